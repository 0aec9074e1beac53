/* Each contribution to the uncertainty of the angle is tested alone, with expected values from algebra in
 * double precision: the data of the test make the other contributions zero. */
#include "medium/adapt/angle_sigma.h"
#include "tests/unit/vectors.h"

#define KP     400.0
#define KI     40000.0
#define PERIOD 1e-4
#define WINDOW 8e-4

static const angle_sigma_params_t PARAMS = {
    .data = 0.1f,
    .resistance = 0.95f,
    .inductance_d = 0.0125f,
    .inductance_q = 0.02f,
    .kp = (float)KP,
    .ki = (float)KI,
    .band = 0.025f,
    .zone = 1e-3f,
    .leg_rate = 4.0f,
    .inductance_rate = 2.0f,
    .encoder = 1e-3f,
    .period = (float)PERIOD,
    .window = (float)WINDOW,
};

static angle_sigma_t sigma;

/* An EMF of 100 V at 500 rad/s, i_q of 4 A, no dead time, and all values learnt as accurately as possible. */
static angle_sigma_input_t learnt(void)
{
    return (angle_sigma_input_t){.amplitude = 100.0f,
                                 .emf = {0.0f, 100.0f},
                                 .noise = 0.125f,
                                 .omega_e = 500.0f,
                                 .current = {0.0f, 4.0f},
                                 .leg_rate = 0.4f,
                                 .inductance_rate = 0.2f,
                                 .resistance_rate = 0.2f};
}

static double stated(const angle_sigma_params_t *params, const angle_sigma_input_t *input)
{
    const angle_sigma_tuning_t tuning = angle_sigma_prepare(params);
    angle_sigma_reset(&sigma, ANGLE_SIGMA_UNKNOWN);
    angle_sigma_step(&sigma, &tuning, input);
    return (double)sigma.sigma;
}

/* The root of the sum of the squares of this contribution, of the gain of the sensors, and of the smallest
 * uncertainty. */
static double with_gain(double contribution, double omega, double current)
{
    const double gain = (double)ANGLE_SIGMA_GAIN * omega * 0.02 * current / 100.0;
    return sqrt(contribution * contribution + gain * gain + pow((double)ANGLE_SIGMA_LEAST, 2.0));
}

void setUp(void)
{
}

static void test_an_inductance_that_is_not_learnt_turns_the_emf_by_its_reactance(void)
{
    angle_sigma_params_t params = PARAMS;
    angle_sigma_input_t input = learnt();
    params.inductance_rate = 0.0f;
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, with_gain(0.1 * 500.0 * 0.02 * 4.0 / 100.0, 500.0, 4.0),
                              stated(&params, &input));
    input.current.q = -4.0f;
    input.omega_e = -500.0f;
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, with_gain(0.1 * 500.0 * 0.02 * 4.0 / 100.0, 500.0, 4.0),
                              stated(&params, &input));
}

static void test_a_resistance_that_is_not_learnt_counts_with_i_d_only(void)
{
    angle_sigma_params_t params = PARAMS;
    angle_sigma_input_t input = learnt();
    input.omega_e = 0.0f; /* without a reactance */
    input.resistance_rate = 2.0f;
    const double first = 0.1 * 0.1 + pow((double)ANGLE_SIGMA_R_LEARNT, 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, with_gain(0.0, 0.0, 0.0), stated(&params, &input));
    input.current.d = -3.0f;
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, with_gain(sqrt(first) * 0.95 * 3.0 / 100.0, 0.0, 0.0),
                              stated(&params, &input));
}

static void test_the_first_error_falls_with_the_sixth_power_of_the_rate_and_the_noise_with_its_root(void)
{
    static const double shares[] = {1.0, 0.7, 0.5, 0.3, 0.1};
    for (uint32_t n = 0; n < sizeof shares / sizeof shares[0]; n++) {
        angle_sigma_input_t input = learnt();
        input.inductance_rate = (float)(2.0 * shares[n]);
        const double left = pow(shares[n], 6.0) * 0.1;
        const double noise = sqrt(shares[n]) * (double)ANGLE_SIGMA_L_LEARNT;
        TEST_ASSERT_DOUBLE_WITHIN(
            2e-6, with_gain(sqrt(left * left + noise * noise) * 500.0 * 0.02 * 4.0 / 100.0, 500.0, 4.0),
            stated(&PARAMS, &input));
    }
}

/* The loss of the legs leaves a sawtooth across the current. Its sixth harmonic is 12/35 of its amplitude,
 * and the loop follows it with the gain of a first-order low-pass at k_p. */
