/* A shaft in double precision, counted as by the hardware (floor, modulo counts per turn), is given to the
 * module; the true angle and speed are known. All expected values are closed forms of the loop in the
 * header. */
#include <float.h>

#include "estimator/encoder.h"
#include "math/angle.h"
#include "tests/unit/compare.h"
#include "tests/unit/sweep.h"

static const encoder_params_t PARAMS = {
    .count_per_turn = 10000.0f, .pole_pairs = 4.0f, .offset = 0.0f, .bandwidth = 200.0f, .period = 1e-4f};

/* The rounding of the angle: 2^-23 of the product (numbers up to pi), and 2^-24 of the angle of a count
 * times pi. */
#define ANGLE_ROUNDING 4e-7

static uint32_t count_at(double turns, double steps)
{
    return (uint32_t)floor((turns - floor(turns)) * steps);
}

/* Half a step of the count [rad], electrical. */
static double half_step(const encoder_params_t *params)
{
    return PI * (double)params->pole_pairs / (double)params->count_per_turn;
}

/* The largest error of the speed [rad/s] that an angle error within half a step can cause. It is half a
 * step times the 1-norm of the loop's impulse response from angle to speed, which is twice the peak of its
 * step response r^2/T (n+1) a^n. 5 % are added for rounding: the last digit of the speed at 628 rad/s is
 * 8e-6 rad of angle, 0.6 % of the half step, and the angle is rounded, too. */
static double ripple_bound(const encoder_params_t *params)
{
    double x = (double)params->bandwidth * (double)params->period;
    double peak = 0.0;
    for (int n = 0; n < 10000; n++) {
        double value = pow(1.0 - exp(-x), 2.0) / (double)params->period * (n + 1) * exp(-x * n);
        peak = value > peak ? value : peak;
    }
    return 1.05 * 2.0 * peak * half_step(params);
}

/* The largest error of the mean speed over this number of samples [rad/s]. The sum of the speed is the
 * change of (step response * angle error), at most half step / T at either end. The prediction rounds
 * twice per step by at most 2^-23. */
static double mean_bound(const encoder_params_t *params, int samples)
{
    return (2.0 * half_step(params) / samples + 2.0 / 8388608.0) / (double)params->period;
}

static encoder_tuning_t tuning; /* tuning of the encoder that was started last */

/* Starts an encoder with these parameters at count 0 and standstill. */
static void start_at_zero(encoder_t *encoder, const encoder_params_t *params)
{
    encoder_prepare(&tuning, params);
    memset(encoder, 0x55, sizeof *encoder);
    encoder_reset(encoder, &tuning, 0u);
}

static void test_angle_is_exact_for_every_count(void)
{
    /* 41 steps and 2 pole pairs are a case whose quotient the float estimates too low; in most large ones
     * it is too high. */
    static const uint32_t sets[][2] = {
        {10000, 4}, {4096, 7},   {65536, 4}, {65536, 32767}, {65535, 32767}, {2, 1},     {2, 3}, {3, 2},
        {10001, 3}, {60000, 21}, {1000, 50}, {65536, 32749}, {10000, 10000}, {20000, 1}, {41, 2}};
    for (unsigned s = 0; s < sizeof sets / sizeof sets[0]; s++) {
        encoder_params_t params = PARAMS;
        params.count_per_turn = (float)sets[s][0];
        params.pole_pairs = (float)sets[s][1];
        encoder_t encoder;
        start_at_zero(&encoder, &params);
        double worst = 0.0;
        for (uint32_t count = 0; count < sets[s][0]; count += sets[s][0] < 1000u ? 1u : SWEEP) {
            uint64_t halves = (2 * (uint64_t)count + 1) * sets[s][1] % (2 * (uint64_t)sets[s][0]);
            double expected = PI * (double)halves / (double)sets[s][0];
            float theta = encoder_step(&encoder, &tuning, count).theta_e;
            double error = fabs(circle((double)theta - expected));
            if (!(error <= worst) || !((double)theta >= -PI && (double)theta < PI)) {
                worst = error;
            }
        }
        /* The second term is the rounding of 2 pi in double precision. */
        TEST_ASSERT_DOUBLE_WITHIN(ANGLE_ROUNDING + 8.0 * DBL_EPSILON, 0.0, worst);
    }
}

