/* Frequency and amplitude of the dither by which L is learnt (inductance.h). */
#ifndef MEDIUM_ADAPT_INDUCTANCE_DITHER_H
#define MEDIUM_ADAPT_INDUCTANCE_DITHER_H

#include "medium/adapt/inductance.h"

#define INDUCTANCE_TWO_PI 6.2831853f

#define INDUCTANCE_RIPPLE_TURN 0.8f   /* [rad] turn in a step from which on the ripple does not matter */
#define INDUCTANCE_REPEATS     0.004f /* [rad] a step is a third of a turn: within half a sample in a cycle */

/* True if the frequency is not near one or two times the electrical one, and not within `reach` of six times
 * it. All in [rad/s]. */
static inline bool inductance_is_good(float frequency, float omega, float reach)
{
    const float near = INDUCTANCE_TWO_PI * INDUCTANCE_NEAR;
    return !bounds_within(frequency - omega, near) && !bounds_within(frequency - 2.0f * omega, near) &&
           !bounds_within(frequency - 6.0f * omega, reach);
}

/* True if the inverter's voltage hides L at this speed [rad/s], above 0, and this i_q [A]. Either the ripple
 * of the current by the EMF exceeds i_q, while the rotor turns little in a step. Or a step is so near a third
 * of a turn that all steps of a cycle have their samples at the same angles: what the model of the inverter
 * misses is then the same in each step, and its response to the dither counts as L. */
static inline bool inductance_hides(const inductance_tuning_t *tuning, float speed, float i_q)
{
    const float turn = speed * tuning->time;
    return (bounds_within(i_q, speed * tuning->ripple) && turn < INDUCTANCE_RIPPLE_TURN) ||
           bounds_within(turn - INDUCTANCE_TWO_PI / 3.0f, INDUCTANCE_REPEATS);
}

/* The index of the first frequency that is good at this speed [rad/s]; without torque it must not be near
 * five or seven times the electrical one either. Those before `from` have been a resonance of the shaft.
 * INDUCTANCE_FREQUENCIES: none is good. */
static inline uint32_t inductance_frequency(float omega, bool torque, uint32_t from)
{
    static const float frequencies[INDUCTANCE_FREQUENCIES] = {INDUCTANCE_TWO_PI * INDUCTANCE_FREQUENCY_1,
                                                              INDUCTANCE_TWO_PI * INDUCTANCE_FREQUENCY_2,
                                                              INDUCTANCE_TWO_PI * INDUCTANCE_FREQUENCY_3};
    const float reach =
        torque ? INDUCTANCE_TWO_PI * INDUCTANCE_NEAR_SIXTH : INDUCTANCE_TWO_PI * INDUCTANCE_NEAR + omega;
    uint32_t which = from;
    while (which < INDUCTANCE_FREQUENCIES && !inductance_is_good(frequencies[which], omega, reach)) {
        which++;
    }
    return which;
}

/* The amplitude at INDUCTANCE_SLOW and above [A]: a share of the current limit, and more where the noise of
 * the sensors requires it. */
static inline float inductance_dither(const inductance_params_t *params)
{
    const float most = INDUCTANCE_DITHER_MOST * params->current_max;
    const float by_noise = bounds_less(INDUCTANCE_NOISE * params->noise, most);
    return bounds_more(INDUCTANCE_DITHER * params->current_max, by_noise);
}

/* The largest factor of this amplitude at low speed [-]. An L that is wrong by a fifth shifts the angle under
 * rated torque, half of the limit, by 0.1 L i_max/psi_f, and with this shift the dither makes a torque. The
 * speed may swing with it by half of INDUCTANCE_R_SPEED_DRIFT, beyond which a cycle has no result. */
static inline float inductance_slow_most(const inductance_params_t *params)
{
    const float ahead = 0.1f * params->inductance_q * params->current_max / params->flux_linkage;
    const float swing = params->acceleration * inductance_dither(params) * ahead /
                        (INDUCTANCE_TWO_PI * INDUCTANCE_FREQUENCY_1);
    const float most = 0.5f * INDUCTANCE_R_SPEED_DRIFT * INDUCTANCE_SPEED_MIN;
    if (params->salient || swing >= most) {
        return 1.0f;
    }
    return swing * INDUCTANCE_SLOW_MOST < most ? INDUCTANCE_SLOW_MOST : most / swing;
}

/* The amplitude [A] at this speed [rad/s], above 0, and this i_q [A] (inductance.h). */
static inline float inductance_amplitude(const inductance_tuning_t *tuning, float speed, float i_q)
{
    const float slow = tuning->current * bounds_less(INDUCTANCE_SLOW / speed, tuning->slow_most);
    const float most = (1.0f / INDUCTANCE_TORQUE) * bounds_magnitude(i_q);
    return bounds_more(tuning->current, bounds_less(slow, most));
}

/* The value of the dither's wave at t, -1..1. */
static inline float inductance_wave_at(float t)
{
    return 4.0f * t * (1.0f - bounds_magnitude(t));
}

/* The position in the wave that follows by `by`. */
static inline float inductance_later(float t, float by)
{
    const float next = t + by;
    return next < 1.0f ? next : next - 2.0f;
}

#endif
