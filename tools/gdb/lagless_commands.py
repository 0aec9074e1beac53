"""The commands: moving in simulated time, and displaying the state.

The simulation is deterministic. To go back, the commands run the program again from its start, with LAGLESS_STOP=PERIOD in its environment.
The program then calls rig_stop_at() before that period; the interrupt follows a few microseconds later. Loaded by lagless.py."""
import functools
import os
import re
import sys

import gdb
import lagless_printers as show
import lagless_registers as registers
import lagless_time as time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
INTERRUPT = "app_interrupt"  # the sample interrupt
NO_RIG = (gdb.error, gdb.GdbError)  # the exceptions when the rig is read before it exists


# ---- The simulation in the memory of the program ---------------------------------------------------------------------------------


def program_lives():
    return gdb.selected_inferior().pid != 0


def offset_of(struct, *path):
    """Offset [octets] and type of a nested field."""
    offset, here = 0, struct
    for name in path:
        field = here.strip_typedefs()[name]
        offset += field.bitpos // 8
        here = field.type
    return offset


def current_rig():
    """The rig whose interrupt runs: the one around `app`, which the rig sets before each period."""
    if not program_lives():
        raise gdb.GdbError("no program is running: 'period N' or 'until-fault' starts it")
    try:
        app = show.global_value("app")
        if int(app) == 0:
            raise gdb.GdbError("there is no rig yet, because the program has not made it; 'period 0' goes to its first interrupt")
        rig = gdb.lookup_type("struct rig")
        address = int(app) - offset_of(rig, "state", "app")
        return gdb.Value(address).cast(rig.pointer())
    except gdb.error:
        if gate.rig is None:  # thread-local variables need libthread_db, which not every machine has
            raise
        return gate.rig


def ring():
    return current_rig()["state"]


def present_period():
    return int(ring()["period"])


def period_ticks():
    """Ticks [1/150 MHz] of one period, as the program was built; known before it runs."""
    return int(show.global_value("rig_period_ticks"))


def place_text():
    """The simulated time."""
    state = ring()
    ticks = period_ticks()
    period = int(state["period"])
    if int(state["start"]) == 0:
        return "before period 0, while the board starts"
    # of a replay, period 0 lies before the start of the clock
    after = (int(state["chip"]["tick"]) - int(state["start"]) - period * ticks + 2**63) % 2**64 - 2**63
    sign, length = "+" if after >= 0 else "-", float(abs(after) * time.TICK * 10**6)
    return f"period {period}, {time.seconds(period, ticks)} {sign} {length:.2f} us"


# ---- Travelling ---------------------------------------------------------------------------------------------------------

DRIVE_SOURCES = re.compile(r"/firmware/(drive|fast|medium)/")  # the two tasks and the functions that connect them


class Entry(gdb.Breakpoint):
    """The interrupt's first line. Enabled only from rig_stop_at() to the next interrupt, because it slows the
    program down."""

    def __init__(self):
        super().__init__(function=INTERRUPT, internal=True)
        self.enabled = False
        self.silent = True  # the commands print the position
        self.hit = False
        self.pc = None

    def stop(self):
        self.hit = True
        self.pc = gdb.newest_frame().pc()
        return True


class Gate(gdb.Breakpoint):
    """The stop hook of the rig: the requested period begins."""

    def __init__(self):
        super().__init__(function="rig_stop_at", internal=True)
        self.rig = None
        self.hit = False

    def stop(self):
        self.hit = True
        try:
            self.rig = gdb.newest_frame().read_var("rig")
        except (ValueError, gdb.error):
            self.rig = None
        entry.enabled = True
        return False


class Freed(gdb.Breakpoint):
    """A rig is freed: stores its number of periods. A rig that only checks a scenario has no periods."""

    def __init__(self):
        super().__init__(function="rig_free", internal=True)
        self.periods = 0

    def stop(self):
        try:
            rig = gdb.newest_frame().read_var("rig")
            if int(rig) != 0:
                self.periods = max(self.periods, int(rig["state"]["period"]))
        except (ValueError, gdb.error):
            pass
        return False


