/* `lagless connect TARGET`: talk to a drive, line by line. */
#include <argp.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/connect.h"
#include "host_sim/cli/connect_edit.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/inputs.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/names.h"
#include "host_sim/line/transport.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

static bool connect_help(session_t *session, uint32_t count, char **words);
static bool connect_explain(session_t *session, uint32_t count, char **words);
static bool connect_quit(session_t *session, uint32_t count, char **words);

#define WHERE "[--name NAME] [--format csv,mat,mdf]"

const connect_command_t connect_commands[] = {
    {"status", "", 0u, "", connect_status, "prints the state of the drive and the staged parameters"},
    {"get", "NAME...", COMPLETE_ROWS, "", connect_get,
     "prints values; of a staged parameter the staged value"},
    {"set", "NAME VALUE", COMPLETE_PARAMS | COMPLETE_REQUESTS | COMPLETE_SERVICES, "", connect_set,
     "stages a parameter; a request acts at once"},
    {"apply", "", 0u, "", connect_apply, "checks the staged parameters as a set and activates them"},
    {"params", "[PART]", 0u, "", connect_params,
     "lists what can be set, with value and range; with PART in the name"},
    {"signals", "[PART]", 0u, "", connect_signals, "lists the signals, with value; with PART in the name"},
    {"go", "SPEED", 0u, "", connect_go, "switches on and runs at this speed: go 500 r/min, go -52 rad/s"},
    {"stop", "", 0u, "", connect_stop, "speed 0; the bridge stays on"},
    {"quick_stop", "", 0u, "", connect_quick_stop, "brakes as hard as allowed, then off"},
    {"off", "", 0u, "", connect_off, "bridge off, the motor coasts"},
    {"reset", "", 0u, "", connect_reset, "resets a fault whose cause is gone; the bridge stays off"},
    {"watch", "NAME... [every TIME] [for TIME]", COMPLETE_ROWS, "every for", connect_watch,
     "prints values repeatedly, until Ctrl-C or for a time"},
    {"wait", "TIME | until NAME > VALUE [timeout TIME]", COMPLETE_ROWS, "until timeout", connect_wait,
     "waits, in the drive's time; comparisons: < <= > >= == !="},
    {"save", "", 0u, "", connect_save,
     "stores the active parameters in the drive's flash; the bridge must be off"},
    {"load", "", 0u, "", connect_load, "stages the saved parameters"},
    {"defaults", "", 0u, "", connect_defaults, "stages the default parameters"},
    {"erase", "yes", 0u, "yes", connect_erase,
     "erases all saved parameters, or what another program has left in their place; the active ones stay"},
    {"restart", "", 0u, "", connect_restart, "resets the controller, and connects again"},
    {"record", "NAME... for TIME --out FOLDER [every PERIODS] " WHERE, COMPLETE_SIGNALS,
     "for every --out --name --format", connect_record,
     "records every period of the signals into CSV and MAT files"},
    {"capture",
     "[on ... | signals NAME... | after TIME | arm | trigger | wait [TIME] | read --out FOLDER " WHERE
     " | save FILE | release]",
     COMPLETE_SIGNALS,
     "on signals after arm trigger wait read save release fault command above below --out --name --format",
     connect_capture,
     "the drive's own buffer: `on fault`, `on command`, `on SIGNAL above VALUE`, `on SIGNAL below VALUE`; "
     "save: the record for lagless replay"},
    {"faults", "", 0u, "", connect_faults, "prints the drive's last faults, newest first"},
    {"explain", "[REASON]", COMPLETE_REASONS, "", connect_explain,
     "explains a fault or refusal and its remedy"},
    {"help", "[COMMAND]", COMPLETE_COMMANDS, "", connect_help, "prints this list"},
    {"quit", "", 0u, "", connect_quit, "ends; command_timeout then stops a running motor"},
};
const uint32_t connect_command_count = sizeof connect_commands / sizeof connect_commands[0];

static volatile sig_atomic_t stop;

static void on_interrupt(int number)
{
    (void)number;
    stop = 1;
}

bool connect_stopped(void)
{
    return stop != 0;
}

