/* Cells: their list, the selection, their names, and the judgement. */
#include "host_sim/lab/matrix.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/course.h"
#include "host_sim/lab/matrix_table.h"
#include "host_sim/lab/promised.h"
#include "host_sim/rig/rig.h"
#include "settings/faults.h"
#include "settings/reasons.h"

#define NOTICED_MOST 1.0 /* [s] */
#define HALF         0.5
#define PI           3.14159265358979323846
/* [r/min] ... by this; the bare rotor by the speed that it gains with 5 A in the 20 ms until a fault is
 * detected. */
#define AWAY_HEAVY 100.0
#define AWAY_LIGHT 400.0
#define SLOW_RPM   300.0 /* [r/min] */
#define AWAY       1.2   /* [-] of its previous or requested speed: a rotor driven away is faster ... */
/* ---- names ---- */

static const char *bit_name(const char *const *names, uint32_t count, uint32_t bit)
{
    for (uint32_t n = 0; n < count; n++) {
        if (bit == 1u << n) {
            return names[n];
        }
    }
    return "-";
}

const char *matrix_reaction_name(uint32_t reaction)
{
    static const char *const names[MATRIX_REACTIONS] = {"rides",   "warns", "catches",
                                                        "refuses", "stops", "opens"};
    return bit_name(names, MATRIX_REACTIONS, reaction);
}

const char *matrix_rotor_name(uint32_t rotor)
{
    static const char *const names[MATRIX_ROTORS] = {"follows", "strays", "coasts", "stands"};
    return bit_name(names, MATRIX_ROTORS, rotor);
}

const char *matrix_kind_name(uint32_t kind)
{
    static const char *const names[MATRIX_KINDS] = {"reaction", "reason", "time",
                                                    "current",  "rotor",  "profile"};
    return bit_name(names, MATRIX_KINDS, kind);
}

const char *matrix_set_text(char to[MATRIX_NAME_SIZE], uint32_t set, const char *(*name)(uint32_t))
{
    size_t length = 0;
    to[0] = '\0';
    for (uint32_t bit = 1u; bit <= set && length < MATRIX_NAME_SIZE; bit <<= 1) {
        if ((set & bit) != 0u) {
            length += (size_t)snprintf(to + length, MATRIX_NAME_SIZE - length, "%s%s",
                                       length > 0u ? " or " : "", name(bit));
        }
    }
    return to;
}

const char *matrix_source_name(uint32_t place)
{
    return (1u << place & (MATRIX_ENCODER_H | MATRIX_ENCODER_L)) != 0u ? "encoder" : "sensorless";
}

const char *matrix_shaft_name(uint32_t place)
{
    return (1u << place & (MATRIX_ENCODER_H | MATRIX_SENSORLESS_H)) != 0u ? "h" : "l";
}

const char *const matrix_scenario = "scenario";

const char *matrix_cell_name(char to[MATRIX_NAME_SIZE], const matrix_cell_t *cell)
{
    if (cell->user != NULL) {
        snprintf(to, MATRIX_NAME_SIZE, "%s/%s/%s", matrix_faults[cell->fault].name, matrix_scenario,
                 matrix_source_name(cell->place));
    } else {
        snprintf(to, MATRIX_NAME_SIZE, "%s/%s/%s/%s", matrix_faults[cell->fault].name,
                 matrix_manoeuvres[cell->manoeuvre].name, matrix_source_name(cell->place),
                 matrix_shaft_name(cell->place));
    }
    return to;
}

/* ---- which cells ---- */

static bool with_encoder(uint32_t place)
{
    return (1u << place & (MATRIX_ENCODER_H | MATRIX_ENCODER_L)) != 0u;
}

static const matrix_promise_t *promise_of(const matrix_cell_t *cell)
{
    const matrix_promise_t *promise = NULL;
    for (size_t n = 0; n < matrix_promise_count; n++) {
        const matrix_promise_t *row = &matrix_promises[n];
        if (row->fault == cell->fault && (row->manoeuvres >> cell->manoeuvre & 1u) != 0u &&
            (row->places >> cell->place & 1u) != 0u) {
            promise = row;
        }
    }
    return promise;
}

const char *matrix_never(const matrix_cell_t *cell)
{
    const char *missing = matrix_manoeuvres[cell->manoeuvre].missing;
    return with_encoder(cell->place) && missing != NULL ? missing : cell->promise->because;
}

