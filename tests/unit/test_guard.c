/* Every row of the fault table, from the table: what the guard says is compared period by period with a model
 * that reads the same rows one at a time. */
#include "drive/guard.h"

#include <math.h>
#include <string.h>
#include <unity.h>

#include "drive/guard_quantities.h"
#include "drive/manoeuvres.h"
#include "drive/measure.h"
#include "drive/reasons.h"
#include "estimator/chosen.h"
#include "protect/current_watch.h"
#include "protect/encoder_watch.h"
#include "protect/link.h"
#include "protect/motion_watch.h"

#define ROWS ((uint32_t)FAULTS)

/* All that the guard is told of a period. */
typedef struct {
    measured_t measured;
    float omega_m;
    uint32_t invalid, unlocked, failed, too_fast;
    uint32_t unattended, reported;
    uint32_t encoder_wrong, moves_wrong, encoder_lost;
    uint32_t currents;   /* CURRENT_WATCH_... bits */
    uint32_t heat, link; /* conditions of both */
    uint32_t now;        /* moments that are */
} scene_t;

static uint32_t clock; /* [periods] since setUp */

/* Each moment for itself, as the drive can have them, and all. */
#define EVERY (GUARD_ALWAYS | GUARD_RUNNING | GUARD_ENCODER | GUARD_TRACKING | GUARD_SUPPLIED)

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
    clock = 0u;
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

/* The slow rows are looked at in the last of GUARD_LOOK_PERIODS. Where the guard says that it needs not be
 * called, a call changes nothing: no row is forgotten there. */
static void step(const scene_t *scene)
{
    clock++;
    const guard_input_t input = {
        .measured = &scene->measured,
        .omega_m = scene->omega_m,
        .estimate_invalid = scene->invalid,
        .unlocked = scene->unlocked,
        .failed = scene->failed,
        .too_fast = scene->too_fast,
        .unattended = scene->unattended,
        .reported = scene->reported,
        .encoder_wrong = scene->encoder_wrong,
        .moves_wrong = scene->moves_wrong,
        .encoder_lost = scene->encoder_lost,
        .current_faults = scene->currents,
        .heat = scene->heat,
        .link = scene->link,
        .now = scene->now,
        .look = clock % GUARD_LOOK_PERIODS == 0u ? 1u : 0u,
    };
    const guard_t before = guard;
    const bool calm = guard_is_calm(&guard, &input, FAULT_EACH) &&
                      (input.look == 0u || guard_is_calm(&guard, &input, FAULT_SLOW));
    guard_step(&guard, &input);
    TEST_ASSERT_TRUE(!calm || memcmp(&before, &guard, sizeof guard) == 0);
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

static void expect_rows(uint32_t one, uint32_t other, fault_set_t set)
{
    fault_set_t expected = fault_set_none();
    expected = one < ROWS ? fault_set_both(expected, row_of(one)) : expected;
    expected = other < ROWS ? fault_set_both(expected, row_of(other)) : expected;
    expect_set(expected, set, "rows");
}

static void expect_nothing(void)
{
    expect_set(fault_set_none(), guard.faults, "faults");
    expect_set(fault_set_none(), guard.stops, "stops");
    expect_set(fault_set_none(), guard.losses, "losses");
    expect_set(fault_set_none(), guard.warnings, "warnings");
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
    scene->too_fast = value != 0.0f ? 1u : 0u;
}

static void set_bits(uint32_t *word, uint32_t what, float value)
{
    *word = value != 0.0f ? *word | what : *word & ~what;
}

static void set_program(scene_t *scene, float value, int way)
{
    set_bits(&scene->reported, way == 0 ? GUARD_CORRUPT_PROGRAM : GUARD_CORRUPT_INTERRUPT_CODE, value);
}

static void set_params(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->reported, GUARD_CORRUPT_PARAMS, value);
}

static void set_stack(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->reported, GUARD_CORRUPT_STACK_END, value);
}

static void set_unattended(scene_t *scene, float value, int way)
{
    (void)way;
    scene->unattended = value != 0.0f ? 1u : 0u;
}

static void set_encoder_jump(scene_t *scene, float value, int way)
{
    (void)way;
    scene->encoder_wrong = value != 0.0f ? ENCODER_WATCH_JUMP : 0u;
}

static void set_encoder_direction(scene_t *scene, float value, int way)
{
    (void)way;
    scene->encoder_wrong = value != 0.0f ? ENCODER_WATCH_DIRECTION : 0u;
}

