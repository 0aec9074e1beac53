#include "fast/measure.h"
#include "math/trig.h"

#include "tests/unit/compare.h"

#define SETTLE 64u
/* Number of samples in the mean: a power of two, so that the mean of equal samples is exact. */
#define PERIODS 16

/* The range that a sensor may show is half a per cent smaller than its ends. */
#define MIDDLE (0.5f * (DRIVE_CURRENT_MAX + DRIVE_CURRENT_MIN))
#define RAIL   (0.995f * 0.5f * (DRIVE_CURRENT_MAX - DRIVE_CURRENT_MIN))

/* Without a sensor of its own c is the sum of two currents and may show three times as much. */
#define SHARE_C (DRIVE_CURRENT_SENSORS == 3 ? 1.0f : 3.0f)

static const ab_t NO_TRIM = {0.0f, 0.0f};

static params_t params;
static measure_t measure;
static measure_tuning_t tuning;
static drive_samples_t samples;

static void begin(void)
{
    tuning = measure_prepare(&params);
    memset(&measure, 0x55, sizeof measure);
    measure_init(&measure);
}

void setUp(void)
{
    params_defaults(&params);
    params.calibration_periods = PERIODS;
    params.current_offset_max = 0.5f;
    begin();
    samples = (drive_samples_t){.i_a = 2.0f,
                                .i_b = -0.5f,
                                .i_c = -1.5f,
                                .u_dc = 311.0f,
                                .sink_temperature = 40.0f,
                                .motor_temperature = 60.0f,
                                .encoder = 1234u,
                                .flags = DRIVE_SAMPLE_LATE};
}

static calibration_t calibrate(void)
{
    measure_step(&measure, &samples, NO_TRIM);
    return measure_calibrate(&measure, &tuning, &samples);
}

/* Runs the calibration from its beginning to its end with these samples. */
static calibration_t calibrate_all(void)
{
    for (uint32_t n = 1; n < SETTLE + PERIODS; n++) {
        TEST_ASSERT_EQUAL(CALIBRATION_GOES_ON, calibrate());
    }
    return calibrate();
}

static void currents(float a, float b, float c)
{
    samples.i_a = a;
    samples.i_b = b;
    samples.i_c = c;
}

static void expect_abc(float a, float b, float c, abc_t found)
{
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, a, found.a);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, b, found.b);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, c, found.c);
}

/* ---- samples to measurements ---- */

static void test_a_sample_becomes_a_measurement(void)
{
    measure_step(&measure, &samples, NO_TRIM);
    const measured_t *measured = &measure.measured;
    TEST_ASSERT_EQUAL_UINT32(1u, measured->good);
    expect_abc(2.0f, -0.5f, -1.5f, measured->current_abc);
    TEST_ASSERT_EQUAL_FLOAT(2.0f, measured->current.alpha);
    TEST_ASSERT_EQUAL_FLOAT(0.577350269f, measured->current.beta); /* (b - c)/sqrt(3) */
    TEST_ASSERT_EQUAL_FLOAT(311.0f, measured->u_dc);
    TEST_ASSERT_EQUAL_FLOAT(40.0f, measured->sink_temperature);
    TEST_ASSERT_EQUAL_FLOAT(60.0f, measured->motor_temperature);
    TEST_ASSERT_EQUAL_UINT32(1234u, measured->encoder_count);
    TEST_ASSERT_EQUAL_HEX32(DRIVE_SAMPLE_LATE, measured->flags);
}

static void test_offsets_are_removed(void)
{
    currents(0.25f, -0.125f, 0.375f);
    TEST_ASSERT_EQUAL(CALIBRATION_GOOD, calibrate_all());
    currents(2.25f, -0.625f, -1.125f);
    measure_step(&measure, &samples, NO_TRIM);
    expect_abc(2.0f, -0.5f, -1.5f, measure.measured.current_abc);
}

