"""Verdicts for the user's own motor: matrix, map and campaign around a scenario; and files that are given in place of another kind.

usage: test_own_motor.py LAGLESS FOLDER"""

import importlib.util
import json
import os
import re
import signal
import time
import unittest

from command_line import TestCase, lagless

# A servo motor of 1.27 N m: the brake of the paper's rig, 3 N m, is more than twice its rated torque.
SERVO = """pole_pairs = 5
resistance_line = "5.6 ohm"
inductance_line = "17 mH"
ke_line_rms = "33 V/krpm"
rated_current_rms = "2.4 A"
rated_torque = "1.27 N m"
rated_speed = "3000 r/min"
inertia = "0.28 kg cm^2"
load_inertia = "2 kg cm^2"
link_voltage = "311 V"
"""
# A motor of more than 14 N m, for which the overload of the paper's rig is no overload.
LARGE = """pole_pairs = 3
resistance = "0.35 ohm"
inductance = "4.1 mH"
ke_line_rms = "120 V/krpm"
rated_current_rms = "9 A"
inertia = "48 kg cm^2"
load_inertia = "150 kg cm^2"
link_voltage = "311 V"
"""
# A 48 V motor: the low link voltage of the paper's rig, 150 V, is far above its overvoltage trip.
HUB = """pole_pairs = 15
resistance_line = "0.13 ohm"
inductance_line = "0.25 mH"
ke_line_rms = "48 V/krpm"
rated_current_rms = "7 A"
rated_speed = "650 r/min"
inertia = "60 kg cm^2"
load_inertia = "0.6 kg m^2"
link_voltage = "48 V"
"""


