#include "manoeuvre/run.h"

#include <string.h>
#include <unity.h>

/* The paper's speed control; powers of two where the sums shall be exact. */
static const speed_control_params_t SPEED = {
    .kp = 0.5f, .ki = 2.5f, .weight = 1.0f, .current_limit = 10.0f, .period = 1e-4f};

#define FLUX       0.125f /* [Wb] */
#define POLE_PAIRS 4.0f

static run_t run;

/* No ramps, no current that is not wished for; of a hand-over half is left a period later. */
static run_tuning_t tuning_of(const speed_control_params_t *speed, float flux_linkage)
{
    return (run_tuning_t){
        .speed = speed_control_prepare(speed), .flux_linkage = flux_linkage, .low_share = 1.0f, .fade = 0.5f};
}

static void begin(const run_tuning_t *tuning)
{
    memset(&run, 0x55, sizeof run);
    run_init(&run, tuning);
}

void setUp(void)
{
    const run_tuning_t tuning = tuning_of(&SPEED, FLUX);
    begin(&tuning);
}

static demand_t step(run_mode_t mode, float omega_m_ref, float d, float q, float omega_m)
{
    const run_wish_t wish = {mode, omega_m_ref, {d, q}};
    demand_t demand;
    run_step(&run, &wish, POLE_PAIRS * omega_m, omega_m, &demand);
    return demand;
}

static void expect(demand_t demand, float d, float q, float omega_m_ref)
{
    TEST_ASSERT_EQUAL_FLOAT(d, demand.current.d);
    TEST_ASSERT_EQUAL_FLOAT(q, demand.current.q);
    TEST_ASSERT_EQUAL_FLOAT(omega_m_ref, demand.omega_m_ref);
}

/* Where no observer sees it. */
static void test_emf_is_the_flux_turning(void)
{
    for (int way = -1; way <= 1; way++) {
        const dq_t emf = run_emf(&run, 400.0f * (float)way);
        TEST_ASSERT_TRUE(emf.d == 0.0f && emf.q == 400.0f * 0.125f * (float)way);
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

/* What heat and DC link leave holds for what is wished for too, has two sides, and may ask for a current. */
static void test_torque_current_stays_within_what_is_left_of_the_limit(void)
{
    run_limit(&run, -2.0f, 4.0f);
    expect(step(RUN_SPEED, 100.0f, 0.0f, 0.0f, 0.0f), 0.0f, 4.0f, 100.0f);
    expect(step(RUN_SPEED, -100.0f, 0.0f, 0.0f, 0.0f), 0.0f, -2.0f, -100.0f);
    expect(step(RUN_CURRENT, 0.0f, 1.0f, 9.0f, 8.0f), 1.0f, 4.0f, 8.0f);
    expect(step(RUN_CURRENT, 0.0f, 1.0f, -9.0f, 8.0f), 1.0f, -2.0f, 8.0f);
    run_limit(&run, -10.0f, -3.0f);
    expect(step(RUN_SPEED, 100.0f, 0.0f, 0.0f, 0.0f), 0.0f, -3.0f, 100.0f);
    expect(step(RUN_STOP, 0.0f, 0.0f, 0.0f, -100.0f), 0.0f, -3.0f, 0.0f);
    run_enter(&run, (dq_t){6.0f, 0.0f}, 0.0f); /* beside what a hand-over has left */
    run_limit(&run, -9.0f, 9.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 8.0f, step(RUN_SPEED, 100.0f, 0.0f, 0.0f, 0.0f).current.q);
}

/* A limit that comes and goes: what it cuts off leaves the integral with k_i/k_p, as at current_limit; after
 * half a second exp(-2.5) of 4 A is left. */
static void test_what_a_limit_cuts_off_leaves_the_integral(void)
{
    for (int n = 0; n < 1000; n++) {
        (void)step(RUN_CURRENT, 0.0f, 0.0f, 5.0f, 8.0f);
    }
    run_limit(&run, -10.0f, 1.0f);
    for (int n = 0; n < 5000; n++) {
        TEST_ASSERT_TRUE(step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f).current.q == 1.0f);
    }
    run_limit(&run, -10.0f, 10.0f);
    const float first = step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f).current.q;
    TEST_ASSERT_FLOAT_WITHIN(2e-3f, 1.0f + 4.0f * 0.082085f, first);
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

/* From a hand-over: its i_q is held and its speed is the reference, its i_d fades by a half a period. */
static void test_it_is_entered_with_the_current_that_flows(void)
{
    (void)step(RUN_CURRENT, 0.0f, 0.0f, 5.0f, 8.0f);
    run_enter(&run, (dq_t){4.0f, 3.0f}, -8.0f);
    for (float left = 2.0f; left > 0.1f; left *= 0.5f) {
        expect(step(RUN_SPEED, -8.0f, 0.0f, 0.0f, -8.0f), left, 3.0f, -8.0f);
    }
    run_enter(&run, (dq_t){0.0f, 0.0f}, 8.0f);
    expect(step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f), 0.0f, 0.0f, 8.0f);
}

