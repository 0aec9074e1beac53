/* The manoeuvre that is active, and the one that follows. Without an encoder:
 *
 *     off --> catch: turning --> run                                             a slow rotor is proved first
 *                    standing --> align --> ramp --> handover --> run          (the start)
 *                                       --> forced                 the reference is too slow to track
 *     run --> forced      the reference is below fallback_speed
 *         --> reverse     through zero speed, if that takes longer than the model of the loop can bridge
 *         --> relock      the lock is lost: catch again at once; the loop that is locked then has no torque
 *                         until several windows of its EMF agree (proof.h), otherwise it is caught again; a
 *                         rotor that turns against the reference keeps its speed until its lock is judged
 *     ramp, forced, reverse --> handover --> run                   the reference is above handover_speed
 *     a start that fails --> catch after a pause, with more current and a slower ramp; at most start_tries
 *
 * Commissioning of a motor at standstill (medium/commission/commission.h) has its own manoeuvre, in which
 * this module controls nothing. If the bridge stays on, a catch follows.
 *
 * With the encoder the only manoeuvre is run; if the encoder is wrong, the drive continues with the
 * manoeuvres above. Each manoeuvre is a file of this folder; this file defines when each one ends. The rules
 * by which the limits follow from motor and shaft are in docs/theory.md, 23.
 *
 * One step per window, in the medium task: its result goes into the setpoint, from which
 * fast/reference/reference.h makes the reference of each period. Bounded, no division. */
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

/* When the current of a window can be compared with the winding's law (current_watch.h): where the EMF is
 * small or changes smoothly. A loop that tracks follows the current sensors, so nothing is compared then. */
typedef enum {
    COMPARED_NEVER,
    COMPARED_ALWAYS,
    COMPARED_STANDING, /* while no turning rotor is detected */
    COMPARED_UNTRACKED /* from the second window on, while the loop does not track */
} manoeuvre_compared_t;

/* One row for each manoeuvre: M(NAME, "name", source, compared, step). Append only: the numbers are those of
 * the signal `manoeuvre`, and the joined names are its choices.
 *
 *   source    of the frame in which control works. SOURCE_CATCH: the rotor's speed is unknown;
 *             SOURCE_FORCED: the frame is that of the forced ramp
 *   compared  manoeuvre_compared_t
 *   step      manoeuvres_STEP() executes one window of the manoeuvre and selects the next one */
#define MANOEUVRES(M)                                                                                        \
    M(OFF, "off", SOURCE_NONE, COMPARED_NEVER, catch)                                                        \
    M(CATCH, "|catch", SOURCE_CATCH, COMPARED_STANDING, catch)                                               \
    M(ALIGN, "|align", SOURCE_FORCED, COMPARED_ALWAYS, align)                                                \
    M(RAMP, "|ramp", SOURCE_FORCED, COMPARED_UNTRACKED, force)                                               \
    M(HANDOVER, "|handover", SOURCE_FORCED, COMPARED_NEVER, hand_over)                                       \
    M(RUN, "|run", SOURCE_ESTIMATE, COMPARED_NEVER, run)                                                     \
    M(FORCED, "|forced", SOURCE_FORCED, COMPARED_UNTRACKED, force)                                           \
    M(REVERSE, "|reverse", SOURCE_FORCED, COMPARED_UNTRACKED, force)                                         \
    M(RELOCK, "|relock", SOURCE_CATCH, COMPARED_NEVER, catch)                                                \
    M(COMMISSION, "|commission", SOURCE_FORCED, COMPARED_NEVER, resume)

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

/* The reasons for which a manoeuvre fails: bits, conditions of the fault table. */
#define MANOEUVRE_STALLED  UINT32_C(1) /* the rotor does not follow the forced frame */
#define MANOEUVRE_UNLOCKED UINT32_C(2) /* it follows, but the estimate did not lock to it */
#define MANOEUVRE_TOO_FAST UINT32_C(4) /* its EMF is above the DC link voltage */
#define MANOEUVRE_LOST     UINT32_C(8) /* the lock was lost too often */

/* Rise of the forced current per window, over the current of a start: from zero to it in 1.5 ms. */
#define MANOEUVRE_RISE (DRIVE_WINDOW_PERIOD / 1.5e-3f)

/* Duration of a catch. */
#define MANOEUVRE_CATCH_PERIODS DRIVE_PERIODS(20e-3f)

/* Nothing is judged for this time after a hand-over: twice the time constant of the low-passes of
 * the signs, which start as locked. */
#define MANOEUVRE_MASKED DRIVE_WINDOWS(10e-3f)

/* Nothing is learnt for this time after a hand-over, because the remaining error of the hand-over
 * would be attributed to the motor. */
#define MANOEUVRE_STEADY DRIVE_WINDOWS(50e-3f)

/* A rotor that was lost, is caught again and turns against the reference keeps its speed for this time. In
 * the reversal that follows, the lock cannot be judged where the EMF is small. Therefore the signs of a lost
 * lock, including the scatter, must first be absent for ten of these means. After that, MANOEUVRE_PROVED
 * remains until the rotor has been reversed or the reference has changed. */
