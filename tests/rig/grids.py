#!/usr/bin/env python3
"""Grids of scenarios: a scenario with expressions in braces, for every point of a product of parameters.

usage: grids.py RUN_SCENARIO FOLDER GRID

A file *.grid has one or more grids. Of each,
    grid NAME
    each A, B in VALUES      an axis: one name, or several that go together
    let A = EXPRESSION       a name for what follows, of every point
and the scenario behind them (docs/scenarios.md), in which an event and an expectation are a line each:
    at TIME: row = value, row = value
    expect SIGNAL STATISTIC from TIME to TIME >= LIMIT <= LIMIT
A line that begins with spaces goes on with the one before. Expressions, in braces and behind `from`, `to` and `at`, are Python's; they
know the names of the grid, `math`, and
    on                       [s] when the drive is switched on: its offsets are measured, and up to seven periods have passed
    draw(a, b)               a number between them, another one in each point
    desk(...)                sections and events that all share, below: the rotor, and the sensors' errors that calibration leaves
Of the points one in LAGLESS_GRID_SHARE (10; 1: all) runs, by a draw from LAGLESS_GRID_SEED (the date), at least one of each grid;
LAGLESS_SEED moves the noise, as in tests/rig/seed.h. Ends with 0 all limits kept, 1 not, 2 wrong use."""
import datetime
import itertools
import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys

MEMBERS, PHASES, PERIOD = 64, 8, 1e-4
LIGHT = {"params.motor_inertia": 0.003, "params.pll_bandwidth": 400, "params.feedforward_cutoff": 125, "plant.inertia": 0.003}
# The speed control of the paper's figures, which learns nothing.
PAPER = {"params.speed_kp": 0.5, "params.speed_ki": 2.5, "params.speed_setpoint_weight": 1, "params.torque_feedforward": 0,
         "params.inductance_adaptation": 0, "params.dead_time_adaptation": 0, "params.inertia_adaptation": "off", "params.low_speed_current": 0}
# The paper's rig; its bare motor, with the bandwidths that a rotor as light needs; the same without friction.
ROTORS = {"heavy": ({}, 1.32), "light": (LIGHT, 0.05), "bare": (LIGHT, 0.0)}


def given(name, otherwise):
    text = os.environ.get(name) or str(otherwise)
    if not text.isdigit():
        sys.exit(f"{name}={text} is no whole number")
    return int(text)


NOISE = given("LAGLESS_SEED", 0)
DAY = given("LAGLESS_GRID_SEED", f"{datetime.datetime.now(datetime.timezone.utc):%Y%m%d}")
SHARE = max(1, given("LAGLESS_GRID_SHARE", 10))

SENSORS = "plant.current_offset_a = 0.03", "plant.current_offset_c = -0.03", "plant.current_gain_error_b = 0.002"
SHORT = re.compile(r"^(?:at (?P<time>[^:]+): (?P<rows>.+)|expect (?P<signal>\w+) (?P<statistic>\w+)(?: from (?P<begin>\S+))?"
                   r"(?: to (?P<end>\S+))?(?: >= (?P<least>.+?))?(?: <= (?P<most>.+))?)$", re.M)


def read(text):
    """(name, axes, names, scenario) of each grid; axes as (names, values), names as (name, expression)."""
    for part in re.split(r"^grid ", re.sub(r"\n +", " ", text), flags=re.M)[1:]:
        title, *lines = part.splitlines()
        axes, names, scenario = [], [], []
        for line in lines:
            axis, name = re.fullmatch(r"each (.+?) in (.+)", line), re.fullmatch(r"let (\w+) = (.+)", line)
            if axis:
                axes.append((axis[1].split(", "), list(eval(axis[2], {"math": math}))))  # a file of this project's
            elif name:
                names.append(name.groups())
            else:
                scenario.append(line)
        yield title, axes, names, "\n".join(scenario)


