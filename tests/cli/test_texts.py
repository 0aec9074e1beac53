"""Texts that other programs read: dumps in printable ASCII, values as they were given, and one version number from one place.

usage: test_texts.py LAGLESS FOLDER"""

import os
import re
import unittest

from command_line import ROOT, TestCase, document, lagless


class Dump(TestCase):
    """A VCD file (IEEE 1364) consists of printable ASCII."""

    HEAD = 'schema = 1\ntitle = "%s"\n[run]\nduration = "1 ms"\n'

    def dump(self, text, *more):
        path = self.write("a.toml", text)
        self.expect(0, lagless("run", path, "--out", self.folder, "--force", "--format", "vcd", "-q", *more))
        with open(os.path.join(self.folder, "a.vcd"), "rb") as file:
            return file.read()

    def test_no_octet_of_a_dump_is_beyond_printable_ascii(self):
        for text in (self.HEAD % "5 µs at 40 °C", self.HEAD % "a" + "# größer als Ω, 日本\n", self.HEAD % "tab" + "#\ta tab\n",
                     self.HEAD % "a" + '[[measure]]\nname = "é"\nsignal = "i_q"\nstatistic = "mean"\n',
                     self.HEAD % "a" + '[[expect]]\nname = "ü"\nsignal = "i_q"\nstatistic = "mean"\nat_most = 100\n'):
            octets = self.dump(text)
            self.assertEqual([], sorted({octet for octet in octets if not 32 <= octet < 127 and octet != 10}), text)

    def test_it_has_the_text_with_its_octets_by_number(self):
        self.assertIn(b"title: 5 \\xc2\\xb5s\n", self.dump(self.HEAD % "5 µs"))

    def test_a_csv_keeps_the_text_as_it_is(self):
        path = self.write("a.toml", self.HEAD % "5 µs at 40 °C")
        self.expect(0, lagless("run", path, "--out", self.folder, "-q"))
        self.assertIn("# title: 5 µs at 40 °C\n", self.read("a.csv"))


class Values(TestCase):
    def test_a_value_that_is_not_finite_is_reported_with_its_sign(self):
        for row, section in (("speed_request", "requests"), ("load_torque", "plant"), ("at_least", "expect")):
            for value, told in (("-inf", "-inf"), ("inf", "inf"), ("+inf", "inf"), ("nan", "nan")):
                head = Dump.HEAD % "a"
                text = (f'[[expect]]\nsignal = "i_q"\nstatistic = "mean"\n{row} = {value}\n' if section == "expect" else
                        f"[{section}]\n{row} = {value}\n")
                self.expect(2, lagless("run", self.write("a.toml", head + text)), f": {row}: {told} is not a finite number")


    def test_a_value_with_a_unit_but_without_quotes_gets_the_hint(self):
        path = self.write("a.toml", 'schema = 1\ntitle = "a"\n[run]\nduration = 1 s\n')
        self.expect(2, lagless("run", path), "a.toml:4:14: duration: not TOML", 'a value with a unit is a text in quotes, "1.5 s"')


    def test_a_row_has_both_its_names_wherever_it_is_set(self):
        """A name is accepted with its table and without it."""
        event = '[[at]]\ntime = "0.1 s"\n%s = 5\n'
        for row in ("speed_request", "requests.speed_request"):
            self.expect(0, lagless("run", self.scenario(event % row), "--set", row + "=3"))
            self.expect(0, lagless("run", self.scenario(Profiles.COURSE % (row, 1, 2)), "--record", row, "--out", self.folder, "--force"))


