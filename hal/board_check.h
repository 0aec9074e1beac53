/* Checks of the board file. The build refuses impossible values, with the line of docs/board.md that contains
 * the accepted values. Included by hal/board.h only, after its definitions. */
#ifndef HAL_BOARD_CHECK_H
#define HAL_BOARD_CHECK_H

/* ---- Line 2: clocks ---- */

#if BOARD_CRYSTAL_HZ < 20000000 || BOARD_CRYSTAL_HZ > 35000000
#error                                                                                                       \
    "docs/board.md, line 2: BOARD_CRYSTAL_HZ is accepted from 20 to 35 MHz, the range of the chip's oscillator"
#endif
#if BOARD_SYSCLK_HZ > 150000000 || BOARD_SYSCLK_HZ < 75000000
#error "docs/board.md, line 2: BOARD_SYSCLK_HZ is accepted from 75 to 150 MHz"
#endif
#if BOARD_PLL_TIMES > 10 || BOARD_PLL_TIMES * (BOARD_CRYSTAL_HZ / 1000) != 2 * (BOARD_SYSCLK_HZ / 1000)
#error                                                                                                       \
    "docs/board.md, line 2: this crystal gives no such BOARD_SYSCLK_HZ: crystal x n/2 with n = 1..10 (30 MHz: 150 MHz, 25: 125, 20: 100)"
#endif

/* ---- Line 3: carrier ---- */

#if BOARD_CARRIER_HZ < 5000 || BOARD_CARRIER_HZ > 20000
#error "docs/board.md, line 3: BOARD_CARRIER_HZ is accepted from 5000 to 20000"
#endif

/* ---- Lines 4 to 6: gates and trip ---- */

#if BOARD_LEG_FIRST != 1 && BOARD_LEG_FIRST != 4
#error                                                                                                       \
    "docs/board.md, line 4: the legs are ePWM1, 2, 3 or ePWM4, 5, 6, in any order: their counters start each other"
#endif
#if BOARD_LEG_A == BOARD_LEG_B || BOARD_LEG_B == BOARD_LEG_C || BOARD_LEG_A == BOARD_LEG_C ||                \
    BOARD_LEG_A > BOARD_LEG_FIRST + 2 || BOARD_LEG_B > BOARD_LEG_FIRST + 2 ||                                \
    BOARD_LEG_C > BOARD_LEG_FIRST + 2
#error                                                                                                       \
    "docs/board.md, line 4: the legs are ePWM1, 2, 3 or ePWM4, 5, 6, each once: their counters start each other"
#endif

#if HAL_GATE_ACTIVE_HIGH != 0 && HAL_GATE_ACTIVE_HIGH != 1
#error "docs/board.md, line 5: BOARD_GATE_ACTIVE_HIGH is 0 or 1"
#endif

#if BOARD_TRIP_ZONE < 1 || BOARD_TRIP_ZONE > 6
#error                                                                                                       \
    "docs/board.md, line 6: BOARD_TRIP_ZONE is accepted from 1 to 6 (TZ1 = GPIO12 to TZ6 = GPIO17, active low)"
#endif
#if BOARD_TRIP_PULL_UP != 0 && BOARD_TRIP_PULL_UP != 1
#error "docs/board.md, line 6: BOARD_TRIP_PULL_UP is 0 or 1"
#endif

/* ---- Line 7: dead band ---- */

#if BOARD_DEAD_BAND_MIN_NS < 50
#error                                                                                                       \
    "docs/board.md, line 7: BOARD_DEAD_BAND_MIN_NS is accepted from 50: the minimum of the data sheet of the switches"
#endif
#if BOARD_DEAD_TIME_NS < BOARD_DEAD_BAND_MIN_NS
#error                                                                                                       \
    "docs/board.md, line 7: BOARD_DEAD_TIME_NS is below BOARD_DEAD_BAND_MIN_NS, the minimum of the module: the legs would shoot through"
