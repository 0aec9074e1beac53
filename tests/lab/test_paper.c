/* The paper's figures, row by row: the formulas against numbers worked out elsewhere, the measured rows
 * against theory, the verdicts on rows made by hand. All figures are run once, on the real interrupt code. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/paper.h"
#include "unity.h"

#define THREADS 2u

static bool all[PAPER_FIGURES];
static paper_t *paper;
static paper_error_t why;

void setUp(void)
{
}

void tearDown(void)
{
}

static const paper_row_t *row(const char *id)
{
    const paper_row_t *found = paper_row_by_id(paper, id);
    TEST_ASSERT_NOT_NULL_MESSAGE(found, id);
    return found;
}

static void expect(const char *id, paper_verdict_t verdict)
{
    const paper_row_t *found = row(id);
    char text[300];
    snprintf(text, sizeof text, "%s: %g is %s, not %s %s", id, found->ours,
             paper_verdict_name(found->verdict), paper_verdict_name(verdict), found->because);
    TEST_ASSERT_TRUE_MESSAGE(found->verdict == verdict, text);
    /* A verdict that is not plain says why. */
    TEST_ASSERT_EQUAL_INT(verdict == PAPER_REPRODUCED, found->because[0] == '\0');
    TEST_ASSERT_FALSE_MESSAGE(found->stopped, id);
}

static void expect_number(const char *id, double expected, double tolerance)
{
    char text[120];
    snprintf(text, sizeof text, "%s: %.4g, expected %.4g within %g", id, row(id)->ours, expected, tolerance);
    TEST_ASSERT_TRUE_MESSAGE(fabs(row(id)->ours - expected) <= tolerance, text);
}

/* The same of both flavours. */
static void expect_both(const char *name, paper_verdict_t verdict)
{
    char id[64];
    snprintf(id, sizeof id, "%.50s.real", name);
    expect(id, verdict);
    snprintf(id, sizeof id, "%.50s.ideal", name);
    expect(id, verdict);
}

/* ---- formulas ---- */

/* Natural frequencies of physics.md, section 3, for omega_c in these ratios to that of the conventional loop,
 * 40.3 rad/s at 100 rad/s. Three digits: 0.05 of the result, and 0.05 x 1.5 of omega_c, which moves it by up
 * to 0.55 times as much. */
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

/* Damping 1, omega_c 0: |Phi|^2 = 1/2 at wn sqrt(3 + sqrt(10)) = 2.4824 wn, from (19). */
static void test_conventional_loop_in_closed_form(void)
{
    double kp = 0.0;
    double ki = 0.0;
    TEST_ASSERT_TRUE(paper_loop(100.0, 0.0, &kp, &ki));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100.0 / sqrt(3.0 + sqrt(10.0)), sqrt(ki));
}

/* The feed-forward alone has a bandwidth of omega_c: there is no loop of less. */
static void test_loop_that_does_not_exist_is_refused(void)
{
    double kp = 7.0;
    double ki = 8.0;
    TEST_ASSERT_FALSE(paper_loop(100.0, 101.0, &kp, &ki));
    TEST_ASSERT_EQUAL_DOUBLE(7.0, kp);
    TEST_ASSERT_EQUAL_DOUBLE(8.0, ki);
}

/* Table of physics.md, section 2, simulated there and rounded to 0.1 mrad; and its 0.08 rad for 162 V. */
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
    /* (14) as printed over-compensates by 35.5 mrad there, with the power-weighted k_f. */
    TEST_ASSERT_DOUBLE_WITHIN(
        0.5, 35.5, 1e3 * (paper_lag_sampled(200.0, 1.0, 628.3185) - paper_lag_printed(200.0, 1.0, 628.3185)));
}

/* ---- verdicts, on rows made by hand ---- */

static paper_verdict_t judged(double number, double expected, double ours, bool kind, bool stopped)
{
    const paper_row_t made = {.paper = number,
                              .expected = expected,
                              .ours = ours,
                              .tolerance = 0.5,
                              .kind = kind,
                              .stopped = stopped};
    return paper_judge(&made);
}

