#include "estimator/chosen.h"
#include "settings/params.h"

#include "settings/reasons.h"
#include "settings/requests.h"
#include "settings/tuning.h"
#include "tests/unit/rows.h"

static params_t params;
static params_error_t why;

void setUp(void)
{
    params_defaults(&params);
    memset(&why, 0, sizeof why);
}

/* The paper's Table I and its test rig (section 2). */
static void test_defaults_are_the_papers_motor_and_are_accepted(void)
{
    TEST_ASSERT_TRUE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_INT32(4, params.motor_pole_pairs);
    TEST_ASSERT_EQUAL_FLOAT(0.95f, params.motor_resistance);
    TEST_ASSERT_EQUAL_FLOAT(12.5e-3f, params.motor_inductance_d);
    TEST_ASSERT_EQUAL_FLOAT(0.183f, params.motor_flux_linkage);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, params.current_limit);
}

/* Each parameter is set just below and just above its range, and to a value that is not a number. It must
 * be refused by its own name with a range within its own. (A whole number has no representation of NaN.)
 * Both ends belong to the range: at most a rule between parameters refuses them. */
static void test_every_row_is_refused_outside_its_range_by_name_and_takes_both_ends(void)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        const float min = table_min(row);
        const float max = table_max(row);
        const bool whole = row->kind != SLOT_FLOAT;
        const float values[] = {min, max, whole ? min - 1.0f : nextafterf(min, -INFINITY),
                                whole ? max + 1.0f : nextafterf(max, INFINITY), NAN};
        TEST_ASSERT_FALSE_MESSAGE(table_accepts(row, NAN), row->name);
        for (size_t m = 0; m < (whole ? 4u : 5u); m++) {
            params_defaults(&params);
            table_set(row, &params, values[m]);
            const bool accepted = params_check(&params, &why);
            if (m < 2u) {
                TEST_ASSERT_TRUE_MESSAGE(accepted || why.reason == REASON_CROSS_RULE, row->name);
                continue;
            }
            TEST_ASSERT_FALSE_MESSAGE(accepted, row->name);
            TEST_ASSERT_EQUAL_STRING(row->name, why.field);
            TEST_ASSERT_EQUAL_UINT32(row->id, why.id);
            TEST_ASSERT_EQUAL_INT32(REASON_OUT_OF_RANGE, why.reason);
            TEST_ASSERT_TRUE_MESSAGE(why.min >= min && why.min <= why.max && why.max <= max, row->name);
            TEST_ASSERT_TRUE(m == 4u ? isnan(why.value) : why.value == values[m]);
        }
    }
}

static void expect_rule(const char *field, float min, float max)
{
    const table_row_t *row = row_of(field);
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING(field, why.field);
    /* The reported value is the given one, in the unit of the parameter. */
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * fabsf(table_get(row, &params)), table_get(row, &params), why.value);
    TEST_ASSERT_TRUE(why.rule != NULL && strlen(why.rule) > 0);
    TEST_ASSERT_EQUAL_INT32(REASON_CROSS_RULE, why.reason);
    TEST_ASSERT_EQUAL_UINT32(row->id, why.id);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * (fabsf(min) + 1e-9f), min, why.min);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f * (fabsf(max) + 1e-9f), max, why.max);
}

#ifdef LAGLESS_ESTIMATOR_FIXED
/* L = 1 H is within the range of the parameter, and too large for the number formats of the default motor. */
static void test_a_motor_that_does_not_fit_is_refused_by_its_row(void)
{
    params.motor_inductance_q = 1.0f;
    params.motor_inductance_d = 1.0f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("motor_inductance_q", why.field);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, why.value);
    TEST_ASSERT_NOT_NULL(strstr(why.rule, "fixed-point estimator"));
}
#endif

/* The limit that a rule reports is accepted. */
static void expect_accepted_at(const char *field, float limit)
{
    table_set(row_of(field), &params, limit);
    TEST_ASSERT_TRUE_MESSAGE(params_check(&params, &why), field);
}

typedef struct {
    const char *field;
    float good, bad, min, max; /* good is NAN if no value is accepted */
    const char *given;         /* values of other parameters */
} rule_t;

/* Among the given parameters the last accepted value and the first refused one are tested. The refusal has
 * a range, and the end of it that was exceeded must be accepted. */
