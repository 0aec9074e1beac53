/* The steps of commissioning that turn the rotor, with a rotor in double precision that follows the
 * orders: the measured values, the orders of each test, and the reasons of tests that fail. */
#include <math.h>
#include <string.h>
#include <unity.h>

#include "medium/adapt/sums.h"
#include "medium/commission/turning_steps.h"

#define WINDOW 8e-4
#define PAIRS  4.0
#define MOST   200000u /* [windows] longest duration of a test */

static const double pi = 3.14159265358979323846;

typedef struct {
    double inertia, coulomb, viscous, flux, inductance_d, inductance_q;
    double saturation;  /* [A] I_s of the q axis; 0: no saturation */
    double observed_q;  /* [H] constant L_q of the observer for a saturating rotor */
    double angle_noise; /* [rad] noise of the angle of the EMF, uniform between minus and plus this */
    double speed_noise; /* [-] relative noise of the estimated speed */
    double later;       /* [N m] additional dry friction as soon as the test commands a current */
    double lost_after;  /* [windows] with an order of a current until the lock is lost; 0: never */
    uint32_t draw;      /* seed of the noise; 0: any */
    double grows;       /* [kg m^2] is added to J at the first steady speed after the pushes */
    double
        edge_delay; /* [s] by which the edges of the legs, and so the middle of the zero vector, are late */
    double slow;    /* [1/s] rate of a speed control that is not ideal; 0: ideal */
} rotor_t;

typedef struct {
    rotor_t is;
    double theta, omega, i_q; /* mechanical angle and speed, and the current */
    double windows;           /* number of windows with an order of a current */
    uint32_t draw;
    bool pushed, grown;
} model_t;

static double noise(model_t *model)
{
    model->draw = model->draw * 1664525u + 1013904223u;
    return (double)(model->draw >> 8u) / 8388608.0 - 1.0;
}

/* Simulates one window with this order; the speed control is proportional and knows the friction. */
static turning_input_t follow(model_t *model, const turning_wish_t *wish)
{
    rotor_t *is = &model->is;
    const double i_d = (double)wish->current.d;
    const double bent = is->saturation > 0.0 ? 1.0 / hypot(1.0, model->i_q / is->saturation) : 1.0;
    const double constant = 1.5 * PAIRS * (is->flux + (is->inductance_d - bent * is->inductance_q) * i_d);
    const double observed = is->saturation > 0.0 ? is->observed_q : is->inductance_q;
    const bool by_current = wish->by_current != 0u;
    model->pushed = model->pushed || by_current;
    if (model->pushed && !by_current && !model->grown) {
        is->inertia += is->grows;
        model->grown = true;
    }
    model->windows += by_current ? 1.0 : 0.0;
    const double gain = is->slow > 0.0 ? is->slow : 40.0;
    const double friction = is->coulomb + (model->pushed && by_current ? is->later : 0.0);
    double mean = 0.0;
    for (int n = 0; n < 8; n++) {
        const double slack = (double)wish->omega_m_ref - model->omega;
        const double wanted =
            by_current ? (double)wish->current.q
                       : (friction + is->viscous * model->omega + gain * is->inertia * slack) / constant;
        model->i_q += 0.1 * (wanted - model->i_q);
        const double torque =
            constant * model->i_q - is->viscous * model->omega - (model->omega > 0.0 ? friction : 0.0);
        model->omega += torque / is->inertia * WINDOW / 8.0;
        model->theta += model->omega * WINDOW / 8.0;
        mean += model->i_q / 8.0;
    }
    const double omega_e = PAIRS * model->omega;
    /* The sample is before the middle of the zero vector, in which the EMF decreases the current. */
    mean += is->edge_delay * fabs(omega_e) * is->flux / is->inductance_q;
    const double half = 0.5 * (WINDOW - WINDOW / 8.0) * omega_e; /* the mean vector lags by half a window */
    const double turn = omega_e * WINDOW / 8.0;
    const double shorter = sin(4.0 * turn) / (8.0 * sin(0.5 * turn));
    /* The voltage of the active flux along q, and of the rest of psi_q along d. */
    const double across = shorter * omega_e * (bent * is->inductance_q - observed) * model->i_q;
    const double along = shorter * omega_e * (is->flux + (is->inductance_d - observed) * i_d);
    const double emf = hypot(along, across);
    const double off = is->angle_noise * noise(model) - atan2(across, along);
    const dq_t current = {(float)(shorter * (i_d * cos(half) + mean * sin(half))),
                          (float)(shorter * (mean * cos(half) - i_d * sin(half)))};
    const sums_t sums = {.emf = {(float)(emf * sin(half + off)), (float)(emf * cos(half + off))},
                         .current = {current.d, current.q}};
    /* Means of the window in the frame of its end, rotated to its middle as in the medium task. */
    means_t means;
    sums_mean(&sums, 1.0f, (rotation_t){0.0f, 1.0f}, (float)omega_e, (float)(half / omega_e), &means);
    return (turning_input_t){
        .runs = is->lost_after > 0.0 && model->windows > is->lost_after ? 0u : 1u,
        .theta_e = (float)remainder(PAIRS * model->theta, 2.0 * pi),
        .omega_e = (float)(omega_e * (1.0 + is->speed_noise * noise(model))),
        .emf = means.emf_rotor,
        .current = means.current_rotor,
    };
}