static void test_verdict_follows_from_the_numbers(void)
{
    const double none = (double)NAN;
    TEST_ASSERT_EQUAL_INT(PAPER_REPRODUCED, judged(4.0, 4.0, 3.75, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_REPRODUCED, judged(4.0, 4.0, 4.5, false, false)); /* at the limit */
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, 4.5625, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, -4.0, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_IN_KIND, judged(4.0, 4.0, 9.0, true, false));
    TEST_ASSERT_EQUAL_INT(PAPER_IN_KIND, judged(none, 4.0, 4.0, false, false)); /* no number in print */
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(none, 4.0, 9.0, false, false));
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, none, true, false));
    TEST_ASSERT_EQUAL_INT(PAPER_NOT_REPRODUCED, judged(4.0, 4.0, 4.0, true, true)); /* the drive stopped */
}

/* ---- the figures ---- */

static void test_fig04_and_fig08(void)
{
    expect("fig04.sigmoid.formula", PAPER_REPRODUCED);
    expect("fig04.sign.formula", PAPER_IN_KIND);
    expect("fig08.b100_falling.formula", PAPER_REPRODUCED);
    expect("fig08.b200_falling.formula", PAPER_REPRODUCED);
    /* Least where k_p rules: 20 log(40.3/25.9), to the digits of that table. */
    expect_number("fig08.b100_lower.formula", 3.84, 0.05);
    expect_number("fig08.b200_lower.formula", 3.84, 0.05);
}

/* |x| of one axis goes from 0 to f^-1(78 V/200 V) = 0.82 A: k_f from 0.5 down to 0.474, mean by the
 * describing function about 0.486. */
static void test_fig05(void)
{
    expect_both("fig05.sigmoid", PAPER_REPRODUCED);
    expect_number("fig05.sigmoid.ideal", 0.487, 0.003);
    expect_both("fig05.sigmoid_spread", PAPER_IN_KIND);
    expect_both("fig05.sign", PAPER_IN_KIND);
    expect_both("fig05.sign_spread", PAPER_IN_KIND);
}

static void test_fig10(void)
{
    TEST_ASSERT_TRUE(row("fig10.mean.real")->verdict != PAPER_NOT_REPRODUCED);
    TEST_ASSERT_TRUE(row("fig10.mean.ideal")->verdict != PAPER_NOT_REPRODUCED);
    expect_both("fig10.ripple", PAPER_IN_KIND);
}

static void test_fig11(void)
{
    expect_both("fig11.ks162", PAPER_REPRODUCED);
    expect_both("fig11.ks200", PAPER_IN_KIND);
    expect_both("fig11.theory", PAPER_REPRODUCED);
    expect_both("fig11.printed", PAPER_NOT_REPRODUCED);
    expect_number("fig11.ks200.ideal", -54.1, 1.0);
    expect_number("fig11.printed.ideal", 35.5, 1.5);
}

static void test_fig12(void)
{
    expect_both("fig12.off", PAPER_REPRODUCED);
    expect_both("fig12.exact", PAPER_REPRODUCED);
    expect_both("fig12.printed", PAPER_NOT_REPRODUCED);
    expect_both("fig12.i_q", PAPER_NOT_REPRODUCED);
    expect_both("fig12.i_d", PAPER_REPRODUCED);
    /* 4 A (1/cos 0.08 - 1), the torque being the same; 4 A tan 0.08. The window's speed drifts by less than
     * makes 3 mA. */
    expect_number("fig12.i_q.ideal", 0.0128, 0.003);
    expect_number("fig12.i_d.ideal", 0.3207, 0.003);
}

static void test_fig13(void)
{
    expect_both("fig13.steady", PAPER_REPRODUCED);
    expect_both("fig13.accelerating", PAPER_REPRODUCED);
    expect_both("fig13.decelerating", PAPER_REPRODUCED);
    expect_both("fig13.decelerating_rated", PAPER_REPRODUCED);
    expect_both("fig13.theory", PAPER_REPRODUCED);
    expect_number("fig13.accelerating.ideal", 355.0, 10.0);
    expect_number("fig13.decelerating.ideal", 450.0, 15.0);
    expect_number("fig13.decelerating_rated.ideal", 616.0, 20.0);
}

