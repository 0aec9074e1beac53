"""Drive and plant as FMUs of their own (`lagless fmu --part`), coupled once in a period: every period has the same bits as the closed loop in one program.

usage: test_parts.py LAGLESS FOLDER      run by a Python that has fmpy (tools/setup all puts it into build/venv); without it this ends
with 77, skipped."""
import importlib.util
import json
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

if importlib.util.find_spec("fmpy") is None:
    print("skipped: this Python has no fmpy (tools/setup all installs it into build/venv)")
    sys.exit(77)

import fmpy  # noqa: E402
import numpy  # noqa: E402
from fmpy.fmi1 import FMICallException  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

from coupled import Coupled, Part  # noqa: E402

LAGLESS, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2]).absolute()
HERE = pathlib.Path(__file__).resolve()
DOCUMENT = HERE.parents[2] / "docs/fmu.md"
HEAD = 'schema = 1\ntitle = "parts"\n[run]\nduration = "2 s"\nseed = 7\n'
RUNS = '[params]\nposition_source = "encoder"\n[requests]\nenable = "on"\nspeed_request = "20 rad/s"\n'
# Events of both parts, and a ramp.
EVENTS = (HEAD + RUNS + '[plant]\ndc_resistance = 0.5\ndc_capacitance = 1e-3\n[[at]]\ntime = "0.1 s"\nramp = "0.05 s"\nplant.load_torque = "1 N m"\n'
          '[[at]]\ntime = "0.3 s"\nparams.speed_kp = 0.4\nrequests.speed_request = "30 rad/s"\nrig.missing_samples = 2\n'
          '[[at]]\ntime = "0.4 s"\nplant.supply_lost = 1\n')
SHORT = HEAD + RUNS + '[[at]]\ntime = "0.2 s"\nplant.shorted_switches = 1\n'
SHUNTS = 'schema = 1\ntitle = "shunts"\nboard = "mosfet_48v_60a"\nmotor = "teknic-m2310p-ln-04k"\n[run]\nduration = "1 s"\n[requests]\nenable = "on"\nspeed_request = "60 rad/s"\n'


