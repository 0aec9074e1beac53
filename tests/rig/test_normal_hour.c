/* An hour of normal running, half of it on each shaft, in parts of a minute: stops and starts, reversals,
 * slow speeds, loads that come and go, with the sensors as they are. Nothing is wrong: no fault, no warning,
 * no lost rotor, each start at the first try. */
#include "tests/rig/start.h"
#include "tests/rig/the_rig.h"

#define PARTS    60u /* of the hour, each on one shaft */
#define SEGMENTS 10u /* of a part, of six seconds each */
#define SPEEDS   9u

static start_seen_t seen;

/* A generator of its own (Park and Miller 1988), that an hour is the same everywhere. */
static uint32_t drawn(uint32_t *state, uint32_t below)
{
    *state = (uint32_t)((uint64_t)*state * 48271u % 2147483647u);
    return *state % below;
}

/* What a light rotor is stopped by is no normal load (lock_loss.grid): at speeds that are slow for it none
 * comes. */
static void segment(start_shaft_t shaft, uint32_t *state)
{
    static const double speeds[SPEEDS] = {-1500.0, -700.0, -300.0, -100.0, 0.0, 60.0, 200.0, 500.0, 1200.0};
    const double rpm = speeds[drawn(state, SPEEDS)];
    const bool loaded = fabs(rpm) > (shaft == HEAVY ? 50.0 : 400.0);
    const double load = loaded ? 0.25 * RATED_TORQUE * drawn(state, 5u) : 0.0;
    run_put(rig, "speed_request", rpm * RPM);
    run_seconds(rig, 3.0);
    run_load(rig, load, 1.0);
    run_seconds(rig, 1.0);
    run_load(rig, 0.0, 0.5);
    run_seconds(rig, 0.5);
    if (drawn(state, 10u) == 0u) {
        run_put(rig, "enable", drawn(state, 2u) == 0u ? 0.0 : 2.0); /* off, or a quick stop */
        run_seconds(rig, 2.0);
        run_put(rig, "enable", 1.0);
    }
}

static void test_an_hour_raises_nothing(void)
{
    grid_t grid = grid_of("an hour", PARTS);
    for (uint32_t n; grid_next(&grid, &n);) {
        uint32_t state = 20261123u + n;
        const start_shaft_t shaft = (start_shaft_t)grid_axis(&n, START_BOTH);
        rig_free(rig);
        rig = start_on_desk(shaft, 17u);
        run_put(rig, "speed_ramp", 1500.0 * RPM);
        start_ready(rig, 1.0);
        start_watch(rig, &seen);
        run_on(rig, 300.0);
        for (uint32_t k = 0; k < SEGMENTS; k++) {
            segment(shaft, &state);
        }
        const char *const where =
            run_say("normal running %c, part %u: fault %d, lost %d times, try %d, warnings 0x%x",
                    START_SHAFT_NAMES[shaft], (unsigned)n, seen.first_fault, seen.losses_most,
                    seen.start_try_most, (unsigned)seen.warnings);
        TEST_ASSERT_TRUE_MESSAGE(seen.noticed == 0u && seen.losses_most == 0 && seen.start_try_most <= 1,
                                 where);
    }
}
