/* The frequency of the dither by which L is learnt (inductance.h), from the electrical speed. */
#ifndef MEDIUM_ADAPT_INDUCTANCE_FREQUENCY_H
#define MEDIUM_ADAPT_INDUCTANCE_FREQUENCY_H

#include "medium/adapt/inductance.h"

#define INDUCTANCE_TWO_PI 6.2831853f

/* True if the frequency is near one or two times the electrical one. All in [rad/s]. */
static inline bool inductance_is_near(float frequency, float omega)
{
    return bounds_within(frequency - omega, INDUCTANCE_TWO_PI * INDUCTANCE_NEAR) ||
           bounds_within(frequency - 2.0f * omega, INDUCTANCE_TWO_PI * INDUCTANCE_NEAR);
}

/* The frequency at this speed [rad/s]: the first one that is not near one, two or six times the electrical
 * one, and without torque not near five or seven times either. If the first one is near such a multiple, the
 * second one may be near the sixth. Those before `from` have been a resonance of the shaft. */
static inline uint32_t inductance_frequency(float omega, bool torque, uint32_t from)
{
    const float sixth = 6.0f * omega;
    const float reach =
        torque ? INDUCTANCE_TWO_PI * INDUCTANCE_NEAR_SIXTH : INDUCTANCE_TWO_PI * INDUCTANCE_NEAR + omega;
    if (from == 0u && !bounds_within(INDUCTANCE_TWO_PI * INDUCTANCE_FREQUENCY_1 - sixth, reach) &&
        !inductance_is_near(INDUCTANCE_TWO_PI * INDUCTANCE_FREQUENCY_1, omega)) {
        return 0u;
    }
    return from > 1u || bounds_within(INDUCTANCE_TWO_PI * INDUCTANCE_FREQUENCY_2 - sixth, reach) ? 2u : 1u;
}

#endif
