/* The slave by octets: commands as the standard (ASAM MCD-1 XCP 1.x, "Command reference") lays them out, and
 * the answers that it lays out for them. Behind the addresses stands a memory of this file: extension 1,
 * slots 1 to 8, which may hold anything but 0xDEADDEAD; extension 0, which cannot be written; texts of
 * extensions 5 and 6. */
#include "talk/xcp.h"

#include <string.h>
#include <unity.h>

#define SLOTS 9u /* slot 0 is none */

static xcp_t xcp;
static daq_t daq;
static uint16_t answer[FRAME_MAX_CTO];
static uint32_t length;

static uint32_t memory[SLOTS];
static uint32_t applied_memory[SLOTS];
static bool set_is_bad;
static uint32_t clock_now;

static const char *text_of(uint32_t extension)
{
    return extension == XCP_EXTENSION_A2L   ? "a file to upload, 33 octets of it"
           : extension == XCP_EXTENSION_EPK ? "lagless-01234567"
                                            : "isr_10kHz";
}

static bool is_text(uint32_t extension)
{
    return extension == XCP_EXTENSION_A2L || extension == XCP_EXTENSION_EPK ||
           extension == XCP_EXTENSION_EVENT;
}

static uint32_t text_length(uint32_t extension)
{
    return (uint32_t)strlen(text_of(extension));
}

