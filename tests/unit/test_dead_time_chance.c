/* The learning of the dead time with right parameters: neither a motion of the rotor nor the noise of the
 * sensors replaces them. */
#include "tests/unit/dead_time_bench.h"

void setUp(void)
{
    world_begin();
}

/* The parameters are right, and the current is along the magnet, as in a forced frame. The EMF, across the
 * current, grows with the speed from 4.6 to 22 V in 0.16 s. A mean that followed this growth with the time
 * constant 1/omega would be short by up to psi_f 600/omega = 2 V, which is no dead time. */
static void test_an_accelerating_rotor_teaches_nothing(void)
{
    for (int32_t n = 0; n < 2; n++) {
        setUp();
        know();
        world.ahead = 0.0;
        const double direction = n != 0 ? -1.0 : 1.0;
        for (int32_t k = 0; k < 1600; k++) {
            world.omega = direction * (25.0 + 600.0 * PERIOD * k);
            const period_t input = next();
            step(&input);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, unlearnt());
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, off());
        }
    }
}

/* The EMF of a salient rotor is shorter by D i_d/psi_f, here by a third, as soon as the loop tracks it. */
static void test_with_another_model_of_the_rotor_the_means_begin_again(void)
{
    know();
    world.ahead = 0.0;
    turn(0.1);
    world.flux = 0.67;
    world.model = 1u;
    for (int32_t k = 0; k < 1000; k++) {
        turn(PERIOD);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, unlearnt());
    }
}

/* A rotor swings in a forced frame. Its EMF, across the current, swings by psi_f 6 rad/s = 1.1 V. At 12/s the
 * twelfth harmonic moves the learnt value by 12 9.4 1.1/(12 omega) = 0.26 V, 3.3 % of the dead band's
 * voltage, and the used value by a sixth of that. */
static void test_a_swinging_rotor_does_not_replace_right_parameters(void)
{
    dead_time_learn_params_t params = PARAMS;
    params.rate = 12.0f;
    params.effective = (float)TRUE;
    take(&params);
    world.ahead = 0.0;
    world.omega = 40.0;
    world.faster = 6.0;
    world.swing = 76.0;
    double most = 0.0;
    for (int32_t k = 0; k < 2000; k++) {
        turn(PERIOD);
        most = fmax(most, fabs(unlearnt()) * TRUE / BAND);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, off());
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.005, 0.029, most);
}

/* A rotor swings through half a radian, with an EMF of 4.4 V across the current, and the damping turns the
 * current by 0.4 rad, which are 4.8 rad of the twelfth harmonic. At some of the speeds a harmonic of the
 * swing coincides with it. The learnt value moves by up to a quarter of the dead band, and remains below the
 * threshold, so that at most a tenth of V is used. */
static void test_a_rotor_that_swings_far_does_not_replace_right_parameters(void)
{
    double most = 0.0, used = 0.0;
    for (int32_t n = 0; n < 40; n++) {
        setUp();
        dead_time_learn_params_t params = PARAMS;
        params.rate = 6.0f;
        params.effective = (float)TRUE;
        take(&params);
        world.ahead = 0.0;
        world.omega = 26.0 + 0.2 * n;
        world.faster = 24.0;
        world.swing = 43.0;
        world.damps = n % 2 == 0 ? -0.4 : 0.4;
        for (int32_t k = 0; k < 4000; k++) {
            turn(PERIOD);
            most = fmax(most, fabs(unlearnt()) * TRUE / BAND);
            used = fmax(used, fabs(off()));
        }
    }
    TEST_ASSERT_TRUE(most > 2.0 * (double)DEAD_TIME_LEARN_CHANCE);
    TEST_ASSERT_TRUE(used < 0.1);
}

/* The torque of the shape swings a rotor at 6 omega. Its EMF of 7.7 V swings by 8 % with its speed, and in a
 * forced frame the damping turns the current by c. The learnt value then contains up to 28 c 0.64 V, half of
 * which the weight of the steps removes: with 0.05 rad 0.45 V of 7.2 V. At most 2 % of V is used. If the
 * swing of the current were not considered, the parameters would be replaced. */
