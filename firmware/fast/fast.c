#include "fast/fast_trips.h"

#include <string.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/trig.h"
#include "settings/reasons.h"

/* [-] of the DC link: the voltage is limited if the applied voltage is shorter than the required one by more
 * than this. The shortest pulse and the dead time cause smaller differences. */
#define LIMITED_SHARE 0.05f

/* [V] No gain, current and speed within their ranges need a voltage beyond this. */
#define VOLTAGE_MOST 1e6f

/* [periods] of a window before the one that computes the lean of the loop. The first and the last period of a
 * window have other work. */
#define LEAN_PERIOD 4u

/* Passes the learnt values of motor, load and inverter to the parts that use them. */
static void set_models(fast_t *fast, fast_orders_t orders)
{
    const setpoint_t *setpoint = orders.setpoint;
    chosen_set_flux(&fast->estimator, setpoint->models.flux_linkage, setpoint->models.speed_per_volt);
}

/* Sets other coefficients; the state is kept. */
static void set_tuning(fast_t *fast, const fast_tuning_t *tuning)
{
    measure_take(&fast->measure);
    chosen_take(&fast->estimator, &tuning->estimator);
    current_control_take(&fast->current_control, &tuning->current_control);
    link_limit_take(&fast->link, &tuning->link);
}

void fast_init(fast_t *fast, fast_orders_t orders)
{
    const fast_tuning_t *tuning = orders.tuning;
    memset(fast, 0, sizeof *fast);
    measure_init(&fast->measure);
    guard_init(&fast->trips);
    inverter_init(&fast->inverter);
    doubt_init(&fast->doubt);
    current_control_init(&fast->current_control, &tuning->current_control);
    excite_init(&fast->control.excite);
    reference_init(&fast->reference);
    link_limit_init(&fast->link, &tuning->link);
    encoder_reset(&fast->encoder, &tuning->encoder, 0u);
    set_tuning(fast, tuning);
    set_models(fast, orders);
    chosen_reset(&fast->estimator, fast->shaft.position, fast->measure.measured.current);
}

/* ---- the setpoint ---- */

/* Limits of i_q by heat, supply and DC link, with the sign of the speed. */
static void limit(fast_t *fast, const setpoint_t *setpoint)
{
    const float brakes = setpoint->braking_limit;
    const float drives = setpoint->driving_limit;
    const float braking = bounds_more(bounds_less(fast->link.braking, brakes), -drives);
    const float asked = bounds_more(bounds_less(fast->link.driving, drives), -brakes);
    const float least = braking < 0.0f ? -braking : 0.0f; /* braking current that a full link supplies */
    const float driving = setpoint->only_brakes != 0u && asked > least ? least : asked;
    const bool backwards = fast->omega_m < 0.0f;
    fast->bounds.lower = backwards ? -driving : -braking;
    fast->bounds.upper = backwards ? braking : driving;
}

void fast_turn(fast_t *fast, const setpoint_t *setpoint, const setpoint_t *before)
{
    fast->given.late <<= 1;
    fast->given.overdue = 0u;
    fast->given.fresh = 1u;
    if (setpoint->gates == 0u && (int32_t)(setpoint->number - fast->bridge.open_since) >= 0) {
        fast->bridge.open = 0u;
    }
    if (setpoint->calibrate != before->calibrate) {
        fast->report.calibration = (int32_t)CALIBRATION_GOES_ON;
        if (setpoint->calibrate == (int32_t)CALIBRATE_NOT) {
            measure_begin_calibration(&fast->measure);
        }
    }
}

/* Outputs that this setpoint permits. While the bridge is open because of a fault, the brake stays set, and
 * the chopper stays off until a setpoint that was made of the fault permits it. */
static uint32_t permitted(const fast_bridge_t *bridge, const setpoint_t *setpoint)
{
    if (bridge->open == 0u) {
        return setpoint->outputs;
    }
    const bool judged = (int32_t)(setpoint->number - bridge->open_since) >= 0;
    return judged ? setpoint->outputs & ~DRIVE_OUTPUT_BRAKE : 0u;
}

