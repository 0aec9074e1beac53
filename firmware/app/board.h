/* The board between motor and controller: scaling of its analog front end. The drive speaks SI, the HAL
 * speaks counts; app.c turns one into the other with these numbers. */
#ifndef APP_BOARD_H
#define APP_BOARD_H

#include "drive/params.h"
#include "hal/hal.h"

/* An ADC code stands for the middle of its step. */
#define BOARD_HALF_CODE 0.5f

/* Phase currents: two sensors, 1.5 V at zero, full scale DRIVE_CURRENT_RANGE at either end. */
#define BOARD_CURRENT_PER_CODE (2.0f * DRIVE_CURRENT_RANGE / (float)HAL_ADC_FULL) /* [A] */
#define BOARD_CURRENT_ZERO     (-DRIVE_CURRENT_RANGE)                             /* [A] at code 0 */

/* DC link: divider, 3 V = 500 V. */
#define BOARD_DC_PER_CODE (500.0f / (float)HAL_ADC_FULL) /* [V] */

/* Temperatures: linear sensors, 0 V = -50 degC, 3 V = 150 degC. */
#define BOARD_TEMPERATURE_PER_CODE (200.0f / (float)HAL_ADC_FULL) /* [K] */
#define BOARD_TEMPERATURE_ZERO     (-50.0f)                       /* [degC] at code 0 */

#endif
