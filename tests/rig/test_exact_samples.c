/* Ideal sensors (`sensors` = exact): the drive gets the truth of t_k, at every period, in every order of
 * switching. With an ideal inverter besides, the closed loop shows the timing convention to the tick: the
 * voltage that the interrupt of period k commands acts on [t_{k+1}, t_{k+2}), all of it and nothing else. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drive/reasons.h"
#include "hal/f28335/bus.h"
#include "hal/hal.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/no_rig.h"
#include "tests/rig/run.h"

#define SENSORS_ADC   0.0
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

/* ---- the instant of the sample ---- */

/* Of each sensor, rms over so many periods: what the drive believes minus what flows. Every gate edge or mean
 * voltages; the noise is the samples' own. Beyond it is less than one code: half a step that the measured
 * zero may lie beside, the rounding, and the 0.28 us that a third current is held later, in which the largest
 * EMF here moves it by 2.6 mA. */
static void expect_currents_within_a_code(double fidelity, double noise)
{
    rig_t *rig = turning(1500.0);
    double square[3] = {0.0};
    run_put(rig, "fidelity", fidelity);
    run_put(rig, "current_noise", noise);
    run_to_ready(rig);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.3);
    for (uint32_t n = 0; n < 4000; n++) {
        rig_step(rig);
        for (uint32_t s = 0; s < BOARD_CURRENT_SENSORS; s++) {
            const double error = rig_value(rig, sampled[s]) - rig_value(rig, truths[s]);
            square[s] += error * error / 4000.0;
        }
    }
    run_expect_no_fault(rig);
    for (uint32_t s = 0; s < BOARD_CURRENT_SENSORS; s++) {
        char message[120];
        snprintf(message, sizeof message, "%s: %.2f mA rms, noise %.1f, a code %.2f", sampled[s],
                 1e3 * sqrt(square[s]), 1e3 * noise, 1e3 * LSB);
        printf("  fidelity %.0f, %s\n", fidelity, message);
        TEST_ASSERT_TRUE_MESSAGE(square[s] <= noise * noise + LSB * LSB, message);
        TEST_ASSERT_TRUE_MESSAGE(square[s] > 0.9 * noise * noise, message);
    }
    rig_free(rig);
}

static void test_currents_of_each_sensor_are_within_a_code_of_the_truth(void)
{
    for (int32_t n = 0; n < 4; n++) {
        expect_currents_within_a_code(n % 2, n / 2 == 0 ? 0.0 : 0.01);
    }
}

/* What the gates are at the instants t_k. */
typedef struct {
    uint64_t next;     /* [ticks] the t_k that comes */
    uint64_t since[3]; /* [ticks] when the sampled side's switch of each leg came on */
    uint32_t on;       /* six commands */
    uint32_t samples;  /* [periods] seen, all commands known */
    uint32_t others;   /* [periods] in which a switch of the other side was on */
    uint32_t away;     /* [periods] in which one of the sampled side was not */
    uint64_t before;   /* [ticks] shortest time that the three had been on */
    uint64_t after;    /* [ticks] shortest time that they stayed on */
} zero_vector_t;

#define SAMPLED_SIDE  (BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR ? 0u : 1u)
#define OF_LEGS(side) (0x15u << (side))

static void on_gates_at_samples(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    zero_vector_t *seen = context;
    if (what != RIG_EDGE_GATES) {
        return;
    }
    while (seen->next < tick) {
        seen->samples++;
        seen->others += (seen->on & OF_LEGS(1u - SAMPLED_SIDE)) != 0u;
        seen->away += (seen->on & OF_LEGS(SAMPLED_SIDE)) != OF_LEGS(SAMPLED_SIDE);
        for (uint32_t leg = 0; leg < 3u; leg++) {
            const bool on = (seen->on >> (2u * leg + SAMPLED_SIDE) & 1u) != 0u;
            const uint64_t age = on ? seen->next - seen->since[leg] : 0u;
            seen->before = age < seen->before ? age : seen->before;
        }
        seen->after = tick - seen->next < seen->after ? tick - seen->next : seen->after;
        seen->next += RIG_PERIOD_TICKS;
    }
    for (uint32_t leg = 0; leg < 3u; leg++) {
        const uint32_t bit = 1u << (2u * leg + SAMPLED_SIDE);
        if ((value & bit) != 0u && (seen->on & bit) == 0u) {
            seen->since[leg] = tick;
        }
    }
    seen->on = value;
}

/* A link too low for the speed: some leg has its largest duty, another its smallest, in every period. t_k is
 * the middle of the shortest pulse, which lacks the dead time at its beginning. Where shunts below the lower
 * switches are sampled, what is left of its first half is the time that they need to settle. */