def lagless(*arguments):
    return subprocess.run([LAGLESS, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def archives(scenario, *parts):
    """The FMUs of a scenario, a shipped one or the text of one."""
    if "\n" in scenario:
        path = FOLDER / "own.toml"
        path.write_text(scenario)
        scenario = str(path)
    for part in parts:
        lagless("fmu", scenario, "--part", part, "--out", FOLDER, "--force")
    stem = pathlib.Path(scenario).stem
    return [FOLDER / (f"{stem}.fmu" if part == "ring" else f"{stem}_{part}.fmu") for part in parts]


class Outputs:
    """Those of the drive, then those of the plant, of a ring or of two coupled parts."""

    def __init__(self, *parts):
        names = [name for part in (DRIVE, PLANT) for name in part]
        self.parts = [(part, *part.split([name for name in names if name in part.names("output")])) for part in parts]
        self.names = [name for _, _, names in self.parts for name in names]

    def read(self):
        return {name: value for part, (reals, whole), names in self.parts
                for name, value in zip(names, part.slave.getReal(reals) + part.slave.getInteger(whole))}


class Parts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        global DRIVE, PLANT
        shutil.rmtree(FOLDER, ignore_errors=True)
        FOLDER.mkdir(parents=True)
        ring, drive, plant = (fmpy.read_model_description(str(archive)) for archive in archives(EVENTS, "ring", "drive", "plant"))
        outputs = [{variable.name for variable in model.modelVariables if variable.causality == "output"} for model in (ring, drive, plant)]
        DRIVE, PLANT = sorted(outputs[1] & outputs[0]), sorted(outputs[2] & outputs[0])
        (FOLDER / "names.json").write_text(json.dumps([DRIVE, PLANT]))
        assert outputs[0] - outputs[1] - outputs[2] == {"theta_err", "theta_hat_err", "chip_reports"}

    def expect_equal(self, scenario, periods, exact=False):
        """Returns how often the master has repeated a period of the drive."""
        ring, drive, plant = (Part(archive, FOLDER) for archive in archives(scenario, "ring", "drive", "plant"))
        both = Coupled(drive, plant, exact)
        ring.slave.exitInitializationMode()
        whole, halves = Outputs(ring), Outputs(drive, plant)
        for period in range(periods):
            ring.step(period)
            both.step()
            expected, found = whole.read(), halves.read()
            wrong = [name for name in found if expected[name] != found[name] and not (expected[name] != expected[name] and found[name] != found[name])]
            self.assertEqual(wrong, [], f"{scenario}: period {period}")
        for part in (ring, drive, plant):
            part.free()
        return both.repeated

    def test_both_are_valid_and_fit_each_other(self):
        models = []
        for archive in archives("load_step", "drive", "plant"):
            self.assertEqual(validate_fmu(str(archive)), [])
            models.append({variable.name: variable for variable in fmpy.read_model_description(str(archive)).modelVariables})
        for source, target, prefix in ((*models, "command_"), (*reversed(models), "sample_")):
            sent = {name for name in source if name.startswith(prefix) and name in target}
            self.assertGreater(len(sent), 8)
            for name in sent:
                self.assertEqual((source[name].causality, target[name].causality, source[name].type), ("output", "input", target[name].type))

    def test_coupled_once_a_period_they_have_the_bits_of_the_ring(self):
        for scenario, periods in ((EVENTS, 5000), ("cold_start", 12000), ("hoist", 8000), (SHUNTS, 6000)):
            with self.subTest(scenario=scenario):
                self.assertEqual(self.expect_equal(scenario, periods), 0)

    def test_a_trip_within_a_period_is_exact_if_the_master_repeats_the_period(self):
        self.assertEqual(self.expect_equal(SHORT, 2200, exact=True), 1)

    def test_states_of_both_go_on_in_a_new_process(self):
        drive, plant = (Part(archive, FOLDER) for archive in archives(EVENTS, "drive", "plant"))
        both = Coupled(drive, plant)
        for _ in range(1200):  # within the ramp
            both.step()
        for part in (drive, plant):
            state = part.slave.getFMUState()
            (FOLDER / f"{part.model.guid.split('-')[-2]}.state").write_bytes(part.slave.serializeFMUState(state))
            part.slave.freeFMUState(state)
        first = run(both, 1500)
        drive.free()
        plant.free()
        done = subprocess.run([sys.executable, "-B", str(HERE), LAGLESS, str(FOLDER), "restored"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(numpy.array_equal(first, numpy.load(FOLDER / "restored.npy"), equal_nan=True))

    def test_a_step_may_end_at_most_one_period(self):
        drive = Part(archives(EVENTS, "drive")[0], FOLDER)
        drive.slave.exitInitializationMode()
        period = [drive.variables["period"].valueReference]
        for n in range(10):
            before = drive.slave.getReal(period)[0]
            drive.slave.doStep(n * drive.period / 4, drive.period / 4)
            self.assertEqual(drive.slave.getReal(period)[0] - before, 1.0 if n % 4 == 3 else 0.0)
        with self.assertRaises(FMICallException):
            drive.slave.doStep(10 * drive.period / 4, 2.5 * drive.period)
        drive.free()

    def test_a_value_out_of_range_is_refused(self):
        plant = Part(archives(EVENTS, "plant")[0], FOLDER)
        plant.slave.exitInitializationMode()
        reference = [plant.variables["command_duty_a"].valueReference]
        with self.assertRaises(FMICallException):
            plant.slave.setReal(reference, [1.5])
        self.assertEqual(plant.slave.getReal(reference), [0.5])
        plant.free()

    def test_a_state_of_the_other_part_is_refused(self):
        drive, plant = (Part(archive, FOLDER) for archive in archives(EVENTS, "drive", "plant"))
        state = drive.slave.getFMUState()
        octets = drive.slave.serializeFMUState(state)
        with self.assertRaises(FMICallException):
            plant.slave.deSerializeFMUstate(octets)
        drive.free()
        plant.free()

    def test_the_master_of_the_document_runs(self):
        code = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.S)[-1]
        (FOLDER / "units").mkdir(exist_ok=True)
        for part in ("drive", "plant"):
            lagless("fmu", "load_step", "--part", part, "--out", FOLDER / "units", "--force")
        done = subprocess.run([sys.executable, "-c", code.replace("60000", "3000")], cwd=FOLDER, capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lagless("run", "load_step", "--quiet", "--force", "--every", 1, "--record", "true_omega_m", "--out", FOLDER / "recorded")
        rows = (FOLDER / "recorded/load_step.csv").read_text(encoding="utf-8").splitlines()
        values = [float(row.split(",")[-1]) for row in rows if row[:1].isdigit()]
        self.assertAlmostEqual(float(done.stdout.split()[-2]), values[2999], places=4)


def run(both, periods):
    outputs = Outputs(both.drive, both.plant)
    rows = []
    for _ in range(periods):
        both.step()
        rows.append(list(outputs.read().values()))
    return numpy.array(rows)


def restored():
    """In a separate process: the states from the files, and the following periods."""
    global DRIVE, PLANT
    drive, plant = Part(FOLDER / "own_drive.fmu", FOLDER), Part(FOLDER / "own_plant.fmu", FOLDER)
    DRIVE, PLANT = json.loads((FOLDER / "names.json").read_text())
    both = Coupled(drive, plant)
    for part in (drive, plant):
        name = part.model.guid.split("-")[-2]
        part.slave.setFMUState(part.slave.deSerializeFMUstate((FOLDER / f"{name}.state").read_bytes()))
    both.period = 1200
    numpy.save(FOLDER / "restored.npy", run(both, 1500))


if sys.argv[3:] == ["restored"]:
    restored()
else:
    unittest.main(argv=sys.argv[:1])
