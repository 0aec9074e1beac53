/* The gain of the current sensors: the measured change of the current compared
 * with the change by the voltage. */
#include "medium/protect/current_watch_parts.h"

#include "math/bounds.h"

#define GAIN_TURN    64.0f /* [-] Dp^2 over the error by the turn of the EMF, squared */
#define GAIN_SIDE    1.1f  /* [-] ratio from which one window takes a side */
#define GAIN_CURRENT 2.0f  /* [-] of the largest phase current: least current of this phase */
#define GAIN_SANE    0.35f /* [-] a smaller ratio, or one above its inverse, is an invalid sample */
#define GAIN_MOST    64.0f /* [-] of a window's Dp^2: above this the sums restart */
#define GAIN_WINDOWS 2u    /* [windows] of one side */
#define GAIN_SIGMAS  9.0f  /* [-] of noise, squared: least excess of a sum over its limit */
#define NOISE_LEAST  0.1f  /* [-] of the smallest Dp^2: noise below this is ignored */
#define NOISE_MOST   0.1f  /* [-] of the smallest Dp^2: largest noise */
#define NOISE_SHARE  0.05f /* [-] of a window in the mean noise */
#define GAIN_AXES    1.5f  /* [-] largest effect of the noise of two sensors on the length of the vector */
#define ZONE_SHARE   0.67f /* [-] of the zone: above this the loss of a leg is constant */

/* True if the loss of a leg is constant at all three window ends. */
static inline bool keeps_sign(const current_watch_tuning_t *tuning, const current_watch_phase_t *phase,
                              float value)
{
    const float zone = ZONE_SHARE * tuning->none;
    const float first = phase->value - phase->change;
    return (value > zone && phase->value > zone && first > zone) ||
           (value < -zone && phase->value < -zone && first < -zone);
}

/* The side of a ratio. */
static inline int32_t side_of(float part, float whole)
{
    return part > GAIN_SIDE * whole ? 1 : GAIN_SIDE * part < whole ? -1 : 0;
}

/* Adds the squares and products of a window to the sums of one side; the sums restart for another side.
 * true: there are enough windows. */
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

/* True if a sum exceeds its limit by more than noise can explain. `weight`: the sum of squares by which
 * the noise of one is multiplied. */
static inline bool is_beyond(float over, float noise, float weight)
{
    return over > 0.0f && over * over > GAIN_SIGMAS * noise * weight;
}

/* True if the gain of both sensors is wrong: the range, or L outside its assumed error. The products are
 * those of the vectors, so that their ratio is between those of L_d and of L_q for any position of a salient
 * rotor. */
static bool is_wrong(const current_watch_tuning_t *tuning, const current_watch_gain_t *all, float noise)
{
    const float sum = all->product[0] + all->product[1];
    const float squares = all->square[0] + all->square[1];
    return is_beyond(tuning->gain.min * squares - sum, noise, GAIN_AXES * squares) ||
           is_beyond(sum - tuning->gain.max * squares, noise, GAIN_AXES * squares);
}

/* True if one sensor differs from the other, for any L. */
static bool is_uneven(const current_watch_tuning_t *tuning, const current_watch_gain_t *pair, float noise)
{
    const float weight = pair->square[0] * pair->square[1] * (pair->square[0] + pair->square[1]);
    const float one = pair->product[0] * pair->square[1];
    const float other = pair->product[1] * pair->square[0];
    return pair->square[0] > tuning->gain.pair && pair->square[1] > tuning->gain.pair &&
           (is_beyond(one - tuning->gain.ratio * other, noise, weight) ||
            is_beyond(other - tuning->gain.ratio * one, noise, weight));
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
    if (both < NOISE_LEAST * tuning->gain.least) { /* nearly no change: the difference is noise */
        const float mean = 0.5f * (residual[0] * residual[0] + residual[1] * residual[1]);
        watch->noise += NOISE_SHARE * (bounds_clamp(mean, NOISE_MOST * tuning->gain.least) - watch->noise);
        return false;
    }
    const float swing = tuning->gain.swing * window->periods * window->periods * window->largest;
    if (both < tuning->gain.least || both < GAIN_TURN * turn * turn || both < swing * swing ||
        watch->windows - watch->unknown < 3u || window->largest < GAIN_CURRENT * tuning->carries ||
        watch->steered == 0u || watch->suspected != 0u || !keeps_sign(tuning, &phase[0], window->value[0]) ||
        !keeps_sign(tuning, &phase[1], window->value[1]) ||
        !keeps_sign(tuning, &phase[2], window->value[2])) {
        return false;
    }
    const float moved[2] = {window->change[0] - phase[0].change, window->change[1] - phase[1].change};
    const float product[2] = {step[0] * moved[0], step[1] * moved[1]};
    /* Of the vectors: three quarters of the square of a length are a^2 + b^2 + a b. */
    const float square_all[2] = {square[0] + 0.5f * step[0] * step[1], square[1] + 0.5f * step[0] * step[1]};
    const float product_all[2] = {product[0] + 0.5f * step[0] * moved[1],
                                  product[1] + 0.5f * step[1] * moved[0]};
    const float length = square_all[0] + square_all[1];
    const float sum = product_all[0] + product_all[1];
    bool wrong = false;
    if (sum < GAIN_SANE * length || GAIN_SANE * sum > length) {
        *all = (current_watch_gain_t){0};
        *pair = (current_watch_gain_t){0};
    } else {
        const float least = tuning->gain.axis * length;
        if (square[0] >= least && square[1] >= least) {
            const int32_t side = side_of(product[0] * square[1], product[1] * square[0]);
            wrong = gather(pair, side, square, product) && is_uneven(tuning, pair, watch->noise);
        }
        const bool enough = gather(all, side_of(sum, length), square_all, product_all);
        wrong = wrong || (enough && is_wrong(tuning, all, watch->noise));
    }
    return wrong;
}
