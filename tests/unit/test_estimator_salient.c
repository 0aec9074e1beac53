/* The estimator with exact data of salient rotors (salient_oracle.h) that turn at a constant speed. The
 * current is held in the frame of the estimator, as a drive does it. The expected results are as follows. The
 * active flux leaves no error. Wrong data leave the error that a closed formula gives. A step of the current
 * leaves no error, because its transient is known.
 *
 * Motors of the family F(s): p 4, R 0.95 ohm, L_q 20 mH, L_d = L_q/s, psi_f 0.1 Wb, 10 A. The tracking
 * loop follows the rule for J 0.01 kg m^2 and 800 rad/s. */
#include "math/frames.h"
#include "tests/oracle/salient_oracle.h"
#include "tests/unit/estimator_bench.h"
#include "tests/unit/vectors.h"

#define L_Q         0.02
#define R           0.95
#define FLUX        0.1
#define CURRENT     10.0
#define OMEGA_TOP   (4800.0 * RAD_PER_RPM)
#define OMEGA_RATED (2400.0 * RAD_PER_RPM)
#define GAIN_TOP    (1.75 * 0.3) /* [Wb] k_s: the largest active flux of s = 4 at 15 A */

/* The parameters of the estimator divided by those of the motor. */
typedef struct {
    double inductance_d, inductance_q, resistance, flux_linkage;
} assumption_t;

static const assumption_t RIGHT = {1.0, 1.0, 1.0, 1.0};

static salient_oracle_case_t rotor;
static double theta;         /* [rad] angle of the magnet at t_k */
static double complex flows; /* [A] current at t_k in the stationary frame */
static double noise;         /* SD of a measured current [A] */
/* The known transient is subtracted from the voltage, as if the observer did not add it. */
static bool transient_lost;
static uint32_t dice;

static double complex pair_of(const double value[2])
{
    return value[0] + J * value[1];
}

/* The i_d at most torque per ampere, with a current of this length. */
static double most_torque(double saliency, double current)
{
    const double taken = saliency * current;
    return -2.0 * taken * current / (FLUX + sqrt(FLUX * FLUX + 8.0 * taken * taken));
}

/* A normally distributed number with SD 1: the sum of twelve numbers between 0 and 1, minus 6. */
static double normal(void)
{
    double sum = -6.0;
    for (int n = 0; n < 12; n++) {
        dice = dice * 1664525u + 1013904223u;
        sum += (double)dice / 4294967296.0;
    }
    return sum;
}

static void given(double ratio, double omega, const assumption_t *assumption)
{
    rotor = (salient_oracle_case_t){R, L_Q / ratio, L_Q, FLUX, T, omega};
    theta = 0.3;
    flows = 0.0;
    noise = 0.0;
    transient_lost = false;
    const double inductance = assumption->inductance_q * L_Q;
    estimator_params_t params = {.smo = {.resistance = (float)(assumption->resistance * R),
                                         .inductance = (float)inductance,
                                         .gain = (float)(GAIN_TOP * OMEGA_TOP),
                                         .slope = (float)(1.6 * inductance / (GAIN_TOP * OMEGA_TOP * T)),
                                         .emf_cutoff = 2500.0f,
                                         .period = (float)T,
                                         .switching = SMO_SIGMOID_VECTOR},
                                 .lag = LAG_EXACT,
                                 .pll = {.amplitude_floor = (float)(11.0 * FLUX)},
                                 .flux_linkage = (float)(assumption->flux_linkage * FLUX),
                                 .saliency =
                                     (float)(inductance - assumption->inductance_d * rotor.inductance_d)};
    tune(&params, 313.0, 31.0);
    init(&params);
}

/* Simulates a period with this current in the frame of the estimator [A]; returns the error of the angle
 * [mrad]. */
static double period(double i_d, double i_q)
{
    const double before[2] = {creal(flows), cimag(flows)};
    const double complex next = (i_d + J * i_q) * cexp(J * (double)est.tracker.pll.theta_e);
    const double now[2] = {creal(next), cimag(next)};
    double voltage[2];
    salient_oracle_voltage(&rotor, theta, before, now, voltage);
    const double complex step = next * cexp(-J * (double)est.tracker.pll.theta_e) -
                                flows * cexp(-J * ((double)est.tracker.pll.theta_e - rotor.omega * T));
    flows = next;
    theta += rotor.omega * T;
    if (transient_lost) {
        const double complex known =
            (L_Q - rotor.inductance_d) / T * creal(step) * cexp(J * (theta - 0.5 * rotor.omega * T));
        voltage[0] -= creal(known);
        voltage[1] -= cimag(known);
    }
    const double seen[2] = {now[0] + noise * normal(), now[1] + noise * normal()};
    const position_t position = estimator_step(&est, as_float(voltage), as_float(seen));
    return 1e3 * circle((double)position.theta_e - theta);
}

