#include <argp.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/cli.h"

const char *argp_program_version = "lagless 0.1.0";

typedef struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *text;
} command_t;

static const command_t commands[] = {
    {"demo", command_demo, "encoder-mode speed profile, as a table and a picture"},
    {"bench", command_bench, "speed of the ring and cost of the interrupt"},
};

static void print_commands(FILE *to)
{
    fprintf(to, "Usage: lagless COMMAND [OPTION...]\n\n");
    for (size_t n = 0; n < sizeof commands / sizeof commands[0]; n++) {
        fprintf(to, "  %-8s %s\n", commands[n].name, commands[n].text);
    }
    fprintf(to, "\n`lagless COMMAND --help` tells the options of each.\n");
}

int main(int argc, char **argv)
{
    argp_err_exit_status = EXIT_USAGE;
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
    for (size_t n = 0; n < sizeof commands / sizeof commands[0]; n++) {
        if (strcmp(argv[1], commands[n].name) == 0) {
            char name[64];
            snprintf(name, sizeof name, "lagless %s", commands[n].name);
            argv[1] = name;
            return commands[n].run(argc - 1, argv + 1);
        }
    }
    fprintf(stderr, "lagless: %s: no such command\n\n", argv[1]);
    print_commands(stderr);
    return EXIT_USAGE;
}
