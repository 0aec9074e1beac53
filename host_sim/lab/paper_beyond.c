/* The rows beyond the paper. */
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/paper_parts.h"

static const result_t *of(const paper_t *paper, figure_t figure, const char *variant, int load, int n,
                          bool real)
{
    char name[32];
    snprintf(name, sizeof name, "%s_%s_%d", variant, load_names[load], n);
    return paper_find(paper, figure, name, real);
}

/* The worst of several numbers, and what it was measured on. */
typedef struct {
    double ours;
    const result_t *at;
    bool stopped;
} worst_t;

static void consider(worst_t *worst, const result_t *result, double number)
{
    worst->stopped = worst->stopped || result->lost;
    if (worst->at == NULL || fabs(number) > fabs(worst->ours)) {
        worst->ours = number;
        worst->at = result;
    }
}

static void row_of_worst(paper_t *paper, const claim_t *claim, const worst_t *worst, const char *condition)
{
    char text[120];
    snprintf(text, sizeof text, "worst of %s", condition);
    paper_row_of_several(paper, claim, worst->at, worst->stopped, worst->ours, false, text);
}

/* ---- over speed ---- */

/* What (14) as printed leaves of the sampled observer's lag [mrad]. */
static double left_by_printed(double rpm)
{
    const double omega_e = paper_machine.pole_pairs * rpm * RPM;
    return (paper_lag_sampled(KS, 1.0, omega_e) - paper_lag_printed(KS, 1.0, omega_e)) / MRAD;
}

static void judge_speed(paper_t *paper, bool real)
{
    const int fastest = SPEEDS_BEYOND - 1;
    worst_t lagless = {0};
    worst_t uncompensated = {0};
    worst_t printed = {0};
    for (int n = 0; n < SPEEDS_BEYOND; n++) {
        const double omega_e = paper_machine.pole_pairs * speeds_beyond[n] * RPM;
        const double lag = paper_lag_sampled(KS, 1.0, omega_e) / MRAD;
        const result_t *none = of(paper, BEYOND_SPEED, speed_variants[V_UNCOMPENSATED], 1, n, real);
        const result_t *paper_s = of(paper, BEYOND_SPEED, speed_variants[V_PRINTED], 1, n, real);
        const result_t *ours = of(paper, BEYOND_SPEED, speed_variants[V_LAGLESS], 1, n, real);
        if (speeds_beyond[n] >= 300.0) {
            consider(&lagless, ours, ours->numbers[0].mean);
            consider(&uncompensated, none, none->numbers[0].mean - lag);
            consider(&printed, paper_s, paper_s->numbers[0].mean - left_by_printed(speeds_beyond[n]));
        }
    }
    const char *condition = "six speeds from 307 r/min, 5 N m";
    /* Ideal: float arithmetic and the speed's settling; real: what the compensation leaves (docs/theory.md,
     * 21). */
    const claim_t small =
        paper_claim_of_theory(BEYOND_SPEED, "lagless", "lagless: largest mean error at 5 N m from 300 r/min",
                              "mrad", 0.0, real ? 1.5 : 0.5, "more is left");
    /* Theory's k_f is that of one sine; harmonics and rounding add up to 0.3 mrad (docs/theory.md, 4, the
     * table), and what the inverter adds is as above. */
    const claim_t none = paper_claim_of_theory(
        BEYOND_SPEED, "uncompensated", "not compensated: distance from theory of the sampled observer",
        "mrad", 0.0, real ? 2.5 : 1.0, "the distance is larger");
    /* The real drive adds the devices' 0.02 ohm to R; (14) as printed divides by it: 2 % of 93 mrad. */
    const double printed_tolerance = real ? 4.5 : 1.5;
    const claim_t as_printed = paper_claim_of_theory(
        BEYOND_SPEED, "printed", "(14) as printed: distance from theory of what it leaves", "mrad", 0.0,
        printed_tolerance, "the distance is larger");
    row_of_worst(paper, &small, &lagless, condition);
    row_of_worst(paper, &none, &uncompensated, condition);
    row_of_worst(paper, &as_printed, &printed, condition);

    const result_t *fast = of(paper, BEYOND_SPEED, speed_variants[V_PRINTED], 1, fastest, real);
    /* docs/theory.md, 4, at 1500 r/min: 35.5 with the power-weighted k_f of the firmware; a plain mean of k_f
     * leaves 32.5. */
    const claim_t leaves = paper_claim_of_theory(
        BEYOND_SPEED, "printed_1490", "(14) as printed, 1490 r/min: what is left", "mrad",
        left_by_printed(speeds_beyond[fastest]), printed_tolerance, "another number is left");
    paper_row_of(paper, &leaves, fast, fast->numbers[0].mean, false);
}

/* ---- over bandwidth ---- */

static double ki_of(const result_t *result)
{
    double kp = 0.0;
    double ki = 0.0;
    (void)paper_loop(result->run.bandwidth, result->run.omega_c, &kp, &ki);
    return ki;
}

