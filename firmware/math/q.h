/* Arithmetic of the fixed-point modules: numbers in Q formats, 64-bit products, saturation and binary angles.
 *
 * A number in Qn is an int32_t that counts in units of 2^-n of its base (estimator/fixed/formats.h). A
 * product of Qm and Qn is Qm+n in 64 bits; q_round() converts it back, to the nearest, halves upward. An
 * angle is a uint32_t that counts in 2^-32 of a turn: it wraps by overflow.
 *
 * No operation here is undefined or depends on the compiler: no shift of a negative number except in
 * q_floor(), no signed overflow, no conversion that does not fit. Each function states its saturation and the
 * conditions for its caller; tools/check-values proves that the callers meet them. No state, no float. */
#ifndef MATH_Q_H
#define MATH_Q_H

#include <stdint.h>

#define Q_LARGEST INT32_MAX

/* 1 in Qn. */
#define Q_ONE(n) (INT32_C(1) << (n))

/* A constant in Qn, rounded; |value| 2^n must be below 2^31. The compiler evaluates it. */
#define Q_CONST(n, value) ((int32_t)((value) * (float)(INT32_C(1) << (n)) + ((value) < 0.0f ? -0.5f : 0.5f)))

/* floor(x / 2^n), n in 1..62, without the shift of a negative number: x is made positive first. */
static inline int64_t q_floor_raised(int64_t x, int32_t n)
{
    uint64_t raised = (uint64_t)x + (UINT64_C(1) << 63);
    return (int64_t)(raised >> n) - (INT64_C(1) << (63 - n));
}

/* The same. The result of >> for a negative number depends on the compiler, which selects the form at compile
 * time. */
static inline int64_t q_floor(int64_t x, int32_t n)
{
    return (INT64_C(-3) >> 1) == INT64_C(-2) ? x >> n : q_floor_raised(x, n);
}

/* x / 2^n to the nearest, n in 1..62; x + 2^(n-1) must fit. */
static inline int64_t q_round(int64_t x, int32_t n)
{
    return q_floor(x + (INT64_C(1) << (n - 1)), n);
}

/* floor(a b / 2^32): the upper word of the product, one instruction on many processors. */
static inline int32_t q_high(int32_t a, int32_t b)
{
    return (int32_t)q_floor((int64_t)a * b, 32);
}

static inline uint32_t q_high_unsigned(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 32);
}

/* The same to the nearest. */
static inline int32_t q_high_near(int32_t a, int32_t b)
{
    return (int32_t)q_round((int64_t)a * b, 32);
}

/* x / 2^32 toward zero: an exactly odd function, also where halves are frequent. */
static inline int32_t q_word(int64_t x)
{
    return (int32_t)q_floor(x + (x < 0 ? INT64_C(0xffffffff) : 0), 32);
}

/* The end of -end .. end - 1 that x exceeds. It is a call, so that this rare case costs a branch and not two
 * selections. */
int32_t q_end(int32_t x, int32_t end);

/* Joins the two words of x. */
static inline int64_t q_join(int32_t high, int64_t x)
{
    return (int64_t)high * (INT64_C(1) << 32) + (int64_t)((uint64_t)x & UINT32_C(0xffffffff));
}

/* x / 2^n to the nearest within -2^m .. 2^m - 1, n in 1..31, m in 32 - n..30; x + 2^(n-1) must fit. The upper
 * word is limited, so that a result beyond the range is within 2^(32-n) of the end. */
static inline int32_t q_cut(int64_t x, int32_t n, int32_t m)
{
    const int32_t end = Q_ONE(m + n - 32);
    int64_t raised = x + (INT64_C(1) << (n - 1));
    int32_t high = (int32_t)q_floor(raised, 32);
    if (high < -end || high >= end) {
        high = q_end(high, end);
    }
    return high * Q_ONE(32 - n) + (int32_t)((uint32_t)((uint64_t)raised & UINT32_C(0xffffffff)) >> n);
}

/* x within +-Q_LARGEST. */
static inline int32_t q_saturate(int64_t x)
{
    if (x > Q_LARGEST) {
        return Q_LARGEST;
    }
    return x < -Q_LARGEST ? -Q_LARGEST : (int32_t)x;
}

/* x within +-limit; limit >= 0. */
static inline int32_t q_clamp(int32_t x, int32_t limit)
{
    int32_t upper = x < limit ? x : limit;
    return upper > -limit ? upper : -limit;
}

static inline int64_t q_clamp_long(int64_t x, int64_t limit)
{
    int64_t upper = x < limit ? x : limit;
    return upper > -limit ? upper : -limit;
}

/* |x|; of INT32_MIN: Q_LARGEST. */
static inline int32_t q_magnitude(int32_t x)
{
    if (x >= 0) {
        return x;
    }
    return x < -Q_LARGEST ? Q_LARGEST : -x;
}

static inline int64_t q_product(int32_t a, int32_t b)
{
    return (int64_t)a * b;
}

/* a b / 2^n to the nearest; the result must fit. */
static inline int32_t q_multiply(int32_t a, int32_t b, int32_t n)
{
    return (int32_t)q_round(q_product(a, b), n);
}

/* The same, saturated. */
static inline int32_t q_multiply_saturated(int32_t a, int32_t b, int32_t n)
{
    return q_saturate(q_round(q_product(a, b), n));
}

/* a + b, a - b, saturated. */
static inline int32_t q_add(int32_t a, int32_t b)
{
    return q_saturate((int64_t)a + b);
}

static inline int32_t q_subtract(int32_t a, int32_t b)
{
    return q_saturate((int64_t)a - b);
}

/* x^2, x^2 + y^2; both always fit. INT32_MIN counts as -Q_LARGEST. */
static inline uint64_t q_square(int32_t x)
{
    uint32_t length = (uint32_t)q_magnitude(x);
    return (uint64_t)length * length;
}

static inline uint64_t q_square_sum(int32_t x, int32_t y)
{
    return q_square(x) + q_square(y);
}

/* An angle as a number from -1/2 to below 1/2 turn, and the inverse. */
static inline int32_t q_signed(uint32_t angle)
{
    return angle > UINT32_C(0x7fffffff) ? -(int32_t)(UINT32_C(0xffffffff) - angle) - 1 : (int32_t)angle;
}

/* Number of leading zero bits of x: 0..63; of 0: 63. Six compares. */
static inline int32_t q_leading_zeros(uint64_t x)
{
    int32_t zeros = 0;
    uint32_t high = (uint32_t)(x >> 32);
    if (high == 0u) {
        zeros = 32;
        high = (uint32_t)x;
    }
    if (high < UINT32_C(0x10000)) {
        zeros += 16;
        high <<= 16;
    }
    if (high < UINT32_C(0x1000000)) {
        zeros += 8;
        high <<= 8;
    }
    if (high < UINT32_C(0x10000000)) {
        zeros += 4;
        high <<= 4;
    }
    if (high < UINT32_C(0x40000000)) {
        zeros += 2;
        high <<= 2;
    }
    return zeros + (high < UINT32_C(0x80000000));
}

/* A coefficient whose size is not known at compile time: mantissa step / 2^32. */
typedef struct {
    int32_t mantissa; /* 2^30..2^31 - 1, or 0 [-] */
    int32_t step;     /* a power of two, limited by the type near 2^31 [-] */
} q_scale_t;

/* x times the coefficient, in the format of x shifted as defined for the coefficient: x mantissa / 2^32 in
 * whole steps. */
static inline int64_t q_scaled(int32_t x, q_scale_t scale)
{
    return q_product(q_high_near(x, scale.mantissa), scale.step);
}

#endif
