/* Reports a current sensor whose value does not change while control requires another current. This is the
 * fast part of current_watch.h, in the fast task: where V/L makes 25 A/ms, a window is too long. In each
 * period, for each sensor:
 *
 *     stuck   the value has not changed by a bit in any of the last periods, and differs from the reference
 *             by more than 5 % of the range in each of the last four of them
 *
 * With such a control error the current changes by many codes per period, unless the link gives no more
 * voltage; with noise a value repeats for one or two periods. Behind an open wire no current flows: where any
 * phase has almost no current, only a difference of 15 % is judged, and the value has to repeat for longer.
 *
 * Does not handle: a sensor that is stuck near the reference. */
#ifndef FAST_PROTECT_STILL_WATCH_H
#define FAST_PROTECT_STILL_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

#define STILL_SOME 3u /* [periods] without a change from which a value is examined */

typedef struct {
    float range;        /* range of the sensors in both directions [A] */
    float inductance;   /* the larger of L_d and L_q [H], > 0 */
    float period;       /* T [s] */
    bool three_sensors; /* false: two sensors */
    bool judged;        /* false: the watch is off */
} still_watch_params_t;

typedef struct {
    uint32_t sensors; /* [-] 2 or 3; 0: the watch is off */
    float off;        /* largest difference from the reference that is accepted [A] */
    float far;        /* the same where a phase has almost no current [A] */
    float none;       /* limit of almost no current [A] */
    float slow;       /* link voltage below which a current changes by only a few codes in a period [V] */
} still_watch_tuning_t;

typedef struct {
    float value[3];    /* of the last period [A] */
    uint32_t still[3]; /* [periods] without a change */
    uint32_t off[3];   /* [periods] of these with a difference from the reference */
} still_watch_t;

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

/* Bits of the judged sensors whose value has changed in the last `periods`. */
static inline uint32_t still_watch_moved(const still_watch_t *watch, uint32_t periods)
{
    return (watch->still[0] < periods ? 1u : 0u) | (watch->still[1] < periods ? 2u : 0u) |
           (watch->still[2] < periods ? 4u : 0u);
}

/* Judges the sensors while control runs and still_watch_count() is true; true: a sensor is stuck. `asked`
 * [A]: reference for the sample of the last period. `limited`: the applied voltage is less than control
 * required. */
bool still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning, abc_t asked, abc_t current,
                       bool limited, float u_dc);

#endif
