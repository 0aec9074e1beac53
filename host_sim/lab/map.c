#include "host_sim/lab/map.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/dynamometer.h"
#include "host_sim/lab/paper_drive.h"
#include "host_sim/lab/pool.h"
#include "host_sim/lab/scenario_parts.h"
#include "host_sim/rig/rig.h"

#define PI               3.14159265358979323846
#define RPM              (2.0 * PI / 60.0) /* [rad/s] */
#define MRAD             1e-3              /* [rad] */
#define LOCK_MRAD        250.0             /* limit of mean and SD */
#define LOCK_SPEED       0.05              /* [-] of the reference */
#define LOCK_RPM         10.0              /* [r/min] */
#define CHANGES_MAX      12u
#define CHANGES_OF_POINT 2u
#define LEARN_HERTZ      20.0                /* [Hz] electrical */
#define LEARN_LONGER     2.0                 /* [-] */
#define EVENLY           0.38196601125010515 /* [-] (3 - sqrt 5)/2 */
#define NOT_WHOLE        1e-6                /* [-] largest rounding error of a whole number */

/* ---- the changes of a point ---- */

/* The row's value becomes factor times it plus shift. */
typedef struct {
    const char *row;
    double factor; /* [-] */
    double shift;  /* [unit of the row] */
} change_t;

typedef struct {
    const char *name;
    bool machine; /* a deviation of the motor data, which also exists with an ideal inverter */
    change_t changes[CHANGES_OF_POINT];
} deviation_t;

#define DEAD_TIME_SHIFT 0.5e-6                  /* [s] */
#define DEAD_TIME_LEAST (5.0 * DEAD_TIME_SHIFT) /* [s] dead time from which the shift is this one */
#define ROUNDING        1e-6                    /* [-] of a float */

static const deviation_t deviations[MAP_DEVIATIONS] = {
    [MAP_NOMINAL] = {"nominal", true, {{0}}},
    [MAP_FLUX_LOW] = {"psi_f -10 %", true, {{"params.motor_flux_linkage", 0.9, 0.0}}},
    [MAP_FLUX_HIGH] = {"psi_f +10 %", true, {{"params.motor_flux_linkage", 1.1, 0.0}}},
    [MAP_RESISTANCE_LOW] = {"R -50 %", true, {{"params.motor_resistance", 0.5, 0.0}}},
    [MAP_RESISTANCE_HIGH] = {"R +50 %", true, {{"params.motor_resistance", 1.5, 0.0}}},
    [MAP_INDUCTANCE_LOW] =
        {"L -20 %", true, {{"params.motor_inductance_d", 0.8, 0.0}, {"params.motor_inductance_q", 0.8, 0.0}}},
    [MAP_INDUCTANCE_HIGH] =
        {"L +20 %", true, {{"params.motor_inductance_d", 1.2, 0.0}, {"params.motor_inductance_q", 1.2, 0.0}}},
    /* The error voltage of the drive is proportional to dead_time + turn_on_delay - turn_off_delay;
     * dead_time itself also
     * sets the ePWM. In either direction the larger delay is used, because a delay of less than 0.5 us cannot
     * be reduced. Of a dead time below 2.5 us it is a fifth (deviate). */
    [MAP_DEAD_TIME_LOW] = {"dead time -0.5 us", false, {{"params.turn_off_delay", 1.0, DEAD_TIME_SHIFT}}},
    [MAP_DEAD_TIME_HIGH] = {"dead time +0.5 us", false, {{"params.turn_on_delay", 1.0, DEAD_TIME_SHIFT}}},
    [MAP_OFFSET] = {"offset 50 mA", false, {{"plant.current_offset_a", 0.0, 0.05}}},
    [MAP_NOISE] = {"noise 20 mA", false, {{"plant.current_noise", 0.0, 0.02}}},
    [MAP_HARMONICS] = {"EMF 5th 3 % and 7th 2 %",
                       false,
                       {{"plant.emf_5th", 0.0, 0.03}, {"plant.emf_7th", 0.0, 0.02}}},
    [MAP_LEG] = {"leg a +0.5 V", false, {{"plant.leg_a_drop", 0.0, 0.5}}},
    [MAP_GAIN] = {"sensor a +1 %", false, {{"plant.current_gain_error_a", 0.0, 0.01}}},
};

