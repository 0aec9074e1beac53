/* The fault table: every protection of the drive is one row here and nothing else. Enumeration, evaluator
 * (guard.c), reasons, `lagless explain`, docs/reference.md and the test of every row are made from it.
 *
 * F(number, NAME, "name", quantity, comparison, "limit row", margin, rate, debounce, when, reaction,
 *   "what happened", "what to do")
 *
 *   number      permanent, append only: shared with the refusals of reasons.h
 *   quantity    of guard/guard_quantities.h
 *   comparison  ABOVE, BELOW: of the limit; HOLDS: the quantity is a condition, there is no limit
 *   limit row   parameter that is the limit, "" with HOLDS; margin is added to it, in its unit
 *   rate        EACH: judged in each period by the fast task, which opens the bridge by itself; SLOW: once a
 *               window by the medium task
 *   debounce    [periods] for which it must hold without a break; for a SLOW row up to two windows more
 *   when        ALWAYS; RUNNING: only while the gates shall be on; ENCODER: the same, and control uses the
 *               encoder; TRACKING: like RUNNING, and control uses an estimate that may be judged;
 *               SUPPLIED: like RUNNING, and no ride-through of a supply loss is active
 *   reaction    OPEN: bridge open, fault latched; STOP: the motor is braked to standstill, then the bridge
 *               opens and the fault is latched; CATCH: the rotor is lost and caught again; WARN: shown in
 *               `warnings` while it holds
 *
 * The place of a row is its bit in `faults_later` and `warnings`: append only, too. If several faults occur
 * in one period, the first row is the reason. A current above its limit or a trip stops the drive at once;
 * slow quantities have a longer debounce time, so that one disturbed conversion does not stop a drive. */
#ifndef SETTINGS_FAULTS_H
#define SETTINGS_FAULTS_H

#include <stdint.h>

#include "medium/protect/thermal.h"
#include "settings/params.h"

/* Distance below its limit at which the heat sink is warm [K]. */
#define FAULTS_SINK_WARM THERMAL_KELVIN

/* Distance below its limit at which the motor is warm [K]. From there on both reduce the current limit. */
#define FAULTS_MOTOR_WARM THERMAL_KELVIN

/* Debounce of a lost lock [periods]: 5 ms from its sign to the catch, minus the window in which the sign is
 * detected, and minus the window until the setpoint with the order to catch acts. */
#define FAULTS_UNLOCKED (DRIVE_PERIODS(5e-3f) - 2u * DRIVE_WINDOW)

