/* Reports a current sensor whose value does not change while control requires another current. The quick half
 * of current_watch.h, in the fast task: where V/L makes 25 A/ms, a window is too long. In each period, sensor
 * by sensor:
 *
 *     stuck   its value has not moved by a bit in any of the last periods, and is off what is asked for by
 * more than 5 % of the range in each of the last four of them
 *
 * A current that control misses by so much moves by many codes in a period, unless the link gives no more
 * voltage; noise lets a value stay for a period or two. Past an open wire no current moves: where any phase
 * has next to none, only a value that is off by 15 % is judged, and has to stay for longer.
 *
 * Does not handle: a sensor that is stuck near what is asked for. */
#ifndef FAST_PROTECT_STILL_WATCH_H
#define FAST_PROTECT_STILL_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

#define STILL_SOME 3u /* [periods] without a move, from which on a value is looked at */

typedef struct {
    float range;        /* what the sensors see in both directions [A] */
    float inductance;   /* the larger of L_d and L_q [H], > 0 */
    float period;       /* T [s] */
    bool three_sensors; /* else two */
    bool judged;        /* false: nothing is ever found */
} still_watch_params_t;

typedef struct {
    uint32_t sensors; /* [-] 2 or 3; 0: nothing is ever found */
    float off;        /* largest distance from what is asked for that is none [A] */
    float far;        /* likewise, where a phase has next to no current [A] */
    float none;       /* next to no current [A] */
    float slow;       /* link, below which its whole voltage moves a current by few codes in a period [V] */
} still_watch_tuning_t;

typedef struct {
    float value[3];    /* of the last period [A] */
    uint32_t still[3]; /* [periods] for which it has not moved */
    uint32_t off[3];   /* [periods] of them, for which it has been off what is asked for */
} still_watch_t;

/* These coefficients. One division. */
still_watch_tuning_t still_watch_prepare(const still_watch_params_t *params);

/* A period of sensor `n`, with its current [A]. */
static inline void still_watch_one(still_watch_t *watch, uint32_t n, float current)
{
    watch->still[n] = current == watch->value[n] ? watch->still[n] + 1u : 0u;
    watch->value[n] = current;
}

/* In each period, with the current [A]. true: a value has stayed for some periods. */
static inline bool still_watch_count(still_watch_t *watch, const still_watch_tuning_t *tuning,
                                     const abc_t *current)
{
    if (tuning->sensors == 0u) {
        return false;
    }
    still_watch_one(watch, 0u, current->a);
    still_watch_one(watch, 1u, current->b);
    if (tuning->sensors == 3u) {
        still_watch_one(watch, 2u, current->c);
    }
    return watch->still[0] >= STILL_SOME || watch->still[1] >= STILL_SOME || watch->still[2] >= STILL_SOME;
}

/* Bits of the sensors whose value has not stayed in all of the last so many periods, of as many as are
 * judged. */
static inline uint32_t still_watch_moved(const still_watch_t *watch, uint32_t periods)
{
    return (watch->still[0] < periods ? 1u : 0u) | (watch->still[1] < periods ? 2u : 0u) |
           (watch->still[2] < periods ? 4u : 0u);
}

/* Where one has, and control runs: is it stuck? `asked` [A]: for the sample of the last period; `limited`:
 * control has not got the voltage that it asked for. */
bool still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning, abc_t asked, abc_t current,
                       bool limited, float u_dc);

#endif
