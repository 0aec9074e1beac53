#!/usr/bin/env python3
"""Tests of figures.py and pictures.py on a small synthetic report. Without matplotlib all are skipped. A share of the tests that draw every
figure runs, chosen by the date: LAGLESS_GRID_SEED (the date, UTC, as YYYYMMDD), LAGLESS_GRID_SHARE (1: all figures)."""
import importlib.util
import math
import os
import pathlib
import random
import re
import shutil
import struct
import sys
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
DRAWS = importlib.util.find_spec("matplotlib") is not None
if DRAWS:
    sys.path.insert(0, str(HERE))
    import numpy

    import figures
    import pictures
    import style

LOOPS = {100: (0, 12, 25, 40), 200: (0, 25, 50, 81)}
TRACES = {  # runs, quantities, additional columns
    "fig05": (["sign", "sigmoid"], ["k_f_alpha[1/A]"], []),
    "fig10": (["sign", "sigmoid"], ["speed[r/min]", "speed_hat[r/min]", "theta[rad]", "theta_hat[rad]",
                                    "theta_err[mrad]"],
              ["speed_ref[r/min]"]),
    "fig11": (["ks162", "ks200"], ["speed[r/min]", "speed_hat[r/min]", "theta[rad]", "theta_hat[rad]",
                                   "theta_err[mrad]",
                                   "theory_err[mrad]"], ["speed_ref[r/min]"]),
    "fig12": (["exact", "printed"], ["speed[r/min]", "theta_err[mrad]", "i_q[A]", "true_i_d[A]"], []),
    "fig13": (["b100_wc0_nl", "b100_wc0_rated"],
              ["speed[r/min]", "speed_hat[r/min]", "theta_err[mrad]", "theory_err[mrad]"], ["speed_ref[r/min]"]),
    "fig14": ([f"b{b}_wc{c}_nl" for b in LOOPS for c in LOOPS[b]],
              ["speed[r/min]", "speed_hat[r/min]", "theta_err[mrad]"],
              ["speed_ref[r/min]"]),
    "fig15": ([f"b{b}_wc{c}_rated" for b in LOOPS for c in LOOPS[b]]
              + [f"{loop}_uncompensated" for loop in ("b200_wc0", "b200_wc25", "b100_wc0")],
              ["speed[r/min]", "speed_hat[r/min]", "theta_err[mrad]"], ["speed_ref[r/min]"]),
    "fig17": ([f"{loop}_{speed}" for loop in ("b100_wc0", "b100_wc25", "b200_wc50") for speed in (500, 1500)],
              ["speed[r/min]", "speed_hat[r/min]", "theta_err[mrad]", "i_q[A]"],
              ["speed_ref_500[r/min]", "speed_ref_1500[r/min]"]),
}
TABLES = ("fig16", "beyond_speed", "beyond_bandwidth", "beyond_map")


def traces(figure, count=1200, step=1e-3):
    """Header and lines; one run is shorter, another turns round."""
    runs, quantities, more = TRACES[figure]
    names = ["time[s]", *more] + [f"{run}_{flavour}_{quantity}" for run in runs for flavour in ("ideal", "real")
                                  if flavour == "real" or "uncompensated" not in run for quantity in quantities]
    lines = []
    for k in range(count):
        line = [f"{step * k:.4f}"]
        for n, name in enumerate(names[1:]):
            value = 3.0 * math.sin(0.05 * k + n)
            if name.startswith("b200_wc0_uncompensated") and "theta_err" in name:
                value = 3141.0 * math.sin(0.1 * k)
            elif "k_f_alpha" in name:
                value = 1.2 + math.sin(0.05 * k + n)
            line.append("" if n == len(names) - 2 and k > 0.9 * count else f"{value:.5g}")
        lines.append(",".join(line))
    return "\n".join([",".join(names), *lines]) + "\n"


def table(head, lines):
    return "\n".join([head] + [",".join(map(str, line)) for line in lines]) + "\n"


