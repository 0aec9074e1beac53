/* The forced frame and its damping. gamma is the load angle, by which the d axis of the frame is ahead of the
 * rotor's:
 *
 *     torque = K_t (I sin gamma + i_q cos gamma), e_q = omega psi_f cos gamma, e_d = omega psi_f sin gamma
 *
 * so that small swings obey s^2 + (K_t k psi_f p/J) H(s) s + w_n^2 = 0, where H is the high-pass and
 * low-pass of e_q. */
#include "fast/reference/forced.h"
#include "tests/unit/vectors.h"

#define T           1e-4
#define R           0.95
#define L           0.0125
#define PSI         0.183
#define POLE_PAIRS  4.0
#define CURRENT     8.0
#define CURRENT_MAX 10.0
#define KT          (1.5 * POLE_PAIRS * PSI)

static forced_t forced;
static forced_tuning_t tuning;
static forced_params_t params;

static void begin(double inertia, double dead_voltage, double damping)
{
    params = (forced_params_t){
        .resistance = (float)R,
        .inductance = (float)L,
        .inductance_least = (float)L,
        .flux_linkage = (float)PSI,
        .pole_pairs = (float)POLE_PAIRS,
        .inertia = (float)inertia,
        .dead_voltage = (float)dead_voltage,
        .current = (float)CURRENT,
        .current_max = (float)CURRENT_MAX,
        .damping = (float)damping,
        .period = (float)T,
    };
    tuning = forced_prepare(&params);
    memset(&forced, 0x55, sizeof forced);
    forced_init(&forced);
}

void setUp(void)
{
    begin(0.003, 10.0, 0.0);
    forced_enter(&forced, 0.0f, 0.0f, (float)CURRENT);
}

static double natural(double inertia)
{
    return sqrt(POLE_PAIRS * KT * CURRENT / inertia);
}

/* The damping is half of the critical one with a light rotor; with a heavy rotor errors of the observer
 * limit it. */
static void test_damping_by_the_rule(void)
{
    static const double inertias[] = {1e-4, 0.003, 0.0636, 1.0};
    for (int n = 0; n < 4; n++) {
        for (double dead_voltage = 0.0; dead_voltage < 20.0; dead_voltage += 9.0) {
            begin(inertias[n], dead_voltage, 0.0);
            const double w = natural(inertias[n]);
            const double wanted = w * inertias[n] / (POLE_PAIRS * KT * PSI);
            const double most = 0.5 / (0.3 * R + 0.25 * dead_voltage / CURRENT);
            const double expected = fmin(wanted, most);
            TEST_ASSERT_DOUBLE_WITHIN(1e-5 * w, w, (double)forced_natural(&params));
            TEST_ASSERT_DOUBLE_WITHIN(2e-5 * expected, expected, (double)forced_damping(&params));
            TEST_ASSERT_DOUBLE_WITHIN(2e-5 * expected, expected, (double)tuning.damping);
            const double share = 1.0 - exp(-T * fmin(2.5 / (expected * L), 1.0 / T));
            TEST_ASSERT_DOUBLE_WITHIN(1e-4 * share, share, (double)tuning.damping_share);
        }
    }
    begin(0.003, 10.0, 0.0);
    TEST_ASSERT_TRUE(tuning.damping < 0.5f); /* limited by w_n */
    begin(0.0636, 10.0, 0.0);
    TEST_ASSERT_TRUE(tuning.damping < 0.9f); /* limited by R and the dead time */
}

/* The transfer function of y += share (x - y) if a sample acts at once: share/(1 - (1 - share)/z). */
static double complex lowpass_of(double cutoff, double complex z)
{
    const double share = 1.0 - exp(-cutoff * T);
    return share / (1.0 - (1.0 - share) / z);
}

/* High-pass and low-pass shift the phase by less than a quarter of a turn each: the high-pass has 6 rad/s,
 * the low-pass 2.5/(k L). */
static void test_damping_takes_energy_out_of_every_swing_from_slow_to_fast(void)
{
    const double k = (double)tuning.damping;
    for (double rate = 3.0; rate < 2000.0; rate *= 1.5) {
        const int turn = (int)(2.0 * PI / (rate * T) + 0.5);
        const double step = 2.0 * PI / turn;
        const double complex z = cexp(J * step);
        const double complex share = (1.0 - lowpass_of(6.0, z)) * lowpass_of(2.5 / (k * L), z);
        double work = 0.0;
        forced_enter(&forced, 0.0f, 0.0f, (float)CURRENT);
        for (int n = 0; n < turn * (2 + (int)rate); n++) {
            const double swing = 0.5 * sin(step * n);
            const double across = (double)forced_step(&forced, &tuning, (dq_t){0.0f, (float)swing}).q;
            work += n >= turn * (1 + (int)rate) ? across * swing / turn : 0.0;
        }
        const double expected = -0.5 * 0.25 * k * creal(share);
        TEST_ASSERT_TRUE(work < 0.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * fabs(expected) + 1e-6, expected, work);
    }
}

