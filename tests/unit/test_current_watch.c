/* The watch over current sensors and phases, fed with a winding in double precision: alpha and beta by L
 * di = T (u - R i), at standstill. The expected times and limits are calculated by hand from the
 * coefficients. */
#include "medium/protect/current_watch.h"

#include "math/trig.h"

#include "tests/unit/compare.h"

#define PERIOD     1e-4
#define RESISTANCE 0.95
#define INDUCTANCE 12.5e-3
#define LINK       300.0

static current_watch_t watch;
static double i_alpha, i_beta;      /* [A] true currents */
static double gain_a, gain_b, in_c; /* [-] gains of sensors a and b; [A] added by the sensor of c */
static ab_t error;                  /* [A] current error of the observer */
static uint32_t ticks;              /* [periods] counter */
static uint32_t seen;               /* [-] bits that the watch has reported so far */
static uint32_t periods;            /* [periods] until the first bit */
static double per_ampere;           /* [rad/s^2 per A] acceleration of the rotor */
static double salience;             /* [-] L_q/L_d; the assumed inductance is the mean of both */
static bool forced;                 /* a forced frame moves the rotor */
static bool contradicted;           /* the EMF along the axis of a phase is wrong */
static bool elsewhere;              /* the EMF is wrong, but along the axis of no phase */
static double saturated;            /* [-] smallest incremental L over that of both axes */
static float doubt;                 /* [rad/s] uncertainty of the rotor's speed */
static float omega_e;               /* [rad/s] speed of the rotor */
static rotation_t rotor;            /* its angle */
static float scatter;               /* [A^2] mean square of the sensors' noise in the calibration */

/* The present window, as the fast task sums it. */
#define WINDOW 8u
static struct {
    uint32_t periods, moved;
    ab_t voltage;
    dq_t asked_for;
    abc_t before; /* currents at the end of the window before */
} sum;
static float u_dc;   /* [V] */
static bool limited; /* the control has not got the voltage that it requested */

static void prepare(bool three, double l_assumed, double r_assumed)
{
    const current_watch_params_t params = {
        .resistance = (float)(RESISTANCE * r_assumed),
        .inductance_d = (float)(INDUCTANCE * l_assumed * 2.0 / (1.0 + salience)),
        .inductance_q = (float)(INDUCTANCE * l_assumed * 2.0 * salience / (1.0 + salience)),
        .least = (float)(saturated * INDUCTANCE * l_assumed * 2.0 * fmin(1.0, salience) / (1.0 + salience)),
        .flux_linkage = 0.183f,
        .per_ampere = (float)per_ampere,
        .dead_time = 2.5e-6f,
        .drop = 0.9f,
        .range = 20.0f,
        .three_sensors = three,
        .period = (float)PERIOD,
    };
    const current_watch_tuning_t tuning = current_watch_prepare(&params);
    current_watch_init(&watch, &tuning);
    i_alpha = i_beta = in_c = 0.0;
    error = (ab_t){0.0f, 0.0f};
    gain_a = gain_b = 1.0;
    seen = periods = ticks = 0u;
    memset(&sum, 0, sizeof sum);
}

void setUp(void)
{
    u_dc = (float)LINK;
    limited = false;
    per_ampere = 0.0;
    salience = saturated = 1.0;
    forced = contradicted = elsewhere = false;
    doubt = 0.0f;
    omega_e = 0.0f;
    rotor = (rotation_t){0.0f, 1.0f};
    scatter = 0.0f;
    prepare(false, 1.0, 1.0);
}

static void add(ab_t voltage, dq_t asked_for, abc_t measured)
{
    sum.periods++;
    sum.voltage.alpha += voltage.alpha;
    sum.voltage.beta += voltage.beta;
    sum.asked_for.d += asked_for.d;
    sum.asked_for.q += asked_for.q;
    sum.moved |= (measured.a != sum.before.a ? 1u : 0u) | (measured.b != sum.before.b ? 2u : 0u) |
                 (measured.c != sum.before.c ? 4u : 0u);
}

static uint32_t close_window(current_watch_input_t *input)
{
    input->periods = sum.periods;
    input->voltage = sum.voltage;
    input->asked_for = sum.asked_for;
    input->moved = sum.moved;
    const uint32_t bits = current_watch_step(&watch, input);
    memset(&sum, 0, sizeof sum);
    sum.before = input->current;
    return bits;
}

static void judge(ab_t voltage, abc_t measured, ab_t reference)
{
    current_watch_input_t input = {
        .current = measured,
        .error = error,
        .reference = {reference.alpha, reference.beta},
        .frame = {0.0f, 1.0f},
        .u_dc = u_dc,
        .limited = limited,
        .rotor = rotor,
        .omega_e = omega_e,
        .doubt = doubt,
        .forced = forced,
        .contradicted = contradicted,
        .elsewhere = elsewhere,
        .comparable = true,
        .noise = scatter,
    };
    ticks++;
    add(voltage, input.reference, measured);
    const uint32_t bits = ticks % WINDOW == 0u ? close_window(&input) & ~CURRENT_WATCH_MAYBE : 0u;
    if (seen == 0u) {
        periods++;
        seen = bits;
    }
}

/* Runs a sound winding for this number of periods with this voltage; its sensors have their gains and a
 * code of noise. */
static void run(double alpha, double beta, uint32_t count, ab_t reference)
{
    for (uint32_t n = 0; n < count; n++) {
        i_alpha += PERIOD / INDUCTANCE * (alpha - RESISTANCE * i_alpha);
        i_beta += PERIOD / INDUCTANCE * (beta - RESISTANCE * i_beta);
        const double noise = 0.005 * (double)(n % 3u);
        const double a = gain_a * i_alpha + noise;
        const double b = gain_b * (-0.5 * i_alpha + sqrt(0.75) * i_beta) - 2.0 * noise;
        judge((ab_t){(float)alpha, (float)beta}, (abc_t){(float)a, (float)b, (float)(-a - b + in_c)},
              reference);
    }
}

/* At first 2 A flow, so that the signs of all three phase currents are certain. Then the reference of the
 * current rises as the current of a winding does at 60 V, and remains constant. */
