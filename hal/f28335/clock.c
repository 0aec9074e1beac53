#include "hal/f28335/clock.h"

#include "hal/f28335/bus.h"

/* 30 MHz x 10 / 2 */
#define PLL_TIMES_10 10u

/* HSPCLK = 150 MHz / 6 = 25 MHz, the ADC's limit; LSPCLK = 150 MHz / 4 */
#define HSPCLK_BY_6 3u
#define LSPCLK_BY_4 2u

/* Flash at 150 MHz: five waits, paged and random; OTP eight (data manual). */
#define FLASH_WAITS 0x0505u
#define OTP_WAITS   8u
#define FLASH_ON    3u /* FPWR: active */

/* The lock takes 131072 OSCCLK, a quarter of that in SYSCLK cycles, because the chip runs at OSCCLK/4
 * meanwhile. */
#define LOCK_POLL_CYCLES UINT32_C(256)
#define LOCK_POLLS       4096u

#define MODULE_CLOCKS_0 PCLKCR0_ADC
#define MODULE_CLOCKS_1 (PCLKCR1_EPWM1 | PCLKCR1_EPWM2 | PCLKCR1_EPWM3 | PCLKCR1_EQEP1)

/* Runs from RAM on silicon (hal/CMakeLists.txt): the flash must not be read meanwhile. */
static void set_flash_waits(void)
{
    bus_allow();
    bus_write16(&FLASH_REGS->FPWR, FLASH_ON);
    bus_write16(&FLASH_REGS->FBANKWAIT, FLASH_WAITS);
    bus_write16(&FLASH_REGS->FOTPWAIT, OTP_WAITS);
    bus_write16(&FLASH_REGS->FOPT, FOPT_ENPIPE);
    bus_protect();
    /* The pipeline must be empty of fetches that began with the old setting. */
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
     * would take the lock for a fault. */
    write_pllsts(PLLSTS_DIVSEL(0u));
    write_pllsts(PLLSTS_DIVSEL(0u) | PLLSTS_MCLKOFF);
    bus_allow();
    bus_write16(&SYSCTRL->PLLCR, PLL_TIMES_10);
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
    bus_write16(&SYSCTRL->HISPCP, HSPCLK_BY_6);
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
    bus_protect();
    /* A module takes writes two cycles after its clock came. */
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
