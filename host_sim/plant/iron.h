/* Models the loss of the iron by one resistance R_c: in addition to the current o that makes the flux psi
 * (the magnets' included) and the torque, the phases carry a current along the EMF,
 *
 *   i = o + j g psi(o),   g = omega_e/R_c
 *   u = R i + dpsi/dt + j omega_e psi,   di/dt = do/dt + j g dpsi/dt + j psi dg/dt      (rotor frame)
 *
 * i is the state of the plant; o follows from it by Newton's method, whose first step is exact without
 * saturation. With a broken wire there is no loss (g = 0). */
#ifndef HOST_SIM_PLANT_IRON_H
#define HOST_SIM_PLANT_IRON_H

#include "host_sim/plant/magnetics.h"

#define IRON_PASSES  12
#define IRON_SETTLED 1e-24 /* [A^2] */

typedef struct {
    double i_d, i_q;   /* [A] that make the flux */
    double g;          /* omega_e/R_c [S] */
    magnetics_t field; /* of these */
} iron_t;

/* The currents o at the phase currents (i_d, i_q) [A] and this electrical speed [rad/s]. */
static inline iron_t iron_at(const plant_t *plant, double omega_e, double i_d, double i_q)
{
    const plant_params_t *q = &plant->params;
    const bool lossy = q->iron_loss_resistance > 0.0 && plant->open == 0u;
    const double g = lossy ? omega_e / q->iron_loss_resistance : 0.0;
    iron_t iron = {i_d, i_q, g, magnetics_at(plant, i_d, i_q)};
    for (int pass = 0; lossy && pass < IRON_PASSES; pass++) {
        const magnetics_t *f = &iron.field;
        const double miss_d = i_d - iron.i_d + g * f->flux_q;
        const double miss_q = i_q - iron.i_q - g * (q->flux_linkage + f->flux_d);
        if (miss_d * miss_d + miss_q * miss_q < IRON_SETTLED) {
            break;
        }
        const double dd = 1.0 - g * f->cross_q;
        const double qq = 1.0 + g * f->cross_d;
        const double per = 1.0 / (dd * qq + g * g * f->slope_d * f->slope_q);
        iron.i_d += per * (qq * miss_d + g * f->slope_q * miss_q);
        iron.i_q += per * (dd * miss_q - g * f->slope_d * miss_d);
        iron.field = magnetics_at(plant, iron.i_d, iron.i_q);
    }
    return iron;
}

#endif
