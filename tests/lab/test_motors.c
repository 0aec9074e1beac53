/* Motors in the form of data sheets, the parameters that `lagless tune` computes, and [motor] and
 * [[profile]] in a scenario. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "estimator/chosen.h"
#include "host_sim/lab/motor.h"
#include "host_sim/lab/runner.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/tune.h"
#include "settings/params.h" /* position_source_t */
#include "tests/rig/seed.h"
#include "unity.h"

#define PI 3.14159265358979323846

/* The messages of a scenario with a motor that is too salient for the estimator, and with one on an
 * encoder. */
#define TOO_SALIENT "[params]\nmotor_inductance_d = 0.0125\nmtpa = \"off\"\n"
#define ON_ENCODER  "position_source = \"encoder\"\nfield_weakening = \"off\"\n"

static scenario_error_t error;
static motor_sheet_t sheet;
static motor_t motor;
static tune_t tune;

/* Makes a sheet from texts "key=value"; NULL ends the list. */
static bool given(const char *const *assignments)
{
    sheet = (motor_sheet_t){.name = "test"};
    for (; *assignments != NULL; assignments++) {
        if (!motor_override(&sheet, *assignments, &error)) {
            return false;
        }
    }
    return motor_make(&sheet, &motor, &error);
}

#define GIVEN(...) given((const char *const[]){__VA_ARGS__, NULL})
#define USUAL      "pole_pairs=4", "resistance=1 ohm", "inductance=5 mH", "rated_current_peak=5 A"

/* ---- the sheet ---- */

static void test_every_form_of_the_flux_gives_the_same_motor(void)
{
    /* psi_f = 0.1 Wb and p = 4. The peak EMF of a phase is 0.4 V s/rad, that is 41.888 V at 1000 r/min and
     * 72.552 V between lines; K_t is 0.6 N m/A (peak current), and 2 pi 0.1 V/Hz. With block commutation
     * through two phases the mean EMF is 3/pi of the peak between lines: 0.66160 N m/A, or V s/rad, which
     * is 14.434 rpm/V. */
    static const char *const ways[] = {"flux_linkage=0.1 Wb",
                                       "flux_volts_per_hertz=0.6283185 V/Hz",
                                       "ke_line_peak=72.5520 V/krpm",
                                       "ke_line_rms=51.3020 V/krpm",
                                       "ke_phase_peak=41.8879 V/krpm",
                                       "ke_phase_rms=29.6192 V/krpm",
                                       "kt_peak=0.6 N m/A",
                                       "kt_rms=848.528 mN m/A",
                                       "kt_block=0.661595 N m/A",
                                       "speed_constant_block=14.4339 rpm/V"};
    for (size_t n = 0; n < sizeof ways / sizeof ways[0]; n++) {
        TEST_ASSERT_TRUE_MESSAGE(GIVEN(USUAL, ways[n]), error.message);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6, 0.1, motor.value[MOTOR_FLUX], ways[n]);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6, 0.1, motor_given(&sheet, MOTOR_FLUX), ways[n]);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.6, motor_torque_constant(&motor));
    }
}

static void test_lines_are_twice_a_phase_and_poles_twice_the_pairs(void)
{
    TEST_ASSERT_TRUE(GIVEN("poles=8", "resistance_line=2 ohm", "inductance_line=10 mH",
                           "rated_current_rms=2 A", "flux_linkage=0.1"));
    TEST_ASSERT_EQUAL_DOUBLE(4.0, motor.value[MOTOR_POLE_PAIRS]);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, motor.value[MOTOR_RESISTANCE]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 5e-3, motor.value[MOTOR_INDUCTANCE_D]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 5e-3, motor.value[MOTOR_INDUCTANCE_Q]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.828427, motor.value[MOTOR_CURRENT]);
    TEST_ASSERT_TRUE(GIVEN(USUAL, "flux_linkage=0.1", "rated_current_block=1 A"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0 * sqrt(3.0) / PI, motor.value[MOTOR_CURRENT]);
}

