/* Data of the matrix: faults, manoeuvres and promises of the drive. To change a promise, edit only this file;
 * `lagless matrix --cell FAULT/MANOEUVRE` shows the result.
 *
 * A cell whose promise the drive does not keep is red, and is listed at the end of this file. A promise is
 * reduced only if it is physically impossible to keep; its row then contains the reason. */
#ifndef HOST_SIM_LAB_MATRIX_TABLE_H
#define HOST_SIM_LAB_MATRIX_TABLE_H

#include <math.h>

#include "host_sim/lab/matrix.h"
#include "host_sim/lab/promised.h"
#include "host_sim/rig/rig.h"
#include "settings/faults.h"

/* clang-format off */

/* ---- faults ----
 *
 * F(NAME, "name", when, watch [s], lasts [s], what, "text")
 *   when   LATER: the fault occurs in the manoeuvre; FIRST: it exists from the beginning, before the bridge comes on
 *   watch  from the injection to the end; a cell ends 0.3 s after a fault is latched
 *   lasts  after this time the changes end; FOR_GOOD: permanent
 *   what   SET(row, value), TIMES(row, factor), ADD(row, step); NOTHING; WITH_CAPACITOR(row, value): before the change
 *          the DC link gets a capacitor of 1 mF behind 0.2 ohm; RECTIFIED: this alone; WITH_RESISTOR(ohms, above): the
 *          link gets a brake resistor as well, which is connected above this voltage */

#define LATER false
#define FIRST true
#define FOR_GOOD 0.0
#define NOTHING                    {{NULL, 0.0, 0.0}}
#define SET(row, value)            {{row, 0.0, value}}
#define TIMES(row, factor)         {{row, factor, 0.0}}
#define ADD(row, step)             {{row, 1.0, step}}
#define WITH_CAPACITOR(row, value) \
    {{"plant.dc_capacitance", 0.0, 1e-3}, {"plant.dc_resistance", 0.0, 0.2}, {row, 0.0, value}}
#define RECTIFIED {{"plant.dc_capacitance", 0.0, 1e-3}, {"plant.dc_resistance", 0.0, 0.2}}
#define WITH_RESISTOR(ohms, above) \
    {{"plant.dc_capacitance", 0.0, 1e-3}, {"plant.dc_resistance", 0.0, 0.2}, {"plant.chopper_resistance", 0.0, ohms}, \
     {"plant.chopper_voltage", 0.0, above}}

/* Code of the ADC for this current [A]. */
#define CODE(amperes) (double)(int32_t)(((amperes) - (double)BOARD_CURRENT_AT_0V) / (double)BOARD_CURRENT_PER_CODE + 0.5)

#define HALF_A_TURN 0.785398 /* [rad] electrical, of four pole pairs */

