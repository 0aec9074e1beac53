/* Compares the fast path for the plain carrier with the general engine, and averages with edges. AQCTLB =
 * 0x0090 selects the general engine: output B of the action qualifier reaches no pin, because the dead
 * band uses output A, but the set-up is no longer the plain one. */
#include <string.h>
#include <unity.h>

#include "bench.h"

#define LEGS 3u

static uint64_t start;
static uint32_t random_state;
static edge_t kept[BENCH_EDGES];

void setUp(void)
{
    bench_power_on();
    random_state = 12345u;
}

static uint32_t random_below(uint32_t n)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)random_state * n) >> 32);
}

/* Random compare values, among which the corners of the range are frequent. */
static uint16_t random_compare(void)
{
    static const uint16_t corner[] = {0u,    1u,    2u,    224u,  225u,  226u,  449u,  450u,  451u, 7049u,
                                      7050u, 7274u, 7275u, 7276u, 7498u, 7499u, 7500u, 7501u, 9000u};
    return random_below(2u) == 0u ? corner[random_below(sizeof corner / sizeof corner[0])]
                                  : (uint16_t)random_below(7501u);
}

static void next_compare(void)
{
    for (uint32_t leg = 0u; leg < LEGS; leg++) {
        bench_compare[leg] = random_compare();
    }
}

static void begin(bool plain, uint16_t dbctl, uint16_t red, uint16_t fed)
{
    setUp();
    bench_start(SKIP_TBCLKSYNC);
    for (uint32_t n = 1u; n <= LEGS; n++) {
        bus_write16(&EPWM(n)->AQCTLB, plain ? 0u : 0x0090u);
        bus_write16(&EPWM(n)->DBCTL, dbctl);
        bus_write16(&EPWM(n)->DBRED, red);
        bus_write16(&EPWM(n)->DBFED, fed);
    }
    bench_in_interrupt = next_compare;
    bench_forget();
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    start = chip_now(&bench_chip);
}

static void same_edges(uint16_t dbctl, uint16_t red, uint16_t fed)
{
    begin(false, dbctl, red, fed);
    chip_run(start + 2000u * CARRIER + 77u);
    TEST_ASSERT_FALSE(chip_carrier_plain(&bench_chip));
    uint32_t count = bench.edges;
    memcpy(kept, bench.edge, sizeof kept);
    begin(true, dbctl, red, fed);
    chip_run(start + 2000u * CARRIER + 77u);
    TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
    TEST_ASSERT_TRUE_MESSAGE(count > 1000u, "too few edges for a comparison");
    TEST_ASSERT_EQUAL_UINT32(count, bench.edges);
    TEST_ASSERT_EQUAL_MEMORY(kept, bench.edge, count * sizeof(edge_t));
    TEST_ASSERT_EQUAL_UINT32(0u, bench.out_of_order);
}

static void test_fast_path_and_general_engine_give_the_same_edges(void)
{
    same_edges(0x000Bu, 450u, 450u);
}

static void test_same_edges_with_other_dead_bands_and_polarities(void)
{
    same_edges(0x0007u, 300u, 375u);
    same_edges(0x0003u, 1023u, 1023u);
    same_edges(0x000Fu, 0u, 450u);
    same_edges(0x000Bu, 1u, 0u);
}

/* The edges of one leg in one period, calculated by hand. The leg falls at CMPA and rises at 15000 - CMPA;
 * every rising edge is delayed by 450. */
static void test_edges_are_where_the_formula_puts_them(void)
{
    bench_compare[0] = 3000u;
    bench_compare[1] = 3750u;
    bench_compare[2] = 5000u;
    bench_start(SKIP_TBCLKSYNC);
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    uint64_t zero = chip_now(&bench_chip) + 2u * CARRIER;
    chip_run(zero);
    bench_forget();
    chip_run(zero + CARRIER);
    static const struct {
        uint32_t tick, level;
    } expected[] = {{3000u, 0x14u},  {3450u, 0x16u},  {3750u, 0x12u},  {4200u, 0x1Au},
                    {5000u, 0x0Au},  {5450u, 0x2Au},  {10000u, 0x0Au}, {10450u, 0x1Au},
                    {11250u, 0x12u}, {11700u, 0x16u}, {12000u, 0x14u}, {12450u, 0x15u}};
    TEST_ASSERT_EQUAL_UINT32(12u, bench.edges);
    for (uint32_t i = 0u; i < 12u; i++) {
        TEST_ASSERT_EQUAL_UINT64(zero + expected[i].tick, bench.edge[i].tick);
        TEST_ASSERT_EQUAL_HEX32(expected[i].level, bench.edge[i].level);
        TEST_ASSERT_EQUAL_HEX32(0x3Fu, bench.edge[i].driven);
    }
}

