/* Computes the parameters of the drive for a motor. Each rule is in one place and has a reason. Warnings
 * report before a run what will not work on this board.
 *
 *     current_limit        2 I_rated, limited by the board: a start needs more current than the load
 *     overcurrent_trip     1.5 current_limit, at least 1.2 current_limit plus the ripple, and 1.05 of the
 *                          current with which a rotor is caught at overspeed_trip           theory, 23
 *     dc_overvoltage       1.286 U_dc, dc_undervoltage 0.643 U_dc: the shares of the board
 *     overspeed_trip       1.4 omega_top, at most 0.85 rad a period; the hand-over is at most at 0.3 of it
 *     start_current        0 (current_limit), or the continuous current of a leg of the board's module
 *     feedforward_cutoff   1.6 sqrt(p T/J), at least 50 rad/s; pll_bandwidth is 4 times this    theory, 7
 *     speed_ramp           what the tracking loop follows with a wrong J, if the motor can do more
 *     position_source      sensorless; encoder for L_q above 1.2 L_d                            theory, 6
 *     omega_free           the rated speed, or the largest speed without load at this link
 *     omega_top            the rated speed, or less if link, current or sampling limit it
 *
 * Parameters that the drive computes by its own rules remain 0: observer, hand-over, ramp and damping of a
 * start, speed control. The firmware accepts the rows (params_check); a motor without accepted rows is an
 * error. */
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
    char warnings[TUNE_WARNINGS][TUNE_TEXT_SIZE]; /* one line each, including the notes of the motor */
    uint32_t warning_count;
    double link;        /* [V] */
    double speed_top;   /* [rad/s] mechanical, top speed under load on this board */
    double torque_top;  /* [N m] rated torque, or less if the board's current limits it */
    double current;     /* [A] peak, for torque_top */
    double handover;    /* [rad/s] mechanical, end of the forced frame in a start */
    double response;    /* [s] time in which the speed control reacts to a load */
    bool needs_encoder; /* too salient for the estimator */
} tune_t;

/* false: the board cannot run this motor; `error` has the reason, `tune` the warnings until then. */
bool tune_motor(const motor_t *motor, tune_t *tune, scenario_error_t *error);

/* Prints the rows as TOML, [params] and [plant], each with its reason; `comment` is printed before each line
 * ("" or "# "). */
void tune_print(FILE *to, const tune_t *tune, const char *comment);

/* Writes a scenario: cold start, acceleration to the top speed with a part of the load, then the whole load.
 * The motor is written as it was given, by its name in the library or key by key. */
void tune_scenario(FILE *to, const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune);

/* Writes a scenario with three speeds, from the top speed to 0.3 of it and not below the hand-over, and
 * with none, half and all of the load at each. For each of these points there are two expectations, with the
 * name of the point: the mean of the angle error, and its standard deviation. */
void tune_grid(FILE *to, const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune);

/* Time [s] in which a load [N m] may rise evenly without reducing the speed [rad/s] by more than 3 %. The
 * speed control with the bandwidth w, 1/14 of the loop's, has a speed error of rate/(J w^2). */
double tune_load_time(double torque, double speed, double inertia, double bandwidth);

/* Prints the ranges and limits that a board needs for this motor, and the boards that have them; `comment` is
 * printed before each line. */
void tune_boards(FILE *to, const motor_t *motor, const char *comment);

#endif
