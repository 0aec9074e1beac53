#include "tests/oracle/pll_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "tests/oracle/exponential.h"

namespace
{

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

/* |p(j omega)|^2 as a polynomial in omega^2. */
Vector4 square(const Vector4 &p)
{
    return {p(0) * p(0), p(1) * p(1) - 2.0 * p(0) * p(2), p(2) * p(2) - 2.0 * p(1) * p(3), p(3) * p(3)};
}

double cubic(const Vector4 &p, double x)
{
    return p(0) + x * (p(1) + x * (p(2) + x * p(3)));
}

/* The positive roots of a cubic at which it changes its sign. Between its extremes the cubic is monotonic,
 * and no root exceeds 1 + max |p_n/p_3|. Each interval is halved until its ends are neighbouring numbers. */
std::vector<double> positive_roots(const Vector4 &p)
{
    const double most = 1.0 + (p.head<3>() / p(3)).cwiseAbs().maxCoeff();
    std::vector<double> ends = {0.0, most};
    const double discriminant = p(2) * p(2) - 3.0 * p(3) * p(1);
    if (discriminant > 0.0) {
        for (const double sign : {-1.0, 1.0}) {
            const double extreme = (sign * std::sqrt(discriminant) - p(2)) / (3.0 * p(3));
            if (extreme > 0.0 && extreme < most) {
                ends.push_back(extreme);
            }
        }
    }
    std::sort(ends.begin(), ends.end());
    std::vector<double> roots;
    for (size_t n = 0; n + 1 < ends.size(); n++) {
        double low = ends[n], high = ends[n + 1];
        const bool rises = cubic(p, low) < 0.0;
        if (rises == (cubic(p, high) < 0.0)) {
            continue;
        }
        for (double middle = 0.5 * (low + high); middle > low && middle < high; middle = 0.5 * (low + high)) {
            ((cubic(p, middle) < 0.0) == rises ? low : high) = middle;
        }
        roots.push_back(high);
    }
    return roots;
}

} /* namespace */

double pll_oracle_bandwidth(const pll_oracle_t *loop, int *crossings)
{
    const Vector4 p = 2.0 * square(numerator(*loop)) - square(denominator(*loop));
    const std::vector<double> roots = positive_roots(p);
    *crossings = static_cast<int>(roots.size());
    return roots.empty() ? 0.0 : std::sqrt(roots.back());
}

double pll_oracle_error_coefficient(const pll_oracle_t *loop, int n)
{
    /* Without feed-forward numerator and denominator have a common factor s. */
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
    /* The controllable canonical form of Phi_e1 = 1 + rest/below, driven by a chain of integrators that
     * produces t^n/n!. */
    const Vector4 below = denominator(*loop);
    const Vector4 rest = error_numerator(*loop) - below;
    if (n < 0 || 4 + n > Matrix9::RowsAtCompileTime) {
        throw std::out_of_range("pll_oracle_continuous: the power of the input is 0 to 5");
    }
    Matrix9 system = Matrix9::Zero();
    system(0, 1) = 1.0;
    system(1, 2) = 1.0;
    system.block<1, 3>(2, 0) = -below.head<3>().transpose();
    system(2, 3) = 1.0;
    for (int m = 0; m < n; m++) {
        system(3 + m, 4 + m) = 1.0;
    }
    const Matrix9 step = oracle_exponential(system * loop->period);
    Vector9 x = Vector9::Zero();
    x(3 + n) = scale;
    for (size_t k = 0; k < count; k++) {
        error[k] = rest.head<3>().dot(x.head<3>()) + x(3);
        x = step * x;
    }
}

void pll_oracle_sampled(const pll_oracle_t *loop, const double *theta, const double *omega, size_t count,
                        double *error, double *frequency)
{
    /* The states are angle, integrator and feed-forward; the inputs are angle and speed. The feed-forward
     * acts in the step of its input. */
    const double t = loop->period;
    const double share = -std::expm1(-loop->wc * t);
    Eigen::Matrix3d a;
    a << 1.0 - t * loop->kp, t, t * (1.0 - share), -t * loop->ki, 1.0, 0.0, 0.0, 0.0, 1.0 - share;
    Eigen::Matrix<double, 3, 2> b;
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
    /* The polynomial is z^2 - (2 - kp T) z + 1 - kp T + ki T^2; the magnitude of a complex pair of roots
     * is the square root of their product. */
    const double t = loop->period;
    const double half = 1.0 - 0.5 * t * loop->kp;
    const double product = 1.0 - t * loop->kp + t * t * loop->ki;
    const double discriminant = half * half - product;
    return discriminant < 0.0 ? std::sqrt(product) : std::fabs(half) + std::sqrt(discriminant);
}
