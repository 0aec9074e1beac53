/* One run on a rig of its own. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/paper_parts.h"

#define READY         1.0  /* [s] offsets are measured by then, or never */
#define HOLD          0.1  /* [s] on the dynamometer: current and estimator settle */
#define FOLLOW        0.01 /* [s] the encoder's speed follows the rotor's */
#define SLICE_PERIODS 10u  /* [periods] grid of the events */
#define PLATEAU_BEGIN 0.75 /* share of a speed change: the transient is over, the limit still holds */
#define PLATEAU_END   0.85
/* The loop has lost the rotor if the mean speed is off its reference, or the error comes near half a turn. */
#define LOST_SPEED 0.2    /* [-] */
#define LOST_ANGLE 3000.0 /* [mrad] */

#define MOTION (BIT(C_SPEED) | BIT(C_SPEED_HAT) | BIT(C_ERROR))

const shown_t paper_shown[PAPER_FIGURES] = {
    [FIG05] = {BIT(C_K_F), 1},
    [FIG10] = {MOTION | BIT(C_THETA) | BIT(C_THETA_HAT), 1},
    [FIG11] = {MOTION | BIT(C_THETA) | BIT(C_THETA_HAT) | BIT(C_THEORY), 1},
    [FIG12] = {BIT(C_SPEED) | BIT(C_ERROR) | BIT(C_I_Q) | BIT(C_I_D), 1},
    [FIG13] = {MOTION | BIT(C_THEORY), 1},
    [FIG14] = {MOTION, 4},
    [FIG15] = {MOTION, 4},
    [FIG17] = {MOTION | BIT(C_I_Q), 4},
};

size_t paper_columns(size_t figure)
{
    size_t count = 0;
    for (unsigned c = 0; c < COLUMNS; c++) {
        count += (paper_shown[figure].columns & BIT(c)) != 0u;
    }
    return count;
}

/* ---- what is measured ---- */

typedef struct {
    double squares, speed_mean, speed_squares, k_squares; /* Welford's recurrences */
    double plateau_count, plateau_sum, acceleration_sum;
    bool plateau_over;
} sums_t;

typedef struct {
    result_t *result;
    course_t course;
    sums_t sums[WINDOWS_MAX];
    double load;    /* [N m] */
    double ki;      /* of its loop [rad/s^2] */
    uint32_t count; /* [periods] so far */
} watch_t;

enum { T_SPEED, T_HAT, T_THETA, T_THETA_HAT, T_ERROR, T_I_Q, T_I_D, T_TORQUE, T_I_ERR, TAPPED };
static const char *const tapped[TAPPED] = {
    [T_SPEED] = "true_omega_m",  [T_HAT] = "omega_hat",       [T_THETA] = "true_theta_e",
    [T_THETA_HAT] = "theta_hat", [T_ERROR] = "theta_hat_err", [T_I_Q] = "i_q",
    [T_I_D] = "true_i_d",        [T_TORQUE] = "true_torque",  [T_I_ERR] = "i_err_alpha"};

static void recur(double count, double value, double *mean, double *squares)
{
    const double step = value - *mean;
    *mean += step / count;
    *squares += step * (value - *mean);
}

typedef struct {
    double error, speed, speed_err, i_q, i_d, k_f, acceleration;
} moment_t;

static void take_window(const window_t *window, const moment_t *now, numbers_t *n, sums_t *s)
{
    n->count += 1.0;
    recur(n->count, now->error, &n->mean, &s->squares);
    recur(n->count, now->speed_err, &s->speed_mean, &s->speed_squares);
    recur(n->count, now->k_f, &n->k_mean, &s->k_squares);
    n->speed += (now->speed - n->speed) / n->count;
    n->i_q += (now->i_q - n->i_q) / n->count;
    n->i_d += (now->i_d - n->i_d) / n->count;
    n->peak = fmax(n->peak, fabs(now->error));
    n->speed_peak = fmax(n->speed_peak, fabs(now->speed_err));
    n->k_max = fmax(n->k_max, now->k_f);
    if (window->from != window->to) {
        const double share = (now->speed - window->from) / (window->to - window->from);
        s->plateau_over = s->plateau_over || share >= PLATEAU_END;
        if (share > PLATEAU_BEGIN && !s->plateau_over) {
            s->plateau_count += 1.0;
            s->plateau_sum += now->error;
            s->acceleration_sum += now->acceleration;
        }
    }
}

