#include "medium/manoeuvre/run.h"

#include "fast/reference/demand.h"
#include "tests/unit/compare.h"
#include "tests/unit/sweep.h"

/* The paper's speed control. The values are powers of two where the sums must be exact. */
static const speed_control_params_t SPEED = {
    .kp = 0.5f, .ki = 2.5f, .weight = 1.0f, .current_limit = 10.0f, .period = 1e-4f};

#define POLE_PAIRS 4.0f

static run_t run;

/* A tuning without ramps and with no current but the requested one; half of the current of a hand-over
 * remains after a period. */
static run_tuning_t tuning_of(const speed_control_params_t *speed)
{
    return (run_tuning_t){.speed = speed_control_prepare(speed), .low_share = 1.0f, .fade = 0.5f};
}

static void begin(const run_tuning_t *tuning)
{
    memset(&run, 0x55, sizeof run);
    run_init(&run, tuning);
}

void setUp(void)
{
    const run_tuning_t tuning = tuning_of(&SPEED);
    begin(&tuning);
}

static demand_t step(run_mode_t mode, float omega_m_ref, float d, float q, float omega_m)
{
    const run_wish_t wish = {mode, omega_m_ref, {d, q}, 0.0f};
    demand_t demand;
    run_step(&run, &wish, POLE_PAIRS * omega_m, omega_m, &demand.current, &demand.omega_m_ref);
    return demand;
}

static void expect(demand_t demand, float d, float q, float omega_m_ref)
{
    TEST_ASSERT_EQUAL_FLOAT(d, demand.current.d);
    TEST_ASSERT_EQUAL_FLOAT(q, demand.current.q);
    TEST_ASSERT_EQUAL_FLOAT(omega_m_ref, demand.omega_m_ref);
}

static void test_zero_requests_no_current_and_leaves_the_speed_control_at_rest(void)
{
    for (int n = 0; n < 100; n++) {
        expect(step(RUN_ZERO, 20.0f, 1.0f, 2.0f, 5.0f), 0.0f, 0.0f, 0.0f);
    }
    expect(step(RUN_SPEED, 5.0f, 0.0f, 0.0f, 5.0f), 0.0f, 0.0f, 5.0f);
}

static void test_currents_are_taken_as_requested(void)
{
    expect(step(RUN_CURRENT, 99.0f, -1.5f, 3.0f, 5.0f), -1.5f, 3.0f, 5.0f);
    expect(step(RUN_CURRENT, 99.0f, 1.0f, -4.0f, -2.0f), 1.0f, -4.0f, -2.0f);
}

/* i_q begins with kp (ref - omega), and each step adds ki T (ref - omega), with ki T = 2.5e-4 A/(rad/s). */
static void test_speed_makes_the_torque_current_and_the_request_the_other(void)
{
    expect(step(RUN_SPEED, 12.0f, -2.0f, 7.0f, 4.0f), -2.0f, 4.0f, 12.0f);
    for (int n = 0; n < 999; n++) {
        (void)step(RUN_SPEED, 12.0f, -2.0f, 7.0f, 4.0f);
    }
    /* A thousand sums below 2 are rounded by 6e-8 each. */
    TEST_ASSERT_FLOAT_WITHIN(6e-5f, 4.0f + 1000.0f * 2.5e-4f * 8.0f,
                             step(RUN_SPEED, 12.0f, 0.0f, 0.0f, 4.0f).current.q);
}

/* Between two steps i_q is a value at speed zero less a part in proportion to the present speed. At the
 * speed of the step it is the i_q of the step, and it decreases by k_p for each rad/s more. A requested
 * current does not decrease with the speed. */
static void test_it_gives_the_slope_of_i_q_over_the_speed_until_the_next_step(void)
{
    static const float weights[] = {1.0f, 0.5f, 0.0f};
    for (int n = 0; n < 3; n++) {
        speed_control_params_t speed = SPEED;
        speed.weight = weights[n];
        const run_tuning_t tuning = tuning_of(&speed);
        begin(&tuning);
        run_enter(&run, (dq_t){0.0f, 2.0f}, 8.0f);
        const float i_q = step(RUN_SPEED, 10.0f, 0.0f, 0.0f, 8.0f).current.q;
        TEST_ASSERT_EQUAL_FLOAT(0.5f, run.stiffness);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, i_q, run.i_q_standing - run.stiffness * 8.0f);
    }
    (void)step(RUN_CURRENT, 0.0f, 0.0f, 3.0f, 8.0f);
    TEST_ASSERT_TRUE(run.i_q_standing == 3.0f && run.stiffness == 0.0f);
    (void)step(RUN_ZERO, 0.0f, 0.0f, 3.0f, 8.0f);
    TEST_ASSERT_TRUE(run.i_q_standing == 0.0f && run.stiffness == 0.0f);
}

