#include "drive/protection.h"

#include <string.h>

#include "drive/reasons.h"
#include "unity.h"

static protection_t protection;
static protection_input_t healthy;

void setUp(void)
{
    const protection_limits_t limits = {15.0f, 400.0f, 200.0f, 90.0f, 130.0f, 220.0f};
    protection_init(&protection, &limits);
    healthy = (protection_input_t){
        .current = {1.0f, -0.5f, -0.5f},
        .u_dc = 311.0f,
        .sink_temperature = 40.0f,
        .motor_temperature = 40.0f,
        .omega_m = 100.0f,
        .bridge_on = 1u,
    };
}

void tearDown(void)
{
}

/* Steps until the fault shows; 0 if it does not within the time. */
static uint32_t periods_until(const protection_input_t *input, int32_t reason)
{
    for (uint32_t n = 1; n <= 2000u; n++) {
        if (protection_reason(protection_step(&protection, input)) == reason) {
            return n;
        }
    }
    return 0;
}

static void expect_fault(const protection_input_t *input, int32_t reason, uint32_t debounce)
{
    protection_reset(&protection);
    TEST_ASSERT_EQUAL_UINT32(debounce, periods_until(input, reason));
    TEST_ASSERT_EQUAL_UINT32(debounce, protection_debounce(reason));
}

static void test_a_healthy_drive_runs_on(void)
{
    for (int n = 0; n < 3000; n++) {
        TEST_ASSERT_EQUAL_HEX32(0, protection_step(&protection, &healthy));
    }
}

static void test_each_phase_stops_at_once_above_its_limit_in_either_sign(void)
{
    for (int phase = 0; phase < 3; phase++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            protection_input_t input = healthy;
            float *current = phase == 0 ? &input.current.a : phase == 1 ? &input.current.b : &input.current.c;
            *current = (float)sign * 15.0f;
            protection_reset(&protection);
            TEST_ASSERT_EQUAL_HEX32(0, protection_step(&protection, &input)); /* at the limit */
            *current = (float)sign * 15.001f;
            expect_fault(&input, REASON_OVERCURRENT, 1);
        }
    }
}

static void test_dc_link_limits(void)
{
    protection_input_t input = healthy;
    input.u_dc = 400.0f;
    TEST_ASSERT_EQUAL_UINT32(0, periods_until(&input, REASON_DC_OVERVOLTAGE));
    input.u_dc = 400.1f;
    expect_fault(&input, REASON_DC_OVERVOLTAGE, 2);
    input.u_dc = 200.0f;
    protection_reset(&protection);
    TEST_ASSERT_EQUAL_UINT32(0, periods_until(&input, REASON_DC_UNDERVOLTAGE));
    input.u_dc = 199.9f;
    expect_fault(&input, REASON_DC_UNDERVOLTAGE, 10);
}

static void test_temperatures_stop_after_a_tenth_of_a_second(void)
{
    protection_input_t input = healthy;
    input.sink_temperature = 90.1f;
    expect_fault(&input, REASON_SINK_HOT, 1000);
    input = healthy;
    input.motor_temperature = 130.1f;
    expect_fault(&input, REASON_MOTOR_HOT, 1000);
    input.motor_temperature = 130.0f;
    protection_reset(&protection);
    TEST_ASSERT_EQUAL_UINT32(0, periods_until(&input, REASON_MOTOR_HOT));
}

static void test_overspeed_in_either_direction(void)
{
    protection_input_t input = healthy;
    input.omega_m = 220.5f;
    expect_fault(&input, REASON_OVERSPEED, 10);
    input.omega_m = -220.5f;
    expect_fault(&input, REASON_OVERSPEED, 10);
    input.omega_m = -220.0f;
    protection_reset(&protection);
    TEST_ASSERT_EQUAL_UINT32(0, periods_until(&input, REASON_OVERSPEED));
}

static void test_flags_stop_the_drive(void)
{
    protection_input_t input = healthy;
    input.tripped = 1u;
    expect_fault(&input, REASON_MODULE_FAULT, 1);
    input = healthy;
    input.encoder_error = 1u;
    expect_fault(&input, REASON_ENCODER_PHASE, 1);
    input = healthy;
    input.late = 1u;
    expect_fault(&input, REASON_LATE, 3);
    input = healthy;
    input.bad_sample = 1u;
    expect_fault(&input, REASON_BAD_SAMPLE, 3);
}

