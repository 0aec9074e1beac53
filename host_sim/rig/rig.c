/* Creation of a rig, its step, its observers, its state as bytes. */
#include "host_sim/rig/rig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "contract/tap.h"
#include "host_sim/rig/rig_parts.h"
#include "settings/params.h"
#include "settings/reasons.h"
#include "settings/signals.h"

/* The program does not read it; `used` keeps it with link-time optimisation. */
__attribute__((used)) const uint32_t rig_period_ticks = RIG_PERIOD_TICKS;
const uint32_t rig_window_periods = DRIVE_WINDOW;
const char rig_board[] = BOARD_NAME;

rig_state_t *rig_state(rig_t *rig)
{
    return &rig->state;
}

/* ---- life ---- */

void rig_bind(rig_t *rig)
{
    rig_software_bind(rig);
    app = &rig->state.app;
    chip_bind(&rig->state.chip, &rig->world);
}

/* Sets the variables to zero and runs main() up to its loop; the present period begins when the function
 * returns. The first carrier period has no sample at its beginning; the first sample is that of the next
 * period. After a failed initialisation the board has no carrier, or that of an earlier program; simulated
 * time continues nevertheless. */
static void start_software(rig_t *rig)
{
    rig_state_t *state = &rig->state;
    const uint64_t begin = chip_now(&state->chip);
    rig_bind(rig);
    memset(app, 0, sizeof *app);
    state->medium_until = 0u;
    app_start();
    const uint64_t zero = chip_carrier_tick(&state->chip);
    const uint64_t first =
        (zero != CHIP_NEVER && zero > begin ? zero : chip_now(&state->chip)) + RIG_PERIOD_TICKS;
    state->start =
        first -
        RIG_PERIOD_TICKS * state->period; /* begin of period 0, computed as if the carrier had not stopped */
    state->begun = state->period;
    state->background_next = first;
    chip_run(first);
}

void rig_start(rig_t *rig)
{
    rig->state.period = 0u;
    start_software(rig);
}

void rig_power_cycle(rig_t *rig)
{
    rig_bind(rig);
    chip_power_cycle(&rig->state.chip);
    start_software(rig);
}

rig_t *rig_create(uint64_t seed)
{
    rig_t *rig = calloc(1, sizeof *rig);
    if (rig == NULL) {
        return NULL;
    }
    rig->world = rig_world(rig);
    rig_state_t *state = &rig->state;
    table_defaults(&plant_table, &state->plant_values);
    table_defaults(&conditions_table, &state->conditions);
    const plant_params_t plant = rig_plant_params(&state->plant_values);
    plant_init(&state->plant, &plant, seed);
    chip_power_on(&state->chip, (uint32_t)BOARD_CRYSTAL_HZ);
    chip_serial_speed(&state->chip, (uint32_t)BOARD_SERIAL_BAUD);
#if BOARD_STORE == BOARD_STORE_I2C
    const chip_memory_t memory = {BOARD_STORE_ADDRESS, BOARD_STORE_PAGE_OCTETS,
                                  BOARD_STORE_WRITE_US * (uint32_t)(CHIP_TICKS_PER_SECOND / 1000000u)};
    chip_attach_memory(&state->chip, &memory);
#endif
    rig_bind(rig);
    rig_drive_enable_input(rig);
    rig_start(rig);
    return rig;
}

void rig_free(rig_t *rig)
{
    free(rig);
}

/* Difference of two wrapped angles, wrapped. */
static float angle_between(float a, float b)
{
    const double turn = 6.283185307179586;
    const double difference = (double)a - (double)b;
    return (float)(difference >= 0.5 * turn   ? difference - turn
                   : difference < -0.5 * turn ? difference + turn
                                              : difference);
}

/* The next t_k that has not been recorded: the true values are taken there. */
static uint64_t next_begin(const rig_state_t *state)
{
    return state->start + RIG_PERIOD_TICKS * state->begun;
}

