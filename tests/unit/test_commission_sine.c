/* The step `inductance` of commissioning with windings of known data: L_d, L_q, the saturation of the q
 * axis, and the reasons if there is no result. */
#include <complex.h>
#include <math.h>
#include <unity.h>

#include "tests/unit/commission_windings.h"

/* For a flux cos x of this amplitude: the ratio of the flux to the first harmonic of its current, with psi
 * = L i/sqrt(1 + (i/I_s)^2). */
static double harmonic(double inductance, double saturation, double flux)
{
    double sum = 0.0;
    for (int n = 0; n < 64; n++) {
        const double x = cos(PI * (n + 0.5) / 32.0);
        const double share = flux * x / (inductance * saturation);
        sum += x * flux * x / (inductance * sqrt(1.0 - share * share)) / 32.0;
    }
    return flux / sum;
}

/* L of the saturating q axis for a sine of this voltage. */
static double bent(const winding_t *winding, double voltage, double omega)
{
    const double motion = winding->l_q * winding->rotor / (omega * omega);
    double inductance = winding->l_q;
    for (int n = 0; n < 20 && winding->bends > 0.0; n++) {
        const double current = voltage / hypot(winding->resistance, omega * (inductance - motion));
        inductance = harmonic(winding->l_q, winding->bends, inductance * current);
    }
    return inductance - motion;
}

/* I/U = b/(1 - a z^-1), with L > 0. */
static double complex admittance(double resistance, double inductance, double turn)
{
    const double a = exp(-resistance * PERIOD / inductance);
    return (1.0 - a) / resistance / (1.0 - a * cexp(-IM * turn));
}

/* The sums of a settled window with the sine of the order. The admittances Y of the rotor's axes are turned
 * by `aside`, and sensor a has the relative error g: its current is i_alpha (1 + g), so that i_beta = (i_a +
 * 2 i_b)/sqrt(3) has the error g i_alpha/sqrt(3). */
static void answer_sine(bench_t *bench, const winding_t *winding)
{
    const excite_order_t *order = &bench->commission.order;
    const sine_step_t *step = &bench->commission.work.sine;
    const double turn = (double)order->turn;
    const double omega = turn / PERIOD;
    const bool across = order->sine_across != 0u;
    const double l_q = bent(winding, (double)order->voltage, omega);
    const double complex voltage = 0.5 * PERIODS * (double)order->voltage; /* the mean of cos^2 is 1/2 */
    const double complex y_d = winding->l_d > 0.0 ? admittance(winding->resistance, winding->l_d, turn) : 0.0;
    const double complex y_q = l_q > 0.0 ? admittance(winding->resistance, l_q, turn) : 0.0;
    const double c = cos(winding->aside), s = sin(winding->aside);
    const double complex current = voltage * (across ? y_d * s * s + y_q * c * c : y_d * c * c + y_q * s * s);
    const double complex other = voltage * (y_d - y_q) * s * c;
    const double complex leaves = other + (step->lowered < winding->steady ? winding->leaves * current : 0.0);
    const double complex alpha = across ? leaves : current;
    const double complex beta = across ? current : leaves;
    const double complex along_d = (1.0 + winding->sensor) * alpha;
    const double complex along_q = beta + winding->sensor / sqrt(3.0) * alpha;
    answer_hold(bench, winding, winding->resistance);
    bench->seen.voltage_cos =
        (dq_t){across ? 0.0f : (float)creal(voltage), across ? (float)creal(voltage) : 0.0f};
    bench->seen.current_cos = (dq_t){(float)creal(along_d), (float)creal(along_q)};
    bench->seen.current_sin = (dq_t){(float)-cimag(along_d), (float)-cimag(along_q)};
}

