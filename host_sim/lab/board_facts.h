/* What a board sees and stands, as its file says it: one constant per file of hal/f28335/boards, made by the
 * build (lab.cmake), each seeing its own file. */
#ifndef HOST_SIM_LAB_BOARD_FACTS_H
#define HOST_SIM_LAB_BOARD_FACTS_H

#include <stddef.h>

#include "host_sim/rig/rig.h"

typedef struct {
    const char *name;
    double current_range;    /* [A] seen in both directions */
    double current_per_code; /* [A] */
    double overvoltage_max;  /* [V] of the link that may be asked for */
    double nominal;          /* [V] */
    double period;           /* [s] of the carrier */
    double dead_time;        /* [s] */
} board_facts_t;

#define BOARD_FACTS                                                                                          \
    {                                                                                                        \
        BOARD_NAME, (double)BOARD_CURRENT_RANGE,                                                             \
            (double)(BOARD_CURRENT_PER_CODE < 0.0f ? -BOARD_CURRENT_PER_CODE : BOARD_CURRENT_PER_CODE),      \
            (double)BOARD_OVERVOLTAGE_MAX_MV / 1e3, (double)BOARD_DC_NOMINAL_MV / 1e3, (double)BOARD_PERIOD, \
            BOARD_DEAD_TIME_NS / 1e9                                                                         \
    }

extern const board_facts_t *const board_facts[]; /* NULL at its end */

#endif
