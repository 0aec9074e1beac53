/* The application above the real HAL, on a bus that records each access. The tests check which accesses
 * are made with interrupts off, and which of them feed the watchdog. */
#include <string.h>

#include "app/app.h"
#include "hal/f28335/bus.h"
#include "hal/f28335/pwm.h"
#include "hal/f28335/qep.h"
#include "tests/hal/recording_bus.h"
#include "unity.h"

#define LEGS 3u
/* Register writes in a section with interrupts off: two dead bands per leg, and the writes that restart
 * the encoder. */
#define ENCODER_WRITES 3u

static app_t the_app;
static uint32_t judged;     /* [-] calls of the functions that take a long time */
static uint32_t judged_off; /* [-] calls of them while interrupts were off */

/* ---- replacements of the functions that check and prepare parameters (CMakeLists.txt) ---- */

bool noted_params_check(const params_t *params, params_error_t *why);
bool noted_params_check_live(const params_t *now, const params_t *next, params_error_t *why);
bool noted_requests_check(const requests_t *requests, const params_t *params, params_error_t *why);
void noted_drive_prepare(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed);

static void note_judging(void)
{
    judged++;
    judged_off += !rec.interrupts_on;
}

bool noted_params_check(const params_t *params, params_error_t *why)
{
    note_judging();
    return params_check(params, why);
}

bool noted_params_check_live(const params_t *now, const params_t *next, params_error_t *why)
{
    note_judging();
    return params_check_live(now, next, why);
}

bool noted_requests_check(const requests_t *requests, const params_t *params, params_error_t *why)
{
    note_judging();
    return requests_check(requests, params, why);
}

void noted_drive_prepare(drive_tuning_t *tuning, const params_t *params, const assumed_t *assumed)
{
    note_judging();
    drive_prepare(tuning, params, assumed);
}

/* ---- bench ---- */

void setUp(void)
{
    recording_reset();
    rec.otp[0] = 0x0123u;
    rec.otp[1] = 0x0045u;
    memset(&the_app, 0, sizeof the_app);
    app = &the_app;
    app_start();
    TEST_ASSERT_EQUAL_INT32(HAL_OK, app->board_status);
    TEST_ASSERT_TRUE(rec.interrupts_on);
    recording_clear_log();
    judged = 0;
    judged_off = 0;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0u, rec.overflows, "the log was too short");
    TEST_ASSERT_FALSE_MESSAGE(rec.allowed, "EALLOW is still set");
    TEST_ASSERT_EQUAL_UINT32(0u, rec.nested);
}

/* The index of the only entry of this kind. */
static uint32_t only(did_t did)
{
    uint32_t place = rec.entries;
    for (uint32_t n = 0; n < rec.entries; n++) {
        if (rec.entry[n].did == did) {
            TEST_ASSERT_EQUAL_UINT32(rec.entries, place);
            place = n;
        }
    }
    TEST_ASSERT_TRUE(place < rec.entries);
    return place;
}

/* Checks that the log is one section with interrupts off, without other accesses; returns how many
 * registers the section writes. */
static uint32_t expect_one_section(void)
{
    const uint32_t off = only(DID_INTERRUPTS_OFF);
    const uint32_t on = only(DID_INTERRUPTS_ON);
    TEST_ASSERT_EQUAL_UINT32(0u, off);
    TEST_ASSERT_EQUAL_UINT32(rec.entries - 1u, on);
    for (uint32_t n = 1; n < on; n++) {
        TEST_ASSERT_TRUE(rec.entry[n].did == DID_WRITE16 || rec.entry[n].did == DID_WRITE32);
    }
    TEST_ASSERT_TRUE(rec.interrupts_on);
    return on - off - 1u;
}

static void expect_judged_with_interrupts_on(void)
{
    TEST_ASSERT_TRUE(judged > 0u);
    TEST_ASSERT_EQUAL_UINT32(0u, judged_off);
}

/* ---- parameters and requests ---- */

/* Each set writes both dead-band registers of each leg while the bridge is off, and the registers of the
 * encoder only if its number of lines changes; while the bridge is on it writes nothing. */