static void judge_bandwidth(paper_t *paper, bool real)
{
    worst_t conventional = {0};
    worst_t feedforward = {0};
    worst_t torque = {0};
    int lost = 0;
    for (int n = 0; n < BANDWIDTHS_BEYOND; n++) {
        for (int load = 0; load < 2; load++) {
            const result_t *plain =
                of(paper, BEYOND_BANDWIDTH, bandwidth_variants[V_CONVENTIONAL], load, n, real);
            const result_t *forward =
                of(paper, BEYOND_BANDWIDTH, bandwidth_variants[V_FEEDFORWARD], load, n, real);
            const result_t *told =
                of(paper, BEYOND_BANDWIDTH, bandwidth_variants[V_TORQUE_FEEDFORWARD], load, n, real);
            lost += told->lost;
            if (bandwidths_beyond[n] >= 100.0) { /* a conventional one of 50 rad/s is lost */
                const numbers_t *up = &plain->numbers[UP];
                consider(&conventional, plain,
                         up->plateau - paper_tracking_error(ki_of(plain), up->acceleration) / MRAD);
                consider(&feedforward, forward, forward->numbers[UP].plateau);
                consider(&torque, told, fmax(told->numbers[UP].peak, told->numbers[DOWN].peak));
            }
        }
    }
    const char *condition = "five bandwidths from 100 to 400 rad/s, no load and 5 N m";
    /* Ideal: what has not settled. Real: what the inverter's compensation leaves towards 1500 r/min without
     * load (docs/theory.md, 21). */
    const claim_t follows = paper_claim_of_theory(
        BEYOND_BANDWIDTH, "conventional", "conventional: distance of the steady error from asin(a/k_i)",
        "mrad", 0.0, real ? 4.0 : 0.5, "the distance is larger");
    const claim_t none = paper_claim_of_theory(BEYOND_BANDWIDTH, "feedforward",
                                               "feed-forward: largest steady error while accelerating",
                                               "mrad", 0.0, real ? 4.0 : 2.0, "more is left");
    /* Real: what dead time adds while i_q passes zero (docs/theory.md, 21). */
    const claim_t small = paper_claim_of_theory(BEYOND_BANDWIDTH, "torque_feedforward",
                                                "torque fed forward: largest error of both speed changes",
                                                "mrad", 0.0, real ? 24.0 : 10.0, "it is larger");
    const claim_t all = paper_claim_of_theory(
        BEYOND_BANDWIDTH, "lost", "torque fed forward: runs of 14, from 50 rad/s up, that are lost", "-", 0.0,
        0.0, "some are");
    row_of_worst(paper, &follows, &conventional, condition);
    row_of_worst(paper, &none, &feedforward, condition);
    row_of_worst(paper, &small, &torque, condition);
    paper_row_of_several(paper, &all, torque.at, false, lost, false,
                         "seven bandwidths from 50 to 400 rad/s, no load and 5 N m");
}

/* ---- the map ---- */

static void judge_map(paper_t *paper)
{
    static const struct {
        const char *id, *claim;
    } claims[MAP_CLAIMS] = {
        [MAP_CLAIM_INDUCTANCE] = {"inductance", "L off by 20 %: distance from -asin(dL i_q/psi_f)"},
        [MAP_CLAIM_NO_EFFECT] = {"no_effect", "psi_f off by 10 %, R by 50 %: what they move the mean by"},
        [MAP_CLAIM_LEARNT] = {"learnt",
                              "L off by 20 %, adaptation on and sure: what is left of it in the mean"},
    };
    for (map_claim_t n = MAP_CLAIM_INDUCTANCE; n < MAP_CLAIMS; n++) {
        const map_verdict_t verdict = map_judge(paper->points, paper->point_count, n);
        char condition[240];
        snprintf(
            condition, sizeof condition,
            "every gate edge; worst of %zu points, 100 to 1490 r/min in both directions, no load and 5 N "
            "m; vector sigmoid, exact lag, PLL 200 rad/s, omega_c 50 rad/s; inverter compensated",
            verdict.judged);
        const claim_t claim = paper_claim_of_theory(BEYOND_MAP, claims[n].id, claims[n].claim, "mrad", 0.0,
                                                    verdict.limit_mrad, "the distance is larger");
        paper_row_of_map(paper, &claim, verdict.lost > 0u,
                         verdict.judged > 0u ? verdict.worst_mrad : (double)NAN, condition);
    }
}

void paper_judge_beyond(paper_t *paper, figure_t figure)
{
    if (figure == BEYOND_MAP) {
        judge_map(paper);
        return;
    }
    for (int real = 1; real >= 0; real--) {
        if (figure == BEYOND_SPEED) {
            judge_speed(paper, real != 0);
        } else {
            judge_bandwidth(paper, real != 0);
        }
    }
}
