/* The learnt inductance with an EMF from algebra, e_q = psi_f omega + (L_d,true - L_q,assumed) omega i_d
 * plus the disturbance of a test, and with a current control that follows like a low-pass. */
#include "medium/adapt/inductance.h"
#include "medium/adapt/inductance_dither.h"
#include "medium/adapt/sums.h"
#include "tests/unit/compare.h"

#define PERIOD 1e-4
#define EVERY  4u
#define PSI    0.183
#define L_TRUE 12.5e-3
#define R_TRUE 0.97
#define I_Q    4.5

/* The motion of the rotor, its true values, and those of the parameters. */
typedef struct {
    double omega;              /* [rad/s] */
    double l_d, l_q;           /* true [H] */
    double l_d_from, l_q_from; /* [H] values of the parameters */
    double i_q;                /* [A] */
    double noise;              /* [V] largest magnitude of the uniform noise of e_q */
    double ripple;             /* [V] amplitude of a ripple of e_q */
    double ripple_omega;       /* [rad/s] its frequency */
    double acceleration;       /* [rad/s^2] */
    double resistance;         /* [ohm] error of R that acts on e_q alone */
    double r, r_from;          /* [ohm] true R, and that of the parameters */
    double wrong_l;            /* [H] true minus assumed L, acts on e_d alone */
    double mobility;           /* [rad/s/A] speed by which the rotor swings, in step with i_d */
    double loop;               /* [rad/s] bandwidth of the tracking loop; 0: its angle is constant */
    double swing;              /* [-] i_q per i_d, delayed by 5 ms */
    double swing_d;            /* [A] amplitude of i_d at 220 Hz, beside the dither */
    double control;            /* [rad/s] frequency of a speed control of damping 0.2; 0: none */
    double shaft;              /* [rad/s] resonance of the shaft; 0: it is stiff */
    double detector;           /* [-] reading of the detector */
    double follows;            /* [-] i_d per reference */
    double rate;               /* [1/s] rate of learning */
    bool sound;
    bool voltage_unknown;
} motor_t;

static inductance_t x;
static uint32_t every = EVERY; /* [periods] between two steps */
static uint32_t seed;
static double time_now;        /* [s] */
static double speed, integral; /* of the speed control: integral of i_q [A s], and of this [A s^2] */
static double twist, load;     /* of the shaft: difference of the angles [A s^2], speed of the load [A s] */

static motor_t usual(void)
{
    return (motor_t){.omega = 400.0,
                     .l_d = L_TRUE,
                     .l_q = L_TRUE,
                     .l_d_from = L_TRUE,
                     .l_q_from = L_TRUE,
                     .i_q = I_Q,
                     .r = R_TRUE,
                     .r_from = R_TRUE,
                     .follows = 1.0,
                     .rate = 2.0,
                     .sound = true};
}

static double random_pm1(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (double)seed / 2147483648.0 - 1.0;
}

/* Computes the tuning from the learnt values, as the background does. */
static void assume(const motor_t *motor)
{
    const double ratio = (double)(x.learnt.value / x.learnt.from);
    const inductance_params_t params = {
        .inductance_d = (float)(ratio * motor->l_d_from),
        .inductance_q = x.learnt.value,
        .observed_q = x.learnt.value,
        .from = (float)motor->l_q_from,
        .resistance = x.resistance.value,
        .resistance_from = (float)motor->r_from,
        .flux_linkage = (float)PSI,
        .current_max = 10.0f,
        .rate = (float)motor->rate,
        .period = (float)PERIOD,
        .every = every,
        .salient = motor->l_q_from > 1.10001 * motor->l_d_from,
    };
    const inductance_tuning_t tuning = inductance_prepare(&params);
    inductance_take(&x, &tuning);
}

static void begin(const motor_t *motor)
{
    memset(&x, 0, sizeof x);
    x.learnt = (learnt_value_t){(float)motor->l_q_from, (float)motor->l_q_from};
    x.resistance = (learnt_value_t){(float)motor->r_from, (float)motor->r_from};
    assume(motor);
    const inductance_tuning_t tuning = x.tuning;
    inductance_init(&x, &tuning);
    seed = 1u;
    time_now = 0.0;
    speed = integral = twist = load = 0.0;
}

/* A period of the drive: it adds to the means, and with the last period of the means the learning makes
 * its step. */
static void period(int number, dq_t emf, dq_t current, const inductance_input_t *beside)
{
    static inductance_input_t means;
    if (number % (int)EVERY == 1) {
        means = (inductance_input_t){.sound = true};
    }
    means.emf.q += emf.q / (float)EVERY;
    means.emf.d += emf.d / (float)EVERY;
    means.current.d += current.d / (float)EVERY;
    means.current.q += current.q / (float)EVERY;
    means.sound = means.sound && beside->sound;
    means.voltage_known = beside->voltage_known;
    means.detector = beside->detector;
    means.omega_smooth = beside->omega_smooth;
    means.theta = beside->theta;
    means.flux = beside->flux;
    if (number % (int)EVERY == 0) {
        inductance_step(&x, &means);
    }
}

/* A period of the rotor with this i_q [A], in units in which the whole inertia is one. A third of it is the
 * rotor's; the damping of the resonance is 2 %. */
static void turn(const motor_t *motor, double i_q)
{
    if (motor->shaft == 0.0) {
        speed += PERIOD * i_q;
        return;
    }
    const double part = 1.0 / 3.0;
    const double inertia = part * (1.0 - part);
    const double torque = inertia * motor->shaft * (motor->shaft * twist + 2.0 * 0.02 * (speed - load));
    speed += PERIOD * (i_q - torque) / part;
    load += PERIOD * torque / (1.0 - part);
    twist += PERIOD * (speed - load);
}

/* Runs the steps, with a new assumption every 10 ms; stores the largest and the smallest i_d that was
 * requested. */
static double asked_most, asked_least;

