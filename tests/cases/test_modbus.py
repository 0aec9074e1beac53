"""The drive as a server of Modbus RTU on the chip's serial line: mbpoll, unmodified, reads a signal and starts the motor, and the motor
stops when mbpoll is silent. Wrong frames and forbidden writes get the answers of docs/modbus.md. usage: test_modbus.py LAGLESS FOLDER"""
import json
import os
import pathlib
import re
import select
import shutil
import struct
import subprocess
import sys
import time
import tty
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import stuck  # noqa: E402

LAGLESS, FOLDER = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2])
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = """schema = 1
title = "A motor on Modbus"
[run]
duration = "1 s"
[params]
line_protocol = "modbus"
modbus_address = 17
position_source = "encoder"
{}
[rig]
fidelity = "averaged"
"""
READ, WRITE_ONE, WRITE = 3, 6, 16
OFF, ON, QUICK_STOP = 0, 1, 2


def ids():
    found = {}
    for command in ("params", "signals"):
        done = subprocess.run([LAGLESS, command, "--json"], text=True, stdout=subprocess.PIPE, check=True)
        found.update({row["name"]: row["id"] for row in json.loads(done.stdout)["rows"]})
    return found


ID = ids()


def crc(octets):
    """The remainder of the division by x^16 + x^15 + x^2 + 1, the lowest bit of each octet first."""
    rest = 0xFFFF
    for octet in octets:
        for bit in range(8):
            out = (rest ^ octet >> bit) & 1
            rest = rest >> 1 ^ (0xA001 if out else 0)
    return struct.pack("<H", rest)


