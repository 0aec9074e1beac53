/* The steps of commissioning at standstill with windings of known data: the result of each step, and the
 * reason with which it ends. A winding answers an order at once with the sums of a settled window; the
 * expected values are the data of the winding. The rotor of the swing is a motor in double precision. */
#include <complex.h>
#include <math.h>
#include <unity.h>

#include "fast/control/excite.h"
#include "tests/unit/commission_windings.h"

/* ---- resistance ---- */

static int32_t resistance_of(bench_t *bench, const winding_t *winding, const commission_tuning_t *tuning)
{
    const resistance_step_t *step = &bench->commission.work.resistance;
    commission_init(&bench->commission);
    bench->commission.results.inductance_pulse = 5e-3f;
    bench->seen = (excite_seen_t){.serial = 0u};
    order_step(bench, tuning, COMMISSION_RESISTANCE);
    while (bench->commission.state < (int32_t)COMMISSION_DONE) {
        const double twice =
            2.0 * atan2((double)bench->commission.order.axis.sin, (double)bench->commission.order.axis.cos);
        const bool flat = winding->flat != 0 && step->phase >= RESISTANCE_FULL;
        const double sign = step->repeated != 0u ? -1.0 : 1.0;
        answer_hold(bench, winding,
                    (flat ? 0.0 : winding->resistance) *
                        (1.0 + (winding->gain + sign * winding->moving) * cos(twice)));
        order_step(bench, tuning, COMMISSION_RESISTANCE);
    }
    return bench->commission.reason;
}

static void test_resistance_and_loss_of_a_leg_are_those_of_the_winding(void)
{
    static const winding_t windings[] = {{.resistance = 0.02, .rest = 0.4},
                                         {.resistance = 0.95, .rest = 13.0},
                                         {.resistance = 8.0, .rest = 4.0}};
    for (uint32_t n = 0u; n < sizeof windings / sizeof windings[0]; n++) {
        bench_t bench;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, resistance_of(&bench, &windings[n], &TUNING));
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * windings[n].resistance + 1e-6, windings[n].resistance,
                                  (double)bench.commission.results.resistance);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * windings[n].rest, 0.75 * windings[n].rest,
                                  (double)bench.commission.results.dead_voltage);
        TEST_ASSERT_EQUAL_FLOAT(5.0f, bench.commission.results.current_hold);
    }
}

/* The trapezia between the levels miss the corners of the triangles; the tolerance is 8 % and 3.5 mA. R
 * and V are those of the winding, because the fitted line does not use points in the zone. */
static void test_zone_of_the_legs_is_measured_beside_the_line(void)
{
    for (double zone = 0.02; zone < 0.2; zone *= 1.3) {
        const winding_t winding = {.resistance = 0.95, .rest = 13.0, .zone = zone};
        commission_tuning_t tuning = TUNING;
        bench_t bench;
        tuning.current_hold = 1.1f;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, resistance_of(&bench, &winding, &tuning));
        TEST_ASSERT_DOUBLE_WITHIN(0.08 * zone + 3.5e-3, zone, (double)bench.commission.results.current_zone);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.95, (double)bench.commission.results.resistance);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * 13.0, 0.75 * 13.0, (double)bench.commission.results.dead_voltage);
    }
}

/* The largest current is half of the link voltage less the loss of the legs, divided by R. */
static void test_link_limits_the_current_of_a_large_resistance(void)
{
    const winding_t winding = {.resistance = 40.0, .rest = 12.0};
    bench_t bench;
    (void)resistance_of(&bench, &winding, &TUNING);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, (0.5 * LINK - 12.0) / 40.0,
                              (double)bench.commission.results.current_hold);
}

