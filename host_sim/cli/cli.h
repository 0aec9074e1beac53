/* `lagless`: one command line for the desk. Data on stdout, messages on stderr. */
#ifndef HOST_SIM_CLI_CLI_H
#define HOST_SIM_CLI_CLI_H

#include <stdbool.h>

enum {
    EXIT_DONE = 0,     /* and all expectations met */
    EXIT_FAILED = 1,   /* ran, but an expectation failed */
    EXIT_USAGE = 2,    /* wrong use or input */
    EXIT_INTERNAL = 3, /* internal or I/O */
};

int command_bench(int argc, char **argv);
int command_demo(int argc, char **argv);

#endif
