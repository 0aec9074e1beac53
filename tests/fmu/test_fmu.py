"""The FMU of `lagless fmu` in fmpy, a co-simulation master of other authors, which is not modified.

usage: test_fmu.py LAGLESS FOLDER      run by a Python that has fmpy (tools/setup all puts it into build/venv); without it this ends
with 77, skipped."""
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import unittest

if importlib.util.find_spec("fmpy") is None:
    print("skipped: this Python has no fmpy (tools/setup all installs it into build/venv)")
    sys.exit(77)

import fmpy  # noqa: E402
import numpy  # noqa: E402
from fmpy.fmi2 import FMU2Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

LAGLESS, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2]).absolute()
PERIOD = 1e-4
HERE = pathlib.Path(__file__).resolve()
# The scenario has a ramp, an event of the plant, a parameter that changes, and a light load, which a master changes later.
SCENARIO = """schema = 1
title = "a <ring> & its events"
[run]
duration = "0.5 s"
seed = 7
[params]
position_source = "encoder"
[requests]
enable = "on"
speed_request = "20 rad/s"
[[at]]
time = "0.1 s"
ramp = "0.05 s"
plant.load_torque = "1 N m"
[[at]]
time = "0.3 s"
params.speed_kp = 0.4
requests.speed_request = "30 rad/s"
"""


class Ring:
    """An instance that is stepped period by period; its outputs are rows of numbers."""

    def __init__(self, archive):
        self.folder = fmpy.extract(archive, unzipdir=FOLDER / f"unzipped_{pathlib.Path(archive).stem}")
        self.model = fmpy.read_model_description(archive)
        self.variables = {variable.name: variable for variable in self.model.modelVariables}
        self.outputs = [variable for variable in self.model.modelVariables if variable.causality == "output"]
        self.reals = [variable.valueReference for variable in self.outputs if variable.type == "Real"]
        self.whole = [variable.valueReference for variable in self.outputs if variable.type != "Real"]
        self.names = ([variable.name for variable in self.outputs if variable.type == "Real"] +
                      [variable.name for variable in self.outputs if variable.type != "Real"])
        self.slave = FMU2Slave(guid=self.model.guid, unzipDirectory=self.folder,
                               modelIdentifier=self.model.coSimulation.modelIdentifier, instanceName="ring")
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.period = 0

    def step(self, periods=1):
        self.slave.doStep(self.period * PERIOD, periods * PERIOD)
        self.period += periods
        return self.slave.getReal(self.reals) + self.slave.getInteger(self.whole)

    def run(self, count):
        return numpy.array([self.step() for _ in range(count)])

    def set(self, name, value):
        variable = self.variables[name]
        (self.slave.setReal if variable.type == "Real" else self.slave.setInteger)([variable.valueReference], [value])

    def free(self):
        self.slave.terminate()
        self.slave.freeInstance()


