"""Makes index.html of the paper report, with verdicts, pictures, conditions, and plots with zoom. The file contains style, script, pictures
and data, so that it needs no network. uPlot draws the plots if it was found (tools/get-uplot)."""
import base64
import dataclasses
import functools
import gzip
import html
import json
import math
import os
import pathlib
import re
import string
import struct

import numpy

import style

PARTS = pathlib.Path(__file__).resolve().with_name("page")
RUN_UNITS = {"bandwidth": "rad/s", "omega_c": "rad/s", "kp": "rad/s", "ki": "rad/s²", "load": "N m", "gain": "V",
             "omega_s": "rad/s"}
SYMBOLS = {"omega_c": "ω<sub>c</sub>", "omega_s": "ω<sub>s</sub>", "kp": "k<sub>p</sub>", "ki": "k<sub>i</sub>",
           "gain": "k<sub>s</sub>"}
OPEN_ROWS = 40  # [lines] a longer table is folded


# ---- data for uPlot: each column as whole multiples of a power of ten, which compresses well ----

def pack(values, logarithmic=False):
    """({base, exponent}, octets) of a column. Value = (base + code - 1) 10^exponent; code 0 is NaN. The step is
    1/20000 to 1/200000 of the column's range, on a logarithmic axis at most 1/100 of its least number. Octets: the
    codes' differences, sign in the lowest bit, as four planes of n octets, lowest first."""
    finite = numpy.isfinite(values)
    some = values[finite] if finite.any() else numpy.zeros(1)
    low = float(some.min())
    span = float(some.max()) - low or abs(low) or 1.0
    exponent = math.floor(math.log10(span / 20000.0))
    if logarithmic and low > 0.0:
        finest = math.ceil(math.log10(span)) - 9  # 10^9 fits into 31 bits
        exponent = max(min(exponent, math.floor(math.log10(low)) - 2), finest)
    multiples = numpy.zeros(len(values), dtype=numpy.int64)
    multiples[finite] = numpy.rint(scaled(values[finite], -exponent))
    base = int(multiples[finite].min()) if finite.any() else 0
    steps = numpy.diff(numpy.where(finite, multiples - base + 1, 0), prepend=0)
    folded = ((steps << 1) ^ (steps >> 63)).astype("<u4")
    return {"base": base, "exponent": exponent}, folded.view(numpy.uint8).reshape(-1, 4).T.tobytes()


def scaled(values, exponent):
    """values * 10^exponent. For negative exponents it divides by the exact 10^n, which gives the nearest float; a multiplication by the
    inverse does not."""
    return values * 10.0 ** exponent if exponent >= 0 else values / 10.0 ** -exponent


def axis_of(values):
    """Start and step of an evenly spaced axis, or else all of its values."""
    count = len(values)
    if count > 1:
        start, step = float(values[0]), round((float(values[-1]) - float(values[0])) / (count - 1), 12)
        if step > 0 and numpy.abs(start + step * numpy.arange(count) - values).max() < 1e-3 * step:
            return {"start": start, "step": step, "count": count}
    return {"values": [float(f"{value:.9g}") for value in values], "count": count}


def plain(label):
    """matplotlib's $i_q$ and \\omega as plain text."""
    text = re.sub(r"\\(hat|mathrm)\b", "", re.sub(r"[${}]", "", label))
    return re.sub(r"\\?omega(?=_|\b)", "ω", text).replace("\\", "").replace("\n", " ")


def plots(layouts, data):
    """One dictionary per layout: what page.js needs to draw it."""
    result = []
    for layout in layouts:
        if not layout.interactive:
            continue
        columns, octets = {}, []
        for panel in layout.panels:
            for trace in panel.traces:
                if trace.column not in columns:
                    meta, packed = pack(data.columns[trace.column], panel.log_y)
                    columns[trace.column] = {"index": len(octets), "unit": data.units[trace.column], **meta}
                    octets.append(packed)
        panels = [dataclasses.asdict(panel) for panel in layout.panels]
        for panel in panels:
            for text in [panel] + panel["traces"]:
                text.update({key: plain(text[key]) for key in ("ylabel", "title", "label") if key in text})
        result.append({
            "id": layout.id, "xlabel": plain(layout.xlabel), "title": plain(layout.title), "log": layout.log_x,
            "x": axis_of(data.columns[layout.x]), "x_unit": data.units[layout.x], "columns": columns, "panels": panels,
            "data": base64.b64encode(gzip.compress(b"".join(octets), 9, mtime=0)).decode("ascii"),
        })
    return result


# ---- text ----

def escape(text):
    return html.escape(str(text), quote=True)


