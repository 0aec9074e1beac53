#include "medium/medium_parts.h"

#include <string.h>

#include "guard/guard_quantities.h"
#include "math/bounds.h"
#include "settings/reasons.h"

/* [-] of the EMF of a rotor with the estimated speed: psi_f wrong by a quarter, and an angle by 0.35 rad */
#define CONFIRMED_LEAST 0.7f
#define CONFIRMED_MOST  1.5f
#define CONFIRMED_LAG   1.25f /* [-] speed over that of the loop without its proportional part */
#define CONFIRMED_GROWN 1.1f  /* [-] of the mean over 3 ms: largest mean over 1.7 ms */

/* [-] of the link: largest EMF of a rotor whose current through the diodes is not detected */
#define CONFIRMED_BEYOND 1.15f

/* [-] of overspeed_trip: above it the bridge does not come on. Below it the noise of the encoder's speed
 * causes no trip before the EMF is known. */
#define SWITCH_ON_SPEED 0.9f

/* Time for which a suspected sensor or wire has priority over the EMF. */
#define SUSPICION_PERIODS DRIVE_PERIODS(3.5e-3f)

/* ---- faults ---- */

/* True if the EMF of the newest catch comes from a rotor. Noise has a length, but no mean in a rotating
 * frame, and no direction. An open wire makes an EMF that grows, so that its short mean exceeds the long one.
 * A rotor whose EMF is far above the link would have fed it before the gates were on. */
static bool is_caught(const window_t *window)
{
    const catch_seen_t *catching = &window->catching.seen;
    const float least = CONFIRMED_LEAST * catching->length;
    const float grown = CONFIRMED_GROWN * catching->length;
    const float most = CONFIRMED_BEYOND * FRAMES_ONE_OVER_SQRT_3 * window->measured.u_dc;
    const ab_t mean = catching->emf;
    const float square = mean.alpha * mean.alpha + mean.beta * mean.beta;
    return square >= least * least && square <= grown * grown &&
           !bounds_within(catching->cross, catching->cross_min) && catching->length <= most;
}

/* True if the EMF confirms the speed. In a loop that tracks the rotor the EMF lies on the q axis and has the
 * expected length, also for the speed at the stop, which the estimate may have reached within a window. The
 * low-pass of this EMF begins with the expected one: in a loop that has just begun, the catch before has to
 * confirm the speed. A relock is excluded, because its loop did not follow the rotor at the beginning; the
 * outcome of a lost catch is not used. */
static bool is_confirmed(const medium_t *medium, const window_t *window, float omega_e)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    const float now = medium->estimate.flux * bounds_magnitude(omega_e);
    const float expected = now > m->lock.expected ? now : m->lock.expected;
    if (m->tracking == 0u) {
        return m->now == (int32_t)MANOEUVRE_CATCH && is_caught(window);
    }
    const bool begins = m->now == (int32_t)MANOEUVRE_RUN && m->windows < MANOEUVRE_MASKED;
    return manoeuvres_knows(m) && (!begins || is_caught(window)) &&
           m->lock.projection >= CONFIRMED_LEAST * expected &&
           m->lock.projection <= CONFIRMED_MOST * m->lock.expected;
}

/* True if the rotor may be slower than overspeed_trip. The speed of a catch is the length of the EMF over
 * psi_f, which may be too small. A loop that tracks counts turns, but after a lost lock the speed contains
 * its proportional part: the speed without this part, which lags, must be near the trip, too. */
static bool may_be_slower(const medium_t *medium, const window_t *window)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    const float tracked = CONFIRMED_LAG * medium->estimate.omega_smooth * m->limits.pole_pairs_inverse;
    const float least = m->tracking == 0u ? CONFIRMED_LEAST * window->omega_m : tracked;
    return bounds_within(least, medium->speed.trip);
}

/* The measurements at the end of the window. */
drive_fault_t medium_seen_in(const window_t *window, int32_t reason)
{
    return (drive_fault_t){
        .reason = reason,
        .period = window->period,
        .i_a = window->measured.current_abc.a,
        .i_b = window->measured.current_abc.b,
        .u_dc = window->measured.u_dc,
        .theta_e = window->rotor.theta_e,
        .omega_e = window->rotor.omega_e,
    };
}