class Modbus(stuck.TestCase):
    def serve(self, more=""):
        FOLDER.mkdir(parents=True, exist_ok=True)
        path = FOLDER / f"{self.id().split('.')[-1]}.toml"
        path.write_text(SCENARIO.format(more), encoding="utf-8")
        process = subprocess.Popen([LAGLESS, "serve", str(path), "--serial", "--quiet"], text=True, stdout=subprocess.PIPE)
        self.addCleanup(self.stop, process)
        self.name = process.stdout.readline().split()[-1]
        time.sleep(0.2)  # the drive changes its protocol within this time
        return self.name

    def stop(self, process):
        process.terminate()
        process.communicate(timeout=20)
        self.assertEqual(process.returncode, 0, "serve ends in order when it is stopped")

    def open(self, more=""):
        self.line = os.open(self.serve(more), os.O_RDWR | os.O_NOCTTY)
        self.addCleanup(os.close, self.line)
        tty.setraw(self.line)

    def octets(self, count, patience=5.0):
        got = b""
        while len(got) < count and select.select([self.line], [], [], patience)[0]:
            got += os.read(self.line, count - len(got))
        return got

    def ask(self, *octets, address=17, good=True):
        """The answer without address and CRC; None if no answer came."""
        frame = bytes((address, *octets))
        check = crc(frame)
        os.write(self.line, frame + (check if good else bytes((check[0] ^ 1, check[1]))))
        head = self.octets(3, 5.0 if good else 0.5)
        if not head:
            return None
        whole = head + self.octets(2 if head[1] & 0x80 else head[2] + 2 if head[1] == READ else 5)
        self.assertEqual(crc(whole[:-2]), whole[-2:])
        self.assertEqual(17, whole[0])
        return whole[1:-2]

    def read(self, name, form=">i"):
        # A simulated drive that runs late on a busy machine may receive two frames without the silence between them. It answers neither,
        # and a master repeats its request.
        for _ in range(3):
            answer = self.ask(READ, *struct.pack(">HH", 2 * ID[name], 2))
            if answer is not None:
                break
        self.assertIsNotNone(answer, name)
        self.assertEqual(bytes((READ, 4)), answer[:2])
        return struct.unpack(form, answer[2:])[0]

    def write(self, name, value, form=">i"):
        return self.ask(WRITE, *struct.pack(">HHB", 2 * ID[name], 2, 4), *struct.pack(form, value))

    def expect_exception(self, number, answer):
        self.assertEqual([0x80 | answer[0] & 0x7F, number], list(answer))

    def wait_for(self, name, value):
        for _ in range(200):
            if self.read(name) == value:
                return
            time.sleep(0.05)
        self.fail(f"{name} has not become {value}")

    # ---- mbpoll ----

    def mbpoll(self, name, *values, form="int"):
        done = subprocess.run(["mbpoll", "-m", "rtu", "-a", "17", "-b", "19200", "-P", "none", "-0", "-B", "-o", "5", "-t", f"4:{form}",
                               "-r", str(2 * ID[name]), *([] if values else ["-1"]), self.name, *map(str, values)],
                              text=True, capture_output=True, timeout=60)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        found = re.search(r"^\[\d+\]:\s+(\S+)", done.stdout, re.MULTILINE)
        return float(found.group(1)) if found else None

    @unittest.skipUnless(shutil.which("mbpoll"), "mbpoll is not installed: tools/setup all")
    def test_mbpoll_reads_and_starts_the_drive_and_its_silence_stops_it(self):
        self.serve()
        self.assertTrue(280 < self.mbpoll("u_dc", form="float") < 330)
        self.mbpoll("speed_request", 50, form="float")
        self.mbpoll("enable", ON)
        speed = 0.0
        for _ in range(100):
            speed = self.mbpoll("omega_m", form="float")
            if speed > 49.0:
                break
        self.assertAlmostEqual(50.0, speed, delta=1.0)
        self.assertEqual(ON, self.mbpoll("enable"))
        time.sleep(2.5)  # longer than command_timeout, 1 s
        self.assertEqual(QUICK_STOP, self.mbpoll("enable"))
        self.mbpoll("enable", ON)  # the next request starts it again
        self.assertEqual(ON, self.mbpoll("enable"))

    # ---- frames and exceptions ----

    def test_wrong_frames_and_forbidden_writes_get_the_answers_of_the_page(self):
        self.open("current_limit = 8.0")
        enable, u_dc = struct.pack(">H", 2 * ID["enable"]), struct.pack(">H", 2 * ID["u_dc"])
        errors = self.read("line_errors")
        self.assertIsNone(self.ask(WRITE, *enable, 0, 2, 4, 0, 0, 0, ON, good=False))
        self.assertEqual(errors + 1, self.read("line_errors"))
        self.assertEqual(OFF, self.read("enable"))
        self.expect_exception(1, self.ask(7))
        self.expect_exception(2, self.ask(READ, 0xFF, 0xF0, 0, 2))
        self.expect_exception(2, self.write("u_dc", 100.0, ">f"))
        self.expect_exception(2, self.write("order_refusal", 0))
        self.expect_exception(2, self.ask(WRITE, *enable, 0, 1, 2, 0, 0))
        self.expect_exception(3, self.ask(READ, *u_dc, 0, 200))
        self.expect_exception(3, self.ask(WRITE, *enable, 0, 2, 4, 0, 0, 0))
        self.expect_exception(3, self.write("enable", 3))
        self.expect_exception(3, self.write("current_limit", float("nan"), ">f"))
        self.expect_exception(4, self.write("i_q_request", 9.0, ">f"))  # above current_limit
        self.assertEqual(0.0, self.read("i_q_request", ">f"))
        self.assertEqual(8.0, self.read("current_limit", ">f"))
        self.write("speed_request", 100.0, ">f")
        self.write("overspeed_trip", 50.0, ">f")
        self.expect_exception(4, self.write("order", 1))  # below the speed reference in use
        self.assertNotEqual(0, self.read("order_refusal"))

    def test_a_single_register_starts_the_drive_and_a_broadcast_stops_it(self):
        self.open()
        self.wait_for("state", 1)
        self.assertEqual(WRITE_ONE, self.ask(WRITE_ONE, *struct.pack(">HH", 2 * ID["enable"] + 1, ON))[0])
        self.wait_for("state", 3)
        frame = bytes((0, WRITE_ONE, *struct.pack(">HH", 2 * ID["enable"] + 1, QUICK_STOP)))
        os.write(self.line, frame + crc(frame))
        time.sleep(0.2)
        self.assertEqual(QUICK_STOP, self.read("enable"))

    def test_requests_to_other_drives_do_not_keep_the_motor_running(self):
        self.open()
        self.wait_for("state", 1)
        self.write("enable", ON)
        end = time.monotonic() + 3.0
        while time.monotonic() < end:
            frame = bytes((18, READ, 0, 2, 0, 2))
            os.write(self.line, frame + crc(frame))
            time.sleep(0.1)
        self.assertEqual(QUICK_STOP, self.read("enable"))

    def test_a_locked_drive_reads_and_stops_until_it_has_its_key(self):
        self.open("line_key = 4711")
        self.assertEqual(0, self.read("line_key"))
        self.expect_exception(1, self.write("enable", ON))
        self.expect_exception(1, self.write("current_limit", 5.0, ">f"))
        self.expect_exception(1, self.write("line_key", 4712))
        self.assertEqual(WRITE, self.write("enable", QUICK_STOP)[0])
        self.assertEqual(WRITE, self.write("line_key", 4711)[0])
        self.assertEqual(WRITE, self.write("current_limit", 5.0, ">f")[0])
        time.sleep(2.5)  # after this silence the drive is locked again
        self.expect_exception(1, self.write("current_limit", 6.0, ">f"))
        self.assertEqual(5.0, self.read("current_limit", ">f"))

    def test_the_way_back_to_xcp(self):
        self.open()
        self.write("line_protocol", 0)
        self.assertEqual(WRITE, self.write("order", 1)[0])
        done = subprocess.run([LAGLESS, "connect", self.name], input="get line_protocol\n", text=True, capture_output=True, timeout=60)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        self.assertIn("xcp", done.stdout)

    def test_the_page_has_the_registers_of_the_tables(self):
        done = subprocess.run([sys.executable, "-B", ROOT / "tools/modbus-docs", "--check", LAGLESS], text=True, capture_output=True)
        self.assertEqual(0, done.returncode, done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
