/* The application above a board that records its calls. The tests check the start, a start that fails, and
 * the registers that change with the parameters. They also check that the interrupt never uses an
 * incomplete change. */
#include "app/app.h"
#include "settings/reasons.h"
#include "tests/unit/compare.h"

/* ---- the board ---- */

static char asked[512];
static hal_config_t config;
static hal_status_t status;      /* the result of hal_init */
static hal_samples_t conversion; /* the samples that hal_read returns */
static bool interrupts_on;
static bool interrupts_wrong; /* interrupts were disabled twice or enabled twice */
static uint32_t dead_band, encoder_max;
static uint32_t fed;
static bool output_chopper, output_brake;
static bool led_run, led_fault;
static bool output_chopper, output_brake;
static bool medium_requested;
static uint32_t cycles;          /* free-running timer */
static uint32_t cycles_per_call; /* [cycles] that pass with each reading of the timer and of the sample */

static app_t the_app;
static params_error_t why;
static drive_t seen;      /* copy of the drive as an interrupt would read it */
static bool bridge_comes; /* the bridge turns on in the interrupt just before interrupts are disabled again */

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

uint32_t hal_time(void)
{
    cycles += cycles_per_call;
    return cycles;
}

void hal_read(hal_samples_t *samples)
{
    ask("read ");
    cycles += cycles_per_call;
    *samples = conversion;
}

void hal_write_compare(uint16_t a, uint16_t b, uint16_t c)
{
    (void)a;
    (void)b;
    (void)c;
    ask("compare ");
}

/* Functions whose calls are only recorded. */
#define NOTED(function, what)                                                                                \
    void function(void)                                                                                      \
    {                                                                                                        \
        ask(what " ");                                                                                       \
    }
NOTED(hal_gates_off, "gates-off")
NOTED(hal_end_of_sample, "end-of-sample")
NOTED(hal_end_of_trip, "end-of-trip")
NOTED(hal_end_of_serial, "end-of-serial")
NOTED(hal_serial_drop, "drop")
NOTED(hal_begin_medium, "begin-medium")
NOTED(hal_end_medium, "end-medium")
NOTED(hal_watchdog_start, "watchdog")
NOTED(hal_restart, "restart")

bool hal_gates_on(void)
{
    ask("gates-on ");
    return true;
}

void hal_request_medium(void)
{
    ask("request-medium ");
    medium_requested = true;
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

void hal_watchdog_feed(void)
{
    fed++;
}

static uint16_t memories[HAL_REGIONS][100];
static uint32_t memory_words = 100u;

hal_memory_t hal_memory(hal_region_t region)
{
    return (hal_memory_t){memories[region], memory_words};
}

void hal_outputs(bool chopper, bool brake)
{
    output_chopper = chopper;
    output_brake = brake;
}

void hal_leds(bool run, bool fault)
{
    led_run = run;
    led_fault = fault;
}

/* No client is connected to the line. */
uint32_t hal_serial_read(uint16_t *octets, uint32_t room)
{
    (void)octets;
    (void)room;
    return 0u;
}

uint32_t hal_serial_write(const uint16_t *octets, uint32_t count)
{
    (void)octets;
    (void)count;
    return 0u;
}

uint32_t hal_serial_errors(void)
{
    return 0u;
}

bool hal_serial_sends(void)
{
    return false;
}

void hal_serial_baud(uint32_t baud)
{
    (void)baud;
}

/* ---- the store ---- */

static uint16_t stored[HAL_STORE_PAGES][HAL_STORE_WORDS];
static bool store_refuses;
static bool stored_with_bridge_on;

uint16_t hal_store_word(uint32_t page, uint32_t at)
{
    return stored[page][at];
}

bool hal_store_erase(uint32_t page)
{
    stored_with_bridge_on |= drive_bridge_on(&app->drive);
    memset(stored[page], 0xFF, sizeof stored[page]);
    return !store_refuses;
}

bool hal_store_program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count)
{
    stored_with_bridge_on |= drive_bridge_on(&app->drive);
    for (uint32_t n = 0; n < count && !store_refuses; n++) {
        stored[page][at + n] &= words[n];
    }
    return !store_refuses;
}

/* Returns true if a value has changed that an interrupt would have read. An interrupt reads the new tuning
 * only after the background has set the flag `offered`. */
