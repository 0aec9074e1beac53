#include "medium/manoeuvre/weakening.h"

#include <stdbool.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

#define TRIM_RATE    100.0f /* [1/s] */
#define TRIM_MOST    0.25f  /* [-] FLUX_WRONG, and the errors of L and R */
#define TRIM_FORGETS 0.9f   /* [-] share that remains one step later, while the voltage is no limit */
#define FLUX_WRONG   1.3f   /* [-] true flux over the assumed one, at most */
#define ASKED_MOST   1.3f   /* [-] of `use`: a requested voltage counts up to this */
#define FLUX_SHARE   0.5f   /* low-pass of psi_m: link and speed are noisy [-] */
#define HALVINGS     12     /* of the range of i_d: 10 A to 3 mA */
#define FLUX_LEAST   0.1f   /* least psi_a [-] of psi_f */

weakening_tuning_t weakening_prepare(const weakening_params_t *params)
{
    return (weakening_tuning_t){
        .flux_linkage = params->flux_linkage,
        .inductance_d = params->inductance_d,
        .inductance_q = params->inductance_q,
        .inverse_d = 1.0f / params->inductance_d,
        .inverse_q = 1.0f / params->inductance_q,
        .inverse_flux = 1.0f / params->flux_linkage,
        .saliency = params->inductance_q - params->inductance_d,
        .resistance = params->resistance,
        .current_max = params->current_max,
        .i_d_mtpa = params->i_d_mtpa,
        .use = params->use,
        .flux_bound = params->flux_linkage + params->inductance_q * params->current_max,
        .trim_share = TRIM_RATE * params->period,
    };
}

void weakening_init(weakening_t *weakening, const weakening_tuning_t *tuning)
{
    *weakening = (weakening_t){.trim = 0.0f};
    weakening_take(weakening, tuning);
}

void weakening_bend(weakening_t *weakening, float inductance_q)
{
    weakening_tuning_t *tuning = &weakening->tuning;
    tuning->inductance_q = inductance_q;
    tuning->inverse_q = 1.0f / inductance_q;
    tuning->saliency = inductance_q - tuning->inductance_d;
    tuning->flux_bound = tuning->flux_linkage + inductance_q * tuning->current_max;
}

/* i_d at the intersection of circle and ellipse [A]: -c/(L_d psi_f + sqrt(L_d^2 psi_f^2 + (L_q^2 - L_d^2)
 * c)), c = psi_f^2 + L_q^2 I^2 - psi_m^2; above zero where the circle lies within. */
static float where_they_meet(const weakening_t *weakening)
{
    const weakening_tuning_t *tuning = &weakening->tuning;
    const float flux_q = tuning->inductance_q * tuning->current_max;
    const float c = tuning->flux_linkage * tuning->flux_linkage + flux_q * flux_q -
                    weakening->flux_most * weakening->flux_most;
    const float along = tuning->inductance_d * tuning->flux_linkage;
    const float across = tuning->saliency * (tuning->inductance_q + tuning->inductance_d);
    return -c / (along + root_or_none(along * along + across * c));
}

/* i_d of the most torque on the ellipse [A]: psi_d = -2 D psi_m^2/(L_q psi_f +
 * sqrt(L_q^2 psi_f^2 + 8 D^2 psi_m^2)). */
static float most_per_volt(const weakening_t *weakening)
{
    const weakening_tuning_t *tuning = &weakening->tuning;
    const float along = tuning->inductance_q * tuning->flux_linkage;
    const float taken = tuning->saliency * weakening->flux_most;
    const float flux_d =
        -2.0f * taken * weakening->flux_most / (along + root_or_none(along * along + 8.0f * taken * taken));
    return (flux_d - tuning->flux_linkage) * tuning->inverse_d;
}

static float active_flux(const weakening_tuning_t *tuning, float i_d)
{
    return bounds_more(tuning->flux_linkage - tuning->saliency * i_d, FLUX_LEAST * tuning->flux_linkage);
}

/* i_d, i_q and torque at the point of most torque. */
static void limit(weakening_t *weakening)
{
    const weakening_tuning_t *tuning = &weakening->tuning;
    const float least = bounds_more(where_they_meet(weakening), most_per_volt(weakening));
    const float within = bounds_more(least, -tuning->current_max);
    weakening->i_d_limit = bounds_less(within, tuning->i_d_mtpa);
    const float flux_d = tuning->flux_linkage + tuning->inductance_d * weakening->i_d_limit;
    const float by_voltage =
        root_or_none(weakening->flux_most * weakening->flux_most - flux_d * flux_d) * tuning->inverse_q;
    const float by_current =
        root_or_none(tuning->current_max * tuning->current_max - weakening->i_d_limit * weakening->i_d_limit);
    const float i_q = bounds_less(by_voltage, by_current);
    weakening->i_q_most = flux_d > 0.0f ? by_voltage : weakening->flux_most * tuning->inverse_q;
    weakening->torque_share = active_flux(tuning, weakening->i_d_limit) * tuning->inverse_flux;
    weakening->torque_limit = weakening->torque_share * i_q;
}

