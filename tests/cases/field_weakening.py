"""Field weakening of a family of motors without an encoder (p 4, 0.95 ohm, psi_f 0.1 Wb, J 0.01 kg m^2, 15 A, 311 V; L_q 20 mH and L_q/L_d
from 2 to 4, or 8 mH in both axes), on the real inverter.

usage: field_weakening.py [--long] LAGLESS FOLDER [TEST...]

The base speed is the speed at which the largest current, at most torque per ampere, needs the voltage that the inverter makes, 0.98 of
(0.92/sqrt3 - (4/pi) 0.023) U_dc (docs/theory.md, 30). The largest torque at a speed is found here by trying every i_d, with R; no
equation of the drive is used. The limits are the lines A5, A7 to A11, A17 and A19 of docs/salient.md."""
import collections
import itertools
import math
import sys
import unittest

from long_runs import DEVICE, LINK, TESTS, VOLTAGE, at, column, first, keep, mean, peak, recorded, share

FLUX, P, R, J, CURRENT = 0.1, 4, 0.95, 0.01, 15.0
FAMILY = {1.0: 8e-3, 2.0: 20e-3, 3.0: 20e-3, 4.0: 20e-3}
SIX_STEP = 0.98 * (0.92 * 2 / math.pi - 4 / math.pi * 0.023) * LINK
TOP = {1.0: 2.4, 2.0: 3.0, 3.0: 3.0, 4.0: 3.0}  # multiples of the base speed; at 1.0 the link limits the EMF
NAMES = ("true_omega_m", "theta_hat_err", "i_alpha", "i_beta", "true_torque", "u_d_ref", "u_q_ref", "u_dc", "omega_m_ref", "lock_losses",
         "fault_reason")


Data = collections.namedtuple("Data", "p r l_d l_q flux j current")
# A power stage: its name, link voltage [V], resistance of a device [ohm], the voltage that it makes [V], and its period [s].
Stage = collections.namedtuple("Stage", "board link device voltage period")
IGBT = Stage("pm50rl1a060", LINK, DEVICE, VOLTAGE, 1e-4)
# The duties end at 0.064 from 1, for the shunts, and at 0.014; the dead time is 0.008 of a period of 20 kHz.
MOSFET = Stage("mosfet_48v_60a", 36.0, 2e-3, 0.98 * (0.922 / math.sqrt(3) - 4 / math.pi * 0.008) * 36.0, 5e-5)


