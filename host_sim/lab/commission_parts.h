/* Common declarations of the parts of commissioning. */
#ifndef HOST_SIM_LAB_COMMISSION_PARTS_H
#define HOST_SIM_LAB_COMMISSION_PARTS_H

#include "host_sim/lab/commission.h"

/* A commissioning in progress. */
typedef struct {
    const commission_drive_t *drive;
    const commission_plate_t *plate;
    const commission_options_t *options;
    commission_result_t *result;
    scenario_error_t *error;
    double link;     /* [V] */
    double handover; /* speed of the hand-over with the parameters of this step, mechanical [rad/s] */
    double raised;   /* of the hand-over that is used over the one of the rules [-] */
    bool lost;       /* the drive cannot be reached any more */
} commission_work_t;

/* The number of a choice of this row. */
double commission_choice(const char *row, const char *choice);

/* Value of a row by its name; NAN if the drive is lost. */
double commission_value(commission_work_t *work, const char *name);

/* Sets a request or stages a parameter. */
bool commission_put(commission_work_t *work, const char *name, double value);

/* Lets the drive run. */
void commission_wait(commission_work_t *work, double seconds);

/* Waits until a row has this value, at most this time [s]. */
bool commission_wait_for(commission_work_t *work, const char *row, double value, double seconds);

/* Ends the step with this reason. */
void commission_end(commission_work_t *work, const char *name, const char *text, const char *remedy);
void commission_end_with_fault(commission_work_t *work);

/* True if the user has stopped the step; the bridge opens one period later. */
bool commission_is_stopped(commission_work_t *work, commission_do_t step);

/* Runs one step; the bridge is off before and after it. false: the result has the reason. */
bool commission_run_step(commission_work_t *work, commission_do_t step);

/* Measures the lowest speed without an encoder; the bridge is off before and after it. */
bool commission_least_speed(commission_work_t *work);

/* The user's answer about the turn. false: the result has the reason. */
bool commission_ask_turn(commission_work_t *work);

/* Parameters that follow from the result, for the use of the drive. */
bool commission_stage_result(commission_work_t *work);

/* Parameters for the next step, from the present results. false: they are refused, and `error` has the
 * reason. If R is already known, the plate contradicts the measurement: this becomes the reason of the
 * result, and the function returns true. */
bool commission_stage(commission_work_t *work);

/* The speed of a turning step [rad/s], mechanical. */
double commission_speed(commission_work_t *work, commission_do_t step);

#endif
