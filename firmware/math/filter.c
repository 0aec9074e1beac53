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
