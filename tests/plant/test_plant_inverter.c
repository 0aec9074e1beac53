/* Legs, delays, dead time, averaged mode, protection, broken phases. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/plant/interval.h"
#include "tests/plant/bench.h"
#include "unity.h"

#define RPM (3.14159265358979323846 / 30.0) /* [rad/s] */

static plant_params_t locked(void)
{
    return plant_of("shaft_locked = 1");
}

/* ---- dead time ---- */

/* The mean of u_alpha in steady state over one period, in which leg a is high for `high_a` and legs b and
 * c for `high_bc`. */
static double mean_alpha(const plant_params_t *q, uint32_t high_a, uint32_t high_bc, uint32_t dead,
                         bool averaged)
{
    uint32_t high[3] = {high_a, high_bc, high_bc};
    double before = 0.0;
    double after = 0.0;
    plant_init(&plant, q, 1);
    for (uint64_t k = 0; k < 2000; k++) { /* 200 ms, 15 time constants */
        uint64_t start = k * LOOP_PERIOD;
        before = after;
        if (averaged) {
            plant_carrier(&plant, start, LOOP_PERIOD, high, dead, false);
        } else {
            /* Leg a has the longer pulse: its edges come first and last. */
            uint64_t rise_a = start + (LOOP_PERIOD - high_a) / 2u;
            uint64_t rise_bc = start + (LOOP_PERIOD - high_bc) / 2u;
            uint32_t lower = PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2);
            uint32_t upper_bc = PLANT_UPPER(1) | PLANT_UPPER(2);
            plant_gates(&plant, rise_a, lower & ~PLANT_LOWER(0));
            plant_gates(&plant, rise_a + dead, (lower & ~PLANT_LOWER(0)) | PLANT_UPPER(0));
            plant_gates(&plant, rise_bc, PLANT_UPPER(0));
            plant_gates(&plant, rise_bc + dead, PLANT_UPPER(0) | upper_bc);
            plant_gates(&plant, rise_bc + high_bc, PLANT_UPPER(0));
            plant_gates(&plant, rise_bc + high_bc + dead, PLANT_UPPER(0) | (lower & ~PLANT_LOWER(0)));
            plant_gates(&plant, rise_a + high_a, lower & ~PLANT_LOWER(0));
            plant_gates(&plant, rise_a + high_a + dead, lower);
        }
        after = truth_at(start + LOOP_PERIOD).flux_alpha;
    }
    return (after - before) / 1e-4;
}

static void test_dead_time_error_is_that_of_the_formula(void)
{
    /* docs/theory.md, 12, with the drops at 4.55 A, 0.8 + 0.018 * 4.55 V and 0.95 + 0.025 * 4.55 V. In
     * this test the drops have no slope, so that they do not depend on the current. The current flows into
     * a and out of b and c, so that the error of the vector is 4/3 of that of a leg. */
    static const uint32_t dead[] = {300, 375, 450};
    static const double row[] = {6.6, 8.1, 9.7};
    plant_params_t q = plant_with(
        locked(),
        "igbt_voltage = 0.8819, igbt_resistance = 0, diode_voltage = 1.06375, diode_resistance = 0");
    for (int n = 0; n < 3; n++) {
        double t_e = (dead[n] + 105.0 - 135.0) / LOOP_PERIOD;
        double v =
            t_e * (311.0 - q.igbt_voltage + q.diode_voltage) + 0.5 * (q.igbt_voltage + q.diode_voltage);
        /* The small term is (d - 1/2)(V_ce - V_f), for d = 0.56 and 0.44. */
        double small = 2.0 / 3.0 * (0.06 + 0.06) * (q.igbt_voltage - q.diode_voltage);
        double commanded = 2.0 / 3.0 * 0.12 * 311.0;
        for (int averaged = 0; averaged < 2; averaged++) {
            double error = commanded - mean_alpha(&q, 8400, 6600, dead[n], averaged);
            /* The edges are exact to the tick; the remaining errors are rounding and the e^-15 that
             * remains of the settling. */
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 4.0 / 3.0 * v + small, error);
            TEST_ASSERT_DOUBLE_WITHIN(0.07, row[n],
                                      error * 0.75); /* covers the rounding of the table and the small term */
        }
    }
}

