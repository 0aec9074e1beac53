/* The slave octet by octet: commands and answers as the standard (ASAM MCD-1 XCP 1.x, "Command reference")
 * defines them. The addresses lead to a memory of this file: extension 1 has slots 1 to 8, which accept
 * any value but 0xDEADDEAD; extension 0 cannot be written; extensions 5 and 6 have texts. */
#include "contract/line.h"
#include "talk/xcp.h"

#include "tests/unit/compare.h"
#include <stdlib.h>

#define SLOTS 9u /* slot 0 does not exist */

static xcp_t xcp;
static daq_t daq;
static uint16_t answer[FRAME_MAX_CTO];
static uint32_t length;

static uint32_t memory[SLOTS];
static uint32_t applied_memory[SLOTS];
static bool set_is_bad;
static uint32_t clock_now;
static uint32_t key; /* 0: no key is needed */

/* The text of an extension; NULL if it has none. */
static const char *text_of(uint32_t extension)
{
    return extension == XCP_EXTENSION_A2L     ? "a file to upload, 33 octets of it"
           : extension == XCP_EXTENSION_EPK   ? "lagless-01234567"
           : extension == XCP_EXTENSION_EVENT ? "isr_10kHz"
                                              : NULL;
}

static uint32_t text_length(uint32_t extension)
{
    return (uint32_t)strlen(text_of(extension));
}

static uint32_t read_memory(uint32_t extension, uint32_t address, uint32_t count, uint16_t *octets)
{
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t at = address + n;
        if (text_of(extension) != NULL) {
            if (at >= text_length(extension)) {
                return XCP_OUT_OF_RANGE;
            }
            octets[n] = (uint16_t)text_of(extension)[at];
        } else if (extension > 1u || at < 4u || at >= 4u * SLOTS) {
            return XCP_OUT_OF_RANGE;
        } else {
            octets[n] = (uint16_t)(memory[at / 4u] >> 8u * (at % 4u) & 0xFFu);
        }
    }
    return XCP_OK;
}

static uint32_t write_memory(uint32_t extension, uint32_t address, uint32_t count, const uint32_t *slots)
{
    if (extension == 0u) {
        return XCP_WRITE_PROTECTED;
    }
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t slot = address / 4u + n;
        if (extension != 1u || slot == 0u || slot >= SLOTS || slots[n] == UINT32_C(0xDEADDEAD)) {
            return XCP_OUT_OF_RANGE;
        }
    }
    memcpy(&memory[address / 4u], slots, count * sizeof *slots);
    return XCP_OK;
}

static bool writable(uint32_t extension)
{
    return extension == 1u;
}

static bool none_coded(uint32_t extension, uint32_t address, uint32_t count, const uint32_t *slots)
{
    (void)extension;
    (void)address;
    (void)count;
    (void)slots;
    return false;
}

/* Returns true if this write sets slot 1 to this value, and nothing else. */
static bool stops(uint32_t extension, uint32_t address, uint32_t slot)
{
    return extension == 1u && address == 4u && slot == UINT32_C(0x57099057);
}

static uint32_t measurable(uint32_t extension, uint32_t address, uint32_t *offset)
{
    if (extension != 0u || address % 4u != 0u || address < 4u || address >= 4u * SLOTS) {
        return XCP_OUT_OF_RANGE;
    }
    *offset = address / 4u * (uint32_t)sizeof memory[0];
    return XCP_OK;
}

static xcp_segment_t segment(void)
{
    return (xcp_segment_t){1u, 4u, 4u * (SLOTS - 1u)};
}

static uint32_t apply(void)
{
    if (set_is_bad) {
        return XCP_OUT_OF_RANGE;
    }
    memcpy(applied_memory, memory, sizeof memory);
    return XCP_OK;
}

static bool applied(void)
{
    return memcmp(applied_memory, memory, sizeof memory) == 0;
}

static uint32_t clock_of_drive(void)
{
    return clock_now;
}