#endif
#if BOARD_CYCLES_OF_NS(BOARD_DEAD_TIME_NS) > BOARD_DEAD_BAND_MAX
#error "docs/board.md, line 7: BOARD_DEAD_TIME_NS does not fit the dead-band register, 1023 cycles"
#endif
#if BOARD_MINIMUM_PULSE_NS < 0 || BOARD_MINIMUM_PULSE_NS > 10000
#error "docs/board.md, line 7: BOARD_MINIMUM_PULSE_NS is accepted from 0 to 10000"
#endif

/* ---- Lines 8 and 9: currents ---- */

#define BOARD_IS_INPUT(n) ((n) >= 0 && (n) <= 15)
#if !BOARD_IS_INPUT(BOARD_CURRENT_A_INPUT) || !BOARD_IS_INPUT(BOARD_CURRENT_B_INPUT)
#error "docs/board.md, line 8: phases a and b need a sensor each: BOARD_ADC_A(0..7) or BOARD_ADC_B(0..7)"
#endif
#if BOARD_CURRENT_C_INPUT != BOARD_NONE && !BOARD_IS_INPUT(BOARD_CURRENT_C_INPUT)
#error "docs/board.md, line 8: BOARD_CURRENT_C_INPUT is BOARD_ADC_A(0..7), BOARD_ADC_B(0..7) or BOARD_NONE"
#endif
#if BOARD_CURRENT_A_INPUT % 8 != BOARD_CURRENT_B_INPUT % 8
#error                                                                                                       \
    "docs/board.md, line 8: currents a and b must be a pair, ADCINAn and ADCINBn: only a pair is sampled at the same instant"
#endif
#if BOARD_CURRENT_A_INPUT == BOARD_CURRENT_B_INPUT
#error "docs/board.md, line 8: currents a and b are on one input"
#endif

#if BOARD_CURRENT_ZERO_MV < 300 || BOARD_CURRENT_ZERO_MV > 2700
#error                                                                                                       \
    "docs/board.md, line 9: BOARD_CURRENT_ZERO_MV is accepted from 300 to 2700: the ADC must measure both directions"
#endif
#if BOARD_CURRENT_STEP_MA == 0 || BOARD_CURRENT_STEP_MV <= 0
#error                                                                                                       \
    "docs/board.md, line 9: BOARD_CURRENT_STEP_MA (negative: the sensor inverts) over BOARD_CURRENT_STEP_MV (positive) is no scale"
#endif

/* ---- Line 10: sampling ---- */

#if BOARD_SAMPLES_AT != BOARD_UPPER_ZERO_VECTOR && BOARD_SAMPLES_AT != BOARD_LOWER_ZERO_VECTOR
#error "docs/board.md, line 10: BOARD_SAMPLES_AT is BOARD_UPPER_ZERO_VECTOR or BOARD_LOWER_ZERO_VECTOR"
#endif
#if BOARD_SHUNT_SETTLED_NS < 0 || BOARD_SHUNT_SETTLED_NS + BOARD_DEAD_TIME_NS > 125000000 / BOARD_CARRIER_HZ
#error                                                                                                       \
    "docs/board.md, line 10: BOARD_SHUNT_SETTLED_NS is accepted from 0 to an eighth of a carrier period less dead time"
#endif
#if BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR && BOARD_SHUNT_SETTLED_NS != 0
#error                                                                                                       \
    "docs/board.md, line 10: BOARD_SHUNT_SETTLED_NS is for shunts below the lower switches: 0 at the upper zero vector"
#endif

/* ---- Lines 11 and 12: voltage and temperatures ---- */

#if !BOARD_IS_INPUT(BOARD_DC_INPUT)
#error "docs/board.md, line 11: BOARD_DC_INPUT is BOARD_ADC_A(0..7) or BOARD_ADC_B(0..7)"
#endif
#if BOARD_DC_STEP_MV <= 0 || BOARD_DC_PIN_MV <= 0
#error "docs/board.md, line 11: BOARD_DC_STEP_MV over BOARD_DC_PIN_MV is no scale"
#endif
#if BOARD_SINK_INPUT != BOARD_NONE && !BOARD_IS_INPUT(BOARD_SINK_INPUT)
#error "docs/board.md, line 12: BOARD_SINK_INPUT is BOARD_ADC_A(0..7), BOARD_ADC_B(0..7) or BOARD_NONE"
#endif
#if BOARD_MOTOR_INPUT != BOARD_NONE && !BOARD_IS_INPUT(BOARD_MOTOR_INPUT)
#error "docs/board.md, line 12: BOARD_MOTOR_INPUT is BOARD_ADC_A(0..7), BOARD_ADC_B(0..7) or BOARD_NONE"
#endif

