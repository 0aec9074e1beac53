/* The integrals of the current control when the manoeuvre changes the frame. Speed and current are zero,
 * and the currents are at their references, so that an integral changes for no other reason. */
#include "math/angle.h"
#include "math/trig.h"
#include "tests/unit/drive_bench.h"
#include "tests/unit/vectors.h"

void setUp(void)
{
    bench_begin();
}

static double complex integrals(void)
{
    return (double)drive.fast.current_control.d.integral + J * (double)drive.fast.current_control.q.integral;
}

#define OMEGA_E 400.0f /* [rad/s] speed that the loop reports, far above that of the hand-over */

/* The sum of integrals and feed-forward, which is the voltage if no current flows. */
static double complex made(void)
{
    return integrals() + (double)drive.fast.demand.emf.d +
           (double complex)I * (double)drive.fast.demand.emf.q;
}

/* The voltage in the stationary frame. */
static double complex voltage(void)
{
    return made() * cexp(J * (double)drive.fast.demand.frame.theta_e);
}

static void preset(float d, float q)
{
    drive.fast.current_control.d.integral = d;
    drive.fast.current_control.q.integral = q;
}

/* Brings the drive into operation with the encoder at this count, without a requested current. */
static void given_operation(uint32_t count)
{
    params.position_source = POSITION_ENCODER;
    params.low_speed_current = 0.0f;
    params.inductance_adaptation = 0.0f;
    drive_init(&drive, &params);
    samples.encoder = count;
    bring_to_ready();
    request_currents(0.0f, 0.0f);
    request(REQUEST_ON);
    windows(SWITCHING_ON + 2u);
    expect_state(DRIVE_OPERATION_ENABLED);
}

/* The loop reports that its EMF has the expected direction. */
static void claim(void)
{
    drive.fast.estimator.tracker.pll.emf = (dq_t){0.0f, params.motor_flux_linkage * OMEGA_E};
    drive.fast.estimator.estimate.emf_loop = (dq_t){0.0f, params.motor_flux_linkage * OMEGA_E};
    drive.fast.estimator.estimate.omega_smooth = OMEGA_E;
}

/* Estimate and encoder show different angles. The EMF agrees with the speed of the estimate, so that the
 * drive uses the estimate: the voltage vector must be the same in both frames. */
static void test_voltage_stays_when_the_frame_turns(void)
{
    for (int n = 0; n < 8; n++) {
        setUp();
        given_operation(700u);
        const float turned = 25.0f * DRIVE_PERIOD * OMEGA_E; /* until the new source acts */
        const float angle = drive.fast.demand.frame.theta_e + 0.4f + 0.7f * (float)n - turned;
        chosen_lock(&drive.fast.estimator, (position_t){angle_wrap(angle), OMEGA_E},
                    drive.fast.estimator.estimate.amplitude);
        claim();
        params.position_source = POSITION_SENSORLESS;
        offer_params();
        for (uint32_t k = 0; k < 3u * DRIVE_WINDOW; k++) { /* until the new source acts */
            claim();
            steps(1);
        }
        claim();
        preset(3.0f, -4.0f);
        const double complex before = voltage();
        const double from = (double)drive.fast.demand.frame.theta_e;
        step();
        TEST_ASSERT_EQUAL_INT32(FRAME_TURNS, drive.fast.demand.change);
        TEST_ASSERT_TRUE(fabs(circle((double)drive.fast.demand.frame.theta_e - from)) > 0.3);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, cabs(voltage() - before));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 5.0, cabs(made()));
    }
}

/* An encoder at standstill has no EMF, the estimate one of 400 rad/s. The integrals contain the voltage
 * that the encoder's EMF does not explain. In the period in which the EMF of the estimate replaces that of
 * the encoder, the integrals are reduced by the difference. */
static void test_the_observed_emf_takes_the_place_of_the_integral(void)
{
    given_operation(700u);
    chosen_lock(&drive.fast.estimator, (position_t){drive.fast.demand.frame.theta_e, OMEGA_E},
                drive.fast.estimator.estimate.amplitude);
    params.position_source = POSITION_SENSORLESS;
    offer_params();
    for (uint32_t k = 0; k < 4u * DRIVE_WINDOW; k++) {
        claim();
        const double complex before = made();
        const int32_t origin = drive.fast.demand.origin;
        preset(crealf((float complex)before), cimagf((float complex)before));
        steps(1);
        if (origin == (int32_t)EMF_MODEL && drive.fast.demand.origin == (int32_t)EMF_OBSERVED) {
            TEST_ASSERT_TRUE(fabs((double)drive.fast.demand.emf.q) > 30.0);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, cabs(before), cabs(made()));
            return;
        }
    }
    TEST_FAIL_MESSAGE("the source of the EMF has not changed");
}

/* The frame continues, and the integrals remain in it. */
static void test_integrals_go_on_with_the_frame(void)
{
    given_operation(700u);
    preset(3.0f, -4.0f);
    const double complex before = integrals();
    steps(5);
    TEST_ASSERT_EQUAL_INT32(FRAME_GOES_ON, drive.fast.demand.change);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, cabs(integrals() - before));
}

/* An alignment begins after a catch: the integrals of the stationary frame are no longer valid. */
static void test_integrals_are_zero_in_a_new_frame(void)
{
    params.position_source = POSITION_SENSORLESS;
    params.doubtful_current = 0.0f; /* no current is requested in the catch */
    drive_init(&drive, &params);
    bring_to_ready();
    request(REQUEST_ON);
    for (int n = 0; n < 2000 && drive.medium.manoeuvres.now != (int32_t)MANOEUVRE_ALIGN; n++) {
        steps(1);
    }
    TEST_ASSERT_EQUAL_INT32(MANOEUVRE_ALIGN, drive.medium.manoeuvres.now);
    windows(1);
    preset(3.0f, -4.0f);
    steps(1); /* it takes effect in the window after the next */
    TEST_ASSERT_EQUAL_INT32(FRAME_ANEW, drive.fast.demand.change);
    /* The rest is the part of this period: R w T of the current that has risen by then. */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, (0.95 + 0.0215) * 1000.0 * 1e-4 * (double)drive.fast.demand.current.d,
                              cabs(integrals()));
}
