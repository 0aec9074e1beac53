/* The catch with an EMF of known course: e = j omega psi_f exp(j theta). */
#include "fast/reference/catch.h"
#include "tests/unit/scatter.h"
#include "tests/unit/vectors.h"

#define T         1e-4
#define PSI       0.183
#define SPEED_MIN 6.0   /* [rad/s] */
#define WHOLE     200u  /* [periods] longest duration of a catch, 20 ms */
#define LINK      1e4f  /* [V] more than any EMF in this test */
#define EMF       600.0 /* [rad/s] cutoff of the EMF's low-pass in its own frame */
#define SETTLED   40u   /* [periods] 4 ms: the speed is first assumed */
#define SURE      100u  /* [periods] 10 ms: a catch may end */
#define FAST      500.0 /* [rad/s] from this speed on the rotation of the EMF shows the speed after 0.6 ms */
#define EARLY     6u    /* [periods] 0.6 ms; half of it from 1000 rad/s on */

static catch_t catching;
static catch_tuning_t tuning;

void setUp(void)
{
    const catch_params_t params = {.flux_linkage = (float)PSI,
                                   .speed_min = (float)SPEED_MIN,
                                   .doubtful = 0.1f,
                                   .current_d = 2.0f,
                                   .reach = 1.0f,
                                   .period = (float)T};
    tuning = catch_prepare(&params);
    memset(&catching, 0x55, sizeof catching);
    catch_enter(&catching, WHOLE, 0.0f);
}

static double complex emf_of(double omega, double theta)
{
    return J * omega * PSI * cexp(J * theta);
}

static catch_outcome_t step(double complex emf, float voltage_max)
{
    return catch_step(&catching, &tuning, to_ab(emf), (float)cabs(emf), voltage_max);
}

typedef struct {
    catch_outcome_t outcome;
    uint32_t periods;
    double complex emf; /* EMF of the last period */
    double theta;       /* angle of the last period */
} caught_t;

/* Runs a whole catch of a rotor at this speed, with an additional constant error of the voltage. */
static caught_t catch_of(double omega, double theta_start, double complex error)
{
    caught_t caught = {CATCH_GOES_ON, 0u, 0.0, 0.0};
    catch_enter(&catching, WHOLE, 0.0f);
    while (caught.outcome == CATCH_GOES_ON && caught.periods < 2u * WHOLE) {
        caught.theta = theta_start + omega * T * caught.periods;
        caught.emf = emf_of(omega, caught.theta) + error;
        caught.outcome = step(caught.emf, LINK);
        caught.periods++;
    }
    return caught;
}

/* The error of the first speed [rad/s], from the power series of an arc. A sixth of it is left at the end
 * of a catch, and it decreases at 300 rad/s. */
static double error_of_series(double omega)
{
    const double sine = sin(omega * T);
    const double square = sine * sine;
    const double arc = sine * (1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + 5.0 / 112.0 * square)));
    return fabs(omega) > FAST ? fabs(arc / T - omega) : 0.0;
}

/* The low-pass of the EMF begins at zero, which adds an error of -e exp(-(w_c + j omega) t); exp(-3) of it
 * is left after 10 ms. Apart from this error the lag of the low-pass is subtracted exactly. */
static void test_turning_rotor_is_caught_with_speed_direction_and_angle(void)
{
    static const double speeds[] = {8.0, 12.0, 32.0, 100.0, 300.0, 1000.0, 3000.0, 5000.0, 8000.0, 11000.0};
    for (int n = 0; n < 10; n++) {
        for (int way = -1; way <= 1; way += 2) {
            for (double start = -3.0; start < 3.2; start += 0.7) {
                const double omega = way * speeds[n];
                const caught_t caught = catch_of(omega, start, 0.0);
                TEST_ASSERT_EQUAL_INT(CATCH_TURNING, caught.outcome);
                TEST_ASSERT_TRUE(caught.periods <= WHOLE);
                const frame_t rotor = catch_rotor(&catching);
                const double left = error_of_series(omega) / 6.0;
                TEST_ASSERT_DOUBLE_WITHIN(1e-5 + left / 300.0, 0.0,
                                          circle((double)rotor.theta_e - caught.theta));
                TEST_ASSERT_DOUBLE_WITHIN(1e-6 * speeds[n] + left, omega, (double)rotor.omega_e);
            }
        }
    }
}

