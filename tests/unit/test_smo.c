/* The observer is fed with exact data of a turning machine (oracle) in open loop. The error of float:
 * current_hat of up to 15 A is rounded by 1e-6 A, which b^-1 = 125 V/A turns into 1e-4 V. On an EMF of at
 * least 7.7 V this is at worst 0.02 mrad in a mean. */
#include "estimator/smo.h"
#include "tests/oracle/smo_oracle.h"
#include "tests/unit/machines.h"

#define FLOAT_MRAD 0.03

static smo_t smo;

static smo_params_t with(smo_switching_t switching, float gain, float emf_cutoff)
{
    smo_params_t params = PAPER;
    params.switching = switching;
    params.gain = gain;
    params.emf_cutoff = emf_cutoff;
    return params;
}

static smo_oracle_case_t paper_case(double rpm, double current_q)
{
    smo_oracle_case_t rig = {0.95, 0.0125, 0.183, 1e-4, rpm * RAD_PER_RPM, 0.3, current_q};
    return rig;
}

typedef struct {
    double mean, sd; /* [mrad] */
} deviation_t;

static deviation_t deviation(const smo_params_t *params, const smo_oracle_case_t *rig)
{
    long settle = 3000;
    long count = 6000; /* number of samples: whole revolutions at 100, 500, 1000 and 1500 r/min */
    double sum = 0.0;
    double squares = 0.0;
    smo_init(&smo, params);
    for (long k = 1; k <= settle + count; k++) {
        smo_oracle_sample_t now;
        smo_oracle_sample(rig, k, &now);
        ab_t emf = smo_step(&smo, as_float(now.voltage), as_float(now.current));
        if (k > settle) {
            double a = (double)emf.alpha;
            double b = (double)emf.beta;
            double angle = 1e3 * atan2(b * now.emf[0] - a * now.emf[1], a * now.emf[0] + b * now.emf[1]);
            sum += angle;
            squares += angle * angle;
        }
    }
    deviation_t result = {sum / (double)count, 0.0};
    result.sd = sqrt(squares / (double)count - result.mean * result.mean);
    return result;
}

void setUp(void)
{
    smo_init(&smo, &PAPER);
}

static void test_runs_as_the_same_observer_in_double_precision(void)
{
    static const float cutoffs[] = {0.0f, 2000.0f};
    for (int n = 0; n < 2; n++) {
        for (double rpm = -1500.0; rpm <= 1500.0; rpm += 1000.0) {
            smo_oracle_case_t rig = paper_case(rpm, 6.0);
            smo_oracle_observer_t observer = {200.0, 1.0, (double)cutoffs[n]};
            smo_oracle_run_t axis = smo_oracle_run(&rig, &observer, SMO_ORACLE_SIGMOID, 3000, 6000);
            smo_oracle_run_t both = smo_oracle_run(&rig, &observer, SMO_ORACLE_VECTOR, 3000, 6000);
            smo_params_t params = with(SMO_SIGMOID, 200.0f, cutoffs[n]);
            deviation_t found = deviation(&params, &rig);
            TEST_ASSERT_DOUBLE_WITHIN(FLOAT_MRAD, 1e3 * axis.mean, found.mean);
            TEST_ASSERT_DOUBLE_WITHIN(FLOAT_MRAD, 1e3 * axis.sd, found.sd);
            /* The mean gain has a ripple of the sixth harmonic of the speed, behind a low-pass of 100
             * rad/s: below 1 %. */
            TEST_ASSERT_DOUBLE_WITHIN(0.01 * axis.product / axis.square, axis.product / axis.square,
                                      (double)smo_equivalent_gain(&smo));
            params.switching = SMO_SIGMOID_VECTOR;
            TEST_ASSERT_DOUBLE_WITHIN(FLOAT_MRAD, 1e3 * both.mean, deviation(&params, &rig).mean);
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, both.product / both.square, (double)smo_equivalent_gain(&smo));
        }
    }
}

