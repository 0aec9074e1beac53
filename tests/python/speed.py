#!/usr/bin/env python3
"""Compares the speed of the package with that of the program for one scenario. The speed is the simulated time divided by the wall-clock
time of the simulation alone.
The best of several alternating runs counts; both make the recording of the scenario.

usage: PYTHONPATH=host_sim/python LAGLESS_LIBRARY=.../liblagless.so speed.py LAGLESS [SCENARIO [REPEATS]]
"""
import json
import subprocess
import sys
import tempfile

import lagless


def main():
    program, name = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "sensorless_speed_profile"
    theirs, ours = [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(int(sys.argv[3]) if len(sys.argv) > 3 else 10):
            text = subprocess.run([program, "run", name, "--json", "--force", "--out", folder], capture_output=True, check=True).stdout
            theirs.append(json.loads(text)["seconds_per_second"])
            result = lagless.run(name)
            ours.append(result.seconds / result.wall)
    print(f"{name}: program {max(theirs):.1f} x real time, Python {max(ours):.1f} x, {100 * max(ours) / max(theirs):.0f} %")


if __name__ == "__main__":
    main()
