#!/usr/bin/env python3
"""Writes the page of `lagless matrix`: the fault matrix in colour, and for each cell the promised and the observed reaction.

usage: matrix.py JSON HTML [--title TEXT]     writes HTML, one file that needs no network

JSON: an object with `faults` and `manoeuvres` (each a list of {name, text}) and `cells`, a list of objects with these keys:
  needed       cell, fault, manoeuvre, source, verdict (green, red, never)
  of never     because
  of the rest  red_by, promised {text, because}, seen {text, reaction}
  shaft        h or l, in all cells or in none. Without it, the cells are those of a user's run (`--scenario`, `--board`).
Rows are the faults, columns the manoeuvres. With shafts, each combination has four fields: encoder and sensorless, each on both shafts. Without
them it has one field. A field has the first letter of the observed reaction. The letter is a capital if the reaction differs from the promise,
for readers who do not see the colour. Ends with 0 done, 2 wrong use or input, 3 page cannot be written. Python 3.9.
"""
import argparse
import html
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # python -I does not add this folder to the path
from table import InputError

PARTS = pathlib.Path(__file__).resolve().with_name("page")
TEXTS = ("cell", "fault", "manoeuvre", "source")
VERDICTS = ("green", "red", "never")
LETTERS = {"rides": "r", "warns": "w", "catches": "c", "refuses": "n", "stops": "s", "opens": "o"}
PLACES = (("encoder", "h"), ("encoder", "l"), ("sensorless", "h"), ("sensorless", "l"))
REACTIONS = {"rides": "runs on", "warns": "warns", "catches": "catches the rotor again", "refuses": "does not switch on", "stops": "stops",
             "opens": "opens the bridge"}
WORDS = {"green": "as promised", "red": "not as promised", "never": "cannot occur"}


def wanted(where, thing, key, kind, what):
    value = thing.get(key) if isinstance(thing, dict) else None
    if not isinstance(value, kind):
        raise InputError(f"{where}: {key}: {what} is expected")
    return value


def place_of(cell):
    return tuple(cell.get(key) for key in ("fault", "manoeuvre", "source", "shaft"))


def has_shafts(matrix):
    return any(isinstance(cell, dict) and "shaft" in cell for cell in matrix["cells"])


def read_matrix(path):
    """The object; every problem is an InputError that names file and cell."""
    try:
        with open(path, encoding="utf-8") as file:
            matrix = json.load(file)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}") from None
    for key in ("faults", "manoeuvres"):
        for number, row in enumerate(wanted(path, matrix, key, list, "a list"), 1):
            for text in ("name", "text"):
                wanted(f"{path}: {key} {number}", row, text, str, "a text")
    names = {key: {row["name"] for row in matrix[f"{key}s"]} for key in ("fault", "manoeuvre")}
    seen = set()
    for number, cell in enumerate(wanted(path, matrix, "cells", list, "a list"), 1):
        where = f"{path}: cell {number}"
        for key in TEXTS:
            wanted(where, cell, key, str, "a text")
        for key, known in names.items():
            if cell[key] not in known:
                raise InputError(f"{where}: {key}: `{cell[key]}` is not in the list of them")
        if cell.get("verdict") not in VERDICTS:
            raise InputError(f"{where}: verdict: `{cell.get('verdict')}` is none of {', '.join(VERDICTS)}")
        if cell["verdict"] == "never":
            wanted(where, cell, "because", str, "a text")
        else:
            wanted(where, cell, "red_by", str, "a text")
            for key, texts in (("promised", ("text", "because")), ("seen", ("text", "reaction"))):
                for text in texts:
                    wanted(f"{where}: {key}", wanted(where, cell, key, dict, "an object"), text, str, "a text")
        if has_shafts(matrix):
            wanted(where, cell, "shaft", str, "a text")
        place = place_of(cell)
        if place in seen:
            raise InputError(f"{where}: {cell['cell']} occurs twice")
        seen.add(place)
    return matrix


def escape(text):
    return html.escape(str(text), quote=True)


def anchor(cell):
    return cell["cell"].replace("/", ".")


def field(cell):
    """The HTML of one field of the matrix."""
    if cell is None:
        return '<span class="cell unseen" title="not run">&nbsp;</span>'
    name = escape(cell["cell"])
    if cell["verdict"] == "never":
        return f'<span class="cell never" title="{name}: cannot occur: {escape(cell["because"])}">·</span>'
    letter = LETTERS.get(cell["seen"]["reaction"], "?")
    letter = letter.upper() if cell["verdict"] == "red" else letter
    title = f'{name}\npromised: {escape(cell["promised"]["text"])}\nobserved: {escape(cell["seen"]["text"])}'
    return f'<a class="cell {cell["verdict"]}" href="#{escape(anchor(cell))}" title="{title}">{letter}</a>'


def overview(matrix):
    places = {place_of(cell): cell for cell in matrix["cells"]}
    fields = PLACES if has_shafts(matrix) else sorted({place_of(cell)[2:] for cell in matrix["cells"]})
    head = "".join(f'<th title="{escape(row["text"])}">{escape(row["name"])}</th>' for row in matrix["manoeuvres"])
    body = []
    for fault in matrix["faults"]:
        if not any(key[0] == fault["name"] for key in places):
            continue
        columns = "".join(
            "<td>" + "".join(field(places.get((fault["name"], row["name"], *place))) for place in fields) + "</td>"
            for row in matrix["manoeuvres"])
        body.append(f'<tr><th title="{escape(fault["text"])}"><a href="#{escape(fault["name"])}">{escape(fault["name"])}</a></th>'
                    f'{columns}</tr>')
    return f'<table class="matrix"><thead><tr><th></th>{head}</tr></thead><tbody>{"".join(body)}</tbody></table>'