static void begin_period(rig_t *rig)
{
    plant_t *plant = &rig->state.plant;
    rig_truth_t *truth = &rig->state.ahead[rig->state.begun % RIG_AHEAD];
    if (rig->cut.part == (int32_t)RIG_DRIVE) { /* without its plant */
        rig->state.begun++;
        return;
    }
    plant_advance(plant, next_begin(&rig->state));
    rig_follow_outputs(rig);
    rig->state.begun++;
    truth->true_theta_e = (float)plant->theta_e;
    truth->true_omega_m = (float)plant->omega_m;
    truth->true_omega_e = (float)(plant->omega_m * plant->p);
    truth->true_torque = (float)plant->torque;
    truth->true_i_a = (float)plant->i[0];
    truth->true_i_b = (float)plant->i[1];
    truth->true_i_c = (float)plant->i[2];
    truth->true_i_d = (float)plant->i_d;
    truth->true_i_q = (float)plant->i_q;
    truth->true_u_dc = (float)plant->v_dc;
    truth->true_supply_current = (float)((plant->supplied - rig->state.supplied) / RIG_PERIOD_SECONDS);
    rig->state.supplied = plant->supplied;
    truth->shoot_throughs = (float)plant->shoot_throughs;
    truth->chip_reports = (float)chip_report_total(&rig->state.chip);
}

void rig_pass(rig_t *rig, uint64_t until)
{
    while (next_begin(&rig->state) < until) {
        chip_run(next_begin(&rig->state));
        begin_period(rig);
    }
    chip_run(until);
}

/* Stores the true values at the t_k of the present period. The errors of angle are not known yet, and keep
 * their values. */
static void show_truth(rig_t *rig)
{
    rig_truth_t *truth = &rig->state.truth;
    const rig_truth_t last = *truth;
    *truth = rig->state.ahead[rig->state.period % RIG_AHEAD];
    truth->theta_err = last.theta_err;
    truth->theta_hat_err = last.theta_hat_err;
}

/* Runs up to `ticks` of the present period; the background runs after the interrupts. Returns the number of
 * interrupts. A plant alone ends where a sample waits for the drive. */
static uint32_t run_period(rig_t *rig, uint64_t ticks)
{
    rig_state_t *state = &rig->state;
    uint32_t turns = 0;
    rig_bind(rig);
    if (chip_restart_asked(&state->chip)) {
        chip_boot(&state->chip);
        start_software(rig);
    }
    if (state->begun <= state->period) {
        state->begun = state->period;
        begin_period(rig);
    }
    show_truth(rig);
    const uint64_t end = state->start + RIG_PERIOD_TICKS * state->period + ticks;
    for (;;) {
        const uint64_t medium = state->medium_until;
        const bool medium_ends = medium > chip_now(&state->chip) && medium < end;
        const bool reached = !chip_run_to_background(medium_ends ? medium : end);
        if ((reached && !medium_ends) || rig->cut.waits != 0u) {
            return turns;
        }
        turns += rig_background(rig);
    }
}

void rig_step_part(rig_t *rig, uint64_t ticks)
{
    run_period(rig, ticks < RIG_PERIOD_TICKS ? ticks : RIG_PERIOD_TICKS);
}

__attribute__((noinline)) void rig_stop_at(rig_t *rig, uint32_t period)
{
    (void)rig;
    (void)period;
    __asm__ volatile(""); /* keeps the call, and with it the place for a breakpoint */
}

void rig_step(rig_t *rig)
{
    rig_state_t *state = &rig->state;
    if (rig->stop_hook_set && rig->stop_hook_period == state->period) {
        rig_stop_at(rig, state->period);
    }
    if (run_period(rig, RIG_PERIOD_TICKS) == 0u && rig_background_is_free(rig)) {
        if (rig->cut.part == (int32_t)RIG_RING) {
            plant_advance(&state->plant,
                          chip_now(&state->chip)); /* otherwise the encoder would jump at t_k+1 */
        }
        chip_look(&state->chip);
        rig_background(rig);
    }
    state->truth.theta_err = angle_between(state->app.drive.fast.rotor.theta_e, state->truth.true_theta_e);
    state->truth.theta_hat_err =
        angle_between(state->app.drive.fast.estimator.estimate.frame.theta_e, state->truth.true_theta_e);
    state->period++;

    if (rig->tap_sink != NULL && (state->period - 1u) % rig->tap_every == 0u) {
        uint32_t slots[RIG_TAP_MAX];
        tap_copy(rig->tap_offsets, rig->tap_count, state, slots);
        rig->tap_sink(rig->tap_context, state->period - 1u, slots, rig->tap_count);
    }
}

