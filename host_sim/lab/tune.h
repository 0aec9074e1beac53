/* From a motor to the rows of the drive: every rule of thumb once, each with its reason; and what will not
 * work on this board, told before anything runs.
 *
 *   current_limit        2 I_rated, as far as the board goes: a start needs more than its load
 *   overcurrent_trip     1.5 current_limit, at least 1.2 of it and the ripple
 *   dc_overvoltage       1.286 U_dc, dc_undervoltage 0.643 U_dc: the board's own shares
 *   overspeed_trip       1.4 omega_top, 0.5 rad a period at most; the drive hands over at 0.3 of it at most
 *   start_current        0 (current_limit), or what a leg of the board's module stands
 *   feedforward_cutoff   1.6 sqrt(p T/J), 50 rad/s at least; pll_bandwidth 4 times it        theory, 7
 *   speed_ramp           what the tracking loop follows if J is wrong, where the motor could do more
 *   position_source      sensorless; encoder for L_q above 1.2 L_d                            theory, 6
 *   omega_free           the rated speed, or what the link lets it come to without load
 *   omega_top            the rated speed, or what link, current and sampling leave of it
 *
 * What the drive makes by its own rules stays 0: observer, hand-over, ramp and damping of a start, speed
 * control. The rows are accepted by the firmware (params_check): a motor whose rows are not has none. */
#ifndef HOST_SIM_LAB_TUNE_H
#define HOST_SIM_LAB_TUNE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/motor.h"
#include "host_sim/lab/scenario.h"

#define TUNE_ROWS        48u
#define TUNE_WARNINGS    16u
#define TUNE_TEXT_SIZE   320u
#define TUNE_REASON_SIZE 192u

typedef struct {
    const table_row_t *row;
    double value; /* [unit of the row] as it is printed, with six digits */
    char reason[TUNE_REASON_SIZE];
} tune_row_t;

typedef struct {
    tune_row_t rows[TUNE_ROWS]; /* params first, then plant */
    uint32_t count;
    char warnings[TUNE_WARNINGS][TUNE_TEXT_SIZE]; /* one line each; the motor's notes are among them */
    uint32_t warning_count;
    double link;        /* [V] */
    double speed_top;   /* [rad/s] mechanical, that this board turns the motor with under its load */
    double torque_top;  /* [N m] rated, or what the board's current makes */
    double current;     /* [A] peak, for torque_top */
    double handover;    /* [rad/s] mechanical, up to which a start forces the frame */
    bool needs_encoder; /* too salient for the estimator */
} tune_t;

/* false: the board can not run this motor; `error` says why, `tune` has the warnings so far. */
bool tune_motor(const motor_t *motor, tune_t *tune, scenario_error_t *error);

/* The rows as TOML, [params] and [plant], a reason each; `comment` before each line ("" or "# "). */
void tune_print(FILE *to, const tune_t *tune, const char *comment);

/* A scenario ready to run: cold start, to the top speed with a part of the load, then all of it. The motor is
 * written as it was given: by its name of the library, or key by key. */
void tune_scenario(FILE *to, const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune);

/* In which time [s] a load [N m] may come that grows evenly, if the speed [rad/s] is to dip by no more than
 * 3 %: the speed control, 1/14 of the loop's bandwidth fast, lags a torque's rate by rate/(J w^2). */
double tune_load_time(double torque, double speed, double inertia, double bandwidth);

/* What a board would have to see and stand for this motor, and which boards do; several lines, each with
 * `comment` before it. */
void tune_boards(FILE *to, const motor_t *motor, const char *comment);

#endif
