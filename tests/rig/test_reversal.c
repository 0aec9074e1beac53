/* Passing zero speed without an encoder: +-500 r/min by step and by ramps, without load, with a passive and
 * with an active one, on both shafts; and a reference that changes its mind twelve times. The tracking loop
 * knows the rotor's inertia (torque_feedforward 1): that carries the angle through the gap without an EMF. */
#include "tests/rig/start.h"

#define SPEED      500.0 /* [r/min] */
#define LOCKED     100.0 /* [mrad] of the mean, as asked */
#define SETTLED    4.0   /* [mrad] likewise, once it has settled: what it comes to */
#define MEAN_TIME  0.3   /* [s] at the end, over which it is taken */
#define AFTERWARDS 4.0   /* [s] that a reversal may last beyond its ramp, with stop and start */
#define PHASES     12u   /* of the electrical turn, at which the reference changes */
#define TURN       0.030 /* [s] that it takes */

static rig_t *rig;
static start_seen_t seen;

void setUp(void)
{
    rig = NULL;
}

void tearDown(void)
{
    rig_free(rig);
}

typedef struct {
    start_shaft_t shaft;
    double load, kind; /* [N m]; 0 passive, 1 active */
    double ramp;       /* [r/min/s]; 0: a step */
    inertia_adaptation_t inertia;
} reversal_t;

typedef struct {
    double peak;    /* error while run lasts [mrad] */
    double mean;    /* at the end, the larger of both ways [mrad] */
    double current; /* [A] */
    double forced;  /* [s] in another manoeuvre than run, of both ways */
    double reached; /* [s] until 95 % of the other speed, the larger */
    int losses, fault;
    bool runs; /* at the end of both ways */
} reversed_t;

static double believed = 1.0; /* inertia, over what it is [-] */

static void prepare(const reversal_t *what, uint32_t seed)
{
    rig_free(rig);
    rig = start_on_desk(what->shaft, seed);
    run_put(rig, "motor_inertia", believed * start_shaft_data[what->shaft].inertia);
    run_put(rig, "inertia_adaptation", (double)what->inertia);
    run_put(rig, "speed_ramp", what->ramp * RPM);
    run_put(rig, "load_kind", what->kind);
    start_running(rig, SPEED, what->load, 1.5);
    start_watch(rig, &seen);
}

static void reverse(reversed_t *result, double wanted, double seconds)
{
    const uint32_t periods = rig_periods(seconds), last = rig_periods(MEAN_TIME);
    double mean = 0.0, reached = seconds;
    run_put(rig, "speed_request", wanted * RPM);
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(rig);
        start_raise(&result->current, seen.current);
        if (seen.manoeuvre == RUNS) {
            start_raise(&result->peak, 1e3 * fabs(seen.error));
        } else {
            result->forced += RIG_PERIOD_SECONDS;
        }
        if (reached == seconds && seen.speed / wanted > 0.95) {
            reached = start_time(n);
        }
        if (n >= periods - last) {
            mean += 1e3 * seen.error / last;
        }
    }
    start_raise(&result->mean, fabs(mean));
    start_raise(&result->reached, reached);
    result->runs = result->runs && seen.manoeuvre == RUNS;
    result->losses = seen.losses;
    result->fault = seen.fault;
}

static void test_reversal_ends_locked_both_ways(void)
{
    static const double ramps[] = {0.0, 500.0, 100.0};
    static const struct {
        double load, kind;
    } loads[] = {{0.0, 0.0}, {RATED_TORQUE, 0.0}, {RATED_TORQUE, 1.0}};
    reversed_t results[2][3][3];
    for (size_t s = 0; s < 2u; s++) {
        for (size_t r = 0; r < 3u; r++) {
            for (size_t l = 0; l < 3u; l++) {
                const reversal_t what = {(start_shaft_t)s, loads[l].load, loads[l].kind, ramps[r],
                                         INERTIA_ON};
                const double seconds = AFTERWARDS + (ramps[r] > 0.0 ? 2.0 * SPEED / ramps[r] : 0.0);
                reversed_t *const to = &results[s][r][l];
                *to = (reversed_t){.runs = true};
                prepare(&what, 1u);
                reverse(to, -SPEED, seconds);
                reverse(to, SPEED, seconds);
                printf("reversal %c, %.0f N m %s, %.0f r/min/s: peak %.0f, mean at the end <= %.1f mrad, "
                       "%.2f A, "
                       "reached after %.2f s, %.2f s forced, losses %d, fault %d\n",
                       START_SHAFT_NAMES[s], what.load, what.kind > 0.0 ? "active" : "passive", what.ramp,
                       to->peak, to->mean, to->current, to->reached, to->forced, to->losses, to->fault);
            }
        }
    }
    for (size_t n = 0; n < 18u; n++) {
        const reversed_t *result = &results[n / 9u][n / 3u % 3u][n % 3u];
        TEST_ASSERT_EQUAL_INT(0, result->fault);
        TEST_ASSERT_TRUE(result->runs);
        TEST_ASSERT_TRUE(result->mean < SETTLED);
        TEST_ASSERT_TRUE(result->current <= 10.5);
    }
}

/* Two changes of speed there and back, by which the inertia is known within 2 %. */
static void learn_inertia(void)
{
    for (int32_t n = 0; n < 4; n++) {
        run_put(rig, "speed_request", (n % 2 == 0 ? 2.0 : 1.0) * SPEED * RPM);
        run_seconds(rig, 1.5);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * rig_value(rig, "plant.inertia"), rig_value(rig, "plant.inertia"),
                              rig_value(rig, "inertia_hat"));
}

