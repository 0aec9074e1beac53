/* Watchdog, SPRUFB0 ch. 5: an 8-bit counter on OSCCLK/512; its overflow resets the chip. */
#ifndef HAL_F28335_WATCHDOG_H
#define HAL_F28335_WATCHDOG_H

#include <stdbool.h>

/* Switches the watchdog off, by four writes. After the boot ROM it runs with 4.37 ms, about the time in which
 * the PLL locks. */
void watchdog_stop(void);

/* True if the watchdog counts. */
bool watchdog_runs(void);

#endif
