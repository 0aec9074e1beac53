/* Parameters of the drive: the only table, the struct made from it, and the judgement of a whole set.
 *
 * Staged and active: clients write single values into a staged set; params_check judges the whole set, ranges
 * first, then the rules between parameters; only then drive_prepare computes its tuning, which the drive
 * takes over. */
#ifndef SETTINGS_PARAMS_H
#define SETTINGS_PARAMS_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/refusal.h"
#include "contract/table.h"
#include "estimator/estimator.h"
#include "fast/control/current_control.h"
#include "fast/protect/link_limit.h"
#include "hal/board.h"
#include "medium/adapt/assumed.h"
#include "medium/manoeuvre/weakening.h"

/* Constants of the board: fixed by hardware, not parameters. The firmware below the app uses no
 * other properties of the board. */
#define DRIVE_PERIOD          BOARD_PERIOD                /* T_s [s] */
#define DRIVE_DUTY_COUNTS     ((float)BOARD_PERIOD_COUNT) /* [-] steps of a duty from 0 to 1 */
#define DRIVE_CURRENT_MIN     BOARD_CURRENT_MIN           /* [A] range of the current sensors, from ... */
#define DRIVE_CURRENT_MAX     BOARD_CURRENT_MAX           /* [A] ... to */
#define DRIVE_CURRENT_RANGE   BOARD_CURRENT_RANGE   /* [A] range of the current sensors in both directions */
#define DRIVE_CURRENT_SENSORS BOARD_CURRENT_SENSORS /* [-] 2: current c is minus the sum of the others; 3 */
#define DRIVE_SINK_SENSOR     (BOARD_SINK_INPUT != BOARD_NONE) /* without a sensor no temperature is judged */
#define DRIVE_HAS_BRAKE       (BOARD_BRAKE_OUTPUT != BOARD_NONE) /* without an output there is no brake */
#define DRIVE_MOTOR_SENSOR    (BOARD_MOTOR_INPUT != BOARD_NONE)  /* the same for the motor */

/* Largest current reference [A]: the range above it is needed for ripple and overshoot below the trip. */
#define DRIVE_CURRENT_LIMIT_MAX (0.8f * DRIVE_CURRENT_RANGE)

/* Largest threshold of the chopper [V]; 0: the board has no chopper output. Largest current of its switch
 * [A].
 */
#define DRIVE_CHOPPER_MAX     (BOARD_CHOPPER_OUTPUT == BOARD_NONE ? 0.0f : BOARD_VOLTS(BOARD_OVERVOLTAGE_MAX_MV))
#define DRIVE_CHOPPER_CURRENT BOARD_AMPERES(BOARD_CHOPPER_CURRENT_MA)

/* Number of periods in this time [s]: at least one. */
#define DRIVE_PERIODS(seconds) ((uint32_t)((seconds) / DRIVE_PERIOD + 0.5f))

/* The medium task runs once per window of this many periods: at 1.25 kHz, or at the
 * nearest rate of whole periods. */
#define DRIVE_WINDOW        DRIVE_PERIODS(0.8e-3f)
#define DRIVE_WINDOW_PERIOD ((float)DRIVE_WINDOW * DRIVE_PERIOD) /* [s] */

/* Number of windows in this time [s]. */
#define DRIVE_WINDOWS(seconds) ((uint32_t)((seconds) / DRIVE_WINDOW_PERIOD + 0.5f))

/* Least time for which the lower switches are on before an upper one may be on [periods]. */
#define DRIVE_CHARGE_PERIODS ((uint32_t)((float)BOARD_GATE_CHARGE_US / (1e6f * DRIVE_PERIOD) + 0.999f))
/* Largest dead band of the register [s]. */
#define DRIVE_DEAD_TIME_MAX ((float)BOARD_DEAD_BAND_MAX / (float)BOARD_SYSCLK_HZ)

typedef enum { POSITION_ENCODER, POSITION_SENSORLESS } position_source_t;
typedef enum { SPEED_SMOOTH, SPEED_WHOLE } speed_feedback_t;
typedef enum { LOCK_NOT_JUDGED, LOCK_JUDGED } lock_judged_t;
typedef enum { CURRENT_NOT_JUDGED, CURRENT_JUDGED } current_judged_t;
typedef enum { INERTIA_OFF, INERTIA_ON } inertia_adaptation_t;
typedef enum { LINE_XCP, LINE_MODBUS } line_protocol_t;
typedef enum { MTPA_OFF, MTPA_ON } mtpa_t;
typedef enum { SALIENT_ADAPTATION_OFF, SALIENT_ADAPTATION_ON } salient_adaptation_t;
typedef enum { WEAKENING_OFF, WEAKENING_ON } field_weakening_t;
typedef enum { OVER_MODULATION_OFF, OVER_MODULATION_ON } over_modulation_t;
typedef enum { BRAKE_NONE, BRAKE_HOLDING } holding_brake_choice_t;
typedef enum { FAULT_RECORD_SIGNALS, FAULT_RECORD_REPLAY } fault_record_t;
typedef enum { ENCODER_FAULT_OPEN, ENCODER_FAULT_SENSORLESS, ENCODER_FAULT_IGNORED } encoder_fault_reaction_t;

