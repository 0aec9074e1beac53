/* Which manoeuvre is under way, and what follows it. Without an encoder:
 *
 *     off --> catch: turning --> run
 *                    standing --> align --> ramp --> handover --> run          (the start)
 *                                       --> forced                 the reference is too slow to track
 *     run --> forced      the reference is below fallback_speed
 *         --> reverse     through zero speed, if that takes longer than the model of the loop can bridge
 *         --> relock      the lock is lost: catch again, at once; the loop that is locked then has no torque
 *                         until several windows of its EMF agree (proof.h), else it is caught once more; a
 *                         rotor that turns against the wish keeps its speed until its lock has been judged
 *     ramp, forced, reverse --> handover --> run                   the reference is above handover_speed
 *     a start that fails --> catch after a pause, with more current and a slower ramp; start_tries of them
 *
 * With the encoder there is nothing but run; if it turns out wrong, what is above goes on from there. Each
 * manoeuvre is a room file of firmware/manoeuvre/; here stands only when one ends. Rules by which the limits
 * follow from motor and shaft: docs/theory.md, 23.
 *
 * One step per T; bounded, no division. */
#ifndef DRIVE_MANOEUVRES_H
#define DRIVE_MANOEUVRES_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "drive/params.h"
#include "estimator/estimate.h"
#include "estimator/position.h"
#include "manoeuvre/catch.h"
#include "manoeuvre/demand.h"
#include "manoeuvre/forced.h"
#include "manoeuvre/handover.h"
#include "manoeuvre/lock.h"
#include "manoeuvre/proof.h"
#include "manoeuvre/run.h"

typedef enum {
    MANOEUVRE_OFF,
    MANOEUVRE_CATCH,
    MANOEUVRE_ALIGN,
    MANOEUVRE_RAMP,
    MANOEUVRE_HANDOVER,
    MANOEUVRE_RUN,
    MANOEUVRE_FORCED,
    MANOEUVRE_REVERSE,
    MANOEUVRE_RELOCK
} manoeuvre_t;
#define MANOEUVRE_NAMES "off|catch|align|ramp|handover|run|forced|reverse|relock"

/* What a manoeuvre has failed by: bits, conditions of the fault table. */
#define MANOEUVRE_STALLED  UINT32_C(1) /* the rotor does not follow the forced frame */
#define MANOEUVRE_UNLOCKED UINT32_C(2) /* it does, but the estimate did not get hold of it */
#define MANOEUVRE_TOO_FAST UINT32_C(4) /* its EMF is beyond what the DC link holds */
#define MANOEUVRE_LOST     UINT32_C(8) /* lost and caught again too often */

/* So long nothing is judged after a hand-over: twice the time constant of the signs' low-passes, which begin
 * as locked. */
#define MANOEUVRE_MASKED_PERIODS DRIVE_PERIODS(10e-3f)

/* And so long nothing is learnt: what a hand-over leaves of error would be taken for the motor's. */
#define MANOEUVRE_STEADY_PERIODS DRIVE_PERIODS(50e-3f)

/* So long a rotor that was lost, is caught again and turns against the wish keeps its speed: in the reversal
 * that follows nothing is judged where the EMF is small, so that ten means of the signs of a lost lock, the
 * scatter's too, have to be good before it. */
#define MANOEUVRE_PROVING_PERIODS (MANOEUVRE_STEADY_PERIODS + DRIVE_PERIODS(10e-3f))

/* When one ends. */
typedef struct {
    uint32_t sensorless;       /* [-] 1: the control's angle shall be the estimator's; 0: the encoder's */
    float pole_pairs;          /* p [-] */
    float pole_pairs_inverse;  /* 1/p [-] */
    float handover_speed;      /* [rad/s] electrical */
    float fallback_speed;      /* [rad/s] electrical */
    float flux_linkage;        /* psi_f [Wb] */
    float speed_per_volt;      /* 1/psi_f [rad/s/V] */
    float ramp;                /* of the forced frame a period [rad/s] */
    float current_rise;        /* of the forced current a period [A] */
    float current_max;         /* longest current vector [A] */
    float doubtful;            /* current below which the loss of a leg is in doubt [A]; 0: never */
    float align_speed;         /* of the forced frame in an alignment [rad/s] electrical */
    float swing_square;        /* omega_e^2 per ampere up to which a forced rotor swings [rad^2/s^2/A] */
    uint32_t align_periods;    /* [periods] of it */
    uint32_t fallback_periods; /* [periods] that the EMF may be gone in a reversal */
    uint32_t start_tries;      /* [-] */
    uint32_t smooth;           /* [-] 1: the speed is that without the loop's proportional part */
    uint32_t slow_loop;        /* [-] 1: the tracking loop is too slow for inertia and current limit */
    uint32_t judging;          /* [-] 1: the lock is judged */
    int32_t encoder_fault;     /* [-] encoder_fault_reaction_t: what to do with an encoder that is wrong */
} manoeuvres_limits_t;

