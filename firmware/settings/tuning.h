/* Tuning: the coefficients of every module, derived from a set of parameters. The background computes it,
 * with all divisions and exponentials; the interrupt takes it over as a whole at the start of a step. */
#ifndef SETTINGS_TUNING_H
#define SETTINGS_TUNING_H

#include <stdbool.h>
#include <stdint.h>

#include "fast/fast.h"
#include "medium/adapt/assumed.h"
#include "medium/medium.h"
#include "settings/params.h"

typedef struct {
    fast_tuning_t fast;
    medium_tuning_t medium;
} drive_tuning_t;

/* The assumed values: each learnt value while its parameter is still the one from which learning
 * started; all others from the set. */
assumed_t drive_assumed(const params_t *params, const learnt_t *learnt);

/* True if the drive may run with these assumed values in place of those of a set that params_check has
 * accepted. */
bool drive_may_assume(const params_t *params, const assumed_t *assumed);

/* Coefficients of a set that params_check has accepted, with `assumed`, accepted by drive_may_assume(), in
 * place of the set's values of motor and sensors. For the background. */
void drive_prepare(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed);

#endif