class Fault(gdb.Breakpoint):
    """The place where the state of the drive becomes `fault`: only there the drive triggers its capture.
    The called function is in another file, so that the compiler keeps the call at every level of optimisation, while it may inline
    show_fault() itself."""

    def __init__(self):
        super().__init__(function="capture_trigger", internal=True)
        self.enabled = False
        self.silent = True
        self.hit = False

    def stop(self):
        frame = gdb.newest_frame()
        self.hit = frame.type() != gdb.INLINE_FRAME and DRIVE_SOURCES.search(file_of(frame.older()))
        return self.hit


class Begun(gdb.Breakpoint):
    """Directly after the drive's step: tests whether the requested manoeuvre has begun since the last step. It is enabled only while a
    command waits for it."""

    def __init__(self):
        super().__init__(function="app_write", internal=True)
        self.enabled = False
        self.silent = True
        self.hit = False
        self.wanted = self.last = None

    def wait_for(self, wanted, last):
        self.wanted, self.last = wanted, last
        self.enabled = True

    def stop(self):
        now = present_manoeuvre()
        self.hit = now == self.wanted and now != self.last
        self.last = now
        return self.hit


def present_manoeuvre():
    return int(ring()["app"]["drive"]["medium"]["manoeuvres"]["now"])


def file_of(frame):
    """Full name of the source file of a frame; "" if there is none."""
    symtab = frame.find_sal().symtab
    return symtab.fullname() if symtab else ""


class Landing(gdb.Breakpoint):
    """The return address of a function. (gdb's own FinishBreakpoint misses callers that are inlined themselves.)"""

    def __init__(self, pc):
        super().__init__(f"*{pc:#x}", internal=True, temporary=True)
        self.silent = fault.silent
        self.hit = False

    def stop(self):
        self.hit = True
        return True


def disarm():
    for breakpoint in (entry, fault, begun):
        if breakpoint.enabled:
            breakpoint.enabled = False


def on_stop(_):
    """gdb calls this after every stop. It handles a stop for which no command of this file waits, because the user started the program with
    LAGLESS_STOP."""
    armed = entry.enabled
    disarm()
    if armed and entry_hit() and not travelling:
        tell_place()


def entry_hit():
    return entry.hit


def forget_rig(_):
    gate.rig = None


class FrontEnd(gdb.Parameter):
    """The user interface. cli: gdb itself. ide: a program that controls gdb (VS Code), to which gdb reports every stop. When going back,
    the new process starts before the old one ends, because such a program ends its session with the last process."""

    set_doc = "Set the interface to the user: gdb's own command line or an IDE."
    show_doc = "Show the interface to the user: gdb's own command line or an IDE."

    def __init__(self):
        super().__init__("lagless-front-end", gdb.COMMAND_RUNNING, gdb.PARAM_ENUM, ["cli", "ide"])
        self.value = "cli"

    def get_set_string(self):
        for breakpoint in (entry, fault, begun):
            breakpoint.silent = self.value == "cli"
        return ""

    def get_show_string(self, value):
        return f"The interface to the user: {value}."


def quietly(command):
    return gdb.execute(command, to_string=True)


def run_again(stop_before):
    """Start the program from its beginning, without the user's breakpoints."""
    if stop_before is None:
        environment = "unset environment LAGLESS_STOP"
    else:
        environment = f"set environment LAGLESS_STOP {stop_before}"
    if not program_lives():
        quietly(environment)
        quietly("run")
        return

    old = None
    if front_end.value == "ide":
        old = gdb.selected_inferior().num
        known = {inferior.num for inferior in gdb.inferiors()}
        quietly("clone-inferior")
        new = next(inferior.num for inferior in gdb.inferiors() if inferior.num not in known)
        quietly(f"inferior {new}")
    quietly(environment)
    sleeping = [breakpoint for breakpoint in gdb.breakpoints() if breakpoint.enabled and breakpoint.number > 0]
    for breakpoint in sleeping:
        breakpoint.enabled = False
    try:
        quietly("run")
    finally:
        for breakpoint in sleeping:
            if breakpoint.is_valid():
                breakpoint.enabled = True
        if old is not None:
            quietly(f"kill inferiors {old}")
            quietly(f"remove-inferiors {old}")


