"""Reads a scenario from a name, a file, text or a dict, and runs and judges it as `lagless run` does."""
import concurrent.futures
import ctypes as c
import itertools
import os
import pathlib
import warnings

import numpy as np

from ._errors import Error
from ._library import About, Ask, History, Outcome, Progress, ScenarioError, of, why
from ._library import Verdict as _VerdictStruct
from ._result import Recorder, Result, Trace, Verdict, reason
from ._rows import ids, row, row_by_id

# Signals that are recorded if neither scenario nor caller names any, as in `lagless run`.
DEFAULT_ROWS = ("omega_m_ref", "true_omega_m", "i_d", "i_q", "theta_err", "u_dc")
_JUDGEMENTS = ("met", "failed", "not_judged", "measured")


def _folder():
    """The folder of the scenarios that come with the package: inside the package, or in the project's tree."""
    here = pathlib.Path(__file__).parent
    return next((folder for folder in (here / "scenarios", here.parents[1] / "scenarios") if folder.is_dir()), None)


def scenarios():
    """The scenarios that come with the package: name -> path."""
    folder = _folder()
    return {path.stem: path for path in sorted(folder.glob("*.toml"))} if folder else {}


# ---- TOML ----

def _toml_value(value):
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, str):
        escaped = "".join({'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}.get(sign) or
                          (sign if sign.isprintable() else f"\\u{ord(sign):04x}") for sign in value)
        return f'"{escaped}"'
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_toml_value(one) for one in value)}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_toml_key(key)} = {_toml_value(one)}" for key, one in value.items()) + "}"
    raise Error(f"{value!r}: accepted in a scenario: numbers, text, lists and dicts")


def _toml_key(key):
    """Writes a key; a dot in it has its meaning in TOML: "plant.load_torque"."""
    return ".".join(part if part and all(sign.isalnum() or sign in "_-" for sign in part) else _toml_value(part)
                    for part in str(key).split("."))


def to_toml(scenario):
    """The text of a scenario given as dict: tables as dicts, [[at]] and [[expect]] as lists of dicts."""
    lines = ["schema = 1"] if "schema" not in scenario else []
    tables = []
    for key, value in scenario.items():
        if isinstance(value, dict):
            tables += ["", f"[{_toml_key(key)}]"] + [f"{_toml_key(name)} = {_toml_value(one)}" for name, one in value.items()]
        elif isinstance(value, (list, tuple)) and value and all(isinstance(one, dict) for one in value):
            for one in value:
                tables += ["", f"[[{_toml_key(key)}]]"] + [f"{_toml_key(name)} = {_toml_value(x)}" for name, x in one.items()]
        else:
            lines.append(f"{_toml_key(key)} = {_toml_value(value)}")
    return "\n".join(lines + tables) + "\n"


# ---- reading ----

def _refusal(text, error):
    return Error(text.value.decode(errors="replace"), error.name.decode(errors="replace"), error.place.line, error.place.column)


class _Scenario:
    """A scenario that has been read, by the library of its board; closed by `with`."""

    def __init__(self, source, board=None):
        path, text = _source(source)
        error, refusal = ScenarioError(), why()
        octets = None if text is None else text.encode()
        self.library = of(board)
        for _ in range(2):
            self.handle = self.library.scenario_read(os.fsencode(path), octets, len(octets or b""), c.byref(error), refusal)
            if self.handle or board is not None or not error.board:
                break
            self.library = of(error.board.decode())  # the board that the scenario names
        if not self.handle:
            raise _refusal(refusal, error)
        self.board = self.library.name
        unsuited = self.about().unsuited.decode()
        if unsuited:
            warnings.warn(unsuited, stacklevel=3)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.library.scenario_free(self.handle)

    def override(self, values):
        """Applies settings that replace those of the source, also wrong ones; then checks the whole scenario."""
        error, refusal = ScenarioError(), why()
        for name, value in (values or {}).items():
            text = value if isinstance(value, str) else _toml_value(value)
            if not self.library.scenario_override(self.handle, f"{name}={text}".encode(), c.byref(error), refusal):
                raise _refusal(refusal, error)
        if not self.library.scenario_check(self.handle, c.byref(error), refusal):
            raise _refusal(refusal, error)

    def about(self):
        about = About()
        self.library.scenario_about(self.handle, c.byref(about))
        return about


def _source(source):
    """The path of the scenario, and its text if it is not a file."""
    if isinstance(source, dict):
        return "scenario", to_toml(source)
    if isinstance(source, str) and "\n" in source:
        return "scenario", source
    if isinstance(source, (str, os.PathLike)):
        path = os.fspath(source)
        known = scenarios()
        if os.sep not in path and not path.endswith(".toml") and path in known:
            return known[path], None
        if not os.path.exists(path) and os.sep not in path and not path.endswith(".toml"):
            raise Error(f"{path}: no file and no scenario of the package has this name; accepted: a file, or {', '.join(known)}", path)
        return path, None
    raise Error(f"{type(source).__name__}: accepted: name, path or text of a scenario, or a dict", "scenario")


# ---- running ----

class _Watch:
    """The library calls this at intervals during the run, so that Ctrl-C and the caller's progress are handled."""

    def __init__(self, progress):
        self.progress, self.error = progress, None

    def __call__(self, fraction):
        try:
            if self.progress is not None:
                self.progress(fraction)
        except BaseException as error:  # raised again when the library has returned
            self.error = error
        return self.error is not None