#define MANOEUVRE_PROVED  UINT32_C(1)
#define MANOEUVRE_PROVING (MANOEUVRE_PROVED + MANOEUVRE_STEADY + DRIVE_WINDOWS(10e-3f))

/* The limits that end a manoeuvre. */
typedef struct {
    uint32_t sensorless;       /* [-] 1: control uses the estimator's angle; 0: the encoder's */
    float pole_pairs;          /* p [-] */
    float pole_pairs_inverse;  /* 1/p [-] */
    float handover_speed;      /* [rad/s] electrical */
    float fallback_speed;      /* [rad/s] electrical */
    float flux_linkage;        /* psi_f [Wb] */
    float ramp;                /* rise of the forced speed per window [rad/s] */
    float stop_ramp;           /* its fall in a quick stop [rad/s] */
    float ease_share;          /* share by which it approaches its final speed per window [-] */
    float current_start;       /* of the forced frame in a start [A] */
    float current_inverse;     /* 1/current_start [1/A] */
    float align_rise;          /* rise of the forced current per window in an alignment [A] */
    float current_retry;       /* largest current of a start after a failed one [A] */
    float current_caught;      /* along the d axis of a rotor that is caught [A] */
    float doubtful;            /* smaller currents leave the sign of a leg's loss uncertain [A]; 0: never */
    float align_speed;         /* of the forced frame in an alignment [rad/s] electrical */
    float swing_square;        /* omega_e^2 per ampere up to which a forced rotor swings [rad^2/s^2/A] */
    uint32_t align_windows;    /* [windows] duration of an alignment */
    uint32_t fallback_periods; /* [periods] for which the EMF may be missing in a reversal */
    uint32_t start_tries;      /* [-] */
    uint32_t
        smooth; /* [-] 1: the speed is used without the loop's proportional part, unless the shaft swings */
    uint32_t slow_loop;    /* [-] 1: the tracking loop is too slow for inertia and current limit */
    uint32_t judging;      /* [-] 1: the lock is judged */
    int32_t encoder_fault; /* [-] encoder_fault_reaction_t: reaction to a wrong encoder */
} manoeuvres_limits_t;

typedef struct {
    manoeuvres_limits_t limits;
    handover_tuning_t handover;
    lock_tuning_t lock;
    proof_tuning_t proof;
    run_tuning_t run;
} manoeuvres_tuning_t;

/* The lost locks. */
typedef struct {
    uint32_t count;    /* [-] since the bridge was switched on */
    uint32_t clock[2]; /* [windows] times of the last two */
    uint32_t relocks;  /* [-] catches since the last loss, without a proved lock */
    uint32_t brief;    /* [-] consecutive, each after a run that did not last */
} manoeuvres_losses_t;

/* The passage of a reversal through zero speed. */
typedef struct {
    uint32_t missing; /* [periods] without an EMF */
    float began; /* [rad/s] electrical: speed towards the reference when the EMF began to be missing, <= 0 */
} manoeuvres_passage_t;

/* State of a forced frame. */
typedef struct {
    float wanted;      /* current [A] */
    float needed;      /* part that the load needs, as last measured [A] */
    float emf_length;  /* low-passed [V] */
    float emf_across;  /* current x EMF, low-passed, positive for a rotor that turns with the frame [V A] */
    float quickness;   /* factor of the ramp in this start [-] */
    float speed;       /* at the end of the next window [rad/s], electrical */
    float current;     /* at the end of the next window [A] */
    uint32_t stalling; /* [windows] in which the EMF was smaller than that of a rotor that follows */
    uint32_t
        astray; /* [windows] in which the loop beside the frame was not locked, at a speed far from its */
} manoeuvres_forced_t;

typedef struct {
    manoeuvres_limits_t limits; /* of the tuning */
    handover_t handover;
    lock_t lock;
    proof_t proof;
    run_t run;

    int32_t now;           /* [-] manoeuvre_t */
    uint32_t sensorless;   /* [-] 1: control uses the estimator's angle; 0: the encoder's */
    uint32_t encoder_lost; /* [-] 1: the encoder was wrong; until the bridge is switched off */
    uint32_t clock;        /* [windows] */
    uint32_t windows;      /* [windows] in this manoeuvre, or in run since zero speed was passed */
    uint32_t entered;      /* [windows] number of the setpoint that began the newest catch */
    uint32_t tracking;     /* [-] 1: the loop tracks; 0: only the observer is stepped */
    uint32_t start_try;    /* [-] number of this start, from 1; 0: none, or finished */
    manoeuvres_losses_t losses;
    uint32_t other_source; /* [-] 1: position_source has changed while running */
    uint32_t reversing;    /* [-] 1: run passes zero speed, and nothing is judged while the EMF is small */
    uint32_t judged;       /* [-] 1: control uses an estimate that may be judged */
    uint32_t proving;      /* [windows] left in which the speed is kept, plus MANOEUVRE_PROVED; or 0 */
    manoeuvres_passage_t passage;
    uint32_t sound_windows; /* [windows] since the start succeeded */
    uint32_t unlocked;      /* [-] 1: a sign of a lost lock is present */
    uint32_t failed;        /* [-] MANOEUVRE_... bits that stop the drive */
    float omega_ref;        /* of the last window of run [rad/s], electrical */
    float omega_m_proved;   /* the speed that is kept while proving [rad/s], mechanical */
    manoeuvres_forced_t forced;
} manoeuvres_t;

