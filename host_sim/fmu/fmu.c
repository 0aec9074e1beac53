/* The simulation, or one of its parts, as an FMI 2.0 co-simulation: the functions of the standard, with a rig
 * and its course.
 *
 * An instance runs the scenario in its resources, whose events act at their times. A step runs the periods
 * that end before its end or with it, so that steps may have any length. Outputs are the slots of the last
 * period as a recording has them. An input acts when its value differs from the last one that was set (at
 * first from the start value): a master that repeats an unchanged value does not take back what an event has
 * set. The parameters of the drive that one call sets are applied as a set.
 *
 * A part runs at most one period in a step, because the parts exchange values in each period. The plant runs
 * ahead of the step, to the sample of the next period.
 *
 * Other files contain states (fmu_state.c) and the functions that the unit does not support (fmu_none.c). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/fmu/fmu_parts.h"
#include "host_sim/lab/tally.h"

#define ENDS_WITHIN 1e-6 /* [periods] of the end of a step: rounding of times in the master */
#define PATH_OCTETS 4096u

/* ---- messages ---- */

fmi2Status fmu_say(const instance_t *instance, fmi2Status status, const char *text)
{
    if (instance->logger != NULL) {
        instance->logger(instance->environment, instance->name, status,
                         status >= fmi2Error ? "logStatusError" : "logStatusDiscard", "%s", text);
    }
    return status;
}

static fmi2Status say_about(const instance_t *instance, fmi2Status status, const scenario_error_t *error)
{
    char text[1200];
    return fmu_say(instance, status, scenario_error_text(error, text, sizeof text));
}

/* ---- the simulation of an instance ---- */

static void on_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    instance_t *instance = context;
    (void)period;
    memcpy(instance->kept.slots, slots, count * sizeof *slots);
}

/* Rig and course at t = 0. */
static bool power_on(instance_t *instance)
{
    scenario_error_t error;
    instance->rig = rig_create(instance->seed);
    if (instance->rig == NULL || !course_init(&instance->course, instance->scenario, instance->rig)) {
        fmu_say(instance, fmi2Fatal, "no memory for the simulation");
        return false;
    }
    if (!course_start(&instance->course, &error)) {
        say_about(instance, fmi2Error, &error);
        return false;
    }
    rig_part_cut(instance->rig, instance->part);
    instance->kept = (kept_t){.now = 0.0};
    const table_row_t *rows[FMU_VARIABLES_MAX];
    const uint32_t count = fmu_variables(instance->part, rows);
    for (uint32_t n = 0; n < count; n++) {
        if (!fmu_is_output(instance->part, rows[n])) {
            instance->kept.set[rows[n]->id] = fmu_initial(instance->scenario, rows[n]);
        }
    }
    instance->initialized = false;
    return rig_tap(instance->rig, instance->outputs, instance->output_count, 1u, on_sample, instance);
}

static void power_off(instance_t *instance)
{
    course_free(&instance->course);
    rig_free(instance->rig);
    instance->rig = NULL;
}