class Motor:
    """A motor with constant inductances; a subclass for saturation replaces flux_q, mtpa, most and own_rows."""

    def __init__(self, ratio, data=None, top=0.0, trip=1.1, stage=IGBT):
        self.current = 0.0  # [A], measured by the last call of steady()
        self.stage = stage
        data = data or Data(P, R, FAMILY[ratio] / ratio, FAMILY[ratio], FLUX, J, CURRENT)
        self.data, self.trip, self.ratio, self.l_d, self.l_q = data, trip, ratio, data.l_d, data.l_q
        self.saliency = self.l_q - self.l_d
        low, high = 1.0, 5000.0
        while high - low > 1e-3:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.voltage(*self.mtpa(), middle) < stage.voltage else (low, middle)
        self.base = low / data.p  # [rad/s] mechanical
        self.top = (top or TOP[ratio]) * self.base

    def mtpa(self, current=0.0):
        flux, current = self.data.flux, current or self.data.current
        i_d = -2 * self.saliency * current ** 2 / (flux + math.sqrt(flux ** 2 + 8 * (self.saliency * current) ** 2))
        return i_d, math.sqrt(current ** 2 - i_d ** 2)

    def flux_q(self, i_q):
        return self.l_q * i_q

    def voltage(self, i_d, i_q, omega):
        r = self.data.r + self.stage.device
        return math.hypot(r * i_d - omega * self.flux_q(i_q), r * i_q + omega * (self.data.flux + self.l_d * i_d))

    def torque(self, i_d, i_q):
        return 1.5 * self.data.p * ((self.data.flux + self.l_d * i_d) * i_q - self.flux_q(i_q) * i_d)

    def most(self, omega_m, volts=0.0):
        """The largest driving torque [N m] at this speed, over every i_d from 0 to -I with the largest i_q that the current limit and the
        voltage allow."""
        omega, r, best = self.data.p * omega_m, self.data.r + self.stage.device, 0.0
        volts = volts or self.stage.voltage
        a = (omega * self.l_q) ** 2 + r * r
        for i_d in (-self.data.current * n / 200 for n in range(201)):
            flux = self.data.flux + self.l_d * i_d
            b = omega * r * (flux - self.l_q * i_d)
            c = (r * i_d) ** 2 + (omega * flux) ** 2 - volts ** 2
            if b * b > a * c:
                room = math.sqrt(self.data.current ** 2 - i_d ** 2)
                best = max(best, self.torque(i_d, min((math.sqrt(b * b - a * c) - b) / a, room)))
        return best

    def steady(self, share, current, *settings):
        """Mean and standard deviation of the angle error [mrad], lock losses and mean torque [N m], at this share of the base speed with
        this current at most torque per ampere. The rotor is caught at half of the base speed, and the shaft then moves it to the speed
        of the measurement."""
        return self.held(share, 0.999 * self.torque(*self.mtpa(current)), *settings)

    def held(self, share, torque, *settings):
        text = self.text("steady", 3.6, at(0.8, f"requests.torque_request = {torque}", 'requests.mode = "torque"') +
                         at(1.0, f"plant.shaft_locked_speed = {share * self.base}", ramp=0.8),
                         f"shaft_locked = 1\nshaft_locked_speed = {0.5 * self.base}")
        text = text.replace("[plant]", f"fallback_speed = {0.03 * self.base}\n[plant]")
        rows = recorded(NAMES, f"steady_{share}", text, *settings)
        self.current = mean(list(map(math.hypot, column(rows, "i_alpha", 2.6), column(rows, "i_beta", 2.6))))
        errors = column(rows, "theta_hat_err", 2.6)
        middle = mean(errors)
        scatter = 1e3 * math.sqrt(mean([(e - middle) ** 2 for e in errors]))
        return 1e3 * middle, scatter, max(column(rows, "lock_losses")), mean(column(rows, "true_torque", 2.6))

    def time(self, begin, end, torque=math.inf, parts=20):
        """The time [s] in which the largest torque (or this one, if it is smaller) moves the rotor from one speed to the other."""
        step = (end - begin) / parts
        return sum(step * self.data.j / min(torque, self.most(begin + (n + 0.5) * step)) for n in range(parts))

    def own_rows(self, trip):
        """The parameters and plant values that only this kind of motor needs: here those of the observer."""
        gain = 1.3 * (self.data.flux + self.saliency * self.data.current) * self.data.p * trip
        slope = 1.6 * self.l_q / (gain * self.stage.period)
        rows = f"observer_gain = {gain}\nobserver_slope = {slope}\nestimate_current_max = {4.0 / slope}\n"
        if self.stage is MOSFET:
            rows += f"low_speed_current = {0.2 * self.data.current}\nestimate_speed_min = {0.03 * self.base}\n"
        return rows, ""

    def text(self, title, duration, events, plant="", speed=None):
        """A scenario that begins at this speed, by default 0.3 of the base speed, or whose shaft holds the speed."""
        speed = 0.3 * self.base if speed is None else speed
        trip = self.trip * abs(self.top)
        params, own_plant = self.own_rows(trip)
        start = "" if "shaft_locked" in plant else f"[start]\nspeed = {speed}\n"
        return f"""schema = 1
title = "{title}"
board = "{self.stage.board}"
[run]
duration = {duration}
{start}[params]
motor_pole_pairs = {self.data.p}
motor_resistance = {self.data.r}
motor_inductance_d = {self.l_d}
motor_inductance_q = {self.l_q}
motor_flux_linkage = {self.data.flux}
motor_inertia = {self.data.j}
current_limit = {self.data.current}
overcurrent_trip = {1.25 * self.data.current}
overspeed_trip = {trip}
field_weakening = "on"
{params}[plant]
pole_pairs = {self.data.p}
resistance = {self.data.r}
inductance_d = {self.l_d}
inductance_q = {self.l_q}
flux_linkage = {self.data.flux}
inertia = {self.data.j}
friction_coulomb = 0
dc_voltage = {self.stage.link}
{own_plant}{plant}
[requests]
enable = "on"
speed_request = {speed}
{events}"""


