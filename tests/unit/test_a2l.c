/* Text by windows, numbers as text, and the description of a small table. That a calibration tool reads the
 * whole of the drive's is for tests/line. */
#include "talk/a2l.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unity.h>

#include "math/float_bits.h"

static uint16_t octets[4096];
static char string[4096];

void setUp(void)
{
}

void tearDown(void)
{
}

static const char *string_of(const text_t *text)
{
    for (uint32_t n = 0; n < text->at; n++) {
        string[n] = (char)octets[n];
    }
    string[text->at] = '\0';
    return string;
}

static const char *float_text(float value)
{
    text_t text = text_window(0u, 4000u, octets);
    text_float(&text, value);
    return string_of(&text);
}

static void test_floats_read_back_as_they_were(void)
{
    static const struct {
        float value;
        const char *text;
    } cases[] = {
        {0.0f, "0"},
        {1.0f, "1"},
        {-1.0f, "-1"},
        {0.1f, "0.1"},
        {220.0f, "220"},
        {1e-5f, "1e-5"},
        {12.5e-3f, "0.0125"},
        {0.95f, "0.95"},
        {1e4f, "10000"},
        {16777216.0f, "16777216"},
        {1e10f, "1e10"},
        {3.1415927f, "3.1415927"},
        {-0.001f, "-0.001"},
        {1e-7f, "1e-7"},
        {3.4028235e38f, "3.4028235e38"},
        {1.17549435e-38f, "1.1754944e-38"},
        {1e-45f, "1e-45"},
        {123456.7f, "123456.7"},
    };
    for (uint32_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        TEST_ASSERT_EQUAL_STRING(cases[n].text, float_text(cases[n].value));
    }
}

/* Over all exponents, against the C library's reader; and never longer than its nine digits. */
static void test_every_float_is_as_short_as_it_reads_back(void)
{
    uint32_t bits = 1u;
    for (uint32_t n = 0; n < 50000u; n++) {
        bits = bits * UINT32_C(1664525) + UINT32_C(1013904223);
        const float value = float_of_bits(bits & UINT32_C(0x7FFFFFFF));
        if ((bits >> 23 & 0xFFu) == 0xFFu) {
            continue; /* not finite */
        }
        const char *shortest = float_text(value);
        TEST_ASSERT_EQUAL_HEX32(float_bits(value), float_bits(strtof(shortest, NULL)));
        for (int digits = 1; digits < 9; digits++) { /* no shorter one would do */
            char shorter[32];
            uint32_t length = 0u;
            for (const char *c = shortest; *c != '\0' && *c != 'e'; c++) {
                length += *c >= '1' && *c <= '9' ? 1u : length > 0u && *c == '0' ? 1u : 0u;
            }
            snprintf(shorter, sizeof shorter, "%.*e", digits - 1, (double)value);
            if (float_bits(strtof(shorter, NULL)) == float_bits(value)) {
                break;
            }
            TEST_ASSERT_TRUE_MESSAGE(strchr(shortest, 'e') == NULL || length > (uint32_t)digits, shortest);
        }
    }
}

static void test_whole_numbers_and_hex(void)
{
    text_t text = text_window(0u, 4000u, octets);
    text_whole(&text, INT64_MIN);
    text_put_octet(&text, ' ');
    text_whole(&text, 4294967295);
    text_put_octet(&text, ' ');
    text_whole(&text, 0);
    text_put_octet(&text, ' ');
    text_hex(&text, UINT32_C(0x00C0FFEE), 8u);
    TEST_ASSERT_EQUAL_STRING("-9223372036854775808 4294967295 0 00c0ffee", string_of(&text));
}

static void test_quotes_are_escaped(void)
{
    text_t text = text_window(0u, 4000u, octets);
    text_quoted(&text, "a \"b\" \\ c");
    TEST_ASSERT_EQUAL_STRING("\"a \\\"b\\\" \\\\ c\"", string_of(&text));
}

/* ---- the file ---- */

static const table_row_t set_rows[] = {
    {7, SLOT_FLOAT, TABLE_LIVE, 0, "gain", "1/s", "how fast", "", 1.0f, 1e-3f, 2.5f, {0, 0, 0}},
    {8, SLOT_INT, TABLE_OFF, 4, "pairs", "-", "how many", "", 0.0f, 0.0f, 0.0f, {4, -1, 64}},
    {9, SLOT_ENUM, TABLE_LIVE, 8, "way", "-", "which", "left|right", 0.0f, 0.0f, 0.0f, {1, 0, 0}},
};
static const table_row_t shown_rows[] = {
    {2000, SLOT_UINT, TABLE_READ, 0, "period", "periods", "clock", "", 0.0f, 0.0f, 0.0f, {0, 0, 0}},
    {2001, SLOT_FLOAT, TABLE_READ, 4, "i_a", "A", "current", "", 0.0f, 0.0f, 0.0f, {0, 0, 0}},
};
static const table_t set = {"params", set_rows, 3u};
static const table_t shown = {"signals", shown_rows, 2u};
static const a2l_table_t tables[] = {{&shown, 0u}, {&set, 1u}};
static const a2l_t a2l = {tables, 2u, UINT32_C(0x01234567)};

