"""A campaign finds a bug that was planted: one sign of catch turned. usage: test_planted.py LAGLESS PLANTED FOLDER

It must break a promise within 60 runs of one seed, 120 of another, or 200 of a third, and the small scenario that is written must break it with the
planted program and hold with the right one: then it is about that sign and nothing else."""

import glob
import os
import shutil
import subprocess
import sys
import tomllib

CAMPAIGNS = (("60", "5"), ("120", "4"), ("200", "2"))  # runs, seed
EVENTS_MOST = 3  # switched on, asked for a speed, and one more
ROWS_MOST = 40   # set in a scenario that was made small


def rows(scenario):
    return sum(len(scenario.get(table, {})) for table in ("params", "plant", "rig", "requests"))


def found_by(lagless, planted, folder, runs, seed):
    """The scenarios that tell the planted program from the right one: events, rows, path."""
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([planted, "campaign", "--runs", runs, "--seed", seed, "--out", folder])
    found = []
    for path in sorted(glob.glob(os.path.join(folder, "run-*.toml"))):
        wrong, right = (subprocess.run([program, "run", "-q", path], capture_output=True).returncode for program in (planted, lagless))
        assert wrong == 1, f"{path} does not reproduce what it is about: exit code {wrong}"
        if right == 0:
            with open(path, "rb") as file:
                scenario = tomllib.load(file)
            found.append((len(scenario.get("at", [])), rows(scenario), path))
    return found


def main(lagless, planted, folder):
    found = next(filter(None, (found_by(lagless, planted, folder, *campaign) for campaign in CAMPAIGNS)), None)
    assert found, "no scenario tells the planted program from the right one"
    events, most, path = min(found)
    print(f"{len(found)} scenarios are about the planted bug; the smallest, {path}: {events} events, {most} rows")
    assert events <= EVENTS_MOST and most <= ROWS_MOST, "it was not made small"


main(*sys.argv[1:])