static void test_never_both_gates_of_a_leg(void)
{
    begin(true, 0x000Bu, 450u, 450u);
    chip_run(start + 400u * CARRIER);
    TEST_ASSERT_TRUE_MESSAGE(bench.edges > 1000u, "too few edges");
    for (uint32_t i = 0u; i < bench.edges; i++) {
        uint32_t level = bench.edge[i].level;
        TEST_ASSERT_EQUAL_HEX32(0u, level & (level >> 1) & 0x15u);
    }
}

/* Sum over the edges of a carrier period: pin A is high for high - dead, pin B for period - high - dead.
 * This does not hold if the leg does not switch or if a pulse is shorter than the dead band; the compare
 * values avoid these cases. */
static void wide_compare(void)
{
    for (uint32_t leg = 0u; leg < LEGS; leg++) {
        bench_compare[leg] = (uint16_t)(451u + random_below(7500u - 902u));
    }
}

static void test_averaged_high_times_are_the_sum_over_edges(void)
{
    static uint64_t high[200][6];
    static uint64_t begins_high[200];
    begin(true, 0x000Bu, 450u, 450u);
    bench_in_interrupt = wide_compare;
    chip_run(start + 200u * CARRIER);
    for (uint32_t k = 0u; k < 200u; k++) {
        for (uint32_t pin = 0u; pin < 6u; pin++) {
            high[k][pin] =
                bench_high_of(pin, start + k * (uint64_t)CARRIER, start + (k + 1u) * (uint64_t)CARRIER);
        }
        begins_high[k] = bench_high_of(0u, start + k * (uint64_t)CARRIER, start + k * (uint64_t)CARRIER + 1u);
    }
    begin(true, 0x000Bu, 450u, 450u);
    bench_in_interrupt = wide_compare;
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 200u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(200u, bench.averages);
    for (uint32_t k = 0u; k < 200u; k++) {
        TEST_ASSERT_EQUAL_UINT64(start + k * (uint64_t)CARRIER, bench.average[k].tick);
        TEST_ASSERT_EQUAL_UINT32(CARRIER, bench.average[k].period);
        TEST_ASSERT_EQUAL_UINT32(450u, bench.average[k].dead);
        TEST_ASSERT_TRUE(k < 2u || bench.average[k].ends == (begins_high[k] != 0u));
        /* In the first periods all pins are low at the start. */
        for (uint32_t leg = 0u; leg < LEGS && k >= 2u; leg++) {
            uint32_t a = bench.average[k].high[leg];
            TEST_ASSERT_EQUAL_UINT64(a - 450u, high[k][2u * leg]);
            TEST_ASSERT_EQUAL_UINT64(CARRIER - a - 450u, high[k][2u * leg + 1u]);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0u, bench.edges);
}

static void test_averaged_high_times_at_the_limits(void)
{
    static const uint16_t compare[] = {1u, 7499u, 7500u, 7501u};
    static const uint32_t high[] = {2u, 14998u, 15000u, 15000u};
    for (uint32_t i = 0u; i < 4u; i++) {
        begin(true, 0x000Bu, 450u, 450u);
        bench_in_interrupt = NULL;
        chip_set_averaged(&bench_chip, true);
        bench_compare[0] = compare[i];
        chip_run(start + 6u * CARRIER);
        TEST_ASSERT_EQUAL_UINT32(high[i], bench.average[bench.averages - 1u].high[0]);
    }
    begin(true, 0x000Bu, 450u, 450u);
    bench_in_interrupt = NULL;
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 3u * CARRIER);
    bench_compare[0] = 0u; /* written in the period that begins at 3, loaded at 4, acts until 5 */
    chip_run(start + 7u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(7500u, bench.average[3].high[0]);
    TEST_ASSERT_EQUAL_UINT32(15000u, bench.average[4].high[0]);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.average[5].high[0]);
}

