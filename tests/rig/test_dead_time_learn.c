/* The configured dead time and drop are 40 % too small or too large, on the real inverter. The tests
 * measure the learnt value, the time that learning takes, and the improvement of the estimate. */
#include <math.h>

#include "settings/reasons.h"
#include "tests/rig/run.h"

/* The required accuracy at 100 r/min is 5 % after 1.5 s, then a mean of 2 mrad and an SD of 6 mrad; at 50
 * r/min it is 5 % after 2.5 s and a mean of 12 mrad. If the current limit of the board is lower, the load
 * is lower, too. The limits come from 22 seeds: four standard deviations for a mean, and the mean plus
 * four standard deviations for a time or an SD. They are at least as large as the values of the kit. The
 * seeds were measured while the drive used the sixth harmonic; the twelfth has 1.5 times its noise
 * (docs/theory.md, 25), and the limits of mean, SD and voltage without load are larger by this factor.
 * Times below a second have 0.25 to 0.4 s more, because the drive does not use measurements that may be
 * noise. */
#define RATED (RUN_LIMIT_SHARE * 5.0) /* [N m] */

#define SENSORLESS 1.0
#define ENCODER    0.0

static const double factors[] = {0.6, 1.4};

/* The drive assumes this share of the effective dead time (by way of the delays) and of the drop. The
 * parameters are staged. */
static void assume(rig_t *rig, double share)
{
    const double dead_time = rig_value(rig, "dead_time");
    const double effective =
        dead_time + rig_value(rig, "params.turn_on_delay") - rig_value(rig, "params.turn_off_delay");
    const double more = share * effective - dead_time;
    run_put(rig, "params.turn_on_delay", fmax(0.0, more));
    run_put(rig, "params.turn_off_delay", fmax(0.0, -more));
    run_times(rig, "device_drop", share);
}

/* The loss of a leg [V] by the parameters of the plant, which is the true value of dead_time_hat. */
static double truth(rig_t *rig)
{
    const double effective = rig_value(rig, "dead_time") + rig_value(rig, "plant.turn_on_delay") -
                             rig_value(rig, "plant.turn_off_delay");
    const double drop = 0.5 * (rig_value(rig, "igbt_voltage") + rig_value(rig, "diode_voltage"));
    return effective / RIG_PERIOD_SECONDS * rig_value(rig, "u_dc") + drop;
}

static double learnt_share(rig_t *rig)
{
    return rig_value(rig, "dead_time_hat") / truth(rig);
}

/* A drive at this speed and load, with the right dead time and without learning. */
static rig_t *running(double rpm, double load, double source)
{
    const double rpm_loading = copysign(300.0, rpm);
    rig_t *rig = run_rig(7);
    run_put(rig, "fallback_speed", 3.0); /* 50 r/min use the estimate and not a forced frame */
    run_put(rig, "position_source", source);
    run_parameter(rig, "dead_time_adaptation", 0.0);
    run_real_under_load(rig, rpm, rpm_loading, load);
    run_seconds(rig, 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.0, learnt_share(rig));
    return rig;
}

/* Runs for this number of seconds, and returns the time [s] from which on the voltage is within 5 % until
 * the end; -1 if there is none. */
static double until_known(rig_t *rig, double seconds)
{
    double since = -1.0;
    for (int32_t n = 1; n <= (int32_t)(100.0 * seconds); n++) {
        run_seconds(rig, 0.01);
        if (fabs(learnt_share(rig) - 1.0) > 0.05) {
            since = -1.0;
        } else if (since < 0.0) {
            since = 0.01 * n;
        }
    }
    return since;
}

/* The assumed value becomes wrong from one period to the next, and learning begins. */
static double learn(rig_t *rig, double share, double seconds)
{
    assume(rig, share);
    run_parameter(rig, "dead_time_adaptation", 6.0);
    return until_known(rig, seconds);
}

