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
static inline void run_take(run_t *run, const run_tuning_t *tuning)
{
    run->flux_linkage = tuning->flux_linkage;
    speed_control_take(&run->speed, &tuning->speed);
}

/* The speed control starts anew without a current. */
void run_reset(run_t *run);

/* References and EMF of this period, at this electrical and mechanical speed [rad/s]. While currents are
 * wished for, the speed control follows them, so that a change of mode does not jump. No division. */
static inline demand_t run_step(run_t *run, const run_wish_t *wish, float omega_e, float omega_m)
{
    demand_t demand = {{0.0f, 0.0f}, {0.0f, omega_e * run->flux_linkage}, 0.0f};
    switch (wish->mode) {
    case RUN_ZERO:
        break;
    case RUN_CURRENT:
        speed_control_reset(&run->speed, wish->current.q);
        demand.current = wish->current;
        demand.omega_m_ref = omega_m;
        break;
    case RUN_SPEED:
        demand.current.d = wish->current.d;
        demand.current.q = speed_control_step(&run->speed, wish->omega_m_ref, omega_m);
        demand.omega_m_ref = wish->omega_m_ref;
        break;
    }
    return demand;
}

#endif
