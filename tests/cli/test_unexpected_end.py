"""A run that ends with a fault or a lasting refusal fails, unless an expectation names that end.
usage: test_unexpected_end.py LAGLESS FOLDER"""

import json
import os
import unittest

from command_line import TestCase, lagless

# Speed and reference are both 0 while the drive is off: this expectation is met by a dead drive.
BACK = """[[expect]]
name = "speed comes back"
signal = "true_omega_m"
minus = "omega_m_ref"
statistic = "peak"
from = "%s"
at_most = "20 r/min"
"""


def at(time, setting):
    return f'[[at]]\ntime = "{time}"\n{setting}\n'


def expect(signal, at_least, at_most, more=""):
    return f'[[expect]]\nsignal = "{signal}"\nstatistic = "last"\nat_least = "{at_least}"\nat_most = "{at_most}"\n{more}'.replace(
        '"-"', '"0"')


def number(signal, at_least, at_most, more=""):
    return f'[[expect]]\nsignal = "{signal}"\nstatistic = "last"\nat_least = {at_least}\nat_most = {at_most}\n{more}'


class UnexpectedEnd(TestCase):
    SAG = at("0.5 s", 'plant.dc_voltage = "100 V"')
    OFF = at("0.3 s", 'requests.enable = "off"')

    def run_it(self, code, *more, duration="2 s", fragments=(), absent=("no expectation names",)):
        done = lagless("run", self.scenario(*more, duration=duration))
        self.expect(code, done, *fragments)
        for fragment in absent:
            self.assertNotIn(fragment, done.stdout)
        return done

    def fails(self, *more, duration="2 s", fragments=()):
        return self.run_it(1, *more, duration=duration, fragments=("which no expectation names", *fragments), absent=())

    # ---- faults

    def test_a_link_that_sags_fails_though_the_check_is_met(self):
        """D1 of the first-hour trial: docs/scenarios.md's own example with a link of 100 V."""
        self.fails(self.SAG, BACK % "1.9 s", fragments=(
            "FAILED      end of the run: fault dc_undervoltage at 0.5010 s, which no expectation names", "met         speed comes back"))

    def test_a_jammed_shaft_fails(self):
        done = self.fails(at("0.5 s", "rig.brake_torque = 1000"), BACK % "3.9 s", duration="4 s")
        self.assertRegex(done.stdout, "fault (stalled|speed_error|encoder_mismatch) at")

    def test_a_motor_too_hot_fails_after_its_quick_stop(self):
        self.fails(at("0.5 s", "plant.motor_temperature = 140"), BACK % "1.9 s", fragments=("fault motor_hot at",))

    def test_a_run_without_any_expectation_fails(self):
        self.fails(self.SAG)

    def test_a_fault_fails_though_the_drive_is_not_asked_to_be_on_any_more(self):
        self.fails(self.SAG, at("1 s", 'requests.enable = "off"'), BACK % "1.9 s")

    def test_quiet_prints_it_and_json_has_it(self):
        path = self.scenario(self.SAG, BACK % "1.9 s", duration="2 s")
        self.assertEqual("FAILED      end of the run: fault dc_undervoltage at 0.5010 s, which no expectation names\n",
                         lagless("run", path, "-q").stdout)
        told = json.loads(lagless("run", path, "--json").stdout)
        self.assertEqual((1, "fault dc_undervoltage at 0.5010 s, which no expectation names"),
                         (told["failed"], told["unexpected_end"]))
        told = json.loads(lagless("run", self.scenario(BACK % "1.9 s", duration="2 s"), "--json").stdout)
        self.assertEqual((0, None), (told["failed"], told["unexpected_end"]))

    def test_a_recording_has_it_among_its_verdicts(self):
        lagless("run", self.scenario(self.SAG, duration="2 s"), "--out", self.folder)
        with open(os.path.join(self.folder, "a.csv"), encoding="utf-8") as file:
            self.assertIn("failed: fault dc_undervoltage at 0.5010 s, which no expectation names", file.read())

    # ---- refusals

    def test_a_lasting_refusal_fails(self):
        self.fails(self.OFF, at("0.5 s", 'plant.dc_voltage = "150 V"'), at("0.8 s", 'requests.enable = "on"'), BACK % "1.9 s",
                   fragments=("end of the run: the drive is to be on and refuses with dc_undervoltage",))

    def test_a_drive_that_was_never_on_fails_without_any_limit(self):
        done = lagless("run", self.scenario(), "--set", "plant.dc_voltage=150 V")
        self.expect(1, done, "never on: ", "refuses with dc_undervoltage, which no expectation names")

    def test_a_drive_that_has_had_no_time_to_come_on_is_not_refused(self):
        self.run_it(0, duration="20 ms")
        self.run_it(0, self.OFF, at("0.5 s", 'requests.enable = "on"'), duration="0.505 s")

    # ---- named

    def test_an_expectation_of_the_reason_names_a_fault(self):
        self.run_it(0, self.SAG, number("fault_reason", 23, 23))
        self.run_it(0, self.SAG, number("fault_reason", 20, 30))
        self.fails(self.SAG, number("fault_reason", 0, 30))  # it would be met without a fault, too
        self.fails(self.SAG, number("fault_reason", 22, 22))

    def test_an_expectation_of_the_state_names_a_fault(self):
        self.run_it(0, self.SAG, expect("state", "fault", "fault"))
        self.fails(self.SAG, expect("state", "operation_enabled", "fault"))

    def test_an_expectation_names_no_fault_that_comes_after_it(self):
        self.fails(self.SAG, number("fault_reason", 1, 90, 'to = "0.4 s"\n'))
        reset = at("0.9 s", 'plant.dc_voltage = 311\nrequests.enable = "off"') + at("1 s", 'requests.fault_reset = "yes"')
        again = at("1.2 s", 'requests.fault_reset = "no"\nrequests.enable = "on"')
        named = number("fault_reason", 23, 23, 'to = "0.8 s"\n')
        self.run_it(0, self.SAG, reset, again, named)
        self.fails(self.SAG, reset, again, named, at("1.6 s", "plant.dc_voltage = 100"))

    def test_an_expectation_names_a_refusal(self):
        refused = self.OFF + at("0.5 s", 'plant.dc_voltage = "150 V"') + at("0.8 s", 'requests.enable = "on"')
        self.run_it(0, refused, number("refusal", 23, 23))
        self.run_it(0, refused, expect("state", "ready", "ready"))
        self.fails(refused, expect("state", "ready", "operation_enabled"))
        self.fails(refused, number("refusal", 23, 23, 'to = "1.5 s"\n'))

    def test_needs_drive_no_names_a_drive_that_is_never_on(self):
        limit = BACK % "1.9 s" + 'needs_drive = "no"\n'
        self.run_it(0, at("10 ms", "plant.dc_voltage = 150"), limit)
        self.fails(self.SAG, limit)  # that was on

    # ---- elsewhere

    def test_a_campaign_around_a_scenario_reports_a_fault_that_it_does_not_name(self):
        folder = os.path.join(self.folder, "c")
        path = self.scenario(self.SAG, BACK % "1.9 s", duration="2 s")
        self.expect(1, lagless("campaign", "--scenario", path, "--runs", "2", "--out", folder), "violated  2", "fault dc_undervoltage at ")
        self.expect(1, lagless("run", os.path.join(folder, "run-000000.toml")), "fault dc_undervoltage")
        named = self.scenario(self.SAG, number("fault_reason", 23, 23), duration="2 s", name="b.toml")
        self.expect(0, lagless("campaign", "--scenario", named, "--runs", "2", "--out", folder + "b"), "violated  0")

    def test_every_scenario_that_comes_with_the_program_names_its_end(self):
        """What ends with a fault on purpose says so; tests/lab runs each."""
        for name in ("estimate_lost", "dc_link_sag", "stuck_sensor", "late_interrupt"):
            self.expect(0, lagless("run", name), "end state fault")


if __name__ == "__main__":
    unittest.main(argv=["test_unexpected_end.py"], verbosity=2)
