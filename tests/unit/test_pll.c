/* A rotating EMF whose angle and speed are known in double precision is given to the loop. Small deviations
 * are compared with the linear oracle (pll_oracle.h), large ones with the numbers of docs/theory.md, 21, and
 * closed forms.
 *
 * Rounding: theta_e, its sine and the increment of the angle are accurate to 4e-7 rad per step, which the
 * loop (kp T >= 0.005) turns into less than 1e-5 rad in the mean. An integrator that contains the whole
 * speed (conventional loop) changes only if ki T eps exceeds half of its last digit, 1.6e-5 rad/s below
 * 512 rad/s: it may stop STALL/(ki T) away from its goal. */
#include "estimator/pll.h"
#include "math/angle.h"
#include "math/bounds.h"
#include "tests/oracle/pll_oracle.h"
#include "tests/unit/compare.h"

#define PSI      0.183
#define T        1e-4
#define COUNT    20000
#define SPEED    335.0 /* 800 r/min, electrical [rad/s] */
#define ROUNDING 1e-5
#define STALL    1.6e-5

static double angle_in[COUNT], speed_in[COUNT], error_out[COUNT], omega_out[COUNT];
static double error_expected[COUNT], omega_expected[COUNT];

static pll_params_t design(float bandwidth, float cutoff)
{
    pll_params_t params = {.amplitude_floor = 2.0f};
    params_error_t why;
    TEST_ASSERT_TRUE(pll_design(&params, bandwidth, 1.0f, cutoff, 1e-4f));
    TEST_ASSERT_TRUE(pll_params_check(&params, &why));
    return params;
}

static pll_oracle_t oracle_of(const pll_params_t *params, double gamma)
{
    return (pll_oracle_t){(double)params->kp, (double)params->ki, (double)params->feedforward_cutoff, gamma,
                          (double)params->period};
}

static double tolerance(const pll_params_t *params)
{
    return ROUNDING + (params->feedforward_cutoff > 0.0f ? 0.0 : 2.0 * STALL / ((double)params->ki * T));
}

static ab_t emf_at(double theta, double omega)
{
    return (ab_t){(float)(-PSI * omega * sin(theta)), (float)(PSI * omega * cos(theta))};
}

/* Runs the loop on a rotor that turns at about `speed` in `direction`. The deviations of its angle and
 * speed are in angle_in and speed_in. error_out receives the true minus the tracked angle, and omega_out
 * the deviation of the frequency, both without the sign of the direction. */
static void run(pll_t *pll, double direction, double speed, double gamma, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        double theta = direction * (speed * (double)k * T + angle_in[k]);
        ab_t emf = emf_at(theta, direction * (speed + speed_in[k]));
        position_t p = pll_step(pll, emf, (float)(gamma / PSI), 0.0f);
        TEST_ASSERT_TRUE(p.theta_e >= -3.1415927f && p.theta_e < 3.1415926f);
        error_out[k] = direction * circle(theta - (double)p.theta_e);
        omega_out[k] = direction * (double)p.omega_e - speed;
    }
}

static void start(pll_t *pll, const pll_params_t *params, double theta, double omega)
{
    pll_init(pll, params);
    pll_reset(pll, (position_t){(float)theta, (float)omega});
}

/* A loop that has settled at a constant speed, with its EMF filter. */
static void start_settled(pll_t *pll, const pll_params_t *params, double direction)
{
    start(pll, params, 0.0, direction * SPEED);
    pll_reset_emf(pll, (float)(PSI * SPEED));
}

/* The input scale t^n/n!; a step of the angle is an impulse of the speed. */
static void input(int n, double scale)
{
    for (size_t k = 0; k < COUNT; k++) {
        double t = (double)k * T;
        angle_in[k] = scale;
        speed_in[k] = n == 0 && k == 0 ? scale / T : 0.0;
        for (int m = 1; m <= n; m++) {
            speed_in[k] = m == n ? angle_in[k] : 0.0;
            angle_in[k] *= t / m;
        }
    }
}

