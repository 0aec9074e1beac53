/* The protections that need more than single samples, and the current limit that follows from them. */
#include "medium/medium_parts.h"

#include "fast/protect/still_watch.h"
#include "math/bounds.h"
#include "math/trig.h"
#include "settings/reasons.h"

/* [-] uncertain share of the EMF: psi_f by 20 % and the rotor's angle; if the angle is
 * unknown, all of it in every direction. */
#define EMF_KNOWN   0.3f
#define EMF_UNKNOWN 1.3f

/* ---- current sensors and wires ---- */

/* True if the current of this window can be compared with the law of the winding. */
static bool is_comparable(const manoeuvres_t *m, const window_t *window)
{
    switch ((manoeuvre_compared_t)manoeuvres_row(m)->compared) {
    case COMPARED_ALWAYS:
        return true;
    case COMPARED_STANDING:
        return window->catching.seen.turning == 0u;
    case COMPARED_UNTRACKED:
        return m->tracking == 0u && m->windows >= 1u;
    case COMPARED_NEVER:
        break;
    }
    return false;
}

/* True if a forced frame takes along a rotor that is aligned with it. */
static bool is_taken_along(const manoeuvres_t *m)
{
    return manoeuvres_row(m)->source == (int32_t)SOURCE_FORCED && m->now != (int32_t)MANOEUVRE_ALIGN;
}

void medium_watch_currents(medium_t *medium, const window_t *window)
{
    current_watch_t *watch = &medium->current_watch;
    const manoeuvres_t *m = &medium->manoeuvres;
    const bool excited = m->now == (int32_t)MANOEUVRE_COMMISSION; /* its reference is not that of control */
    if (window->estimating == 0u || watch->tuning.judged == 0u || excited) {
        medium->found.current_faults = 0u;
        return;
    }
    const bool known = m->sensorless == 0u || m->tracking != 0u;
    const float omega_e = m->limits.pole_pairs * window->omega_m;
    const current_watch_input_t input = {
        .periods = window->sum.periods,
        .voltage = window->sum.voltage,
        .asked_for = window->sum.reference,
        .moved = still_watch_moved(window->sensors.still, DRIVE_WINDOW),
        .current = window->measured.current_abc,
        .error = window->current_err,
        .reference = window->reference,
        .frame = window->frame.rotation,
        .u_dc = window->measured.u_dc,
        .rotor = window->rotor.rotation,
        .omega_e = known ? omega_e : 0.0f,
        .doubt = (known ? EMF_KNOWN : EMF_UNKNOWN) * bounds_magnitude(omega_e),
        .forced = !known && is_taken_along(m),
        .contradicted = medium->encoder_watch.of_a_phase != 0u,
        .elsewhere = medium->encoder_watch.elsewhere != 0u,
        .limited = window->sum.limited != 0u,
        .comparable = is_comparable(m, window),
        .noise = window->sensors.noise,
    };
    medium->found.current_faults = current_watch_step(watch, &input);
}

/* ---- encoder and shaft ---- */

/* True if the encoder is judged: control uses it, and the EMF is known. */
static bool judges_encoder(const medium_t *medium, const window_t *window)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    return m->sensorless == 0u && m->limits.encoder_fault != (int32_t)ENCODER_FAULT_IGNORED &&
           window->estimating != 0u;
}

static uint32_t watch_shaft(medium_t *medium, const window_t *window, const requests_t *requests)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    const motion_watch_input_t input = {
        .i_q = run_torque(&m->run) * window->current.q, /* as a current of psi_f */
        .i_q_ref = window->reference.q,
        .limit = run_room(&m->run),
        .omega_m = window->omega_m,
        .omega_m_ref = window->omega_m_ref,
        .measured = m->sensorless == 0u,
        .confirmed = medium->encoder_watch.confirmed != 0u,
        .running = m->windows,
        .asked = requests->mode == (int32_t)MODE_SPEED || medium->sequence.state == (int32_t)DRIVE_QUICK_STOP,
    };
    return motion_watch_step(&medium->motion_watch, &input);
}