static void set_encoder_mismatch(scene_t *scene, float value, int way)
{
    (void)way;
    scene->encoder_wrong = value != 0.0f ? ENCODER_WATCH_MISMATCH : 0u;
}

static void set_runaway(scene_t *scene, float value, int way)
{
    (void)way;
    scene->moves_wrong = value != 0.0f ? MOTION_RUNAWAY : 0u;
}

static void set_stalled(scene_t *scene, float value, int way)
{
    (void)way;
    scene->moves_wrong = value != 0.0f ? MOTION_STALLED : 0u;
}

static void set_speed_error(scene_t *scene, float value, int way)
{
    (void)way;
    scene->moves_wrong = value != 0.0f ? MOTION_SPEED_ERROR : 0u;
}

static void set_encoder_lost(scene_t *scene, float value, int way)
{
    (void)way;
    scene->encoder_lost = value != 0.0f ? 1u : 0u;
}

static void set_currents(scene_t *scene, uint32_t bit, float value)
{
    scene->currents = value > 0.0f ? scene->currents | bit : scene->currents & ~bit;
}

static void set_current_stuck(scene_t *scene, float value, int way)
{
    (void)way;
    set_currents(scene, CURRENT_WATCH_STUCK, value);
}

static void set_current_gain(scene_t *scene, float value, int way)
{
    (void)way;
    set_currents(scene, CURRENT_WATCH_GAIN, value);
}

static void set_phase_loss(scene_t *scene, float value, int way)
{
    (void)way;
    set_currents(scene, CURRENT_WATCH_LOSS, value);
}

static void set_current_sum(scene_t *scene, float value, int way)
{
    (void)way;
    set_currents(scene, CURRENT_WATCH_SUM, value);
}

static void set_motor_overload(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->heat, THERMAL_MOTOR, value);
}

static void set_module_overload(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->heat, THERMAL_MODULE, value);
}

static void set_derating(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->heat, THERMAL_DERATING, value);
}

static void set_dc_ripple(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->link, LINK_RIPPLES, value);
}

static void set_dc_limits(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->link, LINK_LIMITS, value);
}