static void release(instance_t *instance)
{
    if (instance != NULL) {
        power_off(instance);
        if (instance->scenario != NULL) {
            scenario_free(instance->scenario);
        }
        free(instance->name);
        free(instance);
    }
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* file:///a%20b or file:/a%20b, then the name of the scenario. false: another place, or too long. */
static bool scenario_path(char path[PATH_OCTETS], const char *location)
{
    size_t length = 0;
    if (location == NULL || strncmp(location, "file:/", 6) != 0) {
        return false;
    }
    const char *c = location + 5;
    if (strncmp(c, "//", 2) == 0) {
        c += 2 + strcspn(c + 2, "/"); /* the host is this one */
    }
    for (; *c != '\0' && length + 20u < PATH_OCTETS; c++) {
        const bool coded = *c == '%' && hex_digit(c[1]) >= 0 && hex_digit(c[2]) >= 0;
        path[length++] = coded ? (char)(16 * hex_digit(c[1]) + hex_digit(c[2])) : *c;
        c += coded ? 2 : 0;
    }
    memcpy(path + length, "/scenario.toml", sizeof "/scenario.toml");
    return *c == '\0';
}

static bool read_scenario(instance_t *instance, const char *location)
{
    char path[PATH_OCTETS];
    scenario_error_t error;
    if (!scenario_path(path, location)) {
        fmu_say(instance, fmi2Error, "the location of the resources is no file:///FOLDER");
        return false;
    }
    instance->scenario = scenario_read(path, &error);
    if (instance->scenario == NULL) {
        say_about(instance, fmi2Error, &error);
        return false;
    }
    instance->seed = instance->scenario->seed;
    return true;
}

static void list_outputs(instance_t *instance)
{
    const table_row_t *rows[FMU_VARIABLES_MAX];
    const uint32_t count = fmu_variables(instance->part, rows);
    for (uint32_t n = 0; n < count; n++) {
        const bool taps = fmu_is_output(instance->part, rows[n]) && !fmu_is_exchange(rows[n]);
        if (taps && instance->output_count < RIG_TAP_MAX) {
            instance->place[rows[n]->id] = (uint16_t)instance->output_count;
            instance->outputs[instance->output_count++] = rows[n]->id;
        }
    }
}

/* The part of this GUID. false: it is that of another version. */
static bool find_part(const char *guid, rig_part_t *part)
{
    char own[FMU_GUID_SIZE];
    for (uint32_t n = 0; n < FMU_PARTS && guid != NULL; n++) {
        *part = (rig_part_t)n;
        if (strcmp(guid, fmu_guid(*part, own)) == 0) {
            return true;
        }
    }
    return false;
}

/* ---- creation and states of an instance ---- */

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count,
                               const fmi2String names[])
{
    (void)component;
    (void)on;
    (void)count;
    (void)names;
    return fmi2OK; /* every message is of an error */
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logs)
{
    instance_t *instance = calloc(1, sizeof *instance);
    (void)visible;
    (void)logs;
    if (instance == NULL) {
        return NULL;
    }
    instance->logger = functions != NULL ? functions->logger : NULL;
    instance->environment = functions != NULL ? functions->componentEnvironment : NULL;
    instance->name = strdup(name != NULL ? name : "");
    const bool known = find_part(guid, &instance->part);
    list_outputs(instance);
    if (type != fmi2CoSimulation) {
        fmu_say(instance, fmi2Error, "only co-simulation is supported");
    } else if (!known) {
        fmu_say(instance, fmi2Error,
                "the GUID is that of another version: model description and library do not belong together");
    } else if (read_scenario(instance, location) && power_on(instance)) {
        return instance;
    }
    release(instance);
    return NULL;
}

void fmi2FreeInstance(fmi2Component component)
{
    release(component);
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean has_stop, fmi2Real stop)
{
    instance_t *instance = component;
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    instance->kept.start = start;
    instance->kept.now = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    (void)component;
    return fmi2OK;
}

/* The plant goes to the sample of the period that begins, with the events at its begin. */
static fmi2Status look_ahead(instance_t *instance)
{
    scenario_error_t error;
    if (instance->part == RIG_PLANT) {
        if (!course_change(&instance->course, instance->kept.periods, &error)) {
            return say_about(instance, fmi2Error, &error);
        }
        rig_part_sample(instance->rig);
    }
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    instance_t *instance = component;
    instance->initialized = true;
    return look_ahead(instance);
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    (void)component;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component component)
{
    power_off(component);
    return power_on(component) ? fmi2OK : fmi2Fatal;
}

/* ---- values ---- */

fmi2Status fmu_no_variable(const instance_t *instance, fmi2ValueReference reference, const char *kind)
{
    char text[96];
    snprintf(text, sizeof text, "value reference %u: no variable of type %s has this reference", reference,
             kind);
    return fmu_say(instance, fmi2Error, text);
}

/* The row, if its kind agrees with `real`. */
static const table_row_t *row_of(rig_part_t part, fmi2ValueReference reference, bool real)
{
    const table_row_t *row = fmu_row(part, reference);
    return row != NULL && fmu_is_real(row) == real ? row : NULL;
}

