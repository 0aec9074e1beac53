/* The manoeuvres in the forced frame: align, ramp, forced, reverse, hand-over. */
#include "drive/manoeuvres_parts.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"
#include "math/trig.h"

#define PAUSE_PERIODS DRIVE_PERIODS(0.3f)   /* without current before another start */
#define STALL_PERIODS DRIVE_PERIODS(50e-3f) /* with too little EMF */
#define STALL_SHARE   0.6f                  /* [-] of the EMF that a rotor in step has, at least */
#define LENGTH_SHARE                                                                                         \
    (50.0f * DRIVE_PERIOD)  /* [-] low-pass of the EMF's length: a leg that passes zero current              \
                               slowly pretends one for some 20 ms */
#define TRACK_SHARE   0.4f  /* [-] of handover_speed, from which on the loop tracks */
#define UNTRACK_SHARE 0.3f  /* [-] likewise, below which it does not any more */
#define REACHED_SHARE 0.02f /* [-] of handover_speed: so near is there */
#define RETRY_CURRENT 1.3f  /* [-] of the last try's */
#define RETRY_RAMP    0.6f  /* [-] likewise */
#define GRIP_MAX      0.83f /* [-] sine of the largest load angle at which a forced frame takes over */
#define NEED_SHARE    (5.0f * DRIVE_PERIOD) /* [-] low-pass of the current that the load needs */

static void force_by(manoeuvres_t *m, const manoeuvres_input_t *input, frame_change_t change,
                     demand_t *demand)
{
    const dq_t emf = frames_park(input->estimate->emf, m->forced.frame.rotation);
    demand->frame = m->forced.frame;
    demand->change = (int32_t)change;
    demand->current = forced_step(&m->forced, emf);
    demand->emf = (dq_t){FORCED_EMF_SHARE * emf.d, FORCED_EMF_SHARE * emf.q};
    demand->omega_m_ref = m->forced.frame.omega_e * m->limits.pole_pairs_inverse;
}

/* The frame turns from the first period on, in the direction that is wished for: slowly, and once round, so
 * that it takes every rotor along wherever that stands. */
void manoeuvres_begin_start(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand)
{
    const forced_tuning_t *tuning = &m->forced.tuning;
    const bool first = m->start_try == 0u;
    m->start_try++;
    m->quickness = first ? 1.0f : RETRY_RAMP * m->quickness;
    m->current = first ? tuning->current : bounds_clamp(RETRY_CURRENT * m->current, m->limits.current_max);
    m->needed = m->current;
    m->length = 0.0f;
    m->tracking = 0u;
    manoeuvres_enter(m, MANOEUVRE_ALIGN);
    /* who wanted to stop has found the rotor standing */
    const float speed = input->wish.mode == RUN_STOP ? 0.0f : m->limits.align_speed;
    forced_enter(&m->forced, 0.0f, manoeuvres_wanted(m, &input->wish) < 0.0f ? -speed : speed, 0.0f);
    force_by(m, input, FRAME_ANEW, demand);
}

/* Towards `wanted` [A], by no more than the rise. */
static void raise_current(manoeuvres_t *m, float wanted)
{
    m->forced.current += bounds_clamp(wanted - m->forced.current, m->limits.current_rise);
}

void manoeuvres_align(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand)
{
    raise_current(m, m->current);
    if (m->periods >= m->limits.align_periods) {
        manoeuvres_enter(m, MANOEUVRE_RAMP);
    }
    force_by(m, input, FRAME_GOES_ON, demand);
}

/* Is a leg's loss in doubt? One that dwells at zero current in a slow ramp pretends an EMF for some 20 ms. */
static bool leg_dwells(const manoeuvres_t *m, ab_t current)
{
    const abc_t phases = frames_inverse_clarke(current);
    const bounds_span_t span =
        bounds_span(bounds_magnitude(phases.a), bounds_magnitude(phases.b), bounds_magnitude(phases.c));
    return span.smallest < m->limits.doubtful;
}

/* Does the rotor follow? Asked from fallback_speed on. What is in doubt says nothing of the EMF's length. */
static bool stalls(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const float speed = bounds_magnitude(m->forced.frame.omega_e);
    const bool asked = speed >= m->limits.fallback_speed;
    if (!leg_dwells(m, input->current)) {
        m->length = lowpass_step(m->length, LENGTH_SHARE, input->estimate->amplitude);
    }
    const bool follows = m->length >= STALL_SHARE * m->limits.flux_linkage * speed;
    m->stall_periods = asked && !follows ? m->stall_periods + 1u : 0u;
    return m->stall_periods >= STALL_PERIODS;
}

/* Whether the loop tracks beside the forced frame: it does where there is EMF enough. */
static void track_beside(manoeuvres_t *m, const estimate_t *estimate)
{
    const float speed = bounds_magnitude(m->forced.frame.omega_e);
    if (m->tracking == 0u && speed >= TRACK_SHARE * m->limits.handover_speed) {
        const float omega_e = m->forced.frame.omega_e;
        manoeuvres_lock_to(m, (position_t){catch_angle(estimate->emf, omega_e), omega_e},
                           estimate->amplitude);
    } else if (m->tracking != 0u && speed < UNTRACK_SHARE * m->limits.handover_speed) {
        m->tracking = 0u;
    } else if (m->tracking != 0u) {
        lock_step(&m->lock, estimate);
    }
}

