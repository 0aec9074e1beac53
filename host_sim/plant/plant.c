#include "host_sim/plant/plant.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "host_sim/plant/averaged.h"
#include "host_sim/plant/interval.h"
#include "host_sim/plant/noise.h"
#include "host_sim/plant/phasor.h"

#define TICK           (1.0 / 150e6)
#define ALL_GATES      UINT32_C(0x3f)
#define LOWER_GATES    UINT32_C(0x2a)
#define NO_TRIP        1e300 /* [A^2] */
#define EDGES_PER_GATE 4u
#define ZONE_TIME      1e-6 /* [s] shortest time constant of the zone */

static uint64_t ticks_of(double seconds)
{
    return (uint64_t)(seconds * 150e6 + 0.5);
}

/* ---- parameters ---- */

static plant_law_t law_of(const plant_params_t *q, double share_positive, double share_negative)
{
    double sp = share_positive;
    double sn = share_negative;
    plant_law_t law = {
        {sp, sn},
        {-sp * q->igbt_voltage - (1.0 - sp) * q->diode_voltage,
         sn * q->diode_voltage + (1.0 - sn) * q->igbt_voltage},
        {sp * q->igbt_resistance + (1.0 - sp) * q->diode_resistance,
         sn * q->diode_resistance + (1.0 - sn) * q->igbt_resistance},
    };
    return law;
}

static void make_laws(plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    /* Off: lower diode for i > 0, upper diode for i < 0: the averaged law at these shares has just those. */
    plant->law[PLANT_LAW_OFF] = law_of(q, 0.0, 1.0);
    plant->law[PLANT_LAW_UPPER] = law_of(q, 1.0, 1.0);
    plant->law[PLANT_LAW_LOWER] = law_of(q, 0.0, 0.0);
    plant->law[PLANT_LAW_BOTH] = (plant_law_t){{0.5, 0.5}, {0.0, 0.0}, {0.0, 0.0}};
}

static void want_extras(plant_t *plant)
{
    plant->extras = plant->metering || plant->link_rate > 0.0 || plant->params.current_bandwidth > 0.0;
}

static bool module_shut(const plant_t *plant)
{
    return plant->tick < plant->fault_until || plant->params.force_fault != 0.0;
}

/* ---- gates ---- */

static void trip(plant_t *plant, uint32_t gates)
{
    if (plant->averaged) {
        gates = ALL_GATES;
    }
    plant->shut |= gates;
    plant->fault_until = plant->tick + plant->pulse_ticks;
}

static void leg_follows(plant_t *plant, uint32_t leg)
{
    plant->kind[leg] = (plant->on & ~plant->shut) >> (2u * leg) & 3u;
    if (plant->kind[leg] != PLANT_LAW_OFF) {
        plant->idle = 0;
        plant->calm_ticks = 0;
    }
}

/* Laws of all legs from what is on and not shut. */
static void legs_follow(plant_t *plant)
{
    for (uint32_t leg = 0; leg < 3; leg++) {
        leg_follows(plant, leg);
        if (plant->averaged && !plant->shut) {
            plant->kind[leg] = PLANT_LAW_AVERAGED + leg;
            plant->idle = 0;
            plant->calm_ticks = 0;
        }
    }
}

static void shoot_through(plant_t *plant, uint32_t leg)
{
    plant->shoot_throughs++;
    plant->shoot_through_tick = plant->tick;
    plant->shoot_through_leg = leg;
    if (plant->trip_square < NO_TRIP) {
        trip(plant, PLANT_UPPER(leg) | LOWER_GATES);
        legs_follow(plant);
    }
}

/* Arms whose IGBT carries too much. Rare: the length of the current vector says whether to look. */
static void protect(plant_t *plant)
{
    uint32_t over = 0;
    for (uint32_t leg = 0; leg < 3; leg++) {
        double i = plant->i[leg];
        uint32_t kind = plant->kind[leg];
        if (i * i <= plant->trip_square || kind == PLANT_LAW_OFF) {
            continue;
        }
        if (i > 0.0 && kind != PLANT_LAW_LOWER) {
            over |= PLANT_UPPER(leg);
        } else if (i < 0.0 && kind != PLANT_LAW_UPPER) {
            over |= LOWER_GATES;
        }
    }
    if (over) {
        trip(plant, over);
        legs_follow(plant);
    }
}

