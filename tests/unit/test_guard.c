/* Every row of the fault table: in each period the result of the guard is compared with a model that
 * evaluates the same rows one at a time. */
#include "guard/guard.h"

#include "tests/unit/compare.h"
#include "tests/unit/sweep.h"

#include "estimator/chosen.h"
#include "fast/measure.h"
#include "guard/guard_quantities.h"
#include "medium/manoeuvre/manoeuvres.h"
#include "medium/protect/current_watch.h"
#include "medium/protect/encoder_watch.h"
#include "medium/protect/link_watch.h"
#include "medium/protect/motion_watch.h"
#include "settings/reasons.h"

#define ROWS ((uint32_t)FAULTS)

/* All inputs of the guard in a period. */
typedef struct {
    measured_t measured;
    guard_input_t input;
    guard_found_t found;
    uint32_t bad; /* 1: the sample is bad */
} scene_t;

static uint32_t clock; /* [periods] since setUp */

/* Each condition of the drive alone, and all of them together. */
#define EVERY (GUARD_ALWAYS | GUARD_RUNNING | GUARD_ENCODER | GUARD_TRACKING | GUARD_SUPPLIED)

static params_t params;
static guard_t each, slow; /* the guard of the fast task and that of the medium task */
static guard_tuning_t tuning;
static guard_t guard; /* the result of both */
static scene_t healthy;

/* Combines the results of both guards. */
static void unite(void)
{
    guard = each;
    guard.failed = fault_set_both(each.failed, slow.failed);
    guard.faults = fault_set_both(each.faults, slow.faults);
    guard.stops = fault_set_both(each.stops, slow.stops);
    guard.losses = fault_set_both(each.losses, slow.losses);
    guard.warnings = fault_set_both(each.warnings, slow.warnings);
}

/* None of the limits is the default one. */
void setUp(void)
{
    params_defaults(&params);
    for (uint32_t n = 0; n < ROWS; n++) {
        const table_row_t *limit = table_by_name(&params_table, fault_rows[n].limit);
        if (limit != NULL) {
            table_set(limit, &params, 0.97f * limit->initial);
        }
    }
    tuning = guard_prepare(&params);
    memset(&each, 0x55, sizeof each);
    memset(&slow, 0x55, sizeof slow);
    guard_init(&each);
    guard_init(&slow);
    unite();
    clock = 0u;
    healthy = (scene_t){
        .measured = {.current_abc = {1.0f, -0.5f, -0.5f},
                     .u_dc = 311.0f,
                     .sink_temperature = 40.0f,
                     .motor_temperature = 45.0f,
                     .flags = DRIVE_SAMPLE_FAULT_LINE}, /* this flag counts as a trip */
        .input = {.omega_m = 100.0f, .now = EVERY},
        .found = {.estimate_invalid = 0u},
    };
}

/* One guard has the rows that are judged in each period, the other those that are judged in the last
 * period of a window. If the first one returns that no call is necessary, a call must change nothing. */
static void step(const scene_t *scene)
{
    clock++;
    measured_t measured = scene->measured;
    guard_input_t input = scene->input;
    measured.good = 1u - scene->bad;
    input.measured = &measured;
    input.found = NULL;
    const guard_t before = each;
    const bool calm = guard_is_calm(&each, &tuning, &input, FAULT_EACH);
    guard_step_each(&each, &tuning, &input);
    TEST_ASSERT_TRUE(!calm || memcmp(&before, &each, sizeof each) == 0);
    if (clock % DRIVE_WINDOW == 0u) {
        input.found = &scene->found;
        guard_step_slow(&slow, &tuning, &input);
    }
    unite();
}

static fault_set_t row_of(uint32_t row)
{
    return fault_set_of((fault_bit_t)row);
}

static void expect_set(fault_set_t expected, fault_set_t set, const char *of)
{
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(expected.word[0], set.word[0], of);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(expected.word[1], set.word[1], of);
}

/* The shown rows, in the order of fault_reaction_t. */
static void expect_shown(const fault_set_t sets[4], const char *of)
{
    expect_set(sets[FAULT_OPEN], guard.faults, of);
    expect_set(sets[FAULT_STOP], guard.stops, of);
    expect_set(sets[FAULT_CATCH], guard.losses, of);
    expect_set(sets[FAULT_WARN], guard.warnings, of);
}