static uint32_t key_of_drive(void)
{
    return key;
}

static xcp_access_t access = {
    .read = read_memory,
    .write = write_memory,
    .writable = writable,
    .coded = none_coded,
    .stops = stops,
    .measurable = measurable,
    .text_length = text_length,
    .segment = segment,
    .apply = apply,
    .applied = applied,
    .clock = clock_of_drive,
    .key = key_of_drive,
    .period = 100000u,
};

/* ---- octets ---- */

/* The octets in a text: hexadecimal numbers, and letters between quotes. */
static uint32_t octets_of(const char *text, uint16_t *octets)
{
    uint32_t count = 0u;
    for (bool letters = false; *text != '\0';) {
        TEST_ASSERT_TRUE(count < FRAME_MAX_DTO);
        if (*text == '\'') {
            letters = !letters;
            text++;
        } else if (letters) {
            octets[count++] = (uint16_t)*text++;
        } else if (*text == ' ') {
            text++;
        } else {
            char *end;
            octets[count++] = (uint16_t)strtoul(text, &end, 16);
            text = end;
        }
    }
    return count;
}

static void expect(const char *text, const uint16_t *octets, uint32_t count)
{
    uint16_t expected[FRAME_MAX_DTO];
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(octets_of(text, expected), count, text);
    if (count > 0u) {
        TEST_ASSERT_EQUAL_HEX16_ARRAY_MESSAGE(expected, octets, count, text);
    }
}

static void send(const uint16_t *octets, uint32_t count)
{
    memset(answer, 0x55, sizeof answer);
    length = xcp_command(&xcp, &daq, &access, (frame_packet_t){octets, count}, answer);
}

static void ask(const char *command, const char *expected)
{
    uint16_t octets[FRAME_MAX_DTO];
    send(octets, octets_of(command, octets));
    expect(expected, answer, length);
}

/* Sends commands whose answers are not compared. */
static void prepare(const char *commands)
{
    char command[80];
    for (size_t count; *commands != '\0'; commands += count + strspn(commands + count, ", ")) {
        count = strcspn(commands, ",");
        TEST_ASSERT_TRUE(count < sizeof command);
        memcpy(command, commands, count);
        command[count] = '\0';
        ask(command, "FF");
    }
}

/* RESOURCE is CAL/PAG and DAQ. COMM_MODE_BASIC is Intel order, BYTE, no block mode, with
 * GET_COMM_MODE_INFO. MAX_CTO is 64, MAX_DTO 128, both versions are 1. */
#define CONNECTED "FF 05 80 40 80 00 01 01"

void setUp(void)
{
    memset(&xcp, 0x55, sizeof xcp);
    memset(&daq, 0, sizeof daq);
    xcp_init(&xcp, 0u);
    daq_clear(&daq);
    for (uint32_t n = 0; n < SLOTS; n++) {
        memory[n] = UINT32_C(0x03020100) + UINT32_C(0x04040404) * n;
        applied_memory[n] = memory[n];
    }
    set_is_bad = false;
    clock_now = UINT32_C(0x12345678);
    access.period = 100000u;
    key = 0u;
    ask("FF 00", CONNECTED);
}

/* ---- session ---- */

static void test_without_a_connection_only_connect_is_answered(void)
{
    ask("FE", "FF");
    for (uint16_t code = 0u; code < 0xFFu; code++) {
        send((const uint16_t[8]){code}, 8u);
        TEST_ASSERT_EQUAL_UINT32(0u, length);
    }
    ask("FF 00", CONNECTED);
}

/* Allocates a list of one ODT of one entry, and sets the pointer to this entry. */
#define ONE_LIST "D5 00 01 00, D4 00 00 00 01, D3 00 00 00 00 01, E2 00 00 00 00 00"

