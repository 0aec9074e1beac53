/* A drive at a serial link, for commissioning (host_sim/lab/commission_drive.h). */
#ifndef HOST_SIM_SCOPE_COMMISSION_LINE_H
#define HOST_SIM_SCOPE_COMMISSION_LINE_H

#include "host_sim/lab/commission_drive.h"
#include "host_sim/line/master.h"

typedef struct {
    master_t *master;
    /* Serves the link for this time [s]; false: the line is lost. NULL: master_wait. */
    bool (*pump)(void *context, double seconds);
    void *context;
    uint32_t period; /* [periods] last one that the drive reported */
    double passed;   /* [periods] since the first one */
    bool begun;
    master_error_t error;
} commission_line_t;

/* `line` has master, pump and context. */
commission_drive_t commission_line_drive(commission_line_t *line);

#endif
