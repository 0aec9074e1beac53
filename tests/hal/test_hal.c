/* The HAL on a bus that records every access. The expected words are calculated by hand from the field
 * tables of the peripheral guides (SPRUFB0, SPRUG04, SPRU812, SPRUG05). The test is built once for each
 * gate polarity. */
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "hal/f28335/adc.h"
#include "hal/f28335/bus.h"
#include "hal/f28335/pwm.h"
#include "hal/hal.h"
#include "tests/hal/recording_bus.h"
#include "unity.h"

#define PERIOD      15000u /* 150 MHz / 10 kHz */
#define COUNT_MAX   9999u  /* 2500 lines, four edges each */
#define VECTOR(n)   (UINT32_C(0x300000) + (n))
#define ASSERT(...) TEST_ASSERT_TRUE_MESSAGE(__VA_ARGS__)

#if HAL_GATE_ACTIVE_HIGH
#define EXPECTED_DBCTL 0x000Bu
#define EXPECTED_TZCTL 0x000Au
#else
#define EXPECTED_DBCTL 0x0007u
#define EXPECTED_TZCTL 0x0005u
#endif

static void on_sample(void)
{
}

static void on_medium(void)
{
}

static void on_trip(void)
{
}

static void on_serial(void)
{
}

static hal_config_t config;

static hal_status_t start(void)
{
    return hal_init(&config);
}

void setUp(void)
{
    recording_reset();
    rec.otp[0] = 0x0123u;
    rec.otp[1] = 0x0045u;
    config = (hal_config_t){375u, COUNT_MAX, on_sample, on_medium, on_trip, on_serial};
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, rec.overflows, "the log was too short");
    TEST_ASSERT_FALSE_MESSAGE(rec.allowed, "EALLOW left open");
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, rec.nested,
                                     "EALLOW and EDIS do not pair, or time passes in between");
}

/* ---- Start-up: values of the registers ---- */

static bool is_wide(uint32_t address)
{
    return (address >= 0x0C00u && address < 0x0C18u && (address & 7u) < 4u) ||
           (address >= 0x0D00u && address < 0x0E00u) || (address >= 0x6B00u && address < 0x6B12u) ||
           (address >= 0x6F80u && address < 0x6FE0u);
}

typedef struct {
    const volatile void *reg;
    uint32_t value;
} expected_t;

static void assert_registers(const expected_t *expected, uint32_t n)
{
    for (const expected_t *e = expected; e < expected + n; e++) {
        const uint32_t address = recording_address(e->reg);
        char where[32];
        (void)snprintf(where, sizeof where, "register 0x%04X", (unsigned)address);
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(e->value,
                                        is_wide(address) ? *(const volatile uint32_t *)e->reg
                                                         : *(const volatile uint16_t *)e->reg,
                                        where);
    }
}

#define ASSERT_REGISTERS(table) assert_registers(table, sizeof table / sizeof table[0])

static void test_start_up_leaves_clock_and_flash_at_150_MHz(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    const expected_t expected[] = {
        {&SYSCTRL->WDCR, 0x0068u},    {&SYSCTRL->PLLCR, 10u},       {&SYSCTRL->PLLSTS, 0x0101u},
        {&SYSCTRL->HISPCP, 3u},       {&SYSCTRL->LOSPCP, 2u},       {&SYSCTRL->PCLKCR0, 0x040Cu},
        {&SYSCTRL->PCLKCR1, 0x4007u}, {&SYSCTRL->PCLKCR3, 0x2700u}, {&FLASH_REGS->FBANKWAIT, 0x505u},
        {&FLASH_REGS->FOTPWAIT, 8u},  {&FLASH_REGS->FOPT, 1u},      {&FLASH_REGS->FPWR, 3u},
    };
    ASSERT_REGISTERS(expected);
}

static void test_start_up_sets_each_leg_to_the_manual_s_words(void)
{
    recording_soil();
    TEST_ASSERT_EQUAL(HAL_OK, start());
    for (uint16_t n = 1u; n <= 3u; n++) {
        const bool first = n == 1u;
        const volatile epwm_regs_t *leg = EPWM(n);
        const expected_t expected[] = {
            {&leg->TBCTL, first ? 0x4012u : 0x6006u},
            {&leg->TBPHS, first ? 0u : 2u},
            {&leg->TBPRD, 7500u},
            {&leg->CMPCTL, 0u},
            {&leg->CMPA, 3750u},
            {&leg->CMPB, first ? 87u : 0u},
            {&leg->AQCTLA, 0x0090u},
            {&leg->AQCTLB, 0u},
            {&leg->AQCSFRC, 0u},
            {&leg->TBCTR, 0u},
            {&leg->DBCTL, EXPECTED_DBCTL},
            {&leg->DBRED, 375u},
            {&leg->DBFED, 375u},
            {&leg->TZSEL, 0x0100u},
            {&leg->TZCTL, EXPECTED_TZCTL},
            {&leg->TZEINT, 0u},
            {&leg->TZFLG, TZ_OST},
            {&leg->ETSEL, first ? 0x0F00u : 0u},
            {&leg->ETPS, first ? 0x0100u : 0u},
        };
        ASSERT_REGISTERS(expected);
    }
}

static void test_start_up_sets_the_converter_to_four_pairs(void)
{
    recording_soil();
    TEST_ASSERT_EQUAL(HAL_OK, start());
    const expected_t expected[] = {
        {&ADC->ADCTRL1, 0x0410u},        {&ADC->ADCTRL2, 0x4900u}, /* RST_SEQ1 stays set. */
        {&ADC->ADCTRL3, 0x00E1u},        {&ADC->ADCMAXCONV, 3u},
        {&ADC->ADCCHSELSEQ[0], 0x2102u}, {&ADC->ADCST, 0x0010u},
    };
    ASSERT_REGISTERS(expected);
}

/* The hold by SPRS439, simultaneous sampling: 2.5 ADCCLK for the start, 1 + ACQ_PS for the first window, 3
 * + ACQ_PS for the next pair, with an ADCCLK of 40 ns. ACQ_PS is 4, in the word 0x0410. 14.5 x 40 ns = 580
 * ns = 87 / 150 MHz. */
static void test_currents_are_held_at_counter_zero(void)
{
    const double adcclk = 40e-9;
    const double held = (2.5 + (1.0 + 4.0) + (3.0 + 4.0)) * adcclk;
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, held, (double)ADC_LEAD / (double)HAL_CLOCK_HZ);
}

