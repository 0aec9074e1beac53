/* The serial line, the stored pages and the restart in the whole simulation: HAL, virtual chip and plant. */
#include "hal/hal.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/frames.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

#define LINE_SECONDS (10.0 / (double)BOARD_SERIAL_BAUD) /* time of an octet */

/* The slave uses another line: only this file sends and receives on the line of the chip. */
static uint32_t nothing_comes(void *context, uint8_t *octets, uint32_t room)
{
    (void)context;
    (void)octets;
    (void)room;
    return 0u;
}

static uint32_t nothing_goes(void *context, const uint8_t *octets, uint32_t count)
{
    (void)context;
    (void)octets;
    return count;
}

static const rig_line_t elsewhere = {nothing_comes, nothing_goes, NULL};

void setUp(void)
{
    rig = run_rig(1u);
    rig_line(rig, &elsewhere);
}

static double value(const char *name)
{
    return rig_value(rig, name);
}

static void put(const char *name, double to)
{
    run_put(rig, name, to);
}

static chip_t *chip(void)
{
    return &rig_state(rig)->chip;
}

static uint32_t reports(void)
{
    return chip_report_total(chip());
}

/* The octets that the background of the firmware would read now. */
static uint32_t heard(uint16_t octets[16])
{
    rig_bind(rig);
    return hal_serial_read(octets, 16u);
}

static void test_octets_come_through_at_the_line_s_rate(void)
{
    uint8_t octets[64];
    if (RIG_PERIOD_SECONDS > 16.0 * LINE_SECONDS) {
        return; /* this test reads once in a period */
    }
    uint16_t got[16];
    uint32_t count = 0;
    for (uint32_t n = 0; n < 64u; n++) {
        octets[n] = (uint8_t)(3u * n);
    }
    TEST_ASSERT_EQUAL_UINT32(64u, rig_serial_put(rig, octets, 64u));
    for (uint32_t period = 1u; count < 64u; period++) {
        rig_step(rig);
        const uint32_t more = heard(got);
        for (uint32_t n = 0; n < more; n++) {
            TEST_ASSERT_EQUAL_HEX16(octets[count + n], got[n]);
        }
        count += more;
        const double sent = (double)period * RIG_PERIOD_SECONDS / LINE_SECONDS;
        TEST_ASSERT_TRUE((double)count <= sent + 0.05 && ((double)count > sent - 1.05 || count == 64u));
    }
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_errors());
    TEST_ASSERT_EQUAL_UINT32(0u, reports());
}

static void test_octets_go_out_at_the_line_s_rate(void)
{
    uint16_t octets[17];
    uint8_t got[64];
    for (uint16_t n = 0; n < 17u; n++) {
        octets[n] = (uint16_t)(0xA0u + n);
    }
    rig_bind(rig);
    TEST_ASSERT_EQUAL_UINT32(16u, hal_serial_write(octets, 17u));
    uint32_t count = 0;
    for (uint32_t period = 1u; count < 16u; period++) {
        rig_step(rig);
        count += rig_serial_get(rig, &got[count], 64u - count);
        const double sent = (double)period * RIG_PERIOD_SECONDS / LINE_SECONDS;
        TEST_ASSERT_TRUE((double)count <= sent + 0.01 && ((double)count > sent - 1.01 || count == 16u));
    }
    for (uint32_t n = 0; n < 16u; n++) {
        TEST_ASSERT_EQUAL_HEX8(0xA0u + n, got[n]);
    }
    TEST_ASSERT_EQUAL_UINT32(0u, reports());
}

/* ---- The drive's own interrupts at the line ---- */

static void send(const uint8_t *packet, uint32_t count, uint32_t number)
{
    uint8_t frame[FRAMES_MOST];
    const uint32_t octets = frames_make(frame, packet, count, number, true);
    for (uint32_t sent = 0; sent < octets; rig_step(rig)) {
        sent += rig_serial_put(rig, frame + sent, octets - sent);
    }
}

/* A master sends two commands of the greatest length in succession at the full rate of the line. No octet
 * is lost although the background waits until both have arrived, at every carrier frequency. */
