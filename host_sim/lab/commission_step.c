/* One step of commissioning on the drive: request, wait, reason. */
#include "host_sim/lab/commission_parts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "settings/reasons.h"

#define WAIT_READY 2.0    /* [s] until the drive is ready */
#define WAIT_ON    4.0    /* [s] until it is on */
#define WAIT_FAULT 6.0    /* [s] until a fault is latched that has opened the bridge */
#define LOOK       2.5e-3 /* [s] between two checks */
#define COAST      0.3    /* [s] after a turning step */
#define STEP_MOST  30.0   /* [s] in addition to the largest time of a step in the drive */

/* ---- the drive ---- */

double commission_value(commission_work_t *work, const char *name)
{
    double value = (double)NAN;
    const bool good = !work->lost && work->drive->get(work->drive->context, rig_row_by_name(name), &value);
    work->lost = work->lost || !good;
    return good ? value : (double)NAN;
}

bool commission_put(commission_work_t *work, const char *name, double value)
{
    return !work->lost && work->drive->put(work->drive->context, rig_row_by_name(name), value);
}

static double seconds(const commission_work_t *work)
{
    return work->drive->seconds(work->drive->context);
}

void commission_wait(commission_work_t *work, double seconds)
{
    work->lost = work->lost || !work->drive->wait(work->drive->context, seconds);
}

bool commission_wait_for(commission_work_t *work, const char *row, double value, double most)
{
    const double begin = seconds(work);
    while (!work->lost && seconds(work) - begin < most) {
        if (commission_value(work, row) == value) {
            return true;
        }
        commission_wait(work, LOOK);
    }
    return commission_value(work, row) == value;
}

/* ---- ends ---- */

static void choice_name(const char *row, double value, char *to, size_t size)
{
    const char *at = rig_row_by_name(row)->choices;
    for (uint32_t n = 0; n < (uint32_t)value; n++) {
        at += strcspn(at, "|");
        at += *at == '|' ? 1u : 0u;
    }
    snprintf(to, size, "%.*s", (int)strcspn(at, "|"), at);
}

void commission_end(commission_work_t *work, const char *name, const char *text, const char *remedy)
{
    snprintf(work->result->reason, sizeof work->result->reason, "%s", name);
    snprintf(work->result->what, sizeof work->result->what, "%s; %s", text, remedy);
}

/* Translates the reason of a latched fault to the reason of this step. */
void commission_end_with_fault(commission_work_t *work)
{
    const reason_row_t *row = reason_by_number((int32_t)commission_value(work, "fault_reason"));
    const bool wiring = work->result->step == COMMISSION_DO_wiring;
    const char *name = row == NULL                                   ? "fault"
                       : row->number == REASON_OVERCURRENT && wiring ? "wiring_overcurrent"
                       : row->number == REASON_CURRENT_OFFSET        ? "offset"
                       : row->number == REASON_DC_UNDERVOLTAGE       ? "link_low"
                                                                     : row->name;
    commission_end(work, name, row != NULL ? row->text : "the drive has latched a fault",
                   row != NULL ? row->remedy : "read fault_reason");
}

/* The meaning of a reason of a step (firmware/medium/commission/commission_types.h). */
static void end_with_reason(commission_work_t *work)
{
    char name[48];
    char detail[96] = "";
    const int number = (int)commission_value(work, "commission_reason");
    const int value = (int)commission_value(work, "commission_detail");
    choice_name("commission_reason", number, name, sizeof name);
    if (strcmp(name, "open_phase") == 0 && value >= 1 && value <= 3) {
        snprintf(detail, sizeof detail, "phase %c", 'a' + value - 1);
    } else if (strcmp(name, "sensor_map") == 0) {
        snprintf(detail, sizeof detail, "sensor a is on leg %c%s, sensor b on leg %c%s",
                 'a' + value / 1000 - 1, value / 10 % 10 != 0 ? " with the wrong sign" : "",
                 'a' + value / 100 % 10 - 1, value % 10 != 0 ? " with the wrong sign" : "");
    } else if (strcmp(name, "current_loop") == 0) {
        snprintf(detail, sizeof detail, "%.2f of the design", commission_value(work, "commission_loop_gain"));
    } else if (strcmp(name, "no_standstill_angle") == 0) {
        snprintf(detail, sizeof detail, "%s",
                 value == 1   ? "the axis is known, its polarity is not"
                 : value == 2 ? "the ripple brings a phase current to zero"
                              : "");
    } else if (value != 0) {
        snprintf(detail, sizeof detail, "sensor %c", 'a' + value - 1);
    }
    const reason_row_t *row = reason_of_commission(number);
    commission_end(work, name, row->text, row->remedy);
    if (detail[0] != '\0') {
        char text[sizeof work->result->what];
        snprintf(text, sizeof text, "%s: %.290s", detail, work->result->what);
        snprintf(work->result->what, sizeof work->result->what, "%s", text);
    }
}

