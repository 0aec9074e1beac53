/* Ranges and defaults follow the board: a set beyond what its sensors see or its stage stands is refused,
 * with the row's name and range; the defaults are a good set. */
#include <math.h>
#include <string.h>

#include "settings/params.h"
#include "settings/reasons.h"
#include "settings/requests.h"
#include "unity.h"

static params_t params;
static params_error_t why;

void setUp(void)
{
    params_defaults(&params);
    memset(&why, 0, sizeof why);
}

/* What the sensors see in both directions [A], line 9. */
static double seen(void)
{
    return fmin(BOARD_CURRENT_ZERO_MV, 3000.0 - BOARD_CURRENT_ZERO_MV) * fabs((double)BOARD_CURRENT_STEP_MA) /
           BOARD_CURRENT_STEP_MV / 1e3;
}

static void expect_refused(const char *row, double value, double min, double max)
{
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING(row, why.field);
    TEST_ASSERT_EQUAL_INT32(REASON_OUT_OF_RANGE, why.reason);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(value), value, (double)why.value);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(min) + 1e-12, min, (double)why.min);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(max), max, (double)why.max);
}

static void test_defaults_are_the_board_s_and_a_good_set(void)
{
    TEST_ASSERT_TRUE_MESSAGE(params_check(&params, &why), why.field);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_CURRENT_LIMIT_MA / 1e3f, params.current_limit);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_OVERCURRENT_TRIP_MA / 1e3f, params.overcurrent_trip);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_OVERVOLTAGE_MV / 1e3f, params.dc_overvoltage);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_UNDERVOLTAGE_MV / 1e3f, params.dc_undervoltage);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_DEAD_TIME_NS / 1e9f, params.dead_time);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_MINIMUM_PULSE_NS / 1e9f, params.minimum_pulse);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_TURN_ON_DELAY_NS / 1e9f, params.turn_on_delay);
    TEST_ASSERT_EQUAL_FLOAT(BOARD_TURN_OFF_DELAY_NS / 1e9f, params.turn_off_delay);
    TEST_ASSERT_EQUAL_FLOAT((BOARD_IGBT_DROP_MV + BOARD_DIODE_DROP_MV) / 2e3f, params.device_drop);
    TEST_ASSERT_EQUAL_FLOAT((BOARD_IGBT_SLOPE_UOHM + BOARD_DIODE_SLOPE_UOHM) / 2e6f,
                            params.device_resistance);
}

static void test_current_limit_leaves_a_fifth_of_the_sensors_range(void)
{
    const double value = 0.81 * seen();
    params.low_speed_current = 0.0f; /* what wants a current at all is another's matter */
    params.current_limit = (float)value;
    /* the trip leaves room above the limit */
    expect_refused("current_limit", value, 0.1, fmin(0.8 * seen(), BOARD_OVERCURRENT_TRIP_MA / 1.2e3));
}

static void test_overcurrent_trip_stays_within_the_sensors_range(void)
{
    const double value = 0.96 * seen();
    params.overcurrent_trip = (float)value;
    expect_refused("overcurrent_trip", value, 1.2 * BOARD_CURRENT_LIMIT_MA / 1e3, 0.95 * seen());
    params.overcurrent_trip = (float)(0.9499 * seen());
    TEST_ASSERT_TRUE_MESSAGE(params_check(&params, &why), why.field);
}

static void test_overvoltage_trip_stays_within_what_the_stage_stands(void)
{
    const double max = BOARD_OVERVOLTAGE_MAX_MV / 1e3;
    params.dc_overvoltage = (float)(1.01 * max);
    expect_refused("dc_overvoltage", 1.01 * max, BOARD_UNDERVOLTAGE_MV / 1e3 + 10.0, max);
    params.dc_overvoltage = (float)max;
    TEST_ASSERT_TRUE_MESSAGE(params_check(&params, &why), why.field);
}

/* The register holds 1023 cycles. */
static void test_dead_time_is_not_below_what_the_module_demands(void)
{
    const double min = BOARD_DEAD_BAND_MIN_NS / 1e9;
    params.dead_time = (float)(0.99 * min);
    expect_refused("dead_time", 0.99 * min, min, 1023.0 / BOARD_SYSCLK_HZ);
    params.dead_time = (float)(min * 1.000001);
    params.turn_off_delay = 0.0f;
    TEST_ASSERT_TRUE_MESSAGE(params_check(&params, &why), why.field);
}

/* A trip above the end of the sensor's line would never come. */
static void test_temperature_trips_are_within_the_sensors_lines(void)
{
    const double sink = fmin(120.0, fmax(BOARD_SINK_AT_0V, BOARD_SINK_AT_3V));
    const double motor = fmin(145.0, fmax(BOARD_MOTOR_AT_0V, BOARD_MOTOR_AT_3V));
    params.sink_temperature_max = (float)sink + 0.5f;
    expect_refused("sink_temperature_max", sink + 0.5, 0.0, sink);
    params_defaults(&params);
    params.motor_temperature_max = (float)motor + 0.5f;
    expect_refused("motor_temperature_max", motor + 0.5, 0.0, motor);
}

static void test_current_requests_follow_the_sensors_too(void)
{
    requests_t requests;
    requests_defaults(&requests);
    requests.i_q_request = (float)(-0.81 * seen());
    TEST_ASSERT_FALSE(requests_check(&requests, &params, &why));
    TEST_ASSERT_EQUAL_STRING("i_q_request", why.field);
    TEST_ASSERT_EQUAL_INT32(REASON_OUT_OF_RANGE, why.reason);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * seen(), fmin(0.8 * seen(), BOARD_CURRENT_LIMIT_MA / 1e3),
                              (double)why.max);
    requests.i_q_request = -params.current_limit;
    TEST_ASSERT_TRUE(requests_check(&requests, &params, &why));
}