/* ---- commands about the commands ---- */

static const connect_command_t *find_command(session_t *session, const char *name)
{
    names_search_t search = names_search(name);
    for (uint32_t n = 0; n < connect_command_count; n++) {
        names_consider(&search, connect_commands[n].name);
        if (strcmp(connect_commands[n].name, name) == 0) {
            return &connect_commands[n];
        }
    }
    const char *near = names_found(&search);
    connect_fail(session, "%s: no such command%s%s; `help` lists them", name,
                 near != NULL ? "; did you mean " : "", near != NULL ? near : "");
    return NULL;
}

static void help_command(const session_t *session, const connect_command_t *command, const char *separator)
{
    if (session->json) {
        printf("%s{\"name\": \"%s\", \"arguments\": ", separator, command->name);
        json_text(stdout, command->arguments);
        printf(", \"text\": ");
        json_text(stdout, command->text);
        printf("}");
    } else {
        printf("%s %s\n    %s\n", command->name, command->arguments, command->text);
    }
}

static bool connect_help(session_t *session, uint32_t count, char **words)
{
    const connect_command_t *one = count != 0u ? find_command(session, words[0]) : NULL;
    if (count != 0u && one == NULL) {
        return false;
    }
    printf(session->json ? ", \"commands\": [" : "");
    for (uint32_t n = 0; n < connect_command_count; n++) {
        if (one == NULL || one == &connect_commands[n]) {
            help_command(session, &connect_commands[n], one == NULL && n != 0u ? ", " : "");
        }
    }
    printf(session->json ? "]" : "");
    return true;
}

/* Reasons by number or name, with the text of `lagless explain`. */
static bool connect_explain(session_t *session, uint32_t count, char **words)
{
    char name[] = "lagless explain";
    char json[] = "--json";
    char *arguments[4] = {name};
    int used = 1;
    if (count > 1u || (count == 1u && words[0][0] == '-')) {
        return connect_fail(session, "explain: more than one reason; accepted: one, by its name or number");
    }
    if (session->json) {
        arguments[used++] = json;
        printf(", \"explained\": ");
    }
    if (count == 1u) {
        arguments[used++] = words[0];
    }
    fflush(stdout);
    if (command_explain(used, arguments) == EXIT_DONE) {
        return true;
    }
    printf(session->json ? "null" : "");
    return connect_fail(session, "%s: no such reason", words[0]);
}

static bool connect_quit(session_t *session, uint32_t count, char **words)
{
    (void)words;
    session->quit = count == 0u;
    return session->quit || connect_fail(session, "quit: no argument is accepted");
}

/* ---- a line ---- */

static uint32_t split(char *line, char *words[CONNECT_WORDS])
{
    uint32_t count = 0;
    char *rest = NULL;
    line[strcspn(line, "#\r\n")] = '\0';
    for (char *word = strtok_r(line, " \t", &rest); word != NULL && count < CONNECT_WORDS;
         word = strtok_r(NULL, " \t", &rest)) {
        words[count++] = word;
    }
    return count;
}

/* "line 3: set: ...", with the command's name once. */
static void tell_failure(const session_t *session, const char *command)
{
    const char *text = session->error.text;
    const size_t length = strlen(command);
    const bool named = strncmp(text, command, length) == 0 && text[length] == ':';
    if (session->json) {
        connect_json_text("error", text);
    }
    fflush(stdout);
    fprintf(stderr, "lagless connect: line %u: %s%s%s\n", (unsigned)session->line, named ? "" : command,
            named ? "" : ": ", text);
}

/* false: it failed. */
static bool run_line(session_t *session, const char *text)
{
    char line[CONNECT_LINE];
    char *words[CONNECT_WORDS];
    session->line++;
    if (snprintf(line, sizeof line, "%s", text) >= (int)sizeof line) {
        connect_fail(session, "more than %u octets", CONNECT_LINE - 1u);
        fprintf(stderr, "lagless connect: line %u: %s\n", (unsigned)session->line, session->error.text);
        return false;
    }
    const uint32_t count = split(line, words);
    if (count == 0u) {
        return true;
    }
    const connect_command_t *command = find_command(session, words[0]);
    if (session->json) {
        printf("{\"line\": %u, \"command\": ", (unsigned)session->line);
        json_text(stdout, words[0]);
    }
    const bool good = command != NULL && command->run(session, count - 1u, words + 1);
    if (!good) {
        tell_failure(session, words[0]);
    }
    printf(session->json ? "}\n" : "");
    fflush(stdout);
    return good;
}

