/* The campaign: its random choices, its verdicts, and that they depend neither on the number of cores nor
 * on shards. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drive/drive.h"
#include "fast/measure.h"
#include "host_sim/lab/campaign_parts.h"
#include "medium/manoeuvre/manoeuvres.h"
#include "medium/sequence.h"
#include "settings/signals.h"
#include "tests/lab/courses.h"
#include "unity.h"

/* ---- what is drawn ---- */

static void test_random_numbers_fill_16_bins_evenly_along_draws_runs_and_seeds(void)
{
    enum { BINS = 16, DRAWS = 16000 };
    for (uint32_t along = 0; along < 3u; along++) {
        uint32_t bins[BINS] = {0};
        for (uint32_t n = 0; n < DRAWS; n++) {
            const double u =
                campaign_random(along == 2u ? n : 7u, along == 1u ? n : 3u, along == 0u ? n : 5u);
            TEST_ASSERT_TRUE(u >= 0.0 && u < 1.0);
            bins[(uint32_t)(u * BINS)]++;
        }
        /* chi^2 with 15 degrees of freedom exceeds 44.3 once in 10000 cases. */
        double chi_square = 0.0;
        for (uint32_t n = 0; n < BINS; n++) {
            chi_square += pow(bins[n] - (double)DRAWS / BINS, 2.0) / ((double)DRAWS / BINS);
        }
        TEST_ASSERT_TRUE(chi_square < 44.3);
    }
}

#define DRAWN 2000u
#define MANY  12000u /* a quantity that occurs in an eighth of the runs is then drawn 1500 times */

static void test_every_quantity_reaches_over_its_range_and_not_beyond(void)
{
    for (uint32_t n = 0; n < CAMPAIGN_QUANTITY_COUNT; n++) {
        const campaign_quantity_row_t *row = &campaign_quantities[n];
        const double span = row->law == CAMPAIGN_LOG ? log(row->most / row->least) : row->most - row->least;
        double lowest = 1.0;
        double highest = 0.0;
        for (uint32_t run = 0; run < MANY; run++) {
            campaign_case_t drawn;
            campaign_draw(11u, run, 2.0, &drawn);
            const double x = drawn.quantities[n];
            const bool may_be_none = row->law == CAMPAIGN_HALF || row->law == CAMPAIGN_FEW ||
                                     row->law == CAMPAIGN_THIRD || row->law == CAMPAIGN_OWN;
            if (may_be_none && x == row->initial) {
                continue;
            }
            TEST_ASSERT_TRUE_MESSAGE(x >= row->least && x <= row->most, row->name);
            const double share = span == 0.0                ? 0.5
                                 : row->law == CAMPAIGN_LOG ? log(x / row->least) / span
                                                            : (x - row->least) / span;
            lowest = fmin(lowest, share);
            highest = fmax(highest, share);
        }
        /* Of at least 1000 values the probability that none is in the last hundredth is e^-10. */
        TEST_ASSERT_TRUE_MESSAGE(span == 0.0 || (lowest < 0.01 && highest > 0.99), row->name);
    }
}

static void test_half_of_the_runs_have_one_fault_and_every_fault_comes(void)
{
    uint32_t seen[256] = {0};
    uint32_t injected = 0;
    for (uint32_t run = 0; run < DRAWN; run++) {
        campaign_case_t drawn;
        campaign_draw(12u, run, 2.0, &drawn);
        seen[drawn.faults[0].kind]++;
        injected += drawn.faults[0].kind != 0u;
        for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
            const campaign_injected_t *fault = &drawn.faults[n];
            TEST_ASSERT_TRUE(fault->kind == 0u || (fault->time >= 0.0 && fault->time < 2.0));
            TEST_ASSERT_TRUE(fault->lasts == 0.0 || (fault->lasts >= 0.01 && fault->lasts <= 0.3));
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(5.0 * sqrt(0.25 * DRAWN), 0.5 * DRAWN, injected); /* five standard deviations */
    for (uint32_t n = 1; n < campaign_fault_count; n++) {
        TEST_ASSERT_GREATER_THAN_UINT32_MESSAGE(0u, seen[n], campaign_faults[n].name);
        TEST_ASSERT_NOT_NULL_MESSAGE(rig_row_by_name(campaign_faults[n].row), campaign_faults[n].row);
        TEST_ASSERT_EQUAL_MESSAGE(campaign_faults[n].excused != 0u, campaign_faults[n].because[0] != '\0',
                                  campaign_faults[n].name);
    }
}

static void test_every_motor_can_be_driven_by_the_board(void)
{
    for (uint32_t run = 0; run < DRAWN; run++) {
        campaign_case_t drawn;
        campaign_draw(13u, run, 2.0, &drawn);
        const campaign_motor_t m = campaign_motor(&drawn);
        const double omega_e = m.pole_pairs * m.speed;
        const double most = m.fastest * omega_e;
        const double emf = omega_e * m.flux_linkage;
        const double along = emf + m.resistance * m.current;
        const double across = omega_e * m.inductance_q * m.current;
        const double link = CAMPAIGN_VALUE(&drawn, dc_voltage);
        TEST_ASSERT_TRUE(m.current >= 0.5 && m.current <= 10.0);
        TEST_ASSERT_TRUE(m.speed >= 60.0 && m.speed <= 1000.0);
        TEST_ASSERT_TRUE(omega_e <= 2000.0 * 1.000001);
        TEST_ASSERT_TRUE(m.fastest == 1.0 || (m.fastest <= 2.5 && most * RIG_PERIOD_SECONDS < 0.33));
        TEST_ASSERT_TRUE(m.inductance_q <= 4.0 * m.inductance_d * 1.000001);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9 * m.torque, 1.5 * m.pole_pairs * m.flux_linkage * m.current, m.torque);
        TEST_ASSERT_TRUE(emf < link / sqrt(3.0));
        /* At half the rated speed with rated current the link voltage is not exhausted. */
        TEST_ASSERT_TRUE(hypot(along - 0.5 * emf, 0.5 * across) < link / sqrt(3.0));
        /* The ripple, peak to peak, at the extremes of both voltages. */
        TEST_ASSERT_TRUE(link * RIG_PERIOD_SECONDS / (6.0 * m.inductance_d) <= 0.3 * m.current * 1.000001);
    }
}

