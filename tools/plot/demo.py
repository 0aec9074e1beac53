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
import csv
import math
import pathlib
import sys
import textwrap

NEEDED = {"time": "s", "speed_ref": "r/min", "speed": "r/min", "i_d": "A", "i_q": "A", "i_a": "A", "theta_err": "mrad"}
OPTIONAL = {"i_d_ref": "A", "i_q_ref": "A", "i_b": "A", "i_c": "A", "torque": "N m", "load_torque": "N m",
            "duty_a": "-", "duty_b": "-", "duty_c": "-"}
ZOOM = 0.040  # [s]

# Okabe and Ito's palette: distinguishable with any colour vision, and by lightness in print.
BLUE, ORANGE, GREEN, PURPLE, BLACK = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000"


class InputError(Exception):
    pass


def read_recording(path):
    """Columns by name, as lists of numbers; every problem is an InputError that names file and line."""
    units = {**NEEDED, **OPTIONAL}
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = csv.reader(file)
            header = next(rows, None)
            if header is None:
                raise InputError(f"{path}: empty")
            names = []
            for cell in header:
                name, _, unit = cell.strip().partition("[")
                unit = unit[:-1] if unit.endswith("]") else None
                if name in units and unit != units[name]:
                    raise InputError(f"{path}:1: column `{cell.strip()}`: expected {name}[{units[name]}]")
                if name in names:
                    raise InputError(f"{path}:1: column `{name}` is there twice")
                names.append(name)
            missing = [f"{name}[{unit}]" for name, unit in NEEDED.items() if name not in names]
            if missing:
                raise InputError(f"{path}:1: missing: {', '.join(missing)}")
            columns = {name: [] for name in names}
            for cells in rows:
                if not cells:
                    continue
                if len(cells) != len(names):
                    raise InputError(f"{path}:{rows.line_num}: {len(cells)} values, but {len(names)} columns")
                for name, cell in zip(names, cells):
                    try:
                        value = float(cell)
                    except ValueError:
                        value = math.nan
                    if not math.isfinite(value):
                        raise InputError(f"{path}:{rows.line_num}: {name}: `{cell}` is no finite number")
                    columns[name].append(value)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: {error}") from None
    time = columns["time"]
    if len(time) < 2:
        raise InputError(f"{path}: {len(time)} rows; a picture needs two or more")
    if any(not later > earlier for earlier, later in zip(time, time[1:])):
        raise InputError(f"{path}: time does not increase from row to row")
    return columns


def outline(time, values, most=4000):
    """The same curve with fewer points: least and largest of each stretch, so that no peak is lost."""
    count = len(time)
    if count <= most:
        return time, values
    kept = {0, count - 1}
    stretch = math.ceil(2 * count / most)
    for begin in range(0, count, stretch):
        indices = range(begin, min(begin + stretch, count))
        kept.add(min(indices, key=values.__getitem__))
        kept.add(max(indices, key=values.__getitem__))
    order = sorted(kept)
    return [time[i] for i in order], [values[i] for i in order]


def draw(data, title, png):
    try:
        import matplotlib
    except ImportError:
        print("demo.py: matplotlib is missing: run tools/setup demo, or install python3-matplotlib", file=sys.stderr)
        return 3
    matplotlib.use("Agg")
    matplotlib.rcParams.update({
        "font.size": 9, "axes.grid": True, "grid.color": "#DDDDDD", "grid.linewidth": 0.6, "axes.axisbelow": True,
        "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.8, "lines.linewidth": 1.1,
        "legend.frameon": False, "svg.hashsalt": "lagless", "svg.fonttype": "path",
    })
    from matplotlib import pyplot

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

    def line(panel, name, colour, label, **style):
        if name in data:
            axes[panel].plot(*outline(time, data[name]), color=colour, label=label, **style)

    wanted = {"linestyle": (0, (4, 2)), "linewidth": 1.2, "zorder": 3}
    line("speed", "speed", BLUE, "speed")
    line("speed", "speed_ref", BLACK, "reference", **wanted)
    axes["speed"].set_ylabel("speed [r/min]")
    line("current", "i_q", BLUE, "$i_q$")
    line("current", "i_d", ORANGE, "$i_d$")
    line("current", "i_q_ref", BLACK, "references", **wanted)
    line("current", "i_d_ref", BLACK, "_" if "i_q_ref" in data else "reference", **wanted)
    axes["current"].set_ylabel("current [A]")
    if has_torque:
        line("torque", "torque", GREEN, "motor")
        line("torque", "load_torque", BLACK, "load", **wanted)
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
        png.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(png, metadata={"Software": None})
        figure.savefig(png.with_suffix(".svg"), metadata={"Date": None})
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
