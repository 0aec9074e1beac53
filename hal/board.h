/* The board: the file that describes it, and the values that follow from it. board_check.h rejects impossible
 * values.
 *
 * One header of hal/f28335/boards holds the facts of one board, as a schematic and data sheets give them
 * (docs/board.md explains each line; the numbers in the messages below are those of its table). It is chosen
 * by LAGLESS_BOARD_FILE, which the build sets (-DLAGLESS_BOARD=name). Nothing else in the tree names a pin, a
 * channel, a scale or a rate.
 *
 * Only constants: no code, no storage, no register. */
#ifndef HAL_BOARD_H
#define HAL_BOARD_H

#include <stdint.h>

/* ---- Words for board files ---- */

#define BOARD_NONE              99        /* the board does not have it */
#define BOARD_ADC_A(n)          (n)       /* ADCINAn, n = 0..7 */
#define BOARD_ADC_B(n)          (8 + (n)) /* ADCINBn, n = 0..7 */
#define BOARD_UPPER_ZERO_VECTOR 0         /* currents are held while all upper switches are on */
#define BOARD_LOWER_ZERO_VECTOR 1         /* while all lower switches are on, as shunts below them need */
#define BOARD_EQEP1_GPIO20      0         /* encoder on eQEP1: A, B, strobe, index on GPIO20 to 23 */
#define BOARD_EQEP1_GPIO50      1         /* on eQEP1: GPIO50 to 53 */
#define BOARD_EQEP2_GPIO24      2         /* on eQEP2: A, B, index, strobe on GPIO24 to 27 */
#define BOARD_SCIA_GPIO28       0         /* serial line on SCI-A: in on GPIO28, out on GPIO29 */
#define BOARD_SCIA_GPIO35       1         /* out on GPIO35, in on GPIO36 */
#define BOARD_STORE_FLASH       0         /* parameters are saved in the chip's own flash */
#define BOARD_STORE_I2C         1         /* in an EEPROM or FRAM on the I2C bus */
#define BOARD_I2CA_GPIO32       0         /* I2C bus on I2C-A: data on GPIO32, clock on GPIO33 */

/* ---- The board file ---- */

/* LAGLESS_ANY_BOARD: a source of the simulation that is compiled once for all boards. It may use only the
 * words above; a use of a number of one board does not compile in it. */
#if !defined(LAGLESS_ANY_BOARD)
#if defined(LAGLESS_BOARD_FILE)
#include LAGLESS_BOARD_FILE
#elif !defined(__TMS320C2000__)
#include "hal/f28335/boards/pm50rl1a060.h"
#else
#error "no board is chosen: -DLAGLESS_BOARD=name, one of hal/f28335/boards (docs/board.md)"
#endif

/* ---- Every line of the board file is defined ---- */

#if !defined(BOARD_NAME)
#error "docs/board.md, line 1: BOARD_NAME is missing"
#endif
#if !defined(BOARD_CRYSTAL_HZ) || !defined(BOARD_SYSCLK_HZ)
#error "docs/board.md, line 2: BOARD_CRYSTAL_HZ or BOARD_SYSCLK_HZ is missing"
#endif
#if !defined(BOARD_CARRIER_HZ)
#error "docs/board.md, line 3: BOARD_CARRIER_HZ is missing"
#endif
#if !defined(BOARD_LEG_A) || !defined(BOARD_LEG_B) || !defined(BOARD_LEG_C)
#error "docs/board.md, line 4: BOARD_LEG_A, BOARD_LEG_B or BOARD_LEG_C is missing"
#endif
#if !defined(BOARD_TRIP_ZONE) || !defined(BOARD_TRIP_PULL_UP)
#error "docs/board.md, line 6: BOARD_TRIP_ZONE or BOARD_TRIP_PULL_UP is missing"
#endif
#if !defined(BOARD_DEAD_BAND_MIN_NS) || !defined(BOARD_DEAD_TIME_NS) || !defined(BOARD_MINIMUM_PULSE_NS)
#error                                                                                                       \
    "docs/board.md, line 7: BOARD_DEAD_BAND_MIN_NS, BOARD_DEAD_TIME_NS or BOARD_MINIMUM_PULSE_NS is missing"
