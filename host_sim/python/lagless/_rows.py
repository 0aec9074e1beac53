"""Rows of the tables: values that can be set or read, by name, with unit, range and text."""
import ctypes as c
import dataclasses
import difflib
import functools

from ._errors import Error
from ._library import Row as _RowStruct
from ._library import library, of, why

_KINDS = ("float32", "int32", "uint32", "int32")
_ENUM = 3


@dataclasses.dataclass(frozen=True)
class Row:
    """One 32-bit value of the drive, the plant or the rig.

    key: unique name, "i_q", or "plant.inertia" where two tables have the name; initial, min, max: default and accepted range, None
    for a row that can only be read; choices: names of the values from 0 up, for a row that has choices."""
    id: int
    key: str
    name: str
    table: str
    unit: str
    text: str
    choices: tuple
    dtype: str
    settable: bool
    initial: float
    min: float
    max: float

    def number(self, value):
        """The number that a value means: a number, a bool, the name of a choice, or text with a unit."""
        if isinstance(value, str):
            if self.choices:
                if value in self.choices:
                    return float(self.choices.index(value))
                raise Error(f"{self.key} = \"{value}\": accepted: {', '.join(self.choices)}", self.key)
            number, text = c.c_double(), why()
            if not library.value(self.id, value.encode(), c.byref(number), text):
                raise Error(text.value.decode(), self.key)
            return number.value
        try:
            return float(value)
        except (TypeError, ValueError):
            raise Error(f"{self.key} = {value!r}: accepted: numbers and text with a unit", self.key) from None

    def value(self, number):
        """The value that a number of the library represents: the choice's name, a whole number, or a float."""
        if self.choices:
            return self.choices[int(number)] if 0 <= int(number) < len(self.choices) else int(number)
        return int(number) if self.dtype != "float32" else number


@functools.lru_cache(maxsize=None)
def _tables(library):
    """key -> Row of every row, and id -> Row."""
    by_key, by_id = {}, {}
    struct, n = _RowStruct(), 0
    while library.row(n, c.byref(struct)):
        settable = struct.access != 0
        choices = struct.choices.decode()
        row_ = Row(struct.id, struct.key.decode(), struct.name.decode(), struct.table.decode(), struct.unit.decode(),
                   struct.text.decode(), tuple(choices.split("|")) if struct.kind == _ENUM else (), _KINDS[struct.kind], settable,
                   struct.initial if settable else None, struct.min if settable else None, struct.max if settable else None)
        by_key[row_.key], by_id[row_.id] = row_, row_
        n += 1
    return by_key, by_id


def rows(table=None, board=None):
    """All rows by their key, or those of one table: params, requests, signals, services, truth, plant, rig. Ranges and defaults are
    those of the board."""
    return {key: found for key, found in _tables(of(board))[0].items() if table in (None, found.table)}


def row(name, board=None):
    """The row of this name: "i_q", "plant.inertia"."""
    by_key = _tables(of(board))[0]
    found = by_key.get(name) or by_key.get(name.rpartition(".")[2])
    if found is not None and name in (found.key, f"{found.table}.{found.name}"):
        return found
    twins = [key for key, other in by_key.items() if other.name == name]
    if twins:
        raise Error(f"{name}: two tables have this name; accepted: {' or '.join(twins)}", name)
    near = difflib.get_close_matches(name, by_key, 1)
    raise Error(f"{name}: no row has this name" + (f"; nearest: {near[0]}" if near else ""), name)


def row_by_id(number, board=None):
    return _tables(of(board))[1][number]


def period(board=None):
    """Length of a PWM period [s]."""
    return of(board).period()


def periods_of(time, what="time", board=None):
    """A number of periods: a whole number is the number itself; seconds as float or as text with a unit are rounded to the nearest
    period."""
    if isinstance(time, bool) or not isinstance(time, (int, float, str)):
        raise Error(f"{what} = {time!r}: accepted: periods as int, seconds as float or text (\"20 ms\")", what)
    if isinstance(time, int):
        count = time
    else:
        seconds = row("interrupt_delay").number(time) if isinstance(time, str) else time
        if not 0 <= seconds <= 4e5:
            raise Error(f"{what} = {time!r}: accepted: 0 to 4e5 s", what)
        count = round(seconds / period(board))
    if not 0 <= count < 2**32:
        raise Error(f"{what} = {time!r}: accepted: 0 to {2**32 - 1} periods", what)
    return count


def ids(names, board=None):
    """A C array of the ids of these names, and their rows."""
    found = [row(name, board) for name in names]
    for n, one in enumerate(found):
        if one in found[:n]:
            raise Error(f"record: {one.key} is named twice; name it once", one.key)
    if len(found) > 128:
        raise Error(f"record: {len(found)} rows; accepted: up to 128", "record")
    return (c.c_uint32 * max(1, len(found)))(*[one.id for one in found]), found