static bool changed(void)
{
    static drive_t now;
    now = app->drive;
    if (now.offered == 0u) {
        now.offered = seen.offered;
        *drive_idle_tuning(&now) = *drive_idle_tuning(&seen);
    }
    return memcmp(&seen, &now, sizeof seen) != 0;
}

void hal_interrupts_off(void)
{
    ask("off ");
    interrupts_wrong |= !interrupts_on || changed();
    interrupts_on = false;
    if (bridge_comes) {
        app->drive.state = DRIVE_SWITCHED_ON;
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

/* From now on no request is active, and an interrupt may occur at any time. */
static void from_here(void)
{
    memset(asked, 0, sizeof asked);
    seen = app->drive;
}

static void given_bridge_on(void)
{
    app->drive.state = DRIVE_OPERATION_ENABLED;
    from_here();
}

/* One sample interrupt, followed by the medium task if it is due. */
static void sample(void)
{
    medium_requested = false;
    app_interrupt();
    if (medium_requested) {
        app_medium();
    }
    seen = app->drive;
}

/* Runs the interrupts to the end of a window. */
static void interrupt(void)
{
    do {
        sample();
    } while (!medium_requested);
}

static void apply(void)
{
    TEST_ASSERT_TRUE(app_apply(&why));
}

/* Runs the background through its list more than once. */
static void background(void)
{
    for (int n = 0; n < 12; n++) {
        app_background();
    }
}

static void expect_asked_in_good_order(const char *what)
{
    TEST_ASSERT_EQUAL_STRING(what, asked);
    TEST_ASSERT_EQUAL_MEMORY(&seen, &app->drive, sizeof seen);
}

void setUp(void)
{
    memset(stored, 0xFF, sizeof stored);
    store_refuses = false;
    stored_with_bridge_on = false;
    start(HAL_OK);
}

/* After every action on a board that has started: no interrupt has seen an incomplete change, and
 * interrupts are enabled. */
void tearDown(void)
{
    TEST_ASSERT_FALSE(status == HAL_OK && (interrupts_wrong || !interrupts_on));
}

static void test_a_start_brings_the_board_up_with_the_defaults_and_then_the_watchdog(void)
{
    const params_t *params = &app->active;
    TEST_ASSERT_EQUAL_STRING("init watchdog ", asked);
    TEST_ASSERT_EQUAL_INT32(HAL_OK, app->board_status);
    TEST_ASSERT_EQUAL_INT32(DRIVE_NOT_READY, app->drive.state);
    TEST_ASSERT_EQUAL_UINT32(4u * 2500u - 1u, config.encoder_count_max);
    TEST_ASSERT_TRUE((double)config.dead_band_count >= (double)params->dead_time * HAL_CLOCK_HZ - 1e-3);
    TEST_ASSERT_TRUE((double)config.dead_band_count < (double)params->dead_time * HAL_CLOCK_HZ + 1.0);
    TEST_ASSERT_TRUE(config.on_sample == app_interrupt);
    TEST_ASSERT_TRUE(config.on_trip == app_trip);
    TEST_ASSERT_TRUE(config.on_serial == app_serial);
}

/* The drive is in fault and reports the reason. The watchdog is not started: no interrupt occurs that it
 * could watch, and after a reset the start would fail again. */
static void test_a_start_that_fails_is_a_fault_and_starts_no_watchdog(void)
{
    static const hal_status_t failures[] = {HAL_CLOCK_MISSING, HAL_PLL_UNLOCKED, HAL_BAD_CONFIG,
                                            HAL_TRIP_FAILED};
    for (size_t n = 0; n < sizeof failures / sizeof failures[0]; n++) {
        start(failures[n]);
        TEST_ASSERT_EQUAL_STRING("init ", asked);
        TEST_ASSERT_EQUAL_INT32(failures[n], app->board_status);
        TEST_ASSERT_EQUAL_INT32(DRIVE_FAULT, app->drive.state);
        TEST_ASSERT_EQUAL_INT32(REASON_BOARD_FAILED, app->drive.fault_reason);
        background();
        TEST_ASSERT_EQUAL_UINT32(0u, fed);
        TEST_ASSERT_TRUE(led_fault);
        TEST_ASSERT_FALSE(led_run);
    }
}

static void test_the_background_sees_the_drive_between_two_interrupts_and_shows_it(void)
{
    interrupt();
    background();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_WINDOW, app->seen.period);
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

/* The duration is measured from the entry, so that the reading is included; also across the end of the
 * timer's range. The longest duration is kept. */
static void test_each_task_notes_its_last_and_its_longest_duration(void)
{
    static const uint32_t steps[] = {40u, 700u, 5u};
    cycles = UINT32_MAX - 50u;
    for (size_t n = 0; n < sizeof steps / sizeof steps[0]; n++) {
        cycles_per_call = steps[n];
        interrupt();
        TEST_ASSERT_EQUAL_UINT32(2u * steps[n], app->drive.fast_took.last);
        TEST_ASSERT_EQUAL_UINT32(steps[n], app->drive.medium_took.last);
        TEST_ASSERT_EQUAL_UINT32(2u * (n > 0u ? 700u : 40u), app->drive.fast_took.longest);
        TEST_ASSERT_EQUAL_UINT32(n > 0u ? 700u : 40u, app->drive.medium_took.longest);
    }
    cycles_per_call = 0u;
}

static void test_each_flag_of_the_board_is_the_drive_s(void)
{
    static const struct {
        uint16_t of_board;
        uint32_t of_drive;
    } flags[] = {{HAL_FLAG_TRIPPED, DRIVE_SAMPLE_TRIPPED},
                 {HAL_FLAG_FAULT_PIN, DRIVE_SAMPLE_FAULT_LINE},
                 {HAL_FLAG_ENCODER, DRIVE_SAMPLE_ENCODER},
                 {HAL_FLAG_LATE, DRIVE_SAMPLE_LATE},
                 {HAL_FLAG_NOT_ENABLED, DRIVE_SAMPLE_NOT_ENABLED}};
    for (size_t n = 0; n < sizeof flags / sizeof flags[0]; n++) {
        drive_samples_t samples;
        conversion.flags = flags[n].of_board;
        app_read(&samples);
        TEST_ASSERT_EQUAL_HEX32(flags[n].of_drive, samples.flags);
    }
}

/* ---- parameters and requests ---- */

static void test_while_the_bridge_is_on_the_registers_stay(void)
{
    app->staged.speed_kp = 0.7f;
    given_bridge_on();
    apply();
    expect_asked_in_good_order("off on ");
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->active.speed_kp);
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->drive.medium.manoeuvres.run.speed.pi.tuning.kp);
}

