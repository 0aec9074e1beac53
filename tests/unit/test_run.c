#include "manoeuvre/run.h"

#include <string.h>
#include <unity.h>

/* The paper's speed control; powers of two where the sums shall be exact. */
static const speed_control_params_t SPEED = {.kp = 0.5f, .ki = 2.5f, .current_limit = 10.0f, .period = 1e-4f};

#define FLUX 0.125f /* [Wb] */

static run_t run;

static run_tuning_t tuning_of(const speed_control_params_t *speed, float flux_linkage)
{
    return (run_tuning_t){speed_control_prepare(speed), flux_linkage};
}

void setUp(void)
{
    const run_tuning_t tuning = tuning_of(&SPEED, FLUX);
    memset(&run, 0x55, sizeof run);
    run_init(&run, &tuning);
}

void tearDown(void)
{
}

static demand_t step(run_mode_t mode, float omega_m_ref, float d, float q, float omega_m)
{
    const run_wish_t wish = {mode, omega_m_ref, {d, q}};
    return run_step(&run, &wish, 4.0f * omega_m, omega_m);
}

static void expect(demand_t demand, float d, float q, float omega_m_ref)
{
    TEST_ASSERT_EQUAL_FLOAT(d, demand.current.d);
    TEST_ASSERT_EQUAL_FLOAT(q, demand.current.q);
    TEST_ASSERT_EQUAL_FLOAT(omega_m_ref, demand.omega_m_ref);
}

static void test_emf_is_the_flux_turning_whatever_is_wished_for(void)
{
    static const run_mode_t modes[] = {RUN_ZERO, RUN_CURRENT, RUN_SPEED};
    for (int n = 0; n < 3; n++) {
        for (int way = -1; way <= 1; way++) {
            const run_wish_t wish = {modes[n], 3.0f, {1.0f, 2.0f}};
            const demand_t demand = run_step(&run, &wish, 400.0f * (float)way, 7.0f);
            TEST_ASSERT_EQUAL_FLOAT(0.0f, demand.emf.d);
            TEST_ASSERT_EQUAL_FLOAT(400.0f * 0.125f * (float)way, demand.emf.q);
        }
    }
}

static void test_zero_asks_for_nothing_and_leaves_the_speed_control_at_rest(void)
{
    for (int n = 0; n < 100; n++) {
        expect(step(RUN_ZERO, 20.0f, 1.0f, 2.0f, 5.0f), 0.0f, 0.0f, 0.0f);
    }
    expect(step(RUN_SPEED, 5.0f, 0.0f, 0.0f, 5.0f), 0.0f, 0.0f, 5.0f);
}

static void test_currents_are_taken_as_they_are_wished_for(void)
{
    expect(step(RUN_CURRENT, 99.0f, -1.5f, 3.0f, 5.0f), -1.5f, 3.0f, 5.0f);
    expect(step(RUN_CURRENT, 99.0f, 1.0f, -4.0f, -2.0f), 1.0f, -4.0f, -2.0f);
}

/* kp (ref - omega) at first; then ki T of it more in every step: 2.5e-4 A/(rad/s). */
static void test_speed_makes_the_torque_current_and_the_wish_the_other(void)
{
    expect(step(RUN_SPEED, 12.0f, -2.0f, 7.0f, 4.0f), -2.0f, 4.0f, 12.0f);
    for (int n = 0; n < 999; n++) {
        (void)step(RUN_SPEED, 12.0f, -2.0f, 7.0f, 4.0f);
    }
    /* a thousand sums below 2 round by 6e-8 each */
    TEST_ASSERT_FLOAT_WITHIN(6e-5f, 4.0f + 1000.0f * 2.5e-4f * 8.0f,
                             step(RUN_SPEED, 12.0f, 0.0f, 0.0f, 4.0f).current.q);
}

static void test_torque_current_stays_within_the_limit(void)
{
    expect(step(RUN_SPEED, 100.0f, 0.0f, 0.0f, 0.0f), 0.0f, 10.0f, 100.0f);
    expect(step(RUN_SPEED, -100.0f, 0.0f, 0.0f, 0.0f), 0.0f, -10.0f, -100.0f);
}

/* At the reference the first torque current is the one that flowed. */
static void test_from_current_to_speed_without_a_jump(void)
{
    for (int n = 0; n < 10; n++) {
        (void)step(RUN_CURRENT, 0.0f, 0.0f, 1.0f + (float)n, 8.0f);
    }
    expect(step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f), 0.0f, 10.0f, 8.0f);
    (void)step(RUN_CURRENT, 0.0f, 0.0f, -3.0f, 8.0f);
    expect(step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f), 0.0f, -3.0f, 8.0f);
}

static void test_reset_starts_without_a_current(void)
{
    (void)step(RUN_CURRENT, 0.0f, 0.0f, 5.0f, 8.0f);
    run_reset(&run);
    expect(step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f), 0.0f, 0.0f, 8.0f);
}

static void test_new_coefficients_act_and_the_speed_control_goes_on(void)
{
    (void)step(RUN_CURRENT, 0.0f, 0.0f, 5.0f, 8.0f);
    speed_control_params_t speed = SPEED;
    speed.kp = 1.0f;
    speed.current_limit = 6.5f;
    const run_tuning_t tuning = tuning_of(&speed, 2.0f * FLUX);
    run_take(&run, &tuning);
    const demand_t demand = step(RUN_SPEED, 9.0f, 0.0f, 0.0f, 8.0f);
    expect(demand, 0.0f, 6.0f, 9.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.25f * 32.0f, demand.emf.q);
    expect(step(RUN_SPEED, 18.0f, 0.0f, 0.0f, 8.0f), 0.0f, 6.5f, 18.0f);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_emf_is_the_flux_turning_whatever_is_wished_for);
    RUN_TEST(test_zero_asks_for_nothing_and_leaves_the_speed_control_at_rest);
    RUN_TEST(test_currents_are_taken_as_they_are_wished_for);
    RUN_TEST(test_speed_makes_the_torque_current_and_the_wish_the_other);
    RUN_TEST(test_torque_current_stays_within_the_limit);
    RUN_TEST(test_from_current_to_speed_without_a_jump);
    RUN_TEST(test_reset_starts_without_a_current);
    RUN_TEST(test_new_coefficients_act_and_the_speed_control_goes_on);
    return UNITY_END();
}
