#!/usr/bin/env python3
"""Tests of map.py. Without matplotlib the tests that draw are skipped, with a message."""
import importlib.util
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

from called import called

SCRIPT = pathlib.Path(__file__).resolve().with_name("map.py")
DRAWS = importlib.util.find_spec("matplotlib") is not None
FIRST = {"rpm": -100, "load_nm": 0, "deviation": "nominal", "adaptation": "off", "mean_mrad": -0.5, "sd_mrad": 1.0, "peak_mrad": 3.0,
         "locked": True}


def points(speeds=(100, 300), loads=(0, 5), deviations=("nominal", "psi_f -10 %", "L +20 %")):
    return [{**FIRST, "rpm": direction * speed, "load_nm": load, "deviation": deviation, "mean_mrad": 0.01 * speed * load}
            for deviation in deviations for load in loads for direction in (-1, 1) for speed in speeds]


class Map(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_plot_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.json = self.folder / "map.json"
        self.png = self.folder / "out" / "map.png"

    def run_script(self, what, *arguments):
        if what is not None:
            self.json.write_text(what if isinstance(what, str) else json.dumps(what))
        return called("map", self.json, self.png, *arguments)

    def assert_refused(self, what, *words):
        run = self.run_script(what)
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)
        self.assertFalse(self.png.exists())

    def test_missing_file_is_refused(self):
        self.assert_refused(None, "map.json", "No such file")

    def test_what_is_not_json_is_refused(self):
        self.assert_refused("", "map.json")
        self.assert_refused("[{", "map.json")

    def test_what_is_not_a_list_of_objects_is_refused(self):
        self.assert_refused([], "a list of points")
        self.assert_refused({"points": points()}, "a list of points")
        self.assert_refused([FIRST, 5], "point 2", "object")

    def test_every_key_is_needed(self):
        for key in FIRST:
            self.assert_refused([FIRST, {k: v for k, v in FIRST.items() if k != key}], "point 2", key)

    def test_value_of_the_wrong_kind_is_refused(self):
        for key, value in (("rpm", "100"), ("mean_mrad", True), ("sd_mrad", None), ("peak_mrad", float("inf")),
                           ("load_nm", float("nan")), ("locked", 1), ("deviation", 3), ("adaptation", None), ("theory_mrad", "x")):
            self.assert_refused([{**FIRST, key: value}], "point 1", key)

    def test_point_that_is_there_twice_is_refused(self):
        self.assert_refused([FIRST, FIRST], "point 2", "nominal at -100 r/min, 0 N m, adaptation off", "twice")

    def test_name_without_png_is_refused(self):
        self.png = self.folder / "map.jpg"
        self.assertEqual(self.run_script(points()).returncode, 2)

    def test_missing_matplotlib_is_reported(self):
        self.json.write_text(json.dumps(points()))
        run = subprocess.run([sys.executable, "-B", "-I", "-S", SCRIPT, self.json, self.png], stderr=subprocess.PIPE, text=True,
                             check=False)  # a Python without any packages
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn("matplotlib is missing", run.stderr)

    def assert_drawn(self):
        head = self.png.read_bytes()[:24]
        self.assertEqual(head[:8], b"\x89PNG\r\n\x1a\n")
        self.assertIn("</svg>", self.png.with_suffix(".svg").read_text())
        return struct.unpack(">II", head[16:24])

    def draw(self, what, *arguments):
        run = self.run_script(what, *arguments)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return self.assert_drawn()

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_more_speeds_are_wider_and_more_deviations_higher(self):
        width, height = self.draw(points((100, 200, 300, 400)))
        self.assertGreater(self.draw(points((100, 200, 300, 400, 500)))[0], width)
        on = [{**point, "adaptation": "on"} for point in points((100, 200, 300, 400))]
        self.assertGreater(self.draw(points((100, 200, 300, 400)) + on)[1], height)
        self.assertGreater(self.draw(points((100, 200, 300, 400), (0, 5), "abcd"), "--title", "any, $5 and 100 %, " * 20)[1],
                           height)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_titles_of_neighbours_have_room_with_one_speed(self):
        """A character of 9 points is 0.06 inches wide on average; the picture has 200 dots per inch."""
        width, _ = self.draw(points((300,), (2.09576, 4.5, 6.98586)))
        self.assertGreater(width, 3 * len("2.096 N m, adaptation off: speed [r/min]") * 0.06 * 200)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_one_point_lost_points_and_huge_errors_are_drawn(self):
        self.draw([FIRST])
        self.draw([{**FIRST, "mean_mrad": -3000.0, "sd_mrad": 1800.0, "locked": False, "theory_mrad": 16.4}])
        self.draw([{**FIRST, "mean_mrad": 0.0, "theory_mrad": None}])

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_same_points_give_the_same_octets_and_a_changed_number_others(self):
        def octets(what):
            self.draw(what)
            return self.png.read_bytes(), self.png.with_suffix(".svg").read_bytes()

        first = octets([FIRST])
        self.assertEqual(octets([FIRST]), first)
        for key, value in (("mean_mrad", -0.6), ("sd_mrad", 1.5), ("locked", False), ("theory_mrad", 2.0)):
            self.assertNotEqual(octets([{**FIRST, key: value}]), first, key)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_a_folder_that_cannot_be_made_is_reported(self):
        self.png = self.json / "below" / "map.png"
        run = self.run_script(points())
        self.assertEqual(run.returncode, 3)
        self.assertIn("map.py: ", run.stderr)

    def test_numbers_have_three_digits_and_shades_grow_with_the_magnitude(self):
        import map as script
        minus = "\N{MINUS SIGN}"
        for value, text in ((0.0, "0.00"), (-0.004, "0.00"), (-0.006, minus + "0.01"), (9.99, "9.99"), (9.996, "10.0"),
                            (-78.46, minus + "78.5"), (99.96, "100"), (3141.6, "3142")):
            self.assertEqual(script.digits(value), text)
        self.assertEqual([script.shade(v) for v in (0.0, 0.3, -100.0, 5000.0)], [0.0, 0.0, 1.0, 1.0])
        self.assertEqual(script.shade(-3.0), script.shade(3.0))
        self.assertLess(script.shade(3.0), script.shade(4.0))
        # sRGB grey 0x76 (luminance 0.181) is the darkest with more contrast to black, 0x75 (0.178) the lightest for white
        self.assertEqual([script.ink(*[c / 255] * 3) for c in (255, 0x76, 0x75, 0)],
                         ["#000000", "#000000", "#FFFFFF", "#FFFFFF"])


if __name__ == "__main__":
    unittest.main()