static void test_resistance_ends_with_the_reason_of_its_winding(void)
{
    static const struct {
        const char *name;
        winding_t winding;
        float hold; /* [A] */
        commission_reason_t reason;
    } rows[] = {
        {"the voltage does not rise with the current",
         {.rest = 5.0},
         5.0f,
         COMMISSION_REASON_NO_STEADY_CURRENT},
        {"the voltage does not follow the staircase",
         {.resistance = 0.95, .rest = 5.0, .flat = 1},
         5.0f,
         COMMISSION_REASON_NO_STEADY_CURRENT},
        {"0.4 A may flow", {.resistance = 0.95}, 0.4f, COMMISSION_REASON_HEAT_LIMIT_TOO_LOW},
        {"the link drives 0.39 A", {.resistance = 400.0}, 5.0f, COMMISSION_REASON_HEAT_LIMIT_TOO_LOW},
        {"a sensor is wrong by 3 % in one direction",
         {.resistance = 0.95, .gain = 0.03},
         5.0f,
         COMMISSION_REASON_SENSOR_GAIN},
        {"another difference each time",
         {.resistance = 0.95, .moving = 0.03},
         5.0f,
         COMMISSION_REASON_ROTOR_SWINGS},
        {"1 % is within the scatter", {.resistance = 0.95, .gain = 0.01}, 5.0f, COMMISSION_REASON_NONE},
        {"a current flows across the axis",
         {.resistance = 0.95, .across = 0.2},
         5.0f,
         COMMISSION_REASON_ROTOR_SWINGS},
        {"L/R of 1.9 periods",
         {.resistance = 5e-3 / (1.9 * PERIOD)},
         5.0f,
         COMMISSION_REASON_TIME_CONSTANT_SHORT},
        {"L/R of 2.1 periods", {.resistance = 5e-3 / (2.1 * PERIOD)}, 5.0f, COMMISSION_REASON_NONE},
    };
    for (uint32_t n = 0u; n < sizeof rows / sizeof rows[0]; n++) {
        commission_tuning_t tuning = TUNING;
        bench_t bench;
        tuning.current_hold = rows[n].hold;
        TEST_ASSERT_EQUAL_INT32_MESSAGE(rows[n].reason, resistance_of(&bench, &rows[n].winding, &tuning),
                                        rows[n].name);
    }
}

/* The result is that of the second staircase if its two directions agree. */
static void test_second_staircase_is_taken_when_the_first_one_scatters(void)
{
    const winding_t winding = {.resistance = 0.95, .gain = 0.02, .moving = 0.02};
    bench_t bench;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, resistance_of(&bench, &winding, &TUNING));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.95, (double)bench.commission.results.resistance);
}

/* ---- swing ---- */

/* A surface motor, driven by the excitation of the fast task. */
typedef struct {
    double resistance, inductance, flux, inertia, friction; /* [ohm], [H], [Wb], [kg m^2], [N m s] */
    double angle, omega;                                    /* [rad] electrical; [rad/s] mechanical */
    double complex current, acts, next;                     /* [A], [V] */
    double moving, lost; /* voltage that the drive does not know: of every second jump; now [V] */
} motor_t;

/* Simulates a period in 16 parts. */
static void turn_motor(motor_t *motor, excite_t *excite, const excite_order_t *order)
{
    const double part = PERIOD / 16.0;
    const ab_t asked =
        excite_step(excite, order, (ab_t){(float)creal(motor->current), (float)cimag(motor->current)},
                    (ab_t){(float)creal(motor->acts), (float)cimag(motor->acts)});
    motor->acts = motor->next;
    motor->next = (double)asked.alpha + IM * (double)asked.beta;
    for (int n = 0; n < 16; n++) {
        const double complex magnets = motor->flux * cexp(IM * motor->angle);
        const double complex emf = IM * 4.0 * motor->omega * magnets;
        const double torque = 1.5 * 4.0 * cimag(conj(magnets) * motor->current);
        motor->current +=
            part / motor->inductance * (motor->acts - motor->resistance * motor->current - motor->lost - emf);
        motor->omega += part / motor->inertia * (torque - motor->friction * motor->omega);
        motor->angle += part * 4.0 * motor->omega;
    }
}

