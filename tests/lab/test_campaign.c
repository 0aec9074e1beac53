/* The campaign: what it draws, what it judges, and that neither cores nor shards change it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drive/drive.h"
#include "fast/measure.h"
#include "host_sim/lab/campaign_parts.h"
#include "medium/manoeuvre/manoeuvres.h"
#include "medium/sequence.h"
#include "settings/signals.h"
#include "tests/lab/watched.h"
#include "unity.h"

/* ---- what is drawn ---- */

static void test_random_numbers_fill_16_bins_evenly_along_draws_runs_and_seeds(void)
{
    enum { BINS = 16, DRAWS = 16000 };
    for (uint32_t along = 0; along < 3u; along++) {
        uint32_t bins[BINS] = {0};
        for (uint32_t n = 0; n < DRAWS; n++) {
            const double u =
                campaign_random(along == 2u ? n : 7u, along == 1u ? n : 3u, along == 0u ? n : 5u);
            TEST_ASSERT_TRUE(u >= 0.0 && u < 1.0);
            bins[(uint32_t)(u * BINS)]++;
        }
        /* chi^2 of 15 degrees of freedom: above 44.3 once in 10000 */
        double chi_square = 0.0;
        for (uint32_t n = 0; n < BINS; n++) {
            chi_square += pow(bins[n] - (double)DRAWS / BINS, 2.0) / ((double)DRAWS / BINS);
        }
        TEST_ASSERT_TRUE(chi_square < 44.3);
    }
}

#define DRAWN 2000u
#define MANY  12000u /* a quantity that is drawn in an eighth of the runs is in 1500 of them */

static void test_every_quantity_reaches_over_its_range_and_not_beyond(void)
{
    for (uint32_t n = 0; n < CAMPAIGN_QUANTITY_COUNT; n++) {
        const campaign_quantity_row_t *row = &campaign_quantities[n];
        const double span = row->law == CAMPAIGN_LOG ? log(row->most / row->least) : row->most - row->least;
        double lowest = 1.0;
        double highest = 0.0;
        for (uint32_t run = 0; run < MANY; run++) {
            campaign_case_t drawn;
            campaign_draw(11u, run, 2.0, &drawn);
            const double x = drawn.quantities[n];
            if ((row->law == CAMPAIGN_HALF || row->law == CAMPAIGN_FEW) && x == row->initial) {
                continue;
            }
            TEST_ASSERT_TRUE_MESSAGE(x >= row->least && x <= row->most, row->name);
            const double share = span == 0.0                ? 0.5
                                 : row->law == CAMPAIGN_LOG ? log(x / row->least) / span
                                                            : (x - row->least) / span;
            lowest = fmin(lowest, share);
            highest = fmax(highest, share);
        }
        /* of 1000 at least, none in the last hundredth: e^-10 */
        TEST_ASSERT_TRUE_MESSAGE(span == 0.0 || (lowest < 0.01 && highest > 0.99), row->name);
    }
}

