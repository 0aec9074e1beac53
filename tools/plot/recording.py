"""Recordings of `lagless run` and `lagless connect`, CSV or MAT v5, as host_sim/lab/recorder.h describes them. Needs numpy."""
import dataclasses
import pathlib
import re
import struct
import zlib

import numpy

from table import InputError, units_of

FORMAT = "1"
ESCAPED = re.compile(r"\\(?:\\|x([0-9a-f]{2}))")


@dataclasses.dataclass
class Recording:
    path: pathlib.Path
    meta: dict      # program, commit, scenario, title, seed, every, period, ended as text; unknown values are missing
    units: dict     # unit of each column, in their order, without time
    columns: dict   # of each column: numpy array; time too. CSV: double; MAT: single, int32, uint32
    choices: dict   # column -> names of its values from 0 up
    values: dict    # setting at t = 0 -> (value, unit)
    notes: list     # [(key, name, text)]: events and results of expectations
    text: str       # the scenario

    @property
    def time(self):
        return self.columns["time"]

    @property
    def period(self):
        """[s] of the PWM"""
        try:
            return float(self.meta["period"].split()[0])
        except (KeyError, ValueError, IndexError):
            raise InputError(f"{self.path}: no recording: `period` is missing") from None

    def periods(self):
        """Number of each sample's period, from 0."""
        return numpy.rint(self.time / self.period).astype(numpy.int64)


def the_one_in(path):
    """The path of the recording in a folder of `lagless run --out`; the path of a file stays unchanged."""
    if not path.is_dir():
        return path
    found = {each.stem: each for suffix in (".mat", ".csv") for each in sorted(path.glob(f"*{suffix}"))}
    names = [name for name in found if not (name.endswith("_fault") and name[:-6] in found)]
    if len(names) != 1:
        raise InputError(f"{path}: it contains {len(names)} recordings: {', '.join(sorted(names)) or 'no CSV or MAT'}; name one of them")
    return found[names[0]]


def read(path, tell=lambda fraction: None):
    """Every problem is an InputError that names the file, and the line if there is one. `tell` is called with the progress, 0 to 1."""
    path = the_one_in(pathlib.Path(path))
    try:
        octets = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; accepted: a CSV or MAT file of `lagless run --out FOLDER`") from None
    recording = of_mat(path, octets) if octets[:10] == b"MATLAB 5.0" else of_csv(path, octets, tell)
    tell(1.0)
    time = recording.time
    if not len(time):
        raise InputError(f"{path}: no samples")
    if not (numpy.diff(time) > 0.0).all():
        raise InputError(f"{path}: time does not increase from row to row")
    return recording


# ---- CSV ----

def unescaped(text):
    return ESCAPED.sub(lambda m: chr(int(m[1], 16)) if m[1] else "\\", text)


def of_csv(path, octets, tell):
    try:
        text = octets.decode("utf-8")
    except UnicodeDecodeError as error:
        text = octets[:error.start].decode("utf-8")
        if text.startswith("# lagless recording: "):
            raise InputError(f"{path}:{text.count(chr(10)) + 1}: octet {error.start + 1} of the file is no UTF-8") from None
    if not text.startswith("# lagless recording: "):
        raise InputError(f"{path}: no recording of lagless: a CSV begins with `# lagless recording: {FORMAT}`, "
                         "a MAT file with `MATLAB 5.0`")
    meta, values, choices, notes, lines = {}, {}, {}, [], []
    count, begin = 0, 0
    while text.startswith("#", begin):
        end = text.find("\n", begin)
        end = len(text) if end < 0 else end
        key, _, value = text[begin + 2:end].partition(": ")
        key, value = unescaped(key), unescaped(value)
        kind, _, name = key.partition(" ")
        if kind == "text":
            lines.append(value)
        elif kind == "value":
            value_of, _, unit = value.partition(" ")
            try:
                values[name] = (float(value_of), unit)
            except ValueError:
                raise InputError(f"{path}:{count + 1}: `{text[begin:end]}`: a number and its unit are expected; the file may "
                                 "be cut off") from None
        elif kind == "choices":
            choices[name] = value.split("|")
        elif kind in ("event", "verdict"):
            notes.append((kind, name, value))
        else:
            meta[key] = value
        begin, count = end + 1, count + 1
    if meta["lagless recording"] != FORMAT:
        raise InputError(f"{path}: recording of format {meta['lagless recording']}: this program reads format {FORMAT}")
    head, _, data = text[begin:].partition("\n")
    units = units_of(path, head.split(",") if head else [])
    for name, unit in units.items():
        if unit is None:
            raise InputError(f"{path}:{count + 1}: column `{name}`: a unit in brackets is expected")
    if units.pop("time", None) != "s":
        raise InputError(f"{path}:{count + 1}: column time[s] is missing; the file may be cut off")
    columns = numbers(path, data, 1 + len(units), count + 2, tell)
    return Recording(path, meta, units, dict(zip(("time", *units), columns)), choices, values, notes, "\n".join(lines))


AT_ONCE = 20000  # [lines] between two reports of progress