/* A high level at GPIO27, the enable input, enables the drive. Its pull-up is off, so that an open wire
 * reads as low. */
static void test_start_up_connects_gates_fault_line_encoder_serial_line_and_enable_input(void)
{
    rec.regs.gpio_control[0].DIR = 0x08000000u;
    rec.regs.gpio_control[0].PUD = 0x3000FFFFu;
    rec.regs.gpio_control[0].MUX2 = 0x50000000u; /* another program has assigned a CAN port */
    TEST_ASSERT_EQUAL(HAL_OK, start());
    const expected_t expected[] = {
        {&GPIO_CONTROL(0u)->MUX1, 0x01000555u},
        {&GPIO_CONTROL(0u)->MUX2, 0x55005500u},
        {&GPIO_CONTROL(0u)->QSEL1, 0x03000000u},
        {&GPIO_CONTROL(0u)->QSEL2, 0x03000000u},
        {&GPIO_CONTROL(0u)->PUD, 0x0800EFFFu},
        /* Chopper and brake are outputs. */
        {&GPIO_CONTROL(0u)->DIR, 0xC0000000u},
    };
    ASSERT_REGISTERS(expected);
}

static void test_start_up_sets_the_encoder_to_four_counts_a_line_in_step_with_the_carrier(void)
{
    recording_soil();
    rec.regs.eqep[0].QFLG = 0x0FFFu;
    TEST_ASSERT_EQUAL(HAL_OK, start());
    const expected_t expected[] = {
        {&EQEP(1u)->QPOSMAX, 9999u}, {&EQEP(1u)->QPOSINIT, 0u}, {&EQEP(1u)->QUPRD, 15000u},
        {&EQEP(1u)->QUTMR, 0u},      {&EQEP(1u)->QDECCTL, 0u},  {&EQEP(1u)->QEPCTL, 0x900Eu},
        {&EQEP(1u)->QEINT, 0u},      {&EQEP(1u)->QFLG, 0u},
    };
    ASSERT_REGISTERS(expected);
    ASSERT(recording_find_value(0u, &EQEP(1u)->QEPCTL, 0x908Cu) < rec.entries,
           "position not initialised by SWI before the unit timer runs");
}

static void test_vectors_lead_to_the_application_and_all_others_shut_the_gates(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    TEST_ASSERT_EQUAL_UINT32(5u, rec.functions);
    const bus_isr_t other = rec.function[0];
    TEST_ASSERT_TRUE(rec.function[1] == on_sample && rec.function[2] == on_trip);
    TEST_ASSERT_TRUE(rec.function[3] == on_medium && rec.function[4] == on_serial);
    for (uint32_t n = 1u; n < 128u; n++) {
        const uint32_t expected = n == 32u   ? VECTOR(1u)
                                  : n == 40u ? VECTOR(2u)
                                  : n == 14u ? VECTOR(3u)
                                  : n == 96u ? VECTOR(4u)
                                             : VECTOR(0u);
        TEST_ASSERT_EQUAL_HEX32(expected, PIE_VECTORS->vector[n]);
    }
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, recording_count(&PIE_VECTORS->vector[0]), "reset vector written");

    TEST_ASSERT_TRUE(hal_gates_on());
    other();
    TEST_ASSERT_BITS(TZ_OST, TZ_OST, EPWM(1u)->TZFLG & EPWM(2u)->TZFLG & EPWM(3u)->TZFLG);
}

static void test_only_the_interrupts_of_the_application_are_enabled(void)
{
    for (uint16_t n = 0; n < 12u; n++) {
        rec.regs.pie.group[n].IER = 0xFFu;
        rec.regs.pie.group[n].IFR = 0x11u;
    }
    TEST_ASSERT_EQUAL(HAL_OK, start());
    TEST_ASSERT_EQUAL_HEX16(PIECTRL_ENPIE, PIE->PIECTRL);
    for (uint16_t n = 0; n < 12u; n++) {
        TEST_ASSERT_EQUAL_HEX16(n < 2u || n == 8u ? 1u : 0u, PIE->group[n].IER);
        TEST_ASSERT_EQUAL_HEX16(0u, PIE->group[n].IFR);
    }
    const volatile uint16_t *const behind = F28335_BASE + 0x0CFAu;
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, recording_count(behind), "wrote past the last group");
    TEST_ASSERT_EQUAL_HEX16(0x0103u, PIE->PIEACK);
    TEST_ASSERT_EQUAL_HEX16(0x2103u, rec.groups);
    TEST_ASSERT_TRUE(rec.interrupts_on);

    setUp();
    config.on_serial = NULL;
    TEST_ASSERT_EQUAL(HAL_OK, start());
    TEST_ASSERT_EQUAL_HEX16(0u, PIE->group[8].IER);
    TEST_ASSERT_EQUAL_HEX16(0x2003u, rec.groups);
}

/* ---- Start-up: order and protection ---- */

/* The registers of SPRUFB0, "EALLOW-protected registers", that this register map contains. */
static bool is_protected(uint32_t address)
{
    const uint32_t of_epwm = (address - 0x6800u) % 0x40u;
    if (address >= 0x6800u && address < 0x6980u) {
        return of_epwm == 0x12u || of_epwm == 0x14u || of_epwm == 0x15u || of_epwm == 0x17u ||
               of_epwm == 0x18u || of_epwm == 0x20u;
    }
    /* For ADCREFSEL and ADCOFFTRIM SPRU812 states no protection, but TI's own calibration function writes
     * them with EALLOW set. */
    if (address == 0x711Cu || address == 0x711Du) {
        return true;
    }
    return (address >= 0x0A80u && address < 0x0A88u) || (address >= 0x0D00u && address < 0x0E00u) ||
           (address >= 0x6F80u && address < 0x6FC0u) || (address >= 0x7010u && address < 0x7030u);
}

static void assert_every_write_is_as_the_register_wants_it(void)
{
    for (uint32_t i = 0; i < rec.entries; i++) {
        const entry_t *e = &rec.entry[i];
        char where[48];
        if (e->did == DID_WRITE16 || e->did == DID_WRITE32) {
            (void)snprintf(where, sizeof where, "write %u, register 0x%04X", (unsigned)i,
                           (unsigned)e->address);
            TEST_ASSERT_EQUAL_MESSAGE(is_protected(e->address), e->allowed, where);
            TEST_ASSERT_EQUAL_MESSAGE(is_wide(e->address) ? DID_WRITE32 : DID_WRITE16, e->did, where);
        }
    }
}

