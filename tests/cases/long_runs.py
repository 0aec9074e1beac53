"""The common part of field_weakening.py and saturation.py: their arguments, the voltage that the inverter makes, and runs of scenarios that
these programs write.

usage: NAME.py [--long] LAGLESS FOLDER [TEST...]

LAGLESS_GRID_SEED (by default the UTC date as YYYYMMDD) selects the share of a grid that runs; with --long the whole grid runs."""
import csv
import datetime
import itertools
import math
import os
import pathlib
import random
import subprocess
import sys

LONG = "--long" in sys.argv
LAGLESS, FOLDER, *TESTS = [a for a in sys.argv[1:] if not a.startswith("-")]
FOLDER = pathlib.Path(FOLDER)
FOLDER.mkdir(parents=True, exist_ok=True)
LINK = 311.0
DEVICE = 0.0215  # [ohm] differential resistance of a transistor or diode
VOLTAGE = 0.98 * (0.92 / math.sqrt(3) - 4 / math.pi * 0.023) * LINK
SEED = os.environ.get("LAGLESS_GRID_SEED") or f"{datetime.datetime.now(datetime.timezone.utc):%Y%m%d}"
DRAW = random.Random(SEED)
print(f"LAGLESS_GRID_SEED={SEED}", flush=True)


def share(cells, number):
    """All cells with --long, otherwise a random choice of this number of them."""
    cells = list(cells)
    return cells if LONG else DRAW.sample(cells, number)


def at(time, *lines, ramp=None):
    return f"[[at]]\ntime = {time}\n" + (f"ramp = {ramp}\n" if ramp else "") + "".join(line + "\n" for line in lines)


def recorded(names, name, text, *settings):
    """The samples of a run, each as a dictionary of the time and these signals."""
    scenario = FOLDER / f"{name}.toml"
    scenario.write_text(text)
    done = subprocess.run([LAGLESS, "run", "--force", "--every", "5", "-o", FOLDER, "-r", ",".join(names), scenario,
                           *itertools.chain(*(("-s", s) for s in settings))], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise AssertionError(done.stderr)
    with (FOLDER / f"{name}.csv").open() as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        next(rows)
        return [dict(zip(("time", *names), map(float, row))) for row in rows]


def keep(case, line, value, limit):
    """The value is at most this limit; tools/salient shows the largest value of a line in docs/salient.md."""
    print(f"measured {line}: {value:.6g}, limit {limit:.6g}", flush=True)
    case.assertLessEqual(value, limit, line)


def column(rows, name, begin=0.0, end=1e9):
    return [row[name] for row in rows if begin <= row["time"] < end]


def mean(values):
    return sum(values) / len(values)


def peak(rows, begin, end=1e9):
    """The largest absolute error of the angle [mrad]."""
    return 1e3 * max(map(abs, column(rows, "theta_hat_err", begin, end)))


def first(rows, begin, holds):
    """The first time after `begin` at which the function `holds` is true for the speed."""
    return next((row["time"] for row in rows if row["time"] > begin and holds(row["true_omega_m"])), math.inf)
