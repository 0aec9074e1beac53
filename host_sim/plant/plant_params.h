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
    P(inertia,               "kg m^2",   0.0636,  1e-6,   1e3,    "inertia of everything that turns; 0.0636: the paper's rig, 0.003: the bare motor") \
    P(friction_coulomb,      "N m",      1.32,    0.0,    1e3,    "dry friction") \
    P(friction_viscous,      "N m s/rad", 0.0,    0.0,    1e2,    "friction that grows with speed") \
    P(load_kind,             "-",        0.0,     0.0,    1.0,    "0 passive: load opposes motion; 1 active: load has a constant sign") \
    P(load_torque,           "N m",      0.0,     -1e4,   1e4,    "load; active and positive drives backwards; passive needs >= 0") \
    P(shaft_locked,          "-",        0.0,     0.0,    1.0,    "1: a dynamometer holds shaft_locked_speed at any torque") \
    P(shaft_locked_speed,    "rad/s",    0.0,     -1e4,   1e4,    "speed of the locked shaft, mechanical") \
    P(dc_voltage,            "V",        BOARD_VOLTS(BOARD_DC_NOMINAL_MV),   0.0,    1000.0, "source of the DC link, open-circuit") \
    P(dc_resistance,         "ohm",      0.0,     0.0,    100.0,  "between source and capacitor; current flows one way unless dc_returns is 1; 0: stiff link") \
    P(dc_capacitance,        "F",        0.0,     0.0,    1.0,    "DC link; 0: stiff link") \
    P(turn_on_delay,         "s",        BOARD_TURN_ON_DELAY_NS / 1e9,  0.0,    5e-6,   "command edge to the switched voltage, opto included") \
    P(turn_off_delay,        "s",        BOARD_TURN_OFF_DELAY_NS / 1e9,  0.0,    5e-6,   "command edge to the switched voltage, opto included") \
    P(igbt_voltage,          "V",        BOARD_IGBT_DROP_MV / 1e3,   0.0,    10.0,   "on-state drop at no current, straight-line model") \
    P(igbt_resistance,       "ohm",      BOARD_IGBT_SLOPE_UOHM / 1e6,   0.0,    1.0,    "slope of the on-state drop") \
    P(diode_voltage,         "V",        BOARD_DIODE_DROP_MV / 1e3,   0.0,    10.0,   "diode drop at no current, straight-line model") \
    P(diode_resistance,      "ohm",      BOARD_DIODE_SLOPE_UOHM / 1e6,   0.0,    1.0,    "slope of the diode drop") \
    P(current_zone,          "A",        0.05,    0.0,    5.0,    "half width of the soft passage of a leg through zero current") \
    P(short_circuit_current, "A",        BOARD_SHORT_CIRCUIT_TRIP_MA / 1e3,   0.0,    1e4,    "a switch with more current turns itself off; 0: module without protection") \
    P(fault_pulse,           "s",        1.8e-3,  0.0,    1.0,    "shortest time for which the fault output stays active") \
    P(current_range,         "A",        BOARD_CURRENT_OVER(1500.0f), -1e4, 1e4, "current sensors: current that changes the pin by 1.5 V; negative: inverting") \
    P(current_gain_error_a,  "-",        0.0,     -2.0,   0.5,    "sensor of phase a reads (1 + this) times the current; -2: wired the wrong way") \
    P(current_gain_error_b,  "-",        0.0,     -2.0,   0.5,    "sensor of phase b reads (1 + this) times the current; -2: wired the wrong way") \
    P(current_offset_a,      "A",        0.0,     -100.0, 100.0,  "offset of the current sensor of phase a") \
    P(current_offset_b,      "A",        0.0,     -100.0, 100.0,  "offset of the current sensor of phase b") \
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
    P(force_fault,           "-",        0.0,     0.0,    1.0,    "1: control supply too low: all switches off, fault output active") \
    P(current_zero,          "V",        BOARD_CURRENT_ZERO_MV / 1e3, 0.0, 3.0, "pin voltage of the current sensors without current") \
    P(current_gain_error_c,  "-",        0.0,     -2.0,   0.5,    "sensor of phase c, where there is one, reads (1 + this) times the current; -2: wired the wrong way") \
    P(current_offset_c,      "A",        0.0,     -100.0, 100.0,  "offset of the current sensor of phase c, if there is one") \
    P(friction_breakaway,    "N m",      0.0,     0.0,    1e3,    "friction up to which the shaft stays at rest, plus a passive load; at least friction_coulomb; 0: off, friction is smooth about zero speed") \
    P(leg_a_drop,            "V",        0.0,     0.0,    50.0,   "added to the drops of both IGBTs and both diodes of leg a") \
    P(leg_b_drop,            "V",        0.0,     0.0,    50.0,   "added to the drops of both IGBTs and both diodes of leg b") \
    P(leg_c_drop,            "V",        0.0,     0.0,    50.0,   "added to the drops of both IGBTs and both diodes of leg c") \
    P(leg_a_resistance,      "ohm",      0.0,     0.0,    10.0,   "resistance in series with leg a: a bad contact, an unequal winding") \
    P(leg_b_resistance,      "ohm",      0.0,     0.0,    10.0,   "resistance in series with leg b") \
    P(leg_c_resistance,      "ohm",      0.0,     0.0,    10.0,   "resistance in series with leg c") \
    P(leg_a_delay,           "s",        0.0,     0.0,    5e-6,   "added to the turn-on delay of both IGBTs of leg a") \
    P(leg_b_delay,           "s",        0.0,     0.0,    5e-6,   "added to the turn-on delay of both IGBTs of leg b") \
    P(leg_c_delay,           "s",        0.0,     0.0,    5e-6,   "added to the turn-on delay of both IGBTs of leg c") \
    P(open_switches,         "-",        0.0,     0.0,    63.0,   "IGBTs that never conduct, while their diodes do: sum of 1 upper a, 2 lower a, 4 upper b, 8 lower b, 16 upper c, 32 lower c") \
    P(shorted_switches,      "-",        0.0,     0.0,    63.0,   "IGBTs that always conduct, independent of gate and protection; sum as for open_switches") \
    P(swap_phases,           "-",        0.0,     0.0,    3.0,    "motor wires exchanged behind the current sensors: 1 b with c, 2 c with a, 3 a with b") \
    P(swap_currents,         "-",        0.0,     0.0,    5.0,    "signals of the current sensors exchanged: 1 b with c, 2 c with a, 3 a with b, 4 each has that of the next phase, 5 of the one before") \
    P(encoder_reversed,      "-",        0.0,     0.0,    1.0,    "1: tracks A and B are exchanged; from then on the encoder counts the other way") \
    P(encoder_slip,          "-",        0.0,     0.0,    1.0,    "share of the rotor's motion that the encoder misses (lost lines, slipping coupling); 1: all of it") \
    P(encoder_stuck_a,       "-",        -1.0,    -1.0,   1.0,    "constant level of track A; -1: none") \
    P(encoder_stuck_b,       "-",        -1.0,    -1.0,   1.0,    "constant level of track B; -1: none") \
    P(dc_ripple,             "V",        0.0,     0.0,    500.0,  "amplitude of a sine on dc_voltage, rising from 0 when it is set") \
    P(dc_ripple_frequency,   "rad/s",    1884.9556, 0.0,  6e4,    "frequency of dc_ripple; default: 6-pulse rectifier on 50 Hz") \
    P(supply_lost,           "-",        0.0,     0.0,    1.0,    "1: the supply no longer feeds the link's capacitor") \
    P(chopper_resistance,    "ohm",      0.0,     0.0,    1e4,    "brake resistor across a soft link while its voltage is above chopper_voltage; 0: none") \
    P(chopper_voltage,       "V",        400.0,   0.0,    1000.0, "DC-link voltage above which chopper_resistance is connected") \
    P(load_inertia,          "kg m^2",   0.0,     0.0,    1e3,    "inertia at the other end of the shaft, where load_torque acts; adds to inertia if the shaft is rigid") \
    P(shaft_stiffness,       "N m/rad",  0.0,     0.0,    1e7,    "stiffness of the shaft between inertia and load_inertia; 0: rigid") \
    P(shaft_damping,         "N m s/rad", 0.0,    0.0,    1e3,    "damping of the torsion of the same shaft") \
    P(load_quadratic,        "N m s^2/rad^2", 0.0, 0.0,   1e2,    "load that opposes motion and grows with the square of the speed: a fan, a pump") \
    P(load_sine,             "N m",      0.0,     -1e4,   1e4,    "amplitude of a load that is a sine of the shaft's angle: a piston") \
    P(load_sine_cycles,      "-",        1.0,     1.0,    100.0,  "periods of load_sine per turn, whole number") \
    P(load_spring,           "N m/rad",  0.0,     0.0,    1e6,    "spring that pulls the shaft back to angle 0") \
    P(load_table_speed,      "rad/s",    0.0,     0.0,    1e4,    "mechanical speed between the points of a table: load_table_1 at this speed, load_table_2 at twice this speed; 0: no table") \
    P(load_table_1,          "N m",      0.0,     -1e4,   1e4,    "load against motion at load_table_speed; linear between the points, none at standstill") \
    P(load_table_2,          "N m",      0.0,     -1e4,   1e4,    "load at twice load_table_speed") \
    P(load_table_3,          "N m",      0.0,     -1e4,   1e4,    "load at three times load_table_speed") \
    P(load_table_4,          "N m",      0.0,     -1e4,   1e4,    "load at four times load_table_speed") \
    P(load_table_5,          "N m",      0.0,     -1e4,   1e4,    "load at five times load_table_speed") \
    P(load_table_6,          "N m",      0.0,     -1e4,   1e4,    "load at six times load_table_speed and above") \
    P(saturation_d,          "A",        0.0,     0.0,    1e4,    "current I_s at which the flux of i_d is inductance_d i_d/sqrt(1 + (i_d/I_s)^2), 1/sqrt 2 of the unsaturated one; 0: no saturation, else 1 A at least") \
    P(saturation_q,          "A",        0.0,     0.0,    1e4,    "the same of i_q and inductance_q") \
    P(flux_map,              "-",        0.0,     0.0,    32.0,   "number of a flux map, psi_d and psi_q over i_d and i_q, in place of inductances and saturation; in a scenario the name of its CSV file; 0: none") \
    P(iron_loss_resistance,  "ohm",      0.0,     0.0,    1e6,    "resistance R_c of the iron: the loss 1.5 (omega_e psi)^2/R_c by a current omega_e psi/R_c along the EMF; 0: no loss, else 10 ohm at least") \
    P(chopper_driven,        "-",        0.0,     0.0,    1.0,    "1: the chopper output of the board connects chopper_resistance; 0: chopper_voltage does") \
    P(holding_torque,        "N m",      0.0,     0.0,    1e4,    "torque of the holding brake on the brake output of the board, set by a spring; 0: none") \
    P(holding_release_time,  "s",        0.05,    0.0,    5.0,    "from the brake output until the holding brake is free") \
    P(holding_apply_time,    "s",        0.03,    0.0,    5.0,    "from the end of the brake output until the holding brake holds") \
    P(dc_returns,            "-",        0.0,     0.0,    1.0,    "1: the source of a soft link takes current as well, as a battery does; 0: a rectifier, or a battery that has cut off its charging")