/* True if the speed at the stop was that of the encoder. The position source may have changed since the
 * setpoint that acts was made; the fast task reports the source of a stop of its own. */
static bool is_by_encoder(const medium_t *medium, const window_t *window)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    if (window->report.stop.reason != (int32_t)REASON_NONE) {
        return window->report.source == (int32_t)SOURCE_ENCODER;
    }
    return m->sensorless == 0u && m->now != (int32_t)MANOEUVRE_CATCH && m->now != (int32_t)MANOEUVRE_RELOCK;
}

/* Changes a fault of the shaft's speed into a fault of the estimate if only the estimate shows it, and into
 * one of the encoder if only the encoder shows it while the EMF is that of a slower rotor. */
static int32_t true_reason(const medium_t *medium, const window_t *window, const drive_fault_t *stop)
{
    const int32_t reason = medium->sequence.fault_reason;
    const bool overspeed = reason == (int32_t)REASON_OVERSPEED;
    if (!overspeed && reason != (int32_t)REASON_ROTOR_TOO_FAST) {
        return reason;
    }
    if (is_by_encoder(medium, window)) {
        const bool denied = overspeed && encoder_watch_denies(&medium->encoder_watch, stop->omega_e);
        return denied ? (int32_t)REASON_ENCODER_MISMATCH : reason;
    }
    const bool sure =
        is_confirmed(medium, window, stop->omega_e) && !(overspeed && may_be_slower(medium, window));
    return sure ? reason : (int32_t)REASON_ESTIMATE_ASTRAY;
}

/* The drive has stopped with a fault; stores the measurements. */
static void note(medium_t *medium, const window_t *window, drive_fault_t stop)
{
    sequence_t *sequence = &medium->sequence;
    sequence->fault_reason = true_reason(medium, window, &stop);
    medium->fault = stop;
    medium->fault.reason = sequence->fault_reason;
    medium->fault.manoeuvre = medium->manoeuvres.now;
    medium->faults++;
}

void medium_stop(medium_t *medium, const window_t *window, drive_fault_t stop)
{
    sequence_fault(&medium->sequence, stop.reason);
    note(medium, window, stop);
}

/* ---- guard ---- */

/* The conditions under which rows of the fault table are judged while the gates are on. */
static uint32_t moments(const medium_t *medium, const medium_tuning_t *tuning)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    if (!sequence_bridge_on(&medium->sequence)) {
        return GUARD_ALWAYS;
    }
    return GUARD_ALWAYS | GUARD_RUNNING | (m->sensorless != 0u ? 0u : GUARD_ENCODER) |
           (manoeuvres_judged(m) ? GUARD_TRACKING : 0u) |
           (link_watch_excuses(&medium->link.watch, &tuning->link) ? 0u : GUARD_SUPPLIED);
}

/* True if the EMF is above the link. A wrong sensor or wire may be the cause: while one is suspected its own
 * fault is judged first, for a limited time. */
static bool is_too_fast(const medium_t *medium, const window_t *window)
{
    return (medium->manoeuvres.failed & MANOEUVRE_TOO_FAST) != 0u &&
           ((medium->found.current_faults & CURRENT_WATCH_MAYBE) == 0u ||
            window->catching.seen.periods_beyond >= SUSPICION_PERIODS);
}

/* Judges the rows of the fault table that belong to the window. */
static void judge(medium_t *medium, const medium_tuning_t *tuning, const window_t *window)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    medium->background.unattended += medium->background.unattended != 0u ? DRIVE_WINDOW : 0u;
    const guard_found_t found = {
        .estimate_invalid = medium->estimate.invalid,
        .unlocked = m->unlocked,
        .failed = m->failed,
        .too_fast = is_too_fast(medium, window) ? 1u : 0u,
        .unattended = medium->background.unattended > tuning->unattended_max ? 1u : 0u,
        .reported = medium->background.reported,
        .moves_wrong = medium->found.moves_wrong,
        .encoder_lost = m->encoder_lost,
        .current_faults = medium->found.current_faults,
        .heat = medium->thermal.conditions,
        .link = medium->link.watch.conditions,
        .loops = (m->limits.slow_loop != 0u ? GUARD_LOOP_SLOW : 0u) |
                 (m->run.calm < 1.0f ? GUARD_LOOP_OSCILLATED : 0u),
        .chopper = medium->outputs.chopper.conditions,
        .brake_torque = medium->outputs.brake.failed,
    };
    const guard_input_t input = {
        .measured = &window->measured,
        .omega_m = window->omega_m,
        .encoder_wrong = medium->found.encoder_wrong,
        .found = &found,
        .now = medium->sequence.state == (int32_t)DRIVE_SWITCHED_ON ? GUARD_ALWAYS : moments(medium, tuning),
    };
    guard_step_slow(&medium->guard, &tuning->guard, &input);
}