/* The catch ends after 10 ms if the rotor has turned by at least 1 rad between 4 ms and 10 ms. Otherwise
 * it ends as soon as the rotor has turned by 1 rad since 4 ms, or after 20 ms. */
static void test_fast_rotor_is_caught_before_the_catch_is_over(void)
{
    static const double speeds[] = {2000.0, 500.0, 220.0, 150.0, 100.0, 60.0, 20.0};
    for (int n = 0; n < 7; n++) {
        double turned = 0.0;
        uint32_t expected = 0u;
        while ((turned < 1.0 || expected < 100u) && expected < WHOLE) {
            expected++;
            turned += expected >= 40u ? speeds[n] * T : 0.0;
        }
        TEST_ASSERT_UINT32_WITHIN(1u, expected, catch_of(speeds[n], 0.4, 0.0).periods);
        TEST_ASSERT_UINT32_WITHIN(1u, expected, catch_of(-speeds[n], 0.4, 0.0).periods);
        TEST_ASSERT_EQUAL(n < 3, expected == 100u);
        TEST_ASSERT_EQUAL(n >= 5, expected == WHOLE);
    }
}

/* An observer that begins at zero lacks exp(-t/0.4 ms) of the EMF: 0.7 % after 2 ms, and later less than a
 * catch can measure. At first the loop explains a part of this lack by an error of psi_f, which it
 * corrects later. A fast rotor is caught after 10 ms, a slow one after 20 ms. */
static void test_a_settling_observer_does_not_reduce_the_speed(void)
{
    static const double speeds[] = {500.0, 20.0};
    for (int n = 0; n < 2; n++) {
        for (int way = -1; way <= 1; way += 2) {
            const double omega = way * speeds[n];
            catch_outcome_t outcome = CATCH_GOES_ON;
            uint32_t k = 0u;
            catch_enter(&catching, WHOLE, 0.0f);
            for (; outcome == CATCH_GOES_ON && k < 2u * WHOLE; k++) {
                outcome = step(emf_of(omega, omega * T * k) * (1.0 - exp(-T * k / 0.4e-3)), LINK);
            }
            TEST_ASSERT_EQUAL_INT(CATCH_TURNING, outcome);
            TEST_ASSERT_EQUAL_UINT32(n == 0 ? WHOLE / 2u : WHOLE, k);
            TEST_ASSERT_DOUBLE_WITHIN(n == 0 ? 1.5e-3 * 500.0 : 1e-4 * 20.0, omega, (double)catching.omega_e);
        }
    }
}

/* The error of the speed [rad/s] that the slip leaves if the length of the EMF is wrong by `share`. phi is
 * the phase between the EMF and the frame, d the error of the frame's speed. In continuous time, from
 * where the speed is first assumed: phi' = d - w_c phi, d' = -q^2 sin phi, q = min(speed - 80, 430 rad/s)
 * or 0, w_c = 600 rad/s. */
static double left_of(double omega, double share, double seconds)
{
    const double natural = fmin(fmax(fabs(share * omega) - 80.0, 0.0), 430.0);
    const double step = 1e-6;
    double phi = 0.0;
    double missing = omega * (1.0 - share);
    for (double t = 0.0; t < seconds; t += step) {
        phi += step * (missing - EMF * phi);
        missing -= step * natural * natural * sin(phi);
    }
    return missing;
}

/* The psi_f of the motor is a third larger than configured, or a fifth smaller. If a rotor seems fast, the
 * slip is known before the loop begins. */
static void test_speed_becomes_that_of_the_turning_whatever_psi_f(void)
{
    static const double speeds[] = {50.0, 200.0, 531.0, 1000.0};
    static const double shares[] = {1.0 / 0.75, 1.0 / 1.25};
    for (int n = 0; n < 16; n++) {
        const double omega = n % 2 == 0 ? speeds[n / 4] : -speeds[n / 4];
        const double share = shares[n / 2 % 2];
        catch_enter(&catching, WHOLE, 0.0f);
        for (uint32_t k = 1u; k <= SURE; k++) {
            (void)step(share * emf_of(omega, omega * T * k), LINK);
            if (k >= SETTLED) {
                const bool known = share * fabs(omega) >= FAST;
                const double left = known ? 0.0 : left_of(omega, share, T * (k - SETTLED));
                TEST_ASSERT_DOUBLE_WITHIN(0.03 * fabs((1.0 - share) * omega), omega - left,
                                          (double)catching.omega_e);
            }
        }
    }
}

