/* Functions that the tests use and avr-libc's <math.h> does not have. */
#ifndef TARGET_MATH_H
#define TARGET_MATH_H

#include_next <math.h>

float nextafterf(float from, float to);
double expm1(double x);
double atanh(double x);
double nearbyint(double x);
double remainder(double x, double y);

#endif
