#include "app/app.h"

HAL_PER_CHIP app_t *app;

static uint32_t drive_flags(uint16_t hal_flags)
{
    return ((hal_flags & HAL_FLAG_TRIPPED) != 0u ? DRIVE_SAMPLE_TRIPPED : 0u) |
           ((hal_flags & HAL_FLAG_FAULT_PIN) != 0u ? DRIVE_SAMPLE_FAULT_LINE : 0u) |
           ((hal_flags & HAL_FLAG_ENCODER) != 0u ? DRIVE_SAMPLE_ENCODER : 0u) |
           ((hal_flags & HAL_FLAG_LATE) != 0u ? DRIVE_SAMPLE_LATE : 0u) |
           ((hal_flags & HAL_FLAG_NOT_ENABLED) != 0u ? DRIVE_SAMPLE_NOT_ENABLED : 0u);
}

static float current_of(uint16_t code)
{
    return ((float)code + BOARD_HALF_CODE) * BOARD_CURRENT_PER_CODE + BOARD_CURRENT_AT_0V;
}

/* The value of a sensor that is linear from 0 to 3 V. */
#define TEMPERATURE_OF(code, at_0v, at_3v)                                                                   \
    (((float)(code) + BOARD_HALF_CODE) * (((float)(at_3v) - (float)(at_0v)) / (float)BOARD_ADC_FULL) +       \
     (float)(at_0v))

#if BOARD_SINK_INPUT == BOARD_NONE
#define SINK_OF(code) DRIVE_NO_TEMPERATURE
#else
#define SINK_OF(code) TEMPERATURE_OF(code, BOARD_SINK_AT_0V, BOARD_SINK_AT_3V)
#endif
#if BOARD_MOTOR_INPUT == BOARD_NONE
#define MOTOR_OF(code) DRIVE_NO_TEMPERATURE
#else
#define MOTOR_OF(code) TEMPERATURE_OF(code, BOARD_MOTOR_AT_0V, BOARD_MOTOR_AT_3V)
#endif

static inline void convert(const hal_samples_t *counts, drive_samples_t *samples)
{
    samples->i_a = current_of(counts->current_a);
    samples->i_b = current_of(counts->current_b);
#if BOARD_CURRENT_SENSORS == 3
    samples->i_c = current_of(counts->current_c);
#else
    samples->i_c = -(samples->i_a + samples->i_b);
#endif
    samples->u_dc = ((float)counts->dc_link + BOARD_HALF_CODE) * BOARD_DC_PER_CODE;
    samples->sink_temperature = SINK_OF(counts->sink_temperature);
    samples->motor_temperature = MOTOR_OF(counts->motor_temperature);
    samples->encoder = counts->encoder;
    samples->flags = drive_flags(counts->flags);
}

#define CODE_BITS  12u
#define FLAGS_AT   24u
#define COUNT_AT   24u
#define CODE_MASK  UINT32_C(0xFFF)
#define COUNT_MASK UINT32_C(0xFF)
#define FLAGS_MASK UINT32_C(0x1F)

/* The slots of drive/record.h. */
static inline void pack(const hal_samples_t *counts, uint32_t codes[RECORD_CODES])
{
    codes[0] =
        counts->current_a | (uint32_t)counts->current_b << CODE_BITS | (uint32_t)counts->flags << FLAGS_AT;
    codes[1] = counts->current_c | (uint32_t)counts->dc_link << CODE_BITS | counts->encoder << COUNT_AT;
    codes[2] = counts->sink_temperature | (uint32_t)counts->motor_temperature << CODE_BITS |
               counts->encoder >> 8 << COUNT_AT;
}

void app_read(drive_samples_t *samples)
{
    hal_samples_t counts;
    hal_read(&counts);
    convert(&counts, samples);
    pack(&counts, samples->codes);
}

void app_read_again(const uint32_t codes[RECORD_CODES], drive_samples_t *samples)
{
    const hal_samples_t counts = {
        .current_a = (uint16_t)(codes[0] & CODE_MASK),
        .current_b = (uint16_t)(codes[0] >> CODE_BITS & CODE_MASK),
        .current_c = (uint16_t)(codes[1] & CODE_MASK),
        .dc_link = (uint16_t)(codes[1] >> CODE_BITS & CODE_MASK),
        .sink_temperature = (uint16_t)(codes[2] & CODE_MASK),
        .motor_temperature = (uint16_t)(codes[2] >> CODE_BITS & CODE_MASK),
        .flags = (uint16_t)(codes[0] >> FLAGS_AT & FLAGS_MASK),
        .encoder = codes[1] >> COUNT_AT | (codes[2] >> COUNT_AT & COUNT_MASK) << 8,
    };
    convert(&counts, samples);
    pack(&counts, samples->codes);
}

static uint16_t compare_of(float duty)
{
    return (uint16_t)(duty * (float)HAL_PERIOD_COUNT + 0.5f);
}

void app_write(const drive_command_t *command)
{
    hal_write_compare(compare_of(command->duty.a), compare_of(command->duty.b), compare_of(command->duty.c));
    switch ((drive_gates_t)command->gates) {
    case GATES_ON:
        (void)hal_gates_on(); /* the flags of the next sample show whether the gates are on */
        break;
    case GATES_OFF:
        hal_gates_off();
        break;
    case GATES_KEEP:
        break;
    }
    hal_outputs((command->outputs & DRIVE_OUTPUT_CHOPPER) != 0u,
                (command->outputs & DRIVE_OUTPUT_BRAKE) != 0u);
    hal_end_of_sample();
}

HAL_INTERRUPT void app_interrupt(void)
{
    drive_samples_t samples;
    drive_command_t command;
    const uint32_t begin = hal_time();
    app_read(&samples);
    if (drive_step(&app->drive, &samples, &command)) {
        hal_request_medium();
    }
    daq_sample(&app->talk.daq, &app->drive, app->drive.fast.period);
    talk_exchange();
    drive_took(&app->drive.fast_took, hal_time() - begin);
    app_write(&command);
}

HAL_INTERRUPT void app_medium(void)
{
    hal_begin_medium();
    const uint32_t begin = hal_time();
    drive_medium_step(&app->drive);
    drive_medium_took(&app->drive, hal_time() - begin);
    hal_end_medium();
}

HAL_INTERRUPT void app_serial(void)
{
    talk_receive();
    hal_end_of_serial();
}

HAL_INTERRUPT void app_trip(void)
{
    drive_trip(&app->drive);
    hal_end_of_trip();
}