def numbers(path, data, count, first, tell):
    """Columns of lines of numbers; `first` is the line they begin at."""
    lines = data.rstrip().splitlines()
    if not lines:
        return [numpy.zeros(0)] * count
    tables = []
    try:
        for begin in range(0, len(lines), AT_ONCE):
            tables.append(numpy.loadtxt(lines[begin:begin + AT_ONCE], delimiter=",", comments=None, ndmin=2))
            tell((begin + AT_ONCE) / (len(lines) + AT_ONCE))
        if {table.shape[1] for table in tables} == {count}:
            return [numpy.concatenate([table[:, n] for table in tables]) for n in range(count)]
    except ValueError:
        pass
    for line, row in enumerate(lines, first):
        cells = row.split(",")
        if len(cells) != count:
            raise InputError(f"{path}:{line}: {len(cells)} values, but {count} columns")
        for cell in cells:
            try:
                float(cell)
            except ValueError:
                raise InputError(f"{path}:{line}: `{cell}` is no number") from None
    raise InputError(f"{path}: its lines are no numbers")


# ---- MAT v5 ----

NUMBERS = {1: "<i1", 2: "<u1", 3: "<i2", 4: "<u2", 5: "<i4", 6: "<u4", 7: "<f4", 9: "<f8", 12: "<i8", 13: "<u8"}
ENCODINGS = {1: "utf-8", 2: "utf-8", 4: "utf-16-le", 16: "utf-8", 17: "utf-16-le"}
MATRIX, COMPRESSED = 14, 15
STRUCT, CHAR = 2, 4  # classes; those of numbers are 6 to 15
CLASSES = {6: "<f8", 7: "<f4", 8: "<i1", 9: "<u1", 10: "<i2", 11: "<u2", 12: "<i4", 13: "<u4", 14: "<i8", 15: "<u8"}


def elements(octets):
    """(type, content) of each data element."""
    at = 0
    while at + 8 <= len(octets):
        kind, size = struct.unpack_from("<II", octets, at)
        if kind >> 16:  # a small element: type and length in one word, the content in the next
            kind, size, begin, end = kind & 0xFFFF, kind >> 16, at + 4, at + 8
        else:
            begin = at + 8
            end = begin + (size if kind == COMPRESSED else -(-size // 8) * 8)
        if begin + size > len(octets):
            raise ValueError("cut off")
        yield kind, octets[begin:begin + size]
        at = end


def matrix(content):
    """(name, value) of a matrix: an array, a text, or a dictionary of a struct's fields."""
    parts = list(elements(content))
    (_, flags), (_, _), (_, name), *rest = parts
    kind = flags[0]
    name = name.decode("ascii")
    if kind == STRUCT:
        length = struct.unpack("<i", rest[0][1])[0]
        names = rest[1][1]
        fields = [names[k:k + length].split(b"\0")[0].decode("ascii") for k in range(0, len(names), length)] if length else []
        return name, {field: matrix(value)[1] for field, (_, value) in zip(fields, rest[2:])}
    if kind == CHAR:
        return name, rest[0][1].decode(ENCODINGS[rest[0][0]]) if rest else ""
    if kind not in CLASSES:
        raise ValueError(f"class {kind}")
    values = numpy.frombuffer(rest[0][1], NUMBERS[rest[0][0]]) if rest else numpy.zeros(0)
    return name, values.astype(CLASSES[kind])


def of_mat(path, octets):
    try:
        return recording_of(path, octets)
    except InputError:
        raise
    # a damaged file can cause any error of the arithmetic below
    except (ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError, ValueError, struct.error,
            zlib.error) as error:
        raise InputError(f"{path}: this MAT file cannot be read: {error or type(error).__name__}") from None


def recording_of(path, octets):
    variables = {}
    try:
        if octets[126:128] != b"IM":
            raise ValueError("not little-endian")
        for kind, content in elements(octets[128:]):
            if kind == COMPRESSED:
                (kind, content), = elements(zlib.decompress(content))
            if kind == MATRIX:
                name, value = matrix(content)
                variables[name] = value
    except (ValueError, KeyError, IndexError, struct.error, zlib.error, UnicodeDecodeError) as error:
        raise InputError(f"{path}: this MAT file cannot be read: {error}") from None
    meta = variables.pop("meta", None)
    if not isinstance(meta, dict) or "units" not in meta or "time" not in variables:
        raise InputError(f"{path}: no recording of lagless: `time` or `meta` is missing")
    if not all(isinstance(value, numpy.ndarray) and len(value) == len(variables["time"]) for value in variables.values()):
        raise InputError(f"{path}: its columns are not equally long")
    units = {name: meta["units"].get(name, "-") for name in variables if name != "time"}
    notes = []
    for line in meta.get("notes", "").splitlines():
        key, _, text = line.partition(": ")
        kind, _, name = key.partition(" ")
        notes.append((kind, name, text))

    def word(value):
        return value if isinstance(value, str) else f"{value.ravel()[0]:.18g}" if value.dtype.kind == "f" else str(value.ravel()[0])
    known = {key: word(meta[key]) for key in ("program", "commit", "tables", "scenario", "title", "seed", "every", "period", "ended")
             if key in meta}
    values = {name: (float(value.ravel()[0]), meta["value_units"].get(name, "-")) for name, value in meta.get("values", {}).items()}
    return Recording(path, known, units, variables, {name: value.split("|") for name, value in meta.get("choices", {}).items()},
                     values, notes, meta.get("text", ""))
