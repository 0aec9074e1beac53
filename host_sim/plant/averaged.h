/* Averaged mode: the mean voltage of a carrier period, computed from its edges.
 *
 * A period begins and ends in the middle of a zero vector, here that of the upper switches. Leg j switches
 * twice, at h_j = d_j T/2 from each end. Both its switches are off for T_e = dead + t_on - t_off around this
 * instant, and everything is delayed by (dead + t_on + t_off)/2. Within the period EMF, resistance and mean
 * drops change the current of phase j with the slope F_j. Leg x changes it with the slope G_jx V_dc while it
 * is on; G follows from L_d and L_q at the angle in the middle of the period. Up to the middle
 *
 *     i_j(t)     = i_j(0) + F_j t + sum over x of G_jx V_dc min(t, t_x)
 *     i_j(T - t) = i_j(T) - F_j t - sum over x of G_jx V_dc min(t, t'_x)
 *     i_j(T)     = i_j(0) + F_j T + sum over x of G_jx V_dc (t_x + t'_x)
 *
 * In the first two equations dF/dt (T - t) t/2 is subtracted because the EMF turns. t_x and t'_x are the
 * effective switching instants h_x - s T_e/2. s is the mean sign of the current while both switches are off,
 * linear inside the zone. Because s and the currents depend on each other, they are found by iteration. The
 * currents at both ends of both dead bands are then the corners of a polygon. The mean voltage of the leg
 * follows from the laws of its gates along this polygon, with drops and zones. A pulse shorter than T_e is
 * omitted. With the zero vector of the lower switches at the ends, h is that of the lower switches, and V_dc
 * and s have the opposite sign.
 *
 * The currents of the plant are those of the mean voltage. At the samples, at the ends of the period, they
 * are equal to the switched currents, except for F times the delays. Derivation: docs/theory.md, 12. Not
 * handled: drops that change within the period; a long period in which R/L or the acceleration makes the
 * currents nonlinear; a short circuit because the dead band is too short. */
#ifndef HOST_SIM_PLANT_AVERAGED_H
#define HOST_SIM_PLANT_AVERAGED_H

#include "host_sim/plant/plant.h"

/* The laws of the legs for the carrier period that begins now, as plant_carrier has described it. */
void averaged_period(plant_t *plant);

#endif