typedef struct {
    manoeuvres_limits_t limits;
    forced_tuning_t forced;
    catch_tuning_t catching;
    handover_tuning_t handover;
    lock_tuning_t lock;
    proof_tuning_t proof;
    run_tuning_t run;
} manoeuvres_tuning_t;

typedef struct {
    manoeuvres_limits_t limits; /* of the tuning */
    forced_t forced;
    catch_t catching;
    handover_t handover;
    lock_t lock;
    proof_t proof;
    run_t run;

    int32_t now;            /* [-] manoeuvre_t */
    uint32_t sensorless;    /* [-] 1: the control's angle is the estimator's; 0: the encoder's */
    uint32_t encoder_lost;  /* [-] 1: it is so because the encoder was wrong; until the bridge goes off */
    uint32_t clock;         /* [periods] */
    uint32_t periods;       /* [periods] in this manoeuvre, or of run since it has passed zero speed */
    uint32_t tracking;      /* [-] 1: the loop tracks; 0: the observer alone is stepped */
    uint32_t start_try;     /* [-] number of this start, from 1; 0: none, or done */
    uint32_t lock_losses;   /* [-] since the bridge came on */
    uint32_t loss_clock[2]; /* [periods] of the last two */
    uint32_t other_source;  /* [-] 1: position_source has changed under way */
    uint32_t reversing;     /* [-] 1: run passes zero speed, where nothing is judged once the EMF is small */
    uint32_t judged;        /* [-] 1: control turns with an estimate that may be judged */
    uint32_t proving;       /* [periods] for which a rotor that was caught again still keeps its speed */
    uint32_t relocks;       /* [-] catches since the lock was lost last whose lock was not proved */
    uint32_t slow_periods;  /* [periods] without an EMF */
    uint32_t stall_periods; /* [periods] with less EMF than a rotor that follows has */
    uint32_t sound_periods; /* [periods] since the start succeeded */
    uint32_t unlocked;      /* [-] 1: a sign of a lost lock stands */
    uint32_t failed;        /* [-] MANOEUVRE_... bits that stop the drive */
    float omega_ref;        /* of the last period of run [rad/s], electrical */
    float omega_m_proved;   /* the speed that is kept meanwhile [rad/s], mechanical */
    float current;          /* of the forced frame, wanted [A] */
    float needed;           /* of it, as last seen [A] */
    float length;           /* of the EMF in a forced frame, low-passed [V] */
    float quickness;        /* of the ramp in this start [-] */

    uint32_t locking;  /* [-] 1: the loop shall be locked at `locked` in this period */
    position_t locked; /* [rad], [rad/s] at t_k */
    float locked_emf;  /* mean length of its EMF [V] */
} manoeuvres_t;

/* What a period brings. */
typedef struct {
    ab_t current;               /* [A] at t_k */
    float voltage_max;          /* [V] what the link gives in every direction */
    const estimate_t *estimate; /* at t_k */
    const frame_t *encoder;     /* at t_k */
    float omega_m;              /* [rad/s] mechanical, of the rotor as it is believed */
    run_wish_t wish;
    uint32_t estimating; /* [-] 1: the observer runs: its EMF is that of t_k */
    uint32_t losses;     /* [-] not 0: the guard says that the lock is lost */
} manoeuvres_input_t;

/* Coefficients, those that a set leaves at 0 by their rules. For the background. */
manoeuvres_tuning_t manoeuvres_prepare(const params_t *params, const believed_t *believed);

/* These coefficients; off. */
void manoeuvres_init(manoeuvres_t *m, const manoeuvres_tuning_t *tuning);

/* New coefficients; what is under way goes on. */
void manoeuvres_take(manoeuvres_t *m, const manoeuvres_tuning_t *tuning);

/* The bridge comes on: catch, or with the encoder run, at this mechanical speed of the encoder [rad/s]. */
void manoeuvres_begin(manoeuvres_t *m, float omega_m);

