#include "drive/fast_parts.h"

#include <string.h>

#include "drive/reasons.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/trig.h"

/* [-] of the link, by which a voltage must fall short of what control asks for to be limited; a shortest
 * pulse and what the dead time takes are less */
#define LIMITED_SHARE 0.05f

/* What is learnt of motor, load and inverter, to who works with it. */
static void tell_models(fast_t *fast)
{
    const setpoint_t *setpoint = &fast->setpoint;
    chosen_set_flux(&fast->estimator, setpoint->flux_linkage, setpoint->speed_per_volt);
    inverter_set_dead_time(&fast->inverter, setpoint->dead_time);
}

void fast_init(fast_t *fast, const fast_tuning_t *tuning, const setpoint_t *setpoint)
{
    memset(fast, 0, sizeof *fast);
    fast->setpoint = *setpoint;
    measure_init(&fast->measure, &tuning->measure);
    guard_init(&fast->trips, &tuning->guard);
    inverter_init(&fast->inverter, &tuning->inverter);
    doubt_init(&fast->doubt, &tuning->doubt);
    current_control_init(&fast->current_control, &tuning->current_control);
    reference_init(&fast->reference, &tuning->reference);
    link_init(&fast->link, &tuning->link);
    fast_set_tuning(fast, tuning, 0u);
    chosen_reset(&fast->estimator, fast->encoder_position, fast->measure.measured.current);
}

void fast_set_tuning(fast_t *fast, const fast_tuning_t *tuning, uint32_t encoder_count)
{
    measure_take(&fast->measure, &tuning->measure);
    guard_take(&fast->trips, &tuning->guard);
    encoder_take(&fast->encoder, &tuning->encoder, encoder_count);
    chosen_take(&fast->estimator, &tuning->estimator);
    inverter_take(&fast->inverter, &tuning->inverter);
    fast->doubt.tuning = tuning->doubt;
    current_control_take(&fast->current_control, &tuning->current_control);
    reference_set_tuning(&fast->reference, &tuning->reference);
    link_take(&fast->link, &tuning->link);
    still_watch_take(&fast->still_watch, &tuning->still_watch);
    fast->limits = tuning->limits;
    tell_models(fast);
}

/* ---- the setpoint ---- */

/* What heat and DC link leave of i_q, on the side of the speed. */
static void limit(fast_t *fast)
{
    const float most = fast->setpoint.current_limit;
    const float braking = bounds_clamp(fast->link.braking, most);
    const float asked = bounds_clamp(fast->link.driving, most);
    const float least = braking < 0.0f ? -braking : 0.0f; /* what a full link gives away */
    const float driving = fast->setpoint.only_brakes != 0u && asked > least ? least : asked;
    const bool backwards = fast->omega_m < 0.0f;
    fast->lower = backwards ? -driving : -braking;
    fast->upper = backwards ? braking : driving;
}

void fast_take(fast_t *fast, const setpoint_t *setpoint)
{
    const int32_t calibrated = fast->setpoint.calibrate;
    fast->medium_late = 0u;
    fast->setpoint = *setpoint;
    reference_take(&fast->reference, setpoint);
    tell_models(fast);
    fast->link.sunk = setpoint->link_sunk;
    fast->link.low = setpoint->link_low;
    if (setpoint->gates == 0u && (int32_t)(setpoint->number - fast->open_since) >= 0) {
        fast->open = 0u;
    }
    if (setpoint->calibrate != calibrated) {
        fast->calibration = (int32_t)CALIBRATION_GOES_ON;
        if (setpoint->calibrate == (int32_t)CALIBRATE_NOT) {
            measure_begin_calibration(&fast->measure);
        }
    }
    limit(fast);
}

/* ---- where the rotor is ---- */

/* Is what acted too uncertain to track by? */
static inline bool doubtful(fast_t *fast, const inverter_acted_t *acted)
{
    const estimate_t *last = &fast->estimator.estimate;
    const setpoint_t *setpoint = &fast->setpoint;
    const doubt_input_t input = {
        .current = acted->current,
        .leg = acted->leg,
        .amplitude = last->amplitude,
        .detector = last->detector,
        .omega_e = last->frame.omega_e,
        .omega_m = fast->omega_m,
        .omega_m_miss = fast->demand.omega_m_ref - fast->omega_m,
        .load = setpoint->load_seen,
        .gained = setpoint->gained,
        .foreseen = setpoint->foreseen,
    };
    return doubt_step(&fast->doubt, &input);
}

/* While the reference of the speed stays, i_q is there for the load. What it has beyond that accelerates, and
 * the tracking loop gets it as a torque in its next step. It is the i_q of the frame at t_k, as the loop has
 * it: in the frame of t_k-1 a part of i_d is in it. */
