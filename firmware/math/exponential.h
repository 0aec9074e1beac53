/* Exponential function of a decay, for the coefficients of sampled systems: exp(x) and 1 - exp(-x).
 *
 *     exp(x) = 2^n exp(r),  n = round(x / ln 2),  r = x - n ln 2
 *
 * with a minimax polynomial on |r| <= ln(2)/2; 1 - exp(-x) has a polynomial of its own below ln 2, where the
 * difference would lose its digits. No state, no libm. For init: about 30 multiplications, several branches,
 * no division.
 *
 * Does not handle: growing exponentials. */
#ifndef MATH_EXPONENTIAL_H
#define MATH_EXPONENTIAL_H

/* exp(x) [-] for x in [-80, 0]: relative error <= 5e-7, exactly 1 at 0. Above 0 it is 1; below -80 and for
 * NaN it is 0. */
float exponential(float x);

/* 1 - exp(-x) [-] for x in [0, 80]: relative error <= 5e-7 for any small x. Below 0 and for NaN it is 0;
 * above 80 it is 1. */
float exponential_rest(float x);

#endif
