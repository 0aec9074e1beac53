/* The simulation as a whole: it is deterministic, it can be copied, and several run in one process. */
#include "host_sim/chip/chip.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/run.h"

static rig_t *started(uint64_t seed, double rpm)
{
    rig_t *rig = run_rig(seed);
    run_paper_drive(rig);
    run_to_ready(rig);
    run_on(rig, rpm);
    return rig;
}

static void test_board_comes_up_without_a_report_of_the_chip(void)
{
    rig_t *rig = run_rig(1);
    run_seconds(rig, 1.0);
    for (int kind = 1; kind < CHIP_REPORT_KINDS; kind++) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(0,
                                         chip_report_count(&rig_state(rig)->chip, (chip_report_kind_t)kind),
                                         chip_report_text((chip_report_kind_t)kind));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "chip_reports"));
    rig_free(rig);
}

static void test_same_seed_same_bits_other_seed_other_bits(void)
{
    rig_t *a = started(7, 800.0);
    rig_t *b = started(7, 800.0);
    rig_t *c = started(8, 800.0);
    run_seconds(a, 0.5);
    run_seconds(b, 0.5);
    run_seconds(c, 0.5);
    TEST_ASSERT_EQUAL_HEX64(rig_hash(a), rig_hash(b));
    TEST_ASSERT_TRUE(rig_hash(a) != rig_hash(c));
    rig_free(a);
    rig_free(b);
    rig_free(c);
}

static void test_two_rigs_in_turn_do_not_disturb_each_other(void)
{
    rig_t *alone = started(3, 1200.0);
    rig_t *a = started(3, 1200.0);
    rig_t *b = started(4, -300.0);
    run_put(b, "load_torque", 3.0);
    for (int n = 0; n < 3000; n++) {
        rig_step(alone);
    }
    for (int n = 0; n < 3000; n++) {
        rig_step(a);
        rig_step(b);
    }
    TEST_ASSERT_EQUAL_HEX64(rig_hash(alone), rig_hash(a));
    TEST_ASSERT_TRUE(rig_value(b, "true_omega_m") < -1.0);
    rig_free(alone);
    rig_free(a);
    rig_free(b);
}

static void expect_the_same_end_after_a_save(double fidelity)
{
    rig_t *rig = started(5, 1500.0);
    run_put(rig, "fidelity", fidelity);
    run_put(rig, "load_torque", 2.0);
    run_seconds(rig, 1.0);
    void *state = malloc(rig_state_size());
    TEST_ASSERT_NOT_NULL(state);
    rig_save(rig, state);
    const uint64_t hash_saved = rig_hash(rig);
    run_seconds(rig, 0.5);
    const uint64_t hash_end = rig_hash(rig);
    TEST_ASSERT_TRUE(hash_saved != hash_end);

    rig_t *other = run_rig(99);
    TEST_ASSERT_TRUE(rig_load(other, state, rig_state_size()));
    TEST_ASSERT_EQUAL_HEX64(hash_saved, rig_hash(other));
    run_seconds(other, 0.5);
    TEST_ASSERT_EQUAL_HEX64(hash_end, rig_hash(other));

    /* Loads the earlier state into the same simulation. */
    TEST_ASSERT_TRUE(rig_load(rig, state, rig_state_size()));
    run_seconds(rig, 0.5);
    TEST_ASSERT_EQUAL_HEX64(hash_end, rig_hash(rig));
    free(state);
    rig_free(rig);
    rig_free(other);
}

static void test_saved_at_one_second_and_restored_ends_the_same(void)
{
    expect_the_same_end_after_a_save(0.0);
    expect_the_same_end_after_a_save(1.0);
}

static void test_a_state_of_another_size_is_refused(void)
{
    rig_t *rig = run_rig(1);
    const uint64_t hash = rig_hash(rig);
    char little[16] = {0};
    TEST_ASSERT_FALSE(rig_load(rig, little, sizeof little));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "16 octets"));
    TEST_ASSERT_EQUAL_HEX64(hash, rig_hash(rig));
    rig_free(rig);
}

