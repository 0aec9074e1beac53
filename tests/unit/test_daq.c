/* The queue between interrupt and background: the samples that it keeps and loses, and that each sample that
 * it returns is complete. */
#include "talk/daq.h"

#include "tests/unit/compare.h"

#define SLOTS 20u

static daq_t daq;
static uint32_t source[SLOTS];
static uint16_t packet[5u + 4u * DAQ_ENTRIES];

void setUp(void)
{
    memset(&daq, 0, sizeof daq);
    daq_clear(&daq);
}

static uint32_t word_at(const uint16_t *octets)
{
    return (uint32_t)octets[0] | (uint32_t)octets[1] << 8 | (uint32_t)octets[2] << 16 |
           (uint32_t)octets[3] << 24;
}

/* Every slot in every period has another value. */
static uint32_t value_of(uint32_t period, uint32_t slot)
{
    return (period * SLOTS + slot) * UINT32_C(2654435761);
}

static void sample(uint32_t period)
{
    for (uint32_t n = 0; n < SLOTS; n++) {
        source[n] = value_of(period, n);
    }
    daq_sample(&daq, source, period);
}

/* Allocates one list with one ODT that has these slots of the source. */
static void list_of(uint32_t list, const uint32_t *slots, uint32_t count)
{
    TEST_ASSERT_EQUAL(DAQ_DONE, daq_alloc_entries(&daq, list, 0u, count));
    for (uint32_t n = 0; n < count; n++) {
        TEST_ASSERT_EQUAL(DAQ_DONE, daq_write(&daq, list, 0u, n, slots[n] * (uint32_t)sizeof source[0]));
    }
}

static void make(uint32_t lists)
{
    TEST_ASSERT_EQUAL(DAQ_DONE, daq_alloc_lists(&daq, lists));
    for (uint32_t n = 0; n < lists; n++) {
        TEST_ASSERT_EQUAL(DAQ_DONE, daq_alloc_odts(&daq, n, 1u));
    }
}

static void expect_sample(uint32_t odt, uint32_t period, const uint32_t *slots, uint32_t count)
{
    TEST_ASSERT_EQUAL_UINT32(5u + 4u * count, daq_next(&daq, daq.put, packet));
    TEST_ASSERT_EQUAL_UINT32(odt, packet[0]);
    TEST_ASSERT_EQUAL_UINT32(period, word_at(packet + 1));
    for (uint32_t n = 0; n < count; n++) {
        TEST_ASSERT_EQUAL_HEX32(value_of(period, slots[n]), word_at(packet + 5u + 4u * n));
    }
}

static const uint32_t chosen[DAQ_ENTRIES] = {19, 0, 7, 3, 14, 1, 10, 2, 12, 5, 4, 8, 18, 17, 16, 15};

static void test_a_sample_is_the_slots_of_its_period(void)
{
    make(1u);
    list_of(0u, chosen, DAQ_ENTRIES);
    TEST_ASSERT_EQUAL(DAQ_DONE, daq_start(&daq, 1u));
    for (uint32_t period = UINT32_MAX - 50u; period != 50u; period++) {
        sample(period);
        expect_sample(0u, period, chosen, DAQ_ENTRIES);
        TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, packet));
    }
    TEST_ASSERT_EQUAL_UINT32(0u, daq.lost);
}

/* Up to DAQ_CELLS samples wait. One sample more is lost, but no other, and the overload is reported once. */
static void test_a_full_queue_loses_whole_samples_and_counts_them(void)
{
    make(1u);
    list_of(0u, chosen, 3u);
    (void)daq_start(&daq, 1u);
    for (uint32_t period = 0u; period < DAQ_CELLS; period++) {
        sample(period);
    }
    TEST_ASSERT_FALSE(daq_overloaded(&daq, daq.lost));
    sample(DAQ_CELLS);
    sample(DAQ_CELLS + 1u);
    TEST_ASSERT_EQUAL_UINT32(2u, daq.lost);
    TEST_ASSERT_TRUE(daq_overloaded(&daq, daq.lost));
    TEST_ASSERT_FALSE(daq_overloaded(&daq, daq.lost));
    expect_sample(0u, 0u, chosen, 3u);
    sample(DAQ_CELLS + 2u); /* there is room again */
    for (uint32_t period = 1u; period < DAQ_CELLS; period++) {
        expect_sample(0u, period, chosen, 3u);
    }
    expect_sample(0u, DAQ_CELLS + 2u, chosen, 3u);
    TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, packet));
    TEST_ASSERT_EQUAL_UINT32(2u, daq.lost);
}

