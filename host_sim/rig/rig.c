#include "host_sim/rig/rig.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "drive/reasons.h"
#include "drive/signals.h"
#include "hal/f28335/bus.h"
#include "hal/f28335/pwm.h"
#include "hal/f28335/qep.h"
#include "host_sim/rig/rig_state.h"

/* [periods] the background loop comes round once a millisecond */
#define BACKGROUND_EVERY rig_periods(1e-3)

/* Nothing of the program reads it; `used` keeps it where the linker looks across rooms. */
__attribute__((used)) const uint32_t rig_period_ticks = RIG_PERIOD_TICKS;

/* Tables by their order, which is also that of rig_table(). */
typedef enum { PARAMS, REQUESTS, SIGNALS, TRUTH, PLANT, CONDITIONS, TABLES } table_number_t;

static const table_t *const tables[TABLES] = {
    [PARAMS] = &params_table, [REQUESTS] = &requests_table, [SIGNALS] = &signals_table,
    [TRUTH] = &truth_table,   [PLANT] = &plant_table,       [CONDITIONS] = &conditions_table,
};

typedef struct {
    table_number_t table;
    const table_row_t *row;
    const char *base; /* struct that holds the slot */
} place_t;

struct rig {
    rig_state_t state;
    chip_world_t world;
    /* onlookers; none of this changes what happens */
    const uint32_t *tap_slots[RIG_TAP_MAX];
    uint32_t tap_count;
    uint32_t tap_every;
    rig_sink_t tap_sink;
    void *tap_context;
    rig_edge_sink_t edge_sink;
    void *edge_context;
    place_t stop_place;
    rig_compare_t stop_compare;
    double stop_value;
    bool stop_hook_set;
    uint32_t stop_hook_period;
    uint32_t error_id;
    int32_t error_reason;
    char error[256];
};

/* The rig whose chip and application run on this thread: for the interrupts, which get no argument. */
static __thread const rig_t *bound;

rig_state_t *rig_state(rig_t *rig)
{
    return &rig->state;
}

/* ---- the world around the chip's pins ---- */

/* Which leg of the plant, and of the board, hangs on which ePWM. */
static const uint32_t legs[3] = {BOARD_LEG_A, BOARD_LEG_B, BOARD_LEG_C};

static void tell_edge(rig_t *rig, uint64_t tick, rig_edge_t what, uint32_t value)
{
    if (rig->edge_sink != NULL) {
        rig->edge_sink(rig->edge_context, tick - rig->state.start, (uint32_t)what, value);
    }
}

/* Trips of the modules as trips of the legs. */
static uint32_t legs_tripped(uint32_t modules)
{
    return (modules >> (legs[0] - 1u) & 1u) | (modules >> (legs[1] - 1u) & 1u) << 1 |
           (modules >> (legs[2] - 1u) & 1u) << 2;
}

static void on_event(void *context, uint64_t tick, chip_event_t what, uint32_t value)
{
    static const rig_edge_t edges[] = {
        [CHIP_EVENT_ADC_START] = RIG_EDGE_ADC_START,
        [CHIP_EVENT_INTERRUPT] = RIG_EDGE_ISR_ENTER,
        [CHIP_EVENT_RETURN] = RIG_EDGE_ISR_EXIT,
        [CHIP_EVENT_TRIP] = RIG_EDGE_TRIP,
    };
    tell_edge(context, tick, edges[what], what == CHIP_EVENT_TRIP ? legs_tripped(value) : value);
}

/* The power module's fault output reaches the trip pin without software and without delay. */
static void follow_fault_line(rig_t *rig)
{
    const uint32_t active = plant_fault_line(&rig->state.plant);
    if (active != rig->state.fault_line) {
        rig->state.fault_line = active;
        chip_set_pin(&rig->state.chip, PWM_FAULT_PIN, active == 0u);
    }
}

/* Only the currents move within a microsecond; slow quantities are taken at the plant's present instant. */
static double on_analog(void *context, uint64_t tick, uint32_t channel)
{
    static const struct {
        uint32_t channel;
        plant_channel_t signal;
    } wires[] = {
        {BOARD_CURRENT_A_INPUT, PLANT_CURRENT_A}, {BOARD_CURRENT_B_INPUT, PLANT_CURRENT_B},
        {BOARD_CURRENT_C_INPUT, PLANT_CURRENT_C}, {BOARD_DC_INPUT, PLANT_DC_LINK},
        {BOARD_SINK_INPUT, PLANT_SINK},           {BOARD_MOTOR_INPUT, PLANT_MOTOR},
    };
    plant_t *plant = &((rig_t *)context)->state.plant;
    for (size_t n = 0; n < sizeof wires / sizeof wires[0]; n++) {
        if (wires[n].channel == channel) {
            if (wires[n].signal <= PLANT_CURRENT_C) {
                plant_advance(plant, tick);
            }
            return plant_analog(plant, wires[n].signal);
        }
    }
    return 0.0; /* not wired */
}

