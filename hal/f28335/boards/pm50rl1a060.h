/* Board: TMS320F28335 (30 MHz crystal) and a Mitsubishi PM50RL1A060, IPM of 600 V, 50 A; 311 V link, two
 * current sensors of +-20 A in the motor leads. docs/board.md explains each line and its check on the bench.
 */
#define BOARD_NAME "pm50rl1a060" /* 1 */

#define BOARD_CRYSTAL_HZ 30000000 /* 2 */
#define BOARD_SYSCLK_HZ  150000000

#define BOARD_CARRIER_HZ 10000 /* 3 */

#define BOARD_LEG_A 1 /* 4: EPWM1A, 1B = GPIO0, 1 */
#define BOARD_LEG_B 2 /* GPIO2, 3 */
#define BOARD_LEG_C 3 /* GPIO4, 5 */

/* 5: BOARD_GATE_ACTIVE_HIGH is omitted: the user's optocoupler stage between chip and module may invert (the
 * inputs of the module are active low). The build requires the option -DLAGLESS_GATES=. */

#define BOARD_TRIP_ZONE    1 /* 6: TZ1 = GPIO12, the module's fault output F_O, open collector */
#define BOARD_TRIP_PULL_UP 1

#define BOARD_DEAD_BAND_MIN_NS 2000 /* 7: t_dead of the module */
#define BOARD_DEAD_TIME_NS     2500
#define BOARD_MINIMUM_PULSE_NS 1500

#define BOARD_CURRENT_A_INPUT BOARD_ADC_A(0) /* 8 */
#define BOARD_CURRENT_B_INPUT BOARD_ADC_B(0)
#define BOARD_CURRENT_C_INPUT BOARD_NONE

#define BOARD_CURRENT_ZERO_MV 1500 /* 9: +-20 A are 0 to 3 V */
#define BOARD_CURRENT_STEP_MA 20000
#define BOARD_CURRENT_STEP_MV 1500

#define BOARD_SAMPLES_AT                                                                                     \
    BOARD_UPPER_ZERO_VECTOR /* 10: sensors in the leads measure the current at any time */
#define BOARD_SHUNT_SETTLED_NS 0

#define BOARD_DC_INPUT   BOARD_ADC_A(1) /* 11: 500 V are 3 V */
#define BOARD_DC_STEP_MV 500000
#define BOARD_DC_PIN_MV  3000

#define BOARD_SINK_INPUT  BOARD_ADC_B(1) /* 12: -50 to 150 degC are 0 to 3 V, both */
#define BOARD_SINK_AT_0V  (-50)
#define BOARD_SINK_AT_3V  150
#define BOARD_MOTOR_INPUT BOARD_ADC_A(2)
#define BOARD_MOTOR_AT_0V (-50)
#define BOARD_MOTOR_AT_3V 150

#define BOARD_ENCODER BOARD_EQEP1_GPIO20 /* 13 */

#define BOARD_LED_RUN        BOARD_NONE /* 14 */
#define BOARD_LED_FAULT      BOARD_NONE
#define BOARD_LED_ACTIVE_LOW 0

#define BOARD_TURN_ON_DELAY_NS      700 /* 15: optocoupler and module */
#define BOARD_TURN_OFF_DELAY_NS     900
#define BOARD_IGBT_DROP_MV          800
#define BOARD_IGBT_SLOPE_UOHM       18000
#define BOARD_DIODE_DROP_MV         950
#define BOARD_DIODE_SLOPE_UOHM      25000
#define BOARD_SHORT_CIRCUIT_TRIP_MA 100000

#define BOARD_CURRENT_LIMIT_MA    10000 /* 16 */
#define BOARD_OVERCURRENT_TRIP_MA 15000
#define BOARD_DC_NOMINAL_MV       311000
#define BOARD_UNDERVOLTAGE_MV     200000
#define BOARD_OVERVOLTAGE_MV      400000
#define BOARD_OVERVOLTAGE_MAX_MV  450000 /* limit of the stage */

#define BOARD_MODULE_CONTINUOUS_MA 25000 /* 17: half of the module's rated current: leg at standstill */
#define BOARD_MODULE_TIME_MS       200
#define BOARD_GATE_CHARGE_US       0 /* four isolated supplies */

#define BOARD_SERIAL_BAUD 937500 /* 18: LSPCLK / 40, exactly */
#define BOARD_SERIAL_PINS BOARD_SCIA_GPIO28

/* 19: a manual contact to 3.3 V, with a resistor to ground: an open wire is off */
#define BOARD_ENABLE_INPUT       27
#define BOARD_ENABLE_ACTIVE_HIGH 1
#define BOARD_ENABLE_DEBOUNCE_US 5000

#define BOARD_STORE BOARD_STORE_FLASH /* 20 */

/* 21: the seventh switch of the module, and a relay for the brake. Resistors of 2.2 kohm to ground keep the
 * resistor off and the brake set during a reset. */
#define BOARD_CHOPPER_OUTPUT      30
#define BOARD_CHOPPER_ACTIVE_HIGH 1
#define BOARD_CHOPPER_CURRENT_MA  25000
#define BOARD_BRAKE_OUTPUT        31
#define BOARD_BRAKE_ACTIVE_HIGH   1
