#include "host_sim/lab/paper_theory.h"

#include <assert.h>
#include <complex.h>
#include <math.h>

#define PI     3.14159265358979323846
#define J      ((double complex)I)
#define PERIOD ((double)PAPER_PERIOD_TICKS / 150e6) /* T_s [s] */

const paper_machine_t paper_machine = {
    .pole_pairs = 4.0,
    .resistance = 0.95,
    .inductance = 12.5e-3,
    .flux_linkage = 0.183,
    .inertia = 0.0636,
    .friction = 1.32,
    .current_limit = 10.0,
};

static double torque_per_ampere(void)
{
    return 1.5 * paper_machine.pole_pairs * paper_machine.flux_linkage;
}

/* ---- PLL ---- */

/* |Phi_1(j omega)| of (22). */
static double closed_loop(double kp, double ki, double wc, double omega)
{
    const double complex s = J * omega;
    return cabs(((kp + wc) * s * s + (ki + kp * wc) * s + ki * wc) / ((s + wc) * (s * s + kp * s + ki)));
}

bool paper_loop(double bandwidth, double omega_c, double *kp, double *ki)
{
    double low = 1e-3 * bandwidth;
    double high = bandwidth;
    if (closed_loop(2.0 * low, low * low, omega_c, bandwidth) > sqrt(0.5)) {
        return false;
    }
    for (int n = 0; n < 60; n++) { /* the gain at `bandwidth` rises with the natural frequency */
        const double wn = 0.5 * (low + high);
        if (closed_loop(2.0 * wn, wn * wn, omega_c, bandwidth) < sqrt(0.5)) {
            low = wn;
        } else {
            high = wn;
        }
    }
    *kp = 2.0 * high;
    *ki = high * high;
    return true;
}

void paper_loop_filter(double bandwidth, double omega_c, double omega, double *gain, double *phase)
{
    double kp = 0.0;
    double ki = 0.0;
    const bool exists = paper_loop(bandwidth, omega_c, &kp, &ki);
    assert(exists);
    (void)exists;
    const double complex response = kp + ki / (J * omega);
    *gain = cabs(response);
    *phase = carg(response);
}

double paper_tracking_error(double ki, double acceleration)
{
    return -asin(acceleration / ki);
}

double paper_tracking_error_at_limit(double ki, double braking)
{
    /* k_i sin e - A cos e = B, the left a sine of the amplitude sqrt(k_i^2 + A^2) */
    const double per_torque = paper_machine.pole_pairs / paper_machine.inertia;
    const double driven = per_torque * torque_per_ampere() * paper_machine.current_limit;
    return asin(per_torque * braking / hypot(ki, driven)) + atan2(driven, ki);
}

/* ---- observer ---- */

double paper_sigmoid(double x)
{
    return tanh(0.5 * x);
}

double paper_sigmoid_gain(double x)
{
    return fabs(x) < 1e-6 ? 0.5 : paper_sigmoid(x) / x;
}

double paper_sign_gain(double x)
{
    return 1.0 / fmax(fabs(x), 1e-6);
}

/* Describing function of tanh(slope x/2) for a sine of this amplitude, by the trapezoidal rule over a whole
 * period, which converges faster than any power of the step. The four quarters of the period are equal. */
static double describing_gain(double slope, double amplitude)
{
    const int points = 8; /* of a quarter */
    double sum = 0.0;
    for (int n = 0; n < points; n++) {
        const double sine = sin(0.5 * PI * (n + 0.5) / points);
        sum += tanh(0.5 * slope * amplitude * sine) * sine;
    }
    return 2.0 * sum / (points * amplitude);
}

/* v/e of the sampled observer, exact zero-order hold, for g = k_s k_f (docs/theory.md, 4). */
static double complex sampled_response(double g, double omega_e)
{
    const double lambda = paper_machine.resistance / paper_machine.inductance;
    const double a = exp(-lambda * PERIOD);
    const double b = (1.0 - a) / paper_machine.resistance;
    const double complex z = cexp(J * omega_e * PERIOD);
    return b * g / (z - (a - b * g)) * lambda * (z - a) / ((1.0 - a) * (lambda + J * omega_e));
}

/* The k_f that belongs to the amplitude of the current error that it makes. */
static double settled_gain(double gain, double slope, double omega_e)
{
    const double emf = paper_machine.flux_linkage * fabs(omega_e);
    double k_f = 0.5 * slope;
    double change = emf;
    for (int n = 0; n < 100 && fabs(change) > 1e-12 * slope; n++) {
        const double amplitude = emf * cabs(sampled_response(gain * k_f, omega_e)) / (gain * k_f);
        change = describing_gain(slope, amplitude) - k_f;
        k_f += change;
    }
    return k_f;
}

double paper_lag_sampled(double gain, double slope, double omega_e)
{
    return carg(sampled_response(gain * settled_gain(gain, slope, omega_e), omega_e));
}

double paper_lag_printed(double gain, double slope, double omega_e)
{
    const double g = gain * settled_gain(gain, slope, omega_e);
    return -atan(omega_e * paper_machine.inductance /
                 (g * paper_machine.resistance + paper_machine.resistance));
}