/* The default motor at the default overspeed_trip has 279 V between two phases: on a board with a smaller
 * permitted link voltage its field is not weakened. */
#define DRIVE_WEAKENING (BOARD_OVERVOLTAGE_MAX_MV >= 280000 ? WEAKENING_ON : WEAKENING_OFF)

/* F(id, name, unit, default, min, max, access, text): float
 * I(id, name, unit, default, min, max, access, text): int32_t
 * E(id, name, choices, default, access, text): int32_t with named values
 * Defaults: the paper's Table I motor and rig; power stage and limits of the board. */
#define DRIVE_PARAMS(F, I, E)                                                                                \
    I(1, motor_pole_pairs, "-", 4, 1, 64, TABLE_OFF, "pole pairs p")                                         \
    F(2, motor_resistance, "ohm", 0.95f, 1e-3f, 100.0f, TABLE_LIVE, "stator resistance R of a phase")        \
    F(3, motor_inductance_d, "H", 12.5e-3f, 1e-5f, 1.0f, TABLE_LIVE, "direct-axis inductance L_d")           \
    F(4, motor_inductance_q, "H", 12.5e-3f, 1e-5f, 1.0f, TABLE_LIVE, "quadrature-axis inductance L_q")       \
    F(5, motor_flux_linkage, "Wb", 0.183f, 1e-4f, 10.0f, TABLE_LIVE,                                         \
      "flux linkage psi_f, amplitude per phase")                                                             \
    F(6, current_limit, "A", BOARD_AMPERES(BOARD_CURRENT_LIMIT_MA), 0.1f, DRIVE_CURRENT_LIMIT_MAX,           \
      TABLE_LIVE, "limit of the magnitude of i_q from the speed control")                                    \
    F(7, current_bandwidth, "rad/s", 1000.0f, 10.0f, 3000.0f, TABLE_LIVE,                                    \
      "closed-loop bandwidth of the current control")                                                        \
    F(8, speed_kp, "A s/rad", 0.0f, 0.0f, 100.0f, TABLE_LIVE,                                                \
      "proportional gain of the speed control, per mechanical rad/s; 0: by rule from motor_inertia and "     \
      "pll_bandwidth/14")                                                                                    \
    F(9, speed_ki, "A/rad", 0.0f, 0.0f, 10000.0f, TABLE_LIVE,                                                \
      "integral gain of the speed control, per mechanical rad; 0: by rule, damping 0.87")                    \
    F(10, overspeed_trip, "rad/s", 220.0f, 1.0f, 10000.0f, TABLE_LIVE,                                       \
      "mechanical speed that stops the drive")                                                               \
    F(11, overcurrent_trip, "A", BOARD_AMPERES(BOARD_OVERCURRENT_TRIP_MA), 0.2f,                             \
      0.95f * DRIVE_CURRENT_RANGE, TABLE_LIVE, "phase current that stops the drive")                         \
    F(12, dc_overvoltage, "V", BOARD_VOLTS(BOARD_OVERVOLTAGE_MV), 20.0f,                                     \
      BOARD_VOLTS(BOARD_OVERVOLTAGE_MAX_MV), TABLE_LIVE, "DC-link voltage that stops the drive")             \
    F(13, dc_undervoltage, "V", BOARD_VOLTS(BOARD_UNDERVOLTAGE_MV), 10.0f,                                   \
      BOARD_VOLTS(BOARD_OVERVOLTAGE_MAX_MV - 10000), TABLE_LIVE,                                             \
      "DC-link voltage below which the drive does not run")                                                  \
    F(14, sink_temperature_max, "degC", (float)BOARD_SINK_HOT, 0.0f, (float)BOARD_SINK_MAX, TABLE_LIVE,      \
      "heat-sink temperature that stops the drive")                                                          \
    F(15, motor_temperature_max, "degC", (float)BOARD_MOTOR_HOT, 0.0f, (float)BOARD_MOTOR_MAX, TABLE_LIVE,   \
      "motor temperature that stops the drive")                                                              \
    F(16, dead_time, "s", BOARD_SECONDS(BOARD_DEAD_TIME_NS), BOARD_SECONDS(BOARD_DEAD_BAND_MIN_NS),          \
      DRIVE_DEAD_TIME_MAX, TABLE_OFF, "dead band of the legs, set in the ePWM")                              \
    F(17, minimum_pulse, "s", BOARD_SECONDS(BOARD_MINIMUM_PULSE_NS), 0.0f, 10.0e-6f, TABLE_OFF,              \
      "shortest pulse that the power module may get")                                                        \
    F(18, turn_on_delay, "s", BOARD_SECONDS(BOARD_TURN_ON_DELAY_NS), 0.0f, 5.0e-6f, TABLE_LIVE,              \
      "command edge to current on, for the compensation")                                                    \
    F(19, turn_off_delay, "s", BOARD_SECONDS(BOARD_TURN_OFF_DELAY_NS), 0.0f, 5.0e-6f, TABLE_LIVE,            \
      "command edge to current off, for the compensation")                                                   \
    F(20, device_drop, "V", ((float)BOARD_IGBT_DROP_MV + (float)BOARD_DIODE_DROP_MV) / 2e3f, 0.0f, 5.0f,     \
      TABLE_LIVE, "mean forward drop of IGBT and diode at small current")                                    \
    F(21, current_zone, "A", 0.05f, 1e-3f, 2.0f, TABLE_LIVE,                                                 \
      "current below which the dead-time error fades")                                                       \
    F(22, compensation_gain, "-", 1.0f, 0.0f, 1.2f, TABLE_LIVE,                                              \
      "share of the modelled dead-time error that is compensated")                                           \
    I(23, encoder_lines, "-", 2500, 16, 16384, TABLE_OFF, "encoder lines per turn; four counts each")        \
    F(24, encoder_offset, "rad", 0.0f, -3.1415927f, 3.1415927f, TABLE_OFF,                                   \
      "electrical angle of the encoder at count zero")                                                       \
    F(25, encoder_bandwidth, "rad/s", 1500.0f, 50.0f, 3000.0f, TABLE_LIVE,                                   \
      "natural frequency of the encoder's speed tracking")                                                   \
    I(26, calibration_periods, "-", 512, 16, 16384, TABLE_OFF, "samples averaged for the current offsets")   \
    F(27, current_offset_max, "A", 0.05f * DRIVE_CURRENT_RANGE, 0.01f, 0.25f * DRIVE_CURRENT_RANGE,          \
      TABLE_LIVE, "largest offset of a current sensor that is accepted")                                     \
    E(28, position_source, "encoder|sensorless", POSITION_SENSORLESS, TABLE_LIVE,                            \
      "source of the control's angle; the estimator runs in either case")                                    \
    F(29, start_speed, "rad/s", 0.0f, 0.0f, 10000.0f, TABLE_LIVE,                                            \
      "mechanical speed above which the drive catches a turning rotor; a slower one is aligned; 0: half of " \
      "handover_speed, at least 10 rad/s electrical, at most handover_speed")                                \
    F(30, observer_gain, "V", 0.0f, 0.0f, 1e4f, TABLE_LIVE,                                                  \
      "k_s of the observer; 0: 1.25 times the largest EMF at overspeed_trip")                                \
    F(31, observer_slope, "1/A", 0.0f, 0.0f, 1e3f, TABLE_LIVE,                                               \
      "a_f of the sigmoid tanh(a_f x/2); 0: 1.6 motor_inductance_q/(k_s T_s)")                               \
    F(32, observer_emf_cutoff, "rad/s", 2500.0f, 0.0f, 1e5f, TABLE_LIVE,                                     \
      "omega_s of the back-EMF filter; 0: no filter")                                                        \
    E(33, observer_switching, "sign|sigmoid|sigmoid_vector", SMO_SIGMOID_VECTOR, TABLE_OFF,                  \
      "switching function of the observer")                                                                  \
    E(34, lag_compensation, "none|printed|corrected|exact", LAG_EXACT, TABLE_LIVE,                           \
      "phase self-compensation: paper eq. (14) as printed, as corrected, or the lag of the sampled "         \
      "observer")                                                                                            \
    F(35, pll_bandwidth, "rad/s", 0.0f, 0.0f, 5000.0f, TABLE_LIVE,                                           \
      "-3 dB bandwidth of the closed tracking loop; 0, together with feedforward_cutoff = 0: by rule, four " \
      "times the cutoff that the rule computes")                                                             \
    F(36, pll_damping, "-", 1.0f, 0.5f, 5.0f, TABLE_LIVE, "damping of the tracking loop")                    \
    F(37, feedforward_cutoff, "rad/s", 0.0f, 0.0f, 5000.0f, TABLE_LIVE,                                      \
      "omega_c of the speed feed-forward; 0: conventional PLL, or with pll_bandwidth 0 by rule from "        \
      "motor_inertia and current_limit")                                                                     \
    F(38, flux_adaptation, "rad/s", 0.0f, 0.0f, 20.0f, TABLE_LIVE,                                           \
      "rate at which the feed-forward's psi_f follows the EMF; 0: off")                                      \
    F(39, torque_feedforward, "-", 1.0f, 0.0f, 2.0f, TABLE_LIVE,                                             \
      "share of the torque's acceleration fed forward to the PLL; 0: as in the paper")                       \
    F(40, motor_inertia, "kg m^2", 0.0636f, 1e-7f, 1e3f, TABLE_LIVE,                                         \
      "inertia of everything that turns, for the torque feed-forward")                                       \
    F(41, estimate_amplitude_min, "-", 0.5f, 0.0f, 1.0f, TABLE_LIVE,                                         \
      "least EMF over psi_f omega_e of a valid estimate; 0: not judged")                                     \
    F(42, estimate_amplitude_max, "-", 1.5f, 1.0f, 100.0f, TABLE_LIVE,                                       \
      "largest EMF over psi_f omega_e of a valid estimate; 1: not judged")                                   \
    F(43, estimate_detector_max, "-", 0.6f, 0.0f, 1.0f, TABLE_LIVE,                                          \
      "largest sine of the tracking error of a valid estimate; 0: not judged")                               \
    F(44, estimate_current_max, "A", 0.0f, 0.0f, 100.0f, TABLE_LIVE,                                         \
      "largest current error of a valid estimate; 0: 4/a_f of the observer; 100: in effect not judged")      \
    F(45, estimate_speed_min, "rad/s", 3.0f, 0.0f, 10000.0f, TABLE_LIVE,                                     \
      "least mechanical speed of a valid estimate; 0: not judged")                                           \
    F(46, estimate_time, "s", 0.1f, 0.0f, 10.0f, TABLE_LIVE,                                                 \
      "time for which a criterion must fail before the estimate counts as lost; time for which it is met "   \
      "is subtracted")                                                                                       \
    F(47, doubtful_current, "A", 0.1f, 0.0f, 2.0f, TABLE_LIVE,                                               \
      "phase current below which a leg's dead-time loss is uncertain: zone and sensor error; 0: none")       \
    F(48, offset_trim, "A/V", 0.05f, 0.0f, 0.1f, TABLE_LIVE,                                                 \
      "share of the mean EMF by which the current offsets are trimmed while turning; 0: off")                \
    F(49, device_resistance, "ohm", ((float)BOARD_IGBT_SLOPE_UOHM + (float)BOARD_DIODE_SLOPE_UOHM) / 2e6f,   \
      0.0f, 1.0f, TABLE_LIVE,                                                                                \
      "slope of the on-state drops, mean of IGBT and diode; adds to R in the control")                       \
    F(50, start_current, "A", 0.0f, 0.0f, DRIVE_CURRENT_LIMIT_MAX, TABLE_LIVE,                               \
      "length of the current vector of a start; 0: current_limit")                                           \
    F(51, start_ramp, "rad/s^2", 0.0f, 0.0f, 1e6f, TABLE_LIVE,                                               \
      "mechanical acceleration of the start; 0: 15 % of the acceleration that start_current allows, at "     \
      "least 0.3 s to handover_speed")                                                                       \
    F(52, handover_speed, "rad/s", 0.0f, 0.0f, 10000.0f, TABLE_LIVE,                                         \
      "mechanical speed above which the control uses the estimated angle; 0: by rule, where the EMF "        \
      "exceeds the voltages of dead time and R I, and the noise of the currents")                            \
    F(53, fallback_speed, "rad/s", 0.0f, 0.0f, 10000.0f, TABLE_LIVE,                                         \
      "mechanical speed below which the control uses a forced frame; 0: 0.4 of handover_speed")              \
    I(54, start_tries, "-", 3, 1, 100, TABLE_LIVE,                                                           \
      "number of starts that may fail before the drive stops; after a failed one the next begins by itself") \
    F(55, speed_ramp, "rad/s^2", 0.0f, 0.0f, 1e6f, TABLE_LIVE,                                               \
      "mechanical acceleration of the speed reference; 0: no ramp, only the current limit")                  \
    F(56, speed_setpoint_weight, "-", 0.0f, 0.0f, 1.0f, TABLE_LIVE,                                          \
      "share of the reference in the proportional part; 0: no overshoot, 1: the paper's PI")                 \
    F(57, quick_stop_ramp, "rad/s^2", 0.0f, 0.0f, 1e6f, TABLE_LIVE,                                          \
      "mechanical deceleration of a quick stop; 0: no ramp, only the current limit")                         \
    F(58, start_damping, "A/V", 0.0f, 0.0f, 1000.0f, TABLE_LIVE,                                             \
      "current across the forced frame per volt of oscillating EMF; 0: by rule from inertia, R and dead "    \
      "time")                                                                                                \
    F(59, start_align_time, "s", 0.0f, 0.0f, 10.0f, TABLE_LIVE,                                              \
      "duration of the turn of an alignment; 0: 16 divided by the rotor's natural frequency in the forced "  \
      "frame")                                                                                               \
    F(60, low_speed_current, "A", 0.2f * BOARD_AMPERES(BOARD_CURRENT_LIMIT_MA), 0.0f,                        \
      DRIVE_CURRENT_LIMIT_MAX, TABLE_LIVE,                                                                   \
      "least i_d + |i_q| at low speed without encoder; it avoids currents near zero, where the dead-time "   \
      "loss is uncertain; 0: off")                                                                           \
    F(61, inductance_adaptation, "1/s", 3.0f, 0.0f, 20.0f, TABLE_LIVE,                                       \
      "initial rate at which L_d, L_q and R are learnt by a small alternating i_d; it decreases to a "       \
      "tenth; 0, or motor_inductance_q above 1.1 motor_inductance_d without salient_adaptation: off")        \
    E(166, salient_adaptation, "off|on", SALIENT_ADAPTATION_OFF, TABLE_LIVE,                                 \
      "on: with motor_inductance_q of 1.5 motor_inductance_d or more, L_q is learnt by a small alternating " \
      "current that keeps the torque, at the rate inductance_adaptation")                                    \
    F(62, dead_time_adaptation, "1/s", 6.0f, 0.0f, 20.0f, TABLE_LIVE,                                        \
      "initial rate at which the legs' dead time is learnt from the EMF; it decreases to a tenth; 0: off")   \
    E(63, inertia_adaptation, "off|on", INERTIA_ON, TABLE_LIVE,                                              \
      "on: without encoder the drive learns J from steps of the speed reference; the torque feed-forward "   \
      "then excludes the load's current")                                                                    \
    E(64, speed_feedback, "smooth|whole", SPEED_SMOOTH, TABLE_LIVE,                                          \
      "speed for the speed control; smooth: the estimate without the loop's proportional part; whole: with " \
      "it, as in the paper")                                                                                 \
    E(65, lock_judged, "off|on", LOCK_JUDGED, TABLE_LIVE,                                                    \
      "on: the drive reports a lost rotor at once (unlocked), also if the criteria estimate_... are off, "   \
      "and catches it again; off: for the paper's loop, whose lag is larger than this check accepts")        \
    E(67, mtpa, "off|on", MTPA_ON, TABLE_LIVE,                                                               \
      "i_d of a salient rotor for most torque per ampere; off, or motor_inductance_q up to 1.1 "             \
      "motor_inductance_d: i_d_request alone")                                                               \
    E(85, field_weakening, "off|on", DRIVE_WEAKENING, TABLE_LIVE,                                            \
      "negative i_d where the DC link limits the voltage, for any rotor; off: the speed is limited there")   \
    F(86, voltage_use, "-", 0.93f, 0.5f, 1.1f, TABLE_LIVE,                                                   \
      "share of U_dc/sqrt3 that field_weakening uses, within duties and dead time; the rest is for the "     \
      "current control")                                                                                     \
    E(165, over_modulation, "off|on", OVER_MODULATION_OFF, TABLE_LIVE,                                       \
      "on: the voltage may exceed that of a sinusoidal modulation, up to six-step within duties and dead "   \
      "time; off: up to U_dc/sqrt3 within them")                                                             \
    F(87, torque_slew, "s", 0.0f, 0.0f, 10.0f, TABLE_LIVE,                                                   \
      "time in which the torque may grow to that of current_limit; 0: 10 ms for a salient rotor, else no "   \
      "limit")                                                                                               \
    F(70, stall_time, "s", 2.0f, 0.0f, 3600.0f, TABLE_LIVE,                                                  \
      "time for which the rotor may be at standstill at the current limit while a speed is commanded; 0: "   \
      "not judged")                                                                                          \
    F(71, speed_error_time, "s", 5.0f, 0.0f, 3600.0f, TABLE_LIVE,                                            \
      "time for which the speed may stay far from its reference at the current limit without approaching "   \
      "it; 0: not judged")                                                                                   \
    E(72, encoder_fault_reaction, "open|sensorless|ignored", ENCODER_FAULT_OPEN, TABLE_LIVE,                 \
      "reaction to a wrong encoder: bridge open, continue without it if the motor turns, or none (a test "   \
      "without a motor)")                                                                                    \
    E(66, current_judged, "off|on", CURRENT_JUDGED, TABLE_LIVE,                                              \
      "on: current sensors and phases are checked with the voltage equation of the winding; off: for a "     \
      "test without a motor")                                                                                \
    F(80, ride_through_time, "s", 0.0f, 0.0f, 10.0f, TABLE_LIVE,                                             \
      "time for which a lost supply is no fault: the rotor feeds the DC link, or coasts, and the motor "     \
      "runs again when the supply returns; 0: off")                                                          \
    F(81, motor_current_continuous, "A", 0.7f * BOARD_AMPERES(BOARD_CURRENT_LIMIT_MA), 0.0f, 1000.0f,        \
      TABLE_LIVE, "continuous current of the motor, length of the vector; 0: not judged")                    \
    F(82, motor_time_constant, "s", 60.0f, 0.0f, 3600.0f, TABLE_LIVE,                                        \
      "thermal time constant of the motor's winding; 0: not judged")                                         \
    F(83, module_current_continuous, "A", BOARD_AMPERES(BOARD_MODULE_CONTINUOUS_MA), 0.0f, 1000.0f,          \
      TABLE_LIVE, "continuous direct current of a leg of the module; 0: not judged")                         \
    F(84, module_time_constant, "s", (float)BOARD_MODULE_TIME_MS / 1e3f, 0.0f, 100.0f, TABLE_LIVE,           \
      "thermal time constant of the module's switches; 0: not judged")                                       \
    F(90, fault_stop_time, "s", 5.0f, 0.0f, 600.0f, TABLE_LIVE,                                              \
      "time for stopping the motor after a fault until the bridge opens anyway; 0: opens at once")           \
    F(92, background_time_max, "s", 0.1f, 0.0f, 10.0f, TABLE_LIVE,                                           \
      "longest permitted pause of the background while the motor runs; 0: not judged (for a debugger that "  \
      "halts only the background)")                                                                          \
    F(93, command_timeout, "s", 1.0f, 0.0f, 3600.0f, TABLE_LIVE,                                             \
      "time for which a client on the serial link may be silent before a motor that it switched on stops; "  \
      "0: no limit")                                                                                         \
    I(123, line_key, "-", 0, 0, 999999, TABLE_LIVE,                                                          \
      "key that a client on the serial link needs for writing; 0: none. A change acts from the next "        \
      "connection on")                                                                                       \
    E(195, line_protocol, "xcp|modbus", LINE_XCP, TABLE_OFF,                                                 \
      "protocol on the serial link: XCP at the rate of the board, or Modbus RTU at modbus_baud; it changes " \
      "20 ms after the last answer")                                                                         \
    I(196, modbus_address, "-", 1, 1, 247, TABLE_OFF, "address of the drive as a server of Modbus RTU")      \
    I(197, modbus_baud, "-", 19200, 9600, 115200, TABLE_OFF,                                                 \
      "rate of the serial link under Modbus RTU, in bit/s; 8 data bits, no parity, 1 stop bit")              \
    F(94, motor_saturation_current, "A", 0.0f, 0.0f, 10000.0f, TABLE_LIVE,                                   \
      "i_q at which saturation reduces the flux of the q axis to 1/sqrt 2 of motor_inductance_q i_q; "       \
      "motor_inductance_q is then the value without current; 0: no saturation")                              \
    F(124, motor_data_uncertainty, "-", 0.1f, 0.0f, 1.0f, TABLE_LIVE,                                        \
      "standard uncertainty of the configured R, L and dead time, relative to their values, for "            \
      "theta_sigma and for the stability of the tracking loop; 0: the loop takes L for exact")               \
    E(205, fault_record, "signals|replay", FAULT_RECORD_SIGNALS, TABLE_LIVE,                                 \
      "what the drive keeps of the time before a fault: 12 signals of 341 periods, or the raw samples and "  \
      "the state from which `lagless replay` runs the drive's tasks again")                                  \
    F(236, chopper_voltage, "V", 0.0f, 0.0f, DRIVE_CHOPPER_MAX, TABLE_LIVE,                                  \
      "DC-link voltage above which the chopper output connects the brake resistor, until 2 % below; 0: "     \
      "no chopper")                                                                                          \
    F(237, chopper_resistance, "ohm", 100.0f, 0.1f, 10000.0f, TABLE_LIVE, "brake resistor of the chopper")   \
    F(238, chopper_power, "W", 100.0f, 1.0f, 1e6f, TABLE_LIVE, "continuous power of the brake resistor")     \
    F(239, chopper_time_constant, "s", 30.0f, 0.1f, 3600.0f, TABLE_LIVE,                                     \
      "thermal time constant of the brake resistor")                                                         \
    E(240, holding_brake, "off|on", BRAKE_NONE, TABLE_OFF,                                                   \
      "on: the brake output releases a holding brake when the motor has torque, and sets it before the "     \
      "bridge opens; `enable` = off then stops the motor like quick_stop; with an encoder only")             \
    F(241, brake_release_time, "s", 0.1f, 0.0f, 5.0f, TABLE_LIVE,                                            \
      "time from the brake output until the shaft is free; until then the speed reference is zero")          \
    F(242, brake_apply_time, "s", 0.1f, 0.0f, 5.0f, TABLE_LIVE,                                              \
      "time from the end of the brake output until the brake holds; until then the motor holds")             \
    F(243, brake_preload, "N m", 0.0f, -10000.0f, 10000.0f, TABLE_LIVE,                                      \
      "torque that the motor must have before the brake is released: that of the load at standstill")        \
    F(304, supply_current_max, "A", 0.0f, 0.0f, 10000.0f, TABLE_LIVE,                                        \
      "largest mean current that the motor draws from the supply: the torque is limited to it; 0: no limit") \
    F(305, supply_current_regen_max, "A", 0.0f, 0.0f, 10000.0f, TABLE_LIVE,                                  \
      "largest mean current that a braking motor returns to the supply, for a battery: the torque is "       \
      "limited to it; 0: no limit")                                                                          \
    I(91, module_fault_retries, "-", 0, 0, 100, TABLE_LIVE,                                                  \
      "number of faults of the power module that the drive resets by itself: after a second it starts the "  \
      "motor again if `enable` is still on")