/* Random changes between averages and edges must change neither the visible edges nor the internal state. */
static void test_averaged_periods_leave_the_right_state_behind(void)
{
    begin(true, 0x000Bu, 450u, 450u);
    chip_run(start + 300u * CARRIER);
    uint32_t count = bench.edges;
    memcpy(kept, bench.edge, sizeof kept);
    begin(true, 0x000Bu, 450u, 450u);
    for (uint32_t k = 0u; k < 100u; k++) {
        chip_set_averaged(&bench_chip, k % 2u == 0u);
        chip_run(start + (3u * k + 3u) * (uint64_t)CARRIER);
    }
    TEST_ASSERT_TRUE_MESSAGE(bench.averages > 100u && bench.edges > 500u, "both modes must have run");
    uint32_t compared = 0u;
    uint32_t j = 0u;
    for (uint32_t i = 0u; i < bench.edges; i++) {
        while (j + 1u < count && kept[j + 1u].tick <= bench.edge[i].tick) {
            j++;
        }
        if (j < count &&
            kept[j].tick <= bench.edge[i].tick) { /* the level at this tick in the run without averages */
            TEST_ASSERT_EQUAL_HEX32(kept[j].level, bench.edge[i].level);
            compared += kept[j].tick == bench.edge[i].tick;
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(compared > 500u, "too few common edges");
}

static void test_unplain_legs_are_reported_by_edges_in_averaged_mode(void)
{
    begin(false, 0x000Bu, 450u, 450u);
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 20u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.averages);
    TEST_ASSERT_TRUE_MESSAGE(bench.edges > 50u, "edges expected");
    begin(true, 0x0007u, 450u, 450u); /* active low complementary: the average does not describe this mode */
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 20u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.averages);
    begin(true, 0x000Bu, 450u, 451u); /* the two dead bands differ */
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 20u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.averages);
}

static void test_trip_in_an_averaged_period_shows_at_once(void)
{
    begin(true, 0x000Bu, 450u, 450u);
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 5u * CARRIER + 4000u);
    bench_forget();
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
    TEST_ASSERT_EQUAL_UINT64(start + 5u * CARRIER + 4000u, bench.edge[0].tick);
    TEST_ASSERT_EQUAL_HEX32(0u, bench.edge[0].level);
    chip_run(start + 8u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.averages);
    TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
}

static void trip_and_release(bool plain, uint32_t phase)
{
    begin(plain, 0x000Bu, 450u, 450u);
    chip_set_pin(&bench_chip, 12u, false);
    chip_run(start + 5u * CARRIER + phase);
    chip_set_pin(&bench_chip, 12u, true);
    bench_forget();
    bus_allow();
    for (uint32_t n = 1u; n <= LEGS; n++) {
        bus_write16(&EPWM(n)->TZCLR, TZ_OST | TZ_INT);
    }
    bus_protect();
    chip_run(start + 9u * CARRIER);
}

static void test_release_in_the_middle_of_a_period_shows_the_true_state(void)
{
    for (uint32_t phase = 0u; phase < CARRIER; phase += 61u) {
        trip_and_release(false, phase);
        uint32_t count = bench.edges;
        memcpy(kept, bench.edge, sizeof kept);
        trip_and_release(true, phase);
        TEST_ASSERT_TRUE_MESSAGE(count > 20u, "edges expected");
        TEST_ASSERT_EQUAL_UINT32(count, bench.edges);
        TEST_ASSERT_EQUAL_MEMORY(kept, bench.edge, count * sizeof(edge_t));
    }
}

/* The release is written exactly at the tick of an edge: the pins show the level after this edge. */
static void test_release_at_the_tick_of_an_edge(void)
{
    bench_start(0u);
    start = chip_now(&bench_chip);
    chip_set_pin(&bench_chip, 12u, false);
    chip_run(start + 5u * CARRIER + 3750u + 450u); /* at this tick the lower gates turn on */
    chip_set_pin(&bench_chip, 12u, true);
    bench_forget();
    bench_allowed16(&EPWM(1u)->TZCLR, TZ_OST | TZ_INT);
    TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
    TEST_ASSERT_EQUAL_HEX32(2u, bench.edge[0].level);
}

