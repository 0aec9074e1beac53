/* The dead time that is learnt from the EMF of a turning rotor. The expected values follow from algebra
 * alone. */
#include "tests/unit/dead_time_bench.h"

void setUp(void)
{
    world_begin();
}

/* The remaining error [-] after this number of seconds of learning, by the law of the rate in small steps. */
static double left_after(double seconds, double share)
{
    double rate = RATE;
    double left = 1.0;
    for (int32_t n = 0; n < (int32_t)(seconds / PERIOD + 0.5); n++) {
        left -= share * PERIOD * rate * left;
        rate += share * PERIOD * (0.01 * RATE * RATE - rate * rate) / 6.0;
    }
    return left;
}

/* The twelfth harmonic of the error rotates with the rotor, and its mean follows with a time constant of
 * 1/omega. Learning is therefore slower than the rate by a share of 1/(1 + 144), with a ripple of half a
 * turn. The rate begins when the learnt value is used. */
static void test_error_falls_with_the_rate(void)
{
    static const double speeds[] = {42.0, 70.0, 90.0};
    static const double ahead[] = {0.5, 0.0, 0.8};
    for (int32_t n = 0; n < 18; n++) {
        setUp();
        world.omega = (n % 2 != 0 ? -1.0 : 1.0) * speeds[n / 2 % 3];
        world.ahead = ahead[n / 6] * PI;
        turn(0.15);
        const double before = unlearnt();
        const double whole = 4.0 * PI / fabs(world.omega);
        turn(whole);
        const double expected = 144.0 / 145.0 * log(left_after(0.15, 1.0) / left_after(0.15 + whole, 1.0));
        char message[120];
        snprintf(message, sizeof message, "%.0f rad/s, current %.1f pi ahead", world.omega, ahead[n / 6]);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.05 * expected, expected, -log(unlearnt() / before), message);
        turn(10.0);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-3, 0.0, off(), message);
    }
}

/* The EMF has fifth and seventh harmonics of either sign, driving and braking, with the current in line with
 * the EMF or across it: each pair of harmonics, speed and direction of the current. They have no twelfth
 * harmonic, so that nothing is learnt from them. */
static void test_harmonics_of_the_emf_are_no_dead_time(void)
{
    static const double harmonics[][2] = {{0.03, 0.02}, {-0.03, -0.02}, {-0.03, 0.02}, {0.01, 0.005}};
    static const double speeds[] = {34.0, -42.0, 70.0, 125.0};
    static const double ahead[] = {0.5, -0.5, 0.0, 0.8};
    for (int32_t n = 0; n < 16; n++) {
        const int32_t both = (n / 4 + n) % 4;
        setUp();
        world.omega = speeds[n % 4];
        world.ahead = ahead[n / 4] * PI;
        world.fifth = harmonics[both][0];
        world.seventh = harmonics[both][1];
        know();
        turn(20.0);
        char message[120];
        snprintf(message, sizeof message, "%g and %g at %.0f rad/s, %.1f pi ahead: off %.4f", world.fifth,
                 world.seventh, world.omega, world.ahead / PI, unlearnt());
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-3, 0.0, unlearnt(), message);
    }
}

/* The direction of the current moves slowly between the zero crossings and fast through them, as with too
 * much compensation, or the other way round. */
static void test_an_uneven_current_teaches_the_same(void)
{
    static const double dwells[] = {0.12, -0.12};
    for (int32_t n = 0; n < 4; n++) {
        setUp();
        world.dwells = dwells[n % 2];
        world.learn.learnt = (float)((n < 2 ? 1.4 : 0.6) * TRUE);
        world.learn.effective = world.learn.learnt;
        turn(15.0);
        TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, unlearnt());
    }
}

/* The length of the current changes by 2 % six times per turn, and its mean is 1 % above or below the least
 * current, seven times the zone. In every second twelfth of a turn it is on the other side. The EMF has a
 * fifth harmonic, whose product with the twelfth of the signs has a mean in these parts of a turn alone.
 * Above the limit the whole turn counts, below it nothing. */
static void test_a_current_whose_length_passes_the_limit_counts_with_its_mean(void)
{
    static const double sides[] = {1.01, 0.99};
    for (int32_t n = 0; n < 4; n++) {
        setUp();
        dead_time_learn_params_t params = PARAMS;
        params.effective = (float)TRUE;
        params.zone = (float)(world.current / 7.0 / sides[n % 2]);
        take(&params);
        world.fifth = 0.03;
        world.longer = n < 2 ? 0.02 : -0.02;
        turn(10.0);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, unlearnt());
        TEST_ASSERT_EQUAL(n % 2 == 0, world.learn.rate < 0.2f * (float)RATE);
    }
}

