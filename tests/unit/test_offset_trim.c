/* EMFs that are the sum of a rotating vector and a constant. The constant is the effect of an offset, and
 * the trim must find it. */
#include "medium/adapt/offset_trim.h"
#include "tests/unit/sweep.h"
#include "tests/unit/vectors.h"

#define GAIN   0.05f
#define PERIOD 1e-4f
#define WINDOW 1000 /* periods */

static const offset_trim_params_t PARAMS = {.gain = GAIN, .period = PERIOD};
static const offset_trim_params_t SALIENT = {.gain = GAIN, .period = PERIOD, .saliency = 0.02f};
static const ab_t NONE = {0.0f, 0.0f};
static const ab_t CURRENT = {0.8f, -0.9f}; /* 1.2 A */

/* A rotor as the drive measures it. */
typedef struct {
    offset_trim_t trim;
    double theta;            /* [rad] */
    double samples_per_turn; /* a negative number stands for the other direction */
    double amplitude;        /* [V] amplitude of the rotating EMF */
    ab_t current;            /* [A] */
    float omega;             /* [rad/s] speed that the trim receives */
} rotor_t;

static rotor_t rotor;

static void begin(const offset_trim_params_t *params)
{
    const offset_trim_tuning_t tuning = offset_trim_prepare(params);
    offset_trim_init(&rotor.trim, &tuning);
}

static float omega_of(double samples_per_turn)
{
    return (float)(2.0 * PI / (samples_per_turn * 1e-4));
}

/* The rotor does not turn yet; its samples are evenly distributed around the wrap of the angle. */
static void start(double samples_per_turn)
{
    memset(&rotor, 0x55, sizeof rotor);
    rotor = (rotor_t){.theta = PI / samples_per_turn,
                      .samples_per_turn = samples_per_turn,
                      .amplitude = 60.0,
                      .current = CURRENT,
                      .omega = omega_of(samples_per_turn)};
    begin(&PARAMS);
}

/* At 314 rad/s five turns of 200 samples are a window. */
void setUp(void)
{
    start(200.0);
}

/* A step with this EMF, and this c of a saturating q axis [Wb]. */
static ab_t step_of(double complex emf, float cross)
{
    const double wrapped = rotor.theta - 2.0 * PI * floor(rotor.theta / (2.0 * PI) + 0.5);
    const offset_trim_input_t input = {
        .emf_hat = to_ab(emf),
        .current = rotor.current,
        .rotor = {(float)sin(rotor.theta), (float)cos(rotor.theta)},
        .theta_e = (float)wrapped,
        .omega_e = rotor.omega,
        .cross = cross,
    };
    const ab_t offset = offset_trim_step(&rotor.trim, &input);
    /* From the wrapped angle: a growing one would lose digits where a double has 32 bits. */
    rotor.theta = wrapped + 2.0 * PI / rotor.samples_per_turn;
    return offset;
}

static ab_t step(double complex constant)
{
    const double way = rotor.samples_per_turn > 0.0 ? 1.0 : -1.0;
    return step_of(constant + rotor.amplitude * way * J * cexp(J * rotor.theta), 0.0f);
}

static ab_t steps(double complex constant, int32_t count)
{
    ab_t offset = rotor.trim.offset;
    for (int32_t n = 0; n < count; n++) {
        offset = step(constant);
    }
    return offset;
}

static const double complex CONSTANT = -0.31 + 0.17 * J;

/* Runs to the end of a window. Returns the number of samples. */
static int32_t finish_window(double complex constant)
{
    int32_t count = 0;
    do {
        (void)step(constant);
        count++;
    } while (rotor.trim.count != 0u && count < 4 * WINDOW);
    TEST_ASSERT_EQUAL_UINT32(0u, rotor.trim.count);
    return count;
}

/* The window that a reset begins has no speed to compare with and ends without a change. The window after
 * it begins where the angle wraps, within the period of a sample, so that this constant acts in it from
 * the begin. */
static void begin_window_of(double complex constant)
{
    (void)finish_window(constant);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, rotor.trim.offset.alpha);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, rotor.trim.offset.beta);
}

static void begin_window(void)
{
    begin_window_of(CONSTANT);
}

/* The sums stay below 16 kV and are rounded by at most 2^-11 V. 1500 such errors of either sign make 0.02
 * V; multiplied by gain/count this is 7e-7 A. The limit is for three windows, with a wide margin: */
#define ROUNDING 6e-6

static void expect_offset(double complex wanted, double tolerance, ab_t offset)
{
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, creal(wanted), (double)offset.alpha);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, cimag(wanted), (double)offset.beta);
}

