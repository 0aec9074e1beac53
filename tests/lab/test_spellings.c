/* Units as data sheets spell them. Every expected value is the definition of the unit, not what the table
 * says. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/motor.h"
#include "host_sim/lab/units.h"
#include "unity.h"

#define PI  3.14159265358979323846
#define RPM (2.0 * PI / 60.0)      /* [rad/s] */
#define LBF (0.45359237 * 9.80665) /* [N] a pound's weight */

static double value_of(const char *text, const char *unit)
{
    double value = NAN;
    units_error_t why;
    TEST_ASSERT_TRUE_MESSAGE(units_read(text, unit, &value, &why), text);
    return value;
}

static void is(double expected, const char *text, const char *unit)
{
    const double value = value_of(text, unit);
    TEST_ASSERT_TRUE_MESSAGE(fabs(value - expected) <= 1e-12 * fabs(expected), text);
}

static void refused(const char *text, const char *unit)
{
    double value;
    units_error_t why;
    TEST_ASSERT_FALSE_MESSAGE(units_read(text, unit, &value, &why), text);
}

static void test_micro_has_two_characters(void)
{
    static const char *const units[] = {"H", "A", "V", "F", "s", "rad"};
    for (size_t n = 0; n < sizeof units / sizeof units[0]; n++) {
        static const char *const micros[] = {"u", "\xC2\xB5", "\xCE\xBC"};
        for (size_t k = 0; k < 3; k++) {
            char text[40];
            snprintf(text, sizeof text, "6000 %s%s", micros[k], units[n]);
            is(6e-3, text, units[n]);
        }
    }
}

static void test_the_ohm_is_a_letter_or_a_sign_or_a_word(void)
{
    static const char *const ohms[] = {"ohm", "Ohm", "OHM", "ohms", "\xCE\xA9", "\xE2\x84\xA6"};
    for (size_t n = 0; n < sizeof ohms / sizeof ohms[0]; n++) {
        static const struct {
            const char *prefix;
            double factor;
        } prefixes[] = {{"", 1.0}, {"m", 1e-3}, {"k", 1e3}};
        for (size_t k = 0; k < 3; k++) {
            char text[40];
            snprintf(text, sizeof text, "1.5 %s%s", prefixes[k].prefix, ohms[n]);
            is(1.5 * prefixes[k].factor, text, "ohm");
        }
    }
}

static void test_products_have_a_space_a_dot_or_nothing(void)
{
    static const char *const signs[] = {" ", "",         ".",         "-", "\xC2\xB7", "\xE2\x8B\x85",
                                        "*", "\xC2\xA0", " \xC2\xB7 "};
    for (size_t n = 0; n < sizeof signs / sizeof signs[0]; n++) {
        static const char *const squares[] = {"^2", "2", "\xC2\xB2"};
        char text[60];
        snprintf(text, sizeof text, "2 N%sm", signs[n]);
        is(2.0, text, "N m");
        snprintf(text, sizeof text, "2 mN%sm/A", signs[n]);
        is(2e-3, text, "N m/A");
        snprintf(text, sizeof text, "2 V%ss", signs[n]);
        is(2.0, text, "Wb");
        for (size_t k = 0; k < 3; k++) {
            snprintf(text, sizeof text, "3 kg%scm%s", signs[n], squares[k]);
            is(3e-4, text, "kg m^2");
            snprintf(text, sizeof text, "3 g%smm%s", "", squares[k]);
            refused(text, "kg m^2"); /* not in the table: no guess */
        }
    }
}

