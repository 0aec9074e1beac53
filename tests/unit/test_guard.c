/* Every row of the fault table, from the table: what the guard says is compared period by period with a model
 * that reads the same rows one at a time. */
#include "drive/guard.h"

#include <math.h>
#include <string.h>
#include <unity.h>

#include "drive/manoeuvres.h"
#include "drive/measure.h"
#include "drive/reasons.h"
#include "estimator/chosen.h"

#define ROWS ((uint32_t)FAULTS)

/* All that the guard is told of a period. */
typedef struct {
    measured_t measured;
    float omega_m;
    uint32_t invalid, unlocked, failed;
    uint32_t now; /* moments that are */
} scene_t;

/* Each moment for itself, as the drive can have them, and all. */
#define EVERY (GUARD_ALWAYS | GUARD_RUNNING | GUARD_ENCODER | GUARD_TRACKING)

static params_t params;
static guard_t guard;
static scene_t healthy;

/* None of the limits is a default. */
void setUp(void)
{
    params_defaults(&params);
    for (uint32_t n = 0; n < ROWS; n++) {
        const table_row_t *limit = table_by_name(&params_table, fault_rows[n].limit);
        if (limit != NULL) {
            table_set(limit, &params, 0.97f * limit->initial);
        }
    }
    const guard_tuning_t tuning = guard_prepare(&params);
    memset(&guard, 0x55, sizeof guard);
    guard_init(&guard, &tuning);
    healthy = (scene_t){
        .measured = {.current_abc = {1.0f, -0.5f, -0.5f},
                     .u_dc = 311.0f,
                     .sink_temperature = 40.0f,
                     .motor_temperature = 45.0f,
                     .flags = DRIVE_SAMPLE_FAULT_LINE, /* a trip is what counts */
                     .good = 1u},
        .omega_m = 100.0f,
        .invalid = ESTIMATOR_SAMPLE, /* counted by itself, as a bad sample */
        .now = EVERY,
    };
}

void tearDown(void)
{
}

static void step(const scene_t *scene)
{
    const guard_input_t input = {&scene->measured, scene->omega_m, scene->invalid,
                                 scene->unlocked,  scene->failed,  scene->now};
    guard_step(&guard, &input);
}

/* ---- where the quantities of the table come from, each in every way it can ---- */

static void set_current(scene_t *scene, float value, int way)
{
    float *phases[] = {&scene->measured.current_abc.a, &scene->measured.current_abc.b,
                       &scene->measured.current_abc.c};
    *phases[way % 3] = way < 3 ? value : -value;
}

static void set_u_dc(scene_t *scene, float value, int way)
{
    (void)way;
    scene->measured.u_dc = value;
}

static void set_sink(scene_t *scene, float value, int way)
{
    (void)way;
    scene->measured.sink_temperature = value;
}

static void set_motor(scene_t *scene, float value, int way)
{
    (void)way;
    scene->measured.motor_temperature = value;
}

static void set_speed(scene_t *scene, float value, int way)
{
    scene->omega_m = way == 0 ? value : -value;
}

static void set_flag(scene_t *scene, uint32_t flag, float value)
{
    scene->measured.flags = (scene->measured.flags & ~flag) | (value != 0.0f ? flag : 0u);
}

static void set_tripped(scene_t *scene, float value, int way)
{
    (void)way;
    set_flag(scene, DRIVE_SAMPLE_TRIPPED, value);
}

static void set_late(scene_t *scene, float value, int way)
{
    (void)way;
    set_flag(scene, DRIVE_SAMPLE_LATE, value);
}

static void set_encoder(scene_t *scene, float value, int way)
{
    (void)way;
    set_flag(scene, DRIVE_SAMPLE_ENCODER, value);
}

static void set_bad(scene_t *scene, float value, int way)
{
    (void)way;
    scene->measured.good = value != 0.0f ? 0u : 1u;
}

static void set_invalid(scene_t *scene, uint32_t criterion, float value)
{
    scene->invalid = (scene->invalid & ~criterion) | (value != 0.0f ? criterion : 0u);
}

static void set_amplitude(scene_t *scene, float value, int way)
{
    (void)way;
    set_invalid(scene, ESTIMATOR_AMPLITUDE, value);
}

static void set_detector(scene_t *scene, float value, int way)
{
    (void)way;
    set_invalid(scene, ESTIMATOR_DETECTOR, value);
}