/* Adds one more key of the flux to the given ones; --set would replace the earlier one. */
static void say_too(motor_key_t key, double value)
{
    sheet.has[key] = true;
    sheet.value[key] = value;
    TEST_ASSERT_TRUE_MESSAGE(motor_make(&sheet, &motor, &error), error.message);
}

static void test_a_contradiction_is_reported_with_both_numbers(void)
{
    TEST_ASSERT_TRUE(GIVEN(USUAL, "ke_line_peak=72.552 V/krpm", "inertia=1e-3"));
    say_too(MOTOR_KEY_kt_rms, 0.87);
    TEST_ASSERT_EQUAL_UINT32(0u, motor.note_count); /* a difference of 2.5 % counts as rounding */
    say_too(MOTOR_KEY_kt_rms, 0.6);
    TEST_ASSERT_EQUAL_UINT32(1u, motor.note_count);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.1, motor.value[MOTOR_FLUX]);
    TEST_ASSERT_NOT_NULL(strstr(motor.notes[0], "100 mWb"));
    TEST_ASSERT_NOT_NULL(strstr(motor.notes[0], "70.71 mWb"));
    TEST_ASSERT_NOT_NULL(strstr(motor.notes[0], "29 % less; ke_line_peak is used"));
    TEST_ASSERT_TRUE(GIVEN(USUAL, "flux_linkage=0.1", "rated_torque=4.3 N m", "inertia=1e-3"));
    TEST_ASSERT_EQUAL_UINT32(1u, motor.note_count); /* 5 A make 3 N m */
    TEST_ASSERT_NOT_NULL(strstr(motor.notes[0], "= 3 N m"));
}

static void test_what_is_missing_is_named_and_nothing_is_reported_twice(void)
{
    TEST_ASSERT_FALSE(GIVEN("pole_pairs=4", "inductance_d=1 mH"));
    const char *const missing[] = {"resistance or resistance_line", "inductance_q", "rated_current_peak",
                                   "flux_linkage, a ke_... or a kt_..."};
    for (size_t n = 0; n < sizeof missing / sizeof missing[0]; n++) {
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.message, missing[n]), error.message);
    }
    TEST_ASSERT_NULL(strstr(error.message, "pole"));
    TEST_ASSERT_FALSE(
        GIVEN("poles=7", "resistance=1", "inductance=5e-3", "rated_current_peak=5", "flux_linkage=0.1"));
    TEST_ASSERT_NOT_NULL(strstr(error.message, "even"));
    TEST_ASSERT_FALSE(GIVEN(USUAL, "resistence=1 ohm"));
    TEST_ASSERT_NOT_NULL(strstr(error.message, "nearest: resistance"));
    TEST_ASSERT_FALSE(GIVEN(USUAL, "inertia=3 N m"));
    TEST_ASSERT_NOT_NULL(strstr(error.message, "kg cm^2"));
    TEST_ASSERT_FALSE(GIVEN(USUAL, "encoder_lines=5"));
}

/* The rated torque, 3 N m, reaches the top speed in 0.2 s. At 1000 rad/s a current of 5 A needs 25 V
 * across the EMF and 105 V along it, together 107.935 V, half of 215.870 V. */
