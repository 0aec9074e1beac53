#include "host_sim/cli/fault_table.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/json.h"
#include "host_sim/lab/units.h"
#include "host_sim/rig/rig.h"

const fault_row_t *fault_table_row(int32_t reason)
{
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        if (fault_rows[n].reason == reason) {
            return &fault_rows[n];
        }
    }
    return NULL;
}

/* NULL: the quantity is a condition. */
static const table_row_t *limit_of(const fault_row_t *row)
{
    return row->limit[0] != '\0' ? table_by_name(&params_table, row->limit) : NULL;
}

static double default_of(const fault_row_t *row)
{
    return rig_initial(limit_of(row)) + (double)row->margin;
}

const char *fault_table_condition(char to[FAULT_TABLE_TEXT_SIZE], const fault_row_t *row)
{
    if (limit_of(row) == NULL) {
        snprintf(to, FAULT_TABLE_TEXT_SIZE, "%s", row->quantity);
        return to;
    }
    char margin[32] = "";
    if (row->margin != 0.0f) {
        snprintf(margin, sizeof margin, " %c %g", row->margin < 0.0f ? '-' : '+', fabs((double)row->margin));
    }
    snprintf(to, FAULT_TABLE_TEXT_SIZE, "%s %s %s%s", row->quantity,
             strcmp(row->comparison, "ABOVE") == 0 ? ">" : "<", row->limit, margin);
    return to;
}

const char *fault_table_limit(char to[FAULT_TABLE_TEXT_SIZE], const fault_row_t *row)
{
    char text[UNITS_TEXT_SIZE] = "";
    if (limit_of(row) != NULL) {
        units_row_text(text, default_of(row), limit_of(row));
    }
    snprintf(to, FAULT_TABLE_TEXT_SIZE, "%s", text);
    return to;
}

static double debounce_ms(const fault_row_t *row)
{
    return row->debounce * RIG_PERIOD_SECONDS * 1e3;
}

const char *fault_table_debounce(char to[FAULT_TABLE_TEXT_SIZE], const fault_row_t *row)
{
    snprintf(to, FAULT_TABLE_TEXT_SIZE, "%" PRIu32 " period%s, %.6g ms", row->debounce,
             row->debounce == 1u ? "" : "s", debounce_ms(row));
    if (row->rate == FAULT_SLOW) {
        const size_t used = strlen(to);
        snprintf(to + used, FAULT_TABLE_TEXT_SIZE - used, ", judged every %u periods",
                 (unsigned)rig_window_periods);
    }
    return to;
}

/* By fault_when_t and by fault_reaction_t: names in JSON and in the printed table. */
typedef struct {
    const char *name, *text;
} word_t;

static const word_t moments[] = {
    [FAULT_ALWAYS] = {"ALWAYS", "always"},
    [FAULT_RUNNING] = {"RUNNING", "while the gates are commanded on"},
    [FAULT_ENCODER] = {"ENCODER", "while the gates are commanded on and control uses the encoder"},
    [FAULT_TRACKING] =
        {"TRACKING", "while the gates are commanded on and control uses the estimate, except in reversals"},
    [FAULT_SUPPLIED] = {"SUPPLIED", "while the gates are commanded on and no ride-through is active"},
};
static const word_t reactions[] = {
    [FAULT_WARN] = {"WARN", "shown in warnings while it holds"},
    [FAULT_CATCH] = {"CATCH", "the rotor is caught again; lost three times within 2 s, or in start_tries "
                              "consecutive runs of less than 0.5 s, it is a fault"},
    [FAULT_STOP] = {"STOP", "the motor is braked to standstill, then the bridge opens, the fault is latched"},
    [FAULT_OPEN] = {"OPEN", "the bridge opens, the fault is latched"},
};

const char *fault_table_when(const fault_row_t *row)
{
    return moments[row->when].text;
}

const char *fault_table_reaction(const fault_row_t *row)
{
    return reactions[row->reaction].text;
}

void fault_table_print_json(const fault_row_t *row)
{
    if (row == NULL) {
        printf("null");
        return;
    }
    const table_row_t *limit = limit_of(row);
    printf("{\"quantity\": \"%s\", \"comparison\": \"%s\", \"limit\": ", row->quantity, row->comparison);
    json_text(stdout, limit != NULL ? limit->name : NULL);
    printf(", \"margin\": ");
    json_number(stdout, (double)row->margin);
    printf(", \"default\": ");
    json_number(stdout, limit != NULL ? default_of(row) : (double)NAN);
    printf(", \"unit\": ");
    json_text(stdout, limit != NULL ? limit->unit : NULL);
    printf(", \"rate\": \"%s\", \"debounce_periods\": %" PRIu32 ", \"debounce_ms\": ",
           row->rate == FAULT_SLOW ? "SLOW" : "EACH", row->debounce);
    json_number(stdout, debounce_ms(row));
    printf(", \"when\": \"%s\", \"reaction\": \"%s\"}", moments[row->when].name,
           reactions[row->reaction].name);
}
