"""Runs a user's estimator under the conditions of docs/accuracy.md and docs/peers.md, and compares it with that of the drive and of other
drives."""
import concurrent.futures
import ctypes as c
import dataclasses
import functools
import json
import os
import pathlib

import numpy as np

from ._errors import Error
from ._rows import period, row
from ._scenario import run

_FOLDER = pathlib.Path(__file__).with_name("bench")
_RECORD = ("u_alpha", "u_beta", "i_alpha", "i_beta", "true_theta_e", "theta_hat_err")
_SPEEDS = (50, 100, 313, 503, 1013, 1490)  # [r/min]
_CURRENT = 5.0                             # [A]
# Begin and end of the counted intervals [s]: the steady part of steady.toml; each ramp of ramp.toml and the 50 ms after it.
_STEADY = ((1.2, 2.3),)
_RAMPS = ((1.0, 1.09), (1.5, 1.59))
# Errors of the sensors in addition to the 12-bit converter and 10 mA of noise, as in docs/accuracy.md.
_REAL = {"plant.current_offset_a": 0.03, "plant.current_offset_c": -0.03, "plant.current_gain_error_b": 0.002}


def _configured(name, factor):
    return {name: factor * row(name).initial}


def _inductance(factor):
    return {**_configured("motor_inductance_d", factor), **_configured("motor_inductance_q", factor)}


# Condition -> the rows that differ from the real inverter and sensors. The estimator gets the same wrong data as the drive.
_DEVIATIONS = {
    "R -50 %": lambda: _configured("motor_resistance", 0.5),
    "R +50 %": lambda: _configured("motor_resistance", 1.5),
    "L -20 %": lambda: _inductance(0.8),
    "L +20 %": lambda: _inductance(1.2),
    "psi_f -10 %": lambda: _configured("motor_flux_linkage", 0.9),
    "psi_f +10 %": lambda: _configured("motor_flux_linkage", 1.1),
    "dead time -0.5 us": lambda: {"params.turn_off_delay": row("params.turn_off_delay").initial + 0.5e-6},
    "dead time +0.5 us": lambda: {"params.turn_on_delay": row("params.turn_on_delay").initial + 0.5e-6},
    "offset 50 mA": lambda: {"plant.current_offset_a": 0.05},
    "noise 20 mA": lambda: {"plant.current_noise": 0.02},
    "sensor a +1 %": lambda: {"plant.current_gain_error_a": 0.01},
    "leg a +0.5 V": lambda: {"plant.leg_a_drop": 0.5},
    "EMF 5th 3 % and 7th 2 %": lambda: {"plant.emf_5th": 0.03, "plant.emf_7th": 0.02},
}


@dataclasses.dataclass(frozen=True)
class Motor:
    """The configuration of an estimator: the parameters of the drive, which are wrong in some cases."""
    period: float        # T [s]
    pole_pairs: int      # [-]
    resistance: float    # R [ohm]
    inductance_d: float  # L_d [H]
    inductance_q: float  # L_q [H]
    flux_linkage: float  # psi_f [Wb]


@dataclasses.dataclass(frozen=True)
class AngleError:
    """Estimated minus true electrical angle in the counted intervals [mrad]: mean, standard deviation and largest value, each of the worse
    direction of rotation, without signs."""
    mean: float
    sd: float
    peak: float

    def __str__(self):
        return " / ".join(f"{one:.{2 if one < 10 else 1 if one < 100 else 0}f}" for one in (self.mean, self.sd, self.peak))


@dataclasses.dataclass(frozen=True)
class Case:
    """One condition. scenario: a file of the bench; changes: the rows that differ from it, for each direction of rotation; spans: the counted
    intervals [s]."""
    name: str
    scenario: str
    changes: tuple
    spans: tuple
    peers: dict = dataclasses.field(default_factory=dict)

    def motor(self, changes):
        def number(name):
            found = row(name)
            return found.number(changes.get(name, changes.get("params." + name, found.initial)))

        return Motor(period(), int(number("motor_pole_pairs")), number("motor_resistance"), number("motor_inductance_d"),
                     number("motor_inductance_q"), number("motor_flux_linkage"))


