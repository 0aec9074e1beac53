/* ePWM1-3: three legs on one centre-aligned carrier of 10 kHz, SPRUG04.
 *
 * TBCLK 150 MHz, up-down to 7500. Output A of a leg (upper switch) is on while the counter is below CMPA, so
 * its duty is CMPA/7500, centred on counter zero = t_k; output B is its complement, and each turn-on comes
 * later by the dead band. CMPA is taken over at counter zero. ePWM1 leads, 2 and 3 follow by its sync pulse,
 * which takes two cycles: they load 2 counting up and so stand equal. ePWM1 also starts the ADC (adc.h).
 *
 * Trip zone: TZ1 (GPIO12, the power module's fault line, active low, without any clock in its way) shuts all
 * six outputs until software lets them on again. TZFRC does the same on command. The trip interrupt is armed
 * only while the gates are on: a forced trip is no event, and clearing TZFLG[INT] while OST stands would
 * bring the next interrupt at once. */
#ifndef HAL_F28335_PWM_H
#define HAL_F28335_PWM_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/hal.h"

/* The board's gate interface: 1 = a switch is on while its pin is high (inverting opto stage in front of the
 * active-low module inputs), 0 = on while low. Only the schematic can tell; the wrong one turns on both
 * switches of every leg. */
#ifndef HAL_GATE_ACTIVE_HIGH
#define HAL_GATE_ACTIVE_HIGH 1
#endif

#define PWM_PERIOD (UINT32_C(2) * HAL_PERIOD_COUNT) /* [1/150 MHz] one carrier period */

/* GPIO number of TZ1, the power module's fault line. */
#define PWM_FAULT_PIN 12u

/* Everything of the three modules, counters standing, and the trip forced. False: a module did not take the
 * trip; the pins must not be connected then. Needs module clocks and TBCLKSYNC 0. `dead_band_count` in
 * HAL_DEAD_BAND_MIN..HAL_DEAD_BAND_MAX [1/150 MHz]. */
bool pwm_init(uint16_t dead_band_count);

/* Time since the last counter zero: 0..PWM_PERIOD - 1 [1/150 MHz], right after it and right before it to a
 * few cycles. */
uint32_t pwm_elapsed(void);

/* Any leg shut by the trip zone. All legs shut by it. */
bool pwm_any_tripped(void);
bool pwm_all_tripped(void);

/* The power module pulls its fault line now. */
bool pwm_fault_line(void);

#endif
