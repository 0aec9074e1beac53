/* Numbers as text. The expected texts are written by hand from the binary format, or come from the exact
 * conversions of the C library. */
#define _POSIX_C_SOURCE 200809L

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/recorder_parts.h"
#include "math/float_bits.h"
#include "unity.h"

void tearDown(void)
{
    setlocale(LC_ALL, "C");
}

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static const char *float_text(uint32_t bits)
{
    static char text[RECORDER_NUMBER_SIZE + 1u];
    memset(text, '#', sizeof text);
    text[recorder_float_text(text, bits)] = '\0';
    return text;
}

static void expect_float(const char *expected, float value)
{
    TEST_ASSERT_EQUAL_STRING(expected, float_text(float_bits(value)));
}

static void test_float_has_fewest_digits(void)
{
    expect_float("0", 0.0f);
    expect_float("-0", -0.0f);
    expect_float("1", 1.0f);
    expect_float("-2.5", -2.5f);
    expect_float("0.1", 0.1f);
    expect_float("0.3", 0.3f);
    expect_float("310", 310.0f);
    expect_float("16777216", 16777216.0f);
    expect_float("3.1415927", 3.14159265f);
    expect_float("10.000001", 10.000001f);
}

static void test_float_is_plain_between_1e_minus_4_and_1e9(void)
{
    expect_float("0.0001", 1e-4f);
    expect_float("9.9999e-5", 9.9999e-5f);
    expect_float("0.000123", 1.23e-4f);
    expect_float("999999940", 999999936.0f); /* the largest float below 1e9; its neighbours differ by 64 */
    expect_float("1e9", 1e9f);
    expect_float("1.5e9", 1.5e9f);
    expect_float("-1.5e-7", -1.5e-7f);
}

static void test_float_at_the_ends_of_the_format(void)
{
    TEST_ASSERT_EQUAL_STRING("3.4028235e38", float_text(UINT32_C(0x7F7FFFFF)));
    TEST_ASSERT_EQUAL_STRING("1.1754944e-38", float_text(UINT32_C(0x00800000)));
    TEST_ASSERT_EQUAL_STRING("1.1754942e-38", float_text(UINT32_C(0x007FFFFF)));
    TEST_ASSERT_EQUAL_STRING("1e-45", float_text(1u));
    TEST_ASSERT_EQUAL_STRING("-1e-45", float_text(UINT32_C(0x80000001)));
    TEST_ASSERT_EQUAL_STRING("inf", float_text(UINT32_C(0x7F800000)));
    TEST_ASSERT_EQUAL_STRING("-inf", float_text(UINT32_C(0xFF800000)));
    TEST_ASSERT_EQUAL_STRING("nan", float_text(UINT32_C(0x7FC00000)));
    TEST_ASSERT_EQUAL_STRING("nan", float_text(UINT32_C(0xFF800001)));
}

/* The text has the fewest digits that printf needs. Powers of two are excluded: the distance to the next
 * smaller float is half of that to the next larger one. The nearest decimal with this number of digits may
 * then be outside the interval of the float although a more distant one is within it. */
static void expect_shortest(uint32_t bits)
{
    char least[40];
    const float value = float_of(bits);
    for (int digits = 0; digits < 9; digits++) {
        snprintf(least, sizeof least, "%.*e", digits, (double)value);
        if (float_bits(strtof(least, NULL)) == bits) {
            break;
        }
    }
    /* The two decimals are equal: they name the same double. */
    TEST_ASSERT_TRUE_MESSAGE(strtod(least, NULL) == strtod(float_text(bits), NULL), least);
}

static void expect_reads_back(uint32_t bits)
{
    const char *text = float_text(bits);
    char *end;
    TEST_ASSERT_TRUE_MESSAGE(float_bits(strtof(text, &end)) == bits, text);
    TEST_ASSERT_TRUE_MESSAGE(*end == '\0' && strlen(text) <= 15u, text);
    /* Converted to double first, as most readers do. */
    TEST_ASSERT_TRUE_MESSAGE(float_bits((float)strtod(text, NULL)) == bits, text);
}

