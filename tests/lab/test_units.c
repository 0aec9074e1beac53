/* Quantities as people write and read them. Expected values are literals of the number meant: the reading is
 * exact. */
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/units.h"
#include "host_sim/rig/rig.h"
#include "unity.h"

#define PI 3.14159265358979323846

static double value_of(const char *text, const char *unit)
{
    double value = (double)NAN;
    units_error_t why;
    TEST_ASSERT_TRUE_MESSAGE(units_read(text, unit, &value, &why), text);
    return value;
}

static void expect_exact(double expected, const char *text, const char *unit)
{
    TEST_ASSERT_TRUE_MESSAGE(value_of(text, unit) == expected, text);
}

static void expect_refused(const char *text, const char *unit, const char *part)
{
    double value = 42.0;
    units_error_t why = {""};
    TEST_ASSERT_FALSE_MESSAGE(units_read(text, unit, &value, &why), text);
    TEST_ASSERT_TRUE_MESSAGE(value == 42.0, "a refused text must not change the value");
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why.text, part), why.text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why.text, "accepted: "), why.text);
}

/* The prefix goes into the number's exponent, so the result is the very double that a compiler makes of the
 * literal. */
static void test_prefixes_are_exact(void)
{
    expect_exact(3e-6, "3 us", "s");
    expect_exact(2.5e-6, "2.5us", "s");
    expect_exact(0.7e-6, "0.7 us", "s");
    expect_exact(1e-9, "1 ns", "s");
    expect_exact(0.25, "250 mA", "A");
    expect_exact(12.5e-3, "12.5 mH", "H");
    expect_exact(0.0005, "0.5 mrad", "rad");
    expect_exact(0.183, "183 mWb", "Wb");
    expect_exact(0.003, "30 kg cm^2", "kg m^2");
    expect_exact(0.003, "30000 g cm^2", "kg m^2");
    expect_exact(470e-6, "470 uF", "F");
    expect_exact(0.95, "950 mohm", "ohm");
    expect_exact(1500.0, "1.5 kN m", "N m");
    expect_exact(0.3, "30 %", "-");
    expect_exact(0.3, "30%", "-");
}

static void test_every_form_of_a_number_is_read(void)
{
    expect_exact(-5.0, "-5 N m", "N m");
    expect_exact(5.0, "+5 N m", "N m");
    expect_exact(0.5, ".5 s", "s");
    expect_exact(5.0, "5. s", "s");
    expect_exact(1e-3, "1e-3 s", "s");
    expect_exact(1e-3, "1E-3s", "s");
    expect_exact(1000.0, "1e+3 V", "V");
    expect_exact(311.0, "  311   V  ", "V");
    expect_exact(0.1, "0.1000000000000000055511151231257827 s", "s");
    TEST_ASSERT_TRUE(signbit(value_of("-0 A", "A")));
}

static void test_spaces_inside_a_unit_are_optional(void)
{
    expect_exact(5.0, "5 Nm", "N m");
    expect_exact(5.0, "5N m", "N m");
    expect_exact(5.0, "5 N  m", "N m");
    expect_exact(0.2, "0.2 Nms/rad", "N m s/rad");
    expect_exact(0.5, "0.5 As/rad", "A s/rad");
}

static void test_factors_round_once(void)
{
    /* correctly rounded products of the correctly rounded factor */
    expect_exact(1500.0 * (PI / 30.0), "1500 r/min", UNITS_SPEED);
    expect_exact(1500.0 * (PI / 30.0), "1500 rpm", UNITS_SPEED);
    expect_exact(200.0 * (PI / 30.0), "200 r/min/s", UNITS_ACCELERATION);
    expect_exact(200.0 * (PI / 30.0), "200 rpm/s", UNITS_ACCELERATION);
    expect_exact(30.0 * (PI / 180.0), "30 deg", "rad");
    expect_exact(160.0 * (2.0 * PI), "160 Hz", "rad/s");
    expect_exact(120.0, "2 min", "s");
    expect_exact(90.0, "90 degC", "degC");
    expect_exact(1000.0, "1 krad/s", "rad/s");
}

static void test_other_writings_mean_the_same(void)
{
    expect_exact(3e-6, "3 \xC2\xB5s", "s"); /* micro sign */
    expect_exact(3e-6, "3 \xCE\xBCs", "s"); /* mu */
    expect_exact(0.95, "0.95 \xCE\xA9", "ohm");
    expect_exact(5.0, "5 N\xC2\xB7m", "N m");
    expect_exact(90.0,
                 "90 \xC2\xB0"
                 "C",
                 "degC");
    expect_exact(0.003, "0.003 kg m\xC2\xB2", "kg m^2");
    expect_exact(20.0, "20 rad/s\xC2\xB2", UNITS_ACCELERATION);
}

static void test_units_without_a_list_are_read_as_they_are_spelled(void)
{
    expect_exact(12.0, "12 periods", "periods");
    expect_exact(7.0, "7 counts", "counts");
    expect_refused("12 period", "periods", "accepted: a number with periods");
}

