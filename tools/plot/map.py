#!/usr/bin/env python3
"""Draws the error map of `lagless map`: one field for each point, with mean and standard deviation of the angle's error.

usage: map.py JSON PNG [--title TEXT]     writes PNG, and beside it the same picture as SVG

JSON: a list of points, objects with
  needed    rpm load_nm deviation adaptation mean_mrad sd_mrad peak_mrad locked
  drawn     theory_mrad (or null): what theory predicts for the mean, if available. Rows are the deviations in the order of the list,
  columns the speeds; blocks of the loads are side by side, those of the adaptation below each other. A field is darker the larger the
  magnitude of the mean is, on a logarithmic scale; it also contains the
numbers. A point that is not locked is hatched instead.
Ends with 0 done, 2 wrong use or input, 3 matplotlib missing or picture cannot be written. Python 3.9 and matplotlib.
"""
import argparse
import itertools
import json
import math
import pathlib
import sys
import textwrap

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # python -I does not add this folder to the path
import style
from table import InputError

NUMBERS = ("rpm", "load_nm", "mean_mrad", "sd_mrad", "peak_mrad")
FRAMED = {"axes.grid": False, "axes.spines.top": True, "axes.spines.right": True, "hatch.linewidth": 0.6}
THEORY_SHOWN = 0.5  # [mrad] a deviation whose predicted means are all smaller has no predictions in the picture
LEAST, MOST = 0.3, 100.0  # [mrad] ends of the scale; smaller and larger values have the colours of the ends


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def read_points(path):
    """The points of the list; every problem is an InputError that names file and point."""
    try:
        with open(path, encoding="utf-8") as file:
            points = json.load(file)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}") from None
    if not isinstance(points, list) or not points:
        raise InputError(f"{path}: a list of points is expected")
    seen = set()
    for number, point in enumerate(points, 1):
        where = f"{path}: point {number}"
        if not isinstance(point, dict):
            raise InputError(f"{where}: an object is expected")
        for key in NUMBERS:
            if not is_number(point.get(key)):
                raise InputError(f"{where}: {key}: `{point.get(key)}` is not a finite number")
        if not isinstance(point.get("locked"), bool):
            raise InputError(f"{where}: locked: `{point.get('locked')}` is neither true nor false")
        for key in ("deviation", "adaptation"):
            if not isinstance(point.get(key), str):
                raise InputError(f"{where}: {key}: `{point.get(key)}` is no text")
        if point.get("theory_mrad") is not None and not is_number(point["theory_mrad"]):
            raise InputError(f"{where}: theory_mrad: `{point['theory_mrad']}` is not a finite number")
        place = (point["deviation"], point["load_nm"], point["rpm"], point["adaptation"])
        if place in seen:
            raise InputError(f"{where}: {place[0]} at {place[2]:g} r/min, {place[1]:g} N m, adaptation {place[3]} occurs twice")
        seen.add(place)
    return points


def digits(value):
    """Three significant digits, and a minus sign with the width of a plus sign."""
    size = abs(value)
    text = f"{value:.{2 if size < 9.995 else 1 if size < 99.95 else 0}f}"
    return label(text.replace("-0.00", "0.00"))


def label(text):
    return text.replace("psi_f", "$\\psi_f$").replace("-", "\N{MINUS SIGN}")


def shade(mean):
    """0 white .. 1 darkest: logarithm of the magnitude between both ends of the scale."""
    size = min(max(abs(mean), LEAST), MOST)
    return math.log(size / LEAST) / math.log(MOST / LEAST)