/* The first period of a window takes over the new setpoint, and begins the sums. */
static void begin_window(fast_t *fast, fast_orders_t orders)
{
    const setpoint_t *setpoint = orders.setpoint;
    fast->given.fresh = 0u;
    fast_begin_sums(&fast->sum);
    reference_take(&fast->reference, &orders.tuning->reference, setpoint);
    set_models(fast, orders);
    fast->link.sunk = setpoint->link.sunk;
    fast->link.low = setpoint->link.low;
    fast->bridge.outputs.permitted = permitted(&fast->bridge, setpoint);
    const bool later = fast->link.limits != 0u && fast->bridge.on != 0u; /* set in limit_by_link() */
    if (!later) {
        limit(fast, setpoint);
    }
}

void fast_take_tuning(fast_t *fast, fast_orders_t orders, const fast_tuning_t *before)
{
    encoder_take(&fast->encoder, &before->encoder, &orders.tuning->encoder,
                 fast->measure.measured.encoder_count);
    set_tuning(fast, orders.tuning);
    set_models(fast, orders);
}

/* ---- where the rotor is ---- */

/* true: the voltage that acted is too uncertain for tracking. */
static inline bool voltage_uncertain(fast_t *fast, fast_orders_t orders, const inverter_acted_t *acted)
{
    const estimate_t *last = &fast->estimator.estimate;
    if (!doubt_may_be(&fast->doubt, last->amplitude, acted->leg)) {
        return false;
    }
    const setpoint_t *setpoint = orders.setpoint;
    const doubt_input_t input = {
        .current = acted->current,
        .leg = acted->leg,
        .amplitude = last->amplitude,
        .detector = last->detector,
        .omega_e = last->frame.omega_e,
        .omega_m = fast->omega_m,
        .omega_m_miss = fast->demand.omega_m_ref - fast->omega_m,
        .load = setpoint->models.load_seen,
        .gained = setpoint->models.gained,
        .foreseen = setpoint->models.foreseen,
    };
    return doubt_step(&fast->doubt, &orders.tuning->doubt, &input);
}

/* The torque that accelerates the rotor, and the lean of the loop, from i_q.
 *
 * While the speed reference is constant, the mean i_q carries the load. The difference from this mean
 * accelerates the rotor, and the tracking loop receives it as a torque in its next step. The i_q is that of
 * the frame at t_k, as the loop uses it: in the frame of t_k-1 it would contain a part of i_d. */
static void estimate_load(fast_t *fast, fast_orders_t orders)
{
    const setpoint_t *setpoint = orders.setpoint;
    const estimate_t *estimate = &fast->estimator.estimate;
    const dq_t current = frames_park(fast->measure.measured.current, estimate->frame.rotation);
    const float torque = (current.q * estimate->flux - current.d * estimate->cross) *
                         setpoint->models.speed_per_volt; /* as a current of psi_f */
    const float load = lowpass_step(fast->load_current, setpoint->models.load_share, torque);
    fast->load_current = load;
    chosen_set_load(&fast->estimator, load);
    if (fast->sum.periods == LEAN_PERIOD) {
        chosen_set_lean(&fast->estimator, loop_lean(&orders.tuning->lean, current.q, estimate->omega_smooth));
    }
}

