/* Tuning: the coefficients of every module, derived from a set of parameters. Made in the background, with
 * all its divisions and exponentials; the interrupt takes it whole at the start of a step. */
#ifndef DRIVE_TUNING_H
#define DRIVE_TUNING_H

#include <stdbool.h>
#include <stdint.h>

#include "adapt/believed.h"
#include "adapt/dead_time_learn.h"
#include "adapt/emf_shape.h"
#include "adapt/flux.h"
#include "adapt/inductance.h"
#include "adapt/inertia.h"
#include "adapt/offset_trim.h"
#include "adapt/sums.h"
#include "adapt/unequal_legs.h"
#include "control/current_control.h"
#include "drive/guard.h"
#include "drive/manoeuvres.h"
#include "drive/measure.h"
#include "drive/params.h"
#include "drive/sequence.h"
#include "estimator/chosen.h"
#include "estimator/encoder.h"
#include "inverter/doubt.h"
#include "inverter/inverter.h"
#include "protect/current_watch.h"
#include "protect/encoder_watch.h"
#include "protect/link.h"
#include "protect/motion_watch.h"
#include "protect/oscillation_watch.h"
#include "protect/thermal.h"

/* Inductance, dead time and inertia learn from means of so many periods. */
#define DRIVE_LEARN_PERIODS 8u

/* Heat and the supply of the DC link are looked at every so many periods, in turn. */
#define DRIVE_LIMIT_PERIODS (2u * GUARD_LOOK_PERIODS)

/* From one judgement of the shaft's motion to the next [periods]. */
#define DRIVE_MOTION_PERIODS (2u * GUARD_LOOK_PERIODS)

typedef struct {
    measure_tuning_t measure;
    guard_tuning_t guard;
    uint32_t unattended_max; /* [periods] that the background may stay away from a running motor */
    sequence_tuning_t sequence;
    encoder_tuning_t encoder;
    chosen_tuning_t estimator;
    flux_tuning_t flux;
    offset_trim_tuning_t offset_trim;
    inductance_tuning_t inductance;
    inertia_tuning_t inertia;
    inverter_tuning_t inverter;
    dead_time_learn_tuning_t dead_time_learn;
    emf_shape_tuning_t emf_shape;
    unequal_legs_tuning_t unequal_legs;
    doubt_tuning_t doubt;
    current_control_tuning_t current_control;
    manoeuvres_tuning_t manoeuvres;
    encoder_watch_tuning_t encoder_watch;
    motion_watch_tuning_t motion_watch;
    oscillation_watch_tuning_t oscillation_watch;
    current_watch_tuning_t current_watch;
    thermal_tuning_t thermal;
    link_tuning_t link;
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
