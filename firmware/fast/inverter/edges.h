#ifndef FAST_INVERTER_EDGES_H
#define FAST_INVERTER_EDGES_H
#include <stdbool.h>
#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    float current_per_volt; /* T/(24 L) [A/V] */
    float whole;            /* share for which the sampled switch of a leg of duty 0 is off [-] */
    float way;              /* 1, or -1 where the lower switches are sampled [-] */
    float lag;              /* 2 lag/T */
    float turn;             /* T/(4 sqrt(3)) [s] */
} edges_tuning_t;

#ifndef KNOT
#define KNOT 1.0f
#endif
#ifndef LAGS
#define LAGS 1.0f
#endif
#ifdef BEND
#define BENT(r) BEND
#else
#define BENT(r) (1.0f - (r)*(r))
#endif

typedef struct {
    abc_t first, second;
} edges_t;

static inline edges_tuning_t edges_prepare(float period, float inductance, float lag, bool upper)
{
    return (edges_tuning_t){
        period / (24.0f * inductance),
        upper ? 1.0f : 0.0f,
        upper ? 1.0f : -1.0f,
        LAGS * 2.0f * lag / period,
        0.25f * FRAMES_ONE_OVER_SQRT_3 * period,
    };
}

static inline float edges_sign(float current)
{
    return bounds_magnitude(current + 1.0f) - bounds_magnitude(current - 1.0f);
}

static inline float edges_meet(float begin, float end, float one, float other)
{
    return bounds_magnitude(begin - one) + bounds_magnitude(end - one) +
           bounds_magnitude(begin - other) + bounds_magnitude(end - other);
}

static inline edges_t edges_signs(const edges_tuning_t *edges, const edges_t *last, float per_zone, float late, abc_t duty, ab_t middle,
                                     ab_t change, float effective, float omega_e, float u_dc)
{
    const float way = edges->way;
    const float scale = way * per_zone;
    const float half_scale = 0.5f * scale;
    const float ampere = edges->current_per_volt * per_zone * u_dc;
    const float half = 0.5f * effective * ampere;
    const float later = 2.0f * late * half;
    const float far = KNOT * half + later;
    const float near = KNOT * half - later;
    const float band = 8.0f * half;
    const abc_t current = frames_inverse_clarke((ab_t){scale * middle.alpha, scale * middle.beta});
    const abc_t part = frames_inverse_clarke((ab_t){half_scale * change.alpha, half_scale * change.beta});
    const float whole = edges->whole;
    const abc_t rest = {whole - way * duty.a, whole - way * duty.b, whole - way * duty.c};
    const abc_t own = {ampere * rest.a, ampere * rest.b, ampere * rest.c};
    const abc_t fall = {own.a + half * last->first.a, own.b + half * last->first.b, own.c + half * last->first.c};
    const abc_t rise = {own.a + half * last->second.a, own.b + half * last->second.b, own.c + half * last->second.c};
    const float falls = 2.0f * (fall.a + fall.b + fall.c);
    const float rises = 2.0f * (rise.a + rise.b + rise.c);
    const abc_t u1 = {6.0f * fall.a - falls, 6.0f * fall.b - falls, 6.0f * fall.c - falls};
    const abc_t u2 = {6.0f * rise.a - rises, 6.0f * rise.b - rises, 6.0f * rise.c - rises};
    const abc_t f = {part.a + u1.a + u2.a, part.b + u1.b + u2.b, part.c + u1.c + u2.c};
    const float turn = edges->turn * omega_e;
    const float lag = edges->lag;
    const abc_t at = {
        current.a + lag * f.a - turn * (f.c - f.b) * BENT(rest.a),
        current.b + lag * f.b - turn * (f.a - f.c) * BENT(rest.b),
        current.c + lag * f.c - turn * (f.b - f.a) * BENT(rest.c),
    };
    const abc_t swing = {rest.a * f.a + band, rest.b * f.b + band, rest.c * f.c + band};
    return (edges_t){
        {edges_sign(at.a - swing.a + u2.a + edges_meet(own.a - far, own.a + near, fall.b, fall.c)),
         edges_sign(at.b - swing.b + u2.b + edges_meet(own.b - far, own.b + near, fall.c, fall.a)),
         edges_sign(at.c - swing.c + u2.c + edges_meet(own.c - far, own.c + near, fall.a, fall.b))},
        {edges_sign(at.a + swing.a - u1.a - edges_meet(own.a + far, own.a - near, rise.b, rise.c)),
         edges_sign(at.b + swing.b - u1.b - edges_meet(own.b + far, own.b - near, rise.c, rise.a)),
         edges_sign(at.c + swing.c - u1.c - edges_meet(own.c + far, own.c - near, rise.a, rise.b))},
    };
}
#endif
