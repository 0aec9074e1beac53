#include "host_sim/lab/commission.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/commission_parts.h"
#include "host_sim/lab/course.h"

#define WAIT_READY   2.0  /* [s] largest time until the drive is ready */
#define LINK_ERROR   0.03 /* largest difference from the user's meter: resistors of 1 %, reference, meter */
#define GAIN_ERROR   0.01 /* of the current sensors and of the divider of the link, together */
#define DEVICE_ERROR 0.2  /* of the resistance of the devices by their data sheet */
#define FRICTION_ERROR                                                                                       \
    0.005 /* of the friction at the rated speed over the rated torque: offsets, remaining loss of the dead   \
             time */
#define LINEAR         1e5    /* [A] least saturation current of a q axis without a saturation */
#define LOOK           2.5e-3 /* [s] */
#define OVER_TOP       1.4    /* overspeed_trip over the largest speed of tune */
#define RANGE_LEAST    150.0  /* [rad/s] electrical: least rated speed for the turning steps */
#define HANDOVER_STEP  0.5    /* share of the rules' hand-over speed by which it is increased with each try */
#define HANDOVER_TIMES 2.0    /* of the rules' hand-over speed, at most */
#define PARAMS_MOST    512u

static const struct {
    const char *name;
    double seconds;
    const char *text;
} steps[] = {
#define ROW_OF(name, seconds, text) {#name, seconds, text},
    COMMISSION_LIST(ROW_OF)
#undef ROW_OF
};

const char *commission_step_name(commission_do_t step)
{
    return steps[step].name;
}

const char *commission_step_text(commission_do_t step)
{
    return steps[step].text;
}

double commission_step_seconds(commission_do_t step)
{
    return steps[step].seconds;
}

bool commission_choose(commission_options_t *options, const char *text, char *why, size_t size)
{
    bool any = false;
    options->chosen = true;
    for (uint32_t n = 0; n < COMMISSION_STEP_COUNT; n++) {
        options->skip[n] = true;
    }
    for (const char *at = text; *at != '\0'; at += strspn(at, ",")) {
        const size_t length = strcspn(at, ",");
        uint32_t n = 0;
        while (n < COMMISSION_STEP_COUNT &&
               (strncmp(at, steps[n].name, length) != 0 || steps[n].name[length] != '\0')) {
            n++;
        }
        if (n == COMMISSION_STEP_COUNT) {
            int used = snprintf(why, size, "%.*s: accepted", (int)length, at);
            for (n = 0; n < COMMISSION_STEP_COUNT && used > 0 && (size_t)used < size; n++) {
                used += snprintf(why + used, size - (size_t)used, "%s %s", n > 0u ? "," : "", steps[n].name);
            }
            return false;
        }
        options->skip[n] = false;
        any = true;
        at += length;
    }
    if (!any) {
        snprintf(why, size, "no name is given; accepted: names of steps, separated by commas");
    }
    return any;
}

/* A signal as a result; 0 is not measured. */
static commission_value_t measured(commission_work_t *work, const char *row, double relative)
{
    const double value = commission_value(work, row);
    return value > 0.0 ? (commission_value_t){value, relative * value}
                       : (commission_value_t){(double)NAN, (double)NAN};
}

/* The values that the drive has measured after a step. The uncertainties: of R those of the gains and of the
 * devices, and half the spread of the directions; of L the accuracy that the tests have shown; of psi_f and J
 * the scatter of the measurement, and the effects of link and dead time. */