/* The set is refused because of this parameter: the drive, its registers and the active set are unchanged. */
static void expect_refused(const char *field, int32_t reason)
{
    static drive_t before;
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
}

/* The refused sets have a value outside its range, violate the present request, or change a parameter that
 * may change only while the bridge is off. */
static void test_a_bad_set_is_refused_and_changes_nothing(void)
{
    app->staged.encoder_lines = 1024;
    app->staged.speed_kp = -1.0f;
    expect_refused("speed_kp", REASON_OUT_OF_RANGE);
    setUp();
    app->drive.requests.speed_request = 200.0f;
    app->staged.overspeed_trip = 150.0f;
    expect_refused("speed_request", REASON_CROSS_RULE);
    setUp();
    given_bridge_on();
    app->staged.encoder_lines = 1024;
    expect_refused("encoder_lines", REASON_BRIDGE_ON);
}

static void test_a_bridge_that_comes_on_during_this_time_keeps_the_old_set(void)
{
    app->staged.encoder_lines = 1024;
    from_here();
    bridge_comes = true;
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_EQUAL_INT32(REASON_BRIDGE_ON, why.reason);
    TEST_ASSERT_EQUAL_STRING("off on ", asked);
    TEST_ASSERT_EQUAL_INT32(2500, app->active.encoder_lines);
    interrupt();
    TEST_ASSERT_EQUAL_UINT32(9999u, app->drive.tunings[app->drive.in_force].fast.encoder.last_count);
}

static void test_the_last_good_set_before_an_interrupt_is_taken(void)
{
    app->staged.speed_kp = 0.7f;
    from_here();
    apply();
    app->staged.speed_kp = 0.6f;
    app->staged.start_speed = 9.0f;
    apply();
    app->staged.speed_kp = -1.0f;
    TEST_ASSERT_FALSE(app_apply(&why));
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(0.6f, app->drive.medium.manoeuvres.run.speed.pi.tuning.kp);
    TEST_ASSERT_EQUAL_FLOAT(4.0f * 9.0f,
                            app->drive.tunings[app->drive.in_force].fast.reference.catching.speed_min);
}

