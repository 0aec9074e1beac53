/* The gain of the current sensors: the measured change of the current against that which the voltage has
 * made.
 */
#include "medium/protect/current_watch_parts.h"

#include "math/bounds.h"

#define GAIN_TURN    64.0f /* [-] Dp^2 over what the EMF's own turn may pretend, squared */
#define GAIN_SIDE    1.1f  /* [-] from which on one window's ratio takes a side */
#define GAIN_CURRENT 2.0f  /* [-] of what a phase carries, that one must: a catch is no measurement */
#define GAIN_SANE    0.35f /* [-] what is less, or more than its inverse, is a sample gone wrong */
#define GAIN_MOST    64.0f /* [-] of a window's Dp^2: then the sums begin anew */
#define GAIN_WINDOWS 2u    /* [windows] of one side */
#define GAIN_SIGMAS  9.0f  /* [-] of noise, squared, that a sum must be beyond its limit */
#define NOISE_LEAST  0.1f  /* [-] of the shortest Dp^2: less is none */
#define NOISE_MOST   0.1f  /* [-] likewise, of noise */
#define NOISE_SHARE  0.05f /* [-] of a window in the mean noise */
#define ZONE_SHARE   0.67f /* [-] of it, above which the loss of a leg stays as it is */

/* Does the loss of a leg stay as it is, for all of three window's ends? */
static inline bool keeps_sign(const current_watch_tuning_t *tuning, const current_watch_phase_t *phase,
                              float value)
{
    const float zone = ZONE_SHARE * tuning->none;
    const float first = phase->value - phase->change;
    return (value > zone && phase->value > zone && first > zone) ||
           (value < -zone && phase->value < -zone && first < -zone);
}

/* The side that a ratio takes. */
static inline int32_t side_of(float part, float whole)
{
    return part > GAIN_SIDE * whole ? 1 : GAIN_SIDE * part < whole ? -1 : 0;
}

/* A window's squares and products into sums of one side; for another they begin anew. true: there are enough
 * windows of them. */
static bool gather(current_watch_gain_t *gain, int32_t side, const float square[2], const float product[2])
{
    if (side != gain->side || gain->square[0] + gain->square[1] > GAIN_MOST * (square[0] + square[1])) {
        *gain = (current_watch_gain_t){.side = side};
    }
    gain->windows++;
    for (uint32_t n = 0; n < 2u; n++) {
        gain->square[n] += square[n];
        gain->product[n] += product[n];
    }
    return gain->windows >= GAIN_WINDOWS;
}

/* Is a sum beyond its limit by so much that noise does not explain it? `weight`: the sum of squares that
 * noise of one is multiplied with. */
static inline bool is_beyond(float over, float noise, float weight)
{
    return over > 0.0f && over * over > GAIN_SIGMAS * noise * weight;
}

/* Both sensors alike: the range, or L beyond what may be wrong of it. */
static bool is_wrong(const current_watch_tuning_t *tuning, const current_watch_gain_t *all, float noise)
{
    const float sum = all->product[0] + all->product[1];
    const float squares = all->square[0] + all->square[1];
    return is_beyond(tuning->gain_min * squares - sum, noise, squares) ||
           is_beyond(sum - tuning->gain_max * squares, noise, squares);
}

/* One beside the other, wherever L is. */
static bool is_uneven(const current_watch_tuning_t *tuning, const current_watch_gain_t *pair, float noise)
{
    const float weight = pair->square[0] * pair->square[1] * (pair->square[0] + pair->square[1]);
    const float one = pair->product[0] * pair->square[1];
    const float other = pair->product[1] * pair->square[0];
    return pair->square[0] > tuning->gain_pair && pair->square[1] > tuning->gain_pair &&
           (is_beyond(one - tuning->gain_ratio * other, noise, weight) ||
            is_beyond(other - tuning->gain_ratio * one, noise, weight));
}

bool current_watch_gain(current_watch_t *watch, const current_watch_input_t *input,
                        const current_watch_window_t *window)
{
    const current_watch_tuning_t *tuning = &watch->tuning;
    const current_watch_phase_t *phase = watch->phase;
    current_watch_gain_t *all = &watch->all;
    current_watch_gain_t *pair = &watch->pair;
    if (!input->comparable) {
        *all = (current_watch_gain_t){0};
        *pair = (current_watch_gain_t){0};
        return false;
    }
    const float step[2] = {window->moved[0] - phase[0].expected, window->moved[1] - phase[1].expected};
    const float square[2] = {step[0] * step[0], step[1] * step[1]};
    const float both = square[0] + square[1];
    const float speed = bounds_magnitude(input->omega_e) + input->doubt;
    const float turn = tuning->per_speed * window->periods * speed * window->periods * tuning->back * speed;
    const float residual[2] = {window->change[0] - phase[0].change - step[0],
                               window->change[1] - phase[1].change - step[1]};
    if (both < NOISE_LEAST * tuning->gain_least) { /* next to nothing new: what is left is noise */
        const float mean = 0.5f * (residual[0] * residual[0] + residual[1] * residual[1]);
        watch->noise += NOISE_SHARE * (bounds_clamp(mean, NOISE_MOST * tuning->gain_least) - watch->noise);
        return false;
    }
    const float swing = tuning->gain_swing * window->periods * window->periods * window->largest;
    if (both < tuning->gain_least || both < GAIN_TURN * turn * turn || both < swing * swing ||
        watch->windows < 3u || window->largest < GAIN_CURRENT * tuning->carries || watch->steered == 0u ||
        watch->suspected != 0u || !keeps_sign(tuning, &phase[0], window->value[0]) ||
        !keeps_sign(tuning, &phase[1], window->value[1]) ||
        !keeps_sign(tuning, &phase[2], window->value[2])) {
        return false;
    }
    const float product[2] = {step[0] * (window->change[0] - phase[0].change),
                              step[1] * (window->change[1] - phase[1].change)};
    const float sum = product[0] + product[1];
    bool wrong = false;
    if (sum < GAIN_SANE * both || GAIN_SANE * sum > both) {
        *all = (current_watch_gain_t){0};
        *pair = (current_watch_gain_t){0};
    } else {
        const bool enough = gather(all, side_of(sum, both), square, product);
        const int32_t side = side_of(product[0] * square[1], product[1] * square[0]);
        wrong = gather(pair, side, square, product) && is_uneven(tuning, pair, watch->noise);
        wrong = wrong || (enough && is_wrong(tuning, all, watch->noise));
    }
    return wrong;
}
