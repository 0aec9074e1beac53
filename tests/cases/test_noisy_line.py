"""`lagless connect` over the chip's serial line, which inverts some bits in both directions: each command ends correctly, with the values
that were sent.

usage: test_noisy_line.py LAGLESS FOLDER"""
import os
import pathlib
import pty
import subprocess
import sys
import threading
import tty
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import stuck  # noqa: E402

LAGLESS, FOLDER = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2])
SCENARIO = 'schema = 1\ntitle = "A motor on a noisy line"\n[run]\nduration = "1 s"\n[params]\nposition_source = "encoder"\n[rig]\nfidelity = "averaged"\n'


class Line:
    """A line between two ends. It inverts one bit of every octet whose number is in `wrong`, and loses every octet whose number is in
    `lost`."""

    def __init__(self, drive, wrong, lost=()):
        self.drive = os.open(drive, os.O_RDWR | os.O_NOCTTY)
        self.inner, outer = pty.openpty()
        tty.setraw(outer)
        self.outer, self.name = outer, os.ttyname(outer)
        self.spoilt = 0
        self.wrong, self.lost = wrong, lost
        for source, to in ((self.inner, self.drive), (self.drive, self.inner)):
            threading.Thread(target=self.carry, args=(source, to), daemon=True).start()

    def carry(self, source, to):
        count = 0
        while True:
            try:
                octets = os.read(source, 256)
            except OSError:
                return
            out = bytearray()
            for octet in octets:
                count += 1
                if count in self.wrong:
                    octet ^= 1 << count % 8
                    self.spoilt += 1
                if count in self.lost:
                    self.spoilt += 1
                else:
                    out.append(octet)
            os.write(to, bytes(out))


class Noise(stuck.TestCase):
    def serve(self):
        FOLDER.mkdir(parents=True, exist_ok=True)
        path = FOLDER / "noisy.toml"
        path.write_text(SCENARIO, encoding="utf-8")
        process = subprocess.Popen([LAGLESS, "serve", str(path), "--serial", "--quiet"], text=True, stdout=subprocess.PIPE)
        self.addCleanup(lambda: (process.kill(), process.communicate()))
        return process.stdout.readline().split()[-1]

    def session(self, line, *commands):
        done = subprocess.run([LAGLESS, "connect", line.name], input="\n".join(commands) + "\n", text=True, capture_output=True, timeout=200)
        self.assertEqual(0, done.returncode, done.stdout + done.stderr)
        return done.stdout

    def number(self, text, name):
        return float(next(row.split()[1] for row in reversed(text.splitlines()) if row.startswith(name + " ")))

    def test_a_session_ends_well_with_wrong_bits_in_both_directions(self):
        # wrong octets in the first frames, among them CONNECT, and in later ones: each makes the master wait for a second
        line = Line(self.serve(), wrong={5, 40, 41, 131, 320, 560, 2000})
        out = self.session(line, "wait until state == ready", "set current_limit 8 A", "get current_limit", "go 200 r/min",
                           "wait until omega_m > 195 r/min timeout 30 s", "get speed_request enable line_errors", "off",
                           "wait until state == ready", "get enable")
        self.assertGreaterEqual(line.spoilt, 7)
        self.assertEqual([8.0, 200.0], [self.number(out, "current_limit"), round(self.number(out, "speed_request"), 3)])
        self.assertGreater(self.number(out, "line_errors"), 0)
        self.assertIn("on, going to 200 r/min", out)
        self.assertRegex(out, r"enable +off\s*$")

    def test_lost_octets_are_tolerated(self):
        line = Line(self.serve(), wrong=(), lost={30, 100, 101, 102, 400})
        out = self.session(line, "wait until state == ready", "set current_limit 8 A", "apply", "get current_limit")
        self.assertGreaterEqual(line.spoilt, 5)
        self.assertEqual(8.0, self.number(out, "current_limit"))

    def test_without_noise_nothing_is_counted(self):
        line = Line(self.serve(), wrong=())
        out = self.session(line, "wait until state == ready", "go 200 r/min", "wait 0.5 s", "off", "get line_errors")
        self.assertEqual(0, self.number(out, "line_errors"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