/* A sample whose first packet has been taken keeps its place in the queue until its last packet has been
 * taken. */
static void test_a_sample_of_two_packets_is_not_torn(void)
{
    TEST_ASSERT_EQUAL(DAQ_DONE, daq_alloc_lists(&daq, 1u));
    TEST_ASSERT_EQUAL(DAQ_DONE, daq_alloc_odts(&daq, 0u, 2u));
    for (uint32_t odt = 0u; odt < 2u; odt++) {
        TEST_ASSERT_EQUAL(DAQ_DONE, daq_alloc_entries(&daq, 0u, odt, 1u));
        TEST_ASSERT_EQUAL(DAQ_DONE, daq_write(&daq, 0u, odt, 0u, odt * (uint32_t)sizeof source[0]));
    }
    (void)daq_start(&daq, 1u);
    sample(7u);
    TEST_ASSERT_EQUAL_UINT32(9u, daq_next(&daq, daq.put, packet));
    for (uint32_t period = 8u; period < 8u + DAQ_CELLS; period++) {
        sample(period);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, daq.lost); /* one place of the queue was still occupied */
    TEST_ASSERT_EQUAL_UINT32(5u, daq_next(&daq, daq.put, packet));
    TEST_ASSERT_EQUAL_UINT32(1u, packet[0]);
    TEST_ASSERT_EQUAL_HEX32(value_of(7u, 1u), word_at(packet + 1));
}

static void test_lists_of_different_rates_keep_their_order(void)
{
    make(2u);
    list_of(0u, chosen, 2u);
    list_of(1u, chosen + 2, 5u);
    TEST_ASSERT_EQUAL(DAQ_DONE, daq_set_prescaler(&daq, 1u, 255u));
    (void)daq_start(&daq, 3u);
    for (uint32_t period = 0u; period <= 510u; period++) {
        sample(period);
        expect_sample(0u, period, chosen, 2u);
        if (period % 255u == 0u) {
            expect_sample(1u, period, chosen + 2, 5u);
        }
        TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, packet));
    }
}

static void test_limits_of_the_requests(void)
{
    make(1u);
    TEST_ASSERT_EQUAL(DAQ_OUT_OF_RANGE, daq_set_prescaler(&daq, 0u, 256u));
    TEST_ASSERT_EQUAL(DAQ_OUT_OF_RANGE, daq_set_prescaler(&daq, 1u, 1u));
    TEST_ASSERT_EQUAL(DAQ_DONE, daq_set_prescaler(&daq, 0u, 0u));
    TEST_ASSERT_EQUAL_UINT32(1u, daq.list[0].prescaler);
    TEST_ASSERT_EQUAL(DAQ_OUT_OF_RANGE, daq_select(&daq, 1u));
    TEST_ASSERT_EQUAL(DAQ_OUT_OF_RANGE, daq_write(&daq, 0u, 0u, 0u, 0u));
    TEST_ASSERT_EQUAL(DAQ_INCOMPLETE, daq_start(&daq, 1u)); /* a list without entries */
    TEST_ASSERT_EQUAL(DAQ_OUT_OF_RANGE, daq_start(&daq, 2u));
}

static void test_clearing_keeps_the_count_of_the_lost(void)
{
    make(1u);
    list_of(0u, chosen, 1u);
    (void)daq_start(&daq, 1u);
    for (uint32_t period = 0u; period < DAQ_CELLS + 3u; period++) {
        sample(period);
    }
    daq_clear(&daq);
    TEST_ASSERT_EQUAL_UINT32(3u, daq.lost);
    TEST_ASSERT_FALSE(daq_overloaded(&daq, daq.lost));
    TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, packet));
    sample(1u);
    TEST_ASSERT_EQUAL_UINT32(0u, daq_next(&daq, daq.put, packet));
}
