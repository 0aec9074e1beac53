/* A board for the tests, written with docs/board.md as the only source. A drive of 48 V and 30 A: F28335
 * with a 20 MHz crystal, MOSFETs behind inverting gate drivers on ePWM4 to 6, a Hall sensor in each motor
 * lead, mounted so that its output falls with the current. */
#define BOARD_NAME "desk48" /* 1 */

#define BOARD_CRYSTAL_HZ 20000000 /* 2: 20 MHz x 10/2 */
#define BOARD_SYSCLK_HZ  100000000

#define BOARD_CARRIER_HZ 10000 /* 3: 100 MHz/10000; the longest interrupt takes nine tenths of the period */

#define BOARD_LEG_A 5 /* 4: GPIO8, 9 */
#define BOARD_LEG_B 6 /* GPIO10, 11 */
#define BOARD_LEG_C 4 /* GPIO6, 7 */

#define BOARD_GATE_ACTIVE_HIGH 0 /* 5 */

#define BOARD_TRIP_ZONE    6 /* 6: TZ6 = GPIO17, which a comparator drives high and low */
#define BOARD_TRIP_PULL_UP 0

#define BOARD_DEAD_BAND_MIN_NS 322 /* 7: 250 ns for the gate driver and 72 ns for its skew */
#define BOARD_DEAD_TIME_NS     400
#define BOARD_MINIMUM_PULSE_NS 500

#define BOARD_CURRENT_A_INPUT BOARD_ADC_B(5) /* 8 */
#define BOARD_CURRENT_B_INPUT BOARD_ADC_A(5)
#define BOARD_CURRENT_C_INPUT BOARD_ADC_B(2)

#define BOARD_CURRENT_ZERO_MV 1650 /* 9: 26.4 mV/A down from 1.65 V: +62.5 A at 0 V, -51.1 A at 3 V */
#define BOARD_CURRENT_STEP_MA (-50000)
#define BOARD_CURRENT_STEP_MV 1320

#define BOARD_SAMPLES_AT       BOARD_UPPER_ZERO_VECTOR /* 10: sensors in the leads */
#define BOARD_SHUNT_SETTLED_NS 0

#define BOARD_DC_INPUT   BOARD_ADC_A(0) /* 11: 60 V are 2.5 V, 3 V are 72 V */
#define BOARD_DC_STEP_MV 60000
#define BOARD_DC_PIN_MV  2500

#define BOARD_SINK_INPUT  BOARD_ADC_A(6) /* 12: 500 mV + 10 mV/degC */
#define BOARD_SINK_AT_0V  (-50)
#define BOARD_SINK_AT_3V  250
#define BOARD_MOTOR_INPUT BOARD_NONE

#define BOARD_ENCODER BOARD_EQEP2_GPIO24 /* 13 */

#define BOARD_LED_RUN        32 /* 14 */
#define BOARD_LED_FAULT      61
#define BOARD_LED_ACTIVE_LOW 0

/* 15: 4 mohm in both directions, since the channel of a MOSFET conducts current of either sign */
#define BOARD_TURN_ON_DELAY_NS      120
#define BOARD_TURN_OFF_DELAY_NS     150
#define BOARD_IGBT_DROP_MV          0
#define BOARD_IGBT_SLOPE_UOHM       4000
#define BOARD_DIODE_DROP_MV         0
#define BOARD_DIODE_SLOPE_UOHM      4000
#define BOARD_SHORT_CIRCUIT_TRIP_MA 120000

#define BOARD_CURRENT_LIMIT_MA    30000 /* 16 */
#define BOARD_OVERCURRENT_TRIP_MA 45000
#define BOARD_DC_NOMINAL_MV       48000
#define BOARD_UNDERVOLTAGE_MV     24000
#define BOARD_OVERVOLTAGE_MV      60000
#define BOARD_OVERVOLTAGE_MAX_MV  66000

#define BOARD_MODULE_CONTINUOUS_MA 40000 /* 17 */
#define BOARD_MODULE_TIME_MS       50
#define BOARD_GATE_CHARGE_US       200

#define BOARD_SERIAL_BAUD 781250 /* 18 */
#define BOARD_SERIAL_PINS BOARD_SCIA_GPIO35

#define BOARD_ENABLE_INPUT       50 /* 19: closed to ground by a relay, with the chip's pull-up */
#define BOARD_ENABLE_ACTIVE_HIGH 0
#define BOARD_ENABLE_DEBOUNCE_US 2000

#define BOARD_STORE BOARD_STORE_FLASH /* 20 */

#define BOARD_CHOPPER_OUTPUT      58 /* 21: the chopper has an inverting driver, the brake a relay */
#define BOARD_CHOPPER_ACTIVE_HIGH 0
#define BOARD_CHOPPER_CURRENT_MA  40000
#define BOARD_BRAKE_OUTPUT        59
#define BOARD_BRAKE_ACTIVE_HIGH   1