static double largest_difference(const double *a, const double *b, size_t from, size_t to)
{
    double largest = 0.0;
    for (size_t k = from; k < to; k++) {
        largest = fmax(largest, fabs(a[k] - b[k]));
    }
    return largest;
}

static const float LOOPS[][2] = {{100.0f, 0.0f}, {100.0f, 8.0f},  {100.0f, 25.0f},
                                 {200.0f, 0.0f}, {200.0f, 50.0f}, {200.0f, 121.0f}};
#define LOOP_COUNT (sizeof LOOPS / sizeof LOOPS[0])

/* Steps of the angle, of its speed and of its acceleration, compared with the linear sampled loop. sin x
 * differs from x by x^3/6 < 1e-6 below 18 mrad. F stops STALL/(omega_c T) rad/s before its goal. This is a
 * step of the speed, which causes an angle error of at most 0.74 of itself divided by kp until the
 * integrator has compensated it. The limit of the speed is kp times the tolerance of the angle, plus this
 * remainder, plus two last digits of 400 rad/s. */
static void test_responses_are_those_of_the_polynomials(void)
{
    static const double scale[3] = {0.01, 1.0, 20.0};
    for (size_t n = 0; n < 2u * LOOP_COUNT; n++) {
        const double direction = n % 2u != 0u ? -1.0 : 1.0;
        pll_params_t params = design(LOOPS[n / 2u][0], LOOPS[n / 2u][1]);
        pll_oracle_t loop = oracle_of(&params, 1.0);
        double stop = loop.wc > 0.0 ? STALL / (loop.wc * T) : 0.0;
        double allowed = 2e-6 + tolerance(&params) + stop / loop.kp;
        for (int order = 0; order < 3; order++) {
            pll_t pll;
            input(order, scale[order]);
            start(&pll, &params, 0.0, direction * SPEED);
            run(&pll, direction, SPEED, 1.0, COUNT / 2);
            pll_oracle_sampled(&loop, angle_in, speed_in, COUNT / 2, error_expected, omega_expected);
            check_below(largest_difference(error_out, error_expected, 0, COUNT / 2), allowed,
                        "sampled, angle");
            check_below(largest_difference(omega_out, omega_expected, 0, COUNT / 2),
                        loop.kp * allowed + stop + 6e-5, "sampled, speed");

            /* The continuous loop of (19), (23). Sample and hold shift the response by up to T. In this
             * time the error changes by at most its largest slope: (kp + wc) step after the step itself,
             * or the slope of the ramp. */
            pll_oracle_continuous(&loop, order, scale[order], COUNT / 2, error_expected);
            double slope = order == 0   ? (loop.kp + loop.wc) * scale[0]
                           : order == 1 ? scale[1]
                                        : 0.1 * scale[2];
            check_below(largest_difference(error_out, error_expected, 1, COUNT / 2), slope * T + allowed,
                        "continuous");
        }
    }
}

/* The paper's claim and erratum 10. An acceleration leaves an error of a/ki in the conventional loop, none
 * with the feed-forward, and its share with a wrong speed per volt. Third coefficient of (24): an
 * acceleration that grows by j per second leaves j/(ki omega_c). Half of the remaining transient is over
 * after 0.02 s, all of it after 2 s. */