static void begin_inductance(bench_t *bench, const winding_t *winding)
{
    commission_init(&bench->commission);
    bench->commission.results.noise = (float)winding->noise;
    bench->commission.results.current_zone = (float)winding->zone;
    bench->commission.results.inductance_pulse = (float)fmax(winding->l_d, 1e-4);
    bench->commission.results.resistance = (float)winding->resistance;
    bench->commission.results.current_hold = TUNING.current_hold;
    bench->seen = (excite_seen_t){.serial = 0u};
    order_step(bench, &TUNING, COMMISSION_INDUCTANCE);
}

static int32_t inductance_of(bench_t *bench, const winding_t *winding)
{
    begin_inductance(bench, winding);
    while (bench->commission.state < (int32_t)COMMISSION_DONE) {
        answer_sine(bench, winding);
        order_step(bench, &TUNING, COMMISSION_INDUCTANCE);
    }
    return bench->commission.reason;
}

/* The tested rotors include one that the sine moves, for which 10 000 rad^2/s^2 lower L_q by 0.1 and 0.2 %
 * at the two frequencies, and a small winding, whose frequency is doubled. */
static void test_sine_gives_both_inductances_also_of_a_rotor_that_swings(void)
{
    static const winding_t windings[] = {
        {.resistance = 0.95, .l_d = 5e-3, .l_q = 5e-3},
        {.resistance = 0.95, .l_d = 5e-3, .l_q = 12e-3, .rotor = 4e5},
        {.resistance = 0.05, .l_d = 2e-4, .l_q = 3e-4, .rotor = 1e4},
        {.resistance = 0.95, .l_d = 5e-3, .l_q = 5e-3, .leaves = 0.2, .steady = 2u},
    };
    for (uint32_t n = 0u; n < sizeof windings / sizeof windings[0]; n++) {
        const winding_t *winding = &windings[n];
        bench_t bench;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, inductance_of(&bench, winding));
        TEST_ASSERT_DOUBLE_WITHIN(2e-3 * winding->l_d, winding->l_d,
                                  (double)bench.commission.results.inductance_d);
        TEST_ASSERT_DOUBLE_WITHIN(4e-3 * winding->l_q, winding->l_q,
                                  (double)bench.commission.results.inductance_q);
    }
}

/* The iron reduces the flux, also with a rotor that swings; L_q is the value without current. A linear
 * axis has no I_s. The axis is not judged if the phase currents would pass through zero because of their
 * ripple or a wide zone. */
static void test_two_amplitudes_show_the_saturation_of_the_q_axis(void)
{
    static const struct {
        winding_t winding;
        double found; /* [A] */
    } rows[] = {
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .bends = 5.0}, 5.0},
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .bends = 10.0, .rotor = 5e4}, 10.0},
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .bends = 10.0, .rotor = 4e5}, 0.0},
        /* I_s of 15.5 A lowers L_q by 5 % at 5 A. It changes L by 0.6 % at an amplitude of 0.45, which is
         * detected, */
        /* and by 0.2 % at 0.3, to which a wide zone limits the amplitude: a linear axis cannot be
         * distinguished there. */
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .bends = 15.5}, 15.5},
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .bends = 15.5, .zone = 0.95}, 0.0},
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .zone = 0.95}, 0.0},
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .noise = 0.2}, 0.0},
        {{.resistance = 0.05, .l_d = 2e-3, .l_q = 3e-3, .bends = 15.0, .zone = 0.1}, 15.0},
        {{.resistance = 0.05, .l_d = 2e-4, .l_q = 3e-4, .bends = 15.0, .zone = 0.1}, 0.0},
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .rotor = 4e5, .noise = 0.01}, (double)SINE_LINEAR},
        /* a change as large as 0.25 % and 2.5 standard errors could be there without being seen */
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .noise = 0.03}, 0.0},
        {{.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .bends = 5.0, .zone = 1.1}, 0.0},
    };
    for (uint32_t n = 0u; n < sizeof rows / sizeof rows[0]; n++) {
        bench_t bench;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, inductance_of(&bench, &rows[n].winding));
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * rows[n].found, rows[n].found,
                                  (double)bench.commission.results.saturation_current);
        if (rows[n].found > 0.0 && rows[n].found < (double)SINE_LINEAR) {
            TEST_ASSERT_DOUBLE_WITHIN(4e-3 * rows[n].winding.l_q, rows[n].winding.l_q,
                                      (double)bench.commission.results.inductance_q);
        }
    }
}