static void test_a_wrong_unit_is_refused_with_those_that_fit(void)
{
    expect_refused("5 kg", "N m",
                   "\"5 kg\" is not a quantity in N m; accepted: a number with N m, mN m, kN m");
    expect_refused("1500", UNITS_SPEED,
                   "\"1500\" has no unit; accepted: a number with rad/s, r/min, deg/s, rpm");
    expect_refused("200 r/min", UNITS_ACCELERATION,
                   "\"200 r/min\" is not a quantity in rad/s^2; accepted: a number with rad/s^2, r/min/s");
    expect_refused("5 ma", "A", "is not a quantity in A"); /* units tell upper from lower case */
    expect_refused("5 m s", "s", "is not a quantity in s");
    expect_refused("5 s s", "s", "is not a quantity in s");
    expect_refused("1 V", "-", "pure number");
    expect_refused("2 h", "s", "s, ms, us, ns, min");
}

static void test_a_text_without_a_number_is_refused(void)
{
    expect_refused("", "s", "does not begin with a number");
    expect_refused("s", "s", "does not begin with a number");
    expect_refused("- 5 s", "s", "does not begin with a number");
    expect_refused("nan s", "s", "does not begin with a number");
    expect_refused("inf s", "s", "does not begin with a number");
    expect_refused("0x10 s", "s", "is not a quantity in s");
    expect_refused("1,5 s", "s", "is not a quantity in s");
    expect_refused("1.5.2 s", "s", "is not a quantity in s");
    expect_refused("5 e3 s", "s", "is not a quantity in s");
}

static void test_numbers_beyond_a_double_are_refused(void)
{
    char text[600];
    expect_refused("1e400 s", "s", "is too large");
    expect_refused("1e999999999999999999999 s", "s", "is too large");
    expect_exact(0.0, "1e-999999999999999999999 s", "s");
    memset(text, '9', sizeof text);
    memcpy(text + sizeof text - 3u, " s", 3u);
    expect_refused(text, "s", "does not begin with a number");
    memset(text, '9', 300);
    memcpy(text + 300, " s", 3u);
    TEST_ASSERT_TRUE(value_of(text, "s") == 1e300); /* 300 nines: the double nearest to 10^300 */
}

/* r/min on an electrical speed would be wrong by the pole pairs. */
static void test_r_min_is_for_mechanical_speeds_only(void)
{
    expect_refused("1500 r/min", "rad/s", "accepted: a number with rad/s, krad/s, Hz, kHz");
    expect_refused("200 r/min/s", "rad/s^2", "accepted: a number with rad/s^2");
    expect_refused("25 Hz", UNITS_SPEED, "accepted: a number with rad/s, r/min, deg/s, rpm");
}

/* The rows that say "mechanical" in their text; a new one of that kind belongs into this list. */
static void test_mechanical_speeds_are_known_by_their_text(void)
{
    static const char *const mechanical[] = {"omega_m",        "omega_m_ref",        "true_omega_m",
                                             "speed_request",  "overspeed_trip",     "shaft_locked_speed",
                                             "start_speed",    "estimate_speed_min", "handover_speed",
                                             "fallback_speed", "load_table_speed"};
    unsigned found = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count; n++) {
            bool expected = false;
            for (size_t m = 0; m < sizeof mechanical / sizeof mechanical[0]; m++) {
                expected = expected || strcmp(mechanical[m], table->rows[n].name) == 0;
            }
            const bool is = strcmp(units_of_row(&table->rows[n]), UNITS_SPEED) == 0;
            TEST_ASSERT_EQUAL_INT_MESSAGE(expected, is, table->rows[n].name);
            found += is;
        }
    }
    TEST_ASSERT_EQUAL_UINT(sizeof mechanical / sizeof mechanical[0], found);
}

static void test_accelerations_are_mechanical(void)
{
    static const char *const rows[] = {"start_ramp", "speed_ramp", "quick_stop_ramp"};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        TEST_ASSERT_EQUAL_STRING(UNITS_ACCELERATION, units_of_row(rig_row_by_name(rows[n])));
    }
}

/* What a table says of itself must be readable. */
static void test_every_unit_of_every_table_reads_itself(void)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count; n++) {
            char text[64] = "2 ";
            const bool pure = strcmp(table->rows[n].unit, "-") == 0;
            strcat(text, pure ? "" : table->rows[n].unit);
            expect_exact(2.0, text, units_of_row(&table->rows[n]));
        }
    }
}

static void expect_text(const char *expected, double value, const char *unit)
{
    char text[UNITS_TEXT_SIZE];
    TEST_ASSERT_EQUAL_STRING(expected, units_text(text, value, unit));
}

