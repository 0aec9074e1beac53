#include "contract/table.h"

#include "settings/params.h"
#include "settings/reasons.h"
#include "settings/requests.h"
#include "settings/signals.h"
#include "tests/unit/compare.h"

typedef struct {
    float f;
    int32_t i;
    uint32_t u;
    int32_t e;
} slots_t;

#define HUES "red|green|blue"

static const table_row_t rows[] = {
    {1, SLOT_FLOAT, TABLE_LIVE, offsetof(slots_t, f), "f", "V", "a float", "", 1.5f, -2.0f, 2.0f, {0, 0, 0}},
    {2, SLOT_INT, TABLE_LIVE, offsetof(slots_t, i), "i", "-", "signed", "", 0.0f, 0.0f, 0.0f, {-3, -5, 5}},
    {3, SLOT_UINT, TABLE_LIVE, offsetof(slots_t, u), "u", "-", "unsigned", "", 0.0f, 0.0f, 0.0f, {7, 0, 9}},
    {4, SLOT_ENUM, TABLE_LIVE, offsetof(slots_t, e), "e", "-", "hue", HUES, 0.0f, 0.0f, 0.0f, {1, 0, 0}},
};
static const table_t table = {"test", rows, 4};

static void test_defaults_reach_every_slot(void)
{
    slots_t slots;
    table_defaults(&table, &slots);
    TEST_ASSERT_EQUAL_FLOAT(1.5f, slots.f);
    TEST_ASSERT_EQUAL_INT32(-3, slots.i);
    TEST_ASSERT_EQUAL_UINT32(7, slots.u);
    TEST_ASSERT_EQUAL_INT32(1, slots.e);
}

/* A float has 24 bits: 2^24 + 1 and the ends of both integer types are not exact floats. */
static void test_whole_numbers_are_exact_to_their_last_bit(void)
{
    static const int64_t ints[] = {16777217, -16777217, INT32_MAX, INT32_MIN, 0};
    static const int64_t uints[] = {16777217, UINT32_MAX, INT64_C(2147483648), 0};
    slots_t slots;
    for (size_t n = 0; n < sizeof ints / sizeof ints[0]; n++) {
        table_set_whole(&rows[1], &slots, ints[n]);
        TEST_ASSERT_EQUAL_INT64(ints[n], table_whole(&rows[1], &slots));
        TEST_ASSERT_EQUAL_INT64(ints[n], slots.i);
    }
    for (size_t n = 0; n < sizeof uints / sizeof uints[0]; n++) {
        table_set_whole(&rows[2], &slots, uints[n]);
        TEST_ASSERT_EQUAL_INT64(uints[n], table_whole(&rows[2], &slots));
        TEST_ASSERT_EQUAL_UINT32((uint32_t)uints[n], slots.u);
    }
}

static void test_whole_limits_are_exact_and_so_are_defaults(void)
{
    table_row_t row = rows[1];
    const table_t one = {"one", &row, 1};
    slots_t slots;
    row.whole = (table_whole_t){16777217, -16777217, 16777219};
    table_defaults(&one, &slots);
    TEST_ASSERT_EQUAL_INT32(16777217, slots.i);
    TEST_ASSERT_TRUE(table_accepts_whole(&row, 16777219) && table_accepts_whole(&row, -16777217));
    TEST_ASSERT_FALSE(table_accepts_whole(&row, 16777220) || table_accepts_whole(&row, -16777218));
    TEST_ASSERT_FALSE(table_accepts_whole(&row, INT64_C(4294967296) + 5)); /* its lower 32 bits are 5 */
    slots.i = 16777220;
    TEST_ASSERT_FALSE(table_holds(&row, &slots));
    slots.i = 16777219;
    TEST_ASSERT_TRUE(table_holds(&row, &slots));
    slots.f = NAN;
    TEST_ASSERT_FALSE(table_holds(&rows[0], &slots));
}

/* A refusal reports its range in floats, which must be exact for the whole-number rows of the drive. */
static void test_whole_limits_of_the_drive_are_exact_as_floats(void)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        if (row->kind != SLOT_FLOAT) {
            TEST_ASSERT_TRUE_MESSAGE(row->whole.min >= -16777216 && table_whole_max(row) <= 16777216,
                                     row->name);
            TEST_ASSERT_EQUAL_INT32(row->whole.min, (int32_t)table_min(row));
            TEST_ASSERT_EQUAL_INT32(table_whole_max(row), (int32_t)table_max(row));
        }
    }
}