static void take(commission_work_t *work, commission_do_t step)
{
    commission_result_t *result = work->result;
    if (step == COMMISSION_DO_resistance) {
        const commission_value_t all = measured(work, "commission_resistance", 0.0);
        const double device = commission_value(work, "device_resistance");
        const double spread = commission_value(work, "commission_resistance_spread");
        result->resistance = (commission_value_t){
            all.value - device, (GAIN_ERROR + 0.5 * spread) * all.value + DEVICE_ERROR * device};
        result->dead_voltage = measured(work, "commission_dead_voltage", 0.02);
        result->current_zone = measured(work, "commission_current_zone", 0.2);
    } else if (step == COMMISSION_DO_inductance) {
        result->inductance_d = measured(work, "commission_inductance_d", 0.01);
        result->inductance_q = measured(work, "commission_inductance_q", 0.03);
        result->saturation_current = measured(work, "commission_saturation_current", 0.1);
        if (result->saturation_current.value >= LINEAR) {
            result->saturation_current = (commission_value_t){0.0, 0.0};
        }
    } else if (step == COMMISSION_DO_angle) {
        result->angle_d = commission_value(work, "commission_angle");
    } else if (step == COMMISSION_DO_current_loop) {
        result->loop_gain = commission_value(work, "commission_loop_gain");
    } else if (step == COMMISSION_DO_swing) {
        result->flux_first = commission_value(work, "commission_flux_first");
        result->inertia_first = commission_value(work, "commission_inertia_first");
    } else if (step == COMMISSION_DO_flux) {
        result->flux_linkage = measured(work, "commission_flux_linkage", 0.01);
    } else if (step == COMMISSION_DO_inertia) {
        const double scatter = commission_value(work, "commission_inertia_scatter");
        result->inertia = measured(work, "commission_inertia", 0.015 + 2.0 * scatter);
        const double rated =
            1.5 * work->plate->pole_pairs * result->flux_linkage.value * work->plate->current;
        result->friction_coulomb.value = commission_value(work, "commission_friction_coulomb");
        result->friction_coulomb.error = FRICTION_ERROR * rated;
        result->friction_viscous.value = commission_value(work, "commission_friction_viscous");
        result->friction_viscous.error = FRICTION_ERROR * rated / work->plate->speed;
    }
}

static void clear(commission_result_t *result)
{
    const commission_value_t none = {(double)NAN, (double)NAN};
    memset(result, 0, sizeof *result);
    result->resistance = result->inductance_d = result->inductance_q = none;
    result->flux_linkage = result->inertia = result->saturation_current = none;
    result->friction_coulomb = result->friction_viscous = result->dead_voltage = result->current_zone = none;
    result->loop_gain = result->least_speed = result->turns = result->angle_d = (double)NAN;
}

rig_t *commission_rig_of(const scenario_t *scenario, uint64_t seed, scenario_error_t *error)
{
    rig_t *rig = rig_create(seed);
    course_t course;
    if (rig == NULL || !course_init(&course, scenario, rig)) {
        snprintf(error->message, sizeof error->message, "not enough memory");
        rig_free(rig);
        return NULL;
    }
    const bool started = course_start(&course, error);
    course_free(&course);
    if (!started) {
        rig_free(rig);
        return NULL;
    }
    return rig;
}

commission_plate_t commission_plate_by(const commission_drive_t *drive)
{
    double pairs = 0.0;
    double continuous = 0.0;
    double limit = 0.0;
    double trip = 0.0;
    (void)drive->get(drive->context, rig_row_by_name("motor_pole_pairs"), &pairs);
    (void)drive->get(drive->context, rig_row_by_name("motor_current_continuous"), &continuous);
    (void)drive->get(drive->context, rig_row_by_name("current_limit"), &limit);
    (void)drive->get(drive->context, rig_row_by_name("overspeed_trip"), &trip);
    return (commission_plate_t){
        .pole_pairs = pairs,
        .current = continuous > 0.0 ? continuous : 0.5 * limit,
        .speed = trip / OVER_TOP,
    };
}

commission_plate_t commission_plate_of(rig_t *rig)
{
    commission_rig_room_t room;
    const commission_drive_t drive = commission_rig_drive(&room, rig);
    const commission_plate_t plate = commission_plate_by(&drive);
    commission_rig_leave(&room);
    return plate;
}