#endif
#if !defined(BOARD_CURRENT_A_INPUT) || !defined(BOARD_CURRENT_B_INPUT) || !defined(BOARD_CURRENT_C_INPUT)
#error "docs/board.md, line 8: BOARD_CURRENT_A_INPUT, _B_INPUT or _C_INPUT is missing"
#endif
#if !defined(BOARD_CURRENT_ZERO_MV) || !defined(BOARD_CURRENT_STEP_MA) || !defined(BOARD_CURRENT_STEP_MV)
#error "docs/board.md, line 9: BOARD_CURRENT_ZERO_MV, _STEP_MA or _STEP_MV is missing"
#endif
#if !defined(BOARD_SAMPLES_AT) || !defined(BOARD_SHUNT_SETTLED_NS)
#error "docs/board.md, line 10: BOARD_SAMPLES_AT or BOARD_SHUNT_SETTLED_NS is missing"
#endif
#if !defined(BOARD_DC_INPUT) || !defined(BOARD_DC_STEP_MV) || !defined(BOARD_DC_PIN_MV)
#error "docs/board.md, line 11: BOARD_DC_INPUT, BOARD_DC_STEP_MV or BOARD_DC_PIN_MV is missing"
#endif
#if !defined(BOARD_SINK_INPUT) || !defined(BOARD_MOTOR_INPUT)
#error "docs/board.md, line 12: BOARD_SINK_INPUT or BOARD_MOTOR_INPUT is missing (BOARD_NONE: no sensor)"
#endif
#if BOARD_SINK_INPUT != BOARD_NONE && (!defined(BOARD_SINK_AT_0V) || !defined(BOARD_SINK_AT_3V))
#error "docs/board.md, line 12: BOARD_SINK_AT_0V or BOARD_SINK_AT_3V is missing"
#endif
#if BOARD_MOTOR_INPUT != BOARD_NONE && (!defined(BOARD_MOTOR_AT_0V) || !defined(BOARD_MOTOR_AT_3V))
#error "docs/board.md, line 12: BOARD_MOTOR_AT_0V or BOARD_MOTOR_AT_3V is missing"
#endif
#if !defined(BOARD_ENCODER)
#error "docs/board.md, line 13: BOARD_ENCODER is missing"
#endif
#if !defined(BOARD_LED_RUN) || !defined(BOARD_LED_FAULT) || !defined(BOARD_LED_ACTIVE_LOW)
#error "docs/board.md, line 14: BOARD_LED_RUN, BOARD_LED_FAULT or BOARD_LED_ACTIVE_LOW is missing"
#endif
#if !defined(BOARD_TURN_ON_DELAY_NS) || !defined(BOARD_TURN_OFF_DELAY_NS) || !defined(BOARD_IGBT_DROP_MV) || \
    !defined(BOARD_IGBT_SLOPE_UOHM) || !defined(BOARD_DIODE_DROP_MV) || !defined(BOARD_DIODE_SLOPE_UOHM) ||  \
    !defined(BOARD_SHORT_CIRCUIT_TRIP_MA)
#error                                                                                                       \
    "docs/board.md, line 15: a delay, drop, slope or BOARD_SHORT_CIRCUIT_TRIP_MA of the power stage is missing"
#endif
#if !defined(BOARD_CURRENT_LIMIT_MA) || !defined(BOARD_OVERCURRENT_TRIP_MA) ||                               \
    !defined(BOARD_UNDERVOLTAGE_MV) || !defined(BOARD_OVERVOLTAGE_MV) ||                                     \
    !defined(BOARD_OVERVOLTAGE_MAX_MV) || !defined(BOARD_DC_NOMINAL_MV)