static void edge_acts(plant_t *plant, uint32_t gate, uint32_t on)
{
    uint32_t bit = UINT32_C(1) << gate;
    uint32_t leg = gate >> 1;
    if (on) {
        plant->on |= bit;
        if (plant->shut && !module_shut(plant)) {
            plant->shut &= ~bit;
        }
    } else {
        plant->on &= ~bit;
    }
    leg_follows(plant, leg);
    if (on && plant->kind[leg] == PLANT_LAW_BOTH) {
        shoot_through(plant, leg);
    }
}

static plant_edge_t *pending(plant_t *plant, uint32_t n)
{
    return &plant->pending[(plant->pending_first + n) % PLANT_PENDING];
}

static void drop_first(plant_t *plant)
{
    plant->waiting[pending(plant, 0)->gate]--;
    plant->pending_first = (plant->pending_first + 1u) % PLANT_PENDING;
    plant->pending_count--;
}

static void act_pending(plant_t *plant)
{
    while (plant->pending_count && pending(plant, 0)->tick <= plant->tick) {
        const plant_edge_t *edge = pending(plant, 0);
        edge_acts(plant, edge->gate, edge->on);
        drop_first(plant);
    }
}

/* An edge that hands a leg from switch to diode or back at the same rail, with the current far enough from
 * zero until then, changes no voltage: no interval needs to end there. */
static bool edge_is_silent(const plant_t *plant, const plant_edge_t *edge)
{
    uint32_t leg = edge->gate >> 1;
    uint32_t before = plant->on >> (2u * leg) & 3u;
    uint32_t after = before ^ (UINT32_C(1) << (edge->gate & 1u));
    double i = plant->i[leg];
    uint32_t diode_twin = i > 0.0 ? PLANT_LAW_LOWER : PLANT_LAW_UPPER;
    if ((before | after) != diode_twin || plant->shut | plant->idle) {
        return false;
    }
    /* |di/dt| of a phase: two thirds of the link plus drops and resistive part (a fifth is ample) plus EMF.
     */
    double fastest = (plant->v_dc * 1.2 + fabs(plant->omega_m) * plant->p * plant->emf_bound) * plant->k_max;
    return fabs(i) > plant->zone + fastest * TICK * (double)(int64_t)(edge->tick - plant->tick);
}

static void push_edge(plant_t *plant, uint64_t tick, uint32_t gate, uint32_t on)
{
    if (plant->waiting[gate]) {
        /* The last pending edge of this gate is the opposite one: overtaken, or one too many, both go. */
        uint32_t last = plant->pending_count - 1u;
        while (pending(plant, last)->gate != gate) {
            last--;
        }
        if (tick <= pending(plant, last)->tick || plant->waiting[gate] == EDGES_PER_GATE) {
            for (uint32_t n = last; n + 1u < plant->pending_count; n++) {
                *pending(plant, n) = *pending(plant, n + 1u);
            }
            plant->pending_count--;
            plant->waiting[gate]--;
            return;
        }
    }
    uint32_t at = plant->pending_count++;
    while (at > 0 && pending(plant, at - 1u)->tick > tick) {
        *pending(plant, at) = *pending(plant, at - 1u);
        at--;
    }
    *pending(plant, at) = (plant_edge_t){tick, gate, on};
    plant->waiting[gate]++;
}

static void integrate(plant_t *plant, uint64_t tick)
{
    while (plant->tick < tick) {
        uint64_t until = tick;
        if (plant->averaged) {
            if (plant->tick >= plant->period_end) {
                averaged_period(plant);
            }
            until = tick < plant->period_end ? tick : plant->period_end;
        }
        plant->tick += interval_step(plant, until - plant->tick);
        if (plant->i_d * plant->i_d + plant->i_q * plant->i_q > plant->trip_square) {
            protect(plant);
        }
    }
}

