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