static void estimate(fast_t *fast, fast_orders_t orders)
{
    const measured_t *measured = &fast->measure.measured;
    fast->acted = inverter_acted(&fast->inverter, &orders.tuning->inverter, orders.setpoint->models.dead_time,
                                 orders.setpoint->models.per_zone, measured->current,
                                 fast->demand.frame.omega_e, measured->u_dc);
    const inverter_acted_t *acted = &fast->acted;
    const ab_t spared = orders.setpoint->models.spared;
    const ab_t voltage = {acted->voltage.alpha - spared.alpha, acted->voltage.beta - spared.beta};
    if (fast->reference.tracking == 0u) {
        chosen_observe(&fast->estimator, voltage, measured->current, reference_speed(&fast->reference));
        fast->load_current = 0.0f;
        chosen_set_load(&fast->estimator, 0.0f);
        return;
    }
    if (voltage_uncertain(fast, orders, acted)) {
        (void)chosen_coast(&fast->estimator, voltage, measured->current);
    } else {
        chosen_track(&fast->estimator, voltage, measured->current);
    }
    estimate_load(fast, orders);
}

/* While the bridge is off, the voltage is unknown and the estimator does not run. */
static void estimate_position(fast_t *fast, fast_orders_t orders)
{
    const fast_tuning_t *tuning = orders.tuning;
    fast->shaft.position =
        encoder_step(&fast->encoder, &tuning->encoder, fast->measure.measured.encoder_count);
    if (fast->reference.source == (int32_t)SOURCE_ENCODER) {
        fast->shaft.frame = (frame_t){fast->shaft.position.theta_e, fast->shaft.position.omega_e,
                                      trig_turn(fast->shaft.position.theta_e)};
    }
    reference_advance(&fast->reference, &tuning->reference);
    if (fast->estimating != 0u) {
        estimate(fast, orders);
    }
    fast_update_rotor(fast, orders);
}

/* ---- control ---- */

/* The demand on current control in this period. `left`: this is the first period without the encoder. If the
 * loop is locked to an angle here, its next step continues from this angle. */
static void demand(fast_t *fast, fast_orders_t orders, bool left)
{
    const measured_t *measured = &fast->measure.measured;
    const reference_input_t input = {
        .u_dc = measured->u_dc,
        .estimate = &fast->estimator.estimate,
        .position = &fast->shaft.position,
        .encoder = &fast->shaft.frame,
        .omega_m = fast->omega_m,
        .estimating = fast->estimating,
        .period = fast->sum.periods,
    };
    reference_t *reference = &fast->reference;
    const frame_t last = fast->demand.frame;
    dq_t emf = fast->demand.emf;
    const int32_t origin = fast->demand.origin;
    reference_step(reference, &orders.tuning->reference, orders.setpoint, &input, &fast->demand);
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
        const rotation_t turn = frames_between(before, now);
        current_control_turn(&fast->current_control, turn);
        emf = frames_park((ab_t){emf.d, emf.q}, turn);
    } else if (fast->demand.change == (int32_t)FRAME_ANEW) {
        current_control_reset(&fast->current_control, (dq_t){0.0f, 0.0f});
    }
    /* psi_f omega and the observed EMF differ by the error of psi_f, which the integrals have compensated */
    if (fast->demand.origin != origin && origin != (int32_t)EMF_OTHER &&
        fast->demand.origin != (int32_t)EMF_OTHER) {
        current_control_shift(&fast->current_control,
                              (dq_t){fast->demand.emf.d - emf.d, fast->demand.emf.q - emf.q});
    }
    fast->control.current = frames_park(measured->current, now);
}

/* The limits of i_q near the limits of the DC link, in each period. They do not act in a forced frame, where
 * i_q does not determine the power into the link. */
static void limit_by_link(fast_t *fast, fast_orders_t orders)
{
    const link_limit_tuning_t *tuning = &orders.tuning->link;
    const float u_dc = fast->measure.measured.u_dc;
    if (link_limit_is_near(&fast->link, tuning, u_dc)) {
        const bool forced = fast->reference.source == (int32_t)SOURCE_FORCED;
        link_limit_step(&fast->link, tuning, u_dc, forced ? 0.0f : fast->omega_m);
        limit(fast, orders.setpoint);
    }
}

/* The current reference in the frame of the rotor, limited by heat and DC link, with the dither, from whose
 * response L is identified. */
