#include "medium/adapt/offset_trim.h"

#include <stdbool.h>

#include "math/angle.h"
#include "math/bounds.h"

offset_trim_tuning_t offset_trim_prepare(const offset_trim_params_t *params)
{
    return (offset_trim_tuning_t){params->gain, params->saliency, (uint32_t)(TRIM_WINDOW / params->period)};
}

void offset_trim_init(offset_trim_t *trim, const offset_trim_tuning_t *tuning)
{
    offset_trim_take(trim, tuning);
    offset_trim_reset(trim, (ab_t){0.0f, 0.0f});
}

static void begin_window(offset_trim_t *trim, float omega_e, ab_t sum, float ahead)
{
    trim->sum = sum;
    trim->ahead = ahead;
    trim->count = 0u;
    trim->omega = omega_e;
}

void offset_trim_reset(offset_trim_t *trim, ab_t offset)
{
    begin_window(trim, 0.0f, (ab_t){0.0f, 0.0f}, 0.0f);
    trim->theta_prev = 0.0f;
    trim->offset = offset;
}

static bool steady(const offset_trim_t *trim, float omega_e, const ab_t *current)
{
    float square = current->alpha * current->alpha + current->beta * current->beta;
    const float turned = bounds_magnitude(omega_e) * TRIM_WINDOW;
    return turned > TRIM_SPEED_MIN * TRIM_WINDOW &&
           turned < TRIM_TURN_MOST * (float)trim->tuning.window_periods &&
           bounds_magnitude(omega_e - trim->omega) < TRIM_SPEED_DRIFT * bounds_magnitude(omega_e) &&
           square > TRIM_CURRENT_MIN * TRIM_CURRENT_MIN;
}

/* Share of the last period that lies beyond the wrap of the angle [-], after a step by more than pi. */
static float share_beyond(float theta_e, float moved)
{
    const float turned = ANGLE_TWO_PI - bounds_magnitude(moved);
    return turned > 0.0f ? (ANGLE_PI - bounds_magnitude(theta_e)) / turned : 0.0f;
}

void offset_trim_turn(offset_trim_t *trim, const offset_trim_input_t *input, ab_t emf, float moved)
{
    if (trim->count < trim->tuning.window_periods) {
        return;
    }
    const float beyond = share_beyond(input->theta_e, moved);
    const ab_t rest = {beyond * emf.alpha, beyond * emf.beta};
    if (steady(trim, input->omega_e, &input->current)) {
        const float share = trim->tuning.gain / ((float)trim->count + trim->ahead - beyond);
        trim->offset.alpha =
            bounds_clamp(trim->offset.alpha - share * (trim->sum.alpha - rest.alpha), TRIM_LIMIT);
        trim->offset.beta =
            bounds_clamp(trim->offset.beta - share * (trim->sum.beta - rest.beta), TRIM_LIMIT);
    }
    begin_window(trim, input->omega_e, rest, beyond);
}