/* Checks that each input has one signal. */
#define BOARD_SAME_INPUT(x, y) ((x) != BOARD_NONE && (x) == (y))
#if BOARD_SAME_INPUT(BOARD_CURRENT_C_INPUT, BOARD_CURRENT_A_INPUT) ||                                        \
    BOARD_SAME_INPUT(BOARD_CURRENT_C_INPUT, BOARD_CURRENT_B_INPUT)
#error "docs/board.md, line 8: BOARD_CURRENT_C_INPUT is the input of current a or b"
#endif
#if BOARD_SAME_INPUT(BOARD_DC_INPUT, BOARD_CURRENT_A_INPUT) ||                                               \
    BOARD_SAME_INPUT(BOARD_DC_INPUT, BOARD_CURRENT_B_INPUT) ||                                               \
    BOARD_SAME_INPUT(BOARD_DC_INPUT, BOARD_CURRENT_C_INPUT)
#error "docs/board.md, line 11: BOARD_DC_INPUT is the input of a current"
#endif
#if BOARD_SAME_INPUT(BOARD_SINK_INPUT, BOARD_CURRENT_A_INPUT) ||                                             \
    BOARD_SAME_INPUT(BOARD_SINK_INPUT, BOARD_CURRENT_B_INPUT) ||                                             \
    BOARD_SAME_INPUT(BOARD_SINK_INPUT, BOARD_CURRENT_C_INPUT) ||                                             \
    BOARD_SAME_INPUT(BOARD_SINK_INPUT, BOARD_DC_INPUT)
#error "docs/board.md, line 12: BOARD_SINK_INPUT is the input of a current or of the link"
#endif
#if BOARD_SAME_INPUT(BOARD_MOTOR_INPUT, BOARD_CURRENT_A_INPUT) ||                                            \
    BOARD_SAME_INPUT(BOARD_MOTOR_INPUT, BOARD_CURRENT_B_INPUT) ||                                            \
    BOARD_SAME_INPUT(BOARD_MOTOR_INPUT, BOARD_CURRENT_C_INPUT) ||                                            \
    BOARD_SAME_INPUT(BOARD_MOTOR_INPUT, BOARD_DC_INPUT) ||                                                   \
    BOARD_SAME_INPUT(BOARD_MOTOR_INPUT, BOARD_SINK_INPUT)
#error "docs/board.md, line 12: BOARD_MOTOR_INPUT is the input of another signal"
#endif

#if BOARD_SINK_AT_0V == BOARD_SINK_AT_3V || BOARD_SINK_MAX < BOARD_SINK_HOT
#error                                                                                                       \
    "docs/board.md, line 12: BOARD_SINK_AT_0V or BOARD_SINK_AT_3V is accepted from 95 degC: the ADC must be able to measure the trip temperature, 90 degC"
#endif
#if BOARD_MOTOR_AT_0V == BOARD_MOTOR_AT_3V || BOARD_MOTOR_MAX < BOARD_MOTOR_HOT
#error                                                                                                       \
    "docs/board.md, line 12: BOARD_MOTOR_AT_0V or BOARD_MOTOR_AT_3V is accepted from 135 degC: the ADC must be able to measure the trip temperature, 130 degC"
#endif

/* ---- Lines 13 and 14: encoder and lights ---- */

#if BOARD_ENCODER != BOARD_EQEP1_GPIO20 && BOARD_ENCODER != BOARD_EQEP1_GPIO50 &&                            \
    BOARD_ENCODER != BOARD_EQEP2_GPIO24
#error "docs/board.md, line 13: BOARD_ENCODER is BOARD_EQEP1_GPIO20, BOARD_EQEP1_GPIO50 or BOARD_EQEP2_GPIO24"
#endif
#if (BOARD_LED_RUN != BOARD_NONE && (BOARD_LED_RUN < 0 || BOARD_LED_RUN > 87)) ||                            \
    (BOARD_LED_FAULT != BOARD_NONE && (BOARD_LED_FAULT < 0 || BOARD_LED_FAULT > 87))
