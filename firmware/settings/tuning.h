/* Tuning: the coefficients of every module, derived from a set of parameters. Made in the background, with
 * all its divisions and exponentials; the interrupt takes it whole at the start of a step. */
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

/* What is believed: what was learnt, each value while its parameter is still that from which it began; all
 * else as the set says. */
believed_t drive_believed(const params_t *params, const learnt_t *learnt);

/* May the drive run on a set that params_check has accepted with this belief in the place of its own values?
 */
bool drive_may_believe(const params_t *params, const believed_t *believed);

/* Coefficients of a set that params_check has accepted, with `believed` in the place of what the set says of
 * motor and sensors, one that drive_may_believe(). For the background. */
void drive_prepare(drive_tuning_t *tuning, const params_t *params, const believed_t *believed);

#endif