static void test_a_new_connection_begins_again(void)
{
    prepare(ONE_LIST ", E1 FF 04 00 04 00 00 00");
    ask("DE 01 00 00", "FF 00");
    prepare("EB 02 00 00");
    ask("FD", "FF 40 00 00 00 00"); /* the status is DAQ_RUNNING */
    ask("FF 00", CONNECTED);
    ask("FD", "FF 00 00 00 00 00");
    ask("EA 02 00", "FF 00 00 01"); /* the client selects the staged page again */
    TEST_ASSERT_EQUAL_UINT32(0u, daq.lists);
}

/* SYNCH is answered by its error code, GET_COMM_MODE_INFO by octets. */
static void test_unknown_commands_are_reported(void)
{
    ask("FC", "FE 00");
    ask("FB", "FF 00 00 00 00 00 00 10");
    static const uint16_t unknown[] = {0xF2, 0xF1, 0xEF, 0xEE, 0xED, 0xEC, 0xE6, 0xE3,
                                       0xDF, 0xDB, 0xD8, 0xD2, 0xC7, 0xC0, 0x80, 0x00};
    for (uint32_t n = 0; n < sizeof unknown / sizeof unknown[0]; n++) {
        send((const uint16_t[8]){unknown[n]}, 8u);
        expect("FE 20", answer, length);
    }
}

/* The number of octets that a command needs at least; one octet fewer is a syntax error. */
static void test_short_commands_are_reported(void)
{
    static const struct {
        uint16_t code;
        uint32_t octets;
    } needs[] = {{0xFF, 2}, {0xFA, 2}, {0xF8, 3}, {0xF7, 2}, {0xF6, 8}, {0xF5, 2}, {0xF4, 8}, {0xF3, 8},
                 {0xF0, 2}, {0xEB, 4}, {0xEA, 3}, {0xE8, 5}, {0xE7, 4}, {0xE2, 6}, {0xE1, 8}, {0xE0, 8},
                 {0xDE, 4}, {0xDD, 2}, {0xD7, 4}, {0xD5, 4}, {0xD4, 5}, {0xD3, 6}};
    for (uint32_t n = 0; n < sizeof needs / sizeof needs[0]; n++) {
        for (uint32_t octets = 1u; octets < needs[n].octets; octets++) {
            const uint16_t command[8] = {needs[n].code, 1};
            send(command, octets);
            expect("FE 21", answer, length);
        }
    }
}

/* ---- seed and key ---- */

static void connect_locked(void)
{
    key = 4711u;
    ask("FF 00", "FF 05 80 40 80 00 01 01");
    ask("FD", "FF 00 01 00 00 00");
}

/* The octets of the seed for CAL/PAG. */
static uint32_t seed_of_drive(void)
{
    send((const uint16_t[]){0xF8, 0u, 1u}, 3u);
    TEST_ASSERT_EQUAL_UINT32(6u, length);
    TEST_ASSERT_EQUAL_HEX16(0xFF, answer[0]);
    TEST_ASSERT_EQUAL_HEX16(4u, answer[1]);
    return (uint32_t)answer[2] | (uint32_t)answer[3] << 8 | (uint32_t)answer[4] << 16 |
           (uint32_t)answer[5] << 24;
}

static void answer_seed(uint32_t reply, const char *expected)
{
    const uint16_t unlock[] = {0xF7,
                               4u,
                               (uint16_t)(reply & 0xFFu),
                               (uint16_t)(reply >> 8 & 0xFFu),
                               (uint16_t)(reply >> 16 & 0xFFu),
                               (uint16_t)(reply >> 24)};
    send(unlock, 6u);
    expect(expected, answer, length);
}

/* The expected answer was computed by another program that follows the text of docs/serial.md. */
static void test_the_answer_to_a_seed_is_that_of_the_guide(void)
{
    static const struct {
        uint32_t seed, key, reply;
    } cases[] = {{UINT32_C(0x00000000), UINT32_C(1), UINT32_C(0x8F281456)},
                 {UINT32_C(0x12345678), UINT32_C(999999), UINT32_C(0xD5F2AE9C)},
                 {UINT32_C(0xFFFFFFFF), UINT32_C(4711), UINT32_C(0x20D4B002)},
                 {UINT32_C(0x00000001), UINT32_C(4711), UINT32_C(0xCDE9A026)}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        TEST_ASSERT_EQUAL_HEX32(cases[n].reply, line_unlocks(cases[n].seed, cases[n].key));
    }
}