#error                                                                                                       \
    "docs/board.md, line 14: BOARD_LED_RUN and BOARD_LED_FAULT are the number of a GPIO, 0 to 87, or BOARD_NONE"
#endif
#define BOARD_ENCODER_PIN                                                                                    \
    (BOARD_ENCODER == BOARD_EQEP1_GPIO20 ? 20 : BOARD_ENCODER == BOARD_EQEP1_GPIO50 ? 50 : 24)
/* True for a pin of the gates, of the fault line or of the encoder. */
#define BOARD_PIN_IS_TAKEN(pin)                                                                              \
    (((pin) >= 2 * BOARD_LEG_FIRST - 2 && (pin) < 2 * BOARD_LEG_FIRST + 4) ||                                \
     (pin) == 11 + BOARD_TRIP_ZONE || ((pin) >= BOARD_ENCODER_PIN && (pin) < BOARD_ENCODER_PIN + 4))
#if BOARD_PIN_IS_TAKEN(BOARD_LED_RUN) || BOARD_PIN_IS_TAKEN(BOARD_LED_FAULT)
#error                                                                                                       \
    "docs/board.md, line 14: BOARD_LED_RUN or BOARD_LED_FAULT is a pin of a gate, of the fault line or of the encoder"
#endif
#if BOARD_LED_RUN != BOARD_NONE && BOARD_LED_RUN == BOARD_LED_FAULT
#error "docs/board.md, line 14: BOARD_LED_RUN and BOARD_LED_FAULT are one pin"
#endif
#if BOARD_LED_ACTIVE_LOW != 0 && BOARD_LED_ACTIVE_LOW != 1
#error "docs/board.md, line 14: BOARD_LED_ACTIVE_LOW is 0 or 1"
#endif

/* ---- Lines 15 and 16: power stage and limits ---- */

#if BOARD_TURN_ON_DELAY_NS < 0 || BOARD_TURN_ON_DELAY_NS > 5000 || BOARD_TURN_OFF_DELAY_NS < 0 ||            \
    BOARD_TURN_OFF_DELAY_NS > 5000
#error                                                                                                       \
    "docs/board.md, line 15: BOARD_TURN_ON_DELAY_NS and BOARD_TURN_OFF_DELAY_NS are accepted from 0 to 5000"
#endif
#if BOARD_TURN_OFF_DELAY_NS > BOARD_DEAD_TIME_NS + BOARD_TURN_ON_DELAY_NS
#error                                                                                                       \
    "docs/board.md, line 15: BOARD_TURN_OFF_DELAY_NS exceeds dead time and turn-on delay: the legs would shoot through"
#endif

#if BOARD_IGBT_DROP_MV < 0 || BOARD_IGBT_DROP_MV > 5000 || BOARD_DIODE_DROP_MV < 0 ||                        \
    BOARD_DIODE_DROP_MV > 5000
#error "docs/board.md, line 15: BOARD_IGBT_DROP_MV and BOARD_DIODE_DROP_MV are accepted from 0 to 5000"
#endif
#if BOARD_IGBT_SLOPE_UOHM < 0 || BOARD_IGBT_SLOPE_UOHM > 1000000 || BOARD_DIODE_SLOPE_UOHM < 0 ||            \
    BOARD_DIODE_SLOPE_UOHM > 1000000
#error                                                                                                       \
    "docs/board.md, line 15: BOARD_IGBT_SLOPE_UOHM and BOARD_DIODE_SLOPE_UOHM are accepted from 0 to 1000000"
#endif
#if BOARD_SHORT_CIRCUIT_TRIP_MA < 0 ||                                                                       \
    (BOARD_SHORT_CIRCUIT_TRIP_MA > 0 && BOARD_SHORT_CIRCUIT_TRIP_MA <= BOARD_OVERCURRENT_TRIP_MA)
#error                                                                                                       \
    "docs/board.md, line 15: BOARD_SHORT_CIRCUIT_TRIP_MA is 0 (none) or more than BOARD_OVERCURRENT_TRIP_MA"