static void test_every_write_has_the_register_s_width_and_EALLOW_exactly_where_needed(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    hal_watchdog_start();
    TEST_ASSERT_TRUE(hal_set_dead_band(450u));
    TEST_ASSERT_TRUE(hal_set_encoder(3999u));
    TEST_ASSERT_TRUE(hal_gates_on());
    hal_write_compare(1u, 2u, 3u);
    hal_gates_off();
    hal_end_of_sample();
    hal_end_of_trip();
    assert_every_write_is_as_the_register_wants_it();
}

static void test_pll_follows_the_manual_step_by_step(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    const struct {
        const volatile uint16_t *reg;
        uint32_t value;
    } step[] = {
        {&SYSCTRL->PLLSTS, 0x0000u},                              /* DIVSEL 0 */
        {&SYSCTRL->PLLSTS, 0x0040u},                              /* clock-loss detector off */
        {&SYSCTRL->PLLCR, 10u},      {&SYSCTRL->PLLSTS, 0x0000u}, /* detector on */
        {&SYSCTRL->PLLSTS, 0x0100u},                              /* DIVSEL 2 */
    };
    uint32_t at = 0u;
    for (uint32_t i = 0; i < sizeof step / sizeof step[0]; i++) {
        uint32_t next = at;
        while (next < rec.entries && rec.entry[next].address != recording_address(&SYSCTRL->PLLSTS) &&
               rec.entry[next].address != recording_address(&SYSCTRL->PLLCR)) {
            next++;
        }
        TEST_ASSERT_TRUE(next < rec.entries);
        TEST_ASSERT_EQUAL_HEX32(recording_address(step[i].reg), rec.entry[next].address);
        TEST_ASSERT_EQUAL_HEX32(step[i].value, rec.entry[next].value);
        if (i == 3u) {
            TEST_ASSERT_EQUAL_MESSAGE(DID_WAIT, rec.entry[next - 1u].did, "no wait for the lock");
            ASSERT(rec.entry[next - 1u].value >= 32768u, "the start continued before the lock");
        }
        at = next + 1u;
    }
    TEST_ASSERT_EQUAL_UINT32(4u, recording_count(&SYSCTRL->PLLSTS));
    TEST_ASSERT_EQUAL_UINT32(1u, recording_count(&SYSCTRL->PLLCR));
}

static void test_watchdog_goes_off_before_anything_else(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    TEST_ASSERT_EQUAL(DID_INTERRUPTS_OFF, rec.entry[0].did);
    TEST_ASSERT_EQUAL(DID_WRITE16, rec.entry[1].did);
    TEST_ASSERT_EQUAL_HEX32(0x7029u, rec.entry[1].address);
    TEST_ASSERT_EQUAL_HEX32(0x0068u, rec.entry[1].value);
}

static void test_carrier_starts_last_and_does_not_count_before(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    TEST_ASSERT_EQUAL(DID_INTERRUPTS_ON, rec.entry[rec.entries - 1u].did);
    const entry_t *last = &rec.entry[rec.entries - 2u];
    TEST_ASSERT_EQUAL_HEX32(0x701Cu, last->address);
    TEST_ASSERT_EQUAL_HEX32(0x040Cu, last->value);
    const uint32_t first = recording_find(0u, &SYSCTRL->PCLKCR0);
    TEST_ASSERT_EQUAL_HEX32(0x0408u, rec.entry[first].value);
    TEST_ASSERT_EQUAL_UINT32(2u, recording_count(&SYSCTRL->PCLKCR0));
    /* The unit timer of the encoder starts within its tolerance of the start of the carrier: no wait is
     * between them. */
    const uint32_t unit = recording_find_value(0u, &EQEP(1u)->QEPCTL, 0x900Eu);
    TEST_ASSERT_EQUAL_UINT32(rec.entries - 3u, unit);
}

/* The first write of a value to a register, or the first write to it of any value, or another event of the
 * bus. */
typedef struct {
    const volatile void *reg; /* NULL: the event `did` */
    uint32_t value;
    did_t did;
} event_t;

#define ANY UINT32_C(0xFFFFFFFF)
#define WRITE(r, v)                                                                                          \
    {                                                                                                        \
        &(r), v, DID_WRITE16                                                                                 \
    }
#define DOES(what)                                                                                           \
    {                                                                                                        \
        NULL, ANY, what                                                                                      \
    }
#define FAST_CLOCK     WRITE(SYSCTRL->PLLSTS, 0x0100u)
#define PINS_CONNECTED WRITE(GPIO_CONTROL(0u)->MUX1, 0x01000555u)
#define FAULT_LINE     WRITE(GPIO_CONTROL(0u)->MUX1, 0x01000000u)
#define FIRST_VECTOR   WRITE(PIE_VECTORS->vector[1], ANY)
#define CONVERTER_ON   WRITE(ADC->ADCTRL3, ANY)

static uint32_t place_of(const event_t *event)
{
    uint32_t n = 0u;
    if (event->reg != NULL) {
        return event->value == ANY ? recording_find(0u, event->reg)
                                   : recording_find_value(0u, event->reg, event->value);
    }
    while (n < rec.entries && rec.entry[n].did != event->did) {
        n++;
    }
    return n;
}

static void expect_order(const event_t *first, const event_t *then, const char *why)
{
    TEST_ASSERT_TRUE_MESSAGE(place_of(first) < place_of(then), why);
    TEST_ASSERT_TRUE_MESSAGE(place_of(then) < rec.entries, why);
}

/* SPRU812: the reference is selected before the converter is powered. A chip that is started again without
 * a reset still has the interrupt enables and requests of the earlier program. */
