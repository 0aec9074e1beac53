#include "medium/adapt/dead_time_learn.h"

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"
#include "math/sixth.h"
#include "medium/adapt/gain.h"

/* [-] amplitude of the line across the current over that along the current, 1/11 + 1/13; <q s>; mean of the
 * signs along the current; largest ratio of the angles by which current and reference have turned. */
#define TWELFTH  (24.0f / 143.0f)
#define POWER    (0.5f * TWELFTH)
#define ALONG    (4.0f / 3.14159265f)
#define WAY_MOST 3.0f

/* [-] square of the effect that the noise of a current sensor has on the result of one step, over that of
 * the voltage 12 omega L s: 4/3 in a component of the current's vector of two sensors, one half after the
 * multiplication with sin 12 phi. */
#define NOISE_SQUARE (0.66666667f / (ALONG * POWER * ALONG * POWER))
#define DEVIATIONS   4.0f /* [-] of the noise */
#define SWINGS       8.0f /* [-] weight of the square of a swing: its effect may last, and is not independent */

/* [-] A swing c of the current's direction at 6 omega shows 3 c of the sixth harmonic A of the EMF as the
 * twelfth: an error of (143 pi/16) c A of the voltage, with A of 0.08 of the EMF, and c^2 = 2 (1 - |m(u)|^2).
 * It is a threshold if its square is 8 times this variance. A swing of 0.02 rad is free. */
#define TURNED_SQUARE 1.26f
#define TURNED_FREE   2e-4f

#define PRESENT 0.5f /* [-] of the least square of the current: least of the present one */
#define SMOOTH  2.0f /* [-] cut-off of the used value over the speed: the twelfth harmonic is left by 1/6 */

dead_time_learn_tuning_t dead_time_learn_prepare(const dead_time_learn_params_t *params)
{
    const float effective = params->effective;
    const float current = DEAD_TIME_LEARN_ZONES * params->zone;
    return (dead_time_learn_tuning_t){
        .rate = params->rate,
        .per_rate = params->rate > 0.0f ? 1.0f / params->rate : 0.0f,
        .effective = effective,
        .least = effective < 0.0f ? effective : 0.0f,
        .most = DEAD_TIME_LEARN_RANGE * (effective > params->band ? effective : params->band),
        .band = params->band,
        .per_band = params->flux_linkage / (DEAD_TIME_LEARN_EMF_FULL * params->band),
        .flux_linkage = params->flux_linkage,
        .current_square = current * current,
        .swing =
            params->inductance > 0.0f ? DEAD_TIME_LEARN_SWINGS * params->period / params->inductance : 0.0f,
        .reactance_square = NOISE_SQUARE * 144.0f * params->inductance * params->inductance,
        .period = (float)params->every * params->period,
    };
}

void dead_time_learn_take(dead_time_learn_t *learn, const dead_time_learn_tuning_t *tuning)
{
    const bool same = tuning->effective == learn->tuning.effective && tuning->band == learn->tuning.band;
    if (!same || tuning->rate == 0.0f) {
        learn->effective = tuning->effective;
        learn->learnt = tuning->effective;
        learn->smooth = tuning->effective;
        learn->variance = 0.0f;
        learn->rate = tuning->rate;
        learn->ripple = 1.0f;
        learn->begun = 0u;
    }
    if (tuning->rate != learn->tuning.rate) {
        learn->rate = tuning->rate;
    }
    learn->tuning = *tuning;
}

static inline float cross(ab_t a, ab_t b)
{
    return a.alpha * b.beta - a.beta * b.alpha;
}

static inline float square_of(ab_t a)
{
    return a.alpha * a.alpha + a.beta * a.beta;
}

static inline ab_t product(ab_t a, ab_t b)
{
    return (ab_t){a.alpha * b.alpha - a.beta * b.beta, a.alpha * b.beta + a.beta * b.alpha};
}

static inline bool same(ab_t a, ab_t b)
{
    return a.alpha == b.alpha && a.beta == b.beta;
}

/* The least square of the current with which an error of the dead time can be measured [A^2]. */
static float least_square(const dead_time_learn_tuning_t *tuning, const dead_time_learn_input_t *input)
{
    const float swing = tuning->swing * tuning->flux_linkage * input->omega_e_ref;
    const float noise = DEAD_TIME_LEARN_NOISES * input->noise;
    return bounds_more(tuning->current_square, bounds_more(swing * swing, noise));
}