/* ---- lines from stdin; the connection to the drive is maintained meanwhile ---- */

typedef struct {
    char text[4u * CONNECT_LINE];
    size_t used;
    bool ended;
} input_t;

/* Waits for stdin or the drive; false: the line to the drive is lost. *ready: stdin has something. */
static bool await_input(session_t *session, bool *ready)
{
    master_t *master = session->master;
    const double patience = master_patience(master);
    struct pollfd waiting[2] = {{STDIN_FILENO, POLLIN, 0},
                                {master_descriptor(master), master_events(master), 0}};
    const int milliseconds = patience < 1e3 ? (int)(1e3 * patience) + 1 : 1000;
    *ready = poll(waiting, 2, milliseconds) > 0 && (waiting[0].revents & (POLLIN | POLLHUP | POLLERR)) != 0;
    return master_work(master) || connect_fail(session, "%s: %s", master_name(master), master_lost(master));
}

static bool take_line(input_t *input, char line[CONNECT_LINE])
{
    const char *end = memchr(input->text, '\n', input->used);
    const size_t length = end != NULL ? (size_t)(end - input->text) : input->used;
    if (end == NULL && (!input->ended || input->used == 0u) && input->used < sizeof input->text) {
        return false;
    }
    const size_t kept = length < CONNECT_LINE ? length : CONNECT_LINE - 1u;
    memcpy(line, input->text, kept);
    line[kept] = '\0';
    const size_t gone = length + (end != NULL ? 1u : 0u);
    memmove(input->text, input->text + gone, input->used - gone);
    input->used -= gone;
    return true;
}

static int end_lost(const session_t *session)
{
    fflush(stdout);
    fprintf(stderr, "lagless connect: %s\n", session->error.text);
    return EXIT_INTERNAL;
}

static int run_script(session_t *session, bool terminal)
{
    static input_t input;
    char line[CONNECT_LINE];
    int result = EXIT_DONE;
    if (terminal) {
        printf("lagless> ");
        fflush(stdout);
    }
    while (!session->quit) {
        bool ready = false;
        if (!terminal && connect_stopped()) { /* within a line or between two lines: it ends the script */
            fprintf(stderr, "lagless connect: interrupted\n");
            return EXIT_FAILED;
        }
        if (take_line(&input, line)) {
            if (!terminal && !session->json && line[strspn(line, " \t\r")] != '\0') {
                printf("> %s\n", line);
            }
            const bool good = run_line(session, line);
            result = good || terminal ? result : EXIT_FAILED;
            if (master_descriptor(session->master) < 0) {
                return EXIT_INTERNAL;
            }
            if (!terminal && !good && !session->keep_going) {
                return EXIT_FAILED;
            }
            if (terminal) {
                stop = 0; /* what it interrupted has ended */
            }
            if (terminal && !session->quit) {
                printf("lagless> ");
                fflush(stdout);
            }
            continue;
        }
        if (input.ended || connect_stopped()) {
            break;
        }
        if (!await_input(session, &ready)) {
            return end_lost(session);
        }
        if (ready) {
            const ssize_t count = read(STDIN_FILENO, input.text + input.used, sizeof input.text - input.used);
            input.used += count > 0 ? (size_t)count : 0u;
            input.ended = count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
        }
    }
    return result;
}

static bool edit_line(void *session, const char *line)
{
    (void)run_line(session, line);
    stop = 0; /* what it interrupted has ended */
    return !((session_t *)session)->quit && master_descriptor(((session_t *)session)->master) >= 0;
}

/* Until a key is pressed; false: the line is lost, or Ctrl-C. */
static bool edit_wait(void *session)
{
    bool ready = false;
    while (!ready) {
        if (connect_stopped() || !await_input(session, &ready)) {
            return false;
        }
    }
    return true;
}