static void test_errors_in_acceleration_are_the_coefficients(void)
{
    static const struct {
        float bandwidth, cutoff;
        double gamma, direction;
        int order;
        double size;
    } cases[] = {{100.0f, 0.0f, 1.0, 1.0, 2, 80.0},   {100.0f, 0.0f, 1.0, -1.0, 2, 80.0},
                 {100.0f, 0.0f, 1.0, 1.0, 2, -80.0},  {200.0f, 0.0f, 1.0, -1.0, 2, -80.0},
                 {100.0f, 25.0f, 1.0, 1.0, 2, 80.0},  {100.0f, 25.0f, 1.0, -1.0, 2, 80.0},
                 {200.0f, 50.0f, 1.0, 1.0, 2, -80.0}, {100.0f, 25.0f, 0.9, 1.0, 2, 80.0},
                 {100.0f, 25.0f, 1.1, 1.0, 2, 80.0},  {200.0f, 50.0f, 1.2, -1.0, 2, -80.0},
                 {100.0f, 25.0f, 1.0, 1.0, 3, 80.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const double gamma = cases[n].gamma, direction = cases[n].direction, size = cases[n].size;
        pll_params_t params = design(cases[n].bandwidth, cases[n].cutoff);
        pll_oracle_t loop = oracle_of(&params, gamma);
        pll_t pll;
        input(cases[n].order, size);
        start(&pll, &params, 0.0, direction * SPEED);
        run(&pll, direction, SPEED, gamma, COUNT);
        double expected = size * pll_oracle_error_coefficient(&loop, cases[n].order);
        if (cases[n].order == 2) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, size / loop.ki * (loop.wc > 0.0 ? 1.0 - gamma : 1.0), expected);
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs(expected) + tolerance(&params), expected, error_out[COUNT - 1]);
    }
}

/* The float arithmetic of about 20 operations has a relative error of 1e-5, unless the root itself is a
 * small difference (c near 1). */
static void test_designs_have_one_crossing_at_their_bandwidth(void)
{
    static const float damping[] = {0.5f, 0.7071f, 1.0f, 2.0f, 5.0f};
    static const float cutoff[] = {0.0f, 0.01f, 0.3f, 0.6f, 0.9f, 0.99f};
    for (size_t n = 0; n < 5; n++) {
        for (size_t m = 0; m < 6; m++) {
            pll_params_t params = {.amplitude_floor = 3.0f};
            int crossings;
            TEST_ASSERT_TRUE(pll_design(&params, 150.0f, damping[n], 150.0f * cutoff[m], 1e-4f));
            pll_oracle_t loop = oracle_of(&params, 1.0);
            TEST_ASSERT_DOUBLE_WITHIN(150.0 * 2e-5, 150.0, pll_oracle_bandwidth(&loop, &crossings));
            TEST_ASSERT_EQUAL_INT(1, crossings);
            double ratio = loop.kp / (2.0 * sqrt(loop.ki));
            TEST_ASSERT_DOUBLE_WITHIN(1e-6 * ratio, (double)damping[n], ratio);
            TEST_ASSERT_EQUAL_FLOAT(3.0f, params.amplitude_floor);
        }
    }
}

static void test_impossible_designs_are_refused_and_change_nothing(void)
{
    static const float wanted[][4] = {
        {100.0f, 0.499f, 0.0f, 1e-4f}, {100.0f, 5.01f, 0.0f, 1e-4f}, {100.0f, 1.0f, 100.0f, 1e-4f},
        {100.0f, 1.0f, 101.0f, 1e-4f}, {100.0f, 1.0f, -1.0f, 1e-4f}, {0.0f, 1.0f, 0.0f, 1e-4f},
        {-9.0f, 1.0f, 0.0f, 1e-4f},    {NAN, 1.0f, 0.0f, 1e-4f},     {100.0f, NAN, 0.0f, 1e-4f},
        {100.0f, 1.0f, NAN, 1e-4f},    {100.0f, 1.0f, 0.0f, NAN},    {INFINITY, 1.0f, 0.0f, 1e-4f},
        {100.0f, 1.0f, 0.0f, 0.0f},    {100.0f, 1.0f, 0.0f, 1.1e-2f}};
    pll_params_t params = design(100.0f, 25.0f);
    pll_params_t before = params;
    for (size_t n = 0; n < sizeof wanted / sizeof wanted[0]; n++) {
        TEST_ASSERT_FALSE(pll_design(&params, wanted[n][0], wanted[n][1], wanted[n][2], wanted[n][3]));
        TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    }
    /* With damping 1 both poles are at 1 - wn T, stable for wn T < 2, and wn = bandwidth sqrt(sqrt(10) -
     * 3). */
    float edge = (float)(2.0 / T / sqrt(sqrt(10.0) - 3.0));
    TEST_ASSERT_FALSE(pll_design(&params, 1.001f * edge, 1.0f, 0.0f, 1e-4f));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
    TEST_ASSERT_TRUE(pll_design(&params, 0.99f * edge, 1.0f, 0.0f, 1e-4f));
}