/* A write that ends the plain set-up in the middle of a period whose edges nobody has read. */
static void test_leaving_the_plain_set_up_in_an_averaged_period(void)
{
    for (uint32_t phase = 0u; phase < CARRIER; phase += 611u) {
        begin(false, 0x000Bu, 450u, 450u);
        chip_run(start + 9u * CARRIER);
        uint32_t count = bench.edges;
        memcpy(kept, bench.edge, sizeof kept);
        begin(true, 0x000Bu, 450u, 450u);
        chip_set_averaged(&bench_chip, true);
        uint64_t left = start + 4u * CARRIER + phase;
        chip_run(left);
        bus_write16(&EPWM(1u)->AQCTLB, 0x0090u);
        chip_run(start + 9u * CARRIER);
        uint32_t i = 0u;
        while (i < count && kept[i].tick <= left) {
            i++;
        }
        TEST_ASSERT_TRUE_MESSAGE(i > 0u && bench.edges > 10u, "edges expected");
        TEST_ASSERT_EQUAL_UINT64(left, bench.edge[0].tick);
        TEST_ASSERT_EQUAL_HEX32(kept[i - 1u].level, bench.edge[0].level);
        TEST_ASSERT_EQUAL_UINT32(count - i, bench.edges - 1u);
        TEST_ASSERT_EQUAL_MEMORY(&kept[i], &bench.edge[1], (count - i) * sizeof(edge_t));
    }
}

/* After the clock has stopped no edge follows, so that the stop itself must end the average. */
static void test_stopped_clock_in_an_averaged_period_shows_the_levels(void)
{
    begin(true, 0x000Bu, 450u, 450u);
    bench_in_interrupt = NULL;
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 5u * CARRIER + 6000u);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.edges);
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC);
    TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
    TEST_ASSERT_EQUAL_UINT64(start + 5u * CARRIER + 6000u, bench.edge[0].tick);
    TEST_ASSERT_EQUAL_HEX32(0x2Au, bench.edge[0].level);
}

static void test_change_of_dead_band_while_running(void)
{
    for (uint32_t plain = 0u; plain < 2u; plain++) {
        begin(plain != 0u, 0x000Bu, 450u, 450u);
        for (uint32_t k = 1u; k <= 30u; k++) {
            chip_run(start + k * 10007u);
            for (uint32_t n = 1u; n <= LEGS; n++) {
                bus_write16(&EPWM(n)->DBRED, (uint16_t)(300u + k));
                bus_write16(&EPWM(n)->DBFED, (uint16_t)(300u + k));
            }
        }
        if (plain == 0u) {
            memcpy(kept, bench.edge, sizeof kept);
            continue;
        }
        TEST_ASSERT_TRUE_MESSAGE(bench.edges > 100u, "edges expected");
        TEST_ASSERT_EQUAL_MEMORY(kept, bench.edge, bench.edges * sizeof(edge_t));
    }
}

static void test_copy_runs_identically(void)
{
    static chip_t copy;
    static chip_t end;
    for (uint32_t averaged = 0u; averaged < 2u; averaged++) {
        begin(true, 0x000Bu, 450u, 450u);
        chip_set_averaged(&bench_chip, averaged != 0u);
        chip_run(start + 20u * CARRIER + 12345u);
        uint32_t seed = random_state;
        uint16_t compare[3] = {bench_compare[0], bench_compare[1], bench_compare[2]};
        memcpy(&copy, &bench_chip, sizeof copy);
        chip_run(start + 60u * CARRIER + 999u);
        memcpy(&end, &bench_chip, sizeof end);
        memcpy(&bench_chip, &copy, sizeof copy);
        random_state = seed;
        memcpy(bench_compare, compare, sizeof compare);
        bench.last_tick = 0u;
        chip_run(start + 60u * CARRIER + 999u);
        TEST_ASSERT_EQUAL_MEMORY(&end, &bench_chip, sizeof end);
    }
}

