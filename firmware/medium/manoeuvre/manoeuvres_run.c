/* The manoeuvres in the frame of the rotor, and what follows the catch that finds it: catch, relock, run. */
#include "medium/manoeuvre/manoeuvres_parts.h"

#include "math/bounds.h"
#include "math/trig.h"

#define LOSS_WINDOWS  DRIVE_WINDOWS(2.0f)  /* in which three losses are one too many */
#define SLOW_PERIODS  DRIVE_PERIODS(5e-3f) /* below fallback_speed when that is asked for */
#define SOUND_WINDOWS DRIVE_WINDOWS(0.5f)  /* of run, after which a start counts as done */
#define RELOCKS       10u                  /* [-] catches after one loss, none of which could be proved */
#define LOCKED_ASIDE  0.3f                 /* [-] of the EMF along the q axis: 17 degrees */
#define LOCKED_LENGTH 0.3f                 /* [-] of psi_f omega, that the EMF may be off */
#define PASSED_SHARE  1.67f                /* [-] of fallback_speed, at which a reversal has passed zero */

/* The current along the d axis of a rotor whose lock is not proved: it makes no torque, and keeps the legs
 * out of the dead time's zone. */
static inline dq_t without_torque(const manoeuvres_t *m)
{
    return (dq_t){m->limits.current_caught, 0.0f};
}

/* The rotor turns, and the fast task has locked the loop to it. At first sight it runs; a rotor that was lost
 * is proved before. */
static void caught(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const float omega_e = input->estimate->omega_smooth;
    m->tracking = 1u;
    lock_reset(&m->lock, omega_e);
    if (m->now == (int32_t)MANOEUVRE_RELOCK) {
        proof_enter(&m->proof);
        return;
    }
    manoeuvres_enter_run(m, without_torque(m), omega_e);
    m->reversing = omega_e * manoeuvres_wanted(m, &input->wish) < 0.0f;
    manoeuvres_run_at(m, input, omega_e, m->run.omega_m_ref, setpoint);
}

/* The loop agrees with its EMF: run from here on. A rotor that turns against the wish keeps its speed first.
 */
static void proved(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const float omega_e = input->estimate->omega_smooth;
    const bool against = omega_e * manoeuvres_wanted(m, &input->wish) < 0.0f;
    const bool speed = input->wish.mode == RUN_SPEED;
    manoeuvres_enter_run(m, without_torque(m), omega_e);
    m->windows = MANOEUVRE_MASKED; /* judged from the next window on */
    m->reversing = against && !speed;
    m->proving = against && speed ? MANOEUVRE_PROVING : 0u;
    m->omega_m_proved = m->run.omega_m_ref;
    manoeuvres_run_at(m, input, omega_e, m->run.omega_m_ref, setpoint);
}

/* A relock whose loop is locked. One that does not agree with its EMF is caught again: it has had no torque,
 * and is no loss of its own, until that has been so too often. */
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
        manoeuvres_enter_catch(m, MANOEUVRE_RELOCK, MANOEUVRE_CATCH_PERIODS, input->estimate->omega_smooth,
                               setpoint);
        break;
    case PROOF_GOES_ON:
    default:
        break;
    }
}

/* Has the fast task begun the catch that was ordered last? */
static inline bool has_begun(const manoeuvres_t *m, const manoeuvres_input_t *input)
{
    return (int32_t)(input->setpoint - m->entered) >= 0;
}