static void test_two_of_the_largest_commands_wait_for_a_background_that_is_late(void)
{
    const uint8_t connect[2] = {0xFF, 0};
    const uint8_t packet[64] = {0xF0, 62};
    rig_line(rig, NULL);
    run_seconds(rig, 0.1);
    send(connect, sizeof connect, 0u);
    put("background_time", 4e-3); /* shorter than the silence that ends a frame */
    run_seconds(rig, 40e-3);
    for (uint32_t n = 0; n < 20u; n++) {
        send(packet, sizeof packet, 2u * n + 1u);
        send(packet, sizeof packet, 2u * n + 2u);
        run_seconds(rig, 40e-3);
        TEST_ASSERT_EQUAL_DOUBLE(2.0 * n + 3.0, value("line_frames"));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value("line_errors"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value("fault_reason"));
    TEST_ASSERT_EQUAL_UINT32(0u, reports());
    rig_bind(rig);
    TEST_ASSERT_EQUAL_UINT32(0u, hal_serial_errors());
}

/* A client floods the line. The interrupt must not be requested without end for octets that do not fit,
 * and the lost octets are counted. */
static void test_octets_without_room_are_dropped_and_counted(void)
{
    static const uint8_t flood[64];
    rig_line(rig, NULL);
    run_seconds(rig, 0.1);
    put("background_time", 0.2);
    rig_run(rig, 10u);
    const uint32_t before = chip_interrupt_count(chip(), PIE_SCIRXINTA);
    uint32_t sent = 0;
    for (; sent < 2000u; rig_step(rig)) {
        sent += rig_serial_put(rig, flood, sizeof flood);
    }
    rig_bind(rig);
    TEST_ASSERT_TRUE(hal_serial_errors() > 0u);
    TEST_ASSERT_TRUE(chip_interrupt_count(chip(), PIE_SCIRXINTA) - before <= sent / 4u);
    put("background_time", 2e-6);
    run_seconds(rig, 0.3);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value("fault_reason"));
    TEST_ASSERT_EQUAL_UINT32(0u, reports());
}

/* ---- Stored pages ---- */

static void program(uint32_t page, uint32_t at, uint16_t word)
{
    rig_bind(rig);
    TEST_ASSERT_TRUE(hal_store_program(page, at, &word, 1u));
}

static uint16_t stored(uint32_t page, uint32_t at)
{
    rig_bind(rig);
    return hal_store_word(page, at);
}

static void test_the_pages_outlive_the_supply_and_the_drive_begins_again(void)
{
    put("plant.inertia", 0.01);
    rig_set_motion(rig, 1.0, 30.0);
    rig_run(rig, 200u);
    program(0u, 3u, 0x1234u);
    program(1u, 5u, 0x4321u);
    put("motor_inertia", 0.02);
    TEST_ASSERT_TRUE(rig_apply(rig));
    rig_run(rig, 200u);
    const uint32_t period = rig_period(rig);
    const double speed = value("true_omega_m");
    rig_power_cycle(rig);
    TEST_ASSERT_EQUAL_UINT32(period, rig_period(rig));
    rig_run(rig, 1u);
    TEST_ASSERT_EQUAL_UINT32(period + 1u, rig_period(rig));
    TEST_ASSERT_EQUAL_HEX16(0x1234u, stored(0u, 3u));
    TEST_ASSERT_EQUAL_HEX16(0x4321u, stored(1u, 5u));
    TEST_ASSERT_EQUAL_DOUBLE(rig_initial_named("motor_inertia"), value("motor_inertia"));
    TEST_ASSERT_EQUAL_DOUBLE((double)0.01f, value("plant.inertia"));
    TEST_ASSERT_TRUE(speed > 1.0);
    TEST_ASSERT_TRUE(value("true_omega_m") > 0.5 * speed && value("true_omega_m") < speed);
    rig_run(rig, 2000u);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, value("state")); /* the state ready */
    TEST_ASSERT_EQUAL_UINT32(0u, reports());
}

static void test_the_flash_goes_through_a_file_of_octets(void)
{
    static uint8_t octets[RIG_FLASH_SIZE], again[RIG_FLASH_SIZE];
    if (BOARD_STORE != BOARD_STORE_FLASH) {
        return; /* this board has another memory: tests/board/test_store_memory.c */
    }
    program(0u, 0u, 0x1234u);
    program(1u, 9u, 0xABCDu);
    rig_flash_save(rig, octets);
    TEST_ASSERT_EQUAL_HEX8(0x34u, octets[0]);
    TEST_ASSERT_EQUAL_HEX8(0x12u, octets[1]);
    TEST_ASSERT_EQUAL_HEX8(0xCDu, octets[65536u + 18u]);
    TEST_ASSERT_EQUAL_HEX8(0xFFu, octets[RIG_FLASH_SIZE - 1u]);
    rig_t *other = run_rig(2u);
    TEST_ASSERT_TRUE(rig_flash_load(other, octets, sizeof octets));
    rig_flash_save(other, again);
    TEST_ASSERT_EQUAL_MEMORY(octets, again, sizeof octets);
    TEST_ASSERT_FALSE(rig_flash_load(other, octets, sizeof octets - 1u));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(other), "131072"));
    octets[0] = 0x99u;
    octets[RIG_FLASH_SIZE - 1u] = 0u;
    TEST_ASSERT_FALSE(rig_flash_load(other, octets, sizeof octets));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(other), "page 1"));
    rig_flash_save(other, again);
    TEST_ASSERT_EQUAL_HEX8(0x34u, again[0]);
    rig_free(other);
}
