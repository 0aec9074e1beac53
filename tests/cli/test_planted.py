"""A campaign finds a planted defect: one sign of the catch is inverted.

usage: test_planted.py LAGLESS PLANTED FOLDER

The planted program must violate an invariant within 60 runs of one seed, or 120, 60 or 200 of three others. The minimised scenario
that the campaign writes must fail with the planted program and pass with the right one, which shows that it depends on that sign alone.
The runs are made in twelfths until such a scenario exists, because minimising the other violations takes most of the time."""

import glob
import itertools
import os
import shutil
import subprocess
import sys
import tomllib

CAMPAIGNS = (("60", "7"), ("120", "4"), ("60", "5"), ("200", "2"))  # runs, seed
EVENTS_MOST = 3  # turning on, a requested speed, and one more event
ROWS_MOST = 40   # settings of a minimised scenario
SHARDS = 12


def rows(scenario):
    return sum(len(scenario.get(table, {})) for table in ("params", "plant", "rig", "requests"))


def found_by(lagless, planted, folder, runs, seed, shard):
    """The scenarios whose results differ between the program with the planted defect and the right one, as (events, settings, path)."""
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([planted, "campaign", "--runs", runs, "--seed", seed, "--shard", f"{shard}/{SHARDS}", "--out", folder])
    for path in sorted(glob.glob(os.path.join(folder, "run-*.toml"))):
        wrong, right = (subprocess.run([program, "run", "-q", path], capture_output=True).returncode for program in (planted, lagless))
        assert wrong == 1, f"{path} does not reproduce what it is about: exit code {wrong}"
        if right == 0:
            with open(path, "rb") as file:
                scenario = tomllib.load(file)
            yield len(scenario.get("at", [])), rows(scenario), path


def main(lagless, planted, folder):
    found = []
    for (runs, seed), shard in itertools.product(CAMPAIGNS, range(1, SHARDS + 1)):
        found += found_by(lagless, planted, folder, runs, seed, shard)
        events, most, path = min(found, default=(EVENTS_MOST + 1, 0, ""))
        if events <= EVENTS_MOST and most <= ROWS_MOST:
            print(f"{len(found)} scenarios depend on the planted defect; the smallest, {path}: {events} events, {most} rows")
            return
    assert found, "no scenario distinguishes the planted program from the correct one"
    sys.exit(f"none was minimised: {found}")


main(*sys.argv[1:])
