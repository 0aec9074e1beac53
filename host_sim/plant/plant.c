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

/* The law with a drop [V] and a resistance [ohm] that only this leg has. */
static plant_law_t law_of(const plant_params_t *q, double share_positive, double share_negative, double drop,
                          double resistance)
{
    double sp = share_positive;
    double sn = share_negative;
    plant_law_t law = {
        {sp, sn},
        {-sp * q->igbt_voltage - (1.0 - sp) * q->diode_voltage - drop,
         sn * q->diode_voltage + (1.0 - sn) * q->igbt_voltage + drop},
        {sp * q->igbt_resistance + (1.0 - sp) * q->diode_resistance + resistance,
         sn * q->diode_resistance + (1.0 - sn) * q->igbt_resistance + resistance},
    };
    return law;
}

/* Laws and delays of the legs; the larger of their own resistances [ohm]. */
static double make_legs(plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    const double drop[3] = {q->leg_a_drop, q->leg_b_drop, q->leg_c_drop};
    const double resistance[3] = {q->leg_a_resistance, q->leg_b_resistance, q->leg_c_resistance};
    const double delay[3] = {q->leg_a_delay, q->leg_b_delay, q->leg_c_delay};
    double most = 0.0;
    for (uint32_t leg = 0; leg < 3; leg++) {
        double d = drop[leg];
        double r = resistance[leg];
        plant_law_t *law = plant->law[plant->wire[leg]];
        /* With both switches off the lower diode conducts for i > 0 and the upper diode for i < 0; the
         * averaged law at these shares gives the same voltages.
         */
        law[PLANT_LAW_OFF] = law_of(q, 0.0, 1.0, d, r);
        law[PLANT_LAW_UPPER] = law_of(q, 1.0, 1.0, d, r);
        law[PLANT_LAW_LOWER] = law_of(q, 0.0, 0.0, d, r);
        law[PLANT_LAW_BOTH] = (plant_law_t){{0.5, 0.5}, {0.0, 0.0}, {r, r}};
        plant->turn_on_ticks[plant->wire[leg]] = ticks_of(q->turn_on_delay + delay[leg]);
        most = r > most ? r : most;
    }
    return most;
}

static void want_extras(plant_t *plant)
{
    plant->extras =
        plant->metering || plant->link_rate > 0.0 || plant->ripples || plant->params.current_bandwidth > 0.0;
}

static bool module_shut(const plant_t *plant)
{
    return plant->tick < plant->fault_until || plant->params.force_fault != 0.0;
}

/* ---- wires ---- */

/* The phase that replaces phase n, 0..2, if two phases are exchanged: 1 b with c, 2 c with a, 3 a with b; 0
 * none. */
static uint32_t changed(double pair, uint32_t n)
{
    uint32_t swap = (uint32_t)pair;
    return swap == 0u || n == swap - 1u ? n : 4u - swap - n;
}

/* The sensor whose signal is read as that of phase n: 4 the next one, 5 the one before, else a pair changes
 * places. */
static uint32_t sensor_of(double swap, uint32_t n)
{
    return swap > 3.0 ? (n + (uint32_t)swap - 3u) % 3u : changed(swap, n);
}

/* Gate bits by legs as bits by the phases on their wires, and the other way round: a pair changes places. */
static uint32_t rewired(const plant_t *plant, uint32_t gates)
{
    if (!plant->rewired) {
        return gates;
    }
    uint32_t bits = 0;
    for (uint32_t leg = 0; leg < 3; leg++) {
        bits |= (gates >> (2u * leg) & 3u) << (2u * plant->wire[leg]);
    }
    return bits;
}

