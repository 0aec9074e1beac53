/* What a campaign demands of a drive: that it obeys, works, and reports truly and in time. */
#include <string.h>

#include "drive/drive.h"
#include "host_sim/lab/campaign_parts.h"
#include "medium/manoeuvre/manoeuvres.h"
#include "medium/sequence.h"
#include "settings/reasons.h"
#include "tests/lab/watched.h"
#include "unity.h"

/* Gates on or all off, now. */
static void gates(bool on)
{
    campaign_watch_edge(&watch, 0u, (uint32_t)RIG_EDGE_GATES, on ? 0x15u : 0u);
}

/* The default motor, 10 A and 157 rad/s, runs at speed zero with the encoder; this fault from the start. */
static void judge_anew(const char *fault, double value)
{
    observed = (campaign_case_t){.seconds = 5.0};
    for (uint32_t n = 0; n < CAMPAIGN_QUANTITY_COUNT; n++) {
        observed.quantities[n] = campaign_quantities[n].initial;
    }
    observed.quantities[CAMPAIGN_Q_encoder] = 1.0;
    for (uint32_t n = 0; n < campaign_fault_count; n++) {
        if (strcmp(campaign_faults[n].name, fault) == 0) {
            observed.faults[0] = (campaign_injected_t){n, 0.0, value, 0.0};
        }
    }
    TEST_ASSERT_TRUE_MESSAGE(fault[0] == '\0' || observed.faults[0].kind != 0u, fault);
    watch_a_drive_that_runs();
    put("true_u_dc", 311.0f);
    gates(true);
}

static void pass(double seconds)
{
    const uint32_t periods = campaign_periods(seconds);
    for (uint32_t n = 0; n < periods; n++) {
        campaign_watch_sample(&watch, now++, slots, count);
    }
}

#define PERIOD RIG_PERIOD_SECONDS

static void expect_held(void)
{
    TEST_ASSERT_EQUAL_STRING("", result.end == CAMPAIGN_VIOLATED ? campaign_invariants[result.invariant].name
                                                                 : "");
}

static void expect_violated(campaign_invariant_t invariant)
{
    TEST_ASSERT_EQUAL(CAMPAIGN_VIOLATED, result.end);
    TEST_ASSERT_EQUAL_STRING(campaign_invariants[invariant].name, campaign_invariants[result.invariant].name);
}

static void test_off_means_no_gate_two_windows_and_two_periods_later(void)
{
    judge_anew("", 0.0);
    *slot("enable") = (uint32_t)REQUEST_OFF;
    pass((2.0 * DRIVE_WINDOW + 2.0) * PERIOD);
    gates(false);
    expect_held();
    pass(1.0);
    judge_anew("", 0.0);
    *slot("enable") = (uint32_t)REQUEST_OFF;
    pass((2.0 * DRIVE_WINDOW + 3.0) * PERIOD);
    expect_violated(CAMPAIGN_I_OFF);
}

static void test_on_with_the_bridge_off_and_no_refusal_may_last_10_ms(void)
{
    judge_anew("", 0.0);
    gates(false);
    *slot("state") = (uint32_t)DRIVE_READY;
    *slot("refusal") = (uint32_t)REASON_NOT_READY;
    pass(0.05);
    *slot("refusal") = 0u;
    pass(10e-3);
    expect_held();
    pass(PERIOD);
    expect_violated(CAMPAIGN_I_PERSIST);
}

/* 10 A of the default motor are 10.98 N m; 0.0636 kg m^2 at 100 rad/s stop with them in 0.58 s. */
static void test_a_quick_stop_may_take_three_times_what_rated_torque_needs_and_half_a_second(void)
{
    const double most = 0.5 + 3.0 * 100.0 * 0.0636 / (1.5 * 4.0 * 0.183 * 10.0);
    judge_anew("", 0.0);
    *slot("enable") = (uint32_t)REQUEST_QUICK_STOP;
    *slot("state") = (uint32_t)DRIVE_QUICK_STOP;
    put("true_omega_m", 100.0f);
    pass(most - 2e-3);
    expect_held();
    pass(4e-3);
    expect_violated(CAMPAIGN_I_STOP);
}