static void test_speeds_of_data_sheets(void)
{
    static const char *const spellings[] = {"r/min",
                                            "rpm",
                                            "RPM",
                                            "Rpm",
                                            "1/min",
                                            "min^-1",
                                            "min-1",
                                            "rev/min",
                                            "U/min",
                                            "r / min",
                                            "min\xE2\x81\xBB\xC2\xB9"};
    for (size_t n = 0; n < sizeof spellings / sizeof spellings[0]; n++) {
        char text[60];
        snprintf(text, sizeof text, "3000 %s", spellings[n]);
        is(3000.0 * RPM, text, UNITS_SPEED);
        snprintf(text, sizeof text, "3000%s%s", spellings[n][0] == '1' ? " " : "", spellings[n]);
        is(3000.0 * RPM, text, UNITS_SPEED);
        refused(text, "rad/s"); /* not mechanical */
    }
    is(12.0, "12 rad\xC2\xB7s^-1", UNITS_SPEED);
    is(2.0 * PI * 40.0, "40 Hz", "rad/s");
}

static void test_voltage_constants_of_data_sheets(void)
{
    static const char *const spellings[] = {"V/krpm",         "V/kRPM",     "V/1000 r/min",  "V/1000r/min",
                                            "V/(1000 r/min)", "V/1000 rpm", "V/1000 min^-1", "V/1000 min-1",
                                            "V / 1000 RPM",   "mV/rpm",     "mV/min^-1",     "mV\xC2\xB7min"};
    for (size_t n = 0; n < sizeof spellings / sizeof spellings[0]; n++) {
        char text[60];
        snprintf(text, sizeof text, "45 %s", spellings[n]);
        is(45.0, text, "V/krpm");
    }
    is(0.5 * 1000.0 * RPM, "0.5 V s/rad", "V/krpm");
    is(0.5 * 1000.0 * RPM, "0.5 V\xC2\xB7s/rad", "V/krpm");
    is(200.0, "200 min^-1/V", "rpm/V");
    is(200.0, "200 RPM/V", "rpm/V");
}

static void test_pounds_and_inches(void)
{
    is(LBF * 0.0254, "1 lb-in", "N m");
    is(10.0 * LBF * 0.0254 / 16.0, "10 oz-in", "N m");
    is(LBF * 0.0254 / 16.0, "1 oz-in-s^2", "kg m^2");
    is(LBF * 0.0254 / 16.0, "1 oz\xC2\xB7in/A", "N m/A");
}

static void test_degrees(void)
{
    is(130.0,
       "130 \xC2\xB0"
       "C",
       "degC");
    is(130.0, "130 deg C", "degC");
    is(PI / 6.0, "30\xC2\xB0", "rad");
    is(4.0 * PI / 180.0, "4 \xC2\xB0/s\xC2\xB2", UNITS_ACCELERATION);
}

/* rms and peak are values of a quantity, and a key is for one of them. */
static void test_arms_is_for_keys_of_rms_values(void)
{
    scenario_error_t error;
    static const struct {
        const char *assignment;
        bool good;
    } rows[] = {
        {"rated_current_rms=3 Arms", true}, {"rated_current_rms=3 A rms", true},
        {"rated_current_rms=3 A", true},    {"rated_current_rms=3 Apk", false},
        {"rated_current_peak=3 Apk", true}, {"rated_current_peak=3 Arms", false},
        {"ke_line_rms=45 Vrms/krpm", true}, {"ke_line_peak=45 Vrms/krpm", false},
        {"ke_line_peak=45 Vpk/krpm", true}, {"kt_rms=0.5 N\xC2\xB7m/Arms", true},
        {"kt_peak=0.5 N m/Arms", false},    {"kt_rms=0.5 Nm/A", true},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        motor_sheet_t sheet = {.name = "x"};
        TEST_ASSERT_EQUAL_MESSAGE(rows[n].good, motor_override(&sheet, rows[n].assignment, &error),
                                  rows[n].assignment);
    }
}

static void test_what_no_data_sheet_means_is_refused(void)
{
    refused("3 Arms", "A"); /* a row of the drive: amplitudes */
    refused("2 N..m", "N m");
    refused("2 mm", "N m");
    refused("2 Nm/", "N m");
    refused("3 kgcm^3", "kg m^2");
    refused("6000 \xC2\xB6H", "H");
    refused("45 V/100 rpm", "V/krpm");
    refused("1 "
            "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
            "aaaaaaaaaaaaa",
            "A");
}
