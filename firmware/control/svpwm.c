#include "control/svpwm.h"

#include <stdbool.h>

/* Beyond this a voltage is not one, and sums of three could overflow [V]. */
#define VOLTAGE_LIMIT 1e30f

/* Below this the reciprocal is not finite [V]. */
#define U_DC_LEAST 1e-37f

static bool within(float value, float limit)
{
    return value >= -limit && value <= limit;
}

static float clamp(float value, float lower, float upper)
{
    if (value > upper) {
        return upper;
    }
    return value < lower ? lower : value;
}

svpwm_t svpwm_closely(ab_t voltage, float u_dc, float duty_min, float duty_max)
{
    svpwm_t result = {{0.5f, 0.5f, 0.5f}, {0.0f, 0.0f}, UINT32_C(1)};
    if (!(u_dc >= U_DC_LEAST && u_dc <= VOLTAGE_LIMIT && within(voltage.alpha, VOLTAGE_LIMIT) &&
          within(voltage.beta, VOLTAGE_LIMIT))) {
        return result;
    }

    abc_t phases = frames_inverse_clarke(voltage);
    float highest = phases.a > phases.b ? phases.a : phases.b;
    float lowest = phases.a > phases.b ? phases.b : phases.a;
    if (phases.c > highest) {
        highest = phases.c;
    } else if (phases.c < lowest) {
        lowest = phases.c;
    }

    float span = highest - lowest;
    float duty_span = duty_max - duty_min;
    float per_volt = 1.0f / u_dc;
    if (span * per_volt > duty_span) {
        per_volt = duty_span / span;
    }

    float centre = 0.5f * (highest + lowest);
    float middle = 0.5f * (duty_min + duty_max);
    result.duty.a = clamp(middle + (phases.a - centre) * per_volt, duty_min, duty_max);
    result.duty.b = clamp(middle + (phases.b - centre) * per_volt, duty_min, duty_max);
    result.duty.c = clamp(middle + (phases.c - centre) * per_volt, duty_min, duty_max);

    /* From the duties, not from the request: their rounding and the cut are in it. */
    ab_t share = frames_clarke(result.duty);
    result.voltage.alpha = share.alpha * u_dc;
    result.voltage.beta = share.beta * u_dc;
    return result;
}
