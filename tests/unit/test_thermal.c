/* The thermal models of motor and module are compared with the exact solution of tau dh/dt = i^2/I_c^2 - h
 * in double precision, period by period of the carrier; and the remaining limit of the current. */
#include "medium/protect/thermal.h"
#include "tests/unit/compare.h"

#define PERIOD  1e-4 /* [s] of the carrier */
#define EVERY   16   /* number of periods from one square to the next */
#define WITHIN  0.02 /* share of the largest heat */
#define COOL    20.0f
#define NOBODY  (-273.15f) /* [degC] reading of an absent sensor */
#define STEP_S  (PERIOD * EVERY * (double)THERMAL_SUMS)
#define MAX_A   10.0
#define MOTOR_A 7.0

static thermal_t x;
static measured_t measured;
static uint32_t period;

static thermal_params_t usual(void)
{
    return (thermal_params_t){
        .current_max = (float)MAX_A,
        .motor_continuous = (float)MOTOR_A,
        .motor_time = 60.0f,
        .module_continuous = 25.0f,
        .module_time = 0.2f,
        .sink_hot = 90.0f,
        .motor_hot = 130.0f,
        .period = (float)(PERIOD * EVERY),
    };
}

static void begin(const thermal_params_t *params)
{
    const thermal_tuning_t tuning = thermal_prepare(params);
    memset(&x, 0x55, sizeof x);
    thermal_init(&x, &tuning);
    measured = (measured_t){.sink_temperature = COOL, .motor_temperature = COOL};
    period = 0u;
}

void setUp(void)
{
    const thermal_params_t params = usual();
    begin(&params);
}

static abc_t phases(double length, double angle)
{
    return (abc_t){(float)(length * cos(angle)), (float)(length * cos(angle - 2.0 * PI / 3.0)),
                   (float)(length * cos(angle + 2.0 * PI / 3.0))};
}

/* One period of the carrier, as in the drive. */
static void pass(abc_t current)
{
    period++;
    if (period % EVERY == 0u) {
        thermal_add(&x, current);
        if (thermal_is_due(&x)) {
            thermal_step(&x, &measured);
        }
    }
}

/* THERMAL_SUMS squares of the same current. */
static void hold(abc_t current)
{
    for (uint32_t n = 0; n < THERMAL_SUMS; n++) {
        thermal_add(&x, current);
    }
    TEST_ASSERT_TRUE(thermal_is_due(&x));
    thermal_step(&x, &measured);
}

static double exact(double heat, double square, double time)
{
    return square + (heat - square) * exp(-PERIOD / time);
}

/* ---- the model ---- */

/* A flipped bit can give the heat any value. One that is not finite or is too large becomes 10, from which
 * the heat decreases again; a finite negative one becomes 0. */
static void test_a_heat_that_is_not_a_number_counts_as_hot(void)
{
    static const float broken[] = {NAN, INFINITY, 3e38f, -INFINITY, -3.0f};
    for (size_t n = 0; n < sizeof broken / sizeof broken[0]; n++) {
        setUp();
        x.motor_heat = broken[n];
        x.leg_heat.b = broken[n];
        hold((abc_t){0.0f, 0.0f, 0.0f});
        TEST_ASSERT_EQUAL_FLOAT(n < 4u ? 10.0f : 0.0f, x.motor_heat);
        TEST_ASSERT_EQUAL_FLOAT(n < 4u ? 10.0f : 0.0f, x.leg_heat.b);
        TEST_ASSERT_EQUAL_HEX32(n < 4u ? THERMAL_MOTOR | THERMAL_MODULE | THERMAL_DERATING : 0u,
                                x.conditions);
        hold((abc_t){0.0f, 0.0f, 0.0f});
        TEST_ASSERT_TRUE(x.motor_heat < 10.0f && x.leg_heat.b < 10.0f);
    }
}

/* A cycle of loads at speeds from standstill to 200 Hz, for motor and legs with time constants from 50 ms
 * up. The slower sampling and the mean may change the heat by less than 2 % of the largest one. */
