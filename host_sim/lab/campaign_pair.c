/* A run with learning and the same run without it: compares the angle errors while both are steady and the
 * learnt values have settled. */
#include <math.h>

#include "host_sim/lab/campaign_parts.h"

#define PAIRED_EVERY 8u    /* [-] one of this number of runs with learning is repeated */
#define PAIRED_REST  1u    /* remainder that differs from that of the runs that are repeated */
#define WINDOW       50e-3 /* [s] */
#define SETTLED      9.0   /* [s] of constant request and load: L takes 8 s of measurements (theory, 24) */
#define NEAR         0.05  /* [-] of rated speed, within which the speed is steady */
#define WINDOWS_MIN  4u    /* [periods] with fewer periods that are steady in both runs nothing is compared */
#define LEGS         3.0   /* [-] share of one leg in the mean of all */
#define SHAPED       225.0 /* [rad/s] electrical: above this speed the loop does not follow the EMF's harmonics */
/* [-] of the true value: from this difference on a learnt value counts as changed */
#define MOVED 0.005

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

double campaign_lost_time(const campaign_case_t *drawn)
{
    return rig_initial_named("dead_time") - rig_initial_named("plant.turn_off_delay") +
           CAMPAIGN_VALUE(drawn, turn_on_delay) * rig_initial_named("plant.turn_on_delay") +
           CAMPAIGN_VALUE(drawn, leg_delay) / LEGS;
}

double campaign_lost_voltage(const campaign_case_t *drawn)
{
    return 0.5 * CAMPAIGN_VALUE(drawn, drops) *
               (rig_initial_named("igbt_voltage") + rig_initial_named("diode_voltage")) +
           CAMPAIGN_VALUE(drawn, leg_drop) / LEGS;
}

double campaign_series_resistance(const campaign_case_t *drawn)
{
    return campaign_motor(drawn).resistance * (1.0 + CAMPAIGN_VALUE(drawn, leg_resistance) / LEGS) +
           0.5 * CAMPAIGN_VALUE(drawn, drops) *
               (rig_initial_named("igbt_resistance") + rig_initial_named("diode_resistance"));
}

void campaign_angles_begin(campaign_angles_t *angles, const campaign_case_t *drawn)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    *angles = (campaign_angles_t){
        .blind = campaign_blind_speed(drawn),
        .rated = motor.speed,
        .shape = fabs(CAMPAIGN_VALUE(drawn, emf_5th) + CAMPAIGN_VALUE(drawn, emf_7th)) / sqrt(2.0),
        .shaped = SHAPED / motor.pole_pairs,
        .steady = true,
        .lost_time = campaign_lost_time(drawn) / RIG_PERIOD_SECONDS,
        .drop = campaign_lost_voltage(drawn),
        .truth = {0.0, motor.inductance_q, campaign_series_resistance(drawn)},
    };
}

/* What has been learnt until now, and the voltage that a leg loses at the present link. */
static void keep_learnt(campaign_angles_t *angles, const uint32_t *rows)
{
    for (uint32_t n = 0; n < (uint32_t)CAMPAIGN_LEARNT_COUNT; n++) {
        angles->learnt[n] = campaign_number(rows, CAMPAIGN_AT_dead_time_hat + n);
    }
    angles->truth[0] = angles->lost_time * campaign_number(rows, CAMPAIGN_AT_true_u_dc) + angles->drop;
}

/* If the learnt values are nearer to the true ones, they are not the cause of a larger mean: for small errors
 * the mean of the angle error is a sum of one part for each value, proportional to the error of this value.
 * If each part decreases and the sum becomes larger, then the errors of the configured values have
 * compensated each other. The ripple is such a sum, too: an error of the dead time may compensate the sixth
 * harmonic that the fifth and seventh harmonics of the EMF make. */
bool campaign_is_truer(const campaign_angles_t *with, const campaign_angles_t *without)
{
    bool truer = false;
    for (uint32_t n = 0; n < (uint32_t)CAMPAIGN_LEARNT_COUNT; n++) {
        const double truth = with->truth[n];
        const bool moved = fabs(with->learnt[n] - without->learnt[n]) > MOVED * fabs(truth);
        if (moved && fabs(with->learnt[n] - truth) >= fabs(without->learnt[n] - truth)) {
            return false;
        }
        truer = truer || moved;
    }
    return truer;
}

