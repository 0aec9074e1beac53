#!/usr/bin/env python3
"""Draws the result of `lagless commission`: the measured points of each step, and the values that follow from them.

usage: commission.py --out FOLDER --format html,png,svg     reads the result as JSON from stdin, writes FOLDER/commission.KIND

JSON: an object with
  of             name of the drive or of the scenario
  plate          pole_pairs, current [A], speed [rad/s]
  sheet          values of the plate's file, or null
  step_seconds   duration of each step
  step, what     the last step, and what ended it ("": commissioned)
  result         the object of `lagless commission --json`
Ends with 0 done, 2 wrong use or input, 3 matplotlib missing or a file cannot be written. Python 3.9, numpy and matplotlib.
"""
import argparse
import io
import json
import math
import pathlib
import string
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # python -I does not add this folder to the path
import style
from table import InputError

NAME = "commission"
RPM = math.pi / 30
# Key of the result: symbol, meaning, unit, factor.
VALUES = {
    "resistance": ("R", "resistance of a phase", "Ω", 1),
    "inductance_d": ("L_d", "inductance along the magnets", "mH", 1e3),
    "inductance_q": ("L_q", "inductance across the magnets, without current", "mH", 1e3),
    "saturation_current": ("I_s", "current at which L_q saturates; 0: none was seen", "A", 1),
    "flux_linkage": ("psi_f", "flux linkage of the magnets", "mWb", 1e3),
    "inertia": ("J", "moment of inertia", "g m²", 1e3),
    "friction_coulomb": ("T_c", "dry friction", "mN m", 1e3),
    "friction_viscous": ("B", "friction in proportion to the speed", "µN m s/rad", 1e6),
    "dead_voltage": ("V", "voltage that a leg loses by its dead time", "V", 1),
    "current_zone": ("z", "half width of the zone in which a leg loses less", "mA", 1e3),
    "angle_d": ("angle", "electrical direction of the d axis of a held rotor", "degrees", 180 / math.pi),
    "loop_gain": ("gain", "gain of the current loop over its design", "", 1),
    "least_speed": ("least speed", "lowest speed without an encoder", "r/min", 1 / RPM),
    "largest_current": ("largest current", "of a phase, in all steps", "A", 1),
}


def line(x, y):
    """Slope and intercept of the least-squares line."""
    import numpy
    slope, intercept = numpy.polyfit(numpy.asarray(x), numpy.asarray(y), 1)
    return float(slope), float(intercept)


def lost_share(current, zone):
    """Share of 4/3 V that is lost at this current along a phase (docs/commissioning.md, Steps)."""
    if current >= 2 * zone:
        return 1.0
    return 1 - (0.5 * (1 - current / (2 * zone)) if current >= zone else 1 - 0.75 * current / zone)


def is_steep(points):
    """The points with at least a third of the largest current, where the legs lose the whole voltage."""
    most = max(x for x, _ in points)
    return [(x, y) for x, y in points if x >= most / 3]


def from_zero(axis, values):
    """The range of the y axis includes zero and, below the largest value, the legend."""
    axis.set_ylim(min(0.0, *values), 1.15 * max(values))
    axis.legend(loc="lower right")


# ---- panels: each draws the points of a step, and returns its title ----

def resistance(axis, points, result):
    steep = is_steep(points)
    slope, intercept = line(*zip(*steep))
    most = max(x for x, _ in points)
    axis.plot(*zip(*points), "o", markersize=4, color=style.BLUE, label="measured")
    axis.plot([0, most], [intercept, intercept + slope * most], color=style.ORANGE, **style.WANTED, label=f"{intercept:.3g} V + {slope:.4g} Ω · i")
    axis.set(xlabel="current along the phase [A]", ylabel="voltage [V]", xlim=0)
    from_zero(axis, [y for _, y in points])
    return "resistance: R from the slope, 4/3 V at zero current"


def dead_time(axis, points, result):
    import numpy
    slope, _ = line(*zip(*is_steep(points)))
    axis.plot([x for x, _ in points], [y - slope * x for x, y in points], "o", markersize=4, color=style.BLUE, label="measured")
    zone, dead = result["current_zone"], result["dead_voltage"]
    if zone and dead:
        currents = numpy.geomspace(0.5 * min(x for x, _ in points if x > 0), max(x for x, _ in points), 400)
        axis.plot(currents, [4 / 3 * dead * lost_share(x, zone) for x in currents], color=style.ORANGE, **style.WANTED, label="with V and z")
    axis.set(xlabel="current along the phase [A]", ylabel="voltage less R i [V]", xscale="log")
    from_zero(axis, [y - slope * x for x, y in points])
    return "resistance: voltage that the legs lose"