typedef struct {
    double peak;     /* [mrad] of all */
    uint32_t beyond; /* [-] passages with more than was asked for */
    uint32_t of;     /* [-] */
} passages_t;

/* What comes before has been done in every passage: `limit` [mrad] was asked for. */
static passages_t pass_zero(const reversal_t *what, void (*before)(void), double limit)
{
    passages_t passages = {0};
    for (uint32_t n = 0; n < PHASES; n += START_THINNED) {
        prepare(what, 1u + n);
        before();
        run_seconds(rig, TURN * n / PHASES);
        for (int way = -1; way <= 1; way += 2) {
            reversed_t result = {.runs = true};
            reverse(&result, way * SPEED, 1.5);
            TEST_ASSERT_TRUE(result.runs);
            TEST_ASSERT_EQUAL_INT(0, result.losses);
            TEST_ASSERT_TRUE(result.mean < LOCKED);
            start_raise(&passages.peak, result.peak);
            passages.beyond += result.peak > limit;
            passages.of++;
        }
    }
    printf("reversal %c, %.0f N m, J x %.1f, step, %u passages: peak <= %.0f mrad, beyond %.0f mrad: %u\n",
           START_SHAFT_NAMES[what->shaft], what->load, believed, passages.of, passages.peak, limit,
           passages.beyond);
    return passages;
}

static void nothing(void)
{
}

/* At which phase zero is passed decides which leg dwells in the dead time's zone there; the loop coasts
 * meanwhile. The inertia is that of the parameter, right as it is, without learning, and at first with it; or
 * what has been learnt. */
static void test_step_without_load_keeps_the_angle_through_zero(void)
{
    static const double limits[] = {47.0, 32.0}; /* asked: 60, 80 */
    for (size_t s = 0; s < 2u; s++) {
        const reversal_t set = {(start_shaft_t)s, 0.0, 0.0, 0.0, INERTIA_OFF};
        const reversal_t learnt = {(start_shaft_t)s, 0.0, 0.0, 0.0, INERTIA_ON};
        const passages_t passages[] = {pass_zero(&set, nothing, limits[s]),
                                       pass_zero(&learnt, nothing, limits[s]),
                                       pass_zero(&learnt, learn_inertia, limits[s])};
        for (size_t n = 0; n < 3u; n++) {
            TEST_ASSERT_EQUAL_UINT32(0u, passages[n].beyond);
        }
    }
}

/* The first change of speed with a parameter that is wrong. Told of half or twice the torque the loop is off
 * by no more than told of none, and where that matters it does not coast: without any torque
 * (torque_feedforward 0) the medians are 82 mrad on the rig; on the bare motor 88 with twice the inertia and
 * 38 with half of it, as the speed control's gains go with it. Now and then a leg dwells at zero current and
 * a passage has two or three times as much, told of a torque or not: hence the limits. */
static void test_step_with_a_wrong_inertia_keeps_the_angle_through_zero(void)
{
    static const double factors[] = {0.5, 2.0};
    static const double limits[][2] = {{90.0, 77.0}, {57.0, 74.0}};
    for (size_t n = 0; n < 2u; n++) {
        believed = factors[n];
        for (size_t s = 0; s < 2u; s++) {
            const reversal_t first = {(start_shaft_t)s, 0.0, 0.0, 0.0, INERTIA_ON};
            TEST_ASSERT_TRUE(pass_zero(&first, nothing, limits[n][s]).beyond == 0u);
        }
    }
    believed = 1.0;
}

/* A passive load of the rated torque turns round with the speed, on the bare motor from 15 A that accelerate
 * to
 * 6. Told of none, the loop is off by what the acceleration makes; it is not lost. */
static void test_step_with_a_passive_load_is_not_lost(void)
{
    static const double limits[] = {200.0, 300.0};
    for (size_t s = 0; s < 2u; s++) {
        const reversal_t first = {(start_shaft_t)s, RATED_TORQUE, 0.0, 0.0, INERTIA_ON};
        TEST_ASSERT_TRUE(pass_zero(&first, nothing, limits[s]).beyond == 0u);
    }
}

static void test_reference_that_toggles_every_third_of_a_second_ends_locked(void)
{
    for (size_t s = 0; s < 2u; s++) {
        const reversal_t what = {(start_shaft_t)s, 0.0, 0.0, 0.0, INERTIA_ON};
        reversed_t result = {.runs = true}, on_the_way = {.runs = true};
        prepare(&what, 1u);
        for (uint32_t n = 0; n < 12u; n++) {
            reverse(&on_the_way, n % 2u == 0u ? -SPEED : SPEED, 0.3);
        }
        reverse(&result, SPEED, AFTERWARDS);
        printf("reversal %c, 12 times every 0.3 s: peak %.0f mrad on the way, mean at the end %.1f mrad, "
               "%.2f A, losses "
               "%d, fault %d\n",
               START_SHAFT_NAMES[s], on_the_way.peak, result.mean, fmax(result.current, on_the_way.current),
               result.losses, result.fault);
        TEST_ASSERT_EQUAL_INT(0, result.fault);
        TEST_ASSERT_TRUE(result.runs);
        TEST_ASSERT_TRUE(result.mean < SETTLED);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, SPEED, seen.speed);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reversal_ends_locked_both_ways);
    RUN_TEST(test_step_without_load_keeps_the_angle_through_zero);
    RUN_TEST(test_step_with_a_wrong_inertia_keeps_the_angle_through_zero);
    RUN_TEST(test_step_with_a_passive_load_is_not_lost);
    RUN_TEST(test_reference_that_toggles_every_third_of_a_second_ends_locked);
    return UNITY_END();
}