/* True if the speed suits the dead band's voltage [V] and is low enough for the steps, and the current, whose
 * square [A^2] this is, has a direction. A value that is not a number is never visible. */
static bool visible(const dead_time_learn_tuning_t *tuning, const dead_time_learn_input_t *input,
                    float square, float band)
{
    const float due = tuning->flux_linkage * bounds_magnitude(input->omega_e_ref);
    const float turn = 12.0f * tuning->period * input->omega_e_ref;
    const float least = DEAD_TIME_LEARN_EMF_LEAST * due;
    const float seen = square_of(input->emf);
    return due > DEAD_TIME_LEARN_EMF_MIN * band && due < DEAD_TIME_LEARN_EMF_MAX * band &&
           bounds_within(turn, DEAD_TIME_LEARN_TURN) && seen > least * least &&
           seen < DEAD_TIME_LEARN_EMF_LIMIT * DEAD_TIME_LEARN_EMF_LIMIT &&
           square > PRESENT * least_square(tuning, input) &&
           square < DEAD_TIME_LEARN_EMF_LIMIT * DEAD_TIME_LEARN_EMF_LIMIT;
}

/* The correlation signal s [-] for the EMF across the current, from the current's direction. */
static inline float twelfth(ab_t unit)
{
    const ab_t sixth = sixth_power(unit);
    return 2.0f * sixth.alpha * sixth.beta;
}

/* A mean that turns by `turn` [rad] from one call to the next and follows the vector by `share` [-]. */
static inline ab_t follow(ab_t mean, float turn, float share, ab_t vector)
{
    const float kept = 1.0f - 0.5f * turn * turn;
    const ab_t turned = {kept * mean.alpha - turn * mean.beta, kept * mean.beta + turn * mean.alpha};
    return (ab_t){lowpass_step(turned.alpha, share, vector.alpha),
                  lowpass_step(turned.beta, share, vector.beta)};
}

/* Updates the slow means. Returns the weight w of the step, from the angle by which the current's direction
 * has turned. */
static float go_on(dead_time_learn_t *learn, const dead_time_learn_input_t *input, ab_t along, float square)
{
    if (learn->begun == 0u) {
        learn->begun = 1u;
        learn->emf_mean = input->emf;
        learn->omega_ref = input->omega_e_ref;
        learn->along_mean = along;
        learn->along = along;
        learn->against = (ab_t){0.0f, 0.0f};
        learn->square = square;
    }
    const float turn = learn->tuning.period * input->omega_e_ref;
    const float share = bounds_magnitude(turn);
    const float inverse = inverse_root(learn->omega_ref * learn->omega_ref);
    const float grown = input->omega_e_ref * learn->omega_ref * inverse * inverse;
    learn->emf_mean = (ab_t){grown * learn->emf_mean.alpha, grown * learn->emf_mean.beta};
    learn->omega_ref = input->omega_e_ref;
    learn->emf_mean = follow(learn->emf_mean, turn, share, input->emf);
    learn->along_mean = follow(learn->along_mean, turn, share, along);
    learn->square = lowpass_step(learn->square, share, square);
    learn->rest = (ab_t){input->emf.alpha - learn->emf_mean.alpha, input->emf.beta - learn->emf_mean.beta};
    const ab_t against = product(learn->rest, along);
    learn->against.alpha = lowpass_step(learn->against.alpha, share, against.alpha);
    learn->against.beta = lowpass_step(learn->against.beta, share, against.beta);
    const float way = cross(learn->along, along) * inverse_root(share * share);
    learn->along = along;
    return 0.5f + 0.5f * bounds_clamp(turn < 0.0f ? -way : way, WAY_MOST);
}

/* True if the speed is near its reference, the current is large enough and turns with both, and the current
 * measurement is consistent. Sensors with a wrong gain or offset leave a larger EMF against
 * the current than unequal legs do. */
