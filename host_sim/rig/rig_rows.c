/* Numbers of a row in the simulation, in double, which represents numbers of every kind exactly; and ranges
 * as text, whose ends are accepted as an input. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host_sim/rig/rig_parts.h"

double rig_initial(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT ? (double)row->initial : (double)row->whole.initial;
}

double rig_initial_named(const char *name)
{
    return rig_initial(rig_row_by_name(name));
}

double rig_min(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT ? (double)row->min : (double)row->whole.min;
}

double rig_max(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT ? (double)row->max : (double)table_whole_max(row);
}

bool rig_accepts(const table_row_t *row, double value)
{
    if (row->kind == SLOT_FLOAT) {
        return fabs(value) <= 3.4e38 && table_accepts(row, (float)value);
    }
    return value >= rig_min(row) && value <= rig_max(row) && value == floor(value);
}

double rig_row_get(const table_row_t *row, const void *base)
{
    return row->kind == SLOT_FLOAT ? (double)table_get(row, base) : (double)table_whole(row, base);
}

void rig_row_put(const table_row_t *row, void *base, double value)
{
    if (row->kind == SLOT_FLOAT) {
        table_set(row, base, (float)value);
    } else {
        table_set_whole(row, base, (int64_t)value);
    }
}

const char *rig_value_text(char to[RIG_NUMBER_SIZE], double value)
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(to, RIG_NUMBER_SIZE, "%.*g", digits, value);
        if ((float)strtod(to, NULL) == (float)value) {
            break;
        }
    }
    return to;
}

/* One end of a range or a value in it, with as few digits as possible, and rounded into the range. */
static void end_text(char to[RIG_NUMBER_SIZE], double end, double min, double max, int least_digits)
{
    const double slot = (double)(float)end;
    const double inside = slot < min   ? (double)nextafterf((float)end, INFINITY)
                          : slot > max ? (double)nextafterf((float)end, -INFINITY)
                                       : end;
    for (int digits = least_digits; digits <= 17; digits++) {
        snprintf(to, RIG_NUMBER_SIZE, "%.*g", digits, inside);
        const double read = (double)(float)strtod(to, NULL);
        if (read >= min && read <= max) {
            break;
        }
    }
}

const char *rig_range_text(char to[RIG_RANGE_SIZE], const table_row_t *row, double min, double max)
{
    char ends[2][RIG_NUMBER_SIZE];
    if (!(min <= max)) {
        snprintf(to, RIG_RANGE_SIZE, "none");
        return to;
    }
    end_text(ends[0], min, min, max, 6);
    end_text(ends[1], max, min, max, 6);
    const bool pure = row->unit[0] == '-' && row->unit[1] == '\0';
    snprintf(to, RIG_RANGE_SIZE, "%s%s to %s%s%.24s", row->kind == SLOT_FLOAT ? "" : "whole numbers ",
             ends[0], ends[1], pure ? "" : " ", pure ? "" : row->unit);
    return to;
}

const char *rig_advice_text(char to[RIG_NUMBER_SIZE], double advice, double min, double max)
{
    end_text(to, advice, min, max, 4);
    return to;
}