/* What theory says of the error at this moment [mrad]. */
static double theory(const watch_t *w, const moment_t *now)
{
    const run_t *run = &w->result->run;
    if (run->figure == FIG11) {
        return paper_lag_sampled(run->gain, 1.0, paper_machine.pole_pairs * now->speed * RPM) / MRAD;
    }
    return paper_tracking_error(w->ki, now->acceleration) / MRAD;
}

static void record(const watch_t *w, const moment_t *now, const float value[TAPPED])
{
    result_t *result = w->result;
    const unsigned columns = paper_shown[result->run.figure].columns;
    const float all[COLUMNS] = {
        [C_SPEED] = (float)now->speed,
        [C_SPEED_HAT] = (float)((double)value[T_HAT] / paper_machine.pole_pairs / RPM),
        [C_THETA] = value[T_THETA],
        [C_THETA_HAT] = value[T_THETA_HAT],
        [C_ERROR] = (float)now->error,
        [C_THEORY] = (columns & BIT(C_THEORY)) != 0u ? (float)theory(w, now) : 0.0f,
        [C_I_Q] = value[T_I_Q],
        [C_I_D] = value[T_I_D],
        [C_K_F] = (float)now->k_f,
    };
    float *to = &result->trace[paper_columns(result->run.figure) * result->rows++];
    for (unsigned c = 0; c < COLUMNS; c++) {
        if ((columns & BIT(c)) != 0u) {
            *to++ = all[c];
        }
    }
}

static void watch(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    watch_t *w = context;
    result_t *result = w->result;
    float value[TAPPED];
    (void)period;
    memcpy(value, slots, count * sizeof value[0]);

    const double time = w->count * RIG_PERIOD_SECONDS;
    const double speed = (double)value[T_SPEED];
    const double i_err = (double)value[T_I_ERR];
    const double torque = (double)value[T_TORQUE] - w->load - paper_machine.friction;
    const moment_t now = {
        .error = (double)value[T_ERROR] / MRAD,
        .speed = speed / RPM,
        .speed_err = ((double)value[T_HAT] / paper_machine.pole_pairs - speed) / RPM,
        .i_q = (double)value[T_I_Q],
        .i_d = (double)value[T_I_D],
        .k_f = result->run.switching == SIGN ? paper_sign_gain(i_err) : paper_sigmoid_gain(i_err),
        .acceleration = paper_machine.pole_pairs * torque / paper_machine.inertia,
    };
    for (size_t n = 0; n < w->course.window_count; n++) {
        const window_t *window = &w->course.windows[n];
        if (time >= window->begin && time < window->end) {
            take_window(window, &now, &result->numbers[n], &w->sums[n]);
        }
    }
    if (result->rows < result->rows_max && w->count % paper_shown[result->run.figure].every == 0u) {
        record(w, &now, value);
    }
    w->count++;
}

/* ---- the rig ---- */

#define PUT(rig, settings) paper_drive_put(rig, settings, sizeof settings / sizeof settings[0])

/* Inverter and sensors without error: what the dead band delays one edge by, the turn-off delays the other.
 */
static const setting_t ideal_settings[] = {
    {"plant.turn_on_delay", 0.0},  {"plant.turn_off_delay", 2.5e-6},
    {"plant.igbt_voltage", 0.0},   {"plant.igbt_resistance", 0.0},
    {"plant.diode_voltage", 0.0},  {"plant.diode_resistance", 0.0},
    {"plant.current_zone", 0.0},   {"plant.current_noise", 0.0},
    {"params.turn_on_delay", 0.0}, {"params.turn_off_delay", 2.5e-6},
    {"params.device_drop", 0.0},   {"params.device_resistance", 0.0},
    {"params.current_zone", 1e-3}, {"rig.sensors", 1.0},
};
/* What calibration left of the sensors' errors. */
static const setting_t real_settings[] = {
    {"plant.current_offset_a", 0.03},
    {"plant.current_gain_error_a", 0.002},
};
/* Of fig16 besides: a machine whose EMF is no pure sine. */
static const setting_t harmonic_settings[] = {
    {"plant.emf_5th", 0.01},
    {"plant.emf_7th", 0.005},
};
/* The rig, and the criteria of a lost estimate, which the paper does not have. */
const setting_t paper_common[] = {
    {"params.current_bandwidth", 1000.0},
    {"params.overspeed_trip", 200.0}, /* [rad/s]; the smallest k_s covers the EMF up to here */
    {"params.observer_slope", 1.0},
    {"params.pll_damping", 1.0},
    {"params.flux_adaptation", 0.0},
    {"params.dead_time_adaptation", 0.0},
    {"params.estimate_amplitude_min", 0.0},
    {"params.estimate_amplitude_max", 1.0},
    {"params.estimate_detector_max", 0.0},
    {"params.estimate_current_max", 0.0},
    {"params.estimate_speed_min", 0.0},
    {"params.lock_judged", 0.0},
    {"rig.fidelity", 1.0},
};
const size_t paper_common_count = sizeof paper_common / sizeof paper_common[0];

