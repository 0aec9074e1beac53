/* The whole commissioning on the simulated drive. The drive has only the name plate data of the motors,
 * and the sensors have errors; the limits are those of docs/commissioning.md. Wrong wiring, and a fault
 * inside a step, are named. */
#include <math.h>
#include <string.h>
#include <unity.h>

#include "host_sim/lab/commission.h"
#include "tests/rig/seed.h"

typedef struct {
    double resistance, inductance_d, inductance_q, flux_linkage, pole_pairs, current, speed, inertia;
    double friction; /* [N m] dry friction */
    double zone;     /* [A] zone around zero in which the voltage of the legs changes its sign */
} machine_t;

static const machine_t machines[] = {
    {0.95, 12.5e-3, 12.5e-3, 0.183, 4.0, 5.0, 157.0, 3e-3, 0.1, 0.05},
    {0.42, 4.86e-3, 4.86e-3, 0.407, 1.0, 5.9, 243.0, 0.023, 0.15, 0.05},
    {2.9, 3.92e-3, 6.7e-3, 0.119, 2.0, 3.9, 470.0, 9.3e-4, 0.03, 0.05},
    {2.63, 8.6e-3, 8.6e-3, 0.06, 4.0, 3.8, 314.0, 3.1e-5, 0.014,
     0.05}, /* a light rotor: its rated torque makes 44000 rad/s^2 */
    {0.57, 8.7e-3, 22.8e-3, 0.108, 2.0, 7.0, 351.0, 2e-3, 0.023,
     0.05}, /* at I_max (L_q - L_d) I is 1.8 psi_f */
    {3.9, 12.6e-3, 12.6e-3, 0.477, 4.0, 1.2, 51.0, 0.0184, 0.235,
     0.15}, /* the zone is an eighth of the current */
};
#define MACHINES (sizeof machines / sizeof machines[0])

static const commission_options_t all = {.progress = NULL};

static rig_t *rig_with(const machine_t *m, uint64_t seed)
{
    rig_t *rig = run_rig(seed);
    TEST_ASSERT_NOT_NULL(rig);
    TEST_ASSERT_TRUE(
        rig_put(rig, "plant.pole_pairs", m->pole_pairs) && rig_put(rig, "plant.resistance", m->resistance) &&
        rig_put(rig, "plant.inductance_d", m->inductance_d) &&
        rig_put(rig, "plant.inductance_q", m->inductance_q) &&
        rig_put(rig, "plant.flux_linkage", m->flux_linkage) && rig_put(rig, "plant.inertia", m->inertia) &&
        rig_put(rig, "plant.friction_coulomb", m->friction) && rig_put(rig, "plant.current_zone", m->zone) &&
        rig_put(rig, "plant.current_offset_a", 0.05) && rig_put(rig, "plant.current_gain_error_b", 0.004) &&
        rig_put(rig, "plant.dc_noise", 0.2));
    return rig;
}

static void run(rig_t *rig, const machine_t *m, const commission_options_t *options,
                commission_result_t *result)
{
    const commission_plate_t plate = {m->pole_pairs, m->current, m->speed};
    scenario_error_t error = {.file = ""};
    TEST_ASSERT_TRUE_MESSAGE(commission_rig(rig, &plate, options, result, &error), error.message);
}

/* Slope of the least-squares line through the points of a step from this x on. */
static double slope_of(const commission_result_t *result, commission_do_t step, double from)
{
    double n = 0.0;
    double x = 0.0;
    double y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    for (uint32_t k = 0u; k < result->points_count; k++) {
        const commission_measured_t *point = &result->points[k];
        if (point->step == (uint32_t)step && point->x >= from) {
            n += 1.0;
            x += point->x;
            y += point->y;
            xx += point->x * point->x;
            xy += point->x * point->y;
        }
    }
    return (n * xy - x * y) / (n * xx - x * x);
}

static double largest_x(const commission_result_t *result, commission_do_t step)
{
    double most = 0.0;
    for (uint32_t k = 0u; k < result->points_count; k++) {
        const commission_measured_t *point = &result->points[k];
        most = point->step == (uint32_t)step ? fmax(most, point->x) : most;
    }
    return most;
}

/* The voltage over the current has the slope R, with the resistance of the devices, and the acceleration over
 * the torque has the slope 1/J: the pictures of these points show where the results come from. */