static bool is_one_of(const char *name, const char *const *list, size_t count)
{
    bool found = false;
    for (size_t n = 0; n < count; n++) {
        found = found || strcmp(name, list[n]) == 0;
    }
    return found;
}

/* True if the estimate was lost or too noisy, so that a hand-over at a higher speed may help. */
static bool worth_another_try(const commission_work_t *work)
{
    static const char *const lost[] = {"lock_lost",       "start_unlocked",  "start_stalled",
                                       "estimate_astray", "sensorless_lost", "inertia_not_seen"};
    return is_one_of(work->result->reason, lost, sizeof lost / sizeof lost[0]) &&
           work->raised + HANDOVER_STEP <= HANDOVER_TIMES;
}

/* A turning step failed, and the rated speed is so small that the back-EMF hardly exceeds the loss of the
 * dead time: the range is the reason. */
static void name_small_range(commission_work_t *work)
{
    static const char *const small[] = {"lock_lost",       "start_unlocked",  "start_stalled",
                                        "estimate_astray", "sensorless_lost", "inertia_not_seen",
                                        "emf_too_small",   "overspeed"};
    const double omega_e = work->plate->pole_pairs * work->plate->speed;
    if (work->result->step < COMMISSION_DO_flux || omega_e >= RANGE_LEAST ||
        !is_one_of(work->result->reason, small, sizeof small / sizeof small[0])) {
        return;
    }
    char text[160];
    snprintf(text, sizeof text,
             "the rated speed is %.0f rad/s electrical, below %.0f rad/s, and the step ended with %s",
             omega_e, RANGE_LEAST, work->result->reason);
    commission_end(work, "speed_range_small", text,
                   "permit more speed, or enter psi_f and J from the data sheet");
}

/* Clears the results of a try. */
static void reset_fault(commission_work_t *work)
{
    work->result->reason[0] = '\0';
    work->result->what[0] = '\0';
    (void)commission_put(work, "fault_reset", 1.0);
    commission_wait(work, LOOK);
    (void)commission_put(work, "fault_reset", 0.0);
    commission_wait(work, LOOK);
}

static void try_again(commission_work_t *work)
{
    work->raised += HANDOVER_STEP;
    reset_fault(work);
}

/* Tries that fail heat motor and module: if a later one ends by the heat, the reason is that of the first. */
static void name_first(commission_result_t *result, const commission_result_t *first)
{
    static const char *const heat[] = {"motor_overload", "module_overload"};
    if (first->reason[0] != '\0' && is_one_of(result->reason, heat, sizeof heat / sizeof heat[0])) {
        memcpy(result->reason, first->reason, sizeof result->reason);
        memcpy(result->what, first->what, sizeof result->what);
    }
}

/* A signal of the drive that only this step gives a value; NULL: no signal keeps the value. */
static const char *proof_of(commission_do_t step)
{
    static const char *const rows[COMMISSION_STEP_COUNT] = {
        [COMMISSION_DO_wiring] = "commission_inductance_pulse",
        [COMMISSION_DO_resistance] = "commission_current_zone",
        [COMMISSION_DO_inductance] = "commission_inductance_q",
        [COMMISSION_DO_current_loop] = "commission_loop_gain",
        [COMMISSION_DO_swing] = "commission_inertia_first",
        [COMMISSION_DO_flux] = "commission_flux_linkage",
        [COMMISSION_DO_inertia] = "commission_inertia"};
    return rows[step];
}

/* True if the drive has a result of this step from an earlier commissioning. */
static bool is_known(commission_work_t *work, commission_do_t step)
{
    const char *row = work->options->resume ? proof_of(step) : NULL;
    return row != NULL && commission_value(work, row) > 0.0;
}

