/* What a start of the motor hangs on, through the door of the rig: where the rotor stands and whether it is
 * free, a brake, an estimate that is wrong. */
#include <stdlib.h>

#include "tests/rig/run.h"

#define PI 3.14159265358979323846

static rig_t *rig;

void setUp(void)
{
    rig = run_rig(3);
    run_paper_drive(rig);
    run_shaft_of_board(rig);
    TEST_ASSERT_TRUE(rig_apply(rig));
}

void tearDown(void)
{
    rig_free(rig);
}

/* Encoder mode at a steady speed; the estimator works beside it. */
static void run_up(double rpm)
{
    run_to_ready(rig);
    run_on(rig, rpm);
    run_seconds(rig, 1.5);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * rpm, rpm, rig_value(rig, "true_omega_m") / RPM);
}

/* ---- a shaft that sticks ---- */

static void test_standing_rotor_stays_where_the_start_put_it(void)
{
    run_put(rig, "load_kind", 1.0);
    run_put(rig, "friction_breakaway", 2.0);
    run_put(rig, "load_torque", 1.99);
    rig_set_motion(rig, 2.5, 0.0);
    run_to_ready(rig);
    const double angle = rig_value(rig, "true_theta_e");
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, remainder(4.0 * 2.5, 2.0 * PI), angle);
    TEST_ASSERT_DOUBLE_WITHIN(4.0 * 2.0 * PI / 10000.0, angle, rig_value(rig, "encoder_theta_e"));
    run_seconds(rig, 0.5);
    TEST_ASSERT_EQUAL_DOUBLE(angle, rig_value(rig, "true_theta_e"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "true_omega_m"));
}

static void test_motor_current_breaks_the_shaft_loose_beyond_break_away_only(void)
{
    /* Half the limit's torque holds; in current mode i_q sets the torque. */
    const double torque = RUN_TORQUE(5.0) * RUN_LIMIT_SHARE;
    run_put(rig, "friction_breakaway", torque);
    run_to_ready(rig);
    run_put(rig, "mode", 1.0);
    run_put(rig, "enable", 1.0);
    run_put(rig, "i_q_request", 0.97 * 5.0 * RUN_LIMIT_SHARE);
    run_seconds(rig, 0.2);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * torque, 0.97 * torque, rig_value(rig, "true_torque"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "true_omega_m"));
    run_put(rig, "i_q_request", 1.03 * 5.0 * RUN_LIMIT_SHARE);
    run_seconds(rig, 0.2);
    const double omega =
        (1.03 * torque - rig_value(rig, "friction_coulomb")) / rig_value(rig, "inertia") * 0.2;
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * omega, omega, rig_value(rig, "true_omega_m"));
}

static void test_break_away_below_dry_friction_is_refused_whichever_is_set(void)
{
    run_put(rig, "friction_coulomb", 1.5);
    TEST_ASSERT_FALSE(rig_put(rig, "friction_breakaway", 1.4));
    TEST_ASSERT_EQUAL_STRING("friction_breakaway = 1.4 N m: accepted 1.5 to 1000 N m "
                             "(or 0: friction_breakaway is no less than friction_coulomb)",
                             rig_error(rig));
    run_put(rig, "friction_breakaway", 1.5);
    TEST_ASSERT_FALSE(rig_put(rig, "friction_coulomb", 1.6));
    TEST_ASSERT_EQUAL_UINT32(rig_row_by_name("friction_breakaway")->id, rig_error_id(rig));
    TEST_ASSERT_EQUAL_DOUBLE(1.5, rig_value(rig, "friction_coulomb"));
}

/* ---- brake ---- */