static void expect_slopes(rig_t *rig, const machine_t *m, const commission_result_t *result)
{
    const double path = m->resistance + rig_value(rig, "device_resistance");
    const double third = largest_x(result, COMMISSION_DO_resistance) / 3.0;
    TEST_ASSERT_DOUBLE_WITHIN(fmax(0.02 * m->resistance, 0.01), path,
                              slope_of(result, COMMISSION_DO_resistance, third));
    TEST_ASSERT_DOUBLE_WITHIN(0.04 / m->inertia, 1.0 / m->inertia,
                              slope_of(result, COMMISSION_DO_inertia, -HUGE_VAL));
}

/* The result states the uncertainty of each value. */
static void expect_stated(rig_t *rig, const machine_t *m, const commission_result_t *result)
{
    const struct {
        const char *name;
        double true_value;
        commission_value_t measured;
    } rows[] = {
        {"resistance", m->resistance, result->resistance},
        {"inductance_d", m->inductance_d, result->inductance_d},
        {"inductance_q", m->inductance_q, result->inductance_q},
        {"flux_linkage", m->flux_linkage, result->flux_linkage},
        {"inertia", m->inertia, result->inertia},
        {"friction_coulomb", m->friction, result->friction_coulomb},
        {"friction_viscous", rig_value(rig, "plant.friction_viscous"), result->friction_viscous},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(rows[n].measured.error, rows[n].true_value, rows[n].measured.value,
                                          rows[n].name);
    }
}

/* The limits of the errors are: R 2 % or 10 mohm, L_d 1.5 %, L_q 3 %, psi_f 1 % and 0.7 V of its EMF, J 4
 * %. The limit of the friction at half the rated speed is 1.5 % of the rated torque. The current stays
 * below 1.25 of twice the rated current plus half the ripple. */
static void test_unknown_motors_are_measured_within_the_limits(void)
{
    for (uint32_t n = 0u; n < MACHINES; n++) {
        const machine_t *m = &machines[n];
        commission_result_t result;
        rig_t *rig = rig_with(m, n + 1u);
        run(rig, m, &all, &result);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("", result.reason, result.what);
        const double emf = 0.58 * m->speed * m->pole_pairs * m->flux_linkage;
        const double viscous = rig_value(rig, "plant.friction_viscous");
        const double ripple = 311.0 * RIG_PERIOD_SECONDS / (12.0 * m->inductance_d);
        TEST_ASSERT_DOUBLE_WITHIN(fmax(0.02 * m->resistance, 0.01), m->resistance, result.resistance.value);
        TEST_ASSERT_DOUBLE_WITHIN(0.015 * m->inductance_d, m->inductance_d, result.inductance_d.value);
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * m->inductance_q, m->inductance_q, result.inductance_q.value);
        TEST_ASSERT_DOUBLE_WITHIN((0.01 + 0.7 / emf) * m->flux_linkage, m->flux_linkage,
                                  result.flux_linkage.value);
        TEST_ASSERT_DOUBLE_WITHIN(0.04 * m->inertia, m->inertia, result.inertia.value);
        TEST_ASSERT_DOUBLE_WITHIN(0.015 * 1.5 * m->pole_pairs * m->flux_linkage * m->current,
                                  m->friction + 0.5 * m->speed * viscous,
                                  result.friction_coulomb.value +
                                      0.5 * m->speed * result.friction_viscous.value);
        TEST_ASSERT_TRUE(result.largest_current <= 1.25 * 2.0 * m->current + 0.5 * ripple);
        TEST_ASSERT_TRUE(result.largest_heat > 0.0 && result.largest_heat <= 1.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.05, 1.0, result.loop_gain);
        TEST_ASSERT_TRUE(result.least_speed > 0.0 && result.least_speed < m->speed);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "enable"));
        expect_slopes(rig, m, &result);
        expect_stated(rig, m, &result);
        rig_free(rig);
    }
}

/* The motor has 1 A and 2900 rad/s. The guess of J, with which the rated torque needs 0.05 s to the rated
 * speed, is 9.6e-7 kg m^2, less than the parameter allows. */