/* The signal shows a torque at a limit, but not a torque that is still rising, nor a requested current. */
static void test_a_limited_torque_is_shown_as_such(void)
{
    run_limit(&run, -2.0f, 4.0f);
    (void)step(RUN_SPEED, 7.9f, 0.0f, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_UINT32(0u, run.limited);
    (void)step(RUN_SPEED, 8.1f, 0.0f, 0.0f, 0.0f);
    TEST_ASSERT_EQUAL_UINT32(1u, run.limited);
    (void)step(RUN_STOP, 0.0f, 0.0f, 0.0f, 10.0f);
    TEST_ASSERT_EQUAL_UINT32(1u, run.limited);
    (void)step(RUN_CURRENT, 0.0f, 0.0f, 9.0f, 0.0f);
    TEST_ASSERT_EQUAL_UINT32(0u, run.limited);
}

/* The limits of the thermal model and of the DC link apply to requested currents too. Each has two sides
 * and may force a current. */
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
    run_enter(&run, (dq_t){6.0f, 0.0f}, 0.0f); /* in addition to the remaining current of a hand-over */
    run_limit(&run, -9.0f, 9.0f);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 8.0f, step(RUN_SPEED, 100.0f, 0.0f, 0.0f, 0.0f).current.q);
}

/* While a limit is active, the part of i_q beyond it is taken from the integral with k_i/k_p, as with
 * current_limit; after half a second exp(-2.5) of 4 A is left. */
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

/* If the speed is at the reference, the first torque current is the present one. */
static void test_from_current_to_speed_without_a_jump(void)
{
    for (int n = 0; n < 10; n++) {
        (void)step(RUN_CURRENT, 0.0f, 0.0f, 1.0f + (float)n, 8.0f);
    }
    expect(step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f), 0.0f, 10.0f, 8.0f);
    (void)step(RUN_CURRENT, 0.0f, 0.0f, -3.0f, 8.0f);
    expect(step(RUN_SPEED, 8.0f, 0.0f, 0.0f, 8.0f), 0.0f, -3.0f, 8.0f);
}

/* After a hand-over i_q is held, the speed becomes the reference, and i_d decreases by half per period. */
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

/* The ramp is 1/1024 rad/s per period upwards and downwards, and the quick stop has a ramp of its own; a
 * ramp of 0 is a step. */
