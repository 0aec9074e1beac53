/* Frames of XCP on TCP and SxI: LEN and CTR of 16 bits each in Intel order, then the packet; on a serial
 * line a fill octet and the sum of all words follow. */
#include "talk/frame.h"

#include "tests/unit/compare.h"

#define SILENCE 50u

static frame_receiver_t receiver;
static frame_sender_t sender;
static uint32_t now;

void setUp(void)
{
    memset(&receiver, 0x55, sizeof receiver);
    memset(&sender, 0x55, sizeof sender);
    frame_receiver_init(&receiver, SILENCE);
    frame_sender_init(&sender);
    now = 1000u;
}

/* The number of packets that these octets, arriving now, complete. */
static uint32_t hear(const uint16_t *octets, uint32_t count)
{
    uint32_t packets = 0u;
    for (uint32_t n = 0; n < count; n++) {
        packets += frame_take(&receiver, octets[n], now) ? 1u : 0u;
    }
    return packets;
}

static const uint16_t connect[] = {0x02, 0x00, 0x00, 0x00, 0xFF, 0x00};

static void expect_connect(void)
{
    TEST_ASSERT_EQUAL_UINT32(1u, hear(connect, 6u));
    const frame_packet_t packet = frame_packet(&receiver);
    TEST_ASSERT_EQUAL_UINT32(2u, packet.count);
    TEST_ASSERT_EQUAL_HEX16_ARRAY(connect + FRAME_HEADER, packet.octets, 2u);
}

static void test_a_frame_is_complete_with_its_last_octet_and_not_before(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, hear(connect, 5u));
    TEST_ASSERT_TRUE(frame_take(&receiver, connect[5], now));
    TEST_ASSERT_EQUAL_UINT32(1u, receiver.frames);
    TEST_ASSERT_EQUAL_UINT32(0u, receiver.errors);
    expect_connect(); /* the next frame follows at once */
    now += 100u * SILENCE;
    expect_connect(); /* a later frame is also accepted */
}

static void test_a_packet_may_have_the_stated_length_and_not_more(void)
{
    uint16_t frame[FRAME_HEADER + FRAME_MAX_CTO] = {FRAME_MAX_CTO};
    frame[FRAME_HEADER + FRAME_MAX_CTO - 1u] = 0xA5;
    TEST_ASSERT_EQUAL_UINT32(1u, hear(frame, FRAME_HEADER + FRAME_MAX_CTO));
    TEST_ASSERT_EQUAL_UINT32(FRAME_MAX_CTO, frame_packet(&receiver).count);
    TEST_ASSERT_EQUAL_HEX16(0xA5, frame_packet(&receiver).octets[FRAME_MAX_CTO - 1u]);
    static const uint16_t longer[] = {FRAME_MAX_CTO + 1u, 0x00};
    TEST_ASSERT_EQUAL_UINT32(0u, hear(longer, 2u));
    TEST_ASSERT_EQUAL_UINT32(1u, receiver.errors);
}

/* All octets after a wrong length are dropped, until the line has been silent for the required time. */
static void test_after_a_wrong_length_a_silence_brings_it_back(void)
{
    static const uint16_t wrong[][4] = {
        {0x00, 0x00, 0x01, 0x00}, {0x02, 0x01, 0xFF, 0x00}, {0xFF, 0xFF, 0xFF, 0xFF}};
    for (uint32_t n = 0; n < 3u; n++) {
        const uint32_t errors = receiver.errors;
        TEST_ASSERT_EQUAL_UINT32(0u, hear(wrong[n], 4u));
        TEST_ASSERT_EQUAL_UINT32(errors + 1u, receiver.errors);
        now += SILENCE - 1u;
        TEST_ASSERT_EQUAL_UINT32(0u, hear(connect, 6u));
        now += SILENCE - 1u; /* each octet restarts the silence */
        TEST_ASSERT_EQUAL_UINT32(0u, hear(connect, 6u));
        TEST_ASSERT_EQUAL_UINT32(errors + 1u, receiver.errors); /* one wrong length is counted as one error */
        now += SILENCE;
        expect_connect();
    }
}

static void test_half_a_frame_ends_with_a_silence(void)
{
    for (uint32_t octets = 1u; octets < 6u; octets++) {
        const uint32_t errors = receiver.errors;
        TEST_ASSERT_EQUAL_UINT32(0u, hear(connect, octets));
        now += SILENCE - 1u;
        frame_listen(&receiver, now);
        TEST_ASSERT_EQUAL_UINT32(errors, receiver.errors);
        now += 1u;
        frame_listen(&receiver, now);
        TEST_ASSERT_EQUAL_UINT32(errors + 1u, receiver.errors);
        expect_connect(); /* this was the silence */
    }
}

/* The time counter wraps during the frame. */
static void test_slow_octets_make_a_frame_all_the_same(void)
{
    now = UINT32_MAX - 3u * SILENCE;
    for (uint32_t n = 0; n < 5u; n++) {
        TEST_ASSERT_FALSE(frame_take(&receiver, connect[n], now));
        now += SILENCE - 1u;
    }
    TEST_ASSERT_TRUE(frame_take(&receiver, connect[5], now));
}

static void test_an_error_of_the_line_drops_the_frame_under_way(void)
{
    (void)hear(connect, 3u);
    frame_broken(&receiver, now);
    TEST_ASSERT_EQUAL_UINT32(0u, hear(connect + 3, 3u));
    TEST_ASSERT_EQUAL_UINT32(1u, receiver.errors);
    frame_broken(&receiver, now); /* no further octet is lost */
    TEST_ASSERT_EQUAL_UINT32(1u, receiver.errors);
    now += SILENCE;
    expect_connect();
    now += 10u * SILENCE; /* the beginning of a frame was lost: the silence before it does not count as the
                             silence after it */
    frame_broken(&receiver, now);
    TEST_ASSERT_EQUAL_UINT32(0u, hear(connect, 6u));
    now += SILENCE;
    expect_connect();
}

