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
 * manoeuvre is a file of this folder; here stands only when one ends. Rules by which the limits
 * follow from motor and shaft: docs/theory.md, 23.
 *
 * One step per window, in the medium task: what it decides goes into the setpoint, from which
 * fast/reference/reference.h makes the demand of each period. Bounded, no division. */
#ifndef MEDIUM_MANOEUVRE_MANOEUVRES_H
#define MEDIUM_MANOEUVRE_MANOEUVRES_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "estimator/estimate.h"
#include "estimator/position.h"
#include "fast/reference/reference.h"
#include "fast/reference/setpoint.h"
#include "medium/manoeuvre/handover.h"
#include "medium/manoeuvre/lock.h"
#include "medium/manoeuvre/proof.h"
#include "medium/manoeuvre/run.h"
#include "settings/params.h"

/* When the current of a window can be compared with what the winding must do (current_watch.h): where the EMF
 * is small or goes on smoothly. A loop that tracks follows the current sensors, so nothing is compared. */
typedef enum {
    COMPARED_NEVER,
    COMPARED_ALWAYS,
    COMPARED_STANDING, /* while no rotor is seen turning */
    COMPARED_UNTRACKED /* from the second window on, while the loop does not track */
} manoeuvre_compared_t;

/* One row for each manoeuvre: M(NAME, "name", source, compared, step). Append only: the numbers are those of
 * the signal `manoeuvre`, and the names, joined, are its choices.
 *
 *   source    of the frame in which control works. SOURCE_CATCH: nothing is known of the rotor's speed;
 *             SOURCE_FORCED: the frame is that of the forced ramp
 *   compared  manoeuvre_compared_t
 *   step      manoeuvres_STEP() is the manoeuvre: one window, and what follows */
#define MANOEUVRES(M)                                                                                        \
    M(OFF, "off", SOURCE_NONE, COMPARED_NEVER, catch)                                                        \
    M(CATCH, "|catch", SOURCE_CATCH, COMPARED_STANDING, catch)                                               \
    M(ALIGN, "|align", SOURCE_FORCED, COMPARED_ALWAYS, align)                                                \
    M(RAMP, "|ramp", SOURCE_FORCED, COMPARED_UNTRACKED, force)                                               \
    M(HANDOVER, "|handover", SOURCE_FORCED, COMPARED_NEVER, hand_over)                                       \
    M(RUN, "|run", SOURCE_ESTIMATE, COMPARED_NEVER, run)                                                     \
    M(FORCED, "|forced", SOURCE_FORCED, COMPARED_UNTRACKED, force)                                           \
    M(REVERSE, "|reverse", SOURCE_FORCED, COMPARED_UNTRACKED, force)                                         \
    M(RELOCK, "|relock", SOURCE_CATCH, COMPARED_NEVER, catch)

typedef enum {
#define MANOEUVRE_ENUM(NAME, name, source, compared, step) MANOEUVRE_##NAME,
    MANOEUVRES(MANOEUVRE_ENUM)
#undef MANOEUVRE_ENUM
} manoeuvre_t;
#define MANOEUVRE_NAME(NAME, name, source, compared, step) name
#define MANOEUVRE_NAMES                                    MANOEUVRES(MANOEUVRE_NAME)

typedef struct {
    int32_t source;   /* [-] frame_source_t */
    int32_t compared; /* [-] manoeuvre_compared_t */
} manoeuvre_row_t;

/* What a manoeuvre has failed by: bits, conditions of the fault table. */
#define MANOEUVRE_STALLED  UINT32_C(1) /* the rotor does not follow the forced frame */
#define MANOEUVRE_UNLOCKED UINT32_C(2) /* it does, but the estimate did not get hold of it */
#define MANOEUVRE_TOO_FAST UINT32_C(4) /* its EMF is beyond what the DC link holds */
#define MANOEUVRE_LOST     UINT32_C(8) /* lost and caught again too often */

/* A catch takes so long. */
#define MANOEUVRE_CATCH_PERIODS DRIVE_PERIODS(20e-3f)

/* So long nothing is judged after a hand-over: twice the time constant of the signs' low-passes, which begin
 * as locked. */
#define MANOEUVRE_MASKED DRIVE_WINDOWS(10e-3f)

/* And so long nothing is learnt: what a hand-over leaves of error would be taken for the motor's. */
#define MANOEUVRE_STEADY DRIVE_WINDOWS(50e-3f)

