/* The error map compared with theory: the error of a wrong inductance, deviations that must have no
 * effect, and the values of a point that lost its lock; and the judgement, with points made by hand. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/map.h"
#include "unity.h"

#define POINTS_MAX 600u

static map_setup_t setup;
static map_point_t points[POINTS_MAX];
static map_error_t why;

void setUp(void)
{
    setup = map_setup_default();
    setup.settle = 1.5;
    setup.window = 1.0;
    setup.turns = 1.0;
    setup.columns[MAP_ADAPTATION_ON] = false;
    memset(points, 0, sizeof points);
    memset(&why, 0, sizeof why);
}

static void only(double rpm, double load)
{
    setup.speeds[0] = rpm;
    setup.speed_count = 1;
    setup.loads[0] = load;
    setup.load_count = 1;
}

/* The map has these deviations and no others. */
static void only_rows(size_t count, const map_deviation_t *kept)
{
    memset(setup.left_out, true, sizeof setup.left_out);
    for (size_t n = 0; n < count; n++) {
        setup.left_out[kept[n]] = false;
    }
}

#define ROWS(...)                                                                                            \
    only_rows(sizeof((const map_deviation_t[]){__VA_ARGS__}) / sizeof(map_deviation_t),                      \
              (const map_deviation_t[]){__VA_ARGS__})

static size_t run(unsigned threads)
{
    const size_t count = map_count(&setup);
    TEST_ASSERT_TRUE(count <= POINTS_MAX);
    TEST_ASSERT_TRUE_MESSAGE(map_run(&setup, points, threads, &why), why.text);
    return count;
}

static const map_point_t *point_of(size_t count, map_deviation_t deviation, double rpm, double load,
                                   map_adaptation_t adaptation)
{
    const map_point_t *found = map_find(points, count, deviation, rpm, load, adaptation);
    TEST_ASSERT_NOT_NULL_MESSAGE(found, "no such point");
    return found;
}

static const map_point_t *point(size_t count, map_deviation_t deviation, double rpm, double load)
{
    return point_of(count, deviation, rpm, load, MAP_ADAPTATION_OFF);
}

static void expect_within(double limit, double expected, double value, const char *what)
{
    char text[120];
    snprintf(text, sizeof text, "%s: %.4f, expected %.4f within %g", what, value, expected, limit);
    TEST_ASSERT_TRUE_MESSAGE(fabs(value - expected) <= limit, text);
}

/* ---- choice of the points ---- */

static void test_default_covers_every_deviation_load_column_speed_and_direction_once(void)
{
    setup = map_setup_default();
    const size_t count = map_count(&setup);
    TEST_ASSERT_EQUAL_UINT(MAP_DEVIATIONS * 2u * 2u * 5u * 2u, count);
    setup.settle = 0.0;
    setup.learn = 0.0;
    setup.window = 1e-4;
    setup.turns = 1.0;
    setup.averaged = true; /* which runs faster */
    run(2);
    for (size_t n = 0; n < count; n++) {
        const map_point_t *p = &points[n];
        TEST_ASSERT_EQUAL_PTR(p, point_of(count, p->deviation, p->rpm, p->load, p->adaptation));
        TEST_ASSERT_EQUAL_INT(n / 40u, p->deviation);
        TEST_ASSERT_EQUAL_DOUBLE(n / 20u % 2u == 0u ? 0.0 : 5.0, p->load);
        TEST_ASSERT_EQUAL_INT(n / 10u % 2u == 0u ? MAP_ADAPTATION_OFF : MAP_ADAPTATION_ON, p->adaptation);
        TEST_ASSERT_TRUE(n % 10u == 0u || p->rpm > p[-1].rpm);
    }
    TEST_ASSERT_EQUAL_DOUBLE(-1490.0, points[0].rpm);
    TEST_ASSERT_EQUAL_DOUBLE(-100.0, points[4].rpm);
    TEST_ASSERT_EQUAL_DOUBLE(100.0, points[5].rpm);
}

/* At 100 r/min, four pole pairs and 10 kHz a turn has 1500 samples; the speed is chosen so that it has
 * 0.38197 more. */
