/* The estimator of the drive: the one in float (estimator.h) or its fixed-point version (fixed/fixed.h),
 * selected by the build (LAGLESS_ESTIMATOR). Only this file depends on the selection. Both versions take the
 * same parameters and fill the same structs of estimate.h, their members `estimate` and `observed`. */
#ifndef ESTIMATOR_CHOSEN_H
#define ESTIMATOR_CHOSEN_H

#ifdef LAGLESS_ESTIMATOR_FIXED

#include "estimator/fixed/fixed.h"

/* Largest L_q/L_d of a supported motor [-]: this version assumes the active flux to be psi_f, and with a
 * larger ratio the EMF of the feed-forward makes the tracking loop unstable under load (docs/theory.md,
 * 6). */
#define CHOSEN_SALIENT_MAX 1.2f
#define CHOSEN_SALIENT     "1.2"

/* Least saturation current of the q axis over the current limit [-]: this version has no saturation, and at
 * this ratio L_q changes by half a percent. */
#define CHOSEN_SATURATION_LEAST 10.0f
#define CHOSEN_SATURATION_TEXT                                                                               \
    "at least 10 current_limit, because the fixed-point estimator has no saturation"

/* Largest electrical turn in a period [rad], that of the law of the lag in this version (lag_q.h). */
#define CHOSEN_TURN_MAX  LAG_TURN_LIMIT_FIXED
#define CHOSEN_TURN_TEXT "0.63"

typedef fixed_t chosen_t;
typedef fixed_tuning_t chosen_tuning_t;
#define chosen_params_check fixed_params_check
#define chosen_prepare      fixed_prepare
#define chosen_take         fixed_take
#define chosen_init         fixed_init
#define chosen_set_flux     fixed_set_flux
#define chosen_set_load     fixed_set_load
#define chosen_set_lean     fixed_set_lean
#define chosen_reset        fixed_reset
#define chosen_step         fixed_step
#define chosen_track        (void)fixed_step /* includes the judgement */
#define chosen_coast        fixed_coast
#define chosen_observe      fixed_observe
#define chosen_lock         fixed_lock

#else

#include "estimator/estimator.h"

/* Largest L_q/L_d of a supported motor [-], the limit of the tests (docs/theory.md, 30). */
#define CHOSEN_SALIENT_MAX      4.0f
#define CHOSEN_SALIENT          "4"

/* Least saturation current of the q axis over the current limit [-]: below this ratio the incremental
 * inductance at the current limit is less than 1/40 of that without current. */
#define CHOSEN_SATURATION_LEAST 0.4f
#define CHOSEN_SATURATION_TEXT  "at least 0.4 current_limit, because the current control is unstable below"

/* Largest electrical turn in a period [rad], that of the law of the lag (lag.h). */
#define CHOSEN_TURN_MAX         LAG_TURN_LIMIT
#define CHOSEN_TURN_TEXT        "1.15"

typedef estimator_t chosen_t;
typedef estimator_tuning_t chosen_tuning_t;
#define chosen_params_check     estimator_params_check
#define chosen_prepare          estimator_prepare
#define chosen_take             estimator_take
#define chosen_init             estimator_init
#define chosen_set_flux         estimator_set_flux
#define chosen_set_load         estimator_set_load
#define chosen_set_lean         estimator_set_lean
#define chosen_reset            estimator_reset
#define chosen_step             estimator_step
#define chosen_track            estimator_track
#define chosen_coast            estimator_coast
#define chosen_observe          estimator_observe
#define chosen_lock             estimator_lock

#endif

#endif
