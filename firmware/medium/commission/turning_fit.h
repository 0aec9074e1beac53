/* Least squares with three unknowns, for the torque test: y = c0 x0 + c1 x1 + c2 x2 by its normal equations.
 * For the background. */
#ifndef MEDIUM_COMMISSION_TURNING_FIT_H
#define MEDIUM_COMMISSION_TURNING_FIT_H

#include <stdbool.h>
#include <stdint.h>

#define TURNING_UNKNOWNS 3u /* 1/J, -T_c/J, -B/J */

/* Normal equations of a least-squares fit of three unknowns. */
typedef struct {
    float a[TURNING_UNKNOWNS][TURNING_UNKNOWNS];
    float b[TURNING_UNKNOWNS];
    float yy; /* sum of the squares of the acceleration */
    float n;  /* [-] slices */
} turning_fit_t;

/* Adds y = c0 x0 + c1 x1 + c2 x2 to the fit. */
void turning_fit_add(turning_fit_t *fit, const float x[TURNING_UNKNOWNS], float y);

/* Solves it for c. false: the unknowns cannot be separated. `error`: standard error of the first, relative.
 */
bool turning_fit_solve(const turning_fit_t *fit, float x[TURNING_UNKNOWNS], float *error);

#endif
