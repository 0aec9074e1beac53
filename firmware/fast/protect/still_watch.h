/* Reports a current sensor whose value does not change while control requires another current. This is the
 * fast part of current_watch.h, in the fast task: where V/L makes 25 A/ms, a window is too long. In each
 * period, for each sensor:
 *
 *     stuck   the value has not changed by a bit in the last periods, and differs from the reference
 *             by more than 5 % of the range in each of the last four of them
 *
 *             or it has not changed in the last three periods, while the voltage of its phase jumped: in the
 *             last two of them it was larger than in the first, enough to change the current by 2 % of the
 *             range, 40 codes. An EMF does not jump
 *
 * With such a control error the current changes by many codes per period, unless the voltage is at the limit
 * of the link. Because of noise a value repeats for one or two periods at most. A phase with an open wire has
 * no current, which does not change either. Therefore, while any phase has almost no current, only a
 * difference of 15 % is judged, and the value must have repeated for longer, also after a
 * jump of the voltage.
 *
 * With a wrong offset a sensor shows a constant value other than zero while its phase carries no current. The
 * dead time, compensated with the wrong sign, then holds the current at zero against the control. Therefore a
 * difference at which the control's voltage is less than this effect is not judged for such a value.
 *
 * Three values that add up to zero are those of the currents: a stuck one would make the sum different by its
 * error. One of them then does not change because its switch does not conduct.
 *
 * Does not handle: a sensor that is stuck near the reference without a jump of the voltage. */
#ifndef FAST_PROTECT_STILL_WATCH_H
#define FAST_PROTECT_STILL_WATCH_H

#include <float.h>
#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "math/winding.h"

#define STILL_SOME   3u       /* [periods] without a change from which a value is examined */
#define STILL_OFF    4u       /* [periods]: a step of the reference is visible in the third sample */
#define STILL_ALONE  8u       /* [periods] without a change, where a phase has almost no current */
#define STILL_PUSHED 0x10000u /* [periods] in place of a count, after a jump of the voltage */
#define STILL_FAR    3.0f     /* [-] factor on the accepted difference, where a phase has almost no current */

/* The largest change of the dead time's loss: the loss of three legs, 4/3 of that of one, with the opposite
 * sign in two periods. */
#define STILL_PUSH_DEAD 5.33333333f /* [-] */
/* The largest effect of one sensor's offset on its phase: its leg and that of the computed third current are
 * compensated with the wrong sign, (2 2 + 2)/3 of the loss of a leg. */
#define STILL_HELD_DEAD 2.0f /* [-] */

typedef struct {
    float range;        /* range of the sensors in both directions [A] */
    float inductance;   /* the larger of L_d and L_q [H], > 0 */
    float gain;         /* the smaller gain of the current control [ohm], > 0 */
    float dead_time;    /* of the legs [s] */
    float drop;         /* of a device [V] */
    float period;       /* T [s] */
    bool three_sensors; /* false: two sensors */
    bool judged;        /* false: the watch is off */
} still_watch_params_t;

typedef struct {
    uint32_t sensors; /* [-] 2 or 3; 0: the watch is off */
    float off;        /* largest accepted difference from the reference [A] */
    float gain;       /* the smaller gain of the current control [ohm] */
    float held;       /* largest effect of the drops on the voltage of a phase, with a wrong offset [V] */
    float none;       /* limit of almost no current [A] */
    float slow;       /* link voltage below which a current changes by only a few codes in a period [V] */
    float push;       /* least jump of the voltage, as the sum of two periods [V] ... */
    float push_link;  /* ... in addition, per volt of the link: largest change of the dead time's loss [-] */
    float turn;       /* ... in addition, per speed and volt: change of a rotating EMF in this time [s] */
} still_watch_tuning_t;

typedef struct {
    float value[3];    /* of the last period [A] */
    uint32_t still[3]; /* [periods] without a change */
    uint32_t off[3]; /* [periods] of these with a difference from the reference; or STILL_PUSHED, after a jump
                        of the voltage */
    ab_t voltage[2]; /* that acted in the last period and in the one before [V] */
} still_watch_t;

/* The inputs of a period in which a value is examined. */
typedef struct {
    ab_t asked;           /* reference for the sample of the last period [A] */
    const abc_t *current; /* measured [A] */
    const ab_t *voltage;  /* that acted in the last period [V] */
    float omega_e;        /* assumed speed of the rotor [rad/s] */
    float u_dc;           /* [V] */
    bool limited;         /* the applied voltage is less than control required */
} still_watch_input_t;

/* Computes the coefficients. One division. */
still_watch_tuning_t still_watch_prepare(const still_watch_params_t *params);

/* One period of sensor `n`, with its current [A]. true: it has not changed for some periods. */
static inline bool still_watch_one(still_watch_t *watch, uint32_t n, float current)
{
    if (current != watch->value[n]) {
        watch->value[n] = current;
        watch->still[n] = 0u;
        return false;
    }
    watch->still[n]++;
    return watch->still[n] >= STILL_SOME;
}

/* Counts in each period, with the current [A]. true: a value has not changed for some periods. */
static inline bool still_watch_count(still_watch_t *watch, const still_watch_tuning_t *tuning,
                                     const abc_t *current)
{
    if (tuning->sensors == 0u) {
        return false;
    }
    const bool a = still_watch_one(watch, 0u, current->a);
    const bool b = still_watch_one(watch, 1u, current->b);
    const bool c = tuning->sensors == 3u && still_watch_one(watch, 2u, current->c);
    return a || b || c;
}