static void test_window_is_whole_electrical_periods(void)
{
    setup.window = 1.0;
    TEST_ASSERT_EQUAL_UINT32(10503u, map_window(&setup, 100.0).periods); /* 7 turns are 10502.67 samples */
    TEST_ASSERT_EQUAL_UINT32(10503u, map_window(&setup, -100.0).periods);
    /* 68 turns of 148.38 samples each; at the nominal speed a turn has 148.07. */
    TEST_ASSERT_EQUAL_UINT32(10090u, map_window(&setup, 1013.0).periods);
    setup.window = 0.25;
    TEST_ASSERT_EQUAL_UINT32(2502u, map_window(&setup, 300.0).periods); /* 5 turns of 500.38 samples */
    TEST_ASSERT_EQUAL_UINT32(15000u, map_window(&setup, 10.0).periods); /* never less than one turn */
    setup.turns = 10.0;
    TEST_ASSERT_EQUAL_UINT32(5004u, map_window(&setup, 300.0).periods); /* 10 turns of 500.38 samples */
}

/* The phases of the first samples of the turns are multiples of the fractional part of the samples per
 * turn. After N turns they leave no gap wider than 2/N (three gap theorem; with the fraction of the golden
 * section no gap is wider than 1.9/N). A turn at exactly 1000 r/min has 150 samples, and every turn would
 * sample the same angles. */
static void test_samples_of_a_window_meet_every_angle_at_any_speed(void)
{
    static const double speeds[] = {100.0, 101.0, 300.0, 500.0, 750.0, 996.7, 1000.0, 1200.0, 1500.0, 1900.0};
    enum { TURNS = 60 };
    for (size_t s = 0; s < sizeof speeds / sizeof speeds[0]; s++) {
        const double rpm = map_window(&setup, speeds[s]).rpm;
        const double samples = 60.0 / (rpm * 4.0 * 1e-4);
        bool met[TURNS / 2] = {false};
        for (int n = 0; n < TURNS; n++) {
            const double phase = n * samples - floor(n * samples);
            met[(int)(phase * TURNS / 2)] = true;
        }
        for (int n = 0; n < TURNS / 2; n++) {
            TEST_ASSERT_TRUE(met[n]);
        }
        /* The speed changes by at most 0.382 samples of a turn. */
        TEST_ASSERT_TRUE(fabs(rpm / speeds[s] - 1.0) <= 0.382001 / samples);
        TEST_ASSERT_EQUAL_DOUBLE(-rpm, map_window(&setup, -speeds[s]).rpm);
    }
}

/* ---- measurements ---- */

/* By the torque balance i_q is (load + 1.32 N m)/(1.5 p psi_f), p = 4, psi_f = 0.183 Wb, against the
 * direction of rotation (friction and load are passive). The measured values are means over a second,
 * after the speed control has settled within 1e-3. */
static double i_q_of(double rpm, double load)
{
    return (rpm < 0.0 ? -1.0 : 1.0) * (load + 1.32) / (1.5 * 4.0 * 0.183);
}

/* The equation is exact in steady state. With i_d = 0 in the estimated frame, sin(error) = -dL i/psi_f,
 * where i is the length of the current. Its part across the true EMF is i cos(error) = i_q, so that
 * tan(error) = -dL i_q/(psi_f cos^2(error)). The estimator's own error adds at most 0.3 mrad, or 0.5 mrad
 * at its peak, because a ripple has no peak of ten times its deviation. */