static void test_averaged_mode_has_no_error_where_nothing_switches(void)
{
    plant_params_t q = plant_with(locked(), "dc_voltage = 20, " NO_DROPS);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0 / 3.0 * 20.0, mean_alpha(&q, LOOP_PERIOD, 0, 375, true));
    /* The pulse is one tick shorter, and the upper transistor of leg a turns on T_e late: 345 ticks of the
     * period. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0 / 3.0 * 20.0 * (1.0 - 346.0 / LOOP_PERIOD),
                              mean_alpha(&q, LOOP_PERIOD - 1, 0, 375, true));
    /* A pulse shorter than T_e has no effect: the current stays in the zone, so that the mean voltage is
     * at most R times the zone. */
    TEST_ASSERT_DOUBLE_WITHIN(0.95 * 0.05, 0.0, mean_alpha(&q, 300, 0, 375, true));
}

/* The averaged inverter compared with single periods of a switched one. Each averaged period begins with
 * the currents at the end of the previous switched period. */
typedef struct {
    double rms;            /* [V] averaged minus switched mean voltage of a period */
    double one_current;    /* [V] the same difference if both edges of a leg had the mean current */
    double mean_d, mean_q; /* [V] mean of the difference `rms`, in the rotor frame */
} missed_t;

/* The mean leg voltage of a period [V] if both edges had this current: the plant's laws of both switches,
 * weighted by their on-times. */
static double by_one_current(uint32_t high, uint32_t dead, double i)
{
    double error = (double)dead + (double)plant.turn_on_ticks[0] - (double)plant.turn_off_ticks;
    double sign = i * plant.zone_inverse;
    sign = sign > 1.0 ? 1.0 : sign < -1.0 ? -1.0 : sign;
    double share = ((double)high - error * sign) / LOOP_PERIOD;
    double unused;
    return share * interval_pole(&plant, &plant.law[0][PLANT_LAW_UPPER], i, &unused) +
           (1.0 - share) * interval_pole(&plant, &plant.law[0][PLANT_LAW_LOWER], i, &unused);
}

static missed_t compare(const plant_params_t *q, double i_d, double i_q, uint32_t upper_ends)
{
    enum { SETTLING = 1000, PERIODS = 4000 };
    static plant_t averaged;
    missed_t missed = {0.0, 0.0, 0.0, 0.0};
    setUp();
    loop.i_d_ref = i_d;
    loop.i_q_ref = i_q;
    loop.upper_ends = upper_ends;
    plant_init(&plant, q, 1);
    for (int k = 0; k < SETTLING + PERIODS; k++) {
        const uint32_t high[3] = {loop.high[0], loop.high[1], loop.high[2]};
        const plant_t before = plant;
        loop_period(&loop, &plant, NULL, NULL);
        if (k < SETTLING) {
            continue;
        }
        averaged = before;
        plant_carrier(&averaged, before.tick, LOOP_PERIOD, high, loop.dead, upper_ends != 0u);
        plant_advance(&averaged, before.tick + LOOP_PERIOD);
        double v[3];
        for (int leg = 0; leg < 3; leg++) {
            v[leg] = by_one_current(high[leg], loop.dead, 0.5 * (before.i[leg] + plant.i[leg]));
        }
        double alpha = (averaged.flux_alpha - plant.flux_alpha) * 1e4;
        double beta = (averaged.flux_beta - plant.flux_beta) * 1e4;
        double one_alpha = (2.0 * v[0] - v[1] - v[2]) / 3.0 - (plant.flux_alpha - before.flux_alpha) * 1e4;
        double one_beta = (v[1] - v[2]) / sqrt(3.0) - (plant.flux_beta - before.flux_beta) * 1e4;
        missed.rms += (alpha * alpha + beta * beta) / PERIODS;
        missed.one_current += (one_alpha * one_alpha + one_beta * one_beta) / PERIODS;
        missed.mean_d += (alpha * plant.cos_e + beta * plant.sin_e) / PERIODS;
        missed.mean_q += (beta * plant.cos_e - alpha * plant.sin_e) / PERIODS;
    }
    missed.rms = sqrt(missed.rms);
    missed.one_current = sqrt(missed.one_current);
    return missed;
}