# The motors of A19 with their power stages, and with inertias of the motor library; that of the hub motor is the one of a wheel of 2 kg and
# 7 cm. Columns: data, power stage, top speed divided by base speed, limits of the angle error on the way up and down [mrad], limits of its mean and SD
# at 5, 10, 30 and 80 % of the base speed under 66 % of the current [mrad].
REFERENCE = {
    "servo": (Data(3, 3.6, 36e-3, 51e-3, 0.545, 15e-3, 6.1), IGBT, 1.5, (3, 18), ((0.4, 5.2), (0.4, 2.8), (0.2, 1.2), (0.1, 0.5))),
    "traction": (Data(3, 0.216, 4.44e-3, 14.4e-3, 0.066, 3.24e-3, 15.0), IGBT, 3.0, (32, 44), ((29, 1.1), (14, 0.7), (4.2, 0.6), (1.7, 1.1))),
    "compressor": (Data(2, 0.57, 8.72e-3, 22.8e-3, 0.1077, 2e-3, 8.7), IGBT, 2.25, (17, 35), ((7.0, 1.5), (3.5, 1.0), (0.7, 0.7), (0.5, 1.6))),
    "1FT6084": (Data(4, 0.268, 2.2e-3, 2.2e-3, 0.1226, 14.6e-3, 15.0), IGBT, 1.35, (24, 62), ((0.3, 3.3), (0.8, 1.9), (1.2, 1.5), (0.1, 0.8))),
    "hub": (Data(15, 0.179, 0.336e-3, 0.336e-3, 0.023, 10e-3, 20.0), MOSFET, 1.5, (8, 10), ((0.7, 4.6), (0.5, 3.0), (0.1, 0.9), (0.1, 0.4))),
}


def longest(rows, begin):
    return max(map(math.hypot, column(rows, "i_alpha", begin), column(rows, "i_beta", begin)))


def up_and_down(motor, name, torque, settings=()):
    """The motor accelerates with all of its torque from 0.3 of the base speed to the top speed, holds it, and slows down to half of the
    base speed."""
    near = 0.97 * motor.top
    arrives = 1.0 + motor.time(0.3 * motor.base, motor.top, torque)
    text = motor.text(name, arrives + 2.4, at(1.0, f"requests.torque_request = {torque}", 'requests.mode = "torque"') +
                      at(arrives, f"requests.speed_request = {motor.top}", 'requests.mode = "speed"') +
                      at(arrives + 1.0, f"requests.speed_request = {0.5 * motor.base}"))
    rows = recorded(NAMES, name, text, *settings)
    up = first(rows, 1.0, lambda speed: speed >= near)
    down = first(rows, arrives + 1.0, lambda speed: speed <= 0.52 * motor.base)
    return rows, {
        "time": (up - 1.0) / motor.time(0.3 * motor.base, near, torque),
        "current": longest(rows, 1.0) / motor.data.current,
        "up": peak(rows, 1.0, up),
        "down": peak(rows, arrives + 1.0, down + 0.02),
        "losses": max(column(rows, "lock_losses")),
        "fault": max(column(rows, "fault_reason")),
    }