/* A catch closes the bridge on a rotor at 0.9 of rated speed, whose EMF acts for three periods on the winding
 * before the control balances it. The flux that overcurrent_trip, 1.5 times the rated current, has on each
 * axis is at least the flux of this EMF. Where the q axis saturates, it is L_q i/sqrt(1 + (i/I_s)^2). */
static void test_no_catch_of_a_motor_trips_by_its_current_also_where_the_iron_saturates(void)
{
    uint32_t saturates = 0;
    for (uint32_t run = 0; run < DRAWN; run++) {
        campaign_case_t drawn;
        campaign_draw(16u, run, 2.0, &drawn);
        const campaign_motor_t m = campaign_motor(&drawn);
        if (CAMPAIGN_VALUE(&drawn, motor_drawn) == 0.0) {
            continue;
        }
        const double current = 1.5 * m.current;
        const double bent = m.saturation > 0.0 ? hypot(1.0, current / m.saturation) : 1.0;
        const double least = fmin(m.inductance_d * current, m.inductance_q * current / bent);
        const double driven = 3.0 * RIG_PERIOD_SECONDS * 0.9 * m.pole_pairs * m.speed * m.flux_linkage;
        TEST_ASSERT_TRUE(least >= driven * 0.999999);
        saturates += m.saturation > 0.0;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(DRAWN / 20u, saturates);
}

/* The share of refused draws is below a hundredth, and each refusal names a row and a reason. */
static void test_what_is_drawn_is_accepted(void)
{
    uint32_t refused = 0;
    for (uint32_t run = 0; run < DRAWN; run++) {
        char text[CAMPAIGN_TEXT_SIZE];
        campaign_case_t drawn;
        scenario_error_t error;
        campaign_draw(14u, run, 2.0, &drawn);
        const size_t octets = campaign_text(&drawn, NULL, text, sizeof text);
        TEST_ASSERT_TRUE(octets > 0u);
        scenario_t *scenario = scenario_read_text("drawn", text, octets, &error);
        if (scenario == NULL) {
            refused++;
            TEST_ASSERT_NOT_NULL_MESSAGE(rig_row_by_name(error.name), error.message);
        }
        scenario_free(scenario);
    }
    TEST_ASSERT_LESS_THAN_UINT32(DRAWN / 100u, refused);
}

/* A sensor that shows more than current_offset_max without current is refused, so that a drift and the offset
 * before it must be less: on every board. A step from one drift to the opposite one must not show a current
 * of more than overcurrent_trip. */
static void test_no_drift_makes_an_offset_that_the_drive_refuses_or_an_overcurrent(void)
{
    const double most = rig_initial_named("current_offset_max");
    uint32_t drifts = 0;
    for (uint32_t run = 0; run < DRAWN; run++) {
        campaign_case_t drawn;
        campaign_draw(15u, run, 2.0, &drawn);
        for (uint32_t n = 0; n < drawn.event_count; n++) {
            const double value = drawn.events[n].kind == CAMPAIGN_V_DRIFT ? drawn.events[n].value : 0.0;
            drifts += value != 0.0 ? 1u : 0u;
            TEST_ASSERT_TRUE(fabs(CAMPAIGN_VALUE(&drawn, offset_a) + value) < most);
            TEST_ASSERT_TRUE(fabs(CAMPAIGN_VALUE(&drawn, offset_b) - value) < most);
            TEST_ASSERT_TRUE(2.0 * fabs(value) < 0.9 * campaign_trip(&drawn));
        }
    }
    TEST_ASSERT_TRUE(drifts > DRAWN / 10u);
}

/* The offsets of 0.1 and 0.2 A drift by 0.3 A, a by +0.3 A and b by -0.3 A. The offset of a sensor is wrong
 * for 10 ms after that, and returns to the value to which it has drifted. */
static void test_a_wrong_offset_that_ends_returns_to_the_drifted_one(void)
{
    static const char *const rows[] = {"current_offset_a", "current_offset_b"};
    static const double ends[] = {0.4, -0.1};
    for (size_t k = 0; k < 2u; k++) {
        char text[CAMPAIGN_TEXT_SIZE];
        scenario_error_t error;
        campaign_case_t drawn = {.seconds = 0.1, .event_count = 1u};
        set_initial(&drawn);
        drawn.quantities[CAMPAIGN_Q_offset_a] = 0.1;
        drawn.quantities[CAMPAIGN_Q_offset_b] = 0.2;
        drawn.events[0] = (campaign_event_t){.kind = CAMPAIGN_V_DRIFT, .time = 0.02, .value = 0.3};
        uint32_t kind = 1u;
        while (strcmp(campaign_faults[kind].name, rows[k]) != 0) {
            kind++;
        }
        drawn.faults[0] = (campaign_injected_t){.kind = kind, .time = 0.05, .lasts = 0.01, .value = -0.25};
        const size_t octets = campaign_text(&drawn, NULL, text, sizeof text);
        scenario_t *scenario = scenario_read_text("drawn", text, octets, &error);
        TEST_ASSERT_NOT_NULL(scenario);
        const scenario_event_t *last = &scenario->events[scenario->event_count - 1u];
        TEST_ASSERT_EQUAL_UINT32(1u, last->count);
        TEST_ASSERT_EQUAL_STRING(rows[k], last->settings[0].row->name);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, ends[k], last->settings[0].value);
        scenario_free(scenario);
    }
}

