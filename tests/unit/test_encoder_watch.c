/* The encoder is compared with a known EMF: psi_f omega on the q axis of the true rotor, in the frame of
 * an encoder that is wrong by an angle or turns at another speed. T_j, the time between two judgements, is
 * 0.8 ms. A sign is a contradiction between encoder and EMF. At psi_f omega_least it must last for 8 ms,
 * ten judgements; at larger EMFs the time is shorter in proportion, at least three judgements. Below five
 * times that EMF the mean of two windows is judged: if the EMF rotates by half a turn between them, the
 * mean is zero, which is a sign too. A judgement whose EMF is by chance wrong along the axis of a phase is
 * postponed; expect() counts the others. */
#include <stdlib.h>

#include "estimator/encoder.h"
#include "medium/protect/encoder_watch.h"
#include "tests/unit/compare.h"
#include "tests/unit/scatter.h"
#include "tests/unit/vectors.h"

#define T     1e-4
#define EVERY 8u
#define R     0.95    /* [ohm] */
#define L     12.5e-3 /* [H] */
#define PSI   0.183
#define LEAST 60.0   /* [rad/s] */
#define STEP  2.5e-3 /* [rad] */

static encoder_watch_t watch;

static double rotor, encoder; /* [rad] */
static ab_t current;          /* [A] */
static ab_t observed;         /* [V] EMF of the observer at the end of a window */
static ab_t lacks;            /* [A] requested minus measured current */
static bool is_doubtful;      /* the sign of the current, and with it the EMF, is uncertain */

static uint32_t bits; /* bits of the last judgement */

/* The usual parameters with this noise and this limit of the current below which the EMF is uncertain [A]. */
static encoder_watch_params_t usual(double noise, float doubtful)
{
    return (encoder_watch_params_t){
        .resistance = (float)R,
        .inductance = (float)L,
        .flux_linkage = (float)PSI,
        .speed_least = (float)LEAST,
        .step = (float)STEP,
        .noise = (float)noise,
        .doubtful = doubtful,
        .period = (float)T,
        .every = EVERY,
    };
}

static encoder_watch_tuning_t prepared(double noise, float doubtful)
{
    const encoder_watch_params_t params = usual(noise, doubtful);
    return encoder_watch_prepare(&params);
}

static void begin(double noise, float doubtful)
{
    const encoder_watch_tuning_t tuning = prepared(noise, doubtful);
    memset(&watch, 0x55, sizeof watch);
    encoder_watch_init(&watch, &tuning);
    encoder_watch_rest(&watch);
    rotor = 0.3;
    encoder = 0.3;
    current = (ab_t){0.0f, 0.0f};
    lacks = (ab_t){0.0f, 0.0f};
    is_doubtful = false;
}

void setUp(void)
{
    begin(0.0, 0.0f);
}

/* A salient rotor turns slowly while i_d rises by 3 A in each of twelve windows. With the difference of the
 * inductances this makes 4 mH 3 A/0.8 ms = 15 V, more than the least EMF, 11 V. If the watch knows the
 * difference, the encoder agrees with the EMF; if not, the watch reports a mismatch. */
static void test_a_current_along_the_magnet_of_a_salient_rotor_is_no_sign(void)
{
    const double apart = 4e-3; /* L_q - L_d [H] */
    for (int32_t known = 0; known < 2; known++) {
        encoder_watch_params_t params = usual(0.0, 0.0f);
        params.saliency = known != 0 ? (float)apart : 0.0f;
        const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
        const double omega = 20.0;
        double theta = 0.05;
        double along = 0.0;
        uint32_t found = 0u;
        encoder_watch_init(&watch, &tuning);
        encoder_watch_begin(&watch, (ab_t){0.0f, 0.0f});
        for (uint32_t window = 0; window < 60u; window++) {
            const double complex first = along * cexp(J * theta);
            const double complex flux = ((L - apart) * along + PSI) * cexp(J * theta);
            along += window >= 20u && window < 32u ? 3.0 : 0.0;
            theta += omega * EVERY * T;
            const double complex last = along * cexp(J * theta);
            const double complex now = ((L - apart) * along + PSI) * cexp(J * theta);
            encoder_watch_add(&watch, to_ab((now - flux) / T + 0.5 * EVERY * R * (first + last)));
            const encoder_watch_input_t input = {.current = to_ab(last),
                                                 .encoder = {(float)sin(theta), (float)cos(theta)},
                                                 .omega_e = (float)omega};
            found |= encoder_watch_step(&watch, &input);
        }
        TEST_ASSERT_EQUAL_UINT32(known != 0 ? 0u : ENCODER_WATCH_MISMATCH, found);
    }
}

/* The q axis saturates: psi_q = L i_q/(1 + i_q/8 A). A rotor turns slowly while i_q rises by 1.5 A in each of
 * twelve windows. With a constant L the first of them makes 12.5 mH (1.5 - 1.26) A/0.8 ms = 4 V, and the last
 * one 21 V. If the watch knows L_q at the present current, the encoder agrees with the EMF; if not, the watch
 * reports a mismatch. */
static void test_a_current_through_an_axis_that_saturates_is_no_sign(void)
{
    for (int32_t known = 0; known < 2; known++) {
        setUp();
        const double omega = 20.0;
        double theta = 0.05;
        double across = 0.0;
        uint32_t found = 0u;
        encoder_watch_begin(&watch, (ab_t){0.0f, 0.0f});
        for (uint32_t window = 0; window < 60u; window++) {
            const double complex first = J * across * cexp(J * theta);
            const double complex flux = (J * L / (1.0 + across / 8.0) * across + PSI) * cexp(J * theta);
            across += window >= 20u && window < 32u ? 1.5 : 0.0;
            theta += omega * EVERY * T;
            const double excess = L / (1.0 + across / 8.0) - L;
            const double complex last = J * across * cexp(J * theta);
            const double complex now = (J * (L + excess) * across + PSI) * cexp(J * theta);
            encoder_watch_add(&watch, to_ab((now - flux) / T + 0.5 * EVERY * R * (first + last)));
            const encoder_watch_input_t input = {.current = to_ab(last),
                                                 .encoder = {(float)sin(theta), (float)cos(theta)},
                                                 .omega_e = (float)omega,
                                                 .excess = known != 0 ? (float)excess : 0.0f};
            found |= encoder_watch_step(&watch, &input);
        }
        TEST_ASSERT_EQUAL(known != 0, found == 0u);
    }
}

/* 6 A flow along the magnet of a salient rotor when the encoder begins to control it, and L_q - L_d changes
 * by a tenth later. 4 mH 6 A/0.8 ms are 30 V; the noise is so large that the EMF is a low-pass, which would
 * remember them for longer than a sign must last. Neither is an EMF. */
