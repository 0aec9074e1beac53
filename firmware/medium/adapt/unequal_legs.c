#include "medium/adapt/unequal_legs.h"

#include "math/bounds.h"
#include "math/root.h"
#include "medium/adapt/gain.h"

/* 3 pi/2: difference of the voltage over its line at three times the current [-]; difference of the
 * resistance over its line against the current [-]. */
#define PER_THIRD   4.71238898f
#define PER_AGAINST 2.0f

void unequal_legs_take(unequal_legs_t *legs, const unequal_legs_tuning_t *tuning)
{
    if (tuning->rate != legs->tuning.rate || tuning->rate == 0.0f) {
        legs->rate = tuning->rate;
    }
    if (tuning->rate == 0.0f) {
        const unequal_leg_t none = {{0.0f, 0.0f}, {0.0f, 0.0f}};
        legs->voltage = none;
        legs->resistance = none;
    }
    legs->tuning = *tuning;
}

static inline ab_t product(ab_t a, ab_t b)
{
    return (ab_t){a.alpha * b.alpha - a.beta * b.beta, a.alpha * b.beta + a.beta * b.alpha};
}

/* Moves the learnt value by `share` [-] towards the sum of the value in use and the remaining error. */
static void follow(unequal_leg_t *leg, float share, ab_t missed, float taken, float most)
{
    const ab_t wrong = {missed.alpha + taken * leg->used.alpha - leg->seen.alpha,
                        missed.beta + taken * leg->used.beta - leg->seen.beta};
    leg->seen.alpha = bounds_clamp(leg->seen.alpha + share * wrong.alpha, most);
    leg->seen.beta = bounds_clamp(leg->seen.beta + share * wrong.beta, most);
}

static void use(unequal_leg_t *leg, float chance)
{
    leg->used = (ab_t){gain_beyond(leg->seen.alpha, chance), gain_beyond(leg->seen.beta, chance)};
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
    const float ohm = PER_AGAINST * per_ampere;
    const ab_t voltage = {-PER_THIRD * third.alpha, -PER_THIRD * third.beta};
    const ab_t resistance = {ohm * against.alpha, -ohm * against.beta};
    follow(&legs->voltage, share, voltage, input->taken, tuning->voltage_max);
    follow(&legs->resistance, share, resistance, input->taken, tuning->resistance_max);
    legs->rate = gain_step(legs->rate, tuning->rate, input->time);
    const float rate = legs->rate * tuning->per_rate;
    use(&legs->voltage, gain_chance(tuning->voltage_chance, rate, GAIN_LEAST));
    use(&legs->resistance, gain_chance(tuning->resistance_chance, rate, GAIN_LEAST));
}

ab_t unequal_legs_voltage(const unequal_legs_t *legs, float share, ab_t current)
{
    const abc_t phases = frames_inverse_clarke(current);
    const abc_t more = frames_inverse_clarke(legs->voltage.used);
    const abc_t resistance = frames_inverse_clarke(legs->resistance.used);
    const float per_zone = legs->tuning.per_zone;
    const abc_t lost = {more.a * bounds_clamp(per_zone * phases.a, 1.0f) + resistance.a * phases.a,
                        more.b * bounds_clamp(per_zone * phases.b, 1.0f) + resistance.b * phases.b,
                        more.c * bounds_clamp(per_zone * phases.c, 1.0f) + resistance.c * phases.c};
    const ab_t vector = frames_clarke(lost);
    return (ab_t){share * vector.alpha, share * vector.beta};
}
