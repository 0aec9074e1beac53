/* One run on a rig of its own. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/dynamometer.h"
#include "host_sim/lab/paper_parts.h"

#define SLICE_PERIODS 10u  /* [periods] grid of the events */
#define PLATEAU_BEGIN 0.75 /* share of a speed change: the transient is over, the limit still holds */
#define PLATEAU_END   0.85
/* The loop has lost the rotor if the mean speed is off its reference, or the error comes near half a turn. */
#define LOST_SPEED 0.2    /* [-] */
#define LOST_ANGLE 3000.0 /* [mrad] */

#define MOTION (BIT(C_SPEED) | BIT(C_SPEED_HAT) | BIT(C_ERROR))

const shown_t paper_shown[PAPER_FIGURES] = {
    [FIG15] = {MOTION, 4},
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
    double squares, speed_mean, speed_squares; /* Welford's recurrences */
    double plateau_count, plateau_sum, acceleration_sum;
    bool plateau_over;
} sums_t;

typedef struct {
    result_t *result;
    course_t course;
    sums_t sums[WINDOWS_MAX];
    double load;    /* [N m] */
    uint32_t count; /* [periods] so far */
} watch_t;

enum { T_SPEED, T_HAT, T_ERROR, T_TORQUE, TAPPED };
static const char *const tapped[TAPPED] = {[T_SPEED] = "true_omega_m",
                                           [T_HAT] = "omega_hat",
                                           [T_ERROR] = "theta_hat_err",
                                           [T_TORQUE] = "true_torque"};

static void recur(double count, double value, double *mean, double *squares)
{
    const double step = value - *mean;
    *mean += step / count;
    *squares += step * (value - *mean);
}

typedef struct {
    double error, speed, speed_err, acceleration;
} moment_t;

static void take_window(const window_t *window, const moment_t *now, numbers_t *n, sums_t *s)
{
    n->count += 1.0;
    recur(n->count, now->error, &n->mean, &s->squares);
    recur(n->count, now->speed_err, &s->speed_mean, &s->speed_squares);
    n->speed += (now->speed - n->speed) / n->count;
    n->peak = fmax(n->peak, fabs(now->error));
    n->speed_peak = fmax(n->speed_peak, fabs(now->speed_err));
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

static void record(const watch_t *w, const moment_t *now, const float value[TAPPED])
{
    result_t *result = w->result;
    const unsigned columns = paper_shown[result->run.figure].columns;
    const float all[COLUMNS] = {
        [C_SPEED] = (float)now->speed,
        [C_SPEED_HAT] = (float)((double)value[T_HAT] / paper_machine.pole_pairs / RPM),
        [C_ERROR] = (float)now->error,
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
    const double torque = (double)value[T_TORQUE] - w->load - paper_machine.friction;
    const moment_t now = {
        .error = (double)value[T_ERROR] / MRAD,
        .speed = speed / RPM,
        .speed_err = ((double)value[T_HAT] / paper_machine.pole_pairs - speed) / RPM,
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
        {"params.lag_compensation", run->lag},
        {"params.pll_bandwidth", run->bandwidth},
        {"params.feedforward_cutoff", run->omega_c},
        {"params.torque_feedforward", run->torque ? 1.0 : 0.0},
    };
    return PUT(rig, machine) && paper_drive_put(rig, paper_drive, paper_drive_count) &&
           paper_drive_put(rig, paper_common, paper_common_count) &&
           (result->real || paper_drive_put(rig, paper_ideal, paper_ideal_count)) &&
           (run->dead_time == 0.0 || PUT(rig, unaware)) && PUT(rig, own) && rig_apply(rig);
}

static bool begin(rig_t *rig, const result_t *result)
{
    const run_t *run = &result->run;
    const double speed = paper_course(run).rpm * RPM;
    const dynamometer_t to = {speed, run->load, paper_holding_current(run->load), true};
    if ((result->real && !PUT(rig, real_settings)) ||
        (result->real && run->figure == FIG16 && !PUT(rig, harmonic_settings)) ||
        !dynamometer_begin(rig, &to)) {
        return false;
    }
    /* With real sensors the drive trims the offset away while turning; a rotor that gets lost is seen being
     * lost. */
    const double settle = run->dead_time > 0.0 ? 0.0 : result->real ? 3.0 : 0.5;
    rig_run(rig, rig_periods(settle));
    return true;
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
        to->plateau = s->plateau_count > 0.0 ? s->plateau_sum / s->plateau_count : (double)NAN;
        to->acceleration = s->plateau_count > 0.0 ? s->acceleration_sum / s->plateau_count : (double)NAN;
        const bool off = window->from == window->to && fabs(to->speed - window->to) > LOST_SPEED * window->to;
        if (off || to->peak > LOST_ANGLE) {
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
    for (uint32_t n = 0; n < TAPPED; n++) {
        ids[n] = rig_row_by_name(tapped[n])->id;
    }
    if (!configure(rig, result) || !dynamometer_wait(rig) || !begin(rig, result) ||
        !rig_tap(rig, ids, TAPPED, 1u, watch, &w)) {
        return false;
    }
    const uint32_t slices = (uint32_t)ceil(course->length / (SLICE_PERIODS * RIG_PERIOD_SECONDS) - 1e-6);
    size_t next = 0;
    for (uint32_t slice = 0; slice < slices; slice++) {
        const double time = (slice + 0.5) * SLICE_PERIODS * RIG_PERIOD_SECONDS;
        while (next < course->event_count && course->events[next].time <= time) {
            if (!rig_put(rig, "speed_request", course->events[next++].speed * RPM)) {
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
