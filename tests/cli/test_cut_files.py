"""Files that are truncated or damaged are refused with a clear message, without a traceback, and no part of them reaches a result.

usage: test_cut_files.py LAGLESS FOLDER CASES"""

import importlib.util
import os
import shutil
import sys
import unittest

from command_line import TestCase, lagless

CASES = sys.argv[3]
DRAWS = importlib.util.find_spec("numpy") is not None


class Campaign(TestCase):
    """`lagless campaign merge` of damaged results."""

    def setUp(self):
        super().setUp()
        self.results = os.path.join(self.folder, "campaign.csv")
        lagless("campaign", "--runs", "30", "--seconds", "0.1", "--seed", "77", "--shard", "1/30", "--out", self.folder)
        with open(self.results, encoding="utf-8") as file:
            self.head, self.columns, self.line = file.read().splitlines(keepends=True)

    def merge(self, *lines, head=None):
        with open(self.results, "w", encoding="utf-8") as file:
            file.write((head or self.head) + self.columns + "".join(lines))
        return lagless("campaign", "merge", self.folder)

    def test_what_is_not_a_result_is_refused(self):
        self.assertEqual(
            "run,end,invariant,period,row,injected,reason,excused,from,reproduced,latched,second,calm,tracked,"
            "inside,share\n", self.columns)
        self.expect(1, self.merge(self.line), "29 of 30 runs are not done")
        none = self.line.split(",")[2]  # stands for a run that violates no invariant
        for start, end in (
                # A violation without an invariant, which must not be counted beyond the end of an array, and an invariant without a
                # violation.
                (f"20,2,{none}", "3,45,0,0,0,0,0,0,0,0,0"), ("20,2,99", "3,45,0,0,0,0,0,0,0,0,0"), ("20,1,3", "3,45,0,0,0,0,0,0,0,0,0"), ("20,3,3", "3,45,0,0,0,0,0,0,0,0,0"),
                # Indices beyond the end of their tables, and too few fields.
                (f"30,1,{none}", "3,45,0,0,0,0,0,0,0,0,0"), (f"20,1,{none}", "9999,45,0,0,0,0,0,0,0,0,0"), (f"20,4,{none}", "3,45,0,0,0,0,0,0,0,0,0"), (f"20,1,{none}", "3,45,0,0,7,0,0,0,0,0,0"),
                (f"20,1,{none}", "3,45,0,0,0,0,0,0,0,0"), (f"20,1,{none}", "3,45,0,0,0,0,0,0,5,6,0"), (f"-1,1,{none}", "3,45,0,0,0,0,0,0,0,0,0")):
            self.expect(2, self.merge(f"{start},900,0,{end}\n"), ":3: no result of a run")
        self.columns = "run,end,invariant,period\n"  # of an earlier program
        self.expect(2, self.merge(self.line), "campaign.csv:2: the columns are not those of this program")
        self.columns = ""  # without the names a line of a run follows the first one
        self.expect(1, self.merge(self.line), "29 of 30 runs are not done")
        for runs in ("0", "1000001", "4294967295"):
            self.expect(2, self.merge(self.line, head=self.head.replace("runs 30", f"runs {runs}")), ":1: no campaign")
        shutil.copy(os.path.join(CASES, "merge_overflow.csv"), self.results)  # the file from the report of this defect
        self.expect(2, lagless("campaign", "merge", self.folder), "campaign.csv:")


@unittest.skipUnless(DRAWS, "numpy is missing")
class Recordings(TestCase):
    """`lagless plot` and `lagless compare` with truncated recordings."""

    def setUp(self):
        super().setUp()
        lagless("run", self.scenario(duration="20 ms"), "--out", self.folder, "--format", "csv,mat")

    def octets(self, name):
        with open(os.path.join(self.folder, name), "rb") as file:
            return file.read()

    def refuses(self, name, octets, *fragments):
        path = os.path.join(self.folder, name)
        with open(path, "wb") as file:
            file.write(octets)
        for command in (["plot", path, "--out", os.path.join(self.folder, "out")], ["compare", path, path]):
            done = lagless(*command)
            self.expect(2, done, path, *fragments)
            self.assertEqual(1, done.stderr.count("\n"), done.stderr)

    def test_a_csv_that_is_cut_off(self):
        text = self.octets("a.csv")
        value, head = text.index(b"# value current_limit: "), text.index(b"time[s]")
        micro = text.replace(b"# title: a test", "# title: 5 µs".encode())
        for octets, *fragments in ((text[:value + len(b"# value current_limit: ")], "cut.csv:", "may be cut off"),
                                   (text[:value + len(b"# value current_limit")], "may be cut off"),
                                   (text[:text.index(b"# value")],), (text[:head],), (text[:head + 12],),
                                   (micro[:micro.index("µ".encode()) + 1], "no UTF-8"), (text[:text.rindex(b",")], "values, but")):
            self.refuses("cut.csv", octets, *fragments)
        with open(os.path.join(CASES, "plot_traceback.csv"), "rb") as file:
            self.refuses("reported.csv", file.read(), "reported.csv:70:", "may be cut off")

if __name__ == "__main__":
    unittest.main(argv=["test_cut_files.py"], verbosity=2)