static void test_half_of_the_runs_have_one_fault_and_every_fault_comes(void)
{
    uint32_t seen[256] = {0};
    uint32_t injected = 0;
    for (uint32_t run = 0; run < DRAWN; run++) {
        campaign_case_t drawn;
        campaign_draw(12u, run, 2.0, &drawn);
        seen[drawn.faults[0].kind]++;
        injected += drawn.faults[0].kind != 0u;
        for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
            const campaign_injected_t *fault = &drawn.faults[n];
            TEST_ASSERT_TRUE(fault->kind == 0u || (fault->time >= 0.0 && fault->time < 2.0));
            TEST_ASSERT_TRUE(fault->lasts == 0.0 || (fault->lasts >= 0.01 && fault->lasts <= 0.3));
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(5.0 * sqrt(0.25 * DRAWN), 0.5 * DRAWN, injected); /* 5 sigma */
    for (uint32_t n = 1; n < campaign_fault_count; n++) {
        TEST_ASSERT_GREATER_THAN_UINT32_MESSAGE(0u, seen[n], campaign_faults[n].name);
        TEST_ASSERT_NOT_NULL_MESSAGE(rig_row_by_name(campaign_faults[n].row), campaign_faults[n].row);
        TEST_ASSERT_EQUAL_MESSAGE(campaign_faults[n].excused != 0u, campaign_faults[n].because[0] != '\0',
                                  campaign_faults[n].name);
    }
}

static void test_every_motor_can_be_driven_by_the_board(void)
{
    for (uint32_t run = 0; run < DRAWN; run++) {
        campaign_case_t drawn;
        campaign_draw(13u, run, 2.0, &drawn);
        const campaign_motor_t m = campaign_motor(&drawn);
        const double omega_e = m.pole_pairs * m.speed;
        const double emf = omega_e * m.flux_linkage;
        const double along = emf + m.resistance * m.current;
        const double across = omega_e * m.inductance_q * m.current;
        const double link = CAMPAIGN_VALUE(&drawn, dc_voltage);
        TEST_ASSERT_TRUE(m.current >= 0.5 && m.current <= 10.0);
        TEST_ASSERT_TRUE(m.speed >= 60.0 && m.speed <= 1000.0);
        TEST_ASSERT_TRUE(omega_e <= 2000.0 * 1.000001);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9 * m.torque, 1.5 * m.pole_pairs * m.flux_linkage * m.current, m.torque);
        TEST_ASSERT_TRUE(emf < link / sqrt(3.0));
        /* at half of rated speed with rated current there is voltage left */
        TEST_ASSERT_TRUE(hypot(along - 0.5 * emf, 0.5 * across) < link / sqrt(3.0));
        /* ripple of both voltage's extremes, peak to peak */
        TEST_ASSERT_TRUE(link * RIG_PERIOD_SECONDS / (6.0 * m.inductance_d) <= 0.3 * m.current * 1.000001);
    }
}

/* The share that is refused stays below a hundredth, and each is told by a row and with a reason. */
static void test_what_is_drawn_is_accepted(void)
{
    uint32_t refused = 0;
    for (uint32_t run = 0; run < DRAWN; run++) {
        char text[CAMPAIGN_TEXT_SIZE];
        campaign_case_t drawn;
        scenario_error_t error;
        campaign_draw(14u, run, 2.0, &drawn);
        const size_t octets = campaign_text(&drawn, NULL, text, sizeof text);
        TEST_ASSERT_TRUE(octets > 0u);
        scenario_t *scenario = scenario_read_text("drawn", text, octets, &error);
        if (scenario == NULL) {
            refused++;
            TEST_ASSERT_NOT_NULL_MESSAGE(rig_row_by_name(error.name), error.message);
        }
        scenario_free(scenario);
    }
    TEST_ASSERT_LESS_THAN_UINT32(DRAWN / 100u, refused);
}

static void test_a_case_of_defaults_sets_nothing_but_the_friction(void)
{
    char text[CAMPAIGN_TEXT_SIZE];
    scenario_error_t error;
    campaign_case_t plain = {.seconds = 0.1};
    for (uint32_t n = 0; n < CAMPAIGN_QUANTITY_COUNT; n++) {
        plain.quantities[n] = campaign_quantities[n].initial;
    }
    const size_t octets = campaign_text(&plain, NULL, text, sizeof text);
    scenario_t *scenario = scenario_read_text("plain", text, octets, &error);
    TEST_ASSERT_NOT_NULL(scenario);
    for (uint32_t n = 0; n < scenario->events[0].count; n++) {
        TEST_ASSERT_EQUAL_STRING("friction_coulomb", scenario->events[0].settings[n].row->name);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, scenario->event_count);
    scenario_free(scenario);
}

/* ---- what is judged ---- */

/* A healthy drive of the default motor, trip 15 A, that runs. */
static void judge_anew(uint32_t fault)
{
    observed = (campaign_case_t){.faults = {{.kind = fault}}};
    watch_a_drive_that_runs();
    put("true_u_dc", 311.0f);
    campaign_watch_edge(&watch, 0u, (uint32_t)RIG_EDGE_GATES, 0x15u);
}

/* So many periods of what the slots show. */
static void pass(uint32_t periods)
{
    for (uint32_t n = 0; n < periods; n++) {
        campaign_watch_sample(&watch, now++, slots, count);
    }
}

static void expect_held(void)
{
    TEST_ASSERT_NOT_EQUAL(CAMPAIGN_VIOLATED, result.end);
    TEST_ASSERT_EQUAL(0, watch.stop);
}

