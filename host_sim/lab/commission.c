#include "host_sim/lab/commission.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/commission_parts.h"
#include "host_sim/lab/course.h"
#include "settings/reasons.h"

#define WAIT_READY     2.0   /* [s] until the drive is ready */
#define WAIT_ON        4.0   /* [s] until it is on */
#define WAIT_FAULT     6.0   /* [s] until a fault is latched that has opened the bridge */
#define LINK_ERROR     0.05  /* largest difference from the user's meter, relative */
#define LINEAR         1e5   /* [A] least saturation current of a q axis without a saturation */
#define SLICE          25u   /* [periods] between two looks */
#define COAST          0.3   /* [s] after a turning step */
#define STEP_MOST      150.0 /* [s] above the largest time of every step in the drive */
#define OVER_TOP       1.4   /* overspeed_trip over the largest speed of tune */
#define RANGE_LEAST    150.0 /* [rad/s] electrical: least rated speed for the turning steps */
#define HANDOVER_STEP  0.5   /* by which the hand-over becomes faster with each try, of that of the rules */
#define HANDOVER_TIMES 2.0   /* of that of the rules, at most */
static const char *const names[] = {
#define NAME_OF(name, text) #name,
    COMMISSION_LIST(NAME_OF)
#undef NAME_OF
};
static const char *const texts[] = {
#define TEXT_OF(name, text) text,
    COMMISSION_LIST(TEXT_OF)
#undef TEXT_OF
};

const char *commission_step_name(commission_do_t step)
{
    return names[step];
}

const char *commission_step_text(commission_do_t step)
{
    return texts[step];
}

static void choice_name(const char *row, double value, char *to, size_t size)
{
    const char *at = rig_row_by_name(row)->choices;
    for (uint32_t n = 0; n < (uint32_t)value; n++) {
        at += strcspn(at, "|");
        at += *at == '|' ? 1u : 0u;
    }
    snprintf(to, size, "%.*s", (int)strcspn(at, "|"), at);
}

/* ---- steps ---- */

static bool wait_for(commission_work_t *work, const char *row, double value, double seconds)
{
    const uint32_t most = rig_periods(seconds);
    for (uint32_t n = 0; n < most; n += SLICE) {
        if (rig_value(work->rig, row) == value) {
            return true;
        }
        (void)rig_run(work->rig, SLICE);
    }
    return rig_value(work->rig, row) == value;
}

static void end_with(commission_work_t *work, const char *name, const char *text, const char *remedy)
{
    snprintf(work->result->reason, sizeof work->result->reason, "%s", name);
    snprintf(work->result->what, sizeof work->result->what, "%s; %s", text, remedy);
}

/* The drive has latched a fault: its reason, under the name that it has in this step. */
static void end_with_fault(commission_work_t *work)
{
    const reason_row_t *row = reason_by_number((int32_t)rig_value(work->rig, "fault_reason"));
    const bool wiring = work->result->step == COMMISSION_DO_wiring;
    const char *name = row == NULL                                   ? "fault"
                       : row->number == REASON_OVERCURRENT && wiring ? "wiring_overcurrent"
                       : row->number == REASON_CURRENT_OFFSET        ? "offset"
                       : row->number == REASON_DC_UNDERVOLTAGE       ? "link_low"
                                                                     : row->name;
    end_with(work, name, row != NULL ? row->text : "the drive has latched a fault",
             row != NULL ? row->remedy : "read fault_reason");
}

/* What a reason of a step means (firmware/medium/commission/commission_types.h). */
static void end_with_reason(commission_work_t *work)
{
    char name[48];
    char detail[96] = "";
    const int number = (int)rig_value(work->rig, "commission_reason");
    const int value = (int)rig_value(work->rig, "commission_detail");
    choice_name("commission_reason", number, name, sizeof name);
    if (strcmp(name, "open_phase") == 0 && value >= 1 && value <= 3) {
        snprintf(detail, sizeof detail, "phase %c", 'a' + value - 1);
    } else if (strcmp(name, "sensor_map") == 0) {
        snprintf(detail, sizeof detail, "sensor a sits on leg %c%s, sensor b on leg %c%s",
                 'a' + value / 1000 - 1, value / 10 % 10 != 0 ? " with the wrong sign" : "",
                 'a' + value / 100 % 10 - 1, value % 10 != 0 ? " with the wrong sign" : "");
    } else if (value != 0) {
        snprintf(detail, sizeof detail, "sensor %c", 'a' + value - 1);
    }
    const reason_row_t *row = reason_of_commission(number);
    end_with(work, name, row->text, row->remedy);
    if (detail[0] != '\0') {
        char text[sizeof work->result->what];
        snprintf(text, sizeof text, "%s: %.290s", detail, work->result->what);
        snprintf(work->result->what, sizeof work->result->what, "%s", text);
    }
}

/* true: the user has stopped the step; the bridge is open a period later. */
static bool is_stopped(commission_work_t *work, commission_do_t step)
{
    const commission_options_t *options = work->options;
    if (options->goes_on == NULL || options->goes_on(options->context, step)) {
        return false;
    }
    (void)rig_put(work->rig, "enable", 0.0);
    end_with(work, "stopped_by_user", "the step was stopped",
             "begin again; the results of earlier steps stay");
    return true;
}

