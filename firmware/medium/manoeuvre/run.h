/* Run: the motor follows its speed or current references in the frame of the rotor.
 *
 *     speed reference   moves to the requested speed by `ramp`, or by `stop_ramp` in a quick stop
 *     i_q               from the speed control, or the requested one, within run_limit(); in the periods
 *                       until the next step: i_q_standing - stiffness omega_m
 *     i_d               the requested one, and the larger of two: the remaining one of a hand-over, fading;
 *                       the one that keeps i_d + |i_q| at `low_current` at low speed, where the loss of a
 *                       leg without current is an unknown voltage (docs/theory.md, 23)
 *
 * For a salient rotor, D = L_q - L_d above 0, i_d is negative. This increases the active flux psi_a = psi_f -
 * D i_d, and with it EMF and torque. i_d is that of most torque per ampere, or that of the low speed if this
 * is larger. The output of the speed control is the torque as a current with psi_f; i_q is this current times
 * psi_f/psi_a (docs/theory.md, 30). If the q axis saturates, D follows from the i_q of the last step: psi_a
 * and the ellipse use the apparent L_q, and the i_d of most torque per ampere uses both L_q. At the voltage
 * limit i_d is as negative as the torque needs, for any rotor, and the torque is limited (weakening.h).
 *
 * One step per window, after run_look(). Does not handle: the start, standstill
 * without an encoder, a lost rotor. */
#ifndef MEDIUM_MANOEUVRE_RUN_H
#define MEDIUM_MANOEUVRE_RUN_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/saturation.h"
#include "math/bounds.h"
#include "math/frames.h"
#include "medium/manoeuvre/speed_control.h"
#include "medium/manoeuvre/weakening.h"

/* A fading current below this counts as zero [A]. */
#define RUN_NOTHING 1e-3f

/* Least psi_a/psi_f [-]; share by which the i_d of most torque per ampere approaches the value for i_q in a
 * step [-]: i_q depends on its inverse, and would oscillate with the full step. */
#define RUN_TORQUE_LEAST 0.1f
#define RUN_MTPA_SHARE   0.5f

#define RUN_RELAX                                                                                            \
    0.995f /* [-] per step, of an increased bandwidth of the speed control: 0.3 s from 7 to 1                \
            */

typedef struct {
    speed_control_tuning_t speed;
    float ramp;        /* change of the speed reference per step [rad/s], mechanical; 0: no limit */
    float stop_ramp;   /* the same in a quick stop */
    float low_current; /* least i_d + |i_q| at low speed, where it is kept [A]; 0: no i_d for that */
    float low_inverse; /* 1/speed [s/rad], electrical, at which a fifth of it remains; whole below speed/5 */
    float low_share;   /* low-pass of that i_d, because i_q is noisy [-] */
    float fade;        /* share of a hand-over's i_d that remains one step later [-] */
    float saliency;    /* D/psi_f of a salient rotor [1/A]; 0: a round one, or nearly */
    saturation_t saturation; /* of the q axis; changes the L_q of `saliency` */
    uint32_t mtpa;           /* [-] 1: i_d of a salient rotor for most torque per ampere */
    float per_torque;        /* current of psi_f that makes a torque, 1/(1.5 p psi_f) [A/(N m)] */
    float slew;              /* by which a torque may grow per step, as a current of psi_f [A]; 0: no limit */
    weakening_tuning_t weakening;
} run_tuning_t;

typedef struct {
    run_tuning_t tuning;
    speed_control_t speed;
    float omega_m_ref;  /* present reference [rad/s], mechanical */
    float calm;         /* factor on the bandwidth of the speed control [-]; 1: as configured */
    uint32_t swings;    /* [-] 1: it made the shaft swing, or the rotor was lost: the speed must not lag */
    float stiff;        /* another one [-], above 1 while the load changes from the brake to the motor */
    float low_kept;     /* [-] 1: low_current is kept; 0: not needed with an encoder */
    float i_d_left;     /* remaining i_d of a hand-over [A] */
    float i_d_low;      /* for the low-speed current, magnitude [A] */
    float i_d_mtpa;     /* for most torque per ampere, magnitude [A] */
    float i_d;          /* of the last step, without the requested i_d [A] */
    float apart;        /* D/psi_f at the i_q of the last step [1/A], with the apparent L_q */
    float steep;        /* the same with the incremental L_q [1/A] */
    float torque;       /* of the last step, as a current of psi_f [A] */
    uint32_t limited;   /* [-] 1: it is at one of its limits */
    float lower;        /* lower limit of i_q [A] by heat and DC link */
    float upper;        /* upper limit of i_q [A], not below `lower` */
    float i_q_standing; /* i_q at speed zero, not limited [A] */
    float stiffness;    /* decrease of i_q with the speed [A s/rad], mechanical */
    weakening_t weakening;
} run_t;

