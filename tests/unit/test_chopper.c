/* The brake chopper: the energy of the link, C u^2/2, with a resistor, and the temperature of a
 * first-order body. Both expected values are closed forms. */
#include "fast/protect/chopper.h"
#include "medium/protect/chopper_watch.h"
#include "tests/unit/compare.h"

#define CHOPS        365.0  /* [V] */
#define RESISTANCE   47.0   /* [ohm] */
#define CONTINUOUS   200.0  /* [W] */
#define TIME         10.0   /* [s] */
#define LOOK         0.8e-3 /* [s] between two evaluations, 8 periods */
#define PERIODS      8u
#define EFFECT_LOOKS 26u /* [evaluations] 20 ms, and the first evaluation, which only stores the voltage */

static chopper_watch_t watch;
static chopper_watch_tuning_t tuning;

void setUp(void)
{
    const chopper_watch_params_t params = {
        .voltage = (float)CHOPS,
        .below = (float)(0.98 * CHOPS),
        .resistance = (float)RESISTANCE,
        .continuous = (float)CONTINUOUS,
        .time = (float)TIME,
        .period = (float)LOOK,
        .periods = (float)PERIODS,
    };
    watch = (chopper_watch_t){0};
    tuning = chopper_watch_prepare(&params);
}

static void look(double u_dc, uint32_t chopped, double power)
{
    const chopper_watch_input_t input = {(float)u_dc, chopped, (float)power};
    chopper_watch_step(&watch, &tuning, &input);
}

static void test_it_is_on_above_its_threshold_until_two_percent_below(void)
{
    const chopper_tuning_t thresholds = chopper_prepare((float)CHOPS);
    static const struct {
        double u_dc;
        uint32_t on;
    } way[] = {{300.0, 0u}, {364.9, 0u}, {365.1, 1u}, {360.0, 1u}, {357.8, 1u},
               {357.6, 0u}, {364.9, 0u}, {400.0, 1u}, {100.0, 0u}};
    uint32_t on = 0u;
    for (size_t n = 0; n < sizeof way / sizeof way[0]; n++) {
        on = chopper_step(on, &thresholds, (float)way[n].u_dc);
        TEST_ASSERT_EQUAL_UINT32(way[n].on, on);
    }
}

static void test_without_a_threshold_it_stays_off(void)
{
    const chopper_tuning_t none = chopper_prepare(0.0f);
    TEST_ASSERT_EQUAL_UINT32(0u, chopper_step(1u, &none, 1e6f));
    const chopper_watch_params_t params = {.voltage = 0.0f};
    TEST_ASSERT_EQUAL_UINT32(0u, chopper_watch_prepare(&params).on);
}

/* The heat is h(t) = p (1 - exp(-t/tau)), where p is the mean power over the continuous one; the chopper
 * is on for a quarter of the time. */
static void test_the_resistor_warms_as_a_body_of_first_order(void)
{
    const double p = 0.25 * 370.0 * 370.0 / (RESISTANCE * CONTINUOUS);
    for (uint32_t n = 1; n <= 2500u; n++) {
        look(370.0, PERIODS / 4u, 0.0);
        const double expected = p * (1.0 - exp(-LOOK * n / TIME));
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * p, expected, (double)watch.heat);
    }
}

/* The chopper is always on: p = 14.6, and h = 1 after tau ln(p/(p - 1)). The resistor cools to 0.8 in tau
 * ln(1/0.8). */
static void test_an_overloaded_resistor_is_found_and_may_be_used_again_when_it_is_cool(void)
{
    const double p = 370.0 * 370.0 / (RESISTANCE * CONTINUOUS);
    const double hot = TIME * log(p / (p - 1.0)), cools = TIME * log(1.0 / 0.8);
    uint32_t n = 0u;
    while ((watch.conditions & CHOPPER_OVERLOAD) == 0u && n < 100000u) {
        look(370.0, PERIODS, -5000.0); /* [W] the motor returns more than the resistor takes */
        n++;
    }
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * LOOK, hot, n * LOOK);
    for (n = 0u; (watch.conditions & CHOPPER_OVERLOAD) != 0u && n < 100000u; n++) {
        look(340.0, 0u, 0.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * cools, cools, n * LOOK);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions);
}

/* Integrates C du/dt = -u/R + P/u with one step for each evaluation. Returns the number of evaluations
 * until the condition is reported, 0 if it is not. */
static uint32_t looks_until_no_effect(double resistance, double capacitance, double returned)
{
    double u = 385.0;
    setUp();
    for (uint32_t n = 1; n <= 125u; n++) {
        look(u, PERIODS, -returned);
        if ((watch.conditions & CHOPPER_NO_EFFECT) != 0u) {
            return n;
        }
        u += LOOK / capacitance * (returned / u - (resistance > 0.0 ? u / resistance : 0.0));
    }
    return 0u;
}

static void test_a_resistor_that_takes_energy_is_not_reported_absent(void)
{
    static const double farads[] = {0.2e-3, 1e-3, 5e-3, 20e-3}; /* R C is up to 0.94 s */
    for (size_t n = 0; n < sizeof farads / sizeof farads[0]; n++) {
        TEST_ASSERT_EQUAL_UINT32(0u, looks_until_no_effect(RESISTANCE, farads[n], 0.0));
        TEST_ASSERT_EQUAL_UINT32(0u, looks_until_no_effect(RESISTANCE, farads[n], 1000.0));
        TEST_ASSERT_EQUAL_UINT32(0u,
                                 looks_until_no_effect(RESISTANCE, farads[n], 385.0 * 385.0 / RESISTANCE));
    }
}

static void test_a_link_that_does_not_fall_while_the_chopper_is_on_is_reported(void)
{
    TEST_ASSERT_EQUAL_UINT32(EFFECT_LOOKS, looks_until_no_effect(0.0, 1e-3, 0.0));
    TEST_ASSERT_EQUAL_UINT32(EFFECT_LOOKS, looks_until_no_effect(0.0, 1e-3, 300.0));
    look(385.0, 0u, 0.0); /* off; the condition lasts while the link is high */
    TEST_ASSERT_EQUAL_UINT32(CHOPPER_NO_EFFECT, watch.conditions);
    look(350.0, 0u, 0.0);
    TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions);
}

/* The chopper is judged only while it is on without a pause; in this test every twentieth evaluation has a
 * pause of a period. */
static void test_a_chopper_that_works_in_short_pulses_is_not_judged(void)
{
    for (uint32_t n = 0; n < 1000u; n++) {
        look(365.0, n % 20u == 19u ? PERIODS - 1u : PERIODS, 0.0);
        TEST_ASSERT_EQUAL_UINT32(0u, watch.conditions & CHOPPER_NO_EFFECT);
    }
}
