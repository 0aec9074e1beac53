/* Board: TI's high-voltage motor kit TMDSHVMTRPFCKIT R1.1 with an F28335 controlCARD. Low-side shunts in all
 * three legs, no temperature sensor on the chip's inputs. Not used here, but wired: the phase voltages (B7,
 * B6, B4), the index of the encoder (GPIO23), the brake's and the PFC's switches. docs/board.md explains each
 * line and its check on the bench. */
#define BOARD_NAME "hvmtrpfckit" /* 1 */

/* 2: cards of later revisions have a crystal of 30 MHz. A crystal of 20 MHz gives 100 MHz, one of 25 MHz
 * gives 125 MHz: measure it (bench check 3), and enter it here. */
#define BOARD_CRYSTAL_HZ 30000000
#define BOARD_SYSCLK_HZ  150000000

#define BOARD_CARRIER_HZ 10000 /* 3 */

#define BOARD_LEG_A 1 /* 4: EPWM1A, 1B = GPIO0, 1 */
#define BOARD_LEG_B 2 /* GPIO2, 3 */
#define BOARD_LEG_C 3 /* GPIO4, 5 */

#define BOARD_GATE_ACTIVE_HIGH 1 /* 5 */

#define BOARD_TRIP_ZONE    1 /* 6: TZ1 = GPIO12, module fault and over-current in one line */
#define BOARD_TRIP_PULL_UP 1

#define BOARD_DEAD_BAND_MIN_NS 2000 /* 7 */
#define BOARD_DEAD_TIME_NS     2500
#define BOARD_MINIMUM_PULSE_NS 1500

#define BOARD_CURRENT_A_INPUT BOARD_ADC_A(1) /* 8 */
#define BOARD_CURRENT_B_INPUT BOARD_ADC_B(1)
#define BOARD_CURRENT_C_INPUT BOARD_ADC_A(3)

#define BOARD_CURRENT_ZERO_MV 1650 /* 9: +-10 A are 0 to 3.3 V, of which the ADC converts 3.0 V */
#define BOARD_CURRENT_STEP_MA 10000
#define BOARD_CURRENT_STEP_MV 1650

#define BOARD_SAMPLES_AT                                                                                     \
    BOARD_LOWER_ZERO_VECTOR /* 10: a shunt carries current while its lower switch is on */
#define BOARD_SHUNT_SETTLED_NS 2000

#define BOARD_DC_INPUT   BOARD_ADC_A(7) /* 11: 409 V are 3.3 V */
#define BOARD_DC_STEP_MV 409000
#define BOARD_DC_PIN_MV  3300

#define BOARD_SINK_INPUT  BOARD_NONE /* 12 */
#define BOARD_MOTOR_INPUT BOARD_NONE

#define BOARD_ENCODER BOARD_EQEP1_GPIO20 /* 13 */

#define BOARD_LED_RUN        31 /* 14: LD2 and LD3 of the card, lit by a low pin */
#define BOARD_LED_FAULT      34
#define BOARD_LED_ACTIVE_LOW 1

#define BOARD_TURN_ON_DELAY_NS      700 /* 15 */
#define BOARD_TURN_OFF_DELAY_NS     900
#define BOARD_IGBT_DROP_MV          800
#define BOARD_IGBT_SLOPE_UOHM       18000
#define BOARD_DIODE_DROP_MV         950
#define BOARD_DIODE_SLOPE_UOHM      25000
#define BOARD_SHORT_CIRCUIT_TRIP_MA 30000

#define BOARD_CURRENT_LIMIT_MA    6300 /* 16 */
#define BOARD_OVERCURRENT_TRIP_MA 7600
#define BOARD_DC_NOMINAL_MV       311000
#define BOARD_UNDERVOLTAGE_MV     200000
#define BOARD_OVERVOLTAGE_MV      345000
#define BOARD_OVERVOLTAGE_MAX_MV  360000 /* the end of the ADC's scale */

#define BOARD_MODULE_CONTINUOUS_MA 10000 /* 17: half of the module's rated current: leg at standstill */
#define BOARD_MODULE_TIME_MS       100
#define BOARD_GATE_CHARGE_US       300 /* upper gates from bootstrap capacitors */

#define BOARD_SERIAL_BAUD 937500 /* 18: LSPCLK / 40, exactly */
#define BOARD_SERIAL_PINS BOARD_SCIA_GPIO28

/* 19: the kit has no switch for it. Every client on the serial line may start the motor. */
#define BOARD_ENABLE_INPUT BOARD_NONE

#define BOARD_STORE BOARD_STORE_FLASH /* 20 */

#define BOARD_CHOPPER_OUTPUT BOARD_NONE /* 21 */
#define BOARD_BRAKE_OUTPUT   BOARD_NONE