static void test_a_current_before_the_first_window_is_no_emf(void)
{
    const double apart = 4e-3; /* L_q - L_d [H] */
    encoder_watch_params_t params = usual(1.0, 0.0f);
    params.saliency = (float)apart;
    encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    const double omega = 20.0;
    const double along = 6.0; /* i_d [A] */
    const double flux = (L - apart) * along + PSI;
    memset(&watch, 0x55, sizeof watch);
    encoder_watch_init(&watch, &tuning);
    encoder_watch_rest(&watch);
    encoder_watch_begin(&watch, to_ab(along * cexp(J * 0.05)));
    double theta = 0.05;
    for (uint32_t window = 0; window < 60u; window++) {
        if (window == 30u) {
            params.saliency = (float)(0.9 * apart);
            tuning = encoder_watch_prepare(&params);
            encoder_watch_take(&watch, &tuning);
        }
        const double complex before = cexp(J * theta);
        theta += omega * EVERY * T;
        const double complex now = cexp(J * theta);
        encoder_watch_add(&watch,
                          to_ab(flux * (now - before) / T + 0.5 * EVERY * R * along * (now + before)));
        const encoder_watch_input_t input = {.current = to_ab(along * now),
                                             .encoder = {(float)sin(theta), (float)cos(theta)},
                                             .omega_e = (float)omega};
        TEST_ASSERT_EQUAL_UINT32(0u, encoder_watch_step(&watch, &input));
        TEST_ASSERT_DOUBLE_WITHIN(1.0, PSI * omega, (double)watch.judged.q);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.0, (double)watch.judged.d);
    }
}

/* Three standard deviations of the mean of two windows are 3 sqrt(2) L n/(2 n_w T). If psi_f omega_least is
 * smaller than this, the EMF is that of a low-pass with a quarter, whose noise is sqrt(2/28)/sqrt(1/2) =
 * 0.378 of this: a window contains the noise of its end and the opposite of that of its beginning. If psi_f
 * omega_least were smaller than this noise as well, noise would be judged. */
static void test_noise_in_an_emf_is_not_judged(void)
{
    const double quiet = (double)prepared(0.0, 0.0f).emf_least;
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * quiet, PSI * LEAST, quiet);
    /* Makes five times the EMF of omega_least. */
    const double noise = 5.0 * PSI * LEAST * EVERY * T / (3.0 * 0.70711 * L);
    const double left = 5.0 * sqrt(2.0 / 28.0) / sqrt(0.5);
    const encoder_watch_tuning_t noisy = prepared(noise, 0.0f);
    TEST_ASSERT_DOUBLE_WITHIN(0.005 * quiet, left * quiet, (double)noisy.emf_least);
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * quiet, left * quiet * 8e-3 / (EVERY * T), (double)noisy.holds);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * quiet, quiet, (double)prepared(0.4 * noise, 0.0f).emf_least);
}

static uint32_t judged(double said)
{
    const encoder_watch_input_t input = {.current = current,
                                         .encoder = {(float)sin(encoder), (float)cos(encoder)},
                                         .omega_e = (float)said,
                                         .emf = observed,
                                         .lacks = lacks,
                                         .doubtful = is_doubtful};
    return encoder_watch_step(&watch, &input);
}

/* One judgement without current, with a rotor at omega [rad/s] whose EMF is `share` of psi_f omega, and an
 * encoder that shows `said` [rad/s]. */
static uint32_t judge(double omega, double share, double said)
{
    for (uint32_t n = 0; n < EVERY; n++) {
        const double e = share * PSI * omega;
        const double middle = rotor + 0.5 * T * omega;
        encoder_watch_add(&watch, (ab_t){(float)(-e * sin(middle)), (float)(e * cos(middle))});
        rotor += T * omega;
        encoder += T * said;
    }
    observed = to_ab(share * PSI * omega * J * cexp(J * rotor));
    return judged(said);
}

static void settle(double omega)
{
    for (uint32_t n = 0; n < 100u; n++) {
        TEST_ASSERT_EQUAL_HEX32(0u, judge(omega, 1.0, omega));
    }
}

/* The number of judgements until a condition is detected, which is in `bits`; 0 if none is detected in 0.8
 * s. */
static uint32_t noticed(double omega, double share, double said)
{
    for (uint32_t n = 1; n <= 1000u; n++) {
        bits = judge(omega, share, said);
        if (bits != 0u) {
            return n;
        }
    }
    return 0u;
}

/* Returns true if the watch detects an encoder that is wrong by half a turn, at this speed and with this
 * current along alpha. */
static bool is_noticed(double omega, float alpha)
{
    begin(0.0, 0.2f);
    current.alpha = alpha;
    rotor += PI;
    return noticed(omega, 1.0, omega) != 0u;
}

/* If almost no current flows, the assumed sign may be wrong, and the voltage of the dead time is up to
 * twice the assumed one. */
static void test_without_a_current_twice_as_large_an_emf_is_judged(void)
{
    for (int way = -1; way <= 1; way += 2) {
        TEST_ASSERT_FALSE(is_noticed(way * 1.9 * LEAST, 0.0f));
        TEST_ASSERT_FALSE(is_noticed(way * 1.9 * LEAST, 0.19f));
        TEST_ASSERT_TRUE(is_noticed(way * 1.9 * LEAST, 0.21f));
        TEST_ASSERT_TRUE(is_noticed(way * 2.1 * LEAST, 0.0f));
    }
}

/* At 1.9 psi_f omega_least the sign must last for 8/0.8/1.9 = 5.3 judgements, six. The current passes the
 * limit in every second window. Those below it neither add to the sum nor halve it. */
static void test_windows_without_a_current_do_not_count_against_the_others(void)
{
    for (int way = -1; way <= 1; way += 2) {
        begin(0.0, 0.2f);
        rotor += PI;
        uint32_t flows = 0u;
        uint32_t put_off = 0u;
        uint32_t found = 0u;
        for (uint32_t n = 0; n < 200u && found == 0u; n++) {
            const uint32_t waited = watch.waited;
            current.alpha = n % 2u == 0u ? 0.21f : 0.19f;
            found = judge(way * 1.9 * LEAST, 1.0, way * 1.9 * LEAST);
            const bool counts = n >= watch.tuning.settles && n % 2u == 0u;
            flows += counts ? 1u : 0u;
            put_off += counts && watch.waited > waited ? 1u : 0u;
        }
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, found);
        TEST_ASSERT_EQUAL_UINT32(6u, flows - put_off);
    }
}

/* The share of windows [-], over ten turns at 240 rad/s, in which both conditions hold: the EMF in the
 * frame of an encoder that is wrong by `off` [rad] differs much from the rotor's, and the difference is
 * along the axis of no phase. */