/* Runs a step on the motor until it has ended. */
static int32_t measured_on(bench_t *bench, motor_t *motor, int32_t step)
{
    excite_t excite;
    excite_init(&excite);
    commission_init(&bench->commission);
    bench->commission.results = (commission_results_t){.resistance = (float)motor->resistance,
                                                       .inductance_pulse = (float)motor->inductance,
                                                       .inductance_d = (float)motor->inductance,
                                                       .inductance_q = (float)motor->inductance,
                                                       .current_hold = TUNING.current_hold};
    bench->seen = (excite_seen_t){.serial = 0u};
    order_step(bench, &TUNING, step);
    const swing_step_t *swing = &bench->commission.work.swing;
    while (bench->commission.state < (int32_t)COMMISSION_DONE) {
        motor->lost = swing->phase == (int32_t)SWING_JUMP && swing->jump % 2u == 0u ? motor->moving : 0.0;
        for (uint32_t k = 0u; k < (uint32_t)PERIODS; k++) {
            turn_motor(motor, &excite, &bench->commission.order);
        }
        excite_close(&excite, &bench->seen);
        const commission_window_t window = {
            .standing = {&bench->seen,
                         {0.0f, 0.0f, 0.0f},
                         {(float)creal(motor->current), (float)cimag(motor->current)},
                         (float)LINK},
            .bridge_on = true};
        commission_window(&bench->commission, &TUNING, step, &window);
    }
    return bench->commission.reason;
}

static int32_t swing_of(bench_t *bench, motor_t *motor)
{
    return measured_on(bench, motor, COMMISSION_SWING);
}

static motor_t motor_with(double inertia)
{
    return (motor_t){.resistance = 0.95,
                     .inductance = 5e-3,
                     .flux = 0.1,
                     .inertia = inertia,
                     .friction = 1e-4,
                     .angle = 1.0};
}

static void test_swing_gives_first_values_of_flux_and_inertia(void)
{
    for (double inertia = 5e-4; inertia < 2e-2; inertia *= 3.0) {
        motor_t motor = motor_with(inertia);
        bench_t bench;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, swing_of(&bench, &motor));
        TEST_ASSERT_DOUBLE_WITHIN(0.05 * 0.1, 0.1, (double)bench.commission.results.flux_first);
        TEST_ASSERT_DOUBLE_WITHIN(0.15 * inertia, inertia, (double)bench.commission.results.inertia_first);
    }
}

/* A rotor of very small inertia follows only the braking, so that the jumps are repeated with less
 * braking. */
static void test_swing_of_a_light_rotor_is_repeated_with_less_braking(void)
{
    motor_t motor = motor_with(3.2e-6);
    bench_t bench;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, swing_of(&bench, &motor));
    TEST_ASSERT_TRUE(bench.commission.work.swing.freer == 2u);
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * 0.1, 0.1, (double)bench.commission.results.flux_first);
}

/* A holding brake, or a rotor too heavy for the duration of a jump: the step must not return a flux. */
static void test_rotor_that_does_not_follow_is_named(void)
{
    static const double inertias[] = {20.0, 1e5, 1e9};
    for (uint32_t n = 0u; n < sizeof inertias / sizeof inertias[0]; n++) {
        motor_t motor = motor_with(inertias[n]);
        bench_t bench;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_ROTOR_NOT_TURNING, swing_of(&bench, &motor));
    }
}

/* The flux of the magnets is a hundredth of L I, and the error of the integrated voltage is as large. */
static void test_rotor_of_too_little_flux_is_named(void)
{
    motor_t motor = motor_with(1e-5);
    bench_t bench;
    motor.flux = 0.01 * motor.inductance * 5.0;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_EMF_TOO_SMALL, swing_of(&bench, &motor));
}

/* 0.1 V in every second jump is 25 mWb in its 0.25 s: a quarter of the one motor's magnets, and twelve times
 * those of the other. */
static void test_flux_that_differs_between_the_directions_is_named(void)
{
    motor_t motor = motor_with(1e-5);
    bench_t bench;
    motor.flux = 2e-3;
    motor.moving = 0.1;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_EMF_TOO_SMALL, swing_of(&bench, &motor));
    motor = motor_with(1e-4);
    motor.moving = 0.1;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, swing_of(&bench, &motor));
}

/* Half of the ripple with 0.1 mH is 311 V T/(24 L) = 13 A, more than 0.6 of 10 A. A rotor whose EMF drives
 * less than the limit of the zero vector still adds it to one of two opposite pulses and subtracts it from
 * the other. */
