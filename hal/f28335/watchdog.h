/* Watchdog, SPRUFB0 ch. 5: an 8-bit counter on OSCCLK/512; its overflow resets the chip. */
#ifndef HAL_F28335_WATCHDOG_H
#define HAL_F28335_WATCHDOG_H

#include <stdbool.h>

/* Off. The boot ROM leaves it running at 4.37 ms, about the time the PLL needs to lock. Four writes' worth of
 * time. */
void watchdog_stop(void);

/* It counts. */
bool watchdog_runs(void);

#endif
