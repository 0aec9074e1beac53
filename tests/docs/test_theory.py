#!/usr/bin/env python3
"""What docs/theory.md says, held against computation: its tables of numbers against the formulas, the formulas against
brute-force simulation in double precision, and its constants against the sources. Independent of the firmware's code.

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
INERTIA, FRICTION, LIMIT = 0.0636, 1.32, 10.0


def omega_of(rpm):
    return POLE_PAIRS * rpm * 2 * math.pi / 60


def rows_below(head):
    """The cells of the table whose head begins with these cells."""
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
    """Mean of a turning EMF as the winding weighs it over a period, over its value at the period's beginning."""
    half = complex(0.5 * d, 0.5 * x)
    return cmath.exp(0.5j * x) * cmath.sinh(half) / half * (0.5 * d) / math.sinh(0.5 * d)


def impedance(g, omega, resistance=R, inductance=L, period=T):
    """e/x by section 4, nothing neglected."""
    x, d = omega * period, resistance * period / inductance
    a = math.exp(-d)
    b = (1 - a) / resistance
    return (cmath.exp(1j * x) - (a - b * g)) / (b * hold(x, d))


def impedance_law(g, omega, resistance=R, inductance=L, period=T):
    """The same as the firmware computes it."""
    h, d = 0.5 * omega * period, resistance * period / inductance
    b = (1 - math.exp(-d)) / resistance
    return complex((g + resistance) * (1 - h * h / 3), (2 / b - resistance - g) * h) * cmath.exp(-1j * h * d / 6)


def lag_form(g, omega, decay=0.0):
    x, d = omega * T, R * T / L
    pole = math.exp(-d) - (1 - math.exp(-d)) / R * g
    lag = math.atan2(math.sin(x), math.cos(x) - pole) - x / 2 - x * d / 12
    return lag + math.atan2(decay * math.sin(x), 1 - decay * math.cos(x))


def sigmoid(y):
    return math.tanh(0.5 * y)


