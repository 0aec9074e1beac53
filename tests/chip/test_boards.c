/* Boards that differ in crystal and SYSCLK, in their legs (on ePWM4..6), in the position of the upper
 * pulse (centred on the period match) or in the polarity of the gates (active low). As in test_carrier.c,
 * the fast path is compared with the general engine (AQCTLB = 0x0090 makes the chip use the general
 * engine), and averages are compared with edges; both are compared with the formula. */
#include <string.h>
#include <unity.h>

#include "bench.h"

#define LEGS        3u
#define ZERO_WORD   0x0090u /* output A is high while CTR < CMPA */
#define PERIOD_WORD 0x0060u /* output A is high while CTR >= CMPA */
#define AHC         0x000Bu
#define ALC         0x0007u

typedef struct {
    uint32_t crystal_hz; /* SYSCLK is this times 10 / 2 */
    uint32_t first;      /* number of the ePWM of the first leg */
    bool led;            /* ePWM1 counts too, before ePWM4 */
    uint16_t aqctla, dbctl, half, red, fed;
} board_t;

static board_t board;
static uint64_t start;
static uint32_t random_state;
static edge_t kept[BENCH_EDGES];
static sample_t kept_samples[BENCH_SAMPLES];

static uint32_t random_below(uint32_t n)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)random_state * n) >> 32);
}

/* Random compare values, among which the corners of the range are frequent. */
static void next_compare(void)
{
    const uint32_t p = board.half;
    const uint32_t d = board.red;
    const uint32_t corner[] = {0u,    1u,         2u,     d / 2u, d / 2u + 1u, d - 1u, d,          d + 1u,
                               p - d, p - d - 1u, p - 2u, p - 1u, p,           p + 1u, p - d / 2u, p + d};
    for (uint32_t leg = 0u; leg < LEGS; leg++) {
        bench_compare[leg] =
            (uint16_t)(random_below(2u) == 0u ? corner[random_below(sizeof corner / sizeof corner[0])]
                                              : random_below(p + 1u));
    }
}

static void set_up_leg(uint32_t n, bool plain)
{
    const bool leads = n == board.first && !board.led;
    bus_write16(&EPWM(n)->TBPRD, board.half);
    bus_write16(&EPWM(n)->TBPHS, leads ? 0u : 2u);
    bus_write16(&EPWM(n)->TBCTL, leads ? 0x4012u : 0x6006u);
    bus_write16(&EPWM(n)->CMPA, board.half / 2u);
    bus_write16(&EPWM(n)->CMPB, 87u);
    bus_write16(&EPWM(n)->AQCTLA, board.aqctla);
    bus_write16(&EPWM(n)->AQCTLB, plain ? 0u : 0x0090u);
    bus_write16(&EPWM(n)->DBRED, board.red);
    bus_write16(&EPWM(n)->DBFED, board.fed);
    bus_write16(&EPWM(n)->DBCTL, board.dbctl);
    bus_allow();
    bus_write16(&EPWM(n)->TZSEL, TZSEL_OSHT1);
    bus_write16(&EPWM(n)->TZCTL, board.dbctl == ALC ? 0x0005u : 0x000Au);
    bus_protect();
}

static void begin(const board_t *shape, bool plain)
{
    board = *shape;
    random_state = 12345u;
    bench_power_on_with(board.crystal_hz);
    bench_first_leg = board.first;
    bench_world.active_low = board.dbctl == ALC;
    bench_clock();
    bench_allowed16(&SYSCTRL->PCLKCR1, 0x003Fu);
    for (uint32_t leg = 0u; leg < LEGS; leg++) {
        bench_compare[leg] = board.half / 2u;
        set_up_leg(board.first + leg, plain);
    }
    if (board.led) {
        bus_write16(&EPWM(1u)->TBPRD, board.half);
        bus_write16(&EPWM(1u)->TBCTL, 0x4012u);
    }
    bench_allowed32(&GPIO_CONTROL(0u)->MUX1, 0x01000000u | (board.first == 1u ? 0x00000555u : 0x00555000u));
    bench_adc(SKIP_SOC);
    bus_write16(&EPWM(board.first)->ETSEL, ETSEL_SOCAEN | ETSEL_SOCASEL(ET_CMPB_DOWN));
    bus_write16(&EPWM(board.first)->ETPS, ETPS_SOCAPRD(1));
    bench_interrupts(0u);
    bench_in_interrupt = next_compare;
    bench_forget();
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    start = chip_now(&bench_chip);
}

