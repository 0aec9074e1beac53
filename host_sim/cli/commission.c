/* `lagless commission SCENARIO`. */
#include <argp.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <termios.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/commission.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/scenario.h"

#define RPM (3.14159265358979323846 / 30.0)

typedef struct {
    arguments_scenario_t of;
    const char *plate, *steps, *file;
    bool json, yes;
    bool turns;  /* the answer to shaft_free */
    double link; /* the answer to link [V]; 0: none */
} options_t;

/* A voltage above zero. */
static bool link_of(const char *text, double *link)
{
    char *end = NULL;
    *link = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*link) && *link > 0.0;
}

/* --answer NAME=VALUE. */
static void answer(options_t *options, const char *text, struct argp_state *state)
{
    if (strcmp(text, "shaft_free=yes") == 0) {
        options->turns = true;
    } else if (strcmp(text, "shaft_free=no") == 0) {
        options->turns = false;
    } else if (strncmp(text, "link=", 5u) == 0 && link_of(text + 5, &options->link)) {
        return;
    } else {
        argp_error(state,
                   "--answer %s: accepted shaft_free=yes, shaft_free=no and link=VOLT, for example link=311",
                   text);
    }
}

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
        answer(options, argument, state);
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

/* ---- what is asked for ---- */

/* --steps a,b: the others are not requested. */
static bool choose_steps(const char *text, commission_options_t *options)
{
    char copy[256];
    for (uint32_t n = 0; n < COMMISSION_STEP_COUNT; n++) {
        options->skip[n] = text != NULL;
    }
    if (text == NULL) {
        return true;
    }
    snprintf(copy, sizeof copy, "%s", text);
    bool any = false;
    for (char *word = strtok(copy, ","); word != NULL; word = strtok(NULL, ",")) {
        uint32_t n = 0;
        while (n < COMMISSION_STEP_COUNT && strcmp(word, commission_step_name((commission_do_t)n)) != 0) {
            n++;
        }
        if (n == COMMISSION_STEP_COUNT) {
            fprintf(stderr, "lagless commission: --steps %s: accepted", word);
            for (n = 0; n < COMMISSION_STEP_COUNT; n++) {
                fprintf(stderr, "%s %s", n > 0u ? "," : "", commission_step_name((commission_do_t)n));
            }
            fprintf(stderr, ", separated by commas\n");
            return false;
        }
        options->skip[n] = false;
        any = true;
    }
    if (!any) {
        fprintf(stderr, "lagless commission: --steps: no name is given; accepted names of steps, separated "
                        "by commas\n");
    }
    return any;
}