#error "docs/board.md, line 16: a limit of current or voltage is missing"
#endif

#if !defined(BOARD_MODULE_CONTINUOUS_MA) || !defined(BOARD_MODULE_TIME_MS) || !defined(BOARD_GATE_CHARGE_US)
#error                                                                                                       \
    "docs/board.md, line 17: BOARD_MODULE_CONTINUOUS_MA, BOARD_MODULE_TIME_MS or BOARD_GATE_CHARGE_US is missing"
#endif

#if !defined(BOARD_SERIAL_BAUD)
#error "docs/board.md, line 18: BOARD_SERIAL_BAUD is missing (0: no serial line)"
#endif
#if BOARD_SERIAL_BAUD != 0 && !defined(BOARD_SERIAL_PINS)
#error "docs/board.md, line 18: BOARD_SERIAL_PINS is missing"
#endif

#if !defined(BOARD_ENABLE_INPUT)
#error                                                                                                       \
    "docs/board.md, line 19: BOARD_ENABLE_INPUT is missing (BOARD_NONE: every client on the serial line may start the motor)"
#endif
#if BOARD_ENABLE_INPUT != BOARD_NONE &&                                                                      \
    (!defined(BOARD_ENABLE_ACTIVE_HIGH) || !defined(BOARD_ENABLE_DEBOUNCE_US))
#error "docs/board.md, line 19: BOARD_ENABLE_ACTIVE_HIGH or BOARD_ENABLE_DEBOUNCE_US is missing"
#endif

#if !defined(BOARD_STORE)
#error "docs/board.md, line 20: BOARD_STORE is missing (BOARD_STORE_FLASH: the chip's own flash)"
#endif
#if BOARD_STORE == BOARD_STORE_I2C && (!defined(BOARD_STORE_PINS) || !defined(BOARD_STORE_ADDRESS) ||        \
                                       !defined(BOARD_STORE_PAGE_OCTETS) || !defined(BOARD_STORE_WRITE_US))
#error                                                                                                       \
    "docs/board.md, line 20: BOARD_STORE_PINS, BOARD_STORE_ADDRESS, BOARD_STORE_PAGE_OCTETS or BOARD_STORE_WRITE_US is missing"
#endif

#if !defined(BOARD_CHOPPER_OUTPUT) || !defined(BOARD_BRAKE_OUTPUT)
#error "docs/board.md, line 21: BOARD_CHOPPER_OUTPUT or BOARD_BRAKE_OUTPUT is missing (BOARD_NONE: no output)"
#endif
#if BOARD_CHOPPER_OUTPUT != BOARD_NONE &&                                                                    \
    (!defined(BOARD_CHOPPER_ACTIVE_HIGH) || !defined(BOARD_CHOPPER_CURRENT_MA))
#error "docs/board.md, line 21: BOARD_CHOPPER_ACTIVE_HIGH or BOARD_CHOPPER_CURRENT_MA is missing"
#endif
#if BOARD_BRAKE_OUTPUT != BOARD_NONE && !defined(BOARD_BRAKE_ACTIVE_HIGH)
#error "docs/board.md, line 21: BOARD_BRAKE_ACTIVE_HIGH is missing"
#endif

/* ---- Line 2: clocks ---- */

#define BOARD_PLL_TIMES (2 * (BOARD_SYSCLK_HZ / 1000) / (BOARD_CRYSTAL_HZ / 1000)) /* PLLCR; then /2 */

/* The ADC's clock is SYSCLK/(2n), at most 25 MHz. */
#define BOARD_ADC_PRESCALE ((BOARD_SYSCLK_HZ + 49999999) / 50000000) /* n: HISPCP */

/* ---- Line 3: carrier ---- */

/* Counts of half a carrier period: the nearest to the requested carrier for which a whole period is a whole
 * number of ADC clocks, so that the ADC samples at the same count in every period. */