def number(value):
    """Four significant digits, as an engineer writes them."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, (int, float)):
        return escape(value)
    if not math.isfinite(value):
        return str(value)
    if value != 0 and not 1e-3 <= abs(value) < 1e6:
        mantissa, exponent = f"{value:.3e}".split("e")
        return f"{trimmed(mantissa)}e{int(exponent)}".replace("-", "−")
    text = f"{value:.{max(0, 3 - math.floor(math.log10(abs(value))))}f}" if value else "0"
    return trimmed(text).replace("-", "−")


def trimmed(text):
    return text.rstrip("0").rstrip(".") if "." in text else text


def unit(text):
    return "" if text in ("-", "text") else escape(text)


def verdict(name):
    sign, kind, _ = style.VERDICTS[name]
    return f'<span class="verdict {kind}"><span class="sign">{sign}</span> {escape(name)}</span>'


def leading(flavour):
    """A key that sorts flavours: first real inverter and sensors, then formulas, then ideal ones. It also accepts a tuple (flavour,
    ...)."""
    flavour = flavour if isinstance(flavour, str) else flavour[0]
    return {"real": 0, "formula": 1, "ideal": 2}.get(flavour, 3), flavour


def claims(rows):
    """(row, ideal row or None) of each claim: most were measured with a real inverter and with an ideal one."""
    groups = {}
    for row in rows:
        key = row["id"][:-len(row["flavour"]) - 1] if row["id"].endswith("." + row["flavour"]) else row["id"]
        groups.setdefault(key, {})[row["flavour"]] = row
    for group in groups.values():
        first = group.pop(min(group, key=leading))
        yield first, group.pop("ideal", None)
        yield from ((row, None) for row in group.values())


def heading(name, of_unit="", kind="number"):
    """Column head: the symbol where there is one, and the unit."""
    text = SYMBOLS.get(name) or escape(re.sub(r"\bsd\b", "SD", name.replace("_", " ")))
    bracket = f' <span class="unit">[{unit(of_unit)}]</span>' if unit(of_unit) else ""
    return f'<th class="{kind}">{text}{bracket}</th>'


def cell(kind, text, label=""):
    name = f' data-label="{label}"' if label else ""  # shown if the window is too narrow for the head of the table
    return f'<td class="{kind}"{name}>{text}</td>'


def ours_cells(row, ideal):
    """The cells of the measured values: with the real inverter or by formula, and beside them with the ideal inverter."""
    if row["flavour"] == "ideal":
        row, ideal = None, row
    return "".join(
        f'<td class="{kind}" data-label="{label}" data-row="{escape(each["id"])}">{number(each["ours"])}</td>' if each
        else cell("none", "") for each, label, kind in ((row, "ours", "number ours"), (ideal, "ideal", "number")))


def verdict_cell(row, ideal, note="", ideal_note=""):
    text = verdict(row["verdict"]) + note
    if ideal and (ideal["verdict"] != row["verdict"] or ideal_note != note):
        text += f'<span class="other">ideal: {verdict(ideal["verdict"])}{ideal_note}</span>'
    return cell("judged", text)


def counts(rows):
    parts = []
    flavours = sorted({row["flavour"] for row in rows}, key=leading)
    for name, (_, kind, meaning) in style.VERDICTS.items():
        of = [row["flavour"] for row in rows if row["verdict"] == name]
        if of:
            split = ", ".join(f"{of.count(flavour)} {flavour}" for flavour in flavours if flavour in of)
            parts.append(f'<li class="{kind}"><b>{len(of)}</b> {verdict(name)}<small>{escape(split)}</small>'
                         f'<small>{escape(meaning)}</small></li>')
    return f'<ul class="counts">{"".join(parts)}</ul>'


def figure_name(figure):
    return figure["paper"] or "Beyond"


def verdict_table(manifest):
    body = []
    for figure in manifest["figures"]:
        rows = [row for row in manifest["rows"] if row["figure"] == figure["id"]]
        body.append(f'<tbody><tr class="group"><th colspan="6" scope="rowgroup"><a href="#{figure["id"]}">'
                    f'{escape(figure_name(figure))}</a> {escape(figure["title"])}</th></tr>')
        for row, ideal in claims(rows):
            body.append(f'<tr>{cell("claim", escape(row["claim"]))}{cell("number", number(row["paper"]), "paper")}'
                        f'{ours_cells(row, ideal)}{cell("unit", unit(row["unit"]))}{verdict_cell(row, ideal)}</tr>')
        body.append("</tbody>")
    return ('<table class="verdicts"><thead><tr><th>claim</th><th>paper</th><th>ours</th><th>ours, ideal</th>'
            f'<th>unit</th><th>verdict</th></tr></thead>{"".join(body)}</table>')


def expected(row):
    if row["expected"] is None:
        return "–"
    return number(row["expected"]) + (f" ± {number(row['tolerance'])}" if row["tolerance"] is not None else "")


def figure_rows(rows):
    """The table with the rows of one figure, below it the numbered reasons, each of which can belong to many rows, and the folded
    conditions."""
    reasons, body, conditions = {}, [], {}

    def note(row):
        if not row or not row["because"]:
            return ""
        return f'<sup>{reasons.setdefault(row["because"], len(reasons) + 1)}</sup>'
    for row, ideal in claims(rows):
        body.append(f'<tr>{cell("claim", escape(row["claim"]))}{cell("number", number(row["paper"]), "paper")}'
                    f'{cell("number", expected(row), "expected")}{ours_cells(row, ideal)}'
                    f'{cell("unit", unit(row["unit"]))}{verdict_cell(row, ideal, note(row), note(ideal))}</tr>')
        for each in filter(None, (row, ideal)):
            conditions.setdefault(each["condition"], []).append(each["id"].split(".", 1)[-1])
    notes = "".join(f"<li>{escape(reason)}</li>" for reason in reasons)
    listed = "".join(f"<dt>{escape(', '.join(names))}</dt><dd>{escape(text)}</dd>"
                     for text, names in conditions.items())
    notes = f'<ol class="notes">{notes}</ol>' if notes else ""
    return ('<table class="rows"><thead><tr><th>claim</th><th>paper</th><th>expected</th><th>ours</th>'
            f'<th>ours, ideal</th><th>unit</th><th>verdict</th></tr></thead><tbody>{"".join(body)}</tbody></table>'
            f'{notes}<details><summary>under which conditions each number was measured</summary><dl>{listed}</dl>'
            '</details>')


def run_table(runs):
    """The table of gains and settings of the runs of a figure; flavours with the same settings share a line."""
    if not runs:
        return ""
    keys = [key for key in dict.fromkeys(key for run in runs for key in run)
            if key not in ("name", "flavour", "condition")]
    lines = {}
    for run in runs:
        lines.setdefault((run["name"], *(run.get(key) for key in keys)), []).append(run["flavour"])
    head = "<th>run</th><th>flavour</th>" + "".join(heading(key, RUN_UNITS.get(key, "")) for key in keys)
    body = "".join(f'<tr><th scope="row">{escape(line[0])}</th><td>{escape(", ".join(flavours))}</td>'
                   + "".join(cell("number", number(value)) for value in line[1:]) + "</tr>"
                   for line, flavours in lines.items())
    texts = "".join(f"<li>{escape(text)}</li>" for text in dict.fromkeys(run["condition"] for run in runs))
    return (f'<details><summary>conditions of the {len(runs)} runs</summary><div class="wide"><table class="data">'
            f'<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div><ul class="texts">{texts}</ul>'
            '</details>')


def data_tables(data):
    """The data of a CSV as tables, one for each flavour, the real one first."""
    names = list(data.columns)
    count = len(data.columns[names[0]])
    if "flavour" not in names:
        return data_table(data, names, range(count), "all")
    flavours = sorted(set(data.columns["flavour"]), key=leading)
    return "".join(data_table(data, [name for name in names if name != "flavour"],
                              [k for k in range(count) if data.columns["flavour"][k] == flavour], flavour)
                   for flavour in flavours)


def data_table(data, names, lines, what):
    def value(name, k):
        if data.units[name] == "text":
            return f"<td>{escape(data.columns[name][k])}</td>"
        content = float(data.columns[name][k])
        if name == "lost":
            return '<td class="lost">lost</td>' if content else "<td>no</td>"
        return cell("number", number(content if math.isfinite(content) else None))
    head = "".join(heading(name, data.units[name], "text" if data.units[name] == "text" or name == "lost" else "number")
                   for name in names)
    body = "".join(f'<tr>{"".join(value(name, k) for name in names)}</tr>' for k in lines)
    is_open = " open" if what != "ideal" and len(lines) <= OPEN_ROWS else ""
    return (f'<details{is_open}><summary>all numbers as a table: {escape(what)}, {len(lines)} lines</summary>'
            f'<div class="wide tall"><table class="data"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
            '</div></details>')


# ---- the page ----

def picture(figure, folder):
    return image((folder / "pictures" / f'{figure["id"]}.png').read_bytes(), f'{figure_name(figure)}: {figure["title"]}')


def image(png, alt):
    width, height = struct.unpack(">II", png[16:24])
    return (f'<img width="{width}" height="{height}" decoding="async" alt="{escape(alt)}" '
            f'src="data:image/png;base64,{base64.b64encode(png).decode("ascii")}">')


def embedded(value):
    """JSON that is safe inside <script>."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")


