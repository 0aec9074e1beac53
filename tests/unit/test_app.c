/* The application above a board that writes down what it is asked: the start and a start that fails, what
 * goes to the registers when parameters change, and that the interrupt sees no change half done. */
#include <string.h>
#include <unity.h>

#include "app/app.h"
#include "drive/reasons.h"

/* ---- the board ---- */

static char asked[512];
static hal_config_t config;
static hal_status_t status;      /* what hal_init says */
static hal_samples_t conversion; /* what hal_read gives */
static bool interrupts_on;
static bool interrupts_wrong; /* off twice, or on twice */
static uint32_t dead_band, encoder_max;
static uint32_t fed;
static bool led_run, led_fault;

static app_t the_app;
static drive_t seen;      /* the drive as an interrupt would find it */
static bool bridge_comes; /* with the interrupt just before the next time that they are off */

static void ask(const char *what)
{
    strncat(asked, what, sizeof asked - strlen(asked) - 1u);
}

hal_status_t hal_init(const hal_config_t *with)
{
    ask("init ");
    config = *with;
    interrupts_on = status == HAL_OK;
    return status;
}

void hal_read(hal_samples_t *samples)
{
    ask("read ");
    *samples = conversion;
}

void hal_write_compare(uint16_t a, uint16_t b, uint16_t c)
{
    (void)a;
    (void)b;
    (void)c;
    ask("compare ");
}

void hal_gates_off(void)
{
    ask("gates-off ");
}

bool hal_gates_on(void)
{
    ask("gates-on ");
    return true;
}

void hal_end_of_sample(void)
{
    ask("end-of-sample ");
}

void hal_end_of_trip(void)
{
    ask("end-of-trip ");
}

bool hal_set_dead_band(uint16_t count)
{
    ask("dead-band ");
    dead_band = count;
    return true;
}

bool hal_set_encoder(uint32_t count_max)
{
    ask("encoder ");
    encoder_max = count_max;
    return true;
}

void hal_watchdog_start(void)
{
    ask("watchdog ");
}

void hal_watchdog_feed(void)
{
    fed++;
}

void hal_leds(bool run, bool fault)
{
    led_run = run;
    led_fault = fault;
}

/* Has anything changed that an interrupt would have read? A tuning that is not offered it does not read. */
static bool changed(void)
{
    static drive_t now;
    now = app->drive;
    if (now.offered == 0u) {
        now.offered = seen.offered;
        now.offer = seen.offer;
    }
    return memcmp(&seen, &now, sizeof seen) != 0;
}

void hal_interrupts_off(void)
{
    ask("off ");
    interrupts_wrong |= !interrupts_on || changed();
    interrupts_on = false;
    if (bridge_comes) {
        app->drive.sequence.state = DRIVE_SWITCHED_ON;
        bridge_comes = false;
    }
}

void hal_interrupts_on(void)
{
    ask("on ");
    interrupts_wrong |= interrupts_on;
    interrupts_on = true;
    seen = app->drive;
}

/* ---- the application ---- */

static void start(hal_status_t of_board)
{
    memset(&the_app, 0, sizeof the_app);
    memset(asked, 0, sizeof asked);
    app = &the_app;
    status = of_board;
    fed = 0u;
    dead_band = 0u;
    encoder_max = 0u;
    interrupts_on = false;
    interrupts_wrong = false;
    bridge_comes = false;
    conversion = (hal_samples_t){.current_a = 2048,
                                 .current_b = 2048,
                                 .current_c = 2048,
                                 .dc_link = 2048,
                                 .sink_temperature = 1024,
                                 .motor_temperature = 1024};
    app_start();
    seen = app->drive;
}

/* Since now nothing is asked, and an interrupt may come at any time. */
static void from_here(void)
{
    memset(asked, 0, sizeof asked);
    seen = app->drive;
}

static void given_bridge_on(void)
{
    app->drive.sequence.state = DRIVE_OPERATION_ENABLED;
    from_here();
}

static void interrupt(void)
{
    app_interrupt();
    seen = app->drive;
}

/* More than once round its list. */
static void background(void)
{
    for (int n = 0; n < 12; n++) {
        app_background();
    }
}

static void expect_asked_in_good_order(const char *what)
{
    TEST_ASSERT_EQUAL_STRING(what, asked);
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_TRUE(interrupts_on);
    TEST_ASSERT_EQUAL_MEMORY(&seen, &app->drive, sizeof seen);
}

