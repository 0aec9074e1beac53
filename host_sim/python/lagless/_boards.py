"""The boards that a run can use."""
import dataclasses

from ._library import library


@dataclasses.dataclass(frozen=True)
class Board:
    """A power stage with its control board, with the values of its header in hal/f28335/boards; V, A, s.

    nominal, undervoltage, overvoltage, overvoltage_max: of the DC link: nominal value, default trips, largest trip; current_limit,
    current_trip: defaults; current_range, current_per_code: range of the sensors in both directions, and its resolution; period: of the
    carrier; sensors: how many; shunts: True below the lower switches, False in the motor's leads."""
    name: str
    nominal: float
    undervoltage: float
    overvoltage: float
    overvoltage_max: float
    current_limit: float
    current_trip: float
    current_range: float
    current_per_code: float
    period: float
    dead_time: float
    sensors: int
    shunts: bool


def boards():
    """name -> Board of each board that `board=` accepts; the first one is the default."""
    found, n = {}, 0
    while facts := library.boards(n):
        values = {field.name: getattr(facts.contents, field.name) for field in dataclasses.fields(Board)}
        found[values["name"].decode()] = Board(**{**values, "name": values["name"].decode()})
        n += 1
    return found