/* One carrier period; it is a whole number of ticks at every SYSCLK of this test. */
static uint64_t period_ticks(void)
{
    return 2u * (uint64_t)board.half * 150000000u / (5u * board.crystal_hz);
}

static void run_periods(uint32_t n)
{
    chip_run(start + n * period_ticks());
}

static void same_events(const board_t *shape)
{
    begin(shape, false);
    run_periods(500u);
    TEST_ASSERT_FALSE(chip_carrier_plain(&bench_chip));
    uint32_t edges = bench.edges;
    uint32_t samples = bench.samples;
    uint64_t zero = chip_carrier_tick(&bench_chip);
    memcpy(kept, bench.edge, sizeof kept);
    memcpy(kept_samples, bench.sample, sizeof kept_samples);
    begin(shape, true);
    run_periods(500u);
    TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
    TEST_ASSERT_TRUE_MESSAGE(edges > 1000u && samples > 3900u, "too few events for a comparison");
    TEST_ASSERT_EQUAL_UINT32(edges, bench.edges);
    TEST_ASSERT_EQUAL_MEMORY(kept, bench.edge, edges * sizeof(edge_t));
    TEST_ASSERT_EQUAL_UINT32(samples, bench.samples);
    TEST_ASSERT_EQUAL_MEMORY(kept_samples, bench.sample, samples * sizeof(sample_t));
    TEST_ASSERT_EQUAL_UINT64(zero, chip_carrier_tick(&bench_chip));
    TEST_ASSERT_EQUAL_UINT32(0u, bench.out_of_order);
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(&bench_chip));
}

static void test_same_events_at_100_megahertz(void)
{
    same_events(&(board_t){20000000u, 1u, false, ZERO_WORD, AHC, 5000u, 300u, 300u});
    same_events(&(board_t){20000000u, 1u, false, ZERO_WORD, ALC, 4999u, 201u, 333u});
}

static void test_same_events_at_125_megahertz(void)
{
    same_events(&(board_t){25000000u, 1u, false, ZERO_WORD, AHC, 6250u, 250u, 251u});
}

static void test_same_events_centred_on_the_period_match(void)
{
    same_events(&(board_t){30000000u, 1u, false, PERIOD_WORD, AHC, 7500u, 450u, 450u});
    same_events(&(board_t){30000000u, 1u, false, PERIOD_WORD, ALC, 7500u, 300u, 375u});
    same_events(&(board_t){30000000u, 1u, false, PERIOD_WORD, 0x000Fu, 7500u, 1023u, 0u});
    same_events(&(board_t){20000000u, 1u, false, PERIOD_WORD, AHC, 5000u, 201u, 200u});
}

static void test_same_events_on_modules_4_to_6(void)
{
    same_events(&(board_t){30000000u, 4u, false, ZERO_WORD, AHC, 7500u, 450u, 450u});
    same_events(&(board_t){30000000u, 4u, true, ZERO_WORD, AHC, 7500u, 450u, 450u});
    same_events(&(board_t){20000000u, 4u, true, PERIOD_WORD, ALC, 5000u, 201u, 201u});
}

/* While the legs are tripped, no edge is visible; after the release the pins have the levels that the legs
 * have reached meanwhile. */
static void test_release_of_blind_legs_shows_the_true_state(void)
{
    const board_t shape = {20000000u, 4u, false, PERIOD_WORD, AHC, 5000u, 301u, 298u};
    for (uint32_t phase = 0u; phase < 15000u; phase += 613u) {
        uint32_t count = 0u;
        for (uint32_t plain = 0u; plain < 2u; plain++) {
            begin(&shape, plain != 0u);
            chip_set_pin(&bench_chip, 12u, false);
            chip_run(start + 7u * period_ticks() + phase);
            chip_set_pin(&bench_chip, 12u, true);
            bench_forget();
            bus_allow();
            for (uint32_t n = 4u; n <= 6u; n++) {
                bus_write16(&EPWM(n)->TZCLR, TZ_OST | TZ_INT);
            }
            bus_protect();
            run_periods(12u);
            if (plain == 0u) {
                count = bench.edges;
                memcpy(kept, bench.edge, sizeof kept);
            }
        }
        TEST_ASSERT_TRUE_MESSAGE(count > 20u, "edges expected");
        TEST_ASSERT_EQUAL_UINT32(count, bench.edges);
        TEST_ASSERT_EQUAL_MEMORY(kept, bench.edge, count * sizeof(edge_t));
    }
}

