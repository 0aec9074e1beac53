/* Commissioning of a drive, simulated or real: the steps of firmware/medium/commission in their order, each
 * with the parameters that follow from the steps before. The drive does the measurements. This module
 * determines the order of the steps, sets the parameters between them and collects the result. It reads no
 * value of the plant.
 *
 *     board, wiring, resistance, angle, inductance, turn, swing   with limits from the plate
 *     current_loop                                         with the measured R and L
 *     flux                                                 with the rows of tune for R, L and the first
 * psi_f, J inertia                                              with psi_f least_speed with the parameters
 * that are the result
 *
 * The bridge is off between two steps. A step that fails ends the commissioning; the values that earlier
 * steps have measured stay in the drive until its restart, and options.resume reads them from there. If all
 * requested steps have a result and psi_f is known, the parameters that follow from it are active at the end;
 * else those of the beginning. Nothing is saved. */
#ifndef HOST_SIM_LAB_COMMISSION_H
#define HOST_SIM_LAB_COMMISSION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/commission_drive.h"
#include "host_sim/lab/motor.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/rig/rig.h"

/* S(name, largest time [s], excitation of the motor) in their order. The names are the choices of the request
 * `commission`; `least_speed` is no step of the drive, but a run without an encoder. */
#define COMMISSION_LIST(S)                                                                                   \
    S(board, 3.0, "Nothing: the bridge is off.")                                                             \
    S(wiring, 5.0, "Short voltage pulses in six directions. The rotor does not move.")                       \
    S(resistance, 60.0, "A constant current in six directions. The rotor follows it by one p-th of a turn.") \
    S(angle, 25.0, "Currents in twelve directions. Hold the shaft: the motor has torque.")                   \
    S(inductance, 15.0, "A constant current with a superimposed sine. The rotor stands still.")              \
    S(current_loop, 15.0, "A constant current with small steps. The rotor stands still.")                    \
    S(turn, 140.0, "The shaft makes one slow turn forward. Watch a mark on it.")                             \
    S(swing, 40.0, "The rotor swings to and fro by a third of an electrical turn.")                          \
    S(flux, 60.0, "The rotor turns at a constant speed.")                                                    \
    S(inertia, 120.0, "The rotor accelerates, coasts and brakes several times.")                             \
    S(least_speed, 40.0, "The rotor turns more and more slowly.")

typedef enum {
#define COMMISSION_STEP_OF(name, seconds, text) COMMISSION_DO_##name,
    COMMISSION_LIST(COMMISSION_STEP_OF)
#undef COMMISSION_STEP_OF
        COMMISSION_STEP_COUNT
} commission_do_t;

/* Q(name, text, accepted answers): questions about what only the user can observe. */
#define COMMISSION_QUESTIONS(Q)                                                                              \
    Q(direction, "In which direction did the shaft turn?", "as_said, reversed")                              \
    Q(turn, "How many turns did the mark on the shaft make?", "one, or a number such as 2 or 0.5")

typedef enum {
#define COMMISSION_QUESTION_OF(name, text, accepted) COMMISSION_ASK_##name,
    COMMISSION_QUESTIONS(COMMISSION_QUESTION_OF)
#undef COMMISSION_QUESTION_OF
        COMMISSION_QUESTION_COUNT
} commission_question_t;

/* Data of the motor's plate. */
typedef struct {
    double pole_pairs; /* [-] */
    double current;    /* continuous, peak value of a phase [A] */
    double speed;      /* largest, mechanical [rad/s] */
} commission_plate_t;

/* A measured value; NAN: not measured. `error` is its uncertainty, absolute. */
typedef struct {
    double value, error;
} commission_value_t;

/* A measured point of a step. The quantities of x and y are those of the signals commission_point_x and
 * commission_point_y. */
typedef struct {
    uint32_t step; /* commission_do_t */
    double x, y;
} commission_measured_t;

#define COMMISSION_POINTS 1000u /* [-] points that a result can have; later ones are left out */

