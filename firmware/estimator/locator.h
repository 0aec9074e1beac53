/* The estimator that the drive runs on: that in float (estimator.h) or its fixed-point twin (fixed/fixed.h),
 * as the build says (LAGLESS_ESTIMATOR). The one place that knows; both take the same parameters. */
#ifndef ESTIMATOR_LOCATOR_H
#define ESTIMATOR_LOCATOR_H

#ifdef LAGLESS_ESTIMATOR_FIXED

#include "estimator/fixed/fixed.h"

typedef fixed_t locator_t;
#define locator_params_check fixed_params_check
#define locator_init         fixed_init
#define locator_retune       fixed_retune
#define locator_reset        fixed_reset
#define locator_rotation     fixed_rotation
#define locator_step         fixed_step
#define locator_coast        fixed_coast
#define locator_judge        fixed_judge
#define locator_invalid      fixed_invalid

#else

#include "estimator/estimator.h"

typedef estimator_t locator_t;
#define locator_params_check estimator_params_check
#define locator_init         estimator_init
#define locator_retune       estimator_retune
#define locator_reset        estimator_reset
#define locator_rotation     estimator_rotation
#define locator_step         estimator_step
#define locator_coast        estimator_coast
#define locator_judge        estimator_judge
#define locator_invalid      estimator_invalid

#endif

#endif
