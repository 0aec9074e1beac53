/* The drive's TCP port and clients that do not speak XCP: their connections are closed, and nothing of theirs
 * is handed on to the drive, frames behind an HTTP head included. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "host_sim/lab/wire.h"
#include "unity.h"

static volatile sig_atomic_t stop;
static wire_t *wire;
static int client;
static uint8_t heard[4096];

static void poll_some(void)
{
    for (int n = 0; n < 10; n++) {
        wire_poll(wire);
        usleep(1000);
    }
}

static uint32_t hear(void)
{
    uint32_t count = 0;
    for (int n = 0; n < 10; n++) {
        wire_poll(wire);
        count += wire_read(wire, &heard[count], (uint32_t)sizeof heard - count);
        usleep(1000);
    }
    return count;
}

void setUp(void)
{
    wire_error_t error;
    const struct timeval patience = {.tv_sec = 2};
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
    wire = wire_listen(0u, false, &stop, &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(wire, error.text);
    at.sin_port = htons((uint16_t)strtoul(strchr(wire_name(wire), ':') + 1, NULL, 10));
    client = socket(AF_INET, SOCK_STREAM, 0);
    TEST_ASSERT_EQUAL(0, connect(client, (const struct sockaddr *)&at, sizeof at));
    setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    poll_some();
    TEST_ASSERT_TRUE(wire_has_client(wire));
}

void tearDown(void)
{
    close(client);
    wire_close(wire);
}

static void put(const void *octets, size_t count)
{
    TEST_ASSERT_EQUAL((ssize_t)count, send(client, octets, count, MSG_NOSIGNAL));
}

/* Nothing but the good-bye that the wire itself says for a client that has gone. */
static void is_closed_unheard(void)
{
    static const uint8_t goodbye[] = {1, 0, 0, 0, 0xFE};
    uint8_t octet;
    const uint32_t count = hear();
    TEST_ASSERT_FALSE(wire_has_client(wire));
    TEST_ASSERT_TRUE(count == 0u || (count == sizeof goodbye && memcmp(heard, goodbye, count) == 0));
    TEST_ASSERT_TRUE(recv(client, &octet, 1, 0) <= 0); /* an end or a reset, no silence */
}

static const uint8_t start[] = {2,    0,    0, 0, 0xFF, 0x00, 8, 0, 1,    0, 0xF6, 0, 0, 2,
                                0xA0, 0x0F, 0, 0, 6,    0,    2, 0, 0xF0, 4, 0x79, 0, 0, 0};

static void test_frames_behind_an_http_head_are_not_heard(void)
{
    static const char *const heads[] = {"GET / HTTP/1.1\r\nHost: x\r\n\r\n", "POST / HTTP/1.1\r\n\r\n",
                                        "OPTIONS * HTTP/1.1\r\n\r\n", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"};
    for (uint32_t n = 0; n < sizeof heads / sizeof heads[0]; n++) {
        if (n > 0u) {
            tearDown();
            setUp();
        }
        put(heads[n], strlen(heads[n]));
        put(start, sizeof start);
        is_closed_unheard();
    }
}

static void test_a_tls_hello_is_not_heard(void)
{
    static const uint8_t hello[] = {0x16, 0x03, 0x01, 0x00, 0xA5, 0x01, 0x00, 0x00, 0xA1, 0x03, 0x03};
    put(hello, sizeof hello);
    put(start, sizeof start);
    is_closed_unheard();
}

static void test_lengths_of_0_and_above_the_largest_close(void)
{
    static const uint8_t wrong[][4] = {{0, 0, 0, 0}, {65, 0, 0, 0}, {1, 1, 0, 0}};
    for (uint32_t n = 0; n < 3u; n++) {
        if (n > 0u) {
            tearDown();
            setUp();
        }
        put(wrong[n], 4u);
        put(start, sizeof start);
        is_closed_unheard();
    }
}

static void test_good_frames_before_a_bad_one_are_heard_and_none_behind_it(void)
{
    put(start, 6u);
    TEST_ASSERT_EQUAL(6u, hear());
    put("GET ", 4u);
    put(start + 6, sizeof start - 6u);
    is_closed_unheard();
}

/* TCP may deliver a frame in pieces, however long they are apart: the drive gets it whole. */
static void test_a_frame_in_pieces_is_handed_on_whole(void)
{
    for (uint32_t n = 0; n < 6u; n++) {
        TEST_ASSERT_EQUAL(0u, hear());
        put(&start[n], 1u);
    }
    TEST_ASSERT_EQUAL(6u, hear());
    TEST_ASSERT_EQUAL_HEX8_ARRAY(start, heard, 6);
    TEST_ASSERT_TRUE(wire_has_client(wire));
}

static void test_the_longest_frame_passes(void)
{
    uint8_t longest[68] = {64};
    put(longest, sizeof longest);
    TEST_ASSERT_EQUAL(68u, hear());
    TEST_ASSERT_TRUE(wire_has_client(wire));
}
