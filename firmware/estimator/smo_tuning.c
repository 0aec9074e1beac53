/* The coefficients of the observer and their checks, for the background. */
#include "estimator/smo.h"

#include "math/check.h"
#include "math/exponential.h"

bool smo_params_check(const smo_params_t *params, params_error_t *why)
{
    if (!params_within(why, "resistance", PARAMS_RANGE, params->resistance, 1e-3f, 100.0f) ||
        !params_within(why, "inductance", PARAMS_RANGE, params->inductance, 1e-6f, 1.0f) ||
        !params_within(why, "gain", PARAMS_RANGE, params->gain, 0.1f, 1e4f) ||
        !params_within(why, "slope", PARAMS_RANGE, params->slope, 1e-3f, 1e3f) ||
        !params_within(why, "emf_cutoff", PARAMS_RANGE, params->emf_cutoff, 0.0f, 1e5f) ||
        !params_within(why, "period", PARAMS_RANGE, params->period, 1e-6f, 1e-2f) ||
        !params_within(why, "switching", PARAMS_RANGE, (float)params->switching, (float)SMO_SIGN,
                       (float)SMO_SIGMOID_VECTOR)) {
        return false;
    }

    float period_max = 0.5f * params->inductance / params->resistance;
    if (params->period > period_max) {
        return params_refuse(why, "period", "period <= inductance / (2 resistance)", params->period, 1e-6f,
                             period_max);
    }

    if (params->switching != SMO_SIGN) {
        float voltage_gain =
            exponential_rest(params->resistance * params->period / params->inductance) / params->resistance;
        float gain_max = 2.0f * SMO_LOOP_GAIN_MAX / (voltage_gain * params->slope);
        if (params->gain > gain_max) {
            return params_refuse(why, "gain", "loop gain per sample: b gain slope / 2 <= 1.2", params->gain,
                                 0.1f, gain_max);
        }
    }
    return true;
}

/* F(y) = y/(e^y - 1) = 1 - y/2 + y^2/12 - y^4/720 + y^6/30240 at d + s, as a series in s, over F(d): the
 * omitted terms are below 1e-6 for d <= 1/2. */
static void prepare_hold(float hold[4], float d)
{
    float d2 = d * d;
    float scale = 1.0f / (1.0f - 0.5f * d + d2 * (1.0f / 12.0f - d2 * (1.0f / 720.0f)));
    hold[0] = scale * (-0.5f + d * (1.0f / 6.0f - d2 * (1.0f / 180.0f)));
    hold[1] = scale * (1.0f / 12.0f - d2 * (1.0f / 120.0f - d2 * (1.0f / 2016.0f)));
    hold[2] = scale * d * (-1.0f / 180.0f + d2 * (1.0f / 1512.0f));
    hold[3] = scale * (-1.0f / 720.0f + d2 * (1.0f / 2016.0f));
}

void smo_prepare(smo_tuning_t *tuning, const smo_params_t *params)
{
    params_error_t why;
    CHECK(smo_params_check(params, &why));

    float decay = params->resistance * params->period / params->inductance;
    tuning->resistance = params->resistance;
    tuning->inductance = params->inductance;
    tuning->period = params->period;
    tuning->voltage_gain = exponential_rest(decay) / params->resistance;
    tuning->gain = params->gain;
    tuning->half_slope = 0.5f * params->slope;
    tuning->emf_decay = params->emf_cutoff > 0.0f ? exponential(-params->emf_cutoff * params->period) : 0.0f;
    prepare_hold(tuning->hold, decay);
    tuning->switching = (int32_t)params->switching;
    switching_prepare(&tuning->axes, params->slope, params->period, params->switching == SMO_SIGN);
}

void smo_init(smo_t *smo, const smo_params_t *params)
{
    const ab_t none = {0.0f, 0.0f};
    smo_tuning_t tuning;
    smo_prepare(&tuning, params);
    smo_take(smo, &tuning);
    smo_reset(smo, none, none);
}