static void test_a_case_of_defaults_sets_nothing_but_the_friction_and_the_uncertainty_of_its_data(void)
{
    char text[CAMPAIGN_TEXT_SIZE];
    scenario_error_t error;
    campaign_case_t plain = {.seconds = 0.1};
    set_initial(&plain);
    const size_t octets = campaign_text(&plain, NULL, text, sizeof text);
    scenario_t *scenario = scenario_read_text("plain", text, octets, &error);
    TEST_ASSERT_NOT_NULL(scenario);
    for (uint32_t n = 0; n < scenario->events[0].count; n++) {
        const char *name = scenario->events[0].settings[n].row->name;
        TEST_ASSERT_TRUE_MESSAGE(
            strcmp(name, "friction_coulomb") == 0 || strcmp(name, "motor_data_uncertainty") == 0, name);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, scenario->event_count);
    scenario_free(scenario);
}

/* ---- what is judged ---- */

/* A running drive of the default motor without a defect, with a trip of 15 A and with a fault of which
 * only the kind matters. */
static void judge_anew(const char *fault)
{
    observed = (campaign_case_t){0};
    inject(fault, 0.0, 0.0);
}

static void test_every_float_among_the_signals_is_watched(void)
{
    judge_anew("");
    for (uint32_t n = 0; n < signals_table.count; n++) {
        if (signals_table.rows[n].kind == SLOT_FLOAT) {
            TEST_ASSERT_TRUE(slot(signals_table.rows[n].name) < &slots[floats]);
        }
    }
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(RIG_TAP_MAX, count);
}

static void test_every_float_that_is_no_number_or_infinite_is_a_violation(void)
{
    static const float bad[] = {(float)NAN, (float)INFINITY, -(float)INFINITY};
    judge_anew("");
    const uint32_t all = floats;
    for (uint32_t n = 0; n < all; n++) {
        judge_anew("");
        const uint32_t finite = 0x7f7fffffu; /* the largest number */
        slots[n] = n < all - CAMPAIGN_FLOATS_JUDGED ? finite : 0u;
        pass(PERIOD);
        expect(HELD, "finite");
        memcpy(&slots[n], &bad[n % 3u], sizeof bad[0]);
        pass(PERIOD);
        expect(CAMPAIGN_I_NUMBER, "not finite");
        TEST_ASSERT_EQUAL_UINT32(ids[n], result.row);
        TEST_ASSERT_EQUAL_UINT32(1u, result.period);
    }
}

/* The limit is 1.2 times the trip, 18 A; a wrong sensor excuses a current up to 25 A. A third of a turn
 * with four pole pairs takes 52.4 ms at 10 rad/s and 5 ms at 100 rad/s. */
