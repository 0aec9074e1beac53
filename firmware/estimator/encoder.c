#include "estimator/encoder.h"

#include "math/angle.h"
#include "math/exponential.h"

/* Electrical angle of the middle of a count step [rad]. */
static float encoder_angle(const encoder_t *encoder, uint32_t count)
{
    uint32_t steps = encoder->count_per_turn;
    uint32_t whole = UINT32_C(2) * steps;
    uint32_t halves =
        (UINT32_C(2) * (count < steps ? count : steps - UINT32_C(1)) + UINT32_C(1)) * encoder->pole_pairs;

    /* The quotient is at most 32767 and its float estimate off by less than 0.01: one too large or one too
     * small at the very edge. Too large shows as a wrapped difference; too small leaves a rest just above
     * `whole`, which centring takes. */
    uint32_t quotient = (uint32_t)((float)halves * encoder->turn_per_count);
    uint32_t rest = halves - quotient * whole;
    if (rest >= UINT32_C(0x80000000)) {
        rest += whole;
    }

    float centred = (float)rest - (rest >= steps ? (float)whole : 0.0f);
    return angle_wrap(centred * encoder->angle_per_count + encoder->offset);
}

void encoder_init(encoder_t *encoder, const encoder_params_t *params)
{
    encoder_retune(encoder, params);
    encoder_reset(encoder, UINT32_C(0));
}

void encoder_retune(encoder_t *encoder, const encoder_params_t *params)
{
    float rest = exponential_rest(params->bandwidth * params->period);
    encoder->count_per_turn = (uint32_t)params->count_per_turn;
    encoder->pole_pairs = (uint32_t)params->pole_pairs;
    encoder->turn_per_count = 0.5f / params->count_per_turn;
    encoder->angle_per_count = ANGLE_PI / params->count_per_turn;
    encoder->offset = params->offset;
    encoder->angle_gain = rest * (2.0f - rest);
    encoder->speed_gain = rest * rest / params->period;
    encoder->period = params->period;
}

void encoder_reset(encoder_t *encoder, uint32_t count)
{
    encoder->theta_next = encoder_angle(encoder, count);
    encoder->omega_e = 0.0f;
}

position_t encoder_step(encoder_t *encoder, uint32_t count)
{
    position_t position;
    position.theta_e = encoder_angle(encoder, count);

    float error = angle_wrap(position.theta_e - encoder->theta_next);
    encoder->omega_e += encoder->speed_gain * error;
    encoder->theta_next =
        angle_wrap(encoder->theta_next + encoder->period * encoder->omega_e + encoder->angle_gain * error);
    position.omega_e = encoder->omega_e;
    return position;
}
