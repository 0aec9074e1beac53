"""`lagless run --plot`, `lagless plot`, `lagless compare`: pictures, messages, exit codes. usage: test_look.py LAGLESS FOLDER"""

import base64
import gzip
import importlib.util
import json
import os
import pathlib
import re
import shlex
import shutil
import struct
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import command_line  # noqa: E402

FOLDER = pathlib.Path(command_line.FOLDER)
DRAWS = importlib.util.find_spec("matplotlib") is not None
UPLOT = (pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "lagless" / "uplot").is_dir() \
    or "UPLOT_DIR" in os.environ
SCENARIO = """schema = 1
title = "a test & <its> title"
[run]
duration = "0.2 s"
record = ["i_d", "plant.inertia"]
[params]
position_source = "encoder"
[requests]
enable = "on"
speed_request = "300 r/min"
[[at]]
time = "0.1 s"
plant.load_torque = "1 N m"
[[expect]]
name = "turns"
signal = "true_omega_m"
statistic = "last"
at_least = "1 r/min"
[[expect]]
name = "flies"
signal = "true_omega_m"
statistic = "last"
at_least = "5000 r/min"
"""
RECORDING = """# lagless recording: 1
# program: lagless 0.2.0
# scenario: x
# title: by hand
# seed: 1
# every: 1
# period: 0.0001 s
# ended: complete
# choices state: not_ready|ready
# value inertia: 0.06 kg m^2
time[s],i_q[A],state[-]
0.0000,1,0
0.0001,1.5,0
0.0002,2,1
0.0003,-0.1,1
"""


def lagless(*arguments, **settings):
    return command_line.lagless(*map(str, arguments), **settings)


def layouts(page):
    """The data that the script of the page draws, for each figure."""
    text = page.read_text(encoding="utf-8")
    hosts = re.findall(r'data-figure="(\w+)".*?<script type="application/json">(.*?)</script>', text, re.DOTALL)
    return {figure: json.loads(content) for figure, content in hosts}


def column(layout, name):
    """The values of a column, unpacked as page.js does it."""
    octets = gzip.decompress(base64.b64decode(layout["data"]))
    meta, count = layout["columns"][name], layout["x"]["count"]
    planes = [octets[(4 * meta["index"] + k) * count:(4 * meta["index"] + k + 1) * count] for k in range(4)]
    code, values = 0, []
    for word in zip(*planes):
        folded = struct.unpack("<I", bytes(word))[0]
        code += folded >> 1 ^ -(folded & 1)
        values.append((meta["base"] + code - 1) * 10.0 ** meta["exponent"] if code else None)
    return values


