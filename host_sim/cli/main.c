#include <argp.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/board.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/streams.h"
#include "host_sim/lab/names.h"

const cli_command_t cli_commands[] = {
    {"run", command_run, "run a scenario, judge it, record it, plot it"},
    {"plot", command_plot, "plot a recording as a page with zoom, or as pictures"},
    {"compare", command_compare, "compare two recordings: the first difference, and both on one page"},
    {"serve", command_serve, "run a scenario without end, for clients that talk to its drive"},
    {"scope", command_scope, "show and control a running drive on a page in the browser"},
    {"scenarios", command_scenarios, "list the scenarios that come with the program"},
    {"boards", command_boards, "list the boards between which --board chooses"},
    {"motors", command_motors, "list the motors that come with the program, or show one"},
    {"tune", command_tune, "compute the parameters for a motor, each with its rule, and warn of its limits"},
    {"commission", command_commission,
     "measure the data of an unknown motor by the drive, and write its file"},
    {"params", command_params, "list what can be set: parameters, requests, plant, rig"},
    {"signals", command_signals, "list the signals of the drive and the true values of the plant"},
    {"explain", command_explain, "explain a fault, warning or refusal: what happened, what to do"},
    {"connect", command_connect,
     "talk to a drive over TCP or a serial link: run it, set and save parameters, record"},
    {"replay", command_replay, "run the drive's tasks again on the samples that it recorded before a fault"},
    {"map", command_map, "measure the error of the sensorless angle over speed, load and wrong motor data"},
    {"campaign", command_campaign, "do thousands of random runs, each judged by rules that must always hold"},
    {"matrix", command_matrix,
     "inject every fault in every manoeuvre and compare the reaction with the promise"},
    {"paper", command_paper, "measure the paper's figures again and judge them against its numbers"},
    {"fmu", command_fmu, "write the simulation of a scenario as an FMU (FMI 2.0) for simulation programs"},
    {"bench", command_bench, "measure the speed of the simulation and the cost of interrupt and estimator"},
    {"reference", command_reference, "print all tables as Markdown"},
    {"completion", command_completion, "print shell completion, for `source`"},
    {"man", command_man, "print the manual page"},
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

/* Commands that no longer exist, and the commands that replace them. */
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
            fprintf(stderr, "lagless: %s: this command was removed: %s\n", name, former[n].instead);
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
    board_begin(argc, argv);
    if (argc < 2) {
        print_commands(stderr);
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_commands(stdout);
        return EXIT_DONE;
    }
    if (strcmp(argv[1], "--version") == 0 || strcmp(argv[1], "-V") == 0) {
        printf("%s\n", CLI_VERSION);
        return EXIT_DONE;
    }
    if (strcmp(argv[1], "help") == 0) { /* `lagless help` and `lagless help COMMAND` */
        if (argc == 2) {
            print_commands(stdout);
            return EXIT_DONE;
        }
        argv[1] = argv[2];
        argv[2] = "--help";
        argc = 3;
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