static void test_a_stop_for_a_fault_ends_within_fault_stop_time(void)
{
    judge_anew("motor_hot", 140.0);
    *slot("state") = (uint32_t)DRIVE_QUICK_STOP;
    pass(5.0);
    expect_held();
    pass(5e-3);
    expect_violated(CAMPAIGN_I_STOP);
}

static void test_a_shaft_beyond_its_trip_may_have_a_gate_on_for_5_ms(void)
{
    judge_anew("", 0.0);
    put("true_omega_m", 1.06f * 220.0f);
    put("omega_m_ref", 1.06f * 220.0f);
    put("speed_request", 1.06f * 220.0f);
    pass(5e-3);
    put("true_omega_m", 1.04f * 220.0f);
    pass(5e-3);
    put("true_omega_m", -1.06f * 220.0f);
    pass(5e-3);
    expect_held();
    pass(PERIOD);
    expect_violated(CAMPAIGN_I_TRIP_SPEED);
}

static void test_a_link_beyond_its_trip_may_have_a_gate_on_for_three_periods(void)
{
    judge_anew("", 0.0);
    put("true_u_dc", 400.4f); /* within a step of the converter */
    pass(0.05);
    put("true_u_dc", 400.6f);
    pass(3.0 * PERIOD);
    expect_held();
    pass(PERIOD);
    expect_violated(CAMPAIGN_I_TRIP_LINK);
}

static void test_a_gate_that_is_off_makes_a_fast_shaft_and_a_high_link_none_of_the_drives(void)
{
    judge_anew("", 0.0);
    gates(false);
    pass(PERIOD);
    *slot("enable") = (uint32_t)REQUEST_OFF;
    put("true_omega_m", 500.0f);
    put("true_u_dc", 500.0f);
    pass(1.0);
    expect_held();
}

static void test_a_quick_stop_that_drives_may_do_so_for_100_ms(void)
{
    judge_anew("", 0.0);
    *slot("enable") = (uint32_t)REQUEST_QUICK_STOP;
    *slot("state") = (uint32_t)DRIVE_QUICK_STOP;
    put("true_omega_m", 50.0f);
    put("true_torque", -5.0f); /* it brakes */
    pass(0.2);
    put("true_torque", 1.2f); /* a tenth of rated torque is 1.1 N m */
    pass(0.1);
    expect_held();
    pass(2.0 * PERIOD);
    expect_violated(CAMPAIGN_I_AWAY);
}

/* 157 rad/s rated, 80 rad/s asked for: torque away from that, 1.2 N m of 10.98, with this error in each of
 * 100 ms. */
static void drive_away(const float errors[4])
{
    judge_anew("", 0.0);
    put("speed_request", 80.0f);
    put("omega_m_ref", 80.0f);
    put("true_torque", 1.2f);
    const double answer = 3.0 * 14.0 / campaign_loop(&observed);
    for (int n = 0; n < 4; n++) {
        put("true_omega_m", 80.0f + errors[n]);
        pass(0.25 * answer + PERIOD);
    }
    pass(2.0 * PERIOD);
}

/* A load that goes leaves a speed that rises at first; by half of three time constants it comes back. */
static void test_a_torque_that_takes_the_speed_ever_further_away_is_flight(void)
{
    drive_away((const float[]){9.0f, 10.0f, 11.0f, 12.0f});
    expect_violated(CAMPAIGN_I_AWAY);
    drive_away((const float[]){9.0f, 12.0f, 12.0f, 11.0f});
    expect_held();
    drive_away((const float[]){12.0f, 12.0f, 11.0f, 13.0f});
    expect_held();
}