/* True if the EMF may be wrong because of a wire or a current sensor. The current watch reports these first;
 * it needs more time than a large EMF off the encoder's axis, and its result has priority. A sensor that is
 * only suspected does not count: the current watch expects the EMF at the encoder's angle. */
static bool doubts_emf(const medium_t *medium, const window_t *window, ab_t asked)
{
    if ((medium->found.current_faults & ~CURRENT_WATCH_MAYBE) != 0u) {
        return true;
    }
    return current_watch_lacks(&medium->current_watch, window->measured.current_abc,
                               frames_inverse_clarke(asked));
}

/* If the speed loop begins to oscillate, the speed contains the proportional part of the tracking loop from
 * then on, without which it lags. A loop that oscillates is also made slower. In mode current the speed is
 * not controlled. */
static void watch_oscillation(medium_t *medium, const window_t *window, const requests_t *requests)
{
    oscillation_watch_t *watch = &medium->speed.oscillation;
    if (requests->mode != (int32_t)MODE_SPEED) {
        oscillation_watch_rest(watch);
        return;
    }
    const oscillation_t found = oscillation_watch_step(watch, window->reference.q, window->omega_m_ref);
    manoeuvres_t *m = &medium->manoeuvres;
    const bool lags = m->sensorless != 0u && m->limits.smooth != 0u && m->run.swings == 0u;
    if (found == OSCILLATION_CERTAIN && !lags) {
        run_calm(&m->run, false);
    }
    if (found != OSCILLATION_NONE) {
        m->run.swings = 1u;
    }
}

/* The drive continues without the encoder: the watches of the encoder are reset. */
static void forget_encoder(medium_t *medium)
{
    encoder_watch_rest(&medium->encoder_watch);
    motion_watch_rest(&medium->motion_watch);
    current_watch_begin(&medium->current_watch);
    medium->found.encoder_wrong = 0u;
}

static void rest(medium_t *medium)
{
    encoder_watch_forget(&medium->encoder_watch);
    motion_watch_rest(&medium->motion_watch);
    oscillation_watch_rest(&medium->speed.oscillation);
    medium->found.moves_wrong = 0u;
}

void medium_watch_motion(medium_t *medium, const window_t *window, const requests_t *requests)
{
    manoeuvres_t *m = &medium->manoeuvres;
    const run_wish_t none = {RUN_ZERO, 0.0f, {0.0f, 0.0f}, 0.0f};
    medium->found.encoder_wrong = 0u;
    encoder_watch_add(&medium->encoder_watch, window->sum.voltage);
    if (!sequence_bridge_on(&medium->sequence) || medium->sequence.state == (int32_t)DRIVE_SWITCHED_ON ||
        m->now != (int32_t)MANOEUVRE_RUN) { /* the shaft is not driven */
        rest(medium);
        encoder_watch_begin(&medium->encoder_watch, window->measured.current);
        return;
    }
    if (window->report.left != (int32_t)JUMP_IGNORED) {
        const manoeuvres_input_t input = medium_manoeuvres_input(medium, window, none);
        manoeuvres_left_encoder(m, &input, window->report.left == (int32_t)JUMP_TO_ESTIMATE,
                                &medium->setpoint);
        forget_encoder(medium);
    }
    watch_oscillation(medium, window, requests);
    medium->found.moves_wrong = watch_shaft(medium, window, requests);
    if (!judges_encoder(medium, window)) {
        encoder_watch_rest(&medium->encoder_watch);
        encoder_watch_begin(&medium->encoder_watch, window->measured.current);
        return;
    }
    const ab_t current = window->measured.current;
    const ab_t asked = frames_inverse_park(window->reference, window->frame.rotation);
    const rotation_t encoder = trig_turn(window->encoder.theta_e);
    const encoder_watch_input_t input = {
        .current = current,
        .encoder = encoder,
        .omega_e = window->encoder.omega_e,
        .emf = window->estimate.emf,
        .lacks = {asked.alpha - current.alpha, asked.beta - current.beta},
        .excess = run_excess(&m->run, frames_park(current, encoder).q),
        .doubtful = doubts_emf(medium, window, asked),
    };
    medium->found.encoder_wrong = encoder_watch_step(&medium->encoder_watch, &input);
    if ((medium->found.encoder_wrong & ENCODER_WATCH_WIRE) != 0u) {
        medium->found.current_faults |= CURRENT_WATCH_LOSS;
    }
    if ((medium->found.encoder_wrong & ENCODER_WATCH_MISMATCH) != 0u &&
        m->limits.encoder_fault == (int32_t)ENCODER_FAULT_SENSORLESS) {
        const manoeuvres_input_t now = medium_manoeuvres_input(medium, window, none);
        manoeuvres_leave_encoder(m, &now, &medium->setpoint);
        forget_encoder(medium);
    }
}

