/* Flux maps: psi_d and psi_q over i_d and i_q, measured or computed, in place of inductances and their
 * saturation.
 *
 * A map is a full grid. Between the points both fluxes are bicubic functions. They follow from the flux at
 * the four points around, its derivatives with respect to i_d and i_q, and the mixed derivative. The
 * derivatives at a point are those of the parabola through the point and its neighbours. Therefore flux and
 * incremental inductances are continuous, and the flux at a point is exactly that of the map. Outside the
 * grid the flux is linear.
 *
 * Maps are immutable and have a number, from 1 on, by which a parameter of the plant selects one, so that the
 * state of a plant has no pointer. The same map added again gets the same number. Not for several threads at
 * once: maps are added while a scenario is read. */
#ifndef HOST_SIM_PLANT_FLUX_MAP_H
#define HOST_SIM_PLANT_FLUX_MAP_H

#include <stdbool.h>
#include <stdint.h>

#define FLUX_MAPS       32u  /* most maps in a process */
#define FLUX_MAP_POINTS 256u /* most points along an axis */

typedef struct flux_map flux_map_t;

/* Flux and incremental inductances at a current. */
typedef struct {
    double flux_d, flux_q; /* [Wb] with the magnets */
    double slope_dd, slope_dq, slope_qd,
        slope_qq; /* [H] d psi_d/d i_d, d psi_d/d i_q, d psi_q/d i_d, d psi_q/d i_q */
} flux_map_point_t;

/* Grid of a map: currents in rising order, and the fluxes with i_q as the faster index. */
typedef struct {
    uint32_t count_d, count_q;
    const double *i_d, *i_q;       /* [A] */
    const double *flux_d, *flux_q; /* [Wb] count_d x count_q */
} flux_map_grid_t;

/* Reason for which a map was refused, with the point of the grid. */
typedef struct {
    const char *rule;
    double i_d, i_q; /* [A] */
} flux_map_error_t;

/* Number of the map with this grid, new or known. 0: refused, see `error`. An axis has fewer than three
 * points or no point at zero current, or a flux does not grow with its current. */
uint32_t flux_map_add(const flux_map_grid_t *grid, flux_map_error_t *error);

/* The map of this number; NULL: none. */
const flux_map_t *flux_map_of(uint32_t number);

flux_map_point_t flux_map_at(const flux_map_t *map, double i_d, double i_q);

/* Energy of the field at these currents minus that without current [J], integrated along i_d, then along i_q.
 */
double flux_map_energy(const flux_map_t *map, double i_d, double i_q);

/* Change of a current for which an inductance changes little [A]: the smallest step of the grid. */
double flux_map_step(const flux_map_t *map);

#endif
