/* The ADC: instants of the hold, results, sequencer, power. Timing by SPRS439: the first window ends 2.5 +
 * ACQ_PS + 1 ADCCLK after the start, each further one 2 (3 for pairs) + ACQ_PS later. The results follow 4
 * (A) and 5 (B) ADCCLK after their window. ADCCLK = 25 MHz = 6 ticks. */
#include <math.h>
#include <stdlib.h>
#include <unity.h>

#include "bench.h"

static uint64_t soc;

void setUp(void)
{
    bench_power_on();
    bench_clock();
    bench_adc(SKIP_SOC);
    for (uint32_t channel = 0u; channel < 16u; channel++) {
        bench.volts[channel] = 0.1 * (double)(channel + 1u);
    }
}

static void software_start(void)
{
    bench_forget();
    soc = chip_now(&bench_chip);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_SOC_SEQ1);
}

static uint16_t code(uint32_t channel)
{
    return (uint16_t)floor(4096.0 * bench.volts[channel] / 3.0);
}

static void test_pairs_are_held_together_at_the_data_sheet_ticks(void)
{
    software_start();
    chip_run(soc + 1000u);
    static const uint32_t channel[] = {0u, 8u, 0u, 8u, 1u, 9u, 2u, 10u};
    TEST_ASSERT_EQUAL_UINT32(8u, bench.samples);
    for (uint32_t i = 0u; i < 8u; i++) {
        /* The first window after 7.5 ADCCLK, the others every 7. */
        TEST_ASSERT_EQUAL_UINT64(soc + 45u + 42u * (i / 2u), bench.sample[i].tick);
        TEST_ASSERT_EQUAL_UINT32(channel[i], bench.sample[i].channel);
        TEST_ASSERT_EQUAL_UINT16(code(channel[i]), ADC_MIRROR->ADCRESULT[i]);
        TEST_ASSERT_EQUAL_UINT16(code(channel[i]) << 4, ADC->ADCRESULT[i]);
    }
}

static void test_second_pair_is_held_at_counter_zero(void)
{
    setUp();
    bench_start(0u);
    uint64_t zero = chip_now(&bench_chip) + 3u * CARRIER;
    bench_forget();
    chip_run(zero + 100u);
    /* The pairs are held at -42, 0, 42, 84. */
    TEST_ASSERT_EQUAL_UINT64(zero, bench.sample[bench.samples - 5u].tick);
    TEST_ASSERT_EQUAL_UINT64(zero, chip_carrier_tick(&bench_chip));
}