static void set_observed(scene_t *scene, float value, int way)
{
    (void)way;
    set_invalid(scene, ESTIMATOR_CURRENT, value);
}

static void set_estimate_speed(scene_t *scene, float value, int way)
{
    (void)way;
    set_invalid(scene, ESTIMATOR_SPEED, value);
}

static void set_unlocked(scene_t *scene, float value, int way)
{
    (void)way;
    scene->unlocked = value != 0.0f ? 1u : 0u;
}

static void set_failed(scene_t *scene, uint32_t what, float value)
{
    scene->failed = value != 0.0f ? scene->failed | what : scene->failed & ~what;
}

static void set_lock_lost(scene_t *scene, float value, int way)
{
    (void)way;
    set_failed(scene, MANOEUVRE_LOST, value);
}

static void set_start_stalled(scene_t *scene, float value, int way)
{
    (void)way;
    set_failed(scene, MANOEUVRE_STALLED, value);
}

static void set_start_unlocked(scene_t *scene, float value, int way)
{
    (void)way;
    set_failed(scene, MANOEUVRE_UNLOCKED, value);
}

static void set_rotor_too_fast(scene_t *scene, float value, int way)
{
    (void)way;
    set_failed(scene, MANOEUVRE_TOO_FAST, value);
}

typedef struct {
    const char *name;
    void (*set)(scene_t *scene, float value, int way);
    int ways;
} quantity_t;

static const quantity_t quantities[] = {
    {"phase_current", set_current, 6},
    {"u_dc", set_u_dc, 1},
    {"sink_temperature", set_sink, 1},
    {"motor_temperature", set_motor, 1},
    {"speed", set_speed, 2},
    {"tripped", set_tripped, 1},
    {"bad_sample", set_bad, 1},
    {"late", set_late, 1},
    {"encoder_error", set_encoder, 1},
    {"estimate_amplitude", set_amplitude, 1},
    {"estimate_detector", set_detector, 1},
    {"estimate_current", set_observed, 1},
    {"estimate_speed", set_estimate_speed, 1},
    {"unlocked", set_unlocked, 1},
    {"lock_lost", set_lock_lost, 1},
    {"start_stalled", set_start_stalled, 1},
    {"start_unlocked", set_start_unlocked, 1},
    {"rotor_too_fast", set_rotor_too_fast, 1},
};

