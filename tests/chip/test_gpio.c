/* GPIO: data registers, direction, multiplexer, and what the gates of the inverter receive. */
#include <unity.h>

#include "bench.h"

void setUp(void)
{
    bench_power_on();
    bench_clock();
}

static void direction(uint32_t port, uint32_t bits)
{
    bench_allowed32(&GPIO_CONTROL(port)->DIR, bits);
}

static void test_inputs_follow_the_board(void)
{
    TEST_ASSERT_EQUAL_HEX32(0xFFFFF000u, GPIO_DATA(0u)->DAT); /* all pins except GPIO0..11 are pulled up */
    chip_set_pin(&bench_chip, 3u, true);
    chip_set_pin(&bench_chip, 12u, false);
    chip_set_pin(&bench_chip, 33u, false);
    chip_set_pin(&bench_chip, 87u, false);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFE008u, GPIO_DATA(0u)->DAT);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFDu, GPIO_DATA(1u)->DAT);
    TEST_ASSERT_EQUAL_HEX32(0x007FFFFFu, GPIO_DATA(2u)->DAT);
}

static void test_outputs_set_clear_toggle(void)
{
    direction(1u, 0x0000000Fu);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFF0u, GPIO_DATA(1u)->DAT);
    bus_write32(&GPIO_DATA(1u)->SET, 0x00000005u);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFF5u, GPIO_DATA(1u)->DAT);
    bus_write32(&GPIO_DATA(1u)->CLEAR, 0x00000004u);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFF1u, GPIO_DATA(1u)->DAT);
    bus_write32(&GPIO_DATA(1u)->TOGGLE, 0x00000003u);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFF2u, GPIO_DATA(1u)->DAT);
    bus_write32(&GPIO_DATA(1u)->DAT, 0x00000008u);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFF8u, GPIO_DATA(1u)->DAT);
}

/* The level of a light on any pin can be read. */
static void test_driven_outputs_can_be_asked(void)
{
    for (uint32_t gpio = 0u; gpio < 88u; gpio++) {
        TEST_ASSERT_EQUAL_INT32(-1, chip_pin_out(&bench_chip, gpio));
    }
    for (uint32_t gpio = 0u; gpio < 88u; gpio++) {
        direction(gpio / 32u, GPIO_PIN(gpio));
        TEST_ASSERT_EQUAL_INT32(0, chip_pin_out(&bench_chip, gpio));
        bus_write32(&GPIO_DATA(gpio / 32u)->SET, GPIO_PIN(gpio));
        TEST_ASSERT_EQUAL_INT32(1, chip_pin_out(&bench_chip, gpio));
        bus_write32(&GPIO_DATA(gpio / 32u)->TOGGLE, GPIO_PIN(gpio));
        TEST_ASSERT_EQUAL_INT32(0, chip_pin_out(&bench_chip, gpio));
        TEST_ASSERT_EQUAL_INT32(-1, chip_pin_out(&bench_chip, (gpio + 1u) % 88u));
        direction(gpio / 32u, 0u);
    }
    direction(1u, GPIO_PIN(32u));
    bus_allow();
    bus_write32(&GPIO_CONTROL(1u)->MUX1, GPIO_FIELD(32u, 1u)); /* the pin belongs to another peripheral */
    bus_protect();
    TEST_ASSERT_EQUAL_INT32(-1, chip_pin_out(&bench_chip, 32u));
}

static void test_gates_can_be_asked(void)
{
    bench_start(0u);
    chip_run(chip_now(&bench_chip) + 3u * CARRIER + 7500u); /* at the period match all lower gates are on */
    for (uint32_t gpio = 0u; gpio < 6u; gpio++) {
        TEST_ASSERT_EQUAL_INT32((int32_t)(gpio % 2u), chip_pin_out(&bench_chip, gpio));
    }
    bus_allow();
    bus_write16(&EPWM(1u)->TZCTL, 0u); /* high impedance */
    bus_write16(&EPWM(1u)->TZFRC, TZ_OST);
    bus_protect();
    TEST_ASSERT_EQUAL_INT32(-1, chip_pin_out(&bench_chip, 1u));
}

/* A light that blinks on another pin does not end an averaged period. */
static void test_other_outputs_leave_an_average_alone(void)
{
    bench_start(0u);
    direction(1u, GPIO_PIN(34u));
    chip_set_averaged(&bench_chip, true);
    uint64_t from = chip_now(&bench_chip);
    chip_run(from + 3u * CARRIER + 5000u);
    bench_forget();
    bus_write32(&GPIO_DATA(1u)->TOGGLE, GPIO_PIN(34u));
    chip_run(from + 5u * CARRIER + 5000u);
    TEST_ASSERT_EQUAL_UINT32(2u, bench.averages);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.edges);
    TEST_ASSERT_EQUAL_INT32(1, chip_pin_out(&bench_chip, 34u));
}

static void test_input_clock_off_freezes_inputs(void)
{
    bench_allowed16(&SYSCTRL->PCLKCR3, 0x0700u);
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFF000u, GPIO_DATA(0u)->DAT);
}

static void test_gate_pins_float_until_muxed_or_driven(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, bench.edges);
    direction(0u, 0x00000002u); /* EPWM1B as a plain output, low */
    TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
    TEST_ASSERT_EQUAL_HEX32(0x02u, bench.edge[0].driven);
    TEST_ASSERT_EQUAL_HEX32(0x00u, bench.edge[0].level);
    bus_write32(&GPIO_DATA(0u)->SET, 0x00000002u);
    TEST_ASSERT_EQUAL_HEX32(0x02u, bench.edge[1].level);
    bench_allowed32(&GPIO_CONTROL(0u)->MUX1, GPIO_FIELD(0u, 1u) | GPIO_FIELD(1u, 1u) | GPIO_FIELD(2u, 2u));
    /* The function of another peripheral drives no gate. */
    TEST_ASSERT_EQUAL_HEX32(0x03u, bench.edge[bench.edges - 1u].driven);
    TEST_ASSERT_EQUAL_HEX32(0x00u, bench.edge[bench.edges - 1u].level);
}

static void test_data_register_shows_the_gate_pins(void)
{
    bench_start(0u);
    uint64_t from = chip_now(&bench_chip);
    chip_run(from + 3u * CARRIER + 7500u); /* at the period match all lower gates are on */
    TEST_ASSERT_EQUAL_HEX32(0xFFFFF02Au, GPIO_DATA(0u)->DAT);
}

static void test_trip_pin_reads_whatever_its_function(void)
{
    bench_start(0u);
    chip_set_pin(&bench_chip, 12u, false);
    TEST_ASSERT_EQUAL_HEX32(0u, GPIO_DATA(0u)->DAT & GPIO_PIN(12u));
    chip_set_pin(&bench_chip, 12u, true);
    TEST_ASSERT_EQUAL_HEX32(GPIO_PIN(12u), GPIO_DATA(0u)->DAT & GPIO_PIN(12u));
}

static void test_port_c_has_no_qualification(void)
{
    bus_allow();
    bus_write32(&GPIO_CONTROL(2u)->QSEL1, 0u);
    bus_write32(&GPIO_CONTROL(1u)->QSEL1, 5u);
    TEST_ASSERT_EQUAL_UINT32(1u, chip_report_count(&bench_chip, CHIP_UNKNOWN_REGISTER));
    TEST_ASSERT_EQUAL_HEX32(5u, GPIO_CONTROL(1u)->QSEL1);
}
