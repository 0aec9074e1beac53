"""Chooses the panels for a recording of a drive: speeds, torque, currents and voltages with their limits, the error of the angle, states as
bands. Any other signal has a panel for its unit, so that every recorded signal is shown. Needs numpy.

A row of PANELS takes the columns of its list that the recording has. Scale turns the SI unit into that of the axis."""
import dataclasses
import math
import re

import numpy

from figures import Data, Layout, Panel, Trace
from style import BLACK, BLUE, GREEN, ORANGE, PURPLE
from table import RPM, by_name

SKY, AMBER, GREY, RED = "#56B4E9", "#E69F00", "#777777", "#B3261E"
CYCLE = (BLUE, ORANGE, GREEN, PURPLE, SKY, AMBER, GREY)
BANDS_MAX = 400      # bands of a column; a column with more changes is drawn as a line
NEAR_LIMIT = 0.4     # share of the largest limit: from this value on the limit is within the axis
UNKNOWN = 1.81       # [rad] theta_sigma of an unknown angle
LOCKED = 350.0       # [mrad] a larger error of the angle counts as a lost lock


@dataclasses.dataclass
class Kind:
    """A panel: its title, its unit, the factor from the unit of the recording, and {column: (label, colour, look)}."""
    title: str
    unit: str
    scale: float
    rows: dict
    source: str = ""  # unit in the recording, if it differs
    kind: str = ""
    height: float = 1.0


REFERENCE, LIMIT, TURNS = {"dashed": True}, {"dashed": True, "limit": True}, {"wraps": math.pi}
PANELS = (
    Kind("speed", "r/min", RPM, {
        "omega_m": ("used by the drive", ORANGE, {}), "true_omega_m": ("true", BLUE, {}),
        "omega_m_ref": ("reference", BLACK, REFERENCE)}, "rad/s"),
    Kind("torque", "N m", 1.0, {
        "true_torque": ("motor", GREEN, {}), "load_torque": ("load", BLACK, REFERENCE)}),
    Kind("current", "A", 1.0, {
        "true_i_q": ("true i_q", SKY, {}), "true_i_d": ("true i_d", AMBER, {}), "i_q": ("i_q", BLUE, {}), "i_d": ("i_d", ORANGE, {}),
        "i_q_ref": ("i_q reference", BLACK, REFERENCE), "i_d_ref": ("i_d reference", GREY, REFERENCE),
        "i_q_upper": ("upper limit of i_q", RED, LIMIT), "i_q_lower": ("lower limit of i_q", RED, LIMIT)}, height=1.2),
    Kind("phase current", "A", 1.0, {
        "true_i_a": ("true i_a", BLUE, {}), "true_i_b": ("true i_b", ORANGE, {}), "true_i_c": ("true i_c", GREEN, {}),
        "i_a": ("measured i_a", PURPLE, {}), "i_b": ("measured i_b", AMBER, {}), "i_c": ("measured i_c", SKY, {}),
        "overcurrent_trip": ("overcurrent_trip", RED, LIMIT), "overcurrent_trip-": ("-overcurrent_trip", RED, LIMIT)}),
    Kind("voltage", "V", 1.0, {
        "u_q_ref": ("u_q reference", SKY, {}), "u_d_ref": ("u_d reference", AMBER, {}), "u_q": ("u_q", BLUE, {}), "u_d": ("u_d", ORANGE, {}),
        "u_length": ("length of the vector", GREY, {}), "u_limit": ("limit u_dc/√3", RED, LIMIT)}),
    Kind("DC link", "V", 1.0, {
        "true_u_dc": ("true", SKY, {}), "u_dc": ("measured", BLUE, {}), "dc_swing": ("swing in 20 ms", ORANGE, {}),
        "dc_overvoltage": ("dc_overvoltage", RED, LIMIT), "dc_undervoltage": ("dc_undervoltage", RED, LIMIT)}, height=0.7),
    Kind("angle error", "mrad", 1e3, {
        "theta_hat_err": ("of the estimate", ORANGE, {"wraps": 1e3 * math.pi}),
        "theta_err": ("of the angle that the drive uses", BLUE, {"wraps": 1e3 * math.pi}),
        "sigma_upper": ("3 theta_sigma", GREY, LIMIT), "sigma_lower": ("-3 theta_sigma", GREY, LIMIT)},
        "rad", "error", 1.2),
    Kind("electrical angle", "rad", 1.0, {
        "true_theta_e": ("true", BLUE, TURNS), "theta_e": ("used by the drive", ORANGE, TURNS),
        "theta_hat": ("estimated", GREEN, TURNS), "frame_theta_e": ("of the active frame", PURPLE, TURNS),
        "encoder_theta_e": ("encoder", SKY, TURNS)}),
    Kind("electrical speed", "rad/s", 1.0, {
        "true_omega_e": ("true", BLUE, {}), "omega_e": ("used by the drive", ORANGE, {}), "omega_hat": ("estimated", GREEN, {}),
        "omega_smooth": ("estimated, smooth", PURPLE, {}), "encoder_omega_e": ("encoder", SKY, {})}),
    Kind("back-EMF", "V", 1.0, {
        "e_alpha": ("alpha", BLUE, {}), "e_beta": ("beta", ORANGE, {}), "e_hat_alpha": ("observed alpha", SKY, {}),
        "e_hat_beta": ("observed beta", AMBER, {}), "e_amplitude": ("length of the vector", GREEN, {})}),
    Kind("duty", "-", 1.0, {"duty_a": ("leg a", BLUE, {}), "duty_b": ("leg b", ORANGE, {}), "duty_c": ("leg c", GREEN, {})}),
)
FIRST_BANDS = ("state", "manoeuvre", "fault_reason", "warnings", "warnings_2", "refusal", "fault_present")
REASONS = ("fault_reason", "refusal", "fault_present", "order_refusal")
BIT = re.compile(r"\b(\d+) ([a-z][a-z ]*)")


