/* Clocks, flash, watchdog, EALLOW, access widths. The crystal has 30 MHz, so that its cycle is 5 ticks,
 * unless stated otherwise. */
#include <string.h>
#include <unity.h>

#include "bench.h"

#define LOCK     (131072u * 5u)
#define WATCHDOG (256u * 512u * 5u)

void setUp(void)
{
    bench_power_on();
}

static void watchdog_off(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, WDCR_WDDIS | WDCR_WDCHK);
}

static void test_state_after_the_boot_rom(void)
{
    TEST_ASSERT_EQUAL_UINT32(15000000u, chip_sysclk_hz(&bench_chip));
    TEST_ASSERT_EQUAL_HEX16(0x0101u, SYSCTRL->PLLSTS);
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->PLLCR);
    TEST_ASSERT_EQUAL_HEX16(1u, SYSCTRL->HISPCP);
    TEST_ASSERT_EQUAL_HEX16(2u, SYSCTRL->LOSPCP);
    TEST_ASSERT_EQUAL_HEX16(0x2700u, SYSCTRL->PCLKCR3);
    TEST_ASSERT_EQUAL_HEX16(0x0F0Fu, FLASH_REGS->FBANKWAIT);
    TEST_ASSERT_EQUAL_HEX16(0x0FFFu, GPIO_CONTROL(0u)->PUD);
    TEST_ASSERT_NULL(chip_last_report(&bench_chip));
}

static void test_sysclk_of_every_divider(void)
{
    watchdog_off();
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(0u));
    TEST_ASSERT_EQUAL_UINT32(7500000u, chip_sysclk_hz(&bench_chip));
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(1u));
    TEST_ASSERT_EQUAL_UINT32(7500000u, chip_sysclk_hz(&bench_chip));
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(3u)); /* /1 is allowed while the PLL is bypassed */
    TEST_ASSERT_EQUAL_UINT32(30000000u, chip_sysclk_hz(&bench_chip));
    TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_PLL_MISUSE));
}

static void test_lock_takes_131072_crystal_cycles(void)
{
    watchdog_off();
    bus_write16(&SYSCTRL->PLLSTS, 0u);
    uint64_t from = chip_now(&bench_chip);
    bus_write16(&SYSCTRL->PLLCR, 10u);
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS);
    chip_run(from + LOCK);
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS);
    TEST_ASSERT_EQUAL_UINT32(7500000u, chip_sysclk_hz(&bench_chip));
    chip_run(from + LOCK + 1u);
    TEST_ASSERT_EQUAL_HEX16(PLLSTS_PLLLOCKS, SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS);
    TEST_ASSERT_EQUAL_UINT32(75000000u, chip_sysclk_hz(&bench_chip));
    bus_write16(&FLASH_REGS->FBANKWAIT, 0x0505u);
    bus_write16(&FLASH_REGS->FOTPWAIT, 8u);
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(2u));
    TEST_ASSERT_EQUAL_UINT32(150000000u, chip_sysclk_hz(&bench_chip));
    TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_FLASH_TOO_FAST));
}

/* Ticks per crystal cycle: 7.5 at 20 MHz, 6 at 25 MHz, 6.25 at 24 MHz, 7 1/7 at 21 MHz. The lock of the
 * PLL and the watchdog count crystal cycles. */
static void test_everything_follows_the_crystal(void)
{
    static const struct {
        uint32_t hz;
        /* [ticks] lock: 131072 cycles; bite: 256 x 512 cycles; both rounded up to a whole tick. */
        uint64_t lock, bite;
    } crystal[] = {{20000000u, 983040u, 983040u},
                   {25000000u, 786432u, 786432u},
                   {24000000u, 819200u, 819200u},
                   {21000000u, 936229u, 936229u},
                   {35000000u, 561738u, 561738u}};
    for (uint32_t i = 0u; i < sizeof crystal / sizeof crystal[0]; i++) {
        bench_power_on_with(crystal[i].hz);
        TEST_ASSERT_EQUAL_UINT32(crystal[i].hz / 2u, chip_sysclk_hz(&bench_chip));
        chip_run(crystal[i].bite);
        TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_WATCHDOG_RESET));
        chip_run(crystal[i].bite + 1u);
        TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_WATCHDOG_RESET));
        bench_power_on_with(crystal[i].hz);
        watchdog_off();
        bus_write16(&SYSCTRL->PLLSTS, 0u);
        TEST_ASSERT_EQUAL_UINT32(crystal[i].hz / 4u, chip_sysclk_hz(&bench_chip));
        bus_write16(&SYSCTRL->PLLCR, 8u);
        chip_run(crystal[i].lock);
        TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS);
        chip_run(crystal[i].lock + 1u);
        TEST_ASSERT_EQUAL_HEX16(PLLSTS_PLLLOCKS, SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS);
        TEST_ASSERT_EQUAL_UINT32(crystal[i].hz * 2u, chip_sysclk_hz(&bench_chip));
    }
}