/* Lists end at CHANGES_MAX or with an empty row. */
static const change_t ideal_changes[CHANGES_MAX] = {
    /* The turn-off delay equals the delay that the dead band causes at turn-on, so that no error voltage
     * remains. */
    {"plant.turn_on_delay", 0.0, 0.0},  {"plant.turn_off_delay", 0.0, 2.5e-6},
    {"plant.igbt_voltage", 0.0, 0.0},   {"plant.igbt_resistance", 0.0, 0.0},
    {"plant.diode_voltage", 0.0, 0.0},  {"plant.diode_resistance", 0.0, 0.0},
    {"plant.current_zone", 0.0, 0.0},   {"plant.current_noise", 0.0, 0.0},
    {"params.turn_on_delay", 0.0, 0.0}, {"params.turn_off_delay", 0.0, 2.5e-6},
    {"params.device_drop", 0.0, 0.0},   {"rig.sensors", 0.0, 1.0},
};
static const change_t real_changes[CHANGES_MAX] = {
    {"plant.current_offset_a", 0.0, 0.03}, /* rows that change after the calibration */
    {"plant.current_gain_error_a", 0.0, 0.002},
};

/* The rows by which the drive learns its motor. Off is 0. On is the value of the scenario; if it is 0, the
 * default of the row; if this is 0 too, the value here. A row that a drive does not have is skipped. */
static const struct {
    const char *row;
    double on; /* [unit of the row] */
} learning[] = {
    {"flux_adaptation", 2.0},
    {"inductance_adaptation", 3.0},
    {"dead_time_adaptation", 6.0},
    {"inertia_adaptation", 1.0},
};

/* The encoder of the dynamometer, and the torque that it commands. */
static const setting_t bench[] = {
    {"params.position_source", 0.0}, {"params.encoder_lines", 2500.0}, {"params.encoder_offset", 0.0},
    {"plant.encoder_lines", 2500.0}, {"plant.encoder_offset", 0.0},    {"plant.load_torque", 0.0},
    {"plant.load_kind", 0.0},
};

static double pole_pairs(const map_setup_t *setup)
{
    const table_row_t *row = rig_row_by_name("plant.pole_pairs");
    return setup->scenario != NULL ? scenario_initial(setup->scenario, row) : rig_initial(row);
}

static bool change(rig_t *rig, const change_t *changes, size_t count)
{
    for (size_t n = 0; n < count && changes[n].row != NULL; n++) {
        const change_t *c = &changes[n];
        if (!rig_put(rig, c->row, c->factor * rig_value(rig, c->row) + c->shift)) {
            return false;
        }
    }
    return true;
}

/* Share of the shift of the dead time that is used with this dead time [s]. */
static double dead_time_share(double dead_time)
{
    return dead_time < (1.0 - ROUNDING) * DEAD_TIME_LEAST ? dead_time / DEAD_TIME_LEAST : 1.0;
}

static bool deviate(rig_t *rig, map_deviation_t which)
{
    deviation_t deviation = deviations[which];
    if (which == MAP_DEAD_TIME_LOW || which == MAP_DEAD_TIME_HIGH) {
        deviation.changes[0].shift *= dead_time_share(rig_value(rig, "params.dead_time"));
    }
    return change(rig, deviation.changes, CHANGES_OF_POINT);
}

static double choice(const char *row, const char *name)
{
    return table_choice(rig_row_by_name(row), name);
}