static void jump(void)
{
    run(2.0 * RESISTANCE + 25.0, 0.0, 8u, (ab_t){2.0f, 0.0f});
    run(RESISTANCE * i_alpha, 0.0, 32u, (ab_t){2.0f, 0.0f});
    run(RESISTANCE * i_alpha + 60.0, 0.0, 12u, (ab_t){6.0f, 0.0f});
    run(RESISTANCE * i_alpha, 0.0, 16u, (ab_t){8.0f, 0.0f});
}

/* For this number of periods this voltage [V] acts along phase a, with these currents of a and b and a
 * code of noise. */
static void feed(uint32_t count, float voltage, float a, float b, ab_t reference)
{
    for (uint32_t n = 0; n < count; n++) {
        const float noisy_a = a + 0.02f * (float)(n % 3u);
        const float noisy_b = b - 0.02f * (float)(n % 5u);
        judge((ab_t){voltage, 0.0f}, (abc_t){noisy_a, noisy_b, -noisy_a - noisy_b}, reference);
    }
}

/* The expected change p is 100 V - 0.6 A R per period, which is 0.8 A. Its uncertainty is 4/3 (7.5 V + 0.9
 * V) and R/2 of the current. The value is present at the end of one window and does not change in the
 * whole next window. Near zero a wire without current shows the same, so that 12 periods are needed; six
 * are enough if 100 V make 3 A more than the uncertainty within five of them. 30 V make 0.15 A per period.
 * With a limit of 9 A, three times the usual one, 100 V do not reach it within the 12 periods. */
