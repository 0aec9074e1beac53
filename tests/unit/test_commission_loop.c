/* The steps `current_loop` and `turn` of commissioning. The test closes the loop period by period, with
 * excite_loop(), the current control of the drive and the exact law of a winding, i_k+1 = a i_k + b u_k-1.
 * The expected ratio of the loop's gain to its design value is L_hat/L. */
#include <math.h>
#include <unity.h>

#include "fast/control/current_control.h"
#include "fast/control/excite.h"
#include "tests/unit/commission_windings.h"

#define RESISTANCE 0.95
#define INDUCTANCE 5e-3 /* [H] the value that the drive has measured */
#define GAIN       0.2  /* gain of the loop by design */

typedef struct {
    bench_t bench;
    excite_t excite;
    current_control_t control;
    double resistance;    /* [ohm] */
    double inductance;    /* [H] the true value */
    double current, loss; /* [A], [V] */
    double voltage;       /* [V] voltage of this period */
    double noise;         /* [A] amplitude of an alternating error of the sensor */
    uint32_t period;
} loop_t;

static commission_tuning_t tuning_of(void)
{
    commission_tuning_t tuning = TUNING;
    tuning.inductance_d = (float)INDUCTANCE;
    tuning.loop_gain = (float)GAIN;
    return tuning;
}

/* A pseudo-random error of the sensor with a uniform distribution. */
static double error_of(loop_t *loop)
{
    static uint32_t state = 1u;
    state = state * 1664525u + 1013904223u;
    return loop->noise * ((double)(state >> 8) / 8388608.0 - 1.0);
}

/* Runs a window under the present order. */
static void run_window(loop_t *loop)
{
    const excite_order_t *order = &loop->bench.commission.order;
    const double a = exp(-loop->resistance * PERIOD / loop->inductance);
    for (uint32_t n = 0u; n < (uint32_t)PERIODS; n++) {
        const dq_t seen = {(float)(loop->current + error_of(loop)), 0.0f};
        const dq_t wanted = excite_loop(&loop->excite, order, seen);
        const dq_t asked =
            current_control_step(&loop->control, (dq_t){wanted.d, 0.0f}, seen, 0.0f, (dq_t){0.0f, 0.0f});
        current_control_applied(&loop->control, asked);
        loop->current = a * loop->current + (1.0 - a) / loop->resistance * (loop->voltage - loop->loss);
        loop->voltage = (double)asked.d;
    }
    excite_close(&loop->excite, &loop->bench.seen);
}

/* The reason with which the step ends for a winding with this L. */
static int32_t check_loop(loop_t *loop, double resistance, double inductance, double least, double noise)
{
    const commission_tuning_t tuning = tuning_of();
    const winding_t settled = {.resistance = resistance};
    const current_control_params_t params = {(float)resistance,      (float)INDUCTANCE, (float)INDUCTANCE,
                                             (float)(GAIN / PERIOD), (float)PERIOD,     0.0f};
    const current_control_tuning_t control = current_control_prepare(&params);
    bench_t *bench = &loop->bench;
    *loop = (loop_t){.resistance = resistance, .inductance = inductance, .loss = 10.0, .noise = noise};
    current_control_init(&loop->control, &control);
    excite_init(&loop->excite);
    commission_init(&bench->commission);
    bench->commission.results.noise = (float)(noise / sqrt(3.0));
    bench->commission.results.inductance_pulse = (float)INDUCTANCE;
    bench->commission.results.inductance_d = (float)INDUCTANCE;
    bench->commission.results.inductance_d_least = (float)least;
    bench->commission.results.resistance = (float)resistance;
    bench->commission.results.current_hold = TUNING.current_hold;
    bench->commission.results.current_aligned = TUNING.current_hold;
    order_step(bench, &tuning, COMMISSION_CURRENT_LOOP);
    while (bench->commission.state < (int32_t)COMMISSION_DONE) {
        if (bench->commission.order.kind == (int32_t)EXCITE_LOOP) {
            run_window(loop);
        } else {
            answer_hold(bench, &settled, resistance);
        }
        order_step(bench, &tuning, COMMISSION_CURRENT_LOOP);
    }
    return bench->commission.reason;
}

/* A gain within 5 % of the design is accepted as measured, and 12 % is the limit: factors of 0.6, 0.8,
 * 1.25 and 1.6 are refused. */