static uint32_t read_memory(uint32_t extension, uint32_t address, uint32_t count, uint16_t *octets)
{
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t at = address + n;
        if (is_text(extension)) {
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

static xcp_access_t access = {
    .read = read_memory,
    .write = write_memory,
    .writable = writable,
    .coded = none_coded,
    .measurable = measurable,
    .text_length = text_length,
    .segment = segment,
    .apply = apply,
    .applied = applied,
    .clock = clock_of_drive,
    .period = 100000u,
};

/* ---- octets ---- */

static void send(const uint16_t *octets, uint32_t count)
{
    memset(answer, 0x55, sizeof answer);
    length = xcp_command(&xcp, &daq, &access, (frame_packet_t){octets, count}, answer);
}

#define SEND(...)                                                                                            \
    send((const uint16_t[]){__VA_ARGS__}, sizeof((const uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t))
#define EXPECT(...)                                                                                          \
    do {                                                                                                     \
        static const uint16_t expected[] = {__VA_ARGS__};                                                    \
        TEST_ASSERT_EQUAL_UINT32(sizeof expected / sizeof expected[0], length);                              \
        TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, answer, sizeof expected / sizeof expected[0]);               \
    } while (0)

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
    SEND(0xFF, 0x00);
}

void tearDown(void)
{
}

/* ---- session ---- */

/* RESOURCE: CAL/PAG and DAQ. COMM_MODE_BASIC: Intel, BYTE, no block mode, GET_COMM_MODE_INFO is there.
 * MAX_CTO 64, MAX_DTO 128, both versions 1. */
static void test_connect_tells_what_the_slave_can(void)
{
    EXPECT(0xFF, 0x05, 0x80, 64, 128, 0, 0x01, 0x01);
}

static void test_without_a_connection_only_connect_is_answered(void)
{
    SEND(0xFE);
    EXPECT(0xFF);
    for (uint16_t code = 0u; code < 0xFFu; code++) {
        SEND(code, 0, 0, 0, 0, 0, 0, 0);
        TEST_ASSERT_EQUAL_UINT32(0u, length);
    }
    SEND(0xFF, 0x00);
    TEST_ASSERT_EQUAL_UINT32(8u, length);
}

static void test_a_new_connection_begins_anew(void)
{
    SEND(0xD5, 0, 1, 0);
    SEND(0xD4, 0, 0, 0, 1);
    SEND(0xD3, 0, 0, 0, 0, 1);
    SEND(0xE2, 0, 0, 0, 0, 0);
    SEND(0xE1, 0xFF, 4, 0, 4, 0, 0, 0);
    SEND(0xDE, 1, 0, 0);
    SEND(0xEB, 0x02, 0, 0);
    SEND(0xFD);
    EXPECT(0xFF, 0x40, 0, 0, 0, 0); /* DAQ_RUNNING */
    SEND(0xFF, 0x00);
    SEND(0xFD);
    EXPECT(0xFF, 0x00, 0, 0, 0, 0);
    SEND(0xEA, 0x02, 0);
    EXPECT(0xFF, 0, 0, 1); /* the client looks at the staged page again */
    TEST_ASSERT_EQUAL_UINT32(0u, daq.lists);
}

static void test_synch_is_answered_by_its_error(void)
{
    SEND(0xFC);
    EXPECT(0xFE, 0x00);
}

static void test_comm_mode_info(void)
{
    SEND(0xFB);
    EXPECT(0xFF, 0, 0, 0, 0, 0, 0, 0x10);
}

static void test_unknown_commands_are_told_so(void)
{
    static const uint16_t unknown[] = {0xF8, 0xF7, 0xF2, 0xF1, 0xEF, 0xEE, 0xED, 0xEC, 0xE6,
                                       0xE3, 0xDF, 0xDB, 0xD8, 0xD2, 0xC7, 0xC0, 0x80, 0x00};
    for (uint32_t n = 0; n < sizeof unknown / sizeof unknown[0]; n++) {
        SEND(unknown[n], 0, 0, 0, 0, 0, 0, 0);
        EXPECT(0xFE, 0x20);
    }
}

/* Octets that a command needs at least; one fewer is a mistake of syntax. */
static void test_short_commands_are_told_so(void)
{
    static const struct {
        uint16_t code;
        uint32_t octets;
    } needs[] = {{0xFF, 2}, {0xFA, 2}, {0xF6, 8}, {0xF5, 2}, {0xF4, 8}, {0xF3, 8}, {0xF0, 2},
                 {0xEB, 4}, {0xEA, 3}, {0xE8, 5}, {0xE7, 4}, {0xE2, 6}, {0xE1, 8}, {0xE0, 8},
                 {0xDE, 4}, {0xDD, 2}, {0xD7, 4}, {0xD5, 4}, {0xD4, 5}, {0xD3, 6}};
    for (uint32_t n = 0; n < sizeof needs / sizeof needs[0]; n++) {
        for (uint32_t octets = 1u; octets < needs[n].octets; octets++) {
            const uint16_t command[8] = {needs[n].code, 1};
            send(command, octets);
            EXPECT(0xFE, 0x21);
        }
    }
}

/* Mode 1: the text stands in the answer. Mode 0: it is to be uploaded from where the transfer address now is.
 */
static void test_identification(void)
{
    SEND(0xFA, 0);
    EXPECT(0xFF, 1, 0, 0, 7, 0, 0, 0, 'l', 'a', 'g', 'l', 'e', 's', 's');
    SEND(0xFA, 1);
    EXPECT(0xFF, 1, 0, 0, 7, 0, 0, 0, 'l', 'a', 'g', 'l', 'e', 's', 's');
    SEND(0xFA, 4);
    EXPECT(0xFF, 0, 0, 0, 33, 0, 0, 0);
    SEND(0xF5, 6);
    EXPECT(0xFF, 'a', ' ', 'f', 'i', 'l', 'e');
    SEND(0xF5, 3);
    EXPECT(0xFF, ' ', 't', 'o');
    SEND(0xFA, 5);
    EXPECT(0xFF, 0, 0, 0, 16, 0, 0, 0);
    SEND(0xF5, 8);
    EXPECT(0xFF, 'l', 'a', 'g', 'l', 'e', 's', 's', '-');
    SEND(0xFA, 2);
    EXPECT(0xFF, 0, 0, 0, 0, 0, 0, 0); /* nothing of this type */
    SEND(0xFA, 200);
    EXPECT(0xFF, 0, 0, 0, 0, 0, 0, 0);
}

/* ---- memory ---- */

static void test_upload_goes_on_where_it_ended(void)
{
    SEND(0xF6, 0, 0, 1, 4, 0, 0, 0);
    EXPECT(0xFF);
    SEND(0xF5, 4);
    EXPECT(0xFF, 0x04, 0x05, 0x06, 0x07);
    SEND(0xF5, 6);
    EXPECT(0xFF, 0x08, 0x09, 0x0A, 0x0B, 0x0C, 0x0D);
    SEND(0xF5, 1);
    EXPECT(0xFF, 0x0E);
}

static void test_short_upload_brings_its_address(void)
{
    SEND(0xF4, 4, 0, 1, 8, 0, 0, 0);
    EXPECT(0xFF, 0x08, 0x09, 0x0A, 0x0B);
    SEND(0xF5, 4); /* the transfer address stands behind it */
    EXPECT(0xFF, 0x0C, 0x0D, 0x0E, 0x0F);
    SEND(0xF4, 2, 0, 0, 7, 0, 0, 0); /* from the midst of a slot */
    EXPECT(0xFF, 0x07, 0x08);
}

static void test_what_is_not_there_is_out_of_range(void)
{
    static const uint16_t addresses[][5] = {
        {1, 0, 0, 0, 0},    {1, 36, 0, 0, 0}, {1, 4, 1, 0, 0},
        {1, 4, 0, 0, 0x80}, {2, 4, 0, 0, 0},  {255, 4, 0, 0, 0},
    };
    for (uint32_t n = 0; n < sizeof addresses / sizeof addresses[0]; n++) {
        const uint16_t *a = addresses[n];
        const uint16_t command[] = {0xF4, 4, 0, a[0], a[1], a[2], a[3], a[4]};
        send(command, 8u);
        EXPECT(0xFE, 0x22);
    }
    SEND(0xF4, 5, 0, 1, 32, 0, 0, 0); /* begins within, ends outside */
    EXPECT(0xFE, 0x22);
    SEND(0xF4, 0, 0, 1, 4, 0, 0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xF4, 64, 0, 1, 4, 0, 0, 0); /* one octet more than an answer holds */
    EXPECT(0xFE, 0x22);
}

static void test_download_writes_slots(void)
{
    SEND(0xF6, 0, 0, 1, 8, 0, 0, 0);
    SEND(0xF0, 8, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88);
    EXPECT(0xFF);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x44332211), memory[2]);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x88776655), memory[3]);
    SEND(0xF0, 4, 0x01, 0x00, 0x00, 0x00); /* and the address goes on */
    EXPECT(0xFF);
    TEST_ASSERT_EQUAL_HEX32(1u, memory[4]);
}

