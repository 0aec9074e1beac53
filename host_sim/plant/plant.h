/* The world around the chip: inverter, motor, shaft, sensors, in double precision.
 *
 * Motor (rotor frame, amplitude-invariant, star point free; theta_e = p theta_m is the angle of the d axis
 * to phase a):
 *
 *   L_d di_d/dt = u_d - R i_d + omega_e L_q i_q - e_d,   e_d = -omega_e psi_f (k_5 + k_7) sin 6 theta_e
 *   L_q di_q/dt = u_q - R i_q - omega_e L_d i_d - e_q,   e_q =  omega_e psi_f (1 + (k_7 - k_5) cos 6 theta_e)
 *   T = 1.5 p ((e_d i_d + e_q i_q)/omega_e + (L_d - L_q) i_d i_q)
 *
 * The EMF of phase a is then -omega_e psi_f (sin theta + k_5 sin 5 theta + k_7 sin 7 theta). With
 * saturation_d or saturation_q the flux of an axis is L i/sqrt(1 + (i/I_s)^2), and its derivative with
 * respect to the current is L/(1 + (i/I_s)^2)^1.5, which stays constant from 3 I_s on. In the equations above
 * omega_e L i is replaced by omega_e times this flux. The axes do not influence each other (magnetics.h).
 *
 * With iron_loss_resistance R_c the currents of these equations are those that produce flux and torque. In
 * addition the phases carry omega_e psi/R_c along the EMF (iron.h), with the loss 1.5 (omega_e psi)^2/R_c.
 * The legs, the sensors and R carry the sum.
 *
 * Shaft: J domega/dt = T - (T_c + T_passive) s(omega) - B omega - T_active, with a smooth sign s = x (3 -
 * x^2)/2, x = omega/w, limited to +-1. w is PLANT_SHAFT_WIDTH, or PLANT_SHAFT_FOLLOW (T_c + T_passive)/J if
 * that is more, for rotors that are too light for the step of the integration. With a torque below T_c this
 * rotor turns slowly, below w, while a real rotor does not turn. The driven machine adds T_work = k omega
 * |omega| + T_table(omega) + T_sine sin(n theta) + c theta, where theta is the angle of the load. Dry
 * friction holds a rotor at standstill while T - T_active - T_work does not exceed it. With a break-away
 * torque T_b or a brake, T_c + T_passive + T_brake acts with the exact sign of the motion. A rotor at
 * standstill is then held exactly until |T - T_active| exceeds max(T_b, T_c) + T_passive + T_brake. It stops
 * and starts at a tick.
 *
 * With load_inertia and shaft_stiffness there are two masses, twist' = omega - omega_load:
 *
 *   J domega/dt = T - T_friction - T_brake - T_s,   T_s = k twist + c (omega - omega_load)
 *   J_load domega_load/dt = T_s - T_passive s(omega_load) - T_active
 *
 * Friction and brake act at the motor, and the load acts at the other end. Without stiffness J + J_load are
 * one mass.
 *
 * Inverter (docs/theory.md, 12): the pole voltage of a leg follows from its two gates and the sign of its
 * current. Upper on: V_dc - V_ce(i) or V_dc + V_f(|i|). Lower on: -V_f(i) or +V_ce(|i|). Both off: lower
 * diode for i > 0, upper diode for i < 0. Between -current_zone and +current_zone each of these voltages
 * changes linearly from one value to the other. With both gates off this models the charge of the node,
 * otherwise it rounds the knee of the voltage drops. The zone is never narrower than (V_dc/2 + V_f) 1
 * us/min(L_d, L_q), because the steps of the integration cannot resolve less. Command edges act after
 * turn_on_delay or turn_off_delay. A pulse or gap whose end would occur before its beginning is omitted, and
 * so is one that would be the fifth edge of its gate within a delay. If all three legs are off, all currents
 * are inside the zone for PLANT_IDLE_TICKS and the EMF between lines is below V_dc + 2 V_f, the currents are
 * zero until a gate turns on or the EMF rises. Both on: shoot-through, counted; the pole voltage is V_dc/2
 * until the protection acts. An open switch never conducts. A shorted switch always conducts, and is not
 * switched off by the protection; when the other switch of the leg turns on, this is a shoot-through. Both
 * have an effect with gate edges only, not in averaged mode. DC link: constant voltage, or a capacitor behind
 * a resistance and a rectifier (no current to the source) or a battery (dc_returns), with a chopper across
 * it, which switches by itself or by the output of the board. The source is a constant voltage plus a sine.
 *
 * Protection of the module, as in Mitsubishi's L series (data sheet of PM50B5LA060; the return to operation
 * is assumed): a switch with more than short_circuit_current, or with a shoot-through, is switched off. A
 * lower switch also switches off the other two lower ones, which share its driver supply and fault output.
 * The fault line is active for fault_pulse. A switch follows its commands again after the pulse and a new
 * off-on edge. force_fault switches off all switches and keeps the line active. In averaged mode any trip
 * switches off all switches until the first carrier period after the pulse.
 *
 * Averaged mode: one mean pole voltage per leg and carrier period. It follows from V_dc high/period, dead
 * time, delays and drops, with the current at each of the two edges, including the ripple (averaged.h).
 *
 * Time: ticks of 1/150 MHz. Bits are the same on every machine (IEEE double, no contraction; of libm only
 * sqrt, fabs, floor, ceil, ldexp).
 *
 * Not handled: iron loss while a wire is broken, iron loss by ripple, hysteresis, switching energy, heating
 * (temperatures are parameters), the current of a shoot-through in the IGBTs, the 0.2 us until a short
 * circuit is switched off, over-temperature, a floating node when only one or two legs are off (a current up
 * to the zone's width flows). */