static void test_offset_is_added_and_wrapped(void)
{
    static const float offsets[] = {0.5f, 3.0f, -3.0f, 500.0f};
    for (unsigned k = 0; k < sizeof offsets / sizeof offsets[0]; k++) {
        encoder_params_t params = PARAMS;
        params.offset = offsets[k];
        encoder_t encoder;
        start_at_zero(&encoder, &params);
        for (uint32_t count = 0; count < 10000; count += 111) {
            double expected = (double)offsets[k] + 2.0 * PI * 4.0 * (count + 0.5) / 10000.0;
            float theta = encoder_step(&encoder, &tuning, count).theta_e;
            /* The sum with 500 is rounded by 2^-16. */
            TEST_ASSERT_DOUBLE_WITHIN(ANGLE_ROUNDING + fabs((double)offsets[k]) / 16777216.0 +
                                          (32.0 + fabs((double)offsets[k])) * DBL_EPSILON,
                                      0.0, circle((double)theta - expected));
            TEST_ASSERT_TRUE((double)theta >= -PI && (double)theta < PI);
        }
    }
}

static void test_count_beyond_the_turn_is_the_last_one(void)
{
    encoder_t encoder;
    start_at_zero(&encoder, &PARAMS);
    float last = encoder_step(&encoder, &tuning, 9999).theta_e;
    TEST_ASSERT_FALSE(encoder_step(&encoder, &tuning, 9998).theta_e == last);
    TEST_ASSERT_TRUE(encoder_step(&encoder, &tuning, 10000).theta_e == last);
    TEST_ASSERT_TRUE(encoder_step(&encoder, &tuning, 20001).theta_e == last);
    TEST_ASSERT_TRUE(encoder_step(&encoder, &tuning, UINT32_MAX).theta_e == last);
}

/* Many turns at constant speed: the angle is within half a step, the speed within the bound of its ripple,
 * and its mean is exact. */
