"""Compares two recordings: a report of the differences, and both in the same panels. Needs numpy."""
import dataclasses
import math

import numpy

import drive
import progress
import recording as recordings
from figures import Layout, Panel
from table import InputError, by_name, printed

SETTINGS_MAX = 12  # this number of settings is printed; the page has all


def alike(name):
    """The name of a column in the form that both CSV and MAT allow."""
    return name.replace(".", "_")


def common_columns(a, b):
    """([(name in A, name in B)], only in A, only in B)"""
    of_b = {alike(name): name for name in b.units}
    both = [(name, of_b[alike(name)]) for name in a.units if alike(name) in of_b]
    in_a = {alike(name) for name in a.units}
    return both, [name for name in a.units if alike(name) not in of_b], [name for name in b.units if alike(name) not in in_a]


def pair(a, b):
    """Both columns in the same number type, because a single-precision number of MAT differs from the double that is read from CSV."""
    kinds = {values.dtype for values in (a, b) if values.dtype != numpy.float64}
    kind = numpy.float32 if numpy.dtype("f4") in kinds or not kinds else numpy.float64
    if kind is numpy.float32 and not kinds and ((a == numpy.rint(a)).all() and (b == numpy.rint(b)).all()):
        kind = numpy.float64  # counts above 2^24 need doubles
    return a.astype(kind), b.astype(kind)


def differ(a, b):
    """Where the samples differ. Two values that are not a number count as equal."""
    return (a != b) & ~((a != a) & (b != b))


HALF_TURN = {"rad": math.pi, "mrad": 1e3 * math.pi}  # Each signal in rad is an angle that wraps.


def apart(x, y, unit):
    """x - y; of two angles the difference of least magnitude."""
    by = x - y
    half = HALF_TURN.get(unit)
    return by if half is None else numpy.where(numpy.abs(by) > half, numpy.mod(by + half, 2 * half) - half, by)


@dataclasses.dataclass
class Difference:
    name: str
    unit: str
    first: int      # place among the common samples
    count: int
    largest: float  # [unit]
    a: float
    b: float


class Comparison:
    def __init__(self, a, b, rows):
        self.a, self.b, self.rows = a, b, rows
        if a.period != b.period:
            raise InputError(f"{a.path} has periods of {a.period:g} s, {b.path} of {b.period:g} s: their samples cannot be compared")
        self.both, self.only_a, self.only_b = common_columns(a, b)
        for name, other in self.both:
            if a.units[name] != b.units[other]:
                raise InputError(f"{name}: [{a.units[name]}] in {a.path}, [{b.units[other]}] in {b.path}: the tables differ")
        self.periods, self.at_a, self.at_b = numpy.intersect1d(a.periods(), b.periods(), return_indices=True)
        self.differences = []
        for name, other in self.both:
            x, y = pair(a.columns[name][self.at_a], b.columns[other][self.at_b])
            where = numpy.flatnonzero(differ(x, y))
            if len(where):
                by = numpy.abs(apart(x[where].astype(float), y[where].astype(float), a.units[name]))
                by = by[numpy.isfinite(by)]
                self.differences.append(Difference(name, a.units[name], int(where[0]), len(where), float(by.max(initial=0.0)),
                                                   x[where[0]], y[where[0]]))
        self.differences.sort(key=lambda one: one.first)
        self.left_a = len(a.time) - len(self.periods)
        self.left_b = len(b.time) - len(self.periods)

    @property
    def equal(self):
        return not (self.differences or self.only_a or self.only_b or self.left_a or self.left_b) and bool(self.both)

    def settings(self):
        """[(name, value in A, value in B, unit)] of the settings that differ; None if a recording does not contain the setting."""
        found = []
        of_b = {alike(name): value for name, value in self.b.values.items()}
        of_a = {alike(name): value for name, value in self.a.values.items()}
        names = {alike(name): name for values in (self.b.values, self.a.values) for name in values}
        for key, name in names.items():
            x, y = of_a.get(key), of_b.get(key)
            if x is None or y is None or numpy.float32(x[0]) != numpy.float32(y[0]):
                found.append((name, x[0] if x else None, y[0] if y else None, (x or y)[1]))
        return found if self.a.values and self.b.values else []

    def named(self, name, value, unit):
        """A value with its unit: the name of a choice, a mechanical speed in r/min, else the shortest decimal."""
        for choices in (self.a.choices.get(name), self.b.choices.get(name)):
            if choices and value == value and 0 <= int(value) < len(choices):
                return choices[int(value)]
        shown, shown_unit = printed(float(value), unit, {**self.rows.get(name, {}), "choices": ""})
        if shown_unit != unit:
            return short(shown, shown_unit)
        whole = numpy.isfinite(value) and value == int(value) and abs(value) < 1e9
        return (f"{int(value)}" if whole else str(value)) + of_unit(unit)

    def lines(self):
        """The report, a line each."""
        a, b = self.a, self.b
        for letter, one in (("A", a), ("B", b)):
            yield f"{letter}: {one.path}: {len(one.time)} samples of {len(one.units)} signals, {one.time[0]:.9g} s to {one.time[-1]:.9g} s"
        for key in ("program", "commit", "tables", "scenario", "seed", "ended"):
            x, y = a.meta.get(key, ""), b.meta.get(key, "")
            if x != y:
                yield f"{key}: {x or '-'} in A, {y or '-'} in B"
        if a.meta.get("every") != b.meta.get("every"):
            yield f"rate: every {a.meta.get('every')} periods in A, every {b.meta.get('every')} in B"
        if a.text and b.text and a.text.rstrip() != b.text.rstrip():
            yield "the texts of the scenarios differ"
        for letter, names in (("A", self.only_a), ("B", self.only_b)):
            if names:
                yield f"only in {letter}: {', '.join(names)}"
        settings = self.settings()
        for name, x, y, unit in settings[:SETTINGS_MAX]:
            row = self.rows.get(name, {})
            yield f"setting {name}: {short(*printed(x, unit, row))} in A, {short(*printed(y, unit, row))} in B"
        if len(settings) > SETTINGS_MAX:
            yield f"and {len(settings) - SETTINGS_MAX} more settings"
        if not self.both:
            yield "no signal is in both"
            return
        if not len(self.periods):
            yield "A and B have no sample at the same time"
            return
        if self.left_a or self.left_b:
            yield f"compared: {len(self.periods)} samples that both have; {self.left_a} only A has, {self.left_b} only B"
        yield from self.verdict()

    def verdict(self):
        count = len(self.periods)
        if not self.differences:
            yield (f"equal: {count} samples of {len(self.both)} signals" if self.equal else
                   f"no difference in the {count} samples of the {len(self.both)} signals that both have")
            return
        first = self.differences[0]
        period = int(self.periods[first.first])
        names = [one for one in self.differences if one.first == first.first]
        yield f"first difference: period {period}, {period * self.a.period:.9g} s"
        for one in names:
            a, b = (self.named(one.name, value, one.unit) for value in (one.a, one.b))
            yield f"  {one.name}: {a} in A, {b} in B"
        yield f"{len(self.differences)} of {len(self.both)} signals differ:"
        wide = max(len(one.name) for one in self.differences)
        for one in self.differences:
            when = int(self.periods[one.first]) * self.a.period
            yield f"  {one.name:{wide}}  from {when:.9g} s, in {one.count} of {count} samples{self.by_up_to(one)}"

    def by_up_to(self, one):
        """The largest difference in the unit of `lagless run`; of names of choices there is none."""
        if self.a.choices.get(one.name) or self.b.choices.get(one.name):
            return ""
        largest, unit = printed(one.largest, one.unit, {**self.rows.get(one.name, {}), "choices": ""})
        if unit == "rad" and largest < 1.0:
            largest, unit = 1e3 * largest, "mrad"
        return f", by up to {largest:.4g}{of_unit(unit)}"


