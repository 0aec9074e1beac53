#!/usr/bin/env python3
"""Experiments as files, and the commands that take a user's scenario: `lagless paper FILE`, bench, campaign, matrix.

The example of docs/experiments.md is run and its output compared; everything else is expected from algebra."""
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import stuck  # noqa: E402

LAGLESS, ROOT = sys.argv[1], os.path.abspath(sys.argv[2])
with open(os.path.join(ROOT, "docs", "experiments.md"), encoding="utf-8") as page:
    PAGE = page.read()

# 10 periods of a rig that stands: the load goes from 0 to 4.5 N m in steps of 0.5.
STANDING = """schema = 1
title = "stands"
[run]
duration = "1 ms"
[[at]]
time = 0
ramp = "0.9 ms"
plant.load_torque = "4.5 N m"
[[measure]]
name = "load"
signal = "plant.load_torque"
[[measure]]
name = "some"
signal = "plant.load_torque"
between = {signal = "plant.load_torque", begin = 0.9, end = 2.5}
[[measure]]
name = "late"
signal = "plant.load_torque"
unit = "mN m"
from = "0.5 ms"
"""


def claim(name, value, printed=None, tolerance=1e-9, more=""):
    told = f"printed = {printed!r}\ntolerance = {tolerance!r}\n" if printed is not None else ""
    return f'[[claim]]\nid = "{name}"\ntext = "t"\nunit = "-"\nvalue = "{value}"\n{told}{more}'