#define BOARD_PERIOD_COUNT                                                                                   \
    (BOARD_ADC_PRESCALE * ((BOARD_SYSCLK_HZ + BOARD_ADC_PRESCALE * BOARD_CARRIER_HZ) /                       \
                           (2 * BOARD_ADC_PRESCALE * BOARD_CARRIER_HZ)))
#define BOARD_PERIOD_CYCLES (2 * BOARD_PERIOD_COUNT)
#define BOARD_PERIOD        ((float)BOARD_PERIOD_CYCLES / (float)BOARD_SYSCLK_HZ) /* T_s [s] */

/* ---- Lines 4 to 6: gates and trip ---- */

#define BOARD_LEG_FIRST                                                                                      \
    (BOARD_LEG_A < BOARD_LEG_B ? (BOARD_LEG_A < BOARD_LEG_C ? BOARD_LEG_A : BOARD_LEG_C)                     \
                               : (BOARD_LEG_B < BOARD_LEG_C ? BOARD_LEG_B : BOARD_LEG_C))

/* Level of a gate pin that turns its switch on: the board file defines it, or the build if the stage in front
 * of the module is the user's: -DLAGLESS_GATES=active_high or active_low. */
#if defined(BOARD_GATE_ACTIVE_HIGH) && defined(HAL_GATE_ACTIVE_HIGH)
#if BOARD_GATE_ACTIVE_HIGH != HAL_GATE_ACTIVE_HIGH
#error "docs/board.md, line 5: LAGLESS_GATES contradicts BOARD_GATE_ACTIVE_HIGH of the board file"
#endif
#elif defined(BOARD_GATE_ACTIVE_HIGH)
#define HAL_GATE_ACTIVE_HIGH BOARD_GATE_ACTIVE_HIGH
#elif !defined(HAL_GATE_ACTIVE_HIGH)
#if defined(__TMS320C2000__)
#error                                                                                                       \
    "docs/board.md, line 5: the level that turns a switch on is open: -DLAGLESS_GATES=active_high or active_low"
#endif
#define HAL_GATE_ACTIVE_HIGH 1
#endif

/* ---- Line 7: dead band ---- */

/* Nanoseconds in SYSCLK cycles, rounded up. */
#define BOARD_CYCLES_OF_NS(ns) (((ns) * (BOARD_SYSCLK_HZ / 100000) + 9999) / 10000)

#define BOARD_DEAD_BAND_MIN BOARD_CYCLES_OF_NS(BOARD_DEAD_BAND_MIN_NS)
#define BOARD_DEAD_BAND_MAX 1023 /* the register has 10 bits */

/* ---- Lines 8 and 9: currents ---- */

#define BOARD_CURRENT_SENSORS (BOARD_CURRENT_C_INPUT == BOARD_NONE ? 2 : 3)

/* The ADC has 4096 codes for 0 to 3 V; a code represents the middle of its step. */
#define BOARD_ADC_FULL  4096
#define BOARD_HALF_CODE 0.5f
#define BOARD_PIN_MV    3000.0f

#define BOARD_AMPERES(ma) ((float)(ma) / 1000.0f)
#define BOARD_CURRENT_OVER(mv)                                                                               \
    (BOARD_AMPERES(BOARD_CURRENT_STEP_MA) * (mv) / (float)BOARD_CURRENT_STEP_MV)               /* [A] */
#define BOARD_CURRENT_AT_0V    (-BOARD_CURRENT_OVER((float)BOARD_CURRENT_ZERO_MV))             /* [A] */
#define BOARD_CURRENT_AT_3V    BOARD_CURRENT_OVER(BOARD_PIN_MV - (float)BOARD_CURRENT_ZERO_MV) /* [A] */
#define BOARD_CURRENT_PER_CODE (BOARD_CURRENT_OVER(BOARD_PIN_MV) / (float)BOARD_ADC_FULL)      /* [A] */