def set_stop(rig, period):
    """Does the same as rig_stop_before(), which a program with link-time optimisation does not contain as a function."""
    memory = gdb.selected_inferior()
    for name, value in (("stop_hook_set", 1), ("stop_hook_period", period)):
        field = rig[name]
        memory.write_memory(int(field.address), value.to_bytes(field.type.sizeof, sys.byteorder))


def go_on(stop_before, again):
    """Let the program run, from here or from its beginning, until something stops it."""
    global travelling
    if stop_before is not None and gate.pending and gdb.current_progspace().filename:
        raise gdb.GdbError(
            "this program has no rig_stop_at() to stop in: it is linked with optimisation across modules or not of this project; "
            "take build/debug/lagless"
        )
    travelling = True
    entry.enabled = False  # The breakpoint is still enabled if the last program ended between the gate and the first line of the interrupt.
    for breakpoint in (entry, gate, fault, begun):
        breakpoint.hit = False
    freed.periods = 0
    try:
        if again or not program_lives():
            run_again(stop_before)
            return
        if stop_before is not None:
            set_stop(current_rig(), stop_before)
        quietly("continue")
    finally:
        travelling = False


def tell_place():
    """Prints the simulated time and the position of the program; within the interrupt all its lines."""
    gdb.write(place_text() + "\n")
    gdb.execute("frame")
    here = gdb.selected_frame().find_sal()
    function = gdb.selected_frame().function()
    if here.symtab and function is not None and function.name == INTERRUPT:
        block = gdb.selected_frame().block()
        while block.function is None or block.function.name != function.name:
            block = block.superblock
        own = function.symtab
        lines = [item.line for item in own.linetable() if block.start <= item.pc < block.end]
        # In a program that is optimised across modules the first instruction may belong to a function of another file.
        first = here.line + 1 if here.symtab.filename == own.filename else function.line
        last = min(max(lines, default=0), first + 9)
        if last >= first:
            gdb.execute(f"list {own.filename}:{first},{own.filename}:{last}")


def stopped_on_the_way():
    try:
        gdb.write(f"stopped before that: {place_text()}\n")
    except NO_RIG:
        pass


def at_entry_of(period):
    frame = gdb.newest_frame()
    return frame.pc() == entry.pc and frame.name() == INTERRUPT and present_period() == period


def go_to(period):
    """Goes to the first line of the interrupt of this period; to go back, it runs the program again."""
    again = True
    if program_lives():
        try:
            if at_entry_of(period):
                tell_place()
                return
            again = period <= present_period()
        except NO_RIG:
            pass
    go_on(period, again)
    if not program_lives():
        if gate.hit:
            raise gdb.GdbError(f"no interrupt came in period {period} or later, and the program ended")
        if 0 < freed.periods <= period:
            raise gdb.GdbError(
                f"the program ended before period {period}: it has {freed.periods}, 0 to {freed.periods - 1}"
            )
        raise gdb.GdbError(
            f"the program ended before period {period} "
            "(if it has more periods than that, it does not use LAGLESS_STOP as 'lagless run' does)"
        )
    if not entry_hit():
        stopped_on_the_way()
        return
    tell_place()
    if present_period() != period:
        gdb.write(f"no interrupt came in period {period}; this is the next one\n")


# ---- Commands -----------------------------------------------------------------------------------------------------------


def one_line_errors(invoke):
    """Each error is reported in one line, without a traceback."""

    @functools.wraps(invoke)
    def guarded(self, argument, from_tty):
        try:
            invoke(self, argument.strip())
        except gdb.GdbError:
            raise
        except KeyboardInterrupt:
            raise gdb.GdbError("interrupted") from None
        except (gdb.error, ValueError, KeyError, TypeError, AttributeError, OverflowError, StopIteration) as error:
            text = " ".join(str(error).split()) or type(error).__name__
            raise gdb.GdbError(f"{self.name}: {text}") from None

    return guarded


class Command(gdb.Command):
    """A command of this file; its help text is its docstring."""

    name = ""

    def __init__(self):
        super().__init__(self.name, gdb.COMMAND_USER)

    def complete(self, text, word):
        return gdb.COMPLETE_NONE

    def no_argument(self, argument):
        if argument:
            raise gdb.GdbError(f"{self.name} takes no argument, not '{argument}'")


