#!/usr/bin/env python3
"""docs/CONTRIBUTING.md names commits as examples. The files named with a commit must exist, and the commit must be in the history of this
tree and have changed them; in a clone without history only the files are checked. CITATION.cff must agree with CMake and the licence.

usage: test_contributing.py [unittest options]
"""
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
RECIPES = ("A protection", "A parameter", "A manoeuvre", "A board", "A motor", "An experiment")
EXAMPLE = re.compile(r"^Example: `(\w+)`: ((?:`[^`]+`[,.]\s*)+)$", re.MULTILINE)


def examples(text):
    """The examples as (commit, its files), in the order of the text."""
    return [(commit, re.findall(r"`([^`]+)`", files)) for commit, files in EXAMPLE.findall(text)]


def git(*words):
    return subprocess.run(["git", "-C", ROOT, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)


def has_history():
    return git("rev-parse", "--is-shallow-repository").stdout.strip() == "false"


class Contributing(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.text = (ROOT / "docs/CONTRIBUTING.md").read_text(encoding="utf-8")

    def test_each_recipe_has_an_example(self):
        parts = dict(part.split("\n", 1) for part in self.text.split("\n## ")[1:])
        for name in RECIPES:
            self.assertTrue(examples(parts[name]), name)
        self.assertEqual(self.text.count("\nExample"), len(examples(self.text)), "an example that cannot be read")

    def test_the_files_of_the_examples_are_there(self):
        for commit, files in examples(self.text):
            for name in files:
                self.assertTrue((ROOT / name).is_file(), f"{commit}: {name}")

    def test_the_commits_are_of_this_history_and_touched_these_files(self):
        for commit, files in examples(self.text) if has_history() else ():
            with self.subTest(commit=commit):
                self.assertEqual(git("merge-base", "--is-ancestor", commit, "HEAD").returncode, 0)
                touched = set(git("show", "--format=", "--name-only", commit).stdout.splitlines())
                for name in files:  # under the present name of the file, or under its name at that time
                    names = git("log", "--follow", "--format=", "--name-only", "--", name).stdout.split()
                    self.assertTrue(touched & {name, *names}, name)


class Citation(unittest.TestCase):
    def test_it_has_the_numbers_of_the_project(self):
        entries = dict(re.findall(r"^(\w[\w-]*): (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE))
        project = re.search(r"^project\((\w+) VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual((entries["title"], entries["version"]), project.groups())
        self.assertIn(entries["license"] + " License", (ROOT / "LICENSE").read_text(encoding="utf-8").splitlines()[0])
        self.assertEqual((entries["cff-version"], entries["type"]), ("1.2.0", "software"))
        self.assertIn("Phase Self-compensation SMO and Feed-forward PLL", (ROOT / "CITATION.cff").read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