#endif

#define BOARD_ABS(x) ((x) < 0 ? -(x) : (x))
#define BOARD_RANGE_UP_MA                                                                                    \
    ((3000 - BOARD_CURRENT_ZERO_MV) * BOARD_ABS(BOARD_CURRENT_STEP_MA) / BOARD_CURRENT_STEP_MV)
#define BOARD_RANGE_DOWN_MA (BOARD_CURRENT_ZERO_MV * BOARD_ABS(BOARD_CURRENT_STEP_MA) / BOARD_CURRENT_STEP_MV)
#if 100 * BOARD_OVERCURRENT_TRIP_MA > 95 * BOARD_RANGE_UP_MA ||                                              \
    100 * BOARD_OVERCURRENT_TRIP_MA > 95 * BOARD_RANGE_DOWN_MA
#error                                                                                                       \
    "docs/board.md, line 16: BOARD_OVERCURRENT_TRIP_MA is accepted up to 95 % of the range of the sensors in both directions"
#endif
#if BOARD_CURRENT_LIMIT_MA < 200
#error "docs/board.md, line 16: BOARD_CURRENT_LIMIT_MA is accepted from 200"
#endif
#if 12 * BOARD_CURRENT_LIMIT_MA > 10 * BOARD_OVERCURRENT_TRIP_MA
#error "docs/board.md, line 16: BOARD_OVERCURRENT_TRIP_MA is accepted from 1.2 BOARD_CURRENT_LIMIT_MA"
#endif
#if BOARD_UNDERVOLTAGE_MV < 10000
#error "docs/board.md, line 16: BOARD_UNDERVOLTAGE_MV is accepted from 10000"
#endif
#if BOARD_UNDERVOLTAGE_MV + 10000 > BOARD_OVERVOLTAGE_MV ||                                                  \
    BOARD_OVERVOLTAGE_MV > BOARD_OVERVOLTAGE_MAX_MV || BOARD_DC_NOMINAL_MV <= BOARD_UNDERVOLTAGE_MV ||       \
    BOARD_DC_NOMINAL_MV >= BOARD_OVERVOLTAGE_MV
#error                                                                                                       \
    "docs/board.md, line 16: BOARD_UNDERVOLTAGE_MV < BOARD_DC_NOMINAL_MV < BOARD_OVERVOLTAGE_MV <= BOARD_OVERVOLTAGE_MAX_MV, 10 V between the trips"
#endif
#if BOARD_OVERVOLTAGE_MAX_MV * BOARD_DC_PIN_MV > BOARD_DC_STEP_MV * 2940
#error                                                                                                       \
    "docs/board.md, line 16: BOARD_OVERVOLTAGE_MAX_MV is accepted up to 98 % of the largest link voltage that the ADC can measure"
#endif

/* ---- Line 17: module's heat, gate supply ---- */

#if BOARD_MODULE_CONTINUOUS_MA < 100 || BOARD_MODULE_CONTINUOUS_MA > 1000000
#error                                                                                                       \
    "docs/board.md, line 17: BOARD_MODULE_CONTINUOUS_MA is accepted from 100 to 1000000: the continuous direct current of a leg"
#endif
#if BOARD_MODULE_TIME_MS < 1 || BOARD_MODULE_TIME_MS > 100000
#error "docs/board.md, line 17: BOARD_MODULE_TIME_MS is accepted from 1 to 100000"
#endif
#if BOARD_GATE_CHARGE_US < 0 || BOARD_GATE_CHARGE_US > 100000
#error "docs/board.md, line 17: BOARD_GATE_CHARGE_US is accepted from 0 (isolated supplies) to 100000"
#endif

/* ---- Line 18: serial line ---- */

#if BOARD_SERIAL_BAUD != 0
#if BOARD_SERIAL_BAUD < 115200 || BOARD_SERIAL_BAUD > 2343750
#error "docs/board.md, line 18: BOARD_SERIAL_BAUD is 0 (no line) or accepted from 115200 to 2343750"
#endif
/* The receiver tolerates a sender that is up to 2.5 % faster or 6 % slower. */
#if BOARD_SERIAL_DIVIDER < 2 ||                                                                              \
    50 * BOARD_ABS(BOARD_LSPCLK_HZ - 8 * BOARD_SERIAL_DIVIDER * BOARD_SERIAL_BAUD) >                         \
        8 * BOARD_SERIAL_DIVIDER * BOARD_SERIAL_BAUD