/* CMPA = 200 is shorter than the dead bands. Therefore the last edge of a period that nothing observed
 * comes after the next zero: 298 - 200 counts after it on the lower gate, 301 - 200 on the upper one. A
 * count is 1.5 ticks. */
static void test_dead_band_of_a_blind_period_reaches_over_zero(void)
{
    for (uint32_t on_period = 0u; on_period < 2u; on_period++) {
        begin(&(board_t){20000000u, 1u, false, on_period ? PERIOD_WORD : ZERO_WORD, AHC, 5000u, 301u, 298u},
              true);
        bench_in_interrupt = NULL;
        bench_compare[0] = 200u;
        chip_set_pin(&bench_chip, 12u, false);
        run_periods(6u);
        uint64_t zero = chip_now(&bench_chip);
        chip_run(zero + 20u);
        chip_set_pin(&bench_chip, 12u, true);
        bench_allowed16(&EPWM(1u)->TZCLR, TZ_OST | TZ_INT);
        bench_forget();
        chip_run(zero + 300u);
        TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
        TEST_ASSERT_EQUAL_UINT64(zero + (on_period ? 147u : 152u), bench.edge[0].tick);
        TEST_ASSERT_EQUAL_HEX32(on_period ? 2u : 1u, bench.edge[0].level & 3u);
    }
}

/* Calculated by hand for 100 MHz, where a count is 1.5 ticks: leg 4 rises at 1000 + 200 and falls at 10000
 * - 1000. */
static void test_edges_are_where_the_formula_puts_them(void)
{
    begin(&(board_t){20000000u, 4u, false, PERIOD_WORD, AHC, 5000u, 200u, 200u}, true);
    bench_in_interrupt = NULL;
    bench_compare[0] = 1000u;
    bench_compare[1] = 2000u;
    bench_compare[2] = 3001u;
    run_periods(3u);
    uint64_t zero = chip_now(&bench_chip);
    bench_forget();
    run_periods(4u);
    static const struct {
        uint32_t tick, pins;
    } step[] = {{1500u, 0x28u},  {1800u, 0x29u},  {3000u, 0x21u},  {3300u, 0x25u},
                {4502u, 0x05u},  {4802u, 0x15u},  {10499u, 0x05u}, {10799u, 0x25u},
                {12000u, 0x21u}, {12300u, 0x29u}, {13500u, 0x28u}, {13800u, 0x2Au}};
    TEST_ASSERT_EQUAL_UINT32(12u, bench.edges);
    for (uint32_t i = 0u; i < 12u; i++) {
        TEST_ASSERT_EQUAL_UINT64(zero + step[i].tick, bench.edge[i].tick);
        TEST_ASSERT_EQUAL_HEX32(step[i].pins << 6, bench.edge[i].level);
        TEST_ASSERT_EQUAL_HEX32(0xFC0u, bench.edge[i].driven);
    }
}

/* Without a dead band pin A is high exactly for the time that the average states, at every corner of the
 * range and at random values between. */
static void averages_are_the_edges(const board_t *shape)
{
    static uint64_t high[300][LEGS];
    uint32_t pin = 2u * (shape->first - 1u);
    begin(shape, true);
    run_periods(300u);
    for (uint32_t k = 0u; k < 300u; k++) {
        for (uint32_t leg = 0u; leg < LEGS; leg++) {
            high[k][leg] =
                bench_high_of(pin + 2u * leg, start + k * period_ticks(), start + (k + 1u) * period_ticks());
        }
    }
    begin(shape, true);
    chip_set_averaged(&bench_chip, true);
    run_periods(300u);
    TEST_ASSERT_EQUAL_UINT32(300u, bench.averages);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.edges);
    for (uint32_t k = 0u; k < 300u; k++) {
        TEST_ASSERT_EQUAL_UINT64(start + k * period_ticks(), bench.average[k].tick);
        TEST_ASSERT_EQUAL_UINT32(period_ticks(), bench.average[k].period);
        TEST_ASSERT_EQUAL_UINT32(0u, bench.average[k].dead);
        for (uint32_t leg = 0u; leg < LEGS; leg++) {
            TEST_ASSERT_EQUAL_UINT64(high[k][leg], bench.average[k].high[leg]);
        }
    }
}

