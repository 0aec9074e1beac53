"""Draws the pictures of the paper report, one for each figure, arranged as in the paper: draw() writes PNG and SVG.

The curves follow the layouts of figures.py. This file adds the parts for print only: enlarged stretches, shades, tables as pictures.
Needs matplotlib.
"""
import math
import re

import numpy
from matplotlib import cm, colormaps, colors, ticker
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

import style
from figures import Data, InputError, Trace
from map import digits, ink, label as minus
from style import BLACK, BLUE, GREEN, ORANGE, PURPLE

WIDTH = 9.0          # [in]
DPI = 200            # [1/in]
GREY = "#999999"     # the variant `ideal` in addition to `real`
SHADE = "#F3EFD8"    # conditions that are valid for a part of the run
BOX = {"facecolor": "#FFFFFF", "edgecolor": "none", "pad": 1.5, "alpha": 0.85}
TURN = 6000.0        # [mrad] range of an error that wraps
MARKS = 9            # along a curve
LINE = 155           # [characters] of conditions
PERIODS = 2          # electrical, in an enlarged stretch
PERIOD = 60.0 / (1500.0 * 4)  # [s] electrical, at 1500 r/min

SYMBOL = re.compile(r"\b(omega|psi|i|u|k|a)_([a-z])\b")


def typeset(text):
    """Converts the plain names of the project to symbols: k_f, omega_c, m^2. A dollar sign stays a dollar sign."""
    text = SYMBOL.sub(lambda m: f"${'' if len(m[1]) == 1 else chr(92)}{m[1]}_{m[2]}$", text.replace("$", r"\$"))
    return re.sub(r"\bus\b", "\N{MICRO SIGN}s", re.sub(r"\^(\d)\b", r"$^\1$", text))


def conditions(figure, manifest):
    """The conditions that are common to all runs of a figure (or all its rows), with line breaks between conditions."""
    shown = [run for run in figure.get("runs", []) if run.get("condition")]
    shown = shown or [row for row in manifest.get("rows", []) if row["figure"] == figure["id"] and row.get("condition")]
    parts = [re.split(r"; |, (?![\d.]+(?:,| A))", one["condition"]) for one in shown if one["flavour"] != "ideal"]
    lines = [""]
    for part in parts[0] if parts else []:
        if all(part in other for other in parts):
            if len(lines[-1]) + len(part) > LINE:
                lines.append("")
            lines[-1] += f"{part}, "
    return [line.rstrip(", ") for line in lines if line]


class Sheet:
    """A picture during drawing: title, conditions, and a grid of panels below them; lengths in inches."""

    def __init__(self, figure, manifest, heights, columns=1, gaps=None, head=0.3, left=0.85, right=0.2, between=0.75,
                 note="", title=None):
        style.pyplot(**{"font.size": 8.5, "legend.fontsize": 8, "axes.titlesize": 9})
        self.id = figure["id"]
        below = conditions(figure, manifest) + ([note] if note else [])
        self.gaps = gaps or [0.24] * (len(heights) - 1)
        self.heights, self.left, self.between = heights, left, between
        self.under = 0.36 + 0.15 * len(below)  # the title, down from the upper edge
        self.top = self.under + head
        self.height = self.top + sum(heights) + sum(self.gaps) + 0.52
        self.wide = (WIDTH - left - right - between * (columns - 1)) / columns
        self.figure = Figure(figsize=(WIDTH, self.height), dpi=DPI)
        FigureCanvasAgg(self.figure)  # this renderer can measure the size of text
        whose = f"{figure['paper']} " if figure.get("paper") else "Beyond the paper:"
        self.figure.text(0.5, 1.0 - 0.10 / self.height, typeset(title or f"{whose} {figure['title']}"), fontsize=11, ha="center",
                         va="top")
        for n, line in enumerate(below):
            self.figure.text(0.5, 1.0 - (0.35 + 0.15 * n) / self.height, typeset(line), fontsize=7.5, ha="center",
                             va="top", color="#444444")

    def panel(self, row, column=0, span=1, share=None, indent=0.0):
        """Axes at this place of the grid; `indent` is left free on their left."""
        above = self.top + sum(self.heights[:row]) + sum(self.gaps[:row])
        x = self.left + column * (self.wide + self.between) + indent
        width = self.wide * span + self.between * (span - 1) - indent
        axis = self.figure.add_axes([x / WIDTH, 1.0 - (above + self.heights[row]) / self.height, width / WIDTH,
                                     self.heights[row] / self.height], sharex=share)
        axis.inches = width
        return axis

    def legend(self, axis, columns):
        """Legend of all panels, between the title and the panels."""
        self.figure.legend(handles=axis.get_legend_handles_labels()[0], loc="upper center", ncol=columns,
                           bbox_to_anchor=(0.5, 1.0 - (self.under + 0.06) / self.height), handlelength=2.6,
                           borderaxespad=0.0)

    def save(self, folder):
        self.figure.align_ylabels()
        style.save(self.figure, folder / f"{self.id}.png")


