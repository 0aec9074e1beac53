/* The measurements of a period, in the form that every module uses. */
#ifndef CONTRACT_MEASURED_H
#define CONTRACT_MEASURED_H

#include <stdint.h>

#include "math/frames.h"

typedef struct {
    abc_t current_abc;       /* [A] phase currents at t_k, offsets removed */
    ab_t current;            /* [A] the same in the stationary frame, trim also removed */
    float u_dc;              /* [V] DC link */
    float sink_temperature;  /* [degC] */
    float motor_temperature; /* [degC] */
    uint32_t encoder_count;  /* [counts] */
    uint32_t flags;          /* [-] DRIVE_SAMPLE_... */
    uint32_t good; /* [-] 0: invalid sample; currents, DC link and temperatures are the last good ones */
} measured_t;

#endif
