#include "host_sim/lab/fmu_model.h"

#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/xml.h"
#include "host_sim/rig/rig.h"

/* Services are the values of the drive's link and store, for a client on the serial link. */
static bool is_in_model(const table_t *table)
{
    return strcmp(table->name, "services") != 0;
}

const table_row_t *fmu_row(uint32_t reference)
{
    const table_row_t *row = rig_row(reference);
    return row != NULL && is_in_model(scenario_table_of(row)) ? row : NULL;
}

const table_row_t *fmu_variable(uint32_t n)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        if (!is_in_model(table)) {
            continue;
        }
        if (n < table->count) {
            return &table->rows[n];
        }
        n -= table->count;
    }
    return NULL;
}

bool fmu_is_output(const table_row_t *row)
{
    return row->access == TABLE_READ;
}

bool fmu_is_real(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT || row->kind == SLOT_UINT;
}

const char *fmu_guid(char to[FMU_GUID_SIZE])
{
    snprintf(to, FMU_GUID_SIZE, "{lagless-" LAGLESS_VERSION "-%08lx}", (unsigned long)rig_tables_hash());
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

/* Every unit once, in the order of the variables. */
static void write_units(FILE *file)
{
    fprintf(file, "<UnitDefinitions>\n<Unit name=\"s\"><BaseUnit s=\"1\"/></Unit>\n");
    for (uint32_t n = 0; fmu_variable(n) != NULL; n++) {
        const table_row_t *row = fmu_variable(n);
        bool seen = !fmu_is_real(row) || !has_unit(row) || strcmp(row->unit, "s") == 0;
        for (uint32_t before = 0; before < n && !seen; before++) {
            seen = fmu_is_real(fmu_variable(before)) && strcmp(fmu_variable(before)->unit, row->unit) == 0;
        }
        if (!seen) {
            fprintf(file, "<Unit");
            attribute(file, "name", row->unit);
            fprintf(file, "/>\n");
        }
    }
    fprintf(file, "</UnitDefinitions>\n");
}

static void write_choices(FILE *file)
{
    fprintf(file, "<TypeDefinitions>\n");
    for (uint32_t n = 0; fmu_variable(n) != NULL; n++) {
        const table_row_t *row = fmu_variable(n);
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
static void write_kind(FILE *file, const table_row_t *row, const scenario_t *scenario)
{
    const bool real = fmu_is_real(row);
    fprintf(file, real ? "<Real" : row->kind == SLOT_ENUM ? "<Enumeration" : "<Integer");
    if (row->kind == SLOT_ENUM) {
        fprintf(file, " declaredType=\"choices_%lu\"", (unsigned long)row->id);
    }
    if (real && has_unit(row)) {
        attribute(file, "unit", row->unit);
    }
    if (!fmu_is_output(row)) {
        write_number(file, "min", rig_min(row));
        write_number(file, "max", rig_max(row));
        write_number(file, "start", scenario_initial(scenario, row));
    }
    fprintf(file, "/>");
}

static void write_variable(FILE *file, const table_row_t *row, const scenario_t *scenario)
{
    char name[128];
    scenario_row_name(row, name, sizeof name);
    const bool param = scenario_is_param(row);
    fprintf(file, "<ScalarVariable");
    attribute(file, "name", name);
    fprintf(file, " valueReference=\"%lu\"", (unsigned long)row->id);
    attribute(file, "description", row->text);
    fprintf(file, " causality=\"%s\"", fmu_is_output(row) ? "output" : param ? "parameter" : "input");
    fprintf(file, " variability=\"%s\">",
            param                     ? "tunable"
            : row->kind == SLOT_FLOAT ? "continuous"
                                      : "discrete");
    write_kind(file, row, scenario);
    fprintf(file, "</ScalarVariable>\n");
}

/* The places of the outputs among the variables, time being the first. */
static void write_outputs(FILE *file, const char *name)
{
    fprintf(file, "<%s>\n", name);
    for (uint32_t n = 0; fmu_variable(n) != NULL; n++) {
        if (fmu_is_output(fmu_variable(n))) {
            fprintf(file, "<Unknown index=\"%lu\"/>\n", (unsigned long)n + 2u);
        }
    }
    fprintf(file, "</%s>\n", name);
}

uint32_t fmu_describe(FILE *file, const scenario_t *scenario, const char *commit)
{
    char guid[FMU_GUID_SIZE];
    uint32_t n = 0;
    fprintf(file, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\"");
    attribute(file, "modelName", FMU_IDENTIFIER);
    attribute(file, "guid", fmu_guid(guid));
    attribute(file, "description", scenario->title);
    attribute(file, "version", commit);
    attribute(file, "generationTool", "lagless " LAGLESS_VERSION);
    fprintf(file, " variableNamingConvention=\"flat\" numberOfEventIndicators=\"0\">\n");
    fprintf(file, "<CoSimulation modelIdentifier=\"" FMU_IDENTIFIER
                  "\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\" "
                  "canSerializeFMUstate=\"true\" canNotUseMemoryManagementFunctions=\"true\"/>\n");
    write_units(file);
    write_choices(file);
    fprintf(file, "<DefaultExperiment startTime=\"0\" stopTime=\"%.17g\" stepSize=\"%.17g\"/>\n",
            scenario->duration, RIG_PERIOD_SECONDS);
    fprintf(file,
            "<ModelVariables>\n<ScalarVariable name=\"time\" valueReference=\"%u\" "
            "causality=\"independent\" variability=\"continuous\"><Real unit=\"s\"/></ScalarVariable>\n",
            FMU_TIME);
    for (; fmu_variable(n) != NULL; n++) {
        write_variable(file, fmu_variable(n), scenario);
    }
    fprintf(file, "</ModelVariables>\n<ModelStructure>\n");
    write_outputs(file, "Outputs");
    write_outputs(file, "InitialUnknowns");
    fprintf(file, "</ModelStructure>\n</fmiModelDescription>\n");
    return n + 1u;
}
