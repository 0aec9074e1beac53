/* The fast part of the manoeuvres: from the setpoint of a window to the demand of each of its periods.
 *
 *     encoder, estimate   the frame of the rotor; current references on a straight line to those of the
 *                         setpoint, with the part of i_q that the speed control subtracts for the speed in
 *                         each period, without the delay of a window; the known EMF from the encoder's
 *                         speed, or as the loop filters it
 *     forced              its angle, the line of its speed and current, and the damping of its pendulum
 *                         (forced.h), also without the delay of a window
 *     catch               the whole law of catch.h; where a rotating rotor is found, the loop is locked to
 *                         it in the next period that has no work at an end of the window, and from
 *                         then on the current flows along its d axis without torque, until the next
 *                         setpoint that names another source
 *
 * One step per T, after that of the estimator. No division. */
#ifndef FAST_REFERENCE_REFERENCE_H
#define FAST_REFERENCE_REFERENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "estimator/estimate.h"
#include "estimator/position.h"
#include "fast/reference/catch.h"
#include "fast/reference/demand.h"
#include "fast/reference/forced.h"
#include "fast/reference/setpoint.h"

typedef struct {
    forced_tuning_t forced;
    catch_tuning_t catching;
    float flux_linkage;       /* for the EMF from the encoder's speed: psi_f, or a share of it [Wb] */
    float saliency;           /* D = L_q - L_d [H] */
    float pole_pairs_inverse; /* 1/p [-] */
    float periods;            /* of a window [-] */
    float per_period;         /* 1/periods [-] */
} reference_tuning_t;

typedef struct {
    int32_t source;     /* [-] frame_source_t: the present one */
    int32_t named;      /* [-] that of the last setpoint */
    uint32_t tracking;  /* [-] 1: the loop tracks; 0: only the observer is stepped */
    uint32_t fresh;     /* [-] 1: this is the first period of a setpoint */
    dq_t current;       /* reference before limits and dither [A]; its q axis for speed zero */
    float stiffness;    /* decrease of i_q with the speed [A s/rad] */
    float omega_m;      /* the speed of the last period [rad/s] */
    float left;         /* [periods] until the reference reaches the setpoint */
    dq_t slope;         /* change of the reference per period [A] */
    float forced_slope; /* change of the forced speed per period [rad/s] */
    float rise;         /* change of the forced current per period [A] */
    int32_t outcome;    /* [-] catch_outcome_t of the present catch */
    forced_t forced;
    catch_t catching;

    uint32_t locking;  /* [-] 1: the loop has to be locked at `locked` in this period */
    position_t locked; /* [rad], [rad/s] at t_k */
    float locked_emf;  /* mean length of its EMF [V] */
} reference_t;

/* Inputs of a period. */
typedef struct {
    float u_dc;                 /* DC link at t_k [V] */
    const estimate_t *estimate; /* at t_k */
    const position_t *position; /* of the encoder at t_k */
    const frame_t *encoder;     /* the same as a frame, computed while control uses the encoder */
    float omega_m;              /* estimated speed of the rotor [rad/s], mechanical */
    uint32_t estimating;        /* [-] 1: the observer runs, and its EMF is that of t_k */
    uint32_t period;            /* [-] of the window, from 1 */
} reference_input_t;

/* Starts without a frame. */
void reference_init(reference_t *reference);

/* Takes over this setpoint in the first period of a window, before the step of the estimator. */
void reference_take(reference_t *reference, const reference_tuning_t *tuning, const setpoint_t *setpoint);

/* The reference while the bridge is off. */
void reference_rest(reference_t *reference, int32_t source);

/* The encoder's angle has jumped: control continues with the loop that already tracks, or with a catch at
 * this speed [rad/s], electrical. */
void reference_leave_encoder(reference_t *reference, bool to_estimate, float omega_e, uint32_t periods);

/* Advances a forced frame to t_k, before the step of the estimator. */
static inline void reference_advance(reference_t *reference, const reference_tuning_t *tuning)
{
    if (reference->source == (int32_t)SOURCE_FORCED) {
        forced_advance(&reference->forced, &tuning->forced);
    }
}

/* The speed of the observer's step while the loop does not track [rad/s]. */
static inline float reference_speed(const reference_t *reference)
{
    return reference->source == (int32_t)SOURCE_FORCED ? reference->forced.frame.omega_e
                                                       : reference->catching.omega_e;
}

/* true: the frame of control rotates with the rotor. */
static inline bool reference_in_rotor(const reference_t *reference)
{
    return reference->source == (int32_t)SOURCE_ESTIMATE || reference->source == (int32_t)SOURCE_ENCODER;
}

/* The stationary frame, for a rotor with this speed and an unknown angle. */
static inline frame_t reference_stationary(float omega_e)
{
    return (frame_t){0.0f, omega_e, {0.0f, 1.0f}};
}

/* true: the rotor at t_k is that of the tracking loop. */
static inline bool reference_tracks(const reference_t *reference)
{
    return reference->tracking != 0u && reference->source != (int32_t)SOURCE_ENCODER &&
           reference->source != (int32_t)SOURCE_NONE;
}

