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
static drive_t seen;             /* the drive as an interrupt would find it */
static void (*before_off)(void); /* what an interrupt does that comes just before they are off; NULL: none */

static void ask(const char *what)
{
    strncat(asked, what, sizeof asked - strlen(asked) - 1u);
}

/* What only the background writes: an offer that stands is whole, and none is touched that the interrupt may
 * take. */
static bool same_but_for_the_offer(void)
{
    static drive_t now, then;
    now = app->drive;
    then = seen;
    const bool offer_changed = memcmp(&now.offer, &then.offer, sizeof now.offer) != 0;
    const bool changed_in_force = offer_changed && now.offered != 0u;
    memset(&now.offer, 0, sizeof now.offer);
    memset(&then.offer, 0, sizeof then.offer);
    now.offered = 0u;
    then.offered = 0u;
    return memcmp(&now, &then, sizeof now) == 0 && !changed_in_force;
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

void hal_interrupts_off(void)
{
    ask("off ");
    interrupts_wrong |= !interrupts_on;
    interrupts_on = false;
    interrupts_wrong |= !same_but_for_the_offer();
    if (before_off != NULL) {
        before_off();
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
    before_off = NULL;
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

static void expect_asked_in_good_order(const char *what)
{
    TEST_ASSERT_EQUAL_STRING(what, asked);
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_TRUE(interrupts_on);
    seen.offer = app->drive.offer; /* offered whole, after they were on again */
    TEST_ASSERT_TRUE(same_but_for_the_offer());
}

/* Every task of the background's list. */
static void background(void)
{
    do {
        app_background();
    } while (app->task != 0u);
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
        app_interrupt();
        background();
        background();
        TEST_ASSERT_EQUAL_UINT32(n, fed);
    }
    TEST_ASSERT_FALSE(led_run);
    TEST_ASSERT_FALSE(led_fault);
    app->drive.sequence.state = DRIVE_OPERATION_ENABLED;
    background();
    TEST_ASSERT_TRUE(led_run);
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

static void test_a_set_is_taken_with_interrupts_off_and_the_registers_follow(void)
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
}

static void test_while_the_bridge_is_on_the_registers_stay(void)
{
    params_error_t why;
    app->drive.sequence.state = DRIVE_OPERATION_ENABLED;
    app->staged.speed_kp = 0.7f;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    expect_asked_in_good_order("off on ");
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->active.speed_kp);
}

static void test_a_set_that_is_refused_changes_nothing_and_interrupts_are_on_again(void)
{
    params_error_t why;
    app->staged.speed_kp = -1.0f;
    app->staged.encoder_lines = 1024;
    from_here();
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_TRUE(same_but_for_the_offer());
    TEST_ASSERT_NULL(strstr(asked, "encoder"));
    TEST_ASSERT_NULL(strstr(asked, "dead-band"));
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_TRUE(interrupts_on);
}

static void come_on(void)
{
    app->drive.sequence.state = DRIVE_OPERATION_ENABLED;
}

/* The bridge was off when the set was judged and is on when it is offered. */
static void test_a_bridge_that_comes_on_meanwhile_keeps_the_board_s_parameters(void)
{
    params_error_t why;
    app->staged.encoder_lines = 1024;
    app->staged.speed_kp = 0.7f;
    from_here();
    before_off = come_on;
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_EQUAL_STRING("off on ", asked);
    TEST_ASSERT_EQUAL_INT32(2500, app->active.encoder_lines);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, app->active.speed_kp);
    TEST_ASSERT_TRUE(interrupts_on);
}

/* Two sets before the interrupt has taken the first: that one is not touched while it could be. */
static void test_a_second_set_takes_the_place_of_one_that_still_waits(void)
{
    params_error_t why;
    app->staged.speed_kp = 0.7f;
    TEST_ASSERT_TRUE(app_apply(&why));
    TEST_ASSERT_EQUAL_UINT32(1u, app->drive.offered);
    app->staged.speed_kp = 0.9f;
    from_here();
    const drive_tuning_t first = app->drive.offer;
    TEST_ASSERT_TRUE(app_apply(&why));
    expect_asked_in_good_order("off dead-band encoder on ");
    TEST_ASSERT_TRUE(memcmp(&first, &app->drive.offer, sizeof first) != 0);
    TEST_ASSERT_EQUAL_UINT32(1u, app->drive.offered);
    app_interrupt();
    TEST_ASSERT_EQUAL_UINT32(0u, app->drive.offered);
}

static void test_a_set_that_waits_is_not_lost_by_one_that_comes_too_late(void)
{
    params_error_t why;
    app->staged.speed_kp = 0.7f;
    TEST_ASSERT_TRUE(app_apply(&why));
    const drive_tuning_t first = app->drive.offer;
    app->staged.speed_kp = 0.9f;
    app->staged.encoder_lines = 1024;
    from_here();
    before_off = come_on;
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_EQUAL_UINT32(1u, app->drive.offered);
    TEST_ASSERT_EQUAL_MEMORY(&first, &app->drive.offer, sizeof first);
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->active.speed_kp);
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
    TEST_ASSERT_FALSE(app_request(&requests, &why));
    TEST_ASSERT_TRUE(same_but_for_the_offer());
    TEST_ASSERT_FALSE(interrupts_wrong);
    TEST_ASSERT_TRUE(interrupts_on);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_start_brings_the_board_up_with_the_defaults_and_then_the_watchdog);
    RUN_TEST(test_a_start_that_fails_is_a_fault_and_starts_no_watchdog);
    RUN_TEST(test_the_watchdog_is_fed_once_for_every_time_that_the_interrupt_was_alive);
    RUN_TEST(test_the_interrupt_reads_first_and_acknowledges_last);
    RUN_TEST(test_each_flag_of_the_board_is_the_drive_s);
    RUN_TEST(test_a_set_is_taken_with_interrupts_off_and_the_registers_follow);
    RUN_TEST(test_while_the_bridge_is_on_the_registers_stay);
    RUN_TEST(test_a_set_that_is_refused_changes_nothing_and_interrupts_are_on_again);
    RUN_TEST(test_a_bridge_that_comes_on_meanwhile_keeps_the_board_s_parameters);
    RUN_TEST(test_a_second_set_takes_the_place_of_one_that_still_waits);
    RUN_TEST(test_a_set_that_waits_is_not_lost_by_one_that_comes_too_late);
    RUN_TEST(test_requests_are_taken_with_interrupts_off);
    return UNITY_END();
}
