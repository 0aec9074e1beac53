/* A board for the tests, written with docs/board.md as the only source. A pump of 2.2 kW on the mains:
 * F28335 control card with a 30 MHz crystal, whose serial line is on GPIO35 and 36. The IGBT module has
 * bootstrap gate drivers on ePWM1 to 3 and three shunts below the lower switches. The encoder is on GPIO50
 * to 53. A contact, which the control of the plant closes, enables the drive. An FRAM stores the
 * parameters. */
#define BOARD_NAME "pump325" /* 1 */

#define BOARD_CRYSTAL_HZ 30000000 /* 2: 30 MHz x 10/2 */
#define BOARD_SYSCLK_HZ  150000000

#define BOARD_CARRIER_HZ 10000 /* 3 */

#define BOARD_LEG_A 3 /* 4: GPIO4, 5 */
#define BOARD_LEG_B 1 /* GPIO0, 1 */
#define BOARD_LEG_C 2 /* GPIO2, 3 */

#define BOARD_GATE_ACTIVE_HIGH 1 /* 5 */

#define BOARD_TRIP_ZONE    3 /* 6: TZ3 = GPIO14, open drain of the module */
#define BOARD_TRIP_PULL_UP 1

#define BOARD_DEAD_BAND_MIN_NS 1000 /* 7: from the data sheet of the module */
#define BOARD_DEAD_TIME_NS     1500
#define BOARD_MINIMUM_PULSE_NS 800

#define BOARD_CURRENT_A_INPUT BOARD_ADC_A(2) /* 8 */
#define BOARD_CURRENT_B_INPUT BOARD_ADC_B(2)
#define BOARD_CURRENT_C_INPUT BOARD_ADC_A(4)

#define BOARD_CURRENT_ZERO_MV 1500 /* 9: 10 mohm x 5 + 1.5 V: 50 mV/A, +-30 A */
#define BOARD_CURRENT_STEP_MA 30000
#define BOARD_CURRENT_STEP_MV 1500

#define BOARD_SAMPLES_AT       BOARD_LOWER_ZERO_VECTOR /* 10 */
#define BOARD_SHUNT_SETTLED_NS 2500

#define BOARD_DC_INPUT   BOARD_ADC_B(7) /* 11: 450 V are 2.9 V */
#define BOARD_DC_STEP_MV 450000
#define BOARD_DC_PIN_MV  2900

#define BOARD_SINK_INPUT  BOARD_ADC_B(0) /* 12: tangent of the module's thermistor at 90 degC */
#define BOARD_SINK_AT_0V  140
#define BOARD_SINK_AT_3V  10
#define BOARD_MOTOR_INPUT BOARD_NONE

#define BOARD_ENCODER BOARD_EQEP1_GPIO50 /* 13 */

#define BOARD_LED_RUN        60 /* 14 */
#define BOARD_LED_FAULT      61
#define BOARD_LED_ACTIVE_LOW 1

#define BOARD_TURN_ON_DELAY_NS      500 /* 15 */
#define BOARD_TURN_OFF_DELAY_NS     600
#define BOARD_IGBT_DROP_MV          900
#define BOARD_IGBT_SLOPE_UOHM       30000
#define BOARD_DIODE_DROP_MV         1000
#define BOARD_DIODE_SLOPE_UOHM      28000
#define BOARD_SHORT_CIRCUIT_TRIP_MA 60000

#define BOARD_CURRENT_LIMIT_MA    12000 /* 16 */
#define BOARD_OVERCURRENT_TRIP_MA 18000
#define BOARD_DC_NOMINAL_MV       325000
#define BOARD_UNDERVOLTAGE_MV     200000
#define BOARD_OVERVOLTAGE_MV      400000
#define BOARD_OVERVOLTAGE_MAX_MV  420000

#define BOARD_MODULE_CONTINUOUS_MA 15000 /* 17 */
#define BOARD_MODULE_TIME_MS       150
#define BOARD_GATE_CHARGE_US       500

#define BOARD_SERIAL_BAUD 1171875 /* 18 */
#define BOARD_SERIAL_PINS BOARD_SCIA_GPIO35

/* 19: the contact connects the pin to 3.3 V; a resistor on the board pulls it down. */
#define BOARD_ENABLE_INPUT       49
#define BOARD_ENABLE_ACTIVE_HIGH 1
#define BOARD_ENABLE_DEBOUNCE_US 3000

#define BOARD_STORE             BOARD_STORE_I2C /* 20: FM24W256, A0 to A2 at ground */
#define BOARD_STORE_PINS        BOARD_I2CA_GPIO32
#define BOARD_STORE_ADDRESS     0x50
#define BOARD_STORE_PAGE_OCTETS 0
#define BOARD_STORE_WRITE_US    0

#define BOARD_CHOPPER_OUTPUT BOARD_NONE /* 21 */
#define BOARD_BRAKE_OUTPUT   BOARD_NONE
