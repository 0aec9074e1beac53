"""How gdb shows the drive's values: frames, angles, samples, commands, and states by name."""
import math
import struct

import gdb


def number(value):
    return f"{float(value):.5g}"


def degrees(radians):
    return f"{math.degrees(float(radians)):.2f} deg"


def angle(radians):
    return f"{degrees(radians)} ({float(radians):.5f} rad)"


def rpm(omega):
    return f"{float(omega) * 30 / math.pi:.2f} r/min"


def text_at(pointer):
    return pointer.string()


def global_value(name):
    """Returns a global variable of the program, also if a local variable hides it."""
    symbol = gdb.lookup_global_symbol(name)
    if symbol is None:
        raise gdb.GdbError(f"this program has no '{name}': take a lagless that was built with debug information")
    return symbol.value()


def table_rows(table):
    """Rows of one of the program's tables (contract/table.h)."""
    value = global_value(table)
    return [value["rows"][n] for n in range(int(value["count"]))]


known_choices = {}  # stored here, because gdb cannot read the texts of a program that has ended


def choices(table, row_name):
    """Names of the values of an enumerated row, from 0 on; [] if there is no such row."""
    key = table, row_name
    if key not in known_choices or gdb.selected_inferior().pid != 0:
        try:
            known_choices[key] = next((text_at(row["choices"]).split("|") for row in table_rows(table) if text_at(row["name"]) == row_name), [])
        except gdb.MemoryError:
            if key not in known_choices:
                raise gdb.GdbError("the program has ended, and its tables cannot be read: 'period 0' starts it again") from None
    return known_choices[key]


def choice(table, row_name, value):
    """Name of a value of an enumerated row: choice("signals_table", "state", 3) is "operation_enabled"."""
    names = choices(table, row_name)
    return names[int(value)] if 0 <= int(value) < len(names) else f"{int(value)} (no such value)"


def reason_row(value):
    """(name, text, remedy) of a reason number."""
    try:
        reasons = global_value("reasons")
        count = int(global_value("reasons_count"))  # The declaration in the header has no length.
    except (gdb.error, gdb.GdbError):  # the linker removes tables that a program does not use
        return f"reason {int(value)}", "this program does not contain the table of reasons", "see settings/reasons.h"
    for n in range(count):
        if int(reasons[n]["number"]) == int(value):
            return tuple(text_at(reasons[n][field]) for field in ("name", "text", "remedy"))
    return f"{int(value)}", "the table of reasons has no such number", "-"


def reason_name(value):
    return reason_row(value)[0]


def elements(array):
    """The elements of a C array, as a list."""
    return [array[n] for n in range(array.type.range()[1] + 1)]


def rows_by_id(table, ids):
    """Rows of one of the program's tables with these ids, in the order of the ids."""
    rows = {int(row["id"]): row for row in table_rows(table)}
    return [rows[int(number)] for number in ids]


def unit_of(row):
    unit = text_at(row["unit"])
    return "" if unit == "-" else unit


def slot_text(row, slot):
    """The value of a 32-bit slot, by the kind of its row."""
    kind, bits = str(row["kind"]), int(slot)
    if kind == "SLOT_FLOAT":
        return number(struct.unpack("=f", struct.pack("=I", bits))[0])
    if kind == "SLOT_ENUM":
        return text_at(row["choices"]).split("|")[bits]
    return str(bits - 2**32 if kind == "SLOT_INT" and bits >= 2**31 else bits)