static const commission_tuning_t TUNING = {.current_max = 10.0f,
                                           .pole_pairs = (float)PAIRS,
                                           .period = 1e-4f,
                                           .window = (float)WINDOW,
                                           .inductance_d = 0.01f,
                                           .inductance_q = 0.01f};

static commission_tuning_t tuning_of(const rotor_t *is, double inertia)
{
    commission_tuning_t tuning = TUNING;
    tuning.inductance_d = (float)is->inductance_d;
    tuning.inductance_q = (float)is->inductance_q;
    tuning.observed_q = (float)(is->saturation > 0.0 ? is->observed_q : is->inductance_q);
    tuning.saturation = (float)is->saturation;
    tuning.flux_linkage = (float)(0.9 * is->flux);
    tuning.inertia = (float)inertia;
    tuning.edge_delay = (float)is->edge_delay;
    return tuning;
}

/* The whole torque test, from 30 to 100 rad/s; `least` is the speed of the hand-over. */
static commission_verdict_t torque_test(const rotor_t *is, double inertia, double least,
                                        commission_results_t *results)
{
    torque_test_t step;
    turning_wish_t wish = {0u, 30.0f, {0.0f, 0.0f}};
    model_t model = {.is = *is, .omega = 30.0, .draw = 7u + is->draw};
    const commission_tuning_t tuning = tuning_of(is, inertia);
    commission_verdict_t verdict = commission_goes_on();
    torque_test_begin(&step);
    for (uint32_t n = 0u; n < MOST && verdict.finished == 0u; n++) {
        turning_input_t input = follow(&model, &wish);
        input.speed = 100.0f;
        input.least = (float)least;
        verdict = torque_test_step(&step, &tuning, &input, &wish, results);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, verdict.finished);
    return verdict;
}

static commission_results_t known(double flux, double inertia_first)
{
    return (commission_results_t){.flux_first = (float)flux,
                                  .flux_linkage = (float)flux,
                                  .inertia_first = (float)inertia_first,
                                  .dead_voltage = 1.0f};
}

/* ---- J and friction ---- */

/* A round rotor of 10 mH with this inertia [kg m^2], dry friction [N m], viscous friction [N m s] and flux
 * [Wb]. */
#define ROTOR(j, dry, wet, psi)                                                                              \
    .inertia = (j), .coulomb = (dry), .viscous = (wet), .flux = (psi), .inductance_d = 0.01,                 \
    .inductance_q = 0.01
#define GOOD ROTOR(2e-3, 0.1, 0.0, 0.1)

/* If the swing has given this inertia, the torque test of this rotor ends with this reason. */
static void expect_of_torque(commission_reason_t reason, const rotor_t *is, double swung,
                             commission_results_t *results)
{
    TEST_ASSERT_EQUAL_INT32(reason, torque_test(is, swung, 10.0, results).reason);
}

static commission_results_t expect_inertia(const rotor_t *is, double swung, double share)
{
    commission_results_t results = known(is->flux, swung);
    expect_of_torque(COMMISSION_REASON_NONE, is, swung, &results);
    TEST_ASSERT_DOUBLE_WITHIN(share * is->inertia, is->inertia, (double)results.inertia);
    return results;
}

