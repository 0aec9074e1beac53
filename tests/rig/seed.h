/* Selects the noise of a closed-loop test, and the points of a grid that run.
 *
 * LAGLESS_SEED (0) moves every seed of noise, and the period at which a drive is switched on, of 0 to 7: what
 * is learnt is summed over eight. A claim holds for every seed.
 *
 * A grid is a product of parameters. Of its points one in LAGLESS_GRID_SHARE (10; 1: all) runs, by a draw
 * from LAGLESS_GRID_SEED (the date, UTC, as YYYYMMDD), at least one of each grid. The draw also makes the
 * noise of a point. All three are printed by the first test that needs them. */
#ifndef TESTS_RIG_SEED_H
#define TESTS_RIG_SEED_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "host_sim/rig/rig.h"
#include "unity.h"

#define SEED_MEMBERS 64u /* seeds of a run, beginning with the one that the test has written down */
#define SEED_PHASES  8u  /* periods of a sum of what is learnt */

static uint32_t seed_member; /* of the test under way */

/* A number of the environment, whole and positive or 0; else this. */
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

/* Power on, with the noise of this seed and of the run. */
static inline rig_t *run_rig(uint64_t seed)
{
    const uint64_t run = (uint64_t)seed_values()->noise * SEED_MEMBERS + seed_member;
    rig_t *const rig = rig_create(seed + 1000u * run);
    TEST_ASSERT_NOT_NULL(rig);
    return rig;
}

/* Periods that the run waits before a drive is switched on. */
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
#undef RUN_TEST /* after a grid that failed, the noise is still that of its last point */
#define RUN_TEST(test) seed_run(test, #test, __LINE__, 1u)

/* ---- a grid ---- */

typedef struct {
    const char *name;
    uint32_t points, next, least; /* `least` runs in any case; `points`: none */
} grid_t;

/* Of a point, by its grid's name: FNV-1a, mixed again so that each bit depends on all others. */
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

/* If no point is drawn, the point with the least draw runs. */
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

/* Selects the next point that runs, and its own noise; false: no point is left. */
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

/* A document has the numbers of the drive as it is built: there all points run, each with the noise that the
 * test specifies. On another board, and together with the fixed-point twin, the usual share of the points
 * runs.
 */
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

/* A point's coordinate in the next dimension, of this size; `point` becomes what is left. */
static inline uint32_t grid_axis(uint32_t *point, uint32_t size)
{
    const uint32_t coordinate = *point % size;
    *point /= size;
    return coordinate;
}

#endif
