/* Runs and judges the scenarios of a motor, with the parameters of tune: cold start without an encoder to the
 * top speed, and load (tune_scenario); then a grid of speeds and loads (tune_grid). */
#ifndef HOST_SIM_LAB_MOTOR_TRIAL_H
#define HOST_SIM_LAB_MOTOR_TRIAL_H

#include <stdbool.h>
#include <stdint.h>

#include "host_sim/lab/motor.h"
#include "host_sim/lab/tune.h"

typedef struct {
    motor_t motor;
    tune_t tune;
    double load;        /* [N m] on its shaft at the end */
    double speed_error; /* [-] of the top speed, mean under load */
    double angle_mean;  /* [rad] electrical, estimate minus truth, under load */
    double angle_sd;    /* [rad] */
    double grid_mean;   /* [rad] largest mean error of the angle at the points of the grid, its magnitude */
    double grid_sd;     /* [rad] largest standard deviation there */
    char grid_at[80];   /* point of the largest standard deviation: speed and load */
    double seconds;     /* [s] simulated, of the first scenario */
    bool met;           /* all expectations of the scenarios that ran are met */
    char miss[480];     /* "" or the first expectation that failed, or the fault */
} motor_trial_t;

/* false: the motor cannot be read, tuned or run; `error` has the message. `trial` is too large for the stack
 * of a thread. */
bool motor_trial(const motor_sheet_t *sheet, motor_trial_t *trial, scenario_error_t *error);

/* The grid of a motor whose first trial was met; otherwise nothing. */
bool motor_trial_grid(const motor_sheet_t *sheet, motor_trial_t *trial, scenario_error_t *error);

#endif
