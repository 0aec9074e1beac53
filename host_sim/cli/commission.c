/* `lagless commission SCENARIO|TARGET`. */
#include <argp.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/commission_page.h"
#include "host_sim/cli/commission_talk.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/plot.h"
#include "host_sim/lab/commission.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/line/master.h"
#include "host_sim/scope/commission_line.h"

#define SAVE_KEY 300

typedef struct {
    arguments_scenario_t of;
    const char *plate, *steps, *file;
    const char *plot;   /* formats of the pictures; NULL: none */
    const char *folder; /* of the pictures; NULL: a new one */
    uint32_t key;       /* of the line; 0: none */
    bool json, yes, resume, save;
    commission_answers_t answers;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'p':
        options->plate = argument;
        return 0;
    case 't':
        options->steps = argument;
        return 0;
    case 'w':
        options->file = argument;
        return 0;
    case 'a':
        if (!commission_talk_answer(&options->answers, argument)) {
            argp_error(
                state,
                "--answer %s: accepted: shaft_free=yes, shaft_free=no, link=VOLT (for example link=311), "
                "direction=as_said, direction=reversed, turn=one, turn=NUMBER (turns of the shaft)",
                argument);
        }
        return 0;
    case 'K':
        options->key = arguments_key(argument, state);
        return 0;
    case 'r':
        options->resume = true;
        return 0;
    case SAVE_KEY:
        options->save = true;
        return 0;
    case 'P':
        options->plot = argument != NULL ? argument : "html";
        return 0;
    case 'o':
        options->folder = argument;
        return 0;
    case 'y':
        options->yes = true;
        return 0;
    case 'j':
        options->json = true;
        return 0;
    case ARGUMENTS_FORCE_KEY:
        return arguments_force(key);
    default:
        return arguments_scenario(key, argument, state, &options->of);
    }
}

/* ---- the requested procedure ---- */

/* Values of the plate's file that replace the parameters of the drive. */
static bool read_plate(const char *path, commission_plate_t *plate, commission_sheet_t *of)
{
    motor_sheet_t sheet;
    scenario_error_t error;
    if (!motor_read_file(path, &sheet, &error)) {
        library_say("commission", &error);
        return false;
    }
    *plate = (commission_plate_t){
        .pole_pairs = motor_given(&sheet, MOTOR_POLE_PAIRS),
        .current = motor_given(&sheet, MOTOR_CURRENT),
        .speed = motor_given(&sheet, MOTOR_SPEED),
    };
    *of = (commission_sheet_t){
        .resistance = motor_given(&sheet, MOTOR_RESISTANCE),
        .inductance_d = motor_given(&sheet, MOTOR_INDUCTANCE_D),
        .inductance_q = motor_given(&sheet, MOTOR_INDUCTANCE_Q),
        .flux_linkage = motor_given(&sheet, MOTOR_FLUX),
        .inertia = motor_given(&sheet, MOTOR_INERTIA),
    };
    const char *missing = !isfinite(plate->pole_pairs) ? "pole_pairs or poles"
                          : !isfinite(plate->current)  ? "rated_current_peak, _rms or _block"
                          : !isfinite(plate->speed)    ? "rated_speed"
                                                       : NULL;
    if (missing != NULL) {
        fprintf(stderr, "lagless commission: --plate %s: %s is missing\n", path, missing);
    }
    return missing == NULL;
}

/* ---- the run ---- */

/* A rig as the scenario describes it at t = 0. NULL: the reason has been printed. */
static rig_t *make_rig(const options_t *options, const scenario_t *scenario)
{
    uint64_t seed = scenario->seed;
    if (options->of.seed != NULL && !arguments_whole(options->of.seed, 0u, UINT64_MAX / 2u, &seed)) {
        fprintf(stderr, "lagless commission: --seed %s: accepted: whole numbers 0 to %" PRIu64 "\n",
                options->of.seed, UINT64_MAX / 2u);
        return NULL;
    }
    scenario_error_t error = {.file = ""};
    rig_t *rig = commission_rig_of(scenario, seed, &error);
    if (rig == NULL) {
        fprintf(stderr, "lagless commission: %s: %s\n", scenario->path, error.message);
    }
    return rig;
}

