#include "host_sim/plant/averaged.h"

#include <math.h>
#include <stddef.h>

#include "host_sim/plant/interval.h"

#define TICK       (1.0 / 150e6)
#define INV_SQRT_3 0.57735026918962576451

/* Repetitions end when the signs of all hand-overs together have changed by no more than this [-], 4 mV of a
 * leg, or after this number. */
#define SETTLED     1e-3
#define MOST_PASSES 8

/* The interval in which both switches of a leg are off. Times count from the nearer end of the period. */
typedef struct {
    double near;   /* [s] border to the switch that is on at the ends */
    double far;    /* [s] border to the other switch */
    double sign;   /* [-] mean of the current's sign between them, -1..1 */
    double leaves; /* [s] effective border: an edge at this time has the same mean voltage */
    double i_near; /* [A] current at `near` */
    double i_far;  /* [A] at `far` */
} handover_t;

typedef struct {
    double way;              /* [-] 1: the upper switches are on at the ends; -1: the lower */
    double length, rate;     /* T [s], 1/T [1/s] */
    double free[3];          /* by EMF and resistance, mean [A/s] */
    double turn[3];          /* half of the change of this rate per second [A/s^2] */
    double slope[3];         /* slope F: `free` and the drops [A/s] */
    double drop[3];          /* [V] mean pole voltage beyond V_dc times the share at the upper rail */
    double volt;             /* way V_dc [V] */
    double by_leg[3][3];     /* G: slope of the current of a phase for each volt of a leg [A/(V s)] */
    double begin[3], end[3]; /* [A] currents at the ends */
    double follow[3];        /* [-] share of the change of a sign that one repetition applies */
    handover_t first[3], second[3];
} period_t;

/* A leg's current [A] at t from the end of the period that `from` is of, the leg itself on for `own` of it;
 * ahead: 1 from its begin, -1 back from its end. */
static inline double current_at(const period_t *period, const handover_t half[3], const double from[3],
                                double ahead, int leg, double t, double own)
{
    const double *by_leg = period->by_leg[leg];
    double on = by_leg[leg] * own;
    for (int x = 0; x < 3; x++) {
        if (x != leg) {
            on += by_leg[x] * (half[x].leaves < t ? half[x].leaves : t);
        }
    }
    double way = period->slope[leg] * t + period->volt * on;
    return from[leg] + ahead * way - period->turn[leg] * t * (period->length - t);
}

/* Antiderivative of the sign that is linear inside the zone [A]. */
static inline double sign_integral(const plant_t *plant, double i)
{
    double size = fabs(i);
    return size < plant->zone ? 0.5 * i * i * plant->zone_inverse : size - 0.5 * plant->zone;
}

/* Mean of that sign while the current changes linearly from x to y. */
static inline double sign_mean(const plant_t *plant, double x, double y)
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

/* Drop [V] of a leg that is at the upper rail for this share of the time, at one current. */
static double drop_at(const plant_t *plant, int leg, double share, double i)
{
    double at_lower;
    double at_upper;
    double lower = interval_pole(plant, &plant->law[leg][PLANT_LAW_LOWER], i, &at_lower);
    double upper = interval_pole(plant, &plant->law[leg][PLANT_LAW_UPPER], i, &at_upper);
    return lower + share * (upper - plant->v_dc - lower);
}

static void describe(const plant_t *plant, period_t *period)
{
    bool upper = plant->averaged == PLANT_AVERAGED_UPPER;
    double ticks = (double)plant->period;
    period->way = upper ? 1.0 : -1.0;
    period->length = ticks * TICK;
    period->rate = 1.0 / period->length;
    period->volt = period->way * plant->v_dc;
    double begin[3], end[3], by_alpha[3], by_beta[3];
    interval_phase_slopes(plant, period->length, begin, end, by_alpha, by_beta);
    for (int leg = 0; leg < 3; leg++) {
        /* Clarke transform of one volt of a leg: alpha 2/3, -1/3, -1/3; beta 0, +-1/sqrt 3. */
        period->by_leg[leg][0] = by_alpha[leg] * (2.0 / 3.0);
        period->by_leg[leg][1] = by_beta[leg] * INV_SQRT_3 - by_alpha[leg] * (1.0 / 3.0);
        period->by_leg[leg][2] = -by_beta[leg] * INV_SQRT_3 - by_alpha[leg] * (1.0 / 3.0);
        double delays = (double)plant->dead + (double)plant->turn_on_ticks[leg];
        double both_off = delays - (double)plant->turn_off_ticks;
        double late = 0.5 * (delays + (double)plant->turn_off_ticks) * TICK;
        bool switches = plant->high[leg] > 0u && plant->high[leg] < plant->period;
        double on = (double)(upper ? plant->high[leg] : plant->period - plant->high[leg]);
        double width = switches && both_off > 0.0 ? both_off : 0.0;
        handover_t *edge = &period->first[leg];
        edge->near = on > width ? 0.5 * (on - width) * TICK : 0.0;
        edge->far = 0.5 * (on + width < ticks ? on + width : ticks) * TICK;
        period->free[leg] = 0.5 * (begin[leg] + end[leg]);
        period->turn[leg] = 0.5 * (end[leg] - begin[leg]) * period->rate;
        double i = plant->i[leg] + late * period->free[leg];
        period->begin[leg] = i;
        period->drop[leg] = drop_at(plant, leg, (double)plant->high[leg] / ticks, i);
        set_sign(period, edge, sign_mean(plant, i, i));
        period->second[leg] = *edge;
        /* The effect of a sign on the mean current of its own hand-over determines how much of the new value
         * is taken. */
        double own = 0.25 * period->by_leg[leg][leg] * fabs(plant->v_dc) * (edge->far - edge->near);
        period->follow[leg] = 1.0 / (1.0 + own * plant->zone_inverse);
    }
}