class Period(Command):
    """Go to a PWM period: to the first line of its interrupt.
Usage: period N | period +N | period -N

N counts from power-on, a period of the board's carrier each. With a sign: this number of periods from the present one. Forward, the program
continues, and your breakpoints stop it. Backward, the program runs again from its start, which gives the same bits, and ignores your
breakpoints."""

    name = "period"

    @one_line_errors
    def invoke(self, argument):
        sign = argument[:1]
        if not argument:
            raise gdb.GdbError("period: the number is missing; write for example 'period 5000', 'period +1' or 'period -2'")
        if sign in "+-":
            steps = time.period_number(argument[1:].strip())
            here = present_period()
            target = here + steps if sign == "+" else here - steps
            if target < 0:
                raise gdb.GdbError(f"'period {argument}' is before the start: this is period {here}")
            go_to(time.period_number(str(target)))
        else:
            go_to(time.period_number(argument))


class At(Command):
    """Go to a simulated time: to the first line of the interrupt of the period that it lies in.
Usage: at TIME

TIME counts from power-on, with a unit or in seconds: at 0.5 s, at 12.3ms, at 0.5"""

    name = "at"

    @one_line_errors
    def invoke(self, argument):
        if not argument:
            raise gdb.GdbError("at: the time is missing; write for example 'at 0.5 s'")
        go_to(time.period_of_time(argument, period_ticks()))


def limit_ahead(argument, command):
    """The period at which an until-... command stops at the latest; None: nowhere."""
    limit = time.period_number(argument) if argument else None
    if limit is not None and program_lives():
        try:
            here = present_period()
        except NO_RIG:
            here = -1
        if limit <= here:
            raise gdb.GdbError(f"{command} {limit}: this is period {here} already")
    return limit


class UntilFault(Command):
    """Go on to the period in which the drive enters fault.
Usage: until-fault [LIMIT]

Stops directly after the drive has latched the fault, so that `why` can explain it: in the interrupt that detected it or, if the medium task
detected it, in the first sample interrupt after that task has ended. At the latest stops in period LIMIT. A program
that is not running is started."""

    name = "until-fault"

    @one_line_errors
    def invoke(self, argument):
        limit = limit_ahead(argument, self.name)
        fault.enabled = True
        try:
            go_on(limit, again=False)
        finally:
            disarm()
        if not program_lives():
            raise gdb.GdbError("the program ended without a fault")
        if entry_hit():
            gdb.write(f"no fault before period {limit}\n")
            tell_place()
        elif fault.hit:
            self.leave_drive()
        else:
            stopped_on_the_way()

    @staticmethod
    def leave_drive():
        """Continues from the place where the fault is detected to the place where the drive has latched it and returns to its caller in
        app."""
        names = []
        outermost = frame = gdb.newest_frame()
        while frame is not None and "/app/" not in file_of(frame):
            if DRIVE_SOURCES.search(file_of(frame)) and frame.name() not in names:  # also for a part of a function
                names.append(frame.name())
            outermost, frame = frame, frame.older()
        while outermost.type() == gdb.INLINE_FRAME:
            outermost = outermost.older()
        landing = Landing(outermost.older().pc())
        quietly("continue")
        if not landing.hit:
            landing.delete()
            stopped_on_the_way()
            return
        UntilFault.tell_fault(" < ".join(names))

    @staticmethod
    def tell_fault(names):
        reason = int(ring()["app"]["drive"]["fault_reason"])
        gdb.write(f"fault {reason}, {show.reason_name(reason)}, by {names}\n")
        tell_place()