/* A row whose quantity is not there fails here: it must be added above. */
static const quantity_t *quantity_of(uint32_t row)
{
    const quantity_t *found = NULL;
    for (size_t n = 0; n < sizeof quantities / sizeof quantities[0]; n++) {
        if (strcmp(quantities[n].name, fault_rows[row].quantity) == 0) {
            found = &quantities[n];
        }
    }
    TEST_ASSERT_NOT_NULL_MESSAGE(found, fault_rows[row].quantity);
    return found;
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

/* Faults, losses and warnings after a quantity has had this value for so many periods. */
static void expect_after(uint32_t of_row, float value, uint32_t now, uint32_t periods)
{
    uint32_t faults = 0u;
    uint32_t losses = 0u;
    uint32_t warnings = 0u;
    for (uint32_t n = 0; n < ROWS; n++) {
        const fault_row_t *row = &fault_rows[n];
        if (strcmp(row->quantity, fault_rows[of_row].quantity) == 0 && holds(n, value) && counts(n, now) &&
            periods >= row->debounce) {
            faults |= row->reaction == FAULT_OPEN ? UINT32_C(1) << n : 0u;
            losses |= row->reaction == FAULT_CATCH ? UINT32_C(1) << n : 0u;
            warnings |= row->reaction == FAULT_WARN ? UINT32_C(1) << n : 0u;
        }
    }
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(faults, guard.faults, fault_rows[of_row].name);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(losses, guard.losses, fault_rows[of_row].name);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(warnings, guard.warnings, fault_rows[of_row].name);
}

static bool shown(uint32_t row)
{
    return ((guard.faults | guard.losses | guard.warnings) >> row & 1u) != 0u;
}

/* So many periods with this value, each compared. */
static void check_periods(uint32_t row, float value, int way, uint32_t now, uint32_t count)
{
    scene_t scene = healthy;
    quantity_of(row)->set(&scene, value, way);
    scene.now = now;
    for (uint32_t n = 1; n <= count; n++) {
        step(&scene);
        expect_after(row, value, now, n);
    }
}

/* ---- every row ---- */

static void test_a_healthy_drive_runs_on(void)
{
    for (int n = 0; n < 3000; n++) {
        step(&healthy);
        TEST_ASSERT_EQUAL_HEX32(0u, guard.faults);
        TEST_ASSERT_EQUAL_HEX32(0u, guard.losses);
        TEST_ASSERT_EQUAL_HEX32(0u, guard.warnings);
    }
}

static void test_every_row_at_its_limit_is_silent(void)
{
    for (uint32_t row = 0; row < ROWS; row++) {
        for (int way = 0; way < quantity_of(row)->ways; way++) {
            setUp();
            check_periods(row, limit_of(row), way, EVERY, fault_rows[row].debounce + 10u);
            TEST_ASSERT_FALSE_MESSAGE(shown(row), fault_rows[row].name);
        }
    }
}

/* Its debounce long it must hold; then it is shown for as long as it holds, and no longer. */
static void test_every_row_beyond_its_limit_shows_after_its_debounce(void)
{
    for (uint32_t row = 0; row < ROWS; row++) {
        for (int way = 0; way < quantity_of(row)->ways; way++) {
            setUp();
            check_periods(row, beyond(row), way, EVERY, fault_rows[row].debounce - 1u);
            TEST_ASSERT_FALSE_MESSAGE(shown(row), fault_rows[row].name);
            setUp();
            check_periods(row, beyond(row), way, EVERY, fault_rows[row].debounce + 100u);
            TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
            if (fault_rows[row].debounce > 1u) { /* else there is nothing to count */
                TEST_ASSERT_EQUAL_UINT32(fault_rows[row].debounce - 1u, guard.held[row]); /* and no further */
            }
            step(&healthy);
            TEST_ASSERT_EQUAL_HEX32(0u, guard.faults | guard.losses | guard.warnings);
        }
    }
}

static void test_every_row_counts_anew_after_a_break(void)
{
    for (uint32_t row = 0; row < ROWS; row++) {
        setUp();
        for (int n = 0; n < 3; n++) {
            check_periods(row, beyond(row), 0, EVERY, fault_rows[row].debounce - 1u);
            step(&healthy);
            TEST_ASSERT_EQUAL_HEX32(0u, guard.faults | guard.losses);
        }
        check_periods(row, beyond(row), 0, EVERY, fault_rows[row].debounce);
        TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
    }
}

/* Of the moments that there can be: with the gates off only lasting dangers count, the encoder's and the
 * estimate's only while control turns with them; what was there before the moment is counted from then. */
static void test_every_row_is_silent_until_its_moment(void)
{
    for (uint32_t row = 0; row < ROWS; row++) {
        for (uint32_t moments = 0u; moments <= EVERY; moments++) {
            setUp();
            check_periods(row, beyond(row), 0, moments, fault_rows[row].debounce + 100u);
            TEST_ASSERT_EQUAL_MESSAGE(counts(row, moments), shown(row), fault_rows[row].name);
            if (!counts(row, moments)) {
                const uint32_t its_own = GUARD_MOMENT(fault_rows[row].when);
                check_periods(row, beyond(row), 0, its_own, fault_rows[row].debounce);
                TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
                check_periods(row, beyond(row), 0, moments, 1u); /* and no longer than it is */
            }
        }
    }
}

static void test_every_row_has_a_reason_of_its_own_that_can_be_read(void)
{
    for (uint32_t n = 0; n < ROWS; n++) {
        const int32_t reason = guard_reason(UINT32_C(1) << n);
        TEST_ASSERT_EQUAL_INT32(fault_rows[n].reason, reason);
        TEST_ASSERT_NOT_NULL(reason_by_number(reason));
        TEST_ASSERT_EQUAL_STRING(fault_rows[n].name, reason_by_number(reason)->name);
        TEST_ASSERT_TRUE(fault_rows[n].debounce > 0u);
        for (uint32_t m = 0; m < n; m++) {
            TEST_ASSERT_TRUE(fault_rows[m].reason != reason);
        }
    }
}

/* ---- what the table must say ---- */

/* Every way to be destroyed within a period stops at once, a voltage or a speed within a millisecond, a
 * temperature within a tenth of a second; a conversion may be disturbed, an interrupt late, once and again.
 * Only the warm sink warns. A rotor that is lost is caught again, and that it was lost too often, or a start
 * failed, is a fault. */
static void test_reactions_are_as_fast_as_the_danger(void)
{
    static const struct {
        int32_t reason;
        float seconds;
        uint32_t periods;
        fault_when_t when;
        fault_reaction_t reaction;
    } rows[] = {
        {REASON_MODULE_FAULT, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_OVERCURRENT, 0.0f, 1u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_BAD_SAMPLE, 0.0f, 3u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_DC_OVERVOLTAGE, 0.0f, 2u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_OVERSPEED, 1e-3f, 0u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_LATE, 0.0f, 3u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_DC_UNDERVOLTAGE, 1e-3f, 0u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_ENCODER_PHASE, 0.0f, 1u, FAULT_ENCODER, FAULT_OPEN},
        {REASON_SINK_HOT, 0.1f, 0u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_MOTOR_HOT, 0.1f, 0u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_ESTIMATE_AMPLITUDE, 0.0f, 1u, FAULT_TRACKING, FAULT_CATCH},
        {REASON_ESTIMATE_DETECTOR, 0.0f, 1u, FAULT_TRACKING, FAULT_CATCH},
        {REASON_ESTIMATE_CURRENT, 0.0f, 1u, FAULT_TRACKING, FAULT_CATCH},
        {REASON_ESTIMATE_SPEED, 0.0f, 1u, FAULT_TRACKING, FAULT_CATCH},
        {REASON_SINK_WARM, 0.1f, 0u, FAULT_ALWAYS, FAULT_WARN},
        {REASON_UNLOCKED, 5e-3f, 0u, FAULT_TRACKING, FAULT_CATCH},
        {REASON_LOCK_LOST, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_START_STALLED, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_START_UNLOCKED, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_ROTOR_TOO_FAST, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
    };
    TEST_ASSERT_EQUAL_UINT32(sizeof rows / sizeof rows[0], ROWS);
    for (uint32_t n = 0; n < ROWS; n++) {
        TEST_ASSERT_EQUAL_INT32(rows[n].reason, fault_rows[n].reason);
        TEST_ASSERT_EQUAL_MESSAGE(rows[n].when, fault_rows[n].when, fault_rows[n].name);
        TEST_ASSERT_EQUAL_MESSAGE(rows[n].reaction, fault_rows[n].reaction, fault_rows[n].name);
        if (rows[n].periods > 0u) {
            TEST_ASSERT_EQUAL_UINT32(rows[n].periods, fault_rows[n].debounce);
        } else {
            TEST_ASSERT_FLOAT_WITHIN(0.51f * DRIVE_PERIOD, rows[n].seconds,
                                     (float)fault_rows[n].debounce * DRIVE_PERIOD);
        }
    }
}

/* Warm is 10 K below hot, warns and opens nothing; hot does both. */
static void test_a_warm_sink_warns_before_it_is_hot(void)
{
    scene_t scene = healthy;
    params.sink_temperature_max = 85.0f;
    const guard_tuning_t tuning = guard_prepare(&params);
    guard_take(&guard, &tuning);
    static const struct {
        float temperature;
        bool warm, hot;
    } cases[] = {{75.0f, false, false}, {75.01f, true, false}, {85.0f, true, false}, {85.01f, true, true}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        scene.measured.sink_temperature = cases[n].temperature;
        for (uint32_t m = 0; m < DRIVE_PERIODS(0.2f); m++) {
            step(&scene);
        }
        TEST_ASSERT_EQUAL_HEX32(cases[n].warm ? UINT32_C(1) << FAULT_SINK_WARM : 0u, guard.warnings);
        TEST_ASSERT_EQUAL_HEX32(cases[n].hot ? UINT32_C(1) << FAULT_SINK_HOT : 0u, guard.faults);
    }
}

/* ---- several at once ---- */

static void test_the_gravest_of_several_is_named(void)
{
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, guard_reason(0u));
    for (uint32_t gravest = 0; gravest < ROWS; gravest++) {
        uint32_t all = 0u;
        for (uint32_t n = gravest; n < ROWS; n++) {
            all |= UINT32_C(1) << n;
        }
        TEST_ASSERT_EQUAL_INT32(fault_rows[gravest].reason, guard_reason(all));
    }
    TEST_ASSERT_EQUAL_INT32(REASON_MODULE_FAULT, fault_rows[0].reason);
    TEST_ASSERT_EQUAL_INT32(REASON_OVERCURRENT, fault_rows[1].reason);
}

/* The link is low from the first period on, the interrupt late from the fifth, a phase over its limit in the
 * eighth alone. */
static void test_each_row_counts_for_itself(void)
{
    for (uint32_t n = 1; n <= DRIVE_PERIODS(1e-3f) + 5u; n++) {
        scene_t scene = healthy;
        set_u_dc(&scene, 0.0f, 0);
        set_late(&scene, n >= 5u ? 1.0f : 0.0f, 0);
        set_current(&scene, n == 8u ? 1000.0f : 1.0f, 1);
        step(&scene);
        uint32_t expected = n >= DRIVE_PERIODS(1e-3f) ? UINT32_C(1) << FAULT_DC_UNDERVOLTAGE : 0u;
        expected |= n >= 7u ? UINT32_C(1) << FAULT_LATE : 0u;
        expected |= n == 8u ? UINT32_C(1) << FAULT_OVERCURRENT : 0u;
        TEST_ASSERT_EQUAL_HEX32(expected, guard.faults);
    }
}

static void test_all_criteria_of_the_estimate_are_told_apart(void)
{
    scene_t scene = healthy;
    scene.invalid = ESTIMATOR_AMPLITUDE | ESTIMATOR_SPEED;
    step(&scene);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << FAULT_ESTIMATE_AMPLITUDE | UINT32_C(1) << FAULT_ESTIMATE_SPEED,
                            guard.losses);
    TEST_ASSERT_EQUAL_HEX32(0u, guard.faults);
}

