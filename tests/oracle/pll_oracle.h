/* The expected results of the PLL, from the paper's polynomials and from the sampled linear loop, in double
 * precision (Eigen): roots of polynomials, matrix exponentials. Valid for small errors, for which the
 * detector gives the angle difference.
 *
 *     Phi_1  = [(kp + wc) s^2 + (ki + kp wc) s + ki wc] / [(s + wc)(s^2 + kp s + ki)]
 *     Phi_e1 = s^2 (s + wc (1 - gamma)) / [(s + wc)(s^2 + kp s + ki)]
 *
 * Phi_1 is (22), with wc = 0 (19); Phi_e1 with gamma = 1 is (23). gamma is the gain from speed to the
 * feed-forward's speed. All values are deviations from a constant speed. */
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

/* The coefficient of s^n in the power series of Phi_e1 [s^n], that is the remaining error at an input
 * t^n/n!; (24). */
double pll_oracle_error_coefficient(const pll_oracle_t *loop, int n);

/* The angle error theta - theta_hat [rad] of the continuous loop (23) at t = 0, T, 2T, ... for the input
 * scale t^n/n!, n from 0 to 5. */
void pll_oracle_continuous(const pll_oracle_t *loop, int n, double scale, size_t count, double *error);

/* The angle error of the sampled loop, computed in the order of docs/theory.md, 7, from samples of the
 * angle [rad] and of the speed [rad/s]; and the total frequency of that loop [rad/s]. */
void pll_oracle_sampled(const pll_oracle_t *loop, const double *theta, const double *omega, size_t count,
                        double *error, double *frequency);

/* The largest |z| of the sampled angle loop. The feed-forward is outside this loop and has no influence. */
double pll_oracle_radius(const pll_oracle_t *loop);

#ifdef __cplusplus
}
#endif

#endif