def inductance(axis, points, result):
    for name, colour, sign in (("d", style.BLUE, 1), ("q", style.ORANGE, -1)):
        of = [(abs(x), 1e3 * y) for x, y in points if sign * x > 0]
        if of:
            axis.plot(*zip(*of), "o", markersize=4, color=colour, label=f"measured along {name}")
        value = result[f"inductance_{name}"]
        if value:
            axis.axhline(1e3 * value, color=colour, linestyle=(0, (4, 2)), linewidth=1.2, label=f"$L_{name}$ {1e3 * value:.4g} mH")
    axis.set(xlabel="amplitude of the sine [A]", ylabel="inductance [mH]", xlim=0)
    from_zero(axis, [1e3 * y for _, y in points])
    return "inductance: over the amplitude"


def swing(axis, points, result):
    axis.plot([x + 1 for x, _ in points], [1e3 * y for _, y in points], "o", markersize=4, color=style.BLUE, label="measured")
    if result["flux_linkage"]:
        axis.axhline(1e3 * result["flux_linkage"], color=style.ORANGE, **style.WANTED, label="result of the step flux")
    axis.set(xlabel="jump of the current vector [-]", ylabel="$\\psi_f$ [mWb]")
    from_zero(axis, [1e3 * y for _, y in points])
    return "swing: $\\psi_f$ from the circle of each jump"


def flux(axis, points, result):
    axis.plot(*zip(*points), "o", markersize=5, color=style.BLUE, label="measured")
    most = max(x for x, _ in points)
    if result["flux_linkage"]:
        axis.plot([0, most], [0, result["flux_linkage"] * most], color=style.ORANGE, **style.WANTED, label="$\\psi_f\\,\\omega$")
    axis.set(xlabel="electrical speed [rad/s]", ylabel="EMF [V]", xlim=0)
    from_zero(axis, [y for _, y in points])
    return "flux: EMF at a steady speed"


def inertia(axis, points, result):
    axis.plot(*zip(*points), "o", markersize=3, color=style.BLUE, label="measured")
    if result["inertia"]:
        torques = [min(x for x, _ in points), max(x for x, _ in points)]
        offset = sum(y - x / result["inertia"] for x, y in points) / len(points)  # by friction, at the mean speed
        axis.plot(torques, [torque / result["inertia"] + offset for torque in torques], color=style.ORANGE, **style.WANTED, label="slope 1/J")
    axis.set(xlabel="torque of the motor [N m]", ylabel="acceleration [rad/s²]")
    axis.legend(loc="lower right")
    return "inertia: acceleration over torque"


PANELS = (("resistance", resistance, 3), ("resistance", dead_time, 3), ("inductance", inductance, 1), ("swing", swing, 1), ("flux", flux, 1),
          ("inertia", inertia, 2))


# ---- input ----

def read(text):
    try:
        data = json.loads(text)
    except ValueError as error:
        raise InputError(f"stdin: {error}") from None
    for key, kind in (("of", str), ("plate", dict), ("sheet", dict), ("step_seconds", dict), ("step", str), ("what", str), ("result", dict)):
        if not isinstance(data, dict) or not isinstance(data.get(key), kind):
            raise InputError(f"stdin: {key}: expected: the data that `lagless commission --plot` sends")
    missing = [key for key in (*VALUES, "reason", "uncertainty", "points") if key not in data["result"]]
    if missing:
        raise InputError(f"stdin: result: {missing[0]} is missing")
    return data


# ---- output ----

def draw(data):
    """The figure; None if no step has measured points."""
    pyplot = style.pyplot()
    points = data["result"]["points"]
    panels = [(draws, points[step]) for step, draws, least in PANELS if len(points.get(step, [])) >= least]
    if not panels:
        return None
    columns = min(len(panels), 3)
    rows = math.ceil(len(panels) / columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(4.1 * columns, 3.2 * rows), layout="constrained", squeeze=False)
    for axis, (draws, of) in zip(axes.flat, panels):
        axis.set_title(draws(axis, of, data["result"]), fontsize=9.5)
    for axis in axes.flat[len(panels):]:
        axis.set_axis_off()
    return figure


