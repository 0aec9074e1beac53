"""One rule for every command that writes: never an input, an existing file only with --force.
usage: test_overwrite.py LAGLESS FOLDER"""

import os
import unittest

from command_line import NO_PICTURES, TestCase, lagless

MOTOR = """# the data sheet, with its comments
pole_pairs = 4
resistance = "1.5 ohm"
inductance = "6 mH"
ke_line_rms = "45 V/krpm"
rated_current_rms = "3 A"
link_voltage = "310 V"
inertia = "3 kg cm^2"
"""


class Overwrite(TestCase):
    def path(self, name):
        return os.path.join(self.folder, name)

    def keeps(self, name, code, *arguments, fragments=(), **settings):
        """That a command leaves this file as it is, and says which it is."""
        before = self.read(name)
        done = lagless(*arguments, **settings)
        self.expect(code, done, name, *fragments)
        self.assertEqual(before, self.read(name))
        self.assertEqual([], [each for each in os.listdir(self.folder) if each.endswith(".partial")])

    # ---- inputs

    def test_tune_does_not_write_over_its_motor(self):
        motor = self.write("m.toml", MOTOR)
        for more in ([], ["--force"]):
            self.keeps("m.toml", 2, "tune", motor, "--write", motor, *more, fragments=("is an input of this command",))

    def test_an_input_is_known_by_other_names_too(self):
        motor = self.write("m.toml", MOTOR)
        os.symlink(motor, self.path("link.toml"))
        os.link(motor, self.path("hard.toml"))
        for name in ("link.toml", "hard.toml", "./m.toml", "../work/m.toml"):
            self.expect(2, lagless("tune", motor, "--write", self.path(name), "--force"), f"{name} is an input")
            self.assertEqual(MOTOR, self.read("m.toml"))
        with open(motor) as file:
            self.keeps("m.toml", 2, "tune", "/dev/stdin", "--write", motor, "--force", stdin=file)

    def test_a_file_that_a_scenario_names_is_an_input(self):
        """The run writes s.csv, which a link makes the motor of the scenario."""
        self.write("m.toml", MOTOR)
        scenario = self.write("s.toml", 'schema = 1\ntitle = "x"\n[run]\nduration = "1 ms"\n[motor]\nfile = "m.toml"\n')
        os.symlink("m.toml", self.path("s.csv"))
        before = self.read("m.toml")
        self.expect(2, lagless("run", scenario, "--out", self.folder, "--force"), "s.csv is an input of this command")
        self.assertEqual(before, self.read("m.toml"))

    def test_a_scenario_from_stdin_is_an_input(self):
        scenario = self.scenario(duration="1 ms")
        os.symlink(scenario, self.path("stdin.csv"))
        with open(scenario) as file:
            self.expect(2, lagless("run", "-", "--out", self.folder, "--force", stdin=file), "stdin.csv is an input")

    def test_a_recording_that_is_compared_is_an_input(self):
        recording = self.record()
        os.symlink(recording, self.path("compare.html"))
        self.expect(2, lagless("compare", recording, recording, "--out", self.folder, "--force"), "compare.html is an input")

    # ---- what exists

    def record(self, *more):
        self.expect(0, lagless("run", self.scenario(duration="1 ms"), "--out", self.folder, *more))
        return self.path("a.csv")

    def test_tune_writes_over_an_existing_file_only_with_force(self):
        motor = self.write("m.toml", MOTOR)
        self.write("mine.toml", "# edited by hand\n")
        self.keeps("mine.toml", 2, "tune", motor, "--write", self.path("mine.toml"), fragments=("exists; --force replaces it",))
        self.expect(0, lagless("tune", motor, "--write", self.path("mine.toml"), "--force"))
        self.assertIn("# Written by `lagless tune`", self.read("mine.toml"))
        self.expect(0, lagless("tune", motor, "--write", "/dev/null"))

    def test_run_writes_over_no_recording(self):
        self.record()
        self.keeps("a.csv", 2, "run", self.scenario(duration="2 ms"), "--out", self.folder, fragments=("--force",))
        for ending in ("mat", "vcd"):
            self.write(f"b.{ending}", "mine")
            self.keeps(f"b.{ending}", 2, "run", self.scenario(duration="1 ms", name="b.toml"), "--out", self.folder, "--format", ending)
        self.write("c_fault.csv", "mine")
        self.keeps("c_fault.csv", 2, "run", self.scenario(duration="1 ms", name="c.toml"), "--out", self.folder)
        self.write("d.html", "mine")
        self.keeps("d.html", 2, "run", self.scenario(duration="1 ms", name="d.toml"), "--plot", "--out", self.folder, env=NO_PICTURES)
        self.record("--force")

    def test_plot_and_compare_write_over_no_picture(self):
        recording = self.record()
        for name, arguments in (("a.html", ["plot", recording]), ("a.svg", ["plot", recording, "--format", "html,svg"]),
                                ("compare.html", ["compare", recording, recording, "--out", self.folder])):
            self.write(name, "mine")
            self.keeps(name, 2, *arguments, env=NO_PICTURES)
            self.expect(0, lagless(*arguments, "--force", env=NO_PICTURES))
            os.remove(self.path(name))

    def test_map_and_matrix_write_over_no_result(self):
        for name, arguments in (("map.json", ["map", "--ideal", "--speeds", "500", "--adaptation", "off", "--averaged"]),
                                ("map.png", ["map", "--ideal", "--speeds", "500", "--adaptation", "off", "--averaged"]),
                                ("matrix.json", ["matrix", "--cell", "stuck_a_rail/off"]),
                                ("matrix.html", ["matrix", "--cell", "stuck_a_rail/off"])):
            self.write(name, "mine")
            self.keeps(name, 2, *arguments, "--out", self.folder, env=NO_PICTURES)
            os.remove(self.path(name))
        self.write("matrix.json", "mine")
        self.expect(0, lagless("matrix", "--cell", "stuck_a_rail/off", "--out", self.folder, "--force", env=NO_PICTURES))
        self.assertNotEqual("mine", self.read("matrix.json"))

    def test_paper_writes_over_no_report(self):
        os.mkdir(self.path("data"))
        for name in ("rows.json", "index.html", "data/fig12.csv"):
            self.write(name, "mine")
            self.keeps(name, 2, "paper", "fig12", "--out", self.folder, env=NO_PICTURES)
            os.remove(self.path(name))
        self.write("rows.json", "mine")
        self.expect(0, lagless("paper", "fig12", "--out", self.folder, "--force", env=NO_PICTURES))

    def test_a_campaign_begins_anew_only_with_force_and_leaves_no_old_scenario(self):
        few = ["campaign", "--runs", "2", "--seconds", "0.1", "--out", self.folder]
        self.write("run-000001.toml", "mine")
        self.keeps("run-000001.toml", 2, *few)
        self.expect(0, lagless(*few, "--force"))
        self.assertFalse(os.path.exists(self.path("run-000001.toml")))
        self.keeps("campaign.csv", 2, *few, fragments=("--resume", "--force"))
        self.expect(0, lagless(*few, "--resume"))

    def test_a_campaign_does_not_take_away_the_scenario_that_it_is_around(self):
        scenario = self.scenario(duration="20 ms", name="run-000000.toml")
        self.keeps("run-000000.toml", 2, "campaign", "--scenario", scenario, "--runs", "1", "--out", self.folder, "--force",
                   fragments=("is an input",))

    def test_connect_writes_over_no_recording(self):
        target = "tcp://" + self.serve("load_step", "--port", "0")[1]
        self.write("rec.csv", "mine")
        script = f"record omega_m for 10 ms --out {self.folder} --name rec --format csv\n"
        self.keeps("rec.csv", 1, "connect", target, input=script, fragments=("another --name",))
        self.expect(0, lagless("connect", target, "--force", input=script))
        self.assertNotEqual("mine", self.read("rec.csv"))


if __name__ == "__main__":
    unittest.main(argv=["test_overwrite.py"], verbosity=2)
