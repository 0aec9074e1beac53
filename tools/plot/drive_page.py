"""Shows one recording, or two, on one page: plots with zoom, verdicts, settings, scenario. The plots are those of page.py and
page.js; without uPlot a picture replaces them."""
import math
import string

import page
from page import PARTS, cell, escape, number, unit
from table import printed

JUDGED = {"failed": ("✗", "bad", "failed"), "not_judged": ("?", "kind", "not judged"), "met": ("✓", "good", "met"),
          "measured": ("=", "", "measured")}
MISSING_UPLOT = "Plots with zoom are missing, because uPlot was not found: run tools/get-uplot and make the page again."


def verdict(kind):
    sign, look, word = JUDGED.get(kind, ("–", "", kind.replace("_", " ")))
    return f'<span class="verdict {look}"><span class="sign">{sign}</span> {escape(word)}</span>'


def verdict_section(notes):
    """The expectations of the run, the failed ones first."""
    rows = [(name, text) for key, name, text in notes if key == "verdict"]
    if not rows:
        return ""
    kinds = list(JUDGED) + [name for name, _ in rows if name not in JUDGED]
    rows.sort(key=lambda row: kinds.index(row[0]))
    counts = "".join(f'<li class="{JUDGED[kind][1]}"><b>{sum(name == kind for name, _ in rows)}</b> {verdict(kind)}</li>'
                     for kind in JUDGED if any(name == kind for name, _ in rows))
    body = "".join(f"<tr>{cell('judged', verdict(name))}<td>{escape(text)}</td></tr>" for name, text in rows)
    return (f'<section id="verdicts"><h2>Expectations</h2><ul class="counts">{counts}</ul>'
            f'<table class="judged-list"><tbody>{body}</tbody></table></section>')


def setting_rows(recording, rows, chosen):
    lines = []
    for name, (value, of) in recording.values.items():
        if chosen(name, value):
            row = rows.get(name, {})
            shown, shown_unit = printed(value, of, row)
            default, _ = printed(row.get("default"), of, row)
            lines.append(f'<tr><th scope="row">{escape(name)}</th>{cell("number", number(shown))}{cell("unit", unit(shown_unit))}'
                         f'{cell("number", number(default))}<td>{escape(row.get("text", ""))}</td></tr>')
    return "".join(lines)


def settings_section(recording, rows):
    """Lists every value that determined the run: first those that differ from their defaults, then the others, folded."""
    if not recording.values:
        return ""

    def touched(name, value):
        default = rows.get(name, {}).get("default")
        return default is None or not math.isclose(value, default, rel_tol=1e-6, abs_tol=0.0)
    head = ('<thead><tr><th>name</th><th class="number">value</th><th>unit</th><th class="number">default</th><th>meaning</th>'
            "</tr></thead>")
    first = setting_rows(recording, rows, touched)
    rest = setting_rows(recording, rows, lambda name, value: not touched(name, value))
    count = rest.count("<tr>")
    table = '<div class="wide"><table class="data settings">' + head + "<tbody>{}</tbody></table></div>"
    return ('<section id="settings"><h2>Settings at t = 0</h2>'
            + (table.format(first) if first else "<p>All settings have their defaults.</p>")
            + (f"<details><summary>the other {count} settings, at their defaults</summary>{table.format(rest)}</details>" if rest else "")
            + "</section>")


def text_section(recording):
    if not recording.text.strip():
        return ""
    return (f'<section id="scenario"><h2>Scenario</h2><details><summary>{escape(recording.meta.get("scenario", ""))}, as it was run'
            f'</summary><pre>{escape(recording.text)}</pre></details></section>')


def plot_section(name, heading, events, drawn, data, png):
    """`drawn`: result of page.plots(); `png`: octets of a picture that replaces it, or None."""
    inner = (f'<div class="picture">{page.image(png, heading)}</div>' if png else
             page.interactive({"id": name, "events": events}, drawn))
    links = f'<p class="links">Data: <a href="{escape(data)}">{escape(data)}</a></p>' if data else ""
    return f'<section class="figure" id="{name}"><h2>{escape(heading)}</h2>{inner}{links}</section>'


def alarm(when, reason):
    """A fault that the recording shows."""
    return (f'<p class="alarm"><b>Fault {escape(reason["name"])} at {when:.9g} s</b>: {escape(reason["text"])}. '
            f'What to do: {escape(reason["remedy"])}.</p>')


def verdict_line(notes):
    """How many expectations were met, for the head of the page."""
    kinds = [name for key, name, _ in notes if key == "verdict"]
    parts = [f"{kinds.count(kind)} {verdict(kind)}" for kind in JUDGED if kind in kinds]
    return f'<p><a href="#verdicts">Expectations</a>: {", ".join(parts)}</p>' if parts else ""


def about(recording):
    meta = recording.meta
    count = len(recording.time)
    span = f"{recording.time[0]:.9g} s to {recording.time[-1]:.9g} s"
    parts = [f"{count} samples of {len(recording.units)} signals, {span}", f"ended: {meta.get('ended', '?')}"]
    if meta.get("scenario"):
        parts.append(f"scenario {meta['scenario']}, seed {meta.get('seed', '?')}")
    return ". ".join((", ".join(parts), f"{meta.get('program', '?')}, commit {meta.get('commit', '?')}")) + "."


def write(path, title, lead, sections, alarms=(), how=""):
    library = page.uplot()
    ids = {"run": "Plots", "fault": "Fault", "verdicts": "Expectations", "settings": "Settings", "scenario": "Scenario",
           "differences": "Differences", "both": "Both", "apart": "B minus A"}
    links = " ".join(f'<a href="#{name}">{text}</a>' for name, text in ids.items() if any(f'id="{name}"' in part for part in sections))
    text = string.Template((PARTS / "drive.html").read_text(encoding="utf-8")).substitute(
        title=escape(title), lead=lead, alarms="".join(alarms), links=links, sections="".join(sections),
        how=escape(how if library else MISSING_UPLOT), licence=page.licence(library),
        style=(library["style"] if library else "") + "".join((PARTS / name).read_text(encoding="utf-8")
                                                               for name in ("page.css", "drive.css")),
        script=(library["script"] + "\n" if library else "") + (PARTS / "page.js").read_text(encoding="utf-8"))
    return page.replaced(path, text)
