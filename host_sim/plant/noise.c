#include "host_sim/plant/noise.h"

#define NOISE_SCALE 0.28767798089123053 /* 1/sqrt(12 + 1/12) */

uint64_t noise_next(uint64_t *state)
{
    *state += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t z = *state;
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static uint64_t ones(uint64_t x)
{
    x -= (x >> 1) & UINT64_C(0x5555555555555555);
    x = (x & UINT64_C(0x3333333333333333)) + ((x >> 2) & UINT64_C(0x3333333333333333));
    x = (x + (x >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f);
    return (x * UINT64_C(0x0101010101010101)) >> 56;
}

double noise_gauss(uint64_t *state)
{
    uint64_t word = noise_next(state);
    double count = (double)ones(word >> 16);
    double fraction = ((double)(word & 0xffffu) + 0.5) * (1.0 / 65536.0);
    return (count - 24.5 + fraction) * NOISE_SCALE;
}