void setUp(void)
{
    start(HAL_OK);
}

void tearDown(void)
{
}

static void test_a_start_brings_the_board_up_with_the_defaults_and_then_the_watchdog(void)
{
    const params_t *params = &app->active;
    TEST_ASSERT_EQUAL_STRING("init watchdog ", asked);
    TEST_ASSERT_EQUAL_INT32(HAL_OK, app->board_status);
    TEST_ASSERT_EQUAL_INT32(DRIVE_NOT_READY, app->drive.sequence.state);
    TEST_ASSERT_EQUAL_UINT32(4u * 2500u - 1u, config.encoder_count_max);
    TEST_ASSERT_TRUE((double)config.dead_band_count >= (double)params->dead_time * HAL_CLOCK_HZ - 1e-3);
    TEST_ASSERT_TRUE((double)config.dead_band_count < (double)params->dead_time * HAL_CLOCK_HZ + 1.0);
    TEST_ASSERT_TRUE(config.on_sample == app_interrupt);
    TEST_ASSERT_TRUE(config.on_trip == app_trip);
}

/* The drive is in fault and says why; the watchdog is left alone, since no interrupt comes that it could
 * watch, and a reset would end in the same. */
static void test_a_start_that_fails_is_a_fault_and_starts_no_watchdog(void)
{
    static const hal_status_t failures[] = {HAL_CLOCK_MISSING, HAL_PLL_UNLOCKED, HAL_BAD_CONFIG,
                                            HAL_TRIP_FAILED};
    for (size_t n = 0; n < sizeof failures / sizeof failures[0]; n++) {
        start(failures[n]);
        TEST_ASSERT_EQUAL_STRING("init ", asked);
        TEST_ASSERT_EQUAL_INT32(failures[n], app->board_status);
        TEST_ASSERT_EQUAL_INT32(DRIVE_FAULT, app->drive.sequence.state);
        TEST_ASSERT_EQUAL_INT32(REASON_BOARD_FAILED, app->drive.sequence.fault_reason);
        background();
        TEST_ASSERT_EQUAL_UINT32(0u, fed);
        TEST_ASSERT_TRUE(led_fault);
        TEST_ASSERT_FALSE(led_run);
    }
}

static void test_the_watchdog_is_fed_once_for_every_time_that_the_interrupt_was_alive(void)
{
    background();
    TEST_ASSERT_EQUAL_UINT32(0u, fed);
    for (uint32_t n = 1; n <= 3u; n++) {
        interrupt();
        interrupt();
        background();
        TEST_ASSERT_EQUAL_UINT32(n, fed);
    }
}

/* With the interrupt always alive it is fed once a round: the other tasks come between. */
static void test_the_watchdog_is_fed_when_the_list_has_come_round(void)
{
    uint32_t calls = 0u;
    do {
        interrupt();
        app_background();
        calls++;
    } while (fed == 0u && calls < 100u);
    TEST_ASSERT_TRUE(calls > 1u && calls < 100u);
    for (uint32_t n = 0; n < 10u * calls; n++) {
        interrupt();
        app_background();
    }
    TEST_ASSERT_EQUAL_UINT32(11u, fed);
}

static void test_the_background_sees_the_drive_between_two_interrupts_and_shows_it(void)
{
    interrupt();
    background();
    TEST_ASSERT_EQUAL_UINT32(1u, app->seen.period);
    TEST_ASSERT_EQUAL_INT32(DRIVE_NOT_READY, app->seen.state);
    TEST_ASSERT_FALSE(led_run);
    TEST_ASSERT_FALSE(led_fault);
    given_bridge_on();
    background();
    TEST_ASSERT_TRUE(app->seen.bridge_on);
    TEST_ASSERT_TRUE(led_run);
    drive_trip(&app->drive);
    from_here();
    background();
    TEST_ASSERT_EQUAL_INT32(REASON_MODULE_FAULT, app->seen.fault_reason);
    TEST_ASSERT_FALSE(led_run);
    TEST_ASSERT_TRUE(led_fault);
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_TRUE(interrupts_on);
}