static void test_an_inertia_that_is_not_given_is_that_of_a_machine(void)
{
    TEST_ASSERT_TRUE(GIVEN(USUAL, "flux_linkage=0.1"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 3.0 * 0.2 / (100.0 * PI), motor.value[MOTOR_INERTIA]);
    TEST_ASSERT_TRUE(GIVEN(USUAL, "flux_linkage=0.1", "link_voltage=215.870 V"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 3.0 * 0.2 / (0.9 * 250.0), motor.value[MOTOR_INERTIA]);
    TEST_ASSERT_TRUE(GIVEN(USUAL, "flux_linkage=0.1", "link_voltage=311", "rated_speed=1500 r/min"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, 3.0 * 0.2 / (50.0 * PI), motor.value[MOTOR_INERTIA]);
    TEST_ASSERT_NOT_NULL(strstr(motor.notes[0], "reaches 1500 r/min in 0.2 s"));
}

/* rms and peak are two values of a quantity; each key is for one of them. */
static void test_arms_is_for_keys_of_rms_values(void)
{
    static const struct {
        const char *assignment;
        bool good;
    } rows[] = {
        {"rated_current_rms=3 Arms", true}, {"rated_current_rms=3 A rms", true},
        {"rated_current_rms=3 A", true},    {"rated_current_rms=3 Apk", false},
        {"rated_current_peak=3 Apk", true}, {"rated_current_peak=3 Arms", false},
        {"ke_line_rms=45 Vrms/krpm", true}, {"ke_line_peak=45 Vrms/krpm", false},
        {"ke_line_peak=45 Vpk/krpm", true}, {"kt_rms=0.5 N\xC2\xB7m/Arms", true},
        {"kt_peak=0.5 N m/Arms", false},    {"kt_rms=0.5 Nm/A", true},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        sheet = (motor_sheet_t){.name = "x"};
        TEST_ASSERT_EQUAL_MESSAGE(rows[n].good, motor_override(&sheet, rows[n].assignment, &error),
                                  rows[n].assignment);
    }
}

/* ---- tune ---- */

static double row_of(const char *name)
{
    for (uint32_t n = 0; n < tune.count; n++) {
        if (strcmp(tune.rows[n].row->name, name) == 0) {
            return tune.rows[n].value;
        }
    }
    TEST_FAIL_MESSAGE(name);
    return 0.0;
}

static bool warns_of(const char *what)
{
    for (uint32_t n = 0; n < tune.warning_count; n++) {
        if (strstr(tune.warnings[n], what) != NULL) {
            return true;
        }
    }
    return false;
}

/* The paper's motor in its test rig; the default parameters of the drive were computed by hand for it. */
static void test_the_rules_make_the_paper_s_rows(void)
{
    TEST_ASSERT_TRUE(GIVEN("pole_pairs=4", "resistance=0.95", "inductance=12.5 mH", "flux_linkage=0.183",
                           "rated_current_peak=4.55", "rated_torque=5", "rated_speed=1500 r/min",
                           "inertia=0.0636", "link_voltage=311"));
    TEST_ASSERT_TRUE_MESSAGE(tune_motor(&motor, &tune, &error), error.message);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, row_of("observer_gain"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, row_of("observer_slope"));
    TEST_ASSERT_EQUAL_DOUBLE(50.0, row_of("feedforward_cutoff"));
    TEST_ASSERT_EQUAL_DOUBLE(200.0, row_of("pll_bandwidth"));
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 220.0, row_of("overspeed_trip"));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 400.0, row_of("dc_overvoltage"));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 200.0, row_of("dc_undervoltage"));
    TEST_ASSERT_EQUAL_DOUBLE(1000.0, row_of("current_bandwidth"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, row_of("speed_ramp"));
}

static void test_a_heavier_load_slows_the_loops_and_a_lighter_one_is_warned_of(void)
{
    const char *const light[] = {USUAL, "flux_linkage=0.1", "rated_speed=2000 r/min", "inertia=2e-5", NULL};
    TEST_ASSERT_TRUE(given(light));
    TEST_ASSERT_TRUE(tune_motor(&motor, &tune, &error));
    /* Limited; 1.6 sqrt(4 x 3/2e-5) would be 1239. */
    TEST_ASSERT_EQUAL_DOUBLE(250.0, row_of("feedforward_cutoff"));
    TEST_ASSERT_TRUE(row_of("speed_ramp") > 0.0);
    /* 209 rad/s x 2e-5/3 N m = 1.4 ms, compared with 14/1000 s. */
    TEST_ASSERT_TRUE(warns_of("within 1.4 ms, before the speed control reacts (14 ms)"));
    TEST_ASSERT_TRUE(motor_override(&sheet, "load_inertia=1e-2", &error) &&
                     motor_make(&sheet, &motor, &error));
    TEST_ASSERT_TRUE(tune_motor(&motor, &tune, &error));
    TEST_ASSERT_EQUAL_DOUBLE(55.0, row_of("feedforward_cutoff")); /* 1.6 sqrt(4 x 3/0.01002) = 55.4 */
    TEST_ASSERT_FALSE(warns_of("within"));
}

static void test_an_impossible_motor_is_reported_with_numbers(void)
{
    TEST_ASSERT_TRUE(GIVEN("pole_pairs=7", "resistance=35 mohm", "inductance=85 uH", "ke_line_rms=4",
                           "rated_current_rms=14", "link_voltage=48", "inertia=1e-4"));
    TEST_ASSERT_TRUE_MESSAGE(tune_motor(&motor, &tune, &error), error.message);
    /* The ripple is 48 V x 100 us/(6 x 85 uH) = 9.41 A. */
    TEST_ASSERT_TRUE(warns_of("85 uH at 10 kHz and a link of 48 V: the current ripple is 9.41 A"));
    TEST_ASSERT_TRUE(warns_of("rated current 19.8 A peak"));
    TEST_ASSERT_DOUBLE_WITHIN(0.001, fmin(0.6 * 9.412, 0.5 * row_of("current_limit")),
                              row_of("low_speed_current"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, row_of("current_judged"));
    /* The EMF is 0.1 x 4 x 523.6 = 209 V; a link of 311 V gives at most 180 V per phase. */
    TEST_ASSERT_TRUE(GIVEN(USUAL, "flux_linkage=0.1", "rated_speed=5000 r/min", "inertia=1e-3"));
    TEST_ASSERT_TRUE(tune_motor(&motor, &tune, &error));
    TEST_ASSERT_TRUE(warns_of("at 5000 r/min the EMF is 209.4 V"));
    TEST_ASSERT_TRUE(tune.speed_top < 5000.0 * PI / 30.0);
    /* With the link voltage that the warning names the motor reaches its speed. */
    const char *at = strstr(tune.warnings[0], "r/min; a link of ");
    TEST_ASSERT_NOT_NULL(at);
    char link[64];
    snprintf(link, sizeof link, "link_voltage=%.0f", strtod(at + 17, NULL));
    if (strtod(at + 17, NULL) < 390.0) {
        TEST_ASSERT_TRUE(motor_override(&sheet, link, &error) && motor_make(&sheet, &motor, &error));
        TEST_ASSERT_TRUE(tune_motor(&motor, &tune, &error));
        TEST_ASSERT_FALSE(warns_of("top speed"));
    }
    TEST_ASSERT_TRUE(GIVEN("pole_pairs=4", "resistance=10 ohm", "inductance=1 mH", "flux_linkage=0.1",
                           "rated_current_peak=1", "inertia=1e-4"));
    TEST_ASSERT_FALSE(tune_motor(&motor, &tune, &error)); /* L/R is 0.1 ms */
    /* The message names a sufficient inductance: 2 x 100 us x 10 ohm = 2 mH. */
    TEST_ASSERT_NOT_NULL(strstr(error.message, "2 mH at least"));
}

/* The drive never refuses the parameters of `lagless tune`. Motors are drawn at random over the whole
 * range of the table: either tune refuses the motor, or the drive accepts its parameters, which this test
 * checks again. */
static uint32_t state = 1u;
static double drawn(double low, double high)
{
    state = state * 1664525u + 1013904223u;
    return low * pow(high / low, (double)(state >> 8) / 16777216.0);
}

static void test_the_drive_accepts_the_rows_of_every_motor_that_has_some(void)
{
    uint32_t with_rows = 0u;
    for (int n = 0; n < 400; n++) {
        sheet = (motor_sheet_t){.name = "drawn"};
        const struct {
            motor_key_t key;
            double value;
        } draws[] = {{MOTOR_KEY_pole_pairs, floor(drawn(1.0, 20.99))},
                     {MOTOR_KEY_resistance, drawn(0.01, 20.0)},
                     {MOTOR_KEY_inductance_d, drawn(5e-5, 0.1)},
                     {MOTOR_KEY_flux_linkage, drawn(2e-3, 1.0)},
                     {MOTOR_KEY_rated_current_peak, drawn(0.5, 50.0)},
                     {MOTOR_KEY_rated_speed, drawn(20.0, 900.0)},
                     {MOTOR_KEY_inertia, drawn(1e-6, 1.0)},
                     {MOTOR_KEY_link_voltage, drawn(12.0, 600.0)}};
        for (size_t m = 0; m < sizeof draws / sizeof draws[0]; m++) {
            sheet.has[draws[m].key] = true;
            sheet.value[draws[m].key] = draws[m].value;
        }
        sheet.has[MOTOR_KEY_inductance_q] = true;
        sheet.value[MOTOR_KEY_inductance_q] = sheet.value[MOTOR_KEY_inductance_d] * drawn(1.0, 2.0);
        TEST_ASSERT_TRUE_MESSAGE(motor_make(&sheet, &motor, &error), error.message);
        if (!tune_motor(&motor, &tune, &error)) {
            TEST_ASSERT_TRUE(error.message[0] != '\0');
            continue;
        }
        with_rows++;
        rig_t *rig = rig_create(1);
        for (uint32_t row = 0; row < tune.count; row++) {
            TEST_ASSERT_TRUE_MESSAGE(rig_set(rig, tune.rows[row].row->id, tune.rows[row].value),
                                     rig_error(rig));
            TEST_ASSERT_TRUE(tune.rows[row].reason[0] != '\0');
        }
        TEST_ASSERT_TRUE_MESSAGE(rig_apply(rig), rig_error(rig));
        rig_free(rig);
    }
    TEST_ASSERT_TRUE(with_rows > 200u);
}

/* ---- the library ---- */

static void test_the_library_has_a_dozen_published_motors_from_30_w_to_5_kw(void)
{
    char **names;
    const int count = motor_library(&names);
    double least = 1e9;
    double most = 0.0;
    TEST_ASSERT_TRUE(count >= 12);
    for (int n = 0; n < count; n++) {
        TEST_ASSERT_TRUE_MESSAGE(motor_read_library(names[n], &sheet, &error), error.message);
        TEST_ASSERT_TRUE_MESSAGE(motor_make(&sheet, &motor, &error), error.message);
        TEST_ASSERT_TRUE_MESSAGE(sheet.title[0] != '\0' && strlen(sheet.source) > 30u, names[n]);
        TEST_ASSERT_TRUE_MESSAGE(motor.has[MOTOR_INERTIA], names[n]);
        TEST_ASSERT_TRUE_MESSAGE(tune_motor(&motor, &tune, &error), error.message);
        const double speed = motor.has[MOTOR_SPEED] ? motor.value[MOTOR_SPEED] : tune.speed_top;
        least = fmin(least, speed * motor.value[MOTOR_TORQUE]);
        most = fmax(most, speed * motor.value[MOTOR_TORQUE]);
        free(names[n]);
    }
    free(names);
    TEST_ASSERT_TRUE(least < 30.0 && most > 5000.0);
}

/* Each motor starts from each angle of the rotor at standstill; the swings of a light rotor must not be
 * reported as a fault of the sensors. The test is a grid of motors and angles.
 * tests/lab/test_tune_boards.c tests that each motor runs to its top speed under load. Of 104 starts one
 * ends in estimate_astray: a small motor whose winding has a large inductance, so that the noise of the
 * current is estimated as a speed. It does not occur with five other seeds. */
static void test_every_motor_starts_from_every_angle(void)
{
    char **names;
    const int count = motor_library(&names);
    grid_t grid = grid_of("motors, places of the rotor", 8u * (uint32_t)count);
    uint32_t runs = 0u;
    uint32_t stopped = 0u;
    for (uint32_t point; grid_next(&grid, &point);) {
        const double place = 0.41 * grid_axis(&point, 8u);
        const char *name = names[point];
        char text[400];
        TEST_ASSERT_TRUE_MESSAGE(motor_read_library(name, &sheet, &error) &&
                                     motor_make(&sheet, &motor, &error) && tune_motor(&motor, &tune, &error),
                                 error.message);
        snprintf(
            text, sizeof text,
            "schema = 1\ntitle = \"start\"\nmotor = \"%s\"\n[run]\nduration = 0.35\n%s[start]\nangle = %.3f\n"
            "[requests]\nenable = \"on\"\nspeed_request = 50\n[[expect]]\nsignal = \"fault_reason\"\n"
            "statistic = \"max\"\nat_most = 0\n",
            name, tune.needs_encoder ? "[params]\n" ON_ENCODER : "", place);
        scenario_t *scenario = scenario_read_text(name, text, strlen(text), &error);
        TEST_ASSERT_NOT_NULL_MESSAGE(scenario, error.message);
        const runner_options_t options = {.has_seed = false};
        runner_result_t result;
        TEST_ASSERT_TRUE(runner_run(scenario, &options, &result));
        snprintf(text, sizeof text, "%s from %.3f rad", name, place);
        runs++;
        if (result.fault_reason != 0) {
            printf("%s: fault %d\n", text, (int)result.fault_reason);
            stopped++;
        }
        runner_result_free(&result);
        scenario_free(scenario);
    }
    TEST_ASSERT_TRUE_MESSAGE(stopped <= 1u + runs / 50u, "starts that end in a fault");
    for (int n = 0; n < count; n++) {
        free(names[n]);
    }
    free(names);
}

/* ---- [motor] and [[profile]] ---- */

#define HEAD "schema = 1\ntitle = \"t\"\n[run]\nduration = \"0.1 s\"\n"

static scenario_t *read_text(const char *text)
{
    return scenario_read_text("test.toml", text, strlen(text), &error);
}

static double initial(const scenario_t *scenario, const char *name)
{
    return scenario_initial(scenario, scenario_row(name, &error));
}

static void test_a_motor_fills_params_and_plant_and_both_count_over_it(void)
{
    scenario_t *scenario =
        read_text(HEAD "[params]\nmotor_resistance = 1.5\n[motor]\nname = \"estun-emj-04apb22\"\n"
                       "load_inertia = \"2 kg cm^2\"\n[plant]\nfriction_coulomb = 0.25\n");
    TEST_ASSERT_NOT_NULL_MESSAGE(scenario, error.message);
    TEST_ASSERT_EQUAL_DOUBLE(1.5, initial(scenario, "motor_resistance"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.62656, initial(scenario, "plant.resistance"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.060145, initial(scenario, "motor_flux_linkage")); /* 0.377903/(2 pi) */
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.060145, initial(scenario, "plant.flux_linkage"));
    /* Inertia of rotor and load. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.310002e-4, initial(scenario, "motor_inertia"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 3.10002e-5, initial(scenario, "plant.inertia"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 2e-4, initial(scenario, "plant.load_inertia"));
    TEST_ASSERT_EQUAL_DOUBLE(0.25, initial(scenario, "plant.friction_coulomb"));
    scenario_free(scenario);
    /* Every parameter has the value that tune computes. */
    const bool encoder = CHOSEN_SALIENT_MAX < 1.42f;
    scenario = read_text(encoder ? "motor = \"awan-2kw2-ipm\"\n" HEAD "[params]\n" ON_ENCODER
                                 : "motor = \"awan-2kw2-ipm\"\n" HEAD);
    TEST_ASSERT_NOT_NULL(scenario);
    TEST_ASSERT_TRUE(motor_read_library("awan-2kw2-ipm", &sheet, &error) &&
                     motor_make(&sheet, &motor, &error) && tune_motor(&motor, &tune, &error));
    for (uint32_t n = 0; n < tune.count; n++) {
        TEST_ASSERT_EQUAL_DOUBLE((double)(float)tune.rows[n].value,
                                 scenario_initial(scenario, tune.rows[n].row));
    }
    scenario_free(scenario);
}

/* L_q of 51 mH is 4.08 times 12.5 mH: the drive names both rows, their values and what to do, and [motor]
 * does not select an encoder by itself. With an encoder the same motor is accepted. */
static void test_a_motor_too_salient_without_encoder_is_refused_with_both_rows(void)
{
    static const char *const told[] = {"0.051 H: accepted",
                                       "motor_inductance_q <= " CHOSEN_SALIENT " motor_inductance_d",
                                       "motor_inductance_d = 0.0125 H", "use an encoder"};
    TEST_ASSERT_NULL(read_text("motor = \"awan-2kw2-ipm\"\n" HEAD TOO_SALIENT));
    TEST_ASSERT_EQUAL_STRING("motor_inductance_q", error.name);
    for (size_t n = 0; n < sizeof told / sizeof told[0]; n++) {
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.message, told[n]), error.message);
    }
    scenario_t *scenario = read_text("motor = \"awan-2kw2-ipm\"\n" HEAD TOO_SALIENT ON_ENCODER);
    TEST_ASSERT_NOT_NULL_MESSAGE(scenario, error.message);
    scenario_free(scenario);
}

/* Up to the largest ratio that the estimator accepts tune selects no encoder; beyond it tune selects one
 * and reports this. */
static void test_tune_takes_an_encoder_for_a_motor_too_salient(void)
{
    static const double shares[] = {0.99, 1.01, 1.5};
    for (size_t n = 0; n < sizeof shares / sizeof shares[0]; n++) {
        char inductance_q[40];
        snprintf(inductance_q, sizeof inductance_q, "inductance_q=%.6g mH",
                 5.0 * shares[n] * (double)CHOSEN_SALIENT_MAX);
        TEST_ASSERT_TRUE_MESSAGE(GIVEN("pole_pairs=4", "resistance=1 ohm", "inductance_d=5 mH",
                                       "rated_current_peak=5 A", "flux_linkage=0.1", "rated_speed=1500 r/min",
                                       "inertia=1e-3", inductance_q),
                                 error.message);
        TEST_ASSERT_TRUE_MESSAGE(tune_motor(&motor, &tune, &error), error.message);
        const bool encoder = shares[n] > 1.0;
        TEST_ASSERT_EQUAL_DOUBLE(encoder ? POSITION_ENCODER : POSITION_SENSORLESS, row_of("position_source"));
        TEST_ASSERT_TRUE(warns_of("position_source is set to encoder") == encoder);
    }
}

/* The value of a row at a time, in a run with this profile. */
static double at_time(const char *profile, double time)
{
    char text[900];
    runner_result_t result;
    const runner_options_t options = {.has_seed = false};
    snprintf(text, sizeof text,
             HEAD
             "%s[[expect]]\nsignal = \"plant.load_torque\"\nstatistic = \"mean\"\nfrom = %.6g\nto = %.6g\n"
             "at_least = -1000\n",
             profile, time, time + 1e-4);
    scenario_t *scenario = read_text(text);
    TEST_ASSERT_NOT_NULL_MESSAGE(scenario, error.message);
    TEST_ASSERT_TRUE(runner_run(scenario, &options, &result));
    const double value = result.verdicts[0].value;
    runner_result_free(&result);
    scenario_free(scenario);
    return value;
}

static void test_a_profile_goes_from_point_to_point(void)
{
    const char *const linear =
        "[[profile]]\nrow = \"plant.load_torque\"\npoints = [[0.01, \"1 N m\"], [\"30 ms\", 5], "
        "[0.05, 5], [0.05, 2], [0.09, 0]]\n";
    const char *const steps =
        "[[profile]]\nrow = \"load_torque\"\nshape = \"steps\"\npoints = [[0, 1], [0.03, 5], "
        "[0.05, 2]]\n";
    static const struct {
        double time, linear, steps;
    } course[] = {{0.005, 0.0, 1.0},   {0.0101, 1.0, 1.0}, {0.02, 3.0, 1.0},
                  {0.0299, 4.98, 1.0}, {0.0301, 5.0, 5.0}, {0.045, 5.0, 5.0},
                  {0.0501, 2.0, 2.0},  {0.07, 1.0, 2.0},   {0.095, 0.0, 2.0}};
    for (size_t n = 0; n < sizeof course / sizeof course[0]; n++) {
        /* The limit is the change in one period of a ramp of 200 N m/s. */
        TEST_ASSERT_DOUBLE_WITHIN(0.025, course[n].linear, at_time(linear, course[n].time));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, course[n].steps, at_time(steps, course[n].time));
    }
}

