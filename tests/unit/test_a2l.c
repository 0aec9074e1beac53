/* Text that is read in windows, numbers as text, and the description of a small table. tests/line tests
 * that a calibration tool can read the whole description of the drive. */
#include "talk/a2l.h"

#include <stdlib.h>

#include "math/float_bits.h"
#include "tests/unit/compare.h"

static uint16_t octets[8192];
static char string[8192];

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

/* Tested over all exponents with the reader of the C library; the text never has more than nine digits. */
static void test_every_float_is_as_short_as_it_reads_back(void)
{
    uint32_t bits = 1u;
    for (uint32_t n = 0; n < 50000u; n++) {
        bits = bits * UINT32_C(1664525) + UINT32_C(1013904223);
        const float value = float_of_bits(bits & UINT32_C(0x7FFFFFFF));
        if ((bits >> 23 & 0xFFu) == 0xFFu) {
            continue; /* this bit pattern is no finite number */
        }
        const char *shortest = float_text(value);
        TEST_ASSERT_EQUAL_HEX32(float_bits(value), float_bits(strtof(shortest, NULL)));
        for (int digits = 1; digits < 9; digits++) { /* fewer digits must not be sufficient */
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

static void write_event(text_t *text)
{
    text_put(text, "isr_8kHz");
}

static const a2l_t a2l = {
    tables, 2u, UINT32_C(0x01234567), {125000u, 115200u, write_event}, {1u, 0x1cu, 0x0cu}};

/* The grammar by ASAM MCD-1 XCP 1.0, part 2: the blocks in their order, names and numbers of enumerations,
 * codes of commands. */
static const char expected_grammar[] =
    "ASAP2_VERSION 1 61\n"
    "/begin PROJECT lagless \"\"\n"
    "  /begin MODULE drive \"lagless drive\"\n"
    "    /begin A2ML\n"
    "block \"IF_DATA\" taggedunion if_data{\"XCP\" struct{taggedstruct{\n"
    "block \"PROTOCOL_LAYER\" struct{uint;uint;uint;uint;uint;uint;uint;uint;uchar;uint;\n"
    "enum{\"BYTE_ORDER_MSB_LAST\"=0,\"BYTE_ORDER_MSB_FIRST\"=1};\n"
    "enum{\"ADDRESS_GRANULARITY_BYTE\"=1,\"ADDRESS_GRANULARITY_WORD\"=2,\"ADDRESS_GRANULARITY_DWORD\"=4};\n"
    "taggedstruct{(\"OPTIONAL_CMD\" enum{"
    "\"GET_COMM_MODE_INFO\"=251,\"GET_ID\"=250,\"GET_SEED\"=248,\"UNLOCK\"=247,\"SET_MTA\"=246,\"UPLOAD\"="
    "245,\"SHORT_UPLOAD\"=244,"
    "\"BUILD_CHECKSUM\"=243,\"DOWNLOAD\"=240,\"SET_CAL_PAGE\"=235,\"GET_CAL_PAGE\"=234,"
    "\"GET_PAG_PROCESSOR_INFO\"=233,\"GET_SEGMENT_INFO\"=232,\"GET_PAGE_INFO\"=231,\"SET_DAQ_PTR\"=226,"
    "\"WRITE_DAQ\"=225,\"SET_DAQ_LIST_MODE\"=224,\"START_STOP_DAQ_LIST\"=222,\"START_STOP_SYNCH\"=221,"
    "\"GET_DAQ_CLOCK\"=220,\"GET_DAQ_PROCESSOR_INFO\"=218,\"GET_DAQ_RESOLUTION_INFO\"=217,"
    "\"GET_DAQ_EVENT_INFO\"=215,\"FREE_DAQ\"=214,\"ALLOC_DAQ\"=213,\"ALLOC_ODT\"=212,\"ALLOC_ODT_ENTRY\"=211"
    "})*;};};\n"
    "block \"SEGMENT\" struct{uchar;uchar;uchar;uchar;uchar;taggedstruct{\n"
    "block \"CHECKSUM\" struct{enum{\"XCP_CRC_32\"=9};taggedstruct{\"MAX_BLOCK_SIZE\" ulong;};};\n"
    "(block \"PAGE\" struct{uchar;\n"
    "enum{\"ECU_ACCESS_NOT_ALLOWED\"=0,\"ECU_ACCESS_WITHOUT_XCP_ONLY\"=1,\"ECU_ACCESS_WITH_XCP_ONLY\"=2,"
    "\"ECU_ACCESS_DONT_CARE\"=3};\n"
    "enum{\"XCP_READ_ACCESS_NOT_ALLOWED\"=0,\"XCP_READ_ACCESS_WITHOUT_ECU_ONLY\"=1,"
    "\"XCP_READ_ACCESS_WITH_ECU_ONLY\"=2,\"XCP_READ_ACCESS_DONT_CARE\"=3};\n"
    "enum{\"XCP_WRITE_ACCESS_NOT_ALLOWED\"=0,\"XCP_WRITE_ACCESS_WITHOUT_ECU_ONLY\"=1,"
    "\"XCP_WRITE_ACCESS_WITH_ECU_ONLY\"=2,\"XCP_WRITE_ACCESS_DONT_CARE\"=3};})*;};};\n"
    "block \"DAQ\" struct{enum{\"STATIC\"=0,\"DYNAMIC\"=1};uint;uint;uchar;\n"
    "enum{\"OPTIMISATION_TYPE_DEFAULT\"=0};enum{\"ADDRESS_EXTENSION_FREE\"=0};\n"
    "enum{\"IDENTIFICATION_FIELD_TYPE_ABSOLUTE\"=0};\n"
    "enum{\"GRANULARITY_ODT_ENTRY_SIZE_DAQ_DWORD\"=4};uchar;\n"
    "enum{\"NO_OVERLOAD_INDICATION\"=0,\"OVERLOAD_INDICATION_PID\"=1,\"OVERLOAD_INDICATION_EVENT\"=2};\n"
    "taggedstruct{\"PRESCALER_SUPPORTED\";\n"
    "block \"TIMESTAMP_SUPPORTED\" struct{uint;enum{\"SIZE_DWORD\"=4};\n"
    "enum{\"UNIT_1NS\"=0,\"UNIT_10NS\"=1,\"UNIT_100NS\"=2,\"UNIT_1US\"=3,\"UNIT_10US\"=4,\"UNIT_100US\"=5,"
    "\"UNIT_1MS\"=6,\"UNIT_10MS\"=7,\"UNIT_100MS\"=8,\"UNIT_1S\"=9};taggedstruct{\"TIMESTAMP_FIXED\";};};\n"
    "(block \"EVENT\" struct{char[101];char[9];uint;enum{\"DAQ\"=1,\"STIM\"=2,\"DAQ_STIM\"=3};"
    "uchar;uchar;uchar;uchar;})*;};};\n"
    "block \"XCP_ON_SxI\" struct{uint;ulong;taggedstruct{\"ASYNCH_FULL_DUPLEX_MODE\" struct{\n"
    "enum{\"PARITY_NONE\"=0,\"PARITY_ODD\"=1,\"PARITY_EVEN\"=2};enum{\"ONE_STOP_BIT\"=1,\"TWO_STOP_BITS\"=2};"
    "};};\n"
    "enum{\"HEADER_LEN_CTR_WORD\"=4};enum{\"NO_CHECKSUM\"=0,\"CHECKSUM_BYTE\"=1,"
    "\"CHECKSUM_WORD\"=2};};\n"
    "block \"XCP_ON_TCP_IP\" struct{uint;uint;taggedunion{\"HOST_NAME\" char[256];\"ADDRESS\" char[15];};};\n"
    "};};};\n"
    "    /end A2ML\n";

static const char expected_head[] =
    "    /begin MOD_PAR \"\" ADDR_EPK 0x0 EPK \"lagless-01234567\"\n"
    "      /begin MEMORY_SEGMENT params \"\" DATA RAM INTERN 0x0000001c 0x0000000c -1 -1 -1 -1 -1\n"
    "        /begin IF_DATA XCP /begin SEGMENT 0 2 1 0 0\n"
    "          /begin CHECKSUM XCP_CRC_32 MAX_BLOCK_SIZE 4096 /end CHECKSUM\n"
    "          /begin PAGE 0 ECU_ACCESS_DONT_CARE XCP_READ_ACCESS_DONT_CARE XCP_WRITE_ACCESS_NOT_ALLOWED "
    "/end PAGE\n"
    "          /begin PAGE 1 ECU_ACCESS_NOT_ALLOWED XCP_READ_ACCESS_DONT_CARE XCP_WRITE_ACCESS_DONT_CARE "
    "/end PAGE\n"
    "        /end SEGMENT /end IF_DATA\n"
    "      /end MEMORY_SEGMENT\n"
    "    /end MOD_PAR\n"
    "    /begin MOD_COMMON \"\" BYTE_ORDER MSB_LAST ALIGNMENT_BYTE 1 ALIGNMENT_WORD 2 ALIGNMENT_LONG 4 "
    "ALIGNMENT_FLOAT32_IEEE 4 /end MOD_COMMON\n"
    "    /begin RECORD_LAYOUT RL.FLOAT32_IEEE FNC_VALUES 1 FLOAT32_IEEE COLUMN_DIR DIRECT /end "
    "RECORD_LAYOUT\n"
    "    /begin RECORD_LAYOUT RL.SLONG FNC_VALUES 1 SLONG COLUMN_DIR DIRECT /end RECORD_LAYOUT\n"
    "    /begin RECORD_LAYOUT RL.ULONG FNC_VALUES 1 ULONG COLUMN_DIR DIRECT /end RECORD_LAYOUT\n";

/* The protocol by docs/serial.md: 64 and 128 octets, two lists, entries of 4 octets; 8 kHz are 125 us, one
 * octet. */
static const char expected_protocol[] =
    "    /begin IF_DATA XCP\n"
    "      /begin PROTOCOL_LAYER 0x0100 1000 1000 1000 1000 1000 1000 1 64 128 BYTE_ORDER_MSB_LAST "
    "ADDRESS_GRANULARITY_BYTE\n"
    "        OPTIONAL_CMD GET_COMM_MODE_INFO\n        OPTIONAL_CMD GET_ID\n"
    "        OPTIONAL_CMD GET_SEED\n        OPTIONAL_CMD UNLOCK\n        OPTIONAL_CMD SET_MTA\n"
    "        OPTIONAL_CMD UPLOAD\n        OPTIONAL_CMD SHORT_UPLOAD\n        OPTIONAL_CMD BUILD_CHECKSUM\n"
    "        OPTIONAL_CMD DOWNLOAD\n        OPTIONAL_CMD SET_CAL_PAGE\n        OPTIONAL_CMD GET_CAL_PAGE\n"
    "        OPTIONAL_CMD GET_PAG_PROCESSOR_INFO\n        OPTIONAL_CMD GET_SEGMENT_INFO\n"
    "        OPTIONAL_CMD GET_PAGE_INFO\n        OPTIONAL_CMD SET_DAQ_PTR\n        OPTIONAL_CMD WRITE_DAQ\n"
    "        OPTIONAL_CMD SET_DAQ_LIST_MODE\n        OPTIONAL_CMD START_STOP_DAQ_LIST\n"
    "        OPTIONAL_CMD START_STOP_SYNCH\n        OPTIONAL_CMD GET_DAQ_CLOCK\n"
    "        OPTIONAL_CMD GET_DAQ_PROCESSOR_INFO\n        OPTIONAL_CMD GET_DAQ_RESOLUTION_INFO\n"
    "        OPTIONAL_CMD GET_DAQ_EVENT_INFO\n        OPTIONAL_CMD FREE_DAQ\n        OPTIONAL_CMD ALLOC_DAQ\n"
    "        OPTIONAL_CMD ALLOC_ODT\n        OPTIONAL_CMD ALLOC_ODT_ENTRY\n"
    "      /end PROTOCOL_LAYER\n"
    "      /begin DAQ DYNAMIC 2 1 0 OPTIMISATION_TYPE_DEFAULT ADDRESS_EXTENSION_FREE "
    "IDENTIFICATION_FIELD_TYPE_ABSOLUTE GRANULARITY_ODT_ENTRY_SIZE_DAQ_DWORD 4 OVERLOAD_INDICATION_EVENT "
    "PRESCALER_SUPPORTED\n"
    "        /begin TIMESTAMP_SUPPORTED 125 SIZE_DWORD UNIT_1US TIMESTAMP_FIXED /end TIMESTAMP_SUPPORTED\n"
    "        /begin EVENT \"isr_8kHz\" \"isr\" 0 DAQ 2 125 3 255 /end EVENT\n"
    "      /end DAQ\n";
static const char expected_serial[] = "      /begin XCP_ON_SxI 0x0100 115200 ASYNCH_FULL_DUPLEX_MODE "
                                      "PARITY_NONE ONE_STOP_BIT HEADER_LEN_CTR_WORD "
                                      "CHECKSUM_WORD /end XCP_ON_SxI\n";
static const char expected_tcp[] =
    "      /begin XCP_ON_TCP_IP 0x0100 5555 ADDRESS \"127.0.0.1\" /end XCP_ON_TCP_IP\n"
    "    /end IF_DATA\n";

static const char expected_rows[] =
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

static char expected[8192]; /* the whole text, because standard C has no literals of this length */

static const char *whole(const char *serial)
{
    snprintf(expected, sizeof expected, "%s%s%s%s%s%s", expected_grammar, expected_head, expected_protocol,
             serial, expected_tcp, expected_rows);
    return expected;
}

static void test_every_row_is_described(void)
{
    a2l_place_t place = {0u, 0u};
    text_t text = text_window(0u, sizeof octets / sizeof octets[0], octets);
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_STRING(whole(expected_serial), string_of(&text));
}

static void test_a_board_without_a_serial_line_is_reached_by_tcp_alone(void)
{
    a2l_t without = a2l;
    without.line.baud = 0u;
    a2l_place_t place = {0u, 0u};
    text_t text = text_window(0u, sizeof octets / sizeof octets[0], octets);
    a2l_write(&without, &place, &text);
    TEST_ASSERT_EQUAL_STRING(whole(""), string_of(&text));
}

static void test_any_window_shows_its_part_of_the_whole(void)
{
    const uint32_t length = (uint32_t)strlen(whole(expected_serial));
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
    const uint32_t length = (uint32_t)strlen(whole(expected_serial));
    a2l_place_t place = {0u, 0u};
    text_t text = text_window(UINT32_MAX, 0u, octets);
    octets[0] = 0xFFFFu;
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_UINT32(length, text.at);
    text = text_window(length, 63u, octets);
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_UINT32(length, text.at);
    text = text_window(UINT32_MAX - 10u, 63u, octets); /* the end of this window would exceed 32 bits */
    a2l_write(&a2l, &place, &text);
    TEST_ASSERT_EQUAL_HEX16(0xFFFF, octets[0]);
}
