/* Windings with known data. They answer the orders of the steps of commissioning at standstill at once,
 * with the sums of a settled window. */
#ifndef TESTS_UNIT_COMMISSION_WINDINGS_H
#define TESTS_UNIT_COMMISSION_WINDINGS_H

#include <math.h>

#include "tests/unit/commission_bench.h"

#define PERIODS 8.0
#define LINK    311.0

/* A winding and its faults. */
typedef struct {
    double resistance; /* [ohm] */
    double rest;       /* [V] 4/3 of the loss of a leg */
    double zone;       /* [A] half width of the zone around zero current in which the loss changes its sign */
    double noise;      /* [A] noise of a current sensor */
    double gain;       /* [-] part of R that depends on the direction: R (1 + gain cos 2 angle) */
    double moving;     /* [-] as `gain`, with the other sign in the second staircase */
    double across;     /* [-] current across the axis divided by that along the axis */
    double l_d, l_q;   /* [H] */
    /* [rad^2/s^2] square of the natural frequency of a free rotor, which lowers L_q: L_q (1 - rotor/w^2). */
    double rotor;
    double bends; /* [A] I_s of the q axis; 0: it does not saturate */
    /* Current across the sine divided by that along the sine, until the current has been lowered. */
    double leaves;
    double aside;  /* [rad] angle from the axis to the d axis of the rotor */
    double sensor; /* [-] relative error of the gain of sensor a */
    int flat;      /* 1: the voltage does not follow the staircase of currents */
    /* Number of windows for which a rotor that leaves the axis is still steady; 0: it never leaves. */
    unsigned steady;
} winding_t;

typedef struct {
    commission_t commission;
    excite_seen_t seen;
} bench_t;

static void order_step(bench_t *bench, const commission_tuning_t *tuning, int32_t step)
{
    const commission_window_t window = {
        .standing = {&bench->seen, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f}, (float)LINK}, .bridge_on = true};
    commission_window(&bench->commission, tuning, step, &window);
}

/* The sums of a settled window for the present order, which has no sine. */
static void answer_hold(bench_t *bench, const winding_t *winding, double resistance)
{
    const excite_order_t *order = &bench->commission.order;
    const double current = (double)order->current;
    bench->seen = (excite_seen_t){
        .periods = (uint32_t)PERIODS, .serial = order->serial, .done = 1u, .axis = order->axis};
    bench->seen.current = (dq_t){(float)(PERIODS * current), (float)(PERIODS * winding->across * current)};
    /* The legs carry i, -i/2, -i/2; the axis has 2/3 of the sum of the first and of the mean of the
     * others. */
    const double passes =
        winding->zone > 0.0
            ? 0.5 * (fmin(current / winding->zone, 1.0) + fmin(0.5 * current / winding->zone, 1.0))
            : 1.0;
    bench->seen.voltage = (dq_t){(float)(PERIODS * (resistance * current + passes * winding->rest)), 0.0f};
}

#endif