static bool write_motor(const char *path, const char *scenario, const commission_plate_t *plate,
                        const commission_result_t *result)
{
    char title[200];
    snprintf(title, sizeof title, "Measured on %.150s", scenario);
    for (char *at = title; *at != '\0'; at++) {
        *at = *at == '"' || *at == '\\' ? '/' : *at;
    }
    FILE *file = output_open(path);
    if (file == NULL) {
        return false;
    }
    commission_write(file, plate, result, title);
    return output_close(file, path);
}

/* Runs the steps on a simulated drive or on one at a serial link. */
typedef struct {
    rig_t *rig;
    commission_line_t line;
    commission_rig_room_t room;
    commission_drive_t drive;
} machine_t;

static bool is_target(const char *name)
{
    return strncmp(name, "tcp://", 6u) == 0 || strncmp(name, "/dev/", 5u) == 0;
}

/* The drive of the command line. false: the reason has been printed. */
static int open_machine(machine_t *machine, const options_t *options, const scenario_t *scenario)
{
    if (scenario != NULL) {
        machine->rig = make_rig(options, scenario);
        if (machine->rig == NULL) {
            return EXIT_USAGE;
        }
        machine->drive = commission_rig_drive(&machine->room, machine->rig);
        return EXIT_DONE;
    }
    master_error_t error;
    machine->line.master = master_open(options->of.scenario, &error);
    if (machine->line.master == NULL ||
        (options->key != 0u && !master_unlock(machine->line.master, options->key, &error))) {
        fprintf(stderr, "lagless commission: %s\n", error.text);
        return EXIT_INTERNAL;
    }
    machine->drive = commission_line_drive(&machine->line);
    return EXIT_DONE;
}

static void close_machine(machine_t *machine)
{
    if (machine->rig != NULL) {
        commission_rig_leave(&machine->room);
    }
    rig_free(machine->rig);
    master_close(machine->line.master);
}

/* Orders a drive on a serial link to save its parameters in its flash. */
static bool save(machine_t *machine)
{
    master_refusal_t refusal = {0};
    master_error_t error = {{0}};
    const bool good = master_order(machine->line.master, "save", &refusal, &error);
    if (!good) {
        fprintf(stderr, "lagless commission: --save: %s\n", error.text);
    }
    return good;
}

static void print_end(const options_t *options, const commission_result_t *result,
                      const commission_sheet_t *sheet)
{
    if (options->json) {
        commission_print_json(stdout, result);
        return;
    }
    commission_print_sheet(result, sheet);
    if (result->reason[0] != '\0' && result->seconds == 0.0) { /* no step has printed it */
        printf("%s\n", result->what);
    }
    printf("%s after %.1f s; largest current %.3g A\n",
           result->reason[0] != '\0' ? result->reason : "commissioned", result->seconds,
           result->largest_current);
}

static int run(options_t *options, const scenario_t *scenario, machine_t *machine)
{
    const bool terminal = !options->yes && isatty(STDIN_FILENO) && isatty(STDERR_FILENO);
    commission_talk_t talk = {.quiet = options->json,
                              .terminal = terminal,
                              .sees_shaft = scenario == NULL,
                              .answers = options->answers};
    commission_options_t steps = {.resume = options->resume, .plant_answers = true};
    commission_result_t result;
    commission_sheet_t sheet = {(double)NAN, (double)NAN, (double)NAN, (double)NAN, (double)NAN};
    scenario_error_t error = {.file = ""};
    char why[256];
    if (options->steps != NULL && !commission_choose(&steps, options->steps, why, sizeof why)) {
        fprintf(stderr, "lagless commission: --steps: %s\n", why);
        return EXIT_USAGE;
    }
    commission_plate_t plate = commission_plate_by(&machine->drive);
    if (options->plate != NULL && !read_plate(options->plate, &plate, &sheet)) {
        return EXIT_USAGE;
    }
    if (options->file != NULL && !output_allowed(options->file)) { /* the plate is an input, too */
        return EXIT_USAGE;
    }
    commission_talk_begin(&talk, &steps);
    const bool good = commission_drive(&machine->drive, &plate, &steps, &result, &error);
    commission_talk_end(&talk);
    if (!good) {
        fprintf(stderr, "lagless commission: %s: %s\n", error.name, error.message);
        return EXIT_USAGE;
    }
    print_end(options, &result, &sheet);
    const commission_page_t page = {scenario != NULL ? scenario->title : options->of.scenario, &plate, &sheet,
                                    &result};
    const int drawn =
        options->plot != NULL ? commission_page_draw(&page, options->folder, options->plot) : EXIT_DONE;
    const bool failed = result.reason[0] != '\0';
    if (options->file != NULL &&
        !write_motor(options->file, scenario != NULL ? scenario->path : options->of.scenario, &plate,
                     &result)) {
        return EXIT_INTERNAL;
    }
    if (options->file != NULL) {
        fprintf(stderr, "the measured motor is in %s\n", options->file);
    }
    if (options->file != NULL && !commission_known(&result)) {
        fprintf(stderr,
                "lagless commission: --write %s: R, L and psi_f are not all measured; complete the file from "
                "the data sheet, or repeat the missing steps\n",
                options->file);
        return EXIT_FAILED;
    }
    if (options->save && !failed && !save(machine)) {
        return EXIT_INTERNAL;
    }
    return failed ? EXIT_FAILED : drawn;
}

