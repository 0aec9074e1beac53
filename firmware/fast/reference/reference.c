#include "fast/reference/reference.h"

#include <stddef.h>
#include <string.h>

#include "math/angle.h"
#include "math/trig.h"

/* The first period of a window takes over a setpoint, the second one a tuning, and the last one closes the
 * window. Locking the loop takes long, too. */
#define LOCKING_FROM 3u

#define LOCKING 1u /* [periods] of a catch in which the loop is locked to the rotor that was found */

void reference_init(reference_t *reference)
{
    memset(reference, 0, sizeof *reference);
    forced_init(&reference->forced);
}

void reference_rest(reference_t *reference, int32_t source)
{
    reference->source = source;
    reference->named = source;
    reference->tracking = 0u;
    reference->current = (dq_t){0.0f, 0.0f};
    reference->slope = (dq_t){0.0f, 0.0f};
    reference->stiffness = 0.0f;
    reference->outcome = (int32_t)CATCH_GOES_ON;
    reference->catching.found = 0u;
}

void reference_leave_encoder(reference_t *reference, bool to_estimate, float omega_e, uint32_t periods)
{
    if (to_estimate) {
        reference->source = (int32_t)SOURCE_ESTIMATE;
        reference->tracking = 1u;
    } else {
        reference->source = (int32_t)SOURCE_CATCH;
        reference->tracking = 0u;
        reference->outcome = (int32_t)CATCH_GOES_ON;
        catch_enter(&reference->catching, periods - LOCKING, omega_e);
    }
}

void reference_take(reference_t *reference, const reference_tuning_t *tuning, const setpoint_t *setpoint)
{
    const float share = tuning->per_period;
    /* without an order to enter, a catch that the fast task itself has begun or ended continues */
    const bool other = setpoint->source != reference->named && setpoint->source != (int32_t)SOURCE_CATCH;
    reference->fresh = 1u;
    reference->left = tuning->periods;
    if (other || setpoint->enter != 0u) {
        reference->source = setpoint->source;
    }
    reference->named = setpoint->source;
    if (setpoint->change == (int32_t)FRAME_GOES_ON) {
        /* with another stiffness i_q has no step */
        reference->current.q += (setpoint->stiffness - reference->stiffness) * reference->omega_m;
        reference->slope = (dq_t){share * (setpoint->current.d - reference->current.d),
                                  share * (setpoint->current.q - reference->current.q)};
    } else {
        reference->current = setpoint->current;
        reference->slope = (dq_t){0.0f, 0.0f};
    }
    reference->stiffness = setpoint->stiffness;
    if (setpoint->enter != 0u && setpoint->source == (int32_t)SOURCE_FORCED) {
        reference->forced.frame.omega_e = setpoint->forced.begin;
        reference->forced.current = setpoint->change == (int32_t)FRAME_ANEW ? 0.0f : setpoint->forced.current;
    }
    reference->forced_slope = share * (setpoint->forced.speed - reference->forced.frame.omega_e);
    reference->rise = share * (setpoint->forced.current - reference->forced.current);
}

static void lock_to(reference_t *reference, position_t position, float emf)
{
    reference->locking = 1u;
    reference->locked = position;
    reference->locked_emf = emf;
    reference->tracking = 1u;
}

void reference_obey(reference_t *reference, const setpoint_t *setpoint, const estimate_t *estimate,
                    const position_t *encoder)
{
    const float forced = reference->forced.frame.omega_e;
    if (setpoint->enter != 0u) {
        reference->outcome = (int32_t)CATCH_GOES_ON;
        reference->tracking = 0u;
        if (setpoint->source == (int32_t)SOURCE_FORCED) {
            const float from = setpoint->change == (int32_t)FRAME_ANEW ? 0.0f : estimate->frame.theta_e;
            forced_enter(&reference->forced, angle_turn_back(from + setpoint->forced.ahead), forced,
                         reference->forced.current);
        } else {
            catch_enter(&reference->catching, setpoint->catching.periods - LOCKING, setpoint->catching.speed);
        }
    }
    switch ((lock_order_t)setpoint->lock) {
    case LOCK_RELEASE:
        reference->tracking = 0u;
        break;
    case LOCK_TO_EMF:
        lock_to(reference, (position_t){catch_angle(estimate->emf, forced), forced}, estimate->amplitude);
        break;
    case LOCK_TO_ENCODER:
        lock_to(reference, *encoder, estimate->amplitude);
        break;
    case LOCK_FOLLOWS:
        reference->tracking = 1u;
        break;
    case LOCK_KEEP:
        break;
    }
}

