/* ADC: simultaneous pairs ADCINAn and ADCINBn, once a carrier period, SPRU812 and data manual SPRS439
 * (simultaneous sampling timing).
 *
 *   pair 0     as the last pair; dropped, because the first conversion after a pause may be wrong (SPRZ272)
 *
 *   pair 1     phase currents a and b, sampled exactly at t_k
 *
 *   pair 2..   current c, DC link, heat sink, motor, if the board has them; each input is converted once
 *
 * ADCCLK is SYSCLK/(2n), 25 MHz at most: 6 cycles of 150 MHz. Sampling begins 2.5 ADCCLK after the start, the
 * window is ACQ_PS + 1 ADCCLK, a pair follows the one before by 3 + ACQ_PS ADCCLK. Pair 1 is therefore
 * sampled 2.5 + 5 + 7 = 14.5 ADCCLK after the start, 87 cycles of 150 MHz. CMPB of the leading ePWM, counting
 * down, starts the conversion by this time before counter zero. A carrier period is a whole number of ADCCLK
 * (board.h), so that ADCCLK keeps its phase to the carrier. The interrupt occurs at the end of the last pair,
 * with four pairs about 0.8 us after t_k. Current c, if it has a sensor, is sampled one pair after t_k, 0.28
 * us.
 *
 * Calibration: TI has stored two constants of each chip in its OTP. The boot ROM copies them, but not if
 * a debugger starts the program. Therefore this module copies them. ADCTRL1[RESET], which would undo this, is
 * never used. */
#ifndef HAL_F28335_ADC_H
#define HAL_F28335_ADC_H

#include "hal/board.h"

#define ADC_ACQ_PS            4u /* window of 5 ADCCLK = 200 ns; simultaneous mode needs 160 ns or more */
#define ADC_CYCLES_HALF_CLOCK ((uint16_t)BOARD_ADC_PRESCALE) /* [SYSCLK cycles] half an ADCCLK */

/* Start to hold of pair 1, in half ADCCLK: 5 to the window, the window, one pair. */
#define ADC_HALF_CLOCKS (5u + 2u * (ADC_ACQ_PS + 1u) + 2u * (3u + ADC_ACQ_PS))
#define ADC_LEAD        ((uint16_t)(ADC_CYCLES_HALF_CLOCK * ADC_HALF_CLOCKS)) /* [SYSCLK cycles] */

/* The place of each signal's pair in the order of the conversions, and the place of the last pair. Two
 * signals of the same pair share one place; a signal that the board does not have (pair 8) takes no place. */
#define ADC_PAIR(input) ((input) == BOARD_NONE ? 8 : (input) % 8)
#define ADC_A           ADC_PAIR(BOARD_CURRENT_A_INPUT)
#define ADC_C           ADC_PAIR(BOARD_CURRENT_C_INPUT)
#define ADC_DC          ADC_PAIR(BOARD_DC_INPUT)
#define ADC_SINK        ADC_PAIR(BOARD_SINK_INPUT)
#define ADC_MOTOR       ADC_PAIR(BOARD_MOTOR_INPUT)

#define ADC_PLACE_A 1

#if ADC_C == 8 || ADC_C == ADC_A
#define ADC_PLACE_C 1
#define ADC_LAST_1  1
#define ADC_PAIR_1  ADC_A
#else
#define ADC_PLACE_C 2
#define ADC_LAST_1  2
#define ADC_PAIR_1  ADC_C
#endif

#if ADC_DC == ADC_A
#define ADC_PLACE_DC ADC_PLACE_A
#elif ADC_DC == ADC_C
#define ADC_PLACE_DC ADC_PLACE_C
#else
#define ADC_PLACE_DC (ADC_LAST_1 + 1)
#endif
#if ADC_PLACE_DC > ADC_LAST_1
#define ADC_LAST_2 ADC_PLACE_DC
#define ADC_PAIR_2 ADC_DC
#else
#define ADC_LAST_2 ADC_LAST_1
#define ADC_PAIR_2 ADC_PAIR_1
#endif

#if ADC_SINK == 8
#define ADC_PLACE_SINK 0
#elif ADC_SINK == ADC_A
#define ADC_PLACE_SINK ADC_PLACE_A
#elif ADC_SINK == ADC_C
#define ADC_PLACE_SINK ADC_PLACE_C
#elif ADC_SINK == ADC_DC
#define ADC_PLACE_SINK ADC_PLACE_DC
#else
#define ADC_PLACE_SINK (ADC_LAST_2 + 1)
#endif
#if ADC_PLACE_SINK > ADC_LAST_2
#define ADC_LAST_3 ADC_PLACE_SINK
#define ADC_PAIR_3 ADC_SINK
#else
#define ADC_LAST_3 ADC_LAST_2
#define ADC_PAIR_3 ADC_PAIR_2
#endif

#if ADC_MOTOR == 8
#define ADC_PLACE_MOTOR 0
#elif ADC_MOTOR == ADC_A
#define ADC_PLACE_MOTOR ADC_PLACE_A
#elif ADC_MOTOR == ADC_C
#define ADC_PLACE_MOTOR ADC_PLACE_C
#elif ADC_MOTOR == ADC_DC
#define ADC_PLACE_MOTOR ADC_PLACE_DC
#elif ADC_MOTOR == ADC_SINK
#define ADC_PLACE_MOTOR ADC_PLACE_SINK
#else
#define ADC_PLACE_MOTOR (ADC_LAST_3 + 1)
#endif
#if ADC_PLACE_MOTOR > ADC_LAST_3
#define ADC_LAST      ADC_PLACE_MOTOR
#define ADC_LAST_PAIR ADC_MOTOR
#else
#define ADC_LAST      ADC_LAST_3
#define ADC_LAST_PAIR ADC_PAIR_3
#endif

/* Place of an input's result in the result registers: pair n gives 2n (A) and 2n + 1 (B). */
#define ADC_RESULT(input, place) (2 * (place) + ((input) >= 8 ? 1 : 0))

/* Power up (waits 5 ms), calibration, sequence, start by ePWM SOCA, interrupt at its end. */
void adc_init(void);

/* The next start begins with pair 0 again and may interrupt again. */
void adc_rearm(void);

#endif