#define MATRIX_FAULTS(F) \
    F(NONE,             "none",             LATER, 3.0, FOR_GOOD, NOTHING,                                   "nothing is wrong: no false alarm") \
    /* current sensors */ \
    F(STUCK_A_RAIL,     "stuck_a_rail",     LATER, 1.0, FOR_GOOD, SET("rig.stuck_current_a", 4095.0),        "current sensor a reads its largest value") \
    F(STUCK_B_RAIL,     "stuck_b_rail",     LATER, 1.0, FOR_GOOD, SET("rig.stuck_current_b", 0.0),           "current sensor b reads its smallest value") \
    F(STUCK_A_ZERO,     "stuck_a_zero",     LATER, 3.0, FOR_GOOD, SET("rig.stuck_current_a", CODE(0.0)),     "current sensor a is dead and reads 0 A") \
    F(STUCK_B_ZERO,     "stuck_b_zero",     LATER, 3.0, FOR_GOOD, SET("rig.stuck_current_b", CODE(0.0)),     "current sensor b is dead and reads 0 A") \
    F(STUCK_C_ZERO,     "stuck_c_zero",     LATER, 3.0, FOR_GOOD, SET("rig.stuck_current_c", CODE(0.0)),     "current sensor c is dead and reads 0 A") \
    F(STUCK_A_2A,       "stuck_a_2a",       LATER, 3.0, FOR_GOOD, SET("rig.stuck_current_a", CODE(2.0)),     "current sensor a always reads 2 A") \
    F(STUCK_B_2A,       "stuck_b_2a",       LATER, 3.0, FOR_GOOD, SET("rig.stuck_current_b", CODE(-2.0)),    "current sensor b always reads -2 A") \
    F(CURRENT_RANGE,    "current_range",    FIRST, 3.0, FOR_GOOD, TIMES("plant.current_range", 2.0),         "current sensors with twice the configured range: they read half of the current") \
    F(CURRENT_INVERSE,  "current_inverse",  FIRST, 3.0, FOR_GOOD, TIMES("plant.current_range", -1.0),        "all current sensors are wired the wrong way round") \
    F(SWAP_CURRENTS,    "swap_currents",    FIRST, 3.0, FOR_GOOD, SET("plant.swap_currents", 3.0),           "the signals of current sensors a and b are exchanged") \
    F(GAIN_A,           "gain_a",           LATER, 6.0, FOR_GOOD, SET("plant.current_gain_error_a", 0.5),    "current sensor a reads 1.5 times the current") \
    F(OFFSET_A,         "offset_a",         LATER, 9.0, FOR_GOOD, ADD("plant.current_offset_a", 2.0),        "the offset of current sensor a changes by 2 A") \
    F(NOISE_BURST,      "noise_burst",      LATER, 3.0, 0.01,     SET("plant.current_noise", 0.5),           "10 ms of noise in the current sensors, 0.5 A rms") \
    /* wires, legs, module */ \
    F(OPEN_PHASE_A,     "open_phase_a",     LATER, 3.0, FOR_GOOD, SET("plant.open_phase_a", 1.0),            "the wire of phase a is broken") \
    F(OPEN_PHASE_B,     "open_phase_b",     LATER, 3.0, FOR_GOOD, SET("plant.open_phase_b", 1.0),            "the wire of phase b is broken") \
    F(OPEN_PHASE_C,     "open_phase_c",     LATER, 3.0, FOR_GOOD, SET("plant.open_phase_c", 1.0),            "the wire of phase c is broken") \
    F(SWAP_PHASES,      "swap_phases",      FIRST, 3.0, FOR_GOOD, SET("plant.swap_phases", 3.0),             "the motor wires a and b are exchanged") \
    F(OPEN_SWITCH_A,    "open_switch_a",    LATER, 3.0, FOR_GOOD, SET("plant.open_switches", 1.0),           "the upper switch of leg a never conducts") \
    F(OPEN_SWITCH_B,    "open_switch_b",    LATER, 3.0, FOR_GOOD, SET("plant.open_switches", 8.0),           "the lower switch of leg b never conducts") \
    F(SHORT_SWITCH_A,   "short_switch_a",   LATER, 1.0, FOR_GOOD, SET("plant.shorted_switches", 1.0),        "the upper switch of leg a always conducts") \
    F(LEG_A_DROP,       "leg_a_drop",       LATER, 3.0, FOR_GOOD, SET("plant.leg_a_drop", 2.0),              "the switches of leg a drop 2 V more") \
    F(LEG_A_RESISTANCE, "leg_a_resistance", LATER, 3.0, FOR_GOOD, SET("plant.leg_a_resistance", 1.0),        "a bad contact of 1 ohm in phase a") \
    F(MODULE_FAULT,     "module_fault",     LATER, 1.0, FOR_GOOD, SET("plant.force_fault", 1.0),             "the power module switches off and activates its fault output") \
    F(SINK_WARM,        "sink_warm",        LATER, 3.0, FOR_GOOD, SET("plant.sink_temperature", 85.0),       "the heat sink is warm") \
    F(SINK_HOT,         "sink_hot",         LATER, 3.0, FOR_GOOD, SET("plant.sink_temperature", 95.0),       "the heat sink is too hot") \
    F(MOTOR_HOT,        "motor_hot",        LATER, 3.0, FOR_GOOD, SET("plant.motor_temperature", 140.0),     "the winding is too hot") \
    F(DEMAGNETISED,     "demagnetised",     LATER, 3.0, FOR_GOOD, TIMES("plant.flux_linkage", 0.8),          "the magnets have lost a fifth of their flux") \
    /* shaft */ \
    F(JAM,              "jam",              LATER, 9.0, FOR_GOOD, SET("rig.brake_torque", 1000.0),           "the shaft is jammed") \
    F(OVERLOAD,         "overload",         LATER, 9.0, FOR_GOOD, SET("rig.brake_torque", 14.0),             "a brake with more torque than current_limit allows") \
    F(BRAKE,            "brake",            LATER, 4.0, FOR_GOOD, SET("rig.brake_torque", 3.0),              "a brake well within current_limit: this is a load, no fault") \
    F(BRAKE_FALLS,      "brake_falls",      LATER, 9.0, FOR_GOOD, SET("plant.holding_torque", 30.0),         "the holding brake has lost its supply, and its spring sets it") \
    /* encoder */ \
    F(ENCODER_SLIPPED,  "encoder_slipped",  LATER, 3.0, FOR_GOOD, ADD("plant.encoder_offset", HALF_A_TURN),  "the encoder has slipped on the shaft by half an electrical turn") \
    F(ENCODER_SLIPS,    "encoder_slips",    LATER, 3.0, FOR_GOOD, SET("plant.encoder_slip", 0.3),            "the encoder misses three tenths of the motion") \
    F(ENCODER_STANDS,   "encoder_stands",   LATER, 3.0, FOR_GOOD, SET("plant.encoder_slip", 1.0),            "the coupling of the encoder is broken: the encoder does not turn") \
    F(ENCODER_TRACK,    "encoder_track",    LATER, 3.0, FOR_GOOD, SET("plant.encoder_stuck_a", 1.0),         "track A of the encoder has a constant level") \
    F(ENCODER_OFFSET,   "encoder_offset",   FIRST, 3.0, FOR_GOOD, ADD("plant.encoder_offset", HALF_A_TURN),  "the offset of the encoder is wrong by half an electrical turn") \
    F(ENCODER_LINES,    "encoder_lines",    FIRST, 3.0, FOR_GOOD, TIMES("plant.encoder_lines", 0.5),         "an encoder with half of the configured lines") \
    F(ENCODER_REVERSED, "encoder_reversed", FIRST, 3.0, FOR_GOOD, SET("plant.encoder_reversed", 1.0),        "the tracks of the encoder are exchanged: it counts the other way") \
    F(POLE_PAIRS,       "pole_pairs",       FIRST, 3.0, FOR_GOOD, ADD("plant.pole_pairs", 1.0),              "a motor with five pole pairs, while four are configured") \
    /* DC link */ \
    F(DC_HIGH,          "dc_high",          LATER, 1.0, FOR_GOOD, SET("plant.dc_voltage", 420.0),            "the DC link is too high") \
    F(DC_LOW,           "dc_low",           LATER, 3.0, FOR_GOOD, SET("plant.dc_voltage", 150.0),            "the DC link is too low, permanently") \
    F(DC_SAG,           "dc_sag",           LATER, 3.0, 0.3,      SET("plant.dc_voltage", 230.0),            "the DC link sags to 230 V for 0.3 s") \
    F(DC_RIPPLE,        "dc_ripple",        LATER, 3.0, FOR_GOOD, SET("plant.dc_ripple", 30.0),              "the DC link swings by 30 V at 300 Hz") \
    F(SUPPLY_LOST,      "supply_lost",      LATER, 4.0, FOR_GOOD, WITH_CAPACITOR("plant.supply_lost", 1.0),  "the supply no longer feeds the DC link of 1 mF") \
    F(SUPPLY_BACK,      "supply_back",      LATER, 4.0, 0.3,      WITH_CAPACITOR("plant.supply_lost", 1.0),  "the supply does not feed the DC link of 1 mF for 0.3 s") \
    F(CHARGE_CUT,       "charge_cut",       LATER, 4.0, FOR_GOOD, RECTIFIED,                                 "the battery at the DC link of 1 mF no longer accepts current") \
    F(BATTERY,          "battery",          LATER, 4.0, FOR_GOOD, WITH_CAPACITOR("plant.dc_returns", 1.0),   "a battery at the DC link of 1 mF takes current: this is no fault") \
    F(CHOPPER_ALONE,    "chopper_alone",    LATER, 4.0, FOR_GOOD, WITH_RESISTOR(47.0, 365.0),                "a chopper that switches by itself, at the DC link of 1 mF: this is no fault") \
    F(CHOPPER_SHORTED,  "chopper_shorted",  LATER, 4.0, FOR_GOOD, WITH_RESISTOR(47.0, 1.0),                  "the switch of the chopper is shorted: the resistor stays at the DC link of 1 mF") \
    F(DC_STUCK_HIGH,    "dc_stuck_high",    LATER, 1.0, FOR_GOOD, SET("rig.stuck_dc_link", 4095.0),          "the sensor of the DC link reads its largest value") \
    F(DC_STUCK_LOW,     "dc_stuck_low",     LATER, 3.0, FOR_GOOD, SET("rig.stuck_dc_link", 0.0),             "the sensor of the DC link reads its smallest value") \
    /* software and samples */ \
    F(LATE,             "late",             LATER, 1.0, FOR_GOOD, SET("rig.interrupt_delay", 120e-6),        "the sample interrupt begins later than one period") \
    F(MISSING_SAMPLE,   "missing_sample",   LATER, 3.0, FOR_GOOD, SET("rig.missing_samples", 1.0),           "one conversion and its interrupt do not occur") \
    F(MISSING_SAMPLES,  "missing_samples",  LATER, 3.0, FOR_GOOD, SET("rig.missing_samples", 10.0),          "ten successive conversions do not occur") \
    F(ESTIMATE_JUMP,    "estimate_jump",    LATER, 3.0, FOR_GOOD, SET("rig.estimate_jump", 2.5),             "the estimated angle jumps by 2.5 rad") \
    F(FLIP_FLASH,       "flip_flash",       LATER, 3.0, FOR_GOOD, SET("rig.flip_memory", 1.0),               "a bit of the program in flash flips") \
    F(FLIP_CODE,        "flip_code",        LATER, 3.0, FOR_GOOD, SET("rig.flip_memory", 2.0),               "a bit of the interrupt's code in RAM flips") \
    F(FLIP_STACK_END,   "flip_stack_end",   LATER, 3.0, FOR_GOOD, SET("rig.flip_memory", 3.0),               "a bit at the end of the stack flips") \
    F(FLIP_PARAMS,      "flip_params",      LATER, 3.0, FOR_GOOD, SET("rig.flip_memory", 4.0),               "a bit of the active parameters flips") \
    /* enable input */ \
    F(ENABLE_LOST,      "enable_lost",      LATER, 1.0, FOR_GOOD, SET("rig.enable_input", 1.0),              "the enable input of the board is lost permanently") \
    F(ENABLE_BOUNCES,   "enable_bounces",   LATER, 3.0, 2e-3,     SET("rig.enable_input", 1.0),              "the enable input of the board is lost for 2 ms")

