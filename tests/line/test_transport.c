/* Names of targets, and serial devices, in whose place the test uses a pseudo terminal. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/line/transport.h"
#include "unity.h"

static transport_target_t parsed;
static char why[320];

void setUp(void)
{
    why[0] = '\0';
}

static void refused(const char *target, const char *part)
{
    TEST_ASSERT_FALSE(transport_parse(target, &parsed, why, sizeof why));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why, part), why);
}

static void test_tcp_targets(void)
{
    TEST_ASSERT_TRUE(transport_parse("tcp://127.0.0.1:5555", &parsed, why, sizeof why));
    TEST_ASSERT_TRUE(parsed.tcp);
    TEST_ASSERT_EQUAL_STRING("127.0.0.1", parsed.place);
    TEST_ASSERT_EQUAL_STRING("5555", parsed.port);
    TEST_ASSERT_TRUE(transport_parse("tcp://[::1]:1", &parsed, why, sizeof why));
    TEST_ASSERT_EQUAL_STRING("::1", parsed.place);
    TEST_ASSERT_EQUAL_STRING("1", parsed.port);
}

static void test_devices_with_and_without_a_baud(void)
{
    TEST_ASSERT_TRUE(transport_parse("/dev/ttyUSB0", &parsed, why, sizeof why));
    TEST_ASSERT_FALSE(parsed.tcp);
    TEST_ASSERT_EQUAL_STRING("/dev/ttyUSB0", parsed.place);
    TEST_ASSERT_EQUAL(937500u, parsed.baud);
    TEST_ASSERT_TRUE(transport_parse("/dev/ttyUSB0:115200", &parsed, why, sizeof why));
    TEST_ASSERT_EQUAL_STRING("/dev/ttyUSB0", parsed.place);
    TEST_ASSERT_EQUAL(115200u, parsed.baud);
    TEST_ASSERT_TRUE(transport_parse("/dev/serial/by-id/usb-a:b/x", &parsed, why, sizeof why));
    TEST_ASSERT_EQUAL_STRING("/dev/serial/by-id/usb-a:b/x", parsed.place);
}

static void test_what_is_not_a_target_is_reported_with_what_would_be(void)
{
    refused("", "accepted");
    refused("drive", "accepted: tcp://HOST:PORT");
    refused("http://127.0.0.1:80", "accepted");
    refused("tcp://127.0.0.1", "port 1 to 65535");
    refused("tcp://127.0.0.1:0", "port 1 to 65535");
    refused("tcp://127.0.0.1:65536", "port 1 to 65535");
    refused("tcp://127.0.0.1:55x", "port 1 to 65535");
    refused("tcp://:5555", "no host");
    refused("/dev/ttyUSB0:fast", "whole numbers 1200 to 12000000");
    refused("/dev/ttyUSB0:300", "whole numbers 1200 to 12000000");
}

/* Returns the master side of a pseudo terminal; `name` receives the name of the other side. */
static int terminal(char name[64])
{
    const int master = posix_openpt(O_RDWR | O_NOCTTY);
    TEST_ASSERT_TRUE(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
    TEST_ASSERT_EQUAL(0, ptsname_r(master, name, 60));
    return master;
}

static void test_a_serial_device_is_raw_both_ways(void)
{
    static const uint8_t octets[] = {0x00, 0x03, 0x04, 0x0A, 0x0D, 0x11, 0x13, 0x1A, 0x7F, 0xFF};
    char name[64];
    uint8_t got[sizeof octets];
    bool lossless = true;
    const int far = terminal(name);
    const int near = transport_open(strcat(name, ":937500"), &lossless, why, sizeof why);
    TEST_ASSERT_TRUE_MESSAGE(near >= 0, why);
    TEST_ASSERT_FALSE(lossless);
    TEST_ASSERT_EQUAL(sizeof octets, write(near, octets, sizeof octets));
    TEST_ASSERT_EQUAL(sizeof octets, read(far, got, sizeof got));
    TEST_ASSERT_EQUAL_MEMORY(octets, got, sizeof octets);
    TEST_ASSERT_EQUAL(sizeof octets, write(far, octets, sizeof octets));
    TEST_ASSERT_EQUAL(sizeof octets, read(near, got, sizeof got));
    TEST_ASSERT_EQUAL_MEMORY(octets, got, sizeof octets);
    TEST_ASSERT_EQUAL_MESSAGE(-1, read(near, got, sizeof got), "it does not wait");
    close(near);
    close(far);
}

static void test_a_serial_device_is_taken_by_one_program_alone(void)
{
    char name[64];
    bool lossless;
    const int far = terminal(name);
    const int first = transport_open(name, &lossless, why, sizeof why);
    TEST_ASSERT_TRUE(first >= 0);
    TEST_ASSERT_EQUAL(-1, transport_open(name, &lossless, why, sizeof why));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why, "another program"), why);
    close(first);
    close(far);
}

static void test_what_is_not_a_serial_device_is_reported(void)
{
    bool lossless;
    TEST_ASSERT_EQUAL(-1, transport_open("/dev/null", &lossless, why, sizeof why));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why, "no serial device"), why);
    TEST_ASSERT_EQUAL(-1, transport_open("/dev/ttyUSB_none", &lossless, why, sizeof why));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why, "/dev/ttyUSB_none: No such file"), why);
}
