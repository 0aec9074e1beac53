"""Mistakes and disturbances that a new user meets: two runs into one folder, full disks, drives that stay off, names that are refused.

usage: test_first_hour.py LAGLESS FOLDER"""

import json
import os
import re
import shutil
import subprocess
import sys
import time
import unittest

from command_line import LAGLESS, NO_PICTURES, ROOT, TestCase, document, lagless

WITHOUT_VALGRIND = {**os.environ, "PATH": "/nowhere"}  # `lagless bench` then counts no instructions
MAP = ["map", "--ideal", "--averaged", "--speeds", "300", "--adaptation", "off"]  # the map that takes the least time


class FirstHour(TestCase):
    def out(self, name="out"):
        return os.path.join(self.folder, name)

    def under_way(self, *arguments):
        """Starts a program that has a file open in its folder."""
        running = self.started(*arguments, "--out", self.out())
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline and not (os.path.isdir(self.out()) and os.listdir(self.out())):
            time.sleep(0.01)
        return running


class OneFolder(FirstHour):
    """(a) Two runs into one folder give both results or a clear error, never a mixture."""

    def test_a_second_run_of_the_same_name_is_refused_and_the_first_one_keeps_its_result(self):
        running = self.under_way("run", self.scenario(duration="3600 s"), "--every", "100")
        second = lagless("run", self.scenario(), "--out", self.out())
        self.expect(3, second, "a.csv.partial: another run is writing it")
        self.expect(0, lagless("run", self.scenario(name="b.toml"), "--out", self.out()))  # a run with another name may use the folder
        running.terminate()
        self.assertEqual(1, running.wait(60))
        self.assertEqual(["a.csv", "b.csv"], sorted(os.listdir(self.out())))
        with open(self.out() + "/a.csv") as file:
            rows = [line for line in file if not line.startswith("#")]
        self.assertEqual("time", rows[0][:4])
        times = [float(row.split(",")[0]) for row in rows[1:]]
        self.assertEqual([round(0.01 * n, 4) for n in range(len(times))], times)
        self.expect(0, lagless("run", self.scenario(), "--force", "--out", self.out()))  # nothing prevents this run any more

    def test_a_killed_run_does_not_block_the_next(self):
        running = self.under_way("run", self.scenario(duration="3600 s"), "--every", "100")
        running.kill()
        running.wait()
        self.expect(0, lagless("run", self.scenario(), "--out", self.out()))
        self.assertEqual(["a.csv"], os.listdir(self.out()))

    def test_a_command_that_fills_a_folder_locks_it(self):
        running = self.under_way("campaign", "--runs", "100000")
        for command in (["map"], ["matrix", "--cell", "stuck_a_rail/off"], ["paper", "fig12"], ["campaign", "--resume"]):
            self.expect(3, lagless(*command, "--out", self.out()), "another lagless writes there")
        self.assertEqual(["campaign.csv"], [name for name in os.listdir(self.out()) if not name.startswith("run-")])
        running.terminate()
        running.wait(60)

    def test_the_old_result_stays_until_the_new_one_is_complete(self):
        os.makedirs(self.out())
        for name, command in (("map.json", ["map"]), ("matrix.json", ["matrix"])):
            path = os.path.join(self.out(), name)
            with open(path, "w") as file:
                file.write("before")
            running = subprocess.Popen([LAGLESS, *command, "--force", "--out", self.out()], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(0.5)
            running.kill()
            running.wait()
            with open(path) as file:
                self.assertEqual("before", file.read())


class Output(FirstHour):
    """(b) Output that cannot be written gives exit 3 for each command; (f) so does a folder that cannot be written."""

    COMMANDS = (["--help"], ["--version"], ["scenarios"], ["params"], ["signals", "--json"], ["explain"], ["explain", "21"],
                ["run", "--help"], ["run", "bare_motor"], ["run", "bare_motor", "--json"], ["run", "nosuch", "--json"], ["reference"],
                ["completion", "bash"], ["man"], ["bench", "--seconds", "0.01"], ["paper", "fig12", "--json"],
                MAP, ["matrix", "--cell", "stuck_a_rail/off"],
                ["campaign", "--runs", "2", "--seconds", "0.1"], ["serve", "bare_motor", "--port", "0", "--until", "60 min"])

    def test_a_full_disk_under_stdout_gives_3(self):
        for command in self.COMMANDS:
            with open("/dev/full", "w") as full:
                self.expect(3, lagless(*command, stdout=full, timeout=60, cwd=self.folder, env=WITHOUT_VALGRIND), "could not be written")

    def test_a_full_disk_under_a_session_gives_3(self):
        target = "tcp://" + self.serve("bare_motor", "--port", "0")[1]
        with open("/dev/full", "w") as full:
            for arguments in (["connect", target], ["connect", target, "--json"]):
                self.expect(3, lagless(*arguments, stdout=full, input="status\n", timeout=60), "could not be written")
            self.expect(3, lagless("scope", target, "--http", "0", "--no-browser", stdout=full, timeout=60), "could not be written")

    def test_a_closed_stdout_gives_3_and_no_file_takes_its_place(self):
        for command in (["params"], ["run", self.scenario(), "--out", self.out()]):
            self.expect(3, lagless(*command, preexec_fn=lambda: os.close(1)), "could not be written")
        with open(self.out() + "/a.csv") as file:
            self.assertEqual("# ", file.read(2))
            self.assertNotIn("a test\n0.2", file.read())

    def test_without_output_no_stdout_is_needed(self):
        with open("/dev/full", "w") as full:
            self.expect(0, lagless("run", self.scenario(), "--quiet", stdout=full))

    def test_a_folder_that_cannot_be_written_gives_3_before_the_run(self):
        for command in (["run", self.scenario()], ["map"], ["matrix", "--cell", "stuck_a_rail/off"], ["paper"], ["campaign"]):
            for folder in ("/proc/nothing", "/dev/null/x"):
                begun = time.monotonic()
                self.expect(3, lagless(*command, "--out", folder), folder[:9])
                self.assertLess(time.monotonic() - begun, 5.0)


class Report(FirstHour):
    """(d) `lagless paper` with one figure does not overwrite the whole report."""

    def test_a_report_with_other_figures_is_not_replaced(self):
        os.makedirs(self.out() + "/data")
        for name in ("rows.json", "report.json", "data/fig04.csv", "data/fig12.csv"):
            with open(os.path.join(self.out(), name), "w") as file:
                file.write(name)
        self.expect(2, lagless("paper", "fig12", "--out", self.out()), "holds a report with fig04", "--out")
        for name in ("rows.json", "report.json", "data/fig12.csv"):
            with open(os.path.join(self.out(), name)) as file:
                self.assertEqual(name, file.read())


class Names(FirstHour):
    """(h) One name for the number of periods per sample; input from stdin; the settings that --set can change."""

    def test_every_means_the_same_in_each_place(self):
        times = []
        path = self.scenario(name="a.toml")
        with open(path) as file:
            text = file.read()
        with open(path, "w") as file:
            file.write(text.replace("[params]", "every = 40\n[params]"))
        for arguments in ([path], [self.scenario(name="b.toml"), "--every", "40"], [self.scenario(name="c.toml"), "--set", "run.every=40"]):
            result = json.loads(lagless("run", *arguments, "--json", "--traces", "--record", "i_q").stdout)
            times.append(result["traces"][0]["values"])
        self.assertEqual([round(0.004 * n, 4) for n in range(50)], times[0])
        self.assertEqual([times[0]] * 2, times[1:])

    def test_a_scenario_comes_from_stdin(self):
        with open(self.scenario()) as file:
            text = file.read()
        done = lagless("run", "-", "--out", self.out(), "--json", input=text)
        self.expect(0, done)
        self.assertEqual([self.out() + "/stdin.csv"], json.loads(done.stdout)["files"])
        self.assertEqual(json.loads(lagless("run", self.scenario(), "--json").stdout)["state_hash"], json.loads(done.stdout)["state_hash"])
        self.expect(2, lagless("run", "-", input=text + "[rgi]\n"), "stdin:10:", "rgi")
        self.expect(2, lagless("run", "-"), "stdin:1:1: schema: it is missing")
        self.expect(0, lagless("serve", "-", "--port", "0", "--free", "--until", "0.1 s", input=text), "listening on")

    def test_set_changes_duration_and_start_and_help_states_it(self):
        result = json.loads(lagless("run", self.scenario(), "--set", "run.duration=0.1 s", "--set", "start.speed=200 r/min", "--set",
                                    "start.angle=30 deg", "--json", "--traces", "--record", "true_omega_m").stdout)
        self.assertEqual(1000, result["periods"])
        self.assertAlmostEqual(200 * 3.14159265 / 30, result["traces"][1]["values"][0], places=2)
        told = " ".join(lagless("run", "--help").stdout.split())
        for name in ("run.duration", "run.seed", "run.every", "start.speed", "start.angle"):
            self.assertIn(name, told)
            self.assertIn(name, lagless("man").stdout)
        for name in ("--set run.duration=", "start.speed", "start.angle", "run.seed", "run.every", "lagless run -"):
            self.assertIn(name, document("docs/command_line.md"))

    def test_set_replaces_a_wrong_value_of_the_file(self):
        path = self.scenario("[plant]\ninertia = -1\ndc_voltage = \"310 A\"\n[start]\nspeed = \"fast\"\n", duration="2 h")
        mended = ["--set", "inertia=0.05", "--set", "dc_voltage=310", "--set", "start.speed=0", "--set", "run.duration=0.2 s"]
        self.expect(0, lagless("run", path, *mended))
        for left, name in ((2, "inertia"), (8, "duration")):
            self.expect(2, lagless("run", path, *mended[:left - 2], *mended[left:]), path + ":", " %s: " % name)


class Measures(FirstHour):
    """(k) A number without a limit, samples in JSON, units in the keys of JSON."""

    MEASURE = '[[measure]]\nname = "how high"\nsignal = "true_omega_m"\nstatistic = "max"\nfrom = "0.15 s"\n'

    def test_a_measure_reports_a_number_and_fails_nothing(self):
        path = self.scenario(self.MEASURE)
        done = lagless("run", path)
        self.expect(0, done)
        rpm, = re.findall(r"^measured    how high: max of true_omega_m from 150 ms to 200 ms: ([\d.]+) r/min$", done.stdout, re.M)
        measure, = json.loads(lagless("run", path, "--json").stdout)["measures"]
        self.assertEqual(["name", "signal", "minus", "statistic", "unit", "from_s", "to_s", "value", "verdict"], list(measure))
        self.assertEqual(("measured", "rad/s"), (measure["verdict"], measure["unit"]))
        self.assertAlmostEqual(float(rpm) * 3.14159265 / 30, measure["value"], places=3)
        # Only the end of the run fails: `enable` is refused, and no expectation names that.
        self.expect(1, lagless("run", path, "--set", "plant.dc_voltage=150"), "measured ", "end of the run: the drive refuses `enable` with ")
        self.assertEqual("", lagless("run", path, "--quiet").stdout)

    def test_a_measure_has_no_limits(self):
        self.expect(2, lagless("run", self.scenario(self.MEASURE + "at_most = 1\n")), "at_most", "[[expect]] has limits")

    def test_traces_are_what_a_recording_has(self):
        result = json.loads(lagless("run", self.scenario(), "--json", "--traces", "--record", "i_q,state,plant.inertia", "--every", "50",
                                    "--out", self.out()).stdout)
        self.assertEqual([("time", "s"), ("i_q", "A"), ("state", "-"), ("inertia", "kg m^2")], [(t["name"], t["unit"]) for t in result["traces"]])
        with open(self.out() + "/a.csv") as file:
            rows = [line.rstrip().split(",") for line in file if not line.startswith("#")][1:]
        self.assertEqual(40, len(rows))
        for n, trace in enumerate(result["traces"]):
            for row, value in zip(rows, trace["values"]):
                self.assertAlmostEqual(float(row[n]), value, delta=1e-7 * abs(value))
        self.expect(2, lagless("run", self.scenario(), "--traces"), "--traces needs --json")
        self.assertNotIn("traces", json.loads(lagless("run", self.scenario(), "--json").stdout))


class Tables(FirstHour):
    """(j) Lists are complete and printed in columns."""

    def test_columns_begin_where_they_begin_in_every_line(self):
        for command, pattern in ((["explain"], r"^ *\d+ +\w+ +(?=\S)"), (["scenarios"], r"^\w+ +[\d.]+ s +(?=\S)"),
                                 (["params"], r"^ +\d+ +\w+ +(?=\S)"), (["signals"], r"^ +\d+ +\w+ +\S.*?  +(?=\S)")):
            text = lagless(*command).stdout
            for block in text.split("\n\n"):
                begins = {len(match) for match in re.findall(pattern, block, re.M)}
                self.assertEqual(1, len(begins or {0}), (command, begins, block[:200]))
        for line in lagless("explain").stdout.splitlines():
            self.assertRegex(line, r"^ *\d+  \w+ {2,}\S")

    def test_a_claim_without_a_number_in_print_has_none_that_is_expected(self):
        lagless("paper", "fig10", "--out", self.out(), env=NO_PICTURES)
        with open(self.out() + "/report.json") as file:
            rows = {row["id"]: row for row in json.load(file)["rows"]}
        self.assertIsNone(rows["fig10.ripple.real"]["expected"])
        for row in rows.values():
            if row["expected"] is not None:
                self.assertGreater(row["tolerance"], 0.0, row["id"])


class Documents(FirstHour):
    """(e) The command lines in the documents work after the steps before them; (j), (k) the statements of the documents on CSV, JSON and
    exit codes are true."""

    def blocks(self):
        """The indented blocks of the documents, with the lines above them."""
        for folder, _, names in os.walk(os.path.join(ROOT, "docs")):
            for name in sorted(names) + (["../README.md"] if folder.endswith("docs") else []):
                if name.endswith(".md"):
                    lines = document(os.path.join(folder, name)).splitlines()
                    for number, line in enumerate(lines):
                        if line.startswith("    ") and "ctest " in line:
                            yield name, line, lines[:number]

    def test_a_ctest_line_has_its_build_above_it_and_finds_tests(self):
        found = 0
        for name, line, above in self.blocks():
            for preset, rest in re.findall(r"ctest --preset (\w+)([^&]*)", line):
                found += 1
                for step in ("cmake --preset " + preset, "cmake --build --preset " + preset):
                    self.assertTrue([one for one in [*above, line.split("ctest")[0]] if one.startswith("    ") and re.search(step + r"\b(?! --target)", one)],
                                    "%s: %s: `%s` is not above it" % (name, line, step))
                if preset == "host" and shutil.which("ctest"):
                    tests = subprocess.run(["ctest", "--test-dir", os.path.dirname(LAGLESS), "-N", *rest.replace("-V", "").split()], capture_output=True, text=True)
                    self.assertNotIn("Total Tests: 0", tests.stdout, line)
        self.assertGreaterEqual(found, 4)

    def test_a_preset_without_its_toolchain_says_which_package_brings_it(self):
        tools = os.path.join(self.folder, "bin")
        os.makedirs(tools)
        for program in ("cmake", "ninja"):
            if shutil.which(program) is None:
                self.skipTest("no " + program)
            os.symlink(shutil.which(program), os.path.join(tools, program))
        for preset, package, words in (("m4f", "gcc-arm-none-eabi", "arm-none-eabi-gcc is missing"), ("avr", "gcc-avr", "avr-gcc is missing"),
                                       ("f28335-flash", "docs/chip.md", "C2000_CGT_ROOT is not set")):
            settings = {key: value for key, value in os.environ.items() if not key.startswith(("CMAKE_", "C2000", "CC"))}
            done = subprocess.run(["cmake", "--preset", preset, "-S", ROOT, "-B", self.out(preset)], cwd=ROOT, capture_output=True, text=True,
                                  env={**settings, "PATH": tools})
            self.assertNotEqual(0, done.returncode)
            said = " ".join(done.stderr.split())
            self.assertIn(words, said)
            self.assertIn(package, said)

    def test_exit_codes_are_those_that_the_manual_has(self):
        told = re.findall(r"^\| (\d) \| (\w+)", document("docs/command_line.md"), re.M)
        self.assertEqual(["0", "1", "2", "3"], [code for code, _ in told])
        self.assertEqual(["0", "1", "2", "3"], re.findall(r"^\.TP\n(\d)$", lagless("man").stdout, re.M))

    def test_csv_is_read_as_the_document_says(self):
        line, = re.findall(r'^    pandas\.read_csv\("rec/my\.csv", (.*)\)$', document("docs/command_line.md"), re.M)
        self.assertEqual('comment="#"', line)
        path = self.scenario()
        with open(path, "a") as file:
            file.write('# a comment, with "quotes" # and more\n')
        self.expect(0, lagless("run", path, "--out", self.out(), "--record", "i_q,state,plant.inertia"))
        with open(self.out() + "/a.csv") as file:
            lines = [line.partition("#")[0].rstrip("\n") for line in file]  # the lines that a reader with comment="#" gets
        lines = [line.split(",") for line in lines if line]
        self.assertEqual(["time[s]", "i_q[A]", "state[-]", "inertia[kg m^2]"], lines[0])
        self.assertEqual(2000, len([[float(number) for number in line] for line in lines[1:] if len(line) == 4]))
        try:
            import pandas
        except ImportError:
            return
        self.assertEqual((2000, 4), pandas.read_csv(self.out() + "/a.csv", comment="#").shape)

    def numbers(self, value, key=""):
        """The keys of all numbers in this value; tables with names as keys are left out."""
        if isinstance(value, dict):
            for name, inner in value.items():
                yield from self.numbers(inner, name) if name not in ("excuses", "invariants", "reasons", "refusals", "values") or isinstance(inner, list) else ()
        elif isinstance(value, list):
            for inner in value if key != "values" else ():
                yield from self.numbers(inner, key)
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            yield key

    def test_units_of_json_keys_are_as_documented(self):
        section = document("docs/command_line.md").partition("## JSON")[2]
        suffixes = tuple(re.findall(r"`(_\w+)`", section))
        keys = set(re.findall(r"`(\w+)`", section))
        path = self.scenario(Measures.MEASURE)
        for command in (["run", path, "--traces"], ["run", "nosuch"], ["scenarios"], ["params"], ["signals"], ["explain"], ["explain", "21"],
                        ["bench", "--seconds", "0.01"], ["campaign", "--runs", "3", "--seconds", "0.1"], ["matrix", "--cell", "stuck_a_rail/off"], ["matrix", "--share", "0.1"], ["motors"], ["tune", "liu-2019"],
                        MAP, ["paper", "fig12"]):
            for key in set(self.numbers(json.loads(lagless(*command, "--json", env=WITHOUT_VALGRIND).stdout))):
                self.assertTrue(key in keys or key.endswith(suffixes), (command, key))


class Progress(FirstHour):
    """A progress bar with the time left appears on a terminal, and nothing in a pipe."""

    BAR = re.compile(rb"\r\[#*\.*\] +\d+ %  (\d+ min )?\d+ s left")

    def seen(self, arguments, enough, environment=None):
        """The text that the program wrote to a terminal until the required text appeared or the program ended."""
        master, slave = os.openpty()
        running = subprocess.Popen([LAGLESS, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=slave, cwd=self.folder,
                                   env={**os.environ, **(environment or {})})
        os.close(slave)
        text = b""
        try:
            while not enough(text):
                text += os.read(master, 4096)
        except OSError:
            pass
        running.kill()
        running.wait()
        os.close(master)
        return text

    def test_long_work_shows_a_bar_with_the_time_left_on_a_terminal(self):
        for arguments in (["run", self.scenario(duration="3600 s")], ["map"], ["matrix"], ["campaign"], ["paper"]):
            self.assertRegex(self.seen(arguments, self.BAR.search), self.BAR, arguments)

    def test_the_progress_of_pictures_is_shown(self):
        script = os.path.join(self.folder, "python")
        with open(script, "w") as file:
            file.write("#!/bin/sh\nsleep 0.5; echo 0.1 >&$LAGLESS_PROGRESS; sleep 0.2; echo 0.2 >&$LAGLESS_PROGRESS; sleep 5\n")
        os.chmod(script, 0o755)
        drawn = self.seen(["paper", "fig12"], lambda text: self.BAR.search(text.partition(b"drawing")[2]), {"LAGLESS_PYTHON": script})
        self.assertRegex(drawn.partition(b"drawing")[2], self.BAR)

    def test_the_report_shows_how_far_its_pictures_are(self):
        reading, writing = os.pipe()
        done = subprocess.run([sys.executable, "-B", "-c", "import progress; progress.tell(0.25)"], pass_fds=[writing],
                              cwd=os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tools/plot"),
                              env={**os.environ, "LAGLESS_PROGRESS": str(writing)})
        os.close(writing)
        with open(reading) as file:
            self.assertEqual((0, 0.25), (done.returncode, float(file.read())))

    def test_a_pipe_gets_no_progress_bar(self):
        done = lagless("run", self.scenario(duration="10 s"))
        self.assertEqual((0, ""), (done.returncode, done.stderr))


class Json(FirstHour):
    """(k) With --json an error is printed as JSON too."""

    def error(self, code, *arguments):
        done = lagless(*arguments, "--json")
        self.assertEqual(code, done.returncode, done.stderr)
        error = json.loads(done.stdout)["error"]
        self.assertEqual(["exit_code", "message", "file", "line", "column", "name"], list(error))
        self.assertEqual((code, done.stderr.strip()), (error["exit_code"], error["message"]))
        return error

    def test_an_error_is_one_object_with_the_message(self):
        for code, arguments, fragment in ((2, ["rnu"], "did you mean run?"), (2, ["run", "nosuch"], "neither a file"),
                                          (3, ["run", self.scenario(), "--out", "/dev/null/x"], "/dev/null"), (2, ["matrix", "--cell", "x"], "no cell"),
                                          (2, ["connect", "nowhere"], "nowhere")):
            error = self.error(code, *arguments)
            self.assertIn(fragment, error["message"])
            self.assertIsNone(error["file"])

    def test_an_error_in_a_file_has_its_place(self):
        path = self.scenario("[rig]\nfidelty = \"averaged\"\n")
        for command in ("run", "map"):
            error = self.error(2, command, path)
            self.assertEqual((path, 11, 1, "fidelty"), tuple(error[key] for key in ("file", "line", "column", "name")))
            self.assertIn("nearest: fidelity", error["message"])


class Manual(FirstHour):
    """(i) The manual page explains every option in the words of --help."""

    def test_every_option_of_every_command_is_in_the_manual_with_its_text(self):
        page = lagless("man").stdout.replace("\\-", "-").replace("\\fB", "").replace("\\fI", "").replace("\\fR", "")
        sections = dict(re.findall(r'^\.SS "lagless (\w+)([^"]*"\n.*?)(?=^\.S[SH] )', page, re.M | re.S))
        commands = re.findall(r"^  (\w+) ", lagless("--help").stdout, re.M)
        self.assertEqual(commands, list(sections))
        for command, section in sections.items():
            told = lagless(command, "--help").stdout
            self.assertTrue(told.startswith("Usage: lagless " + command), told)
            options = [name for name in re.findall(r"--([a-z-]+)", told) if name not in ("help", "usage", "version")]
            for option in options:
                if re.search(r"^ .*--%s\b" % option, told, re.M):
                    self.assertRegex(section, r"(?m)^(-., )?--%s(=.*)?\n\S" % option)
        self.assertIn("--set=NAME=VALUE\n", sections["run"])
        self.assertIn("its duration and its expectations have no effect", " ".join(sections["serve"].split()))

    def test_the_page_is_one_that_man_takes(self):
        if shutil.which("groff") is None:
            self.skipTest("no groff")
        done = subprocess.run(["groff", "-man", "-Tascii", "-ww"], input=lagless("man").stdout, capture_output=True, text=True)
        self.assertEqual((0, ""), (done.returncode, done.stderr))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
