#include "inverter/svpwm.h"

#include <stdbool.h>

#include "math/bounds.h"

/* Beyond this a voltage is not one, and sums of three could overflow [V]. */
#define VOLTAGE_LIMIT 1e30f

/* Below this the reciprocal is not finite [V]. */
#define U_DC_LEAST 1e-37f

static float greater(float x, float y)
{
    return x > y ? x : y;
}

static float lesser(float x, float y)
{
    return x < y ? x : y;
}

svpwm_t svpwm_modulate(ab_t voltage, float u_dc, float duty_min, float duty_max)
{
    if (!(u_dc >= U_DC_LEAST && u_dc <= VOLTAGE_LIMIT && bounds_within(voltage.alpha, VOLTAGE_LIMIT) &&
          bounds_within(voltage.beta, VOLTAGE_LIMIT))) {
        return (svpwm_t){{0.5f, 0.5f, 0.5f}, {0.0f, 0.0f}};
    }
    const abc_t phases = frames_inverse_clarke(voltage);
    const float highest = greater(greater(phases.a, phases.b), phases.c);
    const float lowest = lesser(lesser(phases.a, phases.b), phases.c);
    const float span = highest - lowest;
    const float range = duty_max - duty_min;
    const bool cut = span > range * u_dc;
    const float per_volt = cut ? range / span : 1.0f / u_dc;
    const float share = cut ? per_volt * u_dc : 1.0f;
    const float centre = 0.5f * (highest + lowest);
    const float middle = 0.5f * (duty_min + duty_max);
    return (svpwm_t){
        /* Between the limits but for rounding, which takes the clamps. */
        {lesser(greater(middle + (phases.a - centre) * per_volt, duty_min), duty_max),
         lesser(greater(middle + (phases.b - centre) * per_volt, duty_min), duty_max),
         lesser(greater(middle + (phases.c - centre) * per_volt, duty_min), duty_max)},
        {share * voltage.alpha, share * voltage.beta},
    };
}
