#include "tests/oracle/smo_oracle.h"

#include <cmath>
#include <complex>

#include <Eigen/Dense>

namespace
{

using Complex = std::complex<double>;

constexpr double pi = 3.14159265358979323846;

/* Integral over one period of exp(-lambda (T - s)) exp(j omega s) ds / L, which is the reduction of the
 * current by an EMF of 1 V at the start of the period. Gauss-Legendre with 3 points on 8 parts; the error
 * is below 1e-13. */
Complex emf_response(const smo_oracle_case_t &q)
{
    const double node = std::sqrt(0.6);
    const double nodes[] = {-node, 0.0, node};
    const double weights[] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
    constexpr int parts = 8;
    const double width = q.period / parts;
    Complex sum = 0.0;
    for (int part = 0; part < parts; part++) {
        for (int n = 0; n < 3; n++) {
            const double s = width * (part + 0.5 + 0.5 * nodes[n]);
            sum += 0.5 * width * weights[n] *
                   std::exp(Complex(-q.resistance / q.inductance * (q.period - s), q.omega_e * s));
        }
    }
    return sum / q.inductance;
}

double decay(const smo_oracle_case_t &q)
{
    return std::exp(-q.resistance * q.period / q.inductance);
}

double gain(const smo_oracle_case_t &q)
{
    return -std::expm1(-q.resistance * q.period / q.inductance) / q.resistance;
}

Complex emf_at(const smo_oracle_case_t &q, long k)
{
    const double theta =
        q.theta_start + std::remainder(q.omega_e * q.period * static_cast<double>(k), 2.0 * pi);
    return Complex(0.0, q.flux_linkage * q.omega_e) * std::polar(1.0, theta);
}

Complex current_at(const smo_oracle_case_t &q, long k)
{
    const double theta =
        q.theta_start + std::remainder(q.omega_e * q.period * static_cast<double>(k), 2.0 * pi);
    return Complex(0.0, q.current_q) * std::polar(1.0, theta);
}

/* The held voltage that leads to this current: i(k) = a i(k-1) + b u - response e(k-1). */
Complex voltage_before(const smo_oracle_case_t &q, long k)
{
    return (current_at(q, k) - decay(q) * current_at(q, k - 1) + emf_response(q) * emf_at(q, k - 1)) /
           gain(q);
}

} // namespace

void smo_oracle_sample(const smo_oracle_case_t *rig, long k, smo_oracle_sample_t *sample)
{
    const Complex u = voltage_before(*rig, k);
    const Complex i = current_at(*rig, k);
    const Complex e = emf_at(*rig, k);
    *sample = {{u.real(), u.imag()}, {i.real(), i.imag()}, {e.real(), e.imag()}};
}

smo_oracle_response_t smo_oracle_response(const smo_oracle_case_t *rig, const smo_oracle_observer_t *observer,
                                          double k_f)
{
    /* The states are x(k) and e_hat(k); x(k+1) = a x - b v + response e(k), e_hat(k+1) = c e_hat + (1 - c)
     * v(k+1). */
    const double g = observer->gain * k_f;
    const double c = observer->emf_cutoff > 0.0 ? std::exp(-observer->emf_cutoff * rig->period) : 0.0;
    const double p = decay(*rig) - gain(*rig) * g;
    Eigen::Matrix2cd system;
    system << p, 0.0, (1.0 - c) * g * p, c;
    Eigen::Vector2cd input(emf_response(*rig), (1.0 - c) * g * emf_response(*rig));
    const Complex z = std::polar(1.0, rig->omega_e * rig->period);
    const Eigen::Vector2cd state = (z * Eigen::Matrix2cd::Identity() - system).fullPivLu().solve(input);
    return {-std::arg(state(1)), std::abs(state(1))};
}

smo_oracle_run_t smo_oracle_run(const smo_oracle_case_t *rig, const smo_oracle_observer_t *observer,
                                smo_oracle_switching_t switching, long settle, long count)
{
    const double c = observer->emf_cutoff > 0.0 ? std::exp(-observer->emf_cutoff * rig->period) : 0.0;
    const double a = decay(*rig);
    const double b = gain(*rig);
    const auto axis = [&](double x) {
        return switching == SMO_ORACLE_SIGN ? static_cast<double>((x > 0.0) - (x < 0.0))
                                            : std::tanh(0.5 * observer->slope * x);
    };
    Complex hat = current_at(*rig, 0);
    Complex v = 0.0;
    Complex emf_hat = 0.0;
    double sum = 0.0;
    double squares = 0.0;
    smo_oracle_run_t run = {};
    for (long k = 1; k <= settle + count; k++) {
        hat = a * hat + b * (voltage_before(*rig, k) - v);
        const Complex x = hat - current_at(*rig, k);
        Complex f;
        if (switching == SMO_ORACLE_VECTOR) {
            const double length = std::abs(x);
            f = length > 0.0 ? std::tanh(0.5 * observer->slope * length) * x / length : Complex(0.0);
        } else {
            f = Complex(axis(x.real()), axis(x.imag()));
        }
        v = observer->gain * f;
        emf_hat = c * emf_hat + (1.0 - c) * v;
        if (k > settle) {
            const double angle = std::arg(emf_hat / emf_at(*rig, k));
            sum += angle;
            squares += angle * angle;
            run.ratio += std::abs(emf_hat / emf_at(*rig, k));
            run.product += f.real() * x.real() + f.imag() * x.imag();
            run.square += std::norm(x);
        }
    }
    const double n = static_cast<double>(count);
    run.mean = sum / n;
    run.sd = std::sqrt(squares / n - run.mean * run.mean);
    run.ratio /= n;
    run.product /= n;
    run.square /= n;
    return run;
}