static int run_terminal(session_t *session)
{
    bool ready;
    connect_edit_begin(edit_line, edit_wait, session);
    stop = 0;
    while (connect_edit_goes_on() && !connect_stopped()) {
        if (!await_input(session, &ready)) {
            connect_edit_end();
            return end_lost(session);
        }
        if (ready) {
            connect_edit_read();
        }
    }
    connect_edit_end();
    return master_descriptor(session->master) < 0 ? EXIT_INTERNAL : EXIT_DONE;
}

/* ---- the command ---- */

typedef struct {
    bool json, keep_going;
    uint32_t key; /* 0: none */
    const char *target;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'j':
        options->json = true;
        return 0;
    case 'k':
        options->keep_going = true;
        return 0;
    case 'K':
        options->key = arguments_key(argument, state);
        return 0;
    case ARGUMENTS_FORCE_KEY:
        return arguments_force(key);
    case ARGP_KEY_ARG:
        if (options->target != NULL) {
            argp_error(state, "%s: a second target; accepted: one; commands are read from stdin", argument);
        }
        options->target = argument;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "no target is given; accepted: tcp://HOST:PORT such as tcp://127.0.0.1:5555, or a "
                          "serial device such as /dev/ttyUSB0");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void catch_interrupt(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_interrupt;
    sigaction(SIGINT, &action, NULL);
}

/* The motor still runs when the client ends: printed on stderr, because the user would not see it otherwise.
 */
static void tell_running(session_t *session)
{
    double state;
    double patience;
    if (session->steers && master_descriptor(session->master) >= 0 &&
        connect_get_named(session, "state", &state) && connect_is("state", state, "operation_enabled") &&
        connect_get_named(session, "command_timeout", &patience)) {
        if (patience > 0.0) {
            fprintf(stderr,
                    "lagless connect: the motor runs; the drive stops it in %g s without a client "
                    "(command_timeout)\n",
                    patience);
        } else {
            fprintf(stderr, "lagless connect: the motor continues to run, because command_timeout is 0\n");
        }
    }
}

int command_connect(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"json", 'j', NULL, 0, "one JSON object for each line of the script", 0},
        {"keep-going", 'k', NULL, 0, "continue after a line that failed; the exit code is 1 nevertheless", 0},
        ARGUMENTS_KEY,
        ARGUMENTS_FORCE,
        {0}};
    static const struct argp argp = {
        rows,
        parse,
        "TARGET",
        "Connects to a drive, simulated (tcp://127.0.0.1:5555) or real (/dev/ttyUSB0, /dev/ttyUSB0:115200).\v"
        "Commands are read from the terminal, or as a script from stdin; `help` lists them. A script ends at "
        "the first line that fails.",
        NULL,
        NULL,
        NULL};
    options_t options = {false, false, 0u, NULL};
    static session_t session;
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    transport_target_t parsed;
    if (!transport_parse(options.target, &parsed, session.error.text, sizeof session.error.text)) {
        fprintf(stderr, "lagless connect: %s\n", session.error.text);
        return EXIT_USAGE;
    }
    inputs_note_descriptor(STDIN_FILENO);
    session.json = options.json;
    session.keep_going = options.keep_going;
    session.master = master_open(options.target, &session.error);
    if (session.master == NULL ||
        (options.key != 0u && !master_unlock(session.master, options.key, &session.error))) {
        fprintf(stderr, "lagless connect: %s\n", session.error.text);
        master_close(session.master);
        return EXIT_INTERNAL;
    }
    catch_interrupt();
    const bool terminal = isatty(STDIN_FILENO) != 0;
    session.terminal = terminal;
    if (terminal && !session.json) {
        printf("%s: %s; `help` lists the commands\n", master_name(session.master),
               master_epk(session.master));
    }
    const int result = terminal && connect_edit_has() && !session.json ? run_terminal(&session)
                                                                       : run_script(&session, terminal);
    tell_running(&session);
    master_close(session.master);
    return result;
}
