/* A drive that is switched on while its rotor turns: caught without an encoder at every speed and angle, both
 * ways; a slow one is brought to what is asked for; one beyond the DC link is refused. */
#include "drive/reasons.h"
#include "tests/rig/start.h"

#define ANGLES 12u
#define LOCKED 0.1  /* [rad] */
#define HELD   5e-3 /* [s] for which it must be less, so that it counts */
#define MEAN   0.1  /* [s] at the end, over which speed and error are taken */
#define READY  1.0  /* state */

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
    uint32_t tried, good, caught; /* [-] `caught`: without a start */
    double locked, inrush;        /* largest [s], [A] */
} catch_grid_t;

static double believed = 1.0; /* [-] psi_f of the drive over that of the motor */

/* Turning at `rpm` when `wanted` is asked for. */
static void catch_at(catch_grid_t *grid, start_shaft_t shaft, double rpm, double wanted, double seconds,
                     uint32_t n)
{
    const double angle = 2.0 * PI * n / ANGLES / POLE_PAIRS;
    rig_free(rig);
    rig = start_on_desk(shaft, 1u + n);
    if (believed != 1.0) {
        run_put(rig, "overspeed_trip", 175.0); /* so that k_s reaches for more flux too */
        run_times(rig, "motor_flux_linkage", believed);
    }
    start_ready(rig, 0.0);
    rig_set_motion(rig, angle, rpm * RPM);
    run_seconds(rig, 0.002);
    rig_set_motion(rig, angle, rpm * RPM);
    start_watch(rig, &seen);
    run_on(rig, wanted);
    const uint32_t periods = rig_periods(seconds), mean = rig_periods(MEAN);
    double locked = seconds, speed = 0.0, error = 0.0;
    uint32_t small = 0;
    bool started = false;
    grid->tried++;
    for (uint32_t k = 0; k < periods && seen.fault == 0; k++) {
        rig_step(rig);
        started = started || seen.manoeuvre == ALIGNS;
        if (seen.manoeuvre == CATCHES) {
            start_raise(&grid->inrush, seen.current);
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
    const bool good =
        seen.fault == 0 && seen.manoeuvre == RUNS && fabs(speed - wanted) < 2.0 && fabs(error) < LOCKED;
    grid->good += good;
    grid->caught += good && !started;
    if (good) {
        start_raise(&grid->locked, locked);
    }
}

static catch_grid_t catch_and_print(start_shaft_t shaft, double rpm, double wanted, double seconds)
{
    catch_grid_t grid = {0};
    for (uint32_t n = 0; n < ANGLES; n += START_THINNED) {
        catch_at(&grid, shaft, rpm, wanted, seconds, n);
    }
    printf("catch %c, %+.0f r/min, %+.0f asked: %u/%u, caught turning %u, locked <= %.1f ms, inrush %.2f A\n",
           START_SHAFT_NAMES[shaft], rpm, wanted, grid.good, grid.tried, grid.caught, 1e3 * grid.locked,
           grid.inrush);
    return grid;
}

static void test_turning_rotor_is_caught_at_every_angle(void)
{
    static const double speeds[] = {100.0, 300.0, 700.0, 1000.0, 1500.0};
    catch_grid_t grids[2][5][2];
    for (size_t s = 0; s < 2u; s++) {
        for (size_t n = 0; n < 5u; n++) {
            grids[s][n][0] = catch_and_print((start_shaft_t)s, speeds[n], speeds[n], 1.5);
            grids[s][n][1] = catch_and_print((start_shaft_t)s, -speeds[n], -speeds[n], 1.5);
        }
    }
    for (size_t n = 0; n < 20u; n++) {
        const catch_grid_t *grid = &grids[n / 10u][n / 2u % 5u][n % 2u];
        TEST_ASSERT_EQUAL_UINT32(grid->tried, grid->caught);
        TEST_ASSERT_TRUE(grid->locked <= 26e-3); /* asked: 60 ms */
        TEST_ASSERT_TRUE(grid->inrush <= 3.0);
    }
}

/* <|e|>/psi_f is a third too fast then, or a fifth too slow; beyond 1200 r/min the former is an overspeed
 * before the phase of the EMF has told the speed. */
static void test_rotor_is_caught_with_psi_f_wrong_by_a_quarter(void)
{
    static const double speeds[] = {300.0, 700.0, 1000.0, 1200.0};
    static const double shares[] = {0.75, 1.25};
    catch_grid_t grids[16];
    for (size_t n = 0; n < 16u; n++) {
        const double rpm = n % 2u == 0u ? speeds[n / 4u] : -speeds[n / 4u];
        believed = shares[n / 2u % 2u];
        printf("psi_f believed %.2f, ", believed);
        grids[n] = catch_and_print(LIGHT, rpm, rpm, 1.0);
    }
    believed = 1.0;
    for (size_t n = 0; n < 16u; n++) {
        TEST_ASSERT_EQUAL_UINT32(grids[n].tried, grids[n].caught);
        TEST_ASSERT_TRUE(grids[n].locked <= 60e-3);
        TEST_ASSERT_TRUE(grids[n].inrush <= 3.0);
    }
}

/* Between standing and turning either way of getting hold of it is right, so long as it ends running; 60
 * r/min is below handover_speed, where the frame is forced, so that more is asked for. */
static void test_slow_rotor_ends_running_as_asked(void)
{
    static const double speeds[] = {-80.0, -60.0, -40.0, 40.0, 60.0};
    catch_grid_t grids[2][5];
    for (size_t s = 0; s < 2u; s++) {
        for (size_t n = 0; n < 5u; n++) {
            grids[s][n] = catch_and_print((start_shaft_t)s, speeds[n], 300.0, 5.0);
        }
    }
    for (size_t n = 0; n < 10u; n++) {
        const catch_grid_t *grid = &grids[n / 5u][n % 5u];
        TEST_ASSERT_EQUAL_UINT32(grid->tried, grid->good);
        TEST_ASSERT_TRUE(grid->inrush <= 3.0);
    }
}

/* ---- beyond the DC link ---- */

#define LINK_VOLTAGE 311.0
#define FLUX_LINKAGE 0.183

/* Speed at which the EMF between two terminals reaches the link: beyond it the diodes conduct [r/min]. */
#define DIODE_SPEED (LINK_VOLTAGE / (1.7320508 * FLUX_LINKAGE) / POLE_PAIRS / RPM)

/* The protection by speed out of the way; k_s must hold the EMF, and the slope goes with it. */
static void prepare_fast(start_shaft_t shaft, uint32_t seed)
{
    rig_free(rig);
    rig = start_on_desk(shaft, seed);
    run_put(rig, "overspeed_trip", 300.0);
    run_put(rig, "observer_gain", 250.0);
    run_put(rig, "observer_slope", 0.8);
    run_put(rig, "estimate_current_max", 5.0);
    start_ready(rig, 0.0);
}

typedef struct {
    uint32_t tried, off, stopped; /* [-] `off`: the gates never came on; else `stopped` by the reason */
    double latest, current;       /* [s], [A] */
} too_fast_t;

/* A dynamometer holds the speed: what the rotor loses by itself shall not decide. */
static void switch_on_at(too_fast_t *seen_of, double rpm, double angle)
{
    run_put(rig, "shaft_locked_speed", rpm * RPM);
    run_put(rig, "shaft_locked", 1.0);
    rig_set_motion(rig, angle, rpm * RPM);
    run_seconds(rig, 0.02);
    start_watch(rig, &seen);
    run_on(rig, rpm > 0.0 ? 1500.0 : -1500.0);
    bool off = true;
    seen_of->tried++;
    for (uint32_t n = 0; n < rig_periods(0.1) && seen.fault == 0; n++) {
        rig_step(rig);
        off = off && rig_value(rig, "state") == READY;
        start_raise(&seen_of->current, seen.current);
        if (seen.fault != 0) {
            start_raise(&seen_of->latest, start_time(n + 1u));
        }
    }
    seen_of->off += off && rig_value(rig, "refusal") == REASON_ROTOR_TOO_FAST;
    seen_of->stopped += seen.fault == REASON_ROTOR_TOO_FAST;
}

/* Before the gates come on if the diodes carry current already, else as soon as the EMF has been seen. */
static void test_rotor_beyond_the_link_is_refused(void)
{
    static const double shares[] = {1.02, 1.05, 1.1, 1.2};
    too_fast_t all[4] = {{0}};
    for (size_t f = 0; f < 4u; f++) {
        for (uint32_t n = 0; n < ANGLES; n++) {
            prepare_fast(n % 2u == 0u ? HEAVY : LIGHT, 1u + n);
            switch_on_at(&all[f], (n % 4u < 2u ? shares[f] : -shares[f]) * DIODE_SPEED, 0.13 * n);
        }
        printf("catch beyond the link, EMF %.2f of it: %u of %u never on, %u stopped <= %.1f ms, current "
               "%.2f A\n",
               shares[f], all[f].off, all[f].tried, all[f].stopped, 1e3 * all[f].latest, all[f].current);
    }
    for (size_t f = 0; f < 4u; f++) {
        TEST_ASSERT_EQUAL_UINT32(all[f].tried, all[f].off + all[f].stopped);
        TEST_ASSERT_TRUE(all[f].latest <= 5e-3);
    }
    TEST_ASSERT_EQUAL_UINT32(all[3].tried, all[3].off);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_turning_rotor_is_caught_at_every_angle);
    RUN_TEST(test_rotor_is_caught_with_psi_f_wrong_by_a_quarter);
    RUN_TEST(test_slow_rotor_ends_running_as_asked);
    RUN_TEST(test_rotor_beyond_the_link_is_refused);
    return UNITY_END();
}
