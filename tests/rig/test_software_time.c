/* The software takes the time that its rows state: the writes of the interrupt come when its time is over,
 * and a section with interrupts off delays them. tests/chip/test_busy.c tests the chip during this time,
 * tick by tick. */
#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

#define RPM_ASKED 700.0

/* The last sample interrupt [ticks from t_0]. */
static struct {
    uint64_t enter, exit;
} seen;

static void on_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    (void)context;
    if (value == PIE_SEQ1INT && what == RIG_EDGE_ISR_ENTER) {
        seen.enter = tick;
    }
    if (value == PIE_SEQ1INT && what == RIG_EDGE_ISR_EXIT) {
        seen.exit = tick;
    }
}

void setUp(void)
{
    rig = run_rig(5);
    run_put(rig, "fidelity", 1.0);
    run_to_ready_at(rig, RPM_ASKED);
    rig_watch_edges(rig, on_edge, NULL);
}

static void start(void)
{
    run_on(rig, RPM_ASKED);
    run_seconds(rig, 0.5);
    run_expect_no_fault(rig);
}

static double interrupt_ticks(void)
{
    return RIG_INTERRUPT_CYCLES * (150e6 / (double)BOARD_SYSCLK_HZ);
}

/* The interrupt takes this number of periods. */
static void put_interrupt(double periods)
{
    run_put(rig, "interrupt_time", periods * (double)RIG_PERIOD_TICKS / interrupt_ticks());
}

/* ---- the interrupt ---- */

static double tracked(const char *key)
{
    FILE *file = fopen(COST_FILE, "r");
    TEST_ASSERT_NOT_NULL(file);
    char text[4000] = "";
    TEST_ASSERT_TRUE(fread(text, 1, sizeof text - 1u, file) > 0u);
    fclose(file);
    const char *found = strstr(text, key);
    TEST_ASSERT_NOT_NULL_MESSAGE(found, key);
    return strtod(found + strlen(key), NULL);
}

static void test_the_tracked_cost_is_what_interrupt_and_medium_task_take(void)
{
    const double interrupt = tracked("\"isr_cycles_c28x_estimate\":");
    const double medium = tracked("\"medium_cycles_c28x_estimate\":");
    TEST_ASSERT_DOUBLE_WITHIN(0.25 * interrupt, interrupt, RIG_INTERRUPT_CYCLES);
    TEST_ASSERT_DOUBLE_WITHIN(0.25 * medium, medium, RIG_MEDIUM_CYCLES);
}

static void test_from_entry_to_exit_it_is_the_row(void)
{
    static const double factors[] = {0.0, 0.5, 1.0, 3.0};
    for (size_t n = 0; n < sizeof factors / sizeof factors[0]; n++) {
        run_put(rig, "interrupt_time", factors[n]);
        rig_step(rig);
        TEST_ASSERT_DOUBLE_WITHIN(0.5, factors[n] * interrupt_ticks(), (double)(seen.exit - seen.enter));
    }
}

/* A copy of the running rig. */
static rig_t *copy(void)
{
    void *state = malloc(rig_state_size());
    TEST_ASSERT_NOT_NULL(state);
    rig_save(rig, state);
    rig_t *other = run_rig(1);
    TEST_ASSERT_TRUE(rig_load(other, state, rig_state_size()));
    free(state);
    return other;
}

/* Both simulations must have the same signals, to the bit, while they get another speed request and a
 * load. */
static void expect_same_bits(rig_t *other)
{
    static const char *const rows[] = {"i_a",     "i_b",     "u_dc",        "duty_a",       "duty_b",
                                       "theta_e", "i_q_ref", "omega_m_ref", "true_omega_m", "state"};
    rig_t *const both[] = {rig, other};
    for (size_t n = 0; n < 2u; n++) {
        run_put(both[n], "speed_request", 900.0 * RPM);
        run_put(both[n], "load_torque", 1.0);
    }
    for (uint32_t n = 0; n < 2000; n++) {
        rig_step(rig);
        rig_step(other);
        for (size_t m = 0; m < sizeof rows / sizeof rows[0]; m++) {
            TEST_ASSERT_EQUAL_DOUBLE(rig_value(other, rows[m]), rig_value(rig, rows[m]));
        }
    }
    rig_free(other);
}

/* hal_read takes the samples of t_k whatever the rest of the interrupt takes, and duties act from t_{k+1}
 * on if they are written before it. Gates are switched at the end of the interrupt, so that they must be
 * on before. */
static void test_within_the_period_no_bit_depends_on_it(void)
{
    start();
    run_put(rig, "medium_time", 0.0);
    rig_t *quick = copy();
    run_put(quick, "interrupt_time", 0.0);
    put_interrupt(0.9);
    expect_same_bits(quick);
}

