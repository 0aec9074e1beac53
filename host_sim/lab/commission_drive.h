/* The drive that is commissioned, reached through a rig (here) or a serial link
 * (host_sim/scope/commission_line.h). Rows are those of the tables of a drive. */
#ifndef HOST_SIM_LAB_COMMISSION_DRIVE_H
#define HOST_SIM_LAB_COMMISSION_DRIVE_H

#include <stdbool.h>

#include "host_sim/rig/rig.h"

typedef struct {
    /* Value of a row; of a parameter, the active one. false: the drive cannot be reached. */
    bool (*get)(void *context, const table_row_t *row, double *value);
    /* A request at once; a parameter is staged. false: refused, or the drive cannot be reached; see why(). */
    bool (*put)(void *context, const table_row_t *row, double value);
    /* The staged parameters become active together. false: refused, see why(). */
    bool (*apply)(void *context);
    /* Lets the drive run for about this time of its own clock [s]. false: the drive cannot be reached. */
    bool (*wait)(void *context, double seconds);
    /* Time of the drive's clock [s] since an arbitrary moment. */
    double (*seconds)(void *context);
    /* Largest phase current since the last call [A]. NULL: the drive's own signal is used. */
    double (*largest)(void *context);
    /* The visible motion of a simulated motor: the turns [-] of its shaft since the last call. NULL:
     * there is a user. */
    double (*turned)(void *context);
    /* One line about the last refusal. */
    const char *(*why)(void *context);
    void *context;
} commission_drive_t;

/* A rig as a drive. `room`: memory for its largest currents; the rig's tap is in use until
 * commission_rig_leave(). */
typedef struct {
    rig_t *rig;
    double largest; /* [A] */
    double turned;  /* [rad] */
} commission_rig_room_t;
commission_drive_t commission_rig_drive(commission_rig_room_t *room, rig_t *rig);
void commission_rig_leave(commission_rig_room_t *room);

#endif
