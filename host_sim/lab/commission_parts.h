/* What the parts of commissioning share. */
#ifndef HOST_SIM_LAB_COMMISSION_PARTS_H
#define HOST_SIM_LAB_COMMISSION_PARTS_H

#include "host_sim/lab/commission.h"

/* A commissioning under way. */
typedef struct {
    rig_t *rig;
    const commission_plate_t *plate;
    const commission_options_t *options;
    commission_result_t *result;
    scenario_error_t *error;
    double link;     /* [V] */
    double handover; /* speed of the hand-over with the parameters of this step, mechanical [rad/s] */
    double raised;   /* of the hand-over that is used over the one of the rules [-] */
} commission_work_t;

/* The number of a choice of this row. */
double commission_choice(const char *row, const char *choice);

/* Parameters for the next step, from what is measured so far. false: refused, and `error` says why; if R is
 * known already, plate and measurement contradict each other, which is the reason of the result, and true. */
bool commission_stage(commission_work_t *work);

/* The speed of a turning step [rad/s], mechanical. */
double commission_speed(const commission_work_t *work, commission_do_t step);

#endif
