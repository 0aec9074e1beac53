/* A fault that speaks of the shaft's speed names the estimate where only that has such a speed: what the EMF
 * of a tracked, a caught and a lost rotor confirms, and what it does not. */
#include "drive/drive.h"

#include <string.h>
#include <unity.h>

#include "settings/reasons.h"

static drive_t drive;

/* Sensorless, running with 100 V of EMF expected and seen. */
void setUp(void)
{
    params_t params;
    params_defaults(&params);
    params.position_source = POSITION_SENSORLESS;
    drive_init(&drive, &params);
    drive.medium.sequence.state = (int32_t)DRIVE_OPERATION_ENABLED;
    drive.window.measured.u_dc = 311.0f;
    manoeuvres_t *m = &drive.medium.manoeuvres;
    m->now = (int32_t)MANOEUVRE_RUN;
    m->sensorless = 1u;
    m->tracking = 1u;
    m->lock.expected = 100.0f;
    m->lock.projection = 100.0f;
}

void tearDown(void)
{
}

#define TRIP (drive.medium.speed.trip)

/* Caught, with 100 V of EMF that turns, and beyond the trip even if psi_f is 1/0.7 of what is believed. */
static void given_catch(void)
{
    manoeuvres_t *m = &drive.medium.manoeuvres;
    window_catch_t *catching = &drive.window.catching;
    drive.window.omega_m = -1.43f * TRIP;
    m->now = (int32_t)MANOEUVRE_CATCH;
    m->tracking = 0u;
    catching->length = 100.0f;
    catching->emf = (ab_t){60.0f, -80.0f};
    catching->cross = -2.0f;
    catching->cross_min = 1.0f;
}

static void expect(int32_t of, int32_t reason)
{
    drive_stop(&drive, of);
    TEST_ASSERT_EQUAL_INT32(reason, drive.fault_reason);
    TEST_ASSERT_EQUAL_INT32(reason, drive.fault.reason);
    TEST_ASSERT_EQUAL_INT32(reason, drive.log.faults[(drive.log.count - 1u) % FAULT_LOG_LENGTH].reason);
    TEST_ASSERT_FALSE(fault_set_any(drive.medium.sequence.faults_later));
}

/* psi_f wrong by a quarter is 0.75 to 1.33 of the EMF, an angle wrong by 0.35 rad takes 6 % of it. */
static void test_a_tracked_rotor_is_confirmed_by_its_emf(void)
{
    static const struct {
        float share;
        int32_t reason;
    } cases[] = {
        {-1.0f, REASON_ESTIMATE_ASTRAY}, {0.0f, REASON_ESTIMATE_ASTRAY}, {0.5f, REASON_ESTIMATE_ASTRAY},
        {0.71f, REASON_OVERSPEED},       {1.0f, REASON_OVERSPEED},       {1.33f, REASON_OVERSPEED},
        {1.6f, REASON_ESTIMATE_ASTRAY},  {3.0f, REASON_ESTIMATE_ASTRAY},
    };
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        setUp();
        drive.medium.manoeuvres.lock.projection = 100.0f * cases[n].share;
        expect(REASON_OVERSPEED, cases[n].reason);
    }
}

static void test_the_encoder_needs_no_confirmation(void)
{
    drive.medium.manoeuvres.sensorless = 0u;
    drive.medium.manoeuvres.lock.projection = 0.0f;
    expect(REASON_OVERSPEED, REASON_OVERSPEED);
}

static void test_a_caught_rotor_is_confirmed_by_a_mean_and_a_direction(void)
{
    given_catch();
    expect(REASON_OVERSPEED, REASON_OVERSPEED);
    given_catch();
    expect(REASON_ROTOR_TOO_FAST, REASON_ROTOR_TOO_FAST);
    given_catch();
    drive.window.catching.emf = (ab_t){0.0f, 65.0f}; /* noise: its mean is a part of its length */
    expect(REASON_OVERSPEED, REASON_ESTIMATE_ASTRAY);
    given_catch();
    drive.window.catching.cross = 0.9f; /* it does not turn */
    expect(REASON_ROTOR_TOO_FAST, REASON_ESTIMATE_ASTRAY);
}

/* The speed of a catch is a length over psi_f, which may be believed 30 % too small. */
static void test_a_caught_rotor_is_no_overspeed_by_as_much_as_its_flux_may_be_wrong(void)
{
    given_catch();
    drive.window.omega_m = 1.42f * TRIP;
    expect(REASON_OVERSPEED, REASON_ESTIMATE_ASTRAY);
    given_catch();
    drive.window.omega_m = 1.42f * TRIP; /* whose EMF is beyond the link needs no psi_f for that */
    expect(REASON_ROTOR_TOO_FAST, REASON_ROTOR_TOO_FAST);
    setUp();
    drive.window.omega_m = 1.01f * TRIP; /* tracked: turns are counted */
    expect(REASON_OVERSPEED, REASON_OVERSPEED);
}

/* 311 V hold 179.6 V in every direction: a rotor with 207 V would have fed the link before. */
static void test_an_emf_far_beyond_the_link_is_no_rotor(void)
{
    given_catch();
    drive.window.catching.length = 200.0f;
    drive.window.catching.emf = (ab_t){120.0f, -160.0f};
    expect(REASON_ROTOR_TOO_FAST, REASON_ROTOR_TOO_FAST);
    given_catch();
    drive.window.catching.length = 208.0f;
    drive.window.catching.emf = (ab_t){124.8f, -166.4f};
    expect(REASON_ROTOR_TOO_FAST, REASON_ESTIMATE_ASTRAY);
}

static void test_a_rotor_that_is_lost_confirms_nothing(void)
{
    given_catch();
    drive.medium.manoeuvres.now = (int32_t)MANOEUVRE_RELOCK;
    expect(REASON_OVERSPEED, REASON_ESTIMATE_ASTRAY);
    setUp();
    drive.medium.manoeuvres.now = (int32_t)MANOEUVRE_RELOCK; /* its loop tracks again */
    expect(REASON_OVERSPEED, REASON_ESTIMATE_ASTRAY);
}

static void test_no_other_fault_is_renamed(void)
{
    drive.medium.manoeuvres.lock.projection = 0.0f;
    expect(REASON_OVERCURRENT, REASON_OVERCURRENT);
    expect(REASON_LOCK_LOST, REASON_LOCK_LOST);
}
