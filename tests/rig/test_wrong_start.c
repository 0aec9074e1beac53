/* A wrong initialisation goes wrong here as it would on silicon. Each test starts the real board and then
 * spoils one word. */
#include "hal/f28335/bus.h"
#include "hal/hal.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

void setUp(void)
{
    rig = run_rig(1);
    run_to_ready(rig);
    rig_bind(rig);
}

static uint32_t interrupts_in(uint32_t periods)
{
    const double before = rig_value(rig, "period");
    rig_run(rig, periods);
    return (uint32_t)(rig_value(rig, "period") - before);
}

static uint32_t reports(chip_report_kind_t kind)
{
    return chip_report_count(&rig_state(rig)->chip, kind);
}

static void test_missing_start_of_conversion_means_no_interrupt_and_a_watchdog_reset(void)
{
    bus_write16(&EPWM(BOARD_LEG_FIRST)->ETSEL, 0);
    rig_run(rig, 2);
    TEST_ASSERT_EQUAL_UINT32(0, interrupts_in(1000));
    TEST_ASSERT_EQUAL_UINT32(0, reports(CHIP_WATCHDOG_RESET));
    rig_run(rig, 3000); /* 279.6 ms after it was last fed */
    TEST_ASSERT_TRUE(reports(CHIP_WATCHDOG_RESET) >= 1u);
    TEST_ASSERT_TRUE(chip_halted(&rig_state(rig)->chip));
}

/* both outputs active high from the same signal, without complement */
static void spoil_polarity(void)
{
    for (uint32_t n = BOARD_LEG_FIRST; n <= BOARD_LEG_FIRST + 2u; n++) {
        bus_write16(&EPWM(n)->DBCTL, DBCTL_OUT_BOTH);
    }
}

static void test_wrong_dead_band_polarity_shoots_through_and_the_module_trips(void)
{
    run_on(rig, 0.0);
    rig_run(rig, RUN_SWITCHING_ON);
    run_expect_no_fault(rig);
    rig_bind(rig);
    spoil_polarity();
    rig_run(rig, 3);
    TEST_ASSERT_TRUE(rig_value(rig, "shoot_throughs") >= 1.0);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE(20.0, rig_value(rig, "fault_reason")); /* module_fault */
}

static void test_no_dead_band_at_all_shoots_through(void)
{
    run_on(rig, 0.0);
    rig_run(rig, RUN_SWITCHING_ON);
    run_expect_no_fault(rig);
    rig_bind(rig);
    for (uint32_t n = BOARD_LEG_FIRST; n <= BOARD_LEG_FIRST + 2u; n++) {
        bus_write16(&EPWM(n)->DBRED, 0);
        bus_write16(&EPWM(n)->DBFED, 0);
    }
    rig_run(rig, 3);
    /* turn-off takes 0.2 us longer than turn-on: both switches of a leg conduct */
    TEST_ASSERT_TRUE(rig_value(rig, "shoot_throughs") >= 1.0);
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
}