/* Two steps from zero, calculated by hand: i_hat = b (u - v), v = k_s tanh(x/2), and the filtered e_hat. */
static void test_two_steps_by_hand(void)
{
    double b = -expm1(-0.95 * 1e-4 / 0.0125) / 0.95;
    double a = exp(-0.95 * 1e-4 / 0.0125);
    double c = exp(-0.2);
    smo_params_t params = with(SMO_SIGMOID, 200.0f, 2000.0f);
    smo_init(&smo, &params);

    double x1 = b * 50.0 - 0.1;
    double y1 = b * -30.0 + 0.3;
    ab_t first = smo_step(&smo, (ab_t){50.0f, -30.0f}, (ab_t){0.1f, -0.3f});
    double v1 = 200.0 * tanh(x1 / 2.0);
    double w1 = 200.0 * tanh(y1 / 2.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, (1.0 - c) * v1, (double)first.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, (1.0 - c) * w1, (double)first.beta);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, tanh(x1 / 2.0) / x1, (double)smo.axes.gain_axis.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, tanh(y1 / 2.0) / y1, (double)smo.axes.gain_axis.beta);

    double x2 = a * (x1 + 0.1) + b * (20.0 - v1) - 0.4;
    double y2 = a * (y1 - 0.3) + b * (10.0 - w1) + 0.2;
    ab_t second = smo_step(&smo, (ab_t){20.0f, 10.0f}, (ab_t){0.4f, -0.2f});
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, c * (1.0 - c) * v1 + (1.0 - c) * 200.0 * tanh(x2 / 2.0),
                              (double)second.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, c * (1.0 - c) * w1 + (1.0 - c) * 200.0 * tanh(y2 / 2.0),
                              (double)second.beta);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, x2, (double)smo.current_err.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, y2, (double)smo.current_err.beta);
}

static void test_gain_of_the_sign_is_capped(void)
{
    smo_params_t params = with(SMO_SIGN, 200.0f, 0.0f);
    smo_init(&smo, &params);
    ab_t emf = smo_step(&smo, (ab_t){0.0f, 0.0f}, (ab_t){0.0005f, -0.25f});
    TEST_ASSERT_TRUE(emf.alpha == -200.0f && emf.beta == 200.0f);
    TEST_ASSERT_TRUE(smo.axes.gain_axis.alpha == SMO_SIGN_GAIN_MAX);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 4.0, (double)smo.axes.gain_axis.beta);
    /* The expected value is <f x>/<x x> = 0.2505/(0.0625 + 2.5e-7). */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.2505 / 0.06250025, (double)smo_equivalent_gain(&smo));
}

static void test_reset_is_settled(void)
{
    ab_t current = {-7.0f, 3.0f};
    ab_t emf = {60.0f, -97.0f};
    for (int s = SMO_SIGMOID; s <= SMO_SIGMOID_VECTOR; s++) {
        smo_params_t params = with((smo_switching_t)s, 200.0f, 2000.0f);
        smo_init(&smo, &params);
        smo_reset(&smo, current, emf);
        ab_t hat = smo.current_hat;
        ab_t voltage = {0.95f * hat.alpha + emf.alpha, 0.95f * hat.beta + emf.beta};
        /* tanh and its inverse have a relative error of 1e-6 each: 2e-4 V. The gain does not change
         * either. */
        float gain = smo_equivalent_gain(&smo);
        for (int n = 0; n < 50; n++) {
            ab_t result = smo_step(&smo, voltage, current);
            TEST_ASSERT_FLOAT_WITHIN(5e-4f, emf.alpha, result.alpha);
            TEST_ASSERT_FLOAT_WITHIN(5e-4f, emf.beta, result.beta);
            TEST_ASSERT_FLOAT_WITHIN(1e-5f, gain, smo_equivalent_gain(&smo));
        }
    }
    /* The values of tanh(x/2) are 0.3 and -0.485 on the axes. */
    smo_init(&smo, &PAPER);
    smo_reset(&smo, current, emf);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.0 * atanh(0.3), (double)smo.current_err.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.0 * atanh(-0.485), (double)smo.current_err.beta);
}

static void test_reset_inverts_up_to_99_percent_and_stays_bounded_beyond(void)
{
    smo_reset(&smo, (ab_t){0.0f, 0.0f}, (ab_t){197.8f, 0.0f});
    /* Near its limit the inverse is steep: an error of 1e-6 in tanh is 1e-6/(1 - 0.98) in its argument. */
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, 2.0 * atanh(0.989), (double)smo.current_err.alpha);
    smo_reset(&smo, (ab_t){0.0f, 0.0f}, (ab_t){1000.0f, -1000.0f});
    TEST_ASSERT_TRUE(smo.emf_hat.alpha > 190.0f && smo.emf_hat.alpha < 200.001f);
    TEST_ASSERT_TRUE(smo.emf_hat.beta == -smo.emf_hat.alpha);
    TEST_ASSERT_TRUE(smo.current_hat.alpha > 5.0f && smo.current_hat.beta < -5.0f);
}

static void test_reset_of_the_sign_continues_the_emf(void)
{
    smo_params_t params = with(SMO_SIGN, 200.0f, 2000.0f);
    smo_init(&smo, &params);
    smo_reset(&smo, (ab_t){1.0f, 0.0f}, (ab_t){60.0f, -20.0f});
    TEST_ASSERT_TRUE(smo.emf_hat.alpha == 60.0f && smo.emf_hat.beta == -20.0f);
    TEST_ASSERT_TRUE(smo.current_err.alpha == 0.0f && smo.current_hat.alpha == 1.0f);
}