/* The trim follows the difference between the requested voltage and u: while the field is weakened, and also
 * if the requested voltage exceeds u although psi_f and L as configured leave enough voltage. Otherwise the
 * torque of a rotor with a larger psi_f would be limited by the voltage without i_d, and the torque of the
 * speed control would grow to its limit meanwhile. */
static void trim(weakening_t *weakening, float u, float square)
{
    if (weakening->weakens == 0u && square <= u * u) {
        weakening->trim *= TRIM_FORGETS;
        return;
    }
    const float asked = root_or_none(square);
    const float counts = bounds_less(asked, ASKED_MOST * u);
    weakening->trim =
        bounds_clamp(weakening->trim + weakening->tuning.trim_share * (u - counts) / u, TRIM_MOST);
}

void weakening_look(weakening_t *weakening, float u_dc, float omega_e, dq_t voltage)
{
    const weakening_tuning_t *tuning = &weakening->tuning;
    const float u = tuning->use * u_dc;
    const float speed = bounds_magnitude(omega_e);
    const bool looked = weakening->looks != 0u;
    const float square = voltage.d * voltage.d + voltage.q * voltage.q;
    const bool short_of = weakening->trim < 0.0f || square > u * u;
    const float bound = short_of ? FLUX_WRONG * tuning->flux_bound : tuning->flux_bound;
    const bool may =
        tuning->use > 0.0f && u > 0.0f && speed * bound + tuning->resistance * tuning->current_max > u;
    weakening->looks = may ? UINT32_C(1) : UINT32_C(0);
    if (!may) {
        weakening->trim = 0.0f;
        weakening->weakens = 0u;
        weakening->drop = 0.0f;
        return;
    }
    trim(weakening, u, square);
    const float left = u * (1.0f + weakening->trim) - weakening->drop;
    const float flux = left > 0.0f ? left / speed : 0.0f;
    const float most = bounds_less(flux, tuning->flux_bound);
    weakening->flux_most = lowpass_step(looked ? weakening->flux_most : most, FLUX_SHARE, most);
    limit(weakening);
}

/* True if this torque over 1.5 p [Wb A] with this i_d [A] needs more flux than psi_m: psi_d^2 + (L_q
 * T/psi_a)^2 without the division. */
static bool is_beyond(const weakening_t *weakening, float i_d, float torque)
{
    const weakening_tuning_t *tuning = &weakening->tuning;
    const float flux_d = tuning->flux_linkage + tuning->inductance_d * i_d;
    const float flux_a = active_flux(tuning, i_d);
    const float flux_q = tuning->inductance_q * torque;
    return flux_q * flux_q >
           flux_a * flux_a * (weakening->flux_most * weakening->flux_most - flux_d * flux_d);
}

/* The largest i_d from i_d_limit to `most` at which the ellipse permits this torque. */
static float bisect(const weakening_t *weakening, float torque, float most)
{
    float low = weakening->i_d_limit;
    float high = most;
    for (int n = 0; n < HALVINGS; n++) {
        const float middle = 0.5f * (low + high);
        if (is_beyond(weakening, middle, torque)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return low;
}

/* R (i n): the voltage over R in the direction of the EMF. */
static void note_drop(weakening_t *weakening, float i_d, float i_q, float omega_e)
{
    const weakening_tuning_t *tuning = &weakening->tuning;
    const float flux_d = tuning->flux_linkage + tuning->inductance_d * i_d;
    const float flux_q = tuning->inductance_q * i_q;
    const float along = (i_q * flux_d - i_d * flux_q) * inverse_root(flux_d * flux_d + flux_q * flux_q);
    weakening->drop = tuning->resistance * (omega_e < 0.0f ? -along : along);
}

float weakening_i_d(weakening_t *weakening, float torque, float i_d, float omega_e)
{
    const weakening_tuning_t *tuning = &weakening->tuning;
    if (weakening->looks == 0u) {
        return i_d;
    }
    const float wanted = torque * tuning->flux_linkage;
    const bool beyond = i_d > weakening->i_d_limit && is_beyond(weakening, i_d, wanted);
    const float taken = beyond ? bisect(weakening, wanted, i_d) : i_d;
    weakening->weakens = beyond ? UINT32_C(1) : UINT32_C(0);
    note_drop(weakening, taken, wanted / active_flux(tuning, taken), omega_e);
    return taken;
}