def told(cell):
    """The HTML of one row in the list of a fault."""
    if cell["verdict"] == "never":
        what = f'<td colspan="2">{escape(cell["because"])}</td>'
    else:
        because = f'<br><small>{escape(cell["promised"]["because"])}</small>' if cell["promised"]["because"] else ""
        by = f'<br><small>not as promised: {escape(cell["red_by"])}</small>' if cell["red_by"] else ""
        what = (f'<td data-label="promised:">{escape(cell["promised"]["text"])}{because}</td>'
                f'<td data-label="observed:">{escape(cell["seen"]["text"])}{by}</td>')
    name = " ".join(text for text in place_of(cell)[1:] if text is not None)
    return (f'<tr id="{escape(anchor(cell))}"><td>{escape(name)}</td>'
            f'<td><span class="word {cell["verdict"]}">{WORDS[cell["verdict"]]}</span></td>{what}</tr>')


def sections(matrix):
    parts = []
    for fault in matrix["faults"]:
        cells = [cell for cell in matrix["cells"] if cell["fault"] == fault["name"]]
        if cells:
            head = "<thead><tr><th>cell</th><th>verdict</th><th>promised</th><th>observed</th></tr></thead>"
            rows = "".join(told(cell) for cell in cells if cell["verdict"] != "never")
            never = "".join(told(cell) for cell in cells if cell["verdict"] == "never")
            table = f'<div class="wide"><table class="cells">{head}<tbody>{rows}</tbody></table></div>' if rows else ""
            never = (f'<details><summary>cells that cannot occur</summary><table class="cells"><tbody>{never}</tbody></table>'
                     '</details>') if never else ""
            parts.append(f'<section id="{escape(fault["name"])}"><h2>{escape(fault["name"])}</h2><p>{escape(fault["text"])}</p>'
                         f'{table}{never}</section>')
    return "".join(parts)


def lead(matrix):
    """What a row, a column and a field of the matrix are."""
    if has_shafts(matrix):
        return ("A row is an injected fault, a column the manoeuvre in which it occurs. Each place has four cells: with the encoder on the paper's "
                "rig (shaft h) and on the bare motor (shaft l), then without encoder on h and l.")
    return f"A row is a fault that was injected into this run: {escape(', '.join(row['text'] for row in matrix['manoeuvres']))}."


def page(matrix, title):
    count = {verdict: sum(cell["verdict"] == verdict for cell in matrix["cells"]) for verdict in VERDICTS}
    totals = " &nbsp; ".join(f'<span class="total"><b>{count[verdict]}</b> <span class="word {verdict if count[verdict] else "zero"}">{WORDS[verdict]}</span></span>'
                             for verdict in VERDICTS)
    drawn = ""
    if "seed" in matrix:
        drawn = f"<p>Selected: {escape(matrix.get('share_percent'))} % of the cells, by seed {escape(matrix['seed'])}.</p>"
    letters = ", ".join(f"<b>{letter}</b> {REACTIONS[name]}" for name, letter in LETTERS.items())
    manoeuvres = "".join(f"<dt>{escape(row['name'])}</dt><dd>{escape(row['text'])}</dd>" for row in matrix["manoeuvres"])
    meaning = f"<details><summary>meaning of the manoeuvres</summary><dl>{manoeuvres}</dl></details>" if has_shafts(matrix) else ""
    css = "".join((PARTS / name).read_text(encoding="utf-8") for name in ("page.css", "matrix.css"))
    return (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
            '<meta name="color-scheme" content="light dark">'
            f'<title>{escape(title)}</title><style>{css}</style></head><body><h1>{escape(title)}</h1>'
            f'<p class="totals">{totals}</p>{drawn}'
            f'<p class="lead">{lead(matrix)} The letter '
            f'shows what the drive did: {letters}. A capital letter on red is a reaction that was not promised; <b>·</b> is a cell '
            'that cannot occur. Select a cell to see its numbers.</p>'
            f'<div class="wide">{overview(matrix)}</div>'
            f'{meaning}{sections(matrix)}</body></html>\n')


def main():
    parser = argparse.ArgumentParser(description="Writes the page of `lagless matrix`.")
    parser.add_argument("json", type=pathlib.Path)
    parser.add_argument("html", type=pathlib.Path)
    parser.add_argument("--title", default="Fault matrix", help="of the page")
    options = parser.parse_args()
    if options.html.suffix != ".html":
        parser.error(f"{options.html}: the page's name must end in .html")
    try:
        matrix = read_matrix(options.json)
    except InputError as error:
        print(f"matrix.py: {error}", file=sys.stderr)
        return 2
    try:
        options.html.parent.mkdir(parents=True, exist_ok=True)
        options.html.write_text(page(matrix, options.title), encoding="utf-8")
    except OSError as error:
        print(f"matrix.py: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
