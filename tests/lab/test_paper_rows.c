/* Every row of a figure, a test of its own: `test_paper fig13` runs that figure's experiments on the real
 * interrupt code and holds each row to the verdict below and, where something is known of it, to a number
 * from the paper, physics.md or algebra. A row that is not below fails, and so does a line below without a
 * row. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/paper.h"
#include "unity.h"

#define THREADS 2u

typedef struct {
    const char *id;
    paper_verdict_t verdict;
    double number, tolerance; /* [unit of the row]; NONE: nothing is known of it */
} expected_t;

#define NONE  ((double)NAN)
#define SAME  PAPER_REPRODUCED
#define KIND  PAPER_IN_KIND
#define NOT   PAPER_NOT_REPRODUCED
#define HOLDS PAPER_HOLDS
#define BOTH(id, v, n, t)                                                                                    \
    {id ".real", v, n, t},                                                                                   \
    {                                                                                                        \
        id ".ideal", v, n, t                                                                                 \
    }
/* What the real inverter and sensors add is between 1.5 mrad at rated load and 4 mrad without, towards 1500
 * r/min (physics.md, section 8). */
#define REAL_MORE(id, v, n, t, more)                                                                         \
    {id ".real", v, n, (t) + (more)},                                                                        \
    {                                                                                                        \
        id ".ideal", v, n, t                                                                                 \
    }