static bool settled(const dead_time_learn_t *learn, const dead_time_learn_input_t *input, float band)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const float missing = input->omega_e_ref - input->omega_e;
    const float against = DEAD_TIME_LEARN_AGAINST * band;
    return learn->square > least_square(tuning, input) && square_of(learn->against) < against * against &&
           bounds_within(tuning->flux_linkage * missing, DEAD_TIME_LEARN_MISS * band) &&
           square_of(learn->along_mean) > DEAD_TIME_LEARN_STEADY;
}

/* The variance of the learnt value by the part of the shape of the EMF that a current with a swing shows as
 * the twelfth harmonic, per step in which it acts [-]. In a frame that follows the estimate the current has
 * no such swing. */
static float mistaken(const dead_time_learn_t *learn, const dead_time_learn_input_t *input, float per_volt)
{
    if (!input->forced) {
        return 0.0f;
    }
    const float turned = bounds_more(1.0f - square_of(learn->along_mean) - TURNED_FREE, 0.0f);
    const float emf = learn->tuning.flux_linkage * input->omega_e_ref * per_volt;
    return TURNED_SQUARE * turned * emf * emf;
}

/* The variance that the noise of the sensors, a rotor that swings and a current that swings have caused in
 * the learnt value after a step of this share [-]: the swing of a rotor is the motion of the value about its
 * low-pass. */
static void scatter(dead_time_learn_t *learn, const dead_time_learn_input_t *input, float share,
                    float per_volt)
{
    const float per_ampere = input->omega_e_ref * per_volt;
    const float noise = learn->tuning.reactance_square * per_ampere * per_ampere * input->noise;
    const float swing = learn->learnt - learn->smooth;
    learn->variance += share * (share * noise + SWINGS * swing * swing + mistaken(learn, input, per_volt) +
                                (share - 2.0f) * learn->variance);
}

/* The weight of the learnt value is 1 if it differs from the parameters by more than chance can explain, and
 * falls with the fourth power of the distance below. */
static void use(dead_time_learn_t *learn)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const float chance = DEAD_TIME_LEARN_CHANCE * tuning->band * learn->rate * tuning->per_rate;
    const float square = chance * chance + DEVIATIONS * DEVIATIONS * learn->variance;
    const float doubt = DEAD_TIME_LEARN_RIPPLE * tuning->band * learn->ripple;
    const float apart = learn->smooth - tuning->effective;
    const float ratio = bounds_clamp(apart * inverse_root(square), 1.0f);
    const float weight = ratio * ratio * ratio * ratio;
    learn->effective = tuning->effective + weight * (apart - bounds_clamp(apart, doubt));
}

void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const float band = tuning->band * input->link;
    const float square = square_of(input->current);
    learn->seen = 0.0f;
    if (input->model != learn->model) {
        learn->begun = 0u;
        learn->model = input->model;
    }
    if (!visible(tuning, input, square, band)) {
        learn->begun = 0u;
        return;
    }
    const float inverse = inverse_root(square);
    const ab_t along = {inverse * input->current.alpha, inverse * input->current.beta};
    const bool frozen = same(along, learn->along);
    const float weight = go_on(learn, input, along, square);
    if (frozen || !settled(learn, input, band)) {
        return;
    }
    const float across = cross(along, learn->rest);
    if (!bounds_within(across, band)) {
        return;
    }
    const float per_volt = inverse_root(input->link * input->link);
    const float swing = tuning->swing * tuning->flux_linkage * input->omega_e_ref * inverse;
    const float emf_share = tuning->per_band * bounds_magnitude(input->omega_e_ref) * per_volt;
    const float time = emf_share < 1.0f ? emf_share * emf_share * tuning->period : tuning->period;
    learn->seen = time;
    const float seen = across * twelfth(along) * weight * per_volt;
    const float missed = (1.0f / (ALONG * POWER)) * seen;
    const float share = learn->rate * time;
    const float wanted = learn->learnt + share * (learn->effective + missed - learn->learnt);
    learn->ripple = lowpass_step(learn->ripple, share, swing * swing);
    scatter(learn, input, share, per_volt);
    learn->rate = gain_step(learn->rate, tuning->rate, time);
    if (wanted >= tuning->least && wanted <= tuning->most) {
        learn->learnt = wanted;
    }
    const float follows = SMOOTH * bounds_magnitude(tuning->period * input->omega_e_ref);
    learn->smooth = lowpass_step(learn->smooth, follows, learn->learnt);
    use(learn);
}
