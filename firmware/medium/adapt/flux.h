/* Flux linkage psi_f from what the estimator sees of a turning rotor, slowly:
 *
 *     psi_f = <|e|>/<|omega_e|>       both means through the same low-pass, so that a ramp of the speed
 * leaves no trace d(1/psi_f)/dt = adaptation (<|omega_e|>/<|e|> - 1/psi_f)
 *
 * It adapts only where the EMF is large enough to be measured (FLUX_SPEED_MIN) and the tracking loop has
 * settled (FLUX_DETECTOR_MAX), and by at most FLUX_RANGE of the parameter.
 *
 * One step per T, of the periods that were tracked. Does not handle: an error of the observer's voltage,
 * which it takes for flux. */
#ifndef MEDIUM_ADAPT_FLUX_H
#define MEDIUM_ADAPT_FLUX_H

#define FLUX_SPEED_MIN    60.0f /* [rad/s] electrical */
#define FLUX_DETECTOR_MAX 0.05f /* [-] */
#define FLUX_CUTOFF       20.0f /* [rad/s], low-pass of EMF and speed */
#define FLUX_RANGE        0.5f  /* [-] of the parameter, either way */

/* Not checked here; the estimator's set has the same fields and rules. */
typedef struct {
    float flux_linkage; /* psi_f that it starts from [Wb], above 0 */
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

/* Coefficients. Division and exponential: for the background. */
void flux_prepare(flux_tuning_t *tuning, const flux_params_t *params);

/* The coefficients alone. An adapted psi_f stays while that of the parameters is not changed and the
 * adaptation is on; else it starts from the parameter again. */
void flux_take(flux_t *flux, const flux_tuning_t *tuning);

/* As if the rotor had turned at omega_e [rad/s] for long; psi_f stays. */
void flux_reset(flux_t *flux, float omega_e);

/* One period that was tracked: EMF's amplitude [V], smooth speed [rad/s], detector [-]. No division. */
void flux_step(flux_t *flux, float amplitude, float omega_smooth, float detector);

#endif
