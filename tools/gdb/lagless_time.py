"""Simulated time: PWM period k begins at t_k = k * ticks/150 MHz, with `ticks` from rig_period_ticks of the program. Used by
gdb's commands and by tools/debug."""
import re
from decimal import Decimal
from fractions import Fraction

TICK = Fraction(1, 150_000_000)  # [s]
LAST_PERIOD = 0xFFFFFFFE
UNITS = {"": Decimal(1), "s": Decimal(1), "ms": Decimal("1e-3"), "us": Decimal("1e-6")}
TIME = re.compile(r"\s*([0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]{1,3})?|\.[0-9]+)\s*([a-z]*)\s*")


def time_of(text):
    """The instant [s] that a text means: "0.5 s", "500 ms", "12.34us" or "0.5"."""
    match = TIME.fullmatch(text)
    if not match or match[2] not in UNITS:
        raise ValueError(f"'{text}' is no time: a number and s, ms or us, such as 0.5s or \"500 ms\"")
    return Fraction(Decimal(match[1]) * UNITS[match[2]])


def period_of_time(text, ticks):
    """The period in which this instant lies. Uses the begins that seconds() returns, so that a printed time leads to the same period."""
    instant = time_of(text)
    period = instant // (ticks * TICK)
    period += instant >= begin(period + 1, ticks)
    if period > LAST_PERIOD:
        raise ValueError(f"'{text}' is too late: the last period begins at {seconds(LAST_PERIOD, ticks)}")
    return period


def period_number(text):
    """The number of a period, read from a text."""
    if not re.fullmatch(r"[0-9]+", text) or int(text) > LAST_PERIOD:
        raise ValueError(f"'{text}' is no period: a whole number from 0 to {LAST_PERIOD}")
    return int(text)


def decimals(ticks):
    """The smallest number of decimals that represents the begin of each period exactly; 9 if there is none."""
    return next((count for count in range(1, 9) if (ticks * TICK * 10**count).denominator == 1), 9)


def begin(period, ticks):
    """Begin of a period [s], rounded to the printed decimals."""
    scale = 10 ** decimals(ticks)
    return Fraction(round(period * ticks * TICK * scale), scale)


def seconds(period, ticks):
    """Begin of a period, as text with the decimals of a recording."""
    count = decimals(ticks)
    whole, rest = divmod(round(begin(period, ticks) * 10**count), 10**count)
    return f"{whole}.{rest:0{count}} s"
