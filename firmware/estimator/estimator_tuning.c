/* The coefficients of the estimator and their checks, for the background. */
#include "estimator/estimator.h"

#include "math/check.h"

estimator_parts_t estimator_parts(const estimator_params_t *params)
{
    estimator_parts_t parts;
    parts.observer = (observer_params_t){.smo = params->smo, .lag = params->lag};
    parts.tracker = (tracker_params_t){.pll = params->pll,
                                       .flux_linkage = params->flux_linkage,
                                       .saliency = params->saliency,
                                       .torque_feedforward = params->torque_feedforward,
                                       .saturation = params->saturation,
                                       .validity = params->validity};
    if (params->lag == LAG_EXACT) {
        parts.tracker.pll.emf_cutoff = params->smo.emf_cutoff;
        parts.observer.smo.emf_cutoff = 0.0f;
    }
    return parts;
}

bool estimator_params_check(const estimator_params_t *params, params_error_t *why)
{
    const estimator_parts_t parts = estimator_parts(params);
    if (!smo_params_check(&params->smo, why) || !pll_params_check(&parts.tracker.pll, why) ||
        !params_within(why, "lag", PARAMS_RANGE, (float)params->lag, (float)LAG_NONE, (float)LAG_EXACT) ||
        !params_within(why, "flux_linkage", PARAMS_RANGE, params->flux_linkage, 1e-4f, 10.0f) ||
        !params_within(why, "saliency", PARAMS_RANGE, params->saliency, -1.0f, 1.0f) ||
        !params_within(why, "flux_adaptation", PARAMS_RANGE, params->flux_adaptation, 0.0f, 100.0f) ||
        !params_within(why, "torque_feedforward", PARAMS_RANGE, params->torque_feedforward, 0.0f,
                       ESTIMATOR_TORQUE_FEEDFORWARD_MAX) ||
        !validity_params_check(&params->validity, why)) {
        return false;
    }

    float period = params->smo.period;
    if (params->pll.period != period) {
        return params_refuse(why, "period", "pll.period = smo.period", params->pll.period, period, period);
    }
    const bool more = params->flux_most > params->flux_linkage;
    const float flux = more ? params->flux_most : params->flux_linkage;
    const float gain_min = ESTIMATOR_GAIN_MARGIN * flux * params->validity.speed_max;
    if (params->smo.gain < gain_min) {
        return params_refuse(why, "gain",
                             "gain >= 1.1 times the largest EMF, flux_linkage speed_max, or flux_most",
                             params->smo.gain, gain_min, 1e4f);
    }
    if (params->torque_feedforward > 0.0f && params->pll.feedforward_cutoff == 0.0f) {
        return params_refuse(why, "torque_feedforward",
                             "0 with feedforward_cutoff = 0, else its error does not decay",
                             params->torque_feedforward, 0.0f, 0.0f);
    }
    return true;
}

void estimator_prepare(estimator_tuning_t *tuning, const estimator_params_t *params)
{
    params_error_t why;
    CHECK(estimator_params_check(params, &why));

    const estimator_parts_t parts = estimator_parts(params);
    observer_prepare(&tuning->observer, &parts.observer);
    tracker_prepare(&tuning->tracker, &parts.tracker);
}

void estimator_init(estimator_t *est, const estimator_params_t *params)
{
    const position_t origin = {0.0f, 0.0f};
    const ab_t none = {0.0f, 0.0f};
    estimator_tuning_t tuning;
    estimator_prepare(&tuning, params);
    estimator_take(est, &tuning);
    estimator_reset(est, origin, none);
}
