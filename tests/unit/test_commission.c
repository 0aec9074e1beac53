/* The steps of commissioning, with expected values from algebra. The inputs are: an exact winding in
 * double precision, i(k+1) = a i(k) + b u(k), a = exp(-R T/L), b = (1 - a)/R, driven by voltages that act
 * from t_k+1 to t_k+2; matrices of wirings that follow from their maps; torques that follow from J and
 * friction. */
#include <complex.h>
#include <math.h>
#include <string.h>
#include <unity.h>

#include "fast/control/excite.h"
#include "tests/unit/commission_bench.h"

typedef struct {
    double a, b;
    double complex current, acts, next; /* [A], [V] */
} winding_t;

static winding_t winding(double resistance, double inductance)
{
    const double a = exp(-resistance * PERIOD / inductance);
    return (winding_t){a, (1.0 - a) / resistance, 0.0, 0.0, 0.0};
}

/* Simulates a period with this order. Returns the current at its beginning [A]. */
static double complex run(winding_t *w, excite_t *excite, const excite_order_t *order)
{
    const double complex current = w->current;
    const ab_t asked = excite_step(excite, order, (ab_t){(float)creal(current), (float)cimag(current)},
                                   (ab_t){(float)creal(w->acts), (float)cimag(w->acts)});
    w->acts = w->next;
    w->next = (double)asked.alpha + IM * (double)asked.beta;
    w->current = w->a * w->current + w->b * w->acts;
    return current;
}

static void test_pulse_answers_with_the_current_of_its_first_half(void)
{
    for (uint32_t n = 1u; n <= 20u; n += 3u) {
        winding_t w = winding(0.5, 5e-3);
        excite_t excite;
        excite_seen_t seen = {.done = 0u};
        excite_init(&excite);
        const excite_order_t order = {.kind = (int32_t)EXCITE_PULSE,
                                      .serial = 7u,
                                      .axis = {0.6f, 0.8f},
                                      .voltage = 10.0f,
                                      .periods = n,
                                      .current_max = 100.0f};
        for (uint32_t k = 0u; k < 4000u && seen.done == 0u; k++) {
            (void)run(&w, &excite, &order);
            if (k % 8u == 7u) {
                excite_close(&excite, &seen);
            }
        }
        const double expected = w.b * 10.0 * (1.0 - pow(w.a, n)) / (1.0 - w.a);
        TEST_ASSERT_EQUAL_UINT32(1u, seen.done);
        TEST_ASSERT_EQUAL_UINT32(7u, seen.serial);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5 * expected, 0.8 * expected, (double)seen.response.alpha);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5 * expected, 0.6 * expected, (double)seen.response.beta);
        TEST_ASSERT_TRUE(cabs(w.current) < (double)EXCITE_STILL);
    }
}

/* The sample above the limit ends the pulse; the voltage that was ordered one period before still acts. */
static void test_pulse_ends_above_its_largest_current(void)
{
    winding_t w = winding(0.5, 5e-3);
    excite_t excite;
    excite_init(&excite);
    const excite_order_t order = {.kind = (int32_t)EXCITE_PULSE,
                                  .serial = 1u,
                                  .axis = {0.0f, 1.0f},
                                  .voltage = 50.0f,
                                  .periods = 50u,
                                  .current_max = 3.0f};
    double largest = 0.0;
    for (uint32_t k = 0u; k < 300u; k++) {
        largest = fmax(largest, cabs(run(&w, &excite, &order)));
    }
    TEST_ASSERT_TRUE(largest > 3.0);
    TEST_ASSERT_TRUE(largest < 3.0 + 2.0 * w.b * 50.0);
}

static excite_order_t hold_order(double inductance)
{
    return (excite_order_t){.kind = (int32_t)EXCITE_HOLD,
                            .serial = 1u,
                            .axis = {0.8f, 0.6f},
                            .current = 4.0f,
                            .slew = 0.02f,
                            .inductance = (float)inductance,
                            .across_from = 1e3f,
                            .ki = (float)(300.0 * 60.0 * inductance * PERIOD),
                            .voltage_max = 100.0f,
                            .across = (float)(30.0 * inductance)};
}

static void test_hold_brings_the_current_to_its_axis(void)
{
    winding_t w = winding(0.5, 5e-3);
    excite_t excite;
    excite_init(&excite);
    const excite_order_t order = hold_order(5e-3);
    w.current = -2.0 + 1.0 * IM;
    for (uint32_t k = 0u; k < 10000u; k++) {
        (void)run(&w, &excite, &order);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 4.0 * 0.6, creal(w.current));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 4.0 * 0.8, cimag(w.current));
    TEST_ASSERT_EQUAL_UINT32(1u, excite.seen.done);
}