/* The drive's measurement covers the whole interrupt, and it keeps the longest one. */
static void test_the_drive_reports_what_its_last_and_its_longest_interrupt_took(void)
{
    static const double factors[] = {1.0, 2.0, 0.5};
    double longest = 0.0;
    for (size_t n = 0; n < sizeof factors / sizeof factors[0]; n++) {
        const double cycles = factors[n] * RIG_INTERRUPT_CYCLES;
        longest = cycles > longest ? cycles : longest;
        run_put(rig, "interrupt_time", factors[n]);
        rig_run(rig, 2);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, cycles, rig_value(rig, "fast_cycles"));
        TEST_ASSERT_DOUBLE_WITHIN(2.0, longest, rig_value(rig, "fast_cycles_max"));
    }
}

/* ---- the medium task ---- */

/* The medium task, with the interrupts during it, takes this number of windows from its begin. */
static void put_medium(rig_t *of, double windows)
{
    const double alone = DRIVE_WINDOW * ((double)RIG_PERIOD_TICKS - interrupt_ticks());
    const double cycles = RIG_MEDIUM_CYCLES * (150e6 / (double)BOARD_SYSCLK_HZ);
    run_put(of, "medium_time", windows * alone / cycles);
}

/* The setpoint of a window takes effect in a fixed period, whenever it is ready before that. The
 * background applies learnt values when it has time; in this test nothing is learnt. */
static void test_within_the_window_no_bit_depends_on_the_medium_task(void)
{
    static const double windows[] = {0.1, 0.3, 0.5, 0.7, 0.9, 0.95};
    run_parameter(rig, "inductance_adaptation", 0.0);
    run_parameter(rig, "inertia_adaptation", 0.0);
    start();
    for (size_t n = 0; n < sizeof windows / sizeof windows[0]; n++) {
        rig_t *at_once = copy();
        run_put(at_once, "medium_time", 0.0);
        put_medium(rig, windows[n]);
        expect_same_bits(at_once);
        run_expect_no_fault(rig);
    }
}

/* The measured time is from its begin to its end: its own time and that of the interrupts during it. */
static void test_the_drive_reports_what_its_last_and_its_longest_medium_task_took(void)
{
    const double period = (double)RIG_PERIOD_TICKS * ((double)BOARD_SYSCLK_HZ / 150e6);
    static const double windows[] = {0.1, 0.6, 0.3};
    double longest = rig_value(rig, "medium_cycles_max");
    run_put(rig, "interrupt_time", 0.5);
    for (size_t n = 0; n < sizeof windows / sizeof windows[0]; n++) {
        put_medium(rig, windows[n]);
        rig_run(rig, 3u * DRIVE_WINDOW);
        const double own = rig_value(rig, "medium_time") * RIG_MEDIUM_CYCLES;
        const double of_interrupts = 0.5 * RIG_INTERRUPT_CYCLES;
        const double took = rig_value(rig, "medium_cycles");
        const double interrupts = floor((took - own) / of_interrupts + 0.5);
        TEST_ASSERT_DOUBLE_WITHIN(3.0, own + interrupts * of_interrupts, took);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, took / period, interrupts);
        longest = took > longest ? took : longest;
        TEST_ASSERT_EQUAL_DOUBLE(longest, rig_value(rig, "medium_cycles_max"));
    }
    run_put(rig, "medium_time", 0.0);
    rig_run(rig, 2u * DRIVE_WINDOW);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "medium_cycles"));
}

/* The medium task is reported as late within this number of windows. */
static void expect_late_within(uint32_t windows)
{
    const uint32_t begin = rig_period(rig);
    while (rig_value(rig, "fault_reason") == 0.0 && rig_period(rig) - begin < 100u * DRIVE_WINDOW) {
        rig_step(rig);
    }
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_MEDIUM_LATE, rig_value(rig, "fault_reason"));
    TEST_ASSERT_TRUE(rig_period(rig) - begin <= windows * DRIVE_WINDOW + 1u);
}

/* For one window the last setpoint remains active; in the second window the gates are off. */
static void test_a_medium_task_longer_than_the_window_is_reported_as_late(void)
{
    start();
    put_medium(rig, 4.0);
    expect_late_within(4u);
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_FAULT, rig_value(rig, "state"));
    run_seconds(rig, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_a"));
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_MEDIUM_LATE, rig_value(rig, "fault_reason"));
}

/* It takes longer than its window, but not longer than two: every second setpoint is missing, and the sums of
 * every second window are lost. */