/* All edges that act until tick; the state stays at the last of them that changed a voltage. */
static void run_edges(plant_t *plant, uint64_t tick)
{
    while (plant->pending_count && pending(plant, 0)->tick <= tick) {
        const plant_edge_t *edge = pending(plant, 0);
        if (edge_is_silent(plant, edge)) {
            plant->on ^= UINT32_C(1) << edge->gate;
            plant->kind[edge->gate >> 1] = plant->on >> (edge->gate & 6u) & 3u;
            plant->calm_ticks = 0;
            drop_first(plant);
        } else {
            integrate(plant, edge->tick);
            act_pending(plant);
        }
    }
}

void plant_advance(plant_t *plant, uint64_t tick)
{
    run_edges(plant, tick);
    integrate(plant, tick);
}

void plant_gates(plant_t *plant, uint64_t tick, uint32_t on)
{
    on &= ALL_GATES;
    if (plant->averaged) {
        plant_advance(plant, tick);
        plant->averaged = PLANT_EDGES;
        plant->commanded = on;
        plant->on = on;
        legs_follow(plant);
        for (uint32_t leg = 0; leg < 3; leg++) {
            if (plant->kind[leg] == PLANT_LAW_BOTH) {
                shoot_through(plant, leg);
            }
        }
        return;
    }
    run_edges(plant, tick);
    uint32_t changed = on ^ plant->commanded;
    plant->commanded = on;
    for (uint32_t gate = 0; changed; gate++, changed >>= 1) {
        if (changed & 1u) {
            uint32_t rises = on >> gate & 1u;
            push_edge(plant, tick + (rises ? plant->turn_on_ticks : plant->turn_off_ticks), gate, rises);
        }
    }
}

void plant_carrier(plant_t *plant, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                   bool upper)
{
    assert(period > 0);
    plant_advance(plant, tick);
    plant->averaged = upper ? PLANT_AVERAGED_UPPER : PLANT_AVERAGED_LOWER;
    plant->period = period;
    memcpy(plant->high, high, sizeof plant->high);
    plant->dead = dead;
    plant->pending_count = 0;
    memset(plant->waiting, 0, sizeof plant->waiting);
    plant->commanded = 0;
    plant->on = 0;
    plant->shut = module_shut(plant) ? ALL_GATES : 0;
    averaged_period(plant);
    legs_follow(plant);
}

/* ---- start and parameters ---- */

/* Torques on the shaft that do not come from the air gap. */
static void make_shaft(plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    bool passive = q->load_kind == PLANT_LOAD_PASSIVE;
    double opposing = passive ? q->load_torque : 0.0;
    plant->active_torque = passive ? 0.0 : q->load_torque;
    plant->dry_torque = q->friction_coulomb + opposing + plant->brake_torque;
    bool sticks = q->friction_breakaway > 0.0 || plant->brake_torque > 0.0;
    double friction =
        q->friction_breakaway > q->friction_coulomb ? q->friction_breakaway : q->friction_coulomb;
    plant->hold_torque = sticks ? friction + opposing + plant->brake_torque : 0.0;
    double width = PLANT_SHAFT_FOLLOW * plant->dry_torque * plant->inertia_inverse;
    plant->width_inverse = 1.0 / (width > PLANT_SHAFT_WIDTH ? width : PLANT_SHAFT_WIDTH);
}