static void test_check_accepts_exactly_the_stable_loops(void)
{
    int good = 0, bad = 0;
    for (int n = 1; n < 60; n++) {
        for (int m = 1; m < 60; m++) {
            pll_params_t params = {.kp = (float)(0.083 * n / T),
                                   .ki = (float)(0.077 * m / (T * T)),
                                   .feedforward_cutoff = 10.0f,
                                   .amplitude_floor = 2.0f,
                                   .period = 1e-4f};
            pll_oracle_t loop = oracle_of(&params, 1.0);
            double radius = pll_oracle_radius(&loop);
            params_error_t why;
            if (fabs(radius - 1.0) < 1e-5) {
                continue;
            }
            TEST_ASSERT_EQUAL_INT(radius < 1.0, pll_params_check(&params, &why));
            good += radius < 1.0;
            bad += radius > 1.0;
        }
    }
    TEST_ASSERT_TRUE(good > 300 && bad > 300);
}

/* One field is beyond either end of its range, or not a number, and the refusal names it; the ends are the
 * last accepted values. NAN means that another rule defines that end. emf_cutoff is 0 or faster than kp. */
static void test_check_names_the_field_that_is_out_of_range(void)
{
#define FIELD(member) #member, offsetof(pll_params_t, member)
    static const struct {
        const char *field;
        size_t at;
        float refused[2], accepted[2];
    } rows[] = {{FIELD(period), {0.9e-6f, 1.01e-2f}, {1.0e-6f, NAN}},
                {FIELD(feedforward_cutoff), {-1e-6f, 10001.0f}, {0.0f, 9999.0f}},
                {FIELD(ki), {0.0f, 4.001e8f}, {1e-3f, NAN}},
                {FIELD(kp), {0.649f, 20001.0f}, {0.650f, 20000.0f}},
                {FIELD(emf_cutoff), {160.0f, 1.01e5f}, {162.0f, 1e5f}},
                {FIELD(emf_cutoff), {-1.0f, INFINITY}, {0.0f, NAN}},
                {FIELD(amplitude_floor), {0.9e-3f, 1.01e4f}, {1.0e-3f, 1.0e4f}}};
#undef FIELD
    static const pll_params_t good = {161.0f, 6495.0f, 50.0f, 2.0f, 1e-4f, 1e5f};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const float values[] = {rows[n].refused[0], rows[n].refused[1], NAN, rows[n].accepted[0],
                                rows[n].accepted[1]};
        for (int m = 0; m < 5; m++) {
            pll_params_t params = good;
            params_error_t why;
            memcpy((char *)&params + rows[n].at, &values[m], sizeof values[m]);
            if (m > 2) {
                TEST_ASSERT_TRUE_MESSAGE(isnan(values[m]) || pll_params_check(&params, &why), rows[n].field);
                continue;
            }
            TEST_ASSERT_FALSE_MESSAGE(pll_params_check(&params, &why), rows[n].field);
            TEST_ASSERT_EQUAL_STRING(rows[n].field, why.field);
            TEST_ASSERT_TRUE(why.rule != NULL && why.min < why.max);
            TEST_ASSERT_TRUE(m == 2 ? isnan(why.value) : why.value == values[m]);
            TEST_ASSERT_TRUE(m == 2 || values[m] <= why.min || values[m] >= why.max);
        }
    }
}

/* eps = sin(theta - theta_hat) min(1, |e|/floor) in both directions of rotation; |e| is within 3e-6 and
 * the rounding of the inputs. Below 1e-15 V the square of the EMF underflows, and the amplitude is between
 * zero and this value. The detector is not affected, because it is divided by the floor. */