def tables():
    flavours, loads = ("ideal", "real"), (0, 5)
    yield "fig04", table("x[A],sign[-],sigmoid[-],k_f_sign[1/A],k_f_sigmoid[1/A]",
                         [(x, (x > 0) - (x < 0), math.tanh(x / 2), 1 / abs(x) if x else "",
                           math.tanh(x / 2) / x if x else 0.5)
                          for x in range(-10, 11)])
    yield "fig08", table("omega[rad/s]," + ",".join(f"b{b}_wc{c}_gain[dB],b{b}_wc{c}_phase[deg]" for b in LOOPS
                                                   for c in LOOPS[b]),
                         [(10 ** (k / 10), *[60 - k + n for n in range(16)]) for k in range(-10, 41)])
    yield "fig15_dead_time", table("run[text],dead_time[us],lost[-]",
                                   [(run, t, int(t > 3.3)) for run in ("b200_wc0", "b100_wc0")
                                                                       for t in (2.5, 3.25, 3.5)])
    yield "fig16", table("flavour[text],bandwidth[rad/s],omega_c[rad/s],load[N m],lost[-],sd_100[mrad],sd_1500[mrad],"
                         "speed_sd_100[r/min],speed_sd_1500[r/min],overshoot_accelerating[mrad],"
                         "overshoot_decelerating[mrad],speed_overshoot_accelerating[r/min],"
                         "speed_overshoot_decelerating[r/min],steady_accelerating[mrad]",
                         [(f, b, c, load, 0, *[b + c + load + n for n in range(9)]) for f in flavours for b in LOOPS
                          for c in LOOPS[b] for load in loads])
    yield "beyond_speed", table("flavour[text],variant[text],load[N m],speed[r/min],mean[mrad],sd[mrad],peak[mrad],"
                                "lost[-]",
                                [(f, v, load, n, n / 30, 2, 9, int(n == 100)) for f in flavours
                                 for v in ("uncompensated", "printed", "lagless") for load in loads
                                 for n in (100, 500, 1490)])
    yield "beyond_bandwidth", table("flavour[text],variant[text],bandwidth[rad/s],omega_c[rad/s],load[N m],"
                                    "steady_accelerating[mrad],peak_accelerating[mrad],peak_decelerating[mrad],"
                                    "sd_100[mrad],lost[-]",
                                    [(f, v, b, b / 4, load, *(("", "", "", "", 1) if b == 50
                                                              else (-300 / b, 9, 9, 2, 0)))
                                     for f in flavours for v in ("conventional", "feedforward", "torque_feedforward")
                                     for b in (50, 100, 400) for load in loads])
    yield "beyond_map", table("deviation[text],adaptation[text],load[N m],speed[r/min],mean[mrad],sd[mrad],peak[mrad],theory[mrad],"
                              "lost[-]",
                              [(d, on, load, n, n / 100, 1, 3, "", int(d == "R -50 %" and n < 0))
                               for d in ("nominal", "R -50 %") for on in ("off", "on")
                               for load in loads for n in (-500, -100, 100, 500)])


def manifest():
    ids = ["fig04", "fig08", *TRACES, *TABLES]
    return {"flavours": {"real": "with error"}, "rows": [], "figures": [
        {"id": name, "title": f"of k_f, {name}, $5", "paper": f"Fig. {int(name[3:])}" if name[:3] == "fig" else None,
         "csv": f"data/{name}.csv", "events": [{"time": 0.3, "text": "on"}, {"time": 0.9, "text": "off"}],
         "runs": [{"name": run, "flavour": "real", "lost": run == "b200_wc0_uncompensated",
                   "condition": "100 % noise 10 mA, J 0.06 kg m^2; speed PI 0.5, 2.5, 10 A"}
                  for run in TRACES.get(name, [[]])[0]]} for name in ids]}


