#!/usr/bin/env python3
"""Tests of report.py and page.py. Without matplotlib the tests that draw or pack are skipped, with a message."""
import base64
import copy
import gzip
import html.parser
import importlib.util
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

from called import called

FOLDER = pathlib.Path(__file__).resolve().parent
SCRIPT = FOLDER / "report.py"
DRAWS = importlib.util.find_spec("matplotlib") is not None
if DRAWS:
    import numpy
    import figures
    import page


def row(name, verdict="reproduced", because=""):
    figure, _, flavour = name.split(".")
    return {"id": name, "figure": figure, "flavour": flavour, "claim": f"claim of {name}", "paper": None,
            "expected": None, "ours": 1.25, "unit": "mrad", "tolerance": None, "verdict": verdict, "because": because,
            "condition": "all else equal"}


MANIFEST = {
    "commit": "abc123", "seed": 1, "seconds": 12.5,
    "flavours": {"ideal": "none", "real": "2.5 us", "formula": "an equation"},
    "conditions": [{"name": "motor_resistance", "value": 0.95, "unit": "ohm", "text": "R < 1 & more"}],
    "figures": [{"id": "fig04", "title": "sign <and> sigmoid", "claim": "a & b", "paper": "Fig. 4",
                 "csv": "data/fig04.csv", "events": [],
                 "runs": [{"name": "r", "flavour": flavour, "bandwidth": 100, "condition": flavour}
                          for flavour in ("ideal", "real")]}],
    "rows": [row("fig04.a.real", "not reproduced", "the print errs"), row("fig04.a.ideal"), row("fig04.b.formula")],
}
CSV = "x[A],sign[-],sigmoid[-],k_f_sign[1/A],k_f_sigmoid[1/A]\n" + "".join(
    f"{x / 10:g},{(x > 0) - (x < 0)},{math.tanh(x / 20):.6g},{10 / abs(x) if x else ''},"
    f"{math.tanh(x / 20) * 10 / x if x else 0.5:.6g}\n" for x in range(-100, 101))