class UntilManoeuvre(Command):
    """Go on to the period in which the drive begins a manoeuvre.
Usage: until-manoeuvre NAME [LIMIT]

NAME is one of off, catch, align, ramp, handover, run, forced, reverse, relock. Stops in the first interrupt of the sample
after the medium task has begun it, right after the drive's step; its setpoint acts a window later. If the manoeuvre is active already,
its next beginning counts. At the latest stops in period LIMIT. A program that is not running is started."""

    name = "until-manoeuvre"

    def complete(self, text, word):
        return [name for name in show.choices("signals_table", "manoeuvre") if name.startswith(word)]

    @one_line_errors
    def invoke(self, argument):
        name, _, limit = argument.partition(" ")
        names = show.choices("signals_table", "manoeuvre")
        if name not in names:
            wrong = f"no manoeuvre '{name}'" if name else "which manoeuvre?"
            raise gdb.GdbError(f"{wrong}: {', '.join(names)}")
        limit = limit_ahead(limit.strip(), f"{self.name} {name}")
        try:
            last = present_manoeuvre() if program_lives() else None
        except NO_RIG:
            last = None
        begun.wait_for(names.index(name), last)
        try:
            go_on(limit, again=False)
        finally:
            disarm()
        if not program_lives():
            raise gdb.GdbError(f"the program ended without the manoeuvre {name}")
        if entry_hit():
            gdb.write(f"no {name} before period {limit}\n")
            tell_place()
        elif begun.hit:
            frame = gdb.newest_frame()
            (frame.older() if frame.name() == "app_write" else frame).select()
            gdb.write(f"{name}, start_try {int(ring()['app']['drive']['medium']['manoeuvres']['start_try'])}\n")
            tell_place()
        else:
            stopped_on_the_way()


class Why(Command):
    """Print why the drive is in fault, warns, or does not follow its requests, and what to do.
Usage: why

For a fault, also print the last periods before it that the drive has stored; the last one is that of the fault."""

    name = "why"
    PERIODS = 8  # periods of the history that are printed

    @one_line_errors
    def invoke(self, argument):
        self.no_argument(argument)
        state = ring()
        drive = state["app"]["drive"]
        found = False
        sequence, snapshot = drive["medium"]["sequence"], drive["fault"]
        if int(drive["fault_reason"]) != 0:
            found = True
            period = int(snapshot["period"])
            self.tell("fault", int(drive["fault_reason"]))
            gdb.write(f"  when: period {period} by the drive's count, {time.seconds(period, period_ticks())}\n")
            gdb.write(
                f"  then: i_a {show.number(snapshot['i_a'])} A, i_b {show.number(snapshot['i_b'])} A, "
                f"u_dc {show.number(snapshot['u_dc'])} V, theta_e {show.degrees(snapshot['theta_e'])}, "
                f"omega_e {show.number(snapshot['omega_e'])} rad/s\n"
            )
            if show.fault_rows_of(sequence["faults_later"]):
                gdb.write(f"  later: {show.fault_names(sequence['faults_later'], ', ')}\n")
            self.tell_history(drive["capture"])
        found = self.tell_log(drive["log"], int(drive["fault_reason"]) != 0) or found
        for row in show.fault_rows_of(drive["medium"]["guard"]["warnings"]):
            found = True
            self.tell("warning", int(row["reason"]))
        if int(sequence["refusal"]) != 0:
            found = True
            self.tell("refusal", int(sequence["refusal"]))
        found = self.tell_misuse(state["chip"]) or found
        if not found:
            gdb.write(f"nothing is wrong: the drive is in {show.choice('signals_table', 'state', drive['state'])}\n")

    @staticmethod
    def tell_log(log, latched):
        """Prints earlier faults from the drive's log, the newest first. Returns True if there are any."""
        count, kept = int(log["count"]), log["faults"].type.range()[1] + 1
        newest = count - (1 if latched else 0)
        for number in range(newest - 1, max(-1, count - kept - 1), -1):
            fault = log["faults"][number % kept]
            if int(fault["reason"]) == 0:  # a replay has only the number of the faults
                continue
            gdb.write(f"earlier: {show.reason_name(fault['reason'])} at {time.seconds(int(fault['period']), period_ticks())}, "
                      f"in {show.choice('signals_table', 'manoeuvre', fault['manoeuvre'])}\n")
        return newest > 0

    @staticmethod
    def tell(kind, number):
        name, text, remedy = show.reason_row(number)
        gdb.write(f"{kind} {number}, {name}: {text}\n  remedy: {remedy}\n")

    @staticmethod
    def tell_misuse(chip):
        """Prints the last wrong use of the chip that the simulation has detected, if there is one."""
        total = int(chip["report_total"])
        if total == 0:
            return False
        last = chip["reports"][(total - 1) % (chip["reports"].type.range()[1] + 1)]
        names = {field.enumval: field.name for field in gdb.lookup_type("chip_report_kind_t").fields()}
        kind = names.get(int(last["kind"]), f"kind {int(last['kind'])}")
        text = kind.replace("CHIP_", "").replace("_", " ").lower()
        gdb.write(
            f"chip: {total} wrong use{'s' if total > 1 else ''} found, the last at tick {int(last['tick'])}: "
            f"{text}, {register_name(int(last['address']))}\n"
        )
        return True

    @classmethod
    def tell_history(cls, capture):
        """Prints the newest periods that the capture of the drive has stored (contract/capture.h)."""
        tuning, slots, kept = capture["tuning"], capture["slots"], show.captured(capture)
        columns, width, ring = (int(tuning[name]) for name in ("columns", "width", "ring"))
        count = min(kept, cls.PERIODS)
        if count == 0:
            return
        if int(tuning["id"][0]) == 0:
            gdb.write("  the drive has kept a record for a replay (docs/replay.md)\n")
            return
        rows = show.rows_by_id("signals_table", [tuning["id"][n] for n in range(columns)])
        lines = [["period", *(show.text_at(row["name"]) for row in rows)], ["", *(show.unit_of(row) for row in rows)]]
        for ago in reversed(range(count)):
            first = (int(capture["next"]) - (ago + 1) * width) % ring
            cells = (show.slot_text(row, slots[first + n]) for n, row in enumerate(rows))
            lines.append([str(int(capture["newest"]) - ago), *cells])
        widths = [max(len(line[n]) for line in lines) for n in range(len(lines[0]))]
        gdb.write(f"  the last {count} of {kept} periods that the drive has kept:\n")
        for line in lines:
            gdb.write("    " + "  ".join(f"{cell:>{width}}" for cell, width in zip(line, widths)).rstrip() + "\n")


