#include "math/frames.h"

#define ONE_THIRD       0.333333333f
#define ONE_OVER_SQRT_3 0.577350269f
#define HALF_OF_SQRT_3  0.866025404f

ab_t frames_clarke(abc_t phases)
{
    ab_t stationary;
    /* Differences first: what is common to the three cancels without rounding. */
    stationary.alpha = ((phases.a - phases.b) + (phases.a - phases.c)) * ONE_THIRD;
    stationary.beta = (phases.b - phases.c) * ONE_OVER_SQRT_3;
    return stationary;
}

ab_t frames_clarke_two(float a, float b)
{
    ab_t stationary;
    stationary.alpha = a;
    stationary.beta = (a + 2.0f * b) * ONE_OVER_SQRT_3;
    return stationary;
}

abc_t frames_inverse_clarke(ab_t stationary)
{
    float along = -0.5f * stationary.alpha;
    float across = HALF_OF_SQRT_3 * stationary.beta;
    abc_t phases;
    phases.a = stationary.alpha;
    phases.b = along + across;
    phases.c = along - across;
    return phases;
}

dq_t frames_park(ab_t stationary, rotation_t angle)
{
    dq_t rotor;
    rotor.d = stationary.alpha * angle.cos + stationary.beta * angle.sin;
    rotor.q = stationary.beta * angle.cos - stationary.alpha * angle.sin;
    return rotor;
}

ab_t frames_inverse_park(dq_t rotor, rotation_t angle)
{
    ab_t stationary;
    stationary.alpha = rotor.d * angle.cos - rotor.q * angle.sin;
    stationary.beta = rotor.d * angle.sin + rotor.q * angle.cos;
    return stationary;
}