static void test_runs_in_pieces_as_in_one(void)
{
    static chip_t whole;
    begin(true, 0x000Bu, 450u, 450u);
    chip_run(start + 40u * CARRIER);
    memcpy(&whole, &bench_chip, sizeof whole);
    begin(true, 0x000Bu, 450u, 450u);
    for (uint64_t t = start; t < start + 40u * CARRIER; t += 98u) {
        chip_run(t);
    }
    chip_run(start + 40u * CARRIER);
    whole.limit = bench_chip.limit; /* a value that only the last search used */
    TEST_ASSERT_EQUAL_MEMORY(&whole, &bench_chip, sizeof whole);
}

static uint64_t pull_at;
static bool pulled;

/* The board pulls the trip pin low in the first callback at or after pull_at. */
static void pull(uint64_t tick, bool analog)
{
    (void)analog;
    if (tick == pull_at && !pulled) {
        pulled = true;
        chip_set_pin(&bench_chip, 12u, false);
    }
}

static void trip_does_nothing(void)
{
    bus_allow();
    for (uint32_t n = 1u; n <= LEGS; n++) {
        bus_write16(&EPWM(n)->TZCTL, 0x000Fu);
    }
    bus_protect();
}

static void test_pin_pulled_in_a_conversion_brings_the_edges_back_in_order(void)
{
    begin(true, 0x000Bu, 10u, 10u);
    bench_in_interrupt = NULL;
    bench_compare[0] = 20u; /* the leg falls between the sample windows at zero and at zero + 42 */
    trip_does_nothing();
    chip_set_averaged(&bench_chip, true);
    chip_run(start + 5u * CARRIER - 1000u);
    bench_forget();
    pulled = false;
    pull_at = start + 5u * CARRIER;
    bench_on_world = pull;
    chip_run(start + 5u * CARRIER + 1000u);
    TEST_ASSERT_TRUE(pulled);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.out_of_order);
    TEST_ASSERT_EQUAL_UINT64(start + 5u * CARRIER, bench.edge[0].tick);
    TEST_ASSERT_EQUAL_HEX32(0x15u, bench.edge[0].level);
    TEST_ASSERT_EQUAL_UINT64(start + 5u * CARRIER + 20u, bench.edge[1].tick);
    TEST_ASSERT_EQUAL_HEX32(0x14u, bench.edge[1].level);
}

static uint64_t tripped_at;

static void on_trip(void)
{
    tripped_at = chip_now(&bench_chip);
    bus_write16(&PIE->PIEACK, 2u);
}

static void test_pin_pulled_at_an_edge_interrupts_in_time(void)
{
    begin(true, 0x000Bu, 450u, 450u);
    bench_in_interrupt = NULL;
    bench_compare[0] = 3000u;
    bench_compare[1] = 3005u;
    bench_compare[2] = 3100u;
    trip_does_nothing();
    bus_allow();
    bus_write16(&EPWM(1u)->TZEINT, TZ_OST);
    bus_write32(&PIE_VECTORS->vector[PIE_EPWM1_TZ], bus_vector(on_trip));
    bus_protect();
    bus_write16(&PIE->group[1].IER, 1u);
    bus_enable_group(2u);
    chip_run(start + 5u * CARRIER);
    pulled = false;
    pull_at = start + 5u * CARRIER + 3000u;
    bench_on_world = pull;
    chip_run(start + 6u * CARRIER);
    TEST_ASSERT_TRUE(pulled);
    TEST_ASSERT_EQUAL_UINT64(pull_at + 14u, tripped_at);
}

static void test_carrier_tick_is_the_last_zero(void)
{
    begin(true, 0x000Bu, 450u, 450u);
    chip_run(start + 7u * CARRIER + 1u);
    TEST_ASSERT_EQUAL_UINT64(start + 7u * CARRIER, chip_carrier_tick(&bench_chip));
    begin(false, 0x000Bu, 450u, 450u);
    chip_run(start + 7u * CARRIER);
    TEST_ASSERT_EQUAL_UINT64(start + 6u * CARRIER, chip_carrier_tick(&bench_chip));
}
