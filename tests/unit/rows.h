/* Sets one or several parameters by name: "start_current=6 lag_compensation=printed". */
#ifndef TESTS_UNIT_ROWS_H
#define TESTS_UNIT_ROWS_H

#include <stdlib.h>

#include "settings/params.h"
#include "tests/unit/compare.h"

static inline const table_row_t *row_of(const char *name)
{
    const table_row_t *row = table_by_name(&params_table, name);
    TEST_ASSERT_NOT_NULL_MESSAGE(row, name);
    return row;
}

static inline void set_rows(params_t *set, const char *text)
{
    char words[400];
    TEST_ASSERT_TRUE(strlen(text) < sizeof words);
    strcpy(words, text);
    for (char *name = strtok(words, "="); name != NULL; name = strtok(NULL, "=")) {
        const table_row_t *row = row_of(name);
        const char *value = strtok(NULL, " ");
        const int32_t choice = row->kind == SLOT_ENUM ? table_choice(row, value) : -1;
        table_set(row, set, choice >= 0 ? (float)choice : (float)strtod(value, NULL));
    }
}

#endif