#ifndef HOST_SIM_PLANT_PLANT_H
#define HOST_SIM_PLANT_PLANT_H

#include <stdbool.h>
#include <stdint.h>

#include "host_sim/plant/plant_params.h"

#define PLANT_TICKS_PER_SECOND UINT64_C(150000000)
#define PLANT_NEVER            UINT64_MAX
#define PLANT_SHAFT_WIDTH      0.2 /* [rad/s] mechanical, least half width of the smooth sign */
#define PLANT_SHAFT_FOLLOW                                                                                   \
    2e-4 /* [s] keeps the integration with the smooth sign stable: 0.75 per step of 100 us */
#define PLANT_IDLE_TICKS UINT64_C(7500) /* 50 us */

/* Gate bits, as in plant_gates(). */
#define PLANT_UPPER(leg) (UINT32_C(1) << (2u * (uint32_t)(leg)))
#define PLANT_LOWER(leg) (UINT32_C(2) << (2u * (uint32_t)(leg)))

typedef enum {
    PLANT_CURRENT_A,
    PLANT_CURRENT_B,
    PLANT_CURRENT_C,
    PLANT_DC_LINK,
    PLANT_SINK,
    PLANT_MOTOR
} plant_channel_t;

/* The device that carries a leg's current. */
typedef enum {
    PLANT_LEG_OPEN, /* none: no current, or the phase is broken */
    PLANT_LEG_UPPER_IGBT,
    PLANT_LEG_UPPER_DIODE,
    PLANT_LEG_LOWER_IGBT,
    PLANT_LEG_LOWER_DIODE,
    PLANT_LEG_ZONE,          /* |i| inside the zone around zero */
    PLANT_LEG_SHOOT_THROUGH, /* both IGBTs */
    PLANT_LEG_AVERAGED       /* averaged mode: upper and lower share the period */
} plant_leg_t;

/* The true values, which the drive does not get. */
typedef struct {
    double theta_e;         /* [rad] electrical, in [-pi, pi) */
    double omega_e;         /* [rad/s] electrical */
    double theta_m;         /* [rad] mechanical, unwrapped */
    double omega_m;         /* [rad/s] mechanical */
    double torque;          /* T [N m] air gap */
    double load_torque;     /* [N m] friction, load and brake together, positive against positive rotation */
    double i_a, i_b, i_c;   /* [A] into the motor */
    double i_d, i_q;        /* [A] rotor frame */
    double u_alpha, u_beta; /* [V] motor voltage now */
    double flux_alpha; /* [V s] integral of u_alpha since init: differences over a period give its mean */
    double flux_beta;  /* [V s] integral of u_beta since init */
    double dc_voltage; /* V_dc [V] */
    double leg_a, leg_b, leg_c;  /* plant_leg_t [-] */
    double shoot_throughs;       /* [-] number of times that both switches of a leg were on */
    double shoot_through_second; /* [s] time of the last one; -1: none */
    double shoot_through_leg;    /* [-] leg of the last one, 0..2; -1: none */
    double fault_line;           /* [-] 1: fault output active */
    double shut_gates;           /* [-] gates that the module has switched off, bits as in plant_gates() */
    double energy_dc;            /* [J] from the link into the inverter, since metering was switched on */
    double energy_copper;        /* [J] into R and iron, since then */
    double energy_inverter;      /* [J] conduction losses, since then */
    double energy_mechanical;    /* [J] into friction, load, brake and dynamometer, since then */
    double energy_magnetic; /* [J] stored in the field of the currents; without saturation 0.75 (L_d i_d^2 +
                               L_q i_q^2) */
    double energy_kinetic;  /* [J] stored now, J omega_m^2/2 of both masses, and energy of the twist */
    double omega_load;      /* [rad/s] mechanical speed of the load; omega_m if the shaft is rigid */
    double twist;           /* [rad] of an elastic shaft, the motor ahead */
    double shaft_torque;    /* [N m] from the motor into an elastic shaft */
} plant_truth_t;

