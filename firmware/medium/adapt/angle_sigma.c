#include "medium/adapt/angle_sigma.h"

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

#define LEG_SQUARE      1.6211389f  /* (4/pi)^2 [-] */
#define UNIFORM         0.28867513f /* 1/sqrt 12: standard deviation of an angle within a count [-] */
#define SAWTOOTH_SQUARE 0.05877551f /* (12/35)^2/2 [-] */

static float reciprocal_or_none(float x)
{
    return x > 0.0f ? 1.0f / x : 0.0f;
}

angle_sigma_tuning_t angle_sigma_prepare(const angle_sigma_params_t *params)
{
    return (angle_sigma_tuning_t){
        .data_square = params->data * params->data,
        .resistance_square = params->resistance * params->resistance,
        .inductance_square = params->inductance_q * params->inductance_q,
        .band = params->band,
        .ripple = 0.125f * params->period / params->inductance_d,
        .follow_square = params->kp * params->kp,
        .noise_share = 0.5f * params->period * (params->kp + params->ki / params->kp),
        .mean_share = lowpass_share(1.0f / ANGLE_SIGMA_MEAN_TIME, params->window),
        .zone_square = params->zone * params->zone,
        .per_leg_rate = reciprocal_or_none(params->leg_rate),
        .per_inductance_rate = reciprocal_or_none(params->inductance_rate),
        .encoder = UNIFORM * params->encoder,
        .window = params->window,
    };
}

void angle_sigma_reset(angle_sigma_t *sigma, float known)
{
    sigma->lag = 0.0f;
    sigma->square = 0.0f;
    sigma->drifted = 0.0f;
    sigma->sigma = known;
}

static inline float square_of(float x)
{
    return x * x;
}

/* u^2 over the square of the value, for a value that is learnt with this rate [1/s], with the noise `learnt`
 * [-] at first. */
static inline float uncertain(const angle_sigma_tuning_t *tuning, float rate, float per_rate, float learnt)
{
    if (per_rate == 0.0f) {
        return tuning->data_square;
    }
    const float share = per_rate * rate;
    const float third = share * square_of(share);
    return square_of(square_of(third)) * tuning->data_square + share * square_of(learnt);
}

/* The share that a positive number has of its sum with another one that is not negative [-]. */
static inline float share_of(float part, float rest)
{
    return part / (part + rest);
}

/* Square of the component of the EMF's error that is perpendicular to the EMF [V^2]. */
static inline float across(const angle_sigma_tuning_t *tuning, const angle_sigma_input_t *input)
{
    const float d_square = square_of(input->current.d);
    const float q_square = square_of(input->current.q);
    const float omega_square = square_of(input->omega_e);
    const float reactance_square = omega_square * tuning->inductance_square;
    const float amount = d_square + q_square + tuning->zone_square;
    const float along_d = share_of(d_square + tuning->zone_square, q_square);
    const float sixth = share_of(tuning->follow_square, 36.0f * omega_square);
    const float ripple = share_of(square_of(tuning->ripple * input->link), amount);
    const float leg =
        LEG_SQUARE * square_of(tuning->band * input->link) * (along_d + SAWTOOTH_SQUARE * sixth);
    const float of_leg = uncertain(tuning, input->leg_rate, tuning->per_leg_rate, ANGLE_SIGMA_V_LEARNT) +
                         square_of(ANGLE_SIGMA_V_UNUSED * input->leg_rate * tuning->per_leg_rate) +
                         square_of(ANGLE_SIGMA_V_RIPPLE) * ripple;
    const float of_l =
        uncertain(tuning, input->inductance_rate, tuning->per_inductance_rate, ANGLE_SIGMA_L_LEARNT);
    const float of_r =
        uncertain(tuning, input->resistance_rate, tuning->per_inductance_rate, ANGLE_SIGMA_R_LEARNT);
    return leg * of_leg + reactance_square * (q_square * of_l + amount * square_of(ANGLE_SIGMA_GAIN)) +
           tuning->resistance_square * d_square * of_r;
}

/* Square of the loop's lag in a window, less the part that noise causes [rad^2]. Without an EMF it is 1. */
static inline float lag_square(const angle_sigma_input_t *input)
{
    const float d_square = square_of(input->emf.d);
    const float whole = d_square + square_of(input->emf.q);
    return whole > 0.0f ? d_square / whole - input->noise * input->scatter : 1.0f;
}

void angle_sigma_step(angle_sigma_t *sigma, const angle_sigma_tuning_t *tuning,
                      const angle_sigma_input_t *input)
{
    const float turned = tuning->window * bounds_magnitude(input->omega_e);
    sigma->drifted = input->coasted != 0u ? sigma->drifted + ANGLE_SIGMA_DRIFT * turned : 0.0f;
    sigma->lag = lowpass_step(sigma->lag, tuning->mean_share, lag_square(input));
    sigma->square = lowpass_step(sigma->square, tuning->mean_share, input->scatter);
    const float lag = sigma->lag > 0.0f ? sigma->lag : 0.0f;
    const float variance = across(tuning, input) / square_of(input->amplitude) + lag +
                           tuning->noise_share * sigma->square + square_of(sigma->drifted) +
                           square_of(ANGLE_SIGMA_LEAST);
    const bool known = variance < square_of(ANGLE_SIGMA_UNKNOWN); /* the comparison is also false for NaN */
    sigma->sigma = known ? root_or_none(variance) : ANGLE_SIGMA_UNKNOWN;
}
