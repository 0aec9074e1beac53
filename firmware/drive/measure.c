#include "drive/measure.h"

#include <string.h>

#include "math/bounds.h"

#define SETTLE_PERIODS 64u /* [periods] after the start before offsets are averaged */

measure_tuning_t measure_prepare(const params_t *params)
{
    return (measure_tuning_t){
        .weight = 1.0f / (float)params->calibration_periods,
        .periods = SETTLE_PERIODS + (uint32_t)params->calibration_periods,
        .offset_max = params->current_offset_max,
    };
}

void measure_init(measure_t *measure, const measure_tuning_t *tuning)
{
    memset(measure, 0, sizeof *measure);
    measure_take(measure, tuning);
}

void measure_begin_calibration(measure_t *measure)
{
    measure->calibrated = 0u;
}

calibration_t measure_calibrate(measure_t *measure, const drive_samples_t *samples)
{
    if (measure->calibrated == 0u) {
        measure->offset = (abc_t){0.0f, 0.0f, 0.0f};
    }
    if (measure->measured.good == 0u) {
        return CALIBRATION_GOES_ON;
    }
    if (measure->calibrated >= SETTLE_PERIODS) {
        measure->offset.a += measure->tuning.weight * samples->i_a;
        measure->offset.b += measure->tuning.weight * samples->i_b;
        measure->offset.c += measure->tuning.weight * samples->i_c;
    }
    measure->calibrated++;
    if (measure->calibrated < measure->tuning.periods) {
        return CALIBRATION_GOES_ON;
    }
    const float limit = measure->tuning.offset_max;
    return bounds_within(measure->offset.a, limit) && bounds_within(measure->offset.b, limit) &&
                   bounds_within(measure->offset.c, MEASURE_C_SHARE * limit)
               ? CALIBRATION_GOOD
               : CALIBRATION_FAILED;
}