static void test_a_hundred_megahertz_does_not_drift(void)
{
    bench_power_on_with(20000000u);
    bench_clock();
    TEST_ASSERT_EQUAL_UINT32(100000000u, chip_sysclk_hz(&bench_chip));
    bus_write32(&CPU_TIMER(0u)->PRD, UINT32_MAX);
    bus_write16(&CPU_TIMER(0u)->TCR, TCR_TRB);
    uint64_t from = chip_now(&bench_chip); /* a cycle begins at this tick or between it and the next */
    chip_run(from + UINT64_C(3000000000));
    chip_look(&bench_chip);
    TEST_ASSERT_UINT32_WITHIN(1u, UINT32_MAX - 2000000000u, CPU_TIMER(0u)->TIM);
    from = chip_now(&bench_chip);
    for (uint32_t i = 0u; i < 1000u; i++) {
        bus_wait(2u);
    }
    TEST_ASSERT_EQUAL_UINT64(from + 3000u, chip_now(&bench_chip));
}

static void test_watchdog_count_follows_the_crystal(void)
{
    bench_power_on_with(20000000u);
    chip_run(3839u); /* a count of the watchdog is 512 x 7.5 ticks */
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(0u, SYSCTRL->WDCNTR);
    chip_run(100u * 3840u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(100u, SYSCTRL->WDCNTR);
}

/* A timer whose clock is off in PCLKCR3 does not count and ignores writes; the others continue. */
static void test_timer_without_clock_does_not_count(void)
{
    watchdog_off();
    chip_run(1000u);
    bus_write16(&SYSCTRL->PCLKCR3, PCLKCR3_GPIOIN | 0x0500u); /* switches timer 1 off */
    uint32_t stood = CPU_TIMER(1u)->TIM;
    TEST_ASSERT_EQUAL_UINT32(0xFFFFu - 100u, stood);
    chip_run(11000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(stood, CPU_TIMER(1u)->TIM);
    TEST_ASSERT_EQUAL_UINT32(0xFFFFu - 1100u, CPU_TIMER(0u)->TIM);
    TEST_ASSERT_EQUAL_UINT32(0xFFFFu - 1100u, CPU_TIMER(2u)->TIM);
    bus_write16(&CPU_TIMER(1u)->TCR, TCR_TSS);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_CLOCK_OFF));
    bus_write16(&SYSCTRL->PCLKCR3, PCLKCR3_GPIOIN | 0x0700u);
    chip_run(12000u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT32(stood - 100u, CPU_TIMER(1u)->TIM);
}

static void test_other_multipliers_count_right(void)
{
    /* 30 MHz x 7 / 4 = 52.5 MHz, so that a cycle has 20/7 ticks and 700 cycles have 2000. */
    watchdog_off();
    bus_write16(&SYSCTRL->PLLSTS, 0u);
    bus_write16(&SYSCTRL->PLLCR, 7u);
    chip_run(chip_now(&bench_chip) + LOCK + 1u);
    TEST_ASSERT_EQUAL_UINT32(52500000u, chip_sysclk_hz(&bench_chip));
    uint64_t locked = chip_now(&bench_chip) - 1u; /* a cycle begins at this tick */
    bus_wait(700u);
    TEST_ASSERT_EQUAL_UINT64(locked + 2000u, chip_now(&bench_chip));
    bus_wait(1u); /* 2 6/7 ticks, rounded up to the first tick of the next cycle */
    TEST_ASSERT_EQUAL_UINT64(locked + 2003u, chip_now(&bench_chip));
}

static void test_pll_misuse_is_ignored_and_reported(void)
{
    watchdog_off();
    bus_write16(&SYSCTRL->PLLCR, 10u); /* the write has no effect because DIVSEL is 2 */
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_PLL_MISUSE));
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->PLLCR);
    bus_write16(&SYSCTRL->PLLSTS, 0u);
    bus_write16(&SYSCTRL->PLLCR, 11u); /* a reserved value */
    TEST_ASSERT_EQUAL_UINT32(2u, bench_reports(CHIP_PLL_MISUSE));
    bus_write16(&SYSCTRL->PLLCR, 10u);
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(2u)); /* the PLL has not locked yet */
    TEST_ASSERT_EQUAL_UINT32(3u, bench_reports(CHIP_PLL_MISUSE));
    TEST_ASSERT_EQUAL_UINT32(7500000u, chip_sysclk_hz(&bench_chip));
    chip_run(chip_now(&bench_chip) + LOCK + 1u);
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(3u)); /* /1 with the PLL on would be 300 MHz */
    TEST_ASSERT_EQUAL_UINT32(4u, bench_reports(CHIP_PLL_MISUSE));
    TEST_ASSERT_EQUAL_UINT32(75000000u, chip_sysclk_hz(&bench_chip));
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_PLLOFF);
    TEST_ASSERT_EQUAL_UINT32(5u, bench_reports(CHIP_PLL_MISUSE));
}