#define PHASE(x)                                                                                             \
    {                                                                                                        \
        .what = "phase " x, .fault = "",                                                                     \
        .steps = {{"true_i_" x "=-17.98", 10.0 * PERIOD},                                                    \
                  {"true_i_" x "=-18.02", 2.0 * PERIOD},                                                     \
                  {"true_i_" x "=0", PERIOD},                                                                \
                  {"true_i_" x "=18.02", 2.0 * PERIOD},                                                      \
                  {"", PERIOD}},                                                                             \
        .violated = CAMPAIGN_I_CURRENT, .row = "true_i_" x, .periods = 2u                                    \
    }

static const course_t courses[] = {
    PHASE("a"),
    PHASE("b"),
    PHASE("c"),
    /* In the first period a gate was still on. */
    {"current with all gates off is excused", "",
     .steps = {{"gates=0", PERIOD}, {"true_i_b=1000", 20.0 * PERIOD}}, .violated = HELD,
     .excused = CAMPAIGN_BIT(CURRENT)},
    {"an angle wrong by more than 0.8 rad may last 50 ms of run", "",
     .steps = {{"theta_err=-0.81", 50e-3},
               {"manoeuvre=relock", PERIOD}, /* the drive reacts */
               {"manoeuvre=run", 50e-3},
               {"theta_err=0.79", PERIOD},
               {"theta_err=0.81", 50e-3},
               {"state=ready", PERIOD},
               {"state=operation_enabled", 50e-3},
               {"", PERIOD}},
     .violated = CAMPAIGN_I_ANGLE, .row = "theta_err", .periods = 500u},
    /* In the period in which the fault is latched the gates may still be on. */
    {"a gate that is on a period after the fault was latched", "",
     .steps = {{"state=fault fault_reason=52", PERIOD}, {"", PERIOD}}, .violated = CAMPAIGN_I_GATES,
     .row = "state"},
    /* A flipped bit has caused this state; it may last two windows and two periods. */
    {"a state of a fault that has no reason, for eighteen periods", "",
     .steps = {{"state=fault", 18.0 * PERIOD}}, .violated = HELD},
    {"a state of a fault that has no reason, for a period more", "",
     .steps = {{"state=fault", 19.0 * PERIOD}}, .violated = CAMPAIGN_I_GATES, .row = "state"},
    {"a spike within one period", "",
     .steps = {{"state=fault fault_reason=52 gates=0", 100.0 * PERIOD}, {"gates=1 gates=0", PERIOD}},
     .violated = CAMPAIGN_I_GATES, .row = "state"},
    {"a late sample", "", .steps = {{"sample_flags=7", PERIOD}, {"sample_flags=8", PERIOD}},
     .violated = CAMPAIGN_I_LATE, .row = "sample_flags"},
    {"a short through a leg", "", .steps = {{"shoot_throughs=1", PERIOD}}, .violated = CAMPAIGN_I_LEGS,
     .row = "shoot_throughs"},
    {"a report of the chip", "", .steps = {{"chip_reports=1", PERIOD}}, .violated = CAMPAIGN_I_CHIP,
     .row = "chip_reports"},
    {"a violation that a fault causes by itself is excused, and no other", "late_interrupt",
     .steps = {{"sample_flags=8", 5.0 * PERIOD}, {"shoot_throughs=1", PERIOD}}, .violated = CAMPAIGN_I_LEGS,
     .row = "shoot_throughs", .excused = CAMPAIGN_BIT(LATE)},
    {"an interrupt that runs past its period does not control the current", "slow_interrupt",
     .steps = {{"true_i_a=40", 10.0 * PERIOD}, {"shoot_throughs=1", PERIOD}}, .violated = CAMPAIGN_I_LEGS,
     .row = "shoot_throughs", .excused = CAMPAIGN_BIT(CURRENT)},
    /* The rotor drives the current itself, which brakes it; with another current the limit holds again. */
    {"a rotor that is caught above overspeed_trip excuses the current that it drives, and no later one", "",
     .steps = {{"manoeuvre=catch true_omega_m=1000 true_i_a=20", 5.0 * PERIOD},
               {"true_omega_m=100", 5.0 * PERIOD},
               {"true_i_a=10", PERIOD},
               {"true_i_a=20", 2.0 * PERIOD},
               {"", PERIOD}},
     .violated = CAMPAIGN_I_CURRENT, .row = "true_i_a", .excused = CAMPAIGN_BIT(CURRENT)},
    /* While the bridge is off, the time does not run. */
    {"a sensor that is stuck excuses the current for 20 ms with the bridge on", "stuck_near_zero_a",
     .steps = {{"gates=0", 500.0 * PERIOD},
               {"gates=1 true_i_b=24 true_omega_m=100", 20e-3},
               {"", 3.0 * PERIOD}},
     .violated = CAMPAIGN_I_CURRENT, .row = "true_i_b", .excused = CAMPAIGN_BIT(CURRENT)},
    {"a sensor that is stuck excuses the current for a third of a turn", "stuck_near_zero_a",
     .steps = {{"true_i_b=18.5 true_omega_m=10", 52e-3}, {"", 1e-3}}, .violated = CAMPAIGN_I_CURRENT,
     .row = "true_i_b"},
    {"a sensor that is stuck excuses a current up to 25 A", "stuck_near_zero_a",
     .steps = {{"true_i_b=25.1", 2.0 * PERIOD}, {"", PERIOD}}, .violated = CAMPAIGN_I_CURRENT,
     .row = "true_i_b"},
    {"a wrong gain excuses the current up to 25 A", "current_range",
     .steps = {{"true_i_c=-24.9", 0.5}, {"true_i_c=-25.1", 3.0 * PERIOD}}, .violated = CAMPAIGN_I_CURRENT,
     .row = "true_i_c"},
    {"a flipped bit may make a signal infinite, but not the angle of a drive that runs", "flipped_bit",
     .steps = {{"theta_err=nan", 50e-3}, {"", PERIOD}}, .violated = CAMPAIGN_I_ANGLE, .row = "theta_err",
     .excused = CAMPAIGN_BIT(NUMBER)},
    {"a chip that is reset by a fault must have its gates off, and no other requirement applies",
     "slow_background",
     .steps = {{"chip_reports=1 gates=0", PERIOD}, {"theta_err=3", 0.2}, {"gates=1", PERIOD}},
     .violated = CAMPAIGN_I_GATES, .row = "state", .excused = CAMPAIGN_BIT(CHIP)},
};