static void check_rule(const rule_t *rule)
{
    params_defaults(&params);
    set_rows(&params, rule->given);
    if (!isnan(rule->good)) {
        expect_accepted_at(rule->field, rule->good);
    }
    table_set(row_of(rule->field), &params, rule->bad);
    expect_rule(rule->field, rule->min, rule->max);
    expect_accepted_at(rule->field, rule->bad > why.max ? why.max : why.min);
}

/* A motor of so small a psi_f that no other rule limits its speed; the observer covers its EMF. */
#ifdef LAGLESS_ESTIMATOR_FIXED
#define FASTEST "observer_gain=1010 observer_slope=0.19 motor_flux_linkage=0.04 "
#else
#define FASTEST "observer_gain=1010 observer_slope=0.19 motor_flux_linkage=0.02 "
#endif
#define FASTEST_SPEED (CHOSEN_TURN_MAX / 4e-4f) /* [rad/s] */

static const rule_t between_rows[] = {
    {"overcurrent_trip", 12.0f, 11.9f, 12.0f, 19.0f, "current_limit=10"},
    {"dc_undervoltage", 290.0f, 291.0f, 10.0f, 290.0f, "dc_overvoltage=300"},
    /* The bands of the limits of braking and driving must not overlap. */
    {"dc_undervoltage", 239.3f, 300.0f, 10.0f, 0.95f * 320.0f / 1.27f,
     "dc_overvoltage=320 ride_through_time=0.5"},
    /* A switch must be off before the other switch turns on. */
    {"turn_off_delay", 2.4e-6f, 2.6e-6f, 0.0f, 2.5e-6f, "dead_time=2e-6 turn_on_delay=0.5e-6"},
    {"motor_pole_pairs", 4.0f, 5.0f, 1.0f, 4.0f, "encoder_lines=256"},
    /* The largest turn in a period/(4 pole pairs x 100 us), for a motor whose EMF does not charge the link.
     * The lower end is estimate_speed_min. If start_speed is configured, the lower end is start_speed/0.3,
     * because the largest hand-over speed by the rule is 0.3 of this parameter. */
    {"overspeed_trip", 0.999f * FASTEST_SPEED, 1.001f * FASTEST_SPEED, 3.0f, FASTEST_SPEED, FASTEST},
    {"overspeed_trip", 0.999f * FASTEST_SPEED, 1.001f * FASTEST_SPEED, 8.0f / 0.3f, FASTEST_SPEED,
     FASTEST "start_speed=8"},
    /* The link of the board withstands 450 V: sqrt3 x 0.183 Wb x 4 x 354.92 rad/s; the observer would
     * cover more. */
    {"overspeed_trip", 354.8f, 355.1f, 3.0f,
     BOARD_VOLTS(BOARD_OVERVOLTAGE_MAX_MV) / (1.7320508f * 0.183f * 4.0f), "observer_gain=295"},
    /* A sample takes at most half of the time constant of the winding: 12.5 mH/(2 x 100 us) = 62.5 ohm, of
     * which 0.5 belong to the devices. */
    {"motor_resistance", 61.9f, 62.1f, 1e-3f, 62.0f, "device_resistance=0.5"},
    /* The cutoff is below the bandwidth of the loop to which it belongs; a torque feed-forward requires at
     * least 0.1 rad/s. */
    {"feedforward_cutoff", 94.9f, 95.1f, 0.0f, 95.0f, "torque_feedforward=0 pll_bandwidth=100"},
    {"torque_feedforward", 0.0f, 0.5f, 0.0f, 0.0f, "feedforward_cutoff=0 pll_bandwidth=200"},
    {"start_current", 10.0f, 10.1f, 0.0f, 10.0f, ""},
    {"estimate_speed_min", 219.9f, 220.0f, 0.0f, 220.0f, ""}, /* below the largest speed */
    {"estimate_speed_min", 219.9f, 221.0f, 0.0f, 220.0f, ""},
    {"low_speed_current", 10.0f, 10.1f, 0.0f, 10.0f, ""},
    {"low_speed_current", 1.5f, 2.0f, 0.0f, 1.5f, "current_limit=1.5"},
    /* The upper end is half of 220 rad/s. The lower end is the configured start_speed. If start_speed is
     * 0, its value follows from a rule, and the lower end is 0. */
    {"handover_speed", 8.0f, 110.1f, 8.0f, 110.0f, "start_speed=8"},
    {"handover_speed", 0.0f, 110.1f, 0.0f, 110.0f, ""},
    /* By rule it is 15.710 rad/s. */
    {"fallback_speed", 15.7f, 15.72f, 0.0f, 1.15f * 10.0f / 0.732f, ""},
    {"start_speed", 15.71f, 15.72f, 0.0f, 1.15f * 10.0f / 0.732f, ""},
    {"start_speed", 8.0f, 8.1f, 0.0f, 8.0f, "handover_speed=8"},
    /* The limit is 0.7 x 1.5 x 0.732 Wb x I/0.0636 kg m^2, which is 120.85 rad/s^2 with 10 A and 60.42
     * rad/s^2 with 5 A. */
    {"start_ramp", 120.8f, 121.0f, 0.0f, 0.7f * 10.98f / 0.0636f, ""},
    {"start_ramp", 60.4f, 100.0f, 0.0f, 0.7f * 5.49f / 0.0636f, "start_current=5"},
};

