#!/usr/bin/env python3
"""No number in the documents is written by hand: if a program prints other numbers, the check of each document fails.

A script replaces the program. It replaces every 1 in the output of the real program by a 7, or runs the program with another seed. The
outputs of tests and of the report are copied and changed in the same way. The test of ctest that is named with each check proves that
the check passes with the real program.

usage: test_red.py LAGLESS BUILD [unittest options]
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

LAGLESS, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77

TURNS = """#!{python}
import subprocess
import sys
done = subprocess.run([{lagless!r}, *sys.argv[1:]], stdout=subprocess.PIPE)
sys.stdout.buffer.write(done.stdout.replace(b"1", b"7"))
sys.exit(done.returncode)
"""
ANOTHER_SEED = """#!/bin/sh
command=$1
shift
exec '{lagless}' "$command" --seed 99 "$@"
"""


PRINTS = """#!{python}
print(POINTS)
"""


def turned(text):
    return text.replace("1", "7")


class Documents(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def instead(self, script):
        program = self.folder / "lagless"
        program.write_text(script.replace("{python}", sys.executable).replace("{lagless!r}", repr(str(LAGLESS)))
                           .replace("{lagless}", str(LAGLESS)))
        program.chmod(0o755)
        return program

    def red(self, *command):
        """The command must end with 1, and not by a crash."""
        done = subprocess.run([str(word) for word in command], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              check=False)
        code, said = done.returncode, done.stdout
        if code == SKIPPED:
            self.skipTest(said)
        self.assertEqual(1, code, said)
        self.assertNotIn("Error", said.replace("AssertionError", "").replace("CMake Error", ""), said)

    def test_table_beside_others(self):
        """The ctest test with the real program is peers_documents."""
        self.red(sys.executable, "-B", "tools/peers", "--lagless", self.instead(TURNS))

    def test_tables_of_motors(self):
        """The ctest test with the real program is cli_motors."""
        self.red(sys.executable, "-B", "tools/motors-docs", "--check", self.instead(TURNS))

    def test_picture_of_the_cold_start(self):
        """The ctest test with the real program is look_docs."""
        python = ROOT / "build/venv/bin/python3"
        python = python if python.exists() else sys.executable
        self.red(python, "-B", "tools/plot/docs.py", self.instead(ANOTHER_SEED), "--check")

    def test_tables_of_accuracy(self):
        """The ctest test with the real program is accuracy_documents."""
        printed = BUILD / "tests/rig"
        for text in printed.glob("test_rig_sensorless_*.txt"):
            (self.folder / text.stem).symlink_to(printed / text.stem)  # the check ignores an output that is older than its program
            (self.folder / text.name).write_text(turned(text.read_text()))
        self.assertTrue(list(self.folder.iterdir()), "no test has printed anything")
        self.red(sys.executable, "-B", "tools/accuracy", "--printed", "--tests", self.folder)

    def test_rows_of_the_report(self):
        """The ctest test with the real program is paper_documents."""
        report = json.loads((BUILD / "paper/report.json").read_text())
        for row in report["rows"]:
            row["ours"] = (row["ours"] or 0.0) + 1.0
        (self.folder / "report.json").write_text(json.dumps(report))
        self.red(sys.executable, "-B", "tools/plot/documents.py", "--check", "--only", "paper.md", self.folder, "docs")

    def test_points_of_the_map(self):
        """The ctest test with the real program is paper_map_of_the_day."""
        accuracy = (ROOT / "docs/accuracy.md").read_text(encoding="utf-8")
        rows = re.findall(r"(?m)^\| ([^|]+) \|", accuracy.partition("begin: the map")[2].partition("<!-- end")[0])
        points = [{"rpm": rpm, "load_nm": 5, "deviation": name, "adaptation": "off", "mean_mrad": 0.123, "sd_mrad": 0.123, "locked": True}
                  for name in rows[1:] for rpm in (-500, 500)]
        self.red(sys.executable, "-B", "tests/report/map_of_the_day.py", self.instead(PRINTS.replace("POINTS", repr(json.dumps(points)))),
                 "docs/accuracy.md", "500", "off")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
