"""`lagless replay`: a drive at the serial line of the virtual chip has a fault; `connect` saves its record, and a new process replays it.
Files that do not belong to this program are refused.

usage: test_replay.py LAGLESS FOLDER"""

import csv
import json
import os
import re
import unittest

import command_line
from command_line import lagless

# The drive has no encoder and learns the inductance when a wire breaks, so that the tuning changes within the record.
LEARNS = """schema = 1
title = "Learns"
[run]
duration = "3 s"
[params]
fault_record = "replay"
[requests]
enable = "on"
speed_request = "500 r/min"
[plant]
resistance = 1.2
inductance_q = 0.015
inductance_d = 0.015
inertia = 0.02
load_torque = 3
[[at]]
time = "2.144 s"
plant.open_phase_a = 1
"""
TURNS = """schema = 1
title = "Turns"
[run]
duration = "0.5 s"
[params]
fault_record = "replay"
position_source = "encoder"
[requests]
enable = "on"
speed_request = "300 r/min"
"""
SAG = TURNS + '[[at]]\ntime = "0.3 s"\nplant.dc_voltage = 150\n'
TOO_HIGH = TURNS + """[[at]]
time = "0.3 s"
requests.speed_request = "400 r/min"
[[at]]
time = "0.302 s"
params.dc_overvoltage = "300 V"
"""
MODULE = TURNS + '[[at]]\ntime = "0.3 s"\nplant.force_fault = 1\n'


def check_of(text):
    value = 14695981039346656037
    for octet in text.encode():
        value = (value ^ octet) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}"


def sealed(text):
    """The text of a changed file with the checksum of its new content."""
    body = text[:text.rindex("check ")]
    return body + f"check {check_of(body)}\n"


