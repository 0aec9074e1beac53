#include "host_sim/rig/rig_tables.h"

static const table_row_t truth_rows[] = {
#define TRUTH_ROW(id, name, unit, text)                                                                      \
    {id,   SLOT_FLOAT, TABLE_READ, offsetof(rig_truth_t, name), #name, unit, text, "", 0.0f,                 \
     0.0f, 0.0f,       {0, 0, 0}},
    RIG_TRUTH(TRUTH_ROW)
#undef TRUTH_ROW
};
const table_t truth_table = {"truth", truth_rows, sizeof truth_rows / sizeof truth_rows[0]};

/* Numbers the rows of PLANT_PARAMS by their order. */
enum {
#define PLANT_NUMBER(name, unit, initial, min, max, text) PLANT_ROW_##name,
    PLANT_PARAMS(PLANT_NUMBER)
#undef PLANT_NUMBER
};

static const table_row_t plant_rows[] = {
#define PLANT_ROW(name, unit, initial, min, max, text)                                                       \
    {4000u + (uint32_t)PLANT_ROW_##name,                                                                     \
     SLOT_FLOAT,                                                                                             \
     TABLE_LIVE,                                                                                             \
     offsetof(rig_plant_t, name),                                                                            \
     #name,                                                                                                  \
     unit,                                                                                                   \
     text,                                                                                                   \
     "",                                                                                                     \
     (float)(initial),                                                                                       \
     (float)(min),                                                                                           \
     (float)(max),                                                                                           \
     {0, 0, 0}},
    PLANT_PARAMS(PLANT_ROW)
#undef PLANT_ROW
};
const table_t plant_table = {"plant", plant_rows, sizeof plant_rows / sizeof plant_rows[0]};

static const table_row_t condition_rows[] = {
#define CONDITION_ROW_FLOAT(id, name, unit, initial, min, max, text)                                         \
    {id,  SLOT_FLOAT, TABLE_LIVE, offsetof(rig_conditions_t, name), #name, unit, text, "", initial,          \
     min, max,        {0, 0, 0}},
#define CONDITION_ROW_ENUM(id, name, choices, text)                                                          \
    {id,   SLOT_ENUM, TABLE_LIVE, offsetof(rig_conditions_t, name), #name, "-", text, choices, 0.0f,         \
     0.0f, 0.0f,      {0, 0, 0}},
    RIG_CONDITIONS(CONDITION_ROW_FLOAT, CONDITION_ROW_ENUM)
#undef CONDITION_ROW_FLOAT
#undef CONDITION_ROW_ENUM
};
const table_t conditions_table = {"rig", condition_rows, sizeof condition_rows / sizeof condition_rows[0]};

/* A 32-bit slot at the end of its range may lie a rounding beyond it. */
static double within(double value, double min, double max)
{
    return value < min ? min : (value > max ? max : value);
}

plant_params_t rig_plant_params(const rig_plant_t *values)
{
    return (plant_params_t){
#define PLANT_VALUE(name, unit, initial, min, max, text) .name = within((double)values->name, min, max),
        PLANT_PARAMS(PLANT_VALUE)
#undef PLANT_VALUE
    };
}
