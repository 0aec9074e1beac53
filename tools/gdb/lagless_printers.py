"""How gdb shows the drive's values: frames, angles, samples, commands, and states by name."""
import math

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
    """A global variable of the program, whatever locals hide it."""
    symbol = gdb.lookup_global_symbol(name)
    if symbol is None:
        raise gdb.GdbError(f"this program has no '{name}': is it lagless, built with debug information?")
    return symbol.value()


def table_rows(table):
    """Rows of one of the program's tables (contract/table.h)."""
    value = global_value(table)
    return [value["rows"][n] for n in range(int(value["count"]))]


def choice(table, row_name, value):
    """Name of a value of an enumerated row: choice("signals_table", "state", 3) is "operation_enabled"."""
    for row in table_rows(table):
        if text_at(row["name"]) == row_name:
            names = text_at(row["choices"]).split("|")
            if 0 <= int(value) < len(names):
                return names[int(value)]
    return f"{int(value)} (no such value)"


def reason_row(value):
    """(name, text, remedy) of a reason number."""
    try:
        reasons = global_value("reasons")
        count = int(global_value("reasons_count"))  # the array may be seen through its header, without a length
    except (gdb.error, gdb.GdbError):  # the linker leaves out what a program does not use
        return f"reason {int(value)}", "this program does not carry the table of reasons", "see drive/reasons.h"
    for n in range(count):
        if int(reasons[n]["number"]) == int(value):
            return tuple(text_at(reasons[n][field]) for field in ("name", "text", "remedy"))
    return f"{int(value)}", "the table of reasons has no such number", "-"


def reason_name(value):
    return reason_row(value)[0]


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


def show_command(v):
    return f"duty {named('a', 'b', 'c')(v['duty'])}, gates {gates_name(v['gates'])}"


LINES = {
    "abc_t": named("a", "b", "c"),
    "ab_t": named("alpha", "beta"),
    "dq_t": named("d", "q"),
    "rotation_t": show_rotation,
    "position_t": show_position,
    "drive_samples_t": show_samples,
    "drive_command_t": show_command,
}
FIELDS = {
    "drive_t": {
        "state": lambda v: choice("signals_table", "state", v),
        "refusal": reason_name,
        "sample_flags": lambda v: bit_names(v, SAMPLE_FLAGS),
    },
    "drive_fault_t": {"reason": reason_name},
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