class Drawn:
    """Layouts of a recording, and the columns that they show, in the units of their axes."""

    def __init__(self, recording, tables):
        self.recording, self.tables = recording, tables
        self.rows = by_name(tables)
        self.data = Data(recording.path, {"time": recording.time}, {"time": "s"})
        self.left = dict(recording.units)  # columns that no panel shows yet
        self.panels = [panel for panel in (self.bands(), *(self.panel(kind) for kind in PANELS), *self.others()) if panel]

    def layout(self, name, title=""):
        return Layout(name, "time", "time [s]", self.panels, title=title)

    # ---- columns ----

    def take(self, name, unit, scale):
        values = self.recording.columns[name].astype(float) * scale
        self.data.columns[name], self.data.units[name] = values, unit
        self.left.pop(name, None)
        return values

    def derive(self, name, values, unit="V"):
        self.data.columns[name], self.data.units[name] = values, unit

    def constant(self, name, setting, sign=1.0, unit="A"):
        """A parameter as a line, if the recording contains it."""
        value = self.recording.values.get(setting)
        if value and value[0] > 0.0:
            self.derive(name, numpy.full(len(self.recording.time), sign * value[0]), unit)

    # ---- panels of lines ----

    def panel(self, kind):
        source = kind.source or kind.unit
        present = [name for name in kind.rows if self.left.get(name) == source]
        if not any(not kind.rows[name][2].get("limit") and not kind.rows[name][2].get("dashed") for name in present):
            return None  # a reference without its signal is shown in the panel of its unit
        for name in present:
            self.take(name, kind.unit, kind.scale)
        self.derived(kind.title)
        shown = [name for name in kind.rows if name in self.data.columns]
        traces = [Trace(name, label, colour, **look) for name, (label, colour, look) in kind.rows.items() if name in shown]
        unit = f" [{kind.unit}]"
        panel = Panel(kind.title + unit, traces, kind.kind, kind.height)
        self.limits(panel)
        if kind.title == "angle error":
            self.tracking(panel)
        return panel

    def derived(self, title):
        columns = self.data.columns
        if title == "phase current":
            self.constant("overcurrent_trip", "overcurrent_trip")
            self.constant("overcurrent_trip-", "overcurrent_trip", -1.0)
        elif title == "DC link":
            self.constant("dc_overvoltage", "dc_overvoltage", unit="V")
            self.constant("dc_undervoltage", "dc_undervoltage", unit="V")
        elif title == "angle error" and self.left.pop("theta_sigma", None) == "rad":
            sigma = self.recording.columns["theta_sigma"].astype(float)
            stated = numpy.where(sigma < UNKNOWN, 3e3 * sigma, numpy.nan)
            self.derive("sigma_upper", stated, "mrad")
            self.derive("sigma_lower", -stated, "mrad")
        elif title == "voltage" and "u_d" in columns and "u_q" in columns:
            self.derive("u_length", numpy.hypot(columns["u_d"], columns["u_q"]))
            if self.recording.units.get("u_dc") == "V":
                self.derive("u_limit", self.recording.columns["u_dc"].astype(float) / math.sqrt(3.0))

    def limits(self, panel):
        """Writes the values of limits that are beyond the axis."""
        held = [self.data.columns[trace.column] for trace in panel.traces if not trace.limit]
        reach = max((numpy.abs(values[numpy.isfinite(values)]).max(initial=0.0) for values in held), default=0.0)
        beyond = []
        for trace in panel.traces:
            values = self.data.columns[trace.column]
            least = numpy.abs(values[numpy.isfinite(values)]).min(initial=math.inf)
            if trace.limit and math.isfinite(least) and reach < NEAR_LIMIT * least and not trace.label.startswith(("-", "lower")):
                beyond.append(f"{trace.label} {least:.3g} {self.data.units[trace.column]}")
        panel.note = f"beyond the axis: {', '.join(beyond)}" if beyond else ""

    def tracking(self, panel):
        """Scales the axis of the angle's error to the locked estimate in the manoeuvre run, because the error has no meaning before that.
        The drive's own uncertainty is within the axis for at least half of that time."""
        names = self.recording.choices.get("manoeuvre", [])
        if "run" not in names or "manoeuvre" not in self.recording.columns:
            return
        run = self.recording.columns["manoeuvre"] == names.index("run")
        errors = [trace for trace in panel.traces if not trace.limit]
        stated = [self.data.columns[trace.column][run] for trace in panel.traces if trace.limit]
        reach = [self.data.columns[trace.column][run] for trace in errors]
        reach += [numpy.median(values[numpy.isfinite(values)], keepdims=True) for values in stated if numpy.isfinite(values).any()]
        reach = [values[numpy.abs(values) < LOCKED] for values in reach]
        reach = [values for values in reach if len(values)]
        if reach:
            least, most = min(map(numpy.min, reach)), max(map(numpy.max, reach))
            room = 0.15 * (most - least) or 1.0
            outside = any((values < least - room).any() or (values > most + room).any()
                          for values in (self.data.columns[trace.column] for trace in errors))
            if outside:
                panel.range = [float(least - room), float(most + room)]
                panel.note = "axis scaled to the locked estimate in run"

    # ---- bands ----

    def names(self, name):
        """The names of the values of a column; None: they are numbers."""
        row = self.rows.get(name, {})
        if name in self.recording.choices or "choices" in row:
            choices = self.recording.choices.get(name) or row["choices"].split("|")
            return {str(value): choice for value, choice in enumerate(choices)}
        if name in REASONS:
            return {number: reason["name"] for number, reason in self.tables.get("reasons", {}).items()} or None
        if name in ("warnings", "warnings_2", "faults_later", "faults_later_2"):
            faults = self.tables.get("faults", [])
            return {"bits": faults[32:] if name.endswith("_2") else faults[:32]} if faults else None
        bits = {int(value): text.strip() for value, text in BIT.findall(row.get("text", ""))}
        if row.get("kind") == "uint" and bits and all(value == 1 << k for k, value in enumerate(sorted(bits))) and len(bits) > 2:
            return {"bits": [bits[value] for value in sorted(bits)]}
        return None

    def is_band(self, name):
        if self.recording.units[name] != "-":
            return False
        values = self.recording.columns[name]
        if not numpy.isfinite(values).all() or (values != numpy.rint(values)).any():
            return False
        if numpy.count_nonzero(numpy.diff(values)) >= BANDS_MAX:
            return False
        kind = self.rows.get(name, {}).get("kind")
        return kind in ("int", "uint", "choice") or (kind is None and (name in self.recording.choices or name in FIRST_BANDS))

    def bands(self):
        names = [name for name in FIRST_BANDS if name in self.left] + [name for name in self.left if name not in FIRST_BANDS]
        names = [name for name in names if self.is_band(name)]
        quiet = [name for name in names if name in ("warnings_2", "fault_present") and not self.recording.columns[name].any()]
        for name in quiet:  # the other columns show this
            self.take(name, "-", 1.0)
        names = [name for name in names if name not in quiet]
        if not names:
            return None
        for name in names:
            self.take(name, "-", 1.0)
        traces = [Trace(name, name.replace("_", " "), colour(n), names=self.names(name)) for n, name in enumerate(names)]
        return Panel("", traces, "bands", 0.16 * len(names))

    # ---- the rest ----

    def others(self):
        """Makes a panel for each remaining unit, but none for the time if this is the axis."""
        if "period" in self.left and "period" in self.recording.columns:
            clock = self.recording.columns["period"].astype(float) - self.recording.periods()
            if (clock == clock[0]).all():
                del self.left["period"]
        units = {}
        for name, unit in self.left.items():
            units.setdefault(unit, []).append(name)
        for unit, names in units.items():
            for begin in range(0, len(names), len(CYCLE)):
                part = names[begin:begin + len(CYCLE)]
                for name in part:
                    self.take(name, unit, 1.0)
                label = part[0] if len(part) == 1 else "others"
                yield Panel(f"{label} [{unit}]", [Trace(name, name, colour(n)) for n, name in enumerate(part)])


