/* Ranges and defaults follow the board. A set beyond the range of the sensors or the limits of the power
 * stage is refused, and the message contains the name and the range of the parameter. The defaults are
 * accepted. */
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

/* The range of the current sensors that is valid in both directions [A], line 9. */
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

/* For each parameter whose range depends on the board: a value beyond each end, with the range that is
 * reported, and a value within it. The current limit is four fifths of the sensors' range and below the
 * trip, which is 95 % of that range. The register of the dead time holds 1023 cycles. A temperature beyond
 * the range of the sensor could never trip. */
static void test_ranges_follow_sensors_stage_and_module(void)
{
    const double limit = fmin(0.8 * seen(), BOARD_OVERCURRENT_TRIP_MA / 1.2e3);
    const double voltage = BOARD_OVERVOLTAGE_MAX_MV / 1e3, dead_time = BOARD_DEAD_BAND_MIN_NS / 1e9;
    const double sink = fmin(120.0, fmax(BOARD_SINK_AT_0V, BOARD_SINK_AT_3V));
    const double motor = fmin(145.0, fmax(BOARD_MOTOR_AT_0V, BOARD_MOTOR_AT_3V));
    const struct {
        const char *row;
        /* Within is NAN if another parameter would have to change with this one. */
        double beyond, min, max, within;
    } rows[] = {{"current_limit", 0.81 * seen(), 0.1, limit, NAN},
                {"overcurrent_trip", 0.96 * seen(), 1.2 * BOARD_CURRENT_LIMIT_MA / 1e3, 0.95 * seen(),
                 0.9499 * seen()},
                {"dc_overvoltage", 1.01 * voltage, BOARD_UNDERVOLTAGE_MV / 1e3 + 10.0, voltage, voltage},
                {"dead_time", 0.99 * dead_time, dead_time, 1023.0 / BOARD_SYSCLK_HZ, 1.000001 * dead_time},
                {"sink_temperature_max", sink + 0.5, 0.0, sink, NAN},
                {"motor_temperature_max", motor + 0.5, 0.0, motor, NAN}};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const table_row_t *const row = table_by_name(&params_table, rows[n].row);
        params_defaults(&params);
        params.low_speed_current = 0.0f; /* another rule requires a current */
        params.turn_off_delay = 0.0f;
        table_set(row, &params, (float)rows[n].beyond);
        expect_refused(rows[n].row, rows[n].beyond, rows[n].min, rows[n].max);
        if (!isnan(rows[n].within)) {
            table_set(row, &params, (float)rows[n].within);
            TEST_ASSERT_TRUE_MESSAGE(params_check(&params, &why), why.field);
        }
    }
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