/* One step from a bridge that is off to a bridge that is off. false: `result` has the reason. */
static bool run_step(commission_work_t *work, commission_do_t step)
{
    rig_t *rig = work->rig;
    const bool turns = step >= COMMISSION_DO_flux;
    const double done = commission_choice("commission_state", "done");
    const double failed = commission_choice("commission_state", "failed");
    const double fault = commission_choice("state", "fault");
    bool ended = wait_for(work, "state", commission_choice("state", "ready"), WAIT_READY) &&
                 rig_put(rig, "speed_request", turns ? commission_speed(work, step) : 0.0) &&
                 rig_put(rig, "commission", commission_choice("commission", names[step])) &&
                 (step == COMMISSION_DO_board || rig_put(rig, "enable", 1.0));
    const uint32_t most = rig_periods(STEP_MOST);
    const uint32_t on = rig_periods(WAIT_ON);
    (void)rig_run(rig, SLICE);
    for (uint32_t n = 0; ended && n < most; n += SLICE) {
        if (is_stopped(work, step)) {
            break;
        }
        const double state = rig_value(rig, "commission_state");
        if (state == done || state == failed || rig_value(rig, "state") == fault ||
            (n > on && rig_value(rig, "refusal") != 0.0)) {
            break;
        }
        (void)rig_run(rig, SLICE);
    }
    const bool opened =
        rig_value(rig, "commission_state") == failed &&
        rig_value(rig, "commission_reason") == commission_choice("commission_reason", "bridge_opened");
    if (opened) { /* a fault that stops the motor first is latched later */
        (void)wait_for(work, "state", fault, WAIT_FAULT);
    }
    if (work->result->reason[0] != '\0') {
        ended = false;
    } else if (rig_value(rig, "state") == fault) {
        end_with_fault(work);
    } else if (rig_value(rig, "commission_state") == failed) {
        end_with_reason(work);
    } else if (rig_value(rig, "commission_state") != done) {
        const reason_row_t *row = reason_by_number((int32_t)rig_value(rig, "refusal"));
        end_with(work, row != NULL && row->number != 0 ? row->name : "time_out",
                 row != NULL ? row->text : "the step did not end", row != NULL ? row->remedy : "repeat it");
    }
    ended = work->result->reason[0] == '\0';
    (void)rig_put(rig, "enable", 0.0);
    (void)rig_run(rig, rig_periods(turns ? COAST : 0.05));
    (void)rig_put(rig, "commission", 0.0);
    (void)rig_run(rig, SLICE);
    return ended;
}

/* A signal as a result; 0 is not measured. */
static commission_value_t measured(commission_work_t *work, const char *row, double relative)
{
    const double value = rig_value(work->rig, row);
    return value > 0.0 ? (commission_value_t){value, relative * value}
                       : (commission_value_t){(double)NAN, (double)NAN};
}

/* What the drive knows after a step. The uncertainties: of R half the spread of the directions; of L the
 * study's accuracy; of psi_f and J scatter of the measurement and the link's and the dead time's share. */
static void take(commission_work_t *work, commission_do_t step)
{
    commission_result_t *result = work->result;
    if (step == COMMISSION_DO_resistance) {
        const commission_value_t all = measured(work, "commission_resistance", 0.0);
        const double device = rig_value(work->rig, "device_resistance");
        const double spread = rig_value(work->rig, "commission_resistance_spread");
        result->resistance = (commission_value_t){all.value - device, 0.5 * spread * all.value};
        result->dead_voltage = measured(work, "commission_dead_voltage", 0.02);
        result->current_zone = measured(work, "commission_current_zone", 0.1);
    } else if (step == COMMISSION_DO_inductance) {
        result->inductance_d = measured(work, "commission_inductance_d", 0.01);
        result->inductance_q = measured(work, "commission_inductance_q", 0.03);
        result->saturation_current = measured(work, "commission_saturation_current", 0.1);
        if (result->saturation_current.value >= LINEAR) {
            result->saturation_current = (commission_value_t){0.0, 0.0};
        }
    } else if (step == COMMISSION_DO_swing) {
        result->flux_first = rig_value(work->rig, "commission_flux_first");
        result->inertia_first = rig_value(work->rig, "commission_inertia_first");
    } else if (step == COMMISSION_DO_flux) {
        result->flux_linkage = measured(work, "commission_flux_linkage", 0.01);
    } else if (step == COMMISSION_DO_inertia) {
        const double scatter = rig_value(work->rig, "commission_inertia_scatter");
        result->inertia = measured(work, "commission_inertia", 0.015 + 2.0 * scatter);
        result->friction_coulomb.value = rig_value(work->rig, "commission_friction_coulomb");
        result->friction_coulomb.error = 0.1 * result->friction_coulomb.value;
        result->friction_viscous.value = rig_value(work->rig, "commission_friction_viscous");
        result->friction_viscous.error = 0.1 * result->friction_viscous.value;
    }
}

