/* ADC: four simultaneous pairs once a carrier period, SPRU812 and data manual SPRS439 (simultaneous sampling
 * timing).
 *
 *   pair 0  A2/B2  dropped: the first conversion after a pause may be wrong (errata); converted again as pair
 * 3 pair 1  A0/B0  phase currents a and b, held exactly at t_k pair 2  A1/B1  DC link, sink temperature pair
 * 3  A2/B2  motor temperature, spare
 *
 * ADCCLK 25 MHz (6 cycles of 150 MHz). Sampling begins 2.5 ADCCLK after the start, the window is ACQ_PS + 1
 * ADCCLK, a pair follows the one before by 3 + ACQ_PS ADCCLK. So pair 1 is held 2.5 + 5 + 7 = 14.5 ADCCLK =
 * 87 cycles after the start, which therefore comes 87 counts before counter zero, by CMPB of ePWM1 counting
 * down. 15000 is a multiple of 6: ADCCLK keeps its phase to the carrier. The interrupt comes at the end of
 * the last pair, about 0.8 us after t_k.
 *
 * Does not calibrate: the boot ROM did, and ADCTRL1[RESET], which would undo it, is never used. */
#ifndef HAL_F28335_ADC_H
#define HAL_F28335_ADC_H

#define ADC_ACQ_PS            4u /* window of 5 ADCCLK = 200 ns; simultaneous mode asks for 160 ns or more */
#define ADC_CYCLES_HALF_CLOCK 3u /* [1/150 MHz] half an ADCCLK */

/* Start to hold of pair 1, in half ADCCLK: 5 to the window, the window, one pair. */
#define ADC_HALF_CLOCKS (5u + 2u * (ADC_ACQ_PS + 1u) + 2u * (3u + ADC_ACQ_PS))
#define ADC_LEAD        ((uint16_t)(ADC_CYCLES_HALF_CLOCK * ADC_HALF_CLOCKS)) /* [1/150 MHz] */

/* Places in the result registers: pair n gives results 2n (A) and 2n + 1 (B). */
#define ADC_CURRENT_A         2u
#define ADC_CURRENT_B         3u
#define ADC_DC_LINK           4u
#define ADC_SINK_TEMPERATURE  5u
#define ADC_MOTOR_TEMPERATURE 6u

/* Power up (waits 5 ms), sequence, start by ePWM SOCA, interrupt at its end. */
void adc_init(void);

/* The next start begins with pair 0 again and may interrupt again. */
void adc_rearm(void);

#endif
