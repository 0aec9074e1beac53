/* The fault matrix: its data are consistent, every requirement is judged, and without an injected fault no
 * violation is found. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/matrix.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"
#include "unity.h"

#define CELLS_MAX 4096u
#define RPM       (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */

static matrix_cell_t cells[CELLS_MAX];
static matrix_cell_t again[CELLS_MAX];

void setUp(void)
{
    TEST_ASSERT_TRUE(matrix_size() <= CELLS_MAX);
}

static size_t lay_out(matrix_choice_t choice)
{
    return matrix_lay_out(&choice, cells);
}

static void run(matrix_cell_t *of, size_t count, unsigned threads)
{
    char why[POOL_WHY];
    TEST_ASSERT_TRUE_MESSAGE(matrix_run(of, count, threads, NULL, NULL, why), why);
}

static uint32_t index_of_manoeuvre(const char *name)
{
    for (uint32_t n = 0; n < matrix_manoeuvre_count; n++) {
        if (strcmp(matrix_manoeuvres[n].name, name) == 0) {
            return n;
        }
    }
    TEST_FAIL_MESSAGE(name);
    return 0;
}

/* ---- the data ---- */

/* docs/faults.md states this size. */
static void test_the_document_states_the_size(void)
{
    static char text[65536];
    char told[200];
    size_t occur = 0;
    const size_t count = lay_out((matrix_choice_t){0});
    for (size_t n = 0; n < count; n++) {
        occur += cells[n].occurs ? 1u : 0u;
    }
    snprintf(
        told, sizeof told,
        "%zu faults, %zu manoeuvres, two sources of the angle, two shafts: %zu cells, of which %zu can occur",
        matrix_fault_count, matrix_manoeuvre_count, count, occur);
    FILE *file = fopen(LAGLESS_SCENARIOS "/../../docs/faults.md", "r");
    TEST_ASSERT_NOT_NULL(file);
    text[fread(text, 1u, sizeof text - 1u, file)] = '\0';
    fclose(file);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(text, told), told);
}

static void test_every_cell_has_a_promise_and_every_promise_decides_a_cell(void)
{
    char name[MATRIX_NAME_SIZE];
    const size_t count = lay_out((matrix_choice_t){0});
    TEST_ASSERT_EQUAL_UINT(matrix_size(), count);
    for (size_t n = 0; n < count; n++) {
        TEST_ASSERT_NOT_NULL_MESSAGE(cells[n].promise, matrix_cell_name(name, &cells[n]));
    }
    for (size_t p = 0; p < matrix_promise_count; p++) {
        bool decides = false;
        for (size_t n = 0; n < count; n++) {
            decides = decides || cells[n].promise == &matrix_promises[p];
        }
        char text[120];
        snprintf(text, sizeof text, "promise %zu, of %s: others below it speak of all of its cells", p,
                 matrix_faults[matrix_promises[p].fault].name);
        TEST_ASSERT_TRUE_MESSAGE(decides, text);
    }
}

static void test_names_of_faults_and_manoeuvres_differ_and_have_no_slash(void)
{
    for (size_t a = 0; a < matrix_fault_count; a++) {
        TEST_ASSERT_NULL_MESSAGE(strchr(matrix_faults[a].name, '/'), matrix_faults[a].name);
        for (size_t b = 0; b < a; b++) {
            TEST_ASSERT_TRUE_MESSAGE(strcmp(matrix_faults[a].name, matrix_faults[b].name) != 0,
                                     matrix_faults[a].name);
        }
    }
    for (size_t a = 0; a < matrix_manoeuvre_count; a++) {
        for (size_t b = 0; b < a; b++) {
            TEST_ASSERT_TRUE_MESSAGE(strcmp(matrix_manoeuvres[a].name, matrix_manoeuvres[b].name) != 0,
                                     matrix_manoeuvres[a].name);
        }
    }
}