/* Currents at the borders of one half's hand-overs, `from` its end and `ahead` 1 or -1 with time, and the
 * signs by these. Returns the sum of the changes that the signs have caused. */
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

/* The same as interval_pole_mean, but faster if the current stays outside the zone. */
static inline double along(const plant_t *plant, const plant_law_t *law, double x, double y)
{
    double zone = plant->zone;
    bool positive = x >= zone && y >= zone;
    if (positive || (x <= -zone && y <= -zone)) {
        size_t side = !positive;
        return law->s[side] * plant->v_dc + law->d[side] - law->r[side] * 0.5 * (x + y);
    }
    return interval_pole_mean(plant, law, x, y);
}

/* Mean pole voltage of a leg along the polygon of its current [V]. */
static double pole_voltage(const plant_t *plant, const period_t *period, int leg)
{
    const handover_t *first = &period->first[leg];
    const handover_t *second = &period->second[leg];
    const plant_law_t *law = plant->law[leg];
    const plant_law_t *off = &law[PLANT_LAW_OFF];
    const plant_law_t *ends = &law[period->way > 0.0 ? PLANT_LAW_UPPER : PLANT_LAW_LOWER];
    const plant_law_t *middle = &law[period->way > 0.0 ? PLANT_LAW_LOWER : PLANT_LAW_UPPER];
    double flux =
        first->near * along(plant, ends, period->begin[leg], first->i_near) +
        (first->far - first->near) * along(plant, off, first->i_near, first->i_far) +
        (period->length - first->far - second->far) * along(plant, middle, first->i_far, second->i_far) +
        (second->far - second->near) * along(plant, off, second->i_far, second->i_near) +
        second->near * along(plant, ends, second->i_near, period->end[leg]);
    return flux * period->rate;
}

/* Share of the period that the leg is at the upper rail, by the borders in effect. */
static double share_of(const period_t *period, int leg)
{
    double at_ends = (period->first[leg].leaves + period->second[leg].leaves) * period->rate;
    return period->way > 0.0 ? at_ends : 1.0 - at_ends;
}

/* Repeats until signs and currents agree. Afterwards the drops are those of the last polygon. */
static void settle(const plant_t *plant, period_t *period)
{
    double change = 1.0;
    for (int pass = 0; pass < MOST_PASSES && change > SETTLED; pass++) {
        for (int leg = 0; leg < 3; leg++) {
            const double *by_leg = period->by_leg[leg];
            const double *drop = period->drop;
            period->slope[leg] =
                period->free[leg] + by_leg[0] * drop[0] + by_leg[1] * drop[1] + by_leg[2] * drop[2];
        }
        change = meet(plant, period, period->first, period->begin, 1.0);
        for (int leg = 0; leg < 3; leg++) {
            double on = 0.0;
            for (int x = 0; x < 3; x++) {
                on += period->by_leg[leg][x] * (period->first[x].leaves + period->second[x].leaves);
            }
            period->end[leg] = period->begin[leg] + period->slope[leg] * period->length + period->volt * on;
        }
        change += meet(plant, period, period->second, period->end, -1.0);
        for (int leg = 0; leg < 3; leg++) {
            period->drop[leg] = pole_voltage(plant, period, leg) - share_of(period, leg) * plant->v_dc;
        }
    }
}

void averaged_period(plant_t *plant)
{
    period_t period;
    describe(plant, &period);
    settle(plant, &period);
    for (int leg = 0; leg < 3; leg++) {
        double share = share_of(&period, leg);
        /* The slope of the drops is proportional to the difference of the current from its mean. */
        double mean = plant->i[leg] + 0.5 * (period.end[leg] - period.begin[leg]);
        double drop = period.drop[leg] + plant->r_mean * mean;
        plant->law[leg][PLANT_LAW_AVERAGED] =
            (plant_law_t){{share, share}, {drop, drop}, {plant->r_mean, plant->r_mean}};
    }
    plant->period_end = plant->tick + plant->period;
}