static void expect_nothing(void)
{
    static const fault_set_t none[4] = {{{0u, 0u}}, {{0u, 0u}}, {{0u, 0u}}, {{0u, 0u}}};
    expect_shown(none, "nothing");
}

/* The inputs from which a quantity of the table can come: bits of a word of the scene, or without bits a
 * float, whose magnitude counts for both signs. The inputs of the same quantity are adjacent. */
#define AT(field) offsetof(scene_t, field)
static const struct {
    const char *quantity;
    size_t at;
    uint32_t bits;
    float sign;
} ways[] = {
    {"phase_current", AT(measured.current_abc.a), 0u, 1.0f},
    {"phase_current", AT(measured.current_abc.b), 0u, 1.0f},
    {"phase_current", AT(measured.current_abc.c), 0u, 1.0f},
    {"phase_current", AT(measured.current_abc.a), 0u, -1.0f},
    {"phase_current", AT(measured.current_abc.b), 0u, -1.0f},
    {"phase_current", AT(measured.current_abc.c), 0u, -1.0f},
    {"u_dc", AT(measured.u_dc), 0u, 1.0f},
    {"sink_temperature", AT(measured.sink_temperature), 0u, 1.0f},
    {"motor_temperature", AT(measured.motor_temperature), 0u, 1.0f},
    {"speed", AT(input.omega_m), 0u, 1.0f},
    {"speed", AT(input.omega_m), 0u, -1.0f},
    {"tripped", AT(measured.flags), DRIVE_SAMPLE_TRIPPED, 0.0f},
    {"late", AT(measured.flags), DRIVE_SAMPLE_LATE_OFTEN, 0.0f},
    {"medium_late", AT(input.medium_late), 1u, 0.0f},
    {"encoder_error", AT(measured.flags), DRIVE_SAMPLE_ENCODER, 0.0f},
    {"bad_sample", AT(bad), 1u, 0.0f},
    {"estimate_amplitude", AT(found.estimate_invalid), ESTIMATOR_AMPLITUDE, 0.0f},
    {"estimate_detector", AT(found.estimate_invalid), ESTIMATOR_DETECTOR, 0.0f},
    {"estimate_current", AT(found.estimate_invalid), ESTIMATOR_CURRENT, 0.0f},
    {"estimate_current", AT(found.estimate_invalid), ESTIMATOR_SAMPLE, 0.0f},
    {"estimate_speed", AT(found.estimate_invalid), ESTIMATOR_SPEED, 0.0f},
    {"unlocked", AT(found.unlocked), 1u, 0.0f},
    {"lock_lost", AT(found.failed), MANOEUVRE_LOST, 0.0f},
    {"start_stalled", AT(found.failed), MANOEUVRE_STALLED, 0.0f},
    {"start_unlocked", AT(found.failed), MANOEUVRE_UNLOCKED, 0.0f},
    {"rotor_too_fast", AT(found.too_fast), 1u, 0.0f},
    {"program_corrupt", AT(found.reported), GUARD_CORRUPT_PROGRAM, 0.0f},
    {"program_corrupt", AT(found.reported), GUARD_CORRUPT_INTERRUPT_CODE, 0.0f},
    {"params_corrupt", AT(found.reported), GUARD_CORRUPT_PARAMS, 0.0f},
    {"stack_low", AT(found.reported), GUARD_CORRUPT_STACK_END, 0.0f},
    {"master_silent", AT(found.reported), GUARD_MASTER_SILENT, 0.0f},
    {"background_stalled", AT(found.unattended), 1u, 0.0f},
    {"encoder_jump", AT(input.encoder_wrong), ENCODER_WATCH_JUMP, 0.0f},
    {"encoder_direction", AT(input.encoder_wrong), ENCODER_WATCH_DIRECTION, 0.0f},
    {"encoder_mismatch", AT(input.encoder_wrong), ENCODER_WATCH_MISMATCH, 0.0f},
    {"encoder_lost", AT(found.encoder_lost), 1u, 0.0f},
    {"runaway", AT(found.moves_wrong), MOTION_RUNAWAY, 0.0f},
    {"stalled", AT(found.moves_wrong), MOTION_STALLED, 0.0f},
    {"speed_error", AT(found.moves_wrong), MOTION_SPEED_ERROR, 0.0f},
    {"current_stuck", AT(found.current_faults), CURRENT_WATCH_STUCK, 0.0f},
    {"current_gain", AT(found.current_faults), CURRENT_WATCH_GAIN, 0.0f},
    {"phase_loss", AT(found.current_faults), CURRENT_WATCH_LOSS, 0.0f},
    {"current_sum", AT(found.current_faults), CURRENT_WATCH_SUM, 0.0f},
    {"motor_overload", AT(found.heat), THERMAL_MOTOR, 0.0f},
    {"module_overload", AT(found.heat), THERMAL_MODULE, 0.0f},
    {"derating", AT(found.heat), THERMAL_DERATING, 0.0f},
    {"dc_ripple", AT(found.link), LINK_RIPPLES, 0.0f},
    {"dc_limits", AT(found.link), LINK_LIMITS, 0.0f},
    {"loop_slow", AT(found.loops), GUARD_LOOP_SLOW, 0.0f},
    {"oscillation", AT(found.loops), GUARD_LOOP_OSCILLATED, 0.0f},
    {"chopper_overload", AT(found.chopper), CHOPPER_OVERLOAD, 0.0f},
    {"chopper_no_effect", AT(found.chopper), CHOPPER_NO_EFFECT, 0.0f},
    {"brake_torque", AT(found.brake_torque), 1u, 0.0f},
};
#define WAYS (sizeof ways / sizeof ways[0])

