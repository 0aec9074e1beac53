/* The limits of the DC link: their lines, and their effect with a capacitor that the rotor charges; the
 * detection of the supply, and the ripple. */
#include "tests/unit/compare.h"
#include "tests/unit/link_bench.h"

void setUp(void)
{
    begin(0.5);
}

static void expect(double u_dc, double omega_m, double braking, double driving)
{
    limit_at(u_dc, omega_m);
    TEST_ASSERT_FLOAT_WITHIN(2e-4f, (float)braking, limit.braking);
    TEST_ASSERT_FLOAT_WITHIN(2e-4f, (float)driving, limit.driving);
    TEST_ASSERT_EQUAL_UINT32(braking < MOST || driving < MOST, limit.limits);
}

/* ---- limits ---- */

/* From 95 % to 98 % of 400 V the limit of braking falls from all to zero; beyond, it requests a driving
 * current of 0.5 %. Up to 115 % of 200 V the link is held, and from 127 % on the driving current is not
 * limited. Below omega_free = 0.15 R I/K_t = 1.325 rad/s the limits of braking open without a step. */
static void test_limits_fade_towards_the_trips_and_open_towards_standstill(void)
{
    const double slow = 0.15 * 0.97 * MOST / TORQUE;
    const double rows[][4] = {
        /* [V], [rad/s], [A], [A] */
        {311.0, OMEGA, 10.0, 10.0},     {379.9, OMEGA, 10.0, 10.0},      {386.0, OMEGA, 5.0, 10.0},
        {392.0, OMEGA, 0.0, 10.0},      {395.0, OMEGA, -0.05, 10.0},     {450.0, OMEGA, -0.05, 10.0},
        {254.1, OMEGA, 10.0, 10.0},     {242.0, OMEGA, 10.0, 5.0},       {230.0, OMEGA, 10.0, 0.0},
        {224.0, OMEGA, 10.0, -2.5},     {0.0, OMEGA, 10.0, -10.0},       {386.0, 0.0, 10.0, 10.0},
        {386.0, 0.5 * slow, 7.5, 10.0}, {386.0, slow, 5.0, 10.0},        {400.0, 0.5 * slow, 4.975, 10.0},
        {224.0, 0.0, 10.0, 0.0},        {224.0, 0.5 * slow, 10.0, -1.25}};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        expect(rows[n][0], rows[n][1], rows[n][2], rows[n][3]);
        expect(rows[n][0], -rows[n][1], rows[n][2], rows[n][3]);
    }
}

static void test_without_ride_through_driving_is_never_limited(void)
{
    begin(0.0);
    TEST_ASSERT_FALSE(is_near(0.0));
    expect(0.0, OMEGA, 10.0, 10.0);
    for (int n = 0; n < 100; n++) {
        look(0.0);
        TEST_ASSERT_FALSE(excuses());
        TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions & LINK_SINKS);
    }
}

static void test_limits_are_requested_as_long_as_they_act(void)
{
    TEST_ASSERT_FALSE(is_near(311.0));
    TEST_ASSERT_TRUE(is_near(380.5));
    TEST_ASSERT_TRUE(is_near(253.5));
    limit_at(386.0, OMEGA);
    TEST_ASSERT_TRUE(is_near(311.0));
    limit_at(311.0, OMEGA);
    TEST_ASSERT_FALSE(is_near(311.0));
}

/* ---- supply ---- */

static void looks(double u_dc, double seconds)
{
    for (int n = 0; n < (int)(seconds / LOOK + 0.5); n++) {
        look(u_dc);
    }
}

/* The time is 0.5 s from the first evaluation below 230 V on. A link below the hold, which has decreased
 * to 210 V, does not count as supplied. */
static void test_a_lost_supply_is_excused_for_its_time(void)
{
    looks(311.0, 1.0);
    TEST_ASSERT_TRUE(excuses());
    looks(240.0, 1.0);
    TEST_ASSERT_TRUE(excuses());
    looks(311.0, LOOK);
    looks(205.0, 0.499);
    TEST_ASSERT_TRUE(excuses());
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions & (LINK_LOST | LINK_SINKS));
    looks(205.0, 0.003);
    TEST_ASSERT_FALSE(excuses());
    TEST_ASSERT_EQUAL_UINT32(LINK_LOST, watch.conditions & (LINK_LOST | LINK_SINKS));
    looks(255.0, LOOK);
    TEST_ASSERT_TRUE(excuses());
}

/* One disturbed conversion does not count as a falling link. */
static void test_a_link_that_sinks_is_seen_twice(void)
{
    looks(311.0, 0.1);
    looks(0.0, LOOK);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions & LINK_SINKS);
    looks(311.0, LOOK);
    looks(199.0, LOOK);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions & LINK_SINKS);
    looks(199.0, LOOK);
    TEST_ASSERT_EQUAL_UINT32(LINK_SINKS, watch.conditions & LINK_SINKS);
    looks(201.0, LOOK);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions & LINK_SINKS);
}

/* ---- ripple ---- */

static void rectified(double hertz, double depth, double seconds)
{
    for (int n = 0; n < (int)(seconds / LOOK + 0.5); n++) {
        look(311.0 * (1.0 - depth * (1.0 - fabs(sin(PI * hertz * n * LOOK)))));
    }
}

static void test_a_lost_phase_shows_within_a_tenth_of_a_second(void)
{
    rectified(100.0, 0.15, 0.09);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions);
    rectified(100.0, 0.15, 0.04);
    TEST_ASSERT_EQUAL_UINT32(LINK_RIPPLES, watch.conditions);
    /* The evaluations miss the cusps of the ripple by at most half of their distance in time, in which the
     * ripple changes by a quarter of its depth. */
    TEST_ASSERT_TRUE(watch.ripple <= 0.1501f * 311.0f && watch.ripple >= 0.75f * 0.15f * 311.0f);
    looks(311.0, 0.045);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions);
}

static void test_three_phases_a_sag_and_a_braking_are_no_ripple(void)
{
    rectified(300.0, 0.08, 0.5);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions);
    for (int n = 0; n < 100; n++) {
        look(311.0 + 0.8 * n);
        TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions);
    }
    looks(390.0, 0.2);
    looks(311.0, 0.2);
    looks(260.0, 0.05);
    looks(311.0, 0.2);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions);
}

static void test_new_coefficients_keep_what_is_lost_and_limit_again(void)
{
    looks(205.0, 0.3);
    limit_at(205.0, OMEGA);
    TEST_ASSERT_TRUE(limit.driving < 4.0f);
    prepare(0.2, 4.0);
    link_limit_take(&limit, &limit_tuning);
    TEST_ASSERT_TRUE(is_near(300.0)); /* the limit acts until the next step */
    limit_at(300.0, OMEGA);
    TEST_ASSERT_TRUE(limit.driving == 4.0f && limit.braking == 4.0f);
    prepare(0.2, 3.0);
    link_limit_take(&limit, &limit_tuning); /* no limit acts: no step is necessary */
    TEST_ASSERT_FALSE(is_near(300.0));
    TEST_ASSERT_TRUE(limit.driving == 3.0f && limit.braking == 3.0f);
    TEST_ASSERT_FALSE(excuses());
}