/* ---- what is found ---- */

static void test_finds_the_constant_of_an_emf_that_turns_either_way(void)
{
    for (int way = -1; way <= 1; way += 2) {
        start(way * 200.0);
        expect_offset(0.0, 0.0, rotor.trim.offset);
        begin_window();
        expect_offset(0.0, 0.0, steps(CONSTANT, WINDOW - 1));
        const ab_t offset = step(CONSTANT);
        expect_offset(-0.05 * CONSTANT, ROUNDING, offset);
        TEST_ASSERT_EQUAL_FLOAT(rotor.trim.offset.alpha, offset.alpha);
        TEST_ASSERT_EQUAL_FLOAT(rotor.trim.offset.beta, offset.beta);
    }
}

/* A turn is not a whole number of samples. Each of many windows may have an error of at most an eighth of
 * omega T of the rotating EMF, for any position of the wraps in a period. 724.98 samples per turn are a
 * motor of 20 pole pairs at 41 r/min; most of its turns have 725 samples, and a few have one less. */
static void test_broken_turns_leave_less_than_a_sample(void)
{
    static const double turns[] = {20.93, 42.93, -42.93, 157.3, -333.3, 724.98, -724.98};
    for (size_t n = 0; n < sizeof turns / sizeof turns[0]; n++) {
        start(turns[n]);
        begin_window();
        const double left = 2.0 * PI / fabs(turns[n]) / 8.0 * rotor.amplitude;
        for (int32_t window = 1; window <= 60; window += SWEEP_FEW) {
            rotor.trim.offset = NONE;
            const int32_t count = finish_window(CONSTANT);
            TEST_ASSERT_TRUE(count >= WINDOW && count <= WINDOW + (int32_t)fabs(turns[n]) + 1);
            expect_offset(-0.05 * CONSTANT, 0.05 * left / WINDOW + ROUNDING, rotor.trim.offset);
        }
    }
}

/* If a turn takes longer than TRIM_WINDOW, a window is one turn: 1500 samples, 41.9 rad/s. */
static void test_a_slow_window_is_a_whole_turn(void)
{
    start(1500.0);
    begin_window();
    expect_offset(0.0, 0.0, steps(CONSTANT, 1499));
    expect_offset(-0.05 * CONSTANT, ROUNDING, step(CONSTANT));
}

/* The active flux psi_a = psi_f - D i_d + j c i_q of a salient rotor whose current contains the constant x:
 * in the rotor's frame it changes with the turn. The observed EMF is j omega psi_a e^(j theta), and has a
 * mean over a turn, j omega (c - D) x/2. */
static void expect_no_offset_of_salient(double samples_per_turn, double complex x, double c)
{
    start(samples_per_turn);
    begin(&SALIENT);
    const double omega = (double)rotor.omega;
    for (int32_t window = 0; window < 2; window++) {
        do {
            const double complex turn = cexp(J * rotor.theta);
            const double complex now = x * conj(turn); /* in the rotor's frame */
            const double complex flux = 0.1 - 0.02 * creal(now) + J * c * cimag(now);
            rotor.current = to_ab(x + 3.0 * J * turn);
            (void)step_of(CONSTANT + J * omega * flux * turn, (float)(c * cimag(now)));
        } while (rotor.trim.count != 0u);
    }
    const double part = fabs(omega) * 1e-4 / 8.0 * fabs(omega) * 0.1 / WINDOW; /* by the divided sample */
    expect_offset(-0.05 * CONSTANT, 0.05 * part + 4.0 * ROUNDING, rotor.trim.offset);
}

static void test_a_salient_rotor_has_no_offset_by_the_ripple_of_its_current(void)
{
    static const double turns[] = {2.1, -2.3, 3.7, -7.1, 21.3, -42.93, 157.3};
    for (size_t n = 0; n < sizeof turns / sizeof turns[0]; n++) {
        expect_no_offset_of_salient(turns[n], 0.3 - 0.2 * J, 0.0);
        expect_no_offset_of_salient(turns[n], -0.1 + 0.3 * J, -0.01);
    }
}

/* ---- when no result is permitted ---- */

/* One window in which the trim receives these speeds at its beginning and end. */
static void expect_window_of_speeds(float begin, float end, bool counts)
{
    setUp();
    rotor.omega = begin;
    begin_window();
    rotor.omega = end;
    const ab_t offset = steps(CONSTANT, WINDOW);
    expect_offset(counts ? -0.05 * CONSTANT : 0.0, counts ? ROUNDING : 0.0, offset);
}

/* The speed is too low, or it changes by more than TRIM_SPEED_DRIFT of itself, in either direction. 512
 * and 0.5 % of it are exact floats. */