static void test_without_a_key_the_seed_is_empty_and_nothing_is_locked(void)
{
    ask("FD", "FF 00 00 00 00 00");
    ask("F8 00 01", "FF 00");
    ask("F7 04 01 02 03 04", "FF 00");
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F0 04 78 56 34 12", "FF");
    TEST_ASSERT_EQUAL_HEX32(0x12345678u, memory[1]);
}

static void test_a_locked_slave_is_read_and_measured_but_not_written(void)
{
    uint32_t before[SLOTS];
    memcpy(before, memory, sizeof memory);
    connect_locked();
    ask("F4 04 00 01 04 00 00 00", "FF 04 05 06 07");
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F5 04", "FF 04 05 06 07");
    ask("EB 02 00 00", "FF"); /* the page that is read */
    ask("D5 00 01 00", "FF");
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F0 04 78 56 34 12", "FE 25");
    ask("F0 08 78 56 34 12 78 56 34 12", "FE 25");
    ask("EB 01 00 00", "FE 25");
    ask("EB 83 00 00", "FE 25");
    TEST_ASSERT_EQUAL_HEX32_ARRAY(before, memory, SLOTS);
}

static void test_a_locked_slave_takes_a_stop_and_nothing_beside_it(void)
{
    connect_locked();
    ask("F6 00 00 01 08 00 00 00", "FF");
    ask("F0 04 57 90 09 57", "FE 25"); /* another slot */
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F0 04 57 90 09 56", "FE 25");
    ask("F0 08 57 90 09 57 57 90 09 57", "FE 25"); /* with a second slot */
    ask("F0 04 57 90 09", "FE 25");
    ask("F0 04 57 90 09 57", "FF");
    TEST_ASSERT_EQUAL_HEX32(0x57099057u, memory[1]);
    ask("F0 04 57 90 09 57", "FE 25"); /* the address points after it */
}

static void test_the_right_answer_opens_the_session_and_no_other_one(void)
{
    connect_locked();
    answer_seed(line_unlocks(seed_of_drive(), key), "FF 00");
    ask("FD", "FF 00 00 00 00 00");
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F0 04 78 56 34 12", "FF");
    TEST_ASSERT_EQUAL_HEX32(0x12345678u, memory[1]);
    ask("EB 01 00 00", "FF");
    answer_seed(0u, "FF 00"); /* repeated as if its answer had been lost */
    ask("FF 00", CONNECTED);
    ask("FD", "FF 00 01 00 00 00");
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F0 04 00 00 00 00", "FE 25");
    TEST_ASSERT_EQUAL_HEX32(0x12345678u, memory[1]);
}

static void test_a_wrong_answer_ends_the_session(void)
{
    for (uint32_t bit = 0; bit < 32u; bit++) {
        connect_locked();
        answer_seed(line_unlocks(seed_of_drive(), key) ^ UINT32_C(1) << bit, "FE 25");
        ask("FD", "");
    }
    connect_locked();
    (void)seed_of_drive();
    ask("F7 02 00 00", "FE 25"); /* the length is wrong */
    ask("FD", "");
}

static void test_a_seed_is_good_for_one_answer(void)
{
    connect_locked();
    answer_seed(0u, "FE 29"); /* no seed was requested */
    const uint32_t first = seed_of_drive();
    const uint32_t second = seed_of_drive(); /* the seed at the same time */
    TEST_ASSERT_TRUE(first != second);
    answer_seed(line_unlocks(first, key), "FE 25");
    connect_locked();
    answer_seed(line_unlocks(second, key), "FE 29");
}