def value_rows(data):
    from page import cell, escape, number
    result, rows = data["result"], []
    for key, (symbol, meaning, unit, factor) in VALUES.items():
        value, error, sheet = result[key], result["uncertainty"].get(key), data["sheet"].get(key)
        if value is None:
            continue
        uncertainty = "" if not error else f"± {number(float(f'{factor * error:.2g}'))}"
        plate = "" if sheet is None else f"{number(factor * sheet)} ({100 * (value / sheet - 1):+.1f} %)".replace("-", "−")
        rows.append(f'<tr><th scope="row">{escape(symbol)}</th>{cell("number", number(factor * value))}{cell("number", uncertainty)}'
                    f'{cell("unit", escape(unit))}{cell("number", plate)}<td>{escape(meaning)}</td></tr>')
    return "".join(rows)


def write_page(path, data, figure):
    import page
    from page import escape, number
    result = data["result"]
    title = f"Commissioning: {data['of']}"
    plate = data["plate"]
    lead = (f"Plate: {plate['pole_pairs']:.0f} pole pairs, {number(plate['current'])} A (peak), {number(plate['speed'] / RPM)} r/min. "
            f"{'Commissioned' if result['reason'] is None else 'Ended'} after {number(round(result['seconds'], 1))} s.")
    alarm = "" if result["reason"] is None else (f'<p class="alarm"><b>{escape(result["reason"])} in the step {escape(data["step"])}</b>: '
                                                 f'{escape(data["what"])}.</p>')
    picture = "<p>No step has measured points.</p>"
    if figure is not None:
        png = io.BytesIO()
        figure.savefig(png, format="png", dpi=160, metadata={"Software": None})
        picture = f'<div class="picture">{page.image(png.getvalue(), "the measured points of each step")}</div>'
    rows = value_rows(data)
    values = ('<div class="wide"><table class="data settings"><thead><tr><th>name</th><th class="number">value</th><th class="number">uncertainty</th>'
              f'<th>unit</th><th class="number">plate</th><th>meaning</th></tr></thead><tbody>{rows}</tbody></table></div>'
              if rows else "<p>No value was measured.</p>")
    steps = "".join(f'<tr><th scope="row">{escape(name)}</th>{page.cell("number", number(round(seconds, 1)))}</tr>'
                    for name, seconds in data["step_seconds"].items() if seconds)
    times = f'<table class="data"><thead><tr><th>step</th><th class="number">s</th></tr></thead><tbody>{steps}</tbody></table>' if steps else ""
    sections = [f'<section id="curves"><h2>Measured points</h2>{picture}</section>', f'<section id="values"><h2>Values</h2>{values}</section>']
    if times:
        sections.append(f'<section id="times"><h2>Duration of the steps</h2>{times}</section>')
    names = {"curves": "Measured points", "values": "Values", "times": "Durations"}
    text = string.Template((page.PARTS / "drive.html").read_text(encoding="utf-8")).substitute(
        title=escape(title), lead=lead, alarms=alarm, how="", licence="", script="", sections="".join(sections),
        links=" ".join(f'<a href="#{name}">{label}</a>' for name, label in names.items() if any(f'id="{name}"' in part for part in sections)),
        style="".join((page.PARTS / name).read_text(encoding="utf-8") for name in ("page.css", "drive.css")))
    return page.replaced(path, text)


def write(data, folder, kinds):
    figure = draw(data)
    if figure is None and kinds != ["html"]:
        print("commission.py: no step has measured points, so that there is no picture", file=sys.stderr)
    folder.mkdir(parents=True, exist_ok=True)
    for kind in kinds:
        path = folder / f"{NAME}.{kind}"
        if kind == "html":
            write_page(path, data, figure)
        elif figure is not None:
            style.save_as(figure, path)
        else:
            continue
        print(f"{'page' if kind == 'html' else 'picture'}: {path}", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description="Draws the result of `lagless commission`.")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--format", type=style.formats, default=["html"])
    options = parser.parse_args()
    try:
        write(read(sys.stdin.read()), options.out, options.format)
    except InputError as error:
        print(f"commission.py: {error}", file=sys.stderr)
        return 2
    except ImportError as error:
        if error.name and error.name.split(".")[0] in ("numpy", "matplotlib"):
            print(f"commission.py: {style.MISSING}", file=sys.stderr)
            return 3
        raise
    except OSError as error:
        print(f"commission.py: {error.filename or 'the output'} cannot be written: {error.strerror or error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