/* The inputs of a window. */
typedef struct {
    const estimate_t *estimate; /* at its end; the EMF is the mean of the window, turned to its end */
    dq_t current;               /* mean in the estimate's frame [A] */
    ab_t sample;                /* the current at its end [A] */
    float scatter;              /* mean square of the detector [-] */
    uint32_t tracked;           /* [periods] in which the loop tracked */
    position_t encoder;         /* at its end */
    float omega_m;              /* [rad/s] mechanical, assumed speed of the rotor at its end */
    run_wish_t wish;
    uint32_t voltage_near; /* [-] 1: the dead time is nearly known, so that the estimate's frame is right */
    uint32_t losses;       /* [-] not 0: the guard reports that the lock is lost */
    int32_t outcome;       /* [-] catch_outcome_t of the active catch */
    uint32_t setpoint;     /* [windows] number of the setpoint that was active */
} manoeuvres_input_t;

/* Computes the coefficients; parameters that are 0 are replaced by their rules. For the background. */
manoeuvres_tuning_t manoeuvres_prepare(const params_t *params, const assumed_t *assumed);
reference_tuning_t reference_prepare(const params_t *params, const assumed_t *assumed);

/* Sets these coefficients and the manoeuvre off. */
void manoeuvres_init(manoeuvres_t *m, const manoeuvres_tuning_t *tuning);

/* Takes over new coefficients; the active manoeuvre continues. */
void manoeuvres_take(manoeuvres_t *m, const manoeuvres_tuning_t *tuning);

/* The bridge is switched on: catch, or with the encoder run, at this
 * mechanical speed of the encoder [rad/s]. */
void manoeuvres_begin(manoeuvres_t *m, float omega_m, setpoint_t *setpoint);

/* A step of commissioning excites the standing motor in place of current control: the frame is at rest. */
void manoeuvres_stand(manoeuvres_t *m, setpoint_t *setpoint);

/* The encoder is found to be wrong while running: the drive continues without it until the bridge is switched
 * off. It starts from the estimated angle if the EMF shows that the loop is
 * locked, otherwise with a catch. */
void manoeuvres_leave_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);

/* The same after the fast task has left the encoder by itself. */
void manoeuvres_left_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, bool to_estimate,
                             setpoint_t *setpoint);

/* True if the loop that tracks beside the encoder follows the rotor: its filtered EMF lies on its q axis, in
 * the direction of rotation, and has the length for the rotor's speed. */
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

/* The row of the active manoeuvre. */
const manoeuvre_row_t *manoeuvres_row(const manoeuvres_t *m);

/* True if the frame is that of the forced ramp. */
static inline bool manoeuvres_forces(const manoeuvres_t *m)
{
    return manoeuvres_row(m)->source == (int32_t)SOURCE_FORCED;
}

/* True if the rotor turns so evenly that it causes no ripple of the EMF. In a forced frame it is a pendulum:
 * near its w_n it answers the sixth harmonic of the currents with a swing. In
 * a catch its motion is unknown. */
static inline bool manoeuvres_even(const manoeuvres_t *m)
{
    const float omega_e = m->forced.speed;
    return m->now == (int32_t)MANOEUVRE_RUN ||
           (manoeuvres_forces(m) && omega_e * omega_e > m->limits.swing_square * m->forced.current);
}

/* True if the rotor's speed is known. It is unknown in a catch. */
static inline bool manoeuvres_knows(const manoeuvres_t *m)
{
    return manoeuvres_row(m)->source != (int32_t)SOURCE_CATCH;
}

/* True if control uses an estimate that may be judged: not in a reversal once the EMF is smaller than at
 * handover_speed, and not shortly after a hand-over. */
static inline bool manoeuvres_judged(const manoeuvres_t *m)
{
    return m->judged != 0u;
}

/* True in the first window in which control uses the estimate. What the loop did before does not count,
 * because the hand-over has judged it by its own signs. */
static inline bool manoeuvres_begins_run(const manoeuvres_t *m)
{
    return m->now == (int32_t)MANOEUVRE_RUN && m->windows == 0u;
}

/* True if the rotor's data may be learnt: only while the estimate is judged, not during a reversal, and not
 * for a while after a hand-over. */
static inline bool manoeuvres_steady(const manoeuvres_t *m)
{
    return m->judged != 0u && m->reversing == 0u && m->windows > MANOEUVRE_STEADY;
}

/* True if a dither of i_d may be added to the reference. Where i_d weakens the
 * field there is no voltage for it. */
static inline bool manoeuvres_dithers(const manoeuvres_t *m)
{
    return manoeuvres_steady(m) && !run_weakens(&m->run);
}

/* Fills `setpoint` with the source of the frame, references and orders of the window after the next; also
 * sets m->unlocked and m->failed. */
void manoeuvres_step(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);

#endif
