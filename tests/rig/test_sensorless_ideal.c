/* The estimate closes the loop; inverter and sensors are ideal, so what is left is the method and its floats.
 */
#include "tests/rig/no_rig.h"
#include "tests/rig/run.h"

/* ---- motors ---- */

typedef struct {
    const char *name;
    double pole_pairs, resistance, inductance, flux_linkage; /* [-], [ohm], [H], [Wb] */
    double inertia, friction, load;                          /* [kg m^2], [N m], [N m] */
    double speed;                                            /* [rad/s] largest, mechanical */
    double bandwidth;                                        /* [rad/s] of the speed control */
    double current, dc_voltage;                              /* [A] limit, [V] */
} motor_t;

/* Table I in its rig. */
static const motor_t paper = {.name = "paper",
                              .pole_pairs = 4.0,
                              .resistance = 0.95,
                              .inductance = 12.5e-3,
                              .flux_linkage = 0.183,
                              .inertia = 0.0636,
                              .friction = 1.32,
                              .load = 5.0,
                              .speed = 1500.0 * RPM,
                              .bandwidth = 8.0,
                              .current = 10.0,
                              .dc_voltage = 311.0};

/* Fast and light: omega_e T_s = 0.3 with one pole pair, 28648 r/min. */
static const motor_t spindle = {.name = "spindle",
                                .pole_pairs = 1.0,
                                .resistance = 0.4,
                                .inductance = 0.6e-3,
                                .flux_linkage = 0.03,
                                .inertia = 5e-5,
                                .friction = 0.03,
                                .load = 0.3,
                                .speed = 3000.0,
                                .bandwidth = 40.0,
                                .current = 10.0,
                                .dc_voltage = 200.0};

/* The same frequency from many poles, and hardly any inductance. */
static const motor_t hub = {.name = "hub",
                            .pole_pairs = 15.0,
                            .resistance = 0.12,
                            .inductance = 0.35e-3,
                            .flux_linkage = 0.015,
                            .inertia = 0.02,
                            .friction = 0.3,
                            .load = 2.5,
                            .speed = 200.0,
                            .bandwidth = 20.0,
                            .current = 12.0,
                            .dc_voltage = 100.0};

/* Slow, with much of everything. */
static const motor_t direct = {.name = "direct",
                               .pole_pairs = 20.0,
                               .resistance = 12.0,
                               .inductance = 60e-3,
                               .flux_linkage = 0.55,
                               .inertia = 0.5,
                               .friction = 3.0,
                               .load = 30.0,
                               .speed = 13.0,
                               .bandwidth = 20.0,
                               .current = 3.0,
                               .dc_voltage = 400.0};

/* Resistance rules: R T_s/L = 0.4, where 0.5 is the observer's limit. */
static const motor_t miniature = {.name = "miniature",
                                  .pole_pairs = 2.0,
                                  .resistance = 8.0,
                                  .inductance = 2e-3,
                                  .flux_linkage = 0.02,
                                  .inertia = 2e-5,
                                  .friction = 0.01,
                                  .load = 0.06,
                                  .speed = 1000.0,
                                  .bandwidth = 40.0,
                                  .current = 1.5,
                                  .dc_voltage = 100.0};

/* The same motor as the board can run it: with less current where its load needs more than the limit can be,
 * and a tenth to spare, and with less voltage where the board has no more. Impedances, flux linkage, shaft
 * and load go with them, and nothing of an angle or a time changes: L i/psi_f, R T_s/L, omega_e T_s and the
 * steps of the counter over the EMF are those of the motor as it is written down. */
static motor_t of_board(const motor_t *written)
{
    motor_t m = *written;
    const double current_max = 0.94 * (double)DRIVE_CURRENT_RANGE / 1.2;
    const double load_current = (m.friction + m.load) / (1.5 * m.pole_pairs * m.flux_linkage);
    const double current = fmin(1.0, current_max / (1.1 * load_current));
    const double voltage = fmin(1.0, BOARD_OVERVOLTAGE_MAX_MV / 1e3 / (1.1 * m.dc_voltage));
    m.resistance *= voltage / current;
    m.inductance *= voltage / current;
    m.flux_linkage *= voltage;
    m.inertia *= voltage * current;
    m.friction *= voltage * current;
    m.load *= voltage * current;
    m.forced.wanted = fmin(current_max, current * m.forced.wanted);
    m.dc_voltage *= voltage;
    return m;
}

