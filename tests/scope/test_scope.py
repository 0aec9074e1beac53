"""`lagless scope` without a browser: its answers, the conditions in which it stops the motor, and its end.

usage: test_scope.py LAGLESS FOLDER"""

import base64
import contextlib
import http.client
import json
import os
import re
import signal
import struct
import sys
import threading
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "cli"))
import command_line  # noqa: E402
from command_line import lagless  # noqa: E402

RPM = 30 / 3.141592653589793
BENCH = """schema = 1
title = "a motor with an encoder that waits for a master"
[run]
duration = "60 min"
[params]
position_source = "encoder"
[rig]
fidelity = "averaged"
"""


class Page:
    """Acts as a page: receives the events and sends requests."""

    def __init__(self, url):
        self.host, self.path = re.fullmatch(r"http://([^/]+)(/[0-9a-f]{32})/", url).groups()
        self.hello, self.values, self.state, self.samples, self.captures = None, {}, {}, [], []
        self.connection = http.client.HTTPConnection(self.host, timeout=30)
        self.connection.request("GET", self.path + "/events")
        self.answer = self.connection.getresponse()
        self.socket = self.answer.fp
        self.thread = threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def listen(self):
        name = None
        with contextlib.suppress(OSError, ValueError, AttributeError):
            for line in self.socket:
                if line.startswith(b"event: "):
                    name = line[7:].strip().decode()
                elif line.startswith(b"data: "):
                    self.take(name, json.loads(line[6:]))

    def take(self, name, data):
        if name == "hello":
            self.hello = data
            self.values.update(data["values"])
        elif name == "state":
            self.values.update(data["values"])
            self.state = data
        elif name == "samples":
            self.samples.append(data)
        elif name == "capture":
            self.captures.append(data)

    def value(self, name):
        row = next(row for row in self.hello["rows"] if row["name"] == name)
        return self.values.get(str(row["id"]), float("nan"))  # no value yet: every comparison with NaN is false

    def ask(self, path, body=""):
        connection = http.client.HTTPConnection(self.host, timeout=30)
        connection.request("POST", self.path + path, body, {"X-Lagless": "1"})
        answer = json.load(connection.getresponse())
        connection.close()
        return answer

    def close(self):
        self.answer.close()
        self.connection.close()