static void test_brake_stops_the_running_drive_holds_it_and_lets_it_go_on(void)
{
    run_up(500.0);
    run_put(rig, "brake_torque", 60.0);
    /* J w/(T_brake - T of the limit) is 67 ms. */
    run_seconds(rig, 0.08);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "true_omega_m"));
    const double angle = rig_value(rig, "true_theta_e");
    run_seconds(rig, 0.3);
    TEST_ASSERT_TRUE(rig_value(rig, "true_torque") > 0.9 * RUN_TORQUE(10.0) * RUN_LIMIT_SHARE);
    TEST_ASSERT_EQUAL_DOUBLE(angle, rig_value(rig, "true_theta_e"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "true_omega_m"));
    TEST_ASSERT_EQUAL_DOUBLE(60.0, rig_value(rig, "brake_torque"));
    run_put(rig, "brake_torque", 0.0);
    run_seconds(rig, 1.5);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(5.0, 500.0, rig_value(rig, "true_omega_m") / RPM);
}

/* ---- an estimate that is wrong ---- */

static void test_angle_of_the_estimate_jumps_once_and_comes_back(void)
{
    static const double jumps[] = {0.5, -1.2, 0.5};
    run_up(500.0);
    for (size_t n = 0; n < sizeof jumps / sizeof jumps[0]; n++) {
        const double before = rig_value(rig, "theta_hat_err");
        const double amplitude = rig_value(rig, "e_amplitude");
        run_put(rig, "estimate_jump", jumps[n]);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "estimate_jump"));
        rig_step(rig);
        TEST_ASSERT_DOUBLE_WITHIN(5e-3, jumps[n], rig_value(rig, "theta_hat_err") - before);
        /* The EMF that the loop has seen has not moved. */
        TEST_ASSERT_DOUBLE_WITHIN(0.05 * amplitude, amplitude, rig_value(rig, "e_amplitude"));
        const double after = rig_value(rig, "theta_hat_err");
        rig_step(rig);
        TEST_ASSERT_TRUE(fabs(rig_value(rig, "theta_hat_err") - after) < 0.1 * fabs(jumps[n]));
        run_seconds(rig, 0.3);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, before, rig_value(rig, "theta_hat_err"));
        run_expect_no_fault(rig);
    }
    TEST_ASSERT_FALSE(rig_put(rig, "estimate_jump", 3.2));
    TEST_ASSERT_TRUE(rig_put(rig, "estimate_jump", PI));
}

/* ---- the encoder ---- */

/* A cold start, a load, another speed, a reversal and a stop, all without the encoder. */
static void next_part_of_a_run(rig_t *of, uint32_t n)
{
    switch (n) {
    case 0:
        run_on(of, 300.0);
        break;
    case 25000:
        run_put(of, "load_torque", 2.0 * RUN_LIMIT_SHARE);
        break;
    case 30000:
        run_put(of, "load_torque", 0.0);
        run_put(of, "speed_request", -300.0 * RPM);
        break;
    case 60000:
        run_put(of, "enable", 2.0);
        break;
    default:
        break;
    }
}

/* The next period of both; every signal is the same to the bit but those of the encoder itself. */
static void expect_same_period(rig_t *one, rig_t *other, const table_t *signals)
{
    static const char *const of_encoder[] = {"encoder_count", "encoder_theta_e", "encoder_omega_e",
                                             "sample_flags"};
    rig_step(one);
    rig_step(other);
    for (uint32_t n = 0; n < signals->count; n++) {
        double value[2] = {0.0, 0.0};
        bool shows_it = false;
        for (size_t m = 0; m < sizeof of_encoder / sizeof of_encoder[0]; m++) {
            shows_it = shows_it || strcmp(signals->rows[n].name, of_encoder[m]) == 0;
        }
        TEST_ASSERT_TRUE(rig_get(one, signals->rows[n].id, &value[0]));
        TEST_ASSERT_TRUE(rig_get(other, signals->rows[n].id, &value[1]));
        if (!shows_it) {
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value[0], value[1], signals->rows[n].name);
        }
    }
}

/* The same rig once more, with an encoder that all but stands, four counts a turn in place of 10000, and from
 * the reversal on one whose tracks change both at once now and then. */