static void test_a_slow_or_changing_speed_is_left_alone(void)
{
    const float limit = TRIM_SPEED_MIN;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const float s = (float)sign;
        expect_window_of_speeds(s * 0.999f * limit, s * 0.999f * limit, false);
        expect_window_of_speeds(s * limit, s * limit, false);
        expect_window_of_speeds(s * 1.001f * limit, s * 1.001f * limit, true);
        expect_window_of_speeds(s * 300.0f, s * -300.0f, false);
        for (int32_t up = -1; up <= 1; up += 2) {
            const float drift = (float)up * TRIM_SPEED_DRIFT * 512.0f;
            expect_window_of_speeds(s * (512.0f - 1.01f * drift), s * 512.0f, false);
            expect_window_of_speeds(s * (512.0f - 0.99f * drift), s * 512.0f, true);
        }
    }
}

/* A rotor that turns by almost half a turn in a step. */
static void test_a_fast_rotor_is_left_alone(void)
{
    const float limit = TRIM_TURN_MOST / PERIOD;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const float s = (float)sign;
        expect_window_of_speeds(s * 1.001f * limit, s * 1.001f * limit, false);
        expect_window_of_speeds(s * 0.999f * limit, s * 0.999f * limit, true);
    }
}

/* The square of 0.5 is an exact float. Both components count: 0.71^2 + 0.71^2 > 1. */
static void test_a_small_current_is_left_alone(void)
{
    static const struct {
        float alpha, beta; /* multiples of TRIM_CURRENT_MIN */
        bool counts;
    } cases[] = {{0.99f, 0.0f, false}, {0.0f, -1.0f, false}, {-1.01f, 0.0f, true},
                 {0.0f, 1.01f, true},  {0.71f, 0.71f, true}, {0.7f, -0.7f, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        begin_window();
        rotor.current = (ab_t){cases[n].alpha * TRIM_CURRENT_MIN, cases[n].beta * TRIM_CURRENT_MIN};
        const ab_t offset = steps(CONSTANT, WINDOW);
        expect_offset(cases[n].counts ? -0.05 * CONSTANT : 0.0, cases[n].counts ? ROUNDING : 0.0, offset);
    }
}

/* ---- limits, reset, new coefficients ---- */

static void test_each_component_stops_at_the_limit(void)
{
    begin_window_of(-4.1 + 0.9 * J);
    const ab_t offset = steps(-4.1 + 0.9 * J, 4 * WINDOW);
    TEST_ASSERT_EQUAL_FLOAT(TRIM_LIMIT, offset.alpha);
    TEST_ASSERT_FLOAT_WITHIN(4.0f * (float)ROUNDING, -0.18f, offset.beta);
    /* The trim leaves the limit at once, except for the half of a sample before the wrap: nothing has
     * accumulated beyond the limit. */
    const ab_t back = steps(1.0 + 3.0 * J, WINDOW);
    const float half = 0.05f * 0.5f * (1.0f + 4.1f) / (float)WINDOW;
    TEST_ASSERT_FLOAT_WITHIN((float)ROUNDING, TRIM_LIMIT - 0.05f + half, back.alpha);
    TEST_ASSERT_EQUAL_FLOAT(-TRIM_LIMIT, back.beta);
}

static void test_reset_takes_the_offset_and_forgets_the_window(void)
{
    begin_window();
    (void)steps(CONSTANT, WINDOW / 2);
    offset_trim_reset(&rotor.trim, (ab_t){0.02f, -0.01f});
    TEST_ASSERT_EQUAL_FLOAT(0.0f, rotor.trim.sum.alpha);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, rotor.trim.sum.beta);
    TEST_ASSERT_EQUAL_UINT32(0u, rotor.trim.count);
    /* The speed of that window does not count for the window that has begun either. */
    const ab_t offset = steps(CONSTANT, WINDOW + WINDOW / 2);
    TEST_ASSERT_EQUAL_FLOAT(0.02f, offset.alpha);
    TEST_ASSERT_EQUAL_FLOAT(-0.01f, offset.beta);
    /* The next result is added to the earlier one. */
    expect_offset(0.02 - 0.01 * J - 0.05 * CONSTANT, ROUNDING, steps(CONSTANT, WINDOW));
}

static void test_reset_leaves_nothing_of_before(void)
{
    const offset_trim_t fresh = rotor.trim;
    (void)steps(CONSTANT, WINDOW + WINDOW / 2);
    offset_trim_reset(&rotor.trim, NONE);
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &rotor.trim, sizeof fresh);
}
