#include "medium/commission/turning_window.h"

#include "math/frames.h"
#include "math/root.h"
#include "math/winding.h"

#define STRAIGHTENS 3u /* [-] steps to the angle of the EMF of a saturating rotor */

float turning_mean_length(float n, float turn)
{
    const float y = 0.25f * turn * turn;
    const float nn = n * n;
    return 1.0f - (nn - 1.0f) * y * (1.0f / 6.0f - (3.0f * nn - 7.0f) * y * (1.0f / 360.0f));
}

float turning_lengthening(const commission_tuning_t *tuning, const turning_input_t *input)
{
    return 1.0f / turning_mean_length(tuning->window / tuning->period, tuning->period * input->omega_e);
}

float turning_emf(const turning_input_t *input)
{
    return root_or_none(input->emf.d * input->emf.d + input->emf.q * input->emf.q);
}

dq_t turning_current(const turning_input_t *input)
{
    const float amount = turning_emf(input);
    const float share = amount > 0.0f ? 1.0f / amount : 0.0f;
    const rotation_t error = {-share * input->emf.d, share * input->emf.q};
    return frames_park((ab_t){input->current.d, input->current.q}, error);
}

/* psi_q/i_q at this i_q [H]. */
static float apparent(const commission_tuning_t *tuning, float i_q)
{
    const float x = tuning->saturation > 0.0f ? i_q / tuning->saturation : 0.0f;
    return tuning->inductance_q * winding_saturation(x * x);
}

turning_input_t turning_straightened(const commission_tuning_t *tuning, const turning_input_t *input)
{
    turning_input_t straight = *input;
    for (uint32_t n = 0u; n < STRAIGHTENS && tuning->saturation > 0.0f; n++) {
        const float i_q = turning_current(&straight).q;
        const float c = (apparent(tuning, i_q) - tuning->observed_q) * i_q;
        const float amount = turning_emf(&straight);
        const float share = amount > 0.0f ? input->omega_e * c / amount : 0.0f;
        straight.emf = (dq_t){input->emf.d + share * straight.emf.q, input->emf.q - share * straight.emf.d};
    }
    return straight;
}

float turning_torque(const commission_tuning_t *tuning, const turning_input_t *input, float psi)
{
    const float longer = turning_lengthening(tuning, input);
    const dq_t sampled = turning_current(input);
    const float early = tuning->edge_delay * longer * turning_emf(input) / tuning->inductance_q;
    const dq_t current = {longer * sampled.d, longer * sampled.q - early};
    const float reluctance = (tuning->inductance_d - apparent(tuning, current.q)) * current.d;
    return 1.5f * tuning->pole_pairs * (psi + reluctance) * current.q;
}
