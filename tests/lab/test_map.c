/* The error map against theory: what a wrong inductance must give, what must not matter, what a lost point
 * looks like; and the judgement, on points made by hand. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/map.h"
#include "unity.h"

#define POINTS_MAX 300u

static map_setup_t setup;
static map_point_t points[POINTS_MAX];
static map_error_t why;

void setUp(void)
{
    setup = map_setup_default();
    setup.settle = 1.5;
    setup.window = 1.0;
    memset(points, 0, sizeof points);
    memset(&why, 0, sizeof why);
}

void tearDown(void)
{
}

static void only(double rpm, double load)
{
    setup.speeds[0] = rpm;
    setup.speed_count = 1;
    setup.loads[0] = load;
    setup.load_count = 1;
}

static size_t run(unsigned threads)
{
    const size_t count = map_count(&setup);
    TEST_ASSERT_TRUE(count <= POINTS_MAX);
    TEST_ASSERT_TRUE_MESSAGE(map_run(&setup, points, threads, &why), why.text);
    return count;
}

static const map_point_t *point(size_t count, map_deviation_t deviation, double rpm, double load)
{
    for (size_t n = 0; n < count; n++) {
        if (points[n].deviation == deviation && points[n].rpm == rpm && points[n].load == load) {
            return &points[n];
        }
    }
    TEST_FAIL_MESSAGE("no such point");
    return NULL;
}

static void expect_within(double limit, double expected, double value, const char *what)
{
    char text[120];
    snprintf(text, sizeof text, "%s: %.4f, expected %.4f within %g", what, value, expected, limit);
    TEST_ASSERT_TRUE_MESSAGE(fabs(value - expected) <= limit, text);
}

/* ---- which points ---- */

static void test_default_covers_every_deviation_load_speed_and_direction_once(void)
{
    const size_t count = map_count(&setup);
    TEST_ASSERT_EQUAL_UINT(MAP_DEVIATIONS * 2u * 5u * 2u, count);
    setup.settle = 0.0;
    setup.window = 1e-4;
    run(2);
    for (size_t n = 0; n < count; n++) {
        const map_point_t *p = &points[n];
        TEST_ASSERT_EQUAL_PTR(p, point(count, p->deviation, p->rpm, p->load));
        TEST_ASSERT_EQUAL_INT(n / 20u, p->deviation);
        TEST_ASSERT_EQUAL_DOUBLE(n / 10u % 2u == 0u ? 0.0 : 5.0, p->load);
        TEST_ASSERT_TRUE(n % 10u == 0u || p->rpm > p[-1].rpm);
    }
    TEST_ASSERT_EQUAL_DOUBLE(-1490.0, points[0].rpm);
    TEST_ASSERT_EQUAL_DOUBLE(-101.0, points[4].rpm);
    TEST_ASSERT_EQUAL_DOUBLE(101.0, points[5].rpm);
}

static void test_ideal_map_has_the_machine_only(void)
{
    only(500.0, 0.0);
    TEST_ASSERT_EQUAL_UINT(MAP_DEVIATIONS * 2u, map_count(&setup));
    setup.ideal = true;
    TEST_ASSERT_EQUAL_UINT(7u * 2u, map_count(&setup));
}

static void test_every_deviation_has_its_own_name(void)
{
    TEST_ASSERT_EQUAL_STRING("nominal", map_deviation_name(MAP_NOMINAL));
    TEST_ASSERT_EQUAL_STRING("L +20 %", map_deviation_name(MAP_INDUCTANCE_HIGH));
    TEST_ASSERT_EQUAL_STRING("dead time -0.5 us", map_deviation_name(MAP_DEAD_TIME_LOW));
    for (map_deviation_t a = 0; a < MAP_DEVIATIONS; a++) {
        for (map_deviation_t b = 0; b < a; b++) {
            TEST_ASSERT_TRUE(strcmp(map_deviation_name(a), map_deviation_name(b)) != 0);
        }
    }
}

static void test_window_is_whole_electrical_periods(void)
{
    setup.window = 1.0;
    TEST_ASSERT_EQUAL_UINT32(10500u, map_window(&setup, 100.0)); /* 7 of 150 ms */
    TEST_ASSERT_EQUAL_UINT32(10500u, map_window(&setup, -100.0));
    TEST_ASSERT_EQUAL_UINT32(10069u, map_window(&setup, 1013.0)); /* 68 of 14.8075 ms: 1.006910 s */
    setup.window = 0.25;
    TEST_ASSERT_EQUAL_UINT32(2500u, map_window(&setup, 300.0)); /* 5 of 50 ms, none added */
    TEST_ASSERT_EQUAL_UINT32(15000u, map_window(&setup, 10.0)); /* never less than one */
}