static void run(const motor_t *motor, double seconds)
{
    static double i_d, i_d_slow, i_q_asked, ahead, rotor, rocked;
    asked_most = 0.0;
    asked_least = 0.0;
    for (int n = 1; n <= (int)(seconds / PERIOD + 0.5); n++) {
        const double omega = motor->omega + motor->acceleration * time_now;
        const double against = 0.4 * motor->control * speed + motor->control * motor->control * integral;
        const double swing = motor->swing * i_d_slow + i_q_asked - against;
        turn(motor, swing);
        integral += PERIOD * speed;
        const double i_q = motor->i_q + swing;
        const double l_q = (double)x.tuning.inductance_q;
        const double rocks = motor->mobility * i_d;
        const double emf = PSI * (omega + rocks) + (motor->l_d - l_q) * omega * i_d +
                           motor->resistance * i_q + motor->ripple * sin(motor->ripple_omega * time_now) +
                           motor->noise * random_pm1();
        /* The loop rotates until the EMF along its d axis is zero: psi_f omega (its angle error) + dR i_d +
         * dL di_d/dt. `ahead` is its angle from an even rotation, `rocked` that of the rotor. */
        const double slope = 0.1 * (motor->follows * (double)x.dither.d - i_d) / PERIOD;
        const double drop = PSI * omega * (ahead - rocked) + (motor->r - (double)x.tuning.resistance) * i_d +
                            (motor->wrong_l + motor->l_d - l_q) * slope + motor->noise * random_pm1();
        ahead -= PERIOD * motor->loop * drop / (PSI * omega);
        rocked += PERIOD * rocks;
        rotor = remainder(rotor + PERIOD * omega, 2.0 * PI);
        const inductance_input_t input = {.detector = (float)motor->detector,
                                          .omega_smooth = (float)omega,
                                          .theta = (float)remainder(rotor + ahead, 2.0 * PI),
                                          .sound = motor->sound,
                                          .voltage_known = !motor->voltage_unknown};
        const double beside = motor->swing_d * sin(2.0 * PI * 220.0 * time_now);
        period(n, (dq_t){(float)drop, (float)emf}, (dq_t){(float)(i_d + beside), (float)i_q}, &input);
        const dq_t dither = x.dither;
        i_d += 0.1 * (motor->follows * (double)dither.d - i_d);
        i_d_slow += 0.02 * (i_d - i_d_slow);
        i_q_asked += 0.1 * ((double)dither.q - i_q_asked);
        asked_most = fmax(asked_most, (double)dither.d);
        asked_least = fmin(asked_least, (double)dither.d);
        time_now += PERIOD;
        if (n % 100 == 0) {
            assume(motor);
        }
    }
}

static double ratio(void)
{
    return (double)x.learnt.value / L_TRUE;
}

/* The rest of an error [-] after this number of seconds with valid cycles, by the law of the rate. */
static double left_after(double seconds, double first)
{
    double rate = first;
    double left = 1.0;
    for (int n = 0; n < (int)(seconds / PERIOD + 0.5); n++) {
        left -= PERIOD * rate * left;
        rate += PERIOD * (0.01 * first * first - rate * rate) / 6.0;
    }
    return left;
}

static void add(ab_t *sum, dq_t part, rotation_t frame)
{
    const ab_t stationary = frames_inverse_park(part, frame);
    sum->alpha += stationary.alpha;
    sum->beta += stationary.beta;
}

/* 1256 rad/s rotate a vector by 1 rad in eight periods. The sums are taken in the stationary frame, as in
 * the drive, and i_q does not swing, so that there is nothing to oppose. Two errors would make the drive
 * oppose 1.4 % of the dither, and a light rotor would swing: an angle of the means that is wrong by 14
 * mrad, or a missing term for a changing i_d (omega T/12 of its change in the time T of a step). */
static void test_a_dither_without_torque_is_not_opposed_at_any_speed(void)
{
    for (int n = 0; n < 4; n++) {
        motor_t motor = usual();
        const double omega = n % 2 == 0 ? 1256.0 : -600.0;
        motor.rate = 0.2;
        every = 8u;
        begin(&motor);
        sums_t sums = {.unsound = 0u};
        double i_d = 0.0, i_q = 0.0, rotor = 0.0, most = 0.0, asked = 0.0;
        for (uint32_t k = 1; k <= 20000u; k++) {
            rotor = remainder(rotor + PERIOD * omega, 2.0 * PI);
            i_d += 0.1 * ((double)x.dither.d - i_d);
            i_q += 0.1 * ((double)x.dither.q - i_q);
            const rotation_t frame = {(float)sin(rotor), (float)cos(rotor)};
            const double torque = n < 2 ? I_Q : -I_Q;
            add(&sums.current, (dq_t){(float)i_d, (float)(torque + i_q)}, frame);
            add(&sums.emf, (dq_t){0.0f, (float)(PSI * omega)}, frame);
            if (k % every == 0u) {
                means_t means = {.theta = (float)rotor};
                sums_mean(&sums, 0.125f, frame, (float)omega, (float)(3.5 * PERIOD), &means);
                const inductance_input_t input = {.emf = means.emf_rotor,
                                                  .current = means.current_rotor,
                                                  .omega_smooth = (float)omega,
                                                  .theta = (float)rotor,
                                                  .sound = true,
                                                  .voltage_known = true};
                inductance_step(&x, &input);
                sums = (sums_t){.unsound = 0u};
                most = fmax(most, k > 10000u ? fabs((double)x.dither.q) : 0.0);
                asked = fmax(asked, k > 10000u ? (double)x.dither.d : 0.0);
            }
        }
        every = EVERY;
        TEST_ASSERT_TRUE(asked > 0.4);
        TEST_ASSERT_DOUBLE_WITHIN(0.003 * asked, 0.0, most);
    }
}

/* The largest opposing current in the next 0.2 s [A]. */
static double largest_opposition(const motor_t *motor)
{
    double most = 0.0;
    for (int k = 0; k < 200; k++) {
        run(motor, 1e-3);
        most = fmax(most, fabs((double)x.dither.q));
    }
    return most;
}

/* A speed control of 140 to 160 rad/s and a damping of 0.2 answers an i_q at 33 Hz, 207 rad/s: at 150 rad/s
 * with 1.9/(0.9 - j 0.55) = 1.8 at 31 degrees, to which the high-pass of 100 rad/s adds 26 degrees, and the
 * step after which the dither acts some more. If a half of the swing were opposed in each cycle, the
 * opposition would grow to its limit, the amplitude of the dither of 0.5 A. The swing itself is 5 % of the
 * dither. */
static void test_the_opposition_is_stable_with_a_speed_control_that_swings(void)
{
    for (int n = 0; n < 3; n++) {
        motor_t motor = usual();
        motor.swing = 0.05;
        motor.control = 140.0 + 10.0 * n;
        begin(&motor);
        run(&motor, 6.0);
        const double most = largest_opposition(&motor);
        TEST_ASSERT_TRUE(most < 2.0 * 0.05 * 0.5);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, ratio());
    }
}

/* At the resonance of a shaft the control nearly suppresses an i_q, and its answer is turned by a quarter of
 * a cycle and more. Without the decay the opposition grows to 0.1 to 0.6 A in the first three cases, and with
 * it to 0.3 A in the others, which need another frequency. The swing itself is 2 % of the dither of 0.5 A. An
 * opposition of an eighth of the dither may last. */