static void test_currents_are_held_in_the_zero_vector_that_the_board_needs(void)
{
    rig_t *rig = turning(1500.0);
    zero_vector_t seen = {.before = UINT64_MAX, .after = UINT64_MAX};
    run_put(rig, "fidelity", 0.0);
    run_put(rig, "dc_voltage", 1.02 * rig_value(rig, "dc_undervoltage"));
    run_to_ready(rig);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.1);
    rig_watch_edges(rig, on_gates_at_samples, &seen);
    rig_step(rig); /* each leg switches */
    seen = (zero_vector_t){
        .next = RIG_PERIOD_TICKS * rig_period(rig), .on = seen.on, .before = UINT64_MAX, .after = UINT64_MAX};
    memcpy(seen.since,
           (uint64_t[3]){seen.next - RIG_PERIOD_TICKS, seen.next - RIG_PERIOD_TICKS,
                         seen.next - RIG_PERIOD_TICKS},
           sizeof seen.since);
    rig_run(rig, 2000);
    run_expect_no_fault(rig);
    rig_watch_edges(rig, NULL, NULL);

    const double dead = BOARD_DEAD_TIME_NS;
    const double half_pulse = fmax(dead + BOARD_SHUNT_SETTLED_NS, 0.5 * (dead + BOARD_MINIMUM_PULSE_NS));
    const double before = 1e9 * TICK * (double)seen.before;
    const char *const message =
        run_say("%u samples: on for %.0f ns at least, another %.0f; off in %u, others on in %u", seen.samples,
                before, 1e9 * TICK * (double)seen.after, seen.away, seen.others);
    TEST_ASSERT_TRUE_MESSAGE(seen.samples > 1990u, message);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, seen.others, message);
    if (half_pulse > dead) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, seen.away, message);
        TEST_ASSERT_TRUE_MESSAGE(before >= BOARD_SHUNT_SETTLED_NS, message);
        TEST_ASSERT_TRUE_MESSAGE(1e9 * TICK * (double)seen.after >= BOARD_SHUNT_SETTLED_NS, message);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(20.0, half_pulse - dead, before, message); /* it was reached */
    } else {
        TEST_ASSERT_TRUE_MESSAGE(seen.away > 1000u, message); /* it was reached: nothing is on yet */
    }
    rig_free(rig);
}

/* ---- switching ---- */

static void test_sensors_may_change_while_the_drive_runs_and_back(void)
{
    rig_t *rig = turning(700.0);
    run_put(rig, "current_noise", 0.0);
    run_put(rig, "current_offset_a", 0.3); /* measured by the drive and taken off */
    run_put(rig, "current_offset_b", -0.2);
    run_to_ready(rig);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.2);
    const double zero = rig_value(rig, "offset_a");
    TEST_ASSERT_DOUBLE_WITHIN(LSB, 0.3, zero);
    TEST_ASSERT_TRUE(largest_sample_error(rig, 500) > 1e-3);

    run_put(rig, "sensors", SENSORS_EXACT);
    TEST_ASSERT_TRUE(largest_sample_error(rig, 500) <= 2.0 * HALF_ULP);
    TEST_ASSERT_EQUAL_DOUBLE(zero, rig_value(rig, "offset_a"));

    run_put(rig, "sensors", SENSORS_ADC);
    const double error = largest_sample_error(rig, 500);
    TEST_ASSERT_TRUE(error > 1e-3);
    TEST_ASSERT_TRUE(error <= LSB + 1e-5);
    run_expect_no_fault(rig);
    rig_free(rig);
}

static void test_sensors_may_change_while_offsets_are_measured(void)
{
    rig_t *rig = turning(700.0);
    run_put(rig, "current_offset_a", 0.5);
    rig_run(rig, 300); /* of 64 that settle and 512 that are averaged */
    run_put(rig, "sensors", SENSORS_EXACT);
    run_to_ready(rig);
    /* the mean of (300 - 64) samples of 0.5 A and of zeros */
    TEST_ASSERT_DOUBLE_WITHIN(LSB, 0.5 * 236.0 / 512.0, rig_value(rig, "offset_a"));
    run_put(rig, "enable", 1.0);
    TEST_ASSERT_TRUE(largest_sample_error(rig, 1000) <= 2.0 * HALF_ULP);
    run_expect_no_fault(rig);

    /* A reset measures anew: of these sensors, which have no offset. */
    run_put(rig, "force_fault", 1.0);
    run_seconds(rig, 0.01);
    run_put(rig, "enable", 0.0);
    run_put(rig, "force_fault", 0.0);
    run_seconds(rig, 0.03);
    run_put(rig, "fault_reset", 1.0);
    run_seconds(rig, 0.1);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "offset_a"));
    run_put(rig, "enable", 1.0);
    expect_samples_are_the_truth(rig, 1000);
    run_expect_no_fault(rig);
    rig_free(rig);
}