class Replay(command_line.TestCase):
    def saved(self, scenario):
        """The file of a fault that was saved over the serial line, and what the drive reported about that fault."""
        path = os.path.join(self.folder, "field.replay")
        _, target = self.serve(self.write("field.toml", scenario), "--quiet", "--serial", place=r"(\S+)")
        done = self.expect(0, lagless("connect", target, "--json", timeout=120, input="\n".join([
            "capture wait 20 s", f"capture save {path}", "get fault_reason fault_period"]) + "\n"))
        said = json.loads(done.stdout.splitlines()[-1])
        return path, said["fault_reason"], int(said["fault_period"])

    def replayed(self, path, *options):
        return json.loads(self.expect(0, lagless("replay", path, "--json", *options)).stdout)

    def is_same(self, saved):
        path, reason, period = saved
        seen = self.replayed(path)
        self.assertTrue(seen["same"], seen)
        self.assertIsNone(seen["differs_from"])
        self.assertEqual(seen["recorded"]["period"], period)
        self.assertEqual(seen["replayed"], seen["recorded"])
        # A snapshot is replaced when the newer one is (rows - 16)/2 - 8 = 46 periods old. The medium task latches a fault of the last window, of 8
        # periods: this much of the time before the fault may be missing.
        self.assertGreaterEqual(period - seen["begin"], 46 - 8)
        return seen

    def run_to_fault(self, scenario):
        """The file of a simulated run."""
        self.expect(1, lagless("run", self.write("run.toml", scenario), "--quiet", "--out", self.folder, "--force"))
        return os.path.join(self.folder, "run.replay")

    def rows(self, name):
        return list(csv.DictReader(line for line in self.read(name).splitlines() if not line.startswith("#")))

    def test_broken_wire_of_a_drive_that_has_learnt(self):
        path, *said = self.saved(LEARNS)
        self.assertEqual(self.is_same((path, *said))["replayed"]["reason"], "phase_loss")
        self.replayed(path, "--out", self.folder)
        self.assertGreater(float(self.rows("field_replay.csv")[0]["inductance_hat[H]"]), 13e-3)  # larger than the parameter, 12.5 mH

    def test_tuning_that_the_drive_has_learnt_just_before(self):
        """Faults at several times: the tuning changes every 10 ms at most, and each record contains at least the last 4.6 ms."""
        tunings = []
        for time in ("2.204", "2.208", "2.212", "2.216", "2.220"):
            seen = self.replayed(self.run_to_fault(LEARNS.replace("2.144 s", f"{time} s")))
            self.assertTrue(seen["same"])
            tunings.append(seen["tunings"])
        self.assertGreaterEqual(max(tunings), 1)

    def test_sag_of_the_link(self):
        self.assertEqual(self.is_same(self.saved(SAG))["replayed"]["reason"], "dc_undervoltage")

    def test_fault_right_after_a_request_and_a_parameter(self):
        seen = self.is_same(self.saved(TOO_HIGH))
        self.assertEqual((seen["replayed"]["reason"], seen["requests"]), ("dc_overvoltage", 1))
        self.assertGreaterEqual(seen["tunings"], 1)

    def test_trip_of_the_power_module_and_the_recording_of_all_signals(self):
        path = self.run_to_fault(MODULE)
        seen = self.replayed(path, "--out", self.folder)
        self.assertEqual((seen["replayed"]["reason"], seen["same"]), ("module_fault", True))
        rows, whole = self.rows("run_replay.csv"), self.rows("run.csv")
        self.assertEqual(len(rows), seen["periods"])
        by_time = {row["time[s]"]: row for row in whole}
        for row in rows:
            for name in ("i_q[A]", "i_d[A]", "omega_m_ref[rad/s]", "u_dc[V]"):
                self.assertEqual(row[name], by_time[row["time[s]"]][name])

    def test_text_says_what_happened_and_what_to_do(self):
        done = self.expect(0, lagless("replay", self.run_to_fault(SAG)), "bit for bit, in all", "dc_undervoltage in period",
                           "what happened:", "what to do:")
        self.assertIn(lagless("--version").stdout.split()[1] + ",", done.stdout)  # the firmware has the version of the program

    def test_a_changed_sample_gives_other_duties(self):
        path = self.run_to_fault(SAG)
        text = self.read("run.replay")
        lines = text.splitlines(keepends=True)
        first = next(n for n, line in enumerate(lines) if line.startswith("slots ")) + 1
        slots = "".join(lines[first:-1]).split()
        for period in range(0, 120, 20):  # the replay begins in one of the first of them, and contains a later one
            at = 20 + 4 * period  # after the head
            slots[at] = f"{int(slots[at], 16) ^ 0x40:08x}"  # changes a value of sensor a by 64 codes
        body = "\n".join(" ".join(slots[n:n + 8]) for n in range(0, len(slots), 8)) + "\n"
        self.write("run.replay", sealed("".join(lines[:first]) + body + lines[-1]))
        self.expect(1, lagless("replay", path), "DIFFERENT   duties or gates from period")

    def test_each_flipped_octet_is_found(self):
        path = self.run_to_fault(SAG)
        with open(path, "rb") as file:
            octets = file.read()
        for at in (40, len(octets) // 2, len(octets) - 30, len(octets) - 3):
            with open(path, "wb") as file:
                file.write(octets[:at] + bytes([octets[at] ^ 1]) + octets[at + 1:])
            told = self.expect(2, lagless("replay", path)).stderr
            self.assertRegex(told, "check .*the file was changed or damaged|`check` is missing at the end")
        for length in (8, 100, len(octets) // 2, len(octets) - 1):
            with open(path, "wb") as file:
                file.write(octets[:length])
            self.expect(2, lagless("replay", path), "the file is cut")

    def test_each_wrong_item_is_named_with_what_is_accepted(self):
        path = self.run_to_fault(SAG)
        text = self.read("run.replay")

        def slot(number, value):
            def change(text):
                head, slots, rest = re.fullmatch(r"(.*?\nslots \d+\n)(.*)(check .*)", text, re.DOTALL).groups()
                return head + slots[:9 * number] + f"{value:08x}" + slots[9 * number + 8:] + rest
            return change

        def line(before, after):
            return lambda text: re.sub(before, after, text, count=1, flags=re.MULTILINE)

        for change, *fragments in (
            (line("^lagless replay 1", "lagless replay 2"), "format 2: accepted: 1"),
            (line("^tables .*", "tables lagless-00000000"), "tables lagless-00000000: accepted: lagless-"),
            (line("^board .*", "board other"), "board other: accepted:"),
            (line("^board .*\n", ""), "the line `board` is missing"),
            (line("^period .*", "period 1"), "period 1: accepted:"),
            (line("^slots .*", "slots 9"), "slots 9: accepted:"),
            (line("^slots (.*)", r"slots 4000"), "accepted: the number of slots that follow"),
            (slot(0, 7), "format 7 of the record: accepted: 1"),
            (slot(2, 0x020304), "firmware 2.3.4: accepted: 0.1.0"),
            (slot(3, 1), "layout 00000001 of the state: accepted:"),
            (slot(6, 4), "with 4 periods: accepted:"),
            (slot(10, 0), "no complete snapshot of the state before the trigger"),
            (slot(13, 50000), "carrier with a period of 50000 ns: accepted: 100000 ns"),
        ):
            with self.subTest(fragments=fragments):
                self.write("run.replay", sealed(change(text)))
                self.expect(2, lagless("replay", path), *fragments)
        self.refuses((("replay",), "no file is given"), (("replay", path + "x"), "it cannot be read"))

    def test_buffer_of_signals_is_no_record(self):
        _, target = self.serve(self.write("a.toml", TURNS.replace('"replay"', '"signals"')), "--quiet", "--port", "0")
        self.expect(1, lagless("connect", "tcp://" + target, input=f"capture save {self.folder}/a.replay\n", timeout=60),
                    "the capture buffer contains signals", "fault_record replay")


if __name__ == "__main__":
    unittest.main(argv=[__file__])
