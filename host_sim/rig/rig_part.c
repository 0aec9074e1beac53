/* The drive alone and the plant alone (rig_part.h). */
#include <string.h>

#include "hal/f28335/pwm.h"
#include "host_sim/rig/rig_parts.h"

/* ---- the rows ---- */

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, text)                                                   \
    {id,  SLOT_FLOAT, TABLE_LIVE, offsetof(rig_exchange_t, name), #name, unit, text, "", initial,            \
     min, max,        {0, 0, 0}},
#define ROW_WHOLE(id, name, unit, initial, max, text)                                                        \
    {id,   SLOT_INT, TABLE_LIVE,       offsetof(rig_exchange_t, name), #name, unit, text, "", 0.0f,          \
     0.0f, 0.0f,     {initial, 0, max}},
#define ROW_ENUM(id, name, choices, text)                                                                    \
    {id,   SLOT_ENUM, TABLE_LIVE, offsetof(rig_exchange_t, name), #name, "-", text, choices, 0.0f,           \
     0.0f, 0.0f,      {0, 0, 0}},
    RIG_COMMAND(ROW_FLOAT, ROW_WHOLE, ROW_ENUM) RIG_SAMPLE(ROW_FLOAT, ROW_WHOLE, ROW_ENUM)
#undef ROW_FLOAT
#undef ROW_WHOLE
#undef ROW_ENUM
};
static const table_t table = {"exchange", rows, sizeof rows / sizeof rows[0]};

const table_t *rig_exchange_table(void)
{
    return &table;
}

bool rig_exchange_is_command(const table_row_t *row)
{
    return row->offset < offsetof(rig_exchange_t, sample_i_a);
}

double rig_exchange_get(const rig_t *rig, const table_row_t *row)
{
    return rig_row_get(row, &rig->cut.exchange);
}

void rig_exchange_set(rig_t *rig, const table_row_t *row, double value)
{
    rig_row_put(row, &rig->cut.exchange, value);
}

/* [ticks] of a time in a period; a negative one is 0. */
static uint64_t ticks_of(float seconds)
{
    return seconds > 0.0f ? (uint64_t)((double)seconds * (double)CHIP_TICKS_PER_SECOND + 0.5) : 0u;
}

/* [ticks] begin of the present period. */
static uint64_t period_begin(const rig_t *rig)
{
    return rig->state.start + RIG_PERIOD_TICKS * rig->state.period;
}

static float seconds_of(uint64_t ticks)
{
    return (float)((double)ticks / (double)CHIP_TICKS_PER_SECOND);
}

/* ---- the drive ---- */

/* Whether its own interrupt was late, only the drive knows. */
void rig_part_take(const rig_t *rig, drive_samples_t *samples)
{
    const rig_exchange_t *from = &rig->cut.exchange;
    samples->i_a = from->sample_i_a;
    samples->i_b = from->sample_i_b;
    samples->i_c = from->sample_i_c;
    samples->u_dc = from->sample_u_dc;
    samples->sink_temperature = from->sample_sink_temperature;
    samples->motor_temperature = from->sample_motor_temperature;
    samples->encoder = (uint32_t)from->sample_encoder;
    samples->flags = (samples->flags & DRIVE_SAMPLE_LATE) |
                     (from->sample_tripped != 0 ? DRIVE_SAMPLE_TRIPPED : 0u) |
                     (from->sample_fault_line != 0 ? DRIVE_SAMPLE_FAULT_LINE : 0u) |
                     (from->sample_encoder_error != 0 ? DRIVE_SAMPLE_ENCODER : 0u) |
                     (from->sample_late != 0 ? DRIVE_SAMPLE_LATE : 0u) |
                     (from->sample_not_enabled != 0 ? DRIVE_SAMPLE_NOT_ENABLED : 0u);
}

void rig_part_give(rig_t *rig, const drive_command_t *command)
{
    rig_exchange_t *to = &rig->cut.exchange;
    to->command_duty_a = command->duty.a;
    to->command_duty_b = command->duty.b;
    to->command_duty_c = command->duty.c;
    to->command_gates = command->gates;
    to->command_chopper = (command->outputs & DRIVE_OUTPUT_CHOPPER) != 0u;
    to->command_brake = (command->outputs & DRIVE_OUTPUT_BRAKE) != 0u;
    to->command_time = seconds_of(chip_now(&rig->state.chip) - period_begin(rig));
    to->command_dead_time = rig->state.app.active.dead_time;
    to->command_encoder_lines = rig->state.app.active.encoder_lines;
}

/* The trip interrupt comes where the module has tripped; if that is not known, at the begin of the period. */
static void step_drive(rig_t *rig)
{
    const rig_exchange_t *exchange = &rig->cut.exchange;
    const uint64_t trip = ticks_of(exchange->trip_time);
    rig->cut.exchange.command_time = -1.0f;
    rig->cut.exchange.command_gates = (int32_t)GATES_KEEP;
    rig_bind(rig);
    chip_set_pin(&rig->state.chip, PWM_FAULT_PIN, exchange->sample_fault_line == 0);
    if (trip > 0u && trip < RIG_PERIOD_TICKS) {
        rig_step_part(rig, trip);
        chip_set_pin(&rig->state.chip, PWM_FAULT_PIN, false);
    }
    rig_step(rig);
}