static const char *why_not_yet(const matrix_cell_t *cell)
{
    char name[MATRIX_NAME_SIZE];
    matrix_cell_name(name, cell);
    const matrix_not_yet_t *row = matrix_not_yet;
    while (row->cell != NULL && strcmp(row->cell, name) != 0) {
        row++;
    }
    return row->because;
}

bool matrix_surprises(const matrix_cell_t *cell)
{
    return cell->occurs && (cell->red != 0u) != (cell->not_yet != NULL);
}

/* A number from 0 to 1 that depends only on the seed and the cell (splitmix64). */
static double draw(uint64_t seed, uint64_t cell)
{
    uint64_t z = (seed * UINT64_C(0x9E3779B97F4A7C15)) ^ (cell + 1u) * UINT64_C(0xD1B54A32D192ED03);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return (double)((z ^ z >> 31) >> 11) / 9007199254740992.0;
}

/* True if the cell has this name, or belongs to it. */
static bool is_below(const char *name, const char *part)
{
    const size_t length = strlen(part);
    return strncmp(name, part, length) == 0 &&
           (name[length] == '\0' || name[length] == '/' || (length > 0u && part[length - 1u] == '/'));
}

static bool chosen(const matrix_choice_t *choice, const matrix_cell_t *cell, size_t number)
{
    char name[MATRIX_NAME_SIZE];
    matrix_cell_name(name, cell);
    return (choice->only == NULL || strcmp(choice->only, matrix_faults[cell->fault].name) == 0) &&
           (choice->cell == NULL || is_below(name, choice->cell)) &&
           (choice->share == 0.0 || (cell->occurs && draw(choice->seed, number) < choice->share));
}

size_t matrix_size(void)
{
    return matrix_fault_count * matrix_manoeuvre_count * MATRIX_PLACES;
}

size_t matrix_lay_out(const matrix_choice_t *choice, matrix_cell_t *cells)
{
    size_t count = 0;
    for (size_t number = 0; number < matrix_size(); number++) {
        matrix_cell_t cell = {
            .fault = (uint32_t)(number / (matrix_manoeuvre_count * MATRIX_PLACES)),
            .manoeuvre = (uint32_t)(number / MATRIX_PLACES % matrix_manoeuvre_count),
            .place = (uint32_t)(number % MATRIX_PLACES),
            .within = (double)NAN,
        };
        cell.promise = promise_of(&cell);
        cell.occurs = cell.promise != NULL && cell.promise->reactions != 0u &&
                      !(with_encoder(cell.place) && matrix_manoeuvres[cell.manoeuvre].missing != NULL);
        cell.not_yet = why_not_yet(&cell);
        if (chosen(choice, &cell, number)) {
            cells[count++] = cell;
        }
    }
    return count;
}

/* ---- of a scenario ---- */

/* The state of the drive at this time: the cell that all faults share; false: `error`. */
static bool stands_at(const matrix_user_t *user, matrix_cell_t *cell, scenario_error_t *error)
{
    course_t course = {0};
    rig_t *rig = rig_create(user->scenario->seed);
    bool good = rig != NULL && course_init(&course, user->scenario, rig);
    const char *why = good ? NULL : "not enough memory";
    good = good && course_start(&course, error) &&
           course_run(&course, 0u, rig_periods(user->at), error) != COURSE_NEVER;
    if (good) {
        const table_row_t *state = rig_row_by_name("state");
        const bool sensorless = rig_value(rig, "position_source") != 0.0;
        const bool slow = fabs(rig_value(rig, "true_omega_m")) < SLOW_RPM * RPM;
        *cell = (matrix_cell_t){
            .user = user,
            .manoeuvre = slow ? MATRIX_AT_RUN_SLOW : MATRIX_AT_RUN_FAST,
            .place = sensorless ? 2u : 0u,
            .within = (double)NAN,
        };
        if ((int32_t)rig_value(rig, "state") != table_choice(state, "operation_enabled")) {
            why = "the drive is not on at that time; accepted: a time at which it is";
        } else if (rig_value(rig, "manoeuvre") != table_choice(rig_row_by_name("manoeuvre"), "run")) {
            why =
                "the drive does not run yet at that time (it starts, catches or is forced); accepted: a time "
                "at which it does";
        }
    }
    if (why != NULL) {
        good = false;
        snprintf(error->message, sizeof error->message, "%s", why);
    }
    course_free(&course);
    rig_free(rig);
    return good;
}