def letters(axes):
    for letter, axis in zip("abcdefghijklmnop", axes):
        axis.annotate(f"({letter})", (0.0, 1.0), xytext=(0.0, 4.0), xycoords="axes fraction",
                      textcoords="offset points")


def legend(axis, handles=None, title="", indent=0.3):
    """Writes the legend above the axes, on the right of the panel's letter, in as many lines as necessary, and a title above it."""
    handles = handles or axis.get_legend_handles_labels()[0]
    renderer = axis.figure.canvas.get_renderer()
    for lines in range(1, len(handles) + 1):
        shown = axis.legend(handles=handles, loc="lower left", bbox_to_anchor=(indent / axis.inches, 1.0),
                            ncol=math.ceil(len(handles) / lines), handlelength=2.0, columnspacing=1.0,
                            borderaxespad=0.2,
                            borderpad=0.0, handletextpad=0.4, labelspacing=0.25)
        if shown.get_window_extent(renderer).width <= (axis.inches + 0.05 - indent) * DPI:
            break
    if title:
        axis.set_title(typeset(title), fontweight="bold", pad=5 + 12 * lines)


def part(data, x, column, window=None):
    """The finite points of the column, only those in the window [from, to] if there is one."""
    xs, ys = data[x], data[column]
    keep = numpy.isfinite(ys)
    if window:
        keep &= (xs >= window[0]) & (xs <= window[1])
    return xs[keep], ys[keep]


def curve(axis, data, x, trace, window=None, **look):
    xs, ys = part(data, x, trace.column, window)
    if not len(xs):
        return  # the run was shorter
    half = trace.wraps or (math.pi if data.units[trace.column] == "rad" else 0.0)
    if half:  # no line where a wrapped angle jumps
        jumps = numpy.flatnonzero(numpy.abs(numpy.diff(ys)) > half) + 1
        xs, ys = numpy.insert(xs, jumps, xs[jumps]), numpy.insert(ys, jumps, numpy.nan)
    look = {"color": trace.colour, "linewidth": 1.0, **(style.WANTED if trace.dashed else {}), **look}
    line, = axis.plot(*style.outline(xs.tolist(), ys.tolist(), most=int(axis.inches * DPI)), label=typeset(trace.label),
                      **look)
    if trace.mark:
        marks(axis, line, trace.mark, xs, ys)


def marks(axis, line, mark, xs, ys):
    """Marks at intervals along a curve, at the mean of the surrounding values; each kind of mark has different places."""
    line.set(marker=mark, markevery=[], markersize=4.4, markeredgecolor="#FFFFFF",
             markeredgewidth=0.5)  # for the legend
    scaled = numpy.log(xs) if axis.get_xscale() == "log" else xs
    goals = scaled[0] + (numpy.arange(MARKS) + "os^D".find(mark) / 4 + 0.1) / MARKS * (scaled[-1] - scaled[0])
    at = numpy.searchsorted(scaled, goals)
    around = len(xs) // 400
    axis.plot(xs[at], [ys[max(i - around, 0):i + around + 1].mean() for i in at], linestyle="", marker=mark,
              markersize=4.4,
              color=line.get_color(), markeredgecolor="#FFFFFF", markeredgewidth=0.5, zorder=line.get_zorder() + 0.4,
              label="_")