/* While the receiver was off, octets may have arrived that it has not noticed. */
static void test_a_silence_while_not_listening_does_not_count(void)
{
    (void)hear(connect, 3u);
    now += 10u * SILENCE;
    frame_wait(&receiver, now);
    TEST_ASSERT_EQUAL_UINT32(1u, hear(connect + 3, 3u));
}

/* A word of the C28x has sixteen bits, an octet has eight. */
static void test_only_the_lower_eight_bits_of_a_word_count(void)
{
    static const uint16_t frame[] = {0xAA02, 0xFF00, 0x1200, 0x3400, 0x56FF, 0x7800};
    TEST_ASSERT_EQUAL_UINT32(1u, hear(frame, 6u));
    TEST_ASSERT_EQUAL_HEX16(0xFF, frame_packet(&receiver).octets[0]);
    TEST_ASSERT_EQUAL_HEX16(0x00, frame_packet(&receiver).octets[1]);
}

static void test_what_is_sent_has_length_and_counter_in_front(void)
{
    TEST_ASSERT_TRUE(frame_is_free(&sender));
    for (uint32_t counter = 0u; counter < 0x10003u; counter++) {
        frame_open(&sender)[0] = 0xFE;
        frame_open(&sender)[1] = 0x22;
        frame_close(&sender, 2u);
        TEST_ASSERT_FALSE(frame_is_free(&sender));
        const uint16_t expected[] = {2u,   0u,  (uint16_t)(counter & 0xFFu), (uint16_t)(counter >> 8 & 0xFFu),
                                     0xFE, 0x22};
        TEST_ASSERT_EQUAL_UINT32(6u, sender.count);
        TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, sender.octets, 6u);
        sender.sent = 6u;
        TEST_ASSERT_TRUE(frame_is_free(&sender));
    }
}

/* ---- frames with a tail ---- */

/* The columns are: octets, 1 if they are a packet, number of errors so far. */
static void test_with_a_tail_the_sum_must_agree_and_the_counter_must_follow(void)
{
    static const struct {
        uint16_t octets[8];
        uint32_t packets, errors;
    } frames[] = {
        {{0x01, 0, 0x00, 0, 0xFD, 0x00, 0xFE, 0x00}, 0u, 1u}, /* a command before the first CONNECT */
        {{0x02, 0, 0x05, 0, 0xFF, 0x00, 0x06, 0x01}, 1u, 1u}, /* CONNECT: 0002 + 0005 + 00FF */
        {{0x01, 0, 0x06, 0, 0xFD, 0x00, 0x04, 0x01}, 1u, 1u}, /* the next counter: 0001 + 0006 + 00FD */
        {{0x01, 0, 0x06, 0, 0xFD, 0x00, 0x04, 0x01}, 0u, 2u}, /* the same counter twice */
        {{0x01, 0, 0x08, 0, 0xFD, 0x00, 0x06, 0x01}, 0u, 3u}, /* a frame was lost before this one */
        /* A SYNCH packet with any counter; its sum is 100FC, of which 16 bits are sent. */
        {{0x01, 0, 0xFF, 0xFF, 0xFC, 0x00, 0xFC, 0x00}, 1u, 3u},
        {{0x01, 0, 0x00, 0, 0xFD, 0x00, 0xFE, 0x00}, 1u, 3u},
        {{0x01, 0, 0x01, 0, 0xFD, 0x00, 0xFE, 0x00}, 0u, 4u}, /* a wrong sum: FF is the right one */
        {{0x01, 0, 0x01, 0, 0xFD, 0x00, 0xFF, 0x00}, 0u, 4u}, /* no silence has followed the error */
    };
    receiver.tail = 1u;
    for (size_t n = 0; n < sizeof frames / sizeof frames[0]; n++) {
        TEST_ASSERT_EQUAL_UINT32(0u, hear(frames[n].octets, 7u));
        TEST_ASSERT_EQUAL_UINT32(frames[n].packets, hear(frames[n].octets + 7, 1u));
        TEST_ASSERT_EQUAL_UINT32(frames[n].errors, receiver.errors);
    }
}

/* 0003 + 22FE + 0033 with the fill octet 0, which had another value in the buffer; 0004 + 0001 + FFFF +
 * FFFE = 20002. */
static void test_with_a_tail_what_is_sent_ends_with_the_sum(void)
{
    static const uint16_t expected[][10] = {{3u, 0u, 0u, 0u, 0xFE, 0x22, 0x33, 0u, 0x34, 0x23},
                                            {4u, 0u, 1u, 0u, 0xFF, 0xFF, 0xFE, 0xFF, 0x02, 0x00}};
    sender.tail = 1u;
    for (uint32_t n = 0; n < 2u; n++) {
        memset(sender.octets, 0x77, sizeof sender.octets);
        memcpy(frame_open(&sender), expected[n] + FRAME_HEADER, (3u + n) * sizeof expected[n][0]);
        frame_close(&sender, 3u + n);
        TEST_ASSERT_FALSE(frame_is_free(&sender));
        TEST_ASSERT_EQUAL_UINT32(0u, sender.sent);
        TEST_ASSERT_EQUAL_UINT32(10u, sender.count);
        TEST_ASSERT_EQUAL_HEX16_ARRAY(expected[n], sender.octets, 10u);
        sender.sent = 10u;
        TEST_ASSERT_TRUE(frame_is_free(&sender));
    }
}
