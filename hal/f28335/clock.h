/* Clocks: crystal -> SYSCLK (30 -> 150 MHz), prescalers, flash wait states, module clocks. SPRUFB0 ch. 1
 * and 5. All these registers need EALLOW. */
#ifndef HAL_F28335_CLOCK_H
#define HAL_F28335_CLOCK_H

#include "hal/hal.h"

/* Sets prescalers and flash wait states for SYSCLK, then the PLL, then the clocks of ADC, legs, encoder,
 * timers and GPIO. The carrier counters do not run yet (TBCLKSYNC 0). After HAL_CLOCK_MISSING or
 * HAL_PLL_UNLOCKED the chip runs at a quarter of its present clock, and the modules have no clock. The
 * watchdog must be off. It takes the lock time of the PLL, 4.4 ms; at most 140 ms. */
hal_status_t clock_init(void);

/* Starts all carrier counters in the same cycle. */
void clock_start_carrier(void);

/* true: the carrier counters run. Their start is the last step of hal_init, so hal_init has ended. */
bool clock_carrier_runs(void);

#endif