static double elsewhere_share(double off)
{
    uint32_t count = 0u;
    setUp();
    settle(240.0);
    encoder += off;
    const uint32_t windows = (uint32_t)(10.0 * 2.0 * PI / (240.0 * T * EVERY));
    for (uint32_t n = 0; n < windows; n++) {
        (void)judge(240.0, 1.0, 240.0);
        count += watch.elsewhere;
    }
    return (double)count / (double)windows;
}

/* The difference of the two EMFs has the length 2 sin(off/2) and rotates with the rotor. The sine of three
 * times its angle to the nearest phase axis is below 0.4 for a share of 0.26 of the turn. */
static void test_an_encoder_that_is_off_puts_the_emf_beside_all_axes(void)
{
    for (int way = -1; way <= 1; way += 2) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, elsewhere_share(way * 0.28));
        TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.74, elsewhere_share(way * 0.32));
        TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.74, elsewhere_share(way * 1.0));
    }
}

/* A broken wire adds an EMF along the axis of its phase, in this test b. At rest nothing is known. */
static void test_an_emf_that_is_wrong_along_a_phase_is_not_elsewhere(void)
{
    settle(240.0);
    for (uint32_t n = 0; n < 60u; n++) {
        encoder_watch_add(&watch, (ab_t){(float)(-0.5 * EVERY * 40.0), (float)(0.8660254 * EVERY * 40.0)});
        (void)judge(240.0, 1.0, 240.0);
        TEST_ASSERT_EQUAL_UINT32(0u, watch.elsewhere);
    }
    encoder += 1.0;
    while (watch.elsewhere == 0u) {
        (void)judge(240.0, 1.0, 240.0);
    }
    encoder_watch_rest(&watch);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.elsewhere);
}

/* The number of judgements until a condition is detected, without those that are postponed. */
static uint32_t counted(double omega, double share, double said)
{
    uint32_t put_off = 0;
    for (uint32_t n = 1; n <= 1000u; n++) {
        const uint32_t waited = watch.waited;
        bits = judge(omega, share, said);
        put_off += watch.waited > waited ? 1u : 0u;
        if (bits != 0u) {
            return n - put_off;
        }
    }
    return 0u;
}

static void expect(uint32_t bit, uint32_t judgements, double omega, double share, double said)
{
    TEST_ASSERT_EQUAL_UINT32(judgements, counted(omega, share, said));
    TEST_ASSERT_EQUAL_HEX32(bit, bits);
}

static void test_a_correct_encoder_is_not_reported(void)
{
    static const double speeds[] = {0.0, 5.0, 59.0, 61.0, 240.0, 1200.0, 3000.0, 4000.0, 7854.0, 11500.0};
    for (int n = 0; n < 20; n++) {
        const double omega = n < 10 ? speeds[n] : -speeds[n - 10];
        setUp();
        TEST_ASSERT_EQUAL_UINT32(0u, noticed(omega, 1.0, omega));
    }
}

/* The cosine of 36.87 degrees is 0.8. At 7854 rad/s the rotor turns once in a window, and its mean EMF is
 * zero. */
static void test_the_angle_may_be_off_by_less_than_37_degrees(void)
{
    static const double speeds[] = {240.0, -240.0, 7300.0, -7300.0};
    for (int n = 0; n < 8; n++) {
        const double omega = speeds[n % 4];
        const double degrees = n < 4 ? 1.0 : -1.0;
        setUp();
        settle(omega);
        encoder += degrees * 36.0 * PI / 180.0;
        TEST_ASSERT_EQUAL_UINT32(0u, noticed(omega, 1.0, omega));
        encoder += degrees * 2.0 * PI / 180.0;
        TEST_ASSERT_GREATER_THAN_UINT32(0u, noticed(omega, 1.0, omega));
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
    }
}

/* The limit is 8 ms of psi_f omega_least as an integral of the voltage: ten judgements at 61 rad/s, five
 * at 120 rad/s, three from 200 rad/s on. */
static void test_the_larger_the_emf_the_sooner_it_is_assumed(void)
{
    static const struct {
        double omega;
        uint32_t judgements;
    } cases[] = {{61.0, 10u}, {121.0, 5u}, {151.0, 4u}, {201.0, 3u}, {1200.0, 3u}};
    for (int n = 0; n < 5; n++) {
        for (int turn = -1; turn <= 1; turn += 2) {
            setUp();
            settle(turn * cases[n].omega);
            encoder += PI;
            expect(ENCODER_WATCH_MISMATCH, cases[n].judgements, turn * cases[n].omega, 1.0,
                   turn * cases[n].omega);
        }
    }
}

/* The mean of the first judgement is that of one window with the whole EMF and one with 0.24 of it. */
static void test_an_encoder_that_turns_without_an_emf_is_wrong(void)
{
    for (int turn = -1; turn <= 1; turn += 2) {
        setUp();
        settle(turn * 240.0);
        expect(ENCODER_WATCH_MISMATCH, 4u, turn * 240.0, 0.24, turn * 240.0);
        TEST_ASSERT_EQUAL_UINT32(1u, counted(0.0, 0.0, turn * 240.0));
        setUp();
        settle(turn * 240.0);
        TEST_ASSERT_EQUAL_UINT32(0u, noticed(turn * 240.0, 0.26, turn * 240.0));
    }
}

/* A rotor turns at 240 rad/s, by 11 degrees in a window, while its encoder stands or nearly so. The mean of
 * two windows is off the q axis by 11, 22 and 33 degrees at the second, third and fourth judgement. These
 * count half, because the EMF is longer than three times that of the encoder's speed; the later ones, off by
 * more than 37 degrees, count whole. One of them, or two, are within 10 degrees of the axis of a phase, 30
 * degrees from the q axis, and are postponed. Three are complete in the sixth window. */
static void test_an_emf_without_a_speed_of_the_encoder_is_wrong_before_it_has_turned(void)
{
    static const double said[] = {0.0, 1e-3, -1e-3, 0.05};
    for (size_t n = 0; n < sizeof said / sizeof said[0]; n++) {
        for (int turn = 1; turn >= -1; turn -= 2) {
            setUp();
            settle(turn * 240.0);
            TEST_ASSERT_EQUAL_UINT32(6u, noticed(turn * 240.0, 1.0, turn * 240.0 * said[n]));
            TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
        }
    }
}

/* Along the q axis it counts half, whatever the sign of a speed near zero: six judgements instead of three. A
 * sensor error whose EMF grows with the current causes an overcurrent before. */