static void test_detector_is_the_sine_of_the_error_at_any_amplitude(void)
{
    pll_params_t params = design(200.0f, 0.0f);
    static const double amplitude[] = {1e-35, 1e-6, 0.5, 1.9999, 2.0001, 2.5, 61.0, 1e6, 9.99e14};
    for (int direction = -1; direction <= 1; direction += 2) {
        for (size_t n = 0; n < sizeof amplitude / sizeof amplitude[0]; n++) {
            for (int m = -90; m < 90; m++) {
                pll_t pll;
                double theta_hat = 0.7, theta = theta_hat + m * PI / 90.0;
                start(&pll, &params, theta_hat, direction * 400.0);
                (void)pll_step(&pll, emf_at(theta, direction * amplitude[n] / PSI), 0.0f, 0.0f);
                double expected = sin(theta - theta_hat) * fmin(1.0, amplitude[n] / 2.0);
                TEST_ASSERT_DOUBLE_WITHIN(4e-6, expected, (double)pll.detector);
                if (amplitude[n] >= 1e-6) {
                    TEST_ASSERT_DOUBLE_WITHIN(4e-6, 1.0, (double)pll.amplitude / amplitude[n]);
                } else {
                    TEST_ASSERT_TRUE(pll.amplitude >= 0.0f && pll.amplitude <= 1e-15f);
                }
            }
        }
    }
}

static void check_finite(const pll_t *pll, position_t p)
{
    TEST_ASSERT_TRUE(isfinite(p.theta_e) && isfinite(p.omega_e));
    TEST_ASSERT_TRUE(fabsf(pll->theta_e) <= 3.1415926f && isfinite(pll->detector) &&
                     isfinite(pll->amplitude));
    TEST_ASSERT_TRUE(fabsf(pll->feedforward) <= pll->tuning.speed_limit);
    TEST_ASSERT_TRUE(fabsf(pll->integral) <= 2.0f * pll->tuning.speed_limit && isfinite(pll->omega_smooth));
}

/* Without an EMF, or with one beyond 1e15 V, the angle continues with the smooth speed, which changes only
 * by the share of the torque, a T per period. The angle in period k then lags the parabola only by a T^2
 * k/2. angle_wrap and the products are accurate to 4e-7 rad per period, and the speed to half its last
 * digit, 1.5e-5 rad/s. The sum over k periods shifts the angle by at most 1.5e-5 T k^2/2. */
static void test_without_an_emf_it_coasts(void)
{
    static const ab_t beyond[] = {{NAN, 0.0f}, {0.0f, -INFINITY}, {1.001e15f, 0.0f}, {0.8e15f, -0.8e15f}};
    pll_params_t params = design(200.0f, 50.0f);
    for (int n = 0; n < 10; n++) {
        const double direction = n % 2 ? -1.0 : 1.0, a = n / 2 % 2 ? 1000.0 : 0.0;
        pll_t pll;
        input(0, 0.0);
        start(&pll, &params, 0.0, direction * SPEED);
        run(&pll, direction, SPEED, 1.0, 2000);
        const pll_t before = pll;
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.0, circle(direction * SPEED * 2000 * T - (double)pll.theta_e));
        for (int k = 0; k < 200; k++) {
            const double theta = (double)before.theta_e + (double)before.omega_smooth * k * T +
                                 direction * 0.5 * a * k * (k + 1) * T * T;
            const float share = (float)(direction * a);
            position_t p = n < 2 ? pll_coast(&pll, share) : pll_step(&pll, beyond[n % 4], 5.5f, share);
            TEST_ASSERT_DOUBLE_WITHIN(1.6e-5 * (k + 1),
                                      (double)before.omega_smooth + direction * a * (k + 1) * T,
                                      (double)p.omega_e);
            TEST_ASSERT_DOUBLE_WITHIN(4e-7 * (k + 1) + 7.5e-6 * k * k * T, 0.0,
                                      circle(theta - (double)p.theta_e));
            /* The loop has not used the error, which is shown as zero. */
            TEST_ASSERT_EQUAL_FLOAT(0.0f, pll.detector);
        }
        TEST_ASSERT_TRUE(before.integral == pll.integral);
        TEST_ASSERT_EQUAL_FLOAT(pll.integral + pll.feedforward, pll.omega_smooth);
        if (n >= 2) {
            TEST_ASSERT_EQUAL_FLOAT(0.0f, pll.amplitude);
        }
    }
}