/* ---- what is measured ---- */

/* Torque balance: (load + 1.32 N m)/(1.5 p psi_f), p = 4, psi_f = 0.183 Wb, against the direction of rotation
 * (friction and load are passive). Means of a second: the speed control has settled within 1e-3 of it. */
static double i_q_of(double rpm, double load)
{
    return (rpm < 0.0 ? -1.0 : 1.0) * (load + 1.32) / (1.5 * 4.0 * 0.183);
}

/* Exact in the steady state: with i_d = 0 in the estimated frame, sin(error) = -dL i/psi_f, i the length of
 * the current, whose part across the true EMF is i cos(error) = i_q: tan(error) = -dL i_q/(psi_f
 * cos^2(error)). The estimator's own error besides is within 0.3 mrad, 0.5 at its peak: a ripple, whose peak
 * is not ten times its deviation. */
static void test_wrong_inductance_turns_the_angle_as_theory_says(void)
{
    setup.ideal = true;
    setup.averaged = true; /* the ripple moves the sampled i_q against the mean torque */
    setup.speed_count = 3;
    setup.speeds[0] = 100.0;
    setup.speeds[1] = 300.0;
    setup.speeds[2] = 1490.0;
    const size_t count = run(2);
    for (size_t n = 0; n < count; n++) {
        const map_point_t *p = &points[n];
        TEST_ASSERT_TRUE(p->locked);
        expect_within(0.01, i_q_of(p->rpm, p->load), p->i_q, "i_q");
        expect_within(0.1, p->rpm, p->true_rpm, "speed");
        const double d_l = p->deviation == MAP_INDUCTANCE_LOW    ? -0.0025
                           : p->deviation == MAP_INDUCTANCE_HIGH ? 0.0025
                                                                 : 0.0; /* 20 % of 12.5 mH */
        const double ratio = -d_l * i_q_of(p->rpm, p->load) / 0.183;
        double angle = atan(ratio);
        if (d_l != 0.0) {
            expect_within(0.2, 1e3 * angle, p->theory_mrad, "theory");
        } else {
            TEST_ASSERT_TRUE(isnan(p->theory_mrad));
        }
        for (int k = 0; k < 20; k++) {
            angle = atan(ratio / (cos(angle) * cos(angle)));
        }
        expect_within(0.3, 1e3 * angle, p->mean_mrad, map_deviation_name(p->deviation));
        const double swing = p->peak_mrad - fabs(p->mean_mrad);
        TEST_ASSERT_TRUE(swing > 0.0 && swing < 10.0 * p->sd_mrad && p->sd_mrad < p->peak_mrad);
        TEST_ASSERT_TRUE(p->deviation != MAP_NOMINAL || p->peak_mrad <= 0.5);
    }
    for (map_claim_t claim = 0; claim < MAP_CLAIMS; claim++) {
        const map_verdict_t verdict = map_judge(points, count, claim);
        TEST_ASSERT_TRUE(verdict.met);
        TEST_ASSERT_EQUAL_UINT(claim == MAP_CLAIM_INDUCTANCE ? 24u : 48u, verdict.judged);
    }
}

/* Each deviation must be seen in what it disturbs: twice the noise makes more of it, a dead time off by a
 * fifth a ripple that the right one does not have. The other direction is the mirror image but for offset and
 * gain error of one sensor. */
static void test_noise_and_dead_time_act(void)
{
    static const map_deviation_t disturbed[] = {MAP_NOISE, MAP_DEAD_TIME_LOW, MAP_DEAD_TIME_HIGH};
    only(307.0, 5.0);
    const size_t count = run(2);
    for (int direction = -1; direction <= 1; direction += 2) {
        const double rpm = 307.0 * direction;
        const map_point_t *nominal = point(count, MAP_NOMINAL, rpm, 5.0);
        TEST_ASSERT_TRUE(nominal->locked && nominal->sd_mrad > 0.05);
        for (size_t n = 0; n < sizeof disturbed / sizeof disturbed[0]; n++) {
            const map_point_t *p = point(count, disturbed[n], rpm, 5.0);
            TEST_ASSERT_TRUE_MESSAGE(p->sd_mrad > 1.2 * nominal->sd_mrad, map_deviation_name(disturbed[n]));
            expect_within(1.0, -point(count, disturbed[n], -rpm, 5.0)->mean_mrad, p->mean_mrad, "mirror");
        }
        /* Too small is not too large. */
        TEST_ASSERT_TRUE(fabs(point(count, MAP_DEAD_TIME_LOW, rpm, 5.0)->sd_mrad -
                              point(count, MAP_DEAD_TIME_HIGH, rpm, 5.0)->sd_mrad) > 0.1);
    }
}