/* What the file of a plate gives in place of the drive's parameters. */
static bool read_plate(const char *path, commission_plate_t *plate)
{
    motor_sheet_t sheet;
    scenario_error_t error;
    if (!motor_read_file(path, &sheet, &error)) {
        library_say(&error);
        return false;
    }
    *plate = (commission_plate_t){
        .pole_pairs = motor_given(&sheet, MOTOR_POLE_PAIRS),
        .current = motor_given(&sheet, MOTOR_CURRENT),
        .speed = motor_given(&sheet, MOTOR_SPEED),
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

/* The turning steps need a free shaft, and every value the true link. On a terminal the user is asked; the
 * simulated shaft is free, and its link is as measured. */
static void ask(options_t *options, commission_options_t *steps)
{
    char line[32] = "y";
    const bool terminal = !options->yes && isatty(STDIN_FILENO) && isatty(STDERR_FILENO);
    if (terminal && options->link == 0.0) {
        fprintf(stderr, "Voltage of the DC link by a meter, in V? [empty: not measured] ");
        if (fgets(line, sizeof line, stdin) != NULL) {
            line[strcspn(line, "\n")] = '\0';
            (void)link_of(line, &options->link);
        }
    }
    steps->link = options->link;
    if (options->turns && terminal) {
        fprintf(stderr, "Is the shaft free, uncoupled and out of reach of persons? It will turn. [y/n] ");
        if (fgets(line, sizeof line, stdin) == NULL || (line[0] != 'y' && line[0] != 'Y')) {
            options->turns = false;
        }
    }
    if (!options->turns) {
        for (uint32_t n = COMMISSION_DO_swing; n < COMMISSION_STEP_COUNT; n++) {
            steps->skip[n] = true;
        }
    }
}

/* ---- what is said ---- */

/* A terminal that gives each key at once, without showing it. */
typedef struct {
    struct termios before;
    bool on;
} keys_t;

typedef struct {
    bool quiet;
    keys_t keys;
} listener_t;

static void show(const char *name, commission_value_t value, double factor, const char *unit)
{
    if (isfinite(value.value)) {
        printf("  %-10s %10.4g +- %.2g %s\n", name, factor * value.value, factor * value.error, unit);
    }
}

static void progress(void *context, commission_do_t step, bool done, const commission_result_t *result)
{
    const listener_t *listener = context;
    if (listener->quiet) {
        return;
    }
    if (!done) {
        printf("%s: %s\n", commission_step_name(step), commission_step_text(step));
        fflush(stdout);
        return;
    }
    if (result->reason[0] != '\0') {
        printf("  ended by %s after %.1f s: %s\n", result->reason, result->seconds, result->what);
        return;
    }
    switch (step) {
    case COMMISSION_DO_board:
    case COMMISSION_DO_wiring:
        printf("  good\n");
        break;
    case COMMISSION_DO_resistance:
        show("R", result->resistance, 1.0, "ohm");
        show("V_dead", result->dead_voltage, 1.0, "V");
        show("zone", result->current_zone, 1e3, "mA");
        break;
    case COMMISSION_DO_inductance:
        show("L_d", result->inductance_d, 1e3, "mH");
        show("L_q", result->inductance_q, 1e3, "mH");
        if (result->saturation_current.value > 0.0) {
            show("I_s", result->saturation_current, 1.0, "A");
        } else {
            printf("  %s\n", result->saturation_current.value == 0.0 ? "L_q does not depend on the current"
                                                                     : "saturation not measured");
        }
        break;
    case COMMISSION_DO_swing:
        printf("  first values: psi_f %.3g Wb, J %.3g kg m^2\n", result->flux_first, result->inertia_first);
        break;
    case COMMISSION_DO_flux:
        show("psi_f", result->flux_linkage, 1e3, "mWb");
        break;
    case COMMISSION_DO_inertia:
        show("J", result->inertia, 1e3, "g m^2");
        show("T_c", result->friction_coulomb, 1e3, "mN m");
        show("B", result->friction_viscous, 1e6, "uN m s/rad");
        break;
    case COMMISSION_STEP_COUNT:
        break;
    }
}

static void print_json(const commission_result_t *result)
{
    const struct {
        const char *name;
        double value;
    } rows[] = {
        {"resistance", result->resistance.value},
        {"inductance_d", result->inductance_d.value},
        {"inductance_q", result->inductance_q.value},
        {"saturation_current", result->saturation_current.value},
        {"flux_linkage", result->flux_linkage.value},
        {"inertia", result->inertia.value},
        {"friction_coulomb", result->friction_coulomb.value},
        {"friction_viscous", result->friction_viscous.value},
        {"dead_voltage", result->dead_voltage.value},
        {"current_zone", result->current_zone.value},
    };
    printf("{");
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        printf("\"%s\": ", rows[n].name);
        json_number(stdout, rows[n].value);
        printf(", ");
    }
    printf("\"reason\": ");
    json_text(stdout, result->reason[0] != '\0' ? result->reason : NULL);
    printf(", \"seconds\": ");
    json_number(stdout, result->seconds);
    printf(", \"largest_current\": ");
    json_number(stdout, result->largest_current);
    printf("}\n");
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

/* ---- Esc ---- */

#define ESCAPE 0x1b

static volatile sig_atomic_t interrupted; /* Ctrl-C: as Esc, so that the terminal is as before */

static void interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

static keys_t keys_begin(void)
{
    keys_t keys = {.on = isatty(STDIN_FILENO) && tcgetattr(STDIN_FILENO, &keys.before) == 0};
    if (keys.on) {
        struct termios now = keys.before;
        now.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
        keys.on = signal(SIGINT, interrupt) != SIG_ERR && tcsetattr(STDIN_FILENO, TCSANOW, &now) == 0;
    }
    return keys;
}

static void keys_end(const keys_t *keys)
{
    if (keys->on) {
        (void)tcsetattr(STDIN_FILENO, TCSANOW, &keys->before);
    }
}

static bool no_escape(void *context, commission_do_t step)
{
    const listener_t *listener = context;
    (void)step;
    fd_set input;
    struct timeval now = {0, 0};
    char key = '\0';
    FD_ZERO(&input);
    FD_SET(STDIN_FILENO, &input);
    if (interrupted != 0) {
        return false;
    }
    if (!listener->keys.on || select(STDIN_FILENO + 1, &input, NULL, NULL, &now) != 1) {
        return true;
    }
    return read(STDIN_FILENO, &key, 1u) != 1 || key != ESCAPE;
}

/* ---- the run ---- */

/* A rig as the scenario describes it at t = 0. NULL: the reason has been printed. */
static rig_t *make_rig(const options_t *options, const scenario_t *scenario)
{
    uint64_t seed = scenario->seed;
    if (options->of.seed != NULL && !arguments_whole(options->of.seed, 0u, UINT64_MAX / 2u, &seed)) {
        fprintf(stderr, "lagless commission: --seed %s: accepted whole numbers 0 to %" PRIu64 "\n",
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

static int run(options_t *options, const scenario_t *scenario)
{
    listener_t listener = {.quiet = options->json};
    commission_options_t steps = {.progress = progress, .goes_on = no_escape, .context = &listener};
    commission_result_t result;
    scenario_error_t error = {.file = ""};
    if (!choose_steps(options->steps, &steps)) {
        return EXIT_USAGE;
    }
    if (options->file != NULL && !output_allowed(options->file)) {
        return EXIT_USAGE;
    }
    rig_t *rig = make_rig(options, scenario);
    if (rig == NULL) {
        return EXIT_USAGE;
    }
    commission_plate_t plate = commission_plate_of(rig);
    if (options->plate != NULL && !read_plate(options->plate, &plate)) {
        rig_free(rig);
        return EXIT_USAGE;
    }
    if (options->file != NULL && !output_allowed(options->file)) { /* the plate is an input, too */
        rig_free(rig);
        return EXIT_USAGE;
    }
    ask(options, &steps);
    listener.keys = keys_begin();
    if (listener.keys.on && !listener.quiet) {
        fprintf(stderr, "Esc opens the bridge.\n");
    }
    const bool good = commission_rig(rig, &plate, &steps, &result, &error);
    keys_end(&listener.keys);
    rig_free(rig);
    if (!good) {
        fprintf(stderr, "lagless commission: %s: %s\n", error.name, error.message);
        return EXIT_USAGE;
    }
    if (options->json) {
        print_json(&result);
    } else {
        printf("%s, %.1f s, largest current %.3g A\n",
               result.reason[0] != '\0' ? result.reason : "commissioned", result.seconds,
               result.largest_current);
    }
    const bool known = isfinite(result.resistance.value) && isfinite(result.inductance_q.value) &&
                       isfinite(result.flux_linkage.value);
    if (options->file != NULL && !known) {
        fprintf(stderr,
                "lagless commission: --write %s: not written, because R, L and psi_f are not all "
                "measured\n",
                options->file);
        return EXIT_FAILED;
    }
    if (options->file != NULL && !write_motor(options->file, scenario->path, &plate, &result)) {
        return EXIT_INTERNAL;
    }
    return result.reason[0] != '\0' ? EXIT_FAILED : EXIT_DONE;
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
         "only these steps, and those whose results they need: board, wiring, resistance, inductance, swing, "
         "flux, inertia, separated by commas",
         0},
        {"answer", 'a', "NAME=VALUE", 0,
         "answer to a question: shaft_free=yes or shaft_free=no (the rotor is not turned); link=VOLT, the DC "
         "link by "
         "a meter",
         0},
        {"yes", 'y', NULL, 0, "answer all questions with yes", 0},
        {"write", 'w', "FILE", 0, "write the measured motor, for [motor] and for `lagless tune`", 0},
        ARGUMENTS_FORCE,
        {"json", 'j', NULL, 0, "one JSON object on stdout", 0},
        {0}};
    static const struct argp argp = {
        rows,
        parse,
        "SCENARIO",
        "Measures the data of the scenario's motor by the drive itself, step by step, from standstill to the "
        "torque test. Of the scenario's motor only the plate is used.",
        NULL,
        NULL,
        NULL};
    options_t options = {.turns = true};
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    scenario_t *scenario = library_read("commission", &options.of);
    if (scenario == NULL) {
        return EXIT_USAGE;
    }
    const int exit_code = run(&options, scenario);
    scenario_free(scenario);
    return exit_code;
}
