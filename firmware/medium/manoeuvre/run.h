/* Running: the motor follows its speed or current references in the frame of the rotor.
 *
 *     speed reference   to what is wished for by `ramp`, or `stop_ramp` in a quick stop
 *     i_q               from the speed control, or what is wished for, within run_limit(); for the periods
 *                       until the next step: i_q_standing - stiffness omega_m
 *     i_d               what is wished for, and the larger of two: what a hand-over has left, fading;
 *                       what keeps i_d + |i_q| at `low_current` at low speed, where the loss of a leg
 *                       without current is a voltage that nobody knows (docs/theory.md, 23)
 *
 * A salient rotor, D = L_q - L_d above 0, has i_d below zero, where the active flux psi_a = psi_f - D i_d and
 * with it EMF and torque grow: the i_d of most torque per ampere, or that of the low speed if that is more.
 * The speed control then gives the current of psi_f that would make the torque, and i_q is psi_f/psi_a of it
 * (docs/theory.md, 30). Where the voltage ends, i_d goes as far below zero as the torque needs, of any rotor,
 * and the torque ends where there is no more of it (weakening.h).
 *
 * One step per window, after run_look(). Does not handle: starting, standing without an encoder, a lost
 * rotor. */
#ifndef MEDIUM_MANOEUVRE_RUN_H
#define MEDIUM_MANOEUVRE_RUN_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "medium/manoeuvre/speed_control.h"
#include "medium/manoeuvre/weakening.h"

/* What is less than this of a fading current is none [A]. */
#define RUN_NOTHING 1e-3f

/* Least psi_a/psi_f [-], and how the i_d of most torque per ampere goes to what i_q makes of it, a step [-]:
 * i_q goes with its inverse, and would swing with the whole of it. */
#define RUN_TORQUE_LEAST 0.1f
#define RUN_MTPA_SHARE   0.5f

typedef struct {
    speed_control_tuning_t speed;
    float ramp;        /* of the speed reference a step [rad/s], mechanical; 0: at once */
    float stop_ramp;   /* the same in a quick stop */
    float low_current; /* i_d + |i_q| at low speed, at least, where that is kept [A]; 0: no i_d for that */
    float low_inverse; /* 1/the electrical speed [s/rad] from which on a fifth of it is left; up to a fifth of
                          that speed it is kept whole */
    float low_share;   /* low-pass of that i_d, for i_q is noisy [-] */
    float fade;        /* share of a hand-over's i_d that is left a step later [-] */
    float saliency;    /* D/psi_f of a salient rotor [1/A]; 0: a round one, or nearly */
    uint32_t mtpa;     /* [-] 1: i_d of a salient rotor for most torque per ampere */
    float per_torque;  /* current of psi_f that makes a torque, 1/(1.5 p psi_f) [A/(N m)] */
    float slew;        /* by which a torque may grow a step, as a current of psi_f [A]; 0: at once */
    weakening_tuning_t weakening;
} run_tuning_t;

typedef struct {
    run_tuning_t tuning;
    speed_control_t speed;
    float omega_m_ref;  /* reference in force [rad/s], mechanical */
    float calm;         /* factor on the bandwidth of the speed control [-]; 1: as the set says */
    float low_kept;     /* [-] 1: low_current is kept; 0: who has an encoder needs none */
    float i_d_left;     /* of a hand-over [A] */
    float i_d_low;      /* for the low-speed current, its size [A] */
    float i_d_mtpa;     /* for most torque per ampere, its size [A] */
    float i_d;          /* of the last step, but for what is wished for [A] */
    float torque;       /* of the last step, as a current of psi_f [A] */
    float lower;        /* of i_q [A]: what heat and DC link leave of the limit */
    float upper;        /* upper limit of i_q [A], not below `lower` */
    float i_q_standing; /* i_q at speed zero, not limited [A] */
    float stiffness;    /* by which it falls with the speed [A s/rad], mechanical */
    weakening_t weakening;
} run_t;

