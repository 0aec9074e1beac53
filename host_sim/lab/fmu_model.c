#include "host_sim/lab/fmu_model.h"

#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/xml.h"
#include "host_sim/rig/rig.h"

static const char *const part_names[FMU_PARTS] = {
    [RIG_RING] = "ring", [RIG_DRIVE] = "drive", [RIG_PLANT] = "plant"};

const char *fmu_part_name(rig_part_t part)
{
    return part_names[part];
}

bool fmu_part_of(const char *name, rig_part_t *part)
{
    for (uint32_t n = 0; n < FMU_PARTS; n++) {
        if (strcmp(name, part_names[n]) == 0) {
            *part = (rig_part_t)n;
            return true;
        }
    }
    return false;
}

/* ---- the variables ---- */

#define RING  (1u << RIG_RING)
#define DRIVE (1u << RIG_DRIVE)
#define PLANT (1u << RIG_PLANT)

/* Tables, and rows of a table with rows of both parts, that belong to a part; the first entry that fits.
 * Services are the values of the drive's link and store, for a client on the serial link. */
static const struct {
    const char *table;
    const char *row; /* NULL: every other one */
    uint32_t parts;
} owners[] = {
    {"services", NULL, 0u},
    {"params", NULL, RING | DRIVE},
    {"requests", NULL, RING | DRIVE},
    {"signals", NULL, RING | DRIVE},
    {"truth", "theta_err", RING}, /* both parts know one of the two angles */
    {"truth", "theta_hat_err", RING},
    {"truth", "chip_reports", RING}, /* each part has a chip of its own */
    {"truth", NULL, RING | PLANT},
    {"plant", NULL, RING | PLANT},
    {"rig", "interrupt_delay", RING | DRIVE | PLANT},
    {"rig", "missing_samples", RING | DRIVE | PLANT},
    {"rig", "sensors", RING | DRIVE | PLANT},
    {"rig", "interrupt_time", RING | DRIVE},
    {"rig", "section_time", RING | DRIVE},
    {"rig", "background_time", RING | DRIVE},
    {"rig", "medium_time", RING | DRIVE},
    {"rig", "estimate_jump", RING | DRIVE},
    {"rig", "flip_bit", RING | DRIVE},
    {"rig", "flip_word", RING | DRIVE},
    {"rig", "flip_memory", RING | DRIVE},
    {"rig", NULL, RING | PLANT},
    {"exchange", NULL, DRIVE | PLANT},
};

static bool has_row(rig_part_t part, const table_t *table, const table_row_t *row)
{
    for (size_t n = 0; n < sizeof owners / sizeof owners[0]; n++) {
        if (strcmp(owners[n].table, table->name) == 0 &&
            (owners[n].row == NULL || strcmp(owners[n].row, row->name) == 0)) {
            return (owners[n].parts >> part & 1u) != 0u;
        }
    }
    return false;
}

/* The tables of the rig, then the exchange. */
static const table_t *table_at(uint32_t n)
{
    return n == rig_table_count() ? rig_exchange_table() : rig_table(n);
}

bool fmu_is_exchange(const table_row_t *row)
{
    return table_by_id(rig_exchange_table(), row->id) == row;
}

const table_row_t *fmu_row(rig_part_t part, uint32_t reference)
{
    for (uint32_t n = 0; table_at(n) != NULL; n++) {
        const table_row_t *row = table_by_id(table_at(n), reference);
        if (row != NULL) {
            return has_row(part, table_at(n), row) ? row : NULL;
        }
    }
    return NULL;
}

uint32_t fmu_variables(rig_part_t part, const table_row_t *rows[FMU_VARIABLES_MAX])
{
    uint32_t count = 0;
    for (uint32_t t = 0; table_at(t) != NULL; t++) {
        const table_t *table = table_at(t);
        for (uint32_t n = 0; n < table->count && count < FMU_VARIABLES_MAX; n++) {
            if (has_row(part, table, &table->rows[n])) {
                rows[count++] = &table->rows[n];
            }
        }
    }
    return count;
}