static void test_rules_between_rows_hold_at_their_limits(void)
{
    for (size_t n = 0; n < sizeof between_rows / sizeof between_rows[0]; n++) {
        check_rule(&between_rows[n]);
    }
    /* A feed-forward whose error decays may receive the torque. */
    params_defaults(&params);
    set_rows(&params, "torque_feedforward=0.5 pll_bandwidth=200");
    expect_accepted_at("feedforward_cutoff", 1.0f);
}

#define ROUND_ROTORS_OBSERVER "mtpa=off field_weakening=off observer_gain=200 observer_slope=1"

/* On the estimator L_q is at most 4 L_d, 50 mH for 12.5 mH; the fixed-point twin accepts 1.2. An observer
 * with a slope of 1 and 200 V does not oscillate if (1 - exp(-R T/L))/R is at most 12 mA/V. */
static void test_a_salient_rotor_beyond_what_was_tried_runs_on_an_encoder_only(void)
{
    const double resistance = 0.95 + 0.0215;
    const double x =
        0.012 * resistance; /* the logarithm as a series, which is exact with a double of 32 bits too */
    const float ringing = (float)(1e-4 / 0.012 / (1.0 + x * (1.0 / 2.0 + x * (1.0 / 3.0 + x / 4.0))));
    const float most = CHOSEN_SALIENT_MAX * 12.5e-3f;
    const rule_t on_the_estimator = {"motor_inductance_q", 0.99f * most, 1.01f * most, ringing, most,
                                     ROUND_ROTORS_OBSERVER}; /* i_d needs a larger observer_gain */
    check_rule(&on_the_estimator);
    params.motor_inductance_q = 1.01f * most;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_NOT_NULL(strstr(why.rule, "motor_inductance_q <= " CHOSEN_SALIENT " motor_inductance_d"));
    TEST_ASSERT_NOT_NULL(strstr(why.rule, "use an encoder"));

    params.position_source = POSITION_ENCODER;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.encoder_fault_reaction = ENCODER_FAULT_IGNORED;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.encoder_fault_reaction = ENCODER_FAULT_SENSORLESS; /* which would use the estimator */
    expect_rule("motor_inductance_q", ringing, most);
}

/* The largest L_q for this L_d is 6 mH, and the observer needs at least 8.3 mH: only an encoder permits
 * this motor. */
static void test_a_salient_rotor_is_advised_an_encoder(void)
{
    set_rows(&params, ROUND_ROTORS_OBSERVER);
    params.motor_inductance_d = 6e-3f / CHOSEN_SALIENT_MAX;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("motor_inductance_q", why.field);
    TEST_ASSERT_TRUE(params_none_accepted(&why));
    TEST_ASSERT_EQUAL_UINT32(row_of("position_source")->id, why.change);
}

/* By the rules k_s is 1.25 times the EMF at overspeed_trip, 0.183 x 4 x 220 = 161.04 V, and a_f = 1.6
 * L/(k_s T_s). A configured slope keeps the gain of the observer's loop while L is learnt. */