static void test_all_failures_of_a_manoeuvre_are_told_apart(void)
{
    scene_t scene = healthy;
    scene.failed = MANOEUVRE_UNLOCKED | MANOEUVRE_LOST;
    step(&scene);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << FAULT_START_UNLOCKED | UINT32_C(1) << FAULT_LOCK_LOST,
                            guard.faults);
    scene.failed = MANOEUVRE_STALLED | MANOEUVRE_TOO_FAST;
    step(&scene);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << FAULT_START_STALLED | UINT32_C(1) << FAULT_ROTOR_TOO_FAST,
                            guard.faults);
    TEST_ASSERT_EQUAL_HEX32(0u, guard.losses);
}

/* ---- new limits ---- */

static void test_new_limits_act_at_once_and_the_counting_goes_on(void)
{
    scene_t scene = healthy;
    scene.measured.u_dc = params.dc_undervoltage - 1.0f;
    const uint32_t half = DRIVE_PERIODS(1e-3f) / 2u;
    for (uint32_t n = 0; n < half; n++) {
        step(&scene);
    }
    params.dc_undervoltage -= 0.5f; /* still above the link */
    params.overcurrent_trip = 0.75f;
    const guard_tuning_t tuning = guard_prepare(&params);
    guard_take(&guard, &tuning);
    for (uint32_t n = half + 1u; n < DRIVE_PERIODS(1e-3f); n++) {
        step(&scene);
        TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << FAULT_OVERCURRENT, guard.faults); /* 1 A */
    }
    step(&scene);
    TEST_ASSERT_EQUAL_HEX32(UINT32_C(1) << FAULT_OVERCURRENT | UINT32_C(1) << FAULT_DC_UNDERVOLTAGE,
                            guard.faults);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_healthy_drive_runs_on);
    RUN_TEST(test_every_row_at_its_limit_is_silent);
    RUN_TEST(test_every_row_beyond_its_limit_shows_after_its_debounce);
    RUN_TEST(test_every_row_counts_anew_after_a_break);
    RUN_TEST(test_every_row_is_silent_until_its_moment);
    RUN_TEST(test_every_row_has_a_reason_of_its_own_that_can_be_read);
    RUN_TEST(test_reactions_are_as_fast_as_the_danger);
    RUN_TEST(test_a_warm_sink_warns_before_it_is_hot);
    RUN_TEST(test_the_gravest_of_several_is_named);
    RUN_TEST(test_each_row_counts_for_itself);
    RUN_TEST(test_all_criteria_of_the_estimate_are_told_apart);
    RUN_TEST(test_all_failures_of_a_manoeuvre_are_told_apart);
    RUN_TEST(test_new_limits_act_at_once_and_the_counting_goes_on);
    return UNITY_END();
}