static void test_a_set_offered_before_survives_one_that_came_too_late(void)
{
    app->staged.speed_kp = 0.7f;
    from_here();
    apply();
    app->staged.encoder_lines = 1024;
    bridge_comes = true;
    TEST_ASSERT_FALSE(app_apply(&why));
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->drive.medium.manoeuvres.run.speed.pi.tuning.kp);
    TEST_ASSERT_EQUAL_UINT32(9999u, app->drive.tunings[app->drive.in_force].fast.encoder.last_count);
}

/* ---- what is learnt ---- */

/* L is learnt, with confidence. */
static void learnt(float share)
{
    learnt_value_t *inductance = &app->drive.medium.inductance.learnt;
    inductance->value = share * inductance->from;
    app->drive.medium.inductance.look.kept = inductance->value;
    from_here();
}

static void periods(uint32_t count)
{
    app->drive.fast.period += count;
    from_here();
}

static void expect_share(float expected, float inductance)
{
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, expected, inductance / app->active.motor_inductance_q);
}

static void expect_offered(float share)
{
    expect_share(share, DRIVE_PERIOD * drive_idle_tuning(&app->drive)->fast.current_control.reactance.q);
}

static void background_offers(bool offers)
{
    background();
    TEST_ASSERT_EQUAL_UINT32(offers ? 1u : 0u, app->drive.offered);
}

/* A learnt value is offered if it differs by more than a thousandth and 10 ms have passed since the last
 * tuning. */
static void test_what_is_learnt_is_offered_where_it_has_moved(void)
{
    background();
    periods(1000u);
    background_offers(false);
    learnt(1.0009f);
    background_offers(false);
    learnt(1.1f);
    background_offers(true);
    expect_offered(1.1f);
    interrupt();
    interrupt(); /* both tasks have it at the end of the next window */
    expect_share(1.1f, DRIVE_PERIOD * app->drive.fast.current_control.reactance.q);
    learnt(1.2f);
    background_offers(false);
    periods((uint32_t)(0.01 / (double)DRIVE_PERIOD + 0.5));
    background_offers(true);
    expect_offered(1.2f);
}

/* With this L the observer would oscillate: its slope changes with L, but its resistance does not. */
static void test_what_the_drive_cannot_run_on_is_not_assumed(void)
{
    app->staged.motor_resistance = 40.0f;
    apply();
    interrupt();
    periods(1000u);
    learnt(0.5f);
    background_offers(false);
    app->staged.speed_kp = 0.7f;
    apply();
    expect_offered(1.0f);
}

/* A set with the same L keeps the learnt value; a set with another L begins with that L, even while the
 * background still has the value that was learnt before. */
static void test_a_new_set_keeps_what_was_learnt_of_the_rows_that_it_leaves(void)
{
    app->staged.inductance_adaptation = 2.0f;
    apply();
    interrupt();
    learnt(1.1f);
    background();
    app->staged.speed_kp = 0.7f;
    from_here();
    apply();
    expect_offered(1.1f);
    interrupt();
    expect_share(1.1f, app->drive.medium.inductance.learnt.value);

    app->staged.motor_inductance_q = 15e-3f;
    from_here();
    apply();
    expect_offered(1.0f);
    periods(1000u);
    background();
    expect_offered(1.0f);
    interrupt();
    TEST_ASSERT_EQUAL_FLOAT(15e-3f, app->drive.medium.inductance.learnt.value);
    background_offers(false);
}

/* The gains of the speed control change with J at once, and so does the torque feed-forward of the
 * tracking loop. */
