/* Faults during the steps of commissioning: the bridge opens as in any other state, the reason is that of
 * the fault, and no value is saved. One commissioning runs, and in the middle of each step every fault is
 * tried on a copy of the simulation. Further tests cover a step in which the rotor is lost, and one that
 * is repeated, stopped, or cannot reach the rated speed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unity.h>

#include "host_sim/lab/commission.h"
#include "settings/reasons.h"
#include "tests/rig/seed.h"

static const commission_plate_t plate = {4.0, 5.0, 157.0};

typedef struct {
    const char *row;
    double value;
    const char *reason;
    uint32_t most; /* [periods] from the fault to the open bridge: the time in the row of the fault table, and
                      three periods */
} wrong_t;

static const wrong_t wrongs[] = {
    {"rig.stuck_current_a", 4095.0, "bad_sample", 6u},
    {"rig.stuck_current_b", 0.0, "bad_sample", 6u},
    {"plant.force_fault", 1.0, "module_fault", 4u},
    {"plant.dc_voltage", 420.0, "dc_overvoltage", 5u},
    {"plant.dc_voltage", 150.0, "dc_undervoltage", 13u},
    {"rig.stuck_dc_link", 4095.0, "dc_overvoltage", 5u},
    {"rig.interrupt_delay", 120e-6, "late", 8u},
    {"rig.missing_samples", 10.0, "late", 16u},
    {"plant.sink_temperature", 95.0, "sink_hot", 9000u},
    {"plant.motor_temperature", 140.0, "motor_hot", 9000u}, /* a motor that turns is braked first */
};

/* The middle of a step [samples of 2.5 ms]. */
static const uint32_t middles[COMMISSION_STEP_COUNT] = {
    [COMMISSION_DO_wiring] = 30u,      [COMMISSION_DO_resistance] = 1000u,  [COMMISSION_DO_angle] = 1000u,
    [COMMISSION_DO_inductance] = 400u, [COMMISSION_DO_current_loop] = 700u, [COMMISSION_DO_turn] = 1000u,
    [COMMISSION_DO_swing] = 400u,      [COMMISSION_DO_flux] = 600u,         [COMMISSION_DO_inertia] = 1600u,
    [COMMISSION_DO_least_speed] = 300u};

typedef struct {
    rig_t *rig;
    void *copy;
    uint32_t looks[COMMISSION_STEP_COUNT];
    uint32_t begun[COMMISSION_STEP_COUNT]; /* how often each step has begun */
    uint32_t tried;                        /* number of faults that were tried */
    uint32_t gates;
    commission_do_t at;  /* the step in which the fault occurs */
    double load;         /* [N m] load during the first tries of the step */
    uint32_t load_tries; /* number of these tries */
    bool stops;
} bench_t;

static void watch_gates(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    bench_t *bench = context;
    (void)tick;
    if (what == (uint32_t)RIG_EDGE_GATES) {
        bench->gates = value;
    }
}

static rig_t *rig_with_motor(uint64_t seed)
{
    rig_t *rig = run_rig(seed);
    TEST_ASSERT_NOT_NULL(rig);
    TEST_ASSERT_TRUE(rig_put(rig, "plant.inertia", 3e-3) && rig_put(rig, "plant.friction_coulomb", 0.1));
    return rig;
}

