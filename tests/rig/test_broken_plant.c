/* What rig and plant can break, set on a running drive: that it acts at its instant, reaches the drive
 * through the chip as it would on a board, can be taken back, and costs no bit while it is none. What the
 * drive does about it is judged elsewhere. */
#include <stdlib.h>

#include "hal/f28335/qep.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

/* By the encoder at this speed, `seconds` after the switch was closed. */
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

static int64_t position(void)
{
    return (int64_t)rig_state(rig)->chip.registers.eqep[QEP_MODULE - 1u].QPOSCNT;
}

/* Counts that have come in so many periods. */
static int64_t counted(uint32_t periods)
{
    const int64_t turn = 10000;
    const int64_t before = position();
    rig_run(rig, periods);
    const int64_t way = ((position() - before) % turn + turn) % turn;
    return way > turn / 2 ? way - turn : way;
}

/* ---- none ---- */

/* Every such row, put to what it is: the bits are those of any other row that is put to what it is. */
static void test_rows_that_are_none_change_no_bit(void)
{
    static const char *const rows[] = {
        "leg_a_drop",      "leg_b_resistance", "leg_c_delay",   "open_switches",       "shorted_switches",
        "swap_phases",     "swap_currents",    "dc_ripple",     "encoder_reversed",    "encoder_slip",
        "encoder_stuck_a", "encoder_stuck_b",  "supply_lost",   "dc_ripple_frequency", "chopper_voltage",
        "load_inertia",    "shaft_stiffness",  "shaft_damping", "chopper_resistance"};
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
    run_put(rig, "fidelity", 0.0);
    run_put(rig, "open_switches", 1.0);
    TEST_ASSERT_FALSE(rig_put(rig, "fidelity", 1.0));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "open_switches"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fidelity"));
    run_put(rig, "open_switches", 0.0);
    run_put(rig, "fidelity", 1.0);
}

/* In the midst of a period, with the lower switch of a on: shoot-through, trip and open gates within that
 * tick. */
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

/* The half wave that the open switch would carry stays away; repaired, it is there again. */
static void test_an_open_switch_takes_a_half_wave_and_gives_it_back(void)
{
    running(0.0, 300.0, 0.05);
    run_put(rig, "current_judged", 0.0); /* else the drive opens the bridge */
    run_parameter(rig, "encoder_fault_reaction", ENCODER_FAULT_IGNORED);
    run_put(rig, "load_torque", 3.0);
    run_seconds(rig, 0.2);
    double most[2] = {0.0, 0.0};
    for (uint32_t open = 0; open < 2u; open++) {
        run_put(rig, "open_switches", open == 0u ? 1.0 : 0.0);
        for (uint32_t n = 0; n < 1500u; n++) { /* three electrical turns; the first third of one aside */
            rig_step(rig);
            if (n > 200u) {
                most[open] = fmax(most[open], rig_value(rig, "true_i_a"));
            }
        }
    }
    printf("i_a up to %.3f A, repaired %.3f A\n", most[0], most[1]);
    TEST_ASSERT_TRUE(most[0] < 0.5);
    TEST_ASSERT_TRUE(most[1] > 3.0);
}

/* A loop that takes the motor the wrong way round, encoder and wires alike, is no fault at all: i_q as ever.
 */
static void test_wires_and_encoder_the_other_way_round_together_turn_the_motor_backwards(void)
{
    for (int sensors = 0; sensors < 2; sensors++) {
        rig_free(rig);
        rig = run_rig(5);
        run_put(rig, "sensors", sensors);
        run_paper_drive(rig);
        run_put(rig, "swap_phases", 1.0);
        run_put(rig, "encoder_reversed", 1.0);
        run_to_ready(rig);
        run_on(rig, 300.0);
        run_seconds(rig, 2.5);
        run_expect_no_fault(rig);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, -300.0, rig_value(rig, "true_omega_m") / RPM);
        TEST_ASSERT_DOUBLE_WITHIN(6.0, 300.0, rig_value(rig, "omega_m") / RPM); /* of one instant */
    }
}

static void test_current_signals_come_in_as_they_are_wired(void)
{
    running(0.0, 300.0, 0.05);
    run_put(rig, "load_torque", 3.0);
    run_seconds(rig, 0.3);
    run_put(rig, "current_noise", 0.0);
    run_put(rig, "enable", 0.0); /* nothing the drive could do about it: the sensors alone */
    run_put(rig, "swap_currents", 3.0);
    rig_step(rig);
    const plant_t *plant = &rig_state(rig)->plant;
    const double volts = 1.5 / plant->params.current_range;
    TEST_ASSERT_TRUE(fabs(plant->i[0] - plant->i[1]) > 0.2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5 + volts * plant->i[1],
                              plant_analog(&rig_state(rig)->plant, PLANT_CURRENT_A));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5 + volts * plant->i[0],
                              plant_analog(&rig_state(rig)->plant, PLANT_CURRENT_B));
}

