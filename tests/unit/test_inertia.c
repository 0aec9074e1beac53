/* The learnt inertia on a shaft that is computed by algebra: domega/dt = K (i_q - i_L), with the motor's
 * current and the part of it that carries the load. */
#include "medium/adapt/inertia.h"
#include "tests/unit/compare.h"

#define PERIOD     1e-4
#define PSI        0.183
#define POLE_PAIRS 4.0
#define J_FROM     0.02 /* [kg m^2] the parameter */
#define LIMIT      10.0 /* [A] */

static inertia_t x;
static double omega, reference; /* [rad/s] electrical */

/* A change of the speed. */
typedef struct {
    double inertia;   /* [kg m^2] true inertia */
    double to;        /* [rad/s] final speed */
    double current;   /* [A] i_q - i_L during the change, towards the reference */
    double load;      /* [A] i_L before the change */
    double viscous;   /* [A s/rad] additional load per speed gained */
    double step;      /* [A] step of the load in the middle of the change */
    double ramp;      /* [rad/s^2] ramp of the reference; 0: a step */
    double short_of;  /* [rad/s] speed error at the begin of the tail, which decays in 50 ms */
    bool unsound_way; /* one period of it is invalid */
    bool unsound_tail;
} way_t;

static way_t usual(double inertia, double to)
{
    return (way_t){.inertia = inertia, .to = to, .current = 5.0, .load = 1.2, .short_of = 4.0};
}

static inertia_tuning_t prepared(double from, double assumed, bool on)
{
    const inertia_params_t params = {(float)from,  (float)assumed, (float)PSI, (float)POLE_PAIRS,
                                     (float)LIMIT, (float)PERIOD,  on};
    return inertia_prepare(&params);
}

static void step(double i_q, bool sound)
{
    const inertia_input_t input = {(float)reference, (float)omega, (float)i_q};
    if (!sound) {
        inertia_spoil(&x);
    }
    inertia_step(&x, &input);
}

static void stand(double i_q, double seconds)
{
    for (int n = 0; n < (int)(seconds / PERIOD + 0.5); n++) {
        step(i_q, true);
    }
}

void setUp(void)
{
    const inertia_tuning_t tuning = prepared(J_FROM, J_FROM, true);
    memset(&x, 0x55, sizeof x);
    inertia_init(&x, &tuning);
    omega = 100.0;
    reference = 100.0;
    stand(0.0, 0.2);
}

/* The current accelerates the shaft until an error of `short_of` is left, which decays exponentially; 0.1
 * s before and 0.3 s after the change are simulated too. */
static void go(const way_t *way)
{
    const double k = 1.5 * POLE_PAIRS * POLE_PAIRS * PSI / way->inertia;
    const double from = omega, sign = way->to > omega ? 1.0 : -1.0;
    const double half = 0.5 * (from + way->to);
    double after = 0.0, load = way->load;
    stand(load, 0.1);
    bool begun = false; /* the current responds a period later */
    while (after < 0.3) {
        const double miss = way->to - omega;
        const bool pushes = sign * miss > way->short_of + 1e-9;
        const double pushed = !begun ? 0.0 : (pushes ? sign * way->current : 20.0 * miss / k);
        begun = true;
        reference = way->ramp == 0.0 || fabs(way->to - reference) < way->ramp * PERIOD
                        ? way->to
                        : reference + sign * way->ramp * PERIOD;
        load = way->load + way->viscous * (omega - from) + (sign * (omega - half) > 0.0 ? way->step : 0.0);
        const bool first = fabs(omega - half) < 5.0;
        step(load + pushed, pushes ? !(way->unsound_way && first) : !way->unsound_tail);
        omega += k * pushed * PERIOD;
        after += pushes ? 0.0 : PERIOD;
    }
    stand(load, 0.1);
}

/* The J that the last change has given, divided by the true value. */
static double said(double inertia)
{
    return (double)x.said[0] / inertia;
}

static double hat(void)
{
    return (double)x.learnt.value;
}

/* Heavier and lighter rotors than the parameter, in both directions, accelerating and decelerating. The
 * sum is made of held samples, so that the limit is one period of the change. */
