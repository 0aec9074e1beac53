#include "adapt/dead_time_learn.h"

#include "adapt/gain.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"

/* Means over a sixth of a turn, with the weight of look_at(), of the signs across the current and of the
 * shape's sixth harmonic, whose amplitude is 1: of the one squared, of their product, of the other squared,
 * and what of the last the first leaves. */
#define OF_SIGNS (0.0848f)
#define OF_BOTH  (0.1793f)
#define OF_SHAPE (0.4629f)
#define OF_REST  (OF_SHAPE - OF_BOTH * OF_BOTH / OF_SIGNS)
#define ALIKE    (OF_BOTH / OF_SIGNS) /* [-] legs' voltage that a shape is taken for at first, over its own */

#define SHAPE_RATE        0.8f /* [-] of the rate of the dead time: that at which the two are told apart */
#define ALONE             0.7f /* [-] of its first spread, at which the dead time is no longer learnt alone */
#define PER_SIGNS_SQUARED 0.61685028f /* [-] (pi/4)^2: length of a direction over the mean signs along it */

dead_time_learn_tuning_t dead_time_learn_prepare(const dead_time_learn_params_t *params)
{
    const float effective = params->effective;
    const float current = DEAD_TIME_LEARN_ZONES * params->zone;
    const float drift = GAIN_LEAST * GAIN_LEAST * GAIN_FORGETS;
    const float time = params->rate / OF_SIGNS;
    const float shape = params->shaped ? params->rate * SHAPE_RATE / OF_REST : 0.0f;
    return (dead_time_learn_tuning_t){
        .rate = params->rate,
        .effective = effective,
        .least = effective < 0.0f ? effective : 0.0f,
        .most = DEAD_TIME_LEARN_RANGE * (effective > params->band ? effective : params->band),
        .band = params->band,
        .per_band = 1.0f / params->band,
        .time = time,
        .shape = shape,
        .time_drift = drift * (time * time * OF_SIGNS + ALIKE * ALIKE * shape * shape * OF_REST),
        .shape_drift = drift * shape * shape * OF_REST,
        .flux_linkage = params->flux_linkage,
        .current_square = current * current,
        .period = (float)params->every * params->period,
    };
}

void dead_time_learn_take(dead_time_learn_t *learn, const dead_time_learn_tuning_t *tuning)
{
    const bool same = tuning->effective == learn->tuning.effective && tuning->band == learn->tuning.band;
    if (!same || tuning->rate == 0.0f) {
        learn->effective = tuning->effective;
        learn->shape = (dq_t){0.0f, 0.0f};
        dead_time_learn_pause(learn);
    }
    if (!same || tuning->rate != learn->tuning.rate) {
        learn->spread = (dead_time_learn_spread_t){tuning->time, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        learn->fresh = 1u;
    }
    learn->tuning = *tuning;
}

/* The sixth power of a number of length 1. */
static ab_t sixth_power(ab_t unit)
{
    const float square_re = unit.alpha * unit.alpha - unit.beta * unit.beta;
    const float square_im = 2.0f * unit.alpha * unit.beta;
    const float cube_re = square_re * unit.alpha - square_im * unit.beta;
    const float cube_im = square_re * unit.beta + square_im * unit.alpha;
    return (ab_t){cube_re * cube_re - cube_im * cube_im, 2.0f * cube_re * cube_im};
}

/* From here on the shape is regressed beside the dead time, which has followed all that was seen until now.
 * What of that was a shape goes over to it more slowly, so far as at this EMF and this place of the current
 * it looks like dead time. */
static void begin(dead_time_learn_t *learn)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const dead_time_learn_look_t *look = &learn->look;
    const float in_line = look->rotor.alpha * look->rotor.alpha;
    const float alike = ALIKE * look->rotor.alpha * in_line * in_line * sixth_power(look->rotor).alpha;
    const float shape = tuning->shape * look->shrink;
    const float both = alike * look->due;
    learn->fresh = 0u;
    learn->spread.tt += both * both * shape;
    learn->spread.td = -both * shape;
    learn->spread.dd = shape;
    learn->spread.qq = shape;
}

static inline float cross(ab_t a, ab_t b)
{
    return a.alpha * b.beta - a.beta * b.alpha;
}