static void clear(commission_result_t *result)
{
    const commission_value_t none = {(double)NAN, (double)NAN};
    memset(result, 0, sizeof *result);
    result->resistance = result->inductance_d = result->inductance_q = none;
    result->flux_linkage = result->inertia = result->saturation_current = none;
    result->friction_coulomb = result->friction_viscous = result->dead_voltage = result->current_zone = none;
}

static void note_currents(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    commission_result_t *result = context;
    (void)period;
    for (uint32_t n = 0; n < count; n++) {
        float value;
        memcpy(&value, &slots[n], sizeof value);
        result->largest_current = fmax(result->largest_current, fabs((double)value));
    }
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

commission_plate_t commission_plate_of(rig_t *rig)
{
    const double continuous = rig_value(rig, "motor_current_continuous");
    return (commission_plate_t){
        .pole_pairs = rig_value(rig, "motor_pole_pairs"),
        .current = continuous > 0.0 ? continuous : 0.5 * rig_value(rig, "current_limit"),
        .speed = rig_value(rig, "overspeed_trip") / OVER_TOP,
    };
}

static bool is_one_of(const char *name, const char *const *list, size_t count)
{
    bool found = false;
    for (size_t n = 0; n < count; n++) {
        found = found || strcmp(name, list[n]) == 0;
    }
    return found;
}

/* The estimate was lost, or too noisy: a faster hand-over may help. */
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
    end_with(work, "speed_range_small", text, "permit more speed, or enter psi_f and J from the data sheet");
}

/* Clears what a try has left. */
static void try_again(commission_work_t *work)
{
    work->raised += HANDOVER_STEP;
    work->result->reason[0] = '\0';
    work->result->what[0] = '\0';
    (void)rig_put(work->rig, "fault_reset", 1.0);
    (void)rig_run(work->rig, SLICE);
    (void)rig_put(work->rig, "fault_reset", 0.0);
    (void)rig_run(work->rig, SLICE);
}

/* A step with all its tries; a result has no reason. false: the plate is not accepted. */
static bool try_step(commission_work_t *work, commission_do_t step)
{
    const commission_options_t *options = work->options;
    commission_result_t *result = work->result;
    bool good = commission_stage(work);
    while (good && result->reason[0] == '\0') {
        if (options->progress != NULL) {
            options->progress(options->context, step, false, result);
        }
        if (run_step(work, step)) {
            take(work, step);
            return true;
        }
        if (step < COMMISSION_DO_flux || !worth_another_try(work)) {
            break;
        }
        try_again(work);
        good = commission_stage(work);
    }
    name_small_range(work);
    return good;
}

/* An error of the measured link is the same one of R, L and psi_f. false: it is beyond what a divider may
 * have, and `result` says so. */
static bool link_agrees(commission_work_t *work)
{
    char text[160];
    const double meter = work->options->link;
    if (!(meter > 0.0) || fabs(work->link - meter) <= LINK_ERROR * meter) {
        return true;
    }
    snprintf(text, sizeof text, "the drive measures %.4g V at the DC link, the meter shows %.4g V",
             work->link, meter);
    end_with(work, "link_mismatch", text, "check the meter and the divider of the DC link");
    return false;
}

/* The step is requested, or a later one needs it. */
static bool is_needed(const commission_options_t *options, uint32_t step)
{
    bool needed = !options->skip[step];
    for (uint32_t n = step + 1u; step != (uint32_t)COMMISSION_DO_board && n < COMMISSION_STEP_COUNT; n++) {
        needed = needed || !options->skip[n];
    }
    return needed;
}

bool commission_rig(rig_t *rig, const commission_plate_t *plate, const commission_options_t *options,
                    commission_result_t *result, scenario_error_t *error)
{
    commission_work_t work = {
        .rig = rig, .plate = plate, .options = options, .result = result, .error = error, .raised = 1.0};
    const uint32_t currents[] = {rig_row_by_name("i_a")->id, rig_row_by_name("i_b")->id,
                                 rig_row_by_name("i_c")->id};
    const uint32_t begin = rig_period(rig);
    clear(result);
    (void)rig_put(rig, "enable", 0.0);
    (void)rig_put(rig, "commission", 0.0);
    if (!wait_for(&work, "state", commission_choice("state", "ready"), WAIT_READY)) {
        end_with_fault(&work);
        return true;
    }
    work.link = rig_value(rig, "u_dc");
    if (!link_agrees(&work)) {
        return true;
    }
    (void)rig_tap(rig, currents, 3u, 1u, note_currents, result);
    bool good = true;
    for (uint32_t n = 0; good && result->reason[0] == '\0' && n < COMMISSION_STEP_COUNT; n++) {
        if (!is_needed(options, n)) {
            continue;
        }
        result->step = n;
        good = try_step(&work, (commission_do_t)n);
        const double earlier = result->seconds;
        result->seconds = (rig_period(rig) - begin) * RIG_PERIOD_SECONDS;
        result->step_seconds[n] = result->seconds - earlier;
        if (good && options->progress != NULL) {
            options->progress(options->context, (commission_do_t)n, true, result);
        }
    }
    (void)rig_tap(rig, currents, 0u, 1u, NULL, NULL);
    return good;
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