def colour(n):
    return CYCLE[n % len(CYCLE)]


def spans(times, values):
    """(begin, end, value) of each stretch of equal values, without those that are not numbers; the last ends
    with the last sample."""
    if not len(values):
        return []
    none = numpy.iinfo(numpy.int64).min
    values = numpy.where(numpy.isfinite(values), values, none).astype(numpy.int64)
    starts = numpy.concatenate(([0], numpy.flatnonzero(numpy.diff(values)) + 1))
    ends = numpy.append(times[starts[1:]], times[-1])
    return [(float(times[start]), float(end), int(values[start])) for start, end in zip(starts, ends) if values[start] != none]


def name_of(names, value):
    """The text of a value in a band."""
    if not names:
        return str(value)
    if "bits" in names:
        bits = [names["bits"][bit] if bit < len(names["bits"]) else f"bit {bit}" for bit in range(32) if value >> bit & 1]
        return ", ".join(bits) or "none"
    return names.get(str(value), str(value))


def events(drawn):
    """Events of the scenario, changes of manoeuvre, and faults: [{time, text, kind}] in the order of time."""
    recording = drawn.recording
    found = []
    for key, name, text in recording.notes:
        if key == "event":
            found.append({"time": float(name.split()[0]), "text": text, "kind": ""})
    for column in ("manoeuvre", "fault_reason"):
        if column in recording.columns and drawn.is_band(column):
            names = drawn.names(column)
            for begin, _, value in spans(recording.time, recording.columns[column])[1:]:
                if column == "manoeuvre":
                    found.append({"time": begin, "text": name_of(names, value), "kind": "manoeuvre"})
                elif value:
                    found.append({"time": begin, "text": f"fault {name_of(names, value)}", "kind": "fault"})
    return sorted((event for event in found if recording.time[0] <= event["time"] <= recording.time[-1]),
                  key=lambda event: event["time"])
