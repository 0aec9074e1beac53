"""One rule holds for every command that writes files: it never overwrites an input, and it overwrites an existing file only with --force.

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
        """Checks that a command does not change this file and names it in its message."""
        before = self.read(name)
        done = lagless(*arguments, **settings)
        self.expect(code, done, name, *fragments)
        self.assertEqual(before, self.read(name))
        self.assertEqual([], [each for each in os.listdir(self.folder) if each.endswith(".partial")])

    # ---- inputs

    def test_an_input_is_not_written_whatever_its_name(self):
        motor = self.write("m.toml", MOTOR)
        for more in ([], ["--force"]):
            self.keeps("m.toml", 2, "tune", motor, "--write", motor, *more, fragments=("is an input of this command",))
        os.symlink(motor, self.path("link.toml"))
        os.link(motor, self.path("hard.toml"))
        for name in ("link.toml", "hard.toml", "./m.toml", "../work/m.toml"):
            self.expect(2, lagless("tune", motor, "--write", self.path(name), "--force"), f"{name} is an input")
            self.assertEqual(MOTOR, self.read("m.toml"))

    def test_files_that_a_command_reads_by_the_way_are_inputs(self):
        """Further inputs are the motor file of a scenario, also if the name of the recording is a link to it; stdin; and a recording that
        is compared."""
        self.write("m.toml", MOTOR)
        scenario = self.write("s.toml", 'schema = 1\ntitle = "x"\n[run]\nduration = "1 ms"\n[motor]\nfile = "m.toml"\n')
        recording = self.record()
        for link, target in (("s.csv", "m.toml"), ("stdin.csv", "a.toml"), ("compare.html", "a.csv")):
            os.symlink(target, self.path(link))
        for name, source, arguments in (("s.csv", None, ["run", scenario]), ("stdin.csv", self.path("a.toml"), ["run", "-"]),
                                        ("compare.html", None, ["compare", recording, recording]),
                                        ("m.toml", self.path("m.toml"), ["tune", "/dev/stdin", "--write", self.path("m.toml")])):
            before = self.read(name)
            with open(source or os.devnull, encoding="utf-8") as file:
                done = lagless(*arguments, "--force", *([] if arguments[0] == "tune" else ["--out", self.folder]), stdin=file)
            self.expect(2, done, f"{name} is an input")
            self.assertEqual(before, self.read(name))

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

    def test_no_result_is_written_over(self):
        recording = self.record()
        self.keeps("a.csv", 2, "run", self.scenario(duration="2 ms"), "--out", self.folder, fragments=("--force",))
        os.mkdir(self.path("data"))
        run, there = ["run", self.scenario(duration="1 ms", name="b.toml")], ["--out", self.folder]
        few_points, cell = ["map", "--ideal", "--speeds", "500", "--adaptation", "off", "--averaged"], ["matrix", "--cell", "stuck_a_rail/off"]
        for name, arguments in (("b.mat", [*run, *there, "--format", "mat"]), ("b.vcd", [*run, *there, "--format", "vcd"]),
                                ("b.mf4", [*run, *there, "--format", "mdf"]),
                                ("b_fault.csv", [*run, *there]), ("b.html", [*run, *there, "--plot"]),
                                ("a.html", ["plot", recording]), ("a.svg", ["plot", recording, "--format", "html,svg"]),
                                ("compare.html", ["compare", recording, recording, *there]),
                                ("map.json", [*few_points, *there]), ("map.png", [*few_points, *there]),
                                ("matrix.json", [*cell, *there]), ("matrix.html", [*cell, *there]),
                                *((name, ["paper", "fig12", *there]) for name in ("rows.json", "index.html", "data/fig12.csv"))):
            self.write(name, "mine")
            self.keeps(name, 2, *arguments, env=NO_PICTURES)
            if name in ("a.html", "compare.html", "matrix.json", "data/fig12.csv"):
                self.expect(0, lagless(*arguments, "--force", env=NO_PICTURES))
            os.remove(self.path(name))

    def test_a_campaign_begins_again_only_with_force_and_leaves_no_old_scenario(self):
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