static void expect_violated(campaign_invariant_t invariant, const char *row)
{
    TEST_ASSERT_EQUAL(CAMPAIGN_VIOLATED, result.end);
    TEST_ASSERT_EQUAL(invariant, result.invariant);
    TEST_ASSERT_EQUAL_UINT32(rig_row_by_name(row)->id, result.row);
    TEST_ASSERT_NOT_EQUAL(0, watch.stop);
}

static uint32_t fault_of(const char *name)
{
    for (uint32_t n = 0; n < campaign_fault_count; n++) {
        if (strcmp(campaign_faults[n].name, name) == 0) {
            return n;
        }
    }
    TEST_FAIL_MESSAGE(name);
    return 0u;
}

static void test_every_float_among_the_signals_is_watched(void)
{
    judge_anew(0u);
    for (uint32_t n = 0; n < signals_table.count; n++) {
        if (signals_table.rows[n].kind == SLOT_FLOAT) {
            TEST_ASSERT_TRUE(slot(signals_table.rows[n].name) < &slots[floats]);
        }
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(RIG_TAP_MAX, count);
}

static void test_every_float_that_is_no_number_or_infinite_is_a_violation(void)
{
    static const float bad[] = {(float)NAN, (float)INFINITY, -(float)INFINITY};
    judge_anew(0u);
    const uint32_t all = floats;
    for (uint32_t n = 0; n < all; n++) {
        judge_anew(0u);
        const uint32_t finite = 0x7f7fffffu; /* the largest number */
        slots[n] = n < all - CAMPAIGN_FLOATS_JUDGED ? finite : 0u;
        pass(1u);
        expect_held();
        memcpy(&slots[n], &bad[n % 3u], sizeof bad[0]);
        pass(1u);
        TEST_ASSERT_EQUAL(CAMPAIGN_I_NUMBER, result.invariant);
        TEST_ASSERT_EQUAL_UINT32(ids[n], result.row);
        TEST_ASSERT_EQUAL_UINT32(1u, result.period);
    }
}

static void test_current_beyond_1_2_times_the_trip_may_last_two_samples(void)
{
    static const char *const names[] = {"true_i_a", "true_i_b", "true_i_c"};
    const double limit = 1.2 * rig_initial(rig_row_by_name("overcurrent_trip"));
    for (uint32_t phase = 0; phase < 3u; phase++) {
        judge_anew(0u);
        put(names[phase], (float)(-0.999 * limit));
        pass(10u);
        put(names[phase], (float)(-1.001 * limit));
        pass(2u);
        put(names[phase], 0.0f);
        pass(1u);
        put(names[phase], (float)(1.001 * limit));
        pass(2u);
        expect_held();
        pass(1u);
        expect_violated(CAMPAIGN_I_CURRENT, names[phase]);
        TEST_ASSERT_EQUAL_UINT32(15u, result.period);
        TEST_ASSERT_EQUAL_UINT32(13u, result.from);
    }
}

static void test_current_with_all_gates_off_is_excused_and_told(void)
{
    judge_anew(0u);
    campaign_watch_edge(&watch, 0u, (uint32_t)RIG_EDGE_GATES, 0u);
    pass(1u); /* in this one a gate was still on */
    put("true_i_b", 1000.0f);
    pass(20u);
    expect_held();
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(CURRENT), result.excused);
}

static void test_an_angle_wrong_by_more_than_0_8_rad_may_last_50_ms_of_run(void)
{
    const uint32_t most = (uint32_t)(50e-3 / RIG_PERIOD_SECONDS);
    judge_anew(0u);
    put("theta_err", -0.81f);
    pass(most);
    *slot("manoeuvre") = (uint32_t)MANOEUVRE_RELOCK; /* it reacts */
    pass(1u);
    *slot("manoeuvre") = (uint32_t)MANOEUVRE_RUN;
    pass(most);
    put("theta_err", 0.79f);
    pass(1u);
    put("theta_err", 0.81f);
    pass(most);
    *slot("state") = (uint32_t)DRIVE_READY;
    pass(1u);
    *slot("state") = (uint32_t)DRIVE_OPERATION_ENABLED;
    pass(most);
    expect_held();
    pass(1u);
    expect_violated(CAMPAIGN_I_ANGLE, "theta_err");
    TEST_ASSERT_EQUAL_UINT32(result.period - most, result.from);
}