/* What a hand-over has left goes first, for it fades without a step: sqrt(10^2 - 6^2) is left beside 6 A, all
 * of it once it is gone. */
static void test_the_torque_current_fits_beside_what_a_hand_over_has_left(void)
{
    run_enter(&run, (dq_t){6.0f, 10.0f}, 8.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 8.0f, step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f).current.q);
    run_enter(&run, (dq_t){20.0f, 10.0f}, 8.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.0f, step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f).current.q);
    for (int n = 0; n < 20; n++) {
        (void)step(RUN_SPEED, 100.0f, 0.0f, 0.0f, 8.0f);
    }
    TEST_ASSERT_TRUE(step(RUN_SPEED, 100.0f, 0.0f, 0.0f, 8.0f).current.q == 10.0f);
}

/* 1/1024 rad/s a period up and down, the quick stop's is another; 0: at once. */
static void test_ramps_take_the_reference_to_the_wish(void)
{
    run_tuning_t tuning = tuning_of(&SPEED, FLUX);
    tuning.ramp = 1.0f / 1024.0f;
    tuning.stop_ramp = 1.0f / 256.0f;
    run_take(&run, &tuning);
    run_enter(&run, (dq_t){0.0f, 0.0f}, 2.0f);
    for (int n = 1; n <= 1024; n++) {
        TEST_ASSERT_EQUAL_FLOAT(2.0f + (float)n / 1024.0f,
                                step(RUN_SPEED, 3.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    }
    TEST_ASSERT_EQUAL_FLOAT(3.0f, step(RUN_SPEED, 3.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    for (int n = 1; n <= 768; n++) { /* the wish in a quick stop is to stand, whatever the request */
        TEST_ASSERT_EQUAL_FLOAT(3.0f - (float)n / 256.0f, step(RUN_STOP, 9.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    }
    TEST_ASSERT_EQUAL_FLOAT(0.0f, step(RUN_STOP, 9.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    tuning.ramp = 0.0f;
    tuning.stop_ramp = 0.0f;
    run_take(&run, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(-7.0f, step(RUN_SPEED, -7.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, step(RUN_STOP, -7.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
}

/* A ramp begins where the motor is, not where the reference was before another mode. */
static void test_a_ramp_begins_at_the_speed_of_the_motor(void)
{
    run_tuning_t tuning = tuning_of(&SPEED, FLUX);
    tuning.ramp = 0.25f;
    run_take(&run, &tuning);
    static const run_mode_t modes[] = {RUN_ZERO, RUN_CURRENT};
    for (int n = 0; n < 2; n++) {
        run_enter(&run, (dq_t){0.0f, 0.0f}, -50.0f);
        (void)step(modes[n], 0.0f, 0.0f, 1.0f, 8.0f);
        TEST_ASSERT_EQUAL_FLOAT(8.25f, step(RUN_SPEED, 20.0f, 0.0f, 0.0f, 8.0f).omega_m_ref);
    }
}

/* 1/low_inverse = 100 rad/s: all of 2 A up to 20 rad/s, a fifth of it, and no less, from 100 rad/s on, in
 * either direction; i_q counts, i_d that is wished for does not. */
static void test_at_low_speed_the_current_vector_is_kept_long(void)
{
    static const struct {
        float omega_e, i_q, i_d;
    } cases[] = {{0.0f, 0.0f, 2.0f},   {20.0f, 0.0f, 2.0f},   {-20.0f, 0.0f, 2.0f}, {70.0f, 0.0f, 1.0f},
                 {-70.0f, 0.5f, 0.5f}, {70.0f, -0.5f, 0.5f},  {100.0f, 0.0f, 0.4f}, {800.0f, 0.0f, 0.4f},
                 {0.0f, 1.5f, 0.5f},   {0.0f, -1.5f, 0.5f},   {0.0f, 2.0f, 0.0f},   {0.0f, 5.0f, 0.0f},
                 {70.0f, 1.0f, 0.0f},  {-300.0f, 0.4f, 0.0f}, {300.0f, 0.1f, 0.3f}};
    run_tuning_t tuning = tuning_of(&SPEED, FLUX);
    tuning.low_current = 2.0f;
    tuning.low_inverse = 0.01f;
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const float omega_m = cases[n].omega_e / POLE_PAIRS;
        begin(&tuning);
        run_enter(&run, (dq_t){0.0f, cases[n].i_q}, omega_m);
        const demand_t demand = step(RUN_SPEED, omega_m, -3.0f, 0.0f, omega_m);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, cases[n].i_q, demand.current.q);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, cases[n].i_d - 3.0f, demand.current.d);
    }
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
    TEST_ASSERT_EQUAL_FLOAT(0.25f * 32.0f, run_emf(&run, 32.0f).q);
    expect(step(RUN_SPEED, 18.0f, 0.0f, 0.0f, 8.0f), 0.0f, 6.5f, 18.0f);
}