/* Each limit is 1.5 times the largest value that this test has measured. */
static void expect_missed(const char *what, double rpm, const missed_t *missed, double limit, double share)
{
    char message[200];
    snprintf(message, sizeof message,
             "%s, %.0f r/min: %.4f V rms, mean (%.4f, %.4f); both edges by the mean current %.4f V", what,
             rpm, missed->rms, missed->mean_d, missed->mean_q, missed->one_current);
    TEST_ASSERT_TRUE_MESSAGE(missed->rms <= limit, message);
    TEST_ASSERT_TRUE_MESSAGE(missed->rms <= share * missed->one_current, message);
    TEST_ASSERT_TRUE_MESSAGE(fabs(missed->mean_d) <= 0.008 && fabs(missed->mean_q) <= 0.008, message);
}

/* The torques are 1.32 N m of friction, and 5 N m more. */
static void test_averaged_period_has_the_voltage_of_its_edges(void)
{
    static const struct {
        double rpm;      /* [r/min] */
        double limit[2]; /* [V] without load and with load */
        double share;    /* [-] largest ratio to the error that one current for both edges leaves */
    } points[] = {
        {100.0, {0.034, 0.015}, 0.6},  {503.0, {0.024, 0.019}, 0.06},   {1013.0, {0.05, 0.024}, 0.04},
        {1490.0, {0.047, 0.02}, 0.03}, {-1013.0, {0.042, 0.025}, 0.04},
    };
    for (size_t n = 0; n < 4u * sizeof points / sizeof points[0]; n++) {
        const double rpm = points[n / 4u].rpm;
        const bool loaded = (n & 1u) != 0u;
        plant_params_t q = locked();
        q.shaft_locked_speed = rpm * RPM;
        const missed_t missed = compare(&q, 0.0, (loaded ? 6.32 : 1.32) / 1.098, (uint32_t)(n >> 1) & 1u);
        expect_missed(loaded ? "5 N m" : "no load", rpm, &missed, points[n / 4u].limit[loaded],
                      points[n / 4u].share);
    }
}

static void test_averaged_period_of_a_salient_machine_has_the_voltage_of_its_edges(void)
{
    static const double speeds[] = {503.0, 1013.0, 1490.0, -1013.0}; /* [r/min] */
    for (size_t n = 0; n < 2u * sizeof speeds / sizeof speeds[0]; n++) {
        const double rpm = speeds[n / 2u];
        plant_params_t q =
            plant_with(locked(), "inductance_d = 0.008, inductance_q = 0.02, emf_5th = 0.03, emf_7th = 0.02");
        q.shaft_locked_speed = rpm * RPM;
        const missed_t missed = compare(&q, -2.0, n % 2u != 0u ? 5.0 : 1.0, 0u);
        expect_missed(n % 2u != 0u ? "salient, 5 A" : "salient, 1 A", rpm, &missed, 0.062, 0.14);
    }
}

static void test_averaged_periods_continue_until_the_mode_changes(void)
{
    const uint32_t high[3] = {8400, 6600, 7000};
    plant_params_t q = locked();
    q.shaft_locked_speed = 503.0 * RPM;
    plant_init(&plant, &q, 1);
    plant_carrier(&plant, 0, LOOP_PERIOD, high, 375, false);
    const plant_truth_t told_once = truth_at(20u * LOOP_PERIOD);
    plant_init(&plant, &q, 1);
    for (uint64_t k = 0; k < 20u; k++) {
        plant_carrier(&plant, k * LOOP_PERIOD, LOOP_PERIOD, high, 375, false);
    }
    const plant_truth_t told_each = truth_at(20u * LOOP_PERIOD);
    TEST_ASSERT_EQUAL_MEMORY(&told_once, &told_each, sizeof told_once);
}

