#include "drive/sequence.h"

#include <string.h>

#include "drive/guard.h"
#include "drive/reasons.h"

#define REARM_PERIODS DRIVE_PERIODS(20e-3f) /* without a fault or its line before a reset or a start */

/* A phase current that no gate drives: the rotor feeds the link through the diodes [A]. */
#define DIODE_CURRENT (0.02f * DRIVE_CURRENT_RANGE)

/* Gates off, or as they are, and nothing to start. */
#define OFF  ((uint32_t)GATES_OFF)
#define KEEP ((uint32_t)GATES_KEEP)

/* What the machine decides by, of one period. */
typedef struct {
    const requests_t *requests;
    const measured_t *measured;
    uint32_t faults; /* [-] bits of the fault table that open the bridge */
    bool standing;   /* the rotor is known to stand */
    calibration_t calibration;
} input_t;

sequence_tuning_t sequence_prepare(const params_t *params)
{
    return (sequence_tuning_t){
        .dc_undervoltage = params->dc_undervoltage,
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
}

void sequence_fault(sequence_t *sequence, int32_t reason)
{
    sequence->fault_reason = reason;
    sequence->faults_later = 0u;
    enter(sequence, DRIVE_FAULT);
}

static bool rearmed(const sequence_t *sequence)
{
    return sequence->quiet_periods >= REARM_PERIODS;
}

static uint32_t in_fault(sequence_t *sequence, const input_t *input, bool reset_edge)
{
    if (input->faults != 0u) {
        sequence->faults_later |= input->faults & ~guard_fault_of(sequence->fault_reason);
    }
    sequence->refusal = input->requests->enable == (int32_t)REQUEST_OFF ? REASON_NONE : REASON_FAULT_LATCHED;
    if (reset_edge && rearmed(sequence)) {
        sequence->fault_reason = REASON_NONE;
        enter(sequence, DRIVE_NOT_READY);
    } else if (reset_edge || !rearmed(sequence)) {
        sequence->refusal = REASON_FAULT_PRESENT;
    }
    return OFF;
}

static uint32_t in_not_ready(sequence_t *sequence, const input_t *input)
{
    sequence->refusal = input->requests->enable == (int32_t)REQUEST_OFF ? REASON_NONE : REASON_NOT_READY;
    if (input->calibration == CALIBRATION_GOOD) {
        enter(sequence, DRIVE_READY);
    } else if (input->calibration == CALIBRATION_FAILED) {
        sequence_fault(sequence, REASON_CURRENT_OFFSET);
    }
    return OFF;
}

static int32_t why_not_on(const sequence_t *sequence, const input_t *input)
{
    if (!rearmed(sequence)) {
        return REASON_FAULT_PRESENT;
    }
    if (input->measured->u_dc < sequence->tuning.dc_undervoltage) {
        return REASON_DC_UNDERVOLTAGE;
    }
    const ab_t i = input->measured->current;
    return i.alpha * i.alpha + i.beta * i.beta > DIODE_CURRENT * DIODE_CURRENT ? REASON_ROTOR_TOO_FAST
                                                                               : REASON_NONE;
}

static uint32_t in_ready(sequence_t *sequence, const input_t *input)
{
    uint32_t order = OFF;
    if (input->requests->enable == (int32_t)REQUEST_ON && sequence->stopped == 0u) {
        sequence->refusal = why_not_on(sequence, input);
        if (sequence->refusal == (int32_t)REASON_NONE) {
            order |= SEQUENCE_PRESET;
            enter(sequence, DRIVE_SWITCHED_ON);
        }
    }
    return order;
}

/* First period: the first duties go out; second: the gates come on with them; third: they
 * must. */
static uint32_t in_switched_on(sequence_t *sequence, const input_t *input)
{
    if (input->requests->enable != (int32_t)REQUEST_ON) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    sequence->coming_on++;
    if (sequence->coming_on < 2u) {
        return (uint32_t)GATES_ON;
    }
    if ((input->measured->flags & DRIVE_SAMPLE_TRIPPED) != 0u) {
        sequence_fault(sequence, REASON_GATES_REFUSED);
        return OFF;
    }
    enter(sequence, DRIVE_OPERATION_ENABLED);
    return KEEP | SEQUENCE_PRESET | SEQUENCE_TRACK;
}

static uint32_t in_operation(sequence_t *sequence, const input_t *input)
{
    if (input->requests->enable == (int32_t)REQUEST_OFF) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    if (input->requests->enable == (int32_t)REQUEST_QUICK_STOP) {
        enter(sequence, DRIVE_QUICK_STOP);
    }
    return KEEP;
}

static uint32_t in_quick_stop(sequence_t *sequence, const input_t *input)
{
    if (input->requests->enable == (int32_t)REQUEST_OFF) {
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    if (input->standing) {
        sequence->stopped = 1u;
        enter(sequence, DRIVE_READY);
        return OFF;
    }
    return KEEP;
}

static uint32_t in_state(sequence_t *sequence, const input_t *input)
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

uint32_t sequence_step(sequence_t *sequence, const requests_t *requests, const measured_t *measured,
                       uint32_t faults, bool standing, calibration_t calibration)
{
    const input_t input = {requests, measured, faults, standing, calibration};
    const int32_t reset = requests->fault_reset;
    const bool reset_edge = reset != 0 && sequence->fault_reset_seen == 0;
    const bool quiet = faults == 0u && (measured->flags & DRIVE_SAMPLE_FAULT_LINE) == 0u;
    sequence->fault_reset_seen = reset;
    sequence->quiet_periods = quiet ? sequence->quiet_periods + (rearmed(sequence) ? 0u : 1u) : 0u;
    sequence->refusal = REASON_NONE;
    if (requests->enable == (int32_t)REQUEST_OFF) {
        sequence->stopped = 0u;
    }

    if (sequence->state == (int32_t)DRIVE_FAULT) {
        return in_fault(sequence, &input, reset_edge);
    }
    if (faults != 0u) {
        sequence_fault(sequence, guard_reason(faults));
        return OFF;
    }
    return in_state(sequence, &input);
}
