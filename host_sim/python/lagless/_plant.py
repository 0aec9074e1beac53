"""Inverter, motor, shaft and sensors without chip and firmware, for a user's controller or estimator."""
import ctypes as c
import dataclasses

from ._errors import Error
from ._library import PlantNow, library, why
from ._motulator import plant_rows
from ._rows import row, rows

_TICK = 1 / 150e6  # [s]


@dataclasses.dataclass(frozen=True)
class PlantState:
    """The plant at the end of a period, when a drive samples.

    i_a, i_b, i_c [A], u_dc [V], encoder [counts]: as measured by the sensors, with errors and noise; theta_e [rad] and
    omega_e [rad/s] electrical, theta_m (unwrapped) and omega_m mechanical, torque [N m], i_d, i_q [A]: true values; t [s].
    `truth` has all other true values of the plant, by name."""
    t: float
    i_a: float
    i_b: float
    i_c: float
    u_dc: float
    encoder: int
    theta_e: float
    omega_e: float
    theta_m: float
    omega_m: float
    torque: float
    i_d: float
    i_q: float
    truth: object = dataclasses.field(repr=False)


class Plant:
    """The plant of every scenario, stepped by carrier periods with duties from Python.

        plant = lagless.Plant(seed=1, inertia=0.003, load_torque="1 N m")     # rows of the table plant, by name or
        plant = lagless.Plant(n_p=4, R_s=0.95, L_d=0.0125, L_q=0.0125, psi_f=0.183, J=0.003)     # in motulator's names
        now = plant.state
        while now.t < 1.0:
            now = plant.step(controller(now))     # three duties 0..1; None: all gates off

    period, dead_time [s]: of the carrier and of the dead band that duties get; switched: every edge of the gates, or (False)
    their mean voltage, which is faster; delay: number of periods until a duty acts, 1 as in a drive
    that computes during the period, 0 for a controller without delay.

    The same seed gives the same bits. The plant starts at standstill, without current, with all gates off."""

    def __init__(self, seed=1, period=1e-4, dead_time=2.5e-6, switched=True, delay=1, **values):
        ticks, dead = round(period / _TICK), round(dead_time / _TICK)
        if not 150 <= ticks <= 150000000:
            raise Error(f"period = {period!r}: accepted: 1e-6 to 1 s", "period")
        if not 0 <= dead < ticks / 4:
            raise Error(f"dead_time = {dead_time!r}: accepted: 0 to a quarter of the period", "dead_time")
        if not isinstance(delay, int) or delay < 0:
            raise Error(f"delay = {delay!r}: accepted: whole numbers from 0", "delay")
        self._plant = library.plant_create(seed, ticks, dead, not switched)
        if not self._plant:
            raise MemoryError("no memory for a plant")
        self.period = ticks * _TICK
        self._waiting = [None] * delay
        self._now = PlantNow()
        if values:
            self.set(**values)
        self._look()

    def close(self):
        """Frees the memory; the object cannot be used afterwards."""
        if getattr(self, "_plant", None):
            library.plant_free(self._plant)
            self._plant = None

    __del__ = close

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def _open(self):
        if not self._plant:
            raise Error("the plant is closed; create a new Plant")
        return self._plant

    def set(self, values=None, **more):
        """Sets rows of the table plant from now on, either all of them or none. motulator's names are accepted as well."""
        found = [(_row(name), value) for name, value in plant_rows({**(values or {}), **more}).items()]
        numbers = (c.c_uint32 * len(found))(*[one.id for one, _ in found])
        wanted = (c.c_double * len(found))(*[one.number(value) for one, value in found])
        refusal = why()
        if not library.plant_set(self._open, numbers, wanted, len(found), refusal):
            raise Error(refusal.value.decode(), refusal.value.decode().partition(" ")[0])

    def get(self, name):
        """Value of a row of the table plant."""
        value = c.c_double()
        library.plant_get(self._open, _row(*plant_rows({name: 0.0})).id, c.byref(value))
        return value.value

    __getitem__ = get

    def set_motion(self, angle=0.0, speed=0.0):
        """Turns the rotor: mechanical angle [rad] and speed [rad/s]."""
        library.plant_set_motion(self._open, float(angle), float(speed))
        self._look()

    def step(self, duties):
        """One carrier period; `duties` of legs a, b, c act `delay` periods later. Returns the state at its end."""
        if duties is not None:
            if len(duties) != 3:
                raise Error(f"{len(duties)} duties; accepted: three, or None", "duties")
            duties = (c.c_double * 3)(*duties)
        self._waiting.append(duties)
        library.plant_step(self._open, self._waiting.pop(0))
        return self._look()

    def _look(self):
        now = self._now
        library.plant_now(self._open, c.byref(now))
        truth = type(now.truth).from_buffer_copy(now.truth)
        self.state = PlantState(now.seconds, now.i_a, now.i_b, now.i_c, now.u_dc, now.encoder, truth.theta_e, truth.omega_e,
                                truth.theta_m, truth.omega_m, truth.torque, truth.i_d, truth.i_q, truth)
        return self.state


def _row(name):
    table = rows("plant")
    found = table.get("plant." + name) or table.get(name)
    if found is None:
        return row("plant." + name.rpartition(".")[2])
    return found