static void test_what_a_fault_changes_can_be_changed(void)
{
    for (size_t n = 0; n < matrix_fault_count; n++) {
        const matrix_fault_t *fault = &matrix_faults[n];
        for (size_t c = 0; c < MATRIX_CHANGES && fault->changes[c].row != NULL; c++) {
            const table_row_t *row = rig_row_by_name(fault->changes[c].row);
            TEST_ASSERT_NOT_NULL_MESSAGE(row, fault->changes[c].row);
            const double value = fault->changes[c].factor * rig_initial(row) + fault->changes[c].shift;
            TEST_ASSERT_TRUE_MESSAGE(rig_accepts(row, value), fault->name);
            TEST_ASSERT_TRUE_MESSAGE(value != rig_initial(row), fault->name);
        }
    }
}

/* Each name in a list, separated by blanks, is that of a reason. */
static void expect_reasons(const char *names)
{
    for (const char *rest = names; *rest != '\0';) {
        const size_t length = strcspn(rest, " ");
        bool known = false;
        for (uint32_t n = 0; n < reasons_count; n++) {
            known =
                known || (strlen(reasons[n].name) == length && strncmp(reasons[n].name, rest, length) == 0);
        }
        TEST_ASSERT_TRUE_MESSAGE(known, rest);
        rest += length + strspn(rest + length, " ");
    }
}

static void test_required_reasons_exist_and_are_given_where_one_is_needed(void)
{
    for (size_t n = 0; n < matrix_promise_count; n++) {
        const matrix_promise_t *promise = &matrix_promises[n];
        const uint32_t with_reason = MATRIX_WARNS | MATRIX_REFUSES | MATRIX_STOPS | MATRIX_OPENS;
        const char *fault = matrix_faults[promise->fault].name;
        expect_reasons(promise->reasons);
        TEST_ASSERT_TRUE_MESSAGE((promise->reactions & with_reason) == 0u || promise->reasons[0] != '\0',
                                 fault);
        /* A cell that cannot occur, or that allows more than 25 A, needs a physical reason. */
        TEST_ASSERT_TRUE_MESSAGE(
            (promise->reactions != 0u && promise->current <= 25.0) || promise->because[0] != '\0', fault);
    }
}

/* Rows of plant and simulation that are no fault, or that are a listed fault on another leg or track. The
 * campaign tests flipped bits of the drive's state. */
static bool is_no_fault(const char *name)
{
    static const char none[] =
        " fidelity metering sensors interrupt_time medium_time section_time background_time "
        "leg_b_drop leg_c_drop leg_b_delay leg_c_delay leg_b_resistance leg_c_resistance "
        "leg_a_delay encoder_stuck_b dc_ripple_frequency "
        "load_inertia shaft_stiffness shaft_damping current_zero current_gain_error_c "
        "current_offset_c friction_breakaway flip_bit flip_word load_quadratic load_sine "
        "load_sine_cycles load_spring load_table_speed load_table_1 load_table_2 load_table_3 "
        "load_table_4 load_table_5 load_table_6 saturation_d saturation_q flux_map iron_loss_resistance "
        "chopper_driven holding_release_time holding_apply_time ";
    char word[64];
    snprintf(word, sizeof word, " %s ", name);
    return strstr(none, word) != NULL;
}

static bool is_injected(const table_row_t *row)
{
    for (size_t n = 0; n < matrix_fault_count; n++) {
        for (size_t c = 0; c < MATRIX_CHANGES && matrix_faults[n].changes[c].row != NULL; c++) {
            if (rig_row_by_name(matrix_faults[n].changes[c].row) == row) {
                return true;
            }
        }
    }
    return false;
}

/* All rows of the plant from open_phase_a on, where the faults begin, and all of the simulation. */
static void test_every_fault_that_can_be_injected_is_in_the_matrix_or_listed_as_none(void)
{
    const uint32_t breaks = rig_row_by_name("open_phase_a")->id;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        const bool of_rig = table_by_name(table, "stuck_current_a") != NULL;
        const bool of_plant = table_by_name(table, "open_phase_a") != NULL;
        for (uint32_t n = 0; n < table->count && (of_rig || of_plant); n++) {
            const table_row_t *row = &table->rows[n];
            if ((of_rig || row->id >= breaks) && !is_no_fault(row->name)) {
                TEST_ASSERT_TRUE_MESSAGE(is_injected(row), row->name);
            }
        }
    }
}

