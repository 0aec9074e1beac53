/* The world around the chip: inverter, motor, shaft, sensors, in double precision.
 *
 * Motor (rotor frame, amplitude-invariant, star point free; theta_e = p theta_m is the angle of the d axis
 * to phase a):
 *
 *   L_d di_d/dt = u_d - R i_d + omega_e L_q i_q - e_d,   e_d = -omega_e psi_f (k_5 + k_7) sin 6 theta_e
 *   L_q di_q/dt = u_q - R i_q - omega_e L_d i_d - e_q,   e_q =  omega_e psi_f (1 + (k_7 - k_5) cos 6 theta_e)
 *   T = 1.5 p ((e_d i_d + e_q i_q)/omega_e + (L_d - L_q) i_d i_q)
 *
 * With saturation_d or saturation_q the flux of an axis is L i/sqrt(1 + (i/I_s)^2), its derivative by the
 * current L/(1 + (i/I_s)^2)^1.5, and omega_e L i above is omega_e times that flux; the axes do not act on
 * each other (magnetics.h). So the EMF of phase a is -omega_e psi_f (sin theta + k_5 sin 5 theta + k_7 sin 7
 * theta).
 *
 * With iron_loss_resistance R_c the currents of these equations are those that make flux and torque. The
 * phases carry omega_e psi/R_c along the EMF beside them (iron.h), with the loss 1.5 (omega_e psi)^2/R_c; the
 * legs, the sensors and R see the sum.
 *
 * Shaft: J domega/dt = T - (T_c + T_passive) s(omega) - B omega - T_active, with a smooth sign that lets a
 * standstill rest: s = x (3 - x^2)/2, x = omega/w, limited to +-1 beyond w. w is PLANT_SHAFT_WIDTH, or
 * PLANT_SHAFT_FOLLOW (T_c + T_passive)/J where that is more (a lighter rotor than a step can follow). A
 * torque below T_c therefore makes the rotor creep, slower than w, where a real one would stick.
 * Of what drives the load, T_work = k omega |omega| + T_table(omega) + T_sine sin(n theta) + c theta comes on
 * top, theta being the angle of the end that the load is at; a rotor that stands is held while T - T_active -
 * T_work is not more than dry friction holds. With a break-away torque T_b or a brake, T_c + T_passive +
 * T_brake acts at once with the sign of the motion, and a rotor that stands is held, exactly, until |T -
 * T_active| exceeds max(T_b, T_c) + T_passive + T_brake. It comes to rest and breaks loose at a tick.
 *
 * With load_inertia and shaft_stiffness there are two masses, twist' = omega - omega_load:
 *
 *   J domega/dt = T - T_friction - T_brake - T_s,   T_s = k twist + c (omega - omega_load)
 *   J_load domega_load/dt = T_s - T_passive s(omega_load) - T_active
 *
 * Friction and brake act at the motor, the load at the far end. Without stiffness J + J_load turn as one.
 *
 * Inverter (docs/theory.md, 12): a leg's pole voltage follows from its two gates and
 * the sign of its current. Upper on: V_dc - V_ce(i) or V_dc + V_f(|i|). Lower on: -V_f(i) or +V_ce(|i|).
 * Both off: lower diode for i > 0, upper diode for i < 0. Between -current_zone and +current_zone each of
 * these goes linearly from the one value to the other: for both gates off this stands for the charge of the
 * node, for the others it rounds the knee of the drops. The zone is never narrower than
 * (V_dc/2 + V_f) 1 us/min(L_d, L_q), which is as stiff as the steps resolve.
 * Command edges act after turn_on_delay or turn_off_delay. A pulse or gap whose end would overtake its
 * beginning vanishes, and so does one that would be the fifth edge of its gate within a delay.
 * All three legs off, all currents inside the zone for PLANT_IDLE_TICKS and the EMF between lines below
 * V_dc + 2 V_f: no current flows at all until a gate turns on or the EMF rises.
 * Both on: shoot-through, counted; the pole voltage is V_dc/2 as long as the protection leaves it so.
 * An open switch is one whose gate is never on, a shorted one is always on and nothing shuts it: its
 * partner's turning on is a shoot-through. Both act on edges, in averaged mode not. DC link: stiff, or a
 * capacitor behind a resistance and a rectifier (nothing flows back to the source), with a chopper across it.
 * The source: a constant and a sine.
 *
 * Protection of the module (as Mitsubishi's L series has it, PM50B5LA060's data sheet for one; when a shut
 * gate obeys again is assumed): an arm whose IGBT carries more than short_circuit_current, or that takes part
 * in a shoot-through, shuts; a lower one takes its two neighbours with it (one common driver supply and fault
 * output), the others keep obeying. The fault line is active for fault_pulse; a shut gate obeys again after
 * the pulse and a fresh off-on edge. force_fault shuts all and holds the line. In averaged mode any trip
 * shuts all arms, and the first carrier period after the pulse resumes.
 *
 * Averaged mode: one mean pole voltage per leg and carrier period, what its two edges, dead time, delays and
 * drops make of V_dc high/period, each edge with the current that it meets, ripple included (averaged.h).
 *
 * Time: ticks of 1/150 MHz. Bits are the same on every machine (IEEE double, no contraction; of libm only
 * sqrt, fabs, floor, ceil, ldexp).
 *
 * Not handled: iron loss beside a broken wire or by ripple, hysteresis, switching energy, warming
 * (temperatures are parameters), the current of a shoot-through in the IGBTs, the 0.2 us until a short
 * circuit is shut off, over-temperature, a floating node when only one or two legs are off (the zone leaks up
 * to its width). */