/* A burst: the noise of the samples that it lasts, not of those before and after. */
static void test_a_burst_of_noise_is_in_the_samples_while_it_lasts(void)
{
    rig = run_rig(5);
    run_paper_drive(rig);
    run_to_ready(rig);
    const double quiet = 3.0 * 0.05;
    for (int part = 0; part < 3; part++) {
        run_put(rig, "current_noise", part == 1 ? 2.0 : 0.01);
        double most = 0.0;
        for (int n = 0; n < 50; n++) {
            rig_step(rig);
            most = fmax(most, fabs(rig_value(rig, "i_a")));
        }
        TEST_ASSERT_TRUE((most > 2.0) == (part == 1));
        TEST_ASSERT_TRUE((most < quiet) == (part != 1));
    }
}

/* ---- encoder ---- */

/* 600 r/min: 10 turns a second, 10 counts a period. */
static void test_the_counter_of_the_chip_sees_what_the_encoder_is(void)
{
    static const struct {
        const char *row;
        double value;
        int64_t counts; /* in 100 periods, of 1000 */
    } rows[] = {{"encoder_reversed", 1.0, -1000},
                {"encoder_slip", 0.2, 800},
                {"encoder_slip", 1.0, 0},
                {"encoder_stuck_a", 0.0, 0},
                {"encoder_stuck_b", 1.0, 0}};
    for (uint32_t fidelity = 0; fidelity < 2u; fidelity++) {
        for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
            rig_free(rig);
            rig = run_rig(5);
            run_put(rig, "fidelity", fidelity);
            run_put(rig, "shaft_locked", 1.0);
            run_put(rig, "shaft_locked_speed", 600.0 * RPM);
            run_to_ready(rig);
            TEST_ASSERT_INT64_WITHIN(1, 1000, counted(100u));
            const double none = rig_value(rig, rows[n].row);
            run_put(rig, rows[n].row, rows[n].value);
            /* The counter is as of the last interrupt: a period's counts at either end. */
            TEST_ASSERT_INT64_WITHIN(20, rows[n].counts, counted(100u));
            run_put(rig, rows[n].row, none);
            rig_run(rig, 1u);
            TEST_ASSERT_INT64_WITHIN(1, 1000, counted(100u));
        }
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "chip_reports"));
    }
}

/* The disc slips once, by 0.5 rad electrical: 198.9 counts, and no more. */
static void test_an_encoder_that_slips_once_is_off_by_that_from_then_on(void)
{
    running(0.0, 600.0, 0.1);
    const double before = rig_value(rig, "theta_err");
    run_put(rig, "plant.encoder_offset", 0.125);
    TEST_ASSERT_INT64_WITHIN(30, 10 * 10 + 199, counted(10u));
    TEST_ASSERT_DOUBLE_WITHIN(0.02, before + 0.5, rig_value(rig, "theta_err"));
    run_seconds(rig, 0.05);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, before + 0.5, rig_value(rig, "theta_err"));
}

/* ---- supply ---- */

static void test_ripple_of_the_supply_is_in_what_the_drive_measures(void)
{
    for (uint32_t fidelity = 0; fidelity < 2u; fidelity++) {
        running(fidelity, 300.0, 0.05);
        run_put(rig, "dc_ripple", 30.0);
        run_put(rig, "dc_ripple_frequency", 2.0 * 3.14159265358979323846 * 100.0);
        double most = 0.0;
        double least = 1e3;
        const double nominal = rig_value(rig, "dc_voltage");
        for (int n = 0; n < 200; n++) {
            rig_step(rig);
            const double t = n * RIG_PERIOD_SECONDS;
            const double wanted = nominal + 30.0 * sin(2.0 * 3.14159265358979323846 * 100.0 * t);
            TEST_ASSERT_DOUBLE_WITHIN(0.2, wanted, rig_value(rig, "true_u_dc"));
            most = fmax(most, rig_value(rig, "u_dc"));
            least = fmin(least, rig_value(rig, "u_dc"));
        }
        TEST_ASSERT_DOUBLE_WITHIN(2.0, nominal + 30.0, most);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, nominal - 30.0, least);
    }
}