#error                                                                                                       \
    "docs/board.md, line 18: BOARD_SERIAL_BAUD is not within 2 % of BOARD_SYSCLK_HZ/(32 n), n whole and at least 2 (150 MHz: 2343750, 1562500, 1171875, 937500, 115200; 125 MHz: 976563; 100 MHz: 781250)"
#endif
#if BOARD_SERIAL_PINS != BOARD_SCIA_GPIO28 && BOARD_SERIAL_PINS != BOARD_SCIA_GPIO35
#error "docs/board.md, line 18: BOARD_SERIAL_PINS is BOARD_SCIA_GPIO28 or BOARD_SCIA_GPIO35"
#endif
#define BOARD_SERIAL_LOWER       (BOARD_SERIAL_PINS == BOARD_SCIA_GPIO28 ? 28 : 35)
#define BOARD_PIN_IS_SERIAL(pin) ((pin) == BOARD_SERIAL_LOWER || (pin) == BOARD_SERIAL_LOWER + 1)
#if BOARD_PIN_IS_SERIAL(BOARD_LED_RUN) || BOARD_PIN_IS_SERIAL(BOARD_LED_FAULT)
#error "docs/board.md, line 18: BOARD_SERIAL_PINS are those of BOARD_LED_RUN or BOARD_LED_FAULT"
#endif
#else
#define BOARD_PIN_IS_SERIAL(pin) 0
#endif

/* ---- Line 19: enable input ---- */

#if BOARD_ENABLE_INPUT != BOARD_NONE
#if BOARD_ENABLE_INPUT < 0 || BOARD_ENABLE_INPUT > 87
#error "docs/board.md, line 19: BOARD_ENABLE_INPUT is the number of a GPIO, 0 to 87, or BOARD_NONE"
#endif
#if BOARD_PIN_IS_TAKEN(BOARD_ENABLE_INPUT) || BOARD_PIN_IS_SERIAL(BOARD_ENABLE_INPUT) ||                     \
    BOARD_ENABLE_INPUT == BOARD_LED_RUN || BOARD_ENABLE_INPUT == BOARD_LED_FAULT
#error                                                                                                       \
    "docs/board.md, line 19: BOARD_ENABLE_INPUT is a pin of a gate, the fault line, the encoder, a light or the serial line"
#endif
#if BOARD_ENABLE_ACTIVE_HIGH != 0 && BOARD_ENABLE_ACTIVE_HIGH != 1
#error "docs/board.md, line 19: BOARD_ENABLE_ACTIVE_HIGH is 0 or 1"
#endif
#if BOARD_ENABLE_DEBOUNCE_US < 0 || BOARD_ENABLE_DEBOUNCE_US > 20000
#error "docs/board.md, line 19: BOARD_ENABLE_DEBOUNCE_US is accepted from 0 to 20000"
#endif
#endif

/* ---- Line 20: where parameters are saved ---- */

#if BOARD_STORE != BOARD_STORE_FLASH && BOARD_STORE != BOARD_STORE_I2C
#error "docs/board.md, line 20: BOARD_STORE is BOARD_STORE_FLASH or BOARD_STORE_I2C"
#endif
#if BOARD_STORE == BOARD_STORE_I2C
#if BOARD_STORE_PINS != BOARD_I2CA_GPIO32
#error "docs/board.md, line 20: BOARD_STORE_PINS is BOARD_I2CA_GPIO32: the driver uses no other pins"
#endif
#define BOARD_PIN_IS_STORE(pin) ((pin) == 32 || (pin) == 33)
#if BOARD_PIN_IS_STORE(BOARD_LED_RUN) || BOARD_PIN_IS_STORE(BOARD_LED_FAULT) ||                              \
    BOARD_PIN_IS_STORE(BOARD_ENABLE_INPUT)