class Tags(html.parser.HTMLParser):
    """The addresses that a page would load: those of src and href, and of CSS."""

    def __init__(self, text):
        super().__init__()
        self.addresses, self.open = re.findall(r"url\(([^)]*)\)", text), []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.addresses += [value for key, value in attributes if key in ("src", "href", "srcset", "data", "action")]
        if tag not in ("meta", "link", "img", "br", "hr"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            raise ValueError(f"</{tag}> closes nothing")


class Report(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_report_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.manifest = copy.deepcopy(MANIFEST)
        (self.folder / "data").mkdir()
        (self.folder / "data" / "fig04.csv").write_text(CSV)

    def run_script(self, **environment):
        if self.manifest is not None:
            (self.folder / "report.json").write_text(json.dumps(self.manifest))
        if DRAWS:
            page.uplot.cache_clear()  # each case has its own
        return called("report", self.folder, **environment)

    def library(self):
        """A replacement for uPlot, so that no test needs the network."""
        folder = self.folder / "uplot"
        folder.mkdir()
        (folder / "uPlot.iife.min.js").write_text("var uPlot = null;")
        (folder / "uPlot.min.css").write_text(".uplot {}")
        (folder / "LICENSE").write_text("The MIT License <of uPlot>")
        return str(folder)

    def assert_refused(self, *words):
        run = self.run_script()
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
        for word in ("report.json", *words):
            self.assertIn(word, run.stderr)
        self.assertFalse((self.folder / "index.html").exists())

    def test_missing_matplotlib_is_reported_and_the_data_stay(self):
        (self.folder / "report.json").write_text(json.dumps(self.manifest))
        run = subprocess.run([sys.executable, "-B", "-I", "-S", SCRIPT, self.folder], stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn("matplotlib is missing", run.stderr)
        self.assertEqual((self.folder / "data" / "fig04.csv").read_text(), CSV)

    def test_bad_manifests_are_refused_with_file_and_key(self):
        def spoil(change, *words):
            self.manifest = copy.deepcopy(MANIFEST)
            change(self.manifest)
            with self.subTest(words):
                self.assert_refused(*words)
        spoil(lambda m: m.pop("rows"), "rows: is missing")
        spoil(lambda m: m["figures"][0].pop("claim"), "figures[0].claim: is missing")
        spoil(lambda m: m["rows"][1].update(ours="much"), "rows[1].ours: expected a number", "much")
        spoil(lambda m: m["rows"][1].update(paper=True), "rows[1].paper: expected a number")
        spoil(lambda m: m["rows"][2].update(verdict="fine"), "rows[2].verdict", "fine", "does not hold")
        spoil(lambda m: m["rows"][0].update(figure="fig99"), "rows[0].figure", "fig99")
        spoil(lambda m: m["figures"][0].update(id="../x"), "figures[0].id", "../x")
        spoil(lambda m: m["figures"][0].update(csv="../x.csv"), "figures[0].csv", "../x.csv")
        spoil(lambda m: m["figures"].append(m["figures"][0]), "figures[1].id", "fig04")
        spoil(lambda m: m.update(seed=None), "seed: expected a number, got null")

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_files_that_cannot_be_read_are_named(self):
        self.manifest = None
        self.assert_refused("No such file")
        (self.folder / "report.json").write_text("{")
        self.assert_refused("Expecting")
        self.manifest = MANIFEST
        (self.folder / "data" / "fig04.csv").unlink()
        run = self.run_script()
        self.assertEqual(run.returncode, 2, run.stderr)
        self.assertIn("fig04.csv", run.stderr)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_page_loads_nothing_and_is_well_formed(self):
        run = self.run_script(UPLOT_DIR=self.library())
        self.assertEqual((run.returncode, run.stderr, len(run.stdout.splitlines())), (0, "", 1), run.stderr)
        text = (self.folder / "index.html").read_text(encoding="utf-8")
        tags = Tags(text)
        self.assertEqual(tags.open, [])
        foreign = [each for each in tags.addresses if not each.startswith(("#", "data:"))]
        self.assertEqual(sorted(set(foreign)), ["data/fig04.csv", "pictures/fig04.svg"])
        for address in foreign:
            self.assertTrue((self.folder / address).is_file(), address)
        for words in ("sign &lt;and&gt; sigmoid", "a &amp; b", "R &lt; 1 &amp; more", "the print errs", "var uPlot",
                      "License &lt;of uPlot&gt;", "abc123", "ideal: <span"):
            self.assertIn(words, text)
        self.assertEqual(text.count('data-row="fig04.a.ideal"'), 2)  # in the table of verdicts, and in its figure

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_without_uplot_the_page_reports_it_and_shows_the_pictures(self):
        run = self.run_script(UPLOT_DIR="", XDG_CACHE_HOME=str(self.folder))
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("get-uplot", run.stdout)
        text = (self.folder / "index.html").read_text(encoding="utf-8")
        self.assertIn("run tools/get-uplot", text)
        self.assertIn("data:image/png;base64,iVBOR", text)
        self.assertNotIn('class="plots"', text)

    @unittest.skipUnless(DRAWS, "no matplotlib")
    def test_page_of_a_failed_report_is_the_last_one(self):
        (self.folder / "index.html").write_text("last")
        (self.folder / "data" / "fig04.csv").write_text("x[A]\n1\n")
        self.assertEqual(self.run_script().returncode, 2)
        self.assertEqual((self.folder / "index.html").read_text(), "last")


def unpack(meta, octets):
    """Tests of page.js."""
    count = len(octets) // 4
    values, code = [], 0
    for i in range(count):
        folded = sum(octets[plane * count + i] << 8 * plane for plane in range(4))
        code += (folded >> 1) ^ -(folded & 1)
        values.append((meta["base"] + code - 1) * 10.0 ** meta["exponent"] if code else math.nan)
    return values


@unittest.skipUnless(DRAWS, "no matplotlib")
class Packing(unittest.TestCase):
    def assert_kept(self, values, within, **how):
        values = numpy.array(values, dtype=float)
        meta, octets = page.pack(values, **how)
        for was, now in zip(values, unpack(meta, octets)):
            if math.isnan(was):
                self.assertTrue(math.isnan(now))
            else:
                self.assertLessEqual(abs(was - now), within * (1.0 + 1e-9), (was, now))

    def test_values_are_kept_within_half_a_step_of_1_20000_of_the_range(self):
        self.assert_kept([math.sin(k) * 450.0 for k in range(3000)], 900.0 / 20000.0 / 2.0)
        self.assert_kept([1500.0 + 1e-3 * k for k in range(100)], 0.1 / 20000.0 / 2.0)

    def test_missing_numbers_stay_missing(self):
        self.assert_kept([math.nan, -3.0, 5.0, math.nan, 4.0, math.nan], 8.0 / 20000.0 / 2.0)
        self.assert_kept([math.nan, math.nan], 0.0)

    def test_constants_are_exact(self):
        self.assert_kept([0.0, 0.0], 0.0)
        self.assert_kept([-1500.0] * 5, 0.0)

    def test_small_numbers_keep_two_digits_on_a_logarithmic_axis(self):
        values = [10.0 ** (k / 10.0) for k in range(-20, 40)]
        self.assert_kept(values, 0.01 * min(values) / 2.0, logarithmic=True)

    def test_even_axis_becomes_start_and_step_and_another_stays(self):
        self.assertEqual(page.axis_of(numpy.array([0.5, 0.5001, 0.5002])), {"start": 0.5, "step": 0.0001, "count": 3})
        self.assertEqual(page.axis_of(numpy.array([1.0, 10.0, 100.0])), {"values": [1.0, 10.0, 100.0], "count": 3})

    def test_layout_becomes_json_with_its_columns_once_each(self):
        layout = figures.Layout("l", "time", "time [s]", [
            figures.Panel("error [mrad]", [figures.Trace("a", "$\\omega_c$ 25", "#000000")]),
            figures.Panel("both [mrad]", [figures.Trace("a", "a", "#000000"), figures.Trace("b", "b", "#0072B2")])])
        data = types.SimpleNamespace(units={"time": "s", "a": "mrad", "b": "mrad"}, columns={
            "time": numpy.array([0.0, 0.1]), "a": numpy.array([1.0, 2.0]), "b": numpy.array([0.0, -1.0])})
        plot, = page.plots([layout], data)
        self.assertEqual({name: column["index"] for name, column in plot["columns"].items()}, {"a": 0, "b": 1})
        self.assertEqual(plot["panels"][0]["traces"][0]["label"], "ω_c 25")
        octets = gzip.decompress(base64.b64decode(plot["data"]))
        self.assertEqual(len(octets), 2 * 2 * 4)
        self.assertEqual(unpack(plot["columns"]["b"], octets[8:]), [0.0, -1.0])
        self.assertNotIn("<", page.embedded({"text": "</script>"}))


@unittest.skipUnless(DRAWS, "no matplotlib")
class Text(unittest.TestCase):
    def test_numbers_have_four_digits_and_a_minus(self):
        for value, text in ((355.04, "355"), (-80.153, "−80.15"), (0.0, "0"), (12345.6, "12346"), (0.01861, "0.01861"),
                            (1e-5, "1e−5"), (100.0, "100"), (None, "–"), (True, "yes"), ("sign", "sign")):
            self.assertEqual(page.number(value), text)

    def test_claims_pair_real_with_ideal_and_lose_no_row(self):
        rows = [row("f.a.ideal"), row("f.a.real"), row("f.b.ideal"), row("f.c.formula"), row("f.a.formula")]
        pairs = [(first["id"], ideal and ideal["id"]) for first, ideal in page.claims(rows)]
        self.assertEqual(pairs, [("f.a.real", "f.a.ideal"), ("f.a.formula", None), ("f.b.ideal", None),
                                 ("f.c.formula", None)])


if __name__ == "__main__":
    unittest.main()