/* A step of 10 mrad. In the linear loop the filter is between the detector and the loop filter, y = c y +
 * (1 - c) e. At kp, the smallest accepted cutoff, it is still damped: the response has decayed after ten
 * time constants. The limit for sin x is that of the test without the filter. */
static void test_emf_filter_is_in_front_of_the_loop(void)
{
    static const double times_kp[] = {1.0, 20.0};
    for (int n = 0; n < 4; n++) {
        pll_params_t params = design(200.0f, n < 2 ? 0.0f : 50.0f);
        const double kp = (double)params.kp, ki = (double)params.ki;
        params.emf_cutoff = (float)(1.00001 * times_kp[n % 2] * kp);
        const double c = exp(-(double)params.emf_cutoff * T);
        pll_t pll;
        input(0, 0.01);
        speed_in[0] = 0.0; /* the amplitude does not depend on the step */
        start_settled(&pll, &params, 1.0);
        run(&pll, 1.0, SPEED, 1.0, 3000);
        double theta = 0.0, integral = 0.0, y = 0.0, feedforward = 0.0;
        const double share = n < 2 ? 0.0 : 1.0 - exp(-50.0 * T);
        double largest = 0.0;
        for (size_t k = 0; k < 3000; k++) {
            y = c * y + (1.0 - c) * (angle_in[k] - theta);
            feedforward -= share * feedforward;
            largest = fmax(largest, fabs(error_out[k] - (angle_in[k] - theta)));
            theta += T * (integral + kp * y + feedforward);
            integral += ki * T * y;
        }
        check_below(largest, 2e-6 + tolerance(&params), "filtered step");
        check_below(fabs(error_out[2999]), 2e-6 + tolerance(&params), "settled");
    }
}

/* While the loop only observes, it does not correct an error of 0.1 rad, but the filter receives it: after
 * m periods the filter contains 1 - c^m of it. */
static void test_watching_fills_the_filter_and_coasts(void)
{
    pll_params_t params = design(200.0f, 0.0f);
    const double c = exp(-0.1);
    params.emf_cutoff = 1000.0f;
    for (int m = 0; m < 20; m += 3) {
        pll_t pll;
        start_settled(&pll, &params, 1.0);
        for (int k = 0; k < 50; k++) {
            (void)pll_step(&pll, emf_at(SPEED * k * T, SPEED), 0.0f, 0.0f);
        }
        const float smooth = pll.omega_smooth;
        for (int k = 0; k < m; k++) {
            position_t p = pll_watch(&pll, emf_at((double)pll.theta_e + 0.1, SPEED), 0.0f);
            TEST_ASSERT_EQUAL_FLOAT(smooth, p.omega_e);
            TEST_ASSERT_EQUAL_FLOAT(0.0f, pll.detector);
        }
        TEST_ASSERT_EQUAL_FLOAT(smooth, pll.omega_smooth);
        if (m == 6) { /* an input that is no EMF does not enter the filter */
            (void)pll_watch(&pll, (ab_t){NAN, 1.0f}, 0.0f);
            (void)pll_watch(&pll, (ab_t){0.0f, INFINITY}, 0.0f);
        }
        (void)pll_step(&pll, emf_at((double)pll.theta_e + 0.1, SPEED), 0.0f, 0.0f);
        const double known = 1.0 - pow(c, m + 1.0);
        const double sine = sin(0.1) * known, cosine = 1.0 - (1.0 - cos(0.1)) * known;
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, sine / hypot(sine, cosine), (double)pll.detector);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, hypot(sine, cosine), (double)pll.amplitude / (PSI * SPEED));
    }
}

