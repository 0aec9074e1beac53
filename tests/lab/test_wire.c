/* The server side of the drive's line: one client at a time, unchanged octets, and the effect of a
 * disconnect. */
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "host_sim/lab/wire.h"
#include "unity.h"

static volatile sig_atomic_t stop;
static wire_t *wire;

void setUp(void)
{
    stop = 0;
    wire = NULL;
}

void tearDown(void)
{
    wire_close(wire);
}

static uint32_t port_of(const wire_t *of)
{
    return (uint32_t)strtoul(strchr(wire_name(of), ':') + 1, NULL, 10);
}

static int client_at(uint32_t port)
{
    const struct sockaddr_in at = {.sin_family = AF_INET,
                                   .sin_port = htons((uint16_t)port),
                                   .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
    const struct timeval patience = {.tv_sec = 2};
    const int client = socket(AF_INET, SOCK_STREAM, 0);
    TEST_ASSERT_EQUAL(0, connect(client, (const struct sockaddr *)&at, sizeof at));
    setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    return client;
}

static void open_port(bool wait)
{
    wire_error_t error;
    wire = wire_listen(0u, wait, &stop, &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(wire, error.text);
}

/* The octets that arrive within 20 calls. */
static uint32_t read_some(uint8_t *to, uint32_t room)
{
    uint32_t count = 0;
    for (int n = 0; n < 20 && count < room; n++) {
        wire_poll(wire);
        count += wire_read(wire, &to[count], room - count);
        usleep(1000);
    }
    return count;
}

/* Four frames of 64 octets, which together contain every octet value once. */
static void frames_of_all(uint8_t all[272])
{
    for (uint32_t n = 0; n < 272u; n++) {
        const uint32_t at = n % 68u;
        all[n] = (uint8_t)(at == 0u ? 64u : at < 4u ? 0u : n / 68u * 64u + at - 4u);
    }
}

static void test_octets_pass_both_ways_as_they_are(void)
{
    uint8_t all[272], got[272];
    frames_of_all(all);
    open_port(false);
    const int client = client_at(port_of(wire));
    TEST_ASSERT_EQUAL(272, send(client, all, sizeof all, 0));
    TEST_ASSERT_EQUAL_UINT32(272u, read_some(got, sizeof got));
    TEST_ASSERT_EQUAL_UINT8_ARRAY(all, got, 272);
    TEST_ASSERT_TRUE(wire_has_client(wire));
    TEST_ASSERT_EQUAL_UINT32(272u, wire_write(wire, all, sizeof all));
    wire_poll(wire);
    memset(got, 0, sizeof got);
    TEST_ASSERT_EQUAL(272, recv(client, got, sizeof got, MSG_WAITALL));
    TEST_ASSERT_EQUAL_UINT8_ARRAY(all, got, 272);
    close(client);
}

static void test_second_client_sees_an_end_and_the_first_goes_on(void)
{
    uint8_t octet = 7u;
    open_port(false);
    const int first = client_at(port_of(wire));
    wire_poll(wire);
    const int second = client_at(port_of(wire));
    wire_poll(wire);
    TEST_ASSERT_EQUAL(0, recv(second, &octet, 1, 0));
    TEST_ASSERT_EQUAL(5, send(first, (const uint8_t[]){1, 0, 0, 0, 7}, 5, 0));
    uint8_t octets[5];
    TEST_ASSERT_EQUAL_UINT32(5u, read_some(octets, 5u));
    close(first);
    close(second);
}

static void test_only_this_machine_is_listened_to(void)
{
    struct sockaddr_in other = {.sin_family = AF_INET, .sin_addr = {.s_addr = htonl(0x7f000002u)}};
    open_port(false);
    other.sin_port = htons((uint16_t)port_of(wire));
    const int client = socket(AF_INET, SOCK_STREAM, 0);
    TEST_ASSERT_EQUAL(-1, connect(client, (const struct sockaddr *)&other, sizeof other)); /* 127.0.0.2 */
    TEST_ASSERT_EQUAL(ECONNREFUSED, errno);
    close(client);
}

/* The drive receives silence, a DISCONNECT, and silence. Then the next client is accepted and receives no
 * data of the first one. This holds also for a client that connects before the server has noticed that the
 * first one is gone. */
static void test_a_disconnect_is_sent_for_a_client_that_leaves_before_the_next_one_is_served(void)
{
    static const uint8_t goodbye[] = {1u, 0u, 0u, 0u, 0xfeu};
    uint8_t octets[16];
    open_port(false);
    for (int seen = 1; seen >= 0; seen--) {
        const int first = client_at(port_of(wire));
        wire_poll(wire);
        close(first);
        if (seen != 0) {
            wire_poll(wire);
            TEST_ASSERT_FALSE(wire_has_client(wire));
        }
        const int second = client_at(port_of(wire));
        TEST_ASSERT_EQUAL(5, send(second, (const uint8_t[]){1, 0, 0, 0, 'x'}, 5, 0));
        uint32_t polls = 0;
        uint32_t count = 0;
        while (count == 0u && polls < 100u) {
            wire_poll(wire);
            polls++;
            count = wire_read(wire, octets, sizeof octets);
        }
        /* [ms] longer than the wait for the rest of a frame. */
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(6u, polls);
        TEST_ASSERT_EQUAL_UINT32(sizeof goodbye, count);
        TEST_ASSERT_EQUAL_UINT8_ARRAY(goodbye, octets, sizeof goodbye);
        /* An answer of the drive, for which there is no client. */
        TEST_ASSERT_EQUAL_UINT32(3u, wire_write(wire, octets, 3u));
        TEST_ASSERT_EQUAL_UINT32(5u, read_some(octets, 5u));
        TEST_ASSERT_EQUAL('x', octets[4]);
        TEST_ASSERT_EQUAL(-1, recv(second, octets, 1, MSG_DONTWAIT));
        close(second);
        wire_poll(wire);
        read_some(octets, 5u); /* the DISCONNECT for the second client */
    }
}

static void test_without_a_client_all_octets_are_accepted(void)
{
    const uint8_t octets[100] = {0};
    open_port(true);
    for (int n = 0; n < 10000; n++) {
        TEST_ASSERT_EQUAL_UINT32(100u, wire_write(wire, octets, sizeof octets));
    }
}

/* A client does not read, and the line does not wait: the line accepts fewer and fewer octets. */
static void test_without_waiting_a_slow_client_leaves_no_room(void)
{
    const uint8_t octets[100] = {0};
    open_port(false);
    const int client = client_at(port_of(wire));
    wire_poll(wire);
    uint32_t taken = 0;
    for (int n = 0; n < 100000; n++) { /* 10 MB, more than two sockets can store */
        taken += wire_write(wire, octets, sizeof octets);
        wire_poll(wire);
    }
    TEST_ASSERT_LESS_THAN_UINT32(10000000u, taken);
    TEST_ASSERT_EQUAL_UINT32(0u, wire_write(wire, octets, sizeof octets));
    close(client);
}

/* A child process writes 10 MB of a counter through a line that waits; all octets arrive in order. */
static void test_with_waiting_nothing_is_lost(void)
{
    enum { TOTAL = 10000000 };
    static uint8_t got[65536];
    open_port(true);
    const int client = client_at(port_of(wire));
    wire_poll(wire);
    const pid_t child = fork();
    TEST_ASSERT_GREATER_OR_EQUAL(0, child);
    if (child == 0) {
        uint8_t octets[100];
        for (uint32_t n = 0; n < TOTAL; n += 100u) {
            for (uint32_t k = 0; k < 100u; k++) {
                octets[k] = (uint8_t)((n + k) % 251u);
            }
            if (wire_write(wire, octets, sizeof octets) != sizeof octets) {
                _exit(1);
            }
        }
        for (int n = 0; n < 2000; n++) {
            wire_poll(wire);
            usleep(1000);
        }
        _exit(0);
    }
    usleep(200000); /* the writer has filled all buffers by now */
    uint32_t count = 0, wrong = 0;
    while (count < TOTAL) {
        const ssize_t n = recv(client, got, sizeof got, 0);
        if (n <= 0) {
            break;
        }
        for (ssize_t k = 0; k < n; k++) {
            wrong += got[k] != (uint8_t)((count + (uint32_t)k) % 251u);
        }
        count += (uint32_t)n;
    }
    kill(child, SIGKILL);
    close(client);
    TEST_ASSERT_EQUAL_UINT32(TOTAL, count);
    TEST_ASSERT_EQUAL_UINT32(0u, wrong);
}

static void on_alarm(int number)
{
    (void)number;
    stop = 1;
}

static void test_stop_ends_the_waiting(void)
{
    const uint8_t octets[100] = {0};
    const struct itimerval soon = {.it_value = {.tv_usec = 300000}};
    open_port(true);
    const int client = client_at(port_of(wire));
    wire_poll(wire);
    signal(SIGALRM, on_alarm);
    setitimer(ITIMER_REAL, &soon, NULL);
    uint32_t writes = 0;
    while (stop == 0 && writes < 1000000u) {
        (void)wire_write(wire, octets, sizeof octets);
        writes++;
    }
    TEST_ASSERT_LESS_THAN_UINT32(1000000u, writes); /* the signal has ended it, not the count */
    close(client);
}

/* All octet values are transferred, also those that a terminal would interpret as commands or change. */
static void test_terminal_is_raw(void)
{
    wire_error_t error;
    uint8_t all[256], got[256];
    for (uint32_t n = 0; n < 256u; n++) {
        all[n] = (uint8_t)n;
    }
    wire = wire_terminal(&error);
    TEST_ASSERT_NOT_NULL_MESSAGE(wire, error.text);
    const int client = open(wire_name(wire), O_RDWR | O_NOCTTY);
    TEST_ASSERT_GREATER_OR_EQUAL(0, client);
    TEST_ASSERT_EQUAL(256, write(client, all, sizeof all));
    TEST_ASSERT_EQUAL_UINT32(256u, read_some(got, sizeof got));
    TEST_ASSERT_EQUAL_UINT8_ARRAY(all, got, 256);
    TEST_ASSERT_EQUAL_UINT32(256u, wire_write(wire, all, sizeof all));
    wire_poll(wire);
    memset(got, 0, sizeof got);
    uint32_t count = 0;
    struct pollfd look = {.fd = client, .events = POLLIN};
    while (count < 256u && poll(&look, 1, 2000) == 1) {
        count += (uint32_t)read(client, &got[count], sizeof got - count);
    }
    TEST_ASSERT_EQUAL_UINT8_ARRAY(all, got, 256);
    close(client);
    read_some(got, 1u); /* the client may connect and disconnect */
    const int again = open(wire_name(wire), O_RDWR | O_NOCTTY);
    TEST_ASSERT_EQUAL(3, write(again, "abc", 3));
    TEST_ASSERT_EQUAL_UINT32(3u, read_some(got, 3u));
    close(again);
}

/* ---- octets that are not a frame end the connection, and none of them is passed on ---- */

static int connected(void)
{
    open_port(false);
    const int client = client_at(port_of(wire));
    wire_poll(wire);
    TEST_ASSERT_TRUE(wire_has_client(wire));
    return client;
}

static void put(int client, const void *octets, size_t count)
{
    TEST_ASSERT_EQUAL((ssize_t)count, send(client, octets, count, MSG_NOSIGNAL));
}

/* The drive receives only the DISCONNECT that the server itself sends for a client that has disconnected. */
static void expect_closed_unheard(int client)
{
    static const uint8_t goodbye[] = {1, 0, 0, 0, 0xFE};
    uint8_t heard[64];
    const uint32_t count = read_some(heard, sizeof heard);
    TEST_ASSERT_FALSE(wire_has_client(wire));
    TEST_ASSERT_TRUE(count == 0u || (count == sizeof goodbye && memcmp(heard, goodbye, count) == 0));
    TEST_ASSERT_TRUE(recv(client, heard, 1, 0) <= 0); /* the connection ends or is reset */
    close(client);
    wire_close(wire);
    wire = NULL;
}

/* CONNECT, SET_MTA and DOWNLOAD, which would switch the motor on. */
static const uint8_t start[] = {2,    0,    0, 0, 0xFF, 0x00, 8, 0, 1,    0, 0xF6, 0, 0, 2,
                                0xA0, 0x0F, 0, 0, 6,    0,    2, 0, 0xF0, 4, 0x79, 0, 0, 0};

/* The other octets are HTTP, TLS, and lengths of 0 and above the largest one. */
static void test_frames_behind_other_octets_are_ignored(void)
{
#define HEAD(text)                                                                                           \
    {                                                                                                        \
        text, sizeof text - 1u                                                                               \
    }
    static const struct {
        const char *octets;
        size_t count;
    } heads[] = {HEAD("GET / HTTP/1.1\r\nHost: x\r\n\r\n"),
                 HEAD("POST / HTTP/1.1\r\n\r\n"),
                 HEAD("OPTIONS * HTTP/1.1\r\n\r\n"),
                 HEAD("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
                 HEAD("\x16\x03\x01\x00\xA5\x01\x00\x00\xA1\x03\x03"),
                 HEAD("\0\0\0\0"),
                 HEAD("\x41\0\0\0"),
                 HEAD("\x01\x01\0\0")};
    for (size_t n = 0; n < sizeof heads / sizeof heads[0]; n++) {
        const int client = connected();
        put(client, heads[n].octets, heads[n].count);
        put(client, start, sizeof start);
        expect_closed_unheard(client);
    }
}

static void test_valid_frames_before_an_invalid_one_are_accepted_and_none_behind_it(void)
{
    uint8_t heard[64];
    const int client = connected();
    put(client, start, 6u);
    TEST_ASSERT_EQUAL_UINT32(6u, read_some(heard, sizeof heard));
    put(client, "GET ", 4u);
    put(client, start + 6, sizeof start - 6u);
    expect_closed_unheard(client);
}

/* TCP may deliver a frame in pieces with any pause between them; the drive receives the whole frame. */
static void test_a_frame_in_pieces_is_handed_on_whole(void)
{
    uint8_t heard[64];
    const int client = connected();
    for (uint32_t n = 0; n < 6u; n++) {
        TEST_ASSERT_EQUAL_UINT32(0u, read_some(heard, sizeof heard));
        put(client, &start[n], 1u);
    }
    TEST_ASSERT_EQUAL_UINT32(6u, read_some(heard, sizeof heard));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(start, heard, 6);
    TEST_ASSERT_TRUE(wire_has_client(wire));
    close(client);
}