#error                                                                                                       \
    "docs/board.md, line 20: BOARD_STORE_PINS are those of BOARD_LED_RUN, BOARD_LED_FAULT or BOARD_ENABLE_INPUT"
#endif
#if BOARD_STORE_ADDRESS < 0x50 || BOARD_STORE_ADDRESS > 0x57
#error "docs/board.md, line 20: BOARD_STORE_ADDRESS is accepted from 0x50 to 0x57"
#endif
#if BOARD_STORE_PAGE_OCTETS < 0 || BOARD_STORE_PAGE_OCTETS > 128 || BOARD_STORE_PAGE_OCTETS % 8 != 0
#error "docs/board.md, line 20: BOARD_STORE_PAGE_OCTETS is 0 (no pages) or a multiple of 8 accepted up to 128"
#endif
#if BOARD_STORE_WRITE_US < 0 || BOARD_STORE_WRITE_US > 20000
#error "docs/board.md, line 20: BOARD_STORE_WRITE_US is accepted from 0 (none) to 20000"
#endif
#endif

/* ---- Line 21: brake chopper and holding brake ---- */

#if BOARD_STORE == BOARD_STORE_I2C
#define BOARD_PIN_IS_OF_STORE(pin) BOARD_PIN_IS_STORE(pin)
#else
#define BOARD_PIN_IS_OF_STORE(pin) 0
#endif
#define BOARD_OUTPUT_IS_TAKEN(pin)                                                                           \
    (BOARD_PIN_IS_TAKEN(pin) || BOARD_PIN_IS_SERIAL(pin) || BOARD_PIN_IS_OF_STORE(pin) ||                    \
     (pin) == BOARD_LED_RUN || (pin) == BOARD_LED_FAULT || (pin) == BOARD_ENABLE_INPUT)
#if (BOARD_CHOPPER_OUTPUT != BOARD_NONE && (BOARD_CHOPPER_OUTPUT < 0 || BOARD_CHOPPER_OUTPUT > 87)) ||       \
    (BOARD_BRAKE_OUTPUT != BOARD_NONE && (BOARD_BRAKE_OUTPUT < 0 || BOARD_BRAKE_OUTPUT > 87))
#error                                                                                                       \
    "docs/board.md, line 21: BOARD_CHOPPER_OUTPUT and BOARD_BRAKE_OUTPUT are the number of a GPIO, 0 to 87, or BOARD_NONE"
#endif
#if (BOARD_CHOPPER_OUTPUT != BOARD_NONE && BOARD_OUTPUT_IS_TAKEN(BOARD_CHOPPER_OUTPUT)) ||                   \
    (BOARD_BRAKE_OUTPUT != BOARD_NONE && BOARD_OUTPUT_IS_TAKEN(BOARD_BRAKE_OUTPUT))
#error                                                                                                       \
    "docs/board.md, line 21: BOARD_CHOPPER_OUTPUT or BOARD_BRAKE_OUTPUT is a pin of lines 4, 6, 13, 14, 18, 19 or 20"
#endif
#if BOARD_CHOPPER_OUTPUT != BOARD_NONE
#if BOARD_CHOPPER_OUTPUT == BOARD_BRAKE_OUTPUT
#error "docs/board.md, line 21: BOARD_CHOPPER_OUTPUT and BOARD_BRAKE_OUTPUT are one pin"
#endif
#if BOARD_CHOPPER_ACTIVE_HIGH != 0 && BOARD_CHOPPER_ACTIVE_HIGH != 1
#error "docs/board.md, line 21: BOARD_CHOPPER_ACTIVE_HIGH is 0 or 1"
#endif
#if BOARD_CHOPPER_CURRENT_MA < 100 || BOARD_CHOPPER_CURRENT_MA > 1000000
#error "docs/board.md, line 21: BOARD_CHOPPER_CURRENT_MA is accepted from 100 to 1000000"
#endif
#endif
#if BOARD_BRAKE_OUTPUT != BOARD_NONE
#if BOARD_BRAKE_ACTIVE_HIGH != 0 && BOARD_BRAKE_ACTIVE_HIGH != 1
#error "docs/board.md, line 21: BOARD_BRAKE_ACTIVE_HIGH is 0 or 1"
#endif
#endif

#endif