bool fmu_is_output(rig_part_t part, const table_row_t *row)
{
    return fmu_is_exchange(row) ? rig_exchange_is_command(row) == (part == RIG_DRIVE)
                                : row->access == TABLE_READ;
}

bool fmu_is_real(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT || row->kind == SLOT_UINT;
}

/* The row "command_NAME" of a parameter NAME begins with its value. */
double fmu_initial(const scenario_t *scenario, const table_row_t *row)
{
    const char command[] = "command_";
    const bool is_command = fmu_is_exchange(row) && strncmp(row->name, command, sizeof command - 1u) == 0;
    const table_row_t *param =
        is_command ? table_by_name(rig_table(0), row->name + sizeof command - 1u) : NULL;
    return param != NULL          ? scenario_initial(scenario, param)
           : fmu_is_exchange(row) ? rig_initial(row)
                                  : scenario_initial(scenario, row);
}

const char *fmu_guid(rig_part_t part, char to[FMU_GUID_SIZE])
{
    const uint32_t hash = table_hash(rig_exchange_table(), rig_tables_hash());
    snprintf(to, FMU_GUID_SIZE, "{lagless-" LAGLESS_VERSION "-%s-%08lx}", part_names[part],
             (unsigned long)hash);
    return to;
}

/* ---- the description ---- */

static void attribute(FILE *file, const char *name, const char *text)
{
    fprintf(file, " %s=\"", name);
    xml_text(file, text);
    fputc('"', file);
}

static bool has_unit(const table_row_t *row)
{
    return strcmp(row->unit, "-") != 0;
}

/* What is described. */
typedef struct {
    rig_part_t part;
    const scenario_t *scenario;
    uint32_t count;
    const table_row_t *rows[FMU_VARIABLES_MAX];
} model_t;

/* Every unit once, in the order of the variables. */
static void write_units(FILE *file, const model_t *model)
{
    fprintf(file, "<UnitDefinitions>\n<Unit name=\"s\"><BaseUnit s=\"1\"/></Unit>\n");
    for (uint32_t n = 0; n < model->count; n++) {
        const table_row_t *row = model->rows[n];
        bool seen = !fmu_is_real(row) || !has_unit(row) || strcmp(row->unit, "s") == 0;
        for (uint32_t before = 0; before < n && !seen; before++) {
            seen = fmu_is_real(model->rows[before]) && strcmp(model->rows[before]->unit, row->unit) == 0;
        }
        if (!seen) {
            fprintf(file, "<Unit");
            attribute(file, "name", row->unit);
            fprintf(file, "/>\n");
        }
    }
    fprintf(file, "</UnitDefinitions>\n");
}

static void write_choices(FILE *file, const model_t *model)
{
    fprintf(file, "<TypeDefinitions>\n");
    for (uint32_t n = 0; n < model->count; n++) {
        const table_row_t *row = model->rows[n];
        if (row->kind != SLOT_ENUM) {
            continue;
        }
        fprintf(file, "<SimpleType name=\"choices_%lu\"><Enumeration>\n", (unsigned long)row->id);
        const char *choice = row->choices;
        for (uint32_t value = 0; *choice != '\0'; value++) {
            const size_t length = strcspn(choice, "|");
            fprintf(file, "<Item name=\"%.*s\" value=\"%lu\"/>\n", (int)length, choice, (unsigned long)value);
            choice += length + (choice[length] == '|' ? 1u : 0u);
        }
        fprintf(file, "</Enumeration></SimpleType>\n");
    }
    fprintf(file, "</TypeDefinitions>\n");
}

static void write_number(FILE *file, const char *name, double value)
{
    fprintf(file, " %s=\"%.17g\"", name, value);
}