/* ---- heat, supply and DC link ---- */

/* Power that the winding takes in the last period of the window [W]. */
static float power_of(const window_t *window)
{
    return window->estimating == 0u
               ? 0.0f
               : 1.5f * (window->voltage.d * window->current.d + window->voltage.q * window->current.q);
}

/* Limits of i_q by the current of the supply. */
static void limit_supply(medium_t *medium, const supply_limit_tuning_t *tuning, const window_t *window)
{
    const manoeuvres_t *m = &medium->manoeuvres;
    const abc_t current = window->measured.current_abc;
    const bool rotor = m->sensorless == 0u || m->tracking != 0u;
    const bool excited = m->now == (int32_t)MANOEUVRE_COMMISSION; /* its voltage is not that of control */
    const supply_limit_input_t input = {
        .u_dc = window->measured.u_dc,
        .power = power_of(window),
        .magnitudes = bounds_magnitude(current.a) + bounds_magnitude(current.b) + bounds_magnitude(current.c),
        .i_q = window->current.q,
        .torque_share = run_torque(&m->run),
        .omega_m = window->omega_m,
        .conducting = excited ? 0u : window->estimating,
        .in_rotor = rotor ? UINT32_C(1) : UINT32_C(0),
    };
    supply_limit_step(&medium->link.supply, tuning, &input);
}

/* Within ride_through_time a falling link voltage opens the bridge, which is switched on again when the
 * supply is back: the rotor is caught. After that time the undervoltage is a fault. */
static void ride_through(medium_t *medium, const window_t *window, const requests_t *requests)
{
    const uint32_t conditions = medium->link.watch.conditions;
    if (sequence_bridge_on(&medium->sequence)) {
        medium->found.coasting = (conditions & LINK_SINKS) != 0u ? UINT32_C(1) : UINT32_C(0);
        if (medium->found.coasting != 0u) {
            sequence_coast(&medium->sequence);
        }
    } else if (requests->enable == (int32_t)REQUEST_OFF) {
        medium->found.coasting = 0u;
    } else if (medium->found.coasting != 0u && (conditions & LINK_LOST) != 0u) {
        medium->found.coasting = 0u;
        medium_stop(medium, window, medium_seen_in(window, REASON_DC_UNDERVOLTAGE));
    }
}

void medium_limit(medium_t *medium, const medium_tuning_t *tuning, const window_t *window,
                  const requests_t *requests)
{
    thermal_add(&medium->thermal, window->measured.current_abc);
    if (thermal_is_due(&medium->thermal)) {
        thermal_step(&medium->thermal, &window->measured);
    }
    if (tuning->supply.on != 0u) {
        limit_supply(medium, &tuning->supply, window);
    }
    const link_watch_input_t link = {
        .u_dc = window->measured.u_dc,
        .slow = window->link.slow,
        .limits = window->link.limits | medium->link.supply.limits,
    };
    link_watch_step(&medium->link.watch, &tuning->link, &link);
    ride_through(medium, window, requests);
}