static void test_start_up_keeps_the_order_of_its_steps(void)
{
    rec.otp[0] = 0x1234u;
    rec.otp[1] = 0x01F3u;
    TEST_ASSERT_EQUAL(HAL_OK, start());
    const struct {
        event_t first, then;
        const char *why;
    } orders[] = {
        {WRITE(SYSCTRL->HISPCP, ANY), FAST_CLOCK, "prescaler of the ADC"},
        {WRITE(SYSCTRL->LOSPCP, ANY), FAST_CLOCK, "prescaler of the line"},
        {WRITE(FLASH_REGS->FBANKWAIT, ANY), FAST_CLOCK, "waits of the flash"},
        {WRITE(FLASH_REGS->FOTPWAIT, ANY), FAST_CLOCK, "waits of the OTP"},
        {WRITE(FLASH_REGS->FOPT, ANY), FAST_CLOCK, "pipeline"},
        {WRITE(SYSCTRL->PCLKCR0, ANY), WRITE(SYSCTRL->PCLKCR3, ANY), "clocks"},
        {WRITE(SYSCTRL->PCLKCR1, ANY), WRITE(SYSCTRL->PCLKCR3, ANY), "clocks"},
        {WRITE(CPU_TIMER(0u)->TCR, TCR_TRB | TCR_FREE), DOES(DID_WAIT),
         "the timer runs before the first wait"},
        {WRITE(GPIO_CONTROL(0u)->QSEL1, ANY), FAULT_LINE, "the fault line is asynchronous"},
        {FAULT_LINE, PINS_CONNECTED, "the fault line acts before a gate pin changes"},
        {WRITE(PIE->PIECTRL, 0u), FIRST_VECTOR, "interrupts of the earlier program"},
        {DOES(DID_DISABLE_GROUPS), FIRST_VECTOR, "enables of the earlier program"},
        {DOES(DID_CLEAR_PENDING), FIRST_VECTOR, "requests of the earlier program"},
        {WRITE(PIE_VECTORS->vector[32], VECTOR(1u)), WRITE(PIE->PIECTRL, 1u), "vector of the sample"},
        {WRITE(PIE_VECTORS->vector[40], VECTOR(2u)), WRITE(PIE->PIECTRL, 1u), "vector of the trip"},
        {WRITE(PIE->PIECTRL, 1u), WRITE(PIE->group[0].IER, 1u), "interrupts"},
        {WRITE(ADC->ADCREFSEL, 0x1234u), CONVERTER_ON, "reference"},
        {WRITE(ADC->ADCOFFTRIM, 0x01F3u), CONVERTER_ON, "offset"},
        {CONVERTER_ON, WRITE(ADC->ADCTRL2, ANY), "converter"},
    };
    for (uint32_t n = 0; n < sizeof orders / sizeof orders[0]; n++) {
        expect_order(&orders[n].first, &orders[n].then, orders[n].why);
    }
    for (uint16_t n = 1u; n <= 3u; n++) {
        const event_t safe[] = {WRITE(EPWM(n)->TZCTL, ANY), WRITE(EPWM(n)->TZSEL, ANY),
                                WRITE(EPWM(n)->DBCTL, ANY)};
        const event_t trip = WRITE(EPWM(n)->TZFRC, TZ_OST), pins = PINS_CONNECTED;
        for (uint32_t m = 0; m < 3u; m++) {
            expect_order(&safe[m], &trip, "the action of a trip is set before the trip");
        }
        expect_order(&trip, &pins, "every leg is tripped before its pins are connected");
        TEST_ASSERT_TRUE(recording_find(0u, &EPWM(n)->TZCLR) == rec.entries);
    }
    for (uint32_t group = 0; group < 12u; group++) {
        const event_t enables = WRITE(PIE->group[group].IER, 0u), requests = WRITE(PIE->group[group].IFR, 0u);
        const event_t vectors = FIRST_VECTOR;
        expect_order(&enables, &vectors, "enables of the PIE");
        expect_order(&requests, &vectors, "requests of the PIE");
    }
    TEST_ASSERT_BITS_MESSAGE(TZ_INT, 0u, EPWM(1u)->TZFLG, "the forced trip must not request an interrupt");
}

/* The waits [cycles]: for the pipeline, for the clock of a module, for a pin after its multiplexer, and
 * for the converter 5 ms at 150 MHz. */
static void test_start_up_waits_for_what_takes_time(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    const struct {
        event_t after;
        uint32_t least, most;
    } waits[] = {{WRITE(FLASH_REGS->FOPT, ANY), 8u, ANY},
                 {WRITE(SYSCTRL->PCLKCR3, ANY), 2u, ANY},
                 {WRITE(GPIO_CONTROL(0u)->MUX2, 0x05005500u), 2u, ANY},
                 {CONVERTER_ON, 750000u, 900000u}};
    for (uint32_t n = 0; n < sizeof waits / sizeof waits[0]; n++) {
        const entry_t *next = &rec.entry[place_of(&waits[n].after) + 1u];
        TEST_ASSERT_EQUAL(DID_WAIT, next->did);
        TEST_ASSERT_TRUE(next->value >= waits[n].least && next->value < waits[n].most);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, recording_count(&ADC->ADCTRL3));
    for (uint32_t i = 0; i < recording_find(0u, &SYSCTRL->PCLKCR3); i++) {
        const uint32_t address = rec.entry[i].address;
        const bool module = (address >= 0x6800u && address < 0x6B80u) ||
                            (address >= 0x7050u && address < 0x7060u) ||
                            (address >= 0x7100u && address < 0x7120u);
        ASSERT(!module, "module written without clock");
    }
}

static void test_a_debugger_may_look_while_the_program_runs_and_halts_the_background_only(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    TEST_ASSERT_TRUE(rec.debug_allowed);
    TEST_ASSERT_EQUAL_HEX16(0x2003u, rec.debug_groups);
    TEST_ASSERT_EQUAL_HEX16(rec.groups & ~0x0100u,
                            rec.debug_groups); /* received octets may wait for the background task */
}

static void test_an_erased_calibration_is_left_alone(void)
{
    rec.otp[0] = 0x1234u;
    rec.otp[1] = 0xFFFFu;
    TEST_ASSERT_EQUAL(HAL_OK, start());
    TEST_ASSERT_EQUAL_UINT32(0u, recording_count(&ADC->ADCREFSEL));
    TEST_ASSERT_EQUAL_UINT32(0u, recording_count(&ADC->ADCOFFTRIM));
}

/* ---- Start-up: refusals ---- */

static void assert_refused_untouched(void)
{
    TEST_ASSERT_EQUAL(HAL_BAD_CONFIG, start());
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, rec.entries, "the chip was accessed");
}

/* The refused values are a dead band outside its limits, a count of the encoder that does not match four
 * edges per line, and a missing function. */
