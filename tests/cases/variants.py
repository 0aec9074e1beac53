#!/usr/bin/env python3
"""Scenarios that are another one but for some lines: writes each variant of a file as a scenario of its own, and prints their names.

usage: variants.py VARIANTS FOLDER

A variant begins with `NAME of BASE: what it is`, BASE.toml beside VARIANTS. Lines that begin with `-` are lines of BASE, each of which it
has once; lines with `+` behind them stand in their place. Ends with 0 done, 1 a line that BASE has not, or more than once.
Python 3.9, standard library.
"""
import pathlib
import re
import sys


def read(text):
    """(name, base, what it is, changes) of each variant; a change: lines that go, lines that come."""
    variants = []
    for number, line in enumerate(text.splitlines(), 1):
        begin = re.fullmatch(r"(\w+) of (\w+): (.+)", line)
        if begin:
            variants.append((*begin.groups(), []))
        elif line[:1] in ("-", "+") and variants:
            changes = variants[-1][3]
            if line[0] == "-" and (not changes or changes[-1][1]):
                changes.append(([], []))
            if not changes:
                raise ValueError(f"line {number}: a line that comes stands behind one that goes")
            changes[-1][line[0] == "+"].append(line[1:])
        elif line and not line.startswith("#"):
            raise ValueError(f"line {number}: accepted are `NAME of BASE: what it is`, and lines with -, + or #")
    return variants


def made(base, name, what, changes):
    lines = [line for line in base.splitlines() if not line.startswith("#")]
    for gone, come in changes:
        places = [at for at in range(len(lines)) if lines[at:at + len(gone)] == gone]
        if len(places) != 1:
            raise ValueError(f"{name}: {gone} stands {len(places)} times in its base, not once")
        lines[places[0]:places[0] + len(gone)] = come
    return "\n".join([f"# {what}", *lines]) + "\n"


def main(source, folder):
    source, folder = pathlib.Path(source), pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    try:
        for name, base, what, changes in read(source.read_text(encoding="utf-8")):
            text = made(source.with_name(f"{base}.toml").read_text(encoding="utf-8"), name, what, changes)
            (folder / f"{name}.toml").write_text(text, encoding="utf-8")
            print(name)
    except (OSError, ValueError) as error:
        sys.exit(f"{source}: {error}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