static void test_a_speed_change_measures_the_inertia(void)
{
    static const double inertias[] = {0.005, 0.0115, 0.02, 0.055, 0.09};
    for (int n = 0; n < 20; n++) {
        const double inertia = inertias[n / 4], sign = n % 2 ? -1.0 : 1.0;
        setUp();
        omega = sign * (n / 2 % 2 ? 600.0 : 100.0);
        reference = omega;
        stand(sign * 1.2, 0.3);
        way_t way = usual(inertia, sign * (n / 2 % 2 ? 100.0 : 600.0));
        way.load = sign * 1.2;
        go(&way);
        TEST_ASSERT_DOUBLE_WITHIN(0.004, 1.0, said(inertia));
    }
}

/* On average half of the load that grows with the speed has acted during the change, and the tail shows
 * all of it. */
static void test_a_load_that_grows_with_the_speed_has_no_part_in_it(void)
{
    for (int n = 0; n < 2; n++) {
        setUp();
        way_t way = usual(0.04, 500.0);
        way.viscous = (n ? -1.0 : 1.0) * 0.12 * way.current / 400.0;
        go(&way);
        TEST_ASSERT_DOUBLE_WITHIN(0.005, 1.0, said(0.04));
    }
}

/* The result of one change is not used; two results that agree are used. */
static void learn_twice(void)
{
    way_t way = usual(0.04, 500.0);
    go(&way);
    TEST_ASSERT_EQUAL_FLOAT((float)J_FROM, x.learnt.value);
    way.to = 100.0;
    go(&way);
    TEST_ASSERT_DOUBLE_WITHIN(0.004 * 0.04, 0.04, hat());
}

static void test_two_ways_that_agree_are_assumed_one_is_not(void)
{
    learn_twice();
    /* This resembles the effect of a load that was applied and removed again. */
    const way_t way = usual(0.09, 500.0);
    go(&way);
    TEST_ASSERT_DOUBLE_WITHIN(0.004, 1.0, said(0.09));
    TEST_ASSERT_DOUBLE_WITHIN(0.004 * 0.04, 0.04, hat());
}

/* The learnt value is the median of the last three results, in every order. */
static void test_what_is_learnt_is_the_median_of_three(void)
{
    static const double orders[][3] = {{1, 2, 3}, {1, 3, 2}, {2, 1, 3}, {2, 3, 1}, {3, 1, 2}, {3, 2, 1}};
    for (int n = 0; n < 6; n++) {
        setUp();
        for (int k = 0; k < 3; k++) {
            const way_t way = usual(0.02 * orders[n][k], k % 2 ? 100.0 : 500.0);
            go(&way);
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.004 * 0.04, 0.04, hat());
    }
}

static void test_it_stays_within_its_range(void)
{
    for (int n = 0; n < 2; n++) {
        setUp();
        for (int k = 0; k < 2; k++) {
            const way_t way = usual(J_FROM * (n ? 1.0 / 6.0 : 6.0), k % 2 ? 100.0 : 500.0);
            go(&way);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * J_FROM, J_FROM * (n ? 1.0 / 5.0 : 5.0), hat());
    }
}

/* ---- changes that give no value ---- */

/* The usual change is from 100 to 500 rad/s with 5 A and 0.04 kg m^2. One condition at a time is wrong.
 * The load steps by 0.18 of the current. The change is short, weak, or longer than the longest accepted
 * one (3.95 s, without the tail). A period of the change or of its tail is invalid. Or the torque acts in
 * one direction and the rotor moves in the other. */
static void test_a_doubtful_speed_change_measures_nothing(void)
{
    const double per_ampere = 1.5 * POLE_PAIRS * POLE_PAIRS * PSI;
    const way_t cases[] = {
        {.inertia = 0.04, .to = 500.0, .current = 5.0, .step = 0.18 * 5.0},
        {.inertia = 0.04, .to = 500.0, .current = 5.0, .step = -0.18 * 5.0},
        {.inertia = 0.04, .to = 155.0, .current = 5.0},
        {.inertia = 0.004, .to = 500.0, .current = 0.019 * LIMIT},
        {.inertia = 0.2, .to = 500.0, .current = 4.05 * 400.0 * 0.2 / per_ampere / 16.0},
        {.inertia = 0.04, .to = 500.0, .current = 5.0, .unsound_way = true},
        {.inertia = 0.04, .to = 500.0, .current = 5.0, .unsound_tail = true},
        {.inertia = -0.04, .to = 500.0, .current = -5.0},
    };
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        way_t way = cases[n];
        way.load = 1.2;
        way.short_of = 4.0;
        setUp();
        const float before = x.said[0];
        go(&way);
        TEST_ASSERT_EQUAL_FLOAT(before, x.said[0]);
        TEST_ASSERT_EQUAL_UINT32(0u, x.under_way);
    }
}

