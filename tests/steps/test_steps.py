"""The steps of tools/check: failures, steps that run in parallel, steps that were not checked. usage: test_steps.py CTEST"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

CTEST = sys.argv[1]
TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"

# Four tests in the form in which CMake gives them to ctest.
TESTS = """add_test(done "/bin/sh" "-c" "exit 0")
add_test(without_tool "/bin/sh" "-c" "exit 77")
set_tests_properties(without_tool PROPERTIES SKIP_RETURN_CODE 77)
add_test(partly "/bin/sh" "-c" "echo Ran 9 tests; echo; echo 'OK (skipped=2)'")
add_test(ignored "/bin/sh" "-c" "echo 7 Tests 0 Failures 3 Ignored; echo OK")
"""


class Steps(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_steps_"))
        (self.folder / "tools").mkdir()
        shutil.copy(TOOLS / "steps.sh", self.folder / "tools")

    def tearDown(self):
        shutil.rmtree(self.folder)

    def run_script(self, text, ci=None, path=None):
        (self.folder / "script").write_text("set -eu\n. tools/steps.sh\n" + text)
        environment = {key: value for key, value in os.environ.items() if key != "CI"}
        if ci is not None:
            environment["CI"] = ci
        if path is not None:
            environment["PATH"] = path
        return subprocess.run(["/bin/sh", "script"], cwd=self.folder, env=environment, capture_output=True, text=True, check=False)

    def log(self, name):
        return (self.folder / "build/log" / name).read_text()

    # ---- steps ----

    def test_a_failing_step_shows_what_it_printed_and_ends_the_script(self):
        done = self.run_script("step a 'one' echo quiet\nstep a 'two' sh -c 'echo why; exit 5'\necho after\n")
        self.assertEqual(1, done.returncode)
        self.assertRegex(done.stdout, r"^one +[0-9]+ s\ntwo +[0-9]+ s  FAILED\n$")
        self.assertIn("why", done.stderr)
        self.assertNotIn("quiet", done.stderr)

    def test_a_script_that_is_called_adds_its_steps_to_those_of_its_caller(self):
        (self.folder / "inner").write_text(". tools/steps.sh\nstep a inner true\n")
        done = self.run_script("""step a before true\nSTEPS_OF_CALLER=yes sh inner\nunchecked 'a tool'
            beside lane env STEPS_OF_CALLER=yes sh inner\nstep a after true\nbeside_end lane\n""")
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        rows = [line.split("\t")[0] for line in self.log("steps.tsv").splitlines()]
        self.assertEqual(["after", "before", "inner", "inner"], sorted(rows))
        self.assertEqual("a tool\n", self.log("unchecked"))

    def test_a_parallel_step_is_reported_where_it_is_waited_for(self):
        done = self.run_script("""lane() { step a 'first of the lane' sleep 0.2; step a 'second of the lane' true; }
            beside lane lane
            step b 'in front' true
            beside_end lane
            echo end\n""")
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        self.assertEqual(["in front", "first of the lane", "second of the lane", "end"],
                         [line.split("  ")[0] for line in done.stdout.splitlines()])

    def test_a_failure_of_a_parallel_step_ends_the_script_at_its_next_step(self):
        done = self.run_script("""lane() { step a 'bad' sh -c 'echo because; exit 3'; echo no further; }
            beside lane lane
            while [ ! -s build/log/lane.ended ]; do sleep 0.05; done
            step b 'in front' true
            echo after\n""")
        self.assertEqual(1, done.returncode)
        self.assertRegex(done.stdout, r"^in front +[0-9]+ s\nbad +[0-9]+ s  FAILED\n")
        self.assertIn("because", done.stdout)
        self.assertNotIn("after", done.stdout)
        self.assertNotIn("no further", done.stdout)

    def test_a_failing_step_ends_the_parallel_steps(self):
        begun = time.monotonic()
        done = self.run_script("""lane() { step a 'long' sh -c 'echo $$ >pid; exec sleep 60'; }
            beside lane lane
            while [ ! -s pid ]; do sleep 0.05; done
            step b 'bad' false\n""")
        self.assertEqual(1, done.returncode)
        self.assertLess(time.monotonic() - begun, 30.0)
        process = int((self.folder / "pid").read_text())
        for _ in range(100):
            if not pathlib.Path(f"/proc/{process}/stat").exists() or not alive(process):
                return
            time.sleep(0.05)
        self.fail("the step beside still runs")

    def test_processor_seconds_of_a_step_do_not_include_parallel_steps(self):
        busy = "i=0; while [ $i -lt 400000 ]; do i=$((i + 1)); done"
        done = self.run_script(f"""lane() {{ step a idle true; step a busy sh -c '{busy}'; }}
            beside lane lane
            while [ ! -s build/log/lane.ended ]; do sleep 0.05; done
            step b 'in front' true
            beside_end lane
            step b after sh -c '{busy}'\n""")
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        spent = {text: float(after) - float(before) for text, _, before, after in
                 (line.split("\t") for line in self.log("steps.tsv").splitlines())}
        self.assertGreater(spent["busy"], 0.1)
        self.assertGreater(spent["after"], 0.1)
        self.assertLess(spent["in front"], 0.05)
        self.assertLess(spent["idle"], 0.05)

    # ---- what was not checked ----

    def test_what_could_not_be_checked_is_reported_and_a_failure_under_ci(self):
        line = "dialect: not checked, this machine has no no_such_tool (tools/setup installs it)"
        done = self.run_script("tools_here dialect sh no_such_tool && echo wrong\nsteps_unchecked\necho end\n")
        self.assertEqual((0, [line, "", "not checked, 1:", "  " + line, "end"]), (done.returncode, done.stdout.splitlines()), done.stderr)
        for script, ci, code, told in (("tools_here dialect no_such_tool || true\nsteps_unchecked\necho end\n", "true", 1, "  dialect: not checked"),
                                       ("tools_here dialect sh\nsteps_unchecked\necho end\n", "true", 0, "end"),
                                       ("lane() { unchecked 'x: not checked'; }\nbeside lane lane\nbeside_end lane\nsteps_unchecked\n", "1", 1,
                                        "  x: not checked")):
            with self.subTest(script=script):
                done = self.run_script(script, ci=ci)
                self.assertEqual((code, code == 1), (done.returncode, "CI is set" in done.stderr))
                self.assertIn(told, done.stdout.splitlines()[-1])

    def test_skipped_tests_are_reported_and_a_failure_under_ci_and_skipped_parts_are_reported(self):
        build = self.folder / "build/preset"
        build.mkdir(parents=True)
        rows = TESTS.splitlines()
        for tests, ci, code, told in ((TESTS, None, 0, ["preset: test without_tool was skipped", "preset: test partly skipped 2 of its parts",
                                                        "preset: test ignored skipped 3 of its parts"]),
                                      ("\n".join(rows[:3]), "yes", 1, ["preset: test without_tool was skipped"]),
                                      (rows[3], "yes", 0, ["preset: test partly skipped 2 of its parts"]), (rows[0], "yes", 0, []),
                                      ("", None, 1, ["FAILED"])):
            with self.subTest(tests=tests, ci=ci):
                (build / "CTestTestfile.cmake").write_text(tests)
                done = self.run_script(f"""step preset ctest '{CTEST}' --test-dir build/preset --no-tests=error
                    steps_skipped preset preset
                    steps_skipped_inside build/preset preset
                    steps_unchecked\n""", ci)
                self.assertEqual(code, done.returncode, done.stdout + done.stderr)
                for text in told:
                    self.assertIn(text, done.stdout)
                shutil.rmtree(self.folder / "build/log")


def alive(process):
    """The process is running: it has neither ended nor become a zombie."""
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
