/* Clocks: crystal -> SYSCLK (30 -> 150 MHz), prescalers, flash wait states, module clocks. SPRUFB0 ch. 1
 * and 5. Every register here is behind EALLOW. */
#ifndef HAL_F28335_CLOCK_H
#define HAL_F28335_CLOCK_H

#include "hal/hal.h"

/* Prescalers and flash wait states for SYSCLK, then the PLL, then the clocks of ADC, legs, encoder, timers
 * and GPIO; the carrier counters still stand (TBCLKSYNC 0). HAL_CLOCK_MISSING or HAL_PLL_UNLOCKED: the chip
 * goes on at a quarter of whatever clock it has, the modules stay without clock. The watchdog must be off.
 * Takes the PLL's lock time, 4.4 ms; at most 140 ms. */
hal_status_t clock_init(void);

/* All carrier counters start in the same cycle. */
void clock_start_carrier(void);

/* Whether they do: the last step of hal_init, so also whether that came to its end. */
bool clock_carrier_runs(void);

#endif
