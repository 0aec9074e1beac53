#include "host_sim/lab/boards.h"

#include <stdio.h>
#include <string.h>

#include "host_sim/lab/names.h"

#define CURRENT_SHARE 1.25         /* of the rated current, at least */
#define LIMIT_SHARE   (0.95 / 1.2) /* of the range: the largest trip, and the limit below it */
#define LINK_SHARE    1.15         /* of the link, at least: distance to the largest trip */
#define VOLTAGE_USE   0.9          /* of the link: largest EMF */
#define SQRT_3        1.7320508075688772
#define WINDOW        0.8e-3 /* [s] of the medium task */

static void append(char to[BOARDS_TEXT_SIZE], const char *text)
{
    const size_t used = strlen(to);
    snprintf(to + used, BOARDS_TEXT_SIZE - used, "%s", text);
}

static const board_facts_t *find(const char *name)
{
    for (size_t n = 0; board_facts[n] != NULL; n++) {
        if (strcmp(board_facts[n]->name, name) == 0) {
            return board_facts[n];
        }
    }
    return NULL;
}

/* The most similar name: the one with the longest common beginning, and among these the one with the fewest
 * edits. */
static const char *likest(const char *name)
{
    const char *best = "none";
    size_t best_same = 0, best_edits = SIZE_MAX;
    for (size_t n = 0; board_facts[n] != NULL; n++) {
        const char *other = board_facts[n]->name;
        size_t same = 0;
        while (name[same] != '\0' && name[same] == other[same]) {
            same++;
        }
        const size_t edits = names_distance(name, other);
        if (same > best_same || (same == best_same && edits < best_edits)) {
            best = other;
            best_same = same;
            best_edits = edits;
        }
    }
    return best;
}

const board_facts_t *boards_find(const char *name, char why[BOARDS_TEXT_SIZE])
{
    const board_facts_t *board = find(name);
    why[0] = '\0';
    if (board != NULL) {
        return board;
    }
    names_search_t search = names_search(name);
    for (size_t n = 0; board_facts[n] != NULL; n++) {
        names_consider(&search, board_facts[n]->name);
    }
    const char *near = names_found(&search) != NULL ? names_found(&search) : likest(name);
    snprintf(why, BOARDS_TEXT_SIZE, "no board is called %.64s; nearest: %s; accepted: ", name, near);
    for (size_t n = 0; board_facts[n] != NULL; n++) {
        append(why, n > 0u ? ", " : "");
        append(why, board_facts[n]->name);
    }
    return NULL;
}

bool boards_is_default(void)
{
    return board_facts[0] == NULL || strcmp(board_facts[0]->name, rig_board) == 0;
}

const char *boards_line(void)
{
    static _Thread_local char line[BOARDS_NAME_SIZE + 16u];
    snprintf(line, sizeof line, "board = \"%s\"\n", rig_board);
    return boards_is_default() ? "" : line;
}

bool boards_current_suits(const board_facts_t *board, const motor_t *motor)
{
    return LIMIT_SHARE * board->current_range >= CURRENT_SHARE * motor->value[MOTOR_CURRENT];
}

/* The link voltage that a motor file contains, else the one that the EMF needs at rated speed [V]; 0: not
 * known. */
static double link_of(const motor_t *motor)
{
    const double emf =
        motor->has[MOTOR_SPEED]
            ? SQRT_3 * motor->value[MOTOR_FLUX] * motor->value[MOTOR_POLE_PAIRS] * motor->value[MOTOR_SPEED]
            : 0.0;
    return motor->has[MOTOR_LINK] ? motor->value[MOTOR_LINK] : emf / VOLTAGE_USE;
}

bool boards_voltage_suits(const board_facts_t *board, const motor_t *motor)
{
    return LINK_SHARE * link_of(motor) <= board->overvoltage_max;
}

/* True if `a` is the better board for a motor that suits both. */
static bool is_closer(const board_facts_t *a, const board_facts_t *b)
{
    return b == NULL || a->overvoltage_max < b->overvoltage_max ||
           (a->overvoltage_max <= b->overvoltage_max && a->current_range < b->current_range);
}

const board_facts_t *boards_propose(const motor_t *motor)
{
    const board_facts_t *best = NULL;
    for (size_t n = 0; board_facts[n] != NULL; n++) {
        const board_facts_t *board = board_facts[n];
        if (boards_current_suits(board, motor) && boards_voltage_suits(board, motor) &&
            is_closer(board, best)) {
            best = board;
        }
    }
    return best;
}

const char *boards_unsuited(char to[BOARDS_TEXT_SIZE], const motor_t *motor)
{
    const board_facts_t *board = find(rig_board);
    char part[200];
    to[0] = '\0';
    if (board == NULL || (boards_current_suits(board, motor) && boards_voltage_suits(board, motor))) {
        return to;
    }
    if (!boards_current_suits(board, motor)) {
        snprintf(
            part, sizeof part,
            "the motor's rated current of %.4g A peak needs a limit of %.4g A, and board %s allows %.4g A",
            motor->value[MOTOR_CURRENT], CURRENT_SHARE * motor->value[MOTOR_CURRENT], board->name,
            LIMIT_SHARE * board->current_range);
        append(to, part);
    }
    if (!boards_voltage_suits(board, motor)) {
        snprintf(part, sizeof part,
                 "%sthe motor needs a link of %.4g V, and the largest trip of board %s is %.4g V",
                 to[0] != '\0' ? "; " : "", link_of(motor), board->name, board->overvoltage_max);
        append(to, part);
    }
    const board_facts_t *other = boards_propose(motor);
    snprintf(part, sizeof part, other != NULL ? "; --board %s suits" : "; no board of this program suits",
             other != NULL ? other->name : "");
    append(to, part);
    return to;
}

const board_facts_t *boards_present(void)
{
    return find(rig_board);
}

/* The medium task runs in the time that the interrupt leaves in each period. */
const char *boards_hurried(char to[BOARDS_TEXT_SIZE], const board_facts_t *board)
{
    const double interrupt = RIG_INTERRUPT_CYCLES / board->clock;
    const double medium = RIG_MEDIUM_CYCLES / board->clock;
    const double left = 1.0 - interrupt / board->period;
    const double most = (1.0 - medium / WINDOW) / interrupt;
    to[0] = '\0';
    if (left * WINDOW < medium) {
        snprintf(
            to, BOARDS_TEXT_SIZE,
            "board %s: at %.4g MHz the interrupt takes about %.3g us of each period of %.3g us, and the "
            "medium "
            "task needs %.3g us of the rest within %.3g us, more than is left: the drive would react half as "
            "often; choose a carrier up to %.3g kHz",
            board->name, board->clock / 1e6, 1e6 * interrupt, 1e6 * board->period, 1e6 * medium, 1e6 * WINDOW,
            most / 1e3);
    }
    return to;
}
