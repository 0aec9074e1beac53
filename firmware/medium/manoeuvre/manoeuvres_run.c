/* The manoeuvres in the rotor's frame and the one that finds the rotor: catch, relock, run. */
#include "medium/manoeuvre/manoeuvres_parts.h"

#include "math/bounds.h"
#include "math/trig.h"

#define LOSS_WINDOWS  DRIVE_WINDOWS(2.0f)  /* time within which the third loss is a fault */
#define SLOW_PERIODS  DRIVE_PERIODS(5e-3f) /* below fallback_speed when the reference is, too */
#define SOUND_WINDOWS DRIVE_WINDOWS(0.5f)  /* of run, after which a start counts as successful */
#define RELOCKS       10u   /* [-] largest number of catches after one loss without a proved lock */
#define LOCKED_ASIDE  0.3f  /* [-] of the EMF along the q axis: 17 degrees */
#define LOCKED_LENGTH 0.3f  /* [-] of psi_f omega: largest error of the EMF */
#define PASSED_SHARE  1.67f /* [-] of fallback_speed, at which a reversal has passed zero */

/* The current along the d axis of a rotor whose lock is not proved: it makes no torque, and keeps the
 * legs out of the dead time's zone. */
static inline dq_t without_torque(const manoeuvres_t *m)
{
    return (dq_t){m->limits.current_caught, 0.0f};
}

/* The rotor turns, and the fast task has locked the loop to it. After a first catch run begins, unless the
 * rotor is slower than at a hand-over: its load may have turned it round during the catch. Such a rotor and
 * one that was lost are proved first. */
static void caught(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const float omega_e = input->estimate->omega_smooth;
    m->tracking = 1u;
    lock_reset(&m->lock, omega_e);
    if (m->now == (int32_t)MANOEUVRE_RELOCK || bounds_within(omega_e, m->limits.handover_speed)) {
        proof_enter(&m->proof);
        return;
    }
    manoeuvres_enter_run(m, without_torque(m), omega_e);
    m->reversing = omega_e * manoeuvres_wanted(m, &input->wish) < 0.0f;
    manoeuvres_run_at(m, input, omega_e, m->run.omega_m_ref, setpoint);
}

/* The loop agrees with its EMF: run begins. A rotor that turns against the
 * reference keeps its speed first. A rotor that is slower than at a hand-over continues in the forced frame,
 * which accelerates it to this speed: in run the angle would be wrong because of the dead time. */
static void proved(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const float omega_e = input->estimate->omega_smooth;
    const bool against = omega_e * manoeuvres_wanted(m, &input->wish) < 0.0f;
    const bool speed = input->wish.mode == RUN_SPEED && m->now == (int32_t)MANOEUVRE_RELOCK;
    if (speed && bounds_within(omega_e, m->limits.handover_speed)) {
        m->run.omega_m_ref = omega_e * m->limits.pole_pairs_inverse;
        manoeuvres_fall_back(m, input, setpoint);
        return;
    }
    manoeuvres_enter_run(m, without_torque(m), omega_e);
    m->windows = MANOEUVRE_MASKED; /* the judgement starts with the next window */
    m->reversing = against && !speed;
    m->proving = against && speed ? MANOEUVRE_PROVING : 0u;
    m->omega_m_proved = m->run.omega_m_ref;
    manoeuvres_run_at(m, input, omega_e, m->run.omega_m_ref, setpoint);
}

/* A relock whose loop is locked. If the loop does not agree with its EMF, the rotor is caught again. This
 * does not count as another loss, because there was no torque yet, unless it happens too often. */
static void prove_lock(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    switch (proof_step(&m->proof, input->estimate)) {
    case PROOF_GOOD:
        proved(m, input, setpoint);
        break;
    case PROOF_FAILED:
        m->losses.relocks++;
        if (m->losses.relocks >= RELOCKS) {
            m->failed |= MANOEUVRE_LOST;
        }
        manoeuvres_enter_catch(m, (manoeuvre_t)m->now, MANOEUVRE_CATCH_PERIODS, input->estimate->omega_smooth,
                               setpoint);
        break;
    case PROOF_GOES_ON:
    default:
        break;
    }
}