static void test_wrong_inductance_turns_the_angle_as_theory_says(void)
{
    setup.ideal = true;
    setup.averaged = true; /* with gate edges the ripple shifts the sampled i_q relative to the mean torque */
    setup.speed_count = 2;
    setup.speeds[0] = 100.0;
    setup.speeds[1] = 1490.0;
    const size_t count = run(2);
    for (size_t n = 0; n < count; n++) {
        const map_point_t *p = &points[n];
        TEST_ASSERT_TRUE(p->locked);
        const double turned = 1e-3 * p->mean_mrad;
        expect_within(0.01, i_q_of(p->rpm, p->load), p->i_q * cos(turned) - p->i_d * sin(turned), "i_q");
        expect_within(0.1, map_window(&setup, p->rpm).rpm, p->true_rpm, "speed");
        const double d_l = p->deviation == MAP_INDUCTANCE_LOW    ? -0.0025
                           : p->deviation == MAP_INDUCTANCE_HIGH ? 0.0025
                                                                 : 0.0; /* [H] 20 % of 12.5 mH */
        const double ratio = -d_l * i_q_of(p->rpm, p->load) / 0.183;
        double angle = atan(ratio);
        for (int k = 0; k < 20; k++) {
            angle = atan(ratio / (cos(angle) * cos(angle)));
        }
        expect_within(0.2, 1e3 * angle, p->theory_mrad, "theory");
        expect_within(0.3, 1e3 * angle, p->mean_mrad, map_deviation_name(p->deviation));
        const double swing = p->peak_mrad - fabs(p->mean_mrad);
        TEST_ASSERT_TRUE(swing > 0.0 && swing < 10.0 * p->sd_mrad && p->sd_mrad < p->peak_mrad);
        TEST_ASSERT_TRUE(p->deviation != MAP_NOMINAL || p->peak_mrad <= 0.5);
    }
    for (map_claim_t claim = 0; claim < MAP_CLAIM_LEARNT; claim++) {
        const map_verdict_t verdict = map_judge(points, count, claim);
        TEST_ASSERT_TRUE(verdict.met);
        TEST_ASSERT_EQUAL_UINT(claim == MAP_CLAIM_INDUCTANCE ? 16u : 32u, verdict.judged);
    }
}

/* A deviation that does not change the mean still changes the noise: no two deviations may have equal
 * bits. */
static void test_every_deviation_reaches_the_drive(void)
{
    only(307.0, 0.0);
    setup.settle = 0.0;
    setup.window = 0.1;
    const size_t count = run(2);
    for (size_t a = 0; a < count; a++) {
        for (size_t b = 0; b < a; b++) {
            TEST_ASSERT_TRUE_MESSAGE(points[a].mean_mrad != points[b].mean_mrad,
                                     map_deviation_name(points[a].deviation));
        }
    }
}

/* 10 N m and the friction need 10.3 A, and the limit is 10 A: the rotor slows down and the lock is lost. A
 * lack of 0.34 N m at 0.0636 kg m^2 decelerates by 51 r/min per second, about 100 r/min up to the middle
 * of the window. */
static void test_overloaded_point_is_not_locked_and_has_numbers(void)
{
    only(300.0, 10.0);
    ROWS(MAP_NOMINAL, MAP_FLUX_LOW, MAP_INDUCTANCE_LOW);
    const size_t count = run(2);
    for (size_t n = 0; n < count; n++) {
        const map_point_t *p = &points[n];
        TEST_ASSERT_FALSE(p->locked);
        TEST_ASSERT_TRUE(isnan(p->theory_mrad));
        TEST_ASSERT_TRUE(isfinite(p->mean_mrad) && isfinite(p->sd_mrad) && isfinite(p->peak_mrad));
        TEST_ASSERT_TRUE(fabs(p->true_rpm) < 285.0 || p->fault != 0);
    }
    for (map_claim_t claim = 0; claim < MAP_CLAIMS; claim++) {
        TEST_ASSERT_FALSE(map_judge(points, count, claim).met);
    }
}

/* 20 % of L shift the angle by -asin(dL i/psi_f) = 79 mrad at 5 N m. With the adaptation the drive learns
 * L within 3 %, which leaves at most 12 mrad. Without it the assumed L does not change. */
static void test_adaptation_takes_away_what_a_wrong_inductance_does(void)
{
    only(300.0, 5.0);
    ROWS(MAP_NOMINAL, MAP_INDUCTANCE_LOW, MAP_INDUCTANCE_HIGH);
    setup.columns[MAP_ADAPTATION_ON] = true;
    const size_t count = run(2);
    for (int direction = -1; direction <= 1; direction += 2) {
        const double rpm = 300.0 * direction;
        for (map_deviation_t d = MAP_INDUCTANCE_LOW; d <= MAP_INDUCTANCE_HIGH; d++) {
            const map_point_t *off = point_of(count, d, rpm, 5.0, MAP_ADAPTATION_OFF);
            const map_point_t *on = point_of(count, d, rpm, 5.0, MAP_ADAPTATION_ON);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, d == MAP_INDUCTANCE_LOW ? 0.010 : 0.015, off->inductance);
            expect_within(0.03 * 0.0125, 0.0125, on->inductance, "L as learnt");
            TEST_ASSERT_TRUE(fabs(off->mean_mrad) > 70.0 && fabs(on->mean_mrad) < 12.0);
            TEST_ASSERT_TRUE(on->confidence > 0.9 && off->confidence < 0.9);
        }
    }
    const map_verdict_t learnt = map_judge(points, count, MAP_CLAIM_LEARNT);
    TEST_ASSERT_EQUAL_UINT(4u, learnt.judged);
    TEST_ASSERT_TRUE(learnt.met);
    TEST_ASSERT_TRUE(map_judge(points, count, MAP_CLAIM_INDUCTANCE).met);
}