/* ---- manoeuvres ----
 *
 * M(NAME, "name", missing, enabled, turning, reference, load, settle, then, row, choice, below, delay, "text")
 *   fields of matrix_manoeuvre_t; missing: why there is none with the encoder, NULL: there is */

#define NOT_WITH_ENCODER "with the encoder the drive has only the manoeuvre run, at every speed"
#define RPM (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */
#define NO_SPEED (double)NAN
#define ENABLED true
#define OFF_YET false

#define MATRIX_MANOEUVRES(M) \
    M(OFF,      "off",      NULL,             OFF_YET, 0.0,    300.0,  0.0, 0.0, NO_SPEED,NULL,           NULL,                0.0,          0.05, "ready, the bridge off; 0.1 s after the fault the drive is commanded on, with 300 r/min") \
    M(ALIGN,    "align",    NOT_WITH_ENCODER, ENABLED, 0.0,    300.0,  0.0, 0.0, NO_SPEED,"manoeuvre",    "align",             0.0,          0.05, "start: the forced frame turns slowly, and the rotor follows") \
    M(RAMP,     "ramp",     NOT_WITH_ENCODER, ENABLED, 0.0,    300.0,  0.0, 0.0, NO_SPEED,"manoeuvre",    "ramp",              0.0,          0.05, "start: the forced frame accelerates") \
    M(HANDOVER, "handover", NOT_WITH_ENCODER, ENABLED, 0.0,    300.0,  0.0, 0.0, NO_SPEED,"manoeuvre",    "handover",          0.0,          0.0,  "start: the current decreases, then the frame is that of the estimate") \
    M(RUN_SLOW, "run_slow", NULL,             ENABLED, 150.0,  150.0,  2.5, 1.0, NO_SPEED,NULL,           NULL,                0.0,          0.0,  "150 r/min, 2.5 N m") \
    M(RUN_FAST, "run_fast", NULL,             ENABLED, 1200.0, 1200.0, 2.5, 1.0, NO_SPEED,NULL,           NULL,                0.0,          0.0,  "1200 r/min, 2.5 N m") \
    M(FORCED,   "forced",   NOT_WITH_ENCODER, ENABLED, 300.0,  300.0,  0.0, 0.5, 20.0,   "manoeuvre",    "forced",            0.0,          0.2,  "20 r/min: too slow to track, the rotor follows a forced frame") \
    M(REVERSAL, "reversal", NULL,             ENABLED, 500.0,  500.0,  0.0, 0.5, -500.0, "true_omega_m", NULL,                3.0,          0.0,  "reversal from 500 to -500 r/min; the fault occurs at zero speed") \
    M(BRAKING,  "braking",  NULL,             ENABLED, 1500.0, 1500.0, 0.0, 0.5, 300.0,  "true_omega_m", NULL,                1200.0 * RPM, 0.0,  "braking from 1500 to 300 r/min at the current limit; the fault occurs at 1200 r/min") \
    M(CATCH,    "catch",    NULL,             ENABLED, 600.0,  600.0,  0.0, 0.0, NO_SPEED,"state",        "operation_enabled", 0.0,          2e-3, "the bridge came on 2 ms before the fault, while the rotor turned at 600 r/min")

/* ---- promises ----
 *
 * P(FAULT, manoeuvres, places, reactions, "reasons", within [s], current [A], rotor, "because")
 *   The last row that applies to a cell counts: the rule first, exceptions below it.
 *   manoeuvres  AT(NAME), or sets of them; places ENCODER, SENSORLESS, BOTH, or one of MATRIX_ENCODER_H ...
 *   reactions   a set: any of them will do; NEVER: the cell cannot occur, `because` has the reason
 *   reasons     any of these; none for RIDES and CATCHES
 *   within      SOON: 20 ms or a third of a turn of the currents; AT_ONCE; or a time; ANY_TIME
 *   rotor       a set; OUT: gates off, it coasts or stands */

#define AT(NAME)   (1u << MATRIX_AT_##NAME)
#define EVERYWHERE ((1u << MATRIX_MANOEUVRE_COUNT) - 1u)
#define RUNNING    (AT(RUN_SLOW) | AT(RUN_FAST) | AT(REVERSAL) | AT(BRAKING))

#define ENCODER    (MATRIX_ENCODER_H | MATRIX_ENCODER_L)
#define SENSORLESS (MATRIX_SENSORLESS_H | MATRIX_SENSORLESS_L)
#define BARE       (MATRIX_ENCODER_L | MATRIX_SENSORLESS_L)
#define HEAVY      (MATRIX_ENCODER_H | MATRIX_SENSORLESS_H)
#define BOTH       (ENCODER | SENSORLESS)

