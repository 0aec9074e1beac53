/* Hyperbolic tangent as the ratio tanh(x)/x, a function of x^2 only, for switching functions that act on a
 * component or on the length of a vector: neither needs a square root.
 *
 *     tanh(x)/x = P(z)/Q(z),      z = x^2 <= 2   degree 1 over 2, relative error 8.4e-7; |tanh(x)| up to 0.89
 *     tanh(x)/x = c + R(z)/S(z),  2 < z <= 52    degree 2 over 3, relative error 1.1e-6
 *     tanh(x)/x = 1/sqrt(z),      52 < z         relative error 1.1e-6, the difference of tanh from 1
 *
 * and the rounding, 5e-7. The fits are minimax with equal errors at both seams, so that no piece begins above
 * the end of the previous one. All coefficients are positive: no cancellation. No state, no libm.
 *
 * Does not handle: negative, infinite and NaN squares in tanh_ratio (NaN gives NaN). */
#ifndef MATH_TANH_H
#define MATH_TANH_H

/* The end of the first piece. */
#define TANH_SHORT_END 2.0f

/* The two pieces beyond it, called by tanh_ratio(). */
float tanh_ratio_far(float square);

/* tanh(x)/x [-] from `square` = x^2 in [0, 1e30]: relative error <= 2e-6, exactly 1 at 0, falling (two
 * adjacent floats may round the other way by 3e-7). At most one division. */
static inline float tanh_ratio(float square)
{
    if (!(square <= TANH_SHORT_END)) {
        return tanh_ratio_far(square);
    }
    return (111.209503f + square * 10.4015303f) / (111.209503f + square * (47.4701691f + square));
}

/* tanh(x)/x [-] at the x where tanh(x)^2 is `square` in [0, 0.98]; above 0.98 the result is that of 0.98.
 * Twenty divisions: for resets. */
float tanh_ratio_at(float square);

/* tanh(x) [-]: relative and absolute error <= 2e-6, exactly odd, never beyond +-1, exactly +-1 for |x| > 7
 * (infinity included); NaN: 0. At most one division. */
float tanh_value(float x);

#endif
