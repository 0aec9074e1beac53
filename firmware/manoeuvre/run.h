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
 * (docs/theory.md, 30).
 *
 * One step per window. Does not handle: starting, standing without an encoder, a lost rotor. */
#ifndef MANOEUVRE_RUN_H
#define MANOEUVRE_RUN_H

#include <stdbool.h>
#include <stdint.h>

#include "control/speed_control.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/frames.h"
#include "math/root.h"

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
    float lower;        /* of i_q [A]: what heat and DC link leave of the limit */
    float upper;        /* upper limit of i_q [A], not below `lower` */
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

/* psi_a/psi_f at the i_d of the last step [-]: torque per i_q. */
static inline float run_torque(const run_t *run)
{
    const float torque = 1.0f - run->tuning.saliency * run->i_d;
    return torque > RUN_TORQUE_LEAST ? torque : RUN_TORQUE_LEAST;
}

/* Size of the i_d of most torque per ampere beside this i_q [A]: 2 D i_q^2/(psi_f + sqrt(psi_f^2 + 4 D^2
 * i_q^2)).
 */
static inline float run_mtpa(const run_t *run, float i_q)
{
    const float lean = 2.0f * run->tuning.saliency * i_q;
    const float square = 1.0f + lean * lean;
    return lean * i_q / (1.0f + square * inverse_root(square));
}

/* i_d of a salient rotor [A]. It follows i_q in some steps, for i_q follows it. */
static inline float run_i_d_salient(run_t *run, float i_q, float low)
{
    const run_tuning_t *tuning = &run->tuning;
    const float wanted = tuning->mtpa != 0u ? run_mtpa(run, i_q) : 0.0f;
    run->i_d_mtpa = lowpass_step(run->i_d_mtpa, RUN_MTPA_SHARE, wanted);
    run->i_d_low = lowpass_step(run->i_d_low, tuning->low_share, low);
    return run->i_d_left - (run->i_d_low > run->i_d_mtpa ? run->i_d_low : run->i_d_mtpa);
}

/* i_d that is not wished for [A] beside the last i_q [A]. */
static inline float run_i_d(run_t *run, float i_q, float omega_e)
{
    const run_tuning_t *tuning = &run->tuning;
    const float slower = 1.2f - bounds_magnitude(omega_e) * tuning->low_inverse;
    const float kept = slower < 1.0f ? (slower > 0.2f ? slower : 0.2f) : 1.0f;
    const float short_of = kept * run->low_kept * tuning->low_current - bounds_magnitude(i_q);
    const float low = short_of > 0.0f ? short_of : 0.0f;
    const float left = tuning->fade * run->i_d_left;
    run->i_d_left = bounds_within(left, RUN_NOTHING) ? 0.0f : left;
    if (tuning->saliency > 0.0f) {
        return run_i_d_salient(run, i_q, low);
    }
    run->i_d_low = lowpass_step(run->i_d_low, tuning->low_share, low);
    return run->i_d_left > run->i_d_low ? run->i_d_left : run->i_d_low;
}

/* `i_q` [A] within its limits. */
static inline float run_within(const run_t *run, float i_q)
{
    const float below = i_q < run->upper ? i_q : run->upper;
    return below > run->lower ? below : run->lower;
}

/* What the longest vector leaves for i_q beside what fades of i_d, of a salient rotor all of it [A]; heat and
 * DC link apart. */
static inline float run_room(const run_t *run)
{
    const float limit = run->speed.current_limit;
    const float i_d = run->tuning.saliency > 0.0f ? run->i_d : run->i_d_left;
    const float square = limit * limit - i_d * i_d;
    if (i_d == 0.0f) {
        return limit;
    }
    return square > 0.0f ? square * inverse_root(square) : 0.0f;
}

/* i_q of the speed control [A] at this mechanical speed [rad/s]: within its limits, and that room. */
static inline float run_i_q(run_t *run, float omega_m)
{
    const float room = run_room(run);
    const float lower = bounds_clamp(run->lower, room);
    const float upper = bounds_clamp(run->upper, room);
    if (run->tuning.saliency > 0.0f) {
        const float torque = run_torque(run);
        const float share = 1.0f / torque;
        run->i_q_standing = share * speed_control_standing(&run->speed, run->omega_m_ref);
        run->stiffness = share * run->speed.pi.tuning.kp;
        return share *
               speed_control_step(&run->speed, run->omega_m_ref, omega_m, torque * lower, torque * upper);
    }
    run->i_q_standing = speed_control_standing(&run->speed, run->omega_m_ref);
    run->stiffness = run->speed.pi.tuning.kp;
    return speed_control_step(&run->speed, run->omega_m_ref, omega_m, lower, upper);
}

/* Current [A] and speed reference [rad/s] of this step in the rotor's frame, at this electrical and
 * mechanical speed [rad/s]. While currents are wished for, the speed control follows them, so that a change
 * of mode does not jump. A division where the rotor is salient. */
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
        run->i_d = current->d;
        speed_control_reset(&run->speed, run_torque(run) * current->q, omega_m);
        *omega_m_ref = omega_m;
        break;
    case RUN_SPEED:
    case RUN_STOP:
        run->omega_m_ref = wish->mode == RUN_SPEED ? run_reference(run, wish->omega_m_ref, run->tuning.ramp)
                                                   : run_reference(run, 0.0f, run->tuning.stop_ramp);
        current->q = run_i_q(run, omega_m);
        run->i_d = run_i_d(run, current->q, omega_e);
        current->d = wish->current.d + run->i_d;
        *omega_m_ref = run->omega_m_ref;
        break;
    }
}

#endif