/* ---- sequence ---- */

static uint32_t sequence(medium_t *medium, const window_t *window, const requests_t *requests)
{
    const bool was_fault = medium->sequence.state == (int32_t)DRIVE_FAULT;
    const sequence_input_t input = {
        .requests = requests,
        .measured = &window->measured,
        .faults = fault_set_both(medium->guard.faults, window->report.failed),
        .stops = medium->guard.stops,
        .standing = manoeuvres_knows(&medium->manoeuvres) &&
                    bounds_within(window->omega_m, medium->sequence.tuning.standstill),
        .overspeed = is_by_encoder(medium, window) &&
                     !bounds_within(window->omega_m, SWITCH_ON_SPEED * medium->speed.trip),
        .brake_set = medium->outputs.brake.state == (int32_t)BRAKE_SET,
        .bridge = (bridge_t)window->bridge,
        .calibration = (calibration_t)window->sensors.calibration,
    };
    if (window->report.stop.reason != (int32_t)REASON_NONE && !was_fault) {
        medium_stop(medium, window, window->report.stop);
    }
    const bool stopped = medium->sequence.state == (int32_t)DRIVE_FAULT;
    const uint32_t order = sequence_step(&medium->sequence, &input);
    if (!stopped && medium->sequence.state == (int32_t)DRIVE_FAULT) {
        note(medium, window, medium_seen_in(window, REASON_NONE));
    }
    return order;
}

/* ---- manoeuvre ---- */

/* The orders of a turning step of commissioning. */
static run_wish_t commissioned(const turning_wish_t *wish)
{
    return (run_wish_t){wish->by_current != 0u ? RUN_CURRENT : RUN_SPEED, wish->omega_m_ref, wish->current,
                        0.0f};
}

static run_wish_t wish(const medium_t *medium, const medium_tuning_t *tuning, const requests_t *requests)
{
    run_wish_t wish = {RUN_SPEED,
                       requests->speed_request,
                       {requests->i_d_request, requests->i_q_request},
                       requests->torque_request};
    if (medium->sequence.state == (int32_t)DRIVE_SWITCHED_ON) {
        wish.mode = RUN_ZERO;
    } else if (medium->sequence.state == (int32_t)DRIVE_QUICK_STOP) {
        wish.mode = RUN_STOP;
    } else if (commission_turns(&medium->commission)) {
        wish = commissioned(&medium->commission.wish);
    } else if (requests->mode == (int32_t)MODE_CURRENT) {
        wish.mode = RUN_CURRENT;
    } else if (requests->mode == (int32_t)MODE_TORQUE) {
        wish.mode = RUN_TORQUE;
    }
    if (tuning->outputs.brake.on != 0u && wish.mode != RUN_ZERO) {
        medium_hold(medium, tuning, &wish);
    }
    return wish;
}

/* The reaction that the fast task executes by itself if the encoder's angle jumps. */
static jump_reaction_t at_a_jump(const medium_t *medium, const window_t *window)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    const bool runs = sequence_bridge_on(&medium->sequence) &&
                      medium->sequence.state != (int32_t)DRIVE_SWITCHED_ON &&
                      m->now == (int32_t)MANOEUVRE_RUN && m->sensorless == 0u && window->estimating != 0u;
    if (!runs || m->limits.encoder_fault == (int32_t)ENCODER_FAULT_IGNORED) {
        return JUMP_IGNORED;
    }
    if (m->limits.encoder_fault != (int32_t)ENCODER_FAULT_SENSORLESS) {
        return JUMP_OPENS;
    }
    return manoeuvres_is_locked(m, &window->estimate) ? JUMP_TO_ESTIMATE : JUMP_TO_CATCH;
}

