/* A debugger on the drive: the values that it reads, and the effects of its halts, its real-time mode and
 * its restarts on bridge and motor. It halts between two steps of the simulation; its writes use the bus
 * as those of the software do. */
#include "hal/f28335/bus.h"
#include "hal/f28335/pwm.h"
#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "tests/rig/run.h"

#define ALL_UPPER   0x15u /* bits as in RIG_EDGE_GATES */
#define ALL_LOWER   0x2Au
#define ZERO_VECTOR (BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR ? ALL_UPPER : ALL_LOWER)
#define ALL_TRIPPED 0x7u
#define LATE_LIMIT  3u /* [periods] successive late samples are a fault */
/* [s] time-out by SPRUFB0 with the slowest prescaler. */
#define WATCHDOG (256.0 * 512.0 * 64.0 / BOARD_CRYSTAL_HZ)

static rig_t *rig;

static struct {
    uint64_t tick; /* [ticks] time of the last change of a gate */
    uint32_t gates, tripped;
    uint32_t changes;       /* [-] number of changes of the gates */
    uint32_t on_after_trip; /* [-] changes that turned a gate on after all legs had been tripped */
    uint32_t all_tripped;   /* [-] whether all legs have been tripped since the begin of the recording */
    uint32_t converted;     /* [-] number of conversions begun */
    uint32_t early;         /* [-] interrupts before the first conversion */
    uint32_t entered;       /* [-] number of interrupts */
} seen;

static void see(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    (void)context;
    switch ((rig_edge_t)what) {
    case RIG_EDGE_GATES:
        seen.on_after_trip += seen.all_tripped != 0u && (value & ~seen.gates) != 0u;
        seen.changes += value != seen.gates;
        seen.gates = value;
        seen.tick = tick;
        break;
    case RIG_EDGE_TRIP:
        seen.tripped = value;
        seen.all_tripped |= value == ALL_TRIPPED;
        break;
    case RIG_EDGE_ADC_START:
        seen.converted++;
        break;
    case RIG_EDGE_ISR_ENTER:
        seen.entered++;
        seen.early += seen.converted == 0u;
        break;
    case RIG_EDGE_ISR_EXIT:
        break;
    }
}

static void watch(void)
{
    memset(&seen, 0, sizeof seen);
    rig_watch_edges(rig, see, NULL);
    seen.changes = 0u;
    seen.all_tripped = 0u;
}

static chip_t *chip(void)
{
    return &rig_state(rig)->chip;
}

static plant_t *plant(void)
{
    return &rig_state(rig)->plant;
}

/* Chip and motor run for this number of ticks, in which the background does not complete a pass. */
static void pass_ticks(uint64_t ticks)
{
    rig_bind(rig);
    chip_run(chip_now(chip()) + ticks);
    plant_advance(plant(), chip_now(chip()));
    rig_state(rig)->period =
        (uint32_t)((chip_now(chip()) - rig_state(rig)->start + RIG_PERIOD_TICKS - 1u) / RIG_PERIOD_TICKS);
}

static void pass_periods(uint32_t periods)
{
    for (uint32_t n = 0; n < periods; n++) {
        pass_ticks(RIG_PERIOD_TICKS);
    }
}

static void pass_seconds(double seconds)
{
    pass_periods(rig_periods(seconds));
}

/* Halts at this part of a period. */
static void halt_at(double part)
{
    pass_ticks((uint64_t)(part * (double)RIG_PERIOD_TICKS));
    chip_debug_halt(chip());
}

static uint32_t samples(void)
{
    return chip_interrupt_count(chip(), PIE_SEQ1INT);
}

static double current(void)
{
    return hypot(plant()->i_d, plant()->i_q);
}

static double speed(void)
{
    return plant()->omega_m / RPM;
}

/* Runs at a speed that a dynamometer holds. */
static void run_held_at(double rpm)
{
    run_put(rig, "shaft_locked", 1.0);
    run_put(rig, "shaft_locked_speed", rpm * RPM);
    run_to_ready(rig);
    run_on(rig, rpm);
    run_seconds(rig, 0.1);
    run_expect_no_fault(rig);
}

void setUp(void)
{
    rig = run_rig(41);
    run_paper_drive(rig);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(chip()));
    rig_free(rig);
}