/* ---- choice of the cells ---- */

static void test_a_cell_is_chosen_by_its_name_or_the_beginning_of_it(void)
{
    TEST_ASSERT_EQUAL_UINT(1u, lay_out((matrix_choice_t){.cell = "stuck_a_zero/run_fast/sensorless/l"}));
    TEST_ASSERT_EQUAL_UINT(4u, lay_out((matrix_choice_t){.cell = "stuck_a_zero/run_fast"}));
    TEST_ASSERT_EQUAL_UINT(4u, lay_out((matrix_choice_t){.cell = "stuck_a_zero/run_fast/"}));
    TEST_ASSERT_EQUAL_UINT(4u * matrix_manoeuvre_count, lay_out((matrix_choice_t){.cell = "stuck_a_zero"}));
    TEST_ASSERT_EQUAL_UINT(0u, lay_out((matrix_choice_t){.cell = "stuck_a"}));
    TEST_ASSERT_EQUAL_UINT(4u * matrix_manoeuvre_count, lay_out((matrix_choice_t){.only = "jam"}));
}

static void test_a_share_is_drawn_by_its_seed_from_the_cells_that_occur(void)
{
    size_t occur = 0;
    const size_t all = lay_out((matrix_choice_t){0});
    for (size_t n = 0; n < all; n++) {
        occur += cells[n].occurs ? 1u : 0u;
    }
    const size_t first = lay_out((matrix_choice_t){.share = 0.1, .seed = 20261122u});
    for (size_t n = 0; n < first; n++) {
        TEST_ASSERT_TRUE(cells[n].occurs);
    }
    /* A tenth of the cells, within five standard deviations of a binomial distribution. */
    const double spread = 5.0 * sqrt(0.09 * (double)occur);
    TEST_ASSERT_DOUBLE_WITHIN(spread, 0.1 * (double)occur, (double)first);
    matrix_choice_t same = {.share = 0.1, .seed = 20261122u};
    TEST_ASSERT_EQUAL_UINT(first, matrix_lay_out(&same, again));
    TEST_ASSERT_EQUAL_MEMORY(cells, again, first * sizeof cells[0]);

    same.seed++;
    const size_t second = matrix_lay_out(&same, again);
    size_t both = 0;
    for (size_t a = 0; a < first; a++) {
        for (size_t b = 0; b < second; b++) {
            both += cells[a].fault == again[b].fault && cells[a].manoeuvre == again[b].manoeuvre &&
                    cells[a].place == again[b].place;
        }
    }
    TEST_ASSERT_TRUE(both < first / 3u);
}

/* ---- judgement ---- */

