#include "adapt/dead_time_learn.h"

#include <stdbool.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

#define SAWTOOTH (12.0f / 35.0f) /* [-] sixth harmonic of the sawtooth, 1/5 + 1/7 */

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

/* What the three signs have across the current, by its direction [-]: the first of the sawtooth's harmonics,
 * in parts of what they have along it, 4/pi. */
static float sawtooth(ab_t unit)
{
    const float square_re = unit.alpha * unit.alpha - unit.beta * unit.beta;
    const float square_im = 2.0f * unit.alpha * unit.beta;
    const float cube_re = square_re * unit.alpha - square_im * unit.beta;
    const float cube_im = square_re * unit.beta + square_im * unit.alpha;
    return -SAWTOOTH * 2.0f * cube_re * cube_im;
}

/* A mean that turns by `turn` [rad] a period and follows the vector by `share`. */
static inline ab_t follow(ab_t mean, float turn, float share, ab_t vector)
{
    const ab_t turned = {mean.alpha - turn * mean.beta, mean.beta + turn * mean.alpha};
    return (ab_t){lowpass_step(turned.alpha, share, vector.alpha),
                  lowpass_step(turned.beta, share, vector.beta)};
}

static inline float cross(ab_t a, ab_t b)
{
    return a.alpha * b.beta - a.beta * b.alpha;
}

static inline float square_of(ab_t a)
{
    return a.alpha * a.alpha + a.beta * a.beta;
}

void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const float band = tuning->band * input->link;
    const float speed = bounds_magnitude(input->omega_e);
    const float square = square_of(input->current);
    if (!visible(learn, input, band, speed) || square < tuning->current_square) {
        learn->begun = 0u;
        return;
    }
    const float inverse = inverse_root(square);
    const ab_t newest = {inverse * input->current.alpha, inverse * input->current.beta};
    if (learn->begun == 0u) {
        learn->begun = 1u;
        learn->emf_mean = input->emf;
        learn->along_mean = newest;
        learn->along[0] = newest;
        learn->along[1] = newest;
        learn->along[2] = newest;
    }
    const float turn = tuning->period * input->omega_e_ref;
    const float share = tuning->period * speed;
    const ab_t along = learn->along[2]; /* whose noise is not in this EMF any more */
    learn->along[2] = learn->along[1];
    learn->along[1] = learn->along[0];
    learn->along[0] = newest;
    learn->emf_mean = follow(learn->emf_mean, turn, share, input->emf);
    learn->along_mean = follow(learn->along_mean, turn, share, along);

    const float due = DEAD_TIME_LEARN_AGREE * tuning->flux_linkage * speed;
    const float miss = tuning->flux_linkage * (input->omega_e_ref - input->omega_e);
    if (!bounds_within(miss, DEAD_TIME_LEARN_MISS * band) || square_of(learn->emf_mean) < due * due) {
        return;
    }
    const float across = cross(learn->along_mean, input->emf) - cross(learn->along_mean, learn->emf_mean);
    const float per_volt = inverse_root(input->link * input->link);
    const float wanted = learn->effective + tuning->rate * across * (cross(learn->along_mean, along) + sawtooth(along)) * per_volt;
    if (wanted >= tuning->least && wanted <= tuning->most) {
        learn->effective = wanted;
    }
}
