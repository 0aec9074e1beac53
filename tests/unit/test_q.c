/* Integer arithmetic compared with 128-bit integers and the double library. Small domains are tested
 * exhaustively, others by a dense sweep and random numbers with a fixed seed. */
#include "math/filter_q.h"
#include "math/frames_q.h"
#include "math/q.h"
#include "math/root_q.h"
#include "math/tanh_q.h"
#include "math/trig_q.h"
#include "tests/unit/compare.h"

#define TURN 4294967296.0

static uint64_t seed;

void setUp(void)
{
    seed = UINT64_C(2026);
}

static uint64_t draw(void)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (seed >> 32) | (seed << 32);
}

/* A random number of any size and either sign. */
static int64_t draw_signed(void)
{
    uint64_t bits = draw() >> (draw() % 64u);
    int64_t positive = (int64_t)(bits >> 1);
    return draw() % 2u ? -positive : positive;
}

static int32_t draw_short(void)
{
    return (int32_t)(draw_signed() % INT64_C(0x80000000));
}

/* The floor of x/2^n by division, which C defines. */
static int64_t floor_by_division(int64_t x, int32_t n)
{
    int64_t divisor = INT64_C(1) << n;
    int64_t quotient = x / divisor;
    return quotient - (x % divisor < 0);
}

static void test_floor_is_that_of_division(void)
{
    static const int64_t edges[] = {0, 1, -1, 2, -2, INT64_MAX, INT64_MIN, INT64_MIN + 1, INT64_MAX - 1};
    for (int32_t n = 1; n <= 62; n++) {
        for (unsigned m = 0; m < sizeof edges / sizeof edges[0]; m++) {
            TEST_ASSERT_EQUAL_INT64(floor_by_division(edges[m], n), q_floor(edges[m], n));
            TEST_ASSERT_EQUAL_INT64(floor_by_division(edges[m], n), q_floor_raised(edges[m], n));
        }
        for (int m = 0; m < 2000; m++) {
            int64_t x = draw_signed();
            TEST_ASSERT_EQUAL_INT64(floor_by_division(x, n), q_floor(x, n));
            TEST_ASSERT_EQUAL_INT64(floor_by_division(x, n), q_floor_raised(x, n));
        }
    }
}

static void test_round_goes_to_the_nearest_halves_up(void)
{
    static const struct {
        int64_t x;
        int32_t n;
        int64_t expected;
    } rows[] = {{3, 1, 2},   {-3, 1, -1}, {1, 1, 1},   {-1, 1, 0},  {5, 2, 1},    {6, 2, 2},
                {-5, 2, -1}, {-6, 2, -1}, {-7, 2, -2}, {127, 8, 0}, {-128, 8, 0}, {-129, 8, -1}};
    for (unsigned m = 0; m < sizeof rows / sizeof rows[0]; m++) {
        TEST_ASSERT_EQUAL_INT64(rows[m].expected, q_round(rows[m].x, rows[m].n));
    }
}

static void test_saturation_is_symmetric(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, q_saturate(INT64_C(0x7fffffff)));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, q_saturate(INT64_C(0x80000000)));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, q_saturate(INT64_MAX));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, q_saturate(-INT64_C(0x7fffffff)));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, q_saturate(-INT64_C(0x80000000)));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, q_saturate(INT64_MIN));
    TEST_ASSERT_EQUAL_INT32(-5, q_saturate(-5));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, q_add(INT32_MAX, 1));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, q_subtract(-INT32_MAX, 2));
    TEST_ASSERT_EQUAL_INT32(7, q_clamp(9, 7));
    TEST_ASSERT_EQUAL_INT32(-7, q_clamp(INT32_MIN, 7));
    TEST_ASSERT_EQUAL_INT64(-7, q_clamp_long(INT64_MIN, 7));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, q_magnitude(INT32_MIN));
    TEST_ASSERT_EQUAL_INT32(3, q_magnitude(-3));
}

static void test_products_keep_all_their_bits(void)
{
    TEST_ASSERT_EQUAL_INT64(INT64_C(4611686018427387904), q_product(INT32_MIN, INT32_MIN));
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(0x7ffffffe00000002), q_square_sum(INT32_MIN, INT32_MAX));
    for (int m = 0; m < 100000; m++) {
        int32_t a = draw_short();
        int32_t b = draw_short();
        TEST_ASSERT_DOUBLE_WITHIN(0.5000001, (double)a * b / 2147483648.0, (double)q_multiply(a, b, 31));
    }
}