/* What the capacitor had is what the drive took, by the plant's meters; without a capacitor it is refused. */
static void test_a_lost_supply_drains_the_link_by_what_the_drive_takes(void)
{
    for (uint32_t fidelity = 0; fidelity < 2u; fidelity++) {
        running(fidelity, 600.0, 0.1);
        TEST_ASSERT_FALSE(rig_put(rig, "supply_lost", 1.0));
        TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "dc_capacitance"));
        run_put(rig, "dc_capacitance", 2e-3);
        run_put(rig, "dc_resistance", 0.2);
        run_put(rig, "load_torque", 2.0);
        run_seconds(rig, 0.05);
        run_put(rig, "supply_lost", 1.0);
        run_put(rig, "metering", 1.0);
        const double before = rig_state(rig)->plant.v_dc;
        run_seconds(rig, 0.1);
        const plant_t *plant = &rig_state(rig)->plant;
        const double given = 0.5 * 2e-3 * (before * before - plant->v_dc * plant->v_dc);
        printf("%.1f V to %.1f V, %.3f J of %.3f J\n", before, plant->v_dc, plant->energy_dc, given);
        TEST_ASSERT_TRUE(plant->v_dc < before - 5.0);
        TEST_ASSERT_DOUBLE_WITHIN(5e-3 * given, given, plant->energy_dc);
        run_put(rig, "supply_lost", 0.0);
        run_seconds(rig, 0.02);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, rig_value(rig, "dc_voltage"), plant->v_dc);
    }
}

/* ---- samples and memory ---- */

static void test_missing_samples_are_as_many_as_asked_for(void)
{
    for (uint32_t fidelity = 0; fidelity < 2u; fidelity++) {
        running(fidelity, 300.0, 0.05);
        const uint32_t entries = chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT);
        run_put(rig, "missing_samples", 3.0);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "missing_samples"));
        rig_run(rig, 1u); /* the conversion under way at t_k comes */
        TEST_ASSERT_EQUAL_UINT32(entries + 1u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        rig_run(rig, 3u);
        TEST_ASSERT_EQUAL_UINT32(entries + 1u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        rig_run(rig, 6u);
        TEST_ASSERT_EQUAL_UINT32(entries + 7u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        run_put(rig, "missing_samples", 10000.0);
        rig_run(rig, 5u);
        TEST_ASSERT_EQUAL_UINT32(entries + 8u, chip_interrupt_count(&rig_state(rig)->chip, PIE_SEQ1INT));
        run_put(rig, "missing_samples", 0.0); /* and they come again */
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
    const size_t word = offsetof(app_t, drive.sequence) / sizeof(uint32_t);
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
    /* The last word is followed by the first. */
    const double words = (double)(sizeof before / sizeof(uint32_t));
    run_put(rig, "flip_word", (double)word + words);
    memcpy(now, (const char *)&rig_state(rig)->app + 4u * word, sizeof now);
    TEST_ASSERT_EQUAL_HEX32(was[0] ^ 0x80000000u, now[0]);
    TEST_ASSERT_FALSE(rig_put(rig, "flip_word", 0.5));
    TEST_ASSERT_FALSE(rig_put(rig, "flip_bit", 32.0));
}

/* ---- elastic load ---- */

/* Two thirds of the rig's inertia behind a shaft that swings with 40 Hz: the loop holds the speed in both
 * fidelities, and the far end with it. */
static void test_the_drive_turns_an_elastic_load(void)
{
    for (uint32_t fidelity = 0; fidelity < 2u; fidelity++) {
        rig_free(rig);
        rig = run_rig(5);
        run_put(rig, "fidelity", fidelity);
        run_paper_drive(rig);
        run_put(rig, "inertia", 0.0212);
        run_put(rig, "load_inertia", 0.0424);
        run_put(rig, "shaft_damping", 0.05);
        run_put(rig, "shaft_stiffness", 893.0);
        run_to_ready(rig);
        run_on(rig, 600.0);
        double most = 0.0;
        for (uint32_t n = 0; n < 20000u; n++) {
            rig_step(rig);
            most = fmax(most, fabs(rig_state(rig)->plant.twist));
        }
        run_expect_no_fault(rig);
        plant_truth_t now;
        plant_truth(&rig_state(rig)->plant, &now);
        printf("twist to %.4f rad, far end %.2f r/min\n", most, now.omega_load / RPM);
        /* 10 A, 11 N m less friction, two thirds of it through 893 N m/rad; at a step twice that. */
        TEST_ASSERT_TRUE(most > 0.9 * (11.0 - 1.3) * 2.0 / 3.0 / 893.0);
        TEST_ASSERT_TRUE(most < 2.2 * 11.0 * 2.0 / 3.0 / 893.0);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, 600.0, now.omega_m / RPM);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, 600.0, now.omega_load / RPM);
    }
}