/* Commands of the six switches, leg by leg. The board's bias holds an undriven pin at the level of off. */
static uint32_t switches_on(uint32_t level, uint32_t driven)
{
    const uint32_t pins = (HAL_GATE_ACTIVE_HIGH != 0 ? level : ~level) & driven;
    uint32_t on = 0;
    for (uint32_t leg = 0; leg < 3u; leg++) {
        on |= (pins >> (2u * (legs[leg] - 1u)) & 3u) << (2u * leg);
    }
    return on;
}

static void on_gates(void *context, uint64_t tick, uint32_t level, uint32_t driven)
{
    rig_t *rig = context;
    const uint32_t on = switches_on(level, driven);
    tell_edge(rig, tick, RIG_EDGE_GATES, on);
    plant_gates(&rig->state.plant, tick, on);
    follow_fault_line(rig);
}

static void on_carrier(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead)
{
    rig_t *rig = context;
    const uint32_t of_legs[3] = {high[legs[0] - BOARD_LEG_FIRST], high[legs[1] - BOARD_LEG_FIRST],
                                 high[legs[2] - BOARD_LEG_FIRST]};
    plant_carrier(&rig->state.plant, tick, period, of_legs, dead);
    follow_fault_line(rig);
}

static int64_t on_encoder(void *context, uint64_t tick)
{
    rig_t *rig = context;
    return plant_encoder_at(&rig->state.plant, tick) - rig->state.encoder_moved;
}

/* ---- life ---- */

void rig_bind(rig_t *rig)
{
    bound = rig;
    app = &rig->state.app;
    chip_bind(&rig->state.chip, &rig->world);
}

void rig_start(rig_t *rig)
{
    rig_state_t *state = &rig->state;
    const uint64_t begin = chip_now(&state->chip);
    rig_bind(rig);
    memset(app, 0, sizeof *app);
    app_start();
    /* The first carrier period has no sample at its beginning; period 0 is the next. A board that did not
     * come up has no carrier, or that of an earlier program, and time goes on all the same. */
    const uint64_t zero = chip_carrier_tick(&state->chip);
    state->start = (zero != CHIP_NEVER && zero > begin ? zero : chip_now(&state->chip)) + RIG_PERIOD_TICKS;
    state->period = 0u;
    chip_run(state->start);
}