static void test_an_invalid_motor_or_profile_is_refused_with_its_place(void)
{
#define ROW HEAD "[[profile]]\nrow = \"load_torque\"\n"
    static const struct {
        const char *text, *says;
        uint32_t line;
    } wrong[] = {
        {HEAD "[motor]\nname = \"teknik\"\n", "`lagless motors`", 5u},
        {"motor = \"liu\"\n" HEAD, "nearest: liu-2019", 1u},
        {HEAD "[motor]\nname = \"liu-2019\"\nfile = \"a.toml\"\n", "one of the two", 7u},
        {HEAD "[motor]\nfile = \"no_such_motor.toml\"\n", "no_such_motor.toml", 6u},
        {HEAD "[motor]\npole_pairs = 4\nresistance = \"1 H\"\n", "ohm", 7u},
        {HEAD "[motor]\npole_pairs = 4\nresistanc = 1\n", "nearest: resistance", 7u},
        {HEAD "[motor]\npole_pairs = 4\nrated_speed_rpm = 3000\n", "rated_speed = \"NUMBER rpm\"", 7u},
        {HEAD "[motor]\npole_pairs = 4\nresistance_line_mohm = 3000\n", "resistance_line = \"NUMBER mohm\"",
         7u},
        {HEAD "[motor]\npole_pairs = 4\nrated_speed_max = 3000\n", "lists them", 7u},
        {HEAD "[motor]\npole_pairs = 4\n", "missing: resistance", 5u},
        {HEAD "[motor]\nname = \"liu-2019\"\nresistance = \"90 ohm\"\n", "311 V is too low: R I at ", 5u},
        {HEAD "motor = 4\n", "no such key", 5u},
        {"motor = 4\n" HEAD, "a table", 1u},
        {HEAD "[[profile]]\npoints = [[0, 1]]\n", "row", 5u},
        {ROW, "points", 5u},
        {HEAD "[[profile]]\nrow = \"load_torqe\"\npoints = [[0, 1]]\n", "nearest: load_torque", 6u},
        {HEAD "[[profile]]\nrow = \"i_q\"\npoints = [[0, 1]]\n", "can be read, not set", 6u},
        {ROW "points = [[0, 1], [0.02]]\n", "a time and a value", 7u},
        {ROW "points = [[0.05, 1], [0.02, 2]]\n", "do not decrease", 7u},
        {ROW "points = [[0, 1], [0.2, 2]]\n", "points: 200 ms is outside", 7u},
        {ROW "points = [[0, \"1 V\"]]\n", "N m", 7u},
        {ROW "points = [[0, -1e6]]\n", "outside its range", 7u},
        {HEAD "[[profile]]\nrow = \"enable\"\npoints = [[0, \"on\"]]\n", "steps", 6u},
        {ROW "shape = \"cubic\"\npoints = [[0, 1]]\n", "linear, steps", 7u},
    };
    for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
        TEST_ASSERT_NULL_MESSAGE(read_text(wrong[n].text), wrong[n].text);
        char whole[800];
        snprintf(whole, sizeof whole, "%.90s: %.640s", error.name, error.message);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(whole, wrong[n].says), whole);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(wrong[n].line, error.place.line, wrong[n].text);
        TEST_ASSERT_TRUE(error.name[0] != '\0');
    }
}
