/* The paper's drive: what every experiment puts on the rig that is judged against the print, or was reckoned
 * for its speed control. */
#ifndef HOST_SIM_LAB_PAPER_DRIVE_H
#define HOST_SIM_LAB_PAPER_DRIVE_H

#include <stdbool.h>
#include <stddef.h>

#include "host_sim/rig/rig.h"

/* A row of a table and its value. */
typedef struct {
    const char *row;
    double value;
} setting_t;

/* PI with 0.5 A s/rad and 2.5 A/rad, the reference whole in both parts, the speed as the loop has it, no
 * current but for torque; and the encoder: the paper does not describe a start without one. */
extern const setting_t paper_drive[];
extern const size_t paper_drive_count;

/* What all runs of the paper's experiments put on the rig besides, and those of the ideal drive. */
extern const setting_t paper_common[];
extern const size_t paper_common_count;
extern const setting_t paper_ideal[];
extern const size_t paper_ideal_count;

/* Puts these settings on the rig; false: rig_error(). To be applied. */
bool paper_drive_put(rig_t *rig, const setting_t *settings, size_t count);

/* The estimate, which has run beside the encoder, takes over from it under way; false: rig_error(). */
bool paper_drive_without_encoder(rig_t *rig);

#endif