static void test_a_fault_is_noticed_in_20_ms_or_a_third_of_a_turn(void)
{
    const double e = 4.0 * RPM; /* electrical speed per r/min */
    /* a third of a turn takes 4.2 ms. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 20e-3, matrix_noticed(1200.0 * e, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.0 / 30.0, matrix_noticed(-150.0 * e, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.25, matrix_noticed(20.0 * e, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.0, matrix_noticed(0.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.0 / 12.0, matrix_noticed(150.0 * e, 0.5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 20e-3 + 6.25e-3, matrix_noticed(1200.0 * e, 0.5));
}

static const matrix_promise_t promise = {.reactions = MATRIX_OPENS,
                                         .reasons = "overcurrent bad_sample",
                                         .within = 10e-3,
                                         .current = 25.0,
                                         .rotor = MATRIX_COASTS | MATRIX_STANDS,
                                         .because = ""};

/* Returns a cell whose result agrees with the promised reaction above. */
static matrix_cell_t kept(void)
{
    return (matrix_cell_t){.promise = &promise,
                           .occurs = true,
                           .seen = {.reaction = MATRIX_OPENS,
                                    .reason = REASON_BAD_SAMPLE,
                                    .noticed = 9e-3,
                                    .gates_off = 9e-3,
                                    .current = 24.0,
                                    .rotor = MATRIX_COASTS,
                                    .started = 100.0,
                                    .reference = 100.0,
                                    .fastest = 101.0}};
}

static uint32_t red(matrix_cell_t cell)
{
    matrix_judge(&cell);
    return cell.red;
}

static void test_a_kept_promise_is_green_and_each_broken_part_is_reported(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, red(kept()));
    matrix_cell_t cell = kept();
    cell.seen.reaction = MATRIX_RIDES;
    TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_REACTION, red(cell));
    cell = kept();
    cell.seen.reason = REASON_OVERSPEED;
    TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_REASON, red(cell));
    cell = kept();
    cell.seen.rotor = MATRIX_STRAYS;
    TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_ROTOR, red(cell));
    static const double too_much[][2] = {{11e-3, 25.1}, {(double)NAN, (double)NAN}}; /* [s], [A] */
    for (size_t n = 0; n < 2u; n++) {
        cell = kept();
        cell.seen.noticed = too_much[n][0];
        TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_TIME, red(cell));
        cell = kept();
        cell.seen.current = too_much[n][1];
        TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_CURRENT, red(cell));
    }
}

static void test_a_warning_of_something_else_is_a_wrong_reason(void)
{
    const matrix_promise_t warns = {.reactions = MATRIX_WARNS,
                                    .reasons = "sink_warm",
                                    .within = (double)NAN,
                                    .current = 25.0,
                                    .rotor = MATRIX_FOLLOWS};
    matrix_cell_t cell = kept();
    cell.promise = &warns;
    cell.seen.reaction = MATRIX_WARNS;
    cell.seen.reason = 0;
    cell.seen.rotor = MATRIX_FOLLOWS;
    cell.seen.warnings = UINT64_C(1) << FAULT_SINK_WARM;
    TEST_ASSERT_EQUAL_UINT32(0u, red(cell));
    cell.seen.warnings |= UINT64_C(1) << FAULT_LATE;
    TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_REASON, red(cell));
}

static void test_a_rotor_that_is_driven_away_is_red_wherever_it_ends(void)
{
    matrix_cell_t cell = kept();
    cell.seen.fastest = 1.2 * 100.0 + 100.0 * RPM + 0.1;
    TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_ROTOR, red(cell));
    cell.seen.fastest -= 0.2;
    TEST_ASSERT_EQUAL_UINT32(0u, red(cell));
    cell.place = 1u; /* place 1 is the bare rotor */
    cell.seen.fastest += 300.0 * RPM;
    TEST_ASSERT_EQUAL_UINT32(0u, red(cell));
    cell.seen.fastest += 0.2;
    TEST_ASSERT_EQUAL_UINT32(MATRIX_BY_ROTOR, red(cell));
}

static void test_reasons_are_whole_names(void)
{
    TEST_ASSERT_TRUE(matrix_accepts("late overcurrent", REASON_OVERCURRENT));
    TEST_ASSERT_TRUE(matrix_accepts("late  overcurrent ", REASON_LATE));
    TEST_ASSERT_FALSE(matrix_accepts("overcurren", REASON_OVERCURRENT));
    TEST_ASSERT_FALSE(matrix_accepts("not_overcurrent", REASON_OVERCURRENT));
    TEST_ASSERT_FALSE(matrix_accepts("", REASON_OVERCURRENT));
}