static void test_results_appear_one_by_one(void)
{
    software_start();
    chip_run(soc + 45u + 24u); /* the first result comes 4 ADCCLK after the first window */
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(code(0u), ADC_MIRROR->ADCRESULT[0]);
    TEST_ASSERT_EQUAL_UINT16(0u, ADC_MIRROR->ADCRESULT[1]);
    chip_run(soc + 45u + 29u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(0u, ADC_MIRROR->ADCRESULT[1]);
    chip_run(soc + 45u + 30u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(code(8u), ADC_MIRROR->ADCRESULT[1]);
    TEST_ASSERT_EQUAL_UINT16(0u, ADC_MIRROR->ADCRESULT[2]);
    TEST_ASSERT_EQUAL_HEX16(ADCST_SEQ1_BSY, ADC->ADCST);
}

static void test_end_of_sequence_is_the_last_result(void)
{
    software_start();
    uint64_t end = soc + 45u + 3u * 42u + 30u;
    chip_run(end);
    TEST_ASSERT_EQUAL_HEX16(ADCST_SEQ1_BSY, ADC->ADCST);
    chip_run(end + 1u);
    TEST_ASSERT_EQUAL_HEX16(ADCST_INT_SEQ1, ADC->ADCST);
    bus_write16(&ADC->ADCST, ADCST_INT_SEQ1_CLR);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCST);
}

static void test_sequential_timing_and_channels(void)
{
    bus_write16(&ADC->ADCTRL3, 0x00E0u);
    bus_write16(&ADC->ADCTRL1, ADCTRL1_SEQ_CASC | ADCTRL1_ACQ_PS(1));
    bus_write16(&ADC->ADCMAXCONV, 4u);
    bus_write16(&ADC->ADCCHSELSEQ[0], 0xF3A0u);
    bus_write16(&ADC->ADCCHSELSEQ[1], 0x0005u);
    software_start();
    chip_run(soc + 1000u);
    static const uint32_t channel[] = {0u, 10u, 3u, 15u, 5u};
    TEST_ASSERT_EQUAL_UINT32(5u, bench.samples);
    for (uint32_t i = 0u; i < 5u; i++) {
        /* The first window after 4.5 ADCCLK, the others every 3. */
        TEST_ASSERT_EQUAL_UINT64(soc + 27u + 18u * i, bench.sample[i].tick);
        TEST_ASSERT_EQUAL_UINT32(channel[i], bench.sample[i].channel);
        TEST_ASSERT_EQUAL_UINT16(code(channel[i]), ADC_MIRROR->ADCRESULT[i]);
    }
}

static void test_clock_prescalers(void)
{
    /* HISPCP 3 divides by 6, ADCCLKPS 2 by 4, CPS by 2: a cycle has 48 ticks. With ACQ_PS 0 the window
     * ends after 3.5 ADCCLK. */
    bus_write16(&ADC->ADCTRL3, 0x00E0u | ADCTRL3_ADCCLKPS(2));
    bus_write16(&ADC->ADCTRL1, ADCTRL1_SEQ_CASC | ADCTRL1_CPS);
    bus_write16(&ADC->ADCMAXCONV, 1u);
    software_start();
    chip_run(soc + 10000u);
    TEST_ASSERT_EQUAL_UINT64(soc + 168u, bench.sample[0].tick);
    TEST_ASSERT_EQUAL_UINT64(soc + 168u + 96u, bench.sample[1].tick);
}

/* Sequences of two to eight pairs, with every channel once: CONV00..07 are in the first two channel
 * registers. */
static void test_sequences_of_two_to_eight_pairs(void)
{
    for (uint32_t pairs = 2u; pairs <= 8u; pairs++) {
        bus_write16(&ADC->ADCMAXCONV, (uint16_t)(pairs - 1u));
        bus_write16(&ADC->ADCCHSELSEQ[0], 0x4567u);
        bus_write16(&ADC->ADCCHSELSEQ[1], 0x0123u);
        bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
        bus_write16(&ADC->ADCST, ADCST_INT_SEQ1_CLR);
        for (uint32_t channel = 0u; channel < 16u; channel++) {
            bench.volts[channel] = 0.01 * pairs + 0.1 * (double)(channel + 1u);
        }
        software_start();
        uint64_t end = soc + 45u + 42u * (pairs - 1u) + 30u;
        chip_run(end);
        TEST_ASSERT_EQUAL_HEX16(ADCST_SEQ1_BSY, ADC->ADCST);
        chip_run(end + 1u);
        TEST_ASSERT_EQUAL_HEX16(ADCST_INT_SEQ1, ADC->ADCST);
        TEST_ASSERT_EQUAL_UINT32(2u * pairs, bench.samples);
        for (uint32_t i = 0u; i < 2u * pairs; i++) {
            uint32_t channel = 7u - i / 2u + 8u * (i % 2u);
            TEST_ASSERT_EQUAL_UINT64(soc + 45u + 42u * (i / 2u), bench.sample[i].tick);
            TEST_ASSERT_EQUAL_UINT32(channel, bench.sample[i].channel);
            TEST_ASSERT_EQUAL_UINT16(code(channel), ADC_MIRROR->ADCRESULT[i]);
        }
    }
}

static void test_sixteen_single_conversions_use_all_four_channel_registers(void)
{
    bus_write16(&ADC->ADCTRL3, 0x00E0u);
    bus_write16(&ADC->ADCMAXCONV, 15u);
    bus_write16(&ADC->ADCCHSELSEQ[0], 0xCDEFu);
    bus_write16(&ADC->ADCCHSELSEQ[1], 0x89ABu);
    bus_write16(&ADC->ADCCHSELSEQ[2], 0x4567u);
    bus_write16(&ADC->ADCCHSELSEQ[3], 0x0123u);
    software_start();
    chip_run(soc + 2000u);
    TEST_ASSERT_EQUAL_UINT32(16u, bench.samples);
    for (uint32_t i = 0u; i < 16u; i++) {
        TEST_ASSERT_EQUAL_UINT32(15u - i, bench.sample[i].channel);
        TEST_ASSERT_EQUAL_UINT16(code(15u - i), ADC_MIRROR->ADCRESULT[i]);
    }
}

/* SEQ1 alone has eight states and eight results; after the last state and result it continues with the
 * first. */
static void test_uncascaded_sequencer_goes_round_in_eight_results(void)
{
    bus_write16(&ADC->ADCTRL1, ADCTRL1_ACQ_PS(4));
    bus_write16(&ADC->ADCMAXCONV, 2u);
    bus_write16(&ADC->ADCCHSELSEQ[0], 0x3210u);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
    software_start();
    chip_run(soc + 1000u);
    software_start(); /* converts states 3, 0, 1 */
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT32(3u, bench.sample[0].channel);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.sample[2].channel);
    TEST_ASSERT_EQUAL_UINT16(code(3u), ADC_MIRROR->ADCRESULT[6]);
    TEST_ASSERT_EQUAL_UINT16(code(0u), ADC_MIRROR->ADCRESULT[0]);
    TEST_ASSERT_EQUAL_UINT16(0u, ADC_MIRROR->ADCRESULT[8]);
}

