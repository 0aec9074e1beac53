/* Running: the speed reference on its ramps, and what of i_d nobody has wished for. */
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
static void begin(float ramp, float stop_ramp, float low_current)
{
    const speed_control_params_t speed = {
        .kp = 0.5f, .ki = 2.5f, .weight = 0.0f, .current_limit = LIMIT, .period = (float)T};
    tuning = (run_tuning_t){
        .speed = speed_control_prepare(&speed),
        .flux_linkage = 0.183f,
        .ramp = ramp * (float)T,
        .stop_ramp = stop_ramp * (float)T,
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
    begin(100.0f, 400.0f, 0.0f);
}

void tearDown(void)
{
}

static demand_t step(run_mode_t mode, float wanted, float omega_m)
{
    const run_wish_t wish = {mode, wanted, {0.0f, 0.0f}};
    const frame_t rotor = {0.4f, POLE_PAIRS * omega_m, {0.389418342f, 0.921060994f}};
    return run_step(&run, &wish, &rotor, run_emf(&run, rotor.omega_e), omega_m);
}

static void test_reference_goes_by_its_ramp_and_ends_on_what_is_wished_for(void)
{
    for (int way = -1; way <= 1; way += 2) {
        run_enter(&run, (dq_t){0.0f, 0.0f}, (float)way * -3.0f);
        for (int n = 1; n <= 2000; n++) {
            const double expected = fmin(-3.0 + 100.0 * T * n, 12.0);
            TEST_ASSERT_DOUBLE_WITHIN(
                1e-3, way * expected,
                (double)step(RUN_SPEED, (float)way * 12.0f, (float)way * -3.0f).omega_m_ref);
        }
        TEST_ASSERT_EQUAL_FLOAT((float)way * 12.0f, run.omega_m_ref);
    }
}

static void test_without_a_ramp_it_is_there_at_once(void)
{
    begin(0.0f, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_FLOAT(50.0f, step(RUN_SPEED, 50.0f, 1.0f).omega_m_ref);
    TEST_ASSERT_EQUAL_FLOAT(-50.0f, step(RUN_SPEED, -50.0f, 1.0f).omega_m_ref);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, step(RUN_STOP, -50.0f, 1.0f).omega_m_ref);
}

/* From where it is; to zero whatever is wished for. */
static void test_quick_stop_has_a_ramp_of_its_own(void)
{
    for (int way = -1; way <= 1; way += 2) {
        run_enter(&run, (dq_t){0.0f, 0.0f}, (float)way * 20.0f);
        for (int n = 1; n <= 1000; n++) {
            const double expected = fmax(20.0 - 400.0 * T * n, 0.0);
            TEST_ASSERT_DOUBLE_WITHIN(
                1e-3, way * expected,
                (double)step(RUN_STOP, (float)way * 30.0f, (float)way * 20.0f).omega_m_ref);
        }
        TEST_ASSERT_EQUAL_FLOAT(0.0f, run.omega_m_ref);
    }
}

/* It starts from the speed, not from where it was before. */
static void test_reference_starts_from_the_speed_after_a_wish_for_current(void)
{
    (void)step(RUN_SPEED, 50.0f, 0.0f);
    (void)step(RUN_CURRENT, 0.0f, 30.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 30.0 + 100.0 * T, (double)step(RUN_SPEED, 50.0f, 30.0f).omega_m_ref);
    (void)step(RUN_ZERO, 0.0f, -7.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -7.0 + 100.0 * T, (double)step(RUN_SPEED, 50.0f, -7.0f).omega_m_ref);
}

/* At the speed that the reference starts from the first i_q is the one that flowed, but for one step of the
 * ramp, which the integral alone sees: later. */
static void test_current_of_a_hand_over_is_held(void)
{
    static const float currents[] = {0.0f, 4.5f, -4.5f, 9.9f};
    static const float speeds[] = {15.0f, -15.0f, 0.0f};
    for (int n = 0; n < 12; n++) {
        const dq_t current = {3.0f, currents[n % 4]};
        const float omega_m = speeds[n / 4];
        run_enter(&run, current, omega_m);
        const demand_t demand = step(RUN_SPEED, omega_m, omega_m);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, current.q, demand.current.q);
        TEST_ASSERT_EQUAL_FLOAT(omega_m, demand.omega_m_ref);
    }
}

/* With 0.1 s; beside no i_q worth the name it is not cut. */
static void test_i_d_of_a_hand_over_fades(void)
{
    run_enter(&run, (dq_t){6.0f, 0.0f}, 15.0f);
    for (int n = 1; n <= 10000; n++) {
        const demand_t demand = step(RUN_SPEED, 15.0f, 15.0f);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 6.0 * exp(-T * n / 0.1), (double)demand.current.d);
    }
}

