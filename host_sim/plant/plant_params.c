#include "host_sim/plant/plant_params.h"

#include <math.h>
#include <stddef.h>

typedef struct {
    const char *name;
    size_t offset;
    double standard, minimum, maximum;
} row_t;

static const row_t rows[] = {
#define ROW(name, unit, standard, minimum, maximum, text)                                                    \
    {#name, offsetof(plant_params_t, name), standard, minimum, maximum},
    PLANT_PARAMS(ROW)
#undef ROW
};

plant_params_t plant_params_default(void)
{
    plant_params_t params = {
#define STANDARD(name, unit, standard, minimum, maximum, text) standard,
        PLANT_PARAMS(STANDARD)
#undef STANDARD
    };
    return params;
}

static bool counts_something(const plant_params_t *params, const double *value)
{
    return value == &params->pole_pairs || value == &params->load_kind || value == &params->shaft_locked ||
           value == &params->encoder_lines || value == &params->open_phase_a ||
           value == &params->open_phase_b || value == &params->open_phase_c || value == &params->force_fault;
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
        if (value == &params->load_torque && params->load_kind == PLANT_LOAD_PASSIVE && *value < 0.0) {
            return refuse(why, row, *value, 0.0, "a passive load can not drive");
        }
        if (value == &params->friction_breakaway && *value != 0.0 && *value < params->friction_coulomb) {
            return refuse(why, row, *value, params->friction_coulomb,
                          "or 0: friction_breakaway is no less than friction_coulomb");
        }
    }
    return true;
}