/* Sums of the product of a held current and a sine, over whole periods of the sine, give L of the exact
 * winding, for any response of the control. */
static void test_sine_on_a_held_current_gives_the_inductance(void)
{
    for (double inductance = 2e-4; inductance < 0.1; inductance *= 3.0) {
        const double resistance = fmin(1.0, inductance / (4.0 * PERIOD));
        winding_t w = winding(resistance, inductance);
        excite_t excite;
        excite_seen_t seen;
        excite_init(&excite);
        excite_order_t order = hold_order(inductance);
        order.turn = (float)(2.0 * PI * 0.05);
        order.voltage = (float)(0.5 * 2.0 * PI * 500.0 * inductance);
        order.sine_across = 1u;
        for (uint32_t k = 0u; k < 8000u; k++) {
            (void)run(&w, &excite, &order);
        }
        excite_close(&excite, &seen);
        double complex voltage = 0.0, current = 0.0;
        for (uint32_t k = 0u; k < 1000u; k++) {
            (void)run(&w, &excite, &order);
            if (k % 8u == 7u) {
                excite_close(&excite, &seen);
                TEST_ASSERT_EQUAL_UINT32(8u, seen.periods);
                voltage += (double)seen.voltage_cos.q - IM * (double)seen.voltage_sin.q;
                current += (double)seen.current_cos.q - IM * (double)seen.current_sin.q;
            }
        }
        const float found =
            sine_solve((sine_sum_t){(float)creal(voltage), (float)cimag(voltage)},
                       (sine_sum_t){(float)creal(current), (float)cimag(current)},
                       (rotation_t){(float)sin(2.0 * PI * 0.05), (float)cos(2.0 * PI * 0.05)}, &TUNING);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3 * inductance, inductance, (double)found);
    }
}

#define DEAD_TIME 2.5e-6 /* [s] */
#define TURN_ON   1.2e-6 /* [s] */
#define TURN_OFF  0.9e-6 /* [s] */

/* The current at the end of a period for a mean voltage of 1 V that the edges of the legs make near a duty of
 * one half: the upper switch of a leg is off from T/4 to 3 T/4. A current out of a leg delays its rising edge
 * by the dead time, a current into it the falling one. The current flows out of leg a, which has two thirds
 * of the voltage, and into the two others. */
static double answer_of_edges(double resistance, double inductance)
{
    const double late = DEAD_TIME + TURN_ON, early = TURN_OFF;
    const double edges[2][2] = {{0.25 * PERIOD + early, 0.75 * PERIOD + late},
                                {0.25 * PERIOD + late, 0.75 * PERIOD + early}};
    double answer = 0.0;
    for (int n = 0; n < 4; n++) {
        const double share = (n < 2 ? 2.0 : 1.0) / 3.0;
        answer += 0.5 * share * exp(-(PERIOD - edges[n / 2][n % 2]) * resistance / inductance);
    }
    return answer * PERIOD / inductance;
}

/* The current follows the law I = b U/(1 - a z^-1), for L/R from two periods on. At two periods the dead time
 * of leg a weighs more than that of the others by (R T/L)^2 T_e/(24 T) = 2.9e-4. */
static void test_sine_solve_inverts_the_law_of_the_winding(void)
{
    commission_tuning_t tuning = TUNING;
    tuning.edge_delay = (float)(0.5 * (DEAD_TIME + TURN_ON + TURN_OFF));
    for (double periods = 2.0; periods < 3000.0; periods *= 1.7) {
        for (double turn = 0.05; turn < 0.7; turn += 0.1) {
            const double resistance = 0.7;
            const double inductance = periods * PERIOD * resistance;
            const winding_t w = winding(resistance, inductance);
            const double complex voltage = 3.0 - 1.0 * IM;
            const double complex current =
                answer_of_edges(resistance, inductance) * voltage / (1.0 - w.a * cexp(-IM * turn));
            const float found = sine_solve((sine_sum_t){(float)creal(voltage), (float)cimag(voltage)},
                                           (sine_sum_t){(float)creal(current), (float)cimag(current)},
                                           (rotation_t){(float)sin(turn), (float)cos(turn)}, &tuning);
            TEST_ASSERT_DOUBLE_WITHIN((periods < 4.0 ? 4e-4 : 1e-4) * inductance, inductance, (double)found);
        }
    }
}

/* ---- wiring ---- */

/* The matrix of a winding with this saliency at this angle, seen by the sensors of a map. `open` is the
 * number of a phase without current, 1 to 3; 0: none. */