/* ---- edges ---- */

/* Drives 12 A into a and out of b and c, with a link of 30 V; returns the tick. */
static uint64_t flowing(const plant_params_t *q)
{
    plant_init(&plant, q, 1);
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_advance(&plant, 3000000u);
    return 3000000u;
}

static plant_params_t no_slope(void)
{
    return plant_with(locked(), "dc_voltage = 30, igbt_resistance = 0, diode_resistance = 0");
}

/* The volt-seconds of u_alpha that a toggle of the upper switch of leg a removes, in ticks of the full leg
 * voltage. */
static double lost_ticks(const plant_params_t *q, const uint32_t *offsets, int count)
{
    uint64_t at = flowing(q);
    plant_truth_t before = truth_at(at);
    uint32_t others = PLANT_LOWER(1) | PLANT_LOWER(2);
    for (int n = 0; n < count; n++) {
        plant_gates(&plant, at + offsets[n], others | (n % 2 ? PLANT_UPPER(0) : 0u));
    }
    plant_truth_t after = truth_at(at + 3000u);
    double full = 2.0 / 3.0 * (q->dc_voltage - 2.0 * q->igbt_voltage);
    double swing = 2.0 / 3.0 * (q->dc_voltage - q->igbt_voltage + q->diode_voltage);
    return (full * 3000.0 - (after.flux_alpha - before.flux_alpha) * 150e6) / swing;
}

static void test_gap_shorter_than_the_difference_of_delays_vanishes(void)
{
    plant_params_t q = no_slope();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, lost_ticks(&q, (const uint32_t[]){100, 131}, 2));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, lost_ticks(&q, (const uint32_t[]){100, 130}, 2));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, lost_ticks(&q, (const uint32_t[]){100, 101}, 2));
    /* The switch is off twice; the first time is too short, and only the second has an effect. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 70.0, lost_ticks(&q, (const uint32_t[]){100, 110, 120, 220}, 4));
}

static void test_pulse_shorter_than_the_difference_of_delays_vanishes(void)
{
    plant_params_t q = plant_with(no_slope(), "turn_on_delay = 0.9e-6, turn_off_delay = 0.7e-6");
    /* Off at 100 acts at 205, and on at 300 acts at 435. Off at 329 acts at 434 and so cancels the on; off
     * at 331 acts at 436. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 3000.0 - 205.0, lost_ticks(&q, (const uint32_t[]){100, 300, 329}, 3));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 3000.0 - 206.0, lost_ticks(&q, (const uint32_t[]){100, 300, 331}, 3));
}

static void test_more_edges_than_a_delay_holds_end_in_the_commanded_state(void)
{
    plant_params_t q = plant_with(no_slope(), "turn_on_delay = 4e-6, turn_off_delay = 4e-6");
    /* Nine edges, ten ticks apart, within a delay of 600 ticks. Off, on, off, on wait for 700, 710, 720,
     * 730. The queue is then full: the fifth edge cancels the fourth and itself; the sixth waits for 750
     * and is cancelled by the seventh, and the eighth by the ninth. The edges that act are off at 700, on
     * at 710, off at 720. */
    uint32_t offsets[9];
    for (uint32_t n = 0; n < 9; n++) {
        offsets[n] = 100u + 10u * n;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 3000.0 - 700.0 - 10.0, lost_ticks(&q, offsets, 9));
    TEST_ASSERT_EQUAL_UINT32(0u, plant.on & PLANT_UPPER(0));
    plant_gates(&plant, plant.tick, PLANT_UPPER(0));
    plant_advance(&plant, plant.tick + 700u);
    TEST_ASSERT_EQUAL_UINT32(PLANT_UPPER(0), plant.on);
}