static void test_each_course_has_its_expected_verdict(void)
{
    for (size_t n = 0; n < sizeof courses / sizeof courses[0]; n++) {
        judge_anew(courses[n].fault);
        follow(&courses[n]);
    }
}

static void test_the_values_of_the_judge_are_those_of_the_drive(void)
{
    TEST_ASSERT_EQUAL_UINT32(DRIVE_SAMPLE_LATE, CAMPAIGN_LATE_FLAG);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(CAMPAIGN_STATE_WORDS, sizeof(drive_t) / sizeof(uint32_t));
}

/* While the EMF is too small to show the angle, the time of a wrong angle does not run. */
static void test_what_only_the_emf_shows_excuses_the_angle_of_a_slow_rotor(void)
{
    static const char *const faults[] = {"leg_drop_a", "estimate_jump"};
    for (size_t n = 0; n < sizeof faults / sizeof faults[0]; n++) {
        judge_anew(faults[n]);
        put("theta_err", 1.0f);
        put("true_i_a", 2.0f);
        put("true_omega_m", 0.99f * (float)watch.excused[0].blind);
        pass(0.5);
        expect(HELD, "below the speed from which on the EMF shows the angle");
        TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(ANGLE), result.excused);
        put("true_omega_m", 1.01f * (float)watch.excused[0].blind);
        pass(50e-3 + PERIOD);
        expect(CAMPAIGN_I_ANGLE, "above the speed from which on the EMF shows the angle");
    }
}

/* A leg that loses U takes 2/3 U from the voltage vector. An EMF of this length may be hidden: that of a
 * speed of 2/3 U/(psi_f p). A resistance loses R I at rated current, a delay its share of the period. */
static void test_a_leg_that_loses_more_hides_the_emf_of_a_faster_rotor(void)
{
    static const struct {
        const char *fault;
        double value;
        double volts_per_current, volts_per_link; /* [1] or [ohm], of I or 1; [1] of u_dc */
    } cases[] = {{"leg_drop_a", 45.0, 0.0, 0.0},
                 {"leg_resistance_b", 8.0, 8.0, 0.0},
                 {"leg_delay_c", 12e-6, 0.0, 12e-6 / PERIOD},
                 {"leg_drop_a", 3.0, 0.0, 0.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        judge_anew("");
        set_initial(&observed);
        observed.quantities[CAMPAIGN_Q_dc_voltage] = 311.0;
        inject(cases[n].fault, cases[n].value, 0.0);
        const campaign_motor_t *motor = &watch.motor;
        const double current = cases[n].volts_per_current * motor->current;
        const double link = cases[n].volts_per_link * 311.0;
        const double lost = current + link > 0.0 ? current + link : cases[n].value;
        const double hidden = 2.0 / 3.0 * lost / (motor->flux_linkage * motor->pole_pairs);
        const double blind = campaign_blind_speed(&observed);
        TEST_ASSERT_TRUE((n < 3u) == (hidden > blind));
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, n < 3u ? hidden : blind, watch.excused[0].blind);
    }
}

/* An open wire or switch must be reported from a commanded current of 0.04 of the sensors' range on. While it
 * is smaller, the open wire may turn the EMF by any angle. */