static void test_a_refused_download_changes_nothing(void)
{
    uint32_t before[SLOTS];
    memcpy(before, memory, sizeof memory);
    SEND(0xF6, 0, 0, 1, 4, 0, 0, 0);
    SEND(0xF0, 8, 1, 0, 0, 0, 0xAD, 0xDE, 0xAD, 0xDE); /* the second of two */
    EXPECT(0xFE, 0x22);
    SEND(0xF0, 2, 1, 0); /* half a slot */
    EXPECT(0xFE, 0x22);
    SEND(0xF0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xF0, 4, 1, 0, 0); /* an octet is missing */
    EXPECT(0xFE, 0x21);
    SEND(0xF0, 63, 1, 0, 0); /* more than a command holds */
    EXPECT(0xFE, 0x21);
    SEND(0xF0, 255, 1, 0, 0);
    EXPECT(0xFE, 0x21);
    SEND(0xF6, 0, 0, 1, 5, 0, 0, 0); /* across two slots */
    SEND(0xF0, 4, 1, 0, 0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xF6, 0, 0, 0, 4, 0, 0, 0); /* a signal */
    SEND(0xF0, 4, 1, 0, 0, 0);
    EXPECT(0xFE, 0x23);
    SEND(0xF6, 0, 0, 9, 4, 0, 0, 0); /* nothing at all */
    SEND(0xF0, 4, 1, 0, 0, 0);
    EXPECT(0xFE, 0x22);
    TEST_ASSERT_EQUAL_HEX32_ARRAY(before, memory, SLOTS);
}