static wiring_matrix_t seen_by(wiring_map_t map, double saliency, double angle, int open)
{
    wiring_matrix_t matrix;
    memset(&matrix, 0, sizeof matrix);
    for (int n = 0; n < 6; n++) {
        const double direction = n * PI / 3.0;
        const double complex along = cexp(IM * direction) * cexp(-IM * angle);
        const double complex flows = (creal(along) + IM * cimag(along) / saliency) * cexp(IM * angle);
        double leg[3];
        for (int k = 0; k < 3; k++) {
            leg[k] = creal(flows * cexp(-IM * 2.0 * PI * k / 3.0));
        }
        if (open > 0) { /* the voltage between the two other phases drives one current */
            const int one = open % 3, other = (open + 1) % 3;
            const double between =
                cos(direction - 2.0 * PI * one / 3.0) - cos(direction - 2.0 * PI * other / 3.0);
            leg[open - 1] = 0.0;
            leg[one] = 0.5 * between;
            leg[other] = -0.5 * between;
        }
        const double a = map.sign_a * leg[map.leg_a];
        const double b = map.sign_b * leg[map.leg_b];
        wiring_matrix_add(&matrix, frames_clarke((abc_t){(float)a, (float)b, (float)(-a - b)}),
                          (rotation_t){(float)sin(direction), (float)cos(direction)});
    }
    return matrix;
}

static wiring_map_t best_of(const wiring_matrix_t *matrix)
{
    wiring_search_t search = {0u, 0u, 0.0f};
    while (!wiring_search(&search, matrix)) {
    }
    TEST_ASSERT_EQUAL_UINT32(WIRING_MAPS, search.tried);
    return wiring_map_of(search.best);
}

/* All 24 maps of two sensors, with rotors up to L_q = 7.3 L_d over their angles, are identified with legs
 * and signs. */
static void test_every_map_of_the_sensors_is_named(void)
{
    int maps = 0;
    for (int n = 0; n < 36; n++) {
        const wiring_map_t map = {n % 3, n / 3 % 3, n / 9 % 2 == 0 ? 1 : -1, n / 18 == 0 ? 1 : -1};
        if (map.leg_a == map.leg_b) {
            continue;
        }
        maps++;
        for (double saliency = 1.0; saliency <= 8.0; saliency *= 1.22) {
            for (double angle = 0.0; angle < PI; angle += 0.1) {
                const wiring_matrix_t matrix = seen_by(map, saliency, angle, 0);
                const wiring_map_t found = best_of(&matrix);
                TEST_ASSERT_EQUAL_INT32(wiring_code(map), wiring_code(found));
                TEST_ASSERT_EQUAL_INT(map.leg_a == 0 && map.leg_b == 1 && map.sign_a > 0 && map.sign_b > 0,
                                      wiring_is_right(found));
                /* The rank is larger than with an open phase; where sensors are exchanged, this holds for
                 * less salient rotors only. */
                TEST_ASSERT_TRUE((saliency > 4.0 && !wiring_is_right(found)) || wiring_rank(&matrix) > 0.15f);
                if (wiring_rank(&matrix) < 0.15f) {
                    TEST_ASSERT_EQUAL_INT32(0, wiring_open_phase(&matrix));
                    TEST_ASSERT_EQUAL_INT32(0, wiring_stuck_sensor(&matrix));
                }
            }
        }
    }
    TEST_ASSERT_EQUAL_INT(24, maps);
}

static void test_an_open_phase_takes_the_rank_and_is_named(void)
{
    for (int open = 1; open <= 3; open++) {
        const wiring_matrix_t matrix = seen_by((wiring_map_t){0, 1, 1, 1}, 1.0, 0.0, open);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, (double)wiring_rank(&matrix));
        TEST_ASSERT_EQUAL_INT32(open, wiring_open_phase(&matrix));
    }
}

/* In the Clarke transform sensor a also contributes i_a/sqrt 3 to beta, and sensor b 2 i_b/sqrt 3. */
static void test_sensor_that_does_not_change_is_no_open_phase(void)
{
    static const wiring_matrix_t of_a = {{0.0f, -0.577350269f}, {0.0f, 1.0f}};
    static const wiring_matrix_t of_b = {{1.0f, 0.577350269f}, {0.0f, 0.0f}};
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.0f, wiring_rank(&of_a));
    TEST_ASSERT_EQUAL_INT32(0, wiring_open_phase(&of_a));
    TEST_ASSERT_EQUAL_INT32(0, wiring_open_phase(&of_b));
    TEST_ASSERT_EQUAL_INT32(1, wiring_stuck_sensor(&of_a));
    TEST_ASSERT_EQUAL_INT32(2, wiring_stuck_sensor(&of_b));
}

/* ---- torque test ---- */

static void test_mean_of_turning_vectors_is_as_short_as_the_kernel_of_dirichlet(void)
{
    for (int n = 8; n <= 16; n += 8) {
        for (double turn = 0.001; n * turn <= 2.4; turn *= 1.3) {
            const double expected = sin(0.5 * n * turn) / (n * sin(0.5 * turn));
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, expected, (double)turning_mean_length((float)n, (float)turn));
        }
    }
}

