/* Commissioning of a drive on a rig: the steps of firmware/medium/commission in their order, each with the
 * parameters that follow from the steps before. The drive measures; here are the order of the steps, the
 * parameters between them and the result. Nothing of the plant is read.
 *
 *     board, wiring, resistance, inductance, swing     with limits from the plate
 *     flux                                             with the rows of tune for R, L and the first psi_f, J
 *     inertia                                          with psi_f
 *
 * The bridge is off between two steps. A step that fails ends the commissioning; what the earlier ones have
 * measured stays. */
#ifndef HOST_SIM_LAB_COMMISSION_H
#define HOST_SIM_LAB_COMMISSION_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/motor.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/rig/rig.h"

/* S(name, what is done to the motor) in their order. The names are the choices of the request `commission`.
 */
#define COMMISSION_LIST(S)                                                                                   \
    S(board, "nothing: the bridge is off")                                                                   \
    S(wiring, "short pulses of voltage in six directions; the rotor does not move")                          \
    S(resistance, "a steady current in six directions; the rotor follows them by a turn of p-th part")       \
    S(inductance, "a steady current with a sine; the rotor stands")                                          \
    S(swing, "the rotor is drawn to and fro by a sixth of an electrical turn")                               \
    S(flux, "the rotor turns at a steady speed")                                                             \
    S(inertia, "the rotor is accelerated and braked, four times or more")

typedef enum {
#define COMMISSION_STEP_OF(name, text) COMMISSION_DO_##name,
    COMMISSION_LIST(COMMISSION_STEP_OF)
#undef COMMISSION_STEP_OF
        COMMISSION_STEP_COUNT
} commission_do_t;

/* Of the motor's plate. */
typedef struct {
    double pole_pairs; /* [-] */
    double current;    /* continuous, peak value of a phase [A] */
    double speed;      /* largest, mechanical [rad/s] */
} commission_plate_t;

/* A measured value; NAN: not measured. `error` is its uncertainty, absolute. */
typedef struct {
    double value, error;
} commission_value_t;

typedef struct {
    commission_value_t resistance;              /* of a phase, without the devices [ohm] */
    commission_value_t inductance_d;            /* [H] */
    commission_value_t inductance_q;            /* without current [H] */
    commission_value_t saturation_current;      /* of the q axis; 0: it does not saturate [A] */
    commission_value_t flux_linkage;            /* psi_f [Wb] */
    commission_value_t inertia;                 /* [kg m^2] */
    commission_value_t friction_coulomb;        /* [N m] */
    commission_value_t friction_viscous;        /* [N m s/rad] */
    commission_value_t dead_voltage;            /* loss of a leg [V] */
    commission_value_t current_zone;            /* half width of its passage through zero current [A] */
    double flux_first, inertia_first;           /* of the swing [Wb], [kg m^2] */
    uint32_t step;                              /* commission_do_t of the last one that ran */
    char reason[48];                            /* "": commissioned; else the name of a reason */
    char what[400];                             /* one line: what happened, what to do */
    double seconds;                             /* [s] simulated */
    double step_seconds[COMMISSION_STEP_COUNT]; /* [s] of each step, with its repetitions */
    double largest_current;                     /* of a phase [A] */
} commission_result_t;

typedef struct {
    /* Steps that are not requested. They run nevertheless if a later one is, because it needs their results;
     * but for `board`, whose results nothing needs. */
    bool skip[COMMISSION_STEP_COUNT];
    double link; /* of the DC link by the user's meter [V]; 0: not known */
    /* before each try of a step, and once after it; NULL: nobody listens */
    void (*progress)(void *context, commission_do_t step, bool done, const commission_result_t *result);
    /* every 2.5 ms of a step; false opens the bridge and ends the commissioning with `stopped_by_user`; NULL:
     * never */
    bool (*goes_on)(void *context, commission_do_t step);
    void *context;
} commission_options_t;

const char *commission_step_name(commission_do_t step);
const char *commission_step_text(commission_do_t step);

/* A rig as the scenario describes it at t = 0, with this seed. NULL: `error` says why. */
rig_t *commission_rig_of(const scenario_t *scenario, uint64_t seed, scenario_error_t *error);

/* The plate as the active parameters of the drive tell it: pole pairs, continuous current, and the speed of
 * which tune makes overspeed_trip. */
commission_plate_t commission_plate_of(rig_t *rig);

/* Runs the steps. false: the plate is not accepted by this board; `error` says why. */
bool commission_rig(rig_t *rig, const commission_plate_t *plate, const commission_options_t *options,
                    commission_result_t *result, scenario_error_t *error);

/* The measured motor as a file that [motor] and `lagless tune` accept. R, L and psi_f must be known. */
void commission_write(FILE *file, const commission_plate_t *plate, const commission_result_t *result,
                      const char *title);

#endif