int command_commission(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        ARGUMENTS_SCENARIO,
        ARGUMENTS_BOARD,
        {"plate", 'p', "FILE", 0,
         "pole pairs, rated current and rated speed of the motor, with the keys of a motor's file; without "
         "it those of the scenario's parameters",
         0},
        {"steps", 't', "NAMES", 0,
         "only these steps, and those whose results they need: board, wiring, resistance, inductance, "
         "current_loop, turn, swing, flux, inertia, least_speed, separated by commas; and angle, for a shaft "
         "that is held",
         0},
        {"answer", 'a', "NAME=VALUE", 0,
         "answer to a question: shaft_free=yes or shaft_free=no (the rotor is not turned); link=VOLT, the DC "
         "link by a meter; direction=as_said or direction=reversed, turn=one or turn=NUMBER, what the shaft "
         "did "
         "in the step turn",
         0},
        {"yes", 'y', NULL, 0,
         "ask no questions on the terminal: the shaft is free, the simulated motor answers", 0},
        {"resume", 'r', NULL, 0, "take what the drive has measured since its start, and run the other steps",
         0},
        {"save", SAVE_KEY, NULL, 0, "save the resulting parameters in the flash of a drive on a serial link",
         0},
        ARGUMENTS_KEY,
        {"plot", 'P', "FORMATS", OPTION_ARG_OPTIONAL,
         "draw the measured points: html (default, a page with all values), png, svg, separated by commas; "
         "without --out into a new folder below runs",
         0},
        {"out", 'o', "FOLDER", 0, "folder of the pictures of --plot", 0},
        {"write", 'w', "FILE", 0, "write the measured motor, for [motor] and for `lagless tune`", 0},
        ARGUMENTS_FORCE,
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {0}};
    static const struct argp argp = {
        rows,
        parse,
        "SCENARIO|TARGET",
        "Measures the data of an unknown motor by the drive itself, step by step, from standstill to the "
        "torque "
        "test: that of a simulated drive, of whose motor only the plate is used, or of a drive on a serial "
        "link "
        "(tcp://127.0.0.1:5555, /dev/ttyUSB0, /dev/ttyUSB0:115200).",
        NULL,
        NULL,
        NULL};
    options_t options = {.answers = {true, 0.0, {(double)NAN, (double)NAN}}};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if ((options.file != NULL && !output_allowed(options.file)) ||
        (options.plot != NULL && !plot_formats("commission", options.plot))) {
        return EXIT_USAGE;
    }
    if (options.folder != NULL && options.plot == NULL) {
        fprintf(stderr, "lagless commission: --out: the folder of the pictures: accepted with --plot\n");
        return EXIT_USAGE;
    }
    const bool target = is_target(options.of.scenario);
    if (target ? options.of.set_count > 0u || options.of.seed != NULL : options.save || options.resume) {
        fprintf(stderr, "lagless commission: %s\n",
                target ? "--set and --seed: accepted with a scenario, not with a drive on a serial link"
                       : "--save and --resume: accepted with a drive on a serial link, not with a scenario");
        return EXIT_USAGE;
    }
    scenario_t *scenario = target ? NULL : library_read("commission", &options.of);
    if (!target && scenario == NULL) {
        return EXIT_USAGE;
    }
    if (options.plot != NULL && !commission_page_folder(&options.folder, options.plot)) {
        scenario_free(scenario);
        return EXIT_USAGE;
    }
    machine_t machine = {.rig = NULL};
    int exit_code = open_machine(&machine, &options, scenario);
    if (exit_code == EXIT_DONE) {
        exit_code = run(&options, scenario, &machine);
    }
    close_machine(&machine);
    scenario_free(scenario);
    return exit_code;
}