def points(title, axes):
    """Of the product those that run, each with its noise."""
    product = list(itertools.product(*(values for _, values in axes)))
    draws = [random.Random(f"{DAY} {title} {n}") for n in range(len(product))]
    lots = [dice.random() for dice in draws]
    for n, values in enumerate(product):
        if lots[n] < 1 / SHARE or (lots[n] == min(lots) and min(lots) >= 1 / SHARE):
            place = {}
            for (names, _), value in zip(axes, values):
                place.update(zip(names, value if len(names) > 1 else (value,)))
            yield place, draws[n]


def desk(space, shaft, seconds, rpm=0, degrees=0, paper=False, **rows):
    """Runs until so many seconds after `on`; rows as params_NAME or plant_NAME, None: by rule. A rotor that turns has its friction from
    `on` on, so that it keeps its speed."""
    changes, friction = ROTORS[shaft]
    values = {**(PAPER if paper else {}), **changes, "plant.friction_coulomb": 0 if rpm else friction,
              **{name.replace("_", ".", 1): value for name, value in rows.items()},
              "run.duration": space["on"] + seconds, "run.seed": space["seed"], "start.speed": f"{rpm} r/min", "start.angle": f"{degrees} deg"}
    text = []
    for section in ("run", "start", "params", "plant"):
        text.append(f"[{section}]")
        text += [f"{row.split('.')[1]} = {json.dumps(value)}" for row, value in values.items()
                 if row.startswith(section) and value is not None]
    text += ["[[at]]", "time = 0.06", *SENSORS]
    if rpm:
        text += ["[[at]]", f"time = {space['on']}", f"plant.friction_coulomb = {friction}"]
    return "\n".join(text)


def written(title, place, names, scenario, dice):
    run = NOISE * MEMBERS + dice.randrange(MEMBERS)
    space = {"math": math, "draw": dice.uniform, "desk": lambda *a, **k: desk(space, *a, **k), "seed": 1 + 1000 * run,
             "on": 0.06 + run % PHASES * PERIOD, **place}
    for name, expression in names:
        space[name] = eval(expression, space)

    def whole(line):
        if line["time"]:
            return "\n".join(["[[at]]", f"time = {eval(line['time'], space)}", *line["rows"].split(", ")])
        limits = [f"{key} = {eval(line[group], space)}" for key, group in (("from", "begin"), ("to", "end")) if line[group]]
        limits += [f"{key} = {line[group]}" for key, group in (("at_least", "least"), ("at_most", "most")) if line[group]]
        return "\n".join(["[[expect]]", f'signal = "{line["signal"]}"', f'statistic = "{line["statistic"]}"', *limits])

    body = SHORT.sub(whole, re.sub(r"\{([^}]*)\}", lambda found: str(eval(found[1], space)), scenario))
    where = re.sub(r'["\s]+', " ", ", ".join(f"{name} {value}" for name, value in place.items()))[:150]
    return f'schema = 1\ntitle = "{title}: {where}"\n{body}\n'


def main(runner, folder, source):
    print(f"LAGLESS_SEED={NOISE} LAGLESS_GRID_SEED={DAY} LAGLESS_GRID_SHARE={SHARE}")
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    failed = count = 0
    for title, axes, names, scenario in read(pathlib.Path(source).read_text(encoding="utf-8")):
        for place, dice in points(title, axes):
            count += 1
            file = folder / f"{pathlib.Path(source).stem}_{count}.toml"
            file.write_text(written(title, place, names, scenario, dice), encoding="utf-8")
            done = subprocess.run([runner, file], capture_output=True, text=True, check=False)
            print(done.stdout + done.stderr, end="")
            if done.returncode != 0:
                failed += 1
                print(f"FAILED: {file} is kept")
            else:
                file.unlink()
    print(f"{count} runs, {failed} failed")
    return 1 if failed or not count else 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        print(__doc__)
        sys.exit(2)
    sys.exit(main(*sys.argv[1:]))