static void test_what_is_not_yet_kept_names_cells_that_occur_each_once_with_its_reason(void)
{
    for (const matrix_not_yet_t *row = matrix_not_yet; row->cell != NULL; row++) {
        TEST_ASSERT_EQUAL_UINT_MESSAGE(1u, lay_out((matrix_choice_t){.cell = row->cell}), row->cell);
        TEST_ASSERT_TRUE_MESSAGE(cells[0].occurs, row->cell);
        TEST_ASSERT_EQUAL_PTR_MESSAGE(row->because, cells[0].not_yet, row->cell);
        TEST_ASSERT_TRUE_MESSAGE(strlen(row->because) > 20u, row->cell);
    }
    lay_out((matrix_choice_t){.cell = "none/run_fast/encoder/h"});
    TEST_ASSERT_NULL(cells[0].not_yet);
}

static void test_a_result_that_is_not_the_listed_one_is_reported_both_ways(void)
{
    matrix_cell_t cell = kept();
    TEST_ASSERT_FALSE(matrix_surprises(&cell));
    cell.red = MATRIX_BY_TIME;
    TEST_ASSERT_TRUE(matrix_surprises(&cell));
    cell.not_yet = "known";
    TEST_ASSERT_FALSE(matrix_surprises(&cell));
    cell.red = 0u;
    TEST_ASSERT_TRUE(matrix_surprises(&cell));
    cell.occurs = false;
    TEST_ASSERT_FALSE(matrix_surprises(&cell));
}

/* ---- runs ---- */

/* A sensor at its limit is reported as long as the drive can stop: in every cell the bridge opens at once,
 * as promised. The table has the speed of the rotor in each manoeuvre when the fault occurs [r/min]. */
static void test_a_sensor_at_its_rail_is_green_in_every_manoeuvre_and_comes_in_it(void)
{
    static const struct {
        const char *manoeuvre;
        double least, most;
    } expected[] = {
        {"off", -1.0, 1.0},        {"align", -60.0, 60.0},     {"ramp", 0.0, 150.0},
        {"handover", 50.0, 250.0}, {"run_slow", 142.0, 158.0}, {"run_fast", 1190.0, 1210.0},
        {"forced", 5.0, 35.0},     {"reversal", -10.0, 29.0},  {"braking", 1190.0, 1200.0},
        {"catch", 560.0, 610.0},
    };
    const size_t count = lay_out((matrix_choice_t){.only = "stuck_a_rail"});
    run(cells, count, 2u);
    for (size_t n = 0; n < count; n++) {
        const double rpm = cells[n].seen.started / RPM;
        char name[MATRIX_NAME_SIZE];
        char text[160];
        snprintf(text, sizeof text, "%s: %.1f r/min", matrix_cell_name(name, &cells[n]), rpm);
        if (!cells[n].occurs) {
            continue;
        }
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, cells[n].red, text);
        TEST_ASSERT_EQUAL_UINT32(MATRIX_OPENS, cells[n].seen.reaction);
        TEST_ASSERT_TRUE(cells[n].seen.gates_off <= 1e-3);
        for (size_t e = 0; e < sizeof expected / sizeof expected[0]; e++) {
            TEST_ASSERT_TRUE_MESSAGE(cells[n].manoeuvre != index_of_manoeuvre(expected[e].manoeuvre) ||
                                         (rpm >= expected[e].least && rpm <= expected[e].most),
                                     text);
        }
    }
}

/* The allowed time consists of the debounce time of the input, 50 ms of braking, and the windows of the
 * medium task. */
static void test_a_lost_enable_input_opens_the_bridge_in_its_time_in_every_manoeuvre(void)
{
    const double most = (double)BOARD_ENABLE_DEBOUNCE_US * 1e-6 + 50e-3 + 4e-3;
    const size_t count = lay_out((matrix_choice_t){.only = "enable_lost"});
    run(cells, count, 2u);
    for (size_t n = 0; n < count; n++) {
        char name[MATRIX_NAME_SIZE];
        if (cells[n].occurs) {
            matrix_cell_name(name, &cells[n]);
            TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, cells[n].red, name);
            TEST_ASSERT_TRUE_MESSAGE(cells[n].seen.gates_off <= most, name);
        }
    }
}
