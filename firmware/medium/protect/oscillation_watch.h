/* Oscillation watch: does the speed loop swing a shaft? A load on an elastic shaft is turned against the
 * rotor by its own natural frequency; a speed control that is too quick for it feeds that swing. It is looked
 * for in the torque reference, between the bandwidth of the speed loop and that of the tracking loop:
 *
 *     y = LP_fast(i_q_ref - LP_slow(i_q_ref))
 *
 * Half-waves of y that follow one another with nearly the same length are counted in blocks of
 * OSCILLATION_WAVES; one that does not fit begins anew, so that noise is none. Told after OSCILLATION_BLOCKS
 * in a row
 *
 *     growing     the mean peak is 1.1 times that of the block before, and more than 0.5 % of the current
 * limit sustained   the mean peak is more than 10 % of the current limit
 *
 * A ripple that the motor itself makes (offsets, unequal legs, harmonics) is regular, but neither grows at a
 * speed that stays, nor is it that large. A change of the speed reference begins anew. Does not handle: a
 * load that itself swings in this band with a tenth of the torque; it is told as an oscillation.
 *
 * One step per `every` T; no division. */
#ifndef MEDIUM_PROTECT_OSCILLATION_WATCH_H
#define MEDIUM_PROTECT_OSCILLATION_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#define OSCILLATION_WAVES  16u /* [half-waves] of a block */
#define OSCILLATION_BLOCKS 3u  /* [blocks] in a row */

typedef struct {
    float slow;          /* bandwidth of the speed loop [rad/s], > 0 */
    float fast;          /* of the tracking loop [rad/s], > slow */
    float current_limit; /* [A], > 0 */
    float period;        /* T [s] */
    uint32_t every;      /* periods of a step [-] */
} oscillation_watch_params_t;

typedef struct {
    float slow_share; /* of the low-passes [-] */
    float fast_share; /* [-] */
    float growing;    /* least sum of the peaks of a block that grows [A] */
    float sustained;  /* likewise, of one that stays [A] */
    uint32_t longest; /* [steps] of a half-wave */
} oscillation_watch_tuning_t;

typedef struct {
    oscillation_watch_tuning_t tuning;
    float slow;      /* LP_slow [A] */
    float fast;      /* y [A] */
    float reference; /* of the speed, at the last step [rad/s] */
    float peak;      /* of this half-wave [A] */
    float sum;       /* of the peaks of this block [A] */
    float before;    /* of those of the last block [A] */
    uint32_t begun;  /* [-] 1: the low-passes have begun */
    uint32_t length; /* [steps] of this half-wave so far */
    uint32_t usual;  /* [steps] of the last one; 0: there was none */
    uint32_t waves;  /* [half-waves] of this block */
    uint32_t blocks; /* [blocks] in a row */
} oscillation_watch_t;

/* Coefficients. Divisions and exponentials: for the background. */
oscillation_watch_tuning_t oscillation_watch_prepare(const oscillation_watch_params_t *params);

/* These coefficients; nothing seen. */
void oscillation_watch_init(oscillation_watch_t *watch, const oscillation_watch_tuning_t *tuning);

/* New coefficients; what is under way goes on. */
static inline void oscillation_watch_take(oscillation_watch_t *watch,
                                          const oscillation_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* The loop is open. */
static inline void oscillation_watch_rest(oscillation_watch_t *watch)
{
    watch->begun = 0u;
}

/* Torque reference [A] and mechanical speed reference [rad/s]: does the loop oscillate? It is told once, and
 * looked for anew. */
bool oscillation_watch_step(oscillation_watch_t *watch, float i_q_ref, float omega_m_ref);

#endif