/* A learnt value that differs from the parameters by d has the weight (d/c)^4 below the threshold c, and 1
 * above. At the initial rate c is 0.08 of the dead band, and at a tenth of this rate 0.008. */
static void test_only_what_is_more_than_chance_is_used(void)
{
    world.learn.tuning.effective = (float)(TRUE - 0.012 * BAND);
    world.learn.effective = world.learn.tuning.effective;
    world.learn.learnt = world.learn.effective;
    turn(0.5);
    TEST_ASSERT_TRUE((double)world.learn.learnt > TRUE - 0.006 * BAND);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * BAND, TRUE - 0.012 * BAND, (double)world.learn.effective);
    TEST_ASSERT_FALSE(dead_time_learn_is_settled(&world.learn));
    turn(30.0);
    TEST_ASSERT_TRUE(dead_time_learn_is_settled(&world.learn));
    TEST_ASSERT_EQUAL_FLOAT(world.learn.learnt, world.learn.effective);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, off());
}

/* With this noise of the sensors the threshold c is known: its square is the part of chance, which the rate
 * determines, plus 16 P. */
static void test_below_the_threshold_the_weight_falls_with_the_fourth_power(void)
{
    static const double apart[] = {-0.2, 0.5, 0.8, -0.8};
    for (size_t n = 0; n < sizeof apart / sizeof apart[0]; n++) {
        setUp();
        dead_time_learn_params_t params = PARAMS;
        params.effective = (float)TRUE;
        take(&params);
        const double wrong = apart[n] * 0.08 * BAND;
        world.learn.learnt = (float)(TRUE + wrong);
        world.learn.smooth = world.learn.learnt;
        world.learn.ripple = 0.0f;
        turn(0.0008);
        const double chance = 0.08 * BAND * (double)world.learn.rate / RATE;
        const double threshold = sqrt(chance * chance + 16.0 * (double)world.learn.variance);
        const double left = (double)world.learn.smooth - TRUE;
        TEST_ASSERT_DOUBLE_WITHIN(0.1 * fabs(wrong), wrong, left);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * fabs(wrong), left * pow(left / threshold, 4.0),
                                  (double)world.learn.effective - TRUE);
    }
}

/* The EMF changes the current by the share s of the largest permitted ripple, s = 4 e T/(L |i|). A wrong L
 * then changes the learnt value by up to 0.075 s^2 of the dead band. The drive uses the value within this
 * distance from the learnt one that is nearest to the parameters. */
static void test_with_ripple_the_used_value_is_the_nearest_to_the_parameters(void)
{
    static const double ripples[] = {0.4, 0.8, -0.8};
    for (size_t n = 0; n < sizeof ripples / sizeof ripples[0]; n++) {
        setUp();
        dead_time_learn_params_t params = PARAMS;
        world.omega = ripples[n] < 0.0 ? -42.0 : 42.0;
        params.inductance = (float)(4.0 * PERIOD * PSI * 42.0 / (world.current * fabs(ripples[n])));
        params.effective = (float)((n == 1u ? 1.4 : 0.6) * TRUE);
        take(&params);
        turn(15.0);
        const double doubt = 0.075 * ripples[n] * ripples[n] * BAND / TRUE;
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, unlearnt());
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, unlearnt() + (n == 1u ? doubt : -doubt), off());
    }
}

/* Before the first step the ripple counts as the largest. Its mean falls like the initial error of the
 * learnt value, so that a short time of learning changes the value in use less than the low-pass of the
 * learnt one. */
static void test_a_short_time_of_learning_is_used_in_part(void)
{
    turn(0.15);
    const double left = left_after(0.15, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, -0.4 * left, unlearnt());
    const double smooth = (double)world.learn.smooth / TRUE - 1.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, smooth - 0.075 * left * BAND / TRUE, off());
}

/* At 600 rad/s the twelfth harmonic rotates by 2.9 rad from step to step, almost half a turn; at 380 rad/s
 * by 1.8 rad. psi_f is small so that both EMFs are small enough to be evaluated. */