def lagless(*arguments):
    return subprocess.run([LAGLESS, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def recorded(scenario, names, *more):
    """The values of these signals that `lagless run` records in every period, read from the MDF file (tests/recorder/check_mdf.py)."""
    out = FOLDER / "recorded"
    lagless("run", scenario, "--quiet", "--force", "--every", 1, "--record", ",".join(names), "--format", "mdf", "--out", out, *more)
    kinds = {variable.name: ("<f4" if variable.type == "Real" else "<i4") for variable in KNOWN.values()}
    kinds.update({name: "<u4" for name in UNSIGNED})
    record = numpy.dtype([("time", "<f8"), *((name, kinds[name]) for name in names)])
    octets = next(out.glob(f"{pathlib.Path(scenario).stem}.mf4")).read_bytes()
    at = octets.rindex(b"##DT\0\0\0\0") + 24
    samples = numpy.frombuffer(octets[at:], record)
    return numpy.array([samples[name].astype(float) for name in names]).T


def same(a, b):
    """Equal, or both are NaN."""
    return a.shape == b.shape and bool(((a == b) | (numpy.isnan(a) & numpy.isnan(b))).all())


class Fmu(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        global KNOWN, UNSIGNED
        shutil.rmtree(FOLDER, ignore_errors=True)
        FOLDER.mkdir(parents=True)
        cls.scenario = FOLDER / "own.toml"
        cls.scenario.write_text(SCENARIO)
        lagless("fmu", cls.scenario, "--out", FOLDER)
        cls.archive = str(FOLDER / "own.fmu")
        KNOWN = {variable.name: variable for variable in fmpy.read_model_description(cls.archive).modelVariables}
        import json
        UNSIGNED = {row["name"] for row in json.loads(lagless("signals", "--json"))["rows"] if row["kind"] == "uint32"}

    def test_it_is_valid(self):
        self.assertEqual(validate_fmu(self.archive), [])
        model = fmpy.read_model_description(self.archive)
        self.assertEqual(model.description, "a <ring> & its events")
        self.assertEqual(float(model.defaultExperiment.stepSize), PERIOD)
        self.assertGreater(len(model.modelVariables), 250)

    def test_every_output_of_every_period_has_the_bits_of_the_program(self):
        """The scenarios are one written in this file with events and ramps, a shipped cold start of a motor without encoder, and two
        shipped ones with a fault and with profiles."""
        for scenario, periods in ((self.scenario, 5000), ("cold_start", 20000), ("dc_link_sag", 12000), ("both_directions", 12000)):
            with self.subTest(scenario=str(scenario)):
                lagless("fmu", scenario, "--out", FOLDER, "--force")
                ring = Ring(str(FOLDER / f"{pathlib.Path(scenario).stem}.fmu"))
                found = ring.run(periods)
                ring.free()
                expected = recorded(scenario, ring.names)[:periods]
                wrong = [name for n, name in enumerate(ring.names) if not same(found[:, n:n + 1], expected[:, n:n + 1])]
                self.assertEqual(wrong, [])
                self.assertTrue(same(found, expected))

    def test_a_state_goes_on_where_it_was_saved_also_in_a_new_process(self):
        ring = Ring(self.archive)
        ring.run(1200)  # within the ramp of the scenario
        state = ring.slave.getFMUState()
        (FOLDER / "state").write_bytes(ring.slave.serializeFMUState(state))
        first = ring.run(1500)
        ring.slave.setFMUState(state)
        ring.period = 1200
        again = ring.run(1500)
        ring.slave.freeFMUState(state)
        ring.free()
        self.assertTrue(same(first, again))
        done = subprocess.run([sys.executable, "-B", str(HERE), LAGLESS, str(FOLDER), "restored"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(same(first, numpy.load(FOLDER / "restored.npy")))

    def test_what_a_master_sets_is_what_an_event_sets(self):
        with_event = FOLDER / "event.toml"
        with_event.write_text(SCENARIO + '[[at]]\ntime = "0.4 s"\nrequests.speed_request = 25\nrequests.enable = "quick_stop"\n')
        ring = Ring(self.archive)
        ring.run(4000)
        ring.set("speed_request", 25.0)
        ring.set("enable", 2)
        found = ring.run(1000)
        ring.free()
        self.assertTrue(same(found, recorded(with_event, ring.names)[4000:]))

    def test_long_steps_and_the_masters_own_loop_come_to_the_same(self):
        ring = Ring(self.archive)
        single = ring.run(5000)
        ring.free()
        ring = Ring(self.archive)
        long = numpy.array([ring.step(250) for _ in range(20)])
        ring.free()
        self.assertTrue(same(long, single[249::250]))
        result = fmpy.simulate_fmu(self.archive, stop_time=0.5, step_size=PERIOD, output_interval=0.001, output=["true_omega_m", "i_q"])
        self.assertEqual(len(result), 501)
        for name in ("true_omega_m", "i_q"):
            self.assertTrue(same(result[name][1:], single[9::10, ring.names.index(name)]))

    def test_a_start_value_is_what_set_of_the_program_is(self):
        result = fmpy.simulate_fmu(self.archive, stop_time=0.4, step_size=PERIOD, output_interval=PERIOD,
                                   start_values={"inertia": 0.02, "speed_kp": 0.3}, output=["true_omega_m", "i_q"])
        expected = recorded(self.scenario, ["true_omega_m", "i_q"], "--set", "inertia=0.02", "--set", "speed_kp=0.3")
        for n, name in enumerate(("true_omega_m", "i_q")):
            self.assertTrue(same(result[name][1:], expected[:4000, n]))


def restored():
    """Loads the state from the file in a separate process and makes the following steps."""
    ring = Ring(str(FOLDER / "own.fmu"))
    ring.slave.setFMUState(ring.slave.deSerializeFMUstate((FOLDER / "state").read_bytes()))
    ring.period = 1200
    numpy.save(FOLDER / "restored.npy", ring.run(1500))
    ring.free()


if sys.argv[3:] == ["restored"]:
    restored()
else:
    unittest.main(argv=sys.argv[:1])
