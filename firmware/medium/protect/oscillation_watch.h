/* Oscillation watch: detects an oscillation of the speed loop. A load on an elastic shaft swings against the
 * rotor with its natural frequency, and a speed control that is too fast for it sustains this swing. The
 * watch uses the torque reference, between the bandwidth of the speed loop and that of the tracking loop:
 *
 *     y = LP_fast(i_q_ref - LP_slow(i_q_ref))
 *
 * Consecutive half-waves of y with nearly the same length are counted in blocks of OSCILLATION_WAVES; one of
 * another length restarts the count, so that noise is not counted. An oscillation is reported after
 * OSCILLATION_BLOCKS blocks in succession with
 *
 *     growing     the mean peak is 1.1 times that of the block before, and above 0.5 % of the current limit
 *     sustained   the mean peak is above 10 % of the current limit
 *
 * A ripple that the motor itself makes (offsets, unequal legs, harmonics) is regular, but it does
 * not grow at a constant speed and is smaller than that. A change of the speed reference restarts
 * the count. Does not handle: a load that itself swings in this band with a tenth of the torque; it
 * is reported as an oscillation.
 *
 * One step per `every` T; no division. */
#ifndef MEDIUM_PROTECT_OSCILLATION_WATCH_H
#define MEDIUM_PROTECT_OSCILLATION_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#define OSCILLATION_WAVES  16u /* [half-waves] of a block */
#define OSCILLATION_BLOCKS 3u  /* [blocks] in succession */

typedef struct {
    float slow;          /* bandwidth of the speed loop [rad/s], > 0 */
    float fast;          /* bandwidth of the tracking loop [rad/s], > slow */
    float current_limit; /* [A], > 0 */
    float period;        /* T [s] */
    uint32_t every;      /* periods of a step [-] */
} oscillation_watch_params_t;

typedef struct {
    float slow_share; /* of the low-passes [-] */
    float fast_share; /* [-] */
    float growing;    /* least sum of the peaks of a block that grows [A] */
    float sustained;  /* the same for a sustained one [A] */
    uint32_t longest; /* [steps] of a half-wave */
} oscillation_watch_tuning_t;

typedef struct {
    oscillation_watch_tuning_t tuning;
    float slow;      /* LP_slow(i_q_ref) [A] */
    float fast;      /* y [A] */
    float reference; /* speed reference of the last step [rad/s] */
    float peak;      /* of this half-wave [A] */
    float sum;       /* of the peaks in this block [A] */
    float before;    /* of the peaks in the last block [A] */
    uint32_t begun;  /* [-] 1: the low-passes have started */
    uint32_t length; /* [steps] of this half-wave so far */
    uint32_t usual;  /* [steps] of the last one; 0: there was none */
    uint32_t waves;  /* [half-waves] of this block */
    uint32_t blocks; /* [blocks] in succession */
} oscillation_watch_t;

/* Computes the coefficients. Divisions and exponentials: for the background. */
oscillation_watch_tuning_t oscillation_watch_prepare(const oscillation_watch_params_t *params);

/* Takes these coefficients; nothing has been measured yet. */
void oscillation_watch_init(oscillation_watch_t *watch, const oscillation_watch_tuning_t *tuning);

/* Takes over new coefficients; the state is kept. */
static inline void oscillation_watch_take(oscillation_watch_t *watch,
                                          const oscillation_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* Resets the state, because the loop is open. */
static inline void oscillation_watch_rest(oscillation_watch_t *watch)
{
    watch->begun = 0u;
}

/* Torque reference [A] and mechanical speed reference [rad/s]. Returns true if the loop oscillates; it is
 * reported once, and the count restarts. */
bool oscillation_watch_step(oscillation_watch_t *watch, float i_q_ref, float omega_m_ref);

#endif
