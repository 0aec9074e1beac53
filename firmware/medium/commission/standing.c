#include "medium/commission/standing.h"

#include "math/bounds.h"

#define CORNER      60.0f /* [rad/s] of its integral, until R is known */
#define CORNER_MOST 15.0f /* [rad/s] least R/L that the integral follows */
#define ACROSS      30.0f /* [rad/s] of the resistance across the axis, over L */
#define ACROSS_FROM 0.4f  /* of the held current [-] */
#define MOST        1.1f  /* length of the current over the largest, from which it is braked [-] */
#define VOLTAGE     0.55f /* of the DC link [-] */
#define SLEW        0.02f /* [s] from zero to the largest current */

#define TURN      4.19f /* [rad/s] 60 degrees in 0.25 s */
#define TURN_LAG  0.3f  /* current across over that along, above which the turn is slower [-] */
#define TURN_SLOW 0.25f
#define AGREE     0.003f
#define AGREE_V   0.01f /* [V] */
#define NEAR      0.05f /* largest distance of the current from its reference, relative [-] */
#define TRIES     40u

void standing_gains(float u_dc, const commission_tuning_t *tuning, const commission_results_t *results,
                    excite_order_t *order)
{
    const float inductance = results->inductance_pulse;
    const float slowest = CORNER_MOST * inductance;
    const float known = results->resistance > 0.0f ? bounds_more(results->resistance, slowest) : 0.0f;
    const float corner = known > 0.0f ? known : CORNER * inductance;
    order->inductance = inductance;
    order->ki = EXCITE_BANDWIDTH * corner * tuning->period;
    order->across = ACROSS * inductance;
    order->across_from = ACROSS_FROM * bounds_less(tuning->current_hold, tuning->current_max);
    const float most = MOST * tuning->current_max;
    order->most_inverse = 1.0f / (most * most);
    order->voltage_max = VOLTAGE * u_dc;
    order->slew = tuning->current_max * tuning->period * (1.0f / SLEW);
}

void standing_begin(standing_t *standing, float angle, float u_dc, const commission_tuning_t *tuning,
                    const commission_results_t *results, excite_order_t *order)
{
    standing_wait(standing);
    *order = (excite_order_t){.kind = (int32_t)EXCITE_HOLD, .serial = order->serial + 1u};
    standing_point(standing, angle, order);
    standing_gains(u_dc, tuning, results, order);
}

void standing_wait(standing_t *standing)
{
    standing->windows = 0u;
    standing->tries = 0u;
    standing->last = -1.0f;
    commission_mean_begin(&standing->mean);
}

bool standing_turn(standing_t *standing, float angle, const commission_tuning_t *tuning,
                   const excite_seen_t *seen, excite_order_t *order)
{
    const float rest = angle_wrap(angle - standing->angle);
    const bool lags = !bounds_within(seen->current.q, bounds_magnitude(TURN_LAG * seen->current.d));
    const float step = (lags ? TURN_SLOW : 1.0f) * TURN * tuning->window;
    standing_point(standing, standing->angle + bounds_clamp(rest, step), order);
    return bounds_within(rest, step);
}

standing_state_t standing_step(standing_t *standing, standing_want_t want, const excite_seen_t *seen)
{
    if (standing->windows == 0u) {
        commission_mean_begin(&standing->mean);
    }
    commission_mean_add(&standing->mean, seen);
    standing->windows++;
    if (standing->windows < want.block) {
        return STANDING_NOT_YET;
    }
    const dq_t voltage = commission_mean_of(&standing->mean, standing->mean.voltage);
    const dq_t flows = commission_mean_of(&standing->mean, standing->mean.current);
    const float agree = AGREE * bounds_magnitude(voltage.d) + AGREE_V;
    const bool reached = bounds_within(flows.d - want.current, NEAR * want.current);
    const bool rests = reached && bounds_within(flows.q, want.across);
    const bool steady = standing->last >= 0.0f && bounds_within(voltage.d - standing->last, agree) && rests;
    standing->last = bounds_magnitude(voltage.d);
    standing->windows = 0u;
    standing->tries++;
    if (steady) {
        return STANDING_STEADY;
    }
    if (standing->tries < TRIES) {
        return STANDING_NOT_YET;
    }
    return reached ? STANDING_SWINGS : STANDING_NEVER;
}