/* ---- the map of a scenario ---- */

static scenario_t *scenario(const char *text)
{
    scenario_error_t error;
    scenario_t *made = scenario_read_text("my.toml", text, strlen(text), &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(made, error.message);
    return made;
}

#define HEAD "schema = 1\ntitle = \"t\"\n[run]\nduration = \"1 s\"\n"

static void test_scenario_gives_its_speeds_and_loads_once_each(void)
{
    scenario_t *of = scenario(HEAD "[requests]\nspeed_request = \"-500 r/min\"\n[[at]]\ntime = \"0.2 s\"\n"
                                   "requests.speed_request = \"300 r/min\"\nplant.load_torque = 3\n[[at]]\n"
                                   "time = \"0.4 s\"\nrequests.speed_request = \"500 r/min\"\n[[at]]\n"
                                   "time = \"0.5 s\"\nrequests.speed_request = 0\n");
    scenario_error_t error;
    setup.speed_count = 0;
    TEST_ASSERT_TRUE(map_of_scenario(&setup, of, &error));
    TEST_ASSERT_EQUAL_UINT(2u, setup.speed_count);
    TEST_ASSERT_EQUAL_DOUBLE(300.0, setup.speeds[0]);
    TEST_ASSERT_EQUAL_DOUBLE(500.0, setup.speeds[1]);
    TEST_ASSERT_EQUAL_UINT(2u, setup.load_count);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, setup.loads[0]);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, setup.loads[1]);
    setup.speeds[0] = 700.0; /* speeds that the user gives are kept */
    setup.speed_count = 1;
    TEST_ASSERT_TRUE(map_of_scenario(&setup, of, &error));
    TEST_ASSERT_EQUAL_UINT(1u, setup.speed_count);
    TEST_ASSERT_EQUAL_DOUBLE(700.0, setup.speeds[0]);
    scenario_free(of);
}

static void expect_no_map(const char *text, uint32_t line, const char *name, const char *message)
{
    scenario_error_t error;
    scenario_t *of = scenario(text);
    setup.speed_count = 0;
    TEST_ASSERT_FALSE(map_of_scenario(&setup, of, &error));
    TEST_ASSERT_EQUAL_STRING("my.toml", error.file);
    TEST_ASSERT_EQUAL_UINT32(line, error.place.line);
    TEST_ASSERT_EQUAL_STRING(name, error.name);
    TEST_ASSERT_TRUE_MESSAGE(strstr(error.message, message) != NULL, error.message);
    scenario_free(of);
}

static void test_scenario_of_which_there_is_no_map_is_refused_with_its_line(void)
{
    expect_no_map(HEAD "[requests]\nenable = \"on\"\n", 0u, "speed_request", "other than 0");
    expect_no_map(HEAD "[requests]\nspeed_request = \"9 r/min\"\n", 6u, "speed_request",
                  "9 r/min; a map accepts 10 r/min or more");
    expect_no_map(HEAD
                  "[requests]\nspeed_request = 50\n[[at]]\ntime = 0.1\nplant.load_torque = 1\n[[at]]\n"
                  "time = 0.2\nplant.load_torque = 2\n[[at]]\ntime = 0.3\nplant.load_torque = 3\n[[at]]\n"
                  "time = 0.4\nplant.load_torque = 4\n",
                  18u, "load_torque", "at most 4");
}

/* The scenario has another motor with six pole pairs: its torque balance gives 2/(1.5 x 6 x 0.05) = 4.444
 * A, and the wrong L an error of asin(0.2 x 2 mH x 4.46 A/0.05 Wb) = 35.7 mrad. */
