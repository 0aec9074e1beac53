/* Running statistics of samples in double: mean and deviation by Welford's recurrence (runner.h). All
 * statistics are updated with each sample, because selecting one costs as much. A sample that is NaN makes
 * all of them NaN. */
#ifndef HOST_SIM_LAB_TALLY_H
#define HOST_SIM_LAB_TALLY_H

#include <stdint.h>

#include "contract/table.h"
#include "host_sim/lab/scenario.h"

typedef struct {
    uint32_t count;
    double mean, squares_about, squares, min, max, last;
} tally_t;

tally_t tally_empty(void);
void tally_count(tally_t *tally, double x);

/* NAN: there was no sample. */
double tally_value(const tally_t *tally, statistic_t statistic);

/* Converts a slot of the tap to a number. */
double tally_number(uint32_t slot, slot_kind_t kind);

#endif
