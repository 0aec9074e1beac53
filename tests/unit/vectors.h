/* Space vectors as complex numbers in double precision. */
#ifndef TESTS_UNIT_VECTORS_H
#define TESTS_UNIT_VECTORS_H

#include <complex.h>

#include "math/frames.h"
#include "tests/unit/compare.h"

#define J ((double complex)I)

static inline double complex of_ab(ab_t vector)
{
    return (double)vector.alpha + J * (double)vector.beta;
}

static inline double complex of_dq(dq_t vector)
{
    return (double)vector.d + J * (double)vector.q;
}

static inline dq_t to_dq(double complex vector)
{
    return (dq_t){(float)creal(vector), (float)cimag(vector)};
}

static inline ab_t to_ab(double complex vector)
{
    return (ab_t){(float)creal(vector), (float)cimag(vector)};
}

/* The component of phase 0, 1 or 2. */
static inline double phase_of(double complex vector, int phase)
{
    return creal(vector * cexp(-J * (2.0 * PI / 3.0 * phase)));
}

#endif