static void test_the_loss_of_the_legs_acts_along_the_current_and_with_its_sawtooth_across(void)
{
    angle_sigma_params_t params = PARAMS;
    params.leg_rate = 0.0f;
    params.inductance_d = 1.0f; /* so large that there is no ripple */
    angle_sigma_input_t input = learnt();
    input.link = 320.0f; /* a dead band of 8 V */
    const double volt = 0.1 * 8.0 * 4.0 / PI;
    const double follows = KP / hypot(KP, 6.0 * 500.0);
    TEST_ASSERT_DOUBLE_WITHIN(
        5e-6,
        with_gain(hypot(volt * 12.0 / 35.0 / sqrt(2.0) * follows / 100.0,
                        500.0 * 0.02 * 4.0 / 100.0 * sqrt(0.1) * (double)ANGLE_SIGMA_L_LEARNT),
                  500.0, 4.0),
        stated(&params, &input));
    input.current = (dq_t){-4.0f, 0.0f};
    const double sawtooth = sqrt(1.0 + pow(12.0 / 35.0 * follows, 2.0) / 2.0);
    const double ohm = 0.95 * 4.0 * sqrt(0.1) * (double)ANGLE_SIGMA_R_LEARNT;
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, with_gain(hypot(volt * sawtooth, ohm) / 100.0, 500.0, 4.0),
                              stated(&params, &input));
}

/* The first error, the noise, and the difference from the parameters up to which these remain in use. */
static void test_a_loss_of_the_legs_that_is_learnt_but_not_used_counts(void)
{
    static const double shares[] = {1.0, 0.5, 0.2, 0.1};
    angle_sigma_params_t params = PARAMS;
    params.inductance_d = 1.0f; /* so large that there is no ripple */
    for (uint32_t n = 0; n < sizeof shares / sizeof shares[0]; n++) {
        angle_sigma_input_t input = learnt();
        input.current = (dq_t){-4.0f, 0.0f};
        input.link = 320.0f; /* a dead band of 8 V */
        input.leg_rate = (float)(4.0 * shares[n]);
        const double known = hypot(pow(shares[n], 6.0) * 0.1, sqrt(shares[n]) * (double)ANGLE_SIGMA_V_LEARNT);
        const double of_v = hypot(known, shares[n] * (double)ANGLE_SIGMA_V_UNUSED);
        const double follows = KP / hypot(KP, 6.0 * 500.0);
        const double volt = of_v * 8.0 * 4.0 / PI * sqrt(1.0 + pow(12.0 / 35.0 * follows, 2.0) / 2.0);
        const double ohm = 0.95 * 4.0 * sqrt(0.1) * (double)ANGLE_SIGMA_R_LEARNT;
        TEST_ASSERT_DOUBLE_WITHIN(5e-6, with_gain(hypot(volt, ohm) / 100.0, 500.0, 4.0),
                                  stated(&params, &input));
    }
}

static void test_where_the_ripple_exceeds_the_current_the_loss_of_the_legs_is_uncertain_though_learnt(void)
{
    angle_sigma_input_t input = learnt();
    input.current = (dq_t){0.01f, 0.0f};
    input.link = 311.0f; /* ripple of 311 V x 100 us/(8 x 12.5 mH) = 0.31 A */
    const double of_v = hypot(hypot((double)ANGLE_SIGMA_V_RIPPLE, 0.1 * (double)ANGLE_SIGMA_V_UNUSED),
                              sqrt(0.1) * (double)ANGLE_SIGMA_V_LEARNT);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * of_v * 0.025 * 311.0 * 4.0 / PI / 100.0,
                              with_gain(of_v * 0.025 * 311.0 * 4.0 / PI / 100.0, 500.0, 0.01),
                              stated(&PARAMS, &input));
}

static void test_the_noise_of_the_detector_passes_the_bandwidth_of_the_loop(void)
{
    angle_sigma_input_t input = learnt();
    input.current = (dq_t){0.0f, 0.0f};
    input.scatter = 1e-4f;
    const angle_sigma_tuning_t tuning = angle_sigma_prepare(&PARAMS);
    const double passes = 0.5 * PERIOD * (KP + KI / KP);
    angle_sigma_reset(&sigma, ANGLE_SIGMA_UNKNOWN);
    for (uint32_t n = 1; n <= 40u; n++) {
        angle_sigma_step(&sigma, &tuning, &input);
        const double mean = 1.0 - exp(-(double)n * WINDOW / (double)ANGLE_SIGMA_MEAN_TIME);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, with_gain(sqrt(passes * mean) * 1e-2, 0.0, 0.0), (double)sigma.sigma);
    }
}