def grouped(axis, data, layout, panel, window=None):
    """Draws all curves of a panel. The other traces determine the range of the axis if a position error covers whole turns; a note then
    names the trace that exceeds the axis."""
    if layout.log_x:
        axis.set_xscale("log")
    if panel.log_y:
        axis.set_yscale("log")
    for n, trace in enumerate(panel.traces):
        curve(axis, data, layout.x, trace, window, zorder=2.9 if trace.dashed else 2.0 + 0.1 * n)
    axis.set_ylabel(typeset(panel.ylabel))
    reach = {trace.label: part(data, layout.x, trace.column, window)[1] for trace in panel.traces}
    reach = {label: ys for label, ys in reach.items() if len(ys)}
    wild = [label for label, ys in reach.items() if panel.ylabel == "position error [mrad]" and numpy.ptp(ys) > TURN]
    held = [ys for label, ys in reach.items() if label not in wild]
    if wild and held:
        least, most = min(map(numpy.min, held)), max(map(numpy.max, held))
        axis.set_ylim(least - 0.35 * (most - least), most + 0.35 * (most - least))
        axis.text(0.99, 0.04, typeset(f"{'; '.join(wild)}: wraps; beyond the axis"), transform=axis.transAxes,
                  ha="right", fontsize=7.5,
                  bbox=BOX, zorder=5)


def span(data, layout):
    return float(data[layout.x][0]), float(data[layout.x][-1])


def stack(sheet, data, layout, column=0, shade=()):
    """The panels of a layout below each other in one column of the sheet, their x axis shared."""
    axes = []
    for n, panel in enumerate(layout.panels):
        axis = sheet.panel(n, column, share=axes[0] if axes else None)
        grouped(axis, data, layout, panel)
        axis.tick_params(labelbottom=n == len(layout.panels) - 1)
        for begin, end in shade:
            axis.axvspan(begin, end, color=SHADE, linewidth=0, zorder=0)
        axes.append(axis)
    axes[-1].set_xlabel(layout.xlabel)
    axes[0].set_xlim(*span(data, layout))
    said = set()
    for axis in axes:  # the panel has a legend if this differs from those above
        handles, labels = axis.get_legend_handles_labels()
        if not said.issuperset(labels):
            legend(axis, handles, layout.title if axis is axes[0] else "")
        said.update(labels)
    return axes


def heights(layout, unit):
    return [unit * panel.height for panel in layout.panels]


def shaded(figure):
    """From each first event to each second."""
    times = [event["time"] for event in figure.get("events", [])]
    return list(zip(times[::2], times[1::2]))


def side_by_side(figure, layouts, data, manifest, unit=1.35, shade=(), note=""):
    sheet = Sheet(figure, manifest, heights(layouts[0], unit), columns=len(layouts), note=note, head=0.7, between=0.85)
    columns = [stack(sheet, data, layout, n, shade) for n, layout in enumerate(layouts)]
    letters([axis for row in zip(*columns) for axis in row])
    return sheet


def enlarged(axis, data, column, seconds):
    """The last seconds of a column, on an axis in milliseconds that begins at a round time."""
    end = math.floor(100.0 * (part(data, "time", column)[0][-1] + 1e-3)) / 100.0
    begin = end - seconds
    axis.set_xlim(begin, end)
    ticks = numpy.arange(0.0, seconds + 1e-6, 0.005 if seconds < 0.03 else 0.01)
    axis.set_xticks(begin + ticks, [f"{1e3 * tick:.3g}" for tick in ticks])
    axis.set_xlabel(f"time after {begin:.2f} s [ms]")
    return begin, end


def fig04(figure, layouts, data, manifest):
    layout, = layouts
    sheet = Sheet(figure, manifest, [2.9], columns=2, between=0.8)
    axes = [sheet.panel(0, n) for n in range(2)]
    for axis, panel in zip(axes, layout.panels):
        grouped(axis, data, layout, panel)
        axis.set_xlim(*span(data, layout))
        axis.set_xlabel(layout.xlabel)
        legend(axis)
    letters(axes)
    return sheet


def fig05(figure, layouts, data, manifest):
    layout, = layouts
    sheet = Sheet(figure, manifest, [2.0, 1.6], note="the last 60 ms, some four electrical periods")
    axes = [sheet.panel(n) for n in range(2)]
    for axis, panel in zip(axes, layout.panels):
        grouped(axis, data, layout, panel, enlarged(axis, data, panel.traces[0].column, 0.06))
    axes[0].tick_params(labelbottom=False)
    axes[0].set_xlabel("")
    axes[1].set_ylim(min(0.45, axes[1].get_ylim()[0]), 0.51)
    axes[1].axhline(0.5, **style.WANTED, color=BLACK, label="bound, 1/2")
    for axis in axes:
        legend(axis)
    letters(axes)
    return sheet