static void test_inertia_and_friction_of_light_and_heavy_rotors(void)
{
    rotor_t rotors[] = {
        {ROTOR(2e-3, 0.1, 5e-4, 0.1)},
        {ROTOR(0.2, 0.2, 1e-3, 0.2)},
        {ROTOR(0.2, 0.2, 1e-3, 0.2),
         .slow = 0.8}, /* the speed still approaches a steady value with 2 rad/s^2 */
        {ROTOR(6e-5, 0.02, 1e-4, 0.05)},
        {ROTOR(2e-3, 0.1, 5e-4, 0.1)},
        {ROTOR(2e-2, 0.1, 5e-4, 0.1), .saturation = 5.0, .observed_q = 0.016},
    };
    rotors[4].inductance_q = rotors[5].inductance_q = 0.03;
    for (uint32_t n = 0u; n < sizeof rotors / sizeof rotors[0]; n++) {
        const commission_results_t results = expect_inertia(&rotors[n], rotors[n].inertia, 0.01);
        const double friction = rotors[n].coulomb + 60.0 * rotors[n].viscous;
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * friction, friction,
                                  (double)results.friction_coulomb + 60.0 * (double)results.friction_viscous);
    }
}

/* Edges that are 2 us late make the sample larger than the mean by 2 us |e|/L_q. As a torque, this would be a
 * viscous friction of 1.5 p^2 psi^2 D/L_q = 4.8e-5 N m s/rad, five times the true one. */
static void test_current_of_a_sample_before_the_middle_of_the_zero_vector_is_no_friction(void)
{
    const rotor_t is = {ROTOR(2e-3, 0.1, 1e-5, 0.1), .edge_delay = 2e-6};
    const commission_results_t results = expect_inertia(&is, is.inertia, 0.01);
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, is.viscous, (double)results.friction_viscous);
}

/* The acceleration of a slice has a noise of 8 %. As the independent variable of the regression it would
 * make J too small by 1.5 %, which is visible in the mean of many tests. The noise of the torque, which is
 * smaller, makes J too large. */
static void test_inertia_from_noisy_angles(void)
{
    rotor_t is = {ROTOR(1.5e-4, 0.02, 0.0, 0.1), .angle_noise = 0.07, .speed_noise = 0.03};
    double sum = 0.0;
    for (is.draw = 1u; is.draw <= 8u; is.draw++) {
        commission_results_t results = known(is.flux, is.inertia);
        expect_of_torque(COMMISSION_REASON_NONE, &is, is.inertia, &results);
        sum += (double)results.inertia / 8.0;
    }
    TEST_ASSERT_TRUE(sum > 0.995 * is.inertia && sum < 1.02 * is.inertia);
}

/* The slices of braking are too short for a measurement of the acceleration, and those of pushing and
 * coasting have nearly the same mean speed. Without the steady speeds the fit could not separate B from J. */
static void test_friction_of_the_steady_speeds_shows_the_inertia_of_a_light_rotor(void)
{
    rotor_t is = {ROTOR(1.2e-5, 8e-3, 2e-5, 0.02), .angle_noise = 0.04};
    for (is.draw = 1u; is.draw <= 8u; is.draw++) {
        (void)expect_inertia(&is, is.inertia, 0.03);
    }
}

/* A wrong inertia from the swing is confirmed as wrong by a second test. */
static void test_a_push_that_does_not_suffice_grows_and_a_wrong_swing_is_put_right(void)
{
    const rotor_t sticks = {GOOD, .later = 1.0}, good = {GOOD};
    (void)expect_inertia(&sticks, sticks.inertia, 0.01);
    (void)expect_inertia(&good, 0.5 * good.inertia, 0.01);
}

/* A fiftieth of 500 V is 10 V, and the EMF at 35 rad/s is 14 V. Two tests and the swing give three values
 * of an inertia that increases. The angle may have more noise than the test can average. */