/* ---- chopper and brake ---- */

static void watch_brake(medium_t *medium, const medium_outputs_tuning_t *tuning, const window_t *window)
{
    manoeuvres_t *m = &medium->manoeuvres;
    const sequence_t *sequence = &medium->sequence;
    const holding_brake_input_t input = {
        .bridge = sequence_bridge_on(sequence),
        .holds = m->now == (int32_t)MANOEUVRE_RUN && window->bridge == (int32_t)BRIDGE_ON &&
                 sequence->state != (int32_t)DRIVE_SWITCHED_ON,
        .set = sequence->setting != 0u,
        .torque = run_torque(&m->run) * window->current.q,
    };
    holding_brake_step(&medium->outputs.brake, &tuning->brake, &input);
    run_stiffen(&m->run, medium->outputs.brake.state == (int32_t)BRAKE_RELEASING ? tuning->stiff : 1.0f);
}

void medium_watch_outputs(medium_t *medium, const medium_tuning_t *tuning, const window_t *window)
{
    const medium_outputs_tuning_t *outputs = &tuning->outputs;
    if (outputs->chopper.on != 0u) {
        const chopper_watch_input_t input = {
            .u_dc = window->measured.u_dc,
            .chopped = window->sum.chopped,
            .power = power_of(window),
        };
        chopper_watch_step(&medium->outputs.chopper, &outputs->chopper, &input);
    } else {
        medium->outputs.chopper.conditions = 0u;
    }
    if (outputs->brake.on != 0u) {
        watch_brake(medium, outputs, window);
    }
}

/* True if the chopper may work in spite of this fault: the measured link voltage, the program and the brake
 * circuit are not in doubt. The brake switch of an intelligent module shares its protection and its supply.
 */
static bool chopper_survives(int32_t reason)
{
    switch (reason) {
    case REASON_MODULE_FAULT:
    case REASON_GATES_REFUSED:
    case REASON_BAD_SAMPLE:
    case REASON_LATE:
    case REASON_MEDIUM_LATE:
    case REASON_BACKGROUND_STALLED:
    case REASON_PROGRAM_CORRUPT:
    case REASON_PARAMS_CORRUPT:
    case REASON_STACK_LOW:
    case REASON_STORE_CORRUPT:
    case REASON_BOARD_FAILED:
    case REASON_CHOPPER_OVERLOAD:
    case REASON_CHOPPER_NO_EFFECT:
        return false;
    default:
        return true;
    }
}

uint32_t medium_outputs(const medium_t *medium, const medium_tuning_t *tuning, uint32_t bridge)
{
    const sequence_t *sequence = &medium->sequence;
    uint32_t outputs = 0u;
    if (tuning->outputs.chopper.on != 0u && medium->outputs.chopper.conditions == 0u &&
        (sequence->state != (int32_t)DRIVE_FAULT || chopper_survives(sequence->fault_reason))) {
        outputs |= DRIVE_OUTPUT_CHOPPER;
    }
    if (tuning->outputs.brake.on != 0u && bridge != 0u && holding_brake_opens(&medium->outputs.brake)) {
        outputs |= DRIVE_OUTPUT_BRAKE;
    }
    return outputs;
}

void medium_hold(const medium_t *medium, const medium_tuning_t *tuning, run_wish_t *wish)
{
    switch ((brake_state_t)medium->outputs.brake.state) {
    case BRAKE_SET:
        *wish = (run_wish_t){RUN_TORQUE, 0.0f, {0.0f, 0.0f}, tuning->outputs.preload};
        break;
    case BRAKE_RELEASING:
    case BRAKE_APPLYING:
        *wish = (run_wish_t){RUN_STOP, 0.0f, {0.0f, 0.0f}, 0.0f};
        break;
    case BRAKE_RELEASED:
        break;
    }
}