/* The whole plant: it can be copied with memcpy, and has no pointers and no padding. The fields are visible
 * for the debugger. */
#include "host_sim/plant/plant_state.h"

/* Sets the state of tick 0: all gates off, no current, rotor at angle 0 and at standstill (or at the locked
 * speed), link charged, metering off. params must pass plant_params_check (asserted). The seed determines
 * every noise sample. */
void plant_init(plant_t *plant, const plant_params_t *params, uint64_t seed);

/* Changes the parameters and keeps the state. A locked shaft jumps to its speed, a phase that breaks loses
 * its current, a constant link voltage jumps. Delays act on edges that are commanded from now on. In averaged
 * mode differences of a leg act from the next carrier period on. Encoder: a change of slip, stuck tracks or
 * direction makes no step, except for the edge of a track that sticks at its other level. A new offset is a
 * step, as of a disc that slips. */
void plant_set_params(plant_t *plant, const plant_params_t *params);

/* Sets angle [rad] and speed [rad/s] of the rotor, mechanical; the phase currents remain. A locked shaft
 * keeps its speed. */
void plant_set_motion(plant_t *plant, double theta_m, double omega_m);

/* Sets the torque [N m] of a brake on the shaft, >= 0 (asserted); 0: released. The brake acts like dry
 * friction. It has no effect on a locked shaft. */
void plant_set_brake(plant_t *plant, double torque);

/* Outputs of the board at this tick, at which the plant must be: the chopper connects its resistor, where
 * chopper_driven says so, and the holding brake is released or set, which happens at the first call after its
 * release or apply time. To be called at least once in a period. */
void plant_outputs(plant_t *plant, bool chopper, bool released);

/* on: counts the energies from zero, which takes computing time; off after init. The energies satisfy dc =
 * copper + inverter + mechanical + change of magnetic + change of kinetic, unless motion or parameters are
 * set from outside. */
void plant_set_metering(plant_t *plant, bool on);

/* Six switch commands from this tick on: PLANT_UPPER(n), PLANT_LOWER(n), n = 0..2. The ticks of the calls
 * must ascend. The state remains at the last edge that changed a voltage until plant_advance. The call ends
 * averaged mode; its commands then act without delay. */
void plant_gates(plant_t *plant, uint64_t tick, uint32_t on);

/* Averaged mode from this tick on. In each `period` ticks the upper command of leg n is on for high[n] ticks,
 * before the dead band of `dead` ticks at each rising edge. high = 0 or period: no edges and no error. upper:
 * the command is on at both ends of the period, otherwise around its middle. The values are valid until the
 * next call of this function or of plant_gates. period > 0 (asserted). The call advances the plant to the
 * tick, and cancels pending edges. */
void plant_carrier(plant_t *plant, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                   bool upper);

/* Advances the plant to the tick; a tick in the past has no effect. It takes about 40 ns for each interval
 * between edges that change a voltage, or for 100 us. The currents are within 1 mA of the exact solution for
 * omega_e 100 us < 0.3. */
void plant_advance(plant_t *plant, uint64_t tick);

/* Voltage at the ADC pin at the present tick, 0..3 V, with noise that is new in each call. The call does not
 * advance the plant: channels that are sampled within a microsecond may share one plant_advance. */
double plant_analog(plant_t *plant, plant_channel_t channel);

/* The encoder's position at the present tick [counts], without a limit: floor(4 lines (theta_m + offset)/(2
 * pi)), minus the missed counts, with the faults of the tracks. */
int64_t plant_encoder(const plant_t *plant);

/* The same at a tick near the present one, without advancing the plant: the angle is extrapolated with the
 * present speed. Within a period the error is less than 0.05 counts, for 10000 counts a turn and 4000
 * rad/s^2. */
int64_t plant_encoder_at(const plant_t *plant, uint64_t tick);

/* true while a fault output of the power module is active; the outputs share one line. */
bool plant_fault_line(const plant_t *plant);

/* Reads all true values at the present tick. It takes about 100 ns, which is too slow for every period. */
void plant_truth(const plant_t *plant, plant_truth_t *truth);

const char *plant_leg_text(plant_leg_t leg); /* "upper diode" */

#endif