static void test_flash_wait_states(void)
{
    /* An access time of 37 ns needs 5 wait states at 150 MHz and 2 at 75 MHz; 60 ns (OTP) need 8. */
    static const struct {
        uint16_t bank, otp;
        uint32_t reports;
    } row[] = {
        {0x0505u, 8u, 0u}, {0x0405u, 8u, 1u}, {0x0504u, 8u, 1u}, {0x0505u, 7u, 1u}, {0x0F0Fu, 31u, 0u}};
    for (uint32_t i = 0u; i < 5u; i++) {
        bench_power_on();
        watchdog_off();
        bus_write16(&SYSCTRL->PLLSTS, 0u);
        bus_write16(&SYSCTRL->PLLCR, 10u);
        bus_write16(&FLASH_REGS->FBANKWAIT, row[i].bank);
        bus_write16(&FLASH_REGS->FOTPWAIT, row[i].otp);
        chip_run(chip_now(&bench_chip) + LOCK + 1u);
        TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_FLASH_TOO_FAST));
        bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(2u));
        TEST_ASSERT_EQUAL_UINT32(row[i].reports, bench_reports(CHIP_FLASH_TOO_FAST));
    }
    bus_write16(&FLASH_REGS->FBANKWAIT, 0x0404u); /* lowers the number of wait states */
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_FLASH_TOO_FAST));
}

static void test_clock_change_keeps_counters_going(void)
{
    /* A carrier of 2 x 1000 counts, that is 2000 cycles; from the middle of the period on the clock has
     * half its frequency. */
    bench_clock();
    bus_write16(&EPWM(1u)->TBCTL, TBCTL_UPDOWN);
    bus_write16(&EPWM(1u)->TBPRD, 1000u);
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, PCLKCR0_TBCLKSYNC);
    uint64_t from = chip_now(&bench_chip);
    chip_run(from + 500u);
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(0u)); /* 75 MHz */
    chip_run(from + 500u + 600u);
    chip_look(&bench_chip);
    TEST_ASSERT_EQUAL_UINT16(800u, EPWM(1u)->TBCTR);
}