static void test_the_observer_follows_motor_and_trip_where_its_rows_are_zero(void)
{
    params_defaults(&params);
    assumed_t assumed = params_configured(&params);
    observer_rows_t observer = params_observer(&params, &assumed);
    const double slope = 1.6 * 12.5e-3 / (1.25 * 161.04 * (double)DRIVE_PERIOD);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 201.3f, observer.gain);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f * (float)slope, (float)slope, observer.slope);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, (float)(4.0 / slope), observer.current_max);
    params.observer_gain = 400.0f;
    params.overspeed_trip = 440.0f;
    assumed.inductance_q = 1.2f * params.motor_inductance_q; /* a learnt value */
    observer = params_observer(&params, &assumed);
    TEST_ASSERT_EQUAL_FLOAT(400.0f, observer.gain);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, (float)(1.2 * slope * 201.3 / 400.0), observer.slope);
    params.observer_slope = 0.5f;
    params.estimate_current_max = 7.0f;
    observer = params_observer(&params, &assumed);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.6f, observer.slope);
    TEST_ASSERT_EQUAL_FLOAT(7.0f, observer.current_max);
}

static loop_params_t loop_of(float inertia, float current_limit)
{
    params_defaults(&params);
    params.motor_inertia = inertia;
    params.current_limit = current_limit;
    const assumed_t assumed = params_configured(&params);
    return params_loop(&params, &assumed);
}

/* The cutoff is 1.6 sqrt(p T/J), where T is half of the torque at the current limit and K_t = 1.098 N m/A;
 * at least 50 rad/s, at most 0.025 per period. The loop has four times this bandwidth. */
static void test_the_tracking_loop_follows_inertia_and_current_limit(void)
{
    const loop_params_t rig = loop_of(0.0636f, 10.0f); /* 29.7 rad/s */
    TEST_ASSERT_EQUAL_FLOAT(50.0f, rig.cutoff);
    TEST_ASSERT_EQUAL_FLOAT(200.0f, rig.bandwidth);
    const loop_params_t bare = loop_of(0.003f, 10.0f);
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 136.9f, bare.cutoff); /* 1.6 sqrt(4 x 5.49/0.003) */
    TEST_ASSERT_FLOAT_WITHIN(0.4f, 547.6f, bare.bandwidth);
    const loop_params_t weak = loop_of(0.003f, 5.0f);
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 96.8f, weak.cutoff);
    const loop_params_t tiny = loop_of(1e-5f, 10.0f);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 0.025f / DRIVE_PERIOD, tiny.cutoff);
    TEST_ASSERT_FALSE(rig.slow || bare.slow || weak.slow || tiny.slow);
}

/* A configured bandwidth of 0.6 of that by the rule is accepted: 328.6 rad/s for the bare motor. */
static void test_a_configured_loop_is_used_and_reported_slow_below_its_share_of_the_rule(void)
{
    static const struct {
        float inertia, bandwidth;
        bool slow;
    } cases[] = {
        {0.003f, 328.0f, true}, {0.003f, 329.0f, false}, {0.0636f, 72.0f, false}, {0.0636f, 71.0f, true}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        params_defaults(&params);
        params.motor_inertia = cases[n].inertia;
        params.pll_bandwidth = cases[n].bandwidth;
        params.feedforward_cutoff = 25.0f;
        TEST_ASSERT_TRUE(params_check(&params, &why));
        const assumed_t assumed = params_configured(&params);
        const loop_params_t loop = params_loop(&params, &assumed);
        TEST_ASSERT_EQUAL_FLOAT(cases[n].bandwidth, loop.bandwidth);
        TEST_ASSERT_EQUAL_FLOAT(25.0f, loop.cutoff);
        TEST_ASSERT_EQUAL(cases[n].slow, loop.slow);
    }
}

/* ---- the start ---- */

static start_params_t start_of(void)
{
    const assumed_t assumed = params_configured(&params);
    return params_start(&params, &assumed);
}

/* 2.5 us/100 us of 400 V are 10 V, and R I is 9.7 V. With psi_f p = 0.732 V s the hand-over is at 1.15 x
 * 10 V/0.732 V s = 15.71 rad/s, and the other speeds are 0.4 and 0.5 of it. The ramp is 15 % of 1.5 x
 * 0.732 Wb x 10 A/0.0636 kg m^2, which is 25.9 rad/s^2. */
