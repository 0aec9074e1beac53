/* Running: the motor follows its speed or current references in the frame of the rotor.
 *
 * One step per T. Does not handle: starting, reversing slowly, a lost rotor. */
#ifndef MANOEUVRE_RUN_H
#define MANOEUVRE_RUN_H

#include "control/speed_control.h"
#include "manoeuvre/demand.h"

typedef struct {
    speed_control_tuning_t speed;
    float flux_linkage; /* psi_f, for the EMF that control is told of [Wb] */
} run_tuning_t;

typedef struct {
    float flux_linkage; /* of the tuning [Wb] */
    speed_control_t speed;
} run_t;

typedef enum {
    RUN_ZERO, /* no current: the gates are coming on */
    RUN_CURRENT,
    RUN_SPEED
} run_mode_t;

/* What is wished for; the references are within their limits. */
typedef struct {
    run_mode_t mode;
    float omega_m_ref; /* [rad/s] mechanical, with RUN_SPEED */
    dq_t current;      /* [A] with RUN_CURRENT; its d axis with RUN_SPEED too */
} run_wish_t;

/* These coefficients; the speed control at rest. */
void run_init(run_t *run, const run_tuning_t *tuning);

/* New coefficients; the speed control goes on. */
void run_take(run_t *run, const run_tuning_t *tuning);

/* The speed control starts anew without a current. */
void run_reset(run_t *run);

/* References and EMF of this period, at this electrical and mechanical speed [rad/s]. While currents are
 * wished for, the speed control follows them, so that a change of mode does not jump. No division. */
demand_t run_step(run_t *run, const run_wish_t *wish, float omega_e, float omega_m);

#endif