static void test_with_the_bridge_off_only_lasting_dangers_count(void)
{
    protection_input_t input = healthy;
    input.bridge_on = 0u;
    input.tripped = 1u;
    input.u_dc = 0.0f;
    input.omega_m = 1000.0f;
    input.encoder_error = 1u;
    input.late = 1u;
    input.estimate = 15u;
    for (int n = 0; n < 2000; n++) {
        TEST_ASSERT_EQUAL_HEX32(0, protection_step(&protection, &input));
    }
    input.u_dc = 401.0f;
    TEST_ASSERT_EQUAL_UINT32(2, periods_until(&input, REASON_DC_OVERVOLTAGE));
}

/* The estimator counts by itself; here each of its signs stops at once, below every other fault. */
static void test_each_sign_of_a_lost_estimate_stops_at_once(void)
{
    static const int32_t lost[] = {REASON_ESTIMATE_AMPLITUDE, REASON_ESTIMATE_DETECTOR,
                                   REASON_ESTIMATE_CURRENT, REASON_ESTIMATE_SPEED};
    protection_input_t input = healthy;
    for (uint32_t n = 0; n < 4u; n++) {
        input.estimate = UINT32_C(1) << n;
        expect_fault(&input, lost[n], 1);
        TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << (10u + n), protection_step(&protection, &input));
        TEST_ASSERT_EQUAL_HEX32(0, protection_step(&protection, &healthy));
    }
    input.estimate = 15u;
    TEST_ASSERT_EQUAL_HEX32(15u << 10, protection_step(&protection, &input));
    TEST_ASSERT_EQUAL_INT32(REASON_ESTIMATE_AMPLITUDE, protection_reason(15u << 10));
    input.motor_temperature = 131.0f; /* whatever else is wrong is named first */
    for (int n = 0; n < 1000; n++) {
        (void)protection_step(&protection, &input);
    }
    TEST_ASSERT_EQUAL_INT32(REASON_MOTOR_HOT, protection_reason(protection_step(&protection, &input)));
}

static void test_every_row_of_the_fault_table_has_a_reason_of_its_own(void)
{
    for (uint32_t n = 0; n < PROTECTION_FAULTS; n++) {
        const int32_t reason = protection_reason(UINT32_C(1) << n);
        TEST_ASSERT_NOT_NULL(reason_by_number(reason));
        TEST_ASSERT_TRUE(reason >= REASON_MODULE_FAULT && protection_debounce(reason) > 0u);
        for (uint32_t m = 0; m < n; m++) {
            TEST_ASSERT_TRUE(protection_reason(UINT32_C(1) << m) != reason);
        }
    }
}

static void test_a_break_starts_the_debounce_again(void)
{
    protection_input_t low = healthy;
    low.u_dc = 100.0f;
    for (int n = 0; n < 50; n++) {
        for (int m = 0; m < 9; m++) {
            TEST_ASSERT_EQUAL_HEX32(0, protection_step(&protection, &low));
        }
        TEST_ASSERT_EQUAL_HEX32(0, protection_step(&protection, &healthy));
    }
}

static void test_a_lasting_fault_stays_reported(void)
{
    protection_input_t input = healthy;
    input.u_dc = 100.0f;
    TEST_ASSERT_EQUAL_UINT32(10, periods_until(&input, REASON_DC_UNDERVOLTAGE));
    for (int n = 0; n < 100; n++) {
        TEST_ASSERT_EQUAL_INT32(REASON_DC_UNDERVOLTAGE,
                                protection_reason(protection_step(&protection, &input)));
    }
}

static void test_the_gravest_of_several_is_named_and_all_are_shown(void)
{
    protection_input_t input = healthy;
    input.tripped = 1u;
    input.current.a = 16.0f;
    const uint32_t faults = protection_step(&protection, &input);
    TEST_ASSERT_EQUAL_INT32(REASON_MODULE_FAULT, protection_reason(faults));
    TEST_ASSERT_EQUAL_HEX32(3, faults);
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, protection_reason(0));
    TEST_ASSERT_EQUAL_UINT32(0, protection_debounce(REASON_NONE));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_healthy_drive_runs_on);
    RUN_TEST(test_each_phase_stops_at_once_above_its_limit_in_either_sign);
    RUN_TEST(test_dc_link_limits);
    RUN_TEST(test_temperatures_stop_after_a_tenth_of_a_second);
    RUN_TEST(test_overspeed_in_either_direction);
    RUN_TEST(test_flags_stop_the_drive);
    RUN_TEST(test_with_the_bridge_off_only_lasting_dangers_count);
    RUN_TEST(test_each_sign_of_a_lost_estimate_stops_at_once);
    RUN_TEST(test_every_row_of_the_fault_table_has_a_reason_of_its_own);
    RUN_TEST(test_a_break_starts_the_debounce_again);
    RUN_TEST(test_a_lasting_fault_stays_reported);
    RUN_TEST(test_the_gravest_of_several_is_named_and_all_are_shown);
    return UNITY_END();
}
