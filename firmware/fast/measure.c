#include "fast/measure.h"

#include <string.h>

#include "math/bounds.h"
#include "math/filter.h"

#define SETTLE_PERIODS 64u    /* [periods] after the start before offsets are averaged */
#define RECENT_SHARE   0.015f /* [-] weight of a sample in the low-pass of the sensors' values, 7 ms */
#define UNSURE_SHARE   0.25f  /* [-] of MEASURE_MOVED: largest error of unsure offsets at a start */

/* [periods] A current that flows changes by more than MEASURE_QUIET within this time; offsets step less
 * often. */
#define FLOWS_PERIODS 128u

measure_tuning_t measure_prepare(const params_t *params)
{
    return (measure_tuning_t){
        .weight = 1.0f / (float)params->calibration_periods,
        .periods = SETTLE_PERIODS + (uint32_t)params->calibration_periods,
        .offset_max = params->current_offset_max,
    };
}

void measure_init(measure_t *measure)
{
    memset(measure, 0, sizeof *measure);
}

void measure_begin_calibration(measure_t *measure)
{
    measure->calibrated = 0u;
    measure_begin_rest(measure);
}

static void widen(float value, float *smallest, float *largest)
{
    *smallest = value < *smallest ? value : *smallest;
    *largest = value > *largest ? value : *largest;
}

/* Adds a sample to a block, or begins a block with it. */
static void collect(measure_rest_t *rest, const drive_samples_t *samples, float weight, bool first)
{
    const abc_t now = {samples->i_a, samples->i_b, samples->i_c};
    if (first) {
        rest->mean = (abc_t){0.0f, 0.0f, 0.0f};
        rest->smallest = now;
        rest->largest = now;
    }
    rest->mean.a += weight * now.a;
    rest->mean.b += weight * now.b;
    rest->mean.c += weight * now.c;
    widen(now.a, &rest->smallest.a, &rest->largest.a);
    widen(now.b, &rest->smallest.b, &rest->largest.b);
    widen(now.c, &rest->smallest.c, &rest->largest.c);
}

/* true: no current flowed in this block. */
static bool is_quiet(const measure_rest_t *rest)
{
    return rest->largest.a - rest->smallest.a <= MEASURE_QUIET &&
           rest->largest.b - rest->smallest.b <= MEASURE_QUIET &&
           rest->largest.c - rest->smallest.c <= MEASURE_C_SHARE * MEASURE_QUIET;
}

/* Compares offsets [A] with the limit of the sensors. */
static calibration_t judged(const measure_tuning_t *tuning, abc_t offset)
{
    const float limit = tuning->offset_max;
    return bounds_within(offset.a, limit) && bounds_within(offset.b, limit) &&
                   bounds_within(offset.c, MEASURE_C_SHARE * limit)
               ? CALIBRATION_GOOD
               : CALIBRATION_FAILED;
}

static float square_sum(float one, float other)
{
    return one * one + other * other;
}

/* Adds a sample to the scatter, or begins with it. */
static void add_scatter(measure_noise_t *noise, const drive_samples_t *samples, float weight, bool first)
{
    const float a = samples->i_a;
    const float b = samples->i_b;
    if (first) {
        *noise = (measure_noise_t){.a = {a, a}, .b = {b, b}};
    }
    noise->step += weight * square_sum(a - noise->a[0], b - noise->b[0]);
    noise->leap += weight * square_sum(a - noise->a[1], b - noise->b[1]);
    noise->a[1] = noise->a[0];
    noise->b[1] = noise->b[0];
    noise->a[0] = a;
    noise->b[0] = b;
}

/* White noise of two sensors has a `step` of four times its variance and an equal `leap`; a current that is
 * sampled finely has a `leap` of four times its `step`. */
static bool is_white(const measure_noise_t *noise)
{
    return noise->leap < 2.0f * noise->step;
}

/* Keeps the mean of a block of which this number of samples has been collected: at a quarter, at a half and
 * at the end, while no current has flowed. A current that begins later, because a load drives the rotor until
 * its EMF exceeds the link, does not change the offsets then. One that flows from the beginning does. */
static void keep_mean(measure_t *measure, uint32_t collected, uint32_t whole)
{
    measure_rest_t *rest = &measure->rest;
    const bool ends = collected == whole;
    const float share = ends ? 1.0f : collected == whole >> 1 ? 2.0f : collected == whole >> 2 ? 4.0f : 0.0f;
    const bool none = ends && rest->found == (int32_t)CALIBRATION_GOES_ON;
    if (share != 0.0f && (none || is_quiet(rest))) {
        measure->offset = (abc_t){share * rest->mean.a, share * rest->mean.b, share * rest->mean.c};
        rest->found = (int32_t)CALIBRATION_GOOD;
    }
}

calibration_t measure_calibrate(measure_t *measure, const measure_tuning_t *tuning,
                                const drive_samples_t *samples)
{
    measure_rest_t *rest = &measure->rest;
    if (measure->calibrated == 0u) {
        measure->offset = (abc_t){0.0f, 0.0f, 0.0f};
    }
    if (measure->measured.good == 0u) {
        return CALIBRATION_GOES_ON;
    }
    if (measure->calibrated >= SETTLE_PERIODS) {
        collect(rest, samples, tuning->weight, measure->calibrated == SETTLE_PERIODS);
        add_scatter(&measure->noise, samples, tuning->weight, measure->calibrated == SETTLE_PERIODS);
        keep_mean(measure, measure->calibrated + 1u - SETTLE_PERIODS, tuning->periods - SETTLE_PERIODS);
    }
    measure->calibrated++;
    if (measure->calibrated < tuning->periods) {
        return CALIBRATION_GOES_ON;
    }
    rest->unsure = is_quiet(rest) ? 0u : 1u;
    measure->noise.step = is_white(&measure->noise) ? measure->noise.step : 0.0f;
    return measure_noise(measure) > MEASURE_NOISY * MEASURE_NOISY ? CALIBRATION_NOISY
                                                                  : judged(tuning, measure->offset);
}

