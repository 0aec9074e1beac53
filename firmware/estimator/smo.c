#include "estimator/smo.h"

#include "math/tanh.h"

/* v and k_f of the error in the state, for the switching functions per axis. */
static void switch_axes(smo_t *smo)
{
    ab_t f = switching_step(&smo->axes, &smo->tuning.axes, smo->current_err);
    smo->gain_mean = smo->axes.gain;
    smo->switched = (ab_t){smo->tuning.gain * f.alpha, smo->tuning.gain * f.beta};
}

/* v and k_f of the error in the state, for every switching function. */
static void switch_any(smo_t *smo, float square)
{
    if (smo->tuning.switching == (int32_t)SMO_SIGMOID_VECTOR) {
        (void)smo_switch_vector(smo, square);
    } else {
        switch_axes(smo);
    }
}

void smo_reset_error(smo_t *smo, ab_t current, ab_t error)
{
    smo->current_err = error;
    smo->current_hat = (ab_t){current.alpha + error.alpha, current.beta + error.beta};
    switching_reset(&smo->axes);
    switch_any(smo, smo_error_square(smo));
    smo->emf_hat = smo->switched;
}

void smo_reset(smo_t *smo, ab_t current, ab_t emf)
{
    float per_volt = 1.0f / smo->tuning.gain;
    ab_t f = {per_volt * emf.alpha, per_volt * emf.beta};
    if (smo->tuning.switching == (int32_t)SMO_SIGMOID_VECTOR) {
        float k_f = smo->tuning.half_slope * tanh_ratio_at(f.alpha * f.alpha + f.beta * f.beta);
        smo_reset_error(smo, current, (ab_t){f.alpha / k_f, f.beta / k_f});
        return;
    }
    smo_reset_error(smo, current, switching_error(&smo->tuning.axes, f));
    if (smo->tuning.switching == (int32_t)SMO_SIGN) { /* v of the next period */
        smo->switched = emf;
        smo->emf_hat = emf;
    }
}

void smo_answer(smo_t *smo, float error_square)
{
    switch_any(smo, error_square);
    ab_t v = smo->switched;
    if (smo->tuning.emf_decay > 0.0f) { /* eq. (11) */
        v.alpha += smo->tuning.emf_decay * (smo->emf_hat.alpha - v.alpha);
        v.beta += smo->tuning.emf_decay * (smo->emf_hat.beta - v.beta);
    }
    smo->emf_hat = v;
}

ab_t smo_step(smo_t *smo, ab_t voltage, ab_t current)
{
    float error_square;
    if (smo_predict(smo, voltage, current, &error_square)) {
        smo_answer(smo, error_square);
    }
    return smo->emf_hat;
}

float smo_equivalent_gain(const smo_t *smo)
{
    return smo->gain_mean;
}