static bool stop_met(const rig_t *rig)
{
    if (rig->stop_compare == RIG_NEVER) {
        return false;
    }
    const double value = rig_row_get(rig->stop_place.row, rig->stop_place.base);
    switch (rig->stop_compare) {
    case RIG_EQUAL:
        return value == rig->stop_value;
    case RIG_NOT_EQUAL:
        return value != rig->stop_value;
    case RIG_ABOVE:
        return value > rig->stop_value;
    case RIG_BELOW:
        return value < rig->stop_value;
    case RIG_NEVER:
        break;
    }
    return false;
}

uint32_t rig_run(rig_t *rig, uint32_t periods)
{
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(rig);
        if (stop_met(rig)) {
            return n + 1u;
        }
    }
    return periods;
}

uint32_t rig_period(const rig_t *rig)
{
    return rig->state.period;
}

void rig_stop_before(rig_t *rig, uint32_t period)
{
    rig->stop_hook_set = true;
    rig->stop_hook_period = period;
}

/* ---- onlookers ---- */

bool rig_tap(rig_t *rig, const uint32_t *ids, uint32_t count, uint32_t every, rig_sink_t sink, void *context)
{
    if (count > RIG_TAP_MAX || every == 0u) {
        return rig_refuse(rig, 0u, REASON_OUT_OF_RANGE,
                          "a tap accepts 1 to 160 rows, and an interval of 1 period or more");
    }
    for (uint32_t n = 0; n < count; n++) {
        place_t place;
        if (!rig_find(rig, ids[n], &place)) {
            return rig_refuse_id(rig, ids[n]);
        }
        rig->tap_offsets[n] = (size_t)(place.base - (const char *)&rig->state) + place.row->offset;
    }
    rig->tap_count = count;
    rig->tap_every = every;
    rig->tap_sink = sink;
    rig->tap_context = context;
    return true;
}

bool rig_history_held(const rig_t *rig)
{
    const drive_t *drive = &rig->state.app.drive;
    return drive->state == (int32_t)DRIVE_FAULT && drive->record.on == 0u &&
           drive->capture.state == (uint32_t)CAPTURE_HELD && drive->capture.at == drive->fault.period;
}

uint32_t rig_history_count(const rig_t *rig)
{
    return capture_count(&rig->state.app.drive.capture);
}

uint32_t rig_history_columns(const rig_t *rig)
{
    return rig->state.app.drive.capture.tuning.columns;
}

const uint32_t *rig_history_rows(const rig_t *rig)
{
    return rig->state.app.drive.capture.tuning.id;
}

const uint32_t *rig_history(const rig_t *rig, uint32_t ago, uint32_t *period)
{
    const capture_t *capture = &rig->state.app.drive.capture;
    *period = capture->newest - ago;
    return capture_row(capture, capture_count(capture) - 1u - ago);
}

bool rig_stop_when(rig_t *rig, uint32_t id, rig_compare_t compare, double value)
{
    if (!rig_find(rig, id, &rig->stop_place)) {
        return rig_refuse_id(rig, id);
    }
    rig->stop_compare = compare;
    rig->stop_value = value;
    return true;
}

/* ---- the serial line, and stored data ---- */

void rig_serial_baud(rig_t *rig, uint32_t baud)
{
    chip_serial_speed(&rig->state.chip, baud);
}

uint32_t rig_serial_put(rig_t *rig, const uint8_t *octets, uint32_t count)
{
    return chip_serial_put(&rig->state.chip, octets, count);
}

uint32_t rig_serial_get(rig_t *rig, uint8_t *octets, uint32_t room)
{
    return chip_serial_get(&rig->state.chip, octets, room);
}