/* True if the fast task has begun the catch that was ordered last. */
static inline bool has_begun(const manoeuvres_t *m, const manoeuvres_input_t *input)
{
    return (int32_t)(input->setpoint - m->entered) >= 0;
}

void manoeuvres_catch(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    if (m->tracking != 0u) {
        prove_lock(m, input, setpoint);
        return;
    }
    if (!has_begun(m, input)) {
        return;
    }
    switch ((catch_outcome_t)input->outcome) {
    case CATCH_GOES_ON:
        break;
    case CATCH_TURNING:
        caught(m, input, setpoint);
        break;
    case CATCH_STANDING:
        manoeuvres_begin_start(m, input, setpoint);
        break;
    case CATCH_TOO_FAST:
        m->failed |= MANOEUVRE_TOO_FAST;
        break;
    }
}

/* The speed with which the catch of a lost rotor begins [rad/s]: that of the loop, unless the EMF denies it.
 */
static float lost_speed(const estimate_t *estimate)
{
    return estimate_is_denied(estimate) ? 0.0f : estimate->omega_smooth;
}

/* The lock is lost: the rotor is caught again, unless the limit of losses is reached, or no start has led to
 * a run that lasted. A run that did not last counts as a try: with a wrong current sensor a relock, a
 * hand-over and a short run would otherwise repeat without end, too slowly for the limit of losses. */
static void lose(manoeuvres_t *m, const estimate_t *estimate, setpoint_t *setpoint)
{
    const bool often = m->losses.count >= 2u && m->clock - m->losses.clock[1] < LOSS_WINDOWS;
    const uint32_t tries = m->limits.start_tries;
    m->losses.brief = m->sound_windows < SOUND_WINDOWS ? m->losses.brief + 1u : 0u;
    if (often || m->losses.brief >= tries || m->start_try >= tries) {
        m->failed |= MANOEUVRE_LOST;
    }
    m->losses.count++;
    m->losses.relocks = 0u;
    m->run.swings = 1u;
    m->losses.clock[1] = m->losses.clock[0];
    m->losses.clock[0] = m->clock;
    manoeuvres_enter_catch(m, MANOEUVRE_RELOCK, MANOEUVRE_CATCH_PERIODS, lost_speed(estimate), setpoint);
}

/* True if the present EMF is that of a rotor with the speed of the loop. The mean of the lock is not enough
 * in a reversal: for some milliseconds it still contains the EMF of the old direction. */
static bool has_emf(const estimate_t *estimate)
{
    const float along = estimate->omega_smooth < 0.0f ? -estimate->emf_loop.q : estimate->emf_loop.q;
    return along >= LOCK_PROJECTION_MIN * estimate->flux * bounds_magnitude(estimate->omega_smooth);
}

/* Detects a requested reversal through zero speed and a reference that is too slow to track. In both cases
 * neither loop nor lock is judged where the EMF is small, and the EMF may be missing for a while. The speed
 * of the loop alone does not show that the rotor has passed zero: beside a rotor that a load holds, the
 * errors of R and of the dead time may accelerate the loop in the direction of the reference. Nor does an EMF
 * beside a scattered loop. */
static void watch_reversal(manoeuvres_t *m, float omega_ref, const estimate_t *estimate)
{
    const float slow = m->limits.fallback_speed;
    const float omega = estimate->omega_smooth;
    if (omega_ref * m->omega_ref < 0.0f || bounds_within(omega_ref, slow)) {
        m->reversing = 1u;
    } else if (m->reversing != 0u && omega_ref * omega > 0.0f && !bounds_within(omega, PASSED_SHARE * slow) &&
               !lock_is_off(&m->lock) && !lock_is_scattered(&m->lock) && has_emf(estimate)) {
        m->reversing = 0u;
        m->windows = 0u; /* the masking time of a hand-over */
    }
    m->omega_ref = omega_ref;
}