def fig08(figure, layouts, data, manifest):
    return side_by_side(figure, layouts, data, manifest, unit=2.0)


def ideal(axis, data, trace, window=None, label="_"):
    """The same run with inverter and sensors without error, thin and grey."""
    column = data.need(trace.column.replace("_real_", "_ideal_"), data.units[trace.column])
    curve(axis, data, "time", Trace(column, label, GREY), window, linewidth=0.6, zorder=2.8)


def profile(figure, layouts, data, manifest):
    """Speed and position error over the whole profile; between these panels, enlarged details of the position and its error."""
    layout, = layouts
    speed, position, error = layout.panels
    sheet = Sheet(figure, manifest, [1.7, 1.6, 2.1], columns=2, gaps=[0.68, 0.68], between=0.85,
                  note=f"(b), (c): {PERIODS} electrical periods at the end")
    axes = [sheet.panel(0, span=2), sheet.panel(1, 0), sheet.panel(1, 1), sheet.panel(2, span=2)]
    for axis, panel in zip(axes[1:3], (position, error)):
        window = enlarged(axis, data, position.traces[0].column, PERIODS * PERIOD)
        grouped(axis, data, layout, panel, window)
    for axis, panel in zip(axes[::3], (speed, error)):
        grouped(axis, data, layout, panel)
        axis.set_xlim(*span(data, layout))
        axis.set_xlabel(layout.xlabel)
    axes[1].set_ylim(-3.4, 3.4)
    axes[1].lines[0].set_linewidth(2.6)  # so that the true angle stays visible below its estimate
    for trace in error.traces:
        if not trace.dashed:
            ideal(axes[2], data, trace, window)
    for axis in (axes[0], axes[1], axes[3]):
        legend(axis)
    legend(axes[2], [Line2D([], [], color=GREY, label="ideal inverter and sensors", linewidth=0.8)])
    letters(axes)
    return sheet


def ideal(axis, data, trace, window):
    """The same run with inverter and sensors without error, thin and grey."""
    column = data.need(trace.column.replace("_real_", "_ideal_"), data.units[trace.column])
    curve(axis, data, "time", Trace(column, "_", GREY), window, linewidth=0.8, zorder=1.9)


def fig12(figure, layouts, data, manifest):
    layout, = layouts
    sheet = Sheet(figure, manifest, heights(layout, 1.6), note="shaded: compensation on")
    letters(stack(sheet, data, layout, shade=shaded(figure)))
    return sheet


def fig17(figure, layouts, data, manifest):
    return side_by_side(figure, layouts, data, manifest, shade=shaded(figure), note="shaded: rated load on")


def fig15(figure, layouts, data, manifest):
    """Draws the loops at both bandwidths; below them the loops whose inverter is not compensated, and the dead time that each of them
    tolerates."""
    loops, loss = layouts[:2], layouts[2]
    table = Data.read(data.path.with_name("fig15_dead_time.csv"))
    sheet = Sheet(figure, manifest, heights(loops[0], 1.1) + [1.7, 0.75], columns=2, gaps=[0.24, 0.24, 1.1, 0.85],
                  head=0.7,
                  between=0.85)
    columns = [stack(sheet, data, layout, n) for n, layout in enumerate(loops)]
    lost = [sheet.panel(3, 0), sheet.panel(3, 1)]
    for axis, panel in zip(lost, (loss.panels[0], loss.panels[-1])):
        grouped(axis, data, loss, panel)
        axis.set_xlim(*span(data, loss))
        axis.set_xlabel(loss.xlabel)
    handles = lost[0].get_legend_handles_labels()[0]
    legend(lost[0], handles[:2], loss.title)
    legend(lost[1], handles[2:])
    bears = sheet.panel(4, span=2, indent=1.05)
    dead_time(bears, table)
    letters([axis for row in zip(*columns) for axis in row] + lost + [bears])
    return sheet