_Static_assert(RIG_FLASH_SIZE == 2u * CHIP_FLASH_PAGES * CHIP_FLASH_WORDS, "size of the flash");

#if BOARD_STORE == BOARD_STORE_I2C
/* The content of the memory on the bus is at the beginning of the file. */
void rig_flash_save(const rig_t *rig, uint8_t *octets)
{
    memset(octets, 0xFF, RIG_FLASH_SIZE);
    memcpy(octets, chip_memory_octets(&rig->state.chip), CHIP_I2C_KEPT);
}

bool rig_flash_load(rig_t *rig, const uint8_t *octets, size_t size)
{
    char text[sizeof rig->error];
    if (size != RIG_FLASH_SIZE) {
        snprintf(text, sizeof text, "flash of %zu octets: accepted: %u", size, RIG_FLASH_SIZE);
        return rig_refuse(rig, 0u, REASON_OUT_OF_RANGE, text);
    }
    chip_memory_fill(&rig->state.chip, octets);
    return true;
}
#else
void rig_flash_save(const rig_t *rig, uint8_t *octets)
{
    for (uint32_t n = 0; n < CHIP_FLASH_PAGES * CHIP_FLASH_WORDS; n++) {
        const uint16_t word = chip_flash_word(&rig->state.chip, n / CHIP_FLASH_WORDS, n % CHIP_FLASH_WORDS);
        octets[2u * n] = (uint8_t)(word & 0xFFu);
        octets[2u * n + 1u] = (uint8_t)(word >> 8);
    }
}

bool rig_flash_load(rig_t *rig, const uint8_t *octets, size_t size)
{
    char text[sizeof rig->error];
    uint16_t words[CHIP_FLASH_WORDS];
    const chip_t before = rig->state.chip;
    if (size != RIG_FLASH_SIZE) {
        snprintf(text, sizeof text, "flash of %zu octets: accepted: %u", size, RIG_FLASH_SIZE);
        return rig_refuse(rig, 0u, REASON_OUT_OF_RANGE, text);
    }
    for (uint32_t page = 0; page < CHIP_FLASH_PAGES; page++) {
        const uint8_t *from = octets + page * (RIG_FLASH_SIZE / CHIP_FLASH_PAGES);
        for (uint32_t at = 0; at < CHIP_FLASH_WORDS; at++) {
            words[at] = (uint16_t)(from[2u * at] | from[2u * at + 1u] << 8);
        }
        if (!chip_flash_fill(&rig->state.chip, page, words)) {
            rig->state.chip = before;
            snprintf(text, sizeof text,
                     "flash page %u has different words after word %u: accepted: erased "
                     "ones there",
                     page, CHIP_FLASH_KEPT - 1u);
            return rig_refuse(rig, 0u, REASON_OUT_OF_RANGE, text);
        }
    }
    return true;
}
#endif

/* ---- state as bytes ---- */

size_t rig_state_size(void)
{
    return sizeof(rig_state_t);
}

void rig_save(const rig_t *rig, void *state)
{
    memcpy(state, &rig->state, sizeof rig->state);
}

bool rig_load(rig_t *rig, const void *state, size_t size)
{
    if (size != sizeof rig->state) {
        char text[sizeof rig->error];
        snprintf(text, sizeof text, "the state has %zu octets: accepted: %zu, the size in this program", size,
                 sizeof rig->state);
        return rig_refuse(rig, 0u, REASON_OUT_OF_RANGE, text);
    }
    memcpy(&rig->state, state, sizeof rig->state);
    return true;
}

/* FNV-1a over the octets. The PIE vectors are left out, because they contain addresses of functions of this
 * program.
 */
uint64_t rig_hash(const rig_t *rig)
{
    const unsigned char *octet = (const unsigned char *)&rig->state;
    const size_t begin = offsetof(rig_state_t, chip.registers.pie_vectors);
    const size_t end = begin + sizeof rig->state.chip.registers.pie_vectors;
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t n = 0; n < sizeof rig->state; n++) {
        if (n < begin || n >= end) {
            hash = (hash ^ octet[n]) * UINT64_C(1099511628211);
        }
    }
    return hash;
}