static void test_a_start_goes_by_rules_where_the_rows_are_0(void)
{
    start_params_t start = start_of();
    TEST_ASSERT_EQUAL_FLOAT(10.0f, start.current);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 10.0f, start.dead_voltage);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 15.710f, start.handover_speed);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 6.284f, start.fallback_speed);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 7.855f, start.catch_speed);
    TEST_ASSERT_FLOAT_WITHIN(1e-2f, 25.90f, start.ramp);
    TEST_ASSERT_FLOAT_WITHIN(1e-2f, 25.90f, start.stop_ramp);
    params.motor_resistance = 2.0f; /* R I is 2.0215 ohm x 10 A */
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 31.758f, start_of().handover_speed);
    params.overspeed_trip = 100.0f; /* at most 0.3 of it */
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 30.0f, start_of().handover_speed);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 15.0f, start_of().catch_speed);
    params.motor_inertia = 0.003f; /* 30 rad/s within 0.3 s, not 549 rad/s^2, which a quick stop uses */
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 100.0f, start_of().ramp);
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 549.0f, start_of().stop_ramp);
    TEST_ASSERT_TRUE(params_check(&params, &why));
}

/* With L = 0.1 H and 20 mA of noise L n/T is 20 V. The low-pass of 2500 rad/s has the share a = 1 - exp(-1/4)
 * = 0.2212, and leaves a/(1 - a/2)^(1/2) = 0.23456 of it, 4.691 V. The hand-over is at 8.2 times this over
 * 0.732 V s. Without the low-pass 2^(1/2) of 20 V is left, which is limited to 0.3 of the trip. Dead time and
 * resistance alone need 15.71 rad/s as before. */
static void test_noise_of_the_currents_moves_the_hand_over(void)
{
    params.motor_inductance_d = params.motor_inductance_q = 0.1f;
    learnt_t learnt = {.noise_square = 0.02f * 0.02f};
    assumed_t assumed = drive_assumed(&params, &learnt);
    TEST_ASSERT_FLOAT_WITHIN(1e-7f, 0.02f, assumed.noise);
    TEST_ASSERT_FLOAT_WITHIN(5e-3f, 52.551f, params_start(&params, &assumed).handover_speed);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 15.710f, params_start(&params, &assumed).visible_speed);
    params.observer_emf_cutoff = 0.0f;
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.3f * params.overspeed_trip,
                             params_start(&params, &assumed).handover_speed);
    params.handover_speed = 25.0f; /* a configured speed is used */
    TEST_ASSERT_EQUAL_FLOAT(25.0f, params_start(&params, &assumed).handover_speed);
    TEST_ASSERT_EQUAL_FLOAT(25.0f, params_start(&params, &assumed).visible_speed);
}

/* Of 3.9 mA the low-pass leaves at most 2^(1/2) x 2500 rad/s x L n = 1.379 V, and 8.2 times this are 11.3 V,
 * less than 1.15 x 10 V; the noise then makes no new tuning, and neither does that of a salient rotor. */
static void test_noise_without_effect_is_not_assumed(void)
{
    params.motor_inductance_d = params.motor_inductance_q = 0.1f;
    learnt_t learnt = {.noise_square = 3.9e-3f * 3.9e-3f};
    const assumed_t configured = params_configured(&params);
    const assumed_t quiet = drive_assumed(&params, &learnt);
    TEST_ASSERT_FALSE(assumed_moved(&configured, &quiet));
    learnt.noise_square = 4.0e-3f * 4.0e-3f;
    const assumed_t loud = drive_assumed(&params, &learnt);
    TEST_ASSERT_TRUE(assumed_moved(&configured, &loud));
    TEST_ASSERT_FALSE(assumed_moved(&loud, &loud));
    params.motor_inductance_d = 0.02f;
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive_assumed(&params, &learnt).noise);
}