/* The error of the dead time has a constant direction and does not rotate. */
static void test_a_constant_voltage_error_is_not_a_rotor(void)
{
    for (double length = 0.5; length < 200.0; length *= 1.7) {
        for (double angle = -3.1; angle < 3.2; angle += 0.4) {
            const double complex error = length * PSI * SPEED_MIN * cexp(J * angle);
            const caught_t caught = catch_of(0.0, 0.0, error);
            TEST_ASSERT_EQUAL_INT(CATCH_STANDING, caught.outcome);
            TEST_ASSERT_EQUAL_UINT32(WHOLE, caught.periods);
        }
    }
}

/* A rotor with 0.3 of the EMF of the slowest accepted rotor, plus a voltage of twice this EMF that rotates
 * by 0.4 rad per period, faster than any rotor. The sum has the length of the EMF of a fast enough rotor,
 * and a direction. */
static void test_ripple_as_long_as_an_emf_is_no_rotor(void)
{
    catch_outcome_t outcome = CATCH_GOES_ON;
    for (uint32_t n = 0; outcome == CATCH_GOES_ON && n < 2u * WHOLE; n++) {
        const double omega = 0.3 * SPEED_MIN;
        const double complex ripple = 2.0 * PSI * SPEED_MIN * cexp(J * 0.4 * n);
        outcome = step(emf_of(omega, omega * T * n) + ripple, LINK);
    }
    TEST_ASSERT_EQUAL_INT(CATCH_STANDING, outcome);
}

/* A rotor at ten times the least speed, with noise on both axes of its EMF. Its length is that of a rotor at
 * five times this speed if the standard deviation of the noise is four times the EMF. With a quarter of the
 * EMF it remains a rotor: the low-pass leaves a fifth of the noise, and the length grows by 3 %. */
static void test_noise_longer_than_the_emf_is_no_rotor(void)
{
    static const double sizes[] = {0.25, 4.0}; /* [-] standard deviation of the noise over the EMF */
    static const catch_outcome_t outcomes[] = {CATCH_TURNING, CATCH_STANDING};
    const double omega = 10.0 * SPEED_MIN;
    for (size_t size = 0; size < 2u; size++) {
        for (unsigned draw = 0; draw < 100u; draw++) {
            catch_outcome_t outcome = CATCH_GOES_ON;
            catch_enter(&catching, WHOLE, 0.0f);
            for (uint32_t n = 0; outcome == CATCH_GOES_ON; n++) {
                const double deviation = sizes[size] * PSI * omega;
                const double complex error = deviation * (scatter_gauss() + J * scatter_gauss());
                outcome = step(emf_of(omega, omega * T * n) + error, LINK);
            }
            TEST_ASSERT_EQUAL_INT(outcomes[size], outcome);
        }
    }
}

static void test_rotor_slower_than_the_least_speed_counts_as_at_standstill(void)
{
    for (int way = -1; way <= 1; way += 2) {
        TEST_ASSERT_EQUAL_INT(CATCH_STANDING, catch_of(way * 0.0, 1.0, 0.0).outcome);
        TEST_ASSERT_EQUAL_INT(CATCH_STANDING, catch_of(way * 0.99999 * SPEED_MIN, 1.0, 0.0).outcome);
        TEST_ASSERT_EQUAL_INT(CATCH_TURNING, catch_of(way * 1.00001 * SPEED_MIN, 1.0, 0.0).outcome);
    }
}

/* The EMF must be beyond the link for 1 ms without interruption, ten periods. If field weakening is on, a
 * longer EMF is accepted. */
static void test_emf_beyond_the_link_is_reported_within_a_millisecond(void)
{
    const double omega = 1000.0;
    const float below = (float)(0.999 * omega * PSI);
    const float above = (float)(1.001 * omega * PSI);
    for (int m = 0; m < 2; m++) {
        tuning.reach = m == 0 ? 1.0f : 1.5f;
        catch_enter(&catching, WHOLE, 0.0f);
        for (int n = 1; n < 10; n++) {
            TEST_ASSERT_EQUAL_INT(CATCH_GOES_ON, step(emf_of(omega, omega * T * n), below / tuning.reach));
        }
        TEST_ASSERT_EQUAL_INT(CATCH_TOO_FAST, step(emf_of(omega, omega * T * 10), below / tuning.reach));
    }
    tuning.reach = 1.0f;
    catch_enter(&catching, WHOLE, 0.0f);
    for (int n = 1; n < 100; n++) {
        const float link = n % 10 == 0 ? above : below;
        TEST_ASSERT_EQUAL_INT(CATCH_GOES_ON, step(emf_of(omega, omega * T * n), link));
    }
}

