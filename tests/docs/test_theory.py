#!/usr/bin/env python3
"""Compares docs/theory.md with computation: its tables of numbers with formulas and brute-force simulation in double precision, and its
constants with the sources. No code of the firmware is used.

usage: test_theory.py [unittest options]        Python 3.9, standard library only
"""
import cmath
import math
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs/theory.md").read_text(encoding="utf-8")

# The paper's machine.
R, L, PSI, POLE_PAIRS, T = 0.95, 12.5e-3, 0.183, 4, 1e-4
INERTIA, LIMIT = 0.0636, 10.0


def omega_of(rpm):
    return POLE_PAIRS * rpm * 2 * math.pi / 60


def rows_below(head):
    """The rows of the table whose heading row begins with these cells."""
    lines = TEXT.splitlines()
    starts = [n for n, line in enumerate(lines) if line.startswith(head)]
    assert len(starts) == 1, f"{head}: {len(starts)} tables"
    rows = []
    for line in lines[starts[0] + 2:]:
        if not line.startswith("|"):
            return rows
        rows.append([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]])
    return rows


def half_digit(cell):
    """Half a unit of the last digit of a printed number."""
    digits = len(cell.partition(".")[2]) if "." in cell else 0
    return 0.5 * 10.0 ** -digits + 1e-9


# ---- The observer -------------------------------------------------------------------------------------------------------


def hold(x, d):
    """The mean of a rotating EMF over a period, weighted by the response of the winding, over its value at the begin."""
    half = complex(0.5 * d, 0.5 * x)
    return cmath.exp(0.5j * x) * cmath.sinh(half) / half * (0.5 * d) / math.sinh(0.5 * d)


def impedance(g, omega, resistance=R, inductance=L, period=T):
    """e/x by section 4 without approximations."""
    x, d = omega * period, resistance * period / inductance
    a = math.exp(-d)
    b = (1 - a) / resistance
    return (cmath.exp(1j * x) - (a - b * g)) / (b * hold(x, d))


def impedance_law(g, omega, resistance=R, inductance=L, period=T):
    """The quotient of the EMF and the signal of the observer, with the approximations of the firmware."""
    h, d = 0.5 * omega * period, resistance * period / inductance
    b = (1 - math.exp(-d)) / resistance
    return complex((g + resistance) * (1 - h * h / 3), (2 / b - resistance - g) * h) * cmath.exp(-1j * h * d / 6)


def lag_form(g, omega):
    x, d = omega * T, R * T / L
    pole = math.exp(-d) - (1 - math.exp(-d)) / R * g
    return math.atan2(math.sin(x), math.cos(x) - pole) - x / 2 - x * d / 12


def sigmoid(y):
    return math.tanh(0.5 * y)