typedef struct {
#define PARAMS_FLOAT(id, name, unit, initial, min, max, access, text) float name;   /* [unit of its row] */
#define PARAMS_INT(id, name, unit, initial, min, max, access, text)   int32_t name; /* [unit of its row] */
#define PARAMS_ENUM(id, name, choices, initial, access, text)         int32_t name; /* [-] */
    DRIVE_PARAMS(PARAMS_FLOAT, PARAMS_INT, PARAMS_ENUM)
#undef PARAMS_FLOAT
#undef PARAMS_INT
#undef PARAMS_ENUM
} params_t;

extern const table_t params_table;

/* Defaults of every row: a set that params_check accepts. */
void params_defaults(params_t *params);

/* Judges whether the drive may run with this set. false: `why` names the first row that is out of its range,
 * or the first row of the first broken rule between rows (rules.h). It gives the value of this row, and the
 * range that would be accepted with every other row unchanged: the row's own range, reduced by all rules
 * between rows. The row to change is this row. If none of its values is accepted, it is another row whose
 * change makes one possible, or 0 if no single row does. Pure; for the background: a refusal evaluates the
 * rules some hundred times. */
bool params_check(const params_t *params, params_error_t *why);

/* True if `next` may replace `active` while the bridge is on. false: names the
 * first TABLE_OFF field that differs. */
