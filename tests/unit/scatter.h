/* Random values for tests of the modules. */
#ifndef TESTS_UNIT_SCATTER_H
#define TESTS_UNIT_SCATTER_H

#include <stdlib.h>

/* Mean 0, standard deviation 1 [-], by the sum of twelve even values. */
static inline double scatter_gauss(void)
{
    double sum = -6.0;
    for (int n = 0; n < 12; n++) {
        sum += (double)rand() / RAND_MAX;
    }
    return sum;
}

#endif
