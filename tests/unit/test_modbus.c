/* Modbus RTU: frames separated by the gap, the CRC, and functions and exceptions of the standard. The rows
 * belong to this file: ids 10 to 12 hold whole values, 13 a float; 12 is read-only; 11 refuses 99; ids 14
 * to 19 are a gap; others do not exist. */
#include "talk/modbus.h"

#include "tests/unit/compare.h"

#define ADDRESS 17u
#define GAP     18u /* [periods] length of the gap */

static modbus_t modbus;
static uint16_t store[MODBUS_STORE_OCTETS + 1u];
static uint16_t answer[MODBUS_ANSWER_MAX + 1u];
static uint32_t slots[20];
static uint32_t now;

static uint32_t read_slot(uint32_t id, uint32_t *slot)
{
    *slot = id < 20u ? slots[id] : 0u;
    return id >= 10u && id < 20u ? MODBUS_OK : MODBUS_ILLEGAL_ADDRESS;
}

static uint32_t write_slots(uint32_t id, uint32_t count, const uint32_t *values)
{
    if (id < 10u || id + count > 14u) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    for (uint32_t n = 0; n < count; n++) {
        if (id + n == 12u) {
            return MODBUS_ILLEGAL_ADDRESS;
        }
        if (id + n == 11u && values[n] == 99u) {
            return MODBUS_FAILURE;
        }
    }
    for (uint32_t n = 0; n < count; n++) {
        slots[id + n] = values[n];
    }
    return MODBUS_OK;
}

static bool is_whole(uint32_t id)
{
    return id != 13u;
}

static const modbus_access_t access = {read_slot, write_slots, is_whole};

void setUp(void)
{
    memset(&modbus, 0, sizeof modbus);
    for (uint32_t n = 0; n < 20u; n++) {
        slots[n] = 0u;
    }
    slots[10] = 0x12345678u;
    slots[13] = 0x3FC00000u; /* 1.5 */
    store[MODBUS_STORE_OCTETS] = 0x5A5Au;
    answer[MODBUS_ANSWER_MAX] = 0xA5A5u;
    now = 1000u;
    modbus_set(&modbus, ADDRESS, GAP);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_HEX16(0x5A5Au, store[MODBUS_STORE_OCTETS]);
    TEST_ASSERT_EQUAL_HEX16(0xA5A5u, answer[MODBUS_ANSWER_MAX]);
}

/* The division of the message by x^16 + x^15 + x^2 + 1, bit by bit as on the line: octets with the lowest
 * bit first. */
static uint32_t remainder_of(const uint16_t *octets, uint32_t count)
{
    uint32_t rest = 0xFFFFu; /* bit 15 is the power 0, bit 0 is the power 15 */
    for (uint32_t n = 0; n < 8u * count; n++) {
        const uint32_t in = (uint32_t)octets[n / 8u] >> n % 8u & 1u;
        const uint32_t out = rest & 1u;
        rest >>= 1;
        if ((in ^ out) != 0u) {
            rest ^= 1u << 15 | 1u << 13 | 1u; /* the powers 0, 2 and 15 */
        }
    }
    return rest;
}

static void take(const uint16_t *octets, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        modbus_take(&modbus, store, octets[n], now);
    }
}

static modbus_result_t after(uint32_t periods)
{
    now += periods;
    return modbus_listen(&modbus, store, &access, now, answer);
}

