#!/usr/bin/env python3
"""Every shipped scenario is TOML to Python's own reader, says what it is, and expects something.

usage: test_tomllib.py FOLDER
Ends with 77 (skipped) where Python is older than 3.11 and has no tomllib.
"""
import pathlib
import sys

try:
    import tomllib
except ImportError:
    print("skipped: this Python has no tomllib (3.11 or later has)")
    sys.exit(77)

TOP = {"schema", "title", "text", "run", "start", "params", "requests", "plant", "rig", "at", "expect"}


def complaints(path):
    octets = path.read_bytes()
    try:
        text = octets.decode("ascii")
        scenario = tomllib.loads(text)
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        return [str(error)]
    found = []
    if not text.startswith("# "):
        found.append("does not begin with a comment that says what it is for")
    if list(scenario)[0] != "schema" or scenario["schema"] != 1:
        found.append("does not begin with schema = 1")
    if not scenario.get("title"):
        found.append("has no title")
    if not scenario.get("run", {}).get("record"):
        found.append("records nothing by default")
    if not scenario.get("expect"):
        found.append("expects nothing")
    found += [f"has the key {key}" for key in scenario if key not in TOP]
    return found


def main():
    paths = sorted(pathlib.Path(sys.argv[1]).glob("*.toml"))
    failed = 0
    for path in paths:
        for complaint in complaints(path):
            print(f"{path.name}: {complaint}")
            failed += 1
    print(f"{len(paths)} scenarios, {failed} complaints")
    return 1 if failed or not paths else 0


if __name__ == "__main__":
    sys.exit(main())
