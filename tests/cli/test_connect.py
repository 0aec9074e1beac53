"""`lagless connect` with a drive of `lagless serve`: whole sessions, wrong lines, lines that break.

usage: test_connect.py LAGLESS FOLDER KEEPING_DRIVE"""

import csv
import json
import os
import pty
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import time
import unittest

import command_line
from command_line import FOLDER, LAGLESS, document, lagless

# The motor stands still, and the shaft has a light load. The simulation uses mean voltages, so that it keeps real time on a busy machine.
BENCH = """schema = 1
title = "On the bench"
[run]
duration = "1 s"
[plant]
load_torque = "0.5 N m"
[rig]
fidelity = "averaged"
"""

# The motor turns from the start without a command: a client that only listens receives the values that `lagless run` records.
TURNING = """schema = 1
title = "Turning"
[run]
duration = "8 s"
[params]
position_source = "encoder"
[requests]
enable = "on"
speed_request = "300 r/min"
[rig]
fidelity = "averaged"
"""


def connect(target, script, *options, **settings):
    return lagless("connect", target, *options, input=script, timeout=60, **settings)


def answers(result):
    """One object for each line of the script that had an effect."""
    return [json.loads(line) for line in result.stdout.splitlines()]


class Case(command_line.TestCase):
    def setUp(self):
        super().setUp()
        os.rmdir(self.folder)  # the recording must create it

    def serve(self, text=BENCH, *options):
        """Starts a server; returns its process, with the address for a client in `target`."""
        path = os.path.join(FOLDER, self._testMethodName + ".toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        process, place = super().serve(path, "--quiet", *options, *([] if "--serial" in options else ["--port", "0"]), place=r"(\S+)")
        process.target = place if place.startswith("/") else "tcp://" + place
        return process

    def typing(self, server, lines, *options):
        """A client that has received these lines and waits for more."""
        client = self.started("connect", server.target, *options, stdin=subprocess.PIPE)
        client.stdin.write(lines)
        client.stdin.flush()
        return client

    def recording(self, name):
        return list(csv.reader(line for line in self.read(name + ".csv").splitlines() if not line.startswith("#")))

    def does(self, server, script, *options):
        result = connect(server.target, script, *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""), result.stdout)
        return result

    def fails(self, server, script, message):
        result = connect(server.target, script)
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertIn(message, result.stderr)
        return result


class Memory(Case):
    """An EEPROM on the I2C bus needs half a second to save a set, after the answer to the order."""

    SAVE = "wait until state == ready\nset motor_resistance 1 ohm\napply\nsave\n"

    def drive(self, kind):
        running = subprocess.Popen([sys.argv[3], kind], stdout=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (running.kill(), running.communicate()))
        running.target = "tcp://" + running.stdout.readline().split()[-1]
        return running

    def test_save_and_erase_end_when_the_memory_has_taken_them(self):
        drive = self.drive("good")
        said = answers(self.does(drive, self.SAVE + "get store_state\nerase yes\nget store_state store_error\n", "--json"))
        self.assertEqual([(row["store_state"], row.get("store_error")) for row in said if row["command"] == "get"],
                         [("saved", None), ("empty", "none")])

    def test_a_memory_that_fails_is_reported(self):
        drive = self.drive("breaks")
        self.fails(drive, self.SAVE, "save: the memory has failed; `get store_error` shows the reason")
        said = answers(self.does(drive, "get store_error\n", "--json"))
        self.assertEqual(said[0]["store_error"], "not_taken")
        self.fails(drive, "save\n", "save: refused: the memory did not accept")

    def test_a_link_that_is_lost_during_this_time_is_reported(self):
        result = connect(self.drive("vanishes").target, self.SAVE)
        self.assertEqual(result.returncode, 3, result.stdout)
        self.assertRegex(result.stderr, "line 4: save: .*(the memory was busy|closed the connection)")


