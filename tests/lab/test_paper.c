/* The code behind the paper's figures: the formulas compared with numbers that were computed separately,
 * the verdicts on rows made by hand, and files and threads of one figure. test_paper_rows.py judges the
 * rows of the report. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/paper.h"
#include "host_sim/lab/paper_theory.h"
#include "unity.h"

static paper_t *paper; /* fig12, seed 1 */
static paper_error_t why;

/* ---- formulas ---- */

/* The natural frequencies of docs/theory.md, 7, for these ratios of omega_c to the natural frequency of
 * the conventional loop, 40.3 rad/s at a bandwidth of 100 rad/s. The table has three digits: 0.05 for the
 * result, and 0.05 x 1.5 for omega_c, which changes the result by up to 0.55 times as much. */
static void test_loops_of_equal_bandwidth(void)
{
    static const struct {
        double ratio, wn;
    } loops[] = {{0.0, 40.3}, {0.625, 25.9}, {1.0, 18.9}, {1.5, 11.4}};
    for (size_t n = 0; n < sizeof loops / sizeof loops[0]; n++) {
        for (double bandwidth = 100.0; bandwidth <= 200.0; bandwidth += 100.0) {
            double kp = 0.0;
            double ki = 0.0;
            TEST_ASSERT_TRUE(paper_loop(bandwidth, loops[n].ratio * 0.40284 * bandwidth, &kp, &ki));
            TEST_ASSERT_DOUBLE_WITHIN(0.1, loops[n].wn, 100.0 / bandwidth * sqrt(ki));
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.0 * sqrt(ki), kp);
        }
    }
}

/* The feed-forward alone has a bandwidth of omega_c, so that no loop has a smaller one. */
static void test_loop_that_does_not_exist_is_refused(void)
{
    double kp = 7.0;
    double ki = 8.0;
    TEST_ASSERT_FALSE(paper_loop(100.0, 101.0, &kp, &ki));
    TEST_ASSERT_EQUAL_DOUBLE(7.0, kp);
    TEST_ASSERT_EQUAL_DOUBLE(8.0, ki);
}

/* The table of docs/theory.md, 4, rounded to 0.1 mrad, and the 0.08 rad of Fig. 11 for 162 V. */
static void test_lag_of_the_sampled_observer(void)
{
    static const double speeds[] = {100.0, 500.0, 1000.0, 1500.0};
    static const double lags[] = {-3.1, -15.8, -33.1, -54.1};
    for (int n = 0; n < 4; n++) {
        const double omega_e = 4.0 * speeds[n] * 2.0 * 3.14159265358979 / 60.0;
        TEST_ASSERT_DOUBLE_WITHIN(0.3, lags[n], 1e3 * paper_lag_sampled(200.0, 1.0, omega_e));
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, -paper_lag_sampled(200.0, 1.0, omega_e),
                                  paper_lag_sampled(200.0, 1.0, -omega_e));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, -80.0, 1e3 * paper_lag_sampled(162.0, 1.0, 628.3185));
    /* (14) as printed over-compensates by 35.5 mrad at this point, with the power-weighted k_f. */
    TEST_ASSERT_DOUBLE_WITHIN(
        0.5, 35.5, 1e3 * (paper_lag_sampled(200.0, 1.0, 628.3185) - paper_lag_printed(200.0, 1.0, 628.3185)));
}

/* The angle errors of the paper's three accelerations, calculated from its own numbers for k_i = 1624:
 * asin(a/k_i), and the equilibrium with the cosine of the torque (docs/theory.md, 19). The limit is 1 %,
 * the accuracy to which these numbers determine the test rig. */
static void test_tracking_error_at_the_current_limit(void)
{
    const double ki = 1624.0;
    const double up = paper_tracking_error_at_limit(ki, -1.32);
    TEST_ASSERT_DOUBLE_WITHIN(0.0036, 0.355, up);
    TEST_ASSERT_DOUBLE_WITHIN(0.0045, 0.450, paper_tracking_error_at_limit(ki, 1.32));
    TEST_ASSERT_DOUBLE_WITHIN(0.0063, 0.629, paper_tracking_error_at_limit(ki, 6.32));
    /* The angle solves k_i sin e = (p/J)(T_m cos e + braking) with T_m = 10.98 N m, so that a = k_i sin e
     * gives it back. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 4.0 / 0.0636 * (10.98 * cos(up) - 1.32), ki * sin(up));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -up, paper_tracking_error(ki, ki * sin(up)));
    TEST_ASSERT_TRUE(isnan(paper_tracking_error_at_limit(100.0, 50.0)));
}

/* At the corner k_p and k_i/omega are equal, which is 45 degrees. */
static void test_loop_filter_at_its_corner(void)
{
    double kp = 0.0;
    double ki = 0.0;
    double gain = 0.0;
    double phase = 0.0;
    TEST_ASSERT_TRUE(paper_loop(100.0, 25.0, &kp, &ki));
    paper_loop_filter(100.0, 25.0, ki / kp, &gain, &phase);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, kp * sqrt(2.0), gain);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -0.25 * 3.14159265358979, phase);
}

/* ---- verdicts, on rows made by hand ---- */

static paper_verdict_t judged_of(const char *figure, double number, double expected, double ours, bool kind,
                                 bool stopped)
{
    const paper_row_t made = {.figure = paper_figure(figure),
                              .beyond = strncmp(figure, "beyond", 6) == 0,
                              .paper = number,
                              .expected = expected,
                              .ours = ours,
                              .tolerance = 0.5,
                              .kind = kind,
                              .stopped = stopped};
    return paper_judge(&made);
}

static paper_verdict_t judged(double number, double expected, double ours, bool kind, bool stopped)
{
    return judged_of("fig13", number, expected, ours, kind, stopped);
}