/* clang-format on */

/* load_kind */
#define PLANT_LOAD_PASSIVE 0.0
#define PLANT_LOAD_ACTIVE  1.0

#define PLANT_SATURATION_LEAST 1.0  /* [A] smallest current of saturation that is not 0 */
#define PLANT_IRON_LEAST       10.0 /* [ohm] smallest resistance of the iron that is not 0 */

#define PLANT_SHAFT_FASTEST                                                                                  \
    1e5 /* [rad/s] largest natural frequency or decay of the twist of an elastic shaft */

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
    const char *rule;  /* the rule as text */
    double value;      /* [unit of the field] value of the field */
    double minimum;    /* [unit of the field] smallest value accepted */
    double maximum;    /* [unit of the field] largest value accepted */
} plant_params_error_t;

/* The defaults of the table. */
plant_params_t plant_params_default(void);

/* true: every value is in its range, numbers that count something are whole, and the rules between values
 * hold. A passive load is not negative. The break-away torque is 0 or at least the dry friction. No switch is
 * both open and shorted. A lost supply requires a capacitor. flux_linkage is that of the flux map within 1 %.
 * The natural frequency of an elastic shaft does not exceed PLANT_SHAFT_FASTEST. Otherwise false and *why has
 * the message; why may be NULL. A value that is not a number (NaN) is out of range. */
bool plant_params_check(const plant_params_t *params, plant_params_error_t *why);

#endif
