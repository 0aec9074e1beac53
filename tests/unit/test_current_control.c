/* Closed loop with an exact winding in double precision: i(k+1) = a i(k) + b u(k), a = exp(-R T/L), b = (1
 * - a)/R, where u(k) is the voltage that the controller has computed at k-1 (it acts from t_k+1 to t_k+2). */
#include "fast/control/current_control.h"
#include "tests/unit/vectors.h"

static const current_control_params_t PARAMS = {.resistance = 0.95f,
                                                .inductance_d = 0.0125f,
                                                .inductance_q = 0.0125f,
                                                .bandwidth = 1000.0f,
                                                .period = 1e-4f};

static const dq_t NONE = {0.0f, 0.0f};

static void begin(current_control_t *control, const current_control_params_t *params)
{
    const current_control_tuning_t tuning = current_control_prepare(params);
    current_control_init(control, &tuning);
}

static void test_feed_forward_is_the_motor_equation_and_the_given_emf(void)
{
    current_control_params_t params = PARAMS;
    params.inductance_d = 0.008f;
    params.inductance_q = 0.016f;
    current_control_t control;
    begin(&control, &params);
    dq_t current = {-3.0f, 7.0f};
    for (int direction = -1; direction <= 1; direction++) {
        double omega = 628.0 * direction;
        dq_t emf = {-20.5f, (float)(omega * 0.183)};
        dq_t voltage = current_control_step(&control, current, current, (float)(omega * 1e-4), emf);
        /* The limit is five roundings of numbers up to 115 V. */
        TEST_ASSERT_DOUBLE_WITHIN(4e-5, -omega * 0.016 * 7.0 - 20.5, (double)voltage.d);
        TEST_ASSERT_DOUBLE_WITHIN(4e-5, omega * (0.008 * -3.0 + 0.183), (double)voltage.q);
    }
}

static void test_axes_are_back_calculated_each_with_its_own_shortfall(void)
{
    current_control_t control;
    begin(&control, &PARAMS);
    dq_t reference = {10.0f, -10.0f};
    dq_t current = {0.0f, 0.0f};
    current_control_step(&control, reference, current, 0.0f, NONE);
    /* The controller requested (125, -125) and got (100, -25): errors of 8 and -2 would have given these
     * voltages, of which ki T = 0.095 is integrated. */
    dq_t applied = {100.0f, -25.0f};
    current_control_applied(&control, applied);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.095 * 8.0, (double)control.d.integral);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.095 * -2.0, (double)control.q.integral);
}

/* While an EMF rises by S [V/s] without a feed-forward, the integral rises by S as well, so that the current
 * differs from its reference by S/ki. ki is R w_b = 950, or as `held` demands, up to L w_b^2/4 = 3125. */
static void test_the_integral_of_the_q_axis_follows_a_rising_emf(void)
{
    static const double cases[][2] = {{0.0, 950.0}, {900.0, 950.0}, {2000.0, 2000.0}, {1e6, 3125.0}};
    const double slope = 1000.0;
    const double a = exp(-0.95 * 1e-4 / 0.0125);
    for (unsigned n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        current_control_params_t params = PARAMS;
        params.held = (float)cases[n][0];
        current_control_t control;
        begin(&control, &params);
        double current = 0.0;
        double acting = 0.0;
        for (int k = 0; k < 2000; k++) {
            const dq_t measured = {0.0f, (float)current};
            const dq_t wanted = current_control_step(&control, NONE, measured, 0.0f, NONE);
            current_control_applied(&control, wanted);
            current = a * current + (1.0 - a) / 0.95 * (acting - slope * 1e-4 * (k + 0.5));
            acting = (double)wanted.q;
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * slope / cases[n][1], -slope / cases[n][1], current);
    }
}

/* The voltage in the stationary frame for a reference, a current and an EMF that are given in the
 * stationary frame, computed in a frame at `theta`. The winding is isotropic: except for the integrals the
 * control is the same in any frame. */
static double complex stationary_voltage(current_control_t *control, double theta)
{
    const double complex back = cexp(-J * theta);
    const dq_t voltage =
        current_control_step(control, to_dq((4.0 - 3.0 * J) * back), to_dq((3.5 + 1.0 * J) * back), 0.025f,
                             to_dq((20.0 + 30.0 * J) * back));
    return of_dq(voltage) * cexp(J * theta);
}

