#include "medium/sequence.h"

#include <string.h>

#include "guard/guard.h"
#include "math/bounds.h"
#include "settings/reasons.h"

#define REARM_WINDOWS DRIVE_WINDOWS(20e-3f) /* without a fault or its line before a reset or a start */

/* From a fault of the power module to its automatic reset; the drive must run for FORGET_WINDOWS
 * until the count of resets restarts. */
#define RETRY_WINDOWS  DRIVE_WINDOWS(1.0f)
#define FORGET_WINDOWS DRIVE_WINDOWS(60.0f)

#define INPUT_STOP_WINDOWS DRIVE_WINDOWS(SEQUENCE_INPUT_STOP)

/* Orders the bridge off, or on, without a start. */
#define OFF UINT32_C(0)
#define ON  SEQUENCE_ON

sequence_tuning_t sequence_prepare(const params_t *params)
{
    return (sequence_tuning_t){
        .dc_undervoltage = params->dc_undervoltage,
        .standstill = bounds_more(SEQUENCE_STANDSTILL_SHARE * params->overspeed_trip, SEQUENCE_STANDSTILL),
        .stop_windows = DRIVE_WINDOWS(params->fault_stop_time),
        .retries = (uint32_t)params->module_fault_retries,
        .brakes = params->holding_brake == (int32_t)BRAKE_HOLDING ? UINT32_C(1) : UINT32_C(0),
        .debounce = DRIVE_WINDOWS((float)BOARD_ENABLE_DEBOUNCE_US / 1e6f),
    };
}

void sequence_init(sequence_t *sequence, const sequence_tuning_t *tuning)
{
    memset(sequence, 0, sizeof *sequence);
    sequence_take(sequence, tuning);
    sequence->state = (int32_t)DRIVE_NOT_READY;
}

static void enter(sequence_t *sequence, drive_state_t state)
{
    sequence->state = (int32_t)state;
    sequence->setting = 0u;
    sequence->retry_windows = 0u;
}

void sequence_fault(sequence_t *sequence, int32_t reason)
{
    sequence->fault_reason = sequence->stop_reason != (int32_t)REASON_NONE ? sequence->stop_reason : reason;
    sequence->faults_later =
        fault_set_without(guard_fault_of(reason), guard_fault_of(sequence->fault_reason));
    sequence->stop_reason = (int32_t)REASON_NONE;
    enter(sequence, DRIVE_FAULT);
}

void sequence_coast(sequence_t *sequence)
{
    enter(sequence, DRIVE_READY);
}

static bool rearmed(const sequence_t *sequence)
{
    return sequence->quiet_windows >= REARM_WINDOWS;
}

/* The reason why a fault cannot be reset now: the first fault that is still present, the module's fault line,
 * or the fault itself if it has been absent for too short a time. */
static int32_t present(const sequence_t *sequence, const sequence_input_t *input)
{
    const fault_set_t holding = fault_set_both(input->faults, input->stops);
    if (fault_set_any(holding)) {
        return guard_reason(holding);
    }
    return (input->measured->flags & DRIVE_SAMPLE_FAULT_LINE) != 0u ? (int32_t)REASON_MODULE_FAULT
                                                                    : sequence->fault_reason;
}

/* A fault of the power module that is no longer present is reset automatically after a pause, as often as the
 * parameters allow. */
static bool retries(sequence_t *sequence, const sequence_input_t *input)
{
    if (sequence->fault_reason != (int32_t)REASON_MODULE_FAULT ||
        input->requests->enable != (int32_t)REQUEST_ON || sequence->retried >= sequence->tuning.retries) {
        return false;
    }
    sequence->retry_windows++;
    if (sequence->retry_windows < RETRY_WINDOWS || !rearmed(sequence)) {
        return false;
    }
    sequence->retried++;
    return true;
}

static uint32_t in_fault(sequence_t *sequence, const sequence_input_t *input, bool reset_edge)
{
    if (fault_set_any(input->faults)) {
        sequence->faults_later = fault_set_both(
            sequence->faults_later, fault_set_without(input->faults, guard_fault_of(sequence->fault_reason)));
    }
    sequence->refusal = input->requests->enable == (int32_t)REQUEST_OFF ? REASON_NONE : REASON_FAULT_LATCHED;
    const bool reset = reset_edge && rearmed(sequence);
    if (reset || retries(sequence, input)) {
        sequence->held |= reset && input->requests->enable == (int32_t)REQUEST_ON ? UINT32_C(1) : UINT32_C(0);
        sequence->fault_reason = REASON_NONE;
        sequence->fault_present = REASON_NONE;
        enter(sequence, DRIVE_NOT_READY);
    } else if (reset_edge) {
        sequence->refusal = REASON_FAULT_PRESENT;
        sequence->fault_present = present(sequence, input);
    } else if (!rearmed(sequence)) {
        sequence->refusal = REASON_FAULT_PRESENT;
    }
    return OFF;
}