static void test_a_speed_too_high_for_the_steps_teaches_nothing(void)
{
    dead_time_learn_params_t params = PARAMS;
    params.flux_linkage = 0.03f;
    for (int32_t n = 0; n < 4; n++) {
        setUp();
        take(&params);
        const bool quick = n < 2;
        world.omega = (n % 2 != 0 ? -1.0 : 1.0) * (quick ? 600.0 : 380.0);
        const double before = unlearnt();
        turn(3.0);
        if (quick) {
            TEST_ASSERT_EQUAL_DOUBLE(before, unlearnt());
        } else {
            TEST_ASSERT_TRUE(fabs(unlearnt()) < 0.1 * fabs(before));
        }
    }
}

/* Noise of the sensors smooths the edges of the assumed signs, but not those of the true ones. V is learnt
 * too large by the missing share of the twelfth harmonic: the mean of 1 - exp(-45 s_j^2/i^2), with twice
 * the s^2 in the third phase. If this mean exceeds 3 % and the noise is known, nothing is learnt. */
static void test_noise_is_not_learnt_as_dead_time(void)
{
    static const struct {
        double times; /* [-] current divided by noise */
        bool known, learns;
    } cases[] = {{30.0, false, true}, {44.0, true, false}, {46.0, true, true}, {17.0, true, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        const double square = 45.0 / (cases[n].times * cases[n].times);
        const double left = (2.0 * exp(-square) + exp(-2.0 * square)) / 3.0;
        world.noise = world.current / cases[n].times;
        world.known = cases[n].known ? world.noise : 0.0;
        turn(15.0);
        const double expected = cases[n].learns ? 1.0 / left - 1.0 : -0.4;
        char message[80];
        snprintf(message, sizeof message, "%.0f times the noise", cases[n].times);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-3, expected, off(), message);
    }
}

/* If the EMF is below 0.85 of the voltage of the dead band, the rate decreases with the square of the EMF. */
static void test_slower_where_the_emf_is_small(void)
{
    world.omega = 0.55 * BAND * LINK / PSI;
    turn(0.4);
    const double before = unlearnt();
    const double whole = 4.0 * PI / world.omega;
    turn(whole);
    const double share = 0.55 / 0.85;
    const double slower = share * share;
    const double expected = 144.0 / 145.0 * log(left_after(0.4, slower) / left_after(0.4 + whole, slower));
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * expected, expected, -log(unlearnt() / before));
}

/* One value is wrong in each period: the EMF or current of the drive is multiplied by a factor, or its
 * speed, reference or link voltage is different. */
static void test_an_invalid_measurement_changes_nothing(void)
{
    static const struct {
        const char *what;
        float emf, current, omega_e, omega_e_ref, link;
    } cases[] = {
        {"current is no number", 1.0f, NAN, 42.0f, 42.0f, (float)LINK},
        {"EMF is no number", NAN, 1.0f, 42.0f, 42.0f, (float)LINK},
        {"link is no number", 1.0f, 1.0f, 42.0f, 42.0f, NAN},
        {"speed is no number", 1.0f, 1.0f, NAN, 42.0f, (float)LINK},
        {"no EMF", 0.0f, 1.0f, 42.0f, 42.0f, (float)LINK},
        {"endless EMF", INFINITY, 1.0f, 42.0f, 42.0f, (float)LINK},
        {"small current", 1.0f, 0.1f, 42.0f, 42.0f, (float)LINK},
        {"too slow", 1.0f, 1.0f, 42.0f, 18.0f, (float)LINK},
        {"too fast", 1.0f, 1.0f, 42.0f, 150.0f, (float)LINK},
        {"reference apart", 1.0f, 1.0f, 22.0f, 42.0f, (float)LINK},
    };
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        turn(0.2);
        const float before = world.learn.effective;
        for (int32_t k = 0; k < 10000; k++) {
            const period_t good = next();
            const period_t bad = {
                .omega_e = cases[n].omega_e,
                .omega_e_ref = cases[n].omega_e_ref,
                .emf = {cases[n].emf * good.emf.alpha, cases[n].emf * good.emf.beta},
                .current = {cases[n].current * good.current.alpha, cases[n].current * good.current.beta},
                .link = cases[n].link,
            };
            step(&bad);
        }
        TEST_ASSERT_EQUAL_FLOAT_MESSAGE(before, world.learn.effective, cases[n].what);
        turn(10.0);
        TEST_ASSERT_TRUE_MESSAGE(fabs(off()) < 2e-3, cases[n].what);
    }
}

