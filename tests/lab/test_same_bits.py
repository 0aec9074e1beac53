#!/usr/bin/env python3
"""Tests of tools/same-bits and of the program that it runs: a changed bit is reported with its row.

usage: test_same_bits.py TAP_HASH
"""
import contextlib
import io
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import tool  # noqa: E402

same_bits = tool.load("same-bits")

PROGRAM = pathlib.Path(sys.argv.pop() if len(sys.argv) > 1 else tool.ROOT / "build/host/tests/lab/tap_hash").resolve()
BUILD = PROGRAM.parents[2]


def fnv(words):
    """FNV-1a, 64 bits, over words of 32 bits, lowest octet first."""
    value = 0xCBF29CE484222325
    for word in words:
        for octet in word.to_bytes(4, "little"):
            value = (value ^ octet) * 0x100000001B3 % 2**64
    return f"{value:016x}"


def rows_of(*overrides, scenario="current_mode_locked_shaft"):
    rows, error = same_bits.hashed(PROGRAM, [str(same_bits.SCENARIOS / f"{scenario}.toml"), *overrides])
    if rows is None:
        raise AssertionError(error)
    return rows


class Program(unittest.TestCase):
    def test_a_row_has_the_hash_of_its_values(self):
        rows = rows_of()
        self.assertEqual(rows["fault_reason"], fnv([0] * 4000))
        self.assertEqual(rows["enable"], fnv([1] * 4000))
        # The signal counts the steps, so that its first value is 1.
        self.assertIn(rows["period"], (fnv(range(1, 4001)), fnv(range(4000))))

    def test_every_row_of_signals_requests_and_truth_is_there(self):
        rows = rows_of()
        told = subprocess.run([BUILD / "lagless", "signals", "--json"], capture_output=True, text=True, check=True).stdout
        self.assertLessEqual({row["name"] for row in json.loads(told)["rows"]}, rows.keys())
        self.assertLessEqual({"speed_request", "i_q_request", "true_theta_e", "theta_hat_err"}, rows.keys())

    def test_a_wrong_override_is_reported(self):
        rows, error = same_bits.hashed(PROGRAM, [str(same_bits.SCENARIOS / "load_step.toml"), "no_such_row=1"])
        self.assertIsNone(rows)
        self.assertIn("no_such_row", error)


class Comparing(unittest.TestCase):
    def test_rows_of_both_are_compared_and_those_of_one_side_reported(self):
        record = {"i_a": "1", "i_b": "2", "u_dc": "3"}
        for other, verdict in ((dict(record), (True, "same, 3 rows")), ({**record, "i_b": "4"}, (False, "DIFFERENT in 1 of 3 rows: i_b")),
                               ({"i_a": "1", "i_b": "2", "i_c": "9"}, (True, "same, 2 rows; new: i_c; gone: u_dc"))):
            self.assertEqual(same_bits.compare(record, other), verdict)
        self.assertFalse(same_bits.compare(record, {"x": "1"})[0])


class Tool(unittest.TestCase):
    """The command for one run, with a separate record."""

    RUN = "current_mode_locked_shaft"

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(setattr, same_bits, "RECORD", same_bits.RECORD)
        same_bits.RECORD = pathlib.Path(folder.name) / "record.json"

    def told(self, *arguments):
        out = io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            code = same_bits.main(["--build", str(BUILD), *arguments, self.RUN])
        return code, out.getvalue()

    def test_what_was_accepted_is_the_same_and_a_change_of_it_is_found(self):
        self.assertEqual(self.told("--accept")[0], 0)
        code, text = self.told()
        self.assertEqual(code, 0, text)
        self.assertRegex(text, self.RUN + r" +same, \d+ rows\n")
        records = json.loads(same_bits.RECORD.read_text())
        rows = records[same_bits.estimator_of(BUILD)][self.RUN]
        rows["i_q"] = "0" * 16
        same_bits.write(records)
        code, text = self.told()
        self.assertEqual(code, 1, text)
        self.assertRegex(text, r"DIFFERENT in 1 of \d+ rows: i_q\n")
        self.assertEqual(self.told("no_such_run")[0], 2)


class Record(unittest.TestCase):
    def test_the_record_in_the_tree_has_every_run(self):
        records = json.loads(same_bits.RECORD.read_text())
        for estimator, of_runs in records.items():
            self.assertEqual(set(of_runs), set(same_bits.runs()), estimator)
            self.assertEqual(len({json.dumps(rows, sort_keys=True) for rows in of_runs.values()}), len(of_runs), "two runs alike")


if __name__ == "__main__":
    unittest.main()