class Session(Case):
    def test_profile_from_standstill_saved_parameters_outlive_the_power(self):
        flash = os.path.join(FOLDER, "session.flash")
        if os.path.exists(flash):
            os.remove(flash)
        server = self.serve(BENCH, "--flash", flash)
        result = self.does(server, f"""# commissioning, as a script
wait until state == ready
get omega_m motor_resistance store_state
set motor_resistance 1.05 ohm
set motor_pole_pairs = 4
set current_limit 9 A
apply
go 500 r/min
wait until omega_m > 490 r/min timeout 10 s
wait until manoeuvre == run
record omega_m omega_m_ref i_q u_dc manoeuvre for 0.5 s --out {self.folder}
go -31.4 rad/s
wait until omega_m < -31 rad/s timeout 10 s
stop
wait until omega_m > -1 rad/s timeout 10 s
quick_stop
wait until state == ready
save
set motor_resistance 3
restart
get motor_resistance current_limit store_state
""", "--json")
        said = answers(result)
        self.assertEqual((said[0]["line"], said[0]["command"], said[0]["state"]), (2, "wait", "ready"))
        self.assertAlmostEqual(said[1]["omega_m"], 0.0, delta=0.1)
        self.assertAlmostEqual(said[1]["motor_resistance"], 0.95, places=6)
        self.assertEqual(said[1]["store_state"], "empty")
        self.assertAlmostEqual(said[-1]["motor_resistance"], 1.05, places=6)
        self.assertEqual(said[-1]["current_limit"], 9.0)
        self.assertEqual(said[-1]["store_state"], "loaded")
        rows = self.recording("recording")
        self.assertEqual(rows[0], ["time[s]", "omega_m[rad/s]", "omega_m_ref[rad/s]", "i_q[A]", "u_dc[V]", "manoeuvre[-]"])
        self.assertEqual(len(rows) - 1, 5000)
        begin = float(rows[1][0])
        for n, row in enumerate(rows[1:]):
            self.assertAlmostEqual(float(row[0]), begin + n * 1e-4, places=7)
            self.assertAlmostEqual(float(row[1]), 52.36, delta=1.6)

        # The supply of the drive fails and returns.
        server.terminate()
        self.assertEqual((server.wait(20), server.stderr.read()), (0, ""))
        server = self.serve(BENCH, "--flash", flash)
        said = answers(self.does(server, "get motor_resistance current_limit store_state period\n", "--json"))
        self.assertAlmostEqual(said[0]["motor_resistance"], 1.05, places=6)
        self.assertEqual(said[0]["current_limit"], 9.0)
        self.assertEqual(said[0]["store_state"], "loaded")
        self.assertLess(said[0]["period"], 100000)

        # Without the file the server is a drive with default parameters.
        server = self.serve()
        said = answers(self.does(server, "get motor_resistance store_state\n", "--json"))
        self.assertAlmostEqual(said[0]["motor_resistance"], 0.95, places=6)
        self.assertEqual(said[0]["store_state"], "empty")

    def test_saved_parameters_are_erased_when_the_word_is_given(self):
        server = self.serve()
        self.does(server, "wait until state == ready\nsave\nload\n")
        result = self.fails(server, "erase\n", "erase: all saved parameters of this drive would be lost")
        self.assertIn("erase yes", result.stderr)
        self.fails(server, "erase no\n", "erase yes")
        said = answers(self.does(server, "load\nget store_state\nerase yes\nget store_state\nrestart\n", "--json"))
        self.assertEqual([said[1]["store_state"], said[3]["store_state"], said[4]["store_state"]], ["loaded", "empty", "empty"])
        self.fails(server, "load\n", "this drive has no saved parameters")

    def test_a_locked_drive_is_read_by_all_and_written_with_its_key_alone(self):
        server = self.serve(BENCH + "[params]\nline_key = 4711\n")
        said = answers(self.does(server, "get line_key u_dc speed_request\n", "--json"))
        self.assertEqual(said[0]["line_key"], 0)
        self.assertGreater(said[0]["u_dc"], 300.0)
        for line in ("set speed_request 10 r/min", "set current_limit 8", "apply", "save", "go 300 r/min", "off"):
            self.fails(server, line + "\n", "locked by its line_key: it can be read and stopped; to write, connect with --key KEY")
        wrong = connect(server.target, "get u_dc\n", "--key", "4712")
        self.assertEqual((wrong.returncode, wrong.stdout), (3, ""))
        self.assertIn("the key is wrong", wrong.stderr)
        script = "wait until state == ready\nset speed_request 10\nset current_limit 8\napply\nsave\nrestart\nget line_key\n"
        said = answers(self.does(server, script + "set speed_request 5\nget speed_request\n", "--json", "--key", "4711"))
        self.assertEqual((said[6]["line_key"], said[8]["speed_request"]), (4711, 5.0))
        self.does(self.serve(), "set speed_request 10\n", "--key", "4711")  # a drive that needs no key
        for key in ("0", "-1", "4711x", "1000000", ""):
            refused = connect(server.target, "", "--key", key)
            self.assertEqual(refused.returncode, 2)
            self.assertIn("a whole number from 1 to 999999", refused.stderr)

    def test_recorded_is_to_the_bit_what_run_records(self):
        server = self.serve(TURNING)
        names = "omega_m i_d i_q i_a theta_e duty_a u_dc state"
        self.does(server, f"wait 0.3 s\nrecord {names} for 1 s --out {self.folder}\n")
        subprocess.run([LAGLESS, "run", os.path.join(FOLDER, self._testMethodName + ".toml"), "--quiet", "--out", self.folder, "--record", names.replace(" ", ",")], check=True)
        ours, theirs = self.recording("recording"), self.recording(self._testMethodName)
        self.assertEqual(ours[0], theirs[0])
        by_time = {row[0]: row for row in theirs[1:]}
        self.assertEqual(len(ours) - 1, 10000)
        for row in ours[1:]:
            self.assertEqual(row, by_time[row[0]])
        with open(os.path.join(self.folder, "recording.mat"), "rb") as file:
            self.assertEqual(file.read(10), b"MATLAB 5.0")

    def test_serial_line_carries_what_its_baud_has_room_for_and_reports_the_rest(self):
        """937 500 baud are 93.75 octets per millisecond. A sample of three floats has 4 + 1 + 4 + 12 octets: every third period they need
        70 octets per millisecond, every period 210."""
        server = self.serve(BENCH, "--serial")
        result = self.does(server, f"""wait until state == ready
restart
go 300 r/min
wait until omega_m > 290 r/min timeout 10 s
record omega_m i_q u_dc for 0.5 s every 3 --out {self.folder} --format csv,mdf
quick_stop
wait until state == ready
""")
        self.assertIn("1667 samples", result.stdout)
        times = [float(row[0]) for row in self.recording("recording")[1:]]
        self.assertEqual(len(times), 1667)
        for before, after in zip(times, times[1:]):
            self.assertAlmostEqual(after - before, 3e-4, places=7)
        with open(os.path.join(self.folder, "recording.mf4"), "rb") as file:
            mdf = file.read()
        self.assertEqual(mdf[:16], b"MDF     4.10    ")
        samples = mdf[-1667 * 20:]  # a time as double and three floats
        self.assertEqual([struct.unpack_from("<d", samples, 20 * n)[0] for n in range(1667)], times)
        self.fails(server, f"record omega_m i_q u_dc for 0.2 s --out {self.folder} --name fast\n", "the line is too slow; fewer names, or every ")

    def test_capture_has_the_moment_before_its_trigger(self):
        server = self.serve()
        self.does(server, f"""go 500 r/min
wait until omega_m > 480 r/min timeout 10 s
capture on omega_m below 400 r/min
capture after 10 ms
capture signals omega_m i_q u_dc
capture arm
go 300 r/min
capture wait 5 s
capture read --out {self.folder}
capture release
quick_stop
wait until state == ready
""")
        rows = self.recording("capture")
        self.assertEqual(rows[0], ["time[s]", "period[periods]", "omega_m[rad/s]", "i_q[A]", "u_dc[V]"])
        self.assertEqual(len(rows) - 1, 512)
        periods = [int(row[1]) for row in rows[1:]]
        self.assertEqual(periods, list(range(periods[0], periods[0] + 512)))
        level = 400 * 2 * 3.141592653589793 / 60
        speeds = [float(row[2]) for row in rows[1:]]
        trigger = 512 - 1 - 100
        self.assertGreaterEqual(speeds[trigger - 1], level)
        self.assertLess(speeds[trigger], level)

    def test_fault_is_listed_explained_and_reset_when_its_cause_is_gone(self):
        server = self.serve()
        self.does(server, "go 200 r/min\nset sink_temperature_max 20 degC\napply\nwait until state == fault timeout 1 s\n")
        self.fails(server, "go 200 r/min\n", "go: sink_hot: ")
        self.fails(server, "reset\n", "reset: still there: sink_hot: ")
        result = self.does(server, "faults\ndefaults\napply\nreset\ngo 200 r/min\noff\nexplain sink_hot\n")
        self.assertRegex(result.stdout, r"(?m)^ +\d+\.\d{4} s  sink_hot ")
        self.assertIn("what to do:", result.stdout)

    def test_status_reports_what_is_staged(self):
        server = self.serve()
        result = self.does(server, "set motor_resistance 1 ohm\nset current_limit 8\nstatus\ndefaults\nstatus\napply\nstatus\n")
        self.assertIn("staged, not applied: motor_resistance 1 ohm, current_limit 8 A\n", result.stdout)
        self.assertEqual(result.stdout.count("staged, not applied"), 1)
        result = connect(server.target, "set motor_resistance 1 ohm\n")
        result = self.does(server, "status\nget motor_resistance\n")
        self.assertIn("staged, not applied: what another client has set", result.stdout)

    def test_watch_and_lists(self):
        server = self.serve()
        result = self.does(server, "wait until state == ready\nwatch omega_m state for 0.3 s every 0.1 s\nparams motor_\nsignals theta\n", "--json")
        said = answers(result)
        self.assertEqual(len(said[1]["samples"]), 4)
        self.assertEqual(said[1]["samples"][0]["state"], "ready")
        rows = {row["name"]: row for row in said[2]["rows"]}
        self.assertEqual((rows["motor_pole_pairs"]["min"], rows["motor_pole_pairs"]["max"]), (1, 64))
        self.assertTrue(all("motor_" in name for name in rows))
        self.assertIn("theta_e", [row["name"] for row in said[3]["rows"]])
        text = self.does(server, "params motor_res\n").stdout
        self.assertRegex(text, r"motor_resistance +950 mohm +0.001 to 100 ohm +stator resistance")

    def test_help_and_completion_know_every_command(self):
        server = self.serve()
        said = answers(self.does(server, "help\nhelp go\n", "--json"))
        names = [row["name"] for row in said[0]["commands"]]
        for name in ("status", "get", "set", "apply", "params", "signals", "go", "stop", "quick_stop", "off", "reset", "watch",
                     "wait", "save", "load", "defaults", "restart", "record", "capture", "faults", "explain", "quit"):
            self.assertIn(name, names)
        self.assertEqual([row["name"] for row in said[1]["commands"]], ["go"])