/* So long a rotor that was lost, is caught again and turns against the wish keeps its speed: in the reversal
 * that follows nothing is judged where the EMF is small, so that ten means of the signs of a lost lock, the
 * scatter's too, have to be good before it. */
#define MANOEUVRE_PROVING (MANOEUVRE_STEADY + DRIVE_WINDOWS(10e-3f))

/* When one ends. */
typedef struct {
    uint32_t sensorless;       /* [-] 1: the control's angle shall be the estimator's; 0: the encoder's */
    float pole_pairs;          /* p [-] */
    float pole_pairs_inverse;  /* 1/p [-] */
    float handover_speed;      /* [rad/s] electrical */
    float fallback_speed;      /* [rad/s] electrical */
    float flux_linkage;        /* psi_f [Wb] */
    float speed_per_volt;      /* 1/psi_f [rad/s/V] */
    float ramp;                /* of the forced frame a window [rad/s] */
    float ease_share;          /* of the way to its speed, a window [-] */
    float current_start;       /* of the forced frame in a start [A] */
    float current_inverse;     /* 1 over it [1/A] */
    float current_rise;        /* of the forced current a window [A] */
    float current_retry;       /* of a start after one that has failed, at most [A] */
    float current_caught;      /* along the d axis of a rotor that is caught [A] */
    float doubtful;            /* current below which the loss of a leg is in doubt [A]; 0: never */
    float align_speed;         /* of the forced frame in an alignment [rad/s] electrical */
    float swing_square;        /* omega_e^2 per ampere up to which a forced rotor swings [rad^2/s^2/A] */
    uint32_t align_windows;    /* [windows] of it */
    uint32_t fallback_periods; /* [periods] that the EMF may be gone in a reversal */
    uint32_t start_tries;      /* [-] */
    uint32_t smooth;           /* [-] 1: the speed is that without the loop's proportional part */
    uint32_t slow_loop;        /* [-] 1: the tracking loop is too slow for inertia and current limit */
    uint32_t judging;          /* [-] 1: the lock is judged */
    int32_t encoder_fault;     /* [-] encoder_fault_reaction_t: what to do with an encoder that is wrong */
} manoeuvres_limits_t;

typedef struct {
    manoeuvres_limits_t limits;
    handover_tuning_t handover;
    lock_tuning_t lock;
    proof_tuning_t proof;
    run_tuning_t run;
} manoeuvres_tuning_t;

/* Locks that were lost. */
typedef struct {
    uint32_t count;    /* [-] since the bridge came on */
    uint32_t clock[2]; /* [windows] of the last two */
    uint32_t relocks;  /* [-] catches since the last one whose lock was not proved */
} manoeuvres_losses_t;

/* A forced frame. */
typedef struct {
    float wanted;      /* current [A] */
    float needed;      /* of it, as last seen [A] */
    float emf_length;  /* low-passed [V] */
    float quickness;   /* of the ramp in this start [-] */
    float speed;       /* at the end of the next window [rad/s], electrical */
    float current;     /* likewise [A] */
    uint32_t stalling; /* [windows] with less EMF than a rotor that follows has */
} manoeuvres_forced_t;

typedef struct {
    manoeuvres_limits_t limits; /* of the tuning */
    handover_t handover;
    lock_t lock;
    proof_t proof;
    run_t run;

    int32_t now;           /* [-] manoeuvre_t */
    uint32_t sensorless;   /* [-] 1: the control's angle is the estimator's; 0: the encoder's */
    uint32_t encoder_lost; /* [-] 1: it is so because the encoder was wrong; until the bridge goes off */
    uint32_t clock;        /* [windows] */
    uint32_t windows;      /* [windows] in this manoeuvre, or of run since it has passed zero speed */
    uint32_t entered;      /* [windows] number of the setpoint that began the newest catch */
    uint32_t tracking;     /* [-] 1: the loop tracks; 0: the observer alone is stepped */
    uint32_t start_try;    /* [-] number of this start, from 1; 0: none, or done */
    manoeuvres_losses_t losses;
    uint32_t other_source;  /* [-] 1: position_source has changed under way */
    uint32_t reversing;     /* [-] 1: run passes zero speed, where nothing is judged once the EMF is small */
    uint32_t judged;        /* [-] 1: control turns with an estimate that may be judged */
    uint32_t proving;       /* [windows] for which a rotor that was caught again still keeps its speed */
    uint32_t slow_periods;  /* [periods] without an EMF */
    uint32_t sound_windows; /* [windows] since the start succeeded */
    uint32_t unlocked;      /* [-] 1: a sign of a lost lock stands */
    uint32_t failed;        /* [-] MANOEUVRE_... bits that stop the drive */
    float omega_ref;        /* of the last window of run [rad/s], electrical */
    float omega_m_proved;   /* the speed that is kept meanwhile [rad/s], mechanical */
    manoeuvres_forced_t forced;
} manoeuvres_t;

