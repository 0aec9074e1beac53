/* avr-libc has no <complex.h>. This file declares the part that the tests use, with the 32-bit double. */
#ifndef TARGET_COMPLEX_H
#define TARGET_COMPLEX_H

#include <math.h>

#define complex _Complex
#define I       (__extension__ 1.0fi)

#define creal(z) __real__(z)
#define cimag(z) __imag__(z)

#define conj(z) target_conj(z)
#define cabs(z) target_cabs(z)
#define carg(z) target_carg(z)
#define cexp(z) target_cexp(z)

static inline double complex target_conj(double complex z)
{
    cimag(z) = -cimag(z);
    return z;
}

static inline double target_cabs(double complex z)
{
    return hypot(creal(z), cimag(z));
}

static inline double target_carg(double complex z)
{
    return atan2(cimag(z), creal(z));
}

static inline double complex target_cexp(double complex z)
{
    double complex turned;
    creal(turned) = exp(creal(z)) * cos(cimag(z));
    cimag(turned) = exp(creal(z)) * sin(cimag(z));
    return turned;
}

#endif