/* CRC-32 of IEEE 802.3 over 04h, 05h, ... 0Fh, by Python's zlib.crc32(bytes(range(4, 16))): 0xBCFF1C39. */
static void test_checksum_of_a_block(void)
{
    SEND(0xF6, 0, 0, 1, 4, 0, 0, 0);
    SEND(0xF3, 0, 0, 0, 12, 0, 0, 0);
    EXPECT(0xFF, 0x09, 0, 0, 0x39, 0x1C, 0xFF, 0xBC);
    SEND(0xF5, 1);
    EXPECT(0xFF, 0x10); /* the address stands behind the block */
    SEND(0xF6, 0, 0, 1, 4, 0, 0, 0);
    SEND(0xF3, 0, 0, 0, 0, 0, 0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xF3, 0, 0, 0, 13, 0, 0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xF3, 0, 0, 0, 0, 0, 0, 0x80); /* too long: the largest block is 1000h octets */
    EXPECT(0xFE, 0x22, 0, 0, 0x00, 0x10, 0, 0);
    SEND(0xF3, 0, 0, 0, 64, 0, 0, 0); /* runs out of what there is */
    EXPECT(0xFE, 0x22);
}

/* ---- pages ---- */

static void test_setting_the_drives_page_applies_the_staged_set(void)
{
    SEND(0xEA, 0x01, 0);
    EXPECT(0xFF, 0, 0, 0);
    memory[3] = 77u;
    SEND(0xEA, 0x01, 0);
    EXPECT(0xFF, 0, 0, 1);
    set_is_bad = true;
    SEND(0xEB, 0x01, 0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xEA, 0x01, 0);
    EXPECT(0xFF, 0, 0, 1);
    set_is_bad = false;
    SEND(0xEB, 0x01, 0, 0);
    EXPECT(0xFF);
    TEST_ASSERT_EQUAL_UINT32(77u, applied_memory[3]);
    SEND(0xEA, 0x01, 0);
    EXPECT(0xFF, 0, 0, 0);
}

static void test_pages_that_there_are_not(void)
{
    SEND(0xEB, 0x01, 0, 1); /* the drive runs on no staged set */
    EXPECT(0xFE, 0x26);
    SEND(0xEB, 0x02, 0, 2);
    EXPECT(0xFE, 0x26);
    SEND(0xEB, 0x00, 0, 0);
    EXPECT(0xFE, 0x27);
    SEND(0xEB, 0x01, 1, 0);
    EXPECT(0xFE, 0x28);
    SEND(0xEB, 0x81, 7, 0); /* of all segments */
    EXPECT(0xFF);
    SEND(0xEA, 0x03, 0);
    EXPECT(0xFE, 0x27);
    SEND(0xEA, 0x01, 1);
    EXPECT(0xFE, 0x28);
}

static void test_the_client_chooses_the_page_that_it_reads(void)
{
    TEST_ASSERT_EQUAL_UINT32(XCP_PAGE_STAGED, xcp.page);
    SEND(0xEB, 0x02, 0, 0);
    EXPECT(0xFF);
    TEST_ASSERT_EQUAL_UINT32(XCP_PAGE_ACTIVE, xcp.page);
    SEND(0xEA, 0x02, 0);
    EXPECT(0xFF, 0, 0, 0);
}