void measure_begin_rest(measure_t *measure)
{
    measure->rest.periods = 0u;
    measure->rest.flows = 0u;
    measure->rest.recent = (ab_t){0.0f, 0.0f};
    measure->rest.found = (int32_t)CALIBRATION_GOES_ON;
}

static bool is_longer(ab_t vector, float length)
{
    return vector.alpha * vector.alpha + vector.beta * vector.beta > length * length;
}

/* true: the mean of this block differs from the known offsets and trim by more than MEASURE_MOVED. */
static bool has_moved(const measure_t *measure, ab_t trim)
{
    const abc_t mean = measure->rest.mean;
    const abc_t offset = measure->offset;
    const ab_t left = frames_clarke((abc_t){mean.a - offset.a, mean.b - offset.b, mean.c - offset.c});
    return is_longer((ab_t){left.alpha - trim.alpha, left.beta - trim.beta}, MEASURE_MOVED);
}

calibration_t measure_found(const measure_t *measure)
{
    const measure_rest_t *rest = &measure->rest;
    const calibration_t found = (calibration_t)rest->found;
    const float most = rest->unsure != 0u ? UNSURE_SHARE * MEASURE_MOVED : MEASURE_MOVED;
    const bool due = found != CALIBRATION_FAILED && rest->flows == 0u && is_longer(rest->recent, most);
    return due ? CALIBRATION_DUE : found;
}

/* Adds a sample to the block. After a step of the offsets the earlier samples are useless, and the block
 * begins again with this sample. A current that flows makes the block begin again repeatedly. */
static void add(measure_rest_t *rest, const drive_samples_t *samples, float weight)
{
    collect(rest, samples, weight, rest->periods == SETTLE_PERIODS + 1u);
    const uint32_t lasted = rest->periods - SETTLE_PERIODS;
    if (!is_quiet(rest)) {
        rest->flows = lasted <= FLOWS_PERIODS ? UINT32_C(1) : UINT32_C(0);
        rest->periods = SETTLE_PERIODS + 1u;
        rest->again = 1u;
        collect(rest, samples, weight, true);
    } else if (lasted > FLOWS_PERIODS) {
        rest->flows = 0u;
    }
}

bool measure_rest(measure_t *measure, const measure_tuning_t *tuning, const drive_samples_t *samples,
                  ab_t trim)
{
    measure_rest_t *rest = &measure->rest;
    if (measure->measured.good == 0u) {
        return false;
    }
    rest->periods++;
    if (rest->periods <= SETTLE_PERIODS) {
        return false;
    }
    const ab_t now = measure->measured.current;
    rest->recent.alpha = lowpass_step(rest->recent.alpha, RECENT_SHARE, now.alpha);
    rest->recent.beta = lowpass_step(rest->recent.beta, RECENT_SHARE, now.beta);
    add(rest, samples, tuning->weight);
    if (rest->periods < tuning->periods) {
        return false;
    }
    rest->periods = SETTLE_PERIODS;
    const calibration_t found = judged(tuning, rest->mean);
    rest->found = (int32_t)found;
    const bool moved = has_moved(measure, trim);
    const bool again = rest->again != 0u;
    rest->again = 0u;
    if (found != CALIBRATION_GOOD || (rest->unsure == 0u && !moved)) {
        return false;
    }
    measure->offset = rest->mean;
    rest->recent = (ab_t){0.0f, 0.0f};
    /* after a step within this block its mean lies between both values, and a current may have flowed in a
     * block that began again */
    rest->unsure = moved || again ? UINT32_C(1) : UINT32_C(0);
    return true;
}

/* [-] of overcurrent_trip: a current beyond this has already left its control, which holds it below
 * current_limit. */
#define NEAR_TRIP 0.9f

/* Range of phase c's own sensor around the middle [A]; without one, no value is within it. */
#define C_HALF (DRIVE_CURRENT_SENSORS == 3 ? MEASURE_HALF : -1.0f)

/* Phase c counts if it has a sensor of its own [-]. */
#define C_COUNTS (DRIVE_CURRENT_SENSORS == 3 ? 1.0f : 0.0f)

static float expected(float sample, float half, float offset, float last, float before, float trip)
{
    const float beyond = sample - MEASURE_MIDDLE;
    const bool grows = !bounds_within(last, NEAR_TRIP * trip) && beyond * last > 0.0f;
    return grows || bounds_within(beyond, half) ? sample - offset : 2.0f * last - before;
}

abc_t measure_expected(const measure_t *measure, const drive_samples_t *samples, float trip)
{
    const abc_t offset = measure->offset;
    const abc_t last = measure->measured.current_abc;
    const abc_t before = measure->before;
    const float c = MEASURE_MIDDLE + C_COUNTS * (samples->i_c - MEASURE_MIDDLE);
    const bounds_span_t span = bounds_span(samples->i_a, samples->i_b, c);
    if (span.largest > MEASURE_MIDDLE + MEASURE_HALF && span.smallest < MEASURE_MIDDLE - MEASURE_HALF) {
        return (abc_t){samples->i_a - offset.a, samples->i_b - offset.b, samples->i_c - offset.c};
    }
    return (abc_t){expected(samples->i_a, MEASURE_HALF, offset.a, last.a, before.a, trip),
                   expected(samples->i_b, MEASURE_HALF, offset.b, last.b, before.b, trip),
                   expected(samples->i_c, C_HALF, offset.c, last.c, before.c, trip)};
}
