"""The simulation in closed loop: firmware on the virtual chip, inverter, motor, sensors. One object, which runs period by period."""
import ctypes as c
import operator
import os

from ._errors import Error
from ._library import Samples, of
from ._result import Recorder, Trace, reason
from ._rows import ids, periods_of, row, rows

_COMPARE = {"==": (1, operator.eq), "!=": (2, operator.ne), ">": (3, operator.gt), "<": (4, operator.lt)}
# A state contains addresses of functions, the interrupt vectors. They differ from process to process, so that this address identifies the
# process.
def _place(library):
    return f"{c.cast(library.rig_run, c.c_void_p).value:016x}{os.getpid():08x}".encode()


_CHUNK = 10000  # [periods] between two checks for Ctrl-C


class Rig:
    """Switches the power on: defaults of firmware and plant, rotor at standstill, `seed` for all noise, on a board of boards().

        with lagless.Rig(seed=1) as rig:
            rig.set(enable="on", speed_request="500 r/min")
            trace = rig.run("1 s", record=["true_omega_m", "i_q"])

    The same calls with the same seed give the same bits as the command line. A process can have any number of independent rigs, also in
    several threads (a running rig lets other threads of Python run); only one thread at a time may use a rig."""

    def __init__(self, seed=1, board=None, **values):
        self._library = of(board)
        self.board = self._library.name
        self._rig = self._library.rig_create(seed)
        if not self._rig:
            raise MemoryError("no memory for a rig")
        if values:
            self.set(**values)

    def close(self):
        """Frees the memory; the object cannot be used afterwards."""
        if getattr(self, "_rig", None):
            self._library.rig_free(self._rig)
            self._rig = None

    __del__ = close

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self):
        return f"<Rig at {self.t:g} s, {self['state']}>" if self._rig else "<Rig, closed>"

    @property
    def _open(self):
        if not self._rig:
            raise Error("the rig is closed; create a new Rig")
        return self._rig

    def _refused(self, name=""):
        return Error(self._library.rig_error(self._open).decode(), name)

    # ---- values ----

    def get(self, name):
        """Value of any row: a float in its unit, a whole number, or the name of a choice. A parameter has the value of the active set."""
        found = row(name, self.board)
        return found.value(self._number(found))

    __getitem__ = get

    def _number(self, found):
        value = c.c_double()
        if not self._library.rig_get(self._open, found.id, c.byref(value)):
            raise self._refused(found.key)
        return value.value

    def set(self, values=None, **more):
        """Sets rows by name, either all of them or none: `rig.set(enable="on")`, `rig.set({"plant.inertia": 0.01, "load_torque": "2 N
        m"})`.

        Parameters are judged as one set and act from the next period on; all other rows act at once."""
        pending = [(row(name, self.board), row(name, self.board).number(value)) for name, value in {**(values or {}), **more}.items()]
        before = self.save() if len(pending) > 1 or any(one.table == "params" for one, _ in pending) else None
        parameters = any(one.table == "params" for one, _ in pending)
        while pending:  # some rows accept a value only after another has changed
            left = [(one, value) for one, value in pending if not self._library.rig_set(self._open, one.id, value)]
            if len(left) == len(pending):
                break
            pending = left
        if pending:
            self._library.rig_set(self._open, pending[0][0].id, pending[0][1])  # whose refusal is reported
        if pending or (parameters and not self._library.rig_apply(self._open)):
            error = self._refused(pending[0][0].key if pending else "")
            if before is not None:
                self.load(before)
            raise error

    def __setitem__(self, name, value):
        self.set({name: value})

    def values(self, table=None):
        """All rows, or those of one table, as a dict."""
        return {key: self.get(key) for key in rows(table, self.board)}

    def set_motion(self, angle=0.0, speed=0.0):
        """Sets the rotor to this true mechanical angle [rad] and speed [rad/s]; the count of the encoder is set as by an alignment."""
        self._library.rig_set_motion(self._open, float(angle), float(speed))

    @property
    def fault(self):
        """The latched fault, or None."""
        return reason(int(self["fault_reason"]), int(self["fault_period"]), self.board)

    @property
    def refusal(self):
        """The reason why the drive does not follow a request now, or None."""
        return reason(int(self["refusal"]))

    # ---- time ----

    @property
    def period(self):
        """Periods since creation."""
        return self._library.rig_period(self._open)

    @property
    def t(self):
        """Simulated time [s]."""
        return self.period * self._library.period()

    def step(self):
        """One PWM period."""
        self._library.rig_run(self._open, 1)

    def run(self, time, record=(), every=1, until=None, progress=None):
        """Runs for `time` (periods as int, seconds as float or text) and returns a Trace of the rows of `record`, one sample
        in `every` periods.

        until: (name, "==" | "!=" | ">" | "<", value) ends the run after the period in which this condition is met; progress:
        called with the completed share, about every second of simulated time."""
        count, chosen = periods_of(time, board=self.board), ids([record] if isinstance(record, str) else list(record), self.board)
        if isinstance(every, bool) or not isinstance(every, int) or every < 1:
            raise Error(f"every = {every!r}: accepted: whole numbers from 1", "every")
        recorder = Recorder(chosen[1], (count + every - 1) // every if chosen[1] else 0)
        met = self._stop_when(*until) if until is not None else None
        if chosen[1] and not self._library.rig_tap(self._open, chosen[0], len(chosen[1]), every, c.byref(recorder.struct)):
            raise self._refused("record")
        try:
            done = 0
            while done < count:
                wanted = min(_CHUNK, count - done)
                ran = self._library.rig_run(self._open, wanted)
                done += ran
                if progress is not None:
                    progress(done / count)
                if ran < wanted or (met is not None and met()):
                    break
        finally:
            self._library.rig_tap(self._open, chosen[0], 0, 1, c.byref(recorder.struct))
            self._library.rig_stop_when(self._open, row("state").id, 0, 0.0)
        return Trace(*recorder.taken(), self.board)

    def _stop_when(self, name, compare, limit):
        found = row(name, self.board)
        if compare not in _COMPARE:
            raise Error(f"until: {compare!r}: accepted: {', '.join(_COMPARE)}", "until")
        number, compares = _COMPARE[compare]
        limit = found.number(limit)
        if not self._library.rig_stop_when(self._open, found.id, number, limit):
            raise self._refused(name)
        return lambda: compares(self._number(found), limit)

    # ---- state ----

    def save(self):
        """The whole state as bytes. A run that continues from this state gives the same bits in this rig and in any other rig of this
        process."""
        state = c.create_string_buffer(self._library.rig_state_size())
        self._library.rig_save(self._open, state)
        return _place(self._library) + state.raw

    def load(self, state):
        """Returns to a saved state."""
        place = _place(self._library)
        if state[:len(place)] != place:
            raise Error("this state was saved by another process or by a rig of another board; load it in the process that saved it, in a "
                        "rig of the same board", "state")
        octets = state[len(place):]
        if not self._library.rig_load(self._open, octets, len(octets)):
            raise self._refused("state")

    @property
    def hash(self):
        """Hash of the whole state, 16 hexadecimal digits. Equal states have equal hashes on every machine."""
        return f"{self._library.rig_hash(self._open):016x}"

    def power_cycle(self):
        """Switches the supply of the control board off and on: the drive starts again, and the rotor coasts during this time."""
        self._library.rig_power_cycle(self._open)
