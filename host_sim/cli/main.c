#include <argp.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/streams.h"
#include "host_sim/lab/names.h"

const char *argp_program_version = CLI_VERSION;

const cli_command_t cli_commands[] = {
    {"run", command_run, "run a scenario, judge it, record it, draw it"},
    {"plot", command_plot, "a recording as a page to zoom into, or as pictures"},
    {"compare", command_compare, "two recordings: the first difference, and both in one page"},
    {"serve", command_serve, "run a scenario without end and let others talk to its drive"},
    {"scope", command_scope, "a page in the browser that shows a drive at work and steers it"},
    {"scenarios", command_scenarios, "the scenarios that come with the program"},
    {"motors", command_motors, "the motors that come with the program, or one of them"},
    {"tune", command_tune, "the parameters that a motor needs, each with its reason, and warnings of its limits"},
    {"params", command_params, "what can be set: parameters, requests, plant, rig"},
    {"signals", command_signals, "what can be seen: signals and the plant's truth"},
    {"explain", command_explain, "a fault, warning or refusal: what happened, what to do"},
    {"connect", command_connect,
     "talk to a drive over TCP or a serial line: run it, set and save parameters, record"},
    {"map", command_map, "error of the sensorless angle over speed, load and wrong motor data, judged"},
    {"campaign", command_campaign, "random runs by the thousand, each judged by what must always hold"},
    {"matrix", command_matrix, "every fault in every manoeuvre, and whether the drive does what it promises"},
    {"paper", command_paper, "the paper's figures measured again, judged against its numbers"},
    {"bench", command_bench, "speed of the simulation, cost of the interrupt and of the estimator"},
    {"reference", command_reference, "all tables as Markdown"},
    {"completion", command_completion, "shell completion, for `source`"},
    {"man", command_man, "the manual page"},
};
const size_t cli_command_count = sizeof cli_commands / sizeof cli_commands[0];

static void print_commands(FILE *to)
{
    fprintf(to, "Usage: lagless COMMAND [OPTION...]\n\n");
    for (size_t n = 0; n < cli_command_count; n++) {
        fprintf(to, "  %-11s %s\n", cli_commands[n].name, cli_commands[n].text);
    }
    fprintf(to, "\n`lagless COMMAND --help` lists the options of a command, `lagless man` those of all.\n");
}

/* Commands that there are no more, and what does it now. */
static const struct {
    const char *name, *instead;
} former[] = {
    {"demo", "`lagless run encoder_speed_profile` runs that profile; `tools/demo` makes the report"},
};

/* false: it was never a command. */
static bool tell_former(const char *name)
{
    for (size_t n = 0; n < sizeof former / sizeof former[0]; n++) {
        if (strcmp(name, former[n].name) == 0) {
            fprintf(stderr, "lagless: %s: no command any more: %s\n", name, former[n].instead);
            return true;
        }
    }
    return false;
}

int main(int argc, char **argv)
{
    argp_err_exit_status = EXIT_USAGE;
    signal(SIGXFSZ, SIG_IGN); /* a file-size limit becomes an error message */
    streams_begin(argc, argv);
    if (argc < 2) {
        print_commands(stderr);
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_commands(stdout);
        return EXIT_DONE;
    }
    if (strcmp(argv[1], "--version") == 0 || strcmp(argv[1], "-V") == 0) {
        printf("%s\n", argp_program_version);
        return EXIT_DONE;
    }
    names_search_t search = names_search(argv[1]);
    for (size_t n = 0; n < cli_command_count; n++) {
        names_consider(&search, cli_commands[n].name);
        if (strcmp(argv[1], cli_commands[n].name) == 0) {
            char name[64];
            snprintf(name, sizeof name, "lagless %s", cli_commands[n].name);
            argv[1] = name;
            return cli_commands[n].run(argc - 1, argv + 1);
        }
    }
    if (tell_former(argv[1])) {
        return EXIT_USAGE;
    }
    fprintf(stderr, "lagless: %s: no such command", argv[1]);
    output_suggest(stderr, names_found(&search));
    fprintf(stderr, "\n`lagless --help` lists the commands.\n");
    return EXIT_USAGE;
}
