#ifndef FAST_INVERTER_EDGES_H
#define FAST_INVERTER_EDGES_H

#include <stdbool.h>

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    float current_per_volt; /* T/(12 L) [A/V] */
    float whole;            /* share for which the sampled switch of a leg of duty 0 is off [-] */
    float way;              /* 1, or -1 where the lower switches are sampled [-] */
    float lag;              /* change by EMF in the delay of all edges over that in half a period [-] */
    float turn;             /* 3/16 T [s] */
} edges_tuning_t;

/* Twice the signs of each leg, -2 to 2; positive in the direction of the sampled switches. */
typedef struct {
    abc_t first, second;
} edges_t;

static inline edges_tuning_t edges_prepare(float period, float inductance, float delay, bool upper)
{
    return (edges_tuning_t){
        period / (12.0f * inductance), upper ? 1.0f : 0.0f, upper ? 1.0f : -1.0f, 2.0f * delay / period,
        0.1875f * period,
    };
}

/* Twice the sign of a current between -`minus` and `plus`. */
static inline float edges_sign(float current, float minus, float plus)
{
    return bounds_magnitude(current + minus) - bounds_magnitude(current - plus);
}

/* Sum of the distances of an instant from those of two edges. */
static inline float edges_apart(float instant, float one, float other)
{
#ifdef TWO
    return 0.5f * (bounds_magnitude(instant - TWO - one) + bounds_magnitude(instant + TWO - one)+bounds_magnitude(instant - TWO - other) + bounds_magnitude(instant + TWO - other));
#else
    return bounds_magnitude(instant - one) + bounds_magnitude(instant - other);
#endif
}

static inline edges_t edges_signs(const edges_tuning_t *edges, const edges_t *last, float per_zone, abc_t duty,
                                  ab_t middle, ab_t change, float effective, float omega_e, float u_dc)
{
    const float way = edges->way;
    const float scale = way * per_zone;
    const float half_scale = 0.5f * scale;
    const float ampere = edges->current_per_volt * per_zone * u_dc;
    const float half = 0.5f * effective * ampere;
    const float later = 16.0f / 3.0f * half * half;
    const float whole = edges->whole;
    const abc_t own = {ampere * (whole - way * duty.a), ampere * (whole - way * duty.b),
                       ampere * (whole - way * duty.c)};
    const abc_t fall = {own.a + half * last->first.a, own.b + half * last->first.b,
                        own.c + half * last->first.c};
    const abc_t rise = {own.a + half * last->second.a, own.b + half * last->second.b,
                        own.c + half * last->second.c};
    const abc_t both = {fall.a + rise.a, fall.b + rise.b, fall.c + rise.c};
    const float falls = fall.a + fall.b + fall.c;
    const float rises = rise.a + rise.b + rise.c;
    const ab_t free = {half_scale * change.alpha + (3.0f * both.a - (falls + rises)),
                       half_scale * change.beta + FRAMES_SQRT_3 * (both.b - both.c)};
    const float turn = edges->turn * omega_e;
    const float lag = edges->lag;
    const abc_t at = frames_inverse_clarke((ab_t){scale * middle.alpha + lag * free.alpha + turn * free.beta,
                                                  scale * middle.beta + lag * free.beta - turn * free.alpha});
    const abc_t f = frames_inverse_clarke(free);
    const abc_t swing = {(whole - way * duty.a) * f.a, (whole - way * duty.b) * f.b,
                         (whole - way * duty.c) * f.c};
    const float band = 1.0f + 4.0f * half;
    const float early_plus = band + rises;
    const float early_minus = 2.0f - early_plus;
    const float late_minus = band + falls;
    const float late_plus = 2.0f - late_minus;
    return (edges_t){
        {edges_sign(at.a - swing.a + 3.0f * rise.a + edges_apart(own.a - later, fall.b, fall.c), early_minus, early_plus),
         edges_sign(at.b - swing.b + 3.0f * rise.b + edges_apart(own.b - later, fall.c, fall.a), early_minus, early_plus),
         edges_sign(at.c - swing.c + 3.0f * rise.c + edges_apart(own.c - later, fall.a, fall.b), early_minus, early_plus)},
        {edges_sign(at.a + swing.a - 3.0f * fall.a - edges_apart(own.a + later, rise.b, rise.c), late_minus, late_plus),
         edges_sign(at.b + swing.b - 3.0f * fall.b - edges_apart(own.b + later, rise.c, rise.a), late_minus, late_plus),
         edges_sign(at.c + swing.c - 3.0f * fall.c - edges_apart(own.c + later, rise.a, rise.b), late_minus, late_plus)},
    };
}

#endif