/* One segment of two pages, without mappings, at address 4 of extension 1, 32 octets long. */
static void test_what_is_said_of_segment_and_pages(void)
{
    SEND(0xE9);
    EXPECT(0xFF, 1, 0);
    SEND(0xE8, 1, 0, 0, 0);
    EXPECT(0xFF, 2, 1, 0, 0, 0);
    SEND(0xE8, 0, 0, 0, 0);
    EXPECT(0xFF, 0, 0, 0, 4, 0, 0, 0);
    SEND(0xE8, 0, 0, 1, 0);
    EXPECT(0xFF, 0, 0, 0, 32, 0, 0, 0);
    SEND(0xE8, 0, 0, 2, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xE8, 2, 0, 0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xE8, 1, 1, 0, 0);
    EXPECT(0xFE, 0x28);
    SEND(0xE7, 0, 0, 0);
    EXPECT(0xFF, 0x0F, 0);
    SEND(0xE7, 0, 0, 1);
    EXPECT(0xFF, 0x3C, 0);
    SEND(0xE7, 0, 0, 2);
    EXPECT(0xFE, 0x26);
    SEND(0xE7, 0, 1, 0);
    EXPECT(0xFE, 0x28);
}

/* ---- data acquisition ---- */

/* DAQ_PROPERTIES: dynamic, prescaler, stamps, overload by event. Lists as allocated, one event, none
 * predefined, key 0: absolute ODT numbers. Resolution: entries of four octets; stamps of four octets, fixed,
 * unit 5 (100 us), one tick each. */
static void test_what_is_said_of_acquisition(void)
{
    SEND(0xDA);
    EXPECT(0xFF, 0x93, 0, 0, 1, 0, 0, 0);
    SEND(0xD5, 0, 2, 0);
    SEND(0xDA);
    EXPECT(0xFF, 0x93, 2, 0, 1, 0, 0, 0);
    SEND(0xD9);
    EXPECT(0xFF, 4, 4, 1, 0, 0x5C, 1, 0);
    SEND(0xDC);
    EXPECT(0xFF, 0, 0, 0, 0x78, 0x56, 0x34, 0x12);
}

/* Event 0: for DAQ, consistent as a whole, two lists, nine letters of name, every 1 x 100 us. */
static void test_the_event_has_name_and_cycle(void)
{
    SEND(0xD7, 0, 0, 0);
    EXPECT(0xFF, 0x84, 2, 9, 1, 5, 255);
    SEND(0xF5, 9);
    EXPECT(0xFF, 'i', 's', 'r', '_', '1', '0', 'k', 'H', 'z');
    SEND(0xD7, 0, 1, 0);
    EXPECT(0xFE, 0x22);
}

/* Other carriers: 50 us are 5 x 10 us; 62.5 us are 625 x 100 ns, as an octet 63 x 1 us. */
static void test_other_periods_are_told_as_exactly_as_it_can_be(void)
{
    access.period = 50000u;
    SEND(0xD9);
    EXPECT(0xFF, 4, 4, 1, 0, 0x4C, 5, 0);
    access.period = 62500u;
    SEND(0xD9);
    EXPECT(0xFF, 4, 4, 1, 0, 0x2C, 0x71, 0x02);
    SEND(0xD7, 0, 0, 0);
    EXPECT(0xFF, 0x84, 2, 9, 63, 3, 255);
}

/* Two ODTs of list 0: slots 1 and 2, and slot 3; one of list 1: slot 4. */
static void configure(void)
{
    SEND(0xD6);
    EXPECT(0xFF);
    SEND(0xD5, 0, 2, 0);
    EXPECT(0xFF);
    SEND(0xD4, 0, 0, 0, 2);
    EXPECT(0xFF);
    SEND(0xD4, 0, 1, 0, 1);
    EXPECT(0xFF);
    SEND(0xD3, 0, 0, 0, 0, 2);
    EXPECT(0xFF);
    SEND(0xD3, 0, 0, 0, 1, 1);
    EXPECT(0xFF);
    SEND(0xD3, 0, 1, 0, 0, 1);
    EXPECT(0xFF);
    SEND(0xE2, 0, 0, 0, 0, 0);
    EXPECT(0xFF);
    SEND(0xE1, 0xFF, 4, 0, 4, 0, 0, 0);
    EXPECT(0xFF);
    SEND(0xE1, 0xFF, 4, 0, 8, 0, 0, 0); /* the pointer goes on */
    EXPECT(0xFF);
    SEND(0xE1, 0xFF, 4, 0, 12, 0, 0, 0); /* but not into the next ODT */
    EXPECT(0xFE, 0x22);
    SEND(0xE2, 0, 0, 0, 1, 0);
    SEND(0xE1, 0xFF, 4, 0, 12, 0, 0, 0);
    EXPECT(0xFF);
    SEND(0xE2, 0, 1, 0, 0, 0);
    SEND(0xE1, 0xFF, 4, 0, 16, 0, 0, 0);
    EXPECT(0xFF);
    SEND(0xE0, 0x10, 0, 0, 0, 0, 1, 0);
    EXPECT(0xFF);
    SEND(0xE0, 0x10, 1, 0, 0, 0, 3, 0);
    EXPECT(0xFF);
}

