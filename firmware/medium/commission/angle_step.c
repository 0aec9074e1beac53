#include "medium/commission/angle_step.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/periods.h"
#include "math/root.h"
#include "math/trig.h"

#define DIRECTIONS 12u
#define FIRST      0.261799388f /* [rad] 15 degrees */
#define APART      0.523598776f /* [rad] 30 degrees */
#define RATE       4.19f        /* [rad/s] of the turn from one direction to the next */

#define BIAS            0.8f        /* standing current over I_h [-] */
#define AMPLITUDE       0.1f        /* of the sine over the standing current, at most ... */
#define AMPLITUDE_LEAST 0.04f       /* ... and at least [-] */
#define LEAST_PHASE     0.25881905f /* sin 15 degrees: least phase current over the standing current [-] */
#define CLEAR           1.2f        /* zones that a phase keeps from zero current [-] */
#define AMPLITUDE_PLAIN 0.4f        /* the same over I_h, without a standing current [-] */
#define FREQUENCY       500.0f      /* [Hz] */
#define VOLTAGE_LEAST   3.0f        /* [V] below it the frequency is doubled */
#define VOLTAGE_MOST    0.2f        /* of the DC link [-] */
#define DEAD            1.70f       /* fundamental of the lost voltage, 4/3 V as a square wave, over V [-] */
#define STIFF           2000.0f /* [rad/s] of the resistance across the axis, over L: the rotor needs no braking */

#define BLOCK   0.1f   /* [s] */
#define BLOCKS  4.0f   /* of a direction at most [-] */
#define SETTLE  0.06f  /* [s] before the sums */
#define SCATTER 0.003f /* standard error of 1/L by the noise of a sensor, relative [-] */
#define ACROSS  0.5f   /* current across over that along the axis of a settled current [-] */

#define SALIENCY   0.04f  /* least y_2/y_0 that shows the axis [-] */
#define SATURATION 0.015f /* least y_1/y_0 that shows the direction [-] */

void angle_step_begin(angle_step_t *step)
{
    *step = (angle_step_t){.phase = (int32_t)ANGLE_BEGIN};
}

/* Amplitude over the standing current at which neither ripple nor zone bring a phase current to zero; too
 * small or negative: there is none. */
static float clear_amplitude(const angle_step_t *step, const commission_tuning_t *tuning,
                             const commission_input_t *input, const commission_results_t *results)
{
    const float ripple = input->u_dc * tuning->period / (24.0f * results->inductance_pulse);
    return bounds_less(LEAST_PHASE - (CLEAR * results->current_zone + ripple) / step->bias, AMPLITUDE);
}

/* The voltage of the sine for this amplitude [A]; without a standing current the sine must also contain the
 * voltage that the dead time loses. */
static float voltage_of(const angle_step_t *step, float amplitude, float turn,
                        const commission_tuning_t *tuning, const commission_results_t *results)
{
    const float reactance = turn * step->guess / tuning->period;
    const float lost = step->biased != 0u ? 0.0f : DEAD * results->dead_voltage;
    return lost + amplitude * root_or_none(results->resistance * results->resistance + reactance * reactance);
}

/* Windows of a direction: as many as the mean over the noise needs, sqrt(2/N) noise/amplitude. */
static uint32_t length_of(float amplitude, const commission_tuning_t *tuning,
                          const commission_results_t *results)
{
    const float noise = results->noise > 0.0f ? results->noise : tuning->noise_max;
    const float error = noise / (SCATTER * amplitude);
    const float blocks = 2.0f * error * error * tuning->period * (1.0f / BLOCK);
    return periods_of(BLOCK * bounds_less(bounds_more(blocks, 1.0f), BLOCKS), tuning->window);
}

/* Orders the sine in the present direction: a whole number of its periods. */
static void prepare(angle_step_t *step, const commission_tuning_t *tuning, const commission_input_t *input,
                    const commission_results_t *results, excite_order_t *order)
{
    const float amplitude = step->biased != 0u ? clear_amplitude(step, tuning, input, results) * step->bias
                                               : AMPLITUDE_PLAIN * results->current_hold;
    step->length = length_of(amplitude, tuning, results);
    const float block = (float)step->length * tuning->window;
    const float cycle = ANGLE_TWO_PI * tuning->period / block;
    const float cycles = (float)(uint32_t)(FREQUENCY * block + 0.5f);
    const float once = voltage_of(step, amplitude, cycle * cycles, tuning, results);
    const float turn = (once < VOLTAGE_LEAST ? 2.0f : 1.0f) * cycle * cycles;
    const float voltage = voltage_of(step, amplitude, turn, tuning, results);
    order->turn = turn;
    order->voltage = bounds_less(voltage, VOLTAGE_MOST * input->u_dc);
    order->sine_across = 0u;
    step->windows = 0u;
    step->voltage = (sine_sum_t){0.0f, 0.0f};
    step->current = (sine_sum_t){0.0f, 0.0f};
    step->phase = (int32_t)ANGLE_RUNS;
}

static commission_verdict_t begin(angle_step_t *step, const commission_tuning_t *tuning,
                                  const commission_input_t *input, excite_order_t *order,
                                  const commission_results_t *results)
{
    if (!(results->resistance > 0.0f && results->inductance_pulse > 0.0f)) {
        return commission_failed(COMMISSION_REASON_EARLIER_STEP, 0);
    }
    step->bias = BIAS * results->current_hold;
    step->guess = results->inductance_pulse;
    standing_begin(&step->standing, FIRST, input->u_dc, tuning, results, order);
    order->across = STIFF * results->inductance_pulse;
    prepare(step, tuning, input, results, order);
    return commission_goes_on();
}