/* The number of windows of the whole step with sensors of this noise. */
static double windows_with(double noise)
{
    const winding_t winding = {.resistance = 0.95, .noise = noise, .l_d = 5e-3, .l_q = 5e-3};
    bench_t bench;
    (void)inductance_of(&bench, &winding);
    return (double)bench.commission.windows;
}

/* The allowed error sqrt(2/N) noise/amplitude is 0.13 %, with 0.1 to 0.4 s for a run; for the two runs that
 * are compared for the saturation it is 0.032 %, with up to 1 s. The constant currents are 5 and 3 A along
 * the axis and 5 A three times across it. The amplitudes are a fifth of these, the last one 0.45. */
static void test_noise_lengthens_the_sine(void)
{
    static const struct {
        double amplitude, error, most; /* [A], [-], [s] */
    } sines[] = {
        {1.0, 1.3e-3, 0.4}, {0.6, 1.3e-3, 0.4}, {1.0, 3.2e-4, 1.0}, {1.0, 1.3e-3, 0.4}, {2.25, 3.2e-4, 1.0}};
    const double noise = 0.03;
    double more = 0.0;
    for (uint32_t n = 0u; n < sizeof sines / sizeof sines[0]; n++) {
        const double error = noise / (sines[n].error * sines[n].amplitude);
        more += fmin(fmax(2.0 * error * error * PERIOD, 0.1), sines[n].most) - 0.1;
    }
    TEST_ASSERT_DOUBLE_WITHIN(3.0, more / 8e-4, windows_with(noise) - windows_with(1e-6));
}

/* A rotor leaves the axis: the current is lowered to 0.6 of it, twice. */
static void test_unstable_alignment_lowers_the_current_twice(void)
{
    const winding_t winding = {.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .leaves = 0.2, .steady = 9u};
    bench_t bench;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_ALIGNMENT_UNSTABLE, inductance_of(&bench, &winding));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.36 * 5.0, (double)bench.commission.work.sine.current);
}

/* The current across the sine shows the difference of the gains: 4 % and more are a fault, and 2.2 %, which
 * two sound sensors may have, are none. The control aligns the measured current with the axis, so that the
 * true one and a free rotor are aside by -g/sqrt(3). A rotor that a load holds aside is no fault. */
static void test_sensors_of_different_gains_are_named(void)
{
    static const winding_t windings[] = {
        {.resistance = 0.95, .l_d = 5e-3, .l_q = 5e-3},
        {.resistance = 0.05, .l_d = 2e-4, .l_q = 3e-4},
        {.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3},
    };
    static const double sound[] = {0.0, 0.022, -0.022}, wrong[] = {0.04, -0.04, 0.06, -0.06};
    for (uint32_t n = 0u; n < sizeof windings / sizeof windings[0]; n++) {
        winding_t winding = windings[n];
        bench_t bench;
        for (uint32_t k = 0u; k < sizeof sound / sizeof sound[0]; k++) {
            winding.sensor = sound[k];
            winding.aside = -winding.sensor / sqrt(3.0);
            TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, inductance_of(&bench, &winding));
        }
        for (uint32_t k = 0u; k < sizeof wrong / sizeof wrong[0]; k++) {
            winding.sensor = wrong[k];
            winding.aside = -winding.sensor / sqrt(3.0);
            TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_SENSOR_GAIN, inductance_of(&bench, &winding));
        }
        for (double aside = -0.15; aside < 0.16; aside += 0.05) {
            winding.sensor = 0.0;
            winding.aside = aside;
            TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, inductance_of(&bench, &winding));
        }
    }
}