void plant_set_params(plant_t *plant, const plant_params_t *params)
{
    assert(plant_params_check(params, NULL));
    const plant_params_t *q = &plant->params;
    bool was_forced = q->force_fault != 0.0;
    plant->params = *params;

    plant->p = q->pole_pairs;
    plant->count_per_rad = 4.0 * q->encoder_lines / (PHASOR_TWO_PI * q->pole_pairs);
    interval_count_turns(plant);
    plant->r_mean = 0.5 * (q->igbt_resistance + q->diode_resistance);
    plant->k_d = 1.0 / q->inductance_d;
    plant->k_q = 1.0 / q->inductance_q;
    plant->k_max = plant->k_d > plant->k_q ? plant->k_d : plant->k_q;
    plant->decay_d = (q->resistance + plant->r_mean) * plant->k_d;
    plant->decay_q = (q->resistance + plant->r_mean) * plant->k_q;
    plant->cross_d = q->inductance_q * plant->k_d;
    plant->cross_q = q->inductance_d * plant->k_q;
    plant->saliency = q->inductance_d - q->inductance_q;
    plant->emf_q = q->flux_linkage * plant->k_q;
    plant->emf_d6 = q->flux_linkage * (q->emf_5th + q->emf_7th);
    plant->emf_q6 = q->flux_linkage * (q->emf_7th - q->emf_5th);
    plant->emf_bound = q->flux_linkage * (1.0 + fabs(q->emf_5th) + fabs(q->emf_7th));
    plant->harmonics = q->emf_5th != 0.0 || q->emf_7th != 0.0;

    plant->inertia_inverse = 1.0 / q->inertia;
    make_shaft(plant);
    if (q->shaft_locked != 0.0) {
        plant->omega_m = q->shaft_locked_speed;
    }

    plant->rate = (q->resistance + plant->r_mean) * plant->k_max +
                  q->pole_pairs * q->flux_linkage * sqrt(1.5 * plant->k_max * plant->inertia_inverse);

    bool stiff = q->dc_capacitance == 0.0 || q->dc_resistance == 0.0;
    plant->link_rate = stiff ? 0.0 : 1.0 / q->dc_capacitance;
    plant->source_rate = stiff ? 0.0 : plant->link_rate / q->dc_resistance;
    if (stiff) {
        plant->v_dc = q->dc_voltage;
    }

    double narrowest = (0.5 * q->dc_voltage + q->diode_voltage) * ZONE_TIME * plant->k_max;
    plant->zone = q->current_zone > narrowest ? q->current_zone : narrowest;
    plant->zone = plant->zone > 1e-6 ? plant->zone : 1e-6;
    plant->zone_inverse = 1.0 / plant->zone;
    plant->trip_square =
        q->short_circuit_current > 0.0 ? q->short_circuit_current * q->short_circuit_current : NO_TRIP;
    plant->volts_per_ampere = 1.5 / q->current_range;
    plant->volts_per_volt = 3.0 / q->dc_range;
    plant->turn_on_ticks = ticks_of(q->turn_on_delay);
    plant->turn_off_ticks = ticks_of(q->turn_off_delay);
    plant->pulse_ticks = ticks_of(q->fault_pulse);
    make_laws(plant);

    plant->open = (q->open_phase_a != 0.0 ? 1u : 0u) | (q->open_phase_b != 0.0 ? 2u : 0u) |
                  (q->open_phase_c != 0.0 ? 4u : 0u);
    if (q->current_bandwidth == 0.0) {
        plant->sensed[0] = plant->i[0];
        plant->sensed[1] = plant->i[1];
        plant->sensed[2] = plant->i[2];
    }
    if (q->force_fault != 0.0) {
        plant->shut = ALL_GATES;
        if (!was_forced) {
            plant->fault_until = plant->tick + plant->pulse_ticks;
        }
    }
    want_extras(plant);
    legs_follow(plant);
    interval_restart(plant);
}

void plant_init(plant_t *plant, const plant_params_t *params, uint64_t seed)
{
    memset(plant, 0, sizeof *plant);
    plant->random = seed;
    plant->shoot_through_tick = PLANT_NEVER;
    plant->cos_e = 1.0;
    plant->idle = 1;
    plant->v_dc = params->dc_voltage;
    plant_set_params(plant, params);
}

