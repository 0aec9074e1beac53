#include <argp.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/names.h"

const char *argp_program_version = CLI_VERSION;

const cli_command_t cli_commands[] = {
    {"run", command_run, "SCENARIO", "--set --seed --record --every --out --format --json --quiet",
     "run a scenario, judge it, record it"},
    {"scenarios", command_scenarios, "", "--json", "the scenarios that come with the program"},
    {"params", command_params, "", "--json", "what can be set: parameters, requests, plant, rig"},
    {"signals", command_signals, "", "--json", "what can be seen: signals and the plant's truth"},
    {"explain", command_explain, "[REASON]", "--json",
     "a fault, warning or refusal: what happened, what to do"},
    {"demo", command_demo, "", "--json --out", "encoder-mode speed profile, as a table and a picture"},
    {"map", command_map, "[SCENARIO]", "--speeds --adaptation --ideal --averaged --json --out",
     "error of the sensorless angle over speed, load and wrong beliefs, judged"},
    {"paper", command_paper, "[FIG...]", "--json --out",
     "the paper's figures measured again, judged against its numbers"},
    {"bench", command_bench, "", "--json --seconds",
     "speed of the ring, cost of the interrupt and of the estimator"},
    {"reference", command_reference, "", "", "all tables as Markdown"},
    {"completion", command_completion, "bash", "", "shell completion, for `source`"},
    {"man", command_man, "", "", "the manual page"},
};
const size_t cli_command_count = sizeof cli_commands / sizeof cli_commands[0];

static void print_commands(FILE *to)
{
    fprintf(to, "Usage: lagless COMMAND [OPTION...]\n\n");
    for (size_t n = 0; n < cli_command_count; n++) {
        fprintf(to, "  %-11s %s\n", cli_commands[n].name, cli_commands[n].text);
    }
    fprintf(to, "\n`lagless COMMAND --help` tells the options of each.\n");
}

int main(int argc, char **argv)
{
    argp_err_exit_status = EXIT_USAGE;
    signal(SIGXFSZ, SIG_IGN); /* a file-size limit becomes an error message */
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
    fprintf(stderr, "lagless: %s: no such command", argv[1]);
    output_suggest(stderr, names_found(&search));
    fprintf(stderr, "\n`lagless --help` lists the commands.\n");
    return EXIT_USAGE;
}