static void test_trim_is_removed_in_the_stationary_frame_alone(void)
{
    measure_step(&measure, &samples, (ab_t){0.5f, -0.25f});
    TEST_ASSERT_EQUAL_FLOAT(2.0f, measure.measured.current_abc.a);
    TEST_ASSERT_EQUAL_FLOAT(1.5f, measure.measured.current.alpha);
    TEST_ASSERT_EQUAL_FLOAT(0.577350269f + 0.25f, measure.measured.current.beta);
}

/* ---- invalid samples ---- */

/* Every analogue input, with the largest magnitude that it may show and the middle between its ends. */
static const struct {
    size_t offset;
    float middle;
    float limit;
} inputs[] = {
    {offsetof(drive_samples_t, i_a), MIDDLE, RAIL},
    {offsetof(drive_samples_t, i_b), MIDDLE, RAIL},
    {offsetof(drive_samples_t, i_c), MIDDLE, SHARE_C *RAIL},
    {offsetof(drive_samples_t, u_dc), 0.0f, 2000.0f - (40.0f + 60.0f)},
    {offsetof(drive_samples_t, sink_temperature), 0.0f, 2000.0f - (311.0f + 60.0f)},
    {offsetof(drive_samples_t, motor_temperature), 0.0f, 2000.0f - (311.0f + 40.0f)},
};

#define INPUTS (sizeof inputs / sizeof inputs[0])

static void expect_good_with(size_t input, float value, bool good)
{
    setUp();
    memcpy((char *)&samples + inputs[input].offset, &value, sizeof value);
    measure_step(&measure, &samples, NO_TRIM);
    TEST_ASSERT_EQUAL_UINT32(good ? 1u : 0u, measure.measured.good);
}

/* The limits follow from sums with three roundings. */
static void test_each_input_below_and_above_its_end(void)
{
    for (size_t n = 0; n < INPUTS; n++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const float end = (float)sign * inputs[n].limit;
            expect_good_with(n, inputs[n].middle + (1.0f - 2e-6f) * end, true);
            expect_good_with(n, inputs[n].middle + (1.0f + 2e-6f) * end, false);
            expect_good_with(n, inputs[n].middle + 100.0f * end, false);
        }
    }
}

static void test_no_temperature_sensor_is_no_error(void)
{
    samples.sink_temperature = DRIVE_NO_TEMPERATURE;
    samples.motor_temperature = DRIVE_NO_TEMPERATURE;
    measure_step(&measure, &samples, NO_TRIM);
    TEST_ASSERT_EQUAL_UINT32(1u, measure.measured.good);
}

/* If any input is invalid, all analogue values keep their last valid values; the digital values and the
 * trim are the present ones. */
static void test_a_bad_sample_keeps_the_last_good_values(void)
{
    for (size_t n = 0; n < INPUTS; n++) {
        const float bad = NAN;
        setUp();
        measure_step(&measure, &samples, NO_TRIM);
        const measured_t before = measure.measured;
        currents(-4.0f, 3.0f, 1.0f);
        samples.u_dc = 250.0f;
        samples.sink_temperature = 41.0f;
        samples.motor_temperature = 61.0f;
        samples.encoder = 1240u;
        samples.flags = DRIVE_SAMPLE_TRIPPED | DRIVE_SAMPLE_ENCODER;
        memcpy((char *)&samples + inputs[n].offset, &bad, sizeof bad);
        measure_step(&measure, &samples, (ab_t){0.5f, 0.0f});
        const measured_t *measured = &measure.measured;
        TEST_ASSERT_EQUAL_UINT32(0u, measured->good);
        TEST_ASSERT_EQUAL_MEMORY(&before.current_abc, &measured->current_abc, sizeof before.current_abc);
        TEST_ASSERT_EQUAL_FLOAT(before.current.alpha - 0.5f, measured->current.alpha);
        TEST_ASSERT_EQUAL_FLOAT(before.current.beta, measured->current.beta);
        TEST_ASSERT_EQUAL_FLOAT(311.0f, measured->u_dc);
        TEST_ASSERT_EQUAL_FLOAT(40.0f, measured->sink_temperature);
        TEST_ASSERT_EQUAL_FLOAT(60.0f, measured->motor_temperature);
        TEST_ASSERT_EQUAL_UINT32(1240u, measured->encoder_count);
        TEST_ASSERT_EQUAL_HEX32(DRIVE_SAMPLE_TRIPPED | DRIVE_SAMPLE_ENCODER, measured->flags);
    }
}

