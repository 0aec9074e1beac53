#include "drive/manoeuvres.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/filter.h"

#define CATCH_PERIODS  DRIVE_PERIODS(20e-3f)
#define PAUSE_PERIODS  DRIVE_PERIODS(0.3f)   /* without current before another start */
#define STALL_PERIODS  DRIVE_PERIODS(50e-3f) /* with too little EMF */
#define MASKED_PERIODS DRIVE_PERIODS(50e-3f) /* after a hand-over */
#define SLOW_PERIODS   DRIVE_PERIODS(5e-3f)  /* below fallback_speed when that is asked for */
#define SOUND_PERIODS  DRIVE_PERIODS(0.5f)   /* of run, after which a start counts as done */
#define LOSS_PERIODS   DRIVE_PERIODS(2.0f)   /* in which three losses are one too many */

#define STALL_SHARE   0.6f                  /* [-] of the EMF that a rotor in step has, at least */
#define TRACK_SHARE   0.4f                  /* [-] of handover_speed, from which on the loop tracks */
#define UNTRACK_SHARE 0.3f                  /* [-] likewise, below which it does not any more */
#define PASSED_SHARE  1.67f                 /* [-] of fallback_speed, at which a reversal has passed zero */
#define REACHED_SHARE 0.02f                 /* [-] of handover_speed: so near is there */
#define RETRY_CURRENT 1.3f                  /* [-] of the last try's */
#define RETRY_RAMP    0.6f                  /* [-] likewise */
#define NEED_SHARE    (5.0f * DRIVE_PERIOD) /* [-] low-pass of the current that the load needs */
#define GRIP_MAX      0.83f /* [-] sine of the largest load angle at which a forced frame takes over */

static const frame_t stationary = {0.0f, 0.0f, {0.0f, 1.0f}};

static void enter(manoeuvres_t *m, manoeuvre_t manoeuvre)
{
    m->now = (int32_t)manoeuvre;
    m->periods = 0u;
    m->stall_periods = 0u;
    m->slow_periods = 0u;
    m->unlocked = 0u;
}

static void enter_catch(manoeuvres_t *m, manoeuvre_t manoeuvre, uint32_t periods, float omega_e)
{
    enter(m, manoeuvre);
    catch_enter(&m->catching, periods, omega_e);
    m->tracking = 0u;
}

static void enter_run(manoeuvres_t *m, dq_t current, float omega_e)
{
    enter(m, MANOEUVRE_RUN);
    m->tracking = 1u;
    m->reversing = 0u;
    m->sound_periods = 0u;
    lock_reset(&m->lock, omega_e);
    run_enter(&m->run, current, omega_e * m->limits.pole_pairs_inverse);
}

void manoeuvres_init(manoeuvres_t *m, const manoeuvres_tuning_t *tuning)
{
    forced_init(&m->forced, &tuning->forced);
    catch_init(&m->catching, &tuning->catching);
    handover_init(&m->handover, &tuning->handover);
    lock_init(&m->lock, &tuning->lock);
    run_init(&m->run, &tuning->run);
    m->limits = tuning->limits;
    enter(m, MANOEUVRE_OFF);
}

void manoeuvres_take(manoeuvres_t *m, const manoeuvres_tuning_t *tuning)
{
    forced_take(&m->forced, &tuning->forced);
    catch_take(&m->catching, &tuning->catching);
    handover_take(&m->handover, &tuning->handover);
    lock_take(&m->lock, &tuning->lock);
    run_take(&m->run, &tuning->run);
    m->other_source = m->limits.sensorless != tuning->limits.sensorless;
    m->limits = tuning->limits;
}

void manoeuvres_begin(manoeuvres_t *m, float omega_m)
{
    m->start_try = 0u;
    m->lock_losses = 0u;
    m->failed = 0u;
    if (m->limits.sensorless != 0u) {
        enter_catch(m, MANOEUVRE_CATCH, CATCH_PERIODS, 0.0f);
    } else {
        enter_run(m, (dq_t){0.0f, 0.0f}, omega_m * m->limits.pole_pairs);
    }
}

frame_t manoeuvres_rotor(const manoeuvres_t *m, const frame_t *encoder, const estimate_t *estimate)
{
    if (m->limits.sensorless == 0u) {
        return *encoder;
    }
    if (m->now == (int32_t)MANOEUVRE_OFF) {
        return stationary;
    }
    if (m->tracking != 0u) {
        return estimate->frame;
    }
    return manoeuvres_forces(m) ? m->forced.frame : (frame_t){0.0f, m->catching.omega_e, stationary.rotation};
}