static void test_module_clock_off_ignores_and_reports(void)
{
    watchdog_off();
    bus_write16(&EPWM(1u)->TBPRD, 7500u);
    bus_write16(&ADC->ADCMAXCONV, 3u);
    bus_write32(&EQEP(1u)->QPOSMAX, 9999u);
    bus_write16(&EQEP(1u)->QEPCTL, 8u);
    TEST_ASSERT_EQUAL_UINT32(4u, bench_reports(CHIP_CLOCK_OFF));
    TEST_ASSERT_EQUAL_UINT16(0u, EPWM(1u)->TBPRD);
    TEST_ASSERT_EQUAL_UINT16(0u, ADC->ADCMAXCONV);
    bus_write16(&SYSCTRL->PCLKCR3, PCLKCR3_GPIOIN);
    bus_write32(&CPU_TIMER(0u)->PRD, 5u);
    TEST_ASSERT_EQUAL_UINT32(5u, bench_reports(CHIP_CLOCK_OFF));
}

static void test_protected_registers_need_EALLOW(void)
{
    watchdog_off();
    bus_write16(&SYSCTRL->PCLKCR1, 0x003Fu);
    bus_protect();
    const volatile uint16_t *narrow[] = {
        &SYSCTRL->PLLSTS,  &SYSCTRL->PLLCR,        &SYSCTRL->HISPCP,  &SYSCTRL->LOSPCP, &SYSCTRL->PCLKCR0,
        &SYSCTRL->PCLKCR1, &SYSCTRL->PCLKCR3,      &SYSCTRL->WDCR,    &SYSCTRL->WDKEY,  &SYSCTRL->SCSR,
        &SYSCTRL->MAPCNF,  &FLASH_REGS->FBANKWAIT, &FLASH_REGS->FOPT, &EPWM(1u)->TZSEL, &EPWM(1u)->TZCTL,
        &EPWM(1u)->TZEINT, &EPWM(1u)->TZCLR,       &EPWM(1u)->TZFRC,  &EPWM(1u)->HRCNFG};
    const volatile uint32_t *wide[] = {&PIE_VECTORS->vector[32], &GPIO_CONTROL(0u)->MUX1,
                                       &GPIO_CONTROL(0u)->DIR,   &GPIO_CONTROL(0u)->PUD,
                                       &GPIO_CONTROL(0u)->QSEL1, &GPIO_CONTROL(0u)->CTRL};
    static f28335_t before;
    memcpy(&before, &bench_chip.registers, sizeof before);
    for (uint32_t i = 0u; i < sizeof narrow / sizeof narrow[0]; i++) {
        bus_write16(narrow[i], 0x0004u);
        TEST_ASSERT_EQUAL_UINT32(i + 1u, bench_reports(CHIP_PROTECTED_WRITE));
    }
    for (uint32_t i = 0u; i < sizeof wide / sizeof wide[0]; i++) {
        bus_write32(wide[i], 0x0004u);
        TEST_ASSERT_EQUAL_UINT32(19u + i + 1u, bench_reports(CHIP_PROTECTED_WRITE));
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &bench_chip.registers, sizeof before);
}

static void test_unprotected_registers_do_not(void)
{
    bench_clock();
    bus_write16(&EPWM(1u)->TBPRD, 7500u);
    bus_write16(&ADC->ADCMAXCONV, 1u);
    bus_write32(&EQEP(1u)->QPOSMAX, 1u);
    bus_write32(&CPU_TIMER(0u)->PRD, 1u);
    bus_write16(&PIE->PIECTRL, 1u);
    bus_write32(&GPIO_DATA(0u)->SET, 1u);
    TEST_ASSERT_NULL(chip_last_report(&bench_chip));
}

static void test_widths_and_unknown_registers(void)
{
    watchdog_off();
    bus_write32((const volatile uint32_t *)(const volatile void *)&SYSCTRL->PCLKCR0, 0u);
    bus_write16((const volatile uint16_t *)&GPIO_CONTROL(0u)->MUX1, 0u);
    bus_write16((const volatile uint16_t *)&PIE_VECTORS->vector[32], 0u);
    bus_write16((const volatile uint16_t *)&CPU_TIMER(0u)->PRD, 0u);
    TEST_ASSERT_EQUAL_UINT32(4u, bench_reports(CHIP_BAD_WIDTH));
    bus_write16(F28335_BASE + 0x7750u, 0u); /* a register of SCI-B */
    /* a register of eCAN. */
    bus_write32((const volatile uint32_t *)(const volatile void *)(F28335_BASE + 0x6000u), 0u);
    bus_write16(&SYSCTRL->LPMCR0, 1u);
    bus_write16(&SYSCTRL->LPMCR0, 0u);
    TEST_ASSERT_EQUAL_UINT32(3u, bench_reports(CHIP_UNKNOWN_REGISTER));
}

