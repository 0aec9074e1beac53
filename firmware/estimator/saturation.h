/* Saturation of the q axis: the difference of the flux of i_q from L_q i_q, from a table that is even in i_q.
 *
 *     psi_q = (L_q + excess(|i_q|)) i_q            L_q a constant, that of the observer
 *     dpsi_q/di_q = L_q + excess + |i_q| slope     slope = d excess/d|i_q|
 *
 * The table has 17 points. Values between them are interpolated; beyond its end the last value holds. The
 * background computes it from two parameters, psi_q = L_0 i_q/sqrt(1 + (i_q/I_s)^2): docs/theory.md, 30.
 *
 * No state, no division in saturation_at(). Does not handle: an effect of i_d on psi_q or of i_q on psi_d. */
#ifndef ESTIMATOR_SATURATION_H
#define ESTIMATOR_SATURATION_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"

#define SATURATION_STEPS  16u
#define SATURATION_POINTS 17u

typedef struct {
    float inductance;  /* L_q [H], a constant */
    float bend;        /* L_0/L_q - 1 [-] */
    float current;     /* I_s [A]; 0: no saturation */
    float current_max; /* current at the end of the table [A]; above 0 with a saturation */
} saturation_params_t;

typedef struct {
    float per_step;                  /* steps per ampere [1/A]; 0: no saturation */
    float excess[SATURATION_POINTS]; /* apparent inductance minus L_q [H] */
} saturation_t;

/* Values of the q axis at one current. */
typedef struct {
    float excess; /* [H] */
    float slope;  /* [H/A] */
} saturation_point_t;

/* The table; all zero without a saturation. Divisions and roots: for the background. */
saturation_t saturation_prepare(const saturation_params_t *params);

/* Apparent inductance at this i_q, divided by L_q [-], from the formula instead of the table. For the
 * background. */
float saturation_share(const saturation_params_t *params, float i_q);

static inline bool saturation_is_on(const saturation_t *saturation)
{
    return saturation->per_step != 0.0f;
}

/* Excess and slope at this i_q [A]; zero without a saturation. */
static inline saturation_point_t saturation_at(const saturation_t *saturation, float i_q)
{
    const float x = bounds_magnitude(i_q) * saturation->per_step;
    if (!(x < (float)SATURATION_STEPS)) {
        return (saturation_point_t){saturation->excess[SATURATION_STEPS], 0.0f};
    }
    const uint32_t n = (uint32_t)x;
    const float rise = saturation->excess[n + 1u] - saturation->excess[n];
    return (saturation_point_t){saturation->excess[n] + (x - (float)n) * rise, rise * saturation->per_step};
}

#endif