static uint32_t seen_period;
static float seen_value;
static uint32_t calls;

static void sink(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    TEST_ASSERT_EQUAL_PTR(&calls, context);
    TEST_ASSERT_EQUAL_UINT32(2, count);
    seen_period = period;
    memcpy(&seen_value, &slots[1], sizeof seen_value);
    calls++;
}

/* A shaft coasts without friction, J domega/dt = -T_load. A load that is set at t_k has no effect until
 * t_k, and n periods later the speed has decreased by T_load n T_s/J. A load that had acted from an
 * instant within the previous period would have an effect at t_k already. */
static void expect_load_acts_from_its_instant_on(double fidelity)
{
    const double load = 10.0;
    rig_t *rig = run_rig(1);
    run_put(rig, "fidelity", fidelity);
    run_put(rig, "friction_coulomb", 0.0);
    rig_set_motion(rig, 0.0, 500.0 * RPM);
    run_to_ready(rig);
    const double before = rig_value(rig, "true_omega_m");
    const double a_period = load / rig_value(rig, "plant.inertia") * RIG_PERIOD_SECONDS;
    run_put(rig, "load_torque", load);
    rig_step(rig);
    TEST_ASSERT_EQUAL_DOUBLE(before, rig_value(rig, "true_omega_m"));
    rig_run(rig, 100);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * a_period, before - 100.0 * a_period, rig_value(rig, "true_omega_m"));
    rig_free(rig);
}

static void test_a_plant_row_acts_from_the_instant_at_which_it_is_set(void)
{
    expect_load_acts_from_its_instant_on(0.0);
    expect_load_acts_from_its_instant_on(1.0);
}

static void test_tap_hands_over_the_chosen_slots_every_nth_period(void)
{
    rig_t *rig = started(1, 500.0);
    const uint32_t ids[] = {rig_row_by_name("period")->id, rig_row_by_name("i_q_ref")->id};
    const uint32_t start = rig_period(rig);
    calls = 0;
    TEST_ASSERT_TRUE(rig_tap(rig, ids, 2, 10, sink, &calls));
    rig_run(rig, 100);
    TEST_ASSERT_EQUAL_UINT32(10, calls);
    TEST_ASSERT_EQUAL_UINT32(0, seen_period % 10u);
    TEST_ASSERT_TRUE(seen_period >= start);
    rig_run(rig, 10u - (rig_period(rig) - 1u) % 10u);
    TEST_ASSERT_EQUAL_DOUBLE((double)seen_value, rig_value(rig, "i_q_ref"));

    TEST_ASSERT_FALSE(rig_tap(rig, ids, 2, 0, sink, &calls));
    const uint32_t nobody[] = {123456};
    TEST_ASSERT_FALSE(rig_tap(rig, nobody, 1, 1, sink, &calls));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "123456"));
    rig_free(rig);
}

static void test_run_stops_in_the_period_that_meets_the_condition(void)
{
    rig_t *rig = run_rig(1);
    TEST_ASSERT_TRUE(rig_stop_when(rig, rig_row_by_name("state")->id, RIG_EQUAL, 1.0));
    /* 64 samples are for the settling and 512 are averaged: the result is known in the 576th period, and
     * it takes effect a window later. */
    TEST_ASSERT_EQUAL_UINT32(576u + DRIVE_WINDOW, rig_run(rig, 10000));
    TEST_ASSERT_TRUE(rig_stop_when(rig, rig_row_by_name("period")->id, RIG_ABOVE, 1000.0));
    rig_run(rig, 10000);
    TEST_ASSERT_EQUAL_DOUBLE(1001.0, rig_value(rig, "period"));
    TEST_ASSERT_TRUE(rig_stop_when(rig, rig_row_by_name("period")->id, RIG_NEVER, 0.0));
    TEST_ASSERT_EQUAL_UINT32(50, rig_run(rig, 50));
    TEST_ASSERT_FALSE(rig_stop_when(rig, 999999, RIG_EQUAL, 0.0));
    rig_free(rig);
}