#define NEVER   0u
#define RIDES   MATRIX_RIDES
#define WARNS   MATRIX_WARNS
#define CATCHES MATRIX_CATCHES
#define REFUSES MATRIX_REFUSES
#define STOPS   MATRIX_STOPS
#define OPENS   MATRIX_OPENS

#define SOON     MATRIX_NOTICED
#define SOON_IN_ITS_HALF MATRIX_NOTICED_LATER
#define AT_ONCE  1e-3
/* [s] Two rounds of the background's check of the simulated chip's memory, of 50 steps each. A step follows
 * the previous one after 0.4 ms or more, when it is its turn in the list of five or six tasks. The list
 * executes one task per period, or two in three periods with a carrier so fast that the medium task needs the
 * third one. */
#define CHECK_LIST ((BOARD_STORE == BOARD_STORE_I2C ? 6.0 : 5.0) * (double)DRIVE_PERIOD)
#define CHECK_STEP ((double)(uint32_t)(0.4e-3 / CHECK_LIST + 0.999) * CHECK_LIST)
#define ONE_CHECK  (100.0 * CHECK_STEP * ((double)DRIVE_PERIOD < 75e-6 ? 1.5 : 1.0))
#define ANY_TIME (double)NAN

/* Reactions that take windows of the medium task: a value is suspected in the first whole window in which it is constant,
 * is reported in the next one, and the gates are off a period later. */
#define STUCK_WINDOWS ((double)(3u * DRIVE_WINDOW + 1u) * (double)DRIVE_PERIOD)

#define LIMIT    PROMISED_CURRENT

#define FOLLOWS MATRIX_FOLLOWS
#define STRAYS  MATRIX_STRAYS
#define STANDS  MATRIX_STANDS
#define OUT     (MATRIX_COASTS | MATRIX_STANDS)

#define SENSOR_REASONS "overcurrent bad_sample current_stuck current_gain"
#define PHASE_REASONS  "phase_loss"

#define WRONG_FROM_START "the fault exists from the beginning and appears at the first start: see off and catch"
#define NO_SENSOR_C      "the board has no sensor of phase c"
#define WITHOUT_ENCODER  "control does not use the encoder"
#define NO_CURRENT       "with the encoder the bare motor needs almost no current: the fault has no effect"
#define RISES_SLOWLY     "with the encoder the current rises from zero as the speed control commands it"
#define SHOWS_IN_CHANGES "a gain error is visible only where the current changes fast; with a steady current the dead time hides it, and it does no harm below the limit"
#define HIDES_IN_DEAD_TIME "while current flows, an offset of 2 A changes R i by 1.9 V, which the dead time hides; with the bridge off it is visible"
#define CONTRADICTS      "a leg with a wrong current sign compensates its dead time in the wrong direction, and the EMF contradicts the encoder: the drive cannot decide which of the two is wrong"
#define BY_THE_BACKGROUND "the background checks the memory piece by piece"
#define HELD_BY_DEAD_TIME "the bare motor needs 0.05 A, and dead time and voltage drops, 8 V a leg, keep so small a current at zero: the fault is visible only when more current is commanded"
#define WHILE_OFF        "this value is correct while the bridge is off"
#define ONE_MILLIFARAD   "how long 1 mF lasts depends on the load"
#define STANDS_AT_ONCE   "the load stops the bare rotor within 20 ms, which ends its EMF: a stall, after stall_time"
#define HELD_IN_PLACE    "the wrong angle holds the rotor in place: a stall, after stall_time"
#define HIDDEN_SLOW      "at 20 r/min the EMF is 1.5 V, which the dead time hides: a standing rotor cannot be distinguished from one that follows"
#define TWO_WINDOWS      "a value is suspected in the first whole window in which it is constant, and reported in the next one (docs/theory.md, 27)"
#define WITHOUT_CURRENT  "3.2 ms of the time in which current is commanded, plus its zero crossing of 2 ms and a window (docs/theory.md, 27)"
#define SWINGS_IN        "half a turn of the alignment until the switch is needed; a rotor that swings in may feed the phase with 2.6 psi_f (docs/theory.md, 27)"
#define EIGHT_MS_OF_EMF  "10.3 ms until 37 degrees are reached, 8 ms of the EMF at this speed, and three evaluations (docs/theory.md, 28)"
#define NO_ENABLE_INPUT  "the board has no enable input"
#define INPUT_COMES_LATER "with the bridge off the loss lasts until `enable` is on: an input that comes back starts nothing"
#define BOARD_HAS_INPUT(reactions) (BOARD_ENABLE_INPUT != BOARD_NONE ? (reactions) : NEVER)
#define INPUT_DEBOUNCED  ((double)BOARD_ENABLE_DEBOUNCE_US * 1e-6 + 4e-3) /* [s] and the windows of the medium task */
#define NO_TEMPERATURE_SENSOR "the board has no sensor of this temperature"
#define BOARD_HAS_SINK(reactions)  (BOARD_SINK_INPUT != BOARD_NONE ? (reactions) : NEVER)
#define BOARD_HAS_MOTOR(reactions) (BOARD_MOTOR_INPUT != BOARD_NONE ? (reactions) : NEVER)
#if defined(BOARD_CURRENT_SENSORS) && BOARD_CURRENT_SENSORS == 3
#define OR_SUM " current_sum" /* three sensors contradict each other */
#else
#define OR_SUM ""
#endif
#if defined(BOARD_SAMPLES_AT) && BOARD_SAMPLES_AT == BOARD_LOWER_ZERO_VECTOR
#define OR_SHUNT " current_stuck" /* the shunt of a leg has no current if the lower switch does not conduct */
#else
#define OR_SHUNT ""
#endif
#define BOARD_HAS_C(reactions) (BOARD_CURRENT_SENSORS == 3 ? (reactions) : NEVER)

