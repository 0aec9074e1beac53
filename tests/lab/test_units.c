/* Quantities as text. The expected values are literals of the same number, because the conversion is
 * exact. */
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/units.h"
#include "host_sim/rig/rig.h"
#include "unity.h"

#define PI  3.14159265358979323846
#define RPM (2.0 * PI / 60.0)      /* [rad/s] */
#define LBF (0.45359237 * 9.80665) /* [N] weight of a pound */

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

static void expect_near(double expected, const char *text, const char *unit)
{
    TEST_ASSERT_TRUE_MESSAGE(fabs(value_of(text, unit) - expected) <= 1e-12 * fabs(expected), text);
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

/* A prefix changes the exponent of the number, so that the result is exactly the double of the literal in
 * a compiler. A factor is rounded once, and the product once more. */
static void test_values_are_exact(void)
{
    static const struct {
        double value;
        const char *text, *unit;
    } rows[] = {
        {3e-6, "3 us", "s"},
        {0.7e-6, "0.7us", "s"},
        {1e-9, "1 ns", "s"},
        {0.25, "250 mA", "A"},
        {0.183, "183 mWb", "Wb"},
        {0.003, "30000 g cm^2", "kg m^2"},
        {1500.0, "1.5 kN m", "N m"},
        {0.3, "30 %", "-"},
        /* forms of numbers */
        {-5.0, "-5 N m", "N m"},
        {5.0, "+5 N m", "N m"},
        {0.5, ".5 s", "s"},
        {5.0, "5. s", "s"},
        {1e-3, "1E-3s", "s"},
        {1000.0, "1e+3 V", "V"},
        {311.0, "  311   V  ", "V"},
        {0.1, "0.1000000000000000055511151231257827 s", "s"},
        {0.0, "1e-999999999999999999999 s", "s"},
        /* units with a factor */
        {1500.0 * (PI / 30.0), "1500 r/min", UNITS_SPEED},
        {200.0 * (PI / 30.0), "200 rpm/s", UNITS_ACCELERATION},
        {30.0 * (PI / 180.0), "30 deg", "rad"},
        {160.0 * (2.0 * PI), "160 Hz", "rad/s"},
        {120.0, "2 min", "s"},
        {1000.0, "1 krad/s", "rad/s"},
        /* units without alternatives are read as they are spelled */
        {12.0, "12 periods", "periods"},
        {5.0, "5 N  m", "N m"},
        {0.2, "0.2 Nms/rad", "N m s/rad"},
        {20.0, "20 rad/s\xC2\xB2", UNITS_ACCELERATION},
        {90.0, "90 degC", "degC"},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        expect_exact(rows[n].value, rows[n].text, rows[n].unit);
    }
    TEST_ASSERT_TRUE(signbit(value_of("-0 A", "A")));
}

/* The units as data sheets spell them. Every value follows from the definition of the unit and not from
 * the table of the program. */
static void test_each_spelling_of_a_unit_is_that_unit(void)
{
    static const struct {
        double value;
        const char *number, *unit;
        const char *spellings[12];
    } rows[] = {
        {6e-3, "6000 ", "H", {"uH", "\xC2\xB5H", "\xCE\xBCH"}},
        {6e-3, "6000 ", "rad", {"urad", "\xC2\xB5rad", "\xCE\xBCrad"}},
        {1500.0, "1.5 k", "ohm", {"ohm", "Ohm", "OHM", "ohms", "\xCE\xA9", "\xE2\x84\xA6"}},
        {2e-3,
         "2 m",
         "N m/A",
         {"N m/A", "Nm/A", "N.m/A", "N-m/A", "N\xC2\xB7m/A", "N\xE2\x8B\x85m/A", "N*m/A", "N\xC2\xA0m/A",
          "N \xC2\xB7 m/A"}},
        {3e-4, "3 ", "kg m^2", {"kg cm^2", "kgcm2", "kg.cm\xC2\xB2"}},
        {2.0, "2 ", "Wb", {"V s", "Vs", "V\xC2\xB7s"}},
        {3000.0 * RPM,
         "3000 ",
         UNITS_SPEED,
         {"r/min", "rpm", "RPM", "Rpm", "1/min", "min^-1", "min-1", "rev/min", "U/min", "r / min",
          "min\xE2\x81\xBB\xC2\xB9"}},
        {3000.0 * RPM, "3000", UNITS_SPEED, {"r/min", "rpm", "min^-1"}},
        {45.0,
         "45 ",
         "V/krpm",
         {"V/krpm", "V/kRPM", "V/1000 r/min", "V/1000r/min", "V/(1000 r/min)", "V/1000 rpm", "V/1000 min^-1",
          "V/1000 min-1", "V / 1000 RPM", "mV/rpm", "mV/min^-1", "mV\xC2\xB7min"}},
        {0.5 * 1000.0 * RPM, "0.5 ", "V/krpm", {"V s/rad", "V\xC2\xB7s/rad"}},
        {200.0, "200 ", "rpm/V", {"min^-1/V", "RPM/V"}},
        {LBF * 0.0254, "1 ", "N m", {"lb-in"}},
        {LBF * 0.0254 / 16.0, "1 ", "N m/A", {"oz\xC2\xB7in/A"}},
        {LBF * 0.0254 / 16.0, "1 ", "kg m^2", {"oz-in-s^2"}},
        {130.0, "130 ", "degC", {"\xC2\xB0\x43", "deg C"}},
        {PI / 6.0, "30", "rad", {"\xC2\xB0"}},
        {4.0 * PI / 180.0, "4 ", UNITS_ACCELERATION, {"\xC2\xB0/s\xC2\xB2"}},
        {12.0, "12 ", UNITS_SPEED, {"rad\xC2\xB7s^-1"}},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        for (size_t k = 0; k < 12u && rows[n].spellings[k] != NULL; k++) {
            char text[60];
            snprintf(text, sizeof text, "%s%s", rows[n].number, rows[n].spellings[k]);
            expect_near(rows[n].value, text, rows[n].unit);
        }
    }
}

static void test_what_is_not_a_quantity_is_refused_with_what_would_be(void)
{
    static const struct {
        const char *text, *unit, *part;
    } rows[] = {
        {"5 kg", "N m", "quantity in N m; accepted: a number with N m, mN m, kN m"},
        {"1500", UNITS_SPEED, "\"1500\" has no unit; accepted: a number with rad/s, r/min, deg/s, rpm"},
        {"200 r/min", UNITS_ACCELERATION, "quantity in rad/s^2; accepted: a number with rad/s^2, r/min/s"},
        {"5 ma", "A", "quantity in A"}, /* upper and lower case of a unit differ */
        {"5 m s", "s", "quantity in s"},
        {"5 s s", "s", "quantity in s"},
        {"1 V", "-", "pure number"},
        {"2 h", "s", "s, ms, us, ns, min"},
        {"12 period", "periods", "accepted: a number with periods"},
        {"", "s", "does not begin with a number"},
        {"s", "s", "does not begin with a number"},
        {"- 5 s", "s", "does not begin with a number"},
        {"nan s", "s", "does not begin with a number"},
        {"inf s", "s", "does not begin with a number"},
        {"0x10 s", "s", "quantity in s"},
        {"1,5 s", "s", "quantity in s"},
        {"1.5.2 s", "s", "quantity in s"},
        {"5 e3 s", "s", "quantity in s"},
        {"1e400 s", "s", "is too large"},
        {"1e999999999999999999999 s", "s", "is too large"},
        /* r/min would be wrong by the number of pole pairs for an electrical speed */
        {"1500 r/min", "rad/s", "accepted: a number with rad/s, krad/s, Hz, kHz"},
        {"200 r/min/s", "rad/s^2", "accepted: a number with rad/s^2"},
        {"25 Hz", UNITS_SPEED, "accepted: a number with rad/s, r/min, deg/s, rpm"},
        /* units whose meaning is not certain are refused */
        {"3 Arms", "A", "quantity in A"}, /* parameters of the drive are amplitudes */
        {"2 N..m", "N m", "quantity in N m"},
        {"2 mm", "N m", "quantity in N m"},
        {"2 Nm/", "N m", "quantity in N m"},
        {"3 gmm^2", "kg m^2", "quantity in kg m^2"},
        {"3 kgcm^3", "kg m^2", "quantity in kg m^2"},
        {"6000 \xC2\xB6H", "H", "quantity in H"},
        {"45 V/100 rpm", "V/krpm", "quantity in V/krpm"},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        expect_refused(rows[n].text, rows[n].unit, rows[n].part);
    }
}

static void test_texts_of_any_length_are_read_or_refused(void)
{
    char text[600];
    memset(text, '9', sizeof text);
    memcpy(text + sizeof text - 3u, " s", 3u);
    expect_refused(text, "s", "does not begin with a number");
    memset(text, '9', 300);
    memcpy(text + 300, " s", 3u);
    TEST_ASSERT_TRUE(value_of(text, "s") == 1e300); /* 300 nines, whose nearest double is 10^300 */
    memset(text, 'a', 110);
    memcpy(text, "1 ", 2u);
    text[110] = '\0';
    expect_refused(text, "A", "quantity in A");
}

/* The rows whose text contains "mechanical"; a new row of this kind must be added to the list. */
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

/* The unit of each row must be readable. */
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

static void test_values_are_written_in_the_unit_that_reads_best(void)
{
    static const struct {
        const char *text;
        double value;
        const char *unit;
    } rows[] = {
        {"1500 r/min", 1500.0 * PI / 30.0, UNITS_SPEED},
        {"0.1 r/min", 0.1 * PI / 30.0, UNITS_SPEED},
        {"1000 rad/s", 1000.0, "rad/s"},
        {"20 rad/s^2", 20.0, UNITS_ACCELERATION},
        {"2.5 us", 2.5e-6, "s"},
        {"2 s", 2.0, "s"},
        {"-12.3 mrad", -0.0123, "rad"},
        {"0 A", 0.0, "A"},
        {"999.9 mA", 0.9999, "A"},
        {"1 A", 0.99999999, "A"},
        {"0.0636 kg m^2", 0.0636, "kg m^2"},
        {"0.3", 0.3, "-"},
        {"30010 periods", 30010.0, "periods"},
        {"1e-12 A", 1e-15 * 1e3, "A"},
        {"nan A", (double)NAN, "A"},
        {"-inf A", -(double)INFINITY, "A"},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        char text[UNITS_TEXT_SIZE];
        TEST_ASSERT_EQUAL_STRING(rows[n].text, units_text(text, rows[n].value, rows[n].unit));
    }
}

static void test_both_ends_of_a_range_have_one_unit_unless_it_needs_an_exponent(void)
{
    char text[UNITS_TEXT_SIZE];
    TEST_ASSERT_EQUAL_STRING("0.1 to 16 A", units_range_text(text, 0.1, 16.0, "A"));
    TEST_ASSERT_EQUAL_STRING("2 to 6 us", units_range_text(text, 2e-6, 6e-6, "s"));
    TEST_ASSERT_EQUAL_STRING("0 to 1.2", units_range_text(text, 0.0, 1.2, "-"));
    TEST_ASSERT_EQUAL_STRING("10 uH to 1 H", units_range_text(text, 1e-5, 1.0, "H"));
    TEST_ASSERT_EQUAL_STRING("1e-07 to 1000 kg m^2", units_range_text(text, 1e-7, 1e3, "kg m^2"));
}

/* Each end of a range, read again in the unit in which it is written, is a 32-bit value within the range.
 * This is tested for speeds, whose factor is no decimal number, and for prefixes. */
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
        const bool own_unit = unit[0] != 'k' && memchr(text, ' ', (size_t)(to - text)) != NULL;
        snprintf(low, sizeof low, "%.*s%s", (int)(to - text), text,
                 own_unit ? "" : high + strcspn(high, " "));
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
