/* Parameters, copies and repeatability of the plant. */
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
    q.load_kind = PLANT_LOAD_ACTIVE; /* otherwise a negative load violates a rule between fields */
    q.dc_capacitance = 1e-3;         /* otherwise a lost supply violates a rule; no flux map has been read */
#define TRY(name, unit, standard, minimum, maximum, text)                                                    \
    {                                                                                                        \
        double keep = q.name;                                                                                \
        TEST_ASSERT_EQUAL_DOUBLE(standard, plant_params_default().name);                                     \
        q.name = minimum;                                                                                    \
        TEST_ASSERT_TRUE_MESSAGE(plant_params_check(&q, NULL), #name);                                       \
        q.name = maximum;                                                                                    \
        TEST_ASSERT_TRUE_MESSAGE(plant_params_check(&q, NULL) || &q.name == &q.flux_map, #name);             \
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

/* For each rule between fields: a set that breaks it, the field that is named with its remaining range,
 * and a change that makes the set valid again. An elastic shaft is limited by omega_n^2 = k (1/J +
 * 1/J_load) and by c (1/J + 1/J_load), each of which allows at most 1e5 rad/s. */
static void test_rules_between_fields_name_one_and_the_range_that_is_left(void)
{
    static const struct {
        const char *changes, *field;
        double minimum, maximum;
        const char *instead;
    } rules[] = {
        {"pole_pairs = 3.5", "pole_pairs", 1.0, 64.0, "pole_pairs = 3"},
        {"encoder_lines = 1024.5", "encoder_lines", 1.0, 1e6, "encoder_lines = 1024"},
        {"force_fault = 0.5", "force_fault", 0.0, 1.0, "force_fault = 1"},
        {"supply_lost = 1", "supply_lost", 0.0, 1.0, "dc_capacitance = 1e-4"},
        {"open_switches = 6, shorted_switches = 4", "shorted_switches", 0.0, 63.0, "shorted_switches = 9"},
        {"open_switches = 1.5", "open_switches", 0.0, 63.0, "open_switches = 1"},
        {"inertia = 0.002, load_inertia = 0.002, shaft_stiffness = 9e6, shaft_damping = 101", "shaft_damping",
         0.0, 100.0, "shaft_stiffness = 1e7, shaft_damping = 0"},
        {"inertia = 0.001, load_inertia = 0.001, shaft_stiffness = 9e6", "shaft_stiffness", 0.0, 5e6,
         "shaft_stiffness = 0"},
        {"load_torque = -1", "load_torque", 0.0, 1e4, "load_kind = 1"},
        {"friction_breakaway = 1.3199999", "friction_breakaway", 1.32, 1e3, "friction_breakaway = 1.32"},
        {"friction_breakaway = 1.32, friction_coulomb = 2", "friction_breakaway", 2.0, 1e3,
         "friction_breakaway = 0"},
    };
    for (size_t n = 0; n < sizeof rules / sizeof rules[0]; n++) {
        const plant_params_t wrong = plant_of(rules[n].changes);
        refused(&wrong, rules[n].field, rules[n].minimum, rules[n].maximum);
        const plant_params_t good = plant_with(wrong, rules[n].instead);
        TEST_ASSERT_TRUE_MESSAGE(plant_params_check(&good, NULL), rules[n].instead);
    }
}

/* A run that uses all features: noise, lag, soft link, harmonics, measurement of energy, a change of
 * parameters, a trip. */
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
    /* The copy is made in the middle of a period, with edges pending. */
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

static void test_the_times_of_reading_do_not_matter(void)
{
    /* The edges are the same; time advances once in whole periods and once in steps of an odd number of
     * ticks. */
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
        /* The shaft is of second order, the currents are of fourth order, and the borders of the zone are
         * found within 5 ns: together a tenth of a milliampere. */
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
