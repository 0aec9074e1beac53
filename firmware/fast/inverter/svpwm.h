/* Space-vector modulation: duties of the three legs from a voltage in the stationary frame, with a min-max
 * zero sequence.
 *
 *     duty_x = middle + (v_x - (max(v) + min(v))/2) / u_dc,   middle = (duty_min + duty_max)/2
 *
 * The highest and the lowest leg are symmetrical about the middle of the allowed range, which equals
 * space-vector modulation with equal zero vectors. The modulation is linear up to (duty_max - duty_min)
 * u_dc/sqrt(3) in every direction (180 V at 311 V and 0..1), and up to 2/sqrt(3) times that in the corners of
 * the hexagon. A longer vector keeps its direction and is shortened to the edge of the hexagon.
 *
 * With over-modulation the legs of a longer vector are limited one by one instead,
 *
 *     duty_x = middle + clamp(gain (v_x - (max(v) + min(v))/2)/u_dc, +-range/2)
 *
 * with the gain that keeps the fundamental equal to the request, up to six-step: 2/pi range u_dc. The result
 * leaves the direction of the request by up to 30 degrees, sixfold per turn (docs/theory.md, 16).
 *
 * No state; the duties act one period later (docs/theory.md, 2). Does not handle: minimum pulses other than
 * by duty_min and duty_max. */
#ifndef FAST_INVERTER_SVPWM_H
#define FAST_INVERTER_SVPWM_H

#include <stdbool.h>

#include "math/bounds.h"
#include "math/frames.h"

/* Largest accepted sum of the amounts; sums of three larger voltages could overflow [V]. */
#define SVPWM_VOLTAGE_LIMIT 1e30f

/* Below this voltage the reciprocal is not finite [V]. */
#define SVPWM_U_DC_LEAST 1e-37f

/* Share of the range of duties that is used [-]: the remainder on either side is more than the rounding of a
 * duty, 2e-7, so that no duty exceeds its limit. */
#define SVPWM_SHARE (1.0f - 8e-7f)

typedef struct {
    abc_t duty;   /* share of the period for which the upper switch of each leg is on [-] */
    ab_t voltage; /* mean voltage of these duties at this u_dc, ideal inverter [V]: the requested one, or
                     shorter */
    bool cut;     /* the voltage is shorter than requested */
} svpwm_t;

/* The duties that a leg may have. */
typedef struct {
    float middle; /* of the range [-] */
    float range;  /* width of the used part [-] */
    float inside; /* span of the phase voltages over u_dc that needs no change of the vector [-] */
    bool over;    /* over-modulation */
} svpwm_tuning_t;

/* The duties of a leg from duty_min to duty_max, 0 <= duty_min <= duty_max <= 1 [-]. */
svpwm_tuning_t svpwm_prepare(float duty_min, float duty_max, bool over);

/* The rest of svpwm_modulate() where the span exceeds `inside` u_dc. `phases`: the voltage of each leg [V].
 * One division, and one for a vector that is shortened. */
svpwm_t svpwm_beyond(const svpwm_tuning_t *tuning, ab_t voltage, abc_t phases, float u_dc);

/* Duties for `voltage` [V] at the DC link `u_dc` [V], each within the range of this tuning. If no voltage can
 * be made (u_dc <= 0 or below 1e-37 V, one of the three not finite, or their amounts together above 1e30 V),
 * all duties are 0.5, which is zero voltage, and `cut` is true. One division. */
static inline svpwm_t svpwm_modulate(const svpwm_tuning_t *tuning, ab_t voltage, float u_dc)
{
    const float together = bounds_magnitude(voltage.alpha) + bounds_magnitude(voltage.beta) + u_dc;
    if (!(u_dc >= SVPWM_U_DC_LEAST && together <= SVPWM_VOLTAGE_LIMIT)) {
        return (svpwm_t){{0.5f, 0.5f, 0.5f}, {0.0f, 0.0f}, true};
    }
    const abc_t phases = frames_inverse_clarke(voltage);
    const bounds_span_t ends = bounds_span(phases.a, phases.b, phases.c);
    if (ends.largest - ends.smallest > tuning->inside * u_dc) {
        return svpwm_beyond(tuning, voltage, phases, u_dc);
    }
    const float per_volt = 1.0f / u_dc;
    const float centre = 0.5f * (ends.largest + ends.smallest);
    const float middle = tuning->middle;
    return (svpwm_t){
        {middle + (phases.a - centre) * per_volt, middle + (phases.b - centre) * per_volt,
         middle + (phases.c - centre) * per_volt},
        voltage,
        false,
    };
}

#endif
