"""CSV whose first line names each column with its unit: `name[unit],...`; of figures.py."""
import csv
import math


class InputError(Exception):
    """An error in a file; the text names the file, and the line or column."""


RPM = 30.0 / math.pi


def by_name(tables):
    """Each row of the program's tables by every name that a recording may give it."""
    rows_of = {}
    for row in tables.get("rows", ()):
        for name in (row["name"], f"{row['table']}.{row['name']}", f"{row['table']}_{row['name']}"):
            rows_of.setdefault(name, row)
    return rows_of


def printed(value, unit, row):
    """(value, unit) as `lagless run` prints them: the name of a choice, a mechanical speed in r/min."""
    names = row.get("choices", "").split("|")
    if row.get("choices") and value is not None and value == value and 0 <= value < len(names):
        return names[int(value)], "-"
    if unit in ("rad/s", "rad/s^2") and "mechanical" in row.get("text", ""):
        return None if value is None else value * RPM, unit.replace("rad/s^2", "r/min/s").replace("rad/s", "r/min")
    return value, unit


def units_of(path, cells):
    """{name: unit} of a first line, in its order; the unit is None where there is none."""
    units = {}
    for cell in cells:
        name, _, unit = cell.strip().partition("[")
        if name in units:
            raise InputError(f"{path}:1: column `{name}` occurs twice")
        units[name] = unit[:-1] if unit.endswith("]") else None
    return units


def rows(path):
    """First {name: unit}, then (line, cells) of each line that is not empty."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.reader(file)
            header = next(reader, None)
            if not header:
                raise InputError(f"{path}: empty")
            units = units_of(path, header)
            yield units
            for cells in reader:
                if cells and len(cells) != len(units):
                    raise InputError(f"{path}:{reader.line_num}: {len(cells)} values, but {len(units)} columns")
                if cells:
                    yield reader.line_num, cells
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: {error}") from None


def number(path, line, name, cell):
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}:{line}: {name}: `{cell}` is not a finite number")
    return value
