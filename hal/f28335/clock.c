#include "hal/f28335/clock.h"

#include "hal/f28335/bus.h"

/* Crystal x PLLCR / 2 = SYSCLK: 30 MHz x 10 / 2 = 150 MHz */
#define PLL_TIMES ((uint16_t)BOARD_PLL_TIMES)

/* HSPCLK = SYSCLK / (2 n), 25 MHz at most, the ADC's limit; LSPCLK = SYSCLK / 4 */
#define HSPCLK_BY_2N ((uint16_t)BOARD_ADC_PRESCALE)
#define LSPCLK_BY_4  2u

/* A read of the flash takes 37 ns, paged or random, and a read of the OTP 60 ns. The chip allows (wait states
 * + 1) SYSCLK cycles for it (data manual): five and eight wait states at 150 MHz. */
#define WAITS(ns)   ((uint16_t)(BOARD_CYCLES_OF_NS(ns) - 1))
#define FLASH_WAITS ((uint16_t)(WAITS(37) << 8 | WAITS(37)))
#define OTP_WAITS   WAITS(60)
#define FLASH_ON    3u /* FPWR: active */

/* The lock takes 131072 OSCCLK, a quarter of that in SYSCLK cycles, because the chip runs at OSCCLK/4
 * meanwhile. */
#define LOCK_POLL_CYCLES UINT32_C(256)
#define LOCK_POLLS       4096u

#if BOARD_SERIAL_BAUD != 0
#define SERIAL_CLOCK PCLKCR0_SCIA
#else
#define SERIAL_CLOCK 0u
#endif
#if BOARD_STORE == BOARD_STORE_I2C
#define STORE_CLOCK PCLKCR0_I2CA
#else
#define STORE_CLOCK 0u
#endif
#define MODULE_CLOCKS_0 ((uint16_t)(PCLKCR0_ADC | SERIAL_CLOCK | STORE_CLOCK))
#define LEG_CLOCKS      (PCLKCR1_EPWM1 | PCLKCR1_EPWM2 | PCLKCR1_EPWM3)
#define MODULE_CLOCKS_1 ((uint16_t)(LEG_CLOCKS << (BOARD_LEG_FIRST - 1) | QEP_CLOCK))
#define MODULE_CLOCKS_3 (PCLKCR3_GPIOIN | PCLKCR3_TIMERS)
#if BOARD_ENCODER == BOARD_EQEP2_GPIO24
#define QEP_CLOCK PCLKCR1_EQEP2
#else
#define QEP_CLOCK PCLKCR1_EQEP1
#endif

/* Runs from RAM on silicon (hal/CMakeLists.txt): the flash must not be read meanwhile. */
static void set_flash_waits(void)
{
    bus_allow();
    bus_write16(&FLASH_REGS->FPWR, FLASH_ON);
    bus_write16(&FLASH_REGS->FBANKWAIT, FLASH_WAITS);
    bus_write16(&FLASH_REGS->FOTPWAIT, OTP_WAITS);
    bus_write16(&FLASH_REGS->FOPT, FOPT_ENPIPE);
    bus_protect();
    /* Fetches that began with the old setting must have left the pipeline. */
    bus_wait(8u);
}

static void write_pllsts(uint16_t value)
{
    bus_allow();
    bus_write16(&SYSCTRL->PLLSTS, value);
    bus_protect();
}

static bool clock_is_missing(void)
{
    return (SYSCTRL->PLLSTS & PLLSTS_MCLKSTS) != 0u;
}

static hal_status_t start_pll(void)
{
    uint16_t poll;

    if (clock_is_missing()) {
        return HAL_CLOCK_MISSING;
    }
    /* PLLCR may change only while DIVSEL is 0 (/4); the boot ROM leaves /2. The detector of a missing clock
     * is off, because it would report the locking of the PLL as a fault. */
    write_pllsts(PLLSTS_DIVSEL(0u));
    write_pllsts(PLLSTS_DIVSEL(0u) | PLLSTS_MCLKOFF);
    bus_allow();
    bus_write16(&SYSCTRL->PLLCR, PLL_TIMES);
    bus_protect();
    for (poll = 0u; (SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS) == 0u && poll < LOCK_POLLS; poll++) {
        bus_wait(LOCK_POLL_CYCLES);
    }
    write_pllsts(PLLSTS_DIVSEL(0u));
    if ((SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS) == 0u) {
        return HAL_PLL_UNLOCKED;
    }
    if (clock_is_missing()) {
        return HAL_CLOCK_MISSING;
    }
    write_pllsts(PLLSTS_DIVSEL(2u));
    return HAL_OK;
}

hal_status_t clock_init(void)
{
    hal_status_t status;

    bus_allow();
    bus_write16(&SYSCTRL->HISPCP, HSPCLK_BY_2N);
    bus_write16(&SYSCTRL->LOSPCP, LSPCLK_BY_4);
    bus_protect();
    set_flash_waits();

    status = start_pll();
    if (status != HAL_OK) {
        return status;
    }

    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, MODULE_CLOCKS_0);
    bus_write16(&SYSCTRL->PCLKCR1, MODULE_CLOCKS_1);
    bus_write16(&SYSCTRL->PCLKCR3, MODULE_CLOCKS_3);
    bus_protect();
    /* A module accepts writes from two cycles after its clock was switched on. */
    bus_wait(2u);
    return HAL_OK;
}

void clock_start_carrier(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->PCLKCR0, MODULE_CLOCKS_0 | PCLKCR0_TBCLKSYNC);
    bus_protect();
}

bool clock_carrier_runs(void)
{
    return (SYSCTRL->PCLKCR0 & PCLKCR0_TBCLKSYNC) != 0u;
}