static void sample(uint32_t period)
{
    daq_sample(&daq, memory, period);
}

static void expect_packet(const uint16_t *octets, uint32_t count)
{
    uint16_t packet[FRAME_MAX_DTO];
    TEST_ASSERT_EQUAL_UINT32(count, daq_next(&daq, daq.put, packet));
    TEST_ASSERT_EQUAL_HEX16_ARRAY(octets, packet, count);
}
#define PACKET(...)                                                                                          \
    expect_packet((const uint16_t[]){__VA_ARGS__}, sizeof((const uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t))

/* By select and a common start, as recorders do it: both lists begin in the same period; packets are ODT
 * number, stamp in the first of a list, values. */
static void test_selected_lists_start_together(void)
{
    uint16_t none[FRAME_MAX_DTO];
    configure();
    SEND(0xDE, 2, 0, 0);
    EXPECT(0xFF, 0); /* number of its first ODT */
    SEND(0xDE, 2, 1, 0);
    EXPECT(0xFF, 2);
    sample(99u);
    TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, none));
    SEND(0xDD, 1);
    EXPECT(0xFF);
    sample(UINT32_C(0x01020304));
    PACKET(0, 0x04, 0x03, 0x02, 0x01, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0A, 0x0B);
    PACKET(1, 0x0C, 0x0D, 0x0E, 0x0F);
    PACKET(2, 0x04, 0x03, 0x02, 0x01, 0x10, 0x11, 0x12, 0x13);
    for (uint32_t period = 1u; period <= 6u; period++) { /* list 1 has a prescaler of 3 */
        sample(period);
        PACKET(0, (uint16_t)period, 0, 0, 0, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0A, 0x0B);
        PACKET(1, 0x0C, 0x0D, 0x0E, 0x0F);
        if (period % 3u == 0u) {
            PACKET(2, (uint16_t)period, 0, 0, 0, 0x10, 0x11, 0x12, 0x13);
        }
        TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, none));
    }
    SEND(0xDD, 0);
    EXPECT(0xFF);
    sample(7u);
    TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, none));
}

static void test_one_list_is_started_and_stopped_by_itself(void)
{
    uint16_t packet[FRAME_MAX_DTO];
    configure();
    SEND(0xDE, 1, 1, 0);
    EXPECT(0xFF, 2);
    sample(1u);
    PACKET(2, 1, 0, 0, 0, 0x10, 0x11, 0x12, 0x13);
    TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, packet));
    SEND(0xDE, 1, 0, 0); /* the other one beside it, which is not disturbed */
    EXPECT(0xFF, 0);
    sample(2u);
    PACKET(0, 2, 0, 0, 0, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0A, 0x0B);
    PACKET(1, 0x0C, 0x0D, 0x0E, 0x0F);
    SEND(0xDE, 0, 0, 0);
    EXPECT(0xFF, 0);
    sample(3u);
    TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, packet));
    sample(4u);
    PACKET(2, 4, 0, 0, 0, 0x10, 0x11, 0x12, 0x13);
    SEND(0xDE, 2, 1, 0);
    SEND(0xDD, 2); /* stop what is selected */
    EXPECT(0xFF);
    SEND(0xFD);
    EXPECT(0xFF, 0, 0, 0, 0, 0);
}