static void run_at_constant_speed(const encoder_params_t *params, double omega_e)
{
    enum { SETTLE = 5000, WATCH = SWEEP > 1 ? 5000 : 100000 };
    double period = (double)params->period;
    double turns_per_period = omega_e * period / (2.0 * PI * (double)params->pole_pairs);
    double start = 0.37;
    encoder_t encoder;
    start_at_zero(&encoder, params);
    encoder_reset(&encoder, &tuning, count_at(start, (double)params->count_per_turn));

    double worst_angle = 0.0;
    double worst_speed = 0.0;
    double sum = 0.0;
    for (int32_t k = 0; k < SETTLE + WATCH; k++) {
        double turns = start + turns_per_period * k;
        position_t position =
            encoder_step(&encoder, &tuning, count_at(turns, (double)params->count_per_turn));
        double theta_err =
            fabs(circle((double)position.theta_e - 2.0 * PI * (double)params->pole_pairs * turns));
        double omega_err = (double)position.omega_e - omega_e;
        worst_angle = theta_err <= worst_angle ? worst_angle : theta_err;
        if (k >= SETTLE) {
            sum += omega_err;
            worst_speed = fabs(omega_err) <= worst_speed ? worst_speed : fabs(omega_err);
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(half_step(params) + ANGLE_ROUNDING, 0.0, worst_angle);
    TEST_ASSERT_DOUBLE_WITHIN(ripple_bound(params), 0.0, worst_speed);
    TEST_ASSERT_DOUBLE_WITHIN(mean_bound(params, WATCH), 0.0, sum / WATCH);
}

static void test_constant_speed_with_a_fraction_of_a_count_per_pole(void)
{
    encoder_params_t params = PARAMS;
    params.pole_pairs = 3.0f;
    params.bandwidth = 50.0f;
    params.count_per_turn = 10001.0f;
    run_at_constant_speed(&params, 431.0);
    run_at_constant_speed(&params, -431.0);
}

static void test_speed_is_late_in_an_acceleration_by_the_stated_amount(void)
{
    static const float bandwidths[] = {200.0f, 200.0f, 100.0f, 400.0f};
    static const double accelerations[] = {6668.0, -6668.0, 6668.0, -3000.0};
    for (int n = 0; n < 4; n++) {
        const float bandwidth = bandwidths[n];
        const double acceleration = accelerations[n];
        encoder_params_t params = PARAMS;
        params.bandwidth = bandwidth;
        encoder_t encoder;
        start_at_zero(&encoder, &params);
        double period = (double)params.period;
        double rest = 1.0 - exp(-(double)bandwidth * period);
        double expected = -acceleration * period * (2.0 / rest - 1.5);

        enum { SETTLE = 2000, WATCH = 2000 };
        double sum = 0.0;
        for (int32_t k = 0; k < SETTLE + WATCH; k++) {
            double time = k * period;
            double turns = 0.5 * acceleration * time * time / (2.0 * PI * 4.0);
            position_t position = encoder_step(&encoder, &tuning, count_at(turns, 10000.0));
            if (k >= SETTLE) {
                sum += (double)position.omega_e - acceleration * time;
            }
        }
        /* The limit is 0.015 rad/s; an error of half a period would be 0.33 rad/s. */
        TEST_ASSERT_DOUBLE_WITHIN(mean_bound(&params, WATCH), expected, sum / WATCH);
        /* The approximation that the header states. */
        TEST_ASSERT_DOUBLE_WITHIN(fabs(acceleration) * period, -2.0 * acceleration / (double)bandwidth,
                                  sum / WATCH);
    }
}

/* Braking with 5e4 rad/s^2 from 2500 rad/s, with 2500 lines and three pole pairs, in both directions. The
 * prediction is wrong by a T^2/r^2 = 25.8 mrad and, with two counts of 1.88 mrad, by at most 29.5 mrad. A
 * step by 0.3 rad leaves more than that for the 2.5 ms in which the loop corrects it: e^-2 of it, 41 mrad,
 * at most. */
static void test_braking_is_behind_its_prediction_by_no_more_than_stated(void)
{
    const encoder_params_t params = {10000.0f, 3.0f, 0.0f, 1500.0f, 1e-4f};
    const double braking = 5e4;
    const double rest = 1.0 - exp(-0.15);
    const double stated = braking * 1e-8 / (rest * rest) + 4.0 * half_step(&params);
    for (int way = -1; way <= 1; way += 2) {
        encoder_t encoder;
        start_at_zero(&encoder, &params);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * stated, stated,
                                  (double)encoder_missed_most(&tuning, (float)braking));
        double sum = 0.0;
        double behind = 0.0;
        for (int k = -200; k < 450; k++) { /* the loop settles at the constant speed */
            const double t = 1e-4 * k;
            const double angle = 2500.0 * t - (k > 0 ? 0.5 * braking * t * t : 0.0) + (k >= 400 ? 0.3 : 0.0);
            encoder_step(&encoder, &tuning, count_at(way * angle / (2.0 * PI * 3.0), 10000.0));
            const double now = -way * (double)encoder.missed;
            TEST_ASSERT_TRUE(k < 0 || k >= 400 || now < stated);
            sum += k >= 200 && k < 400 ? now : 0.0;
            behind = k > 400 && now > behind ? now : behind;
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.5 * half_step(&params), braking * 1e-8 / (rest * rest), sum / 200.0);
        TEST_ASSERT_TRUE(behind > 0.3 * exp(-2.0) && behind > stated);
    }
}

static void test_reset_stands_still_at_the_given_count(void)
{
    encoder_t encoder;
    start_at_zero(&encoder, &PARAMS);
    for (uint32_t k = 0; k < 1000; k++) {
        encoder_step(&encoder, &tuning, 25 * k % 10000);
    }
    TEST_ASSERT_TRUE(encoder.omega_e > 100.0f);
    encoder_reset(&encoder, &tuning, 7777);
    for (int k = 0; k < 5; k++) {
        position_t position = encoder_step(&encoder, &tuning, 7777);
        TEST_ASSERT_TRUE(position.omega_e == 0.0f);
        TEST_ASSERT_DOUBLE_WITHIN(ANGLE_ROUNDING + 32.0 * DBL_EPSILON, 0.0,
                                  circle((double)position.theta_e - 2.0 * PI * 4.0 * 7777.5 / 10000.0));
    }
    /* Moving the count by one is one step of the loop: r^2/T of one count, 3.92 * 2.51e-3. */
    double rest = 1.0 - exp(-0.02);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, rest * rest / 1e-4 * 2.0 * half_step(&PARAMS),
                              (double)encoder_step(&encoder, &tuning, 7778).omega_e);
}

/* If the angles of the counts change, the speed does not: a shaft at standstill remains at standstill, and
 * the speed of a turning shaft is that of an encoder that starts on it. */