def dead_time(axis, table):
    names = {"b200_wc0": "200 rad/s, conventional", "b200_wc25": "200 rad/s, omega_c 25 rad/s",
             "b100_wc0": "100 rad/s, conventional"}
    runs, lost = table["run"], table[table.need("lost", "-")] > 0.5
    times = table[table.need("dead_time", "us")]
    order = list(dict.fromkeys(runs))
    row = numpy.array([order.index(run) for run in runs])
    axis.scatter(times[~lost], row[~lost], s=34, color=GREEN, marker="o", label="held", zorder=3)
    axis.scatter(times[lost], row[lost], s=34, color=ORANGE, marker="x", linewidths=1.8, label="lost", zorder=3)
    axis.set_yticks(range(len(order)), [typeset(names.get(run, run)) for run in order])
    axis.set_ylim(len(order) - 0.5, -0.5)
    axis.set_xlabel(typeset("dead time lost of each edge, none of it compensated [us]"))
    legend(axis)


LOOK = {(100.0, 0.0): (BLUE, "o", "-"), (100.0, 5.0): (BLUE, "s", (0, (4, 2))), (200.0, 0.0): (ORANGE, "^", "-"),
        (200.0, 5.0): (ORANGE, "D", (0, (4, 2)))}


def fig16(figure, _, data, manifest):
    """Draws deviations and overshoots over omega_c: position above, speed below; those with ideal inverter thin and grey."""
    sheet = Sheet(figure, manifest, [1.9, 1.9], columns=4, gaps=[0.55], between=0.47, left=0.62,
                  head=0.5, note="grey: the same with an ideal inverter and sensors")
    flavour, lost = numpy.array(data["flavour"]), data[data.need("lost", "-")] > 0.5
    groups = {(bandwidth, load): (data[data.need("bandwidth", "rad/s")] == bandwidth) & (data[data.need("load",
                                                                                                        "N m")] == load)
              for bandwidth, load in LOOK}
    x = data[data.need("omega_c", "rad/s")]
    axes = []
    for row, (quantity, unit) in enumerate((("", "mrad"), ("speed_", "r/min"))):
        for n, (name, title) in enumerate((("sd_100", "SD at 100 r/min"), ("sd_1500", "SD at 1500 r/min"),
                                           ("overshoot_accelerating", "overshoot, accelerating"),
                                           ("overshoot_decelerating", "overshoot, decelerating"))):
            axis = sheet.panel(row, n)
            y = data[data.need(quantity + name, unit)]
            for (bandwidth, load), (colour, mark, dashes) in LOOK.items():
                for shown, look in (("ideal", {"color": GREY, "linewidth": 0.7, "markersize": 2.0, "zorder": 2}),
                                    ("real", {"color": colour, "linewidth": 1.1, "markersize": 4.0, "zorder": 3})):
                    at = numpy.flatnonzero(groups[bandwidth, load] & (flavour == shown) & ~lost)
                    at = at[numpy.argsort(x[at])]
                    axis.plot(x[at], y[at], marker=mark, linestyle=dashes, **look,
                              label=f"{bandwidth:g} rad/s, {load:g} N m" if shown == "real" else "_")
            axis.set_ylim(bottom=0.0)
            axis.set_title(title, fontsize=8.5, pad=4)
            axis.set_xlim(left=0.0 - 0.03 * x.max())
            if n == 0:
                axis.set_ylabel(f"{'speed' if quantity else 'position'} [{unit}]")
            if row == 1:
                axis.set_xlabel(typeset("omega_c [rad/s]"))
            axes.append(axis)
    sheet.legend(axes[0], 4)
    return sheet


VARIANTS = {"uncompensated": (ORANGE, "s", "no compensation"), "printed": (PURPLE, "^", "(14) as printed, per axis"),
            "lagless": (BLUE, "o", "lagless: exact lag, vector sigmoid"),
            "conventional": (ORANGE, "s", "conventional"), "feedforward": (BLUE, "o",
                                                                           "feed-forward, omega_c = bandwidth/4"),
            "torque_feedforward": (GREEN, "^", "the same with torque feed-forward")}


