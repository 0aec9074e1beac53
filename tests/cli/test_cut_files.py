"""Files that are cut off or damaged: a clear refusal, no traceback, nothing of it in a result.
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

    def test_the_fields_have_names(self):
        self.assertEqual("run,end,invariant,period,row,injected,reason,excused,from,reproduced,latched,second,calm\n", self.columns)
        self.expect(1, self.merge(self.line), "29 of 30 runs are not done")

    def test_a_violation_without_an_invariant_is_no_result(self):
        """It was counted beyond the end of an array."""
        for line in ("20,2,19,900,0,3,45,0,0,0,0,0,0\n", "20,2,99,900,0,3,45,0,0,0,0,0,0\n"):
            self.expect(2, self.merge(line), ":3: no result of a run")

    def test_an_invariant_without_a_violation_is_no_result(self):
        for end in (1, 3):
            self.expect(2, self.merge(f"20,{end},3,900,0,3,45,0,0,0,0,0,0\n"), ":3: no result of a run")

    def test_fields_beyond_their_tables_are_no_result(self):
        for line in ("30,1,19,900,0,3,45,0,0,0,0,0,0\n", "20,1,19,900,0,9999,45,0,0,0,0,0,0\n", "20,4,19,900,0,3,45,0,0,0,0,0,0\n",
                     "20,1,19,900,0,3,45,0,0,7,0,0,0\n", "20,1,19,900,0,3,45,0,0,0,0,0\n", "-1,1,19,900,0,3,45,0,0,0,0,0,0\n"):
            self.expect(2, self.merge(line), ":3: no result of a run")

    def test_a_head_of_no_or_too_many_runs_is_none(self):
        for runs in ("0", "1000001", "4294967295"):
            self.expect(2, self.merge(self.line, head=self.head.replace("runs 30", f"runs {runs}")), ":1: no campaign")

    def test_the_file_that_was_reported(self):
        shutil.copy(os.path.join(CASES, "merge_overflow.csv"), self.results)
        self.expect(2, lagless("campaign", "merge", self.folder), "campaign.csv:")


@unittest.skipUnless(DRAWS, "numpy is missing")
class Recordings(TestCase):
    """`lagless plot` and `lagless compare` of recordings that are cut off."""

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

    def test_a_value_that_is_cut_off(self):
        text = self.octets("a.csv")
        at = text.index(b"# value current_limit: ")
        self.refuses("cut.csv", text[:at + len(b"# value current_limit: ")], "cut.csv:", "may be cut off")
        self.refuses("cut.csv", text[:at + len(b"# value current_limit")], "may be cut off")

    def test_a_head_that_is_cut_off(self):
        text = self.octets("a.csv")
        for at in (text.index(b"# value"), text.index(b"time[s]"), text.index(b"time[s]") + 12):
            self.refuses("cut.csv", text[:at])

    def test_a_character_that_is_cut_off(self):
        text = self.octets("a.csv").replace(b"# title: a test", "# title: 5 µs".encode())
        at = text.index("µ".encode()) + 1
        self.refuses("cut.csv", text[:at], "no UTF-8")

    def test_a_row_that_is_cut_off(self):
        text = self.octets("a.csv")
        self.refuses("cut.csv", text[:text.rindex(b",")], "values, but")

    def test_a_mat_file_that_is_cut_off(self):
        octets = self.octets("a.mat")
        for at in (40, 127, 128, 140, 300, len(octets) // 3, len(octets) // 2, len(octets) - 200, len(octets) - 8):
            self.refuses("cut.mat", octets[:at])

    def test_a_mat_file_with_one_octet_changed_gives_no_traceback(self):
        octets = self.octets("a.mat")
        for at in range(128, 1500, 197):
            path = os.path.join(self.folder, "cut.mat")
            with open(path, "wb") as file:
                file.write(octets[:at] + bytes([octets[at] ^ 0x15]) + octets[at + 1:])
            self.assertNotIn("Traceback", lagless("compare", path, path).stderr, at)

    def test_the_file_that_was_reported(self):
        with open(os.path.join(CASES, "plot_traceback.csv"), "rb") as file:
            self.refuses("reported.csv", file.read(), "reported.csv:70:", "may be cut off")


if __name__ == "__main__":
    unittest.main(argv=["test_cut_files.py"], verbosity=2)