rig_t *rig_create(uint64_t seed)
{
    rig_t *rig = calloc(1, sizeof *rig);
    if (rig == NULL) {
        return NULL;
    }
    rig->world = (chip_world_t){.context = rig,
                                .analog = on_analog,
                                .gates = on_gates,
                                .carrier = on_carrier,
                                .encoder = on_encoder,
                                .active_low = HAL_GATE_ACTIVE_HIGH == 0};

    rig_state_t *state = &rig->state;
    table_defaults(&plant_table, &state->plant_values);
    table_defaults(&conditions_table, &state->conditions);
    const plant_params_t plant = rig_plant_params(&state->plant_values);
    plant_init(&state->plant, &plant, seed);
    chip_power_on(&state->chip, (uint32_t)BOARD_CRYSTAL_HZ);
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

static void take_truth(rig_t *rig)
{
    const plant_t *plant = &rig->state.plant;
    rig_truth_t *truth = &rig->state.truth;
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
    truth->shoot_throughs = (float)plant->shoot_throughs;
    truth->chip_reports = (float)chip_report_total(&rig->state.chip);
}

__attribute__((noinline)) void rig_stop_at(rig_t *rig, uint32_t period)
{
    (void)rig;
    (void)period;
    __asm__ volatile(""); /* keeps the call, and with it the place to break on */
}

void rig_step(rig_t *rig)
{
    rig_state_t *state = &rig->state;
    if (rig->stop_hook_set && rig->stop_hook_period == state->period) {
        rig_stop_at(rig, state->period);
    }
    rig_bind(rig);
    const uint64_t begin = state->start + RIG_PERIOD_TICKS * state->period;
    plant_advance(&state->plant, begin);
    take_truth(rig);
    chip_run(begin + RIG_PERIOD_TICKS);
    state->truth.theta_err = angle_between(state->app.drive.position.theta_e, state->truth.true_theta_e);
    state->truth.theta_hat_err = angle_between(state->app.drive.estimate.theta_e, state->truth.true_theta_e);
    if (state->period % BACKGROUND_EVERY == 0u) {
        app_background();
    }
    state->period++;

    if (rig->tap_sink != NULL && (state->period - 1u) % rig->tap_every == 0u) {
        uint32_t slots[RIG_TAP_MAX];
        for (uint32_t n = 0; n < rig->tap_count; n++) {
            slots[n] = *rig->tap_slots[n];
        }
        rig->tap_sink(rig->tap_context, state->period - 1u, slots, rig->tap_count);
    }
}

static bool stop_met(const rig_t *rig)
{
    if (rig->stop_compare == RIG_NEVER) {
        return false;
    }
    const double value = (double)table_get(rig->stop_place.row, rig->stop_place.base);
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

/* ---- the sample interrupt ---- */

/* Ideal sensors: what app_interrupt does, on the truth of t_k. The drive takes off the zero that it has
 * measured of the real sensors; it is put on, so that sensors may change at any time after that. */
static void exact_interrupt(void)
{
    const rig_truth_t *truth = &bound->state.truth;
    const drive_t *drive = &app->drive;
    const bool measuring = drive->state == (int32_t)DRIVE_NOT_READY;
    drive_samples_t samples;
    drive_command_t command;
    app_read(&samples);
    samples.i_a = truth->true_i_a + (measuring ? 0.0f : drive->offset.a);
    samples.i_b = truth->true_i_b + (measuring ? 0.0f : drive->offset.b);
    samples.i_c = truth->true_i_c + (measuring ? 0.0f : drive->offset.c);
    samples.u_dc = truth->true_u_dc;
    drive_step(&app->drive, &samples, &command);
    app_write(&command);
}

static bus_isr_t interrupt_in_force(const rig_t *rig)
{
    return rig->state.conditions.sensors != 0 ? exact_interrupt : app_interrupt;
}

static void point_interrupt_to(bus_isr_t isr)
{
    bus_allow();
    bus_write32(&PIE_VECTORS->vector[PIE_SEQ1INT], bus_vector(isr));
    bus_protect();
}

static __thread double timed_seconds; /* of the interrupts that this thread has timed */

static double clock_seconds(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void timed_interrupt(void)
{
    const bus_isr_t isr = interrupt_in_force(bound);
    const double start = clock_seconds();
    isr();
    timed_seconds += clock_seconds() - start;
}

double rig_interrupt_seconds(rig_t *rig, uint32_t periods)
{
    /* What two readings of the clock cost by themselves. */
    const uint32_t pairs = 10000u;
    double empty = 0.0;
    for (uint32_t n = 0; n < pairs; n++) {
        const double start = clock_seconds();
        empty += clock_seconds() - start;
    }
    rig_bind(rig);
    point_interrupt_to(timed_interrupt);
    timed_seconds = 0.0;
    rig_run(rig, periods);
    rig_bind(rig);
    point_interrupt_to(interrupt_in_force(rig));
    return timed_seconds / periods - empty / pairs;
}

/* ---- the estimator by itself ---- */

typedef struct {
    ab_t voltage; /* [V] */
    ab_t current; /* [A] */
} estimator_input_t;

typedef struct {
    chosen_t start;
    flux_t flux;
    estimator_input_t inputs[RIG_ESTIMATOR_STEPS];
} estimator_record_t;

size_t rig_estimator_size(void)
{
    return sizeof(estimator_record_t);
}

void rig_estimator_record(rig_t *rig, void *record)
{
    estimator_record_t *to = record;
    const drive_t *drive = &rig->state.app.drive;
    to->start = drive->estimator;
    to->flux = drive->flux;
    for (uint32_t n = 0; n < RIG_ESTIMATOR_STEPS; n++) {
        rig_step(rig);
        to->inputs[n] = (estimator_input_t){drive->observer_voltage, drive->current_ab};
    }
}

typedef position_t (*estimator_step_t)(chosen_t *est, flux_t *flux, ab_t voltage, ab_t current);

/* A step, and the adaptation beside it as in the drive. */
static position_t estimator_and_flux(chosen_t *est, flux_t *flux, ab_t voltage, ab_t current)
{
    const position_t position = chosen_step(est, voltage, current);
    const estimate_t *seen = &est->estimate;
    if (flux->tuning.share > 0.0f && seen->coasted == 0u) {
        flux_step(flux, seen->amplitude, seen->omega_smooth, seen->detector);
        chosen_set_flux(est, flux->flux_linkage, flux->speed_per_volt);
    }
    return position;
}

static position_t empty_step(chosen_t *est, flux_t *flux, ab_t voltage, ab_t current)
{
    (void)est;
    (void)flux;
    (void)voltage;
    (void)current;
    return (position_t){0.0f, 0.0f};
}

__attribute__((noinline)) float rig_estimator_replay(const void *record, bool empty)
{
    const estimator_record_t *from = record;
    const volatile estimator_step_t step = empty ? empty_step : estimator_and_flux;
    chosen_t est = from->start;
    flux_t flux = from->flux;
    position_t position = {0.0f, 0.0f};
    for (uint32_t n = 0; n < RIG_ESTIMATOR_STEPS; n++) {
        position = step(&est, &flux, from->inputs[n].voltage, from->inputs[n].current);
    }
    return position.theta_e;
}

double rig_estimator_seconds(const void *record)
{
    double taken[2];
    for (int32_t empty = 0; empty < 2; empty++) {
        const double start = clock_seconds();
        (void)rig_estimator_replay(record, empty != 0);
        taken[empty] = clock_seconds() - start;
    }
    return (taken[0] - taken[1]) / RIG_ESTIMATOR_STEPS;
}

void rig_set_motion(rig_t *rig, double theta_m, double omega_m)
{
    rig_state_t *state = &rig->state;
    plant_advance(&state->plant, chip_now(&state->chip));
    const int64_t before = plant_encoder(&state->plant);
    plant_set_motion(&state->plant, theta_m, omega_m);
    const int64_t count = plant_encoder(&state->plant);
    state->encoder_moved += count - before;

    rig_bind(rig);
    const int64_t turn = (int64_t)EQEP(QEP_MODULE)->QPOSMAX + 1;
    const int64_t within = count % turn;
    bus_write32(&EQEP(QEP_MODULE)->QPOSCNT, (uint32_t)(within < 0 ? within + turn : within));
}

void rig_stop_before(rig_t *rig, uint32_t period)
{
    rig->stop_hook_set = true;
    rig->stop_hook_period = period;
}

/* ---- tables ---- */

uint32_t rig_table_count(void)
{
    return TABLES;
}

const table_t *rig_table(uint32_t index)
{
    return index < TABLES ? tables[index] : NULL;
}

const table_row_t *rig_row(uint32_t id)
{
    for (uint32_t n = 0; n < TABLES; n++) {
        const table_row_t *row = table_by_id(tables[n], id);
        if (row != NULL) {
            return row;
        }
    }
    return NULL;
}

const table_row_t *rig_row_by_name(const char *name)
{
    const char *dot = strchr(name, '.');
    for (uint32_t n = 0; n < TABLES; n++) {
        const table_row_t *row = NULL;
        if (dot == NULL) {
            row = table_by_name(tables[n], name);
        } else if (strlen(tables[n]->name) == (size_t)(dot - name) &&
                   strncmp(tables[n]->name, name, (size_t)(dot - name)) == 0) {
            row = table_by_name(tables[n], dot + 1);
        }
        if (row != NULL) {
            return row;
        }
    }
    return NULL;
}

uint32_t rig_tables_hash(void)
{
    uint32_t hash = 0;
    for (uint32_t n = 0; n < TABLES; n++) {
        hash = table_hash(tables[n], hash);
    }
    return hash;
}

/* ---- values ---- */

static bool refuse(rig_t *rig, uint32_t id, int32_t reason, const char *text)
{
    rig->error_id = id;
    rig->error_reason = reason;
    snprintf(rig->error, sizeof rig->error, "%s", text);
    return false;
}

/* " ohm"; nothing for pure numbers. */
static const char *unit_after(const table_row_t *row, char text[24])
{
    snprintf(text, 24, " %s", row->unit);
    return strcmp(row->unit, "-") == 0 ? "" : text;
}

static bool refuse_value(rig_t *rig, const params_error_t *why)
{
    char text[sizeof rig->error];
    char buffer[24];
    const char *unit = unit_after(rig_row(why->id), buffer);
    if (why->reason == REASON_BRIDGE_ON) {
        snprintf(text, sizeof text, "%s = %.7g%s: it changes only while the bridge is off; now %.7g%s",
                 why->field, (double)why->value, unit, (double)why->min, unit);
    } else {
        snprintf(text, sizeof text, "%s = %.7g%s: accepted %.7g to %.7g%s (%s)", why->field,
                 (double)why->value, unit, (double)why->min, (double)why->max, unit, why->rule);
    }
    return refuse(rig, why->id, why->reason, text);
}

static bool refuse_range(rig_t *rig, const table_row_t *row, double value)
{
    char text[sizeof rig->error];
    char buffer[24];
    const char *unit = unit_after(row, buffer);
    snprintf(text, sizeof text, "%s = %.7g%s: accepted %s%.7g to %.7g%s", row->name, value, unit,
             row->kind == SLOT_FLOAT ? "" : "whole numbers ", (double)row->min, (double)table_max(row), unit);
    return refuse(rig, row->id, REASON_OUT_OF_RANGE, text);
}

static bool find(const rig_t *rig, uint32_t id, place_t *place)
{
    const rig_state_t *state = &rig->state;
    const void *const bases[TABLES] = {
        [PARAMS] = &state->app.drive.params, [REQUESTS] = &state->app.drive.requests,
        [SIGNALS] = &state->app.drive,       [TRUTH] = &state->truth,
        [PLANT] = &state->plant_values,      [CONDITIONS] = &state->conditions,
    };
    for (table_number_t n = PARAMS; n < TABLES; n++) {
        place->row = table_by_id(tables[n], id);
        if (place->row != NULL) {
            place->table = n;
            place->base = bases[n];
            return true;
        }
    }
    return false;
}

static bool refuse_id(rig_t *rig, uint32_t id)
{
    char text[64];
    snprintf(text, sizeof text, "id %lu: no table has it", (unsigned long)id);
    return refuse(rig, id, REASON_UNKNOWN_ID, text);
}

static double number_at(const place_t *place)
{
    const uint32_t bits = table_bits(place->row, place->base);
    switch (place->row->kind) {
    case SLOT_UINT:
        return (double)bits;
    case SLOT_INT:
    case SLOT_ENUM:
        return (double)(int32_t)bits;
    case SLOT_FLOAT:
    case SLOT_KINDS:
        break;
    }
    return (double)table_get(place->row, place->base);
}

bool rig_get(rig_t *rig, uint32_t id, double *value)
{
    place_t place;
    if (!find(rig, id, &place)) {
        return refuse_id(rig, id);
    }
    *value = number_at(&place);
    return true;
}

static bool set_request(rig_t *rig, const table_row_t *row, float value)
{
    requests_t next = rig->state.app.drive.requests;
    params_error_t why;
    table_set(row, &next, value);
    return app_request(&next, &why) || refuse_value(rig, &why);
}

static bool set_plant(rig_t *rig, const table_row_t *row, float value)
{
    rig_state_t *state = &rig->state;
    rig_plant_t next = state->plant_values;
    table_set(row, &next, value);
    const plant_params_t params = rig_plant_params(&next);
    plant_params_error_t why;
    if (!plant_params_check(&params, &why)) {
        /* A rule between rows may speak of another one than was set. */
        const table_row_t *named = table_by_name(&plant_table, why.field);
        char text[sizeof rig->error];
        char buffer[24];
        const char *unit = unit_after(named, buffer);
        snprintf(text, sizeof text, "%s = %.7g%s: accepted %.7g to %.7g%s (%s)", named->name, why.value, unit,
                 why.minimum, why.maximum, unit, why.rule);
        return refuse(rig, named->id, REASON_CROSS_RULE, text);
    }
    state->plant_values = next;
    plant_set_params(&state->plant, &params);
    follow_fault_line(rig);
    return true;
}

static void set_condition(rig_t *rig, const table_row_t *row, float value)
{
    rig_state_t *state = &rig->state;
    rig_conditions_t *now = &state->conditions;
    table_set(row, now, value);
    chip_set_averaged(&state->chip, now->fidelity != 0);
    chip_set_interrupt_delay(&state->chip, (uint32_t)((double)now->interrupt_delay * 150e6 + 0.5));
    chip_stick_adc(&state->chip, BOARD_CURRENT_A_INPUT, (int32_t)now->stuck_current_a);
    chip_stick_adc(&state->chip, BOARD_CURRENT_B_INPUT, (int32_t)now->stuck_current_b);
    if (BOARD_CURRENT_SENSORS == 3) {
        chip_stick_adc(&state->chip, BOARD_CURRENT_C_INPUT, (int32_t)now->stuck_current_c);
    }
    chip_stick_adc(&state->chip, BOARD_DC_INPUT, (int32_t)now->stuck_dc_link);
    if (row->offset == offsetof(rig_conditions_t, metering)) {
        plant_set_metering(&state->plant, now->metering != 0);
    }
    if (row->offset == offsetof(rig_conditions_t, sensors)) {
        point_interrupt_to(interrupt_in_force(rig));
    }
}

bool rig_set(rig_t *rig, uint32_t id, double value)
{
    place_t place;
    if (!find(rig, id, &place)) {
        return refuse_id(rig, id);
    }
    const table_row_t *row = place.row;
    if (row->access == TABLE_READ) {
        char text[sizeof rig->error];
        snprintf(text, sizeof text, "%s: it is shown, not set", row->name);
        return refuse(rig, id, REASON_READ_ONLY, text);
    }
    if (!(fabs(value) <= 3.4e38) || !table_accepts(row, (float)value)) {
        return refuse_range(rig, row, value);
    }

    rig_bind(rig);
    switch (place.table) {
    case PARAMS:
        table_set(row, &rig->state.app.staged, (float)value);
        return true;
    case REQUESTS:
        return set_request(rig, row, (float)value);
    case PLANT:
        return set_plant(rig, row, (float)value);
    case CONDITIONS:
        set_condition(rig, row, (float)value);
        return true;
    case SIGNALS:
    case TRUTH:
    case TABLES:
        break;
    }
    return false;
}

bool rig_apply(rig_t *rig)
{
    params_error_t why;
    rig_bind(rig);
    return app_apply(&why) || refuse_value(rig, &why);
}

double rig_value(rig_t *rig, const char *name)
{
    const table_row_t *row = rig_row_by_name(name);
    double value = 0.0;
    assert(row != NULL);
    (void)rig_get(rig, row->id, &value);
    return value;
}

bool rig_put(rig_t *rig, const char *name, double value)
{
    const table_row_t *row = rig_row_by_name(name);
    if (row == NULL) {
        char text[sizeof rig->error];
        snprintf(text, sizeof text, "%s: no table has a row of this name", name);
        return refuse(rig, 0u, REASON_UNKNOWN_ID, text);
    }
    return rig_set(rig, row->id, value);
}

const char *rig_error(const rig_t *rig)
{
    return rig->error;
}

uint32_t rig_error_id(const rig_t *rig)
{
    return rig->error_id;
}

int32_t rig_error_reason(const rig_t *rig)
{
    return rig->error_reason;
}

/* ---- onlookers ---- */

bool rig_tap(rig_t *rig, const uint32_t *ids, uint32_t count, uint32_t every, rig_sink_t sink, void *context)
{
    if (count > RIG_TAP_MAX || every == 0u) {
        return refuse(rig, 0u, REASON_OUT_OF_RANGE, "a tap takes 1 to 64 rows and every 1st period or fewer");
    }
    for (uint32_t n = 0; n < count; n++) {
        place_t place;
        if (!find(rig, ids[n], &place)) {
            return refuse_id(rig, ids[n]);
        }
        rig->tap_slots[n] = (const uint32_t *)(const void *)(place.base + place.row->offset);
    }
    rig->tap_count = count;
    rig->tap_every = every;
    rig->tap_sink = sink;
    rig->tap_context = context;
    return true;
}

void rig_watch_edges(rig_t *rig, rig_edge_sink_t sink, void *context)
{
    const chip_pins_t *pins = &rig->state.chip.pins;
    const uint64_t now = chip_now(&rig->state.chip);
    rig->edge_sink = sink;
    rig->edge_context = context;
    rig->world.event = sink != NULL ? on_event : NULL;
    tell_edge(rig, now, RIG_EDGE_GATES, switches_on(pins->level, pins->driven));
    tell_edge(rig, now, RIG_EDGE_TRIP, legs_tripped(rig->state.chip.tripped));
}

bool rig_stop_when(rig_t *rig, uint32_t id, rig_compare_t compare, double value)
{
    if (!find(rig, id, &rig->stop_place)) {
        return refuse_id(rig, id);
    }
    rig->stop_compare = compare;
    rig->stop_value = value;
    return true;
}

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
        snprintf(text, sizeof text, "state of %zu octets: this program's has %zu", size, sizeof rig->state);
        return refuse(rig, 0u, REASON_OUT_OF_RANGE, text);
    }
    memcpy(&rig->state, state, sizeof rig->state);
    return true;
}

/* FNV-1a over the octets. The PIE vectors are left out: they hold where functions lie in this very program.
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
