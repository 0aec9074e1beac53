/* Ideal sensors (`sensors` = exact): the drive gets the truth of t_k, at every period, in every order of
 * switching. With an ideal inverter besides, the closed loop shows the timing convention to the tick: the
 * voltage that the interrupt of period k commands acts on [t_{k+1}, t_{k+2}), all of it and nothing else. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hal/f28335/bus.h"
#include "hal/hal.h"
#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "tests/rig/no_rig.h"
#include "tests/rig/run.h"

#define SENSORS_EXACT 1.0
#define TICK          (1.0 / 150e6)                    /* [s] */
#define LSB           ((double)BOARD_CURRENT_PER_CODE) /* [A] of the current channels */
#define SQRT_3        1.73205080756887729353

/* Half an ulp of a float below 8, as phase currents are here. */
#define HALF_ULP 2.4e-7

/* Turning at this speed already, under 5 N m, not yet enabled. */
static rig_t *turning(double rpm)
{
    rig_t *rig = run_rig(61);
    run_paper_drive(rig);
    run_put(rig, "fidelity", 1.0);
    run_put(rig, "load_torque", 5.0);
    rig_set_motion(rig, 0.3, rpm * RPM);
    run_put(rig, "speed_request", rpm * RPM);
    return rig;
}

/* The phases that have a sensor. */
static const char *const sampled[] = {"i_a", "i_b", "i_c"};
static const char *const truths[] = {"true_i_a", "true_i_b", "true_i_c"};

/* Bits, not numbers: what the drive holds is the truth's very slot. */
static void expect_sample_is_the_truth(rig_t *rig)
{
    for (uint32_t n = 0; n < BOARD_CURRENT_SENSORS; n++) {
        TEST_ASSERT_EQUAL_DOUBLE(rig_value(rig, truths[n]), rig_value(rig, sampled[n]));
    }
    TEST_ASSERT_EQUAL_DOUBLE(rig_value(rig, "true_u_dc"), rig_value(rig, "u_dc"));
}

static void expect_samples_are_the_truth(rig_t *rig, uint32_t periods)
{
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(rig);
        expect_sample_is_the_truth(rig);
    }
}

/* Largest |sampled - true| of the phases that have a sensor, over so many periods. */
static double largest_sample_error(rig_t *rig, uint32_t periods)
{
    double largest = 0.0;
    for (uint32_t n = 0; n < periods; n++) {
        rig_step(rig);
        for (uint32_t s = 0; s < BOARD_CURRENT_SENSORS; s++) {
            largest = fmax(largest, fabs(rig_value(rig, sampled[s]) - rig_value(rig, truths[s])));
        }
    }
    return largest;
}

/* ---- the timing convention ---- */

/* Each device at once and without drop; what the dead time costs comes back as turn-off delay, on both sides:
 * plant and firmware's compensation. The firmware trims no offsets: a turn is no whole number of samples, of
 * which its mean of the EMF, and with it the current, feels a share. */