def recorded(path):
    """The columns of a CSV file as {name: (unit, texts)}."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    cells = zip(*(line.split(",") for line in lines))
    return {head.split("[")[0]: (head.split("[")[1][:-1], values) for head, *values in cells}


def fresh(name):
    """Makes an empty folder."""
    folder = FOLDER / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


class Case(command_line.TestCase):
    def setUp(self):
        self.folder = fresh(self.id().rpartition(".")[2])
        self.own_toml = self.folder / "own.toml"
        self.own_toml.write_text(SCENARIO)

    def recording(self, *changes, name="by_hand.csv"):
        text = RECORDING
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new)
        path = self.folder / name
        path.write_text(text)
        return path


@unittest.skipUnless(DRAWS, "matplotlib is missing")
class Plots(Case):
    @classmethod
    def setUpClass(cls):
        """Makes the data that several tests use: two runs of the scenario, in a folder each, and one run that ends with a fault."""
        cls.made = fresh("made")
        (cls.made / "own.toml").write_text(SCENARIO)
        cls.first = lagless("run", "own.toml", "--plot", cwd=cls.made)
        cls.second = lagless("run", "own.toml", "--plot=html,png", "--json", cwd=cls.made)
        cls.fault = lagless("run", "stuck_sensor", "--plot", "--quiet", "--out", "out", cwd=cls.made)
        cls.own = cls.made / "runs" / "own"

    def test_a_run_without_a_folder_gets_a_fresh_one_and_reports_it(self):
        self.expect(1, self.first, "page: runs/own/own.html\n", "FAILED")
        for name in ("own", "own_2"):
            self.assertTrue((self.made / "runs" / name / "own.csv").is_file(), self.second.stderr)
            self.assertTrue((self.made / "runs" / name / "own.html").is_file(), self.second.stderr)

    def test_json_lists_the_pictures_and_stays_json(self):
        self.assertEqual(["runs/own_2/own.csv", "runs/own_2/own.html", "runs/own_2/own.png"], json.loads(self.second.stdout)["files"])

    def test_plot_records_what_a_drive_shows_besides_what_the_scenario_wants(self):
        names = list(recorded(self.own / "own.csv"))
        self.assertEqual(["time", "i_d", "inertia"], [name.replace("plant.", "") for name in names[:3]])
        self.assertLessEqual({"state", "manoeuvre", "fault_reason", "omega_m_ref", "true_omega_m", "true_torque", "i_q", "i_q_upper",
                              "true_i_a", "u_d", "u_q", "u_dc", "theta_err"}, set(names))

    def test_without_plot_nothing_more_is_recorded_and_drawn(self):
        lagless("run", self.own_toml, "--out", self.folder / "out")
        self.assertEqual(3, len(recorded(self.folder / "out" / "own.csv")))
        self.assertEqual(["own.csv"], sorted(path.name for path in (self.folder / "out").iterdir()))

    def test_the_page_has_verdicts_events_settings_and_scenario(self):
        page = (self.own / "own.html").read_text(encoding="utf-8")
        self.assertIn("<h1>a test &amp; &lt;its&gt; title</h1>", page)
        self.assertRegex(page, r'verdict bad.*failed.*flies: last of true_omega_m.*at least 5000 r/min')
        self.assertRegex(page, r"verdict good.*met.*turns: last of true_omega_m")
        self.assertRegex(page, r'<th scope="row">speed_request</th><td class="number">300</td><td class="unit">r/min</td>')
        self.assertRegex(page, r'<th scope="row">enable</th><td class="number">on</td><td class="unit"></td><td class="number">off</td>')
        self.assertIn("plant.load_torque = &quot;1 N m&quot;", page)
        if UPLOT:
            events = layouts(self.own / "own.html")["run"]["events"]
            self.assertIn({"time": 0.1, "text": "load_torque = 1 N m", "kind": ""}, events)
            self.assertIn("run", [event["text"] for event in events if event["kind"] == "manoeuvre"])

    @unittest.skipUnless(UPLOT, "uPlot is missing")
    def test_panels_are_those_of_a_drive_in_units_of_their_own(self):
        drawn = layouts(self.made / "out" / "stuck_sensor.html")
        self.assertEqual(["", "speed [r/min]", "torque [N m]", "current [A]", "phase current [A]", "voltage [V]", "DC link [V]",
                          "angle error [mrad]"], [panel["ylabel"] for panel in drawn["run"]["panels"]])
        bands = drawn["run"]["panels"][0]
        self.assertEqual(["state", "manoeuvre", "fault_reason", "warnings"], [trace["column"] for trace in bands["traces"]])
        self.assertEqual("bad_sample", bands["traces"][2]["names"]["30"])
        self.assertEqual("operation_enabled", bands["traces"][0]["names"]["3"])
        values = recorded(self.made / "out" / "stuck_sensor.csv")
        for name, factor in (("true_omega_m", 30 / 3.14159265358979), ("i_q", 1.0), ("theta_hat_err", 1e3)):
            own = [float(text) * factor for text in values[name][1]]
            room = (max(own) - min(own)) / 2e4
            for shown, true in zip(column(drawn["run"], name)[::97], own[::97]):
                self.assertAlmostEqual(shown, true, delta=room)
        limit = [value / 3 ** 0.5 for value in map(float, values["u_dc"][1])]
        self.assertAlmostEqual(column(drawn["run"], "u_limit")[-1], limit[-1], delta=0.01)

    @unittest.skipUnless(UPLOT, "uPlot is missing")
    def test_a_fault_brings_its_history_and_its_remedy(self):
        page = self.made / "out" / "stuck_sensor.html"
        self.assertEqual({"run", "fault"}, set(layouts(page)))
        self.assertRegex(page.read_text(encoding="utf-8"), r"Fault bad_sample at 1\.000\d s</b>: a sample was not a number.*check sensor supply")
        history = self.made / "out" / "stuck_sensor_fault.csv"
        self.expect(0, lagless("plot", history), "stuck_sensor_fault.html")
        alone = layouts(history.with_suffix(".html"))
        self.assertEqual(["run"], list(alone))
        self.assertEqual(layouts(page)["fault"]["data"], alone["run"]["data"])
        shown = set(alone["run"]["columns"])
        self.assertEqual(set(recorded(history)) - {"time", "period"}, shown & set(recorded(history)))

    @unittest.skipUnless(UPLOT, "uPlot is missing")
    def test_nothing_recorded_is_left_out(self):
        rows = [f"{row['table']}.{row['name']}" for row in json.loads(lagless("signals", "--json").stdout)["rows"]]
        self.assertGreater(len(rows), 80)
        self.expect(1, lagless("run", self.own_toml, "--plot", "--record", ",".join(rows), "--out", self.folder / "out"), "out/own.html")
        rows = set(recorded(self.folder / "out" / "own.csv")) - {"time"}
        self.assertGreater(len(rows), 80)
        layout = layouts(self.folder / "out" / "own.html")["run"]
        traces = [trace["column"] for panel in layout["panels"] for trace in panel["traces"]]
        # These signals have no curve of their own: they are the axis, a pair of limits, and bands that were 0 throughout.
        silent = {"period", "theta_sigma", "warnings_2", "fault_present"}
        self.assertEqual(rows - silent, rows & set(traces))
        self.assertEqual(len(traces), len(set(traces)))
        for panel in layout["panels"][1:]:
            self.assertRegex(panel["ylabel"], r" \[.+\]$")

    def test_a_mat_alone_is_drawn_as_a_csv_is_and_a_vcd_alone_is_refused(self):
        self.expect(1, lagless("run", self.own_toml, "--plot", "--format", "mat", "--out", self.folder / "mat"), "mat/own.html")
        self.expect(2, lagless("run", self.own_toml, "--plot", "--format", "vcd", "--out", self.folder / "vcd"), "csv or mat")
        self.assertFalse((self.folder / "vcd").exists())
        both = [self.own / "own.html", self.folder / "mat" / "own.html"]
        self.assertEqual(*([re.findall(r"verdict (?:good|bad)", page.read_text(encoding="utf-8")) for page in both]))
        if UPLOT:
            drawn = [layouts(page)["run"] for page in both]
            self.assertEqual(*([panel["ylabel"] for panel in each["panels"]] for each in drawn))
            for x, y in zip(*(column(each, "i_d") for each in drawn)):
                self.assertAlmostEqual(x, y, delta=1e-4)


class Document(Case):
    @unittest.skipUnless(DRAWS, "matplotlib is missing")
    def test_what_docs_plots_shows_is_what_is_printed(self):
        """`...` stands for lines that are left out."""
        text = (ROOT / "docs" / "plots.md").read_text(encoding="utf-8")
        blocks = re.findall(r"^    \$ build/host/lagless (.*)\n((?:    (?!\$ ).*\n)*)", text, re.M)
        self.assertEqual({"run", "plot", "compare"}, {command.split()[0] for command, _ in blocks})
        for command, shown in blocks:
            done = lagless(*shlex.split(command), cwd=self.folder)
            lines = (done.stdout + done.stderr).splitlines()
            for line in shown.splitlines():
                if line.strip() != "...":
                    self.assertIn(line[4:], lines, command)
                    del lines[:lines.index(line[4:]) + 1]


class Refusals(Case):
    @unittest.skipUnless(DRAWS, "matplotlib is missing")
    def test_what_is_not_a_recording_is_refused_by_name_and_line(self):
        other = self.folder / "other.csv"
        other.write_text("time,x\n0,1\n1,2\n")
        short = self.folder / "short.mat"
        short.write_bytes(b"MATLAB 5.0 MAT-file, cut off")
        cases = ((other, "other.csv: no recording of lagless"), (self.folder / "none.csv", "none.csv: No such file or directory; accepted: a CSV or MAT file"),
                 (self.folder, "; name one of them"), (short, "short.mat: this MAT file cannot be read"),
                 (self.recording(("recording: 1", "recording: 7")), "format 7: this program reads format 1"),
                 (self.recording(("time[s]", "t[s]"), name="t.csv"), "t.csv:11: column time[s] is missing"),
                 (self.recording(("i_q[A]", "i_q"), name="u.csv"), "u.csv:11: column `i_q`: a unit in brackets"),
                 (self.recording(("0.0002,2,1", "0.0002,2"), name="c.csv"), "c.csv:14: 2 values, but 3 columns"),
                 (self.recording(("1.5", "one"), name="n.csv"), "n.csv:13: `one` is no number"),
                 (self.recording(("0.0002", "0.0001"), name="b.csv"), "b.csv: time does not increase"),
                 (self.recording((RECORDING[RECORDING.index("0.0000"):], ""), name="e.csv"), "e.csv: no samples"))
        sys.path.insert(0, str(ROOT / "tools" / "plot"))
        import recording
        for path, message in cases:
            with self.assertRaises(recording.InputError) as refused:
                recording.read(path)
            self.assertIn(message, str(refused.exception))
            self.assertEqual(1, len(str(refused.exception).splitlines()))
        for command in (["plot", other], ["compare", other, other]):
            done = self.expect(2, lagless(*command), f"lagless {command[0]}: ", cases[0][1])
            self.assertEqual(1, len(done.stderr.splitlines()), done.stderr)

    def test_wrong_use_is_2_before_anything_runs(self):
        path = self.recording()
        self.refuses((["plot"], "no recording is given"), (["compare", path], "two recordings are needed"), (["plot", path, path], "a second recording; accepted: one"),
                     (["plot", path, "--format", "jpg"], "jpg: accepted: html, png, svg"))
        self.expect(2, lagless("run", self.own_toml, "--plot=pdf", cwd=self.folder), "pdf: accepted: html, png, svg")
        self.expect(2, lagless("run", self.own_toml, "--plot", "--record", "nonsense", cwd=self.folder))
        self.assertFalse((self.folder / "runs").exists(), "a refused run leaves no folder")

    @unittest.skipUnless(DRAWS, "matplotlib is missing")
    def test_a_folder_that_cannot_be_written_is_3(self):
        path = self.recording()
        blocked = self.folder / "file"
        blocked.write_text("")
        for command in (["plot", path, "--out", blocked / "x"], ["compare", path, path, "--out", blocked / "x"],
                        ["run", self.own_toml, "--plot", "--out", blocked / "x"]):
            done = self.expect(3, lagless(*command), str(blocked))
            self.assertNotIn("Traceback", done.stderr)
        (self.folder / "runs").write_text("")
        self.expect(3, lagless("run", self.own_toml, "--plot", cwd=self.folder), "runs")

    def test_without_python_or_matplotlib_it_reports_how_to_get_them(self):
        path = self.recording()
        self.expect(3, lagless("plot", path, env={**os.environ, "LAGLESS_PYTHON": "/nonexistent/python3"}),
                    "cannot run Python (/nonexistent/python3)", "install Python 3.9 or later")
        for module in ("numpy", "matplotlib"):
            stub = self.folder / f"no_{module}"
            stub.mkdir()
            (stub / f"{module}.py").write_text(f"raise ModuleNotFoundError('No module named {module}', name='{module}')\n")
            done = self.expect(3, lagless("plot", path, "--format", "png", env={**os.environ, "PYTHONPATH": str(stub)}),
                               "lagless plot: matplotlib is missing: run tools/setup demo")
            self.assertNotIn("Traceback", done.stderr)

    def test_packages_that_setup_installs_after_the_build_are_used(self):
        python = self.folder / "build/venv/bin/python"
        python.parent.mkdir(parents=True)
        python.write_text('#!/bin/sh\necho "called: $0" >&2\nexit 3\n')
        python.chmod(0o755)
        (self.folder / "tools").mkdir()
        environment = {key: value for key, value in os.environ.items() if key != "LAGLESS_PYTHON"}
        self.expect(3, lagless("plot", self.recording(), env={**environment, "LAGLESS_TOOLS": str(self.folder / "tools")}),
                    f"called: {self.folder}/tools/../build/venv/bin/python")


@unittest.skipUnless(DRAWS, "matplotlib is missing")
class Compares(Case):
    def test_equal_recordings_are_0(self):
        done = self.expect(0, lagless("compare", self.recording(), self.recording(name="b.csv")), "equal: 4 samples of 2 signals")
        self.assertEqual("", done.stderr)

    def test_the_first_difference_is_reported_with_period_time_and_both_values(self):
        a = self.recording()
        b = self.recording(("0.0002,2,1", "0.0002,2.25,0"), ("-0.1", "-0.2"), name="b.csv")
        done = self.expect(1, lagless("compare", a, b))
        lines = done.stdout.splitlines()
        begin = lines.index("first difference: period 2, 0.0002 s")
        self.assertEqual(["  i_q: 2 A in A, 2.25 A in B", "  state: ready in A, not_ready in B", "2 of 2 signals differ:"],
                         lines[begin + 1:begin + 4])
        self.assertRegex(lines[begin + 4], r"i_q +from 0\.0002 s, in 2 of 4 samples, by up to 0\.25 A")
        self.assertRegex(lines[begin + 5], r"^  state +from 0\.0002 s, in 1 of 4 samples$")

    def test_angles_differ_by_less_than_half_a_turn(self):
        names = ("i_q[A]", "theta_err[rad]")
        done = self.expect(1, lagless("compare", self.recording(names, ("-0.1", "-3.1")), self.recording(names, ("-0.1", "3.1"), name="b.csv")))
        self.assertRegex(done.stdout, r"theta_err +from 0\.0003 s, in 1 of 4 samples, by up to 83\.19 mrad\n")  # 2 pi - 6.2 = 0.083

    def test_the_last_bit_counts_and_not_a_number_is_itself(self):
        a = self.recording(("1.5", "nan"), ("-0.1", "0.1"))
        self.expect(0, lagless("compare", a, self.recording(("1.5", "nan"), ("-0.1", "0.1"), name="b.csv")))
        self.expect(1, lagless("compare", a, self.recording(("1.5", "nan"), ("-0.1", "0.10000001"), name="c.csv")), "period 3, 0.0003 s",
                    "i_q: 0.1 A in A, 0.10000001 A in B")

    def test_what_stdout_cannot_take_is_3(self):
        a, b = self.recording(), self.recording(name="b.csv")
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = self.expect(3, lagless("compare", a, b, stdout=full), "the output cannot be written: No space left on device")
        self.assertNotIn("Exception", done.stderr)

    def test_rows_rates_lengths_and_settings_that_differ_are_reported(self):
        a = self.recording()
        self.expect(1, lagless("compare", a, self.recording(("i_q[A]", "i_d[A]"), name="b.csv")), "only in A: i_q", "only in B: i_d",
                    "no difference in the 4 samples of the 1 signals that both have")
        self.expect(1, lagless("compare", a, self.recording(("every: 1", "every: 2"), ("0.0001,1.5,0\n", ""), ("0.0003,-0.1,1\n", ""),
                                                            name="c.csv")),
                    "rate: every 1 periods in A, every 2 in B", "compared: 2 samples that both have; 2 only A has, 0 only B")
        self.expect(0, lagless("compare", a, self.recording(("inertia: 0.06", "inertia: 0.07"), name="d.csv")),
                    "setting inertia: 0.06 kg m^2 in A, 0.07 kg m^2 in B", "equal: ")
        with_choice = ("# value inertia", "# value enable: 1 -\n# value speed_request: 31.415927 rad/s\n# value inertia")
        self.expect(0, lagless("compare", self.recording(with_choice, name="f.csv"), self.recording(
            with_choice, ("enable: 1", "enable: 2"), ("31.415927", "62.831853"), name="g.csv")),
                    "setting enable: on in A, quick_stop in B", "setting speed_request: 300 r/min in A, 600 r/min in B")
        self.expect(2, lagless("compare", a, self.recording(("period: 0.0001", "period: 0.00005"), name="e.csv")), "periods of 0.0001 s")

    def test_both_are_drawn_in_one_page_with_their_difference(self):
        a, b = self.recording(), self.recording(("-0.1", "-0.2"), name="b.csv")
        self.expect(1, lagless("compare", a, b, "--out", self.folder / "out", "--format", "png"), "out/compare.png")
        self.expect(1, lagless("compare", a, b, "--plot", cwd=self.folder), "runs/compare/compare.html")
        if UPLOT:
            drawn = layouts(self.folder / "runs" / "compare" / "compare.html")
            self.assertEqual(["i_q A", "i_q B"], [trace["label"] for trace in drawn["both"]["panels"][1]["traces"]])
            for shown, true in zip(column(drawn["apart"], "d.i_q"), (0.0, 0.0, 0.0, -0.1)):
                self.assertAlmostEqual(shown, true, places=6)

    def test_what_is_computed_from_signals_is_drawn_for_each_recording_and_a_common_limit_once(self):
        voltages = (("i_q[A],state[-]", "u_d[V],u_q[V]"), ("# choices", "# value dc_overvoltage: 400 V\n# choices"))
        a = self.recording(*voltages)
        b = self.recording(*voltages, ("-0.1,1", "-3,4"), name="b.csv")
        self.expect(1, lagless("compare", a, b, "--plot", cwd=self.folder))
        if UPLOT:
            drawn = layouts(self.folder / "runs" / "compare" / "compare.html")["both"]
            labels = {trace["label"]: trace["column"] for trace in drawn["panels"][0]["traces"]}
            self.assertEqual({"u_q A", "u_q B", "u_d A", "u_d B", "length of the vector A", "length of the vector B"}, set(labels))
            self.assertAlmostEqual(column(drawn, labels["length of the vector A"])[-1], 1.01 ** 0.5, places=3)
            self.assertAlmostEqual(column(drawn, labels["length of the vector B"])[-1], 5.0, places=3)
        measured = (("i_q[A],state[-]", "u_dc[V],i_q[A]"), voltages[1])
        self.expect(1, lagless("compare", self.recording(*measured), self.recording(*measured, ("-0.1,1", "300,4"), name="b.csv"), "--out",
                               self.folder / "dc"))
        if UPLOT:
            drawn = layouts(self.folder / "dc" / "compare.html")["both"]
            labels = [trace["label"] for panel in drawn["panels"] for trace in panel["traces"]]
            self.assertEqual(1, sum(label.startswith("dc_overvoltage") for label in labels), labels)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