static uint16_t converted(double volts)
{
    bench.volts[0] = volts;
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
    software_start();
    chip_run(soc + 1000u);
    return ADC_MIRROR->ADCRESULT[0];
}

static int32_t trim_of(uint16_t word)
{
    return (word & 0x0100u) != 0u ? (int32_t)(word & 0x01FFu) - 512 : (int32_t)(word & 0x01FFu);
}

static void test_boot_rom_has_copied_the_calibration(void)
{
    TEST_ASSERT_EQUAL_HEX16(bus_otp(0x380083u), ADC->ADCREFSEL);
    TEST_ASSERT_EQUAL_HEX16(bus_otp(0x380085u), ADC->ADCOFFTRIM);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCREFSEL & 0xC000u); /* the reference is internal */
    TEST_ASSERT_TRUE(ADC->ADCREFSEL != 0u && ADC->ADCOFFTRIM != 0u);
    TEST_ASSERT_TRUE_MESSAGE(abs(trim_of(ADC->ADCOFFTRIM)) <= 15, "the data sheet's offset error");
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_otp(0x380084u));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFu, bus_otp(0x380400u));
    TEST_ASSERT_EQUAL_UINT16(2048u, converted(1.5));
}

/* If a debugger starts the program, the boot ROM has not copied the two calibration words. */
static void test_uncalibrated_converter_is_off_until_software_copies_the_words(void)
{
    chip_power_on_by_debugger(&bench_chip, 30000000u);
    /* The boot ROM has not set the divider /2 either. */
    TEST_ASSERT_EQUAL_UINT32(7500000u, chip_sysclk_hz(&bench_chip));
    bench_clock();
    bench_adc(SKIP_SOC);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCREFSEL | ADC->ADCOFFTRIM);
    int32_t missing = trim_of(bus_otp(0x380085u));
    int32_t low = (int32_t)converted(0.3) - 409;
    int32_t high = (int32_t)converted(2.7) - 3686;
    int32_t gain = high - low; /* gain error over 3277 codes */
    TEST_ASSERT_TRUE_MESSAGE(gain <= -10 || gain >= 10, "a gain error");
    TEST_ASSERT_TRUE_MESSAGE(gain >= -30 && gain <= 30, "within the data sheet");
    TEST_ASSERT_INT32_WITHIN(1, -missing + gain * 409 / 3277, low);
    bus_write16(&ADC->ADCREFSEL, bus_otp(0x380083u));
    TEST_ASSERT_EQUAL_UINT16(2048 - missing, converted(1.5)); /* only the offset error remains */
    bus_write16(&ADC->ADCOFFTRIM, bus_otp(0x380085u));
    TEST_ASSERT_EQUAL_UINT16(409u, converted(0.3));
    TEST_ASSERT_EQUAL_UINT16(3686u, converted(2.7));
    bus_write16(&ADC->ADCREFSEL, 0u);
    TEST_ASSERT_INT32_WITHIN(1, 3686 + gain * 3686 / 3277, converted(2.7));
}

