/* The electrical input must equal the sum of copper loss, inverter loss, mechanical output and stored
 * energy, each integrated by itself. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/plant/bench.h"
#include "unity.h"

static void start(const plant_params_t *q, double omega)
{
    plant_init(&plant, q, 1);
    plant_set_motion(&plant, 0.0, omega);
    plant_set_metering(&plant, true);
}

static void drive(int periods, double target, double most)
{
    for (int k = 0; k < periods; k++) {
        double wish = 0.5 * (target - plant.omega_m);
        loop.i_q_ref = wish > most ? most : wish < -most ? -most : wish;
        loop_period(&loop, &plant, NULL, NULL);
    }
}

/* The imbalance relative to the energy that was converted; the limit is 0.1 %. */
static plant_truth_t balanced(double kinetic_before, const char *what)
{
    plant_truth_t now = truth();
    double sinks = now.energy_copper + now.energy_inverter + now.energy_mechanical + now.energy_magnetic +
                   now.energy_kinetic - kinetic_before;
    double moved = fmax(fabs(now.energy_dc), fmax(fabs(now.energy_mechanical), now.energy_copper));
    TEST_ASSERT_TRUE_MESSAGE(moved > 1.0, what);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-3 * moved, now.energy_dc, sinks, what);
    return now;
}

/* Two masses whose natural frequency is 160 Hz. */
#define ELASTIC                                                                                              \
    "inertia = 0.003, load_inertia = 0.006, shaft_damping = 0.05, friction_coulomb = 0.3, load_torque = 4, " \
    "shaft_stiffness = 2000"

#define SATURATES                                                                                            \
    "inductance_d = 0.02, inductance_q = 0.04, saturation_d = 8, saturation_q = 8, inertia = 0.003"

static void test_energy_balances(void)
{
    static const struct {
        const char *name, *changes;
        double start, target, most, i_d; /* [rad/s], [A] */
        int periods;
        uint32_t averaged;
    } drives[] = {
        {"accelerating under load", "load_torque = 5, inertia = 0.003", 0.0, 157.0, 10.0, 0.0, 5000, 0u},
        {"the same averaged", "load_torque = 5, inertia = 0.003", 0.0, 157.0, 10.0, 0.0, 5000, 1u},
        {"braking into the link", "", 150.0, 0.0, 10.0, 0.0, 2000, 0u},
        {"at low current inside the zone", "", 10.0, 10.47, 10.0, 0.0, 5000, 0u},
        {"salient, with harmonics",
         "inductance_d = 0.008, inductance_q = 0.02, emf_5th = 0.03, emf_7th = 0.02, inertia = 0.003", 0.0,
         157.0, 10.0, -4.0, 3000, 0u},
        {"saturating on both axes", SATURATES, 0.0, 120.0, 10.0, -5.0, 3000, 0u},
        {"the same averaged", SATURATES, 0.0, 120.0, 10.0, -5.0, 3000, 1u},
        {"with a loss of the iron", SATURATES ", iron_loss_resistance = 150", 0.0, 120.0, 10.0, -5.0, 3000,
         0u},
        {"the same with a broken phase",
         SATURATES ", open_phase_c = 1, shaft_locked = 1, shaft_locked_speed = 80", 80.0, 90.0, 5.0, 0.0,
         2000, 0u},
        {"a broken phase",
         "inductance_d = 0.008, inductance_q = 0.02, open_phase_b = 1, shaft_locked = 1, shaft_locked_speed "
         "= 80",
         80.0, 90.0, 5.0, 0.0, 2000, 0u},
        {"an elastic load", ELASTIC, 0.0, 120.0, 10.0, 0.0, 4000, 0u},
        {"the same averaged", ELASTIC, 0.0, 120.0, 10.0, 0.0, 4000, 1u},
        {"an elastic load that sticks", ELASTIC ", friction_breakaway = 0.5", 0.0, 120.0, 10.0, 0.0, 4000,
         0u},
        {"a soft link", "dc_resistance = 1, dc_capacitance = 1e-3, load_torque = 5, inertia = 0.003", 0.0,
         157.0, 10.0, 0.0, 3000, 0u},
    };
    for (size_t n = 0; n < sizeof drives / sizeof drives[0]; n++) {
        const plant_params_t q = plant_of(drives[n].changes);
        setUp();
        loop.averaged = drives[n].averaged;
        loop.i_d_ref = drives[n].i_d;
        start(&q, drives[n].start);
        drive(drives[n].periods, drives[n].target, drives[n].most);
        const plant_truth_t end =
            balanced(0.5 * q.inertia * drives[n].start * drives[n].start, drives[n].name);
        if (q.load_inertia > 0.0) {
            TEST_ASSERT_DOUBLE_WITHIN(12.0, 120.0, end.omega_load);
        } else if (n == 0u) {
            TEST_ASSERT_TRUE(end.energy_copper > 1.0 && end.energy_inverter > 1.0 &&
                             end.energy_mechanical > 10.0);
        } else if (q.dc_resistance > 0.0) {
            /* 157 rad/s times 6.3 N m and the losses are about 1.1 kW, that is 3.6 A through 1 ohm. */
            TEST_ASSERT_DOUBLE_WITHIN(0.7, 311.0 - 3.6, end.dc_voltage);
        } else if (drives[n].target == 0.0) {
            TEST_ASSERT_TRUE(end.energy_dc < -10.0);
        }
    }
}

static void test_energy_balances_while_the_shaft_sticks_and_breaks_loose(void)
{
    plant_params_t q = plant_of("friction_breakaway = 4, load_torque = 1, inertia = 0.003");
    start(&q, 0.0);
    uint32_t rests = 0;
    for (int k = 0; k < 4000; k++) {
        loop.i_q_ref = k % 400 < 200 ? 0.04 * (k % 400) : 0.04 * (k % 400 - 400);
        loop_period(&loop, &plant, NULL, NULL);
        rests += plant.omega_m == 0.0;
    }
    balanced(0.0, "stiction");
    TEST_ASSERT_TRUE(rests > 400u && rests < 3600u);
}

static void test_energies_count_only_while_metered(void)
{
    plant_params_t q = plant_params_default();
    plant_truth_t now;
    start(&q, 0.0);
    plant_set_metering(&plant, false);
    drive(100, 157.0, 10.0);
    now = truth();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.energy_dc);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.energy_copper);
    plant_set_metering(&plant, true);
    drive(10, 157.0, 10.0);
    now = truth();
    TEST_ASSERT_TRUE(now.energy_copper > 0.0);
    plant_set_metering(&plant, true);
    now = truth();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.energy_copper);
}