/* The next speed change is judged by itself. */
static void test_after_an_invalid_speed_change_the_next_one_counts(void)
{
    way_t way = usual(0.04, 500.0);
    way.unsound_tail = true;
    go(&way);
    way = usual(0.04, 100.0);
    go(&way);
    TEST_ASSERT_DOUBLE_WITHIN(0.004, 1.0, said(0.04));
}

/* A value is not a number, either the initial speed of the change or a current during it. */
static void test_nothing_is_learnt_from_values_that_are_not_numbers(void)
{
    for (int n = 0; n < 2; n++) {
        setUp();
        stand(1.2, 0.1);
        reference = 500.0;
        omega = n == 0 ? (double)NAN : 100.0;
        step(1.2, true);
        omega = 100.0;
        step(n == 1 ? (double)NAN : 6.0, true);
        stand(6.0, 0.3);
        omega = 500.0;
        stand(1.2, 0.3);
        TEST_ASSERT_EQUAL_UINT32(0u, x.under_way);
        TEST_ASSERT_EQUAL_FLOAT((float)J_FROM, x.said[0]);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, 1.2f, x.load);
    }
}

/* ---- the load current ---- */

/* The load current is held from the period in which the reference moves until the speed has been at the
 * reference for the tail. */
static void test_load_current_is_held_on_the_way(void)
{
    stand(1.2, 0.1);
    reference = 500.0;
    step(1.2, true);
    stand(9.0, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.2, (double)x.load);
    omega = 493.0;
    stand(1.5, (double)INERTIA_TAIL);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.2, (double)x.load);
    omega = 491.0; /* the speed leaves the reference again */
    step(1.5, true);
    omega = 499.0;
    stand(1.5, (double)INERTIA_TAIL);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.2, (double)x.load);
    stand(1.5, 0.02);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 1.5, (double)x.load);
}

static void test_a_reference_that_moves_again_makes_the_way_longer(void)
{
    stand(1.2, 0.1);
    reference = 104.0;
    stand(1.2, 0.1);
    reference = 105.0;
    stand(3.0, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.2, (double)x.load);
    TEST_ASSERT_EQUAL_UINT32(1u, x.under_way);
}

/* After a standstill the load is unknown until the speed has been constant. Until then the whole current
 * counts as load, and a change of the reference is not used as a measurement. */
static void test_after_a_rest_the_load_is_what_the_current_is(void)
{
    stand(1.2, 0.1);
    inertia_rest(&x);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, x.load);
    reference = 300.0;
    step(4.5, true);
    TEST_ASSERT_EQUAL_FLOAT(4.5f, x.load);
    stand(9.0, 0.1);
    TEST_ASSERT_EQUAL_FLOAT(9.0f, x.load);
    reference = 310.0;
    step(8.0, true);
    TEST_ASSERT_EQUAL_FLOAT(8.0f, x.load);
    TEST_ASSERT_EQUAL_UINT32(0u, x.under_way);
    omega = 303.0; /* 7 rad/s away from the reference */
    step(8.0, true);
    reference = 500.0;
    step(8.0, true);
    stand(10.0, 0.1);
    TEST_ASSERT_EQUAL_FLOAT(8.0f, x.load);
    TEST_ASSERT_EQUAL_UINT32(1u, x.under_way);
}

/* After a standstill the load is unknown until the speed has stayed near a constant reference. Without
 * learning the load is never followed, and the loop gets all of i_q. */
static void test_load_is_seen_as_unknown_until_the_speed_has_stayed_at_its_reference(void)
{
    inertia_rest(&x);
    TEST_ASSERT_EQUAL_FLOAT(INERTIA_LOAD_UNKNOWN, inertia_load_seen(&x));
    reference = 300.0;
    stand(2.0, 0.1);
    TEST_ASSERT_EQUAL_FLOAT(INERTIA_LOAD_UNKNOWN, inertia_load_seen(&x));
    omega = 300.0;
    stand(2.0, 0.1);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, inertia_load_seen(&x));
    const inertia_tuning_t off = prepared(J_FROM, J_FROM, false);
    inertia_init(&x, &off);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, inertia_load_seen(&x));
}

static float load_share(float most)
{
    return inertia_load_share(&x, &(inertia_shares_t){.follows = 0.1f, .settles = 0.01f, .most = most});
}