bool params_check_live(const params_t *active, const params_t *next, params_error_t *why);

/* The estimator's part of a set that is in its ranges. A tracking loop exists for each such set; a
 * feedforward_cutoff that is not below pll_bandwidth, which params_check refuses, is left out. */
void params_estimator(const params_t *params, const assumed_t *assumed, estimator_params_t *estimator);

/* Bandwidth of the tracking loop over that of the speed control, by the rule [-]. */
#define PARAMS_SPEED_BELOW_LOOP 14.0f

/* The tracking loop: configured rows, or their rules where pll_bandwidth is 0 (docs/theory.md, 7). */
typedef struct {
    float bandwidth; /* [rad/s] */
    float cutoff;    /* of the feed-forward [rad/s] */
    float speed;     /* of the speed control, by its rule [rad/s] */
    bool slow;       /* true: a torque step of the current limit exceeds the range of the loop */
} loop_params_t;

loop_params_t params_loop(const params_t *params, const assumed_t *assumed);

/* The observer: configured rows, or their rules where they are 0 (docs/theory.md, 3). */
typedef struct {
    float gain;        /* k_s [V] */
    float slope;       /* a_f [1/A] */
    float current_max; /* largest current error of a valid estimate [A] */
} observer_rows_t;

#define PARAMS_OBSERVER_GAIN_LEAST  0.1f  /* [V] of k_s */
#define PARAMS_OBSERVER_SLOPE_LEAST 1e-3f /* [1/A] of a_f */

