/* Writes the scenario of `lagless tune`. */
#include <math.h>
#include <string.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/tune.h"

#define PI  3.14159265358979323846
#define RPM (PI / 30.0)

#define ANGLE_MOST   0.03 /* [rad] mean error of the estimate under load */
#define SCATTER_MOST 0.05 /* [rad] its standard deviation */

/* The grid: shares of the top speed and of the load there [-]. */
static const double grid_speeds[] = {1.0, 0.6, 0.3};
static const double grid_loads[] = {0.0, 0.5, 1.0};
#define GRID_SPEEDS   (sizeof grid_speeds / sizeof grid_speeds[0])
#define GRID_LOADS    (sizeof grid_loads / sizeof grid_loads[0])
#define GRID_HANDOVER 1.3 /* [-] of the hand-over speed: the estimate is not used below it */
#define GRID_SECONDS  0.2 /* [s] in which a point is judged */

static double row_value(const tune_t *tune, const char *name)
{
    for (uint32_t n = 0; n < tune->count; n++) {
        if (strcmp(tune->rows[n].row->name, name) == 0) {
            return tune->rows[n].value;
        }
    }
    return 0.0;
}

void tune_print(FILE *to, const tune_t *tune, const char *comment)
{
    bool plant = false;
    fprintf(to, "%s[params]\n", comment);
    for (uint32_t n = 0; n < tune->count; n++) {
        const tune_row_t *row = &tune->rows[n];
        char value[64];
        if (!plant && !scenario_is_param(row->row)) {
            fprintf(to, "%s\n%s[plant]\n", comment, comment);
            plant = true;
        }
        if (row->row->kind == SLOT_ENUM) {
            char text[UNITS_TEXT_SIZE];
            snprintf(value, sizeof value, "\"%.50s\"", units_row_text(text, row->value, row->row));
        } else {
            (void)rig_value_text(value, row->value);
        }
        fprintf(to, "%s%s = %s # %s\n", comment, row->row->name, value, row->reason);
    }
}

void tune_boards(FILE *to, const motor_t *motor, const char *comment)
{
    const double current = motor->value[MOTOR_CURRENT];
    const double link = motor->has[MOTOR_LINK] ? motor->value[MOTOR_LINK] : 0.0;
    fprintf(to,
            "%sThe full current limit needs a board with a range of +-%.3g A (1.2 x 1.5 x twice the rated "
            "%.3g A)",
            comment, 1.2 * 1.5 * 2.0 * current, current);
    if (link > 0.0) {
        fprintf(to, " and whose link trips at %.4g V", 1.286 * link);
    }
    fprintf(to, ".\n");
    for (size_t n = 0; board_facts[n] != NULL; n++) {
        const board_facts_t *board = board_facts[n];
        const bool enough = boards_current_suits(board, motor);
        const bool volts = boards_voltage_suits(board, motor);
        fprintf(to, "%s  %-14s +-%.3g A in steps of %.2g mA, %.4g V%s: %s%s%s\n", comment, board->name,
                board->current_range, 1e3 * board->current_per_code, board->overvoltage_max,
                strcmp(board->name, rig_board) == 0 ? " (this build)" : "", enough && volts ? "fits" : "",
                enough  ? ""
                : volts ? "too little current"
                        : "too little current, ",
                volts ? "" : "too little voltage");
    }
    const board_facts_t *proposed = boards_propose(motor);
    if (proposed != NULL && strcmp(proposed->name, rig_board) != 0) {
        fprintf(to, "%sProposed: --board %s\n", comment, proposed->name);
    }
}

/* ---- the scenario ---- */

/* Times of the scenario [s]. */
typedef struct {
    double running; /* the estimate has taken over */
    double top;     /* the speed has arrived */
    double load;    /* the load comes */
    double ramp;    /* duration of the rise of the load */
    double settled; /* the drive carries the load from here on */
    double end;
    double first_load, load_torque; /* [N m] */
    double rate;                    /* [rad/s^2] of the speed */
    double loop;                    /* [rad/s] bandwidth of the speed control */
} plan_t;

