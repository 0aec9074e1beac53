#!/usr/bin/env python3
"""Every path, link and function that a document names exists in the tree, and a function exists in the file that is named with it. A second
part proves that the search finds names that do not exist.

usage: test_paths.py DOCUMENT...        paths from the project's root; of a folder all documents are checked. Python 3.9, standard
library
"""
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENTS = []

# A path is in backquotes and begins with a folder or a file of the root; NAME in it stands for any name.
FOLDERS = ("cmake", "docs", "firmware", "hal", "host_sim", "linker", "targetConfigs", "tests", "ti", "tools")
PATH = re.compile(rf"`((?:{'|'.join(FOLDERS)})/[\w./-]*)[ `]")
LINK = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
FUNCTION = re.compile(r"(?<![\w.>])([a-z]\w*_\w+)\(\)")
PLACE = re.compile(r"`([\w./]+\.[ch])`:\s+`(\w+)\(\)`")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


def functions_of_the_tree():
    """All names followed by a bracket in C outside comments, that is functions that are declared, defined or called."""
    found = set()
    for folder in ("firmware", "hal", "host_sim"):
        for path in (ROOT / folder).rglob("*.[ch]"):
            found |= functions_of(path)
    return found


def functions_of(path):
    return set(re.findall(r"\b([a-z]\w*)\s*\(", COMMENT.sub(" ", path.read_text(encoding="utf-8"))))


def missing(text, folder, functions):
    """The names in the text that do not exist in the tree, in the order of the text."""
    lacking = [path for path in PATH.findall(text) if "NAME" not in path and not (ROOT / path).exists()]
    lacking += [link for link in LINK.findall(text) if not (folder / link).exists()]
    lacking += [name + "()" for name in FUNCTION.findall(text) if name not in functions]
    lacking += [f"{path}: {name}()" for path, name in PLACE.findall(text)
                if (ROOT / path).exists() and name not in functions_of(ROOT / path)]
    return lacking


class Paths(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.functions = functions_of_the_tree()

    def test_what_documents_name_exists(self):
        self.assertTrue(DOCUMENTS, "which documents?")
        for path in (path for name in DOCUMENTS for path in (sorted((ROOT / name).glob("*.md")) or [ROOT / name])):
            with self.subTest(document=path.name):
                self.assertEqual(missing(path.read_text(encoding="utf-8"), path.parent, self.functions), [])

    def test_what_does_not_exist_is_found(self):
        text = ("`hal/hal.h`, `hal/nothing.h`, `tools/cost --accept`, `tools/nothing --accept`, [a](docs/board.md), [b](docs/none" ".md#x), "
                "`drive_step()`, drive_nothing(), `make_x(1)`, [c](https://example.org), "
                "`hal/hal.h`: `hal_init()`, `hal/board.h`: `hal_init()`")
        self.assertEqual(missing(text, ROOT, self.functions),
                         ["hal/nothing.h", "tools/nothing", "docs/none" + ".md", "drive_nothing()", "hal/board.h: hal_init()"])


if __name__ == "__main__":
    DOCUMENTS = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    unittest.main(argv=sys.argv[:1])