static void test_the_interrupt_reads_first_and_acknowledges_last(void)
{
    from_here();
    app_interrupt();
    TEST_ASSERT_EQUAL_STRING("read compare gates-off end-of-sample ", asked);
    from_here();
    app_trip();
    TEST_ASSERT_EQUAL_STRING("end-of-trip ", asked);
}

static void test_each_flag_of_the_board_is_the_drive_s(void)
{
    static const struct {
        uint16_t of_board;
        uint32_t of_drive;
    } flags[] = {{HAL_FLAG_TRIPPED, DRIVE_SAMPLE_TRIPPED},
                 {HAL_FLAG_FAULT_PIN, DRIVE_SAMPLE_FAULT_LINE},
                 {HAL_FLAG_ENCODER, DRIVE_SAMPLE_ENCODER},
                 {HAL_FLAG_LATE, DRIVE_SAMPLE_LATE}};
    for (size_t n = 0; n < sizeof flags / sizeof flags[0]; n++) {
        drive_samples_t samples;
        conversion.flags = flags[n].of_board;
        app_read(&samples);
        TEST_ASSERT_EQUAL_HEX32(flags[n].of_drive, samples.flags);
    }
}

/* ---- parameters and requests ---- */

static void test_a_set_is_offered_with_interrupts_off_and_the_registers_follow(void)
{
    params_error_t why;
    app->staged.encoder_lines = 1024;
    app->staged.dead_time = 3e-6f;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    expect_asked_in_good_order("off dead-band encoder on ");
    TEST_ASSERT_EQUAL_INT32(1024, app->active.encoder_lines);
    TEST_ASSERT_EQUAL_UINT32(4095u, encoder_max);
    TEST_ASSERT_TRUE((double)dead_band >= 3e-6 * HAL_CLOCK_HZ - 1e-3);
    TEST_ASSERT_TRUE((double)dead_band < 3e-6 * HAL_CLOCK_HZ + 1.0);
    interrupt();
    TEST_ASSERT_EQUAL_UINT32(4095u, app->drive.encoder.tuning.last_count);
}

static void test_while_the_bridge_is_on_the_registers_stay(void)
{
    params_error_t why;
    app->staged.speed_kp = 0.7f;
    given_bridge_on();
    TEST_ASSERT_TRUE(app_apply(&why));
    expect_asked_in_good_order("off on ");
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->active.speed_kp);
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->drive.manoeuvres.run.speed.pi.tuning.kp);
}

/* Refused for this row: the drive, its registers and the active set are those of before. */
static void expect_refused(const char *field, int32_t reason)
{
    static drive_t before;
    params_error_t why;
    const params_t active = app->active;
    from_here();
    before = app->drive;
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_EQUAL_STRING(field, why.field);
    TEST_ASSERT_EQUAL_INT32(reason, why.reason);
    TEST_ASSERT_EQUAL_MEMORY(&before, &app->drive, sizeof before);
    TEST_ASSERT_EQUAL_MEMORY(&active, &app->active, sizeof active);
    TEST_ASSERT_NULL(strstr(asked, "encoder"));
    TEST_ASSERT_NULL(strstr(asked, "dead-band"));
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_TRUE(interrupts_on);
}

static void test_a_bad_set_is_refused_and_changes_nothing(void)
{
    app->staged.speed_kp = -1.0f;
    app->staged.encoder_lines = 1024;
    expect_refused("speed_kp", REASON_OUT_OF_RANGE);
}

static void test_a_set_that_the_present_request_would_violate_is_refused(void)
{
    app->drive.requests.speed_request = 200.0f;
    app->staged.overspeed_trip = 150.0f;
    expect_refused("speed_request", REASON_CROSS_RULE);
}

static void test_what_changes_only_with_the_bridge_off_is_refused_while_it_is_on(void)
{
    given_bridge_on();
    app->staged.encoder_lines = 1024;
    expect_refused("encoder_lines", REASON_BRIDGE_ON);
}

/* The bridge was off when the set was judged, and on when it was to be offered. */
static void test_a_bridge_that_comes_on_meanwhile_keeps_the_old_set(void)
{
    params_error_t why;
    app->staged.encoder_lines = 1024;
    from_here();
    bridge_comes = true;
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_EQUAL_INT32(REASON_BRIDGE_ON, why.reason);
    TEST_ASSERT_EQUAL_STRING("off on ", asked);
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_EQUAL_INT32(2500, app->active.encoder_lines);
    interrupt();
    TEST_ASSERT_EQUAL_UINT32(9999u, app->drive.encoder.tuning.last_count);
}