static void test_a_value_that_stays_is_stuck_and_near_zero_sooner_where_much_must_flow(void)
{
    static const struct {
        float volts, a, limit; /* [V]; [A]; limit of a stuck value [A], 0: the usual one */
        uint32_t least, most;  /* [periods] */
    } cases[] = {{100.0f, 0.6f, 0.0f, 1u, 2u * WINDOW},
                 {100.0f, 0.01f, 0.0f, 1u, 8u},
                 {30.0f, 0.01f, 0.0f, 12u, 100u},
                 {100.0f, 0.01f, 3.0f, 12u, 100u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        current_watch_tuning_t tuning = watch.tuning;
        tuning.stuck = cases[n].limit > 0.0f ? cases[n].limit : tuning.stuck;
        current_watch_take(&watch, &tuning);
        for (uint32_t k = 0; k < 16u; k++) {
            judge((ab_t){0.0f, 0.0f}, (abc_t){0.01f * (float)(k & 1u), 0.0f, 0.0f}, (ab_t){0.0f, 0.0f});
        }
        TEST_ASSERT_EQUAL_UINT32(0u, seen);
        periods = 0u;
        for (uint32_t k = 0; k < cases[n].most; k++) {
            const float b = -0.4f * (float)(k + 1u);
            judge((ab_t){cases[n].volts, 0.0f}, (abc_t){cases[n].a, b, -cases[n].a - b}, (ab_t){5.0f, 0.0f});
        }
        TEST_ASSERT_EQUAL_UINT32(CURRENT_WATCH_STUCK, seen);
        TEST_ASSERT_TRUE(periods >= cases[n].least);
    }
}

/* Two legs that are compensated with the wrong sign make (2 2 + 2)/3 of the loss of a leg, 2 (7.5 V + 0.9 V)
 * = 16.8 V along phase a. A sensor with an offset of 0.6 A shows a constant value for as long as this voltage
 * holds the current at zero. 18 V exceed it by 22 mA in a window, less 0.6 A R and R/2, and 40 V by 1.4 A. A
 * sound value varies if the noise is one code, 9.77 mA: then 18 V, 0.9 A, are sufficient. */
static void test_a_value_that_the_dead_time_may_hold_with_an_offset_is_not_stuck(void)
{
    static const struct {
        float volts, a, scatter; /* [V]; [A]; [A^2] in the calibration */
        uint32_t seen, windows;  /* the windows that the test lasts */
    } cases[] = {{16.7f, 0.6f, 0.0f, 0u, 200u},
                 {16.7f, -0.6f, 0.0f, 0u, 200u},
                 {40.0f, 0.6f, 0.0f, CURRENT_WATCH_STUCK, 8u},
                 {18.0f, 0.6f, 0.0f, 0u, 12u},
                 {18.0f, 0.6f, 9.0e-5f, 0u, 12u},
                 {18.0f, 0.6f, 1.0e-4f, CURRENT_WATCH_STUCK, 12u},
                 {18.0f, 0.1f, 0.0f, CURRENT_WATCH_STUCK, 12u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        scatter = cases[n].scatter;
        for (uint32_t k = 0; k < (2u + cases[n].windows) * WINDOW; k++) {
            const float a = k < 2u * WINDOW ? 0.01f * (float)(k & 1u) : cases[n].a;
            const float b = -0.5f * a + 0.02f * (float)(k % 3u);
            const float held = k < 2u * WINDOW ? 0.0f : cases[n].a > 0.0f ? cases[n].volts : -cases[n].volts;
            judge((ab_t){held, 0.0f}, (abc_t){a, b, -a - b}, (ab_t){0.0f, 0.0f});
        }
        char text[16];
        (void)snprintf(text, sizeof text, "case %u", (unsigned)n);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(cases[n].seen, seen, text);
    }
}

/* The current is 8 A; then a sensor shows 0, or a wire carries no current, with a code of noise. The error
 * of the observer is 8 A; its limit is 15 % of the range, 3 A. The sensor is suspected within two periods
 * and reported after six periods without a change; the wire is not. 100 V are 0.8 A per period. */
static void jump_to_zero(double noise)
{
    i_alpha = 8.0;
    run(RESISTANCE * 8.0, 0.0, 19u, (ab_t){8.0f, 0.0f});
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
    periods = 0u;
    error = (ab_t){8.0f, 0.0f};
    for (uint32_t n = 0; n < 2u * WINDOW; n++) {
        const float a = (float)(noise * (double)(n % 3u));
        judge((ab_t){100.0f, 0.0f}, (abc_t){a, -4.0f - 0.4f * (float)n, 4.0f + 0.4f * (float)n - a},
              (ab_t){8.0f, 0.0f});
    }
}

/* The stuck value is detected at the end of its window, and it has not changed in the whole next window. */
static void test_a_value_that_jumps_to_zero_is_stuck_within_two_windows(void)
{
    jump_to_zero(0.0);
    TEST_ASSERT_EQUAL_UINT32(CURRENT_WATCH_STUCK, seen);
    TEST_ASSERT_TRUE(periods <= 2u * WINDOW);
    setUp();
    jump_to_zero(0.01);
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}

/* The EMF may be wrong by 40 V, and +-20 V act for 5 ms each, so that no current exceeds its uncertainty.
 * For `still` periods the current of a has one value, then a code more; b moves by `swing` [A]. */
static void stand(uint32_t still, float swing)
{
    doubt = 40.0f / 0.183f;
    for (uint32_t n = 0; n < 400u; n++) {
        const float a = n < still ? -0.5f : -0.5f + 0.01f * (float)(n & 1u);
        const float b = swing * (float)((n / 4u) % 5u) / 4.0f;
        judge((ab_t){n / 50u % 2u == 0u ? 20.0f : -20.0f, 0.0f}, (abc_t){a, b, -a - b}, (ab_t){1.0f, 0.0f});
    }
}

/* The first window is only the beginning of the comparison. The sensor is reported as stuck 15 ms later,
 * at the end of a window. */
static void test_a_value_that_stands_for_15_ms_while_another_moves_is_stuck(void)
{
    stand(400u, 0.2f);
    TEST_ASSERT_EQUAL_UINT32(CURRENT_WATCH_STUCK, seen);
    TEST_ASSERT_TRUE(periods >= WINDOW + 150u && periods <= WINDOW + 150u + WINDOW);
    setUp();
    stand(140u, 0.2f); /* the value changes, and all counts begin again */
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
    setUp();
    stand(400u, 0.03f); /* 0.2 % of 20 A are 0.04 A */
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}

/* A code is 20 A/2048 = 9.77 mA, two codes squared 3.81e-4 A^2. All is at rest: only the noise shows that the
 * value of a is stuck. It is seen at the end of the window in which it has not changed for 16 periods. */
static void test_a_value_without_the_noise_of_its_sensor_is_stuck_after_two_windows(void)
{
    static const struct {
        float scatter; /* [A^2] in the calibration */
        uint32_t seen;
    } cases[] = {{3.9e-4f, CURRENT_WATCH_STUCK}, {3.7e-4f, 0u}, {0.0f, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        scatter = cases[n].scatter;
        for (uint32_t k = 0; k < 20u * WINDOW; k++) {
            const float a = k < 10u * WINDOW ? 0.02f * (float)(k % 2u) : 0.5f;
            const float b = 0.02f * (float)(k % 3u);
            judge((ab_t){0.0f, 0.0f}, (abc_t){a, b, -a - b}, (ab_t){0.0f, 0.0f});
        }
        TEST_ASSERT_EQUAL_UINT32(cases[n].seen, seen);
        TEST_ASSERT_TRUE(seen == 0u || periods == 13u * WINDOW);
    }
}

/* The same with three sensors: the limit of a stuck value is 1 A, and half of it is the largest sum of
 * currents that are right. Phase a carries no current, for example because its switch is open. */
static void test_three_values_that_add_up_to_zero_are_not_stuck(void)
{
    static const struct {
        float added; /* [A] by the sensor of c */
        uint32_t seen;
    } cases[] = {{0.45f, 0u}, {0.55f, CURRENT_WATCH_STUCK}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        prepare(true, 1.0, 1.0);
        scatter = 3.9e-4f;
        for (uint32_t k = 0; k < 10u * WINDOW; k++) {
            const float b = 0.002f * (float)(k % 3u);
            judge((ab_t){0.0f, 0.0f}, (abc_t){0.0f, b, cases[n].added - b}, (ab_t){0.0f, 0.0f});
        }
        TEST_ASSERT_EQUAL_UINT32(cases[n].seen, seen);
    }
}

/* With exact sensors and a constant current no sensor is found stuck. The allowances for R/2 and for the
 * whole dead time cover any voltage, for any time. */
static void test_a_constant_current_is_not_a_stuck_sensor(void)
{
    const float voltage = (float)(1.5 * RESISTANCE * 8.0 + 0.9 * 4.0 / 3.0 * (7.5 + 0.9));
    for (uint32_t n = 0; n < 20000u; n++) {
        judge((ab_t){voltage, 0.0f}, (abc_t){8.0f, -4.0f, -4.0f}, (ab_t){8.0f, 0.0f});
    }
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}

/* One sample of a sensor is wrong by 10 A. */
static void test_a_single_bad_sample_raises_nothing(void)
{
    for (uint32_t at = 0; at < 8u; at++) {
        prepare(false, 1.0, 1.0);
        jump();
        run(RESISTANCE * i_alpha, 0.0, at, (ab_t){8.0f, 0.0f});
        judge((ab_t){(float)(RESISTANCE * i_alpha), 0.0f},
              (abc_t){(float)i_alpha + 10.0f, (float)(-0.5 * i_alpha), (float)(-0.5 * i_alpha) - 10.0f},
              (ab_t){8.0f, 0.0f});
        run(RESISTANCE * i_alpha, 0.0, 40u, (ab_t){8.0f, 0.0f});
        TEST_ASSERT_EQUAL_UINT32(0u, seen);
    }
}

/* Sensors without a fault cause no warning, even if the configured L and R are wrong. A gain is reported
 * if the range of a sensor is 15 instead of 25 A or vice versa, or if one sensor is wrong by 30 %. A light
 * rotor explains a difference of the sensors: psi_f K |i| (8 T)^2/L, times 4/0.35, is compared with Dp.
 * With K of the paper's test rig, 69 rad/s^2 per A, this is 7 mA per A; with 70000 it is 7 A per A, and no
 * rise counts as a measurement. With a salient rotor, too, a difference of the sensors is no fault: along
 * L_d they show more than along L_q, so that the limit of the ratio is 1.2 x 1.42, and a sensor that reads
 * 1.3 times too much is not reported. A ratio below 0.35, or above its inverse, is an invalid sample. */
static void test_a_wrong_gain_is_seen_in_the_first_rise_and_no_wrong_assumption(void)
{
    static const struct {
        double l_assumed, r_assumed, gain_a, gain_b, per_ampere, salience;
        bool wrong;
    } cases[] = {{1.0, 1.0, 1.0, 1.0, 0.0, 1.0, false},      {0.7, 1.0, 1.0, 1.0, 0.0, 1.0, false},
                 {1.3, 1.0, 1.0, 1.0, 0.0, 1.0, false},      {1.0, 0.5, 1.0, 1.0, 0.0, 1.0, false},
                 {1.0, 1.5, 1.0, 1.0, 0.0, 1.0, false},      {0.7, 1.5, 1.0, 1.0, 0.0, 1.0, false},
                 {1.3, 0.5, 1.0, 1.0, 0.0, 1.0, false},      {1.0, 1.0, 0.6, 0.6, 0.0, 1.0, true},
                 {1.0, 1.0, 1.6667, 1.6667, 0.0, 1.0, true}, {1.0, 1.0, 0.7, 1.0, 0.0, 1.0, true},
                 {1.0, 1.0, 1.3, 1.0, 0.0, 1.0, true},       {1.0, 1.0, 1.0, 0.7, 0.0, 1.0, true},
                 {1.0, 1.0, 1.0, 1.3, 0.0, 1.0, true},       {1.0, 1.0, 0.6, 0.6, 69.0, 1.0, true},
                 {1.0, 1.0, 0.6, 0.6, 70000.0, 1.0, false},  {1.0, 1.0, 1.3, 1.0, 0.0, 1.42, false},
                 {1.0, 1.0, 0.3, 0.3, 0.0, 1.0, false},      {1.0, 1.0, 3.2, 3.2, 0.0, 1.0, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        char text[20];
        per_ampere = cases[n].per_ampere;
        salience = cases[n].salience;
        prepare(false, cases[n].l_assumed, cases[n].r_assumed);
        gain_a = cases[n].gain_a;
        gain_b = cases[n].gain_b;
        jump();
        (void)snprintf(text, sizeof text, "case %u", (unsigned)n);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(cases[n].wrong ? CURRENT_WATCH_GAIN : 0u, seen, text);
    }
}

/* The current of a q axis that saturates rises 1.67 times as fast as L without current permits. */
static void test_rise_of_a_saturated_axis_is_no_wrong_gain(void)
{
    saturated = 0.6;
    prepare(false, 1.0, 1.0);
    gain_a = gain_b = 1.6667;
    jump();
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
    prepare(false, 1.0, 1.0);
    gain_a = gain_b = 2.8;
    jump();
    TEST_ASSERT_EQUAL_UINT32(CURRENT_WATCH_GAIN, seen);
}

/* The condition of time is 32 periods without current, up to the end of a window, in a phase whose voltage
 * exceeds the 11.2 V that the dead time may take; 10 V could be hidden by it. 100 V less 11.2 V change the
 * flux by 2.9 psi_f in 6.0 ms, which is more than any flux. Half of this is enough if a forced frame moves
 * the rotor; if no phase carries current, the dead time may take twice as much.
 *
 * If a switch is open, its diode carries 1.2 A of the 3 A that are requested in phase a. This is less than
 * half, and is reported as a loss if the EMF along the axis of the phase contradicts the rotor. Without this
 * contradiction, and with 1.6 A or more, no loss is reported.
 *
 * Below 75 V the whole link changes a current of 12.5 mH by less than 2 % of 20 A in 100 us: at the limit
 * of such a link voltage the condition must last for four times 32 periods. It must last as long if the EMF
 * is wrong, but along the axis of no phase: a wrong angle of the encoder together with the dead time keeps a
 * phase at zero for about 3 ms. If only the other phases deviate from the requested current, by more than
 * 0.4 A and a quarter of the largest, the time is twice as long. A current of 0.5 A instead of 0.2 A deviates
 * by only 0.3 A. */
static void test_a_phase_without_its_current_is_lost(void)
{
    const double dead = 4.0 / 3.0 * (7.5 + 0.9);
    const double volt_seconds = 0.183 / (100.0 - dead) / PERIOD;
    const double longer = 0.183 / (100.0 - 2.0 * dead) / PERIOD;
    enum { FORCED = 1, CONTRADICTED = 2, LIMITED = 4, ELSEWHERE = 8 };
    const struct {
        uint32_t is;
        float link, voltage, a, b; /* [V], [V], [A], [A] */
        ab_t reference;
        double earliest, latest; /* [periods]; 0: never reported */
    } cases[] = {
        {0u, 300.0f, 13.0f, 0.0f, 3.0f, {2.0f, 3.0f}, 32.0, 48.0},
        {0u, 300.0f, 10.0f, 0.0f, 3.0f, {2.0f, 3.0f}, 0.0, 0.0},
        {0u, 300.0f, 100.0f, 0.0f, 1.0f, {0.0f, 0.0f}, 2.9 * volt_seconds, 2.9 * volt_seconds + 17.0},
        {FORCED, 300.0f, 100.0f, 0.0f, 1.0f, {0.0f, 0.0f}, 1.45 * volt_seconds, 1.45 * volt_seconds + 17.0},
        {0u, 300.0f, 100.0f, 0.0f, 0.0f, {0.0f, 0.0f}, 2.9 * longer, 2.9 * longer + 17.0},
        {CONTRADICTED, 300.0f, 20.0f, 1.2f, 2.0f, {3.0f, 3.0f}, 32.0, 60.0},
        {0u, 300.0f, 20.0f, 1.2f, 2.0f, {3.0f, 3.0f}, 0.0, 0.0},
        {LIMITED, 74.0f, 8.0f, 0.0f, 3.0f, {2.0f, 3.0f}, 128.0, 144.0},
        {0u, 74.0f, 8.0f, 0.0f, 3.0f, {2.0f, 3.0f}, 32.0, 64.0},
        {LIMITED, 76.0f, 8.0f, 0.0f, 3.0f, {2.0f, 3.0f}, 32.0, 64.0},
        {ELSEWHERE, 300.0f, 20.0f, 0.0f, 3.0f, {2.0f, 3.0f}, 128.0, 144.0},
        {CONTRADICTED, 300.0f, 20.0f, 1.6f, 2.0f, {3.0f, 3.0f}, 0.0, 0.0},
        {0u, 300.0f, 20.0f, 0.0f, 3.0f, {0.2f, 0.0f}, 64.0, 80.0},
        {0u, 300.0f, 20.0f, 0.0f, 0.5f, {0.2f, 0.3f}, 0.0, 0.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        forced = (cases[n].is & FORCED) != 0u;
        contradicted = (cases[n].is & CONTRADICTED) != 0u;
        elsewhere = (cases[n].is & ELSEWHERE) != 0u;
        limited = (cases[n].is & LIMITED) != 0u;
        u_dc = cases[n].link;
        feed(200u, cases[n].voltage, cases[n].a, cases[n].b, cases[n].reference);
        TEST_ASSERT_EQUAL_UINT32(cases[n].latest > 0.0 ? CURRENT_WATCH_LOSS : 0u, seen);
        if (cases[n].latest > 0.0) {
            TEST_ASSERT_TRUE(periods >= (uint32_t)cases[n].earliest && periods <= (uint32_t)cases[n].latest);
        }
    }
}

/* With a request along the axis of the open phase a the others, in series, carry no current either. It is a
 * loss if the voltage exceeds that of the dead time, 4/3 (7.5 V + 0.9 V) = 11.2 V, and the EMF that is
 * uncertain, 0.183 Wb times 20 rad/s = 3.7 V; not if the control does not reach its voltage, or with a
 * request of less than 0.4 A. */
static void test_a_request_along_an_open_phase_is_a_loss_although_no_phase_carries_current(void)
{
    static const struct {
        float voltage, doubt, reference; /* [V], [rad/s], [A] */
        bool limited, lost;
    } cases[] = {{13.0f, 0.0f, 3.0f, false, true},    {10.0f, 0.0f, 3.0f, false, false},
                 {13.0f, 20.0f, 3.0f, false, false},  {16.0f, 20.0f, 3.0f, false, true},
                 {-16.0f, 20.0f, -3.0f, false, true}, {16.0f, 20.0f, 3.0f, true, false},
                 {16.0f, 20.0f, 0.35f, false, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        doubt = cases[n].doubt;
        limited = cases[n].limited;
        feed(100u, cases[n].voltage, 0.0f, 0.0f, (ab_t){cases[n].reference, 0.0f});
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(cases[n].lost ? CURRENT_WATCH_LOSS : 0u, seen, "case");
        TEST_ASSERT_TRUE(!cases[n].lost || (periods >= 32u && periods <= 48u));
    }
}

/* The same with a rotor whose EMF lies along phase a: the assumed one is 0.183 Wb times 300 rad/s = 55 V. A
 * magnet may have any flux from none to 1.3 of the assumed one, here 0.3 with 90 rad/s uncertain, so that the
 * control may balance any voltage down to 55 + 11.2 + 16.5 V below the assumed EMF. Beyond it a current must
 * flow. While another phase carries 1 A, only the dead time counts. */
static void test_an_emf_of_a_weak_magnet_that_the_control_balances_is_no_loss(void)
{
    static const struct {
        float voltage, beside; /* [V], [A] */
        bool lost;
    } cases[] = {{24.0f, 0.0f, false}, {-20.0f, 0.0f, false}, {-35.0f, 0.0f, true}, {24.0f, 1.0f, true}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        rotor = (rotation_t){-1.0f, 0.0f};
        omega_e = 300.0f;
        doubt = 90.0f;
        feed(100u, cases[n].voltage, 0.0f, cases[n].beside, (ab_t){3.0f, 3.0f});
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(cases[n].lost ? CURRENT_WATCH_LOSS : 0u, seen, "case");
    }
}

/* The request of 1.8 A, of which 0.5 A flow, is nearly across phase a, whose share of them is 0.11 A: less
 * than the 0.15 A of a phase without current. The phase is not lost with 0.1 A, and it is lost with 0.016 A.
 * If only 0.3 A flow in the others, no phase carries current, and the control may be unable to follow the
 * request. */
static void test_a_phase_with_its_share_of_a_short_current_is_not_lost(void)
{
    static const struct {
        float a, b; /* [A] */
        bool lost;
    } cases[] = {{0.1f, 0.5f, false}, {0.016f, 0.5f, true}, {0.016f, 0.3f, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        for (uint32_t k = 0; k < 200u; k++) {
            const float a = cases[n].a + 0.01f * (float)(k % 3u);
            judge((ab_t){20.0f, 15.0f}, (abc_t){a, cases[n].b, -cases[n].b - a}, (ab_t){0.4f, 1.75f});
        }
        TEST_ASSERT_EQUAL_UINT32(cases[n].lost ? CURRENT_WATCH_LOSS : 0u, seen);
    }
}

/* A current of 2 A turns by a quarter in each window, and half of the requested one flows, because the EMF is
 * not known. The current of a is zero at every second end of a window, with another sign of the request each
 * time, and flows in both directions between. */
static void test_a_current_that_is_zero_at_the_ends_of_windows_is_not_missing(void)
{
    for (uint32_t turn = 0; turn < 20u; turn++) {
        feed(WINDOW, 20.0f, 0.0f, 2.0f, (ab_t){3.0f, 3.0f});
        feed(WINDOW, -20.0f, -2.0f, 1.0f, (ab_t){-3.0f, 3.0f});
        feed(WINDOW, -20.0f, 0.0f, -2.0f, (ab_t){-3.0f, -3.0f});
        feed(WINDOW, 20.0f, 2.0f, -1.0f, (ab_t){3.0f, -3.0f});
    }
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}

/* The requested current of a has one sign for 16 periods, in which none flows, and the other sign for 16
 * periods, in which it flows. In the third turn 32 periods without the current of that sign have passed. If
 * a current of that sign flows in one window of each turn, nothing is reported. */
static void test_a_switch_that_does_not_conduct_is_a_loss_although_the_other_sign_flows(void)
{
    for (int closed = 0; closed < 2; closed++) {
        for (int negative = 0; negative < 2; negative++) {
            const float sign = negative != 0 ? -1.0f : 1.0f;
            setUp();
            for (uint32_t turn = 0; turn < 10u; turn++) {
                feed(16u, 20.0f * sign, 0.0f, 3.0f, (ab_t){2.0f * sign, 3.0f});
                if (closed != 0) {
                    feed(8u, 20.0f * sign, 2.0f * sign, 3.0f, (ab_t){2.0f * sign, 3.0f});
                }
                feed(16u, -20.0f * sign, -2.0f * sign, 3.0f, (ab_t){-2.0f * sign, 3.0f});
            }
            TEST_ASSERT_EQUAL_UINT32(closed != 0 ? 0u : CURRENT_WATCH_LOSS, seen);
            TEST_ASSERT_TRUE(closed != 0 || (periods > 48u && periods <= 80u));
        }
    }
}

/* As before, but no phase carries a current while that of a is missing, and the 20 V are less than the 11.2 V
 * of the dead time and 1.3 times the EMF of 0.183 Wb times 300 rad/s, 71.4 V. The EMF is across the axis of a
 * in the middle of the window. Two turns of 40 periods show the missing current and the other one, the third
 * one counts 24 periods, and the fourth one the rest. Nothing is reported if less than 0.4 A, 2 % of the
 * range, flow in the other direction, or no voltage drives the missing current, or in each turn a current of
 * either sign flows. */
static void test_a_switch_that_does_not_conduct_is_a_loss_although_the_emf_is_larger_than_the_voltage(void)
{
    static const struct {
        float voltage, flows, closed; /* [V], [A], [A] */
        bool lost;
    } cases[] = {{20.0f, 2.0f, 0.0f, true},   {20.0f, 0.3f, 0.0f, false}, {20.0f, 0.0f, 0.0f, false},
                 {-20.0f, 2.0f, 0.0f, false}, {10.0f, 2.0f, 0.0f, false}, {20.0f, 2.0f, 0.3f, false}};
    for (size_t n = 0; n < 2u * sizeof cases / sizeof cases[0]; n++) {
        const float sign = n % 2u == 0u ? 1.0f : -1.0f;
        const float volts = sign * cases[n / 2u].voltage;
        const float closed = sign * cases[n / 2u].closed;
        const float flows = -sign * cases[n / 2u].flows;
        setUp();
        omega_e = 300.0f;
        doubt = 90.0f;
        rotor = trig_rotation(0.5f * (float)WINDOW * (float)PERIOD * omega_e);
        for (uint32_t turn = 0; turn < 10u; turn++) {
            feed(16u, volts, 0.0f, 0.0f, (ab_t){0.6f * sign, 0.0f});
            feed(WINDOW, volts, closed, -0.5f * closed, (ab_t){0.6f * sign, 0.0f});
            feed(16u, 0.0f, flows, -0.5f * flows, (ab_t){flows, 0.0f});
        }
        TEST_ASSERT_EQUAL_UINT32(cases[n / 2u].lost ? CURRENT_WATCH_LOSS : 0u, seen);
        TEST_ASSERT_TRUE(!cases[n / 2u].lost || (periods > 120u && periods <= 144u));
    }
}

/* The current of a shorted winding without R is psi_f/L (e^(j theta_0) - e^(j theta)). The change over a
 * window that the watch expects is the exact one at any turn of the rotor in the window, here up to 9.2 rad.
 */
static void test_the_expected_change_is_exact_at_any_turn_of_the_rotor(void)
{
    static const double turns[] = {0.05, 0.5, 2.0, 4.0, 6.28, 9.2, -4.0};
    const double most = 0.183 / INDUCTANCE;
    for (size_t n = 0; n < sizeof turns / sizeof turns[0]; n++) {
        setUp();
        prepare(false, 1.0, 0.0);
        omega_e = (float)(turns[n] / (WINDOW * PERIOD));
        double begin = 0.0;
        double end = 0.0;
        for (uint32_t k = 1; k <= 3u * WINDOW; k++) {
            const double theta = turns[n] * k / WINDOW;
            rotor = trig_rotation((float)remainder(theta, 2.0 * 3.14159265358979));
            const double alpha = most * (1.0 - cos(theta));
            const double beta = -most * sin(theta);
            begin = k == 2u * WINDOW ? alpha : begin;
            end = alpha;
            const double b = -0.5 * alpha + 0.5 * sqrt(3.0) * beta;
            judge((ab_t){0.0f, 0.0f}, (abc_t){(float)alpha, (float)b, (float)(-alpha - b)},
                  (ab_t){(float)alpha, (float)beta});
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * most, end - begin, (double)watch.phase[0].expected);
    }
}

/* A rotor that reverses: phase a has carried a current of one sign for one half turn, and then no phase
 * carries one, because the control balances a wrong EMF with 20 V. */
static void test_a_current_of_one_sign_in_one_half_turn_is_no_open_switch(void)
{
    omega_e = 300.0f;
    doubt = 90.0f;
    rotor = trig_rotation(0.5f * (float)WINDOW * (float)PERIOD * omega_e);
    feed(2u * WINDOW, 20.0f, 0.0f, 0.0f, (ab_t){0.6f, 0.0f});
    feed(2u * WINDOW, 0.0f, -2.0f, 1.0f, (ab_t){-2.0f, 0.0f});
    feed(50u * WINDOW, 20.0f, 0.0f, 0.0f, (ab_t){0.6f, 0.0f});
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}

/* The speed control alternates between requests of 6 A and -5.9 A, whose mean is the current that flows;
 * the current of a is near its zero. */
static void test_a_phase_near_zero_is_not_lost_while_the_reference_chatters(void)
{
    for (uint32_t n = 0; n < 200u; n++) {
        const float noise = 0.02f * (float)(n % 3u);
        const float asked = n % 2u == 0u ? 6.0f : -5.9f;
        judge((ab_t){0.0f, 0.0f}, (abc_t){0.05f + noise, 0.6f, -0.65f - noise}, (ab_t){asked, 0.7f});
    }
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}

/* The request of phase a is 1.2 A in one or two windows of six, in which no current flows through it. That is
 * more than the 0.4 A + 0.25 1 A of a phase that must carry current. In the others it carries the -1 A that
 * are requested. A single window does not count. */
static void test_a_request_of_a_single_window_is_not_missing(void)
{
    for (uint32_t windows = 1; windows <= 2u; windows++) {
        setUp();
        for (uint32_t k = 0; k < 20u; k++) {
            feed(windows * WINDOW, 20.0f, 0.0f, 1.0f, (ab_t){1.2f, 0.6f});
            feed((6u - windows) * WINDOW, 0.0f, -1.0f, 1.0f, (ab_t){-1.0f, 0.6f});
        }
        TEST_ASSERT_EQUAL_UINT32(windows == 1u ? 0u : CURRENT_WATCH_LOSS, seen);
    }
}

/* A phase that turns by a third of a turn in each window, 2618 rad/s, has the same angle at the end of every
 * third one: its current, which lags the request, is zero there. The others carry 2 A and -2 A, and a carries
 * 1.7 A and -1.7 A at the ends of the other windows. */
static void test_a_fast_phase_whose_current_is_zero_in_every_third_window_is_not_lost(void)
{
    for (uint32_t k = 0; k < 40u; k++) {
        feed(WINDOW, 20.0f, 0.0f, 2.0f, (ab_t){2.0f, 1.0f});
        feed(WINDOW, 20.0f, -1.7f, -0.3f, (ab_t){-1.8f, 1.2f});
        feed(WINDOW, 20.0f, 1.7f, -1.7f, (ab_t){-0.1f, -2.2f});
    }
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}

/* In a catch 0.2 A flow beside the open wire of b, and by chance they are equal all through a window. This
 * is no stuck sensor, because voltage is applied to b and it carries no current. Two such windows are
 * reported as a stuck sensor, and so is one window in which no voltage is applied to b. */
static void test_a_current_past_an_open_wire_may_stay_for_some_periods(void)
{
    const uint32_t stays[] = {WINDOW, 2u * WINDOW, WINDOW};
    for (uint32_t n = 0; n < 3u; n++) {
        setUp();
        const float beta = n == 2u ? 29.0f : -60.0f; /* b has minus 25 V and 0.87 of beta */
        for (uint32_t m = 0; m < 60u; m++) {
            const bool still = m >= 31u && m < 32u + stays[n];
            const float noise = still ? 0.0f : 0.02f * (float)(1u + m % 3u);
            judge((ab_t){50.0f, beta}, (abc_t){0.2f + noise, 0.02f * (float)(m % 3u), -0.2f - noise},
                  (ab_t){0.3f, 0.0f});
        }
        TEST_ASSERT_EQUAL_UINT32(n == 0u ? 0u : CURRENT_WATCH_STUCK, seen);
    }
}

static void test_three_currents_must_add_up_to_zero(void)
{
    prepare(true, 1.0, 1.0);
    in_c = 1.5;
    jump();
    TEST_ASSERT_EQUAL_UINT32(0u, seen & CURRENT_WATCH_SUM);
    prepare(true, 1.0, 1.0);
    in_c = 1.7; /* 8 % of the range are 1.6 A */
    jump();
    TEST_ASSERT_EQUAL_UINT32(CURRENT_WATCH_SUM, seen & CURRENT_WATCH_SUM);
}

/* An open wire shows noise; a value that does not change at all is the fault of a sensor. The other two
 * phases carry 3 A, the reference of this phase is 2 A, and its voltage is larger than that of the dead
 * time and smaller than this plus R i of 3 A, so that no other criterion applies. With noise it is
 * reported as a loss. */
static void test_a_value_that_does_not_move_at_all_is_no_open_wire(void)
{
    const ab_t axis[] = {{2.0f, 0.0f}, {-1.0f, 1.7320508f}, {-1.0f, -1.7320508f}};
    const float volts = 15.0f;
    for (uint32_t phase = 0; phase < 6u; phase++) {
        const ab_t along = axis[phase / 2u];
        const bool still = phase % 2u == 0u;
        prepare(true, 1.0, 1.0);
        for (uint32_t n = 0; n < 60u; n++) {
            const float noise = 0.02f * (float)(n % 3u);
            float value[3] = {3.0f + noise, 3.0f + noise, -3.0f - noise};
            value[phase / 2u] = still ? 0.0f : 0.5f * noise;
            value[0] = phase / 2u == 2u ? -value[1] : value[0];
            judge((ab_t){0.5f * volts * along.alpha, 0.5f * volts * along.beta},
                  (abc_t){value[0], value[1], value[2]}, along);
        }
        TEST_ASSERT_EQUAL_UINT32(still ? 0u : CURRENT_WATCH_LOSS, seen);
    }
}

/* The number of periods until the watch warns of a phase without current at this voltage [V]; 0 if it does
 * not within 400 periods. */
static uint32_t periods_until_maybe(float voltage)
{
    for (uint32_t n = 0; n < 400u; n++) {
        const abc_t measured = {0.02f * (float)(n % 3u), -0.02f * (float)(n % 5u), 0.0f};
        current_watch_input_t input = {.current = measured,
                                       .frame = {0.0f, 1.0f},
                                       .u_dc = (float)LINK,
                                       .rotor = {0.0f, 1.0f},
                                       .comparable = true};
        add((ab_t){voltage, 0.0f}, (dq_t){0.0f, 0.0f}, measured);
        if ((n + 1u) % WINDOW == 0u && (close_window(&input) & CURRENT_WATCH_MAYBE) != 0u) {
            return n + 1u;
        }
    }
    return 0u;
}

/* The warning requires a tenth of 2.9 psi_f. The dead time may take 22.4 V of the 30 V if the signs of all
 * three currents are uncertain. A window has 8 periods, and the first window is not judged. */
static void test_a_tenth_of_the_flux_in_a_phase_without_current_is_a_warning(void)
{
    const double expected = 0.1 * 2.9 * 0.183 / (30.0 - 2.0 * 4.0 / 3.0 * (7.5 + 0.9)) / PERIOD;
    const uint32_t until = periods_until_maybe(30.0f);
    TEST_ASSERT_TRUE(until >= (uint32_t)expected && until <= (uint32_t)expected + 17u);
}

/* The sensors have 0.6 of their gain, and the current rises some windows after its reference. The ratio
 * must exceed its limit in two windows. The watch judges the window in which the reference steps and the
 * two windows after it. If the rise begins one window after the step, two windows of it are judged; if it
 * begins two windows after the step, only one is. */
static void test_a_gain_is_judged_in_the_window_of_a_step_and_the_two_after_it(void)
{
    for (uint32_t later = 0; later < 4u; later++) {
        setUp();
        gain_a = gain_b = 0.6;
        run(2.0 * RESISTANCE + 25.0, 0.0, 8u, (ab_t){6.0f, 0.0f});
        run(RESISTANCE * i_alpha, 0.0, 32u, (ab_t){6.0f, 0.0f});
        TEST_ASSERT_EQUAL_UINT32(0u, seen);
        run(RESISTANCE * i_alpha, 0.0, WINDOW * later, (ab_t){8.0f, 0.0f});
        run(RESISTANCE * i_alpha + 60.0, 0.0, 12u, (ab_t){8.0f, 0.0f});
        run(RESISTANCE * i_alpha, 0.0, 16u, (ab_t){8.0f, 0.0f});
        TEST_ASSERT_EQUAL_UINT32(later < 2u ? CURRENT_WATCH_GAIN : 0u, seen);
    }
}

/* The values alternate between x and -x from one window to the next, without a voltage, so that their
 * change varies by 4 x. The mean noise follows the square of this by 5 % per window, limited to a tenth of
 * the shortest Dp^2, which is (3 % of 20 A)^2. */
static void test_the_mean_noise_follows_the_square_of_what_no_voltage_makes(void)
{
    const double amplitudes[] = {0.05, 0.2};
    for (uint32_t n = 0; n < 2u; n++) {
        setUp();
        const double x = amplitudes[n];
        for (uint32_t m = 0; m < 23u * WINDOW; m++) {
            const float a = (float)(m / WINDOW % 2u == 0u ? x : -x);
            /* Before the first windows there was another current. */
            watch.noise = m == 3u * WINDOW ? 0.0f : watch.noise;
            judge((ab_t){0.0f, 0.0f}, (abc_t){a, -a, 0.0f}, (ab_t){0.0f, 0.0f});
        }
        const double square = fmin(16.0 * x * x, 0.1 * 0.6 * 0.6);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * square, square * (1.0 - pow(0.95, 20.0)), (double)watch.noise);
    }
}

/* The limit for no current is 0.75 % of 20 A, 0.15 A. A phase lacks current if it shows less at the end of
 * the last window and now, and its reference is larger than 2 %, 0.4 A, with which the watch can find a loss.
 */
static void test_a_phase_lacks_current_that_had_none_at_the_last_window_either(void)
{
    for (uint32_t phase = 0; phase < 3u; phase++) {
        for (uint32_t n = 0; n < 8u; n++) {
            const float before[] = {(n & 1u) != 0u ? 0.16f : -0.14f, 3.0f, -3.0f};
            const float now[] = {(n & 2u) != 0u ? -0.16f : 0.14f, 3.0f, -3.0f};
            const float asked[] = {(n & 4u) != 0u ? 0.39f : -0.41f, 3.0f, -3.0f};
            const uint32_t b = (4u - phase) % 3u; /* which of the currents phases b and a have */
            const uint32_t a = (3u - phase) % 3u;
            const uint32_t c = (5u - phase) % 3u;
            setUp();
            for (uint32_t m = 0; m < WINDOW; m++) {
                judge((ab_t){0.0f, 0.0f}, (abc_t){before[a], before[b], before[c]}, (ab_t){0.0f, 0.0f});
            }
            TEST_ASSERT_EQUAL(n == 0u, current_watch_lacks(&watch, (abc_t){now[a], now[b], now[c]},
                                                           (abc_t){asked[a], asked[b], asked[c]}));
        }
    }
}

/* Phase a carries no current in two windows in which 2 A are requested. It still lacks a current while 0.14 A
 * are requested, less than the limit, until it carries one of the missing sign: a current of the other sign
 * may flow through the diode of an open switch. Without a missing current the same small request is no lack.
 */
static void test_a_missing_current_is_missing_until_the_phase_carries_one(void)
{
    static const struct {
        float flows, asked; /* [A], in the direction of the request */
        bool lacks;
    } windows[] = {{0.0f, 0.0f, false},  {0.0f, 2.0f, false}, {0.0f, 2.0f, true},  {0.0f, 0.0f, true},
                   {-1.0f, 0.0f, false}, {0.0f, 0.0f, true},  {1.0f, 2.0f, false}, {0.0f, 0.0f, false}};
    for (int way = -1; way <= 1; way += 2) {
        const float sign = (float)way;
        setUp();
        for (uint32_t n = 0; n < WINDOW * sizeof windows / sizeof windows[0]; n++) {
            const uint32_t window = n / WINDOW;
            const float a = sign * windows[window].flows + 0.02f * (float)(n % 3u);
            const abc_t current = {a, 3.0f, -3.0f - a};
            judge((ab_t){30.0f * sign, 0.0f}, current, (ab_t){sign * windows[window].asked, 3.0f});
            const abc_t small = {0.14f * sign, 3.0f, -3.0f - 0.14f * sign};
            if (n % WINDOW == WINDOW - 1u) {
                TEST_ASSERT_EQUAL(windows[window].lacks, current_watch_lacks(&watch, current, small));
            }
        }
    }
}

/* A loss requires 32 successive periods without current. The test has 24 of them, a window that ends with
 * 1 A, and 24 again; the first window is not judged. */
static void test_a_window_with_current_ends_the_time_without_current(void)
{
    for (uint32_t n = 0; n < 64u; n++) {
        const float noise = 0.02f * (float)(n % 3u);
        const float a = n / WINDOW == 4u ? 1.0f + noise : noise;
        judge((ab_t){0.0f, 0.0f}, (abc_t){a, 3.0f, -3.0f - a}, (ab_t){2.0f, 3.0f});
    }
    TEST_ASSERT_EQUAL_UINT32(0u, seen);
}
