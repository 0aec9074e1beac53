#!/usr/bin/env python3
"""The paper's observer with sigmoid switching, eqs. (5), (12) and (14) of docs/paper.md, on the bench of estimators.

usage: paper_observer.py [TEXT]     TEXT: only cases whose names contain it, "1490 r/min, 0 A, ideal"
"""
import cmath
import math
import sys

import lagless

GAIN, SLOPE = 201.0, 0.994  # k_s [V], a_f [1/A] by the rule for the paper's motor
CORNER = 100.0              # bandwidths of the means of k_f and of the speed [rad/s]


class PaperObserver:
    compensated = True

    def __init__(self, motor):
        self.motor, self.decay = motor, math.exp(-motor.resistance * motor.period / motor.inductance_q)
        self.share = 1 - math.exp(-CORNER * motor.period)
        self.i_hat = self.v = 0j
        self.speed, self.turn, self.products, self.squares = 0.0, 1 + 0j, 1e-9, 2e-9 / SLOPE

    def __call__(self, u, i):
        m = self.motor
        self.i_hat = self.decay * self.i_hat + (1 - self.decay) / m.resistance * (u - self.v)              # (5)
        x, before = self.i_hat - i, self.v
        f = complex(math.tanh(SLOPE * x.real / 2), math.tanh(SLOPE * x.imag / 2))
        self.v = GAIN * f
        self.products += self.share * ((f * x.conjugate()).real - self.products)
        self.squares += self.share * (abs(x) ** 2 - self.squares)
        k_f = self.products / self.squares                                                                  # (12)
        self.turn += self.share * (self.v * before.conjugate() - self.turn)
        self.speed = cmath.phase(self.turn) / m.period
        lag = math.atan(self.speed * m.inductance_q / (GAIN * k_f + m.resistance)) if self.compensated else 0.0   # (14), erratum 1
        e = -1j * self.v if self.speed >= 0 else 1j * self.v       # e = j psi_f omega e^(j theta), (2)
        return cmath.phase(e) + lag


class Uncompensated(PaperObserver):
    compensated = False


if __name__ == "__main__":
    for estimator in (Uncompensated, PaperObserver):
        print(f"{estimator.__name__}\n{lagless.bench(estimator, only=''.join(sys.argv[1:2]))}\n")