/* At 100 r/min the drive trims the offsets of the sensors, at 50 r/min it does not. */
static void trim(rig_t *rig, double rpm)
{
    run_parameter(rig, "position_source", SENSORLESS);
    run_put(rig, "speed_request", copysign(100.0, rpm) * RPM);
    run_seconds(rig, 3.0);
    run_put(rig, "speed_request", rpm * RPM);
    run_seconds(rig, 2.0);
}

/* With an assumed share of 1.4 the EMF of 7.7 V at 100 r/min has an error of 4.1 V along the current, and
 * a drive on the estimate would lose the rotor. At and above the speed at which the drive hands over, it
 * does not lose it with a share of 1.3: 80 of 80 tries on two boards succeed within 1.05 s. With 1.4 the
 * speed may oscillate about its reference without load, three times a second and with 300 mrad. The current
 * then passes zero, the speed is wrong, most measurements do not count, and the motion of the learnt value
 * counts as chance: on the default board 40 of 40 tries succeed, on the kit 2 of 40 lose the rotor. The value
 * in use waits until chance is excluded: with the encoder, 1.4 at 100 r/min takes 0.94 to 1.07 s without load
 * (40 noises), and at 50 r/min 1.68 to 2.24 s (30 noises). At 50 r/min on the estimate the rotor would be
 * lost before the dead time is learnt; therefore the drive learns with the encoder and uses the estimate
 * afterwards. The largest mean of 30 noises there is 2 mrad for the kit and 11.6 mrad for the default board
 * without load. The SD of 64 noises without load is 1.8 mrad from 0.6 at 100 r/min, but 2.8 to 4.0 with a
 * mean of 6.1 in four of them, in which R was learnt 4 % and L 7 % wrong while V was not yet known; it is 2.4
 * (3.2 in one) from 1.4 at 100, and 3.6 (4.6) from 1.4 at 50 r/min. */
static const struct {
    double share;          /* assumed share of the dead time */
    double rpm, source;    /* speed and source of the angle while the drive learns */
    double within[2];      /* [s] time of learning without and with load */
    double mean[2], sd[2]; /* [mrad] angle error of the estimate after learning */
} lessons[] = {
    {0.6, 100.0, SENSORLESS, {1.3, 1.1}, {6.6, 6.6}, {5.2, 2.7}},
    {1.4, 100.0, ENCODER, {1.2, 0.9}, {4.9, 4.9}, {3.9, 3.3}},
    {1.3, 150.0, SENSORLESS, {1.4, 0.9}, {5.6, 5.6}, {2.8, 2.8}},
    {0.6, 50.0, ENCODER, {2.2, 1.9}, {10.1, 5.9}, {4.6, 4.6}},
    {1.4, 50.0, ENCODER, {2.6, 1.9}, {13.0, 5.9}, {5.6, 4.6}},
};

static void test_a_wrong_dead_time_is_learnt(void)
{
    grid_t grid = grid_of("lessons", 4u * sizeof lessons / sizeof lessons[0]);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double way = grid_axis(&n, 2u) == 0u ? 1.0 : -1.0;
        const bool loaded = grid_axis(&n, 2u) != 0u;
        const double rpm = way * lessons[n].rpm;
        rig_t *rig = running(rpm, loaded ? RATED : 0.0, lessons[n].source);
        const double since = learn(rig, lessons[n].share, fmax(4.0, 1.2 * lessons[n].within[loaded]));
        trim(rig, rpm);
        const run_error_t err = run_error(rig, 4.0);
        const char *const message = run_say(
            "from %.1f at %.0f r/min%s: 5 %% in %.2f s, then %.3f; mean %.2f, SD %.2f, peak %.0f mrad",
            lessons[n].share, rpm, loaded ? ", loaded" : "", since, learnt_share(rig), err.mean, err.sd,
            err.peak);
        run_expect_no_fault(rig);
        TEST_ASSERT_TRUE_MESSAGE(since >= 0.0 && since <= lessons[n].within[loaded], message);
        TEST_ASSERT_TRUE_MESSAGE(fabs(err.mean) <= lessons[n].mean[loaded], message);
        TEST_ASSERT_TRUE_MESSAGE(err.sd <= lessons[n].sd[loaded], message);
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs(rpm), rpm, err.speed_mean);
        rig_free(rig);
    }
}

