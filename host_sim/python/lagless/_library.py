"""The shared library: its path, the arguments of its functions, and the layout of its structs (host_sim/python/binding.h)."""
import ctypes as c
import os
import pathlib

from ._errors import Error

# In a wheel the library is in the folder of this file; LAGLESS_LIBRARY names another one, for example for the tests of a build.
PATH = os.environ.get("LAGLESS_LIBRARY") or str(pathlib.Path(__file__).with_name("liblagless.so"))

# The library of motors in a wheel, because the folder from which the wheel was built may not exist any more.
_MOTORS = pathlib.Path(__file__).with_name("motors")
if _MOTORS.is_dir():
    os.environ.setdefault("LAGLESS_MOTORS", str(_MOTORS))

WHY_SIZE = 1200
NEVER = 0xFFFFFFFF

b, u32, u64, i32, i64, f64, text, p = (c.c_bool, c.c_uint32, c.c_uint64, c.c_int32, c.c_int64, c.c_double, c.c_char_p,
                                       c.c_void_p)


def _struct(of, /, **fields):
    return type(of, (c.Structure,), {"_fields_": list(fields.items())})


Row = _struct("Row", id=u32, kind=u32, access=u32, table=text, name=text, key=text, unit=text, text=text, choices=text,
              initial=f64, min=f64, max=f64)
Samples = _struct("Samples", slots=p, periods=p, room=u64, used=u64)
About = _struct("About", title=text, source=text, unsuited=text, seed=u64, periods=u32, every=u32, record=c.POINTER(u32),
                record_count=u32, expect_count=u32)
Place = _struct("Place", line=u32, column=u32)
ScenarioError = _struct("ScenarioError", file=c.c_char * 256, place=Place, name=c.c_char * 96, message=c.c_char * 640, board=c.c_char * 64)
Outcome = _struct("Outcome", seed=u64, hash=u64, seconds=f64, end=u32, failed=u32, periods=u32, fault_period=u32, state=i32,
                  fault_reason=i32, refusal=i32, not_on=i32, manoeuvre=i32)
Verdict = _struct("Verdict", name=text, statistic=text, value=f64, at_least=f64, at_most=f64, begin=f64, end=f64, id=u32,
                  minus=u32, samples=u32, judgement=u32, measure=u32)
Truth = _struct("Truth", **{name: f64 for name in (
    "theta_e", "omega_e", "theta_m", "omega_m", "torque", "load_torque", "i_a", "i_b", "i_c", "i_d", "i_q", "u_alpha", "u_beta",
    "flux_alpha", "flux_beta", "dc_voltage", "leg_a", "leg_b", "leg_c", "shoot_throughs", "shoot_through_second",
    "shoot_through_leg", "fault_line", "shut_gates", "energy_dc", "energy_copper", "energy_inverter", "energy_mechanical",
    "energy_magnetic", "energy_kinetic", "omega_load", "twist", "shaft_torque")})
PlantNow = _struct("PlantNow", truth=Truth, i_a=f64, i_b=f64, i_c=f64, u_dc=f64, encoder=i64, seconds=f64)
Progress = c.CFUNCTYPE(c.c_int, f64)
Ask = _struct("Ask", seed=u64, record=c.POINTER(u32), record_count=u32, record_every=u32, samples=c.POINTER(Samples),
              progress=Progress)
History = _struct("History", rows=c.POINTER(u32), slots=p, columns=u32, periods=u32, first_period=u32, fault_reason=i32)
Keep = c.CFUNCTYPE(c.c_int, u32, text, text)
Campaign = _struct("Campaign", seed=u64, seconds=f64, runs=u32, shard=u32, shards=u32, threads=u32, keep=Keep)
Plate = _struct("Plate", pole_pairs=f64, current=f64, speed=f64)
StepDone = c.CFUNCTYPE(u32, u32, u32)
Commission = _struct("Commission", seed=u64, plate=Plate, skip=u32, chosen=u32, progress=StepDone, link=f64, direction=f64, turns=f64)
Value = _struct("Value", value=f64, error=f64)
MeasuredPoint = _struct("MeasuredPoint", step=u32, x=f64, y=f64)
Commissioned = _struct("Commissioned", **{name: Value for name in (
    "resistance", "inductance_d", "inductance_q", "saturation_current", "flux_linkage", "inertia", "friction_coulomb", "friction_viscous", "dead_voltage",
    "current_zone")}, flux_first=f64, inertia_first=f64, angle_d=f64, loop_gain=f64, least_speed=f64, turns=f64, reversed=b, step=u32, reason=c.c_char * 48, what=c.c_char * 400,
    seconds=f64, step_seconds=f64 * 11, largest_current=f64, largest_heat=f64, points_count=u32, points=MeasuredPoint * 1000)

