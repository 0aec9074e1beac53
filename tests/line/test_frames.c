/* Frames in a stream: whole, in halves, between rubbish, with holes. Expected values are the packets that
 * were put in. */
#include <string.h>

#include "host_sim/line/frames.h"
#include "unity.h"

#define SILENT (FRAMES_SILENCE * 1.01)

static frames_t frames;
static double now; /* [s] */

void setUp(void)
{
    now = 100.0;
    frames_init(&frames, false);
}

static void receive(const uint8_t *octets, uint32_t count)
{
    uint32_t room;
    uint8_t *to = frames_room(&frames, &room);
    TEST_ASSERT_TRUE(count <= room);
    memcpy(to, octets, count);
    frames_received(&frames, count, now);
}

/* A frame of three octets, first one `mark`. */
static void frame(uint8_t to[7], uint16_t counter, uint8_t mark)
{
    const uint8_t octets[7] = {3, 0, (uint8_t)counter, (uint8_t)(counter >> 8), mark, 0xAA, 0x55};
    memcpy(to, octets, sizeof octets);
}

static void receive_frame(uint16_t counter, uint8_t mark)
{
    uint8_t octets[7];
    frame(octets, counter, mark);
    receive(octets, sizeof octets);
}

static void expect(uint8_t mark)
{
    uint32_t length = 0;
    const uint8_t *packet = frames_next(&frames, now, &length);
    TEST_ASSERT_NOT_NULL(packet);
    TEST_ASSERT_EQUAL(3u, length);
    TEST_ASSERT_EQUAL_HEX8(mark, packet[0]);
}

static void expect_none(void)
{
    uint32_t length;
    TEST_ASSERT_NULL(frames_next(&frames, now, &length));
}

static void test_frames_come_in_order(void)
{
    receive_frame(7, 1);
    receive_frame(8, 2);
    expect(1);
    expect(2);
    expect_none();
    TEST_ASSERT_EQUAL(0u, frames.missing);
    TEST_ASSERT_EQUAL(0u, frames.dropped);
}

static void test_a_frame_may_come_octet_by_octet(void)
{
    uint8_t octets[7];
    frame(octets, 7, 1);
    for (uint32_t n = 0; n < 6u; n++) {
        receive(&octets[n], 1);
        now += 0.01;
        expect_none();
    }
    receive(&octets[6], 1);
    expect(1);
}

static void test_counter_wraps_without_a_loss(void)
{
    receive_frame(0xFFFF, 1);
    receive_frame(0, 2);
    expect(1);
    expect(2);
    TEST_ASSERT_EQUAL(0u, frames.missing);
}

static void test_missing_frames_are_counted(void)
{
    receive_frame(10, 1);
    expect(1);
    receive_frame(15, 2);
    receive_frame(16, 3);
    expect(2);
    expect(3);
    TEST_ASSERT_EQUAL(4u, frames.missing);
}

static void test_a_half_frame_ends_with_silence_and_the_next_one_is_good(void)
{
    uint8_t octets[7];
    receive_frame(1, 1);
    expect(1);
    frame(octets, 2, 2);
    receive(octets, 5);
    expect_none();
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, FRAMES_SILENCE, frames_patience(&frames, now));
    now += SILENT;
    expect_none();
    TEST_ASSERT_EQUAL(5u, frames.dropped);
    receive_frame(2, 3);
    expect(3);
}

/* Without any silence: samples that never cease. */
static void test_stream_is_found_again_after_a_lost_octet(void)
{
    uint8_t stream[7 * 20];
    for (uint16_t n = 0; n < 20u; n++) {
        frame(stream + 7 * n, (uint16_t)(100u + n), (uint8_t)n);
    }
    for (uint32_t lost = 7; lost < 14u; lost++) { /* each octet of the second frame in turn */
        frames_init(&frames, false);
        receive_frame(99, 99);
        expect(99);
        receive(stream, lost);
        receive(stream + lost + 1, sizeof stream - lost - 1u);
        expect(0);
        uint32_t good = 0;
        uint32_t length;
        uint8_t last = 0;
        for (const uint8_t *packet = frames_next(&frames, now, &length); packet != NULL;
             packet = frames_next(&frames, now, &length)) {
            TEST_ASSERT_EQUAL(3u, length);
            last = packet[0];
            good++;
        }
        TEST_ASSERT_EQUAL(19u, last);
        TEST_ASSERT_TRUE_MESSAGE(good >= 17u, "at most the spoilt frame and its neighbour are lost");
    }
}

static void test_rubbish_before_the_first_frame_is_dropped(void)
{
    static const uint8_t rubbish[] = {0x80, 0xFF, 0x00, 0x00, 0x11, 0xFF, 0xFF};
    receive(rubbish, sizeof rubbish);
    receive_frame(5, 1);
    receive_frame(6, 2);
    expect(1);
    expect(2);
    TEST_ASSERT_EQUAL(sizeof rubbish, frames.dropped);
}

static void test_lengths_0_and_above_the_most_are_no_frames(void)
{
    static const uint8_t none[] = {0, 0, 1, 0};
    static const uint8_t more[] = {FRAMES_PACKET + 1u, 0, 1, 0};
    receive(none, sizeof none);
    expect_none();
    receive(more, sizeof more);
    expect_none();
    now += SILENT;
    expect_none();
    TEST_ASSERT_EQUAL(8u, frames.dropped);
}

static void test_over_a_lossless_line_rubbish_ends_it(void)
{
    static const uint8_t http[] = "HTTP/1.1 400 Bad Request";
    frames_init(&frames, true);
    receive(http, sizeof http);
    expect_none();
    TEST_ASSERT_TRUE(frames.broken);
}

static void test_over_a_lossless_line_silence_ends_no_frame(void)
{
    uint8_t octets[7];
    frames_init(&frames, true);
    frame(octets, 2, 2);
    receive(octets, 3);
    now += 100.0 * SILENT;
    expect_none();
    receive(octets + 3, 4);
    expect(2);
    TEST_ASSERT_EQUAL(0u, frames.dropped);
}