/* y_1 or y_2 over y_0. */
static float share_of(float cosine, float sine, float mean)
{
    return 2.0f * root_or_none(cosine * cosine + sine * sine) / mean;
}

static commission_verdict_t judge(const angle_step_t *step, commission_results_t *results)
{
    const angle_harmonics_t *plain = &step->plain;
    const angle_harmonics_t *bent = &step->bent;
    const bool salient = share_of(plain->cos_2, plain->sin_2, plain->mean) > SALIENCY;
    if (!(share_of(bent->cos_1, bent->sin_1, bent->mean) > SATURATION)) {
        return commission_failed(COMMISSION_REASON_NO_STANDSTILL_ANGLE, salient ? ANGLE_AXIS_ONLY : 0);
    }
    const float direction = trig_atan2(bent->sin_1, bent->cos_1);
    const float axis = 0.5f * trig_atan2(plain->sin_2, plain->cos_2);
    const bool opposite = !bounds_within(angle_wrap(direction - axis), 0.5f * ANGLE_PI);
    results->angle_d = !salient ? direction : opposite ? angle_wrap(axis + ANGLE_PI) : axis;
    return commission_finished();
}

static void add_harmonics(angle_harmonics_t *harmonics, rotation_t axis, float inverse)
{
    harmonics->mean += inverse;
    harmonics->cos_1 += inverse * axis.cos;
    harmonics->sin_1 += inverse * axis.sin;
    harmonics->cos_2 += inverse * (axis.cos * axis.cos - axis.sin * axis.sin);
    harmonics->sin_2 += inverse * 2.0f * axis.cos * axis.sin;
}

/* The sums of a direction are complete: continues with the next direction, with the second round, or with the
 * result. L with a standing current differs from L without one; the first direction of the second round only
 * measures it. */
static commission_verdict_t next(angle_step_t *step, const commission_tuning_t *tuning,
                                 const commission_input_t *input, excite_order_t *order,
                                 commission_results_t *results)
{
    const float inductance = sine_solve(step->voltage, step->current, trig_turn(order->turn), tuning);
    if (!(inductance > 0.0f)) {
        return commission_failed(COMMISSION_REASON_INDUCTANCE_IMPLAUSIBLE, 0);
    }
    const bool probe = step->biased != 0u && step->direction == 0u;
    if (!probe) {
        add_harmonics(step->biased != 0u ? &step->bent : &step->plain, order->axis, 1.0f / inductance);
    }
    step->guess = inductance;
    step->direction++;
    if (step->biased != 0u) {
        if (step->direction > DIRECTIONS) {
            return judge(step, results);
        }
        order->voltage = 0.0f;
        step->phase = (int32_t)ANGLE_TURN;
    } else if (step->direction < DIRECTIONS) {
        standing_point(&step->standing, FIRST + APART * (float)step->direction, order);
        prepare(step, tuning, input, results, order);
    } else if (clear_amplitude(step, tuning, input, results) < AMPLITUDE_LEAST) {
        return commission_failed(COMMISSION_REASON_NO_STANDSTILL_ANGLE, ANGLE_NOT_CLEAR);
    } else {
        step->biased = 1u;
        step->direction = 0u;
        standing_point(&step->standing, FIRST, order);
        order->voltage = 0.0f;
        order->current = step->bias;
        standing_wait(&step->standing);
        step->phase = (int32_t)ANGLE_ALIGN;
    }
    return commission_goes_on();
}

static commission_verdict_t run_on(angle_step_t *step, const commission_tuning_t *tuning,
                                   const commission_input_t *input, excite_order_t *order,
                                   commission_results_t *results)
{
    const excite_seen_t *seen = input->seen;
    const uint32_t from = periods_of(SETTLE, tuning->window);
    step->windows++;
    if (step->windows > from) {
        sine_sum_add(&step->voltage, seen->voltage_cos.d, seen->voltage_sin.d);
        sine_sum_add(&step->current, seen->current_cos.d, seen->current_sin.d);
    }
    return step->windows < from + step->length ? commission_goes_on()
                                               : next(step, tuning, input, order, results);
}

/* One window of the turn of the current to the next direction. The held rotor does not follow, so that the
 * current may cross the axis of the rotor during the turn. */
static void turn_on(angle_step_t *step, const commission_tuning_t *tuning, const commission_input_t *input,
                    const commission_results_t *results, excite_order_t *order)
{
    const float target = FIRST + APART * (float)step->direction;
    const float rest = angle_wrap(target - step->standing.angle);
    const float most = RATE * tuning->window;
    standing_point(&step->standing, step->standing.angle + bounds_clamp(rest, most), order);
    if (bounds_within(rest, most)) {
        prepare(step, tuning, input, results, order);
    }
}

commission_verdict_t angle_step(angle_step_t *step, const commission_tuning_t *tuning,
                                const commission_input_t *input, excite_order_t *order,
                                commission_results_t *results)
{
    if (step->phase == (int32_t)ANGLE_BEGIN) {
        return begin(step, tuning, input, order, results);
    }
    if (input->seen->serial != order->serial) {
        return commission_goes_on();
    }
    if (step->phase == (int32_t)ANGLE_RUNS) {
        return run_on(step, tuning, input, order, results);
    }
    if (step->phase == (int32_t)ANGLE_TURN) {
        turn_on(step, tuning, input, results, order);
        return commission_goes_on();
    }
    const standing_want_t want = {periods_of(BLOCK, tuning->window), order->current, ACROSS * order->current};
    const standing_state_t state = standing_step(&step->standing, want, input->seen);
    if (state != STANDING_STEADY) {
        return standing_verdict(state);
    }
    prepare(step, tuning, input, results, order);
    return commission_goes_on();
}