static void test_heat_of_a_load_cycle_is_that_of_the_exact_solution(void)
{
    static const double times[][2] = {{5.0, 0.05}, {60.0, 0.2}, {0.5, 1.0}};
    static const double lengths[] = {10.0, 2.0, 12.0, 0.0, 7.0}, hertz[] = {0.0, 3.0, 47.0, 100.0, 200.0};
    for (size_t n = 0; n < sizeof times / sizeof times[0]; n++) {
        thermal_params_t params = usual();
        params.motor_time = (float)times[n][0];
        params.module_time = (float)times[n][1];
        begin(&params);
        double motor = 0.0, leg[3] = {0.0, 0.0, 0.0}, angle = 0.3;
        double most_motor = 0.0, most_leg = 0.0, off_motor = 0.0, off_leg = 0.0;
        for (int32_t k = 0; k < 200000; k++) {
            const int32_t part = k / 7001 % 5;
            angle += 2.0 * PI * hertz[(part + k / 35005) % 5] * PERIOD;
            const abc_t i = phases(lengths[part], angle);
            const double squares[3] = {pow((double)i.a, 2.0), pow((double)i.b, 2.0), pow((double)i.c, 2.0)};
            motor = exact(motor, pow(lengths[part] / MOTOR_A, 2.0), times[n][0]);
            for (int32_t m = 0; m < 3; m++) {
                leg[m] = exact(leg[m], squares[m] / (25.0 * 25.0), times[n][1]);
            }
            pass(i);
            if (x.count == 0u && period % EVERY == 0u) {
                const double worst = fmax(leg[0], fmax(leg[1], leg[2]));
                most_motor = fmax(most_motor, motor);
                most_leg = fmax(most_leg, worst);
                off_motor = fmax(off_motor, fabs((double)x.motor_heat - motor));
                off_leg = fmax(off_leg, fabs((double)x.module_heat - worst));
            }
        }
        TEST_ASSERT_TRUE(off_motor < WITHIN * most_motor);
        TEST_ASSERT_TRUE(off_leg < WITHIN * most_leg);
    }
}

/* The longest accepted time constant, with which a step changes the heat by little more than its last
 * digits: h = (i/I_c)^2 (1 - exp(-t/tau)), over three time constants. */
static void test_a_slow_motor_warms_as_slowly_as_it_should(void)
{
    thermal_params_t params = usual();
    params.motor_time = 3600.0f;
    begin(&params);
    const abc_t current = phases(8.0, 1.0);
    const double end = pow(8.0 / MOTOR_A, 2.0);
    for (double t = STEP_S; t < 3.0 * 3600.0; t += STEP_S) {
        hold(current);
        TEST_ASSERT_TRUE(fabs((double)x.motor_heat + end * expm1(-t / 3600.0)) < WITHIN * end);
    }
}

static void test_without_current_or_time_constant_nothing_is_judged(void)
{
    for (uint32_t n = 0; n < 4u; n++) {
        thermal_params_t params = usual();
        *(n == 0u   ? &params.motor_continuous
          : n == 1u ? &params.motor_time
          : n == 2u ? &params.module_continuous
                    : &params.module_time) = 0.0f;
        params.module_continuous = n < 2u ? 0.0f : params.module_continuous;
        params.motor_continuous = n < 2u ? params.motor_continuous : 0.0f;
        begin(&params);
        for (uint32_t k = 0; k < 20000u; k++) {
            hold(phases(100.0, 0.0));
        }
        TEST_ASSERT_TRUE(x.motor_heat == 0.0f && x.module_heat == 0.0f && x.limit == (float)MAX_A);
        TEST_ASSERT_EQUAL_UINT32(0u, x.conditions);
    }
}

/* ---- the current that the model permits ---- */

/* 10 A are always requested. The motor gets them until h = 0.9, t = tau ln(1/(1 - 0.9 I_c^2/I^2)); then
 * the limit decreases to I_c, h rises to 1, and no trip occurs. */
static void test_torque_falls_to_what_the_motor_withstands_and_nothing_trips(void)
{
    const double until = -60.0 * log(1.0 - 0.9 * pow(MOTOR_A / MAX_A, 2.0));
    float last = (float)MAX_A;
    for (double t = STEP_S; t < 1200.0; t += STEP_S) {
        hold(phases((double)x.limit, t));
        TEST_ASSERT_EQUAL_UINT32(t > until * 1.001 ? THERMAL_DERATING : x.conditions & THERMAL_DERATING,
                                 x.conditions);
        TEST_ASSERT_TRUE(t > until * 0.999 || x.limit == (float)MAX_A);
        TEST_ASSERT_TRUE(x.limit <= last + 1e-4f && last - x.limit < 0.05f);
        TEST_ASSERT_TRUE(x.motor_heat < 1.001f);
        last = x.limit;
    }
    TEST_ASSERT_FLOAT_WITHIN(0.01f, (float)MOTOR_A, x.limit);
    TEST_ASSERT_FLOAT_WITHIN(0.001f, 1.0f, x.motor_heat);
}

