/* Coefficients of the encoder watch. */
#include "math/filter.h"
#include "math/periods.h"
#include "medium/protect/encoder_watch.h"

/* [-] three standard deviations of the mean of two windows: of both ends, sqrt(2)/2 each */
#define EMF_NOISE 2.12f
/* If noise determines the least EMF, this is one of a low-pass with the share SLOW, which consists of noise
 * and its opposite in the next window: three times sqrt(2 SLOW^2/(2 - SLOW)). */
#define SLOW       0.25f /* [-] */
#define SLOW_NOISE 0.80f /* [-] */

/* [-] noise of the EMF's speed over that of a window's EMF, times |e| T_j: a second difference of the
 * currents' noise behind the low-pass, whose share is a third. */
#define TURN_NOISE 0.39f
/* Of the least EMF that is judged: largest difference across the axis that noise, or the dead time of the
 * other two phases with small opposite currents, may cause. */
#define OFF_BESIDE 0.5f /* [-] */

encoder_watch_tuning_t encoder_watch_prepare(const encoder_watch_params_t *params)
{
    const float every = (float)params->every;
    const float window = every * params->period;
    const float rate = 1.0f / window;
    const float noise = EMF_NOISE * params->noise * params->inductance * rate;
    const float judged = params->flux_linkage * params->speed_least;
    const float mean_least = bounds_more(judged, noise);
    const float least = bounds_more(judged, SLOW_NOISE / EMF_NOISE * noise);
    const float alone = ENCODER_WATCH_ALONE * mean_least;
    return (encoder_watch_tuning_t){
        .flux_linkage = params->flux_linkage,
        .emf_least = least,
        .doubtful = params->doubtful * params->doubtful,
        .alone = alone * alone,
        .before = judged < noise ? 1.0f - SLOW : 0.5f,
        .noise = 4.0f * noise * noise,
        .unseen = params->unseen * params->unseen,
        .beside = OFF_BESIDE * OFF_BESIDE * mean_least * mean_least,
        .turn_noise = TURN_NOISE * TURN_NOISE * 4.0f * noise * noise * rate * rate,
        .leap = ENCODER_WATCH_LEAP + 2.0f * params->step,
        .share = lowpass_share(ENCODER_WATCH_CUTOFF, window),
        .winding = winding_prepare(params->resistance, params->inductance, params->period),
        .periods = every,
        .volts = params->inductance * rate,
        .salient = params->saliency * rate,
        .middle = -0.5f * window,
        .rate = rate,
        .holds = ENCODER_WATCH_TIME * rate * least,
        .settles = periods_of(ENCODER_WATCH_SETTLE, window),
        .waits = periods_of(ENCODER_WATCH_WAIT, window),
    };
}