def ink(red, green, blue):
    """Black or white, whichever contrasts more (WCAG relative luminance: as far from 1 as from 0 at 0.18)."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)]
    return "#000000" if 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] > 0.18 else "#FFFFFF"


def draw(points, title, png):
    try:
        pyplot = style.pyplot(**FRAMED)
    except ImportError:
        print(f"map.py: {style.MISSING}", file=sys.stderr)
        return 3
    from matplotlib import cm, colors, ticker

    rows = list(dict.fromkeys(point["deviation"] for point in points))
    loads = sorted({point["load_nm"] for point in points})
    speeds = sorted({point["rpm"] for point in points})
    columns = list(dict.fromkeys(point["adaptation"] for point in points))
    has_theory = {point["deviation"] for point in points if abs(point.get("theory_mrad") or 0.0) >= THEORY_SHOWN}

    # Fields have a fixed size in inches, so that the space for their text is always the same.
    wide, names, bar, margin, block_gap, row_gap = 0.62, 0.2 + 0.068 * max(map(len, rows)), 0.75, 0.12, 0.16, 0.5
    heights = [0.55 if row in has_theory else 0.40 for row in rows]
    tops = [sum(heights[:n]) for n in range(len(rows) + 1)]
    titles = {(on, load): f"{'no load' if load == 0 else f'{load:.4g} N m'}, adaptation {on}: speed [r/min]"
              for on in columns for load in loads}
    block = max(wide * len(speeds), 0.066 * max(map(len, titles.values())))
    width = max(names + len(loads) * block + (len(loads) - 1) * block_gap + bar + margin, 7.0)  # space for the caption
    title = textwrap.fill(title, int(11 * width))
    above, below = 0.50 + 0.19 * (title.count("\n") + 1), 0.72
    height = above + len(columns) * tops[-1] + (len(columns) - 1) * row_gap + below
    figure = pyplot.figure(figsize=(width, height), dpi=200)
    colour = colors.LinearSegmentedColormap.from_list("map", ["#FFFFFF", "#9EC3E6", "#0B3C6F"])

    axes = {}
    for (m, on), (n, load) in itertools.product(enumerate(reversed(columns)), enumerate(loads)):
        lower = below + m * (tops[-1] + row_gap)
        axis = figure.add_axes([(names + n * (block + block_gap)) / width, lower / height, block / width, tops[-1] / height])
        axis.set(xlim=(0, len(speeds)), ylim=(tops[-1], 0.0))
        axis.set_xticks([c + 0.5 for c in range(len(speeds))], [label(f"{speed:g}") for speed in speeds])
        axis.set_yticks([(upper + lower) / 2 for upper, lower in zip(tops, tops[1:])], [label(row) for row in rows])
        axis.tick_params(length=0, labeltop=True, labelbottom=False, labelleft=n == 0)
        axis.set_title(titles[on, load], fontsize=9, pad=8)
        axes[on, load] = axis

    for point in points:
        axis = axes[point["adaptation"], point["load_nm"]]
        column, row = speeds.index(point["rpm"]), rows.index(point["deviation"])
        field = colour(shade(point["mean_mrad"]) if point["locked"] else 0.0)
        axis.add_patch(pyplot.Rectangle((column, tops[row]), 1, heights[row], facecolor=field, edgecolor="#FFFFFF",
                                        linewidth=0.8))
        if not point["locked"]:
            axis.add_patch(pyplot.Rectangle((column, tops[row]), 1, heights[row], fill=False, edgecolor="#777777",
                                            hatch="////", linewidth=0.0))
        behind = {} if point["locked"] else {"bbox": {"facecolor": field, "edgecolor": "none", "pad": 1.0}}
        lines = [(0.14, digits(point["mean_mrad"]), 8.5), (0.29, f"\N{PLUS-MINUS SIGN} {digits(point['sd_mrad'])}", 6.5)]
        if point["deviation"] in has_theory and point.get("theory_mrad") is not None:
            lines.append((0.43, f"theory {digits(point['theory_mrad'])}", 6))
        for down, text, size in lines:
            axis.text(column + 0.5, tops[row] + down, text, ha="center", va="center", fontsize=size, color=ink(*field[:3]),
                      **behind)
    for axis in axes.values():
        if 0 < sum(speed < 0 for speed in speeds) < len(speeds):
            axis.axvline(sum(speed < 0 for speed in speeds), color="#000000", linewidth=1.0)
        for side in axis.spines.values():
            side.set_linewidth(0.6)

    scale = cm.ScalarMappable(colors.LogNorm(LEAST, MOST), colour)
    place = figure.add_axes([1.0 - (bar - 0.12) / width, below / height, 0.14 / width,
                             (height - above - below) / height])
    legend = figure.colorbar(scale, cax=place, extend="both", extendfrac=0.02)
    legend.set_ticks([0.3, 1, 3, 10, 30, 100])
    legend.ax.yaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    legend.ax.yaxis.set_minor_locator(ticker.NullLocator())
    legend.set_label("|mean| [mrad]", fontsize=8)
    legend.ax.tick_params(labelsize=8)

    figure.text(names / width, 0.52 / height,
                "estimated minus true angle [mrad, electrical]: mean \N{PLUS-MINUS SIGN} standard deviation", fontsize=8,
                va="center")
    patch = figure.add_axes([names / width, 0.16 / height, 0.32 / width, 0.18 / height])
    patch.add_patch(pyplot.Rectangle((0, 0), 1, 1, facecolor="#FFFFFF", edgecolor="#777777", hatch="////", linewidth=0.6))
    patch.set_axis_off()
    figure.text((names + 0.42) / width, 0.25 / height, "not locked", fontsize=8, va="center")
    figure.suptitle(title, fontsize=10.5, x=0.5, y=1.0 - 0.1 / height, va="top", parse_math=False)
    try:
        style.save(figure, png)
    except OSError as error:
        print(f"map.py: {error}", file=sys.stderr)
        return 3
    return 0


def main():
    parser = argparse.ArgumentParser(description="Draws the error map of `lagless map`.")
    parser.add_argument("json", type=pathlib.Path)
    parser.add_argument("png", type=pathlib.Path)
    parser.add_argument("--title", default="", help="conditions of the map, above the picture")
    options = parser.parse_args()
    if options.png.suffix != ".png":
        parser.error(f"{options.png}: the picture's name must end in .png")
    try:
        points = read_points(options.json)
    except InputError as error:
        print(f"map.py: {error}", file=sys.stderr)
        return 2
    return draw(points, options.title, options.png)


if __name__ == "__main__":
    sys.exit(main())
