/* Board: a generic stage for the rectified 400 V mains, 540 V and 30 A, no product: TMS320F28335 (30 MHz
 * crystal), an intelligent power module of 1200 V and 50 A behind optocouplers, a Hall sensor in each motor
 * lead. docs/board.md explains each line and its check on the bench. */
#define BOARD_NAME "igbt_540v_30a" /* 1 */

#define BOARD_CRYSTAL_HZ 30000000 /* 2 */
#define BOARD_SYSCLK_HZ  150000000

#define BOARD_CARRIER_HZ 8000 /* 3: switching losses of 1200 V */

#define BOARD_LEG_A 1 /* 4: EPWM1A, 1B = GPIO0, 1 */
#define BOARD_LEG_B 2 /* GPIO2, 3 */
#define BOARD_LEG_C 3 /* GPIO4, 5 */

#define BOARD_GATE_ACTIVE_HIGH 0 /* 5: the diodes of the optocouplers are connected to 3.3 V */

#define BOARD_TRIP_ZONE    1 /* 6: TZ1 = GPIO12, the module's fault output, open collector */
#define BOARD_TRIP_PULL_UP 1

#define BOARD_DEAD_BAND_MIN_NS 2500 /* 7 */
#define BOARD_DEAD_TIME_NS     3000
#define BOARD_MINIMUM_PULSE_NS 2000

#define BOARD_CURRENT_A_INPUT BOARD_ADC_A(0) /* 8 */
#define BOARD_CURRENT_B_INPUT BOARD_ADC_B(0)
#define BOARD_CURRENT_C_INPUT BOARD_ADC_A(2)

#define BOARD_CURRENT_ZERO_MV 1500 /* 9: 25 mV/A, +-60 A are 0 to 3 V */
#define BOARD_CURRENT_STEP_MA 60000
#define BOARD_CURRENT_STEP_MV 1500

#define BOARD_SAMPLES_AT       BOARD_UPPER_ZERO_VECTOR /* 10: sensors in the leads */
#define BOARD_SHUNT_SETTLED_NS 0

#define BOARD_DC_INPUT   BOARD_ADC_A(1) /* 11: 900 V are 3 V, by an isolating amplifier */
#define BOARD_DC_STEP_MV 900000
#define BOARD_DC_PIN_MV  3000

#define BOARD_SINK_INPUT  BOARD_ADC_B(1) /* 12: -50 to 150 degC are 0 to 3 V, both */
#define BOARD_SINK_AT_0V  (-50)
#define BOARD_SINK_AT_3V  150
#define BOARD_MOTOR_INPUT BOARD_ADC_B(2)
#define BOARD_MOTOR_AT_0V (-50)
#define BOARD_MOTOR_AT_3V 150

#define BOARD_ENCODER BOARD_EQEP1_GPIO20 /* 13 */

#define BOARD_LED_RUN        31 /* 14 */
#define BOARD_LED_FAULT      34
#define BOARD_LED_ACTIVE_LOW 1

#define BOARD_TURN_ON_DELAY_NS      900 /* 15: optocoupler and module */
#define BOARD_TURN_OFF_DELAY_NS     1300
#define BOARD_IGBT_DROP_MV          900
#define BOARD_IGBT_SLOPE_UOHM       22000
#define BOARD_DIODE_DROP_MV         1100
#define BOARD_DIODE_SLOPE_UOHM      26000
#define BOARD_SHORT_CIRCUIT_TRIP_MA 100000

#define BOARD_CURRENT_LIMIT_MA    30000 /* 16 */
#define BOARD_OVERCURRENT_TRIP_MA 45000
#define BOARD_DC_NOMINAL_MV       540000
#define BOARD_UNDERVOLTAGE_MV     350000
#define BOARD_OVERVOLTAGE_MV      720000
#define BOARD_OVERVOLTAGE_MAX_MV  800000 /* two thirds of the switches' rated voltage */

#define BOARD_MODULE_CONTINUOUS_MA                                                                           \
    30000 /* 17: six tenths of the module's rated current, for a leg at standstill */
#define BOARD_MODULE_TIME_MS 200
#define BOARD_GATE_CHARGE_US 0 /* four isolated supplies */

#define BOARD_SERIAL_BAUD 937500 /* 18: LSPCLK / 40, exactly */
#define BOARD_SERIAL_PINS BOARD_SCIA_GPIO28

/* 19: a contact to 3.3 V, with a resistor to ground: an open wire is off */
#define BOARD_ENABLE_INPUT       27
#define BOARD_ENABLE_ACTIVE_HIGH 1
#define BOARD_ENABLE_DEBOUNCE_US 5000

#define BOARD_STORE BOARD_STORE_FLASH /* 20 */

/* 21: a seventh switch beside the module, and a relay for the brake. Resistors of 2.2 kohm to ground keep the
 * resistor off and the brake set during a reset. */
#define BOARD_CHOPPER_OUTPUT      30
#define BOARD_CHOPPER_ACTIVE_HIGH 1
#define BOARD_CHOPPER_CURRENT_MA  40000
#define BOARD_BRAKE_OUTPUT        32
#define BOARD_BRAKE_ACTIVE_HIGH   1
