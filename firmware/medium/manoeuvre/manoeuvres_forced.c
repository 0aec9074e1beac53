/* The manoeuvres in the forced frame: align, ramp, forced, reverse, hand-over. */
#include "medium/manoeuvre/manoeuvres_parts.h"

#include "math/bounds.h"
#include "math/filter.h"
#include "math/root.h"
#include "math/trig.h"

#define PAUSE_PERIODS    DRIVE_PERIODS(0.3f)   /* time without current before another start */
#define STALL_WINDOWS    DRIVE_WINDOWS(50e-3f) /* with too little EMF */
#define ASTRAY_WINDOWS   DRIVE_WINDOWS(20e-3f) /* after which the loop beside the frame is locked again */
#define HANDOVER_WINDOWS DRIVE_WINDOWS(1.0f)   /* longest time of a hand-over */
#define STALL_SHARE      0.6f                  /* [-] least share of the EMF of a rotor in step */
/* [-] the same of the part of the EMF across the current: 0.56 at the largest load angle at which the rotor
 * holds (GRIP_MAX), with a configured psi_f that is a quarter too large. */
#define ACROSS_SHARE 0.4f
#define LENGTH_SHARE                                                                                         \
    (50.0f * DRIVE_WINDOW_PERIOD) /* [-] low-pass of the EMF's length, wrong for 20 ms at zero current */
#define TRACK_SHARE   0.4f        /* [-] of handover_speed: the loop tracks above this */
#define UNTRACK_SHARE 0.3f        /* [-] of handover_speed: it stops tracking below this */
#define REACHED_SHARE 0.02f       /* [-] of handover_speed: the speed counts as reached within this */
#define RETRY_CURRENT 1.3f        /* [-] factor on the last try's current */
#define RETRY_RAMP    0.6f        /* [-] factor on the last try's ramp */
#define GRIP_MAX      0.83f       /* [-] sine of the largest load angle at which a forced frame takes over */
#define NEED_SHARE    (5.0f * DRIVE_WINDOW_PERIOD) /* [-] low-pass of the current that the load needs */

/* Writes the state of the forced frame, which holds for the end of the next window, to the setpoint. */
static void force_by(const manoeuvres_t *m, setpoint_t *setpoint)
{
    setpoint->source = (int32_t)SOURCE_FORCED;
    setpoint->forced.speed = m->forced.speed;
    setpoint->forced.current = m->forced.current;
    setpoint->omega_m_ref = m->forced.speed * m->limits.pole_pairs_inverse;
}

/* Moves the current towards `wanted` [A], by no more than this rise [A]. */
static void raise_current(manoeuvres_t *m, float wanted, float rise)
{
    m->forced.current += bounds_clamp(wanted - m->forced.current, rise);
}

/* A forced frame begins, ahead of the estimate or of zero by this angle [rad], at its present speed. */
static void begin_frame(manoeuvres_t *m, frame_change_t change, float ahead, setpoint_t *setpoint)
{
    m->tracking = 0u;
    setpoint->enter = 1u;
    setpoint->change = (int32_t)change;
    setpoint->lock = (int32_t)LOCK_KEEP;
    setpoint->forced.ahead = ahead;
    setpoint->forced.begin = m->forced.speed;
    force_by(m, setpoint);
}

/* The frame turns from the first period on, in the requested direction: one slow turn, which takes along a
 * rotor from any angle. */
void manoeuvres_begin_start(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const bool first = m->start_try == 0u;
    m->start_try++;
    m->forced.quickness = first ? 1.0f : RETRY_RAMP * m->forced.quickness;
    m->forced.wanted =
        first ? limits->current_start : bounds_clamp(RETRY_CURRENT * m->forced.wanted, limits->current_retry);
    m->forced.needed = m->forced.wanted;
    m->forced.emf_length = 0.0f;
    m->forced.emf_across = 0.0f;
    manoeuvres_enter(m, MANOEUVRE_ALIGN);
    /* a stop was requested and the rotor stands */
    const float speed = input->wish.mode == RUN_STOP ? 0.0f : limits->align_speed;
    m->forced.speed = manoeuvres_wanted(m, &input->wish) < 0.0f ? -speed : speed;
    m->forced.current = 0.0f;
    raise_current(m, m->forced.wanted, m->limits.align_rise);
    begin_frame(m, FRAME_ANEW, 0.0f, setpoint);
}

void manoeuvres_align(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const bool stops = input->wish.mode == RUN_STOP; /* a stop omits the first turn of the frame */
    raise_current(m, m->forced.wanted, m->limits.align_rise);
    if (m->windows >= m->limits.align_windows || stops) {
        manoeuvres_enter(m, MANOEUVRE_RAMP);
    }
    force_by(m, setpoint);
}

/* True if the sign of a leg's loss is uncertain. A leg that stays near zero current in a slow ramp adds an
 * error to the EMF for some 20 ms. */