static void test_the_opposition_is_stable_at_the_resonance_of_a_shaft(void)
{
    static const struct {
        double control, shaft; /* [rad/s] */
        uint32_t which;
    } cases[] = {
        {70.0, 195.0, 0u}, {80.0, 195.0, 0u}, {90.0, 200.0, 0u}, {80.0, 190.0, 1u}, {100.0, 190.0, 1u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        motor_t motor = usual();
        motor.swing = 0.02;
        motor.control = cases[n].control;
        motor.shaft = cases[n].shaft;
        begin(&motor);
        run(&motor, 9.0);
        const double most = largest_opposition(&motor);
        TEST_ASSERT_TRUE(most < 1.2 * 0.125 * 0.5);
        TEST_ASSERT_EQUAL_UINT32(cases[n].which, x.which);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, ratio());
    }
}

/* What has been learnt until the first frequency is dropped, at a resonance of the shaft, is discarded: L has
 * the value of the parameters to the last bit. The next frequency teaches the true L. */
static void test_what_a_dropped_frequency_has_taught_is_discarded(void)
{
    motor_t motor = usual();
    motor.swing = 0.02;
    motor.control = 80.0;
    motor.shaft = 190.0;
    begin(&motor);
    for (int k = 0; k < 900 && x.swing.from == 0u; k++) {
        run(&motor, 10e-3);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, x.swing.from);
    TEST_ASSERT_EQUAL_FLOAT(x.learnt.from, x.learnt.value);
    TEST_ASSERT_EQUAL_FLOAT(x.learnt.from, x.look.kept);
    TEST_ASSERT_EQUAL_FLOAT(x.tuning.rate, x.rate);
    run(&motor, 6.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, ratio());
}

/* From twice the dither's frequency on the law does not contain the swing, and L is kept. Its configured
 * value is 20 % too small. */
static void test_a_dropped_frequency_that_has_taught_the_truth_is_not_discarded(void)
{
    motor_t motor = usual();
    motor.omega = 900.0;
    motor.swing = 0.02;
    motor.control = 80.0;
    motor.shaft = 190.0;
    motor.l_d_from = motor.l_q_from = 0.8 * L_TRUE;
    begin(&motor);
    for (int k = 0; k < 900 && x.swing.from == 0u; k++) {
        run(&motor, 10e-3);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, x.swing.from);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, ratio());
    TEST_ASSERT_TRUE(x.rate < x.tuning.rate);
    run(&motor, 6.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, ratio());
}

/* Learning trusts its cycles after four of them; each cycle takes effect with its whole share at its end. */
static void test_l_goes_to_the_truth_by_its_rate(void)
{
    for (int n = 0; n < 8; n++) {
        motor_t motor = usual();
        const double wrong = n % 2 ? 1.2 : 0.8;
        motor.omega = n / 2 % 2 ? -400.0 : 400.0;
        motor.rate = n / 4 ? 4.0 : 2.0;
        motor.l_d_from = motor.l_q_from = wrong * L_TRUE;
        begin(&motor);
        run(&motor, 1.0);
        const double left = (ratio() - 1.0) / (wrong - 1.0);
        TEST_ASSERT_TRUE(left < 1.15 * left_after(1.0 - 0.2, motor.rate));
        TEST_ASSERT_TRUE(left > 0.85 * left_after(1.0, motor.rate));
        run(&motor, 9.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, ratio());
        TEST_ASSERT_TRUE(x.confidence > 0.99f);
    }
}

/* An elastic shaft near its resonance lets the rotor swing in step with the dither. The EMF of the swing is
 * 2 to 4 V/A of i_d here, while a wrong L makes 1.3 to 3.8 V/A. The angle shows the same swing, so that L is
 * learnt right from twice the dither's frequency on, for any bandwidth of the loop. The dither leaves a
 * frequency at which the rotor swings, if the next one is not above half of the speed either. */
static void test_l_goes_to_the_truth_while_the_rotor_swings_with_the_dither(void)
{
    static const double speeds[] = {500.0, -800.0, 1500.0};
    static const double loops[] = {0.0, 100.0, 700.0};
    for (int n = 0; n < 36; n++) {
        motor_t motor = usual();
        motor.omega = speeds[n % 3];
        motor.loop = loops[n / 3 % 3];
        motor.mobility = n / 9 % 2 ? 10.0 : -20.0;
        motor.l_d_from = motor.l_q_from = (n / 18 ? 1.2 : 0.8) * L_TRUE;
        begin(&motor);
        run(&motor, 6.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, ratio());
        TEST_ASSERT_EQUAL_UINT32(fabs(motor.omega) > 540.0 ? 2u : 0u, x.swing.from);
    }
}

/* A swing whose EMF p is 0.9 % of omega L counts as zero: omega dL + p = 0 in the end. One of
 * 2.5 % is eliminated. */
static void test_a_swing_that_is_small_beside_l_counts_as_noise(void)
{
    motor_t motor = usual();
    motor.omega = 800.0;
    motor.mobility = 0.009 * 800.0 * L_TRUE / PSI;
    begin(&motor);
    run(&motor, 6.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 1.009, ratio());
    motor.mobility = 0.025 * 800.0 * L_TRUE / PSI;
    begin(&motor);
    run(&motor, 6.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 1.0, ratio());
}

/* The true R is half and twice the assumed one. The loop has a constant angle, follows a part of the
 * dither, or follows most of it: the learnt R must be the same, in both directions, with torque and
 * without. */
static void test_r_goes_to_the_truth_whatever_the_loop_follows(void)
{
    static const double loops[] = {0.0, 100.0, 400.0};
    for (int n = 0; n < 24; n++) {
        motor_t motor = usual();
        const double wrong = n % 2 ? 1.6 : 0.6;
        motor.omega = n / 2 % 2 ? -60.0 : 60.0;
        motor.i_q = n / 4 % 2 ? 0.1 : 4.5;
        motor.loop = loops[n / 8];
        motor.r_from = wrong * R_TRUE;
        motor.rate = 3.0;
        begin(&motor);
        run(&motor, 5.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, (double)x.resistance.value / R_TRUE);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, ratio());
    }
}

/* L di_d/dt leads i_d by a quarter of a cycle, whatever has shifted i_d relative to the dither. R is
 * therefore learnt right although L is wrong by a twentieth, an error that has no effect without torque.
 * In this test the slope is that of half a period before the current, which makes an error of 0.5 %. */
static void test_r_is_learnt_right_with_a_wrong_l(void)
{
    for (int n = 0; n < 4; n++) {
        motor_t motor = usual();
        motor.omega = n / 2 ? 42.0 : 60.0;
        motor.i_q = 0.1;
        motor.rate = 3.0;
        motor.wrong_l = (n % 2 ? 0.05 : -0.05) * L_TRUE;
        begin(&motor);
        run(&motor, 5.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.0, (double)x.resistance.value / R_TRUE);
    }
}

