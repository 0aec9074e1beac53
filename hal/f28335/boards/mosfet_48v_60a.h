/* Board: a generic low-voltage stage of 48 V and 60 A, no product: TMS320F28335 (30 MHz crystal), six MOSFETs
 * of 100 V with a bootstrap gate driver, 0.5 mohm shunts below the lower switches of all three legs.
 * docs/board.md explains each line and its check on the bench. */
#define BOARD_NAME "mosfet_48v_60a" /* 1 */

#define BOARD_CRYSTAL_HZ 30000000 /* 2 */
#define BOARD_SYSCLK_HZ  150000000

#define BOARD_CARRIER_HZ 20000 /* 3 */

#define BOARD_LEG_A 1 /* 4: EPWM1A, 1B = GPIO0, 1 */
#define BOARD_LEG_B 2 /* GPIO2, 3 */
#define BOARD_LEG_C 3 /* GPIO4, 5 */

#define BOARD_GATE_ACTIVE_HIGH 1 /* 5 */

#define BOARD_TRIP_ZONE    1 /* 6: TZ1 = GPIO12, fault output of the gate driver, open drain */
#define BOARD_TRIP_PULL_UP 1

#define BOARD_DEAD_BAND_MIN_NS 200 /* 7: 150 ns to turn off, 50 ns of skew */
#define BOARD_DEAD_TIME_NS     400
#define BOARD_MINIMUM_PULSE_NS 300

#define BOARD_CURRENT_A_INPUT BOARD_ADC_A(0) /* 8 */
#define BOARD_CURRENT_B_INPUT BOARD_ADC_B(0)
#define BOARD_CURRENT_C_INPUT BOARD_ADC_A(1)

#define BOARD_CURRENT_ZERO_MV 1500 /* 9: 0.5 mohm x 30 + 1.5 V: 15 mV/A, +-100 A are 0 to 3 V */
#define BOARD_CURRENT_STEP_MA 100000
#define BOARD_CURRENT_STEP_MV 1500

#define BOARD_SAMPLES_AT       BOARD_LOWER_ZERO_VECTOR /* 10 */
#define BOARD_SHUNT_SETTLED_NS 1200

#define BOARD_DC_INPUT   BOARD_ADC_B(1) /* 11: 100 kohm over 3.9 kohm: 3 V are 79.9 V */
#define BOARD_DC_STEP_MV 103900
#define BOARD_DC_PIN_MV  3900

#define BOARD_SINK_INPUT  BOARD_ADC_A(2) /* 12: 500 mV + 10 mV/degC beside the switches */
#define BOARD_SINK_AT_0V  (-50)
#define BOARD_SINK_AT_3V  250
#define BOARD_MOTOR_INPUT BOARD_NONE

#define BOARD_ENCODER BOARD_EQEP1_GPIO20 /* 13 */

#define BOARD_LED_RUN        31 /* 14 */
#define BOARD_LED_FAULT      34
#define BOARD_LED_ACTIVE_LOW 1

/* 15: at 100 degC 2 mohm in both directions, because the channel conducts in both. The 0.5 mohm of a shunt
 * are in some paths only, and are omitted. */
#define BOARD_TURN_ON_DELAY_NS      120
#define BOARD_TURN_OFF_DELAY_NS     160
#define BOARD_IGBT_DROP_MV          0
#define BOARD_IGBT_SLOPE_UOHM       2000
#define BOARD_DIODE_DROP_MV         0
#define BOARD_DIODE_SLOPE_UOHM      2000
#define BOARD_SHORT_CIRCUIT_TRIP_MA 200000

#define BOARD_CURRENT_LIMIT_MA    60000 /* 16 */
#define BOARD_OVERCURRENT_TRIP_MA 90000
#define BOARD_DC_NOMINAL_MV       48000
#define BOARD_UNDERVOLTAGE_MV     30000
#define BOARD_OVERVOLTAGE_MV      62000
#define BOARD_OVERVOLTAGE_MAX_MV  70000 /* seven tenths of the switches' rated voltage */

#define BOARD_MODULE_CONTINUOUS_MA 60000 /* 17 */
#define BOARD_MODULE_TIME_MS       100
#define BOARD_GATE_CHARGE_US       100 /* upper gates from bootstrap capacitors */

#define BOARD_SERIAL_BAUD 937500 /* 18: LSPCLK / 40, exactly */
#define BOARD_SERIAL_PINS BOARD_SCIA_GPIO28

/* 19: a contact to 3.3 V, with a resistor to ground: an open wire is off */
#define BOARD_ENABLE_INPUT       27
#define BOARD_ENABLE_ACTIVE_HIGH 1
#define BOARD_ENABLE_DEBOUNCE_US 5000

#define BOARD_STORE BOARD_STORE_FLASH /* 20 */

/* 21: a MOSFET for the resistor, and another one for a brake of 24 V. Resistors of 2.2 kohm to ground keep
 * the resistor off and the brake set during a reset. */
#define BOARD_CHOPPER_OUTPUT      30
#define BOARD_CHOPPER_ACTIVE_HIGH 1
#define BOARD_CHOPPER_CURRENT_MA  60000
#define BOARD_BRAKE_OUTPUT        32
#define BOARD_BRAKE_ACTIVE_HIGH   1
