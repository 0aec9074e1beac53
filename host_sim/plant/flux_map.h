/* Flux maps: psi_d and psi_q over i_d and i_q, measured or computed, in place of inductances and their
 * saturation.
 *
 * A map is a full grid. Between its points both fluxes are bicubic: of the flux, its derivatives by i_d and
 * i_q, and the mixed one, at the four points around. The derivatives at a point are those of the parabola
 * through it and its neighbours. Flux and incremental inductances thus have no step anywhere, and at the
 * points the flux is exactly that of the map. Beyond the grid the flux is continued in a straight line.
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

/* Why a map was refused: at this point of the grid. */
typedef struct {
    const char *rule;
    double i_d, i_q; /* [A] */
} flux_map_error_t;

/* Number of the map with this grid, new or known; 0: refused, see `error`: fewer than three points along an
 * axis, no current of zero within it, or somewhere a flux that does not grow with its current. */
uint32_t flux_map_add(const flux_map_grid_t *grid, flux_map_error_t *error);

/* The map of this number; NULL: none. */
const flux_map_t *flux_map_of(uint32_t number);

flux_map_point_t flux_map_at(const flux_map_t *map, double i_d, double i_q);

/* Stored in the field at these currents [J], more than without current: along i_d at first, then along i_q.
 */
double flux_map_energy(const flux_map_t *map, double i_d, double i_q);

/* Current over which an inductance changes little [A]: the smallest step of the grid. */
double flux_map_step(const flux_map_t *map);

#endif