/* Without torque the dither serves R alone. It ends when the rate has fallen to a fifth, by its law after
 * 7.5 s at 3/s; L does not change. */
static void test_without_torque_it_measures_r_for_a_while(void)
{
    motor_t motor = usual();
    motor.omega = 60.0;
    motor.i_q = 0.1;
    motor.rate = 3.0;
    motor.l_d_from = motor.l_q_from = 1.2 * L_TRUE;
    begin(&motor);
    run(&motor, 6.0);
    TEST_ASSERT_TRUE(asked_most > 0.4);
    run(&motor, 6.0);
    run(&motor, 0.1);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, asked_most);
    TEST_ASSERT_EQUAL_FLOAT(x.learnt.from, x.learnt.value);
}

/* The time [s] within the next seconds in which there is a dither, counted in steps of 10 ms. */
static double dithered(const motor_t *motor, int seconds)
{
    double sum = 0.0;
    for (int n = 0; n < 100 * seconds; n++) {
        run(motor, 0.01);
        sum += asked_most > 0.0 || asked_least < 0.0 ? 0.01 : 0.0;
    }
    return sum;
}

/* At 2/s the rate falls to 0.3 of the first one in (1/0.3 - 1) 3 s = 7 s, a little later because the first
 * cycles do not count. From there on a dither of a second follows each pause of 20 s; the learnt value
 * does not change. */
static void test_the_dither_rests_when_it_has_learnt(void)
{
    motor_t motor = usual();
    motor.l_d_from = motor.l_q_from = 1.2 * L_TRUE;
    begin(&motor);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 14.0, dithered(&motor, 20));
    const float learnt = x.learnt.value;
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.0, ratio());
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, dithered(&motor, 5));
    TEST_ASSERT_EQUAL_FLOAT(learnt, x.learnt.value);
    TEST_ASSERT_TRUE(x.confidence > 0.5f);
    const double share = dithered(&motor, 210) / 210.0;
    TEST_ASSERT_TRUE(share > 0.03 && share < 0.05);
}

/* L decreases by a tenth when the load increases by 3 of 10 A: the dither begins again at once. A smaller
 * step of the load does not end the pause. */
static void test_another_load_ends_the_rest(void)
{
    motor_t motor = usual();
    begin(&motor);
    run(&motor, 16.0);
    motor.i_q = I_Q + 2.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, dithered(&motor, 2));
    motor.i_q = I_Q + 3.0;
    motor.l_d = motor.l_q = 0.9 * L_TRUE;
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 1.1, dithered(&motor, 3));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.9, (double)x.said / L_TRUE);
}

/* A pause has begun while the rotor was fast, where R is not measured. It must not prevent R from being
 * learnt once the rotor turns slowly. */
static void test_a_rest_ends_where_r_is_looked_for(void)
{
    motor_t motor = usual();
    motor.r_from = 1.6 * R_TRUE;
    begin(&motor);
    run(&motor, 16.0);
    run(&motor, 0.1);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, asked_most);
    TEST_ASSERT_EQUAL_FLOAT((float)motor.r_from, x.resistance.value);
    motor.omega = 60.0;
    run(&motor, 5.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, (double)x.resistance.value / R_TRUE);
}

static void test_the_dither_is_a_twentieth_of_the_limit(void)
{
    const motor_t motor = usual();
    begin(&motor);
    run(&motor, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.5, asked_most);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -0.5, asked_least);
}

/* Below 80 rad/s the amplitude is 0.5 A 80/omega, up to twice, and never more than a third of i_q unless the
 * usual 0.5 A are more. Without torque R is looked for with the usual amplitude. */
static void test_the_dither_grows_as_the_speed_falls(void)
{
    static const struct {
        double omega, i_q, amplitude;
    } cases[] = {{400.0, 4.5, 0.5}, {80.0, 4.5, 0.5}, {64.0, 4.5, 0.625},
                 {-50.0, 4.5, 0.8}, {40.0, 4.5, 1.0}, {32.0, 4.5, 1.0},
                 {40.0, -2.4, 0.8}, {40.0, 1.8, 0.6}, {40.0, 0.0, 0.5}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        motor_t motor = usual();
        motor.omega = cases[n].omega;
        motor.i_q = cases[n].i_q;
        begin(&motor);
        run(&motor, 0.5);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, cases[n].amplitude, (double)x.current);
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * cases[n].amplitude, cases[n].amplitude, asked_most);
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * cases[n].amplitude, -cases[n].amplitude, asked_least);
    }
}

/* At L_q of 1.11 and 1.15 L_d there is no dither, and nothing is learnt, for any rate. At 1.1 L_d there
 * is a dither. */
static void test_a_rotor_too_salient_is_left_as_it_is(void)
{
    static const double ratios[] = {1.11, 1.15, 2.0, 1.1};
    for (size_t n = 0; n < sizeof ratios / sizeof ratios[0]; n++) {
        motor_t motor = usual();
        motor.rate = 20.0;
        motor.l_d = L_TRUE / ratios[n];
        motor.l_d_from = 0.8 * L_TRUE / ratios[n];
        motor.l_q_from = 0.8 * L_TRUE;
        begin(&motor);
        run(&motor, 5.0);
        if (ratios[n] > 1.1) {
            TEST_ASSERT_EQUAL_FLOAT(0.0f, x.tuning.rate);
            TEST_ASSERT_EQUAL_DOUBLE(0.0, asked_most);
            TEST_ASSERT_EQUAL_FLOAT(x.learnt.from, x.learnt.value);
            TEST_ASSERT_EQUAL_FLOAT(x.resistance.from, x.resistance.value);
        } else {
            TEST_ASSERT_TRUE(asked_most > 0.0);
            TEST_ASSERT_DOUBLE_WITHIN(5e-3, 1.0, ratio());
        }
    }
}

/* Six cycles that agree bring the confidence to 1 - 0.8^5 = 0.67; 2 s of them bring it above 0.9. Then
 * cycles that contradict each other follow until the interval ends: the value returns to that of the
 * parameter, or to the one that was certain. */
