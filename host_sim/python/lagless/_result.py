"""The result of a run: arrays, verdicts, a fault, a picture."""
import collections.abc
import ctypes as c
import dataclasses
import math
import re

import numpy as np

from ._library import Samples, library, of

# Panels of a picture, those of the page of `lagless run --plot`: names, the recorded unit, title, unit of the axis, factor.
# A signal is shown in the first panel that fits it; a signal that fits none has a panel for its unit.
_PANELS = (
    (re.compile(r"(true_)?omega_m(_ref)?|speed_request|omega_load"), "rad/s", "speed", "r/min", 30.0 / math.pi),
    (re.compile(r".*"), "rad/s", "electrical speed", "rad/s", 1.0),
    (re.compile(r".*_err"), "rad", "angle error", "mrad", 1e3),
    (re.compile(r".*"), "rad", "angle", "rad", 1.0),
    (re.compile(r"(true_)?i_[abc]"), "A", "phase current", "A", 1.0),
    (re.compile(r".*"), "A", "current", "A", 1.0),
    (re.compile(r"(true_)?u_dc|dc_.*"), "V", "DC link", "V", 1.0),
    (re.compile(r".*"), "V", "voltage", "V", 1.0),
    (re.compile(r".*"), "N m", "torque", "N m", 1.0),
)
_REFERENCE = ("_ref", "_request")  # drawn dashed


def _panel(name, unit):
    """Label of the axis, and the factor from the recorded value to it."""
    for names, of, title, shown, factor in _PANELS:
        if unit == of and names.fullmatch(name):
            return f"{title} [{shown}]", factor
    return f"[{unit}]", 1.0