static void test_a_start_goes_by_the_rows_where_they_are_not_0(void)
{
    set_rows(&params, "start_current=6 start_ramp=12 handover_speed=25 fallback_speed=9 start_speed=11");
    start_params_t start = start_of();
    TEST_ASSERT_EQUAL_FLOAT(6.0f, start.current);
    TEST_ASSERT_EQUAL_FLOAT(12.0f, start.ramp);
    TEST_ASSERT_EQUAL_FLOAT(12.0f, start.stop_ramp);
    TEST_ASSERT_EQUAL_FLOAT(25.0f, start.handover_speed);
    TEST_ASSERT_EQUAL_FLOAT(9.0f, start.fallback_speed);
    TEST_ASSERT_EQUAL_FLOAT(11.0f, start.catch_speed);
    params.fallback_speed = 0.0f; /* by rule 0.4 and 0.5 of the configured value */
    params.start_speed = 0.0f;
    TEST_ASSERT_EQUAL_FLOAT(10.0f, start_of().fallback_speed);
    TEST_ASSERT_EQUAL_FLOAT(12.5f, start_of().catch_speed);
    TEST_ASSERT_TRUE(params_check(&params, &why));
}

/* A rotor must turn by 10 rad/s, electrical, so that a catch can measure its direction: with one pole pair
 * and the hand-over at 1.15 x 10 V/1.15 V s, 10 rad/s, this is the hand-over itself; with a third of this
 * psi_f half of the hand-over, 15 rad/s, is more. With two pole pairs of half this psi_f it is 5 rad/s. */
static void test_no_rotor_is_caught_whose_direction_cannot_be_measured(void)
{
    params.motor_resistance = 0.1f; /* R I below 10 V */
    params.motor_pole_pairs = 1;
    params.motor_flux_linkage = 1.15f;
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 10.0f, start_of().handover_speed);
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 10.0f, start_of().catch_speed);
    params.motor_flux_linkage = 1.15f / 3.0f;
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 15.0f, start_of().catch_speed);
    params.motor_pole_pairs = 2;
    params.motor_flux_linkage = 1.15f / 1.6f; /* half of the hand-over is 4 rad/s */
    TEST_ASSERT_FLOAT_WITHIN(1e-3f, 5.0f, start_of().catch_speed);
}

static void test_by_rule_a_start_catches_below_its_hand_over(void)
{
    for (params.handover_speed = 110.0f; params.handover_speed > 1e-3f; params.handover_speed *= 0.1f) {
        TEST_ASSERT_TRUE(params_check(&params, &why));
        TEST_ASSERT_TRUE(start_of().catch_speed <= start_of().handover_speed);
    }
}