static void test_averages_are_the_edges_at_every_corner(void)
{
    averages_are_the_edges(&(board_t){30000000u, 1u, false, ZERO_WORD, AHC, 7500u, 0u, 0u});
    averages_are_the_edges(&(board_t){30000000u, 1u, false, PERIOD_WORD, AHC, 7500u, 0u, 0u});
    averages_are_the_edges(&(board_t){30000000u, 4u, true, PERIOD_WORD, AHC, 7500u, 0u, 0u});
}

static void average_of(const board_t *shape, uint16_t compare, average_t *average)
{
    begin(shape, true);
    bench_in_interrupt = NULL;
    chip_set_averaged(&bench_chip, true);
    for (uint32_t leg = 0u; leg < LEGS; leg++) {
        bench_compare[leg] = (uint16_t)(compare + leg);
    }
    run_periods(6u);
    TEST_ASSERT_TRUE(bench.averages > 0u);
    *average = bench.average[bench.averages - 1u];
}

/* At 100 MHz half ticks are rounded: 33 counts of dead band are 49.5 ticks. */
static void test_averages_in_ticks_at_100_megahertz(void)
{
    average_t average;
    average_of(&(board_t){20000000u, 4u, false, ZERO_WORD, AHC, 5000u, 33u, 33u}, 1000u, &average);
    TEST_ASSERT_EQUAL_UINT32(15000u, average.period);
    TEST_ASSERT_EQUAL_UINT32(3000u, average.high[0]); /* in the order of the modules */
    TEST_ASSERT_EQUAL_UINT32(3003u, average.high[1]);
    TEST_ASSERT_EQUAL_UINT32(3006u, average.high[2]);
    TEST_ASSERT_EQUAL_UINT32(50u, average.dead);
    TEST_ASSERT_TRUE(average.ends);
    average_of(&(board_t){20000000u, 1u, false, PERIOD_WORD, AHC, 5000u, 30u, 30u}, 1000u, &average);
    TEST_ASSERT_EQUAL_UINT32(15000u, average.period);
    TEST_ASSERT_EQUAL_UINT32(12000u, average.high[0]);
    TEST_ASSERT_EQUAL_UINT32(11997u, average.high[1]);
    TEST_ASSERT_EQUAL_UINT32(45u, average.dead);
    TEST_ASSERT_FALSE(average.ends);
}

static void test_averages_at_the_limits_centred_on_the_period_match(void)
{
    static const uint16_t compare[] = {0u, 1u, 4999u, 5000u, 5001u};
    static const uint32_t high[] = {15000u, 14997u, 3u, 0u, 0u};
    for (uint32_t i = 0u; i < 5u; i++) {
        average_t average;
        average_of(&(board_t){20000000u, 1u, false, PERIOD_WORD, AHC, 5000u, 300u, 300u}, compare[i],
                   &average);
        TEST_ASSERT_EQUAL_UINT32(high[i], average.high[0]);
    }
}

/* The gates are active low: the pin of the upper gate is low for high - dead ticks, that of the lower one
 * for the rest of the period less a dead band. */
static void test_averages_of_active_low_gates(void)
{
    const board_t shape = {30000000u, 1u, false, ZERO_WORD, ALC, 7500u, 450u, 450u};
    average_t average;
    average_of(&shape, 3000u, &average);
    TEST_ASSERT_EQUAL_UINT32(6000u, average.high[0]);
    TEST_ASSERT_EQUAL_UINT32(450u, average.dead);
    begin(&shape, true);
    bench_in_interrupt = NULL;
    bench_compare[0] = 3000u;
    run_periods(7u);
    uint64_t from = start + 6u * period_ticks();
    TEST_ASSERT_EQUAL_UINT64(15000u - (6000u - 450u), bench_high_of(0u, from, from + 15000u));
    TEST_ASSERT_EQUAL_UINT64(15000u - (9000u - 450u), bench_high_of(1u, from, from + 15000u));
}

