/* A fault of the shaft's speed names the estimate if only the estimate has this speed. The tests give the
 * EMF of a tracked, a caught and a lost rotor, and check whether it confirms the fault. */
#include "drive/drive.h"

#include "settings/reasons.h"
#include "tests/unit/compare.h"

static drive_t drive;

/* The drive is running, and 100 V of EMF are expected. */
void setUp(void)
{
    params_t params;
    params_defaults(&params);
    drive_init(&drive, &params);
    drive.medium.sequence.state = (int32_t)DRIVE_OPERATION_ENABLED;
    drive.window.measured.u_dc = 311.0f;
    drive.medium.manoeuvres.lock.expected = 100.0f;
    drive.medium.manoeuvres.windows = MANOEUVRE_MASKED;
}

/* A rotor that is tracked, on the encoder or caught, at this share of the trip, with this EMF. */
typedef struct {
    const char *what;
    int32_t of, reason;
    manoeuvre_t now;
    bool encoder;
    float omega;       /* share of the trip, without the proportional part of a loop [-] */
    float projection;  /* [V] EMF along the axis if the rotor is tracked, of the expected 100 V */
    float length;      /* [V] length of the EMF in a catch; 0: the rotor is tracked */
    float alpha, beta; /* [V] mean EMF */
    float cross;       /* at least 1 in magnitude: the EMF rotates */
} case_t;

#define RUN    MANOEUVRE_RUN
#define CATCH  MANOEUVRE_CATCH
#define RELOCK MANOEUVRE_RELOCK
#define FAST   REASON_OVERSPEED
#define BEYOND REASON_ROTOR_TOO_FAST
#define ASTRAY REASON_ESTIMATE_ASTRAY

/* A psi_f that is wrong by a quarter gives 0.75 to 1.33 of the expected EMF, and an angle that is wrong by
 * 0.35 rad reduces it by 6 %. The speed of a catch is the length of the EMF divided by psi_f, which may be
 * configured 30 % too small. If the EMF exceeds the link voltage, the speed is confirmed whatever psi_f
 * is: 311 V correspond to 179.6 V in every direction, and a rotor with 207 V has fed the link already. */
static const case_t cases[] = {
    {"against the axis", FAST, ASTRAY, RUN, false, 1.1f, -100.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"no EMF", FAST, ASTRAY, RUN, false, 1.1f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"half of the EMF", FAST, ASTRAY, RUN, false, 1.1f, 50.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"0.71 of the EMF", FAST, FAST, RUN, false, 1.1f, 71.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"tracked: turns are counted", FAST, FAST, RUN, false, 1.01f, 100.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"tracked, with the proportional part of the loop", FAST, FAST, RUN, false, 0.81f, 100.0f, 0.0f, 0.0f,
     0.0f, 0.0f},
    {"by the proportional part of the loop", FAST, ASTRAY, RUN, false, 0.79f, 100.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"1.33 of the EMF", FAST, FAST, RUN, false, 1.1f, 133.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"1.6 of the EMF", FAST, ASTRAY, RUN, false, 1.1f, 160.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"three times the EMF", FAST, ASTRAY, RUN, false, 1.1f, 300.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"on the encoder", FAST, FAST, RUN, true, 1.1f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"another fault", REASON_OVERCURRENT, REASON_OVERCURRENT, RUN, false, 1.1f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"a lost lock", REASON_LOCK_LOST, REASON_LOCK_LOST, RUN, false, 1.1f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f},
    {"caught", FAST, FAST, CATCH, false, -1.43f, 100.0f, 100.0f, 60.0f, -80.0f, -2.0f},
    {"caught, beyond the link", BEYOND, BEYOND, CATCH, false, -1.43f, 100.0f, 100.0f, 60.0f, -80.0f, -2.0f},
    {"noise: its mean is small", FAST, ASTRAY, CATCH, false, -1.43f, 100.0f, 100.0f, 0.0f, 65.0f, -2.0f},
    {"an EMF that does not rotate", BEYOND, ASTRAY, CATCH, false, -1.43f, 100.0f, 100.0f, 60.0f, -80.0f,
     0.9f},
    {"a speed that an error of psi_f may explain", FAST, ASTRAY, CATCH, false, 1.42f, 100.0f, 100.0f, 60.0f,
     -80.0f, -2.0f},
    {"the same, beyond the link", BEYOND, BEYOND, CATCH, false, 1.42f, 100.0f, 100.0f, 60.0f, -80.0f, -2.0f},
    {"just below what every link allows", BEYOND, BEYOND, CATCH, false, -1.43f, 100.0f, 200.0f, 120.0f,
     -160.0f, -2.0f},
    {"far beyond the link", BEYOND, ASTRAY, CATCH, false, -1.43f, 100.0f, 208.0f, 124.8f, -166.4f, -2.0f},
    {"lost", FAST, ASTRAY, RELOCK, false, -1.43f, 100.0f, 100.0f, 60.0f, -80.0f, -2.0f},
    {"lost, and tracks again", FAST, ASTRAY, RELOCK, false, 1.1f, 100.0f, 0.0f, 0.0f, 0.0f, 0.0f},
};

