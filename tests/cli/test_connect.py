"""`lagless connect` at `lagless serve`: whole sessions, wrong lines, lines that break. usage: test_connect.py LAGLESS FOLDER"""

import csv
import json
import os
import pty
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest

from command_line import FOLDER, LAGLESS, document, lagless, stuck

# Nothing runs, the shaft is lightly loaded; mean voltages, so that real time is kept on a busy machine.
BENCH = """schema = 1
title = "On the bench"
[run]
duration = "1 s"
[plant]
load_torque = "0.5 N m"
[rig]
fidelity = "averaged"
"""

# Turns by itself from the start: whoever only listens hears what `lagless run` records.
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


def scenario(name, text):
    path = os.path.join(FOLDER, name + ".toml")
    with open(path, "w") as file:
        file.write(text)
    return path


class Server:
    def __init__(self, path, *options):
        words = [LAGLESS, "serve", path, "--quiet", *options]
        if "--serial" not in options:
            words += ["--port", "0"]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        place = re.fullmatch(r"listening on (\S+)\n", self.process.stdout.readline()).group(1)
        self.target = place if place.startswith("/") else "tcp://" + place

    def end(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=20)
        return self.process.returncode, errors


def connect(target, script, *options, **settings):
    return lagless("connect", target, *options, input=script, timeout=60, **settings)


def answers(result):
    """One object a line of the script that did something."""
    return [json.loads(line) for line in result.stdout.splitlines()]


def recording(folder, name):
    with open(os.path.join(folder, name + ".csv")) as file:
        lines = [line for line in file if not line.startswith("#")]
    return list(csv.reader(lines))