static double value_of(instance_t *instance, const table_row_t *row)
{
    double value = 0.0;
    if (fmu_is_exchange(row)) {
        return rig_exchange_get(instance->rig, row);
    }
    if (fmu_is_output(instance->part, row) && instance->kept.periods > 0u) {
        return tally_number(instance->kept.slots[instance->place[row->id]], row->kind);
    }
    (void)rig_get(instance->rig, row->id, &value);
    return value;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                       fmi2Real values[])
{
    instance_t *instance = component;
    for (size_t n = 0; n < count; n++) {
        const table_row_t *row = row_of(instance->part, references[n], true);
        if (row == NULL && references[n] != FMU_TIME) {
            return fmu_no_variable(instance, references[n], "Real");
        }
        values[n] = row != NULL ? value_of(instance, row) : instance->kept.now;
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference references[], size_t count,
                          fmi2Integer values[])
{
    instance_t *instance = component;
    for (size_t n = 0; n < count; n++) {
        const table_row_t *row = row_of(instance->part, references[n], false);
        if (row == NULL) {
            return fmu_no_variable(instance, references[n], "Integer or Enumeration");
        }
        values[n] = (fmi2Integer)value_of(instance, row);
    }
    return fmi2OK;
}

static fmi2Status say_range(const instance_t *instance, const table_row_t *row, double value)
{
    char text[RIG_NUMBER_SIZE + RIG_RANGE_SIZE + 64u];
    char number[RIG_NUMBER_SIZE];
    char range[RIG_RANGE_SIZE];
    snprintf(text, sizeof text, "%.40s = %s: accepted: %s", row->name, rig_value_text(number, value),
             rig_range_text(range, row, rig_min(row), rig_max(row)));
    return fmu_say(instance, fmi2Discard, text);
}

/* One value; *params: parameters of the drive are staged. */
static fmi2Status set_value(instance_t *instance, const table_row_t *row, double value, bool *params)
{
    if (value == instance->kept.set[row->id]) {
        return fmi2OK;
    }
    if (fmu_is_exchange(row)) {
        if (!rig_accepts(row, value)) {
            return say_range(instance, row, value);
        }
        rig_exchange_set(instance->rig, row, value);
        instance->kept.set[row->id] = value;
        return fmi2OK;
    }
    if (!rig_set(instance->rig, row->id, value)) {
        return fmu_say(instance, fmi2Discard, rig_error(instance->rig));
    }
    instance->kept.set[row->id] = value;
    *params = *params || scenario_is_param(row);
    return fmi2OK;
}

/* Exactly one of the two lists is given. */
static fmi2Status set_values(instance_t *instance, const fmi2ValueReference references[], size_t count,
                             const fmi2Real reals[], const fmi2Integer integers[])
{
    bool params = false;
    fmi2Status status = fmi2OK;
    for (size_t n = 0; n < count; n++) {
        const table_row_t *row = row_of(instance->part, references[n], reals != NULL);
        if (row == NULL || fmu_is_output(instance->part, row)) {
            return fmu_no_variable(instance, references[n], "input or parameter");
        }
        const fmi2Status one =
            set_value(instance, row, reals != NULL ? reals[n] : (double)integers[n], &params);
        status = one > status ? one : status;
    }
    if (params && !rig_apply(instance->rig)) {
        return fmu_say(instance, fmi2Discard, rig_error(instance->rig));
    }
    return status;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                       const fmi2Real values[])
{
    return set_values(component, references, count, values, NULL);
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference references[], size_t count,
                          const fmi2Integer values[])
{
    return set_values(component, references, count, NULL, values);
}

/* ---- a step ---- */

static fmi2Status run_ring(instance_t *instance, uint32_t to)
{
    scenario_error_t error;
    if (course_run(&instance->course, instance->kept.periods, to, &error) == COURSE_NEVER) {
        return say_about(instance, fmi2Error, &error);
    }
    instance->kept.periods = to;
    return fmi2OK;
}

/* One period. The events at its begin have acted on the plant before its sample. */
static fmi2Status run_part(instance_t *instance)
{
    scenario_error_t error;
    if (instance->part == RIG_DRIVE && !course_change(&instance->course, instance->kept.periods, &error)) {
        return say_about(instance, fmi2Error, &error);
    }
    rig_part_step(instance->rig);
    instance->kept.periods++;
    return look_ahead(instance);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real point, fmi2Real size, fmi2Boolean no_set_before)
{
    instance_t *instance = component;
    kept_t *kept = &instance->kept;
    fmi2Status status = fmi2OK;
    (void)no_set_before;
    const double end = point + size;
    const double periods = floor((end - kept->start) / RIG_PERIOD_SECONDS + ENDS_WITHIN);
    if (!instance->initialized || !(size >= 0.0) ||
        fabs(point - kept->now) > ENDS_WITHIN * RIG_PERIOD_SECONDS) {
        return fmu_say(instance, fmi2Error,
                       "a step must follow the initialization, begin at the end of the previous step, and "
                       "have a length >= 0");
    }
    if (!(periods < (double)UINT32_MAX)) {
        return fmu_say(instance, fmi2Error, "the step ends after the largest time of the simulation");
    }
    const uint32_t to = (uint32_t)periods;
    if (instance->part != RIG_RING && to > kept->periods + 1u) {
        return fmu_say(instance, fmi2Error,
                       "more than one period ends within the step: drive and plant exchange values in each "
                       "period; accepted: steps up to the step size of the default experiment");
    }
    if (to > kept->periods) {
        status = instance->part == RIG_RING ? run_ring(instance, to) : run_part(instance);
    }
    kept->now = status == fmi2OK ? end : kept->now;
    return status;
}
