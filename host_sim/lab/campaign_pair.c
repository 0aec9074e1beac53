/* A run with learning and the same run without it: whose angle is better where both are steady and what is
 * learnt has arrived. */
#include <math.h>

#include "host_sim/lab/campaign_parts.h"

#define PAIRED_EVERY 8u    /* [-] one of this number of runs with learning is repeated */
#define PAIRED_REST  1u    /* not one of those that are repeated */
#define WINDOW       50e-3 /* [s] */
#define SETTLED      9.0 /* [s] that a wish and a load must be old: L takes 8 s of measurements (theory, 24) */
#define NEAR         0.05 /* [-] of rated speed, within which the speed is steady */
#define WINDOWS_MIN  4u   /* with fewer that are steady in both runs nothing is compared */

/* A load that depends on the angle keeps the angle error changing, independent of the learning. */
static bool has_steady_load(const campaign_case_t *drawn)
{
    return CAMPAIGN_VALUE(drawn, sine) == 0.0 && CAMPAIGN_VALUE(drawn, spring) == 0.0;
}

bool campaign_is_paired(const campaign_case_t *drawn)
{
    bool coded = drawn->around == NULL && campaign_has_encoder(drawn);
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        coded = coded || drawn->events[n].kind == CAMPAIGN_V_SOURCE;
    }
    return campaign_is_healthy(drawn) && !coded && has_steady_load(drawn) &&
           drawn->run % PAIRED_EVERY == PAIRED_REST;
}

void campaign_angles_begin(campaign_angles_t *angles, const campaign_case_t *drawn)
{
    *angles = (campaign_angles_t){
        .blind = campaign_blind_speed(drawn),
        .rated = campaign_motor(drawn).speed,
        .steady = true,
    };
}

static bool is_steady(campaign_angles_t *angles, const campaign_watch_t *watch, const uint32_t *rows)
{
    const uint32_t wish[4] = {rows[CAMPAIGN_AT_enable], rows[CAMPAIGN_AT_mode],
                              rows[CAMPAIGN_AT_speed_request], rows[CAMPAIGN_AT_load_torque]};
    const double speed = campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const double wanted = campaign_number(rows, CAMPAIGN_AT_speed_request);
    angles->settled = memcmp(wish, angles->wish, sizeof wish) == 0 ? angles->settled + 1u : 0u;
    memcpy(angles->wish, wish, sizeof wish);
    return rows[CAMPAIGN_AT_state] == watch->enabled && rows[CAMPAIGN_AT_manoeuvre] == watch->run &&
           rows[CAMPAIGN_AT_mode] == 0u && angles->settled >= campaign_periods(SETTLED) &&
           fabs(speed) >= angles->blind && fabs(speed - wanted) <= NEAR * angles->rated;
}

void campaign_keep_angle(campaign_watch_t *watch, const uint32_t *rows)
{
    campaign_angles_t *angles = watch->angles;
    if (angles == NULL || angles->windows >= CAMPAIGN_ANGLE_WINDOWS) {
        return;
    }
    const double error = campaign_number(rows, CAMPAIGN_AT_theta_err);
    const bool steady = is_steady(angles, watch, rows);
    angles->steady = angles->steady && steady;
    angles->sum += error * error;
    angles->periods++;
    if (angles->periods >= campaign_periods(WINDOW)) {
        angles->square[angles->windows++] = angles->steady ? (float)(angles->sum / angles->periods) : -1.0f;
        angles->sum = 0.0;
        angles->periods = 0u;
        angles->steady = true;
    }
}

void campaign_compare_angles(const campaign_angles_t *with, const campaign_angles_t *without,
                             campaign_result_t *result)
{
    const uint32_t windows = with->windows < without->windows ? with->windows : without->windows;
    const double limit = 1e-3 * campaign_invariants[CAMPAIGN_I_LEARN].limit;
    double squares[2] = {0.0, 0.0};
    uint32_t common = 0;
    uint32_t first = 0;
    uint32_t last = 0;
    for (uint32_t n = 0; n < windows; n++) {
        if (with->square[n] >= 0.0f && without->square[n] >= 0.0f) {
            squares[0] += (double)with->square[n];
            squares[1] += (double)without->square[n];
            first = common == 0u ? n : first;
            last = n;
            common++;
        }
    }
    if (common >= WINDOWS_MIN && sqrt(squares[0] / common) > sqrt(squares[1] / common) + limit) {
        result->end = CAMPAIGN_VIOLATED;
        result->invariant = CAMPAIGN_I_LEARN;
        result->from = first * campaign_periods(WINDOW);
        result->period = (last + 1u) * campaign_periods(WINDOW) - 1u;
        result->row = rig_row_by_name("theta_err")->id;
    }
}
