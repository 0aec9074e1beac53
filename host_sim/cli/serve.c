/* `lagless serve SCENARIO`: runs the drive of a scenario without end, for a client on its serial link. */
#include <argp.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "contract/line.h"
#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/flash_file.h"
#include "host_sim/cli/library.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/stop.h"
#include "host_sim/lab/course.h"
#include "host_sim/lab/units.h"
#include "host_sim/lab/wire.h"

#define LOOK_PERIODS   rig_periods(1e-3)   /* [periods] between two checks of link and clock */
#define SERIAL_PERIODS rig_periods(0.5e-3) /* [periods] between two checks of the chip's serial line */
#define SERIAL_OCTETS  128u                /* [octets] that the serial line is given at once */
#define KEEP_PERIODS   rig_periods(1.0)    /* [periods] between two checks of the flash */
#define BEHIND_MAX     0.1                 /* [s] of delay that is caught up; a longer delay is not made up */
#define TELL_AFTER     5.0 /* [s] by which the simulation may lag behind real time without a message */
#define UNTIL_MAX      UINT32_MAX *RIG_PERIOD_SECONDS

typedef struct {
    arguments_scenario_t of;
    const char *port, *until, *flash;
    bool realtime, free, serial, quiet;
} options_t;

/* The values of the command line. */
typedef struct {
    uint64_t seed, port;
    uint32_t periods; /* [periods] UINT32_MAX: without end */
} numbers_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'p':
        options->port = argument;
        return 0;
    case 'u':
        options->until = argument;
        return 0;
    case 'F':
        options->flash = argument;
        return 0;
    case 'R':
        options->realtime = true;
        return 0;
    case 'f':
        options->free = true;
        return 0;
    case 't':
        options->serial = true;
        return 0;
    case 'q':
        options->quiet = true;
        return 0;
    case ARGP_KEY_END:
        if (options->realtime && options->free) {
            argp_error(state, "--realtime and --free exclude each other: give one of them");
        }
        if (options->serial && options->port != NULL) {
            argp_error(state, "--serial and --port exclude each other: give one of them");
        }
        return 0;
    default:
        return arguments_scenario(key, argument, state, &options->of);
    }
}

static bool read_until(const char *text, uint32_t *periods)
{
    units_error_t why;
    double seconds = 0.0;
    *periods = UINT32_MAX;
    if (text == NULL) {
        return true;
    }
    if (!units_read(text, "s", &seconds, &why)) {
        fprintf(stderr, "lagless serve: --until %s\n", why.text);
        return false;
    }
    if (!(seconds >= SCENARIO_SECONDS_MIN && seconds < UNTIL_MAX)) {
        fprintf(stderr, "lagless serve: --until %s: accepted: %g to %g s\n", text, SCENARIO_SECONDS_MIN,
                (double)(uint32_t)UNTIL_MAX);
        return false;
    }
    *periods = rig_periods(seconds);
    return true;
}

/* ---- time ---- */

/* Waits, so that the simulation is not faster than real time. */
typedef struct {
    double zero;     /* [s] of the host's clock at which period 0 would have begun */
    double begun;    /* [s] of the host's clock */
    uint32_t behind; /* [-] number of times that a delay was not made up */
    bool told;
} pace_t;

static void sleep_for(double seconds)
{
    const struct timespec time = {.tv_sec = (time_t)seconds,
                                  .tv_nsec = (long)((seconds - (double)(time_t)seconds) * 1e9)};
    nanosleep(&time, NULL);
}

static void keep_pace(pace_t *pace, uint32_t period, bool quiet)
{
    const double ahead = pace->zero + period * RIG_PERIOD_SECONDS - output_seconds();
    if (ahead > 0.0) {
        sleep_for(ahead);
    } else if (ahead < -BEHIND_MAX) {
        pace->zero += -ahead;
        pace->behind++;
    }
    const double wall = output_seconds() - pace->begun;
    if (!pace->told && !quiet && wall > TELL_AFTER && period * RIG_PERIOD_SECONDS < 0.9 * wall) {
        pace->told = true;
        fprintf(
            stderr,
            "lagless serve: this machine is too slow: %.2f x real time; --set fidelity=averaged is faster\n",
            period * RIG_PERIOD_SECONDS / wall);
    }
}

/* ---- the run ---- */

typedef struct {
    rig_t *rig;
    wire_t *wire;
    course_t course;
    flash_file_t *flash;         /* NULL: none is kept */
    uint8_t sent[SERIAL_OCTETS]; /* towards the drive, not yet on its serial line */
    uint32_t sent_count;
    bool realtime, serial, quiet, had_client;
    pace_t pace;
} serve_t;

static void tell_clients(serve_t *serve)
{
    const bool has = wire_has_client(serve->wire);
    if (has != serve->had_client && !serve->serial && !serve->quiet) {
        char from[WIRE_CLIENT_SIZE];
        fprintf(stderr, "lagless serve: client %s%s at %.3f s\n", has ? "connected from " : "disconnected",
                has ? wire_client(serve->wire, from) : "", rig_period(serve->rig) * RIG_PERIOD_SECONDS);
    }
    serve->had_client = has;
}

/* Timed actions that the present parameters no longer permit are reported and left out. */
static void change(serve_t *serve, uint32_t period)
{
    scenario_error_t error;
    if (!course_change(&serve->course, period, &error)) {
        char text[1200];
        fprintf(stderr, "lagless serve: action skipped: %s\n",
                scenario_error_text(&error, text, sizeof text));
    }
}