static void test_a_long_emf_that_does_not_turn_needs_six_judgements(void)
{
    for (int turn = -1; turn <= 1; turn += 2) {
        setUp();
        settle(0.0);
        uint32_t windows = 0u;
        uint32_t found = 0u;
        while (found == 0u && windows < 100u) {
            const double e = EVERY * 60.0;
            encoder_watch_add(&watch, (ab_t){(float)(-e * sin(encoder)), (float)(e * cos(encoder))});
            found = judged(windows % 2u == 0u ? turn * 0.01 : turn * -0.01);
            windows++;
        }
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, found);
        TEST_ASSERT_EQUAL_UINT32(6u, windows);
    }
}

/* A configured psi_f that is too small by less than a factor of three makes the EMF too long, but the encoder
 * is right. */
static void test_a_magnet_that_is_stronger_than_configured_is_no_error_of_the_encoder(void)
{
    static const double speeds[] = {20.0, 61.0, 240.0, 1200.0};
    for (int n = 0; n < 8; n++) {
        const double omega = n < 4 ? speeds[n] : -speeds[n - 4];
        setUp();
        TEST_ASSERT_EQUAL_UINT32(0u, noticed(omega, 2.9, omega));
    }
}

/* The encoder counts in the other direction, and the runs begin at 24 angles between encoder and rotor.
 * The difference of the two EMFs does not rotate. At some of these angles it is along the axis of a phase. */
static void test_an_encoder_that_counts_the_other_way_is_detected_by_its_direction(void)
{
    static const double speeds[] = {90.0, 240.0, 628.0, 900.0};
    for (int n = 0; n < 8; n++) {
        const double omega = n < 4 ? speeds[n] : -speeds[n - 4];
        for (int at = 0; at < 24; at++) {
            setUp();
            encoder += at * PI / 12.0;
            TEST_ASSERT_GREATER_THAN_UINT32(0u, noticed(omega, 1.0, -omega));
            TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_DIRECTION, bits);
        }
    }
}

/* 6 ms are seven and a half windows, to which three judgements are added. */
static void test_after_a_rest_the_current_sensors_are_judged_first(void)
{
    settle(240.0);
    encoder += PI;
    encoder_watch_rest(&watch);
    expect(ENCODER_WATCH_MISMATCH, 11u, 240.0, 1.0, 240.0);
}

/* A winding with R and L, solved in double precision in steps of 1 us with a voltage that changes the
 * current. The voltage less the drops at R and L must be the mean EMF, whose length is reduced by
 * sin(x)/x, x = omega T_j/2. The mean current is taken as the middle of its ends; a change of its rate
 * makes an error of up to 60 V/L T_j/12 = 0.3 A. */
static void test_the_emf_is_what_resistance_and_inductance_leave_of_the_voltage(void)
{
    const double omega = 628.0;
    double i_alpha = 3.0;
    double i_beta = -2.0;
    current = (ab_t){(float)i_alpha, (float)i_beta};
    (void)judged(omega);
    for (uint32_t n = 0; n < EVERY; n++) {
        const ab_t voltage = {40.0f, -70.0f};
        for (int m = 0; m < 100; m++) {
            const double e = PSI * omega;
            i_alpha += 1e-6 / L * ((double)voltage.alpha - R * i_alpha + e * sin(rotor));
            i_beta += 1e-6 / L * ((double)voltage.beta - R * i_beta - e * cos(rotor));
            rotor += 1e-6 * omega;
        }
        encoder_watch_add(&watch, voltage);
    }
    encoder = rotor;
    current = (ab_t){(float)i_alpha, (float)i_beta};
    (void)judged(omega);
    const double x = 0.5 * omega * EVERY * T;
    TEST_ASSERT_DOUBLE_WITHIN(0.3 * R + 0.05, PSI * omega * sin(x) / x, (double)watch.last.q);
    TEST_ASSERT_DOUBLE_WITHIN(0.3 * R + 0.05, 0.0, (double)watch.last.d);
}

/* Current noise of 0.5 A rms for 10 ms makes 5.5 and 7 V rms in the mean of two windows. The EMF is 11.5 V
 * at 150 r/min in one case and zero in the other: at most one of a thousand bursts may be taken for a
 * sign. */
static bool burst_is_a_sign(double omega)
{
    uint32_t seen = 0u;
    setUp();
    settle(omega);
    for (int n = 0; n < 13; n++) {
        const double i_a = 0.5 * scatter_gauss();
        const double i_b = 0.5 * scatter_gauss();
        current = (ab_t){(float)i_a, (float)((i_a + 2.0 * i_b) / sqrt(3.0))};
        seen |= judge(omega, 1.0, omega);
    }
    current = (ab_t){0.0f, 0.0f};
    for (int n = 0; n < 20; n++) {
        seen |= judge(omega, 1.0, omega);
    }
    return seen != 0u;
}

static void test_a_burst_of_noise_is_not_a_sign(void)
{
    int alarms = 0;
    for (int burst = 0; burst < 1000; burst++) {
        alarms += burst_is_a_sign(burst % 3 == 0 ? 0.0 : burst % 3 == 1 ? 62.8 : -62.8) ? 1 : 0;
    }
    TEST_ASSERT_TRUE(alarms <= 1);
}

static bool jumped(float missed)
{
    const encoder_t sampled = {.missed = missed};
    return encoder_jumped(&sampled, watch.tuning.leap);
}

static void test_an_angle_that_jumps_by_more_than_a_rotor_can_is_reported_at_once(void)
{
    TEST_ASSERT_FALSE(jumped(0.5049f));
    TEST_ASSERT_FALSE(jumped(-0.5049f));
    TEST_ASSERT_TRUE(jumped(0.5051f));
    TEST_ASSERT_TRUE(jumped(-0.5051f));
}

/* 0.5 s are 625 judgements of 0.8 ms. At the EMF of 1200 rad/s three judgements are enough. */
static void test_at_a_doubtful_emf_the_judgement_waits_half_a_second(void)
{
    settle(1200.0);
    rotor += 1.0;
    is_doubtful = true;
    TEST_ASSERT_EQUAL_UINT32(625u + 3u, noticed(1200.0, 1.0, 1200.0));
    TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
}

/* Two judgements have seen the sign when the EMF becomes uncertain; the third judgement follows after
 * that. */
static void test_what_was_seen_before_a_doubt_stays(void)
{
    settle(1200.0);
    rotor += 1.0;
    while (watch.count < 2u * 2u) { /* in halves */
        TEST_ASSERT_EQUAL_HEX32(0u, judge(1200.0, 1.0, 1200.0));
    }
    is_doubtful = true;
    for (uint32_t n = 0; n < 10u; n++) {
        TEST_ASSERT_EQUAL_HEX32(0u, judge(1200.0, 1.0, 1200.0));
    }
    is_doubtful = false;
    expect(ENCODER_WATCH_MISMATCH, 1u, 1200.0, 1.0, 1200.0);
}