static void test_gain_of_the_current_loop_shows_a_wrong_inductance(void)
{
    static const struct {
        double over; /* L_hat/L */
        double noise;
        double resistance;
        commission_reason_t reason;
    } rows[] = {
        {1.0, 0.0, RESISTANCE, COMMISSION_REASON_NONE},
        {1.0, 0.03, RESISTANCE, COMMISSION_REASON_NONE},
        {1.0, 0.015, INDUCTANCE / (3.0 * PERIOD), COMMISSION_REASON_NONE}, /* L/R is three periods */
        {0.92, 0.015, RESISTANCE, COMMISSION_REASON_NONE},
        {1.08, 0.015, RESISTANCE, COMMISSION_REASON_NONE},
        {0.6, 0.015, RESISTANCE, COMMISSION_REASON_CURRENT_LOOP},
        {0.8, 0.015, RESISTANCE, COMMISSION_REASON_CURRENT_LOOP},
        {1.25, 0.015, RESISTANCE, COMMISSION_REASON_CURRENT_LOOP},
        {1.6, 0.015, RESISTANCE, COMMISSION_REASON_CURRENT_LOOP},
    };
    for (uint32_t n = 0u; n < sizeof rows / sizeof rows[0]; n++) {
        loop_t loop;
        TEST_ASSERT_EQUAL_INT32(
            rows[n].reason,
            check_loop(&loop, rows[n].resistance, INDUCTANCE / rows[n].over, INDUCTANCE, rows[n].noise));
        /* Beyond the limit the fit is not linear in L_hat/L. */
        if (rows[n].reason == COMMISSION_REASON_NONE) {
            TEST_ASSERT_DOUBLE_WITHIN(0.05 * rows[n].over, rows[n].over,
                                      (double)loop.bench.commission.results.loop_gain);
        }
    }
}

/* At the constant current the saturated d axis has 0.7 L_d, as the step `inductance` has measured. */
static void test_saturation_of_the_d_axis_is_no_error_of_the_loop(void)
{
    loop_t loop;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE,
                            check_loop(&loop, RESISTANCE, 0.7 * INDUCTANCE, 0.7 * INDUCTANCE, 0.015));
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 1.0, (double)loop.bench.commission.results.loop_gain);
}

/* A salient rotor left the axis at I_h and was aligned with 0.6 of this current: with the step of 0.2 the
 * largest reference is the aligned current. */
static void test_a_rotor_that_was_aligned_at_less_current_gets_no_more_than_this_current(void)
{
    bench_t bench = {.seen = {.serial = 0u}};
    commission_init(&bench.commission);
    bench.commission.results.resistance = (float)RESISTANCE;
    bench.commission.results.inductance_pulse = (float)INDUCTANCE;
    bench.commission.results.inductance_d = (float)INDUCTANCE;
    bench.commission.results.current_hold = TUNING.current_hold;
    bench.commission.results.current_aligned = 0.6f * TUNING.current_hold;
    order_step(&bench, &TUNING, COMMISSION_CURRENT_LOOP);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.5f * TUNING.current_hold, bench.commission.order.current);
}

/* The axis advances by p electrical turns; the rotor lags behind it by `across`. */
static int32_t turn_shaft(bench_t *bench, double across, double *turned)
{
    const winding_t winding = {.resistance = RESISTANCE, .across = across};
    double last = 0.0;
    *turned = 0.0;
    commission_init(&bench->commission);
    bench->commission.results.inductance_pulse = (float)INDUCTANCE;
    bench->commission.results.resistance = (float)RESISTANCE;
    bench->commission.results.current_hold = TUNING.current_hold;
    order_step(bench, &TUNING, COMMISSION_TURN);
    while (bench->commission.state < (int32_t)COMMISSION_DONE) {
        const rotation_t axis = bench->commission.order.axis;
        const double angle = atan2((double)axis.sin, (double)axis.cos);
        *turned += remainder(angle - last, 2.0 * PI);
        last = angle;
        answer_hold(bench, &winding, RESISTANCE);
        order_step(bench, &TUNING, COMMISSION_TURN);
    }
    return bench->commission.reason;
}

static void test_one_turn_of_the_shaft_is_as_many_electrical_turns_as_it_has_pole_pairs(void)
{
    bench_t bench;
    double turned = 0.0;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, turn_shaft(&bench, 0.0, &turned));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 2.0 * PI * (double)TUNING.pole_pairs, turned);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_ROTOR_SWINGS, turn_shaft(&bench, 0.5, &turned));
}

static void test_steps_without_the_results_that_they_need_report_it(void)
{
    static const commission_step_t steps[] = {COMMISSION_CURRENT_LOOP, COMMISSION_TURN};
    for (uint32_t n = 0u; n < 2u; n++) {
        bench_t bench = {.seen = {.serial = 0u}};
        commission_init(&bench.commission);
        order_step(&bench, &TUNING, (int32_t)steps[n]);
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_EARLIER_STEP, bench.commission.reason);
    }
}
