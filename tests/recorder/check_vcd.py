#!/usr/bin/env python3
"""Checks that another program measures the times of the compare registers in a VCD file of lagless.

usage: check_vcd.py FOLDER

`sigrok-cli -P pwm` measures duty and period of every wire of FOLDER/duty.vcd. The expected values follow from the registers in
duty.json: for centre-aligned pulses the upper switch of a leg is commanded on for 2 CMPA less the dead band, its lower switch for the
rest of the period less the dead band [1/150 MHz]. Python 3.9. Ends with 77 (skipped) where sigrok-cli or its pwm decoder is missing."""
import json
import pathlib
import re
import shutil
import subprocess
import sys

SKIPPED = 77
TICK = 20 / 3  # [ns]


def skip(text):
    print(f"SKIPPED: {text}")
    sys.exit(SKIPPED)


def sigrok(*arguments):
    return subprocess.run(["sigrok-cli", *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


def channels(vcd):
    """For each wire the name that sigrok gives it, with or without its scope."""
    names = re.findall(r"^- (\S+): logic$", sigrok("-i", str(vcd), "-I", "vcd", "--show").stdout, re.MULTILINE)
    return {name.split(".")[-1]: name for name in names}


def measure(vcd, wire):
    """(start [ns], period [ns], high [ns]) of each whole cycle that the decoder reports."""
    run = sigrok("-i", str(vcd), "-I", "vcd", "-P", f"pwm:data={wire}", "-A", "pwm=duty-cycle",
                 "--protocol-decoder-samplenum")
    cycles = []
    for line in run.stdout.splitlines():
        found = re.fullmatch(r"(\d+)-(\d+) pwm-1: ([\d.]+)%", line.strip())
        if found:
            start, end, percent = int(found[1]), int(found[2]), float(found[3])
            cycles.append((start, end - start, (end - start) * percent / 100))
    if not cycles:
        sys.exit(f"FAILED: {wire}: no cycle in the output of sigrok-cli: {run.stdout[:500]}")
    return cycles


def main():
    folder = pathlib.Path(sys.argv[1])
    if shutil.which("sigrok-cli") is None:
        skip("sigrok-cli is not installed")
    if "Pulse-width modulation" not in sigrok("--show", "-P", "pwm").stdout:
        skip("sigrok-cli has no pwm decoder")
    registers = json.loads((folder / "duty.json").read_text())
    period, dead = registers["period"], registers["dead_band"]
    if len(set(registers["compare"])) != 3 or period != 15000:
        sys.exit(f"FAILED: {registers} is not the set-up that this test is about")

    expected = {"isr": registers["isr_ticks"]}
    for leg, compare in zip("abc", registers["compare"]):
        expected[f"upper_{leg}"] = 2 * compare - dead
        expected[f"lower_{leg}"] = period - 2 * compare - dead
    names = channels(folder / "duty.vcd")
    if sorted(names) != sorted([*expected, "adc_start", "trip"]):
        sys.exit(f"FAILED: sigrok-cli finds the wires {sorted(names)}")
    worst = 0.0
    for wire, ticks in expected.items():
        # The trip interrupts the last cycles.
        cycles = measure(folder / "duty.vcd", names[wire])[:-2]
        if len(cycles) < registers["periods"] - 4:
            sys.exit(f"FAILED: {wire}: {len(cycles)} cycles of {registers['periods']}")
        for start, length, high in cycles:
            error = max(abs(high / TICK - ticks), abs(length / TICK - period))
            if error > 1.0:
                sys.exit(f"FAILED: {wire} at {start} ns: high {high / TICK:.3f} of {length / TICK:.3f} ticks, "
                         f"expected {ticks} of {period}")
            worst = max(worst, error)
    print(json.dumps({"wires": len(expected), "worst_error_ticks": round(worst, 4), "compare": registers["compare"]}))


main()