static void test_what_an_interval_without_agreement_has_learnt_is_not_kept(void)
{
    for (int known = 0; known < 2; known++) {
        motor_t motor = usual();
        begin(&motor);
        if (known != 0) { /* an L that is 10 % larger is learnt until the confidence is above 0.9 */
            motor.l_d = motor.l_q = 1.1 * L_TRUE;
            run(&motor, 2.0);
            TEST_ASSERT_TRUE(x.confidence > 0.9f);
            TEST_ASSERT_DOUBLE_WITHIN(0.02 * L_TRUE, 1.1 * L_TRUE, (double)x.learnt.value);
        } else { /* six cycles agree */
            motor.l_d = motor.l_q = 1.3 * L_TRUE;
            run(&motor, 0.22);
            TEST_ASSERT_TRUE(x.learnt.value > (float)(1.02 * L_TRUE));
        }
        const double had = (known != 0 ? 1.1 : 1.0) * L_TRUE;
        double furthest = 0.0; /* largest distance from `had` before the end */
        for (int n = 0; n < 400 && x.look.failed == 0u; n++) { /* cycles of 33 Hz contradict each other */
            motor.l_d = motor.l_q = (n % 3 == 0 ? 0.8 : 1.4) * L_TRUE;
            run(&motor, 0.0304);
            const double away = x.look.failed == 0u ? fabs((double)x.learnt.value - had) : 0.0;
            furthest = fmax(furthest, away);
        }
        TEST_ASSERT_EQUAL_UINT32(1u, x.look.failed);
        TEST_ASSERT_TRUE(x.confidence <= 0.5f);
        TEST_ASSERT_TRUE(known != 0 || furthest > 0.05 * L_TRUE);
        TEST_ASSERT_DOUBLE_WITHIN(known != 0 ? 0.02 * L_TRUE : 1e-8, had, (double)x.learnt.value);
    }
}

/* Six cycles that agree bring the confidence to 0.67 and change L. Then no cycle has a result, because the
 * loop is not locked, until the interval ends: the value returns to that of the parameter. */
static void test_what_few_cycles_have_learnt_is_not_kept_if_the_interval_fails(void)
{
    motor_t motor = usual();
    begin(&motor);
    motor.l_d = motor.l_q = 1.3 * L_TRUE;
    run(&motor, 0.22);
    TEST_ASSERT_TRUE(x.learnt.value > (float)(1.02 * L_TRUE));
    TEST_ASSERT_TRUE(x.confidence > 0.6f && x.confidence < 0.9f);
    motor.detector = 0.2;
    for (int n = 0; n < 400 && x.look.failed == 0u; n++) {
        run(&motor, 0.01);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, x.look.failed);
    TEST_ASSERT_EQUAL_FLOAT(x.learnt.from, x.learnt.value);
}

/* Six cycles that agree bring the confidence to 0.67, and the load ends: the value returns to that of the
 * parameter. After 2 s the confidence is above 0.9, and the value stays. */
static void test_what_few_cycles_have_learnt_is_not_kept_without_torque(void)
{
    for (int known = 0; known < 2; known++) {
        motor_t motor = usual();
        begin(&motor);
        motor.l_d = motor.l_q = 1.3 * L_TRUE;
        run(&motor, known != 0 ? 2.0 : 0.22);
        const double learnt = (double)x.learnt.value;
        TEST_ASSERT_TRUE(learnt > 1.02 * L_TRUE);
        TEST_ASSERT_EQUAL(known != 0, x.confidence > 0.9f);
        motor.i_q = 0.0;
        run(&motor, 0.1);
        TEST_ASSERT_DOUBLE_WITHIN(1e-2 * L_TRUE, known != 0 ? learnt : L_TRUE, (double)x.learnt.value);
    }
}

/* The noise is uniform within 1 V. The sum over a cycle of 303 steps has an SD of 0.58 sqrt(303 x 0.533) =
 * 7.3 V. A whole L makes 400 x L x 0.5 x 0.533 x 303 = 404 V in it, times 0.9 of the low-pass: the error
 * is 2 %. The mean over 2/share cycles has 0.35 %. */
static void test_noise_averages_out(void)
{
    motor_t motor = usual();
    motor.noise = 1.0;
    motor.l_d_from = motor.l_q_from = 0.8 * L_TRUE;
    begin(&motor);
    run(&motor, 4.0);
    for (int n = 0; n < 20; n++) {
        run(&motor, 0.2);
        TEST_ASSERT_DOUBLE_WITHIN(0.015, 1.0, ratio());
    }
}

/* Errors of the sensors make an oscillation of the EMF at the electrical frequency or twice this
 * frequency, as large as the effect of a twentieth of L. Tested at any electrical frequency. If the
 * oscillation is 4 Hz from the dither, a mean over 1/rate leaves a share of rate/(2 pi 4 Hz). This counts
 * twice, because the square of the dither has a mean of one half: 0.8 %. */
static void test_a_ripple_at_the_electrical_frequency_is_kept_away_from(void)
{
    for (double f = 8.0; f <= 100.0; f += 1.0) {
        for (int times = 1; times <= 2; times++) {
            motor_t motor = usual();
            motor.omega = 2.0 * 3.14159265358979 * f;
            motor.ripple = 0.05 * L_TRUE * 0.5 * motor.omega;
            motor.ripple_omega = times * motor.omega;
            begin(&motor);
            run(&motor, 5.0);
            TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.0, ratio());
        }
    }
}

/* The learnt L and R divided by the true values after this number of seconds, in these cases:
 * - e_q contains an R that is wrong by 0.3 ohm, and i_q swings with the dither, delayed by a fifth of a
 * cycle. If it were not opposed, L would be 11 % wrong. A cycle opposes a quarter of the swing, and 1/64 of
 * the opposition decays: 1/17 of the swing remains, 0.66 %.
 * - The learnt values are limited to half and twice their parameters.
 * - The speed drifts by 1.5 to 2.5 % in a cycle, as that of a light rotor does. Then e_q shows L if the
 * voltage is known.
 * - An EMF below half of psi_f omega means that the loop has lost the rotor, and nothing is learnt.
 * - The error of R that a cycle finds is limited to the parameter: at a rate of 1/s, R changes by at most
 * half of the parameter in 0.5 s, although the true R is nine times as large. */