static plan_t make_plan(const motor_t *motor, const tune_t *tune)
{
    const double inertia = motor_inertia(motor);
    const double torque = motor_torque_constant(motor) * row_value(tune, "current_limit");
    const double natural = sqrt(motor->value[MOTOR_POLE_PAIRS] * torque / inertia);
    const double ramp = row_value(tune, "speed_ramp");
    const double able = 0.5 * torque / inertia;
    const double loop = row_value(tune, "pll_bandwidth") / 14.0;
    const double friction = motor->value[MOTOR_COULOMB] + motor->value[MOTOR_VISCOUS] * tune->speed_top;
    plan_t plan;
    plan.load_torque = fmax(0.0, tune->torque_top - friction);
    plan.first_load = 0.3 * plan.load_torque;
    /* catch, alignment, a ramp to at most 0.3 of overspeed_trip, hand-over */
    const double forced = fmax(0.3, 0.42 * tune->speed_top * inertia / (0.15 * torque));
    plan.running = ceil(10.0 * (0.1 + 16.0 / natural + forced + 1.2)) / 10.0;
    plan.loop = loop;
    plan.rate = ramp > 0.0 && ramp < able ? ramp : able;
    plan.top = ceil(10.0 * (plan.running + tune->speed_top / plan.rate + 12.0 / loop)) / 10.0;
    plan.load = plan.top + 0.3;
    plan.ramp = ceil(20.0 * tune_load_time(plan.load_torque, tune->speed_top, inertia, 14.0 * loop)) / 20.0;
    plan.settled = ceil(10.0 * (plan.load + plan.ramp + 15.0 / loop)) / 10.0;
    plan.end = plan.settled + 0.4;
    return plan;
}

static void write_motor(FILE *to, const motor_sheet_t *sheet, bool of_library)
{
    fprintf(to, "[motor]\n");
    if (of_library) {
        fprintf(to, "name = \"%s\"\n", sheet->name);
        return;
    }
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (sheet->has[n]) {
            fprintf(to, "%s = %.10g # [%s] %s\n", motor_key_name((motor_key_t)n), sheet->value[n],
                    strcmp(motor_key_unit((motor_key_t)n), UNITS_SPEED) == 0 ? "rad/s"
                                                                             : motor_key_unit((motor_key_t)n),
                    motor_key_text((motor_key_t)n));
        }
    }
}

static void write_expect(FILE *to, const char *name, const char *signal, const char *minus,
                         const char *statistic, double from, double to_time, double low, double high)
{
    fprintf(to, "\n[[expect]]\nname = \"%s\"\nsignal = \"%s\"\n", name, signal);
    if (minus != NULL) {
        fprintf(to, "minus = \"%s\"\n", minus);
    }
    fprintf(to, "statistic = \"%s\"\nfrom = %.6g\n", statistic, from);
    if (to_time > 0.0) {
        fprintf(to, "to = %.6g\n", to_time);
    }
    if (isfinite(low)) {
        fprintf(to, "at_least = %.4g\n", low);
    }
    if (isfinite(high)) {
        fprintf(to, "at_most = %.4g\n", high);
    }
}

/* The motor, and as comments the parameters that follow from it. */
static void write_rows(FILE *to, const motor_sheet_t *sheet, const tune_t *tune)
{
    motor_sheet_t library;
    scenario_error_t ignored;
    const bool of_library = motor_read_library(sheet->name, &library, &ignored) &&
                            memcmp(library.has, sheet->has, sizeof sheet->has) == 0 &&
                            memcmp(library.value, sheet->value, sizeof sheet->value) == 0;
    write_motor(to, sheet, of_library);
    fprintf(to, "\n# Parameters that follow from [motor]; a value that you set in [params] or [plant] "
                "has priority.\n");
    tune_print(to, tune, "# ");
    for (uint32_t n = 0; n < tune->warning_count; n++) {
        fprintf(to, "# WARNING %s\n", tune->warnings[n]);
    }
    if (tune->needs_encoder) { /* [motor] does not set this row */
        fprintf(to, "[params]\nposition_source = \"encoder\"\n");
    }
}