static void test_reasons_of_the_torque_test(void)
{
    const rotor_t good = {GOOD}, lost = {GOOD, .lost_after = 100.0}, grows = {GOOD, .grows = 1e-3};
    const rotor_t noisy = {ROTOR(2e-5, 0.1, 0.0, 0.1), .angle_noise = 0.5};
    commission_results_t results = known(good.flux, good.inertia);
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_EMF_TOO_SMALL,
                            torque_test(&good, good.inertia, 60.0, &results).reason);
    results.dead_voltage = 500.0f;
    expect_of_torque(COMMISSION_REASON_EMF_TOO_SMALL, &good, good.inertia, &results);
    results = known(lost.flux, lost.inertia);
    expect_of_torque(COMMISSION_REASON_SENSORLESS_LOST, &lost, lost.inertia, &results);
    results = known(grows.flux, 0.5 * grows.inertia);
    expect_of_torque(COMMISSION_REASON_INERTIA_NOT_SEEN, &grows, grows.inertia, &results);
    results = known(noisy.flux, noisy.inertia);
    expect_of_torque(COMMISSION_REASON_INERTIA_NOT_SEEN, &noisy, noisy.inertia, &results);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, results.inertia);
}

/* ---- psi_f ---- */

static commission_verdict_t flux_test(const rotor_t *is, float speed, commission_results_t *results,
                                      turning_wish_t *wish)
{
    flux_test_t step;
    model_t model = {.is = *is, .omega = (double)speed, .draw = 3u};
    const commission_tuning_t tuning = tuning_of(is, is->inertia);
    commission_verdict_t verdict = commission_goes_on();
    *wish = (turning_wish_t){0u, speed, {0.0f, 0.0f}};
    flux_test_begin(&step);
    for (uint32_t n = 0u; n < MOST && verdict.finished == 0u; n++) {
        turning_input_t input = follow(&model, wish);
        input.speed = speed;
        verdict = flux_test_step(&step, &tuning, &input, wish, results);
    }
    TEST_ASSERT_EQUAL_UINT32(1u, verdict.finished);
    return verdict;
}

/* i_d keeps the signs of the currents in the legs certain. On a salient rotor it adds at most 0.3 psi_f to
 * the active flux. */
static void test_flux_of_round_and_salient_rotors(void)
{
    static const struct {
        double inductance_q, current_d, saturation;
        float speed; /* [rad/s]; 500 is 2000 rad/s electrical, 1.6 rad in a window */
    } rows[] = {{0.01, 5.0, 0.0, 100.0f},
                {0.01, 5.0, 0.0, 500.0f},
                {0.0105, 5.0, 0.0, 100.0f},
                {0.012, -5.0, 0.0, 100.0f},
                {0.03, -0.3 * 0.09 / 0.02, 0.0, 100.0f},
                {0.03, -0.3 * 0.09 / 0.02, 5.0, 100.0f}};
    for (uint32_t n = 0u; n < sizeof rows / sizeof rows[0]; n++) {
        rotor_t is = {GOOD, .saturation = rows[n].saturation, .observed_q = 0.016};
        is.inductance_q = rows[n].inductance_q;
        commission_results_t results = {.noise = 0.0f};
        turning_wish_t wish;
        TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE,
                                flux_test(&is, rows[n].speed, &results, &wish).reason);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * is.flux, is.flux, (double)results.flux_linkage);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, rows[n].current_d, (double)wish.current.d);
    }
}

/* The estimate of each window is wrong by up to 20 %, as where the back-EMF is small. */
static void test_noise_of_the_speed_neither_delays_nor_changes_the_flux(void)
{
    const rotor_t is = {GOOD, .speed_noise = 0.2};
    commission_results_t results = {.noise = 0.0f};
    turning_wish_t wish;
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_NONE, flux_test(&is, 100.0f, &results, &wish).reason);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3 * is.flux, is.flux, (double)results.flux_linkage);
    TEST_ASSERT_TRUE(results.flux_scatter > 0.05f && results.flux_scatter < 0.2f); /* 0.2/sqrt(3) */
}

static void test_rotor_without_magnets_has_no_flux(void)
{
    const rotor_t is = {ROTOR(2e-3, 0.0, 0.0, 0.0)};
    commission_results_t results = {.noise = 0.0f};
    turning_wish_t wish;
    flux_test_t step;
    const commission_tuning_t tuning = tuning_of(&is, 1e-3);
    turning_input_t input = {.runs = 1u, .omega_e = 400.0f, .speed = 100.0f};
    commission_verdict_t verdict = commission_goes_on();
    flux_test_begin(&step);
    for (uint32_t n = 0u; n < MOST && verdict.finished == 0u; n++) {
        verdict = flux_test_step(&step, &tuning, &input, &wish, &results);
    }
    TEST_ASSERT_EQUAL_INT32(COMMISSION_REASON_EMF_TOO_SMALL, verdict.reason);
}