static bool is_way(size_t way, uint32_t row)
{
    return way < WAYS && strcmp(ways[way].quantity, fault_rows[row].quantity) == 0;
}

/* The first input of a row. If a row has none, the test fails here, and its quantity must be added above. */
static size_t way_of(uint32_t row)
{
    size_t way = 0;
    while (way < WAYS && !is_way(way, row)) {
        way++;
    }
    TEST_ASSERT_TRUE_MESSAGE(way < WAYS, fault_rows[row].quantity);
    return way;
}

static void put(scene_t *scene, size_t way, float value)
{
    char *const at = (char *)scene + ways[way].at;
    uint32_t word;
    if (ways[way].bits == 0u) {
        value *= ways[way].sign;
        memcpy(at, &value, sizeof value);
        return;
    }
    memcpy(&word, at, sizeof word);
    word = value != 0.0f ? word | ways[way].bits : word & ~ways[way].bits;
    memcpy(at, &word, sizeof word);
}

/* ---- the model ---- */

static bool compares(uint32_t row, const char *comparison)
{
    return strcmp(fault_rows[row].comparison, comparison) == 0;
}

static float limit_of(uint32_t row)
{
    if (compares(row, "HOLDS")) {
        return 0.0f;
    }
    const table_row_t *limit = table_by_name(&params_table, fault_rows[row].limit);
    TEST_ASSERT_NOT_NULL_MESSAGE(limit, fault_rows[row].name);
    return table_get(limit, &params) + fault_rows[row].margin;
}

/* The nearest value on the wrong side of the row's limit. */
static float beyond(uint32_t row)
{
    if (compares(row, "HOLDS")) {
        return 1.0f;
    }
    return nextafterf(limit_of(row), compares(row, "ABOVE") ? 1e9f : -1e9f);
}

static bool holds(uint32_t row, float value)
{
    if (compares(row, "ABOVE")) {
        return value > limit_of(row);
    }
    if (compares(row, "BELOW")) {
        return value < limit_of(row);
    }
    TEST_ASSERT_TRUE(compares(row, "HOLDS"));
    return value != 0.0f;
}

static bool counts(uint32_t row, uint32_t now)
{
    return fault_rows[row].when == FAULT_ALWAYS || (now & GUARD_MOMENT(fault_rows[row].when)) != 0u;
}

/* Returns the number of periods that the guard has counted for a row whose condition has held for the last
 * `periods`. For a row that is not evaluated in each period, these are the periods from the first
 * evaluation of this time to the last one. */
