/* The fault table: every protection of the drive is one row here and nothing else. Enumeration, evaluator
 * (guard.c), reasons, `lagless explain`, docs/reference.md and the test of every row come from it.
 *
 * F(number, NAME, "name", quantity, comparison, "limit row", margin, debounce, when, reaction,
 *   "what happened", "what to do")
 *
 *   number      permanent, append only: shared with the refusals of reasons.h
 *   quantity    field of quantities_t in guard.c
 *   comparison  ABOVE, BELOW: of the limit; HOLDS: the quantity is a condition, there is no limit
 *   limit row   parameter that is the limit, "" with HOLDS; margin is added to it, in its unit
 *   debounce    [periods] that it must hold without a break
 *   when        ALWAYS; RUNNING: only while the gates shall be on; ENCODER: likewise, and control turns with
 *               the encoder; TRACKING: likewise, and control turns with an estimate that may be judged
 *   reaction    OPEN: bridge open, fault latched; CATCH: the rotor is lost and caught again; WARN: shown in
 *               `warnings` while it holds
 *
 * Order: gravest first; of several at once the first is the reason. A row's place is its bit in
 * `faults_later` and `warnings`: append only, too. A current over its limit or a trip stops at once; what is
 * slow by nature may take its time, so that one disturbed conversion does not stop a drive. */
#ifndef DRIVE_FAULTS_H
#define DRIVE_FAULTS_H

#include <stdint.h>

#include "drive/params.h"

/* How far below its limit the heat sink is warm [K]. */
#define FAULTS_SINK_WARM 10.0f

