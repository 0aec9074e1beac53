/* Selects the noise of a test in closed loop, and the points of a grid that run.
 *
 * LAGLESS_SEED (default 0) changes every seed of noise, and the period at which a drive is switched on, from
 * 0 to 7, because learning sums over eight periods. A claim must hold for every seed.
 *
 * A grid is a product of parameters. One of LAGLESS_GRID_SHARE (default 10; 1: all) points runs, and at least
 * one of each grid. The points are drawn by LAGLESS_GRID_SEED (default: the UTC date as YYYYMMDD), which also
 * selects the noise of a point.
 *
 * The first test that uses one of the three values prints it. */
#ifndef TESTS_RIG_SEED_H
#define TESTS_RIG_SEED_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "host_sim/rig/rig.h"
#include "unity.h"

#define SEED_MEMBERS 64u /* number of seeds in a run; the first is the one that the test states */
#define SEED_PHASES  8u  /* number of periods over which learning sums */

static uint32_t seed_member; /* seed of the running test */

/* A number from the environment, a positive whole number or 0; otherwise this value. */
static inline uint32_t seed_given(const char *name, uint32_t otherwise)
{
    const char *const text = getenv(name);
    if (text == NULL || *text == '\0') {
        return otherwise;
    }
    char *end = NULL;
    const unsigned long value = strtoul(text, &end, 10);
    if (*text < '0' || *text > '9' || *end != '\0' || value > UINT32_MAX) {
        fprintf(stderr, "%s=%s is no whole number\n", name, text);
        exit(2);
    }
    return (uint32_t)value;
}

static inline uint32_t seed_of_day(void)
{
    const time_t now = time(NULL);
    const struct tm *const day = gmtime(&now);
    return (uint32_t)((day->tm_year + 1900) * 10000 + (day->tm_mon + 1) * 100 + day->tm_mday);
}

typedef struct {
    uint32_t noise, grid, share;
} seed_given_t;

static inline const seed_given_t *seed_values(void)
{
    static seed_given_t given;
    if (given.share == 0u) {
        given = (seed_given_t){seed_given("LAGLESS_SEED", 0u), seed_given("LAGLESS_GRID_SEED", seed_of_day()),
                               seed_given("LAGLESS_GRID_SHARE", 10u)};
        given.share = given.share == 0u ? 1u : given.share;
        printf("LAGLESS_SEED=%u LAGLESS_GRID_SEED=%u LAGLESS_GRID_SHARE=%u\n", (unsigned)given.noise,
               (unsigned)given.grid, (unsigned)given.share);
    }
    return &given;
}

/* Powers on a simulation with the noise of this seed and of the run. */
static inline rig_t *run_rig(uint64_t seed)
{
    const uint64_t run = (uint64_t)seed_values()->noise * SEED_MEMBERS + seed_member;
    rig_t *const rig = rig_create(seed + 1000u * run);
    TEST_ASSERT_NOT_NULL(rig);
    return rig;
}

/* The number of periods that the run waits before a drive is switched on. */
static inline uint32_t seed_phase(void)
{
    return (seed_values()->noise + seed_member) % SEED_PHASES;
}

/* ---- a test with several seeds ---- */

static inline void seed_run(void (*test)(void), const char *name, int line, uint32_t members)
{
    for (uint32_t n = 0u; n < members; n++) {
        char text[160];
        (void)snprintf(text, sizeof text, n == 0u ? "%s" : "%s[%u]", name, (unsigned)n);
        seed_member = n;
        UnityDefaultTestRun(test, text, line);
    }
    seed_member = 0u;
}
#undef RUN_TEST /* restores the noise that the last point of a failed grid has left */
#define RUN_TEST(test) seed_run(test, #test, __LINE__, 1u)

/* ---- a grid ---- */

typedef struct {
    const char *name;
    uint32_t points, next, least; /* `least` always runs, unless `points` is 0 */
} grid_t;

/* The random number of a point, from the name of its grid: FNV-1a, mixed again so that each bit depends on
 * all others. */
static inline uint32_t grid_draw(const char *name, uint32_t point)
{
    uint32_t hash = 2166136261u ^ seed_values()->grid;
    for (; *name != '\0'; name++) {
        hash = (hash ^ (unsigned char)*name) * 16777619u;
    }
    hash = (hash ^ point) * 2654435761u;
    hash = (hash ^ (hash >> 15)) * 2246822519u;
    hash = (hash ^ (hash >> 13)) * 3266489917u;
    return hash ^ (hash >> 16);
}

/* If no point is drawn, the point with the smallest random number runs. */
static inline grid_t grid_of(const char *name, uint32_t points)
{
    grid_t grid = {name, points, 0u, 0u};
    bool is_drawn = false;
    for (uint32_t n = 0u; n < points; n++) {
        is_drawn = is_drawn || grid_draw(name, n) % seed_values()->share == 0u;
        grid.least = grid_draw(name, n) < grid_draw(name, grid.least) ? n : grid.least;
    }
    grid.least = is_drawn ? points : grid.least;
    return grid;
}

/* Selects the next point that runs and its noise; false if no point is left. */
static inline bool grid_next(grid_t *grid, uint32_t *point)
{
    seed_member = 0u;
    for (; grid->next < grid->points; grid->next++) {
        const uint32_t draw = grid_draw(grid->name, grid->next);
        if (draw % seed_values()->share == 0u || grid->next == grid->least) {
            seed_member = (draw >> 16) % SEED_MEMBERS;
            *point = grid->next++;
            return true;
        }
    }
    return false;
}

/* The numbers in a document are those of the drive with the default settings of the build. There all
 * points run, each with the noise that the test states. On another board, and with the fixed-point twin,
 * the usual share of the points runs. */
#ifndef GRID_DOCUMENTED
#define GRID_DOCUMENTED (BOARD_CURRENT_SENSORS == 2)
#endif
static inline bool grid_next_documented(grid_t *grid, uint32_t *point)
{
    if (!GRID_DOCUMENTED) {
        return grid_next(grid, point);
    }
    seed_member = 0u;
    *point = grid->next++;
    return *point < grid->points;
}

/* The coordinate of a point in the next dimension, which has this size; `point` becomes the rest of the
 * index. */
static inline uint32_t grid_axis(uint32_t *point, uint32_t size)
{
    const uint32_t coordinate = *point % size;
    *point /= size;
    return coordinate;
}

#endif