static uint32_t seen(const fault_row_t *row, uint32_t periods)
{
    if (row->rate == FAULT_EACH) {
        return periods;
    }
    const uint32_t looks = clock / DRIVE_WINDOW - (clock - periods) / DRIVE_WINDOW;
    return looks == 0u ? 0u : 1u + DRIVE_WINDOW * (looks - 1u);
}

/* Returns the state of a row whose quantity had this value for this number of periods. */
static void expect_after(uint32_t of_row, float value, uint32_t now, uint32_t periods)
{
    fault_set_t sets[4] = {{{0u, 0u}}, {{0u, 0u}}, {{0u, 0u}}, {{0u, 0u}}};
    for (uint32_t n = 0; n < ROWS; n++) {
        const fault_row_t *row = &fault_rows[n];
        if (strcmp(row->quantity, fault_rows[of_row].quantity) == 0 && holds(n, value) && counts(n, now) &&
            seen(row, periods) >= row->debounce) {
            sets[row->reaction] = fault_set_both(sets[row->reaction], row_of(n));
        }
    }
    expect_shown(sets, fault_rows[of_row].name);
}

static bool shown(uint32_t row)
{
    return fault_set_has(guard.failed, (fault_bit_t)row);
}

/* Runs this number of periods with this value. On the host all periods are compared, on other targets
 * those next to the debounce and some of the others. */
static void check_periods(uint32_t row, float value, size_t way, uint32_t now, uint32_t count)
{
    scene_t scene = healthy;
    put(&scene, way, value);
    scene.input.now = now;
    for (uint32_t n = 1; n <= count; n++) {
        const bool decides =
            n + DRIVE_WINDOW >= fault_rows[row].debounce && n <= fault_rows[row].debounce + 2u * DRIVE_WINDOW;
        step(&scene);
        if (decides || n % SWEEP_FEW == 0u) {
            expect_after(row, value, now, n);
        }
    }
}

/* Runs without a fault until no row is shown or counted any more, at most until the next evaluation. */
static void recover(void)
{
    do {
        step(&healthy);
    } while (clock % DRIVE_WINDOW != 0u);
    expect_nothing();
}

/* ---- every row ---- */

/* A row is not shown at its limit. Beyond the limit it must hold for its debounce time; then it is shown
 * exactly as long as it holds. */
static void test_every_row_shows_beyond_its_limit_after_its_debounce(void)
{
    for (uint32_t row = 0; row < ROWS; row++) {
        const uint32_t debounce = fault_rows[row].debounce;
        for (size_t way = way_of(row); is_way(way, row); way++) {
            setUp();
            check_periods(row, limit_of(row), way, EVERY, debounce + 10u);
            TEST_ASSERT_FALSE_MESSAGE(shown(row), fault_rows[row].name);
            setUp();
            check_periods(row, beyond(row), way, EVERY, debounce - 1u);
            TEST_ASSERT_FALSE_MESSAGE(shown(row), fault_rows[row].name);
            setUp();
            check_periods(row, beyond(row), way, EVERY, debounce + 100u);
            TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
            TEST_ASSERT_TRUE(guard.held[row] < debounce); /* the count ends at the debounce */
            if (fault_rows[row].rate == FAULT_EACH) {
                step(&healthy);
                expect_nothing();
            }
            recover();
        }
    }
}

/* [periods] after which a row is shown, whatever the times of the evaluations are. */
static uint32_t enough(uint32_t row)
{
    return fault_rows[row].debounce + (fault_rows[row].rate == FAULT_SLOW ? 2u * DRIVE_WINDOW : 0u);
}

static void test_every_row_counts_again_after_a_break(void)
{
    for (uint32_t row = 0; row < ROWS; row += SWEEP_FEW) {
        setUp();
        for (int n = 0; n < 3; n++) {
            check_periods(row, beyond(row), way_of(row), EVERY, fault_rows[row].debounce - 1u);
            recover();
        }
        check_periods(row, beyond(row), way_of(row), EVERY, enough(row));
        TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
    }
}

/* Each time at which a condition may begin. With the gates off only lasting dangers count; conditions of
 * the encoder and of the estimate count only while the control uses them. An earlier condition counts from
 * that time on. */