/* ---- calibration ---- */

/* The mean of 512 samples of a ramp (instead of the sixteen used elsewhere) is half its height, within 512
 * roundings of 0.4 A by 1.5e-8 each. The ramp spans half of what counts as a current. */
static void test_offsets_are_the_mean(void)
{
    params.calibration_periods = 512;
    begin();
    for (uint32_t n = 0; n < SETTLE; n++) {
        (void)calibrate();
    }
    calibration_t last = CALIBRATION_GOES_ON;
    for (uint32_t n = 0; n < 512u; n++) {
        TEST_ASSERT_EQUAL(CALIBRATION_GOES_ON, last);
        const float share = ((float)n + 0.5f) / 512.0f;
        const float ramp = 0.5f * MEASURE_QUIET * share;
        currents(ramp, -ramp, 0.2f - 0.5f * ramp);
        last = calibrate();
    }
    TEST_ASSERT_EQUAL(CALIBRATION_GOOD, last);
    const float mean = 0.25f * MEASURE_QUIET;
    expect_abc(mean, -mean, 0.2f - 0.5f * mean, measure.offset);
}

/* A rotor feeds the link from this sample of a calibration on: its current of twice the limit adds to the
 * offsets. Without it for a quarter or a half of the samples, these measure the offsets. If it flows
 * earlier, their error is the mean of the current, and the first block without a current has to replace
 * them. */
static void test_a_current_that_begins_in_a_calibration_leaves_the_offsets(void)
{
    static const struct {
        uint32_t from; /* [samples] */
        float error;   /* [-] of the current */
    } cases[] = {{0u, 1.0f}, {2u, 0.875f}, {3u, 0.8125f}, {4u, 0.0f}, {7u, 0.0f}, {8u, 0.0f}, {15u, 0.0f}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const float current = 2.0f * MEASURE_QUIET;
        calibration_t last = CALIBRATION_GOES_ON;
        params.current_offset_max = 4.0f * MEASURE_QUIET;
        begin();
        for (uint32_t k = 0; k < SETTLE + PERIODS; k++) {
            TEST_ASSERT_EQUAL(CALIBRATION_GOES_ON, last);
            const float more = k >= SETTLE + cases[n].from ? current : 0.0f;
            currents(0.1f + more, -0.05f - more, 0.0f);
            last = calibrate();
        }
        TEST_ASSERT_EQUAL(CALIBRATION_GOOD, last);
        const float error = cases[n].error * current;
        expect_abc(0.1f + error, -0.05f - error, 0.0f, measure.offset);
        TEST_ASSERT_EQUAL_UINT32(cases[n].from == 0u ? 0u : 1u, measure.rest.unsure);
    }
}

/* The number of the first of these interrupts at which they have been late too often; 0: never. `late` of
 * every `cycle` interrupts are late; the clock begins at `begin` [periods]. */
static uint32_t late_often_at(uint32_t late, uint32_t cycle, uint32_t begin)
{
    setUp();
    measure.late_until = begin;
    for (uint32_t n = 0; n < 10000u; n++) {
        const bool is_late = n % cycle < late;
        samples.flags = is_late ? DRIVE_SAMPLE_LATE | DRIVE_SAMPLE_TRIPPED : DRIVE_SAMPLE_TRIPPED;
        measure_step(&measure, &samples, NO_TRIM);
        if (is_late) {
            measure_late(&measure, begin + n);
        }
        const uint32_t often = measure.measured.flags & DRIVE_SAMPLE_LATE_OFTEN;
        TEST_ASSERT_EQUAL_HEX32(samples.flags, measure.measured.flags - often);
        if (often != 0u) {
            return n + 1u;
        }
    }
    return 0u;
}

