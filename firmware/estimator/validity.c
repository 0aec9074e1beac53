#include "estimator/validity.h"

#include "math/periods.h"

/* A limit above every value: not judged. */
#define UNLIMITED 1e30f

bool validity_params_check(const validity_params_t *params, params_error_t *why)
{
    if (!params_within(why, "amplitude_min", PARAMS_RANGE, params->amplitude_min, 0.0f, 1.0f) ||
        !params_within(why, "detector_max", PARAMS_RANGE, params->detector_max, 0.0f, 1.0f) ||
        !params_within(why, "current_max", PARAMS_RANGE, params->current_max, 0.0f, 1e3f) ||
        !params_within(why, "speed_max", PARAMS_RANGE, params->speed_max, 0.0f, 1e6f) ||
        !params_within(why, "speed_min", PARAMS_RANGE, params->speed_min, 0.0f, 1e6f) ||
        !params_within(why, "amplitude_time", PARAMS_RANGE, params->amplitude_time, 0.0f, 10.0f) ||
        !params_within(why, "detector_time", PARAMS_RANGE, params->detector_time, 0.0f, 10.0f) ||
        !params_within(why, "current_time", PARAMS_RANGE, params->current_time, 0.0f, 10.0f) ||
        !params_within(why, "speed_time", PARAMS_RANGE, params->speed_time, 0.0f, 10.0f)) {
        return false;
    }
    if (params->amplitude_max != 0.0f && !(params->amplitude_max > 1.0f && params->amplitude_max <= 100.0f)) {
        return params_refuse(why, "amplitude_max", "0 (not judged), or 1 < amplitude_max <= 100",
                             params->amplitude_max, 1.0f, 100.0f);
    }
    return params->speed_max == 0.0f || params->speed_min < params->speed_max ||
           params_refuse(why, "speed_min", "speed_min < speed_max", params->speed_min, 0.0f,
                         params->speed_max);
}

static float limit_of(float value)
{
    return value > 0.0f ? value : UNLIMITED;
}

void validity_prepare_debounce(debounce_tuning_t *tuning, const validity_params_t *params, float period)
{
    tuning->limit[0] = periods_beyond(params->amplitude_time, period);
    tuning->limit[1] = periods_beyond(params->detector_time, period);
    tuning->limit[2] = periods_beyond(params->current_time, period);
    tuning->limit[3] = periods_beyond(params->speed_time, period);
}

void validity_prepare(validity_tuning_t *tuning, const validity_params_t *params, float period)
{
    tuning->amplitude_min = params->amplitude_min;
    tuning->amplitude_max = limit_of(params->amplitude_max);
    tuning->detector_max = limit_of(params->detector_max);
    tuning->error_square_max = limit_of(params->current_max * params->current_max);
    tuning->speed_min = params->speed_min;
    tuning->speed_max = limit_of(params->speed_max);
    validity_prepare_debounce(&tuning->debounce, params, period);
}