/* The result of a judgement if `volts` are added in the direction `axis` [rad] to the EMF of a rotor whose
 * encoder is right. */
static uint32_t judge_with(double omega, double volts, double axis)
{
    encoder_watch_add(&watch, (ab_t){(float)(EVERY * volts * cos(axis)), (float)(EVERY * volts * sin(axis))});
    return judge(omega, 1.0, omega);
}

/* 100 V are added to the 44 V of 240 rad/s, for which a sign must last for six judgements. Along the axis
 * of each phase, in either direction and up to 7 degrees beside it, they are treated as a fault of a wire
 * or a leg, and the judgement is postponed for half a second. In the middle between two axes there is no
 * such postponement. */
static void test_an_emf_that_is_wrong_along_a_phase_is_a_wire_and_waits(void)
{
    for (int n = 0; n < 12; n++) {
        const double axis = PI / 6.0 * n + (n % 2 == 0 ? 7.0 : 0.0) * PI / 180.0;
        uint32_t judgements = 0u;
        uint32_t of_a_phase = 0u;
        setUp();
        settle(240.0);
        for (; judgements < 60u && judge_with(240.0, 100.0, axis) == 0u; judgements++) {
            of_a_phase += watch.of_a_phase;
        }
        if (n % 2 == 0) {
            TEST_ASSERT_EQUAL_UINT32(60u, judgements);
            TEST_ASSERT_GREATER_THAN_UINT32(20u, of_a_phase);
        } else {
            TEST_ASSERT_LESS_THAN_UINT32(24u, judgements);
            TEST_ASSERT_EQUAL_UINT32(0u, of_a_phase);
        }
        (void)judge(240.0, 1.0, 240.0);
        (void)judge(240.0, 1.0, 240.0);
        TEST_ASSERT_EQUAL_UINT32(0u, watch.of_a_phase);
    }
}

/* An open switch that carries 3 A: the voltage that is missing behind it opposes this current, which becomes
 * shorter than the request. The judgement is postponed for the 16 judgements in which the current watch
 * reports it. The same difference is not that of a switch if the current follows its request, exceeds it, or
 * is driven by the difference. */
static void test_a_difference_that_prevents_a_current_is_that_of_a_switch(void)
{
    static const struct {
        double current, lacks; /* [A] along the difference */
        bool open;
    } cases[] = {{3.0, 0.39, true},
                 {3.0, 0.36, false},
                 {3.0, -0.39, false},
                 {-3.0, -0.39, false},
                 {-3.0, 0.39, false}};
    for (size_t n = 0; n < 6u * sizeof cases / sizeof cases[0]; n++) {
        const double axis = PI / 3.0 * (double)(n % 6u);
        uint32_t judgements = 0u;
        setUp();
        settle(240.0);
        current = to_ab(cases[n / 6u].current * cexp(J * axis));
        lacks = to_ab(cases[n / 6u].lacks * cexp(J * axis));
        encoder_watch_begin(&watch, current);
        while (judgements < 16u && judge_with(240.0, 100.0, axis) == 0u) {
            judgements++;
        }
        TEST_ASSERT_EQUAL(cases[n / 6u].open, judgements == 16u);
    }
}

/* Begins with these coefficients, and with rotor and encoder at this angle [rad]. */
static void begin_at(const encoder_watch_tuning_t *tuning, double angle)
{
    setUp();
    encoder_watch_take(&watch, tuning);
    bits = 0u;
    rotor = encoder = angle;
}

/* A wire is open while the rotor is at standstill and no current is requested: the voltage of its phase
 * swings between 18 and 26 V, around twice psi_f omega_least, and is too long for the EMF of the encoder's
 * speed. On the axis of a phase this is never the encoder, also if the q axis lies there, but the wire after
 * half a second. In the middle between two axes the encoder is reported. */
static void test_a_voltage_around_the_least_emf_of_no_current_is_that_of_a_wire(void)
{
    encoder_watch_params_t params = usual(0.0, 1.5f);
    params.unseen = 100.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 12; n++) {
        const double axis = PI / 6.0 * n;
        uint32_t judgements = 0u;
        begin_at(&tuning, axis - 0.5 * PI);
        for (; judgements < 1000u && bits == 0u; judgements++) {
            bits = judge_with(0.0, judgements % 8u < 4u ? 18.0 : 26.0, axis);
        }
        TEST_ASSERT_EQUAL_HEX32(n % 2 == 0 ? ENCODER_WATCH_WIRE : ENCODER_WATCH_MISMATCH, bits);
        TEST_ASSERT_TRUE(n % 2 == 0 ? judgements > 600u : judgements < 60u);
    }
}

/* The noise of a window's EMF is 10 V: three standard deviations of the mean of two windows are 21 V, those
 * of the low-pass 8 V. An encoder that is wrong by 60 degrees is reported although the EMF is only 15 V; the
 * same noise in a right encoder is not, and neither is an EMF within the noise, 6 V. */
static void test_an_emf_beyond_the_noise_of_the_low_pass_is_judged(void)
{
    encoder_watch_params_t params = usual(0.0, 0.0f);
    params.noise = (float)(10.0 * EVERY * T / (sqrt(2.0) * L));
    params.speed_least = 20.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    static const struct {
        double emf, wrong; /* [V], [rad] */
        bool reported;
    } cases[] = {
        {15.0, PI / 3.0, true}, {-15.0, -PI / 3.0, true}, {15.0, 0.0, false}, {6.0, PI / 3.0, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        const double omega = cases[n].emf / PSI;
        const uint32_t most = cases[n].reported ? 60u : 5000u;
        uint32_t judgements = 0u;
        begin_at(&tuning, 0.3);
        encoder += cases[n].wrong;
        for (; judgements < most && bits == 0u; judgements++) {
            const double i_alpha = (double)params.noise * scatter_gauss();
            const double i_beta = (double)params.noise * scatter_gauss();
            current = (ab_t){(float)i_alpha, (float)i_beta};
            bits = judge(omega, 1.0, omega);
        }
        TEST_ASSERT_EQUAL_HEX32(cases[n].reported ? ENCODER_WATCH_MISMATCH : 0u, bits);
    }
}

/* An open wire adds a voltage along the axis of its phase, with the cosine of the rotor's angle. psi_f is
 * configured a third too large: 44 V less 33 V of the true EMF are the error of the difference. At first it
 * is beside 100 V, which are 6 degrees, and after half a turn beside 40 V, 15 degrees. The currents are too
 * small to show a wire. The difference that returns to its axis is no wrong encoder. */
static void test_a_wire_returns_to_its_axis_with_a_wrong_psi(void)
{
    encoder_watch_params_t params = usual(0.0, 0.0f);
    params.unseen = 100.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 6; n++) {
        begin_at(&tuning, PI / 3.0 * n);
        const double axis = PI * 2.0 / 3.0 * (n % 3);
        for (int k = 0; k < 1000; k++) {
            const double volts = (k < 20 ? 100.0 : 40.0) * cos(rotor - axis);
            encoder_watch_add(&watch,
                              (ab_t){(float)(EVERY * volts * cos(axis)), (float)(EVERY * volts * sin(axis))});
            TEST_ASSERT_EQUAL_HEX32(0u, judge(240.0, 0.75, 240.0) & ~ENCODER_WATCH_WIRE);
        }
    }
}

