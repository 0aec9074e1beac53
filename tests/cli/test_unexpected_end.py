"""The verdict on the end of a run: a run that ends with a fault or a lasting refusal fails, unless an expectation names that end. A drive
that was never on is reported, and an expectation that is met only for this reason fails.

usage: test_unexpected_end.py LAGLESS FOLDER"""

import json
import os
import unittest

from command_line import TestCase, lagless


def at(time, setting):
    return f'[[at]]\ntime = "{time}"\n{setting}\n'


def last(signal, at_least, at_most, more=""):
    """An expectation for the last value, with limits given as numbers or texts."""
    return f'[[expect]]\nsignal = "{signal}"\nstatistic = "last"\nat_least = {at_least}\nat_most = {at_most}\n{more}'


def back(begin):
    """Speed and reference are both 0 while the drive is off, so that a drive that is off meets this expectation."""
    return ('[[expect]]\nname = "speed comes back"\nsignal = "true_omega_m"\nminus = "omega_m_ref"\nstatistic = "peak"\n'
            f'from = "{begin}"\nat_most = "20 r/min"\n')


SAG = at("0.5 s", 'plant.dc_voltage = "100 V"')
OFF = at("0.3 s", 'requests.enable = "off"')
DEAD = at("10 ms", "plant.dc_voltage = 150")
REFUSED = OFF + at("0.5 s", 'plant.dc_voltage = "150 V"') + at("0.8 s", 'requests.enable = "on"')
RESET = at("0.9 s", 'plant.dc_voltage = 311\nrequests.enable = "off"') + at("1 s", 'requests.fault_reset = "yes"')
AGAIN = at("1.2 s", 'requests.fault_reset = "no"\nrequests.enable = "on"')
HOLDS = back("0.1 s").replace("20 r/min", "1000 r/min")
STATE = last("state", '"ready"', '"operation_enabled"')
UNNAMED = "which no expectation names"
NEVER_ON = "\nnever on: the DC link is below dc_undervoltage; check supply and precharge\n"

# Tables of the scenario, its duration, the exit code and the output; with code 0 no line may report an unnamed end.
ENDS = (
    # The example of docs/scenarios.md with a link of 100 V.
    (SAG + back("1.9 s"), "2 s", 1, "FAILED      end of the run: fault dc_undervoltage at 0.5010 s, " + UNNAMED, "met         speed comes back"),
    (at("0.5 s", "rig.brake_torque = 1000") + back("3.9 s"), "4 s", 1, "fault ", UNNAMED),
    (at("0.5 s", "plant.motor_temperature = 140") + back("1.9 s"), "2 s", 1, "fault motor_hot at", UNNAMED),
    (SAG, "2 s", 1, UNNAMED),
    (SAG + at("1 s", 'requests.enable = "off"') + back("1.9 s"), "2 s", 1, UNNAMED),
    # The run ends with a refusal.
    (REFUSED + back("1.9 s"), "2 s", 1, "end of the run: the drive refuses `enable` with dc_undervoltage", UNNAMED),
    ("", "20 ms", 0, "end state "),  # too short for the drive to turn on
    (OFF + at("0.5 s", 'requests.enable = "on"'), "0.505 s", 0, "end state "),
    # An expectation names the end, by the reason or by the state.
    (SAG + last("fault_reason", 20, 30), "2 s", 0),
    (SAG + last("fault_reason", 0, 30), "2 s", 1, UNNAMED),  # a run without a fault would meet this expectation too
    (SAG + last("fault_reason", 22, 22), "2 s", 1, UNNAMED),
    (SAG + last("state", '"fault"', '"fault"'), "2 s", 0, "end state fault, fault dc_undervoltage at 0.5010 s"),
    (SAG + last("state", '"operation_enabled"', '"fault"'), "2 s", 1, UNNAMED),
    # A fault after the window of the expectation is not named by it.
    (SAG + last("fault_reason", 1, 90, 'to = "0.4 s"\n'), "2 s", 1, UNNAMED),
    (SAG + RESET + AGAIN + last("fault_reason", 23, 23, 'to = "0.8 s"\n'), "2 s", 0),
    (SAG + RESET + AGAIN + last("fault_reason", 23, 23, 'to = "0.8 s"\n') + at("1.6 s", "plant.dc_voltage = 100"), "2 s", 1, UNNAMED),
    # An expectation names the refusal.
    (REFUSED + last("refusal", 23, 23), "2 s", 0),
    (REFUSED + last("state", '"ready"', '"ready"'), "2 s", 0),
    (REFUSED + last("state", '"ready"', '"operation_enabled"'), "2 s", 1, UNNAMED),
    (REFUSED + last("refusal", 23, 23, 'to = "1.5 s"\n'), "2 s", 1, UNNAMED),
    # A drive that is never on: expectations that are met only for this reason fail.
    (HOLDS + STATE, "0.2 s", 0, "met", "end state operation_enabled\n"),
    (DEAD + HOLDS + STATE, "0.2 s", 1, NEVER_ON, "FAILED", "at most 1000 r/min; the drive never came on\n", "met         last of state", UNNAMED),
    (DEAD + HOLDS + at("0.15 s", 'requests.enable = "off"'), "0.2 s", 1, "never on"),  # also if the last command is off
    (DEAD + HOLDS + 'needs_drive = "no"\n', "0.2 s", 0, "never on: "),
    (SAG + back("1.9 s") + 'needs_drive = "no"\n', "2 s", 1, UNNAMED),  # a drive that was on
    (HOLDS + 'needs_drive = "perhaps"\n', "0.2 s", 2, "needs_drive", "accepted: yes, no"),
    (HOLDS + at("0.15 s", "plant.dc_voltage = 450"), "0.2 s", 1, "not on: ", "met         speed comes back"),
)