static dq_t limited_reference(const fast_t *fast, const setpoint_t *setpoint)
{
    const dq_t asked = fast->demand.current;
    return (dq_t){asked.d + setpoint->dither.d, bounds_between(asked.q, fast->bounds) + setpoint->dither.q};
}

/* Field-oriented control: demand to duties. */
static abc_t control(fast_t *fast, const fast_tuning_t *tuning)
{
    const frame_t *frame = &fast->demand.frame;
    const float turn = DRIVE_PERIOD * frame->omega_e;
    const rotation_t acting = trig_advance(frame->rotation, 1.5f * turn);
    const dq_t asked = current_control_step(&fast->current_control, fast->demand.current,
                                            fast->control.current, turn, fast->demand.emf);
    const inverter_made_t made = inverter_make(&tuning->inverter, frames_inverse_park(asked, acting),
                                               frames_inverse_park(fast->demand.current, acting),
                                               fast->acted.leg, fast->measure.measured.u_dc);
    fast->control.voltage = asked;
    fast->control.limited = 0u;
    if (made.cut) {
        const dq_t missing = frames_park(made.missing, acting);
        const float most = LIMITED_SHARE * fast->measure.measured.u_dc;
        fast->control.limited =
            bounds_within(missing.d, most) && bounds_within(missing.q, most) ? UINT32_C(0) : UINT32_C(1);
        fast->control.voltage = (dq_t){asked.d + missing.d, asked.q + missing.q};
        if (!bounds_within(asked.d, VOLTAGE_MOST) || !bounds_within(asked.q, VOLTAGE_MOST)) {
            fast_stop(fast, REASON_PARAMS_CORRUPT);
        }
    }
    current_control_applied(&fast->current_control, fast->control.voltage);
    return made.duty;
}

/* The first duties go out in the first period, and the gates come on with them in the second. If the lower
 * switches charge the supply of the upper gates (bootstrap), the gates come on a period later, because a
 * pulse that has begun before a duty of zero ends only in the next period. Then only the lower switches are
 * on, for charge_periods. This short-circuits a rotating motor: if current flows, control begins at once, and
 * its zero vectors continue the charging. */
static bool comes_on(fast_t *fast, const fast_limits_t *limits)
{
    const bool charges = limits->charge_periods != 0u;
    const uint32_t gates_at = charges ? UINT32_C(3) : UINT32_C(2);
    if (fast->bridge.on == 0u) {
        fast->bridge.charging = limits->charge_periods;
    }
    fast->bridge.on += fast->bridge.on < FAST_ON ? 1u : 0u;
    fast->command.gates = (int32_t)(fast->bridge.on < gates_at    ? GATES_OFF
                                    : fast->bridge.on == gates_at ? GATES_ON
                                                                  : GATES_KEEP);
    if (fast->bridge.charging != 0u && fast->bridge.on > gates_at) {
        fast->bridge.charging -= 1u;
        fast->bridge.charging = measure_current_flows(&fast->measure.measured) ? 0u : fast->bridge.charging;
    }
    return fast->bridge.on < gates_at || fast->bridge.charging != 0u;
}

/* The estimator runs from the first period of the gates on. While a motor with unknown data is excited, no
 * other module uses its estimate. */
static void begin_estimate(fast_t *fast, const setpoint_t *setpoint)
{
    const bool encoder = fast->reference.source == (int32_t)SOURCE_ENCODER;
    if (setpoint->excite.kind == (int32_t)EXCITE_NONE) {
        chosen_reset(&fast->estimator, encoder ? fast->shaft.position : (position_t){0.0f, 0.0f},
                     fast->measure.measured.current);
    }
    current_control_reset(&fast->current_control, (dq_t){0.0f, 0.0f});
    fast->estimating = 1u;
}