static void test_module_reset_and_chip_reset_treat_the_calibration_differently(void)
{
    bus_write16(&ADC->ADCTRL1, ADCTRL1_RESET);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCREFSEL | ADC->ADCOFFTRIM);
    bus_allow();
    bus_write16(&SYSCTRL->WDKEY, 1u); /* resets the chip; the boot ROM runs after it */
    TEST_ASSERT_EQUAL_HEX16(bus_otp(0x380083u), ADC->ADCREFSEL);
    TEST_ASSERT_EQUAL_HEX16(bus_otp(0x380085u), ADC->ADCOFFTRIM);
}

static void test_code_is_floor_and_clamped(void)
{
    static const double volts[] = {-1.0, 0.0, 3.0 / 4096.0, 3.0 / 4096.0 * 0.999999, 1.5, 2.9999, 3.0, 5.0};
    static const uint16_t expected[] = {0u, 0u, 1u, 0u, 2048u, 4095u, 4095u, 4095u};
    for (uint32_t i = 0u; i < 8u; i++) {
        bench.volts[0] = volts[i];
        bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
        software_start();
        chip_run(soc + 1000u);
        TEST_ASSERT_EQUAL_UINT16(expected[i], ADC_MIRROR->ADCRESULT[0]);
    }
    bench.volts[0] = (double)NAN;
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT16(0u, ADC_MIRROR->ADCRESULT[0]);
}

static void test_offset_trim_is_signed(void)
{
    bench.volts[0] = 1.5;
    bus_write16(&ADC->ADCOFFTRIM, (bus_otp(0x380085u) - 2u) & 0x01FFu);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT16(2046u, ADC_MIRROR->ADCRESULT[0]);
}

static void test_start_stop_mode_goes_on_behind_the_last_state(void)
{
    bus_write16(&ADC->ADCMAXCONV, 2u);
    bus_write16(&ADC->ADCCHSELSEQ[0], 0x3210u);
    bus_write16(&ADC->ADCCHSELSEQ[1], 0x7654u);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_HEX16(0x0003u, ADC->ADCASEQSR);
    software_start(); /* without RST_SEQ1 */
    chip_run(soc + 1000u);
    static const uint32_t channel[] = {3u, 11u, 4u, 12u, 5u, 13u};
    for (uint32_t i = 0u; i < 6u; i++) {
        TEST_ASSERT_EQUAL_UINT32(channel[i], bench.sample[i].channel);
        TEST_ASSERT_EQUAL_UINT16(code(channel[i]), ADC_MIRROR->ADCRESULT[6u + i]);
    }
    software_start(); /* converts states 6, 7 and continues at 0 */
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT32(6u, bench.sample[0].channel);
    TEST_ASSERT_EQUAL_UINT32(7u, bench.sample[2].channel);
    TEST_ASSERT_EQUAL_UINT32(0u, bench.sample[4].channel);
    TEST_ASSERT_EQUAL_UINT16(code(8u), ADC_MIRROR->ADCRESULT[1]);
}