/* Up to 4 ms the reported speed is that of the start; then it is that of the EMF, within 3e-6 rad of its
 * rotation per period, with its sign. The speed of a fast rotor is known from 0.6 ms on, for any psi_f,
 * and from 0.3 ms on if its EMF is as long as that of 1000 rad/s. An
 * observer that assumes the speed zero rotates the EMF and changes its length by a constant factor, in
 * this test 1.2 exp(-0.6 j); this must have no effect. */
static void test_speed_is_that_of_the_start_until_it_is_seen(void)
{
    static const struct {
        double omega;
        double complex lag;
        uint32_t seen;
    } rotors[] = {{300.0, 1.0, SETTLED},
                  {600.0, 1.0, EARLY},
                  {600.0, 1.2 * cexp(-0.6 * J), EARLY},
                  {3000.0, 0.7, EARLY / 2u},
                  {1400.0, 0.7, EARLY}};
    for (int n = 0; n < 10; n++) {
        const double omega = n % 2 == 0 ? rotors[n / 2].omega : -rotors[n / 2].omega;
        catch_enter(&catching, WHOLE, 77.0f);
        for (uint32_t k = 1u; k < 90u; k++) {
            (void)step(rotors[n / 2].lag * emf_of(omega, omega * T * k), LINK);
            TEST_ASSERT_DOUBLE_WITHIN(0.03, k < rotors[n / 2].seen ? 77.0 : omega, (double)catching.omega_e);
        }
    }
}

/* The voltage acts on [t_k+1, t_k+2), on average a period and a half later. */
static void test_voltage_is_the_emf_when_it_acts(void)
{
    static const double speeds[] = {0.0, 30.0, -400.0, 1500.0, -5000.0, 5000.0};
    for (int n = 0; n < 6; n++) {
        catch_enter(&catching, WHOLE, (float)speeds[n]);
        const double complex emf = emf_of(speeds[n], 0.8);
        const ab_t voltage = catch_voltage(&catching, &tuning, to_ab(emf));
        const double complex expected = emf * cexp(J * 1.5 * T * speeds[n]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * (1.0 + cabs(emf)), creal(expected), (double)voltage.alpha);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * (1.0 + cabs(emf)), cimag(expected), (double)voltage.beta);
    }
}

/* Within the first 4 ms no axis is known. Up to 10 ms it is the rotor's d axis, in which a current makes
 * no torque. */
static void test_current_is_along_phase_a_until_a_rotor_is_seen_and_along_its_d_axis_then(void)
{
    static const double speeds[] = {42.0, 100.0, 628.0};
    for (int n = 0; n < 3; n++) {
        for (int way = -1; way <= 1; way += 2) {
            catch_enter(&catching, WHOLE, 0.0f);
            for (uint32_t k = 1u; k < 150u; k++) {
                const double theta = 0.4 + way * speeds[n] * T * k;
                (void)step(emf_of(way * speeds[n], theta), LINK);
                const double complex current = of_ab(catch_current(&catching, &tuning));
                if (k < SETTLED) {
                    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, cabs(current - 0.3));
                } else if (k >= SURE) {
                    const double complex expected = 2.0 * cexp(J * theta);
                    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, cabs(current - expected));
                }
            }
        }
    }
}

/* If the parameter of the current along the d axis is smaller than the zone of the dead time needs on this
 * board, the current is the one that clears the zone. */
static void test_current_along_the_d_axis_is_never_the_smaller_one(void)
{
    const catch_params_t params = {(float)PSI, (float)SPEED_MIN, 0.1f, 0.0f, false, 1.0f, (float)T};
    tuning = catch_prepare(&params);
    TEST_ASSERT_EQUAL_FLOAT(tuning.current, tuning.current_d);
}

static void test_angle_is_a_quarter_turn_beside_the_emf(void)
{
    for (int way = -1; way <= 1; way += 2) {
        for (double theta = -3.14; theta < 3.15; theta += 0.01) {
            const float angle = catch_angle(to_ab(emf_of(way * 50.0, theta)), (float)way);
            TEST_ASSERT_DOUBLE_WITHIN(5e-6, 0.0, circle((double)angle - theta));
        }
    }
    TEST_ASSERT_EQUAL_FLOAT(0.0f, catch_angle((ab_t){0.0f, 0.0f}, 1.0f));
}