#define MATRIX_PROMISES(P) \
    P(NONE,             EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    \
    P(STUCK_A_RAIL,     EVERYWHERE, BOTH, OPENS, "bad_sample", AT_ONCE, LIMIT, OUT, "") \
    P(STUCK_B_RAIL,     EVERYWHERE, BOTH, OPENS, "bad_sample", AT_ONCE, LIMIT, OUT, "") \
    P(STUCK_A_ZERO,     EVERYWHERE, BOTH, OPENS, "current_stuck" OR_SUM, SOON, LIMIT, OUT, "") \
    P(STUCK_A_ZERO,     AT(OFF),    BOTH, OPENS, "current_stuck", 0.5, LIMIT, OUT, WHILE_OFF) \
    P(STUCK_A_ZERO,     AT(CATCH),  MATRIX_ENCODER_H, OPENS, "current_stuck", 0.2, LIMIT, OUT, RISES_SLOWLY) \
    P(STUCK_A_ZERO,     AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, "current_stuck", ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(STUCK_B_ZERO,     EVERYWHERE, BOTH, OPENS, "current_stuck" OR_SUM, SOON, LIMIT, OUT, "") \
    P(STUCK_B_ZERO,     AT(OFF),    BOTH, OPENS, "current_stuck", 0.5, LIMIT, OUT, WHILE_OFF) \
    P(STUCK_B_ZERO,     AT(CATCH),  MATRIX_ENCODER_H, OPENS, "current_stuck", 0.2, LIMIT, OUT, RISES_SLOWLY) \
    P(STUCK_B_ZERO,     AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, "current_stuck", ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(STUCK_C_ZERO,     EVERYWHERE, BOTH, BOARD_HAS_C(OPENS), SENSOR_REASONS " current_sum", SOON, LIMIT, OUT, NO_SENSOR_C) \
    P(STUCK_C_ZERO,     AT(OFF),    BOTH, BOARD_HAS_C(OPENS), SENSOR_REASONS " current_sum", 0.5, LIMIT, OUT, NO_SENSOR_C) \
    P(STUCK_A_2A,       EVERYWHERE, BOTH, OPENS, "current_stuck" OR_SUM, SOON, LIMIT, OUT, "") \
    P(STUCK_A_2A,       AT(CATCH),  MATRIX_ENCODER_H, OPENS, "current_stuck", STUCK_WINDOWS, LIMIT, OUT, TWO_WINDOWS) \
    P(STUCK_A_2A,       AT(OFF),    BOTH, OPENS | REFUSES, "current_offset", SOON, LIMIT, OUT, "") \
    P(STUCK_B_2A,       EVERYWHERE, BOTH, OPENS, "current_stuck" OR_SUM, SOON, LIMIT, OUT, "") \
    P(STUCK_B_2A,       AT(CATCH),  MATRIX_ENCODER_H, OPENS, "current_stuck", STUCK_WINDOWS, LIMIT, OUT, TWO_WINDOWS) \
    P(STUCK_B_2A,       AT(OFF),    BOTH, OPENS | REFUSES, "current_offset", SOON, LIMIT, OUT, "") \
    P(CURRENT_RANGE,    EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(CURRENT_RANGE,    AT(OFF) | AT(CATCH), BOTH, RIDES | OPENS, "current_gain", ANY_TIME, LIMIT, FOLLOWS | OUT, SHOWS_IN_CHANGES) \
    P(CURRENT_RANGE,    AT(OFF),    SENSORLESS, OPENS, "current_gain", 0.5, LIMIT, OUT, "the current of the alignment rises within some milliseconds") \
    P(CURRENT_INVERSE,  EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(CURRENT_INVERSE,  AT(OFF) | AT(CATCH), BOTH, OPENS, "overcurrent current_gain", SOON, LIMIT, OUT, "") \
    P(CURRENT_INVERSE,  AT(CATCH),  MATRIX_ENCODER_L, OPENS, "overcurrent current_gain", ANY_TIME, LIMIT, OUT, HELD_BY_DEAD_TIME) \
    P(SWAP_CURRENTS,    EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(SWAP_CURRENTS,    AT(OFF) | AT(CATCH), BOTH, OPENS, "overcurrent current_gain", 0.5, LIMIT, OUT, "") \
    P(SWAP_CURRENTS,    AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, "overcurrent current_gain", ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(GAIN_A,           EVERYWHERE, SENSORLESS, RIDES | CATCHES | OPENS, "current_gain lock_lost" OR_SUM, ANY_TIME, LIMIT, FOLLOWS | OUT, SHOWS_IN_CHANGES) \
    P(GAIN_A,           EVERYWHERE, ENCODER, RIDES | OPENS, "current_gain encoder_mismatch" OR_SUM, ANY_TIME, LIMIT, FOLLOWS | OUT, SHOWS_IN_CHANGES "; " CONTRADICTS) \
    P(OFFSET_A,         EVERYWHERE, SENSORLESS, RIDES | CATCHES | OPENS, "lock_lost" OR_SUM, ANY_TIME, LIMIT, FOLLOWS | OUT, HIDES_IN_DEAD_TIME) \
    P(OFFSET_A,         AT(ALIGN) | AT(RAMP), SENSORLESS, RIDES | CATCHES | OPENS, "lock_lost start_unlocked", ANY_TIME, LIMIT, FOLLOWS | OUT, "2 A cause a constant 3.7 V in the EMF (docs/theory.md, 14), compared with 4 to 8 V at 50 to 100 r/min: a start may not lock, and reports it") \
    P(OFFSET_A,         EVERYWHERE, ENCODER, RIDES | OPENS, "encoder_mismatch" OR_SUM, ANY_TIME, LIMIT, FOLLOWS | OUT, HIDES_IN_DEAD_TIME "; " CONTRADICTS) \
    P(OFFSET_A,         AT(OFF),    BOTH, OPENS | REFUSES, "current_offset", SOON, LIMIT, OUT, "") \
    P(NOISE_BURST,      EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(NOISE_BURST,      EVERYWHERE & ~AT(OFF), SENSORLESS, RIDES | CATCHES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    \
    P(OPEN_PHASE_A,     EVERYWHERE, BOTH, OPENS, PHASE_REASONS, SOON, LIMIT, OUT, "") \
    P(OPEN_PHASE_A,     AT(BRAKING), HEAVY, OPENS, PHASE_REASONS, 6.5e-3, LIMIT, OUT, WITHOUT_CURRENT) \
    P(OPEN_PHASE_A,     AT(CATCH),  MATRIX_ENCODER_H, OPENS, PHASE_REASONS, 0.2, LIMIT, OUT, RISES_SLOWLY) \
    P(OPEN_PHASE_A,     AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, PHASE_REASONS, ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(OPEN_PHASE_B,     EVERYWHERE, BOTH, OPENS, PHASE_REASONS, SOON, LIMIT, OUT, "") \
    P(OPEN_PHASE_B,     AT(BRAKING), HEAVY, OPENS, PHASE_REASONS, 6.5e-3, LIMIT, OUT, WITHOUT_CURRENT) \
    P(OPEN_PHASE_B,     AT(CATCH),  MATRIX_ENCODER_H, OPENS, PHASE_REASONS, 0.2, LIMIT, OUT, RISES_SLOWLY) \
    P(OPEN_PHASE_B,     AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, PHASE_REASONS, ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(OPEN_PHASE_C,     EVERYWHERE, BOTH, OPENS, PHASE_REASONS, SOON, LIMIT, OUT, "") \
    P(OPEN_PHASE_C,     AT(BRAKING), HEAVY, OPENS, PHASE_REASONS, 6.5e-3, LIMIT, OUT, WITHOUT_CURRENT) \
    P(OPEN_PHASE_C,     AT(CATCH),  MATRIX_ENCODER_H, OPENS, PHASE_REASONS, 0.2, LIMIT, OUT, RISES_SLOWLY) \
    P(OPEN_PHASE_C,     AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, PHASE_REASONS, ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(SWAP_PHASES,      EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(SWAP_PHASES,      AT(CATCH),  ENCODER, OPENS, "encoder_direction", 0.5, LIMIT, OUT, "") \
    P(SWAP_PHASES,      AT(OFF),    ENCODER, OPENS, "runaway stalled", 3.0, LIMIT, OUT, HELD_IN_PLACE) \
    P(SWAP_PHASES,      AT(OFF) | AT(CATCH), SENSORLESS, RIDES, "", ANY_TIME, LIMIT, STRAYS, "the motor turns in the other direction: without the encoder this cannot be detected") \
    P(OPEN_SWITCH_A,    EVERYWHERE, BOTH, OPENS, PHASE_REASONS, SOON_IN_ITS_HALF, LIMIT, OUT, "the switch is needed in half of each electrical turn only") \
    P(OPEN_SWITCH_A,    AT(ALIGN),  SENSORLESS, OPENS, PHASE_REASONS, 0.55, LIMIT, OUT, SWINGS_IN) \
    P(OPEN_SWITCH_A,    AT(CATCH),  MATRIX_ENCODER_H, OPENS, PHASE_REASONS, 0.2, LIMIT, OUT, RISES_SLOWLY) \
    P(OPEN_SWITCH_A,    AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, PHASE_REASONS, ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(OPEN_SWITCH_B,    EVERYWHERE, BOTH, OPENS, PHASE_REASONS OR_SHUNT, SOON_IN_ITS_HALF, LIMIT, OUT, "the switch is needed in half of each electrical turn only") \
    P(OPEN_SWITCH_B,    AT(CATCH),  MATRIX_ENCODER_H, OPENS, PHASE_REASONS, 0.2, LIMIT, OUT, RISES_SLOWLY) \
    P(OPEN_SWITCH_B,    AT(CATCH),  MATRIX_ENCODER_L, RIDES | OPENS, PHASE_REASONS, ANY_TIME, LIMIT, FOLLOWS | OUT, NO_CURRENT) \
    P(SHORT_SWITCH_A,   EVERYWHERE, BOTH, OPENS, "module_fault", AT_ONCE, LIMIT, OUT, "") \
    P(SHORT_SWITCH_A,   AT(RUN_FAST) | AT(BRAKING), BOTH, OPENS, "module_fault", AT_ONCE, 30.0, OUT, "the machine is shorted through the diodes: up to 2 psi_f/L = 29 A, which no gate can switch off") \
    P(SHORT_SWITCH_A,   AT(OFF),    BOTH, OPENS | REFUSES, "module_fault gates_refused fault_present", 3e-3, LIMIT, OUT, "the leg is not switched while the bridge is off") \
    P(LEG_A_DROP,       EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(LEG_A_RESISTANCE, EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(MODULE_FAULT,     EVERYWHERE, BOTH, OPENS, "module_fault", AT_ONCE, LIMIT, OUT, "") \
    P(MODULE_FAULT,     AT(OFF),    BOTH, REFUSES | OPENS, "fault_present gates_refused module_fault", AT_ONCE, LIMIT, OUT, "") \
    P(SINK_WARM,        EVERYWHERE, BOTH, BOARD_HAS_SINK(WARNS), "sink_warm derating", 0.15, LIMIT, FOLLOWS, NO_TEMPERATURE_SENSOR) \
    P(SINK_HOT,         EVERYWHERE, BOTH, BOARD_HAS_SINK(STOPS | OPENS), "sink_hot", 0.15, LIMIT, OUT, NO_TEMPERATURE_SENSOR) \
    P(SINK_HOT,         RUNNING,    BOTH, BOARD_HAS_SINK(STOPS), "sink_hot", 0.15, LIMIT, STANDS, NO_TEMPERATURE_SENSOR) \
    P(MOTOR_HOT,        EVERYWHERE, BOTH, BOARD_HAS_MOTOR(STOPS | OPENS), "motor_hot", 0.15, LIMIT, OUT, NO_TEMPERATURE_SENSOR) \
    P(MOTOR_HOT,        RUNNING,    BOTH, BOARD_HAS_MOTOR(STOPS), "motor_hot", 0.15, LIMIT, STANDS, NO_TEMPERATURE_SENSOR) \
    P(DEMAGNETISED,     EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(DEMAGNETISED,     EVERYWHERE & ~AT(OFF), SENSORLESS, RIDES | CATCHES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    \
    P(JAM,              EVERYWHERE, SENSORLESS, OPENS, "start_stalled", 8.0, LIMIT, STANDS, "start_tries tries") \
    P(JAM,              EVERYWHERE, ENCODER, OPENS, "stalled", 3.0, LIMIT, STANDS, "stall_time") \
    P(JAM,              AT(FORCED), SENSORLESS, OPENS | RIDES, "start_stalled", 8.0, LIMIT, STANDS | STRAYS, HIDDEN_SLOW) \
    P(OVERLOAD,         EVERYWHERE, SENSORLESS, OPENS, "start_stalled", 8.0, LIMIT, STANDS, "start_tries tries") \
    P(OVERLOAD,         EVERYWHERE, ENCODER, OPENS, "stalled", 4.0, LIMIT, STANDS, "the rotor runs down, then stall_time") \
    P(OVERLOAD,         AT(FORCED), SENSORLESS, OPENS | RIDES, "start_stalled", 8.0, LIMIT, STANDS | STRAYS, HIDDEN_SLOW) \
    P(BRAKE,            EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(BRAKE,            EVERYWHERE, MATRIX_SENSORLESS_L, RIDES | CATCHES, "", ANY_TIME, LIMIT, FOLLOWS, "the bare rotor is stopped within about 10 ms and started again") \
    \
    P(BRAKE_FALLS,      EVERYWHERE, SENSORLESS, OPENS, "start_stalled", 8.0, LIMIT, STANDS, "start_tries tries") \
    P(BRAKE_FALLS,      EVERYWHERE, ENCODER, OPENS, "stalled", 4.0, LIMIT, STANDS, "the rotor runs down, then stall_time") \
    P(BRAKE_FALLS,      AT(FORCED), SENSORLESS, OPENS | RIDES, "start_stalled", 8.0, LIMIT, STANDS | STRAYS, HIDDEN_SLOW) \
    P(ENCODER_SLIPPED,  EVERYWHERE, ENCODER, OPENS, "encoder_jump", SOON, LIMIT, OUT, "") \
    P(ENCODER_SLIPPED,  AT(OFF),    ENCODER, OPENS, "encoder_mismatch runaway", 0.5, LIMIT, OUT, "without current and motion it cannot be detected") \
    P(ENCODER_SLIPPED,  EVERYWHERE, SENSORLESS, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, WITHOUT_ENCODER) \
    P(ENCODER_SLIPS,    EVERYWHERE, ENCODER, OPENS, "encoder_mismatch runaway", SOON_IN_ITS_HALF, LIMIT, OUT, "the angle is correct at first; after a third of a turn it is wrong by 36 degrees") \
    P(ENCODER_SLIPS,    AT(REVERSAL), ENCODER, OPENS, "encoder_mismatch runaway", 0.5, LIMIT, OUT, "at zero speed there is no slip yet") \
    P(ENCODER_SLIPS,    AT(RUN_SLOW), MATRIX_ENCODER_L, OPENS, "encoder_mismatch runaway stalled", 3.0, LIMIT, OUT, STANDS_AT_ONCE) \
    P(ENCODER_SLIPS,    AT(OFF),    ENCODER, OPENS, "encoder_mismatch runaway", 0.5, LIMIT, OUT, "without current and motion it cannot be detected") \
    P(ENCODER_SLIPS,    EVERYWHERE, SENSORLESS, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, WITHOUT_ENCODER) \
    P(ENCODER_STANDS,   EVERYWHERE, ENCODER, OPENS, "encoder_mismatch", SOON, LIMIT, OUT, "") \
    P(ENCODER_STANDS,   AT(RUN_SLOW), MATRIX_ENCODER_H, OPENS, "encoder_mismatch", 21e-3, LIMIT, OUT, EIGHT_MS_OF_EMF) \
    P(ENCODER_STANDS,   AT(RUN_SLOW), MATRIX_ENCODER_L, OPENS, "encoder_mismatch stalled", 3.0, LIMIT, OUT, STANDS_AT_ONCE) \
    P(ENCODER_STANDS,   AT(OFF) | AT(REVERSAL), ENCODER, OPENS, "encoder_mismatch stalled", 3.0, LIMIT, OUT, "at standstill a correct encoder does not turn either: torque without motion is reported as a stall, after its own time") \
    P(ENCODER_STANDS,   EVERYWHERE, SENSORLESS, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, WITHOUT_ENCODER) \
    P(ENCODER_TRACK,    EVERYWHERE, ENCODER, OPENS, "encoder_mismatch", SOON, LIMIT, OUT, "") \
    P(ENCODER_TRACK,    AT(RUN_SLOW), MATRIX_ENCODER_H, OPENS, "encoder_mismatch", 21e-3, LIMIT, OUT, EIGHT_MS_OF_EMF) \
    P(ENCODER_TRACK,    AT(RUN_SLOW), MATRIX_ENCODER_L, OPENS, "encoder_mismatch stalled", 3.0, LIMIT, OUT, STANDS_AT_ONCE) \
    P(ENCODER_TRACK,    AT(OFF) | AT(REVERSAL), ENCODER, OPENS, "encoder_mismatch stalled", 3.0, LIMIT, OUT, "like encoder_stands") \
    P(ENCODER_TRACK,    EVERYWHERE, SENSORLESS, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, WITHOUT_ENCODER) \
    P(ENCODER_OFFSET,   EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(ENCODER_OFFSET,   AT(OFF) | AT(CATCH), ENCODER, OPENS, "encoder_mismatch runaway", 0.5, LIMIT, OUT, "") \
    P(ENCODER_OFFSET,   AT(OFF) | AT(CATCH), SENSORLESS, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, WITHOUT_ENCODER) \
    P(ENCODER_LINES,    EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(ENCODER_LINES,    AT(CATCH),  ENCODER, OPENS, "encoder_mismatch", 0.5, LIMIT, OUT, "") \
    P(ENCODER_LINES,    AT(OFF),    ENCODER, OPENS, "encoder_mismatch stalled", 3.0, LIMIT, OUT, HELD_IN_PLACE) \
    P(ENCODER_LINES,    AT(OFF) | AT(CATCH), SENSORLESS, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, WITHOUT_ENCODER) \
    P(ENCODER_REVERSED, EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(ENCODER_REVERSED, AT(CATCH),  ENCODER, OPENS, "encoder_direction", 0.5, LIMIT, OUT, "") \
    P(ENCODER_REVERSED, AT(OFF),    ENCODER, OPENS, "encoder_direction stalled", 3.0, LIMIT, OUT, HELD_IN_PLACE) \
    P(ENCODER_REVERSED, AT(OFF) | AT(CATCH), SENSORLESS, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, WITHOUT_ENCODER) \
    P(POLE_PAIRS,       EVERYWHERE, BOTH, NEVER, "", ANY_TIME, LIMIT, OUT, WRONG_FROM_START) \
    P(POLE_PAIRS,       AT(OFF) | AT(CATCH), ENCODER, OPENS, "encoder_mismatch runaway", 0.5, LIMIT, OUT, "") \
    P(POLE_PAIRS,       AT(OFF) | AT(CATCH), SENSORLESS, RIDES, "", ANY_TIME, LIMIT, STRAYS, "the electrical values are correct, and the shaft turns at 4/5 of the speed: without the encoder this cannot be detected") \
    \
    P(DC_HIGH,          EVERYWHERE, BOTH, OPENS, "dc_overvoltage", AT_ONCE, LIMIT, OUT, "") \
    P(DC_LOW,           EVERYWHERE, BOTH, OPENS, "dc_undervoltage", 5e-3, LIMIT, OUT, "ride_through_time is 0 by default") \
    P(DC_LOW,           AT(OFF),    BOTH, REFUSES, "dc_undervoltage", AT_ONCE, LIMIT, OUT, "") \
    P(DC_SAG,           EVERYWHERE, BOTH, RIDES | WARNS, "dc_limits", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(DC_RIPPLE,        EVERYWHERE, BOTH, WARNS, "dc_ripple", 0.15, LIMIT, FOLLOWS, "") \
    P(SUPPLY_LOST,      EVERYWHERE, BOTH, OPENS | STOPS, "dc_undervoltage", ANY_TIME, LIMIT, OUT, ONE_MILLIFARAD) \
    P(SUPPLY_LOST,      EVERYWHERE, BARE, RIDES | WARNS | OPENS | STOPS, "dc_undervoltage dc_limits", ANY_TIME, LIMIT, FOLLOWS | OUT, ONE_MILLIFARAD) \
    P(SUPPLY_LOST,      AT(OFF),    BOTH, RIDES | REFUSES | OPENS | STOPS, "dc_undervoltage", ANY_TIME, LIMIT, FOLLOWS | OUT, ONE_MILLIFARAD) \
    P(SUPPLY_LOST,      AT(BRAKING), BOTH, RIDES | WARNS | OPENS | STOPS, "dc_undervoltage dc_limits", ANY_TIME, LIMIT, FOLLOWS | STRAYS | OUT, "braking must not raise the link to its trip: without a chopper the drive brakes only as fast as the losses permit") \
    P(SUPPLY_BACK,      EVERYWHERE, BOTH, RIDES | WARNS | CATCHES | OPENS, "dc_undervoltage dc_limits", ANY_TIME, LIMIT, FOLLOWS | OUT, "1 mF may last for 0.3 s; ride_through_time is 0 by default") \
    P(CHARGE_CUT,       EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(CHARGE_CUT,       AT(BRAKING), BOTH, RIDES | WARNS, "dc_limits", ANY_TIME, LIMIT, FOLLOWS | STRAYS, "braking must not raise the link to its trip: without a chopper the drive brakes only as fast as the losses permit") \
    P(BATTERY,          EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(CHOPPER_ALONE,    EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(CHOPPER_SHORTED,  EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(DC_STUCK_HIGH,    EVERYWHERE, BOTH, OPENS, "dc_overvoltage", AT_ONCE, LIMIT, OUT, "") \
    P(DC_STUCK_LOW,     EVERYWHERE, BOTH, OPENS, "dc_undervoltage", 5e-3, LIMIT, OUT, "ride_through_time is 0 by default") \
    P(DC_STUCK_LOW,     AT(OFF),    BOTH, REFUSES, "dc_undervoltage", AT_ONCE, LIMIT, OUT, "") \
    \
    P(LATE,             EVERYWHERE, BOTH, OPENS, "late", AT_ONCE, LIMIT, OUT, "") \
    P(LATE,             AT(OFF),    BOTH, REFUSES, "late", AT_ONCE, LIMIT, OUT, "") \
    P(MISSING_SAMPLE,   EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    P(MISSING_SAMPLES,  EVERYWHERE, BOTH, RIDES | CATCHES | OPENS, "late", ANY_TIME, LIMIT, FOLLOWS | OUT, "the last voltage stays for 1 ms, in which only the power module can act") \
    P(MISSING_SAMPLES,  AT(OFF),    BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "") \
    \
    P(ESTIMATE_JUMP,    EVERYWHERE, BOTH, RIDES, "", ANY_TIME, LIMIT, FOLLOWS, "control does not use the estimate, or a start resets it") \
    P(ESTIMATE_JUMP,    AT(RUN_SLOW) | AT(RUN_FAST) | AT(BRAKING), SENSORLESS, CATCHES, "", SOON, LIMIT, FOLLOWS, "") \
    P(ESTIMATE_JUMP,    AT(HANDOVER) | AT(CATCH), SENSORLESS, RIDES | CATCHES, "", SOON, LIMIT, FOLLOWS, "while control does not use the estimate yet, the loop is locked again") \
    P(ESTIMATE_JUMP,    AT(REVERSAL), SENSORLESS, RIDES | CATCHES, "", 0.5, LIMIT, FOLLOWS, "at zero speed there is no EMF that shows the fault") \
    \
    P(FLIP_FLASH,       EVERYWHERE, BOTH, OPENS, "program_corrupt", ONE_CHECK, LIMIT, OUT, BY_THE_BACKGROUND) \
    P(FLIP_CODE,        EVERYWHERE, BOTH, OPENS, "program_corrupt", ONE_CHECK, LIMIT, OUT, BY_THE_BACKGROUND) \
    P(FLIP_STACK_END,   EVERYWHERE, BOTH, OPENS, "stack_low", ONE_CHECK, LIMIT, OUT, BY_THE_BACKGROUND) \
    P(FLIP_PARAMS,      EVERYWHERE, BOTH, OPENS, "params_corrupt", ONE_CHECK, LIMIT, OUT, BY_THE_BACKGROUND) \
    \
    P(ENABLE_LOST,      EVERYWHERE, BOTH, BOARD_HAS_INPUT(STOPS), "enable_input", INPUT_DEBOUNCED, LIMIT, OUT, NO_ENABLE_INPUT) \
    P(ENABLE_LOST,      AT(OFF),    BOTH, BOARD_HAS_INPUT(REFUSES), "enable_input enable_held", INPUT_DEBOUNCED, LIMIT, OUT, NO_ENABLE_INPUT) \
    P(ENABLE_BOUNCES,   EVERYWHERE, BOTH, BOARD_HAS_INPUT(RIDES), "", ANY_TIME, LIMIT, FOLLOWS, NO_ENABLE_INPUT) \
    P(ENABLE_BOUNCES,   AT(OFF),    BOTH, BOARD_HAS_INPUT(REFUSES), "enable_held", ANY_TIME, LIMIT, OUT, INPUT_COMES_LATER)

/* ---- not yet kept ----
 *
 * N("fault/manoeuvre/source/shaft", "what is seen instead, and why")
 *   Cells that do not keep their promise yet. Remove the row of a cell that passes. */

#define MATRIX_NOT_YET(N)
/* clang-format on */

/* Index of each fault and manoeuvre. */
#define MATRIX_FAULT_INDEX(NAME, name, when, watch, lasts, what, text) MATRIX_FAULT_##NAME,
#define MATRIX_AT_INDEX(NAME, name, missing, enabled, turning, reference, load, settle, then, row, choice,   \
                        below, delay, text)                                                                  \
    MATRIX_AT_##NAME,
enum { MATRIX_FAULTS(MATRIX_FAULT_INDEX) MATRIX_FAULT_COUNT };
enum { MATRIX_MANOEUVRES(MATRIX_AT_INDEX) MATRIX_MANOEUVRE_COUNT };
#undef MATRIX_FAULT_INDEX
#undef MATRIX_AT_INDEX

#endif