static void test_a_medium_task_that_misses_every_second_window_is_reported_as_late(void)
{
    start();
    put_medium(rig, 1.3);
    expect_late_within(6u);
}

/* A medium task that is late once is not a fault: the drive continues with the setpoint that arrives a window
 * later. */
static void test_a_medium_task_that_is_late_once_stops_nothing(void)
{
    start();
    while (rig_state(rig)->app.drive.fast.sum.periods != 1u) {
        rig_step(rig);
    }
    put_medium(rig, 1.5);
    rig_run(rig, DRIVE_WINDOW);
    run_put(rig, "medium_time", 1.0);
    run_seconds(rig, 0.1);
    run_expect_no_fault(rig);
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_OPERATION_ENABLED, rig_value(rig, "state"));
}

/* Three successive late samples turn the gates off, as they do if samples come too late. */
static void test_an_interrupt_longer_than_the_period_is_reported_as_late(void)
{
    start();
    put_interrupt(1.1);
    run_seconds(rig, 0.002);
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_LATE, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
    run_seconds(rig, 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_a"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, rig_value(rig, "true_i_b"));
}

/* Every third sample is missing, and the interrupt after it shows a longer time since the last one. No two of
 * them are in succession. Without a report the drive, which counts interrupts, computes a speed that is half
 * too large. Once in ten interrupts is not too often. */
static void test_samples_that_are_missing_too_often_are_reported_as_late(void)
{
    start();
    for (uint32_t n = 0; n < 60u; n++) {
        run_put(rig, "missing_samples", 1.0);
        rig_run(rig, 10);
    }
    run_expect_no_fault(rig);
    for (uint32_t n = 0; n < 6u; n++) {
        run_put(rig, "missing_samples", 1.0);
        rig_run(rig, 3);
    }
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_LATE, rig_value(rig, "fault_reason"));
}

/* The interrupt of t_k is still running at t_{k+1}, and the recorded truth of t_{k+1} is nevertheless that
 * of this instant: a shaft without friction and load turns by omega T_s p in each period. */
static void test_truth_is_of_t_k_while_an_interrupt_runs_over_it(void)
{
    run_put(rig, "friction_coulomb", 0.0);
    rig_set_motion(rig, 0.3, 100.0);
    put_interrupt(1.7);
    rig_run(rig, 3);
    const double step = 100.0 * rig_value(rig, "plant.pole_pairs") * RIG_PERIOD_SECONDS;
    double last = rig_value(rig, "true_theta_e");
    for (uint32_t n = 0; n < 50; n++) {
        rig_step(rig);
        const double now = rig_value(rig, "true_theta_e");
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, step, remainder(now - last, 2.0 * 3.14159265358979323846));
        last = now;
    }
}

/* ---- sections with interrupts off ---- */

/* All parameters that may change while the bridge is on are changed slightly and back. */
static void change_live_parameters(double factor)
{
    const table_t *params = rig_table(0);
    for (uint32_t n = 0; n < params->count; n++) {
        const table_row_t *row = &params->rows[n];
        double value = 0.0;
        if (row->access == TABLE_LIVE && row->kind == SLOT_FLOAT) {
            TEST_ASSERT_TRUE(rig_get(rig, row->id, &value));
            if (!rig_set(rig, row->id, fmin(fmax(factor * value, (double)row->min), (double)row->max))) {
                TEST_FAIL_MESSAGE(rig_error(rig));
            }
        }
    }
    if (!rig_apply(rig)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
}

#define PHASES 32u

static double reason_after_changes_at_all_phases(void)
{
    for (uint32_t phase = 0; phase < PHASES; phase++) {
        rig_step_part(rig, RIG_PERIOD_TICKS * phase / PHASES);
        change_live_parameters(phase % 2u == 0u ? 1.001 : 1.0 / 1.001);
        rig_run(rig, 5);
    }
    return rig_value(rig, "fault_reason");
}

static void test_a_change_of_all_live_parameters_makes_no_sample_late_at_any_phase(void)
{
    start();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, reason_after_changes_at_all_phases());
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * RPM_ASKED, RPM_ASKED, rig_value(rig, "true_omega_m") / RPM);
}

/* A section delays the interrupts by four periods; the reaction is that to a late interrupt. */
static void test_a_change_with_interrupts_off_for_periods_is_late(void)
{
    start();
    const double ticks = RIG_SECTION_CYCLES * (150e6 / (double)BOARD_SYSCLK_HZ);
    run_put(rig, "section_time", 4.0 * (double)RIG_PERIOD_TICKS / ticks);
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_LATE, reason_after_changes_at_all_phases());
}
