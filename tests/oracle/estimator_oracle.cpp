#include "tests/oracle/estimator_oracle.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <Eigen/Dense>

namespace
{

using Complex = std::complex<double>;

double into_ramp(const estimator_oracle_case_t &q, double t)
{
    return std::clamp(t, q.ramp_start, q.ramp_end) - q.ramp_start;
}

double omega_at(const estimator_oracle_case_t &q, double t)
{
    return q.omega_start + q.acceleration * into_ramp(q, t) + q.swing * std::sin(q.swing_rate * t);
}

double acceleration_at(const estimator_oracle_case_t &q, double t)
{
    const bool ramp = t >= q.ramp_start && t < q.ramp_end;
    return (ramp ? q.acceleration : 0.0) + q.swing * q.swing_rate * std::cos(q.swing_rate * t);
}

double theta_at(const estimator_oracle_case_t &q, double t)
{
    const double ramp = into_ramp(q, t);
    const double after = std::max(t, q.ramp_end) - q.ramp_end;
    const double swung =
        q.swing_rate != 0.0 ? q.swing / q.swing_rate * (1.0 - std::cos(q.swing_rate * t)) : 0.0;
    return q.theta_start + q.omega_start * t + q.acceleration * ramp * (0.5 * ramp + after) + swung;
}

Complex emf_at(const estimator_oracle_case_t &q, double t)
{
    return Complex(0.0, q.flux_linkage * omega_at(q, t)) * std::polar(1.0, theta_at(q, t));
}

Complex current_at(const estimator_oracle_case_t &q, double t)
{
    const Complex rotor(q.current_d, q.current_q + q.current_torque * acceleration_at(q, t));
    return rotor * std::polar(1.0, theta_at(q, t));
}

/* Calculated from a whole number of periods, so that the end of one period and the begin of the next are
 * equal to the last bit. */
double time_of(const estimator_oracle_case_t &q, long k)
{
    return q.period * static_cast<double>(k);
}

Complex emf_mean(const estimator_oracle_case_t &q, double start)
{
    Eigen::Array<double, 5, 1> nodes, weights;
    nodes << -0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640;
    weights << 0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
        0.2369268850561891;
    const double lambda = q.resistance / q.inductance;
    const Eigen::Array<double, 5, 1> elapsed = 0.5 * q.period * (1.0 + nodes);
    const Eigen::Array<double, 5, 1> weight =
        0.5 * q.period * lambda * weights * (-lambda * (q.period - elapsed)).exp();
    Complex sum = 0.0;
    for (int n = 0; n < 5; n++) {
        sum += weight(n) * emf_at(q, start + elapsed(n));
    }
    return sum / -std::expm1(-lambda * q.period);
}

} // namespace

void estimator_oracle_sample(const estimator_oracle_case_t *rig, long k, estimator_oracle_sample_t *sample)
{
    const double before = time_of(*rig, k - 1);
    const double now = time_of(*rig, k);
    const double decay = rig->resistance / rig->inductance * rig->period;
    const double gain = -std::expm1(-decay) / rig->resistance;
    const Complex i = current_at(*rig, now);
    const Complex u = (i - std::exp(-decay) * current_at(*rig, before)) / gain + emf_mean(*rig, before);
    *sample = {{u.real(), u.imag()}, {i.real(), i.imag()}, theta_at(*rig, now), omega_at(*rig, now)};
}