static void test_another_wish_begins_anew(void)
{
    judge_anew("", 0.0);
    put("true_torque", 1.2f);
    put("true_omega_m", 80.0f);
    for (int n = 0; n < 20; n++) {
        put("speed_request", 60.0f - (float)n);
        put("omega_m_ref", 60.0f - (float)n);
        pass(0.05);
    }
    expect_held();
}

/* A load that goes while the speed still comes back from a reversal takes it further away once more. */
static void test_another_load_begins_anew(void)
{
    for (int steps = 0; steps < 2; steps++) {
        judge_anew("", 0.0);
        put("speed_request", 80.0f);
        put("omega_m_ref", 80.0f);
        put("true_torque", 1.2f);
        const double answer = 3.0 * 14.0 / campaign_loop(&observed);
        put("load_torque", 2.0f);
        for (int n = 0; n < 4; n++) {
            put("true_omega_m", 89.0f + (float)n);
            put("load_torque", n >= 2 && steps != 0 ? 1.0f : 2.0f);
            pass(0.25 * answer + PERIOD);
        }
        pass(2.0 * PERIOD);
        if (steps != 0) {
            expect_held();
        } else {
            expect_violated(CAMPAIGN_I_AWAY);
        }
    }
}

static void test_current_mode_must_not_drive_by_more_than_is_asked_for(void)
{
    judge_anew("", 0.0);
    *slot("mode") = (uint32_t)MODE_CURRENT;
    put("i_q_request", 2.0f); /* 2.2 N m */
    put("true_omega_m", 50.0f);
    put("true_torque", 2.3f);
    pass(1.0);
    put("i_q_request", 0.0f);
    put("true_torque", -2.3f); /* what brakes is friction's, or the link's limit */
    pass(1.0);
    expect_held();
    put("true_torque", 2.3f);
    pass(1.0);
    expect_violated(CAMPAIGN_I_AWAY);
}

static void test_a_healthy_drive_that_does_not_reach_its_speed_is_found(void)
{
    judge_anew("", 0.0);
    put("speed_request", 20.0f);
    put("omega_m_ref", 20.0f);
    put("true_omega_m", 20.0f);
    pass(4.0);
    expect_held();
    put("true_omega_m", 0.0f); /* a tenth of rated speed is 15.7 rad/s */
    pass(0.2);
    expect_violated(CAMPAIGN_I_REACH);
    judge_anew("", 0.0);
    put("speed_request", 20.0f);
    put("load_torque", 0.6f * 10.98f); /* more than it must carry */
    pass(4.0);
    expect_held();
}

/* What takes the shaft towards zero feeds the link, and may take as long as friction needs; what takes it up
 * does not. */
static void test_a_soft_link_excuses_a_speed_only_while_the_wish_brakes(void)
{
    for (int up = 0; up < 2; up++) {
        judge_anew("", 0.0);
        observed.quantities[CAMPAIGN_Q_dc_soft] = 1e-3;
        campaign_watch_begin(&watch, &observed, &result, NULL);
        gates(true);
        put("true_omega_m", up != 0 ? 20.0f : 140.0f);
        put("speed_request", 80.0f);
        put("omega_m_ref", 80.0f);
        pass(5.0);
        if (up != 0) {
            expect_violated(CAMPAIGN_I_REACH);
        } else {
            expect_held();
        }
    }
}

static void test_a_load_that_overhauls_on_a_soft_link_is_expected_at_no_speed(void)
{
    judge_anew("", 0.0);
    observed.quantities[CAMPAIGN_Q_dc_soft] = 1e-3;
    observed.quantities[CAMPAIGN_Q_load_kind] = 1.0;
    observed.quantities[CAMPAIGN_Q_load] = 0.3;
    campaign_watch_begin(&watch, &observed, &result, NULL);
    gates(true);
    put("speed_request", 80.0f);
    put("omega_m_ref", 80.0f);
    pass(5.0);
    expect_held();
}