class Trace(collections.abc.Mapping):
    """Samples of some rows: a mapping from names to numpy arrays, of float32 or integers as in the drive.

    t: begin of each sample's period [s], float64; period: number of that period; units: unit of each name; choices: names of the values of rows
    with choices. `trace["i_q"]` and `trace.i_q` are the same; `trace["omega_m"]` is in rad/s."""

    def __init__(self, rows, periods, slots, board=None):
        self.period = periods
        self.t = np.empty(len(periods))
        of(board).seconds(periods.ctypes.data, self.t.ctypes.data, len(periods))
        self._columns = {row.key: np.ascontiguousarray(slots[:, n]).view(row.dtype) for n, row in enumerate(rows)}
        self.rows = {row.key: row for row in rows}
        self.units = {row.key: row.unit for row in rows}
        self.choices = {row.key: row.choices for row in rows if row.choices}

    def __getitem__(self, name):
        return self._columns[name]

    def __getattr__(self, name):
        columns = self.__dict__.get("_columns", {})
        if name in columns:
            return columns[name]
        raise AttributeError(f"{type(self).__name__} has no {name}; recorded: {', '.join(columns) or 'nothing'}")

    def __iter__(self):
        return iter(self._columns)

    def __len__(self):
        return len(self._columns)

    def __repr__(self):
        span = f"{self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else "no sample"
        return f"<{type(self).__name__}: {len(self.t)} samples of {', '.join(self) or 'nothing'}, {span}>"

    def to_pandas(self):
        """A pandas.DataFrame over time [s]; rows with choices as categories; units in `.attrs["units"]`."""
        import pandas

        frame = pandas.DataFrame({name: pandas.Categorical.from_codes(column, self.choices[name]) if name in self.choices
                                  else column for name, column in self.items()}, index=pandas.Index(self.t, name="time"))
        frame.attrs["units"] = dict(self.units)
        return frame

    def plot(self, names=None, figure=None):
        """A matplotlib figure with the panels of the page of `lagless run --plot`: speeds in r/min, angle errors in mrad,
        phase currents apart from those of the axes; shared time axis, references dashed, values held for a period."""
        import matplotlib.pyplot as plt

        panels = {}
        for name in names or self:
            self[name]  # raises KeyError before anything is drawn
            label, factor = (name, 1.0) if name in self.choices else _panel(name, self.units[name])
            panels.setdefault(label, []).append((name, factor))
        figure = figure or plt.figure(figsize=(9, 1.2 + 1.7 * max(1, len(panels))), layout="constrained")
        axes = figure.subplots(max(1, len(panels)), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (label, members) in zip(axes, panels.items()):
            for name, factor in members:
                axis.step(self.t, self[name] * factor if factor != 1.0 else self[name], where="post", label=name, linewidth=1,
                          linestyle="--" if name.endswith(_REFERENCE) else "-")
            if label in self.choices:
                axis.set_yticks(range(len(self.choices[label])), self.choices[label], fontsize=7)
            elif label.startswith("angle error"):
                self._limit_to_run(axis, members)
            axis.set_ylabel(label)
            axis.grid(True, alpha=0.3)
            axis.legend(loc="upper left", bbox_to_anchor=(1, 1), fontsize=8)
        axes[-1].set_xlabel("time [s]")
        return figure

    def _limit_to_run(self, axis, members):
        """The axis covers the errors in manoeuvre run: before, the error of the angle has no meaning."""
        names = self.choices.get("manoeuvre", ())
        run = self["manoeuvre"] == names.index("run") if "run" in names else np.zeros(len(self.t), dtype=bool)
        if run.any() and not run.all():
            values = np.concatenate([self[name][run] * factor for name, factor in members])
            low, high = np.percentile(values, (0.5, 99.5))
            margin = 0.2 * (high - low) + 0.5
            axis.set_ylim(low - margin, high + margin)
            axis.annotate("axis: manoeuvre run", (0.01, 0.9), xycoords="axes fraction", fontsize=7)


@dataclasses.dataclass(frozen=True)
class Verdict:
    """The verdict of an expectation: the value [unit] and its limits, -inf or inf for a missing limit."""
    name: str
    signal: str
    minus: str
    statistic: str
    unit: str
    begin: float
    end: float
    value: float
    at_least: float
    at_most: float
    samples: int
    judgement: str  # met, failed, not_judged; measured, of a [[measure]]
    text: str

    def __bool__(self):
        return self.judgement == "met"


@dataclasses.dataclass(frozen=True)
class Fault:
    """A fault, refusal or warning of the drive: what happened, what to do, and the time if it is known."""
    name: str
    text: str
    remedy: str
    period: int = None
    board: str = dataclasses.field(default=None, repr=False)

    @property
    def seconds(self):
        return None if self.period is None else self.period * of(self.board).period()


def reason(number, period=None, board=None):
    """The Fault of a reason's number; None: nothing is wrong."""
    texts = [c.c_char_p() for _ in range(3)]
    if number == 0 or not library.reason(number, *(c.byref(text) for text in texts)):
        return None
    return Fault(*(text.value.decode() for text in texts), period, board)


class Result(Trace):
    """A run of a scenario: its recording, its verdicts, and how it ended.

    board: name of the board; passed: every expectation is met, and the run did not end with a fault or a lasting refusal that none of them names
    (unexpected_end has its text; None otherwise); verdicts: one for each expectation; measures: measured values without a limit; fault: latched
    at the end, or None; not_on: reason why the bridge is off although it is commanded on, or None; state, manoeuvre: of the drive at the end;
    history: Trace of the periods up to the last fault, or None; hash: of the rig's whole state at the end; periods, seconds: simulated; wall:
    seconds it took; interrupted: it was stopped before its end."""

    def __init__(self, rows, periods, slots, about):
        super().__init__(rows, periods, slots, about["board"])
        self.__dict__.update(about)

    @property
    def passed(self):
        return self.failed == 0 and not self.interrupted

    def __repr__(self):
        fault = f", fault {self.fault.name} at {self.fault.seconds:g} s" if self.fault else ""
        unmet = self.failed - (self.unexpected_end is not None)
        counts = f"{len(self.verdicts) - unmet} of {len(self.verdicts)} expectations met"
        return f"<Result of \"{self.title}\": {self.seconds:g} s, {counts}, {self.state}{fault}; {', '.join(self)}>"

    def report(self):
        """Title and verdicts as text, as `lagless run` prints them."""
        words = {"met": "met", "failed": "FAILED", "not_judged": "not judged", "measured": "measured"}
        end = [f"{'FAILED':<10}  end of the run: {self.unexpected_end}"] if self.unexpected_end else []
        return "\n".join([self.title] + [f"{words[verdict.judgement]:<10}  {verdict.text}" for verdict in self.verdicts + self.measures] + end)

    def plot(self, names=None, figure=None):
        figure = super().plot(names, figure)
        figure.suptitle(self.title, fontsize=10)
        if self.fault is not None:
            for axis in figure.axes:
                axis.axvline(self.fault.seconds, color="tab:red", linewidth=1, linestyle=":")
        return figure

    plot.__doc__ = Trace.plot.__doc__


class Recorder:
    """A buffer for the samples of a tap."""

    def __init__(self, rows, samples):
        self.rows = rows
        self.slots = np.empty((samples, len(rows)), dtype=np.uint32)
        self.periods = np.empty(samples, dtype=np.uint32)
        self.struct = Samples(self.slots.ctypes.data, self.periods.ctypes.data, samples, 0)

    def taken(self):
        count = min(self.struct.used, self.struct.room)
        return self.rows, self.periods[:count].copy(), self.slots[:count]