/* The two frames differ widely, as those of two sources of the angle may. */
static void test_voltage_does_not_jump_when_the_frame_does(void)
{
    static const double turns[] = {0.0, 0.3, -1.7, 3.1, -3.1};
    for (unsigned n = 0; n < sizeof turns / sizeof turns[0]; n++) {
        for (double theta = -3.0; theta < 3.1; theta += 1.0) {
            current_control_t control;
            begin(&control, &PARAMS);
            const dq_t integral = {-7.5f, 14.25f};
            current_control_reset(&control, integral);
            const double complex before = stationary_voltage(&control, theta);
            const rotation_t turn = {(float)sin(turns[n]), (float)cos(turns[n])};
            current_control_turn(&control, turn);
            /* Calculated by hand: the integral is rotated by -turn; the limit is three roundings of
             * products of 14 V. */
            const double complex turned = of_dq(integral) * cexp(-J * turns[n]);
            TEST_ASSERT_DOUBLE_WITHIN(3e-6, creal(turned), (double)control.d.integral);
            TEST_ASSERT_DOUBLE_WITHIN(3e-6, cimag(turned), (double)control.q.integral);
            /* The limit is ten roundings of numbers up to 60 V on either side. */
            const double complex after = stationary_voltage(&control, theta + turns[n]);
            TEST_ASSERT_DOUBLE_WITHIN(4e-5, 0.0, cabs(after - before));
        }
    }
}

enum { RUN = 1500 }; /* four of them fit into the 64 K of a target with a 32-bit double */

typedef struct {
    double current[RUN];  /* current at t_k */
    double integral[RUN]; /* integral before step k */
} run_t;

/* Runs one axis at standstill: the reference steps to `reference` at k = 0, and the voltage is limited to
 * `limit`. */
static void run_axis(run_t *run, const current_control_params_t *params, int axis, double reference,
                     double limit)
{
    double resistance = (double)params->resistance;
    double inductance = (double)(axis == 0 ? params->inductance_d : params->inductance_q);
    double a = exp(-resistance * (double)params->period / inductance);
    double b = (1.0 - a) / resistance;
    double current = 0.0;
    double acting = 0.0;
    current_control_t control;
    begin(&control, params);
    for (int k = 0; k < RUN; k++) {
        run->current[k] = current;
        run->integral[k] = (double)(axis == 0 ? control.d.integral : control.q.integral);
        dq_t reference_dq = {0.0f, 0.0f};
        dq_t current_dq = {0.0f, 0.0f};
        *(axis == 0 ? &reference_dq.d : &reference_dq.q) = (float)reference;
        *(axis == 0 ? &current_dq.d : &current_dq.q) = (float)current;
        dq_t wanted = current_control_step(&control, reference_dq, current_dq, 0.0f, NONE);
        dq_t applied = wanted;
        float *cut = axis == 0 ? &applied.d : &applied.q;
        *cut = (float)fmax(-limit, fmin(limit, (double)*cut));
        current_control_applied(&control, applied);

        current = a * current + b * acting;
        acting = (double)*cut;
    }
}

/* If the controller cancels the pole of the winding, the loop is y(k+2) = y(k+1) + K (1 - y(k)) with K =
 * kp b. */
static void algebra(double *response, double gain)
{
    response[0] = 0.0;
    response[1] = 0.0;
    for (int k = 2; k < RUN; k++) {
        response[k] = response[k - 1] + gain * (1.0 - response[k - 2]);
    }
}

static double gain_of(const current_control_params_t *params, double inductance)
{
    double resistance = (double)params->resistance;
    double a = exp(-resistance * (double)params->period / inductance);
    return inductance * (double)params->bandwidth * (1.0 - a) / resistance;
}

static void test_step_response_is_the_algebraic_one_on_both_axes(void)
{
    static run_t run;
    static double expected[RUN];
    static const float bandwidths[] = {500.0f, 1000.0f, 2500.0f, 5000.0f};
    for (unsigned n = 0; n < sizeof bandwidths / sizeof bandwidths[0]; n++) {
        current_control_params_t params = PARAMS;
        params.inductance_d = 0.008f;
        params.inductance_q = 0.016f;
        params.bandwidth = bandwidths[n];
        for (int axis = 0; axis < 2; axis++) {
            double inductance = axis == 0 ? 0.008 : 0.016;
            double gain = gain_of(&params, inductance);
            algebra(expected, gain);
            run_axis(&run, &params, axis, -10.0, 1e6);
            /* The zero of the controller is at 1 - x with x = R T/L, and the pole a of the winding at
             * exp(-x). The open loop therefore has an additional factor 1 + (x^2/2)/(z - a). It changes
             * the response by at most the 1-norm of the closed loop times x^2/2 times the sum of |error|.
             * 1 % is added for terms of second order, and 2^-20 of the step per period for the float
             * arithmetic over the 1/K periods of the loop's memory. */
            double x = 0.95 * 1e-4 / inductance;
            double norm = 0.0;
            double area = 0.0;
            for (int k = 1; k < RUN; k++) {
                norm += fabs(expected[k] - expected[k - 1]);
                area += fabs(1.0 - expected[k - 1]);
            }
            double tolerance = 10.0 * (1.01 * norm * 0.5 * x * x * area + 1e-6);
            for (int k = 0; k < RUN; k++) {
                TEST_ASSERT_DOUBLE_WITHIN(tolerance, -10.0 * expected[k], run.current[k]);
            }
        }
    }
}