/* True if the speed is behind that of a passage that ends in time: with the mean acceleration since the EMF
 * began to be missing, from w_0 to w in t, it does not reach fallback_speed w_f within t_most if
 * w < w_0 + (w_f - w_0) t/t_most. It is judged from half of t_most on, when w must also have changed its
 * sign: before, a small error of w_0 decides. */
static bool is_late(const manoeuvres_t *m, float toward)
{
    const float most = (float)(int32_t)m->limits.fallback_periods;
    const float time = (float)(int32_t)m->passage.missing;
    const float gained = (toward - m->passage.began) * most;
    return 2.0f * time >= most &&
           (toward < 0.0f || gained < (m->limits.fallback_speed - m->passage.began) * time);
}

/* True if the EMF was missing for longer than a reversal may take, or if the loop is late. A shorter time is
 * the limit for a reference that is too slow to track, for a loop whose speed should make an EMF, and for a
 * loop that does not settle. The mean along the axis is judged, because noise has a length, too. While the
 * loop coasts the EMF is old and is not judged. Below the speed from which on the lock is judged, an EMF is
 * no proof of the angle: a loop that has had enough time and does not settle counts as a loop without EMF. So
 * does a scattered loop whose EMF is smaller than at the hand-over or was missing, because the error of the
 * loop makes an EMF itself. */
static bool is_too_slow(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const float slow = limits->fallback_speed;
    const bool late = m->judged == 0u && m->windows > MANOEUVRE_STEADY;
    const bool small = m->lock.projection < limits->flux_linkage * limits->handover_speed;
    const bool unsettled = (late || small || m->passage.missing != 0u) && lock_is_scattered(&m->lock);
    const bool seen = m->lock.projection >= limits->flux_linkage * slow && !unsettled;
    if (m->reversing == 0u || seen) {
        m->passage.missing = 0u;
        return false;
    }
    const float omega = input->estimate->omega_smooth;
    const float toward = m->omega_ref < 0.0f ? -omega : omega;
    m->passage.began = m->passage.missing != 0u ? m->passage.began : toward < 0.0f ? toward : 0.0f;
    m->passage.missing += input->tracked;
    const bool stays = bounds_within(manoeuvres_wanted(m, &input->wish), slow);
    const bool astray = lock_is_scattered(&m->lock) || (!bounds_within(omega, slow) && lock_is_off(&m->lock));
    return m->passage.missing >= (stays || astray ? SLOW_PERIODS : limits->fallback_periods) ||
           is_late(m, toward);
}

bool manoeuvres_is_locked(const manoeuvres_t *m, const estimate_t *estimate)
{
    const dq_t emf = estimate->emf_loop;
    const float along = estimate->omega_smooth < 0.0f ? -emf.q : emf.q;
    const float expected = estimate->flux * bounds_magnitude(estimate->omega_smooth);
    return !bounds_within(estimate->omega_smooth, m->limits.handover_speed) &&
           bounds_within(emf.d, LOCKED_ASIDE * along) &&
           bounds_within(along - expected, LOCKED_LENGTH * expected);
}

/* position_source has changed while running, and nothing shows that the loop, which tracked beside the
 * encoder, follows the rotor: the loop is locked to the angle of the encoder. */
static void lock_to_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const float omega_e = input->encoder.omega_e;
    setpoint->lock = (int32_t)LOCK_TO_ENCODER;
    m->windows = 0u;
    m->passage.missing = 0u;
    m->reversing = bounds_within(omega_e, m->limits.fallback_speed);
    m->omega_ref = omega_e;
    lock_reset(&m->lock, omega_e);
    manoeuvres_run_at(m, input, omega_e, omega_e * m->limits.pole_pairs_inverse, setpoint);
}

/* Mean square of the detector in the periods in which the loop tracked; without one, the present mean. If the
 * zeros of the other periods counted, a loop that coasts for most of the time would seem to settle at any
 * angle. */
static float scatter_of(const manoeuvres_t *m, const manoeuvres_input_t *input)
{
    return input->tracked != 0u ? (float)DRIVE_WINDOW / (float)input->tracked * input->scatter
                                : m->lock.scatter;
}

