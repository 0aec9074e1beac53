#include "adapt/unequal_legs.h"

#include "adapt/gain.h"
#include "math/bounds.h"
#include "math/root.h"

#define PER_THIRD 4.71238898f /* [-] 3 pi/2: difference of the voltage over its line at three times the current */
#define PER_AGAINST 2.0f /* [-] difference of the resistance over its line against the current */

void unequal_legs_take(unequal_legs_t *legs, const unequal_legs_tuning_t *tuning)
{
    if (tuning->rate != legs->tuning.rate || tuning->rate == 0.0f) {
        legs->rate = tuning->rate;
    }
    if (tuning->rate == 0.0f) {
        legs->voltage = (ab_t){0.0f, 0.0f};
        legs->resistance = (ab_t){0.0f, 0.0f};
    }
    legs->tuning = *tuning;
}

static inline ab_t product(ab_t a, ab_t b)
{
    return (ab_t){a.alpha * b.alpha - a.beta * b.beta, a.alpha * b.beta + a.beta * b.alpha};
}

void unequal_legs_step(unequal_legs_t *legs, const unequal_legs_input_t *input)
{
    const unequal_legs_tuning_t *tuning = &legs->tuning;
    const ab_t current = input->current;
    const float per_ampere = inverse_root(current.alpha * current.alpha + current.beta * current.beta);
    const ab_t along = {per_ampere * current.alpha, per_ampere * current.beta};
    const ab_t against = product(input->rest, along);
    const ab_t third = product(against, product(along, along));
    const float share = legs->rate * input->time;
    const float volt = PER_THIRD * share;
    const float ohm = PER_AGAINST * share * per_ampere;
    legs->voltage.alpha = bounds_clamp(legs->voltage.alpha - volt * third.alpha, tuning->voltage_max);
    legs->voltage.beta = bounds_clamp(legs->voltage.beta - volt * third.beta, tuning->voltage_max);
    legs->resistance.alpha = bounds_clamp(legs->resistance.alpha + ohm * against.alpha, tuning->resistance_max);
    legs->resistance.beta = bounds_clamp(legs->resistance.beta - ohm * against.beta, tuning->resistance_max);
    legs->rate = gain_step(legs->rate, tuning->rate, input->time);
}
