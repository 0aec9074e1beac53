"""A campaign finds a bug that was planted: one sign of catch turned. usage: test_planted.py LAGLESS PLANTED FOLDER

Within 200 runs it must break a promise, and the small scenario that is written must break it with the planted
program and hold with the right one: then it is about that sign and nothing else."""

import glob
import os
import shutil
import subprocess
import sys
import tomllib

RUNS = "200"
EVENTS_MOST = 3  # switched on, asked for a speed, and one more
ROWS_MOST = 40   # set in a scenario that was made small


def rows(scenario):
    return sum(len(scenario.get(table, {})) for table in ("params", "plant", "rig", "requests"))


def main(lagless, planted, folder):
    shutil.rmtree(folder, ignore_errors=True)
    done = subprocess.run([planted, "campaign", "--runs", RUNS, "--seed", "2", "--out", folder])
    assert done.returncode == 1, f"the campaign should have found the bug, exit code {done.returncode}"
    found = []
    for path in sorted(glob.glob(os.path.join(folder, "run-*.toml"))):
        wrong = subprocess.run([planted, "run", "-q", path], capture_output=True).returncode
        right = subprocess.run([lagless, "run", "-q", path], capture_output=True).returncode
        assert wrong == 1, f"{path} does not reproduce what it is about: exit code {wrong}"
        if right == 0:
            with open(path, "rb") as file:
                scenario = tomllib.load(file)
            found.append((len(scenario.get("at", [])), rows(scenario), path))
    assert found, "no scenario tells the planted program from the right one"
    events, most, path = min(found)
    print(f"{len(found)} scenarios are about the planted bug; the smallest, {path}: {events} events, {most} rows")
    assert events <= EVENTS_MOST and most <= ROWS_MOST, "it was not made small"


main(*sys.argv[1:])