class Case(stuck.TestCase):
    def setUp(self):
        self.servers = []
        self.folder = os.path.join(FOLDER, self._testMethodName)
        shutil.rmtree(self.folder, ignore_errors=True)

    def tearDown(self):
        for server in self.servers:
            if server.process.poll() is None:
                server.end(signal.SIGKILL)

    def serve(self, text=BENCH, *options):
        server = Server(scenario(self._testMethodName, text), *options)
        self.servers.append(server)
        return server

    def typing(self, server, lines, *options):
        """A client that was given these lines and waits for more."""
        client = subprocess.Popen([LAGLESS, "connect", server.target, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True)
        client.stdin.write(lines)
        client.stdin.flush()
        return client

    def does(self, server, script, *options):
        result = connect(server.target, script, *options)
        self.assertEqual((result.returncode, result.stderr), (0, ""), result.stdout)
        return result

    def fails(self, server, script, message, code=1):
        result = connect(server.target, script)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        self.assertIn(message, result.stderr)
        return result


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
        rows = recording(self.folder, "recording")
        self.assertEqual(rows[0], ["time[s]", "omega_m[rad/s]", "omega_m_ref[rad/s]", "i_q[A]", "u_dc[V]", "manoeuvre[-]"])
        self.assertEqual(len(rows) - 1, 5000)
        begin = float(rows[1][0])
        for n, row in enumerate(rows[1:]):
            self.assertAlmostEqual(float(row[0]), begin + n * 1e-4, places=7)
            self.assertAlmostEqual(float(row[1]), 52.36, delta=1.6)

        # the power goes, and comes back
        self.assertEqual(server.end(), (0, ""))
        server = self.serve(BENCH, "--flash", flash)
        said = answers(self.does(server, "get motor_resistance current_limit store_state period\n", "--json"))
        self.assertAlmostEqual(said[0]["motor_resistance"], 1.05, places=6)
        self.assertEqual(said[0]["current_limit"], 9.0)
        self.assertEqual(said[0]["store_state"], "loaded")
        self.assertLess(said[0]["period"], 100000)

        # without the file it is another drive
        server = self.serve()
        said = answers(self.does(server, "get motor_resistance store_state\n", "--json"))
        self.assertAlmostEqual(said[0]["motor_resistance"], 0.95, places=6)
        self.assertEqual(said[0]["store_state"], "empty")

    def test_recorded_is_to_the_bit_what_run_records(self):
        server = self.serve(TURNING)
        names = "omega_m i_d i_q i_a theta_e duty_a u_dc state"
        self.does(server, f"wait 0.3 s\nrecord {names} for 1 s --out {self.folder}\n")
        path = scenario(self._testMethodName, TURNING)
        subprocess.run([LAGLESS, "run", path, "--quiet", "--out", self.folder, "--record", names.replace(" ", ",")], check=True)
        ours, theirs = recording(self.folder, "recording"), recording(self.folder, self._testMethodName)
        self.assertEqual(ours[0], theirs[0])
        by_time = {row[0]: row for row in theirs[1:]}
        self.assertEqual(len(ours) - 1, 10000)
        for row in ours[1:]:
            self.assertEqual(row, by_time[row[0]])
        with open(os.path.join(self.folder, "recording.mat"), "rb") as file:
            self.assertEqual(file.read(10), b"MATLAB 5.0")

    def test_decimated_recording(self):
        server = self.serve(TURNING)
        self.does(server, f"record period for 0.1 s every 7 --out {self.folder} --name few --format csv\n")
        periods = [int(row[1]) for row in recording(self.folder, "few")[1:]]
        self.assertEqual(len(periods), 143)
        self.assertEqual({b - a for a, b in zip(periods, periods[1:])}, {7})
        self.assertEqual(os.listdir(self.folder), ["few.csv"])

    def test_serial_line_carries_what_its_baud_has_room_for_and_tells_the_rest(self):
        """937 500 baud are 93.75 octets a millisecond; a sample of three floats is 4 + 1 + 4 + 12 of them, so every third
        period takes 70, each period 210."""
        server = self.serve(BENCH, "--serial")
        result = self.does(server, f"""wait until state == ready
restart
go 300 r/min
wait until omega_m > 290 r/min timeout 10 s
record omega_m i_q u_dc for 0.5 s every 3 --out {self.folder}
quick_stop
wait until state == ready
""")
        self.assertIn("1667 samples", result.stdout)
        times = [float(row[0]) for row in recording(self.folder, "recording")[1:]]
        self.assertEqual(len(times), 1667)
        for before, after in zip(times, times[1:]):
            self.assertAlmostEqual(after - before, 3e-4, places=7)
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
        rows = recording(self.folder, "capture")
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

    def test_status_tells_what_is_staged(self):
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
    def test_each_names_the_thing_and_what_is_accepted(self):
        server = self.serve()
        for line, message in (
            ("frobnicate", "frobnicate: no such command; `help` lists them"),
            ("statsu", "did you mean status"),
            ("get omeg_m", "omeg_m: no such name; did you mean omega_m"),
            ("get", "get: a name is missing; `params`"),
            ("get theta_err", "theta_err: only the simulation has this row"),
            ("set motor_resistance 5000", "motor_resistance: 5000 ohm is outside its range; accepted: 0.001 to 100 ohm"),
            ("set motor_resistance", "motor_resistance: the value is missing; accepted: 0.001 to 100 ohm"),
            ("set motor_resistance 1 kg", "is not a quantity in ohm"),
            ("set motor_pole_pairs 1.5", "accepted: whole numbers 1 to 64"),
            ("set enable maybe", "is not one of its choices; accepted: off, on, quick_stop"),
            ("set omega_m 3", "omega_m: this value is read-only"),
            ("set speed_request 2000 rad/s", "accepted -209 to 209 rad/s (|speed_request| <= 0.95 overspeed_trip)"),
            ("go", "speed_request: the value is missing"),
            ("go 20000 r/min", "accepted -209 to 209 rad/s"),
            ("go fast", "does not begin with a number"),
            ("wait", "wait: a time or a condition is missing"),
            ("wait 2 kg", "is not a quantity in s"),
            ("wait -1 s", "accepted times above 0"),
            ("wait until", "accepted: NAME < <= > >= == != VALUE"),
            ("wait until omega_m ~ 3", "~: not a comparison"),
            ("wait until state == running", "not one of its choices"),
            ("wait until omega_m > 100 rad/s timeout 0.1 s", "not within 0.1 s; it is"),
            ("record omega_m for 1 s", "record NAME... for 2 s --out FOLDER"),
            ("record motor_resistance for 1 s --out x", "only signals are recorded"),
            ("record omega_m for 1 s every 0 --out x", "accepted whole numbers of periods, 1 to 255"),
            ("record omega_m,omega_m for 1 s --out x", "given twice"),
            ("record omega_m for 1 s --out /proc/no/where", "cannot be made"),
            ("record omega_m for 1 s --out x --format vcd", "accepted csv, mat, csv,mat"),
            ("capture dance", "accepted: on, signals, after, arm"),
            ("capture on full moon", "accepted: fault, command, SIGNAL above VALUE"),
            ("capture read --out x", "holds nothing yet"),
            ("explain frob", "frob: no such reason"),
            ("load", "load: this drive has no saved parameters"),
            ("quit now", "no argument is accepted"),
        ):
            with self.subTest(line=line):
                result = self.fails(server, line + "\n", message)
                self.assertIn("line 1: ", result.stderr)

    def test_a_script_ends_with_the_first_line_that_fails(self):
        server = self.serve()
        result = self.fails(server, "get state\nset motor_resistance 5000\nget omega_m\n", "line 2: set: motor_resistance")
        self.assertNotIn("> get omega_m", result.stdout)
        result = connect(server.target, "set motor_resistance 5000\nwait until state == ready\n", "--keep-going")
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stdout, r"state +ready")

    def test_in_json_a_failed_line_is_an_object_too(self):
        server = self.serve()
        said = answers(connect(server.target, "wait until state == ready\nset motor_resistance 5000\n", "--json"))
        self.assertEqual(said[0]["state"], "ready")
        self.assertEqual((said[1]["line"], said[1]["command"]), (2, "set"))
        self.assertIn("accepted: 0.001 to 100 ohm", said[1]["error"])

    def test_a_set_that_does_not_go_together_is_refused_with_its_rule_and_nothing_changes(self):
        server = self.serve()
        self.fails(server, "set dc_undervoltage 390 V\nset dc_overvoltage 380 V\napply\n", "dc_undervoltage")
        said = answers(self.does(server, "status\ndefaults\nget dc_undervoltage\n", "--json"))
        self.assertFalse(said[0]["applied"])

    def test_what_needs_the_bridge_off_is_refused_while_it_is_on(self):
        server = self.serve()
        self.fails(server, "go 300 r/min\nset motor_pole_pairs 3\napply\n",
                   "apply: refused for motor_pole_pairs: possible only while the bridge is off; switch off first")
        self.fails(server, "defaults\ngo 300 r/min\nsave\n", "possible only while the bridge is off; switch off first")

    def test_a_script_says_for_how_long_it_watches(self):
        self.fails(self.serve(), "watch omega_m\n", "watch: a script needs a duration; write: watch omega_m for 2 s")


