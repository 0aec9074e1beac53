#!/usr/bin/env python3
"""Tests of demo.py. Without matplotlib those that draw are skipped, and said to be."""
import importlib.util
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().with_name("demo.py")
DRAWS = importlib.util.find_spec("matplotlib") is not None

NAMES = ["time[s]", "speed_ref[r/min]", "speed[r/min]", "i_d[A]", "i_q[A]", "i_a[A]", "theta_err[mrad]"]
MORE = ["i_d_ref[A]", "i_q_ref[A]", "torque[N m]", "load_torque[N m]", "duty_a[-]", "duty_b[-]", "duty_c[-]", "state[-]"]


def recording(names, count=3):
    rows = [",".join(names)]
    rows += [",".join([repr(1e-4 * k)] + [repr(float(k % 7 + j)) for j in range(1, len(names))]) for k in range(count)]
    return "\n".join(rows) + "\n"


class Demo(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_plot_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.csv = self.folder / "demo.csv"
        self.png = self.folder / "out" / "demo.png"

    def run_script(self, text, *arguments, python=()):
        if text is not None:
            self.csv.write_text(text)
        return subprocess.run([sys.executable, "-B", *python, SCRIPT, self.csv, self.png, *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)

    def assert_refused(self, text, *words):
        run = self.run_script(text)
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)
        self.assertFalse(self.png.exists())

    def test_missing_file_is_refused(self):
        self.assert_refused(None, "demo.csv", "No such file")

    def test_empty_file_is_refused(self):
        self.assert_refused("", "demo.csv: empty")

    def test_header_alone_is_refused(self):
        self.assert_refused(recording(NAMES, 0), "0 rows")

    def test_single_row_is_refused(self):
        self.assert_refused(recording(NAMES, 1), "1 rows")

    def test_missing_columns_are_named(self):
        self.assert_refused(recording([n for n in NAMES if n not in ("i_q[A]", "speed[r/min]")]), "speed[r/min], i_q[A]")

    def test_wrong_unit_is_refused(self):
        self.assert_refused(recording(NAMES).replace("theta_err[mrad]", "theta_err[rad]"), ":1:", "theta_err[mrad]")

    def test_double_column_is_refused(self):
        self.assert_refused(recording(NAMES + ["i_q[A]"]), "`i_q`", "twice")

    def test_short_row_is_refused_with_its_line(self):
        self.assert_refused(recording(NAMES) + "0.5,1\n", ":5:", "2 values")

    def test_text_is_refused_with_its_line(self):
        self.assert_refused(recording(NAMES).replace("0.0002,", "0.0002x,"), ":4:", "time", "0.0002x")

    def test_infinite_value_is_refused_with_its_line(self):
        self.assert_refused(recording(NAMES) + "0.5,inf,0,0,0,0,0\n", ":5:", "speed_ref")

    def test_time_that_stands_still_is_refused(self):
        self.assert_refused(recording(NAMES).replace("0.0002,", "0.0001,"), "time does not increase")

    def test_name_without_png_is_refused(self):
        self.png = self.folder / "demo.jpg"
        self.assertEqual(self.run_script(recording(NAMES)).returncode, 2)

    def test_missing_matplotlib_is_said(self):
        run = self.run_script(recording(NAMES), python=("-I", "-S"))  # no packages at all
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn("matplotlib is missing", run.stderr)

    def assert_drawn(self):
        head = self.png.read_bytes()[:24]
        self.assertEqual(head[:8], b"\x89PNG\r\n\x1a\n")
        width, height = struct.unpack(">II", head[16:24])
        self.assertEqual(width, 1800)
        self.assertGreater(height, 1000)
        svg = self.png.with_suffix(".svg").read_text()
        self.assertIn("</svg>", svg)
        return height

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_needed_columns_are_enough_and_more_columns_give_more_panels(self):
        self.assertEqual(self.run_script(recording(NAMES)).returncode, 0)
        few = self.assert_drawn()
        run = self.run_script(recording(NAMES + MORE, 20000), "--title", "any conditions, $5 and 100 %, " * 6)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertGreater(self.assert_drawn(), few)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_same_recording_gives_the_same_octets(self):
        self.run_script(recording(NAMES))
        first = self.png.read_bytes(), self.png.with_suffix(".svg").read_bytes()
        self.run_script(recording(NAMES))
        self.assertEqual((self.png.read_bytes(), self.png.with_suffix(".svg").read_bytes()), first)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_folder_that_cannot_be_made_is_said(self):
        self.png = self.csv / "below" / "demo.png"
        run = self.run_script(recording(NAMES))
        self.assertEqual(run.returncode, 3)
        self.assertIn("demo.py: ", run.stderr)

    def test_outline_keeps_the_peaks(self):
        sys.path.insert(0, str(SCRIPT.parent))
        import demo
        values = [0.0] * 30000
        values[12345], values[777] = 9.0, -9.0
        time, kept = demo.outline(list(range(30000)), values)
        self.assertLessEqual(len(time), 4002)
        self.assertEqual((kept[time.index(12345)], kept[time.index(777)]), (9.0, -9.0))
        self.assertEqual((time[0], time[-1]), (0, 29999))
        self.assertEqual(time, sorted(set(time)))


if __name__ == "__main__":
    unittest.main()
