/* The capture of a running drive is compared bit for bit with the recording of the same run, for each
 * trigger. */
#include "app/app.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

#define COLUMNS 8u
#define PERIODS 512u
#define TAPPED  (COLUMNS + 1u)
#define SEEN    4096u

static const char *const signals[COLUMNS] = {"i_a",     "i_q", "u_dc",      "theta_e",
                                             "omega_m", "u_q", "theta_hat", "encoder_count"};

static uint32_t seen[SEEN][TAPPED]; /* the last periods, each at the index period modulo SEEN */

static void keep(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    (void)context;
    (void)period;
    memcpy(seen[slots[0] % SEEN], slots, count * sizeof slots[0]);
}

void setUp(void)
{
    rig = run_rig(18);
    run_parameter(rig, "position_source", 0.0);
    run_to_ready_at(rig, 300.0);
    run_on(rig, 300.0);
    run_seconds(rig, 0.5);
    run_expect_no_fault(rig);

    uint32_t ids[TAPPED] = {rig_row_by_name("period")->id};
    for (uint32_t n = 0; n < COLUMNS; n++) {
        char row[16];
        ids[1u + n] = rig_row_by_name(signals[n])->id;
        snprintf(row, sizeof row, "capture_%u", (unsigned)(1u + n));
        run_put(rig, row, ids[1u + n]);
    }
    run_put(rig, "capture_signals", COLUMNS);
    TEST_ASSERT_TRUE(rig_tap(rig, ids, TAPPED, 1u, keep, NULL));
}

static void order(const char *name)
{
    run_put(rig, "order", table_choice(rig_row_by_name("order"), name));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "order_refusal"));
}

static bool is(const char *state)
{
    return rig_value(rig, "capture_state") == table_choice(rig_row_by_name("capture_state"), state);
}

static void arm(const char *on, const char *source, double level, uint32_t after)
{
    run_put(rig, "capture_on", table_choice(rig_row_by_name("capture_on"), on));
    run_put(rig, "capture_source", rig_row_by_name(source)->id);
    run_put(rig, "capture_level", level);
    run_put(rig, "capture_after", after);
    order("capture_arm");
    TEST_ASSERT_TRUE(is("armed"));
}

/* Reads the record over the line: 512 periods of eight signals, of which the newest is this number of
 * periods after the trigger. Each value must be that of the recording. */
static void expect_held(uint32_t at, uint32_t after)
{
    TEST_ASSERT_TRUE(is("held"));
    TEST_ASSERT_EQUAL_UINT32(at, (uint32_t)rig_value(rig, "capture_at"));
    TEST_ASSERT_EQUAL_UINT32(PERIODS, (uint32_t)rig_value(rig, "capture_periods"));
    const uint32_t oldest = at + after + 1u - PERIODS;
    uint32_t bits = 0;
    for (uint32_t n = 0; n < PERIODS; n++) {
        const uint32_t *tapped = seen[(oldest + n) % SEEN];
        TEST_ASSERT_EQUAL_UINT32(oldest + n, tapped[0]);
        for (uint32_t c = 0; c < COLUMNS; c++) {
            TEST_ASSERT_TRUE(capturing_slot(COLUMNS * n + c, &bits));
            TEST_ASSERT_EQUAL_HEX32(tapped[1u + c], bits);
        }
    }
    TEST_ASSERT_FALSE(capturing_slot(COLUMNS * PERIODS, &bits));
}

static float tapped_float(uint32_t period, uint32_t column)
{
    float value;
    memcpy(&value, &seen[period % SEEN][1u + column], sizeof value);
    return value;
}

static uint32_t now(void)
{
    return (uint32_t)rig_value(rig, "period");
}

/* A reference rises, or an unexpected load is put on: the trigger is in the first period in which the
 * signal passes the level. */
static void test_a_signal_that_passes_its_level_triggers_in_its_own_period(void)
{
    static const struct {
        const char *on, *row;
        double level, value; /* [r/min]; value of the row that changes */
        uint32_t after;
    } cases[] = {{"above", "speed_request", 350.0, 400.0 * RPM, 256u},
                 {"below", "load_torque", 280.0, 0.5 * RUN_TORQUE(10.0 * RUN_LIMIT_SHARE), 100u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        if (n > 0u) {
            tearDown();
            setUp();
        }
        const float way = n == 0u ? 1.0f : -1.0f;
        const float level = (float)(cases[n].level * RPM);
        arm(cases[n].on, "omega_m", cases[n].level * RPM, cases[n].after);
        run_seconds(rig, 0.1);
        TEST_ASSERT_TRUE(is("armed"));
        run_put(rig, cases[n].row, cases[n].value);
        run_seconds(rig, 0.3);
        const uint32_t at = (uint32_t)rig_value(rig, "capture_at");
        expect_held(at, cases[n].after);
        TEST_ASSERT_TRUE(way * tapped_float(at, 4u) > way * level);
        TEST_ASSERT_TRUE(way * tapped_float(at - 1u, 4u) <= way * level);
    }
}

/* The step detects the fault, and the motor coasts after it. The reset of the fault keeps the captured
 * signals and settings. */
static void test_fault_triggers_and_its_reset_leaves_the_capture(void)
{
    arm("above", "omega_m", 1e6, 200u);
    run_seconds(rig, 0.1);
    run_put(rig, "dc_voltage", rig_value(rig, "dc_overvoltage") + 5.0);
    run_seconds(rig, 0.1);
    const uint32_t fault = (uint32_t)rig_value(rig, "fault_period");
    TEST_ASSERT_TRUE(rig_value(rig, "fault_reason") != 0.0);
    expect_held(fault, 200u);
    TEST_ASSERT_TRUE(rig_history_held(rig));
    TEST_ASSERT_EQUAL_DOUBLE(COLUMNS, rig_history_columns(rig));

    run_puts(rig, "dc_voltage=311 enable=0");
    run_seconds(rig, 0.1);
    run_put(rig, "fault_reset", 1.0);
    run_seconds(rig, 0.02);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    expect_held(fault, 200u);
}

/* The fault line of the power module acts between two steps. */
static void test_trip_triggers_with_the_step_before_it(void)
{
    arm("command", "omega_m", 0.0, 0u);
    run_seconds(rig, 0.1);
    const uint32_t before = now();
    run_put(rig, "force_fault", 1.0);
    run_seconds(rig, 0.05);
    TEST_ASSERT_EQUAL_UINT32(before, (uint32_t)rig_value(rig, "fault_period"));
    expect_held(before, 0u);
}

/* At the time of the fault the buffer already holds the record of another trigger: this record remains,
 * and the fault has no history. */
static void test_fault_leaves_what_is_held_already(void)
{
    arm("command", "omega_m", 0.0, 0u);
    run_seconds(rig, 0.1);
    const uint32_t at = now();
    order("capture_trigger");
    run_seconds(rig, 0.05);
    run_put(rig, "force_fault", 1.0);
    run_seconds(rig, 0.05);
    TEST_ASSERT_TRUE(rig_value(rig, "fault_reason") != 0.0);
    expect_held(at, 0u);
    TEST_ASSERT_FALSE(rig_history_held(rig));
}
