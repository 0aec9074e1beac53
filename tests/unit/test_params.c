#include "drive/params.h"

#include <math.h>
#include <string.h>

#include "drive/reasons.h"
#include "drive/requests.h"
#include "unity.h"

static params_t params;
static params_error_t why;

void setUp(void)
{
    params_defaults(&params);
    memset(&why, 0, sizeof why);
}

void tearDown(void)
{
}

/* Paper's Table I and rig, section 2. */
static void test_defaults_are_the_papers_motor_and_are_accepted(void)
{
    TEST_ASSERT_TRUE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_INT32(4, params.motor_pole_pairs);
    TEST_ASSERT_EQUAL_FLOAT(0.95f, params.motor_resistance);
    TEST_ASSERT_EQUAL_FLOAT(12.5e-3f, params.motor_inductance_d);
    TEST_ASSERT_EQUAL_FLOAT(0.183f, params.motor_flux_linkage);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, params.speed_kp);
    TEST_ASSERT_EQUAL_FLOAT(2.5f, params.speed_ki);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, params.current_limit);
}

/* Every row, just below and just above its range, and not a number: refused by its own name with its own
 * limits. */
static void test_every_row_is_refused_outside_its_range_by_name(void)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        const bool whole = row->kind != SLOT_FLOAT;
        const float outside[] = {whole ? row->min - 1.0f : nextafterf(row->min, -INFINITY),
                                 whole ? row->max + 1.0f : nextafterf(row->max, INFINITY), NAN};
        for (size_t m = 0; m < (whole ? 2u : 3u); m++) {
            params_defaults(&params);
            table_set(row, &params, outside[m]);
            TEST_ASSERT_FALSE_MESSAGE(params_check(&params, &why), row->name);
            TEST_ASSERT_EQUAL_STRING(row->name, why.field);
            TEST_ASSERT_EQUAL_UINT32(row->id, why.id);
            TEST_ASSERT_EQUAL_INT32(REASON_OUT_OF_RANGE, why.reason);
            TEST_ASSERT_EQUAL_FLOAT(row->min, why.min);
            TEST_ASSERT_EQUAL_FLOAT(row->max, why.max);
        }
    }
}

static void expect_rule(const char *field, float min, float max)
{
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING(field, why.field);
    TEST_ASSERT_EQUAL_INT32(REASON_CROSS_RULE, why.reason);
    TEST_ASSERT_EQUAL_UINT32(table_by_name(&params_table, field)->id, why.id);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * (fabsf(min) + 1e-9f), min, why.min);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * (fabsf(max) + 1e-9f), max, why.max);
}

static void test_overcurrent_trip_must_leave_room_above_the_current_limit(void)
{
    params.current_limit = 10.0f;
    params.overcurrent_trip = 12.0f;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.overcurrent_trip = 11.9f;
    expect_rule("overcurrent_trip", 12.0f, 19.0f);
}

static void test_dc_limits_must_be_in_order(void)
{
    params.dc_overvoltage = 300.0f;
    params.dc_undervoltage = 290.0f;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.dc_undervoltage = 291.0f;
    expect_rule("dc_undervoltage", 0.0f, 290.0f);
}

static void test_turn_off_must_be_over_before_the_other_switch_turns_on(void)
{
    params.dead_time = 2.0e-6f;
    params.turn_on_delay = 0.5e-6f;
    params.turn_off_delay = 2.4e-6f;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.turn_off_delay = 2.6e-6f;
    expect_rule("turn_off_delay", 0.0f, 2.5e-6f);
}

static void test_encoder_must_resolve_a_pole_pair(void)
{
    params.encoder_lines = 256;
    params.motor_pole_pairs = 4;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.motor_pole_pairs = 5;
    expect_rule("motor_pole_pairs", 1.0f, 4.0f);
}