static void test_a_set_writes_its_registers_in_one_section(void)
{
    static const struct {
        drive_state_t state;
        float dead_time;
        int32_t lines;
        uint32_t writes;
    } cases[] = {{DRIVE_NOT_READY, 3e-6f, 1024, 2u * LEGS + ENCODER_WRITES},
                 {DRIVE_NOT_READY, 2.5e-6f, 2500, 2u * LEGS},
                 {DRIVE_OPERATION_ENABLED, 2.5e-6f, 2500, 0u}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        params_error_t why;
        setUp();
        app->drive.state = (int32_t)cases[n].state;
        app->drive.fast.period = 1u;
        app->staged.speed_kp = 0.7f;
        app->staged.dead_time = cases[n].dead_time;
        app->staged.encoder_lines = cases[n].lines;
        TEST_ASSERT_TRUE(app_apply(&why));
        TEST_ASSERT_EQUAL_UINT32(cases[n].writes, expect_one_section());
        TEST_ASSERT_EQUAL_UINT32(1u, app->drive.offered);
        TEST_ASSERT_EQUAL_INT32(cases[n].lines, app->active.encoder_lines);
        TEST_ASSERT_EQUAL_UINT32(4u * (uint32_t)cases[n].lines - 1u,
                                 drive_idle_tuning(&app->drive)->fast.encoder.last_count);
        for (uint32_t leg = 0; leg < LEGS && cases[n].writes > 0u; leg++) {
            const uint32_t dead_band = (uint32_t)((double)cases[n].dead_time * HAL_CLOCK_HZ + 0.5);
            TEST_ASSERT_EQUAL_UINT16(dead_band, EPWM(PWM_LEADER + leg)->DBRED);
            TEST_ASSERT_EQUAL_UINT16(dead_band, EPWM(PWM_LEADER + leg)->DBFED);
        }
        TEST_ASSERT_EQUAL_UINT32(4u * (uint32_t)cases[n].lines - 1u, EQEP(QEP_MODULE)->QPOSMAX);
        expect_judged_with_interrupts_on();
    }
}

static void test_a_set_that_is_refused_turns_no_interrupt_off(void)
{
    params_error_t why;
    app->staged.speed_kp = -1.0f;
    TEST_ASSERT_FALSE(app_apply(&why));
    app->staged = app->active;
    app->staged.dead_time = 3e-6f;
    app->drive.state = (int32_t)DRIVE_OPERATION_ENABLED;
    TEST_ASSERT_FALSE(app_apply(&why));
    TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
    TEST_ASSERT_TRUE(judged >= 2u);
}

static void test_a_request_is_judged_before_interrupts_are_off_and_writes_no_register(void)
{
    params_error_t why;
    requests_t requests = app->drive.requests;
    requests.speed_request = 50.0f;
    TEST_ASSERT_TRUE(app_request(&requests, &why));
    TEST_ASSERT_EQUAL_UINT32(0u, expect_one_section());
    TEST_ASSERT_EQUAL_FLOAT(50.0f, app->drive.requests.speed_request);
    expect_judged_with_interrupts_on();
    recording_clear_log();
    requests.speed_request = 1e9f;
    TEST_ASSERT_FALSE(app_request(&requests, &why));
    TEST_ASSERT_EQUAL_UINT32(0u, rec.entries);
}

/* ---- background and watchdog ---- */

/* The number of feedings; a feeding is the write of both keys in their order. */
static uint32_t feedings(void)
{
    const uint32_t keys = recording_count(&rec.regs.sysctrl.WDKEY);
    TEST_ASSERT_EQUAL_UINT32(0u, keys % 2u);
    return keys / 2u;
}

/* The number of tasks in the list, which take turns. */
static uint32_t tasks(void)
{
    const uint32_t first = app->task;
    uint32_t count = 0;
    do {
        app_background();
        count++;
    } while (app->task != first);
    return count;
}

/* One interrupt allows one feeding, whatever task is next when it comes. */
static void test_the_watchdog_is_fed_once_the_list_and_the_interrupt_have_come_round(void)
{
    const uint32_t count = tasks();
    TEST_ASSERT_TRUE(count >= 2u);
    for (uint32_t place = 0; place < count; place++) {
        setUp();
        for (uint32_t n = 0; n < place; n++) {
            app_background();
        }
        app_interrupt();
        recording_clear_log();
        uint32_t fed_at = 0;
        for (uint32_t n = 1; n <= 4u * count; n++) {
            const uint32_t before = feedings();
            app_background();
            if (feedings() != before) {
                TEST_ASSERT_EQUAL_UINT32(0u, fed_at); /* one feeding for one interrupt */
                TEST_ASSERT_EQUAL_UINT32(0u, app->task);
                fed_at = n;
            }
        }
        /* The first task of a round reads that the interrupt has run, and the last task of that round
         * feeds the watchdog. If the interrupt comes at the start of the list, that is in the same round,
         * otherwise in the next one. */
        TEST_ASSERT_EQUAL_UINT32(place == 0u ? count : 2u * count - place, fed_at);
        TEST_ASSERT_EQUAL_UINT32(1u, feedings());
    }
}

static void test_each_call_is_one_task_with_one_short_section_at_most(void)
{
    const uint32_t count = tasks();
    for (uint32_t n = 0; n < 2u * count; n++) {
        const uint32_t task = app->task;
        app_interrupt();
        recording_clear_log();
        app_background();
        TEST_ASSERT_EQUAL_UINT32((task + 1u) % count, app->task);
        uint32_t off = 0;
        for (uint32_t e = 0; e < rec.entries; e++) {
            const bool turns_off = rec.entry[e].did == DID_INTERRUPTS_OFF;
            off += turns_off;
            /* No register is written in between. */
            TEST_ASSERT_TRUE(!turns_off || rec.entry[e + 1u].did == DID_INTERRUPTS_ON);
        }
        TEST_ASSERT_TRUE(off <= 1u);
        TEST_ASSERT_TRUE(rec.interrupts_on);
    }
}