/* Also those that leave the mean alone change the noise's way through the drive: no two rows have equal bits.
 */
static void test_every_deviation_reaches_the_drive(void)
{
    only(307.0, 0.0);
    setup.settle = 0.0;
    setup.window = 0.1;
    const size_t count = run(2);
    for (size_t a = 0; a < count; a++) {
        for (size_t b = 0; b < a; b++) {
            TEST_ASSERT_TRUE_MESSAGE(points[a].mean_mrad != points[b].mean_mrad,
                                     map_deviation_name(points[a].deviation));
        }
    }
}

/* An offset of 50 instead of 30 mA makes a larger ripple until the drive has trimmed it away. */
static void test_offset_is_seen_at_the_start(void)
{
    only(1013.0, 0.0);
    setup.settle = 0.0;
    setup.window = 0.1;
    const size_t count = run(2);
    for (int direction = -1; direction <= 1; direction += 2) {
        const double rpm = 1013.0 * direction;
        TEST_ASSERT_TRUE(point(count, MAP_OFFSET, rpm, 0.0)->sd_mrad >
                         1.2 * point(count, MAP_NOMINAL, rpm, 0.0)->sd_mrad);
    }
}

/* 10 N m and the friction ask for 10.3 A, the limit is 10 A: the rotor slows down and is lost. 0.34 N m short
 * of 0.0636 kg m^2: 51 r/min a second, some 100 r/min by the middle of the window. */
static void test_overloaded_point_is_not_locked_and_has_numbers(void)
{
    only(300.0, 10.0);
    const size_t count = run(2);
    for (size_t n = 0; n < count; n++) {
        const map_point_t *p = &points[n];
        TEST_ASSERT_FALSE(p->locked);
        TEST_ASSERT_TRUE(isnan(p->theory_mrad));
        TEST_ASSERT_TRUE(isfinite(p->mean_mrad) && isfinite(p->sd_mrad) && isfinite(p->peak_mrad));
        TEST_ASSERT_TRUE(fabs(p->true_rpm) < 285.0 || p->fault != 0);
    }
    for (map_claim_t claim = 0; claim < MAP_CLAIMS; claim++) {
        TEST_ASSERT_FALSE(map_judge(points, count, claim).met);
    }
}

static void test_threads_do_not_change_a_bit(void)
{
    static map_point_t alone[POINTS_MAX];
    only(700.0, 2.0);
    setup.settle = 0.2;
    setup.window = 0.1;
    const size_t count = run(1);
    memcpy(alone, points, sizeof alone);
    memset(points, 0, sizeof points);
    run(5);
    for (size_t n = 0; n < count; n++) {
        TEST_ASSERT_EQUAL_MEMORY(&alone[n].mean_mrad, &points[n].mean_mrad, 6u * sizeof(double));
        TEST_ASSERT_EQUAL_INT(alone[n].locked, points[n].locked);
    }
    setup.seed = 2; /* other noise, other numbers */
    run(2);
    TEST_ASSERT_TRUE(points[0].mean_mrad != alone[0].mean_mrad);
}

static void test_refused_setting_is_told_with_its_point(void)
{
    only(2500.0, 0.0); /* beyond 95 % of the overspeed trip at 2100 r/min */
    TEST_ASSERT_FALSE(map_run(&setup, points, 2, &why));
    TEST_ASSERT_TRUE_MESSAGE(
        strstr(why.text, "speed_request") != NULL && strstr(why.text, "2500 r/min") != NULL, why.text);
}

/* ---- judgement, on points made by hand ---- */

static size_t made(double nominal, double resistance, double inductance, double theory)
{
    const map_point_t one[] = {
        {.rpm = 100.0, .deviation = MAP_NOMINAL, .mean_mrad = nominal, .locked = true},
        {.rpm = -100.0, .deviation = MAP_NOMINAL, .mean_mrad = 50.0, .locked = true}, /* not this one */
        {.rpm = 100.0, .deviation = MAP_RESISTANCE_LOW, .mean_mrad = resistance, .locked = true},
        {.rpm = 100.0,
         .deviation = MAP_INDUCTANCE_HIGH,
         .mean_mrad = inductance,
         .theory_mrad = theory,
         .locked = true},
        {.rpm = 100.0,
         .deviation = MAP_NOISE,
         .mean_mrad = 70.0,
         .locked = true}, /* nothing is claimed of it */
    };
    memcpy(points, one, sizeof one);
    return sizeof one / sizeof one[0];
}

static void expect_verdict(bool met, size_t count, map_claim_t claim, double worst, size_t judged,
                           size_t lost)
{
    const map_verdict_t verdict = map_judge(points, count, claim);
    TEST_ASSERT_EQUAL_INT(met, verdict.met);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, worst, verdict.worst_mrad);
    TEST_ASSERT_EQUAL_UINT(judged, verdict.judged);
    TEST_ASSERT_EQUAL_UINT(lost, verdict.lost);
    TEST_ASSERT_TRUE((verdict.worst == NULL) == (judged == 0u));
}