/* The share of the EMF that is fed forward is 0.8, unless the gain of the loop through a current along d,
 * share D/L_d, would exceed 0.8: it is 0.8 up to L_q = 2 L_d, and smaller above. The same limit applies to
 * a winding whose incremental inductance L_i differs from the observer's L_o = L_d: the observed EMF
 * contains u (1 - L_o/L_i), and the share is 0.8 down to L_i = L_o/2. */
static void test_feed_forward_of_the_emf_is_a_loop_below_one_for_any_saliency(void)
{
    TEST_ASSERT_EQUAL_FLOAT(0.8f, tuning.emf_share);
    for (double ratio = 1.1; ratio < 9.0; ratio *= 1.1) {
        params.saliency = (float)(L - L / ratio);
        tuning = forced_prepare(&params);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, fmin(0.8 * (ratio - 1.0), 0.8),
                                  (double)tuning.emf_share * (ratio - 1.0));
        params.saliency = (float)(L - L / 2.0);
        params.inductance_least = (float)(L / 2.0 / ratio);
        tuning = forced_prepare(&params);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, fmin(0.8 * (ratio - 1.0), 0.8),
                                  (double)tuning.emf_share * (ratio - 1.0));
        params.inductance_least = (float)L;
    }
}

/* exp(-6 t) of a constant e_q is left after the high-pass; the low-pass follows. */
static void test_what_turns_along_is_no_swing(void)
{
    const double k = (double)tuning.damping;
    for (int n = 1; n <= 15000; n++) {
        const double across = (double)forced_step(&forced, &tuning, (dq_t){3.0f, 9.0f}).q;
        if (n > 500) {
            const double left = exp(-6.0 * T * n) / (1.0 - 6.0 * k * L / 2.5);
            TEST_ASSERT_DOUBLE_WITHIN(0.01 * k, -k * 9.0 * left, across);
        }
    }
}

/* The damping has priority within the current of a start; the d axis gets the rest of the vector. */
static void test_current_stays_within_the_longest_vector(void)
{
    for (double swing = -100.0; swing <= 100.0; swing += 5.0) {
        forced_enter(&forced, 0.0f, 0.0f, (float)CURRENT);
        dq_t current = {0.0f, 0.0f};
        for (int n = 0; n < 200; n++) {
            current = forced_step(&forced, &tuning, (dq_t){0.0f, (float)swing});
            TEST_ASSERT_TRUE(fabsf(current.q) <= (float)CURRENT);
            TEST_ASSERT_TRUE(hypot((double)current.d, (double)current.q) <= CURRENT_MAX * 1.000001);
        }
        const double left = sqrt(CURRENT_MAX * CURRENT_MAX - (double)current.q * (double)current.q);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, fmin(CURRENT, left), (double)current.d);
        if (fabs(swing) > 40.0) {
            TEST_ASSERT_EQUAL_FLOAT(swing > 0.0 ? -8.0f : 8.0f, current.q);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 6.0, (double)current.d);
        }
    }
}

static void test_frame_turns_on_by_its_speed(void)
{
    static const float speeds[] = {0.0f, 50.0f, -50.0f, 5000.0f};
    for (int n = 0; n < 4; n++) {
        forced_enter(&forced, 3.0f, speeds[n], 1.0f);
        for (int k = 1; k <= 1000; k++) {
            forced_advance(&forced, &tuning);
            const double theta = 3.0 + T * k * (double)speeds[n];
            const frame_t *frame = &forced.frame;
            TEST_ASSERT_TRUE(frame->theta_e >= -3.1415928f && frame->theta_e < 3.1415928f);
            TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.0, circle((double)frame->theta_e - theta));
            TEST_ASSERT_DOUBLE_WITHIN(2.5e-6, sin((double)frame->theta_e), (double)frame->rotation.sin);
            TEST_ASSERT_DOUBLE_WITHIN(2.5e-6, cos((double)frame->theta_e), (double)frame->rotation.cos);
        }
    }
}

/* The speed changes by the ramp while that is less than 12 rad/s times the rest, and exponentially from
 * there on. */
static void test_speed_goes_to_its_target_by_the_ramp_and_gently_at_the_end(void)
{
    for (int way = -1; way <= 1; way += 2) {
        const double step = 0.05;
        const double share = 1.0 - exp(-12.0 * T);
        double expected = way * -5.0;
        float speed = (float)expected;
        for (int n = 0; n < 20000; n++) {
            const double wanted = share * (way * 100.0 - expected);
            expected += fmax(-step, fmin(step, wanted));
            speed = forced_eased(speed, (float)(way * 100.0), (float)share, (float)step);
            TEST_ASSERT_DOUBLE_WITHIN(5e-3, expected, (double)speed);
            TEST_ASSERT_TRUE((double)way * (double)speed <= 100.0);
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.01, way * 100.0, (double)speed);
    }
}
