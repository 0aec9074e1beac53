"""tools/debug on the record of a drive: it stops in the period of the fault. The recorded structs must consist of slots, so that a record
from the chip has the layout of the host.

usage: test_replay.py --root FOLDER --program LAGLESS (of the preset debug)
Ends with 77 (skipped) where there is no gdb with Python."""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PARSER = argparse.ArgumentParser()
PARSER.add_argument("--root", type=pathlib.Path, required=True)
PARSER.add_argument("--program", type=pathlib.Path, required=True)
OPTIONS, REST = PARSER.parse_known_args()

SCENARIO = """schema = 1
title = "Sag"
[run]
duration = "0.35 s"
[params]
fault_record = "replay"
position_source = "encoder"
[requests]
enable = "on"
speed_request = "300 r/min"
[[at]]
time = "0.3 s"
plant.dc_voltage = 150
"""
# Lists the members whose type is not that of a slot, read by gdb: a plain int or a bool has another size on a C28x, a pointer another
# meaning.
WALK = r"""
def walk(kind, name):
    names = []
    while kind.code == gdb.TYPE_CODE_TYPEDEF:
        names.append(kind.name)
        kind = kind.target()
    if kind.code in (gdb.TYPE_CODE_STRUCT, gdb.TYPE_CODE_UNION):
        for field in kind.fields():
            walk(field.type, f"{name}.{field.name}")
    elif kind.code == gdb.TYPE_CODE_ARRAY:
        walk(kind.target(), name)
    elif not {"int32_t", "uint32_t"} & set(names) and str(kind) != "float":
        print("no slot:", name, kind)
    else:
        count.append(name)
count = []
for name in ("drive_t", "params_t", "believed_t", "requests_t"):
    walk(gdb.lookup_type(name), name)
print("slots:", len(count))
"""


def run(*line):
    return subprocess.run([str(word) for word in line], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                          text=True, timeout=120, check=False).stdout


class Replay(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_debugger_stops_in_the_period_of_the_fault(self):
        (self.folder / "sag.toml").write_text(SCENARIO)
        run(OPTIONS.program, "run", self.folder / "sag.toml", "--quiet", "--out", self.folder)
        record = self.folder / "sag.replay"
        head = dict(line.partition(" ")[::2] for line in record.read_text().splitlines()[:8])
        period = int(head["period"])  # by the count of the drive, which is 1 in period 0 of the simulation
        said = run(sys.executable, OPTIONS.root / "tools/debug", record, "--program", OPTIONS.program, "--batch",
                   "-ex", "print app->drive.fast.period", "-ex", "period -2", "-ex", "until-fault", "-ex", "why")
        self.assertIn(f"period {period - 1}, {(period - 1) * 1e-4:.4f} s + 0.00 us", said)
        self.assertIn(f"$1 = {period - 1}", said)  # the step of the fault has not been executed
        self.assertIn(f"period {period - 3}, ", said)
        self.assertIn("fault 23, dc_undervoltage, by show_fault", said)
        self.assertIn(f"when: period {period} by the drive's count", said)
        self.assertIn("periods that the drive has kept:", said)

    def test_record_consists_of_slots(self):
        (self.folder / "walk.py").write_text(WALK)
        said = run("gdb", "-nx", "-q", "-batch", "-x", self.folder / "walk.py", OPTIONS.program)
        self.assertNotIn("no slot:", said)
        self.assertRegex(said, r"slots: [1-9]\d{2,}")


if shutil.which("gdb") is None or "yes" not in run("gdb", "-nx", "-q", "-batch", "-ex", "python print('y' + 'es')"):
    print("skipped: no gdb with Python")
    sys.exit(77)
unittest.main(argv=[__file__, *REST])
