#include "drive/sequence.h"

#include <string.h>

#include "drive/guard.h"
#include "drive/reasons.h"

#define REARM_PERIODS DRIVE_PERIODS(20e-3f) /* without a fault or its line before a reset or a start */

/* From a fault of the power module to the reset by itself; so long a drive must run until it may try as often
 * again. */
#define RETRY_PERIODS  DRIVE_PERIODS(1.0f)
#define FORGET_PERIODS DRIVE_PERIODS(60.0f)

/* A phase current that no gate drives: the rotor feeds the link through the diodes [A]. */
#define DIODE_CURRENT (0.02f * DRIVE_CURRENT_RANGE)

/* Gates off, or as they are, and nothing to start. */
#define OFF  ((uint32_t)GATES_OFF)
#define KEEP ((uint32_t)GATES_KEEP)

sequence_tuning_t sequence_prepare(const params_t *params)
{
    return (sequence_tuning_t){
        .dc_undervoltage = params->dc_undervoltage,
        .charge_periods = DRIVE_CHARGE_PERIODS,
        .stop_periods = DRIVE_PERIODS(params->fault_stop_time),
        .retries = (uint32_t)params->module_fault_retries,
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
    sequence->coming_on = 0u;
    sequence->retry_periods = 0u;
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
    return sequence->quiet_periods >= REARM_PERIODS;
}

/* What keeps a fault from being reset now: the first of what still holds, the module's line, or that it is
 * not long gone. */
static int32_t present(const sequence_t *sequence, const sequence_input_t *input)
{
    const fault_set_t holding = fault_set_both(input->faults, input->stops);
    if (fault_set_any(holding)) {
        return guard_reason(holding);
    }
    return (input->measured->flags & DRIVE_SAMPLE_FAULT_LINE) != 0u ? (int32_t)REASON_MODULE_FAULT
                                                                    : sequence->fault_reason;
}

/* A fault of the power module that has gone resets itself after a pause, so many times as the set allows. */
static bool retries(sequence_t *sequence, const sequence_input_t *input)
{
    if (sequence->fault_reason != (int32_t)REASON_MODULE_FAULT ||
        input->requests->enable != (int32_t)REQUEST_ON || sequence->retried >= sequence->tuning.retries) {
        return false;
    }
    sequence->retry_periods++;
    if (sequence->retry_periods < RETRY_PERIODS || !rearmed(sequence)) {
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
        sequence->held = reset && input->requests->enable == (int32_t)REQUEST_ON ? UINT32_C(1) : UINT32_C(0);
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
    }
    return OFF;
}

/* Does more current flow than offsets and noise show? */
static bool current_flows(const sequence_input_t *input)
{
    const ab_t i = input->measured->current;
    return i.alpha * i.alpha + i.beta * i.beta > DIODE_CURRENT * DIODE_CURRENT;
}

static int32_t why_not_on(const sequence_t *sequence, const sequence_input_t *input)
{
    if (sequence->held != 0u) {
        return REASON_ENABLE_HELD;
    }
    if (!rearmed(sequence)) {
        return REASON_FAULT_PRESENT;
    }
    if (input->measured->u_dc < sequence->tuning.dc_undervoltage) {
        return REASON_DC_UNDERVOLTAGE;
    }
    if (input->calibration == CALIBRATION_FAILED) {
        return REASON_CURRENT_OFFSET;
    }
    if (current_flows(input)) {
        return REASON_ROTOR_TOO_FAST;
    }
    return input->calibration == CALIBRATION_DUE ? REASON_NOT_READY : REASON_NONE;
}

/* What goes out while the gates come on and are charged. */
static uint32_t charge(const sequence_t *sequence)
{
    return sequence->tuning.charge_periods != 0u ? SEQUENCE_CHARGE : 0u;
}

static uint32_t in_ready(sequence_t *sequence, const sequence_input_t *input)
{
    uint32_t order = OFF;
    if (input->requests->enable == (int32_t)REQUEST_ON) {
        sequence->refusal = why_not_on(sequence, input);
        if (sequence->refusal == (int32_t)REASON_NONE) {
            order |= SEQUENCE_PRESET | charge(sequence);
            enter(sequence, DRIVE_SWITCHED_ON);
        }
    }
    return order;
}

/* First period: the first duties go out; second: the gates come on with them; third: they must. Where the
 * upper gates get their supply through the lower switches, those alone are on for charge_periods then; and
 * the gates come on a period later, for a pulse that a duty of zero finds begun is ended by the one after. A
 * rotor that turns is shorted by that: where current flows, control takes over at once, in whose zero vectors
 * the charging goes on. */
static uint32_t in_switched_on(sequence_t *sequence, const sequence_input_t *input)
{
    if (input->requests->enable != (int32_t)REQUEST_ON) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    const uint32_t charges = charge(sequence);
    const uint32_t on = charges != 0u ? UINT32_C(2) : UINT32_C(1);
    sequence->coming_on++;
    if (sequence->coming_on <= on) {
        return (sequence->coming_on == on ? (uint32_t)GATES_ON : OFF) | charges;
    }
    if ((input->measured->flags & DRIVE_SAMPLE_TRIPPED) != 0u) {
        sequence_fault(sequence, REASON_GATES_REFUSED);
        return OFF;
    }
    if (sequence->coming_on <= on + sequence->tuning.charge_periods && !current_flows(input)) {
        return KEEP | charges;
    }
    enter(sequence, DRIVE_OPERATION_ENABLED);
    return KEEP | SEQUENCE_PRESET | SEQUENCE_TRACK;
}

static uint32_t in_operation(sequence_t *sequence, const sequence_input_t *input)
{
    if (input->requests->enable == (int32_t)REQUEST_OFF) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    if (input->requests->enable == (int32_t)REQUEST_QUICK_STOP) {
        enter(sequence, DRIVE_QUICK_STOP);
    }
    if (sequence->retried != 0u) {
        sequence->retry_periods++;
        sequence->retried = sequence->retry_periods < FORGET_PERIODS ? sequence->retried : 0u;
    }
    return KEEP;
}

static uint32_t in_quick_stop(sequence_t *sequence, const sequence_input_t *input)
{
    const bool for_fault = sequence->stop_reason != (int32_t)REASON_NONE;
    const bool asked_off = input->requests->enable == (int32_t)REQUEST_OFF;
    sequence->stopping++;
    if (for_fault && (asked_off || input->standing || sequence->stopping >= sequence->tuning.stop_periods)) {
        sequence_fault(sequence, sequence->stop_reason);
        return OFF;
    }
    if (asked_off) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    if (input->standing) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    if (input->requests->enable == (int32_t)REQUEST_ON) { /* what has begun is brought to its end */
        sequence->refusal = for_fault ? sequence->stop_reason : (int32_t)REASON_STOPPING;
    }
    return KEEP;
}

/* A fault that asks for a stop: the motor brakes, if it runs. Of several the first counts. */
static uint32_t stop(sequence_t *sequence, const sequence_input_t *input)
{
    if (sequence->state < (int32_t)DRIVE_OPERATION_ENABLED) {
        sequence_fault(sequence, guard_reason(input->stops));
        return OFF;
    }
    sequence->stop_reason = guard_reason(input->stops);
    sequence->stopping = 0u;
    enter(sequence, DRIVE_QUICK_STOP);
    return KEEP;
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
    sequence->quiet_periods = quiet ? sequence->quiet_periods + (rearmed(sequence) ? 0u : 1u) : 0u;
    sequence->refusal = REASON_NONE;
    if (input->requests->enable == (int32_t)REQUEST_OFF) {
        sequence->held = 0u;
        sequence->retried = 0u;
    }

    if (sequence->state == (int32_t)DRIVE_FAULT) {
        return in_fault(sequence, input, reset_edge);
    }
    if (fault) {
        sequence_fault(sequence, guard_reason(input->faults));
        return OFF;
    }
    if (fault_set_any(input->stops) && sequence->stop_reason == (int32_t)REASON_NONE) {
        return stop(sequence, input);
    }
    return in_state(sequence, input);
}
