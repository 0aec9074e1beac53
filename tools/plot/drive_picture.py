"""A recording as one picture, PNG or SVG: the panels of drive.py below each other, over one time axis. Needs matplotlib."""
import dataclasses
import hashlib
import io
import json
import math

import numpy

import pictures
from drive import name_of, spans
import style
from style import BLACK

BAND = 0.17        # [in] a line of a panel of bands
UNIT = 0.95        # [in] a panel of height 1
GAP = 0.26         # [in] between two panels, for a legend of one line
LINE = 0.15        # [in] a further line of a legend
SOFT = "#57606A"
FAULT = "#E39A96"


def tint(trace, value, names):
    """The colours of bands, as in page.js: `none` has no colour, a fault has the colour of faults."""
    name = name_of(names, value)
    if value == 0 or name == "none":
        return None
    if trace.column.removeprefix("A.").removeprefix("B.").startswith(("fault", "warning")) or name == "fault":
        return FAULT
    red, green, blue = TINTS[value % len(TINTS)]
    return tuple(1.0 - 0.3 * (1.0 - part / 255.0) for part in (red, green, blue))


TINTS = ((0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (86, 180, 233), (230, 159, 0), (119, 119, 119))


def bands(axis, panel, data):
    """Draws one line of named bands for each trace."""
    time = data["time"]
    scale = axis.inches / (time[-1] - time[0])
    for row, trace in enumerate(panel.traces):
        for begin, end, value in spans(time, data[trace.column]):
            colour = tint(trace, value, trace.names)
            if colour:
                axis.broken_barh([(begin, end - begin)], (row + 0.06, 0.88), facecolors=[colour], linewidth=0)
            if begin > time[0]:
                axis.plot([begin, begin], [row + 0.06, row + 0.94], color=BLACK, linewidth=0.7)
            room = (end - begin) * scale
            if room > 0.12:
                text = axis.annotate(name_of(trace.names, value), (begin, row + 0.5), xytext=(2.5, -0.4), textcoords="offset points",
                                     va="center", fontsize=6.8, color=BLACK if colour else SOFT)
                fit(text, (begin + end) / 2.0, room)
    axis.set_yticks([row + 0.5 for row in range(len(panel.traces))], [trace.label for trace in panel.traces], fontsize=7.5)
    axis.set_ylim(len(panel.traces), 0)
    axis.tick_params(length=0, labelbottom=False)
    axis.grid(False)
    for side in axis.spines.values():
        side.set_visible(False)


def fit(text, middle, room):
    """A name that is too wide for its band [in] is drawn smaller and centred, or is left out."""
    renderer = text.figure.canvas.get_renderer()
    if text.get_window_extent(renderer).width > (room - 0.06) * pictures.DPI:
        text.xy = (middle, text.xy[1])
        text.set(fontsize=6.0, ha="center", position=(0.0, -0.4))
        if text.get_window_extent(renderer).width > (room - 0.01) * pictures.DPI:
            text.remove()


def reach(axis, panel, data):
    """The axis, as in page.js: a given range, otherwise that of the traces and of the limits that are near them."""
    if panel.range:
        axis.set_ylim(*panel.range)
        return
    if not any(trace.limit for trace in panel.traces):
        return
    held = [part for part in (finite(data[trace.column]) for trace in panel.traces if not trace.limit) if len(part)]
    if not held:
        return
    least, most = min(map(numpy.min, held)), max(map(numpy.max, held))
    far = max(abs(least), abs(most)) / 0.4
    for trace in panel.traces:
        near = finite(data[trace.column])
        near = near[numpy.abs(near) <= far] if trace.limit else near[:0]
        if len(near):
            least, most = min(least, near.min()), max(most, near.max())
    room = 0.08 * (most - least) or 0.1 * abs(most) or 1.0
    axis.set_ylim(least - room, most + room)


def finite(values):
    return values[numpy.isfinite(values)]


def lines(axis, layout, panel, data):
    for n, trace in enumerate(panel.traces):
        pictures.curve(axis, data, layout.x, trace, zorder=2.9 if trace.dashed else 2.0 + 0.1 * n,
                       **({"linewidth": 0.9} if trace.limit else {}))
    axis.set_ylabel(pictures.typeset(panel.ylabel.replace(" [", "\n[")))
    axis.margins(y=0.08)
    reach(axis, panel, data)
    low, high = axis.get_ylim()
    shown = []
    for handle, trace in zip(*by_trace(axis, panel)):
        values = finite(data[trace.column])
        inside = len(values) and ((values >= low) & (values <= high)).any()
        if inside or not trace.limit:
            shown.append(handle)
    pictures.legend(axis, shown[:1] if not shown else unique(shown), indent=0.0)
    if panel.note:
        axis.text(1.0, 1.02, panel.note, transform=axis.transAxes, ha="right", va="bottom", fontsize=7, color=SOFT)


def by_trace(axis, panel):
    """Handles of the legend with their traces. A band that was too short to be drawn has no handle."""
    handles, labels = axis.get_legend_handles_labels()
    of = dict(zip(labels, handles))
    traces = [trace for trace in panel.traces if pictures.typeset(trace.label) in of]
    return [of[pictures.typeset(trace.label)] for trace in traces], traces


def unique(handles):
    """The upper and the lower limit share one entry of the legend."""
    return [handle for handle in handles if not str(handle.get_label()).startswith(("-", "lower"))]


def legend_lines(panel):
    """The approximate number of lines of the legend."""
    if panel.kind == "bands":
        return 1
    return math.ceil(sum(0.45 + 0.058 * len(trace.label) for trace in panel.traces) / 7.8)


def marks(axes, events, begin, end):
    """Draws thin lines through all panels, and the events of the scenario above them."""
    free = begin
    axis = axes[0]
    for event in events:
        colour = "#B3261E" if event["kind"] == "fault" else SOFT
        for each in axes:
            each.axvline(event["time"], color=colour, linewidth=0.6, linestyle=(0, (1, 2)), zorder=1.5)
        length = (0.062 * len(event["text"]) + 0.1) * (end - begin) / axis.inches
        if event["kind"] != "manoeuvre" and event["time"] >= free and event["time"] + length < end + 0.1 * (end - begin):
            axis.annotate(event["text"], (event["time"], 1.0), xycoords=("data", "axes fraction"), xytext=(2, 2.5),
                          textcoords="offset points", fontsize=7, color=colour)
            free = event["time"] + length


def draw(title, drawn, events):
    """matplotlib's figure."""
    layout = drawn.layout("run")
    data = drawn.data
    heights = [BAND * len(panel.traces) if panel.kind == "bands" else UNIT * panel.height for panel in layout.panels]
    said = any(event["kind"] != "manoeuvre" for event in events)
    head = (0.16 if said else 0.04) if layout.panels[0].kind == "bands" else 0.36 if said else 0.22
    over = [LINE * (legend_lines(panel) - 1) for panel in layout.panels]
    sheet = pictures.Sheet({"id": "run", "title": title}, {}, heights, gaps=[GAP + more for more in over[1:]], left=1.0,
                           head=head + over[0], title=title)
    axes = []
    for n, panel in enumerate(layout.panels):
        axis = sheet.panel(n, share=axes[0] if axes else None)
        axes.append(axis)
        axis.set_xlim(float(data["time"][0]), float(data["time"][-1]))
        if panel.kind == "bands":
            bands(axis, panel, data)
        else:
            lines(axis, layout, panel, data)
        axis.tick_params(labelbottom=n == len(layout.panels) - 1)
    axes[-1].set_xlabel(layout.xlabel)
    marks(axes, events, float(data["time"][0]), float(data["time"][-1]))
    return sheet.figure


def fingerprint(title, drawn, events):
    """Fingerprint of the content of the picture, independent of the program that draws it."""
    parts = [title, [dataclasses.asdict(panel) for panel in drawn.panels], events]
    sums = hashlib.sha256(json.dumps(parts, sort_keys=True).encode())
    for name, values in drawn.data.columns.items():
        sums.update(name.encode() + values.astype("<f4").tobytes())
    return f"sha256 {sums.hexdigest()}"


def save(base, title, drawn, events, formats):
    """Writes the files that are required of base.png and base.svg, and returns the octets of the PNG, which are the same for the same picture."""
    figure = draw(title, drawn, events)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None, "Description": fingerprint(title, drawn, events)})
    if "png" in formats:
        base.with_name(base.name + ".png").write_bytes(buffer.getvalue())
    if "svg" in formats:
        style.save_as(figure, base.with_name(base.name + ".svg"))
    return buffer.getvalue()