/* Sends the octets of a request with its CRC; returns the answer of the server. */
static modbus_result_t ask(const uint16_t *octets, uint32_t count)
{
    const uint32_t crc = remainder_of(octets, count);
    const uint16_t tail[2] = {(uint16_t)(crc & 0xFFu), (uint16_t)(crc >> 8)};
    take(octets, count);
    take(tail, 2u);
    return after(GAP);
}
#define ASK(...)                                                                                             \
    ask((const uint16_t[]){__VA_ARGS__}, sizeof((const uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t))

static void expect(modbus_result_t result, const uint16_t *octets, uint32_t count)
{
    TEST_ASSERT_TRUE(result.heard);
    TEST_ASSERT_EQUAL_UINT32(count + 2u, result.count);
    TEST_ASSERT_EQUAL_HEX16_ARRAY(octets, answer, count);
    const uint32_t crc = remainder_of(octets, count);
    TEST_ASSERT_EQUAL_HEX16(crc & 0xFFu, answer[count]);
    TEST_ASSERT_EQUAL_HEX16(crc >> 8, answer[count + 1u]);
}
#define EXPECT(result, ...)                                                                                  \
    expect(result, (const uint16_t[]){__VA_ARGS__},                                                          \
           sizeof((const uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t))

static void expect_silence(modbus_result_t result, uint32_t errors)
{
    TEST_ASSERT_FALSE(result.heard);
    TEST_ASSERT_EQUAL_UINT32(0u, result.count);
    TEST_ASSERT_EQUAL_UINT32(errors, modbus.errors);
    modbus.errors = 0u;
}

/* The example in the standard's appendix about the CRC: 02 07 has the CRC 41 12. */
static void test_the_crc_is_that_of_the_standard(void)
{
    static const uint16_t example[] = {0x02, 0x07};
    TEST_ASSERT_EQUAL_HEX16(0x1241u, remainder_of(example, 2u));
    modbus_set(&modbus, 2u, GAP);
    static const uint16_t frame[] = {0x02, 0x07, 0x41, 0x12};
    take(frame, 4u);
    EXPECT(after(GAP), 0x02, 0x87, MODBUS_ILLEGAL_FUNCTION); /* function 7 does not exist */
}

static void test_registers_are_halves_of_slots_the_upper_one_first(void)
{
    EXPECT(ASK(ADDRESS, 3, 0, 20, 0, 2), ADDRESS, 3, 4, 0x12, 0x34, 0x56, 0x78);
    EXPECT(ASK(ADDRESS, 4, 0, 21, 0, 1), ADDRESS, 4, 2, 0x56, 0x78);
    EXPECT(ASK(ADDRESS, 3, 0, 25, 0, 3), ADDRESS, 3, 6, 0, 0, 0x3F, 0xC0, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(3u, modbus.frames);
}

static void test_a_block_may_be_as_long_as_its_answer_has_room_and_not_longer(void)
{
    EXPECT(ASK(ADDRESS, 3, 0, 20, 0, 0), ADDRESS, 0x83, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 3, 0, 20, 0, MODBUS_READ_MOST + 1u), ADDRESS, 0x83, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 3, 0, 20, 1, 2), ADDRESS, 0x83, MODBUS_ILLEGAL_VALUE);
    /* The range ends after the last register. */
    EXPECT(ASK(ADDRESS, 3, 0, 38, 0, 3), ADDRESS, 0x83, MODBUS_ILLEGAL_ADDRESS);
    EXPECT(ASK(ADDRESS, 3, 0, 19, 0, 1), ADDRESS, 0x83, MODBUS_ILLEGAL_ADDRESS);
    EXPECT(ASK(ADDRESS, 3, 0xFF, 0xFF, 0, 2), ADDRESS, 0x83, MODBUS_ILLEGAL_ADDRESS);
}

static uint32_t read_any(uint32_t id, uint32_t *slot)
{
    *slot = id;
    return MODBUS_OK;
}

static void test_the_longest_answer_fits(void)
{
    static const modbus_access_t any = {read_any, write_slots, is_whole};
    static const uint16_t request[] = {ADDRESS, 3, 0, 1, 0, MODBUS_READ_MOST};
    const uint32_t crc = remainder_of(request, 6u);
    const uint16_t tail[2] = {(uint16_t)(crc & 0xFFu), (uint16_t)(crc >> 8)};
    take(request, 6u);
    take(tail, 2u);
    now += GAP;
    const modbus_result_t result = modbus_listen(&modbus, store, &any, now, answer);
    TEST_ASSERT_EQUAL_UINT32(MODBUS_ANSWER_MAX, result.count);
    TEST_ASSERT_EQUAL_UINT32(0u, remainder_of(answer, result.count));
    TEST_ASSERT_EQUAL_HEX16(30u, answer[4u + 2u * 60u]); /* register 61, the lower half of id 30 */
}

static void test_whole_slots_are_written_all_or_none(void)
{
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 4, 8, 0, 1, 0, 2, 0, 3, 0, 4), ADDRESS, 16, 0, 20, 0, 4);
    TEST_ASSERT_EQUAL_HEX32(0x00010002u, slots[10]);
    TEST_ASSERT_EQUAL_HEX32(0x00030004u, slots[11]);
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 6, 12, 0, 9, 0, 9, 0, 9, 0, 9, 0, 9, 0, 9), ADDRESS, 0x90,
           MODBUS_ILLEGAL_ADDRESS); /* the third one is read-only */
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 4, 8, 0, 9, 0, 9, 0, 0, 0, 99), ADDRESS, 0x90, MODBUS_FAILURE);
    EXPECT(ASK(ADDRESS, 16, 0, 21, 0, 2, 4, 0, 9, 0, 9), ADDRESS, 0x90, MODBUS_ILLEGAL_ADDRESS);
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 1, 2, 0, 9), ADDRESS, 0x90, MODBUS_ILLEGAL_ADDRESS);
    TEST_ASSERT_EQUAL_HEX32(0x00010002u, slots[10]);
    TEST_ASSERT_EQUAL_HEX32(0x00030004u, slots[11]);
}

