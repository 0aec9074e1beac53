#!/usr/bin/env python3
"""Checks what keeps the firmware readable and is in no single line: no circle of includes among its files, no struct that is
a bag, and no schedule by a remainder (a task has its steps in their order, and nothing is due in "every eighth" of them).

usage: check_structs.py [--root FOLDER]

Prints one line a breach, `file:line: rule: text`, and ends with 1 if there is any. Python 3.9, standard library only.
"""
import argparse
import pathlib
import re
import sys

FIELDS = 25  # of a struct that is written by hand; the rows of a table (X macros) are no fields that a reader has to know

# Structs that are still larger, by file and the fields that they may have; the list only shrinks.
LARGER = {}

COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.MULTILINE)
STRUCT = re.compile(r"\bstruct\b[ \t]*\w*[ \t\n]*\{")
SLOT = re.compile(r"% *(?:GUARD|CURRENT|DRIVE|LOOK)_\w+")


def code_of(path):
    return COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), path.read_text(encoding="utf-8"))


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def body_of(text, opening):
    """What stands between this brace and its own end."""
    depth = 0
    for at in range(opening, len(text)):
        depth += (text[at] == "{") - (text[at] == "}")
        if depth == 0:
            return text[opening + 1:at]
    return text[opening + 1:]


def fields_of(body):
    """How many fields a struct has; those of a struct within it are that one's."""
    while True:
        flat = re.sub(r"\{[^{}]*\}", "", body)
        if flat == body:
            break
        body = flat
    flat = "\n".join(line for line in body.splitlines() if not line.lstrip().startswith("#"))
    return sum(len(field.split(",")) for field in flat.split(";") if re.search(r"\w", field))


def circles(graph):
    """Each circle of includes once, from its first file by name."""
    found, done = [], set()

    def walk(file, way):
        if file in way:
            circle = way[way.index(file):]
            start = circle.index(min(circle))
            turned = circle[start:] + circle[:start]
            if turned not in found:
                found.append(turned)
            return
        if file in done:
            return
        for target in graph[file]:
            walk(target, way + [file])
        done.add(file)

    for file in sorted(graph):
        walk(file, [])
    return found


def check(root):
    breaches = []
    files = sorted(path for path in (root / "firmware").rglob("*") if path.suffix in (".c", ".h"))
    names = {path.relative_to(root).as_posix(): path for path in files}
    graph = {}
    for name, path in names.items():
        text = code_of(path)
        here = pathlib.PurePosixPath(name).parent
        targets = [(here / found, pathlib.PurePosixPath("firmware") / found, pathlib.PurePosixPath(found))
                   for found in INCLUDE.findall(path.read_text(encoding="utf-8"))]
        graph[name] = [next(str(way) for way in ways if str(way) in names) for ways in targets if any(str(way) in names for way in ways)]
        for match in STRUCT.finditer(text):
            count = fields_of(body_of(text, match.end() - 1))
            if count > LARGER.get(name, FIELDS):
                breaches.append((name, line_of(text, match.start()), "struct", f"has {count} fields; {FIELDS} at most: give each task or "
                                 "room a struct of its own in it"))
        for match in SLOT.finditer(text):
            breaches.append((name, line_of(text, match.start()), "slot", f"{match.group()}: a task does its steps in their order"))
    for circle in circles(graph):
        breaches.append((circle[0], 1, "circle", " -> ".join([*circle, circle[0]]) + ": these include each other"))
    return sorted(breaches), len(names)


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    breaches, count = check(parser.parse_args(words).root.resolve())
    for name, line, rule, text in breaches:
        print(f"{name}:{line}: {rule}: {text}")
    if breaches:
        return 1
    print(f"check_structs: {count} files of firmware have no circle of includes, no struct of more than {FIELDS} fields, no slots")
    return 0


if __name__ == "__main__":
    sys.exit(main())