static void test_ramps_take_the_reference_to_the_request(void)
{
    run_tuning_t tuning = tuning_of(&SPEED);
    tuning.ramp = 1.0f / 1024.0f;
    tuning.stop_ramp = 1.0f / 256.0f;
    run_take(&run, &tuning);
    run_enter(&run, (dq_t){0.0f, 0.0f}, 2.0f);
    for (int n = 1; n <= 1024; n++) {
        TEST_ASSERT_EQUAL_FLOAT(2.0f + (float)n / 1024.0f,
                                step(RUN_SPEED, 3.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    }
    TEST_ASSERT_EQUAL_FLOAT(3.0f, step(RUN_SPEED, 3.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    for (int n = 1; n <= 768; n++) { /* in a quick stop the reference is standstill, whatever is requested */
        TEST_ASSERT_EQUAL_FLOAT(3.0f - (float)n / 256.0f, step(RUN_STOP, 9.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    }
    TEST_ASSERT_EQUAL_FLOAT(0.0f, step(RUN_STOP, 9.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    tuning.ramp = 0.0f;
    tuning.stop_ramp = 0.0f;
    run_take(&run, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(-7.0f, step(RUN_SPEED, -7.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, step(RUN_STOP, -7.0f, 0.0f, 0.0f, 2.0f).omega_m_ref);
}

static void test_a_ramp_begins_at_the_speed_of_the_motor(void)
{
    run_tuning_t tuning = tuning_of(&SPEED);
    tuning.ramp = 0.25f;
    run_take(&run, &tuning);
    static const run_mode_t modes[] = {RUN_ZERO, RUN_CURRENT};
    for (int n = 0; n < 2; n++) {
        run_enter(&run, (dq_t){0.0f, 0.0f}, -50.0f);
        (void)step(modes[n], 0.0f, 0.0f, 1.0f, 8.0f);
        TEST_ASSERT_EQUAL_FLOAT(8.25f, step(RUN_SPEED, 20.0f, 0.0f, 0.0f, 8.0f).omega_m_ref);
    }
}

/* ---- with the ramps and low-passes of the drive ---- */

#define T        1e-4
#define LOW      2.0f /* low-speed current [A] */
#define HANDOVER 60.0 /* [rad/s] electrical */

/* Integral-proportional speed control; the rest of a hand-over decays with 0.1 s. */
static void begin_slow(float low_current)
{
    const speed_control_params_t speed = {
        .kp = 0.5f, .ki = 2.5f, .weight = 0.0f, .current_limit = 10.0f, .period = (float)T};
    const run_tuning_t tuning = {
        .speed = speed_control_prepare(&speed),
        .ramp = 100.0f * (float)T,
        .stop_ramp = 400.0f * (float)T,
        .low_current = low_current,
        .low_inverse = (float)(0.1 / HANDOVER),
        .low_share = (float)(1.0 - exp(-20.0 * T)),
        .fade = (float)exp(-T / 0.1),
    };
    begin(&tuning);
}

/* The decaying current of the hand-over is reduced first, so that the sum never exceeds the longest
 * vector. */
static void test_i_q_waits_for_the_rest_of_a_hand_over(void)
{
    begin_slow(0.0f);
    run_enter(&run, (dq_t){8.0f, 3.0f}, 15.0f);
    for (int n = 1; n <= 10000; n++) {
        const dq_t current = step(RUN_SPEED, 150.0f, 0.0f, 0.0f, 15.0f).current;
        const double length = hypot((double)current.d, (double)current.q);
        TEST_ASSERT_TRUE(length <= 10.0 * (1.0 + 2e-3)); /* the tolerance is the decay in a period */
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 8.0 * exp(-T * n / 0.1), (double)current.d);
    }
    TEST_ASSERT_EQUAL_FLOAT(10.0f, step(RUN_SPEED, 150.0f, 0.0f, 0.0f, 15.0f).current.q);
}

/* The i_d in steady state at this electrical speed [rad/s] with this i_q, which the integral and a
 * constant speed hold. */
static double settled_i_d(double omega_e, float i_q)
{
    const float omega_m = (float)omega_e / POLE_PAIRS;
    run_enter(&run, (dq_t){0.0f, i_q}, omega_m);
    demand_t demand = {0};
    for (int n = 0; n < 5000; n++) {
        demand = step(RUN_SPEED, omega_m, 0.0f, 0.0f, omega_m);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, i_q, demand.current.q);
    return (double)demand.current.d;
}

/* The low-speed current is complete up to two hand-over speeds; for each further hand-over speed it
 * decreases by a tenth until a fifth is left, from ten on. */
static void test_low_speed_current_fills_up_what_i_q_leaves(void)
{
    static const struct {
        double speeds, kept;
    } cases[] = {{0.0, 1.0}, {1.0, 1.0}, {2.0, 1.0},  {3.0, 0.9},
                 {5.0, 0.7}, {9.0, 0.3}, {10.0, 0.2}, {30.0, 0.2}};
    begin_slow(LOW);
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n += SWEEP_FEW) {
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
    begin_slow(LOW);
    run_enter(&run, (dq_t){0.0f, 0.0f}, 0.0f);
    for (int n = 1; n <= 3000; n++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2.0 * (1.0 - exp(-20.0 * T * n)),
                                  (double)step(RUN_SPEED, 0.0f, 0.0f, 0.0f, 0.0f).current.d);
    }
}

/* The larger of the two currents is used, not their sum, and there is no dip between them: the part of the
 * low-speed current that already flows is not requested again. A requested i_d is added to it. */
static void test_larger_of_both_is_added_to_the_request(void)
{
    begin_slow(LOW);
    run_enter(&run, (dq_t){4.0f, 0.0f}, 0.0f);
    for (int n = 1; n <= 5000; n++) {
        const run_wish_t wish = {RUN_SPEED, 0.0f, {-1.0f, 7.0f}, 0.0f};
        demand_t demand;
        run_step(&run, &wish, 0.0f, 0.0f, &demand.current, &demand.omega_m_ref);
        const double left = 4.0 * exp(-T * n / 0.1), low = 2.0;
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, fmax(left, low) - 1.0, (double)demand.current.d);
    }
}

/* Beyond ten hand-over speeds a fifth of the low-speed current is left; this does not limit requested
 * currents. */
static void test_requested_currents_are_not_changed(void)
{
    begin_slow(LOW);
    run_enter(&run, (dq_t){4.0f, 1.0f}, 0.0f);
    const run_wish_t wish = {RUN_CURRENT, 9.0f, {-1.5f, 3.0f}, 0.0f};
    demand_t demand;
    run_step(&run, &wish, 8.0f, 2.0f, &demand.current, &demand.omega_m_ref);
    TEST_ASSERT_TRUE(demand.current.d == -1.5f && demand.current.q == 3.0f && demand.omega_m_ref == 2.0f);
}

/* ---- torque ---- */

static dq_t torque_step(float torque, float omega_m)
{
    const run_wish_t wish = {RUN_TORQUE, 0.0f, {0.0f, 0.0f}, torque};
    demand_t demand;
    run_step(&run, &wish, POLE_PAIRS * omega_m, omega_m, &demand.current, &demand.omega_m_ref);
    TEST_ASSERT_EQUAL_FLOAT(omega_m, demand.omega_m_ref);
    return demand.current;
}

/* The factor is 0.5 A/(N m), since 1.5 p psi_f is 2 N m/A. A current beyond the limit is not requested.
 * The fast task does not subtract a part in proportion to the speed. */
static void test_a_torque_is_made_as_a_current_of_the_flux(void)
{
    run_tuning_t tuning = tuning_of(&SPEED);
    tuning.per_torque = 0.5f;
    begin(&tuning);
    TEST_ASSERT_EQUAL_FLOAT(3.0f, torque_step(6.0f, 7.0f).q);
    TEST_ASSERT_EQUAL_FLOAT(-3.0f, torque_step(-6.0f, 7.0f).q);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, torque_step(99.0f, 7.0f).q);
    TEST_ASSERT_TRUE(run.i_q_standing == 10.0f && run.stiffness == 0.0f);
    /* The integral of the speed control has followed. */
    expect(step(RUN_SPEED, 7.0f, 0.0f, 0.0f, 7.0f), 0.0f, 10.0f, 7.0f);
}

/* A salient rotor with D/psi_f of 0.1 1/A: 1.5 p (psi_f - D i_d) i_q must be the requested torque, and i_d
 * the one of most torque per ampere for this i_q. */
static void test_a_torque_of_a_salient_rotor_takes_the_least_current(void)
{
    run_tuning_t tuning = tuning_of(&SPEED);
    tuning.per_torque = 0.5f;
    tuning.saliency = 0.1f;
    tuning.mtpa = 1u;
    begin(&tuning);
    dq_t current = {0.0f, 0.0f};
    for (int n = 0; n < 100; n++) {
        current = torque_step(12.0f, 7.0f);
    }
    const double i_d = (double)current.d, i_q = (double)current.q;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 6.0, (1.0 - 0.1 * i_d) * i_q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, (1.0 - sqrt(1.0 + 0.04 * i_q * i_q)) / 0.2, i_d);
}

/* These two functions give the flux psi_q [Wb] and its slope [H]. The motor has psi_q = 0.08 i_q/sqrt(1 +
 * (i_q/8)^2), L_d 20 mH and psi_f 0.3 Wb. */
static double flux_q(double i_q)
{
    return 0.08 * i_q / hypot(1.0, i_q / 8.0);
}

static double flux_q_slope(double i_q)
{
    return 0.08 / pow(hypot(1.0, i_q / 8.0), 3.0);
}

/* The q axis saturates. The torque psi_d i_q - psi_q i_d must be the requested one, and its derivative
 * with respect to the angle of the current vector, at constant length, must be zero. The interpolation of
 * the table leaves an error of 0.5 %. */
static void test_a_torque_of_a_rotor_that_saturates_takes_the_least_current(void)
{
    const double constant = flux_q(9.6) / 9.6; /* [H] */
    const saturation_params_t law = {.inductance = (float)constant,
                                     .bend = (float)(0.08 / constant - 1.0),
                                     .current = 8.0f,
                                     .current_max = 15.0f};
    const weakening_params_t weak = {.flux_linkage = 0.3f,
                                     .inductance_d = 0.02f,
                                     .inductance_q = (float)constant,
                                     .current_max = 10.0f,
                                     .use = 0.5f,
                                     .period = 0.8e-3f};
    run_tuning_t tuning = tuning_of(&SPEED);
    tuning.per_torque = (float)(1.0 / (1.5 * 4.0 * 0.3));
    tuning.saliency = (float)((constant - 0.02) / 0.3);
    tuning.mtpa = 1u;
    tuning.saturation = saturation_prepare(&law);
    tuning.weakening = weakening_prepare(&weak);
    for (int n = -12; n <= 12; n += 4) {
        begin(&tuning);
        dq_t current = {0.0f, 0.0f};
        for (int k = 0; k < 200; k++) {
            current = torque_step((float)n, 7.0f);
        }
        const double d = (double)current.d, q = (double)current.q;
        const double torque = 1.5 * 4.0 * ((0.3 + 0.02 * d) * q - flux_q(q) * d);
        const double along_the_circle =
            0.3 * d + 0.02 * (d * d - q * q) + flux_q(q) * q - flux_q_slope(q) * d * d;
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs((double)n) + 1e-3, (double)n, torque);
        TEST_ASSERT_DOUBLE_WITHIN(0.05 * 0.3 * hypot(d, q) + 1e-3, 0.0, along_the_circle);
        TEST_ASSERT_TRUE(n == 0 || d < -0.3);
    }
}

/* The limit is 0.25 A per step: from zero in both directions. The return to zero is immediate, and a
 * torque that passes zero grows from there as from zero. */
static void test_a_torque_grows_no_faster_than_its_slew(void)
{
    run_tuning_t tuning = tuning_of(&SPEED);
    tuning.per_torque = 1.0f;
    tuning.slew = 0.25f;
    begin(&tuning);
    for (int n = 1; n <= 8; n++) {
        TEST_ASSERT_EQUAL_FLOAT(0.25f * (float)n, torque_step(9.0f, 7.0f).q);
    }
    TEST_ASSERT_EQUAL_FLOAT(-0.25f, torque_step(-9.0f, 7.0f).q);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, torque_step(0.0f, 7.0f).q);
    TEST_ASSERT_EQUAL_FLOAT(0.25f, step(RUN_SPEED, 99.0f, 0.0f, 0.0f, 7.0f).current.q);
    TEST_ASSERT_EQUAL_FLOAT(0.25f, run.i_q_standing - run.stiffness * 7.0f);
    run_limit(&run, -10.0f, -3.0f); /* the limits by a full DC link act at once */
    TEST_ASSERT_EQUAL_FLOAT(-3.0f, step(RUN_SPEED, 99.0f, 0.0f, 0.0f, 7.0f).current.q);
}

/* With L 10 mH, psi_f 0.1 Wb, 1000 rad/s and 80 V the available flux is 0.08 Wb, less than psi_f: it
 * requires -2 A even without torque. */
static void test_beyond_the_voltage_i_d_is_below_zero(void)
{
    run_tuning_t tuning = tuning_of(&SPEED);
    const weakening_params_t weak = {.flux_linkage = 0.1f,
                                     .inductance_d = 10e-3f,
                                     .inductance_q = 10e-3f,
                                     .current_max = 10.0f,
                                     .use = 0.5f,
                                     .period = 0.8e-3f};
    tuning.weakening = weakening_prepare(&weak);
    tuning.low_current = 1.0f;
    begin(&tuning);
    for (int n = 0; n < 100; n++) {
        run_look(&run, 160.0f, 1000.0f, (dq_t){80.0f, 0.0f});
        TEST_ASSERT_EQUAL_FLOAT(0.0f, step(RUN_SPEED, 250.0f, 0.0f, 0.0f, 250.0f).current.q);
    }
    TEST_ASSERT_FLOAT_WITHIN(5e-3f, -2.0f, run.i_d);
    TEST_ASSERT_TRUE(run_weakens(&run));
    run_look(&run, 160.0f, 100.0f, (dq_t){80.0f, 0.0f});
    (void)step(RUN_SPEED, 25.0f, 0.0f, 0.0f, 25.0f);
    TEST_ASSERT_TRUE(run.i_d == 1.0f && !run_weakens(&run));
}