typedef struct {
    commission_value_t resistance;         /* of a phase, without the devices [ohm] */
    commission_value_t inductance_d;       /* [H] */
    commission_value_t inductance_q;       /* without current [H] */
    commission_value_t saturation_current; /* of the q axis; 0: it does not saturate [A] */
    commission_value_t flux_linkage;       /* psi_f [Wb] */
    commission_value_t inertia;            /* [kg m^2] */
    commission_value_t friction_coulomb;   /* [N m] */
    commission_value_t friction_viscous;   /* [N m s/rad] */
    commission_value_t dead_voltage;       /* loss of a leg [V] */
    commission_value_t current_zone;       /* half width of its passage through zero current [A] */
    double flux_first, inertia_first;      /* of the swing [Wb], [kg m^2] */
    double angle_d;                        /* of a held rotor, electrical; NAN: not measured [rad] */
    double loop_gain;                      /* of the current loop over its design; NAN: not checked [-] */
    double least_speed;                    /* mechanical, without an encoder; NAN: not tried [rad/s] */
    double turns;                          /* of the shaft, by the user; NAN: no answer [-] */
    bool reversed;                         /* the user saw the shaft turn backward */
    uint32_t step;                         /* commission_do_t of the last step that ran */
    char reason[48];                       /* "": commissioned; else the name of a reason */
    char what[400];                        /* one line: what happened, what to do */
    double seconds;                        /* [s] of the drive's time */
    double step_seconds[COMMISSION_STEP_COUNT]; /* [s] of each step, with its repetitions */
    double largest_current;                     /* of a phase; over a line: of the vector [A] */
    double largest_heat; /* copper loss, averaged by the motor's time constant, over that of the rated current
                            [-] */
    uint32_t points_count;
    commission_measured_t
        points[COMMISSION_POINTS]; /* in the order of their measurement; of the last try of a step */
} commission_result_t;

typedef struct {
    /* Steps that are not requested. They run nevertheless if a later one is, because it needs their results;
     * except `board`, `angle`, `current_loop` and `turn`: no step needs their results. `turn` needs a user
     * who answers, `angle` one who holds the shaft: it runs only if it is named. */
    bool skip[COMMISSION_STEP_COUNT];
    double link; /* of the DC link by the user's meter [V]; 0: not known */
    bool resume; /* values that the drive has measured since its start are not measured again */
    bool chosen; /* the user has named the steps, so that `turn` also runs with the answers of a simulated
                    motor */
    bool plant_answers; /* if `ask` has no answer, the simulated motor answers, if there is one */
    /* Answer to a question: direction 1 or -1, turn the number of turns. false: none is given. NULL: no
     * answers are available.
     */
    bool (*ask)(void *context, commission_question_t question, double *answer);
    /* called before each try of a step, and once after it; may be NULL */
    void (*progress)(void *context, commission_do_t step, bool done, const commission_result_t *result);
    /* called about every 2.5 ms of a step; if it returns false, the bridge opens and the commissioning ends
     * with `stopped_by_user`; may be NULL */
    bool (*goes_on)(void *context, commission_do_t step);
    void *context;
} commission_options_t;

const char *commission_step_name(commission_do_t step);
const char *commission_step_text(commission_do_t step);
double commission_step_seconds(commission_do_t step); /* [s] largest time of a try */
const char *commission_question_name(commission_question_t question);
const char *commission_question_text(commission_question_t question);
const char *commission_question_accepts(commission_question_t question);

/* The answer that a text gives. false: the question does not accept this text. */
bool commission_answer_of(commission_question_t question, const char *text, double *answer);

/* Steps by their names, separated by commas: all others are skipped. false: `why` lists the accepted names.
 * */
bool commission_choose(commission_options_t *options, const char *text, char *why, size_t size);

/* A rig as the scenario describes it at t = 0, with this seed. NULL: `error` has the reason. */
rig_t *commission_rig_of(const scenario_t *scenario, uint64_t seed, scenario_error_t *error);

/* The plate according to the active parameters of the drive: pole pairs, continuous current, and the speed
 * from which tune computes overspeed_trip. */
commission_plate_t commission_plate_of(rig_t *rig);
commission_plate_t commission_plate_by(const commission_drive_t *drive);

/* Runs the steps. false: this board does not accept the plate; `error` has the reason. */
bool commission_drive(const commission_drive_t *drive, const commission_plate_t *plate,
                      const commission_options_t *options, commission_result_t *result,
                      scenario_error_t *error);

/* The same on a rig. */
bool commission_rig(rig_t *rig, const commission_plate_t *plate, const commission_options_t *options,
                    commission_result_t *result, scenario_error_t *error);

/* The measured values as a motor file. [motor] and `lagless tune` accept it if R, L and psi_f are known;
 * commission_known() returns whether they are. */
bool commission_known(const commission_result_t *result);
void commission_write(FILE *file, const commission_plate_t *plate, const commission_result_t *result,
                      const char *title);

#endif