size_t matrix_around(const matrix_user_t *user, const char *only, matrix_cell_t *cells, bool *good,
                     scenario_error_t *error)
{
    matrix_cell_t like;
    size_t count = 0;
    *good = stands_at(user, &like, error);
    for (uint32_t n = 0; n < matrix_fault_count && *good; n++) {
        matrix_cell_t cell = like;
        cell.fault = n;
        cell.promise = promise_of(&cell);
        cell.occurs = cell.promise != NULL && cell.promise->reactions != 0u;
        if (!matrix_faults[n].from_start && (only == NULL || strcmp(only, matrix_faults[n].name) == 0)) {
            cells[count++] = cell;
        }
    }
    return count;
}

double matrix_current(const matrix_cell_t *cell)
{
    const table_row_t *trip = rig_row_by_name("overcurrent_trip");
    return cell->user == NULL ? cell->promise->current
                              : cell->promise->current * scenario_initial(cell->user->scenario, trip) /
                                    matrix_standard("overcurrent_trip");
}

/* ---- judgement ---- */

double matrix_noticed(double omega_e, double hidden)
{
    const double turn = 2.0 * PI / fmax(fabs(omega_e), 1e-3);
    return fmin(hidden * turn + fmax(PROMISED_NOTICE, PROMISED_TURN * turn), NOTICED_MOST);
}

bool matrix_accepts(const char *accepted, int32_t reason)
{
    const reason_row_t *row = reason_by_number(reason);
    for (const char *rest = accepted; row != NULL && *rest != '\0';) {
        const size_t length = strcspn(rest, " ");
        if (strlen(row->name) == length && strncmp(rest, row->name, length) == 0) {
            return true;
        }
        rest += length + strspn(rest + length, " ");
    }
    return false;
}

/* True if all warnings are among the reasons. */
static bool warned_of(const char *accepted, uint64_t warnings)
{
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        if ((warnings >> n & 1u) != 0u && !matrix_accepts(accepted, fault_rows[n].reason)) {
            return false;
        }
    }
    return true;
}

/* True if the reason is a promised one. RIDES and CATCHES need no reason, but no other warning may occur. */
static bool right_reason(const matrix_cell_t *cell)
{
    const matrix_seen_t *seen = &cell->seen;
    if ((seen->reaction & (MATRIX_REFUSES | MATRIX_STOPS | MATRIX_OPENS)) != 0u) {
        return matrix_accepts(cell->promise->reasons, seen->reason);
    }
    return seen->reaction != MATRIX_WARNS || warned_of(cell->promise->reasons, seen->warnings);
}

void matrix_judge(matrix_cell_t *cell)
{
    const matrix_promise_t *promise = cell->promise;
    const matrix_seen_t *seen = &cell->seen;
    const double asked = fmax(fabs(seen->started), fabs(seen->reference));
    const bool is_light = (1u << cell->place & (MATRIX_ENCODER_L | MATRIX_SENSORLESS_L)) != 0u;
    const double away = AWAY * asked + (is_light ? AWAY_LIGHT : AWAY_HEAVY) * RPM;
    const bool timed = seen->reaction != MATRIX_RIDES && !isnan(promise->within);
    cell->within = promise->within == MATRIX_NOTICED         ? matrix_noticed(seen->turning, 0.0)
                   : promise->within == MATRIX_NOTICED_LATER ? matrix_noticed(seen->turning, HALF)
                                                             : promise->within;
    cell->red = 0u;
    if ((seen->reaction & promise->reactions) == 0u) {
        cell->red |= MATRIX_BY_REACTION;
    } else if (!right_reason(cell)) {
        cell->red |= MATRIX_BY_REASON;
    }
    if (timed && !(seen->noticed <= cell->within)) {
        cell->red |= MATRIX_BY_TIME;
    }
    if (!(seen->current <= matrix_current(cell))) {
        cell->red |= MATRIX_BY_CURRENT;
    }
    if ((seen->rotor & promise->rotor) == 0u || seen->fastest > away) {
        cell->red |= MATRIX_BY_ROTOR;
    }
}
