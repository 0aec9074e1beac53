#!/usr/bin/env python3
"""A current controller in Python that controls the plant: a PI control in the rotor frame, tuned by the data of the winding. The
inverter is simulated with every gate edge.

The shaft is held at a speed; the reference of i_q steps. A loop of bandwidth alpha answers like 1 - exp(-alpha t).

usage: current_control.py [--plot]
"""
import cmath
import math
import sys

import lagless

MOTOR = {"n_p": 4, "R_s": 0.95, "L_d": 0.0125, "L_q": 0.0125, "psi_f": 0.183, "J": 0.0636}


class CurrentControl:
    """u = kp e + ki int e - r i + EMF, e = i* - i. The virtual resistance r damps disturbances by the inverter; kp = alpha L, ki
    = alpha^2 L and r = alpha L - R make the open loop alpha/s."""

    def __init__(self, motor, alpha, period):
        self.motor, self.period = motor, period
        self.kp, self.ki = alpha * motor["L_d"], alpha**2 * motor["L_d"]
        self.damping = alpha * motor["L_d"] - motor["R_s"]
        self.integral = 0j

    def __call__(self, now, reference):
        turn = cmath.exp(1j * now.theta_e)
        i = complex(now.i_a, (now.i_a + 2 * now.i_b) / math.sqrt(3)) / turn
        error = reference - i
        emf = 1j * now.omega_e * (self.motor["psi_f"] + self.motor["L_d"] * i)
        wanted = self.kp * error + self.integral - self.damping * i + emf
        u = wanted * min(1.0, now.u_dc / math.sqrt(3) / max(abs(wanted), 1e-9))
        self.integral += self.period * (self.ki * error + self.ki / self.kp * (u - wanted))
        # The voltage acts from the next period on, and in the middle of that period the rotor has turned for one and a half
        # periods.
        return duties(u * turn * cmath.exp(1.5j * now.omega_e * self.period), now.u_dc)


def duties(u, u_dc):
    """Three duties for a voltage vector, symmetrical about the middle of the link."""
    legs = [(u * cmath.exp(-2j * math.pi * n / 3)).real for n in range(3)]
    middle = (max(legs) + min(legs)) / 2
    return [0.5 + (leg - middle) / u_dc for leg in legs]


def run(alpha=1000.0, step=5.0, speed=50.0, seconds=0.03, at=0.01):
    """Lists of t, the true i_q and its reference [s, A, A]."""
    t, i_q, references = [], [], []
    with lagless.Plant(seed=1, shaft_locked=1, shaft_locked_speed=speed, **MOTOR) as plant:
        control = CurrentControl(MOTOR, alpha, plant.period)
        now = plant.state
        while now.t < seconds:
            reference = 1j * (step if now.t >= at else 0.0)
            now = plant.step(control(now, reference))
            t.append(now.t)
            i_q.append(now.i_q)
            references.append(reference.imag)
    return t, i_q, references


def main():
    t, i_q, references = run()
    begin = next(n for n, reference in enumerate(references) if reference > 0)
    rise = next(t[n] for n in range(begin, len(t)) if i_q[n] > 0.632 * references[n]) - t[begin]
    print(f"63 % after {1e3 * rise:.2f} ms, at the end {i_q[-1]:.2f} A of {references[-1]:.2f} A")
    if "--plot" in sys.argv[1:]:
        import matplotlib.pyplot as plt

        plt.step(t, references, "--", where="post", label="reference")
        plt.plot(t, i_q, label="i_q")
        plt.xlabel("time [s]")
        plt.ylabel("current [A]")
        plt.legend()
        plt.show()


if __name__ == "__main__":
    main()