static void test_a_single_register_writes_a_whole_value_with_its_sign(void)
{
    EXPECT(ASK(ADDRESS, 6, 0, 21, 0x12, 0x34), ADDRESS, 6, 0, 21, 0x12, 0x34);
    TEST_ASSERT_EQUAL_HEX32(0x1234u, slots[10]);
    EXPECT(ASK(ADDRESS, 6, 0, 23, 0xFF, 0xFE), ADDRESS, 6, 0, 23, 0xFF, 0xFE);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFEu, slots[11]);
    /* The upper half of a value. */
    EXPECT(ASK(ADDRESS, 6, 0, 20, 0, 1), ADDRESS, 0x86, MODBUS_ILLEGAL_ADDRESS);
    EXPECT(ASK(ADDRESS, 6, 0, 27, 0, 1), ADDRESS, 0x86, MODBUS_ILLEGAL_ADDRESS); /* half of a float */
    EXPECT(ASK(ADDRESS, 6, 0, 25, 0, 1), ADDRESS, 0x86, MODBUS_ILLEGAL_ADDRESS); /* a read-only row */
    TEST_ASSERT_EQUAL_HEX32(0x3FC00000u, slots[13]);
}

static void test_a_request_of_a_wrong_length_is_refused(void)
{
    EXPECT(ASK(ADDRESS, 3, 0, 20, 0), ADDRESS, 0x83, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 3, 0, 20, 0, 2, 0), ADDRESS, 0x83, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 6, 0, 21, 0), ADDRESS, 0x86, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 2), ADDRESS, 0x90, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 2, 4, 0, 1, 0), ADDRESS, 0x90, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 2, 3, 0, 1, 0, 2), ADDRESS, 0x90, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 16, 0, 20, 0, 0, 0), ADDRESS, 0x90, MODBUS_ILLEGAL_VALUE);
    EXPECT(ASK(ADDRESS, 3), ADDRESS, 0x83, MODBUS_ILLEGAL_VALUE);
    TEST_ASSERT_EQUAL_HEX32(0x12345678u, slots[10]);
    TEST_ASSERT_EQUAL_UINT32(0u, modbus.errors);
}

/* The request has 123 registers, the largest number of the standard, which this server does not accept: it
 * checks the CRC nevertheless. */
static void test_the_longest_frame_of_the_standard_is_answered_and_a_longer_one_is_not(void)
{
    uint16_t frame[300] = {ADDRESS, 16, 0, 20, 0, 123, 246};
    EXPECT(ask(frame, 253u), ADDRESS, 0x90, MODBUS_ILLEGAL_VALUE);
    expect_silence(ask(frame, MODBUS_FRAME_MAX - 1u), 1u);
    expect_silence(ask(frame, 300u), 1u);
}

static void test_other_functions_are_refused_and_answers_of_others_ignored(void)
{
    EXPECT(ASK(ADDRESS, 0), ADDRESS, 0x80, MODBUS_ILLEGAL_FUNCTION);
    EXPECT(ASK(ADDRESS, 1, 0, 0, 0, 1), ADDRESS, 0x81, MODBUS_ILLEGAL_FUNCTION);
    EXPECT(ASK(ADDRESS, 0x2B, 14, 1, 0), ADDRESS, 0xAB, MODBUS_ILLEGAL_FUNCTION);
    expect_silence(ASK(ADDRESS, 0x83, 2), 0u);
    expect_silence(ASK(ADDRESS + 1u, 3, 0, 20, 0, 2), 0u);
}