/* What a window brings. */
typedef struct {
    const estimate_t *estimate; /* at its end; its EMF the mean of the window, turned there */
    dq_t current;               /* mean in the estimate's frame [A] */
    ab_t sample;                /* the current at its end [A] */
    float scatter;              /* mean square of the detector [-] */
    uint32_t tracked;           /* [periods] in which the loop tracked */
    position_t encoder;         /* at its end */
    float omega_m;              /* [rad/s] mechanical, of the rotor as it is believed at its end */
    run_wish_t wish;
    uint32_t losses;   /* [-] not 0: the guard says that the lock is lost */
    int32_t outcome;   /* [-] catch_outcome_t of the catch under way */
    uint32_t setpoint; /* [windows] number of the setpoint that was in force */
} manoeuvres_input_t;

/* Coefficients, those that a set leaves at 0 by their rules. For the background. */
manoeuvres_tuning_t manoeuvres_prepare(const params_t *params, const believed_t *believed);
reference_tuning_t reference_prepare(const params_t *params, const believed_t *believed);

/* These coefficients; off. */
void manoeuvres_init(manoeuvres_t *m, const manoeuvres_tuning_t *tuning);

/* New coefficients; what is under way goes on. */
void manoeuvres_take(manoeuvres_t *m, const manoeuvres_tuning_t *tuning);

/* The bridge comes on: catch, or with the encoder run, at this mechanical speed of the encoder [rad/s]. */
void manoeuvres_begin(manoeuvres_t *m, float omega_m, setpoint_t *setpoint);

/* Under way the encoder turns out wrong: without it until the bridge goes off, from where the estimate puts
 * the rotor if its EMF says that it is locked, else caught first. */
void manoeuvres_leave_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);

/* The same, where the fast task has left it by itself. */
void manoeuvres_left_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, bool to_estimate,
                             setpoint_t *setpoint);

/* Is the loop that tracks beside the encoder on the rotor? Its filtered EMF lies on its q axis, in the
 * direction of rotation, and is as long as that of a rotor this fast. */
bool manoeuvres_is_locked(const manoeuvres_t *m, const estimate_t *estimate);

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

/* The row of the present manoeuvre. */
const manoeuvre_row_t *manoeuvres_row(const manoeuvres_t *m);

/* Is the frame that of the forced ramp? */
static inline bool manoeuvres_forces(const manoeuvres_t *m)
{
    return manoeuvres_row(m)->source == (int32_t)SOURCE_FORCED;
}

/* Does the rotor turn so evenly that a ripple of the EMF is not its own? In a forced frame it is a pendulum:
 * near its w_n it answers the sixth harmonic of the currents with a swing. In a catch nobody knows. */
static inline bool manoeuvres_even(const manoeuvres_t *m)
{
    const float omega_e = m->forced.speed;
    return m->now == (int32_t)MANOEUVRE_RUN ||
           (manoeuvres_forces(m) && omega_e * omega_e > m->limits.swing_square * m->forced.current);
}

/* Is anything known of the rotor's speed? Not in a catch. */
static inline bool manoeuvres_knows(const manoeuvres_t *m)
{
    return manoeuvres_row(m)->source != (int32_t)SOURCE_CATCH;
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
    return m->judged != 0u && m->reversing == 0u && m->windows > MANOEUVRE_STEADY;
}

/* May a dither of i_d go beside the reference? Where i_d weakens the field there is no voltage for it. */
static inline bool manoeuvres_dithers(const manoeuvres_t *m)
{
    return manoeuvres_steady(m) && !run_weakens(&m->run);
}

/* `setpoint`: source of the frame, references and orders of the window after the next; m->unlocked and
 * m->failed with it. */
void manoeuvres_step(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);

#endif