static bool adapt(rig_t *rig, map_adaptation_t adaptation)
{
    for (size_t n = 0; n < sizeof learning / sizeof learning[0]; n++) {
        const table_row_t *row = rig_row_by_name(learning[n].row);
        if (row == NULL) {
            continue;
        }
        const double set = rig_value(rig, learning[n].row);
        const double initial = set != 0.0 ? set : rig_initial(row);
        const double on = initial != 0.0 ? initial : learning[n].on;
        if (!rig_set(rig, row->id, adaptation == MAP_ADAPTATION_ON ? on : 0.0)) {
            return false;
        }
    }
    return true;
}

/* Changes that are applied before the drive measures its offsets, because those of a scenario are present
 * from the beginning.
 */
static bool stand_on(rig_t *rig, const scenario_t *scenario)
{
    const scenario_event_t *initial = &scenario->events[0];
    for (uint32_t n = 0; n < initial->count; n++) {
        const scenario_setting_t *setting = &initial->settings[n];
        const bool is_request = table_by_id(scenario_table("requests"), setting->row->id) != NULL;
        if (!is_request && !rig_set(rig, setting->row->id, setting->value)) {
            return false;
        }
    }
    return true;
}

/* The drive is ready, the bridge off. */
static bool begin(rig_t *rig, const map_setup_t *setup, const map_point_t *point)
{
    const bool conditions =
        setup->scenario != NULL || (paper_drive_put(rig, paper_drive, paper_drive_count) &&
                                    change(rig, setup->ideal ? ideal_changes : real_changes, CHANGES_MAX));
    if (!conditions || !deviate(rig, point->deviation) || !adapt(rig, point->adaptation) || !rig_apply(rig)) {
        return false;
    }
    const double torque_per_ampere =
        1.5 * rig_value(rig, "plant.pole_pairs") * rig_value(rig, "plant.flux_linkage");
    const double friction = rig_value(rig, "plant.friction_coulomb") +
                            rig_value(rig, "plant.friction_viscous") * fabs(point->rpm) * RPM;
    const dynamometer_t to = {
        .speed = map_window(setup, point->rpm).rpm * RPM,
        .load = point->load,
        .current = dynamometer_current(point->load, friction, torque_per_ampere,
                                       rig_value(rig, "params.current_limit"), point->rpm),
        .estimate = true,
    };
    return dynamometer_begin(rig, &to);
}

/* ---- the measurements of a point ---- */

enum { THETA_HAT_ERR, OMEGA_M, I_D, I_Q, INDUCTANCE, CONFIDENCE, TAPPED };
static const char *const tapped[TAPPED] = {
    [THETA_HAT_ERR] = "theta_hat_err",
    [OMEGA_M] = "true_omega_m",
    [I_D] = "i_d",
    [I_Q] = "i_q",
    [INDUCTANCE] = "inductance_hat",
    [CONFIDENCE] = "inductance_confidence",
};

typedef struct {
    double mean, squares; /* of the angle's error [mrad], Welford's recurrence [mrad^2] */
    double peak;          /* [mrad] */
    double sum[TAPPED];   /* [unit of the row] */
    uint32_t count;
} window_t;

static void take(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    window_t *w = context;
    float value[TAPPED];
    (void)period;
    memcpy(value, slots, count * sizeof value[0]);

    const double error = (double)value[THETA_HAT_ERR] / MRAD;
    const double step = error - w->mean;
    w->count++;
    w->mean += step / w->count;
    w->squares += step * (error - w->mean);
    w->peak = fmax(w->peak, fabs(error));
    for (uint32_t n = 0; n < TAPPED; n++) {
        w->sum[n] += (double)value[n];
    }
}

/* The theoretical mean error; the comment at the head of map.h has the formula. */
static double theory_mrad(rig_t *rig, const map_point_t *point)
{
    if (!point->locked || point->deviation >= MAP_DEAD_TIME_LOW) {
        return (double)NAN;
    }
    const double omega = point->true_rpm * RPM * rig_value(rig, "plant.pole_pairs");
    const double l_q = rig_value(rig, "plant.inductance_q");
    const double d_r = rig_value(rig, "params.motor_resistance") - rig_value(rig, "plant.resistance");
    const double d_l = point->inductance - l_q;
    const double flux =
        rig_value(rig, "plant.flux_linkage") + (rig_value(rig, "plant.inductance_d") - l_q) * point->i_d;
    const double sine = (d_r * point->i_d / omega - d_l * point->i_q) / flux;
    return asin(fmax(-1.0, fmin(sine, 1.0))) / MRAD;
}