/* Under way the encoder turns out wrong: without it until the bridge goes off, from where the estimate puts
 * the rotor if its EMF says that it is locked, else caught first. `current` [A] at t_k. */
void manoeuvres_leave_encoder(manoeuvres_t *m, const estimate_t *estimate, ab_t current);

/* The bridge is off. */
static inline void manoeuvres_end(manoeuvres_t *m)
{
    m->sensorless = m->limits.sensorless;
    m->encoder_lost = 0u;
    m->now = (int32_t)MANOEUVRE_OFF;
    m->judged = 0u;
    m->failed = 0u;
    m->unlocked = 0u;
}

/* Is the frame that of the forced ramp? */
static inline bool manoeuvres_forces(const manoeuvres_t *m)
{
    return m->now == (int32_t)MANOEUVRE_ALIGN || m->now == (int32_t)MANOEUVRE_RAMP ||
           m->now == (int32_t)MANOEUVRE_HANDOVER || m->now == (int32_t)MANOEUVRE_FORCED ||
           m->now == (int32_t)MANOEUVRE_REVERSE;
}

/* Before the estimator's step: a forced frame to t_k. */
static inline void manoeuvres_advance(manoeuvres_t *m)
{
    if (manoeuvres_forces(m)) {
        forced_advance(&m->forced);
    }
}

/* The speed at which the observer is stepped while the loop does not track [rad/s]. */
static inline float manoeuvres_speed(const manoeuvres_t *m)
{
    return manoeuvres_forces(m) ? m->forced.frame.omega_e : m->catching.omega_e;
}

/* Of the stator, where nothing is known of the rotor. */
static inline frame_t manoeuvres_stationary(void)
{
    return (frame_t){0.0f, 0.0f, {0.0f, 1.0f}};
}

/* The rotor as the drive believes it to be at t_k: of the encoder, of the estimate while it tracks, else of
 * the frame. */
static inline frame_t manoeuvres_rotor(const manoeuvres_t *m, const frame_t *encoder,
                                       const estimate_t *estimate)
{
    if (m->sensorless == 0u) {
        return *encoder;
    }
    if (m->now == (int32_t)MANOEUVRE_OFF) {
        return manoeuvres_stationary();
    }
    if (m->tracking != 0u) {
        return estimate->frame;
    }
    return manoeuvres_forces(m) ? m->forced.frame
                                : (frame_t){0.0f, m->catching.omega_e, manoeuvres_stationary().rotation};
}

/* Its electrical speed [rad/s], for what must not be noisy: of the estimate without the loop's proportional
 * part, whose noise would come back through the speed control; or whole, where that is wished for. */
static inline float manoeuvres_smooth(const manoeuvres_t *m, const frame_t *rotor, const estimate_t *estimate)
{
    const bool tracked = m->sensorless != 0u && m->limits.smooth != 0u && m->tracking != 0u &&
                         m->now != (int32_t)MANOEUVRE_OFF;
    return tracked ? estimate->omega_smooth : rotor->omega_e;
}

/* Does the rotor turn so evenly that a ripple of the EMF is not its own? In a forced frame it is a pendulum:
 * near its w_n it answers the sixth harmonic of the currents with a swing. In a catch nobody knows. */
static inline bool manoeuvres_even(const manoeuvres_t *m)
{
    const float omega_e = m->forced.frame.omega_e;
    return m->now == (int32_t)MANOEUVRE_RUN ||
           (manoeuvres_forces(m) && omega_e * omega_e > m->limits.swing_square * m->forced.current);
}

/* Is anything known of the rotor's speed? Not in a catch. */
static inline bool manoeuvres_knows(const manoeuvres_t *m)
{
    return m->now != (int32_t)MANOEUVRE_CATCH && m->now != (int32_t)MANOEUVRE_RELOCK;
}

/* Does control turn with an estimate that may be judged? Not in a reversal once the EMF is less than at
 * handover_speed, nor shortly after a hand-over. */
static inline bool manoeuvres_judged(const manoeuvres_t *m)
{
    return m->judged != 0u;
}

/* May anything be learnt of the rotor? Only of one that is judged, not while it is being reversed,
 * and not for a while after a hand-over. */
static inline bool manoeuvres_steady(const manoeuvres_t *m)
{
    return m->judged != 0u && m->reversing == 0u && m->periods > MANOEUVRE_STEADY_PERIODS;
}

/* `demand`: what is asked of control in this period; m->locking, m->unlocked and m->failed with it. */
void manoeuvres_step(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);

#endif
