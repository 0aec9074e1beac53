/* The library of an FMU, loaded as a co-simulation master loads it. It gives the same bits as the
 * simulation without an FMU; states and refusals are tested too. The expected values come from a
 * simulation and a course (host_sim/lab/course.h) in this program. */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2FunctionTypes.h"

#include "host_sim/lab/course.h"
#include "host_sim/lab/fmu_model.h"
#include "host_sim/lab/tally.h"
#include "unity.h"

#define PERIODS 3000u
#define OUTPUTS RIG_TAP_MAX

static const char scenario_text[] =
    "schema = 1\ntitle = \"ring\"\n[run]\nduration = \"0.4 s\"\nseed = 5\n"
    "[params]\nposition_source = \"encoder\"\n[requests]\nenable = \"on\"\nspeed_request = \"20 rad/s\"\n"
    "[[at]]\ntime = \"0.1 s\"\nramp = \"0.1 s\"\nplant.load_torque = \"1 N m\"\n"
    "[[at]]\ntime = \"0.25 s\"\nrequests.speed_request = \"30 rad/s\"\n";

static char folder[64];
static char location[96];
static char said[1024]; /* the last message */
static void *library;

/* The functions of the library. */
static fmi2InstantiateTYPE *instantiate;
static fmi2FreeInstanceTYPE *free_instance;
static fmi2SetupExperimentTYPE *set_up;
static fmi2EnterInitializationModeTYPE *enter;
static fmi2ExitInitializationModeTYPE *leave;
static fmi2DoStepTYPE *do_step;
static fmi2GetRealTYPE *get_real;
static fmi2SetRealTYPE *set_real;
static fmi2GetIntegerTYPE *get_integer;
static fmi2GetFMUstateTYPE *get_state;
static fmi2SetFMUstateTYPE *set_state;
static fmi2FreeFMUstateTYPE *free_state;
static fmi2SerializedFMUstateSizeTYPE *state_size;
static fmi2SerializeFMUstateTYPE *serialize;
static fmi2DeSerializeFMUstateTYPE *deserialize;
static fmi2ResetTYPE *reset;

static void *function(const char *name)
{
    void *found = dlsym(library, name);
    TEST_ASSERT_NOT_NULL_MESSAGE(found, name);
    return found;
}

static void load(void)
{
    library = dlopen(LAGLESS_FMU, RTLD_NOW | RTLD_LOCAL);
    TEST_ASSERT_NOT_NULL_MESSAGE(library, dlerror());
    *(void **)&instantiate = function("fmi2Instantiate");
    *(void **)&free_instance = function("fmi2FreeInstance");
    *(void **)&set_up = function("fmi2SetupExperiment");
    *(void **)&enter = function("fmi2EnterInitializationMode");
    *(void **)&leave = function("fmi2ExitInitializationMode");
    *(void **)&do_step = function("fmi2DoStep");
    *(void **)&get_real = function("fmi2GetReal");
    *(void **)&set_real = function("fmi2SetReal");
    *(void **)&get_integer = function("fmi2GetInteger");
    *(void **)&get_state = function("fmi2GetFMUstate");
    *(void **)&set_state = function("fmi2SetFMUstate");
    *(void **)&free_state = function("fmi2FreeFMUstate");
    *(void **)&state_size = function("fmi2SerializedFMUstateSize");
    *(void **)&serialize = function("fmi2SerializeFMUstate");
    *(void **)&deserialize = function("fmi2DeSerializeFMUstate");
    *(void **)&reset = function("fmi2Reset");
}

void setUp(void)
{
    char path[96];
    strcpy(folder, "/tmp/lagless_fmu_XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/scenario.toml", folder);
    snprintf(location, sizeof location, "file://%s", folder);
    FILE *file = fopen(path, "w");
    fputs(scenario_text, file);
    fclose(file);
    said[0] = '\0';
    if (library == NULL) {
        load();
    }
}