/* Exchanges two motor wires: all values that belong to legs move to the other phases. */
static void rewire(plant_t *plant, double pair)
{
    plant->rewired = pair != 0.0;
    uint32_t moved[3]; /* for each phase, the phase to which its leg is connected from now on */
    for (uint32_t leg = 0; leg < 3; leg++) {
        moved[plant->wire[leg]] = changed(pair, leg);
        plant->wire[leg] = changed(pair, leg);
    }
    const plant_t before = *plant;
    plant->on = 0;
    plant->commanded = 0;
    plant->shut = 0;
    for (uint32_t from = 0; from < 3; from++) {
        uint32_t to = moved[from];
        plant->on |= (before.on >> (2u * from) & 3u) << (2u * to);
        plant->commanded |= (before.commanded >> (2u * from) & 3u) << (2u * to);
        plant->shut |= (before.shut >> (2u * from) & 3u) << (2u * to);
        plant->waiting[2u * to] = before.waiting[2u * from];
        plant->waiting[2u * to + 1u] = before.waiting[2u * from + 1u];
        plant->high[to] = before.high[from];
        plant->sensed[to] = before.sensed[from];
        plant->law[to][PLANT_LAW_AVERAGED] = before.law[from][PLANT_LAW_AVERAGED];
    }
    for (uint32_t n = 0; n < PLANT_PENDING; n++) {
        uint32_t gate = before.pending[n].gate;
        plant->pending[n].gate = 2u * moved[gate >> 1] + (gate & 1u);
    }
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
    uint32_t on = plant->on & ~plant->shut;
    if (plant->stuck_gates) {
        on = (on & ~plant->never_on) | plant->always_on;
    }
    plant->kind[leg] = on >> (2u * leg) & 3u;
    if (plant->kind[leg] != PLANT_LAW_OFF) {
        plant->idle = 0;
        plant->calm_ticks = 0;
    }
}

/* Laws of all legs from the switches that conduct. */
static void legs_follow(plant_t *plant)
{
    for (uint32_t leg = 0; leg < 3; leg++) {
        leg_follows(plant, leg);
        if (plant->averaged && !plant->shut) {
            plant->kind[leg] = PLANT_LAW_AVERAGED;
            plant->idle = 0;
            plant->calm_ticks = 0;
        }
    }
}

static void shoot_through(plant_t *plant, uint32_t leg)
{
    plant->shoot_throughs++;
    plant->shoot_through_tick = plant->tick;
    plant->shoot_through_leg = changed(plant->params.swap_phases, leg);
    if (plant->trip_square < NO_TRIP) {
        trip(plant, PLANT_UPPER(leg) | LOWER_GATES);
        legs_follow(plant);
    }
}

/* Arms whose IGBT carries too much current. This is rare, so the length of the current vector is examined
 * first. */
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
    if ((before | after) != diode_twin || (plant->shut | plant->idle | plant->stuck_gates)) {
        return false;
    }
    /* |di/dt| of a phase: two thirds of the link plus a fifth for drops and resistance, which is a safe
     * limit, plus EMF.
     */
    double fastest = (plant->v_dc * 1.2 + fabs(plant->omega_m) * plant->p * plant->emf_bound) * plant->k_max;
    return fabs(i) > plant->zone + fastest * TICK * (double)(int64_t)(edge->tick - plant->tick);
}