static void test_a_gate_that_is_on_a_period_after_the_fault_was_latched_is_a_violation(void)
{
    judge_anew(0u);
    *slot("state") = (uint32_t)DRIVE_FAULT;
    pass(1u); /* before it opened, gates were on */
    expect_held();
    pass(1u);
    expect_violated(CAMPAIGN_I_GATES, "state");

    judge_anew(0u);
    *slot("state") = (uint32_t)DRIVE_FAULT;
    campaign_watch_edge(&watch, 1u, (uint32_t)RIG_EDGE_GATES, 0u);
    pass(100u);
    expect_held();
    campaign_watch_edge(&watch, 2u, (uint32_t)RIG_EDGE_GATES, 0x20u); /* a spike within one period */
    campaign_watch_edge(&watch, 3u, (uint32_t)RIG_EDGE_GATES, 0u);
    pass(1u);
    expect_violated(CAMPAIGN_I_GATES, "state");
}

static void test_what_the_judge_knows_of_the_drive_is_so(void)
{
    TEST_ASSERT_EQUAL_UINT32(DRIVE_SAMPLE_LATE, CAMPAIGN_LATE_FLAG);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(CAMPAIGN_STATE_WORDS, sizeof(drive_t) / sizeof(uint32_t));
}

static void test_a_late_sample_a_short_through_a_leg_and_a_report_of_the_chip_are_violations(void)
{
    judge_anew(0u);
    *slot("sample_flags") = DRIVE_SAMPLE_LATE - 1u;
    pass(1u);
    expect_held();
    *slot("sample_flags") = DRIVE_SAMPLE_LATE;
    pass(1u);
    expect_violated(CAMPAIGN_I_LATE, "sample_flags");
    judge_anew(0u);
    put("shoot_throughs", 1.0f);
    pass(1u);
    expect_violated(CAMPAIGN_I_LEGS, "shoot_throughs");
    judge_anew(0u);
    put("chip_reports", 1.0f);
    pass(1u);
    expect_violated(CAMPAIGN_I_CHIP, "chip_reports");
}

static void test_what_a_fault_breaks_by_itself_is_excused_and_nothing_else(void)
{
    judge_anew(fault_of("late_interrupt"));
    *slot("sample_flags") = DRIVE_SAMPLE_LATE;
    pass(5u);
    expect_held();
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(LATE), result.excused);
    put("shoot_throughs", 1.0f);
    pass(1u);
    expect_violated(CAMPAIGN_I_LEGS, "shoot_throughs");
}

/* 0.5 A above the limit, and below the 25 A that no phase carries because a sensor lies. */
static void test_a_sensor_that_stands_excuses_the_current_for_20_ms_with_the_bridge_on_up_to_25_A(void)
{
    const float over = (float)(1.2 * rig_initial(rig_row_by_name("overcurrent_trip"))) + 0.5f;
    const uint32_t told = (uint32_t)(20e-3 / RIG_PERIOD_SECONDS);
    TEST_ASSERT_TRUE(over < 25.0f);
    judge_anew(fault_of("stuck_near_zero_a"));
    campaign_watch_edge(&watch, 0u, (uint32_t)RIG_EDGE_GATES, 0u);
    pass(500u); /* off: nothing is at stake yet */
    campaign_watch_edge(&watch, 1u, (uint32_t)RIG_EDGE_GATES, 1u);
    put("true_i_b", over);
    put("true_omega_m", 100.0f); /* a third of a turn is 5 ms */
    pass(told);
    expect_held();
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(CURRENT), result.excused);
    pass(3u);
    expect_violated(CAMPAIGN_I_CURRENT, "true_i_b");

    judge_anew(fault_of("stuck_near_zero_a"));
    put("true_i_b", over);
    put("true_omega_m", 10.0f); /* of four pole pairs: 52.4 ms */
    pass((uint32_t)(52e-3 / RIG_PERIOD_SECONDS));
    expect_held();
    pass((uint32_t)(1e-3 / RIG_PERIOD_SECONDS));
    expect_violated(CAMPAIGN_I_CURRENT, "true_i_b");

    judge_anew(fault_of("stuck_near_zero_a"));
    put("true_i_b", 25.1f);
    pass(2u);
    expect_held();
    pass(1u);
    expect_violated(CAMPAIGN_I_CURRENT, "true_i_b");
}

