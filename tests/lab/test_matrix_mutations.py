"""A defect in a protection makes cells of the fault matrix fail.

usage: test_matrix_mutations.py BUILD SOURCE few|all      BUILD: folder of a Ninja build that contains matrix_cells

Each mutation changes one file of the firmware, which is compiled again and linked before the others. A mutation doubles a limit of the
fault table, exchanges the quantities of two neighbouring rows so that each sets the bit of the other, or doubles a limit of a watch. The
cells that then run are those that expect the fault of the changed row, or the cells that the list names. Only cells that pass without
the mutation count. `few` runs representatives for the daily check; `all` finds the cells by a run of the whole matrix.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/mutation"))
import planted  # noqa: E402

BUILD, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
GUARD, LIMITS, TRIPS, FAST = "guard/guard.c", "settings/guard_tuning.c", "fast/fast_trips.c", "fast/fast.c"
HEADER = "settings/faults.h"
MOST = 8  # cells that run for a mutation of the table

# A row of the table: number, NAME, "name", quantity, comparison, "limit", margin, rate, debounce, when, reaction.
ROW = re.compile(r'F\((\d+), (\w+), "(\w+)", (\w+), (\w+), "(\w*)", ([^,]+), (\w+), ((?:[^,()]|\([^()]*\))+), (\w+), (\w+),')


def flat(text):
    """The text of the header with continued lines joined, so that each row is one line."""
    return re.sub(r"\s*\\\n\s*", " ", text)


def rows():
    text = flat((SOURCE / "firmware" / HEADER).read_text())
    body = text[text.index("#define DRIVE_FAULTS(F)"):]
    return [match.groups() for match in ROW.finditer(body)]


class Mutant:
    """Files of the firmware, by their paths, that replace the originals in the build."""

    def __init__(self, name, compiled, files):
        self.name, self.compiled, self.files = name, compiled, files

    def build(self, folder):
        for path, text in self.files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text)
        objects = [folder / f"mutant_{n}.o" for n in range(len(self.compiled))]
        for compiled, output in zip(self.compiled, objects):  # the mutated files come before those of the tree
            source = (folder if compiled in self.files else SOURCE / "firmware") / compiled
            planted.compile_firmware(BUILD, compiled, source, output, folder)
        return planted.link(BUILD, "tests/lab/matrix_cells", objects, folder / "cells")


def run(program, cells):
    """Runs the cells; returns {cell: (red, reason)}."""
    done = subprocess.run([program, *cells], capture_output=True, text=True, check=True)
    return {line.split()[0]: (int(line.split()[1]), line.split()[2]) for line in done.stdout.splitlines()}


def replaced(path, old, new):
    text = (SOURCE / "firmware" / path).read_text()
    assert len(re.findall(old, text)) == 1, f"{path}: {old} is not there once"
    return re.sub(old, new, text)


def twice_the_limit(row):
    text = replaced(LIMITS, r"return (row->margin \+ \(limit != NULL [^;]*);",
                    rf"return (row == &fault_rows[FAULT_{row[1]}] ? 2.0f : 1.0f) * (\1);")
    return Mutant(f"{row[2]}: its limit twice as large", (LIMITS,), {LIMITS: text})


def exchanged(a, b):
    """Exchanges the comparisons of two rows."""
    text = flat((SOURCE / "firmware" / HEADER).read_text())
    def head(row, other):
        return (f'F({row[0]}, {row[1]}, "{row[2]}", ' + f'{other[3]}, {other[4]}, "{other[5]}", ' + ", ".join(other[6:10]) +
                f", {row[10]},")
    own = [head(row, row) for row in (a, b)]
    assert all(text.count(each) == 1 for each in own), own
    text = text.replace(own[0], head(a, b)).replace(own[1], head(b, a))
    return Mutant(f"{a[2]} and {b[2]}: bits exchanged", (GUARD, LIMITS, TRIPS, FAST), {HEADER: text})


# Limits that the fault table does not contain: row, file, text in the file, replacement. A stuck sensor is found by several laws in each
# cell, so that no cell shows the limit of one: the unit test of the watch tests each law alone.
WATCHES = [
    ("stalled", "settings/params.c", "settings/params.h", r'(stall_time, "s", )2\.0f', r"\g<1>4.0f"),
    ("encoder_mismatch", "medium/protect/encoder_watch.c", "medium/protect/encoder_watch.h", r"(define ENCODER_WATCH_TIME\s+)(\S+)", r"\g<1>(2.0f * \g<2>)"),
    ("phase_loss", "medium/protect/current_watch.c", "medium/protect/current_watch.c", r"(define LOSS_TIME\s+)(\S+)", r"\g<1>(2.0f * \g<2>)"),
]


def watch(row, compiled, path, old, new):
    return Mutant(f"{row}: its watch's limit twice as large", (compiled,), {path: replaced(path, old, new)})


# For rows whose reaction is that a lost rotor is caught, without a latched reason: the cells.
CAUGHT = {"unlocked": ["estimate_jump/run_slow/sensorless", "estimate_jump/run_fast/sensorless", "estimate_jump/braking/sensorless"]}

# The reason of these rows can also come from other code than the table, so that cells with this reason do not test the row.
PAST_THE_TABLE = {"rotor_too_fast": "no cell has a rotor that fast: where a sensor is off by 2 A, the sequence refuses by current_offset"}

# The mutations of the daily check: mutation, cells that must fail with it.
FEW = [
    (lambda by: twice_the_limit(by["dc_overvoltage"]), ["dc_high/run_fast"]),
    (lambda by: twice_the_limit(by["sink_hot"]), ["sink_hot/align"]),
    (lambda by: twice_the_limit(by["dc_undervoltage"]), ["none/off"]),
    (lambda by: exchanged(by["bad_sample"], by["dc_overvoltage"]), ["stuck_a_rail/run_fast", "dc_high/run_slow"]),
    (lambda by: exchanged(by["late"], by["dc_undervoltage"]), ["late/run_slow", "dc_low/run_slow"]),
]


def is_compiled(a, b):
    """False if guard.c does not compile with these rows exchanged: a row of the rate EACH has the reaction OPEN."""
    return all(rate != "EACH" or reaction == "OPEN" for rate, reaction in ((a[7], b[10]), (b[7], a[10])))


def everything(table, whole):
    """A list of (mutation, cells): one for each row that is the reason in a cell, and one for each pair of such neighbours that can be
    exchanged."""
    told = {row[2]: [cell for cell, (red, reason) in whole.items() if red == 0 and reason == row[2]] for row in table}
    cells = {name: some[:MOST] for name, some in told.items()} | CAUGHT
    for name, why in PAST_THE_TABLE.items():
        cells[name] = []
        print(f"{name}: {why}")
    healthy = [cell for cell in whole if cell.startswith("none/run") or cell.startswith("none/off")]
    for row in table:
        if row[4] != "HOLDS" and cells[row[2]]:
            yield twice_the_limit(row), cells[row[2]] + (healthy if row[4] == "BELOW" else [])
    for a, b in zip(table, table[1:]):
        if not is_compiled(a, b):
            print(f"{a[2]} and {b[2]}: not exchanged, because the firmware does not compile with them")
        elif cells[a[2]] or cells[b[2]]:
            yield exchanged(a, b), cells[a[2]] + cells[b[2]] + healthy
    by = {row[2]: row for row in table}
    for one in WATCHES:
        if one[0] in by and told[one[0]]:
            yield watch(*one), told[one[0]]
    unseen = [row[2] for row in table if not cells[row[2]]]
    print("rows that are the reason of no green cell:", " ".join(unseen) or "none")


def main():
    table = rows()
    assert len(table) >= 20 and table[0][2] == "module_fault", "the fault table reads otherwise"
    plain = BUILD / "tests" / "lab" / "matrix_cells"
    if sys.argv[3] == "few":
        by = {row[2]: row for row in table}
        todo = [(make(by), cells) for make, cells in FEW]
    else:
        todo = everything(table, run(plain, []))
    survived = 0
    for mutant, cells in todo:
        folder = pathlib.Path(tempfile.mkdtemp(prefix="lagless_mutant_"))
        try:
            before = run(plain, cells)
            after = run(mutant.build(folder), cells)
        finally:
            shutil.rmtree(folder)
        green = [cell for cell, (red, _) in before.items() if red == 0]
        gone = [cell for cell in green if after[cell][0] != 0]
        survived += not gone
        print(f"{'red' if gone else 'SURVIVED'}: {mutant.name}: {len(gone)} of {len(green)} green cells turn red", flush=True)
    print(f"{survived} survived")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