static void run(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const estimate_t *estimate = input->estimate;
    if (input->losses != 0u) {
        lose(m, estimate, setpoint);
        return;
    }
    if (m->other_source != 0u && m->encoder_lost == 0u && !manoeuvres_is_locked(m, estimate)) {
        lock_to_encoder(m, input, setpoint);
        return;
    }
    manoeuvres_run_at(m, input, estimate->frame.omega_e, input->omega_m, setpoint);
    const float omega_ref = setpoint->omega_m_ref * limits->pole_pairs;
    lock_step(&m->lock, estimate, scatter_of(m, input), omega_ref, m->run.limited != 0u);
    watch_reversal(m, omega_ref, estimate);
    manoeuvres_judge(m, estimate->amplitude, estimate->omega_smooth);
    m->unlocked = limits->judging != 0u && lock_is_lost(&m->lock, m->windows > MANOEUVRE_STEADY);
    m->sound_windows++;
    if (m->sound_windows >= SOUND_WINDOWS) {
        m->start_try = 0u;
    }
    if (is_too_slow(m, input)) {
        manoeuvres_fall_back(m, input, setpoint);
    }
}

/* A rotor that was caught again while turning against the reference keeps its speed until its lock is judged.
 * After two losses the closed loop only brakes it to the hand-over speed, and the forced frame reverses it.
 * At a higher speed the step of the frame's angle would disturb the observer (docs/theory.md, 23.1). */
static void prove(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    manoeuvres_input_t kept = *input;
    const bool against = input->wish.mode == RUN_SPEED && input->wish.omega_m_ref * m->omega_m_proved < 0.0f;
    if (!against || (m->proving == MANOEUVRE_PROVED && m->losses.count < 2u)) {
        m->proving = 0u; /* the reference has changed, or the rotor may be reversed */
    } else if (m->proving > MANOEUVRE_PROVED) {
        m->proving--;
        kept.wish = (run_wish_t){RUN_SPEED, m->omega_m_proved, {0.0f, 0.0f}, 0.0f};
    }
    run(m, &kept, setpoint);
    if (m->proving == MANOEUVRE_PROVED && m->losses.count >= 2u && m->now == (int32_t)MANOEUVRE_RUN &&
        bounds_within(input->estimate->omega_smooth, m->limits.handover_speed)) {
        manoeuvres_fall_back(m, input, setpoint);
    }
}

void manoeuvres_run(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    if (m->proving != 0u) {
        prove(m, input, setpoint);
    } else {
        run(m, input, setpoint);
    }
}

void manoeuvres_left_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, bool to_estimate,
                             setpoint_t *setpoint)
{
    const estimate_t *estimate = input->estimate;
    m->encoder_lost = 1u;
    m->sensorless = 1u;
    run_keep_low(&m->run, true);
    if (to_estimate) {
        manoeuvres_enter_run(m, input->current, estimate->omega_smooth);
        m->windows = MANOEUVRE_MASKED; /* the judgement starts with the next window */
    } else {
        manoeuvres_enter(m, MANOEUVRE_RELOCK);
        m->tracking = 0u;
        m->entered = input->setpoint;
        setpoint->source = (int32_t)SOURCE_CATCH;
        setpoint->current = without_torque(m);
        setpoint->omega_m_ref = 0.0f;
    }
}

void manoeuvres_leave_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const bool locked = manoeuvres_is_locked(m, input->estimate);
    manoeuvres_left_encoder(m, input, locked, setpoint);
    if (locked) {
        m->other_source = 1u;
    } else {
        manoeuvres_enter_catch(m, MANOEUVRE_RELOCK, MANOEUVRE_CATCH_PERIODS, input->estimate->omega_smooth,
                               setpoint);
    }
}

/* With the encoder run is the only manoeuvre; the current of another manoeuvre is taken over. */
void manoeuvres_run_on_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    if (m->now != (int32_t)MANOEUVRE_RUN) {
        manoeuvres_enter_run(m, frames_park(input->sample, trig_turn(input->encoder.theta_e)),
                             input->encoder.omega_e);
        m->other_source = 1u;
    }
    manoeuvres_run_at(m, input, input->encoder.omega_e, input->omega_m, setpoint);
}
