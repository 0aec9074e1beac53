/* The expected results of the PLL, from the paper's polynomials and from the sampled linear loop, in double
 * precision (Eigen): roots of polynomials, matrix exponentials. Small errors only: the detector is the angle
 * difference.
 *
 *     Phi_1   = [(kp + wc) s^2 + (ki + kp wc) s + ki wc] / [(s + wc)(s^2 + kp s + ki)]       (22); wc = 0:
 * (19) Phi_e1  = s^2 (s + wc (1 - gamma)) / [(s + wc)(s^2 + kp s + ki)]                       (23) for gamma
 * = 1
 *
 * gamma is the gain from speed to the feed-forward's speed. All values are deviations from a constant speed.
 */
#ifndef TESTS_ORACLE_PLL_ORACLE_H
#define TESTS_ORACLE_PLL_ORACLE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double kp;     /* [rad/s] */
    double ki;     /* [rad/s^2] */
    double wc;     /* omega_c [rad/s] */
    double gamma;  /* [-] */
    double period; /* T [s] */
} pll_oracle_t;

/* The highest frequency [rad/s] at which |Phi_1|^2 = 1/2, a root of a cubic in omega^2; and the number of
 * such frequencies. */
double pll_oracle_bandwidth(const pll_oracle_t *loop, int *crossings);

/* Coefficient of s^n in the power series of Phi_e1: the error left by an input t^n/n! [s^n]; (24). */
double pll_oracle_error_coefficient(const pll_oracle_t *loop, int n);

/* Angle error theta - theta_hat [rad] at t = 0, T, 2T, ... of the continuous loop (23) for the input scale
 * t^n/n!, n from 0 to 5. */
void pll_oracle_continuous(const pll_oracle_t *loop, int n, double scale, size_t count, double *error);

/* The same of the sampled loop, in the order of docs/theory.md, 7, from samples of the angle [rad] and of
 * the speed [rad/s]; and its whole frequency [rad/s]. */
void pll_oracle_sampled(const pll_oracle_t *loop, const double *theta, const double *omega, size_t count,
                        double *error, double *frequency);

/* Largest |z| of the sampled angle loop, without the feed-forward (it is not in the loop). */
double pll_oracle_radius(const pll_oracle_t *loop);

#ifdef __cplusplus
}
#endif

#endif
