#include "math/filter.h"

#include "math/exponential.h"

void lowpass_init(lowpass_t *filter, float cutoff, float period)
{
    lowpass_reset(filter, 0.0f);
    lowpass_retune(filter, cutoff, period);
}

void lowpass_retune(lowpass_t *filter, float cutoff, float period)
{
    filter->alpha = exponential_rest(cutoff * period);
}

void lowpass_reset(lowpass_t *filter, float value)
{
    filter->value = value;
}

float lowpass_step(lowpass_t *filter, float input)
{
    filter->value += filter->alpha * (input - filter->value);
    return filter->value;
}