static void follow_load(fast_t *fast)
{
    if (fast->reference.tracking == 0u) {
        fast->load = 0.0f;
    } else {
        const estimate_t *estimate = &fast->estimator.estimate;
        const float i_q = frames_park(fast->measure.measured.current, estimate->frame.rotation).q;
        const float torque = i_q * estimate->flux * fast->setpoint.speed_per_volt; /* as a current of psi_f */
        fast->load = lowpass_step(fast->load, fast->setpoint.load_share, torque);
    }
    chosen_set_load(&fast->estimator, fast->load);
}

static void estimate(fast_t *fast)
{
    const measured_t *measured = &fast->measure.measured;
    const inverter_acted_t acted = inverter_acted(&fast->inverter, measured->current, measured->u_dc);
    fast->acted = acted.voltage;
    fast->link_mean = acted.link;
    fast->dead_voltage = acted.leg;
    if (fast->reference.tracking == 0u) {
        chosen_observe(&fast->estimator, acted.voltage, measured->current, reference_speed(&fast->reference));
    } else if (doubtful(fast, &acted)) {
        (void)chosen_coast(&fast->estimator, acted.voltage, measured->current);
    } else {
        (void)chosen_step(&fast->estimator, acted.voltage, measured->current);
    }
    follow_load(fast);
}

/* The rotor as it is believed, and its speed for what must not be noisy: of the estimate without the loop's
 * proportional part, whose noise would come back through the speed control. */
void fast_believe(fast_t *fast)
{
    const estimate_t *estimate = &fast->estimator.estimate;
    const reference_t *reference = &fast->reference;
    fast->rotor = reference_rotor(reference, &fast->encoder_frame, estimate);
    const bool smooth = fast->limits.smooth != 0u && reference_tracks(reference);
    fast->omega_m = (smooth ? estimate->omega_smooth : fast->rotor.omega_e) * fast->limits.pole_pairs_inverse;
}

/* While the bridge is off nothing is known of the voltage: the estimator rests. */
static void locate(fast_t *fast)
{
    fast->encoder_position = encoder_step(&fast->encoder, fast->measure.measured.encoder_count);
    if (fast->reference.source == (int32_t)SOURCE_ENCODER) {
        fast->encoder_frame = (frame_t){fast->encoder_position.theta_e, fast->encoder_position.omega_e,
                                        trig_turn(fast->encoder_position.theta_e)};
    }
    reference_advance(&fast->reference);
    if (fast->estimating != 0u) {
        estimate(fast);
    }
    fast_believe(fast);
}

/* ---- control ---- */

/* What is asked of control in this period; `left`: the first without the encoder. Where the loop is locked,
 * the next step goes on from there. */
static void demand(fast_t *fast, bool left)
{
    const measured_t *measured = &fast->measure.measured;
    const reference_input_t input = {
        .current = measured->current,
        .voltage_max = FRAMES_ONE_OVER_SQRT_3 * measured->u_dc,
        .estimate = &fast->estimator.estimate,
        .position = &fast->encoder_position,
        .encoder = &fast->encoder_frame,
        .omega_m = fast->omega_m,
        .estimating = fast->estimating,
    };
    reference_t *reference = &fast->reference;
    const frame_t last = fast->demand.frame;
    reference_step(reference, &fast->setpoint, &input, &fast->demand);
    if (reference->locking != 0u) {
        chosen_lock(&fast->estimator, reference->locked, reference->locked_emf);
    }
    if (left) {
        fast->demand.change =
            (int32_t)(reference->source == (int32_t)SOURCE_CATCH ? FRAME_ANEW : FRAME_TURNS);
    }
    const rotation_t now = fast->demand.frame.rotation;
    if (fast->demand.change == (int32_t)FRAME_TURNS) {
        const rotation_t before = trig_advance(last.rotation, DRIVE_PERIOD * last.omega_e);
        current_control_turn(&fast->current_control, frames_between(before, now));
    } else if (fast->demand.change == (int32_t)FRAME_ANEW) {
        current_control_reset(&fast->current_control, (dq_t){0.0f, 0.0f});
    }
    fast->current = frames_park(measured->current, now);
}

/* Within what heat and DC link leave, and with the dither from whose answer is learnt. */
static void bound(fast_t *fast)
{
    const int32_t source = fast->reference.source;
    if (link_is_near(&fast->link, fast->measure.measured.u_dc)) {
        /* in a forced frame the limits of i_q do not act: the rotor feeds nothing on their behalf */
        link_limit(&fast->link, fast->measure.measured.u_dc,
                   source == (int32_t)SOURCE_FORCED ? 0.0f : fast->omega_m);
        limit(fast);
    }
    if (source == (int32_t)SOURCE_ESTIMATE || source == (int32_t)SOURCE_ENCODER) {
        dq_t *current = &fast->demand.current;
        const float below = current->q < fast->upper ? current->q : fast->upper;
        current->q = (below > fast->lower ? below : fast->lower) + fast->setpoint.dither.q;
        current->d += fast->setpoint.dither.d;
    }
}

