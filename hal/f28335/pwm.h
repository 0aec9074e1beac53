/* Three ePWMs: three legs on one centre-aligned carrier, SPRUG04.
 *
 * TBCLK = SYSCLK, up-down to HAL_PERIOD_COUNT (7500 at 150 MHz and 10 kHz). Output A of a leg is its upper
 * switch, B its complement, and each turn-on is delayed by the dead band. The board selects the zero vector
 * at counter zero, t_k, by the position of its current sensors (board.h, line 10):
 *
 *   upper zero vector   A is on while the counter is below CMPA = count: duty CMPA/period, centred on t_k
 *
 *   lower zero vector   A is on while the counter is above CMPA = period - count: the same duty, centred
 *                       half a period after t_k; at t_k all lower switches are on
 *
 * A new CMPA acts from counter zero on in both cases. The first module leads. Its sync pulse takes two cycles
 * to the other two; they load 2 counting up, so that all counters are equal. The leader also starts the ADC
 * (adc.h).
 *
 * Trip zone: the fault line of the power module (TZ1 = GPIO12 ...), active low, switches off all six outputs
 * without a clock, until software enables them again. TZFRC does the same on command. The trip interrupt is
 * enabled only while the gates are on, because a forced trip is no event. In addition, clearing TZFLG[INT]
 * while OST is set would cause the next interrupt at once. */
#ifndef HAL_F28335_PWM_H
#define HAL_F28335_PWM_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/hal.h"

#define PWM_PERIOD ((uint32_t)BOARD_PERIOD_CYCLES) /* [SYSCLK cycles] one carrier period */

/* The module that leads: its counter is the carrier. The legs are this one and the next two. */
#define PWM_LEADER ((uint16_t)BOARD_LEG_FIRST)

/* GPIO number of the trip input, the power module's fault line, and its function in the multiplexer: TZ1 to
 * TZ4 are function 1 of GPIO12 to 15, TZ5 and TZ6 function 3 of GPIO16 and 17. */
#define PWM_FAULT_PIN     (11u + (uint16_t)BOARD_TRIP_ZONE)
#define PWM_FAULT_PIN_MUX (BOARD_TRIP_ZONE < 5 ? 1u : 3u)

/* Sets up the three modules, with stopped counters and the trip forced. False: a module does not show the
 * trip, and its pins must not be connected. The module clocks must be on, and TBCLKSYNC 0. `dead_band_count`
 * in HAL_DEAD_BAND_MIN..HAL_DEAD_BAND_MAX [SYSCLK cycles]. */
bool pwm_init(uint16_t dead_band_count);

/* Time since the last counter zero: 0..PWM_PERIOD - 1 [SYSCLK cycles]. Near counter zero the error is a few
 * cycles. */
uint32_t pwm_elapsed(void);

/* True if the trip zone holds the gates of any leg off; the same of all legs. */
bool pwm_any_tripped(void);
bool pwm_all_tripped(void);

/* True if the power module reports a fault on its fault line now. */
bool pwm_fault_line(void);

#endif