def short(value, unit="-"):
    return "-" if value is None else value if isinstance(value, str) else f"{value:.{7 if unit.startswith('r/min') else 9}g}{of_unit(unit)}"


def of_unit(unit):
    return "" if unit == "-" else f" {unit}"


# ---- both in one picture ----

def held(recording, name, periods):
    """The values of the column at these periods. A period without a sample gets the previous sample; periods outside the recording get NaN."""
    own = recording.periods()
    place = numpy.searchsorted(own, periods, side="right") - 1
    values = recording.columns[name].astype(float)[numpy.maximum(place, 0)]
    values[(periods < own[0]) | (periods > own[-1])] = numpy.nan
    return values


def merged(comparison):
    """One recording with the columns of A, those of B under the name B.name, and the times of both."""
    a, b = comparison.a, comparison.b
    periods = numpy.union1d(a.periods(), b.periods())
    columns = {"time": periods * a.period}
    of_b = {alike(name): name for name in b.units}
    for name in a.units:
        columns[name] = held(a, name, periods)
    others = {}
    for key, name in of_b.items():
        own = next((each for each in a.units if alike(each) == key), name)
        others[own] = held(b, name, periods)
    units = {**{own: b.units[of_b[alike(own)]] for own in others}, **a.units}
    for own in units:
        columns.setdefault(own, numpy.full(len(periods), numpy.nan))
    both = dataclasses.replace(a, units=units, columns=columns, choices={**b.choices, **a.choices}, notes=[])
    return both, others


def both_panels(drawn, scales, others, derived):
    """Each trace of A as a solid line, and the same of B as a dashed line; a derived column, for instance a limit, is one line if it is equal
    in both. `derived`: the columns of B that are computed from others."""
    panels = []
    for panel in drawn.panels:
        traces = []
        for trace in panel.traces:
            of_a = drawn.data.columns[trace.column]
            of_b = others[trace.column] * scales[trace.column] if trace.column in scales and trace.column in others else derived.get(trace.column)
            if trace.column not in scales and of_b is not None and numpy.array_equal(of_a, of_b, equal_nan=True):
                traces.append(trace)
                continue
            traces.append(dataclasses.replace(trace, label=f"{trace.label} A", dashed=False))
            if of_b is not None:
                name = f"B.{trace.column}"
                drawn.data.columns[name] = of_b
                drawn.data.units[name] = drawn.data.units[trace.column]
                traces.append(dataclasses.replace(trace, column=name, label=f"{trace.label} B", dashed=panel.kind != "bands"))
        panels.append(dataclasses.replace(panel, traces=traces,
                                          height=panel.height * (2.0 if panel.kind == "bands" else 1.0)))
    return panels


