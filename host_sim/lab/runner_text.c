/* Verdicts and unexpected ends of a run in words. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/runner.h"
#include "host_sim/lab/times.h"
#include "host_sim/lab/units.h"
#include "settings/reasons.h"

const char *runner_unexpected_text(const runner_result_t *result, char *to, size_t size)
{
    char when[TIMES_TEXT_SIZE];
    const reason_row_t *why = reason_by_number(result->not_on);
    to[0] = '\0';
    if (result->unexpected && result->fault_reason != 0) {
        const reason_row_t *fault = reason_by_number(result->fault_reason);
        snprintf(to, size, "fault %s at %s s, which no expectation names", fault != NULL ? fault->name : "?",
                 times_text(when, result->fault_period));
    } else if (result->unexpected && result->not_on != 0 && why != NULL) {
        snprintf(to, size, "the drive refuses `enable` with %s, which no expectation names", why->name);
    } else if (result->unexpected) {
        snprintf(to, size,
                 "the bridge is off although `enable` is on, without a refusal, which no expectation names");
    }
    return to;
}

/* Appends to a text of this size, and cuts it at the end. */
static void append(char *to, size_t size, const char *before, const char *text)
{
    const size_t used = strlen(to);
    snprintf(to + used, size - used, "%s%s", before, text);
}

/* Limits one per mille or more away from the value need four digits, nearer ones six. */
static int digits_of(const runner_verdict_t *verdict)
{
    const double limits[] = {verdict->expect->at_least, verdict->expect->at_most};
    for (size_t n = 0; n < sizeof limits / sizeof limits[0]; n++) {
        const double apart = fabs(verdict->value - limits[n]);
        if (isfinite(apart) && apart > 0.0 && apart < 1e-3 * fabs(limits[n])) {
            return 6;
        }
    }
    return 4;
}

/* "0.468106 mrad" with `digits` digits, but at least those before the point; a word is unchanged. */
static void shorten(char to[UNITS_TEXT_SIZE], int digits)
{
    char unit[UNITS_TEXT_SIZE], *end;
    const double number = strtod(to, &end);
    const int whole = fabs(number) >= 1.0 ? 1 + (int)log10(fabs(number)) : 0;
    if (end != to && isfinite(number)) {
        snprintf(unit, sizeof unit, "%s", end);
        snprintf(to, UNITS_TEXT_SIZE, "%.*g%.60s", whole > digits && whole <= 6 ? whole : digits, number,
                 unit);
    }
}

/* True if the row is the number of a reason, which is shown by its name. */
static bool is_reason(const table_row_t *row)
{
    return strcmp(row->name, "fault_reason") == 0 || strcmp(row->name, "refusal") == 0;
}

/* Writes a choice or a reason by its name, if the value of the statistic is one of the samples. */
static const char *value_text(char to[UNITS_TEXT_SIZE], double value, const runner_verdict_t *verdict)
{
    const scenario_expect_t *expect = verdict->expect;
    const bool picks = (expect->statistic == STATISTIC_MIN || expect->statistic == STATISTIC_MAX ||
                        expect->statistic == STATISTIC_LAST) &&
                       expect->minus == NULL;
    const reason_row_t *reason = picks && is_reason(expect->row) ? reason_by_number((int32_t)value) : NULL;
    if (reason != NULL) {
        snprintf(to, UNITS_TEXT_SIZE, "%s", reason->name);
    } else if (expect->row->kind == SLOT_ENUM) {
        picks ? units_row_text(to, value, expect->row) : units_text(to, value, "-");
    } else {
        units_row_text(to, value, expect->row);
        shorten(to, digits_of(verdict));
    }
    return to;
}

const char *runner_verdict_text(const runner_verdict_t *verdict, char *to, size_t size)
{
    const scenario_expect_t *expect = verdict->expect;
    char text[UNITS_TEXT_SIZE];
    char name[128];
    to[0] = '\0';
    if (expect->name[0] != '\0') {
        append(to, size, expect->name, ": ");
    }
    scenario_row_name(expect->row, name, sizeof name);
    append(to, size, statistic_text(expect->statistic), " of ");
    append(to, size, name, "");
    if (expect->minus != NULL) {
        scenario_row_name(expect->minus, name, sizeof name);
        append(to, size, " - ", name);
    }
    append(to, size, " from ", units_text(text, expect->from, "s"));
    append(to, size, " to ", units_text(text, expect->to, "s"));
    if (verdict->samples == 0u) {
        append(to, size, ": not reached", "");
    } else {
        append(to, size, ": ", value_text(text, verdict->value, verdict));
    }
    const bool none = is_reason(expect->row) && expect->at_most == 0.0; /* reasons are above 0 */
    const bool exact = none || expect->at_least == expect->at_most;
    if (none || isfinite(expect->at_least)) {
        append(to, size, exact ? ", exactly " : ", at least ",
               value_text(text, none ? 0.0 : expect->at_least, verdict));
    }
    if (isfinite(expect->at_most) && !exact) {
        append(to, size, ", at most ", value_text(text, expect->at_most, verdict));
    }
    append(to, size, verdict->never_on ? "; the drive never came on" : "", "");
    return to;
}