class FieldWeakening(unittest.TestCase):
    def test_a7_up_to_three_times_the_base_speed_and_down(self):
        for ratio in share(FAMILY, 1):
            with self.subTest(ratio=ratio):
                motor = Motor(ratio)
                rows, seen = up_and_down(motor, f"a7_{ratio}", 0.999 * motor.torque(*motor.mtpa()))
                self.assertEqual((seen["losses"], seen["fault"]), (0, 0), seen)
                keep(self, "A7 time", seen["time"], 1.04)
                keep(self, "A7 current", seen["current"], 1.08)
                keep(self, "A7 up", seen["up"], 30.0)
                keep(self, "A7 down", seen["down"], 75.0)
                arrives = 1.0 + 1.04 * motor.time(0.3 * motor.base, motor.top)
                # A9: torque and voltage at 1.5 to 2.9 times the base speed
                for times in (1.5, 2.0, 2.9) if ratio > 1 else (1.5, 2.0):
                    near = [row for row in rows if 1.0 < row["time"] < arrives and
                            abs(row["true_omega_m"] - times * motor.base) < 0.04 * motor.base]
                    torque, best = mean(column(near, "true_torque")), motor.most(mean(column(near, "true_omega_m")))
                    keep(self, "A9 torque of the acceleration", 100.0 * abs(torque / best - 1.0), 1.0)
                    voltage = mean(list(map(math.hypot, column(near, "u_d_ref"), column(near, "u_q_ref"))))
                    keep(self, "A7 voltage", abs(voltage - VOLTAGE) / LINK * math.sqrt(3), 0.005)

    def test_a9_most_torque_at_constant_speed(self):
        """The torque is at most 1 % below the largest torque that any i_d gives, and the current is not larger."""
        for ratio, times in share(itertools.product((2.0, 3.0, 4.0), (0.5, 1.0, 1.5, 2.0, 2.9)), 1):
            with self.subTest(ratio=ratio, times=times):
                motor = Motor(ratio)
                error, scatter, losses, torque = motor.steady(times, CURRENT)
                self.assertEqual(losses, 0)
                self.assertLess(abs(error), 2.0)
                self.assertLess(scatter, 3.0)
                keep(self, "A9 torque", 100.0 * abs(torque / motor.most(times * motor.base) - 1.0), 1.0)
                keep(self, "A9 current", motor.current / CURRENT, 1.005)

    def test_over_modulation(self):
        """The angle stays within its limits up to six-step operation, since the observer knows the voltage of the duties. The current
        control responds to the current of six times the frequency, which reduces the largest torque at this voltage by up to 7 %."""
        cells = [(ratio, times, use) for ratio, use in itertools.product(FAMILY, (0.93, 1.1)) for times in (1.5, 2.0)]
        for ratio, times, use in share(cells, 1):
            with self.subTest(ratio=ratio, times=times, use=use):
                motor = Motor(ratio)
                error, scatter, losses, torque = motor.steady(times, CURRENT, "over_modulation=on", f"voltage_use={use}")
                most = motor.most(times * motor.base, min(use * LINK / math.sqrt(3), SIX_STEP))
                self.assertEqual(losses, 0)
                self.assertLess(abs(error), 2.0)
                self.assertLess(scatter, 5.0)
                self.assertLess(abs(torque - most), 0.07 * most)
                self.assertGreater(torque, 1.025 * motor.most(times * motor.base))

    def test_a8_with_wrong_data(self):
        """The drive is configured with L_q 10 %, L_d 20 %, psi_f 10 %, R 30 % and J 20 % wrong in turn, or compensates only 0.8 of the dead
        time. The wrong L_q stays below 4 L_d."""
        def wrong(motor):
            return ((f"motor_inductance_q={1.1 * motor.l_q}",), (f"motor_inductance_q={0.9 * motor.l_q}",),
                    (f"motor_inductance_d={1.2 * motor.l_d}",), (f"motor_inductance_d={0.8 * motor.l_d}",),
                    ("motor_flux_linkage=0.11",), ("motor_flux_linkage=0.09",), ("motor_resistance=1.235",), ("motor_resistance=0.665",),
                    ("motor_inertia=0.012",), ("motor_inertia=0.008",), ("compensation_gain=0.8",))
        cells = [(motor, *w) for motor in map(Motor, (2.0, 3.0)) for w in wrong(motor)]
        for motor, setting in share(cells, 1):
            with self.subTest(ratio=motor.ratio, setting=setting):
                torque = 0.9 * motor.torque(*motor.mtpa())  # the part of the torque that the drive can make at least with wrong data
                gain = 1.6 * (FLUX + motor.saliency * CURRENT) * P * 1.1 * motor.top
                slope = 1.4 * motor.l_q / (gain * 1e-4)
                _, seen = up_and_down(motor, f"a8_{motor.ratio}", torque, (setting, "inertia_adaptation=off", f"observer_gain={gain}",
                                                                           f"observer_slope={slope}", f"estimate_current_max={4 / slope}"))
                self.assertEqual((seen["losses"], seen["fault"]), (0, 0), seen)
                keep(self, "A8 up", seen["up"], 220.0)
                keep(self, "A8 down", seen["down"], 450.0)
                keep(self, "A8 time", seen["time"], 1.06)

    def test_a5_a_wrong_l_q_at_twice_the_base_speed(self):
        """L_q is wrong by a tenth; the shaft holds twice the base speed, with two thirds of the largest torque at it and gains by rule."""
        for ratio, wrong, way in share(itertools.product((2.0, 3.0, 4.0), (0.9, 1.1), (1, -1)), 1):
            if wrong * ratio > 4.0:
                continue  # the drive refuses this ratio
            with self.subTest(ratio=ratio, wrong=wrong, way=way):
                motor = Motor(ratio)
                torque = way * 0.66 * motor.most(2.0 * motor.base)
                error, scatter, losses, seen = motor.held(2.0, torque, f"motor_inductance_q={wrong * motor.l_q}")
                self.assertEqual(losses, 0)
                keep(self, "A5 at twice the base speed", abs(error), 95.0)
                keep(self, "A5 SD at twice the base speed", scatter, 5.0)

    def test_a10_a_link_that_sinks_and_loads_that_step(self):
        for ratio, event in share(itertools.product((2.0, 3.0, 4.0), ("sag", 0.5, 0.95, -0.5, -0.95)), 1):
            with self.subTest(ratio=ratio, event=event):
                motor = Motor(ratio)
                happens = (at(2.2, "plant.dc_voltage = 220", ramp=0.002) if event == "sag" else
                           at(2.2, f"plant.load_torque = {event * motor.most(motor.top)}"))
                text = motor.text("a10", 3.4, at(0.6, f"requests.speed_request = {motor.top}") + happens, "load_kind = 1")
                rows = recorded(NAMES, f"a10_{ratio}_{event}", text)
                self.assertEqual((max(column(rows, "lock_losses")), max(column(rows, "fault_reason"))), (0, 0))
                keep(self, "A10 sag" if event == "sag" else "A10 load", peak(rows, 2.15), 25.0 if event == "sag" else 200.0)
                self.assertGreater(mean(column(rows, "true_omega_m", 3.2)), 0.99 * motor.top)

    def test_a11_braking_into_a_link_that_stores(self):
        for ratio in share((2.0, 3.0, 4.0), 1):
            with self.subTest(ratio=ratio):
                motor = Motor(ratio)
                text = motor.text("a11", 4.0, at(0.6, f"requests.speed_request = {motor.top}") +
                                  at(2.2, f"requests.speed_request = {0.5 * motor.base}"), "dc_resistance = 0.2\ndc_capacitance = 1e-3")
                rows = recorded(NAMES, f"a11_{ratio}", text)
                self.assertEqual((max(column(rows, "lock_losses")), max(column(rows, "fault_reason"))), (0, 0))
                keep(self, "A11 link", max(column(rows, "u_dc")), 405.0)
                self.assertGreater(max(column(rows, "u_dc")), 370.0)  # the motor did feed the link
                keep(self, "A11 angle", peak(rows, 2.2), 60.0)

    def test_a17_a_load_beyond_the_braking_torque(self):
        """A load of 1.3 times the largest torque accelerates the shaft. The drive must begin a quick stop within 100 ms after 1.1 times the
        reference is exceeded, and must not lose the rotor before the quick stop ends with the fault."""
        for ratio, way in share(itertools.product((2.0, 3.0, 4.0), (1, -1)), 1):
            with self.subTest(ratio=ratio, way=way):
                motor = Motor(ratio, trip=1.3)
                motor.base *= way
                motor.top *= way
                text = motor.text("a17", 3.0, at(0.6, f"requests.speed_request = {motor.top}") +
                                  at(2.2, f"plant.load_torque = {-1.3 * way * motor.most(abs(motor.top))}"), "load_kind = 1")
                rows = recorded(NAMES, f"a17_{ratio}_{way}", text)
                beyond = first(rows, 2.2, lambda speed: abs(speed) > 1.1 * abs(motor.top))
                reacts = next(row["time"] for row in rows if row["time"] > 2.2 and row["omega_m_ref"] == 0.0)
                keep(self, "A17 reaction", 1e3 * (reacts - beyond), 100.0)
                self.assertEqual((rows[-1]["fault_reason"], max(column(rows, "lock_losses"))), (53, 0))
                self.assertLess(peak(rows, 2.15, reacts), 200.0)

    def test_a19_reference_motors(self):
        """The motors run up and down with all of their torque, and at four speeds with two thirds of the current. The limits are at least
        1.2 mrad for the mean and 2 mrad for the deviation."""
        for name in share(REFERENCE, 1):
            data, stage, top, (up, down), steady = REFERENCE[name]
            motor = Motor(data.l_q / data.l_d, data, top, 1.3, stage)
            with self.subTest(motor=name):
                _, seen = up_and_down(motor, f"a19_{name}", 0.999 * motor.torque(*motor.mtpa()))
                self.assertEqual((seen["losses"], seen["fault"]), (0, 0), seen)
                keep(self, f"A19 {name} up", seen["up"], 1.5 * up)
                keep(self, f"A19 {name} down", seen["down"], 1.5 * down)
            for part, (middle, deviation) in zip((0.05, 0.1, 0.3, 0.8), steady):
                with self.subTest(motor=name, part=part):
                    error, scatter, losses, _ = motor.steady(part, 0.66 * data.current)
                    self.assertEqual(losses, 0)
                    keep(self, f"A19 {name} mean at {part:.0%}", abs(error), max(1.2, 1.5 * middle))
                    keep(self, f"A19 {name} SD at {part:.0%}", scatter, max(2.0, 1.5 * deviation))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + TESTS)