#if BOARD_CURRENT_STEP_MA > 0
#define BOARD_CURRENT_MIN BOARD_CURRENT_AT_0V /* [A] range of the ADC */
#define BOARD_CURRENT_MAX BOARD_CURRENT_AT_3V
#else
#define BOARD_CURRENT_MIN BOARD_CURRENT_AT_3V
#define BOARD_CURRENT_MAX BOARD_CURRENT_AT_0V
#endif
/* Range in both directions [A]. */
#define BOARD_CURRENT_RANGE (BOARD_CURRENT_MAX < -BOARD_CURRENT_MIN ? BOARD_CURRENT_MAX : -BOARD_CURRENT_MIN)

/* ---- Lines 11 and 12: voltage and temperatures ---- */

#define BOARD_VOLTS(mv)   ((float)(mv) / 1000.0f)
#define BOARD_DC_AT_3V    (BOARD_VOLTS(BOARD_DC_STEP_MV) * BOARD_PIN_MV / (float)BOARD_DC_PIN_MV) /* [V] */
#define BOARD_DC_PER_CODE (BOARD_DC_AT_3V / (float)BOARD_ADC_FULL)                                /* [V] */

/* For the simulation, whose plant always has both temperatures: any law is sufficient. */
#if !defined(BOARD_SINK_AT_0V)
#define BOARD_SINK_AT_0V (-50)
#define BOARD_SINK_AT_3V 150
#endif
#if !defined(BOARD_MOTOR_AT_0V)
#define BOARD_MOTOR_AT_0V (-50)
#define BOARD_MOTOR_AT_3V 150
#endif

/* A trip threshold above the end of its sensor's scale would never be reached, so the largest threshold is 2
 * % below this end. Largest accepted temperature limit [degC]: the smaller of this end and the limit of
 * switches and windings. */
#define BOARD_HOTTER(x, y) ((x) > (y) ? (x) : (y))
#define BOARD_COLDER(x, y) ((x) < (y) ? (x) : (y))
#define BOARD_HOT_END(at_0v, at_3v)                                                                          \
    (BOARD_HOTTER(at_0v, at_3v) - (BOARD_HOTTER(at_0v, at_3v) - BOARD_COLDER(at_0v, at_3v)) / 50)
#define BOARD_SINK_MAX  BOARD_COLDER(BOARD_HOT_END(BOARD_SINK_AT_0V, BOARD_SINK_AT_3V), 120)
#define BOARD_MOTOR_MAX BOARD_COLDER(BOARD_HOT_END(BOARD_MOTOR_AT_0V, BOARD_MOTOR_AT_3V), 145)
#define BOARD_SINK_HOT  90  /* [degC] at which the drive stops by default */
#define BOARD_MOTOR_HOT 130 /* [degC] */

/* ---- Lines 15 and 16: power stage and limits ---- */

#define BOARD_SECONDS(ns) ((float)(ns) / 1e9f)

/* ---- Line 18: serial line ---- */

/* SCI-A counts LSPCLK, a quarter of SYSCLK; a bit is 8 n of its cycles, n = BRR + 1 the nearest whole number
 * of at least 2. */
#define BOARD_LSPCLK_HZ (BOARD_SYSCLK_HZ / 4)
#if BOARD_SERIAL_BAUD > 0
#define BOARD_SERIAL_DIVIDER ((BOARD_LSPCLK_HZ + 4 * BOARD_SERIAL_BAUD) / (8 * BOARD_SERIAL_BAUD))
#endif

/* ---- Line 19: enable input ---- */

/* Without an input nothing is debounced. */
#if !defined(BOARD_ENABLE_DEBOUNCE_US)
#define BOARD_ENABLE_DEBOUNCE_US 0
#endif

/* ---- Line 21: brake chopper and holding brake ---- */

#if !defined(BOARD_CHOPPER_CURRENT_MA)
#define BOARD_CHOPPER_CURRENT_MA 100 /* without an output it has no effect */
#endif

/* ---- Checks of these values ---- */

#include "hal/board_check.h"

#endif
#endif
