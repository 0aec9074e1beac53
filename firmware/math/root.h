/* Reciprocal square root, for lengths of vectors: r = 1/sqrt(x), sqrt(x) = x r.
 *
 * Halving and negating the exponent of the float, done on its bits, guesses r within 3.5 %; two Newton steps,
 * the first with minimax coefficients for this guess, make the rest. Straight line, no state, no division, no
 * libm. Source: the bit trick is common property; constants by own minimax fit. */
#ifndef MATH_ROOT_H
#define MATH_ROOT_H

/* The range of inverse_root(). */
#define INVERSE_ROOT_SMALLEST 1e-30f
#define INVERSE_ROOT_LARGEST  1e30f

/* 1/sqrt(square) for `square` in [1e-30, 1e30]: relative error <= 6e-7. Zero and other values below the range
 * give something finite and positive, so that 0 inverse_root(0) is 0. Does not handle negative or non-finite
 * input. */
float inverse_root(float square);

#endif
