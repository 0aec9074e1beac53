/* Switching functions of the paper, which act on each axis separately, and their equivalent gain k_f:
 *
 *     sign       f = sign(x)         k_f = 1/|x|, limited                (12)
 *     sigmoid    f = tanh(a_f x/2)   k_f = f/x, a_f/2 at zero            (12)
 *
 * The gain that describes both axes is the power-weighted one,
 *
 *     k_f = <f x>/<x x>              both means low-passed at SMO_GAIN_CUTOFF
 *
 * The observer of the drive switches by the length of the error (smo.h). These functions are for the
 * reproduction of the paper and for the comparison with that observer. One step per T. */
#ifndef ESTIMATOR_PAPER_SWITCHING_H
#define ESTIMATOR_PAPER_SWITCHING_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

/* Limit of the equivalent gain of the sign [1/A]: an error below 1 mA is less than any sensor resolves. */
#define SMO_SIGN_GAIN_MAX 1000.0f

/* Corner of the low-pass of the power-weighted gain [rad/s]. */
#define SMO_GAIN_CUTOFF 100.0f

typedef struct {
    float half_slope; /* a_f/2 [1/A] */
    float mean_share; /* 1 - exp(-SMO_GAIN_CUTOFF T) [-] */
    uint32_t sign;    /* [-] 1: sign; 0: sigmoid */
} switching_tuning_t;

typedef struct {
    ab_t gain_axis;     /* k_f of each axis at t_k [1/A] */
    float mean_product; /* low-passed f x, both axes [A] */
    float mean_square;  /* low-passed x x, both axes [A^2] */
    float gain;         /* k_f, power-weighted [1/A]; a_f/2 (sign: the limit) without an error so far */
    uint32_t started;   /* [-] 1: the means contain a sample */
} switching_t;

/* Coefficients from a_f [1/A] and T [s]. */
void switching_prepare(switching_tuning_t *tuning, float slope, float period, bool sign);

/* f(x) [-] of the error x [A]; the gains are in the state. Three divisions. */
ab_t switching_step(switching_t *switching, const switching_tuning_t *tuning, ab_t x);

/* Clears the means: the next ones contain only the sample of the next step. */
void switching_reset(switching_t *switching);

/* The error [A] for which f has this value [-], each component up to 0.99; 0 for the sign, which has no
 * inverse. Many divisions, for resets. */
ab_t switching_error(const switching_tuning_t *tuning, ab_t f);

#endif