def simulate(rpm, gain=200.0, slope=1.0, vector=True, periods=4000):
    """Simulates the exact winding and the sampled observer; returns v/e and the power-weighted gain g [ohm]."""
    omega = omega_of(rpm)
    a = math.exp(-R * T / L)
    b = (1 - a) / R
    turn = cmath.exp(1j * omega * T)
    emf = 1j * PSI * omega
    weight = -(turn - a) / L / complex(R / L, omega)  # weight of the EMF at the begin of the period, in the current at its end
    i, i_hat, v, samples = 0.3 + 0.2j, 0j, 0j, []
    for _ in range(periods):
        u = 0.9 * emf + 1.5  # any voltage is suitable, because winding and observer receive the same
        i = a * i + b * u + weight * emf
        i_hat = a * i_hat + b * (u - v)
        x = i_hat - i
        v = gain * (sigmoid(slope * abs(x)) * x / abs(x) if vector
                    else complex(sigmoid(slope * x.real), sigmoid(slope * x.imag)))
        emf *= turn
        samples.append((v / emf, (v * x.conjugate()).real, abs(x)**2))
    settled = samples[periods // 2:]
    ratio, product, square = (sum(column) / len(settled) for column in zip(*settled))
    return ratio, product / square


class Observer(unittest.TestCase):
    def test_law_holds_in_the_stated_range(self):
        angle = length = 0.0
        for x in (0.05, 0.1, 0.2, 0.3):
            for d in (0.0076, 0.05, 0.1, 0.3):
                for loop_gain in (0.1, 0.4, 0.8, 1.2):
                    inductance = R * T / d
                    g = loop_gain * R / (1 - math.exp(-d))
                    ratio = (impedance_law(g, x / T, R, inductance) / impedance(g, x / T, R, inductance))
                    angle = max(angle, abs(cmath.phase(ratio)))
                    length = max(length, abs(abs(ratio) - 1))
        said = re.search(r"within\s+([\d.e-]+) rad\s+and\s+([\d.e-]+)\s+of\s+its\s+length", TEXT)
        self.assertLessEqual(angle, float(said.group(1)))
        self.assertLessEqual(length, float(said.group(2)))

    def test_table_of_lags(self):
        rows = rows_below("| r/min | vector")
        self.assertEqual([row[0] for row in rows], ["100", "500", "1000", "1500"])
        for rpm, vector, axis, printed, mended, exact in rows:
            omega = omega_of(float(rpm))
            ratio, g = simulate(float(rpm))
            self.assertAlmostEqual(1e3 * cmath.phase(ratio), float(vector), delta=half_digit(vector))
            ratio_axis, g_axis = simulate(float(rpm), vector=False)
            lag = 1e3 * cmath.phase(ratio_axis)
            self.assertAlmostEqual(lag, float(axis), delta=half_digit(axis))
            left = lag + 1e3 * math.atan(omega * L / (g_axis * R + R))
            self.assertAlmostEqual(left, float(printed), delta=half_digit(printed))
            left = lag + 1e3 * math.atan(omega * L / (g_axis + R))
            self.assertAlmostEqual(left, float(mended), delta=half_digit(mended))
            self.assertAlmostEqual(lag + 1e3 * lag_form(g_axis, omega), float(exact), delta=0.1)
            self.assertAlmostEqual(1e3 * (cmath.phase(ratio) + lag_form(g, omega)), 0.0, delta=1e-5)


# ---- The tracking loop --------------------------------------------------------------------------------------------------


def natural_frequency(bandwidth, cutoff, z=1.0):
    c, low, high = cutoff / bandwidth, 0.0, 1.0
    for _ in range(100):
        u = 0.5 * (low + high)
        value = (1 + c * c) * u**4 + (4 * z * z + 2 + c * c * (4 * z * z - 2)) * u * u + 8 * z * c * u - (1 - c * c)
        low, high = (u, high) if value < 0 else (low, u)
    return low * bandwidth


class Loop(unittest.TestCase):
    def test_table_of_designs(self):
        for bandwidth, cutoff, wn, kp, ki in rows_below("| bandwidth | omega_c"):
            found = natural_frequency(float(bandwidth), float(cutoff))
            self.assertAlmostEqual(found, float(wn), delta=half_digit(wn))
            self.assertAlmostEqual(2 * found, float(kp), delta=half_digit(kp))
            self.assertAlmostEqual(found * found, float(ki), delta=half_digit(ki))
            s = 1j * float(bandwidth)
            top = (2 * found + float(cutoff)) * s * s + (found**2 + 2 * found * float(cutoff)) * s + found**2 * float(cutoff)
            gain = abs(top / ((s + float(cutoff)) * (s * s + 2 * found * s + found**2)))
            self.assertAlmostEqual(gain * gain, 0.5, delta=1e-9)

# ---- Content of the sources -----------------------------------------------------------------------------------------


class HeatAndLink(unittest.TestCase):
    def test_numbers_of_the_paper_s_motor(self):
        torque = 1.5 * POLE_PAIRS * PSI
        omega, current, bandwidth, over, c = 1500 * math.pi / 30, LIMIT, 1000.0, 400.0, 1e-3
        resistance = R + (18e-3 + 25e-3) / 2
        share = 0.7 ** 2
        full, band = 0.98 * over, 0.03 * over
        power = torque * omega * current
        rate = power / (c * full * band)
        free = 0.15 * resistance * current / torque
        values = [-60 * math.log(1 - 0.9 * share), -60 * math.log(1 - 1.1 * share), INERTIA * omega ** 2 / 2,
                  c * (full ** 2 - 311 ** 2) / 2, rate, math.sqrt(bandwidth / rate) / 2, 1e3 * power / (full * band * bandwidth / 2),
                  free, (torque * free) ** 2 / (6 * resistance)]
        rows = rows_below("| of heat and link | value |")
        self.assertEqual(len(values), len(rows))
        for (what, cell), value in zip(rows, values):
            printed = cell.split()[0]
            self.assertLessEqual(abs(float(printed) - value), half_digit(printed), what)


def sources():
    for path in sorted((ROOT / "firmware").rglob("*.[ch]")):
        yield path.read_text(encoding="utf-8")


class Constants(unittest.TestCase):
    def test_constants_have_the_values_of_the_text(self):
        defined = {}
        for text in sources():
            for name, value in re.findall(r"^[ \t]*#[ \t]*define[ \t]+([A-Z]\w+)(?:[ \t]|\\\n)+(\S.*)", text, re.MULTILINE):
                number = re.search(r"(?<![\w.])(\d+\.?\d*(?:e[+-]?\d+)?)[fuUL]*(?![\w.])", value)
                defined.setdefault(name, set()).add(float(number.group(1)) if number else None)
        rows = rows_below("| constant | value")
        self.assertGreater(len(rows), 30)
        for names, value, reason in rows:
            found = re.findall(r"`(\w+)`", names)
            numbers = re.findall(r"(?<![\w.^/])\d+\.?\d*(?:e[+-]?\d+)?", value)[:len(found)]
            self.assertEqual(len(found), len(numbers), names)
            for name, number in zip(found, numbers):
                self.assertEqual(defined.get(name), {float(number)}, name)
            self.assertTrue(reason, names)

    def test_defaults_are_those_of_the_tables(self):
        reference = (ROOT / "docs/reference.md").read_text(encoding="utf-8")
        for name, value, _ in rows_below("| parameter | default"):
            self.assertRegex(reference, rf"\| {re.escape(name.strip('`'))} \| {re.escape(value)} \|", name)

    def test_errata_are_numbered_without_gaps(self):
        self.assertEqual([row[0] for row in rows_below("| erratum | in print")], [str(n) for n in range(1, 14)])

    def test_sections_are_numbered_and_those_that_are_cited_exist(self):
        sections = [int(n) for n in re.findall(r"^## (\d+)\. ", TEXT, re.MULTILINE)]
        self.assertEqual(sections, list(range(1, len(sections) + 1)))
        for number in re.findall(r"sections? (\d+)", TEXT):
            self.assertIn(int(number), sections)


if __name__ == "__main__":
    unittest.main()