static void test_recovers_from_saturation_without_windup(void)
{
    static run_t run;
    /* 30 A need 28.5 V of 50 V: about 10 ms at the limit. Since ki/kp = R/L, the integral follows R i
     * during the limitation, ahead by the two periods until a voltage has an effect on the current: R
     * di/dt 2T <= 0.95 * 4000 * 2e-4 = 0.76 V. This is the whole overshoot at the end: 0.76/kp = 0.061 A. */
    run_axis(&run, &PARAMS, 1, 30.0, 50.0);
    double peak = 0.0;
    for (int k = 0; k < RUN; k++) {
        peak = fmax(peak, run.current[k]);
        double lead = run.integral[k] - 0.95 * run.current[k];
        TEST_ASSERT_TRUE_MESSAGE(lead > -0.05 && lead < 0.77, "integral does not follow R i");
    }
    TEST_ASSERT_TRUE_MESSAGE(peak < 30.061, "overshoot after saturation");
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 30.0, run.current[RUN - 1]);
}

/* The rotor turns by `turn` [rad] in a period, i_q_ref steps to 1 A, and the true L of the winding is
 * `share` times the configured one. The winding without resistance is simulated in the stationary frame:
 * the voltage of t_k-1 acts from t_k on, in the direction that the controller has computed for the middle
 * of that period. Returns the largest |i_d| [A]; `left` receives the change of the current in the last
 * period [A]. */
static double coupled(const current_control_params_t *params, double turn, double share, double *left)
{
    current_control_t control;
    begin(&control, params);
    const double period = (double)params->period;
    double complex current = 0.0; /* in the stationary frame */
    double complex acting = 0.0;
    double complex last = 0.0;
    double most = 0.0;
    double angle = 0.0; /* within half a turn, where a 32-bit double resolves it */
    for (int k = 0; k < 400; k++) {
        const double complex rotor = cexp(J * angle);
        angle += angle + turn < PI ? turn : turn - 2.0 * PI;
        const double complex seen = current / rotor;
        const dq_t wanted =
            current_control_step(&control, (dq_t){0.0f, 1.0f}, to_dq(seen), (float)turn, NONE);
        current += period / (share * (double)params->inductance_d) * acting;
        acting = of_dq(wanted) * rotor * cexp(1.5 * J * turn);
        most = fmax(most, fabs(creal(seen)));
        *left = cabs(seen - last);
        last = seen;
    }
    return most;
}

/* The slower root remains real, so that the coupling is of second order: K = 0.03, 0.1 and 0.2 at 0.1 and
 * 0.3 rad. If only the measured current is used, the coupling is 0.16 to 0.22 A at 0.3 rad. An ideal
 * winding has no R, so that the integral has no effect. */
static void test_step_of_one_axis_hardly_moves_the_other_at_a_high_speed(void)
{
    static const float bandwidths[] = {300.0f, 1000.0f, 2000.0f};
    static const double most[] = {0.031, 0.034,
                                  0.096}; /* [A] at 0.3 rad, from the complex difference equation */
    for (unsigned n = 0; n < sizeof bandwidths / sizeof bandwidths[0]; n++) {
        current_control_params_t params = PARAMS;
        params.bandwidth = bandwidths[n];
        params.resistance = 0.0f;
        double left = 0.0;
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, most[n], coupled(&params, 0.3, 1.0, &left));
        TEST_ASSERT_TRUE(coupled(&params, 0.1, 1.0, &left) < 0.5 * most[n]);
    }
}

/* The roots of z^2 - e^(-j turn) z + (K - j g) e^(-j turn/2)/share are at most 0.97 from 0.3 to 1.05 rad, for
 * K of 0.05 to 0.2 and an L that is configured a fifth wrong. With an unlimited g they exceed 1 in 13 of
 * these 36 loops. */
static void test_currents_settle_up_to_six_periods_a_turn_with_an_inductance_a_fifth_wrong(void)
{
    static const double shares[] = {1.0 / 1.2, 1.0, 1.25};
    static const double turns[] = {0.3, 0.5, 0.63, 1.05};
    static const float bandwidths[] = {500.0f, 1000.0f, 2000.0f};
    for (unsigned n = 0; n < 36u; n++) {
        current_control_params_t params = PARAMS;
        params.resistance = 0.0f;
        params.bandwidth = bandwidths[n / 12u];
        double left = 0.0;
        coupled(&params, turns[n / 3u % 4u], shares[n % 3u], &left);
        TEST_ASSERT_TRUE(left < 1e-5);
    }
}