static void test_every_row_is_silent_until_its_moment(void)
{
    for (uint32_t row = 0; row < ROWS; row += SWEEP_FEW) {
        for (uint32_t moments = 0u; moments <= EVERY; moments += SWEEP_FEW) {
            setUp();
            check_periods(row, beyond(row), way_of(row), moments, fault_rows[row].debounce + 100u);
            TEST_ASSERT_EQUAL_MESSAGE(counts(row, moments), shown(row), fault_rows[row].name);
            if (!counts(row, moments)) {
                const uint32_t its_own = GUARD_MOMENT(fault_rows[row].when);
                check_periods(row, beyond(row), way_of(row), its_own, enough(row));
                TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
                if (fault_rows[row].rate == FAULT_EACH) {
                    /* And not longer than its condition holds. */
                    check_periods(row, beyond(row), way_of(row), moments, 1u);
                }
            }
        }
    }
}

/* ---- requirements on the table ---- */

/* The value of the first list that contains the name of the row; each name in a list is between blanks. */
typedef struct {
    const char *rows;
    float value;
} rule_t;

static float ruled(const rule_t *rule, uint32_t row)
{
    char name[40];
    TEST_ASSERT_TRUE(snprintf(name, sizeof name, " %s ", fault_rows[row].name) < (int)sizeof name);
    while (rule->rows != NULL && strstr(rule->rows, name) == NULL) {
        rule++;
    }
    return rule->value;
}

/* Debounce times: a danger of destruction within a period stops the drive at once, a voltage or a speed
 * within a millisecond, a temperature within a tenth of a second. Single disturbed conversions and late
 * interrupts are permitted. The other conditions are debounced where they are detected. */
static const rule_t debounces[] = {{" bad_sample ", 3.0f},
                                   {" dc_overvoltage ", 2.0f},
                                   {" overspeed dc_undervoltage ", 1e-3f / DRIVE_PERIOD},
                                   {" sink_hot motor_hot sink_warm motor_warm ", 0.1f / DRIVE_PERIOD},
                                   {" unlocked ", 5e-3f / DRIVE_PERIOD - 2.0f * DRIVE_WINDOW},
                                   {" current_sum ", 2.4e-3f / DRIVE_PERIOD},
                                   {NULL, 1.0f}};

/* The periods in which each row is evaluated. The conditions that last or destroy are evaluated also with
 * the gates off, those of the encoder and of the estimate only while the control uses them, and all others
 * while the gates are on. */
static const rule_t moments[] = {
    {" overcurrent bad_sample dc_overvoltage sink_hot motor_hot sink_warm motor_warm program_corrupt "
     "params_corrupt stack_low encoder_lost motor_overload module_overload derating master_silent "
     "loop_slow oscillation chopper_overload chopper_no_effect ",
     FAULT_ALWAYS},
    {" encoder_phase encoder_jump encoder_direction encoder_mismatch runaway ", FAULT_ENCODER},
    {" estimate_amplitude estimate_detector estimate_current estimate_speed unlocked ", FAULT_TRACKING},
    {" dc_undervoltage ", FAULT_SUPPLIED},
    {NULL, FAULT_RUNNING}};

/* A slow danger leaves time to brake. Warnings are given for heat, active limits and ripple, and for an
 * encoder that is not used any more. A lost rotor is caught again; too many losses, or a failed start, are
 * a fault. */
static const rule_t reactions[] = {
    {" sink_hot motor_hot background_stalled speed_error motor_overload ", FAULT_STOP},
    {" sink_warm motor_warm encoder_lost derating dc_ripple dc_limits master_silent loop_slow oscillation ",
     FAULT_WARN},
    {" estimate_amplitude estimate_detector estimate_current estimate_speed unlocked ", FAULT_CATCH},
    {NULL, FAULT_OPEN}};

/* A warning of temperature is given 10 K below the limit. */
static const rule_t margins[] = {{" sink_warm motor_warm ", -10.0f}, {NULL, 0.0f}};