/* Locks the estimator to the rotor, with this current in its frame. */
static void locked(double i_d, double i_q)
{
    flows = (i_d + J * i_q) * cexp(J * theta);
    const double now[2] = {creal(flows), cimag(flows)};
    estimator_reset(&est, (position_t){(float)circle(theta), (float)rotor.omega}, as_float(now));
}

static deviation_t held(double i_d, double i_q, int settle, int count)
{
    deviation_t d = {0.0, 0.0, 0.0, 0.0};
    double squares = 0.0;
    for (int n = 0; n < settle + count; n++) {
        const double error = period(i_d, i_q);
        if (n >= settle) {
            d.mean += error;
            squares += error * error;
            d.peak = fmax(d.peak, fabs(error));
        }
    }
    d.mean /= (double)count;
    d.sd = sqrt(fmax(0.0, squares / (double)count - d.mean * d.mean));
    return d;
}

static const double RATIOS[] = {1.0, 1.5, 2.0, 3.0, 4.0};
#define RATIO_COUNT 5

/* The data are right. The currents go from zero to 1.5 times the rated one, the speeds from 2 to 100 %.
 * Only two errors remain: the ripple of i_d between the samples leaves (R T/L_q)(D/L_d) x/12, where x =
 * omega T is the angle of a period; the other is float arithmetic. Braking is tested from 4 % of the speed
 * on; below that the motion of the loop itself moves the flux faster than the loop can follow. */
static void test_right_data_leave_no_error_whatever_the_saliency(void)
{
    static const double shares[] = {0.02, 0.04, 0.1, 0.5, 1.0};
    for (int n = 0; n < RATIO_COUNT; n++) {
        for (int m = 0; m < 5; m++) {
            for (int load = m == 0 ? 0 : -3; load <= 3; load++) {
                given(RATIOS[n], shares[m] * OMEGA_RATED, &RIGHT);
                const double current = 0.5 * fabs((double)load) * CURRENT;
                const double i_d = most_torque(L_Q - rotor.inductance_d, current);
                const double size = sqrt(current * current - i_d * i_d);
                const double i_q = load < 0 ? -size : size;
                locked(i_d, i_q);
                const deviation_t d = held(i_d, i_q, 2000, 1000);
                const double ripple =
                    1e3 * R * T / L_Q * (L_Q / rotor.inductance_d - 1.0) * rotor.omega * T / 12.0;
                check_below(fabs(d.mean), 1.2 * ripple + FLOAT_PEAK, "mean");
                check_line(fabs(d.mean), 0.3, "A1 mean");
                check_line(d.sd, 0.1, "A1 SD");
            }
        }
    }
}

/* The sensors have noise, and the whole rated current flows in either direction (line A4 of
 * docs/salient.md). The observer makes an EMF of L_q/T times the change of the noise, and the loop
 * integrates it with kp. The filter of the EMF, a = exp(-2500 rad/s T), leaves (1 - a)/(1 + a) of its
 * variance. So SD = kp L_q noise sqrt((1 - a)/(1 + a))/(psi_a omega), which is 3.0 mrad at L_q = L_d and 5
 * % of the speed, above the limit of the line. A salient rotor has less, because its flux moves with the
 * angle. */
static void test_noise_moves_the_angle_little_with_all_of_the_current(void)
{
    static const double shares[] = {0.05, 0.1, 0.5, 1.0, 2.0, 100.0 / 2400.0};
    const double passes = tanh(0.5 * 2500.0 * T);
    for (int n = 0; n < 2 * RATIO_COUNT; n++) {
        const bool brakes = n % 2 == 1;
        for (int m = 0; m < (brakes ? 6 : 5); m++) {
            given(RATIOS[n / 2], shares[m] * OMEGA_RATED, &RIGHT);
            noise = 0.01;
            const double i_d = most_torque(L_Q - rotor.inductance_d, CURRENT);
            const double i_q = sqrt(CURRENT * CURRENT - i_d * i_d);
            const double active = FLUX - (L_Q - rotor.inductance_d) * i_d;
            const double law =
                1e3 * (double)est.tracker.pll.tuning.kp * L_Q * noise * sqrt(passes) / (active * rotor.omega);
            locked(i_d, brakes ? -i_q : i_q);
            const deviation_t d = held(i_d, brakes ? -i_q : i_q, 3000, 7000);
            const double limit = m < 5 ? 1.5 : 3.0;
            check_line(d.sd, n < 2 ? fmax(limit, 1.2 * law) : limit,
                       n < 2   ? "A4 SD, L_q = L_d"
                       : m < 5 ? "A4 SD"
                               : "A4 SD braking at 100 r/min");
            check_below(fabs(d.mean), 1.0, "mean");
        }
    }
}