void tearDown(void)
{
    char path[96];
    snprintf(path, sizeof path, "%s/scenario.toml", folder);
    remove(path);
    rmdir(folder);
}

static void listen(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                   fmi2String category, fmi2String message, ...)
{
    va_list arguments;
    (void)environment;
    (void)name;
    (void)status;
    (void)category;
    va_start(arguments, message);
    vsnprintf(said, sizeof said, message, arguments);
    va_end(arguments);
}

static const fmi2CallbackFunctions callbacks = {listen, calloc, free, NULL, NULL};

static fmi2Component opened(void)
{
    char guid[FMU_GUID_SIZE];
    fmi2Component ring = instantiate("ring", fmi2CoSimulation, fmu_guid(RIG_RING, guid), location, &callbacks,
                                     fmi2False, fmi2True);
    TEST_ASSERT_NOT_NULL_MESSAGE(ring, said);
    TEST_ASSERT_EQUAL(fmi2OK, set_up(ring, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    TEST_ASSERT_EQUAL(fmi2OK, enter(ring));
    TEST_ASSERT_EQUAL(fmi2OK, leave(ring));
    return ring;
}

/* Makes one step over this number of periods, beginning at the start of a period. */
static fmi2Status stepped(fmi2Component ring, uint32_t from, uint32_t periods)
{
    return do_step(ring, from * RIG_PERIOD_SECONDS, periods * RIG_PERIOD_SECONDS, fmi2True);
}

static double real_of(fmi2Component ring, const char *name)
{
    const fmi2ValueReference reference = rig_row_by_name(name)->id;
    fmi2Real value;
    TEST_ASSERT_EQUAL_MESSAGE(fmi2OK, get_real(ring, &reference, 1, &value), name);
    return value;
}

static fmi2Status put(fmi2Component ring, const char *name, double value)
{
    const fmi2ValueReference reference = rig_row_by_name(name)->id;
    return set_real(ring, &reference, 1, &value);
}

/* Reads all outputs as numbers; returns how many there are. */
static uint32_t outputs_of(fmi2Component ring, double values[OUTPUTS])
{
    const table_row_t *rows[FMU_VARIABLES_MAX];
    const uint32_t variables = fmu_variables(RIG_RING, rows);
    uint32_t count = 0;
    for (uint32_t n = 0; n < variables; n++) {
        const table_row_t *row = rows[n];
        const fmi2ValueReference reference = row->id;
        fmi2Integer whole = 0;
        if (!fmu_is_output(RIG_RING, row)) {
            continue;
        }
        if (fmu_is_real(row)) {
            TEST_ASSERT_EQUAL(fmi2OK, get_real(ring, &reference, 1, &values[count]));
        } else {
            TEST_ASSERT_EQUAL(fmi2OK, get_integer(ring, &reference, 1, &whole));
            values[count] = whole;
        }
        count++;
    }
    return count;
}

/* ---- the ring by itself ---- */

typedef struct {
    scenario_t *scenario;
    rig_t *rig;
    course_t course;
    uint32_t ids[OUTPUTS];
    uint32_t count;
    uint32_t slots[OUTPUTS];
} reference_t;

static void keep_slots(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    reference_t *reference = context;
    (void)period;
    memcpy(reference->slots, slots, count * sizeof *slots);
}

static reference_t reference_started(void)
{
    scenario_error_t error;
    reference_t reference = {
        .scenario = scenario_read_text("ring", scenario_text, sizeof scenario_text - 1u, &error)};
    TEST_ASSERT_NOT_NULL_MESSAGE(reference.scenario, error.message);
    reference.rig = rig_create(reference.scenario->seed);
    TEST_ASSERT_TRUE(course_init(&reference.course, reference.scenario, reference.rig));
    TEST_ASSERT_TRUE(course_start(&reference.course, &error));
    const table_row_t *rows[FMU_VARIABLES_MAX];
    const uint32_t variables = fmu_variables(RIG_RING, rows);
    for (uint32_t n = 0; n < variables; n++) {
        if (fmu_is_output(RIG_RING, rows[n])) {
            reference.ids[reference.count++] = rows[n]->id;
        }
    }
    return reference;
}

static void reference_ended(reference_t *reference)
{
    course_free(&reference->course);
    rig_free(reference->rig);
    scenario_free(reference->scenario);
}

/* Every output has the value of its slot in the reference. */
static void expect_slots(const reference_t *reference, const double *values, uint32_t period)
{
    for (uint32_t n = 0; n < reference->count; n++) {
        const table_row_t *row = rig_row(reference->ids[n]);
        const double expected = tally_number(reference->slots[n], row->kind);
        char text[96];
        snprintf(text, sizeof text, "%s in period %u: %.9g instead of %.9g", row->name, (unsigned)period,
                 values[n], expected);
        TEST_ASSERT_TRUE_MESSAGE(memcmp(&expected, &values[n], sizeof expected) == 0 ||
                                     (expected != expected && values[n] != values[n]),
                                 text);
    }
}

static void test_every_output_of_every_period_has_the_bits_of_the_ring(void)
{
    reference_t reference = reference_started();
    scenario_error_t error;
    double values[OUTPUTS];
    TEST_ASSERT_TRUE(rig_tap(reference.rig, reference.ids, reference.count, 1u, keep_slots, &reference));
    fmi2Component ring = opened();
    for (uint32_t period = 0; period < PERIODS; period++) {
        TEST_ASSERT_EQUAL(period + 1u, course_run(&reference.course, period, period + 1u, &error));
        TEST_ASSERT_EQUAL_MESSAGE(fmi2OK, stepped(ring, period, 1), said);
        TEST_ASSERT_EQUAL(reference.count, outputs_of(ring, values));
        expect_slots(&reference, values, period);
    }
    TEST_ASSERT_EQUAL_DOUBLE(30.0, real_of(ring, "speed_request")); /* set by the event at 0.25 s */
    TEST_ASSERT_TRUE(real_of(ring, "true_omega_m") > 1.0);          /* and the rotor turns */
    free_instance(ring);
    reference_ended(&reference);
}

static void test_a_step_runs_the_periods_that_end_by_its_end(void)
{
    fmi2Component ring = opened();
    const double half = 0.5 * RIG_PERIOD_SECONDS;
    TEST_ASSERT_EQUAL(fmi2OK, do_step(ring, 0.0, half, fmi2True));
    const double before = real_of(ring, "period");
    TEST_ASSERT_EQUAL(fmi2OK, do_step(ring, half, 100.0 * RIG_PERIOD_SECONDS, fmi2True));
    TEST_ASSERT_EQUAL_DOUBLE(before + 100.0, real_of(ring, "period"));
    TEST_ASSERT_EQUAL(fmi2OK, do_step(ring, 100.5 * RIG_PERIOD_SECONDS, half, fmi2True));
    TEST_ASSERT_EQUAL_DOUBLE(before + 101.0, real_of(ring, "period"));
    TEST_ASSERT_EQUAL(fmi2Error, stepped(ring, 100, 1));
    TEST_ASSERT_EQUAL(fmi2Error, do_step(ring, 101.0 * RIG_PERIOD_SECONDS, -1.0, fmi2True));
    free_instance(ring);
}

/* ---- states ---- */

static void test_a_state_goes_on_where_it_was_saved_also_in_another_instance(void)
{
    fmi2FMUstate state = NULL;
    fmi2FMUstate copy = NULL;
    double first[OUTPUTS];
    double again[OUTPUTS];
    fmi2Component ring = opened();
    fmi2Component other = opened();
    TEST_ASSERT_EQUAL(fmi2OK, stepped(ring, 0, 1500)); /* within the ramp of the scenario */
    TEST_ASSERT_EQUAL(fmi2OK, get_state(ring, &state));
    TEST_ASSERT_EQUAL(fmi2OK, stepped(ring, 1500, 1400));
    const uint32_t count = outputs_of(ring, first);

    size_t size;
    TEST_ASSERT_EQUAL(fmi2OK, state_size(ring, state, &size));
    char *octets = malloc(size);
    TEST_ASSERT_EQUAL(fmi2OK, serialize(ring, state, octets, size));
    TEST_ASSERT_EQUAL(fmi2OK, deserialize(other, octets, size, &copy));
    TEST_ASSERT_EQUAL(fmi2OK, set_state(other, copy));
    TEST_ASSERT_EQUAL(fmi2OK, stepped(other, 1500, 1400));
    TEST_ASSERT_EQUAL(count, outputs_of(other, again));
    TEST_ASSERT_EQUAL_MEMORY(first, again, count * sizeof first[0]);
    TEST_ASSERT_EQUAL(fmi2OK, set_state(ring, state));
    TEST_ASSERT_EQUAL(fmi2OK, stepped(ring, 1500, 1400));
    (void)outputs_of(ring, again);
    TEST_ASSERT_EQUAL_MEMORY(first, again, count * sizeof first[0]);

    octets[size / 2u] ^= 1;
    TEST_ASSERT_EQUAL(fmi2OK, free_state(other, &copy));
    TEST_ASSERT_NULL(copy);
    TEST_ASSERT_EQUAL(fmi2Error, deserialize(other, octets, size, &copy));
    TEST_ASSERT_NOT_NULL(strstr(said, "the state is damaged"));
    octets[size / 2u] ^= 1;
    TEST_ASSERT_EQUAL(fmi2Error, deserialize(other, octets, size - 1u, &copy));
    free(octets);
    TEST_ASSERT_EQUAL(fmi2OK, free_state(ring, &state));
    free_instance(ring);
    free_instance(other);
}

static void test_a_reset_ring_begins_again(void)
{
    double first[OUTPUTS];
    double again[OUTPUTS];
    fmi2Component ring = opened();
    TEST_ASSERT_EQUAL(fmi2OK, stepped(ring, 0, 500));
    const uint32_t count = outputs_of(ring, first);
    TEST_ASSERT_EQUAL(fmi2OK, reset(ring));
    TEST_ASSERT_EQUAL(fmi2OK, set_up(ring, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    TEST_ASSERT_EQUAL(fmi2OK, enter(ring));
    TEST_ASSERT_EQUAL(fmi2OK, leave(ring));
    TEST_ASSERT_EQUAL(fmi2OK, stepped(ring, 0, 500));
    (void)outputs_of(ring, again);
    TEST_ASSERT_EQUAL_MEMORY(first, again, count * sizeof first[0]);
    free_instance(ring);
}

/* ---- what a master sets ---- */

static void test_an_input_acts_when_it_changes_and_not_when_it_is_repeated(void)
{
    fmi2Component ring = opened();
    for (uint32_t period = 0; period < 2600u; period++) { /* the event of period 2500 sets 30 rad/s */
        TEST_ASSERT_EQUAL(fmi2OK, put(ring, "speed_request", 20.0));
        TEST_ASSERT_EQUAL(fmi2OK, stepped(ring, period, 1));
    }
    TEST_ASSERT_EQUAL_DOUBLE(30.0, real_of(ring, "speed_request"));
    TEST_ASSERT_EQUAL(fmi2OK, put(ring, "speed_request", 25.0));
    TEST_ASSERT_EQUAL_DOUBLE(25.0, real_of(ring, "speed_request"));
    free_instance(ring);
}

static void test_parameters_of_one_call_are_applied_as_a_set(void)
{
    const fmi2ValueReference references[] = {rig_row_by_name("speed_kp")->id,
                                             rig_row_by_name("speed_ki")->id};
    const fmi2Real values[] = {0.25, 1.5};
    fmi2Component ring = opened();
    TEST_ASSERT_EQUAL_MESSAGE(fmi2OK, set_real(ring, references, 2, values), said);
    TEST_ASSERT_EQUAL(fmi2OK, stepped(ring, 0, 10));
    TEST_ASSERT_EQUAL_DOUBLE(0.25, real_of(ring, "speed_kp"));
    TEST_ASSERT_EQUAL_DOUBLE(1.5, real_of(ring, "speed_ki"));
    free_instance(ring);
}

static void test_a_value_out_of_its_range_is_discarded_with_the_range(void)
{
    fmi2Component ring = opened();
    TEST_ASSERT_EQUAL(fmi2Discard, put(ring, "speed_request", 1e6));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, "speed_request"), said);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, "accepted"), said);
    TEST_ASSERT_EQUAL_DOUBLE(20.0, real_of(ring, "speed_request"));
    TEST_ASSERT_EQUAL(fmi2Error, put(ring, "i_q", 1.0));
    const fmi2ValueReference unknown = FMU_ID_END - 1u;
    fmi2Real value = 0.0;
    TEST_ASSERT_EQUAL(fmi2Error, get_real(ring, &unknown, 1, &value));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, "6099"), said);
    free_instance(ring);
}

