/* The faults of simulation and plant, set on a running drive. Each fault acts at its instant, reaches the
 * drive through the chip as on a board, can be removed, and changes no bit while it is not set. Other
 * tests judge the reaction of the drive. */
#include "hal/f28335/qep.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

/* Runs with the encoder at this speed, `seconds` after the drive was switched on. */
static void running(double fidelity, double rpm, double seconds)
{
    rig_free(rig);
    rig = run_rig(5);
    run_put(rig, "fidelity", fidelity);
    run_paper_drive(rig);
    run_to_ready(rig);
    if (rpm != 0.0) {
        rig_set_motion(rig, 0.0, rpm * RPM);
    }
    run_on(rig, rpm);
    run_seconds(rig, seconds);
    run_expect_no_fault(rig);
}

/* ---- no fault ---- */

/* Each row of a fault is set to its present value; the result must have the same bits as if another row
 * had been set to its present value. */
static void test_rows_without_a_fault_change_no_bit(void)
{
    static const char *const rows[] = {"leg_a_drop",
                                       "leg_b_resistance",
                                       "leg_c_delay",
                                       "open_switches",
                                       "shorted_switches",
                                       "swap_phases",
                                       "swap_currents",
                                       "dc_ripple",
                                       "encoder_reversed",
                                       "encoder_slip",
                                       "encoder_stuck_a",
                                       "encoder_stuck_b",
                                       "supply_lost",
                                       "dc_ripple_frequency",
                                       "plant.chopper_voltage",
                                       "load_inertia",
                                       "shaft_stiffness",
                                       "shaft_damping",
                                       "plant.chopper_resistance"};
    uint64_t expected = 0u;
    for (size_t n = 0; n <= sizeof rows / sizeof rows[0]; n++) {
        running(0.0, 300.0, 0.02);
        const char *row = n == 0u ? "dc_noise" : rows[n - 1u];
        const double value = rig_value(rig, row);
        rig_step_part(rig, 4711u);
        run_put(rig, row, value);
        run_seconds(rig, 0.01);
        if (n == 0u) {
            expected = rig_hash(rig);
        }
        TEST_ASSERT_EQUAL_HEX64_MESSAGE(expected, rig_hash(rig), row);
    }
}

/* ---- inverter ---- */

static void test_single_switches_and_mean_voltages_refuse_each_other(void)
{
    running(1.0, 300.0, 0.02);
    TEST_ASSERT_FALSE(rig_put(rig, "open_switches", 1.0));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "fidelity"));
    TEST_ASSERT_FALSE(rig_put(rig, "shorted_switches", 63.0));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "switched"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "shorted_switches"));
    run_puts(rig, "fidelity=0 open_switches=1");
    TEST_ASSERT_FALSE(rig_put(rig, "fidelity", 1.0));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "open_switches"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fidelity"));
    run_puts(rig, "open_switches=0 fidelity=1");
}

/* One switch of leg a shorts in the middle of a period, while the other one is on. The shoot-through, the
 * trip and the opening of the gates occur within that tick. */
static void test_a_switch_that_shorts_trips_the_module_within_the_tick(void)
{
    running(0.0, 300.0, 0.05);
    rig_step_part(rig, 200u);
    const rig_state_t *state = rig_state(rig);
    plant_truth_t now;
    plant_advance(&rig_state(rig)->plant, chip_now(&state->chip));
    const uint32_t lower = state->plant.on & PLANT_LOWER(0);
    run_put(rig, "shorted_switches", lower != 0u ? 1.0 : 2.0);
    plant_truth(&state->plant, &now);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, now.shoot_throughs);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, (double)chip_now(&state->chip) / 150e6, now.shoot_through_second);
    TEST_ASSERT_TRUE(chip_tripped(&state->chip, BOARD_LEG_A));
    run_seconds(rig, 0.001);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
}

/* ---- samples and memory ---- */

static void test_missing_samples_have_the_requested_number(void)
{
    for (uint32_t fidelity = 0; fidelity < 2u; fidelity++) {
        running(fidelity, 300.0, 0.05);
        const uint32_t entries = chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT);
        run_put(rig, "missing_samples", 3.0);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "missing_samples"));
        rig_run(rig, 1u); /* the conversion that has begun at t_k is completed */
        TEST_ASSERT_EQUAL_UINT32(entries + 1u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        rig_run(rig, 3u);
        TEST_ASSERT_EQUAL_UINT32(entries + 1u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        rig_run(rig, 6u);
        TEST_ASSERT_EQUAL_UINT32(entries + 7u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        run_put(rig, "missing_samples", 10000.0);
        rig_run(rig, 5u);
        TEST_ASSERT_EQUAL_UINT32(entries + 8u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        run_put(rig, "missing_samples", 0.0); /* the samples come again */
        rig_run(rig, 10u);
        TEST_ASSERT_UINT32_WITHIN(1u, entries + 18u,
                                  chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "chip_reports"));
    }
    TEST_ASSERT_FALSE(rig_put(rig, "missing_samples", 1.5));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "whole"));
}

static void test_a_flipped_bit_is_that_bit_alone_and_flips_back(void)
{
    running(0.0, 300.0, 0.05);
    app_t before = rig_state(rig)->app;
    const size_t word = offsetof(app_t, drive.medium.sequence) / sizeof(uint32_t);
    run_put(rig, "flip_bit", 31.0);
    run_put(rig, "flip_word", (double)word);
    TEST_ASSERT_EQUAL_DOUBLE(-1.0, rig_value(rig, "flip_word"));
    uint32_t was[2], now[2];
    memcpy(was, (const char *)&before + 4u * word, sizeof was);
    memcpy(now, (const char *)&rig_state(rig)->app + 4u * word, sizeof now);
    TEST_ASSERT_EQUAL_HEX32(was[0] ^ 0x80000000u, now[0]);
    TEST_ASSERT_EQUAL_HEX32(was[1], now[1]);
    run_put(rig, "flip_word", (double)word);
    TEST_ASSERT_EQUAL_MEMORY(&before, &rig_state(rig)->app, sizeof before);
    /* The word after the last one is the first. */
    const double words = (double)(sizeof before / sizeof(uint32_t));
    run_put(rig, "flip_word", (double)word + words);
    memcpy(now, (const char *)&rig_state(rig)->app + 4u * word, sizeof now);
    TEST_ASSERT_EQUAL_HEX32(was[0] ^ 0x80000000u, now[0]);
    TEST_ASSERT_FALSE(rig_put(rig, "flip_word", 0.5));
    TEST_ASSERT_FALSE(rig_put(rig, "flip_bit", 32.0));
}
