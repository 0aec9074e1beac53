/* Oscillation watch: detects an oscillation of the speed loop. A load on an elastic shaft swings against the
 * rotor with its natural frequency, and a speed control that is too fast for it sustains this swing. The
 * watch uses the torque reference, between the bandwidth of the speed loop and that of the tracking loop:
 *
 *     y = LP_fast(i_q_ref - LP_slow(i_q_ref))
 *
 * Consecutive waves of y are counted in blocks of OSCILLATION_WAVES. The first wave gives the length; a
 * wave of another length restarts the count, so that neither noise is counted nor a ripple that turns with a
 * rotor whose speed changes. The amplitude of a block is the mean of its positive and negative peaks, on
 * which a torque that changes slowly has no effect. An oscillation is reported in two
 * cases:
 *
 * - Growing: the amplitude has grown by 1.1 OSCILLATION_GROWTHS times, each time within 32 waves, without
 *   having decayed by 1.1 in between, and is above 0.5 % of the current limit.
 * - Sustained: it is above 10 % of the current limit in OSCILLATION_SUSTAINED blocks in succession.
 *
 * The growth is measured from the block of its last step, not from block to block: the rule is the same for a
 * fast and for a slow growth. A ripple that the motor itself makes (offsets, unequal legs, harmonics) is
 * regular, but it does not grow at a constant speed and is smaller than that. A resonance that noise excites
 * is regular, too; its amplitude grows and decays by chance, is smaller, and one of 2^4 series of four steps
 * contains growth only.
 *
 * The first sign of a growth is reported earlier: OSCILLATION_RISES waves in succession that are each larger
 * than the last one by 1.15, up to an amplitude above 2 % of the current limit. A ripple whose frequency
 * approaches a resonance may cause it, too. It is therefore no reason to reduce the gain.
 *
 * A change of the speed reference restarts the count. Does not handle: a load that
 * itself swings in this band with a tenth of the torque; it is reported as an oscillation.
 *
 * One step per `every` T; no division. */
#ifndef MEDIUM_PROTECT_OSCILLATION_WATCH_H
#define MEDIUM_PROTECT_OSCILLATION_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#define OSCILLATION_WAVES     2u  /* [waves] of a block */
#define OSCILLATION_GROWTHS   4u  /* [steps of growth] in succession */
#define OSCILLATION_SUSTAINED 12u /* [blocks] in succession */
#define OSCILLATION_RISES     2u  /* [waves] in succession, each larger than the last one */

typedef enum {
    OSCILLATION_NONE,
    OSCILLATION_BEGINS, /* the first sign */
    OSCILLATION_CERTAIN /* the loop oscillates */
} oscillation_t;

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
    float growing;    /* least sum of a block that grows [A] */
    float sustained;  /* the same for a sustained one [A] */
    float begins;     /* least sum of a wave that is a first sign [A] */
    uint32_t longest; /* [steps] of a wave */
} oscillation_watch_tuning_t;

typedef struct {
    oscillation_watch_tuning_t tuning;
    float slow;       /* LP_slow(i_q_ref) [A] */
    float fast;       /* y [A] */
    float reference;  /* speed reference of the last step [rad/s] */
    float peak;       /* largest |y| of this half-wave [A] */
    float sum;        /* of the peaks in this block [A] */
    float wave;       /* of the peaks in this wave [A] */
    float last;       /* the same of the last wave [A] */
    float step;       /* the sum with which the last step of growth or decay ended [A]; 0: none */
    uint32_t length;  /* [steps] of this wave so far; 0: the low-passes have not started */
    uint32_t first;   /* [steps] of the wave with which the count began; 0: none */
    uint32_t waves;   /* [waves] since the last step of growth or decay */
    uint32_t growths; /* [-] steps of growth in succession */
    uint32_t rises;   /* [waves] in succession that are larger than the last one */
    uint32_t large;   /* [blocks] in succession that are large enough for a sustained oscillation */
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
    watch->length = 0u;
}

/* Torque reference [A] and mechanical speed reference [rad/s]. Returns OSCILLATION_CERTAIN if the loop
 * oscillates; it is reported once, and the count restarts. The first sign of it is returned at the end of
 * each wave that contains one. */
oscillation_t oscillation_watch_step(oscillation_watch_t *watch, float i_q_ref, float omega_m_ref);

#endif
