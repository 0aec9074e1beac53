#!/usr/bin/env python3
"""Experiments as files, and the commands that take a scenario of the user: `lagless paper FILE`, bench, campaign, matrix.

The example of docs/experiments.md is run, and its output is compared with the page; all other expected values follow from algebra."""
import json
import math
import re
import sys
import unittest

import command_line
from command_line import document

PAGE = document("docs/experiments.md")

# A simulation at standstill for 10 periods per point; the load goes from 0 to 4.5 N m in steps of 0.5 N m.
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


class Test(command_line.TestCase):
    def lagless(self, *arguments):
        return command_line.lagless(*arguments, cwd=self.folder, timeout=120)

    def write(self, text, name="my.toml"):
        super().write(name, text)
        return "./" + name

    def rows(self, text, exit_code=0):
        done = self.lagless("paper", self.write(text), "--json")
        self.assertEqual(exit_code, done.returncode, done.stdout + done.stderr)
        return {row["id"]: row for row in json.loads(done.stdout)}

    def refused(self, text, place, *fragments):
        """`place` is a text in the line that the message names."""
        line = text[:text.index(place)].count("\n") + 1 if place else None
        done = self.lagless("paper", self.write(text))
        self.expect(2, done, f"./my.toml:{line}:" if line else "./my.toml:", *fragments)

    # ---- the page ----

    def test_the_example_of_the_page_prints_what_the_page_shows(self):
        example, = re.findall(r"```toml\n# load_step\.toml\n(.*?)```", PAGE, re.S)
        output, = re.findall(r"```text\n(.*?)```", PAGE, re.S)
        done = self.lagless("paper", self.write(example, "load_step.toml"))
        self.assertEqual(output, done.stdout)
        self.assertEqual(0, done.returncode)
        ours = {row["id"]: row["ours"] for row in self.rows(example, 0).values()}
        self.assertAlmostEqual(1.0, ours["my.current.run"], delta=0.02)  # follows from the torque balance

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
        scenario = document("host_sim/scenarios/load_step.toml")
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

    # A grid of three inertias, 1, 2 and 4 kg m^2, and two ends of the load.
    GRID = STANDING.replace("[[measure]]", '[[sweep]]\nname = "j"\nrow = "plant.inertia"\nvalues = [1, 2, 4]\nnames = ["a", "b", "c"]\n'
                            '[[sweep]]\nname = "end"\n[[sweep.point]]\nname = "low"\nnumber = 3\n[[sweep.point]]\nname = "high"\nnumber = 5\n'
                            'at = [{time = "0.9 ms", plant.load_torque = 9}]\n[[measure]]', 1)

    def test_functions_go_over_points(self):
        cases = {"sum(j for j)": 7.0, "sum(j for j, end)": 14.0, "mean(j for j)": 7 / 3, "max(j for j if j < 3)": 2.0, "min(-j for j)": -4.0,
                 "worst(j - 3 for j)": -2.0, "sum(load.last for end)": 13.5, "sum(load.last > 5 for j, end)": 3.0,
                 "sum(end * j for j, end if j <= 2 and end > 4)": 15.0, "j@c - j + end@high": 8.0,
                 "sum(j - j@before(j) for j if j > 1)": 3.0, "sum(j >= j@before(j) for j)": 2.0, "sum(j@before(j)@before(j) < 2 for j)": 1.0,
                 "lowest_at(j, (j - 2.2) * (j - 2.2) for j)": 2.2, "lowest_at(1, 4, 2, 1, 5, 10)": 2.5,
                 "max(j for j if j < max(j for j))": 2.0, "sum(plant.inertia@a for j)": 3.0, "sum(lost for j, end)": 0.0,
                 "sum(1 for j if 1 > 2)": 0.0}
        text = self.GRID + "".join(claim(f"c{n}", text, number, more='at = {j = "a", end = "low"}\n') for n, (text, number) in enumerate(cases.items()))
        rows = self.rows(text)
        for n, (text, number) in enumerate(cases.items()):
            self.assertAlmostEqual(number, rows[f"my.c{n}.run"]["ours"], places=6, msg=text)
            self.assertEqual("holds", rows[f"my.c{n}.run"]["verdict"], text)

    def test_of_no_points_and_at_the_grid_s_end_there_is_nothing_to_measure(self):
        for value in ("min(j for j if 1 > 2)", "max(j for j if 1 > 2)", "mean(j for j if 1 > 2)", "worst(j for j if 1 > 2)", "lowest_at(j, j for j)",
                      "j@before(j)", "load.mean@before(j)", "sum(j - j@before(j) for j)"):
            row, = self.rows(self.GRID + claim("a", value, 1.0, more='at = {j = "a", end = "low"}\n'), 1).values()
            self.assertEqual((None, "does not hold, because there is nothing to measure"), (row["ours"], row["verdict"]), value)

    def test_what_a_for_goes_over_needs_no_point(self):
        row, = self.rows(self.GRID + claim("a", "sum(j for j, end)", 14.0)).values()
        self.assertEqual("holds", row["verdict"])
        self.refused(self.GRID + claim("a", "sum(j for j)", 7.0), "[[claim]]", "it names no point of the sweep end", 'at = {end = "low"}')

    def test_lost_runs_are_counted_and_stop_no_claim(self):
        text = self.GRID + '[[expect]]\nsignal = "plant.load_torque"\nstatistic = "max"\nat_most = "8 N m"\n'
        rows = self.rows(text + claim("count", "sum(lost for j, end)", 3.0) + claim("one", "lost", 1.0, more='at = {j = "a", end = "high"}\n')
                         + claim("which", "min(end for j, end if lost)", 5.0)
                         + claim("needs", "load.last", 9.0, more='at = {j = "a", end = "high"}\n'), 1)
        self.assertEqual(["holds"] * 3 + ["does not hold, because the drive stopped or lost the rotor"], [row["verdict"] for row in rows.values()])

    def test_points_go_only_with_those_they_name(self):
        text = self.GRID.replace("number = 5", 'number = 5\nonly = {j = ["a", "c"]}').replace("[run]", '[experiment]\neach = ["high", "low"]\n[run]')
        text += claim("runs", "sum(1 for j, end)", 5.0) + claim("low", "load.last", 4.5, more='each = "low"\nat = {j = "b"}\n')
        text += claim("before", "sum(load.last@before(j) for j if j > 3)", 4.5, more='each = ["low"]\n')
        rows = self.rows(text)
        self.assertEqual(["my.runs.high", "my.runs.low", "my.low.low", "my.before.low"], list(rows))
        self.assertEqual({"holds"}, {row["verdict"] for row in rows.values()})
        done = self.lagless("paper", self.write(text), "--force", "--out", "there")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertEqual([("a", "low"), ("b", "low"), ("c", "low"), ("a", "high"), ("c", "high")],
                         [(run["name"], run["flavour"]) for run in json.loads(self.read("there/report.json"))["figures"][0]["runs"]])
        self.refused(text + claim("none", "load.last", 9.0, more='at = {j = "b"}\n'), None, "there is no run at b, high", "each = [...]")
        self.refused(text + claim("none", "load.last@high", 9.0, more='each = "low"\nat = {j = "b"}\n'), "load.last@high", "there is no run at these points")

    def test_seeds_are_a_sweep(self):
        measure = '[[measure]]\nname = "noise"\nsignal = "i_a"\n'
        sweep = '[[sweep]]\nname = "seed"\nrow = "run.seed"\nvalues = [3, 1, 7]\n'
        swept = self.rows(STANDING + measure + sweep + "".join(claim(f"s{n}", "noise.sd", 0.0, 1e9, f'at = {{seed = "{n}"}}\n') for n in (1, 3, 7)))
        for seed in (1, 3, 7):
            alone, = self.rows(STANDING.replace("[run]\n", f"[run]\nseed = {seed}\n") + measure + claim("a", "noise.sd", 0.0, 1e9)).values()
            self.assertEqual(alone["ours"], swept[f"my.s{seed}.run"]["ours"])
        self.assertEqual(3, len({row["ours"] for row in swept.values()}))
        steps = sweep.replace("values = [3, 1, 7]", "from = 1\nto = 9\nsteps = 5")
        self.assertEqual([25.0], [row["ours"] for row in self.rows(STANDING + measure + steps + claim("a", "sum(seed for seed)", 25.0)).values()])

    def test_durations_of_whole_turns(self):
        # At 100 r/min and four pole pairs a turn takes 0.15 s; a window of 0.2 s becomes two turns, and 0.3 s are two turns already. At
        # 1013 r/min 34 turns are 0.503455 s.
        for speed, duration, periods in (("100 r/min", "0.2 s", 3000), ("100 r/min", "0.3 s", 3000), ("-1013 r/min", "0.5 s", 5035)):
            text = STANDING.replace('"1 ms"', f'"{duration}"').replace("[[at]]", f'[experiment]\nwhole_turns = true\n[requests]\nspeed_request = "{speed}"\n[[at]]', 1)
            text += '[trace]\ncolumn = [{name = "load", signal = "plant.load_torque"}]\n' + claim("a", "load.last", 4.5)
            done = self.lagless("paper", self.write(text), "--force", "--out", "turns")
            self.assertEqual(0, done.returncode, done.stderr + done.stdout)
            self.assertEqual(periods, len(self.read("turns/data/my.csv").splitlines()) - 1)

    def test_a_table_of_expressions(self):
        table = ('[table]\nlines = ["j"]\ncolumn = [{name = "inertia", sweep = "j"}, {name = "J", unit = "kg m^2", value = "j"},'
                 ' {name = "most", unit = "N m", value = "max(load.last for end)"}, {name = "step", unit = "kg m^2", value = "j - j@before(j)"}]\n')
        done = self.lagless("paper", self.write(self.GRID + table + claim("a", "1", 1.0, more='at = {j = "a", end = "low"}\n')), "--force", "--out", "table")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertEqual(["inertia[text],J[kg m^2],most[N m],step[kg m^2]", "a,1,9,", "b,2,9,1", "c,4,9,2"], self.read("table/data/my.csv").splitlines())

    def test_texts_are_filled_in(self):
        text = self.GRID.replace('number = 3', 'number = 3\ntext = "J {j}, {plant.inertia} kg m^2"').replace(
            "[run]", '[experiment]\nsource = "p. 3"\ncondition = "{end}; {position_source}; {load.last} N m"\n[run]')
        row, = self.rows(text + claim("a", "load.last", 1.0, more='at = {j = "b", end = "low"}\nholds_if = "value > 1"\n'
                                      'where = "of {sum(1 for j)}"\nwhy_not = "it is {value - 1} more"\n')).values()
        self.assertEqual("of 3; J 2 kg m^2, 2 kg m^2; sensorless; 4.5 N m", row["condition"])
        self.assertEqual("reproduced in kind, because it is 3.5 more", row["verdict"])

    def test_named_expressions(self):
        let = '[let]\ntwice = "2 * j"\nall = "sum(twice for j)"\n'
        rows = self.rows(self.GRID + let + "".join(claim(f"c{n}", text, number, more='at = {j = "b", end = "low"}\n') for n, (text, number) in enumerate(
            {"twice": 4.0, "twice@c": 8.0, "all": 14.0, "all / twice@a": 7.0, "sum(twice@before(j) for j if j > 1)": 6.0}.items())))
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
        self.assertEqual("does not hold, because the number is different", rows["my.a.run"]["verdict"])

    def test_a_run_that_is_lost_supports_no_claim(self):
        lost = STANDING + '[[expect]]\nsignal = "plant.load_torque"\nstatistic = "max"\nat_most = "1 N m"\n'
        rows = self.rows(lost + claim("needs", "load.mean", 2.25, 1e-3) + claim("does_not", "1", 1.0), 1)
        self.assertEqual("does not hold, because the drive stopped or lost the rotor", rows["my.needs.run"]["verdict"])
        self.assertEqual("holds", rows["my.does_not.run"]["verdict"])

    def test_data_of_an_experiment(self):
        trace = '[trace]\nevery = 2\nreference = {name = "asked", signal = "speed_request", unit = "r/min"}\ncolumn = [{name = "load", signal = "plant.load_torque", unit = "mN m"}]\n'
        for more, head, lines in (("", "run[text],flavour[text],lost[-],load_mean[N m]", 1), (trace, "time[s],asked[r/min],_load[mN m]", 5)):
            done = self.lagless("paper", self.write(STANDING + more + claim("a", "load.mean", 2.25, 1e-3)), "--force", "--out", "there")
            self.assertEqual(0, done.returncode, done.stderr)
            table = self.read("there/data/my.csv").splitlines()
            self.assertTrue(table[0].startswith(head), table[0])
            self.assertEqual(lines, len(table) - 1)
        self.assertEqual("0.0008,0,4000", table[-1])
        self.assertEqual("my", json.loads(self.read("there/report.json"))["figures"][0]["id"])

    # ---- mistakes in a file ----

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
                (good.replace("load.mean", "load.mean load.mean"), "value = ", ("cannot be read",)),
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
        good = self.GRID + claim("a", "load.mean", 2.25, 1e-3, 'at = {j = "a", end = "low"}\n')
        seeds = '[[sweep]]\nname = "s"\nrow = "run.seed"\n%s\n[run]'
        table = good + '[table]\nlines = ["j"]\ncolumn = [{name = "J", unit = "kg m^2", value = "j"}]\n'
        let = good + '[let]\nmine = "load.mean"\n'
        turns = good.replace("[run]", "[experiment]\nwhole_turns = true\n[run]")
        text = good.replace("[run]", '[experiment]\ncondition = "{end}"\n[run]').replace("number = 3", 'number = 3\ntext = "{j}"')
        for text, line, fragments in (
                (good.replace("load.mean", "sum(1 for jj)"), "value = ", ('no sweep is called "jj"', "for SWEEP, SWEEP if")),
                (good.replace("load.mean", "sum(1, 2 for j)"), "value = ", ("sum takes 1 number of each point", "sum(X for SWEEP)")),
                (good.replace("load.mean", "lowest_at(1 for j)"), "value = ", ("lowest_at takes 2 numbers of each point", "lowest_at(X, Y for SWEEP)")),
                (good.replace("load.mean", "lowest_at(1, 2)"), "value = ", ("lowest_at takes 6 or more numbers, not 2",)),
                (good.replace("load.mean", "sqrt(1 for j)"), "value = ", ("sqrt does not combine points", "sum, mean, max, min, worst, lowest_at")),
                (good.replace("load.mean", "sum(1 for j"), "value = ", ("a ) is missing",)),
                (good.replace("load.mean", "sum(1 for j if)"), "value = ", ("a ) is missing",)),
                (good.replace("load.mean", "sum(nothing for j if 1 > 2)"), "value = ", ('"nothing" is no number', "a sweep", "lost")),
                (good.replace("load.mean", "load.mean@before(jj)"), "value = ", ('no sweep is called "jj"', "@before(SWEEP)")),
                (good.replace("number = 3\n", "").replace("load.mean", "end"), "value = ", ("the point low of the sweep end has no number",)),
                (good.replace("number = 3", 'number = "3"'), "number = ", ("number", "accepted: a number")),
                (good.replace("number = 3", "only = 3"), "only = ", ("only", "a table")),
                (good.replace("number = 3", 'only = {k = "a"}'), "only = ", ("names of the other sweeps",)),
                (good.replace("number = 3", 'only = {end = "low"}'), "only = ", ("names of the other sweeps",)),
                (good.replace("number = 3", 'only = {j = "d"}'), "only = ", ("no point of the sweep", "a, b, c")),
                (good.replace("number = 3", 'only = {k = "x"}').replace("[[sweep]]", '[[sweep]]\nname = "k"\n[[sweep.point]]\nname = "x"\nonly = {end = "high"}\n[[sweep]]', 1).replace(
                    "number = 5", 'only = {k = "y"}').replace('only = {end = "high"}\n', 'only = {end = "high"}\n[[sweep.point]]\nname = "y"\nonly = {end = "low"}\n'),
                 "[[sweep]]", ("no points can be combined",)),
                (good.replace('at = {j = "a"', 'each = "low"\nat = {j = "a"'), "each = ", ("[experiment] has no each",)),
                (good.replace("[run]", '[experiment]\neach = "low"\n[run]').replace('at = {j = "a", end = "low"}', 'each = "high"\nat = {j = "a"}'), 'each = "high"',
                 ("no such name in [experiment] each",)),
                (good.replace('name = "end"', 'name = "j"'), 'name = "j"\n[[sweep.point]]', ("another [[sweep]] has this name", "each name once")),
                (good.replace("[run]", seeds % "values = [1.5]"), "values = [1.5]", ("whole number",)),
                (good.replace("[run]", seeds % "values = [-1]"), "values = [-1]", ("0 to",)),
                (good.replace("[run]", seeds % "from = 1\nto = 2\nsteps = 3"), "from = 1", ("a step is no whole number", "seeds, as 1, 2, 3")),
                (turns.replace("= true", "= 1"), "whole_turns", ("whole_turns", "accepted: a bool")),
                (turns, "whole_turns", ("speed_request is 0 at t = 0", "a speed that makes turns")),
                (table.replace('lines = ["j"]', 'lines = ["jj"]'), "lines = ", ('no sweep is called "jj"', "j, end")),
                (table.replace('unit = "kg m^2", ', ""), "column = ", ("unit", "missing")),
                (table.replace('value = "j"', 'sweep = "k"').replace('unit = "kg m^2", ', ""), "column = ", ('no sweep is called "k"', "j, end")),
                (table.replace(', value = "j"', ""), "column = ", ("unit and value, or sweep",)),
                (table.replace('value = "j"', 'value = "k"'), "column = ", ("of the column J", '"k" is no number')),
                (table.replace("column = [", "column = [] #"), "[table]", ("there are 0 columns", "1 to 16")),
                (table + '[trace]\ncolumn = [{name = "load", signal = "plant.load_torque"}]\n', "[table]", ("the file has a [trace]", "one of them")),
                (let.replace("mine", '"5 N m"'), '"5 N m" =', ("no plain word",)),
                (let.replace("mine =", "lost ="), "lost = ", ("lost", "already has a meaning in expressions")),
                (let.replace("mine =", "end ="), "end = \"load", ("end", "already has a meaning in expressions")),
                (let.replace('mine = "load.mean"', "mine = 5"), "mine = ", ("mine", "accepted: text")),
                (let.replace('mine = "load.mean"', 'mine = "lod.mean"'), "mine = ", ("mine", "lod.mean is neither")),
                (let.replace('mine = "load.mean"', 'mine = "mine + 1"'), "mine = ", ("mine", "too deep")),
                (text.replace('values = [1, 2, 4]\nnames = ["a", "b", "c"]', '').replace('row = "plant.inertia"', '[[sweep.point]]\nname = "a"\ntext = "{end}"'),
                 "condition = ", ("refer to each other in a circle",)),
                (good.replace('at = {j', 'where = "{load.men}"\nat = {j'), "where = ", ("of claim a", "{load.men}", "no statistic")),
                (good.replace('at = {j', 'why_not = "{nothing}"\nat = {j'), "why_not = ", ("of claim a", "{nothing}"))):
            with self.subTest(fragments=fragments):
                self.refused(text, line, *fragments)
        self.refused(good.replace("[run]", '[[sweep]]\nname = "load"\nrow = "position_source"\nvalues = ["encoder", "sensorles"]\n[run]'), "values =", "nearest: sensorless")

    def test_what_the_rig_refuses_under_way_is_reported_with_its_line(self):
        # The scenario sets a parameter that may change only while the bridge is off.
        text = STANDING.replace("[[measure]]", '[requests]\nenable = "on"\n[[at]]\ntime = "0.3 s"\nparams.observer_switching = "sign"\n[[measure]]', 1)
        text = text.replace('"1 ms"', '"0.4 s"').replace('"0.9 ms"', '"0.2 s"').replace('"4.5 N m"', '"0.5 N m"')
        self.refused(text + claim("a", "1", 1.0), "params.observer_switching", "observer_switching")

    def test_figures_and_a_file_do_not_mix_and_a_missing_file_is_reported(self):
        path = self.write(STANDING + claim("a", "1", 1.0))
        for arguments in ((path, "fig13"), ("fig13", path), (path, path)):
            self.expect(2, self.lagless("paper", *arguments), "accepted: one file")
        self.expect(2, self.lagless("paper", "./none.toml"), "none.toml")
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
        self.expect(2, self.lagless("bench", "stuck_sensor", "--seconds", "0.01"), "its state is fault")
        self.assertIn("[SCENARIO]", self.lagless("bench", "--help").stdout)

    def test_campaign_around_a_scenario_finds_what_it_expects_and_reproduces_it(self):
        path = self.write(self.SCENARIO % "600 r/min")
        told = json.loads(self.lagless("campaign", "--scenario", path, "--runs", "6", "--json").stdout)
        self.assertEqual((6, 0, 0.6, 0), (told["done"], told["violated"], told["seconds"], told["faults"]))
        path = self.write(self.SCENARIO % "200 r/min")  # the scenario begins at 400 r/min
        self.expect(1, self.lagless("campaign", "--scenario", path, "--runs", "2", "--out", "found"), "violated  2, of which 2 failed again")
        self.expect(1, self.lagless("run", "found/run-000000.toml"), "never fast")
        self.expect(2, self.lagless("campaign", "merge", "found"), "--scenario")
        self.expect(1, self.lagless("campaign", "--scenario", path, "merge", "found"))
        self.expect(2, self.lagless("campaign", "--scenario", path, "--seconds", "1"), "--seconds cannot be used with --scenario")
        text = self.read("found/run-000000.toml")
        self.assertIn("plant.load_torque = 2", text)
        self.assertIn("at_most", text)
        # The scenario is fully minimised: the failure needs no error of the plant or of the assumed values.
        self.assertNotIn("resistance", text)
        self.assertNotIn("[params]\nmotor", text)

    def test_matrix_in_a_scenario(self):
        path = self.write(self.SCENARIO % "600 r/min")
        done = self.lagless("matrix", "--scenario", path, "--at", "0.3 s", "--only", "stuck_a_rail", "--json")
        self.assertEqual(0, done.returncode, done.stderr)
        matrix = json.loads(done.stdout)
        cell, = matrix["cells"]
        self.assertRegex(matrix["manoeuvres"][0]["text"], "faults at 0.3 s; promised as in run_fast, encoder$")
        self.assertEqual(("stuck_a_rail/scenario/encoder", "scenario", "run_fast", "opens"),
                         (cell["cell"], cell["manoeuvre"], cell["promised_as"], cell["seen"]["reaction"]))
        self.assertLessEqual(cell["seen"]["gates_off_ms"], 1.0)
        for arguments, fragment in ((("--at", "0.7 s"), "less than the duration"), (("--at", "0.01 s"), "the drive is not on"),
                                    ((), "--scenario and --at must be given together"), (("--at", "0.3 s", "--cell", "x"), "one cell for each fault"),
                                    (("--at", "0.3 s", "--only", "pole_pairs"), "present from the beginning"), (("--at", "soon"), "1.5 s")):
            self.expect(2, self.lagless("matrix", "--scenario", path, *arguments), fragment)
        self.assertIn("--scenario", self.lagless("matrix", "--help").stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