/* An encoder that counts the other way round makes the difference of two EMFs that turn against each other.
 * It lies along one line, which depends on the angle at which both agree: here along the axis of a phase.
 * Noise hides in which direction the EMF turns. The current of the drive, which turns with the encoder, flows
 * in this phase, so that its wire is not open, and the encoder is reported. Without current nothing
 * distinguishes both, and the judgement waits. */
static void test_a_difference_along_a_phase_that_carries_a_current_is_no_wire(void)
{
    encoder_watch_params_t params = usual(0.0, 0.2f);
    params.unseen = 100.0f;
    encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    tuning.turn_noise = 1e12f;
    for (int n = 0; n < 12; n++) {
        const double axis = PI / 3.0 * (n % 6);
        uint32_t judgements = 0u;
        begin_at(&tuning, axis + 0.5 * PI);
        for (; judgements < 100u && bits == 0u; judgements++) {
            current = to_ab((n < 6 ? 4.0 : 0.0) * J * cexp(J * encoder));
            bits = judge(150.0, 1.0, -150.0);
        }
        TEST_ASSERT_EQUAL_HEX32(n < 6 ? ENCODER_WATCH_MISMATCH : 0u, bits);
        TEST_ASSERT_TRUE(n < 6 ? judgements < 30u : judgements == 100u);
    }
}

/* An encoder that has slipped by 48 degrees makes a difference of 2 sin(24 deg) psi_f omega = 0.81 psi_f
 * omega, which turns with the rotor. Half of psi_f omega beside its axis is uncertain: with it, and the error
 * of psi_f, every direction may be that of the same phase. Once their mean over 16 windows has reached three
 * quarters of them, after 22 windows, or after 32 postponed judgements of a slow rotor, the differences must
 * lie along a line, and a slipped encoder is reported after the 8 that end the axis, and those of a sign. An
 * open wire of the same voltage stays a wire for as long as the judgement waits, 0.5 s. */
static void test_a_difference_that_turns_is_no_wire_although_its_direction_is_uncertain(void)
{
    encoder_watch_params_t params = usual(0.0, 0.0f);
    params.unseen = 100.0f;
    params.speed_least = 20.0f;
    encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    static const double omegas[] = {370.0, 40.0};
    for (int n = 0; n < 4; n++) {
        const int wire = n % 2;
        const double omega = omegas[n / 2];
        tuning.beside = (float)(0.25 * PSI * omega * PSI * omega);
        setUp();
        encoder_watch_take(&watch, &tuning);
        rotor = 0.0;
        encoder = wire != 0 ? 0.0 : 48.0 * PI / 180.0;
        const double volts = wire != 0 ? 1.2 * PSI * omega : 0.0;
        uint32_t judgements = 0u;
        for (; judgements < 400u; judgements++) {
            if (judge_with(omega, volts * cos(rotor), 2.0 * PI / 3.0) != 0u) {
                break;
            }
        }
        TEST_ASSERT_TRUE(wire != 0 ? judgements == 400u
                                   : judgements >= 22u && judgements <= (n < 2 ? 40u : 130u));
    }
}

/* The EMF of a window has noise of 8 V rms, since its ends are two measured currents: the 40 V of an open
 * wire are up to 36 degrees beside their axis in single windows. The rotor hardly turns, with its q axis
 * perpendicular to the phase. The mean difference remains on the axis: after half a second the broken wire
 * is reported, and no fault of the encoder. */
static void test_noise_of_the_currents_does_not_hide_a_wire(void)
{
    encoder_watch_params_t params = usual(0.0, 1.5f);
    params.noise = (float)(8.0 * EVERY * T / (sqrt(2.0) * L));
    params.unseen = 100.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 6; n++) {
        uint32_t judgements = 0u;
        begin_at(&tuning, PI / 3.0 * n);
        for (; judgements < 1000u && bits == 0u; judgements++) {
            const double i_alpha = (double)params.noise * scatter_gauss();
            const double i_beta = (double)params.noise * scatter_gauss();
            current = (ab_t){(float)i_alpha, (float)i_beta};
            bits = judge_with(0.5, 40.0, PI / 3.0 * n + 5.0 * PI / 180.0);
        }
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_WIRE, bits);
        TEST_ASSERT_GREATER_THAN_UINT32(600u, judgements);
    }
}

/* The same noise while 4 A flow across the axis of a phase without current, in which the current watch sees
 * no request. Less than 1.5 A, three standard deviations and more, are no current. Noise of 2 V in the mean
 * of four windows, a quarter of 8 V, turns 25 V by up to 13 degrees, three standard deviations. This is
 * reported as the broken wire. */
static void test_noise_does_not_hide_a_wire_beside_which_a_current_flows(void)
{
    encoder_watch_params_t params = usual(0.0, 1.5f);
    params.noise = (float)(8.0 * EVERY * T / (sqrt(2.0) * L));
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 24; n++) {
        const double axis = PI / 3.0 * n;
        uint32_t judgements = 0u;
        begin_at(&tuning, axis);
        for (; judgements < 1000u && bits == 0u; judgements++) {
            const double i_alpha = (double)params.noise * scatter_gauss() - 4.0 * sin(axis);
            const double i_beta = (double)params.noise * scatter_gauss() + 4.0 * cos(axis);
            current = (ab_t){(float)i_alpha, (float)i_beta};
            bits = judge_with(0.5, 25.0, axis);
        }
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_WIRE, bits);
        TEST_ASSERT_GREATER_THAN_UINT32(100u, judgements);
    }
}

/* A difference of 12 V along the axis of a phase begins with 6.5 V across it, an error of the voltage, and is
 * 28 degrees beside the axis. It grows to 200 V, beside which no error remains, and does not turn: it is that
 * of a wire. */