static void test_upper_words_are_those_of_division(void)
{
    const int64_t word = INT64_C(1) << 32;
    for (int m = 0; m < 100000; m++) {
        int32_t a = draw_short();
        int32_t b = draw_short();
        int64_t product = (int64_t)a * b;
        TEST_ASSERT_EQUAL_INT32(floor_by_division(product, 32), q_high(a, b));
        TEST_ASSERT_EQUAL_INT32(floor_by_division(product + word / 2, 32), q_high_near(a, b));
        TEST_ASSERT_EQUAL_INT32(product / word, q_word(product));
        TEST_ASSERT_EQUAL_UINT32(((uint64_t)(uint32_t)a * (uint32_t)b) / (uint64_t)word,
                                 q_high_unsigned((uint32_t)a, (uint32_t)b));
        TEST_ASSERT_EQUAL_INT64(product, q_join((int32_t)floor_by_division(product, 32), product));
    }
    TEST_ASSERT_EQUAL_INT32(-1, q_high(-1, 1));
    TEST_ASSERT_EQUAL_INT32(0, q_high_near(-1, 1));
    TEST_ASSERT_EQUAL_INT32(0, q_word(-word + 1));
    TEST_ASSERT_EQUAL_INT32(-1, q_word(-word));
}

/* Within the range the result is the rounded value, beyond it a number within the last step of the upper
 * word. */
static void test_cut_rounds_within_and_ends_beyond(void)
{
    for (int32_t n = 4; n <= 30; n++) {
        for (int32_t bits = 32 - n; bits <= 30; bits++) {
            int64_t end = INT64_C(1) << bits;
            int64_t step = INT64_C(1) << (32 - n);
            for (int m = 0; m < 200; m++) {
                int64_t x = draw_signed() / 2;
                int64_t near = q_round(x, n);
                int64_t found = q_cut(x, n, bits);
                if (near >= -end && near < end) {
                    TEST_ASSERT_EQUAL_INT64(near, found);
                } else {
                    TEST_ASSERT_TRUE(near < 0 ? found >= -end && found < -end + step
                                              : found < end && found >= end - step);
                }
            }
            TEST_ASSERT_EQUAL_INT64(-end, q_cut(-end * (INT64_C(1) << n), n, bits));
            TEST_ASSERT_EQUAL_INT64(end - 1, q_cut((end - 1) * (INT64_C(1) << n), n, bits));
            TEST_ASSERT_EQUAL_INT64(end - step, q_cut(end * (INT64_C(1) << n), n, bits));
        }
    }
}

static void test_signed_angle_is_the_same_angle(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, q_signed(UINT32_C(0x80000000)));
    TEST_ASSERT_EQUAL_INT32(-1, q_signed(UINT32_C(0xffffffff)));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, q_signed(UINT32_C(0x7fffffff)));
    for (int m = 0; m < 10000; m++) {
        uint32_t angle = (uint32_t)draw();
        TEST_ASSERT_EQUAL_UINT32(angle, (uint32_t)q_signed(angle));
    }
}

static void test_leading_zeros_of_every_bit(void)
{
    TEST_ASSERT_EQUAL_INT32(63, q_leading_zeros(0));
    for (int32_t bit = 0; bit < 64; bit++) {
        uint64_t x = UINT64_C(1) << bit;
        TEST_ASSERT_EQUAL_INT32(63 - bit, q_leading_zeros(x));
        TEST_ASSERT_EQUAL_INT32(63 - bit, q_leading_zeros(x | (x - 1u)));
    }
}

/* Tests all values of the first 20 bits at every size. */
static void test_inverse_root_is_within_its_bound(void)
{
    double worst = 0.0;
    double worst_root = 0.0;
    for (int32_t shift = 0; shift < 62; shift++) {
        for (uint64_t m = 0; m < 3000; m++) {
            uint64_t square = ((UINT64_C(1) << 62) + (draw() >> 2) * 3u / 1u) >> shift;
            square = m % 2u ? square : ((UINT64_C(1) << 62) + m * (UINT64_C(1) << 50)) >> shift;
            square = square < ROOT_Q_SMALLEST ? ROOT_Q_SMALLEST : square;
            root_q_t root = inverse_root_q(square);
            TEST_ASSERT_TRUE(root.shift >= 0 && root.shift <= 30);
            TEST_ASSERT_TRUE(root.mantissa >= (INT32_C(1) << 29) && root.mantissa <= (INT32_C(1) << 30));
            double value = ldexp((double)root.mantissa, (int)root.shift - 61);
            worst = fmax(worst, fabs(value * sqrt((double)square) - 1.0));
            double exact = sqrt((double)square);
            double off = fabs((double)root_q(square) - exact) - 1.0;
            worst_root = fmax(worst_root, off / exact);
        }
    }
    check_below(worst, 2e-8, "1/sqrt");
    check_below(worst_root, 2e-8, "sqrt beyond one unit");
}

