/* The voltage that the observer receives is compared with the voltage on the winding, period by period. The
 * voltage on the winding follows from true currents, angle and constants of the plant:
 *
 *     u = (R + r) (i_k-1 + i_k)/2 + L (i_k - i_k-1)/T + (psi_k - psi_k-1)/T
 *
 * r is the slope of the device drops, which the drive counts as part of the winding. The simulation has
 * every gate edge, 2.5 us of dead time, and delays and drops of the module. The sensors are exact, so that
 * the difference is the error of the inverter model alone. */
#include <complex.h>

#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

#define FLUX       0.183   /* [Wb] */
#define RESISTANCE 0.95    /* [ohm] */
#define INDUCTANCE 12.5e-3 /* [H] */

static double complex vector_of(double a, double b, double c)
{
    return (2.0 * a - b - c) / 3.0 + (double complex)I * (b - c) / sqrt(3.0);
}

typedef struct {
    double rms;         /* [V] of assumed minus true voltage */
    double one_current; /* [V] the same difference if both edges of a leg had the mean current */
} missed_t;

/* The voltage that both edges would lose at the mean current [V]. */
static double complex lost_by_mean(double complex current)
{
    double lost[3];
    for (int leg = 0; leg < 3; leg++) {
        const double phase = creal(current * cexp(-(double complex)I * (leg * 2.0943951023931953)));
        lost[leg] = rig_value(rig, "dead_time_hat") *
                    fmax(-1.0, fmin(1.0, phase / rig_value(rig, "params.current_zone")));
    }
    return vector_of(lost[0], lost[1], lost[2]);
}

static missed_t measure(double rpm, double load)
{
    rig = run_rig(7);
    run_puts(rig, "sensors=1 current_noise=0");
    run_paper_drive(rig);
    run_parameter(rig, "position_source", 1.0);
    const double rpm_loading = copysign(fmax(fabs(rpm), 300.0), rpm);
    run_to_ready_at(rig, rpm_loading);
    run_on(rig, rpm_loading);
    run_seconds(rig, 0.5);
    run_load(rig, RUN_LIMIT_SHARE * load, 1.5);
    run_speed(rig, rpm_loading, rpm, 2.0);
    run_seconds(rig, 1.0);

    const double resistance = RESISTANCE + rig_value(rig, "device_resistance");
    const uint32_t periods = 10000u;
    double complex duty[3] = {0.0}; /* newest value first */
    double complex last = 0.0;
    double complex flux_last = 0.0;
    missed_t missed = {0.0, 0.0};
    for (uint32_t n = 0; n < periods + 3u; n++) {
        rig_step(rig);
        const double complex i =
            vector_of(rig_value(rig, "true_i_a"), rig_value(rig, "true_i_b"), rig_value(rig, "true_i_c"));
        const double complex flux = FLUX * cexp((double complex)I * rig_value(rig, "true_theta_e"));
        const double complex voltage =
            resistance * 0.5 * (i + last) + (INDUCTANCE * (i - last) + flux - flux_last) / RIG_PERIOD_SECONDS;
        const double complex told = rig_value(rig, "u_alpha") + (double complex)I * rig_value(rig, "u_beta");
        const double complex simple = duty[1] * rig_value(rig, "u_dc") - lost_by_mean(0.5 * (i + last));
        if (n >= 3u) {
            missed.rms += pow(cabs(told - voltage), 2.0) / periods;
            missed.one_current += pow(cabs(simple - voltage), 2.0) / periods;
        }
        duty[1] = duty[0];
        duty[0] = vector_of(rig_value(rig, "duty_a"), rig_value(rig, "duty_b"), rig_value(rig, "duty_c"));
        last = i;
        flux_last = flux;
    }
    run_expect_no_fault(rig);
    missed.rms = sqrt(missed.rms);
    missed.one_current = sqrt(missed.one_current);
    rig_free(rig);
    rig = NULL;
    return missed;
}

/* The remaining error is a fraction of a volt, compared with the 8 V that a leg loses. It comes from
 * changes of the current within a dead band, and from the difference of 0.15 V between the drops of
 * transistor and diode. The limits are 1.5 times the largest value over both directions and boards. */
static void test_the_observer_gets_what_was_on_the_winding(void)
{
    static const struct {
        double rpm, load; /* [r/min], [N m] */
        double limit;     /* [V] */
        double share;     /* largest share of the error that one current for both edges leaves [-] */
    } points[] = {
        {100.0, 0.0, 0.035, 1.0},  {100.0, 5.0, 0.045, 1.0},  {503.0, 0.0, 0.19, 0.45},
        {503.0, 5.0, 0.11, 0.35},  {1013.0, 0.0, 0.24, 0.25}, {1013.0, 5.0, 0.17, 0.25},
        {1490.0, 0.0, 0.31, 0.25}, {1490.0, 5.0, 0.21, 0.25},
    };
    grid_t grid = grid_of("told", 2u * sizeof points / sizeof points[0]);
    for (uint32_t n; grid_next(&grid, &n);) {
        const double rpm = (n % 2u != 0u ? -1.0 : 1.0) * points[n / 2u].rpm;
        const missed_t missed = measure(rpm, points[n / 2u].load);
        const char *const message =
            run_say("%.0f r/min, %g N m: %.3f V rms; one current for both edges %.3f V", rpm,
                    points[n / 2u].load, missed.rms, missed.one_current);
        TEST_ASSERT_TRUE_MESSAGE(missed.rms <= points[n / 2u].limit, message);
        TEST_ASSERT_TRUE_MESSAGE(missed.rms <= points[n / 2u].share * missed.one_current, message);
    }
}
