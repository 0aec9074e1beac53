#include "estimator/encoder.h"

#include <stdbool.h>

#include "math/exponential.h"

#define STEPS_PER_TURN   4294967296.0f
#define STEPS_PER_RADIAN (STEPS_PER_TURN / ANGLE_TWO_PI)

void encoder_prepare(encoder_tuning_t *tuning, const encoder_params_t *params)
{
    const uint64_t count_per_turn = (uint64_t)(uint32_t)params->count_per_turn;
    const uint64_t pole_pairs = (uint64_t)(uint32_t)params->pole_pairs;
    const uint64_t per_count = (pole_pairs << 48) / count_per_turn;
    const float offset = angle_wrap(params->offset) * STEPS_PER_RADIAN;
    const float rest = exponential_rest(params->bandwidth * params->period);
    tuning->last_count = (uint32_t)params->count_per_turn - UINT32_C(1);
    tuning->steps_per_count = (uint32_t)(per_count >> 16);
    tuning->rest_per_count = (uint32_t)per_count & UINT32_C(0xFFFF);
    tuning->first = (uint32_t)(int32_t)offset + (uint32_t)(per_count >> 17);
    tuning->angle_gain = rest * (2.0f - rest);
    tuning->speed_gain = rest * rest / params->period / STEPS_PER_RADIAN;
    tuning->step_gain = params->period * STEPS_PER_RADIAN;
}

float encoder_missed_most(const encoder_tuning_t *tuning, float acceleration)
{
    const float counts = 2.0f * (float)tuning->steps_per_count;
    const float period = tuning->step_gain / STEPS_PER_RADIAN;
    return ENCODER_ANGLE_PER_STEP * (counts + acceleration * period / tuning->speed_gain);
}

bool encoder_may_brake(const encoder_t *encoder, const encoder_tuning_t *tuning)
{
    const float error = encoder->missed * (1.0f / ENCODER_ANGLE_PER_STEP);
    const float moved = tuning->step_gain * (encoder->omega_e - tuning->speed_gain * error);
    const float least = 0.5f * tuning->angle_gain * bounds_magnitude(error); /* r (1 - r/2) |m| */
    return error < 0.0f ? moved > least : moved < -least;
}

void encoder_follow(encoder_t *encoder, const encoder_tuning_t *tuning, uint32_t count, float omega_e)
{
    encoder->next = encoder_phase(tuning, count) + (uint32_t)(int32_t)(tuning->step_gain * omega_e);
    encoder->omega_e = omega_e;
    encoder->missed = 0.0f;
}

void encoder_reset(encoder_t *encoder, const encoder_tuning_t *tuning, uint32_t count)
{
    encoder->next = encoder_phase(tuning, count);
    encoder->omega_e = 0.0f;
    encoder->missed = 0.0f;
}

static bool same_angles(const encoder_tuning_t *a, const encoder_tuning_t *b)
{
    return a->last_count == b->last_count && a->steps_per_count == b->steps_per_count &&
           a->rest_per_count == b->rest_per_count && a->first == b->first;
}

void encoder_take(encoder_t *encoder, const encoder_tuning_t *before, const encoder_tuning_t *tuning,
                  uint32_t count)
{
    if (!same_angles(before, tuning)) {
        encoder_reset(encoder, tuning, count);
    }
}
