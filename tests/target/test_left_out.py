#!/usr/bin/env python3
"""Every test that tests/target/avr/left_out.c leaves out exists in the file that the row names, and no row occurs twice. A row without such
a test would leave out a test of this name that is written later, without a notice."""
import pathlib
import re
import sys

TESTS = pathlib.Path(__file__).resolve().parents[1]
ROW = re.compile(r'^    \{"([^"]*)",\s*"([^"]*)",', re.MULTILINE)


def complaints(left_out, unit):
    rows = ROW.findall(left_out)
    found = [] if rows else ["no row found"]
    for file, name in rows:
        if rows.count((file, name)) > 1:
            found.append(f"{file}: {name}: twice")
        if f"static void {name}(void)\n" not in unit.get(file, ""):
            found.append(f"{file} has no test {name}")
    return found


def main():
    unit = {path.name: path.read_text() for path in (TESTS / "unit").glob("test_*.c")}
    left_out = (TESTS / "target/avr/left_out.c").read_text()
    wrong = '    {"test_smo.c", "test_no_such_test", PRECISION},\n'
    if complaints(wrong + left_out, unit) != ["test_smo.c has no test test_no_such_test"]:
        sys.exit("a row without its test is not found")
    found = complaints(left_out, unit)
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
