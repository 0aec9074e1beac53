/* Faults of the inverter, its wires, the encoder and the supply, compared with algebra. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/plant/interval.h"
#include "tests/plant/bench.h"
#include "unity.h"

#define TICKS 150e6
#define PI    3.14159265358979323846

static plant_t other;
static uint64_t after(double seconds)
{
    return plant.tick + (uint64_t)(seconds * TICKS + 0.5);
}

/* A winding with so large an inductance that its current hardly changes, without EMF, with the shaft held. */
static plant_params_t choke(void)
{
    return plant_of("inductance_d = 1, inductance_q = 1, resistance = 0, flux_linkage = 0, shaft_locked = 1");
}

static void put_currents(double a, double b, double c)
{
    plant.idle = 0;
    plant.i[0] = a;
    plant.i[1] = b;
    plant.i[2] = c;
    interval_restart(&plant);
}

/* ---- unequal legs ---- */

/* Upper switch a and lower switches b and c are permanently on: V - d - 2 V_ce - (R_leg + 1.5 (R + r_ce))
 * i = 0. */
static void test_a_leg_s_own_drop_and_resistance_are_in_the_steady_current(void)
{
    const uint32_t high[3] = {LOOP_PERIOD, 0, 0};
    for (uint32_t averaged = 0; averaged < 2; averaged++) {
        plant_params_t q =
            plant_of("dc_voltage = 30, shaft_locked = 1, leg_a_drop = 3, leg_a_resistance = 2");
        plant_init(&plant, &q, 1);
        if (averaged) {
            plant_carrier(&plant, 0, LOOP_PERIOD, high, 375, false);
        } else {
            plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
        }
        plant_advance(&plant, (uint64_t)(0.4 * TICKS));
        /* In averaged mode the drops belong to the current half a delay later: an error of 1 us of R i/L,
         * times R_leg. */
        TEST_ASSERT_DOUBLE_WITHIN(averaged ? 1e-3 : 1e-6, (30.0 - 3.0 - 1.6) / (2.0 + 1.5 * (0.95 + 0.018)),
                                  plant.i[0]);

        /* The current changes from the instant of the removal, with the remaining time constant. */
        double i = plant.i[0];
        q.leg_a_drop = 0.0;
        q.leg_a_resistance = 0.0;
        plant_set_params(&plant, &q);
        plant_advance(&plant, plant.tick + (averaged ? LOOP_PERIOD : 0u));
        i = plant.i[0];
        double rest = (30.0 - 1.6) / (1.5 * (0.95 + 0.018));
        plant_advance(&plant, after(5e-3));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, rest + (i - rest) * exp(-5e-3 * (0.95 + 0.018) / 0.0125), plant.i[0]);
    }
}

/* The integral of the voltage over a period [V s], with this delay of leg a. */
static double period_flux(double delay, double i_a, uint32_t averaged)
{
    plant_params_t q = choke();
    q.leg_a_delay = delay;
    plant_init(&plant, &q, 1);
    loop.averaged = averaged;
    for (int k = 0; k < 3; k++) {
        put_currents(i_a, -0.5 * i_a, -0.5 * i_a);
        loop_period(&loop, &plant, NULL, NULL);
    }
    plant_truth_t before, now;
    for (int k = 0; k < 2; k++) { /* the second period contains all of its edges */
        const uint32_t high[3] = {7500, 7500, 7500};
        memcpy(loop.high, high, sizeof high);
        put_currents(i_a, -0.5 * i_a, -0.5 * i_a);
        before = truth();
        loop_period(&loop, &plant, NULL, NULL);
    }
    now = truth();
    return now.flux_alpha - before.flux_alpha;
}

/* While the upper switch turns on later, the current flows through the lower diode, and vice versa. During
 * the delay the voltage is reduced by 2/3 of (V - V_ce + V_f), against the current. */
static void test_a_leg_s_own_delay_takes_its_time_of_the_link_against_the_current(void)
{
    for (uint32_t averaged = 0; averaged < 2; averaged++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            double i = 4.0 * sign;
            double lost = period_flux(0.0, i, averaged) - period_flux(1e-6, i, averaged);
            double fall = plant.params.dc_voltage - (0.8 + 0.018 * 4.0) + (0.95 + 0.025 * 4.0);
            TEST_ASSERT_DOUBLE_WITHIN(2e-3 * 2.0 / 3.0 * 1e-6 * fall, sign * 2.0 / 3.0 * 1e-6 * fall, lost);
        }
    }
}

/* ---- switches ---- */

static plant_leg_t leg_a(void)
{
    plant_truth_t now = truth();
    return (plant_leg_t)now.leg_a;
}