/* clang-format off */
static const expected_t expected[] = {
    /* tanh(x/2)/x at 0; 1/10 mA */
    {"fig04.sigmoid.formula", SAME, 0.5, 1e-9},
    {"fig04.sign.formula", KIND, 100.0, 1e-9},

    /* |x| of one axis goes from 0 to f^-1(78 V/200 V) = 0.82 A: k_f = (1 - x^2/12)/2 from 0.5 down to 0.474, mean
     * by the describing function 0.486, SD 0.67/(24 sqrt 8) = 0.0099, both less the next term's 10 %. */
    {"fig05.sigmoid.real", SAME, 0.487, 0.003}, {"fig05.sigmoid.ideal", SAME, 0.487, 0.003},
    BOTH("fig05.sigmoid_spread", KIND, 0.0203, 0.002),
    BOTH("fig05.sign", KIND, NONE, 0.0),
    BOTH("fig05.sign_spread", KIND, NONE, 0.0),

    /* Least where k_p rules: 20 log(40.3/25.9), to the digits of physics.md's table, section 3. */
    {"fig08.b100_falling.formula", SAME, 0.0, 0.0}, {"fig08.b100_lower.formula", KIND, 3.84, 0.05},
    {"fig08.b200_falling.formula", SAME, 0.0, 0.0}, {"fig08.b200_lower.formula", KIND, 3.84, 0.05},

    /* A switch that acts once per sample is late by half of it at most, 31.4 mrad. */
    BOTH("fig10.mean", KIND, 0.0, 31.4),
    BOTH("fig10.ripple", KIND, NONE, 0.0),

    /* physics.md, section 8; (14) as printed with the power-weighted k_f leaves 35.5. */
    BOTH("fig11.ks162", SAME, -80.0, 3.0),
    REAL_MORE("fig11.ks200", KIND, -54.1, 1.0, 1.5),
    REAL_MORE("fig11.theory", SAME, 0.0, 1.0, 3.0),
    REAL_MORE("fig11.printed", NOT, 35.5, 1.5, 1.5),

    /* Of 4 A: the torque being the same, 4 A (1/cos 0.08 - 1), and 4 A tan 0.08; the window's speed drifts by less
     * than makes 3 mA. (14) counts omega_e T_s/2 = 31.4 mrad too much, and 1/R - 1 = 5 % of 117 mrad; the real
     * drive adds the devices' 0.02 ohm to R, which takes 2 % of them back. */
    REAL_MORE("fig12.off", SAME, -80.0, 3.0, 1.0),
    REAL_MORE("fig12.exact", SAME, 0.0, 1.0, 3.0),
    REAL_MORE("fig12.printed", NOT, 37.2, 1.5, 3.0),
    BOTH("fig12.i_q", NOT, 0.0128, 0.003),
    BOTH("fig12.i_d", SAME, 0.3207, 0.003),

    /* The paper's, as accepted in physics.md, section 8. The last settles at 0.629 rad, where
     * k_i sin e = (p/J)(T_m cos e + T_f + T_L), and may be off by the 2 % that a/k_i may. */
    REAL_MORE("fig13.steady", SAME, 0.0, 0.5, 3.5),
    BOTH("fig13.accelerating", SAME, 355.0, 10.0),
    BOTH("fig13.decelerating", SAME, 450.0, 15.0),
    BOTH("fig13.decelerating_rated", SAME, 629.0, 12.6),
    BOTH("fig13.theory", SAME, 1.0, 0.02),
    BOTH("fig13.equilibrium", SAME, 1.0, 0.02),

    /* physics.md, section 3, its table and 5 %. */
    REAL_MORE("fig14.b100_feedforward", SAME, 0.0, 3.0, 1.0),
    REAL_MORE("fig14.b200_feedforward", SAME, 0.0, 3.0, 1.0),
    BOTH("fig14.b100_conventional", KIND, -354.7, 10.0),
    BOTH("fig14.b200_conventional", KIND, -93.2, 4.7),

    REAL_MORE("fig15.b100_feedforward", SAME, 0.0, 3.0, 1.0),
    REAL_MORE("fig15.b200_feedforward", SAME, 0.0, 3.0, 1.0),
    BOTH("fig15.b100_conventional", KIND, -174.8, 8.7),
    BOTH("fig15.b200_conventional", KIND, -45.0, 2.3),
    /* The loss hangs on the dead time's voltage: 3.6 us x 311 V x 10 kHz = 11 V against an EMF of 7.7 V at 100
     * r/min. Compensated, nothing is lost. */
    BOTH("fig15.compensated", NOT, 0.0, 0.0),
    {"fig15.conventional.real", SAME, 1.0, 0.0},
    {"fig15.feedforward.real", SAME, 0.0, 0.0},
    {"fig15.moderate.real", SAME, 0.0, 0.0},
    /* The reference study's threshold and its step; its survivors go at least as far as it was tried. */
    {"fig15.b200_wc0_dead_time.real", KIND, 3.25, 0.25},
    {"fig15.b200_wc25_dead_time.real", KIND, 4.0, 0.75},
    {"fig15.b100_wc0_dead_time.real", KIND, 4.0, 0.75},

    /* Fewer than the 20 and 12 that are at 1500 r/min. omega_c of the least overshoot: 0.62 of the conventional
     * loop's natural frequency, and flat around (physics.md, sections 3 and 8); under noise up to 1.62 times it. */
    {"fig16.speed_sd.real", SAME, 0.0, 0.0},
    {"fig16.position_sd.real", KIND, 10.0, 9.0},
    {"fig16.speed_sd_bandwidth.real", SAME, 0.0, 0.0},
    {"fig16.position_sd_bandwidth.real", KIND, 3.0, 3.0},
    REAL_MORE("fig16.b100_nl_accelerating", KIND, 25.0, 8.0, 7.5),
    REAL_MORE("fig16.b200_nl_accelerating", KIND, 50.0, 16.0, 15.0),
    REAL_MORE("fig16.b100_nl_decelerating", KIND, 25.0, 8.0, 7.5),
    REAL_MORE("fig16.b200_nl_decelerating", KIND, 50.0, 16.0, 15.0),
    REAL_MORE("fig16.b100_rated_accelerating", KIND, 25.0, 8.0, 7.5),
    REAL_MORE("fig16.b200_rated_accelerating", KIND, 50.0, 16.0, 15.0),
    REAL_MORE("fig16.b100_rated_decelerating", KIND, 25.0, 8.0, 7.5),
    REAL_MORE("fig16.b200_rated_decelerating", KIND, 50.0, 16.0, 15.0),

    /* The reference study's peaks: 115 +- 6, at most 105, at most 32. */
    BOTH("fig17.b100_wc0_500", KIND, 115.0, 6.0), BOTH("fig17.b100_wc0_1500", KIND, 115.0, 6.0),
    BOTH("fig17.b100_wc25_500", KIND, 98.0, 7.0), BOTH("fig17.b100_wc25_1500", KIND, 98.0, 7.0),
    BOTH("fig17.b200_wc50_500", KIND, 28.0, 4.0), BOTH("fig17.b200_wc50_1500", KIND, 28.0, 4.0),
    REAL_MORE("fig17.steady", SAME, 0.0, 0.5, 1.0),

    /* As fig11 and fig12, at 1490 r/min. */
    REAL_MORE("beyond_speed.lagless", HOLDS, 0.0, 0.5, 1.0),
    REAL_MORE("beyond_speed.uncompensated", HOLDS, 0.0, 1.0, 1.5),
    REAL_MORE("beyond_speed.printed", HOLDS, 0.0, 1.5, 3.0),
    REAL_MORE("beyond_speed.printed_1490", HOLDS, 35.3, 1.5, 3.0),

    /* physics.md, sections 8 and 10. */
    REAL_MORE("beyond_bandwidth.conventional", HOLDS, 0.0, 0.5, 3.5),
    REAL_MORE("beyond_bandwidth.feedforward", HOLDS, 0.0, 2.0, 2.0),
    REAL_MORE("beyond_bandwidth.torque_feedforward", HOLDS, 0.0, 10.0, 14.0),
    BOTH("beyond_bandwidth.lost", HOLDS, 0.0, 0.0),

    {"beyond_map.inductance.real", HOLDS, 0.0, 2.0},
    {"beyond_map.no_effect.real", HOLDS, 0.0, 0.3},
};
/* clang-format on */
#define EXPECTED (sizeof expected / sizeof expected[0])

static size_t figure;
static paper_t *paper;
static const paper_row_t *row;      /* of the test that runs */
static const expected_t *should_be; /* likewise */

void setUp(void)
{
}

void tearDown(void)
{
}

