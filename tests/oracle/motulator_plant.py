#!/usr/bin/env python3
"""Compares the plant with motulator's model of a synchronous machine with the same data: a salient machine with constant inductances, and
one with axes that saturate each other. For the machine that saturates, the plant uses a flux map and motulator the law itself.

usage: motulator_plant.py LIBLAGLESS [STEP]

LIBLAGLESS: build/host/python/liblagless.so. STEP: step of the flux map [A], by default 0.5. Needs motulator 0.5.0, numpy and scipy,
which tools/setup does not install: python3 -m venv V && V/bin/pip install motulator==0.5.0.

The rotor is held at 100 rad/s; 60 ms of three-phase duties drive the currents to 11 A; motulator's equations are integrated from edge to
edge by an explicit method of order 8. Prints the largest difference of the current vector at the ends of the periods. Ends with 0 if
that is below 1 uA without a flux map, and below 0.5 mA with a map of 0.5 A."""
import math
import os
import pathlib
import sys
import tempfile
from types import SimpleNamespace

os.environ["LAGLESS_LIBRARY"] = sys.argv[1]
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "host_sim/python"))
import lagless  # noqa: E402
from motulator.drive.model import SynchronousMachine  # noqa: E402
from motulator.drive.utils import SynchronousMachinePars  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

# psi_d = psi_f + L_d i_d/s, psi_q = L_q i_q/s, s^2 = 1 + (L_d i_d^2 + L_q i_q^2)/K; both fluxes follow from one energy.
L_D, L_Q, K, FLUX, R, P, OMEGA, LINK = 0.02, 0.04, 2.0, 0.183, 0.95, 4, 100.0, 311.0
PERIOD, TICKS, CLOCK = 1e-4, 15000, 150e6
IDEAL = dict.fromkeys(("turn_on_delay", "turn_off_delay", "igbt_voltage", "igbt_resistance", "diode_voltage", "diode_resistance",
                       "current_noise", "friction_coulomb", "short_circuit_current", "current_zone"), 0)


def flux(i, bent):
    s = math.sqrt(1 + bent * (L_D * i.real ** 2 + L_Q * i.imag ** 2) / K)
    return complex(FLUX + L_D * i.real / s, L_Q * i.imag / s)


def current(psi, bent):
    d, q = psi.real - FLUX, psi.imag
    s = 1 / math.sqrt(1 - bent * (d * d / L_D + q * q / L_Q) / K)
    return complex(s * d / L_D, s * q / L_Q)


def turned(angle):
    return complex(math.cos(angle), math.sin(angle))


def write_map(path, step):
    currents = [step * n for n in range(-round(20 / step), round(20 / step) + 1)]
    rows = ["i_d,i_q,psi_d,psi_q"]
    for i_d in currents:
        for i_q in currents:
            psi = flux(complex(i_d, i_q), 1)
            rows.append(f"{i_d!r},{i_q!r},{psi.real!r},{psi.imag!r}")
    path.write_text("\n".join(rows) + "\n")


def duties(u):
    """The duties of this voltage vector, as even numbers of ticks of the carrier."""
    phases = [u.real, (-u.real + math.sqrt(3) * u.imag) / 2, (-u.real - math.sqrt(3) * u.imag) / 2]
    middle = (max(phases) + min(phases)) / 2
    return [2 * round(min(0.98, max(0.02, 0.5 + (phase - middle) / LINK)) * TICKS / 2) for phase in phases]


def through_a_period(machine, psi, turn, ticks):
    half = TICKS / 2
    edges = sorted({0.0, PERIOD} | {(half - n / 2) / CLOCK for n in ticks} | {(half + n / 2) / CLOCK for n in ticks})
    for begin, end in zip(edges, edges[1:]):
        a, b, c = [LINK * ((half - n / 2) / CLOCK < (begin + end) / 2 < (half + n / 2) / CLOCK) for n in ticks]
        u = complex(a - (b + c) / 2, math.sqrt(3) / 2 * (b - c)) * 2 / 3

        def rhs(t, state):
            machine.state.psi_s, machine.state.exp_j_theta_m = state
            machine.inp, machine.out = SimpleNamespace(u_ss=u, w_M=OMEGA), SimpleNamespace()
            machine.set_outputs(t)
            return machine.rhs()

        psi, turn = map(complex, solve_ivp(rhs, (0, end - begin), [psi, turn], rtol=1e-9, atol=1e-11, method="DOP853").y[:, -1])
    return psi, turn


def differ(bent, **rows):
    """Largest difference of the current vector, and the largest current [A]."""
    pars = SynchronousMachinePars(n_p=P, R_s=R, L_d=L_D, L_q=L_Q, psi_f=FLUX)
    machine = SynchronousMachine(pars, i_s=(lambda psi: current(psi, 1)) if bent else None, psi_s0=FLUX)
    psi, worst, most = complex(FLUX), 0.0, 0.0
    with lagless.Plant(dead_time=0, delay=0, pole_pairs=P, resistance=R, flux_linkage=FLUX, inductance_d=L_D, inductance_q=L_Q,
                       dc_voltage=LINK, shaft_locked=1, shaft_locked_speed=OMEGA, **IDEAL, **rows) as plant:
        theta = plant.state.theta_e
        turn = turned(theta)
        for k in range(600):
            goal = complex(-6 * math.sin(k / 90) ** 2 - 2, 9 * math.sin(k / 60))
            i = current(psi, bent)
            u = (R * goal + 1j * P * OMEGA * flux(goal, bent) + 15 * (goal - i)) * turned(theta + P * OMEGA * PERIOD / 2)
            ticks = duties(u)
            now = plant.step([n / TICKS for n in ticks])
            psi, turn = through_a_period(machine, psi, turn, ticks)
            theta = now.theta_e
            i = current(psi, bent)
            worst, most = max(worst, abs(i - complex(now.i_d, now.i_q))), max(most, abs(i))
    return worst, most


def main():
    step = float(sys.argv[2]) if len(sys.argv) > 2 else 0.5
    linear = differ(0)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "map.csv"
        write_map(path, step)
        mapped = differ(1, flux_map=str(path))
    print(f"constant L_d and L_q: {linear[0]:.2g} A of {linear[1]:.1f} A; flux map in steps of {step:g} A: {mapped[0]:.2g} A of {mapped[1]:.1f} A")
    return 0 if linear[0] < 1e-6 and mapped[0] < 5e-4 * max(1.0, (step / 0.5) ** 3.5) else 1


if __name__ == "__main__":
    sys.exit(main())