static void test_floats_over_the_whole_range_read_back_and_are_shortest(void)
{
    /* The odd stride of 71000 values covers all exponents and all kinds of fractions. */
    for (uint32_t bits = 1; bits < UINT32_C(0x7F800000); bits += 30011u) {
        expect_reads_back(bits);
        expect_reads_back(bits | UINT32_C(0x80000000));
        if ((bits & UINT32_C(0x7FFFFF)) != 0u) {
            expect_shortest(bits);
        }
    }
}

static void test_the_float_that_rounds_twice_has_a_digit_more(void)
{
    expect_reads_back(UINT32_C(0x15AE43FD));
    expect_reads_back(UINT32_C(0x95AE43FD));
    TEST_ASSERT_EQUAL_STRING("-7.0385307e-26", float_text(UINT32_C(0x95AE43FD)));
}

static void test_powers_of_two_and_their_neighbours_read_back(void)
{
    for (uint32_t exponent = 1; exponent < 255u; exponent++) {
        expect_reads_back((exponent << 23) - 1u);
        expect_reads_back(exponent << 23);
        expect_reads_back((exponent << 23) + 1u);
    }
    TEST_ASSERT_EQUAL_STRING("9.8607613e-32", float_text(UINT32_C(0x0C000000))); /* 2^-103 */
}

static void test_integers_to_their_ends(void)
{
    char text[RECORDER_NUMBER_SIZE + 1u];
    text[recorder_int_text(text, INT32_MIN)] = '\0';
    TEST_ASSERT_EQUAL_STRING("-2147483648", text);
    text[recorder_int_text(text, INT32_MAX)] = '\0';
    TEST_ASSERT_EQUAL_STRING("2147483647", text);
    text[recorder_uint_text(text, UINT64_MAX)] = '\0';
    TEST_ASSERT_EQUAL_STRING("18446744073709551615", text);
    text[recorder_uint_text(text, 0u)] = '\0';
    TEST_ASSERT_EQUAL_STRING("0", text);
    text[recorder_slot_text(text, SLOT_INT, UINT32_C(0xFFFFFFFF))] = '\0';
    TEST_ASSERT_EQUAL_STRING("-1", text);
    text[recorder_slot_text(text, SLOT_ENUM, UINT32_C(0xFFFFFFFF))] = '\0';
    TEST_ASSERT_EQUAL_STRING("-1", text);
    text[recorder_slot_text(text, SLOT_UINT, UINT32_C(0xFFFFFFFF))] = '\0';
    TEST_ASSERT_EQUAL_STRING("4294967295", text);
    text[recorder_slot_text(text, SLOT_FLOAT, float_bits(0.5f))] = '\0';
    TEST_ASSERT_EQUAL_STRING("0.5", text);
}

static void expect_value(const char *expected, double value)
{
    char text[RECORDER_NUMBER_SIZE + 1u];
    text[recorder_value_text(text, value)] = '\0';
    TEST_ASSERT_EQUAL_STRING(expected, text);
}

static void test_settings_are_whole_numbers_or_floats(void)
{
    expect_value("4", 4.0);
    expect_value("-1", -1.0);
    expect_value("0", 0.0);
    expect_value("4294967295", 4294967295.0);
    expect_value("0.0125", (double)0.0125f); /* a float parameter as rig_get returns it */
    expect_value("0.95", (double)0.95f);
    expect_value("-3.1415927", (double)-3.1415927f);
}

static void test_locale_changes_nothing(void)
{
    static const char *const with_comma[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8",
                                             "de_DE"};
    const char *found = NULL;
    for (size_t n = 0; n < sizeof with_comma / sizeof with_comma[0] && found == NULL; n++) {
        found = setlocale(LC_ALL, with_comma[n]);
    }
    if (found == NULL) {
        TEST_IGNORE_MESSAGE("no locale with a decimal comma on this machine (package locales-all)");
    }
    char text[16];
    snprintf(text, sizeof text, "%.1f", 0.5);
    TEST_ASSERT_EQUAL_STRING("0,5", text); /* the locale is really active */
    expect_float("0.5", 0.5f);
    expect_float("1.5e-7", 1.5e-7f);
    expect_value("0.95", (double)0.95f);
}