static bool locked(rig_t *rig, const map_point_t *point, double rpm)
{
    const int32_t on = table_choice(rig_row_by_name("state"), "operation_enabled");
    const int32_t run = table_choice(rig_row_by_name("manoeuvre"), "run");
    return point->fault == 0 && (int32_t)rig_value(rig, "state") == on &&
           (int32_t)rig_value(rig, "manoeuvre") == run && fabs(point->mean_mrad) < LOCK_MRAD &&
           point->sd_mrad < LOCK_MRAD &&
           fabs(point->true_rpm - rpm) <= fmax(LOCK_SPEED * fabs(rpm), LOCK_RPM);
}

static double settling(const map_setup_t *setup, const map_point_t *point)
{
    if (point->adaptation == MAP_ADAPTATION_OFF) {
        return setup->settle;
    }
    const double slow = LEARN_HERTZ * 60.0 / (fabs(point->rpm) * pole_pairs(setup));
    return setup->learn * fmax(1.0, fmin(LEARN_LONGER, slow));
}

static bool measure_on(rig_t *rig, const map_setup_t *setup, map_point_t *point)
{
    window_t w = {0};
    uint32_t ids[TAPPED];
    for (uint32_t n = 0; n < TAPPED; n++) {
        ids[n] = rig_row_by_name(tapped[n])->id;
    }
    const map_window_t window = map_window(setup, point->rpm);
    const bool stands = (setup->scenario == NULL || stand_on(rig, setup->scenario)) &&
                        paper_drive_put(rig, bench, sizeof bench / sizeof bench[0]) && rig_apply(rig) &&
                        (!setup->averaged || rig_put(rig, "fidelity", choice("fidelity", "averaged")));
    if (!stands || !dynamometer_wait(rig) || !begin(rig, setup, point)) {
        return false;
    }
    rig_run(rig, rig_periods(settling(setup, point)));
    if (!rig_tap(rig, ids, TAPPED, 1u, take, &w)) {
        return false;
    }
    rig_run(rig, window.periods);

    point->mean_mrad = w.mean;
    point->sd_mrad = sqrt(w.squares / w.count);
    point->peak_mrad = w.peak;
    point->true_rpm = w.sum[OMEGA_M] / w.count / RPM;
    point->i_d = w.sum[I_D] / w.count;
    point->i_q = w.sum[I_Q] / w.count;
    point->inductance = w.sum[INDUCTANCE] / w.count;
    point->confidence = w.sum[CONFIDENCE] / w.count;
    point->fault = (int32_t)rig_value(rig, "fault_reason");
    point->locked = locked(rig, point, window.rpm);
    point->theory_mrad = theory_mrad(rig, point);
    return true;
}

static bool measure(const map_setup_t *setup, map_point_t *point, char why[POOL_WHY])
{
    rig_t *rig = rig_create(setup->seed);
    if (rig == NULL) {
        snprintf(why, POOL_WHY, "no memory");
        return false;
    }
    const bool measured = measure_on(rig, setup, point);
    if (!measured) {
        snprintf(why, POOL_WHY, "%s at %g r/min, %g N m, adaptation %s: %s",
                 map_deviation_name(point->deviation), point->rpm, point->load,
                 map_adaptation_name(point->adaptation), rig_error(rig));
    }
    rig_free(rig);
    return measured;
}

/* ---- all points ---- */

map_setup_t map_setup_default(void)
{
    return (map_setup_t){
        .speeds = {100.0, 300.0, 500.0, 1000.0, 1490.0},
        .speed_count = 5,
        .loads = {0.0, 5.0},
        .load_count = 2,
        .columns = {true, true},
        .seed = 1,
        .settle = 3.0,
        .learn = 3.0,
        .window = 3.0,
        .turns = 40.0,
    };
}