void manoeuvres_catch(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    if (m->now == (int32_t)MANOEUVRE_RELOCK && m->tracking != 0u) {
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

/* The lock is lost: caught again, unless that has been done too often, or no start has led to a run that
 * lasted. */
static void lose(manoeuvres_t *m, float omega_e, setpoint_t *setpoint)
{
    const bool often = m->losses.count >= 2u && m->clock - m->losses.clock[1] < LOSS_WINDOWS;
    if (often || m->start_try >= m->limits.start_tries) {
        m->failed |= MANOEUVRE_LOST;
    }
    m->losses.count++;
    m->losses.relocks = 0u;
    m->losses.clock[1] = m->losses.clock[0];
    m->losses.clock[0] = m->clock;
    manoeuvres_enter_catch(m, MANOEUVRE_RELOCK, MANOEUVRE_CATCH_PERIODS, omega_e, setpoint);
}

/* Does run pass zero speed because it was told to, or is asked for a speed that slow? Then neither loop nor
 * lock is judged where the EMF says little, and it may be gone for a while. */
static void watch_reversal(manoeuvres_t *m, float omega_ref, float omega)
{
    const float slow = m->limits.fallback_speed;
    if (omega_ref * m->omega_ref < 0.0f || bounds_within(omega_ref, slow)) {
        m->reversing = 1u;
    } else if (m->reversing != 0u && omega_ref * omega > 0.0f && !bounds_within(omega, PASSED_SHARE * slow)) {
        m->reversing = 0u;
        m->windows = 0u; /* the mask of a hand-over */
    }
    m->omega_ref = omega_ref;
}

/* Was the EMF gone for longer than a reversal may take, or half of that without a change of direction, or at
 * a wish that is too slow to track, or while the loop has a speed at which there is one, or does not settle?
 * It is the mean along the axis that tells: noise has a length, too. While the loop coasts it is old and says
 * nothing. */
static bool is_too_slow(manoeuvres_t *m, const manoeuvres_input_t *input)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const float slow = limits->fallback_speed;
    if (m->reversing == 0u || m->lock.projection >= limits->flux_linkage * slow) {
        m->slow_periods = 0u;
        return false;
    }
    m->slow_periods += input->tracked;
    const bool stays = bounds_within(manoeuvres_wanted(m, &input->wish), slow);
    const bool astray = lock_is_scattered(&m->lock) ||
                        (!bounds_within(input->estimate->omega_smooth, slow) && lock_is_off(&m->lock));
    const bool lags = input->estimate->omega_smooth * m->omega_ref < 0.0f;
    const uint32_t most = lags ? limits->fallback_periods / 2u : limits->fallback_periods;
    return m->slow_periods >= (stays || astray ? SLOW_PERIODS : most);
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

/* position_source has changed under way, and nothing says that the loop, which tracked beside the encoder, is
 * on the rotor: it is locked to where the encoder has it. */
static void lock_to_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const float omega_e = input->encoder.omega_e;
    setpoint->lock = (int32_t)LOCK_TO_ENCODER;
    m->windows = 0u;
    m->slow_periods = 0u;
    m->reversing = bounds_within(omega_e, m->limits.fallback_speed);
    m->omega_ref = omega_e;
    lock_reset(&m->lock, omega_e);
    manoeuvres_run_at(m, input, omega_e, omega_e * m->limits.pole_pairs_inverse, setpoint);
}

static void run(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    const manoeuvres_limits_t *limits = &m->limits;
    const estimate_t *estimate = input->estimate;
    if (input->losses != 0u) {
        lose(m, estimate->omega_smooth, setpoint);
        return;
    }
    if (m->other_source != 0u && m->encoder_lost == 0u && !manoeuvres_is_locked(m, estimate)) {
        lock_to_encoder(m, input, setpoint);
        return;
    }
    manoeuvres_run_at(m, input, estimate->frame.omega_e, input->omega_m, setpoint);
    const float omega_ref = setpoint->omega_m_ref * limits->pole_pairs;
    lock_step(&m->lock, estimate, input->scatter);
    watch_reversal(m, omega_ref, estimate->omega_smooth);
    manoeuvres_judge(m, estimate->amplitude, estimate->omega_smooth);
    m->unlocked = limits->judging != 0u &&
                  lock_is_lost(&m->lock, estimate->omega_smooth, omega_ref, m->windows > MANOEUVRE_STEADY);
    m->sound_windows++;
    if (m->sound_windows >= SOUND_WINDOWS) {
        m->start_try = 0u;
    }
    if (is_too_slow(m, input)) {
        manoeuvres_fall_back(m, input, setpoint);
    }
}

/* A rotor that was caught again against the wish keeps its speed until its lock is judged. One that has been
 * lost twice is not reversed by a closed loop then, but in the forced frame. */
static void prove(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    manoeuvres_input_t kept = *input;
    m->proving--;
    if (input->wish.mode != RUN_SPEED || input->wish.omega_m_ref * m->omega_m_proved >= 0.0f) {
        m->proving = 0u; /* the wish has changed */
        run(m, input, setpoint);
        return;
    }
    kept.wish = (run_wish_t){RUN_SPEED, m->omega_m_proved, {0.0f, 0.0f}, 0.0f};
    run(m, &kept, setpoint);
    if (m->proving == 0u && m->losses.count >= 2u && m->now == (int32_t)MANOEUVRE_RUN) {
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
        m->windows = MANOEUVRE_MASKED; /* judged from the next window on */
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

/* With the encoder there is nothing else; out of another manoeuvre it takes the current along. */
void manoeuvres_run_on_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    if (m->now != (int32_t)MANOEUVRE_RUN) {
        manoeuvres_enter_run(m, frames_park(input->sample, trig_turn(input->encoder.theta_e)),
                             input->encoder.omega_e);
        m->other_source = 1u;
    }
    manoeuvres_run_at(m, input, input->encoder.omega_e, input->omega_m, setpoint);
}