observer_rows_t params_observer(const params_t *params, const assumed_t *assumed);

/* Above this L_q/L_d a rotor counts as salient [-]: its i_d is below zero, and L is not learnt. */
#define PARAMS_SALIENT 1.1f

static inline bool params_salient(const assumed_t *assumed)
{
    return assumed->inductance_q > PARAMS_SALIENT * assumed->inductance_d;
}

/* The largest active flux [Wb]: with the longest current at most torque per ampere, or that
 * of field_weakening at overspeed_trip with the least link voltage without link control.
 * For a round rotor it is psi_f. */
float params_flux_most(const params_t *params, const assumed_t *assumed);

/* The least link voltage without link control, over dc_undervoltage [-]: ride-through begins there. */
#define PARAMS_LINK_LEAST (LINK_HOLD + LINK_HOLD_BAND)

/* The parameters of field weakening. */
weakening_params_t params_weakening(const params_t *params, const assumed_t *assumed);

/* i_d of most torque per ampere at current_limit [A], not above zero; 0 for a
 * round rotor, and without mtpa. */
float params_mtpa(const params_t *params, const assumed_t *assumed);

/* Acceleration of the shaft by i_q = 1 A, 1.5 p psi_f/J [rad/s^2 per A], mechanical. A division. */
static inline float params_acceleration(const params_t *params, const assumed_t *assumed)
{
    return 1.5f * (float)params->motor_pole_pairs * assumed->flux_linkage / assumed->inertia;
}