/* Field-oriented control: a demand in, duties out. */
static abc_t control(fast_t *fast)
{
    const frame_t *frame = &fast->demand.frame;
    const rotation_t acting = trig_advance(frame->rotation, 1.5f * DRIVE_PERIOD * frame->omega_e);
    const dq_t asked = current_control_step(&fast->current_control, fast->demand.current, fast->current,
                                            frame->omega_e, fast->demand.emf);
    const inverter_made_t made =
        inverter_make(&fast->inverter, frames_inverse_park(asked, acting),
                      frames_inverse_park(fast->demand.current, acting), fast->measure.measured.u_dc);
    const dq_t missing = frames_park(made.missing, acting);
    const float most = LIMITED_SHARE * fast->measure.measured.u_dc;
    fast->limited =
        bounds_within(missing.d, most) && bounds_within(missing.q, most) ? UINT32_C(0) : UINT32_C(1);
    fast->voltage = (dq_t){asked.d + missing.d, asked.q + missing.q};
    current_control_applied(&fast->current_control, fast->voltage);
    return made.duty;
}

/* First period: the first duties go out; second: the gates come on with them. Where the upper gates get their
 * supply through the lower switches, the gates come on a period later, for a pulse that a duty of zero finds
 * begun is ended by the one after, and those switches alone are on for a while. A rotor that turns is shorted
 * by that: where current flows, control takes over at once, in whose zero vectors the charging goes on. */
static bool comes_on(fast_t *fast)
{
    const bool charges = fast->limits.charge_periods != 0u;
    const uint32_t gates_at = charges ? UINT32_C(3) : UINT32_C(2);
    if (fast->on == 0u) {
        fast->charging = fast->limits.charge_periods;
    }
    fast->on += fast->on < FAST_ON ? 1u : 0u;
    fast->command.gates = (int32_t)(fast->on < gates_at    ? GATES_OFF
                                    : fast->on == gates_at ? GATES_ON
                                                           : GATES_KEEP);
    if (fast->charging != 0u && fast->on > gates_at) {
        fast->charging -= 1u;
        fast->charging = measure_current_flows(&fast->measure.measured) ? 0u : fast->charging;
    }
    return fast->on < gates_at || fast->charging != 0u;
}

/* The estimator runs from the gates' period on. */
static void begin_estimate(fast_t *fast)
{
    const bool encoder = fast->reference.source == (int32_t)SOURCE_ENCODER;
    chosen_reset(&fast->estimator, encoder ? fast->encoder_position : (position_t){0.0f, 0.0f},
                 fast->measure.measured.current);
    current_control_reset(&fast->current_control, (dq_t){0.0f, 0.0f});
    fast->estimating = 1u;
}

static void run(fast_t *fast, bool left)
{
    const bool comes = (fast->on < FAST_ON || fast->charging != 0u) && comes_on(fast);
    if (fast->on >= FAST_ON) {
        fast->command.gates = (int32_t)GATES_KEEP;
    }
    if (!comes && fast->estimating == 0u) {
        begin_estimate(fast);
    }
    demand(fast, left);
    bound(fast);
    fast->command.duty = fast->charging != 0u ? (abc_t){0.0f, 0.0f, 0.0f} : control(fast);
}

/* The offsets of the current sensors, while the bridge is off. Below dc_undervoltage a rotor that turns
 * slowly may feed the link with what seems to be one. */
static void calibrate(fast_t *fast, const drive_samples_t *samples)
{
    measure_t *measure = &fast->measure;
    switch ((calibrate_t)fast->setpoint.calibrate) {
    case CALIBRATE_ALL:
        if (fast->calibration == (int32_t)CALIBRATION_GOES_ON) {
            fast->calibration = (int32_t)measure_calibrate(measure, samples);
        }
        break;
    case CALIBRATE_BLOCKS:
        if (measure->measured.u_dc < fast->limits.dc_undervoltage) {
            measure_begin_rest(measure);
        } else if (measure_rest(measure, samples, fast->setpoint.trim)) {
            fast->offsets = 1u;
        }
        fast->calibration = measure->rest.found;
        break;
    case CALIBRATE_NOT:
        break;
    }
}