/* Sets that follow each other faster than the interrupt: the last good one counts, and whole. */
static void test_the_last_good_set_before_an_interrupt_is_taken(void)
{
    params_error_t why;
    app->staged.speed_kp = 0.7f;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    app->staged.speed_kp = 0.6f;
    app->staged.start_speed = 9.0f;
    TEST_ASSERT_TRUE(app_apply(&why));
    app->staged.speed_kp = -1.0f;
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_FALSE(interrupts_wrong);
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(0.6f, app->drive.manoeuvres.run.speed.pi.tuning.kp);
    TEST_ASSERT_EQUAL_FLOAT(4.0f * 9.0f, app->drive.manoeuvres.catching.tuning.speed_min);
}

/* Likewise when the last was refused at the last moment: the one before it had not been taken yet. */
static void test_a_set_offered_before_survives_one_that_came_too_late(void)
{
    params_error_t why;
    app->staged.speed_kp = 0.7f;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    app->staged.encoder_lines = 1024;
    bridge_comes = true;
    TEST_ASSERT_FALSE(app_apply(&why));
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->drive.manoeuvres.run.speed.pi.tuning.kp);
    TEST_ASSERT_EQUAL_UINT32(9999u, app->drive.encoder.tuning.last_count);
}

/* ---- what is learnt ---- */

static void learnt(float share)
{
    learnt_value_t *inductance = &app->drive.inductance.learnt;
    inductance->value = share * inductance->from;
    from_here();
}

static void periods(uint32_t count)
{
    app->drive.period += count;
    from_here();
}

static float believed_l(void)
{
    return app->drive.offer.current_control.inductance_q / app->active.motor_inductance_q;
}

/* More than a thousandth, and 10 ms since the last tuning. */
static void test_what_is_learnt_is_offered_where_it_has_moved(void)
{
    background();
    periods(1000u);
    background();
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.offered);
    learnt(1.0009f);
    background();
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.offered);
    learnt(1.1f);
    background();
    TEST_ASSERT_EQUAL_UINT32(1u, app->drive.offered);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.1f, believed_l());
    TEST_ASSERT_FALSE(interrupts_wrong);
    interrupt();
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.1f,
                             app->drive.current_control.inductance_q / app->active.motor_inductance_q);
    learnt(1.2f);
    background();
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.offered);
    periods((uint32_t)(0.01 / (double)DRIVE_PERIOD + 0.5));
    background();
    TEST_ASSERT_EQUAL_UINT32(1u, app->drive.offered);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.2f, believed_l());
    TEST_ASSERT_FALSE(interrupts_wrong);
}

/* The observer would ring: its slope goes with L, but not its resistance. */
static void test_what_the_drive_cannot_run_on_is_not_believed(void)
{
    params_error_t why;
    app->staged.motor_resistance = 40.0f;
    TEST_ASSERT_TRUE(app_apply(&why));
    interrupt();
    periods(1000u);
    learnt(0.5f);
    background();
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.offered);
    app->staged.speed_kp = 0.7f;
    TEST_ASSERT_TRUE(app_apply(&why));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f, believed_l());
    TEST_ASSERT_FALSE(interrupts_wrong);
}

/* A set that leaves L alone keeps what was learnt of it; one with another L begins with that, also while the
 * background still remembers what was learnt of the old one. */
static void test_a_new_set_keeps_what_was_learnt_of_the_rows_that_it_leaves(void)
{
    params_error_t why;
    app->staged.inductance_adaptation = 2.0f;
    TEST_ASSERT_TRUE(app_apply(&why));
    interrupt();
    learnt(1.1f);
    background();
    app->staged.speed_kp = 0.7f;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.1f, believed_l());
    interrupt();
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.1f,
                             app->drive.inductance.learnt.value / app->active.motor_inductance_q);

    app->staged.motor_inductance_q = 15e-3f;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f, believed_l());
    periods(1000u);
    background();
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.0f, believed_l());
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(15e-3f, app->drive.inductance.learnt.value);
    background();
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.offered);
}

