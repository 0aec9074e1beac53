/* Running: the motor follows its speed or current references in the frame of the rotor.
 *
 *     speed reference   to what is wished for by `ramp`, or `stop_ramp` in a quick stop
 *     i_q               from the speed control, or what is wished for, within run_limit(); for the periods
 *                       until the next step: i_q_standing - stiffness omega_m
 *     i_d               what is wished for, and the larger of two: what a hand-over has left, fading;
 *                       what keeps i_d + |i_q| at `low_current` at low speed, where the loss of a leg
 *                       without current is a voltage that nobody knows (docs/theory.md, 23)
 *
 * One step per window. Does not handle: starting, standing without an encoder, a lost rotor. */
#ifndef MANOEUVRE_RUN_H
#define MANOEUVRE_RUN_H

#include <stdbool.h>

#include "control/speed_control.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "math/root.h"

/* What is less than this of a fading current is none [A]. */
#define RUN_NOTHING 1e-3f

typedef struct {
    speed_control_tuning_t speed;
    float ramp;        /* of the speed reference a step [rad/s], mechanical; 0: at once */
    float stop_ramp;   /* likewise, in a quick stop */
    float low_current; /* i_d + |i_q| at low speed, at least, where that is kept [A]; 0: no i_d for that */
    float low_inverse; /* 1/the electrical speed [s/rad] from which on a fifth of it is left; up to a fifth of
                          that speed it is kept whole */
    float low_share;   /* low-pass of that i_d, for i_q is noisy [-] */
    float fade;        /* share of a hand-over's i_d that is left a step later [-] */
} run_tuning_t;

typedef struct {
    run_tuning_t tuning;
    speed_control_t speed;
    float omega_m_ref;  /* reference in force [rad/s], mechanical */
    float calm;         /* factor on the bandwidth of the speed control [-]; 1: as the set says */
    float low_kept;     /* [-] 1: low_current is kept; 0: who has an encoder needs none */
    float i_d_left;     /* of a hand-over [A] */
    float i_d_low;      /* for the low-speed current [A] */
    float lower;        /* of i_q [A]: what heat and DC link leave of the limit */
    float upper;        /* likewise, not below `lower` */
    float i_q_standing; /* i_q at speed zero, not limited [A] */
    float stiffness;    /* by which it falls with the speed [A s/rad], mechanical */
} run_t;

typedef enum {
    RUN_ZERO, /* no current: the gates are coming on */
    RUN_CURRENT,
    RUN_SPEED,
    RUN_STOP /* a quick stop: speed zero by its own ramp */
} run_mode_t;

/* What is wished for; the references are within their limits. */
typedef struct {
    run_mode_t mode;
    float omega_m_ref; /* [rad/s] mechanical, with RUN_SPEED */
    dq_t current;      /* [A] with RUN_CURRENT; its d axis with RUN_SPEED and RUN_STOP too */
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

/* i_d that is not wished for [A] beside the last i_q [A]. */
static inline float run_i_d(run_t *run, float i_q, float omega_e)
{
    const run_tuning_t *tuning = &run->tuning;
    const float slower = 1.2f - bounds_magnitude(omega_e) * tuning->low_inverse;
    const float kept = slower < 1.0f ? (slower > 0.2f ? slower : 0.2f) : 1.0f;
    const float short_of = kept * run->low_kept * tuning->low_current - bounds_magnitude(i_q);
    run->i_d_low = lowpass_step(run->i_d_low, tuning->low_share, short_of > 0.0f ? short_of : 0.0f);
    const float left = tuning->fade * run->i_d_left;
    run->i_d_left = bounds_within(left, RUN_NOTHING) ? 0.0f : left;
    return run->i_d_left > run->i_d_low ? run->i_d_left : run->i_d_low;
}

/* `i_q` [A] within its limits. */
static inline float run_within(const run_t *run, float i_q)
{
    const float below = i_q < run->upper ? i_q : run->upper;
    return below > run->lower ? below : run->lower;
}

/* What the longest vector leaves for i_q beside what fades of i_d [A], heat and DC link apart. */
static inline float run_room(const run_t *run)
{
    const float limit = run->speed.current_limit;
    const float square = limit * limit - run->i_d_left * run->i_d_left;
    if (run->i_d_left == 0.0f) {
        return limit;
    }
    return square > 0.0f ? square * inverse_root(square) : 0.0f;
}

/* i_q of the speed control [A] at this mechanical speed [rad/s]: within its limits, and that room. */
static inline float run_i_q(run_t *run, float omega_m)
{
    const bool fades = run->i_d_left != 0.0f;
    const float room = run_room(run);
    const float lower = fades ? bounds_clamp(run->lower, room) : run->lower;
    const float upper = fades ? bounds_clamp(run->upper, room) : run->upper;
    run->i_q_standing = speed_control_standing(&run->speed, run->omega_m_ref);
    run->stiffness = run->speed.pi.tuning.kp;
    return speed_control_step(&run->speed, run->omega_m_ref, omega_m, lower, upper);
}

/* Current [A] and speed reference [rad/s] of this step in the rotor's frame, at this electrical and
 * mechanical speed [rad/s]. While currents are wished for, the speed control follows them, so that a change
 * of mode does not jump. No division. */
static inline void run_step(run_t *run, const run_wish_t *wish, float omega_e, float omega_m, dq_t *current,
                            float *omega_m_ref)
{
    switch (wish->mode) {
    case RUN_ZERO:
        run->omega_m_ref = omega_m;
        *current = (dq_t){0.0f, 0.0f};
        run->i_q_standing = 0.0f;
        run->stiffness = 0.0f;
        *omega_m_ref = 0.0f;
        break;
    case RUN_CURRENT:
        run->omega_m_ref = omega_m;
        *current = (dq_t){wish->current.d, run_within(run, wish->current.q)};
        run->i_q_standing = current->q;
        run->stiffness = 0.0f;
        speed_control_reset(&run->speed, current->q, omega_m);
        *omega_m_ref = omega_m;
        break;
    case RUN_SPEED:
    case RUN_STOP:
        run->omega_m_ref = wish->mode == RUN_SPEED ? run_reference(run, wish->omega_m_ref, run->tuning.ramp)
                                                   : run_reference(run, 0.0f, run->tuning.stop_ramp);
        current->q = run_i_q(run, omega_m);
        current->d = wish->current.d + run_i_d(run, current->q, omega_e);
        *omega_m_ref = run->omega_m_ref;
        break;
    }
}

#endif
