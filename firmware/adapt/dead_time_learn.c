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
        .rate = params->rate * params->period / (DEAD_TIME_LEARN_POWER * params->zone),
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

static inline float cross(dq_t vector, dq_t current)
{
    return vector.q * current.d - vector.d * current.q;
}

/* What is left of a vector without its mean, which follows it by this share. */
static inline dq_t without_mean(dq_t *mean, dq_t vector, float share)
{
    mean->d = lowpass_step(mean->d, share, vector.d);
    mean->q = lowpass_step(mean->q, share, vector.q);
    return (dq_t){vector.d - mean->d, vector.q - mean->q};
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
    const dq_t emf = frames_park(input->emf, input->rotation);
    const dq_t cut = frames_park(input->cut, input->rotation);
    if (learn->begun == 0u) {
        learn->begun = 1u;
        learn->emf_mean = emf;
        learn->cut_mean = cut;
    }
    const dq_t current = frames_park(input->current, input->rotation);
    const float share = tuning->period * speed;
    const float across = cross(without_mean(&learn->emf_mean, emf, share), current) *
                         cross(without_mean(&learn->cut_mean, cut, share), current);

    const float due = DEAD_TIME_LEARN_AGREE * tuning->flux_linkage * speed;
    const dq_t mean = learn->emf_mean;
    const float square = current.d * current.d + current.q * current.q;
    const bool settled =
        bounds_within(tuning->flux_linkage * input->omega_e_miss, DEAD_TIME_LEARN_MISS * band) &&
        mean.d * mean.d + mean.q * mean.q > due * due && square > tuning->current_square;
    if (!settled) {
        return;
    }
    const float scale = square * input->link;
    const float wanted = learn->effective + tuning->rate * across * inverse_root(scale * scale);
    if (wanted >= tuning->least && wanted <= tuning->most) {
        learn->effective = wanted;
    }
}