def run(scenario, set=None, seed=None, record=None, every=None, progress=None, board=None):
    """Runs a scenario and judges it; the same bits as `lagless run`.

    scenario: name of one that comes with the package, path of a file, its text, or a dict:

        lagless.run({"title": "Load step", "run": {"duration": "2 s", "record": ["true_omega_m", "i_q"]},
                     "requests": {"enable": "on", "speed_request": "500 r/min"},
                     "at": [{"time": "1 s", "plant.load_torque": "3 N m"}],
                     "expect": [{"signal": "true_omega_m", "minus": "omega_m_ref", "statistic": "peak", "from": "1.8 s",
                                 "at_most": "2 r/min"}]})

    set: rows that differ, {"motor_resistance": "1.1 ohm", "run.duration": "3 s"}; seed, record, every: replace those of the scenario
    (every: periods from sample to sample); progress: called with the completed share; board: the power stage, one of boards(), if the
    scenario names none.

    Returns a Result. Raises Error if the scenario is wrong, or if the rig refuses a setting during the run."""
    with _Scenario(scenario, board) as read:
        read.override(set)
        return _run(read, seed, record, every, progress)


def _run(read, seed, record, every, progress):
    about = read.about()
    if record is None:
        names = [row_by_id(about.record[n]).key for n in range(about.record_count)] or DEFAULT_ROWS
    else:
        names = [record] if isinstance(record, str) else list(record)
    array, rows = ids(names, read.board)
    step = about.every if every is None else int(every)
    if step < 1:
        raise Error(f"every = {every!r}: accepted: whole numbers from 1", "every")
    seed = about.seed if seed is None else int(seed)
    recorder = Recorder(rows, (about.periods + step - 1) // step if rows else 0)
    watch = _Watch(progress)
    ask = Ask(seed, array, len(rows), step, c.pointer(recorder.struct), Progress(watch))
    error, refusal = ScenarioError(), why()
    handle = read.library.run(read.handle, c.byref(ask), c.byref(error), refusal)
    try:
        if watch.error is not None:
            raise watch.error
        if not handle:
            raise _refusal(refusal, error)
        return Result(*recorder.taken(), _about(about, handle, read.library))
    finally:
        read.library.run_free(handle)


def _about(about, handle, library):
    """All values of a Result except its recordings."""
    outcome, history, unexpected = Outcome(), History(), why()
    library.outcome(handle, c.byref(outcome), unexpected)
    held = library.history(handle, c.byref(history))
    verdicts = [_verdict(handle, n, library) for n in range(about.expect_count)]
    return {
        "board": library.name,
        "title": about.title.decode(),
        "source": about.source.decode(),
        "verdicts": [verdict for verdict, measure in verdicts if not measure],
        "measures": [verdict for verdict, measure in verdicts if measure],
        "failed": outcome.failed,
        "unexpected_end": unexpected.value.decode() or None,
        "interrupted": outcome.end != 0,
        "seed": outcome.seed,
        "hash": f"{outcome.hash:016x}",
        "periods": outcome.periods,
        "seconds": outcome.periods * library.period(),
        "wall": outcome.seconds,
        "state": row("state").value(outcome.state),
        "manoeuvre": row("manoeuvre").value(outcome.manoeuvre),
        "fault": reason(outcome.fault_reason, outcome.fault_period, library.name),
        "refusal": reason(outcome.refusal),
        "not_on": reason(outcome.not_on),
        "history": _history(history, library) if held else None,
    }


def _verdict(handle, n, library):
    struct, text = _VerdictStruct(), why()
    library.verdict(handle, n, c.byref(struct), text)
    found = row_by_id(struct.id)
    verdict = Verdict(struct.name.decode(), found.key, row_by_id(struct.minus).key if struct.minus else None,
                   struct.statistic.decode(), found.unit, struct.begin, struct.end, struct.value, struct.at_least,
                   struct.at_most, struct.samples, _JUDGEMENTS[struct.judgement], text.value.decode())
    return verdict, bool(struct.measure)


def _history(struct, library):
    count = struct.periods * struct.columns
    slots = np.frombuffer(c.string_at(struct.slots, 4 * count), dtype=np.uint32).reshape(struct.periods, struct.columns)
    periods = np.arange(struct.first_period, struct.first_period + struct.periods, dtype=np.uint32)
    return Trace([row_by_id(struct.rows[n]) for n in range(struct.columns)], periods, slots, library.name)


def sweep(scenario, grid, threads=None, **options):
    """Runs a scenario for each combination of values, on all cores: `sweep("cold_start", {"plant.inertia": [0.003, 0.06]})`.

    grid: rows, each with a list of values; options: as of run. Returns a list of (values, Result) in the order of the grid; for a
    refused setting the list has the Error instead of the Result."""
    fixed = options.pop("set", None) or {}
    points = [dict(zip(grid, values)) for values in itertools.product(*grid.values())]

    def one(point):
        try:
            return run(scenario, set={**fixed, **point}, **options)
        except Error as error:
            return error

    with concurrent.futures.ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        return list(zip(points, pool.map(one, points)))