static void test_an_open_wire_excuses_the_angle_while_the_current_cannot_show_it(void)
{
    static const char *const names[] = {"open_phase_a", "open_phase_b", "open_phase_c", "open_switch"};
    const double least = 0.04 * (double)BOARD_CURRENT_RANGE;
    for (size_t n = 0; n < 2u * sizeof names / sizeof names[0]; n++) {
        const bool small = n % 2u == 0u;
        judge_anew("");
        inject(names[n / 2u], 1.0, 0.0);
        put("theta_err", 2.0f);
        put("true_omega_m", 100.0f);
        put("i_d_ref", (float)(0.6 * least));
        put("i_q_ref", (float)((small ? 0.79 : 0.81) * least));
        pass(0.052);
        expect(small ? HELD : CAMPAIGN_I_ANGLE, names[n / 2u]);
    }
}

/* A slow rotor has an angle error of `share` of its limit for longer than allowed, with this current in
 * phase a [A]; half of it returns through each of the other phases. */
static void turn_wrongly(double share, double current)
{
    put("theta_err", 1.0f);
    put("true_i_a", (float)current);
    put("true_i_b", (float)(-0.5 * current));
    put("true_i_c", (float)(-0.5 * current));
    put("true_omega_m", (float)(share * watch.excused[0].blind));
    pass(0.1);
}

/* At 2 A (L_q - L_d) i is half of psi_f: the EMF at a wrong angle is half as large, and the speed limit
 * twice as large. It is twice as large also while the current is too small to show the sign of the voltage
 * of a leg. */
static void test_a_smaller_emf_excuses_the_angle_up_to_the_speed_that_makes_up_for_it(void)
{
    static const struct {
        const char *what;
        /* (L_q - L_d)/psi_f [1/A]; current [A], or as a multiple of the smallest current; share of the
         * limit. */
        double apart, current, share;
        int end;
    } cases[] = {
        {"a salient rotor below its limit", 0.25, 2.0, 1.98, HELD},
        {"a salient rotor above its limit", 0.25, 2.0, 2.02, CAMPAIGN_I_ANGLE},
        {"a round rotor with the same current", 0.0, 2.0, 1.98, CAMPAIGN_I_ANGLE},
        {"almost no current, below the limit", 0.0, -0.98, 1.98, HELD},
        {"almost no current, above the limit", 0.0, -0.98, 2.02, CAMPAIGN_I_ANGLE},
        {"a little more current", 0.0, -1.02, 1.02, CAMPAIGN_I_ANGLE},
    };
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        judge_anew("leg_drop_a");
        watch.motor.inductance_q = watch.motor.inductance_d + cases[n].apart * watch.motor.flux_linkage;
        const double current = cases[n].current;
        turn_wrongly(cases[n].share, current < 0.0 ? -current * watch.truth.none : current);
        expect(cases[n].end, cases[n].what);
    }
}

/* An offset of 0.3 times 10 A in one of two sensors is an error of 2/sqrt(3) 3 A = 3.46 A of the current
 * vector. While less flows, the signs of the phase currents are uncertain. */
static void test_an_offset_that_exceeds_the_current_excuses_the_angle_up_to_twice_the_speed(void)
{
    static const struct {
        double current, share;
        int end;
    } cases[] = {{3.4, 1.98, HELD}, {3.4, 2.02, CAMPAIGN_I_ANGLE}, {3.5, 1.02, CAMPAIGN_I_ANGLE}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        judge_anew("");
        inject("current_offset_b", 0.3, 0.0);
        turn_wrongly(cases[n].share, cases[n].current);
        expect(cases[n].end, "with an offset of 3 A");
    }
}

/* A phase current stays at a share of a limit for three samples. */
static void carry(double current, int end, const char *what)
{
    put("true_i_b", (float)(0.99 * current));
    pass(10.0 * PERIOD);
    expect(HELD, what);
    put("true_i_b", (float)(-1.01 * current));
    pass(3.0 * PERIOD);
    expect(end, what);
}

/* 1.2 times the trip are 18 A. The measured current is wrong by the step of the offset from -0.4 A to 0.3
 * times the rated current; after the fault has ended, and 0.1 s later, by nothing. */
static void test_an_offset_of_a_sensor_adds_to_the_limit_of_the_current(void)
{
    judge_anew("");
    observed.quantities[CAMPAIGN_Q_offset_b] = -0.4;
    inject("current_offset_b", 0.3, 0.0);
    carry(18.0 + 0.3 * watch.motor.current + 0.4, CAMPAIGN_I_CURRENT, "while the offset is there");
    judge_anew("");
    inject("current_offset_b", 0.3, 0.01);
    pass(0.1102);
    carry(18.0, CAMPAIGN_I_CURRENT, "afterwards");
}

/* With offsets of 0.5 A, -0.25 A and none, exchanged sensors differ by 0.25, 0.5 and 0.75 A. A drift by
 * -0.125 A makes these 0.125, 0.375 and 0.5 A from its time on. */
