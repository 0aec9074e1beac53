#include "adapt/emf_shape.h"

#include "adapt/gain.h"
#include "math/root.h"

void emf_shape_take(emf_shape_t *shape, const emf_shape_tuning_t *tuning)
{
    if (tuning->rate != shape->tuning.rate || tuning->rate == 0.0f) {
        shape->rate = tuning->rate;
    }
    if (tuning->rate == 0.0f) {
        shape->d = 0.0f;
        shape->learnt = 0.0f;
    }
    shape->tuning = *tuning;
}

void emf_shape_step(emf_shape_t *shape, const emf_shape_input_t *input)
{
    const ab_t mean = input->emf_mean;
    const float per_emf = inverse_root(mean.alpha * mean.alpha + mean.beta * mean.beta);
    const float due = shape->tuning.flux_linkage * input->omega_e;
    const float per_due = inverse_root(due * due);
    const ab_t rotor = {per_emf * mean.alpha, per_emf * mean.beta};
    const float line = -sixth_power(rotor).beta;
    const float seen = per_due * (rotor.alpha * input->rest.beta - rotor.beta * input->rest.alpha);
    const float missed = seen + (input->taken * shape->d - shape->learnt) * line;
    const float wanted = shape->learnt + 2.0f * shape->rate * input->time * missed * line;
    shape->learnt = bounds_clamp(wanted, EMF_SHAPE_MAX);
    shape->rate = gain_step(shape->rate, shape->tuning.rate, input->time);
    shape->d = gain_beyond(shape->learnt,
                           gain_chance(EMF_SHAPE_CHANCE, shape->rate * shape->tuning.per_rate, GAIN_LEAST));
}