static void test_other_resources_are_open_and_a_seed_comes_in_one_piece(void)
{
    connect_locked();
    ask("F8 00 04", "FF 00"); /* DAQ needs no key: the seed is empty */
    ask("F8 01 00", "FE 29");
    ask("F8 00 00", "FE 22");
    ask("F8 00 05", "FE 22");
}

/* In mode 1 the text is part of the answer; in mode 0 it is uploaded from the transfer address. */
static void test_identification(void)
{
    ask("FA 00", "FF 01 00 00 07 00 00 00 'lagless'");
    ask("FA 01", "FF 01 00 00 07 00 00 00 'lagless'");
    ask("FA 04", "FF 00 00 00 21 00 00 00");
    ask("F5 06", "FF 'a file'");
    ask("F5 03", "FF ' to'");
    ask("FA 05", "FF 00 00 00 10 00 00 00");
    ask("F5 08", "FF 'lagless-'");
    ask("FA 02", "FF 00 00 00 00 00 00 00"); /* this type does not exist */
    ask("FA C8", "FF 00 00 00 00 00 00 00");
}

/* ---- memory ---- */

static void test_uploads_go_on_where_the_last_one_ended(void)
{
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F5 04", "FF 04 05 06 07");
    ask("F5 06", "FF 08 09 0A 0B 0C 0D");
    ask("F5 01", "FF 0E");
    ask("F4 04 00 01 08 00 00 00", "FF 08 09 0A 0B");
    ask("F5 04", "FF 0C 0D 0E 0F");             /* the transfer address points after these octets */
    ask("F4 02 00 00 07 00 00 00", "FF 07 08"); /* from the middle of a slot */
}

static void test_what_is_not_there_is_out_of_range(void)
{
    ask("F4 04 00 01 00 00 00 00", "FE 22");
    ask("F4 04 00 01 24 00 00 00", "FE 22");
    ask("F4 04 00 01 04 01 00 00", "FE 22");
    ask("F4 04 00 01 04 00 00 80", "FE 22");
    ask("F4 04 00 02 04 00 00 00", "FE 22");
    ask("F4 04 00 FF 04 00 00 00", "FE 22");
    ask("F4 05 00 01 20 00 00 00", "FE 22"); /* begins within the range and ends outside */
    ask("F4 00 00 01 04 00 00 00", "FE 22");
    ask("F4 40 00 01 04 00 00 00", "FE 22"); /* one octet more than an answer can hold */
}

static void test_download_writes_slots(void)
{
    ask("F6 00 00 01 08 00 00 00", "FF");
    ask("F0 08 11 22 33 44 55 66 77 88", "FF");
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x44332211), memory[2]);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x88776655), memory[3]);
    ask("F0 04 01 00 00 00", "FF"); /* the address is incremented */
    TEST_ASSERT_EQUAL_HEX32(1u, memory[4]);
}

static void test_a_refused_download_changes_nothing(void)
{
    uint32_t before[SLOTS];
    memcpy(before, memory, sizeof memory);
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F0 08 01 00 00 00 AD DE AD DE", "FE 22"); /* the second of two values */
    ask("F0 02 01 00", "FE 22");                   /* half of a slot */
    ask("F0 00", "FE 22");
    ask("F0 04 01 00 00", "FE 21"); /* an octet is missing */
    ask("F0 3F 01 00 00", "FE 21"); /* more than a command can hold */
    ask("F0 FF 01 00 00", "FE 21");
    ask("F6 00 00 01 05 00 00 00", "FF"); /* parts of two slots */
    ask("F0 04 01 00 00 00", "FE 22");
    ask("F6 00 00 00 04 00 00 00", "FF"); /* a signal */
    ask("F0 04 01 00 00 00", "FE 23");
    ask("F6 00 00 09 04 00 00 00", "FF"); /* no slot exists there */
    ask("F0 04 01 00 00 00", "FE 22");
    TEST_ASSERT_EQUAL_HEX32_ARRAY(before, memory, SLOTS);
}

