/* Simulated time as text and as a number, with the carriers that a board may have. The expected values are
 * k x ticks/150 MHz, calculated by hand. */
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/times.h"
#include "host_sim/rig/rig.h"
#include "unity.h"

static const char *text_of(uint32_t period, uint64_t period_ticks)
{
    static char text[TIMES_TEXT_SIZE];
    const size_t length = times_write(text, period, period_ticks);
    TEST_ASSERT_TRUE(length < TIMES_TEXT_SIZE);
    text[length] = '\0';
    return text;
}

static void test_each_carrier_has_as_many_decimals_as_are_exact_or_nanoseconds(void)
{
    static const struct {
        uint32_t period;
        uint64_t ticks;
        const char *text;
    } rows[] = {
        {0u, 15000u, "0.0000"}, /* a carrier of 10 kHz */
        {1u, 15000u, "0.0001"},
        {9999u, 15000u, "0.9999"},
        {10000u, 15000u, "1.0000"},
        {123456u, 15000u, "12.3456"},
        {UINT32_MAX, 15000u, "429496.7295"},
        {1u, 30000u, "0.0002"}, /* a carrier of 5 kHz */
        {5000u, 30000u, "1.0000"},
        {UINT32_MAX, 30000u, "858993.4590"},
        {1u, 7500u, "0.00005"}, /* a carrier of 20 kHz */
        {19999u, 7500u, "0.99995"},
        {20000u, 7500u, "1.00000"},
        {1u, 9375u, "0.0000625"}, /* a carrier of 16 kHz */
        {0u, 9378u, "0.00000000"},
        {1u, 9378u, "0.00006252"},
        {16000u, 9378u, "1.00032000"},
        {0u, 9374u, "0.000000000"}, /* a period is 62.4933.. us, with infinitely many digits */
        {1u, 9374u, "0.000062493"},
        {2u, 9374u, "0.000124987"}, /* 124.9866.. us, which is not twice the rounded value */
        {3u, 9374u, "0.000187480"},
        {1u, 9376u, "0.000062507"},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        TEST_ASSERT_EQUAL_STRING(rows[n].text, text_of(rows[n].period, rows[n].ticks));
    }
}

/* With the digits of the text as nanoseconds, 3 x text is within 1 of 20 x tick, which holds for no other
 * tick. */
static void test_every_text_identifies_its_tick(void)
{
    for (uint64_t ticks = 7500u; ticks <= 30000u; ticks += 101u) {
        for (uint32_t period = 0; period < 4200000000u; period += 99991111u) {
            const char *text = text_of(period, ticks);
            const char *point = strchr(text, '.');
            TEST_ASSERT_NOT_NULL(point);
            uint64_t nanoseconds = strtoull(text, NULL, 10) * UINT64_C(1000000000);
            uint64_t scale = UINT64_C(100000000);
            for (const char *digit = point + 1; *digit != '\0'; digit++, scale /= 10u) {
                nanoseconds += (uint64_t)(*digit - '0') * scale;
            }
            const int64_t error = (int64_t)(3u * nanoseconds) - (int64_t)(20u * (ticks * period));
            TEST_ASSERT_TRUE_MESSAGE(error >= -1 && error <= 1, text);
            TEST_ASSERT_TRUE_MESSAGE(ticks % 3u != 0u || error == 0, text);
            TEST_ASSERT_TRUE_MESSAGE(times_seconds(period, ticks) == strtod(text, NULL), text);
        }
    }
}

static void expect_period(const char *expected, uint64_t period_ticks)
{
    char text[TIMES_TEXT_SIZE];
    TEST_ASSERT_EQUAL_STRING(expected, times_period_text(text, period_ticks));
}

static void test_length_of_a_period_is_exact_or_has_18_decimals(void)
{
    expect_period("0.0001", 15000u);
    expect_period("0.0002", 30000u);
    expect_period("0.00005", 7500u);
    expect_period("0.00006252", 9378u);
    expect_period("0.000062493333333333", 9374u);
    expect_period("0.000062506666666667", 9376u);
}

static void test_nanoseconds_are_the_nearest(void)
{
    TEST_ASSERT_TRUE(times_nanoseconds(0u) == 0u);
    TEST_ASSERT_TRUE(times_nanoseconds(1u) == 7u);  /* 6.67 ns */
    TEST_ASSERT_TRUE(times_nanoseconds(2u) == 13u); /* 13.33 ns */
    TEST_ASSERT_TRUE(times_nanoseconds(3u) == 20u);
    TEST_ASSERT_TRUE(times_nanoseconds(9374u) == 62493u);
}

static void test_text_of_the_rig_is_that_of_its_period(void)
{
    char text[TIMES_TEXT_SIZE];
    TEST_ASSERT_EQUAL_STRING(text_of(123456u, RIG_PERIOD_TICKS), times_text(text, 123456u));
    TEST_ASSERT_EQUAL_UINT32(RIG_PERIOD_TICKS, rig_period_ticks);
    TEST_ASSERT_EQUAL_UINT32(123456u, rig_periods(123456u * RIG_PERIOD_SECONDS));
}

static void test_time_is_rounded_to_the_nearest_period(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, rig_periods_of(0.0, 9378u));
    TEST_ASSERT_EQUAL_UINT32(1u, rig_periods_of(93e-6, 9378u));   /* 1.49 periods of 62.52 us */
    TEST_ASSERT_EQUAL_UINT32(2u, rig_periods_of(94e-6, 9378u));   /* 1.504 periods */
    TEST_ASSERT_EQUAL_UINT32(7997u, rig_periods_of(0.5, 9378u));  /* 7997.44 periods */
    TEST_ASSERT_EQUAL_UINT32(15995u, rig_periods_of(1.0, 9378u)); /* 15994.88 periods */
    TEST_ASSERT_EQUAL_UINT32(1u, rig_periods_of(74e-6, 7500u));
    TEST_ASSERT_EQUAL_UINT32(2u, rig_periods_of(76e-6, 7500u));
    TEST_ASSERT_EQUAL_UINT32(72000000u, rig_periods_of(3600.0, 7500u));
    TEST_ASSERT_EQUAL_UINT32(1u, rig_periods_of(299e-6, 30000u));
    TEST_ASSERT_EQUAL_UINT32(2u, rig_periods_of(301e-6, 30000u));
    /* 0.3/1e-4 is less than 3000 in binary arithmetic. */
    TEST_ASSERT_EQUAL_UINT32(3000u, rig_periods_of(0.3, 15000u));
    static const uint64_t lengths[] = {7500u, 9374u, 9376u, 9378u, 15000u, 30000u};
    for (size_t n = 0; n < sizeof lengths / sizeof lengths[0]; n++) {
        for (uint32_t period = 0; period < 70000000u; period += 9973u) {
            TEST_ASSERT_EQUAL_UINT32(period, rig_periods_of(times_seconds(period, lengths[n]), lengths[n]));
        }
    }
}