static void test_a_broadcast_writes_without_an_answer_and_does_not_read(void)
{
    const modbus_result_t result = ASK(MODBUS_BROADCAST, 6, 0, 21, 0, 7);
    TEST_ASSERT_TRUE(result.heard);
    TEST_ASSERT_EQUAL_UINT32(0u, result.count);
    TEST_ASSERT_EQUAL_HEX32(7u, slots[10]);
    expect_silence(ASK(MODBUS_BROADCAST, 3, 0, 20, 0, 2), 0u);
}

static void test_a_frame_ends_with_the_gap_and_not_before(void)
{
    static const uint16_t request[] = {ADDRESS, 3, 0, 20, 0, 2};
    const uint32_t crc = remainder_of(request, 6u);
    const uint16_t tail[2] = {(uint16_t)(crc & 0xFFu), (uint16_t)(crc >> 8)};
    now = 0xFFFFFFF0u; /* the count of periods wraps during this time */
    take(request, 6u);
    expect_silence(after(GAP - 1u), 0u); /* a pause within the frame */
    take(tail, 2u);
    expect_silence(after(GAP - 1u), 0u);
    TEST_ASSERT_TRUE(after(1u).heard);
    expect_silence(after(1000u), 0u);
    take(request, 6u); /* a pause that is too long separates two frames, neither of which is valid */
    expect_silence(after(GAP), 1u);
    take(tail, 2u);
    expect_silence(after(GAP), 1u);
}

static void test_lost_octets_invalidate_the_frame_and_not_the_next_one(void)
{
    modbus_broken(&modbus, now);
    expect_silence(ASK(ADDRESS, 6, 0, 21, 0, 7), 1u);
    TEST_ASSERT_EQUAL_HEX32(0x12345678u, slots[10]);
    EXPECT(ASK(ADDRESS, 6, 0, 21, 0, 7), ADDRESS, 6, 0, 21, 0, 7);
}

/* Every bit, and every pair of bits, of a write of 13 octets is wrong. An odd number of wrong bits is
 * always detected, since x + 1 divides the polynomial. */
static void test_no_write_with_one_or_two_wrong_bits_acts(void)
{
    uint16_t frame[13] = {ADDRESS, 16, 0, 20, 0, 2, 4, 0, 1, 0, 2};
    const uint32_t crc = remainder_of(frame, 11u);
    frame[11] = (uint16_t)(crc & 0xFFu);
    frame[12] = (uint16_t)(crc >> 8);
    for (uint32_t a = 0; a < 104u; a++) {
        for (uint32_t b = a; b < 104u; b++) {
            frame[a / 8u] ^= (uint16_t)(1u << a % 8u);
            frame[b / 8u] ^= (uint16_t)(a == b ? 0u : 1u << b % 8u);
            take(frame, 13u);
            expect_silence(after(GAP), 1u);
            frame[a / 8u] ^= (uint16_t)(1u << a % 8u);
            frame[b / 8u] ^= (uint16_t)(a == b ? 0u : 1u << b % 8u);
        }
    }
    TEST_ASSERT_EQUAL_HEX32(0x12345678u, slots[10]);
    take(frame, 13u);
    EXPECT(after(GAP), ADDRESS, 16, 0, 20, 0, 2);
}

static void test_upper_bits_of_a_word_are_not_used(void)
{
    EXPECT(ASK(0xAB00u | ADDRESS, 6, 0, 0x1200u | 21u, 0, 7), ADDRESS, 6, 0, 21, 0, 7);
}

/* 3.5 characters of 11 bits at 9600 bit/s are 4.0104 ms; above 19200 bit/s the standard recommends 1.75
 * ms. */
static void test_the_gap_follows_the_rate(void)
{
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 4.0104167e-3f, modbus_gap(9600.0f));
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 2.0052083e-3f, modbus_gap(19200.0f));
    TEST_ASSERT_FLOAT_WITHIN(1e-9f, 1.75e-3f, modbus_gap(115200.0f));
}
