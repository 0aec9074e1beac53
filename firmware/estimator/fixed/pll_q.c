#include "estimator/fixed/pll_q.h"

#include "math/root_q.h"
#include "math/trig_q.h"

#define FLOOR_INVERSE_Q 15
#define SPEED_INVERSE_Q 14
#define LONG_BITS       (LONG_SPEED_Q - SPEED_Q)

static int32_t short_speed(int64_t speed)
{
    return q_word(speed);
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

/* Advances to the angle of the next result, at this speed. */
static void move(pll_q_t *pll, int32_t omega_e)
{
    place(pll, pll->theta_e + ((uint32_t)omega_e << (ANGLE_Q - SPEED_Q)));
    pll->omega_e = omega_e;
}

void pll_take_q(pll_q_t *pll, const pll_tuning_q_t *tuning)
{
    pll->tuning = *tuning;
}

void pll_reset_q(pll_q_t *pll, position_q_t start)
{
    int64_t speed = q_clamp_long(long_speed(start.omega_e), PLL_SPEED_LIMIT);
    int32_t omega_e = short_speed(speed);
    if (pll->tuning.feedforward_share > 0) {
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
    if (q_magnitude(omega_e) >= pll->tuning.sign_speed) {
        pll->direction = 0;
    }
}

void pll_reset_emf_q(pll_q_t *pll, int32_t amplitude)
{
    int32_t length = q_clamp(amplitude, SAMPLE_LARGEST);
    pll->emf = (dq_q_t){0, pll->omega_smooth < 0 ? -length : length};
    pll->amplitude = length;
}

static void take_speeds(pll_q_t *pll, int64_t feedforward, int64_t integral)
{
    pll->feedforward = feedforward;
    pll->integral = integral;
    pll->omega_smooth = short_speed(integral + feedforward);
}

static int32_t speed_of(int32_t emf, int32_t speed_per_volt)
{
    return q_cut(q_product(emf, speed_per_volt), VOLTAGE_Q + SPEED_PER_VOLT_Q - SPEED_Q, SPEED_Q - 2);
}

void pll_reset_feedforward_q(pll_q_t *pll, int32_t speed_per_volt)
{
    if (pll->tuning.feedforward_share > 0 && q_magnitude(pll->omega_smooth) >= pll->tuning.signed_speed) {
        const int64_t whole = pll->feedforward + pll->integral;
        pll->feedforward = q_clamp_long(long_speed(speed_of(pll->emf.q, speed_per_volt)), PLL_SPEED_LIMIT);
        pll->integral = whole - pll->feedforward;
    }
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

/* The EMF in the frame of the loop, filtered. */
static inline dq_q_t filtered(const pll_q_t *pll, ab_q_t emf)
{
    int32_t decay = pll->tuning.emf_decay;
    int32_t share = Q_ONE(UNIT_Q) - decay;
    dq_q_t e = frames_park_q(emf, pll->rotation);
    e.d = q_cut(q_product(share, e.d) + q_product(decay, pll->emf.d), UNIT_Q, SAMPLE_BITS);
    e.q = q_cut(q_product(share, e.q) + q_product(decay, pll->emf.q), UNIT_Q, SAMPLE_BITS);
    return e;
}

position_q_t pll_watch_q(pll_q_t *pll, ab_q_t emf, int64_t acceleration)
{
    pll->emf = filtered(pll, emf);
    return pll_coast_q(pll, acceleration);
}

/* The sign of the detector at low speed; above it the direction of the start is no longer needed. */
static int32_t soft_sign(pll_q_t *pll)
{
    int32_t omega_smooth = q_clamp(pll->omega_smooth, pll->tuning.sign_speed);
    if (q_magnitude(omega_smooth) >= pll->tuning.sign_speed) {
        pll->direction = 0;
    }
    if (pll->direction != 0) {
        return pll->direction * Q_ONE(UNIT_Q);
    }
    return q_clamp(q_multiply_saturated(omega_smooth, pll->tuning.inverse_sign_speed,
                                        SPEED_Q + SPEED_INVERSE_Q - UNIT_Q),
                   Q_ONE(UNIT_Q));
}

/* A speed that would exceed its limit keeps its value. */
static inline int64_t speed_within(int64_t speed, int32_t limit, int64_t before)
{
    int32_t high = (int32_t)q_floor(speed, LONG_BITS);
    return high >= -limit && high < limit ? q_join(high, speed) : before;
}

/* e_d/floor, Q30. */
static int32_t sine_below_floor(const pll_q_t *pll, int32_t e_d)
{
    return q_clamp(q_multiply_saturated(e_d, pll->tuning.inverse_floor, VOLTAGE_Q + FLOOR_INVERSE_Q - UNIT_Q),
                   Q_ONE(UNIT_Q));
}

position_q_t pll_step_q(pll_q_t *pll, ab_q_t emf, int32_t speed_per_volt, int64_t acceleration)
{
    dq_q_t e = filtered(pll, emf);
    direction_q_t direction = direction_q(e.d, e.q);
    int32_t amplitude = direction.length;
    int32_t sine = amplitude < pll->tuning.amplitude_floor ? sine_below_floor(pll, e.d) : direction.cosine;

    int32_t signed_emf = pll->omega_smooth < 0 ? -amplitude : amplitude;
    int32_t detector = pll->omega_smooth < 0 ? sine : -sine;
    if (q_magnitude(pll->omega_smooth) < pll->tuning.signed_speed) {
        signed_emf = e.q;
        detector = -q_multiply(sine, soft_sign(pll), UNIT_Q);
    }

    int32_t missing = speed_of(signed_emf, speed_per_volt) - short_speed(pll->feedforward);
    int64_t feedforward =
        pll->feedforward + q_product(pll->tuning.feedforward_share, 2 * missing) + acceleration;
    feedforward = speed_within(feedforward, PLL_SHORT_LIMIT, pll->feedforward);
    int64_t integral = pll->integral + q_scaled(detector, pll->tuning.ki_period);
    integral = speed_within(integral, 2 * PLL_SHORT_LIMIT, pll->integral);
    take_speeds(pll, feedforward, integral);

    position_q_t position;
    position.theta_e = pll->theta_e;
    position.omega_e =
        pll->omega_smooth + q_multiply(pll->tuning.kp_rest, detector, SHARE_Q + UNIT_Q - SPEED_Q);

    move(pll, position.omega_e);
    pll->emf = e;
    pll->detector = detector;
    pll->amplitude = amplitude;
    return position;
}