/* A drive that never comes on and gives a reason for that does not reach its speed either. */
static void test_a_refusal_that_lasts_is_a_speed_that_is_not_reached(void)
{
    judge_anew("", 0.0);
    gates(false);
    *slot("state") = (uint32_t)DRIVE_READY;
    *slot("refusal") = (uint32_t)REASON_ROTOR_TOO_FAST;
    put("speed_request", 100.0f);
    pass(5.0);
    expect_violated(CAMPAIGN_I_REACH);
}

/* 220 rad/s are the trip. A load that drives the shaft beyond that while the bridge is off is to be waited
 * for. */
static void test_a_shaft_beyond_its_trip_is_not_expected_to_be_started(void)
{
    judge_anew("", 0.0);
    gates(false);
    *slot("state") = (uint32_t)DRIVE_READY;
    *slot("refusal") = (uint32_t)REASON_ROTOR_TOO_FAST;
    put("speed_request", 100.0f);
    put("true_omega_m", -221.0f);
    pass(5.0);
    expect_held();
    put("true_omega_m", -219.0f);
    pass(10.0);
    expect_violated(CAMPAIGN_I_REACH);
}

static void test_a_hot_motor_is_reported_within_150_ms(void)
{
    judge_anew("motor_hot", 140.0);
    pass(0.15);
    expect_held();
    *slot("state") = (uint32_t)DRIVE_QUICK_STOP;
    pass(1.0);
    expect_held();
    judge_anew("motor_hot", 140.0);
    pass(0.15 + 2.0 * PERIOD);
    expect_violated(CAMPAIGN_I_NOTICE);
    judge_anew("motor_hot", 100.0); /* below its limit of 120 degC */
    pass(5.0);
    expect_held();
}

static void test_a_broken_wire_is_reported_within_a_turn_in_which_current_is_asked_for(void)
{
    judge_anew("open_phase_a", 1.0);
    put("true_omega_m", 31.4159f); /* an electrical turn in 50 ms */
    put("speed_request", 31.4159f);
    pass(1.0); /* nothing is asked for */
    expect_held();
    put("i_q_ref", 2.6f);
    pass(0.059);
    expect_held();
    pass(0.002);
    expect_violated(CAMPAIGN_I_NOTICE);
    TEST_ASSERT_EQUAL_UINT32(rig_row_by_name("fault_reason")->id, result.row);
}

/* A reason counts once it has stayed for two windows. */
static void latch(int32_t reason)
{
    gates(false);
    *slot("state") = (uint32_t)DRIVE_FAULT;
    *slot("fault_reason") = (uint32_t)reason;
    *slot("refusal") = (uint32_t)REASON_FAULT_LATCHED;
    pass((2.0 * DRIVE_WINDOW + 1.0) * PERIOD);
}

static void test_a_reason_that_has_not_happened_is_a_violation(void)
{
    static const int32_t untrue[] = {REASON_OVERSPEED,  REASON_ENCODER_MISMATCH, REASON_RUNAWAY,
                                     REASON_PHASE_LOSS, REASON_CURRENT_STUCK,    REASON_LOCK_LOST,
                                     REASON_MOTOR_HOT,  REASON_OVERCURRENT,      REASON_DC_OVERVOLTAGE};
    for (size_t n = 0; n < sizeof untrue / sizeof untrue[0]; n++) {
        judge_anew("", 0.0);
        pass(0.1);
        latch(untrue[n]);
        expect_violated(CAMPAIGN_I_REASON_TRUE);
    }
}

/* The window that follows may name anew what one period of the fast task has named. */
static void test_a_reason_that_is_named_anew_within_two_windows_is_not_judged(void)
{
    judge_anew("open_phase_b", 1.0);
    gates(false);
    *slot("state") = (uint32_t)DRIVE_FAULT;
    *slot("refusal") = (uint32_t)REASON_FAULT_LATCHED;
    *slot("fault_reason") = (uint32_t)REASON_OVERCURRENT;
    pass(2.0 * DRIVE_WINDOW * PERIOD);
    *slot("fault_reason") = (uint32_t)REASON_PHASE_LOSS;
    pass(1.0);
    expect_held();
    judge_anew("open_phase_b", 1.0);
    latch(REASON_OVERCURRENT);
    expect_violated(CAMPAIGN_I_REASON_TRUE);
}

