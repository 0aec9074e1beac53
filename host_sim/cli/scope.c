/* `lagless scope TARGET`: a page in the browser that shows a running drive, simulated or real. */
#include <argp.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/stop.h"
#include "host_sim/line/master.h"
#include "host_sim/line/transport.h"
#include "host_sim/scope/page.h"
#include "host_sim/scope/scope.h"

#define PORT 5580u /* if none is given */

typedef struct {
    const char *target, *port;
    uint32_t key; /* 0: none */
    bool no_browser;
} options_t;

static error_t parse(int key, char *argument, struct argp_state *state)
{
    options_t *options = state->input;
    switch (key) {
    case 'p':
        options->port = argument;
        return 0;
    case 'K':
        options->key = arguments_key(argument, state);
        return 0;
    case 'n':
        options->no_browser = true;
        return 0;
    case ARGP_KEY_ARG:
        if (options->target != NULL) {
            argp_error(state, "%s: a second target; accepted: one", argument);
        }
        options->target = argument;
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "no target is given; accepted: tcp://127.0.0.1:5555 of `lagless serve`, or a "
                          "serial device, /dev/ttyUSB0[:BAUD]");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Opens the user's browser. A failure is reported; the address is on stdout in any case. */
static void open_browser(const char *address)
{
#if defined(__APPLE__)
    static const char *const opener = "open";
#else
    static const char *const opener = "xdg-open";
#endif
    int status = 0;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        const pid_t grandchild = fork(); /* whose end is not awaited */
        if (grandchild == 0) {
            execlp(opener, opener, address, (char *)NULL);
            fprintf(
                stderr,
                "lagless scope: %s is missing, so no browser is opened: open the printed address yourself\n",
                opener);
            _exit(127);
        }
        _exit(0);
    }
    (void)waitpid(child, &status, 0);
}

static int show(const options_t *options, uint64_t port, const char *page, size_t page_size)
{
    const volatile sig_atomic_t *stop = stop_on_signal();
    char why[700];
    char address[96];
    master_error_t error;
    master_t *master = master_open(options->target, &error);
    if (master == NULL || (options->key != 0u && !master_unlock(master, options->key, &error))) {
        fprintf(stderr, "lagless scope: %s\n", error.text);
        master_close(master);
        return EXIT_INTERNAL;
    }
    scope_t *scope = scope_open(master, (uint32_t)port, page, page_size, why, sizeof why);
    if (scope == NULL) {
        fprintf(stderr, "lagless scope: %s\n", why);
        return EXIT_INTERNAL;
    }
    snprintf(address, sizeof address, "http://127.0.0.1:%u/%s/", (unsigned)scope_port(scope),
             scope_token(scope));
    printf("%s shown at %s\n", options->target, address);
    const bool told = fflush(stdout) == 0;
    if (told) {
        if (!options->no_browser) {
            open_browser(address);
        }
        scope_run(scope, stop);
    }
    scope_close(scope);
    return told ? EXIT_DONE : EXIT_INTERNAL;
}

int command_scope(int argc, char **argv)
{
    static const struct argp_option rows[] = {
        {"http", 'p', "PORT", 0, "port of 127.0.0.1 for the page, default 5580; 0: any free port", 0},
        {"port", 0, NULL, OPTION_ALIAS, "the same as --http", 0},
        ARGUMENTS_KEY,
        {"no-browser", 'n', NULL, 0, "print the address and open nothing", 0},
        {0},
    };
    static const struct argp argp = {rows,
                                     parse,
                                     "TARGET",
                                     "Shows a running drive on a page in the browser: signals with trigger "
                                     "and cursors, requests, parameters, a "
                                     "STOP button. TARGET is tcp://HOST:PORT (`lagless serve` listens at "
                                     "tcp://127.0.0.1:5555) or a serial "
                                     "device, /dev/ttyUSB0[:BAUD].",
                                     NULL,
                                     NULL,
                                     NULL};
    char why[700];
    options_t options = {0};
    uint64_t port = PORT;
    size_t page_size = 0;
    if (!arguments_parse(&argp, argc, argv, &options)) {
        return EXIT_USAGE;
    }
    if (options.port != NULL && !arguments_whole(options.port, 0u, 65535u, &port)) {
        fprintf(stderr, "lagless scope: --http %s: accepted: whole numbers 0 to 65535\n", options.port);
        return EXIT_USAGE;
    }
    transport_target_t parsed;
    if (!transport_parse(options.target, &parsed, why, sizeof why)) {
        fprintf(stderr, "lagless scope: %s\n", why);
        return EXIT_USAGE;
    }
    char *page = page_make(&page_size, why, sizeof why);
    if (page == NULL) {
        fprintf(stderr, "lagless scope: %s\n", why);
        return EXIT_INTERNAL;
    }
    const int exit_code = show(&options, port, page, page_size);
    free(page);
    return exit_code;
}