class Drive(Command):
    """Show the drive: state, references, currents, voltages, angle, with units.
Usage: drive

At the first line of the interrupt these are the values of the previous period, because drive_step() has not run yet. `print app->drive`
shows every field."""

    name = "drive"

    @one_line_errors
    def invoke(self, argument):
        self.no_argument(argument)
        drive = ring()["app"]["drive"]
        fast, medium, requests = drive["fast"], drive["medium"], drive["requests"]
        measured = fast["measure"]["measured"]
        n = show.number

        def line(title, text):
            gdb.write(f"{title:<11}{text}\n")

        def request(name):
            return show.choice("requests_table", name, requests[name])

        state = show.choice("signals_table", "state", drive["state"])
        line("period", f"{int(fast['period'])} by the drive's count")
        line("state", f"{state}, gates {show.gates_name(fast['command']['gates'])}")
        line("fault", show.reason_name(drive["fault_reason"]))
        line("warnings", show.fault_names(drive["medium"]["guard"]["warnings"], ", "))
        line("refusal", show.reason_name(medium["sequence"]["refusal"]))
        line(
            "requests",
            f"enable {request('enable')}, mode {request('mode')}, speed {show.rpm(requests['speed_request'])}, "
            f"i_d {n(requests['i_d_request'])} A, i_q {n(requests['i_q_request'])} A",
        )
        line("speed", f"{show.rpm(fast['omega_m'])}, reference {show.rpm(fast['demand']['omega_m_ref'])}")
        line("manoeuvre", show.choice("signals_table", "manoeuvre", medium["manoeuvres"]["now"]))
        line("position", show.show_position(fast["rotor"]))
        line("frame", show.show_position(fast["demand"]["frame"]))
        for axis in "dq":
            line(
                f"axis {axis}",
                f"i {n(fast['control']['current'][axis])} A, reference {n(fast['demand']['current'][axis])} A; "
                f"u {n(fast['control']['voltage'][axis])} V, commanded {n(fast['current_control']['voltage_ref'][axis])} V",
            )
        phases = measured["current_abc"]
        line("phases", ", ".join(f"i_{phase} {n(phases[phase])} A" for phase in "abc"))
        duty = fast["command"]["duty"]
        line("duty", ", ".join(f"{phase} {float(duty[phase]):.4f}" for phase in "abc"))
        line("DC link", f"{n(measured['u_dc'])} V")
        line("heat", f"sink {n(measured['sink_temperature'])} degC, motor {n(measured['motor_temperature'])} degC")
        line(
            "sample",
            f"encoder {int(measured['encoder_count'])}, flags {show.bit_names(measured['flags'], show.SAMPLE_FLAGS)}",
        )


