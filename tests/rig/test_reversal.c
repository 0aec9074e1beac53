/* Passing zero speed without an encoder: +-500 r/min by step and by ramps, without load, with a passive and
 * with an active one, on both shafts; and a reference that changes its mind twelve times. The tracking loop
 * knows the rotor's inertia (torque_feedforward 1): that carries the angle through the gap without an EMF. */
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#define SPEED      500.0 /* [r/min] */
#define LOCKED     100.0 /* [mrad] of the mean, as asked */
#define SETTLED    4.0   /* [mrad] likewise, once it has settled: what it comes to */
#define MEAN_TIME  0.3   /* [s] at the end, over which it is taken */
#define AFTERWARDS 4.0   /* [s] that a reversal may last beyond its ramp, with stop and start */
#define PHASES     12u   /* of the electrical turn, at which the reference changes */
#define TURN       0.030 /* [s] that it takes */

static start_seen_t seen;

typedef struct {
    start_shaft_t shaft;
    double load, kind; /* [N m]; 0 passive, 1 active */
    double ramp;       /* [r/min/s]; 0: a step */
    double believed;   /* inertia, over what it is [-] */
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

static void prepare(const reversal_t *what, uint32_t seed)
{
    rig_free(rig);
    rig = start_on_desk(what->shaft, seed);
    run_put(rig, "motor_inertia", what->believed * start_shaft_data[what->shaft].inertia);
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
    grid_t grid = grid_of("reversal", START_BOTH * 3u * 3u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const double ramp = ramps[grid_axis(&n, 3u)];
        const reversal_t what = {shaft, loads[n].load, loads[n].kind, ramp, 1.0, INERTIA_ON};
        const double seconds = AFTERWARDS + (ramp > 0.0 ? 2.0 * SPEED / ramp : 0.0);
        reversed_t to = {.runs = true};
        prepare(&what, 1u);
        reverse(&to, -SPEED, seconds);
        reverse(&to, SPEED, seconds);
        const char *const where =
            run_say("reversal %c, %.0f N m %s, %.0f r/min/s: peak %.0f, mean at the end <= %.1f mrad, "
                    "%.2f A, reached after %.2f s, %.2f s forced, losses %d, fault %d",
                    START_SHAFT_NAMES[shaft], what.load, what.kind > 0.0 ? "active" : "passive", ramp,
                    to.peak, to.mean, to.current, to.reached, to.forced, to.losses, to.fault);
        TEST_ASSERT_EQUAL_INT_MESSAGE(0, to.fault, where);
        TEST_ASSERT_TRUE_MESSAGE(to.runs, where);
        TEST_ASSERT_TRUE_MESSAGE(to.mean < SETTLED, where);
        TEST_ASSERT_TRUE_MESSAGE(to.current <= 10.5, where);
    }
}

/* ---- steps through zero ---- */

/* At which phase zero is passed decides which leg dwells in the dead time's zone there; the loop coasts
 * meanwhile. */
typedef struct {
    const char *name;
    double load;
    inertia_adaptation_t inertia;
    bool learnt;      /* by changes of speed before */
    double believed;  /* inertia, over what it is [-] */
    double limits[2]; /* [mrad] of the peak, heavy and light */
} passage_t;

/* Without load and with the inertia known, of the parameter or learnt, 60 and 80 mrad were asked for.
 *
 * The first change of speed with a parameter that is wrong: with half or twice the torque known the loop is
 * off by no more than with none, and where that matters it does not coast: without any torque
 * (torque_feedforward 0) the medians are 82 mrad on the rig; on the bare motor 88 with twice the inertia and
 * 38 with half of it, as the speed control's gains go with it. Now and then a leg dwells at zero current and
 * a passage has two to four times as much, on the bare motor with half the inertia one of 36 with 111 mrad,
 * with twice the inertia three of 48 with up to 160: hence the limits, 1.3 times that.
 *
 * A passive load of the rated torque turns round with the speed, on the bare motor from 15 A that accelerate
 * to 6: the loop is off by what the acceleration makes, 137 +- 9 and 197 +- 28 mrad; it is not lost. */
static const passage_t passages[] = {
    {"test_step_without_load_and_learning", 0.0, INERTIA_OFF, false, 1.0, {47.0, 32.0}},
    {"test_step_without_load_at_first", 0.0, INERTIA_ON, false, 1.0, {47.0, 32.0}},
    {"test_step_without_load_with_what_was_learnt", 0.0, INERTIA_ON, true, 1.0, {47.0, 32.0}},
    {"test_step_with_half_the_inertia_known", 0.0, INERTIA_ON, false, 0.5, {90.0, 145.0}},
    {"test_step_with_twice_the_inertia_believed", 0.0, INERTIA_ON, false, 2.0, {57.0, 210.0}},
    {"test_step_with_a_passive_load_is_not_lost", RATED_TORQUE, INERTIA_ON, false, 1.0, {200.0, 350.0}},
};

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

static const passage_t *under_test;

static void passes_zero(void)
{
    const passage_t *const of = under_test;
    grid_t grid = grid_of(of->name, START_BOTH * PHASES);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const reversal_t what = {shaft, of->load, 0.0, 0.0, of->believed, of->inertia};
        prepare(&what, 1u + n);
        if (of->learnt) {
            learn_inertia();
        }
        run_seconds(rig, TURN * n / PHASES);
        for (int way = -1; way <= 1; way += 2) {
            reversed_t result = {.runs = true};
            reverse(&result, way * SPEED, 1.5);
            const char *const where =
                run_say("reversal %c, %.0f N m, J x %.1f, phase %u, %+d: peak %.0f mrad",
                        START_SHAFT_NAMES[shaft], of->load, of->believed, (unsigned)n, way, result.peak);
            TEST_ASSERT_TRUE_MESSAGE(result.runs, where);
            TEST_ASSERT_EQUAL_INT_MESSAGE(0, result.losses, where);
            TEST_ASSERT_TRUE_MESSAGE(result.mean < LOCKED, where);
            TEST_ASSERT_TRUE_MESSAGE(result.peak <= of->limits[shaft], where);
        }
    }
}

static void test_reference_that_toggles_every_third_of_a_second_ends_locked(void)
{
    grid_t grid = grid_of("toggles", START_BOTH);
    for (uint32_t s; grid_next(&grid, &s);) {
        const reversal_t what = {(start_shaft_t)s, 0.0, 0.0, 0.0, 1.0, INERTIA_ON};
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
    for (size_t n = 0; n < sizeof passages / sizeof passages[0]; n++) {
        under_test = &passages[n];
        seed_run(passes_zero, under_test->name, __LINE__, 1u);
    }
    RUN_TEST(test_reference_that_toggles_every_third_of_a_second_ends_locked);
    return UNITY_END();
}
