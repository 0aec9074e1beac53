/* One interval of the plant in which nothing is switched: motor, legs, DC link, shaft and energies.
 *
 * Currents: the voltage vector is constant in the stationary frame; in the rotor frame it turns backwards
 * with omega_e. With constant speed the equations of plant.h are linear, and their Taylor series is summed to
 * the fourth order. If a current touches the zone around zero, the voltage of its leg is the mean over the
 * change of the current, found by iteration. If this leg is too stiff (both gates off), or a phase is broken,
 * the step is a classical Runge-Kutta method. Its sub-steps end at the borders of the zone and have at most
 * half of its time constant. If a fast rotor feeds the link through the diodes in steady state, there are two
 * sub-steps. Ripple of a constant link voltage: the value in the middle of the interval. Shaft: constant mean
 * torque of both ends, friction at the extrapolated speed of the middle (second order). Currents and angle
 * use the speed extrapolated from the previous interval. The solution of an elastic shaft is exact for
 * torques that are constant at both ends. If a shaft with break-away or brake stops or starts, the interval
 * ends at this tick. */
#ifndef HOST_SIM_PLANT_INTERVAL_H
#define HOST_SIM_PLANT_INTERVAL_H

#include <stdbool.h>
#include <stdint.h>

#include "host_sim/plant/plant.h"

/* Updates the counts of the encoder for whole electrical turns and for its offset. Call it after a change of
 * these values. */
void interval_count_turns(plant_t *plant);

/* Advances by at most `ticks` (> 0) and returns the number of ticks. The step is at most 100 us, and at most
 * 0.1 of the time constants of omega_e, of R/L and of the oscillation of rotor and currents. */
uint64_t interval_step(plant_t *plant, uint64_t ticks);

/* The same after a change of angle, speed, currents or parameters from outside: also restarts the
 * extrapolation of the speed. */
void interval_restart(plant_t *plant);

/* Computes i_d, i_q, torque and the state of broken phases again after a change of phase currents or angle.
 */
void interval_refresh(plant_t *plant);

/* true: dry friction holds the shaft, at speed 0. */
bool interval_held(const plant_t *plant);

/* Mechanical angle now [rad], unwrapped. */
double interval_angle(const plant_t *plant);

/* Friction, load and brake at this speed [N m], positive against positive rotation; on a held shaft that part
 * which does not depend on what drives it. */
double interval_resistance(const plant_t *plant, double omega_m);

/* The same including the torque that holds a fixed shaft, and the load at the far end of an elastic shaft
 * [N m]. */
double interval_load(const plant_t *plant);

/* Open-circuit voltage of the link's source [V], `ahead` [s] from now. */
double interval_source(const plant_t *plant, double ahead);

/* Pole voltage [V] of a leg with this current [A] while this law holds; *share is the part of the current
 * that comes from the link [-]. */
double interval_pole(const plant_t *plant, const plant_law_t *law, double i, double *share);

/* Its mean [V] while the current changes linearly from x to y [A]. */
double interval_pole_mean(const plant_t *plant, const plant_law_t *law, double x, double y);

/* Slopes of the phase currents within the next h [s], from the present currents in the rotor frame: without
 * voltage at its begin and end [A/s], and the additional slope for each volt along alpha and along beta in
 * the middle [A/(V s)]. */
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