static uint32_t in_not_ready(sequence_t *sequence, const sequence_input_t *input)
{
    sequence->refusal = input->requests->enable == (int32_t)REQUEST_OFF ? REASON_NONE : REASON_NOT_READY;
    if (input->calibration == CALIBRATION_GOOD) {
        enter(sequence, DRIVE_READY);
    } else if (input->calibration == CALIBRATION_FAILED) {
        sequence_fault(sequence, REASON_CURRENT_OFFSET);
    } else if (input->calibration == CALIBRATION_NOISY) {
        sequence_fault(sequence, REASON_CURRENT_NOISE);
    }
    return OFF;
}

static int32_t why_not_on(const sequence_t *sequence, const sequence_input_t *input)
{
    if (sequence->input_lost != 0u || sequence->input_differs != 0u) {
        return REASON_ENABLE_INPUT;
    }
    if (sequence->held != 0u) {
        return REASON_ENABLE_HELD;
    }
    if (!rearmed(sequence)) {
        return REASON_FAULT_PRESENT;
    }
    if ((input->measured->flags & DRIVE_SAMPLE_LATE) != 0u) {
        return REASON_LATE; /* with the bridge on, currents would grow in the periods without an interrupt */
    }
    if (input->measured->u_dc < sequence->tuning.dc_undervoltage) {
        return REASON_DC_UNDERVOLTAGE;
    }
    if (input->calibration == CALIBRATION_FAILED) {
        return REASON_CURRENT_OFFSET;
    }
    if (measure_current_flows(input->measured)) {
        return REASON_ROTOR_TOO_FAST;
    }
    if (input->overspeed) {
        return REASON_OVERSPEED; /* the fault would follow before the EMF has shown whether the rotor turns */
    }
    return input->calibration == CALIBRATION_DUE ? REASON_NOT_READY : REASON_NONE;
}

static uint32_t in_ready(sequence_t *sequence, const sequence_input_t *input)
{
    if (input->requests->enable != (int32_t)REQUEST_ON) {
        return OFF;
    }
    sequence->refusal = why_not_on(sequence, input);
    if (sequence->refusal != (int32_t)REASON_NONE) {
        return OFF;
    }
    enter(sequence, DRIVE_SWITCHED_ON);
    return ON | SEQUENCE_BEGIN;
}

/* After their release the gates must be on. */
static uint32_t in_switched_on(sequence_t *sequence, const sequence_input_t *input)
{
    if (input->requests->enable != (int32_t)REQUEST_ON) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    if (input->bridge == BRIDGE_OFF) {
        return ON;
    }
    if ((input->measured->flags & DRIVE_SAMPLE_TRIPPED) != 0u) {
        sequence_fault(sequence, REASON_GATES_REFUSED);
        return OFF;
    }
    if (input->bridge == BRIDGE_ON) {
        enter(sequence, DRIVE_OPERATION_ENABLED);
    }
    return ON;
}

/* The gates are off although the fast task has reported no fault, because a bit of its memory has flipped. */
static bool lost_bridge(sequence_t *sequence, const sequence_input_t *input)
{
    if (input->bridge == BRIDGE_OFF) {
        sequence_fault(sequence, REASON_GATES_REFUSED);
        return true;
    }
    return false;
}

static uint32_t in_operation(sequence_t *sequence, const sequence_input_t *input)
{
    if (lost_bridge(sequence, input)) {
        return OFF;
    }
    const bool asked_off = input->requests->enable == (int32_t)REQUEST_OFF;
    if (asked_off && sequence->tuning.brakes == 0u) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    if (asked_off || input->requests->enable == (int32_t)REQUEST_QUICK_STOP) {
        sequence->stopping = 0u;
        enter(sequence, DRIVE_QUICK_STOP);
    }
    if (sequence->retried != 0u) {
        sequence->retry_windows++;
        sequence->retried = sequence->retry_windows < FORGET_WINDOWS ? sequence->retried : 0u;
    }
    return ON;
}

