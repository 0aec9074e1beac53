"""tools/ensemble with programs that fail for some seeds.

usage: test_ensemble.py"""

import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ENSEMBLE = pathlib.Path(__file__).resolve().parents[2] / "tools/ensemble"

# Output in Unity's form: one function that always passes, and one with two members, of which the second fails for a seed.
PROGRAM = """#!/bin/sh
echo "LAGLESS_SEED=$LAGLESS_SEED"
echo "test.c:1:test_holds:PASS"
echo "test.c:2:test_of_noise:PASS"
if [ "$LAGLESS_SEED" = "{red}" ] && [ "$LAGLESS_GRID_SEED" = "{red}" ]; then
    echo "test.c:2:test_of_noise[1]:FAIL: 3.10 mrad, limit 3.00"
    exit 1
fi
echo "test.c:2:test_of_noise[1]:PASS"
"""

# Output in the form of a grid (tools/desk/run_scenario.c): the second of two scenarios fails for a seed.
GRID = """#!/bin/sh
printf 'braking: shaft heavy\\n  met     a\\n  met     b\\n  state 3\\n'
if [ "$LAGLESS_SEED" = 7 ]; then
    printf 'braking: shaft light\\n  met     a\\n  FAILED  b: 9\\n  state 3\\nFAILED: x.toml is kept\\n2 runs, 1 failed\\n'
    exit 1
fi
printf 'braking: shaft light\\n  met     a\\n  met     b\\n  state 3\\n2 runs, 0 failed\\n'
"""


class Ensemble(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_ensemble_"))

    def tearDown(self):
        shutil.rmtree(self.folder)

    def build(self, **programs):
        lines = []
        for name, (labels, text) in programs.items():
            program = self.folder / f"test_{name}"
            program.write_text(text)
            program.chmod(0o755)
            lines.append(f'add_test({name} "{program}")\nset_tests_properties({name} PROPERTIES LABELS "{labels}")\n')
        (self.folder / "CTestTestfile.cmake").write_text("".join(lines))

    def run_tool(self, *arguments):
        environment = {key: value for key, value in os.environ.items() if not key.startswith("LAGLESS_")}
        return subprocess.run([ENSEMBLE, "--build", self.folder, *arguments], env=environment, capture_output=True, text=True, check=False)

    def test_runs_are_counted_by_function_and_member_and_a_red_one_is_reported_with_seed_and_message(self):
        self.build(rig_a=("rig", PROGRAM.format(red=7)))
        done = self.run_tool("--seeds", "5", "--first", "1")
        self.assertEqual((0, "15 of 15 runs green, 100.00 %, of 2 test functions with 5 seeds\n"), (done.returncode, done.stdout))
        done = self.run_tool("--seeds", "5", "--first", "5")
        self.assertEqual((1, ["rig_a test_of_noise: 9 of 10 green", "    LAGLESS_SEED=7 LAGLESS_GRID_SEED=7: 3.10 mrad, limit 3.00",
                              "14 of 15 runs green, 93.33 %, of 2 test functions with 5 seeds"]), (done.returncode, done.stdout.splitlines()))

    def test_each_scenario_of_a_grid_is_a_run(self):
        self.build(rig_grid=("rig", GRID))
        done = self.run_tool("--seeds", "2", "--first", "6")
        self.assertEqual((1, ["rig_grid braking: 3 of 4 green", "    LAGLESS_SEED=7 LAGLESS_GRID_SEED=7: shaft light; FAILED  b: 9",
                              "3 of 4 runs green, 75.00 %, of 1 test functions with 2 seeds"]), (done.returncode, done.stdout.splitlines()))

    def test_exit_codes(self):
        """99 of a hundred runs are enough; whole grids and other labels are left out; wrong use; no test to run."""
        self.assertEqual(3, self.run_tool().returncode)
        self.build(rig_a=("rig", PROGRAM.format(red=7)), rig_a_whole=("rig;long;grid", "#!/bin/sh\nexit 1\n"), rig_b=("unit", "#!/bin/sh\nexit 1\n"),
                   board_gates=("board", "#!/bin/sh\nexit 1\n"))
        # With these arguments 101 of 102 runs pass, and 98 of 99.
        for code, words in ((0, ("--seeds", "34", "--first", "1")), (1, ("--seeds", "33", "--first", "1")),
                            (1, ("--seeds", "2", "board_gates")), (3, ("rig_nothing",)),
                            (2, ("--seeds", "0")), (2, ("--first", "x")), (2, ("(",)), (2, ("--unknown",))):
            self.assertEqual(code, self.run_tool(*words).returncode, words)


if __name__ == "__main__":
    unittest.main()