static void test_a_wrong_gain_excuses_the_current_up_to_25_A(void)
{
    judge_anew(fault_of("current_range"));
    put("true_i_c", -24.9f);
    pass(5000u);
    expect_held();
    put("true_i_c", -25.1f);
    pass(3u);
    expect_violated(CAMPAIGN_I_CURRENT, "true_i_c");
}

/* Where the EMF is too small to tell, the time of a wrong angle does not run. */
static void test_a_leg_that_loses_voltage_excuses_the_angle_of_a_slow_rotor(void)
{
    const uint32_t most = (uint32_t)(50e-3 / RIG_PERIOD_SECONDS);
    judge_anew(fault_of("leg_drop_a"));
    put("theta_err", 1.0f);
    put("true_omega_m", 0.99f * (float)watch.excused[0].blind);
    pass(10u * most);
    expect_held();
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(ANGLE), result.excused);
    put("true_omega_m", 1.01f * (float)watch.excused[0].blind);
    pass(most + 1u);
    expect_violated(CAMPAIGN_I_ANGLE, "theta_err");
}

static void test_swapped_wires_excuse_the_angle_only_without_an_encoder(void)
{
    const uint32_t most = (uint32_t)(50e-3 / RIG_PERIOD_SECONDS);
    judge_anew(fault_of("swap_phases"));
    observed.event_count = 1u; /* position_source changes after half a second */
    observed.events[0] = (campaign_event_t){.kind = CAMPAIGN_V_SOURCE, .time = 5000.0 * RIG_PERIOD_SECONDS};
    put("theta_err", 1.0f);
    pass(5000u);
    expect_held();
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(ANGLE), result.excused);
    pass(most);
    expect_held();
    pass(2u);
    expect_violated(CAMPAIGN_I_ANGLE, "theta_err");
}

static void test_a_chip_that_is_reset_on_purpose_has_its_gates_off_and_shows_nothing_else(void)
{
    judge_anew(fault_of("slow_background"));
    put("chip_reports", 1.0f);
    campaign_watch_edge(&watch, 0u, (uint32_t)RIG_EDGE_GATES, 0u);
    pass(1u);
    put("theta_err", 3.0f);
    pass(2000u);
    expect_held();
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(CHIP), result.excused);
    campaign_watch_edge(&watch, 0u, (uint32_t)RIG_EDGE_GATES, 1u);
    pass(1u);
    expect_violated(CAMPAIGN_I_GATES, "state");
}

/* ---- many ---- */

#define RUNS    24u
#define SECONDS 0.1

static char *summary_of(const campaign_t *campaign, const campaign_result_t *results)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    TEST_ASSERT_NOT_NULL(file);
    campaign_summary(file, campaign, results, false);
    campaign_summary(file, campaign, results, true);
    fclose(file);
    return text;
}

typedef struct {
    uint32_t kept;
    uint32_t last;
} kept_t;

static bool keep(void *context, uint32_t run, const campaign_result_t *kept, const char *scenario)
{
    kept_t *all = context;
    all->kept++;
    all->last = run;
    TEST_ASSERT_EQUAL(kept->end == CAMPAIGN_VIOLATED, scenario != NULL);
    return true;
}

static campaign_t small_campaign(void)
{
    return (campaign_t){
        .seed = 5u, .runs = RUNS, .seconds = SECONDS, .shard = 1u, .shards = 1u, .threads = 1u};
}

static void test_threads_and_shards_change_nothing(void)
{
    char why[POOL_WHY];
    campaign_result_t alone[RUNS] = {{0}};
    campaign_result_t threads[RUNS] = {{0}};
    campaign_result_t shards[RUNS] = {{0}};
    campaign_t campaign = small_campaign();
    TEST_ASSERT_TRUE(campaign_all(&campaign, alone, why));
    campaign.threads = 3u;
    TEST_ASSERT_TRUE(campaign_all(&campaign, threads, why));
    campaign.shards = 5u;
    for (campaign.shard = 5u; campaign.shard >= 1u; campaign.shard--) {
        TEST_ASSERT_TRUE(campaign_all(&campaign, shards, why));
    }
    TEST_ASSERT_EQUAL_MEMORY(alone, threads, sizeof alone);
    TEST_ASSERT_EQUAL_MEMORY(alone, shards, sizeof alone);

    const campaign_t whole = small_campaign();
    campaign.shard = 3u;
    char *one = summary_of(&whole, alone);
    char *merged = summary_of(&campaign, shards);
    TEST_ASSERT_EQUAL_STRING(one, merged);
    free(one);
    free(merged);
}