#ifndef HOST_SIM_PLANT_PLANT_H
#define HOST_SIM_PLANT_PLANT_H

#include <stdbool.h>
#include <stdint.h>

#include "host_sim/plant/plant_params.h"

#define PLANT_TICKS_PER_SECOND UINT64_C(150000000)
#define PLANT_NEVER            UINT64_MAX
#define PLANT_SHAFT_WIDTH      0.2            /* [rad/s] mechanical, least half width of the smooth sign */
#define PLANT_SHAFT_FOLLOW     2e-4           /* [s] keeps the sign's slope stable: 0.75 per step of 100 us */
#define PLANT_IDLE_TICKS       UINT64_C(7500) /* 50 us */

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

/* Who carries a leg's current. */
typedef enum {
    PLANT_LEG_OPEN, /* nobody: idle, or the phase is broken */
    PLANT_LEG_UPPER_IGBT,
    PLANT_LEG_UPPER_DIODE,
    PLANT_LEG_LOWER_IGBT,
    PLANT_LEG_LOWER_DIODE,
    PLANT_LEG_ZONE,          /* |i| inside the zone around zero */
    PLANT_LEG_SHOOT_THROUGH, /* both IGBTs */
    PLANT_LEG_AVERAGED       /* averaged mode: upper and lower share the period */
} plant_leg_t;

/* What really is; never seen by the drive. */
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
    double shoot_throughs;       /* [-] how often both switches of a leg were on */
    double shoot_through_second; /* [s] when last; -1: never */
    double shoot_through_leg;    /* [-] which leg last, 0..2; -1: none */
    double fault_line;           /* [-] 1: fault output active */
    double shut_gates;           /* [-] gates shut by the module, bits as in plant_gates() */
    double energy_dc;            /* [J] from the link into the inverter, since metering was switched on */
    double energy_copper;        /* [J] into R and iron, since then */
    double energy_inverter;      /* [J] conduction losses, since then */
    double energy_mechanical;    /* [J] into friction, load, brake and dynamometer, since then */
    double energy_magnetic; /* [J] stored in the field of the currents; without saturation 0.75 (L_d i_d^2 +
                               L_q i_q^2) */
    double energy_kinetic;  /* [J] stored now, J omega_m^2/2; of both masses and in the twist */
    double omega_load;      /* [rad/s] mechanical, of the far end of the shaft; omega_m if it is rigid */
    double twist;           /* [rad] of an elastic shaft, the motor ahead */
    double shaft_torque;    /* [N m] from the motor into an elastic shaft */
} plant_truth_t;