static void test_all_off_lets_the_current_die_into_the_link_and_then_none_flows(void)
{
    begin(plant_with(locked(), "shaft_locked_speed = 20"));
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_advance(&plant, 60000u);
    plant_gates(&plant, 60000u, 0);
    TEST_ASSERT_TRUE(truth_at(60000u).i_a > 4.0);
    /* The current of 6.5 A decays with 200 V/12.5 mH in 0.5 ms; after a further 50 us in the zone the
     * nodes float. */
    plant_truth_t now = truth_at(60000u + 150000u);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_a);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_b);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_c);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.torque);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_OPEN, now.leg_b);
    /* The next command makes current flow again. */
    plant_gates(&plant, 300000u, PLANT_UPPER(1) | PLANT_LOWER(2));
    TEST_ASSERT_TRUE(truth_at(315000u).i_b > 0.5);
}

static void test_emf_above_the_link_flows_through_the_diodes(void)
{
    begin(plant_of("dc_voltage = 100, friction_coulomb = 0"));
    plant_set_motion(&plant, 0.0, 157.0); /* 199 V of EMF between lines */
    plant_set_metering(&plant, true);
    plant_truth_t now = truth_at(1500000u);
    TEST_ASSERT_TRUE(fabs(now.i_a) + fabs(now.i_b) + fabs(now.i_c) > 1.0);
    TEST_ASSERT_TRUE(now.torque < -1.0);
    TEST_ASSERT_TRUE(now.energy_dc < -1.0);
    /* The line EMF falls below 100 V + 2 * 0.95 V at 80.4 rad/s; there the braking ends, and no current
     * flows any more. Just above, a crest leaves the legs in the zone, whose leakage (50 mA) brakes on
     * until they float: 0.5 rad/s. */
    now = truth_at(1500000000u);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 101.9 / (sqrt(3.0) * 4.0 * 0.183), now.omega_m);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_a);
}

static void test_a_pulse_starts_the_wait_for_floating_legs_again(void)
{
    uint32_t lower = PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2);
    begin(locked());
    plant_gates(&plant, 0, lower);
    plant_gates(&plant, 1000, 0); /* acts at tick 1135 */
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_ZONE, truth_at(1135u + 5000u).leg_a);
    plant_gates(&plant, 6200, lower); /* acts at tick 6305 */
    plant_gates(&plant, 6300, 0);     /* acts at tick 6435 */
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_ZONE, truth_at(6435u + 5000u).leg_a);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_OPEN, truth_at(6435u + PLANT_IDLE_TICKS).leg_a);
}

/* ---- module ---- */

static void test_shoot_through_is_counted_and_shuts_the_arm_and_all_lower_ones(void)
{
    plant_params_t q = plant_with(locked(), "dc_voltage = 30");
    uint64_t at = flowing(&q);
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
    TEST_ASSERT_EQUAL_DOUBLE(-1.0, truth_at(at).shoot_through_second);
    plant_gates(&plant, at, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2) | PLANT_UPPER(2));
    plant_truth_t now = truth_at(at + 200u);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, now.shoot_throughs);
    TEST_ASSERT_EQUAL_DOUBLE(2.0, now.shoot_through_leg);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, (double)(at + 105u) / 150e6, now.shoot_through_second);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_UPPER(2) | PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2),
                             now.shut_gates);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_UPPER_IGBT, now.leg_a); /* the other gates still obey */
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_UPPER_DIODE, now.leg_b);
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    /* The fault output lasts 1.8 ms = 270000 ticks. */
    plant_advance(&plant, at + 105u + 269999u);
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    plant_advance(&plant, at + 105u + 270000u);
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
    /* The command is still on, but the gates stay off. Each gate follows its command again after an off-on
     * edge. */
    now = truth_at(at + 300000u);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_UPPER(2) | PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2),
                             now.shut_gates);
    plant_gates(&plant, at + 300000u, PLANT_UPPER(0));
    plant_gates(&plant, at + 301000u, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    now = truth_at(at + 302000u);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_UPPER(2) | PLANT_LOWER(0), now.shut_gates);
    now = truth_at(at + 3000000u);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_LOWER_IGBT, now.leg_b);
    TEST_ASSERT_TRUE(now.i_a > 10.0);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, now.shoot_throughs);
}

