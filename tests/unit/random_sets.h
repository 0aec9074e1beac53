/* Random bits, and random sets of parameters, for tests of memories. */
#ifndef TESTS_UNIT_RANDOM_SETS_H
#define TESTS_UNIT_RANDOM_SETS_H

#include "settings/params.h"
#include "tests/unit/compare.h"

static uint32_t noise;

static inline uint32_t random_bits(void)
{
    noise ^= noise << 13;
    noise ^= noise >> 17;
    noise ^= noise << 5;
    return noise;
}

/* Each parameter has any value in its range, including both ends. */
static inline params_t random_set(void)
{
    params_t set = {0};
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        const float share = (float)(random_bits() % 1001u) / 1000.0f;
        const float value = table_min(row) + share * (table_max(row) - table_min(row));
        if (row->kind == SLOT_FLOAT) {
            table_set(row, &set, fminf(value, table_max(row)));
        } else {
            table_set_whole(row, &set, (int64_t)fminf(value, table_max(row)));
        }
        TEST_ASSERT_TRUE(table_holds(row, &set));
    }
    return set;
}

static inline bool equal(const params_t *a, const params_t *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

#endif