def room(panel):
    """The approximate height of a panel with its legend [px]."""
    return 40 + 22 * len(panel["traces"]) if panel["kind"] == "bands" else round(70 + 150 * panel["height"])


def interactive(figure, drawn):
    parts = []
    for plot in drawn:
        height = 60 + sum(room(panel) for panel in plot["panels"])  # so that the layout does not change when the plots are drawn
        parts.append(f'<div class="plots" data-figure="{figure["id"]}" style="min-height:{height}px">'
                     '<button type="button" class="draw">draw the plots (with zoom)</button>'
                     f'<script type="application/json">{embedded({**plot, "events": figure["events"]})}</script></div>')
    return "".join(parts)


def section(figure, rows, folder, drawn, table):
    """One figure: claim, picture, rows, plots, conditions, links to the data."""
    name = pathlib.PurePosixPath(figure["csv"])
    more = sorted(path.name for path in (folder / name.parent).glob(f"{name.stem}_*.csv"))
    links = [figure["csv"]] + [str(name.parent / other) for other in more]
    links = [f'<a href="{escape(link)}">{escape(pathlib.PurePosixPath(link).name)}</a>' for link in links]
    links.append(f'<a href="pictures/{figure["id"]}.svg">the picture as SVG</a>')
    return (f'<section class="figure" id="{figure["id"]}"><h2><a href="#{figure["id"]}">{escape(figure_name(figure))}'
            f'</a> {escape(figure["title"])}</h2><p class="lead">{escape(figure["claim"])}</p>'
            f'<div class="picture">{picture(figure, folder)}</div>{figure_rows(rows)}{interactive(figure, drawn)}'
            f'{table}{run_table(figure["runs"])}<p class="links">Data: {", ".join(links)}. '
            '<a href="#verdicts">Back to the verdicts</a></p></section>')