static const expected_t *expectation(const char *id)
{
    for (size_t n = 0; n < EXPECTED; n++) {
        if (strcmp(expected[n].id, id) == 0) {
            return &expected[n];
        }
    }
    return NULL;
}

/* ---- one row ---- */

static void check_row(void)
{
    char text[400];
    TEST_ASSERT_NOT_NULL_MESSAGE(should_be, "nothing is expected of this row");
    snprintf(text, sizeof text, "%g %s is %s, not %s; %s", row->ours, row->unit,
             paper_verdict_name(row->verdict), paper_verdict_name(should_be->verdict), row->because);
    TEST_ASSERT_TRUE_MESSAGE(row->verdict == should_be->verdict, text);
    TEST_ASSERT_TRUE_MESSAGE(row->verdict == paper_judge(row), "the verdict is not that of its numbers");
    TEST_ASSERT_FALSE_MESSAGE(row->stopped, "a drive stopped");
    if (!isnan(should_be->number)) {
        snprintf(text, sizeof text, "%.5g %s, expected %g within %g", row->ours, row->unit, should_be->number,
                 should_be->tolerance);
        TEST_ASSERT_TRUE_MESSAGE(fabs(row->ours - should_be->number) <= should_be->tolerance, text);
    }
    const bool plain = row->verdict == PAPER_REPRODUCED || row->verdict == PAPER_HOLDS;
    TEST_ASSERT_EQUAL_INT_MESSAGE(plain, row->because[0] == '\0', "a verdict that is not plain says why");
    TEST_ASSERT_TRUE(row->claim[0] != '\0' && row->unit[0] != '\0' && row->condition[0] != '\0');
    TEST_ASSERT_EQUAL_UINT(figure, row->figure);
    TEST_ASSERT_EQUAL_PTR_MESSAGE(row, paper_row_by_id(paper, row->id), "two rows have this id");
}

static void check_missing(void)
{
    TEST_FAIL_MESSAGE("there is no such row");
}

/* ---- the figure's data ---- */

static size_t count_of(const char *text, char c)
{
    size_t count = 0;
    for (; *text != '\0'; text++) {
        count += *text == c;
    }
    return count;
}

static void check_table(void (*write)(const paper_t *, FILE *), size_t least_columns, size_t least_lines)
{
    char *text = NULL;
    char *line = NULL;
    size_t size = 0;
    size_t lines = 0;
    size_t commas = 0;
    FILE *file = open_memstream(&text, &size);
    TEST_ASSERT_NOT_NULL(file);
    write(paper, file);
    fclose(file);
    for (char *rest = text; (line = strsep(&rest, "\n")) != NULL && line[0] != '\0'; lines++) {
        if (lines == 0) {
            commas = count_of(line, ',');
            TEST_ASSERT_EQUAL_UINT(commas + 1u, count_of(line, '['));
            TEST_ASSERT_EQUAL_UINT(commas + 1u, count_of(line, ']'));
        }
        TEST_ASSERT_EQUAL_UINT(commas, count_of(line, ','));
        TEST_ASSERT_NULL_MESSAGE(strstr(line, "nan"), line);
    }
    TEST_ASSERT_TRUE(commas + 1u >= least_columns && lines >= least_lines);
    free(text);
}

static void write_figure(const paper_t *of, FILE *file)
{
    paper_write_csv(of, figure, file);
}

static void csv_names_units_and_has_as_many_fields_in_every_line(void)
{
    check_table(write_figure, 5u, 40u);
    if (figure == paper_figure("fig15")) {
        check_table(paper_write_dead_time, 3u, 20u);
    }
}

static bool belongs(const char *id)
{
    const size_t length = strlen(paper_figures[figure].id);
    return strncmp(id, paper_figures[figure].id, length) == 0 && id[length] == '.';
}

int main(int argc, char **argv)
{
    bool wanted[PAPER_FIGURES] = {false};
    paper_error_t why;
    figure = argc == 2 ? paper_figure(argv[1]) : PAPER_FIGURES;
    if (figure == PAPER_FIGURES) {
        fprintf(stderr, "usage: test_paper FIGURE, as in `lagless paper`\n");
        return 2;
    }
    wanted[figure] = true;
    paper = paper_run(wanted, 1u, THREADS, NULL, NULL, &why);
    if (paper == NULL) {
        fprintf(stderr, "%s\n", why.text);
        return 1;
    }
    UNITY_BEGIN();
    for (size_t n = 0; n < paper_row_count(paper); n++) {
        row = paper_row(paper, n);
        should_be = expectation(row->id);
        UnityDefaultTestRun(check_row, row->id, __LINE__);
    }
    for (size_t n = 0; n < EXPECTED; n++) {
        if (belongs(expected[n].id) && paper_row_by_id(paper, expected[n].id) == NULL) {
            UnityDefaultTestRun(check_missing, expected[n].id, __LINE__);
        }
    }
    RUN_TEST(csv_names_units_and_has_as_many_fields_in_every_line);
    paper_free(paper);
    return UNITY_END();
}