static double trip_of(const motor_t *m)
{
    return fmin(1.5 * m->forced.wanted, 0.95 * (double)DRIVE_CURRENT_RANGE);
}

/* Plant and firmware get the motor, and limits around it. What is judged is the estimate: nothing of this
 * inverter is in doubt, so no current is needed against it, and the estimate turns the control down to a
 * fifteenth of the speed and less. */
static void put_motor(rig_t *rig, const motor_t *m)
{
    const run_motor_t motor = {m->pole_pairs, m->resistance, m->inductance, m->flux_linkage,
                               m->inertia,    m->friction,   m->speed,      m->bandwidth};
    run_put_motor(rig, &motor);
    run_put(rig, "dc_voltage", m->dc_voltage);
    run_put(rig, "current_limit", m->forced.wanted);
    run_put(rig, "overcurrent_trip", trip_of(m));
    run_put(rig, "dc_overvoltage", 1.1 * m->dc_voltage);
    run_put(rig, "dc_undervoltage", 0.6 * m->dc_voltage);
    run_put(rig, "overspeed_trip", 1.15 * m->speed);
    run_put(rig, "low_speed_current", 0.0);
    run_put(rig, "inductance_adaptation", 0.0);
    run_put(rig, "handover_speed", 0.05 * m->speed);
    run_put(rig, "fallback_speed", 0.02 * m->speed);
}

/* Table I on this board. It is as written wherever 5.8 A are within the limit. */
static motor_t paper_of_board(void)
{
    const motor_t m = of_board(&paper);
    TEST_ASSERT_EQUAL_DOUBLE(paper.inductance, m.inductance);
    return m;
}

/* ---- points ---- */

typedef struct {
    const char *name;
    double value;
} change_t;

#define AVERAGED 1.0
#define SWITCHED 0.0

#define ENCODER    0.0
#define SENSORLESS 1.0

/* On at this speed, with which the rotor turns already: the encoder shows the estimator the angle, then the
 * estimate takes over, if it shall. The catch of a start without it would be no start for all of these: until
 * it has seen the EMF no voltage holds that, and the current grows by e T_s/L a period, 10 A of the spindle.
 */
static void run_with(rig_t *rig, double source, double rpm)
{
    run_parameter(rig, "position_source", ENCODER);
    run_to_ready_at(rig, rpm);
    run_on(rig, rpm);
    run_seconds(rig, 0.1);
    run_parameter(rig, "position_source", source);
}

/* Rows are changed, the motor is driven to a point, and what the estimate is off there is measured. */
static run_error_t measure_with(double source, const char *what, const motor_t *m, double fidelity,
                                const change_t *changes, size_t count, double rpm, double load)
{
    rig_t *rig = run_rig(7);
    run_put(rig, "fidelity", fidelity);
    run_ideal(rig);
    put_motor(rig, m);
    for (size_t n = 0; n < count; n++) {
        run_put(rig, changes[n].name, changes[n].value);
    }
    run_with(rig, source, rpm);
    run_seconds(rig, 0.2);
    if (load > 0.0) {
        run_load(rig, load, 1.5);
    }
    run_seconds(rig, 2.5); /* the change from the encoder has been trimmed away */
    const run_error_t err = run_error(rig, 1.5);
    printf("%s, %s, %.0f r/min, %g N m: mean %.3f, SD %.3f, peak %.3f mrad\n", m->name, what, rpm, load,
           err.mean, err.sd, err.peak);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs(rpm), rpm, err.speed_mean);
    rig_free(rig);
    return err;
}

static run_error_t measure(const char *what, const motor_t *m, double fidelity, const change_t *changes,
                           size_t count, double rpm, double load)
{
    return measure_with(SENSORLESS, what, m, fidelity, changes, count, rpm, load);
}