static inline float square_of(ab_t a)
{
    return a.alpha * a.alpha + a.beta * a.beta;
}

static inline bool same(ab_t a, ab_t b)
{
    return a.alpha == b.alpha && a.beta == b.beta;
}

/* Is there something to be seen, with a current of this square [A^2], beside the dead band's voltage [V]? Not
 * of what is no number. */
static bool visible(const dead_time_learn_tuning_t *tuning, const dead_time_learn_input_t *input,
                    float square, float band)
{
    const float due = tuning->flux_linkage * bounds_magnitude(input->omega_e_ref);
    const float least = DEAD_TIME_LEARN_EMF_LEAST * due;
    const float seen = square_of(input->emf);
    return due > DEAD_TIME_LEARN_EMF_MIN * band && due < DEAD_TIME_LEARN_EMF_MAX * band &&
           seen > least * least && seen < DEAD_TIME_LEARN_EMF_LIMIT * DEAD_TIME_LEARN_EMF_LIMIT &&
           square > tuning->current_square && square < DEAD_TIME_LEARN_EMF_LIMIT * DEAD_TIME_LEARN_EMF_LIMIT;
}

static inline float sign_of(float value)
{
    return value < 0.0f ? -1.0f : 1.0f;
}

/* The signs of the three currents as a vector [-]. */
static ab_t signs_of(ab_t current)
{
    const abc_t phases = frames_inverse_clarke(current);
    return frames_clarke((abc_t){sign_of(phases.a), sign_of(phases.b), sign_of(phases.c)});
}

/* A mean that turns by `turn` [rad] from one call to the next and follows the vector by `share` [-]. */
static inline ab_t follow(ab_t mean, float turn, float share, ab_t vector)
{
    const float kept = 1.0f - 0.5f * turn * turn;
    const ab_t turned = {kept * mean.alpha - turn * mean.beta, kept * mean.beta + turn * mean.alpha};
    return (ab_t){lowpass_step(turned.alpha, share, vector.alpha),
                  lowpass_step(turned.beta, share, vector.beta)};
}

/* The slow means; whether the current stands still. */
static void go_on(dead_time_learn_t *learn, const dead_time_learn_input_t *input, ab_t signs)
{
    if (learn->begun == 0u) {
        learn->begun = 1u;
        learn->emf_mean = input->emf;
        learn->signs_mean = (ab_t){0.0f, 0.0f}; /* long enough only after a third of a turn */
    }
    const float turn = learn->tuning.period * input->omega_e_ref;
    const float share = bounds_magnitude(turn);
    learn->emf_mean = follow(learn->emf_mean, turn, share, input->emf);
    learn->signs_mean = follow(learn->signs_mean, turn, share, signs);
    learn->moved = same(input->current, learn->current) ? 0u : 1u;
    learn->current = input->current;
}

/* Are speed and reference together, and does the current turn with them? */
static bool settled(const dead_time_learn_t *learn, const dead_time_learn_input_t *input, float band)
{
    const float missing = input->omega_e_ref - input->omega_e;
    return bounds_within(learn->tuning.flux_linkage * missing, DEAD_TIME_LEARN_MISS * band) &&
           PER_SIGNS_SQUARED * square_of(learn->signs_mean) > DEAD_TIME_LEARN_STEADY && learn->moved != 0u;
}