def beyond(figure, data, manifest, x, xlabel, panels, log=False):
    """Draws panels of [(column, unit, ylabel)] over x, one column of panels for each load. The real inverter has thick lines, the ideal one
    thin lines; a lost point is a cross."""
    loads = sorted(set(data[data.need("load", "N m")]))
    sheet = Sheet(figure, manifest, [1.6] * len(panels), columns=len(loads), between=0.7,
                  head=0.55,
                  note="thin: ideal inverter and sensors" + ("; a cross (its height has no meaning): lost" if data["lost"].any()
                                                             else ""))
    flavour, variant = numpy.array(data["flavour"]), numpy.array(data["variant"])
    lost = data[data.need("lost", "-")] > 0.5
    xs = data[x]
    first = None
    axes = []
    for row, (column, unit, ylabel) in enumerate(panels):
        values = data[data.need(column, unit)]
        for n, load in enumerate(loads):
            axis = sheet.panel(row, n, share=first)
            first = first or axis
            for order, name in enumerate(dict.fromkeys(data["variant"])):
                colour, mark, label = VARIANTS.get(name, (BLACK, "D", name))
                for shown, look in (("ideal", {"linewidth": 0.6, "markersize": 0.0, "zorder": 2}),
                                    ("real", {"linewidth": 1.2, "markersize": 6.5 - 1.3 * order, "zorder": 3})):
                    at = numpy.flatnonzero((variant == name) & (flavour == shown) & (data["load"] == load))
                    at = at[numpy.argsort(xs[at])]
                    good = at[~lost[at] & numpy.isfinite(values[at])]
                    y = numpy.abs(values[good]) if log else values[good]
                    axis.plot(xs[good], y, marker=mark, color=colour, **look,
                              label=typeset(label) if shown == "real" else "_")
                    if shown == "real":
                        for point in xs[at[lost[at]]]:
                            axis.plot([point], [0.95 - 0.07 * order], marker="x", markersize=6, markeredgewidth=1.6,
                                      color=colour, clip_on=False,
                                      transform=axis.get_xaxis_transform(), zorder=4)
            if log:
                axis.set_yscale("log")
                axis.yaxis.set_minor_locator(ticker.NullLocator())
            elif values[numpy.isfinite(values)].min() >= 0.0:
                axis.set_ylim(bottom=0.0)
            if n == 0:
                axis.set_ylabel(typeset(ylabel))
            if row == 0:
                axis.set_title(f"{'no load' if load == 0 else f'{load:g} N m'}", fontsize=9, fontweight="bold", pad=4)
            axis.tick_params(labelbottom=row == len(panels) - 1)
            if row == len(panels) - 1:
                axis.set_xlabel(xlabel)
            axes.append(axis)
    sheet.legend(axes[0], 3)
    letters(axes)
    return sheet


def beyond_speed(figure, _, data, manifest):
    return beyond(figure, data, manifest, data.need("speed", "r/min"), "speed [r/min]",
                  [("mean", "mrad", "mean error [mrad]"), ("sd", "mrad", "SD of the error [mrad]")])


def beyond_bandwidth(figure, _, data, manifest):
    return beyond(figure, data, manifest, data.need("bandwidth", "rad/s"), "closed-loop bandwidth [rad/s]",
                  [("steady_accelerating", "mrad", "|steady error|,\naccelerating [mrad]"),
                   ("peak_accelerating", "mrad", "peak error,\naccelerating [mrad]"),
                   ("peak_decelerating", "mrad", "peak error,\ndecelerating [mrad]"),
                   ("sd_100", "mrad", "SD at\n100 r/min [mrad]")], log=True)


def map_block(axis, rows, speeds):
    """Draws the empty field of a block of the map."""
    axis.set(xlim=(0, len(speeds)), ylim=(len(rows), 0))
    axis.grid(False)
    axis.set_xticks([c + 0.5 for c in range(len(speeds))], [minus(f"{speed:g}") for speed in speeds], fontsize=7)
    axis.set_yticks([r + 0.5 for r in range(len(rows))], [typeset(row.replace("-", "\N{MINUS SIGN}")) for row in rows],
                    fontsize=7.5)
    for side in axis.spines.values():
        side.set_visible(False)
    axis.axvline(sum(speed < 0 for speed in speeds), color=BLACK, linewidth=0.8)


