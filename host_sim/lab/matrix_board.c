/* A run for the faults on a board that is not the paper's rig. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/matrix.h"
#include "host_sim/lab/motor.h"
#include "host_sim/lab/tune.h"

#define SALIENT_MOST 1.2 /* [-] L_q/L_d: the paper's motor has surface magnets */
#define INERTIA_SHARE                                                                                        \
    4.0 /* [-] of the load over the rotor's, so that the rotor coasts as on the paper's rig */
#define SPEED_SHARE    0.3 /* [-] of the top speed; the paper's rig: 1200 of 4000 r/min */
#define ABOVE_HANDOVER 1.5 /* [-] at least this times the speed at which a start hands over */
#define LOAD_SHARE     0.6 /* [-] of the rated torque */
#define STARTED        3.5 /* [s] catch, alignment, hand-over, and a second of running */
#define TEXT_SIZE      600u

static bool suits(const motor_t *motor)
{
    const board_facts_t *board = boards_propose(motor);
    return board != NULL && strcmp(board->name, rig_board) == 0 &&
           motor->value[MOTOR_INDUCTANCE_Q] <= SALIENT_MOST * motor->value[MOTOR_INDUCTANCE_D];
}

/* Finds the motor with the largest current among those of the library for which this board is proposed.
 * false: there is none. */
static bool choose(motor_t *best, tune_t *best_tune)
{
    static _Thread_local tune_t tune;
    bool found = false;
    char **names = NULL;
    const int count = motor_library(&names);
    for (int n = 0; n < count; n++) {
        motor_sheet_t sheet;
        motor_t motor;
        scenario_error_t error;
        if (motor_read_library(names[n], &sheet, &error) && motor_make(&sheet, &motor, &error) &&
            suits(&motor) && (!found || motor.value[MOTOR_CURRENT] > best->value[MOTOR_CURRENT]) &&
            tune_motor(&motor, &tune, &error) && !tune.needs_encoder) {
            *best = motor;
            *best_tune = tune;
            found = true;
        }
        free(names[n]);
    }
    free(names);
    return found;
}

static double ramp_of(const tune_t *tune)
{
    for (uint32_t n = 0; n < tune->count; n++) {
        if (strcmp(tune->rows[n].row->name, "speed_ramp") == 0) {
            return tune->rows[n].value;
        }
    }
    return 0.0;
}

scenario_t *matrix_of_board(double *at, scenario_error_t *error)
{
    static _Thread_local tune_t tune;
    motor_t motor;
    char text[TEXT_SIZE];
    if (!choose(&motor, &tune)) {
        memset(error, 0, sizeof *error);
        snprintf(error->message, sizeof error->message,
                 "no motor of the library suits board %s best; accepted: --scenario SCENARIO --at TIME",
                 rig_board);
        return NULL;
    }
    const double speed = fmax(SPEED_SHARE * tune.speed_top, ABOVE_HANDOVER * tune.handover);
    const double ramp = ramp_of(&tune);
    *at = STARTED + (ramp > 0.0 ? floor(speed / ramp) : 0.0);
    const int length =
        snprintf(text, sizeof text,
                 "schema = 1\nboard = \"%s\"\ntitle = \"%s on board %s\"\n[run]\nduration = "
                 "%.6g\n[motor]\nname = \"%s\"\n"
                 "load_inertia = %.6g\n[start]\nangle = 2\n[requests]\nenable = \"on\"\nspeed_request = "
                 "%.6g\n[plant]\n"
                 "load_torque = %.6g\n",
                 rig_board, motor.name, rig_board, *at + 1.0, motor.name,
                 INERTIA_SHARE * motor.value[MOTOR_INERTIA], speed, LOAD_SHARE * tune.torque_top);
    return scenario_read_text("the run of the matrix", text, (size_t)length, error);
}