static void expect_sweep(const char *figure)
{
    static const char *const names[] = {"b100_feedforward", "b200_feedforward", "b100_conventional",
                                        "b200_conventional"};
    for (int n = 0; n < 4; n++) {
        char name[64];
        snprintf(name, sizeof name, "%s.%s", figure, names[n]);
        expect_both(name, n < 2 ? PAPER_REPRODUCED : PAPER_IN_KIND);
    }
}

static void test_fig14(void)
{
    expect_sweep("fig14");
    expect_number("fig14.b200_conventional.ideal", -93.3, 0.05 * 93.3);
}

/* The loss hangs on the dead time's voltage: 3.6 us x 311 V x 10 kHz = 11 V against an EMF of 7.7 V at 100
 * r/min. With it compensated nothing is lost. */
static void test_fig15(void)
{
    expect_sweep("fig15");
    expect_both("fig15.compensated", PAPER_NOT_REPRODUCED);
    expect("fig15.conventional.real", PAPER_REPRODUCED);
    expect("fig15.feedforward.real", PAPER_REPRODUCED);
    expect("fig15.moderate.real", PAPER_REPRODUCED);
}

static void test_fig16(void)
{
    static const char *const flavours[] = {"real", "ideal"};
    static const char *const changes[] = {"nl_accelerating", "nl_decelerating", "rated_accelerating",
                                          "rated_decelerating"};
    expect("fig16.speed_sd.real", PAPER_REPRODUCED);
    expect("fig16.speed_sd_bandwidth.real", PAPER_REPRODUCED);
    TEST_ASSERT_TRUE(row("fig16.position_sd_bandwidth.real")->verdict != PAPER_NOT_REPRODUCED);
    for (int n = 0; n < 16; n++) {
        char id[64];
        snprintf(id, sizeof id, "fig16.b%d_%s.%s", n / 8 == 0 ? 100 : 200, changes[n % 4],
                 flavours[n / 4 % 2]);
        expect(id, PAPER_IN_KIND);
        expect_number(id, n / 8 == 0 ? 25.0 : 50.0, n / 8 == 0 ? 8.0 : 16.0);
    }
}

/* Acceptance: 115 +- 6, at most 105, at most 32. */
static void test_fig17(void)
{
    expect_both("fig17.steady", PAPER_REPRODUCED);
    for (int n = 0; n < 2; n++) {
        char id[64];
        const int rpm = n == 0 ? 500 : 1500;
        snprintf(id, sizeof id, "fig17.b100_wc0_%d.ideal", rpm);
        expect_number(id, 115.0, 6.0);
        snprintf(id, sizeof id, "fig17.b100_wc25_%d.ideal", rpm);
        expect_number(id, 98.0, 7.0);
        snprintf(id, sizeof id, "fig17.b200_wc50_%d.ideal", rpm);
        expect_number(id, 28.0, 4.0);
    }
}

static void test_every_row_tells_claim_unit_and_condition(void)
{
    bool seen[PAPER_FIGURES] = {false};
    for (size_t n = 0; n < paper_row_count(paper); n++) {
        const paper_row_t *r = paper_row(paper, n);
        const char *id = paper_figures[r->figure].id;
        seen[r->figure] = true;
        TEST_ASSERT_TRUE(r->claim[0] != '\0' && r->unit[0] != '\0' && r->condition[0] != '\0');
        TEST_ASSERT_EQUAL_INT(0, strncmp(r->id, id, strlen(id)));
        TEST_ASSERT_TRUE(r->verdict == paper_judge(r));
        TEST_ASSERT_EQUAL_PTR(r, paper_row_by_id(paper, r->id)); /* no id twice */
    }
    for (size_t n = 0; n < PAPER_FIGURES; n++) {
        TEST_ASSERT_TRUE_MESSAGE(seen[n], paper_figures[n].id);
        TEST_ASSERT_EQUAL_UINT(n, paper_figure(paper_figures[n].id));
    }
    TEST_ASSERT_EQUAL_UINT(PAPER_FIGURES, paper_figure("fig99"));
    TEST_ASSERT_EQUAL_UINT(PAPER_FIGURES, paper_figure("fig0"));
    TEST_ASSERT_NULL(paper_row_by_id(paper, "fig13"));
}