/* A lag of 50 mrad, in either direction of rotation. */
static void test_a_lag_of_the_loop_is_stated_after_the_time_of_its_mean(void)
{
    const angle_sigma_tuning_t tuning = angle_sigma_prepare(&PARAMS);
    angle_sigma_input_t input = learnt();
    input.current = (dq_t){0.0f, 0.0f};
    for (int direction = -1; direction <= 1; direction += 2) {
        input.emf = (dq_t){-(float)(100.0 * sin(0.05)), (float)(direction * 100.0 * cos(0.05))};
        angle_sigma_reset(&sigma, ANGLE_SIGMA_UNKNOWN);
        for (uint32_t n = 1; n <= 40u; n++) {
            angle_sigma_step(&sigma, &tuning, &input);
            const double part = 1.0 - exp(-(double)n * WINDOW / (double)ANGLE_SIGMA_MEAN_TIME);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, with_gain(sin(0.05) * sqrt(part), 0.0, 0.0), (double)sigma.sigma);
        }
    }
}

/* A loop that lags behind a swinging shaft has a lag of both signs. Sigma is its rms value. */
static void test_a_lag_that_swings_counts_with_its_rms_value(void)
{
    const angle_sigma_tuning_t tuning = angle_sigma_prepare(&PARAMS);
    angle_sigma_input_t input = learnt();
    input.current = (dq_t){0.0f, 0.0f};
    angle_sigma_reset(&sigma, ANGLE_SIGMA_UNKNOWN);
    double mean = 0.0;
    for (int n = 1; n <= 500; n++) { /* 50 Hz: 25 windows */
        const double lag = 0.1 * sin(2.0 * PI * 50.0 * WINDOW * n);
        input.emf = (dq_t){(float)(100.0 * sin(lag)), (float)(100.0 * cos(lag))};
        angle_sigma_step(&sigma, &tuning, &input);
        mean += n > 250 ? (double)sigma.sigma / 250.0 : 0.0;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * 0.1 / sqrt(2.0), 0.1 / sqrt(2.0), mean);
}

/* White noise of the samples, of which the window's mean has an eighth of the variance, is no lag. The
 * low-pass leaves a scatter of a fifth of the mean's variance, which is less than what the loop passes. */
static void test_noise_is_no_lag(void)
{
    const angle_sigma_tuning_t tuning = angle_sigma_prepare(&PARAMS);
    angle_sigma_input_t input = learnt();
    input.current = (dq_t){0.0f, 0.0f};
    angle_sigma_reset(&sigma, ANGLE_SIGMA_UNKNOWN);
    uint32_t seed = 1u;
    double mean = 0.0;
    for (int n = 0; n < 4000; n++) {
        double sum = 0.0, square = 0.0;
        for (int k = 0; k < 8; k++) { /* uniform, with a standard deviation of 10 mrad */
            seed = seed * 1664525u + 1013904223u;
            const double sample = 0.01 * sqrt(3.0) * ((double)seed / 2147483648.0 - 1.0);
            sum += sample / 8.0;
            square += sample * sample / 8.0;
        }
        input.emf = (dq_t){(float)(100.0 * sum), 100.0f};
        input.scatter = (float)square;
        angle_sigma_step(&sigma, &tuning, &input);
        mean += (double)(sigma.sigma * sigma.sigma) / 4000.0;
    }
    const double passes = 0.5 * PERIOD * (KP + KI / KP) * 1e-4;
    TEST_ASSERT_DOUBLE_WITHIN(0.125 * 0.2 * 1e-4, passes + pow((double)ANGLE_SIGMA_LEAST, 2.0), mean);
}

static void test_the_angle_of_a_loop_that_coasts_drifts_until_it_tracks_again(void)
{
    const angle_sigma_tuning_t tuning = angle_sigma_prepare(&PARAMS);
    angle_sigma_input_t input = learnt();
    input.current = (dq_t){0.0f, 0.0f};
    input.coasted = 1u;
    angle_sigma_reset(&sigma, ANGLE_SIGMA_UNKNOWN);
    for (uint32_t n = 1; n <= 20u; n++) {
        angle_sigma_step(&sigma, &tuning, &input);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, with_gain(n * 500.0 * WINDOW * (double)ANGLE_SIGMA_DRIFT, 0.0, 0.0),
                                  (double)sigma.sigma);
    }
    input.coasted = 0u;
    angle_sigma_step(&sigma, &tuning, &input);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, with_gain(0.0, 0.0, 0.0), (double)sigma.sigma);
}

static void test_an_angle_without_an_emf_or_with_an_invalid_one_is_unknown(void)
{
    static const float invalid[] = {0.0f, 1e-6f, NAN, INFINITY};
    for (uint32_t n = 0; n < sizeof invalid / sizeof invalid[0]; n++) {
        angle_sigma_input_t input = learnt();
        input.scatter = n >= 2u ? invalid[n] : 0.0f;
        input.amplitude = n < 2u ? invalid[n] : 100.0f;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, PI / sqrt(3.0), stated(&PARAMS, &input));
    }
}

static void test_an_encoder_is_known_to_a_count(void)
{
    const angle_sigma_tuning_t tuning = angle_sigma_prepare(&PARAMS);
    angle_sigma_reset(&sigma, tuning.encoder);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1e-3 / sqrt(12.0), (double)sigma.sigma);
}
