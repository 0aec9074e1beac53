/* The field of the currents with saturation: flux, incremental inductance and energy of each axis. Up to
 * MAGNETICS_FULL I_s
 *
 *   psi = L i/sqrt(1 + (i/I_s)^2),   dpsi/di = L/(1 + (i/I_s)^2)^1.5,   energy 1.5 (psi i - coenergy),
 *   coenergy = L I_s^2 (sqrt(1 + (i/I_s)^2) - 1) = L i^2/(1 + sqrt(1 + (i/I_s)^2)).
 *
 * This is exact for an unlimited I_s as well. Beyond that current the iron is full, and the incremental
 * inductance stays the one at its end, that of the air. Without this part no current could produce a flux
 * above L I_s. Such a flux occurs in a short circuit, which keeps the flux of the winding constant while the
 * rotor turns the magnets' flux into the q axis. With a flux map the values are those of the map. The flux of
 * the magnets, flux_linkage, is not included. */
#ifndef HOST_SIM_PLANT_MAGNETICS_H
#define HOST_SIM_PLANT_MAGNETICS_H

#include <math.h>

#include "host_sim/plant/flux_map.h"
#include "host_sim/plant/plant.h"

/* [-] Current over I_s from which the incremental inductance stays constant: 10^-1.5 = 3 % of L. */
#define MAGNETICS_FULL 3.0

typedef struct {
    double flux_d, flux_q;   /* [Wb] of the currents, without the magnets */
    double slope_d, slope_q; /* [H] incremental inductances */
    double cross_d, cross_q; /* [H] dpsi_d/di_q, dpsi_q/di_d: with a flux map */
} magnetics_t;

typedef struct {
    double flux, slope; /* [Wb], [H] */
} magnetics_axis_t;

/* Flux and inductance by the law above; `bend` is 1/I_s^2 [1/A^2]. */
static inline magnetics_axis_t magnetics_iron(double inductance, double bend, double i)
{
    const double less = 1.0 / sqrt(1.0 + bend * i * i);
    const double apparent = inductance * less;
    return (magnetics_axis_t){apparent * i, apparent * less * less};
}

/* [J] psi i - coenergy = L i^2 (1/r - 1/(1 + r)) = L i^2/(r (1 + r)), r = sqrt(1 + (i/I_s)^2). */
static inline double magnetics_stored(double inductance, double bend, double i)
{
    const double root = sqrt(1.0 + bend * i * i);
    return inductance * i * i / (root * (1.0 + root));
}

static inline bool magnetics_is_full(double bend, double i)
{
    return bend * i * i > MAGNETICS_FULL * MAGNETICS_FULL;
}

static inline magnetics_axis_t magnetics_axis(double inductance, double bend, double i)
{
    if (!magnetics_is_full(bend, i)) {
        return magnetics_iron(inductance, bend, i);
    }
    const double end = copysign(MAGNETICS_FULL / sqrt(bend), i);
    const magnetics_axis_t full = magnetics_iron(inductance, bend, end);
    return (magnetics_axis_t){full.flux + full.slope * (i - end), full.slope};
}

/* [J] Energy of an axis, divided by 1.5. */
static inline double magnetics_axis_energy(double inductance, double bend, double i)
{
    if (!magnetics_is_full(bend, i)) {
        return magnetics_stored(inductance, bend, i);
    }
    const double end = MAGNETICS_FULL / sqrt(bend);
    const double slope = magnetics_iron(inductance, bend, end).slope;
    return magnetics_stored(inductance, bend, end) + 0.5 * slope * (i * i - end * end);
}

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
    const magnetics_axis_t d = magnetics_axis(plant->params.inductance_d, plant->bend_d, i_d);
    const magnetics_axis_t q = magnetics_axis(plant->params.inductance_q, plant->bend_q, i_q);
    return (magnetics_t){.flux_d = d.flux, .flux_q = q.flux, .slope_d = d.slope, .slope_q = q.slope};
}

/* Energy of the field of the currents [J]. */
static inline double magnetics_energy(const plant_t *plant, double i_d, double i_q)
{
    if (plant->map != 0u) {
        return flux_map_energy(flux_map_of(plant->map), i_d, i_q);
    }
    return 1.5 * (magnetics_axis_energy(plant->params.inductance_d, plant->bend_d, i_d) +
                  magnetics_axis_energy(plant->params.inductance_q, plant->bend_q, i_q));
}

#endif
