/* The parameters of a step: the rows of tune for the values that are measured so far, and estimates from the
 * plate for the others. */
#include "host_sim/lab/commission_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/tune.h"

#define SQRT_3 1.7320508075688772

#define TRIP  1.25 /* overcurrent_trip over current_limit */
#define START 0.6  /* start_current over current_limit, at most */

/* A motor that is not measured yet, for the rows of tune: shares of the limits by plate and link. */
#define GUESS_FLUX       0.6  /* of the link's voltage at the largest speed */
#define GUESS_INDUCTANCE 0.3  /* L I over psi_f */
#define GUESS_RESISTANCE 0.03 /* R I over the EMF */

#define SPEED         0.58 /* of the largest speed: both turning steps */
#define VOLTAGE       0.75 /* of the voltage */
#define FLUX_OVER     1.8  /* flux test over the speed of the hand-over, at least ... */
#define TORQUE_OVER   2.4  /* the same of the torque test, which coasts down to 1.3 ... */
#define SPEED_MOST    0.85 /* ... but at most this share of the largest speed, and of the voltage */
#define HANDOVER_MOST 0.49 /* of overspeed_trip: the drive accepts half of it */

double commission_choice(const char *row, const char *choice)
{
    return (double)table_choice(rig_row_by_name(row), choice);
}

static bool refuse(commission_work_t *work, const char *what)
{
    snprintf(work->error->name, sizeof work->error->name, "plate");
    snprintf(work->error->message, sizeof work->error->message, "%s: %s", what,
             work->drive->why(work->drive->context));
    return false;
}

/* The measured values of the motor so far, in the form for tune; the others are estimated from the plate.
 * */