typedef enum {
    RUN_ZERO, /* no current: the gates are coming on */
    RUN_CURRENT,
    RUN_SPEED,
    RUN_TORQUE,
    RUN_STOP /* a quick stop: speed zero by its own ramp */
} run_mode_t;

/* What is wished for; the references are within their limits. */
typedef struct {
    run_mode_t mode;
    float omega_m_ref; /* [rad/s] mechanical, with RUN_SPEED */
    dq_t current;      /* [A] with RUN_CURRENT; its d axis in all but RUN_ZERO too */
    float torque;      /* [N m] with RUN_TORQUE */
} run_wish_t;

/* These coefficients; the speed control at rest. */
void run_init(run_t *run, const run_tuning_t *tuning);

/* Whether the low-speed current is kept. */
static inline void run_keep_low(run_t *run, bool keep)
{
    run->low_kept = keep ? 1.0f : 0.0f;
}

/* i_q stays from `lower` to `upper` [A] from the next step on, both within +-current_limit, lower <= upper;
 * also what is wished for. */
static inline void run_limit(run_t *run, float lower, float upper)
{
    run->lower = lower;
    run->upper = upper;
}

/* New coefficients; the speed control goes on, without a jump while the speed is at its reference. i_q has
 * the whole limit, until run_limit(). */
static inline void run_take(run_t *run, const run_tuning_t *tuning)
{
    run->tuning = *tuning;
    weakening_take(&run->weakening, &tuning->weakening);
    run_limit(run, -tuning->speed.current_limit, tuning->speed.current_limit);
    const speed_control_tuning_t speed = speed_control_slower(&tuning->speed, run->calm);
    speed_control_take(&run->speed, &speed, run->omega_m_ref);
}

/* The speed control half as quick as it is, but not below a quarter of what the set says; or, with `whole`,
 * as the set says again. Its next output for zero error stays. */
void run_calm(run_t *run, bool whole);

/* The speed control goes on from this current [A] in the rotor's frame at this mechanical speed [rad/s]: its
 * i_q is held, its i_d fades but for what the low speed needs of it, the reference starts from the speed. */
void run_enter(run_t *run, dq_t current, float omega_m);

/* The speed reference on its way to what is wished for [rad/s]. */
static inline float run_reference(const run_t *run, float wanted, float ramp)
{
    return ramp > 0.0f ? run->omega_m_ref + bounds_clamp(wanted - run->omega_m_ref, ramp) : wanted;
}

/* psi_a/psi_f at the i_d of the last step [-]: torque per i_q. */
static inline float run_torque(const run_t *run)
{
    const float torque = 1.0f - run->tuning.saliency * run->i_d;
    return torque > RUN_TORQUE_LEAST ? torque : RUN_TORQUE_LEAST;
}

/* What DC link [V] and speed [rad/s], electrical, leave of the torque, with the voltage that current control
 * asks for [V]. A division where that may be less than the current does. */
static inline void run_look(run_t *run, float u_dc, float omega_e, dq_t voltage)
{
    weakening_look(&run->weakening, u_dc, omega_e, voltage);
}

/* Does i_d weaken the field? */
static inline bool run_weakens(const run_t *run)
{
    return run->weakening.weakens != 0u;
}

/* What the longest vector leaves for i_q beside what fades of i_d, of a salient rotor or a weakened field
 * beside all of i_d [A]; heat and DC link apart. */
float run_room(const run_t *run);

/* Current [A] and speed reference [rad/s] of this step in the rotor's frame, at this electrical and
 * mechanical speed [rad/s]. While currents or a torque are wished for, the speed control follows them, so
 * that a change of mode does not jump. A division where the rotor is salient, another one where the voltage
 * may limit. */
void run_step(run_t *run, const run_wish_t *wish, float omega_e, float omega_m, dq_t *current,
              float *omega_m_ref);

#endif