const char *map_deviation_name(map_deviation_t deviation)
{
    assert(deviation < MAP_DEVIATIONS);
    if (dead_time_share(rig_initial_named("params.dead_time")) < 1.0) {
        return deviation == MAP_DEAD_TIME_LOW    ? "dead time -20 %"
               : deviation == MAP_DEAD_TIME_HIGH ? "dead time +20 %"
                                                 : deviations[deviation].name;
    }
    return deviations[deviation].name;
}

const char *map_adaptation_name(map_adaptation_t adaptation)
{
    return adaptation == MAP_ADAPTATION_ON ? "on" : "off";
}

/* Points of one deviation, load and column; from points[count] on, unless it is NULL. */
static size_t lay_out_speeds(const map_setup_t *setup, const map_point_t *like, map_point_t *points,
                             size_t count)
{
    for (size_t s = 0; s < 2u * setup->speed_count && points != NULL; s++) {
        points[count + s] = *like;
        points[count + s].rpm = s < setup->speed_count ? -setup->speeds[setup->speed_count - 1u - s]
                                                       : setup->speeds[s - setup->speed_count];
    }
    return count + 2u * setup->speed_count;
}

static size_t lay_out(const map_setup_t *setup, map_point_t *points)
{
    size_t count = 0;
    for (map_deviation_t d = MAP_NOMINAL; d < MAP_DEVIATIONS; d++) {
        if (setup->left_out[d] || (setup->ideal && !deviations[d].machine)) {
            continue;
        }
        for (size_t l = 0; l < setup->load_count; l++) {
            for (map_adaptation_t a = MAP_ADAPTATION_OFF; a < MAP_ADAPTATIONS; a++) {
                const map_point_t like = {.load = setup->loads[l], .deviation = d, .adaptation = a};
                count = setup->columns[a] ? lay_out_speeds(setup, &like, points, count) : count;
            }
        }
    }
    return count;
}

size_t map_count(const map_setup_t *setup)
{
    return lay_out(setup, NULL);
}

map_window_t map_window(const map_setup_t *setup, double rpm)
{
    const double per_second = fabs(rpm) / 60.0 * pole_pairs(setup); /* electrical turns */
    const double samples = 1.0 / (per_second * RIG_PERIOD_SECONDS); /* of a turn */
    const double whole = round(samples);
    const double evenly = whole + (samples > whole - NOT_WHOLE ? EVENLY : -EVENLY);
    const double turns = fmax(ceil(setup->window / (evenly * RIG_PERIOD_SECONDS)), setup->turns);
    return (map_window_t){.rpm = rpm * samples / evenly, .periods = (uint32_t)(turns * evenly + 0.5)};
}

typedef struct {
    const map_setup_t *setup;
    map_point_t *points;
} work_t;

static bool measure_point(void *context, size_t n, char why[POOL_WHY])
{
    const work_t *work = context;
    return measure(work->setup, &work->points[n], why);
}

static void tell_progress(void *context, size_t done)
{
    const map_setup_t *setup = ((work_t *)context)->setup;
    if (setup->progress != NULL) {
        setup->progress(setup->progress_context, (double)done / (double)map_count(setup));
    }
}

bool map_run(const map_setup_t *setup, map_point_t *points, unsigned threads, map_error_t *why)
{
    assert(setup->speed_count >= 1u && setup->speed_count <= MAP_SPEEDS_MAX);
    assert(setup->columns[MAP_ADAPTATION_OFF] || setup->columns[MAP_ADAPTATION_ON]);
    assert(setup->scenario == NULL || !setup->ideal);
    assert(setup->load_count >= 1u && setup->load_count <= MAP_LOADS_MAX);
    work_t work = {.setup = setup, .points = points};
    const pool_t pool = {
        .count = lay_out(setup, points), .piece = measure_point, .progress = tell_progress, .work = &work};
    return pool_run(&pool, threads, why->text);
}