def difference_panels(drawn, scales, others, differing):
    """B minus A of the signals that differ, without those that are drawn as bands."""
    panels = []
    for panel in drawn.panels:
        traces = []
        for trace in panel.traces:
            if trace.column in differing and trace.column in others and panel.kind != "bands":
                name = f"d.{trace.column}"
                drawn.data.columns[name] = apart(others[trace.column] * scales[trace.column], drawn.data.columns[trace.column],
                                                 drawn.data.units[trace.column])
                drawn.data.units[name] = drawn.data.units[trace.column]
                traces.append(dataclasses.replace(trace, column=name, dashed=False, limit=False, wraps=0.0))
        if traces:
            panels.append(Panel(panel.ylabel.replace(" [", ", B-A ["), traces, "error", panel.height))
    return panels


class Both(drive.Drawn):
    """The panels of both recordings. Bands are also drawn where the merged columns have gaps."""

    def __init__(self, comparison, tables):
        both, others = merged(comparison)
        # Panels are chosen by the samples of A alone, because gaps would make a column of whole numbers appear
        # as one of floats.
        whole = {name: numpy.where(numpy.isfinite(values), values, 0.0) for name, values in both.columns.items()}
        super().__init__(dataclasses.replace(both, columns=whole), tables)
        scales = {}
        for name in both.units:
            if name in self.data.columns:
                scale = drive.RPM if self.data.units[name] == "r/min" else 1e3 if self.data.units[name] == "mrad" else 1.0
                scales[name] = scale
                self.data.columns[name] = both.columns[name] * scale
        taken = set(both.units)
        derived = {name: numpy.where(self.within(comparison.b), values, numpy.nan) for name, values in self.of_b(both, others, comparison, tables)
                   if name not in taken}
        for name in set(self.data.columns) - taken - {"time"}:
            self.data.columns[name] = numpy.where(self.within(comparison.a), self.data.columns[name], numpy.nan)
        differing = {one.name for one in comparison.differences}
        self.apart = difference_panels(self, scales, others, differing)
        self.panels = both_panels(self, scales, others, derived)

    @staticmethod
    def of_b(both, others, comparison, tables):
        """The columns that the panels of B alone would show, as pairs of name and values."""
        whole = {name: numpy.where(numpy.isfinite(values), values, 0.0) for name, values in {**both.columns, **others}.items()}
        return drive.Drawn(dataclasses.replace(both, columns=whole, values=comparison.b.values), tables).data.columns.items()

    def within(self, recording):
        """True where the recording has samples."""
        own = recording.periods() * recording.period
        return (self.data.columns["time"] >= own[0]) & (self.data.columns["time"] <= own[-1])

    def differences(self, name):
        return Layout(name, "time", "time [s]", self.apart)


def run(look):
    """The command. 0: equal; 1: not."""
    a, b = (recordings.read(path, progress.part(0.3 * n, 0.3 * (n + 1))) for n, path in enumerate(look.options.recordings))
    comparison = Comparison(a, b, by_name(look.tables))
    report = list(comparison.lines())
    progress.tell(0.7)
    try:
        if look.options.out:
            draw(look, comparison, report)
    finally:
        progress.end()
        print("\n".join(report), flush=True)
    return 0 if comparison.equal else 1


def draw(look, comparison, report):
    folder = look.folder(None)
    both = Both(comparison, look.tables)
    title = comparison.a.meta.get("title") or comparison.a.path.stem
    if comparison.b.meta.get("title", title) != title:
        title = f"{title} / {comparison.b.meta['title']}"

    def html(pictures):
        import drive_page
        import page
        png = pictures.get("")
        sections = [drive_page.plot_section("both", "Both recordings: A solid, B dashed", [], [] if png else
                                            page.plots([both.layout("both")], both.data), "", png)]
        if both.apart and not png:
            sections.append(drive_page.plot_section("apart", "B minus A", [], page.plots([both.differences("apart")], both.data), "", None))
        lines = "".join(f'<span class="line">{page.escape(line)}</span>' for line in report)
        sections.insert(0, f'<section id="differences"><h2>Differences</h2><pre>{lines}</pre></section>')
        lead = (f"<b>A</b>: {page.escape(comparison.a.path)}. {page.escape(drive_page.about(comparison.a))}<br>"
                f"<b>B</b>: {page.escape(comparison.b.path)}. {page.escape(drive_page.about(comparison.b))}")
        return drive_page.write(folder / "compare.html", title, lead, sections)
    look.save(folder, "compare", [("", title, both, [])], title, html)
    look.tell()
