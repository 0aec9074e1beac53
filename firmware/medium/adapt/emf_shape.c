#include "medium/adapt/emf_shape.h"

#include "math/root.h"
#include "medium/adapt/gain.h"

void emf_shape_take(emf_shape_t *shape, const emf_shape_tuning_t *tuning)
{
    if (tuning->rate != shape->tuning.rate || tuning->rate == 0.0f) {
        shape->rate = tuning->rate;
    }
    if (tuning->rate == 0.0f) {
        shape->used = (dq_t){0.0f, 0.0f};
        shape->learnt = (dq_t){0.0f, 0.0f};
    }
    shape->tuning = *tuning;
}

/* The learnt value of one axis, from the present harmonic `line` and the amount seen after
 * subtraction of `taken`; all [-]. */
static float follow(float learnt, float taken, float share, float seen, float line)
{
    const float missed = seen + (taken - learnt) * line;
    return bounds_clamp(learnt + 2.0f * share * missed * line, EMF_SHAPE_MAX);
}

void emf_shape_step(emf_shape_t *shape, const emf_shape_input_t *input)
{
    const ab_t mean = input->emf_mean;
    const float per_emf = inverse_root(mean.alpha * mean.alpha + mean.beta * mean.beta);
    const float due = shape->tuning.flux_linkage * input->omega_e;
    const float per_due = inverse_root(due * due);
    const ab_t along = {per_emf * mean.alpha, per_emf * mean.beta};
    const ab_t sixth = sixth_power(along);
    const float across = per_due * (along.alpha * input->rest.beta - along.beta * input->rest.alpha);
    const float beyond = per_due * (along.alpha * input->rest.alpha + along.beta * input->rest.beta);
    const float share = shape->rate * input->time;
    const dq_t taken = {input->taken * shape->used.d, input->taken * shape->used.q};
    shape->learnt.d = follow(shape->learnt.d, taken.d, share, across, -sixth.beta);
    shape->learnt.q = follow(shape->learnt.q, taken.q, share, beyond, -sixth.alpha);
    shape->rate = gain_step(shape->rate, shape->tuning.rate, input->time);
    const float chance = gain_chance(EMF_SHAPE_CHANCE, shape->rate * shape->tuning.per_rate, GAIN_LEAST);
    shape->used = (dq_t){gain_beyond(shape->learnt.d, chance), gain_beyond(shape->learnt.q, chance)};
}