static void test_a_running_list_is_not_changed(void)
{
    configure();
    SEND(0xDE, 1, 0, 0);
    SEND(0xD5, 0, 1, 0);
    EXPECT(0xFE, 0x11);
    SEND(0xD4, 0, 0, 0, 1);
    EXPECT(0xFE, 0x11);
    SEND(0xD3, 0, 0, 0, 0, 1);
    EXPECT(0xFE, 0x11);
    SEND(0xE2, 0, 0, 0, 0, 0);
    SEND(0xE1, 0xFF, 4, 0, 4, 0, 0, 0);
    EXPECT(0xFE, 0x11);
    SEND(0xE0, 0x10, 0, 0, 0, 0, 1, 0);
    EXPECT(0xFE, 0x11);
    SEND(0xD6); /* but all of it may be given up */
    EXPECT(0xFF);
    TEST_ASSERT_EQUAL_UINT32(0u, daq.running);
}

static void test_allocations_have_an_order_and_an_end(void)
{
    SEND(0xD4, 0, 0, 0, 1);
    EXPECT(0xFE, 0x29);
    SEND(0xD3, 0, 0, 0, 0, 1);
    EXPECT(0xFE, 0x29);
    SEND(0xD5, 0, 3, 0);
    EXPECT(0xFE, 0x30);
    SEND(0xD5, 0, 2, 0);
    SEND(0xD5, 0, 2, 0);
    EXPECT(0xFE, 0x29);
    SEND(0xD3, 0, 0, 0, 0, 1);
    EXPECT(0xFE, 0x29);
    SEND(0xD4, 0, 2, 0, 1);
    EXPECT(0xFE, 0x22);
    SEND(0xD4, 0, 0, 0, 17);
    EXPECT(0xFE, 0x30);
    SEND(0xD4, 0, 0, 0, 255);
    EXPECT(0xFE, 0x30);
    SEND(0xD4, 0, 0, 0, 2);
    EXPECT(0xFF);
    SEND(0xD4, 0, 0, 0, 1);
    EXPECT(0xFE, 0x29);
    SEND(0xD3, 0, 0, 0, 2, 1);
    EXPECT(0xFE, 0x22);
    SEND(0xD3, 0, 0, 0, 0, 17);
    EXPECT(0xFE, 0x30);
    SEND(0xD3, 0, 0, 0, 0, 10);
    EXPECT(0xFF);
    SEND(0xD3, 0, 0, 0, 1, 7);
    EXPECT(0xFE, 0x30);
    SEND(0xD3, 0, 0, 0, 1, 6);
    EXPECT(0xFF);
    SEND(0xD3, 0, 0, 0, 1, 1);
    EXPECT(0xFE, 0x29);
    SEND(0xD4, 0, 1, 0, 1);
    EXPECT(0xFE, 0x29);
}

