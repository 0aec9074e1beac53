"""Commissioning: the drive measures an unknown motor by itself, as with `lagless commission`."""
import ctypes as c
import dataclasses
import math

from ._errors import Error
from ._library import Commission, Commissioned, StepDone, library, why
from ._rows import row
from ._scenario import _Scenario

_MEASURED = ("resistance", "inductance_d", "inductance_q", "saturation_current", "flux_linkage", "inertia", "friction_coulomb", "friction_viscous",
             "dead_voltage", "current_zone")
# The attributes of the result that are keys of [motor].
_OF_MOTOR = _MEASURED[:-2]
# Key of the plate -> field, factor, and the row whose unit its text may have.
_PLATE = {
    "pole_pairs": ("pole_pairs", 1.0, "motor_pole_pairs"),
    "rated_current_peak": ("current", 1.0, "motor_current_continuous"),
    "rated_current_rms": ("current", math.sqrt(2.0), "motor_current_continuous"),
    "rated_speed": ("speed", 1.0, "overspeed_trip"),
}


@dataclasses.dataclass(frozen=True)
class Measured:
    """A value with its uncertainty, both in SI units; NaN: not measured."""
    value: float
    error: float

    def __float__(self):
        return self.value


class Commissioning:
    """The result. resistance, inductance_d, inductance_q, saturation_current, flux_linkage, inertia, friction_coulomb, friction_viscous,
    dead_voltage, current_zone: each a Measured; saturation_current is 0 if no saturation was measured. reason: None, or the name of the reason
    for the end, described by text; step: the last one that ran; seconds: simulated, step_seconds: of each step; largest_current: of a phase [A];
    largest_heat: copper loss, averaged by the motor's time constant, over that of the rated current;
    angle_d: direction of the d axis of a held rotor, electrical [rad]; loop_gain: of the current loop over its design; least_speed: without an
    encoder [rad/s]; turns: of the shaft in the step turn, as answered, reversed: it turned backward; NaN: not measured.
    points: for the name of each step that measures points, the list of its points (x, y), from which its values follow. The quantities are
    those of the signals commission_point_x and commission_point_y."""

    def __init__(self, plate, result, steps):
        for name in _MEASURED:
            value = getattr(result, name)
            setattr(self, name, Measured(value.value, value.error))
        self.plate = plate
        self.step = steps[result.step]
        self.reason = result.reason.decode() or None
        self.text = result.what.decode() or None
        self.angle_d, self.loop_gain, self.least_speed, self.turns, self.reversed = result.angle_d, result.loop_gain, result.least_speed, result.turns, bool(result.reversed)
        self.seconds, self.largest_current, self.largest_heat = result.seconds, result.largest_current, result.largest_heat
        self.step_seconds = dict(zip(steps, result.step_seconds))
        self.points = {}
        for point in result.points[:result.points_count]:
            self.points.setdefault(steps[point.step], []).append((point.x, point.y))

    @property
    def passed(self):
        """True: all requested steps have a result."""
        return self.reason is None

    def motor(self):
        """The measured values as the table `motor` of a scenario: lagless.run({..., "motor": result.motor()})."""
        missing = [name for name in ("resistance", "inductance_q", "flux_linkage") if math.isnan(float(getattr(self, name)))]
        if missing:
            raise Error(f"{missing[0]} is not measured, because {self.reason or 'its step was left out'}; a motor needs resistance, "
                        "inductance_q and flux_linkage", missing[0])
        values = {name: float(getattr(self, name)) for name in _OF_MOTOR}
        return {**self.plate, **{name: value for name, value in values.items() if not math.isnan(value) and (value or name != "saturation_current")}}

    def __str__(self):
        lines = [f"{name:17} {one.value:12.5g} +- {one.error:.2g}" for name, one in ((name, getattr(self, name)) for name in _MEASURED)
                 if not math.isnan(one.value)]
        end = f"commissioned in {self.seconds:.1f} s" if self.passed else f"{self.reason} in {self.step}: {self.text}"
        return "\n".join([*lines, f"{end}, largest current {self.largest_current:.3g} A"])