static void test_a_speed_that_the_emf_does_not_confirm_is_an_estimate_astray(void)
{
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const case_t *one = &cases[n];
        setUp();
        manoeuvres_t *m = &drive.medium.manoeuvres;
        m->now = (int32_t)one->now;
        m->sensorless = one->encoder ? 0u : 1u;
        m->tracking = one->length > 0.0f ? 0u : 1u;
        m->lock.projection = one->projection;
        drive.window.omega_m = one->omega * drive.medium.speed.trip;
        drive.medium.estimate.omega_smooth = drive.window.omega_m / m->limits.pole_pairs_inverse;
        drive.window.catching.seen.length = one->length;
        drive.window.catching.seen.emf = (ab_t){one->alpha, one->beta};
        drive.window.catching.seen.cross = one->cross;
        drive.window.catching.seen.cross_min = 1.0f;
        drive_stop(&drive, one->of);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(one->reason, drive.fault_reason, one->what);
        TEST_ASSERT_EQUAL_INT32(one->reason, drive.fault.reason);
        TEST_ASSERT_EQUAL_INT32(one->reason,
                                drive.log.faults[(drive.log.count - 1u) % FAULT_LOG_LENGTH].reason);
        TEST_ASSERT_FALSE(fault_set_any(drive.medium.sequence.faults_later));
    }
}

/* The EMF along the axis is a mean over a window. A loop that loses the rotor can reach a much larger speed
 * in this time, and the EMF would then have to be longer: 100 V are 0.7 of 143 V. */
static void test_the_emf_must_confirm_the_speed_at_the_stop(void)
{
    static const struct {
        float emf; /* [V] of a rotor with the speed at the stop */
        int32_t reason;
    } stops[] = {{142.0f, FAST}, {-142.0f, FAST}, {144.0f, ASTRAY}, {-144.0f, ASTRAY}};
    for (size_t n = 0; n < sizeof stops / sizeof stops[0]; n++) {
        setUp();
        manoeuvres_t *m = &drive.medium.manoeuvres;
        m->now = (int32_t)RUN;
        m->sensorless = 1u;
        m->tracking = 1u;
        m->lock.projection = 100.0f;
        drive.medium.estimate.flux = 0.2f;
        drive.medium.estimate.omega_smooth = drive.medium.speed.trip / m->limits.pole_pairs_inverse;
        drive.fast.rotor.omega_e = stops[n].emf / 0.2f;
        drive_stop(&drive, REASON_OVERSPEED);
        TEST_ASSERT_EQUAL_INT32(stops[n].reason, drive.fault_reason);
    }
}

/* The mean EMF along the axis of a loop that has just begun is still the expected one. The catch before it
 * confirms the speed if its mean EMF over 1.7 ms is 0.7 to 1.1 of that over 3 ms, and rotates. With an open
 * wire the EMF grows. */
static void test_a_loop_that_begins_confirms_no_speed(void)
{
    static const struct {
        float alpha, beta, cross; /* [V], [V], [-] of the catch, whose EMF has a mean length of 100 V */
        int32_t reason;
    } catches[] = {{60.0f, -80.0f, 2.0f, FAST},
                   {65.4f, -87.2f, -2.0f, FAST},
                   {66.6f, -88.8f, 2.0f, ASTRAY},
                   {41.0f, -55.0f, 2.0f, ASTRAY},
                   {60.0f, -80.0f, 0.9f, ASTRAY}};
    for (size_t n = 0; n < 2u * sizeof catches / sizeof catches[0]; n++) {
        setUp();
        manoeuvres_t *m = &drive.medium.manoeuvres;
        m->now = (int32_t)RUN;
        m->sensorless = 1u;
        m->tracking = 1u;
        m->windows = n % 2u == 0u ? MANOEUVRE_MASKED - 1u : MANOEUVRE_MASKED;
        m->lock.projection = 100.0f;
        drive.window.omega_m = 1.1f * drive.medium.speed.trip;
        drive.medium.estimate.omega_smooth = drive.window.omega_m / m->limits.pole_pairs_inverse;
        drive.window.catching.seen.length = 100.0f;
        drive.window.catching.seen.emf = (ab_t){catches[n / 2u].alpha, catches[n / 2u].beta};
        drive.window.catching.seen.cross = catches[n / 2u].cross;
        drive.window.catching.seen.cross_min = 1.0f;
        drive_stop(&drive, REASON_OVERSPEED);
        TEST_ASSERT_EQUAL_INT32(n % 2u == 0u ? catches[n / 2u].reason : FAST, drive.fault_reason);
    }
}

/* The fast task reports the source of the speed at a stop of its own: the position source may have changed
 * since the setpoint that acts was made. The speed of a catch that no EMF confirms is then no overspeed. */
static void test_the_source_of_the_speed_is_that_at_the_stop(void)
{
    for (uint32_t n = 0; n < 4u; n++) {
        setUp();
        drive.medium.manoeuvres.now = (int32_t)RUN;
        drive.medium.manoeuvres.sensorless = n / 2u;
        drive.medium.manoeuvres.tracking = 1u;
        drive.window.omega_m = 1.1f * drive.medium.speed.trip;
        const drive_fault_t stop = {.reason = (int32_t)REASON_OVERSPEED};
        drive.window.report.stop = stop;
        drive.window.report.source = (int32_t)(n % 2u != 0u ? SOURCE_ENCODER : SOURCE_CATCH);
        medium_stop(&drive.medium, &drive.window, stop);
        TEST_ASSERT_EQUAL_INT32(n % 2u != 0u ? FAST : ASTRAY, drive.medium.fault.reason);
    }
}