static void test_fit_separates_inertia_and_friction(void)
{
    turning_fit_t fit;
    memset(&fit, 0, sizeof fit);
    for (int n = 0; n < 24; n++) {
        const double a = n % 3 == 0 ? 90.0 : n % 3 == 1 ? -12.0 : -70.0;
        const double w = 40.0 + 3.0 * n;
        const float x[TURNING_UNKNOWNS] = {(float)a, 1.0f, (float)w};
        turning_fit_add(&fit, x, (float)(0.0123 * a + 0.31 + 2.5e-3 * w));
    }
    float x[TURNING_UNKNOWNS];
    float error;
    TEST_ASSERT_TRUE(turning_fit_solve(&fit, x, &error));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * 0.0123, 0.0123, (double)x[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.31, (double)x[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.5e-3, (double)x[2]);
    TEST_ASSERT_TRUE(error < 1e-3f);
}

static void test_fit_of_one_speed_has_no_solution(void)
{
    turning_fit_t fit;
    memset(&fit, 0, sizeof fit);
    for (int n = 0; n < 24; n++) {
        const float x[TURNING_UNKNOWNS] = {0.0f, 1.0f, 50.0f};
        turning_fit_add(&fit, x, 1.0f);
    }
    float x[TURNING_UNKNOWNS];
    float error;
    TEST_ASSERT_FALSE(turning_fit_solve(&fit, x, &error));
}

/* ---- the state machine ---- */

static commission_window_t window_of(const excite_seen_t *seen, float noise, bool on)
{
    return (commission_window_t){
        .standing = {seen, {noise, -noise, 0.0f}, {noise, 0.0f}, 311.0f, 1u},
        .bridge_on = on,
    };
}

static int32_t board_with_noise(double sigma)
{
    static const excite_seen_t none;
    commission_t commission;
    commission_init(&commission);
    /* Two values that alternate have a deviation of exactly half their difference. */
    for (uint32_t n = 0u; n < 3200u; n++) {
        const commission_window_t window = window_of(&none, (float)(n % 2u == 0u ? sigma : -sigma), false);
        commission_window(&commission, &TUNING, COMMISSION_BOARD, &window);
    }
    TEST_ASSERT_TRUE(commission.state >= (int32_t)COMMISSION_DONE);
    return commission.reason;
}

static void test_board_judges_the_noise_of_the_sensors(void)
{
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, board_with_noise(0.029));
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NOISE, board_with_noise(0.031));
}

static void test_step_waits_for_the_bridge_and_ends_with_it(void)
{
    static const excite_seen_t none;
    commission_t commission;
    commission_init(&commission);
    commission_window_t window = window_of(&none, 0.0f, false);
    commission_window(&commission, &TUNING, COMMISSION_WIRING, &window);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_WAITS, commission.state);
    TEST_ASSERT_EQUAL_INT32(EXCITE_HOLD, commission.order.kind);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, commission.order.current);
    window.bridge_on = true;
    commission_window(&commission, &TUNING, COMMISSION_WIRING, &window);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_WORKS, commission.state);
    window.bridge_on = false;
    commission_window(&commission, &TUNING, COMMISSION_WIRING, &window);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_FAILED, commission.state);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_BRIDGE_OPENED, commission.reason);
}

static void test_step_without_the_earlier_ones_is_refused(void)
{
    static const excite_seen_t none;
    static const int32_t steps[] = {COMMISSION_RESISTANCE, COMMISSION_INDUCTANCE, COMMISSION_SWING};
    for (uint32_t n = 0u; n < sizeof steps / sizeof steps[0]; n++) {
        commission_t commission;
        commission_init(&commission);
        const commission_window_t window = window_of(&none, 0.0f, true);
        commission_window(&commission, &TUNING, steps[n], &window);
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_EARLIER_STEP, commission.reason);
    }
}

/* The motor never answers: the pulses grow to a quarter of the link voltage and to their longest duration. */
static void test_no_answer_is_named(void)
{
    commission_t commission;
    excite_seen_t seen = {.periods = 8u, .done = 1u};
    commission_init(&commission);
    float most = 0.0f;
    uint32_t n = 0u;
    for (; n < 6000u && commission.state != (int32_t)COMMISSION_FAILED; n++) {
        const commission_window_t window = window_of(&seen, 0.0f, true);
        commission_window(&commission, &TUNING, COMMISSION_WIRING, &window);
        seen.serial = commission.order.serial;
        most = fmaxf(most, commission.order.voltage);
    }
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NO_MOTOR_CURRENT, commission.reason);
    TEST_ASSERT_TRUE(most >= 0.25f * 311.0f && most < 0.25f * 1.25f * 311.0f);
}
