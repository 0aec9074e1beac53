#include "estimator/paper/lag_paper.h"

#include "math/trig.h"

/* Eq. (14). */
float lag_paper_angle(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    if (mode == LAG_NONE) {
        return 0.0f;
    }
    float resistance = smo->tuning.resistance;
    float g = smo->tuning.gain * smo_equivalent_gain(smo);
    float damping = mode == LAG_PRINTED ? g * resistance + resistance : g + resistance; /* (13) */
    return trig_atan2(omega_e * smo->tuning.inductance, damping);
}

ab_t lag_paper_emf(const smo_t *smo, lag_mode_t mode, float omega_e)
{
    float size = 1.0f / lag_attenuation(smo, omega_e);
    ab_t late = {size * smo->emf_hat.alpha, size * smo->emf_hat.beta};
    rotation_t turn = trig_rotation(lag_paper_angle(smo, mode, omega_e));
    return frames_inverse_park((dq_t){late.alpha, late.beta}, turn);
}