static void test_wiring_names_a_large_ripple_and_a_rotor_that_turns(void)
{
    motor_t still = motor_with(1e-3), small = still, turning = still;
    bench_t bench;
    small.inductance = 1e-4;
    turning.inertia = 1e9;
    turning.omega = 0.25;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, measured_on(&bench, &still, COMMISSION_WIRING));
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * 5e-3, 5e-3, (double)bench.commission.results.inductance_pulse);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_RIPPLE_TOO_LARGE,
                            measured_on(&bench, &small, COMMISSION_WIRING));
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_ROTOR_TURNS, measured_on(&bench, &turning, COMMISSION_WIRING));
}

/* ---- the state machine ---- */

static void test_board_names_a_low_link_and_gates_that_are_not_held_off(void)
{
    static const excite_seen_t none;
    static const struct {
        float u_dc;
        uint32_t tripped;
        bool on;
        commission_reason_t reason;
    } rows[] = {{201.0f, 1u, false, COMMISSION_REASON_NONE},
                {199.0f, 1u, false, COMMISSION_REASON_LINK_LOW},
                {201.0f, 0u, false, COMMISSION_REASON_TRIP_FAILED},
                {199.0f, 0u, false, COMMISSION_REASON_TRIP_FAILED},
                {201.0f, 0u, true, COMMISSION_REASON_NONE}};
    for (uint32_t row = 0u; row < sizeof rows / sizeof rows[0]; row++) {
        commission_t commission;
        commission_init(&commission);
        const commission_window_t window = {
            .standing = {&none, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f}, rows[row].u_dc, rows[row].tripped},
            .bridge_on = rows[row].on};
        for (uint32_t n = 0u; n < 3200u; n++) {
            commission_window(&commission, &TUNING, COMMISSION_BOARD, &window);
        }
        TEST_ASSERT_EQUAL_INT32(rows[row].reason, commission.reason);
    }
}

/* In each of these steps the drive never answers. */
static void test_step_ends_after_its_largest_time_with_what_it_waited_for(void)
{
    static const struct {
        commission_step_t step;
        uint32_t runs;
        double seconds;
        commission_reason_t reason;
    } rows[] = {
        {COMMISSION_RESISTANCE, 0u, 60.0, COMMISSION_REASON_TIME_OUT},
        {COMMISSION_INDUCTANCE, 0u, 15.0, COMMISSION_REASON_TIME_OUT},
        {COMMISSION_SWING, 0u, 40.0, COMMISSION_REASON_TIME_OUT},
        {COMMISSION_FLUX, 0u, 60.0, COMMISSION_REASON_ROTOR_NOT_TURNING},
        {COMMISSION_INERTIA, 0u, 120.0, COMMISSION_REASON_ROTOR_NOT_TURNING},
        {COMMISSION_FLUX, 1u, 60.0, COMMISSION_REASON_SENSORLESS_LOST},
    };
    for (uint32_t n = 0u; n < sizeof rows / sizeof rows[0]; n++) {
        const excite_seen_t silent = {.serial = 999u};
        const commission_window_t window = {
            .standing = {&silent, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f}, (float)LINK},
            .turning = {.runs = rows[n].runs, .speed = 100.0f, .least = 20.0f},
            .bridge_on = true};
        commission_t commission;
        commission_init(&commission);
        commission.results = (commission_results_t){.resistance = 0.95f,
                                                    .inductance_pulse = 5e-3f,
                                                    .inductance_d = 5e-3f,
                                                    .inductance_q = 5e-3f,
                                                    .current_hold = 5.0f,
                                                    .flux_linkage = 0.1f,
                                                    .inertia_first = 1e-3f};
        uint32_t windows = 0u;
        while (commission.state < (int32_t)COMMISSION_DONE) {
            commission_window(&commission, &TUNING, (int32_t)rows[n].step, &window);
            windows++;
        }
        TEST_ASSERT_EQUAL_INT32(rows[n].reason, commission.reason);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3 * rows[n].seconds, rows[n].seconds, 8e-4 * windows);
    }
}