#define DRIVE_FAULTS(F)                                                                                      \
    F(20, MODULE_FAULT, "module_fault", tripped, HOLDS, "", 0.0f, 1u, RUNNING, OPEN,                         \
      "the power module pulled its fault line: short circuit, over-temperature or "                          \
      "low gate supply",                                                                                     \
      "look for a short circuit; check the 15 V supplies and the heat sink")                                 \
    F(21, OVERCURRENT, "overcurrent", phase_current, ABOVE, "overcurrent_trip", 0.0f, 1u, ALWAYS, OPEN,      \
      "a phase current exceeded overcurrent_trip",                                                           \
      "check wiring, encoder direction and offset, current_bandwidth, motor data")                           \
    F(30, BAD_SAMPLE, "bad_sample", bad_sample, HOLDS, "", 0.0f, 3u, ALWAYS, OPEN,                           \
      "a sample was not a number or a current sensor was at its rail",                                       \
      "check sensor supply, wiring and range")                                                               \
    F(22, DC_OVERVOLTAGE, "dc_overvoltage", u_dc, ABOVE, "dc_overvoltage", 0.0f, 2u, ALWAYS, OPEN,           \
      "the DC link exceeded dc_overvoltage", "brake more slowly or add a brake resistor")                    \
    F(26, OVERSPEED, "overspeed", speed, ABOVE, "overspeed_trip", 0.0f, DRIVE_PERIODS(1e-3f), RUNNING, OPEN, \
      "the speed exceeded overspeed_trip", "check references, encoder and load")                             \
    F(29, LATE, "late", late, HOLDS, "", 0.0f, 3u, RUNNING, OPEN,                                            \
      "the interrupt ran past its period several times in a row", "shorten the interrupt")                   \
    F(23, DC_UNDERVOLTAGE, "dc_undervoltage", u_dc, BELOW, "dc_undervoltage", 0.0f, DRIVE_PERIODS(1e-3f),    \
      RUNNING, OPEN, "the DC link is below dc_undervoltage", "check supply and precharge")                   \
    F(28, ENCODER_PHASE, "encoder_phase", encoder_error, HOLDS, "", 0.0f, 1u, ENCODER, OPEN,                 \
      "the encoder tracks changed both at once", "check encoder cable and screen")                           \
    F(24, SINK_HOT, "sink_hot", sink_temperature, ABOVE, "sink_temperature_max", 0.0f, DRIVE_PERIODS(0.1f),  \
      ALWAYS, OPEN, "the heat sink is above sink_temperature_max", "reduce load, improve cooling")           \
    F(25, MOTOR_HOT, "motor_hot", motor_temperature, ABOVE, "motor_temperature_max", 0.0f,                   \
      DRIVE_PERIODS(0.1f), ALWAYS, OPEN, "the motor is above motor_temperature_max",                         \
      "reduce load, improve cooling")                                                                        \
    F(32, ESTIMATE_AMPLITUDE, "estimate_amplitude", estimate_amplitude, HOLDS, "", 0.0f, 1u, TRACKING,       \
      CATCH, "the estimated back-EMF did not fit the estimated speed: the rotor is lost",                    \
      "check motor_flux_linkage, dead time and load; below 50 r/min there is too little EMF")                \
    F(33, ESTIMATE_DETECTOR, "estimate_detector", estimate_detector, HOLDS, "", 0.0f, 1u, TRACKING, CATCH,   \
      "the tracking error of the estimator stayed too large: the rotor is lost",                             \
      "raise pll_bandwidth or use the torque feed-forward; check dead time and motor data")                  \
    F(34, ESTIMATE_CURRENT, "estimate_current", estimate_current, HOLDS, "", 0.0f, 1u, TRACKING, CATCH,      \
      "the observed current stayed far from the measured one: the observer is lost",                         \
      "raise observer_gain; check motor_resistance, motor_inductance_q and wiring")                          \
    F(35, ESTIMATE_SPEED, "estimate_speed", estimate_speed, HOLDS, "", 0.0f, 1u, TRACKING, CATCH,            \
      "the speed stayed below estimate_speed_min or above overspeed_trip: nothing to see or to follow",      \
      "keep sensorless operation faster, or run with the encoder")                                           \
    F(37, SINK_WARM, "sink_warm", sink_temperature, ABOVE, "sink_temperature_max", -FAULTS_SINK_WARM,        \
      DRIVE_PERIODS(0.1f), ALWAYS, WARN, "the heat sink is within 10 K of sink_temperature_max",             \
      "reduce load or improve cooling before it stops the drive")                                            \
    F(38, UNLOCKED, "unlocked", unlocked, HOLDS, "", 0.0f, DRIVE_PERIODS(5e-3f), TRACKING, CATCH,            \
      "the back-EMF was not where the estimate put it: the rotor is lost",                                   \
      "check load and motor data; raise pll_bandwidth or use the torque feed-forward")                       \
    F(39, LOCK_LOST, "lock_lost", lock_lost, HOLDS, "", 0.0f, 1u, RUNNING, OPEN,                             \
      "the rotor was lost three times within 2 s",                                                           \
      "look for a shaft that is held, a load beyond current_limit, or wrong motor data")                     \
    F(40, START_STALLED, "start_stalled", start_stalled, HOLDS, "", 0.0f, 1u, RUNNING, OPEN,                 \
      "the rotor did not follow the start, in start_tries tries",                                            \
      "free the shaft; raise start_current, lower start_ramp; check motor_inertia and wiring")               \
    F(41, START_UNLOCKED, "start_unlocked", start_unlocked, HOLDS, "", 0.0f, 1u, RUNNING, OPEN,              \
      "the rotor followed the start, but the estimate did not get hold of it, in start_tries tries",         \
      "check motor data and dead time; raise handover_speed")                                                \
    F(42, ROTOR_TOO_FAST, "rotor_too_fast", rotor_too_fast, HOLDS, "", 0.0f, 1u, RUNNING, OPEN,              \
      "the rotor turns so fast that its back-EMF is beyond the DC link, or current flows with the gates "    \
      "off",                                                                                                 \
      "let the rotor slow down, or raise the DC link; if it stands, check the current sensors")

/* A row's bit, and how many there are. */
typedef enum {
#define FAULT_BIT(number, NAME, name, quantity, comparison, limit, margin, debounce, when, reaction, text,   \
                  remedy)                                                                                    \
    FAULT_##NAME,
    DRIVE_FAULTS(FAULT_BIT)
#undef FAULT_BIT
        FAULTS
} fault_bit_t;

typedef enum { FAULT_WARN, FAULT_CATCH, FAULT_OPEN } fault_reaction_t;
typedef enum { FAULT_ALWAYS, FAULT_RUNNING, FAULT_ENCODER, FAULT_TRACKING } fault_when_t;

/* A row as data. */
typedef struct {
    int32_t reason;         /* [-] reason_t */
    const char *name;       /* of reason and fault */
    const char *quantity;   /* field of quantities_t in guard.c */
    const char *comparison; /* "ABOVE", "BELOW" or "HOLDS" */
    const char *limit;      /* row of the parameters; "": none */
    float margin;           /* [unit of the limit] */
    uint32_t debounce;      /* [periods] */
    fault_when_t when;
    fault_reaction_t reaction;
} fault_row_t;

extern const fault_row_t fault_rows[FAULTS];

#endif