static void test_edge_during_the_fault_pulse_does_not_reopen_a_gate(void)
{
    plant_params_t q = plant_with(locked(), "dc_voltage = 30");
    uint64_t at = flowing(&q);
    plant_gates(&plant, at, PLANT_UPPER(0) | PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_gates(&plant, at + 10000u, 0);
    plant_gates(&plant, at + 20000u, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_truth_t now = truth_at(at + 3000000u);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_UPPER(0) | PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2),
                             now.shut_gates);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_a);
}

static void test_module_without_protection_only_counts_a_shoot_through(void)
{
    plant_params_t q = plant_with(locked(), "dc_voltage = 30, short_circuit_current = 0");
    uint64_t at = flowing(&q);
    plant_gates(&plant, at, PLANT_UPPER(0) | PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_truth_t now = truth_at(at + 1000u);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, now.shoot_throughs);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_SHOOT_THROUGH, now.leg_a);
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
    /* The node of a is at 15 V; b and c conduct through IGBTs at half the current. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.0 / 3.0 * (15.0 - 0.8 - 0.018 * 0.5 * now.i_a), now.u_alpha);
}

static void test_overcurrent_trips_the_arm_that_carries_it(void)
{
    /* The trip level is below, at and above the current that is reached, in small distances. */
    plant_params_t q = plant_with(locked(), "dc_voltage = 30");
    double reached = 2.0 / 3.0 * 28.4 / (0.95 + 0.018);
    q.short_circuit_current = reached * 1.001;
    plant_init(&plant, &q, 1);
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, truth_at(45000000u).fault_line);
    q.short_circuit_current = reached * 0.99;
    plant_set_params(&plant, &q);
    plant_truth_t now = truth_at(45000000u + 15000u); /* detected within one step of 100 us */
    TEST_ASSERT_EQUAL_DOUBLE(1.0, now.fault_line);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_UPPER(0), now.shut_gates);
    now = truth_at(45000000u + 30000u);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_LOWER_DIODE, now.leg_a);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_LOWER_IGBT, now.leg_b);
    /* A lower switch with too much current turns off the other lower switches too. */
    plant_init(&plant, &q, 1);
    plant_gates(&plant, 0, PLANT_LOWER(0) | PLANT_UPPER(1) | PLANT_UPPER(2));
    now = truth_at(45000000u);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2), now.shut_gates);
}

static void test_forced_fault_shuts_everything_and_holds_the_line(void)
{
    plant_params_t q = plant_with(locked(), "dc_voltage = 30");
    uint64_t at = flowing(&q);
    q.force_fault = 1.0;
    plant_set_params(&plant, &q);
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    plant_truth_t now = truth_at(at + 3000000u);
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    TEST_ASSERT_EQUAL_DOUBLE(63.0, now.shut_gates);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_a);
    q.force_fault = 0.0;
    plant_set_params(&plant, &q);
    /* The fault lasts far longer than the shortest pulse of the fault line. */
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, truth_at(at + 4000000u).i_a);
    plant_gates(&plant, at + 4000000u, 0);
    plant_gates(&plant, at + 4100000u, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    TEST_ASSERT_TRUE(truth_at(at + 5000000u).i_a > 1.0);
    /* A short fault still makes a pulse of full length. */
    q.force_fault = 1.0;
    plant_set_params(&plant, &q);
    q.force_fault = 0.0;
    plant_set_params(&plant, &q);
    plant_advance(&plant, at + 5000000u + 269999u);
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    plant_advance(&plant, at + 5000000u + 270000u);
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
}