/* i_q first: 8 A leave 6 A. */
static void test_i_d_stays_within_the_longest_vector(void)
{
    run_enter(&run, (dq_t){9.0f, 8.0f}, 15.0f);
    const demand_t demand = step(RUN_SPEED, 15.0f, 15.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 6.0f, demand.current.d);
    run_enter(&run, (dq_t){9.0f, 10.0f}, 15.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, step(RUN_SPEED, 15.0f, 15.0f).current.d);
}

/* What is kept at low speed too, when i_q jumps faster than it goes. */
static void test_low_speed_current_leaves_the_longest_vector_alone(void)
{
    begin(0.0f, 0.0f, LOW);
    for (int n = 0; n < 10000; n++) {
        (void)step(RUN_SPEED, 0.0f, 0.0f);
    }
    for (int n = 0; n < 2000; n++) {
        const dq_t current = step(RUN_SPEED, 0.0f, -100.0f).current;
        TEST_ASSERT_TRUE(hypot((double)current.d, (double)current.q) <= 10.0 * 1.00001);
    }
    TEST_ASSERT_EQUAL_FLOAT(10.0f, step(RUN_SPEED, 0.0f, -100.0f).current.q);
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
    begin(0.0f, 0.0f, LOW);
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
    begin(0.0f, 0.0f, LOW);
    run_enter(&run, (dq_t){0.0f, 0.0f}, 0.0f);
    for (int n = 1; n <= 3000; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2.0 * (1.0 - exp(-20.0 * T * n)),
                                  (double)step(RUN_SPEED, 0.0f, 0.0f).current.d);
    }
}

/* The larger of the two, not their sum; what is wished for comes on top. */
static void test_larger_of_both_is_added_to_the_wish(void)
{
    begin(0.0f, 0.0f, LOW);
    run_enter(&run, (dq_t){4.0f, 0.0f}, 0.0f);
    for (int n = 1; n <= 5000; n++) {
        const run_wish_t wish = {RUN_SPEED, 0.0f, {-1.0f, 7.0f}};
        const frame_t rotor = {0.0f, 0.0f, {0.0f, 1.0f}};
        const demand_t demand = run_step(&run, &wish, &rotor, run_emf(&run, 0.0f), 0.0f);
        const double left = 4.0 * exp(-T * n / 0.1), low = 2.0 * (1.0 - exp(-20.0 * T * n));
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, fmax(left, low) - 1.0, (double)demand.current.d);
    }
}

/* Beyond ten hand-over speeds a fifth is left; a wish for currents gets what it wishes. */
static void test_wish_for_currents_gets_nothing_else(void)
{
    begin(0.0f, 0.0f, LOW);
    run_enter(&run, (dq_t){4.0f, 1.0f}, 0.0f);
    const run_wish_t wish = {RUN_CURRENT, 9.0f, {-1.5f, 3.0f}};
    const frame_t rotor = {0.0f, 8.0f, {0.0f, 1.0f}};
    const demand_t demand = run_step(&run, &wish, &rotor, (dq_t){1.0f, 2.0f}, 2.0f);
    TEST_ASSERT_TRUE(demand.current.d == -1.5f && demand.current.q == 3.0f && demand.omega_m_ref == 2.0f);
    TEST_ASSERT_TRUE(demand.emf.d == 1.0f && demand.emf.q == 2.0f);
    TEST_ASSERT_EQUAL_INT32(FRAME_GOES_ON, demand.change);
    TEST_ASSERT_EQUAL_MEMORY(&rotor, &demand.frame, sizeof rotor);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reference_goes_by_its_ramp_and_ends_on_what_is_wished_for);
    RUN_TEST(test_without_a_ramp_it_is_there_at_once);
    RUN_TEST(test_quick_stop_has_a_ramp_of_its_own);
    RUN_TEST(test_reference_starts_from_the_speed_after_a_wish_for_current);
    RUN_TEST(test_current_of_a_hand_over_is_held);
    RUN_TEST(test_i_d_of_a_hand_over_fades);
    RUN_TEST(test_i_d_stays_within_the_longest_vector);
    RUN_TEST(test_low_speed_current_leaves_the_longest_vector_alone);
    RUN_TEST(test_low_speed_current_fills_up_what_i_q_leaves);
    RUN_TEST(test_low_speed_current_comes_with_its_low_pass);
    RUN_TEST(test_larger_of_both_is_added_to_the_wish);
    RUN_TEST(test_wish_for_currents_gets_nothing_else);
    return UNITY_END();
}