/* A late interrupt adds 9 to the sum, which falls by 1 in each period, and 25 are too often: three in
 * succession make 9, 17 and 25; of two in three 9, 17, then 15 + 9, and 32 with the fifth; of every second
 * one 9, 16, 23 and 30 with the seventh; of one in eight 9, 10, and so on, 25 after 16 such cycles. One in
 * nine is never too often. The clock may pass its end. */
static void test_interrupts_that_are_late_too_often_are_marked(void)
{
    static const uint32_t begins[] = {0u, UINT32_MAX - 3u, UINT32_MAX / 2u};
    for (uint32_t n = 0; n < 3u; n++) {
        TEST_ASSERT_EQUAL_UINT32(3u, late_often_at(3u, 10u, begins[n]));
        TEST_ASSERT_EQUAL_UINT32(3u, late_often_at(1u, 1u, begins[n]));
        TEST_ASSERT_EQUAL_UINT32(5u, late_often_at(2u, 3u, begins[n]));
        TEST_ASSERT_EQUAL_UINT32(7u, late_often_at(1u, 2u, begins[n]));
        TEST_ASSERT_EQUAL_UINT32(129u, late_often_at(1u, 8u, begins[n]));
        TEST_ASSERT_EQUAL_UINT32(0u, late_often_at(1u, 9u, begins[n]));
        TEST_ASSERT_EQUAL_UINT32(0u, late_often_at(2u, 18u, begins[n]));
    }
}

/* A sum that has ended long ago, at any distance of the clock, does not count. */
static void test_a_late_interrupt_long_ago_is_forgotten(void)
{
    static const uint32_t later[] = {9u, 100u, UINT32_MAX / 2u, UINT32_MAX / 2u + 50u, UINT32_MAX - 100u};
    for (uint32_t n = 0; n < sizeof later / sizeof later[0]; n++) {
        setUp();
        measure_step(&measure, &samples, NO_TRIM);
        measure_late(&measure, 7u);
        measure_late(&measure, 8u);
        measure_late(&measure, 16u + later[n]);
        measure_late(&measure, 17u + later[n]);
        TEST_ASSERT_EQUAL_HEX32(0u, measure.measured.flags & DRIVE_SAMPLE_LATE_OFTEN);
        measure_late(&measure, 18u + later[n]);
        TEST_ASSERT_EQUAL_HEX32(DRIVE_SAMPLE_LATE_OFTEN, measure.measured.flags & DRIVE_SAMPLE_LATE_OFTEN);
    }
}

/* In the period of an invalid sample, a sensor within its range has its own value, here minus its offset of
 * 0.1, -0.2 and 0.1 A. Another one continues the line of the last two good samples: 3 and 4 A continue with 5
 * A, -1 and -1.5 A with -2 A, and -2 and -2.5 A with -3 A. Phase c without a sensor of its own always does.
 */
static void test_a_bad_sample_is_expected_on_the_line_of_the_others(void)
{
    static const struct {
        float a, b, c; /* [A] samples */
        abc_t three;   /* [A] expected, with three sensors */
    } cases[] = {{NAN, -7.0f, -2.2f, {5.0f, -6.8f, -2.3f}},
                 {-7.0f, 1e3f, -2.2f, {-7.1f, -2.0f, -2.3f}},
                 {4.0f, -7.0f, -1e3f, {3.9f, -6.8f, -3.0f}}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        measure.offset = (abc_t){0.1f, -0.2f, 0.1f};
        samples.i_a = 3.1f;
        samples.i_b = -1.2f;
        samples.i_c = -1.9f;
        measure_step(&measure, &samples, NO_TRIM);
        samples.i_a = 4.1f;
        samples.i_b = -1.7f;
        samples.i_c = -2.4f;
        measure_step(&measure, &samples, NO_TRIM);
        samples.i_a = cases[n].a;
        samples.i_b = cases[n].b;
        samples.i_c = cases[n].c;
        measure_step(&measure, &samples, NO_TRIM);
        TEST_ASSERT_EQUAL_UINT32(0u, measure.measured.good);
        const abc_t expected = measure_expected(&measure, &samples, 100.0f);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, cases[n].three.a, expected.a);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, cases[n].three.b, expected.b);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, DRIVE_CURRENT_SENSORS == 3 ? cases[n].three.c : -3.0f, expected.c);
    }
}

