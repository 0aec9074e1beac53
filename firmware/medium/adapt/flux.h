/* Flux linkage psi_f, learnt slowly from the estimated EMF and speed of the turning rotor:
 *
 *     psi_f = <|e|>/<|omega_e|>       both means through the same low-pass: a ramp of the speed has no effect
 *     d(1/psi_f)/dt = adaptation (<|omega_e|>/<|e|> - 1/psi_f)
 *
 * It adapts only where the EMF is large enough to be measured (FLUX_SPEED_MIN) and the tracking loop has
 * settled (FLUX_DETECTOR_MAX), and by at most FLUX_RANGE of the parameter.
 *
 * One step per T, over the periods in which the loop tracked. Does not handle: an error of the observer's
 * voltage, which changes the learnt flux. */
#ifndef MEDIUM_ADAPT_FLUX_H
#define MEDIUM_ADAPT_FLUX_H

#define FLUX_SPEED_MIN    60.0f /* [rad/s] electrical */
#define FLUX_DETECTOR_MAX 0.05f /* [-] */
#define FLUX_CUTOFF       20.0f /* [rad/s], low-pass of EMF and speed */
#define FLUX_RANGE        0.5f  /* [-] largest change relative to the parameter, either way */

/* Not checked here; the estimator's parameters have the same fields and rules. */
typedef struct {
    float flux_linkage; /* initial psi_f [Wb], above 0 */
    float adaptation;   /* [rad/s]; 0 = off */
    float period;       /* T [s] */
} flux_params_t;

typedef struct {
    float flux_linkage;   /* psi_f of the parameters [Wb] */
    float speed_per_volt; /* its reciprocal [rad/s/V] */
    float share;          /* adaptation T [-]; 0 = off */
    float mean_share;     /* 1 - exp(-FLUX_CUTOFF T) [-] */
} flux_tuning_t;

typedef struct {
    flux_tuning_t tuning;
    /* state */
    float flux_linkage;   /* psi_f as adapted [Wb] */
    float speed_per_volt; /* its reciprocal [rad/s/V] */
    float emf_mean;       /* <|e|> [V] */
    float speed_mean;     /* <|omega_e|> [rad/s] */
} flux_t;

/* Computes the coefficients. Division and exponential: for the background. */
void flux_prepare(flux_tuning_t *tuning, const flux_params_t *params);

/* Takes over the coefficients alone. An adapted psi_f is kept while the parameter is unchanged and the
 * adaptation is on; otherwise it restarts from the parameter. */
void flux_take(flux_t *flux, const flux_tuning_t *tuning);

/* Sets the means as if the rotor had turned at omega_e [rad/s] for a long time; psi_f is kept. */
void flux_reset(flux_t *flux, float omega_e);

/* One period in which the loop tracked: amplitude of the EMF [V], smoothed speed
 * [rad/s], detector [-]. No division. */
void flux_step(flux_t *flux, float amplitude, float omega_smooth, float detector);

#endif