static void test_guess_of_a_very_light_rotor_is_accepted(void)
{
    const machine_t light = {3.0, 8e-3, 8e-3, 0.03, 1.0, 1.0, 2900.0, 1e-6, 1e-3, 0.05};
    commission_options_t options = {.progress = NULL};
    commission_result_t result;
    char why[128];
    rig_t *rig = rig_with(&light, 12u);
    TEST_ASSERT_TRUE(commission_choose(&options, "wiring", why, sizeof why));
    run(rig, &light, &options, &result);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", result.reason, result.what);
    rig_free(rig);
}

static void expect_reason(const char *row, double value, const char *reason)
{
    commission_result_t result;
    rig_t *rig = rig_with(&machines[0], 11u);
    TEST_ASSERT_TRUE(rig_put(rig, row, value));
    run(rig, &machines[0], &all, &result);
    TEST_ASSERT_EQUAL_STRING(reason, result.reason);
    TEST_ASSERT_EQUAL_UINT32(COMMISSION_DO_wiring, result.step);
    TEST_ASSERT_TRUE(isnan(result.resistance.value));
    TEST_ASSERT_TRUE(result.largest_current < 0.7 * 2.0 * machines[0].current);
    rig_free(rig);
}

static void test_wrong_wiring_is_named_before_a_steady_current_flows(void)
{
    expect_reason("open_phase_a", 1.0, "open_phase");
    expect_reason("open_phase_b", 1.0, "open_phase");
    expect_reason("open_phase_c", 1.0, "open_phase");
    expect_reason("swap_currents", 3.0, "sensor_map");
    expect_reason("swap_currents", 4.0, "sensor_map"); /* the current decreases along the pulse */
    expect_reason("current_gain_error_a", -2.0, "sensor_map");
}

/* The constant value is that of no current. A bridge that is on reports another one as a stuck sensor. */
static void test_sensor_that_is_stuck_without_a_current_is_named(void)
{
    expect_reason("rig.stuck_current_a", 2048.0, "sensor_stuck");
    expect_reason("rig.stuck_current_b", 2048.0, "sensor_stuck");
}

/* Sensors without noise do not change while the pulses are along the axis of an open phase. */
static void test_open_phase_of_quiet_sensors_is_named(void)
{
    for (int phase = 0; phase < 3; phase++) {
        static const char *const rows[] = {"open_phase_a", "open_phase_b", "open_phase_c"};
        commission_result_t result;
        rig_t *rig = rig_with(&machines[0], 13u);
        TEST_ASSERT_TRUE(rig_put(rig, rows[phase], 1.0) && rig_put(rig, "plant.current_noise", 0.0));
        run(rig, &machines[0], &all, &result);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("open_phase", result.reason, rows[phase]);
        rig_free(rig);
    }
}

static void test_motor_that_is_not_connected_is_named(void)
{
    commission_result_t result;
    rig_t *rig = rig_with(&machines[0], 13u);
    TEST_ASSERT_TRUE(rig_put(rig, "open_phase_a", 1.0) && rig_put(rig, "open_phase_b", 1.0) &&
                     rig_put(rig, "open_phase_c", 1.0) && rig_put(rig, "plant.current_noise", 0.0));
    run(rig, &machines[0], &all, &result);
    TEST_ASSERT_EQUAL_STRING("no_motor_current", result.reason);
    rig_free(rig);
}

/* Puts a fault into the plant when this step begins. */
static void break_it(void *context, commission_do_t step, bool done, const commission_result_t *result)
{
    (void)result;
    if (step == COMMISSION_DO_resistance && !done) {
        TEST_ASSERT_TRUE(rig_put(context, "force_fault", 1.0));
    }
}

static void test_a_fault_inside_a_step_ends_it_with_the_bridge_open(void)
{
    commission_result_t result;
    rig_t *rig = rig_with(&machines[0], 12u);
    const commission_options_t options = {.progress = break_it, .context = rig};
    run(rig, &machines[0], &options, &result);
    TEST_ASSERT_TRUE(result.reason[0] != '\0');
    TEST_ASSERT_EQUAL_UINT32(COMMISSION_DO_resistance, result.step);
    TEST_ASSERT_TRUE(isnan(result.resistance.value));
    TEST_ASSERT_TRUE(fabs(rig_value(rig, "true_i_a")) < 1e-3);
    rig_free(rig);
}
