#!/usr/bin/env python3
"""Checks every row of a figure in a report that `lagless paper` has made: its verdict, and, if a number is known, the number from the
paper, docs/theory.md or algebra. A row that is not in the table below fails, and so does an entry of the table without a row.

usage: test_paper_rows.py FIGURE REPORT [LAGLESS]    with LAGLESS the figure is measured first, and its report is written to REPORT
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import unittest

FIGURE, REPORT = sys.argv[1], pathlib.Path(sys.argv[2])
SAME, KIND, NOT, HOLDS = "reproduced", "reproduced in kind", "not reproduced", "holds"


def both(name, verdict, number, tolerance, more=0.0):
    """`more` is the additional tolerance for the real inverter and sensors: 1.5 mrad at rated load up to 4 mrad without load, at speeds up
    to 1500 r/min (docs/theory.md, 21)."""
    return (name + ".real", verdict, number, tolerance + more), (name + ".ideal", verdict, number, tolerance)


# Row, verdict, number [unit of the row], tolerance; None: no number is known.
EXPECTED = (
    # tanh(x/2)/x at 0 is 1/2; the sign function has 1/(10 mA).
    ("fig04.sigmoid.formula", SAME, 0.5, 1e-9),
    ("fig04.sign.formula", KIND, 100.0, 1e-9),

    # |x| of one axis goes from 0 to f^-1(78 V/200 V) = 0.82 A, so that k_f = (1 - x^2/12)/2 goes from 0.5 down to 0.474. By the describing
    # function its mean is 0.486 and its SD 0.67/(24 sqrt 8) = 0.0099; the next term of the series reduces the deviation by 10 %.
    ("fig05.sigmoid.real", SAME, 0.487, 0.003), ("fig05.sigmoid.ideal", SAME, 0.487, 0.003),
    *both("fig05.sigmoid_spread", KIND, 0.0203, 0.002),
    *both("fig05.sign", KIND, None, 0.0),
    *both("fig05.sign_spread", KIND, None, 0.0),

    # The smallest gain is where k_p dominates: 20 log(40.3/25.9), with the digits of docs/theory.md, 7.
    ("fig08.b100_falling.formula", SAME, 0.0, 0.0), ("fig08.b100_lower.formula", KIND, 3.84, 0.05),
    ("fig08.b200_falling.formula", SAME, 0.0, 0.0), ("fig08.b200_lower.formula", KIND, 3.84, 0.05),

    # A switch that acts once per sample is delayed by at most half the angle of a sample, 31.4 mrad.
    *both("fig10.mean", KIND, 0.0, 31.4),
    *both("fig10.ripple", KIND, None, 0.0),

    # docs/theory.md, 4; (14) as printed with the power-weighted k_f leaves 35.5 mrad.
    *both("fig11.ks162", SAME, -80.0, 3.0),
    *both("fig11.ks200", KIND, -54.1, 1.0, 1.5),
    *both("fig11.theory", SAME, 0.0, 1.0, 3.0),
    *both("fig11.printed", NOT, 35.5, 1.5, 1.5),

    # Both values are for 4 A: at equal torque i_q is larger by 4 A (1/cos 0.08 - 1), and i_d is 4 A tan 0.08. The drift of the speed in the
    # window makes less than 3 mA, and the additional 1 mrad of the real drive in `off` is 4 mA. Equation (14) gives omega_e T_s/2 = 31.4
    # mrad too much, and also 1/R - 1 = 5 % of 117 mrad; in the real drive the 0.02 ohm of the devices add to R, which reduces this by 2 %.
    *both("fig12.off", SAME, -80.0, 3.0, 1.0),
    *both("fig12.exact", SAME, 0.0, 1.0, 3.0),
    *both("fig12.printed", NOT, 37.2, 1.5, 3.0),
    *both("fig12.i_q", NOT, 0.0128, 0.003),
    *both("fig12.i_d", SAME, 0.3207, 0.003, 0.004),

    # The values of the paper (docs/theory.md, 19), with 3 %. The last row settles at 0.629 rad, where k_i sin e = (p/J)(T_m cos e + T_f +
    # T_L); its tolerance is the 2 % of a/k_i.
    *both("fig13.steady", SAME, 0.0, 0.5, 3.5),
    *both("fig13.accelerating", SAME, 355.0, 10.0),
    *both("fig13.decelerating", SAME, 450.0, 15.0),
    *both("fig13.decelerating_rated", SAME, 629.0, 12.6),
    *both("fig13.theory", SAME, 1.0, 0.02),
    *both("fig13.equilibrium", SAME, 1.0, 0.02),

    # docs/theory.md, 21, with 5 %.
    *both("fig14.b100_feedforward", SAME, 0.0, 3.0, 1.0),
    *both("fig14.b200_feedforward", SAME, 0.0, 3.0, 1.0),
    *both("fig14.b100_conventional", KIND, -354.7, 10.0),
    *both("fig14.b200_conventional", KIND, -93.2, 4.7),

    *both("fig15.b100_feedforward", SAME, 0.0, 3.0, 1.0),
    *both("fig15.b200_feedforward", SAME, 0.0, 3.0, 1.0),
    *both("fig15.b100_conventional", KIND, -174.8, 8.7),
    *both("fig15.b200_conventional", KIND, -45.0, 2.3),
    # The loss of lock depends on the voltage of the dead time: 3.6 us x 311 V x 10 kHz = 11 V, compared with an EMF of 7.7 V at 100 r/min.
    # With compensation the lock is never lost.
    *both("fig15.compensated", NOT, 0.0, 0.0),
    ("fig15.conventional.real", SAME, 1.0, 0.0),
    ("fig15.feedforward.real", SAME, 0.0, 0.0),
    ("fig15.moderate.real", SAME, 0.0, 0.0),
    # The threshold of docs/theory.md, 21, with its step. A loop that keeps its lock does so at least up to the largest value that was
    # tried.
    ("fig15.b200_wc0_dead_time.real", KIND, 3.25, 0.25),
    ("fig15.b200_wc25_dead_time.real", KIND, 4.0, 0.75),
    ("fig15.b100_wc0_dead_time.real", KIND, 4.0, 0.75),

    # The first four rows count the points at which the SD does not change as claimed; at 100 r/min these are fewer than the 20 and 12 at
    # 1500 r/min. The omega_c of the smallest overshoot is 0.62 of the natural frequency of the conventional loop, with a flat minimum
    # (docs/theory.md, 7); under noise it is up to 1.62 times that frequency.
    ("fig16.speed_sd.real", SAME, 0.0, 0.0),
    ("fig16.position_sd.real", KIND, 10.0, 9.0),
    ("fig16.speed_sd_bandwidth.real", SAME, 0.0, 0.0),
    ("fig16.position_sd_bandwidth.real", KIND, 3.0, 3.0),
    *both("fig16.b100_nl_accelerating", KIND, 25.0, 8.0, 7.5),
    *both("fig16.b200_nl_accelerating", KIND, 50.0, 16.0, 15.0),
    *both("fig16.b100_nl_decelerating", KIND, 25.0, 8.0, 7.5),
    *both("fig16.b200_nl_decelerating", KIND, 50.0, 16.0, 15.0),
    *both("fig16.b100_rated_accelerating", KIND, 25.0, 8.0, 7.5),
    *both("fig16.b200_rated_accelerating", KIND, 50.0, 16.0, 15.0),
    *both("fig16.b100_rated_decelerating", KIND, 25.0, 8.0, 7.5),
    *both("fig16.b200_rated_decelerating", KIND, 50.0, 16.0, 15.0),

    # The limits of docs/theory.md, 21, are 115 +- 6 mrad, at most 105 mrad, and at most 32 mrad.
    *both("fig17.b100_wc0_500", KIND, 115.0, 6.0), *both("fig17.b100_wc0_1500", KIND, 115.0, 6.0),
    *both("fig17.b100_wc25_500", KIND, 98.0, 7.0), *both("fig17.b100_wc25_1500", KIND, 98.0, 7.0),
    *both("fig17.b200_wc50_500", KIND, 28.0, 4.0), *both("fig17.b200_wc50_1500", KIND, 28.0, 4.0),
    *both("fig17.steady", SAME, 0.0, 0.5, 1.0),

    # As fig11 and fig12, at 1490 r/min.
    *both("beyond_speed.lagless", HOLDS, 0.0, 0.5, 1.0),
    *both("beyond_speed.uncompensated", HOLDS, 0.0, 1.0, 1.5),
    *both("beyond_speed.printed", HOLDS, 0.0, 1.5, 3.0),
    *both("beyond_speed.printed_1490", HOLDS, 35.3, 1.5, 3.0),

    # docs/theory.md, 21.
    *both("beyond_bandwidth.conventional", HOLDS, 0.0, 0.5, 3.5),
    *both("beyond_bandwidth.feedforward", HOLDS, 0.0, 2.0, 2.0),
    *both("beyond_bandwidth.torque_feedforward", HOLDS, 0.0, 10.0, 14.0),
    *both("beyond_bandwidth.lost", HOLDS, 0.0, 0.0),

    ("beyond_map.inductance.real", HOLDS, 0.0, 2.0),
    ("beyond_map.no_effect.real", HOLDS, 0.0, 0.3),
    ("beyond_map.learnt.real", HOLDS, 0.0, 2.0),
)


def belongs(name):
    return name.partition(".")[0] == FIGURE


class Rows(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if len(sys.argv) > 3:
            subprocess.run([sys.argv[3], "paper", FIGURE, "--force", "--out", REPORT], check=False, stdout=subprocess.DEVNULL,
                           env={**os.environ, "LAGLESS_PYTHON": "/bin/true"})
        cls.rows = [row for row in json.loads((REPORT / "report.json").read_text(encoding="utf-8"))["rows"] if row["figure"] == FIGURE]

    def test_the_rows_are_those_that_are_expected(self):
        self.assertEqual(sorted(row["id"] for row in self.rows), sorted(name for name, *_ in EXPECTED if belongs(name)))

    def test_each_row_has_its_verdict_and_number(self):
        expected = {name: rest for name, *rest in EXPECTED}
        for row in self.rows:
            verdict, number, tolerance = expected[row["id"]]
            with self.subTest(row["id"]):
                # The mean with the sign function scatters by several mrad around -10 mrad from run to run. The limit of 8 mrad for
                # "reproduced" lies within this scatter, so that the verdict may be "reproduced" if the number of this run is within the
                # limit.
                by_luck = row["id"].startswith("fig10.mean.") and row["verdict"] == SAME
                self.assertTrue(row["verdict"] == verdict or by_luck, row)
                self.assertFalse(row["stopped"], "a drive stopped")
                if number is not None:
                    self.assertLessEqual(abs(row["ours"] - number), tolerance, row)
                self.assertEqual(row["verdict"] in (SAME, HOLDS), row["because"] == "", "only SAME and HOLDS need no reason")
                self.assertTrue(row["claim"] and row["unit"] and row["condition"])

    def test_csv_names_units_and_has_as_many_fields_in_every_line(self):
        files = [REPORT / f"data/{FIGURE}.csv", *(REPORT / "data").glob(FIGURE + "_*.csv")]
        self.assertEqual(len(files), 2 if FIGURE == "fig15" else 1)
        for path, columns, lines in zip(files, (5, 3), (40, 20)):
            text = path.read_text(encoding="utf-8")
            head, *rows = csv.reader(text.splitlines())
            self.assertTrue(len(head) >= columns and len(rows) + 1 >= lines and "nan" not in text, path)
            self.assertTrue(all(name.count("[") == name.count("]") == 1 for name in head), head)
            self.assertEqual({len(head)}, {len(row) for row in rows})


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