static void test_the_known_axis_follows_a_longer_difference(void)
{
    encoder_watch_params_t params = usual(0.0, 0.0f);
    params.unseen = 100.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 12; n++) {
        const double axis = PI / 3.0 * (n % 6);
        const double error = n < 6 ? 6.5 : -6.5;
        uint32_t judgements = 0u;
        begin_at(&tuning, axis);
        for (; judgements < 1000u && bits == 0u; judgements++) {
            const double along = judgements < 30u ? 12.0 : fmin(12.0 + 2.0 * (judgements - 30.0), 200.0);
            const double across = along < 60.0 ? error : 0.0;
            bits = judge_with(0.5, hypot(along, across), axis + atan2(across, along));
        }
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_WIRE, bits);
        TEST_ASSERT_GREATER_THAN_UINT32(600u, judgements);
    }
}

/* A psi_f that is wrong by a fifth puts the difference of an open wire, which is hardly longer than the EMF,
 * up to 9.5 degrees beside the axis of the phase. It does not turn, and is that of a wire. One that is 11
 * degrees beside it is that of an encoder. */
static void test_a_wrong_psi_puts_a_wire_beside_its_axis(void)
{
    const encoder_watch_tuning_t tuning = prepared(0.0, 0.0f);
    for (int n = 0; n < 24; n++) {
        const bool wire = n < 12;
        const double aside = (n % 2 != 0 ? -1.0 : 1.0) * (wire ? 9.5 : 11.0) * PI / 180.0;
        const double axis = PI / 3.0 * (n / 2 % 6);
        uint32_t judgements = 0u;
        begin_at(&tuning, axis);
        for (; judgements < 1000u && bits == 0u; judgements++) {
            bits = judge_with(0.5, 25.0, axis + aside);
        }
        TEST_ASSERT_EQUAL_HEX32(wire ? ENCODER_WATCH_WIRE : ENCODER_WATCH_MISMATCH, bits);
        TEST_ASSERT_TRUE(wire ? judgements > 600u : judgements < 20u);
    }
}

/* The EMF is 1.1 times psi_f omega_least and 50 degrees off. The difference is 2 sin(25 degrees) of the
 * EMF, 0.93 psi_f omega_least, which an error of the voltage could make as well. With an EMF of 1.4 times
 * psi_f omega_least the difference is 1.18 times, which is reported. */
static void test_a_difference_below_the_least_emf_may_be_a_wrong_voltage(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        encoder += way * 50.0 * PI / 180.0;
        TEST_ASSERT_EQUAL_UINT32(0u, noticed(1.1 * LEAST, 1.0, 1.1 * LEAST));
        TEST_ASSERT_GREATER_THAN_UINT32(0u, noticed(1.4 * LEAST, 1.0, 1.4 * LEAST));
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
    }
}

/* A motor with a large EMF at a low speed, 90 V at 30 rad/s. The encoder slips by 140 degrees in one
 * period: between two windows the EMF has rotated by more than a quarter of a turn, which would be 1250
 * rad/s in either direction. From then on it rotates with the encoder. */
static void test_the_step_of_a_slip_is_not_a_direction(void)
{
    encoder_watch_params_t params = usual(0.0, 0.0f);
    params.flux_linkage = 3.0f;
    params.speed_least = 4.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 48; n++) {
        setUp();
        encoder_watch_take(&watch, &tuning);
        rotor = encoder = n * PI / 24.0;
        const double share = 3.0 / PSI;
        for (int k = 0; k < 100; k++) {
            TEST_ASSERT_EQUAL_HEX32(0u, judge(30.0, share, 30.0));
        }
        encoder += (n % 2 == 0 ? 140.0 : -140.0) * PI / 180.0;
        TEST_ASSERT_GREATER_THAN_UINT32(0u, noticed(30.0, share, 30.0));
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
    }
}

/* An EMF contradicts a speed if it is below 0.6 of psi_f omega: the EMF of 100 rad/s may be that of a
 * rotor at up to 167 rad/s. If the sensor of the link reads 40 % too little, the EMF still agrees with the
 * speed of the encoder. */
static void test_an_emf_denies_a_speed_for_which_it_is_too_short(void)
{
    TEST_ASSERT_FALSE(encoder_watch_denies(&watch, 1000.0f)); /* nothing is known yet */
    settle(100.0);
    for (int way = -1; way <= 1; way += 2) {
        TEST_ASSERT_FALSE(encoder_watch_denies(&watch, (float)way * 165.0f));
        TEST_ASSERT_TRUE(encoder_watch_denies(&watch, (float)way * 169.0f));
    }
    encoder_watch_rest(&watch);
    TEST_ASSERT_TRUE(encoder_watch_denies(&watch, 169.0f)); /* in the period of the stop */
    encoder_watch_forget(&watch);
    TEST_ASSERT_FALSE(encoder_watch_denies(&watch, 169.0f));
    setUp();
    for (int n = 0; n < 10; n++) {
        (void)judge(200.0, 0.5, 200.0);
    }
    TEST_ASSERT_FALSE(encoder_watch_denies(&watch, 280.0f));
    TEST_ASSERT_TRUE(encoder_watch_denies(&watch, 290.0f));
    setUp(); /* at 2500 rad/s the EMF rotates by 2 rad in a window, and sin(1)/1 of its length remains */
    for (int n = 0; n < 10; n++) {
        (void)judge(2500.0, 1.0 / 1.3, 2500.0);
    }
    TEST_ASSERT_FALSE(encoder_watch_denies(&watch, 2600.0f));
}

/* Current noise i_n makes 3 sqrt(2) i_n L/T_j in the EMF of a window, of which a quarter remains in the mean
 * of four, and shifts an error along a phase by at most this. It matters while almost no current flows, in
 * this test less than 0.2 A. 40 V across 200 V along the axis are 11 degrees, of which 8 are allowed without
 * noise; 115.5 V are the middle between two axes. */
static void test_noise_turns_a_false_emf_of_a_wire_by_no_more_than_its_length(void)
{
    static const struct {
        /* [V] three standard deviations of the noise in a window; voltage across the axis. */
        double noise, beside;
        float flows; /* [A] */
        bool waits;
    } cases[] = {{0.0, 40.0, 0.0f, false},
                 {120.0, 40.0, 0.19f, true},
                 {120.0, 40.0, 0.21f, false},
                 {120.0, 115.5, 0.0f, false}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        uint32_t judgements = 0u;
        begin(cases[n].noise * EVERY * T / (3.0 * sqrt(2.0) * L), 0.2f);
        current.alpha = cases[n].flows;
        settle(240.0);
        const double off = hypot(200.0, cases[n].beside);
        const double axis = atan2(cases[n].beside, 200.0);
        for (; judgements < 60u && judge_with(240.0, off, axis) == 0u; judgements++) {
        }
        TEST_ASSERT_EQUAL(cases[n].waits, judgements == 60u);
    }
}

