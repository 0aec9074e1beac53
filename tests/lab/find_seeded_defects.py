"""A campaign finds a drive that does not work, does not obey or does not protect.

usage: find_seeded_defects.py BUILD SOURCE [DEFECT...]      BUILD: folder of a Ninja build with the program `lagless` in it

Each defect is one file of the firmware, compiled anew with an error and linked before the others. The program with it makes a
campaign of RUNS runs, a tenth at a time until it is found: a run breaks a promise that it keeps without the defect, or more calm
runs end in a fault than chance explains. Takes some minutes of processor, so that it is a test of `tools/check --long`
(campaign_seeded_defects); run it by hand after a change of the campaign or of its judges. Exit status: 0 all are found, 1 one is not, 2 wrong use.
"""
import functools
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile

BUILD, SOURCE = (pathlib.Path(word).resolve() for word in (*sys.argv[1:], ".", ".")[:2])
RUNS, SHARDS, SEED = 250, 10, 33

IN_GUARD = "if (FAULT_##rate == asked && GUARD_IF_"


def without(row):
    return ("guard/guard.c", IN_GUARD, f"if (FAULT_##NAME != FAULT_{row} && FAULT_##rate == asked && GUARD_IF_")


# name: file, what is written there, what instead. A text that is not there stops the script; test_judge_campaign.py looks for all.
SEQUENCE = "medium/sequence.c"
DEFECTS = {
    "never_on": (SEQUENCE, "    if (input->requests->enable != (int32_t)REQUEST_ON) {\n        return OFF;",
                 "    if (input->requests->enable <= (int32_t)REQUEST_QUICK_STOP) {\n        return OFF;"),
    "false_trip": (SEQUENCE, "    if (sequence->retried != 0u) {\n        sequence->retry_windows++;",
                   "    sequence->retry_windows++;\n    if (sequence->retry_windows == DRIVE_WINDOWS(0.3f)) {\n"
                   "        sequence_fault(sequence, REASON_STALLED);\n        return OFF;\n    }\n    if (sequence->retried != 0u) {"),
    "off_ignored": (SEQUENCE, "    if (input->requests->enable == (int32_t)REQUEST_OFF) {\n        enter(sequence, DRIVE_READY);",
                    "    if (input->requests->enable < (int32_t)REQUEST_OFF) {\n        enter(sequence, DRIVE_READY);"),
    "endless_stop": (SEQUENCE, "input->standing", "(input->standing && sequence->state == (int32_t)DRIVE_FAULT)"),
    "no_overspeed": without("OVERSPEED"),
    "no_dc_overvoltage": without("DC_OVERVOLTAGE"),
    "no_motor_hot": without("MOTOR_HOT"),
    "no_phase_loss": without("PHASE_LOSS"),
}


def missing(source):
    """Defects whose text is not in its file, so that they could not be planted."""
    return [name for name, (path, old, _) in DEFECTS.items() if old not in (source / "firmware" / path).read_text(encoding="utf-8")]


def commands(target):
    listed = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", target], capture_output=True, text=True, check=True)
    return [line for line in listed.stdout.splitlines() if line.strip()]


def without_launcher(words):
    """A compiler's command line, from the compiler on."""
    return words[next((n + 1 for n, word in enumerate(words) if pathlib.PurePath(word).name == "ccache"), 0):]


def build(defect, folder):
    path, old, new = DEFECTS[defect]
    text = (SOURCE / "firmware" / path).read_text()
    if old not in text:
        sys.exit(f"{path}: the text that {defect} replaces is not there; bring the list of this script up to date")
    source = folder / pathlib.PurePath(path).name
    source.write_text(text.replace(old, new))
    words = without_launcher(shlex.split(commands(f"firmware/CMakeFiles/lagless_firmware.dir/{path}.o")[-1]))
    words[words.index("-o") + 1] = str(folder / "defect.o")
    words[words.index("-c") + 1] = str(source)
    words.remove("-MD")
    for flag in ("-MT", "-MF"):
        del words[words.index(flag):words.index(flag) + 2]
    subprocess.run([*words, "-fno-lto"], cwd=BUILD, check=True)
    words = shlex.split(commands("lagless")[-1].split("&&")[1])
    words[words.index("-o") + 1] = str(folder / "lagless")
    words.insert(next(n for n, word in enumerate(words) if word.endswith(".o")), str(folder / "defect.o"))
    subprocess.run([*words, "-fno-lto"], cwd=BUILD, check=True)  # in a second instead of a minute; the bits are the same
    return folder / "lagless"


def campaign(program, shard):
    """A tenth of the runs: those from the shard-th on, each tenth."""
    done = subprocess.run([program, "campaign", "--runs", str(RUNS), "--seed", str(SEED), "--shard", f"{shard}/{SHARDS}",
                           "--as-drawn", "--json"], capture_output=True, text=True)
    return done.returncode, json.loads(done.stdout)


@functools.lru_cache(maxsize=None)
def sound(shard):
    """What the program without a defect violates says nothing of a defect."""
    _, summary = campaign(BUILD / "lagless", shard)
    return {(each["run"], each["invariant"]) for each in summary["violations"]}, summary["alarmed"]


def find(defect):
    """What found it, after how many runs; None: nothing did."""
    with tempfile.TemporaryDirectory() as folder:
        program = build(defect, pathlib.Path(folder))
        for shard in range(1, SHARDS + 1):
            known, alarmed = sound(shard)
            code, summary = campaign(program, shard)
            new = [each for each in summary["violations"] if (each["run"], each["invariant"]) not in known]
            runs = shard * RUNS // SHARDS
            if code == 1 and new:
                return f"run {new[0]['run']}, by {new[0]['invariant']}, among the first {runs} that were made"
            if code == 1 and summary["alarmed"] and not alarmed:
                return f"{summary['alarms']} of {summary['calm']} calm runs end in a fault, after {runs} runs"
    return None


def main():
    missed = 0
    for defect in sys.argv[3:] or DEFECTS:
        found = find(defect)
        missed += found is None
        print(f"{defect:18} {found or f'NOT FOUND in {RUNS} runs'}", flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    if len(sys.argv) < 3 or not set(sys.argv[3:]) <= set(DEFECTS):
        print(f"{__doc__}\nDEFECT: {', '.join(DEFECTS)}", file=sys.stderr)
        sys.exit(2)
    sys.exit(main())
