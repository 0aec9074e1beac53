/* Random numbers of the plant: splitmix64 (Steele, Lea, Flood 2014; public-domain reference by S. Vigna) and
 * a nearly Gaussian variable that is computed from it with integers only, so that it is the same on every
 * machine.
 *
 * One word makes one variable: the number of ones among 48 bits (binomial, variance 12) plus the other 16
 * bits as a fraction of one (uniform, variance 1/12), scaled: mean 0, variance 1, excess kurtosis
 * -6.0083/12.0833^2 = -0.041, never beyond 7.05. */
#ifndef HOST_SIM_PLANT_NOISE_H
#define HOST_SIM_PLANT_NOISE_H

#include <stdint.h>

uint64_t noise_next(uint64_t *state); /* 64 random bits; every state is valid */
double noise_gauss(uint64_t *state);  /* [-] mean 0, standard deviation 1; one word */

#endif
