"""The command line: exit codes, messages, JSON, interruption. usage: test_cli.py LAGLESS FOLDER FAULT_ROWS"""

import glob
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest

try:
    import tomllib
except ImportError:
    tomllib = None

from command_line import FEW_POINTS, LAGLESS, NO_PICTURES, ROOT, TestCase, document, lagless

FAULT_ROWS = sys.argv[3]

KEPT = 341  # periods that each of the twelve rows keeps of a fault: CAPTURE_SLOTS / 12

REACHED = """[[expect]]
signal = "true_omega_m"
statistic = "last"
at_least = "%s"
"""


def runs_under_valgrind():
    """Whether the program can run under valgrind: not without valgrind, and not in a build with sanitizers."""
    try:
        return subprocess.run(["valgrind", LAGLESS, "--version"], capture_output=True).returncode == 0
    except FileNotFoundError:
        return False


class CommandLine(TestCase):
    def scenario(self, at_least="-10 r/min", **settings):
        return super().scenario(REACHED % at_least, **settings)

    def test_met_expectations_give_0_and_failed_ones_1_and_valid_json(self):
        met = lagless("run", self.scenario())
        self.expect(0, met, "met")
        self.assertNotIn("\033", met.stdout)  # no colours in a pipe
        self.expect(1, lagless("run", self.scenario(at_least="5000 r/min")), "FAILED", "at least 5000 r/min")
        done = lagless("run", self.scenario(at_least="5000 r/min"), "--json")
        self.assertEqual(1, done.returncode)
        result = json.loads(done.stdout)
        self.assertEqual("failed", result["expectations"][0]["verdict"])
        self.assertEqual((1, 2000), (result["failed"], result["periods"]))
        self.assertNotIn("error", result)  # this result is no error

    def test_json_reports_the_end_after_all_other_lines(self):
        for arguments, manoeuvre, reason in (([self.scenario(at_least="-100 r/min"), "--set", "plant.dc_voltage=150 V"], "off", "dc_undervoltage"),
                                             ([self.scenario(at_least="-100 r/min"), "--set", "position_source=sensorless"], "align", None), (["quick_stop"], "off", None)):
            result = json.loads(lagless("run", *arguments, "--json").stdout)
            self.assertEqual(["files", "manoeuvre", "not_on", "measures"], list(result)[-4:])
            self.assertEqual(manoeuvre, result["manoeuvre"])
            self.assertEqual(reason, result["not_on"] and result["not_on"]["reason"])
            if reason:
                self.assertEqual("check supply and precharge", result["not_on"]["remedy"])

    def test_explain_shows_every_row_of_the_fault_table(self):
        rows = [line.split("\t") for line in subprocess.run([FAULT_ROWS], capture_output=True, text=True).stdout.splitlines()]
        reasons = {reason["name"]: reason for reason in json.loads(lagless("explain", "--json").stdout)["reasons"]}
        self.assertEqual({row[1] for row in rows}, {name for name, reason in reasons.items() if reason["fault"]})
        moments = {"ALWAYS": "always", "RUNNING": "while the gates are commanded on",
                   "ENCODER": "while the gates are commanded on and control uses the encoder",
                   "TRACKING": "while the gates are commanded on and control uses the estimate, except in reversals",
                   "SUPPLIED": "while the gates are commanded on and no ride-through is active"}
        reactions = {"WARN": "shown in warnings while it holds",
                     "CATCH": "the rotor is caught again; lost three times within 2 s, or in start_tries consecutive runs of less than 0.5 s, it is a fault",
                     "STOP": "the motor is braked to standstill, then the bridge opens, the fault is latched",
                     "OPEN": "the bridge opens, the fault is latched"}
        self.assertEqual(set(moments), {row[10] for row in rows})
        self.assertLessEqual({row[11] for row in rows}, set(reactions))
        kinds = set()
        for number, name, quantity, comparison, limit, margin, value, unit, debounce, debounce_ms, when, reaction, rate in rows:
            self.assertEqual(int(number), reasons[name]["number"])
            self.assertEqual({
                "quantity": quantity, "comparison": comparison, "limit": limit or None, "margin": float(margin),
                "default": float(value) if limit else None, "unit": unit or None, "rate": rate, "debounce_periods": int(debounce),
                "debounce_ms": float(debounce_ms), "when": when, "reaction": reaction}, reasons[name]["fault"])
            kind = {comparison, when, reaction, rate, "limit" if limit else "none"}
            if kind <= kinds:
                continue
            kinds |= kind  # each word is reported once, without others
            for wish in (name, number):
                self.assertEqual(reasons[name], json.loads(lagless("explain", wish, "--json").stdout))
            text = lagless("explain", name).stdout
            told = {line.split(":", 1)[0].strip(): line.split(":", 1)[1].strip() for line in text.splitlines()[1:]}
            self.assertTrue(told["must hold for"].startswith(debounce + " period"), text)
            self.assertTrue(told["must hold for"].endswith(" %g ms" % float(debounce_ms) + (", judged every 8 periods" if rate == "SLOW" else "")), text)
            self.assertEqual(reactions[reaction], told["reaction"])
            self.assertEqual(moments[when], told["judged"])
            for part in (quantity, limit, {"ABOVE": " > ", "BELOW": " < ", "HOLDS": ""}[comparison]):
                self.assertIn(part, told["condition"])

    def test_bench_counts_instructions_of_the_estimator(self):
        done = lagless("bench", "--seconds", "0.01", "--json")
        self.expect(0, done)
        result = json.loads(done.stdout)
        for key in ("switched_x_realtime", "averaged_x_realtime", "isr_ns", "estimator_ns", "estimator_ns_worst"):
            self.assertGreater(result[key], 0.0, key)
        typical, worst = result["estimator_instructions"], result["estimator_instructions_worst"]
        if typical is None:
            self.assertIn("not counted", done.stderr)
            self.assertIsNone(worst)
            self.assertFalse(runs_under_valgrind())
            self.skipTest(done.stderr)
        # Every step computes a sine, a cosine, a root and a hyperbolic tangent, of about ten operations each. The longest step computes
        # also the adaptation, two low-passes and one more root, which are more than thirty operations.
        self.assertGreater(typical, 50)
        self.assertGreater(worst, typical + 30)

    def test_bench_reports_the_instructions_of_a_step_or_why_it_has_not_counted_them(self):
        """A shell script replaces valgrind; its arguments end with --replay estimator or --replay empty. The instructions of the loop and
        of the call are subtracted, and the rest is divided by 20000 steps."""
        count = 'case "$*" in *" --replay empty") n=140000 ;; *" --replay estimator") n=4140000 ;; esac\necho "==12== Collected : $n" >&2\n'
        failed = "not counted: this build does not run under valgrind"
        for script, number, said in ((None, None, "not counted: valgrind is not installed"), (count, 200.0, ""),
                                     ("echo '==12== Collected : 5' >&2\nexit 1\n", None, failed),
                                     ("echo '==12== Collected : 0' >&2\n", None, failed)):
            if script:
                os.chmod(self.write("valgrind", "#!/bin/sh\n" + script), 0o755)
            done = lagless("bench", "--seconds", "0.01", "--json", env={**os.environ, "PATH": self.folder})
            self.expect(0, done, said)
            told = json.loads(done.stdout)
            self.assertEqual((number, number is None), (told["estimator_instructions"], done.stderr != ""))
            self.assertGreater(told["estimator_ns"], 0.0)

    def test_map_is_a_list_of_points_with_these_keys_and_a_table_with_verdicts(self):
        """One run tests both: the picture cannot be made, and the points are kept."""
        done = lagless("map", "--ideal", "--averaged", "--speeds", "300", "--adaptation", "off", "--out", self.folder,
                       env={**os.environ, "LAGLESS_PYTHON": "/bin/false"})
        self.expect(3, done, "no picture was drawn", "map.json", "L +20 %", "theory", "met     L wrong", "met     psi_f, R wrong",
                    "no such point", "forward, off")
        self.assertEqual(2, done.stdout.count("nominal   "))
        self.assertNotIn("forward, on", done.stdout)
        points = json.loads(self.read("map.json"))
        self.assertEqual(7 * 2 * 2, len(points))
        for point in points:
            self.assertEqual(["rpm", "load_nm", "deviation", "adaptation", "mean_mrad", "sd_mrad", "peak_mrad", "locked"], list(point)[:8])
            self.assertIs(True, point["locked"])
            self.assertIsNotNone(point["theory_mrad"])
            self.assertAlmostEqual({"L +20 %": 0.015, "L -20 %": 0.01}.get(point["deviation"], 0.0125), point["inductance_h"], 6)
        self.assertEqual({"nominal", "L +20 %", "L -20 %", "R +50 %", "R -50 %", "psi_f +10 %", "psi_f -10 %"},
                         {point["deviation"] for point in points})
        self.assertEqual([(0, -300), (0, 300), (5, -300), (5, 300)], [(point["load_nm"], point["rpm"]) for point in points[:4]])
        # (5 + 1.32) N m / 1.098 N m/A = 5.756 A, and -atan(2.5 mH 5.756 A / 0.183 Wb) = -78.5 mrad; the limit of the difference from theory
        # is 2 mrad.
        turned, = (p["mean_mrad"] for p in points if (p["deviation"], p["rpm"], p["load_nm"]) == ("L +20 %", 300, 5))
        self.assertAlmostEqual(-78.5, turned, delta=2.0)

    def test_map_of_a_scenario_is_at_its_speeds_and_loads_and_reports_its_title(self):
        path = self.write("my.toml", FEW_POINTS)
        done = lagless("map", path)
        self.expect(0, done, "My drive", "700 r/min, 3 N m", "met     the rotor is not lost at any point: none of ", "forward, off", "forward, on")
        self.assertEqual(1, done.stdout.count("nominal   "))
        self.assertRegex(done.stderr, r"^\d+ points in [\d.]+ s\n$")  # without a terminal there is no progress bar
        self.refuses((["map", path, "--speeds", "700,2500"], path + ": ", "speed_request", "2500 r/min"),
                     (["map", path, "--ideal"], "--ideal", "cannot be used with a scenario"), (["map", path, path], "a second scenario; accepted: one"))

    def campaign(self, *arguments, **settings):
        return lagless("campaign", "--runs", "12", "--seed", "3", "--seconds", "0.1", *arguments, **settings)

    def test_campaign_reports_what_was_run_and_its_exit_code_whether_anything_was_violated(self):
        done = self.campaign("--json")
        told = json.loads(done.stdout)
        self.assertEqual({"seed", "runs", "done", "seconds", "quantities", "events", "faults", "injected", "held", "faulted",
                          "excused", "refused", "violated", "invariants", "calm", "alarms", "alarmed", "sigma", "excuses", "reasons",
                          "refusals", "violations"}, set(told))
        self.assertEqual((3, 12, 12, 0.1), (told["seed"], told["runs"], told["done"], told["seconds"]))
        self.assertEqual(12, told["held"] + told["refused"] + told["violated"])
        self.assertEqual(told["violated"], sum(told["invariants"].values()))
        self.assertEqual(told["violated"], len(told["violations"]))
        self.assertEqual([True] * told["violated"], [violation["reproduced"] for violation in told["violations"]])
        self.assertEqual(1 if told["violated"] else 0, done.returncode)
        self.expect(done.returncode, self.campaign(), "12 of 12, seed 3, 0.1 s each", "x real time")

    def test_campaign_in_shards_merges_to_the_bytes_of_one_run_and_is_resumed_behind_a_torn_line(self):
        whole, first, second = (os.path.join(self.folder, name) for name in ("whole", "first", "second"))
        one = self.campaign("--out", whole)
        self.campaign("--out", first, "--shard", "1/2")
        self.campaign("--out", second, "--shard", "2/2")
        for extra in ([], ["--json"]):
            merged = lagless("campaign", "merge", first, second, *extra)
            self.assertEqual(one.returncode, merged.returncode)
            self.assertEqual(lagless("campaign", "merge", whole, *extra).stdout, merged.stdout)
        self.assertEqual(one.stdout, lagless("campaign", "merge", second, first).stdout)
        self.expect(1, lagless("campaign", "merge", first), "6 of 12 runs are not done")

        path = os.path.join(whole, "campaign.csv")
        with open(path, "rb") as file:
            lines = file.read().splitlines(keepends=True)
        with open(path, "wb") as file:
            file.write(b"".join(lines[:-2]) + lines[-2][:5])
        self.expect(2, self.campaign("--out", whole), path, "--resume continues it")
        again = self.campaign("--out", whole, "--resume")
        self.assertEqual(one.stdout, again.stdout)
        self.expect(again.returncode, again, "2 runs in ")
        with open(path, "rb") as file:
            self.assertEqual(sorted(lines), sorted(file.read().splitlines(keepends=True)))
        self.expect(2, lagless("campaign", "--runs", "13", "--seed", "3", "--seconds", "0.1", "--out", whole, "--resume"),
                    path + ":1:", "another campaign")
        with open(path, "wb") as file:
            file.write(lines[0] + b"1,2,\n" + lines[1])
        self.expect(2, self.campaign("--out", whole, "--resume"), path + ":2:", "no result of a run")
        with open(path, "wb") as file:
            file.write(b"something\n")
        self.expect(2, lagless("campaign", "merge", whole), path + ":1:", "no campaign of this program")

    def test_campaign_that_is_stopped_keeps_what_is_done(self):
        folder = os.path.join(self.folder, "stopped")
        path = os.path.join(folder, "campaign.csv")
        run = self.started("campaign", "--runs", "100000", "--out", folder)
        deadline = time.time() + 60
        while time.time() < deadline and not (os.path.exists(path) and os.path.getsize(path) > 200):
            time.sleep(0.05)
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=60)
        self.assertEqual(1, run.returncode, err)
        self.assertIn("runs are not done", err)
        with open(path) as file:
            lines = file.read().splitlines()
        self.assertIn("runs      %d of 100000" % (len(lines) - 2), out)

    def test_campaign_that_cannot_write_gives_3(self):
        folder = os.path.join(self.folder, "full")
        os.makedirs(folder)
        os.symlink("/dev/full", os.path.join(folder, "campaign.csv"))
        self.expect(3, self.campaign("--out", folder))

    def test_map_that_contradicts_theory_gives_1_and_a_list_all_the_same(self):
        # A load of 40 N m is more than the torque at the current limit of 10 A (1.098 N m/A), so that no point can be judged.
        done = lagless("map", self.write("my.toml", FEW_POINTS.replace("load_torque = 3", "load_torque = 40")), "--adaptation", "off", "--json")
        self.expect(1, done, "FAILED  the rotor is not lost at any point: ", "are lost, the first is ")
        self.assertNotIn("FAILED", done.stdout)
        for point in json.loads(done.stdout):
            self.assertEqual(["rpm", "load_nm", "deviation", "adaptation", "mean_mrad", "sd_mrad", "peak_mrad", "locked"], list(point))
            self.assertIs(False, point["locked"])

    def test_matrix_is_an_object_with_these_keys_and_units_and_prints_a_letter_a_cell(self):
        done = lagless("matrix", "--cell", "stuck_a_rail/off")
        self.expect(0, done, "cells: 4 pass, 0 fail")
        self.assertIn(["stuck_a_rail", "oooo"], [line.split() for line in done.stdout.splitlines()])
        done = lagless("matrix", "--cell", "stuck_a_rail/off", "--json")
        self.expect(0, done)
        matrix = json.loads(done.stdout)
        self.assertEqual({"green", "red", "never", "faults", "manoeuvres", "cells"}, set(matrix))
        self.assertEqual((4, 0, 0), (matrix["green"], matrix["red"], matrix["never"]))
        cell = matrix["cells"][0]
        self.assertEqual({"cell", "fault", "manoeuvre", "source", "shaft", "verdict", "red_by", "promised", "seen", "not_yet"}, set(cell))
        self.assertEqual("stuck_a_rail/off/encoder/h", cell["cell"])
        self.assertEqual({"text", "reaction", "reasons", "within_ms", "current_a", "rotor", "because"}, set(cell["promised"]))
        self.assertEqual({"text", "reaction", "reason", "warnings", "noticed_ms", "gates_off_ms", "current_a", "rotor",
                          "speed_rpm", "reference_rpm", "fastest_rpm"}, set(cell["seen"]))
        self.assertEqual(("opens", "bad_sample", "stands", 300), tuple(cell["seen"][key] for key in (
            "reaction", "reason", "rotor", "reference_rpm")))
        never = json.loads(lagless("matrix", "--cell", "stuck_a_rail/ramp/encoder", "--json").stdout)["cells"][0]
        self.assertEqual(("never", True), (never["verdict"], "only the manoeuvre run" in never["because"]))

    def test_matrix_reports_share_and_seed(self):
        done = lagless("matrix", "--share", "0.2", "--seed", "7", "--json")
        self.assertIn(done.returncode, (0, 1))
        self.assertIn("0.2 % of the cells, seed 7", done.stderr)
        matrix = json.loads(done.stdout)
        self.assertEqual((7, 0.2, 0), (matrix["seed"], matrix["share_percent"], matrix["never"]))
        self.assertEqual(1 if matrix["red"] else 0, done.returncode)

    def test_matrix_writes_its_page_and_keeps_its_data_without_one(self):
        done = lagless("matrix", "--cell", "stuck_a_rail/off", "--out", self.folder)
        self.expect(0, done, "matrix.html", "matrix.json")
        self.assertIn("stuck_a_rail/off/encoder/h", self.read("matrix.html"))
        os.remove(os.path.join(self.folder, "matrix.json"))
        done = lagless("matrix", "--cell", "stuck_a_rail/off", "--force", "--out", self.folder,
                       env={**os.environ, "LAGLESS_PYTHON": "/bin/false"})
        self.expect(3, done, "matrix.json")
        self.assertEqual(4, json.loads(self.read("matrix.json"))["green"])

    def test_paper_is_a_list_of_rows_with_these_keys(self):
        done = lagless("paper", "fig08", "fig12", "--json", cwd=self.folder)
        self.expect(0, done)
        rows = json.loads(done.stdout)
        for row in rows:
            self.assertEqual(["id", "claim", "paper", "ours", "unit", "verdict", "condition"], list(row))
            self.assertRegex(row["verdict"], "^(reproduced|(reproduced in kind|not reproduced), because .+)$")
        self.assertEqual({"fig08", "fig12"}, {row["id"].split(".")[0] for row in rows})
        ours = {row["id"]: row["ours"] for row in rows}
        self.assertAlmostEqual(0.32, ours["fig12.i_d.ideal"], delta=0.02)  # 4 A sin(0.08)
        self.assertEqual([], os.listdir(self.folder))  # without a folder no report is written

    def test_paper_prints_a_table_and_the_ideal_beside_the_real(self):
        done = lagless("paper", "fig12", cwd=self.folder, env=NO_PICTURES)
        self.expect(0, done, "current on the wrong axis", "not reproduced\n", "because the lag by (14)",
                    "report: report_fig12/index.html")
        self.assertEqual(["report_fig12"], os.listdir(self.folder))
        line, = (line for line in done.stdout.splitlines() if line.startswith("  i_d "))
        numbers = [float(number) for number in re.findall(r" (0\.\d+)", line)]
        self.assertEqual(3, len(numbers), line)  # the values of the paper, of this program, and the ideal ones
        for number in numbers:
            self.assertAlmostEqual(0.32, number, delta=0.008)

    def test_wrong_use_gives_2_and_says_what_is_accepted(self):
        path = self.scenario()
        self.refuses(
                ([], "Usage"), (["rnu"], "did you mean run?"), (["demo"], "lagless run encoder_speed_profile", "tools/demo"), (["run"], "no scenario is given; accepted: "),
                (["run", "load_stpe"], "did you mean load_step?"), (["run", path, "--seed", "-1"], "whole numbers 0 to"),
                (["run", path, "--set", "inertai=1"], "inertia"),
                (["run", path, "--record", "i_q"], "--out"), (["run", path, "--out", self.folder, "--record", "i_qq"], "i_q"),
                (["run", path, "--out", self.folder, "--format", "xml"], "csv, mat, vcd, mdf"),
                (["run", path, "--out", self.folder, "--every", "0"], "whole numbers 1 to"),
                (["run", path, "--out", self.folder, "--format", "vcd", "--set", "fidelity=averaged"], "switched"),
                (["run", path, path], "a second scenario; accepted: one"), (["explain", "overcurent"], "did you mean overcurrent?"),
                (["explain", "999"], "no such reason"), (["completion", "tcsh"], "bash, zsh, fish"), (["params", "no_such_row"], "no row has no_such_row"),
                (["signals", "no_such", "row_either"], "one of these words"),
                (["campaign", "--runs", "0"], "1 to 1000000"), (["campaign", "--runs", "ten"], "accepted: whole numbers"),
                (["campaign", "--seed", "-1"], "accepted: whole numbers"), (["campaign", "--seconds", "0.01"], "0.1 to 3600"),
                (["campaign", "--seconds", "2x"], "0.1 to 3600"), (["campaign", "--shard", "0/2"], "accepted: I/N"),
                (["campaign", "--shard", "3/2"], "accepted: I/N"), (["campaign", "--shard", "1"], "accepted: I/N"),
                (["campaign", "--runs", "3", "--shard", "1/4"], "more shards than runs; accepted: N up to 3"),
                (["campaign", "--resume"], "--out FOLDER"), (["campaign", "split"], "accepted: `merge FOLDER...`, or none"),
                (["campaign", "merge"], "no folder is given; accepted: "), (["campaign", "merge", "x", "--runs", "3"], "accepted: folders"),
                (["campaign", "merge", "no_such"], "no_such/campaign.csv"),
                (["map", "no_such"], "neither a file nor a scenario of the library; `lagless scenarios` lists them"),
                (["matrix", "--only", "xyz"], "no such fault; accepted: "), (["map", "--adaptation", "x"], "accepted: off, on, both"),
                (["map", "--speeds", "9"], "10 to 1900"), (["map", "--speeds", "1901"], "10 to 1900"),
                (["map", "--speeds", "100,,200"], "accepted"), (["map", "--speeds", "100 200"], "accepted"),
                (["map", "--speeds", ""], "accepted"), (["map", "--speeds", "nan"], "accepted"),
                (["map", "--speeds", "200,100,200"], "200 is given twice"),
                (["map", "--speeds", ",".join(str(n) for n in range(100, 117))], "at most 16"),
                *(([command, "x"], "x: no argument is expected") for command in ("matrix", "reference", "man", "scenarios")), (["help", "rnu"], "did you mean run?"), (["matrix", "--only", "stuck_a_zro"], "did you mean stuck_a_zero?"),
                (["matrix", "--cell", "stuck_a"], "no cell is selected"), (["matrix", "--share", "0"], "above 0 to 100"),
                (["matrix", "--share", "101"], "above 0 to 100"), (["matrix", "--share", "5", "--seed", "-1"], "whole numbers"),
                (["matrix", "--seed", "3"], "--share"),
                (["paper", "fig99"], "known are fig04 fig05"), (["paper", "fig13", "fig1"], "fig1: no such figure"),
                (["paper", "beyond_sped"], "did you mean beyond_speed"), (["paper", "--seed"], "--help"),
                (["serve", "nosuch"], "neither a file nor"), (["serve"], "no scenario is given"), (["serve", "a", "b"], "b: a second scenario; accepted: one"),
                (["serve", "bare_motor", "--port", "65536"], "0 to 65535"), (["serve", "bare_motor", "--port", "x"], "0 to 65535"),
                (["serve", "bare_motor", "--until", "soon"], "accepted"), (["serve", "bare_motor", "--until", "-1"], "accepted"),
                (["serve", "bare_motor", "--free", "--realtime"], "one of them"),
                (["serve", "bare_motor", "--serial", "--port", "1"], "one of them"),
                (["scope", "tcp://127.0.0.1:1", "--port", "x"], "0 to 65535"), (["scope", "tcp://127.0.0.1:1", "--http", "x"], "0 to 65535"),
                (["serve", "bare_motor", "--set", "nosuch=1"], "no table has"), (["serve", "bare_motor", "--seed", "x"], "whole numbers"),
                (["run", os.path.join(self.folder, "none.toml")], "none.toml"))
        self.assertEqual(["a.toml"], os.listdir(self.folder))  # the command has left no output behind

    HISTORY = ["period", "state", "i_a", "i_b", "u_dc", "i_d", "i_q", "i_q_ref", "u_d", "u_q", "theta_e", "omega_e",
               "sample_flags"]

    def samples(self, name):
        """The lines of a CSV file below its header. The header must have the columns of a fault's history."""
        with open(os.path.join(self.folder, name)) as file:
            header, *lines = [line.rstrip("\n") for line in file if not line.startswith("#")]
        self.assertEqual(["time"] + self.HISTORY, [column.split("[")[0] for column in header.split(",")])
        return lines

    def faulty(self, duration, *events, code=0):
        """Runs with these settings at these times and records every period. Returns the result in JSON, the history and the recording."""
        path = self.scenario(duration=duration, at_least="-1e4 r/min")
        with open(path, "a") as file:
            for time_, setting in events:
                file.write('[[at]]\ntime = "%s s"\n%s\n' % (time_, setting))
        done = lagless("run", path, "--json", "--out", self.folder, "--every", "1", "--record", ",".join(self.HISTORY))
        self.expect(code, done)
        return json.loads(done.stdout), self.samples("a_fault.csv"), self.samples("a.csv"), done.stderr

    def test_history_has_the_periods_up_to_a_fault(self):
        """The history ends with the period of the fault: the second one beyond the trip, or the third wrong sample. A trip of the module
        comes before the step, so that the history ends one period earlier. It is as short as the run if the run was short."""
        for event, reason, begin, end in ((("0.15", "plant.dc_voltage = 450"), "dc_overvoltage", 1502 - KEPT, 1502),
                                          (("0.15", "plant.force_fault = 1"), "module_fault", 1500 - KEPT, 1500),
                                          (("0", "rig.stuck_current_a = 4095"), "bad_sample", 0, 3)):
            with self.subTest(reason):
                shutil.rmtree(self.folder)
                os.makedirs(self.folder)
                result, history, recording, told = self.faulty("0.2 s", event, code=1)
                self.assertEqual(recording[begin:end], history)
                self.assertEqual((reason, str(result["fault_period"])), (result["fault_reason"], history[-1].split(",")[1]))
                self.assertEqual([self.folder + "/a.csv", self.folder + "/a_fault.csv"], result["files"])
                self.assertIn("the last %d periods up to fault %s at " % (end - begin, reason), told)
                self.assertIn("s in %s/a_fault.csv\n" % self.folder, told)

    def test_history_is_kept_of_a_fault_that_was_reset_and_goes_with_a_run_without_one(self):
        result, history, recording, _ = self.faulty(
            "0.3 s", ("0.15", "plant.dc_voltage = 450"), ("0.16", "plant.dc_voltage = 311\nrequests.enable = \"off\""),
            ("0.2", "requests.fault_reset = \"yes\""))
        self.assertEqual("none", result["fault_reason"])
        self.assertEqual(recording[1501 - (KEPT - 1):1502], history)  # dc_overvoltage needs two successive samples
        done = lagless("run", self.scenario(), "--json", "--force", "--out", self.folder)
        self.assertEqual([self.folder + "/a.csv"], json.loads(done.stdout)["files"])
        self.assertFalse(os.path.exists(os.path.join(self.folder, "a_fault.csv")))

    def test_history_is_csv_whatever_the_recording_is(self):
        lagless("run", self.scenario(), "--out", self.folder, "--format", "mat", "--set", "stuck_current_a=4095")
        self.assertEqual(["a.mat", "a.toml", "a_fault.csv"], sorted(os.listdir(self.folder)))
        self.assertEqual(3, len(self.samples("a_fault.csv")))

    def test_history_that_cannot_be_written_gives_3(self):
        os.mkdir(os.path.join(self.folder, "a_fault.csv.partial"))
        done = lagless("run", self.scenario(), "--out", self.folder, "--set", "stuck_current_a=4095")
        self.expect(3, done, "a_fault.csv.partial")
        self.assertIn("a.csv", os.listdir(self.folder))

    def test_a_full_disk_gives_3(self):
        def limit():
            import resource
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

        done = lagless("run", self.scenario(duration="1 s"), "--out", self.folder, preexec_fn=limit)
        self.expect(3, done, ".csv.partial")

    def test_quiet_prints_nothing_when_all_is_met(self):
        done = lagless("run", self.scenario(), "--quiet")
        self.assertEqual((0, "", ""), (done.returncode, done.stdout, done.stderr))
        self.assertIn("FAILED", lagless("run", self.scenario(at_least="5000 r/min"), "--quiet").stdout)

    def test_a_signal_keeps_what_was_recorded_and_reports_it(self):
        path = self.scenario(duration="3600 s")
        for number in (signal.SIGINT, signal.SIGTERM):
            running = self.started("run", path, "--force", "--out", self.folder, "--every", "100", "--json")
            time.sleep(1.0)
            running.send_signal(number)
            out, err = running.communicate(timeout=60)
            self.assertEqual(1, running.returncode, err)
            self.assertIn("are kept in", err)
            self.assertEqual("interrupted", json.loads(out)["end"])
            lines = self.read("a.csv").splitlines()
            self.assertIn("# ended: interrupted", lines)
            self.assertGreater(len([line for line in lines if not line.startswith("#")]), 100)

    def test_serve_listens_ends_by_a_signal_and_reports_it_when_the_port_is_taken(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            server, place = self.serve(self.scenario(), "--port", "0")
            port = place.rpartition(":")[2]
            self.expect(3, lagless("serve", self.scenario(), "--port", port), "port " + port, "in use")
            server.send_signal(number)
            self.assertEqual(0, server.wait(10), server.stderr.read())

    def test_serve_reports_the_address_of_its_client(self):
        server, place = self.serve(self.scenario(), "--port", "0")
        with socket.create_connection(("127.0.0.1", int(place.rpartition(":")[2]))) as client:
            port = client.getsockname()[1]
            line = server.stderr.readline()
        server.send_signal(signal.SIGTERM)
        server.wait(10)
        self.assertRegex(line, rf"^lagless serve: client connected from 127\.0\.0\.1:{port} at [\d.]+ s$")

    def test_an_error_begins_with_program_and_command(self):
        wrong = self.scenario(duration="1 parsec")
        motor = self.write("motor.toml", "pole_pairs = 4\n")
        for command in ("run", "serve", "fmu", "map", "commission"):
            for of in ("no_such", "no_such.toml", wrong, motor):
                with self.subTest(command=command, of=of):
                    done = lagless(command, of)
                    self.assertEqual((2, ""), (done.returncode, done.stdout))
                    for line in done.stderr.splitlines():
                        self.assertTrue(line.startswith(f"lagless {command}: "), line)
        for of in ("no_such.toml", wrong, motor):
            with self.subTest(command="paper", of=of):
                for line in lagless("paper", of).stderr.splitlines():
                    self.assertTrue(line.startswith("lagless paper: "), line)

    def test_commands_report_the_file_that_they_write(self):
        path = os.path.join(self.folder, "new.toml")
        self.assertIn(f"the scenario is in {path}", lagless("tune", "teknic-m2310p-ln-04k", "--write", path).stderr)
        self.assertIn(f"the measured motor is in {path}", lagless("commission", "cold_start", "--yes", "--steps", "board", "--write", path,
                                                                  "--force").stderr)

    def test_pictures_of_a_commissioning_are_checked_before_the_motor_moves(self):
        for arguments, named in ((("--plot=bmp",), "html, png, svg"), (("--out", self.folder), "accepted with --plot")):
            with self.subTest(arguments=arguments):
                done = lagless("commission", "cold_start", "--yes", *arguments)
                self.assertEqual((2, ""), (done.returncode, done.stdout))
                self.assertIn(named, done.stderr)
        path = os.path.join(self.folder, "commission.html")
        self.write("commission.html", "kept")
        done = lagless("commission", "cold_start", "--yes", "--plot", "--out", self.folder)
        self.assertEqual((2, ""), (done.returncode, done.stdout))
        self.assertIn(path, done.stderr)
        with open(path, encoding="utf-8") as file:
            self.assertEqual("kept", file.read())

    def test_serve_keeps_time_or_runs_free_and_ends_at_its_time(self):
        begun = time.monotonic()
        self.expect(0, lagless("serve", self.scenario(), "--port", "0", "--until", "1 s"), "listening on 127.0.0.1:")
        self.assertGreater(time.monotonic() - begun, 0.98)
        self.expect(0, lagless("serve", self.scenario(), "--port", "0", "--until", "0.5 s", "--free", "--quiet"))

    def test_each_command_prints_the_version_of_the_program(self):
        version = lagless("--version").stdout
        self.assertRegex(version, r"^lagless \d+\.\d+\.\d+\n$")
        for command in ("run", "explain", "params"):
            self.assertEqual((0, version), (lagless(command, "--version").returncode, lagless(command, "--version").stdout))

    def test_help_is_a_command_too(self):
        for short, long in ((["help"], ["--help"]), (["help", "run"], ["run", "--help"])):
            self.expect(0, lagless(*short))
            self.assertEqual(lagless(*long).stdout, lagless(*short).stdout)

    def test_params_and_signals_list_the_rows_with_a_word_in_name_text_or_unit(self):
        def names(*arguments):
            return {row["name"] for row in json.loads(lagless(*arguments, "--json").stdout)["rows"]}
        rows = json.loads(lagless("params", "--json").stdout)["rows"]
        self.assertEqual({row["name"] for row in rows if "dead" in row["name"] + row["text"] or row["unit"] == "kg m^2"},
                         names("params", "DEAD", "KG M^2"))
        self.assertIn("theta_hat", names("signals", "theta_hat"))
        shown = lagless("params", "motor_flux").stdout
        self.assertIn("motor_flux_linkage ", shown)
        self.assertNotIn("motor_resistance ", shown)

    def test_fish_completes_commands_options_and_rows(self):
        script = lagless("completion", "fish").stdout
        if shutil.which("fish") is None:
            self.skipTest("fish is not installed")
        for line, expected in (("lagless comp", {"compare", "completion"}), ("lagless run --set iner", {"inertia=", "inertia_adaptation="}),
                               ("lagless explain overcurr", {"overcurrent"}), ("lagless params --js", {"--json"})):
            done = subprocess.run(["fish", "-c", script + "\ncomplete -C '%s'" % line], capture_output=True, text=True)
            self.assertEqual(expected, {candidate.split("\t")[0] for candidate in done.stdout.splitlines()}, done.stderr)

    def test_completion_is_bash_and_has_the_names_of_the_tables(self):
        script = lagless("completion", "bash").stdout
        self.assertEqual(0, subprocess.run(["bash", "-n"], input=script, text=True).returncode)
        probe = script + "\nCOMP_WORDS=(lagless run --set iner); COMP_CWORD=3; _lagless 2>/dev/null; echo \"${COMPREPLY[@]}\""
        self.assertEqual("inertia_adaptation= inertia=", subprocess.run(["bash"], input=probe, capture_output=True, text=True).stdout.strip())


class Readme(TestCase):
    """The output of a command shown in README and docs/ is the output of the program; `...` stands for lines that are left out."""

    def test_runs_that_are_shown_are_what_they_print(self):
        blocks = []
        for path in ["README.md", *glob.glob(os.path.join(ROOT, "docs", "*.md"))]:
            blocks += re.findall(r"^    \$ build/host/lagless run (\w+)\n((?:    .*\n)+)", document(path), re.M)
        self.assertIn("cold_start", [name for name, _ in blocks])
        for name, shown in blocks:
            printed = subprocess.run([LAGLESS, "run", name], stdout=subprocess.PIPE, text=True, check=True, timeout=120).stdout
            place = 0
            for line in (line[4:] for line in shown.splitlines() if line.strip() not in ("...", "")):
                with self.subTest(scenario=name, line=line):
                    found = printed.find(line + "\n", place)
                    self.assertGreaterEqual(found, place, "not printed, or not in this order")
                    place = found + len(line)


class Scenarios(TestCase):
    @unittest.skipIf(tomllib is None, "this Python has no tomllib (3.11 or later has)")
    def test_every_shipped_scenario_is_toml_with_a_title_and_an_expectation(self):
        tables = {"schema", "title", "text", "run", "start", "params", "requests", "plant", "rig", "at", "expect"}
        paths = glob.glob(os.path.join(ROOT, "host_sim", "scenarios", "*.toml"))
        self.assertGreater(len(paths), 10)
        for path in paths:
            with self.subTest(path=path):
                text = document(path)
                scenario = tomllib.loads(text)
                self.assertTrue(text.isascii() and text.startswith("# "), "no comment at its head explains its purpose")
                self.assertEqual(("schema", 1), next(iter(scenario.items())))
                self.assertTrue(scenario["title"] and scenario["run"]["record"] and scenario["expect"])
                self.assertLessEqual(set(scenario), tables)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