static void test_the_offset_of_an_exchanged_sensor_adds_to_the_limit_of_the_current(void)
{
    static const struct {
        double pair, drifts, offset; /* [-], [s], [A] */
    } cases[] = {{1.0, 1.0, 0.25},   {2.0, 1.0, 0.5},    {3.0, 1.0, 0.75},
                 {1.0, -1.0, 0.125}, {2.0, -1.0, 0.375}, {3.0, -1.0, 0.5}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        judge_anew("");
        observed.quantities[CAMPAIGN_Q_offset_a] = 0.5;
        observed.quantities[CAMPAIGN_Q_offset_b] = -0.25;
        observed.event_count = 1u;
        observed.events[0] =
            (campaign_event_t){.kind = CAMPAIGN_V_DRIFT, .time = cases[n].drifts, .value = -0.125};
        inject("swap_currents", cases[n].pair, 0.0);
        carry(18.0 + cases[n].offset, CAMPAIGN_I_CURRENT, "exchanged");
    }
}

/* A sensor is stuck at code 1980, -0.033 of 1.5 V, while its offset of 0.1 A is measured. The drive uses the
 * measured value until the bridge is off again, also after the fault has gone. */
static void test_an_offset_measured_with_a_stuck_sensor_adds_to_the_limit_of_the_current(void)
{
    for (int measured = 1; measured >= 0; measured--) {
        judge_anew("");
        observed.quantities[CAMPAIGN_Q_offset_a] = 0.1;
        inject("stuck_near_zero_a", 1980.0, 0.02);
        put("true_omega_m", 300.0f);
        set_rows(measured != 0 ? "gates=0 state=ready" : "");
        pass(0.01);
        set_rows("gates=1 state=operation_enabled");
        pass(0.1102);
        const double shown = (1980.0 / 4095.0 * 3.0 - 1.5) / 1.5 * rig_initial_named("plant.current_range");
        carry(18.0 + (measured != 0 ? 0.1 - shown : 0.0), CAMPAIGN_I_CURRENT, "after the stuck sensor");
    }
}

/* The trip is 1.5 times the rated current. A q axis that saturates below it does not limit the current. */
static void test_a_stuck_sensor_has_no_ceiling_if_the_motor_saturates_below_its_trip(void)
{
    static const double shares[] = {0.0, 1.45, 1.55};
    for (size_t n = 0; n < sizeof shares / sizeof shares[0]; n++) {
        judge_anew("");
        set_initial(&observed);
        observed.quantities[CAMPAIGN_Q_motor_drawn] = 1.0;
        observed.quantities[CAMPAIGN_Q_interior] = 2.0;
        observed.quantities[CAMPAIGN_Q_saturation] = shares[n];
        inject("stuck_near_zero_a", 1980.0, 0.0);
        TEST_ASSERT_EQUAL_DOUBLE(shares[n] == 1.45 ? (double)INFINITY : PROMISED_CURRENT,
                                 watch.excused[0].ceiling);
    }
}

/* Half of 2/3 U_dc drives 0.4 ms U_dc/L in 1.2 ms. The motor with the largest current has the smallest L. */
static void test_the_ceiling_of_a_stuck_sensor_grows_as_the_inductance_becomes_small(void)
{
    static const double currents[] = {1.0, 3.5, 10.0};
    for (size_t n = 0; n < sizeof currents / sizeof currents[0]; n++) {
        judge_anew("");
        set_initial(&observed);
        observed.quantities[CAMPAIGN_Q_motor_drawn] = 1.0;
        observed.quantities[CAMPAIGN_Q_current] = currents[n];
        observed.quantities[CAMPAIGN_Q_reactance] = 0.0;
        inject("stuck_near_zero_a", 1980.0, 0.0);
        const double driven =
            0.4e-3 * observed.quantities[CAMPAIGN_Q_dc_voltage] / campaign_motor(&observed).inductance_d;
        TEST_ASSERT_EQUAL_DOUBLE(n == 2u, driven > PROMISED_CURRENT);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, n == 2u ? driven : PROMISED_CURRENT, watch.excused[0].ceiling);
    }
}

static void test_swapped_wires_excuse_the_angle_only_without_an_encoder(void)
{
    judge_anew("swap_phases");
    observed.event_count = 1u; /* position_source changes after half a second */
    observed.events[0] = (campaign_event_t){.kind = CAMPAIGN_V_SOURCE, .time = 5000.0 * PERIOD};
    put("theta_err", 1.0f);
    pass(5000.0 * PERIOD);
    expect(HELD, "without");
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(ANGLE), result.excused);
    pass(50e-3);
    expect(HELD, "for 50 ms with an encoder");
    pass(2.0 * PERIOD);
    expect(CAMPAIGN_I_ANGLE, "after 50 ms with an encoder");
}

/* The drive of this run has a handover_speed of 108.04 rad/s, and 0.4 of it as fallback_speed. Up to the
 * handover_speed a load may turn the shaft against the reference before the EMF is judged. With the
 * current limit it passes from one direction to the other in 0.15 s, more than it waits for. */