/* Frozen samples: the current is constant for any EMF. This is detected after as many periods as
 * directions of the current are stored. */
static void test_nothing_is_learnt_from_a_constant_current(void)
{
    turn(0.2);
    period_t input = next();
    const ab_t frozen = input.current;
    for (int32_t n = 0; n < 4; n++) {
        step(&input);
        input = next();
        input.current = frozen;
    }
    const float before = world.learn.effective;
    for (int32_t n = 0; n < 10000; n++) {
        input = next();
        input.current = frozen;
        step(&input);
    }
    TEST_ASSERT_EQUAL_FLOAT(before, world.learn.effective);
}

/* The current turns at twice the speed of the reference, as that of a loop which has left the rotor: in the
 * frame of the reference the mean of its direction has the square 1/(1 + 1) = 0.5, less than 0.8. */
static void test_nothing_is_learnt_from_a_current_that_does_not_turn_with_the_reference(void)
{
    turn(0.2);
    float before = 0.0f;
    for (int32_t n = 0; n < 20000; n++) {
        world.theta += world.omega * PERIOD;
        const double complex current = world.current * cexp(J * (2.0 * world.theta + world.ahead));
        const double complex error = (TRUE - (double)world.learn.effective) * LINK * signs_of(current, false);
        const period_t input = {(float)world.omega, (float)world.omega,
                                to_ab(J * PSI * world.omega * cexp(J * world.theta) + error), to_ab(current),
                                (float)LINK};
        step(&input);
        before = n == 2000 ? world.learn.effective : before; /* the means have forgotten the time before */
    }
    TEST_ASSERT_EQUAL_FLOAT(before, world.learn.effective);
}

/* With an EMF as if the legs lost voltage without limit, the learnt value ends at 1.7 dead bands; with an
 * EMF as if they added voltage, it ends at zero. */
static void test_limits(void)
{
    for (int32_t n = 0; n < 2; n++) {
        setUp();
        for (int32_t k = 0; k < 60000; k++) {
            world.theta += world.omega * PERIOD;
            const double complex current = world.current * cexp(J * (world.theta + world.ahead));
            const period_t input = {(float)world.omega, (float)world.omega,
                                    to_ab(J * PSI * world.omega * cexp(J * world.theta) +
                                          (n != 0 ? -3.0 : 3.0) * signs_of(current, false)),
                                    to_ab(current), (float)LINK};
            step(&input);
        }
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, n != 0 ? 0.0 : 1.7 * BAND, (double)world.learn.effective);
        TEST_ASSERT_TRUE(world.learn.effective >= 0.0f && world.learn.effective <= 1.7f * (float)BAND);
    }
}

/* The learnt value is kept if other coefficients change, but not if its own parameters change or if
 * learning is off. */
static void test_what_is_learnt_stays_until_the_parameters_change(void)
{
    turn(2.0);
    const float learnt = world.learn.effective;
    dead_time_learn_params_t params = PARAMS;
    params.flux_linkage *= 1.1f;
    take(&params);
    TEST_ASSERT_EQUAL_FLOAT(learnt, world.learn.effective);
    params.rate = 0.0f;
    take(&params);
    TEST_ASSERT_EQUAL_FLOAT(PARAMS.effective, world.learn.effective);
    params.rate = PARAMS.rate;
    params.effective = 0.02f;
    take(&params);
    TEST_ASSERT_EQUAL_FLOAT(0.02f, world.learn.effective);
}

/* The parameters change, and the rotor has turned by half a turn at the next step. The mean of the EMF
 * must begin again with that step; otherwise it would have the opposite direction. */
static void test_with_other_parameters_the_means_begin_again(void)
{
    turn(0.1);
    dead_time_learn_params_t params = PARAMS;
    params.effective = (float)(0.8 * TRUE);
    take(&params);
    world.theta += PI;
    for (uint32_t n = 0; n < EVERY; n++) {
        const period_t input = next();
        step(&input);
    }
    const double complex mean = (double)world.learn.emf_mean.alpha + (double)world.learn.emf_mean.beta * J;
    const double complex rotor = J * PSI * world.omega * cexp(J * world.theta);
    TEST_ASSERT_TRUE(creal(mean * conj(rotor)) > 0.5 * creal(rotor * conj(rotor)));
}
