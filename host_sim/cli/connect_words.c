/* Lines of `lagless connect`: words, rows, values, times. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/connect.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/names.h"
#include "host_sim/lab/scenario_parts.h"
#include "host_sim/lab/units.h"
#include "host_sim/rig/rig.h"

#define TIME_MAX    86400.0 /* [s] */
#define PAUSE_MAX   0.01    /* [s] of the host's clock from one query of the drive to the next */
#define PAUSE_SHORT 0.001   /* [s] the same, while its clock has not moved */
#define AHEAD       0.1     /* [s] of the drive's time, the same */
#define STAND_STILL                                                                                          \
    5.0 /* [s] of the host's clock: a drive whose clock has not advanced for this time is halted */

bool connect_fail(session_t *session, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(session->error.text, sizeof session->error.text, format, arguments);
    va_end(arguments);
    return false;
}

/* ---- rows ---- */

static bool in_drive(const table_t *table)
{
    master_extension_t extension;
    uint32_t address;
    return master_place(&table->rows[0], &extension, &address);
}

const table_row_t *connect_row(session_t *session, const char *name)
{
    const char *dot = strchr(name, '.');
    names_search_t search = names_search(dot != NULL ? dot + 1 : name);
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        if (!in_drive(table) || (dot != NULL && (strlen(table->name) != (size_t)(dot - name) ||
                                                 strncmp(table->name, name, (size_t)(dot - name)) != 0))) {
            continue;
        }
        const table_row_t *row = table_by_name(table, dot != NULL ? dot + 1 : name);
        if (row != NULL) {
            return row;
        }
        names_consider_table(&search, table);
    }
    const char *near = names_found(&search);
    if (rig_row_by_name(name) != NULL) {
        connect_fail(
            session,
            "%s: only the simulation has this row; a drive has parameters, requests, services and signals",
            name);
    } else {
        connect_fail(session, "%s: no such name%s%s; `params` and `signals` list them", name,
                     near != NULL ? "; did you mean " : "", near != NULL ? near : "");
    }
    return NULL;
}

uint32_t connect_rows(session_t *session, uint32_t count, char **words, const table_row_t **rows,
                      uint32_t room)
{
    uint32_t found = 0;
    for (uint32_t n = 0; n < count; n++) {
        char *rest = NULL;
        for (char *name = strtok_r(words[n], ",", &rest); name != NULL; name = strtok_r(NULL, ",", &rest)) {
            const table_row_t *row = connect_row(session, name);
            if (row == NULL) {
                return 0;
            }
            for (uint32_t before = 0; before < found; before++) {
                if (rows[before] == row) {
                    connect_fail(session, "%s: given twice; accepted: once", name);
                    return 0;
                }
            }
            if (found == room) {
                connect_fail(session, "%s: too many names; accepted: at most %u", name, (unsigned)room);
                return 0;
            }
            rows[found++] = row;
        }
    }
    if (found == 0u) {
        connect_fail(session, "a name is missing; `params` and `signals` list them");
    }
    return found;
}

/* ---- values ---- */

const char *connect_joined(char to[CONNECT_LINE], uint32_t count, char **words)
{
    size_t used = 0;
    to[0] = '\0';
    for (uint32_t n = 0; n < count && used < CONNECT_LINE; n++) {
        used += (size_t)snprintf(to + used, CONNECT_LINE - used, "%s%s", n != 0u ? " " : "", words[n]);
    }
    return to;
}

bool connect_value(session_t *session, const table_row_t *row, const char *text, double *value)
{
    const scenario_place_t nowhere = {0, 0};
    scenario_error_t error;
    units_error_t ignored;
    if (row->access == TABLE_READ) {
        return connect_fail(session, "%s: this value is read-only; `params` lists what can be set",
                            row->name);
    }
    if (text[0] == '\0') {
        return connect_fail(session, "%s: the value is missing; accepted: %s", row->name,
                            scenario_accepted(row).text);
    }
    const bool pure =
        row->kind != SLOT_ENUM && strchr(text, '%') == NULL && units_read(text, "-", value, &ignored);
    if ((!pure && !scenario_row_text_value(row, text, value, nowhere, &error)) ||
        !scenario_row_accepts(row, *value, nowhere, &error)) {
        return connect_fail(session, "%s: %s", row->name, error.message);
    }
    return true;
}