/* The limit is 2e-8 of the reciprocal, plus half a unit. */
static void test_quotient_is_within_its_bound(void)
{
    double worst = 0.0;
    for (int m = 0; m < 200000; m++) {
        int32_t x = draw_short();
        int32_t value = q_magnitude(draw_short());
        int32_t n = (int32_t)(draw() % 31u);
        value = value < 2 ? 2 : value;
        int32_t found = quotient_q(x, reciprocal_q(value), n);
        double exact = ldexp((double)x / (double)value, (int)n);
        if (fabs(exact) * (1.0 + 2e-8) >= (double)Q_LARGEST) {
            TEST_ASSERT_INT32_WITHIN(64, x < 0 ? -Q_LARGEST : Q_LARGEST, found);
        } else {
            double off = fmax(0.0, fabs((double)found - exact) - 0.5);
            worst = fmax(worst, off > 0.0 ? off / fabs(exact) : 0.0);
        }
    }
    check_below(worst, 2e-8, "quotient beyond half a unit");
    TEST_ASSERT_EQUAL_INT32(-Q_LARGEST, quotient_q(-Q_LARGEST, reciprocal_q(2), 30));
    TEST_ASSERT_EQUAL_INT32(0, quotient_q(0, reciprocal_q(2), 30));
}

/* Tests every 2^-16 up to 2, then steps of 2^-16 of the value. */
static void test_tanh_ratio_is_within_its_bound(void)
{
    double worst[3] = {0.0, 0.0, 0.0};
    int32_t before = INT32_C(1) << 30;
    TEST_ASSERT_EQUAL_INT32(before, tanh_ratio_q(0));
    for (double z = 1.0 / 65536.0; z < 1e6; z += fmax(1.0, z) / 65536.0) {
        uint64_t square = (uint64_t)ldexp(z, TANH_Q_SQUARE);
        double x = sqrt(ldexp((double)square, -TANH_Q_SQUARE));
        int32_t found = tanh_ratio_q(square);
        double unit = 1.0 / 1073741824.0;
        double off = fmax(0.0, fabs((double)found * unit - tanh(x) / x) - 2.0 * unit) * x / tanh(x);
        int part = z < 2.0 ? 0 : (z < 64.0 ? 1 : 2);
        worst[part] = fmax(worst[part], off);
        /* The ratio decreases, except for the seams of the parabolas and the rounding. */
        TEST_ASSERT_TRUE((double)found <= (double)before * (1.0 + 4e-7));
        before = found;
    }
    check_below(worst[0], 8e-7, "tanh(x)/x below 2");
    check_below(worst[1], 7e-7, "tanh(x)/x below 64");
    check_below(worst[2], 3e-7, "tanh(x)/x beyond");
    TEST_ASSERT_TRUE(tanh_ratio_q(UINT64_MAX) > 0);
}

static void test_rotation_is_within_its_bound(void)
{
    double worst = 0.0;
    for (uint64_t n = 0; n < (UINT64_C(1) << 32); n += 2039u) {
        rotation_q_t found = trig_rotation_q((uint32_t)n);
        double angle = 2.0 * PI * (double)n / TURN;
        worst = fmax(worst, fabs((double)found.sin / 1073741824.0 - sin(angle)));
        worst = fmax(worst, fabs((double)found.cos / 1073741824.0 - cos(angle)));
    }
    check_below(worst, 6e-9, "sine and cosine");
}

static void test_rotation_is_exact_at_quarters_and_symmetric(void)
{
    static const int32_t one = INT32_C(1) << 30;
    static const int32_t sines[] = {0, 1, 0, -1};
    for (uint32_t n = 0; n < 4u; n++) {
        rotation_q_t found = trig_rotation_q(n << 30);
        TEST_ASSERT_EQUAL_INT32(one * sines[n], found.sin);
        TEST_ASSERT_EQUAL_INT32(one * sines[(n + 1u) % 4u], found.cos);
    }
    for (int m = 0; m < 100000; m++) {
        uint32_t angle = (uint32_t)draw();
        rotation_q_t found = trig_rotation_q(angle);
        rotation_q_t opposite = trig_rotation_q(angle + UINT32_C(0x80000000));
        TEST_ASSERT_EQUAL_INT32(-found.sin, opposite.sin);
        TEST_ASSERT_EQUAL_INT32(-found.cos, opposite.cos);
        rotation_q_t back = trig_rotation_q(0u - angle);
        TEST_ASSERT_EQUAL_INT32(-found.sin, back.sin);
        TEST_ASSERT_EQUAL_INT32(found.cos, back.cos);
    }
}

static double apart(uint32_t a, uint32_t b)
{
    return fabs((double)q_signed(a - b)) * 2.0 * PI / TURN;
}