static const char expected[] =
    "ASAP2_VERSION 1 61\n"
    "/begin PROJECT lagless \"\"\n"
    "  /begin MODULE drive \"lagless drive\"\n"
    "    /begin MOD_PAR \"\" ADDR_EPK 0x0 EPK \"lagless-01234567\" /end MOD_PAR\n"
    "    /begin MOD_COMMON \"\" BYTE_ORDER MSB_LAST ALIGNMENT_BYTE 1 ALIGNMENT_WORD 2 ALIGNMENT_LONG 4 "
    "ALIGNMENT_FLOAT32_IEEE 4 /end MOD_COMMON\n"
    "    /begin RECORD_LAYOUT RL.FLOAT32_IEEE FNC_VALUES 1 FLOAT32_IEEE COLUMN_DIR DIRECT /end "
    "RECORD_LAYOUT\n"
    "    /begin RECORD_LAYOUT RL.SLONG FNC_VALUES 1 SLONG COLUMN_DIR DIRECT /end RECORD_LAYOUT\n"
    "    /begin RECORD_LAYOUT RL.ULONG FNC_VALUES 1 ULONG COLUMN_DIR DIRECT /end RECORD_LAYOUT\n"
    "    /begin MEASUREMENT period \"clock\" ULONG NO_COMPU_METHOD 0 0 0 4294967295 ECU_ADDRESS 0x00001f40 "
    "ECU_ADDRESS_EXTENSION 0 PHYS_UNIT \"periods\" /end MEASUREMENT\n"
    "    /begin MEASUREMENT i_a \"current\" FLOAT32_IEEE NO_COMPU_METHOD 0 0 -3.4028235e38 3.4028235e38 "
    "ECU_ADDRESS 0x00001f44 ECU_ADDRESS_EXTENSION 0 PHYS_UNIT \"A\" /end MEASUREMENT\n"
    "    /begin GROUP signals \"\" ROOT /begin REF_MEASUREMENT\n      period i_a /end REF_MEASUREMENT /end "
    "GROUP\n"
    "    /begin CHARACTERISTIC gain \"how fast\" VALUE 0x0000001c RL.FLOAT32_IEEE 0 NO_COMPU_METHOD 0.001 "
    "2.5 "
    "ECU_ADDRESS_EXTENSION 1 PHYS_UNIT \"1/s\" /end CHARACTERISTIC\n"
    "    /begin CHARACTERISTIC pairs \"how many\" VALUE 0x00000020 RL.SLONG 0 NO_COMPU_METHOD -1 64 "
    "ECU_ADDRESS_EXTENSION 1 PHYS_UNIT \"-\" /end CHARACTERISTIC\n"
    "    /begin COMPU_METHOD CM.way \"\" TAB_VERB \"%.0\" \"\" COMPU_TAB_REF CT.way /end COMPU_METHOD\n"
    "    /begin COMPU_VTAB CT.way \"\" TAB_VERB 2 0 \"left\" 1 \"right\" /end COMPU_VTAB\n"
    "    /begin CHARACTERISTIC way \"which\" VALUE 0x00000024 RL.SLONG 0 CM.way 0 1 ECU_ADDRESS_EXTENSION 1 "
    "PHYS_UNIT \"-\" /end CHARACTERISTIC\n"
    "    /begin GROUP params \"\" ROOT /begin REF_CHARACTERISTIC\n      gain pairs way /end "
    "REF_CHARACTERISTIC "
    "/end GROUP\n"
    "  /end MODULE\n"
    "/end PROJECT\n";

static void test_every_row_is_described(void)
{
    a2l_place_t place = {0u, 0u};
    text_t text = text_window(0u, sizeof octets / sizeof octets[0], octets);
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_STRING(expected, string_of(&text));
}

/* In pieces of any size, one behind the other or from any place, it is the same file. */
static void test_any_window_shows_its_part_of_the_whole(void)
{
    const uint32_t length = (uint32_t)(sizeof expected - 1u);
    a2l_place_t place = {0u, 0u};
    for (uint32_t piece = 1u; piece <= 63u; piece += 31u) {
        for (uint32_t n = 0; n < length; n += piece) {
            const uint32_t from = piece == 32u ? (n * 1237u) % length : n;
            memset(octets, 0xFF, sizeof octets);
            text_t text = text_window(from, piece, octets);
            a2l_write(&a2l, &place, &text);
            TEST_ASSERT_TRUE(text.at >= from + piece || text.at == length);
            TEST_ASSERT_TRUE(place.at <= from);
            for (uint32_t m = 0; m < piece && from + m < length; m++) {
                TEST_ASSERT_EQUAL_HEX16((uint16_t)expected[from + m], octets[m]);
            }
            TEST_ASSERT_EQUAL_HEX16(0xFFFF, octets[piece]);
        }
    }
}

static void test_beyond_its_end_nothing_is_written_and_all_is_counted(void)
{
    a2l_place_t place = {0u, 0u};
    text_t text = text_window(UINT32_MAX, 0u, octets);
    octets[0] = 0xFFFFu;
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_UINT32(sizeof expected - 1u, text.at);
    text = text_window(sizeof expected - 1u, 63u, octets);
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_UINT32(sizeof expected - 1u, text.at);
    text = text_window(UINT32_MAX - 10u, 63u, octets); /* its end would wrap */
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_HEX16(0xFFFF, octets[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_floats_read_back_as_they_were);
    RUN_TEST(test_every_float_is_as_short_as_it_reads_back);
    RUN_TEST(test_whole_numbers_and_hex);
    RUN_TEST(test_quotes_are_escaped);
    RUN_TEST(test_every_row_is_described);
    RUN_TEST(test_any_window_shows_its_part_of_the_whole);
    RUN_TEST(test_beyond_its_end_nothing_is_written_and_all_is_counted);
    return UNITY_END();
}