static void test_an_open_switch_leaves_the_current_to_the_diodes_at_the_instant(void)
{
    plant_params_t q = begin(choke());
    plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_advance(&plant, 1000);
    put_currents(2.0, -1.0, -1.0);
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_UPPER_IGBT, leg_a());
    q.open_switches = 1.0; /* the upper switch of leg a is open */
    plant_set_params(&plant, &q);
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_LOWER_DIODE, leg_a());
    plant_truth_t now = truth();
    /* (2 v_a - v_b - v_c)/3 */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, (-2.0 * (0.95 + 0.05) - 2.0 * (0.8 + 0.018)) / 3.0, now.u_alpha);
    put_currents(-2.0, 1.0, 1.0); /* the diode of the open switch still conducts in the other direction */
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_UPPER_DIODE, leg_a());
    plant_gates(&plant, plant.tick, PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_advance(&plant, after(5e-6));
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_LOWER_IGBT, leg_a());
    q.open_switches = 0.0;
    plant_set_params(&plant, &q);
    plant_gates(&plant, plant.tick, PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_gates(&plant, after(2.5e-6), PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
    plant_advance(&plant, after(10e-6));
    put_currents(2.0, -1.0, -1.0);
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_UPPER_IGBT, leg_a());
}

static void test_a_shorted_switch_conducts_without_command_and_its_partner_trips_the_module(void)
{
    begin(plant_with(choke(), "shorted_switches = 1"));
    put_currents(2.0, -1.0, -1.0);
    plant_advance(&plant, 100);
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_UPPER_IGBT, leg_a());
    plant_gates(&plant, 1000, PLANT_LOWER(1));
    plant_gates(&plant, 2000, PLANT_LOWER(0) | PLANT_LOWER(1));
    plant_advance(&plant, 2000u + plant.turn_on_ticks[0] - 1u);
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
    plant_advance(&plant, 2000u + plant.turn_on_ticks[0] + 1u);
    plant_truth_t now = truth();
    TEST_ASSERT_EQUAL_DOUBLE(1.0, now.shoot_throughs);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, now.shoot_through_leg);
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    TEST_ASSERT_EQUAL_DOUBLE((double)(PLANT_UPPER(0) | PLANT_LOWER(0) | PLANT_LOWER(1) | PLANT_LOWER(2)),
                             now.shut_gates);
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_UPPER_IGBT, leg_a()); /* no protection opens it */
    TEST_ASSERT_EQUAL_INT(PLANT_LEG_UPPER_DIODE, (plant_leg_t)now.leg_b);
}

static void test_a_switch_that_shorts_beside_a_partner_that_is_on_is_a_shoot_through_at_the_instant(void)
{
    plant_params_t q = begin(choke());
    plant_gates(&plant, 0, PLANT_LOWER(2));
    plant_advance(&plant, 1000);
    TEST_ASSERT_FALSE(plant_fault_line(&plant));
    q.shorted_switches = 16.0; /* the upper switch of leg c is shorted */
    plant_set_params(&plant, &q);
    plant_truth_t now = truth();
    TEST_ASSERT_TRUE(plant_fault_line(&plant));
    TEST_ASSERT_EQUAL_DOUBLE(2.0, now.shoot_through_leg);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1000.0 / TICKS, now.shoot_through_second);
}

/* ---- wires ---- */

static const uint32_t exchanged[4][3] = {{0, 1, 2}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

static uint32_t exchange(uint32_t gates, const uint32_t to[3])
{
    uint32_t bits = 0;
    for (uint32_t leg = 0; leg < 3; leg++) {
        bits |= (gates >> (2u * leg) & 3u) << (2u * to[leg]);
    }
    return bits;
}

/* A plant without a fault receives the edges of a control loop. A plant with exchanged wires receives the
 * same edges with exchanged legs. Both must have the same result to the last bit. */
static void test_swapped_phases_are_exchanged_commands_to_the_last_bit(void)
{
    static oracle_edge_t edges[12 * 400];
    for (uint32_t pair = 1; pair <= 3; pair++) {
        plant_params_t q = begin(plant_params_default());
        size_t count = 0;
        setUp();
        for (int k = 0; k < 400; k++) {
            loop.i_q_ref = 5.0;
            loop_period(&loop, &plant, edges, &count);
        }
        q.swap_phases = (double)pair;
        plant_init(&other, &q, 1);
        for (size_t n = 0; n < count; n++) {
            /* Reads the plant at the times at which the loop has read it. */
            plant_advance(&other, edges[n].tick / LOOP_PERIOD * LOOP_PERIOD);
            plant_gates(&other, edges[n].tick, exchange(edges[n].on, exchanged[pair]));
        }
        plant_advance(&other, plant.tick);
        TEST_ASSERT_TRUE(plant.i[0] * plant.i[0] + plant.i[1] * plant.i[1] > 1.0);
        TEST_ASSERT_EQUAL_MEMORY(plant.i, other.i, sizeof plant.i);
        TEST_ASSERT_EQUAL_DOUBLE(plant.omega_m, other.omega_m);
        /* The sensors are on the inverter's side of the exchange. */
        q.current_noise = 0.0;
        q.swap_phases = (double)pair;
        plant_set_params(&other, &q);
        for (uint32_t leg = 0; leg < 3; leg++) {
            double pin = 1.5 + plant.i[exchanged[pair][leg]] * 1.5 / q.current_range;
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, pin,
                                      plant_analog(&other, (plant_channel_t)(PLANT_CURRENT_A + leg)));
        }
    }
}

