/* The C interface of the simulation: tables, staged parameters, refusals as data and as text. */
#include "settings/reasons.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

void setUp(void)
{
    rig = run_rig(1);
}

static void expect_refusal(const char *name, int32_t reason, const char *range)
{
    TEST_ASSERT_EQUAL_INT32(reason, rig_error_reason(rig));
    TEST_ASSERT_EQUAL_UINT32(rig_row_by_name(name)->id, rig_error_id(rig));
    TEST_ASSERT_NOT_NULL_MESSAGE(
        strstr(rig_error(rig), strchr(name, '.') != NULL ? strchr(name, '.') + 1 : name), rig_error(rig));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(rig_error(rig), range), rig_error(rig));
}

static void test_ids_are_unique_over_all_tables_and_every_row_can_be_read(void)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count; n++) {
            double value = (double)NAN;
            TEST_ASSERT_EQUAL_PTR_MESSAGE(&table->rows[n], rig_row(table->rows[n].id), table->rows[n].name);
            TEST_ASSERT_TRUE(rig_get(rig, table->rows[n].id, &value));
            TEST_ASSERT_TRUE_MESSAGE(isfinite(value), table->rows[n].name);
        }
    }
    TEST_ASSERT_NULL(rig_table(rig_table_count()));
    TEST_ASSERT_NULL(rig_row(99999));
}

/* The ids of the plant are numbered in the order of its table. Recordings and scenarios depend on them;
 * two of them are tested. */
static void test_ids_of_the_plant_stay(void)
{
    TEST_ASSERT_EQUAL_UINT32(4000, rig_row_by_name("pole_pairs")->id);
    TEST_ASSERT_EQUAL_UINT32(4007, rig_row_by_name("inertia")->id);
}

static void test_a_name_in_two_tables_is_distinguished_by_its_table(void)
{
    TEST_ASSERT_EQUAL_UINT32(23, rig_row_by_name("params.encoder_lines")->id);
    TEST_ASSERT_TRUE(rig_row_by_name("plant.encoder_lines")->id >= 4000);
    TEST_ASSERT_NULL(rig_row_by_name("plant.enable"));
    TEST_ASSERT_NULL(rig_row_by_name("nothing.enable"));
    TEST_ASSERT_NULL(rig_row_by_name("no_such_row"));
}

