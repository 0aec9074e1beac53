#!/usr/bin/env python3
"""An estimator in Python that runs in parallel with that of the drive: it gets the same voltages and currents, and is compared with the
true angle.

It integrates the voltage minus R i to the flux of the magnets, whose angle is that of the rotor. A correction of its length towards the
known flux prevents a drift by offsets:

    d psi/dt = u - R i - L di/dt + g (psi_f - |psi|) psi/|psi|

usage: estimator.py
"""
import cmath

import numpy as np

import lagless

SCENARIO = {
    "title": "A user's estimator at 1000 r/min under 3 N m, after a start from standstill",
    "run": {"duration": "4 s", "record": ["u_alpha", "u_beta", "i_alpha", "i_beta", "true_theta_e", "theta_hat_err"]},
    "params": {"position_source": "encoder", "inductance_adaptation": 0},
    "requests": {"enable": "on", "speed_request": "1000 r/min"},
    "plant": {"load_torque": "3 N m"},
}


def estimate(u, i, period, resistance, inductance, flux, gain):
    """Angle of the rotor [rad] for each sample: u, mean voltage of the period before it [V], and i [A], as alpha + j beta."""
    angles = np.empty(len(u))
    psi, before = complex(flux), i[0]
    for n, (voltage, current) in enumerate(zip(u.tolist(), i.tolist())):
        psi += period * (voltage - resistance * (current + before) / 2) - inductance * (current - before)
        psi += period * gain * (flux - abs(psi)) * psi / abs(psi)
        angles[n], before = cmath.phase(psi), current
    return angles


def wrap(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def run(gain=50.0):
    """The drive's Result, and the error of this estimator for each sample [rad]."""
    result = lagless.run(SCENARIO)
    assumed = {name: lagless.row("motor_" + name).initial for name in ("resistance", "inductance_q", "flux_linkage")}
    angles = estimate(result.u_alpha + 1j * result.u_beta, result.i_alpha + 1j * result.i_beta, lagless.period(),
                      assumed["resistance"], assumed["inductance_q"], assumed["flux_linkage"], gain)
    return result, wrap(angles - result.true_theta_e)


def main():
    result, error = run()
    end = result.t >= 3.0
    for name, one in (("this one", error), ("the drive's", result.theta_hat_err)):
        print(f"{name:12} mean {1e3 * one[end].mean():6.2f} mrad, deviation {1e3 * one[end].std():5.2f} mrad from 3 s on")


if __name__ == "__main__":
    main()