static void expect_within(double limit, double wanted, double value, const char *what)
{
    char message[120];
    snprintf(message, sizeof message, "%s: %.3f mrad is not %.3f +- %.3f", what, value, wanted, limit);
    TEST_ASSERT_TRUE_MESSAGE(fabs(value - wanted) <= limit, message);
}

/* Where the upper gates are charged through the lower switches, these short the rotor until a sample shows
 * its current, which grows by e T_s/L a period, and for the period in which that acts. A board that charges
 * does not come on at a speed at which that trips it: such points are left to boards that do not. */
static bool comes_on_at(const motor_t *m, double rpm)
{
    const double emf = m->pole_pairs * m->flux_linkage * fabs(rpm) * RPM;
    return DRIVE_CHARGE_PERIODS == 0u || 2.0 * emf * RIG_PERIOD_SECONDS / m->inductance < trip_of(m);
}

/* Each point in one direction, so that speeds and loads have both in turn: without noise the other is its
 * mirror image. */
static double direction_of(uint32_t point)
{
    return (point + point / 2u) % 2u != 0u ? -1.0 : 1.0;
}

/* ---- the default: vector sigmoid, exact lag ---- */

/* With load and without. What algebra and floats leave of the worst motor on the worst
 * board, 0.001, 0.024 and 0.071 mrad, times 1.5. */
static void expect_no_error(const motor_t *written)
{
    const motor_t motor = of_board(written);
    const motor_t *m = &motor;
    static const double shares[] = {1.0 / 15.0, 1.0 / 3.0, 2.0 / 3.0, 1.0};
    grid_t grid = grid_of(m->name, 8u);
    for (uint32_t point; grid_next_documented(&grid, &point);) {
        const double load = point % 2u != 0u ? m->load : 0.0;
        const double rpm = direction_of(point) * shares[point / 2u] * m->speed / RPM;
        if (!comes_on_at(m, rpm)) {
            continue;
        }
        const run_error_t err = measure("default", m, AVERAGED, NULL, 0, rpm, load);
        expect_within(0.0015, 0.0, err.mean, "mean");
        expect_within(0.036, 0.0, err.sd, "SD");
        expect_within(0.11, 0.0, err.peak, "peak");
    }
}

static void test_paper_motor_from_100_to_1500_rpm(void)
{
    expect_no_error(&paper);
}

static void test_spindle_up_to_0_3_rad_per_sample(void)
{
    expect_no_error(&spindle);
}

static void test_hub_motor_up_to_0_3_rad_per_sample(void)
{
    expect_no_error(&hub);
}

static void test_slow_motor_of_large_inductance(void)
{
    expect_no_error(&direct);
}

static void test_motor_of_large_resistance(void)
{
    expect_no_error(&miniature);
}

/* A step of the PWM counter is 1/7500 of the link, 41 mV, and the EMF at 100 r/min is 7.7 V: unknown to the
 * observer, steps of 5 mrad in every sample, of which the loop lets an SD of 0.1 mrad through. It knows them.
 */
static void test_steps_of_the_counter_do_not_show(void)
{
    const motor_t m = paper_of_board();
    grid_t grid = grid_of("counter", 4u);
    for (uint32_t point; grid_next_documented(&grid, &point);) {
        const run_error_t err = measure("default", &m, AVERAGED, NULL, 0, (point & 1) != 0 ? -100.0 : 100.0,
                                        (point & 2) != 0 ? paper.load : 0.0);
        expect_within(0.03, 0.0, err.sd, "SD");
    }
}

/* By which share of a period the board's duties are lower than evenly about a half: the shortest pulse of a
 * lower switch is longer than that of an upper one where a shunt below it has to settle before the sample at
 * its middle. */
static double lower_by(void)
{
    const double upper = BOARD_DEAD_TIME_NS + BOARD_MINIMUM_PULSE_NS;
    const double settled = 2.0 * (BOARD_DEAD_TIME_NS + BOARD_SHUNT_SETTLED_NS);
    const double lower = BOARD_SAMPLES_AT == BOARD_LOWER_ZERO_VECTOR ? fmax(settled, upper) : upper;
    return 0.5 * (lower - upper) * 1e-9 / RIG_PERIOD_SECONDS;
}