static void make_inverter_ideal(rig_t *rig)
{
    static const char *const none[] = {
        "igbt_voltage",       "igbt_resistance",      "diode_voltage",
        "diode_resistance",   "plant.turn_on_delay",  "plant.current_zone",
        "params.device_drop", "params.turn_on_delay", "params.device_resistance",
        "params.offset_trim"};
    for (size_t n = 0; n < sizeof none / sizeof none[0]; n++) {
        run_put(rig, none[n], 0.0);
    }
    const double dead_time = rig_value(rig, "dead_time");
    run_put(rig, "plant.turn_off_delay", dead_time);
    run_put(rig, "params.turn_off_delay", dead_time);
    if (!rig_apply(rig)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
}

static double complex vector_of(double a, double b, double c)
{
    return CMPLX((2.0 * a - b - c) / 3.0, (b - c) / SQRT_3);
}

/* What the last interrupt wrote: shares of the link, as a vector [-]. They are the drive's duties to half a
 * count. */
static double complex share_written(rig_t *rig)
{
    static const char *const duties[] = {"duty_a", "duty_b", "duty_c"};
    static const uint32_t legs[] = {BOARD_LEG_A, BOARD_LEG_B, BOARD_LEG_C};
    double count[3];
    rig_bind(rig);
    for (uint32_t n = 0; n < 3; n++) {
        const double compare = EPWM(legs[n])->CMPA;
        /* the switch that is on while the counter is below it: the one whose zero vector is sampled */
        count[n] = BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR ? compare : HAL_PERIOD_COUNT - compare;
        TEST_ASSERT_DOUBLE_WITHIN(0.501, rig_value(rig, duties[n]) * HAL_PERIOD_COUNT, count[n]);
    }
    return vector_of(count[0], count[1], count[2]) / HAL_PERIOD_COUNT;
}

typedef struct {
    double complex current; /* [A] */
    double theta_e;         /* [rad] */
    double omega_e;         /* [rad/s] */
} instant_t;

static instant_t instant_of(rig_t *rig)
{
    return (instant_t){
        .current =
            vector_of(rig_value(rig, "true_i_a"), rig_value(rig, "true_i_b"), rig_value(rig, "true_i_c")),
        .theta_e = rig_value(rig, "true_theta_e"),
        .omega_e = rig_value(rig, "true_omega_e"),
    };
}

/* Current at t_{k+1} if u [V] stood from t_k on: L di/dt = u - R i - e, e = j omega psi exp(j theta), solved
 * for constant omega. The EMF's share is its mean over the period, weighted as R and L do:
 * 1/L int exp(-(R/L)(T - s)) e(s) ds = j omega psi/L exp(j theta) (exp(j omega T) - a)/(R/L + j omega). */
static double complex current_next(const plant_params_t *motor, const instant_t *now, double omega_e,
                                   double complex u)
{
    const double rate = motor->resistance / motor->inductance_d;
    const double a = exp(-rate * RIG_PERIOD_SECONDS);
    const double complex emf = CMPLX(0.0, omega_e * motor->flux_linkage) * cexp(CMPLX(0.0, now->theta_e));
    const double complex turned = cexp(CMPLX(0.0, omega_e * RIG_PERIOD_SECONDS));
    return a * now->current + (1.0 - a) / motor->resistance * u -
           emf / motor->inductance_d * (turned - a) / CMPLX(rate, omega_e);
}

/* Bound of the prediction, 5 N m and 1500 r/min on the paper's rig, in A:
 *   truth rows, floats: three currents below 8 A at either end move the vector by at most
 *     sqrt((4/3)^2 + (2/sqrt 3)^2) 2.4e-7 = 4.2e-7 each                                               8.4e-7
 *     angle, 1.2e-7 rad of half an ulp: omega psi T/L = 0.92 A times it                                1.1e-7
 *     speeds, 3.1e-5 rad/s: psi T/L = 1.46e-3 A s times it                                             4.5e-8
 *   the plant's series ends after four terms: (omega T)^5/120 = 8e-9 of some amperes                   1e-7
 *   the plant holds one speed per period, carried on from the last torques; mean of both ends here:
 *     1.5 T dT_m/J p, dT_m the change of torque between periods (asserted below 0.02 N m), times
 *     1.46e-3 A s                                                                                      2.8e-7
 * together 1.4e-6. One tick of 6.7 ns is worth more: it exchanges the voltages of two periods, some 7 V and
 * more apart, for that long, 7 V 6.7 ns/12.5 mH = 4e-6 A (asserted for the run). */
#define BOUND 1.4e-6

static void expect_voltages_act_in_their_period(double rpm)
{
    rig_t *rig = turning(rpm);
    make_inverter_ideal(rig);
    run_put(rig, "sensors", SENSORS_EXACT);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 2.0);
    run_expect_no_fault(rig);

    const plant_params_t *motor = &rig_state(rig)->plant.params;
    double complex shares[3] = {0}; /* written in the last periods, newest first */
    double error = 0.0;
    double tick = 0.0;        /* largest error that a voltage late or early by a tick would make */
    double early = INFINITY;  /* smallest error of the command one period too new */
    double late = INFINITY;   /* smallest error of the command one period too old */
    double frame = 0.0;       /* largest difference between i_alpha or i_beta and the truth */
    double largest = 0.0;     /* phase current */
    double torque_step = 0.0; /* largest change of the torque between periods */
    double torque_mean = 0.0;
    instant_t now = {0};
    double torque = 0.0;
    for (uint32_t n = 0; n < 803; n++) {
        rig_step(rig);
        const instant_t next = instant_of(rig);
        const double u_dc = rig_value(rig, "true_u_dc");
        const double torque_next = rig_value(rig, "true_torque");
        expect_sample_is_the_truth(rig);
        frame = fmax(frame, fabs(rig_value(rig, "i_alpha") - creal(next.current)));
        frame = fmax(frame, fabs(rig_value(rig, "i_beta") - cimag(next.current)));
        largest = fmax(largest, cabs(next.current));
        if (n >= 3) {
            /* This step is period k; shares[1] is of its command of k - 2. */
            const double omega = 0.5 * (now.omega_e + next.omega_e);
            error = fmax(error, cabs(current_next(motor, &now, omega, shares[1] * u_dc) - next.current));
            early = fmin(early, cabs(current_next(motor, &now, omega, shares[0] * u_dc) - next.current));
            late = fmin(late, cabs(current_next(motor, &now, omega, shares[2] * u_dc) - next.current));
            tick = fmax(tick, cabs(shares[1] - shares[2]) * u_dc * TICK / motor->inductance_d);
            torque_step = fmax(torque_step, fabs(torque_next - torque));
            torque_mean += torque_next / 800.0;
        }
        shares[2] = shares[1];
        shares[1] = shares[0];
        shares[0] = share_written(rig);
        now = next;
        torque = torque_next;
    }
    const char *const message = run_say(
        "%g r/min: off by %.2g A; a tick %.2g, a period early %.2g, late %.2g A; torque %.3f N m, steps %.2g",
        rpm, error, tick, early, late, torque_mean, torque_step);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(5.0, rpm, rig_value(rig, "true_omega_m") / RPM);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.1, copysign(6.32, rpm), torque_mean, message); /* load and friction */
    TEST_ASSERT_TRUE_MESSAGE(largest < 8.0, message);
    TEST_ASSERT_TRUE_MESSAGE(torque_step < 0.02, message);
    /* In half ulps of a current, the larger axis: phase c, which a drive of two sensors makes from a and b,
     * 4/3; differences and their sum, twice and four times as large, 8/3; the constant 1/3 and the product 2.
     */
    TEST_ASSERT_TRUE_MESSAGE(frame < 6.0 * HALF_ULP, message);
    TEST_ASSERT_TRUE_MESSAGE(error < BOUND, message);
    TEST_ASSERT_TRUE_MESSAGE(tick > 3.0 * BOUND, message);
    TEST_ASSERT_TRUE_MESSAGE(early > 1e4 * BOUND, message);
    TEST_ASSERT_TRUE_MESSAGE(late > 1e4 * BOUND, message);
    rig_free(rig);
}