typedef enum {
    RUN_ZERO, /* no current: the gates are being switched on */
    RUN_CURRENT,
    RUN_SPEED,
    RUN_TORQUE,
    RUN_STOP /* a quick stop: speed zero by its own ramp */
} run_mode_t;

/* The request; the references are within their limits. */
typedef struct {
    run_mode_t mode;
    float omega_m_ref; /* [rad/s] mechanical, with RUN_SPEED */
    dq_t current;      /* [A] with RUN_CURRENT; its d axis in all modes but RUN_ZERO too */
    float torque;      /* [N m] with RUN_TORQUE */
} run_wish_t;

/* Takes these coefficients; the speed control is at rest. */
void run_init(run_t *run, const run_tuning_t *tuning);

/* Selects whether the low-speed current is kept. */
static inline void run_keep_low(run_t *run, bool keep)
{
    run->low_kept = keep ? 1.0f : 0.0f;
}

/* i_q stays from `lower` to `upper` [A] from the next step on, both within +-current_limit, lower <= upper;
 * the limits also hold for a requested i_q. */
static inline void run_limit(run_t *run, float lower, float upper)
{
    run->lower = lower;
    run->upper = upper;
}

/* Takes over new coefficients; the speed control continues, without a jump while the speed is at its
 * reference. i_q has the whole limit, until run_limit(). */
static inline void run_take(run_t *run, const run_tuning_t *tuning)
{
    run->tuning = *tuning;
    run->apart = tuning->saliency;
    run->steep = tuning->saliency;
    weakening_take(&run->weakening, &tuning->weakening);
    run_limit(run, -tuning->speed.current_limit, tuning->speed.current_limit);
    const speed_control_tuning_t speed = speed_control_scaled(&tuning->speed, run->calm * run->stiff);
    speed_control_take(&run->speed, &speed, run->omega_m_ref);
}

/* Halves the bandwidth of the speed control, but not below a quarter of the configured one; or, with `whole`,
 * restores the configured one. Its next output for zero error is kept. */
void run_calm(run_t *run, bool whole);

/* Sets the factor [-] by which the bandwidth of the speed control is higher while it takes over a load. Its
 * next output for zero error is kept. With a factor of 1 the bandwidth returns gradually, by RUN_RELAX at
 * each call. After a step of the gains the slower control would need a long time to remove the difference of
 * i_q from the load.
 */
void run_stiffen(run_t *run, float factor);

/* The speed control continues from this current [A] in the rotor's frame at this mechanical speed
 * [rad/s]: its i_q is held, its i_d fades except for the part that the low speed needs, the
 * reference starts from the speed. */
void run_enter(run_t *run, dq_t current, float omega_m);

/* The next speed reference of the ramp to the requested one [rad/s]. */
static inline float run_reference(const run_t *run, float wanted, float ramp)
{
    return ramp > 0.0f ? run->omega_m_ref + bounds_clamp(wanted - run->omega_m_ref, ramp) : wanted;
}

/* psi_a/psi_f at the i_d of the last step [-]: factor of the torque per i_q. */
static inline float run_torque(const run_t *run)
{
    const float torque = 1.0f - run->apart * run->i_d;
    return torque > RUN_TORQUE_LEAST ? torque : RUN_TORQUE_LEAST;
}

/* The torque limits at this DC link [V] and electrical speed [rad/s], with the voltage that current control
 * requests [V]. A division where the voltage may limit more than the current does. */
static inline void run_look(run_t *run, float u_dc, float omega_e, dq_t voltage)
{
    weakening_look(&run->weakening, u_dc, omega_e, voltage);
}

/* True if i_d weakens the field. */
static inline bool run_weakens(const run_t *run)
{
    return run->weakening.weakens != 0u;
}

/* L_q at this i_q [A] less the assumed one [H]; 0 without saturation. */
static inline float run_excess(const run_t *run, float i_q)
{
    const saturation_t *saturation = &run->tuning.saturation;
    return saturation_is_on(saturation) ? saturation_at(saturation, i_q).excess : 0.0f;
}

/* The largest i_q [A] that the longest current vector permits together with the fading i_d, or, for a salient
 * rotor or a weakened field, together with the whole i_d; without the limits of heat and DC link. */
float run_room(const run_t *run);

/* Current [A] and speed reference [rad/s] of this step in the rotor's frame, at this electrical
 * and mechanical speed [rad/s]. While currents or a torque are requested, the speed control
 * follows them, so that a change of mode causes no jump. A division where the rotor is salient,
 * another one where the voltage may limit. */
void run_step(run_t *run, const run_wish_t *wish, float omega_e, float omega_m, dq_t *current,
              float *omega_m_ref);

#endif