/* The paper's motor, with a different value in each parameter that the estimator reads. */
static void test_estimators_set_is_made_of_the_rows(void)
{
    estimator_params_t estimator;
    /* J has the configured value; the observer uses L_q. */
    set_rows(&params,
             "torque_feedforward=0.5 inertia_adaptation=off motor_inductance_d=12e-3 flux_adaptation=2 "
             "lag_compensation=printed observer_switching=sigmoid observer_emf_cutoff=1800 "
             "observer_gain=190 observer_slope=0.9 estimate_amplitude_min=0.4 estimate_amplitude_max=1 "
             "estimate_detector_max=0.45 estimate_current_max=3.5 estimate_speed_min=2.5 "
             "estimate_time=0.07");
    const assumed_t assumed = params_configured(&params);
    params_estimator(&params, &assumed, &estimator);
    TEST_ASSERT_TRUE(estimator_params_check(&estimator, &why));
    TEST_ASSERT_EQUAL_FLOAT(0.9715f, estimator.smo.resistance); /* 21.5 mohm of the devices */
    TEST_ASSERT_EQUAL_FLOAT(0.9715f, params_configured(&params).resistance);
    TEST_ASSERT_EQUAL_FLOAT(12.5e-3f, estimator.smo.inductance);
    TEST_ASSERT_EQUAL_FLOAT(190.0f, estimator.smo.gain);
    TEST_ASSERT_EQUAL_FLOAT(0.9f, estimator.smo.slope);
    TEST_ASSERT_EQUAL_FLOAT(1800.0f, estimator.smo.emf_cutoff);
    TEST_ASSERT_EQUAL_FLOAT(1e-4f, estimator.smo.period);
    TEST_ASSERT_EQUAL_INT(SMO_SIGMOID, estimator.smo.switching);
    TEST_ASSERT_EQUAL_INT(LAG_PRINTED, estimator.lag);
    pll_params_t loop = {.amplitude_floor = 2.0f};
    TEST_ASSERT_TRUE(pll_design(&loop, 200.0f, 1.0f, 50.0f, 1e-4f));
    TEST_ASSERT_EQUAL_FLOAT(loop.kp, estimator.pll.kp);
    TEST_ASSERT_EQUAL_FLOAT(loop.ki, estimator.pll.ki);
    TEST_ASSERT_EQUAL_FLOAT(50.0f, estimator.pll.feedforward_cutoff);
    TEST_ASSERT_EQUAL_FLOAT(1e-4f, estimator.pll.period);
    TEST_ASSERT_FLOAT_WITHIN(0.02f, 2.0f, estimator.pll.amplitude_floor); /* 0.183 Wb at 11 rad/s */
    TEST_ASSERT_EQUAL_FLOAT(0.183f, estimator.flux_linkage);
    TEST_ASSERT_FLOAT_WITHIN(1e-8f, 0.5e-3f, estimator.saliency);
    TEST_ASSERT_EQUAL_FLOAT(0.183f, estimator.flux_most); /* i_d stays at 0 for an almost round rotor */
    TEST_ASSERT_EQUAL_FLOAT(2.0f, estimator.flux_adaptation);
    TEST_ASSERT_EQUAL_FLOAT(0.5f * 4.392f / 0.0636f, estimator.torque_feedforward);
    TEST_ASSERT_EQUAL_FLOAT(0.4f, estimator.validity.amplitude_min);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, estimator.validity.amplitude_max); /* 1 switches the check off */
    TEST_ASSERT_EQUAL_FLOAT(0.45f, estimator.validity.detector_max);
    TEST_ASSERT_EQUAL_FLOAT(3.5f, estimator.validity.current_max);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, estimator.validity.speed_min);  /* electrical */
    TEST_ASSERT_EQUAL_FLOAT(880.0f, estimator.validity.speed_max); /* also electrical */
    TEST_ASSERT_EQUAL_FLOAT(0.07f, estimator.validity.amplitude_time);
    TEST_ASSERT_EQUAL_FLOAT(0.07f, estimator.validity.detector_time);
    TEST_ASSERT_EQUAL_FLOAT(0.07f, estimator.validity.current_time);
    TEST_ASSERT_EQUAL_FLOAT(0.07f, estimator.validity.speed_time);
    params.estimate_amplitude_max = 1.01f;
    params_estimator(&params, &assumed, &estimator);
    TEST_ASSERT_EQUAL_FLOAT(1.01f, estimator.validity.amplitude_max);
}

#define SALIENT "motor_inductance_q=20e-3 motor_inductance_d=10e-3 motor_flux_linkage=0.1 current_limit=10 "

/* psi_f is 0.1 Wb, D 10 mH and the current 10 A. The i_d of most torque per ampere is -2 D I^2/(psi_f +
 * sqrt(psi_f^2 + 8 D^2 I^2)) = -5 A, so that psi_a is 0.15 Wb with an i_q of 8.66 A. With p 4, 200 rad/s
 * and J 0.01 the torque at the limit is 7.794 N m, and the bandwidth 6.4 sqrt(4 x 3.897/0.01) = 252.7
 * rad/s. ki is the square of 0.403 times the bandwidth, and the cutoff is ki/(0.6 x 800). */
static void test_a_salient_rotor_has_more_flux_and_a_slower_feedforward(void)
{
    /* Without an encoder the fixed-point twin refuses such a rotor. */
    params.position_source = POSITION_ENCODER;
    set_rows(&params, SALIENT "motor_inertia=0.01 overspeed_trip=200 field_weakening=off");
    const assumed_t assumed = params_configured(&params);
    estimator_params_t estimator;
    params_estimator(&params, &assumed, &estimator);
    TEST_ASSERT_FLOAT_WITHIN(1e-8f, 10e-3f, estimator.saliency);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.15f, estimator.flux_most);
    TEST_ASSERT_FLOAT_WITHIN(0.05f, 21.6f, estimator.pll.feedforward_cutoff);
    params.observer_gain = 1.1f * 0.15f * 800.0f * 1.001f;
    TEST_ASSERT_TRUE(params_check(&params, &why));
    params.observer_gain = 1.1f * 0.15f * 800.0f * 0.999f;
    TEST_ASSERT_FALSE(params_check(&params, &why));
    TEST_ASSERT_EQUAL_STRING("observer_gain", why.field);
    params.mtpa = MTPA_OFF;
    TEST_ASSERT_TRUE(params_check(&params, &why));
}

