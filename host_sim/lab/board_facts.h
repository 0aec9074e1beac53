/* Ranges and limits of a board from its file. The build (lab.cmake) makes one constant for each board that
 * the program can choose. */
#ifndef HOST_SIM_LAB_BOARD_FACTS_H
#define HOST_SIM_LAB_BOARD_FACTS_H

#include <stdbool.h>
#include <stddef.h>

#include "host_sim/rig/rig.h"

typedef struct {
    const char *name;
    double current_range;    /* [A] measured in both directions */
    double current_per_code; /* [A] */
    double current_limit;    /* [A] default of the drive's parameter, as the next three */
    double current_trip;     /* [A] */
    double undervoltage;     /* [V] */
    double overvoltage;      /* [V] */
    double overvoltage_max;  /* [V] largest accepted overvoltage trip */
    double nominal;          /* [V] */
    double clock;            /* [Hz] of the CPU */
    double period;           /* [s] of the carrier */
    double dead_time;        /* [s] */
    int sensors;             /* [-] of the phase currents */
    bool shunts;             /* below the lower switches; false: in the leads */
} board_facts_t;

#define BOARD_FACTS                                                                                          \
    {                                                                                                        \
        .name = BOARD_NAME, .current_range = (double)BOARD_CURRENT_RANGE,                                    \
        .current_per_code =                                                                                  \
            (double)(BOARD_CURRENT_PER_CODE < 0.0f ? -BOARD_CURRENT_PER_CODE : BOARD_CURRENT_PER_CODE),      \
        .current_limit = (double)BOARD_CURRENT_LIMIT_MA / 1e3,                                               \
        .current_trip = (double)BOARD_OVERCURRENT_TRIP_MA / 1e3,                                             \
        .undervoltage = (double)BOARD_UNDERVOLTAGE_MV / 1e3,                                                 \
        .overvoltage = (double)BOARD_OVERVOLTAGE_MV / 1e3,                                                   \
        .overvoltage_max = (double)BOARD_OVERVOLTAGE_MAX_MV / 1e3,                                           \
        .nominal = (double)BOARD_DC_NOMINAL_MV / 1e3, .clock = (double)BOARD_SYSCLK_HZ,                      \
        .period = (double)BOARD_PERIOD, .dead_time = BOARD_DEAD_TIME_NS / 1e9,                               \
        .sensors = BOARD_CURRENT_SENSORS, .shunts = BOARD_SAMPLES_AT == BOARD_LOWER_ZERO_VECTOR              \
    }

/* The boards of this build, NULL at the end. The first one is the default board, that of the program
 * `lagless` itself. */
extern const board_facts_t *const board_facts[];

#endif
