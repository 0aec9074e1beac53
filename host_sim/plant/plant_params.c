#include "host_sim/plant/plant_params.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/plant/flux_map.h"

#define MAP_FLUX 0.01 /* [-] by which flux_linkage may differ from that of a map */

typedef struct {
    const char *name;
    size_t offset;
    double standard, minimum, maximum;
} row_t;

static const row_t rows[] = {
#define ROW(name, unit, standard, minimum, maximum, text)                                                    \
    {#name, offsetof(plant_params_t, name), (double)(standard), (double)(minimum), (double)(maximum)},
    PLANT_PARAMS(ROW)
#undef ROW
};

plant_params_t plant_params_default(void)
{
    plant_params_t params = {
#define STANDARD(name, unit, standard, minimum, maximum, text) (double)(standard),
        PLANT_PARAMS(STANDARD)
#undef STANDARD
    };
    return params;
}

static bool counts_something(const plant_params_t *params, const double *value)
{
    const double *const whole[] = {
        &params->pole_pairs,       &params->load_kind,        &params->shaft_locked,
        &params->encoder_lines,    &params->open_phase_a,     &params->open_phase_b,
        &params->open_phase_c,     &params->force_fault,      &params->open_switches,
        &params->shorted_switches, &params->swap_phases,      &params->swap_currents,
        &params->encoder_reversed, &params->encoder_stuck_a,  &params->encoder_stuck_b,
        &params->supply_lost,      &params->load_sine_cycles, &params->flux_map,
        &params->dc_returns,
    };
    for (size_t n = 0; n < sizeof whole / sizeof whole[0]; n++) {
        if (value == whole[n]) {
            return true;
        }
    }
    return false;
}

static bool refuse(plant_params_error_t *why, const row_t *row, double value, double minimum,
                   const char *rule)
{
    if (why != NULL) {
        why->field = row->name;
        why->rule = rule;
        why->value = value;
        why->minimum = minimum;
        why->maximum = row->maximum;
    }
    return false;
}

/* True if a shaft between two masses swings or settles too fast for the steps. */
static bool shaft_resolved(const plant_params_t *params, plant_params_error_t *why)
{
    if (params->load_inertia == 0.0 || params->shaft_stiffness == 0.0) {
        return true;
    }
    const double reduced = 1.0 / (1.0 / params->inertia + 1.0 / params->load_inertia);
    const double stiffest = PLANT_SHAFT_FASTEST * PLANT_SHAFT_FASTEST * reduced;
    const double most_damped = PLANT_SHAFT_FASTEST * reduced;
    const bool stiff = params->shaft_stiffness > stiffest;
    if (!stiff && params->shaft_damping <= most_damped) {
        return true;
    }
    if (why != NULL) {
        *why = (plant_params_error_t){
            .field = stiff ? "shaft_stiffness" : "shaft_damping",
            .rule = "between inertia and load_inertia it moves faster than 1e5 rad/s; 0 stiffness: rigid",
            .value = stiff ? params->shaft_stiffness : params->shaft_damping,
            .maximum = stiff ? stiffest : most_damped,
        };
    }
    return false;
}

/* True if the map exists, and its flux without current agrees with flux_linkage within a hundredth. */
static bool map_fits(const plant_params_t *params, plant_params_error_t *why)
{
    const flux_map_t *map = flux_map_of((uint32_t)params->flux_map);
    if (params->flux_map == 0.0) {
        return true;
    }
    const double flux = map != NULL ? flux_map_at(map, 0.0, 0.0).flux_d : 0.0;
    if (map != NULL && fabs(params->flux_linkage - flux) <= MAP_FLUX * fabs(flux)) {
        return true;
    }
    if (why != NULL && map == NULL) {
        *why = (plant_params_error_t){
            .field = "flux_map", .rule = "no map of this number has been read", .value = params->flux_map};
    } else if (why != NULL) {
        *why = (plant_params_error_t){
            .field = "flux_linkage",
            .rule = "with flux_map: psi_d of the map without current, within 1 %",
            .value = params->flux_linkage,
            .minimum = (1.0 - MAP_FLUX) * flux,
            .maximum = (1.0 + MAP_FLUX) * flux,
        };
    }
    return false;
}

bool plant_params_check(const plant_params_t *params, plant_params_error_t *why)
{
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const row_t *row = &rows[n];
        const double *value = (const double *)(const void *)((const char *)params + row->offset);
        if (!(*value >= row->minimum && *value <= row->maximum)) {
            return refuse(why, row, *value, row->minimum, "outside its range");
        }
        if (counts_something(params, value) && *value != floor(*value)) {
            return refuse(why, row, *value, row->minimum, "must be a whole number");
        }
        if (value == &params->current_range && !(fabs(*value) >= 0.1)) {
            return refuse(why, row, *value, 0.1, "a scale, of 0.1 A at least, either sign");
        }
        if ((value == &params->saturation_d || value == &params->saturation_q) && *value != 0.0 &&
            *value < PLANT_SATURATION_LEAST) {
            return refuse(why, row, *value, PLANT_SATURATION_LEAST,
                          "a current of 1 A at least; 0: no saturation");
        }
        if (value == &params->iron_loss_resistance && *value != 0.0 && *value < PLANT_IRON_LEAST) {
            return refuse(why, row, *value, PLANT_IRON_LEAST,
                          "accepted: 10 ohm and more, or 0: no loss in the iron");
        }
        if (value == &params->load_torque && params->load_kind == PLANT_LOAD_PASSIVE && *value < 0.0) {
            return refuse(why, row, *value, 0.0, "a passive load can not drive");
        }
        if (value == &params->friction_breakaway && *value != 0.0 && *value < params->friction_coulomb) {
            return refuse(why, row, *value, params->friction_coulomb,
                          "or 0: friction_breakaway must not be below friction_coulomb");
        }
        if (value == &params->shorted_switches &&
            ((uint32_t)*value & (uint32_t)params->open_switches) != 0u) {
            return refuse(why, row, *value, 0.0, "a switch of open_switches can not be shorted as well");
        }
        if (value == &params->supply_lost && *value != 0.0 && params->dc_capacitance == 0.0) {
            return refuse(why, row, *value, 0.0, "a link without a supply needs dc_capacitance above 0");
        }
    }
    return map_fits(params, why) && shaft_resolved(params, why);
}
