#!/usr/bin/env python3
"""Tests of commission.py. Without matplotlib the tests that draw are skipped, with a message."""
import importlib.util
import io
import json
import pathlib
import shutil
import tempfile
import unittest
import unittest.mock

import commission
from called import called

DRAWS = importlib.util.find_spec("matplotlib") is not None
VALUES = {key: None for key in commission.VALUES}
ERRORS = {key: None for key in commission.VALUES}


def data(points=None, **result):
    return {"of": "a <fan>", "plate": {"pole_pairs": 5, "current": 4.24, "speed": 209.44}, "step": "inertia", "what": "",
            "sheet": {"resistance": 1.5}, "step_seconds": {"board": 2.5, "turn": 0, "resistance": 10.02},
            "result": {**VALUES, "reason": None, "seconds": 39.7, "uncertainty": ERRORS, "points": points or {}, **result}}


def staircase(resistance, dead, zone):
    """The points of `resistance` by the law of the page docs/commissioning.md."""
    return [(i, resistance * i + 4 / 3 * dead * commission.lost_share(i, zone)) for i in (0.02, 0.05, 0.1, 1.0, 2.0, 3.0)]


class Curves(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_plot_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_script(self, what, kinds="html"):
        with unittest.mock.patch("sys.stdin", io.StringIO(what if isinstance(what, str) else json.dumps(what))):
            return called("commission", "--out", self.folder, "--format", kinds)

    def test_share_of_the_lost_voltage_is_continuous_and_has_its_ends(self):
        # The zone has the half width 0.1 A. At zero current no voltage is lost, at 2/3 of the half width half of the voltage. At the half
        # width the leg with the whole current leaves its zone: three quarters. At twice this current the other two legs leave it: all.
        for current, share in ((0.0, 0.0), (0.1 * 2 / 3, 0.5), (0.1, 0.75), (0.15, 0.875), (0.2, 1.0), (5.0, 1.0)):
            self.assertAlmostEqual(share, commission.lost_share(current, 0.1), places=9)
            self.assertAlmostEqual(commission.lost_share(current + 1e-9, 0.1), commission.lost_share(current, 0.1), places=6)

    def test_line_through_points_has_their_slope_and_intercept(self):
        if not DRAWS:
            self.skipTest("no numpy")
        slope, intercept = commission.line(*zip(*commission.is_steep(staircase(1.4, 8.0, 0.05))))
        self.assertAlmostEqual(1.4, slope, places=9)
        self.assertAlmostEqual(4 / 3 * 8.0, intercept, places=9)

    def test_wrong_data_are_refused_by_name(self):
        for what, named in (("{", "stdin"), ("[]", "of"), ({**data(), "plate": 3}, "plate"), ({**data(), "result": {"reason": None}}, "resistance")):
            run = self.run_script(what)
            self.assertEqual(2, run.returncode)
            self.assertIn(named, run.stderr)
            self.assertEqual([], list(self.folder.iterdir()))
        self.assertEqual(2, self.run_script(data(), "bmp").returncode)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_page_has_the_values_their_uncertainty_and_those_of_the_plate(self):
        points = {"resistance": staircase(1.4, 8.0, 0.05), "inductance": [(0.5, 6e-3), (-0.5, 7.5e-3)], "swing": [(0, 0.11), (1, 0.112)],
                  "flux": [(600, 66)], "inertia": [(0.8, 1300), (0.0, -100), (-0.4, -800)]}
        run = self.run_script(data(points, resistance=1.4, inertia=6e-4, uncertainty={**ERRORS, "resistance": 0.014}), "html,png,svg")
        self.assertEqual((0, ["commission.html", "commission.png", "commission.svg"]), (run.returncode, sorted(path.name for path in self.folder.iterdir())))
        page = (self.folder / "commission.html").read_text(encoding="utf-8")
        for text in ("Commissioning: a &lt;fan&gt;", "± 0.014", "1.5 (−6.7 %)", ">0.6<", "5 pole pairs", "2000 r/min", "data:image/png", "Commissioned after 39.7 s"):
            self.assertIn(text, page)
        self.assertNotIn(">turn<", page)  # a step that did not run
        self.assertIn("</svg>", (self.folder / "commission.svg").read_text())

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_the_end_of_a_step_is_named_and_its_points_are_drawn(self):
        ended = {**data({"resistance": staircase(1.4, 8.0, 0.05)}, reason="rotor_swings"), "what": "the rotor does not come to rest & swings"}
        self.assertEqual(0, self.run_script(ended).returncode)
        page = (self.folder / "commission.html").read_text(encoding="utf-8")
        self.assertIn("rotor_swings in the step inertia", page)
        self.assertIn("does not come to rest &amp; swings", page)
        self.assertIn("data:image/png", page)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_without_points_the_page_says_so_and_no_picture_is_written(self):
        run = self.run_script(data(), "html,png")
        self.assertEqual((0, ["commission.html"]), (run.returncode, [path.name for path in self.folder.iterdir()]))
        self.assertIn("there is no picture", run.stderr)
        self.assertIn("No step has measured points", (self.folder / "commission.html").read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