def _steps():
    names, text = [], c.c_char_p()
    while (name := library.commission_step(len(names), c.byref(text))) is not None:
        names.append(name.decode())
    return names


def _answer(question, text):
    """The number of an answer; 0: none is given."""
    accepted = c.c_char_p()
    value = library.commission_answer(question.encode(), str(text).encode(), c.byref(accepted))
    if accepted.value is None:
        raise Error(f"answers: {question}: accepted: direction, turn", "answers")
    if text is not None and not value:
        raise Error(f"answers: {question} = {text!r}: accepted: {accepted.value.decode()}", "answers")
    return value if text is not None else 0.0


def commission(scenario, plate=None, steps=None, set=None, seed=None, progress=None, board=None, link=None, answers=None):
    """Measures the motor of a scenario by the drive itself, step by step, and returns a Commissioning.

    The values of the motor that the scenario has are not used. plate: pole_pairs, rated_current_peak or rated_current_rms, rated_speed;
    missing values are those of the scenario's parameters. steps: names of the steps to run (default: all); the steps whose results they need
    run as well. set, seed, board: as of run. link: the voltage of the DC link by a meter, as a number [V] or a text with unit. answers: what a
    user sees in the step turn, {"direction": "as_said" or "reversed", "turn": "one" or a number}; without answers the step is left out, unless
    steps contains it: then the simulated motor answers. progress: called with a step's name and False before each try, True after it; an
    exception that it raises, also KeyboardInterrupt, opens the bridge and ends the commissioning.

        result = lagless.commission("cold_start", plate={"pole_pairs": 4, "rated_current_peak": "10 A", "rated_speed": "1500 r/min"})
        print(result)
        lagless.run({"title": "...", "motor": result.motor(), ...})"""
    names = _steps()
    how, result, refusal, raised = Commission(), Commissioned(), why(), []
    for key, value in (plate or {}).items():
        if key not in _PLATE:
            raise Error(f"plate: {key}: accepted: {', '.join(_PLATE)}", key)
        field, factor, of = _PLATE[key]
        number = factor * row(of).number(value)
        if not 0 < number < math.inf:
            raise Error(f"plate: {key} = {value!r}: accepted: positive values", key)
        setattr(how.plate, field, number)
    if steps is not None:
        chosen = [steps] if isinstance(steps, str) else list(steps)
        unknown = [name for name in chosen if name not in names]
        if unknown or not chosen:
            raise Error(f"steps: {unknown[0] if unknown else 'no name is given'}: accepted: {', '.join(names)}", "steps")
        how.chosen = 1
        how.skip = sum(1 << n for n, name in enumerate(names) if name not in chosen)

    if link is not None:
        how.link = row("plant.dc_voltage").number(link)
        if not 0 < how.link < math.inf:
            raise Error(f"link = {link!r}: accepted: positive voltages", "link")
    how.direction, how.turns = (_answer(question, (answers or {}).get(question)) for question in ("direction", "turn"))
    for question in answers or {}:
        _answer(question, answers[question])

    def on_step(step, done):
        try:
            if progress is not None and not raised and done < 2:
                progress(names[step], bool(done))
        except BaseException as error:  # raised again when the library has returned
            raised.append(error)
        return 0 if raised else 1

    how.progress = StepDone(on_step)
    with _Scenario(scenario, board) as read:
        read.override(set)
        how.seed = read.about().seed if seed is None else int(seed)
        accepted = read.library.commission(read.handle, c.byref(how), c.byref(result), refusal)
    if raised:
        raise raised[0]
    if not accepted:
        raise Error(refusal.value.decode(errors="replace"), "plate")
    known = {"pole_pairs": round(how.plate.pole_pairs), "rated_current_peak": how.plate.current, "rated_speed": how.plate.speed}
    return Commissioning(known, result, names)
