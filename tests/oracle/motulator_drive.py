#!/usr/bin/env python3
"""motulator's sensorless flux-vector control on the salient motor of docs/peers.md, in closed loop on motulator's ideal plant.

usage: motulator_drive.py

Needs motulator 0.5.0, which tools/setup does not install: python3 -m venv V && V/bin/pip install motulator==0.5.0.
Prints, at four points with 14 A at most torque per ampere, the torque per ampere and the mean and deviation of the angle error, and the
time from 0.3 to 3 times the base speed at all torque of 15 A; host_sim/python/lagless/bench/peers.json has these numbers."""
import math

import numpy as np
from motulator.drive.control.sm import FluxTorqueReferenceCfg, FluxVectorControl
from motulator.drive.model import Drive, ExternalRotorSpeed, Simulation, StiffMechanicalSystem, SynchronousMachine, VoltageSourceConverter
from motulator.drive.utils import SynchronousMachinePars

PAR = SynchronousMachinePars(n_p=4, R_s=0.95, L_d=0.02 / 3, L_q=0.02, psi_f=0.1)
J, LINK, PERIOD, RPM = 0.01, 311.0, 1e-4, math.pi / 30
BASE = 1385 * RPM  # the base speed of field_weakening.py at 15 A
D = PAR.L_q - PAR.L_d


def mtpa(current):
    """The torque [N m] at most torque per ampere."""
    i_d = -2 * D * current ** 2 / (PAR.psi_f + math.sqrt(PAR.psi_f ** 2 + 8 * (D * current) ** 2))
    return 1.5 * PAR.n_p * (PAR.psi_f - D * i_d) * math.sqrt(current ** 2 - i_d ** 2)


def run(mechanics, speed, torque, duration, current):
    """At the sampling instants: time [s], torque [N m], |i| [A], angle error [rad], mechanical speed [rad/s]."""
    drive = Drive(VoltageSourceConverter(u_dc=LINK), SynchronousMachine(PAR), mechanics)
    control = FluxVectorControl(PAR, FluxTorqueReferenceCfg(PAR, max_i_s=current), T_s=PERIOD, sensorless=True)
    control.observer.est.w_m = PAR.n_p * speed
    control.ref.tau_M = torque
    Simulation(drive, control).simulate(t_stop=duration)
    machine, shaft, seen = drive.machine.data, drive.mechanics.data, control.data
    times = np.asarray(seen.ref.t)
    at = np.minimum(np.searchsorted(machine.t, times), len(machine.t) - 1)
    error = np.angle(np.exp(1j * (np.asarray(seen.fbk.theta_m) - PAR.n_p * shaft.theta_M[at])))
    return times, machine.tau_M[at], np.abs(machine.i_ss[at]), error, shaft.w_M[at]


def main():
    for rpm in (300, 1000):
        for way in (1, -1):
            speed = rpm * RPM
            times, torque, current, error, _ = run(ExternalRotorSpeed(lambda t, w=speed: w + 0 * t), speed,
                                                   lambda t, w=way: w * mtpa(14.0) * min(1.0, 10 * t), 1.0, 14.5)
            late = times > 0.6
            print(f"{rpm} r/min, {way:+d}: {abs(np.mean(torque[late])) / np.mean(current[late]):.4f} N m/A at {np.mean(current[late]):.2f} A, "
                  f"angle {1e3 * np.mean(error[late]):.1f} / {1e3 * np.std(error[late]):.1f} mrad")
    shaft = StiffMechanicalSystem(J)
    shaft.state.w_M = 0.3 * BASE
    times, torque, current, error, speed = run(shaft, 0.3 * BASE, lambda t: (t > 0.1) * 0.999 * mtpa(15.0), 0.65, 15.0)
    there = times[np.argmax(speed > 3 * BASE)] - 0.1
    print(f"0.3 to 3 times {BASE / RPM:.0f} r/min: {there:.3f} s, largest error {1e3 * np.max(np.abs(error[times < there + 0.1])):.0f} mrad, "
          f"current {np.max(current):.1f} A")


if __name__ == "__main__":
    main()
