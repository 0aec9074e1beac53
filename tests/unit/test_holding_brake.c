/* The holding brake: the next state at each evaluation. */
#include "medium/protect/holding_brake.h"
#include "tests/unit/compare.h"

#define LOOK 0.8e-3 /* [s] between two evaluations */

static holding_brake_t brake;
static holding_brake_tuning_t tuning;
static holding_brake_input_t input;

void setUp(void)
{
    const holding_brake_params_t params = {
        .on = true,
        .release_time = 40e-3f, /* [s] 50 evaluations */
        .apply_time = 80e-3f,   /* [s] 100 evaluations */
        .preload = 7.0f,
        .current_limit = 10.0f,
        .period = (float)LOOK,
    };
    brake = (holding_brake_t){0};
    tuning = holding_brake_prepare(&params);
    input = (holding_brake_input_t){.bridge = true, .holds = true, .set = false, .torque = 7.0f};
}

/* The number of evaluations until this state, at most `most`. */
static uint32_t until(brake_state_t state, uint32_t most)
{
    uint32_t n = 0u;
    while (brake.state != (int32_t)state && n < most) {
        holding_brake_step(&brake, &tuning, &input);
        n++;
    }
    TEST_ASSERT_EQUAL_INT32(state, brake.state);
    return n;
}

static void stays(brake_state_t state, uint32_t looks)
{
    for (uint32_t n = 0; n < looks; n++) {
        holding_brake_step(&brake, &tuning, &input);
        TEST_ASSERT_EQUAL_INT32(state, brake.state);
    }
}

static void test_it_is_released_when_the_torque_is_there(void)
{
    TEST_ASSERT_EQUAL_UINT32(6u, until(BRAKE_RELEASING, 100u)); /* [evaluations] 4 ms, and one more */
    TEST_ASSERT_TRUE(holding_brake_opens(&brake));
    /* The release time is 50 evaluations; one more follows, and two until the output is set. */
    TEST_ASSERT_EQUAL_UINT32(53u, until(BRAKE_RELEASED, 1000u));
    TEST_ASSERT_TRUE(holding_brake_opens(&brake));
    TEST_ASSERT_EQUAL_UINT32(0u, brake.failed);
}

/* 5 % of the limit of 10 A are 0.5 A; half a second are 625 evaluations. */
static void test_it_stays_set_without_the_torque_and_that_is_a_fault(void)
{
    input.torque = 6.4f;
    for (uint32_t n = 0; n < 625u; n++) {
        holding_brake_step(&brake, &tuning, &input);
        TEST_ASSERT_EQUAL_INT32(BRAKE_SET, brake.state);
        TEST_ASSERT_FALSE(holding_brake_opens(&brake));
        TEST_ASSERT_EQUAL_UINT32(0u, brake.failed);
    }
    holding_brake_step(&brake, &tuning, &input);
    TEST_ASSERT_EQUAL_UINT32(1u, brake.failed);
    input.bridge = false;
    stays(BRAKE_SET, 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, brake.failed);
}

static void test_a_torque_that_comes_and_goes_does_not_release_it(void)
{
    for (uint32_t n = 0; n < 300u; n++) {
        input.torque = n % 6u == 5u ? 0.0f : 7.0f;
        stays(BRAKE_SET, 1u);
    }
}

static void test_it_stays_set_while_control_does_not_hold_the_rotor(void)
{
    input.holds = false;
    stays(BRAKE_SET, 2000u);
    TEST_ASSERT_EQUAL_UINT32(0u, brake.failed);
}

static void test_it_is_set_for_its_apply_time_before_it_counts_as_set(void)
{
    (void)until(BRAKE_RELEASED, 1000u);
    input.set = true;
    stays(BRAKE_APPLYING, 1u);
    TEST_ASSERT_FALSE(holding_brake_opens(&brake));
    /* The apply time is 100 evaluations; one more follows, and two until the output is set. */
    TEST_ASSERT_EQUAL_UINT32(103u, until(BRAKE_SET, 1000u));
    stays(BRAKE_SET, 2000u);
    TEST_ASSERT_EQUAL_UINT32(0u, brake.failed);
}

static void test_a_bridge_that_opens_sets_it_in_every_state(void)
{
    static const brake_state_t states[] = {BRAKE_SET, BRAKE_RELEASING, BRAKE_RELEASED, BRAKE_APPLYING};
    for (size_t n = 0; n < sizeof states / sizeof states[0]; n++) {
        setUp();
        input.set = false;
        if (states[n] == BRAKE_APPLYING) {
            (void)until(BRAKE_RELEASED, 1000u);
            input.set = true;
        }
        (void)until(states[n], 1000u);
        input.bridge = false;
        stays(BRAKE_SET, 1u);
        TEST_ASSERT_FALSE(holding_brake_opens(&brake));
    }
}

static void test_a_stop_during_the_release_sets_it(void)
{
    (void)until(BRAKE_RELEASING, 100u);
    input.set = true;
    stays(BRAKE_APPLYING, 1u);
}