static bool leg_dwells(const manoeuvres_t *m, ab_t current)
{
    const abc_t phases = frames_inverse_clarke(current);
    const bounds_span_t span =
        bounds_span(bounds_magnitude(phases.a), bounds_magnitude(phases.b), bounds_magnitude(phases.c));
    return span.smallest < m->limits.doubtful;
}

/* True if the rotor does not follow; judged from fallback_speed on. An uncertain loss makes the length of the
 * EMF unusable. A wrong R makes a voltage along the current, which at a low speed reduces the length as much
 * as a rotor that stands; the part of the EMF across the current shows then that the rotor follows. */
static bool stalls(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const float speed = bounds_magnitude(m->forced.speed);
    const bool asked = speed >= m->limits.fallback_speed;
    if (!leg_dwells(m, input->sample)) {
        const ab_t emf = input->estimate->emf;
        const float across = input->sample.alpha * emf.beta - input->sample.beta * emf.alpha;
        m->forced.emf_length = lowpass_step(m->forced.emf_length, LENGTH_SHARE, input->estimate->amplitude);
        m->forced.emf_across =
            lowpass_step(m->forced.emf_across, LENGTH_SHARE, m->forced.speed < 0.0f ? -across : across);
    }
    /* along the magnet i_d > 0 reduces the flux of a salient rotor; without
     * tracking the EMF is that of L_d */
    const float tracked = input->estimate->flux;
    const bool less = m->tracking != 0u && tracked < m->limits.flux_linkage;
    const float flux = less ? tracked : m->limits.flux_linkage;
    const bool follows = m->forced.emf_length >= STALL_SHARE * flux * speed ||
                         m->forced.emf_across >= ACROSS_SHARE * flux * speed * m->forced.current;
    m->forced.stalling = asked && !follows ? m->forced.stalling + 1u : 0u;
    return m->forced.stalling >= STALL_WINDOWS;
}

/* The loop begins beside the frame, at the frame's speed and the angle of the EMF. */
static void lock_to_emf(manoeuvres_t *m, setpoint_t *setpoint)
{
    setpoint->lock = (int32_t)LOCK_TO_EMF;
    m->tracking = 1u;
    m->forced.astray = 0u;
    lock_reset(&m->lock, m->forced.speed);
}

/* Judges the loop beside the frame, and locks it again if it has left the rotor. Noise that exceeds the EMF
 * can move the loop of a light rotor to a speed beyond its range, from which the EMF does not bring it back.
 * A loop that is locked to a rotor at another speed than that of the frame is not changed. */
static void judge_beside(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const estimate_t *estimate = input->estimate;
    lock_step(&m->lock, estimate, input->scatter, 0.0f, false);
    const bool near = bounds_within(estimate->omega_smooth - m->forced.speed, m->limits.handover_speed);
    m->forced.astray = !near && lock_is_lost(&m->lock, true) ? m->forced.astray + 1u : 0u;
    if (m->forced.astray >= ASTRAY_WINDOWS) {
        lock_to_emf(m, setpoint);
    }
}

/* Decides whether the loop tracks beside the forced frame: it does where the EMF is large enough. */
static void track_beside(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const float speed = bounds_magnitude(m->forced.speed);
    if (m->tracking == 0u && speed >= TRACK_SHARE * m->limits.handover_speed) {
        lock_to_emf(m, setpoint);
    } else if (m->tracking != 0u && speed < UNTRACK_SHARE * m->limits.handover_speed) {
        setpoint->lock = (int32_t)LOCK_RELEASE;
        m->tracking = 0u;
    } else if (m->tracking != 0u && input->tracked != 0u) {
        judge_beside(m, input, setpoint);
    }
}

/* Sets the name of the forced frame: accelerating, through zero, or at a constant speed. */
static void name_forced(manoeuvres_t *m, float wanted)
{
    if (bounds_within(wanted, m->limits.handover_speed)) {
        m->now = (int32_t)MANOEUVRE_FORCED;
    } else if (m->now == (int32_t)MANOEUVRE_FORCED) {
        m->now = (int32_t)(wanted * m->forced.speed < 0.0f ? MANOEUVRE_REVERSE : MANOEUVRE_RAMP);
    }
}

/* The current that the load needs, averaged over some swings [A]; unknown while the loop does not track. */
static void see_need(manoeuvres_t *m, const manoeuvres_input_t *input, const setpoint_t *setpoint)
{
    const float i_q = bounds_magnitude(input->current.q);
    if (setpoint->lock == (int32_t)LOCK_TO_EMF) {
        m->forced.needed = i_q;
    } else if (m->tracking != 0u && input->tracked != 0u) {
        m->forced.needed = lowpass_step(m->forced.needed, NEED_SHARE, i_q);
    }
}