/* The speed goes down to 20 r/min under load, and the value learnt at 100 r/min remains. At 30 r/min the
 * SD is 7.3 +- 0.5 mrad over 12 seeds. */
static void test_staircase_to_20_rpm(void)
{
    static const double stairs[] = {150.0, 100.0, 50.0, 30.0, 20.0};
    grid_t grid = grid_of("staircase", 2u);
    for (uint32_t n; grid_next(&grid, &n);) {
        rig_t *rig = running(150.0, RATED, SENSORLESS);
        assume(rig, factors[n]);
        run_put(rig, "estimate_speed_min", 1.0);
        run_put(rig, "fallback_speed", 1.0);
        run_parameter(rig, "dead_time_adaptation", 6.0);
        for (size_t k = 0; k < sizeof stairs / sizeof stairs[0]; k++) {
            run_put(rig, "speed_request", stairs[k] * RPM);
            run_seconds(rig, 3.0);
            const run_error_t err = run_error(rig, 3.0);
            const char *const message = run_say("from %.1f, %.0f r/min: mean %.2f, SD %.2f mrad, V %.3f",
                                                factors[n], stairs[k], err.mean, err.sd, learnt_share(rig));
            TEST_ASSERT_TRUE_MESSAGE(fabs(err.mean) <= 5.6, message); /* the requirement is 20 mrad */
            TEST_ASSERT_TRUE_MESSAGE(err.sd <= 9.3, message);
            TEST_ASSERT_DOUBLE_WITHIN(0.05 * stairs[k], stairs[k], err.speed_mean);
            TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "lock_losses"));
        }
        run_expect_no_fault(rig);
        rig_free(rig);
    }
}

/* Makes the rotor so light that its speed follows every torque. The parameters are staged. */
static void light(rig_t *rig)
{
    run_put(rig, "inertia", 0.003 * RUN_LIMIT_SHARE);
    run_put(rig, "motor_inertia", 0.003 * RUN_LIMIT_SHARE);
    run_put(rig, "friction_coulomb", 0.05);
    run_put(rig, "pll_bandwidth", 400.0);
    run_put(rig, "feedforward_cutoff", 125.0);
}

/* A drive with the rotor of the test rig or the light one at standstill; no parameters are applied yet. */
static rig_t *standing(bool is_light)
{
    rig_t *rig = run_rig(7);
    if (is_light) {
        light(rig);
    } else {
        run_times(rig, "inertia", RUN_LIMIT_SHARE);
        run_times(rig, "motor_inertia", RUN_LIMIT_SHARE);
        run_times(rig, "friction_coulomb", RUN_LIMIT_SHARE);
    }
    return rig;
}

/* Starts from this angle [rad] to this speed under this load, without an encoder and with learning. */
static void start(rig_t *rig, double theta, double rpm, double load)
{
    run_put(rig, "dead_time_adaptation", 6.0);
    run_parameter(rig, "position_source", SENSORLESS);
    rig_set_motion(rig, theta, 0.0);
    run_to_ready(rig);
    run_real(rig);
    run_put(rig, "load_torque", load);
    run_on(rig, rpm);
}

/* The start leads from standstill to 100 r/min, where by the rule a forced frame rotates together with the
 * estimate; the drive learns during the acceleration and at the final speed. The learnt value must be within
 * 5 % after 2.4 s: with eight seeds the light rotor under 5 N m, from 1.4 rad, needs 1.97 to 2.17 s, and the
 * other starts need 1.4 s at most. The angle error may have a mean of 2 mrad, which is the
 * rms of the light rotor without load, and an SD of 6 mrad.
 *
 * With a dead time that is assumed too large by this share, not every try starts the rotor of the test rig
 * under the rated load, and the 6.3 A of the kit do not always start a light rotor: of 24 seeds 15 started
 * at the first try, 7 at a later one, and 2 gave up (docs/not_there.md). The drive must have learnt the
 * value or report a stall. */
