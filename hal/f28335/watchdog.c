#include "hal/f28335/watchdog.h"

#include "hal/f28335/bus.h"
#include "hal/hal.h"

/* Crystal / 512 / 64, 256 counts: 279.6 ms at 30 MHz, 419 ms at 20 MHz */
#define WATCHDOG_SLOWEST 7u

/* With WDCHK other than 101 the chip resets at once. */
#define WDCR_WRONG 0u

void watchdog_stop(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, WDCR_WDDIS | WDCR_WDCHK);
    bus_protect();
}

bool watchdog_runs(void)
{
    return (SYSCTRL->WDCR & WDCR_WDDIS) == 0u;
}

void hal_watchdog_feed(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->WDKEY, WDKEY_FIRST);
    bus_write16(&SYSCTRL->WDKEY, WDKEY_SECOND);
    bus_protect();
}

void hal_watchdog_start(void)
{
    /* The counter may have any value: it is set to zero before it runs. */
    hal_watchdog_feed();
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, (uint16_t)(WDCR_WDCHK | WDCR_WDPS(WATCHDOG_SLOWEST)));
    bus_protect();
}

void hal_restart(void)
{
    hal_gates_off();
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, WDCR_WRONG); /* a reset at once */
    bus_protect();
}