/* One window of the requested step of commissioning. */
static void commission(medium_t *medium, const medium_tuning_t *tuning, const window_t *window,
                       const requests_t *requests)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    if (commission_is_off(&medium->commission, requests->commission)) {
        return;
    }
    const commission_window_t input = {
        .standing = {.seen = &window->excite,
                     .current_abc = window->measured.current_abc,
                     .current = window->measured.current,
                     .u_dc = window->measured.u_dc,
                     .tripped = window->measured.flags & DRIVE_SAMPLE_TRIPPED},
        .turning =
            {
                .runs = m->now == (int32_t)MANOEUVRE_RUN && manoeuvres_steady(m) ? 1u : 0u,
                .theta_e = medium->means.theta,
                .omega_e = medium->means.omega,
                .emf = medium->means.emf_rotor,
                .current = medium->means.current_rotor,
                .speed = requests->speed_request,
                .least = m->limits.pole_pairs_inverse * m->limits.handover_speed,
            },
        .bridge_on = medium->sequence.state == (int32_t)DRIVE_OPERATION_ENABLED,
    };
    commission_window(&medium->commission, &tuning->commission, requests->commission, &input);
}

/* Executes the active manoeuvre: source of the frame and references. */
static void manoeuvre(medium_t *medium, const medium_tuning_t *tuning, const window_t *window,
                      const requests_t *requests, uint32_t order)
{
    manoeuvres_t *m = &medium->manoeuvres;
    setpoint_t *setpoint = &medium->setpoint;
    if ((order & SEQUENCE_ON) == 0u) {
        manoeuvres_end(m);
        setpoint->source = (int32_t)(m->sensorless != 0u ? SOURCE_NONE : SOURCE_ENCODER);
        setpoint->current = (dq_t){0.0f, 0.0f};
        setpoint->omega_m_ref = 0.0f;
        m->run.torque = 0.0f;
        return;
    }
    if ((order & SEQUENCE_BEGIN) != 0u) {
        flux_reset(&medium->flux, m->sensorless != 0u ? 0.0f : window->encoder.omega_e);
        offset_trim_reset(&medium->offset_trim, medium->offset_trim.offset);
        current_watch_begin(&medium->current_watch);
        manoeuvres_begin(m, window->omega_m, setpoint);
        if (commission_excites(&medium->commission)) {
            manoeuvres_stand(m, setpoint);
        }
        return;
    }
    if (commission_excites(&medium->commission)) {
        manoeuvres_stand(m, setpoint);
        return;
    }
    const manoeuvres_input_t input = medium_manoeuvres_input(medium, window, wish(medium, tuning, requests));
    const uint32_t tracked = m->tracking;
    run_limit(&m->run, window->bounds.lower, window->bounds.upper);
    run_look(&m->run, window->measured.u_dc, m->limits.pole_pairs * window->omega_m, window->voltage);
    manoeuvres_step(m, &input, setpoint);
    if (tracked == 0u && m->tracking != 0u) {
        flux_reset(&medium->flux, input.estimate->omega_smooth);
        offset_trim_reset(&medium->offset_trim, medium->offset_trim.offset);
    }
}

manoeuvres_input_t medium_manoeuvres_input(medium_t *medium, const window_t *window, run_wish_t wish)
{
    const float share = 1.0f / (float)DRIVE_WINDOW;
    return (manoeuvres_input_t){
        .estimate = &medium->estimate,
        .current = medium->means.current_rotor,
        .sample = window->measured.current,
        .scatter = share * window->sum.scatter,
        .tracked = window->sum.tracked,
        .encoder = window->encoder,
        .omega_m = window->omega_m,
        .wish = wish,
        .voltage_near = dead_time_learn_is_near(&medium->dead_time_learn) ? UINT32_C(1) : UINT32_C(0),
        .losses = medium->guard.losses.word[0] | medium->guard.losses.word[1],
        .outcome = window->catching.outcome,
        .setpoint = window->setpoint,
    };
}

/* ---- the task ---- */

/* Share with which the load estimate of the fast task follows i_q: zero from the setpoint that changes the
 * reference until the speed has arrived, because the excess of i_q accelerates then. */