/* Values below, at and above each limit; values that are not numbers, not whole or not a choice. */
static void test_values_are_accepted_within_the_range_of_their_row(void)
{
    const struct {
        uint32_t row;
        float value;
        bool accepted;
    } cases[] = {{0, nextafterf(-2.0f, -3.0f), false},
                 {0, -2.0f, true},
                 {0, 2.0f, true},
                 {0, nextafterf(2.0f, 3.0f), false},
                 {0, NAN, false},
                 {0, INFINITY, false},
                 {1, 1.5f, false},
                 {1, 1.0f, true},
                 {3, 2.0f, true},
                 {3, 3.0f, false},
                 {3, -1.0f, false},
                 {3, 1.5f, false},
                 {3, NAN, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        TEST_ASSERT_EQUAL_MESSAGE(cases[n].accepted, table_accepts(&rows[cases[n].row], cases[n].value),
                                  rows[cases[n].row].name);
    }
}

static void test_choices_are_found_by_whole_name_and_bound_the_value(void)
{
    TEST_ASSERT_EQUAL_INT32(0, table_choice(&rows[3], "red"));
    TEST_ASSERT_EQUAL_INT32(2, table_choice(&rows[3], "blue"));
    TEST_ASSERT_EQUAL_INT32(-1, table_choice(&rows[3], "gree"));
    TEST_ASSERT_EQUAL_INT32(-1, table_choice(&rows[3], ""));
    TEST_ASSERT_EQUAL_FLOAT(2.0f, table_max(&rows[3]));
    TEST_ASSERT_EQUAL_FLOAT(9.0f, table_max(&rows[2]));
}

static void test_rows_are_found_by_id_and_name(void)
{
    TEST_ASSERT_EQUAL_PTR(&rows[2], table_by_id(&table, 3));
    TEST_ASSERT_NULL(table_by_id(&table, 5));
    TEST_ASSERT_EQUAL_PTR(&rows[3], table_by_name(&table, "e"));
    TEST_ASSERT_NULL(table_by_name(&table, "x"));
}

/* FNV-1a of the octets of each row: id (little-endian, four octets), kind, then name, unit and choices,
 * each ended by a zero octet. The descriptive text does not count, and a hash may begin with the value of
 * another one. */
static void test_hash_is_fnv_1a_of_all_that_gives_a_value_its_meaning(void)
{
    static const uint8_t octets[] =
        {0x04, 0x03, 0x02, 0x81, 0,   'f', 0,   'V', 0,   0, /* id 81020304h, float */
         2,    0,    0,    0,    1,   'i', 0,   '-', 0,   0,   3,   0,
         0,    0,    2,    'u',  0,   '-', 0,   0, /* int, uint */
         4,    0,    0,    0,    3,   'e', 0,   '-', 0,   'r', 'e', 'd',
         '|',  'g',  'r',  'e',  'e', 'n', '|', 'b', 'l', 'u', 'e', 0};
    table_row_t changed[4];
    const table_t other = {"test", changed, 4};
    memcpy(changed, rows, sizeof rows);
    changed[0].id = UINT32_C(0x81020304);
    uint32_t expected = 2166136261u;
    for (size_t n = 0; n < sizeof octets; n++) {
        expected = (expected ^ octets[n]) * 16777619u;
    }
    TEST_ASSERT_EQUAL_HEX32(expected, table_hash(&other, 0));
    TEST_ASSERT_NOT_EQUAL(expected, table_hash(&other, 1));
    changed[0].text = "other words";
    TEST_ASSERT_EQUAL_HEX32(expected, table_hash(&other, 0));
}

/* The contract of the tables: the properties on which other programs depend. */
static void test_ids_and_names_of_the_drive_are_unique_and_in_their_bands(void)
{
    const table_t *const tables[] = {&params_table, &requests_table, &signals_table};
    const uint32_t first[] = {1, 1000, 2000};
    for (size_t t = 0; t < 3; t++) {
        for (uint32_t n = 0; n < tables[t]->count; n++) {
            const table_row_t *row = &tables[t]->rows[n];
            TEST_ASSERT_TRUE_MESSAGE(row->id >= first[t] && row->id < (t == 0 ? 1000u : first[t] + 1000u),
                                     row->name);
            TEST_ASSERT_EQUAL_PTR_MESSAGE(row, table_by_id(tables[t], row->id), row->name);
            TEST_ASSERT_EQUAL_PTR_MESSAGE(row, table_by_name(tables[t], row->name), row->name);
            TEST_ASSERT_TRUE_MESSAGE(strlen(row->unit) > 0 && strlen(row->text) > 0, row->name);
            TEST_ASSERT_EQUAL_MESSAGE(row->kind == SLOT_ENUM, strlen(row->choices) > 0, row->name);
        }
    }
}

/* The numbers of the named values are those of the enumerations in the code. */
static void test_choices_of_the_drive_are_in_the_order_of_their_enumerations(void)
{
    static const struct {
        const char *row, *choice;
        int32_t value;
    } pairs[] = {
        {"position_source", "encoder", POSITION_ENCODER},
        {"position_source", "sensorless", POSITION_SENSORLESS},
        {"observer_switching", "sign", SMO_SIGN},
        {"observer_switching", "sigmoid", SMO_SIGMOID},
        {"observer_switching", "sigmoid_vector", SMO_SIGMOID_VECTOR},
        {"lag_compensation", "none", LAG_NONE},
        {"lag_compensation", "printed", LAG_PRINTED},
        {"lag_compensation", "corrected", LAG_CORRECTED},
        {"lag_compensation", "exact", LAG_EXACT},
    };
    for (size_t n = 0; n < sizeof pairs / sizeof pairs[0]; n++) {
        const table_row_t *row = table_by_name(&params_table, pairs[n].row);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(pairs[n].value, table_choice(row, pairs[n].choice), pairs[n].choice);
    }
    TEST_ASSERT_EQUAL_FLOAT(1.0f, table_max(table_by_name(&params_table, "position_source")));
    TEST_ASSERT_EQUAL_FLOAT(2.0f, table_max(table_by_name(&params_table, "observer_switching")));
    TEST_ASSERT_EQUAL_FLOAT(3.0f, table_max(table_by_name(&params_table, "lag_compensation")));
}

static void test_every_reason_has_a_unique_number_a_name_a_text_and_a_remedy(void)
{
    for (uint32_t n = 0; n < reasons_count; n++) {
        TEST_ASSERT_EQUAL_PTR(&reasons[n], reason_by_number(reasons[n].number));
        TEST_ASSERT_TRUE(strlen(reasons[n].name) > 0 && strlen(reasons[n].text) > 0 &&
                         strlen(reasons[n].remedy) > 0);
    }
    TEST_ASSERT_NULL(reason_by_number(9999));
    TEST_ASSERT_EQUAL_STRING("overcurrent", reason_by_number(REASON_OVERCURRENT)->name);
}