static void test_other_angles_of_the_counts_are_no_motion(void)
{
    encoder_params_t others[3] = {PARAMS, PARAMS, PARAMS};
    others[0].pole_pairs = 7.0f;
    others[1].count_per_turn = 4096.0f;
    others[2].offset = 1.0f;
    for (size_t n = 0; n < 3; n++) {
        encoder_tuning_t other;
        encoder_prepare(&other, &others[n]);
        encoder_t encoder;
        start_at_zero(&encoder, &PARAMS);
        encoder_reset(&encoder, &tuning, 3210u);
        encoder_take(&encoder, &tuning, &other, 3210u);
        for (int k = 0; k < 100; k++) {
            const float omega = encoder_step(&encoder, &other, 3210u).omega_e;
            TEST_ASSERT_EQUAL_FLOAT(0.0f, omega);
        }
        encoder_t fresh;
        start_at_zero(&fresh, &others[n]);
        encoder_reset(&fresh, &tuning, 3210u);
        for (uint32_t k = 3211u; k < 3311u; k++) {
            const float wanted = encoder_step(&fresh, &tuning, k).omega_e;
            const float omega = encoder_step(&encoder, &other, k).omega_e;
            TEST_ASSERT_EQUAL_FLOAT(wanted, omega);
        }
    }
}

/* A shaft that turns by 0.25 rad per period, electrical, is braked evenly to standstill within 1 to 200
 * periods. Differences above forty counts, 0.1 rad, are those of a rotor that brakes. */
static void test_any_braking_to_standstill_may_be_the_rotors(void)
{
    enum { SETTLE = 500 }; /* 25 time constants of the slowest loop */
    static const float bandwidths[] = {500.0f, 1000.0f, 1500.0f, 3000.0f};
    for (size_t n = 0; n < 4; n++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            for (int periods = 1; periods <= 200; periods += SWEEP_FEW) {
                encoder_params_t params = PARAMS;
                params.bandwidth = bandwidths[n];
                encoder_t encoder;
                start_at_zero(&encoder, &params);
                double turns = 0.0;
                double speed = 0.01 * sign; /* turns per period */
                for (int k = 0; k < SETTLE + 4 * periods; k++) {
                    speed -= k >= SETTLE && k < SETTLE + periods ? 0.01 * sign / periods : 0.0;
                    turns += k >= SETTLE + periods ? 0.0 : speed;
                    (void)encoder_step(&encoder, &tuning, count_at(turns, 10000.0));
                    if (k >= SETTLE && fabs((double)encoder.missed) > 80.0 * half_step(&params)) {
                        TEST_ASSERT_TRUE(encoder_may_brake(&encoder, &tuning));
                    }
                }
            }
        }
    }
}

/* With T omega < r (1 - r/2) |m| no braking explains the difference m: at standstill, and at a speed below.
 * Nor does it explain an angle that is ahead of the prediction. At 1500 rad/s r (1 - r/2) is 0.130: 0.6 rad
 * need 777 rad/s. */
static void test_an_angle_that_no_braking_explains_is_none(void)
{
    static const struct {
        float omega_e, missed;
        bool brakes;
    } cases[] = {{0.0f, 0.6f, false},    {0.0f, -0.6f, false},   {700.0f, -0.6f, false},
                 {-700.0f, 0.6f, false}, {850.0f, -0.6f, true},  {-850.0f, 0.6f, true},
                 {850.0f, 0.6f, false},  {-850.0f, -0.6f, false}};
    encoder_params_t params = PARAMS;
    params.bandwidth = 1500.0f;
    encoder_t encoder;
    start_at_zero(&encoder, &params);
    const float rest = 1.0f - expf(-0.15f);
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        encoder.missed = cases[n].missed;
        encoder.omega_e = cases[n].omega_e + rest * rest / 1e-4f * cases[n].missed; /* after the sample */
        TEST_ASSERT_EQUAL(cases[n].brakes, encoder_may_brake(&encoder, &tuning));
    }
}

/* The loop continues with this speed, as one that has followed the shaft for a long time: 20 counts per
 * period are 0.0503 rad. */
static void test_a_loop_that_follows_has_no_difference(void)
{
    encoder_t encoder;
    start_at_zero(&encoder, &PARAMS);
    for (uint32_t k = 0; k < 1000u; k++) {
        (void)encoder_step(&encoder, &tuning, 200u * k % 10000u);
    }
    const double speed = 20.0 * 2.0 * half_step(&PARAMS) / 1e-4;
    for (int sign = -1; sign <= 1; sign += 2) {
        encoder_follow(&encoder, &tuning, 5000u, (float)(sign * speed));
        TEST_ASSERT_EQUAL_FLOAT(0.0f, encoder.missed);
        for (int k = 1; k <= 100; k++) {
            const position_t position = encoder_step(&encoder, &tuning, (uint32_t)(5000 + sign * 20 * k));
            TEST_ASSERT_DOUBLE_WITHIN(1e-5 * speed, sign * speed, (double)position.omega_e);
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, (double)encoder.missed);
        }
    }
}
