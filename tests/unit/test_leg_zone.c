/* Expected: with half of T_e u_dc/(3 L) = x zone, zone (x + (1 - e^(-2x))/(2x)), by hand. */
#include "medium/adapt/leg_zone.h"

#include "tests/unit/compare.h"

#define PERIOD 1e-4 /* [s] */

static double width_of(double zone, double inductance, double effective, double u_dc)
{
    return 1.0 / (double)leg_zone_inverse((float)(1.0 / zone),
                                          (float)(PERIOD / inductance * effective * u_dc / 6.0));
}

static void test_a_small_inductance_makes_the_zone_wider(void)
{
    /* half of 2.3 us of 300 V in 3 x 1.5 mH is 0.07667 A, x = 1.5333: 0.07667 A + 0.05 A 0.31089; the
     * approximation is 0.6 % too small */
    TEST_ASSERT_DOUBLE_WITHIN(6e-4, 0.09221, width_of(0.05, 1.5e-3, 0.023, 300.0));
    /* a tenth of the link voltage, x = 0.15333: 0.007667 A + 0.05 A 0.86121 */
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.0507271, width_of(0.05, 1.5e-3, 0.023, 30.0));
}

static void test_without_a_link_or_a_dead_time_it_is_that_of_the_node(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.05, width_of(0.05, 1.5e-3, 0.023, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.05, width_of(0.05, 1.5e-3, 0.0, 311.0));
}

static void test_a_dead_time_shorter_than_the_delays_does_not_make_the_zone_narrower(void)
{
    TEST_ASSERT_TRUE(width_of(0.05, 1.5e-3, -0.01, 311.0) >= 0.05);
}
