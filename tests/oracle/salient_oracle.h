/* Exact data of a salient rotor that turns at a constant speed: the voltage that changes its currents from
 * one sample to the next, in double precision.
 *
 * In the rotor's frame psi_d = L_d i_d + psi_f and psi_q = L_q i_q obey
 *
 *     psi_d' = u_d - R i_d + omega psi_q,   psi_q' = u_q - R i_q - omega psi_d
 *
 * and a voltage that is held in the stationary frame rotates backwards there: u' = -j omega u. Fluxes,
 * voltage and magnet together form a linear system with constant coefficients, so that the exponential of
 * one matrix is exact over the period, for any course of the currents. */
#ifndef TESTS_ORACLE_SALIENT_ORACLE_H
#define TESTS_ORACLE_SALIENT_ORACLE_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double resistance;   /* R [ohm] */
    double inductance_d; /* L_d [H] */
    double inductance_q; /* L_q [H] */
    double flux_linkage; /* psi_f [Wb] */
    double period;       /* T [s] */
    double omega;        /* [rad/s] electrical */
} salient_oracle_case_t;

/* alpha and beta of the voltage [V] that, held from t_k-1 to t_k, changes the currents [A] from `before`
 * to `now`; the magnet is at `theta` [rad] at t_k-1. */
void salient_oracle_voltage(const salient_oracle_case_t *rig, double theta, const double before[2],
                            const double now[2], double voltage[2]);

#ifdef __cplusplus
}
#endif

#endif