/* Vectors of every size and direction: the length, and the first component divided by it. */
static void test_direction_is_within_its_bound(void)
{
    double worst_length = 0.0;
    double worst_cosine = 0.0;
    for (int m = 0; m < 1000000; m++) {
        double length = ldexp(64.0, m % 24) * (1.0 + (double)(draw() & 0xffffu) / 65536.0);
        double angle = 2.0 * PI * (double)(draw() & 0xffffffu) / 16777216.0;
        int32_t x = (int32_t)lrint(length * cos(angle));
        int32_t y = (int32_t)lrint(length * sin(angle));
        x = q_clamp(x, (INT32_C(1) << 30) - 1);
        y = q_clamp(y, (INT32_C(1) << 30) - 1);
        length = hypot((double)x, (double)y);
        direction_q_t found = direction_q(x, y);
        worst_length = fmax(worst_length, (fabs((double)found.length - length) - 1.0) / length);
        worst_cosine = fmax(worst_cosine, fabs((double)found.cosine / 1073741824.0 - (double)x / length) -
                                              2.0 / 1073741824.0);
    }
    check_below(worst_length, 2e-8, "length beyond one unit");
    check_below(worst_cosine, 2e-8, "cosine beyond two units");
}

static void test_arc_tangent_is_within_its_bound(void)
{
    double worst = 0.0;
    for (uint64_t n = 0; n < (UINT64_C(1) << 32); n += 40009u) {
        double angle = 2.0 * PI * (double)n / TURN;
        int32_t y = (int32_t)lrint(2147483000.0 * sin(angle));
        int32_t x = (int32_t)lrint(2147483000.0 * cos(angle));
        worst = fmax(worst, apart(trig_atan2_q(y, x), (uint32_t)n));
    }
    check_below(worst, 1.2e-7, "arc tangent");
}

static void test_arc_tangent_at_the_edges(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, trig_atan2_q(0, 0));
    TEST_ASSERT_EQUAL_UINT32(0, trig_atan2_q(0, 5));
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x80000000), trig_atan2_q(0, -5));
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x40000000), trig_atan2_q(7, 0));
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0xc0000000), trig_atan2_q(-7, 0));
    TEST_ASSERT_TRUE(apart(trig_atan2_q(INT32_MIN, INT32_MIN), UINT32_C(0xa0000000)) < 1.2e-7);
}

static void test_park_turns(void)
{
    /* 30 degrees */
    rotation_q_t angle = trig_rotation_q(UINT32_C(0x15555555));
    dq_q_t found = frames_park_q((ab_q_t){1000000, 2000000}, angle);
    TEST_ASSERT_INT32_WITHIN(1, 1866025, found.d); /* 1e6 cos 30 + 2e6 sin 30 */
    TEST_ASSERT_INT32_WITHIN(1, 1232051, found.q); /* 2e6 cos 30 - 1e6 sin 30 */
    /* The longest vector that fits: 2^30 (1 + 1)/sqrt 2 along d. */
    rotation_q_t eighth = trig_rotation_q(UINT32_C(0x20000000));
    const int32_t most = INT32_C(1) << 30;
    found = frames_park_q((ab_q_t){most, most}, eighth);
    TEST_ASSERT_INT32_WITHIN(4, INT32_C(1518500250), found.d);
    TEST_ASSERT_INT32_WITHIN(4, 0, found.q);
    TEST_ASSERT_INT32_WITHIN(4, INT32_C(-1518500250), frames_park_q((ab_q_t){-most, -most}, eighth).d);
}

/* Even with the smallest coefficient the filter reaches its input without a dead zone: 1 - (1 - 2^-20)^n
 * of 1000 counts. */
static void test_filter_has_no_dead_zone(void)
{
    lowpass_q_t filter = {.alpha = INT32_C(1) << 11};
    lowpass_reset_q(&filter, 0);
    for (int32_t n = 0; n < (INT32_C(1) << 24); n++) {
        (void)lowpass_step_q(&filter, 1000);
    }
    TEST_ASSERT_EQUAL_INT32(1000, lowpass_value_q(&filter));
    lowpass_reset_q(&filter, -7);
    TEST_ASSERT_EQUAL_INT32(-7, lowpass_value_q(&filter));
}

static void test_filter_follows_its_exponential(void)
{
    lowpass_q_t filter = {.alpha = INT32_C(21474836)}; /* 0.01 */
    lowpass_reset_q(&filter, 0);
    for (int n = 1; n <= 1000; n++) {
        double expected = 1e9 * (1.0 - pow(1.0 - 21474836.0 / 2147483648.0, n));
        TEST_ASSERT_DOUBLE_WITHIN(2.0, expected, (double)lowpass_step_q(&filter, 1000000000));
    }
}