/* The speed control's gains go with J at once; the tracking loop is told of the torque when J is known. */
static void test_learnt_inertia_goes_into_gains_and_torque(void)
{
    params_error_t why;
    app->staged.inertia_adaptation = INERTIA_ON;
    app->staged.torque_feedforward = 1.0f;
    TEST_ASSERT_TRUE(app_apply(&why));
    interrupt();
    const float kp = app->drive.manoeuvres.run.speed.pi.tuning.kp;
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.doubt.tuning.acceleration_known);
    inertia_t *inertia = &app->drive.inertia;
    inertia->learnt.value = 1.5f * inertia->learnt.from;
    inertia->ways = INERTIA_KNOWN - 1u;
    from_here();
    periods(1000u);
    background();
    interrupt();
    TEST_ASSERT_FLOAT_WITHIN(1e-5f * kp, 1.5f * kp, app->drive.manoeuvres.run.speed.pi.tuning.kp);
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.doubt.tuning.acceleration_known);
    inertia->ways = INERTIA_KNOWN;
    from_here();
    periods(1000u);
    background();
    interrupt();
    TEST_ASSERT_EQUAL_UINT32(1u, app->drive.doubt.tuning.acceleration_known);
    TEST_ASSERT_EQUAL_FLOAT(1.5f * inertia->learnt.from, inertia->learnt.value);
    TEST_ASSERT_FALSE(interrupts_wrong);
}

/* A set that waits to be taken is not lost to what is learnt meanwhile. */
static void test_what_is_learnt_goes_with_a_set_that_still_waits(void)
{
    params_error_t why;
    app->staged.speed_kp = 0.7f;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    periods(1000u);
    learnt(1.1f);
    background();
    interrupt();
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.1f,
                             app->drive.current_control.inductance_q / app->active.motor_inductance_q);
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->drive.manoeuvres.run.speed.pi.tuning.kp);
}

static void test_requests_are_taken_with_interrupts_off(void)
{
    params_error_t why;
    requests_t requests;
    requests_defaults(&requests);
    requests.speed_request = 50.0f;
    from_here();
    TEST_ASSERT_TRUE(app_request(&requests, &why));
    expect_asked_in_good_order("off on ");
    TEST_ASSERT_EQUAL_FLOAT(50.0f, app->drive.requests.speed_request);

    requests.speed_request = 1e9f;
    from_here();
    const drive_t before = app->drive;
    TEST_ASSERT_FALSE(app_request(&requests, &why));
    TEST_ASSERT_EQUAL_MEMORY(&before, &app->drive, sizeof before);
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_TRUE(interrupts_on);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_start_brings_the_board_up_with_the_defaults_and_then_the_watchdog);
    RUN_TEST(test_a_start_that_fails_is_a_fault_and_starts_no_watchdog);
    RUN_TEST(test_the_watchdog_is_fed_once_for_every_time_that_the_interrupt_was_alive);
    RUN_TEST(test_the_watchdog_is_fed_when_the_list_has_come_round);
    RUN_TEST(test_the_background_sees_the_drive_between_two_interrupts_and_shows_it);
    RUN_TEST(test_the_interrupt_reads_first_and_acknowledges_last);
    RUN_TEST(test_each_flag_of_the_board_is_the_drive_s);
    RUN_TEST(test_a_set_is_offered_with_interrupts_off_and_the_registers_follow);
    RUN_TEST(test_while_the_bridge_is_on_the_registers_stay);
    RUN_TEST(test_a_bad_set_is_refused_and_changes_nothing);
    RUN_TEST(test_a_set_that_the_present_request_would_violate_is_refused);
    RUN_TEST(test_what_changes_only_with_the_bridge_off_is_refused_while_it_is_on);
    RUN_TEST(test_a_bridge_that_comes_on_meanwhile_keeps_the_old_set);
    RUN_TEST(test_the_last_good_set_before_an_interrupt_is_taken);
    RUN_TEST(test_a_set_offered_before_survives_one_that_came_too_late);
    RUN_TEST(test_what_is_learnt_is_offered_where_it_has_moved);
    RUN_TEST(test_what_the_drive_cannot_run_on_is_not_believed);
    RUN_TEST(test_a_new_set_keeps_what_was_learnt_of_the_rows_that_it_leaves);
    RUN_TEST(test_learnt_inertia_goes_into_gains_and_torque);
    RUN_TEST(test_what_is_learnt_goes_with_a_set_that_still_waits);
    RUN_TEST(test_requests_are_taken_with_interrupts_off);
    return UNITY_END();
}