/* ---- the plant ---- */

static void take_sample(rig_t *rig)
{
    drive_samples_t samples;
    rig_exchange_t *to = &rig->cut.exchange;
    app_read(&samples);
    if (rig->state.conditions.sensors != 0) {
        rig_exact_samples(&rig->state, &samples);
    }
    to->sample_i_a = samples.i_a;
    to->sample_i_b = samples.i_b;
    to->sample_i_c = samples.i_c;
    to->sample_u_dc = samples.u_dc;
    to->sample_sink_temperature = samples.sink_temperature;
    to->sample_motor_temperature = samples.motor_temperature;
    to->sample_encoder = (int32_t)samples.encoder;
    to->sample_tripped = (samples.flags & DRIVE_SAMPLE_TRIPPED) != 0u;
    to->sample_fault_line = (samples.flags & DRIVE_SAMPLE_FAULT_LINE) != 0u;
    to->sample_encoder_error = (samples.flags & DRIVE_SAMPLE_ENCODER) != 0u;
    to->sample_late = (samples.flags & DRIVE_SAMPLE_LATE) != 0u;
    to->sample_not_enabled = (samples.flags & DRIVE_SAMPLE_NOT_ENABLED) != 0u;
    rig->cut.waits = 1u;
}

/* The sample interrupt reads, and ends with the command. The trip interrupt has no work here. */
static void on_interrupt(void *context, uint32_t vector, void (*function)(void))
{
    rig_t *rig = context;
    if (vector == PIE_SEQ1INT) {
        take_sample(rig);
        return;
    }
    function();
}

/* Parameters that the program writes to registers while the gates are off. */
static void write_settings(rig_t *rig)
{
    const rig_exchange_t *from = &rig->cut.exchange;
    app_t *to = &rig->state.app;
    params_error_t why;
    const bool changed = from->command_dead_time != to->active.dead_time ||
                         from->command_encoder_lines != to->active.encoder_lines;
    if (changed && pwm_all_tripped()) {
        to->staged.dead_time = from->command_dead_time;
        to->staged.encoder_lines = from->command_encoder_lines;
        if (!app_apply(&why)) {
            to->staged = to->active;
        }
    }
}

static void write_command(rig_t *rig)
{
    const rig_exchange_t *from = &rig->cut.exchange;
    const uint64_t at = period_begin(rig) + ticks_of(from->command_time);
    const drive_command_t command = {
        .duty = {from->command_duty_a, from->command_duty_b, from->command_duty_c},
        .gates = from->command_gates,
        .outputs = (from->command_chopper != 0 ? DRIVE_OUTPUT_CHOPPER : 0u) |
                   (from->command_brake != 0 ? DRIVE_OUTPUT_BRAKE : 0u),
    };
    rig->cut.waits = 0u;
    rig_bind(rig);
    if (at > chip_now(&rig->state.chip)) {
        rig_pass(rig, at);
        chip_look(&rig->state.chip);
    }
    write_settings(rig);
    app_write(&command);
    hal_watchdog_feed();
}

static void step_plant(rig_t *rig)
{
    const uint64_t begin = period_begin(rig);
    const uint64_t from = chip_now(&rig->state.chip);
    if (rig->cut.waits != 0u) {
        write_command(rig);
    }
    rig_step(rig);
    rig->cut.exchange.trip_time = rig->cut.tripped > from ? seconds_of(rig->cut.tripped - begin) : -1.0f;
}

void rig_part_sample(rig_t *rig)
{
    if (rig->cut.part == (int32_t)RIG_PLANT && rig->cut.waits == 0u) {
        rig_step_part(rig, RIG_PERIOD_TICKS);
    }
}

/* ---- both ---- */

void rig_part_cut(rig_t *rig, rig_part_t part)
{
    rig_cut_t *cut = &rig->cut;
    const params_t *params = &rig->state.app.active;
    table_defaults(&table, &cut->exchange);
    cut->part = (int32_t)part;
    cut->exchange.command_dead_time = params->dead_time;
    cut->exchange.command_encoder_lines = params->encoder_lines;
    if (part == RIG_DRIVE) {
        rig->world.analog = chip_unconnected.analog;
        rig->world.gates = chip_unconnected.gates;
        rig->world.carrier = chip_unconnected.carrier;
    }
    if (part == RIG_PLANT) {
        rig->world.interrupt = on_interrupt;
    }
}

void rig_part_step(rig_t *rig)
{
    switch ((rig_part_t)rig->cut.part) {
    case RIG_RING:
        rig_step(rig);
        break;
    case RIG_DRIVE:
        step_drive(rig);
        break;
    case RIG_PLANT:
        step_plant(rig);
        break;
    }
}

size_t rig_part_state_size(void)
{
    return sizeof(rig_cut_t);
}

void rig_part_save(const rig_t *rig, void *state)
{
    memcpy(state, &rig->cut, sizeof rig->cut);
}

void rig_part_load(rig_t *rig, const void *state)
{
    memcpy(&rig->cut, state, sizeof rig->cut);
}
