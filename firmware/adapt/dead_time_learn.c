#include "adapt/dead_time_learn.h"

#include <stdbool.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

dead_time_learn_tuning_t dead_time_learn_prepare(const dead_time_learn_params_t *params)
{
    const float effective = params->effective;
    const float current = DEAD_TIME_LEARN_ZONES * params->zone;
    return (dead_time_learn_tuning_t){
        .rate = params->rate * params->period / DEAD_TIME_LEARN_POWER,
        .effective = effective,
        .least = effective < 0.0f ? effective : 0.0f,
        .most = DEAD_TIME_LEARN_RANGE * (effective > params->band ? effective : params->band),
        .band = params->band,
        .flux_linkage = params->flux_linkage,
        .current_square = current * current,
        .period = params->period,
    };
}

void dead_time_learn_take(dead_time_learn_t *learn, const dead_time_learn_tuning_t *tuning)
{
    const bool same = tuning->effective == learn->tuning.effective && tuning->band == learn->tuning.band;
    if (!same || tuning->rate == 0.0f) {
        learn->effective = tuning->effective;
        learn->begun = 0u;
    }
    learn->tuning = *tuning;
}

/* Is there something to be seen, at this dead band's voltage [V] and speed [rad/s]? */
static bool visible(const dead_time_learn_t *learn, const dead_time_learn_input_t *input, float band,
                    float speed)
{
    const float emf = learn->tuning.flux_linkage * speed;
    const float together = bounds_magnitude(input->emf.alpha) + bounds_magnitude(input->emf.beta) +
                           bounds_magnitude(input->current.alpha) + bounds_magnitude(input->current.beta);
    return DEAD_TIME_LEARN_EMF_MIN * band < emf && emf < DEAD_TIME_LEARN_EMF_MAX * band &&
           together < DEAD_TIME_LEARN_EMF_LIMIT;
}

/* Sine of six times the angle of a vector whose length is 1. */
static inline float sixfold(ab_t unit)
{
    const float square_re = unit.alpha * unit.alpha - unit.beta * unit.beta;
    const float square_im = 2.0f * unit.alpha * unit.beta;
    const float cube_re = square_re * unit.alpha - square_im * unit.beta;
    const float cube_im = square_re * unit.beta + square_im * unit.alpha;
    return 2.0f * cube_re * cube_im;
}

/* The mean turns on with the reference, whose speed has no ripple, and follows the EMF. */
static void follow(dead_time_learn_t *learn, const dead_time_learn_input_t *input, float speed)
{
    const float share = learn->tuning.period * speed;
    const float turn = learn->tuning.period * input->omega_e_ref;
    const ab_t mean = learn->emf_mean;
    const ab_t turned = {mean.alpha - turn * mean.beta, mean.beta + turn * mean.alpha};
    learn->emf_mean = learn->begun == 0u ? input->emf
                                         : (ab_t){lowpass_step(turned.alpha, share, input->emf.alpha),
                                                  lowpass_step(turned.beta, share, input->emf.beta)};
    learn->begun = 1u;
}

void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const float band = tuning->band * input->link;
    const float speed = bounds_magnitude(input->omega_e);
    if (!visible(learn, input, band, speed)) {
        learn->begun = 0u;
        return;
    }
    follow(learn, input, speed);

    const ab_t mean = learn->emf_mean;
    const ab_t current = input->current;
    const float due = DEAD_TIME_LEARN_AGREE * tuning->flux_linkage * speed;
    const float square = current.alpha * current.alpha + current.beta * current.beta;
    const float miss = tuning->flux_linkage * (input->omega_e_ref - input->omega_e);
    if (!bounds_within(miss, DEAD_TIME_LEARN_MISS * band) || square < tuning->current_square ||
        mean.alpha * mean.alpha + mean.beta * mean.beta < due * due) {
        return;
    }
    const float inverse = inverse_root(square);
    const ab_t unit = {inverse * current.alpha, inverse * current.beta};
    const float across =
        unit.alpha * (input->emf.beta - mean.beta) - unit.beta * (input->emf.alpha - mean.alpha);
    const float per_volt = inverse_root(input->link * input->link);
    const float wanted = learn->effective - tuning->rate * across * sixfold(unit) * per_volt;
    if (wanted >= tuning->least && wanted <= tuning->most) {
        learn->effective = wanted;
    }
}