/* The whole plant: copyable with memcpy, no pointers, no padding. Fields are for the debugger. */
#include "host_sim/plant/plant_state.h"

/* At tick 0: all gates off, no current, rotor at angle 0 at rest (or at the locked speed), link charged,
 * metering off. params must pass plant_params_check (asserted). The seed fixes every noise sample. */
void plant_init(plant_t *plant, const plant_params_t *params, uint64_t seed);

/* New parameters from now on, state kept. A locked shaft jumps to its speed; a phase that breaks loses its
 * current; a stiff link jumps to its voltage. Delays count for edges commanded from now on. In averaged mode
 * what a leg has of its own counts from the next carrier period on. Encoder: a change of slip, stuck tracks
 * or direction makes no step but the one edge that a track's level makes when it sticks; another offset is a
 * step, as of a disc that slips. */
void plant_set_params(plant_t *plant, const plant_params_t *params);

/* Turns the rotor: angle [rad] and speed [rad/s], mechanical; currents in the phases stay. A locked shaft
 * keeps its speed. */
void plant_set_motion(plant_t *plant, double theta_m, double omega_m);

/* A brake on the shaft: holds and slows it like dry friction of this torque [N m], >= 0 (asserted); 0:
 * released. A locked shaft feels none of it. */
void plant_set_brake(plant_t *plant, double torque);

/* Counts energies from zero (on), or stops counting. Costs time; off after init. While counting,
 * dc = copper + inverter + mechanical + change of magnetic + change of kinetic, unless motion or parameters
 * are set from outside. */
void plant_set_metering(plant_t *plant, bool on);

/* Six switch commands from this tick on: PLANT_UPPER(n), PLANT_LOWER(n), n = 0..2. Ticks of calls ascend.
 * State and everything read from it stay behind, at the last edge that mattered, until plant_advance.
 * Ends averaged mode; the commands that end it act without delay. */
void plant_gates(plant_t *plant, uint64_t tick, uint32_t on);

/* Averaged mode from this tick on: high[n] ticks of each `period` ticks the upper command of leg n would be
 * on without dead band, `dead` ticks of dead band at each rising edge. high 0 or period: no edges, no error.
 * upper: on at both ends of the period and off around its middle; otherwise on around its middle. Holds for
 * all periods from here until the next call of this or plant_gates. period > 0 (asserted). Advances to tick;
 * pending edges are void. */
void plant_carrier(plant_t *plant, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                   bool upper);

/* Lets time pass until tick; a tick in the past does nothing. Some 40 ns per interval between edges that
 * change a voltage, or per 100 us. Within 1 mA of the exact solution while omega_e 100 us < 0.3. */
void plant_advance(plant_t *plant, uint64_t tick);

/* Volts at the ADC pin at the present tick, 0..3, noise included (each call draws anew). Does not advance:
 * channels that are sampled within a microsecond may share one plant_advance. */
double plant_analog(plant_t *plant, plant_channel_t channel);

/* Quadrature counts, free-running, at the present tick: floor(4 lines (theta_m + offset)/(2 pi)), less what
 * the encoder misses, as its tracks tell it. */
int64_t plant_encoder(const plant_t *plant);

/* The same at a tick near the present one, the angle carried on at the present speed: to look without letting
 * time pass. Within a period off by less than a twentieth of a count of 10000 at 4000 rad/s^2. */
int64_t plant_encoder_at(const plant_t *plant, uint64_t tick);

/* true while the module's fault output is active (the wired-OR of all of them). */
bool plant_fault_line(const plant_t *plant);

/* Everything at the present tick. Not for every period: some 100 ns. */
void plant_truth(const plant_t *plant, plant_truth_t *truth);

const char *plant_leg_text(plant_leg_t leg); /* "upper diode" */

#endif