bool manoeuvres_judged(const manoeuvres_t *m)
{
    return m->now == (int32_t)MANOEUVRE_RUN && m->reversing == 0u && m->periods > MASKED_PERIODS &&
           m->limits.sensorless != 0u;
}

/* The speed that is wished for [rad/s], electrical; a wish for a current starts in its direction. */
static float wanted_speed(const manoeuvres_t *m, const run_wish_t *wish)
{
    switch (wish->mode) {
    case RUN_SPEED:
        return wish->omega_m_ref * m->limits.pole_pairs;
    case RUN_CURRENT:
        return wish->current.q < 0.0f ? -m->limits.handover_speed : m->limits.handover_speed;
    case RUN_ZERO:
    case RUN_STOP:
        break;
    }
    return 0.0f;
}

/* The loop shall be locked where this EMF says, at a speed of this sign. */
static void lock_to(manoeuvres_t *m, position_t position)
{
    m->locking = 1u;
    m->locked = position;
    m->tracking = 1u;
    lock_reset(&m->lock, position.omega_e);
}

/* A start has failed by this: once more after a catch, or no more. */
static void fail(manoeuvres_t *m, uint32_t why)
{
    if (m->start_try >= m->limits.start_tries) {
        m->failed |= why;
    } else {
        enter_catch(m, MANOEUVRE_CATCH, PAUSE_PERIODS, 0.0f);
    }
}

/* ---- forced frame ---- */

static demand_t forced_demand(manoeuvres_t *m, const manoeuvres_input_t *input, frame_change_t change)
{
    const dq_t emf = frames_park(input->estimate->emf, m->forced.frame.rotation);
    demand_t demand = {m->forced.frame, (int32_t)change, forced_step(&m->forced, emf), {0.0f, 0.0f}, 0.0f};
    demand.emf = (dq_t){FORCED_EMF_SHARE * emf.d, FORCED_EMF_SHARE * emf.q};
    demand.omega_m_ref = m->forced.frame.omega_e * m->limits.pole_pairs_inverse;
    return demand;
}

/* The first of two steps: a quarter turn beside the second, so that a rotor which the one cannot turn, the
 * other does. */
static demand_t begin_start(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const forced_tuning_t *tuning = &m->forced.tuning;
    const bool first = m->start_try == 0u;
    m->start_try++;
    m->quickness = first ? 1.0f : RETRY_RAMP * m->quickness;
    m->current = first ? tuning->current : RETRY_CURRENT * m->current;
    m->needed = m->current;
    m->tracking = 0u;
    enter(m, MANOEUVRE_ALIGN);
    forced_enter(&m->forced, -0.5f * ANGLE_PI, 0.0f, 0.0f);
    return forced_demand(m, input, FRAME_ANEW);
}

/* Towards `wanted` [A], by no more than the rise. */
static void raise_current(manoeuvres_t *m, float wanted)
{
    m->forced.current += bounds_clamp(wanted - m->forced.current, m->limits.current_rise);
}

static demand_t align(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    frame_change_t change = FRAME_GOES_ON;
    raise_current(m, m->current);
    if (m->periods == m->limits.align_periods) {
        forced_enter(&m->forced, 0.0f, 0.0f, m->forced.current);
        change = FRAME_TURNS;
    } else if (m->periods >= 2u * m->limits.align_periods) {
        enter(m, MANOEUVRE_RAMP);
    }
    return forced_demand(m, input, change);
}

/* Does the rotor follow? Asked from fallback_speed on. */
static bool stalls(manoeuvres_t *m, const estimate_t *estimate)
{
    const float speed = bounds_magnitude(m->forced.frame.omega_e);
    const bool asked = speed >= m->limits.fallback_speed;
    const bool follows = estimate->amplitude >= STALL_SHARE * m->limits.flux_linkage * speed;
    m->stall_periods = asked && !follows ? m->stall_periods + 1u : 0u;
    return m->stall_periods >= STALL_PERIODS;
}

