/* The slave on the chip's serial line, bit by bit. An octet without its stop bit, or a break within a
 * write, invalidates the whole frame. Octets that follow it without a pause are not taken for a frame.
 * After SYNCH the write takes effect. */
#include <string.h>

#include "app/app.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/frames.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"
#include "unity.h"

#define BITS     10u /* bits of an octet on the line: start, eight, stop */
#define REQUESTS 2u
#define PAUSE    60u /* [periods] longer than the silence that ends a frame */

static uint32_t counter;
/* Number of the octet of the next frame that is sent without its stop bit; the first is 1, 0 is none. */
static uint32_t broken;
/* Number of the octet of the next frame that a break follows; the first is 1, 0 is none. */
static uint32_t break_after;

static chip_t *chip(void)
{
    return &rig_state(rig)->chip;
}

static void put_octet(uint8_t octet, bool stopped)
{
    const uint32_t levels = (uint32_t)octet << 1 | (stopped ? 1u << 9 : 0u);
    while (!chip_serial_levels(chip(), levels, BITS)) {
        rig_step(rig);
    }
}

static void send(const uint8_t *packet, uint32_t count)
{
    uint8_t frame[FRAMES_MOST];
    const uint32_t octets = frames_make(frame, packet, count, counter++, true);
    for (uint32_t n = 0; n < octets; n++) {
        put_octet(frame[n], n + 1u != broken);
        if (n + 1u == break_after) {
            TEST_ASSERT_TRUE(chip_serial_levels(chip(), 0u, 30u));
        }
    }
    broken = break_after = 0u;
}
#define SEND(...) send((const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

static void choose_enable(void)
{
    for (uint32_t n = 0; n < 2u; n++) {
        SEND(0xF6, 0, 0, REQUESTS, 0xA0, 0x0F, 0, 0);
        rig_run(rig, 20u);
    }
}

static void switch_on(void)
{
    uint8_t packet[6] = {0xF0, 4};
    frames_put_long(packet + 2, frames_code(1000u, 1u)); /* enable, on */
    send(packet, sizeof packet);
    rig_run(rig, PAUSE);
}

void setUp(void)
{
    rig = rig_create(1u);
    run_put(rig, "fidelity", 1.0);
    rig_run(rig, rig_periods(0.06));
    counter = broken = break_after = 0u;
    SEND(0xFF, 0x00);
    rig_run(rig, PAUSE);
    TEST_ASSERT_EQUAL_UINT32(1u, rig_state(rig)->app.talk.xcp.connected);
}

static double value(const char *name)
{
    return rig_value(rig, name);
}

static void is_spoilt_and_acts_again(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value("enable"));
    TEST_ASSERT_TRUE(value("line_errors") > 0.0);
    SEND(0xFC);
    rig_run(rig, PAUSE);
    choose_enable();
    switch_on();
    TEST_ASSERT_EQUAL_DOUBLE(1.0, value("enable"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value("chip_reports"));
}

static void test_undisturbed_a_write_acts(void)
{
    choose_enable();
    switch_on();
    TEST_ASSERT_EQUAL_DOUBLE(1.0, value("enable"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value("line_errors"));
}

/* The test sends the frame with each octet in turn without its stop bit, and with a break after each octet
 * but the last. */
static void test_a_broken_octet_or_a_break_invalidates_the_frame(void)
{
    for (uint32_t n = 2u; n <= 24u; n++) {
        tearDown();
        setUp();
        choose_enable();
        *(n % 2u == 0u ? &broken : &break_after) = n / 2u;
        switch_on();
        is_spoilt_and_acts_again();
    }
}

/* The frames that follow an invalid one at once are not received before a pause. */
static void test_octets_after_an_invalid_frame_without_a_pause_are_dropped(void)
{
    choose_enable();
    broken = 3u;
    SEND(0xFD);
    counter = 0x8000u; /* the counter would be accepted: that of SYNCH and CONNECT is not checked */
    SEND(0xFF, 0x00);
    SEND(0xFC);
    choose_enable();
    const double frames = value("line_frames");
    TEST_ASSERT_EQUAL_DOUBLE(3.0, frames); /* the frames of CONNECT and of two SET_MTA */
    rig_run(rig, PAUSE);
    is_spoilt_and_acts_again();
}

/* The octet before a break may have been the last of a frame: an octet directly after the break is not
 * taken for the beginning of a frame. */
static void test_a_good_frame_right_behind_a_break_is_dropped(void)
{
    const double frames = value("line_frames");
    TEST_ASSERT_TRUE(chip_serial_levels(chip(), 0u, 30u));
    rig_run(rig, 2u);
    SEND(0xFD);
    rig_run(rig, PAUSE);
    TEST_ASSERT_EQUAL_DOUBLE(frames, value("line_frames"));
    SEND(0xFC);
    rig_run(rig, PAUSE);
    TEST_ASSERT_EQUAL_DOUBLE(frames + 1.0, value("line_frames"));
}

/* On a line of two wires the drive receives all octets that it sends. The answer to a single write equals
 * its request. */
static void test_a_modbus_server_ignores_its_own_answer(void)
{
    static const uint8_t enable_off[] = {0x01, 0x06, 0x07, 0xD1, 0x00, 0x00, 0xD8, 0x87};
    uint8_t octets[16];
    uint32_t answered = 0u;
    TEST_ASSERT_EQUAL_UINT32(14u, rig_serial_get(rig, octets, sizeof octets)); /* the answer to CONNECT */
    run_parameter(rig, "modbus_baud", 115200.0);
    run_parameter(rig, "line_protocol", LINE_MODBUS);
    rig_serial_baud(rig, 0u);
    rig_run(rig, 300u);
    TEST_ASSERT_EQUAL_UINT32(8u, rig_serial_put(rig, enable_off, 8u));
    for (uint32_t n = 0; n < 2000u; n++) {
        rig_step(rig);
        const uint32_t count = rig_serial_get(rig, octets, sizeof octets);
        TEST_ASSERT_EQUAL_UINT32(count, rig_serial_put(rig, octets, count));
        answered += count;
    }
    TEST_ASSERT_EQUAL_UINT32(8u, answered);
}