static void test_learnt_inertia_goes_into_gains_and_torque(void)
{
    app->staged.inertia_adaptation = INERTIA_ON;
    app->staged.torque_feedforward = 1.0f;
    apply();
    interrupt();
    interrupt();
    const float kp = app->drive.medium.manoeuvres.run.speed.pi.tuning.kp;
#ifndef LAGLESS_ESTIMATOR_FIXED
    const float told = app->drive.fast.estimator.tracker.torque_feedforward;
    TEST_ASSERT_TRUE(told > 0.0f);
#endif
    inertia_t *inertia = &app->drive.medium.inertia;
    inertia->learnt.value = 1.5f * inertia->learnt.from;
    from_here();
    periods(1000u);
    background();
    interrupt();
    interrupt(); /* both tasks have it at the end of the next window */
    TEST_ASSERT_FLOAT_WITHIN(1e-5f * kp, 1.5f * kp, app->drive.medium.manoeuvres.run.speed.pi.tuning.kp);
#ifndef LAGLESS_ESTIMATOR_FIXED
    TEST_ASSERT_FLOAT_WITHIN(1e-5f * told, told / 1.5f, app->drive.fast.estimator.tracker.torque_feedforward);
#endif
    TEST_ASSERT_EQUAL_FLOAT(1.5f * inertia->learnt.from, inertia->learnt.value);
}

static void test_what_is_learnt_goes_with_a_set_that_still_waits(void)
{
    app->staged.speed_kp = 0.7f;
    from_here();
    apply();
    periods(1000u);
    learnt(1.1f);
    background();
    interrupt();
    interrupt(); /* both tasks have it at the end of the next window */
    expect_share(1.1f, DRIVE_PERIOD * app->drive.fast.current_control.reactance.q);
    TEST_ASSERT_EQUAL_FLOAT(0.7f, app->drive.medium.manoeuvres.run.speed.pi.tuning.kp);
}

/* ---- stored parameters ---- */

static void expect_order(order_t order, int32_t refusal, uint32_t row)
{
    const bool obeyed = services_write(SERVICE_ORDER, (uint32_t)order, &why);
    TEST_ASSERT_EQUAL_INT32(refusal, app->services.order_refusal);
    TEST_ASSERT_EQUAL_UINT32(row, app->services.order_row);
    TEST_ASSERT_EQUAL(refusal == REASON_NONE, obeyed);
}

/* A motor that differs from the default one is applied and saved. */
static params_t given_saved(void)
{
    app->staged.motor_resistance = 0.5f;
    app->staged.motor_pole_pairs = 3;
    app->staged.observer_gain = 300.0f;
    apply();
    /* This value is only staged and was never checked, so that it must not be saved. */
    app->staged.motor_resistance = 0.25f;
    expect_order(ORDER_SAVE, REASON_NONE, 0u);
    return app->active;
}

static void expect_store(parameters_state_t state, uint32_t unknown, uint32_t defaulted)
{
    TEST_ASSERT_EQUAL_INT32(state, app->services.store_state);
    TEST_ASSERT_EQUAL_UINT32(unknown, app->services.store_unknown);
    TEST_ASSERT_EQUAL_UINT32(defaulted, app->services.store_defaulted);
}

static void expect_defaults_and_fault(void)
{
    params_t usual;
    expect_store(PARAMETERS_CORRUPT, 0u, params_table.count);
    params_defaults(&usual);
    TEST_ASSERT_EQUAL_MEMORY(&usual, &app->active, sizeof usual);
    TEST_ASSERT_EQUAL_INT32(DRIVE_FAULT, app->drive.state);
    TEST_ASSERT_EQUAL_INT32(REASON_STORE_CORRUPT, app->drive.fault_reason);
    TEST_ASSERT_EQUAL_INT32(HAL_OK, app->board_status);
}

static void test_a_saved_set_runs_after_the_next_start(void)
{
    expect_store(PARAMETERS_EMPTY, 0u, 0u);
    const params_t saved = given_saved();
    expect_store(PARAMETERS_SAVED, 0u, 0u);
    TEST_ASSERT_EQUAL_UINT32(1u, app->services.store_saves);
    start(HAL_OK);
    expect_store(PARAMETERS_LOADED, 0u, 0u);
    TEST_ASSERT_EQUAL_MEMORY(&saved, &app->active, sizeof saved);
    TEST_ASSERT_EQUAL_MEMORY(&saved, &app->staged, sizeof saved);
    TEST_ASSERT_EQUAL_INT32(DRIVE_NOT_READY, app->drive.state);
    TEST_ASSERT_EQUAL_FLOAT(0.5f + saved.device_resistance, app->assumed.resistance);
}