static void test_inductance_ends_with_the_reason_of_its_winding(void)
{
    static const struct {
        const char *name;
        winding_t winding;
        commission_reason_t reason;
    } rows[] = {
        {"no current answers", {.resistance = 0.95}, COMMISSION_REASON_INDUCTANCE_IMPLAUSIBLE},
        {"L_q of 11 L_d",
         {.resistance = 0.95, .l_d = 2e-3, .l_q = 22e-3},
         COMMISSION_REASON_INDUCTANCE_IMPLAUSIBLE},
        {"L_q of 0.3 L_d",
         {.resistance = 0.95, .l_d = 9e-3, .l_q = 2.7e-3},
         COMMISSION_REASON_INDUCTANCE_IMPLAUSIBLE},
        {"L/R of 1.9 periods",
         {.resistance = 10.0, .l_d = 1.9e-3, .l_q = 4e-3},
         COMMISSION_REASON_TIME_CONSTANT_SHORT},
        {"a current flows across the axis",
         {.resistance = 0.95, .across = 0.2, .l_d = 5e-3, .l_q = 5e-3},
         COMMISSION_REASON_ROTOR_SWINGS},
    };
    for (uint32_t n = 0u; n < sizeof rows / sizeof rows[0]; n++) {
        bench_t bench;
        TEST_ASSERT_EQUAL_INT32_MESSAGE(rows[n].reason, inductance_of(&bench, &rows[n].winding),
                                        rows[n].name);
    }
}

#define RUNS 7

/* The errors that the steps of a converter cause in the amplitude of a sine about the current c, in steps,
 * are sums of cos(2 pi n c) and sin(2 pi n c). In each run the current of phase a, and half of it in b and c,
 * passes through whole steps, so that these means are zero: those of phase b for n = 1 and 2 are those of
 * phase a for n = 1/2 and 1. A step is a third of the largest noise. The windows before the sums begin, 0.08
 * s, are left out. */
static void test_standing_current_passes_through_whole_steps_of_the_converter_in_each_run(void)
{
    const double a_step = (double)TUNING.noise_max / 3.0;
    const winding_t winding = {.resistance = 0.95, .l_d = 5e-3, .l_q = 9e-3, .noise = 0.01};
    double complex sums[RUNS][2] = {{0.0}};
    uint32_t windows[RUNS] = {0u}, summed[RUNS] = {0u};
    bench_t bench;
    begin_inductance(&bench, &winding);
    while (bench.commission.state < (int32_t)COMMISSION_DONE) {
        const sine_step_t *step = &bench.commission.work.sine;
        const uint32_t run = step->run;
        if (step->phase == (int32_t)SINE_RUNS && ++windows[run] > 101u) {
            const double turn = 2.0 * PI * (double)bench.commission.order.current / a_step;
            sums[run][0] += cexp(IM * 0.5 * turn);
            sums[run][1] += cexp(IM * turn);
            summed[run]++;
        }
        answer_sine(&bench, &winding);
        order_step(&bench, &TUNING, COMMISSION_INDUCTANCE);
    }
    for (int run = 0; run < RUNS; run++) {
        TEST_ASSERT_GREATER_THAN_UINT32(100u, summed[run]);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.0, cabs(sums[run][0]) / summed[run]);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.0, cabs(sums[run][1]) / summed[run]);
    }
}

static void test_sine_solve_refuses_sums_of_no_winding(void)
{
    const rotation_t turn = {0.3f, 0.95f};
    const sine_sum_t none = {0.0f, 0.0f}, one = {1.0f, 0.0f}, against = {-1.0f, 0.1f};
    TEST_ASSERT_EQUAL_FLOAT(0.0f, sine_solve(none, one, turn, &TUNING));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, sine_solve(one, none, turn, &TUNING));
    TEST_ASSERT_FALSE(sine_solve(against, one, turn, &TUNING) > 0.0f);
}
