/* CRC-32, compared with its published check value and with a long division bit by bit. */
#include "math/crc.h"

#include <unity.h>

static uint32_t of_words(const uint16_t *words, uint32_t count)
{
    uint32_t crc = CRC_BEGIN;
    for (uint32_t n = 0; n < count; n++) {
        crc = crc_add(crc, words[n]);
    }
    return crc_end(crc);
}

/* The division by the polynomial as on paper, each octet from its lowest bit. */
static uint32_t by_division(const uint16_t *words, uint32_t count)
{
    uint32_t crc = UINT32_C(0xFFFFFFFF);
    for (uint32_t bit = 0; bit < 16u * count; bit++) {
        const uint32_t in = (uint32_t)words[bit / 16u] >> bit % 16u & 1u;
        const uint32_t out = (crc ^ in) & 1u;
        crc = crc >> 1 ^ (out != 0u ? UINT32_C(0xEDB88320) : 0u);
    }
    return ~crc;
}

/* The check value in the catalogue belongs to the nine octets "123456789"; for the first eight it is
 * 9AE0DAAFh. */
static void test_a_known_message_has_its_known_check(void)
{
    static const uint16_t digits[] = {0x3231, 0x3433, 0x3635, 0x3837};
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x9AE0DAAF), of_words(digits, 4u));
    TEST_ASSERT_EQUAL_HEX32(0u, of_words(digits, 0u));
}

static void test_it_is_the_remainder_of_the_division(void)
{
    uint16_t words[40];
    uint32_t random = 1u;
    for (uint32_t n = 0; n < 40u; n++) {
        random = random * UINT32_C(1664525) + UINT32_C(1013904223);
        words[n] = (uint16_t)(random >> 16);
        TEST_ASSERT_EQUAL_HEX32(by_division(words, n + 1u), of_words(words, n + 1u));
    }
}