/* The time [s] until the condition trips, with the whole current limit. */
static double tripped_after(uint32_t condition)
{
    double t = 0.0;
    while ((x.conditions & condition) == 0u && t < 100.0) {
        hold(phases(MAX_A, 0.0));
        t += STEP_S;
    }
    return t;
}

/* A drive that exceeds the limit is stopped at h = 1.1, after tau ln(1/(1 - 1.1 I_c^2/I^2)). */
static void test_a_drive_that_exceeds_the_limit_trips(void)
{
    const double until = -60.0 * log(1.0 - 1.1 * pow(MOTOR_A / MAX_A, 2.0));
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * until, until, tripped_after(THERMAL_MOTOR));

    thermal_params_t params = usual();
    params.module_continuous = 5.0f;
    begin(&params);
    const double leg = -0.2 * log(1.0 - 1.1 * 0.25);
    TEST_ASSERT_DOUBLE_WITHIN(1.5 * STEP_S, leg, tripped_after(THERMAL_MODULE));
    TEST_ASSERT_EQUAL_UINT32(THERMAL_MODULE | THERMAL_DERATING, x.conditions);
}

/* I_c is above the limit: the motor becomes warm, but its current is never reduced. */
static void test_a_motor_that_withstands_the_limit_is_never_derated(void)
{
    thermal_params_t params = usual();
    params.motor_continuous = (float)MAX_A;
    begin(&params);
    for (double t = 0.0; t < 600.0; t += STEP_S) {
        hold(phases(MAX_A, 0.0));
        TEST_ASSERT_TRUE(x.limit == (float)MAX_A);
    }
    TEST_ASSERT_EQUAL_UINT32(0u, x.conditions);
}

/* From 10 K below the trip on, the limit decreases linearly to a quarter; the warmer of the two sensors
 * counts. An absent sensor reads a temperature far below zero. */
static void test_a_warm_sink_or_motor_takes_the_limit_down(void)
{
    static const struct {
        float sink, motor;
        float limit;
    } cases[] = {{79.9f, 119.9f, 10.0f},  {85.0f, 25.0f, 6.25f},  {25.0f, 127.5f, 4.375f},
                 {88.0f, 121.0f, 4.0f},   {90.0f, 25.0f, 2.5f},   {25.0f, 140.0f, 2.5f},
                 {NOBODY, NOBODY, 10.0f}, {NOBODY, 125.0f, 6.25f}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        measured.sink_temperature = cases[n].sink;
        measured.motor_temperature = cases[n].motor;
        hold(phases(0.0, 0.0));
        TEST_ASSERT_FLOAT_WITHIN(1e-4f, cases[n].limit, x.limit);
        TEST_ASSERT_EQUAL_UINT32(cases[n].limit < 10.0f ? THERMAL_DERATING : 0u, x.conditions);
        measured.sink_temperature = COOL;
        measured.motor_temperature = COOL;
        hold(phases(0.0, 0.0));
        TEST_ASSERT_TRUE(x.limit == (float)MAX_A);
    }
}

static void test_new_coefficients_keep_the_heat_and_a_lower_limit_acts_at_once(void)
{
    for (int32_t n = 0; n < 2000; n++) {
        hold(phases(9.0, 0.0));
    }
    const float heat = x.motor_heat;
    thermal_params_t params = usual();
    params.current_max = 4.0f;
    thermal_tuning_t tuning = thermal_prepare(&params);
    thermal_take(&x, &tuning);
    TEST_ASSERT_TRUE(x.motor_heat == heat && x.limit == 4.0f);
    params.current_max = 10.0f;
    params.motor_continuous = 2.0f;
    tuning = thermal_prepare(&params);
    thermal_take(&x, &tuning);
    hold(phases(9.0, 0.0));
    TEST_ASSERT_TRUE(x.motor_heat > heat);
}