/* CRC-32 of IEEE 802.3 over 04h, 05h, ... 0Fh, by Python's zlib.crc32(bytes(range(4, 16))): 0xBCFF1C39. */
static void test_checksum_of_a_block(void)
{
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F3 00 00 00 0C 00 00 00", "FF 09 00 00 39 1C FF BC");
    ask("F5 01", "FF 10"); /* the address points after the block */
    ask("F6 00 00 01 04 00 00 00", "FF");
    ask("F3 00 00 00 00 00 00 00", "FE 22");
    ask("F3 00 00 00 0D 00 00 00", "FE 22");
    ask("F3 00 00 00 00 00 00 80", "FE 22 00 00 00 10 00 00"); /* the largest block is 1000h octets */
    ask("F3 00 00 00 01 10 00 00", "FE 22 00 00 00 10 00 00");
    ask("F3 00 00 00 00 10 00 00", "FE 22"); /* the block ends beyond the range */
}

/* ---- pages ---- */

static void test_setting_the_drives_page_applies_the_staged_set(void)
{
    ask("EA 01 00", "FF 00 00 00");
    memory[3] = 77u;
    ask("EA 01 00", "FF 00 00 01");
    set_is_bad = true;
    ask("EB 01 00 00", "FE 22");
    ask("EA 01 00", "FF 00 00 01");
    set_is_bad = false;
    ask("EB 01 00 00", "FF");
    TEST_ASSERT_EQUAL_UINT32(77u, applied_memory[3]);
    ask("EA 01 00", "FF 00 00 00");
}

static void test_pages_that_there_are_not(void)
{
    ask("EB 01 00 01", "FE 26"); /* the drive cannot run on the staged page */
    ask("EB 02 00 02", "FE 26");
    ask("EB 00 00 00", "FE 27");
    ask("EB 01 01 00", "FE 28");
    ask("EB 81 07 00", "FF"); /* for all segments */
    ask("EA 03 00", "FE 27");
    ask("EA 01 01", "FE 28");
}

static void test_the_client_chooses_the_page_that_it_reads(void)
{
    TEST_ASSERT_EQUAL_UINT32(XCP_PAGE_STAGED, xcp.page);
    ask("EB 02 00 00", "FF");
    TEST_ASSERT_EQUAL_UINT32(XCP_PAGE_ACTIVE, xcp.page);
    ask("EA 02 00", "FF 00 00 00");
}

/* One segment with two pages, without mappings, at address 4 of extension 1, 32 octets long. */
static void test_description_of_segment_and_pages(void)
{
    ask("E9", "FF 01 00");
    ask("E8 01 00 00 00", "FF 02 01 00 00 00");
    ask("E8 00 00 00 00", "FF 00 00 00 04 00 00 00");
    ask("E8 00 00 01 00", "FF 00 00 00 20 00 00 00");
    ask("E8 00 00 02 00", "FE 22");
    ask("E8 02 00 00 00", "FE 22");
    ask("E8 01 01 00 00", "FE 28");
    ask("E7 00 00 00", "FF 0F 00");
    ask("E7 00 00 01", "FF 3C 00");
    ask("E7 00 00 02", "FE 26");
    ask("E7 00 01 00", "FE 28");
}

/* ---- data acquisition ---- */

/* DAQ_PROPERTIES are: dynamic, prescaler, stamps, overload by event. The lists are those that were
 * allocated, there is one event, no list is predefined, and key 0 means absolute ODT numbers. The
 * resolution states entries of four octets, and fixed time stamps of four octets with unit 5 (100 us) and
 * one tick each. Event 0 is for DAQ and consistent as a whole; it has two lists, a name of nine letters
 * and a period of 1 x 100 us. With other carriers 50 us are 5 x 10 us; 62.5 us are 625 x 100 ns, as an
 * octet 63 x 1 us. */
