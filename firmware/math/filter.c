#include "math/filter.h"

#include "math/exponential.h"

float lowpass_share(float cutoff, float period)
{
    return exponential_rest(cutoff * period);
}
