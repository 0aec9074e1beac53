/* Frames in a stream: whole frames, frames in two parts, frames between meaningless octets, and missing
 * octets. The expected values are the packets that were put in. */
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

#define SIZE (frames.lossless ? 7u : 10u) /* [octets] length of a frame */

/* A frame of three octets, the first of which is `mark`; on a serial line a fill octet 0 and the sum of
 * words follow. */
static void frame(uint8_t to[10], uint16_t counter, uint8_t mark)
{
    const uint32_t sum = 3u + counter + (mark | 0xAAu << 8) + 0x55u;
    const uint8_t octets[10] = {3,    0, (uint8_t)counter, (uint8_t)(counter >> 8), mark, 0xAA,
                                0x55, 0, (uint8_t)sum,     (uint8_t)(sum >> 8)};
    memcpy(to, octets, SIZE);
}

static void receive_frame(uint16_t counter, uint8_t mark)
{
    uint8_t octets[10];
    frame(octets, counter, mark);
    receive(octets, SIZE);
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

static void test_frames_come_in_order_and_those_that_are_missing_are_counted(void)
{
    static const struct {
        uint16_t counters[3];
        uint32_t missing;
    } rows[] = {{{7, 8, 9}, 0u}, {{0xFFFF, 0, 1}, 0u}, {{10, 15, 16}, 4u}};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        frames_init(&frames, false);
        receive_frame(rows[n].counters[0], 1);
        expect(1);
        receive_frame(rows[n].counters[1], 2);
        receive_frame(rows[n].counters[2], 3);
        expect(2);
        expect(3);
        expect_none();
        TEST_ASSERT_EQUAL(rows[n].missing, frames.missing);
        TEST_ASSERT_EQUAL(0u, frames.dropped);
    }
}

/* The dropped octets are meaningless ones, a length of 0, and a length above the largest one. */
static void test_what_is_not_a_frame_is_dropped_and_the_next_one_is_good(void)
{
    static const uint8_t rubbish[3][7] = {
        {0x80, 0xFF, 0x00, 0x00, 0x11, 0xFF, 0xFF}, {0, 0, 1, 0}, {FRAMES_PACKET + 1u, 0, 1, 0}};
    static const uint32_t octets[3] = {7u, 4u, 4u};
    for (size_t n = 0; n < 3u; n++) {
        frames_init(&frames, false);
        receive(rubbish[n], octets[n]);
        expect_none();
        now += SILENT;
        expect_none();
        TEST_ASSERT_EQUAL(octets[n], frames.dropped);
        receive_frame(5, 1);
        expect(1);
    }
}

static void test_a_frame_may_come_octet_by_octet(void)
{
    uint8_t octets[10];
    frame(octets, 7, 1);
    for (uint32_t n = 0; n < 9u; n++) {
        receive(&octets[n], 1);
        now += 0.005;
        expect_none();
    }
    receive(&octets[9], 1);
    expect(1);
}

static void test_a_half_frame_ends_with_silence_and_the_next_one_is_good(void)
{
    uint8_t octets[10];
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

/* The stream has no pause: the samples follow each other without a gap. */
static void test_stream_is_found_again_after_a_lost_octet(void)
{
    uint8_t stream[10 * 20];
    for (uint16_t n = 0; n < 20u; n++) {
        frame(stream + 10 * n, (uint16_t)(100u + n), (uint8_t)n);
    }
    for (uint32_t lost = 10; lost < 20u; lost++) { /* each octet of the second frame in turn is lost */
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
        TEST_ASSERT_TRUE_MESSAGE(good >= 17u, "at most the damaged frame and the next one are lost");
    }
}

/* One bit of a frame on a serial line is wrong; the octets of the next frame are right. */
static void test_a_frame_with_a_wrong_bit_is_dropped(void)
{
    /* The bits after the length, which defines where the frame ends. */
    for (uint32_t bit = 16; bit < 80u; bit++) {
        uint8_t octets[10];
        frames_init(&frames, false);
        receive_frame(1, 1);
        expect(1);
        frame(octets, 2, 2);
        octets[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        receive(octets, sizeof octets);
        receive_frame(3, 3);
        receive_frame(4, 4);
        now += SILENT;
        expect(3);
        expect(4);
        expect_none();
    }
}

/* Calculated by hand: 0002h + 0102h + 00FFh = 0203h; 0001h + 0103h + 00FDh = 0201h with a fill octet 0
 * after the packet. */
static void test_a_frame_is_made_as_the_standard_has_it(void)
{
    static const uint8_t even[8] = {2, 0, 0x02, 0x01, 0xFF, 0x00, 0x03, 0x02};
    static const uint8_t odd[8] = {1, 0, 0x03, 0x01, 0xFD, 0x00, 0x01, 0x02};
    static const uint8_t connect[2] = {0xFF, 0x00};
    static const uint8_t status[1] = {0xFD};
    uint8_t made[FRAMES_HEADER + 2u + FRAMES_TAIL];
    TEST_ASSERT_EQUAL(8u, frames_make(made, false, 0x0102u, connect, 2u));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(even, made, 8u);
    TEST_ASSERT_EQUAL(8u, frames_make(made, false, 0x0103u, status, 1u));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(odd, made, 8u);
    TEST_ASSERT_EQUAL(5u, frames_make(made, true, 0x0103u, status, 1u));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(odd, made, 5u);
}

static void test_over_a_lossless_line_invalid_octets_end_it(void)
{
    static const uint8_t http[] = "HTTP/1.1 400 Bad Request";
    frames_init(&frames, true);
    receive(http, sizeof http);
    expect_none();
    TEST_ASSERT_TRUE(frames.broken);
}

static void test_over_a_lossless_line_silence_ends_no_frame(void)
{
    uint8_t octets[10];
    frames_init(&frames, true);
    frame(octets, 2, 2);
    receive(octets, 3);
    now += 100.0 * SILENT;
    expect_none();
    receive(octets + 3, 4);
    expect(2);
    TEST_ASSERT_EQUAL(0u, frames.dropped);
}
