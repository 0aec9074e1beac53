#!/usr/bin/env python3
"""A tenth of the error map, selected by the seed of the day: one of its speeds, in both directions, without or with learning. Its points
must agree with docs/accuracy.md to the last digit, and the claims of theory must hold for them.

usage: map_of_the_day.py LAGLESS ACCURACY [SPEED COLUMN]

The seed is LAGLESS_GRID_SEED, or the date (UTC) as YYYYMMDD. SPEED [r/min] and COLUMN, off or on, replace the random choice. Exit codes:
0 if all points agree, 1 if a number differs or a claim does not hold. Python 3.9, standard library.
"""
import json
import os
import pathlib
import random
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/plot"))
import documents  # noqa: E402

ARROW = " \N{RIGHTWARDS ARROW} "


def table(text):
    """{(deviation, speed [r/min]): {"off": cell, "on": cell}}, and the largest load [N m]."""
    lines = text.partition(documents.BEGIN_MAP)[2].partition(documents.END)[0].splitlines()
    split = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    speeds = [float(cell.split()[0]) for cell in split[0][1:]]
    cells = {(row[0], speed): dict(zip(("off", "on"), cell.split(ARROW)))
             for row in split[2:] for speed, cell in zip(speeds, row[1:])}
    return cells, float(split[0][0].split()[0])


def printed(number):
    """The number with the digits of the report's file, from which the document is made."""
    return f"{number:.5g}"


def main(lagless, accuracy, *drawn):
    cells, load = table(pathlib.Path(accuracy).read_text(encoding="utf-8"))
    seed = os.environ.get("LAGLESS_GRID_SEED") or time.strftime("%Y%m%d", time.gmtime())
    draw = random.Random(f"map {seed}")
    speed = draw.choice(sorted({speed for _, speed in cells}))
    column = draw.choice(("off", "on"))
    if drawn:
        speed, column = float(drawn[0]), drawn[1]
    print(f"LAGLESS_GRID_SEED={seed}: {speed:g} r/min, adaptation {column}")
    done = subprocess.run([lagless, "map", "--json", "--speeds", f"{speed:g}", "--adaptation", column], stdout=subprocess.PIPE, text=True,
                          check=False)
    rows = [{"deviation": point["deviation"], "adaptation": point["adaptation"], "load": point["load_nm"], "speed": point["rpm"],
             "mean": printed(point.get("mean_mrad", 0.0)), "sd": printed(point.get("sd_mrad", 0.0)), "lost": not point["locked"]}
            for point in json.loads(done.stdout)]
    wrong = done.returncode
    if wrong:
        print(f"`lagless map` ended with {wrong}: a claim of theory does not hold; `{lagless} map --speeds {speed:g} "
              f"--adaptation {column}` names it")
    for deviation in sorted({deviation for deviation, _ in cells}):
        ours = documents.map_cell([row for row in rows if row["deviation"] == deviation], load, speed, column)
        theirs = cells[deviation, speed][column]
        if ours != theirs:
            print(f"{accuracy}: {deviation}, {speed:g} r/min, adaptation {column}: {theirs} there, {ours} here; if that is meant: "
                  "tools/demo, then tools/plot/documents.py report docs")
            wrong = 1
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) not in (3, 5):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