static void test_description_of_acquisition(void)
{
    ask("DA", "FF 93 00 00 01 00 00 00");
    ask("D5 00 02 00", "FF");
    ask("DA", "FF 93 02 00 01 00 00 00");
    ask("D9", "FF 04 04 01 00 5C 01 00");
    ask("DC", "FF 00 00 00 78 56 34 12");
    ask("D7 00 00 00", "FF 84 02 09 01 05 FF");
    ask("F5 09", "FF 'isr_10kHz'");
    ask("D7 00 01 00", "FE 22");
    access.period = 50000u;
    ask("D9", "FF 04 04 01 00 4C 05 00");
    access.period = 62500u;
    ask("D9", "FF 04 04 01 00 2C 71 02");
    ask("D7 00 00 00", "FF 84 02 09 3F 03 FF");
}

/* List 0 has two ODTs, with slots 1 and 2 and with slot 3; list 1 has one, with slot 4. */
static void configure(void)
{
    prepare("D6, D5 00 02 00, D4 00 00 00 02, D4 00 01 00 01");
    prepare("D3 00 00 00 00 02, D3 00 00 00 01 01, D3 00 01 00 00 01, E2 00 00 00 00 00");
    prepare("E1 FF 04 00 04 00 00 00, E1 FF 04 00 08 00 00 00"); /* the pointer is incremented */
    ask("E1 FF 04 00 0C 00 00 00", "FE 22");                     /* but it does not move to the next ODT */
    prepare("E2 00 00 00 01 00, E1 FF 04 00 0C 00 00 00, E2 00 01 00 00 00, E1 FF 04 00 10 00 00 00");
    prepare("E0 10 00 00 00 00 01 00, E0 10 01 00 00 00 03 00");
}

static void sample(uint32_t period)
{
    daq_sample(&daq, memory, period);
}

static void packet(const char *text)
{
    uint16_t octets[FRAME_MAX_DTO];
    const uint32_t count = daq_next(&daq, daq.put, octets);
    expect(text, octets, count);
}

/* Two lists are selected and started together, as recorders do it: both begin in the same period. A packet
 * contains the number of the ODT, in the first packet of a list a stamp, and the values. */
static void test_selected_lists_start_together(void)
{
    char stamped[60];
    configure();
    ask("DE 02 00 00", "FF 00"); /* number of its first ODT */
    ask("DE 02 01 00", "FF 02");
    sample(99u);
    packet("");
    ask("DD 01", "FF");
    sample(UINT32_C(0x01020304));
    packet("00 04 03 02 01 04 05 06 07 08 09 0A 0B");
    packet("01 0C 0D 0E 0F");
    packet("02 04 03 02 01 10 11 12 13");
    for (uint32_t period = 1u; period <= 6u; period++) { /* list 1 has a prescaler of 3 */
        sample(period);
        snprintf(stamped, sizeof stamped, "00 %02X 00 00 00 04 05 06 07 08 09 0A 0B", (unsigned)period);
        packet(stamped);
        packet("01 0C 0D 0E 0F");
        if (period % 3u == 0u) {
            snprintf(stamped, sizeof stamped, "02 %02X 00 00 00 10 11 12 13", (unsigned)period);
            packet(stamped);
        }
        packet("");
    }
    ask("DD 00", "FF");
    sample(7u);
    packet("");
}

static void test_one_list_is_started_and_stopped_by_itself(void)
{
    configure();
    ask("DE 01 01 00", "FF 02");
    sample(1u);
    packet("02 01 00 00 00 10 11 12 13");
    packet("");
    ask("DE 01 00 00", "FF 00"); /* the other type of start, which does not disturb this list */
    sample(2u);
    packet("00 02 00 00 00 04 05 06 07 08 09 0A 0B");
    packet("01 0C 0D 0E 0F");
    ask("DE 00 00 00", "FF 00");
    sample(3u);
    packet("");
    sample(4u);
    packet("02 04 00 00 00 10 11 12 13");
    ask("DE 02 01 00", "FF 02");
    ask("DD 02", "FF"); /* stops the selected list */
    ask("FD", "FF 00 00 00 00 00");
}