static void test_polarity_against_the_board_is_visible_in_the_edges(void)
{
    for (uint32_t low = 0u; low < 2u; low++) {
        begin(&(board_t){30000000u, 1u, false, ZERO_WORD, low ? AHC : ALC, 7500u, 450u, 450u}, true);
        bench_world.active_low = low;
        chip_set_averaged(&bench_chip, true);
        run_periods(20u);
        TEST_ASSERT_EQUAL_UINT32(0u, bench.averages);
        TEST_ASSERT_TRUE_MESSAGE(bench.edges > 50u, "edges expected");
    }
}

static void test_trip_of_modules_4_to_6(void)
{
    begin(&(board_t){30000000u, 4u, false, ZERO_WORD, AHC, 7500u, 450u, 450u}, true);
    run_periods(5u);
    TEST_ASSERT_TRUE((bench.edge[bench.edges - 1u].level & 0xFC0u) != 0u);
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_EQUAL_HEX32(0u, bench.edge[bench.edges - 1u].level);
    TEST_ASSERT_EQUAL_HEX32(0xFC0u, bench.edge[bench.edges - 1u].driven);
    for (uint32_t n = 1u; n <= 6u; n++) {
        TEST_ASSERT_EQUAL(n >= 4u, chip_tripped(&bench_chip, n));
    }
}

static void test_carrier_zeros_ahead_are_exact(void)
{
    static const uint32_t crystal[] = {20000000u, 25000000u, 30000000u};
    for (uint32_t i = 0u; i < 6u; i++) {
        begin(&(board_t){crystal[i % 3u], i < 3u ? 1u : 4u, false, ZERO_WORD, AHC, 5000u, 300u, 300u},
              i % 2u == 0u);
        run_periods(3u);
        chip_run(chip_now(&bench_chip) + 100u);
        TEST_ASSERT_EQUAL_UINT64(start + 3u * period_ticks(), chip_carrier_zero(&bench_chip, 0u));
        TEST_ASSERT_EQUAL_UINT64(start + 1003u * period_ticks(), chip_carrier_zero(&bench_chip, 1000u));
    }
}

/* The counter counts up with TBCLK = SYSCLK / 4, so that 1000 counts are 4000 cycles. */
static void test_zeros_ahead_of_a_divided_up_counter(void)
{
    bench_power_on();
    bench_clock();
    bus_write16(&EPWM(1u)->TBPRD, 999u);
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_CLKDIV(2));
    bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_TBCLKSYNC);
    start = chip_now(&bench_chip);
    TEST_ASSERT_EQUAL_UINT64(CHIP_NEVER, chip_carrier_zero(&bench_chip, 3u));
    chip_run(start + 9000u);
    TEST_ASSERT_EQUAL_UINT64(start + 8000u, chip_carrier_zero(&bench_chip, 0u));
    TEST_ASSERT_EQUAL_UINT64(start + 20000u, chip_carrier_zero(&bench_chip, 3u));
}

/* ePWM2 must not count by itself while the legs are on ePWM4..6; otherwise the fast path is not allowed. */
static void test_another_counter_beside_the_legs_is_not_plain(void)
{
    for (uint32_t led = 0u; led < 2u; led++) {
        begin(&(board_t){30000000u, 4u, led != 0u, ZERO_WORD, AHC, 7500u, 450u, 450u}, true);
        run_periods(3u);
        TEST_ASSERT_TRUE(chip_carrier_plain(&bench_chip));
        bus_write16(&EPWM(2u)->TBPRD, 1000u);
        bus_write16(&EPWM(2u)->TBCTL, 0x0010u);
        run_periods(6u);
        TEST_ASSERT_FALSE(chip_carrier_plain(&bench_chip));
    }
    begin(&(board_t){30000000u, 4u, true, ZERO_WORD, AHC, 7500u, 450u, 450u}, true);
    bus_write16(&EPWM(1u)->AQCTLA, ZERO_WORD); /* a leading module whose output has an action */
    run_periods(6u);
    TEST_ASSERT_FALSE(chip_carrier_plain(&bench_chip));
}
