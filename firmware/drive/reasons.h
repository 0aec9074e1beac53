/* Reasons: why the drive stopped or would not go on. One table of number (permanent, append only), name, text
 * and remedy; faults and refusals share it. */
#ifndef DRIVE_REASONS_H
#define DRIVE_REASONS_H

#include <stdint.h>

/* R(number, NAME, "name", "what happened", "what to do") */
#define DRIVE_REASONS(R)                                                                                     \
    R(0, NONE, "none", "nothing is wrong", "nothing to do")                                                  \
    R(1, NOT_READY, "not_ready", "the current offsets are still being measured",                             \
      "wait until the state is ready")                                                                       \
    R(2, FAULT_LATCHED, "fault_latched", "a fault is latched",                                               \
      "read fault_reason, mend its cause, then reset")                                                       \
    R(3, FAULT_PRESENT, "fault_present",                                                                     \
      "the cause of the fault is still there, or ended less than 20 ms ago",                                 \
      "mend the cause, wait 20 ms, then reset again")                                                        \
    R(4, UNKNOWN_ID, "unknown_id", "no row of the tables has this id", "list the tables")                    \
    R(5, OUT_OF_RANGE, "out_of_range", "the value is outside the range of its row",                          \
      "choose a value in the range")                                                                         \
    R(6, CROSS_RULE, "cross_rule", "the value does not go with the other parameters",                        \
      "change it, or the parameter that the rule names, in one set")                                         \
    R(7, BRIDGE_ON, "bridge_on", "this parameter may change only while the bridge is off",                   \
      "switch off first")                                                                                    \
    R(8, READ_ONLY, "read_only", "this value is shown, not set",                                             \
      "set the parameter or request that makes it")                                                          \
    R(9, BOARD_FAILED, "board_failed", "the board did not come up (clock or configuration)",                 \
      "check crystal and supply, then reset the controller")                                                 \
    R(20, MODULE_FAULT, "module_fault",                                                                      \
      "the power module pulled its fault line: short circuit, over-temperature or "                          \
      "low gate supply",                                                                                     \
      "look for a short circuit; check the 15 V supplies and the heat sink")                                 \
    R(21, OVERCURRENT, "overcurrent", "a phase current exceeded overcurrent_trip",                           \
      "check wiring, encoder direction and offset, current_bandwidth, motor data")                           \
    R(22, DC_OVERVOLTAGE, "dc_overvoltage", "the DC link exceeded dc_overvoltage",                           \
      "brake more slowly or add a brake resistor")                                                           \
    R(23, DC_UNDERVOLTAGE, "dc_undervoltage", "the DC link is below dc_undervoltage",                        \
      "check supply and precharge")                                                                          \
    R(24, SINK_HOT, "sink_hot", "the heat sink is above sink_temperature_max",                               \
      "reduce load, improve cooling")                                                                        \
    R(25, MOTOR_HOT, "motor_hot", "the motor is above motor_temperature_max",                                \
      "reduce load, improve cooling")                                                                        \
    R(26, OVERSPEED, "overspeed", "the speed exceeded overspeed_trip", "check references, encoder and load") \
    R(27, CURRENT_OFFSET, "current_offset",                                                                  \
      "a current sensor reads more than current_offset_max at zero current",                                 \
      "check sensor supply and wiring")                                                                      \
    R(28, ENCODER_PHASE, "encoder_phase", "the encoder tracks changed both at once",                         \
      "check encoder cable and screen")                                                                      \
    R(29, LATE, "late", "the interrupt ran past its period several times in a row", "shorten the interrupt") \
    R(30, BAD_SAMPLE, "bad_sample", "a sample was not a number or a current sensor was at its rail",         \
      "check sensor supply, wiring and range")                                                               \
    R(31, GATES_REFUSED, "gates_refused", "the gates did not come on: the trip could not be cleared",        \
      "check the fault line of the power module")                                                            \
    R(32, ESTIMATE_AMPLITUDE, "estimate_amplitude",                                                          \
      "the estimated back-EMF did not fit the estimated speed: the rotor is lost",                           \
      "check motor_flux_linkage, dead time and load; below 50 r/min there is too little EMF")                \
    R(33, ESTIMATE_DETECTOR, "estimate_detector",                                                            \
      "the tracking error of the estimator stayed too large: the rotor is lost",                             \
      "raise pll_bandwidth or use the torque feed-forward; check dead time and motor data")                  \
    R(34, ESTIMATE_CURRENT, "estimate_current",                                                              \
      "the observed current stayed far from the measured one: the observer is lost",                         \
      "raise observer_gain; check motor_resistance, motor_inductance_q and wiring")                          \
    R(35, ESTIMATE_SPEED, "estimate_speed",                                                                  \
      "the speed stayed below estimate_speed_min or above overspeed_trip: nothing to see or to follow",      \
      "keep sensorless operation faster, or run with the encoder")                                           \
    R(36, TOO_SLOW, "too_slow", "the rotor turns slower than start_speed: there is no back-EMF to start on", \
      "bring it to start_speed first, or run with the encoder")

typedef enum {
#define REASON_VALUE(number, NAME, name, text, remedy) REASON_##NAME = number,
    DRIVE_REASONS(REASON_VALUE)
#undef REASON_VALUE
} reason_t;

typedef struct {
    int32_t number;
    const char *name;
    const char *text;
    const char *remedy;
} reason_row_t;

extern const reason_row_t reasons[];
extern const uint32_t reasons_count;

/* The row of a number; NULL if the table has none. */
const reason_row_t *reason_by_number(int32_t number);

#endif