static void test_map_of_a_scenario_is_of_its_motor_and_parameters(void)
{
    scenario_t *of = scenario(
        HEAD
        "[requests]\nspeed_request = \"600 r/min\"\n[params]\nmotor_pole_pairs = 6\nmotor_resistance = 0.5\n"
        "motor_inductance_d = 0.002\nmotor_inductance_q = 0.002\nmotor_flux_linkage = 0.05\n"
        "observer_slope = 0.16\nestimate_current_max = 25\nlow_speed_current = 0\nmotor_inertia = 0.01\n"
        "[plant]\npole_pairs = 6\nresistance = 0.5\ninductance_d = 0.002\ninductance_q = 0.002\n"
        "flux_linkage = 0.05\ninertia = 0.01\nfriction_coulomb = 0\nload_torque = 2\n[rig]\n"
        "fidelity = \"averaged\"\n");
    scenario_error_t error;
    setup.speed_count = 0;
    TEST_ASSERT_TRUE(map_of_scenario(&setup, of, &error));
    TEST_ASSERT_EQUAL_UINT(MAP_DEVIATIONS * 2u, map_count(&setup));
    ROWS(MAP_NOMINAL, MAP_INDUCTANCE_HIGH);
    const size_t count = run(2);
    for (int direction = -1; direction <= 1; direction += 2) {
        const map_point_t *nominal = point(count, MAP_NOMINAL, 600.0 * direction, 2.0);
        const map_point_t *high = point(count, MAP_INDUCTANCE_HIGH, 600.0 * direction, 2.0);
        TEST_ASSERT_TRUE(nominal->locked && high->locked);
        expect_within(0.03, 4.444 * direction, nominal->i_q, "i_q");
        expect_within(0.5, -35.6 * direction, high->theory_mrad, "theory");
        expect_within(2.0, nominal->mean_mrad - 35.6 * direction, high->mean_mrad, "mean");
    }
    setup.scenario = NULL;
    scenario_free(of);
}

/* ---- judgement, on points made by hand ---- */

static size_t made(double nominal, double resistance, double inductance, double theory)
{
    const map_point_t one[] = {
        {.rpm = 100.0, .deviation = MAP_NOMINAL, .mean_mrad = nominal, .locked = true},
        /* a point at another speed, which must not be used. */
        {.rpm = -100.0, .deviation = MAP_NOMINAL, .mean_mrad = 50.0, .locked = true},
        {.rpm = 100.0, .deviation = MAP_RESISTANCE_LOW, .mean_mrad = resistance, .locked = true},
        {.rpm = 100.0,
         .deviation = MAP_INDUCTANCE_HIGH,
         .mean_mrad = inductance,
         .theory_mrad = theory,
         .locked = true},
        /* Theory makes no claim about this deviation. */
        {.rpm = 100.0, .deviation = MAP_NOISE, .mean_mrad = 70.0, .locked = true},
    };
    memcpy(points, one, sizeof one);
    return sizeof one / sizeof one[0];
}

static void expect_verdict(bool met, size_t count, map_claim_t claim, double worst, size_t judged,
                           size_t lost)
{
    const map_verdict_t verdict = map_judge(points, count, claim);
    TEST_ASSERT_EQUAL_INT(met, verdict.met);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, worst, verdict.worst_mrad);
    TEST_ASSERT_EQUAL_UINT(judged, verdict.judged);
    TEST_ASSERT_EQUAL_UINT(lost, verdict.lost);
    TEST_ASSERT_TRUE((verdict.worst == NULL) == (judged == 0u));
}

