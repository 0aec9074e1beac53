/* A drive that runs without an encoder does not read it: two simulations, one of them with a broken
 * encoder, give the same bits. */
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

/* One part of a run without the encoder: a cold start, a load, another speed, a reversal and a stop. */
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

/* Runs the next period of both; every signal except those of the encoder must be the same to the bit. */
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

/* The second simulation has an encoder with four counts per turn instead of 10000; from the reversal on it
 * has an encoder whose two tracks sometimes change at once. */
static void test_without_the_encoder_no_signal_depends_on_its_count(void)
{
    const table_t *signals = NULL;
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        signals = strcmp(rig_table(n)->name, "signals") == 0 ? rig_table(n) : signals;
    }
    TEST_ASSERT_NOT_NULL(signals);
    rig_t *broken = run_rig(3);
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
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state")); /* the stop has ended */
    TEST_ASSERT_TRUE(ran > 295.0 * RPM);
    TEST_ASSERT_TRUE(fastest < -295.0 * RPM);
    TEST_ASSERT_TRUE(apart > 100.0); /* [rad/s] the encoders show different speeds */
    TEST_ASSERT_TRUE(seen > 0u);
    rig_free(broken);
}
