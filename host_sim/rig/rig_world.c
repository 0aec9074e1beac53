/* The devices at the chip's pins: the inverter, the motor, its sensors and its encoder. */
#include "hal/f28335/pwm.h"
#include "hal/f28335/qep.h"
#include "host_sim/rig/rig_parts.h"

/* The assignment of the legs of plant and board to the ePWMs. */
static const uint32_t legs[3] = {BOARD_LEG_A, BOARD_LEG_B, BOARD_LEG_C};

static void tell_edge(rig_t *rig, uint64_t tick, rig_edge_t what, uint32_t value)
{
    if (rig->edge_sink != NULL) {
        rig->edge_sink(rig->edge_context, tick - rig->state.start, (uint32_t)what, value);
    }
}

/* Converts trips of the ePWM modules to trips of the legs. */
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
void rig_follow_fault_line(rig_t *rig)
{
    if (rig->cut.part == (int32_t)RIG_DRIVE) { /* the other part has the module */
        return;
    }
    const uint32_t active = plant_fault_line(&rig->state.plant);
    if (active != rig->state.fault_line) {
        rig->state.fault_line = active;
        rig->cut.tripped = active != 0u ? chip_now(&rig->state.chip) : rig->cut.tripped;
        chip_set_pin(&rig->state.chip, PWM_FAULT_PIN, active == 0u);
    }
}

void rig_drive_enable_input(rig_t *rig)
{
#if BOARD_ENABLE_INPUT != BOARD_NONE
    const bool active = rig->state.conditions.enable_input == 0;
    chip_set_pin(&rig->state.chip, BOARD_ENABLE_INPUT, active == (BOARD_ENABLE_ACTIVE_HIGH != 0));
#else
    (void)rig;
#endif
}

#define DRIVEN(pin, level) (chip_pin_out(&rig->state.chip, (pin)) == (int32_t)(level))

/* A pin that the chip does not drive yet is held at the level of off by the board. */
void rig_follow_outputs(rig_t *rig)
{
    bool chopper = false;
    bool released = false;
#if BOARD_CHOPPER_OUTPUT != BOARD_NONE
    chopper = DRIVEN(BOARD_CHOPPER_OUTPUT, BOARD_CHOPPER_ACTIVE_HIGH);
#endif
#if BOARD_BRAKE_OUTPUT != BOARD_NONE
    released = DRIVEN(BOARD_BRAKE_OUTPUT, BOARD_BRAKE_ACTIVE_HIGH);
#endif
    plant_outputs(&rig->state.plant, chopper, released);
}

/* Only the currents change within a microsecond; slow quantities are read at the plant's present time. */
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
    rig_follow_fault_line(rig);
}

static void on_carrier(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                       bool ends)
{
    rig_t *rig = context;
    const uint32_t of_legs[3] = {high[legs[0] - BOARD_LEG_FIRST], high[legs[1] - BOARD_LEG_FIRST],
                                 high[legs[2] - BOARD_LEG_FIRST]};
    plant_carrier(&rig->state.plant, tick, period, of_legs, dead, ends);
    rig_follow_fault_line(rig);
}

static int64_t on_encoder(void *context, uint64_t tick)
{
    rig_t *rig = context;
    return plant_encoder_at(&rig->state.plant, tick) - rig->state.encoder_moved;
}

chip_world_t rig_world(rig_t *rig)
{
    return (chip_world_t){.context = rig,
                          .analog = on_analog,
                          .gates = on_gates,
                          .carrier = on_carrier,
                          .encoder = on_encoder,
                          .section = rig_section,
                          .active_low = HAL_GATE_ACTIVE_HIGH == 0};
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

void rig_set_motion(rig_t *rig, double theta_m, double omega_m)
{
    rig_state_t *state = &rig->state;
    plant_advance(&state->plant, chip_now(&state->chip));
    const int64_t before = plant_encoder(&state->plant);
    plant_set_motion(&state->plant, theta_m, omega_m);
    const int64_t count = plant_encoder(&state->plant);
    state->encoder_moved += count - before;
    rig_bind(rig);
    chip_align_encoder(&state->chip, QEP_MODULE, count);
}