static void expect_started_or_given_up(rig_t *rig)
{
    run_seconds(rig, 8.0);
    const char *const message = run_say("not promised: V %.3f, try %.0f, fault %.0f", learnt_share(rig),
                                        rig_value(rig, "start_try"), rig_value(rig, "fault_reason"));
    if (rig_value(rig, "fault_reason") != (double)REASON_START_STALLED) {
        run_expect_no_fault(rig);
        TEST_ASSERT_TRUE_MESSAGE(fabs(learnt_share(rig) - 1.0) <= 0.05, message);
    }
}

static void expect_started(rig_t *rig, double rpm)
{
    for (int32_t k = 0; k < 600 && fabs(rig_value(rig, "true_omega_m") / (rpm * RPM) - 1.0) > 0.1; k++) {
        run_seconds(rig, 0.01);
    }
    const double since = until_known(rig, 3.0);
    run_seconds(rig, 3.0);
    const run_error_t err = run_error(rig, 4.0);
    const char *const message =
        run_say("to %.0f r/min: 5 %% in %.2f s; mean %.2f, SD %.2f", rpm, since, err.mean, err.sd);
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE_MESSAGE(since >= 0.0 && since <= 2.4, message);
    TEST_ASSERT_TRUE_MESSAGE(fabs(err.mean) <= 6.1, message);
    TEST_ASSERT_TRUE_MESSAGE(err.sd <= 3.8, message);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, rpm, err.speed_mean);
}

static void test_a_start_to_100_rpm_learns_it(void)
{
    grid_t grid = grid_of("start to 100 r/min", 16u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double share = factors[grid_axis(&n, 2u)];
        const double load = grid_axis(&n, 2u) != 0u ? RATED : 0.0;
        const double rpm = grid_axis(&n, 2u) != 0u ? -100.0 : 100.0;
        const bool is_light = n != 0u;
        rig_t *rig = standing(is_light);
        assume(rig, share);
        start(rig, 0.0, rpm, load);
        printf("%s rotor, from %.1f, %g N m: ", is_light ? "light" : "rig's", share, load);
        if (share > 1.0 && load > 0.0 && (!is_light || BOARD_CURRENT_LIMIT_MA < 10000)) {
            expect_started_or_given_up(rig);
        } else {
            expect_started(rig, rpm);
        }
        rig_free(rig);
    }
}

/* A rotor of negligible inertia follows a current that rotates slowly. Its natural frequency, 19 Hz at 10
 * A, is near six times the electrical frequency, so that its oscillation resembles dead time. A learnt
 * value must not change. */
static void test_a_light_rotor_in_a_slow_forced_frame_teaches_nothing_wrong(void)
{
    static const double speeds[] = {50.0, 60.0, 70.0, 80.0};
    grid_t grid = grid_of("forced", 8u);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double rpm = speeds[n / 2u];
        rig_t *rig = standing(true);
        run_put(rig, "handover_speed", 200.0 * RPM);
        start(rig, 0.0, rpm, n % 2u != 0u ? RATED : 0.0);
        run_seconds(rig, 6.0);
        const char *const message = run_say("light rotor forced at %.0f r/min, %g N m: V %.3f", rpm,
                                            n % 2u != 0u ? RATED : 0.0, learnt_share(rig));
        run_expect_no_fault(rig);
        TEST_ASSERT_EQUAL_DOUBLE((double)MANOEUVRE_FORCED, rig_value(rig, "manoeuvre"));
        TEST_ASSERT_TRUE_MESSAGE(fabs(learnt_share(rig) - 1.0) <= 0.015, message);
        rig_free(rig);
    }
}