static bool one_try(commission_work_t *work, commission_do_t step)
{
    if (step == COMMISSION_DO_least_speed) {
        return commission_least_speed(work);
    }
    if (step == COMMISSION_DO_turn && work->drive->turned != NULL) {
        (void)work->drive->turned(work->drive->context); /* the time of the run begins here */
    }
    return commission_run_step(work, step) && (step != COMMISSION_DO_turn || commission_ask_turn(work));
}

/* A step with all its tries; a result has no reason. false: the plate is not accepted. */
static bool try_step(commission_work_t *work, commission_do_t step)
{
    const commission_options_t *options = work->options;
    commission_result_t *result = work->result;
    const bool uses_result = step == COMMISSION_DO_least_speed;
    commission_result_t first = *result;
    if (is_known(work, step)) {
        take(work, step);
        return true;
    }
    bool good = uses_result ? commission_stage_result(work) : commission_stage(work);
    while (good && result->reason[0] == '\0') {
        if (options->progress != NULL) {
            options->progress(options->context, step, false, result);
        }
        if (one_try(work, step)) {
            take(work, step);
            return true;
        }
        if (step < COMMISSION_DO_flux || uses_result || !worth_another_try(work)) {
            break;
        }
        first = first.reason[0] == '\0' ? *result : first;
        try_again(work);
        good = commission_stage(work);
    }
    name_first(result, &first);
    name_small_range(work);
    return good;
}

/* An error of the measured link causes the same error of R, L and psi_f. false: it is larger than the
 * tolerance of a divider, and `result` has the reason. */
static bool link_agrees(commission_work_t *work)
{
    char text[160];
    const double meter = work->options->link;
    if (!(meter > 0.0) || fabs(work->link - meter) <= LINK_ERROR * meter) {
        return true;
    }
    snprintf(text, sizeof text, "the drive measures %.4g V at the DC link, the meter shows %.4g V",
             work->link, meter);
    commission_end(work, "link_mismatch", text, "check the meter and the divider of the DC link");
    return false;
}

/* True if the step is requested, or if a later one needs it. */
static bool is_needed(const commission_work_t *work, uint32_t step)
{
    const commission_options_t *options = work->options;
    const bool alone = step == (uint32_t)COMMISSION_DO_board || step == (uint32_t)COMMISSION_DO_angle ||
                       step == (uint32_t)COMMISSION_DO_current_loop || step == (uint32_t)COMMISSION_DO_turn;
    const bool answered =
        options->ask != NULL || (options->chosen && options->plant_answers && work->drive->turned != NULL);
    if (step == (uint32_t)COMMISSION_DO_turn && !answered) {
        return false;
    }
    if (step == (uint32_t)COMMISSION_DO_angle && !options->chosen) {
        return false;
    }
    bool needed = !options->skip[step];
    for (uint32_t n = step + 1u; !alone && n < COMMISSION_STEP_COUNT; n++) {
        needed = needed || !options->skip[n];
    }
    return needed;
}

static bool run_steps(commission_work_t *work)
{
    const commission_options_t *options = work->options;
    commission_result_t *result = work->result;
    const double begin = work->drive->seconds(work->drive->context);
    bool good = true;
    for (uint32_t n = 0; good && result->reason[0] == '\0' && n < COMMISSION_STEP_COUNT; n++) {
        if (!is_needed(work, n)) {
            continue;
        }
        result->step = n;
        good = try_step(work, (commission_do_t)n);
        const double earlier = result->seconds;
        result->seconds = work->drive->seconds(work->drive->context) - begin;
        result->step_seconds[n] = result->seconds - earlier;
        if (work->drive->largest != NULL) {
            result->largest_current =
                fmax(result->largest_current, work->drive->largest(work->drive->context));
        }
        if (good && options->progress != NULL) {
            options->progress(options->context, (commission_do_t)n, true, result);
        }
    }
    return good;
}

/* ---- the parameters at the begin ---- */