/* ---- A plain halt ---- */

static void test_a_halt_ends_in_one_zero_vector_at_the_next_counter_zero(void)
{
    run_held_at(600.0);
    for (double part = 0.05; part < 1.0; part += 0.13) {
        watch();
        halt_at(part);
        const uint64_t zero = chip_carrier_zero(chip(), 1u);
        TEST_ASSERT_TRUE(chip_now(chip()) < zero);
        pass_ticks(zero - chip_now(chip()));
        pass_periods(20);
        TEST_ASSERT_EQUAL_HEX32(ZERO_VECTOR, seen.gates);
        TEST_ASSERT_TRUE(seen.tick + rig_state(rig)->start <= zero);
        chip_look(chip());
        for (uint16_t n = PWM_LEADER; n < PWM_LEADER + 3u; n++) {
            TEST_ASSERT_EQUAL_UINT16(0u, EPWM(n)->TBCTR);
        }
        const uint32_t before = seen.changes;
        const uint32_t entered = seen.entered;
        pass_periods(20);
        TEST_ASSERT_EQUAL_UINT32(before, seen.changes);
        TEST_ASSERT_EQUAL_UINT32(entered, seen.entered);
        tearDown();
        setUp();
        run_held_at(600.0);
    }
}

/* The speed is so low that the short-circuit current, 4.5 A, causes no other trip. */
static void test_after_a_halt_the_drive_reports_late_and_opens_the_gates(void)
{
    static const double length[] = {3e-3, 0.05, 0.5};
    for (double part = 0.05; part < 1.0; part += 0.13) {
        for (size_t n = 0; n < sizeof length / sizeof length[0]; n++) {
            tearDown();
            setUp();
            run_held_at(60.0);
            halt_at(part);
            pass_seconds(length[n]);
            const uint32_t before = samples();
            watch();
            chip_debug_run(chip());
            pass_periods(LATE_LIMIT + 1u);
            TEST_ASSERT_EQUAL_DOUBLE((double)REASON_LATE, rig_value(rig, "fault_reason"));
            TEST_ASSERT_DOUBLE_WITHIN(0.5, before + LATE_LIMIT, rig_value(rig, "fault_period"));
            TEST_ASSERT_EQUAL_HEX32(ALL_TRIPPED, seen.tripped);
            TEST_ASSERT_EQUAL_HEX32(0u, seen.gates);
            TEST_ASSERT_EQUAL_UINT32(0u, seen.on_after_trip);
            pass_seconds(0.02);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, current());
        }
    }
}

/* The first sample was taken when the halt began. */
static void test_after_a_halt_a_current_over_its_trip_opens_the_gates_with_the_first_new_sample(void)
{
    run_put(rig, "friction_coulomb", 0.0);
    run_put(rig, "params.current_limit", 2.0);
    run_parameter(rig, "overcurrent_trip", 3.0);
    run_held_at(60.0); /* the short-circuit current is 4.5 A */
    halt_at(0.4);
    pass_seconds(0.2);
    const uint32_t before = samples();
    watch();
    chip_debug_run(chip());
    pass_periods(2);
    TEST_ASSERT_EQUAL_DOUBLE((double)REASON_OVERCURRENT, rig_value(rig, "fault_reason"));
    TEST_ASSERT_DOUBLE_WITHIN(0.5, before + 2.0, rig_value(rig, "fault_period"));
    TEST_ASSERT_EQUAL_HEX32(0u, seen.gates);
}

static void test_a_halt_with_gates_off_keeps_them_off(void)
{
    run_to_ready(rig);
    rig_set_motion(rig, 0.0, 300.0 * RPM);
    run_seconds(rig, 0.01);
    watch();
    halt_at(0.4);
    pass_seconds(0.1);
    chip_debug_run(chip());
    pass_seconds(0.01);
    TEST_ASSERT_EQUAL_HEX32(0u, seen.gates);
    TEST_ASSERT_EQUAL_UINT32(0u, seen.changes);
    TEST_ASSERT_EQUAL_HEX32(ALL_TRIPPED, seen.tripped);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, current());
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    run_on(rig, 300.0); /* the halt has no lasting effect */
    run_seconds(rig, 0.3);
    run_expect_no_fault(rig);
}

