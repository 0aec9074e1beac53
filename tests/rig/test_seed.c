/* The draw of grids and seeds itself: a tenth is a tenth, every grid has a point, the same seed gives the
 * same points, and all of them run when that is asked. */
#include <string.h>

#include "tests/rig/no_rig.h"
#include "tests/rig/seed.h"

#define POINTS 200u

/* As if this had been given. */
static void give(uint32_t noise, uint32_t grid, uint32_t share)
{
    *(seed_given_t *)seed_values() = (seed_given_t){noise, grid, share};
}

static uint32_t drawn(const char *name, uint32_t points, bool runs[])
{
    uint32_t count = 0u;
    memset(runs, 0, points * sizeof runs[0]);
    grid_t grid = grid_of(name, points);
    for (uint32_t n; grid_next(&grid, &n); count++) {
        TEST_ASSERT_TRUE(n < points && !runs[n]);
        runs[n] = true;
    }
    TEST_ASSERT_EQUAL_UINT32(0u, seed_member);
    return count;
}

/* Of a thousand days 20 points a day, 4.2 standard deviation: their mean within four of its own. */
static void test_a_tenth_runs_and_in_time_every_point(void)
{
    bool runs[POINTS], ever[POINTS] = {false};
    double sum = 0.0;
    for (uint32_t day = 0u; day < 1000u; day++) {
        give(0u, 20260101u + day, 10u);
        sum += drawn("points", POINTS, runs);
        for (uint32_t n = 0; n < POINTS; n++) {
            ever[n] = ever[n] || runs[n];
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(4.0 * 4.25 / 31.6, 20.0, sum / 1000.0);
    for (uint32_t n = 0; n < POINTS; n++) {
        TEST_ASSERT_TRUE(ever[n]);
    }
}

static void test_every_grid_has_a_point(void)
{
    bool runs[4];
    for (uint32_t day = 0u; day < 100u; day++) {
        give(0u, day, 1000u);
        TEST_ASSERT_TRUE(drawn("few", 4u, runs) >= 1u);
        TEST_ASSERT_EQUAL_UINT32(1u, drawn("one", 1u, runs));
    }
}

static void test_a_share_of_one_is_all_of_it_with_the_noise_of_the_tenth(void)
{
    bool runs[POINTS];
    uint32_t noise[POINTS], point;
    give(0u, 7u, 1u);
    grid_t all = grid_of("points", POINTS);
    for (uint32_t n = 0; n < POINTS; n++) {
        TEST_ASSERT_TRUE(grid_next(&all, &point));
        TEST_ASSERT_EQUAL_UINT32(n, point);
        noise[n] = seed_member;
    }
    TEST_ASSERT_FALSE(grid_next(&all, &point));
    give(0u, 7u, 10u);
    grid_t tenth = grid_of("points", POINTS);
    while (grid_next(&tenth, &point)) {
        TEST_ASSERT_EQUAL_UINT32(noise[point], seed_member);
    }
    TEST_ASSERT_TRUE(drawn("points", POINTS, runs) < POINTS / 4u);
}

static void test_days_and_names_draw_other_points(void)
{
    bool one[POINTS], other[POINTS];
    give(0u, 1u, 10u);
    drawn("points", POINTS, one);
    drawn("points", POINTS, other);
    TEST_ASSERT_EQUAL_MEMORY(one, other, sizeof one);
    drawn("others", POINTS, other);
    TEST_ASSERT_TRUE(memcmp(one, other, sizeof one) != 0);
    give(0u, 2u, 10u);
    drawn("points", POINTS, other);
    TEST_ASSERT_TRUE(memcmp(one, other, sizeof one) != 0);
}

/* Eight members are eight phases, whatever LAGLESS_SEED is; the first of what is written has none. */
static void test_eight_members_meet_every_phase(void)
{
    for (uint32_t noise = 0u; noise < 9u; noise++) {
        give(noise, 1u, 10u);
        uint32_t phases = 0u;
        for (seed_member = 0u; seed_member < SEED_PHASES; seed_member++) {
            phases |= 1u << seed_phase();
        }
        TEST_ASSERT_EQUAL_HEX32(0xffu, phases);
    }
    seed_member = 0u;
    give(0u, 1u, 10u);
    TEST_ASSERT_EQUAL_UINT32(0u, seed_phase());
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_tenth_runs_and_in_time_every_point);
    RUN_TEST(test_every_grid_has_a_point);
    RUN_TEST(test_a_share_of_one_is_all_of_it_with_the_noise_of_the_tenth);
    RUN_TEST(test_days_and_names_draw_other_points);
    RUN_TEST(test_eight_members_meet_every_phase);
    return UNITY_END();
}