/* With edges instead of mean voltages the "ideal" inverter is late by tau = 2.5 us, dead band and turn-off
 * delay alike. The pulses of a period still end in it, so their volt-seconds are right, but they have tau
 * less to decay: the observer sees u too large by R tau/L, of which j omega_e L i_q lies across the EMF,
 *
 *     mean = -R tau i_q/psi_f     whatever the speed
 *
 * 0.01 to 1.2 mrad here. A board that leaves the lower switches on for longer than the upper ones moves all
 * duties down, by half of the difference, c. Its pulses then lie nearer to the middle of the period, by c
 * T_s/2 of T_s/4, and have decayed by (R T_s/L)^2 c/8 more at its end, which the observer again takes for
 * voltage: up to 0.06 mrad. The rest, of second order in R tau/L and from the ripple, stays below the limit
 * of the averaged inverter. */
static void test_late_edges_turn_the_estimate_by_what_theory_says(void)
{
    static const motor_t *const motors[] = {&paper, &spindle, &hub, &direct, &miniature};
    grid_t grid = grid_of("late edges", 10u);
    for (uint32_t point; grid_next_documented(&grid, &point);) {
        const motor_t motor = of_board(motors[point / 2u]);
        const motor_t *m = &motor;
        const double direction = direction_of(point);
        const double load = point % 2u != 0u ? m->load : 0.0;
        if (!comes_on_at(m, 0.8 * m->speed / RPM)) {
            continue;
        }
        const double i_q = direction * (m->friction + load) / (1.5 * m->pole_pairs * m->flux_linkage);
        const double tau = BOARD_DEAD_TIME_NS * 1e-9;
        const double decay = m->resistance * RIG_PERIOD_SECONDS / m->inductance;
        const double across =
            1e3 * m->inductance * i_q / m->flux_linkage; /* [mrad] of a wrong voltage's share */
        const double wanted =
            -across * (m->resistance * tau / m->inductance - decay * decay * lower_by() / 8.0);
        const run_error_t err =
            measure("switched", m, SWITCHED, NULL, 0, direction * 0.8 * m->speed / RPM, load);
        expect_within(0.1, wanted, err.mean, "mean");
        expect_within(0.5 + fabs(wanted), 0.0, err.peak, "peak");
    }
}

/* ---- the paper's configuration ---- */

#define LAG_NONE      0.0
#define LAG_PRINTED   1.0
#define LAG_CORRECTED 2.0
#define LAG_EXACT     3.0

static run_error_t measure_paper(const char *what, double gain, double lag, double rpm, double load)
{
    const change_t changes[] = {
        {"observer_switching", 1.0}, {"observer_emf_cutoff", 0.0}, {"observer_gain", gain},
        {"observer_slope", 1.0},     {"lag_compensation", lag},
    };
    const motor_t m = paper_of_board();
    return measure(what, &m, AVERAGED, changes, sizeof changes / sizeof changes[0], rpm, load);
}

static const double speeds[] = {100.0, 500.0, 1000.0, 1500.0};

/* Four means, one for each speed, with load and without. */
static void expect_means(const char *what, double gain, double lag, const double wanted[4], double limit,
                         double sd_limit)
{
    grid_t grid = grid_of(what, 8u);
    for (uint32_t point; grid_next_documented(&grid, &point);) {
        const double direction = direction_of(point);
        const run_error_t err = measure_paper(what, gain, lag, direction * speeds[point / 2u],
                                              point % 2u != 0u ? paper.load : 0.0);
        expect_within(limit, direction * wanted[point / 2u], err.mean, "mean");
        TEST_ASSERT_TRUE(err.sd <= sd_limit);
    }
}

/* Means of docs/theory.md, 4; SD up to 1 mrad, the harmonics of the sigmoid per axis. */
static void test_paper_uncompensated(void)
{
    static const double wanted[] = {-3.1, -15.8, -33.1, -54.1};
    expect_means("none", 200.0, LAG_NONE, wanted, 1.0, 1.0);
}

