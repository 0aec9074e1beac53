#include "host_sim/lab/commission.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/course.h"
#include "host_sim/lab/tune.h"
#include "settings/reasons.h"

#define SQRT_3 1.7320508075688772

#define WAIT_READY 2.0   /* [s] until the drive is ready */
#define WAIT_ON    4.0   /* [s] until it is on */
#define SLICE      25u   /* [periods] between two looks */
#define COAST      0.3   /* [s] after a turning step */
#define STEP_MOST  150.0 /* [s] above the largest time of every step in the drive */
#define OVER_TOP   1.4   /* overspeed_trip over the largest speed of tune */
#define TRIP       1.25  /* overcurrent_trip over current_limit */
#define START      0.6   /* start_current over current_limit, at most */

/* A motor that is not known yet, for the rows of tune: shares of what plate and link allow. */
#define GUESS_FLUX       0.6  /* of the link's voltage at the largest speed */
#define GUESS_INDUCTANCE 0.3  /* L I over psi_f */
#define GUESS_RESISTANCE 0.03 /* R I over the EMF */

#define FLUX_SPEED     0.58 /* of the largest speed: flux test */
#define FLUX_VOLTAGE   0.75 /* of the voltage */
#define TORQUE_SPEED   0.58 /* of the largest speed: torque test */
#define TORQUE_VOLTAGE 0.75
#define FLUX_OVER      1.8   /* flux test over the speed of the hand-over, at least ... */
#define TORQUE_OVER    2.4   /* the same of the torque test, which coasts down to 1.3 ... */
#define RANGE_LEAST    150.0 /* [rad/s] electrical: least rated speed for the turning steps */
#define HANDOVER_STEP  0.5   /* by which the hand-over becomes faster with each try, of that of the rules */
#define HANDOVER_TIMES 2.0   /* of that of the rules, at most */
#define HANDOVER_MOST  0.49  /* of overspeed_trip: the drive accepts half of it */
#define SPEED_MOST     0.85  /* ... and no more than this of the largest speed, and of the voltage */

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

typedef struct {
    rig_t *rig;
    const commission_plate_t *plate;
    commission_result_t *result;
    scenario_error_t *error;
    double link;     /* [V] */
    double handover; /* speed of the hand-over with the parameters of this step, mechanical [rad/s] */
    double raised;   /* of the hand-over that is used over the one of the rules [-] */
} work_t;

/* ---- the choice of a row by name ---- */