/* The parameters of current control in the frame of the encoder. */
current_control_params_t params_encoder_control(const params_t *params, const assumed_t *assumed);

/* The parameters of current control with the position source of the parameters. */
current_control_params_t params_current_control(const params_t *params, const assumed_t *assumed);

/* The largest torque at current_limit [N m]. */
float params_torque_most(const params_t *params, const assumed_t *assumed);

/* The saturation of the q axis, for its table; all zero without. */
saturation_params_t params_saturation(const params_t *params, const assumed_t *assumed);

/* Least incremental inductance in any direction, with at most current_limit [H]. */
float params_inductance_least(const params_t *params, const assumed_t *assumed);

/* The constant L_q of the observer over motor_inductance_q [-]; 1 without saturation. */
float params_saturation_share(const params_t *params);

/* The assumed values that a set of parameters gives for all values that can be learnt. */
assumed_t params_configured(const params_t *params);

/* Parameters of a start and of the change to a forced frame: configured rows, or their rules where
 * they are 0 (docs/theory.md, 23). */
typedef struct {
    float current;        /* [A] in the forced frame */
    float current_most;   /* [A] in another try */
    float ramp;           /* [rad/s^2] mechanical */
    float stop_ramp;      /* [rad/s^2] mechanical, of a quick stop */
    float handover_speed; /* [rad/s] mechanical */
    float fallback_speed; /* [rad/s] mechanical */
    float catch_speed;    /* [rad/s] mechanical, of the slowest turning rotor that is caught */
    float visible_speed;  /* [rad/s] mechanical: handover_speed without the noise of the observed EMF */
    float dead_voltage;   /* [V] largest effect of the dead time, at the largest link voltage */
} start_params_t;

start_params_t params_start(const params_t *params, const assumed_t *assumed);

/* This noise of a current sensor [A], or 0 if it is certain that it does not change the hand-over speed. No
 * exponential, no division. */
float params_noise(const params_t *params, const assumed_t *assumed, float noise);

/* Values in use of the rows that have a rule: the configured value, or the rule where it is 0. */
typedef struct {
    float observer_gain;      /* [V] */
    float observer_slope;     /* [1/A] */
    float pll_bandwidth;      /* [rad/s] */
    float feedforward_cutoff; /* [rad/s] */
    float handover_speed;     /* [rad/s] mechanical */
} params_in_force_t;

params_in_force_t params_in_force(const params_t *params, const assumed_t *assumed);

/* Smallest duty of a leg: it contains the dead time and the shortest pulse. */
float params_duty_min(const params_t *params);

/* Largest duty of a leg: one minus the smallest. If shunts measure the current only while the lower
 * switch is on, it also leaves that switch on, and the shunt's signal settled, when the sample at
 * the middle of its pulse is held. */
float params_duty_max(const params_t *params);

#endif