/* The reason is shown as a refusal from the beginning of the stop on, and latched at its end. */
static void test_a_stop_for_a_fault_that_goes_meanwhile_has_a_true_reason(void)
{
    for (int late = 0; late < 2; late++) {
        judge_anew("motor_hot", 140.0);
        observed.faults[0].lasts = 0.1;
        campaign_watch_begin(&watch, &observed, &result, NULL);
        gates(true);
        pass(late != 0 ? 0.35 : 0.05);
        *slot("state") = (uint32_t)DRIVE_QUICK_STOP;
        *slot("refusal") = (uint32_t)REASON_MOTOR_HOT;
        pass(0.5);
        *slot("refusal") = 0u;
        pass(2.0 * PERIOD);
        latch(REASON_MOTOR_HOT);
        if (late == 0) {
            expect_held();
        } else {
            expect_violated(CAMPAIGN_I_REASON_TRUE);
        }
    }
}

static void test_a_reason_that_has_happened_is_none(void)
{
    judge_anew("", 0.0);
    put("true_omega_m", 210.0f);
    pass(10e-3);
    latch(REASON_OVERSPEED);
    expect_held();
    judge_anew("", 0.0);
    put("theta_err", 0.9f);
    pass(10e-3);
    latch(REASON_LOCK_LOST);
    expect_held();
    judge_anew("open_phase_b", 1.0);
    latch(REASON_PHASE_LOSS);
    expect_held();
    judge_anew("encoder_stuck_a", 1.0);
    latch(REASON_ENCODER_MISMATCH);
    expect_held();
}

/* Once a fault has gone, and a tenth of a second has passed, it makes no reason true and excuses nothing. */
static void test_a_fault_that_has_gone_is_no_excuse(void)
{
    judge_anew("late_interrupt", 150e-6);
    observed.faults[0].lasts = 0.05;
    campaign_watch_begin(&watch, &observed, &result, NULL);
    gates(true);
    *slot("sample_flags") = DRIVE_SAMPLE_LATE;
    *slot("state") = (uint32_t)DRIVE_QUICK_STOP;
    pass(0.15);
    expect_held();
    TEST_ASSERT_EQUAL_UINT32(CAMPAIGN_BIT(LATE), result.excused);
    pass(2.0 * PERIOD);
    expect_violated(CAMPAIGN_I_LATE);
}

static void test_false_alarms_beyond_two_in_a_thousand_are_more_than_chance(void)
{
    static campaign_result_t results[1000];
    campaign_t campaign = {.runs = 1000u};
    uint32_t calm = 0;
    uint32_t alarms = 0;
    for (uint32_t run = 0; run < 1000u; run++) {
        results[run] =
            (campaign_result_t){.end = CAMPAIGN_HELD, .calm = 1u, .invariant = CAMPAIGN_NO_INVARIANT};
        results[run].reason = run < 12u ? REASON_OVERSPEED : 0;
    }
    /* Poisson of mean 2: 12 or more 1.4e-6 of the time, 13 or more 1.6e-7 */
    TEST_ASSERT_TRUE(campaign_alarms(&campaign, results, &calm, &alarms));
    TEST_ASSERT_EQUAL_UINT32(1000u, calm);
    TEST_ASSERT_EQUAL_UINT32(12u, alarms);
    results[12].reason = REASON_OVERSPEED;
    TEST_ASSERT_FALSE(campaign_alarms(&campaign, results, &calm, &alarms));
    results[13].calm = 0u;
    results[13].reason = REASON_OVERSPEED; /* an injected fault, or a load that overhauls */
    TEST_ASSERT_FALSE(campaign_alarms(&campaign, results, &calm, &alarms));
    TEST_ASSERT_EQUAL_UINT32(13u, alarms);
}