/* ---- Real-time mode ---- */

/* Makes the writes of an engineer in the register view before the background is halted. */
static void let_the_carrier_run_through_halts(void)
{
    rig_bind(rig);
    for (uint16_t n = PWM_LEADER; n < PWM_LEADER + 3u; n++) {
        bus_write16(&EPWM(n)->TBCTL, (uint16_t)((EPWM(n)->TBCTL & 0x3FFFu) | TBCTL_FREE_SOFT(2u)));
    }
}

static void run_real_time(void)
{
    run_put(rig, "inertia", 0.003);
    run_to_ready(rig);
    run_on(rig, 600.0);
    run_parameter(rig, "background_time_max", 0.0); /* in this test the background alone is halted */
    run_seconds(rig, 0.8);
    run_expect_no_fault(rig);
    chip_debug_realtime(chip(), true);
}

static void test_a_real_time_halt_stops_the_background_and_leaves_the_drive_running(void)
{
    run_real_time();
    let_the_carrier_run_through_halts();
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 600.0, speed());
    const double torque_current = rig_value(rig, "i_q_ref");
    const uint32_t before = samples();
    halt_at(0.4);
    double lowest = speed();
    double highest = lowest;
    double largest = 0.0;
    const uint32_t periods = rig_periods(5.0 * WATCHDOG);
    for (uint32_t n = 0; n < periods; n++) {
        pass_periods(1);
        lowest = fmin(lowest, speed());
        highest = fmax(highest, speed());
        largest = fmax(largest, current());
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, periods, samples() - before);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 600.0, lowest);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 600.0, highest);
    /* Single periods are compared: both contain the noise of the speed. */
    TEST_ASSERT_DOUBLE_WITHIN(0.4, torque_current, rig_value(rig, "i_q_ref"));
    TEST_ASSERT_DOUBLE_WITHIN(0.5, torque_current, largest);
    run_expect_no_fault(rig);
    TEST_ASSERT_FALSE(chip_halted(chip())); /* the watchdog, which was not served, has reset the chip */

    chip_debug_run(chip());
    run_seconds(rig, 5.0 * WATCHDOG); /* the background serves the watchdog again */
    run_expect_no_fault(rig);
    TEST_ASSERT_FALSE(chip_halted(chip()));
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 600.0, speed());
}

static void test_a_request_written_during_a_real_time_halt_acts(void)
{
    run_real_time();
    let_the_carrier_run_through_halts();
    halt_at(0.4);
    app->drive.requests.speed_request = (float)(300.0 * RPM);
    pass_seconds(0.8);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 300.0, speed());
    app->drive.requests.enable = 0;
    pass_periods(2u * DRIVE_WINDOW + 2u); /* the rest of this window, the next window, and a period */
    TEST_ASSERT_TRUE(chip_tripped(chip(), PWM_LEADER));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
}

/* ---- Restart without reset ---- */

/* The debugger halts the running drive, sets the CPU to its entry and lets it go. */
static void restart(void)
{
    halt_at(0.4);
    pass_periods(20);
    rig_bind(rig);
    chip_restart(chip());
    chip_debug_run(chip());
    watch();
    rig_start(rig);
}

static void expect_a_new_start(void)
{
    TEST_ASSERT_EQUAL_UINT32(1u, seen.all_tripped);
    TEST_ASSERT_EQUAL_UINT32(0u, seen.on_after_trip);
    TEST_ASSERT_EQUAL_HEX32(0u, seen.gates);
    TEST_ASSERT_EQUAL_UINT32(0u, seen.early);
    TEST_ASSERT_EQUAL_INT32((int32_t)HAL_OK, rig_state(rig)->app.board_status);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    run_to_ready(rig);
    TEST_ASSERT_EQUAL_UINT32(0u, seen.on_after_trip);
    run_on(rig, 60.0);
    run_seconds(rig, 0.2);
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE(seen.on_after_trip > 0u);
    TEST_ASSERT_EQUAL_HEX32(0u, seen.tripped);
    TEST_ASSERT_TRUE(chip_debug_can_look(chip()));
}

static void test_a_restart_with_the_bridge_on_opens_the_gates_and_comes_up_again(void)
{
    run_held_at(60.0);
    restart();
    expect_a_new_start();
}