class BrokenLines(Case):
    def test_wrong_use(self):
        for arguments in ([], ["tcp://127.0.0.1:1", "more"], ["drive"], ["tcp://127.0.0.1"], ["/dev/ttyS0:fast"]):
            self.assertEqual(lagless("connect", *arguments).returncode, 2, arguments)

    def test_no_server(self):
        with socket.socket() as held:
            held.bind(("127.0.0.1", 0))
            result = connect(f"tcp://127.0.0.1:{held.getsockname()[1]}", "status\n")
        self.assertEqual(result.returncode, 3)
        self.assertIn("no server listens there", result.stderr)
        self.assertIn("lagless serve", result.stderr)

    def test_second_client_is_told_at_once(self):
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

    def test_who_comes_when_another_one_has_just_gone_is_served(self):
        server = self.serve()
        place = ("127.0.0.1", int(server.target.rsplit(":", 1)[1]))
        connects = bytes.fromhex("02000000ff00")
        with socket.create_connection(place, timeout=5) as first:
            first.sendall(connects)
            self.assertNotEqual(first.recv(1), b"")
            server.process.send_signal(signal.SIGSTOP)  # as on a machine that has other work
            first.sendall(bytes.fromhex("01000100fe"))
        with socket.create_connection(place, timeout=5) as second:
            second.sendall(connects)
            server.process.send_signal(signal.SIGCONT)
            self.assertNotEqual(second.recv(1), b"")

    def test_who_serves_something_else_is_found_out(self):
        with socket.create_server(("127.0.0.1", 0)) as other:

            def answer():
                connection, _ = other.accept()
                connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
                connection.recv(100)
                connection.close()

            thread = threading.Thread(target=answer, daemon=True)
            thread.start()
            result = connect(f"tcp://127.0.0.1:{other.getsockname()[1]}", "status\n")
            thread.join()
        self.assertEqual(result.returncode, 3)
        self.assertIn("what comes is not XCP", result.stderr)

    def test_server_killed_in_the_midst_of_a_script(self):
        server = self.serve()
        client = self.typing(server, "go 300 r/min\nwait 20 s\n")
        time.sleep(1.0)
        server.end(signal.SIGKILL)
        started = time.monotonic()
        _, errors = client.communicate(timeout=20)
        self.assertLess(time.monotonic() - started, 2.0)
        self.assertEqual(client.returncode, 3)
        self.assertIn("line 2: wait: ", errors)
        self.assertIn("closed the line", errors)

    def test_server_killed_while_nobody_types(self):
        server = self.serve()
        client = self.typing(server, "get state\n")
        time.sleep(0.5)
        server.end(signal.SIGKILL)
        self.assertEqual(client.wait(timeout=5), 3)
        self.assertIn("closed the line", client.communicate()[1])

    def test_server_that_stands_still_is_given_up(self):
        server = self.serve()
        client = self.typing(server, "get state\n")
        time.sleep(0.5)
        server.process.send_signal(signal.SIGSTOP)
        client.stdin.write("get state\n")
        _, errors = client.communicate(timeout=20)
        server.process.send_signal(signal.SIGCONT)
        self.assertEqual(client.returncode, 3)
        self.assertIn("does not answer any more", errors)

    def test_a_motor_that_is_left_alone_is_stopped_and_that_is_told(self):
        server = self.serve()
        result = connect(server.target, "go 300 r/min\nwait until omega_m > 280 r/min timeout 10 s\nquit\n")
        self.assertEqual(result.returncode, 0)
        self.assertIn("the motor runs; the drive stops it in 1 s without a client (command_timeout)", result.stderr)
        time.sleep(3.0)
        said = answers(self.does(server, "get state omega_m\n", "--json"))
        self.assertEqual(said[0]["state"], "ready")
        self.assertAlmostEqual(said[0]["omega_m"], 0.0, delta=1.0)

    def test_a_master_that_waits_for_its_user_keeps_the_motor_running(self):
        server = self.serve()
        client = self.typing(server, "go 300 r/min\n", "--json")
        time.sleep(3.0)
        out, _ = client.communicate("get state omega_m\nquick_stop\n")
        self.assertEqual(json.loads(out.splitlines()[1])["state"], "operation_enabled")

    def test_ctrl_c_ends_a_wait(self):
        server = self.serve()
        client = self.typing(server, "wait 100 s\n")
        time.sleep(0.7)
        client.send_signal(signal.SIGINT)
        _, errors = client.communicate(timeout=5)
        self.assertEqual(client.returncode, 1)
        self.assertIn("wait: interrupted", errors)

    def test_ctrl_c_between_two_lines_ends_a_script(self):
        server = self.serve()
        client = self.typing(server, "get state\n")
        while not client.stdout.readline().startswith("state"):
            pass
        time.sleep(0.3)  # until it waits for the next line
        client.send_signal(signal.SIGINT)
        self.assertEqual(client.wait(5), 1)
        self.assertIn("interrupted", client.communicate()[1])


