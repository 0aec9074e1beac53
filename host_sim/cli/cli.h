/* `lagless`: the command line of the simulation. Data on stdout, messages on stderr. */
#ifndef HOST_SIM_CLI_CLI_H
#define HOST_SIM_CLI_CLI_H

#include <stddef.h>

#define CLI_VERSION "lagless " LAGLESS_VERSION /* of the project in CMakeLists.txt */

enum {
    EXIT_DONE = 0,     /* done, and all expectations are met */
    EXIT_FAILED = 1,   /* ran, but an expectation failed or could not be judged */
    EXIT_USAGE = 2,    /* wrong use or input */
    EXIT_INTERNAL = 3, /* internal or I/O */
};

typedef struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *text; /* one line; the options are those that it reads: arguments_show */
} cli_command_t;

/* All commands, in the order of the help. */
extern const cli_command_t cli_commands[];
extern const size_t cli_command_count;

int command_bench(int argc, char **argv);
int command_boards(int argc, char **argv);
int command_campaign(int argc, char **argv);
int command_commission(int argc, char **argv);
int command_compare(int argc, char **argv);
int command_completion(int argc, char **argv);
int command_connect(int argc, char **argv);
int command_explain(int argc, char **argv);
int command_fmu(int argc, char **argv);
int command_man(int argc, char **argv);
int command_map(int argc, char **argv);
int command_matrix(int argc, char **argv);
int command_motors(int argc, char **argv);
int command_paper(int argc, char **argv);
int command_params(int argc, char **argv);
int command_plot(int argc, char **argv);
int command_reference(int argc, char **argv);
int command_replay(int argc, char **argv);
int command_run(int argc, char **argv);
int command_scenarios(int argc, char **argv);
int command_scope(int argc, char **argv);
int command_serve(int argc, char **argv);
int command_signals(int argc, char **argv);
int command_tune(int argc, char **argv);

/* Prints the explanation of a fault or refusal, as `lagless explain` does (explain.c). */
void explain_reason(int number);

#endif