bool commission_is_stopped(commission_work_t *work, commission_do_t step)
{
    const commission_options_t *options = work->options;
    if (options->goes_on == NULL || options->goes_on(options->context, step)) {
        return false;
    }
    (void)commission_put(work, "enable", 0.0);
    commission_end(work, "stopped_by_user", "the user stopped the step and the bridge is open",
                   "begin again; the results of earlier steps are kept");
    return true;
}

/* ---- a step ---- */

/* The newest point that the drive has measured. */
static commission_measured_t point_of(commission_work_t *work, commission_do_t step)
{
    commission_measured_t point = {.step = (uint32_t)step};
    point.x = commission_value(work, "commission_point_x");
    point.y = commission_value(work, "commission_point_y");
    return point;
}

/* Adds the newest point to the result if it differs from the last one. A drive on a line can measure another
 * point between the two readings: then the next look adds it. */
static void take_point(commission_work_t *work, commission_measured_t *last)
{
    commission_result_t *result = work->result;
    const commission_measured_t point = point_of(work, (commission_do_t)last->step);
    if (work->lost || (point.x == last->x && point.y == last->y) ||
        commission_value(work, "commission_point_x") != point.x) {
        return;
    }
    *last = point;
    if (result->points_count < COMMISSION_POINTS) {
        result->points[result->points_count++] = point;
    }
}

/* Removes the points of an earlier try, which are the last ones of the result. */
static void forget_points(commission_result_t *result, commission_do_t step)
{
    while (result->points_count > 0u && result->points[result->points_count - 1u].step == (uint32_t)step) {
        result->points_count--;
    }
}

/* Waits for the end of the step, or of its time. `last`: the newest point before the step. */
static void wait_for_end(commission_work_t *work, commission_do_t step, commission_measured_t last)
{
    const double done = commission_choice("commission_state", "done");
    const double failed = commission_choice("commission_state", "failed");
    const double fault = commission_choice("state", "fault");
    const double begin = seconds(work);
    const double most = commission_step_seconds(step) + STEP_MOST;
    while (!work->lost && seconds(work) - begin < most && !commission_is_stopped(work, step)) {
        const double state = commission_value(work, "commission_state");
        const double heat = commission_value(work, "motor_heat");
        take_point(work, &last);
        work->result->largest_heat = fmax(work->result->largest_heat, work->lost ? 0.0 : heat);
        if (state == done || state == failed || commission_value(work, "state") == fault ||
            (seconds(work) - begin > WAIT_ON && commission_value(work, "refusal") != 0.0)) {
            break;
        }
        commission_wait(work, LOOK);
    }
}

/* The reason of a step that has no result. */
static void name_end(commission_work_t *work)
{
    const double failed = commission_choice("commission_state", "failed");
    const double fault = commission_choice("state", "fault");
    if (commission_value(work, "commission_state") == failed &&
        commission_value(work, "commission_reason") ==
            commission_choice("commission_reason", "bridge_opened")) {
        /* a fault that stops the motor first is latched later */
        (void)commission_wait_for(work, "state", fault, WAIT_FAULT);
    }
    const double state = commission_value(work, "commission_state");
    if (work->result->reason[0] != '\0') {
        return;
    }
    if (work->lost) {
        commission_end(work, "line_lost", "the link to the drive was lost",
                       "the drive opens the bridge after command_timeout; check the cable, then begin again");
    } else if (commission_value(work, "state") == fault) {
        commission_end_with_fault(work);
    } else if (state == failed) {
        end_with_reason(work);
    } else if (state != commission_choice("commission_state", "done")) {
        const reason_row_t *row = reason_by_number((int32_t)commission_value(work, "refusal"));
        const bool named = row != NULL && row->number != 0;
        commission_end(work, named ? row->name : "time_out", named ? row->text : "the step did not end",
                       named ? row->remedy : "repeat it");
    }
}

bool commission_run_step(commission_work_t *work, commission_do_t step)
{
    const bool turns = step >= COMMISSION_DO_flux;
    const commission_measured_t last = point_of(work, step);
    forget_points(work->result, step);
    const bool begun =
        commission_wait_for(work, "state", commission_choice("state", "ready"), WAIT_READY) &&
        commission_put(work, "speed_request", turns ? commission_speed(work, step) : 0.0) &&
        commission_put(work, "commission", commission_choice("commission", commission_step_name(step))) &&
        (step == COMMISSION_DO_board || commission_put(work, "enable", 1.0));
    commission_wait(work, LOOK);
    if (begun) {
        wait_for_end(work, step, last);
    }
    name_end(work);
    if (work->drive->largest == NULL) {
        const double largest = commission_value(work, "commission_largest");
        work->result->largest_current = fmax(work->result->largest_current, work->lost ? 0.0 : largest);
    }
    (void)commission_put(work, "enable", 0.0);
    commission_wait(work, turns ? COAST : 0.05);
    (void)commission_put(work, "commission", 0.0);
    commission_wait(work, LOOK);
    return work->result->reason[0] == '\0';
}