static void set_master_silent(scene_t *scene, float value, int way)
{
    (void)way;
    set_bits(&scene->reported, GUARD_MASTER_SILENT, value);
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
    {"program_corrupt", set_program, 2},
    {"params_corrupt", set_params, 1},
    {"stack_low", set_stack, 1},
    {"background_stalled", set_unattended, 1},
    {"encoder_jump", set_encoder_jump, 1},
    {"encoder_direction", set_encoder_direction, 1},
    {"encoder_mismatch", set_encoder_mismatch, 1},
    {"runaway", set_runaway, 1},
    {"stalled", set_stalled, 1},
    {"speed_error", set_speed_error, 1},
    {"encoder_lost", set_encoder_lost, 1},
    {"current_stuck", set_current_stuck, 1},
    {"current_gain", set_current_gain, 1},
    {"phase_loss", set_phase_loss, 1},
    {"current_sum", set_current_sum, 1},
    {"motor_overload", set_motor_overload, 1},
    {"module_overload", set_module_overload, 1},
    {"derating", set_derating, 1},
    {"dc_ripple", set_dc_ripple, 1},
    {"dc_limits", set_dc_limits, 1},
    {"master_silent", set_master_silent, 1},
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

/* For how many periods a row is known to hold, of the `periods` up to now in which it did: a slow one
 * from the first look that has seen it to the last. */
static uint32_t seen(const fault_row_t *row, uint32_t periods)
{
    if (row->rate == FAULT_EACH) {
        return periods;
    }
    const uint32_t looks = clock / GUARD_LOOK_PERIODS - (clock - periods) / GUARD_LOOK_PERIODS;
    return looks == 0u ? 0u : 1u + GUARD_LOOK_PERIODS * (looks - 1u);
}

/* What is shown of a row after its quantity has had this value for so many periods. */
static void expect_after(uint32_t of_row, float value, uint32_t now, uint32_t periods)
{
    fault_set_t sets[4] = {{{0u, 0u}}, {{0u, 0u}}, {{0u, 0u}}, {{0u, 0u}}}; /* by fault_reaction_t */
    for (uint32_t n = 0; n < ROWS; n++) {
        const fault_row_t *row = &fault_rows[n];
        if (strcmp(row->quantity, fault_rows[of_row].quantity) == 0 && holds(n, value) && counts(n, now) &&
            seen(row, periods) >= row->debounce) {
            sets[row->reaction] = fault_set_both(sets[row->reaction], row_of(n));
        }
    }
    expect_set(sets[FAULT_OPEN], guard.faults, fault_rows[of_row].name);
    expect_set(sets[FAULT_STOP], guard.stops, fault_rows[of_row].name);
    expect_set(sets[FAULT_CATCH], guard.losses, fault_rows[of_row].name);
    expect_set(sets[FAULT_WARN], guard.warnings, fault_rows[of_row].name);
}

static bool shown(uint32_t row)
{
    return fault_set_has(guard.failed, (fault_bit_t)row);
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

/* Healthy until nothing of a row is shown or counted any more: until the next look at the latest. */
static void recover(void)
{
    do {
        step(&healthy);
    } while (clock % GUARD_LOOK_PERIODS != 0u);
    expect_nothing();
}

/* ---- every row ---- */

static void test_a_healthy_drive_runs_on(void)
{
    for (int n = 0; n < 3000; n++) {
        step(&healthy);
        expect_nothing();
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
            TEST_ASSERT_TRUE(guard.held[row] < fault_rows[row].debounce); /* and is counted no further */
            if (fault_rows[row].rate == FAULT_EACH) {
                step(&healthy);
                expect_nothing();
            }
            recover();
        }
    }
}

/* [periods] after which a row is shown, whenever the looks are. */
static uint32_t enough(uint32_t row)
{
    return fault_rows[row].debounce + (fault_rows[row].rate == FAULT_SLOW ? 2u * GUARD_LOOK_PERIODS : 0u);
}

static void test_every_row_counts_anew_after_a_break(void)
{
    for (uint32_t row = 0; row < ROWS; row++) {
        setUp();
        for (int n = 0; n < 3; n++) {
            check_periods(row, beyond(row), 0, EVERY, fault_rows[row].debounce - 1u);
            recover();
        }
        check_periods(row, beyond(row), 0, EVERY, enough(row));
        TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
    }
}

/* Of the moments that there can be: with the gates off only lasting dangers count, the encoder's and the
 * estimate's only while control turns with them; what was there before the moment is counted from then.
 */
static void test_every_row_is_silent_until_its_moment(void)
{
    for (uint32_t row = 0; row < ROWS; row++) {
        for (uint32_t moments = 0u; moments <= EVERY; moments++) {
            setUp();
            check_periods(row, beyond(row), 0, moments, fault_rows[row].debounce + 100u);
            TEST_ASSERT_EQUAL_MESSAGE(counts(row, moments), shown(row), fault_rows[row].name);
            if (!counts(row, moments)) {
                const uint32_t its_own = GUARD_MOMENT(fault_rows[row].when);
                check_periods(row, beyond(row), 0, its_own, enough(row));
                TEST_ASSERT_TRUE_MESSAGE(shown(row), fault_rows[row].name);
                if (fault_rows[row].rate == FAULT_EACH) {
                    check_periods(row, beyond(row), 0, moments, 1u); /* and no longer than it is */
                }
            }
        }
    }
}

static void test_every_row_has_a_reason_of_its_own_that_can_be_read(void)
{
    for (uint32_t n = 0; n < ROWS; n++) {
        const int32_t reason = guard_reason(row_of(n));
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
 * What is warm, limits or ripples warns, and an encoder that was left. A rotor that is lost is caught again,
 * and that it was lost too often, or a start failed, is a fault. */
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
        {REASON_DC_UNDERVOLTAGE, 1e-3f, 0u, FAULT_SUPPLIED, FAULT_OPEN},
        {REASON_ENCODER_PHASE, 0.0f, 1u, FAULT_ENCODER, FAULT_OPEN},
        {REASON_SINK_HOT, 0.1f, 0u, FAULT_ALWAYS, FAULT_STOP},
        {REASON_MOTOR_HOT, 0.1f, 0u, FAULT_ALWAYS, FAULT_STOP},
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
        {REASON_PROGRAM_CORRUPT, 0.0f, 1u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_PARAMS_CORRUPT, 0.0f, 1u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_STACK_LOW, 0.0f, 1u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_BACKGROUND_STALLED, 0.0f, 1u, FAULT_RUNNING, FAULT_STOP},
        {REASON_ENCODER_JUMP, 0.0f, 1u, FAULT_ENCODER, FAULT_OPEN},
        {REASON_ENCODER_DIRECTION, 0.0f, 1u, FAULT_ENCODER, FAULT_OPEN},
        {REASON_ENCODER_MISMATCH, 0.0f, 1u, FAULT_ENCODER, FAULT_OPEN},
        {REASON_RUNAWAY, 0.0f, 1u, FAULT_ENCODER, FAULT_OPEN},
        {REASON_STALLED, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_SPEED_ERROR, 0.0f, 1u, FAULT_RUNNING, FAULT_STOP},
        {REASON_ENCODER_LOST, 0.0f, 1u, FAULT_ALWAYS, FAULT_WARN},
        {REASON_CURRENT_STUCK, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_CURRENT_GAIN, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_PHASE_LOSS, 0.0f, 1u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_CURRENT_SUM, 2.4e-3f, 0u, FAULT_RUNNING, FAULT_OPEN},
        {REASON_MOTOR_OVERLOAD, 0.0f, 1u, FAULT_ALWAYS, FAULT_STOP},
        {REASON_MODULE_OVERLOAD, 0.0f, 1u, FAULT_ALWAYS, FAULT_OPEN},
        {REASON_DERATING, 0.0f, 1u, FAULT_ALWAYS, FAULT_WARN},
        {REASON_MOTOR_WARM, 0.1f, 0u, FAULT_ALWAYS, FAULT_WARN},
        {REASON_DC_RIPPLE, 0.0f, 1u, FAULT_RUNNING, FAULT_WARN},
        {REASON_DC_LIMITS, 0.0f, 1u, FAULT_RUNNING, FAULT_WARN},
        {REASON_MASTER_SILENT, 0.0f, 1u, FAULT_ALWAYS, FAULT_WARN},
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

/* Warm is 10 K below hot, warns and stops nothing; hot does both. */
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
        expect_rows(cases[n].warm ? FAULT_SINK_WARM : ROWS, ROWS, guard.warnings);
        expect_rows(cases[n].hot ? FAULT_SINK_HOT : ROWS, ROWS, guard.stops);
    }
}

/* ---- several at once ---- */

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

/* The link is low from the first period on, the interrupt late from the fifth, a phase over its limit in
 * the eighth alone. */
static void test_each_row_counts_for_itself(void)
{
    for (uint32_t n = 1; n <= DRIVE_PERIODS(1e-3f) + 5u; n++) {
        scene_t scene = healthy;
        set_u_dc(&scene, 0.0f, 0);
        set_late(&scene, n >= 5u ? 1.0f : 0.0f, 0);
        set_current(&scene, n == 8u ? 1000.0f : 1.0f, 1);
        step(&scene);
        TEST_ASSERT_EQUAL(n >= DRIVE_PERIODS(1e-3f), fault_set_has(guard.faults, FAULT_DC_UNDERVOLTAGE));
        TEST_ASSERT_EQUAL(n >= 7u, fault_set_has(guard.faults, FAULT_LATE));
        TEST_ASSERT_EQUAL(n == 8u, fault_set_has(guard.faults, FAULT_OVERCURRENT));
    }
}

static void test_all_criteria_of_the_estimate_are_told_apart(void)
{
    scene_t scene = healthy;
    scene.invalid = ESTIMATOR_AMPLITUDE | ESTIMATOR_SPEED;
    step(&scene);
    expect_rows(FAULT_ESTIMATE_AMPLITUDE, FAULT_ESTIMATE_SPEED, guard.losses);
    expect_rows(ROWS, ROWS, guard.faults);
}

static void test_all_failures_of_a_manoeuvre_are_told_apart(void)
{
    scene_t scene = healthy;
    scene.failed = MANOEUVRE_UNLOCKED | MANOEUVRE_LOST;
    step(&scene);
    expect_rows(FAULT_START_UNLOCKED, FAULT_LOCK_LOST, guard.faults);
    scene.failed = MANOEUVRE_STALLED;
    scene.too_fast = 1u;
    step(&scene);
    expect_rows(FAULT_START_STALLED, FAULT_ROTOR_TOO_FAST, guard.faults);
    expect_rows(ROWS, ROWS, guard.losses);
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
        expect_rows(FAULT_OVERCURRENT, ROWS, guard.faults); /* 1 A */
    }
    step(&scene);
    expect_rows(FAULT_OVERCURRENT, FAULT_DC_UNDERVOLTAGE, guard.faults);
}