static void test_what_is_done_is_not_done_again(void)
{
    char why[POOL_WHY];
    campaign_result_t results[RUNS] = {{0}};
    kept_t kept = {0};
    campaign_t campaign = small_campaign();
    for (uint32_t run = 0; run < RUNS; run++) {
        results[run].end = run == 7u ? CAMPAIGN_NOT_DONE : CAMPAIGN_REFUSED;
    }
    campaign.keep = keep;
    campaign.context = &kept;
    TEST_ASSERT_TRUE(campaign_all(&campaign, results, why));
    TEST_ASSERT_EQUAL_UINT32(1u, kept.kept);
    TEST_ASSERT_EQUAL_UINT32(7u, kept.last);
    TEST_ASSERT_EQUAL(CAMPAIGN_REFUSED, results[0].end);
    TEST_ASSERT_NOT_EQUAL(CAMPAIGN_NOT_DONE, results[7].end);
}

static void test_a_campaign_that_is_stopped_keeps_nothing_half_done(void)
{
    char why[POOL_WHY];
    campaign_result_t results[RUNS] = {{0}};
    const volatile sig_atomic_t stop = 1;
    campaign_t campaign = small_campaign();
    campaign.stop = &stop;
    TEST_ASSERT_TRUE(campaign_all(&campaign, results, why));
    for (uint32_t run = 0; run < RUNS; run++) {
        TEST_ASSERT_EQUAL(CAMPAIGN_NOT_DONE, results[run].end);
    }
}

static void test_a_run_is_the_same_whatever_came_before_it(void)
{
    campaign_case_t drawn;
    campaign_result_t first;
    campaign_result_t again;
    campaign_draw(5u, 3u, SECONDS, &drawn);
    TEST_ASSERT_TRUE(campaign_run(&drawn, NULL, &first));
    campaign_draw(5u, 4u, SECONDS, &drawn);
    TEST_ASSERT_TRUE(campaign_run(&drawn, NULL, &again));
    campaign_draw(5u, 3u, SECONDS, &drawn);
    TEST_ASSERT_TRUE(campaign_run(&drawn, NULL, &again));
    TEST_ASSERT_EQUAL_MEMORY(&first, &again, sizeof first);
}

/* ---- results as text ---- */

static void test_a_result_reads_back_from_its_line_and_a_torn_one_does_not(void)
{
    const campaign_result_t told = {
        CAMPAIGN_VIOLATED, CAMPAIGN_I_ANGLE, 12345u, 3010u, 2u, 38, 33u, 11845u, 12000u, 1u, 3u, 0u};
    char line[CAMPAIGN_LINE_SIZE];
    campaign_line(9999u, &told, line);
    uint32_t run = 0;
    campaign_result_t read = {0};
    TEST_ASSERT_TRUE(campaign_read_line(line, 10000u, &run, &read));
    TEST_ASSERT_EQUAL_UINT32(9999u, run);
    TEST_ASSERT_EQUAL_MEMORY(&told, &read, sizeof told);
    TEST_ASSERT_FALSE(campaign_read_line(line, 9999u, &run, &read));
    for (size_t length = strlen(line); length-- > 0u;) {
        char torn[CAMPAIGN_LINE_SIZE];
        snprintf(torn, sizeof torn, "%.*s", (int)length, line);
        TEST_ASSERT_FALSE_MESSAGE(campaign_read_line(torn, 10000u, &run, &read), torn);
    }
}

static void test_a_head_of_other_tables_is_refused(void)
{
    char line[CAMPAIGN_LINE_SIZE];
    campaign_t read = {0};
    const campaign_t campaign = small_campaign();
    campaign_head(&campaign, line);
    TEST_ASSERT_TRUE(campaign_read_head(line, &read));
    TEST_ASSERT_EQUAL_UINT64(5u, read.seed);
    TEST_ASSERT_EQUAL_UINT32(RUNS, read.runs);
    TEST_ASSERT_EQUAL_DOUBLE(SECONDS, read.seconds);
    char *tables = strstr(line, "tables ");
    TEST_ASSERT_NOT_NULL(tables);
    tables[7] = tables[7] == '0' ? '1' : '0';
    TEST_ASSERT_FALSE(campaign_read_head(line, &read));
}
