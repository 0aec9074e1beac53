/* Brake chopper: connects the brake resistor to the DC link by hysteresis of the link voltage, in each
 * period.
 *
 *     on above U_chop, off below (1 - CHOPPER_BAND) U_chop
 *
 * It is in the fast task because of the link's capacitance: a setpoint of the medium task acts 0.9 to 1.7 ms
 * after the sample, in which a braking power P raises the link by P t/(C u). docs/chopper_and_brake.md has
 * the numbers. Heat and effect of the resistor are judged by the medium task
 * (medium/protect/chopper_watch.h), which permits the chopper with its setpoint.
 *
 * Does not handle: a supply above U_chop, to which the resistor stays connected until the watch finds it. */
#ifndef FAST_PROTECT_CHOPPER_H
#define FAST_PROTECT_CHOPPER_H

#include <float.h>
#include <stdint.h>

#define CHOPPER_BAND 0.02f /* [-] of U_chop */

typedef struct {
    float above; /* on above this link voltage [V] */
    float below; /* off below this one [V] */
} chopper_tuning_t;

/* The thresholds for this U_chop [V]; 0: the chopper stays off. */
static inline chopper_tuning_t chopper_prepare(float voltage)
{
    if (!(voltage > 0.0f)) {
        return (chopper_tuning_t){FLT_MAX, FLT_MAX};
    }
    return (chopper_tuning_t){voltage, (1.0f - CHOPPER_BAND) * voltage};
}

/* Whether the chopper is on at this link voltage [V]; `on`: whether it was. 0 or 1. */
static inline uint32_t chopper_step(uint32_t on, const chopper_tuning_t *tuning, float u_dc)
{
    if (u_dc > tuning->above) {
        return 1u;
    }
    return u_dc < tuning->below ? 0u : on;
}

#endif
