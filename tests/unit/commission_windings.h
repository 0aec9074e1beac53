/* Specified windings, which answer the steps of commissioning at standstill at once, with the sums of a
 * settled window. */
#ifndef TESTS_UNIT_COMMISSION_WINDINGS_H
#define TESTS_UNIT_COMMISSION_WINDINGS_H

#include <math.h>

#include "tests/unit/commission_bench.h"

#define PERIODS 8.0
#define LINK    311.0

/* A winding and its faults. */
typedef struct {
    double resistance; /* [ohm] */
    double rest;       /* 4/3 of the loss of a leg [V] */
    double zone;       /* half width of its passage through zero current [A] */
    double noise;      /* of a current sensor [A] */
    double gain;       /* part of R that depends on the direction: R (1 + gain cos 2 angle) [-] */
    double moving;     /* the same, with the other sign in the second staircase [-] */
    double across;     /* current across the axis over that along the axis [-] */
    double l_d, l_q;   /* [H] */
    double
        rotor; /* the square of the rate of a free rotor, which lowers L_q: L_q (1 - rotor/w^2) [rad^2/s^2] */
    double bends;    /* I_s of the q axis [A]; 0: it does not saturate */
    double leaves;   /* current across the sine over that along the sine, until it has been lowered */
    int flat;        /* 1: the voltage does not follow the staircase of currents */
    unsigned steady; /* times that leaving rotor is still steady again; 0: never leaves */
} winding_t;

typedef struct {
    commission_t commission;
    excite_seen_t seen;
} bench_t;

static void order_step(bench_t *bench, const commission_tuning_t *tuning, int32_t step)
{
    const commission_window_t window = {
        .standing = {&bench->seen, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f}, (float)LINK}, .bridge_on = true};
    bench->commission.tuning = *tuning;
    commission_window(&bench->commission, step, &window);
}

/* The sums of a settled window for the present order, without a sine. */
static void answer_hold(bench_t *bench, const winding_t *winding, double resistance)
{
    const excite_order_t *order = &bench->commission.order;
    const double current = (double)order->current;
    bench->seen = (excite_seen_t){
        .periods = (uint32_t)PERIODS, .serial = order->serial, .done = 1u, .axis = order->axis};
    bench->seen.current = (dq_t){(float)(PERIODS * current), (float)(PERIODS * winding->across * current)};
    /* the legs carry i, -i/2, -i/2; the axis sees 2/3 of the first and of the mean of the others */
    const double passes =
        winding->zone > 0.0
            ? 0.5 * (fmin(current / winding->zone, 1.0) + fmin(0.5 * current / winding->zone, 1.0))
            : 1.0;
    bench->seen.voltage = (dq_t){(float)(PERIODS * (resistance * current + passes * winding->rest)), 0.0f};
}

#endif