static void test_paper_corrected_leaves_half_a_sample(void)
{
    static const double wanted[] = {2.1, 10.4, 20.7, 31.1};
    expect_means("corrected", 200.0, LAG_CORRECTED, wanted, 1.5, 1.0);
}

static void test_paper_exact_leaves_nothing(void)
{
    static const double wanted[] = {0.0, 0.0, 0.0, 0.0};
    expect_means("exact", 200.0, LAG_EXACT, wanted, 0.5, 1.0);
}

static void test_paper_printed_over_compensates(void)
{
    grid_t grid = grid_of("printed", 4u);
    for (uint32_t point; grid_next_documented(&grid, &point);) {
        const double direction = (point & 1) != 0 ? -1.0 : 1.0;
        const run_error_t err = measure_paper("printed", 200.0, LAG_PRINTED, direction * 1500.0,
                                              (point & 2) != 0 ? paper.load : 0.0);
        expect_within(1.5, direction * 35.5, err.mean, "mean");
    }
}

/* The 0.08 rad of the paper's Fig. 10 need k_s = 162 V with this timing. */
static void test_paper_deviation_of_its_fig_10(void)
{
    grid_t grid = grid_of("fig. 10", 4u);
    for (uint32_t point; grid_next_documented(&grid, &point);) {
        const double direction = (point & 1) != 0 ? -1.0 : 1.0;
        const run_error_t err = measure_paper("k_s 162 V", 162.0, LAG_NONE, direction * 1500.0,
                                              (point & 2) != 0 ? paper.load : 0.0);
        expect_within(3.0, direction * -80.0, err.mean, "mean");
    }
}

/* ---- the EMF's filter ---- */

/* Error over the 0.3 s that follow a change of the filter, and over the last 0.1 s of them [mrad]. */
static run_error_t filtered_at(rig_t *rig, double cutoff, double *peak)
{
    run_parameter(rig, "observer_emf_cutoff", cutoff);
    *peak = run_error(rig, 0.2).peak;
    return run_error(rig, 0.1);
}

/* It comes and goes while the estimate closes the loop. With the exact lag it is in the frame of the loop,
 * where a steady EMF does not see it: nothing may show. The paper's lag does not know it, so that it turns
 * the estimate by its phase at omega_e, x = omega_e T_s, c = exp(-cutoff T_s),
 *
 *     -atan2(c sin x, 1 - c cos x)
 *
 * and the loop goes there with a step's overshoot, which one of damping 1 with a feed-forward has, and back.
 * Limits of the peaks: 1.5 times what is there. */
static void test_the_filter_of_the_emf_may_change_while_the_drive_runs(void)
{
    static const double cutoff = 2500.0; /* [rad/s] */
    const motor_t m = paper_of_board();
    grid_t grid = grid_of("filter", 8u);
    for (uint32_t point; grid_next(&grid, &point);) {
        const double direction = (point & 1) != 0 ? -1.0 : 1.0;
        const bool exact = (point & 2) != 0;
        const bool vector = (point & 4) != 0;
        rig_t *rig = run_rig(7);
        run_put(rig, "fidelity", AVERAGED);
        run_ideal(rig);
        put_motor(rig, &m);
        run_put(rig, "observer_switching", vector ? SMO_SIGMOID_VECTOR : SMO_SIGMOID);
        run_put(rig, "lag_compensation", exact ? LAG_EXACT : LAG_CORRECTED);
        run_put(rig, "observer_emf_cutoff", 0.0);
        run_with(rig, SENSORLESS, direction * 1000.0);
        run_seconds(rig, 0.9);
        const double x = paper.pole_pairs * 1000.0 * RPM * RIG_PERIOD_SECONDS;
        const double c = exp(-cutoff * RIG_PERIOD_SECONDS);
        const double turned = exact ? 0.0 : -1e3 * direction * atan2(c * sin(x), 1.0 - c * cos(x));
        const run_error_t without = run_error(rig, 0.1);
        for (int32_t n = 0; n < 3; n++) {
            double on = 0.0;
            double off = 0.0;
            const run_error_t with = filtered_at(rig, cutoff, &on);
            const run_error_t again = filtered_at(rig, 0.0, &off);
            printf("%s, lag %s, %.0f r/min: %.3f, with the filter %.3f (theory %.3f more), again %.3f; peaks "
                   "%.3f, %.3f mrad\n",
                   vector ? "vector" : "axes", exact ? "exact" : "corrected", direction * 1000.0,
                   without.mean, with.mean, turned, again.mean, on, off);
            expect_within(0.5, turned, with.mean - without.mean, "with the filter");
            expect_within(0.2, without.mean, again.mean, "without it");
            if (exact) {
                expect_within(vector ? 0.17 : 0.38, 0.0, fmax(on, off), "peak");
            } else {
                expect_within(0.2 * fabs(turned), fabs(with.mean), on, "peak");
                expect_within(1.0, fabs(with.mean), off, "peak");
            }
        }
        run_expect_no_fault(rig);
        rig_free(rig);
    }
}