/* For the same rotor psi_f/L_d is 10 A too, so that at any speed the weakest field takes all of the
 * current, and the active flux is psi_f + D I. At a speed that the link voltage allows it is that of most
 * torque per ampere. */
static void test_a_weakened_field_has_more_active_flux(void)
{
    set_rows(&params, SALIENT "overspeed_trip=20");
    const assumed_t assumed = params_configured(&params);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.15f, params_flux_most(&params, &assumed));
    float last = 0.15f;
    for (float speed = 300.0f; speed < 1200.0f; speed *= 1.5f) {
        params.overspeed_trip = speed;
        const float flux = params_flux_most(&params, &assumed);
        TEST_ASSERT_TRUE(flux > last && flux < 0.2f);
        last = flux;
    }
    params.overspeed_trip = 1200.0f;
    params.dc_undervoltage = 10.0f;
    TEST_ASSERT_FLOAT_WITHIN(2e-3f, 0.2f, params_flux_most(&params, &assumed));
    params.motor_inductance_d = 20e-3f;
    const assumed_t round = params_configured(&params);
    TEST_ASSERT_EQUAL_FLOAT(0.1f, params_flux_most(&params, &round));
}

/* The torque is 1.5 p psi_f I for a round rotor; for the salient rotor above it follows from -5 A and
 * psi_a 0.15 Wb. */
static void test_the_most_torque_is_that_of_current_limit(void)
{
    set_rows(&params, SALIENT);
    assumed_t assumed = params_configured(&params);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 1.5f * 4.0f * 0.15f * 8.660254f, params_torque_most(&params, &assumed));
    params.mtpa = MTPA_OFF;
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 1.5f * 4.0f * 0.1f * 10.0f, params_torque_most(&params, &assumed));
    params.motor_inductance_d = 20e-3f;
    assumed = params_configured(&params);
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 1.5f * 4.0f * 0.1f * 10.0f, params_torque_most(&params, &assumed));
}

static void test_only_live_rows_change_while_the_bridge_is_on(void)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        params_t next = params;
        table_set(row, &next, table_get(row, &params) != table_max(row) ? table_max(row) : table_min(row));
        const bool live = params_check_live(&params, &next, &why);
        TEST_ASSERT_EQUAL_MESSAGE(row->access == TABLE_LIVE, live, row->name);
        if (!live) {
            TEST_ASSERT_EQUAL_UINT32(row->id, why.id);
            TEST_ASSERT_EQUAL_INT32(REASON_BRIDGE_ON, why.reason);
        }
    }
}

/* docs/theory.md, 16: 2.5 us dead time and a 1.5 us pulse make 300 of 7500 counts. */
static void test_smallest_duty_holds_dead_time_and_shortest_pulse(void)
{
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 300.0f / 7500.0f, params_duty_min(&params));
}

static void test_requests_are_refused_beyond_what_the_parameters_allow(void)
{
    static const struct {
        const char *field;
        float value, max; /* max NAN: the value is accepted */
        /* The limit is 0.95 of 220 rad/s. */
    } cases[] = {{"speed_request", -209.0f, NAN}, {"speed_request", -211.2f, 209.0f},
                 {"i_q_request", 10.0f, NAN},     {"i_q_request", 10.1f, 10.0f},
                 {"i_d_request", -10.1f, 10.0f},  {"enable", 3.0f, 2.0f},
                 {"speed_request", NAN, 209.0f}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        requests_t requests;
        requests_defaults(&requests);
        table_set(table_by_name(&requests_table, cases[n].field), &requests, cases[n].value);
        TEST_ASSERT_EQUAL_MESSAGE(isnan(cases[n].max), requests_check(&requests, &params, &why),
                                  cases[n].field);
        if (!isnan(cases[n].max)) {
            TEST_ASSERT_EQUAL_STRING(cases[n].field, why.field);
            TEST_ASSERT_FLOAT_WITHIN(1e-3f, cases[n].max, why.max);
        }
    }
}
