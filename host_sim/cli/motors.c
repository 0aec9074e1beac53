/* `lagless motors` and `lagless tune`. */
#include <argp.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/streams.h"
#include "host_sim/lab/boards.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/motor.h"
#include "host_sim/lab/motor_trial.h"
#include "host_sim/lab/tune.h"

#define RPM (3.14159265358979323846 / 30.0)

/* `motor`: name of the motor, for errors that do not contain it. */
static int complain(const char *command, const char *motor, const scenario_error_t *error)
{
    char text[1200];
    if (error->file[0] != '\0') {
        streams_at(error->file, error->place.line, error->place.column, error->name);
        fprintf(stderr, "lagless %s: %s\n", command, scenario_error_text(error, text, sizeof text));
    } else {
        fprintf(stderr, "lagless %s: %s: %s: %s\n", command, motor, error->name, error->message);
    }
    return EXIT_USAGE;
}

/* ---- motors ---- */

typedef struct {
    const char *name;
    bool json, check, keys;
} motors_options_t;

static error_t parse_motors(int key, char *argument, struct argp_state *state)
{
    motors_options_t *options = state->input;
    switch (key) {
    case 'j':
        options->json = true;
        return 0;
    case 'c':
        options->check = true;
        return 0;
    case 'k':
        options->keys = true;
        return 0;
    case ARGP_KEY_ARG:
        if (options->name != NULL) {
            argp_error(state, "%s: a second motor; accepted: one", argument);
        }
        options->name = argument;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static double power(const motor_t *motor, const tune_t *tune)
{
    const double speed = motor->has[MOTOR_SPEED] ? motor->value[MOTOR_SPEED] : tune->speed_top;
    return motor->value[MOTOR_TORQUE] * speed;
}

static void print_json(const motor_sheet_t *sheet, const motor_t *motor, const char *separator)
{
    printf("%s\n  {\"name\": ", separator);
    json_text(stdout, sheet->name);
    printf(", \"title\": ");
    json_text(stdout, sheet->title);
    printf(", \"source\": ");
    json_text(stdout, sheet->source);
    static const struct {
        const char *key;
        motor_quantity_t quantity;
    } columns[] = {{"pole_pairs", MOTOR_POLE_PAIRS},       {"resistance_ohm", MOTOR_RESISTANCE},
                   {"inductance_d_h", MOTOR_INDUCTANCE_D}, {"inductance_q_h", MOTOR_INDUCTANCE_Q},
                   {"flux_linkage_wb", MOTOR_FLUX},        {"rated_current_peak_a", MOTOR_CURRENT},
                   {"rated_speed_rad_s", MOTOR_SPEED},     {"rated_torque_nm", MOTOR_TORQUE},
                   {"link_voltage_v", MOTOR_LINK},         {"inertia_kg_m2", MOTOR_INERTIA}};
    for (size_t n = 0; n < sizeof columns / sizeof columns[0]; n++) {
        const motor_quantity_t quantity = columns[n].quantity;
        const bool known = motor->has[quantity] || quantity == MOTOR_TORQUE;
        printf(", \"%s\": ", columns[n].key);
        json_number(stdout, known ? motor->value[quantity] : (double)NAN);
    }
    printf("}");
}

static void print_line(const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune)
{
    printf("%-22s %5.0f W %2.0f %8.4g ohm %7.4g mH %7.4g mWb %6.3g A %7.3g kg cm^2  %s\n", sheet->name,
           power(motor, tune), motor->value[MOTOR_POLE_PAIRS], motor->value[MOTOR_RESISTANCE],
           1e3 * motor->value[MOTOR_INDUCTANCE_Q], 1e3 * motor->value[MOTOR_FLUX],
           motor->value[MOTOR_CURRENT], 1e4 * motor->value[MOTOR_INERTIA], sheet->title);
}

static void print_sheet(const motor_sheet_t *sheet, const motor_t *motor)
{
    printf("%s: %s\n", sheet->name, sheet->title);
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        char value[UNITS_TEXT_SIZE];
        if (sheet->has[n]) {
            printf("  %-22s %-18s %s\n", motor_key_name((motor_key_t)n),
                   units_text(value, sheet->value[n], motor_key_unit((motor_key_t)n)),
                   motor_key_text((motor_key_t)n));
        }
    }
    printf("  psi_f %.4g mWb, K_t %.4g N m/A of the peak, rated torque %.4g N m\n",
           1e3 * motor->value[MOTOR_FLUX], motor_torque_constant(motor), motor->value[MOTOR_TORQUE]);
    printf("  source: %s\n", sheet->source);
}

/* One line of the table of docs/motors.md. */
static void print_trial(const motor_sheet_t *sheet, const motor_trial_t *trial)
{
    const double rated =
        trial->motor.has[MOTOR_SPEED] ? trial->motor.value[MOTOR_SPEED] : trial->tune.speed_top;
    printf("| %s | %.0f W | %.4g V | %.0f of %.0f r/min | %.3g of %.3g N m | %.1f %% | %.0f | %.0f | %.0f | "
           "%.0f at %s | %s |\n",
           sheet->name, power(&trial->motor, &trial->tune), trial->tune.link, trial->tune.speed_top / RPM,
           rated / RPM, trial->load, trial->motor.value[MOTOR_TORQUE], 100.0 * trial->speed_error,
           1e3 * trial->angle_mean, 1e3 * trial->angle_sd, 1e3 * trial->grid_mean, 1e3 * trial->grid_sd,
           trial->grid_at[0] != '\0' ? trial->grid_at : "-",
           trial->met ? (trial->tune.needs_encoder ? "runs, with an encoder" : "runs") : trial->miss);
}

/* The start and the grid of a motor. */
static bool try_motor(const motor_sheet_t *sheet, motor_trial_t *trial, scenario_error_t *error)
{
    return motor_trial(sheet, trial, error) && motor_trial_grid(sheet, trial, error);
}

/* Each motor, one after the other: by its line, or its trial. */
static int walk(const motors_options_t *options)
{
    static motor_trial_t trial;
    int exit_code = EXIT_DONE;
    char **names = NULL;
    const int count = motor_library(&names);
    if (count < 0) {
        fprintf(stderr, "lagless motors: cannot read the folder %s; LAGLESS_MOTORS may name another one\n",
                motor_library_folder());
        return EXIT_INTERNAL;
    }
    if (options->check) {
        printf(
            "| motor | rated | link | top speed | load | speed error | angle, mrad | its SD | grid: angle | "
            "its SD | |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
    }
    printf(options->json ? "{\"motors\": [" : "");
    for (int n = 0; n < count; n++) {
        motor_sheet_t sheet;
        scenario_error_t error;
        bool good = motor_read_library(names[n], &sheet, &error);
        if (good && options->check) {
            good = try_motor(&sheet, &trial, &error);
        } else if (good) {
            good = motor_make(&sheet, &trial.motor, &error) && tune_motor(&trial.motor, &trial.tune, &error);
        }
        if (!good) {
            exit_code = complain("motors", names[n], &error);
        } else if (options->check) {
            print_trial(&sheet, &trial);
            exit_code = trial.met || exit_code != EXIT_DONE ? exit_code : EXIT_FAILED;
        } else if (options->json) {
            print_json(&sheet, &trial.motor, n == 0 ? "" : ",");
        } else {
            print_line(&sheet, &trial.motor, &trial.tune);
        }
        free(names[n]);
    }
    free(names);
    printf(options->json ? "\n]}\n" : "");
    return exit_code;
}

static void print_keys(void)
{
    printf("| key | unit | what it is |\n| --- | --- | --- |\n");
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        const char *unit = motor_key_unit((motor_key_t)n);
        printf("| `%s` | %s | %s |\n", motor_key_name((motor_key_t)n),
               strcmp(unit, UNITS_SPEED) == 0 ? "r/min, rad/s" : unit, motor_key_text((motor_key_t)n));
    }
}

int command_motors(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {"check", 'c', NULL, 0,
         "run each motor with the parameters of `lagless tune`: cold start to the top speed, then "
         "load; and a grid of speeds and loads",
         0},
        ARGUMENTS_BOARD,
        {"keys", 'k', NULL, 0, "list the keys of a motor's file, as Markdown", 0},
        {0}};
    static const struct argp argp = {
        rows,     parse_motors,
        "[NAME]", "Lists the motors that come with the program, or shows one of them with its source.",
        NULL,     NULL,
        NULL};
    motors_options_t options = {.name = NULL};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (options.keys) {
        print_keys();
        return EXIT_DONE;
    }
    if (options.name == NULL) {
        return walk(&options);
    }
    static motor_trial_t trial;
    motor_sheet_t sheet;
    scenario_error_t error;
    if (!motor_read(options.name, &sheet, &error) || !motor_make(&sheet, &trial.motor, &error) ||
        (options.check && !try_motor(&sheet, &trial, &error))) {
        return complain("motors", options.name, &error);
    }
    if (options.check) {
        print_trial(&sheet, &trial);
        return trial.met ? EXIT_DONE : EXIT_FAILED;
    }
    if (options.json) {
        print_json(&sheet, &trial.motor, "");
        printf("\n");
    } else {
        print_sheet(&sheet, &trial.motor);
    }
    return EXIT_DONE;
}

