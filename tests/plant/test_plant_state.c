/* Parameters, copies, repeatability. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/plant/bench.h"
#include "unity.h"

static plant_t copy;

static void refused(const plant_params_t *q, const char *field, double minimum, double maximum)
{
    plant_params_error_t why;
    memset(&why, 0, sizeof why);
    TEST_ASSERT_FALSE_MESSAGE(plant_params_check(q, &why), field);
    TEST_ASSERT_FALSE(plant_params_check(q, NULL));
    TEST_ASSERT_EQUAL_STRING(field, why.field);
    TEST_ASSERT_EQUAL_DOUBLE(minimum, why.minimum);
    TEST_ASSERT_EQUAL_DOUBLE(maximum, why.maximum);
    TEST_ASSERT_NOT_NULL(why.rule);
}

static void test_every_range_is_enforced_below_at_and_above(void)
{
    plant_params_t q = plant_params_default();
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
    q.load_kind = PLANT_LOAD_ACTIVE; /* or a negative load breaks the cross-rule */
    q.dc_capacitance = 1e-3;         /* or a lost supply does */
#define TRY(name, unit, standard, minimum, maximum, text)                                                    \
    {                                                                                                        \
        double keep = q.name;                                                                                \
        TEST_ASSERT_EQUAL_DOUBLE(standard, plant_params_default().name);                                     \
        q.name = minimum;                                                                                    \
        TEST_ASSERT_TRUE_MESSAGE(plant_params_check(&q, NULL), #name);                                       \
        q.name = maximum;                                                                                    \
        TEST_ASSERT_TRUE_MESSAGE(plant_params_check(&q, NULL), #name);                                       \
        q.name = nextafter(minimum, -1e300);                                                                 \
        refused(&q, #name, minimum, maximum);                                                                \
        q.name = nextafter(maximum, 1e300);                                                                  \
        refused(&q, #name, minimum, maximum);                                                                \
        q.name = (double)NAN;                                                                                \
        refused(&q, #name, minimum, maximum);                                                                \
        q.name = keep;                                                                                       \
    }
    PLANT_PARAMS(TRY)
#undef TRY
}

static void test_counting_parameters_must_be_whole(void)
{
    plant_params_t q = plant_of("pole_pairs = 3.5");
    refused(&q, "pole_pairs", 1.0, 64.0);
    q = plant_of("encoder_lines = 1024.5");
    refused(&q, "encoder_lines", 1.0, 1e6);
    q = plant_of("force_fault = 0.5");
    refused(&q, "force_fault", 0.0, 1.0);
}

static void test_a_lost_supply_needs_a_capacitor(void)
{
    plant_params_t q = plant_of("supply_lost = 1");
    refused(&q, "supply_lost", 0.0, 1.0);
    q.dc_capacitance = 1e-4;
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
}

static void test_a_switch_is_open_or_shorted_not_both(void)
{
    plant_params_t q = plant_of("open_switches = 6, shorted_switches = 9");
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
    q.shorted_switches = 4.0;
    refused(&q, "shorted_switches", 0.0, 63.0);
    q.open_switches = 1.5;
    refused(&q, "open_switches", 0.0, 63.0);
}

/* omega_n^2 = k (1/J + 1/J_load) and c (1/J + 1/J_load), each to 1e5 rad/s. */
static void test_an_elastic_shaft_has_an_end_of_its_speed(void)
{
    plant_params_t q = plant_of("inertia = 0.002, load_inertia = 0.002, shaft_stiffness = 1e7");
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
    q.shaft_stiffness = 9e6;
    q.shaft_damping = 101.0;
    refused(&q, "shaft_damping", 0.0, 100.0);
    q.inertia = 0.001;
    q.load_inertia = 0.001;
    refused(&q, "shaft_stiffness", 0.0, 5e6);
    q.shaft_stiffness = 0.0;
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
}

static void test_passive_load_can_not_be_negative(void)
{
    plant_params_t q = plant_of("load_torque = -1");
    refused(&q, "load_torque", 0.0, 1e4);
    q.load_kind = PLANT_LOAD_ACTIVE;
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
}

static void test_break_away_is_none_or_no_less_than_dry_friction(void)
{
    plant_params_t q = plant_params_default();
    q.friction_breakaway = nextafter(q.friction_coulomb, 0.0);
    refused(&q, "friction_breakaway", q.friction_coulomb, 1e3);
    plant_params_error_t why;
    TEST_ASSERT_FALSE(plant_params_check(&q, &why));
    TEST_ASSERT_NOT_NULL(strstr(why.rule, "friction_coulomb"));
    TEST_ASSERT_NOT_NULL(strstr(why.rule, "friction_breakaway"));
    q.friction_breakaway = q.friction_coulomb;
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
    q.friction_coulomb = 2.0;
    refused(&q, "friction_breakaway", 2.0, 1e3);
    q.friction_breakaway = 0.0;
    TEST_ASSERT_TRUE(plant_params_check(&q, NULL));
}

/* A run that meets everything: noise, lag, soft link, harmonics, metering, a change of parameters, a trip. */
static double busy(plant_t *p, loop_t *by, int from, int to)
{
    double sum = 0.0;
    for (int k = from; k < to; k++) {
        if (k == 150) {
            plant_params_t q = p->params;
            q.load_torque = 5.0;
            plant_set_params(p, &q);
        }
        if (k == 250) {
            plant_gates(p, p->tick, by->gates | PLANT_UPPER(0) | PLANT_LOWER(0));
        }
        by->i_q_ref = 6.0;
        loop_period(by, p, NULL, NULL);
        sum += plant_analog(p, PLANT_CURRENT_A) + plant_analog(p, PLANT_DC_LINK) + (double)plant_encoder(p);
    }
    return sum;
}

static void test_copied_state_runs_on_identically(void)
{
    plant_params_t q = plant_of("dc_resistance = 0.5, dc_capacitance = 1e-3, dc_noise = 0.5, "
                                "current_bandwidth = 3e5, emf_5th = 0.02, inductance_q = 0.015");
    plant_init(&plant, &q, 5);
    plant_set_metering(&plant, true);
    busy(&plant, &loop, 0, 100);
    /* In the middle of a period, with edges pending. */
    plant_gates(&plant, plant.tick + 7u, loop.gates ^ (PLANT_UPPER(1) | PLANT_LOWER(1)));
    TEST_ASSERT_TRUE(plant.pending_count > 0);
    plant_advance(&plant, 101u * LOOP_PERIOD);
    memcpy(&copy, &plant, sizeof copy);
    loop_t other = loop;
    double one = busy(&plant, &loop, 101, 400);
    double two = busy(&copy, &other, 101, 400);
    TEST_ASSERT_EQUAL_DOUBLE(one, two);
    TEST_ASSERT_EQUAL_MEMORY(&plant, &copy, sizeof plant);
    TEST_ASSERT_TRUE(plant.shoot_throughs > 0);
}

static void test_two_plants_do_not_disturb_each_other(void)
{
    static plant_t third;
    const plant_params_t q = plant_params_default();
    const plant_params_t r = plant_of("inertia = 0.003");
    loop_t other = loop;
    loop_t alone = loop;
    plant_init(&plant, &q, 5);
    plant_init(&copy, &r, 6);
    plant_init(&third, &q, 5);
    for (int k = 0; k < 200; k++) {
        busy(&plant, &loop, k, k + 1);
        busy(&copy, &other, k, k + 1);
    }
    busy(&third, &alone, 0, 200);
    TEST_ASSERT_EQUAL_MEMORY(&plant, &third, sizeof plant);
}

static void test_where_one_stops_to_look_does_not_matter(void)
{
    /* The same edges, once in whole periods and once in steps of an odd number of ticks. */
    plant_params_t q = plant_of("current_noise = 0, inertia = 0.003");
    static oracle_edge_t edges[12 * 100];
    size_t count = 0;
    loop.i_q_ref = 6.0;
    plant_init(&plant, &q, 1);
    for (int k = 0; k < 100; k++) {
        loop_period(&loop, &plant, edges, &count);
    }
    plant_init(&copy, &q, 1);
    size_t next = 0;
    for (uint64_t tick = 0; tick < 100u * LOOP_PERIOD; tick += 997u) {
        while (next < count && edges[next].tick <= tick) {
            plant_gates(&copy, edges[next].tick, edges[next].on);
            next++;
        }
        plant_advance(&copy, tick);
    }
    while (next < count) {
        plant_gates(&copy, edges[next].tick, edges[next].on);
        next++;
    }
    plant_advance(&copy, 100u * LOOP_PERIOD);
    for (int leg = 0; leg < 3; leg++) {
        /* Second order of the shaft, fourth of the currents, borders of the zone to 5 ns: a tenth of a
         * milliampere. */
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, plant.i[leg], copy.i[leg]);
    }
    TEST_ASSERT_TRUE(fabs(plant.i[0]) + fabs(plant.i[1]) > 1.0);
    plant_advance(&copy, 5u);
    TEST_ASSERT_EQUAL_UINT64(100u * LOOP_PERIOD, copy.tick);
}

static void test_every_leg_state_has_a_text(void)
{
    for (int leg = PLANT_LEG_OPEN; leg <= PLANT_LEG_AVERAGED; leg++) {
        TEST_ASSERT_TRUE(strlen(plant_leg_text((plant_leg_t)leg)) > 3);
    }
}