static void test_what_is_learnt_of_one_motor_or_another(void)
{
    static const struct {
        const char *what;
        double omega, l_from, r_from, rate,
            emf; /* [rad/s], relative to the truth [-], [1/s], share of psi_f omega [-] */
        double resistance, swing, acceleration; /* as of motor_t */
        double seconds, l_least, l_most, r_least, r_most;
    } cases[] = {
        {"swing", 42.0, 1.0, 1.0, 2.0, 1.0, 0.3, 0.4, 0.0, 5.0, 0.993, 1.007, 0.0, 9.0},
        {"swing", 42.0, 1.0, 1.0, 2.0, 1.0, -0.3, 0.4, 0.0, 5.0, 0.993, 1.007, 0.0, 9.0},
        {"half of R", 60.0, 1.0, 2.5, 10.0, 1.0, 0.0, 0.0, 0.0, 8.0, 0.9, 1.1, 1.25, 1.25},
        {"twice R", 60.0, 1.0, 0.4, 10.0, 1.0, 0.0, 0.0, 0.0, 8.0, 0.9, 1.1, 0.8, 0.8},
        {"half of L", 400.0, 2.5, 1.0, 2.0, 1.0, 0.0, 0.0, 0.0, 10.0, 1.25, 1.25, 0.0, 9.0},
        {"twice L", 400.0, 0.4, 1.0, 2.0, 1.0, 0.0, 0.0, 0.0, 10.0, 0.8, 0.8, 0.0, 9.0},
        {"drift", 400.0, 0.8, 1.0, 2.0, 1.0, 0.0, 0.0, -0.015 * 400.0 / 0.03, 0.8, 0.85, 1.1, 0.0, 9.0},
        {"small EMF", 400.0, 0.8, 1.0, 2.0, 0.45, 0.0, 0.0, 0.0, 3.0, 0.8, 0.8, 0.0, 9.0},
        {"small EMF", -400.0, 0.8, 1.0, 2.0, 0.45, 0.0, 0.0, 0.0, 3.0, 0.8, 0.8, 0.0, 9.0},
        {"enough EMF", 400.0, 0.8, 1.0, 2.0, 0.55, 0.0, 0.0, 0.0, 3.0, 0.9, 1.1, 0.0, 9.0},
        {"enough EMF", -400.0, 0.8, 1.0, 2.0, 0.55, 0.0, 0.0, 0.0, 3.0, 0.9, 1.1, 0.0, 9.0},
        {"ninth of R", 60.0, 1.0, 1.0 / 9.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.9, 1.1, 1.2 / 9.0, 1.5 / 9.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        motor_t motor = usual();
        motor.omega = cases[n].omega;
        motor.l_d_from = motor.l_q_from = cases[n].l_from * L_TRUE;
        motor.r_from = cases[n].r_from * R_TRUE;
        motor.rate = cases[n].rate;
        motor.resistance = cases[n].resistance + (cases[n].emf - 1.0) * PSI * motor.omega / motor.i_q;
        motor.swing = cases[n].swing;
        motor.acceleration = cases[n].acceleration;
        begin(&motor);
        run(&motor, cases[n].seconds);
        const double r = (double)x.resistance.value / R_TRUE;
        TEST_ASSERT_TRUE_MESSAGE(ratio() >= cases[n].l_least - 1e-6 && ratio() <= cases[n].l_most + 1e-6,
                                 cases[n].what);
        TEST_ASSERT_TRUE_MESSAGE(r >= cases[n].r_least - 1e-6 && r <= cases[n].r_most + 1e-6, cases[n].what);
    }
}

/* With torque the dither keeps a distance of 6.5 Hz from the sixth harmonic of the dead time, with which a
 * light rotor swings; the cycles of the dither would beat with it. With the small current of a motor
 * without torque the dither would also beat with the neighbours of the sixth harmonic, which an offset of
 * the current sensors causes. Tested up to 15.9 Hz, below which R is measured. */
static void test_it_keeps_away_from_the_sixth_harmonic_and_without_torque_from_its_neighbours(void)
{
    static const struct {
        double i_q, away; /* [A], [Hz] */
        int from, to;     /* first and last harmonic */
    } cases[] = {{0.0, (double)INDUCTANCE_NEAR, 5, 7}, {I_Q, (double)INDUCTANCE_NEAR_SIXTH, 6, 6}};
    for (int n = 0; n < 2; n++) {
        for (double hertz = 5.0; hertz <= 15.5; hertz += 0.1) {
            motor_t motor = usual();
            motor.omega = 2.0 * PI * hertz;
            motor.i_q = cases[n].i_q;
            begin(&motor);
            run(&motor, 0.1);
            TEST_ASSERT_TRUE(asked_most > 0.0);
            const double dither = 1.0 / (x.tuning.wave[x.which].steps * EVERY * PERIOD);
            for (int times = cases[n].from; times <= cases[n].to; times++) {
                TEST_ASSERT_TRUE(fabs(dither - times * hertz) > cases[n].away - 0.5);
            }
        }
    }
}

/* L is wrong by a fifth, and one condition at a time prevents that it is learnt. If nothing can be learnt, at
 * a low speed or almost without torque, no dither is requested; after an invalid cycle the next one follows.
 * A reversal to the same speed backwards always exceeds the change that a cycle may have. */
static void test_nothing_is_learnt_without_an_effect_and_from_an_invalid_cycle(void)
{
    static const struct {
        size_t at;
        double value;
        bool sound, voltage_unknown, dithers;
    } cases[] = {{offsetof(motor_t, omega), 29.0, true, false, false},
                 {offsetof(motor_t, i_q), 1.4, true, false, false},
                 {offsetof(motor_t, i_q), -1.4, true, false, false},
                 {offsetof(motor_t, l_q_from), 0.4e-3, true, false, false}, /* the dither makes only 0.08 V */
                 {offsetof(motor_t, i_q), I_Q, false, false, true},
                 {offsetof(motor_t, detector), -0.11, true, false, true},
                 {offsetof(motor_t, follows), 0.4, true, false, true},
                 {offsetof(motor_t, follows), 1.7, true, false, true},
                 {offsetof(motor_t, noise), 200.0, true, false, true},
                 {offsetof(motor_t, acceleration), -0.04 * 400.0 / 0.03, true, false, true},
                 {offsetof(motor_t, acceleration), -0.015 * 400.0 / 0.03, true, true, true}};
    for (unsigned n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        char text[20];
        motor_t motor = usual();
        motor.l_d_from = motor.l_q_from = 0.8 * L_TRUE;
        memcpy((char *)&motor + cases[n].at, &cases[n].value, sizeof cases[n].value);
        motor.sound = cases[n].sound;
        motor.voltage_unknown = cases[n].voltage_unknown;
        begin(&motor);
        run(&motor, 1.5);
        (void)snprintf(text, sizeof text, "case %u", n);
        TEST_ASSERT_TRUE_MESSAGE(x.learnt.value == x.learnt.from, text);
        TEST_ASSERT_EQUAL_MESSAGE(cases[n].dithers, asked_most > 0.0, text);
    }
}

/* Every second cycle is not sound. Its neighbours agree, but only because they have the same phase of
 * whatever makes the others invalid, as the beat of a harmonic with the dither: nothing is learnt from them.
 */
static void test_a_result_agrees_only_with_that_of_the_cycle_before(void)
{
    for (int broken = 0; broken < 2; broken++) {
        motor_t motor = usual();
        motor.l_d_from = motor.l_q_from = 0.8 * L_TRUE;
        begin(&motor);
        uint32_t cycles = 0u;
        for (int n = 0; n < 2500; n++) {
            cycles += x.left == 0u ? 1u : 0u; /* the next step begins another one */
            motor.sound = broken == 0 || cycles % 2u == 0u;
            run(&motor, EVERY * PERIOD);
        }
        TEST_ASSERT_GREATER_THAN_UINT32(25u, cycles);
        TEST_ASSERT_TRUE(broken != 0 ? x.learnt.value == x.learnt.from : ratio() > 0.9);
    }
}

/* A harmonic of the EMF swings i_d, by less and by more than the dither of 0.5 A, whose mean square is 8/15
 * of its square and not one half. With the larger swing the dead time answers to the dither, too, and nothing
 * is learnt. */
static void test_nothing_is_learnt_beside_a_swing_larger_than_the_dither(void)
{
    for (int n = 0; n < 4; n++) {
        motor_t motor = usual();
        motor.omega = n < 2 ? 400.0 : -400.0;
        motor.l_d_from = motor.l_q_from = 0.8 * L_TRUE;
        motor.swing_d = (n % 2 == 0 ? 0.8 : 1.3) * 0.5;
        begin(&motor);
        run(&motor, 3.0);
        TEST_ASSERT_TRUE(n % 2 == 0 ? ratio() > 0.95 : x.learnt.value == x.learnt.from);
    }
}

/* One period has a value that is not a number, or no EMF: the learnt value does not change, and learning
 * continues afterwards. */
static void test_no_number_and_no_emf_teach_nothing(void)
{
    static const float emfs[] = {NAN, INFINITY, 0.0f, 73.2f};
    static const float currents[] = {0.0f, 0.0f, 0.0f, NAN};
    for (int n = 0; n < 4; n++) {
        motor_t motor = usual();
        motor.l_d_from = motor.l_q_from = 0.8 * L_TRUE;
        begin(&motor);
        run(&motor, 0.9);
        const float before = x.learnt.value;
        const inductance_input_t input = {.omega_smooth = 400.0f, .sound = n == 2};
        for (int k = 1; k <= 10000; k++) {
            period(k, (dq_t){0.0f, emfs[n]}, (dq_t){currents[n], 4.5f}, &input);
        }
        TEST_ASSERT_FLOAT_WITHIN(0.0f, before, x.learnt.value);
        run(&motor, 5.0);
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 1.0, ratio());
    }
}

