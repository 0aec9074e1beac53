/* Hyperbolic tangent as the ratio tanh(x)/x, a function of x^2 alone, for switching functions that act on a
 * component or on the length of a vector: neither needs a square root.
 *
 *     tanh(x)/x = P(z)/Q(z),  z = x^2 <= 64       rational of degree 3 over 4, relative error 1.6e-7
 *     tanh(x)/x = 1/sqrt(z),  z > 64              relative error 2.3e-7, what tanh(8) lacks to 1
 *
 * All coefficients are positive (the poles and zeros of tanh(x)/x interlace on the negative z axis), so
 * nothing cancels. No state, no libm.
 *
 * Does not handle NaN in tanh_ratio; tanh_value gives 0 there. */
#ifndef MATH_TANH_H
#define MATH_TANH_H

/* tanh(x)/x [-] from `square` = x^2 in [0, 1e30]: relative error <= 1e-6, exactly 1 at 0, falling. Below 0 (a
 * rounding) as 0; above 1e30 as there. At most one division. */
float tanh_ratio(float square);

/* tanh(x) [-]: relative and absolute error <= 1e-6, odd bit for bit, never beyond +-1, exactly +-1 for |x| >
 * 8 (infinity included); NaN: 0. At most one division. */
float tanh_value(float x);

#endif