static bool is_steady(campaign_angles_t *angles, const campaign_watch_t *watch, const uint32_t *rows)
{
    const uint32_t wish[4] = {rows[CAMPAIGN_AT_enable], rows[CAMPAIGN_AT_mode],
                              rows[CAMPAIGN_AT_speed_request], rows[CAMPAIGN_AT_load_torque]};
    const double speed = campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const double wanted = campaign_number(rows, CAMPAIGN_AT_speed_request);
    angles->settled = memcmp(wish, angles->wish, sizeof wish) == 0 ? angles->settled + 1u : 0u;
    memcpy(angles->wish, wish, sizeof wish);
    const bool steady = rows[CAMPAIGN_AT_state] == watch->enabled &&
                        rows[CAMPAIGN_AT_manoeuvre] == watch->run && rows[CAMPAIGN_AT_mode] == 0u &&
                        angles->settled >= campaign_periods(SETTLED) && fabs(speed) >= angles->blind &&
                        fabs(speed - wanted) <= NEAR * angles->rated;
    angles->speed = steady ? fabs(speed) : angles->speed;
    return steady;
}

void campaign_keep_angle(campaign_watch_t *watch, const uint32_t *rows)
{
    campaign_angles_t *angles = watch->angles;
    if (angles == NULL || angles->windows >= CAMPAIGN_ANGLE_WINDOWS) {
        return;
    }
    const double error = campaign_number(rows, CAMPAIGN_AT_theta_err);
    const bool steady = is_steady(angles, watch, rows);
    keep_learnt(angles, rows);
    angles->steady = angles->steady && steady;
    angles->squares += error * error;
    angles->sum += error;
    angles->periods++;
    if (angles->periods >= campaign_periods(WINDOW)) {
        angles->square[angles->windows] = angles->steady ? (float)(angles->squares / angles->periods) : -1.0f;
        angles->mean[angles->windows++] = (float)(angles->sum / angles->periods);
        angles->squares = 0.0;
        angles->sum = 0.0;
        angles->periods = 0u;
        angles->steady = true;
    }
}

/* The angle error over the windows that are steady in both runs. */
typedef struct {
    double square; /* [rad^2] sum of the mean squares of the windows */
    double mean;   /* [rad] sum of their means */
    uint32_t windows;
} common_t;

static common_t add(common_t common, const campaign_angles_t *angles, uint32_t window)
{
    return (common_t){common.square + (double)angles->square[window],
                      common.mean + (double)angles->mean[window], common.windows + 1u};
}

static double rms(common_t common)
{
    return sqrt(common.square / common.windows);
}

/* The standard deviation. */
static double ripple(common_t common)
{
    const double mean = common.mean / common.windows;
    return sqrt(fmax(common.square / common.windows - mean * mean, 0.0));
}

bool campaign_compare_angles(const campaign_angles_t *with, const campaign_angles_t *without,
                             campaign_result_t *result)
{
    const uint32_t windows = with->windows < without->windows ? with->windows : without->windows;
    const double limit = 1e-3 * campaign_invariants[CAMPAIGN_I_LEARN].limit;
    common_t learnt = {0.0, 0.0, 0u};
    common_t configured = {0.0, 0.0, 0u};
    uint32_t first = 0;
    uint32_t last = 0;
    for (uint32_t n = 0; n < windows; n++) {
        if (with->square[n] >= 0.0f && without->square[n] >= 0.0f) {
            first = learnt.windows == 0u ? n : first;
            last = n;
            learnt = add(learnt, with, n);
            configured = add(configured, without, n);
        }
    }
    if (learnt.windows < WINDOWS_MIN) {
        return false;
    }
    const bool larger = rms(learnt) > rms(configured) + limit;
    const double shape = without->speed <= without->shaped ? without->shape : 0.0;
    const bool rippled = ripple(learnt) > ripple(configured) + limit + shape;
    const bool worse = larger && (rippled || !campaign_is_truer(with, without));
    if (worse) {
        result->end = CAMPAIGN_VIOLATED;
        result->invariant = CAMPAIGN_I_LEARN;
        result->from = first * campaign_periods(WINDOW);
        result->period = (last + 1u) * campaign_periods(WINDOW) - 1u;
        result->row = rig_row_by_name("theta_err")->id;
    }
    return worse;
}