/* What this step shows, with that direction of the current [-] and one over the dead band's voltage [1/V]. */
static void look_at(dead_time_learn_t *learn, const dead_time_learn_input_t *input, ab_t along, ab_t signs,
                    float per_volt)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    dead_time_learn_look_t *look = &learn->look;
    const float per_signs = inverse_root(square_of(learn->signs_mean));
    const ab_t steady = {per_signs * learn->signs_mean.alpha, per_signs * learn->signs_mean.beta};
    const float per_emf = inverse_root(square_of(learn->emf_mean));
    const ab_t rotor = {per_emf * learn->emf_mean.alpha, per_emf * learn->emf_mean.beta};
    const ab_t emf = {input->emf.alpha - learn->emf_mean.alpha, input->emf.beta - learn->emf_mean.beta};
    const ab_t ripple = {signs.alpha - learn->signs_mean.alpha, signs.beta - learn->signs_mean.beta};
    const float due = tuning->flux_linkage * bounds_magnitude(input->omega_e_ref) * per_volt;
    look->seen = per_volt * cross(steady, emf);
    look->of_time = cross(steady, ripple);
    const ab_t sixth = sixth_power(rotor);
    look->rotor = (ab_t){steady.alpha * rotor.alpha + steady.beta * rotor.beta, cross(steady, rotor)};
    look->of_d = -due * look->rotor.alpha * sixth.beta;
    look->of_q = -due * look->rotor.beta * sixth.alpha;
    const float near = 0.5f - 0.5f * sixth_power(along).alpha;
    const float near_2 = near * near;
    const float near_4 = near_2 * near_2;
    const float slow = due < DEAD_TIME_LEARN_EMF_FULL ? due * (1.0f / DEAD_TIME_LEARN_EMF_FULL) : 1.0f;
    const float per_due = inverse_root(due * due);
    look->due = due;
    look->shrink = per_due * per_due;
    look->time = slow * slow * tuning->period;
    look->weight = look->time * (1.0f - near_4 * near_4);
}

void dead_time_learn_step(dead_time_learn_t *learn, const dead_time_learn_input_t *input)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const float band = tuning->band * input->link;
    const float square = square_of(input->current);
    learn->look.time = 0.0f;
    if (!visible(tuning, input, square, band)) {
        learn->begun = 0u;
        return;
    }
    const float inverse = inverse_root(square);
    const ab_t along = {inverse * input->current.alpha, inverse * input->current.beta};
    const ab_t signs = signs_of(input->current);
    go_on(learn, input, signs);
    if (!settled(learn, input, band)) {
        return;
    }
    look_at(learn, input, along, signs, tuning->per_band * inverse_root(input->link * input->link));
    if (!bounds_within(learn->look.seen, 1.0f)) {
        learn->look.time = 0.0f;
    }
}

/* What is known grows old, but no value less certain than at first. */
static void drift(dead_time_learn_t *learn)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const dead_time_learn_look_t *look = &learn->look;
    dead_time_learn_spread_t *spread = &learn->spread;
    const float most = tuning->shape * look->shrink;
    const float more = look->time * tuning->shape_drift * look->shrink;
    if (learn->fresh != 0u) {
        return;
    }
    spread->tt += spread->tt < tuning->time ? look->time * tuning->time_drift : 0.0f;
    spread->dd += spread->dd < most ? more : 0.0f;
    spread->qq += spread->qq < most ? more : 0.0f;
}

void dead_time_learn_follow(dead_time_learn_t *learn, float left)
{
    const dead_time_learn_tuning_t *tuning = &learn->tuning;
    const dead_time_learn_look_t *look = &learn->look;
    dead_time_learn_spread_t *spread = &learn->spread;
    if (look->time == 0.0f) {
        return;
    }
    if (learn->fresh != 0u && spread->tt < ALONE * tuning->time) {
        begin(learn);
    }
    const float t = look->of_time;
    const float d = look->of_d;
    const float q = look->of_q;
    const float by_t = spread->tt * t + spread->td * d + spread->tq * q;
    const float by_d = spread->td * t + spread->dd * d + spread->dq * q;
    const float by_q = spread->tq * t + spread->dq * d + spread->qq * q;
    const float missed = look->weight * (look->seen - left * learn->shape.d * d - learn->shape.q * q);
    const float wanted = learn->effective + tuning->band * by_t * missed;
    if (wanted >= tuning->least && wanted <= tuning->most) {
        learn->effective = wanted;
    }
    learn->shape.d = bounds_clamp(learn->shape.d + by_d * missed, DEAD_TIME_LEARN_SHAPE_MAX);
    learn->shape.q = bounds_clamp(learn->shape.q + by_q * missed, DEAD_TIME_LEARN_SHAPE_MAX);
    const float forgets = GAIN_FORGETS * look->weight;
    spread->tt -= forgets * by_t * by_t;
    spread->td -= forgets * by_t * by_d;
    spread->tq -= forgets * by_t * by_q;
    spread->dd -= forgets * by_d * by_d;
    spread->dq -= forgets * by_d * by_q;
    spread->qq -= forgets * by_q * by_q;
    drift(learn);
}