/* ---- tune ---- */

typedef struct {
    const char *motor, *file;
    const char *sets[ARGUMENTS_SETS];
    size_t set_count;
    bool json;
} tune_options_t;

static error_t parse_tune(int key, char *argument, struct argp_state *state)
{
    tune_options_t *options = state->input;
    switch (key) {
    case 'j':
        options->json = true;
        return 0;
    case 'w':
        options->file = argument;
        return 0;
    case ARGUMENTS_FORCE_KEY:
        return arguments_force(key);
    case 's':
        if (options->set_count == ARGUMENTS_SETS) {
            argp_error(state,
                       "--set %s: more than %u of them; accepted: at most that many, write the others into "
                       "the motor's file",
                       argument, ARGUMENTS_SETS);
        }
        options->sets[options->set_count++] = argument;
        return 0;
    case ARGP_KEY_ARG:
        if (options->motor != NULL) {
            argp_error(state, "%s: a second motor; accepted: one", argument);
        }
        options->motor = argument;
        return 0;
    case ARGP_KEY_END:
        if (options->motor == NULL) {
            argp_error(
                state,
                "no motor is given; accepted: a name of `lagless motors`, or a file such as MOTOR.toml");
        }
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void print_tune_json(const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune)
{
    const board_facts_t *proposed = boards_propose(motor);
    printf("{\"motor\": ");
    json_text(stdout, sheet->name);
    printf(", \"link_v\": %.9g, \"top_speed_rad_s\": %.9g, \"torque_nm\": %.9g, \"handover_rad_s\": %.9g, "
           "\"response_s\": %.9g, \"board\": ",
           tune->link, tune->speed_top, tune->torque_top, tune->handover, tune->response);
    json_text(stdout, proposed != NULL ? proposed->name : rig_board);
    printf(", \"rows\": [");
    for (uint32_t n = 0; n < tune->count; n++) {
        const table_row_t *row = tune->rows[n].row;
        printf("%s\n  {\"id\": %lu, \"table\": \"%s\", \"name\": \"%s\", \"unit\": \"%s\", \"value\": ",
               n == 0u ? "" : ",", (unsigned long)row->id, scenario_is_param(row) ? "params" : "plant",
               row->name, row->unit);
        json_number(stdout, tune->rows[n].value);
        printf(", \"reason\": ");
        json_text(stdout, tune->rows[n].reason);
        printf("}");
    }
    printf("\n], \"warnings\": [");
    for (uint32_t n = 0; n < tune->warning_count; n++) {
        printf("%s", n == 0u ? "" : ", ");
        json_text(stdout, tune->warnings[n]);
    }
    printf("]}\n");
}

static void print_warnings(const tune_t *tune, FILE *to)
{
    for (uint32_t n = 0; n < tune->warning_count; n++) {
        fprintf(to, "warning: %s\n", tune->warnings[n]);
    }
}

int command_tune(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"set", 's', "KEY=VALUE", 0, "set a key of the motor, \"load_inertia=2 kg cm^2\"; repeatable", 0},
        {"write", 'w', "FILE", 0, "write a scenario: cold start to the top speed, then load", 0},
        ARGUMENTS_BOARD,
        ARGUMENTS_FORCE,
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {0}};
    static const struct argp argp = {
        rows,
        parse_tune,
        "MOTOR",
        "Computes the parameters (params, plant) that a motor of the library or of a file needs, and prints "
        "them as TOML, each with its rule. Warnings of the motor's limits go to stderr.",
        NULL,
        NULL,
        NULL};
    static tune_t tune;
    tune_options_t options = {.motor = NULL};
    motor_sheet_t sheet;
    motor_t motor;
    scenario_error_t error;
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    bool good = motor_read(options.motor, &sheet, &error);
    scenario_error_t ignored;
    scenario_t *scenario = good ? NULL : scenario_read(options.motor, &ignored);
    if (scenario != NULL) {
        scenario_free(scenario);
        fprintf(stderr, "lagless tune: %s is a scenario without [motor]: `lagless run %s` runs it\n",
                options.motor, options.motor);
        return EXIT_USAGE;
    }
    for (size_t n = 0; good && n < options.set_count; n++) {
        good = motor_override(&sheet, options.sets[n], &error);
    }
    if (!good || !motor_make(&sheet, &motor, &error)) {
        return complain("tune", options.motor, &error);
    }
    if (options.file != NULL && !output_allowed(options.file)) {
        return EXIT_USAGE;
    }
    good = tune_motor(&motor, &tune, &error);
    if (!good) {
        print_warnings(&tune, stderr);
        return complain("tune", options.motor, &error);
    }
    if (options.json) {
        print_tune_json(&sheet, &motor, &tune);
    } else {
        tune_boards(stdout, &motor, "# ");
        tune_print(stdout, &tune, "");
        print_warnings(&tune, stderr);
    }
    if (options.file != NULL) {
        FILE *file = output_open(options.file);
        if (file == NULL) {
            return EXIT_INTERNAL;
        }
        tune_scenario(file, &sheet, &motor, &tune);
        if (!output_close(file, options.file)) {
            return EXIT_INTERNAL;
        }
        fprintf(stderr, "the scenario is in %s; `lagless run %s` runs it\n", options.file, options.file);
    }
    return EXIT_DONE;
}
