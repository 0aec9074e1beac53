/* The drive of the commissioning tests: a limit of 10 A, a continuous current of 5 A, and a window of
 * eight periods. */
#ifndef TESTS_UNIT_COMMISSION_BENCH_H
#define TESTS_UNIT_COMMISSION_BENCH_H

#include "medium/commission/commission.h"

#define PERIOD 1e-4
#define PI     3.14159265358979323846
#define IM     ((double complex)I)

static const commission_tuning_t TUNING = {.current_max = 10.0f,
                                           .current_hold = 5.0f,
                                           .pole_pairs = 4.0f,
                                           .undervoltage = 200.0f,
                                           .noise_max = 0.03f,
                                           .period = (float)PERIOD,
                                           .window = 8e-4f,
                                           .inductance_d = 0.01f,
                                           .inductance_q = 0.01f,
                                           .flux_linkage = 0.1f,
                                           .inertia = 1e-3f};

#endif