static void test_a_running_list_is_not_changed(void)
{
    configure();
    ask("DE 01 00 00", "FF 00");
    ask("D5 00 01 00", "FE 11");
    ask("D4 00 00 00 01", "FE 11");
    ask("D3 00 00 00 00 01", "FE 11");
    ask("E2 00 00 00 00 00", "FF");
    ask("E1 FF 04 00 04 00 00 00", "FE 11");
    ask("E0 10 00 00 00 00 01 00", "FE 11");
    ask("D6", "FF"); /* it is allowed to release all of them */
    TEST_ASSERT_EQUAL_UINT32(0u, daq.running);
}

static void test_allocations_have_an_order_and_an_end(void)
{
    ask("D4 00 00 00 01", "FE 29");
    ask("D3 00 00 00 00 01", "FE 29");
    ask("D5 00 03 00", "FE 30");
    ask("D5 00 02 00", "FF");
    ask("D5 00 02 00", "FE 29");
    ask("D3 00 00 00 00 01", "FE 29");
    ask("D4 00 02 00 01", "FE 22");
    ask("D4 00 00 00 11", "FE 30");
    ask("D4 00 00 00 FF", "FE 30");
    ask("D4 00 00 00 02", "FF");
    ask("D4 00 00 00 01", "FE 29");
    ask("D3 00 00 00 02 01", "FE 22");
    ask("D3 00 00 00 00 11", "FE 30");
    ask("D3 00 00 00 00 0A", "FF");
    ask("D3 00 00 00 01 07", "FE 30");
    ask("D3 00 00 00 01 06", "FF");
    ask("D3 00 00 00 01 01", "FE 29");
    ask("D4 00 01 00 01", "FE 29");
}

static void test_what_cannot_be_measured_is_refused(void)
{
    prepare(ONE_LIST);
    ask("E2 00 00 00 00 01", "FE 22");
    ask("E2 00 00 00 01 00", "FE 22");
    ask("E2 00 01 00 00 00", "FE 22");
    ask("E2 00 00 00 00 00", "FF");
    ask("E1 FF 02 00 04 00 00 00", "FE 22"); /* half of a slot */
    ask("E1 FF 08 00 04 00 00 00", "FE 22"); /* two slots */
    ask("E1 03 04 00 04 00 00 00", "FE 22"); /* a single bit */
    ask("E1 FF 04 01 04 00 00 00", "FE 22"); /* a parameter */
    ask("E1 FF 04 00 06 00 00 00", "FE 22"); /* parts of two slots */
    ask("DE 01 00 00", "FE 2A");             /* no entry was written */
    ask("DE 01 01 00", "FE 22");
    ask("DE 03 00 00", "FE 27");
    ask("DD 04", "FE 27");
    ask("E0 12 00 00 00 00 01 00", "FE 27"); /* stimulation is not supported */
    ask("E0 30 00 00 00 00 01 00", "FE 27"); /* packets without a number are not supported */
    ask("E0 10 00 00 01 00 01 00", "FE 22"); /* an event that does not exist */
    ask("E0 10 01 00 00 00 01 00", "FE 22"); /* a list that does not exist */
}

static void test_a_common_start_is_all_or_nothing(void)
{
    prepare("D5 00 02 00, D4 00 00 00 01, D4 00 01 00 01, D3 00 00 00 00 01, D3 00 01 00 00 01");
    prepare("E2 00 00 00 00 00, E1 FF 04 00 04 00 00 00");
    ask("DE 02 00 00", "FF 00");
    ask("DE 02 01 00", "FF 01");
    ask("DD 01", "FE 2A");
    TEST_ASSERT_EQUAL_UINT32(0u, daq.running);
}
