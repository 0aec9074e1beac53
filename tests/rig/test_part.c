/* The two parts of the ring (host_sim/rig/rig_part.h): coupled once in a period they have the bits of a whole
 * rig with the same settings. The expected values are those of that rig. */
#include <stdlib.h>
#include <string.h>

#include "host_sim/rig/rig_part.h"
#include "unity.h"

#define SLOTS RIG_TAP_MAX

/* The switch of leg a that is on when a period begins: if it is shorted, the module trips when the other one
 * turns on, within the period. */
#define SHORTED (BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR ? 1.0 : 2.0)

typedef struct {
    rig_t *rig;
    uint32_t count;
    uint32_t slots[SLOTS]; /* of the last period */
} part_t;

static part_t ring, drive, plant;

static void on_slots(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    part_t *part = context;
    (void)period;
    memcpy(part->slots, slots, count * sizeof *slots);
}

/* The rows that can only be read: those of the drive, or the truth, without those that need both parts. */
static void watch(part_t *part, bool signals, bool truth)
{
    uint32_t ids[SLOTS];
    part->count = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        const bool of_drive = strcmp(table->name, "signals") == 0;
        const bool of_plant = strcmp(table->name, "truth") == 0;
        for (uint32_t n = 0; n < table->count && ((of_drive && signals) || (of_plant && truth)); n++) {
            const char *name = table->rows[n].name;
            if (strcmp(name, "theta_err") != 0 && strcmp(name, "theta_hat_err") != 0 &&
                strcmp(name, "chip_reports") != 0) {
                ids[part->count++] = table->rows[n].id;
            }
        }
    }
    TEST_ASSERT_TRUE(rig_tap(part->rig, ids, part->count, 1u, on_slots, part));
}

static void put(const char *name, double value)
{
    TEST_ASSERT_TRUE_MESSAGE(rig_put(ring.rig, name, value), rig_error(ring.rig));
    TEST_ASSERT_TRUE_MESSAGE(rig_put(drive.rig, name, value), rig_error(drive.rig));
    TEST_ASSERT_TRUE_MESSAGE(rig_put(plant.rig, name, value), rig_error(plant.rig));
}

static void apply(void)
{
    TEST_ASSERT_TRUE_MESSAGE(rig_apply(ring.rig), rig_error(ring.rig));
    TEST_ASSERT_TRUE_MESSAGE(rig_apply(drive.rig), rig_error(drive.rig));
    TEST_ASSERT_TRUE_MESSAGE(rig_apply(plant.rig), rig_error(plant.rig));
}

static void cut(void)
{
    rig_part_cut(drive.rig, RIG_DRIVE);
    rig_part_cut(plant.rig, RIG_PLANT);
}

void setUp(void)
{
    ring.rig = rig_create(11u);
    drive.rig = rig_create(11u);
    plant.rig = rig_create(11u);
    watch(&ring, true, true);
    watch(&drive, true, false);
    watch(&plant, false, true);
    TEST_ASSERT_EQUAL_UINT32(ring.count, drive.count + plant.count);
    put("position_source", table_choice(rig_row_by_name("position_source"), "encoder"));
    put("enable", 1.0);
    put("speed_request", 20.0);
    apply();
}

void tearDown(void)
{
    rig_free(ring.rig);
    rig_free(drive.rig);
    rig_free(plant.rig);
}

static void carry(bool commands)
{
    const table_t *table = rig_exchange_table();
    for (uint32_t n = 0; n < table->count; n++) {
        const table_row_t *row = &table->rows[n];
        if (rig_exchange_is_command(row) == commands) {
            rig_exchange_set(commands ? plant.rig : drive.rig, row,
                             rig_exchange_get(commands ? drive.rig : plant.rig, row));
        }
    }
}

static void couple(void)
{
    rig_part_sample(plant.rig);
    carry(false);
    rig_part_step(drive.rig);
    carry(true);
    rig_part_step(plant.rig);
}

static void expect_equal(uint32_t period)
{
    char text[32];
    snprintf(text, sizeof text, "period %u", period);
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(ring.slots, drive.slots, drive.count * sizeof drive.slots[0], text);
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(ring.slots + drive.count, plant.slots,
                                     plant.count * sizeof plant.slots[0], text);
}

static void run(uint32_t periods)
{
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(ring.rig);
        couple();
        expect_equal(n);
    }
}

/* Runs, and then shorts a switch of the ring and of the plant. */
static void run_to_short(void)
{
    put("short_circuit_current", 60.0);
    cut();
    run(2000);
    TEST_ASSERT_TRUE(rig_put(ring.rig, "shorted_switches", SHORTED));
    TEST_ASSERT_TRUE(rig_put(plant.rig, "shorted_switches", SHORTED));
}

static void test_parts_that_exchange_once_a_period_have_the_bits_of_the_ring(void)
{
    cut();
    run(6000);
    TEST_ASSERT_TRUE(rig_value(ring.rig, "true_omega_m") > 10.0); /* it runs */
}