#define DRIVE_FAULTS(F)                                                                                      \
    F(20, MODULE_FAULT, "module_fault", tripped, HOLDS, "", 0.0f, EACH, 1u, RUNNING, OPEN,                   \
      "the power module activated its fault output: short circuit, over-temperature or low gate supply",     \
      "search for a short circuit; check the 15 V supplies and the heat sink")                               \
    F(21, OVERCURRENT, "overcurrent", phase_current, ABOVE, "overcurrent_trip", 0.0f, EACH, 1u, ALWAYS,      \
      OPEN, "a phase current exceeded overcurrent_trip",                                                     \
      "check wiring, encoder direction and offset, current_bandwidth, motor data")                           \
    F(30, BAD_SAMPLE, "bad_sample", bad_sample, HOLDS, "", 0.0f, EACH, 3u, ALWAYS, OPEN,                     \
      "a sample was not a number or a current sensor was at its limit",                                      \
      "check sensor supply, wiring and range")                                                               \
    F(22, DC_OVERVOLTAGE, "dc_overvoltage", u_dc, ABOVE, "dc_overvoltage", 0.0f, EACH, 2u, ALWAYS, OPEN,     \
      "the DC link exceeded dc_overvoltage", "brake more slowly or add a brake resistor")                    \
    F(26, OVERSPEED, "overspeed", speed, ABOVE, "overspeed_trip", 0.0f, EACH, DRIVE_PERIODS(1e-3f), RUNNING, \
      OPEN, "the speed exceeded overspeed_trip", "check references, encoder and load")                       \
    F(29, LATE, "late", late, HOLDS, "", 0.0f, EACH, 1u, RUNNING, OPEN,                                      \
      "the interrupt exceeded its period three times in succession, or often",                               \
      "shorten the interrupt and the sections that disable interrupts")                                      \
    F(23, DC_UNDERVOLTAGE, "dc_undervoltage", u_dc, BELOW, "dc_undervoltage", 0.0f, EACH,                    \
      DRIVE_PERIODS(1e-3f), SUPPLIED, OPEN, "the DC link is below dc_undervoltage",                          \
      "check supply and precharge")                                                                          \
    F(28, ENCODER_PHASE, "encoder_phase", encoder_error, HOLDS, "", 0.0f, EACH, 1u, ENCODER, OPEN,           \
      "both encoder tracks changed at once", "check encoder cable and screen")                               \
    F(24, SINK_HOT, "sink_hot", sink_temperature, ABOVE, "sink_temperature_max", 0.0f, SLOW,                 \
      DRIVE_PERIODS(0.1f), ALWAYS, STOP, "the heat sink is above sink_temperature_max",                      \
      "reduce load, improve cooling")                                                                        \
    F(25, MOTOR_HOT, "motor_hot", motor_temperature, ABOVE, "motor_temperature_max", 0.0f, SLOW,             \
      DRIVE_PERIODS(0.1f), ALWAYS, STOP, "the motor is above motor_temperature_max",                         \
      "reduce load, improve cooling")                                                                        \
    F(32, ESTIMATE_AMPLITUDE, "estimate_amplitude", estimate_amplitude, HOLDS, "", 0.0f, SLOW, 1u, TRACKING, \
      CATCH, "the estimated back-EMF did not fit the estimated speed: the rotor is lost",                    \
      "check motor_flux_linkage, dead time and load; near standstill the EMF is too small")                  \
    F(33, ESTIMATE_DETECTOR, "estimate_detector", estimate_detector, HOLDS, "", 0.0f, SLOW, 1u, TRACKING,    \
      CATCH, "the tracking error of the estimator stayed too large: the rotor is lost",                      \
      "raise pll_bandwidth or use the torque feed-forward; check dead time and motor data")                  \
    F(34, ESTIMATE_CURRENT, "estimate_current", estimate_current, HOLDS, "", 0.0f, SLOW, 1u, TRACKING,       \
      CATCH, "the observed current stayed far from the measured one: the observer is lost",                  \
      "raise observer_gain; check motor_resistance, motor_inductance_q and wiring")                          \
    F(35, ESTIMATE_SPEED, "estimate_speed", estimate_speed, HOLDS, "", 0.0f, SLOW, 1u, TRACKING, CATCH,      \
      "the speed stayed below estimate_speed_min or above overspeed_trip: the estimator cannot follow",      \
      "run faster without encoder, or use the encoder")                                                      \
    F(37, SINK_WARM, "sink_warm", sink_temperature, ABOVE, "sink_temperature_max", -FAULTS_SINK_WARM, SLOW,  \
      DRIVE_PERIODS(0.1f), ALWAYS, WARN, "the heat sink is within 10 K of sink_temperature_max",             \
      "reduce load or improve cooling before it stops the drive")                                            \
    F(38, UNLOCKED, "unlocked", unlocked, HOLDS, "", 0.0f, SLOW, FAULTS_UNLOCKED, TRACKING, CATCH,           \
      "the back-EMF did not have the estimated direction: the rotor is lost",                                \
      "check load and motor data; raise pll_bandwidth or use the torque feed-forward")                       \
    F(39, LOCK_LOST, "lock_lost", lock_lost, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,                       \
      "the rotor was lost three times within 2 s, or in start_tries consecutive runs of less than 0.5 s",    \
      "check for a blocked shaft, a load beyond current_limit, wrong current sensors or motor data")         \
    F(40, START_STALLED, "start_stalled", start_stalled, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,           \
      "the rotor did not follow the start in start_tries tries",                                             \
      "free the shaft; raise start_current, lower start_ramp; check motor_inertia and wiring")               \
    F(41, START_UNLOCKED, "start_unlocked", start_unlocked, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,        \
      "the rotor followed the start, but the estimate did not lock in start_tries tries",                    \
      "check motor data and dead time; raise handover_speed")                                                \
    F(42, ROTOR_TOO_FAST, "rotor_too_fast", rotor_too_fast, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,        \
      "the back-EMF of the rotor exceeds the DC link, and field_weakening cannot reduce it enough; or "      \
      "current flows with the gates off",                                                                    \
      "let the rotor slow down, or raise the DC link; if the rotor is at standstill, check the current "     \
      "sensors")                                                                                             \
    F(66, PROGRAM_CORRUPT, "program_corrupt", program_corrupt, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, OPEN,      \
      "the program in flash, or its copy in RAM, differs from that of the start",                            \
      "switch the controller off and on; flash it again; if this repeats, replace it")                       \
    F(67, PARAMS_CORRUPT, "params_corrupt", params_corrupt, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, OPEN,         \
      "the active parameters, or values computed from them, have changed without a command",                 \
      "set the parameters again; if this repeats, check the controller's supply for disturbances")           \
    F(68, STACK_LOW, "stack_low", stack_low, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, OPEN,                        \
      "the processor's stack is almost full: data behind it may be overwritten",                             \
      "give the linker a larger stack; check what was added to an interrupt")                                \
    F(69, BACKGROUND_STALLED, "background_stalled", background_stalled, HOLDS, "", 0.0f, SLOW, 1u, RUNNING,  \
      STOP, "the background did not run for background_time_max: the watchdog would reset the processor",    \
      "check for a task of the background that waits; shorten what was added to the interrupt")              \
    F(48, ENCODER_JUMP, "encoder_jump", encoder_jump, HOLDS, "", 0.0f, EACH, 1u, ENCODER, OPEN,              \
      "the encoder's angle jumped by more than a rotor can move in a period",                                \
      "check encoder cable, screen, supply and coupling")                                                    \
    F(49, ENCODER_DIRECTION, "encoder_direction", encoder_direction, HOLDS, "", 0.0f, SLOW, 1u, ENCODER,     \
      OPEN, "encoder and back-EMF turn in opposite directions",                                              \
      "swap two phases of the motor, or the encoder's tracks")                                               \
    F(50, ENCODER_MISMATCH, "encoder_mismatch", encoder_mismatch, HOLDS, "", 0.0f, SLOW, 1u, ENCODER, OPEN,  \
      "the back-EMF does not have the direction of the encoder's angle",                                     \
      "check encoder_lines, encoder_offset, motor_pole_pairs, coupling, encoder cable and current sensors")  \
    F(51, RUNAWAY, "runaway", runaway, HOLDS, "", 0.0f, SLOW, 1u, ENCODER, OPEN,                             \
      "the shaft gained speed against its torque: the torque has the wrong sign",                            \
      "check encoder_offset, encoder direction and the order of the phases; motor_inertia; the load")        \
    F(52, STALLED, "stalled", stalled, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,                             \
      "the rotor was at standstill at the current limit for stall_time",                                     \
      "free the shaft; check load, current_limit and encoder_offset")                                        \
    F(53, SPEED_ERROR, "speed_error", speed_error, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, STOP,                 \
      "the speed stayed far from its reference for speed_error_time at the current limit, or a load drove "  \
      "the shaft above its reference",                                                                       \
      "reduce load or reference; raise current_limit, or speed_error_time for a heavy shaft")                \
    F(54, ENCODER_LOST, "encoder_lost", encoder_lost, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, WARN,               \
      "the encoder failed during operation; the motor continues without it",                                 \
      "stop when convenient; check encoder_lines, encoder_offset, coupling and encoder cable")               \
    F(43, CURRENT_STUCK, "current_stuck", current_stuck, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,           \
      "a current sensor did not change although the voltage must have changed its current",                  \
      "check the sensor, its supply and its wiring to the converter")                                        \
    F(44, CURRENT_GAIN, "current_gain", current_gain, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,              \
      "the measured currents did not change as the voltage requires",                                        \
      "check range and gain of the current sensors, and motor_inductance_d and _q")                          \
    F(45, PHASE_LOSS, "phase_loss", phase_loss, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,                    \
      "no current flowed through a phase whose reference was not zero",                                      \
      "check the motor cable, its terminals and the switches of that leg")                                   \
    F(46, CURRENT_SUM, "current_sum", current_sum, HOLDS, "", 0.0f, SLOW, DRIVE_PERIODS(2.4e-3f), RUNNING,   \
      OPEN, "the sum of the three measured currents was not zero",                                           \
      "check the current sensors; check for a leakage to ground")                                            \
    F(56, MOTOR_OVERLOAD, "motor_overload", motor_overload, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, STOP,         \
      "the motor carried more than motor_current_continuous for too long",                                   \
      "reduce load or start_current; check motor_current_continuous and motor_time_constant")                \
    F(57, MODULE_OVERLOAD, "module_overload", module_overload, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, OPEN,      \
      "a leg of the module carried more than module_current_continuous for too long",                        \
      "reduce load, especially at standstill; check module_current_continuous and module_time_constant")     \
    F(58, DERATING, "derating", derating, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, WARN,                           \
      "the current is limited below current_limit: motor, module or heat sink is warm",                      \
      "reduce load or improve cooling")                                                                      \
    F(59, MOTOR_WARM, "motor_warm", motor_temperature, ABOVE, "motor_temperature_max", -FAULTS_MOTOR_WARM,   \
      SLOW, DRIVE_PERIODS(0.1f), ALWAYS, WARN, "the motor is within 10 K of motor_temperature_max",          \
      "reduce load or improve cooling before it stops the drive")                                            \
    F(60, DC_RIPPLE, "dc_ripple", dc_ripple, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, WARN,                       \
      "the DC link repeatedly changes by more than a tenth within 20 ms",                                    \
      "check for a lost supply phase and for a worn capacitor")                                              \
    F(61, DC_LIMITS, "dc_limits", dc_limits, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, WARN,                       \
      "DC link or supply limit the torque: braking near dc_overvoltage, driving near dc_undervoltage, "      \
      "or the current of supply_current_max or supply_current_regen_max is reached",                         \
      "brake more slowly or add a brake resistor; check the supply and its two limits")                      \
    F(71, MASTER_SILENT, "master_silent", master_silent, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, WARN,            \
      "the client on the serial link was silent for command_timeout: the motor was stopped",                 \
      "check cable and client, then set `enable` again; or change command_timeout")                          \
    F(83, LOOP_SLOW, "loop_slow", loop_slow, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, WARN,                        \
      "pll_bandwidth is too slow for motor_inertia and current_limit: a step of the load loses the rotor",   \
      "set pll_bandwidth and feedforward_cutoff to 0: they then follow the motor")                           \
    F(84, OSCILLATION, "oscillation", oscillation, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, WARN,                  \
      "the speed control made the shaft oscillate: its gain is reduced until the drive is switched on "      \
      "again",                                                                                               \
      "check for an elastic coupling; lower speed_kp and speed_ki, or pll_bandwidth and feedforward_cutoff") \
    F(85, MEDIUM_LATE, "medium_late", medium_late, HOLDS, "", 0.0f, EACH, 1u, RUNNING, OPEN,                 \
      "the medium task had no setpoint ready for two of three successive windows",                           \
      "shorten what was added to the interrupts; request fewer signals over the serial link")                \
    F(150, CHOPPER_OVERLOAD, "chopper_overload", chopper_overload, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS, OPEN,  \
      "the brake resistor carried more than chopper_power for too long: the chopper stays off until it "     \
      "has cooled",                                                                                          \
      "brake less often or more slowly; check chopper_resistance, chopper_power, chopper_time_constant")     \
    F(151, CHOPPER_NO_EFFECT, "chopper_no_effect", chopper_no_effect, HOLDS, "", 0.0f, SLOW, 1u, ALWAYS,     \
      OPEN,                                                                                                  \
      "the DC link did not fall while the chopper was on: no brake resistor, or a supply above "             \
      "chopper_voltage",                                                                                     \
      "check brake resistor, fuse and wiring; set chopper_voltage above the supply")                         \
    F(152, BRAKE_TORQUE, "brake_torque", brake_torque, HOLDS, "", 0.0f, SLOW, 1u, RUNNING, OPEN,             \
      "the motor did not have the torque of brake_preload within 0.5 s: the brake was not released",         \
      "check brake_preload against current_limit, and the DC link")

