"""The content of the figures of the paper report: their data, and for each figure the layouts of page and pictures.

CSV: first line `name[unit],...`. Cells are numbers, or empty if there is no number (a shorter run, 1/0), or text if the unit is
`text`. Columns of traces are called <run>_<flavour>_<quantity>. Needs numpy.
"""
import dataclasses
import io
import pathlib

import numpy

from style import BLACK, BLUE, GREEN, ORANGE, PURPLE
from table import InputError, number, rows

UNITS = {"time": "s", "speed": "r/min", "speed_hat": "r/min", "speed_err": "r/min", "theta": "rad", "theta_hat": "rad",
         "theta_err": "mrad", "theory_err": "mrad", "i_q": "A", "true_i_d": "A", "k_f_alpha": "1/A", "gain": "dB",
         "phase": "deg"}
CURVES = ((BLUE, "o"), (ORANGE, "s"), (GREEN, "^"), (PURPLE, "D"))  # These curves differ by colour, and in grey prints by their marks.


class Data:
    """The columns of a CSV by name, as numpy arrays of numbers or lists of text. `data[name]` must exist."""

    def __init__(self, path, columns, units):
        self.path, self.columns, self.units = pathlib.Path(path), columns, units

    def __getitem__(self, name):
        if name not in self.columns:
            raise InputError(f"{self.path}: column `{name}` is missing")
        return self.columns[name]

    def need(self, name, unit):
        """The name of the column, if the data has it in this unit; otherwise None."""
        self[name]
        if self.units[name] != unit:
            raise InputError(f"{self.path}:1: column `{name}`: expected {name}[{unit}]")
        return name

    @staticmethod
    def read(path):
        """Reads a CSV. Every problem is an InputError that names file and line. Adds each run's speed_err = speed_hat - speed."""
        lines = rows(path)
        units = next(lines)
        for name, unit in units.items():
            if not unit:
                raise InputError(f"{path}:1: column `{name}`: a unit in brackets is expected")
        columns = None if "text" in units.values() else quick(path, len(units))
        if columns is None:
            columns = {name: [] for name in units}
            for line, cells in lines:
                for name, cell in zip(units, cells):
                    columns[name].append(cell if units[name] == "text" or not cell else number(path, line, name, cell))
            columns = [column if units[name] == "text" else numpy.array([numpy.nan if cell == "" else cell
                                                                         for cell in column])
                       for name, column in columns.items()]
        if not len(columns[0]):
            raise InputError(f"{path}: no rows")
        columns = dict(zip(units, columns))
        if "time" in columns and not (numpy.diff(columns["time"]) > 0.0).all():
            raise InputError(f"{path}: time does not increase from row to row")
        for name in [name for name in columns if name.endswith("_speed_hat")]:
            true = name[:-len("_hat")]
            if true in columns:
                columns[f"{true}_err"], units[f"{true}_err"] = columns[name] - columns[true], units[true]
        return Data(path, columns, units)


