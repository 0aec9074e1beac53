#include "fast/control/excite.h"

#include <string.h>

#include "math/angle.h"
#include "math/bounds.h"
#include "math/trig.h"

#define PULSE_ENDS 3u /* [periods] after its voltages, until their currents are sampled */

void excite_init(excite_t *excite)
{
    memset(excite, 0, sizeof *excite);
}

static void begin(excite_t *excite, const excite_order_t *order, ab_t current)
{
    const ab_t none = {0.0f, 0.0f};
    excite->seen.serial = order->serial;
    excite->seen.done = 0u;
    excite->seen.response = none;
    excite->integral = 0.0f;
    excite->reference = 0.0f;
    excite->phase = 0.0f;
    excite->count = 0u;
    excite->still = 0u;
    excite->before = current;
}

static inline float length_square(ab_t vector)
{
    return vector.alpha * vector.alpha + vector.beta * vector.beta;
}

/* The voltage along the axis. The voltage of step k acts from t_k+1 to t_k+2: the current at the end of the
 * first half is sampled in step n + 1. */
static float pulse(excite_t *excite, const excite_order_t *order, ab_t current)
{
    const uint32_t half = order->periods;
    const uint32_t end = 2u * half + PULSE_ENDS;
    const uint32_t count = excite->count;
    const ab_t change = {current.alpha - excite->before.alpha, current.beta - excite->before.beta};
    const bool beyond = length_square(current) > order->current_max * order->current_max;
    if (count == half + 1u || (beyond && count <= half)) {
        excite->seen.response = change;
    }
    excite->count = beyond && count < half ? 2u * half : count + (count < end ? 1u : 0u);
    if (count >= end) {
        excite->still = length_square(current) < EXCITE_STILL * EXCITE_STILL ? excite->still + 1u : 0u;
        excite->seen.done = excite->still >= EXCITE_STILL_PERIODS ? 1u : excite->seen.done;
    }
    const float first = beyond ? 0.0f : order->voltage;
    return count < half ? first : count < 2u * half ? -order->voltage : 0.0f;
}

/* Control along the axis, a resistance across it. The integral waits while the voltage is limited. */
static dq_t hold(excite_t *excite, const excite_order_t *order, dq_t current)
{
    const float step = bounds_clamp(order->current - excite->reference, order->slew);
    excite->reference += step;
    excite->seen.done = bounds_within(order->current - excite->reference, order->slew) ? 1u : 0u;
    const float error = excite->reference - current.d;
    const float wanted = EXCITE_BANDWIDTH * order->inductance * error + excite->integral;
    const float along = bounds_clamp(wanted, order->voltage_max);
    if (bounds_within(wanted, order->voltage_max)) {
        excite->integral += order->ki * error;
    }
    const float beyond = current.q - bounds_clamp(current.q, order->across_from);
    /* |i|/most - 1, from the squares */
    const float squares = current.d * current.d + current.q * current.q;
    const float excess = bounds_more(bounds_less(0.5f * (squares * order->most_inverse - 1.0f), 1.0f), 0.0f);
    const float brake = EXCITE_MOST_HARD * order->inductance * excess;
    return (dq_t){along - brake * current.d,
                  -(order->across + brake) * current.q - EXCITE_ACROSS_HARD * order->inductance * beyond};
}

static void accumulate(dq_t *sum, float share, dq_t value)
{
    sum->d += share * value.d;
    sum->q += share * value.q;
}

static void sum_up(excite_seen_t *seen, rotation_t phase, dq_t voltage, dq_t current)
{
    seen->periods++;
    accumulate(&seen->voltage, 1.0f, voltage);
    accumulate(&seen->current, 1.0f, current);
    accumulate(&seen->voltage_cos, phase.cos, voltage);
    accumulate(&seen->voltage_sin, phase.sin, voltage);
    accumulate(&seen->current_cos, phase.cos, current);
    accumulate(&seen->current_sin, phase.sin, current);
}

ab_t excite_step(excite_t *excite, const excite_order_t *order, ab_t current, ab_t acted)
{
    if (order->serial != excite->seen.serial) {
        begin(excite, order, current);
    }
    const dq_t along = frames_park(current, order->axis);
    excite->seen.axis = order->axis;
    const rotation_t phase = trig_turn(excite->phase);
    sum_up(&excite->seen, phase, frames_park(acted, order->axis), along);
    excite->phase = angle_turn_back(excite->phase + order->turn);
    if (order->kind == (int32_t)EXCITE_PULSE) {
        return frames_inverse_park((dq_t){pulse(excite, order, current), 0.0f}, order->axis);
    }
    dq_t voltage = hold(excite, order, along);
    const float sine = order->voltage * phase.cos;
    voltage.d += order->sine_across != 0u ? 0.0f : sine;
    voltage.q += order->sine_across != 0u ? sine : 0.0f;
    return frames_inverse_park(voltage, order->axis);
}

dq_t excite_loop(excite_t *excite, const excite_order_t *order, dq_t current)
{
    if (order->serial != excite->seen.serial) {
        begin(excite, order, (ab_t){0.0f, 0.0f});
        excite->reference = order->current - order->step;
    }
    excite_seen_t *seen = &excite->seen;
    const uint32_t count = excite->count;
    const float error = excite->reference - current.d;
    /* the reference has stepped in period 0; the voltage of period k - 2 changes the current up to period k
     */
    if (count >= 2u && count < EXCITE_FITTED) {
        seen->voltage_cos.d += (excite->before.alpha - error) * excite->before.beta;
        seen->current_cos.d += excite->before.beta * excite->before.beta;
    }
    seen->periods++;
    accumulate(&seen->current, 1.0f, current);
    excite->before = (ab_t){error, excite->before.alpha};
    excite->count = count + 1u;
    if (excite->count >= order->periods) {
        /* the next sample is the first one of the next step */
        const float high = order->current + order->step;
        excite->count = 0u;
        excite->reference = excite->reference < order->current ? high : order->current - order->step;
    }
    const float beyond = current.q - bounds_clamp(current.q, order->across_from);
    return (dq_t){excite->reference,
                  -order->across * current.q - EXCITE_ACROSS_HARD * order->inductance * beyond};
}

void excite_close(excite_t *excite, excite_seen_t *seen)
{
    const dq_t none = {0.0f, 0.0f};
    excite_seen_t *now = &excite->seen;
    /* Copied field by field, because the compiler copies a whole struct by a function call. */
    seen->periods = now->periods;
    seen->serial = now->serial;
    seen->done = now->done;
    seen->axis = now->axis;
    seen->response = now->response;
    seen->voltage = now->voltage;
    seen->current = now->current;
    seen->voltage_cos = now->voltage_cos;
    seen->voltage_sin = now->voltage_sin;
    seen->current_cos = now->current_cos;
    seen->current_sin = now->current_sin;
    now->periods = 0u;
    now->voltage = none;
    now->current = none;
    now->voltage_cos = none;
    now->voltage_sin = none;
    now->current_cos = none;
    now->current_sin = none;
}
