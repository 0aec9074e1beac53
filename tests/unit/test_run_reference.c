/* Running: how a hand-over's current goes on, and what of i_d nobody has wished for. */
#include <string.h>
#include <unity.h>

#include "manoeuvre/run.h"
#include "tests/unit/compare.h"

#define T          1e-4
#define POLE_PAIRS 4.0f
#define LIMIT      10.0f
#define LOW        2.0f /* low-speed current [A] */
#define HANDOVER   60.0 /* [rad/s] electrical */

static run_t run;
static run_tuning_t tuning;

/* Integral-proportional speed control: 0.5 A s/rad, 2.5 A/rad. */
static void begin(float low_current)
{
    const speed_control_params_t speed = {
        .kp = 0.5f, .ki = 2.5f, .weight = 0.0f, .current_limit = LIMIT, .period = (float)T};
    tuning = (run_tuning_t){
        .speed = speed_control_prepare(&speed),
        .flux_linkage = 0.183f,
        .ramp = 100.0f * (float)T,
        .stop_ramp = 400.0f * (float)T,
        .low_current = low_current,
        .low_inverse = (float)(0.1 / HANDOVER),
        .low_share = (float)(1.0 - exp(-20.0 * T)),
        .fade = (float)exp(-T / 0.1),
    };
    memset(&run, 0x55, sizeof run);
    run_init(&run, &tuning);
}

void setUp(void)
{
    begin(0.0f);
}

static demand_t step(run_mode_t mode, float wanted, float omega_m)
{
    const run_wish_t wish = {mode, wanted, {0.0f, 0.0f}};
    demand_t demand;
    run_step(&run, &wish, POLE_PAIRS * omega_m, omega_m, &demand);
    return demand;
}

/* At the speed that the reference starts from the first i_q is the one that flowed. */
static void test_current_of_a_hand_over_is_held(void)
{
    static const float currents[] = {0.0f, 4.5f, -4.5f, 9.9f};
    static const float speeds[] = {15.0f, -15.0f, 0.0f};
    for (int n = 0; n < 12; n++) {
        const dq_t current = {1.0f, currents[n % 4]};
        const float omega_m = speeds[n / 4];
        run_enter(&run, current, omega_m);
        const demand_t demand = step(RUN_SPEED, omega_m, omega_m);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, current.q, demand.current.q);
        TEST_ASSERT_EQUAL_FLOAT(omega_m, demand.omega_m_ref);
    }
}

/* With 0.1 s. */
static void test_i_d_of_a_hand_over_fades(void)
{
    run_enter(&run, (dq_t){6.0f, 0.0f}, 15.0f);
    for (int n = 1; n <= 10000; n++) {
        const demand_t demand = step(RUN_SPEED, 15.0f, 15.0f);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 6.0 * exp(-T * n / 0.1), (double)demand.current.d);
    }
}

/* What fades goes first, so that both of them together are within the longest vector all the time. */
static void test_i_q_waits_for_what_a_hand_over_has_left(void)
{
    run_enter(&run, (dq_t){8.0f, 3.0f}, 15.0f);
    for (int n = 1; n <= 10000; n++) {
        const dq_t current = step(RUN_SPEED, 150.0f, 15.0f).current;
        const double length = hypot((double)current.d, (double)current.q);
        TEST_ASSERT_TRUE(length <= 10.0 * (1.0 + 2e-3)); /* a period's fading between the two */
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 8.0 * exp(-T * n / 0.1), (double)current.d);
    }
    TEST_ASSERT_EQUAL_FLOAT(10.0f, step(RUN_SPEED, 150.0f, 15.0f).current.q);
}

/* i_d that is settled at this speed [rad/s] electrical, beside this i_q, which integral and speed hold. */
static double settled_i_d(double omega_e, float i_q)
{
    const float omega_m = (float)omega_e / POLE_PAIRS;
    run_enter(&run, (dq_t){0.0f, i_q}, omega_m);
    demand_t demand = {0};
    for (int n = 0; n < 5000; n++) {
        demand = step(RUN_SPEED, omega_m, omega_m);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, i_q, demand.current.q);
    return (double)demand.current.d;
}

/* Whole up to two hand-over speeds, then a tenth less for each until a fifth is left, from ten on. */
static void test_low_speed_current_fills_up_what_i_q_leaves(void)
{
    static const struct {
        double speeds, kept;
    } cases[] = {{0.0, 1.0}, {1.0, 1.0}, {2.0, 1.0},  {3.0, 0.9},
                 {5.0, 0.7}, {9.0, 0.3}, {10.0, 0.2}, {30.0, 0.2}};
    begin(LOW);
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        for (int way = -1; way <= 1; way += 2) {
            const double omega_e = way * cases[n].speeds * HANDOVER;
            const double whole = 2.0 * cases[n].kept;
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, whole, settled_i_d(omega_e, 0.0f));
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, fmax(whole - 0.5, 0.0), settled_i_d(omega_e, 0.5f));
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, fmax(whole - 0.5, 0.0), settled_i_d(omega_e, -0.5f));
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, settled_i_d(omega_e, 5.0f));
        }
    }
}

static void test_low_speed_current_comes_with_its_low_pass(void)
{
    begin(LOW);
    run_enter(&run, (dq_t){0.0f, 0.0f}, 0.0f);
    for (int n = 1; n <= 3000; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2.0 * (1.0 - exp(-20.0 * T * n)),
                                  (double)step(RUN_SPEED, 0.0f, 0.0f).current.d);
    }
}

/* The larger of the two, not their sum, and no dip between them: what flows already of the low-speed current
 * is not asked for anew. What is wished for comes on top. */
static void test_larger_of_both_is_added_to_the_wish(void)
{
    begin(LOW);
    run_enter(&run, (dq_t){4.0f, 0.0f}, 0.0f);
    for (int n = 1; n <= 5000; n++) {
        const run_wish_t wish = {RUN_SPEED, 0.0f, {-1.0f, 7.0f}};
        demand_t demand;
        run_step(&run, &wish, 0.0f, 0.0f, &demand);
        const double left = 4.0 * exp(-T * n / 0.1), low = 2.0;
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, fmax(left, low) - 1.0, (double)demand.current.d);
    }
}

/* Beyond ten hand-over speeds a fifth is left; a wish for currents gets what it wishes. */
static void test_wish_for_currents_gets_nothing_else(void)
{
    begin(LOW);
    run_enter(&run, (dq_t){4.0f, 1.0f}, 0.0f);
    const run_wish_t wish = {RUN_CURRENT, 9.0f, {-1.5f, 3.0f}};
    demand_t demand;
    run_step(&run, &wish, 8.0f, 2.0f, &demand);
    TEST_ASSERT_TRUE(demand.current.d == -1.5f && demand.current.q == 3.0f && demand.omega_m_ref == 2.0f);
}