/* Tries one fault on a copy of the simulation in the middle of a step. */
static void try_fault(bench_t *bench, commission_do_t step, const wrong_t *wrong)
{
    char text[160];
    rig_t *rig = bench->rig;
    const double stored = rig_value(rig, "store_state");
    uint32_t open = 0u;
    uint32_t period = 0u;
    snprintf(text, sizeof text, "%s = %g in %s", wrong->row, wrong->value, commission_step_name(step));
    TEST_ASSERT_TRUE_MESSAGE(bench->gates != 0u, text);
    TEST_ASSERT_TRUE_MESSAGE(rig_put(rig, wrong->row, wrong->value), text);
    /* 40 periods more, since the fault is latched after the end of the window. */
    for (; period < wrong->most + 40u; period++) {
        rig_step(rig);
        open = bench->gates != 0u ? period + 1u : open;
    }
    const reason_row_t *row = reason_by_number((int32_t)rig_value(rig, "fault_reason"));
    TEST_ASSERT_NOT_NULL_MESSAGE(row, text);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(wrong->reason, row->name, text);
    TEST_ASSERT_TRUE_MESSAGE(open <= wrong->most, text);
    TEST_ASSERT_TRUE_MESSAGE(
        fabs(rig_value(rig, "true_i_a")) < 0.02 && fabs(rig_value(rig, "true_i_b")) < 0.02, text);
    TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(stored, rig_value(rig, "store_state"), text);
    bench->tried++;
}

static bool throw_faults(void *context, commission_do_t step)
{
    bench_t *bench = context;
    bench->looks[step]++;
    if (step == COMMISSION_DO_board || bench->looks[step] != middles[step]) {
        return true;
    }
    rig_save(bench->rig, bench->copy);
    for (size_t n = 0u; n < sizeof wrongs / sizeof wrongs[0]; n++) {
        const uint32_t gates = bench->gates;
        try_fault(bench, step, &wrongs[n]);
        TEST_ASSERT_TRUE(rig_load(bench->rig, bench->copy, rig_state_size()));
        bench->gates = gates;
    }
    return true;
}

/* The test first runs all steps except `angle` while the shaft is held. Then it runs `angle` with a motor
 * without saturation, because the currents of such a motor cannot show the direction of the magnets. */
static void test_every_fault_opens_the_bridge_in_every_step(void)
{
    bench_t bench = {.rig = rig_with_motor(3u), .copy = malloc(rig_state_size())};
    commission_result_t result;
    scenario_error_t error = {.file = ""};
    commission_options_t options = {
        .goes_on = throw_faults, .context = &bench, .chosen = true, .plant_answers = true};
    options.skip[COMMISSION_DO_angle] = true;
    TEST_ASSERT_NOT_NULL(bench.copy);
    rig_watch_edges(bench.rig, watch_gates, &bench);
    TEST_ASSERT_TRUE(commission_rig(bench.rig, &plate, &options, &result, &error));
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", result.reason, result.what);
    for (uint32_t n = 0u; n < COMMISSION_STEP_COUNT; n++) {
        options.skip[n] = n != (uint32_t)COMMISSION_DO_angle;
    }
    TEST_ASSERT_TRUE(rig_put(bench.rig, "plant.shaft_locked", 1.0));
    TEST_ASSERT_TRUE(commission_rig(bench.rig, &plate, &options, &result, &error));
    TEST_ASSERT_EQUAL_STRING_MESSAGE("no_standstill_angle", result.reason, result.what);
    TEST_ASSERT_TRUE(isnan(result.angle_d));
    TEST_ASSERT_EQUAL_UINT32((COMMISSION_STEP_COUNT - 1u) * (sizeof wrongs / sizeof wrongs[0]), bench.tried);
    free(bench.copy);
    rig_free(bench.rig);
}

/* ---- ends of a step ---- */

static void count_tries(void *context, commission_do_t step, bool done, const commission_result_t *result)
{
    bench_t *bench = context;
    (void)result;
    if (!done && step == bench->at) {
        bench->begun[step]++;
        const double load = bench->begun[step] <= bench->load_tries ? bench->load : 0.0;
        TEST_ASSERT_TRUE(rig_put(bench->rig, "rig.brake_torque", load));
    }
}

static bool stop_in_the_middle(void *context, commission_do_t step)
{
    bench_t *bench = context;
    bench->looks[step]++;
    return !(bench->stops && step == bench->at && bench->looks[step] == middles[step]);
}

static void commission_with(bench_t *bench, const commission_plate_t *of, commission_result_t *result)
{
    scenario_error_t error = {.file = ""};
    const commission_options_t options = {
        .progress = count_tries, .goes_on = stop_in_the_middle, .context = bench};
    bench->rig = rig_with_motor(5u);
    TEST_ASSERT_TRUE(commission_rig(bench->rig, of, &options, result, &error));
    rig_free(bench->rig);
}

