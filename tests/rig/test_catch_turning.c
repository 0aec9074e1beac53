/* A drive that is switched on while its rotor turns: caught without an encoder at every speed and angle, both
 * ways; a slow one is brought to what is asked for; one beyond the DC link is refused. */
#include "settings/reasons.h"
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#define ANGLES 12u  /* of an electrical turn */
#define LOCKED 0.1  /* [rad] */
#define HELD   5e-3 /* [s] for which it must be less, so that it counts */
#define MEAN   0.1  /* [s] at the end, over which speed and error are taken */
#define READY  1.0  /* state */

static start_seen_t seen;

/* Asked for of a turning rotor: locked after 60 ms. */
typedef struct {
    const char *name;
    uint32_t first, shafts; /* of the shafts, the first and how many */
    uint32_t speeds;
    double rpm[5];
    bool both_ways;
    double beliefs[2]; /* [-] psi_f of the drive over that of the motor; 0: no second */
    double wanted;     /* [r/min] asked for; 0: the speed that it has */
    double seconds;
    double locked; /* [s] at most, without a start; 0: either way of getting hold of it is right */
    double inrush; /* [A] */
} catch_case_t;

/* With psi_f wrong by a quarter <|e|>/psi_f is a third too fast, or a fifth too slow; beyond 1200 r/min the
 * former is an overspeed before the phase of the EMF has told the speed. Between standing and turning 60
 * r/min is below handover_speed, where the frame is forced, so that more is asked for. */
static const catch_case_t cases[] = {
    {"test_turning_rotor_is_caught_at_every_angle",
     HEAVY,
     2u,
     5u,
     {100.0, 300.0, 700.0, 1000.0, 1500.0},
     true,
     {1.0, 0.0},
     0.0,
     1.5,
     26e-3,
     3.0},
    {"test_rotor_is_caught_with_psi_f_wrong_by_a_quarter",
     LIGHT,
     1u,
     4u,
     {300.0, 700.0, 1000.0, 1200.0},
     true,
     {0.75, 1.25},
     0.0,
     1.0,
     60e-3,
     3.0},
    {"test_slow_rotor_ends_running_as_asked",
     HEAVY,
     2u,
     5u,
     {-80.0, -60.0, -40.0, 40.0, 60.0},
     false,
     {1.0, 0.0},
     300.0,
     5.0,
     0.0,
     3.0},
};

/* Turning at this speed, this place of the electrical turn, when the drive is switched on. */
static void prepare(start_shaft_t shaft, double believed, double rpm, double angle)
{
    rig_free(rig);
    rig = start_on_desk(shaft, 1u);
    if (believed != 1.0) {
        run_put(rig, "overspeed_trip", 175.0); /* so that k_s reaches for more flux too */
        run_times(rig, "motor_flux_linkage", believed);
    }
    start_ready(rig, 0.0);
    rig_set_motion(rig, angle, rpm * RPM);
    run_seconds(rig, 0.002);
    rig_set_motion(rig, angle, rpm * RPM);
    start_watch(rig, &seen);
}

static void expect_caught(const catch_case_t *of, double wanted, const char *what)
{
    const uint32_t periods = rig_periods(of->seconds), mean = rig_periods(MEAN);
    double locked = of->seconds, speed = 0.0, error = 0.0, inrush = 0.0;
    uint32_t small = 0;
    bool started = false;
    run_on(rig, wanted);
    for (uint32_t k = 0; k < periods && seen.fault == 0; k++) {
        rig_step(rig);
        started = started || seen.manoeuvre == ALIGNS;
        if (seen.manoeuvre == CATCHES) {
            start_raise(&inrush, seen.current);
        }
        small = seen.manoeuvre == RUNS && fabs(seen.error) < LOCKED ? small + 1u : 0u;
        if (small == rig_periods(HELD)) {
            locked = fmin(locked, start_time(k + 1u) - HELD);
        }
        if (k >= periods - mean) {
            speed += seen.speed / mean;
            error += seen.error / mean;
        }
    }
    const char *const where =
        run_say("%s: %s after %.1f ms, inrush %.2f A, %.1f r/min, fault %d", what,
                started ? "started" : "caught", 1e3 * locked, inrush, speed, seen.fault);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, seen.fault, where);
    TEST_ASSERT_EQUAL_INT_MESSAGE(RUNS, seen.manoeuvre, where);
    TEST_ASSERT_TRUE_MESSAGE(fabs(speed - wanted) < 2.0 && fabs(error) < LOCKED, where);
    TEST_ASSERT_TRUE_MESSAGE(inrush <= of->inrush, where);
    TEST_ASSERT_TRUE_MESSAGE(of->locked == 0.0 || (!started && locked <= of->locked), where);
}