/* After a reset the filter starts from zero or from a given settled value, in either direction. The
 * direction of the EMF is right at once. */
static void test_filter_starts_empty_or_settled(void)
{
    pll_params_t params = design(200.0f, 50.0f);
    params.emf_cutoff = 1000.0f;
    for (int n = 0; n < 4; n++) {
        const double direction = n % 2 ? -1.0 : 1.0;
        pll_t pll;
        start(&pll, &params, 0.0, SPEED);
        for (int k = 0; k < 50; k++) {
            (void)pll_step(&pll, emf_at(SPEED * k * T, SPEED), 5.5f, 0.0f);
        }
        pll_reset(&pll, (position_t){2.0f, (float)(direction * 100.0)});
        if (n >= 2) {
            pll_reset_emf(&pll, (float)(PSI * 100.0));
        }
        (void)pll_step(&pll, emf_at(2.0, direction * 100.0), (float)(1.0 / PSI), 0.0f);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, (double)pll.detector);
        TEST_ASSERT_DOUBLE_WITHIN(4e-6, n >= 2 ? 1.0 : 1.0 - exp(-0.1),
                                  (double)pll.amplitude / (PSI * 100.0));
    }
}

/* F starts at the speed that the EMF shows with a wrong psi_f, and I at the rest of the speed: the loop
 * remains locked. It would lose the rotor if F started at the whole speed. */
static void test_lock_with_a_wrong_psi_f_stays_locked(void)
{
    static const double gammas[] = {1.0 / 0.75, 1.0 / 1.25};
    pll_params_t params = design(200.0f, 50.0f);
    params.emf_cutoff = 1000.0f;
    for (int n = 0; n < 4; n++) {
        const double direction = n % 2 ? -1.0 : 1.0, gamma = gammas[n / 2];
        const float speed_per_volt = (float)(gamma / PSI);
        for (int whole = 0; whole < 2; whole++) {
            pll_t pll;
            start_settled(&pll, &params, direction);
            if (whole == 0) {
                pll_reset_feedforward(&pll, speed_per_volt);
                TEST_ASSERT_DOUBLE_WITHIN(1e-5 * SPEED, gamma * direction * SPEED, (double)pll.feedforward);
                TEST_ASSERT_DOUBLE_WITHIN(1e-5 * SPEED, (1.0 - gamma) * direction * SPEED,
                                          (double)pll.integral);
            }
            double largest = 0.0;
            for (int k = 0; k < 1000; k++) {
                const double theta = direction * SPEED * k * T;
                const position_t p = pll_step(&pll, emf_at(theta, direction * SPEED), speed_per_volt, 0.0f);
                largest = fmax(largest, fabs(circle(theta - (double)p.theta_e)));
            }
            TEST_ASSERT_EQUAL(whole == 0, largest < 1e-4);
            TEST_ASSERT_EQUAL(whole == 1, largest > 0.2);
        }
    }
}

/* A loop without a feed-forward has no F to which a part of the speed could go; a speed beyond the limit
 * is limited as in a reset. */
static void test_split_of_the_speed_keeps_to_the_loop(void)
{
    for (int n = 0; n < 2; n++) {
        const pll_params_t params = design(200.0f, n == 0 ? 0.0f : 50.0f);
        pll_t pll;
        start(&pll, &params, 0.0, SPEED);
        pll_reset_emf(&pll, n == 0 ? 10.0f : 1e9f);
        pll_reset_feedforward(&pll, 5.0f);
        TEST_ASSERT_EQUAL_FLOAT(n == 0 ? 0.0f : PLL_TURN_LIMIT / (float)T, pll.feedforward);
        TEST_ASSERT_EQUAL_FLOAT((float)SPEED, pll.integral + pll.feedforward);
    }
}