class Profiles(TestCase):
    COURSE = '[[profile]]\nrow = "%s"\npoints = [["0 s", %s], ["0.1 s", %s]]\n'

    def test_a_second_profile_of_a_row_is_refused(self):
        for first, second in (("speed_request", "speed_request"), ("plant.load_torque", "load_torque"), ("load_torque", "plant.load_torque"),
                              ("rig.brake_torque", "rig.brake_torque")):
            path = self.scenario(self.COURSE % (first, 1, 2), self.COURSE % ("i_q_request", 0, 0), self.COURSE % (second, 3, 4))
            self.expect(2, lagless("run", path), f"a.toml:17:1: {second}: line 11 has a profile of this row; accepted: one for each row")

    def test_profiles_of_several_rows_go_together(self):
        path = self.scenario(self.COURSE % ("speed_request", 1, 2), self.COURSE % ("load_torque", 0, 1), self.COURSE % ("i_d_request", 0, 0))
        self.expect(0, lagless("run", path))


class Reasons(TestCase):
    def test_no_text_of_a_reason_has_the_speed_of_one_motor(self):
        for number in re.findall(r"(?m)^ *(\d+) ", lagless("explain").stdout):
            self.assertNotIn("r/min", lagless("explain", number).stdout.partition("  condition:")[0])


class Pages(TestCase):
    """A number has the same value on all pages that show it."""

    def test_the_largest_angle_of_a_period_is_that_of_tune(self):
        program, motors = document("host_sim/lab/tune.c"), " ".join(document("docs/motors.md").split())
        good = float(re.search(r"#define TURN_GOOD +([\d.]+)", program)[1])
        most = max(map(float, re.findall(r"#define TURN_MOST +([\d.]+)", program)))
        self.assertIn(f"`tune` allows {most} rad", document("README.md"))
        self.assertIn(f"{most} rad electrical at `overspeed_trip`; from {good} rad on", motors)
        tested, hertz = map(float, re.search(r"up to ([\d.]+) rad of electrical angle per period, which is (\d+) Hz at 10 kHz",
                                             " ".join(document("README.md").split())).groups())
        self.assertAlmostEqual(tested * 1e4 / 6.2831853, hertz, delta=10)

    def test_every_state_of_the_drive_has_a_paragraph_of_its_own(self):
        head, _, rest = document("firmware/medium/sequence.h").partition("*/")
        states = re.findall(r"\bDRIVE_([A-Z_]+),? *(?:/|\n)", rest[:rest.index("}")])
        self.assertEqual(6, len(states))
        for state in states:
            self.assertRegex(head, rf"(?m)^ \*\n \* {state.lower().replace('_', ' ')}: ")

    def test_the_statements_of_the_pages_about_app_apply_are_true(self):
        self.assertIn("app_apply(", document("firmware/app/services.c"))
        self.assertIn("`app_apply` runs, which the order `apply`", " ".join(document("docs/chip.md").split()))


class Version(TestCase):
    """CMake's project() defines the version, and all other places have the same."""

    def test_every_place_has_the_version_of_the_project(self):
        version = re.search(r"project\(lagless VERSION ([\d.]+)", document("CMakeLists.txt"))[1]
        self.assertEqual(f"lagless {version}\n", lagless("--version").stdout)
        self.assertIn(f"\nversion: {version}\n", document("CITATION.cff"))
        self.assertIn('input = "CMakeLists.txt"', document("pyproject.toml"))
        self.assertNotRegex(document("pyproject.toml"), r"(?m)^version *=")
        changes = document("docs/CHANGELOG.md")
        released = re.findall(r"(?m)^## \[?v?(\d[\d.]*)", changes)
        if released:
            self.assertEqual(version, released[0])
        else:
            self.assertIn(f"the first release will be {version}", changes)
        path = self.write("a.toml", Dump.HEAD % "a")
        lagless("run", path, "--out", self.folder, "-q")
        self.assertIn(f"# program: lagless {version}\n", self.read("a.csv"))

    def test_the_changes_count_the_boards_that_there_are(self):
        words = {"one": 1, "two": 2, "three": 3, "four": 4, "five": 5, "six": 6}
        told = re.search(r"The board in one file, with checks and a guide; (\w+) boards", document("docs/CHANGELOG.md"))[1]
        self.assertEqual(len([name for name in os.listdir(os.path.join(ROOT, "hal/f28335/boards")) if name.endswith(".h")]), words[told])


if __name__ == "__main__":
    unittest.main(argv=["test_texts.py"], verbosity=2)