def map_fields(axis, fields, norm, colour):
    """Each field has a colour and a number; a field without a number is hatched."""
    axis.pcolormesh(numpy.ma.masked_invalid(fields), norm=norm, cmap=colour, edgecolors="#FFFFFF", linewidth=0.6)
    inks = [[ink(*field[:3]) for field in line] for line in colour(norm(numpy.nan_to_num(fields)))]
    for (row, place), value in numpy.ndenumerate(fields):
        if numpy.isfinite(value):
            axis.text(place + 0.5, row + 0.53, digits(value), ha="center", va="center", fontsize=6, color=inks[row][place])
        else:
            axis.add_patch(Rectangle((place, row), 1, 1, facecolor="#FFFFFF", edgecolor="#777777", hatch="/////",
                                     linewidth=0.0))


def map_scale(sheet, beside, norm, colour):
    bar = sheet.figure.add_axes([beside.x1 + 0.12 / WIDTH, beside.y0, 0.11 / WIDTH, beside.height])
    scale = sheet.figure.colorbar(cm.ScalarMappable(norm, colour), cax=bar)
    scale.solids.set(rasterized=False, edgecolor="face")
    bar.tick_params(labelsize=6.5)
    bar.grid(False)
    bar.yaxis.set_major_formatter(ticker.FuncFormatter(lambda v, _: minus(f"{v:g}")))
    bar.yaxis.set_minor_locator(ticker.NullLocator())


def beyond_map(figure, _, data, manifest):
    """Mean, SD and peak over deviations and speeds, without and with adaptation, one block for each load. A field in which the rotor was
    lost is hatched."""
    rows = list(dict.fromkeys(data["deviation"]))
    speeds, loads = sorted(set(data[data.need("speed", "r/min")])), sorted(set(data[data.need("load", "N m")]))
    lost = data[data.need("lost", "-")] > 0.5
    columns = list(dict.fromkeys(data["adaptation"]))
    adaptation = numpy.array(data["adaptation"])
    high = 0.19 * len(rows)
    sheet = Sheet(figure, manifest, [high] * (3 * len(columns)), columns=len(loads), gaps=[0.45] * (3 * len(columns) - 1),
                  left=1.25, right=0.7, between=0.1,
                  note="estimated minus true angle, electrical; negative speeds turn backwards; hatched: not locked")
    blocks = [(column, title, diverging, on) for column, title, diverging in (
        ("mean", "mean [mrad]", True), ("sd", "standard deviation [mrad]", False), ("peak", "peak [mrad]", False))
        for on in columns]
    for block, (column, title, diverging, on) in enumerate(blocks):
        values = data[data.need(column, "mrad")]
        largest = max(numpy.abs(values[~lost]).max(initial=0.0), 10.0)
        norm = (colors.SymLogNorm(1.0, vmin=-largest, vmax=largest, base=10) if diverging
                else colors.LogNorm(0.1, largest, clip=True))
        colour = colormaps["PuOr_r" if diverging else "Blues"]
        for n, load in enumerate(loads):
            axis = sheet.panel(block, n)
            map_block(axis, rows, speeds)
            axis.tick_params(length=0, labelleft=n == 0)
            fields = numpy.full((len(rows), len(speeds)), numpy.nan)
            for at in numpy.flatnonzero((data["load"] == load) & (adaptation == on) & ~lost):
                fields[rows.index(data["deviation"][at]), speeds.index(data["speed"][at])] = values[at]
            map_fields(axis, fields, norm, colour)
            axis.set_title(f"{title}, {'no load' if load == 0 else f'{load:g} N m'}, adaptation {on}", fontsize=8.5, pad=3)
            if block == len(blocks) - 1:
                axis.set_xlabel("speed [r/min]")
        map_scale(sheet, axis.get_position(), norm, colour)
    return sheet


DRAWN = {"fig04": fig04, "fig05": fig05, "fig08": fig08, "fig10": profile, "fig11": profile, "fig12": fig12,
         "fig13": side_by_side, "fig14": side_by_side, "fig15": fig15, "fig16": fig16, "fig17": fig17,
         "beyond_speed": beyond_speed, "beyond_bandwidth": beyond_bandwidth, "beyond_map": beyond_map}


def draw(figure, layouts, data, folder, manifest):
    """Writes folder/<id>.png and .svg of one figure of the manifest, whose layouts(figure, data) these are."""
    if figure["id"] not in DRAWN:
        raise InputError(f"report.json: figures: id: no picture of `{figure['id']}` is known")
    DRAWN[figure["id"]](figure, layouts, data, manifest).save(folder)
