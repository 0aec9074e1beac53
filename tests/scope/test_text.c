/* The texts that the scope and its pages exchange. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/rig/rig.h"
#include "host_sim/scope/scope.h"
#include "host_sim/scope/scope_text.h"
#include "unity.h"

static char *text;
static size_t size;
static FILE *to;
static scope_values_t values;

void setUp(void)
{
    to = open_memstream(&text, &size);
    scope_values_init(&values);
}

void tearDown(void)
{
    fclose(to);
    free(text);
}

static const char *written(void)
{
    fflush(to);
    return text;
}

/* Base64 by the test vectors of RFC 4648, section 10. */
static void test_base64_is_that_of_the_standard(void)
{
    static const struct {
        const char *octets, *letters;
    } of[] = {{"", ""},
              {"f", "Zg=="},
              {"fo", "Zm8="},
              {"foo", "Zm9v"},
              {"foob", "Zm9vYg=="},
              {"fooba", "Zm9vYmE="},
              {"foobar", "Zm9vYmFy"}};
    for (size_t n = 0; n < sizeof of / sizeof of[0]; n++) {
        const size_t before = n == 0u ? 0u : strlen(written());
        scope_base64(to, (const uint8_t *)of[n].octets, strlen(of[n].octets));
        TEST_ASSERT_EQUAL_STRING(of[n].letters, written() + before);
    }
    const size_t before = strlen(written());
    const uint8_t high[] = {0xfb, 0xff, 0xfe};
    scope_base64(to, high, sizeof high);
    TEST_ASSERT_EQUAL_STRING("+//+", written() + before);
}

static void test_rows_have_ascending_ids_and_none_is_of_the_simulation(void)
{
    for (uint32_t n = 0; n < values.count; n++) {
        TEST_ASSERT_LESS_THAN_UINT32(3000u, values.rows[n]->id);
        TEST_ASSERT_TRUE(n == 0u || values.rows[n - 1u]->id < values.rows[n]->id);
        TEST_ASSERT_EQUAL_UINT32(n, scope_values_place(&values, values.rows[n]->id));
    }
    uint32_t wanted = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        for (uint32_t n = 0; n < rig_table(t)->count; n++) {
            wanted += rig_table(t)->rows[n].id < 3000u;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(wanted, values.count);
    TEST_ASSERT_LESS_THAN_UINT32(SCOPE_ROWS_MAX, values.count);
}

static uint32_t bits_of(float number)
{
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

static void put(const char *name, uint32_t bits)
{
    const uint32_t place = scope_values_place(&values, rig_row_by_name(name)->id);
    values.bits[place] = bits;
    values.known[place] = true;
    values.news[place] = true;
}

static void test_news_are_reported_once_and_all_on_demand(void)
{
    put("omega_m", bits_of(-1.5f));    /* 2032 */
    put("fault_reason", 0xffffffffu);  /* 2002; as int the value is -1 */
    put("sample_flags", 0xffffffffu);  /* 2044, an unsigned number */
    put("state", 2u);                  /* 2001 */
    put("u_dc", bits_of(1.0f / 0.0f)); /* 2024; JSON has no number for infinity */
    TEST_ASSERT_EQUAL_UINT32(5u, scope_values_text(to, &values, false));
    TEST_ASSERT_EQUAL_STRING("{\"2001\":2,\"2002\":-1,\"2024\":null,\"2032\":-1.5,\"2044\":4294967295}",
                             written());
    const size_t before = strlen(written());
    TEST_ASSERT_EQUAL_UINT32(0u, scope_values_text(to, &values, false));
    TEST_ASSERT_EQUAL_STRING("{}", written() + before);
    TEST_ASSERT_EQUAL_UINT32(5u, scope_values_text(to, &values, true));
}

static void test_rows_have_units_for_people(void)
{
    scope_rows_text(to, &values);
    /* 30/pi = 9.549296585... r/min per rad/s; only mechanical speeds have this factor. */
    const char *row = strstr(written(), "\"name\":\"omega_m\"");
    TEST_ASSERT_NOT_NULL(row);
    TEST_ASSERT_NOT_NULL(strstr(row, "\"unit\":\"rad/s\",\"shown\":\"r/min\",\"factor\":9.5492965"));
    row = strstr(written(), "\"name\":\"omega_e\"");
    TEST_ASSERT_EQUAL_PTR(strstr(row, "\"shown\":"), strstr(row, "\"shown\":\"rad/s\",\"factor\":1,"));
    row = strstr(written(), "\"name\":\"enable\"");
    TEST_ASSERT_EQUAL_PTR(strstr(row, "\"choices\":"),
                          strstr(row, "\"choices\":[\"off\",\"on\",\"quick_stop\"]"));
    row = strstr(written(), "\"name\":\"current_bandwidth\"");
    TEST_ASSERT_EQUAL_PTR(strstr(row, "\"min\":"), strstr(row, "\"min\":10,\"max\":3000,\"initial\":1000}"));
}

static void expect_read(const char *name, const char *given, double wanted)
{
    char why[700];
    double value = 0.0;
    TEST_ASSERT_TRUE_MESSAGE(scope_read(rig_row_by_name(name), given, &value, why, sizeof why), given);
    TEST_ASSERT_EQUAL_DOUBLE(wanted, value);
}

static void expect_refused(const char *name, const char *given, const char *fragment)
{
    char why[700] = "";
    double value = 0.0;
    TEST_ASSERT_FALSE_MESSAGE(scope_read(rig_row_by_name(name), given, &value, why, sizeof why), given);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why, fragment), why);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(why, name), why);
}

static void test_values_are_read_as_people_write_them(void)
{
    expect_read("speed_request", "60 r/min", 6.283185307179586);
    expect_read("speed_request", "-2.5", -2.5);
    expect_read("motor_inductance_d", "12.5 mH", 0.0125);
    expect_read("enable", "quick_stop", 2.0);
    expect_refused("enable", "maybe", "off|on|quick_stop");
    expect_refused("speed_request", "fast", "accepted");
    expect_refused("speed_request", "3 A", "accepted");
    expect_refused("speed_request", "", "accepted");
}

/* Calculated by hand. A sample of n floats is a frame of 4 + 5 + 4 n octets, a fill octet and a sum of two
 * octets, 10 bits each, on four fifths of the line. 8 signals at 937500 baud are 440 bits, 1704.5 samples
 * per second, every 6th period; one signal is 160 bits, 4687 samples per second, every 3rd period; 8
 * signals at 115200 baud are 209.5 samples per second, every 48th period. */
static void test_samples_are_as_many_as_the_line_allows(void)
{
    TEST_ASSERT_EQUAL_UINT32(1u, scope_every("tcp://127.0.0.1:5555", 8u));
    TEST_ASSERT_EQUAL_UINT32(6u, scope_every("/dev/ttyUSB0", 8u));
    TEST_ASSERT_EQUAL_UINT32(3u, scope_every("/dev/ttyUSB0", 1u));
    TEST_ASSERT_EQUAL_UINT32(48u, scope_every("/dev/ttyUSB0:115200", 8u));
    TEST_ASSERT_EQUAL_UINT32(255u, scope_every("/dev/ttyUSB0:1200", 8u));
}