bool connect_time(session_t *session, const char *text, double *seconds)
{
    units_error_t why;
    if (!units_read(text, "-", seconds, &why) && !units_read(text, "s", seconds, &why)) {
        return connect_fail(session, "%s", why.text);
    }
    return (*seconds > 0.0 && *seconds <= TIME_MAX) ||
           connect_fail(session, "%s: accepted: times above 0, at most %g s", text, TIME_MAX);
}

static connect_clause_t *clause_of(const char *word, connect_clause_t *clauses, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        if (strcmp(clauses[n].key, word) == 0) {
            return &clauses[n];
        }
    }
    return NULL;
}

bool connect_clauses(session_t *session, uint32_t *count, char **words, connect_clause_t *clauses,
                     uint32_t clause_count)
{
    uint32_t kept = 0;
    connect_clause_t *now = NULL;
    uint32_t begin = 0;
    for (uint32_t n = 0; n <= *count; n++) {
        connect_clause_t *next = n < *count ? clause_of(words[n], clauses, clause_count) : NULL;
        if (now != NULL && (next != NULL || n == *count)) {
            connect_joined(now->value, n - begin, words + begin);
            if (now->value[0] == '\0') {
                return connect_fail(session, "%s: its value is missing", now->key);
            }
        }
        if (next != NULL) {
            if (next->given) {
                return connect_fail(session, "%s: given twice; accepted: once", next->key);
            }
            next->given = true;
            now = next;
            begin = n + 1u;
        } else if (now == NULL && n < *count) {
            words[kept++] = words[n];
        }
    }
    *count = kept;
    return true;
}

/* ---- the drive's values ---- */

bool connect_get_row(session_t *session, const table_row_t *row, double *value)
{
    return master_get(session->master, row, value, &session->error);
}

bool connect_get_named(session_t *session, const char *name, double *value)
{
    const table_row_t *row = connect_row(session, name);
    return row != NULL && connect_get_row(session, row, value);
}

bool connect_is(const char *row, double value, const char *choice)
{
    const table_row_t *found = rig_row_by_name(row);
    return found != NULL && value == (double)table_choice(found, choice);
}

void connect_json(const table_row_t *row, double value)
{
    printf(", ");
    json_text(stdout, row->name);
    printf(": ");
    if (row->kind == SLOT_ENUM) {
        char text[UNITS_TEXT_SIZE];
        json_text(stdout, units_row_text(text, value, row));
    } else {
        json_number(stdout, value);
    }
}

void connect_json_text(const char *key, const char *text)
{
    printf(", ");
    json_text(stdout, key);
    printf(": ");
    json_text(stdout, text);
}

/* ---- time ---- */

/* [s] until the next query of the drive: half of the remaining time, and AHEAD at most, at the present speed
 * of its clock. So a drive that runs faster than real time is queried in time, and its command timeout does
 * not expire. */
static double pause_of(double left, double passed, double elapsed)
{
    const double rate = fmax(passed / elapsed, 1.0);
    return fmin(PAUSE_MAX, fmin(0.5 * left, AHEAD) / rate);
}

bool connect_wait_for(session_t *session, double seconds, connect_until_t until, void *context, bool *met)
{
    const uint32_t wanted = rig_periods(seconds);
    double first;
    double now;
    uint32_t passed = 0;
    double looked = output_seconds();
    *met = false;
    if (!connect_get_named(session, "period", &first)) {
        return false;
    }
    for (;;) {
        if (until != NULL && (!until(session, context, met) || *met)) {
            return *met;
        }
        if (!connect_get_named(session, "period", &now)) {
            return false;
        }
        const uint32_t since = (uint32_t)now - (uint32_t)first;
        if (since >= wanted) {
            return true;
        }
        if (connect_stopped()) {
            return connect_fail(session, "interrupted");
        }
        const double elapsed = output_seconds() - looked;
        if (since == passed && elapsed > STAND_STILL) {
            return connect_fail(session, "the drive's time has stopped; a debugger may have halted it");
        }
        const double pause = since == passed ? PAUSE_SHORT
                                             : pause_of((wanted - since) * RIG_PERIOD_SECONDS,
                                                        (since - passed) * RIG_PERIOD_SECONDS, elapsed);
        looked = since == passed ? looked : output_seconds();
        passed = since;
        if (!master_wait(session->master, pause)) {
            return connect_fail(session, "%s: %s", master_name(session->master),
                                master_lost(session->master));
        }
    }
}

bool connect_look_staged(session_t *session, bool *staged)
{
    if (!master_staged(session->master, staged, &session->error)) {
        return false;
    }
    if (!*staged) {
        session->staged_count = 0;
        session->staged_set = NULL;
    }
    return true;
}
