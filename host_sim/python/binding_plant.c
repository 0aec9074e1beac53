/* The plant by itself, a carrier period at a time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/python/binding.h"

#define LEGS      3u
#define VOLT_HALF 1.5 /* [V] of the pin for current_range */
#define VOLT_FULL 3.0 /* [V] of the pin for dc_range */

/* The command of a leg before the dead band. The selected switch gets its turn-on command at `on_at`, unless
 * the command changes again before. */
typedef struct {
    bool upper;
    uint64_t on_at; /* [ticks]; PLANT_NEVER: it is on */
} leg_t;

struct binding_plant {
    plant_t plant;
    plant_params_t params;
    uint64_t tick;
    uint32_t ticks, dead; /* [1/150 MHz] */
    uint32_t gates;       /* as last commanded */
    bool averaged, off;
    leg_t legs[LEGS];
};

binding_plant_t *binding_plant_create(uint64_t seed, uint32_t ticks, uint32_t dead, bool averaged)
{
    binding_plant_t *plant = calloc(1, sizeof *plant);
    if (plant != NULL) {
        plant->params = plant_params_default();
        plant->ticks = ticks;
        plant->dead = dead;
        plant->averaged = averaged;
        plant->off = true;
        plant_init(&plant->plant, &plant->params, seed);
    }
    return plant;
}

void binding_plant_free(binding_plant_t *plant)
{
    free(plant);
}

/* ---- parameters ---- */

/* The field of a row of the table `plant`. */
static double *field_of(plant_params_t *params, uint32_t id)
{
    const table_row_t *row = rig_row(id);
#define FIELD(field, unit, initial, min, max, text)                                                          \
    if (row != NULL && strcmp(row->name, #field) == 0) {                                                     \
        return &params->field;                                                                               \
    }
    PLANT_PARAMS(FIELD)
#undef FIELD
    return NULL;
}

bool binding_plant_set(binding_plant_t *plant, const uint32_t *ids, const double *values, uint32_t count,
                       char why[WHY_SIZE])
{
    plant_params_t params = plant->params;
    plant_params_error_t error;
    for (uint32_t n = 0; n < count; n++) {
        double *field = field_of(&params, ids[n]);
        if (field == NULL) {
            snprintf(why, WHY_SIZE, "row %lu is not of the plant", (unsigned long)ids[n]);
            return false;
        }
        *field = values[n];
    }
    if (!plant_params_check(&params, &error)) {
        snprintf(why, WHY_SIZE, "%s = %.9g: %s; accepted: %.9g to %.9g", error.field, error.value, error.rule,
                 error.minimum, error.maximum);
        return false;
    }
    plant->params = params;
    plant_set_params(&plant->plant, &params);
    return true;
}

bool binding_plant_get(const binding_plant_t *plant, uint32_t id, double *value)
{
    plant_params_t params = plant->params;
    const double *field = field_of(&params, id);
    *value = field != NULL ? *field : (double)NAN;
    return field != NULL;
}

void binding_plant_set_motion(binding_plant_t *plant, double theta_m, double omega_m)
{
    plant_set_motion(&plant->plant, theta_m, omega_m);
}

/* ---- the carrier ---- */

static uint32_t gates_of(const binding_plant_t *plant)
{
    uint32_t on = 0;
    for (uint32_t n = 0; n < LEGS; n++) {
        if (plant->legs[n].on_at == PLANT_NEVER) {
            on |= plant->legs[n].upper ? PLANT_UPPER(n) : PLANT_LOWER(n);
        }
    }
    return on;
}

/* The switching of the leg at this tick, with the edges of its duty at `rise` and `fall`. true: its gates
 * change. */
static bool turn_leg(leg_t *leg, uint64_t tick, uint64_t rise, uint64_t fall, uint32_t dead)
{
    const bool upper = tick >= rise && tick < fall;
    if (upper != leg->upper) {
        leg->upper = upper;
        leg->on_at = dead > 0u ? tick + dead : PLANT_NEVER;
        return true;
    }
    if (tick >= leg->on_at) {
        leg->on_at = PLANT_NEVER;
        return true;
    }
    return false;
}

static uint64_t sooner(uint64_t now, uint64_t next, uint64_t candidate)
{
    return candidate > now && candidate < next ? candidate : next;
}

/* Every edge of the period: the upper command of a leg is on for `high` about the middle. */
static void switch_period(binding_plant_t *plant, const uint32_t high[LEGS])
{
    const uint64_t end = plant->tick + plant->ticks;
    uint64_t rise[LEGS];
    uint64_t fall[LEGS];
    for (uint32_t n = 0; n < LEGS; n++) {
        rise[n] = plant->tick + (plant->ticks - high[n]) / 2u;
        fall[n] = rise[n] + high[n];
    }
    for (uint64_t tick = plant->tick; tick < end;) {
        bool changed = tick == plant->tick && plant->off;
        uint64_t next = end;
        for (uint32_t n = 0; n < LEGS; n++) {
            changed = turn_leg(&plant->legs[n], tick, rise[n], fall[n], plant->dead) || changed;
            next = sooner(tick, next, rise[n]);
            next = sooner(tick, next, fall[n]);
            next = sooner(tick, next, plant->legs[n].on_at);
        }
        if (changed) { /* without dead band one switch is switched off before the other is switched on */
            const uint32_t gates = gates_of(plant);
            plant_gates(&plant->plant, tick, gates & plant->gates);
            plant_gates(&plant->plant, tick, gates);
            plant->gates = gates;
        }
        tick = next;
    }
}

static uint32_t high_of(double duty, uint32_t ticks)
{
    return !(duty > 0.0) ? 0u : duty >= 1.0 ? ticks : (uint32_t)(duty * ticks + 0.5);
}

void binding_plant_step(binding_plant_t *plant, const double duties[3])
{
    uint32_t high[LEGS] = {0};
    for (uint32_t n = 0; duties != NULL && n < LEGS; n++) {
        high[n] = high_of(duties[n], plant->ticks);
    }
    if (duties == NULL) {
        plant_gates(&plant->plant, plant->tick, 0u);
        plant->gates = 0u;
    } else if (plant->averaged) {
        plant_carrier(&plant->plant, plant->tick, plant->ticks, high, plant->dead, false);
    } else {
        for (uint32_t n = 0; plant->off && n < LEGS; n++) {
            plant->legs[n] = (leg_t){false, PLANT_NEVER};
        }
        switch_period(plant, high);
    }
    plant->off = duties == NULL;
    plant->tick += plant->ticks;
    plant_advance(&plant->plant, plant->tick);
}

void binding_plant_now(binding_plant_t *plant, binding_plant_now_t *now)
{
    const plant_params_t *params = &plant->params;
    double currents[LEGS];
    for (uint32_t n = 0; n < LEGS; n++) {
        const plant_channel_t channel = (plant_channel_t)(PLANT_CURRENT_A + n);
        currents[n] =
            (plant_analog(&plant->plant, channel) - params->current_zero) * params->current_range / VOLT_HALF;
    }
    plant_truth(&plant->plant, &now->truth);
    now->i_a = currents[0];
    now->i_b = currents[1];
    now->i_c = currents[2];
    now->u_dc = plant_analog(&plant->plant, PLANT_DC_LINK) * params->dc_range / VOLT_FULL;
    now->encoder = plant_encoder(&plant->plant);
    now->seconds = (double)plant->tick / (double)PLANT_TICKS_PER_SECOND;
}