/* It begins with the EMF of the moment, not with that of the time when it was last there. */
static void test_a_filter_that_comes_back_has_forgotten_another_speed(void)
{
    const motor_t m = paper_of_board();
    rig_t *rig = run_rig(7);
    run_put(rig, "fidelity", AVERAGED);
    run_ideal(rig);
    put_motor(rig, &m);
    run_with(rig, SENSORLESS, 1400.0);
    run_seconds(rig, 0.4);
    run_parameter(rig, "observer_emf_cutoff", 0.0);
    run_put(rig, "speed_request", 300.0 * RPM);
    run_seconds(rig, 4.0);
    const double before = run_error(rig, 0.1).peak;
    run_parameter(rig, "observer_emf_cutoff", 2500.0);
    const double after = run_error(rig, 0.1).peak;
    printf("300 r/min: peak %.3f, with the filter again %.3f mrad\n", before, after);
    expect_within(0.03, 0.0, before, "peak without the filter");
    expect_within(0.03, 0.0, after, "peak with the filter");
    run_expect_no_fault(rig);
    rig_free(rig);
}

/* ---- sign ---- */

/* By the encoder, beside which the estimate is looked at: its chatter, a detector of 0.4 rms, is what a lost
 * lock looks like. */
static run_error_t measure_switching(const char *what, double switching, double rpm, double load)
{
    /* an EMF that chatters says nothing of the encoder */
    const change_t changes[] = {{"observer_switching", switching},
                                {"encoder_fault_reaction", (double)ENCODER_FAULT_IGNORED}};
    const motor_t m = paper_of_board();
    return measure_with(ENCODER, what, &m, AVERAGED, changes, 2, rpm, load);
}

/* The mean is less than half a sample, omega_e T_s/2, which is what a switch that acts once per sample can be
 * late or early by. At 1000 r/min a turn is 150 samples and the chatter locks to it, at 1013 it does not. */
static void test_sign_chatters_where_the_sigmoid_rests(void)
{
    grid_t grid = grid_of("sign", 8u);
    for (uint32_t point; grid_next(&grid, &point);) {
        const double direction = (point & 1) != 0 ? -1.0 : 1.0;
        /* the chatter reaches the speed control, which needs the same room above the load on every board */
        const double load =
            (point & 2) != 0 ? paper.load - RUN_TORQUE(paper.current - paper_of_board().current) : 0.0;
        const double rpm = direction * (point / 4 > 0 ? 1013.0 : 1000.0);
        const run_error_t sigmoid = measure_switching("sigmoid", 1.0, rpm, load);
        const run_error_t sign = measure_switching("sign", 0.0, rpm, load);
        expect_within(1e3 * 0.5 * RIG_PERIOD_SECONDS * paper.pole_pairs * fabs(rpm) * RPM, 0.0, sign.mean,
                      "mean of the sign");
        TEST_ASSERT_TRUE(sign.sd >= 20.0 * sigmoid.sd);
    }
}
