#!/usr/bin/env python3
"""Draws the recording of `lagless demo`: speed, currents, torque, angle error, and the phase currents of the last 40 ms.

usage: demo.py CSV PNG [--title TEXT]     writes PNG, and beside it the same picture as SVG

CSV: first line `name[unit],...`, then numbers. Columns in any order; unknown ones are ignored.
  needed    time[s] speed_ref[r/min] speed[r/min] i_d[A] i_q[A] i_a[A] theta_err[mrad]
  drawn     i_d_ref[A] i_q_ref[A] i_b[A] i_c[A] torque[N m] load_torque[N m] duty_a[-] duty_b[-] duty_c[-]
  if there
Ends with 0 done, 2 wrong use or input, 3 matplotlib missing or picture cannot be written. Python 3.9 and matplotlib.
"""
import argparse
import pathlib
import sys
import textwrap

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # which python -I leaves out
import style
from style import BLACK, BLUE, GREEN, ORANGE, PURPLE, outline
from table import InputError, number, rows

NEEDED = {"time": "s", "speed_ref": "r/min", "speed": "r/min", "i_d": "A", "i_q": "A", "i_a": "A", "theta_err": "mrad"}
OPTIONAL = {"i_d_ref": "A", "i_q_ref": "A", "i_b": "A", "i_c": "A", "torque": "N m", "load_torque": "N m",
            "duty_a": "-", "duty_b": "-", "duty_c": "-"}
ZOOM = 0.040  # [s]


def read_recording(path):
    """Columns by name, as lists of numbers; every problem is an InputError that names file and line."""
    lines = rows(path)
    units = next(lines)
    for name, unit in {**NEEDED, **OPTIONAL}.items():
        if name in units and units[name] != unit:
            raise InputError(f"{path}:1: column `{name}`: expected {name}[{unit}]")
    missing = [f"{name}[{unit}]" for name, unit in NEEDED.items() if name not in units]
    if missing:
        raise InputError(f"{path}:1: missing: {', '.join(missing)}")
    columns = {name: [] for name in units}
    for line, cells in lines:
        for name, cell in zip(units, cells):
            columns[name].append(number(path, line, name, cell))
    time = columns["time"]
    if len(time) < 2:
        raise InputError(f"{path}: {len(time)} rows; a picture needs two or more")
    if any(not later > earlier for earlier, later in zip(time, time[1:])):
        raise InputError(f"{path}: time does not increase from row to row")
    return columns


def draw(data, title, png):
    try:
        pyplot = style.pyplot()
    except ImportError:
        print(f"demo.py: {style.MISSING}", file=sys.stderr)
        return 3

    time = data["time"]
    has_torque = "torque" in data or "load_torque" in data
    has_duty = any(f"duty_{leg}" in data for leg in "abc")
    panels = ["speed", "current"] + (["torque"] if has_torque else []) + ["angle"]
    zooms = ["phase"] + (["duty"] if has_duty else [])

    # Rows of fixed height in inches, so that labels have the same room however many panels there are.
    rows = panels + [None] + zooms
    heights = [{"speed": 1.9, None: 0.45}.get(name, 1.5) for name in rows]
    title = textwrap.fill(title, 92)
    above, below, between = 0.3 + 0.18 * (title.count("\n") + 1), 0.55, 0.14
    height = sum(heights) + between * (len(rows) - 1) + above + below
    figure = pyplot.figure(figsize=(9.0, height), dpi=200)
    grid = figure.add_gridspec(len(rows), 1, height_ratios=heights, left=0.095, right=0.865, bottom=below / height,
                               top=1.0 - above / height, hspace=between * len(rows) / sum(heights))
    axes = {}
    for row, name in enumerate(rows):
        if name:
            first = axes.get(panels[0] if name in panels else zooms[0])
            axes[name] = figure.add_subplot(grid[row], sharex=first)
            axes[name].tick_params(labelbottom=name in (panels[-1], zooms[-1]))

    def line(panel, name, colour, label, **look):
        if name in data:
            axes[panel].plot(*outline(time, data[name]), color=colour, label=label, **look)

    line("speed", "speed", BLUE, "speed")
    line("speed", "speed_ref", BLACK, "reference", **style.WANTED)
    axes["speed"].set_ylabel("speed [r/min]")
    line("current", "i_q", BLUE, "$i_q$")
    line("current", "i_d", ORANGE, "$i_d$")
    line("current", "i_q_ref", BLACK, "references", **style.WANTED)
    line("current", "i_d_ref", BLACK, "_" if "i_q_ref" in data else "reference", **style.WANTED)
    axes["current"].set_ylabel("current [A]")
    if has_torque:
        line("torque", "torque", GREEN, "motor")
        line("torque", "load_torque", BLACK, "load", **style.WANTED)
        axes["torque"].set_ylabel("torque [N m]")
    line("angle", "theta_err", PURPLE, "used - true")
    axes["angle"].set_ylabel("angle error\n[mrad, electrical]")
    axes[panels[-1]].set_xlabel("time [s]")
    axes[panels[0]].set_xlim(time[0], time[-1])

    begin = next(i for i, t in enumerate(time) if t >= time[-1] - ZOOM)
    last = [1000.0 * (t - time[-1]) for t in time[begin:]]
    for leg, colour in zip("abc", (BLUE, ORANGE, GREEN)):
        for panel, name, label in (("phase", f"i_{leg}", f"$i_{leg}$"), ("duty", f"duty_{leg}", f"leg {leg}")):
            if name in data:
                axes[panel].plot(last, data[name][begin:], color=colour, label=label)
    axes["phase"].set_ylabel("phase\ncurrent [A]")
    if has_duty:
        axes["duty"].set_ylabel("duty [-]")
    axes[zooms[-1]].set_xlabel(f"last {round(-last[0])} ms: time before the end at {time[-1]:.4g} s [ms]")
    if last[0] < last[-1]:
        axes["phase"].set_xlim(last[0], last[-1])

    for axis in axes.values():
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.04), handlelength=1.6, borderaxespad=0.3)
    figure.align_ylabels(list(axes.values()))
    figure.suptitle(title, fontsize=10.5, x=0.48, y=1.0 - 0.12 / height, va="top", parse_math=False)
    try:
        style.save(figure, png)
    except OSError as error:
        print(f"demo.py: {error}", file=sys.stderr)
        return 3
    return 0


def main():
    parser = argparse.ArgumentParser(description="Draws the recording of `lagless demo`.")
    parser.add_argument("csv", type=pathlib.Path)
    parser.add_argument("png", type=pathlib.Path)
    parser.add_argument("--title", default="", help="conditions of the run, above the picture")
    options = parser.parse_args()
    if options.png.suffix != ".png":
        parser.error(f"{options.png}: the picture's name must end in .png")
    try:
        data = read_recording(options.csv)
    except InputError as error:
        print(f"demo.py: {error}", file=sys.stderr)
        return 2
    return draw(data, options.title, options.png)


if __name__ == "__main__":
    sys.exit(main())