@functools.lru_cache(maxsize=None)
def _measured():
    return json.loads((_FOLDER / "peers.json").read_text(encoding="utf-8"))


def _steady(name, rpm, amperes, changes, peers=None):
    both = tuple({"plant.shaft_locked_speed": f"{sign * rpm} r/min", "i_q_request": sign * amperes, **changes} for sign in (1, -1))
    return Case(f"{rpm} r/min, {amperes:g} A, {name}", "steady.toml", both, _STEADY, peers or {})


def cases():
    """All cases of the bench, in the order of the table."""
    measured = _measured()
    ideal, wrong, sampled = (measured["data"][name] for name in ("ideal", "wrong", "sampled"))

    def peers(table, case):
        return dict(zip(measured["drives"], measured[table][case]))

    found = [_steady(name, rpm, amperes, changes) for name, changes in (("ideal", ideal), ("real inverter and sensors", _REAL))
             for rpm in _SPEEDS for amperes in (0.0, _CURRENT)]
    found += [_steady(name, rpm, _CURRENT, {**_REAL, **make()}) for name, make in _DEVIATIONS.items() for rpm in (313, 1013)]
    for case in measured["steady"]:
        rpm, data = case.split()
        name, changes = {"ideal": ("as measured of the other drives, ideal", ideal),
                         "wrong": ("as measured of the other drives, R -20 %, psi_f +5 %", wrong)}[data]
        found.append(_steady(name, int(rpm), _CURRENT, changes, peers("steady", case)))
    for name, data, changes in (("ideal", "ideal", ideal), ("12 bits, R -20 %, psi_f +5 %", "sampled", {**ideal, **sampled, **wrong})):
        found.append(Case(f"100 to 1500 r/min and back in 40 ms each, {name}", "ramp.toml", (changes,), _RAMPS, peers("ramp", data)))
    return found


# ---- estimators ----

class _Struct(c.Structure):
    """bench/lagless_bench.h."""
    _fields_ = [(field.name, c.c_double) for field in dataclasses.fields(Motor)]


def _shared_object(path):
    """The estimator of a shared object that has the three functions of bench/lagless_bench.h."""
    try:
        library = c.CDLL(os.path.abspath(path))
        create, step, free = library.estimator_create, library.estimator_step, library.estimator_free
    except (OSError, AttributeError) as error:
        raise Error(f"{path}: {error}; accepted: a shared object with the functions of {_FOLDER / 'lagless_bench.h'}", "estimator") \
            from None
    create.restype, create.argtypes = c.c_void_p, [c.POINTER(_Struct)]
    step.restype, step.argtypes = c.c_double, [c.c_void_p] + 4 * [c.c_double]
    free.restype, free.argtypes = None, [c.c_void_p]

    class Estimator:
        def __init__(self, motor):
            self._state = create(c.byref(_Struct(*dataclasses.astuple(motor))))
            if not self._state:
                raise Error(f"{path}: estimator_create returned NULL", "estimator")

        def __call__(self, u, i):
            return step(self._state, u.real, u.imag, i.real, i.imag)

        def __del__(self):
            if getattr(self, "_state", None):
                free(self._state)

    return Estimator


def _angles(estimator, motor, result, name):
    """The estimator's angle at each sample [rad]."""
    step = estimator(motor)
    if not callable(step):
        raise Error(f"estimator(motor) returned {type(step).__name__}; accepted: a function step(u, i) that returns the angle [rad]",
                    "estimator")
    u = (result.u_alpha.astype(float) + 1j * result.u_beta).tolist()
    i = (result.i_alpha.astype(float) + 1j * result.i_beta).tolist()
    angles = [step(*sample) for sample in zip(u, i)]
    try:
        angles = np.array(angles, dtype=float)
        assert angles.ndim == 1
    except (TypeError, ValueError, AssertionError):
        raise Error(f"{name}: step(u, i) returned {angles[0]!r}; accepted: one number, the angle [rad]", "estimator") from None
    wrong = np.flatnonzero(~np.isfinite(angles))
    if len(wrong):
        raise Error(f"{name}: step(u, i) returned {angles[wrong[0]]} at {result.t[wrong[0]]:.4f} s; accepted: finite angles [rad]",
                    "estimator")
    return angles


# ---- measuring ----