class WrongLines(Case):
    ROWS = (
        ("frobnicate", "frobnicate: no such command; `help` lists them"),
        ("statsu", "did you mean status"),
        ("get omeg_m", "omeg_m: no such name; did you mean omega_m"),
        ("get", "a name is missing; `params`"),
        ("get theta_err", "theta_err: only the simulation has this row"),
        ("set motor_resistance 5000", "motor_resistance: 5000 ohm is outside its range; accepted: 0.001 to 100 ohm"),
        ("set motor_resistance", "motor_resistance: the value is missing; accepted: 0.001 to 100 ohm"),
        ("set motor_resistance 1 kg", "quantity in ohm"),
        ("set motor_pole_pairs 1.5", "accepted: whole numbers 1 to 64"),
        ("set enable maybe", "of its choices; accepted: off, on, quick_stop"),
        ("set omega_m 3", "omega_m: this value is read-only"),
        ("set speed_request 2000 rad/s", "accepted: -209 to 209 rad/s (|speed_request| <= 0.95 overspeed_trip)"),
        ("go", "speed_request: the value is missing"),
        ("go 20000 r/min", "accepted: -209 to 209 rad/s"),
        ("wait", "wait: a time or a condition is missing"),
        ("wait 2 kg", "quantity in s"),
        ("wait -1 s", "accepted: times above 0"),
        ("wait until", "accepted: NAME < <= > >= == != VALUE"),
        ("wait until omega_m ~ 3", "~: not a comparison"),
        ("wait until state == running", "of its choices"),
        ("wait until omega_m > 100 rad/s timeout 0.1 s", "not within 0.1 s; it is"),
        ("watch omega_m", "watch: a script needs a duration; write: watch omega_m for 2 s"),
        ("record omega_m for 1 s", "record NAME... for 2 s --out FOLDER"),
        ("record motor_resistance for 1 s --out x", "only signals are recorded"),
        ("record omega_m for 1 s every 0 --out x", "accepted: whole numbers of periods, 1 to 255"),
        ("record omega_m,omega_m for 1 s --out x", "given twice"),
        ("record omega_m for 1 s --out /proc/no/where", "cannot be made"),
        ("record omega_m for 1 s --out x --format vcd", "accepted: csv, mat, mdf, separated by commas"),
        ("capture dance", "accepted: on, signals, after, arm"),
        ("capture on full moon", "accepted: fault, command, SIGNAL above VALUE"),
        ("capture read --out x", "is still empty"),
        ("explain frob", "frob: no such reason"),
        ("load", "load: this drive has no saved parameters"),
        ("quit now", "no argument is accepted"))

    def test_each_names_the_thing_and_what_is_accepted(self):
        """One script continues after each wrong line; in JSON a wrong line is an object too."""
        done = connect(self.serve().target, "".join(line + "\n" for line, _ in self.ROWS), "--keep-going", "--json")
        self.assertEqual(done.returncode, 1, done.stderr)
        told = {answer["line"]: answer for answer in answers(done)}
        for number, (line, message) in enumerate(self.ROWS, 1):
            with self.subTest(line=line):
                self.assertIn(message, told[number]["error"])
                self.assertIn(f"line {number}: ", done.stderr)

    def test_a_script_ends_with_the_first_line_that_fails(self):
        result = self.fails(self.serve(), "get state\nset motor_resistance 5000\nget omega_m\n", "line 2: set: motor_resistance")
        self.assertNotIn("> get omega_m", result.stdout)


