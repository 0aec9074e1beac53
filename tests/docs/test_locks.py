#!/usr/bin/env python3
"""Every package that a requirements.txt pins is in its lock file with the same version, and each archive in a lock file has its hash, so
that tools/setup installs only what is named there. docs/licences.md lists each of them. The workflow names actions and TI's sources by
commit. The lock file is tools/requirements.lock; for tools/plot, which also runs on older Pythons, it is the one beside its
requirements.txt. A new pin needs a new lock:

    uv pip compile --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
        docs/site/requirements.txt tests/*/requirements.txt -o tools/requirements.lock
"""
import pathlib
import re
import subprocess
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
SHARED = PROJECT / "tools" / "requirements.lock"
FILES = sorted(path for folder in ("docs", "tests", "tools") for path in (PROJECT / folder).glob("*/requirements.txt"))
PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;\\]+)((?:[^\n]*\\\n)*[^\n]*)", re.MULTILINE)


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


class Locks(unittest.TestCase):
    def test_each_pin_has_its_licence_in_the_list(self):
        text = plain((PROJECT / "docs/licences.md").read_text(encoding="utf-8"))
        for path in FILES:
            for name, _, _ in PIN.findall(path.read_text(encoding="utf-8")):
                with self.subTest(name=name):
                    self.assertIn(plain(name), text)

    def test_the_workflow_takes_the_work_of_others_by_commit(self):
        text = (PROJECT / ".github/workflows/check.yml").read_text(encoding="utf-8")
        used = re.findall(r"uses: (\S+)", text)
        self.assertEqual(len(used), 4)
        for action in used:
            self.assertRegex(action, r"^actions/[\w-]+@[0-9a-f]{40}$")
        cloned = re.findall(r"git clone[^\n]*(?:\n[^\n]*){2}", text)
        self.assertEqual(len(cloned), 1)
        self.assertRegex(cloned[0], r"checkout --quiet [0-9a-f]{40}")

    def test_each_pin_is_in_its_lock_and_each_line_has_a_hash(self):
        self.assertEqual(len(FILES), 6)
        for path in FILES:
            beside = path.with_suffix(".lock")
            lock = (beside if beside.exists() else SHARED).read_text(encoding="utf-8")
            locked = [(plain(name), version, rest) for name, version, rest in PIN.findall(lock)]
            for name, version, _ in PIN.findall(path.read_text(encoding="utf-8")):
                with self.subTest(file=path.parent.name, name=name):
                    self.assertIn((plain(name), version), [(n, v) for n, v, _ in locked])
            for name, _, rest in locked:
                with self.subTest(file=path.parent.name, name=name):
                    self.assertRegex(rest, r"--hash=sha256:[0-9a-f]{64}\b")
            lines = [line for line in lock.splitlines() if line.strip() and not line.startswith((" ", "#"))]
            self.assertEqual(len(lines), len(locked), "a line of the lock that pins no version")

    def test_uv_stores_the_modules_that_it_installs_in_compiled_form(self):
        setup = (PROJECT / "tools/setup").read_text(encoding="utf-8")
        install = re.search(r"^venv_install\(\) \{.*?^\}$", setup, re.MULTILINE | re.DOTALL).group()
        with tempfile.TemporaryDirectory() as folder:
            uv = pathlib.Path(folder, "build/venv/bin/uv")
            uv.parent.mkdir(parents=True)
            uv.write_text('#!/bin/sh\necho "$@"\n', encoding="utf-8")
            uv.chmod(0o755)
            done = subprocess.run(["sh", "-euc", f"{install}\nvenv_install tests/fmu/requirements.txt"], cwd=folder,
                                  stdout=subprocess.PIPE, text=True, check=True)
        self.assertIn("--compile-bytecode", done.stdout.split())


if __name__ == "__main__":
    unittest.main()