static void test_verdict_follows_from_the_numbers(void)
{
    const double none = (double)NAN;
    TEST_ASSERT_EQUAL_INT(PAPER_REPRODUCED, judged(4.0, 4.0, 3.75, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_REPRODUCED, judged(4.0, 4.0, 4.5, false, false)); /* exactly at the limit */
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, 4.5625, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, -4.0, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_IN_KIND, judged(4.0, 4.0, 9.0, true, false));
    /* The paper prints no number. */
    TEST_ASSERT_EQUAL_INT(PAPER_IN_KIND, judged(none, 4.0, 4.0, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(none, 4.0, 9.0, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, none, true, false));
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, 4.0, true, true)); /* the drive stopped */
}

static void test_beyond_the_paper_a_claim_holds_or_does_not(void)
{
    const double none = (double)NAN;
    TEST_ASSERT_EQUAL_INT(PAPER_HOLDS, judged_of("beyond_speed", none, 4.0, 4.5, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_DOES_NOT_HOLD, judged_of("beyond_speed", none, 4.0, 4.5625, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_DOES_NOT_HOLD, judged_of("beyond_speed", none, 4.0, none, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_DOES_NOT_HOLD, judged_of("beyond_speed", none, 4.0, 4.0, false, true));
}

static void test_figures_are_found_by_name(void)
{
    for (size_t n = 0; n < PAPER_FIGURES; n++) {
        TEST_ASSERT_EQUAL_UINT(n, paper_figure(paper_figures[n].id));
        /* Otherwise the file of the figure contains the title. */
        TEST_ASSERT_TRUE(paper_figures[n].title == NULL ||
                         (paper_figures[n].title[0] != '\0' && paper_figures[n].claim[0] != '\0'));
        /* Each figure has a test of its rows. */
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(LAGLESS_PAPER_TESTED, paper_figures[n].id), paper_figures[n].id);
    }
    TEST_ASSERT_EQUAL_UINT(PAPER_FIGURES, paper_figure("fig99"));
    TEST_ASSERT_EQUAL_UINT(PAPER_FIGURES, paper_figure("fig0"));
    TEST_ASSERT_NULL(paper_row_by_id(paper, "fig12"));
}

/* ---- files ---- */

static char *written(void (*write)(FILE *file))
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    TEST_ASSERT_NOT_NULL(file);
    write(file);
    fclose(file);
    return text;
}

static void write_manifest(FILE *file)
{
    paper_write_manifest(paper, "abc\"123", 1.5, file);
}

static void test_manifest_reports_conditions_figures_and_rows(void)
{
    static const char *const parts[] = {
        "{\"commit\": \"abc\\\"123\", \"seed\": 1, \"seconds\": 1.5,",
        "{\"name\": \"inertia\", \"value\": 0.0636, \"unit\": \"kg m^2\"",
        "{\"name\": \"speed_kp\", \"value\": 0.5,",
        "{\"id\": \"fig12\", ",
        "\"paper\": \"Fig. 12\", \"csv\": \"data/fig12.csv\"",
        "[{\"time\": 1.25, \"text\": \"compensation on\"}, {\"time\": 3.75, \"text\": \"compensation off\"}]",
        "{\"name\": \"printed\", \"flavour\": \"real\", \"bandwidth\": 100, \"omega_c\": 0, \"kp\": 80.5",
        "\"switching\": \"sigmoid\", \"lag\": \"printed\", \"encoder\": false, \"lost\": false",
        "{\"id\": \"fig12.off.real\", \"figure\": \"fig12\", \"flavour\": \"real\"",
        "\"paper\": -80, \"expected\": -80, ",
    };
    char *text = written(write_manifest);
    for (size_t n = 0; n < sizeof parts / sizeof parts[0]; n++) {
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(text, parts[n]), parts[n]);
    }
    TEST_ASSERT_NULL(strstr(text, "fig13"));
    free(text);
}

static void test_board_with_another_carrier_is_refused_by_name(void)
{
    static const struct {
        uint64_t ticks;
        const char *text;
    } others[] = {{9378u, "need a PWM of 10 kHz; this board's has 15.9949 kHz"},
                  {7500u, "need a PWM of 10 kHz; this board's has 20 kHz"},
                  {30000u, "need a PWM of 10 kHz; this board's has 5 kHz"}};
    paper_error_t refusal;
    TEST_ASSERT_TRUE(paper_is_for(15000u, &refusal));
    for (size_t n = 0; n < sizeof others / sizeof others[0]; n++) {
        TEST_ASSERT_FALSE(paper_is_for(others[n].ticks, &refusal));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(refusal.text, others[n].text), refusal.text);
    }
}

int main(void)
{
    bool wanted[PAPER_FIGURES] = {false};
    wanted[paper_figure("fig12")] = true;
    paper = paper_run(wanted, 1u, 2u, NULL, NULL, &why);
    if (paper == NULL) {
        fprintf(stderr, "%s\n", why.text);
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(test_loops_of_equal_bandwidth);
    RUN_TEST(test_loop_that_does_not_exist_is_refused);
    RUN_TEST(test_lag_of_the_sampled_observer);
    RUN_TEST(test_tracking_error_at_the_current_limit);
    RUN_TEST(test_loop_filter_at_its_corner);
    RUN_TEST(test_verdict_follows_from_the_numbers);
    RUN_TEST(test_beyond_the_paper_a_claim_holds_or_does_not);
    RUN_TEST(test_figures_are_found_by_name);
    RUN_TEST(test_manifest_reports_conditions_figures_and_rows);
    RUN_TEST(test_board_with_another_carrier_is_refused_by_name);
    const int failed = UNITY_END();
    paper_free(paper);
    return failed;
}