static void test_reactions_are_as_fast_as_the_danger(void)
{
    for (uint32_t n = 0; n < ROWS; n++) {
        const fault_row_t *row = &fault_rows[n];
        TEST_ASSERT_EQUAL_FLOAT_MESSAGE(ruled(margins, n), row->margin, row->name);
        TEST_ASSERT_FLOAT_WITHIN_MESSAGE(0.51f, ruled(debounces, n), (float)row->debounce, row->name);
        TEST_ASSERT_EQUAL_MESSAGE((int)ruled(moments, n), row->when, row->name);
        TEST_ASSERT_EQUAL_MESSAGE((int)ruled(reactions, n), row->reaction, row->name);
    }
}

/* The place of a row is its bit, and its number is permanent: new rows are only appended. Each row is a
 * reason with a text. */
static void test_rows_keep_their_places_and_numbers(void)
{
    static const int32_t numbers[] = {20, 21, 30, 22, 26, 29, 23, 28, 24, 25, 32, 33, 34, 35,  37,  38,
                                      39, 40, 41, 42, 66, 67, 68, 69, 48, 49, 50, 51, 52, 53,  54,  43,
                                      44, 45, 46, 56, 57, 58, 59, 60, 61, 71, 83, 84, 85, 150, 151, 152};
    TEST_ASSERT_EQUAL_UINT32(sizeof numbers / sizeof numbers[0], ROWS);
    for (uint32_t n = 0; n < ROWS; n++) {
        TEST_ASSERT_EQUAL_INT32_MESSAGE(numbers[n], fault_rows[n].reason, fault_rows[n].name);
        TEST_ASSERT_NOT_NULL(reason_by_number(numbers[n]));
        TEST_ASSERT_EQUAL_STRING(fault_rows[n].name, reason_by_number(numbers[n])->name);
    }
}

/* ---- several faults at once ---- */

static void test_the_gravest_of_several_is_named(void)
{
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, guard_reason(fault_set_none()));
    for (uint32_t gravest = 0; gravest < ROWS; gravest++) {
        fault_set_t all = fault_set_none();
        for (uint32_t n = gravest; n < ROWS; n++) {
            all = fault_set_both(all, row_of(n));
        }
        TEST_ASSERT_EQUAL_INT32(fault_rows[gravest].reason, guard_reason(all));
    }
    TEST_ASSERT_EQUAL_INT32(REASON_MODULE_FAULT, fault_rows[0].reason);
    TEST_ASSERT_EQUAL_INT32(REASON_OVERCURRENT, fault_rows[1].reason);
}

/* Any two conditions that fail at once, in one word or in two. */
static void test_conditions_at_once_are_distinguished(void)
{
    for (uint32_t one = 0; one < ROWS; one++) {
        for (uint32_t other = 0; other < one; other++) {
            scene_t scene = healthy;
            if (!compares(one, "HOLDS") || !compares(other, "HOLDS") || fault_rows[one].debounce > 1u ||
                fault_rows[other].debounce > 1u) {
                continue;
            }
            setUp();
            put(&scene, way_of(one), 1.0f);
            put(&scene, way_of(other), 1.0f);
            for (uint32_t n = 0; n < DRIVE_WINDOW; n++) {
                step(&scene);
            }
            expect_set(fault_set_both(row_of(one), row_of(other)), guard.failed, fault_rows[one].name);
        }
    }
}

/* ---- new limits ---- */

static void test_new_limits_act_at_once_and_the_counting_goes_on(void)
{
    const fault_set_t overcurrent = fault_set_of(FAULT_OVERCURRENT); /* with a limit of 1 A */
    scene_t scene = healthy;
    scene.measured.u_dc = params.dc_undervoltage - 1.0f;
    for (uint32_t n = 1; n <= DRIVE_PERIODS(1e-3f); n++) {
        if (n == DRIVE_PERIODS(1e-3f) / 2u) {
            params.dc_undervoltage -= 0.5f; /* still above the link */
            params.overcurrent_trip = 0.75f;
            tuning = guard_prepare(&params);
        }
        step(&scene);
        if (n < DRIVE_PERIODS(1e-3f)) {
            expect_set(n < DRIVE_PERIODS(1e-3f) / 2u ? fault_set_none() : overcurrent, guard.faults,
                       "so far");
        }
    }
    expect_set(fault_set_both(overcurrent, fault_set_of(FAULT_DC_UNDERVOLTAGE)), guard.faults, "at last");
}