static void test_unknown_sensors_are_refused_and_those_in_force_stay(void)
{
    rig_t *rig = turning(700.0);
    TEST_ASSERT_EQUAL_UINT32(5006, rig_row_by_name("sensors")->id);
    TEST_ASSERT_EQUAL_DOUBLE(SENSORS_ADC, rig_value(rig, "sensors"));
    run_put(rig, "sensors", SENSORS_EXACT);
    run_to_ready(rig);
    const double wrong[] = {2.0, -1.0, 0.5, NAN};
    for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
        TEST_ASSERT_FALSE(rig_put(rig, "sensors", wrong[n]));
        TEST_ASSERT_EQUAL_INT32(REASON_OUT_OF_RANGE, rig_error_reason(rig));
        TEST_ASSERT_EQUAL_UINT32(5006, rig_error_id(rig));
    }
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(rig_error(rig), "accepted whole numbers 0 to 1"), rig_error(rig));
    TEST_ASSERT_EQUAL_DOUBLE(SENSORS_EXACT, rig_value(rig, "sensors"));
    run_put(rig, "enable", 1.0);
    expect_samples_are_the_truth(rig, 500);
    rig_free(rig);
}

/* The vector of the interrupt is a protected register; the chip counts every misuse. */
static void test_switching_is_no_misuse_of_the_chip(void)
{
    rig_t *rig = turning(700.0);
    for (int n = 0; n < 10; n++) {
        run_put(rig, "sensors", n % 2 == 0 ? SENSORS_EXACT : SENSORS_ADC);
        rig_run(rig, 10);
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "chip_reports"));
    TEST_ASSERT_EQUAL_DOUBLE(100.0, rig_value(rig, "period"));
    rig_free(rig);
}

/* ---- several rigs, saved states, timed runs ---- */

static rig_t *running(double rpm, double sensors)
{
    rig_t *rig = turning(rpm);
    run_put(rig, "sensors", sensors);
    run_to_ready(rig);
    run_put(rig, "enable", 1.0);
    run_seconds(rig, 0.1);
    return rig;
}

static void test_rigs_in_turn_get_each_its_own_truth(void)
{
    rig_t *a = running(700.0, SENSORS_EXACT);
    rig_t *b = running(-400.0, SENSORS_EXACT);
    rig_t *c = running(700.0, SENSORS_ADC);
    rig_t *alone = running(700.0, SENSORS_EXACT);
    rig_run(alone, 500);
    for (int n = 0; n < 500; n++) {
        expect_samples_are_the_truth(a, 1);
        expect_samples_are_the_truth(b, 1);
        rig_step(c);
    }
    TEST_ASSERT_EQUAL_HEX64(rig_hash(alone), rig_hash(a));
    TEST_ASSERT_TRUE(largest_sample_error(c, 500) > 1e-3);
    rig_free(a);
    rig_free(b);
    rig_free(c);
    rig_free(alone);
}

static void test_a_saved_state_goes_on_with_its_own_sensors(void)
{
    const double kinds[] = {SENSORS_EXACT, SENSORS_ADC};
    for (size_t n = 0; n < 2; n++) {
        rig_t *rig = running(1200.0, kinds[n]);
        void *state = malloc(rig_state_size());
        TEST_ASSERT_NOT_NULL(state);
        rig_save(rig, state);
        rig_run(rig, 1000);
        const uint64_t end = rig_hash(rig);

        rig_t *other = running(-300.0, kinds[1 - n]);
        TEST_ASSERT_TRUE(rig_load(other, state, rig_state_size()));
        TEST_ASSERT_EQUAL_DOUBLE(kinds[n], rig_value(other, "sensors"));
        rig_run(other, 1000);
        TEST_ASSERT_EQUAL_HEX64(end, rig_hash(other));

        run_put(rig, "sensors", kinds[1 - n]); /* back in time over a change of sensors */
        rig_run(rig, 100);
        TEST_ASSERT_TRUE(rig_load(rig, state, rig_state_size()));
        rig_run(rig, 1000);
        TEST_ASSERT_EQUAL_HEX64(end, rig_hash(rig));
        free(state);
        rig_free(rig);
        rig_free(other);
    }
}

static void test_timing_the_interrupt_changes_nothing(void)
{
    const double kinds[] = {SENSORS_EXACT, SENSORS_ADC};
    for (size_t n = 0; n < 2; n++) {
        rig_t *timed = running(700.0, kinds[n]);
        rig_t *plain = running(700.0, kinds[n]);
        TEST_ASSERT_TRUE(rig_interrupt_seconds(timed, 500) > 0.0);
        rig_run(plain, 500);
        TEST_ASSERT_EQUAL_HEX64(rig_hash(plain), rig_hash(timed));
        rig_run(timed, 500);
        rig_run(plain, 500);
        TEST_ASSERT_EQUAL_HEX64(rig_hash(plain), rig_hash(timed));
        rig_free(timed);
        rig_free(plain);
    }
}