/* Names of one thing: the forced frame on its way up, through zero, or at a speed that stays. */
static void name_forced(manoeuvres_t *m, float wanted)
{
    if (bounds_within(wanted, m->limits.handover_speed)) {
        m->now = (int32_t)MANOEUVRE_FORCED;
    } else if (m->now == (int32_t)MANOEUVRE_FORCED) {
        m->now = (int32_t)(wanted * m->forced.frame.omega_e < 0.0f ? MANOEUVRE_REVERSE : MANOEUVRE_RAMP);
    }
}

/* The current that the load needs, over some swings [A]; unknown while nothing tracks. */
static void see_need(manoeuvres_t *m, float i_q)
{
    if (m->locking != 0u) {
        m->needed = bounds_magnitude(i_q);
    } else if (m->tracking != 0u) {
        m->needed = lowpass_step(m->needed, NEED_SHARE, bounds_magnitude(i_q));
    }
}

/* The current of the forced frame: all of a start's while it speeds up or passes zero; at a speed that stays
 * what the load needs as far as it has been seen, and some more, for a step of the load is not seen before.
 */
static void force_current(manoeuvres_t *m)
{
    float wanted = m->current;
    if (m->now == (int32_t)MANOEUVRE_FORCED) {
        const float with_margin = 1.5f * m->needed + 0.1f * m->current;
        wanted = with_margin < wanted ? with_margin : wanted;
        wanted = wanted > 0.5f * m->current ? wanted : 0.5f * m->current;
    }
    raise_current(m, wanted);
}

/* A start has failed by this: once more after a catch, or no more. */
static void fail(manoeuvres_t *m, uint32_t why)
{
    if (m->start_try >= m->limits.start_tries) {
        m->failed |= why;
    } else {
        manoeuvres_enter_catch(m, MANOEUVRE_CATCH, PAUSE_PERIODS, 0.0f);
    }
}

void manoeuvres_force(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const float wanted = manoeuvres_wanted(m, &input->wish);
    const float target = bounds_clamp(wanted, limits->handover_speed);
    const dq_t seen = frames_park(input->current, input->estimate->frame.rotation);
    forced_speed(&m->forced, target, m->quickness * limits->ramp);
    name_forced(m, wanted);
    track_beside(m, input->estimate);
    see_need(m, seen.q);
    force_current(m);
    if (stalls(m, input)) {
        fail(m, MANOEUVRE_STALLED);
    } else if (m->now != (int32_t)MANOEUVRE_FORCED &&
               bounds_within(target - m->forced.frame.omega_e, REACHED_SHARE * limits->handover_speed)) {
        manoeuvres_enter(m, MANOEUVRE_HANDOVER);
        handover_enter(&m->handover, seen);
    }
    force_by(m, input, FRAME_GOES_ON, demand);
}

/* Out of the forced frame into the estimate's, in which this current flows [A]: nothing but the frame
 * changes. */
static void take_over(manoeuvres_t *m, const manoeuvres_input_t *input, dq_t seen, demand_t *demand)
{
    manoeuvres_enter_run(m, seen, input->estimate->omega_smooth);
    manoeuvres_run_observed(m, input, m->run.omega_m_ref, demand);
    demand->change = (int32_t)FRAME_TURNS;
}

void manoeuvres_hand_over(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand)
{
    const estimate_t *estimate = input->estimate;
    const float forced = m->forced.frame.omega_e;
    const float wanted = manoeuvres_wanted(m, &input->wish);
    const dq_t seen = frames_park(input->current, estimate->frame.rotation);
    lock_step(&m->lock, estimate);
    see_need(m, seen.q);
    m->forced.current = handover_current(&m->handover, m->forced.current, m->current, m->needed);
    const handover_outcome_t outcome = handover_step(&m->handover, estimate, &m->lock, forced, seen);
    if (outcome == HANDOVER_GOOD) {
        take_over(m, input, m->handover.mean, demand);
        return;
    }
    if (outcome == HANDOVER_FAILED) {
        fail(m, MANOEUVRE_UNLOCKED);
    } else if (stalls(m, input)) {
        fail(m, MANOEUVRE_STALLED);
    } else if (bounds_within(wanted, m->limits.handover_speed) || wanted * forced < 0.0f) {
        manoeuvres_enter(m, MANOEUVRE_FORCED);
    }
    force_by(m, input, FRAME_GOES_ON, demand);
}

/* From the estimate's frame into a forced one in which the same torque acts: its d axis is ahead of the
 * rotor's by the load angle. The speed is the lesser of two that can both be wrong. */
void manoeuvres_fall_back(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand)
{
    const estimate_t *estimate = input->estimate;
    const dq_t seen = frames_park(input->current, estimate->frame.rotation);
    m->current = m->forced.tuning.current;
    m->quickness = 1.0f;
    m->needed = bounds_magnitude(seen.q);
    m->length = estimate->amplitude;
    const float sine = bounds_clamp(seen.q * m->forced.tuning.current_inverse, GRIP_MAX);
    const float square = 1.0f - sine * sine;
    const float ahead = trig_angle((rotation_t){sine, square * inverse_root(square)});
    const float emf_speed = estimate->amplitude * m->limits.speed_per_volt;
    const float omega_e = bounds_clamp(estimate->omega_smooth, emf_speed);
    manoeuvres_enter(m, MANOEUVRE_FORCED);
    forced_enter(&m->forced, angle_turn_back(estimate->frame.theta_e + ahead), omega_e, m->current);
    m->tracking = 0u;
    force_by(m, input, FRAME_TURNS, demand);
}
