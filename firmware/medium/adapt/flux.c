#include "medium/adapt/flux.h"

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

void flux_prepare(flux_tuning_t *tuning, const flux_params_t *params)
{
    tuning->flux_linkage = params->flux_linkage;
    tuning->speed_per_volt = 1.0f / params->flux_linkage;
    tuning->share = params->adaptation * params->period;
    tuning->mean_share = lowpass_share(FLUX_CUTOFF, params->period);
}

static void start(flux_t *flux)
{
    flux->flux_linkage = flux->tuning.flux_linkage;
    flux->speed_per_volt = flux->tuning.speed_per_volt;
}

void flux_take(flux_t *flux, const flux_tuning_t *tuning)
{
    const float before = flux->tuning.flux_linkage;
    flux->tuning = *tuning;
    if (tuning->flux_linkage != before || tuning->share == 0.0f) {
        start(flux);
    }
}

void flux_reset(flux_t *flux, float omega_e)
{
    flux->speed_mean = bounds_magnitude(omega_e);
    flux->emf_mean = flux->flux_linkage * flux->speed_mean;
}

void flux_step(flux_t *flux, float amplitude, float omega_smooth, float detector)
{
    const float speed = bounds_magnitude(omega_smooth);
    flux->emf_mean = lowpass_step(flux->emf_mean, flux->tuning.mean_share, amplitude);
    flux->speed_mean = lowpass_step(flux->speed_mean, flux->tuning.mean_share, speed);
    if (speed < FLUX_SPEED_MIN || bounds_magnitude(detector) > FLUX_DETECTOR_MAX) {
        return;
    }
    const float wanted = flux->speed_mean * inverse_root(flux->emf_mean * flux->emf_mean);
    const float change = flux->tuning.share * (wanted - flux->speed_per_volt);
    const float flux_linkage = flux->flux_linkage * (1.0f - flux->flux_linkage * change);
    const float set = flux->tuning.flux_linkage;
    if (bounds_magnitude(flux_linkage - set) > FLUX_RANGE * set) {
        return;
    }
    flux->speed_per_volt += change;
    /* One Newton step per period towards 1/speed_per_volt follows such a slow change. */
    flux->flux_linkage = flux_linkage * (2.0f - flux_linkage * flux->speed_per_volt);
}
