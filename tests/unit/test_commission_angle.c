/* The step `angle` of commissioning with windings of known data: 1/L(theta) = y_0 (1 + y_1 cos x + y_2 cos
 * 2x) with x = theta - theta_d. A constant current changes y_2 and causes y_1. */
#include <complex.h>
#include <math.h>
#include <unity.h>

#include "tests/unit/commission_windings.h"

#define L_MEAN 5e-3 /* [H] 1/y_0 */
#define R      0.95 /* [ohm] */

typedef struct {
    double axis;          /* theta_d [rad] */
    double salient;       /* y_2 without a constant current */
    double salient_bent;  /* y_2 with a constant current */
    double bent;          /* y_1 with a constant current */
    double ripple_factor; /* L for the pulses divided by L_MEAN; 0 stands for 1 */
    bool follows;         /* the rotor turns with the current */
} rotor_t;

/* The sums of a settled window, with the sine of the order along its axis: I = b U/(1 - a z^-1). */
static void answer(bench_t *bench, const rotor_t *rotor)
{
    static const winding_t winding = {.resistance = R};
    const excite_order_t *order = &bench->commission.order;
    const bool biased = order->current > 0.0f;
    const double angle = atan2((double)order->axis.sin, (double)order->axis.cos);
    const double x = rotor->follows && biased ? 0.0 : angle - rotor->axis;
    const double y_1 = biased ? rotor->bent : 0.0;
    const double y_2 = biased ? rotor->salient_bent : rotor->salient;
    const double inductance = L_MEAN / (1.0 + y_1 * cos(x) + y_2 * cos(2.0 * x));
    const double a = exp(-R * PERIOD / inductance);
    const double b = (1.0 - a) / R;
    const double complex voltage = 0.5 * PERIODS * (double)order->voltage;
    const double complex current = b * voltage / (1.0 - a * cexp(-IM * (double)order->turn));
    answer_hold(bench, &winding, R);
    bench->seen.voltage_cos.d = (float)creal(voltage);
    bench->seen.current_cos.d = (float)creal(current);
    bench->seen.current_sin.d = (float)-cimag(current);
}

static int32_t angle_of(bench_t *bench, const rotor_t *rotor)
{
    const double ripple_factor = rotor->ripple_factor > 0.0 ? rotor->ripple_factor : 1.0;
    commission_init(&bench->commission);
    bench->commission.results.noise = 0.01f;
    bench->commission.results.current_zone = 0.05f;
    bench->commission.results.inductance_pulse = (float)(ripple_factor * L_MEAN);
    bench->commission.results.resistance = (float)R;
    bench->commission.results.dead_voltage = 10.0f;
    bench->commission.results.current_hold = TUNING.current_hold;
    bench->seen = (excite_seen_t){.serial = 0u};
    order_step(bench, &TUNING, COMMISSION_ANGLE);
    while (bench->commission.state < (int32_t)COMMISSION_DONE) {
        answer(bench, rotor);
        order_step(bench, &TUNING, COMMISSION_ANGLE);
    }
    return bench->commission.reason;
}

/* The direction follows from the saturation alone, or from the axis of the saliency with the polarity of
 * the saturation. The second result holds also where the constant current has inverted the sign of the
 * saliency. */
static void test_direction_of_a_held_rotor_is_found_with_its_polarity(void)
{
    static const rotor_t rotors[] = {{.bent = 0.03},
                                     {.salient = 0.02, .salient_bent = 0.02, .bent = 0.03},
                                     {.salient = 0.11, .salient_bent = 0.11, .bent = 0.02},
                                     {.salient = 0.11, .salient_bent = -0.05, .bent = 0.1},
                                     {.salient = 0.5, .salient_bent = 0.5, .bent = 0.05}};
    for (uint32_t n = 0u; n < sizeof rotors / sizeof rotors[0]; n++) {
        for (double axis = -3.0; axis < 3.1; axis += 0.7) {
            rotor_t rotor = rotors[n];
            bench_t bench;
            rotor.axis = axis;
            TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, angle_of(&bench, &rotor));
            TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0,
                                      remainder((double)bench.commission.results.angle_d - axis, 2.0 * PI));
        }
    }
}

/* Without saturation at most the axis is known, and there is no result. There is no result either if the
 * rotor follows the current, or if a ripple brings a phase current to zero. */
static void test_held_rotor_without_a_direction_is_named(void)
{
    static const struct {
        rotor_t rotor;
        int32_t detail;
    } rows[] = {{{.axis = 1.0, .bent = 0.014}, 0},
                {{.axis = 1.0, .salient = 0.3, .salient_bent = 0.3}, ANGLE_AXIS_ONLY},
                {{.axis = 1.0, .bent = 0.1, .follows = true}, 0},
                {{.axis = 1.0, .bent = 0.1, .ripple_factor = 0.25}, ANGLE_NOT_CLEAR}};
    for (uint32_t n = 0u; n < sizeof rows / sizeof rows[0]; n++) {
        bench_t bench;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NO_STANDSTILL_ANGLE, angle_of(&bench, &rows[n].rotor));
        TEST_ASSERT_EQUAL_INT32(rows[n].detail, bench.commission.detail);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.commission.results.angle_d);
    }
}

static void test_held_rotor_needs_the_resistance(void)
{
    commission_window_t window = {.bridge_on = true};
    bench_t bench;
    commission_init(&bench.commission);
    bench.seen = (excite_seen_t){.serial = 0u};
    window.standing = (commission_input_t){.seen = &bench.seen, .u_dc = (float)LINK};
    commission_window(&bench.commission, &TUNING, COMMISSION_ANGLE, &window);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_EARLIER_STEP, bench.commission.reason);
}