static void push_edge(plant_t *plant, uint64_t tick, uint32_t gate, uint32_t on)
{
    if (plant->waiting[gate]) {
        /* The last pending edge of this gate is the opposite one: if it is overtaken, or there are too many
         * edges, both are removed. */
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
    on = rewired(plant, on & ALL_GATES);
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
    for (uint32_t changes = on ^ plant->commanded; changes != 0u; changes &= changes - 1u) {
        uint32_t gate = (uint32_t)__builtin_ctz(changes); /* the lowest of them */
        uint32_t rises = on >> gate & 1u;
        push_edge(plant, tick + (rises ? plant->turn_on_ticks[gate >> 1] : plant->turn_off_ticks), gate,
                  rises);
    }
    plant->commanded = on;
}

void plant_carrier(plant_t *plant, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                   bool upper)
{
    assert(period > 0);
    plant_advance(plant, tick);
    plant->averaged = upper ? PLANT_AVERAGED_UPPER : PLANT_AVERAGED_LOWER;
    plant->period = period;
    for (uint32_t leg = 0; leg < 3; leg++) {
        plant->high[plant->wire[leg]] = high[leg];
    }
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

/* Half width of the smooth sign of this dry torque on this inertia, inverse [s/rad]. */
static double width_inverse(double dry_torque, double inertia_inverse)
{
    double width = PLANT_SHAFT_FOLLOW * dry_torque * inertia_inverse;
    return 1.0 / (width > PLANT_SHAFT_WIDTH ? width : PLANT_SHAFT_WIDTH);
}

/* Torques on the shaft that do not come from the air gap; the load is at the far end of an elastic one. */
static void make_shaft(plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    bool elastic = plant->load_inverse > 0.0;
    bool passive = q->load_kind == PLANT_LOAD_PASSIVE;
    double load = passive ? q->load_torque : 0.0;
    double active = passive ? 0.0 : q->load_torque;
    double opposing = elastic ? 0.0 : load;
    plant->load_torque = elastic ? load : 0.0;
    plant->load_active = elastic ? active : 0.0;
    plant->load_width_inverse = width_inverse(plant->load_torque, plant->load_inverse);
    plant->active_torque = elastic ? 0.0 : active;
    double brake = plant->brake_torque + (plant->holds != 0u ? q->holding_torque : 0.0);
    plant->dry_torque = q->friction_coulomb + opposing + brake;
    bool sticks = q->friction_breakaway > 0.0 || brake > 0.0;
    double friction =
        q->friction_breakaway > q->friction_coulomb ? q->friction_breakaway : q->friction_coulomb;
    plant->hold_torque = sticks ? friction + opposing + brake : 0.0;
    plant->width_inverse = width_inverse(plant->dry_torque, plant->inertia_inverse);
}

/* Loads that depend on the square of the speed or on the angle, and the rate of the oscillation of their
 * inertia.
 */
static void make_works(plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    double inverse = plant->load_inverse > 0.0 ? plant->load_inverse : plant->inertia_inverse;
    double stiffness = q->load_spring + q->load_sine_cycles * fabs(q->load_sine);
    const double table[8] = {0.0,
                             q->load_table_1,
                             q->load_table_2,
                             q->load_table_3,
                             q->load_table_4,
                             q->load_table_5,
                             q->load_table_6,
                             q->load_table_6};
    double steepest = 0.0;
    for (uint32_t n = 0; n < 8u; n++) {
        double rise = n > 0u ? fabs(table[n] - table[n - 1u]) : 0.0;
        steepest = rise > steepest ? rise : steepest;
        plant->table[n] = table[n];
    }
    plant->table_inverse = q->load_table_speed > 0.0 ? 1.0 / q->load_table_speed : 0.0;
    plant->works = q->load_quadratic != 0.0 || stiffness != 0.0 || plant->table_inverse != 0.0;
    plant->work_rate = sqrt(stiffness * inverse) + steepest * plant->table_inverse * inverse;
}

/* The rotating masses: one, or two with the shaft between them. If the shaft becomes elastic, the far end
 * continues at the speed of the motor; if it becomes rigid, the momentum of both is kept. */
static void make_masses(plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    bool was = plant->load_inverse > 0.0;
    bool elastic = q->load_inertia > 0.0 && q->shaft_stiffness > 0.0;
    plant->inertia_inverse = 1.0 / (q->inertia + (elastic ? 0.0 : q->load_inertia));
    plant->load_inverse = elastic ? 1.0 / q->load_inertia : 0.0;
    if (q->shaft_locked != 0.0) {
        plant->omega_m = q->shaft_locked_speed;
    } else if (was && !elastic) {
        plant->omega_m =
            (q->inertia * plant->omega_m + q->load_inertia * plant->omega_load) * plant->inertia_inverse;
    }
    if (was != elastic) {
        plant->twist = 0.0;
        plant->omega_load = elastic ? plant->omega_m : 0.0;
    }
    make_shaft(plant);
    make_works(plant);
}

/* Frequency of the oscillation and rate of decay of the twist [1/s]. */
static double shaft_rate(const plant_t *plant)
{
    if (plant->load_inverse == 0.0) {
        return 0.0;
    }
    double sum = plant->inertia_inverse + plant->load_inverse;
    return sqrt(plant->params.shaft_stiffness * sum) + plant->params.shaft_damping * sum;
}

static void make_link(plant_t *plant, const plant_params_t *before)
{
    const plant_params_t *q = &plant->params;
    if (q->dc_ripple != before->dc_ripple || q->dc_ripple_frequency != before->dc_ripple_frequency) {
        plant->ripple_since = plant->tick;
    }
    bool lost = q->supply_lost != 0.0;
    bool stiff = q->dc_capacitance == 0.0 || (q->dc_resistance == 0.0 && !lost);
    plant->ripples = q->dc_ripple != 0.0 && stiff;
    plant->link_rate = stiff ? 0.0 : 1.0 / q->dc_capacitance;
    plant->source_rate = stiff || lost ? 0.0 : plant->link_rate / q->dc_resistance;
    plant->chopper_rate = q->chopper_resistance > 0.0 ? plant->link_rate / q->chopper_resistance : 0.0;
    if (stiff) {
        plant->v_dc = interval_source(plant, 0.0);
    }
}

/* Tracks A (1) and B (2) of the encoder at the position `count` of its disc: 00, A, AB, B and round again. */
static uint32_t tracks_at(const plant_params_t *q, int64_t count)
{
    static const uint32_t way[4] = {0u, 1u, 3u, 2u};
    uint32_t tracks = way[(uint64_t)count & 3u];
    tracks = q->encoder_stuck_a < 0.0 ? tracks : (tracks & 2u) | (uint32_t)q->encoder_stuck_a;
    return q->encoder_stuck_b < 0.0 ? tracks : (tracks & 1u) | (uint32_t)q->encoder_stuck_b << 1;
}

/* Edges [counts] that the decoder counts for a step from these tracks to those; two at once count as none. */
static int64_t quadrature(uint32_t from, uint32_t to)
{
    static const int64_t place[4] = {0, 1, 3, 2};
    static const int64_t edges[4] = {0, 1, 0, -1};
    return edges[(uint32_t)(place[to] - place[from]) & 3u];
}

static int64_t disc_count(const plant_t *plant, double theta_e);
static int64_t shown_count(const plant_t *plant, int64_t count);

/* Sets the faults of the encoder; they do not change counts before this time. */
static void make_encoder(plant_t *plant, const plant_params_t *before, int64_t shown, uint32_t tracks)
{
    const plant_params_t *q = &plant->params;
    plant->count_per_rad = 4.0 * q->encoder_lines * (1.0 - q->encoder_slip) / (PHASOR_TWO_PI * q->pole_pairs);
    interval_count_turns(plant);
    plant->tracks = q->encoder_reversed != 0.0 || q->encoder_stuck_a >= 0.0 || q->encoder_stuck_b >= 0.0;
    bool stuck =
        q->encoder_stuck_a != before->encoder_stuck_a || q->encoder_stuck_b != before->encoder_stuck_b;
    if (stuck || q->encoder_slip != before->encoder_slip || q->encoder_reversed != before->encoder_reversed) {
        int64_t count = disc_count(plant, plant->theta_e);
        int64_t step = stuck ? quadrature(tracks, tracks_at(q, count)) : 0;
        plant->count_shift += shown + (q->encoder_reversed != 0.0 ? -step : step) - shown_count(plant, count);
    }
}

/* The basis of the length of a step: the fastest rate of change. `own`: the largest resistance of a
 * leg's own. */
static void make_rate(plant_t *plant, double own)
{
    const plant_params_t *q = &plant->params;
    plant->bend_d = q->saturation_d > 0.0 ? 1.0 / (q->saturation_d * q->saturation_d) : 0.0;
    plant->bend_q = q->saturation_q > 0.0 ? 1.0 / (q->saturation_q * q->saturation_q) : 0.0;
    plant->map = (uint32_t)q->flux_map;
    plant->saturates =
        plant->bend_d > 0.0 || plant->bend_q > 0.0 || plant->map != 0u || q->iron_loss_resistance > 0.0;
    plant->ohms = q->resistance + plant->r_mean + own;
    plant->rate_other =
        (q->dc_ripple != 0.0 ? q->dc_ripple_frequency : 0.0) + shaft_rate(plant) + plant->work_rate;
    plant->rate = plant->ohms * plant->k_max +
                  q->pole_pairs * q->flux_linkage * sqrt(1.5 * plant->k_max * plant->inertia_inverse) +
                  plant->rate_other;
}

void plant_set_params(plant_t *plant, const plant_params_t *params)
{
    assert(plant_params_check(params, NULL));
    const plant_params_t *q = &plant->params;
    const plant_params_t before = *q;
    const int64_t count = disc_count(plant, plant->theta_e);
    const int64_t shown = shown_count(plant, count);
    const uint32_t tracks = tracks_at(q, count);
    plant->params = *params;

    plant->p = q->pole_pairs;
    make_encoder(plant, &before, shown, tracks);
    if (q->swap_phases != before.swap_phases) {
        rewire(plant, q->swap_phases);
    }
    plant->never_on = rewired(plant, (uint32_t)q->open_switches);
    plant->always_on = rewired(plant, (uint32_t)q->shorted_switches);
    plant->stuck_gates = plant->never_on | plant->always_on;
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

    make_masses(plant);
    make_link(plant, &before);
    double own = make_legs(plant);
    plant->uneven = own > 0.0;

    make_rate(plant, own);

    double narrowest = (0.5 * q->dc_voltage + q->diode_voltage) * ZONE_TIME * plant->k_max;
    plant->zone = q->current_zone > narrowest ? q->current_zone : narrowest;
    plant->zone = plant->zone > 1e-6 ? plant->zone : 1e-6;
    plant->zone_inverse = 1.0 / plant->zone;
    plant->trip_square =
        q->short_circuit_current > 0.0 ? q->short_circuit_current * q->short_circuit_current : NO_TRIP;
    plant->volts_per_ampere = 1.5 / q->current_range;
    plant->volts_per_volt = 3.0 / q->dc_range;
    plant->turn_off_ticks = ticks_of(q->turn_off_delay);
    plant->pulse_ticks = ticks_of(q->fault_pulse);

    plant->open = (q->open_phase_a != 0.0 ? 1u : 0u) | (q->open_phase_b != 0.0 ? 2u : 0u) |
                  (q->open_phase_c != 0.0 ? 4u : 0u);
    if (q->current_bandwidth == 0.0) {
        plant->sensed[0] = plant->i[0];
        plant->sensed[1] = plant->i[1];
        plant->sensed[2] = plant->i[2];
    }
    if (q->force_fault != 0.0) {
        plant->shut = ALL_GATES;
        if (before.force_fault == 0.0) {
            plant->fault_until = plant->tick + plant->pulse_ticks;
        }
    }
    want_extras(plant);
    const uint32_t was[3] = {plant->kind[0], plant->kind[1], plant->kind[2]};
    legs_follow(plant);
    interval_restart(plant);
    for (uint32_t leg = 0; leg < 3 && plant->always_on != 0u; leg++) {
        if (plant->kind[leg] == PLANT_LAW_BOTH && was[leg] != PLANT_LAW_BOTH) {
            shoot_through(plant, leg);
        }
    }
}

void plant_init(plant_t *plant, const plant_params_t *params, uint64_t seed)
{
    memset(plant, 0, sizeof *plant);
    plant->random = seed;
    plant->shoot_through_tick = PLANT_NEVER;
    plant->cos_e = 1.0;
    plant->idle = 1;
    plant->holds = 1;
    plant->v_dc = params->dc_voltage;
    for (uint32_t leg = 0; leg < 3; leg++) {
        plant->wire[leg] = leg;
    }
    /* An encoder that is broken from the start has no previous count. */
    plant->params.encoder_slip = params->encoder_slip;
    plant->params.encoder_reversed = params->encoder_reversed;
    plant->params.encoder_stuck_a = params->encoder_stuck_a;
    plant->params.encoder_stuck_b = params->encoder_stuck_b;
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
    plant->omega_load = plant->load_inverse > 0.0 ? plant->omega_m : 0.0;
    plant->twist = 0.0;
    interval_restart(plant);
}

void plant_set_brake(plant_t *plant, double torque)
{
    assert(torque >= 0.0);
    plant->brake_torque = torque;
    make_shaft(plant);
    interval_restart(plant);
}

void plant_outputs(plant_t *plant, bool chopper, bool released)
{
    const plant_params_t *q = &plant->params;
    plant->chops = chopper;
    if (plant->released != (uint32_t)released) {
        plant->released = released;
        plant->holding_since = plant->tick;
    }
    double passed = (double)(plant->tick - plant->holding_since) / (double)PLANT_TICKS_PER_SECOND;
    bool late = passed >= (released ? q->holding_release_time : q->holding_apply_time);
    if (late && plant->holds == (uint32_t)released) {
        plant->holds = !released;
        if (q->holding_torque > 0.0) {
            make_shaft(plant);
            interval_restart(plant);
        }
    }
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

/* The phase whose pin is assigned to the current of leg n. */
static double current_pin(plant_t *plant, uint32_t n)
{
    const plant_params_t *q = &plant->params;
    const double gain_error[3] = {q->current_gain_error_a, q->current_gain_error_b, q->current_gain_error_c};
    const double offset[3] = {q->current_offset_a, q->current_offset_b, q->current_offset_c};
    const double *i = q->current_bandwidth > 0.0 ? plant->sensed : plant->i;
    uint32_t sensor = sensor_of(q->swap_currents, n);
    double seen = (1.0 + gain_error[sensor]) * i[plant->wire[sensor]] + offset[sensor];
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
    switch (channel) {
    case PLANT_CURRENT_A:
    case PLANT_CURRENT_B:
    case PLANT_CURRENT_C:
        return current_pin(plant, (uint32_t)(channel - PLANT_CURRENT_A));
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

/* floor() for numbers that fit into 64 bits; a number that is not negative needs only one comparison. */
static int64_t floor_of(double x)
{
    if (x >= 0.0) {
        return (int64_t)x;
    }
    int64_t n = (int64_t)x;
    return n - ((double)n > x);
}

/* The number of edges of the disc that have passed. */
static int64_t disc_count(const plant_t *plant, double theta_e)
{
    return plant->count_whole + floor_of(theta_e * plant->count_per_rad + plant->count_rest);
}

/* The count with the tracks' faults: if one is stuck, the edges of the other count forward and backward. */
static int64_t shown_count(const plant_t *plant, int64_t count)
{
    if (!plant->tracks) {
        return plant->count_shift + count;
    }
    const plant_params_t *q = &plant->params;
    bool stuck_a = q->encoder_stuck_a >= 0.0;
    bool stuck_b = q->encoder_stuck_b >= 0.0;
    if (stuck_a || stuck_b) {
        uint32_t moved = tracks_at(q, count);
        uint32_t still = (stuck_a ? moved & 1u : 0u) | (stuck_b ? moved & 2u : 0u);
        count = quadrature(still, moved);
    }
    return plant->count_shift + (q->encoder_reversed != 0.0 ? -count : count);
}

static int64_t encoder_counts(const plant_t *plant, double theta_e)
{
    return shown_count(plant, disc_count(plant, theta_e));
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

static plant_leg_t leg_state(const plant_t *plant, uint32_t leg_of_module)
{
    uint32_t leg = plant->wire[leg_of_module];
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
    truth->theta_m = interval_angle(plant);
    truth->omega_m = plant->omega_m;
    truth->torque = plant->torque;
    truth->load_torque = interval_load(plant);
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
    truth->shut_gates = rewired(plant, plant->shut);
    truth->energy_dc = plant->energy_dc;
    truth->energy_copper = plant->energy_copper;
    truth->energy_inverter = plant->energy_inverter;
    truth->energy_mechanical = plant->energy_mechanical;
    truth->energy_magnetic = interval_magnetic(plant);
    truth->omega_load = plant->load_inverse > 0.0 ? plant->omega_load : plant->omega_m;
    truth->twist = plant->twist;
    truth->shaft_torque = plant->shaft_torque;
    bool elastic = plant->load_inverse > 0.0;
    truth->energy_kinetic =
        0.5 * (q->inertia + (elastic ? 0.0 : q->load_inertia)) * plant->omega_m * plant->omega_m;
    if (elastic) {
        truth->energy_kinetic += 0.5 * q->load_inertia * plant->omega_load * plant->omega_load +
                                 0.5 * q->shaft_stiffness * plant->twist * plant->twist;
    }
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