static void test_reset_of_the_sequencer_aborts(void)
{
    software_start();
    chip_run(soc + 50u);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCST);
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT32(2u, bench.samples);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCST);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT32(8u, bench.samples);
}

static void test_start_while_busy_waits_once(void)
{
    software_start();
    chip_run(soc + 100u);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_SOC_SEQ1);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_SOC_SEQ1);
    TEST_ASSERT_EQUAL_UINT32(2u, chip_report_count(&bench_chip, CHIP_ADC_OVERRUN));
    chip_run(soc + 2000u);
    TEST_ASSERT_EQUAL_UINT32(16u, bench.samples);
    TEST_ASSERT_EQUAL_UINT64(soc + 201u + 45u, bench.sample[8].tick);
}

static void test_interrupt_mode_one_takes_every_other(void)
{
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_INT_MOD_SEQ1);
    for (uint32_t i = 0u; i < 4u; i++) {
        bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_INT_MOD_SEQ1 | ADCTRL2_SOC_SEQ1);
        chip_run(chip_now(&bench_chip) + 1000u);
        TEST_ASSERT_EQUAL_HEX16(i % 2u, ADC->ADCST & ADCST_INT_SEQ1);
        bus_write16(&ADC->ADCST, ADCST_INT_SEQ1_CLR);
    }
}

static void test_conversion_before_five_milliseconds_reads_zero(void)
{
    for (uint32_t late = 0u; late < 2u; late++) {
        bench_power_on();
        bench_clock();
        bench.volts[0] = 1.5;
        bus_write16(&ADC->ADCTRL1, 0x0410u);
        bus_write16(&ADC->ADCTRL3, 0x00E1u);
        bus_wait(749999u + late);
        software_start();
        chip_run(soc + 1000u);
        TEST_ASSERT_EQUAL_UINT16(late ? 2048u : 0u, ADC_MIRROR->ADCRESULT[0]);
        TEST_ASSERT_EQUAL_UINT32(late ? 0u : 1u, chip_report_count(&bench_chip, CHIP_ADC_NOT_POWERED));
    }
}

static void test_waking_the_converter_alone_takes_twenty_microseconds(void)
{
    bench.volts[0] = 1.5;
    bus_write16(&ADC->ADCTRL3, 0x00C1u);
    bus_write16(&ADC->ADCTRL3, 0x00E1u);
    bus_wait(2999u);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT16(0u, ADC_MIRROR->ADCRESULT[0]);
    bus_wait(1u);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT16(2048u, ADC_MIRROR->ADCRESULT[0]);
}

static void test_fast_clock_is_reported(void)
{
    bench_allowed16(&SYSCTRL->HISPCP, 1u);
    software_start();
    TEST_ASSERT_EQUAL_UINT32(1u, chip_report_count(&bench_chip, CHIP_ADC_TOO_FAST));
}

static void test_module_reset_forgets_everything(void)
{
    bus_write16(&ADC->ADCTRL1, ADCTRL1_RESET);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCTRL3);
    TEST_ASSERT_EQUAL_HEX16(0u, ADC->ADCMAXCONV);
    software_start();
    TEST_ASSERT_EQUAL_UINT32(1u, chip_report_count(&bench_chip, CHIP_ADC_NOT_POWERED));
}

static void test_stuck_channel(void)
{
    chip_stick_adc(&bench_chip, 8u, 4095);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT16(4095u, ADC_MIRROR->ADCRESULT[1]);
    TEST_ASSERT_EQUAL_UINT16(code(0u), ADC_MIRROR->ADCRESULT[0]);
    chip_stick_adc(&bench_chip, 8u, -1);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
    software_start();
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT16(code(8u), ADC_MIRROR->ADCRESULT[1]);
}