static float load_share(medium_t *medium, const medium_tuning_t *tuning, const window_t *window)
{
    const inertia_t *inertia = &medium->inertia;
    const bool moves = medium->setpoint.omega_m_ref != medium->speed.reference;
    medium->speed.reference = medium->setpoint.omega_m_ref;
    medium->speed.still = moves ? 0u : medium->speed.still + (medium->speed.still <= DRIVE_LATENCY ? 1u : 0u);
    if (inertia->tuning.on == 0u || window->tracking == 0u) {
        return 0.0f;
    }
    const float share = inertia_load_share(inertia, &tuning->load);
    /* no window contains the setpoint that has changed the reference yet */
    return medium->speed.still <= DRIVE_LATENCY && share < 1.0f ? 0.0f : share;
}

/* z/2 is a sixth of the current that the effective dead time changes, and `swing` is DEAD_TIME_LEARN_SWINGS
 * T/L. */
#define SHIFT_OF_SWING (1.0f / (6.0f * DEAD_TIME_LEARN_SWINGS))

/* The zone of the legs at this DC link [V]. */
static float per_zone(const medium_t *medium, const medium_tuning_t *tuning, float link)
{
    return leg_zone_inverse(tuning->unequal_legs.per_zone, SHIFT_OF_SWING * tuning->dead_time_learn.swing *
                                                               medium->dead_time_learn.effective * link);
}

/* The part of the setpoint that does not depend on the manoeuvre. */
static void set(medium_t *medium, const medium_tuning_t *tuning, const window_t *window, uint32_t order)
{
    setpoint_t *setpoint = &medium->setpoint;
    const sequence_t *sequence = &medium->sequence;
    setpoint->gates = order & SEQUENCE_ON;
    setpoint->outputs = medium_outputs(medium, tuning, setpoint->gates);
    setpoint->calibrate = (int32_t)(sequence->state == (int32_t)DRIVE_NOT_READY ? CALIBRATE_ALL
                                    : sequence->state == (int32_t)DRIVE_FAULT   ? CALIBRATE_NOT
                                                                                : CALIBRATE_BLOCKS);
    setpoint->trim = medium->offset_trim.offset;
    setpoint->moments = moments(medium, tuning);
    setpoint->jump = (int32_t)at_a_jump(medium, window);
    setpoint->jump_periods = MANOEUVRE_CATCH_PERIODS;
    setpoint->dither =
        manoeuvres_dithers(&medium->manoeuvres) ? medium->inductance.dither : (dq_t){0.0f, 0.0f};
    const float room = run_room(&medium->manoeuvres.run); /* together with the remaining i_d of a hand-over */
    const float most = bounds_less(room, medium->thermal.limit);
    setpoint->driving_limit = most;
    setpoint->braking_limit = most;
    if (tuning->supply.on != 0u) {
        setpoint->driving_limit = bounds_less(medium->link.supply.driving, most);
        setpoint->braking_limit = bounds_less(medium->link.supply.braking, most);
    }
    /* with a holding brake the motor carries the load until the brake holds it */
    setpoint->only_brakes = sequence->state == (int32_t)DRIVE_QUICK_STOP &&
                            medium->manoeuvres.run.tuning.stop_ramp == 0.0f && tuning->outputs.brake.on == 0u;
    setpoint->models.load_share = load_share(medium, tuning, window);
    setpoint->models.load_seen = inertia_load_seen(&medium->inertia);
    setpoint->models.gained = inertia_gained(&medium->inertia, medium->means.omega);
    setpoint->models.foreseen = inertia_foreseen(&medium->inertia);
    setpoint->models.flux_linkage = medium->flux.flux_linkage;
    setpoint->models.speed_per_volt = medium->flux.speed_per_volt;
    setpoint->models.dead_time = medium->dead_time_learn.effective;
    setpoint->models.per_zone = per_zone(medium, tuning, window->link.mean);
    setpoint->models.spared = medium->ripple.spared;
    setpoint->excite.kind = (int32_t)EXCITE_NONE;
    if (medium->manoeuvres.now == (int32_t)MANOEUVRE_COMMISSION) {
        setpoint->excite = medium->commission.order;
    }
    /* In a forced frame the loop may have no EMF to follow; its proportional part is noise then. */
    const manoeuvres_t *m = &medium->manoeuvres;
    const bool damps = m->run.swings != 0u && !manoeuvres_forces(m);
    setpoint->smooth = damps ? 0u : m->limits.smooth;
    setpoint->link.sunk = medium->link.watch.sunk;
    setpoint->link.low = medium->link.watch.low;
}