class BrokenLines(Case):
    def test_wrong_use(self):
        for arguments in ([], ["tcp://127.0.0.1:1", "more"], ["drive"], ["tcp://127.0.0.1"], ["/dev/ttyS0:fast"]):
            self.assertEqual(lagless("connect", *arguments).returncode, 2, arguments)

    def test_no_server(self):
        with socket.socket() as held:
            held.bind(("127.0.0.1", 0))
            result = connect(f"tcp://127.0.0.1:{held.getsockname()[1]}", "status\n")
        self.assertEqual(result.returncode, 3)
        self.assertIn("no server listens at this address", result.stderr)
        self.assertIn("lagless serve", result.stderr)

    def test_second_client_gets_a_message_at_once(self):
        server = self.serve()
        first = self.typing(server, "get state\n")
        first.stdout.readline()
        started = time.monotonic()
        result = connect(server.target, "status\n")
        self.assertLess(time.monotonic() - started, 1.0)
        self.assertEqual(result.returncode, 3)
        self.assertIn("another one is connected", result.stderr)
        first.communicate("quit\n")
        self.assertEqual(first.returncode, 0)
        self.does(server, "get state\n")

    def test_server_killed_in_the_midst_of_a_script(self):
        server = self.serve()
        client = self.typing(server, "go 300 r/min\nwait 20 s\n")
        time.sleep(1.0)
        server.kill()
        started = time.monotonic()
        _, errors = client.communicate(timeout=20)
        self.assertLess(time.monotonic() - started, 2.0)
        self.assertEqual(client.returncode, 3)
        self.assertIn("line 2: wait: ", errors)
        self.assertIn("closed the connection", errors)

    def test_a_motor_that_is_left_alone_is_stopped_and_that_is_reported_and_go_starts_it_again(self):
        server = self.serve()
        result = connect(server.target, "go 300 r/min\nwait until omega_m > 280 r/min timeout 10 s\nquit\n")
        self.assertEqual(result.returncode, 0)
        self.assertIn("the motor runs; the drive stops it in 1 s without a client (command_timeout)", result.stderr)
        time.sleep(3.0)
        said = answers(self.does(server, "get state omega_m\n", "--json"))
        self.assertEqual(said[0]["state"], "ready")
        self.assertAlmostEqual(said[0]["omega_m"], 0.0, delta=1.0)
        again = "wait until omega_m > 280 r/min timeout 10 s\n"
        self.does(server, f"go 300 r/min\n{again}quick_stop\nwait until state == ready timeout 10 s\ngo 300 r/min\n{again}quick_stop\n")

    def test_a_master_that_waits_for_its_user_keeps_the_motor_running(self):
        server = self.serve()
        client = self.typing(server, "go 300 r/min\n", "--json")
        time.sleep(3.0)
        out, _ = client.communicate("get state omega_m\nquick_stop\n")
        self.assertEqual(json.loads(out.splitlines()[1])["state"], "operation_enabled")

    def test_ctrl_c_ends_a_wait(self):
        client = self.typing(self.serve(), "wait 100 s\n")
        time.sleep(0.7)
        client.send_signal(signal.SIGINT)
        self.assertIn("wait: interrupted", client.communicate(timeout=5)[1])
        self.assertEqual(client.returncode, 1)

    def test_ctrl_c_between_two_lines_ends_a_script(self):
        server = self.serve()
        client = self.typing(server, "get state\n")
        while not client.stdout.readline().startswith("state"):
            pass
        time.sleep(0.3)  # until the client waits for the next line
        client.send_signal(signal.SIGINT)
        self.assertEqual(client.wait(5), 1)
        self.assertIn("interrupted", client.communicate()[1])