static void test_a_configuration_out_of_its_range_is_refused(void)
{
    static const struct {
        uint16_t dead_band;
        uint32_t count_max;
        uint32_t missing; /* number of the missing function from 1; 0: none */
        bool taken;
    } cases[] = {{299u, COUNT_MAX, 0u, false}, {1024u, COUNT_MAX, 0u, false}, {0u, COUNT_MAX, 0u, false},
                 {300u, COUNT_MAX, 0u, true},  {1023u, COUNT_MAX, 0u, true},  {375u, 0u, 0u, false},
                 {375u, 1u, 0u, false},        {375u, 2u, 0u, false},         {375u, 4u, 0u, false},
                 {375u, 9998u, 0u, false},     {375u, 10000u, 0u, false},     {375u, 0xFFFFFFFEu, 0u, false},
                 {375u, 3u, 0u, true},         {375u, 65535u, 0u, true},      {375u, COUNT_MAX, 1u, false},
                 {375u, COUNT_MAX, 2u, false}, {375u, COUNT_MAX, 3u, false}};
    for (uint32_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        config = (hal_config_t){cases[n].dead_band,
                                cases[n].count_max,
                                cases[n].missing == 1u ? NULL : on_sample,
                                cases[n].missing == 2u ? NULL : on_medium,
                                cases[n].missing == 3u ? NULL : on_trip,
                                on_serial};
        if (!cases[n].taken) {
            assert_refused_untouched();
            continue;
        }
        TEST_ASSERT_EQUAL(HAL_OK, start());
        TEST_ASSERT_EQUAL_UINT16(cases[n].dead_band, EPWM(3u)->DBFED);
        TEST_ASSERT_EQUAL_UINT16(cases[n].dead_band, EPWM(2u)->DBRED);
        TEST_ASSERT_EQUAL_UINT32(cases[n].count_max, EQEP(1u)->QPOSMAX);
    }
    setUp();
    TEST_ASSERT_EQUAL(HAL_BAD_CONFIG, hal_init(NULL));
    TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
}

static void assert_left_safe_and_slow(void)
{
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0u, GPIO_CONTROL(0u)->MUX1, "pins connected");
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(0u, SYSCTRL->PCLKCR1, "modules have a clock");
    TEST_ASSERT_TRUE_MESSAGE((SYSCTRL->PLLSTS & PLLSTS_DIVSEL_ALL) != PLLSTS_DIVSEL(3u), "undivided clock");
    TEST_ASSERT_BITS_MESSAGE(PLLSTS_MCLKOFF, 0u, SYSCTRL->PLLSTS, "clock-loss detector left off");
    TEST_ASSERT_FALSE(rec.interrupts_on);
    TEST_ASSERT_FALSE(hal_gates_on());
    assert_every_write_is_as_the_register_wants_it();
}

/* A clock that is missing from the start leaves the PLL unchanged. If the clock is lost during the lock,
 * or the lock comes a cycle too late, the PLL keeps its divider. If a leg ignores its trip, all gate pins
 * stay disconnected. The chip runs at 7.5 MHz while it waits for the lock: it waits for at least three
 * lock times and at most 150 ms. */
static void test_a_start_that_fails_leaves_the_board_safe(void)
{
    static const struct {
        bool missing, lost;
        uint64_t lock;      /* [cycles] */
        uint16_t trip_deaf; /* bit of the leg that ignores its trip */
        hal_status_t status;
    } cases[] = {{true, false, 32768u, 0u, HAL_CLOCK_MISSING},
                 {false, true, 32768u, 0u, HAL_CLOCK_MISSING},
                 {false, false, UINT64_MAX, 0u, HAL_PLL_UNLOCKED},
                 {false, false, 4096u * 256u + 1u, 0u, HAL_PLL_UNLOCKED},
                 {false, false, 32768u, 1u, HAL_TRIP_FAILED},
                 {false, false, 32768u, 2u, HAL_TRIP_FAILED},
                 {false, false, 32768u, 4u, HAL_TRIP_FAILED},
                 {false, false, 4096u * 256u, 0u, HAL_OK}};
    for (uint32_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        rec.regs.sysctrl.PLLSTS |= cases[n].missing ? PLLSTS_MCLKSTS : 0u;
        rec.loses_clock_at_lock = cases[n].lost;
        rec.lock_cycles = cases[n].lock;
        rec.trip_deaf = cases[n].trip_deaf;
        TEST_ASSERT_EQUAL(cases[n].status, start());
        if (cases[n].status == HAL_OK) {
            continue;
        }
        TEST_ASSERT_EQUAL(cases[n].missing, recording_count(&SYSCTRL->PLLCR) == 0u);
        TEST_ASSERT_EQUAL(cases[n].missing, recording_count(&SYSCTRL->PLLSTS) == 0u);
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(0u, GPIO_CONTROL(0u)->MUX1, "pins connected");
        TEST_ASSERT_FALSE(rec.interrupts_on);
        TEST_ASSERT_FALSE(hal_gates_on());
        if (cases[n].status != HAL_TRIP_FAILED) {
            TEST_ASSERT_TRUE(cases[n].missing || (SYSCTRL->PLLSTS & PLLSTS_DIVSEL_ALL) == 0u);
            assert_left_safe_and_slow();
        }
        if (cases[n].status == HAL_PLL_UNLOCKED) {
            TEST_ASSERT_TRUE(rec.waited >= 3u * 32768u && rec.waited <= 7500u * 150u);
        }
    }
}

/* ---- Gates ---- */

static void start_and_forget(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, start());
    recording_clear_log();
}

static void pull_fault_line(bool low)
{
    rec.regs.gpio_data[0].DAT = low ? 0xFFFFEFFFu : 0xFFFFFFFFu;
}

static uint16_t legs_tripped(void)
{
    return (uint16_t)((EPWM(1u)->TZFLG & TZ_OST) / TZ_OST + (EPWM(2u)->TZFLG & TZ_OST) / TZ_OST +
                      (EPWM(3u)->TZFLG & TZ_OST) / TZ_OST);
}

static void test_gates_come_on_after_start_up_and_arm_the_trip_interrupt(void)
{
    start_and_forget();
    TEST_ASSERT_TRUE(hal_gates_on());
    TEST_ASSERT_EQUAL_UINT16(0u, legs_tripped());
    TEST_ASSERT_EQUAL_HEX16(0x0004u, EPWM(1u)->TZEINT);
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(2u)->TZEINT | EPWM(3u)->TZEINT);
    const uint32_t arm = recording_find(0u, &EPWM(1u)->TZEINT);
    for (uint16_t n = 1u; n <= 3u; n++) {
        ASSERT(recording_find_value(0u, &EPWM(n)->TZCLR, 0x0005u) < arm,
               "the interrupt was enabled before the trip was cleared");
    }
    TEST_ASSERT_EQUAL_UINT32(4u, rec.entries);
}

static void test_gates_that_are_on_are_left_alone(void)
{
    start_and_forget();
    TEST_ASSERT_TRUE(hal_gates_on());
    recording_clear_log();
    TEST_ASSERT_TRUE(hal_gates_on());
    TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
}