static void test_no_effect_is_judged_against_the_nominal_point(void)
{
    expect_verdict(true, made(1.0, 1.25, 0.0, 0.0), MAP_CLAIM_NO_EFFECT, 0.25, 1, 0);
    expect_verdict(true, made(0.0, -0.3, 0.0, 0.0), MAP_CLAIM_NO_EFFECT, 0.3, 1, 0); /* at the limit */
    expect_verdict(false, made(1.0, 0.6875, 0.0, 0.0), MAP_CLAIM_NO_EFFECT, 0.3125, 1, 0);
    size_t count = made(0.0, 0.0, 0.0, 0.0);
    points[2].locked = false;
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 0, 1);
    count = made(0.0, 0.0, 0.0, 0.0);
    points[0].locked = false;
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 0, 1);
    count = made(0.0, 0.0, 0.0, 0.0);
    points[0].load = 5.0; /* another load's nominal is none */
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 0, 1);
    count = made(0.0, 0.0, 0.0, 0.0);
    points[4] = points[2]; /* one good and one lost */
    points[4].locked = false;
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 1, 1);
}

static void test_inductance_is_judged_against_nominal_and_theory(void)
{
    expect_verdict(true, made(0.0, 0.0, -15.0, -16.0), MAP_CLAIM_INDUCTANCE, 1.0, 1, 0);
    expect_verdict(true, made(3.0, 0.0, -15.0, -16.0), MAP_CLAIM_INDUCTANCE, 2.0, 1, 0); /* at the limit */
    expect_verdict(false, made(0.0, 0.0, -18.25, -16.0), MAP_CLAIM_INDUCTANCE, 2.25, 1, 0);
    expect_verdict(false, made(2.25, 0.0, -16.0, -16.0), MAP_CLAIM_INDUCTANCE, 2.25, 1, 0);
    expect_verdict(false, made(0.0, 0.0, 16.0, -16.0), MAP_CLAIM_INDUCTANCE, 32.0, 1, 0);
    size_t count = made(0.0, 0.0, -16.0, -16.0);
    points[3].locked = false;
    expect_verdict(false, count, MAP_CLAIM_INDUCTANCE, 0.0, 0, 1);
    count = made(0.0, 0.0, -16.0, -16.0);
    points[0].locked = false;
    expect_verdict(false, count, MAP_CLAIM_INDUCTANCE, 0.0, 0, 1);
}

static void test_worst_point_is_named(void)
{
    const size_t count = made(0.0, 0.1, 0.0, 0.0);
    points[4] = points[2];
    points[4].deviation = MAP_FLUX_HIGH;
    points[4].mean_mrad = -0.2;
    TEST_ASSERT_EQUAL_PTR(&points[4], map_judge(points, count, MAP_CLAIM_NO_EFFECT).worst);
    points[4].mean_mrad = -0.05;
    TEST_ASSERT_EQUAL_PTR(&points[2], map_judge(points, count, MAP_CLAIM_NO_EFFECT).worst);
}

static void test_map_without_the_rows_of_a_claim_does_not_meet_it(void)
{
    const size_t count = made(0.0, 0.0, 0.0, 0.0);
    points[2].deviation = MAP_NOISE;
    points[3].deviation = MAP_OFFSET;
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 0, 0);
    expect_verdict(false, count, MAP_CLAIM_INDUCTANCE, 0.0, 0, 0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_default_covers_every_deviation_load_speed_and_direction_once);
    RUN_TEST(test_ideal_map_has_the_machine_only);
    RUN_TEST(test_every_deviation_has_its_own_name);
    RUN_TEST(test_window_is_whole_electrical_periods);
    RUN_TEST(test_wrong_inductance_turns_the_angle_as_theory_says);
    RUN_TEST(test_noise_and_dead_time_act);
    RUN_TEST(test_every_deviation_reaches_the_drive);
    RUN_TEST(test_offset_is_seen_at_the_start);
    RUN_TEST(test_overloaded_point_is_not_locked_and_has_numbers);
    RUN_TEST(test_threads_do_not_change_a_bit);
    RUN_TEST(test_refused_setting_is_told_with_its_point);
    RUN_TEST(test_no_effect_is_judged_against_the_nominal_point);
    RUN_TEST(test_inductance_is_judged_against_nominal_and_theory);
    RUN_TEST(test_worst_point_is_named);
    RUN_TEST(test_map_without_the_rows_of_a_claim_does_not_meet_it);
    return UNITY_END();
}
