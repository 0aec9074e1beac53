#include "math/pi.h"

void pi_init(pi_t *pi, float kp, float ki, float period)
{
    pi_reset(pi, 0.0f);
    pi_retune(pi, kp, ki, period);
}

void pi_retune(pi_t *pi, float kp, float ki, float period)
{
    pi->kp = kp;
    pi->ki_period = ki * period;
    if (pi->ki_period < kp) {
        pi->back_gain = pi->ki_period / kp;
    } else {
        pi->back_gain = pi->ki_period > 0.0f ? 1.0f : 0.0f;
    }
}

void pi_reset(pi_t *pi, float integral)
{
    pi->integral = integral;
}

float pi_output(const pi_t *pi, float error)
{
    return pi->kp * error + pi->integral;
}

void pi_update(pi_t *pi, float error, float shortfall)
{
    pi->integral += pi->ki_period * error + pi->back_gain * shortfall;
}

float pi_step(pi_t *pi, float error, float lower, float upper)
{
    float wanted = pi_output(pi, error);
    float applied = wanted;
    if (applied > upper) {
        applied = upper;
    } else if (applied < lower) {
        applied = lower;
    }
    pi_update(pi, error, applied - wanted);
    return applied;
}