Board = _struct("Board", name=text, current_range=f64, current_per_code=f64, current_limit=f64, current_trip=f64, undervoltage=f64,
                overvoltage=f64, overvoltage_max=f64, nominal=f64, clock=f64, period=f64, dead_time=f64, sensors=c.c_int, shunts=b)

# The type of the result, then those of the arguments.
_FUNCTIONS = {
    "layout": (u32,),
    "period": (f64,),
    "version": (text,),
    "board": (text,),
    "boards": (c.POINTER(Board), u32),
    "no_board": (None, text, text),
    "row": (b, u32, c.POINTER(Row)),
    "value": (b, u32, text, c.POINTER(f64), text),
    "reason": (b, i32, c.POINTER(text), c.POINTER(text), c.POINTER(text)),
    "seconds": (None, p, p, u64),
    "rig_create": (p, u64),
    "rig_free": (None, p),
    "rig_run": (u32, p, u32),
    "rig_period": (u32, p),
    "rig_get": (b, p, u32, c.POINTER(f64)),
    "rig_set": (b, p, u32, f64),
    "rig_apply": (b, p),
    "rig_set_motion": (None, p, f64, f64),
    "rig_power_cycle": (None, p),
    "rig_stop_when": (b, p, u32, u32, f64),
    "rig_tap": (b, p, c.POINTER(u32), u32, u32, c.POINTER(Samples)),
    "rig_error": (text, p),
    "rig_state_size": (u64,),
    "rig_save": (None, p, text),
    "rig_load": (b, p, text, u64),
    "rig_hash": (u64, p),
    "scenario_read": (p, text, text, u64, c.POINTER(ScenarioError), text),
    "scenario_free": (None, p),
    "scenario_override": (b, p, text, c.POINTER(ScenarioError), text),
    "scenario_check": (b, p, c.POINTER(ScenarioError), text),
    "scenario_about": (None, p, c.POINTER(About)),
    "scenario_initial": (f64, p, u32),
    "run": (p, p, c.POINTER(Ask), c.POINTER(ScenarioError), text),
    "run_free": (None, p),
    "outcome": (None, p, c.POINTER(Outcome), text),
    "verdict": (None, p, u32, c.POINTER(Verdict), text),
    "history": (b, p, c.POINTER(History)),
    "plant_create": (p, u64, u32, u32, b),
    "plant_free": (None, p),
    "plant_set": (b, p, c.POINTER(u32), c.POINTER(f64), u32, text),
    "plant_get": (b, p, u32, c.POINTER(f64)),
    "plant_set_motion": (None, p, f64, f64),
    "plant_step": (None, p, c.POINTER(f64)),
    "plant_now": (None, p, c.POINTER(PlantNow)),
    "campaign_head": (b, c.POINTER(Campaign), text),
    "campaign": (b, c.POINTER(Campaign), text),
    "campaign_summary": (p, text, b, text),
    "commission_step": (text, u32, c.POINTER(text)),
    "commission_answer": (f64, text, text, c.POINTER(text)),
    "commission": (b, p, c.POINTER(Commission), c.POINTER(Commissioned), text),
    "free": (None, p),
}


def _layout():
    sizes = [c.sizeof(struct) for struct in (Row, Samples, About, ScenarioError, Outcome, Verdict, Truth, PlantNow, Campaign,
                                             Ask, History, Commission, Commissioned, Board)]
    known = 2166136261
    for size in sizes:
        known = ((known ^ size) * 16777619) & 0xFFFFFFFF
    return known


class _Library:
    def __init__(self, path):
        try:
            library = c.CDLL(path)
        except OSError as error:
            raise ImportError(f"lagless: its library cannot be loaded ({error}); build it with `pip install .` in the project's "
                              "folder, or name a built one in LAGLESS_LIBRARY") from None
        for name, (result, *arguments) in _FUNCTIONS.items():
            function = getattr(library, "binding_" + name)
            function.restype, function.argtypes = result, arguments
            setattr(self, name, function)
        if self.layout() != _layout():
            raise ImportError(f"lagless: {path} is of another version than this package; install the package again")
        self.name = self.board().decode()  # of the board that it simulates


library = _Library(PATH)  # of the default board
_loaded = {library.name: library}


def of(board=None):
    """The library of a board, in boards/NAME/ next to that of the default board; None: the default board."""
    if board is None:
        return library
    if board not in _loaded:
        text = why()
        library.no_board(str(board).encode(), text)
        if text.value:
            raise Error(f"board = {board!r}: {text.value.decode()}", "board")
        path = pathlib.Path(PATH)
        _loaded[board] = _Library(str(path.parent / "boards" / board / path.name))
    return _loaded[board]


def why():
    """A buffer for the text of a refusal."""
    return c.create_string_buffer(WHY_SIZE)
