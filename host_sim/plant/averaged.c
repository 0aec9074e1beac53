#include "host_sim/plant/averaged.h"

#include <math.h>

#include "host_sim/plant/interval.h"

#define TICK       (1.0 / 150e6)
#define INV_SQRT_3 0.57735026918962576451

/* Repetitions end when no sign has changed by more than this [-], or after so many. */
#define SETTLED     1e-5
#define MOST_PASSES 8

/* A leg between its two switches, both off. Times from the nearer end of the period. */
typedef struct {
    double near;   /* [s] border to the switch that is on at the ends */
    double far;    /* [s] border to the other */
    double sign;   /* [-] mean of the current's sign between them, -1..1 */
    double leaves; /* [s] border in effect: its mean voltage as of an edge */
    double i_near; /* [A] current at `near` */
    double i_far;  /* [A] at `far` */
} handover_t;

typedef struct {
    double way;                     /* [-] 1: the upper switches are on at the ends; -1: the lower */
    double length;                  /* T [s] */
    double volt;                    /* way V_dc [V] */
    double free[3];                 /* by EMF and resistance, mean [A/s] */
    double turn[3];                 /* half of what that changes per second [A/s^2] */
    double slope[3];                /* F, `free` and drops [A/s] */
    double by_alpha[3], by_beta[3]; /* G [A/(V s)] */
    double begin[3], end[3];        /* [A] currents at the ends */
    double follow[3];               /* [-] share of a new sign that is taken over */
    handover_t first[3], second[3];
} period_t;

/* Current of a leg that the flux of the three legs makes [A]. */
static double made(const period_t *period, int leg, double flux_a, double flux_b, double flux_c)
{
    return period->by_alpha[leg] * (2.0 * flux_a - flux_b - flux_c) * (1.0 / 3.0) +
           period->by_beta[leg] * (flux_b - flux_c) * INV_SQRT_3;
}

/* A leg's current [A] at t from the end of the period that `from` is of, the leg itself on for `own` of it;
 * ahead: 1 from its begin, -1 back from its end. */
static double current_at(const period_t *period, const handover_t half[3], const double from[3], double ahead,
                         int leg, double t, double own)
{
    double on[3];
    for (int x = 0; x < 3; x++) {
        on[x] = period->volt * (half[x].leaves < t ? half[x].leaves : t);
    }
    on[leg] = period->volt * own;
    return from[leg] + ahead * (period->slope[leg] * t + made(period, leg, on[0], on[1], on[2])) -
           period->turn[leg] * t * (period->length - t);
}

/* Antiderivative of the sign that is linear inside the zone [A]. */
static double sign_integral(const plant_t *plant, double i)
{
    double size = fabs(i);
    return size < plant->zone ? 0.5 * i * i * plant->zone_inverse : size - 0.5 * plant->zone;
}

/* Mean of that sign while the current goes in a straight line from x to y. */
static double sign_mean(const plant_t *plant, double x, double y)
{
    double zone = plant->zone;
    if (x >= zone && y >= zone) {
        return 1.0;
    }
    if (x <= -zone && y <= -zone) {
        return -1.0;
    }
    if (fabs(y - x) < 1e-7) {
        double middle = 0.5 * (x + y) * plant->zone_inverse;
        return middle > 1.0 ? 1.0 : middle < -1.0 ? -1.0 : middle;
    }
    return (sign_integral(plant, y) - sign_integral(plant, x)) / (y - x);
}

static void set_sign(const period_t *period, handover_t *edge, double sign)
{
    edge->sign = sign;
    edge->leaves = edge->near + (edge->far - edge->near) * 0.5 * (1.0 - period->way * sign);
}

static void describe(const plant_t *plant, period_t *period)
{
    bool upper = plant->averaged == PLANT_AVERAGED_UPPER;
    double ticks = (double)plant->period;
    double delays = (double)plant->dead + (double)plant->turn_on_ticks;
    double both_off = delays - (double)plant->turn_off_ticks;
    double late = 0.5 * (delays + (double)plant->turn_off_ticks) * TICK;
    period->way = upper ? 1.0 : -1.0;
    period->length = ticks * TICK;
    period->volt = period->way * plant->v_dc;
    double begin[3], end[3];
    interval_phase_slopes(plant, period->length, begin, end, period->by_alpha, period->by_beta);
    for (int leg = 0; leg < 3; leg++) {
        bool switches = plant->high[leg] > 0u && plant->high[leg] < plant->period;
        double on = (double)(upper ? plant->high[leg] : plant->period - plant->high[leg]);
        double width = switches && both_off > 0.0 ? both_off : 0.0;
        handover_t *edge = &period->first[leg];
        edge->near = on > width ? 0.5 * (on - width) * TICK : 0.0;
        edge->far = 0.5 * (on + width < ticks ? on + width : ticks) * TICK;
        period->free[leg] = 0.5 * (begin[leg] + end[leg]);
        period->turn[leg] = 0.5 * (end[leg] - begin[leg]) / period->length;
        double i = plant->i[leg] + late * period->free[leg];
        period->begin[leg] = i;
        period->end[leg] = i;
        edge->i_near = i;
        edge->i_far = i;
        set_sign(period, edge, sign_mean(plant, i, i));
        period->second[leg] = *edge;
        /* What a sign does to the mean current of its own hand-over decides how far to follow the new one. */
        double per_volt = made(period, leg, leg == 0, leg == 1, leg == 2);
        double own = 0.25 * per_volt * plant->v_dc * (edge->far - edge->near) * plant->zone_inverse;
        period->follow[leg] = 1.0 / (1.0 + own);
    }
}

