/* Limits of the fault table from a set of parameters. */
#include "guard/guard.h"

float guard_limit(const fault_row_t *row, const params_t *params)
{
    const table_row_t *limit = table_by_name(&params_table, row->limit);
    return row->margin + (limit != NULL ? table_get(limit, params) : 0.0f);
}

#define PREPARE_ABOVE(NAME) tuning.limit[FAULT_LIMIT_##NAME] = guard_limit(&fault_rows[FAULT_##NAME], params);
#define PREPARE_BELOW(NAME) PREPARE_ABOVE(NAME)
#define PREPARE_HOLDS(NAME)

guard_tuning_t guard_prepare(const params_t *params)
{
#define FAULT_PREPARED(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,    \
                       reaction, text, remedy)                                                               \
    PREPARE_##comparison(NAME)
    guard_tuning_t tuning;
    DRIVE_FAULTS(FAULT_PREPARED)
#undef FAULT_PREPARED
    return tuning;
}