static void test_another_parameter_starts_again_and_another_rate_does_not(void)
{
    motor_t motor = usual();
    motor.l_d_from = motor.l_q_from = 0.8 * L_TRUE;
    begin(&motor);
    run(&motor, 3.0);
    const float learnt = x.learnt.value;
    motor.rate = 1.0;
    assume(&motor);
    TEST_ASSERT_TRUE(x.learnt.value == learnt);
    motor.l_d_from = motor.l_q_from = 0.9 * L_TRUE;
    assume(&motor);
    TEST_ASSERT_TRUE(x.learnt.value == (float)(0.9 * L_TRUE));
    TEST_ASSERT_TRUE(x.learnt.from == (float)(0.9 * L_TRUE));
    run(&motor, 3.0);
    TEST_ASSERT_TRUE(x.learnt.value != x.learnt.from);
    motor.rate = 0.0;
    assume(&motor);
    TEST_ASSERT_TRUE(x.learnt.value == x.learnt.from);
}

/* The current changes by psi_f omega T/L in a period by the EMF alone: with less i_q the signs of the phase
 * currents change within the period. L is 1.1 times or 0.9 times that at which both are equal. */
static void test_where_the_ripple_exceeds_the_current_there_is_no_dither(void)
{
    for (int n = 0; n < 4; n++) {
        const double factor = n % 2 == 0 ? 1.1 : 0.9;
        motor_t motor = usual();
        motor.omega = n < 2 ? 400.0 : -400.0;
        motor.l_d_from = motor.l_q_from = factor * PSI * 400.0 * PERIOD / I_Q;
        motor.l_d = motor.l_q = 1.2 * motor.l_d_from;
        begin(&motor);
        run(&motor, 5.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, factor > 1.0 ? 1.2 : 1.0, (double)x.learnt.value / motor.l_q_from);
    }
}

/* In a step the rotor turns by a third of a turn, within 0.004 rad: all steps have their samples at the same
 * angles. At 1.4 times this distance L is learnt. */
static void test_where_the_samples_repeat_their_angles_there_is_no_dither(void)
{
    static const double apart[] = {0.0, 0.0035, -0.0035, 0.0056, -0.0056}; /* [rad] */
    for (size_t n = 0; n < sizeof apart / sizeof apart[0]; n++) {
        motor_t motor = usual();
        motor.omega = (n % 2 == 0 ? 1.0 : -1.0) * (2.0 * PI / 3.0 + apart[n]) / (EVERY * PERIOD);
        motor.l_d_from = motor.l_q_from = L_TRUE / 1.2;
        begin(&motor);
        run(&motor, 5.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, n >= 3u ? 1.2 : 1.0, (double)x.learnt.value / motor.l_q_from);
    }
}

/* By algebra: not within 4 Hz of one or two times the electrical frequency, and with torque not within 6.5 Hz
 * of six times it; without torque not within 4 Hz of five to seven times it. */
static bool is_good_at(double f, double electrical, bool torque)
{
    const double apart = torque ? 6.5 : 4.0 + electrical;
    return fabs(f - electrical) >= 4.0 && fabs(f - 2.0 * electrical) >= 4.0 &&
           fabs(f - 6.0 * electrical) >= apart;
}

static void test_the_frequency_is_the_first_good_one_that_is_no_resonance(void)
{
    static const double frequencies[] = {33.0, 43.0, 57.0};
    for (double electrical = 4.801; electrical < 200.0; electrical += 0.05) {
        for (uint32_t from = 0; from < 3u; from++) {
            for (int torque = 0; torque < 2; torque++) {
                const float omega = (float)(2.0 * PI * electrical);
                const uint32_t which = inductance_frequency(omega, torque != 0, from);
                for (uint32_t n = from; n < which; n++) {
                    TEST_ASSERT_FALSE(is_good_at(frequencies[n], electrical, torque != 0));
                }
                TEST_ASSERT_TRUE(which == 3u ? from > 0u
                                             : is_good_at(frequencies[which], electrical, torque != 0));
            }
        }
    }
}

/* 0.05 of 10 A; five times the noise from 0.1 A on; 0.15 of 10 A from 0.3 A on. */
static void test_the_dither_is_larger_than_the_noise(void)
{
    static const struct {
        float noise, dither; /* [A] */
    } cases[] = {{0.0f, 0.5f}, {0.09f, 0.5f}, {0.11f, 0.55f}, {0.29f, 1.45f}, {0.31f, 1.5f}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const inductance_params_t params = {
            .inductance_d = (float)L_TRUE,
            .inductance_q = (float)L_TRUE,
            .observed_q = (float)L_TRUE,
            .from = (float)L_TRUE,
            .resistance = 1.0f,
            .resistance_from = 1.0f,
            .flux_linkage = (float)PSI,
            .current_max = 10.0f,
            .noise = cases[n].noise,
            .rate = 1.0f,
            .period = (float)PERIOD,
            .every = every,
        };
        const inductance_tuning_t tuning = inductance_prepare(&params);
        TEST_ASSERT_FLOAT_WITHIN(1e-5f, cases[n].dither, tuning.current);
    }
}