/* The steady angle error with wrong data and this current in the frame of the loop: psi_a(err) sin(err) =
 * -dL_q i_q + dR i_d/omega, psi_a(err) = psi_f - D (i_d cos err - i_q sin err) */
static double by_law(const assumption_t *assumption, double i_d, double i_q)
{
    const double saliency = rotor.inductance_q - rotor.inductance_d;
    const double pulls = -(assumption->inductance_q - 1.0) * L_Q * i_q +
                         (assumption->resistance - 1.0) * R * i_d / rotor.omega;
    double error = 0.0;
    for (int n = 0; n < 200; n++) {
        const double active = FLUX - saliency * (i_d * cos(error) - i_q * sin(error));
        error += 0.5 * (asin(fmax(-1.0, fmin(1.0, pulls / active))) - error);
    }
    return 1e3 * error;
}

static void test_wrong_data_leave_the_error_of_the_law(void)
{
    static const assumption_t assumptions[] = {
        {1.0, 1.2, 1.0, 1.0}, {1.0, 0.8, 1.0, 1.0}, {1.0, 1.0, 1.3, 1.0}, {1.0, 1.0, 0.7, 1.0},
        {1.2, 1.0, 1.0, 1.0}, {0.8, 1.0, 1.0, 1.0}, {1.0, 1.0, 1.0, 1.1}, {1.0, 1.0, 1.0, 0.9}};
    static const double speeds[] = {240.0, 1200.0};
    for (int n = 1; n < RATIO_COUNT; n++) {
        for (int m = 0; m < 8; m++) {
            for (int k = 0; k < 4; k++) {
                given(RATIOS[n], speeds[k / 2] * RAD_PER_RPM, &assumptions[m]);
                const double i_d = most_torque(L_Q - rotor.inductance_d, CURRENT);
                const double i_q = (k % 2 == 0 ? 1.0 : -1.0) * sqrt(CURRENT * CURRENT - i_d * i_d);
                locked(i_d, i_q);
                const deviation_t d = held(i_d, i_q, 6000, 1000);
                const double law = by_law(&assumptions[m], i_d, i_q);
                if (m < 4) {
                    check_line(fabs(d.mean - law), 3.0, "A3 beside the law");
                } else {
                    check_line(fabs(d.mean), 0.5, "A3 mean with wrong L_d or psi_f");
                }
                check_below(d.sd, 1.0, "scatter");
            }
        }
    }
}

/* The drive has the current of most torque per ampere for the L_q that it assumes, at half and all of the
 * base speed, 1385 r/min (line A5). */
static void test_an_inductance_a_fifth_wrong_loses_no_rotor(void)
{
    for (int n = 0; n < 24; n++) {
        const assumption_t assumption = {1.0, n % 2 == 0 ? 0.8 : 1.2, 1.0, 1.0};
        const double way = n / 2 % 2 == 0 ? 1.0 : -1.0;
        given(RATIOS[2 + n / 8], (n / 4 % 2 == 0 ? 0.5 : 1.0) * 1385.0 * RAD_PER_RPM, &assumption);
        const double i_d = most_torque(assumption.inductance_q * L_Q - rotor.inductance_d, CURRENT);
        const double i_q = way * sqrt(CURRENT * CURRENT - i_d * i_d);
        locked(i_d, i_q);
        const deviation_t d = held(i_d, i_q, 8000, 2000);
        check_line(fabs(d.mean - by_law(&assumption, i_d, i_q)), 5.0, "A5 beside the law");
        check_line(d.sd, 5.0, "A5 SD");
    }
}

/* The whole torque is switched on within one sample, and off again: the flux of i_d is known and must not
 * be taken for an EMF. */