static void test_results_are_read_only(void)
{
    bus_write16(&ADC->ADCRESULT[0], 7u);
    bus_write16(&ADC_MIRROR->ADCRESULT[0], 7u);
    TEST_ASSERT_EQUAL_UINT32(2u, chip_report_count(&bench_chip, CHIP_READ_ONLY));
    TEST_ASSERT_EQUAL_UINT16(0u, ADC->ADCRESULT[0]);
}

static void test_every_nth_event_starts(void)
{
    for (uint16_t n = 0u; n <= 3u; n++) {
        setUp();
        bench_start(0u);
        bus_write16(&EPWM(1u)->ETPS, ETPS_SOCAPRD(n));
        uint64_t from = chip_now(&bench_chip);
        bench_forget();
        chip_run(from + 12u * CARRIER + 200u);
        TEST_ASSERT_EQUAL_UINT32(n == 0u ? 0u : 8u * 12u / n, bench.samples);
    }
}

static void test_events_wait_at_their_count_while_disabled(void)
{
    bench_start(0u);
    bus_write16(&EPWM(1u)->ETSEL, ETSEL_SOCASEL(ET_CMPB_DOWN));
    bus_write16(&EPWM(1u)->ETPS, ETPS_SOCAPRD(3));
    uint64_t from = chip_now(&bench_chip);
    chip_run(from + 5u * CARRIER);
    /* Five events; the counter of the pre-scaler stops at three. */
    TEST_ASSERT_EQUAL_HEX16(3u << 10, EPWM(1u)->ETPS & 0x0C00u);
    bus_write16(&EPWM(1u)->ETSEL, ETSEL_SOCAEN | ETSEL_SOCASEL(ET_CMPB_DOWN));
    bench_forget();
    chip_run(from + 6u * CARRIER + 200u); /* the next event starts a conversion */
    TEST_ASSERT_EQUAL_UINT32(8u, bench.samples);
    chip_run(from + 8u * CARRIER + 200u);
    TEST_ASSERT_EQUAL_UINT32(8u, bench.samples);
    chip_run(from + 9u * CARRIER + 200u);
    TEST_ASSERT_EQUAL_UINT32(16u, bench.samples);
}

static void test_forced_start(void)
{
    bus_write16(&EPWM(1u)->ETSEL, ETSEL_SOCAEN);
    bench_forget();
    soc = chip_now(&bench_chip);
    bus_write16(&EPWM(1u)->ETFRC, ET_FLAG_SOCA);
    chip_run(soc + 1000u);
    TEST_ASSERT_EQUAL_UINT32(8u, bench.samples);
    TEST_ASSERT_EQUAL_HEX16(ET_FLAG_SOCA, EPWM(1u)->ETFLG);
    bus_write16(&EPWM(1u)->ETCLR, ET_FLAG_SOCA);
    TEST_ASSERT_EQUAL_HEX16(0u, EPWM(1u)->ETFLG);
}

static void test_start_at_zero_and_at_period(void)
{
    for (uint16_t event = ET_ZERO; event <= ET_PERIOD; event++) {
        for (uint16_t plain = 0u; plain < 2u; plain++) {
            setUp();
            bench_start(0u);
            uint64_t from = chip_now(&bench_chip);
            bus_write16(&EPWM(1u)->AQCTLB, plain ? 0u : 0x0090u);
            bus_write16(&EPWM(1u)->ETSEL, (uint16_t)(ETSEL_SOCAEN | ETSEL_SOCASEL(event)));
            chip_run(from + 2u * CARRIER + 1000u);
            bench_forget();
            chip_run(from + 3u * CARRIER + 1000u);
            TEST_ASSERT_EQUAL_UINT32(plain, chip_carrier_plain(&bench_chip));
            uint64_t at = from + (event == ET_ZERO ? 3u * CARRIER : 2u * CARRIER + 7500u);
            TEST_ASSERT_EQUAL_UINT64(at + 45u, bench.sample[0].tick);
        }
    }
}