static void test_step_that_lost_the_rotor_is_tried_again(void)
{
    commission_result_t result;
    bench_t bench = {.at = COMMISSION_DO_flux, .load = 1000.0, .load_tries = 1u};
    commission_with(&bench, &plate, &result);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", result.reason, result.what);
    TEST_ASSERT_EQUAL_UINT32(2u, bench.begun[COMMISSION_DO_flux]);
    bench = (bench_t){.at = COMMISSION_DO_flux, .load = 1000.0, .load_tries = 9u};
    commission_with(&bench, &plate, &result);
    TEST_ASSERT_EQUAL_UINT32(3u, bench.begun[COMMISSION_DO_flux]);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("start_stalled", result.reason, result.what);
    TEST_ASSERT_TRUE(isfinite(result.inductance_q.value) && !isfinite(result.flux_linkage.value));
}

/* The rated speed is 120 rad/s electrical. */
static void test_small_rated_speed_is_named_when_a_turning_step_fails(void)
{
    const commission_plate_t slow = {4.0, 5.0, 30.0};
    commission_result_t result;
    bench_t bench = {.at = COMMISSION_DO_flux, .load = 1000.0, .load_tries = 9u};
    commission_with(&bench, &slow, &result);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("speed_range_small", result.reason, result.what);
    TEST_ASSERT_NOT_NULL(strstr(result.what, "120 rad/s"));
}

static void test_user_stops_a_step_and_keeps_what_is_known(void)
{
    commission_result_t result;
    bench_t bench = {.at = COMMISSION_DO_inductance, .stops = true};
    commission_with(&bench, &plate, &result);
    TEST_ASSERT_EQUAL_STRING("stopped_by_user", result.reason);
    TEST_ASSERT_EQUAL_UINT32(COMMISSION_DO_inductance, result.step);
    TEST_ASSERT_TRUE(isfinite(result.resistance.value) && !isfinite(result.inductance_d.value));
}

/* A step that is requested alone first runs the steps that it needs, and runs none after it. */
static void test_step_that_is_requested_alone_runs_those_that_it_needs(void)
{
    scenario_error_t error = {.file = ""};
    commission_result_t result;
    commission_options_t options = {.progress = NULL};
    for (uint32_t n = 0u; n < COMMISSION_STEP_COUNT; n++) {
        options.skip[n] = n != (uint32_t)COMMISSION_DO_resistance;
    }
    rig_t *rig = rig_with_motor(6u);
    TEST_ASSERT_TRUE(commission_rig(rig, &plate, &options, &result, &error));
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", result.reason, result.what);
    TEST_ASSERT_EQUAL_UINT32(COMMISSION_DO_resistance, result.step);
    TEST_ASSERT_TRUE(isfinite(result.resistance.value) && result.step_seconds[COMMISSION_DO_board] == 0.0);
    rig_free(rig);
}

/* The meter shows 4 % more link voltage than the drive; 2.5 % are within the errors of divider and meter. */
static void test_a_link_that_contradicts_the_meter_ends_before_the_first_step(void)
{
    scenario_error_t error = {.file = ""};
    commission_result_t result;
    commission_options_t options = {.link = 1.04 * 311.0};
    for (uint32_t n = 1u; n < COMMISSION_STEP_COUNT; n++) {
        options.skip[n] = true;
    }
    rig_t *rig = rig_with_motor(7u);
    TEST_ASSERT_TRUE(commission_rig(rig, &plate, &options, &result, &error));
    TEST_ASSERT_EQUAL_STRING("link_mismatch", result.reason);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, result.step_seconds[COMMISSION_DO_board]);
    options.link = 1.025 * 311.0;
    TEST_ASSERT_TRUE(commission_rig(rig, &plate, &options, &result, &error));
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", result.reason, result.what);
    rig_free(rig);
}