def fault_rows_of(fault_set):
    """Rows of the fault table (settings/faults.h) that are in a fault_set_t."""
    words = [int(word) for word in elements(fault_set["word"])]
    return [row for n, row in enumerate(elements(global_value("fault_rows"))) if words[n // 32] >> n % 32 & 1]


def fault_names(fault_set, separator="|"):
    return separator.join(text_at(row["name"]) for row in fault_rows_of(fault_set)) or "none"


def bit_names(value, names):
    found = [name for n, name in enumerate(names) if int(value) >> n & 1]
    return "|".join(found) if found else "none"


def gates_name(value):
    return ("keep", "on", "off")[int(value)] if 0 <= int(value) <= 2 else f"{int(value)} (no such value)"


SAMPLE_FLAGS = ("tripped", "fault_line", "encoder", "late")


class Line:
    """Shows a struct as one line."""

    def __init__(self, value, text):
        self.value = value
        self.text = text

    def to_string(self):
        return self.text(self.value)


class Fields:
    """Shows a struct as gdb does, some fields by name: {field: function of its value}."""

    def __init__(self, value, named):
        self.value = value
        self.named = named

    def to_string(self):
        return None

    def children(self):
        for field in self.value.type.strip_typedefs().fields():
            value = self.value[field.name]
            show = self.named.get(field.name)
            yield field.name, show(value) if show else value


def named(*names):
    return lambda v: "(" + ", ".join(f"{n} {number(v[n])}" for n in names) + ")"


def show_rotation(v):
    return f"{degrees(math.atan2(float(v['sin']), float(v['cos'])))} (sin {number(v['sin'])}, cos {number(v['cos'])})"


def show_position(v):
    hertz = float(v["omega_e"]) / (2 * math.pi)
    return f"theta_e {angle(v['theta_e'])}, omega_e {number(v['omega_e'])} rad/s ({hertz:.3f} Hz)"


def show_samples(v):
    return (
        f"i_a {number(v['i_a'])} A, i_b {number(v['i_b'])} A, u_dc {number(v['u_dc'])} V, "
        f"sink {number(v['sink_temperature'])} degC, motor {number(v['motor_temperature'])} degC, "
        f"encoder {int(v['encoder'])}, flags {bit_names(v['flags'], SAMPLE_FLAGS)}"
    )


CAPTURE_STATES = ("idle", "armed", "triggered", "held")


def captured(capture):
    """Periods that a capture_t has kept."""
    tuning = capture["tuning"]
    return int(tuning["periods"]) if int(capture["full"]) else int(capture["next"]) // int(tuning["width"])


def show_capture(v):
    state = CAPTURE_STATES[int(v["state"])]
    return f"{state}, {captured(v)} periods of {int(v['tuning']['columns'])} rows, up to period {int(v['newest'])}"


def show_command(v):
    return f"duty {named('a', 'b', 'c')(v['duty'])}, gates {gates_name(v['gates'])}"


LINES = {
    "abc_t": named("a", "b", "c"),
    "ab_t": named("alpha", "beta"),
    "dq_t": named("d", "q"),
    "rotation_t": show_rotation,
    "position_t": show_position,
    "frame_t": show_position,
    "drive_samples_t": show_samples,
    "drive_command_t": show_command,
    "capture_t": show_capture,
}
FIELDS = {
    "drive_t": {
        "state": lambda v: choice("signals_table", "state", v),
        "manoeuvre": lambda v: choice("signals_table", "manoeuvre", v),
        "fault_reason": reason_name,
        "opens": reason_name,
    },
    "manoeuvres_t": {
        "now": lambda v: choice("signals_table", "manoeuvre", v),
    },
    "sequence_t": {
        "state": lambda v: choice("signals_table", "state", v),
        "refusal": reason_name,
        "fault_reason": reason_name,
        "stop_reason": reason_name,
        "fault_present": reason_name,
        "faults_later": fault_names,
    },
    "guard_t": {name: fault_names for name in ("holding", "failed", "faults", "stops", "losses", "warnings")},
    "drive_fault_t": {"reason": reason_name, "manoeuvre": lambda v: choice("signals_table", "manoeuvre", v)},
    "measured_t": {"flags": lambda v: bit_names(v, SAMPLE_FLAGS)},
    "requests_t": {
        name: lambda v, name=name: choice("requests_table", name, v) for name in ("enable", "fault_reset", "mode")
    },
}


def find_printer(value):
    name = value.type.unqualified().name
    if name in LINES:
        return Line(value, LINES[name])
    if name in FIELDS:
        return Fields(value, FIELDS[name])
    return None


gdb.pretty_printers.append(find_printer)