static void test_watchdog_bites_after_its_period(void)
{
    chip_run(WATCHDOG);
    TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_WATCHDOG_RESET));
    chip_run(WATCHDOG + 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_WATCHDOG_RESET));
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    TEST_ASSERT_EQUAL_HEX16(WDCR_WDFLAG, SYSCTRL->WDCR & WDCR_WDFLAG);
}

static void test_watchdog_prescale(void)
{
    static const uint32_t factor[8] = {1u, 1u, 2u, 4u, 8u, 16u, 32u, 64u};
    for (uint16_t n = 0u; n < 8u; n++) {
        bench_power_on();
        bus_allow();
        bus_write16(&SYSCTRL->WDCR, (uint16_t)(WDCR_WDCHK | WDCR_WDPS(n)));
        chip_run((uint64_t)WATCHDOG * factor[n]);
        TEST_ASSERT_EQUAL_UINT32(0u, bench_reports(CHIP_WATCHDOG_RESET));
        chip_run((uint64_t)WATCHDOG * factor[n] + 1u);
        TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_WATCHDOG_RESET));
    }
}

static void test_watchdog_is_fed_by_both_keys_in_order(void)
{
    bus_allow();
    chip_run(600000u);
    bus_write16(&SYSCTRL->WDKEY, WDKEY_FIRST);
    bus_write16(&SYSCTRL->WDKEY, WDKEY_SECOND);
    TEST_ASSERT_EQUAL_UINT16(0u, SYSCTRL->WDCNTR);
    chip_run(600000u + WATCHDOG);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
    chip_run(600000u + WATCHDOG + 1u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    /* The test writes the second key alone, and in the next pass the first key alone. Neither services the
     * watchdog. */
    for (uint32_t i = 0u; i < 2u; i++) {
        bench_power_on();
        bus_allow();
        chip_run(600000u);
        bus_write16(&SYSCTRL->WDKEY, i == 0u ? WDKEY_SECOND : WDKEY_FIRST);
        chip_run(WATCHDOG + 1u);
        TEST_ASSERT_TRUE(chip_halted(&bench_chip));
    }
}

static void test_wrong_key_and_wrong_check_reset_at_once(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->WDKEY, 0x56u);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_WATCHDOG_RESET));
    TEST_ASSERT_EQUAL_STRING("SYSCTRL.WDKEY", chip_register_name(chip_last_report(&bench_chip)->address));
    bench_power_on();
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, WDCR_WDDIS);
    TEST_ASSERT_EQUAL_UINT32(1u, bench_reports(CHIP_WATCHDOG_RESET));
}

static void test_override_locks_the_watchdog_on(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->SCSR, SCSR_WDOVERRIDE);
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->SCSR & SCSR_WDOVERRIDE);
    bus_write16(&SYSCTRL->WDCR, WDCR_WDDIS | WDCR_WDCHK);
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->WDCR & WDCR_WDDIS);
    chip_run(WATCHDOG + 1u);
    TEST_ASSERT_TRUE(chip_halted(&bench_chip));
}

static uint32_t wakes;

static void on_wake(void)
{
    wakes++;
    bus_write16(&PIE->PIEACK, 1u);
}

static void test_watchdog_interrupt_instead_of_reset(void)
{
    wakes = 0u;
    bus_allow();
    bus_write16(&SYSCTRL->SCSR, SCSR_WDENINT);
    bus_write32(&PIE_VECTORS->vector[PIE_VECTOR(1u, 8u)], bus_vector(on_wake));
    bus_write16(&PIE->PIECTRL, 1u);
    bus_write16(&PIE->group[0].IER, 0x80u);
    bus_enable_group(1u);
    bus_interrupts_enable();
    chip_run(3u * WATCHDOG);
    TEST_ASSERT_EQUAL_UINT32(2u, wakes);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
}