static void test_the_drive_waits_for_the_emf_of_a_shaft_that_is_to_pass_zero(void)
{
    campaign_case_t drawn;
    campaign_draw(29113004u, 9106u, 2.0, &drawn);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.4 * 108.04, campaign_fallback_speed(&drawn));
    TEST_ASSERT_EQUAL_DOUBLE(0.1, campaign_passage_seconds(&drawn));
    static const struct {
        const char *what;
        double shaft, reference; /* [-] of fallback_speed */
        bool encoder;
        double most;    /* [s] longest time of a wrong angle */
        double current; /* [A] requested; 0: a speed is requested */
    } cases[] = {{"a shaft that a load stops at zero", 0.99, -1.01, false, 80e-3, 0.0},
                 {"a shaft that a load turns against the reference", 2.49, -1.01, false, 80e-3, 0.0},
                 {"a shaft that has the EMF of the hand-over", 2.51, -1.01, false, 50e-3, 0.0},
                 {"a shaft that has passed zero and has an EMF", -1.01, -1.01, false, 50e-3, 0.0},
                 {"a reference at which the drive does not wait", 0.99, 0.99, false, 50e-3, 0.0},
                 {"a shaft against whose direction a current is requested", 2.49, 0.0, false, 80e-3, -0.1},
                 {"a shaft in whose direction a current is requested", 2.49, 0.0, false, 50e-3, 0.1},
                 {"an encoder", 0.99, -1.01, true, 50e-3, 0.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        judge_anew("");
        observed.quantities[CAMPAIGN_Q_encoder] = cases[n].encoder ? 1.0 : 0.0;
        watch.passage = 80e-3;
        put("theta_err", 1.0f);
        put("true_omega_m", (float)(cases[n].shaft * watch.slow));
        put("omega_m_ref", (float)(cases[n].reference * watch.slow));
        put("i_q_request", (float)cases[n].current);
        *slot("mode") = cases[n].current != 0.0 ? 1u : 0u;
        pass(cases[n].most);
        expect(HELD, cases[n].what);
        pass(2.0 * PERIOD);
        expect(CAMPAIGN_I_ANGLE, cases[n].what);
    }
}

/* ---- many runs ---- */

#define RUNS    24u
#define SECONDS 0.1

/* tests/cli/test_cli.py tests shards, and that they merge to the text of one run. */
static void test_threads_change_nothing_nor_does_what_came_before_a_run(void)
{
    char why[POOL_WHY];
    campaign_result_t alone[RUNS] = {{0}};
    campaign_result_t threads[RUNS] = {{0}};
    campaign_t campaign = {
        .seed = 5u, .runs = RUNS, .seconds = SECONDS, .shard = 1u, .shards = 1u, .threads = 1u};
    TEST_ASSERT_TRUE(campaign_all(&campaign, alone, why));
    campaign.threads = 3u;
    TEST_ASSERT_TRUE(campaign_all(&campaign, threads, why));
    TEST_ASSERT_EQUAL_MEMORY(alone, threads, sizeof alone);
    campaign_case_t drawn;
    campaign_draw(5u, 3u, SECONDS, &drawn);
    TEST_ASSERT_TRUE(campaign_run(&drawn, NULL, &threads[0]));
    TEST_ASSERT_EQUAL(alone[3].end, threads[0].end);
    TEST_ASSERT_EQUAL(alone[3].reason, threads[0].reason);
}

/* ---- results as text ---- */

static void test_a_result_reads_back_from_its_line_and_a_torn_one_does_not(void)
{
    const campaign_result_t told = {CAMPAIGN_VIOLATED,
                                    CAMPAIGN_I_ANGLE,
                                    12345u,
                                    3010u,
                                    2u,
                                    38,
                                    33u,
                                    11845u,
                                    12000u,
                                    1u,
                                    3u,
                                    20000u,
                                    19900u,
                                    1250u,
                                    0u};
    char line[CAMPAIGN_LINE_SIZE];
    campaign_line(9999u, &told, line);
    uint32_t run = 0;
    campaign_result_t read = {0};
    TEST_ASSERT_TRUE(campaign_read_line(line, 10000u, &run, &read));
    TEST_ASSERT_EQUAL_UINT32(9999u, run);
    TEST_ASSERT_EQUAL_MEMORY(&told, &read, sizeof told);
    TEST_ASSERT_FALSE(campaign_read_line(line, 9999u, &run, &read));
    for (size_t length = strlen(line); length-- > 0u;) {
        char torn[CAMPAIGN_LINE_SIZE];
        snprintf(torn, sizeof torn, "%.*s", (int)length, line);
        TEST_ASSERT_FALSE_MESSAGE(campaign_read_line(torn, 10000u, &run, &read), torn);
    }
}
