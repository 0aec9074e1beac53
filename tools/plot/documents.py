#!/usr/bin/env python3
"""Writes parts of the report into the documents: its head, two pictures and the rows whose number in the paper is an angle into
docs/paper.md, the map into docs/accuracy.md.

usage: documents.py FOLDER DOCS            rewrites the text between each two marks, copies the pictures to DOCS
       documents.py FOLDER DOCS --check only checks whether the documents are up to date
                        [--only FILE]      processes only this document, paper.md or accuracy.md

FOLDER contains a report of `lagless paper`. For paper.md the report may lack the map, beyond_map, which takes nine tenths of the
time. Ends with 0 done or up to date, 1 not up to date, 2 wrong use or input. Python 3.9, standard library.
"""
import argparse
import csv
import json
import pathlib
import shutil
import sys

BEGIN = "<!-- begin: written by tools/plot/documents.py -->\n"
BEGIN_MAP = "<!-- begin: the map, written by tools/plot/documents.py -->\n"
END = "<!-- end -->\n"
PICTURES = ("fig12", "fig14")
MAP = "beyond_map"


def number(value):
    if value is None:
        return ""
    return f"{0.0 if abs(value) < 0.05 else value:.1f}"


def block(report):
    rows = [row for row in report["rows"] if row["figure"] != MAP]
    verdicts = [row["verdict"] for row in rows]
    counts = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in dict.fromkeys(verdicts))
    titles = {figure["id"]: figure["title"] for figure in report["figures"]}
    lines = [f"![{titles[name]}]({name}.png)" for name in PICTURES]
    lines += ["", f"{len(rows)} numbers: {counts}. Those with an angle in print, in electrical mrad:", "",
              "| | claim | paper | real drive | ideal drive | verdict |", "|---|---|---|---|---|---|"]
    ours = {row["id"]: row["ours"] for row in rows}
    for row in rows:
        if row["paper"] is not None and row["unit"] == "mrad" and row["flavour"] == "real":
            ideal = ours.get(row["id"].rpartition(".")[0] + ".ideal")
            because = f", {row['because']}" if row["verdict"] == "not reproduced" else ""
            lines.append(f"| {row['figure']} | {row['claim']} | {number(row['paper'])} | {number(row['ours'])} | "
                         f"{number(ideal)} | {row['verdict']}{because} |")
    return "\n".join(lines) + "\n"


def digits(value):
    """Three significant digits."""
    return f"{value:.{2 if value < 9.995 else 1 if value < 99.95 else 0}f}"


def map_cell(rows, load, speed, adaptation):
    """Mean and SD of the direction with the larger mean."""
    points = [row for row in rows if (float(row["load"]), abs(float(row["speed"])), row["adaptation"]) == (load, speed, adaptation)]
    if any(int(row["lost"]) for row in points):
        return "lost"
    worst = max(points, key=lambda row: abs(float(row["mean"])))
    return f"{digits(abs(float(worst['mean'])))} / {digits(float(worst['sd']))}"


def map_block(table):
    """A table with one line per deviation and one column per speed, with adaptation off and on, at the largest load."""
    rows = [{name.partition("[")[0]: value for name, value in row.items()} for row in table]
    load = max(float(row["load"]) for row in rows)
    speeds = sorted({abs(float(row["speed"])) for row in rows})
    lines = [f"| {load:g} N m, adaptation off \N{RIGHTWARDS ARROW} on | " + " | ".join(f"{speed:g} r/min" for speed in speeds) + " |",
             "|---" * (1 + len(speeds)) + "|"]
    for deviation in dict.fromkeys(row["deviation"] for row in rows):
        own = [row for row in rows if row["deviation"] == deviation]
        cells = [f"{map_cell(own, load, speed, 'off')} \N{RIGHTWARDS ARROW} {map_cell(own, load, speed, 'on')}" for speed in speeds]
        lines.append(f"| {deviation} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def paper_block(folder):
    return block(json.loads((folder / "report.json").read_text(encoding="utf-8")))


def accuracy_block(folder):
    with open(folder / "data" / f"{MAP}.csv", encoding="utf-8", newline="") as file:
        return map_block(csv.DictReader(file))


WRITTEN = {"paper.md": (BEGIN, paper_block), "accuracy.md": (BEGIN_MAP, accuracy_block)}


def put(text, mark, fresh):
    """The text with the new block between its marks; None if it has no marks."""
    before, begin, rest = text.partition(mark)
    _, end, after = rest.partition(END)
    return before + begin + fresh + end + after if begin and end else None


def main():
    parser = argparse.ArgumentParser(description="Writes parts of the report into the documents.")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("docs", type=pathlib.Path)
    parser.add_argument("--check", action="store_true", help="write nothing")
    parser.add_argument("--only", choices=list(WRITTEN), metavar="FILE", help="this document alone")
    options = parser.parse_args()
    wanted = [options.only] if options.only else list(WRITTEN)
    try:
        blocks = {name: (WRITTEN[name][0], WRITTEN[name][1](options.folder)) for name in wanted}
        texts = {name: (options.docs / name).read_text(encoding="utf-8") for name in blocks}
    except (OSError, ValueError, KeyError) as error:
        print(f"documents.py: {options.folder} or {options.docs}: {error!r}", file=sys.stderr)
        return 2
    stale = 0
    for name, (mark, lines) in blocks.items():
        fresh = put(texts[name], mark, lines)
        if fresh is None:
            print(f"documents.py: {name}: no line `{mark.strip()}` with a line `{END.strip()}` after it", file=sys.stderr)
            return 2
        if options.check and fresh != texts[name]:
            print(f"documents.py: {name} differs from this report: run tools/demo, then "
                  "tools/plot/documents.py report docs", file=sys.stderr)
            stale = 1
        if not options.check:
            (options.docs / name).write_text(fresh, encoding="utf-8")
    for name in PICTURES if not options.check and "paper.md" in wanted else ():
        shutil.copyfile(options.folder / "pictures" / f"{name}.png", options.docs / f"{name}.png")
    return stale


if __name__ == "__main__":
    sys.exit(main())