class OwnMotor(TestCase):
    def tuned(self, sheet):
        path = os.path.join(self.folder, "my.toml")
        self.expect(0, lagless("tune", self.write("motor.toml", sheet), "--write", path, "--force"))
        return path

    def end_of(self, path):
        return float(re.search(r"(?m)^duration = (.*)", self.read(path))[1])

    def cell(self, path, fault, at):
        done = lagless("matrix", "--scenario", path, "--at", f"{at} s", "--only", fault, "--json")
        cell, = json.loads(done.stdout)["cells"]
        return done.returncode, cell

    # ---- matrix

    def test_a_brake_and_an_overload_are_scaled_to_every_motor(self):
        for sheet in (SERVO, LARGE):
            path = self.tuned(sheet)
            at = self.end_of(path) - 0.2
            code, cell = self.cell(path, "brake", at)
            self.assertEqual((0, "green"), (code, cell["verdict"]), cell)
            self.assertNotEqual("rides", self.cell(path, "overload", at)[1]["seen"]["reaction"])

    def test_a_link_is_high_low_or_sags_by_its_own_trips(self):
        path, at = self.tuned(HUB), 5  # [s] in which it is still accelerating; its scenario takes 22 s
        for fault, reason in (("dc_high", "dc_overvoltage"), ("dc_low", "dc_undervoltage")):
            _, cell = self.cell(path, fault, at)
            self.assertEqual(reason, cell["seen"]["reason"], cell)
        _, cell = self.cell(path, "dc_sag", at)
        self.assertNotIn(cell["seen"]["reason"], ("dc_overvoltage", "dc_undervoltage"), cell)

    def test_numbers_have_no_exponent_and_few_digits(self):
        """A fault after 7.8 s, and a motor with a small ripple and a small inductance."""
        path = self.tuned(HUB.replace("7 A", "16 A"))
        told = lagless("tune", os.path.join(self.folder, "motor.toml")).stderr
        for fault in ("jam", "motor_hot"):
            told += lagless("matrix", "--scenario", path, "--at", "20 s", "--only", fault).stdout
        self.assertRegex(told, r"after [1-9]\.\d{1,3} s")
        self.assertRegex(told, r"ripple is \d\.\d A peak")
        self.assertNotRegex(told, r"\de[+-]\d|\d\.\d{4}")

    def test_learning_does_not_disturb_a_motor_whose_test_signal_is_too_small(self):
        """With 0.125 mH at 300 r/min the EMF of the dither is smaller than the errors of the dead time. Learning may add at most 2 mrad, the
        limit of the campaign."""
        sheet = self.write("motor.toml", HUB.replace("7 A", "16 A"))
        text = f"""schema = 1
title = "hub"
[motor]
file = "{sheet}"
[run]
duration = "20 s"
[plant]
load_torque = "2.1 N m"
[start]
angle = 2
[requests]
enable = "on"
speed_request = "300 r/min"
[[measure]]
signal = "theta_hat_err"
statistic = "sd"
from = "12 s"
"""
        path = self.write("hub.toml", text)
        sd = [json.loads(lagless("run", path, "--json", "--set", "fidelity=averaged", *more).stdout)["measures"][0]["value"]
              for more in ((), ("--set", "inductance_adaptation=0"))]
        self.assertLess(sd[0], sd[1] + 2e-3)

    # ---- map

    def test_a_map_of_ones_own_motor_is_judged_by_what_the_drive_promises(self):
        done = lagless("map", self.tuned(SERVO), "--speeds", "1000", "--averaged", "--adaptation", "off")
        self.assertIn("largest error ", done.stdout)
        self.assertIn("the rotor is not lost at any point: ", done.stdout)
        self.assertIn("with right data the angle is within 30 mrad", done.stdout)
        self.assertNotIn("L wrong", done.stdout)
        self.assertEqual(1 if "FAILED" in done.stdout or done.stdout.count("!") > 1 else 0, done.returncode, done.stdout)

    # ---- campaign

    EDGE = """schema = 1
title = "a link that sags to the edge of its trip"
[run]
duration = "0.3 s"
[params]
position_source = "encoder"
dc_undervoltage = "260 V"
[start]
speed = "400 r/min"
[requests]
enable = "on"
speed_request = "400 r/min"
[[at]]
time = "0.1 s"
plant.dc_voltage = "270 V"
"""

    def test_list_and_file_agree_on_the_fault_of_each_violation(self):
        folder = os.path.join(self.folder, "found")
        path = self.write("edge.toml", self.EDGE)
        told = json.loads(lagless("campaign", "--scenario", path, "--runs", "50", "--out", folder, "--json").stdout)
        self.assertGreaterEqual(len(told["violations"]), 20)
        for violation in told["violations"]:
            run = json.loads(lagless("run", os.path.join(folder, violation["file"]), "--json").stdout)
            self.assertEqual(violation["fault"], run["fault_reason"], violation)
            if run["fault_reason"] != "none":
                self.assertAlmostEqual(violation["fault_s"], run["fault_period"] * 1e-4, 9)
            self.assertTrue(violation["reproduced"])
        self.assertEqual({"dc_undervoltage"}, {violation["fault"] for violation in told["violations"]})
        text = lagless("campaign", "--scenario", path, "merge", folder).stdout
        first = told["violations"][0]
        self.assertRegex(text, rf"{first['file']} .* fault {first['fault']} at {first['fault_s']:.4f} s, injected none\n")

    # ---- files of one kind given for another kind, and a stop

    def test_a_file_of_another_kind_is_refused_with_its_kind(self):
        path = self.write("motor.toml", SERVO)
        for command in ("run", "map", "bench", "paper"):
            self.expect(2, lagless(command, path), "is a motor: `lagless tune", "--write my.toml`")
        for text in ("", "schema = 1\n", "schema = 2\n", 'schema = 2\n[motor]\nname = "liu-2019"\n'):
            self.assertNotIn("is a motor", self.expect(2, lagless("run", self.write("none.toml", text)), "none.toml:1:1: ").stderr)
        motor = self.write("quick.toml", SERVO.replace("17 mH", "0.5 mH"))
        path = self.scenario()
        self.refuses((["tune", path], "is a scenario without [motor]: `lagless run"),
                     (["tune", motor], "periods of the control of 100 us", "uH at least"),
                     (["run", path, "--plot", "png"], "png: write --plot=png"),
                     (["run", "--plot", "html,svg", path], "html,svg: write --plot=html,svg"))

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "numpy is missing")
    def test_compare_takes_the_one_recording_of_a_folder(self):
        for name in ("a", "b"):
            lagless("run", self.scenario(duration="1 ms"), "--out", os.path.join(self.folder, name))
        folders = [os.path.join(self.folder, name) for name in ("a", "b")]
        self.expect(0, lagless("compare", *folders))
        lagless("run", self.scenario(duration="1 ms", name="other.toml"), "--out", folders[0])
        self.expect(2, lagless("compare", *folders), "it contains 2 recordings: a, other")
        self.expect(2, lagless("compare", self.folder, folders[1]), "it contains 0 recordings")

    def test_a_matrix_that_is_stopped_leaves_nothing_and_reports_it(self):
        folder = os.path.join(self.folder, "m")
        running = self.started("matrix", "--out", folder)
        partial = os.path.join(folder, "matrix.json.partial")
        deadline = time.monotonic() + 30
        while not os.path.exists(partial) and time.monotonic() < deadline:
            time.sleep(0.02)
        running.send_signal(signal.SIGINT)
        _, told = running.communicate(timeout=60)
        self.assertEqual(-signal.SIGINT, running.returncode)
        self.assertIn("lagless: stopped; nothing is written", told)
        self.assertEqual([], os.listdir(folder))


if __name__ == "__main__":
    unittest.main(argv=["test_own_motor.py"], verbosity=2)