class Terminal(Case):
    """At a terminal there is a prompt, and if the build has libedit, the tabulator key completes words."""

    def begins(self, server):
        """The output up to the prompt; the terminal ends with the test."""
        self.child, self.terminal = pty.fork()
        if self.child == 0:
            os.environ["TERM"] = "vt100"
            os.execv(LAGLESS, [LAGLESS, "connect", server.target])
        self.addCleanup(os.close, self.terminal)
        return self.types(b"")

    def types(self, keys, mark="lagless> "):
        """Sends the keys, and returns the output up to the text."""
        os.write(self.terminal, keys)
        seen, end = "", time.monotonic() + 10.0
        while mark not in seen and time.monotonic() < end:
            if select.select([self.terminal], [], [], 0.1)[0]:
                seen += os.read(self.terminal, 4096).decode(errors="replace")
        self.assertIn(mark, seen)
        return seen

    def ends(self, code):
        """Checks that the session ends soon, with this exit code."""
        end = time.monotonic() + 10.0
        while time.monotonic() < end:
            if select.select([self.terminal], [], [], 0.1)[0]:
                try:
                    os.read(self.terminal, 4096)
                except OSError:  # the other side has closed the terminal
                    time.sleep(0.05)
            ended, status = os.waitpid(self.child, os.WNOHANG)
            if ended:
                self.assertEqual(code, os.waitstatus_to_exitcode(status))
                return
        os.kill(self.child, signal.SIGKILL)
        os.waitpid(self.child, 0)
        self.fail("the session goes on")

    def test_prompt_and_lines(self):
        self.assertRegex(self.begins(self.serve()), r"lagless-[0-9a-f]{8}; `help` lists the commands")
        self.types(b"wait until state == ready\n")
        self.assertRegex(self.types(b"get state\n"), r"state +ready")
        self.assertIn("did you mean omega_m", self.types(b"get omeg_m\n"))
        os.write(self.terminal, b"quit\n")
        self.ends(0)

    def test_ctrl_c_ends_a_watch_and_ctrl_d_the_session(self):
        self.begins(self.serve())
        self.types(b"watch omega_m every 0.1 s\n", "r/min\r\nomega_m")
        self.types(b"\x03")
        self.types(b"get u_dc\n", " V\r\n")
        os.write(self.terminal, b"\x04")
        self.ends(0)

    def test_ctrl_d_that_is_typed_while_a_command_runs_ends_the_session_behind_it(self):
        self.begins(self.serve())
        os.write(self.terminal, b"wait 0.5 s\n")
        time.sleep(0.2)  # while the command runs
        os.write(self.terminal, b"\x04")
        self.ends(0)

    def test_a_key_that_begins_a_sequence_leaves_the_motor_running_and_a_loss_is_reported(self):
        server = self.serve()
        self.begins(server)
        self.types(b"go 300 r/min\n", "on, going to 300 r/min\r\nlagless> ")
        os.write(self.terminal, b"\x1b")
        time.sleep(2.5)  # longer than command_timeout
        self.types(b"\x07\nget state\n", "operation_enabled\r\nlagless> ")
        os.write(self.terminal, b"\x1b")
        time.sleep(0.3)
        server.kill()
        self.ends(3)

    def test_completion(self):
        linked = subprocess.run(["ldd", LAGLESS], capture_output=True, text=True).stdout
        if "libedit" not in linked:
            self.skipTest("built without libedit")
        self.begins(self.serve())
        self.assertRegex(self.types(b"ge\tmotor_resis\t\n", " mohm\r\n"), r"motor_resistance +950 mohm")


