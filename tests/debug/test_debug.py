#!/usr/bin/env python3
"""The debugger's commands, in gdb sessions on debug_ring: moving to a period forwards and backwards, until-fault, why,
registers, printers, wrong use; the front-end protocol as VS Code uses it, with the settings of .vscode/launch.json; and tools/debug.

usage: test_debug.py --root FOLDER --program DEBUG_RING
Ends with 77 (skipped) where no gdb with Python can run a program."""
import argparse
import functools
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PARSER = argparse.ArgumentParser()
PARSER.add_argument("--root", type=pathlib.Path, required=True)
PARSER.add_argument("--program", type=pathlib.Path, required=True)
OPTIONS, REST = PARSER.parse_known_args()
ROOT = OPTIONS.root.resolve()
PROGRAM = OPTIONS.program.resolve()
SCRIPT = ROOT / "tools" / "gdb" / "lagless.py"
SKIPPED = 77
SECONDS = 120  # a session that takes longer is judged as hanging

# Times of the drive [periods of 100 us]. Windows begin with period 0. The medium task runs at the end of each window, and its setpoints act
# from the end of the next window on.
WINDOW = 8
CALIBRATION = 64 + 512  # number of samples; the first is that of period 0


def end_of_window(period):
    """The first period after the window that contains this period."""
    return (period // WINDOW + 1) * WINDOW

# LeakSanitizer cannot work under a debugger; the other sanitizers can.
ENVIRONMENT = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0", "LC_ALL": "C"}
ENVIRONMENT.pop("LAGLESS_STOP", None)
ENVIRONMENT.pop("DEBUGINFOD_URLS", None)


def run(line, **more):
    return subprocess.run(
        [str(word) for word in line], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
        text=True, timeout=SECONDS, check=False, **{"env": ENVIRONMENT, **more}
    )


def why_not():
    """The reason why no session is possible on this machine; "" if one is possible."""
    if shutil.which("gdb") is None:
        return "no gdb"
    if "yes" not in run(["gdb", "-nx", "-q", "-batch", "-ex", "python print('y' + 'es')"]).stdout:
        return "gdb without Python"
    tried = run(["gdb", "-nx", "-q", "-batch", "-ex", "run", "--args", PROGRAM, "1"]).stdout
    return "" if "exited normally" in tried else "gdb cannot run a program here: " + " ".join(tried.split())


class Gdb:
    """One gdb for all sessions, which reads the symbols of the program once. Each session begins without a running program and without
    breakpoints."""

    RESET = ("delete", "kill", "unset environment LAGLESS_STOP")

    def __init__(self):
        self.process = subprocess.Popen(
            [str(word) for word in ("gdb", "-nx", "-q", "-ex", "set confirm off", "-ex", "set width 0", "-ex", "set height 0",
                                    "-ex", "set prompt", "-x", SCRIPT, PROGRAM)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT)

    def told(self, commands):
        """The output of each of these commands."""
        self.process.stdin.write("".join(f"echo @@@\\n\n{command}\n" for command in commands) + "echo @@@\\n\n")
        self.process.stdin.flush()
        parts = [[]]
        while len(parts) <= len(commands) + 1:
            line = self.process.stdout.readline()
            assert line, f"gdb ended: {parts}"
            if line.endswith("@@@\n"):
                parts[-1].append(line[:-4])
                parts.append([])
            else:
                parts[-1].append(line)
        return ["".join(part) for part in parts[1:-1]]

    def end(self):
        self.process.kill()
        self.process.communicate()


shared = None


def anew():
    """Makes the next session use another gdb."""
    global shared
    if shared:
        shared.end()
    shared = None


def session(*commands, arguments=("200000",)):
    """Runs gdb commands on the program, which is not started yet. Returns the output of each command in their order."""
    global shared
    gdb, shared = shared or Gdb(), None  # a gdb that hangs or ends is not used again
    hanging = threading.Timer(SECONDS, gdb.end)
    hanging.start()
    try:
        gdb.told([*Gdb.RESET, "set args " + " ".join(arguments)])
        parts = gdb.told(commands)
    except BaseException:
        gdb.end()
        raise
    finally:
        hanging.cancel()
    shared = gdb
    for part in parts:
        assert "Traceback" not in part and "Python Exception" not in part, part
    return [part.strip() for part in parts]


def place(text):
    """(period, tick) from the output of where-time."""
    match = re.fullmatch(r"period (\d+), [0-9.]+ s \+ [0-9.]+ us; chip tick (\d+) of 150 MHz", text)
    assert match, text
    return int(match[1]), int(match[2])


def of_both_sensors(test):
    """Runs the test also with sensors = exact. The sample interrupt is the same then; a call of the simulation is between it and the
    drive's step."""

    @functools.wraps(test)
    def both(self):
        for sensors in ((), ("exact",)):
            with self.subTest(sensors=sensors):
                test(self, sensors)

    return both


class TravelTest(unittest.TestCase):
    @of_both_sensors
    def test_period_stops_on_the_first_of_the_interrupts_three_lines_forward_and_back(self, sensors):
        shown, trace, hash_1, back, hash_2, _, hash_3, here = session(
            "period 1234", "backtrace 1", "rig-hash", "period -2", "rig-hash", "period +2", "rig-hash", "period 1234",
            arguments=("2000", *sensors))
        self.assertRegex(shown, r"^period 1234, 0\.1234 s \+ \d\.\d\d us\n#0  app_interrupt \(\)")
        for line in ("app_read(&samples);", "if (drive_step(&app->drive, &samples, &command)) {", "app_write(&command);"):
            self.assertEqual(shown.count(line), 1, shown)
        self.assertIn("#0  app_interrupt ()", trace)
        self.assertRegex(back, r"^period 1232, ")
        self.assertEqual(hash_3, hash_1)
        self.assertNotEqual(hash_2, hash_1)
        self.assertEqual(here.splitlines()[:2], shown.splitlines()[:2])

    def test_own_breakpoint_stops_forward_but_not_back(self):
        _, _, forward, back, listed = session(
            "period 60", "break drive_step", "period 90", "period 40", "info breakpoints"
        )
        self.assertIn("stopped before that: period 60,", forward)
        self.assertTrue(back.startswith("period 40, "), back)
        self.assertRegex(listed, r"keep y .*drive_step")

    def test_program_that_is_too_short_reports_it(self):
        text, after, again = session("period 500", "why", "period 20", arguments=("100",))
        self.assertIn("the program ended before period 500: it has 100, 0 to 99", text)
        self.assertIn("no program is running", after)
        self.assertTrue(again.splitlines()[0].startswith("period 20, "), again)

    @of_both_sensors
    def test_stop_by_environment_needs_no_command(self, sensors):
        _, text = session("set environment LAGLESS_STOP 77", "run", arguments=("100", *sensors))
        self.assertIn("period 77, 0.0077 s", text)
        self.assertIn("app_interrupt ()" if sensors else "const uint32_t begin = hal_time();", text)


class FaultTest(unittest.TestCase):
    @of_both_sensors
    def test_until_fault_stops_in_the_period_of_an_injected_trip_and_why_names_it(self, sensors):
        text, where, why, state = session(
            "until-fault", "where-time", "why", "print app->drive.state", arguments=("30000", "20000", *sensors)
        )
        self.assertEqual(place(where)[0], 20000)
        self.assertTrue(text.startswith("fault 20, module_fault, by show_fault < show_stop < drive_trip\n"), text)
        self.assertIn("app_trip ()", text)
        self.assertIn("fault 20, module_fault: the power module activated its fault output", why)
        self.assertIn("remedy: search for a short circuit", why)
        self.assertIn("when: period 20000 by the drive's count, 2.0000 s", why)
        self.assertRegex(why, r"then: i_a \S+ A, i_b \S+ A, u_dc 31\d(\.\d+)? V, theta_e \S+ deg, omega_e \S+ rad/s")
        self.assertRegex(state, r"= 5$")

    def test_until_fault_finds_a_fault_of_the_step_itself(self):
        # The trip limit is set to 10 mA: the next sample of a motor under load is above it.
        _, _, text, where, why = session(
            "period 10000", "set variable app->drive.tunings[app->drive.in_force].fast.guard.limit[FAULT_LIMIT_OVERCURRENT] = 0.01f", "until-fault",
            "where-time", "why", arguments=("30000",)
        )
        self.assertEqual(place(where)[0], 10000)
        self.assertRegex(text, r"^fault 21, overcurrent, by show_fault < show_stop < drive_step\n")
        self.assertIn("app_interrupt ()", text)
        self.assertIn("fault 21, overcurrent: a phase current exceeded overcurrent_trip", why)

    def test_until_fault_stops_at_its_limit(self):
        text, where, refused = session("until-fault 3000", "where-time", "until-fault 3000", arguments=("4000",))
        self.assertTrue(text.startswith("no fault before period 3000"), text)
        self.assertEqual(place(where)[0], 3000)
        self.assertIn("#0  app_interrupt ()", text)
        self.assertEqual(refused, "until-fault 3000: this is period 3000 already")

    def test_why_of_a_later_fault_names_it(self):
        # The voltage of the DC link is raised above the trip. The next two samples record the fault in the fast task, and the medium task
        # reads it at the end of their window, which begins with period 2000.
        _, _, _, why = session(
            "until-fault", "set variable app->drive.tunings[app->drive.in_force].fast.guard.limit[FAULT_LIMIT_DC_OVERVOLTAGE] = 1.0f", "period 2010",
            "why", arguments=("30000", "2000"),
        )
        self.assertIn("fault 20, module_fault", why)
        self.assertIn("later: dc_overvoltage", why)
        self.assertIn("refusal 3, fault_present", why)

    HISTORY = re.compile(r"(?m)^  the last (\d+) of (\d+) periods that the drive has kept:\n((?:    .*\n?)+)")

    def history(self, why):
        """The history in the output of why, as (shown, kept, {row: [(unit, value, ...)]}); the first column is `period`."""
        match = self.HISTORY.search(why)
        self.assertIsNotNone(match, why)
        names, units, *rows = match[3].splitlines()
        ends = [word.end() for word in re.finditer(r"\S+", names)]
        starts = [0, *ends[:-1]]
        columns = {names[a:b].strip(): (units[a:b].strip(), [row[a:b].strip() for row in rows]) for a, b in zip(starts, ends)}
        return int(match[1]), int(match[2]), columns

    def test_why_shows_the_last_periods_before_a_fault_of_the_step(self):
        _, before, _, _, why, again = session(
            "period 10000", "print app->drive.fast.measure.measured.current_abc.b",
            "set variable app->drive.tunings[app->drive.in_force].fast.guard.limit[FAULT_LIMIT_OVERCURRENT] = 0.01f", "until-fault", "why",
            "print app->drive.fast.measure.measured.current_abc.b",
        )
        shown, kept, columns = self.history(why)
        self.assertEqual((shown, kept), (8, 341))
        self.assertEqual(
            list(columns),
            "period state i_a i_b u_dc i_d i_q i_q_ref u_d u_q theta_e omega_e sample_flags".split(),
        )
        self.assertEqual([columns[name][0] for name in ("i_a", "u_dc", "theta_e", "omega_e")], ["A", "V", "rad", "rad/s"])
        # Period 10000 of the simulation is the drive's 10001st. This is the period of the fault, and the last row.
        self.assertEqual(columns["period"][1], [str(n) for n in range(9994, 10002)])
        self.assertEqual(columns["state"][1], ["operation_enabled"] * 7 + ["fault"])
        self.assertAlmostEqual(float(columns["i_b"][1][-2]), float(before.split("=")[1]), delta=1e-4)
        self.assertAlmostEqual(float(columns["i_b"][1][-1]), float(again.split("=")[1]), delta=1e-4)
        self.assertNotEqual(columns["i_b"][1][-2], columns["i_b"][1][-1])

    def test_why_names_a_warning_that_holds(self):
        # The fault comes 0.1 s after the heat sink, at 40 degC, has exceeded the limit.
        _, _, _, before, _, why, drive = session(
            "period 8000", "set variable app->drive.tunings[app->drive.in_force].medium.guard.limit[FAULT_LIMIT_SINK_WARM] = 30.0f", "period 8999", "why",
            "period 9017", "why", "drive",
        )
        self.assertEqual(before, "nothing is wrong: the drive is in operation_enabled")
        self.assertEqual(
            why.splitlines(),
            ["warning 37, sink_warm: the heat sink is within 10 K of sink_temperature_max",
             "  remedy: reduce load or improve cooling before it stops the drive"],
        )
        self.assertRegex(drive, r"(?m)^warnings +sink_warm$")

    def test_why_names_a_refusal_and_reports_when_nothing_is_wrong(self):
        _, refused, _, good = session("period 100", "why", "period 8000", "why")
        self.assertIn("refusal 1, not_ready: the current offsets are still being measured", refused)
        self.assertIn("remedy: wait; it takes a tenth of a second with the bridge off", refused)
        self.assertEqual(good, "nothing is wrong: the drive is in operation_enabled")

    def test_why_names_a_wrong_use_of_the_chip(self):
        # A trip-zone register is written without EALLOW.
        _, _, why = session("period 8000", "call bus_write16(&((f28335_t *)f28335_base)->epwm[1].TZSEL, 0)", "why")
        self.assertRegex(why, r"^chip: 1 wrong use found, the last at tick \d+: protected write, EPWM2\.TZSEL$")


class ManoeuvreTest(unittest.TestCase):
    def setUp(self):
        anew()  # gdb reads the names of manoeuvres only in a program that runs or has never run

    # The drive is ready in the window with the last sample of the calibration. The next window switches it on, and that setpoint acts a
    # window later; there the gates turn on in the second period. The catch takes 20 ms; in its last period the estimator would lock to a
    # rotor that turns. The medium task has read the result, "no rotation", at the end of the window before, and counts the windows of the
    # alignment from then on. The alignment takes 16 over the pendulum's frequency sqrt(p K_t I / J).
    ON = end_of_window(CALIBRATION - 1) + 2 * WINDOW
    CAUGHT = end_of_window(ON + 1 + 199 - 1)
    ALIGNED = CAUGHT + WINDOW * round(1e4 / WINDOW * 16 / math.sqrt(4 * 1.5 * 4 * 0.183 * 10 / 0.0636))

    def test_until_manoeuvre_stops_in_the_period_that_begins_it(self):
        text, where, drive, before, once_more, again = session(
            "until-manoeuvre ramp", "where-time", "drive", "period -1", "until-manoeuvre ramp", "where-time"
        )
        self.assertTrue(text.startswith("ramp, start_try 1\n"), text)
        self.assertIn("app_interrupt ()", text)
        self.assertEqual(place(where)[0], self.ALIGNED)
        self.assertRegex(drive, r"(?m)^manoeuvre  ramp$")
        self.assertIn(f"period {place(where)[0] - 1},", before)
        self.assertTrue(once_more.startswith("ramp, start_try 1\n"), once_more)
        self.assertEqual(where, again)

    def test_until_manoeuvre_waits_for_the_next_beginning_of_one_that_is_under_way(self):
        _, text, unknown = session("until-manoeuvre align", "until-manoeuvre align", "until-manoeuvre foo", arguments=(str(self.ALIGNED + 100),))
        self.assertIn("the program ended without the manoeuvre align", text)
        self.assertIn("no manoeuvre 'foo': off, catch, align", unknown)  # also after the program has ended


class LookTest(unittest.TestCase):
    def test_drive_speaks_in_names_and_units(self):
        _, text = session("period 30000", "drive")
        rows = {line[:11].strip(): line[11:] for line in text.splitlines()}
        self.assertEqual(rows["state"], "operation_enabled, gates keep")
        self.assertEqual(rows["fault"], "none")
        self.assertEqual(rows["warnings"], "none")
        self.assertEqual(rows["manoeuvre"], "run")
        self.assertEqual(rows["frame"], rows["position"])
        self.assertIn("enable on, mode speed, speed 600.00 r/min", rows["requests"])
        # The speed has settled after 3 s; its ripple is less than 1 % (dead time, encoder).
        speed = float(re.match(r"(\S+) r/min, reference 600.00 r/min$", rows["speed"])[1])
        self.assertAlmostEqual(speed, 600.0, delta=6.0)
        self.assertRegex(
            rows["position"], r"^theta_e -?\d+\.\d\d deg \(-?\d\.\d+ rad\), omega_e 2\d\d\S* rad/s \(\d+\.\d+ Hz\)$"
        )
        self.assertRegex(rows["axis q"], r"^i \S+ A, reference \S+ A; u \S+ V, commanded \S+ V$")
        self.assertRegex(rows["DC link"], r"^31\d\.\d+ V$")

    def test_registers_are_decoded_by_field(self):
        _, blocks, block, one, small, flag, group = session(
            "period 8000", "regs", "regs EPWM1", "regs EPWM1.TBCTL", "regs epwm2.tbprd", "regs EPWM3.TZFLG", "regs PIE1"
        )
        self.assertEqual(blocks.split()[:3], ["blocks:", "ADC", "CPUTIMER0"])
        self.assertIn("TBPRD          0x1d4c", block)  # 7500 counts for 10 kHz, counting up and down
        self.assertRegex(block, r"CMPA +0x\w+  \d\d\.\d\d % of TBPRD")
        self.assertRegex(block, r"DBRED +0x0177  2\.500 us at SYSCLK = 150 MHz")  # the default dead time
        self.assertIn("TBCTL          0x4012  CTRMODE up-down", block)
        self.assertNotIn("reserved", block)
        self.assertTrue(one.startswith("EPWM1.TBCTL at 0x6800 = 0x4012 = 16402\n"), one)
        self.assertRegex(one, r"(?m)^  CTRMODE +1:0 +2  up-down$")
        self.assertTrue(small.startswith("EPWM2.TBPRD at 0x6845 = 0x1d4c = 7500"), small)
        self.assertTrue(flag.startswith("EPWM3.TZFLG at 0x6896 = 0x0000 = 0"), flag)
        self.assertRegex(group, r"PIE1\.IER +0x0001  SEQ1INT")

    def test_every_block_can_be_shown(self):
        _, blocks = session("period 10", "regs")
        names = blocks.split()[1:]
        for name, text in zip(names, session("period 10", *(f"regs {name}" for name in names))[1:]):
            self.assertRegex(text, rf"^{name} at 0x[0-9a-f]{{4}}\n")
            self.assertNotIn("other bits", text, name)

    def test_values_are_printed_as_what_they_are(self):
        # The medium task latches the trip at the end of the window.
        _, voltage, rotor, frame, point, command, requests, drive, _, sequence = session(
            "until-fault", "print app->drive.fast.control.voltage", "print app->drive.fast.rotor", "print app->drive.fast.demand.frame",
            "print app->drive.fast.shaft.position", "print app->drive.fast.command", "print app->drive.requests",
            "print app->drive", f"period {end_of_window(8000)}", "print app->drive.medium.sequence",
            arguments=("30000", "8000"),
        )
        self.assertRegex(voltage, r"= \(d \S+, q \S+\)$")
        self.assertRegex(rotor, r"= theta_e \S+ deg \(\S+ rad\), omega_e \S+ rad/s \(\S+ Hz\)$")
        self.assertRegex(frame, r"= theta_e \S+ deg \(\S+ rad\), omega_e \S+ rad/s \(\S+ Hz\)$")
        self.assertRegex(point, r"= theta_e \S+ deg \(\S+ rad\), omega_e \S+ rad/s \(\S+ Hz\)$")
        self.assertRegex(command, r"= duty \(a 0\.\d+, b 0\.\d+, c 0\.\d+\), gates keep$")
        self.assertIn("state = fault, refusal = fault_present, fault_reason = module_fault, stop_reason = none, fault_present = none, faults_later = none,", sequence)
        self.assertIn("{enable = on, fault_reset = no, mode = speed,", requests)
        self.assertIn("opens = none, state = fault, manoeuvre = ramp, fault_reason = module_fault, fault = {", drive)
        self.assertIn("now = ramp, sensorless = 1, ", drive)
        self.assertIn("fault = {reason = module_fault, period = 8000,", drive)
        self.assertIn("current = (alpha ", drive)
        self.assertIn("warnings = none", drive)
        self.assertIn("capture = held, 341 periods of 12 rows, up to period 8000", drive)

    def test_names_are_completed(self):
        _, some, registers, own = session("period 10", "complete regs GP", "complete regs EPWM1.TZ", "complete until-")
        self.assertEqual(some.split("\n"), ["regs GPIOA", "regs GPIOB", "regs GPIOC"])
        self.assertIn("regs EPWM1.TZFLG", registers.split("\n"))
        self.assertEqual(own.split("\n"), ["until-fault", "until-manoeuvre"])
        _, names = session("period 10", "complete until-manoeuvre r")
        self.assertEqual([line.split()[1] for line in names.split("\n")], ["ramp", "relock", "reverse", "run"])


class WrongUseTest(unittest.TestCase):
    def one_line(self, text, *words):
        self.assertEqual(len(text.splitlines()), 1, text)
        for word in words:
            self.assertIn(word, text)

    def test_without_a_program_each_command_reports_it_in_one_line(self):
        for text in session("why", "drive", "regs", "where-time", "rig-hash", "period +1"):
            self.one_line(text, "no program is running")

    def test_wrong_arguments_are_reported_in_one_line(self):
        cases = {
            "period": "the number is missing",
            "period x": "'x' is no period",
            "period 1.5": "'1.5' is no period",
            "period 4294967295": "a whole number from 0 to 4294967294",
            "period -11": "before the start: this is period 10",
            "at": "the time is missing",
            "at 1 h": "'1 h' is no time",
            "at -1 s": "is no time",
            "until-fault soon": "'soon' is no period",
            "until-manoeuvre": "which manoeuvre?: off, catch, align, ramp, handover, run, forced, reverse, relock",
            "until-manoeuvre runs 9": "no manoeuvre 'runs': off, catch, align, ramp, handover, run, forced, reverse, relock",
            "until-manoeuvre run soon": "'soon' is no period",
            "until-manoeuvre run 10": "until-manoeuvre run 10: this is period 10 already",
            "why not": "takes no argument, not 'not'",
            "drive on": "takes no argument",
            "rig-hash 1": "takes no argument",
            "regs EPWM9": "no block 'EPWM9'",
            "regs EPWM1.TBX": "EPWM1 has no register 'TBX'",
            "set lagless-front-end x": "Undefined item",
        }
        for (command, words), text in zip(cases.items(), session("period 10", *cases)[1:]):
            self.one_line(text, words)

    def test_program_without_the_stop_hook_is_recognised(self):
        line = ["gdb", "-nx", "-q", "-batch", "-x", SCRIPT, "-ex", "echo @@@\\n", "-ex", "period 5"]
        done = run([*line, "--args", sys.executable])
        self.one_line(done.stdout.split("@@@\n")[1].strip(), "this program has no rig_stop_at()")

    def test_before_the_rig_is_there_it_is_reported(self):
        _, _, text, _, there = session("break main", "run", "why", "delete", "period 3")
        self.one_line(text, "there is no rig yet")
        self.assertTrue(there.startswith("period 3, "), there)


class MachineInterface:
    """Uses gdb as an IDE does: sends one line and receives its answer."""

    def __init__(self):
        self.gdb = subprocess.Popen(
            ["gdb", "-nx", "-q", "--interpreter=mi"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT,
        )
        self.token = 100

    def tell(self, command):
        """Sends a command; returns all lines up to the end of the action that it started."""
        self.token += 1
        self.gdb.stdin.write(f'{command}\n{self.token}-interpreter-exec console "echo"\n')
        self.gdb.stdin.flush()
        lines = []
        for line in self.gdb.stdout:
            lines.append(line.rstrip("\n"))
            if re.match(rf"{self.token}\^", line):
                return lines
        raise AssertionError("gdb ended: " + "\n".join(lines))

    def until_stopped(self, command):
        """Sends a command that lets the program run; returns all lines up to the stop."""
        self.gdb.stdin.write(f"{command}\n")
        self.gdb.stdin.flush()
        lines = []
        for line in self.gdb.stdout:
            lines.append(line.rstrip("\n"))
            if line.startswith("*stopped") or "^error" in line:
                return lines
        raise AssertionError("gdb ended: " + "\n".join(lines))

    def console(self, command):
        return self.tell(f'-interpreter-exec console "{command}"')

    def close(self):
        self.gdb.stdin.write("-gdb-exit\n")
        self.gdb.stdin.close()
        self.gdb.stdout.read()
        self.gdb.stdout.close()
        self.gdb.wait(timeout=SECONDS)


class VisualStudioCodeTest(unittest.TestCase):
    def setUp(self):
        self.launch = json.loads((ROOT / ".vscode" / "launch.json").read_text())
        self.tasks = json.loads((ROOT / ".vscode" / "tasks.json").read_text())
        self.gdb = None

    def tearDown(self):
        if self.gdb is not None:
            self.gdb.close()

    def test_configurations_name_tasks_and_inputs_that_exist(self):
        labels = {task["label"] for task in self.tasks["tasks"]}
        inputs = {entry["id"] for entry in self.launch["inputs"]}
        self.assertTrue(self.launch["configurations"])
        for configuration in self.launch["configurations"]:
            self.assertIn(configuration["preLaunchTask"], labels)
            self.assertEqual(set(re.findall(r"\$\{input:(\w+)\}", json.dumps(configuration))), inputs)
            self.assertIs(configuration["stopAtEntry"], False)

    @staticmethod
    def line_of_step(path):
        """The number of a line within the body of drive_step."""
        lines = pathlib.Path(path).read_text().splitlines()
        return next(n for n, line in enumerate(lines, 1) if line.startswith("bool drive_step(")) + 8

    def test_launch_stops_in_the_interrupt_and_goes_back_within_the_session(self):
        configuration = self.launch["configurations"][0]
        (variable,) = configuration["environment"]
        self.gdb = gdb = MachineInterface()
        for command in configuration["setupCommands"]:
            gdb.console(command["text"].replace("${workspaceFolder}", str(ROOT)))
        gdb.tell(f"-file-exec-and-symbols {PROGRAM}")
        gdb.tell("-exec-arguments 20000 6000")
        gdb.tell(f"-gdb-set environment {variable['name']}={variable['value'].replace('${input:period}', '5000')}")
        stopped = gdb.until_stopped("-exec-run")[-1]
        self.assertIn('reason="breakpoint-hit"', stopped)
        self.assertIn('func="app_interrupt"', stopped)
        self.assertRegex(stopped, r'fullname="[^"]*/firmware/app/app.c"')
        self.assertTrue(any("period 5000, 0.5000 s" in line for line in gdb.console("where-time")))

        # Sets a breakpoint by the full name of the source file, as an editor does.
        step = str(ROOT / "firmware" / "drive" / "drive.c")
        self.assertTrue(any("^done,bkpt=" in line for line in gdb.tell(f"-break-insert -f {step}:{self.line_of_step(step)}")))

        back = gdb.console("period -2")
        started = next(n for n, line in enumerate(back) if line.startswith('=thread-group-started,id="i2"'))
        ended = next(n for n, line in enumerate(back) if line.startswith('=thread-group-exited,id="i1"'))
        self.assertLess(started, ended, "the session's last process must not end before the new one starts")
        self.assertTrue(any("period 4998, 0.4998 s" in line for line in back))
        stops = [line for line in back if line.startswith("*stopped")]
        self.assertEqual(len(stops), 1)
        self.assertIn('func="app_interrupt"', stops[0])

        gdb.tell("-break-delete")
        gdb.console("period +2")
        self.assertTrue(any("fault 20, module_fault" in line for line in gdb.console("until-fault")))
        self.assertTrue(any("remedy:" in line for line in gdb.console("why")))


class ToolTest(unittest.TestCase):
    """tools/debug: from one command line to the interrupt, or a message and the right exit code."""

    def tool(self, *words, **more):
        return run([sys.executable, ROOT / "tools" / "debug", *words], **more)

    def test_one_command_stops_inside_the_interrupt_at_a_time(self):
        done = self.tool("--program", PROGRAM, "--at", "0.05 s", "--batch", "-ex", "where-time", "--", "20000")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("period 500, 0.0500 s", done.stdout)
        self.assertIn("#0  app_interrupt ()", done.stdout)

    def test_a_failure_is_reported_in_its_last_line_with_its_exit_code(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            shutil.copy2(PROGRAM, folder / "lagless")

            def holding(name, script):
                """A PATH that contains only this program."""
                (folder / name).mkdir()
                if script:
                    (folder / name / name).write_text("#!/bin/sh\n" + script + "\nexit 1\n")
                    (folder / name / name).chmod(0o755)
                return {"env": {**ENVIRONMENT, "PATH": f"{folder / name}"}}

            for code, words, text, more in (
                (2, ["--at", "1 h"], "--at: '1 h' is no time", {}),
                (2, ["--period", "x"], "--period: 'x' is no period", {}),
                (2, ["--at", "1 s", "--period", "5"], "accepted: one of them", {}),
                (2, ["--at"], "--at needs a value", {}),
                (2, ["--nonsense"], "no option '--nonsense'", {}),
                (2, ["a.toml", "b.toml"], "one scenario", {}),
                (2, ["--program", "/nonexistent/lagless"], "/nonexistent/lagless is not there", {}),
                (2, ["--program", __file__ + "/../CMakeLists.txt"], "is no", {}),
                (2, ["no_such.toml", "--program", folder / "lagless"], "no scenario no_such.toml; shipped are ", {}),
                (3, [], "' failed", holding("cmake", "echo '[1/2] Building'; echo 'drive.c:1: error: no such thing'")),
                (3, [], "no cmake on this machine", holding("nothing", "")),
                (3, ["--program", PROGRAM], "no gdb on this machine", holding("none", "")),
                (3, ["--program", PROGRAM], "without Python", holding("gdb", "echo 'Scripting in \"Python\" is not supported'")),
            ):
                with self.subTest(text):
                    done = self.tool(*words, **more)
                    self.assertEqual(done.returncode, code, done.stdout)
                    self.assertIn(text, done.stdout.splitlines()[-1])
                    self.assertEqual(text == "' failed", "building build/debug/lagless, step 1 of 2\n" in done.stdout)

    def test_a_scenario_goes_to_a_program_named_lagless_by_its_path_or_its_name(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "lagless"
            shutil.copy2(PROGRAM, program)
            scenario = pathlib.Path(folder) / "a scenario.toml"
            scenario.write_text("schema = 1\n")
            for words, text in (([scenario], r"a\\ scenario\.toml"), (["quick_stop"], r"host_sim/scenarios/quick_stop\.toml"),
                                ([], r"host_sim/scenarios/load_step\.toml")):
                done = self.tool(*words, f"--program={program}", "--batch", "-ex", "show args", "--", "--seed", "7")
                self.assertRegex(done.stdout, "run --quiet --seed 7 .*" + text)


if __name__ == "__main__":
    reason = why_not()
    if reason:
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    try:
        unittest.main(argv=[sys.argv[0], *REST])
    finally:
        anew()
