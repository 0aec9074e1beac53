/* Parameters of the plant: one table, from which struct, check and the rig's table are made.
 *
 *   P(name, unit, default, minimum, maximum, text)
 *
 * Defaults are the machine of the paper's Table I in its rig, and power stage and sensors of the board
 * (hal/board.h). Two presets for the shaft: the rig (inertia 0.0636, friction_coulomb 1.32, inferred from the
 * paper's transients) is the default; the bare motor of Table I is inertia 0.003 with the same friction or
 * none.
 * An ideal inverter has all rows from turn_on_delay to fault_pulse at 0. */
#ifndef HOST_SIM_PLANT_PLANT_PARAMS_H
#define HOST_SIM_PLANT_PLANT_PARAMS_H

#include <stdbool.h>

#include "hal/board.h"

/* clang-format off */
#define PLANT_PARAMS(P) \
    P(pole_pairs,            "-",        4.0,     1.0,    64.0,   "pole pairs p, whole number") \
    P(resistance,            "ohm",      0.95,    0.0,    100.0,  "stator resistance R per phase") \
    P(inductance_d,          "H",        0.0125,  1e-5,   1.0,    "inductance L_d") \
    P(inductance_q,          "H",        0.0125,  1e-5,   1.0,    "inductance L_q") \
    P(flux_linkage,          "Wb",       0.183,   0.0,    10.0,   "flux of the magnets psi_f, peak, phase to star point") \
    P(emf_5th,               "-",        0.0,     -0.5,   0.5,    "5th harmonic of the phase EMF, relative to the fundamental") \
    P(emf_7th,               "-",        0.0,     -0.5,   0.5,    "7th harmonic of the phase EMF, relative to the fundamental") \
    P(inertia,               "kg m^2",   0.0636,  1e-6,   1e3,    "everything that turns; 0.0636 the paper's rig, 0.003 the bare motor") \
    P(friction_coulomb,      "N m",      1.32,    0.0,    1e3,    "dry friction") \
    P(friction_viscous,      "N m s/rad", 0.0,    0.0,    1e2,    "friction that grows with speed") \
    P(load_kind,             "-",        0.0,     0.0,    1.0,    "0 passive: load opposes motion; 1 active: load has a constant sign") \
    P(load_torque,           "N m",      0.0,     -1e4,   1e4,    "load; active and positive drives backwards; passive needs >= 0") \
    P(shaft_locked,          "-",        0.0,     0.0,    1.0,    "1: a dynamometer holds shaft_locked_speed whatever the torque") \
    P(shaft_locked_speed,    "rad/s",    0.0,     -1e4,   1e4,    "speed of the locked shaft, mechanical") \
    P(dc_voltage,            "V",        BOARD_VOLTS(BOARD_DC_NOMINAL_MV),   0.0,    1000.0, "source of the DC link, open-circuit") \
    P(dc_resistance,         "ohm",      0.0,     0.0,    100.0,  "between source and capacitor; current flows one way; 0: stiff link") \
    P(dc_capacitance,        "F",        0.0,     0.0,    1.0,    "DC link; 0: stiff link") \
    P(turn_on_delay,         "s",        BOARD_TURN_ON_DELAY_NS / 1e9,  0.0,    5e-6,   "command edge to the switched voltage, opto included") \
    P(turn_off_delay,        "s",        BOARD_TURN_OFF_DELAY_NS / 1e9,  0.0,    5e-6,   "command edge to the switched voltage, opto included") \
    P(igbt_voltage,          "V",        BOARD_IGBT_DROP_MV / 1e3,   0.0,    10.0,   "on-state drop at no current, straight-line model") \
    P(igbt_resistance,       "ohm",      BOARD_IGBT_SLOPE_UOHM / 1e6,   0.0,    1.0,    "slope of the on-state drop") \
    P(diode_voltage,         "V",        BOARD_DIODE_DROP_MV / 1e3,   0.0,    10.0,   "diode drop at no current, straight-line model") \
    P(diode_resistance,      "ohm",      BOARD_DIODE_SLOPE_UOHM / 1e6,   0.0,    1.0,    "slope of the diode drop") \
    P(current_zone,          "A",        0.05,    0.0,    5.0,    "half width of the soft passage of a leg through zero current") \
    P(short_circuit_current, "A",        BOARD_SHORT_CIRCUIT_TRIP_MA / 1e3,   0.0,    1e4,    "an arm that carries more shuts itself; 0: module without protection") \
    P(fault_pulse,           "s",        1.8e-3,  0.0,    1.0,    "shortest time the fault output stays active") \
    P(current_range,         "A",        BOARD_CURRENT_OVER(1500.0f), -1e4, 1e4, "current sensors: amperes that move the pin by 1.5 V; negative: they invert") \
    P(current_gain_error_a,  "-",        0.0,     -0.5,   0.5,    "sensor of phase a reads (1 + this) times the current") \
    P(current_gain_error_b,  "-",        0.0,     -0.5,   0.5,    "sensor of phase b reads (1 + this) times the current") \
    P(current_offset_a,      "A",        0.0,     -100.0, 100.0,  "added by the sensor of phase a") \
    P(current_offset_b,      "A",        0.0,     -100.0, 100.0,  "added by the sensor of phase b") \
    P(current_noise,         "A",        0.01,    0.0,    10.0,   "noise of each current sample, rms") \
    P(current_bandwidth,     "rad/s",    0.0,     0.0,    1e8,    "first-order lag of the current sensors; 0: none") \
    P(dc_range,              "V",        BOARD_DC_AT_3V,   1.0,    1e4,    "DC-link sensor: 0 .. range is 0 .. 3 V") \
    P(dc_gain_error,         "-",        0.0,     -0.5,   0.5,    "DC-link sensor reads (1 + this) times the voltage") \
    P(dc_noise,              "V",        0.0,     0.0,    100.0,  "noise of each DC-link sample, rms") \
    P(sink_temperature,      "degC",     40.0,    -50.0,  150.0,  "heat sink") \
    P(motor_temperature,     "degC",     40.0,    -50.0,  150.0,  "winding") \
    P(encoder_lines,         "-",        2500.0,  1.0,    1e6,    "lines per turn, four counts each, whole number") \
    P(encoder_offset,        "rad",      0.0,     -100.0, 100.0,  "reading of the encoder at rotor angle 0, mechanical") \
    P(open_phase_a,          "-",        0.0,     0.0,    1.0,    "1: the wire of phase a is broken") \
    P(open_phase_b,          "-",        0.0,     0.0,    1.0,    "1: the wire of phase b is broken") \
    P(open_phase_c,          "-",        0.0,     0.0,    1.0,    "1: the wire of phase c is broken") \
    P(force_fault,           "-",        0.0,     0.0,    1.0,    "1: control supply too low: all arms shut, fault output active") \
    P(current_zero,          "V",        BOARD_CURRENT_ZERO_MV / 1e3, 0.0, 3.0, "pin of the current sensors at no current") \
    P(current_gain_error_c,  "-",        0.0,     -0.5,   0.5,    "sensor of phase c, where there is one, reads (1 + this) times the current") \
    P(current_offset_c,      "A",        0.0,     -100.0, 100.0,  "added by the sensor of phase c, where there is one") \
    P(friction_breakaway,    "N m",      0.0,     0.0,    1e3,    "holds the standing shaft up to this, passive load on top; at least friction_coulomb; 0: off, friction is smooth about zero speed")
/* clang-format on */

/* load_kind */
#define PLANT_LOAD_PASSIVE 0.0
#define PLANT_LOAD_ACTIVE  1.0

/* All fields double, in the order and units of the table. */
typedef struct {
#define PLANT_PARAMS_FIELD(name, unit, standard, minimum, maximum, text)                                     \
    double name; /* [unit of the table] */
    PLANT_PARAMS(PLANT_PARAMS_FIELD)
#undef PLANT_PARAMS_FIELD
} plant_params_t;

/* The first rule that a parameter set breaks. */
typedef struct {
    const char *field; /* name in the table */
    const char *rule;  /* what is asked, in words */
    double value;      /* [unit of the field] what was given */
    double minimum;    /* [unit of the field] smallest value accepted */
    double maximum;    /* [unit of the field] largest value accepted */
} plant_params_error_t;

/* The defaults of the table. */
plant_params_t plant_params_default(void);

/* true if every value is in its range, whole where it counts something, and the cross-rules hold (a passive
 * load is not negative; break-away is 0 or no less than dry friction). Otherwise false and *why says what is
 * wrong; why may be NULL. Not a number is out of range. */
bool plant_params_check(const plant_params_t *params, plant_params_error_t *why);

#endif