/* The rotor at t_k while reference_tracks() is false: from the encoder, or from the frame. */
static inline frame_t reference_rotor(const reference_t *reference, const frame_t *encoder)
{
    switch ((frame_source_t)reference->source) {
    case SOURCE_ENCODER:
        return *encoder;
    case SOURCE_FORCED:
        return reference->forced.frame;
    case SOURCE_NONE:
        return reference_stationary(0.0f);
    case SOURCE_ESTIMATE:
    case SOURCE_CATCH:
        break;
    }
    return reference_stationary(reference->catching.omega_e);
}

/* ---- the parts of a step that run rarely ---- */

/* Executes the orders of the setpoint for its first period; `encoder`: its position at t_k. */
void reference_obey(reference_t *reference, const setpoint_t *setpoint, const estimate_t *estimate,
                    const position_t *encoder);

/* A period of a forced frame, with the observed EMF [V] at t_k. */
void reference_force(reference_t *reference, const reference_tuning_t *tuning, ab_t observed,
                     demand_t *demand);

/* A period of a catch, at this link voltage [V]; `estimate`: NULL while the observer does not run. `period`
 * counts the periods of the window from 1. */
void reference_follow_catch(reference_t *reference, const reference_tuning_t *tuning,
                            const estimate_t *estimate, float u_dc, uint32_t period, demand_t *demand);

/* The period in which the loop is locked; the origin of the EMF does not change. */
void reference_run_locked(reference_t *reference, const reference_tuning_t *tuning,
                          const setpoint_t *setpoint, demand_t *demand);

/* ---- the step ---- */

/* Run in the frame of the rotor, with its mechanical speed [rad/s] and the known EMF [V] for the
 * feed-forward. The reference keeps its last value if no other setpoint takes over. */
static inline void reference_run(reference_t *reference, const setpoint_t *setpoint, const frame_t *rotor,
                                 float omega_m, dq_t emf, demand_t *demand)
{
    reference->left -= reference->left > 0.0f ? 1.0f : 0.0f;
    reference->current.d = setpoint->current.d - reference->left * reference->slope.d;
    reference->current.q = setpoint->current.q - reference->left * reference->slope.q;
    reference->omega_m = omega_m;
    demand->frame = *rotor;
    demand->current.d = reference->current.d;
    demand->current.q = reference->current.q - reference->stiffness * omega_m;
    demand->emf = emf;
}

/* Run with the observed EMF, as the loop filters it: after one or two periods it is correct for any angle, so
 * that a lost angle causes no large current. For a salient rotor the observed EMF is that of the active flux,
 * to which omega L_q i_d belongs. Current control adds omega L_d i_d, so the difference, a term with D, is
 * added here. If the q axis saturates, its EMF beyond omega L_q i_q, which the estimator has removed, is
 * added as well. */
static inline void reference_run_on_estimate(reference_t *reference, const reference_tuning_t *tuning,
                                             const setpoint_t *setpoint, const estimate_t *estimate,
                                             float omega_m, demand_t *demand)
{
    const float of_axes = estimate->frame.omega_e * tuning->saliency * reference->current.d;
    const dq_t emf = {estimate->emf_loop.d - estimate->frame.omega_e * estimate->cross,
                      estimate->emf_loop.q + of_axes};
    reference_run(reference, setpoint, &estimate->frame, omega_m, emf, demand);
    demand->origin = (int32_t)EMF_OBSERVED;
}

/* Computes `demand` and reference->locking of this period. */
static inline void reference_step(reference_t *reference, const reference_tuning_t *tuning,
                                  const setpoint_t *setpoint, const reference_input_t *input,
                                  demand_t *demand)
{
    const estimate_t *estimate = input->estimate;
    reference->locking = 0u;
    demand->change = (int32_t)FRAME_GOES_ON;
    if (reference->fresh != 0u) {
        demand->change = setpoint->change;
        reference_obey(reference, setpoint, estimate, input->position);
        reference->fresh = 0u;
    }
    switch ((frame_source_t)reference->source) {
    case SOURCE_ENCODER:
        reference_run(reference, setpoint, input->encoder, input->omega_m,
                      (dq_t){0.0f, input->encoder->omega_e * tuning->flux_linkage}, demand);
        demand->origin = (int32_t)EMF_MODEL;
        break;
    case SOURCE_ESTIMATE:
        if (reference->locking != 0u) {
            reference_run_locked(reference, tuning, setpoint, demand);
        } else {
            reference_run_on_estimate(reference, tuning, setpoint, estimate, input->omega_m, demand);
        }
        break;
    case SOURCE_FORCED:
        demand->origin = (int32_t)EMF_OTHER;
        reference_force(reference, tuning, estimate->emf, demand);
        break;
    case SOURCE_NONE:
    case SOURCE_CATCH:
        demand->origin = (int32_t)EMF_OTHER;
        reference_follow_catch(reference, tuning, input->estimating != 0u ? estimate : NULL, input->u_dc,
                               input->period, demand);
        break;
    }
    demand->omega_m_ref = setpoint->omega_m_ref;
}

#endif