static void test_a_set_that_breaks_a_cross_rule_is_refused_and_the_old_one_runs_on(void)
{
    char range[120];
    const double limit = BOARD_CURRENT_LIMIT_MA / 1e3;
    const double trip = rig_value(rig, "overcurrent_trip");
    run_to_ready(rig);
    run_on(rig, 200.0);
    run_seconds(rig, 0.5);
    run_put(rig, "speed_ki", 3.0);
    run_put(rig, "overcurrent_trip", 1.1 * limit);
    TEST_ASSERT_FALSE(rig_apply(rig));
    snprintf(range, sizeof range, "accepted: %.7g to %.7g A (overcurrent_trip >= 1.2 current_limit)",
             (double)(1.2f * (float)limit), (double)(0.95f * BOARD_CURRENT_RANGE));
    expect_refusal("overcurrent_trip", REASON_CROSS_RULE, range);
    TEST_ASSERT_EQUAL_DOUBLE(trip, rig_value(rig, "overcurrent_trip"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0,
                             rig_value(rig, "speed_ki")); /* either the whole set is accepted or none of it */
    run_seconds(rig, 0.1);
    run_expect_no_fault(rig);
    run_put(rig, "current_limit", 0.9 * limit); /* both are corrected in one set */
    TEST_ASSERT_TRUE(rig_apply(rig));
    TEST_ASSERT_EQUAL_DOUBLE((double)(float)(1.1 * limit), rig_value(rig, "overcurrent_trip"));
    TEST_ASSERT_EQUAL_DOUBLE(3.0, rig_value(rig, "speed_ki"));
}

/* A value that a float would round to a whole number is not accepted as a whole number. A number that a
 * float cannot represent is reported as it was written. */
static void test_numbers_that_are_none_or_not_whole_are_refused(void)
{
    const double none[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e300};
    for (size_t n = 0; n < 4; n++) {
        TEST_ASSERT_FALSE(rig_put(rig, "speed_request", none[n]));
        expect_refusal("speed_request", REASON_OUT_OF_RANGE, "accepted");
        TEST_ASSERT_FALSE(rig_put(rig, "inertia", none[n]));
    }
    TEST_ASSERT_FALSE(rig_put(rig, "params.encoder_lines", 16384.0001));
    expect_refusal("params.encoder_lines", REASON_OUT_OF_RANGE, "whole numbers 16 to 16384");
    TEST_ASSERT_FALSE(rig_put(rig, "enable", 1.00000001));
    /* In 32 bits this would be 512. */
    TEST_ASSERT_FALSE(rig_put(rig, "calibration_periods", 4294967296.0 + 512.0));
}

typedef struct {
    char text[2][32]; /* the ends of the range as they are printed */
} told_t;

/* The range in the text of the last refusal. */
static told_t told_range(void)
{
    told_t told;
    const char *from = strstr(rig_error(rig), "accepted: ");
    TEST_ASSERT_NOT_NULL_MESSAGE(from, rig_error(rig));
    from += strlen("accepted: ");
    from += strncmp(from, "whole numbers ", 14) == 0 ? 14 : 0;
    TEST_ASSERT_EQUAL_INT_MESSAGE(2, sscanf(from, "%31s to %31s", told.text[0], told.text[1]),
                                  rig_error(rig));
    return told;
}

/* The number with its last digit larger (or smaller) by one, or by two if a float cannot represent that. */
static double one_digit_on(const char *text, double direction)
{
    char step[40];
    const size_t mantissa = strcspn(text, "e");
    size_t last = 0;
    for (size_t n = 0; n < mantissa; n++) {
        step[n] = text[n];
        if (text[n] >= '0' && text[n] <= '9') {
            step[n] = '0';
            last = n;
        }
    }
    step[last] = '1';
    step[mantissa] = '\0';
    strncat(step, text + mantissa, 8);
    const double written = strtod(text, NULL);
    const double digit = fabs(strtod(step, NULL));
    const double next = written + direction * digit;
    return (float)next != (float)written ? next : next + direction * digit;
}

/* Every settable row of every table is set to a value beyond each end of its range. The reported ends, as
 * they are printed, are accepted; a value beyond them by one in the last digit is not. */
static void test_reported_limits_of_every_row_are_accepted_as_they_are_written(void)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count; n++) {
            const table_row_t *row = &table->rows[n];
            for (int end = 0; end < 2 && row->access != TABLE_READ; end++) {
                const double given = end == 0 ? -3e38 : 3e38;
                TEST_ASSERT_FALSE_MESSAGE(rig_set(rig, row->id, given), row->name);
                const told_t told = told_range();
                for (int m = 0; m < 2; m++) {
                    TEST_ASSERT_TRUE_MESSAGE(rig_set(rig, row->id, strtod(told.text[m], NULL)) ||
                                                 rig_error_reason(rig) == REASON_CROSS_RULE,
                                             rig_error(rig));
                    TEST_ASSERT_FALSE_MESSAGE(
                        rig_set(rig, row->id, one_digit_on(told.text[m], m == 0 ? -1.0 : 1.0)), row->name);
                    TEST_ASSERT_EQUAL_INT32_MESSAGE(REASON_OUT_OF_RANGE, rig_error_reason(rig), row->name);
                }
            }
        }
    }
}

