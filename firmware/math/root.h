/* Reciprocal square root, for lengths of vectors: r = 1/sqrt(x), sqrt(x) = x r.
 *
 * Halving and negating the exponent of the float, done on its bits, guesses r within 3.5 %; two Newton steps,
 * the first with minimax coefficients for this guess, the second centred, leave 3.2e-7 and the rounding.
 * Straight line, no state, no division, no libm. Source: the bit trick is common property; constants by own
 * minimax fit. */
#ifndef MATH_ROOT_H
#define MATH_ROOT_H

/* 1/sqrt(square): relative error <= 5e-7 for every `square` from 1e-37 to the largest float; the error
 * repeats with every factor of 4. Smaller ones, denormal floats and zero included, give something between
 * 1e18 and 3e19, so that 0 inverse_root(0) is 0. Does not handle negative or non-finite input. Nine
 * multiplications and subtractions. */
float inverse_root(float square);

#endif
