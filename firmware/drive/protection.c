#include "drive/protection.h"

#include "drive/params.h"
#include "drive/reasons.h"

typedef struct {
    int32_t reason;
    uint32_t debounce; /* [periods] */
} fault_row_t;

/* Gravest first. A current over its limit or a trip stops at once; what is slow by nature may take its time,
 * so that one disturbed conversion does not stop a drive. */
static const fault_row_t faults[PROTECTION_FAULTS] = {
    {REASON_MODULE_FAULT, 1},
    {REASON_OVERCURRENT, 1},
    {REASON_BAD_SAMPLE, 3},
    {REASON_DC_OVERVOLTAGE, 2},
    {REASON_OVERSPEED, DRIVE_PERIODS(1e-3f)},
    {REASON_LATE, 3},
    {REASON_DC_UNDERVOLTAGE, DRIVE_PERIODS(1e-3f)},
    {REASON_ENCODER_PHASE, 1},
    {REASON_SINK_HOT, DRIVE_PERIODS(0.1f)},
    {REASON_MOTOR_HOT, DRIVE_PERIODS(0.1f)},
    {REASON_ESTIMATE_AMPLITUDE, 1},
    {REASON_ESTIMATE_DETECTOR, 1},
    {REASON_ESTIMATE_CURRENT, 1},
    {REASON_ESTIMATE_SPEED, 1},
};

void protection_retune(protection_t *protection, const protection_limits_t *limits)
{
    protection->limits = *limits;
}

void protection_reset(protection_t *protection)
{
    protection->counting = 0;
    for (uint16_t n = 0; n < PROTECTION_FAULTS; n++) {
        protection->run[n] = 0;
    }
}

void protection_init(protection_t *protection, const protection_limits_t *limits)
{
    protection_retune(protection, limits);
    protection_reset(protection);
}

static uint32_t beyond(float value, float limit)
{
    return value > limit || value < -limit;
}

uint32_t protection_step(protection_t *protection, const protection_input_t *input)
{
    const protection_limits_t *limits = &protection->limits;
    const uint32_t on = input->bridge_on;
    /* In the order of the fault table. */
    const uint32_t present =
        (input->tripped & on) |
        (beyond(input->current.a, limits->overcurrent) | beyond(input->current.b, limits->overcurrent) |
         beyond(input->current.c, limits->overcurrent))
            << 1 |
        input->bad_sample << 2 | (uint32_t)(input->u_dc > limits->overvoltage) << 3 |
        (beyond(input->omega_m, limits->overspeed) & on) << 4 | (input->late & on) << 5 |
        ((uint32_t)(input->u_dc < limits->undervoltage) & on) << 6 | (input->encoder_error & on) << 7 |
        (uint32_t)(input->sink_temperature > limits->sink_temperature_max) << 8 |
        (uint32_t)(input->motor_temperature > limits->motor_temperature_max) << 9 |
        (on != 0u ? input->estimate << 10 : 0u);

    /* Nothing there and nothing counted: the way of almost every period. */
    if ((present | protection->counting) == 0u) {
        return 0u;
    }
    uint32_t failed = 0;
    for (uint16_t n = 0; n < PROTECTION_FAULTS; n++) {
        const uint32_t run = ((present >> n) & 1u) != 0u ? protection->run[n] + 1u : 0u;
        const uint32_t held = run >= faults[n].debounce;
        protection->run[n] = held ? faults[n].debounce : run;
        failed |= held << n;
    }
    protection->counting = present;
    return failed;
}

int32_t protection_reason(uint32_t failed)
{
    for (uint16_t n = 0; n < PROTECTION_FAULTS; n++) {
        if (((failed >> n) & 1u) != 0u) {
            return faults[n].reason;
        }
    }
    return REASON_NONE;
}

uint32_t protection_debounce(int32_t reason)
{
    for (uint16_t n = 0; n < PROTECTION_FAULTS; n++) {
        if (faults[n].reason == reason) {
            return faults[n].debounce;
        }
    }
    return 0;
}
