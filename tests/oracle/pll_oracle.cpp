#include "tests/oracle/pll_oracle.h"

#include <cmath>
#include <complex>
#include <vector>

#include <Eigen/Dense>
#include <unsupported/Eigen/MatrixFunctions>

namespace
{

using Complex = std::complex<double>;
using Vector4 = Eigen::Vector4d; /* coefficients of 1, s, s^2, s^3 */

Vector4 numerator(const pll_oracle_t &q)
{
    return {q.ki * q.wc, q.ki + q.kp * q.wc, q.kp + q.wc, 0.0};
}

Vector4 denominator(const pll_oracle_t &q)
{
    return {q.ki * q.wc, q.ki + q.kp * q.wc, q.kp + q.wc, 1.0};
}

Vector4 error_numerator(const pll_oracle_t &q)
{
    return {0.0, 0.0, q.wc * (1.0 - q.gamma), 1.0};
}

Complex value(const Vector4 &p, Complex s)
{
    return p(0) + s * (p(1) + s * (p(2) + s * p(3)));
}

/* |p(j omega)|^2 as a polynomial in omega^2. */
Vector4 square(const Vector4 &p)
{
    return {p(0) * p(0), p(1) * p(1) - 2.0 * p(0) * p(2), p(2) * p(2) - 2.0 * p(1) * p(3), p(3) * p(3)};
}

} /* namespace */

double pll_oracle_gain(const pll_oracle_t *loop, double omega)
{
    const Complex s(0.0, omega);
    return std::abs(value(numerator(*loop), s) / ((s + loop->wc) * (s * s + loop->kp * s + loop->ki)));
}

double pll_oracle_error_gain(const pll_oracle_t *loop, double omega)
{
    const Complex s(0.0, omega);
    return std::abs(1.0 -
                    value(error_numerator(*loop), s) / ((s + loop->wc) * (s * s + loop->kp * s + loop->ki)));
}

double pll_oracle_bandwidth(const pll_oracle_t *loop, int *crossings)
{
    const Vector4 p = 2.0 * square(numerator(*loop)) - square(denominator(*loop));
    Eigen::MatrixXd companion(3, 3);
    companion << -p(2) / p(3), -p(1) / p(3), -p(0) / p(3), 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
    const Eigen::VectorXcd roots = companion.eigenvalues();
    double largest = 0.0;
    *crossings = 0;
    for (int n = 0; n < 3; n++) {
        const bool real = std::abs(roots(n).imag()) < 1e-9 * std::abs(roots(n));
        if (real && roots(n).real() > 1e-9) {
            ++*crossings;
            largest = std::max(largest, roots(n).real());
        }
    }
    return std::sqrt(largest);
}

double pll_oracle_error_coefficient(const pll_oracle_t *loop, int n)
{
    /* Without feed-forward a factor s is common to both. */
    const int common = loop->wc == 0.0 ? 1 : 0;
    const Vector4 top = error_numerator(*loop);
    const Vector4 below = denominator(*loop);
    const auto at = [common](const Vector4 &p, int m) { return m + common <= 3 ? p(m + common) : 0.0; };
    std::vector<double> series;
    for (int m = 0; m <= n; m++) {
        double rest = at(top, m);
        for (int j = 1; j <= m; j++) {
            rest -= at(below, j) * series[static_cast<size_t>(m - j)];
        }
        series.push_back(rest / at(below, 0));
    }
    return series.back();
}

void pll_oracle_continuous(const pll_oracle_t *loop, int n, double scale, size_t count, double *error)
{
    /* Controllable canonical form of Phi_e1 = 1 + rest/below, driven by a chain of integrators that makes
     * t^n/n!. */
    const Vector4 below = denominator(*loop);
    const Vector4 rest = error_numerator(*loop) - below;
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(4 + n, 4 + n);
    system(0, 1) = 1.0;
    system(1, 2) = 1.0;
    system.block<1, 3>(2, 0) = -below.head<3>().transpose();
    system(2, 3) = 1.0;
    for (int m = 0; m < n; m++) {
        system(3 + m, 4 + m) = 1.0;
    }
    const Eigen::MatrixXd step = (system * loop->period).exp();
    Eigen::VectorXd x = Eigen::VectorXd::Zero(4 + n);
    x(3 + n) = scale;
    for (size_t k = 0; k < count; k++) {
        error[k] = rest.head<3>().dot(x.head<3>()) + x(3);
        x = step * x;
    }
}

void pll_oracle_sampled(const pll_oracle_t *loop, const double *theta, const double *omega, size_t count,
                        double *error, double *frequency)
{
    /* State: angle, integrator, feed-forward; input: angle, speed. The feed-forward acts in the step it comes
     * in. */
    const double t = loop->period;
    const double share = -std::expm1(-loop->wc * t);
    Eigen::MatrixXd a(3, 3);
    a << 1.0 - t * loop->kp, t, t * (1.0 - share), -t * loop->ki, 1.0, 0.0, 0.0, 0.0, 1.0 - share;
    Eigen::MatrixXd b(3, 2);
    b << t * loop->kp, t * share * loop->gamma, t * loop->ki, 0.0, 0.0, share * loop->gamma;
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < count; k++) {
        const Eigen::Vector3d next = a * x + b * Eigen::Vector2d(theta[k], omega[k]);
        error[k] = theta[k] - x(0);
        frequency[k] = (next(0) - x(0)) / t;
        x = next;
    }
}

double pll_oracle_radius(const pll_oracle_t *loop)
{
    const double t = loop->period;
    Eigen::MatrixXd a(2, 2);
    a << 1.0 - t * loop->kp, t, -t * loop->ki, 1.0;
    return a.eigenvalues().cwiseAbs().maxCoeff();
}
