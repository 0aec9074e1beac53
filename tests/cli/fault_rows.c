/* Prints the fault table and the limits that the guard derives from the default parameters, one row per
 * line with tabs between the columns. test_cli.py compares the text of `lagless explain` with this output. */
#include <inttypes.h>
#include <stdio.h>

#include "guard/guard.h"
#include "hal/board.h"

/* The names in the order of fault_when_t and fault_reaction_t. */
static const char *const moments[] = {"ALWAYS", "RUNNING", "ENCODER", "TRACKING", "SUPPLIED"};
static const char *const reactions[] = {"WARN", "CATCH", "STOP", "OPEN"};

int main(void)
{
    params_t params;
    params_defaults(&params);
    for (uint32_t n = 0; n < (uint32_t)FAULTS; n++) {
        const fault_row_t *row = &fault_rows[n];
        const table_row_t *limit = table_by_name(&params_table, row->limit);
        printf("%" PRId32 "\t%s\t%s\t%s\t%s\t%.9g\t%.9g\t%s\t%" PRIu32 "\t%.9g\t%s\t%s\t%s\n", row->reason,
               row->name, row->quantity, row->comparison, row->limit, (double)row->margin,
               (double)guard_limit(row, &params), limit != NULL ? limit->unit : "", row->debounce,
               row->debounce * 1e3 * BOARD_PERIOD_CYCLES / (double)BOARD_SYSCLK_HZ, moments[row->when],
               reactions[row->reaction], row->rate == FAULT_SLOW ? "SLOW" : "EACH");
    }
    return 0;
}
