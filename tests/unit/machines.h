/* Machines for the tests of the observer, from a large slow one to a small fast one, and the paper's
 * observer. */
#ifndef TESTS_UNIT_MACHINES_H
#define TESTS_UNIT_MACHINES_H

#include "estimator/smo.h"
#include "tests/unit/compare.h"

#define RAD_PER_RPM (4.0 * PI / 30.0) /* electrical, 4 pole pairs */

/* R, L, psi_f and top speed. The last machine is an artificial one at the limits of the observer: R T/L =
 * 0.5, omega T = 0.6. */
static const struct {
    double resistance, inductance, flux_linkage, omega_max;
} MACHINES[] = {{0.95, 0.0125, 0.183, 1500.0 * RAD_PER_RPM},
                {0.2, 0.0008, 0.02, 3000.0},
                {5.0, 0.03, 0.3, 1000.0},
                {0.01, 0.0001, 0.008, 3000.0},
                {30.0, 0.01, 0.05, 2000.0},
                {50.0, 0.01, 0.05, 6000.0}};
#define MACHINE_COUNT ((int)(sizeof MACHINES / sizeof MACHINES[0]) - 1)
#define EXTREME       MACHINE_COUNT

static const smo_params_t PAPER = {.resistance = 0.95f,
                                   .inductance = 0.0125f,
                                   .gain = 200.0f,
                                   .slope = 1.0f,
                                   .emf_cutoff = 0.0f,
                                   .period = 1e-4f,
                                   .switching = SMO_SIGMOID};

/* The observer for a machine: vector sigmoid, k_s and slope by the rule (docs/theory.md, 3). */
static inline smo_params_t observer_of(int machine, float emf_cutoff)
{
    const double gain = 1.75 * MACHINES[machine].flux_linkage * MACHINES[machine].omega_max;
    return (smo_params_t){.resistance = (float)MACHINES[machine].resistance,
                          .inductance = (float)MACHINES[machine].inductance,
                          .gain = (float)gain,
                          .slope = (float)(1.6 * MACHINES[machine].inductance / (gain * 1e-4)),
                          .emf_cutoff = emf_cutoff,
                          .period = 1e-4f,
                          .switching = SMO_SIGMOID_VECTOR};
}

static inline ab_t as_float(const double value[2])
{
    return (ab_t){(float)value[0], (float)value[1]};
}

#endif