static void test_gates_stay_off_while_the_fault_line_is_low(void)
{
    start_and_forget();
    pull_fault_line(true);
    TEST_ASSERT_FALSE(hal_gates_on());
    TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
    TEST_ASSERT_EQUAL_UINT16(3u, legs_tripped());
    pull_fault_line(false);
    TEST_ASSERT_TRUE(hal_gates_on());
}

static void test_only_pin_12_is_the_fault_line(void)
{
    start_and_forget();
    rec.regs.gpio_data[0].DAT = 0x00001000u;
    TEST_ASSERT_TRUE(hal_gates_on());
}

static void test_trip_that_comes_back_at_once_shuts_all_legs(void)
{
    for (uint16_t n = 0; n < 3u; n++) {
        recording_reset();
        start_and_forget();
        rec.trip_again = (uint16_t)(1u << n);
        TEST_ASSERT_FALSE(hal_gates_on());
        TEST_ASSERT_EQUAL_UINT16(3u, legs_tripped());
        TEST_ASSERT_EQUAL_HEX16(0u, EPWM(1u)->TZEINT);
    }
}

static void test_gates_stay_off_when_a_safety_register_has_changed(void)
{
    for (uint16_t leg = 0; leg < 3u; leg++) {
        for (uint32_t kind = 0; kind < 5u; kind++) {
            recording_reset();
            start_and_forget();
            epwm_regs_t *regs = &rec.regs.epwm[leg];
            uint16_t *const changed[] = {&regs->DBCTL, &regs->DBRED, &regs->DBFED, &regs->TZSEL,
                                         &regs->TZCTL};
            *changed[kind] = kind == 1u || kind == 2u ? 299u : 0u;
            TEST_ASSERT_FALSE(hal_gates_on());
            TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
        }
    }
}

static void test_gates_come_on_with_the_shortest_and_the_longest_dead_band(void)
{
    start_and_forget();
    TEST_ASSERT_TRUE(hal_set_dead_band(300u));
    TEST_ASSERT_TRUE(hal_gates_on());
    hal_gates_off();
    TEST_ASSERT_TRUE(hal_set_dead_band(1023u));
    TEST_ASSERT_TRUE(hal_gates_on());
}

static void test_gates_off_trips_all_legs_without_interrupt(void)
{
    start_and_forget();
    TEST_ASSERT_TRUE(hal_gates_on());
    recording_clear_log();
    hal_gates_off();
    TEST_ASSERT_EQUAL_UINT16(3u, legs_tripped());
    TEST_ASSERT_BITS_MESSAGE(TZ_INT, 0u, EPWM(1u)->TZFLG, "a forced trip must not request an interrupt");
    TEST_ASSERT_EQUAL_UINT32(4u, rec.entries);
    TEST_ASSERT_TRUE(hal_gates_on());
}

static void test_compare_values_reach_their_legs_and_end_at_full_duty(void)
{
    start_and_forget();
    hal_write_compare(300u, 3750u, 7200u);
    TEST_ASSERT_EQUAL_UINT16(300u, EPWM(1u)->CMPA);
    TEST_ASSERT_EQUAL_UINT16(3750u, EPWM(2u)->CMPA);
    TEST_ASSERT_EQUAL_UINT16(7200u, EPWM(3u)->CMPA);
    TEST_ASSERT_EQUAL_UINT32(3u, rec.entries);
    hal_write_compare(0u, 7500u, 7501u);
    TEST_ASSERT_EQUAL_UINT16(0u, EPWM(1u)->CMPA);
    TEST_ASSERT_EQUAL_UINT16(7500u, EPWM(2u)->CMPA);
    TEST_ASSERT_EQUAL_UINT16(7500u, EPWM(3u)->CMPA);
    hal_write_compare(65535u, 7501u, 1u);
    TEST_ASSERT_EQUAL_UINT16(7500u, EPWM(1u)->CMPA);
    TEST_ASSERT_EQUAL_UINT16(7500u, EPWM(2u)->CMPA);
    TEST_ASSERT_EQUAL_UINT16(1u, EPWM(3u)->CMPA);
}

static void test_dead_band_and_encoder_stay_unless_every_leg_is_tripped(void)
{
    for (uint32_t n = 0; n < 4u; n++) { /* n < 3: leg n alone is on; n = 3: all legs are on */
        recording_reset();
        start_and_forget();
        for (uint32_t leg = 0; leg < 3u; leg++) {
            rec.regs.epwm[leg].TZFLG = n == leg || n == 3u ? 0u : TZ_OST;
        }
        TEST_ASSERT_FALSE(hal_set_dead_band(400u));
        TEST_ASSERT_FALSE(hal_set_encoder(3999u));
        TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
    }
}

/* ---- Sample ---- */

static uint32_t carrier_start; /* hal_time() at t_0 */

/* Sets time, carrier and unit timer to the values that the hardware has `ticks` after t_0. */
static void at(uint32_t ticks)
{
    const uint32_t phase = ticks % PERIOD;
    rec.regs.cpu_timer[0].TIM = UINT32_MAX - (carrier_start + ticks);
    rec.regs.epwm[0].TBSTS = phase < PERIOD / 2u ? TBSTS_CTRDIR : 0u;
    rec.regs.epwm[0].TBCTR = (uint16_t)(phase < PERIOD / 2u ? phase : PERIOD - phase);
    rec.regs.eqep[0].QUTMR = phase;
}

static void start_carrier(void)
{
    start_and_forget();
    carrier_start = hal_time();
    at(0u);
}

static hal_samples_t sample_at(uint32_t ticks)
{
    hal_samples_t samples;
    memset(&samples, 0x5A, sizeof samples);
    at(ticks);
    hal_read(&samples);
    return samples;
}

static void test_sample_drops_the_first_pair_and_reads_the_right_justified_results(void)
{
    start_carrier();
    for (uint16_t n = 0; n < 16u; n++) {
        rec.regs.adc_mirror.ADCRESULT[n] = (uint16_t)(100u + n);
        rec.regs.adc.ADCRESULT[n] = (uint16_t)((100u + n) << 4);
    }
    rec.regs.eqep[0].QPOSLAT = 0x12345u;
    rec.regs.eqep[0].QPOSCNT = 0x12399u;
    const hal_samples_t samples = sample_at(PERIOD + 100u);
    TEST_ASSERT_EQUAL_UINT16(102u, samples.current_a);         /* channel A0, second sample */
    TEST_ASSERT_EQUAL_UINT16(103u, samples.current_b);         /* channel B0 */
    TEST_ASSERT_EQUAL_UINT16(104u, samples.dc_link);           /* channel A1 */
    TEST_ASSERT_EQUAL_UINT16(105u, samples.sink_temperature);  /* channel B1 */
    TEST_ASSERT_EQUAL_UINT16(106u, samples.motor_temperature); /* channel A2 */
    TEST_ASSERT_EQUAL_HEX32(0x12345u, samples.encoder);
    TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_TRIPPED, samples.flags);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(1u, rec.entries, "a sample makes one write");
}