static bool configure(rig_t *rig, const result_t *result)
{
    const run_t *run = &result->run;
    /* A leg loses dead_time + turn_on_delay - turn_off_delay of each edge. */
    const double dead_time = 1e-6 * run->dead_time - rig_value(rig, "plant.turn_on_delay") +
                             rig_value(rig, "plant.turn_off_delay");
    const setting_t machine[] = {
        {"plant.inertia", paper_machine.inertia},
        {"plant.friction_coulomb", paper_machine.friction},
        {"params.current_limit", paper_machine.current_limit},
    };
    /* The drive believes that nothing is lost: the transistors switch off as late as the dead band lets the
     * others switch on. So neither its modulator nor its observer knows. */
    const setting_t unaware[] = {
        {"params.dead_time", dead_time},
        {"params.turn_on_delay", 0.0},
        {"params.turn_off_delay", dead_time},
        {"params.device_drop", 0.0},
    };
    const setting_t own[] = {
        {"params.observer_switching", run->switching},
        {"params.observer_gain", run->gain},
        {"params.observer_emf_cutoff", run->omega_s},
        {"params.lag_compensation", run->profile == COMPENSATE ? LAG_NONE : run->lag},
        {"params.pll_bandwidth", run->bandwidth},
        {"params.feedforward_cutoff", run->omega_c},
        {"params.torque_feedforward", run->torque ? 1.0 : 0.0},
    };
    return PUT(rig, machine) && paper_drive_put(rig, paper_drive, paper_drive_count) &&
           PUT(rig, paper_common) && (result->real || PUT(rig, ideal_settings)) &&
           (run->dead_time == 0.0 || PUT(rig, unaware)) && PUT(rig, own) && rig_apply(rig);
}

/* A dynamometer turns the rotor until the estimator has settled and the drive gives the torque that is asked
 * for; then estimate and speed control take over: a load that fell on the rotor all at once would stop it at
 * 100 r/min. */
static bool begin(rig_t *rig, const result_t *result)
{
    const run_t *run = &result->run;
    const double omega_m = paper_course(run).rpm * RPM;
    const table_row_t *mode = rig_row_by_name("mode");
    if ((result->real && !PUT(rig, real_settings)) ||
        (result->real && run->figure == FIG16 && !PUT(rig, harmonic_settings)) ||
        !rig_put(rig, "plant.shaft_locked_speed", omega_m) || !rig_put(rig, "plant.shaft_locked", 1.0) ||
        !rig_put(rig, "plant.load_torque", run->load)) {
        return false;
    }
    rig_set_motion(rig, 0.0, omega_m);
    rig_run(rig, rig_periods(FOLLOW));
    if (!rig_put(rig, "mode", table_choice(mode, "current")) ||
        !rig_put(rig, "i_q_request", paper_holding_current(run->load)) || !rig_put(rig, "enable", 1.0)) {
        return false;
    }
    rig_run(rig, rig_periods(HOLD));
    if ((!run->encoder && !paper_drive_without_encoder(rig)) || !rig_put(rig, "speed_request", omega_m) ||
        !rig_put(rig, "mode", table_choice(mode, "speed")) || !rig_put(rig, "plant.shaft_locked", 0.0)) {
        return false;
    }
    /* With real sensors the drive trims the offset away while turning; a rotor that gets lost is seen being
     * lost. */
    const double settle = run->dead_time > 0.0 ? 0.0 : result->real ? 3.0 : 0.5;
    rig_run(rig, rig_periods(settle));
    return true;
}