static void test_bad_sample_is_rejected(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1e38f};
    for (int s = SMO_SIGN; s <= SMO_SIGMOID_VECTOR; s++) {
        for (int n = 0; n < 16; n++) {
            smo_params_t params = with((smo_switching_t)s, 200.0f, 2000.0f);
            smo_init(&smo, &params);
            smo_reset(&smo, (ab_t){2.0f, 1.0f}, (ab_t){50.0f, 20.0f});
            const smo_t before = smo;
            ab_t voltage = {1.0f, 2.0f};
            ab_t current = {2.0f, 1.0f};
            float *slots[] = {&voltage.alpha, &voltage.beta, &current.alpha, &current.beta};
            *slots[n / 4] = bad[n % 4];
            ab_t emf = smo_step(&smo, voltage, current);
            TEST_ASSERT_TRUE(emf.alpha == before.emf_hat.alpha && emf.beta == before.emf_hat.beta);
            TEST_ASSERT_EQUAL_MEMORY(&before, &smo, sizeof smo);
        }
    }
    /* From the zero state the error is minus the current; it may be as long as SMO_ERROR_LIMIT, 1e6 A. */
    const ab_t none = {0.0f, 0.0f};
    float error_square;
    smo_init(&smo, &PAPER);
    TEST_ASSERT_TRUE(smo_predict(&smo, none, (ab_t){6e5f, -8e5f}, &error_square));
    smo_init(&smo, &PAPER);
    TEST_ASSERT_FALSE(smo_predict(&smo, none, (ab_t){6.001e5f, -8e5f}, &error_square));
}

static void test_params_check_names_field_value_and_range(void)
{
    static const struct {
        size_t offset;
        const char *field;
        float min, max;
    } rows[] = {{offsetof(smo_params_t, resistance), "resistance", 1e-3f, 100.0f},
                {offsetof(smo_params_t, inductance), "inductance", 1e-6f, 1.0f},
                {offsetof(smo_params_t, gain), "gain", 0.1f, 1e4f},
                {offsetof(smo_params_t, slope), "slope", 1e-3f, 1e3f},
                {offsetof(smo_params_t, emf_cutoff), "emf_cutoff", 0.0f, 1e5f},
                {offsetof(smo_params_t, period), "period", 1e-6f, 1e-2f}};
    params_error_t why;
    TEST_ASSERT_TRUE(smo_params_check(&PAPER, &why));
    for (unsigned n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const float bad[] = {nextafterf(rows[n].min, -1.0f), nextafterf(rows[n].max, INFINITY), NAN};
        for (int m = 0; m < 3; m++) {
            smo_params_t params = PAPER;
            memcpy((char *)&params + rows[n].offset, &bad[m], sizeof bad[m]);
            TEST_ASSERT_FALSE(smo_params_check(&params, &why));
            TEST_ASSERT_EQUAL_STRING(rows[n].field, why.field);
            TEST_ASSERT_TRUE(m == 2 ? isnan(why.value) : why.value == bad[m]);
            TEST_ASSERT_TRUE(why.min == rows[n].min && why.max == rows[n].max);
        }
        /* At its limits this rule holds; at most a later rule between fields refuses. */
        for (int m = 0; m < 2; m++) {
            smo_params_t params = PAPER;
            float limit = m == 0 ? rows[n].min : rows[n].max;
            memcpy((char *)&params + rows[n].offset, &limit, sizeof limit);
            TEST_ASSERT_TRUE(smo_params_check(&params, &why) ||
                             strcmp(why.rule, "range of the parameter") != 0);
        }
    }
    smo_params_t params = PAPER;
    params.switching = (smo_switching_t)3;
    TEST_ASSERT_FALSE(smo_params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("switching", why.field);
}

static void test_params_check_refuses_too_much_loop_gain(void)
{
    params_error_t why;
    double b = -expm1(-0.95 * 1e-4 / 0.0125) / 0.95;
    float largest = (float)(1.2 / (b * 0.5)); /* the limit is 301.1 V */
    smo_params_t params = with(SMO_SIGMOID_VECTOR, largest * 0.99999f, 0.0f);
    TEST_ASSERT_TRUE(smo_params_check(&params, &why));
    params.gain = largest * 1.00001f;
    TEST_ASSERT_FALSE(smo_params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("gain", why.field);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * largest, largest, why.max);
    params.gain = why.max;
    TEST_ASSERT_TRUE(smo_params_check(&params, &why));
    params.gain = 2.0f * largest;
    params.switching = SMO_SIGN; /* without a slope this limit does not exist */
    TEST_ASSERT_TRUE(smo_params_check(&params, &why));
}
