/* The field of the currents with saturation: flux, incremental inductance and energy of each axis.
 *
 *   psi = L i/sqrt(1 + (i/I_s)^2),   dpsi/di = L/(1 + (i/I_s)^2)^1.5,   energy 1.5 (psi i - coenergy),
 *   coenergy = L I_s^2 (sqrt(1 + (i/I_s)^2) - 1) = L i^2/(1 + sqrt(1 + (i/I_s)^2)),
 *
 * This is exact for an unlimited I_s as well. With a flux map the values are those of the map. The flux of
 * the magnets, flux_linkage, is not included. */
#ifndef HOST_SIM_PLANT_MAGNETICS_H
#define HOST_SIM_PLANT_MAGNETICS_H

#include <math.h>

#include "host_sim/plant/flux_map.h"
#include "host_sim/plant/plant.h"

typedef struct {
    double flux_d, flux_q;   /* [Wb] of the currents, without the magnets */
    double slope_d, slope_q; /* [H] incremental inductances */
    double cross_d, cross_q; /* [H] dpsi_d/di_q, dpsi_q/di_d: with a flux map */
} magnetics_t;

static inline magnetics_t magnetics_at(const plant_t *plant, double i_d, double i_q)
{
    if (plant->map != 0u) {
        const flux_map_point_t at = flux_map_at(flux_map_of(plant->map), i_d, i_q);
        return (magnetics_t){at.flux_d - plant->params.flux_linkage,
                             at.flux_q,
                             at.slope_dd,
                             at.slope_qq,
                             at.slope_dq,
                             at.slope_qd};
    }
    const double less_d = 1.0 / sqrt(1.0 + plant->bend_d * i_d * i_d);
    const double less_q = 1.0 / sqrt(1.0 + plant->bend_q * i_q * i_q);
    const double apparent_d = plant->params.inductance_d * less_d;
    const double apparent_q = plant->params.inductance_q * less_q;
    return (magnetics_t){
        .flux_d = apparent_d * i_d,
        .flux_q = apparent_q * i_q,
        .slope_d = apparent_d * less_d * less_d,
        .slope_q = apparent_q * less_q * less_q,
    };
}

/* Energy of the field of the currents [J]. */
static inline double magnetics_energy(const plant_t *plant, double i_d, double i_q)
{
    if (plant->map != 0u) {
        return flux_map_energy(flux_map_of(plant->map), i_d, i_q);
    }
    const double root_d = sqrt(1.0 + plant->bend_d * i_d * i_d);
    const double root_q = sqrt(1.0 + plant->bend_q * i_q * i_q);
    /* psi i - coenergy = L i^2 (1/r - 1/(1 + r)) = L i^2/(r (1 + r)). */
    return 1.5 * (plant->params.inductance_d * i_d * i_d / (root_d * (1.0 + root_d)) +
                  plant->params.inductance_q * i_q * i_q / (root_q * (1.0 + root_q)));
}

#endif