/* Values of all parameters, in the order of the table. */
static void keep(commission_work_t *work, double values[PARAMS_MOST])
{
    const table_t *params = rig_table(0u);
    for (uint32_t n = 0; n < params->count && n < PARAMS_MOST; n++) {
        values[n] = (double)NAN;
        (void)work->drive->get(work->drive->context, &params->rows[n], &values[n]);
    }
}

static void put_back(commission_work_t *work, const double values[PARAMS_MOST])
{
    const table_t *params = rig_table(0u);
    for (uint32_t n = 0; !work->lost && n < params->count && n < PARAMS_MOST; n++) {
        double now = values[n];
        (void)work->drive->get(work->drive->context, &params->rows[n], &now);
        if (isfinite(values[n]) && now != values[n]) {
            (void)work->drive->put(work->drive->context, &params->rows[n], values[n]);
        }
    }
    (void)(work->lost || work->drive->apply(work->drive->context));
}

bool commission_drive(const commission_drive_t *drive, const commission_plate_t *plate,
                      const commission_options_t *options, commission_result_t *result,
                      scenario_error_t *error)
{
    commission_work_t work = {
        .drive = drive, .plate = plate, .options = options, .result = result, .error = error, .raised = 1.0};
    double before[PARAMS_MOST];
    clear(result);
    (void)commission_put(&work, "enable", 0.0);
    (void)commission_put(&work, "commission", 0.0);
    if (!commission_wait_for(&work, "state", commission_choice("state", "ready"), WAIT_READY)) {
        commission_end_with_fault(&work);
        return true;
    }
    work.link = commission_value(&work, "u_dc");
    if (!link_agrees(&work)) {
        return true;
    }
    keep(&work, before);
    const bool good = run_steps(&work);
    const bool whole = good && result->reason[0] == '\0' && commission_known(result);
    if (!whole || !commission_stage_result(&work)) {
        put_back(&work, before);
    }
    return good;
}

bool commission_rig(rig_t *rig, const commission_plate_t *plate, const commission_options_t *options,
                    commission_result_t *result, scenario_error_t *error)
{
    commission_rig_room_t room;
    const commission_drive_t drive = commission_rig_drive(&room, rig);
    const bool good = commission_drive(&drive, plate, options, result, error);
    commission_rig_leave(&room);
    return good;
}

bool commission_known(const commission_result_t *result)
{
    return isfinite(result->resistance.value) && isfinite(result->inductance_q.value) &&
           isfinite(result->flux_linkage.value);
}

void commission_write(FILE *file, const commission_plate_t *plate, const commission_result_t *result,
                      const char *title)
{
    fprintf(file, "title = \"%s\"\nsource = \"measured by the drive itself: lagless commission\"\n", title);
    fprintf(file, "pole_pairs = %.0f # of the plate\n", plate->pole_pairs);
    fprintf(file, "rated_current_peak = \"%.9g A\" # of the plate\n", plate->current);
    fprintf(file, "rated_speed = \"%.9g rad/s\" # of the plate\n", plate->speed);
    const struct {
        const char *key, *unit;
        commission_value_t value;
    } rows[] = {
        {"resistance", "ohm", result->resistance},
        {"inductance_d", "H", result->inductance_d},
        {"inductance_q", "H", result->inductance_q},
        {"saturation_current", "A", result->saturation_current},
        {"flux_linkage", "Wb", result->flux_linkage},
        {"inertia", "kg m^2", result->inertia},
        {"friction_coulomb", "N m", result->friction_coulomb},
        {"friction_viscous", "N m s/rad", result->friction_viscous},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const bool none = rows[n].value.value == 0.0 && strcmp(rows[n].key, "saturation_current") == 0;
        if (isfinite(rows[n].value.value) && !none) {
            fprintf(file, "%s = \"%.6g %s\" # +-%.2g\n", rows[n].key, rows[n].value.value, rows[n].unit,
                    rows[n].value.error);
        }
    }
}