def _error(errors):
    """Mean, SD and largest value of arrays of errors [rad], one array for each direction and counted interval."""
    return AngleError(*(1e3 * max(abs(float(statistic(one))) for one in errors)
                    for statistic in (np.mean, np.std, lambda one: np.max(np.abs(one)))))


def _counted(result, error, spans):
    return [error[(result.t >= begin) & (result.t < end)] for begin, end in spans]


class Bench:
    """errors: name of a case -> AngleError of the estimator; lagless: the same of the drive's own estimator on the same samples; peers: name of
    a case -> {drive: text of its mean / SD, or of its largest error}, where measured (docs/peers.md). print() shows the tables."""

    def __init__(self, errors, lagless, peers):
        self.errors, self.lagless, self.peers = errors, lagless, peers

    def to_pandas(self):
        """A pandas.DataFrame: a line for each case, columns of both estimators [mrad]."""
        import pandas

        columns = {(who, field.name): [getattr(one, field.name) for one in found.values()]
                   for who, found in (("estimator", self.errors), ("lagless", self.lagless)) for field in dataclasses.fields(AngleError)}
        return pandas.DataFrame(columns, index=pandas.Index(self.errors, name="case"))

    def __str__(self):
        width = max(len("mean / SD / peak of the angle error, mrad"), *map(len, self.errors))
        lines = [f"{'mean / SD / peak of the angle error, mrad':{width}}  {'estimator':>20}  {'lagless':>20}"]
        lines += [f"{name:{width}}  {error!s:>20}  {self.lagless[name]!s:>20}" for name, error in self.errors.items()]
        for name, drives in self.peers.items():
            kind = "mean / SD" if " / " in next(iter(drives.values())) else "largest error"
            lines += ["", f"{name}: {kind} of other drives, mrad", "  " + ", ".join(f"{drive} {text}" for drive, text in drives.items())]
        return "\n".join(lines)


def bench(estimator, only=None, progress=None):
    """Runs an estimator on the samples of a drive in all cases() and returns a Bench.

    estimator: a function or class that is called with a Motor and returns a function step(u, i), or the path of a shared object with the
    functions of bench/lagless_bench.h. step is called once for each sample, in order: u is the mean voltage on the winding in the period that
    ends at the sample [V], i is the current at the sample [A]; both are complex, alpha + j beta. step returns the electrical angle of the rotor
    at the sample [rad].

        class Flux:
            def __init__(self, motor):
                self.motor, self.psi, self.before = motor, complex(motor.flux_linkage), 0

            def __call__(self, u, i):
                ...
                return cmath.phase(self.psi)

        print(lagless.bench(Flux))

    The drive is controlled by its encoder, so that the estimator does not affect the samples. only: runs only the cases whose names contain
    this text; progress: called with the completed share."""
    if isinstance(estimator, (str, os.PathLike)):
        estimator = _shared_object(os.fspath(estimator))
    elif not callable(estimator):
        raise Error(f"estimator = {estimator!r}: accepted: a function or class that takes a Motor, and the path of a shared object",
                    "estimator")
    chosen = [case for case in cases() if only is None or only in case.name]
    if not chosen:
        raise Error(f"only = {only!r}: no case contains this; lagless.bench.cases() lists them", "only")
    work = [(case, changes) for case in chosen for changes in case.changes]
    found, own = {}, {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        # The simulation of later cases runs while the estimator processes the samples of this one.
        results = pool.map(lambda one: run(_FOLDER / one[0].scenario, set=one[1], record=_RECORD, every=1), work)
        for n, ((case, changes), result) in enumerate(zip(work, results)):
            angles = _angles(estimator, case.motor(changes), result, case.name)
            error = np.angle(np.exp(1j * (angles - result.true_theta_e)))
            found.setdefault(case.name, []).extend(_counted(result, error, case.spans))
            own.setdefault(case.name, []).extend(_counted(result, result.theta_hat_err, case.spans))
            if progress is not None:
                progress((n + 1) / len(work))
    return Bench({name: _error(errors) for name, errors in found.items()}, {name: _error(errors) for name, errors in own.items()},
                 {case.name: case.peers for case in chosen if case.peers})


bench.cases = cases
bench.folder = str(_FOLDER)
