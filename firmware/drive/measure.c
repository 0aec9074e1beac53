#include "drive/measure.h"

#include <string.h>

#include "math/bounds.h"

/* A sensor that reads half a per cent less than its end, or more, is there or broken [A]. */
#define CURRENT_MIDDLE (0.5f * (DRIVE_CURRENT_MAX + DRIVE_CURRENT_MIN))
#define CURRENT_HALF   (0.4975f * (DRIVE_CURRENT_MAX - DRIVE_CURRENT_MIN))
/* What phase c may have of a sensor's range: without one of its own it is the sum of two, and within twice
 * that. */
#define CURRENT_C_SHARE   (DRIVE_CURRENT_SENSORS == 3 ? 1.0f : 3.0f)
#define U_DC_LIMIT        1000.0f /* [V] no sensor of the board reads this: not a number */
#define TEMPERATURE_LIMIT 1000.0f /* [degC] likewise */
#define SETTLE_PERIODS    64u     /* [periods] after the start before offsets are averaged */

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

void measure_take(measure_t *measure, const measure_tuning_t *tuning)
{
    measure->tuning = *tuning;
}

static bool is_measurement(const drive_samples_t *samples)
{
    return bounds_within(samples->i_a - CURRENT_MIDDLE, CURRENT_HALF) &&
           bounds_within(samples->i_b - CURRENT_MIDDLE, CURRENT_HALF) &&
           bounds_within(samples->i_c - CURRENT_MIDDLE, CURRENT_C_SHARE * CURRENT_HALF) &&
           bounds_within(samples->u_dc, U_DC_LIMIT) &&
           bounds_within(samples->sink_temperature, TEMPERATURE_LIMIT) &&
           bounds_within(samples->motor_temperature, TEMPERATURE_LIMIT);
}

void measure_step(measure_t *measure, const drive_samples_t *samples, ab_t trim)
{
    measured_t *measured = &measure->measured;
    measured->good = is_measurement(samples);
    if (measured->good != 0u) {
        measured->current_abc = (abc_t){samples->i_a - measure->offset.a, samples->i_b - measure->offset.b,
                                        samples->i_c - measure->offset.c};
        measured->u_dc = samples->u_dc;
        measured->sink_temperature = samples->sink_temperature;
        measured->motor_temperature = samples->motor_temperature;
    }
    const ab_t current = frames_clarke(measured->current_abc);
    measured->current = (ab_t){current.alpha - trim.alpha, current.beta - trim.beta};
    measured->encoder_count = samples->encoder;
    measured->flags = samples->flags;
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
                   bounds_within(measure->offset.c, CURRENT_C_SHARE * limit)
               ? CALIBRATION_GOOD
               : CALIBRATION_FAILED;
}