def quick(path, count):
    """Columns of a CSV that has only numbers, a few times as fast as line by line; None: the file must be read
    line by line."""
    with open(path, encoding="utf-8") as file:
        text = "\n" + file.read().partition("\n")[2]
    if not text.strip():
        return None
    while ",," in text:
        text = text.replace(",,", ",nan,")
    text = text.replace("\n,", "\nnan,").replace(",\n", ",nan\n")
    try:
        numbers = numpy.loadtxt(io.StringIO(text), delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return None
    return list(numbers.T) if numbers.shape[1] == count and not numpy.isinf(numbers).any() else None


@dataclasses.dataclass
class Trace:
    column: str
    label: str
    colour: str
    dashed: bool = False
    mark: str = ""  # matplotlib's marker, now and then along the curve
    limit: bool = False  # does not determine the axis; it is shown if the limited value is near it
    wraps: float = 0.0  # half the range of an angle: no line from one end to the other; 0: no angle
    names: object = None  # names of the values of a band: {value: name}, or {"bits": [name...]}


@dataclasses.dataclass
class Panel:
    ylabel: str
    traces: list
    kind: str = ""  # "error": the error panel; "bands": a line of named stretches for each trace
    height: float = 1.0
    title: str = ""
    log_y: bool = False
    note: str = ""  # in the panel's upper right corner
    range: object = None  # [least, most] of the axis while all of the time is shown


@dataclasses.dataclass
class Layout:
    id: str
    x: str
    xlabel: str
    panels: list
    log_x: bool = False
    interactive: bool = True
    title: str = ""


class Drawer:
    """Makes traces from the data of one figure, and checks that their columns exist in the unit of their axis."""

    def __init__(self, figure, data):
        self.id, self.data = figure["id"], data
        self.lost = {run["name"] for run in figure.get("runs", []) if run["flavour"] == "real" and run.get("lost")}

    def of(self, run, quantity, label, colour, **look):
        column = self.data.need(f"{run}_real_{quantity}", UNITS[quantity])
        return Trace(column, f"{label}, lost" if run in self.lost else label, colour, **look)

    def reference(self, name="speed_ref"):
        return Trace(self.data.need(name, "r/min"), "reference", BLACK, dashed=True)

    def over_time(self, suffix, panels, title=""):
        return Layout(self.id + suffix, self.data.need("time", "s"), "time [s]", panels, title=title)

    def loops(self, suffix, title, runs, reference="speed_ref", current=False):
        """Runs side by side: [(run, label)]; speed, its error or the current, position error."""
        def every(quantity):
            return [self.of(run, quantity, label, colour, mark=mark) for (run, label),
                    (colour, mark) in zip(runs, CURVES)]

        second = Panel("current i_q [A]", every("i_q")) if current else Panel("speed error [r/min]", every("speed_err"),
                                                                              "error")
        return self.over_time(suffix, [
            Panel("speed [r/min]", every("speed") + [self.reference(reference)]), second,
            Panel("position error [mrad]", every("theta_err"), "error", height=1.3)], title)


def fig04(drawer):
    def pair(unit, sign, sigmoid):
        return [Trace(drawer.data.need(sign, unit), "sign", ORANGE),
                Trace(drawer.data.need(sigmoid, unit), "sigmoid", BLUE)]
    return [Layout("fig04", drawer.data.need("x", "A"), "current error x [A]", [
        Panel("switching function f(x) [-]", pair("-", "sign", "sigmoid")),
        Panel("equivalent gain k_f [1/A]", pair("1/A", "k_f_sign", "k_f_sigmoid"), log_y=True)])]


def fig05(drawer):
    return [drawer.over_time("", [
        Panel("k_f of sign [1/A]", [drawer.of("sign", "k_f_alpha", "sign", ORANGE)], log_y=True),
        Panel("k_f of sigmoid [1/A]", [drawer.of("sigmoid", "k_f_alpha", "sigmoid", BLUE)])])]


def fig08(drawer):
    def panels(bandwidth, cutoffs):
        for quantity, ylabel in (("gain", "gain [dB]"), ("phase", "phase [deg]")):
            yield Panel(ylabel, [Trace(drawer.data.need(f"b{bandwidth}_wc{cutoff}_{quantity}", UNITS[quantity]),
                                       loop_name(cutoff), colour, mark=mark)
                                 for cutoff, (colour, mark) in zip(cutoffs, CURVES)])
    return [Layout(f"fig08_b{bandwidth}", drawer.data.need("omega", "rad/s"), "frequency [rad/s]",
                   list(panels(bandwidth, cutoffs)), log_x=True, title=f"closed-loop bandwidth {bandwidth} rad/s")
            for bandwidth, cutoffs in CUTOFFS.items()]


CUTOFFS = {100: (0, 12, 25, 40), 200: (0, 25, 50, 81)}


def loop_name(cutoff):
    return f"omega_c {cutoff} rad/s" if cutoff else "conventional"


def profile(drawer, run, errors):
    return [drawer.over_time("", [
        Panel("speed [r/min]", [drawer.of(run, "speed_hat", "estimated", ORANGE), drawer.of(run, "speed", "true", BLUE),
                                drawer.reference()]),
        Panel("position [rad]", [drawer.of(run, "theta", "true", BLUE),
                                 drawer.of(run, "theta_hat", "estimated", ORANGE)]),
        Panel("position error [mrad]", errors, "error", height=1.3)])]


def fig10(drawer):
    return profile(drawer, "sign", [drawer.of("sign", "theta_err", "sign", ORANGE),
                                    drawer.of("sigmoid", "theta_err", "sigmoid, for comparison", BLUE)])


def fig11(drawer):
    errors = []
    for gain, (colour, mark) in zip((162, 200), CURVES):
        errors += [drawer.of(f"ks{gain}", "theta_err", f"k_s {gain} V", colour, mark=mark),
                   drawer.of(f"ks{gain}", "theory_err", f"theory, {gain} V", BLACK, dashed=True)]
    return profile(drawer, "ks162", errors)


def fig12(drawer):
    def both(quantity):
        return [drawer.of("exact", quantity, "exact lag", BLUE, mark="o"),
                drawer.of("printed", quantity, "(14) as printed", ORANGE, mark="s")]
    return [drawer.over_time("", [Panel("position error [mrad]", both("theta_err"), "error", height=1.3),
                                  Panel("current i_q [A]", both("i_q")),
                                  Panel("wrong-axis current i_d [A]", both("true_i_d"))])]


def fig13(drawer):
    return [drawer.over_time(f"_{load}", [
        Panel("speed [r/min]", [drawer.of(f"b100_wc0_{load}", "speed_hat", "estimated", ORANGE),
                                drawer.of(f"b100_wc0_{load}", "speed", "true", BLUE), drawer.reference()]),
        Panel("speed error [r/min]", [drawer.of(f"b100_wc0_{load}", "speed_err", "estimated - true", PURPLE)], "error"),
        Panel("position error [mrad]", [drawer.of(f"b100_wc0_{load}", "theta_err", "estimated - true", PURPLE),
                                        drawer.of(f"b100_wc0_{load}", "theory_err", "theory, a/k_i", BLACK,
                                                  dashed=True)],
              "error", height=1.3)], title) for load, title in (("nl", "no load"), ("rated", "rated load, 5 N m"))]


def by_bandwidth(drawer, load):
    return [drawer.loops(f"_b{bandwidth}", f"closed-loop bandwidth {bandwidth} rad/s",
                         [(f"b{bandwidth}_wc{cutoff}_{load}", loop_name(cutoff)) for cutoff in cutoffs])
            for bandwidth, cutoffs in CUTOFFS.items()]


def fig14(drawer):
    return by_bandwidth(drawer, "nl")


def fig15(drawer):
    return by_bandwidth(drawer, "rated") + [drawer.loops("_uncompensated", "inverter not compensated", [
        ("b200_wc0_uncompensated", "200 rad/s, conventional"),
        ("b200_wc25_uncompensated", "200 rad/s, omega_c 25 rad/s"),
        ("b100_wc0_uncompensated", "100 rad/s, conventional")])]


def fig17(drawer):
    return [drawer.loops(f"_{speed}", f"{speed} r/min", [
        (f"b100_wc0_{speed}", "100 rad/s, conventional"), (f"b100_wc25_{speed}", "100 rad/s, omega_c 25 rad/s"),
        (f"b200_wc50_{speed}", "200 rad/s, omega_c 50 rad/s")], f"speed_ref_{speed}", current=True)
            for speed in (500, 1500)]


LAYOUTS = {"fig04": fig04, "fig05": fig05, "fig08": fig08, "fig10": fig10, "fig11": fig11, "fig12": fig12,
           "fig13": fig13,
           "fig14": fig14, "fig15": fig15, "fig17": fig17}


def layouts(figure, data):
    """The layouts of one figure of the manifest, in their order. The figures that are tables, fig16 and beyond_*, have no layouts."""
    return LAYOUTS[figure["id"]](Drawer(figure, data)) if figure["id"] in LAYOUTS else []