void plant_set_motion(plant_t *plant, double theta_m, double omega_m)
{
    double theta = theta_m * plant->p;
    double turns = floor(theta * (1.0 / PHASOR_TWO_PI) + 0.5);
    plant->turns = (int64_t)turns;
    plant->theta_e = theta - turns * PHASOR_TWO_PI;
    if (plant->theta_e >= PHASOR_PI) {
        plant->theta_e -= PHASOR_TWO_PI;
        plant->turns++;
    } else if (plant->theta_e < -PHASOR_PI) {
        plant->theta_e += PHASOR_TWO_PI;
        plant->turns--;
    }
    interval_count_turns(plant);
    phasor_at(plant->theta_e, &plant->cos_e, &plant->sin_e);
    plant->steps = 0;
    if (plant->params.shaft_locked == 0.0) {
        plant->omega_m = omega_m;
    }
    interval_restart(plant);
}

void plant_set_brake(plant_t *plant, double torque)
{
    assert(torque >= 0.0);
    plant->brake_torque = torque;
    make_shaft(plant);
    interval_restart(plant);
}

void plant_set_metering(plant_t *plant, bool on)
{
    plant->metering = on;
    want_extras(plant);
    if (on) {
        plant->energy_dc = 0.0;
        plant->energy_copper = 0.0;
        plant->energy_inverter = 0.0;
        plant->energy_mechanical = 0.0;
    }
}

/* ---- sensors ---- */

static double at_pin(double volts)
{
    return volts < 0.0 ? 0.0 : volts > 3.0 ? 3.0 : volts;
}

static double current_pin(plant_t *plant, double i, double gain_error, double offset)
{
    const plant_params_t *q = &plant->params;
    double seen = (1.0 + gain_error) * i + offset;
    if (q->current_noise > 0.0) {
        seen += q->current_noise * noise_gauss(&plant->random);
    }
    return at_pin(q->current_zero + plant->volts_per_ampere * seen);
}

static double temperature_pin(double temperature, double at_0v, double at_3v)
{
    return at_pin((temperature - at_0v) * 3.0 / (at_3v - at_0v));
}

double plant_analog(plant_t *plant, plant_channel_t channel)
{
    const plant_params_t *q = &plant->params;
    const double *i = q->current_bandwidth > 0.0 ? plant->sensed : plant->i;
    switch (channel) {
    case PLANT_CURRENT_A:
        return current_pin(plant, i[0], q->current_gain_error_a, q->current_offset_a);
    case PLANT_CURRENT_B:
        return current_pin(plant, i[1], q->current_gain_error_b, q->current_offset_b);
    case PLANT_CURRENT_C:
        return current_pin(plant, i[2], q->current_gain_error_c, q->current_offset_c);
    case PLANT_DC_LINK: {
        double seen = (1.0 + q->dc_gain_error) * plant->v_dc;
        if (q->dc_noise > 0.0) {
            seen += q->dc_noise * noise_gauss(&plant->random);
        }
        return at_pin(plant->volts_per_volt * seen);
    }
    case PLANT_SINK:
        return temperature_pin(q->sink_temperature, BOARD_SINK_AT_0V, BOARD_SINK_AT_3V);
    case PLANT_MOTOR:
        return temperature_pin(q->motor_temperature, BOARD_MOTOR_AT_0V, BOARD_MOTOR_AT_3V);
    }
    return 0.0;
}

/* floor(), for what fits 64 bits; one comparison for what is not negative. */
static int64_t floor_of(double x)
{
    if (x >= 0.0) {
        return (int64_t)x;
    }
    int64_t n = (int64_t)x;
    return n - ((double)n > x);
}

static int64_t encoder_counts(const plant_t *plant, double theta_e)
{
    return plant->count_whole + floor_of(theta_e * plant->count_per_rad + plant->count_rest);
}

int64_t plant_encoder(const plant_t *plant)
{
    return encoder_counts(plant, plant->theta_e);
}

int64_t plant_encoder_at(const plant_t *plant, uint64_t tick)
{
    double ahead = (double)(int64_t)(tick - plant->tick) * (1.0 / (double)PLANT_TICKS_PER_SECOND);
    return encoder_counts(plant, plant->theta_e + plant->p * plant->omega_m * ahead);
}

