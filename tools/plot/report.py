#!/usr/bin/env python3
"""Draws the results of `lagless paper`: a picture per figure, and the page that shows all of them.

usage: report.py FOLDER     reads FOLDER/report.json and the CSV files that it names;
                            writes FOLDER/pictures/*.png, *.svg and FOLDER/index.html

Ends with 0 done, 2 wrong use or input, 3 matplotlib missing or report cannot be written. Python 3.9 and matplotlib.
"""
import argparse
import json
import multiprocessing
import os
import pathlib
import re
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # python -I does not add it
import progress
import style
from table import InputError

TEXT, NUMBER, ANY = "text", "a number", "text or a number"
TYPES = {TEXT: str, NUMBER: (int, float), ANY: (str, int, float)}


def optional(kind):
    return (kind,)


MANIFEST = {
    "commit": TEXT, "seed": NUMBER, "seconds": NUMBER, "flavours": {},
    "conditions": [{"name": TEXT, "value": optional(ANY), "unit": TEXT, "text": TEXT}],
    "figures": [{"id": TEXT, "title": TEXT, "claim": TEXT, "paper": optional(TEXT), "csv": TEXT,
                 "events": [{"time": NUMBER, "text": TEXT}],
                 "runs": [{"name": TEXT, "flavour": TEXT, "condition": TEXT}]}],
    "rows": [{"id": TEXT, "figure": TEXT, "flavour": TEXT, "claim": TEXT, "paper": optional(NUMBER),
              "expected": optional(NUMBER), "ours": optional(NUMBER), "unit": TEXT, "tolerance": optional(NUMBER),
              "verdict": TEXT, "because": TEXT, "condition": TEXT}],
}


def check(value, shape, key, path):
    """Raises InputError that names the file and the key which is not as in MANIFEST."""
    def refuse(wanted):
        raise InputError(f"{path}: {key or 'all of it'}: expected {wanted}, got {json.dumps(value)[:60]}")
    if isinstance(shape, dict):
        if not isinstance(value, dict):
            refuse("an object")
        for name, inner in shape.items():
            where = f"{key}.{name}" if key else name
            if name not in value:
                raise InputError(f"{path}: {where}: is missing")
            check(value[name], inner, where, path)
    elif isinstance(shape, list):
        if not isinstance(value, list):
            refuse("a list")
        for index, each in enumerate(value):
            check(each, shape[0], f"{key}[{index}]", path)
    elif isinstance(shape, tuple):
        if value is not None:
            check(value, shape[0], key, path)
    elif not isinstance(value, TYPES[shape]) or (isinstance(value, bool) and shape == NUMBER):
        refuse(shape)


def read_manifest(path):
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:  # text that is not UTF-8, too
        raise InputError(f"{path}: {error}") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    check(manifest, MANIFEST, "", path)
    known = set()
    for index, figure in enumerate(manifest["figures"]):
        name = figure["id"]
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or name in known:
            raise InputError(f"{path}: figures[{index}].id: `{name}` is no new name of letters, digits and _")
        if not re.fullmatch(r"(\w+/)*\w+\.csv", figure["csv"], re.ASCII):
            raise InputError(f"{path}: figures[{index}].csv: `{figure['csv']}` is no CSV file below {path.parent}")
        known.add(name)
    for index, row in enumerate(manifest["rows"]):
        if row["figure"] not in known:
            raise InputError(f"{path}: rows[{index}].figure: there is no figure `{row['figure']}`")
        if row["verdict"] not in style.VERDICTS:
            raise InputError(f"{path}: rows[{index}].verdict: `{row['verdict']}` is none of: "
                             f"{', '.join(style.VERDICTS)}")
    return manifest


def draw(job):
    """One figure, made in a separate process: (id, plots, table) for the page."""
    import figures
    import page
    import pictures
    folder, figure, manifest = job
    data = figures.Data.read(folder / figure["csv"])
    layouts = figures.layouts(figure, data)
    pictures.draw(figure, layouts, data, folder / "pictures", manifest)
    return figure["id"], page.plots(layouts, data), "" if layouts else page.data_tables(data)


def report(folder, manifest):
    begin = time.monotonic()
    (folder / "pictures").mkdir(exist_ok=True)

    def size(figure):
        path = folder / figure["csv"]
        return path.stat().st_size if path.exists() else 0
    # The largest figures come first, so that the processes end at about the same time.
    jobs = [(folder, figure, manifest) for figure in sorted(manifest["figures"], key=size, reverse=True)]
    with multiprocessing.Pool(max(2, os.cpu_count() or 2)) as pool:
        done = []
        for figure in pool.imap_unordered(draw, jobs):
            done.append(figure)
            progress.tell(len(done) / len(jobs))
    import page
    index = page.write(folder, manifest, {name: plots for name, plots, _ in done},
                       {name: table for name, _, table in done})
    without = "" if page.uplot() else "; the plots have no zoom, because uPlot is missing: run tools/get-uplot"
    print(f"{index}: {len(done)} figures, {len(manifest['rows'])} rows, {index.stat().st_size / 1e6:.1f} MB, "
          f"{time.monotonic() - begin:.1f} s{without}")


def main():
    parser = argparse.ArgumentParser(description="Draws the results of `lagless paper`, and writes the page that shows them.")
    parser.add_argument("folder", type=pathlib.Path)
    options = parser.parse_args()
    try:
        manifest = read_manifest(options.folder / "report.json")
        style.pyplot()
        report(options.folder, manifest)
    except ImportError:
        print(f"report.py: {style.MISSING}", file=sys.stderr)
        return 3
    except InputError as error:
        print(f"report.py: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"report.py: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