static void test_each_sample_reports_whether_the_enable_input_is_active(void)
{
    start_carrier();
    TEST_ASSERT_TRUE(hal_gates_on());
    TEST_ASSERT_EQUAL_HEX16(0u, sample_at(PERIOD + 100u).flags);
    rec.regs.gpio_data[0].DAT &= ~0x08000000u;
    TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_NOT_ENABLED, sample_at(2u * PERIOD + 100u).flags);
    rec.regs.gpio_data[0].DAT |= 0x08000000u;
    TEST_ASSERT_EQUAL_HEX16(0u, sample_at(3u * PERIOD + 100u).flags);
}

static void test_flags_distinguish_trip_and_fault_line(void)
{
    start_carrier();
    TEST_ASSERT_TRUE(hal_gates_on());
    TEST_ASSERT_EQUAL_HEX16(0u, sample_at(PERIOD + 100u).flags);
    pull_fault_line(true);
    TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_FAULT_PIN, sample_at(2u * PERIOD + 100u).flags);
    pull_fault_line(false);
    for (uint32_t n = 0; n < 3u; n++) {
        rec.regs.epwm[n].TZFLG = TZ_OST;
        TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_TRIPPED, sample_at((3u + n) * PERIOD + 100u).flags);
        rec.regs.epwm[n].TZFLG = TZ_CBC | TZ_INT;
    }
    TEST_ASSERT_EQUAL_HEX16(0u, sample_at(6u * PERIOD + 100u).flags);
}

static void test_phase_error_of_the_encoder_is_reported_once(void)
{
    start_carrier();
    TEST_ASSERT_TRUE(hal_gates_on());
    rec.regs.eqep[0].QFLG = QEP_PHE | QEP_UTO;
    recording_clear_log();
    TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_ENCODER, sample_at(PERIOD + 100u).flags);
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(QEP_UTO, EQEP(1u)->QFLG, "another flag than the error was cleared");
    TEST_ASSERT_EQUAL_HEX16(0u, sample_at(2u * PERIOD + 100u).flags);
}

/* ---- A late interrupt: t_k is found again, one period after the last ---- */

static uint16_t late_at(uint32_t ticks)
{
    return sample_at(ticks).flags & HAL_FLAG_LATE;
}

/* The events of a course are a sample that is in time, a sample that is late, and the end of the
 * interrupt. */
typedef enum { NO_MORE, IN_TIME, LATE, ENDS } timing_t;

/* Events from a start of the carrier on; each is at tick `at` of period `period`. */
static const struct {
    const char *name;
    struct {
        timing_t event;
        uint32_t period, at;
    } step[12];
} courses[] = {
    {"anywhere in its period",
     {{IN_TIME, 1, 90},
      {IN_TIME, 2, 5000},
      {IN_TIME, 3, 7499},
      {IN_TIME, 4, 7500},
      {IN_TIME, 5, 7501},
      {IN_TIME, 6, 14000},
      {IN_TIME, 7, 14912},
      {IN_TIME, 8, 90},
      {IN_TIME, 9, 1},
      {IN_TIME, 10, 0}}},
    {"after the next conversion began",
     {{IN_TIME, 1, PERIOD - 88}, {LATE, 2, PERIOD - 87}, {LATE, 3, PERIOD - 1}, {IN_TIME, 4, 100}}},
    {"in the next period", /* the second sample belongs to period 2 */
     {{IN_TIME, 1, 100}, {LATE, 3, 100}, {IN_TIME, 4, 100}, {LATE, 7, 100}}},
    {"a second one of the same period", {{IN_TIME, 1, 100}, {LATE, 1, 2000}, {IN_TIME, 2, 100}}},
    {"the first one", {{IN_TIME, 1, 80}}},
    {"the first one, of the second period", {{LATE, 2, 80}}},
    {"after an interrupt that ended after the next conversion began",
     {{IN_TIME, 1, 100},
      {ENDS, 1, PERIOD - 88},
      {IN_TIME, 2, 100},
      {ENDS, 2, PERIOD - 87},
      {LATE, 3, 100},
      {ENDS, 3, 3000},
      {IN_TIME, 4, 100}}},
    {"lost after an interrupt that was too long",
     {{IN_TIME, 1, 100}, {ENDS, 2, 1000}, {LATE, 3, 100}, {IN_TIME, 4, 100}}},
};

static void test_a_sample_is_late_unless_its_own_period_goes_on(void)
{
    for (uint32_t n = 0; n < sizeof courses / sizeof courses[0]; n++) {
        start_carrier();
        for (uint32_t k = 0; k < 12u && courses[n].step[k].event != NO_MORE; k++) {
            const uint32_t ticks = courses[n].step[k].period * PERIOD + courses[n].step[k].at;
            if (courses[n].step[k].event == ENDS) {
                at(ticks);
                hal_end_of_sample();
            } else {
                TEST_ASSERT_EQUAL_HEX16_MESSAGE(courses[n].step[k].event == LATE ? HAL_FLAG_LATE : 0u,
                                                late_at(ticks), courses[n].name);
            }
        }
    }
}

/* A halt of the debugger makes such a gap. The same holds for a gap of more than half a turn of the clock. */
static void test_ten_samples_after_a_gap_of_ten_periods_are_late(void)
{
    static const uint32_t gap[] = {10u, 500u, 200000u, 286000u};
    for (uint32_t n = 0; n < sizeof gap / sizeof gap[0]; n++) {
        start_carrier();
        TEST_ASSERT_EQUAL_HEX16(0u, late_at(PERIOD + 100u));
        for (uint32_t k = 0; k < 11u; k++) {
            TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_LATE, late_at((gap[n] + 1u + k) * PERIOD + 100u));
            at((gap[n] + 1u + k) * PERIOD + 3000u);
            hal_end_of_sample();
        }
        TEST_ASSERT_EQUAL_HEX16(0u, late_at((gap[n] + 12u) * PERIOD + 100u));
    }
    start_carrier();
    TEST_ASSERT_EQUAL_HEX16(0u, late_at(PERIOD + 100u));
    TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_LATE, late_at(10u * PERIOD + 100u));
    TEST_ASSERT_EQUAL_HEX16(0u, late_at(11u * PERIOD + 100u));
}