/* Rules between rows report limits, too, which are tested in the same way. */
static void test_reported_limits_of_rules_are_accepted_as_they_are_written(void)
{
    static const struct {
        const char *row;
        double value;
    } wrong[] = {
        {"overspeed_trip", 1300.0},    {"overspeed_trip", 2.0},       {"observer_gain", 100.1},
        {"observer_gain", 333.3},      {"motor_resistance", 70.0},    {"feedforward_cutoff", 199.0},
        {"observer_emf_cutoff", 50.0}, {"estimate_speed_min", 221.7}, {"turn_off_delay", 4.9e-6},
        {"overcurrent_trip", 3.3},
    };
    for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
        rig_free(rig);
        rig = run_rig(1);
        const uint32_t id = rig_row_by_name(wrong[n].row)->id;
        run_puts(rig, "observer_gain=200 observer_slope=1");
        run_put(rig, wrong[n].row, wrong[n].value);
        TEST_ASSERT_FALSE_MESSAGE(rig_apply(rig), wrong[n].row);
        if (rig_error_id(rig) != id) {
            continue; /* this rule is reported with the other row */
        }
        const told_t told = told_range();
        for (int end = 0; end < 2; end++) {
            run_put(rig, wrong[n].row, strtod(told.text[end], NULL));
            TEST_ASSERT_TRUE_MESSAGE(rig_apply(rig), rig_error(rig));
            const bool staged = rig_set(rig, id, one_digit_on(told.text[end], end == 0 ? -1.0 : 1.0));
            TEST_ASSERT_FALSE_MESSAGE(staged && rig_apply(rig), wrong[n].row);
        }
    }
}

static void test_a_row_without_room_is_reported_with_the_one_to_change(void)
{
    run_puts(rig, "observer_gain=200 observer_slope=1 field_weakening=0 overspeed_trip=500");
    TEST_ASSERT_FALSE(rig_apply(rig));
    expect_refusal("observer_gain", REASON_CROSS_RULE, "accepted: none (observer_gain >= 1.1 times");
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(rig_error(rig), "; change observer_slope, advised 0.4372"),
                                 rig_error(rig));
    double number = 0.0;
    TEST_ASSERT_FALSE(rig_error_range(rig, &number, &number, &number));
}

static void test_what_is_shown_is_not_set(void)
{
    TEST_ASSERT_FALSE(rig_put(rig, "i_d", 1.0));
    expect_refusal("i_d", REASON_READ_ONLY, "can be read, not set");
    TEST_ASSERT_FALSE(rig_put(rig, "true_torque", 1.0));
    TEST_ASSERT_FALSE(rig_set(rig, 77777, 1.0));
    TEST_ASSERT_EQUAL_INT32(REASON_UNKNOWN_ID, rig_error_reason(rig));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "77777"));
    double value;
    TEST_ASSERT_FALSE(rig_get(rig, 77777, &value));
    TEST_ASSERT_FALSE(rig_put(rig, "tourqe", 1.0));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "tourqe"));
}

static void test_plant_rules_are_judged_too(void)
{
    TEST_ASSERT_FALSE(rig_put(rig, "load_torque", -3.0)); /* a passive load does not drive */
    expect_refusal("load_torque", REASON_CROSS_RULE, "load_torque = -3");
    run_puts(rig, "load_kind=1 load_torque=-3");
    TEST_ASSERT_EQUAL_DOUBLE(-3.0, rig_value(rig, "load_torque"));
}

/* Repeats the steps on a copy of the estimator: theta_hat of the last period must agree bit for bit. The
 * run has no uncertain voltages, which the drive does not pass to estimator_step. The adaptation of psi_f
 * is far from its end, so that the start of the copy matters. */
static void test_the_estimator_replayed_ends_where_the_drive_is(void)
{
    void *record = malloc(rig_estimator_size());
    TEST_ASSERT_NOT_NULL(record);
    run_paper_drive(rig);
    run_puts(rig, "motor_flux_linkage=0.15 flux_adaptation=0.2");
    run_parameter(rig, "doubtful_current", 0.0);
    run_to_ready_at(rig, 1000.0);
    run_on(rig, 1000.0);
    run_seconds(rig, 0.1);
    rig_estimator_record(rig, record);
    run_expect_no_fault(rig);
    TEST_ASSERT_EQUAL_DOUBLE(rig_value(rig, "theta_hat"), (double)rig_estimator_replay(record, false));
    TEST_ASSERT_EQUAL_DOUBLE(rig_value(rig, "theta_hat"), (double)rig_estimator_replay(record, false));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, (double)rig_estimator_replay(record, true));
    free(record);
}
