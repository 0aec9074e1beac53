/* Simulates properties of the software on the chip: the time that it takes, ideal sensors, and when the
 * background runs.
 *
 * The sample interrupt reads at its entry and writes when its time is over: this time passes at the drive's
 * step, between the two. The medium task computes at its begin. Its results are available when its time is
 * over; interrupts during this time make it longer. */
#include "app/talk.h"
#include "host_sim/rig/rig_parts.h"

#define LINE_OCTETS 256u /* at most, a call */

/* The rig whose chip and application run on this thread: for the interrupts, which get no argument. */
static __thread rig_t *bound;

/* ---- a serial link that does not use the chip; one octet per word, as in the HAL ---- */

static uint32_t line_read(uint16_t *octets, uint32_t room)
{
    uint8_t taken[LINE_OCTETS];
    const uint32_t count =
        bound->line.read(bound->line.context, taken, room < LINE_OCTETS ? room : LINE_OCTETS);
    for (uint32_t n = 0; n < count; n++) {
        octets[n] = taken[n];
    }
    return count;
}

static uint32_t line_write(const uint16_t *octets, uint32_t count)
{
    uint8_t given[LINE_OCTETS];
    const uint32_t most = count < LINE_OCTETS ? count : LINE_OCTETS;
    for (uint32_t n = 0; n < most; n++) {
        given[n] = (uint8_t)(octets[n] & 0xffu);
    }
    return bound->line.write(bound->line.context, given, most);
}

static const talk_line_t desk_line = {line_read, line_write};

void rig_line(rig_t *rig, const rig_line_t *line)
{
    const rig_line_t none = {0};
    rig->line = line != NULL ? *line : none;
}

void rig_software_bind(rig_t *rig)
{
    bound = rig;
    talk_line = rig->line.read != NULL ? &desk_line : NULL;
}

/* [ticks] of this number of cycles times the factor of a row. */
static uint64_t ticks_of(uint32_t cycles, float factor)
{
    return (uint64_t)((double)cycles * (double)factor * (150e6 / (double)BOARD_SYSCLK_HZ) + 0.5);
}

static void take_time(rig_t *rig, uint64_t ticks)
{
    if (ticks != 0u) {
        rig_pass(rig, chip_now(&rig->state.chip) + ticks);
        chip_look(&rig->state.chip);
    }
}

void rig_exact_samples(const rig_state_t *state, drive_samples_t *samples)
{
    const rig_truth_t *truth = &state->truth;
    const float i[3] = {truth->true_i_a, truth->true_i_b, truth->true_i_c};
    const uint32_t *wire = state->plant.wire; /* the sensors are before the exchanged wires */
    samples->i_a = i[wire[0]];
    samples->i_b = i[wire[1]];
    samples->i_c = i[wire[2]];
    samples->u_dc = truth->true_u_dc;
}

/* Of ideal sensors: the drive subtracts the offsets that it has measured with the real ones. They are added
 * here, so that the choice of the sensors may change at any later time. */
static void add_offsets(const drive_t *drive, drive_samples_t *samples)
{
    const bool measuring = drive->state == (int32_t)DRIVE_NOT_READY;
    samples->i_a += measuring ? 0.0f : drive->fast.measure.offset.a;
    samples->i_b += measuring ? 0.0f : drive->fast.measure.offset.b;
    samples->i_c += measuring ? 0.0f : drive->fast.measure.offset.c;
}

/* The medium task has ended: from here on fast task and background get its results and its duration. */
static void end_medium(rig_state_t *state)
{
    if (state->medium_until != 0u && chip_now(&state->chip) >= state->medium_until) {
        const double seconds = (double)(state->medium_until - state->medium_begin) / 150e6;
        drive_medium_took(&state->app.drive, (uint32_t)(seconds * (double)BOARD_SYSCLK_HZ + 0.5));
        state->medium_until = 0u;
        state->app.drive.done = state->medium_done;
        state->app.drive.opens = state->medium_opens;
    }
}

void desk_drive_medium_step(drive_t *drive)
{
    rig_state_t *state = &bound->state;
    const uint64_t ticks = ticks_of(RIG_MEDIUM_CYCLES, state->conditions.medium_time);
    const uint32_t done = drive->done;
    const int32_t opens = drive->opens;
    drive_medium_step(drive);
    if (ticks != 0u) {
        state->medium_begin = chip_now(&state->chip);
        state->medium_until = state->medium_begin + ticks;
        state->medium_done = drive->done;
        state->medium_opens = drive->opens;
        drive->done = done;
        drive->opens = opens;
    }
}

/* The duration of a task is set when its time has passed. */
void desk_drive_medium_took(drive_t *drive, uint32_t cycles)
{
    if (bound->state.medium_until == 0u) {
        drive_medium_took(drive, cycles);
    }
}

bool desk_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    rig_state_t *state = &bound->state;
    if (bound->replay.on) {
        bound->replay.due = drive_step(drive, &bound->replay.samples, command);
        return false;
    }
    drive_samples_t taken = *samples;
    end_medium(state);
    if (bound->cut.part == (int32_t)RIG_DRIVE) {
        rig_part_take(bound, &taken);
    } else if (state->conditions.sensors != 0) {
        rig_exact_samples(state, &taken);
    }
    if (state->conditions.sensors != 0) {
        add_offsets(drive, &taken);
    }
    const bool due = drive_step(drive, &taken, command);
    const uint64_t ticks = ticks_of(RIG_INTERRUPT_CYCLES, state->conditions.interrupt_time);
    state->medium_until += state->medium_until != 0u ? ticks : 0u;
    rig_timing_pause(bound);
    take_time(bound, ticks);
    rig_timing_go_on(bound);
    if (bound->cut.part == (int32_t)RIG_DRIVE) {
        rig_part_give(bound, command);
    }
    return due;
}

uint64_t rig_section(void *context)
{
    const rig_t *rig = context;
    return ticks_of(RIG_SECTION_CYCLES, rig->state.conditions.section_time);
}

bool rig_background_is_free(const rig_t *rig)
{
    const rig_state_t *state = &rig->state;
    const uint64_t now = chip_now(&state->chip);
    return rig->cut.part != (int32_t)RIG_PLANT && !chip_halted(&state->chip) &&
           !chip_debug_halted(&state->chip) && now >= state->background_next &&
           now >= state->chip.cpu.busy_until && now >= state->medium_until;
}

bool rig_background(rig_t *rig)
{
    rig_state_t *state = &rig->state;
    const uint64_t now = chip_now(&state->chip);
    if (!rig_background_is_free(rig)) {
        return false;
    }
    end_medium(state);
    state->background_next = now + (uint64_t)((double)state->conditions.background_time * 150e6 + 0.5);
    app_background();
    return true;
}