static void rest(fast_t *fast, const drive_samples_t *samples)
{
    const dq_t none = {0.0f, 0.0f};
    const bool encoder = fast->setpoint.source == (int32_t)SOURCE_ENCODER;
    if (fast->on != 0u) {
        measure_begin_rest(&fast->measure);
    }
    fast->on = 0u;
    fast->runs = 0u;
    fast->estimating = 0u;
    reference_rest(&fast->reference, (int32_t)(encoder ? SOURCE_ENCODER : SOURCE_NONE));
    fast_believe(fast);
    fast->demand = (demand_t){fast->rotor, (int32_t)FRAME_GOES_ON, none, none, 0.0f};
    current_control_reset(&fast->current_control, none);
    fast->current = frames_park(fast->measure.measured.current, fast->rotor.rotation);
    fast->voltage = none;
    fast->command.duty = (abc_t){0.5f, 0.5f, 0.5f};
    fast->command.gates = (int32_t)GATES_OFF;
    calibrate(fast, samples);
}

/* ---- the window ---- */

static void sum_up(fast_t *fast)
{
    const estimate_t *estimate = &fast->estimator.estimate;
    const measured_t *measured = &fast->measure.measured;
    window_sums_t *sum = &fast->sum;
    sum->periods++;
    sum->limited |= fast->limited;
    sum->current.alpha += measured->current.alpha;
    sum->current.beta += measured->current.beta;
    if (fast->estimating == 0u) {
        sum->unsound = 1u;
        return;
    }
    sum->unsound |= estimate->invalid | (measured->good ^ 1u);
    sum->tracked += estimate->coasted ^ 1u;
    sum->scatter += estimate->detector * estimate->detector;
    sum->voltage.alpha += fast->acted.alpha;
    sum->voltage.beta += fast->acted.beta;
    sum->emf.alpha += estimate->emf.alpha;
    sum->emf.beta += estimate->emf.beta;
    sum->emf_hat.alpha += estimate->emf_hat.alpha;
    sum->emf_hat.beta += estimate->emf_hat.beta;
    sum->reference.d += fast->demand.current.d;
    sum->reference.q += fast->demand.current.q;
}

void fast_close(fast_t *fast, window_t *window)
{
    const catch_t *catching = &fast->reference.catching;
    fast->sum.moved = still_watch_moved(&fast->still_watch, DRIVE_WINDOW);
    *window = (window_t){
        .number = fast->windows,
        .period = fast->period,
        .setpoint = fast->setpoint.number,
        .sum = fast->sum,
        .measured = fast->measure.measured,
        .estimate = fast->estimator.estimate,
        .encoder = fast->encoder_position,
        .frame = fast->demand.frame,
        .rotor = fast->rotor,
        .omega_m = fast->omega_m,
        .current = fast->current,
        .reference = fast->demand.current,
        .omega_m_ref = fast->demand.omega_m_ref,
        .link = fast->link_mean,
        .lower = fast->lower,
        .upper = fast->upper,
        .link_slow = fast->link.slow,
        .link_limits = fast->link.limits,
        .catching = {fast->reference.outcome, catching->turning, catching->periods_beyond, catching->length,
                     catching->emf, catching->cross, catching->cross_min},
        .calibration = fast->calibration,
        .offsets = fast->offsets,
        .estimating = fast->estimating,
        .tracking = fast->reference.tracking,
        .bridge = (int32_t)(fast->on < FAST_ON     ? BRIDGE_OFF
                            : fast->charging != 0u ? BRIDGE_CHARGES
                                                   : BRIDGE_ON),
        .left = fast->left,
        .stop = fast->stop,
    };
    fast->sum = (window_sums_t){0};
    fast->windows++;
    fast->offsets = 0u;
    fast->left = (int32_t)JUMP_IGNORED;
    fast->stop.reason = (int32_t)REASON_NONE;
}

void fast_miss(fast_t *fast)
{
    fast->sum = (window_sums_t){0};
    fast->medium_late++;
}

void fast_step(fast_t *fast, const drive_samples_t *samples, int32_t opens, drive_command_t *command)
{
    if (opens != (int32_t)REASON_NONE) {
        fast_open_bridge(fast, fast->windows - 1u);
    }
    if (fast->period == 0u) {
        encoder_reset(&fast->encoder, samples->encoder);
    }
    fast->period++;
    measure_step(&fast->measure, samples, fast->setpoint.trim);
    locate(fast);
    const bool left = fast_trip(fast);
    sum_up(fast);
    if (fast->setpoint.gates != 0u && fast->open == 0u) {
        run(fast, left);
    } else {
        rest(fast, samples);
    }
    inverter_remember(&fast->inverter, fast->command.duty, fast->measure.measured.current,
                      fast->measure.measured.u_dc);
    *command = fast->command;
}