class Terminal(Case):
    """At a terminal: a prompt, and where the build has libedit, completion by the tabulator."""

    def at_a_terminal(self, server):
        child, terminal = pty.fork()
        if child == 0:
            os.environ["TERM"] = "vt100"
            os.execv(LAGLESS, [LAGLESS, "connect", server.target])
        return child, terminal

    def talk(self, server, keys):
        child, terminal = self.at_a_terminal(server)
        seen = ""
        try:
            for key in keys:
                seen += self.read_until(terminal, "lagless> ")
                os.write(terminal, key.encode())
            while True:
                seen += os.read(terminal, 4096).decode(errors="replace")
        except OSError:
            pass
        _, status = os.waitpid(child, 0)
        os.close(terminal)
        return seen, os.waitstatus_to_exitcode(status)

    def read_until(self, terminal, mark):
        seen = ""
        end = time.monotonic() + 10.0
        while mark not in seen and time.monotonic() < end:
            if select.select([terminal], [], [], 0.1)[0]:
                seen += os.read(terminal, 4096).decode(errors="replace")
        self.assertIn(mark, seen)
        return seen

    def test_prompt_and_lines(self):
        seen, code = self.talk(self.serve(), ["wait until state == ready\n", "get omeg_m\n", "quit\n"])
        self.assertEqual(code, 0, seen)
        self.assertRegex(seen, r"lagless-[0-9a-f]{8}; `help` lists the commands")
        self.assertRegex(seen, r"state +ready")
        self.assertIn("did you mean omega_m", seen)

    def test_ctrl_c_ends_a_watch_and_ctrl_d_the_session(self):
        child, terminal = self.session(self.serve())
        os.write(terminal, b"watch omega_m every 0.1 s\n")
        self.read_until(terminal, "r/min\r\nomega_m")
        os.write(terminal, b"\x03")
        self.read_until(terminal, "lagless> ")
        os.write(terminal, b"get u_dc\n")
        self.read_until(terminal, " V\r\n")
        os.write(terminal, b"\x04")
        self.assertEqual(self.ends(child, terminal), 0)

    def session(self, server):
        """A session at a terminal: its process and the terminal, which end with the test."""
        child, terminal = self.at_a_terminal(server)
        self.addCleanup(os.close, terminal)
        self.read_until(terminal, "lagless> ")
        return child, terminal

    def ends(self, child, terminal):
        """Its exit code, soon; None: it goes on, and is ended."""
        end = time.monotonic() + 10.0
        while time.monotonic() < end:
            if select.select([terminal], [], [], 0.1)[0]:
                try:
                    os.read(terminal, 4096)
                except OSError:  # the other side is closed
                    time.sleep(0.05)
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                return os.waitstatus_to_exitcode(status)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return None

    def test_ctrl_d_that_is_typed_while_a_command_runs_ends_the_session_behind_it(self):
        child, terminal = self.session(self.serve())
        os.write(terminal, b"wait 0.5 s\n")
        time.sleep(0.2)  # in the midst of it
        os.write(terminal, b"\x04")
        self.assertEqual(self.ends(child, terminal), 0)

    def test_a_key_that_begins_a_sequence_leaves_the_motor_running_and_a_loss_is_told(self):
        server = self.serve()
        child, terminal = self.session(server)
        os.write(terminal, b"go 300 r/min\n")
        self.read_until(terminal, "on, going to 300 r/min\r\nlagless> ")
        os.write(terminal, b"\x1b")
        time.sleep(2.5)  # more than command_timeout
        os.write(terminal, b"\x07\nget state\n")
        self.read_until(terminal, "operation_enabled\r\nlagless> ")
        os.write(terminal, b"\x1b")
        time.sleep(0.3)
        server.end(signal.SIGKILL)
        self.assertEqual(self.ends(child, terminal), 3)

    def test_completion(self):
        linked = subprocess.run(["ldd", LAGLESS], capture_output=True, text=True).stdout
        if "libedit" not in linked:
            self.skipTest("built without libedit")
        seen, code = self.talk(self.serve(), ["ge\tmotor_resis\t\n", "quit\n"])
        self.assertEqual(code, 0, seen)
        self.assertRegex(seen, r"motor_resistance +950 mohm")


def plain(text):
    """A session's text without what differs from run to run: numbers, prefixes of units, blanks."""
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
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