/* A load of 4 A is known at 100 rad/s: i_L follows it while the reference is constant, and is held during
 * a change. If the load exceeds its threshold, all of i_q counts as load from the time at which the rotor
 * is near zero speed until the end of the change. The reference may have passed zero long before; i_L then
 * moves slowly, because a jump would be a load step for a loop at full speed. */
static void test_through_zero_all_is_load_beside_a_load_that_matters(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        setUp();
        omega = sign * 100.0;
        reference = sign * 100.0;
        stand(0.0, 0.3);
        stand(sign * 4.0, 0.1);
        const float load = x.load;
        TEST_ASSERT_EQUAL_FLOAT(0.1f, load_share(1.0f));
        reference = sign * 200.0;
        step(sign * 4.0, true); /* the current responds a period later */
        stand(sign * 10.0, 0.01);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, load_share(1.0f));
        reference = sign * -100.0;
        stand(sign * -10.0, 0.01); /* the reference has passed zero, and the rotor still turns fast */
        TEST_ASSERT_EQUAL_FLOAT(0.01f, load_share(1.0f));
        omega = sign * 0.99 * (double)INERTIA_NEAR_ZERO;
        stand(sign * -10.0, 0.01);
        TEST_ASSERT_EQUAL_FLOAT(1.0f, load_share(1.0f));
        TEST_ASSERT_EQUAL_FLOAT(1.0f, load_share(fabsf(load)));
        TEST_ASSERT_EQUAL_FLOAT(0.0f, load_share(nextafterf(fabsf(load), 10.0f)));
        omega = sign * -50.0;
        stand(sign * -10.0, 0.01);
        TEST_ASSERT_EQUAL_FLOAT(1.0f, load_share(1.0f));
        omega = sign * -100.0;
        stand(sign * -4.0, 2.0 * (double)INERTIA_TAIL + 0.04);
        TEST_ASSERT_EQUAL_FLOAT(0.1f, load_share(1.0f));
    }
}

/* After a change i_L moves slowly to the load, which has changed meanwhile, and then follows i_q. */
static void test_load_settles_slowly_after_a_change_of_the_speed(void)
{
    omega = 100.0;
    reference = 100.0;
    stand(0.0, 0.3);
    reference = 200.0;
    step(0.0, true);
    stand(8.0, 0.05);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, load_share(10.0f));
    omega = 200.0;
    stand(3.0, 0.9 * (double)INERTIA_TAIL);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, load_share(10.0f));
    stand(3.0, 0.2 * (double)INERTIA_TAIL);
    TEST_ASSERT_EQUAL_FLOAT(0.01f, load_share(10.0f));
    stand(3.0, (double)INERTIA_TAIL);
    TEST_ASSERT_EQUAL_FLOAT(0.1f, load_share(10.0f));
}

/* The expected speed follows from the K of the assumed inertia, half of that of the parameter, and from 5
 * A for 0.1 s. */
static void test_speed_that_is_foreseen_is_that_of_the_inertia_that_is_assumed(void)
{
    const inertia_tuning_t tuning = prepared(J_FROM, 0.5 * J_FROM, true);
    inertia_take(&x, &tuning);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, inertia_foreseen(&x));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, inertia_gained(&x, 150.0f));
    stand(1.0, 0.1);
    reference = 500.0;
    step(1.0, true);
    stand(6.0, 0.1);
    const double k = 1.5 * POLE_PAIRS * POLE_PAIRS * PSI / (0.5 * J_FROM);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * 0.5 * k, 0.5 * k, (double)inertia_foreseen(&x));
    TEST_ASSERT_EQUAL_FLOAT(50.0f, inertia_gained(&x, 150.0f));
}

/* ---- coefficients ---- */

static void test_another_parameter_or_off_begins_again(void)
{
    for (int n = 0; n < 2; n++) {
        const double from = n ? J_FROM : 0.03;
        const inertia_tuning_t tuning = prepared(from, from, n == 0);
        setUp();
        learn_twice();
        inertia_take(&x, &tuning);
        TEST_ASSERT_EQUAL_FLOAT((float)from, x.learnt.value);
        TEST_ASSERT_EQUAL_FLOAT((float)from, x.learnt.from);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, x.load);
        TEST_ASSERT_EQUAL_FLOAT((float)from, x.said[0]);
        TEST_ASSERT_EQUAL_FLOAT((float)from, x.said[1]);
    }
}