void medium_step(medium_t *medium, const medium_tuning_t *tuning, const window_t *window,
                 const requests_t *requests)
{
    setpoint_t *setpoint = &medium->setpoint;
    setpoint->number = window->number;
    setpoint->enter = 0u;
    setpoint->change = (int32_t)FRAME_GOES_ON;
    setpoint->lock = (int32_t)LOCK_KEEP;
    setpoint->stiffness = 0.0f;

    medium_learn(medium, tuning, window);
    medium_watch_currents(medium, window);
    medium_watch_motion(medium, window, requests);
    medium_limit(medium, tuning, window, requests);
    medium_watch_outputs(medium, tuning, window);
    judge(medium, tuning, window);
    const uint32_t order = sequence(medium, window, requests);
    commission(medium, tuning, window, requests);
    manoeuvre(medium, tuning, window, requests, order);
    set(medium, tuning, window, order);
}

void medium_init(medium_t *medium, const medium_tuning_t *tuning)
{
    memset(medium, 0, sizeof *medium);
    guard_init(&medium->guard);
    sequence_init(&medium->sequence, &tuning->sequence);
    manoeuvres_init(&medium->manoeuvres, &tuning->manoeuvres);
    offset_trim_init(&medium->offset_trim, &tuning->offset_trim);
    inductance_init(&medium->inductance, &tuning->inductance);
    inertia_init(&medium->inertia, &tuning->inertia);
    encoder_watch_init(&medium->encoder_watch, &tuning->encoder_watch);
    motion_watch_init(&medium->motion_watch, &tuning->motion_watch);
    oscillation_watch_init(&medium->speed.oscillation, &tuning->oscillation_watch);
    thermal_init(&medium->thermal, &tuning->thermal);
    supply_limit_reset(&medium->link.supply, &tuning->supply);
    commission_init(&medium->commission);
    medium_set_tuning(medium, tuning);
    medium->setpoint.calibrate = (int32_t)CALIBRATE_ALL;
    medium->setpoint.moments = GUARD_ALWAYS;
    medium->setpoint.source = (int32_t)(medium->manoeuvres.sensorless != 0u ? SOURCE_NONE : SOURCE_ENCODER);
    medium->setpoint.driving_limit = medium->thermal.limit;
    medium->setpoint.braking_limit = medium->thermal.limit;
}

void medium_set_tuning(medium_t *medium, const medium_tuning_t *tuning)
{
    medium->background.in_force = tuning->in_force;
    medium->speed.trip = tuning->guard.limit[FAULT_LIMIT_OVERSPEED];
    sequence_take(&medium->sequence, &tuning->sequence);
    validity_take(&medium->trust.validity, &tuning->validity);
    flux_take(&medium->flux, &tuning->flux);
    offset_trim_take(&medium->offset_trim, &tuning->offset_trim);
    inductance_take(&medium->inductance, &tuning->inductance);
    inertia_take(&medium->inertia, &tuning->inertia);
    dead_time_learn_take(&medium->dead_time_learn, &tuning->dead_time_learn);
    emf_shape_take(&medium->ripple.emf_shape, &tuning->emf_shape);
    unequal_legs_take(&medium->ripple.unequal_legs, &tuning->unequal_legs);
    manoeuvres_take(&medium->manoeuvres, &tuning->manoeuvres);
    encoder_watch_take(&medium->encoder_watch, &tuning->encoder_watch);
    motion_watch_take(&medium->motion_watch, &tuning->motion_watch);
    oscillation_watch_take(&medium->speed.oscillation, &tuning->oscillation_watch);
    current_watch_take(&medium->current_watch, &tuning->current_watch);
    thermal_take(&medium->thermal, &tuning->thermal);
    if (tuning->supply.on == 0u) {
        supply_limit_reset(&medium->link.supply, &tuning->supply);
    }
    medium->setpoint.models.flux_linkage = medium->flux.flux_linkage;
    medium->setpoint.models.speed_per_volt = medium->flux.speed_per_volt;
    medium->setpoint.models.dead_time = medium->dead_time_learn.effective;
    medium->setpoint.models.per_zone = tuning->unequal_legs.per_zone;
}