static motor_t motor_so_far(const commission_work_t *work)
{
    const commission_plate_t *plate = work->plate;
    const commission_result_t *result = work->result;
    const double emf = GUESS_FLUX * work->link / SQRT_3;
    const double flux = isfinite(result->flux_linkage.value) ? result->flux_linkage.value
                        : result->flux_first > 0.0           ? result->flux_first
                                                             : emf / (plate->pole_pairs * plate->speed);
    const double torque = 1.5 * plate->pole_pairs * flux * plate->current;
    const double lightest = rig_min(rig_row_by_name("plant.inertia")); /* that tune accepts */
    const double inertia = isfinite(result->inertia.value) ? result->inertia.value
                           : result->inertia_first > 0.0   ? result->inertia_first
                                                           : torque * 0.05 / plate->speed;
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
        [MOTOR_SATURATION] =
            isfinite(result->saturation_current.value) ? result->saturation_current.value : 0.0,
        [MOTOR_FLUX] = flux,
        [MOTOR_CURRENT] = plate->current,
        [MOTOR_TORQUE] = torque,
        [MOTOR_SPEED] = plate->speed,
        [MOTOR_LINK] = work->link,
        [MOTOR_INERTIA] = fmax(inertia, lightest),
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

/* The delays with which the model of the inverter has the measured loss at this link voltage, and the
 * measured zone. The loss shows the difference of the two delays; the turn-off delay stays that of the board,
 * because the step `inductance` also needs their sum. */
static bool stage_dead_time(commission_work_t *work)
{
    const double lost = work->result->dead_voltage.value;
    if (!isfinite(lost)) {
        return true;
    }
    const double drop = commission_value(work, "device_drop");
    const double effective = (lost - drop) * RIG_PERIOD_SECONDS / work->link;
    const double off = commission_value(work, "params.turn_off_delay");
    const double delay = effective - commission_value(work, "params.dead_time") + off;
    const table_row_t *on = rig_row_by_name("params.turn_on_delay");
    const double most = rig_max(on);
    const table_row_t *zone = rig_row_by_name("params.current_zone");
    const double width = fmin(fmax(work->result->current_zone.value, rig_min(zone)), rig_max(zone));
    return work->drive->put(work->drive->context, zone, width) &&
           commission_put(work, "params.turn_on_delay", fmin(fmax(delay, 0.0), most)) &&
           commission_put(work, "params.turn_off_delay", fmin(off + fmax(-delay, 0.0), most));
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

/* A start with less current than a tuned drive uses, which leaves a margin below the trip for inexact data.
 */
static double start_current(const tune_t *tune)
{
    const double most = START * tuned_value(tune, "current_limit");
    const double start = tuned_value(tune, "start_current");
    return start > 0.0 ? fmin(start, most) : most;
}

/* A hand-over at a higher speed than by the rules, at which the back-EMF is large compared with the noise.
 * */
static bool raise_handover(commission_work_t *work, double by_rule)
{
    const double most = HANDOVER_MOST * commission_value(work, "overspeed_trip");
    work->handover = fmin(work->raised * by_rule, fmax(most, by_rule));
    return commission_put(work, "handover_speed", work->raised > 1.0 ? work->handover : 0.0);
}

/* The rows of `lagless tune` for the present results. false: they are refused; `tuned` is true if the drive
 * refuses them. */
static bool put_rows(commission_work_t *work, tune_t *tune, bool *tuned)
{
    const motor_t motor = motor_so_far(work);
    bool good = tune_motor(&motor, tune, work->error);
    *tuned = good;
    for (uint32_t n = 0; good && n < tune->count; n++) {
        const tune_row_t *row = &tune->rows[n];
        if (scenario_is_param(row->row)) {
            good = work->drive->put(work->drive->context, row->row, row->value);
        }
    }
    return good;
}

static bool put_parameters(commission_work_t *work)
{
    /* The loss of the legs is measured at standstill. Learning it from the EMF as well would replace it by
     * a worse value if the zone of the legs is wide compared with the current. */
    static const char *const off[] = {"inductance_adaptation", "dead_time_adaptation"};
    tune_t *tune = malloc(sizeof *tune);
    bool tuned = false;
    bool good = tune != NULL && put_rows(work, tune, &tuned);
    good = good && commission_put(work, "start_current", start_current(tune));
    good = good && raise_handover(work, tune->handover);
    free(tune);
    good = good &&
           commission_put(work, "position_source", commission_choice("position_source", "sensorless")) &&
           commission_put(work, off[0], 0.0) && commission_put(work, off[1], 0.0) && stage_dead_time(work) &&
           work->drive->apply(work->drive->context);
    if (good) {
        /* 1.25 of the largest current and half the ripple, where the rules accept that */
        const double limit = commission_value(work, "current_limit");
        const double ripple = commission_value(work, "commission_inductance_pulse") > 0.0
                                  ? work->link * RIG_PERIOD_SECONDS /
                                        (24.0 * commission_value(work, "commission_inductance_pulse"))
                                  : 0.0;
        const double trip = commission_value(work, "overcurrent_trip");
        if (!commission_put(work, "overcurrent_trip", TRIP * limit + ripple) ||
            !work->drive->apply(work->drive->context)) {
            good = commission_put(work, "overcurrent_trip", trip) &&
                   commission_put(work, "current_limit", fmin(limit, (trip - ripple) / TRIP)) &&
                   work->drive->apply(work->drive->context);
        }
    }
    return good || (tuned ? refuse(work, "the parameters that follow from it are refused") : false);
}

/* The rules refuse the parameters of a step. true: R is measured, so plate and measurement contradict each
 * other, which becomes the reason. */
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

bool commission_stage(commission_work_t *work)
{
    return put_parameters(work) || contradicts(work->result, work->error);
}

bool commission_stage_result(commission_work_t *work)
{
    /* the rules do not set these rows, which the steps have changed */
    static const char *const own[] = {"start_current", "handover_speed", "fallback_speed",
                                      "inductance_adaptation", "dead_time_adaptation"};
    tune_t *tune = malloc(sizeof *tune);
    bool tuned = false;
    bool good = tune != NULL;
    for (size_t n = 0; good && n < sizeof own / sizeof own[0]; n++) {
        good = commission_put(work, own[n], rig_initial_named(own[n]));
    }
    good = good && put_rows(work, tune, &tuned) && stage_dead_time(work) &&
           work->drive->apply(work->drive->context);
    work->handover = good ? tune->handover : work->handover;
    free(tune);
    return good || (tuned ? refuse(work, "the parameters that follow from it are refused") : false);
}

double commission_speed(commission_work_t *work, commission_do_t step)
{
    const motor_t motor = motor_so_far(work);
    const double top = work->link / SQRT_3 / (motor.value[MOTOR_POLE_PAIRS] * motor.value[MOTOR_FLUX]);
    const bool flux = step == COMMISSION_DO_flux;
    const double speed = fmin(SPEED * work->plate->speed, VOLTAGE * top);
    /* margin above the hand-over speed if dead time and R I make it high */
    const double room =
        fmin((flux ? FLUX_OVER : TORQUE_OVER) * work->handover, SPEED_MOST * fmin(work->plate->speed, top));
    return fmin(fmax(speed, room), 0.9 * commission_value(work, "overspeed_trip"));
}
