/* The functions of a shared object that lagless.bench("my_estimator.so") measures (docs/python.md). It is
 * compiled by
 *
 *     cc -shared -fPIC -O2 -I FOLDER my_estimator.c -o my_estimator.so -lm
 *
 * where FOLDER is the one of this file: python3 -c 'import lagless; print(lagless.bench.folder)'. */
#ifndef LAGLESS_BENCH_H
#define LAGLESS_BENCH_H

typedef struct {
    double period;       /* T [s] */
    double pole_pairs;   /* [-] */
    double resistance;   /* R [ohm] */
    double inductance_d; /* L_d [H] */
    double inductance_q; /* L_q [H] */
    double flux_linkage; /* psi_f [Wb] */
} lagless_motor_t;

/* The state of an estimator that is configured with this motor; NULL: not possible. The motor is valid during
 * the call only. */
void *estimator_create(const lagless_motor_t *motor);

/* The electrical angle of the rotor [rad] at the next sample. u: mean voltage on the winding in the period
 * that ends at the sample [V]; i: current at the sample [A]; both amplitude-invariant. */
double estimator_step(void *estimator, double u_alpha, double u_beta, double i_alpha, double i_beta);

/* Frees the state. */
void estimator_free(void *estimator);

#endif