class UnexpectedEnd(TestCase):
    def test_each_end_is_reported_and_judged(self):
        for tables, duration, code, *fragments in ENDS:
            with self.subTest(tables=tables):
                done = self.expect(code, lagless("run", self.scenario(tables, duration=duration)), *fragments)
                self.assertFalse(code == 0 and "no expectation names" in done.stdout, done.stdout)

    def test_a_drive_that_is_off_as_requested_is_not_reported(self):
        for arguments in (["quick_stop"], [self.scenario(HOLDS), "--set", "enable=off"]):
            self.assertNotIn("not on", self.expect(0, lagless("run", *arguments), "end state ready\n").stdout)

    def test_quiet_prints_it_json_and_a_recording_have_it(self):
        told = "fault dc_undervoltage at 0.5010 s, " + UNNAMED
        path = self.scenario(SAG, back("1.9 s"), duration="2 s")
        self.assertEqual(f"FAILED      end of the run: {told}\n", lagless("run", path, "-q", "--out", self.folder).stdout)
        self.assertIn("failed: " + told, self.read("a.csv"))
        result = json.loads(lagless("run", path, "--json").stdout)
        self.assertEqual((1, told), (result["failed"], result["unexpected_end"]))
        result = json.loads(lagless("run", self.scenario(back("1.9 s"), duration="2 s"), "--json").stdout)
        self.assertEqual((0, None), (result["failed"], result["unexpected_end"]))
        result = json.loads(lagless("run", self.scenario(DEAD, HOLDS), "--json").stdout)
        self.assertEqual(("failed", "the drive never came on"), tuple(result["expectations"][0][key] for key in ("verdict", "because")))

    def test_a_campaign_around_a_scenario_reports_a_fault_that_it_does_not_name(self):
        folder = os.path.join(self.folder, "c")
        path = self.scenario(SAG, back("1.9 s"), duration="2 s")
        self.expect(1, lagless("campaign", "--scenario", path, "--runs", "2", "--out", folder), "violated  2", "fault dc_undervoltage at ")
        self.expect(1, lagless("run", os.path.join(folder, "run-000000.toml")), "fault dc_undervoltage")
        named = self.scenario(SAG, last("fault_reason", 23, 23), duration="2 s", name="b.toml")
        self.expect(0, lagless("campaign", "--scenario", named, "--runs", "2", "--out", folder + "b"), "violated  0")

    def test_a_scenario_that_comes_with_the_program_names_its_end(self):
        self.expect(0, lagless("run", "estimate_lost"), "end state fault, fault start_stalled at ", "\nnot on: the rotor did not follow the start",
                    "; free the shaft")


if __name__ == "__main__":
    unittest.main(argv=["test_unexpected_end.py"], verbosity=2)