static void test_averaged_mode_stops_on_a_fault_and_resumes_after_it(void)
{
    uint32_t high[3] = {8400, 6600, 6600};
    plant_params_t q = begin(locked());
    for (uint64_t k = 0; k < 200; k++) {
        plant_carrier(&plant, k * LOOP_PERIOD, LOOP_PERIOD, high, 375, false);
    }
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_AVERAGED, truth_at(200u * LOOP_PERIOD).leg_a);
    q.short_circuit_current = 2.0;
    plant_set_params(&plant, &q);
    plant_carrier(&plant, 200u * LOOP_PERIOD, LOOP_PERIOD, high, 375, false);
    plant_truth_t now = truth_at(201u * LOOP_PERIOD);
    TEST_ASSERT_EQUAL_DOUBLE(63.0, now.shut_gates);
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    q.short_circuit_current = 100.0;
    plant_set_params(&plant, &q);
    for (uint64_t k = 201; k < 218; k++) {
        plant_carrier(&plant, k * LOOP_PERIOD, LOOP_PERIOD, high, 375, false);
    }
    now = truth_at(218u * LOOP_PERIOD);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_a);
    for (uint64_t k = 218; k < 240; k++) {
        plant_carrier(&plant, k * LOOP_PERIOD, LOOP_PERIOD, high, 375, false);
    }
    now = truth_at(240u * LOOP_PERIOD);
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
    TEST_ASSERT_TRUE(now.i_a > 1.0);
    /* When averaged mode ends, the command acts at once. */
    plant_gates(&plant, 240u * LOOP_PERIOD, 0);
    TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_LOWER_DIODE, truth_at(240u * LOOP_PERIOD + 1u).leg_a);
}

/* ---- broken phases ---- */

static void test_broken_phase_carries_nothing_and_the_others_the_same_current(void)
{
    plant_params_t q = plant_with(locked(), "turn_on_delay = 0, " NO_DROPS
                                            ", dc_voltage = 20, inductance_d = 0.008, inductance_q = 0.02");
    for (int broken = 0; broken < 3; broken++) {
        q.open_phase_a = broken == 0;
        q.open_phase_b = broken == 1;
        q.open_phase_c = broken == 2;
        plant_init(&plant, &q, 1);
        /* The d axis is on the broken phase, so that the line between the other two is on q. */
        plant_set_motion(&plant, 2.0 * 3.14159265358979324 / 3.0 * broken / 4.0, 0.0);
        int next = (broken + 1) % 3;
        int last = (broken + 2) % 3;
        plant_gates(&plant, 0, PLANT_UPPER(next) | PLANT_LOWER(last) | PLANT_UPPER(broken));
        for (int k = 1; k <= 10; k++) {
            double t = 2e-3 * k;
            plant_truth_t now = truth_at((uint64_t)k * 300000u);
            double i[3] = {now.i_a, now.i_b, now.i_c};
            double leg[3] = {now.leg_a, now.leg_b, now.leg_c};
            double expected = 20.0 / (2.0 * q.resistance) * (1.0 - exp(-q.resistance * t / q.inductance_q));
            TEST_ASSERT_EQUAL_DOUBLE(0.0, i[broken]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-8, expected, i[next]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, i[next] + i[last]);
            TEST_ASSERT_EQUAL_DOUBLE(PLANT_LEG_OPEN, leg[broken]);
        }
    }
}

static void test_phase_that_breaks_while_turning_stays_at_exactly_zero(void)
{
    plant_params_t q = plant_params_default();
    loop.i_q_ref = 4.0;
    plant_init(&plant, &q, 1);
    for (int k = 0; k < 300; k++) {
        loop_period(&loop, &plant, NULL, NULL);
    }
    q.open_phase_a = 1.0;
    plant_set_params(&plant, &q);
    double largest = 0.0;
    for (int k = 0; k < 300; k++) {
        plant_truth_t now = truth();
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_a);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, now.i_b + now.i_c);
        largest = fmax(largest, fabs(now.i_b));
        loop_period(&loop, &plant, NULL, NULL);
    }
    TEST_ASSERT_TRUE(largest > 1.0);
    q.open_phase_c = 1.0;
    plant_set_params(&plant, &q);
    for (int k = 0; k < 10; k++) {
        plant_truth_t now;
        loop_period(&loop, &plant, NULL, NULL);
        now = truth();
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.i_b);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, now.torque);
    }
    q.open_phase_a = q.open_phase_c = 0.0;
    plant_set_params(&plant, &q);
    for (int k = 0; k < 100; k++) {
        loop_period(&loop, &plant, NULL, NULL);
    }
    TEST_ASSERT_TRUE(fabs(plant.i[0]) + fabs(plant.i[1]) + fabs(plant.i[2]) > 1.0);
}