/* The wires are exchanged in the middle of a run, with edges pending and with an average among the modes. */
static void test_wires_swapped_in_a_run_leave_the_windings_their_currents_and_move_the_rest(void)
{
    for (uint32_t averaged = 0; averaged < 2; averaged++) {
        plant_params_t q = begin(plant_with(choke(), "current_bandwidth = 1e5"));
        const uint32_t high[3] = {10000, 7000, 3000};
        if (averaged) {
            plant_carrier(&plant, 0, LOOP_PERIOD, high, 375, false);
        } else {
            plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_UPPER(1) | PLANT_LOWER(2));
            plant_advance(&plant, 5000);
            /* This command acts after its delay. */
            plant_gates(&plant, 5000, PLANT_UPPER(0) | PLANT_LOWER(2));
        }
        plant_advance(&plant, 5010);
        double i_b = plant.i[1];
        plant_truth_t before, now;
        before = truth();
        q.swap_phases = 1.0;
        plant_set_params(&plant, &q);
        now = truth();
        TEST_ASSERT_EQUAL_DOUBLE(i_b, plant.i[1]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, before.u_alpha, now.u_alpha);
        TEST_ASSERT_TRUE(fabs(before.u_beta) > 10.0);
        /* Equal except for the voltage drops, because the currents differ. */
        TEST_ASSERT_DOUBLE_WITHIN(2.0, -before.u_beta, now.u_beta);
        if (!averaged) {
            now = truth_at(5000u + plant.turn_off_ticks + 10u);
            TEST_ASSERT_EQUAL_INT(0, (int)(plant.on & PLANT_UPPER(2))); /* the edge of leg b, on phase c */
        }
    }
}

static void test_swapped_and_inverted_sensors_show_what_they_are_wired_to(void)
{
    plant_params_t q = begin(plant_with(
        choke(),
        "current_noise = 0, current_gain_error_b = 0.1, current_offset_b = 0.5, current_gain_error_c = -2"));
    put_currents(3.0, 1.0, -4.0);
    double volts = 1.5 / q.current_range;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + volts * 4.0, plant_analog(&plant, PLANT_CURRENT_C));
    q.swap_currents = 3.0; /* the sensor of phase b, with its errors, is on input a */
    plant_set_params(&plant, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + volts * (1.1 * 1.0 + 0.5), plant_analog(&plant, PLANT_CURRENT_A));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + volts * 3.0, plant_analog(&plant, PLANT_CURRENT_B));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.5 + volts * 4.0, plant_analog(&plant, PLANT_CURRENT_C));
}

/* ---- magnet ---- */

static void test_a_magnet_that_loses_flux_does_so_at_the_instant(void)
{
    plant_params_t q = begin(plant_with(choke(), "flux_linkage = 0.2"));
    put_currents(2.0, -1.0, -1.0);
    plant_set_motion(&plant, -PI / 8.0, 0.0); /* the whole current is i_q */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.5 * 4.0 * 0.2 * 2.0, plant.torque);
    q.flux_linkage = 0.15;
    plant_set_params(&plant, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.5 * 4.0 * 0.15 * 2.0, plant.torque);
}

/* ---- encoder ---- */

static plant_params_t turning(void)
{
    plant_params_t q = plant_of("shaft_locked = 1");
    q.shaft_locked_speed = 2.0 * PI; /* one turn per second: 10000 counts a second */
    return q;
}

