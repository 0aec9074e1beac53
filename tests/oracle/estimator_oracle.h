/* Exact data of a turning machine for the tests of the estimator, in double precision: angle and speed in
 * closed form, chosen currents, and the voltage that produces them.
 *
 *     omega(t) = omega_start + acceleration r(t) + swing sin(swing_rate t)
 *     r(t)     = clamp(t, ramp_start, ramp_end) - ramp_start
 *     i_d(t)   = current_d,   i_q(t) = current_q + current_torque d omega/dt
 *
 * The voltage u is held over [t_k-1, t_k). It follows from the solution of the winding's equation L di/dt = u
 * - R i - e, e = j omega psi_f e^(j theta), over a period, with a = exp(-lambda T), lambda = R/L:
 *
 *     i_k = a i_k-1 + (1 - a)/R (u - e_mean)
 *     e_mean = integral of lambda exp(-lambda (t_k - t)) e(t) dt/(1 - a)
 *
 * Times count from k = 0. ramp_start and ramp_end should be whole periods, since a kink within a period
 * costs accuracy. At a jump of the acceleration d omega/dt has the value after the jump. */
#ifndef TESTS_ORACLE_ESTIMATOR_ORACLE_H
#define TESTS_ORACLE_ESTIMATOR_ORACLE_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double resistance;     /* R [ohm] */
    double inductance;     /* L [H] */
    double flux_linkage;   /* psi_f [Wb] */
    double period;         /* T [s] */
    double theta_start;    /* [rad] at k = 0; this and all following values are electrical */
    double omega_start;    /* [rad/s] */
    double acceleration;   /* a [rad/s^2] */
    double ramp_start;     /* [s] */
    double ramp_end;       /* [s], not before ramp_start */
    double swing;          /* [rad/s] */
    double swing_rate;     /* [rad/s]; 0 = no swing */
    double current_d;      /* [A] */
    double current_q;      /* [A] */
    double current_torque; /* 1/K [A per rad/s^2] */
} estimator_oracle_case_t;

/* The values of period k: alpha and beta of the voltage that acted on [t_k-1, t_k) [V] and of the current
 * at t_k [A]; angle [rad], unwrapped, and speed [rad/s] at t_k. */
typedef struct {
    double voltage[2], current[2], theta, omega;
} estimator_oracle_sample_t;

/* A sample of any k, also a negative one. e_mean is calculated by Gauss-Legendre with 5 points; its
 * relative error is below 1e-13 for omega T and R T/L up to 0.6. */
void estimator_oracle_sample(const estimator_oracle_case_t *rig, long k, estimator_oracle_sample_t *sample);

#ifdef __cplusplus
}
#endif

#endif