static void test_a_rotor_that_the_shape_swings_does_not_replace_right_parameters(void)
{
    static const double swings[] = {0.03, 0.05, 0.1, 0.2};
    for (size_t n = 0; n < sizeof swings / sizeof swings[0]; n++) {
        double most = 0.0, kept = 0.0, used = 0.0;
        for (int32_t k = 0; k < 14; k++) {
            setUp();
            know();
            world.ahead = 0.13 * (k / 2 - 3);
            world.faster = k % 2 == 0 ? 3.5 : -3.5;
            world.swing = 6.0 * world.omega;
            world.damps = swings[n];
            const world_t begun = world;
            world.forced = true;
            for (int32_t time = 0; time < 1000; time++) {
                turn(1e-3);
                most = fmax(most, fabs(unlearnt()));
                kept = fmax(kept, fabs(off()));
            }
            world = begun;
            turn(3.0);
            used = fmax(used, fabs(off()));
        }
        TEST_ASSERT_TRUE(most > 0.04 && used > 0.04);
        TEST_ASSERT_TRUE(kept < 0.02);
    }
}

/* The current swings in the same way beside a rotor that turns evenly: parameters that are wrong by 40 % are
 * replaced. */
static void test_a_swing_of_the_current_does_not_prevent_learning(void)
{
    static const double swings[] = {0.03, -0.03, 0.06, -0.06, -0.1};
    for (size_t n = 0; n < sizeof swings / sizeof swings[0]; n++) {
        setUp();
        world.ahead = 0.0;
        world.dwells = swings[n];
        world.forced = true;
        turn(3.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.0, off());
    }
}

static double random_normal(uint32_t *state)
{
    double sum = -6.0;
    for (int32_t n = 0; n < 12; n++) {
        *state = *state * UINT32_C(1664525) + UINT32_C(1013904223);
        sum += *state / 4294967296.0;
    }
    return sum;
}

/* A period with the noise that two sensors cause in the EMF of a winding: L/T times its change. */
static void noisy_period(double inductance, double complex *last, uint32_t *state)
{
    const double complex noise =
        world.known * (random_normal(state) + J * sqrt(5.0 / 3.0) * random_normal(state));
    period_t input = next();
    const ab_t extra = to_ab(inductance / PERIOD * (noise - *last));
    *last = noise;
    input.emf = (ab_t){input.emf.alpha + extra.alpha, input.emf.beta + extra.beta};
    step(&input);
}

/* With a large winding the noise of the sensors scatters the learnt value by some per cent. The law knows how
 * much: over 200 runs of 0.3 s the variance agrees within four deviations of its own, 4 sqrt(2/200). The
 * threshold is four deviations s, so that of an x with a normal distribution x min(1, x/(4 s))^4 is used. Its
 * mean square is that of x^10/4^8, 945/65536 = 0.0144 s^2. Some ten values of a run are independent, the mean
 * of x^20 is 733 times the square of that of x^10, and four deviations are 4 sqrt(733/2000) = 2.4 of the
 * 0.0144. */
static void test_noise_of_the_sensors_does_not_replace_right_parameters(void)
{
    dead_time_learn_params_t params = PARAMS;
    params.rate = 6.0f;
    params.effective = (float)TRUE;
    params.inductance = 0.03f;
    uint32_t state = 1u;
    double last_squares = 0.0, learnt = 0.0, used = 0.0, expected = 0.0;
    for (int32_t n = 0; n < 200; n++) {
        setUp();
        take(&params);
        world.omega = 80.0;
        world.known = 0.015;
        double complex last = 0.0;
        for (int32_t k = 0; k < 3000; k++) {
            noisy_period(0.03, &last, &state);
            learnt += unlearnt() * unlearnt();
            used += off() * off();
        }
        const double apart = (double)world.learn.learnt - TRUE;
        last_squares += apart * apart / 200.0;
        expected = (double)world.learn.variance;
    }
    TEST_ASSERT_TRUE(sqrt(last_squares) > 0.01 * BAND);
    TEST_ASSERT_DOUBLE_WITHIN(0.4, 1.0, last_squares / expected);
    TEST_ASSERT_TRUE(used <= 3.4 * 0.0144 * learnt);
}