static void test_loading_stages_what_was_saved_and_defaults_what_the_program_has(void)
{
    const params_t saved = given_saved();
    params_t usual;
    params_defaults(&usual);
    expect_order(ORDER_DEFAULTS, REASON_NONE, 0u);
    TEST_ASSERT_EQUAL_MEMORY(&usual, &app->staged, sizeof usual);
    TEST_ASSERT_EQUAL_MEMORY(&saved, &app->active, sizeof saved);
    expect_order(ORDER_LOAD, REASON_NONE, 0u);
    expect_store(PARAMETERS_LOADED, 0u, 0u);
    TEST_ASSERT_EQUAL_MEMORY(&saved, &app->staged, sizeof saved);
}

static void test_saving_is_refused_by_memory_that_takes_nothing_and_while_the_bridge_is_on(void)
{
    store_refuses = true;
    expect_order(ORDER_SAVE, REASON_STORE_FAILED, SERVICE_ORDER);
    given_bridge_on();
    expect_order(ORDER_SAVE, REASON_BRIDGE_ON, SERVICE_ORDER);
    TEST_ASSERT_EQUAL_HEX16(0xFFFF, stored[0][0]);
    TEST_ASSERT_EQUAL_UINT32(0u, app->services.store_saves);
    TEST_ASSERT_FALSE(stored_with_bridge_on);
}

/* A store of another program is no fault: the drive may run with its defaults. Nothing is written over
 * foreign data before they are erased. */
static void test_a_store_of_another_program_runs_the_defaults_until_it_is_erased(void)
{
    params_t usual;
    for (uint32_t at = 0; at < sizeof stored[0] / sizeof stored[0][0]; at++) {
        stored[0][at] = (uint16_t)(at * 40503u);
        stored[1][at] = (uint16_t)(at * 30011u + 7u);
    }
    start(HAL_OK);
    expect_store(PARAMETERS_FOREIGN, 0u, 0u);
    params_defaults(&usual);
    TEST_ASSERT_EQUAL_MEMORY(&usual, &app->active, sizeof usual);
    TEST_ASSERT_EQUAL_INT32(DRIVE_NOT_READY, app->drive.state);
    TEST_ASSERT_EQUAL_INT32(REASON_NONE, app->drive.fault_reason);
    expect_order(ORDER_SAVE, REASON_STORE_FOREIGN, SERVICE_ORDER);
    TEST_ASSERT_EQUAL_HEX16((uint16_t)(5u * 40503u), stored[0][5]);
    given_bridge_on();
    expect_order(ORDER_ERASE, REASON_BRIDGE_ON, SERVICE_ORDER);
    app->drive.state = DRIVE_READY;
    store_refuses = true;
    expect_order(ORDER_ERASE, REASON_STORE_FAILED, SERVICE_ORDER);
    store_refuses = false;
    expect_order(ORDER_ERASE, REASON_NONE, 0u);
    expect_store(PARAMETERS_EMPTY, 0u, 0u);
    const params_t saved = given_saved();
    start(HAL_OK);
    TEST_ASSERT_EQUAL_MEMORY(&saved, &app->active, sizeof saved);
}

static void test_a_corrupt_store_runs_the_defaults_behind_a_latched_fault(void)
{
    (void)given_saved();
    stored[0][20] ^= 0x0040u;
    start(HAL_OK);
    expect_defaults_and_fault();
    app->staged.motor_resistance = 0.25f;
    expect_order(ORDER_LOAD, REASON_STORE_CORRUPT, SERVICE_ORDER);
    TEST_ASSERT_EQUAL_FLOAT(0.25f, app->staged.motor_resistance);
    expect_order(ORDER_SAVE, REASON_NONE, 0u);
    start(HAL_OK);
    expect_store(PARAMETERS_LOADED, 0u, 0u);
    TEST_ASSERT_EQUAL_INT32(DRIVE_NOT_READY, app->drive.state);
}

/* Each value alone is valid, and the record is valid too. This can occur after an update with other rules. */
static void test_a_stored_set_that_breaks_a_rule_runs_the_defaults_behind_a_latched_fault(void)
{
    app->active.current_limit = 10.0f;
    app->active.overcurrent_trip = 5.0f;
    expect_order(ORDER_SAVE, REASON_NONE, 0u);
    start(HAL_OK);
    expect_defaults_and_fault();
}

/* ---- the capture's orders ---- */

