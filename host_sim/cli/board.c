#include "host_sim/cli/board.h"

#include <errno.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/boards.h"
#include "host_sim/lab/json.h"

static struct {
    char **arguments; /* as given on the command line, NULL at their end */
    bool chosen;      /* by --board */
} line;

void board_begin(int argc, char **argv)
{
    line.arguments = calloc((size_t)argc + 1u, sizeof *line.arguments);
    for (int n = 0; n < argc && line.arguments != NULL; n++) {
        line.arguments[n] = argv[n];
    }
}

/* The program of a board: boards/NAME/lagless in the folder of `lagless`; of the default board, `lagless`
 * itself. */
static bool program_of(const board_facts_t *board, char path[PATH_SIZE], char why[BOARD_WHY_SIZE])
{
    char own[PATH_SIZE];
    const ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1u);
    if (length <= 0) {
        snprintf(why, BOARD_WHY_SIZE, "/proc/self/exe cannot be read, so the board's program is not found");
        return false;
    }
    own[length] = '\0';
    char *folder = dirname(own);
    if (!boards_is_default()) { /* this is boards/NAME/lagless itself */
        folder = dirname(dirname(folder));
    }
    const bool is_default = board == board_facts[0];
    const int used = snprintf(path, PATH_SIZE, "%s%s%s/lagless", folder, is_default ? "" : "/boards/",
                              is_default ? "" : board->name);
    if (used < PATH_SIZE && access(path, X_OK) == 0) {
        return true;
    }
    snprintf(why, BOARD_WHY_SIZE, "its program %s is missing; build the target lagless_boards", path);
    return false;
}

/* Ends this program by becoming that of another board. false: `why`. */
static bool become(const board_facts_t *board, char why[BOARD_WHY_SIZE])
{
    char path[PATH_SIZE];
    if (!program_of(board, path, why)) {
        return false;
    }
    if (line.arguments == NULL) {
        snprintf(why, BOARD_WHY_SIZE, "there is no memory");
        return false;
    }
    execv(path, line.arguments);
    snprintf(why, BOARD_WHY_SIZE, "%s does not start: %s", path, strerror(errno));
    return false;
}

bool board_choose(const char *name, char why[BOARD_WHY_SIZE])
{
    const board_facts_t *board = boards_find(name, why);
    if (board == NULL) {
        return false;
    }
    line.chosen = true;
    return strcmp(board->name, rig_board) == 0 || become(board, why);
}

/* Replaces the content of stdin by this text. */
static bool back_to_stdin(const char *text, size_t octets)
{
    FILE *file = tmpfile();
    return file != NULL && fwrite(text, 1, octets, file) == octets && fflush(file) == 0 &&
           lseek(fileno(file), 0, SEEK_SET) == 0 && dup2(fileno(file), STDIN_FILENO) >= 0;
}

bool board_of_scenario(const char *name, const char *text, size_t octets, char why[BOARD_WHY_SIZE])
{
    const board_facts_t *board = line.chosen ? NULL : boards_find(name, why);
    if (board == NULL) {
        why[0] = '\0';
        return false;
    }
    if (text != NULL && !back_to_stdin(text, octets)) {
        snprintf(why, BOARD_WHY_SIZE, "the text cannot be stored: %s; give --board %s", strerror(errno),
                 name);
        return false;
    }
    return become(board, why);
}

/* ---- lagless boards ---- */

static void print_json(const board_facts_t *board, const char *separator)
{
    printf("%s\n  {\"name\": ", separator);
    json_text(stdout, board->name);
    printf(", \"default\": %s, \"link_v\": %.6g, \"undervoltage_v\": %.6g, \"overvoltage_v\": %.6g, "
           "\"overvoltage_max_v\": %.6g, \"current_limit_a\": %.6g, \"overcurrent_trip_a\": %.6g, "
           "\"current_range_a\": %.6g, \"current_step_a\": %.6g, \"current_sensors\": %d, \"shunts\": %s, "
           "\"carrier_hz\": %.6g, \"dead_time_s\": %.6g}",
           board == board_facts[0] ? "true" : "false", board->nominal, board->undervoltage,
           board->overvoltage, board->overvoltage_max, board->current_limit, board->current_trip,
           board->current_range, board->current_per_code, board->sensors, board->shunts ? "true" : "false",
           1.0 / board->period, board->dead_time);
}

static void print_line(const board_facts_t *board)
{
    printf("%-18s %5.4g V %5.3g A %6.4g kHz  trips %.4g V, %.4g V (at most %.4g V), %.3g A  %d %s, +-%.3g A  "
           "dead time %.3g us%s\n",
           board->name, board->nominal, board->current_limit, 1e-3 / board->period, board->undervoltage,
           board->overvoltage, board->overvoltage_max, board->current_trip, board->sensors,
           board->shunts ? "shunts" : "sensors in the leads", board->current_range, 1e6 * board->dead_time,
           board == board_facts[0] ? "  (default)" : "");
    char hurried[BOARDS_TEXT_SIZE];
    if (boards_hurried(hurried, board)[0] != '\0') {
        printf("%-18s %s\n", "", hurried);
    }
}

int command_boards(int argc, char **argv)
{
    bool json;
    if (!arguments_json(argc, argv,
                        "Lists the boards that --board and a scenario's `board` accept: link, current limit, "
                        "carrier, trips (undervoltage, overvoltage, overcurrent) and current sensors.",
                        &json)) {
        return EXIT_USAGE;
    }
    printf(json ? "{\"boards\": [" : "");
    for (size_t n = 0; board_facts[n] != NULL; n++) {
        if (json) {
            print_json(board_facts[n], n == 0u ? "" : ",");
        } else {
            print_line(board_facts[n]);
        }
    }
    printf(json ? "\n]}\n" : "");
    return EXIT_DONE;
}