/* Whether the loop tracks beside the forced frame: it does where there is EMF enough. */
static void track_beside(manoeuvres_t *m, const estimate_t *estimate)
{
    const float speed = bounds_magnitude(m->forced.frame.omega_e);
    if (m->tracking == 0u && speed >= TRACK_SHARE * m->limits.handover_speed) {
        const float omega_e = m->forced.frame.omega_e;
        lock_to(m, (position_t){catch_angle(estimate->emf, omega_e), omega_e});
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

static demand_t force(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const float wanted = wanted_speed(m, &input->wish);
    const float target = bounds_clamp(wanted, limits->handover_speed);
    const dq_t seen = frames_park(input->current, input->estimate->frame.rotation);
    forced_speed(&m->forced, target, m->quickness * limits->ramp);
    name_forced(m, wanted);
    track_beside(m, input->estimate);
    see_need(m, seen.q);
    force_current(m);
    if (stalls(m, input->estimate)) {
        fail(m, MANOEUVRE_STALLED);
    } else if (m->now != (int32_t)MANOEUVRE_FORCED &&
               bounds_within(target - m->forced.frame.omega_e, REACHED_SHARE * limits->handover_speed)) {
        enter(m, MANOEUVRE_HANDOVER);
        handover_enter(&m->handover);
    }
    return forced_demand(m, input, FRAME_GOES_ON);
}

static demand_t hand_over(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const estimate_t *estimate = input->estimate;
    const dq_t seen = frames_park(input->current, estimate->frame.rotation);
    const float wanted = wanted_speed(m, &input->wish);
    lock_step(&m->lock, estimate);
    see_need(m, seen.q);
    m->forced.current = handover_current(&m->handover, m->forced.current, m->needed);
    switch (handover_step(&m->handover, estimate, &m->lock, m->forced.frame.omega_e, seen)) {
    case HANDOVER_GOES_ON:
        break;
    case HANDOVER_GOOD:
        enter_run(m, seen, estimate->omega_smooth);
        m->needed = bounds_magnitude(seen.q);
        demand_t demand = run_step(&m->run, &input->wish, &estimate->frame, m->run.omega_m_ref);
        demand.change = (int32_t)FRAME_TURNS;
        return demand;
    case HANDOVER_FAILED:
        fail(m, MANOEUVRE_UNLOCKED);
        return forced_demand(m, input, FRAME_GOES_ON);
    }
    if (stalls(m, estimate)) {
        fail(m, MANOEUVRE_STALLED);
    } else if (bounds_within(wanted, m->limits.handover_speed) || wanted * m->forced.frame.omega_e < 0.0f) {
        enter(m, MANOEUVRE_FORCED);
    }
    return forced_demand(m, input, FRAME_GOES_ON);
}

/* ---- catch ---- */

static demand_t catch_rotor(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const frame_change_t change = m->periods <= 1u ? FRAME_ANEW : FRAME_GOES_ON;
    demand_t demand = {stationary, (int32_t)change, {m->catching.tuning.current, 0.0f}, {0.0f, 0.0f}, 0.0f};
    if (!input->estimating) {
        return demand;
    }
    const estimate_t *estimate = input->estimate;
    const ab_t voltage = catch_voltage(&m->catching, estimate->emf);
    demand.emf = (dq_t){voltage.alpha, voltage.beta};
    switch (catch_step(&m->catching, estimate->emf, estimate->amplitude, input->voltage_max)) {
    case CATCH_GOES_ON:
        break;
    case CATCH_TURNING: {
        const position_t rotor = catch_position(&m->catching, estimate->emf);
        const frame_t frame = {rotor.theta_e, rotor.omega_e, trig_turn(rotor.theta_e)};
        enter_run(m, (dq_t){0.0f, 0.0f}, rotor.omega_e);
        lock_to(m, rotor);
        demand = run_step(&m->run, &input->wish, &frame, m->run.omega_m_ref);
        demand.change = (int32_t)FRAME_ANEW;
        break;
    }
    case CATCH_STANDING:
        return begin_start(m, input);
    case CATCH_TOO_FAST:
        m->failed |= MANOEUVRE_TOO_FAST;
        break;
    }
    return demand;
}

/* ---- run ---- */

/* The lock is lost: caught again, unless that has been done too often. */
static void lose(manoeuvres_t *m, float omega_e)
{
    if (m->lock_losses >= 2u && m->clock - m->loss_clock[1] < LOSS_PERIODS) {
        m->failed |= MANOEUVRE_LOST;
    }
    m->lock_losses++;
    m->loss_clock[1] = m->loss_clock[0];
    m->loss_clock[0] = m->clock;
    enter_catch(m, MANOEUVRE_RELOCK, CATCH_PERIODS, omega_e);
}

/* From the estimate's frame into a forced one in which the same torque acts: its d axis is ahead of the
 * rotor's by the load angle. The speed is the lesser of two that can both be wrong. */
static demand_t fall_back(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const estimate_t *estimate = input->estimate;
    const dq_t seen = frames_park(input->current, estimate->frame.rotation);
    m->current = m->forced.tuning.current;
    m->quickness = 1.0f;
    m->needed = bounds_magnitude(seen.q);
    const float sine = bounds_clamp(seen.q * m->forced.tuning.current_inverse, GRIP_MAX);
    const float square = 1.0f - sine * sine;
    const float ahead = trig_angle((rotation_t){sine, square * inverse_root(square)});
    const float emf_speed = estimate->amplitude * m->limits.speed_per_volt;
    const float omega_e = bounds_clamp(estimate->omega_smooth, emf_speed);
    enter(m, MANOEUVRE_FORCED);
    forced_enter(&m->forced, angle_turn_back(estimate->frame.theta_e + ahead), omega_e, m->current);
    m->tracking = 0u;
    return forced_demand(m, input, FRAME_TURNS);
}

/* Does run pass zero speed, or is asked for a speed that slow? Then neither loop nor lock is judged, and the
 * EMF may be gone for a while. */
static void watch_reversal(manoeuvres_t *m, float omega_ref, float omega)
{
    const float slow = m->limits.fallback_speed;
    if (omega_ref * omega < 0.0f || bounds_within(omega_ref, slow)) {
        m->reversing = 1u;
    } else if (!bounds_within(omega, PASSED_SHARE * slow) && m->reversing != 0u) {
        m->reversing = 0u;
        m->periods = 0u; /* the mask of a hand-over */
    }
}

/* In this frame of the rotor; the change from one source to another while running keeps the voltage. */
static demand_t run_by(manoeuvres_t *m, const manoeuvres_input_t *input, const frame_t *rotor)
{
    demand_t demand = run_step(&m->run, &input->wish, rotor, rotor->omega_e * m->limits.pole_pairs_inverse);
    if (m->other_source != 0u) {
        demand.change = (int32_t)FRAME_TURNS;
        m->other_source = 0u;
    }
    return demand;
}

static demand_t run(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const estimate_t *estimate = input->estimate;
    if (input->lost) {
        lose(m, estimate->omega_smooth);
        return catch_rotor(m, input);
    }
    const demand_t demand = run_by(m, input, &estimate->frame);
    const float omega_ref = demand.omega_m_ref * limits->pole_pairs;
    lock_step(&m->lock, estimate);
    watch_reversal(m, omega_ref, estimate->omega_smooth);
    m->unlocked = lock_is_lost(&m->lock, estimate->omega_smooth, omega_ref);
    m->sound_periods++;
    if (m->sound_periods >= SOUND_PERIODS) {
        m->start_try = 0u;
    }

    const bool stays = bounds_within(wanted_speed(m, &input->wish), limits->fallback_speed);
    const bool slow = estimate->amplitude < limits->flux_linkage * limits->fallback_speed;
    m->slow_periods = slow && m->reversing != 0u ? m->slow_periods + 1u : 0u;
    return m->slow_periods >= (stays ? SLOW_PERIODS : limits->fallback_periods) ? fall_back(m, input)
                                                                                : demand;
}

/* With the encoder there is nothing else; out of another manoeuvre it takes the current along. */
static demand_t run_on_encoder(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    if (m->now != (int32_t)MANOEUVRE_RUN) {
        enter_run(m, frames_park(input->current, input->encoder.rotation), input->encoder.omega_e);
    }
    return run_by(m, input, &input->encoder);
}

demand_t manoeuvres_step(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    m->clock++;
    m->periods++;
    m->locking = 0u;
    if (m->limits.sensorless == 0u) {
        return run_on_encoder(m, input);
    }
    switch ((manoeuvre_t)m->now) {
    case MANOEUVRE_OFF:
    case MANOEUVRE_CATCH:
    case MANOEUVRE_RELOCK:
        break;
    case MANOEUVRE_ALIGN:
        return align(m, input);
    case MANOEUVRE_RAMP:
    case MANOEUVRE_FORCED:
    case MANOEUVRE_REVERSE:
        return force(m, input);
    case MANOEUVRE_HANDOVER:
        return hand_over(m, input);
    case MANOEUVRE_RUN:
        return run(m, input);
    }
    return catch_rotor(m, input);
}