class Scope(command_line.TestCase):
    def setUp(self):  # tests/cases/test_scope_state.py also uses start() and wait() of this class
        command_line.TestCase.setUp(self)
        self.scenario = command_line.TestCase.write(self, "bench.toml", BENCH)
        for name, text in (("uPlot.iife.min.js", "var uPlot = null;"), ("uPlot.min.css", ".uplot {}"), ("LICENSE", "of uPlot")):
            command_line.TestCase.write(self, name, text)  # a substitute for the downloaded file, so that no test needs the network
        self.uplot = {**os.environ, "UPLOT_DIR": self.folder}

    def start(self, *arguments):
        process = command_line.TestCase.started(self, *arguments, env=self.uplot)
        return process, process.stdout.readline()

    def serve(self, *arguments):
        place = self.start("serve", self.scenario, "--quiet", *arguments)[1].split()[-1]
        return place if place.startswith("/") else "tcp://" + place

    def scope(self, target, *arguments):
        self.process, line = self.start("scope", target, "--http", "0", "--no-browser", *arguments)
        self.url = line.split()[-1]
        return self.page()

    def page(self):
        page = Page(self.url)
        self.addCleanup(page.close)
        self.wait(lambda: page.hello and page.value("state") == 1, "ready")
        return page

    def wait(self, condition, what, seconds=20):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.01)

    def run_motor(self, page):
        self.assertEqual({"ok": True, "text": ""}, page.ask("/set", "speed_request 300 r/min"))
        self.assertTrue(page.ask("/set", "enable on")["ok"])
        self.wait(lambda: abs(page.value("omega_m") * RPM - 300) < 5, "300 r/min")

    def refused(self, code, *arguments, **settings):
        done = lagless("scope", *arguments, timeout=30, env={**self.uplot, **settings})
        self.assertEqual(code, done.returncode, done.stderr)
        return done.stderr

    def test_page_is_complete_and_loads_nothing(self):
        page = self.scope(self.serve("--port", "0"))
        connection = http.client.HTTPConnection(page.host)
        connection.request("GET", page.path + "/")
        text = connection.getresponse().read().decode()
        connection.close()
        self.assertIn("var uPlot = null;", text)
        self.assertNotIn("{{", text)
        self.assertEqual([], re.findall(r"""(?:src|href)=["'](?!data:)[^"']*""", text))
        self.assertEqual([], re.findall(r"https?://(?!www\.w3\.org/2000/svg)[^\s\"']*", text))

    def test_samples_are_the_drives_own(self):
        """Samples of every period arrive in order; the signal that counts the periods equals the stamp."""
        page = self.scope(self.serve("--port", "0"))
        self.assertTrue(page.ask("/signals", "1 2000 2024")["ok"])  # the signals period and u_dc
        self.wait(lambda: sum(each["n"] for each in page.samples if each["c"] == 2) > 5000, "samples")
        chosen = [each for each in page.samples if each["c"] == 2]
        begin = chosen[0]["p"]
        count = 0
        for each in chosen:
            self.assertEqual((begin + count, 1), (each["p"], each["e"]))
            slots = struct.unpack("<%uI" % (2 * each["n"]), base64.b64decode(each["d"]))
            self.assertEqual(list(slots[::2]), list(range(each["p"], each["p"] + each["n"])))
            count += each["n"]
        self.assertEqual(0, page.state["missing"])

    def test_what_the_drive_refuses_is_reported_and_changes_nothing(self):
        page = self.scope(self.serve("--port", "0"))
        self.wait(lambda: page.value("current_bandwidth") > 0, "parameters")
        before = page.value("current_bandwidth")
        for body, fragment in (("current_bandwidth 99999", "10 to 3000"), ("omega_m 5", ""), ("nothing 5", "no such row"),
                               ("enable maybe", "quick_stop"), ("current_bandwidth", "no value"), ("speed_request 1 A", "accepted")):
            answer = page.ask("/set", body)
            self.assertFalse(answer["ok"], body)
            self.assertIn(fragment, answer["text"])
        self.assertFalse(page.ask("/order", "explode")["ok"])
        self.assertFalse(page.ask("/signals", "1 " + "2000 " * 9)["ok"])
        self.assertFalse(page.ask("/signals", "256 2000")["ok"])
        self.assertFalse(page.ask("/signals", "1 1")["ok"])  # 1 is the id of a parameter
        self.assertFalse(page.ask("/nothing")["ok"])
        time.sleep(1)
        self.assertEqual(before, page.value("current_bandwidth"))
        self.assertFalse(page.state["staged"])

    def test_a_set_is_staged_then_applied(self):
        page = self.scope(self.serve("--port", "0"))
        self.assertTrue(page.ask("/set", "current_bandwidth 750")["ok"])
        self.wait(lambda: page.state.get("staged"), "staged")
        self.assertTrue(page.ask("/order", "apply")["ok"])
        self.wait(lambda: not page.state["staged"] and page.value("current_bandwidth") == 750, "active")

    def test_drives_own_buffer_comes_over_the_serial_line(self):
        """All rows that the drive has kept arrive, each with the number of its period, and none of a period that is not held."""
        page = self.scope(self.serve("--serial"))
        self.assertIn("is still empty", page.ask("/capture")["text"])
        for wish in ("capture_1 2000", "capture_2 2024", "capture_3 2044", "capture_signals 3", "capture_after 100", "capture_on command"):
            self.assertTrue(page.ask("/set", wish)["ok"], wish)
        self.assertTrue(page.ask("/order", "capture_arm")["ok"])
        time.sleep(0.3)  # 512 periods take 51 ms
        self.assertTrue(page.ask("/order", "capture_trigger")["ok"])
        self.wait(lambda: page.value("capture_state") == 3, "held")
        self.assertTrue(page.ask("/capture")["ok"])
        begun = time.monotonic()
        self.assertIn("already", page.ask("/capture")["text"])
        self.assertTrue(page.ask("/stop")["ok"])  # the answer does not wait for the whole buffer
        took = time.monotonic() - begun
        self.wait(lambda: page.captures, "the buffer")
        [kept] = page.captures
        self.assertEqual((100, 512, [2000, 2024, 2044]), (kept["after"], kept["periods"], kept["signals"]))
        slots = struct.unpack("<1536I", base64.b64decode(kept["d"]))
        self.assertEqual(list(range(kept["at"] + 100 - 511, kept["at"] + 101)), list(slots[::3]))
        volts = [struct.unpack("<f", struct.pack("<I", slot))[0] for slot in slots[1::3]]
        self.assertTrue(all(abs(each - 311) < 2 for each in volts), volts[:9])
        self.assertTrue(page.ask("/order", "capture_release")["ok"])
        self.assertIn("is still empty", page.ask("/capture")["text"])
        self.assertLess(took, 0.5)

    def test_stop_is_answered_at_once_while_samples_stream_over_the_serial_line(self):
        page = self.scope(self.serve("--serial"))
        took = []
        while not took or (took[-1] >= 0.5 and len(took) < 3):  # a busy machine may delay one of three answers
            self.run_motor(page)
            begun = time.monotonic()
            self.assertTrue(page.ask("/stop")["ok"])
            took.append(time.monotonic() - begun)
            self.wait(lambda: page.value("enable") == 2 and page.value("state") == 1 and abs(page.value("omega_m")) < 0.5, "standstill")
        self.assertLess(min(took), 0.5)

    def test_motor_stops_when_all_pages_are_gone(self):
        page = self.scope(self.serve("--port", "0"))
        other = self.page()
        self.run_motor(page)
        page.close()
        time.sleep(6.5)  # longer than the five seconds, while one page is still connected
        self.assertEqual(1, other.value("enable"))
        other.close()
        time.sleep(2)
        again = Page(self.url)  # the page is loaded again
        self.addCleanup(again.close)
        self.wait(lambda: again.hello and again.value("enable") == 1, "still on")
        again.close()
        time.sleep(6.5)
        last = Page(self.url)
        self.addCleanup(last.close)
        self.wait(lambda: last.hello and last.value("enable") == 2 and abs(last.value("omega_m")) < 0.5, "stopped")

    def test_scope_that_ends_leaves_no_motor_on(self):
        target = self.serve("--port", "0")
        self.run_motor(self.scope(target))
        self.process.send_signal(signal.SIGTERM)
        self.assertEqual(0, self.process.wait(20))
        page = self.scope(target)  # the drive is free again
        self.wait(lambda: page.value("enable") == 2 and abs(page.value("omega_m")) < 0.5, "stopped")

    def test_drive_that_begins_again_is_taken_up_again(self):
        page = self.scope(self.serve("--port", "0"))
        self.assertTrue(page.ask("/order", "restart")["ok"])
        self.wait(lambda: not page.state["link"], "the link is lost")
        self.wait(lambda: page.state["link"] and page.state["sampling"], "the link is back")
        count = len(page.samples)
        self.wait(lambda: len(page.samples) > count + 10, "samples")

    def test_a_locked_drive_is_shown_and_stopped_and_switched_on_with_its_key_alone(self):
        self.scenario = command_line.TestCase.write(self, "locked.toml", BENCH.replace("[rig]", "line_key = 4711\ncommand_timeout = 60\n[rig]"))
        target = self.serve("--port", "0")
        page = self.scope(target)
        for path, body in (("/set", "enable on"), ("/set", "speed_request 300 r/min"), ("/set", "current_bandwidth 750"), ("/order", "apply")):
            self.assertIn("locked by its line_key", page.ask(path, body)["text"])
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(20)
        self.assertIn("the key is wrong", self.refused(3, target, "--http", "0", "--no-browser", "--key", "4712"))
        self.assertIn("a whole number from 1 to 999999", self.refused(2, target, "--key", "0"))
        page = self.scope(target, "--key", "4711")
        self.run_motor(page)
        self.process.kill()  # ends without switching the motor off
        self.process.wait(20)
        page = Page(self.start_locked(target))
        self.addCleanup(page.close)
        self.wait(lambda: page.hello and abs(page.value("omega_m") * RPM - 300) < 5, "it still runs")
        self.assertIn("locked by its line_key", page.ask("/set", "enable off")["text"])
        self.assertTrue(page.ask("/stop")["ok"])
        self.wait(lambda: page.value("state") == 1 and abs(page.value("omega_m")) < 0.5, "standstill")

    def start_locked(self, target):
        self.process, line = self.start("scope", target, "--http", "0", "--no-browser")
        return line.split()[-1]

    def test_the_port_of_the_page_has_the_option_of_serve_too(self):
        line = self.start("scope", self.serve("--port", "0"), "--port", "0", "--no-browser")[1]
        self.assertRegex(line, r" shown at http://127\.0\.0\.1:\d+/[0-9a-f]{32}/$")

    def test_wrong_use_is_refused(self):
        target = self.serve("--port", "0")
        self.assertIn("no target is given", self.refused(2))
        self.assertIn("b: a second target; accepted: one", self.refused(2, "a", "b"))
        self.assertIn("0 to 65535", self.refused(2, target, "--http", "70000"))
        self.assertIn("tcp://", self.refused(2, "nonsense", "--no-browser"))
        self.assertIn("no server listens", self.refused(3, "tcp://127.0.0.1:1", "--no-browser"))
        self.assertIn("get-uplot", self.refused(3, target, "--no-browser", UPLOT_DIR="", XDG_CACHE_HOME="/nowhere", HOME="/nowhere"))
        self.scope(target)
        self.assertIn("one client at a time", self.refused(3, target, "--http", "0", "--no-browser"))
        other = self.serve("--port", "0")
        port = self.url.rsplit(":", 1)[1].split("/")[0]
        self.assertIn("port " + port, self.refused(3, other, "--http", port, "--no-browser"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