static void test_watchdog_reset_floats_the_gates_and_boot_starts_again(void)
{
    bench_start(0u);
    chip_run(chip_now(&bench_chip) + 3u * CARRIER);
    uint64_t before = chip_now(&bench_chip);
    bench_forget();
    bus_allow();
    bus_write16(&SYSCTRL->WDKEY, 1u);
    TEST_ASSERT_EQUAL_UINT32(1u, bench.edges);
    TEST_ASSERT_EQUAL_HEX32(0u, bench.edge[0].driven);
    TEST_ASSERT_EQUAL_UINT64(before, bench.edge[0].tick);
    TEST_ASSERT_EQUAL_UINT32(15000000u, chip_sysclk_hz(&bench_chip));
    uint32_t samples = bench_samples;
    chip_run(before + 5u * CARRIER);
    TEST_ASSERT_EQUAL_UINT32(samples, bench_samples);
    chip_boot(&bench_chip);
    TEST_ASSERT_FALSE(chip_halted(&bench_chip));
    bench_start(0u);
    chip_run(chip_now(&bench_chip) + 3u * CARRIER + 1000u);
    TEST_ASSERT_EQUAL_UINT32(samples + 3u, bench_samples);
    TEST_ASSERT_EQUAL_HEX16(WDCR_WDFLAG, SYSCTRL->WDCR & WDCR_WDFLAG);
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, WDCR_WDFLAG | WDCR_WDDIS | WDCR_WDCHK);
    TEST_ASSERT_EQUAL_HEX16(0u, SYSCTRL->WDCR & WDCR_WDFLAG);
}

static void test_report_ring_keeps_the_last_and_counts_all(void)
{
    for (uint32_t i = 0u; i < 100u; i++) {
        bus_write16(F28335_BASE + 0x5000u + i, 0u);
    }
    TEST_ASSERT_EQUAL_UINT32(100u, bench_reports(CHIP_UNKNOWN_REGISTER));
    TEST_ASSERT_EQUAL_HEX32(0x5063u, chip_last_report(&bench_chip)->address);
}

static void test_names_and_texts(void)
{
    TEST_ASSERT_EQUAL_STRING("EPWM1.TZCLR", chip_register_name(0x6817u));
    TEST_ASSERT_EQUAL_STRING("EPWM6.HRCNFG", chip_register_name(0x6960u));
    TEST_ASSERT_EQUAL_STRING("ADC.ADCCHSELSEQ[2]", chip_register_name(0x7105u));
    TEST_ASSERT_EQUAL_STRING("ADC.ADCRESULT[15]", chip_register_name(0x7117u));
    TEST_ASSERT_EQUAL_STRING("MIRROR.ADCRESULT[3]", chip_register_name(0x0B03u));
    TEST_ASSERT_EQUAL_STRING("PIE.PIEACK", chip_register_name(0x0CE1u));
    TEST_ASSERT_EQUAL_STRING("PIE12.IFR", chip_register_name(0x0CF9u));
    TEST_ASSERT_EQUAL_STRING("PIE.vector[32]", chip_register_name(0x0D40u));
    TEST_ASSERT_EQUAL_STRING("GPIOA.MUX1", chip_register_name(0x6F86u));
    TEST_ASSERT_EQUAL_STRING("GPIOC.TOGGLE", chip_register_name(0x6FD6u));
    TEST_ASSERT_EQUAL_STRING("CPUTIMER2.TCR", chip_register_name(0x0C14u));
    TEST_ASSERT_EQUAL_STRING("EQEP1.QUPRD", chip_register_name(0x6B10u));
    TEST_ASSERT_EQUAL_STRING("SYSCTRL.WDCR", chip_register_name(0x7029u));
    TEST_ASSERT_EQUAL_STRING("FLASH.FOTPWAIT", chip_register_name(0x0A87u));
    TEST_ASSERT_EQUAL_STRING("?", chip_register_name(0x7000u));
    TEST_ASSERT_EQUAL_STRING("?", chip_register_name(0x6813u));
    for (uint32_t kind = 0u; kind < CHIP_REPORT_KINDS; kind++) {
        TEST_ASSERT_TRUE(strlen(chip_report_text((chip_report_kind_t)kind)) > 5u);
    }
}