static void test_a_step_of_torque_is_no_error(void)
{
    static const double speeds[] = {240.0, 1200.0, 2400.0};
    for (int n = 1; n < RATIO_COUNT; n++) {
        for (int m = 0; m < 3; m++) {
            given(RATIOS[n], speeds[m] * RAD_PER_RPM, &RIGHT);
            const double i_d = most_torque(L_Q - rotor.inductance_d, CURRENT);
            const double i_q = sqrt(CURRENT * CURRENT - i_d * i_d);
            locked(0.0, 0.0);
            (void)held(0.0, 0.0, 500, 0);
            check_line(held(i_d, i_q, 0, 1000).peak, 9.0, "A6 peak");
            check_line(held(0.0, 0.0, 0, 1000).peak, 9.0, "A6 peak");
            if (n >= 2 && m == 0) {
                locked(0.0, 0.0);
                (void)held(0.0, 0.0, 500, 0);
                transient_lost = true;
                check_line(-held(i_d, i_q, 0, 1000).peak, -43.0, "A6 without the known transient");
            }
        }
    }
}

/* While the loop is not in use, the observer uses L_d for any direction of the magnet. With a current that
 * pulses along the magnet, the EMF must be that of the magnet alone, psi_f omega. */
static void test_at_rest_the_observer_goes_by_l_d(void)
{
    given(3.0, 100.0, &RIGHT);
    locked(0.0, 0.0);
    for (int n = 0; n < 400; n++) {
        const double before[2] = {creal(flows), cimag(flows)};
        theta += rotor.omega * T;
        flows = (n % 20 < 10 ? 2.0 : -2.0) * cexp(J * theta);
        const double now[2] = {creal(flows), cimag(flows)};
        double voltage[2];
        salient_oracle_voltage(&rotor, theta - rotor.omega * T, before, now, voltage);
        estimator_observe(&est, as_float(voltage), as_float(now), (float)rotor.omega);
        if (n > 20 && n % 10 >= 4) { /* the filter has settled for this sample */
            const double emf[2] = {(double)est.estimate.emf.alpha, (double)est.estimate.emf.beta};
            const double complex in_rotor = pair_of(emf) * cexp(-J * theta);
            TEST_ASSERT_DOUBLE_WITHIN(0.05 * FLUX * rotor.omega, FLUX * rotor.omega, cimag(in_rotor));
            TEST_ASSERT_DOUBLE_WITHIN(0.05 * FLUX * rotor.omega, 0.0, creal(in_rotor));
        }
    }
}

/* A loop that is locked while i_d flows has the EMF psi_a omega instead of psi_f omega. Its feed-forward
 * must begin with psi_a. Otherwise a third or a half of the speed would move from I to F within 1/omega_c;
 * the angle error would be omega_c psi_a/psi_f omega/ki, at least 0.4 rad for these motors. */
static void test_lock_from_rest_begins_with_the_active_flux(void)
{
    static const double currents[] = {-3.0, 2.0};
    for (int n = 2; n < RATIO_COUNT; n++) {
        for (int m = 0; m < 4; m++) {
            const double i_d = currents[m % 2];
            given(RATIOS[n], (m < 2 ? 1.0 : -1.0) * 1200.0, &RIGHT);
            locked(0.0, 0.0);
            for (int k = 0; k < 100; k++) {
                const double before[2] = {creal(flows), cimag(flows)};
                double voltage[2];
                flows = i_d * cexp(J * (theta + rotor.omega * T));
                const double now[2] = {creal(flows), cimag(flows)};
                salient_oracle_voltage(&rotor, theta, before, now, voltage);
                theta += rotor.omega * T;
                estimator_observe(&est, as_float(voltage), as_float(now), (float)rotor.omega);
            }
            estimator_lock(&est, (position_t){(float)circle(theta), (float)rotor.omega},
                           est.estimate.amplitude);
            check_below(held(i_d, 0.0, 0, 2000).peak, 30.0, "peak after the lock");
        }
    }
}

/* No sample may lead to a state that is not a number. */
static void test_invalid_samples_do_not_change_the_flux(void)
{
    given(3.0, 500.0, &RIGHT);
    locked(-2.0, 3.0);
    (void)held(-2.0, 3.0, 100, 0);
    const float flux_before = est.tracker.motor.flux;
    static const ab_t none[] = {{NAN, 0.0f}, {0.0f, INFINITY}, {-INFINITY, 1.0f}, {3e38f, -3e38f}};
    for (int n = 0; n < 4; n++) {
        (void)estimator_step(&est, (ab_t){1.0f, 2.0f}, none[n]);
        TEST_ASSERT_EQUAL_FLOAT(flux_before, est.tracker.motor.flux);
        (void)estimator_step(&est, none[n], (ab_t){1.0f, 2.0f});
        TEST_ASSERT_EQUAL_FLOAT(flux_before, est.tracker.motor.flux);
        TEST_ASSERT_TRUE(isfinite(est.tracker.pll.theta_e) && isfinite(est.tracker.motor.speed_per_volt));
    }
}