static void put(uint32_t id, uint32_t bits)
{
    TEST_ASSERT_TRUE(services_write(id, bits, &why));
}

static void test_the_rows_of_the_capture_are_the_history_of_a_fault_unless_written(void)
{
    const capture_tuning_t usual = app->drive.capture.tuning;
    expect_order(ORDER_CAPTURE_ARM, REASON_NONE, 0u);
    TEST_ASSERT_EQUAL_UINT32(usual.columns, app->drive.capture.tuning.columns);
    TEST_ASSERT_EQUAL_UINT32_ARRAY(usual.id, app->drive.capture.tuning.id, usual.columns);
    TEST_ASSERT_EQUAL_UINT32(CAPTURE_ON_FAULT, app->drive.capture.tuning.on);
    TEST_ASSERT_EQUAL_INT32(CAPTURE_ARMED, app->services.capture_state);
}

/* The ring of the capture begins again with the other content, between two interrupts. */
static void test_another_fault_record_begins_with_the_set_that_selects_it(void)
{
    app->staged.fault_record = (int32_t)FAULT_RECORD_REPLAY;
    from_here();
    TEST_ASSERT_TRUE(app_apply(&why));
    TEST_ASSERT_TRUE(interrupts_on && !interrupts_wrong);
    TEST_ASSERT_EQUAL_UINT32(1u, app->drive.record.on);
}

static void test_a_capture_is_armed_triggered_read_and_released(void)
{
    uint32_t bits = 0u;
    put(1911u, CAPTURE_ON_COMMAND);
    put(1914u, 2u);
    put(1915u, 2u);
    put(1916u, 2000u); /* the row `period` */
    put(1917u, 2001u);
    expect_order(ORDER_CAPTURE_ARM, REASON_NONE, 0u);
    for (int n = 0; n < 10; n++) {
        sample();
    }
    from_here();
    TEST_ASSERT_FALSE(capturing_slot(0u, &bits)); /* the capture is not held */
    expect_order(ORDER_CAPTURE_TRIGGER, REASON_NONE, 0u);
    const uint32_t at = app->drive.fast.period;
    TEST_ASSERT_EQUAL_INT32(CAPTURE_TRIGGERED, app->services.capture_state);
    for (int n = 0; n < 10; n++) {
        sample();
    }
    background();
    TEST_ASSERT_EQUAL_INT32(CAPTURE_HELD, app->services.capture_state);
    TEST_ASSERT_EQUAL_UINT32(12u, app->services.capture_periods);
    TEST_ASSERT_EQUAL_UINT32(at, app->services.capture_at);
    for (uint32_t n = 0; n < 12u; n++) {
        TEST_ASSERT_TRUE(capturing_slot(2u * n, &bits));
        TEST_ASSERT_EQUAL_UINT32(at - 9u + n, bits);
    }
    TEST_ASSERT_FALSE(capturing_slot(24u, &bits));
    expect_order(ORDER_CAPTURE_RELEASE, REASON_NONE, 0u);
    TEST_ASSERT_EQUAL_INT32(CAPTURE_IDLE, app->services.capture_state);
    TEST_ASSERT_EQUAL_UINT32(12u, app->services.capture_signals);
    TEST_ASSERT_EQUAL_UINT32(2001u, app->services.capture_1);
    TEST_ASSERT_EQUAL_UINT32(12u, app->drive.capture.tuning.columns);
}

static void test_a_capture_that_cannot_be_armed_names_the_row(void)
{
    const capture_t before = app->drive.capture;
    put(1920u, 2999u); /* no signal has this id */
    expect_order(ORDER_CAPTURE_ARM, REASON_UNKNOWN_ID, 1920u);
    put(1920u, 2000u);
    put(1914u, 341u); /* with twelve columns 341 periods fit */
    expect_order(ORDER_CAPTURE_ARM, REASON_CROSS_RULE, 1914u);
    put(1914u, 340u);
    put(1911u, CAPTURE_ON_ABOVE);
    put(1912u, 2998u);
    expect_order(ORDER_CAPTURE_ARM, REASON_UNKNOWN_ID, 1912u);
    TEST_ASSERT_EQUAL_MEMORY(&before, &app->drive.capture, sizeof before);
    put(1912u, 2032u);
    expect_order(ORDER_CAPTURE_ARM, REASON_NONE, 0u);
}