void tune_scenario(FILE *to, const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune)
{
    const plan_t plan = make_plan(motor, tune);
    fprintf(to,
            "# Written by `lagless tune`.\nschema = 1\n%stitle = \"%.80s: cold start %s encoder to %.0f "
            "r/min, load %.3g N m\"\n\n",
            boards_line(), sheet->name, tune->needs_encoder ? "with an" : "without", tune->speed_top / RPM,
            plan.load_torque);
    fprintf(
        to,
        "[run]\nduration = %.6g\nrecord = [\"manoeuvre\", \"true_omega_m\", \"omega_m_ref\", \"i_d\", "
        "\"i_q\", \"true_i_a\", \"theta_hat_err\", \"e_amplitude\", \"lock_losses\", \"fault_reason\"]\n\n",
        plan.end);
    write_rows(to, sheet, tune);
    fprintf(
        to,
        "\n[start]\nangle = 2 # [rad] unknown to the drive\n\n[requests]\nenable = \"on\"\nspeed_request = "
        "%.6g "
        "# [rad/s], %.0f r/min\n\n[plant]\nload_torque = %.6g # [N m] passive: it only brakes\n\n"
        "[[at]]\ntime = %.6g\nramp = %.6g\nplant.load_torque = %.6g # [N m]\n",
        tune->speed_top, tune->speed_top / RPM, plan.first_load, plan.load, plan.ramp, plan.load_torque);
    write_expect(to, "never lost", "lock_losses", NULL, "max", 0.0, 0.0, -(double)INFINITY, 0.0);
    fprintf(to,
            "\n[[expect]]\nname = \"%s is in control\"\nsignal = \"manoeuvre\"\nstatistic = \"last\"\n"
            "from = %.6g\nat_least = \"run\"\nat_most = \"run\"\n",
            tune->needs_encoder ? "the encoder" : "the estimate", plan.settled);
    write_expect(to, "top speed", "true_omega_m", NULL, "mean", plan.top, plan.load, 0.99 * tune->speed_top,
                 (double)INFINITY);
    write_expect(to, "speed under load", "true_omega_m", "omega_m_ref", "mean", plan.settled, 0.0,
                 -0.005 * tune->speed_top, 0.005 * tune->speed_top);
    write_expect(to, "angle under load", "theta_hat_err", NULL, "mean", plan.settled, 0.0, -ANGLE_MOST,
                 ANGLE_MOST);
    write_expect(to, "and its scatter", "theta_hat_err", NULL, "sd", plan.settled, 0.0, -(double)INFINITY,
                 SCATTER_MOST);
}

/* ---- its grid ---- */

/* Writes the change by half of the load to this one [N m] at this time [s]; the time from which on the drive
 * carries it. */
static double write_load(FILE *to, const plan_t *plan, double time, double load)
{
    const double ramp = 0.5 * plan->ramp;
    fprintf(to, "\n[[at]]\ntime = %.6g\nramp = %.6g\nplant.load_torque = %.6g # [N m]\n", time, ramp, load);
    return time + ramp + 15.0 / plan->loop;
}

static void write_point(FILE *to, double speed, double load, double from)
{
    char name[80];
    const double end = from + GRID_SECONDS;
    snprintf(name, sizeof name, "%.0f r/min, %.3g N m", speed / RPM, load);
    write_expect(to, name, "theta_hat_err", NULL, "mean", from, end, -ANGLE_MOST, ANGLE_MOST);
    write_expect(to, name, "theta_hat_err", NULL, "sd", from, end, -(double)INFINITY, SCATTER_MOST);
}

void tune_grid(FILE *to, const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune)
{
    const plan_t plan = make_plan(motor, tune);
    const double each = GRID_LOADS * (0.5 * plan.ramp + 15.0 / plan.loop + GRID_SECONDS);
    const double most =
        plan.top + 0.3 + GRID_SPEEDS * (each + 12.0 / plan.loop) + tune->speed_top / plan.rate;
    fprintf(to,
            "# Written by `lagless motors --check`.\nschema = 1\n%stitle = \"%.80s: speeds and loads\"\n\n"
            "[run]\nduration = %.6g\n\n",
            boards_line(), sheet->name, most);
    write_rows(to, sheet, tune);
    fprintf(to, "\n[start]\nangle = 2\n\n[requests]\nenable = \"on\"\nspeed_request = %.6g\n",
            tune->speed_top);
    double time = plan.top + 0.3;
    double before = tune->speed_top;
    for (size_t n = 0; n < GRID_SPEEDS; n++) {
        const double speed = grid_speeds[n] * tune->speed_top;
        if (n != 0 && speed < GRID_HANDOVER * tune->handover) {
            break;
        }
        if (n != 0) {
            fprintf(to, "\n[[at]]\ntime = %.6g\nrequests.speed_request = %.6g\n", time, speed);
            time += (before - speed) / plan.rate + 12.0 / plan.loop;
        }
        before = speed;
        for (size_t k = 0; k < GRID_LOADS; k++) {
            const size_t share =
                n % 2u == 0u ? k : GRID_LOADS - 1u - k; /* each speed begins with the load of the last */
            const double load = grid_loads[share] * plan.load_torque;
            time = k != 0 ? write_load(to, &plan, time, load) : time;
            write_point(to, speed, load, time);
            time += GRID_SECONDS;
        }
    }
    write_expect(to, "never lost", "lock_losses", NULL, "max", 0.0, 0.0, -(double)INFINITY, 0.0);
}