/* ---- no instance ---- */

static void expect_none(fmi2Type type, const char *guid, const char *where, const char *part)
{
    said[0] = '\0';
    TEST_ASSERT_NULL(instantiate("ring", type, guid, where, &callbacks, fmi2False, fmi2False));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(said, part), said);
}

static void test_a_wrong_archive_is_refused_with_the_cause(void)
{
    char guid[FMU_GUID_SIZE];
    fmu_guid(RIG_RING, guid);
    expect_none(fmi2ModelExchange, guid, location, "only co-simulation");
    expect_none(fmi2CoSimulation, "{another}", location, "GUID");
    expect_none(fmi2CoSimulation, guid, "http://somewhere", "file:///FOLDER");
    expect_none(fmi2CoSimulation, guid, "file:///nowhere%20at%20all", "/nowhere at all/scenario.toml");
}

/* The ids are value references and indices of arrays. */
static void test_every_variable_has_a_reference_below_the_end_and_outputs_fit_the_tap(void)
{
    for (uint32_t part = 0; part < FMU_PARTS; part++) {
        const table_row_t *rows[FMU_VARIABLES_MAX];
        const uint32_t variables = fmu_variables((rig_part_t)part, rows);
        uint32_t outputs = 0;
        TEST_ASSERT_TRUE(variables < FMU_VARIABLES_MAX);
        for (uint32_t n = 0; n < variables; n++) {
            const table_row_t *row = rows[n];
            TEST_ASSERT_TRUE_MESSAGE(row->id < FMU_ID_END && row->id != FMU_TIME, row->name);
            TEST_ASSERT_EQUAL_PTR(row, fmu_row((rig_part_t)part, row->id));
            outputs += fmu_is_output((rig_part_t)part, row) ? 1u : 0u;
        }
        TEST_ASSERT_TRUE(outputs > 0u && outputs <= RIG_TAP_MAX);
    }
}

/* Each row of the simulation is a variable of one part at least, but for those that need both parts. */
static void test_every_row_of_the_ring_belongs_to_a_part(void)
{
    const table_row_t *rows[FMU_VARIABLES_MAX];
    const uint32_t variables = fmu_variables(RIG_RING, rows);
    for (uint32_t n = 0; n < variables; n++) {
        const char *name = rows[n]->name;
        const bool of_both = strcmp(name, "theta_err") == 0 || strcmp(name, "theta_hat_err") == 0 ||
                             strcmp(name, "chip_reports") == 0;
        const bool found =
            fmu_row(RIG_DRIVE, rows[n]->id) == rows[n] || fmu_row(RIG_PLANT, rows[n]->id) == rows[n];
        TEST_ASSERT_TRUE_MESSAGE(found != of_both, name);
    }
}