void reference_force(reference_t *reference, const reference_tuning_t *tuning, ab_t observed,
                     demand_t *demand)
{
    forced_t *forced = &reference->forced;
    forced->frame.omega_e += reference->forced_slope;
    forced->current += reference->rise;
    const dq_t emf = frames_park(observed, forced->frame.rotation);
    demand->frame = forced->frame;
    demand->current = forced_step(forced, &tuning->forced, emf);
    const float share = tuning->forced.emf_share;
    demand->emf = (dq_t){share * emf.d, share * emf.q};
}

/* The rotor rotates: the loop is locked to it, the current along its d axis continues, and the torque is
 * zero. */
static void caught(reference_t *reference, const reference_tuning_t *tuning, demand_t *demand)
{
    const frame_t rotor = catch_rotor(&reference->catching);
    reference->outcome = (int32_t)CATCH_TURNING;
    lock_to(reference, (position_t){rotor.theta_e, rotor.omega_e}, catch_length(&reference->catching));
    reference->source = (int32_t)SOURCE_ESTIMATE;
    reference->stiffness = 0.0f;
    reference->omega_m = rotor.omega_e * tuning->pole_pairs_inverse;
    reference->current = (dq_t){tuning->catching.current_d, 0.0f};
    reference->slope = (dq_t){0.0f, 0.0f};
    demand->frame = rotor;
    demand->change = (int32_t)FRAME_TURNS;
    demand->current = reference->current;
    demand->emf = frames_park(reference->catching.seen.emf, demand->frame.rotation);
}

void reference_follow_catch(reference_t *reference, const reference_tuning_t *tuning,
                            const estimate_t *estimate, float u_dc, uint32_t period, demand_t *demand)
{
    catch_t *catching = &reference->catching;
    const bool found = catching->found != 0u && reference->outcome == (int32_t)CATCH_GOES_ON;
    if (found) {
        catch_turn(catching, &tuning->catching);
        if (period >= LOCKING_FROM && (float)period < tuning->periods) {
            caught(reference, tuning, demand);
            return;
        }
    }
    const ab_t current = catch_current(catching, &tuning->catching);
    demand->frame = reference_stationary(0.0f);
    demand->current = (dq_t){current.alpha, current.beta};
    demand->emf = (dq_t){0.0f, 0.0f};
    if (estimate == NULL) {
        return;
    }
    const ab_t voltage = catch_voltage(catching, &tuning->catching, estimate->emf);
    demand->emf = (dq_t){voltage.alpha, voltage.beta};
    if (found || reference->outcome == (int32_t)CATCH_STANDING) {
        return; /* the loop is about to be locked, or the medium task decides how to continue */
    }
    const catch_outcome_t outcome = catch_step(catching, &tuning->catching, estimate->emf,
                                               estimate->amplitude, FRAMES_ONE_OVER_SQRT_3 * u_dc);
    if (outcome != CATCH_TURNING) { /* otherwise the loop is locked in the next period, because finding the
                                       rotor and locking both take long */
        reference->outcome = (int32_t)outcome;
    }
}

void reference_run_locked(reference_t *reference, const reference_tuning_t *tuning,
                          const setpoint_t *setpoint, demand_t *demand)
{
    const position_t at = reference->locked;
    const frame_t frame = {at.theta_e, at.omega_e, trig_turn(at.theta_e)};
    reference_run(reference, setpoint, &frame, at.omega_e * tuning->pole_pairs_inverse,
                  (dq_t){0.0f, at.omega_e * tuning->flux_linkage}, demand);
}
