#include "fast/inverter/svpwm.h"

#include "math/root.h"

/* Span of a circle of the radius 1/sqrt(3), the largest within the hexagon, at a corner of the hexagon [-]; a
 * little less, so that no longer vector is missed. */
#define CORNER_SPAN 0.866f

/* gain^-2 over the square of the requested fundamental, both as shares of range u_dc: a parabola through 1 at
 * 1/3, the end of the linear range. Up to 0.99 of six-step the fundamental is within 0.5 % of the request. */
#define LINEAR_SQUARE  0.333333333f
#define GAIN_SLOPE     2.61149f
#define GAIN_CURVATURE 211.564f
#define GAIN_LEAST     0.1f /* of gain^-2: 0.996 of six-step */

svpwm_tuning_t svpwm_prepare(float duty_min, float duty_max, bool over)
{
    const float range = SVPWM_SHARE * (duty_max - duty_min);
    return (svpwm_tuning_t){0.5f * (duty_min + duty_max), range, over ? CORNER_SPAN * range : range, over};
}

/* Shortens the vector to the edge of the hexagon, without a change of its direction. */
static svpwm_t shortened(const svpwm_tuning_t *tuning, ab_t voltage, abc_t phases, float u_dc)
{
    const bounds_span_t ends = bounds_span(phases.a, phases.b, phases.c);
    const float centre = 0.5f * (ends.largest + ends.smallest);
    const float per_volt = tuning->range / (ends.largest - ends.smallest);
    const float middle = tuning->middle;
    const float share = per_volt * u_dc;
    return (svpwm_t){
        {middle + (phases.a - centre) * per_volt, middle + (phases.b - centre) * per_volt,
         middle + (phases.c - centre) * per_volt},
        {share * voltage.alpha, share * voltage.beta},
        true,
    };
}

/* The duty of one leg that is `share` of the range away from its middle. */
static float leg(const svpwm_tuning_t *tuning, float share)
{
    return tuning->middle + tuning->range * bounds_clamp(share, 0.5f);
}

svpwm_t svpwm_beyond(const svpwm_tuning_t *tuning, ab_t voltage, abc_t phases, float u_dc)
{
    if (!tuning->over) {
        return shortened(tuning, voltage, phases, u_dc);
    }
    const float per_volt = 1.0f / (tuning->range * u_dc);
    const ab_t asked = {per_volt * voltage.alpha, per_volt * voltage.beta};
    const float beyond = asked.alpha * asked.alpha + asked.beta * asked.beta - LINEAR_SQUARE;
    const bool over = beyond > 0.0f;
    const float falls = 1.0f + beyond * (GAIN_SLOPE - GAIN_CURVATURE * beyond);
    const float gain = over ? inverse_root(bounds_more(falls, GAIN_LEAST)) : 1.0f;
    const float scale = gain * per_volt;
    const bounds_span_t ends = bounds_span(phases.a, phases.b, phases.c);
    const float centre = 0.5f * (ends.largest + ends.smallest);
    const abc_t duty = {leg(tuning, scale * (phases.a - centre)), leg(tuning, scale * (phases.b - centre)),
                        leg(tuning, scale * (phases.c - centre))};
    const ab_t made = frames_clarke(duty);
    return (svpwm_t){duty, over ? (ab_t){u_dc * made.alpha, u_dc * made.beta} : voltage, over};
}