/* The kind with its unit; if the row can be set, also its range and its value at t = 0. */
static void write_kind(FILE *file, const table_row_t *row, const model_t *model)
{
    const bool real = fmu_is_real(row);
    fprintf(file, real ? "<Real" : row->kind == SLOT_ENUM ? "<Enumeration" : "<Integer");
    if (row->kind == SLOT_ENUM) {
        fprintf(file, " declaredType=\"choices_%lu\"", (unsigned long)row->id);
    }
    if (real && has_unit(row)) {
        attribute(file, "unit", row->unit);
    }
    if (!fmu_is_output(model->part, row)) {
        write_number(file, "min", rig_min(row));
        write_number(file, "max", rig_max(row));
        write_number(file, "start", fmu_initial(model->scenario, row));
    }
    fprintf(file, "/>");
}

static void write_variable(FILE *file, const table_row_t *row, const model_t *model)
{
    char name[128];
    if (fmu_is_exchange(row)) {
        snprintf(name, sizeof name, "%s", row->name);
    } else {
        scenario_row_name(row, name, sizeof name);
    }
    const bool param = scenario_is_param(row);
    fprintf(file, "<ScalarVariable");
    attribute(file, "name", name);
    fprintf(file, " valueReference=\"%lu\"", (unsigned long)row->id);
    attribute(file, "description", row->text);
    fprintf(file, " causality=\"%s\"",
            fmu_is_output(model->part, row) ? "output"
            : param                         ? "parameter"
                                            : "input");
    fprintf(file, " variability=\"%s\">",
            param                     ? "tunable"
            : row->kind == SLOT_FLOAT ? "continuous"
                                      : "discrete");
    write_kind(file, row, model);
    fprintf(file, "</ScalarVariable>\n");
}

/* The places of the outputs among the variables, time being the first. */
static void write_outputs(FILE *file, const model_t *model, const char *name)
{
    fprintf(file, "<%s>\n", name);
    for (uint32_t n = 0; n < model->count; n++) {
        if (fmu_is_output(model->part, model->rows[n])) {
            fprintf(file, "<Unknown index=\"%lu\"/>\n", (unsigned long)n + 2u);
        }
    }
    fprintf(file, "</%s>\n", name);
}

static void write_head(FILE *file, const model_t *model, const char *commit)
{
    char guid[FMU_GUID_SIZE];
    fprintf(file, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\"");
    attribute(file, "modelName", FMU_IDENTIFIER);
    attribute(file, "guid", fmu_guid(model->part, guid));
    attribute(file, "description", model->scenario->title);
    attribute(file, "version", commit);
    attribute(file, "generationTool", "lagless " LAGLESS_VERSION);
    fprintf(file, " variableNamingConvention=\"flat\" numberOfEventIndicators=\"0\">\n");
    fprintf(file, "<CoSimulation modelIdentifier=\"" FMU_IDENTIFIER
                  "\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\" "
                  "canSerializeFMUstate=\"true\" canNotUseMemoryManagementFunctions=\"true\"/>\n");
}

uint32_t fmu_describe(FILE *file, rig_part_t part, const scenario_t *scenario, const char *commit)
{
    model_t model = {.part = part, .scenario = scenario};
    model.count = fmu_variables(part, model.rows);
    write_head(file, &model, commit);
    write_units(file, &model);
    write_choices(file, &model);
    fprintf(file, "<DefaultExperiment startTime=\"0\" stopTime=\"%.17g\" stepSize=\"%.17g\"/>\n",
            scenario->duration, RIG_PERIOD_SECONDS);
    fprintf(file,
            "<ModelVariables>\n<ScalarVariable name=\"time\" valueReference=\"%u\" "
            "causality=\"independent\" variability=\"continuous\"><Real unit=\"s\"/></ScalarVariable>\n",
            FMU_TIME);
    for (uint32_t n = 0; n < model.count; n++) {
        write_variable(file, model.rows[n], &model);
    }
    fprintf(file, "</ModelVariables>\n<ModelStructure>\n");
    write_outputs(file, &model, "Outputs");
    write_outputs(file, &model, "InitialUnknowns");
    fprintf(file, "</ModelStructure>\n</fmiModelDescription>\n");
    return model.count + 1u;
}