/* The last good samples are 3 and 4 A in phase a, -1 and -1.5 A in phase b. With a trip of 4.4 A, phase a has
 * left its control, 0.9 of the trip being 3.96 A: at the positive limit of its sensor the current has grown,
 * at the negative one the sensor is broken. With 4.5 A it may be under control, and the sensor is broken. */
static void test_a_sensor_that_was_near_the_trip_shows_a_current_beyond_its_range(void)
{
    const float limit = 1.01f * MEASURE_HALF;
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        for (int n = 3; n <= 4; n++) {
            samples.i_a = (float)(way * n);
            samples.i_b = (float)way * (0.5f - 0.5f * (float)n);
            samples.i_c = -samples.i_a - samples.i_b;
            measure_step(&measure, &samples, NO_TRIM);
        }
        const float high = MEASURE_MIDDLE + (float)way * limit;
        samples.i_a = high;
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, high, measure_expected(&measure, &samples, 4.4f).a);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, (float)way * 5.0f, measure_expected(&measure, &samples, 4.5f).a);
        samples.i_a = MEASURE_MIDDLE - (float)way * limit;
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, (float)way * 5.0f, measure_expected(&measure, &samples, 4.4f).a);
        samples.i_a = NAN;
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, (float)way * 5.0f, measure_expected(&measure, &samples, 4.4f).a);
    }
}

/* Sensors at opposite limits show a current that flows from one phase to another. Two at the same limit have
 * lost their supply: the line of the last samples continues. */
static void test_sensors_at_opposite_limits_show_a_current(void)
{
    const float limit = 1.01f * MEASURE_HALF;
    for (int way = -1; way <= 1; way += 2) {
        const float high = MEASURE_MIDDLE + (float)way * limit;
        const float low = MEASURE_MIDDLE - (float)way * limit;
        setUp();
        measure.offset = (abc_t){0.1f, -0.2f, 0.1f};
        samples.i_a = high;
        samples.i_b = low;
        samples.i_c = -0.5f;
        const abc_t flows = measure_expected(&measure, &samples, 100.0f);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, high - 0.1f, flows.a);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, low + 0.2f, flows.b);
        samples.i_b = high;
        const abc_t broken = measure_expected(&measure, &samples, 100.0f);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, broken.a);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, broken.b);
        samples.i_b = 2.0f;
        samples.i_c = low;
        const abc_t other = measure_expected(&measure, &samples, 100.0f);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, DRIVE_CURRENT_SENSORS == 3 ? high - 0.1f : 0.0f, other.a);
    }
}

/* Bad samples are neither counted nor averaged, in the settling and after it: if every third sample is
 * bad, the calibration takes 1.5 times as long. */
static void test_bad_samples_are_left_out(void)
{
    calibration_t last = CALIBRATION_GOES_ON;
    uint32_t good = 0;
    for (uint32_t n = 0; n < 1000u && last == CALIBRATION_GOES_ON; n++) {
        const bool bad = n % 3u == 0u;
        currents(bad ? NAN : 0.25f, bad ? 11.0f : -0.125f, 0.0f);
        last = calibrate();
        good += bad ? 0u : 1u;
    }
    TEST_ASSERT_EQUAL(CALIBRATION_GOOD, last);
    TEST_ASSERT_EQUAL_UINT32(SETTLE + PERIODS, good);
    TEST_ASSERT_EQUAL_FLOAT(0.25f, measure.offset.a);
    TEST_ASSERT_EQUAL_FLOAT(-0.125f, measure.offset.b);
}

