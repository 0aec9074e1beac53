/* One interval of the plant in which nothing is switched: motor, legs, DC link, shaft and energies.
 *
 * Currents: the voltage vector stands still in the stationary frame; in the rotor frame it turns back at
 * omega_e. With constant speed the equations of plant.h are then linear, and their Taylor series is summed
 * to the fourth order. Where a current touches the zone around zero, the voltage of its leg is the mean over
 * the current's way, found by repetition; where that leg is too stiff (both gates off), or a phase is broken,
 * classical Runge-Kutta in sub-steps that end at the borders of the zone and are at most half its time
 * constant long; two of them where a fast rotor feeds the link by the diodes and the transient is over.
 * The ripple of a stiff link: as its value in the middle of the interval.
 * Shaft: constant mean torque of both ends, friction at the extrapolated middle speed (second order); the
 * currents and the angle see the speed extrapolated from one interval earlier. An elastic shaft: exact for
 * torques that are constant at both ends. An interval in which a shaft
 * with break-away or brake would come to rest or break loose ends at the tick of it. */
#ifndef HOST_SIM_PLANT_INTERVAL_H
#define HOST_SIM_PLANT_INTERVAL_H

#include <stdbool.h>
#include <stdint.h>

#include "host_sim/plant/plant.h"

/* What the whole electrical turns and the offset are to the encoder; after a change of any of them. */
void interval_count_turns(plant_t *plant);

/* Advances by at most `ticks` (> 0) and returns by how many: no more than 100 us, less where
 * something changes faster (phase of omega_e, R/L, swing of rotor against currents: 0.1 of each). */
uint64_t interval_step(plant_t *plant, uint64_t ticks);

/* The same after a change of angle, speed, currents or parameters from outside: also the extrapolation of the
 * speed. */
void interval_restart(plant_t *plant);

/* i_d, i_q, torque and the broken phases made consistent after a change of phase currents or angle. */
void interval_refresh(plant_t *plant);

/* true: dry friction holds the shaft, at speed 0. */
bool interval_held(const plant_t *plant);

/* Mechanical angle now [rad], unwrapped. */
double interval_angle(const plant_t *plant);

/* Friction, load and brake at this speed [N m], positive against positive rotation; on a held shaft that part
 * which does not depend on what drives it. */
double interval_resistance(const plant_t *plant, double omega_m);

/* The same with what holds a fixed shaft, and with the load at the far end of an elastic one [N m]. */
double interval_load(const plant_t *plant);

/* Open-circuit voltage of the link's source [V], `ahead` [s] from now. */
double interval_source(const plant_t *plant, double ahead);

/* Pole voltage [V] of a leg under one law at this current [A]; *share is the part of the current the link
 * gives [-]. */
double interval_pole(const plant_t *plant, const plant_law_t *law, double i, double *share);

/* Its mean [V] while the current goes in a straight line from x to y [A]. */
double interval_pole_mean(const plant_t *plant, const plant_law_t *law, double x, double y);

/* How the phase currents move within the next h [s], by the present currents in the rotor frame: without
 * voltage at its begin and end [A/s]; what a volt along alpha and along beta adds in the middle [A/(V s)]. */
void interval_phase_slopes(const plant_t *plant, double h, double begin[3], double end[3], double by_alpha[3],
                           double by_beta[3]);

/* Motor voltage [V] now, in the stationary frame; the EMF where no current can flow. With a broken phase, its
 * part along the line that the current can take. */
void interval_voltage(const plant_t *plant, double *u_alpha, double *u_beta);

/* Energy in the field of the currents [J]. */
double interval_magnetic(const plant_t *plant);

/* Greatest EMF between two lines at this angle and speed [V]. */
double interval_line_emf(const plant_t *plant);

#endif