static const catch_case_t *under_test;

static void catches(void)
{
    const catch_case_t *const of = under_test;
    const uint32_t ways = of->both_ways ? 2u : 1u, beliefs = of->beliefs[1] > 0.0 ? 2u : 1u;
    grid_t grid = grid_of(of->name, of->shafts * of->speeds * ways * beliefs * ANGLES);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)(of->first + grid_axis(&n, of->shafts));
        const double size = of->rpm[grid_axis(&n, of->speeds)];
        const double rpm = grid_axis(&n, ways) == 0u ? size : -size;
        const double believed = of->beliefs[grid_axis(&n, beliefs)];
        const double wanted = of->wanted != 0.0 ? of->wanted : rpm;
        char what[80];
        (void)snprintf(what, sizeof what, "catch %c, %+.0f r/min, %.0f deg, psi_f x %.2f",
                       START_SHAFT_NAMES[shaft], rpm, 360.0 * n / ANGLES, believed);
        prepare(shaft, believed, rpm, 2.0 * PI * n / ANGLES / POLE_PAIRS);
        expect_caught(of, wanted, what);
    }
}

/* ---- beyond the DC link ---- */

#define LINK_VOLTAGE 311.0
#define FLUX_LINKAGE 0.183

/* Speed at which the EMF between two terminals reaches the link: beyond it the diodes conduct [r/min]. */
#define DIODE_SPEED (LINK_VOLTAGE / (1.7320508 * FLUX_LINKAGE) / POLE_PAIRS / RPM)

/* The protection by speed out of the way; k_s must hold the EMF, and the slope goes with it. */
static void prepare_fast(start_shaft_t shaft)
{
    rig_free(rig);
    rig = start_on_desk(shaft, 1u);
    run_put(rig, "overspeed_trip", 300.0);
    run_put(rig, "observer_gain", 250.0);
    run_put(rig, "observer_slope", 0.8);
    run_put(rig, "estimate_current_max", 5.0);
    start_ready(rig, 0.0);
}

/* A dynamometer holds the speed: what the rotor loses by itself shall not decide. Before the gates come on if
 * the diodes carry current already, as at a fifth more than the link, else as soon as the EMF has been seen.
 */
static void test_rotor_beyond_the_link_is_refused(void)
{
    static const double shares[] = {1.02, 1.05, 1.1, 1.2};
    grid_t grid = grid_of("beyond the link", 4u * 4u * ANGLES);
    for (uint32_t n; grid_next(&grid, &n);) {
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        const double way = grid_axis(&n, 2u) == 0u ? 1.0 : -1.0;
        const double share = shares[grid_axis(&n, 4u)];
        bool off = true;
        double stopped = 0.0;
        prepare_fast(shaft);
        run_put(rig, "shaft_locked_speed", way * share * DIODE_SPEED * RPM);
        run_put(rig, "shaft_locked", 1.0);
        rig_set_motion(rig, 0.13 * n, way * share * DIODE_SPEED * RPM);
        run_seconds(rig, 0.02);
        start_watch(rig, &seen);
        run_on(rig, way * 1500.0);
        for (uint32_t k = 0; k < rig_periods(0.1) && seen.fault == 0; k++) {
            rig_step(rig);
            off = off && rig_value(rig, "state") == READY;
            stopped = start_time(k + 1u);
        }
        const char *const where =
            run_say("%c, EMF %+.2f of the link: %s, fault %d after %.1f ms", START_SHAFT_NAMES[shaft],
                    way * share, off ? "never on" : "on", seen.fault, 1e3 * stopped);
        if (off) {
            TEST_ASSERT_EQUAL_DOUBLE(REASON_ROTOR_TOO_FAST, rig_value(rig, "refusal"));
        } else {
            TEST_ASSERT_TRUE_MESSAGE(share < 1.2, where);
            TEST_ASSERT_EQUAL_INT_MESSAGE(REASON_ROTOR_TOO_FAST, seen.fault, where);
            /* 5 ms, and three windows: until `enable` is seen, until it acts, and to the end of that in which
             * it is judged */
            TEST_ASSERT_TRUE_MESSAGE(stopped <= 5e-3 + 3.0 * DRIVE_WINDOW * RIG_PERIOD_SECONDS, where);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        under_test = &cases[n];
        seed_run(catches, under_test->name, __LINE__, 1u);
    }
    RUN_TEST(test_rotor_beyond_the_link_is_refused);
    return UNITY_END();
}