static void test_a_late_sample_is_detected_across_the_wrap_of_the_clock(void)
{
    start_carrier();
    carrier_start = UINT32_MAX - 5u * PERIOD / 2u;
    rec.regs.cpu_timer[1].PRD = carrier_start;
    for (uint32_t k = 1u; k < 6u; k++) {
        TEST_ASSERT_EQUAL_HEX16(0u, late_at(k * PERIOD + 100u));
        at(k * PERIOD + 2000u);
        hal_end_of_sample();
    }
    TEST_ASSERT_EQUAL_HEX16(HAL_FLAG_LATE, late_at(7u * PERIOD + 100u));
}

static void test_end_of_sample_rearms_sequencer_flag_and_group_in_this_order(void)
{
    start_carrier();
    (void)sample_at(PERIOD + 100u);
    recording_clear_log();
    rec.regs.adc.ADCTRL2 = 0xFFFFu; /* the sequencer restart must not write back the bits that it reads */
    hal_end_of_sample();
    TEST_ASSERT_EQUAL_UINT32(3u, rec.entries);
    TEST_ASSERT_EQUAL_UINT32(0u, recording_find_value(0u, &ADC->ADCTRL2, 0x4900u));
    TEST_ASSERT_EQUAL_UINT32(1u, recording_find_value(0u, &ADC->ADCST, 0x0010u));
    TEST_ASSERT_EQUAL_UINT32(2u, recording_find_value(0u, &PIE->PIEACK, 0x0001u));
}

static void test_end_of_trip_acknowledges_its_group_and_leaves_the_trip(void)
{
    start_carrier();
    recording_clear_log();
    rec.regs.pie.PIEACK = 0x0FFFu;
    hal_end_of_trip();
    TEST_ASSERT_EQUAL_UINT32(1u, rec.entries);
    TEST_ASSERT_EQUAL_UINT32(0u, recording_find_value(0u, &PIE->PIEACK, 0x0002u));
    TEST_ASSERT_EQUAL_UINT16(3u, legs_tripped());
}

/* ---- Encoder ---- */

static uint32_t unit_timer_after(int32_t ahead)
{
    start_carrier();
    at(PERIOD + 100u);
    rec.regs.eqep[0].QUTMR = (uint32_t)(100 + ahead);
    hal_samples_t samples;
    hal_read(&samples);
    TEST_ASSERT_EQUAL_HEX16(0u, samples.flags & HAL_FLAG_LATE);
    return EQEP(1u)->QUTMR;
}

static void test_unit_timer_is_put_in_step_when_out_by_more_than_its_tolerance(void)
{
    TEST_ASSERT_EQUAL_UINT32(100u, unit_timer_after(0));
    TEST_ASSERT_EQUAL_UINT32(115u, unit_timer_after(15));
    TEST_ASSERT_EQUAL_UINT32(100u, unit_timer_after(16));
    TEST_ASSERT_EQUAL_UINT32(85u, unit_timer_after(-15));
    TEST_ASSERT_EQUAL_UINT32(100u, unit_timer_after(-16));
    TEST_ASSERT_EQUAL_UINT32(100u, unit_timer_after(7000));
    TEST_ASSERT_EQUAL_UINT32(100u, unit_timer_after(14800));
}

static void test_unit_timer_is_left_alone_by_a_late_sample(void)
{
    start_carrier();
    at(3u * PERIOD + 100u);
    rec.regs.eqep[0].QUTMR = 9000u;
    hal_samples_t samples;
    hal_read(&samples);
    TEST_ASSERT_EQUAL_UINT32(9000u, EQEP(1u)->QUTMR);
}

/* ---- Time, watchdog, interrupt mask ---- */

static void test_time_counts_up_at_150_MHz(void)
{
    recording_soil();
    start_and_forget();
    TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, CPU_TIMER(0u)->PRD);
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(0u, CPU_TIMER(0u)->TPR | CPU_TIMER(0u)->TPRH, "prescaled");
    TEST_ASSERT_BITS(TCR_TSS | TCR_TIE, 0u, CPU_TIMER(0u)->TCR);
    TEST_ASSERT_BITS_MESSAGE(TCR_FREE, TCR_FREE, CPU_TIMER(0u)->TCR,
                             "the timer must count while a debugger halts the CPU");
    TEST_ASSERT_BITS_MESSAGE(TCR_TSS, TCR_TSS, CPU_TIMER(1u)->TCR,
                             "timer 1 holds a value and must not count");
    const uint32_t before = hal_time();
    recording_pass(12345u);
    TEST_ASSERT_EQUAL_UINT32(12345u, hal_time() - before);
    rec.regs.cpu_timer[0].TIM = 0u;
    TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, hal_time());
    rec.regs.cpu_timer[0].TIM = UINT32_MAX;
    TEST_ASSERT_EQUAL_HEX32(0u, hal_time());
}

static void test_watchdog_is_fed_by_its_two_keys_in_order(void)
{
    start_and_forget();
    hal_watchdog_feed();
    TEST_ASSERT_EQUAL_UINT32(2u, rec.entries);
    TEST_ASSERT_EQUAL_UINT32(0u, recording_find_value(0u, &SYSCTRL->WDKEY, 0x55u));
    TEST_ASSERT_EQUAL_UINT32(1u, recording_find_value(0u, &SYSCTRL->WDKEY, 0xAAu));
    assert_every_write_is_as_the_register_wants_it();
}

static void test_watchdog_starts_from_zero_at_279_ms(void)
{
    start_and_forget();
    hal_watchdog_start();
    TEST_ASSERT_EQUAL_UINT32(3u, rec.entries);
    TEST_ASSERT_EQUAL_UINT32(1u, recording_find_value(0u, &SYSCTRL->WDKEY, 0xAAu));
    TEST_ASSERT_EQUAL_UINT32(2u, recording_find_value(0u, &SYSCTRL->WDCR, 0x002Fu));
}

static void test_background_can_bracket_the_interrupt(void)
{
    start_and_forget();
    hal_interrupts_off();
    TEST_ASSERT_FALSE(rec.interrupts_on);
    hal_interrupts_on();
    TEST_ASSERT_TRUE(rec.interrupts_on);
}
