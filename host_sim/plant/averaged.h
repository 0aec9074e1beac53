/* Averaged mode: the mean voltage that one carrier period's edges make.
 *
 * A period begins and ends in the middle of a zero vector, of the upper switches say. Leg j is handed over
 * twice, at h_j = d_j T/2 from either end, and both its switches are off for T_e = dead + t_on - t_off around
 * that instant, all of it (dead + t_on + t_off)/2 late. Within the period EMF, resistance and mean drops move
 * the current of a phase by F per second, the legs by G V_dc each while on (G: a leg's volt on the phases, of
 * the machine with L_d and L_q at the angle of the middle). So, up to the middle,
 *
 *     i_j(t)     = i_j(0) + F_j t + sum over x of G_jx V_dc min(t, t_x)
 *     i_j(T - t) = i_j(T) - F_j t - sum over x of G_jx V_dc min(t, t'_x)
 *     i_j(T)     = i_j(0) + F_j T + sum over x of G_jx V_dc (t_x + t'_x)
 *
 * less dF/dt (T - t) t/2 in the first two for the EMF that turns, where t_x, t'_x are when leg x in effect
 * leaves and returns: h_x - s T_e/2, s the mean over the hand-over of the current's sign, linear inside the
 * zone. s hangs on the currents and these on s: found by repetition.
 * The currents at both ends of both hand-overs are then the corners of a polygon, and the mean voltage of the
 * leg is that of the laws of its gates along it, drops and zones included. A pulse shorter than T_e does not
 * come. With the lower switches' zero vector at the ends, h is of the lower switches and V_dc and s have the
 * other sign.
 *
 * The currents that the plant shows are those of the mean voltage; they meet the switched ones where the
 * samples are, at the ends of the period, but for F times the delays. Derivation: docs/theory.md, 12. Not
 * handled: drops that change within the period, as ripple; a period so long that R/L or acceleration bend the
 * currents; a short circuit by less dead band than the switches need. */
#ifndef HOST_SIM_PLANT_AVERAGED_H
#define HOST_SIM_PLANT_AVERAGED_H

#include "host_sim/plant/plant.h"

/* The laws of the legs for the carrier period that begins now, as plant_carrier has described it. */
void averaged_period(plant_t *plant);

#endif