static bool act(rig_t *rig, const run_t *run, const event_t *event, watch_t *w)
{
    switch (event->kind) {
    case SPEED:
        return rig_put(rig, "speed_request", event->value * RPM);
    case COMPENSATION:
        return rig_put(rig, "params.lag_compensation", event->value > 0.0 ? run->lag : LAG_NONE) &&
               rig_apply(rig);
    case LOAD_TORQUE:
        w->load = event->value;
        return rig_put(rig, "plant.load_torque", event->value);
    }
    return false;
}

/* Sums into numbers; and whether the rotor was where it should be. */
static void conclude(watch_t *w)
{
    result_t *result = w->result;
    result->lost = result->fault != 0;
    for (size_t n = 0; n < w->course.window_count; n++) {
        const window_t *window = &w->course.windows[n];
        const sums_t *s = &w->sums[n];
        numbers_t *to = &result->numbers[n];
        to->sd = sqrt(s->squares / to->count);
        to->speed_sd = sqrt(s->speed_squares / to->count);
        to->k_sd = sqrt(s->k_squares / to->count);
        to->plateau = s->plateau_count > 0.0 ? s->plateau_sum / s->plateau_count : (double)NAN;
        to->acceleration = s->plateau_count > 0.0 ? s->acceleration_sum / s->plateau_count : (double)NAN;
        const bool off = window->from == window->to && fabs(to->speed - window->to) > LOST_SPEED * window->to;
        if (off || (to->peak > LOST_ANGLE && !result->run.encoder)) {
            result->lost = true;
        }
    }
}

static bool measure_on(rig_t *rig, result_t *result)
{
    const run_t *run = &result->run;
    watch_t w = {.result = result, .course = paper_course(run), .load = run->load};
    const course_t *course = &w.course;
    uint32_t ids[TAPPED];
    double kp = 0.0;
    for (uint32_t n = 0; n < TAPPED; n++) {
        ids[n] = rig_row_by_name(tapped[n])->id;
    }
    const table_row_t *state = rig_row_by_name("state");
    if (!paper_loop(run->bandwidth, run->omega_c, &kp, &w.ki) || !configure(rig, result) ||
        !rig_stop_when(rig, state->id, RIG_EQUAL, table_choice(state, "ready"))) {
        return false;
    }
    rig_run(rig, rig_periods(READY));
    if (!rig_stop_when(rig, state->id, RIG_NEVER, 0.0) || !begin(rig, result) ||
        !rig_tap(rig, ids, TAPPED, 1u, watch, &w)) {
        return false;
    }
    const uint32_t slices = (uint32_t)ceil(course->length / (SLICE_PERIODS * RIG_PERIOD_SECONDS) - 1e-6);
    size_t next = 0;
    for (uint32_t slice = 0; slice < slices; slice++) {
        const double time = (slice + 0.5) * SLICE_PERIODS * RIG_PERIOD_SECONDS;
        while (next < course->event_count && course->events[next].time <= time) {
            if (!act(rig, run, &course->events[next++], &w)) {
                return false;
            }
        }
        rig_run(rig, SLICE_PERIODS);
    }
    result->fault = (int32_t)rig_value(rig, "fault_reason");
    conclude(&w);
    return true;
}

bool paper_measure(result_t *result, uint64_t seed, char why[POOL_WHY])
{
    const run_t *run = &result->run;
    const shown_t *shown = &paper_shown[run->figure];
    const bool traced = shown->columns != 0u && !run->sweep;
    if (traced) {
        result->rows_max = (size_t)(paper_course(run).length / (RIG_PERIOD_SECONDS * shown->every) + 0.5);
        result->trace = calloc(result->rows_max * paper_columns(run->figure), sizeof result->trace[0]);
    }
    rig_t *rig = rig_create(seed + run->reseed);
    if (rig == NULL || (traced && result->trace == NULL)) {
        rig_free(rig);
        snprintf(why, POOL_WHY, "no memory");
        return false;
    }
    const bool measured = measure_on(rig, result);
    if (!measured) {
        snprintf(why, POOL_WHY, "%s, %s: %s", paper_figures[run->figure].id, run->name, rig_error(rig));
    }
    rig_free(rig);
    return measured;
}