static void test_speed_must_not_turn_the_frame_half_a_radian_in_a_period(void)
{
    params.overspeed_trip = 1249.0f; /* 0.5 rad / (4 pole pairs x 100 us) = 1250 rad/s */
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.overspeed_trip = 1251.0f;
    expect_rule("overspeed_trip", 1.0f, 1250.0f);
}

static void test_only_live_rows_change_while_the_bridge_is_on(void)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        params_t next = params;
        table_set(row, &next, row->initial != row->max ? row->max : row->min);
        const bool live = params_check_live(&params, &next, &why);
        TEST_ASSERT_EQUAL_MESSAGE(row->access == TABLE_LIVE, live, row->name);
        if (!live) {
            TEST_ASSERT_EQUAL_UINT32(row->id, why.id);
            TEST_ASSERT_EQUAL_INT32(REASON_BRIDGE_ON, why.reason);
        }
    }
}

/* Facts on the ePWM, section 8: 2.5 us dead time and a 1.5 us pulse make 300 of 7500 counts. */
static void test_smallest_duty_holds_dead_time_and_shortest_pulse(void)
{
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 300.0f / 7500.0f, params_duty_min(&params));
}

static void test_requests_start_off_and_harmless(void)
{
    requests_t requests;
    requests_defaults(&requests);
    TEST_ASSERT_EQUAL_INT32(REQUEST_OFF, requests.enable);
    TEST_ASSERT_EQUAL_INT32(0, requests.fault_reset);
    TEST_ASSERT_EQUAL_INT32(MODE_SPEED, requests.mode);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, requests.speed_request);
    TEST_ASSERT_TRUE(requests_check(&requests, &params, &why));
}

static void test_requests_are_refused_beyond_what_the_parameters_allow(void)
{
    requests_t requests;
    requests_defaults(&requests);
    requests.speed_request = -0.95f * params.overspeed_trip;
    TEST_ASSERT_TRUE(requests_check(&requests, &params, &why));
    requests.speed_request = -0.96f * params.overspeed_trip;
    TEST_ASSERT_FALSE(requests_check(&requests, &params, &why));
    TEST_ASSERT_EQUAL_STRING("speed_request", why.field);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 209.0f, why.max);

    requests_defaults(&requests);
    requests.i_q_request = 10.0f;
    TEST_ASSERT_TRUE(requests_check(&requests, &params, &why));
    requests.i_q_request = 10.1f;
    TEST_ASSERT_FALSE(requests_check(&requests, &params, &why));
    TEST_ASSERT_EQUAL_STRING("i_q_request", why.field);

    requests_defaults(&requests);
    requests.i_d_request = -10.1f;
    TEST_ASSERT_FALSE(requests_check(&requests, &params, &why));
    TEST_ASSERT_EQUAL_STRING("i_d_request", why.field);

    requests_defaults(&requests);
    requests.enable = 3;
    TEST_ASSERT_FALSE(requests_check(&requests, &params, &why));
    TEST_ASSERT_EQUAL_STRING("enable", why.field);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, why.max);

    requests_defaults(&requests);
    requests.speed_request = NAN;
    TEST_ASSERT_FALSE(requests_check(&requests, &params, &why));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_defaults_are_the_papers_motor_and_are_accepted);
    RUN_TEST(test_every_row_is_refused_outside_its_range_by_name);
    RUN_TEST(test_overcurrent_trip_must_leave_room_above_the_current_limit);
    RUN_TEST(test_dc_limits_must_be_in_order);
    RUN_TEST(test_turn_off_must_be_over_before_the_other_switch_turns_on);
    RUN_TEST(test_encoder_must_resolve_a_pole_pair);
    RUN_TEST(test_speed_must_not_turn_the_frame_half_a_radian_in_a_period);
    RUN_TEST(test_only_live_rows_change_while_the_bridge_is_on);
    RUN_TEST(test_smallest_duty_holds_dead_time_and_shortest_pulse);
    RUN_TEST(test_requests_start_off_and_harmless);
    RUN_TEST(test_requests_are_refused_beyond_what_the_parameters_allow);
    return UNITY_END();
}