static void test_what_cannot_be_measured_is_refused(void)
{
    SEND(0xD5, 0, 1, 0);
    SEND(0xD4, 0, 0, 0, 1);
    SEND(0xD3, 0, 0, 0, 0, 1);
    SEND(0xE2, 0, 0, 0, 0, 1);
    EXPECT(0xFE, 0x22);
    SEND(0xE2, 0, 0, 0, 1, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xE2, 0, 1, 0, 0, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xE2, 0, 0, 0, 0, 0);
    EXPECT(0xFF);
    SEND(0xE1, 0xFF, 2, 0, 4, 0, 0, 0); /* half a slot */
    EXPECT(0xFE, 0x22);
    SEND(0xE1, 0xFF, 8, 0, 4, 0, 0, 0); /* two of them */
    EXPECT(0xFE, 0x22);
    SEND(0xE1, 3, 4, 0, 4, 0, 0, 0); /* one bit */
    EXPECT(0xFE, 0x22);
    SEND(0xE1, 0xFF, 4, 1, 4, 0, 0, 0); /* a parameter */
    EXPECT(0xFE, 0x22);
    SEND(0xE1, 0xFF, 4, 0, 6, 0, 0, 0); /* across two slots */
    EXPECT(0xFE, 0x22);
    SEND(0xDE, 1, 0, 0); /* and nothing was written */
    EXPECT(0xFE, 0x2A);
    SEND(0xDE, 1, 1, 0);
    EXPECT(0xFE, 0x22);
    SEND(0xDE, 3, 0, 0);
    EXPECT(0xFE, 0x27);
    SEND(0xDD, 4);
    EXPECT(0xFE, 0x27);
    SEND(0xE0, 0x12, 0, 0, 0, 0, 1, 0); /* stimulation */
    EXPECT(0xFE, 0x27);
    SEND(0xE0, 0x30, 0, 0, 0, 0, 1, 0); /* without number */
    EXPECT(0xFE, 0x27);
    SEND(0xE0, 0x10, 0, 0, 1, 0, 1, 0); /* another event */
    EXPECT(0xFE, 0x22);
    SEND(0xE0, 0x10, 1, 0, 0, 0, 1, 0); /* another list */
    EXPECT(0xFE, 0x22);
}

/* One of the lists that shall start is not complete: neither does. */
static void test_a_common_start_is_all_or_nothing(void)
{
    SEND(0xD5, 0, 2, 0);
    SEND(0xD4, 0, 0, 0, 1);
    SEND(0xD4, 0, 1, 0, 1);
    SEND(0xD3, 0, 0, 0, 0, 1);
    SEND(0xD3, 0, 1, 0, 0, 1);
    SEND(0xE2, 0, 0, 0, 0, 0);
    SEND(0xE1, 0xFF, 4, 0, 4, 0, 0, 0);
    SEND(0xDE, 2, 0, 0);
    SEND(0xDE, 2, 1, 0);
    SEND(0xDD, 1);
    EXPECT(0xFE, 0x2A);
    TEST_ASSERT_EQUAL_UINT32(0u, daq.running);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_connect_tells_what_the_slave_can);
    RUN_TEST(test_without_a_connection_only_connect_is_answered);
    RUN_TEST(test_a_new_connection_begins_anew);
    RUN_TEST(test_synch_is_answered_by_its_error);
    RUN_TEST(test_comm_mode_info);
    RUN_TEST(test_unknown_commands_are_told_so);
    RUN_TEST(test_short_commands_are_told_so);
    RUN_TEST(test_identification);
    RUN_TEST(test_upload_goes_on_where_it_ended);
    RUN_TEST(test_short_upload_brings_its_address);
    RUN_TEST(test_what_is_not_there_is_out_of_range);
    RUN_TEST(test_download_writes_slots);
    RUN_TEST(test_a_refused_download_changes_nothing);
    RUN_TEST(test_checksum_of_a_block);
    RUN_TEST(test_setting_the_drives_page_applies_the_staged_set);
    RUN_TEST(test_pages_that_there_are_not);
    RUN_TEST(test_the_client_chooses_the_page_that_it_reads);
    RUN_TEST(test_what_is_said_of_segment_and_pages);
    RUN_TEST(test_what_is_said_of_acquisition);
    RUN_TEST(test_the_event_has_name_and_cycle);
    RUN_TEST(test_other_periods_are_told_as_exactly_as_it_can_be);
    RUN_TEST(test_selected_lists_start_together);
    RUN_TEST(test_one_list_is_started_and_stopped_by_itself);
    RUN_TEST(test_a_running_list_is_not_changed);
    RUN_TEST(test_allocations_have_an_order_and_an_end);
    RUN_TEST(test_what_cannot_be_measured_is_refused);
    RUN_TEST(test_a_common_start_is_all_or_nothing);
    return UNITY_END();
}