static void test_a_reversed_encoder_counts_back_from_where_it_is(void)
{
    plant_params_t q = begin(turning());
    plant_advance(&plant, after(0.12345));
    TEST_ASSERT_EQUAL_INT64(1234, plant_encoder(&plant));
    q.encoder_reversed = 1.0;
    plant_set_params(&plant, &q);
    TEST_ASSERT_EQUAL_INT64(1234, plant_encoder(&plant));
    plant_advance(&plant, after(1.0));
    TEST_ASSERT_EQUAL_INT64(1234 - 10000, plant_encoder(&plant));
    TEST_ASSERT_EQUAL_INT64(1234 - 10000 - 100, plant_encoder_at(&plant, after(0.01)));
    q.encoder_reversed = 0.0;
    plant_set_params(&plant, &q);
    plant_advance(&plant, after(1.0));
    TEST_ASSERT_EQUAL_INT64(1234, plant_encoder(&plant));
    plant_init(&plant, &q, 1);
    q.encoder_reversed = 1.0;
    q.encoder_offset = 0.1; /* 0.1 rad are 159.15 counts */
    plant_init(&other, &q, 1);
    TEST_ASSERT_EQUAL_INT64(-159, plant_encoder(&other));
}

static void test_an_encoder_that_slips_misses_its_share_and_keeps_what_it_has(void)
{
    plant_params_t q = begin(turning());
    plant_advance(&plant, after(3.00005));
    TEST_ASSERT_EQUAL_INT64(30000, plant_encoder(&plant));
    q.encoder_slip = 0.25;
    plant_set_params(&plant, &q);
    TEST_ASSERT_EQUAL_INT64(30000, plant_encoder(&plant));
    plant_advance(&plant, after(2.0));
    TEST_ASSERT_INT64_WITHIN(1, 45000, plant_encoder(&plant));
    q.encoder_slip = 1.0; /* the coupling of the encoder slips completely */
    plant_set_params(&plant, &q);
    int64_t count = plant_encoder(&plant);
    plant_advance(&plant, after(1.3));
    TEST_ASSERT_EQUAL_INT64(count, plant_encoder(&plant));
    q.encoder_slip = 0.0;
    plant_set_params(&plant, &q);
    plant_advance(&plant, after(1.0));
    TEST_ASSERT_INT64_WITHIN(1, count + 10000, plant_encoder(&plant));
}

/* A decoder written for the test: it counts edge by edge from the levels of two tracks, one of which may
 * be stuck. */
static int64_t decoded(int stuck_a, int stuck_b, int from, int to)
{
    int64_t count = from;
    int a = from % 4 == 1 || from % 4 == 2;
    int b = from % 4 >= 2;
    for (int n = from; n <= to; n++) {
        int next_a = stuck_a >= 0 ? stuck_a : n % 4 == 1 || n % 4 == 2;
        int next_b = stuck_b >= 0 ? stuck_b : n % 4 >= 2;
        if (next_a != a && next_b == b) {
            count += next_a != b ? 1 : -1; /* A rises while B is low: a step forward */
        } else if (next_b != b && next_a == a) {
            count += next_b == a ? 1 : -1; /* B rises while A is high: a step forward */
        }
        a = next_a;
        b = next_b;
    }
    return count;
}

static void test_a_stuck_track_shows_the_edges_of_the_other_alone(void)
{
    for (int start = 1000; start < 1004; start++) {
        for (int a = -1; a <= 1; a++) {
            for (int b = -1; b <= 1; b++) {
                plant_params_t q = begin(turning());
                plant_advance(&plant, after((start + 0.5) * 1e-4));
                TEST_ASSERT_EQUAL_INT64(start, plant_encoder(&plant));
                q.encoder_stuck_a = a;
                q.encoder_stuck_b = b;
                bool two = a >= 0 && b >= 0; /* two edges may coincide; they have no effect */
                plant_set_params(&plant, &q);
                for (int n = start; n < start + 13; n++) {
                    if (!two) {
                        TEST_ASSERT_EQUAL_INT64(decoded(a, b, start, n), plant_encoder(&plant));
                    } else {
                        TEST_ASSERT_INT64_WITHIN(1, start, plant_encoder(&plant));
                    }
                    plant_advance(&plant, after(1e-4));
                }
            }
        }
    }
}

/* ---- supply ---- */

static void test_a_ripple_is_a_sine_from_the_instant_it_is_set(void)
{
    plant_params_t q = begin(plant_params_default());
    plant_advance(&plant, 123456);
    q.dc_ripple = 20.0;
    q.dc_ripple_frequency = 2.0 * PI * 300.0;
    plant_set_params(&plant, &q);
    TEST_ASSERT_EQUAL_DOUBLE(q.dc_voltage, plant.v_dc);
    for (int n = 1; n < 200; n++) {
        plant_advance(&plant, 123456u + (uint64_t)n * 7777u);
        double t = n * 7777.0 / TICKS;
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, q.dc_voltage + 20.0 * sin(q.dc_ripple_frequency * t), plant.v_dc);
    }
    q.dc_ripple = 0.0;
    plant_set_params(&plant, &q);
    TEST_ASSERT_EQUAL_DOUBLE(q.dc_voltage, plant.v_dc);
}