# Blocks of the register file by the names that the chip's reports use: (name, path in f28335_t, address in words).
def register_blocks():
    blocks = {}
    whole = gdb.lookup_type("f28335_t")

    def add(name, *path):
        value = functools.reduce(lambda v, key: v[key], path, ring()["chip"]["registers"])
        words = (int(value.address) - int(ring()["chip"]["registers"].address)) // 2
        blocks.setdefault(name, []).append((value, words))

    for field in whole.strip_typedefs().fields():
        if field.name.startswith("reserved") or field.name == "pie_vectors":
            continue
        title = {"adc_mirror": "MIRROR", "cpu_timer": "CPUTIMER", "gpio_control": "GPIO", "gpio_data": "GPIO"}.get(
            field.name, field.name.upper()
        )
        if field.type.strip_typedefs().code != gdb.TYPE_CODE_ARRAY:
            add(title, field.name)
            continue
        for n in range(field.type.range()[1] + 1):
            number = {"CPUTIMER": str(n), "GPIO": "ABC"[n % 3]}.get(title, str(n + 1))
            add(title + number, field.name, n)
    return blocks


def registers_of(block, parts):
    """[(name, value, address, octets)] of a block: each element of an array separately, without reserved words."""
    result = []
    for struct, base in parts:
        for field in struct.type.strip_typedefs().fields():
            if field.name.startswith("reserved"):
                continue
            value = struct[field.name]
            address = base + field.bitpos // 16
            kind = field.type.strip_typedefs()
            if kind.code != gdb.TYPE_CODE_ARRAY:
                result.append((field.name, int(value), address, kind.sizeof))
                continue
            words = kind.target().sizeof // 2
            for n in range(kind.range()[1] + 1):
                element = value[n]
                if kind.target().strip_typedefs().code == gdb.TYPE_CODE_STRUCT:  # PIE groups
                    for k, inner in enumerate(element.type.strip_typedefs().fields()):
                        name = f"{block}{n + 1}.{inner.name}"
                        result.append((name, int(element[inner.name]), address + n * words + k, 2))
                else:
                    result.append((f"{field.name}[{n}]", int(element), address + n * words, words * 2))
    return result


def register_name(address):
    for block, parts in register_blocks().items():
        for name, _, place, _ in registers_of(block, parts):
            if place == address:
                return f"{block}.{name}"
    return f"address {address:#06x}"


def fields_of(block, name):
    if "." in name:  # PIE1.IER, shown within PIE
        return registers.fields_of(*name.split("."))
    return registers.fields_of(block, name)


def note_on(block, name, value, all_values):
    """The meaning of a register that is one number."""
    family = block.rstrip("0123456789")
    if family == "EPWM" and name in ("DBRED", "DBFED"):
        half, power = all_values["TBCTL"] >> 7 & 7, all_values["TBCTL"] >> 10 & 7
        clock = ring()["chip"]["clock"]
        sysclk = 150e6 * int(clock["cycles"]) / int(clock["ticks"])
        return f"{value * (2 * half or 1) * 2**power / sysclk * 1e6:.3f} us at SYSCLK = {sysclk / 1e6:g} MHz"
    if family == "EPWM" and name == "CMPA" and all_values.get("TBPRD"):
        return f"{100 * value / all_values['TBPRD']:.2f} % of TBPRD"
    if block == "MIRROR":
        return f"{(value & 0xFFF) * 3 / 4096:.4f} V"
    if block == "ADC" and name.startswith("ADCRESULT"):
        return f"{(value >> 4) * 3 / 4096:.4f} V"
    return ""