bool plant_fault_line(const plant_t *plant)
{
    return module_shut(plant);
}

/* ---- truth ---- */

static plant_leg_t leg_state(const plant_t *plant, uint32_t leg)
{
    double i = plant->i[leg];
    uint32_t kind = plant->kind[leg];
    if ((plant->open >> leg & 1u) || plant->idle) {
        return PLANT_LEG_OPEN;
    }
    if (kind == PLANT_LAW_BOTH) {
        return PLANT_LEG_SHOOT_THROUGH;
    }
    if (kind >= PLANT_LAW_AVERAGED) {
        return PLANT_LEG_AVERAGED;
    }
    if (fabs(i) < plant->zone) {
        return PLANT_LEG_ZONE;
    }
    if (i > 0.0) {
        return kind == PLANT_LAW_UPPER ? PLANT_LEG_UPPER_IGBT : PLANT_LEG_LOWER_DIODE;
    }
    return kind == PLANT_LAW_LOWER ? PLANT_LEG_LOWER_IGBT : PLANT_LEG_UPPER_DIODE;
}

void plant_truth(const plant_t *plant, plant_truth_t *truth)
{
    const plant_params_t *q = &plant->params;
    memset(truth, 0, sizeof *truth);
    truth->theta_e = plant->theta_e;
    truth->omega_e = plant->p * plant->omega_m;
    truth->theta_m = (plant->theta_e + PHASOR_TWO_PI * (double)plant->turns) / plant->p;
    truth->omega_m = plant->omega_m;
    truth->torque = plant->torque;
    bool fixed = q->shaft_locked != 0.0 || interval_held(plant);
    truth->load_torque = fixed ? plant->torque : interval_resistance(plant, plant->omega_m);
    truth->i_a = plant->i[0];
    truth->i_b = plant->i[1];
    truth->i_c = plant->i[2];
    truth->i_d = plant->i_d;
    truth->i_q = plant->i_q;
    interval_voltage(plant, &truth->u_alpha, &truth->u_beta);
    truth->flux_alpha = plant->flux_alpha;
    truth->flux_beta = plant->flux_beta;
    truth->dc_voltage = plant->v_dc;
    truth->leg_a = leg_state(plant, 0);
    truth->leg_b = leg_state(plant, 1);
    truth->leg_c = leg_state(plant, 2);
    truth->shoot_throughs = plant->shoot_throughs;
    truth->shoot_through_second =
        plant->shoot_through_tick == PLANT_NEVER ? -1.0 : (double)plant->shoot_through_tick * TICK;
    truth->shoot_through_leg = plant->shoot_through_tick == PLANT_NEVER ? -1.0 : plant->shoot_through_leg;
    truth->fault_line = module_shut(plant) ? 1.0 : 0.0;
    truth->shut_gates = plant->shut;
    truth->energy_dc = plant->energy_dc;
    truth->energy_copper = plant->energy_copper;
    truth->energy_inverter = plant->energy_inverter;
    truth->energy_mechanical = plant->energy_mechanical;
    truth->energy_magnetic =
        0.75 * (q->inductance_d * plant->i_d * plant->i_d + q->inductance_q * plant->i_q * plant->i_q);
    truth->energy_kinetic = 0.5 * q->inertia * plant->omega_m * plant->omega_m;
}

const char *plant_leg_text(plant_leg_t leg)
{
    switch (leg) {
    case PLANT_LEG_OPEN:
        return "open";
    case PLANT_LEG_UPPER_IGBT:
        return "upper IGBT";
    case PLANT_LEG_UPPER_DIODE:
        return "upper diode";
    case PLANT_LEG_LOWER_IGBT:
        return "lower IGBT";
    case PLANT_LEG_LOWER_DIODE:
        return "lower diode";
    case PLANT_LEG_ZONE:
        return "zone";
    case PLANT_LEG_SHOOT_THROUGH:
        return "shoot-through";
    case PLANT_LEG_AVERAGED:
        return "averaged";
    }
    return "?";
}
