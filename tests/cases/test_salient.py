"""Motors whose rotor is too salient for the estimator are refused with both rows, and run with an encoder.

usage: test_salient.py LAGLESS FOLDER CASES"""
import pathlib
import subprocess
import sys
import unittest

LAGLESS, FOLDER, CASES = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
REASON = ("motor_inductance_q <= 1.2 motor_inductance_d where position_source or encoder_fault_reaction is sensorless, else the rotor is "
          "lost under load; use an encoder")


def lagless(*arguments):
    return subprocess.run([LAGLESS, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=120)


class Salient(unittest.TestCase):
    def assert_refused(self, done, inductance_q, inductance_d, *fragments):
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        for fragment in (f"motor_inductance_q: {inductance_q} H: accepted ", REASON, f"with motor_inductance_d = {inductance_d} H", *fragments):
            self.assertIn(fragment, done.stderr)

    def test_the_reported_motors_are_refused_with_both_rows_and_what_to_do(self):
        for name, inductance_q, inductance_d, *fragments in (
                ("ipm_learns_itself_astray", "0.0096", "0.0052", "change position_source"),
                ("salient_pll", "0.02", "0.01333", " to 0.015996 H"),  # 1.2 x 13.33 mH
                ("salient_start", "0.0125", "0.005", "change position_source")):
            with self.subTest(name=name):
                self.assert_refused(lagless("run", CASES / f"{name}.toml"), inductance_q, inductance_d, *fragments)

    def test_the_ratio_decides(self):
        """Beside L_d = 12.5 mH: 14.875 mH is 1.19 of it, 15 mH 1.2, 15.125 mH 1.21."""
        settings = ("--set", "params.motor_inductance_d=12.5 mH", "--set")
        for inductance_q in ("14.875 mH", "15 mH"):
            with self.subTest(inductance_q=inductance_q):
                done = lagless("run", "cold_start", *settings, f"params.motor_inductance_q={inductance_q}", "--set",
                               f"plant.inductance_q={inductance_q}")
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assert_refused(lagless("run", "cold_start", *settings, "params.motor_inductance_q=15.125 mH"), "0.015125", "0.0125", " to 0.015 H")

    def test_an_encoder_whose_fault_leads_back_to_the_estimator_is_none(self):
        case = CASES / "salient_with_encoder.toml"
        self.assert_refused(lagless("run", case, "--set", "params.encoder_fault_reaction=sensorless"), "0.0096", "0.0052")
        self.assertEqual(lagless("run", case, "--set", "params.encoder_fault_reaction=ignored").returncode, 0)

    def test_tune_writes_a_scenario_with_an_encoder_that_runs_and_says_why(self):
        FOLDER.mkdir(parents=True, exist_ok=True)
        written = FOLDER / "awan.toml"
        tuned = lagless("tune", "awan-2kw2-ipm", "--write", written, "--force")
        self.assertEqual(tuned.returncode, 0, tuned.stderr)
        self.assertIn('position_source = "encoder" # L_q is 1.42 L_d: without an encoder at most 1.2', tuned.stdout)
        self.assertIn("without an encoder the drive accepts 1.2 L_d at most", tuned.stderr)
        done = lagless("run", written)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assert_refused(lagless("run", written, "--set", "params.position_source=sensorless"), "0.051", "0.036")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