@unittest.skipUnless(DRAWS, "no matplotlib")
class Reading(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_plot_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.csv = self.folder / "fig13.csv"

    def read(self, text):
        self.csv.write_text(text)
        return figures.Data.read(self.csv)

    def assert_refused(self, text, *words):
        with self.assertRaises(figures.InputError) as caught:
            figures.Data.read(self.csv) if text is None else self.read(text)
        for word in ("fig13.csv", *words):
            self.assertIn(word, str(caught.exception))

    def test_missing_and_empty_files_are_refused(self):
        self.assert_refused(None, "No such file")
        self.assert_refused("", "empty")
        self.assert_refused("time[s],a[A]\n", "no rows")

    def test_column_without_unit_or_there_twice_is_refused(self):
        self.assert_refused("time,a[A]\n1,2\n", ":1:", "`time`", "unit")
        self.assert_refused("a[A],a[A]\n1,2\n", ":1:", "`a`", "twice")

    def test_short_and_long_rows_are_refused_with_their_line(self):
        self.assert_refused("time[s],a[A]\n1,2\n3\n", ":3:", "1 values, but 2 columns")
        self.assert_refused("time[s],a[A]\n1,2,3\n4,5,6\n", ":2:", "3 values")

    def test_text_and_infinity_among_numbers_are_refused_with_their_line(self):
        for word in ("x", "inf", "1e999", "#"):
            self.assert_refused(f"time[s],a[A]\n1,2\n3,{word}\n", ":3:", "a:", f"`{word}`")
            self.assert_refused(f"run[text],a[A]\nb,2\nc,{word}\n", ":3:", "a:", f"`{word}`")

    def test_constant_time_is_refused(self):
        self.assert_refused("time[s],a[A]\n1,2\n1,3\n", "time does not increase")

    def test_empty_cells_are_no_numbers_wherever_they_are(self):
        data = self.read("a[A],b[A],c[A],d[A]\n,,,4\n1,,,\n")
        self.assertIsNotNone(figures.quick(self.csv, 4))
        numpy.testing.assert_array_equal([data[name] for name in "abcd"],
                                         [[math.nan, 1], [math.nan] * 2, [math.nan] * 2, [4, math.nan]])
        data = self.read('run[text],a[A]\n"x, y",\n,2\n')
        self.assertEqual(data["run"], ["x, y", ""])
        numpy.testing.assert_array_equal(data["a"], [math.nan, 2])

    def test_speed_error_is_estimated_minus_true(self):
        data = self.read("time[s],a_real_speed_hat[r/min],a_real_speed[r/min]\n0,7,5\n1,3,4\n")
        numpy.testing.assert_array_equal(data["a_real_speed_err"], [2, -1])
        self.assertEqual(data.units["a_real_speed_err"], "r/min")

    def test_missing_column_and_wrong_unit_are_named(self):
        figure = manifest()["figures"][[f["id"] for f in manifest()["figures"]].index("fig13")]
        good = traces("fig13", 20)
        figures.layouts(figure, self.read(good))
        for column in ("b100_wc0_rated_real_theory_err[mrad]", "speed_ref[r/min]", "time[s]"):
            name, unit = column[:-1].split("[")
            with self.assertRaisesRegex(figures.InputError, f"fig13.csv: column `{name}` is missing"):
                figures.layouts(figure, self.read(good.replace(column, f"other[{unit}]")))
            wrong = re.escape(f"fig13.csv:1: column `{name}`: expected {column}")
            with self.assertRaisesRegex(figures.InputError, wrong):
                figures.layouts(figure, self.read(good.replace(column, f"{name}[kV]")))


@unittest.skipUnless(DRAWS, "no matplotlib")
class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_plot_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "data").mkdir()
        for name, text in [*tables(), *((name, traces(name)) for name in TRACES)]:
            (cls.folder / "data" / f"{name}.csv").write_text(text)
        cls.manifest, cls.kept = manifest(), {}
        cls.figures = {figure["id"]: figure for figure in cls.manifest["figures"]}

    def data(self, name):
        return figures.Data.read(self.folder / self.figures[name]["csv"])

    def draw(self, name, data=None):
        data = data or self.data(name)
        pictures.draw(self.figures[name], figures.layouts(self.figures[name], data), data, self.folder / "out",
                      self.manifest)
        return [(self.folder / "out" / f"{name}.{kind}").read_bytes() for kind in ("png", "svg")]

    def of_the_day(self):
        """Two of the figures. Making the report of the paper shows that each figure can be drawn."""
        if os.environ.get("LAGLESS_GRID_SHARE") == "1":
            return list(self.figures)
        seed = os.environ.get("LAGLESS_GRID_SEED") or time.strftime("%Y%m%d", time.gmtime())
        return random.Random(f"figures {seed}").sample(list(self.figures), 2)

    def once(self, name):
        """The unchanged report, drawn once for all tests."""
        if name not in self.kept:
            self.kept[name] = self.draw(name)
        return self.kept[name]

    def test_every_figure_is_drawn(self):
        for name in self.of_the_day():
            with self.subTest(name):
                png, svg = self.once(name)
                width, height = struct.unpack(">II", png[16:24])
                self.assertEqual((png[:8], width), (b"\x89PNG\r\n\x1a\n", 1800))
                self.assertGreater(height, 600)
                self.assertIn(b"</svg>", svg)
                self.assertFalse(b"<image" in svg, "an SVG of paths")
                self.assertLess(len(svg), 1_000_000)

    def test_layouts_name_columns_that_exist_in_the_unit_of_their_axis(self):
        for name, figure in self.figures.items():
            data = self.data(name)
            found = figures.layouts(figure, data)
            self.assertEqual(bool(found), name not in TABLES, name)
            self.assertEqual(len({layout.id for layout in found}), len(found))
            for layout in found:
                self.assertTrue(layout.xlabel.endswith(f"[{data.units[layout.x]}]"))
                for panel in layout.panels:
                    self.assertTrue(panel.traces)
                    for trace in panel.traces:
                        self.assertTrue(panel.ylabel.endswith(f"[{data.units[trace.column]}]"),
                                        (panel.ylabel, trace.column))
                        self.assertEqual(trace.dashed, "ref" in trace.column or "theory" in trace.column)
                        self.assertNotIn("_ideal_", trace.column)

    def test_layouts_show_every_run_and_say_which_is_lost(self):
        for name in ("fig13", "fig14", "fig15", "fig17"):
            shown = {trace.column for layout in figures.layouts(self.figures[name], self.data(name))
                     for panel in layout.panels for trace in panel.traces}
            for run in TRACES[name][0]:
                self.assertIn(f"{run}_real_theta_err", shown)
        labels = {trace.label for panel in figures.layouts(self.figures["fig15"], self.data("fig15"))[2].panels
                  for trace in panel.traces}
        self.assertEqual([label for label in labels if label.endswith(", lost")], ["200 rad/s, conventional, lost"])

    def test_same_data_give_the_same_octets_and_other_data_others(self):
        for name, column, row in (("fig12", "exact_real_theta_err", 700), ("beyond_map", "mean", 3)):
            first = self.once(name)
            self.assertEqual(self.draw(name), first)
            data = self.data(name)
            data[column][row] += 40.0
            changed = self.draw(name, data)
            self.assertNotEqual(changed[0], first[0], name)
            self.assertNotEqual(changed[1], first[1], name)

    def test_table_without_a_column_is_refused(self):
        for name in TABLES:
            for column in self.data(name).columns:
                if column in ("steady_accelerating", "theory") or (column, name) in (
                        ("omega_c", "beyond_bandwidth"), ("peak", "beyond_speed")):
                    continue  # in the table of the page only
                data = self.data(name)
                del data.columns[column]
                with self.assertRaisesRegex(figures.InputError, f"{name}.csv: column `{column}` is missing"):
                    self.draw(name, data)

    def test_figure_without_a_picture_is_refused(self):
        with self.assertRaisesRegex(figures.InputError, "`fig99`"):
            pictures.draw({"id": "fig99"}, [], None, self.folder, self.manifest)

    def drawn(self, name):
        """The axes of a picture, which is not saved."""
        data = self.data(name)
        sheet = pictures.DRAWN[name](self.figures[name], figures.layouts(self.figures[name], data), data, self.manifest)
        return sheet

    def test_peaks_survive_in_the_curves(self):
        data = self.data("fig12")
        count = 50000
        data.columns["time"] = numpy.arange(count) * 1e-4
        for name in data.columns:
            if name != "time":
                data.columns[name] = numpy.zeros(count)
        data["exact_real_theta_err"][[31234, 777]] = 9.0, -8.0
        layouts = figures.layouts(self.figures["fig12"], data)
        sheet = pictures.fig12(self.figures["fig12"], layouts, data, self.manifest)
        xs, ys = sheet.figure.axes[0].lines[0].get_data()
        self.assertLess(len(xs), 3000)
        self.assertEqual((max(ys), min(ys)), (9.0, -8.0))
        self.assertAlmostEqual(xs[list(ys).index(9.0)], 3.1234)

    def test_an_error_beyond_half_a_turn_leaves_the_axis_and_is_reported(self):
        axis = self.drawn("fig15").figure.axes[7]
        self.assertIn("error", axis.get_ylabel())
        self.assertLess(axis.get_ylim()[1], 10.0)  # the locked estimates swing by 3 mrad
        self.assertTrue(any("beyond the axis" in text.get_text() for text in axis.texts))

    def test_no_legend_lies_on_data_and_nothing_is_cut_off(self):
        for name in self.of_the_day():
            sheet = self.drawn(name)
            sheet.figure.draw_without_rendering()
            renderer = sheet.figure.canvas.get_renderer()
            paper = sheet.figure.bbox
            for axis in sheet.figure.axes:
                with self.subTest(name, axis=axis.get_ylabel()):
                    box = axis.get_tightbbox(renderer)
                    self.assertTrue(box.x0 >= 0 and box.y0 >= 0 and box.x1 <= paper.x1 + 1 and box.y1 <= paper.y1, box)
                    self.assertTrue(axis.has_data())
                    if axis.get_legend():
                        legend = axis.get_legend().get_window_extent(renderer)
                        self.assertFalse(any(legend.y0 < other.bbox.y1 - 1 and legend.y1 > other.bbox.y0 and
                                             legend.x0 < other.bbox.x1 and legend.x1 > other.bbox.x0
                                             for other in sheet.figure.axes))

    def test_plain_names_become_symbols_and_the_rest_stays(self):
        self.assertEqual(pictures.typeset("omega_c, k_f $5 2 us"), r"$\omega_c$, $k_f$ \$5 2 " + "\N{MICRO SIGN}s")
        self.assertEqual(pictures.typeset("kg m^2, b100_wc0, torque_iq"), "kg m$^2$, b100_wc0, torque_iq")

    def test_conditions_are_what_all_runs_share(self):
        figure = {"id": "fig13", "runs": [
            {"flavour": "real", "condition": "noise 10 mA; load 0 N m, PI 0.5, 2.5, 10 A"},
            {"flavour": "real", "condition": "noise 10 mA; load 5 N m, PI 0.5, 2.5, 10 A"},
            {"flavour": "ideal", "condition": "no noise"}]}
        self.assertEqual(pictures.conditions(figure, {"rows": []}), ["noise 10 mA, PI 0.5, 2.5, 10 A"])
        row = {"figure": "fig13", "flavour": "formula", "condition": "eq. (12)"}
        self.assertEqual(pictures.conditions({"id": "fig13", "runs": []}, {"rows": [row]}), ["eq. (12)"])

    def test_outline_of_few_points_is_all_of_them(self):
        self.assertEqual(style.outline([0, 1, 2], [5, 6, 7]), ([0, 1, 2], [5, 6, 7]))


if __name__ == "__main__":
    unittest.main()