/* The bit of each row, and the number of rows. */
typedef enum {
#define FAULT_BIT(number, NAME, name, quantity, comparison, limit, margin, rate, debounce, when, reaction,   \
                  text, remedy)                                                                              \
    FAULT_##NAME,
    DRIVE_FAULTS(FAULT_BIT)
#undef FAULT_BIT
        FAULTS
} fault_bit_t;

typedef enum { FAULT_WARN, FAULT_CATCH, FAULT_STOP, FAULT_OPEN } fault_reaction_t;
typedef enum { FAULT_EACH, FAULT_SLOW } fault_rate_t;
typedef enum { FAULT_ALWAYS, FAULT_RUNNING, FAULT_ENCODER, FAULT_TRACKING, FAULT_SUPPLIED } fault_when_t;

/* A row as data. */
typedef struct {
    int32_t reason;         /* [-] reason_t */
    const char *name;       /* of reason and fault */
    const char *quantity;   /* of guard_quantities.h */
    const char *comparison; /* "ABOVE", "BELOW" or "HOLDS" */
    const char *limit;      /* row of the parameters; "": none */
    float margin;           /* [unit of the limit] */
    fault_rate_t rate;
    uint32_t debounce; /* [periods] */
    fault_when_t when;
    fault_reaction_t reaction;
} fault_row_t;

extern const fault_row_t fault_rows[FAULTS];

#endif