static void test_without_the_encoder_no_signal_hangs_on_what_it_shows(void)
{
    const table_t *signals = NULL;
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        signals = strcmp(rig_table(n)->name, "signals") == 0 ? rig_table(n) : signals;
    }
    TEST_ASSERT_NOT_NULL(signals);
    rig_t *broken = run_rig(3);
    rig_free(rig);
    rig = run_rig(3);
    run_put(broken, "plant.encoder_lines", 1.0);
    run_to_ready(rig);
    run_to_ready(broken);
    double apart = 0.0;
    uint32_t seen = 0;
    double ran = 0.0;
    double fastest = 0.0;
    for (uint32_t n = 0; n < 70000u; n++) {
        next_part_of_a_run(rig, n);
        next_part_of_a_run(broken, n);
        if (n % 3000u == 1500u) {
            run_put(broken, "plant.encoder_lines", n < 30000u ? 1.0 : 2500.0);
            run_put(broken, "plant.encoder_offset", n % 6000u == 1500u ? 50.0 : 0.0);
        }
        expect_same_period(rig, broken, signals);
        seen += ((uint32_t)rig_value(broken, "sample_flags") & DRIVE_SAMPLE_ENCODER) != 0u;
        apart = fmax(apart, fabs(rig_value(rig, "encoder_omega_e") - rig_value(broken, "encoder_omega_e")));
        ran = fmax(ran, rig_value(rig, "manoeuvre") == (double)MANOEUVRE_RUN
                            ? fabs(rig_value(rig, "true_omega_m"))
                            : 0.0);
        fastest = fmin(fastest, rig_value(rig, "true_omega_m"));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state")); /* the stop ended */
    TEST_ASSERT_TRUE(ran > 295.0 * RPM);
    TEST_ASSERT_TRUE(fastest < -295.0 * RPM);
    TEST_ASSERT_TRUE(apart > 100.0); /* [rad/s]: the two encoders do not show the same */
    TEST_ASSERT_TRUE(seen > 0u);
    rig_free(broken);
}

/* ---- as a state ---- */

static uint64_t eventful(void)
{
    run_put(rig, "estimate_jump", 0.7);
    run_seconds(rig, 0.05);
    run_put(rig, "brake_torque", 0.0);
    run_seconds(rig, 0.05);
    run_put(rig, "brake_torque", 20.0);
    run_seconds(rig, 0.2);
    return rig_hash(rig);
}

static void test_a_run_with_brake_jump_and_break_away_is_replayed_bit_for_bit(void)
{
    run_put(rig, "friction_breakaway", 2.0);
    run_up(300.0);
    run_put(rig, "brake_torque", 30.0);
    run_seconds(rig, 0.013); /* slowing down */
    TEST_ASSERT_TRUE(rig_value(rig, "true_omega_m") > 0.0);
    void *state = malloc(rig_state_size());
    TEST_ASSERT_NOT_NULL(state);
    rig_save(rig, state);
    const uint64_t begin = rig_hash(rig);
    const uint64_t end = eventful();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "true_omega_m"));
    rig_free(rig);
    rig = run_rig(99);
    TEST_ASSERT_TRUE(rig_load(rig, state, rig_state_size()));
    free(state);
    TEST_ASSERT_EQUAL_HEX64(begin, rig_hash(rig));
    TEST_ASSERT_EQUAL_HEX64(end, eventful());
    TEST_ASSERT_TRUE(begin != end);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_standing_rotor_stays_where_the_start_put_it);
    SEED_RUN_EIGHT(test_motor_current_breaks_the_shaft_loose_beyond_break_away_only);
    RUN_TEST(test_break_away_below_dry_friction_is_refused_whichever_is_set);
    SEED_RUN_EIGHT(test_brake_stops_the_running_drive_holds_it_and_lets_it_go_on);
    SEED_RUN_EIGHT(test_angle_of_the_estimate_jumps_once_and_comes_back);
    RUN_TEST(test_without_the_encoder_no_signal_hangs_on_what_it_shows);
    RUN_TEST(test_a_run_with_brake_jump_and_break_away_is_replayed_bit_for_bit);
    return UNITY_END();
}