static void test_each_voltage_acts_from_the_second_carrier_zero_after_its_sample_to_the_third(void)
{
    expect_voltages_act_in_their_period(1500.0);
}

static void test_each_voltage_acts_in_its_period_in_reverse_too(void)
{
    expect_voltages_act_in_their_period(-1500.0);
}

/* ---- exact samples ---- */

/* Everything wrong that a sensor can have, a link that moves, every gate edge: none of it shows. */
static void test_exact_samples_are_past_all_sensor_errors(void)
{
    rig_t *rig = turning(700.0);
    run_put(rig, "sensors", SENSORS_EXACT);
    run_put(rig, "fidelity", 0.0);
    run_put(rig, "current_gain_error_a", 0.02);
    run_put(rig, "current_gain_error_b", -0.03);
    run_put(rig, "current_offset_a", 0.3);
    run_put(rig, "current_offset_b", -0.2);
    run_put(rig, "current_gain_error_c", 0.03);
    run_put(rig, "current_offset_c", 0.2);
    run_put(rig, "current_noise", 0.1);
    run_put(rig, "plant.current_bandwidth", 5000.0);
    run_put(rig, "dc_gain_error", 0.02);
    run_put(rig, "dc_noise", 2.0);
    run_put(rig, "dc_resistance", 1.0);
    run_put(rig, "dc_capacitance", 1e-3);
    run_to_ready(rig);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "offset_a"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "offset_b"));
    run_put(rig, "enable", 1.0);
    expect_samples_are_the_truth(rig, 3000);
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE(fabs(rig_value(rig, "true_u_dc") - 311.0) > 0.5); /* the link did move */
    rig_free(rig);
}

/* A current sample of the ADC is off by its step and the noise, which is bounded: popcount and fraction of
 * one word end 24.5/sqrt(12 + 1/12) = 7.05 standard deviations out. Zero is measured too: at no current and
 * no noise all samples lie on one code, half a step beside. */
static void test_adc_samples_are_off_by_quantisation_and_noise_at_most(void)
{
    rig_t *rig = turning(700.0);
    run_put(rig, "current_noise", 0.0);
    run_to_ready(rig);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.2);
    const double quantised = largest_sample_error(rig, 2000);
    TEST_ASSERT_TRUE(quantised <= LSB + 1e-5);
    TEST_ASSERT_TRUE(quantised >
                     0.8 * LSB); /* the steps are there: of 4000 samples some come to either end */

    run_put(rig, "current_noise", 0.01);
    const double noisy = largest_sample_error(rig, 2000);
    TEST_ASSERT_TRUE(noisy <= LSB + 0.0705 + 1e-5);
    TEST_ASSERT_TRUE(noisy > 0.025); /* 4000 samples of 10 mA rms */

    run_put(rig, "sensors", SENSORS_EXACT);
    /* offset put on and taken off again: two roundings */
    TEST_ASSERT_TRUE(largest_sample_error(rig, 2000) <= 2.0 * HALF_ULP);
    run_expect_no_fault(rig);
    rig_free(rig);
}