/* An offset at the limit is too large; one below it is accepted. */
static void test_each_sensor_fails_at_its_limit_in_either_sign(void)
{
    for (int phase = 0; phase < 3; phase++) {
        const float limit = phase == 2 ? SHARE_C * 0.5f : 0.5f;
        for (int sign = -1; sign <= 1; sign += 2) {
            static const float shares[] = {0.9999f, 1.0f, 1.0001f};
            for (int n = 0; n < 3; n++) {
                const float offset = (float)sign * shares[n] * limit;
                setUp();
                currents(phase == 0 ? offset : 0.0f, phase == 1 ? offset : 0.0f, phase == 2 ? offset : 0.0f);
                TEST_ASSERT_EQUAL(n == 0 ? CALIBRATION_GOOD : CALIBRATION_FAILED, calibrate_all());
            }
        }
    }
}

/* A normally distributed number with SD 1, as the sum of twelve uniformly distributed ones. */
static float normal(void)
{
    static uint32_t state = 12345u;
    float sum = -6.0f;
    for (uint32_t n = 0; n < 12u; n++) {
        state = state * UINT32_C(1664525) + UINT32_C(1013904223);
        sum += (float)(state >> 8) * (1.0f / 16777216.0f);
    }
    return sum;
}

/* A variance that is measured with 256 pairs of differences is right within about 20 %. */
static void test_sensors_that_scatter_too_much_are_noisy(void)
{
    static const float shares[] = {0.3f, 0.8f, 1.2f, 4.0f};
    params.calibration_periods = 256;
    tuning = measure_prepare(&params);
    for (uint32_t n = 0; n < 4u; n++) {
        const float deviation = shares[n] * MEASURE_NOISY;
        calibration_t last = CALIBRATION_GOES_ON;
        measure_begin_calibration(&measure);
        while (last == CALIBRATION_GOES_ON) {
            const float a = deviation * normal();
            const float b = deviation * normal();
            currents(a, b, -a - b);
            last = calibrate();
        }
        TEST_ASSERT_EQUAL(n < 2u ? CALIBRATION_GOOD : CALIBRATION_NOISY, last);
        /* of N squares of a normal variable the mean scatters by (2/N)^(1/2), here of some 1000 */
        TEST_ASSERT_FLOAT_WITHIN(0.25f * deviation * deviation, deviation * deviation,
                                 measure_noise(&measure));
    }
}

/* The current that a rotor drives through the diodes, up to 0.5 rad per sample; its mean over the
 * calibration is small. */
static void test_a_current_is_no_noise(void)
{
    params.calibration_periods = 256;
    params.current_offset_max = 4.0f;
    tuning = measure_prepare(&params);
    for (uint32_t n = 1; n <= 10u; n++) {
        const rotation_t step = trig_rotation(0.05f * (float)n);
        calibration_t last = CALIBRATION_GOES_ON;
        ab_t current = {8.0f, 0.0f};
        measure_begin_calibration(&measure);
        while (last == CALIBRATION_GOES_ON) {
            const abc_t phases = frames_inverse_clarke(current);
            currents(phases.a, phases.b, phases.c);
            last = calibrate();
            current = frames_inverse_park((dq_t){current.alpha, current.beta}, step);
        }
        TEST_ASSERT_EQUAL(CALIBRATION_GOOD, last);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, measure_noise(&measure));
    }
}

static void test_a_calibration_begins_again(void)
{
    currents(0.25f, -0.125f, 0.375f);
    TEST_ASSERT_EQUAL(CALIBRATION_GOOD, calibrate_all());
    measure_begin_calibration(&measure);
    TEST_ASSERT_EQUAL_FLOAT(0.25f, measure.offset.a); /* the last known offset */
    currents(-0.0625f, 0.25f, 0.125f);
    TEST_ASSERT_EQUAL(CALIBRATION_GOOD, calibrate_all());
    expect_abc(-0.0625f, 0.25f, 0.125f, measure.offset);
}