static void test_coasting_keeps_its_limits(void)
{
    static const float bad[] = {3e8f, -3e8f, INFINITY, NAN};
    pll_params_t params = design(200.0f, 50.0f);
    for (int n = 0; n < 4; n++) {
        pll_t pll;
        start(&pll, &params, 0.3, SPEED);
        position_t p = pll_coast(&pll, bad[n]);
        check_finite(&pll, p);
        TEST_ASSERT_EQUAL_FLOAT((float)SPEED, pll.omega_smooth);
    }
}

/* With an angle error of 0.5 rad e_q = |e| cos 0.5, which shows whether e_q or |e| has been used. */
static void test_feedforward_takes_the_signed_emf_below_its_speed(void)
{
    static const double speed[] = {30.0, 79.9, 80.0, 80.1, -79.9, -80.0, -80.1};
    pll_params_t params = design(200.0f, 50.0f);
    double share = 1.0 - exp(-50.0 * T);
    for (size_t n = 0; n < sizeof speed / sizeof speed[0]; n++) {
        pll_t pll;
        start(&pll, &params, 1.0, speed[n]);
        (void)pll_step(&pll, emf_at(1.5, speed[n]), (float)(1.0 / PSI), 100.0f);
        double taken = fabs(speed[n]) < 79.95 ? cos(0.5) : 1.0;
        double expected = speed[n] + share * (taken - 1.0) * speed[n] + 100.0 * T;
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, expected, (double)pll.feedforward);
    }
}

static void test_sign_is_soft_around_zero_speed_and_hard_after_a_reset(void)
{
    static const double speed[] = {-25.0, -20.1, -20.0, -19.0, -5.0, -1.0, 0.0,
                                   1.0,   5.0,   19.0,  20.0,  20.1, 25.0};
    pll_params_t params = design(200.0f, 0.0f);
    const ab_t emf = {-10.0f, 0.0f};
    for (size_t n = 0; n < sizeof speed / sizeof speed[0]; n++) {
        pll_t pll;
        start(&pll, &params, 0.0, speed[n]);
        (void)pll_step(&pll, emf, 0.0f, 0.0f);
        TEST_ASSERT_EQUAL_FLOAT(speed[n] < 0.0 ? -1.0f : 1.0f, pll.detector);
        start(&pll, &params, 0.0, 30.0);
        pll.omega_smooth = (float)speed[n];
        (void)pll_step(&pll, emf, 0.0f, 0.0f);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, fmax(-1.0, fmin(1.0, speed[n] / 20.0)), (double)pll.detector);
    }
}

/* An angle error or an acceleration that persists without end takes the loop to its limits, from which it
 * must return. An I that would exceed 25000 rad/s keeps its value, and so does an F that would exceed
 * 12500 rad/s, after 41 steps of 300 rad/s. */
static void test_limits_hold(void)
{
    pll_params_t params = design(200.0f, 0.0f);
    pll_t pll;
    start(&pll, &params, 0.0, SPEED);
    for (int k = 0; k < 100000; k++) {
        ab_t emf = emf_at((double)pll.theta_e + 1.5, 300.0);
        position_t p = pll_step(&pll, emf, 0.0f, 3e6f);
        check_finite(&pll, p);
    }
    TEST_ASSERT_TRUE(fabsf(pll.integral) <= 25000.0f && fabsf(pll.integral) > 25000.0f - params.ki * 1e-4f);
    TEST_ASSERT_EQUAL_FLOAT(12300.0f, pll.feedforward);
    for (int k = 1; k <= 133; k++) {
        (void)pll_step(&pll, (ab_t){0.0f, 0.0f}, 0.0f, -3e6f);
        TEST_ASSERT_EQUAL_FLOAT(fmaxf(12300.0f - 300.0f * (float)k, -12300.0f), pll.feedforward);
    }
    pll_reset(&pll, (position_t){7.0f, 1e9f});
    TEST_ASSERT_EQUAL_FLOAT(12500.0f, pll.integral);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 7.0 - 2.0 * PI, (double)pll.theta_e);
}
