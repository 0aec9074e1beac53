/* The expected results of the back-EMF observer, computed by other methods in double precision.
 *
 * Data: a winding with an EMF of constant speed and a current that rotates with it. The mean of the EMF over
 * the hold is integrated numerically.
 *
 * Response: the linear observer and its filter as one state space, solved for z = exp(j omega T).
 *
 * Run: the same observer stepped in time, with the switching function from the standard library. */
#ifndef TESTS_ORACLE_SMO_ORACLE_H
#define TESTS_ORACLE_SMO_ORACLE_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double resistance;   /* R [ohm] */
    double inductance;   /* L [H] */
    double flux_linkage; /* psi_f [Wb] */
    double period;       /* T [s] */
    double omega_e;      /* [rad/s] */
    double theta_start;  /* at k = 0 [rad] */
    double current_q;    /* on the q axis [A] */
} smo_oracle_case_t;

/* The values of period k: alpha and beta of the voltage that acted on [t_k-1, t_k) [V], of the current [A]
 * and of the EMF [V] at t_k. */
typedef struct {
    double voltage[2], current[2], emf[2];
} smo_oracle_sample_t;

typedef enum { SMO_ORACLE_SIGN, SMO_ORACLE_SIGMOID, SMO_ORACLE_VECTOR } smo_oracle_switching_t;

typedef struct {
    double gain;       /* k_s [V] */
    double slope;      /* a_f [1/A] */
    double emf_cutoff; /* omega_s [rad/s], 0 = no filter */
} smo_oracle_observer_t;

typedef struct {
    double lag;         /* [rad] lag of e_hat behind e */
    double attenuation; /* |e_hat|/|e| [-] */
} smo_oracle_response_t;

typedef struct {
    double mean, sd; /* [rad] of the angle of e_hat relative to e */
    double ratio;    /* [-] mean of |e_hat|/|e| */
    double product;  /* [A] mean of f x over both axes */
    double square;   /* [A^2] mean of x^2 over both axes */
} smo_oracle_run_t;

void smo_oracle_sample(const smo_oracle_case_t *rig, long k, smo_oracle_sample_t *sample);

/* The response with the equivalent gain k_f [1/A] on both axes. */
smo_oracle_response_t smo_oracle_response(const smo_oracle_case_t *rig, const smo_oracle_observer_t *observer,
                                          double k_f);

/* Statistics over `count` samples, after the first `settle` samples from the zero state. */
smo_oracle_run_t smo_oracle_run(const smo_oracle_case_t *rig, const smo_oracle_observer_t *observer,
                                smo_oracle_switching_t switching, long settle, long count);

#ifdef __cplusplus
}
#endif

#endif