/* Octets between the terminal and the chip's serial line, which has its own time for them. */
static void lead_serial(serve_t *serve)
{
    uint8_t octets[SERIAL_OCTETS];
    const uint32_t room = SERIAL_OCTETS - serve->sent_count;
    serve->sent_count += wire_read(serve->wire, serve->sent + serve->sent_count, room);
    const uint32_t taken = rig_serial_put(serve->rig, serve->sent, serve->sent_count);
    serve->sent_count -= taken;
    memmove(serve->sent, serve->sent + taken, serve->sent_count);
    for (uint32_t count = rig_serial_get(serve->rig, octets, SERIAL_OCTETS); count != 0u;
         count = rig_serial_get(serve->rig, octets, SERIAL_OCTETS)) {
        (void)wire_write(serve->wire, octets, count);
    }
}

static void turn(serve_t *serve, uint32_t periods, const volatile sig_atomic_t *stop)
{
    uint32_t pause = 0;
    serve->pace.begun = output_seconds();
    serve->pace.zero = serve->pace.begun;
    for (uint32_t period = 0; period < periods && *stop == 0; period++) {
        if (period == pause) {
            change(serve, period);
            pause = course_next(&serve->course, period);
        }
        if (serve->serial && period % SERIAL_PERIODS == 0u) {
            lead_serial(serve);
        }
        if (period % KEEP_PERIODS == 0u) {
            (void)flash_file_keep(serve->flash, serve->rig);
        }
        if (period % LOOK_PERIODS == 0u) {
            wire_poll(serve->wire);
            tell_clients(serve);
            if (serve->realtime) {
                keep_pace(&serve->pace, period, serve->quiet);
            }
        }
        rig_step(serve->rig);
    }
}

static int serve_scenario(const options_t *options, const numbers_t *numbers, const scenario_t *scenario)
{
    scenario_error_t refused;
    wire_error_t error;
    const volatile sig_atomic_t *stop = stop_on_signal();
    serve_t serve = {.realtime = !options->free, .serial = options->serial, .quiet = options->quiet};
    serve.rig = rig_create(options->of.seed != NULL ? numbers->seed : scenario->seed);
    if (serve.rig == NULL || !course_init(&serve.course, scenario, serve.rig)) {
        fprintf(stderr, "lagless serve: not enough memory\n");
        rig_free(serve.rig);
        return EXIT_INTERNAL;
    }
    int exit_code = EXIT_INTERNAL;
    if (options->flash != NULL) {
        serve.flash = flash_file_open(options->flash, serve.rig);
        if (serve.flash == NULL) {
            course_free(&serve.course);
            rig_free(serve.rig);
            return EXIT_INTERNAL;
        }
    }
    serve.wire = options->serial ? wire_terminal(&error)
                                 : wire_listen((uint32_t)numbers->port, options->free, stop, &error);
    if (serve.wire == NULL) {
        fprintf(stderr, "lagless serve: %s\n", error.text);
    } else if (!course_start(&serve.course, &refused)) {
        library_say("serve", &refused);
        exit_code = EXIT_USAGE;
    } else {
        const rig_line_t line = {wire_read, wire_write, serve.wire};
        if (options->serial) {
            rig_serial_baud(serve.rig, 0u);
        } else {
            rig_line(serve.rig, &line);
        }
        printf("listening on %s\n", wire_name(serve.wire));
        if (fflush(stdout) == 0) { /* without its address no client could connect */
            turn(&serve, numbers->periods, stop);
            exit_code = flash_file_keep(serve.flash, serve.rig) ? EXIT_DONE : EXIT_INTERNAL;
        }
    }
    wire_close(serve.wire);
    flash_file_close(serve.flash);
    course_free(&serve.course);
    rig_free(serve.rig);
    return exit_code;
}

int command_serve(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"port", 'p', "N", 0, "port of 127.0.0.1, default 5555; 0: any free port", 0},
        {"realtime", 'R', NULL, 0, "in real time (default)", 0},
        {"free", 'f', NULL, 0, "as fast as possible; waits for a client that reads slowly", 0},
        {"serial", 't', NULL, 0,
         "a pseudo terminal instead of a port: bytes pass the chip's serial port at its baud rate", 0},
        {"flash", 'F', "FILE", 0, "file that keeps the content of the drive's flash from one run to the next",
         0},
        {"until", 'u', "TIME", 0, "simulated time at which the program ends; default: until Ctrl-C", 0},
        ARGUMENTS_SCENARIO,
        ARGUMENTS_BOARD,
        {"quiet", 'q', NULL, 0, "after the first line print only errors", 0},
        {0},
    };
    static const struct argp argp = {
        rows,
        parse,
        "SCENARIO",
        "Runs the drive of a scenario (a TOML file, `-` for stdin, or a name of `lagless "
        "scenarios`) and lets a client talk to it by XCP, at a port of this machine only. The settings and "
        "timed actions of the scenario take effect; its duration and its expectations have no effect.",
        NULL,
        NULL,
        NULL};
    options_t options = {0};
    numbers_t numbers = {.port = LINE_PORT};
    if (!arguments_parse(&argp, argc, argv, &options) ||
        !arguments_number("serve", "--port", options.port, 0u, 65535u, &numbers.port) ||
        !arguments_number("serve", "--seed", options.of.seed, 0u, INT64_MAX, &numbers.seed) ||
        !read_until(options.until, &numbers.periods)) {
        return EXIT_USAGE;
    }
    scenario_t *scenario = library_read("serve", &options.of);
    if (scenario == NULL) {
        return EXIT_USAGE;
    }
    const int exit_code = serve_scenario(&options, &numbers, scenario);
    scenario_free(scenario);
    return exit_code;
}