/* Currents at the borders of one half's hand-overs, `from` its end and `ahead` 1 or -1 with time, and the
 * signs by these. Returns the sum of what the signs have changed. */
static double meet(const plant_t *plant, period_t *period, handover_t half[3], const double from[3],
                   double ahead)
{
    double change = 0.0;
    for (int leg = 0; leg < 3; leg++) {
        handover_t *edge = &half[leg];
        edge->i_near = current_at(period, half, from, ahead, leg, edge->near, edge->near);
        edge->i_far = current_at(period, half, from, ahead, leg, edge->far, edge->leaves);
        double more = sign_mean(plant, edge->i_near, edge->i_far) - edge->sign;
        set_sign(period, edge, edge->sign + period->follow[leg] * more);
        change += fabs(more);
    }
    return change;
}

/* Mean pole voltage of a leg along the polygon of its current [V]. */
static double pole_voltage(const plant_t *plant, const period_t *period, int leg)
{
    const handover_t *first = &period->first[leg];
    const handover_t *second = &period->second[leg];
    const plant_law_t *off = &plant->law[PLANT_LAW_OFF];
    const plant_law_t *ends = &plant->law[period->way > 0.0 ? PLANT_LAW_UPPER : PLANT_LAW_LOWER];
    const plant_law_t *middle = &plant->law[period->way > 0.0 ? PLANT_LAW_LOWER : PLANT_LAW_UPPER];
    double flux =
        first->near * interval_pole_mean(plant, ends, period->begin[leg], first->i_near) +
        (first->far - first->near) * interval_pole_mean(plant, off, first->i_near, first->i_far) +
        (period->length - first->far - second->far) *
            interval_pole_mean(plant, middle, first->i_far, second->i_far) +
        (second->far - second->near) * interval_pole_mean(plant, off, second->i_far, second->i_near) +
        second->near * interval_pole_mean(plant, ends, second->i_near, period->end[leg]);
    return flux / period->length;
}

/* Share of the period that the leg is at the upper rail, by the borders in effect. */
static double share_of(const period_t *period, int leg)
{
    double at_ends = (period->first[leg].leaves + period->second[leg].leaves) / period->length;
    return period->way > 0.0 ? at_ends : 1.0 - at_ends;
}

/* The drops of the polygon as it is, as if they were the same all the period. */
static void take_drops(const plant_t *plant, period_t *period)
{
    double drop[3];
    for (int leg = 0; leg < 3; leg++) {
        drop[leg] = pole_voltage(plant, period, leg) - share_of(period, leg) * plant->v_dc;
    }
    for (int leg = 0; leg < 3; leg++) {
        period->slope[leg] = period->free[leg] + made(period, leg, drop[0], drop[1], drop[2]);
    }
}

static void settle(const plant_t *plant, period_t *period)
{
    double change = 1.0;
    for (int pass = 0; pass < MOST_PASSES && change > SETTLED; pass++) {
        take_drops(plant, period);
        change = meet(plant, period, period->first, period->begin, 1.0);
        double on[3];
        for (int x = 0; x < 3; x++) {
            on[x] = period->volt * (period->first[x].leaves + period->second[x].leaves);
        }
        for (int leg = 0; leg < 3; leg++) {
            period->end[leg] = period->begin[leg] + period->slope[leg] * period->length +
                               made(period, leg, on[0], on[1], on[2]);
        }
        change += meet(plant, period, period->second, period->end, -1.0);
    }
}

void averaged_period(plant_t *plant)
{
    period_t period;
    describe(plant, &period);
    settle(plant, &period);
    for (int leg = 0; leg < 3; leg++) {
        double share = share_of(&period, leg);
        /* The slope of the drops goes with the current, about its mean. */
        double mean = plant->i[leg] + 0.5 * (period.end[leg] - period.begin[leg]);
        double drop = pole_voltage(plant, &period, leg) - share * plant->v_dc + plant->r_mean * mean;
        plant->law[PLANT_LAW_AVERAGED + leg] =
            (plant_law_t){{share, share}, {drop, drop}, {plant->r_mean, plant->r_mean}};
    }
    plant->period_end = plant->tick + plant->period;
}