/* ---- files ---- */

static size_t fields(const char *line)
{
    size_t count = 1;
    for (; *line != '\0'; line++) {
        count += *line == ',';
    }
    return count;
}

static void test_csv_names_units_and_has_as_many_fields_in_every_line(void)
{
    for (size_t figure = 0; figure < PAPER_FIGURES; figure++) {
        char *text = NULL;
        char *line = NULL;
        size_t size = 0;
        size_t lines = 0;
        size_t names = 0;
        FILE *file = open_memstream(&text, &size);
        TEST_ASSERT_NOT_NULL(file);
        paper_write_csv(paper, figure, file);
        fclose(file);
        for (char *rest = text; (line = strsep(&rest, "\n")) != NULL && line[0] != '\0'; lines++) {
            if (lines == 0) {
                names = fields(line);
                size_t units = 0;
                for (const char *c = line; *c != '\0'; c++) {
                    units += *c == '[';
                }
                TEST_ASSERT_EQUAL_UINT(names, units);
            }
            TEST_ASSERT_EQUAL_UINT(names, fields(line));
        }
        TEST_ASSERT_TRUE_MESSAGE(names >= 5u && lines > 40u, paper_figures[figure].id);
        free(text);
    }
}

static void test_threads_do_not_change_a_bit_and_seeds_do(void)
{
    bool wanted[PAPER_FIGURES] = {false};
    wanted[paper_figure("fig12")] = true;
    paper_t *alone = paper_run(wanted, 1u, 1u, NULL, NULL, &why);
    paper_t *other = paper_run(wanted, 2u, 3u, NULL, NULL, &why);
    TEST_ASSERT_NOT_NULL(alone);
    TEST_ASSERT_NOT_NULL(other);
    TEST_ASSERT_EQUAL_UINT(10u, paper_row_count(alone));
    for (size_t n = 0; n < paper_row_count(alone); n++) {
        const paper_row_t *r = paper_row(alone, n);
        TEST_ASSERT_EQUAL_MEMORY(&r->ours, &row(r->id)->ours, sizeof r->ours);
        if (strcmp(r->flavour, "real") == 0) {
            TEST_ASSERT_TRUE(r->ours != paper_row(other, n)->ours);
        }
    }
    paper_free(alone);
    paper_free(other);
}

int main(void)
{
    for (size_t n = 0; n < PAPER_FIGURES; n++) {
        all[n] = true;
    }
    paper = paper_run(all, 1u, THREADS, NULL, NULL, &why);
    if (paper == NULL) {
        fprintf(stderr, "%s\n", why.text);
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(test_loops_of_equal_bandwidth);
    RUN_TEST(test_conventional_loop_in_closed_form);
    RUN_TEST(test_loop_that_does_not_exist_is_refused);
    RUN_TEST(test_lag_of_the_sampled_observer);
    RUN_TEST(test_verdict_follows_from_the_numbers);
    RUN_TEST(test_fig04_and_fig08);
    RUN_TEST(test_fig05);
    RUN_TEST(test_fig10);
    RUN_TEST(test_fig11);
    RUN_TEST(test_fig12);
    RUN_TEST(test_fig13);
    RUN_TEST(test_fig14);
    RUN_TEST(test_fig15);
    RUN_TEST(test_fig16);
    RUN_TEST(test_fig17);
    RUN_TEST(test_every_row_tells_claim_unit_and_condition);
    RUN_TEST(test_csv_names_units_and_has_as_many_fields_in_every_line);
    RUN_TEST(test_threads_do_not_change_a_bit_and_seeds_do);
    paper_free(paper);
    return UNITY_END();
}