/* With L wrong by a fifth the angle is 0.1 L 10 A/psi_f = 0.0683 rad, and 0.5 A along it make 0.0342 A of
 * torque. The speed then swings by this times K/207 rad/s; twice of it may be 0.15 rad/s, up to K of 455, and
 * once up to K of 911. */
static void test_the_dither_of_a_light_rotor_grows_less(void)
{
    static const struct {
        float acceleration, factor; /* K [rad/s^2 per A] */
        bool salient;
    } cases[] = {{0.0f, 2.0f, false},     {450.0f, 2.0f, false}, {600.0f, 1.518f, false},
                 {900.0f, 1.012f, false}, {920.0f, 1.0f, false}, {9000.0f, 1.0f, false},
                 {0.0f, 1.0f, true}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const inductance_params_t params = {
            .inductance_q = (float)L_TRUE,
            .flux_linkage = (float)PSI,
            .current_max = 10.0f,
            .acceleration = cases[n].acceleration,
            .salient = cases[n].salient,
        };
        TEST_ASSERT_FLOAT_WITHIN(1e-3f, cases[n].factor, inductance_slow_most(&params));
    }
}

/* ---- a salient rotor ---- */

#define FLUX   0.1
#define L_D    6.667e-3
#define L_Q    20e-3
#define AT_I_D -5.0
#define AT_I_Q 8.0

static void believe_salient(double l_q_from)
{
    const inductance_params_t params = {
        .inductance_d = (float)L_D,
        .inductance_q = x.learnt.value,
        .observed_q = x.learnt.value,
        .from = (float)l_q_from,
        .resistance = (float)R_TRUE,
        .resistance_from = (float)R_TRUE,
        .flux_linkage = (float)FLUX,
        .current_max = 10.0f,
        .rate = 3.0f,
        .period = (float)PERIOD,
        .every = EVERY,
        .salient = true,
        .salient_too = true,
    };
    const inductance_tuning_t tuning = inductance_prepare(&params);
    inductance_take(&x, &tuning);
}

/* Runs a rotor at constant speed for this number of seconds. An L_q that is wrong by dL appears as the EMF
 * omega (psi_a - dL i), whose angle the loop follows with this bandwidth [rad/s]. The current rotates with
 * the loop, which changes psi_a: D i_q times the rate of the loop is a voltage along d. Returns the
 * largest change of the torque [-]. */
static double run_salient(double l_q_from, double omega, double bandwidth, double seconds)
{
    double i_d = AT_I_D, i_q = AT_I_Q, ahead = 0.0, rotor = 0.0, ripple = 0.0;
    x.learnt = (learnt_value_t){(float)l_q_from, (float)l_q_from};
    believe_salient(l_q_from);
    const inductance_tuning_t tuning = x.tuning;
    inductance_init(&x, &tuning);
    for (int n = 1; n <= (int)(seconds / PERIOD + 0.5); n++) {
        const double wrong = (double)x.tuning.inductance_q - L_Q;
        const double along = FLUX - (L_Q - L_D) * i_d - wrong * i_d;
        const double angle = atan2(-wrong * i_q, along);
        const double emf = omega * hypot(wrong * i_q, along);
        const double turns = bandwidth * (angle - ahead);
        const double drop = ((double)x.tuning.inductance_q - L_D) * i_q * turns;
        ahead += PERIOD * turns;
        rotor = remainder(rotor + PERIOD * omega, 2.0 * PI);
        const inductance_input_t input = {.omega_smooth = (float)omega,
                                          .theta = (float)remainder(rotor + ahead, 2.0 * PI),
                                          .flux = (float)(FLUX - (L_Q - L_D) * AT_I_D),
                                          .sound = true,
                                          .voltage_known = true};
        period(n, (dq_t){(float)(drop - emf * sin(angle - ahead)), (float)(emf * cos(angle - ahead))},
               (dq_t){(float)i_d, (float)i_q}, &input);
        i_d += 0.1 * (AT_I_D + (double)x.dither.d - i_d);
        i_q += 0.1 * (AT_I_Q + (double)x.dither.q - i_q);
        const double torque = (FLUX - (L_Q - L_D) * i_d) * i_q;
        ripple = fmax(ripple, fabs(torque / ((FLUX - (L_Q - L_D) * AT_I_D) * AT_I_Q) - 1.0));
        if (n % 100 == 0) {
            believe_salient(l_q_from);
        }
    }
    return ripple;
}

static void test_l_q_of_a_salient_rotor_goes_to_the_truth(void)
{
    static const double cases[][3] = {
        {0.8, 500.0, 100.0}, {1.2, 500.0, 100.0}, {0.8, -100.0, 400.0}, {1.2, 100.0, 20.0}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        memset(&x, 0, sizeof x);
        time_now = 0.0;
        (void)run_salient(cases[n][0] * L_Q, cases[n][1], cases[n][2], 8.0);
        check_line(fabs((double)x.learnt.value / L_Q - 1.0), 0.01, "A13 learnt L_q");
    }
}

/* At any speed the rate follows the law (1 + g t/6)^-6 with g = 3/s from the third cycle on: of the error
 * of a fifth 0.006 are left after 1.7 s. If the voltage of the loop's own motion had an effect, 0.05 would
 * be left at 100 rad/s. */
static void test_l_q_of_a_salient_rotor_is_learnt_as_fast_at_low_speed(void)
{
    static const double speeds[] = {500.0, 100.0, -100.0};
    for (size_t n = 0; n < sizeof speeds / sizeof speeds[0]; n++) {
        memset(&x, 0, sizeof x);
        time_now = 0.0;
        (void)run_salient(0.8 * L_Q, speeds[n], 150.0, 1.7);
        check_below(fabs((double)x.learnt.value / L_Q - 1.0), 0.006, "error that is left");
    }
}

/* Along the line di_q = t di_d with t = D i_q/psi_a = 0.64 the torque changes by t^2 (di_d/i_q)^2 = 0.16
 * %; with i_d alone it would change by t di_d/i_q = 4 %. */
static void test_a_known_salient_rotor_stays_as_it_is_and_gets_no_torque(void)
{
    memset(&x, 0, sizeof x);
    const double ripple = run_salient(L_Q, 500.0, 100.0, 5.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, (double)x.learnt.value / L_Q);
    TEST_ASSERT_TRUE(ripple > 5e-4);
    TEST_ASSERT_TRUE(ripple < 2.5e-3);
}
