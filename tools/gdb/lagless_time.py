"""Simulated time: one PWM period is 100 us, and period k begins at t_k = k * 100 us. Used by gdb's commands and by
tools/debug."""
import re
from decimal import Decimal

PERIOD = Decimal("1e-4")  # [s]
PERIOD_TICKS = 15000  # of 150 MHz
LAST_PERIOD = 0xFFFFFFFE
UNITS = {"": Decimal(1), "s": Decimal(1), "ms": Decimal("1e-3"), "us": Decimal("1e-6")}
TIME = re.compile(r"\s*([0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+)\s*([a-z]*)\s*")


def period_of_time(text):
    """The period in which this instant lies: "0.5 s", "500 ms", "12.34us" or "0.5"."""
    match = TIME.fullmatch(text)
    if not match or match[2] not in UNITS:
        raise ValueError(f"'{text}' is no time: a number and s, ms or us, such as 0.5s or \"500 ms\"")
    period = int(Decimal(match[1]) * UNITS[match[2]] / PERIOD)
    if period > LAST_PERIOD:
        raise ValueError(f"'{text}' is too late: the last period begins at {seconds(LAST_PERIOD)}")
    return period


def period_number(text):
    """A period's number, as text."""
    if not re.fullmatch(r"[0-9]+", text) or int(text) > LAST_PERIOD:
        raise ValueError(f"'{text}' is no period: a whole number from 0 to {LAST_PERIOD}")
    return int(text)


def seconds(period):
    """Begin of a period, as text: exact, since a period is 0.1 ms."""
    return f"{Decimal(period) * PERIOD:.4f} s"
