#include "math/pi.h"

pi_tuning_t pi_prepare(float kp, float ki, float period)
{
    pi_tuning_t tuning = {kp, ki * period, 0.0f};
    if (tuning.ki_period < kp) {
        tuning.back_gain = tuning.ki_period / kp;
    } else {
        tuning.back_gain = tuning.ki_period > 0.0f ? 1.0f : 0.0f;
    }
    return tuning;
}

void pi_init(pi_t *pi, const pi_tuning_t *tuning)
{
    pi_take(pi, tuning);
    pi_reset(pi, 0.0f);
}

void pi_reset(pi_t *pi, float integral)
{
    pi->integral = integral;
}