static uint32_t in_quick_stop(sequence_t *sequence, const sequence_input_t *input)
{
    if (lost_bridge(sequence, input)) {
        return OFF;
    }
    const bool for_fault = sequence->stop_reason != (int32_t)REASON_NONE;
    const bool asked_off = input->requests->enable == (int32_t)REQUEST_OFF;
    sequence->stopping++;
    const bool over = sequence->stopping >= sequence->tuning.stop_windows ||
                      sequence->input_stop >= INPUT_STOP_WINDOWS || sequence->input_losses > 1u;
    const bool brakes = sequence->tuning.brakes != 0u;
    const bool ends = input->standing || (asked_off && !brakes) || (over && (for_fault || brakes));
    sequence->setting |= ends ? UINT32_C(1) : UINT32_C(0);
    if (sequence->setting != 0u && input->brake_set) {
        if (for_fault) {
            sequence_fault(sequence, sequence->stop_reason);
        } else {
            enter(sequence, DRIVE_READY);
        }
        return OFF;
    }
    if (input->requests->enable == (int32_t)REQUEST_ON) { /* a stop that has begun continues to its end */
        sequence->refusal = for_fault ? sequence->stop_reason : (int32_t)REASON_STOPPING;
    }
    return ON;
}

/* Follows the enable input. It counts once it has had its new level for the debounce time; while the bridge
 * is off, `enable` = on is then held, so that the input alone starts nothing. */
static void look_at_input(sequence_t *sequence, const sequence_input_t *input)
{
    const uint32_t lost =
        (input->measured->flags & DRIVE_SAMPLE_NOT_ENABLED) != 0u ? UINT32_C(1) : UINT32_C(0);
    sequence->input_stop += sequence->input_losses != 0u ? 1u : 0u;
    sequence->input_differs = lost != sequence->input_lost ? sequence->input_differs + 1u : 0u;
    if (sequence->input_differs > sequence->tuning.debounce) {
        sequence->input_lost = lost;
        sequence->input_differs = 0u;
        sequence->input_losses += lost;
    }
    if (!sequence_bridge_on(sequence)) {
        sequence->input_losses = 0u;
        sequence->input_stop = 0u;
        sequence->held |= input->requests->enable == (int32_t)REQUEST_ON ? sequence->input_lost : 0u;
    }
}

/* A fault that requires a stop: a running motor brakes. The first of several faults counts. */
static uint32_t stop(sequence_t *sequence, int32_t reason)
{
    if (sequence->state < (int32_t)DRIVE_OPERATION_ENABLED) {
        sequence_fault(sequence, reason);
        return OFF;
    }
    sequence->stop_reason = reason;
    sequence->stopping = 0u;
    enter(sequence, DRIVE_QUICK_STOP);
    return ON;
}

static uint32_t in_state(sequence_t *sequence, const sequence_input_t *input)
{
    switch ((drive_state_t)sequence->state) {
    case DRIVE_NOT_READY:
        return in_not_ready(sequence, input);
    case DRIVE_READY:
        return in_ready(sequence, input);
    case DRIVE_SWITCHED_ON:
        return in_switched_on(sequence, input);
    case DRIVE_OPERATION_ENABLED:
        return in_operation(sequence, input);
    case DRIVE_QUICK_STOP:
        return in_quick_stop(sequence, input);
    case DRIVE_FAULT:
        break;
    }
    return OFF;
}

uint32_t sequence_step(sequence_t *sequence, const sequence_input_t *input)
{
    const int32_t reset = input->requests->fault_reset;
    const bool reset_edge = reset != 0 && sequence->fault_reset_seen == 0;
    const bool fault = fault_set_any(input->faults);
    const bool quiet =
        !fault && !fault_set_any(input->stops) && (input->measured->flags & DRIVE_SAMPLE_FAULT_LINE) == 0u;
    sequence->fault_reset_seen = reset;
    sequence->quiet_windows = quiet ? sequence->quiet_windows + (rearmed(sequence) ? 0u : 1u) : 0u;
    sequence->refusal = REASON_NONE;
    if (input->requests->enable == (int32_t)REQUEST_OFF) {
        sequence->held = 0u;
        sequence->retried = 0u;
    }
    look_at_input(sequence, input);

    if (sequence->state == (int32_t)DRIVE_FAULT) {
        return in_fault(sequence, input, reset_edge);
    }
    if (fault) {
        sequence_fault(sequence, guard_reason(input->faults));
        return OFF;
    }
    if (fault_set_any(input->stops) && sequence->stop_reason == (int32_t)REASON_NONE) {
        return stop(sequence, guard_reason(input->stops));
    }
    if (sequence->input_losses != 0u && sequence->stop_reason == (int32_t)REASON_NONE) {
        return stop(sequence, REASON_ENABLE_INPUT);
    }
    return in_state(sequence, input);
}