static void run(fast_t *fast, fast_orders_t orders, bool left)
{
    bool comes = false;
    if (fast->bridge.on < FAST_ON || fast->bridge.charging != 0u) {
        comes = comes_on(fast, &orders.tuning->limits);
    } else {
        fast->command.gates = (int32_t)GATES_KEEP;
    }
    if (!comes && fast->estimating == 0u) {
        begin_estimate(fast, orders.setpoint);
    }
    demand(fast, orders, left);
    limit_by_link(fast, orders);
    if (reference_in_rotor(&fast->reference)) {
        fast->demand.current = limited_reference(fast, orders.setpoint);
    }
    if (fast->bridge.charging != 0u) {
        fast->command.duty = (abc_t){0.0f, 0.0f, 0.0f};
    } else if (orders.setpoint->excite.kind != (int32_t)EXCITE_NONE) {
        fast->command.duty = fast_excite(fast, orders);
    } else {
        fast->command.duty = control(fast, orders.tuning);
    }
}

/* ---- the period ---- */

static void sum_up(fast_t *fast)
{
    const estimate_t *estimate = &fast->estimator.estimate;
    const observed_t *observed = &fast->estimator.observed;
    const measured_t *measured = &fast->measure.measured;
    window_sums_t *sum = &fast->sum;
    sum->periods++;
    sum->limited |= fast->control.limited;
    sum->current.alpha += measured->current.alpha;
    sum->current.beta += measured->current.beta;
    if (fast->estimating == 0u) {
        sum->unsound = 1u;
        return;
    }
    sum->unsound |= estimate->invalid | (measured->good ^ 1u);
    sum->tracked += estimate->coasted ^ 1u;
    sum->scatter += estimate->detector * estimate->detector;
    sum->voltage.alpha += fast->acted.voltage.alpha;
    sum->voltage.beta += fast->acted.voltage.beta;
    sum->emf.alpha += estimate->emf.alpha;
    sum->emf.beta += estimate->emf.beta;
    sum->emf_hat.alpha += observed->emf_hat.alpha;
    sum->emf_hat.beta += observed->emf_hat.beta;
    sum->reference.d += fast->demand.current.d;
    sum->reference.q += fast->demand.current.q;
}

/* Brake chopper and holding brake of the board. */
static inline void drive_outputs(fast_t *fast, const chopper_tuning_t *tuning)
{
    fast_outputs_t *outputs = &fast->bridge.outputs;
    outputs->chops = chopper_step(outputs->chops, tuning, fast->measure.measured.u_dc);
    const uint32_t on = outputs->permitted & (outputs->chops | DRIVE_OUTPUT_BRAKE);
    fast->sum.chopped += on & DRIVE_OUTPUT_CHOPPER;
    fast->command.outputs = on;
}

void fast_step(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples, int32_t opens,
               drive_command_t *command)
{
    const setpoint_t *setpoint = orders.setpoint;
    if (fast->given.fresh != 0u) {
        begin_window(fast, orders);
    }
    if (opens != (int32_t)REASON_NONE) {
        fast_open_bridge(fast, fast->report.number - 1u);
    }
    if (fast->period == 0u) {
        encoder_reset(&fast->encoder, &orders.tuning->encoder, samples->encoder);
    }
    fast->period++;
    measure_step(&fast->measure, samples, setpoint->trim);
    if ((samples->flags & DRIVE_SAMPLE_LATE) != 0u) {
        measure_late(&fast->measure, fast->period);
    }
    estimate_position(fast, orders);
    const bool left = fast_trip(fast, orders, samples);
    sum_up(fast);
    if (setpoint->gates != 0u && fast->bridge.open == 0u) {
        run(fast, orders, left);
    } else {
        fast_rest(fast, orders, samples);
    }
    drive_outputs(fast, &orders.tuning->chopper);
    inverter_remember(&fast->inverter, &fast->command.duty, fast->measure.measured.current,
                      fast->measure.measured.u_dc);
    command->duty = (abc_t){fast->command.duty.a, fast->command.duty.b, fast->command.duty.c};
    /* Copied field by field, because the compiler copies a whole struct by a function call. */
    command->gates = fast->command.gates;
    command->outputs = fast->command.outputs;
}