def plain(text):
    """The text of a session without the parts that differ from run to run: numbers, prefixes of units, blanks."""
    text = re.sub(r"-?\d+(\.\d+)?(e[-+]?\d+)?( [mu](?=[AV]\b))?", "#", text)
    text = re.sub(r"# (?=[AV]\b)", "#", text)
    return [" ".join(line.split()) for line in text.splitlines()]


class Document(Case):
    def test_the_session_of_the_document_is_what_happens(self):
        text = document("docs/connect.md")
        printed = re.search(r"(?ms)^    \$ build/host/lagless connect tcp://127.0.0.1:5555 < first_run.txt\n(.*?)\n(?=\S)", text)
        session = re.sub(r"(?m)^    ", "", printed.group(1)).strip("\n")
        script = "".join(line[2:] + "\n" for line in session.splitlines() if line.startswith("> "))
        os.makedirs(self.folder)
        result = connect(self.serve(BENCH).target, script, cwd=self.folder)
        self.assertEqual((result.returncode, result.stderr), (0, ""), result.stdout)
        self.assertEqual(plain(result.stdout.strip("\n")), plain(session))


if __name__ == "__main__":
    os.makedirs(FOLDER, exist_ok=True)
    unittest.main(argv=sys.argv[:1] + sys.argv[4:], verbosity=2)