/* The legs are permanently on, with a choke as load: the flux is the integral of 2/3 of the link voltage
 * less the drops. */
static void test_a_ripple_reaches_the_motor_as_its_integral(void)
{
    const uint32_t high[3] = {LOOP_PERIOD, 0, 0};
    for (uint32_t averaged = 0; averaged < 2; averaged++) {
        plant_params_t q = plant_with(choke(), "dc_ripple = 50");
        q.dc_ripple_frequency = 2.0 * PI * 300.0;
        plant_init(&plant, &q, 1);
        if (averaged) {
            plant_carrier(&plant, 0, LOOP_PERIOD, high, 375, false);
        } else {
            plant_gates(&plant, 0, PLANT_UPPER(0) | PLANT_LOWER(1) | PLANT_LOWER(2));
        }
        plant_advance(&plant, LOOP_PERIOD);
        put_currents(10.0, -5.0, -5.0);
        plant_truth_t before, now;
        before = truth();
        double t0 = (double)plant.tick / TICKS;
        now = truth_at(after(1e-3));
        double w = q.dc_ripple_frequency;
        double volts = q.dc_voltage * 1e-3 + 50.0 / w * (cos(w * t0) - cos(w * (t0 + 1e-3)));
        double drops = 1e-3 * (1.6 + 0.018 * 15.0);
        TEST_ASSERT_DOUBLE_WITHIN(3e-5, 2.0 / 3.0 * (volts - drops), now.flux_alpha - before.flux_alpha);
    }
}

/* An independent integration of v' = (V + r sin - v)/RC + chopper in steps of 0.1 us, without a motor. */
static void test_a_soft_link_follows_source_ripple_and_chopper_as_integrated_elsewhere(void)
{
    plant_params_t q = begin(plant_of("dc_capacitance = 2e-4, dc_resistance = 2, chopper_resistance = 30, "
                                      "chopper_voltage = 320, dc_ripple = 40"));
    double v = plant.v_dc;
    double worst = 0.0;
    for (int n = 0; n < 200000; n++) {
        double h = 1e-7;
        double source = q.dc_voltage + 40.0 * sin(q.dc_ripple_frequency * (n + 0.5) * h);
        double in = source > v ? (source - v) / 2.0 : 0.0;
        double out = v > 320.0 ? v / 30.0 : 0.0;
        v += h * (in - out) / 2e-4;
        if (n % 100 == 99) {
            plant_advance(&plant, (uint64_t)(n + 1) * 15u);
            worst = fmax(worst, fabs(plant.v_dc - v));
        }
    }
    /* The plant's steps of 10 us are of first order: the error is less than one step at the steepest
     * slope, 40 V x 1885/s. */
    TEST_ASSERT_TRUE(worst < 10e-6 * 40.0 * 1885.0);
}

/* The energy that leaves the capacitor is C/2 times the difference of the squared voltages; it returns
 * with the supply. */
static void test_a_lost_supply_leaves_the_capacitor_to_feed_the_inverter(void)
{
    for (uint32_t averaged = 0; averaged < 2; averaged++) {
        for (int stiff = 0; stiff < 2; stiff++) {
            plant_params_t q = plant_of("dc_capacitance = 1e-3");
            q.dc_resistance = stiff ? 0.0 : 0.5;
            setUp();
            loop.averaged = averaged;
            plant_init(&plant, &q, 1);
            for (int k = 0; k < 500; k++) {
                loop.i_q_ref = 5.0;
                loop_period(&loop, &plant, NULL, NULL);
            }
            q.supply_lost = 1.0;
            plant_set_params(&plant, &q);
            plant_set_metering(&plant, true);
            double v = plant.v_dc;
            for (int k = 0; k < 300; k++) {
                loop_period(&loop, &plant, NULL, NULL);
            }
            double given = 0.5 * q.dc_capacitance * (v * v - plant.v_dc * plant.v_dc);
            TEST_ASSERT_TRUE(plant.v_dc < v - 1.0);
            TEST_ASSERT_DOUBLE_WITHIN(2e-3 * given, given, plant.energy_dc);
            q.supply_lost = 0.0;
            plant_set_params(&plant, &q);
            plant_advance(&plant, after(0.01));
            TEST_ASSERT_DOUBLE_WITHIN(stiff ? 1e-9 : 1.0, q.dc_voltage, plant.v_dc);
        }
    }
}