class Test(stuck.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()

    def lagless(self, *arguments):
        return subprocess.run([LAGLESS, *arguments], capture_output=True, text=True, cwd=self.folder, timeout=120)

    def write(self, text, name="my.toml"):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)
        return "./" + name

    def read(self, name):
        with open(os.path.join(self.folder, name), encoding="utf-8") as file:
            return file.read()

    def rows(self, text, exit_code=0):
        done = self.lagless("paper", self.write(text), "--json")
        self.assertEqual(exit_code, done.returncode, done.stdout + done.stderr)
        return {row["id"]: row for row in json.loads(done.stdout)}

    def refused(self, text, place, *fragments):
        """place: what stands in the line that the message is about."""
        line = text[:text.index(place)].count("\n") + 1 if place else None
        done = self.lagless("paper", self.write(text))
        self.assertEqual(2, done.returncode, done.stdout + done.stderr)
        for fragment in (f"./my.toml:{line}:" if line else "./my.toml:", *fragments):
            self.assertIn(fragment, done.stderr)

    # ---- the page ----

    def test_the_example_of_the_page_says_what_the_page_says(self):
        example, = re.findall(r"```toml\n# load_step\.toml\n(.*?)```", PAGE, re.S)
        output, = re.findall(r"```text\n(.*?)```", PAGE, re.S)
        done = self.lagless("paper", self.write(example, "load_step.toml"))
        self.assertEqual(output, done.stdout)
        self.assertEqual(0, done.returncode)
        ours = {row["id"]: row["ours"] for row in self.rows(example, 0).values()}
        self.assertAlmostEqual(1.0, ours["my.current.run"], delta=0.02)  # torque balance

    def test_the_page_names_all_that_a_file_can_refer_to(self):
        for text, line in ((STANDING + claim("a", "nofunction(1)", 0.0), None),
                           (STANDING.replace('unit = "mN m"', 'through = "nothing"') + claim("a", "1", 1.0), None),
                           ("[experiment]\nuse = [\"nothing\"]\n", None), ("[experiment]\ncurve = \"nothing\"\n", None)):
            done = self.lagless("paper", self.write(text if "schema" in text else STANDING.replace("[run]", text + "[run]") + claim("a", "1", 1.0)))
            self.assertEqual(2, done.returncode)
            for name in re.split(r"[|, ]+", done.stderr.split("accepted: ")[1].strip()):
                self.assertIn(f"`{name}`", PAGE)

    # ---- numbers ----

    def test_expressions_are_algebra(self):
        cases = {"2 + 3 * 4": 14.0, "(2 + 3) * -4": -20.0, "10 - 4 - 3": 3.0, "8 / 4 / 2": 1.0, "1e-3 / mrad": 1.0,
                 "max(1, 5, 3) + min(4, 2)": 7.0, "worst(1, -5, 3)": -5.0, "abs(-3) + sqrt(16)": 7.0,
                 "30 * rpm": math.pi, "sin(pi / 6)": 0.5, "1 < 2 and 2 <= 2 and 3 > 2": 1.0, "1 < 2 and 3 < 2": 0.0,
                 "plant.pole_pairs": 4.0, "tracking_error(1624, 500)": -math.asin(500 / 1624),
                 "sqrt(loop_ki(100, 0))": 100 / math.sqrt(3 + math.sqrt(10)),
                 "loop_kp(100, 0) - 2 * sqrt(loop_ki(100, 0))": 0.0}
        rows = self.rows(STANDING + "".join(claim(f"c{n}", text, number) for n, (text, number) in enumerate(cases.items())))
        for n, (text, number) in enumerate(cases.items()):
            self.assertAlmostEqual(number, rows[f"my.c{n}.run"]["ours"], places=7, msg=text)
            self.assertEqual("holds", rows[f"my.c{n}.run"]["verdict"], text)

    def test_statistics_of_a_ramp_in_windows_units_and_between_two_values(self):
        steps = [0.5 * n for n in range(10)]
        mean = sum(steps) / 10
        cases = {"load.mean": mean, "load.min": 0.0, "load.max": 4.5, "load.peak": 4.5, "load.last": 4.5,
                 "load.sd": math.sqrt(sum((x - mean) ** 2 for x in steps) / 10), "load.rms": math.sqrt(sum(x * x for x in steps) / 10),
                 "late.mean": 3500.0, "some.min": 1.0, "some.max": 2.0, "some.mean": 1.5}
        rows = self.rows(STANDING + "".join(claim(f"c{n}", text, number, 1e-5 * max(1.0, number)) for n, (text, number) in enumerate(cases.items())))
        for n, (text, number) in enumerate(cases.items()):
            self.assertAlmostEqual(number, rows[f"my.c{n}.run"]["ours"], delta=1e-5 * max(1.0, number), msg=text)

    def test_from_power_on_it_is_the_run_of_the_scenario(self):
        with open(os.path.join(ROOT, "host_sim", "scenarios", "load_step.toml"), encoding="utf-8") as file:
            scenario = file.read()
        told = json.loads(self.lagless("run", self.write(scenario), "--json").stdout)
        claims = []
        for n, expect in enumerate(told["expectations"]):
            minus = f'minus = "{expect["minus"]}"\n' if expect.get("minus") else ""
            claims.append((expect["value"], claim(f"c{n}", f"m{n}.{expect['statistic']}", 0.0, 1e9)))
            scenario += f'\n[[measure]]\nname = "m{n}"\nsignal = "{expect["signal"]}"\n{minus}from = {expect["from_s"]}\nto = {expect["to_s"]}\n'
        self.assertGreater(len(claims), 3)
        rows = self.rows(scenario + "".join(text for _, text in claims))
        self.assertEqual([value for value, _ in claims], [row["ours"] for row in rows.values()])

    def test_sweeps_make_a_grid_and_claims_choose_its_points(self):
        text = STANDING.replace("[[measure]]", '[[sweep]]\nname = "j"\nrow = "plant.inertia"\nfrom = 0.01\nto = 0.03\nsteps = 3\nnames = ["a", "b", "c"]\n'
                                '[[sweep]]\nname = "end"\n[[sweep.point]]\nname = "low"\n[[sweep.point]]\nname = "high"\ntext = "more"\nat = [{time = "0.9 ms", plant.load_torque = 9}]\n'
                                '[[measure]]\nname = "j"\nsignal = "plant.inertia"\n[[measure]]', 1)
        text = text.replace("[run]", '[experiment]\nid = "grid"\neach = ["high", "low"]\ncondition = "{end}: {plant.inertia}"\n[run]')
        text += claim("j", "j.mean", 0.02, 1e-6, 'at = {j = "b"}\n') + claim("worst", "j.mean", 0.03, 1e-6, 'at = {j = ["a", "c", "b"]}\nwhere = "of three"\n')
        text += claim("other", "j.mean@c - j.mean", 0.02, 1e-6, 'at = {j = "a"}\n')
        text += claim("kind", "j.mean", None, more='at = {j = "a"}\nholds_if = "value < j.mean@b"\n')
        rows = self.rows(text)
        self.assertEqual([f"grid.{c}.{f}" for f in ("high", "low") for c in ("j", "worst", "other", "kind")], list(rows))
        self.assertEqual("of three; more: 0.03", rows["grid.worst.high"]["condition"])
        self.assertEqual("low: 0.02", rows["grid.j.low"]["condition"])
        self.assertEqual({"holds"}, {row["verdict"] for row in rows.values()})

    def test_claims_of_theory_alone_need_no_run(self):
        head = 'schema = 1\ntitle = "theory"\n[experiment]\nsource = "p. 3"\n'
        rows = self.rows(head + claim("corner", "sqrt(loop_ki(100, 0))", 100 / math.sqrt(3 + math.sqrt(10)), more='where = "damping 1"\n'))
        self.assertEqual(("reproduced", "damping 1"), (rows["my.corner.formula"]["verdict"], rows["my.corner.formula"]["condition"]))
        self.refused(head + '[[measure]]\nname = "a"\nsignal = "i_q"\n' + claim("a", "a.mean", 1.0), None, "run", "missing")

    def test_verdicts_and_exit_codes(self):
        source = STANDING.replace("[run]", '[experiment]\nsource = "p. 3"\n[run]')
        rows = self.rows(source + claim("same", "1", 1.0) + claim("kind", "2", 1.0, more='holds_if = "value > 1"\nwhy_not = "twice"\n')
                         + claim("not", "2", 1.0, more='why_not = "twice"\n')
                         + claim("theory", "2", None, more='theory = "1 + 1"\ntolerance = 0.1\n'), 1)
        self.assertEqual(["reproduced", "reproduced in kind, because twice", "not reproduced, because twice",
                          "reproduced in kind, because the source has no number"], [row["verdict"] for row in rows.values()])
        self.assertEqual([1.0, 1.0, 1.0, None], [row["paper"] for row in rows.values()])
        rows = self.rows(STANDING + claim("a", "2", 1.0), 1)
        self.assertEqual("does not hold, because the number is another", rows["my.a.run"]["verdict"])

    def test_a_run_that_is_lost_supports_no_claim(self):
        lost = STANDING + '[[expect]]\nsignal = "plant.load_torque"\nstatistic = "max"\nat_most = "1 N m"\n'
        rows = self.rows(lost + claim("needs", "load.mean", 2.25, 1e-3) + claim("does_not", "1", 1.0), 1)
        self.assertEqual("does not hold, because the drive stopped or lost the rotor", rows["my.needs.run"]["verdict"])
        self.assertEqual("holds", rows["my.does_not.run"]["verdict"])

    def test_data_of_an_experiment(self):
        trace = '[trace]\nevery = 2\nreference = {name = "asked", signal = "speed_request", unit = "r/min"}\ncolumn = [{name = "load", signal = "plant.load_torque", unit = "mN m"}]\n'
        for more, head, lines in (("", "run[text],flavour[text],lost[-],load_mean[N m]", 1), (trace, "time[s],asked[r/min],_load[mN m]", 5)):
            done = self.lagless("paper", self.write(STANDING + more + claim("a", "load.mean", 2.25, 1e-3)), "--out", "there")
            self.assertEqual(0, done.returncode, done.stderr)
            table = self.read("there/data/my.csv").splitlines()
            self.assertTrue(table[0].startswith(head), table[0])
            self.assertEqual(lines, len(table) - 1)
        self.assertEqual("0.0008,0,4000", table[-1])
        self.assertEqual("my", json.loads(self.read("there/report.json"))["figures"][0]["id"])

    # ---- what is wrong with a file ----

    def test_bad_files_are_refused_by_line_key_and_what_is_accepted(self):
        good = STANDING + claim("a", "load.mean", 2.25, 1e-3)
        for text, line, fragments in (
                (good.replace("[[measure]]", "[[mesure]]"), "[[mesure]]", ("mesure", "nearest: measure")),
                (good.replace('signal = "plant.load_torque"\n[[', 'signal = "plant.load_torqe"\n[[', 1), "torqe", ("load_torqe", "nearest: load_torque")),
                (good.replace('unit = "mN m"', 'unit = "A"'), 'unit = "A"', ("unit", "A")),
                (good.replace('from = "0.5 ms"', 'from = "2 ms"'), 'from = "2 ms"', ("from", "0 to 1 ms")),
                (good.replace('name = "some"', 'name = "load" '), 'name = "load" ', ("name", "each name once")),
                (good.replace('name = "some"', 'name = "5 N m"'), 'name = "5 N m"', ("no plain word", "letters, digits")),
                (good.replace("begin = 0.9", "begin = 2.5"), "between", ("end", "another value")),
                (good.replace("load.mean", "lod.mean"), "value = ", ("value", "claim a", "lod.mean is neither a [[measure]]")),
                (good.replace("load.mean", "load.median"), "value = ", ("no statistic", "mean, min, max, peak, sd, rms, last")),
                (good.replace("load.mean", "load.mean +"), "value = ", ("a number is missing",)),
                (good.replace("load.mean", "(load.mean"), "value = ", ("a ) is missing",)),
                (good.replace("load.mean", "max()"), "value = ", ("a number is missing",)),
                (good.replace("load.mean", "sqrt(1, 2)"), "value = ", ("sqrt takes 1 numbers, not 2",)),
                (good.replace("load.mean", "load.mean@there"), "value = ", ("no point of a sweep is called there",)),
                (good.replace("load.mean", "-" * 50 + "1"), "value = ", ("too deep",)),
                (good.replace("load.mean", "load.mean load.mean"), "value = ", ("not understood",)),
                (good.replace("tolerance = 0.001", "tolerance = -1"), "tolerance = -1", ("tolerance", "0 or more")),
                (good.replace("tolerance = 0.001\n", ""), "[[claim]]", ("tolerance", "missing")),
                (good.replace("printed = 2.25\n", ""), "[[claim]]", ("printed", "missing")),
                (good.replace('value = "load.mean"', 'measure = "lod"\nof = "mean"'), 'measure = "lod"', ("no [[measure]] is called", "nearest: load")),
                (good.replace('value = "load.mean"', 'measure = "load"'), "[[claim]]", ("measure and of, or value",)),
                (good + claim("a", "1", 1.0), None, ("each id once",)),
                (good.replace("[run]", '[begin]\nby = "hand"\n[run]'), "by =", ("dynamometer, power_on",)),
                (good.replace("[run]", '[experiment]\nuse = "papr"\n[run]'), "use =", ("nearest: paper",)),
                (good.replace("[run]", '[experiment]\ncondition = "{plant.inertai}"\n[run]'), "condition =", ("{plant.inertai}",)),
                (good.replace("[run]", '[[sweep]]\nname = "j"\nrow = "plant.inertia"\nvalues = [0.01, -1]\n[run]'), "values =", ("inertia", "accepted")),
                (good.replace("[run]", '[[sweep]]\nname = "j"\nrow = "plant.inertia"\nvalues = [0.01, 0.02]\n[run]'), "[[claim]]", ("at", 'at = {j = ')),
                (good.replace("[run]", '[[sweep]]\nname = "j"\nrow = "plant.inertia"\n[run]'), "[[sweep]]", ("values", "missing")),
                (good.replace("[run]", '[[sweep]]\nname = "j"\nrow = "plant.inertia"\nfrom = 1\nto = 2\nsteps = 2001\n[run]'), "steps =", ("2 to 2000",)),
                (good.replace("[run]", '[experiment]\nid = "../x"\n[run]'), "id =", ("part of a row's name",)),
                (good.replace("[run]", '[[sweep]]\nname = "j"\nrow = "plant.inertia"\nvalues = [1, 1]\n[run]'), "[[sweep]]", ("each name once",)),
                (good.replace('[[claim]]', '[[clam]]'), '[[clam]]', ("clam", "nearest: claim"))):
            with self.subTest(fragments=fragments):
                self.refused(text, line, *fragments)
        self.refused(good.replace("[run]", '[[sweep]]\nname = "load"\nrow = "position_source"\nvalues = ["encoder", "sensorles"]\n[run]'), "values =", "nearest: sensorless")

    def test_what_the_rig_refuses_under_way_is_told_with_its_line(self):
        # A parameter that changes only while the bridge is off.
        text = STANDING.replace("[[measure]]", '[requests]\nenable = "on"\n[[at]]\ntime = "0.3 s"\nparams.observer_switching = "sign"\n[[measure]]', 1)
        text = text.replace('"1 ms"', '"0.4 s"').replace('"0.9 ms"', '"0.2 s"').replace('"4.5 N m"', '"0.5 N m"')
        self.refused(text + claim("a", "1", 1.0), "params.observer_switching", "observer_switching")

    def test_figures_and_a_file_do_not_mix_and_a_missing_file_is_told(self):
        path = self.write(STANDING + claim("a", "1", 1.0))
        for arguments in ((path, "fig13"), ("fig13", path), (path, path)):
            done = self.lagless("paper", *arguments)
            self.assertEqual(2, done.returncode)
            self.assertIn("one file at a time", done.stderr)
        done = self.lagless("paper", "./none.toml")
        self.assertEqual(2, done.returncode)
        self.assertIn("none.toml", done.stderr)
        self.assertIn("[FIG... | FILE]", self.lagless("paper", "--help").stdout)

    # ---- scenarios of the user ----

    SCENARIO = ('schema = 1\ntitle = "mine"\n[run]\nduration = "0.6 s"\n[start]\nspeed = "400 r/min"\n[requests]\nenable = "on"\nspeed_request = "400 r/min"\n'
                '[params]\nposition_source = "encoder"\n[plant]\nload_torque = "1 N m"\n'
                '[[at]]\ntime = "0.4 s"\nplant.load_torque = "2 N m"\n'
                '[[expect]]\nname = "never fast"\nsignal = "true_omega_m"\nstatistic = "max"\nat_most = "%s"\n')

    def test_bench_of_a_scenario(self):
        path = self.write(self.SCENARIO % "600 r/min")
        told = json.loads(self.lagless("bench", path, "--seconds", "0.01", "--json").stdout)
        self.assertEqual(path, told["scenario"])
        self.assertGreater(told["averaged_x_realtime"], 0)
        self.assertNotIn("estimator_ns_worst", told)
        done = self.lagless("bench", "stuck_sensor", "--seconds", "0.01")
        self.assertEqual(2, done.returncode)
        self.assertIn("its state is fault", done.stderr)
        self.assertIn("[SCENARIO]", self.lagless("bench", "--help").stdout)

    def test_campaign_around_a_scenario_finds_what_it_expects_and_reproduces_it(self):
        path = self.write(self.SCENARIO % "600 r/min")
        told = json.loads(self.lagless("campaign", "--scenario", path, "--runs", "6", "--json").stdout)
        self.assertEqual((6, 0, 0.6, 0), (told["done"], told["violated"], told["seconds"], told["faults"]))
        path = self.write(self.SCENARIO % "200 r/min")  # it begins at 400
        done = self.lagless("campaign", "--scenario", path, "--runs", "2", "--out", "found")
        self.assertEqual(1, done.returncode, done.stderr)
        self.assertIn("violated  2, of which 2 failed again", done.stdout)
        again = self.lagless("run", "found/run-000000.toml")
        self.assertEqual(1, again.returncode)
        self.assertIn("never fast", again.stdout)
        self.assertIn("plant.load_torque = 2", self.read("found/run-000000.toml"))
        merged = self.lagless("campaign", "merge", "found")
        self.assertEqual(2, merged.returncode)
        self.assertIn("--scenario", merged.stderr)
        self.assertEqual(1, self.lagless("campaign", "--scenario", path, "merge", "found").returncode)
        wrong = self.lagless("campaign", "--scenario", path, "--seconds", "1")
        self.assertEqual(2, wrong.returncode)
        self.assertIn("not with --scenario", wrong.stderr)

    def test_errors_drawn_around_a_scenario_are_of_its_plant_alone(self):
        path = self.write(self.SCENARIO % "200 r/min")
        self.lagless("campaign", "--scenario", path, "--runs", "1", "--out", "found")
        text = self.read("found/run-000000.toml")
        # made as small as it gets: what fails needs no error at all
        self.assertNotIn("resistance", text)
        self.assertNotIn("[params]\nmotor", text)
        self.assertIn("at_most", text)

    def test_matrix_in_a_scenario(self):
        path = self.write(self.SCENARIO % "600 r/min")
        done = self.lagless("matrix", "--scenario", path, "--at", "0.3 s", "--only", "stuck_a_rail", "--json")
        self.assertEqual(0, done.returncode, done.stderr)
        cell, = json.loads(done.stdout)["cells"]
        self.assertEqual(("stuck_a_rail/scenario/encoder", "scenario", "run_fast", "opens"),
                         (cell["cell"], cell["manoeuvre"], cell["promised_as"], cell["seen"]["reaction"]))
        self.assertLessEqual(cell["seen"]["gates_off_ms"], 1.0)
        for arguments, fragment in ((("--at", "0.7 s"), "less than the duration"), (("--at", "0.01 s"), "the drive is not on"),
                                    ((), "one needs the other"), (("--at", "0.3 s", "--cell", "x"), "a cell a fault"),
                                    (("--at", "0.3 s", "--only", "pole_pairs"), "wrong from the beginning"), (("--at", "soon"), "1.5 s")):
            done = self.lagless("matrix", "--scenario", path, *arguments)
            self.assertEqual(2, done.returncode, arguments)
            self.assertIn(fragment, done.stderr)
        self.assertIn("--scenario", self.lagless("matrix", "--help").stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