def simulate(rpm, gain=200.0, slope=1.0, vector=True, decay=0.0, periods=4000):
    """Exact winding and sampled observer, side by side: v/e and e/x, the power-weighted gain g [ohm], and e_hat/e."""
    omega = omega_of(rpm)
    a = math.exp(-R * T / L)
    b = (1 - a) / R
    turn = cmath.exp(1j * omega * T)
    emf = 1j * PSI * omega
    weight = -(turn - a) / L / complex(R / L, omega)  # of the EMF at the period's beginning, on the current at its end
    i, i_hat, v, e_hat, samples = 0.3 + 0.2j, 0j, 0j, 0j, []
    for _ in range(periods):
        u = 0.9 * emf + 1.5  # any voltage will do: it acts on both alike
        i = a * i + b * u + weight * emf
        i_hat = a * i_hat + b * (u - v)
        x = i_hat - i
        v = gain * (sigmoid(slope * abs(x)) * x / abs(x) if vector
                    else complex(sigmoid(slope * x.real), sigmoid(slope * x.imag)))
        e_hat = v + decay * (e_hat - v)
        emf *= turn
        samples.append((v / emf, emf / x, (v * x.conjugate()).real, abs(x)**2, e_hat / emf))
    settled = samples[periods // 2:]
    ratio, over_error, product, square, filtered = (sum(column) / len(settled) for column in zip(*settled))
    return ratio, over_error, product / square, filtered


class Observer(unittest.TestCase):
    def test_law_is_what_simulation_gives(self):
        for rpm in (100, 500, 1000, 1500, -1500):
            ratio, over_error, g, _ = simulate(rpm)
            omega = omega_of(rpm)
            self.assertLess(abs(over_error / impedance(g, omega) - 1), 1e-9)
            self.assertLess(abs(over_error / impedance_law(g, omega) - 1), 1e-7)
            self.assertLess(abs(cmath.phase(ratio) + lag_form(g, omega)), 1e-8)

    def test_filter_adds_its_own_lag_less_half_a_period(self):
        decay = math.exp(-2000 * T)
        _, _, g, filtered = simulate(1500, decay=decay)
        self.assertLess(abs(cmath.phase(filtered) + lag_form(g, omega_of(1500), decay)), 1e-8)

    def test_law_holds_where_the_text_says(self):
        angle = length = 0.0
        for x in (0.05, 0.1, 0.2, 0.3):
            for d in (0.0076, 0.05, 0.1, 0.3):
                for loop_gain in (0.1, 0.4, 0.8, 1.2):
                    inductance = R * T / d
                    g = loop_gain * R / (1 - math.exp(-d))
                    ratio = (impedance_law(g, x / T, R, inductance) / impedance(g, x / T, R, inductance))
                    angle = max(angle, abs(cmath.phase(ratio)))
                    length = max(length, abs(abs(ratio) - 1))
        said = re.search(r"within ([\d.e-]+) rad\s+and ([\d.e-]+) of its\s+length", TEXT)
        self.assertLessEqual(angle, float(said.group(1)))
        self.assertLessEqual(length, float(said.group(2)))

    def test_table_of_lags(self):
        rows = rows_below("| r/min | vector")
        self.assertEqual([row[0] for row in rows], ["100", "500", "1000", "1500"])
        for rpm, vector, axis, printed, mended, exact in rows:
            omega = omega_of(float(rpm))
            ratio, _, g, _ = simulate(float(rpm))
            self.assertAlmostEqual(1e3 * cmath.phase(ratio), float(vector), delta=half_digit(vector))
            ratio_axis, _, g_axis, _ = simulate(float(rpm), vector=False)
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


def ramp(bandwidth, cutoff, acceleration, gamma=1.0, share=0.0, periods=20000):
    """Angle error of the sampled loop in the order of section 7: the last and the largest, and ki."""
    wn = natural_frequency(bandwidth, cutoff)
    theta = omega = integral = forward = tracked = largest = error = 0.0
    for _ in range(periods):
        error = theta - tracked
        largest = max(largest, abs(error))
        forward += (1 - math.exp(-cutoff * T)) * (gamma * omega - forward) + T * share * acceleration
        tracked += T * (integral + 2 * wn * math.sin(error) + forward)
        integral += wn * wn * T * math.sin(error)
        theta += T * omega + 0.5 * acceleration * T * T
        omega += acceleration * T
    return error, largest, wn * wn


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

    def test_table_of_a_shape_that_is_not_learnt(self):
        wn = natural_frequency(200.0, 50.0)
        rows = rows_below("| r/min with a shape that is not learnt")
        self.assertEqual(len(rows), 7)
        for rpm, deviation in rows:
            s = 6j * omega_of(float(rpm))
            passed = abs((2 * wn * s + wn * wn) / (s * s + 2 * wn * s + wn * wn))
            self.assertAlmostEqual(1e3 * 0.05 / math.sqrt(2) * passed, float(deviation), delta=half_digit(deviation))

    def test_a_shape_that_is_left_moves_the_twelfth_harmonic(self):
        a, c, count = 0.383, 0.02, 3600
        angles = [2 * math.pi * n / count for n in range(count)]
        moved = sum(a * math.sin(6 * t) * math.sin(12 * (t + c * math.sin(6 * t))) for t in angles) / count
        self.assertAlmostEqual(moved, -3 * c * a, delta=0.03 * 3 * c * a)

    def test_error_while_accelerating(self):
        for cutoff, gamma in ((0.0, 1.0), (25.0, 1.0), (25.0, 0.9), (25.0, 1.1)):
            error, _, ki = ramp(100.0, cutoff, 80.0, gamma)
            self.assertAlmostEqual(error, math.asin(80.0 / ki * (1 - gamma if cutoff else 1)), delta=1e-9)

    def test_error_of_the_torques_share(self):
        alone = ramp(200.0, 50.0, 100.0)[1]
        for share in (0.7, 1.3):
            self.assertAlmostEqual(ramp(200.0, 50.0, 100.0, share=share)[1] / alone, 0.3, delta=0.01)

    def test_inertia_of_a_way_with_a_load_that_grows_with_the_speed(self):
        k, viscous, target = 69.0, 1e-3, 500.0
        omega, time, way, tail = 0.0, 0.0, None, None
        total, push = 0.0, 6.0
        while tail is None:
            if way is None and target - omega < 8.0:
                way = (omega, total, time)
            pushed = push if way is None else 20.0 * (target - omega) / k
            total += (pushed + viscous * omega) * T
            omega += k * pushed * T
            time += T
            if way is not None and time - way[2] >= 0.15:
                tail = (omega - way[0], total - way[1], time - way[2])
        r = way[2] / (2 * tail[2])
        self.assertAlmostEqual((way[0] - r * tail[0]) / (way[1] - r * tail[1]) / k, 1.0, delta=0.005)
        self.assertLess(way[0] / way[1] / k, 0.98)  # without the tail

    def test_peak_after_a_step_of_acceleration(self):
        wn = natural_frequency(200.0, 50.0)
        self.assertAlmostEqual(wn / 50.0, 1.04, delta=0.005)
        self.assertAlmostEqual(ramp(200.0, 50.0, 100.0)[1] * wn * wn / 100.0, 2 * math.exp(-2), delta=0.01)

    def test_fourth_error_coefficient(self):
        kp, ki, wc, s = 52.0, 670.0, 25.0, 1e-4
        rest = 1 / ((s + wc) * (s * s + kp * s + ki)) - 1 / (ki * wc)
        self.assertAlmostEqual(rest / s, -(ki + kp * wc) / (ki * wc)**2, delta=1e-9)


# ---- Inverter, encoder, rig ---------------------------------------------------------------------------------------------


class Rest(unittest.TestCase):
    def test_leg(self):
        u_dc, tau, v_ce, v_f, duty = 311.0, 0.023, 0.88, 1.06, 0.56
        for sign in (1, -1):
            high = duty - sign * tau
            mean = high * (u_dc - v_ce) - (1 - high) * v_f if sign > 0 else high * (u_dc + v_f) + (1 - high) * v_ce
            said = sign * (tau * (u_dc - v_ce + v_f) + (v_ce + v_f) / 2) + (duty - 0.5) * (v_ce - v_f)
            self.assertAlmostEqual(duty * u_dc - mean, said, delta=1e-9)

    def test_staircase_of_the_three_legs(self):
        along, across, points = 0.0, 0.0, 3600
        for n in range(points):
            phi = 2 * math.pi * (n + 0.5) / points
            a, b, c = (math.copysign(1, math.cos(phi - k * 2 * math.pi / 3)) for k in range(3))
            vector = complex((2 * a - b - c) / 3, (b - c) / math.sqrt(3))
            self.assertAlmostEqual(abs(vector), 4 / 3, delta=1e-9)
            turned = vector * cmath.exp(-1j * phi)
            along += turned.real / points
            across = max(across, abs(turned.imag))
        self.assertAlmostEqual(along, 4 / math.pi, delta=1e-5)
        self.assertAlmostEqual(across, 2 / 3, delta=1.1e-3)  # one step of phi before the jump

    def test_sixth_harmonic_across_the_current(self):
        """What is learnt from a turn of section 25, with the mean taken off as it says."""
        steps, mean, seen, turns = 3600, 0, 0.0, 6
        for n in range(turns * steps):
            phi = 2 * math.pi * (n + 0.5) / steps
            a, b, c = (math.copysign(1, math.cos(phi - k * 2 * math.pi / 3)) for k in range(3))
            vector = complex((2 * a - b - c) / 3, (b - c) / math.sqrt(3))
            turn = 2 * math.pi / steps
            mean *= cmath.exp(1j * turn)
            mean += turn * (vector - mean)
            if n >= (turns - 1) * steps:
                rest = (vector - mean) * cmath.exp(-1j * phi)
                seen += rest.imag * -12 / 35 * math.sin(6 * phi) / steps
        self.assertAlmostEqual(seen, 4 / math.pi * (12 / 35) ** 2 / 2 * 36 / 37, delta=2e-4)

    def test_mean_of_a_shifted_relay(self):
        amplitude, offset, points = 1.2, 0.03, 100000
        mean = sum(math.copysign(1, amplitude * math.sin(2 * math.pi * (n + 0.5) / points) - offset)
                   for n in range(points)) / points
        self.assertAlmostEqual(mean, -2 * offset / (math.pi * amplitude), delta=1e-4)

    def test_encoder(self):
        for bandwidth in (300.0, 1500.0, 3000.0):
            r = 1 - math.exp(-bandwidth * T)
            omega_hat = expected = theta = omega = late = 0.0
            for _ in range(5000):
                error = theta - expected
                omega_hat += r * r / T * error
                expected += T * omega_hat + r * (2 - r) * error
                late = omega_hat - omega
                theta += T * omega + 0.5 * 1000.0 * T * T
                omega += 1000.0 * T
            self.assertAlmostEqual(late, -1000.0 * T * (2 / r - 1.5), delta=1e-6)
            omega_hat = expected = total = 0.0
            for n in range(5000):
                error = (n == 0) - expected
                omega_hat += r * r / T * error
                expected += T * omega_hat + r * (2 - r) * error
                total += abs(omega_hat)
            self.assertAlmostEqual(total / bandwidth, 2 / math.e, delta=0.002)

    def test_rig_of_the_paper(self):
        for braking, printed in ((-FRICTION, 0.355), (FRICTION, 0.449), (FRICTION + 5.0, 0.623)):
            error = 0.1
            for _ in range(200):
                torque = 1.5 * POLE_PAIRS * PSI * LIMIT * math.cos(error) + braking
                error = math.asin(POLE_PAIRS / INERTIA / 1624.0 * torque)
            self.assertAlmostEqual(error / printed, 1.0, delta=0.0101)


# ---- What stands in the sources -----------------------------------------------------------------------------------------


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