class Regs(Command):
    """Show registers of the virtual F28335 by name, bit fields decoded.
Usage: regs | regs BLOCK | regs BLOCK.REGISTER

Without argument: the blocks. Names are those of hal/f28335/registers.h: regs EPWM1, regs ADC, regs EPWM1.TBCTL. The output is the value
that the interrupt would read at this moment."""

    name = "regs"

    @one_line_errors
    def invoke(self, argument):
        blocks = register_blocks()
        if not argument:
            gdb.write("blocks: " + " ".join(sorted(blocks)) + "\n")
            return
        block, _, wanted = argument.upper().partition(".")
        if block[:3] == "PIE" and block[3:].isdigit() and 1 <= int(block[3:]) <= 12:
            block, wanted = "PIE", f"{block}.{wanted}" if wanted else block + "."
        if block not in blocks:
            raise gdb.GdbError(f"no block '{argument}': {' '.join(sorted(blocks))}")
        rows = registers_of(block, blocks[block])
        values = {name: value for name, value, _, _ in rows}
        if wanted.endswith("."):
            rows = [row for row in rows if row[0].startswith(wanted)]
        elif wanted:
            rows = [row for row in rows if row[0] == wanted]
            if not rows:
                raise gdb.GdbError(f"{block} has no register '{wanted}': {' '.join(values)}")
            self.show_one(block, rows[0], values)
            return
        gdb.write(f"{wanted.rstrip('.') or block} at {rows[0][2]:#06x}\n")
        for name, value, _, octets in rows:
            text = registers.summary(fields_of(block, name), value) or note_on(block, name, value, values)
            gdb.write(f"  {name:<15}{value:#0{2 + 2 * octets}x}  {text}".rstrip() + "\n")

    @staticmethod
    def show_one(block, row, values):
        name, value, address, octets = row
        full = name if "." in name else f"{block}.{name}"
        note = note_on(block, name, value, values)
        gdb.write(f"{full} at {address:#06x} = {value:#0{2 + 2 * octets}x} = {value}{'  ' + note if note else ''}\n")
        decoded, rest = registers.decode(fields_of(block, name), value)
        for (field, low, width, _), number, meaning in decoded:
            place = f"{low + width - 1}:{low}" if width > 1 else f"{low}"
            gdb.write(f"  {field:<14}{place:>6}{number:>6}  {meaning}".rstrip() + "\n")
        if rest and decoded:
            gdb.write(f"  other bits {rest:#06x}\n")

    def complete(self, text, word):
        try:
            blocks = register_blocks()
            block, dot, _ = text.upper().partition(".")
            if not dot:
                return [name for name in sorted(blocks) if name.startswith(block)]
            return [name for name, _, _, _ in registers_of(block, blocks[block]) if name.startswith(word.upper())]
        except (gdb.error, gdb.GdbError, KeyError):
            return []


class WhereTime(Command):
    """Print the simulated time: period, seconds, 150 MHz ticks of the chip.
Usage: where-time

While gdb holds the program, simulated time stops."""

    name = "where-time"

    @one_line_errors
    def invoke(self, argument):
        self.no_argument(argument)
        state = ring()
        gdb.write(f"{place_text()}; chip tick {int(state['chip']['tick'])} of 150 MHz\n")


class RigHash(Command):
    """Print a hash of the whole state of the simulation (chip, plant, drive, generators). Equal states of one program have equal hashes.
Usage: rig-hash

The hash is that of rig_hash(), FNV-1a over the octets without the PIE vectors. gdb computes it from the memory of the program, because a
function call in the program would write all registers of the processor, which some versions of gdb cannot do on some processors."""

    name = "rig-hash"

    @one_line_errors
    def invoke(self, argument):
        self.no_argument(argument)
        state = ring()
        octets = bytes(gdb.selected_inferior().read_memory(int(state.address), state.type.sizeof))
        vectors = state["chip"]["registers"]["pie_vectors"]
        begin = int(vectors.address) - int(state.address)
        value = 14695981039346656037
        for octet in octets[:begin] + octets[begin + vectors.type.sizeof:]:
            value = (value ^ octet) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
        gdb.write(f"{value:016x}\n")


gdb.execute(f"directory {ROOT}", to_string=True)
class RigFunction(gdb.Function):
    """The rig whose interrupt runs, for expressions.
Usage: $rig()

For example: print $rig()->state.chip.tick"""

    def __init__(self):
        super().__init__("rig")

    def invoke(self):
        return current_rig()


travelling = False
entry = Entry()
gate, fault, begun, freed = Gate(), Fault(), Begun(), Freed()
gdb.events.stop.connect(on_stop)
gdb.events.exited.connect(forget_rig)
front_end = FrontEnd()
for command in (Period, At, UntilFault, UntilManoeuvre, Why, Drive, Regs, WhereTime, RigHash):
    command()
RigFunction()
