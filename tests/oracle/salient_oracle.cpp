#include "tests/oracle/salient_oracle.h"

#include <cmath>

#include <Eigen/Dense>

namespace
{

using State = Eigen::Matrix<double, 5, 1>; /* i_d, i_q, u_d, u_q, 1 */
using Matrix = Eigen::Matrix<double, 5, 5>;

/* The exponential by its power series, for the matrix halved ten times: the norm is then below 0.01, and
 * the terms after the tenth are below 1e-23. */
Matrix exponential(const Matrix &matrix)
{
    constexpr int halvings = 10;
    const Matrix small = matrix / std::pow(2.0, halvings);
    Matrix sum = Matrix::Identity();
    Matrix term = Matrix::Identity();
    for (int n = 1; n <= 10; n++) {
        term = term * small / n;
        sum += term;
    }
    for (int n = 0; n < halvings; n++) {
        sum = sum * sum;
    }
    return sum;
}

Eigen::Vector2d turned(const Eigen::Vector2d &vector, double angle)
{
    return Eigen::Rotation2Dd(angle) * vector;
}

} // namespace

void salient_oracle_voltage(const salient_oracle_case_t *rig, double theta, const double before[2],
                            const double now[2], double voltage[2])
{
    Matrix rate = Matrix::Zero();
    rate.row(0) << -rig->resistance / rig->inductance_d, rig->omega * rig->inductance_q / rig->inductance_d,
        1.0 / rig->inductance_d, 0.0, 0.0;
    rate.row(1) << -rig->omega * rig->inductance_d / rig->inductance_q, -rig->resistance / rig->inductance_q,
        0.0, 1.0 / rig->inductance_q, -rig->omega * rig->flux_linkage / rig->inductance_q;
    rate(2, 3) = rig->omega; /* u' = -j omega u */
    rate(3, 2) = -rig->omega;
    const Matrix period = exponential(rate * rig->period);

    const Eigen::Vector2d from = turned({before[0], before[1]}, -theta);
    const Eigen::Vector2d to = turned({now[0], now[1]}, -(theta + rig->omega * rig->period));
    const Eigen::Vector2d free = period.block<2, 2>(0, 0) * from + period.block<2, 1>(0, 4);
    const Eigen::Matrix2d gain = period.block<2, 2>(0, 2);
    const Eigen::Vector2d u = turned(gain.inverse() * (to - free), theta);
    voltage[0] = u(0);
    voltage[1] = u(1);
}