/* The noise limit of the EMF is as high as psi_f omega_least, and almost no current flows. The encoder is
 * wrong by 60 degrees at 140 rad/s: the difference has the length of the EMF, 25.6 V, and turns with the
 * rotor. In the mean of four windows a quarter of 3 sqrt(2) n L/T_j, 5.5 V, may turn it. With half of psi_f
 * omega_least, 5.5 V, and 0.3 psi_f omega, 7.7 V, this is an angle with the square of the sine
 * 0.01 + 2 (5.5^2 + 5.5^2 + 7.7^2)/25.6^2 = 0.37, 38 degrees. The difference leaves each axis, and the
 * encoder is reported within a turn, 56 judgements. */
static void test_noise_does_not_hold_a_difference_that_turns_on_an_axis(void)
{
    encoder_watch_params_t params = usual(0.98 * PSI * LEAST * EVERY * T / (3.0 * 0.70711 * L), 0.2f);
    params.unseen = 100.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 24; n++) {
        const double omega = n % 2 == 0 ? 140.0 : -140.0;
        uint32_t judgements = 0u;
        setUp();
        encoder_watch_take(&watch, &tuning);
        rotor = PI / 12.0 * n;
        encoder = rotor + (n % 4 < 2 ? PI : -PI) / 3.0;
        for (bits = 0u; judgements < 80u && bits == 0u; judgements++) {
            const double i_alpha = (double)params.noise / 3.0 * scatter_gauss();
            const double i_beta = (double)params.noise / 3.0 * scatter_gauss();
            current = (ab_t){(float)i_alpha, (float)i_beta};
            bits = judge(omega, 1.0, omega);
        }
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(56u + tuning.settles, judgements);
    }
}

/* The encoder is wrong by 40 degrees at 950 rad/s, and small currents flow. The difference, 25 V, turns by
 * 0.76 rad from one judgement to the next, which leaves a third of it in the mean of four: less than the sum
 * of the 5.5 V beside the axis and of the wrong psi_f that such a mean may contain. A single window shows
 * that it leaves each axis. */
static void test_a_clear_difference_that_turns_fast_is_no_wire(void)
{
    const double share = 0.21;
    encoder_watch_params_t params = usual(0.0, 0.0f);
    params.flux_linkage = (float)(share * PSI);
    params.speed_least = (float)(LEAST / share);
    params.unseen = 100.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 24; n++) {
        const double omega = n % 2 == 0 ? 950.0 : -950.0;
        uint32_t judgements = 0u;
        setUp();
        encoder_watch_take(&watch, &tuning);
        rotor = PI / 12.0 * n;
        encoder = rotor + (n % 4 < 2 ? 40.0 : -40.0) * PI / 180.0;
        for (bits = 0u; judgements < 80u && bits == 0u; judgements++) {
            bits = judge(omega, share, omega);
        }
        TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(20u + tuning.settles, judgements);
    }
}

/* An open wire adds 15 V along the axis of its phase, between the 11 V of the least EMF and the 22 V with
 * which an EMF is judged while the current is below 0.2 A. The current is above this limit in every third
 * window, so that no two windows in succession are wrong; a phase without current makes the others doubtful.
 * Its axis is known from the first ones: each of them is that of the wire. */
static void test_single_windows_on_a_known_axis_are_of_its_wire(void)
{
    encoder_watch_params_t params = usual(0.0, 0.2f);
    params.unseen = 100.0f;
    const encoder_watch_tuning_t tuning = encoder_watch_prepare(&params);
    for (int n = 0; n < 6; n++) {
        const double axis = PI / 3.0 * n;
        setUp();
        encoder_watch_take(&watch, &tuning);
        rotor = encoder = axis;
        for (int k = 0; k < 300; k++) {
            const double length = k < 20 || k % 3 == 0 ? 0.22 : 0.18;
            current = to_ab(length * cexp(J * (axis + 0.5 * PI)));
            is_doubtful = length < 0.2;
            TEST_ASSERT_EQUAL_HEX32(0u, judge_with(5.0, k < 15 ? 0.0 : 15.0, axis) & ~ENCODER_WATCH_WIRE);
        }
    }
}

/* An EMF that is larger than the noise and on the q axis of the encoder confirms the encoder. */
static void test_an_emf_on_the_axis_confirms_the_encoder(void)
{
    settle(240.0);
    TEST_ASSERT_EQUAL_UINT32(1u, watch.confirmed);
    (void)judge(240.0, -1.0, 240.0);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.confirmed);
    (void)judge(240.0, 1.0, 240.0); /* each earlier sign counts until repeated halving has removed it */
    TEST_ASSERT_EQUAL_UINT32(0u, watch.confirmed);
    for (int n = 0; n < 4; n++) {
        (void)judge(240.0, 1.0, 240.0);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, watch.confirmed);
    encoder_watch_rest(&watch);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.confirmed);
    setUp();
    settle(0.9 * LEAST); /* an EMF that is too short does not confirm the encoder */
    TEST_ASSERT_EQUAL_UINT32(0u, watch.confirmed);
}

/* An EMF that rotates against the encoder and is 1.4 times as long belongs to a rotor whose psi_f is
 * wrong. One of 1.6 may come from a current that runs away, so that it must last for six judgements
 * instead of three. */
static void test_an_emf_too_long_for_the_speed_must_last_twice_as_long(void)
{
    const uint32_t sure = counted(240.0, 1.4, -240.0);
    TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_DIRECTION, bits);
    setUp();
    TEST_ASSERT_EQUAL_UINT32(sure + 3u, counted(240.0, 1.6, -240.0));
    TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_DIRECTION, bits);
}

/* A judgement adds its EMF to a sum, limited to the sum that a sign requires, 10 times psi_f 60 rad/s.
 * Each judgement in which the encoder is right halves the sum. After one wrong judgement at 1200 rad/s and
 * two right ones a quarter remains; the EMF at 61 rad/s adds the rest in 8 judgements. */
static void test_one_large_emf_counts_at_most_as_one_sign(void)
{
    settle(1200.0);
    encoder += PI;
    TEST_ASSERT_EQUAL_HEX32(0u, judge(1200.0, 1.0, 1200.0));
    encoder -= PI;
    TEST_ASSERT_EQUAL_HEX32(0u, judge(1200.0, 1.0, 1200.0));
    TEST_ASSERT_EQUAL_HEX32(0u, judge(61.0, 1.0, 61.0));
    encoder += PI;
    TEST_ASSERT_EQUAL_UINT32(8u, counted(61.0, 1.0, 61.0));
    TEST_ASSERT_EQUAL_HEX32(ENCODER_WATCH_MISMATCH, bits);
}