static double choice_of(const char *row, const char *choice)
{
    return (double)table_choice(rig_row_by_name(row), choice);
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

/* ---- parameters ---- */

static bool refuse(work_t *work, const char *what)
{
    snprintf(work->error->name, sizeof work->error->name, "plate");
    snprintf(work->error->message, sizeof work->error->message, "%s: %s", what, rig_error(work->rig));
    return false;
}

/* What is known of the motor so far, as tune wants it; the rest is guessed from the plate. */
static motor_t motor_so_far(const work_t *work)
{
    const commission_plate_t *plate = work->plate;
    const commission_result_t *result = work->result;
    const double emf = GUESS_FLUX * work->link / SQRT_3;
    const double flux = isfinite(result->flux_linkage.value) ? result->flux_linkage.value
                        : result->flux_first > 0.0           ? result->flux_first
                                                             : emf / (plate->pole_pairs * plate->speed);
    const double torque = 1.5 * plate->pole_pairs * flux * plate->current;
    motor_t motor = {.name = "measured"};
    const double values[MOTOR_QUANTITIES] = {
        [MOTOR_POLE_PAIRS] = plate->pole_pairs,
        [MOTOR_RESISTANCE] = isfinite(result->resistance.value) ? fmax(result->resistance.value, 1e-3)
                                                                : GUESS_RESISTANCE * emf / plate->current,
        [MOTOR_INDUCTANCE_D] = isfinite(result->inductance_d.value)
                                   ? result->inductance_d.value
                                   : GUESS_INDUCTANCE * flux / plate->current,
        [MOTOR_INDUCTANCE_Q] = isfinite(result->inductance_q.value)
                                   ? result->inductance_q.value
                                   : GUESS_INDUCTANCE * flux / plate->current,
        [MOTOR_FLUX] = flux,
        [MOTOR_CURRENT] = plate->current,
        [MOTOR_TORQUE] = torque,
        [MOTOR_SPEED] = plate->speed,
        [MOTOR_LINK] = work->link,
        [MOTOR_INERTIA] = isfinite(result->inertia.value) ? result->inertia.value
                          : result->inertia_first > 0.0   ? result->inertia_first
                                                          : torque * 0.05 / plate->speed,
        [MOTOR_COULOMB] =
            isfinite(result->friction_coulomb.value) ? result->friction_coulomb.value : 0.03 * torque,
        [MOTOR_VISCOUS] = isfinite(result->friction_viscous.value) ? result->friction_viscous.value : 0.0,
    };
    memcpy(motor.value, values, sizeof values);
    for (uint32_t n = 0; n < MOTOR_QUANTITIES; n++) {
        motor.has[n] = values[n] != 0.0;
    }
    return motor;
}

/* The delays with which the model of the inverter loses the measured voltage at this link. */
static bool stage_dead_time(work_t *work)
{
    const double lost = work->result->dead_voltage.value;
    if (!isfinite(lost)) {
        return true;
    }
    const double drop = rig_value(work->rig, "device_drop");
    const double effective = (lost - drop) * RIG_PERIOD_SECONDS / work->link;
    const double delay = effective - rig_value(work->rig, "params.dead_time");
    const table_row_t *on = rig_row_by_name("params.turn_on_delay");
    const double most = rig_max(on);
    return rig_put(work->rig, "params.turn_on_delay", fmin(fmax(delay, 0.0), most)) &&
           rig_put(work->rig, "params.turn_off_delay", fmin(fmax(-delay, 0.0), most));
}

/* A row of tune. */
static double tuned_value(const tune_t *tune, const char *name)
{
    for (uint32_t n = 0; n < tune->count; n++) {
        if (strcmp(tune->rows[n].row->name, name) == 0) {
            return tune->rows[n].value;
        }
    }
    return 0.0;
}

/* A start with less current than a tuned drive uses: room below the trip for data that are not exact. */
static double start_current(const tune_t *tune)
{
    const double most = START * tuned_value(tune, "current_limit");
    const double start = tuned_value(tune, "start_current");
    return start > 0.0 ? fmin(start, most) : most;
}

/* A hand-over faster than by the rules, where the back-EMF is large beside the noise. */
static bool raise_handover(work_t *work, double by_rule)
{
    const double most = HANDOVER_MOST * rig_value(work->rig, "overspeed_trip");
    work->handover = fmin(work->raised * by_rule, fmax(most, by_rule));
    return rig_put(work->rig, "handover_speed", work->raised > 1.0 ? work->handover : 0.0);
}

/* Parameters for the next step. */
static bool stage(work_t *work)
{
    static const char *const fixed[] = {"position_source", "inductance_adaptation"};
    const motor_t motor = motor_so_far(work);
    tune_t *tune = malloc(sizeof *tune);
    bool good = tune != NULL && tune_motor(&motor, tune, work->error);
    const bool tuned = good;
    for (uint32_t n = 0; good && n < tune->count; n++) {
        const tune_row_t *row = &tune->rows[n];
        if (scenario_is_param(row->row)) {
            good = rig_set(work->rig, row->row->id, row->value);
        }
    }
    good = good && rig_put(work->rig, "start_current", start_current(tune));
    good = good && raise_handover(work, tune->handover);
    free(tune);
    good = good && rig_put(work->rig, fixed[0], choice_of(fixed[0], "sensorless")) &&
           rig_put(work->rig, fixed[1], 0.0) && stage_dead_time(work) && rig_apply(work->rig);
    if (good) {
        /* 1.25 of the largest current and half the ripple, where the rules accept that */
        const double limit = rig_value(work->rig, "current_limit");
        const double ripple = rig_value(work->rig, "commission_inductance_pulse") > 0.0
                                  ? work->link * RIG_PERIOD_SECONDS /
                                        (24.0 * rig_value(work->rig, "commission_inductance_pulse"))
                                  : 0.0;
        const double trip = rig_value(work->rig, "overcurrent_trip");
        if (!rig_put(work->rig, "overcurrent_trip", TRIP * limit + ripple) || !rig_apply(work->rig)) {
            good = rig_put(work->rig, "overcurrent_trip", trip) &&
                   rig_put(work->rig, "current_limit", fmin(limit, (trip - ripple) / TRIP)) &&
                   rig_apply(work->rig);
        }
    }
    return good || (tuned ? refuse(work, "the parameters that follow from it are refused") : false);
}

/* ---- steps ---- */

static bool wait_for(work_t *work, const char *row, double value, double seconds)
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

static void end_with(work_t *work, const char *name, const char *text, const char *remedy)
{
    snprintf(work->result->reason, sizeof work->result->reason, "%s", name);
    snprintf(work->result->what, sizeof work->result->what, "%s; %s", text, remedy);
}

/* The drive has latched a fault: its reason, under the name that it has in this step. */
static void end_with_fault(work_t *work)
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
static void end_with_reason(work_t *work)
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

/* The speed of a turning step [rad/s], mechanical. */
static double speed_of(const work_t *work, commission_do_t step)
{
    const motor_t motor = motor_so_far(work);
    const double top = work->link / SQRT_3 / (motor.value[MOTOR_POLE_PAIRS] * motor.value[MOTOR_FLUX]);
    const bool flux = step == COMMISSION_DO_flux;
    const double speed = fmin((flux ? FLUX_SPEED : TORQUE_SPEED) * work->plate->speed,
                              (flux ? FLUX_VOLTAGE : TORQUE_VOLTAGE) * top);
    /* room above the hand-over, where dead time and R I make that fast */
    const double room =
        fmin((flux ? FLUX_OVER : TORQUE_OVER) * work->handover, SPEED_MOST * fmin(work->plate->speed, top));
    return fmin(fmax(speed, room), 0.9 * rig_value(work->rig, "overspeed_trip"));
}

/* One step from a bridge that is off to a bridge that is off. false: `result` has the reason. */
static bool run_step(work_t *work, commission_do_t step)
{
    rig_t *rig = work->rig;
    const bool turns = step >= COMMISSION_DO_flux;
    const double done = choice_of("commission_state", "done");
    const double failed = choice_of("commission_state", "failed");
    const double fault = choice_of("state", "fault");
    bool ended = wait_for(work, "state", choice_of("state", "ready"), WAIT_READY) &&
                 rig_put(rig, "speed_request", turns ? speed_of(work, step) : 0.0) &&
                 rig_put(rig, "commission", choice_of("commission", names[step])) &&
                 (step == COMMISSION_DO_board || rig_put(rig, "enable", 1.0));
    const uint32_t most = rig_periods(STEP_MOST);
    const uint32_t on = rig_periods(WAIT_ON);
    (void)rig_run(rig, SLICE);
    for (uint32_t n = 0; ended && n < most; n += SLICE) {
        const double state = rig_value(rig, "commission_state");
        if (state == done || state == failed || rig_value(rig, "state") == fault ||
            (n > on && rig_value(rig, "refusal") != 0.0)) {
            break;
        }
        (void)rig_run(rig, SLICE);
    }
    if (rig_value(rig, "state") == fault) {
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
static commission_value_t measured(work_t *work, const char *row, double relative)
{
    const double value = rig_value(work->rig, row);
    return value > 0.0 ? (commission_value_t){value, relative * value}
                       : (commission_value_t){(double)NAN, (double)NAN};
}

/* What the drive knows after a step. The uncertainties: of R half the spread of the directions; of L the
 * study's accuracy; of psi_f and J scatter of the measurement and the link's and the dead time's share. */
static void take(work_t *work, commission_do_t step)
{
    commission_result_t *result = work->result;
    if (step == COMMISSION_DO_resistance) {
        const commission_value_t all = measured(work, "commission_resistance", 0.0);
        const double device = rig_value(work->rig, "device_resistance");
        const double spread = rig_value(work->rig, "commission_resistance_spread");
        result->resistance = (commission_value_t){all.value - device, 0.5 * spread * all.value};
        result->dead_voltage = measured(work, "commission_dead_voltage", 0.02);
    } else if (step == COMMISSION_DO_inductance) {
        result->inductance_d = measured(work, "commission_inductance_d", 0.01);
        result->inductance_q = measured(work, "commission_inductance_q", 0.03);
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
    result->flux_linkage = result->inertia = none;
    result->friction_coulomb = result->friction_viscous = result->dead_voltage = none;
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

/* The rules refuse the parameters of a step. Once R is measured, plate and measurement contradict each other:
 * true, and that is the reason. */
static bool contradicts(commission_result_t *result, const scenario_error_t *error)
{
    if (!isfinite(result->resistance.value)) {
        return false;
    }
    snprintf(result->reason, sizeof result->reason, "plate_contradiction");
    snprintf(
        result->what, sizeof result->what,
        "no set of parameters for this step has the values of the plate and those that were measured: %.260s",
        error->message);
    return true;
}

static bool is_one_of(const char *name, const char *const *names, size_t count)
{
    bool found = false;
    for (size_t n = 0; n < count; n++) {
        found = found || strcmp(name, names[n]) == 0;
    }
    return found;
}

/* The estimate was lost, or too noisy: a faster hand-over may help. */
static bool worth_another_try(const work_t *work)
{
    static const char *const lost[] = {"lock_lost",       "start_unlocked",  "start_stalled",
                                       "estimate_astray", "sensorless_lost", "inertia_not_seen"};
    return is_one_of(work->result->reason, lost, sizeof lost / sizeof lost[0]) &&
           work->raised + HANDOVER_STEP <= HANDOVER_TIMES;
}

/* A turning step failed, and the rated speed is so small that the back-EMF hardly exceeds the loss of the
 * dead time: the range is the reason. */
static void name_small_range(work_t *work)
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
static void try_again(work_t *work)
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
static bool try_step(work_t *work, commission_do_t step, const commission_options_t *options)
{
    commission_result_t *result = work->result;
    bool good = stage(work) || contradicts(result, work->error);
    if (good && result->reason[0] == '\0' && options->progress != NULL) {
        options->progress(options->context, step, false, result);
    }
    while (good && result->reason[0] == '\0') {
        if (run_step(work, step)) {
            take(work, step);
            return true;
        }
        if (step < COMMISSION_DO_flux || !worth_another_try(work)) {
            break;
        }
        try_again(work);
        good = stage(work) || contradicts(result, work->error);
    }
    name_small_range(work);
    return good;
}

bool commission_rig(rig_t *rig, const commission_plate_t *plate, const commission_options_t *options,
                    commission_result_t *result, scenario_error_t *error)
{
    work_t work = {rig, plate, result, error, 0.0, 0.0, 1.0};
    const uint32_t currents[] = {rig_row_by_name("i_a")->id, rig_row_by_name("i_b")->id,
                                 rig_row_by_name("i_c")->id};
    const uint32_t begin = rig_period(rig);
    clear(result);
    (void)rig_put(rig, "enable", 0.0);
    (void)rig_put(rig, "commission", 0.0);
    if (!wait_for(&work, "state", choice_of("state", "ready"), WAIT_READY)) {
        end_with_fault(&work);
        return true;
    }
    work.link = rig_value(rig, "u_dc");
    (void)rig_tap(rig, currents, 3u, 1u, note_currents, result);
    bool good = true;
    for (uint32_t n = 0; good && result->reason[0] == '\0' && n < COMMISSION_STEP_COUNT; n++) {
        if (options->skip[n]) {
            continue;
        }
        result->step = n;
        good = try_step(&work, (commission_do_t)n, options);
        result->seconds = (rig_period(rig) - begin) * RIG_PERIOD_SECONDS;
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
        {"flux_linkage", "Wb", result->flux_linkage},
        {"inertia", "kg m^2", result->inertia},
        {"friction_coulomb", "N m", result->friction_coulomb},
        {"friction_viscous", "N m s/rad", result->friction_viscous},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        if (isfinite(rows[n].value.value)) {
            fprintf(file, "%s = \"%.6g %s\" # +-%.2g\n", rows[n].key, rows[n].value.value, rows[n].unit,
                    rows[n].value.error);
        }
    }
}
