/* Tuning: the coefficients of every module, derived from a set of parameters. The background computes it,
 * with all divisions and exponentials; the interrupt takes it over as a whole at the start of a step. */
#ifndef SETTINGS_TUNING_H
#define SETTINGS_TUNING_H

#include <stdbool.h>
#include <stdint.h>

#include "fast/fast.h"
#include "medium/adapt/believed.h"
#include "medium/medium.h"
#include "settings/params.h"

typedef struct {
    fast_tuning_t fast;
    medium_tuning_t medium;
} drive_tuning_t;

/* The assumed values: each learnt value while its parameter is still the one from which learning
 * started; all others from the set. */
believed_t drive_believed(const params_t *params, const learnt_t *learnt);

/* True if the drive may run with a set that params_check has accepted, with these
 * assumed values in place of its own. */
bool drive_may_believe(const params_t *params, const believed_t *believed);

/* Coefficients of a set that params_check has accepted, with `believed`, accepted by drive_may_believe(), in
 * place of the set's values of motor and sensors. For the background. */
void drive_prepare(drive_tuning_t *tuning, const params_t *params, const believed_t *believed);

#endif