/* The current of the forced frame: the full start current while it accelerates or passes zero; at a constant
 * speed the measured need of the load and a reserve, because a step of the load is not detected beforehand.
 * The need is measured in the estimate's frame. A wrong dead time turns that frame so far that a load seems
 * to need no current. */
static void force_current(manoeuvres_t *m, bool voltage_near)
{
    float wanted = m->forced.wanted;
    if (m->now == (int32_t)MANOEUVRE_FORCED && voltage_near) {
        const float with_margin = 1.5f * m->forced.needed + 0.1f * m->forced.wanted;
        wanted = with_margin < wanted ? with_margin : wanted;
        wanted = wanted > 0.5f * m->forced.wanted ? wanted : 0.5f * m->forced.wanted;
    }
    raise_current(m, wanted, MANOEUVRE_RISE * m->limits.current_start);
}

/* A start has failed for this reason: another try follows after a catch, or the fault if no try is left. */
static void fail(manoeuvres_t *m, uint32_t why, setpoint_t *setpoint)
{
    if (m->start_try >= m->limits.start_tries) {
        m->failed |= why;
    } else {
        manoeuvres_enter_catch(m, MANOEUVRE_CATCH, PAUSE_PERIODS, 0.0f, setpoint);
    }
}

void manoeuvres_force(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const float wanted = manoeuvres_wanted(m, &input->wish);
    const float target = bounds_clamp(wanted, limits->handover_speed);
    const float ramp = input->wish.mode == RUN_STOP ? limits->stop_ramp : limits->ramp;
    m->forced.speed = forced_eased(m->forced.speed, target, limits->ease_share, m->forced.quickness * ramp);
    name_forced(m, wanted);
    track_beside(m, input, setpoint);
    see_need(m, input, setpoint);
    force_current(m, input->voltage_near != 0u);
    force_by(m, setpoint);
    if (stalls(m, input)) {
        fail(m, MANOEUVRE_STALLED, setpoint);
    } else if (m->now != (int32_t)MANOEUVRE_FORCED &&
               bounds_within(target - m->forced.speed, REACHED_SHARE * limits->handover_speed)) {
        manoeuvres_enter(m, MANOEUVRE_HANDOVER);
        handover_enter(&m->handover, input->current);
    }
}

void manoeuvres_hand_over(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const estimate_t *estimate = input->estimate;
    const float forced = m->forced.speed;
    const float wanted = manoeuvres_wanted(m, &input->wish);
    judge_beside(m, input, setpoint);
    see_need(m, input, setpoint);
    m->forced.current = handover_current(&m->handover, m->forced.current, m->forced.wanted, m->forced.needed);
    force_by(m, setpoint);
    const handover_input_t judged = {
        .omega_smooth = estimate->omega_smooth,
        .omega_forced = forced,
        .current = input->current,
        .needed = m->forced.needed,
    };
    if (handover_step(&m->handover, &judged, &m->lock)) { /* only the frame changes, not the current */
        manoeuvres_enter_run(m, m->handover.mean, estimate->omega_smooth);
        manoeuvres_run_at(m, input, estimate->frame.omega_e, m->run.omega_m_ref, setpoint);
        setpoint->change = (int32_t)FRAME_TURNS;
    } else if (m->windows >= HANDOVER_WINDOWS) {
        fail(m, MANOEUVRE_UNLOCKED, setpoint);
    } else if (stalls(m, input)) {
        fail(m, MANOEUVRE_STALLED, setpoint);
    } else if (bounds_within(wanted, m->limits.handover_speed) || wanted * forced < 0.0f) {
        manoeuvres_enter(m, MANOEUVRE_FORCED);
    }
}

/* Changes from the estimate's frame to a forced one in which the same torque acts: its d axis is ahead of the
 * rotor's by the load angle. Two speeds, which can both be wrong, are available; the smaller one is used. If
 * the loop is scattered, neither is that of the rotor, and the frame begins at rest. One division. */
void manoeuvres_fall_back(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const estimate_t *estimate = input->estimate;
    const float i_q = input->current.q;
    m->forced.wanted = m->limits.current_start;
    m->forced.quickness = 1.0f;
    m->forced.needed = bounds_magnitude(i_q);
    m->forced.emf_length = estimate->amplitude;
    m->forced.emf_across = 0.0f;
    const float sine = bounds_clamp(i_q * m->limits.current_inverse, GRIP_MAX);
    const float square = 1.0f - sine * sine;
    const float ahead = trig_angle((rotation_t){sine, square * inverse_root(square)});
    const float emf_speed = estimate->amplitude / m->limits.flux_linkage;
    manoeuvres_enter(m, MANOEUVRE_FORCED);
    m->forced.speed = lock_is_scattered(&m->lock) ? 0.0f : bounds_clamp(estimate->omega_smooth, emf_speed);
    m->forced.current = m->forced.wanted;
    begin_frame(m, FRAME_TURNS, ahead, setpoint);
}