@functools.lru_cache(maxsize=1)
def uplot():
    """{script, style, licence} of uPlot, or None if uPlot is not found."""
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache")
    for folder in (os.environ.get("UPLOT_DIR"), cache / "lagless" / "uplot"):
        try:
            if folder:
                files = (("script", "uPlot.iife.min.js"), ("style", "uPlot.min.css"), ("licence", "LICENSE"))
                return {key: (pathlib.Path(folder) / name).read_text(encoding="utf-8") for key, name in files}
        except OSError:
            pass
    return None


def condition_table(manifest):
    body = "".join(f'<tr><th scope="row">{escape(each["name"])}</th>{cell("number", number(each["value"]))}'
                   f'{cell("unit", unit(each["unit"]))}<td>{escape(each["text"])}</td></tr>'
                   for each in manifest["conditions"])
    return ('<div class="wide"><table class="data shared settings"><thead><tr><th>name</th><th class="number">value</th>'
            f'<th>unit</th><th>what it is</th></tr></thead><tbody>{body}</tbody></table></div>')


def write(folder, manifest, drawn, tables):
    """Writes folder/index.html. `drawn` and `tables` have, for each figure id, the result of plots(), and that of data_tables() or ''."""
    library = uplot()
    figures = manifest["figures"]
    if not any(drawn.values()):
        how = ""
    elif library:
        how = ("Below each picture are the same traces with zoom, with real inverter and sensors. Their values are rounded to "
               "1/20000 of each trace's range or finer; the CSV files have all digits.")
    else:
        how = "Plots with zoom are missing, because uPlot was not found: run tools/get-uplot and make the report again."
    sections = "".join(
        section(figure, [row for row in manifest["rows"] if row["figure"] == figure["id"]], folder,
                drawn[figure["id"]] if library else [], tables[figure["id"]]) for figure in figures)
    text = string.Template((PARTS / "page.html").read_text(encoding="utf-8")).substitute(
        style=(library["style"] if library else "") + (PARTS / "page.css").read_text(encoding="utf-8"),
        script=(library["script"] + "\n" if library else "") + (PARTS / "page.js").read_text(encoding="utf-8"),
        flavours="".join(f"<dt>{escape(name)}</dt><dd>{escape(line)}</dd>"
                         for name, line in sorted(manifest["flavours"].items(), key=leading)),
        links="".join(f'<a href="#{figure["id"]}" title="{escape(figure["title"])}">'
                      f'{escape(figure["paper"] or figure["id"].replace("_", " "))}</a> ' for figure in figures),
        how=escape(how), counts=counts(manifest["rows"]), verdicts=verdict_table(manifest), sections=sections,
        conditions=condition_table(manifest), seed=escape(manifest["seed"]), commit=escape(manifest["commit"]),
        seconds=number(manifest["seconds"]), licence=licence(library))
    return replaced(folder / "index.html", text)


def licence(library):
    return ("<details><summary>uPlot draws the plots; its licence</summary><pre>"
            f"{escape(library['licence'])}</pre></details>" if library else "")


def replaced(path, text):
    """Writes the file. If this fails, the previous file remains."""
    fresh = path.with_name(path.name + ".new")
    fresh.write_text(text, encoding="utf-8")
    os.replace(fresh, path)
    return path