static void test_a_claim_is_judged_against_nominal_and_theory_where_both_are_locked(void)
{
    static const struct {
        bool met;
        map_claim_t claim;
        double nominal, resistance, inductance, theory, worst;
        int lost; /* index of the point that is not locked; -1: none */
    } rows[] = {
        {true, MAP_CLAIM_NO_EFFECT, 1.0, 1.25, 0.0, 0.0, 0.25, -1},
        {true, MAP_CLAIM_NO_EFFECT, 0.0, -0.3, 0.0, 0.0, 0.3, -1}, /* at the limit */
        {false, MAP_CLAIM_NO_EFFECT, 1.0, 0.6875, 0.0, 0.0, 0.3125, -1},
        {false, MAP_CLAIM_NO_EFFECT, 0.0, 0.0, 0.0, 0.0, 0.0, 2},
        {false, MAP_CLAIM_NO_EFFECT, 0.0, 0.0, 0.0, 0.0, 0.0, 0},
        {true, MAP_CLAIM_INDUCTANCE, 0.0, 0.0, -15.0, -16.0, 1.0, -1},
        {true, MAP_CLAIM_INDUCTANCE, 3.0, 0.0, -15.0, -16.0, 2.0, -1}, /* at the limit */
        {false, MAP_CLAIM_INDUCTANCE, 0.0, 0.0, -18.25, -16.0, 2.25, -1},
        {false, MAP_CLAIM_INDUCTANCE, 2.25, 0.0, -16.0, -16.0, 2.25, -1},
        {false, MAP_CLAIM_INDUCTANCE, 0.0, 0.0, 16.0, -16.0, 32.0, -1},
        {false, MAP_CLAIM_INDUCTANCE, 0.0, 0.0, -16.0, -16.0, 0.0, 3},
        {false, MAP_CLAIM_INDUCTANCE, 0.0, 0.0, -16.0, -16.0, 0.0, 0},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const size_t count = made(rows[n].nominal, rows[n].resistance, rows[n].inductance, rows[n].theory);
        if (rows[n].lost >= 0) {
            points[rows[n].lost].locked = false;
        }
        expect_verdict(rows[n].met, count, rows[n].claim, rows[n].worst, rows[n].lost < 0, rows[n].lost >= 0);
    }
    size_t count = made(0.0, 0.0, 0.0, 0.0);
    points[0].load = 5.0; /* a nominal point at another load does not count */
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 0, 1);
    count = made(0.0, 0.0, 0.0, 0.0);
    points[4] = points[2]; /* one point is locked and one is not */
    points[4].locked = false;
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 1, 1);
}

/* A claim without its rows is not met. The error of a wrong R with an i_d, 5 mrad by theory with a
 * tolerance of a fifth, is expected. Of two points the worse one is named. */
static void test_a_claim_needs_its_rows_expects_theory_and_names_the_worst_point(void)
{
    size_t count = made(0.0, 0.0, 0.0, 0.0);
    points[2].deviation = MAP_NOISE;
    points[3].deviation = MAP_OFFSET;
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 0, 0);
    expect_verdict(false, count, MAP_CLAIM_INDUCTANCE, 0.0, 0, 0);
    TEST_ASSERT_TRUE(map_judge(points, count, MAP_CLAIM_INDUCTANCE).silent);
    count = made(1.0, 7.25, 0.0, 0.0);
    points[2].theory_mrad = 5.0;
    expect_verdict(true, count, MAP_CLAIM_NO_EFFECT, 0.25, 1, 0);
    points[2].mean_mrad = 1.0; /* the expected error does not appear */
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 4.0, 1, 0);
    count = made(0.0, 0.1, 0.0, 0.0);
    points[4] = points[2];
    points[4].deviation = MAP_FLUX_HIGH;
    points[4].mean_mrad = -0.2;
    TEST_ASSERT_EQUAL_PTR(&points[4], map_judge(points, count, MAP_CLAIM_NO_EFFECT).worst);
    points[4].mean_mrad = -0.05;
    TEST_ASSERT_EQUAL_PTR(&points[2], map_judge(points, count, MAP_CLAIM_NO_EFFECT).worst);
}

static void test_learnt_is_judged_against_nominal_where_the_drive_is_sure(void)
{
    const size_t count = made(1.0, 0.0, -15.0, -16.0);
    expect_verdict(false, count, MAP_CLAIM_LEARNT, 0.0, 0, 0);
    for (size_t n = 0; n < count; n++) {
        points[n].adaptation = MAP_ADAPTATION_ON;
    }
    expect_verdict(false, count, MAP_CLAIM_LEARNT, 0.0, 0, 0); /* L was not learnt reliably: no claim */
    points[3].confidence = 0.95;
    expect_verdict(false, count, MAP_CLAIM_LEARNT, 16.0, 1, 0);
    points[3].mean_mrad = -0.5;
    expect_verdict(true, count, MAP_CLAIM_LEARNT, 1.5, 1, 0);
    points[0].adaptation = MAP_ADAPTATION_OFF; /* a nominal point of the other column does not count */
    expect_verdict(false, count, MAP_CLAIM_LEARNT, 0.0, 0, 1);
    expect_verdict(false, count, MAP_CLAIM_NO_EFFECT, 0.0, 0, 0);
}