static void test_so_have_parts_with_averaged_voltages_and_with_ideal_sensors(void)
{
    put("fidelity", 1.0);
    put("sensors", 1.0);
    cut();
    run(4000);
    TEST_ASSERT_TRUE(rig_value(ring.rig, "true_omega_m") > 5.0);
}

/* The interrupt has another duration, and comes later: the instant of the command changes. */
static void test_the_command_acts_at_the_instant_at_which_the_drive_writes_it(void)
{
    put("interrupt_time", 1.3);
    put("interrupt_delay", 3e-6);
    cut();
    run(4000);
}

static void test_a_trip_within_a_period_is_exact_if_the_drive_repeats_the_period(void)
{
    const table_row_t *trip = table_by_name(rig_exchange_table(), "trip_time");
    void *before = malloc(rig_state_size());
    void *part = malloc(rig_part_state_size());
    uint32_t repeated = 0;
    run_to_short();
    for (uint32_t n = 0; n < 100u; n++) {
        rig_step(ring.rig);
        rig_part_sample(plant.rig);
        rig_save(drive.rig, before);
        carry(false);
        rig_exchange_set(drive.rig, trip, -1.0);
        rig_part_save(drive.rig, part);
        rig_part_step(drive.rig);
        carry(true);
        rig_part_step(plant.rig);
        if (rig_exchange_get(plant.rig, trip) >= 0.0) {
            TEST_ASSERT_TRUE(rig_load(drive.rig, before, rig_state_size()));
            rig_part_load(drive.rig, part);
            rig_exchange_set(drive.rig, trip, rig_exchange_get(plant.rig, trip));
            rig_part_step(drive.rig);
            repeated++;
        }
        expect_equal(n);
    }
    TEST_ASSERT_TRUE(repeated > 0u);
    TEST_ASSERT_TRUE(rig_value(drive.rig, "fault_reason") > 0.0);
    free(before);
    free(part);
}

/* Without the repetition the gates open at the same instant, because the trip zone is in the plant; only the
 * drive's report comes in the next period. */
static void test_a_trip_that_is_not_repeated_is_reported_one_period_later(void)
{
    run_to_short();
    for (uint32_t n = 0; n < 50u; n++) {
        const double before = rig_value(ring.rig, "fault_reason");
        rig_step(ring.rig);
        couple();
        TEST_ASSERT_EQUAL_MEMORY(ring.slots + drive.count, plant.slots, plant.count * sizeof plant.slots[0]);
        rig_part_sample(plant.rig);
        if (rig_value(ring.rig, "fault_reason") != rig_value(drive.rig, "fault_reason")) {
            TEST_ASSERT_EQUAL_DOUBLE(before, rig_value(drive.rig, "fault_reason"));
        }
    }
    TEST_ASSERT_EQUAL_DOUBLE(rig_value(ring.rig, "fault_reason"), rig_value(drive.rig, "fault_reason"));
    TEST_ASSERT_TRUE(rig_value(drive.rig, "fault_reason") > 0.0);
}

/* Expected by Ohm's law: rotor locked, inverter ideal, constant duties; u_a = (d_a - mean of d) V. */
static void test_the_plant_obeys_the_duties_of_another_controller(void)
{
    const table_t *table = rig_exchange_table();
    const char *const ideal[] = {"plant.turn_on_delay",   "plant.turn_off_delay", "plant.igbt_voltage",
                                 "plant.igbt_resistance", "plant.diode_voltage",  "plant.diode_resistance"};
    for (size_t n = 0; n < sizeof ideal / sizeof ideal[0]; n++) {
        TEST_ASSERT_TRUE(rig_put(plant.rig, ideal[n], 0.0));
    }
    TEST_ASSERT_TRUE(rig_put(plant.rig, "shaft_locked", 1.0));
    rig_part_cut(plant.rig, RIG_PLANT);
    rig_part_sample(plant.rig);
    rig_exchange_set(plant.rig, table_by_name(table, "command_gates"), 1.0);
    const double v_dc = rig_value(plant.rig, "plant.dc_voltage");
    const double dead = rig_exchange_get(plant.rig, table_by_name(table, "command_dead_time"));
    /* With i_a > 0, i_b < 0, i_c < 0 the dead time takes 2 dead/T from the difference of the legs. */
    rig_exchange_set(plant.rig, table_by_name(table, "command_duty_a"),
                     0.53 + 2.0 * dead / RIG_PERIOD_SECONDS);
    for (uint32_t n = 0; n < 5000u; n++) { /* tau = L/R = 13 ms, in half a second */
        rig_part_step(plant.rig);
        rig_part_sample(plant.rig);
    }
    const double u_a = 2.0 / 3.0 * 0.03 * v_dc;
    const double i_a = u_a / rig_value(plant.rig, "plant.resistance");
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * i_a + 0.05, i_a,
                              rig_exchange_get(plant.rig, table_by_name(table, "sample_i_a")));
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * i_a + 0.05, -0.5 * i_a,
                              rig_exchange_get(plant.rig, table_by_name(table, "sample_i_b")));
}