static void test_values_are_written_in_the_unit_that_reads_best(void)
{
    expect_text("1500 r/min", 1500.0 * PI / 30.0, UNITS_SPEED);
    expect_text("0.1 r/min", 0.1 * PI / 30.0, UNITS_SPEED);
    expect_text("1000 rad/s", 1000.0, "rad/s");
    expect_text("20 rad/s^2", 20.0, UNITS_ACCELERATION);
    expect_text("2.5 us", 2.5e-6, "s");
    expect_text("100 us", 1e-4, "s");
    expect_text("2 s", 2.0, "s");
    expect_text("-12.3 mrad", -0.0123, "rad");
    expect_text("0 A", 0.0, "A");
    expect_text("999.9 mA", 0.9999, "A");
    expect_text("1 A", 0.99999999, "A");
    expect_text("0.0636 kg m^2", 0.0636, "kg m^2");
    expect_text("0.3", 0.3, "-");
    expect_text("30010 periods", 30010.0, "periods");
    expect_text("1e-12 A", 1e-15 * 1e3, "A");
}

static void test_values_that_are_no_number_are_written_as_such(void)
{
    expect_text("nan A", (double)NAN, "A");
    expect_text("-inf A", -(double)INFINITY, "A");
}

static void test_both_ends_of_a_range_have_one_unit(void)
{
    char text[UNITS_TEXT_SIZE];
    TEST_ASSERT_EQUAL_STRING("0.1 to 16 A", units_range_text(text, 0.1, 16.0, "A"));
    TEST_ASSERT_EQUAL_STRING("2 to 6 us", units_range_text(text, 2e-6, 6e-6, "s"));
    TEST_ASSERT_EQUAL_STRING("0 to 1.2", units_range_text(text, 0.0, 1.2, "-"));
}

/* Read again, in the unit that it is written in, each end is a 32-bit value of the range: for speeds, whose
 * factor is no decimal number, and for prefixes. */
static void test_ends_of_a_range_are_read_as_values_of_it(void)
{
    static const char *const units[] = {UNITS_SPEED, "rad/s", "s", "A", "H", "-", "kg m^2", "degC"};
    uint32_t state = 5u;
    for (int n = 0; n < 4000; n++) {
        float ends[2];
        for (int m = 0; m < 2; m++) {
            state = state * UINT32_C(1664525) + UINT32_C(1013904223);
            const float share = (float)(state >> 8) / 16777216.0f;
            state = state * UINT32_C(1664525) + UINT32_C(1013904223);
            ends[m] = (share - 0.3f) * powf(10.0f, (float)((int)(state >> 28) - 8));
        }
        const float min = fminf(ends[0], ends[1]);
        const float max = fmaxf(ends[0], ends[1]);
        const char *unit = units[n % 8];
        char text[UNITS_TEXT_SIZE];
        char low[UNITS_TEXT_SIZE * 2];
        units_range_text(text, (double)min, (double)max, unit);
        char *to = strstr(text, " to ");
        TEST_ASSERT_NOT_NULL(to);
        const char *high = to + 4;
        snprintf(low, sizeof low, "%.*s%s", (int)(to - text), text, high + strcspn(high, " "));
        double read[2];
        units_error_t why;
        TEST_ASSERT_TRUE_MESSAGE(units_read(low, unit, &read[0], &why), low);
        TEST_ASSERT_TRUE_MESSAGE(units_read(high, unit, &read[1], &why), high);
        for (int m = 0; m < 2; m++) {
            TEST_ASSERT_TRUE_MESSAGE((float)read[m] >= min && (float)read[m] <= max, text);
        }
        const double span = fmax(fabs((double)min), fabs((double)max));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5 * span, (double)min, read[0], text);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5 * span, (double)max, read[1], text);
    }
    char text[UNITS_TEXT_SIZE];
    TEST_ASSERT_EQUAL_STRING("9.5493 to 95492.97 r/min", units_range_text(text, 1.0, 1e4, UNITS_SPEED));
}

static void test_choices_are_written_by_name(void)
{
    char text[UNITS_TEXT_SIZE];
    const table_row_t *row = rig_row_by_name("enable");
    TEST_ASSERT_EQUAL_STRING("off", units_row_text(text, 0.0, row));
    TEST_ASSERT_EQUAL_STRING("quick_stop", units_row_text(text, 2.0, row));
    TEST_ASSERT_EQUAL_STRING("3", units_row_text(text, 3.0, row));
    TEST_ASSERT_EQUAL_STRING("0.5", units_row_text(text, 0.5, row));
    TEST_ASSERT_EQUAL_STRING("3 A", units_row_text(text, 3.0, rig_row_by_name("i_q")));
}

static void test_reading_does_not_depend_on_the_locale(void)
{
    static const char *const comma[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR.UTF-8", "fr_FR.utf8"};
    bool found = false;
    for (size_t n = 0; n < sizeof comma / sizeof comma[0] && !found; n++) {
        found = setlocale(LC_ALL, comma[n]) != NULL;
    }
    if (!found) {
        TEST_IGNORE_MESSAGE("no locale with a decimal comma on this machine");
    }
    expect_exact(2.5e-6, "2.5 us", "s");
    setlocale(LC_ALL, "C");
}
