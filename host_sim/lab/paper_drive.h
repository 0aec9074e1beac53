/* The paper's drive: settings of every experiment that is compared with the paper. */
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

/* PI with 0.5 A s/rad and 2.5 A/rad; the whole reference in both parts; the speed of the loop with its
 * proportional part; current only for torque; and the encoder, because the paper does not describe a start
 * without one. */
extern const setting_t paper_drive[];
extern const size_t paper_drive_count;

/* Further settings of all experiments of the paper, and those of the ideal flavour. */
extern const setting_t paper_common[];
extern const size_t paper_common_count;
extern const setting_t paper_ideal[];
extern const size_t paper_ideal_count;

/* Sets these rows on the rig; parameters are staged. false: rig_error(). */
bool paper_drive_put(rig_t *rig, const setting_t *settings, size_t count);

/* Changes from the encoder to the estimate while the motor runs; false: rig_error(). */
bool paper_drive_without_encoder(rig_t *rig);

#endif
