"""`lagless motors` and `lagless tune`, and the page that describes them. usage: test_motors.py LAGLESS FOLDER ROOT"""

import json
import os
import re
import subprocess
import sys
import unittest

from command_line import LAGLESS, ROOT, TestCase, document, lagless

LIBRARY = os.path.join(ROOT, "host_sim", "motors")
PAGE = document("docs/motors.md")


class Motors(TestCase):
    def test_the_list_and_its_json_have_every_file_of_the_library(self):
        names = sorted(name[:-5] for name in os.listdir(LIBRARY) if name.endswith(".toml"))
        done = lagless("motors")
        self.expect(0, done, *names)
        self.assertEqual(names, [motor["name"] for motor in json.loads(lagless("motors", "--json").stdout)["motors"]])

    def test_a_motor_is_shown_with_its_source_and_in_json(self):
        self.expect(0, lagless("motors", "estun-emj-04apb22"), "pole_pairs", "source: TI, MotorControl SDK")
        motor = json.loads(lagless("motors", "estun-emj-04apb22", "--json").stdout)
        self.assertAlmostEqual(0.377903223 / 6.283185307, motor["flux_linkage_wb"], 7)
        self.assertAlmostEqual(3.82, motor["rated_current_peak_a"])

    def test_an_unknown_motor_is_reported_with_the_nearest_and_a_short_file_with_what_is_missing(self):
        path = self.write("short.toml", "pole_pairs = 4\nresistance = 1\n")
        self.refuses((["motors", "teknik-m2310p-ln-04k"], "nearest: teknic-m2310p-ln-04k"),
                     (["tune", "beckhoff"], "nearest: beckhoff-am8122, beckhoff-am8141"), (["tune"], "no motor is given"),
                     (["tune", os.path.join(self.folder, "none.toml")], "none.toml"),
                     (["tune", path], "short.toml", "missing: inductance", "rated_current_peak", "flux_linkage"))

    def test_tune_prints_toml_with_a_reason_each_that_a_scenario_takes(self):
        done = lagless("tune", "baldor-bsm90n-175")
        self.expect(0, done, "(theory, 3)", "pm50rl1a060", "(this build)")
        rows = [line for line in done.stdout.splitlines() if " = " in line and not line.startswith("#")]
        self.assertGreater(len(rows), 30)
        for row in rows:
            self.assertRegex(row, r"^[a-z_]+ = \S+ # \S")
        scenario = self.write("rows.toml", 'schema = 1\ntitle = "rows"\n[run]\nduration = 0.01\n' + done.stdout)
        self.expect(0, lagless("run", scenario))

    def test_tune_in_json_has_rows_reasons_and_warnings(self):
        done = lagless("tune", "hurst-dmb0224c10002", "--json", "--set", "load_inertia=1e-5")
        rows = {(row["table"], row["name"]): row for row in json.loads(done.stdout)["rows"]}
        self.assertEqual(1e-5, rows["plant", "load_inertia"]["value"])
        self.assertAlmostEqual(1.55e-5, rows["params", "motor_inertia"]["value"])
        self.assertTrue(all(row["reason"] for row in rows.values()))
        self.assertTrue(any("V is enough" in text for text in json.loads(done.stdout)["warnings"]))

    def test_the_five_lines_of_the_page_are_a_motor_that_runs(self):
        lines = re.search(r"    # my_motor.toml\n((?:    .*\n)+)", PAGE)[1]
        self.assertEqual(5, len(lines.splitlines()))
        motor = self.write("my_motor.toml", "\n".join(line.strip() for line in lines.splitlines()))
        written = os.path.join(self.folder, "my.toml")
        self.expect(0, lagless("tune", motor, "--write", written), "inertia is not given")
        self.expect(0, lagless("run", written), "met         never lost", "met         angle under load")
        self.expect(3, lagless("tune", motor, "--write", os.path.join(self.folder, "no", "such.toml")))

    def test_the_scenarios_of_the_page_are_read(self):
        head = 'schema = 1\ntitle = "t"\n[run]\nduration = "4 s"\n'
        blocks = ["".join(line[4:] for line in block.splitlines(True)) for block in re.findall(r"\n\n((?:    .+\n)+)", PAGE)]
        motor = next(block for block in blocks if block.startswith("[motor]"))
        assumption = next(block for block in blocks if block.startswith("[params]"))
        loads = next(block for block in blocks if block.startswith("load_torque"))
        profile = next(block for block in blocks if block.startswith("[[profile]]"))
        path = self.write("page.toml", head + motor + assumption + "[plant]\n" + loads + profile)
        self.expect(0, lagless("run", path, "--set", "run.duration=3.1"))

    def test_the_ripple_of_the_page_is_that_of_its_formula(self):
        inductance, carrier, link, ripple = re.search(r"\((\d+) uH at (\d+) kHz and (\d+) V: ([\d.]+) A\)", PAGE).groups()
        self.assertAlmostEqual(float(ripple), int(link) / (int(carrier) * 1e3) / (6 * int(inductance) * 1e-6), 1)

    def test_check_judges_three_speeds_and_three_loads(self):
        done = lagless("motors", "estun-emj-04apb22", "--check")
        self.expect(0, done)
        cells = [cell.strip() for cell in done.stdout.strip().split("|")]
        top, load = float(cells[4].split()[0]), float(cells[5].split()[0])
        self.assertLess(float(cells[9]), 30)
        scatter, speed, torque = re.fullmatch(r"(\d+) at (\d+) r/min, (\S+) N m", cells[10]).groups()
        self.assertLess(float(scatter), 50)
        self.assertIn(round(float(speed) / top, 3), (0.3, 0.6, 1.0))
        self.assertIn(round(float(torque) / load, 2), (0.0, 0.5, 1.0))
        self.assertEqual("runs", cells[11])

    def test_the_tables_of_the_page_are_the_program_s(self):
        done = subprocess.run([sys.executable, os.path.join(ROOT, "tools", "motors-docs"), "--check", LAGLESS],
                              capture_output=True, text=True)
        self.expect(0, done)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
