#include "estimator/fixed/pll_q.h"

#include "math/root_q.h"
#include "math/trig_q.h"

#define FLOOR_INVERSE_Q  15
#define SPEED_INVERSE_Q  14
#define LONG_BITS        (LONG_SPEED_Q - SPEED_Q)
#define SPEED_PER_VOLT_Q 30

static int32_t short_speed(int64_t speed)
{
    return (int32_t)q_round(speed, LONG_BITS);
}

static int64_t long_speed(int32_t speed)
{
    return (int64_t)speed * (INT64_C(1) << LONG_BITS);
}

static void place(pll_q_t *pll, uint32_t theta_e)
{
    pll->theta_e = theta_e;
    pll->rotation = trig_rotation_q(theta_e);
}

/* To the angle of the next result, at this speed. */
static void move(pll_q_t *pll, int32_t omega_e)
{
    place(pll, pll->theta_e + (uint32_t)omega_e);
    pll->omega_e = omega_e;
}

void pll_retune_q(pll_q_t *pll, const pll_params_q_t *params)
{
    pll->params = *params;
}

void pll_init_q(pll_q_t *pll, const pll_params_q_t *params)
{
    const position_q_t origin = {0u, 0};
    pll_retune_q(pll, params);
    pll_reset_q(pll, origin);
}

void pll_reset_q(pll_q_t *pll, position_q_t start)
{
    int64_t speed = q_clamp_long(long_speed(start.omega_e), PLL_SPEED_LIMIT);
    int32_t omega_e = short_speed(speed);
    if (pll->params.feedforward_share > 0) {
        pll->feedforward = speed;
        pll->integral = 0;
    } else {
        pll->feedforward = 0;
        pll->integral = speed;
    }
    place(pll, start.theta_e);
    pll->omega_e = omega_e;
    pll->omega_smooth = omega_e;
    pll->direction = omega_e < 0 ? -1 : 1;
    pll->detector = 0;
    pll->amplitude = 0;
    pll->emf = (dq_q_t){0, 0};
    if (q_magnitude(omega_e) >= pll->params.sign_speed) {
        pll->direction = 0;
    }
}

void pll_settle_q(pll_q_t *pll, int32_t amplitude)
{
    int32_t length = q_clamp(amplitude, Q_LARGEST);
    pll->emf = (dq_q_t){0, pll->omega_smooth < 0 ? -length : length};
    pll->amplitude = length;
}

static void take_speeds(pll_q_t *pll, int64_t feedforward, int64_t integral)
{
    pll->feedforward = feedforward;
    pll->integral = integral;
    pll->omega_smooth = q_saturate((int64_t)short_speed(integral) + short_speed(feedforward));
}

position_q_t pll_coast_q(pll_q_t *pll, int64_t acceleration)
{
    int64_t feedforward = pll->feedforward + acceleration;
    if (feedforward <= PLL_SPEED_LIMIT && feedforward >= -PLL_SPEED_LIMIT) {
        take_speeds(pll, feedforward, pll->integral);
    }
    position_q_t position = {pll->theta_e, pll->omega_smooth};
    move(pll, position.omega_e);
    pll->detector = 0;
    return position;
}

static int32_t decayed(const pll_q_t *pll, int32_t now, int32_t before)
{
    return q_add(now, q_multiply(pll->params.emf_decay, q_subtract(before, now), SHARE_Q));
}

/* The EMF in the frame of the loop, filtered. */
static dq_q_t filtered(const pll_q_t *pll, ab_q_t emf)
{
    dq_q_t e = frames_park_q(emf, pll->rotation);
    e.d = decayed(pll, e.d, pll->emf.d);
    e.q = decayed(pll, e.q, pll->emf.q);
    return e;
}

position_q_t pll_watch_q(pll_q_t *pll, ab_q_t emf, int64_t acceleration)
{
    pll->emf = filtered(pll, emf);
    return pll_coast_q(pll, acceleration);
}

/* The detector's sign at low speed; from there on a start's direction is no longer needed. */
static int32_t soft_sign(pll_q_t *pll)
{
    int32_t omega_smooth = q_clamp(pll->omega_smooth, pll->params.sign_speed);
    if (q_magnitude(omega_smooth) >= pll->params.sign_speed) {
        pll->direction = 0;
    }
    if (pll->direction != 0) {
        return pll->direction * Q_ONE(UNIT_Q);
    }
    return q_clamp(q_multiply_saturated(omega_smooth, pll->params.inverse_sign_speed,
                                        SPEED_Q + SPEED_INVERSE_Q - UNIT_Q),
                   Q_ONE(UNIT_Q));
}

/* e_d/max(|e|, floor), Q30, and |e|. */
static int32_t sine_of(const pll_q_t *pll, dq_q_t e, int32_t *amplitude)
{
    uint64_t square = q_square_sum(e.d, e.q);
    root_q_t inverse = inverse_root_q(square);
    *amplitude = q_saturate(root_from_q(square, inverse));
    int32_t sine =
        *amplitude < pll->params.amplitude_floor
            ? q_multiply_saturated(e.d, pll->params.inverse_floor, VOLTAGE_Q + FLOOR_INVERSE_Q - UNIT_Q)
            : q_multiply_saturated(e.d, inverse.mantissa, 61 - UNIT_Q - inverse.shift);
    return q_clamp(sine, Q_ONE(UNIT_Q));
}

position_q_t pll_step_q(pll_q_t *pll, ab_q_t emf, int32_t speed_per_volt, int64_t acceleration)
{
    dq_q_t e = filtered(pll, emf);
    int32_t amplitude;
    int32_t sine = sine_of(pll, e, &amplitude);

    int32_t omega_smooth = pll->omega_smooth;
    int32_t signed_emf = omega_smooth < 0 ? -amplitude : amplitude;
    int32_t detector = omega_smooth < 0 ? sine : -sine;
    if (q_magnitude(omega_smooth) < pll->params.signed_speed) {
        signed_emf = e.q;
        detector = -q_multiply(sine, soft_sign(pll), UNIT_Q);
    }

    int32_t speed_of_emf =
        q_multiply_saturated(signed_emf, speed_per_volt, VOLTAGE_Q + SPEED_PER_VOLT_Q - SPEED_Q);
    int32_t missing = q_subtract(speed_of_emf, short_speed(pll->feedforward));
    int64_t feedforward = pll->feedforward + q_product(pll->params.feedforward_share, missing) + acceleration;
    if (feedforward > PLL_SPEED_LIMIT || feedforward < -PLL_SPEED_LIMIT) {
        feedforward = pll->feedforward;
    }
    int64_t integral =
        q_clamp_long(pll->integral + q_scaled(detector, pll->params.ki_period), 2 * PLL_SPEED_LIMIT);

    position_q_t position;
    position.theta_e = pll->theta_e;
    position.omega_e = q_saturate((int64_t)short_speed(pll->integral) + short_speed(feedforward) +
                                  q_round(q_product(pll->params.kp, detector), SHARE_Q + UNIT_Q - SPEED_Q));

    move(pll, position.omega_e);
    pll->emf = e;
    take_speeds(pll, feedforward, integral);
    pll->detector = detector;
    pll->amplitude = amplitude;
    return position;
}