/* Each period, after the judgement: the voltage that acted in the last period [V]. */
static inline void still_watch_remember(still_watch_t *watch, const ab_t *voltage)
{
    watch->voltage[1] = watch->voltage[0];
    watch->voltage[0] = *voltage;
}

/* Bits of the judged sensors whose value has changed in the last `periods`, by their counts of periods
 * without a change. */
static inline uint32_t still_watch_moved(const uint32_t still[3], uint32_t periods)
{
    uint32_t moved = still[0] < periods ? UINT32_C(1) : UINT32_C(0);
    if (still[1] < periods) {
        moved |= 2u;
    }
    if (still[2] < periods) {
        moved |= 4u;
    }
    return moved;
}

/* The jump of the voltage of each phase [V]: the sum of the last two of three periods, minus twice the
 * voltage of the first one. The control responds to a sample in the second of three periods. */
static inline abc_t still_watch_jumps(const still_watch_t *watch, ab_t voltage)
{
    const ab_t was = watch->voltage[1];
    return frames_inverse_clarke((ab_t){voltage.alpha + watch->voltage[0].alpha - 2.0f * was.alpha,
                                        voltage.beta + watch->voltage[0].beta - 2.0f * was.beta});
}

/* Largest jump that a rotating EMF, the dead time and a small change of the current explain [V]. */
static inline float still_watch_explained(const still_watch_t *watch, const still_watch_tuning_t *tuning,
                                          float u_dc, float omega_e)
{
    const ab_t was = watch->voltage[1];
    const float length = bounds_magnitude(was.alpha) + bounds_magnitude(was.beta);
    return tuning->push + tuning->push_link * u_dc + tuning->turn * bounds_magnitude(omega_e) * length;
}

/* Limits of a period. */
typedef struct {
    float off;       /* largest difference from the reference [A] */
    float u_dc;      /* [V] */
    float push;      /* largest jump of the voltage [V] */
    uint32_t stands; /* [periods] for which a stuck value has not changed at least */
} still_limits_t;

/* Limits for these inputs. While the link allows only a slow change, no difference counts. */
static inline still_limits_t still_watch_limits(const still_watch_t *watch,
                                                const still_watch_tuning_t *tuning,
                                                const still_watch_input_t *input)
{
    const abc_t current = *input->current;
    const bool alone = bounds_within(current.a, tuning->none) || bounds_within(current.b, tuning->none) ||
                       bounds_within(current.c, tuning->none);
    const bool counts = !input->limited || input->u_dc > tuning->slow;
    return (still_limits_t){
        .off = !counts ? FLT_MAX
               : alone ? STILL_FAR * tuning->off
                       : tuning->off,
        .u_dc = input->u_dc,
        .push = still_watch_explained(watch, tuning, input->u_dc, input->omega_e),
        .stands = alone ? STILL_ALONE : STILL_SOME,
    };
}

/* True if the dead time may hold a value constant that misses its reference by this difference [A]. */
static inline bool still_watch_holds(const still_watch_tuning_t *tuning, float value, float miss, float u_dc)
{
    return !bounds_within(value, tuning->none) &&
           bounds_within(tuning->gain * miss,
                         tuning->held + STILL_HELD_DEAD / STILL_PUSH_DEAD * tuning->push_link * u_dc);
}

/* One period of sensor `n`, with the reference [A] and the jump of the voltage [V] of its phase. true: it is
 * stuck. */
static inline bool still_watch_is_stuck(still_watch_t *watch, const still_watch_tuning_t *tuning, uint32_t n,
                                        float asked, float jump, const still_limits_t *limits)
{
    const uint32_t still = watch->still[n];
    if (still < STILL_SOME) {
        watch->off[n] = 0u;
        return false;
    }
    uint32_t off = still == STILL_SOME ? 0u : watch->off[n];
    if (off >= STILL_PUSHED || !bounds_within(jump, limits->push)) {
        off = STILL_PUSHED;
    } else {
        const float value = watch->value[n];
        const float miss = asked - value;
        off = bounds_within(miss, limits->off) || still_watch_holds(tuning, value, miss, limits->u_dc)
                  ? 0u
                  : off + 1u;
    }
    watch->off[n] = off;
    return off >= STILL_OFF && still >= limits->stands;
}

/* Judges the sensors while control runs and still_watch_count() is true; true: a sensor is stuck. */
static inline bool still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning,
                                     const still_watch_input_t *input)
{
    const abc_t asked = frames_inverse_clarke(input->asked);
    const abc_t jump = still_watch_jumps(watch, *input->voltage);
    const still_limits_t limits = still_watch_limits(watch, tuning, input);
    const bool a = still_watch_is_stuck(watch, tuning, 0u, asked.a, jump.a, &limits);
    const bool b = still_watch_is_stuck(watch, tuning, 1u, asked.b, jump.b, &limits);
    if (tuning->sensors < 3u) {
        return a || b;
    }
    const bool c = still_watch_is_stuck(watch, tuning, 2u, asked.c, jump.c, &limits);
    return (a || b || c) && !winding_adds_up(input->current, tuning->off);
}

#endif
