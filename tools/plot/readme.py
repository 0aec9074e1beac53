#!/usr/bin/env python3
"""Brings the report's head into README.md: two pictures, and the rows that have an angle in print.

usage: readme.py FOLDER README.md            rewrites what stands between the two marks, copies the pictures to docs/
       readme.py FOLDER README.md --check    only says whether that is up to date

FOLDER is that of a report of `lagless paper`. Ends with 0 done or up to date, 1 not up to date, 2 wrong use or input.
Python 3.9, standard library.
"""
import argparse
import json
import pathlib
import shutil
import sys

BEGIN = "<!-- begin: written by tools/plot/readme.py -->\n"
END = "<!-- end -->\n"
PICTURES = ("fig12", "fig14")


def number(value):
    if value is None:
        return ""
    return f"{0.0 if abs(value) < 0.05 else value:.1f}"


def block(report):
    rows = report["rows"]
    verdicts = [row["verdict"] for row in rows]
    counts = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in dict.fromkeys(verdicts))
    titles = {figure["id"]: figure["title"] for figure in report["figures"]}
    lines = [f"![{titles[name]}](docs/{name}.png)" for name in PICTURES]
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


def main():
    parser = argparse.ArgumentParser(description="Brings the report's head into README.md.")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("readme", type=pathlib.Path)
    parser.add_argument("--check", action="store_true", help="write nothing")
    options = parser.parse_args()
    try:
        report = json.loads((options.folder / "report.json").read_text(encoding="utf-8"))
        text = options.readme.read_text(encoding="utf-8")
        fresh = block(report)
    except (OSError, ValueError, KeyError) as error:
        print(f"readme.py: {options.folder / 'report.json'} or {options.readme}: {error!r}", file=sys.stderr)
        return 2
    before, begin, rest = text.partition(BEGIN)
    present, end, after = rest.partition(END)
    if not begin or not end:
        print(f"readme.py: {options.readme}: no line `{BEGIN.strip()}` with a line `{END.strip()}` after it", file=sys.stderr)
        return 2
    if options.check:
        if present != fresh:
            print(f"readme.py: {options.readme} is not what this report says: run tools/demo, then "
                  "tools/plot/readme.py report README.md", file=sys.stderr)
        return int(present != fresh)
    options.readme.write_text(before + begin + fresh + end + after, encoding="utf-8")
    for name in PICTURES:
        shutil.copyfile(options.folder / "pictures" / f"{name}.png", options.readme.parent / "docs" / f"{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
