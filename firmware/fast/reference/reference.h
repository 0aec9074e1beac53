/* The fast half of the manoeuvres: from the setpoint of a window to the demand of each of its periods.
 *
 *     encoder, estimate   the frame of the rotor; current references on a straight line to the setpoint's, of
 *                         i_q less what the speed control takes from it for the speed, which no window may
 *                         delay; the EMF that is known beforehand from the encoder's speed, or as the loop
 *                         filters it
 *     forced              its angle, the line of its speed and current, and the damping of its pendulum
 *                         (forced.h), which no window may delay either
 *     catch               the whole law of catch.h; where a turning rotor is found the loop is locked to it
 * in the period after, and from there on it has current along its d axis and no torque until the next
 * setpoint that names another source
 *
 * One step per T, after the estimator's. No division. */
#ifndef FAST_REFERENCE_REFERENCE_H
#define FAST_REFERENCE_REFERENCE_H

#include <stdbool.h>
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
    float flux_linkage;       /* for the EMF of the encoder's speed: psi_f, or a share of it [Wb] */
    float saliency;           /* D = L_q - L_d [H] */
    float pole_pairs_inverse; /* 1/p [-] */
    float periods;            /* of a window [-] */
    float per_period;         /* one over them [-] */
} reference_tuning_t;

typedef struct {
    int32_t source;     /* [-] frame_source_t: the one in force */
    int32_t named;      /* [-] that of the last setpoint */
    uint32_t tracking;  /* [-] 1: the loop tracks; 0: the observer alone is stepped */
    uint32_t fresh;     /* [-] 1: this is the first period of a setpoint */
    dq_t current;       /* reference before limits and dither [A]; its q axis with the speed at zero */
    float stiffness;    /* by which i_q falls with the speed [A s/rad] */
    float omega_m;      /* the speed of the last period [rad/s] */
    float left;         /* [periods] until it is there */
    dq_t slope;         /* of it a period [A] */
    float forced_slope; /* of the forced speed a period [rad/s] */
    float rise;         /* of the forced current a period [A] */
    int32_t outcome;    /* [-] catch_outcome_t of the catch under way */
    forced_t forced;
    catch_t catching;

    uint32_t locking;  /* [-] 1: the loop shall be locked at `locked` in this period */
    position_t locked; /* [rad], [rad/s] at t_k */
    float locked_emf;  /* mean length of its EMF [V] */
} reference_t;

/* What a period brings. */
typedef struct {
    float u_dc;                 /* DC link at t_k [V] */
    const estimate_t *estimate; /* at t_k */
    const position_t *position; /* of the encoder at t_k */
    const frame_t *encoder;     /* the same, while control turns with it */
    float omega_m;              /* of the rotor as it is believed [rad/s], mechanical */
    uint32_t estimating;        /* [-] 1: the observer runs: its EMF is that of t_k */
} reference_input_t;

/* No frame. */
void reference_init(reference_t *reference);

/* The first period of a window begins with this setpoint, before the estimator's step. */
void reference_take(reference_t *reference, const reference_tuning_t *tuning, const setpoint_t *setpoint);

/* The bridge is off. */
void reference_rest(reference_t *reference, int32_t source);

/* The encoder's angle has jumped: control leaves it for the loop that tracks beside it, or for a catch at
 * this speed [rad/s], electrical. */
void reference_leave_encoder(reference_t *reference, bool to_estimate, float omega_e, uint32_t periods);

/* Before the estimator's step: a forced frame to t_k. */
static inline void reference_advance(reference_t *reference, const reference_tuning_t *tuning)
{
    if (reference->source == (int32_t)SOURCE_FORCED) {
        forced_advance(&reference->forced, &tuning->forced);
    }
}

/* The speed at which the observer is stepped while the loop does not track [rad/s]. */
static inline float reference_speed(const reference_t *reference)
{
    return reference->source == (int32_t)SOURCE_FORCED ? reference->forced.frame.omega_e
                                                       : reference->catching.omega_e;
}

/* Does control turn with the rotor? */
static inline bool reference_in_rotor(const reference_t *reference)
{
    return reference->source == (int32_t)SOURCE_ESTIMATE || reference->source == (int32_t)SOURCE_ENCODER;
}

/* The stationary frame, with this speed of the rotor, whose angle is not known. */
static inline frame_t reference_stationary(float omega_e)
{
    return (frame_t){0.0f, omega_e, {0.0f, 1.0f}};
}

/* The rotor at t_k: of the encoder, of the estimate while it tracks, else of the frame. */
static inline frame_t reference_rotor(const reference_t *reference, const frame_t *encoder,
                                      const estimate_t *estimate)
{
    switch ((frame_source_t)reference->source) {
    case SOURCE_ENCODER:
        return *encoder;
    case SOURCE_NONE:
        return reference_stationary(0.0f);
    case SOURCE_ESTIMATE:
    case SOURCE_FORCED:
    case SOURCE_CATCH:
        break;
    }
    if (reference->tracking != 0u) {
        return estimate->frame;
    }
    return reference->source == (int32_t)SOURCE_FORCED ? reference->forced.frame
                                                       : reference_stationary(reference->catching.omega_e);
}

/* Is its speed the tracking loop's? */
static inline bool reference_tracks(const reference_t *reference)
{
    return reference->tracking != 0u && reference->source != (int32_t)SOURCE_ENCODER &&
           reference->source != (int32_t)SOURCE_NONE;
}

/* `demand` of this period; reference->locking with it. */
void reference_step(reference_t *reference, const reference_tuning_t *tuning, const setpoint_t *setpoint,
                    const reference_input_t *input, demand_t *demand);

#endif
