/* Options of several commands: --json, --out, a scenario with --set and --seed, whole numbers. */
#ifndef HOST_SIM_CLI_ARGUMENTS_H
#define HOST_SIM_CLI_ARGUMENTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct argp;

/* Reads the command line of a command. Each command calls it first. --help and --version end the program.
 * false: wrong use (the message is on stderr), or only arguments_show was called. */
bool arguments_parse(const struct argp *argp, int argc, char **argv, void *input);

/* Shows the options and texts of the command that is called with `run`, without running it. */
typedef void (*arguments_show_t)(const struct argp *argp, void *context);
void arguments_show(int (*run)(int argc, char **argv), arguments_show_t show, void *context);

/* A command without options and arguments; `doc` is the text of --help. false as above. */
bool arguments_none(int argc, char **argv, const char *doc);

/* A command whose one option is --json. */
bool arguments_json(int argc, char **argv, const char *doc, bool *json);

/* --force of every command that writes files: its row, and the action of its key. */
#define ARGUMENTS_FORCE_KEY 256
#define ARGUMENTS_FORCE                                                                                      \
    {                                                                                                        \
        "force", ARGUMENTS_FORCE_KEY, NULL, 0, "replace existing files (never an input)", 0                  \
    }
int arguments_force(int key); /* 0, or the code of argp for an unknown key */

/* --json, --out and --force: rows for a table of options, and the place of their values. */
#define ARGUMENTS_OUTPUT(json_text, out_text)                                                                \
    {"json", 'j', NULL, 0, json_text, 0}, {"out", 'o', "FOLDER", 0, out_text, 0}, ARGUMENTS_FORCE

typedef struct {
    bool json;
    const char *folder; /* NULL: none is given */
} arguments_output_t;

/* For argp's parser: processes these keys. Returns 0, or the code of argp for an unknown key. */
int arguments_output(int key, const char *argument, arguments_output_t *output);

/* A scenario and the options that change it: rows for a table of options. */
#define ARGUMENTS_SCENARIO                                                                                   \
    {"set",                                                                                                  \
     's',                                                                                                    \
     "NAME=VALUE",                                                                                           \
     0,                                                                                                      \
     "replace a value of the scenario before t = 0 (\"inertia=0.003\", \"speed_request=500 "                 \
     "r/min\"), "                                                                                            \
     "run.duration, run.seed, run.every, start.speed, start.angle; repeatable",                              \
     0},                                                                                                     \
    {                                                                                                        \
        "seed", 'S', "N", 0, "seed of all noise, instead of the scenario's", 0                               \
    }

#define ARGUMENTS_SETS 64u

typedef struct {
    const char *scenario;
    const char *sets[ARGUMENTS_SETS]; /* "NAME=VALUE" each */
    size_t set_count;
    const char *seed; /* NULL: none is given */
} arguments_scenario_t;

/* For argp's parser: processes these two keys and the scenario. Returns 0, or the code of argp for an unknown
 * key. */
struct argp_state;
int arguments_scenario(int key, char *argument, struct argp_state *state, arguments_scenario_t *of);

/* The number of --key KEY, which unlocks a drive. A wrong number ends the program with a message. */
#define ARGUMENTS_KEY                                                                                        \
    {                                                                                                        \
        "key", 'K', "KEY", 0,                                                                                \
            "value of the drive's parameter line_key, if it is not 0; without the key the drive can only "   \
            "be "                                                                                            \
            "read and stopped",                                                                              \
            0                                                                                                \
    }
uint32_t arguments_key(const char *text, struct argp_state *state);

/* --board NAME of every command whose result depends on the board. Here is only its row; arguments_parse
 * processes it (board.h). */
#define ARGUMENTS_BOARD_KEY 257
#define ARGUMENTS_BOARD                                                                                      \
    {                                                                                                        \
        "board", ARGUMENTS_BOARD_KEY, "NAME", 0, "the power stage, one of `lagless boards`", 0               \
    }

/* Reads a whole number of decimal digits, min <= value <= max < 10^19. false: the text is not such a number.
 */
bool arguments_whole(const char *text, uint64_t min, uint64_t max, uint64_t *value);

/* Reads the whole number of an option. text = NULL: the option is not given, and *value is unchanged. false:
 * the accepted numbers are on stderr. */
bool arguments_number(const char *command, const char *option, const char *text, uint64_t min, uint64_t max,
                      uint64_t *value);

#endif
