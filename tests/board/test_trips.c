/* Conditions that must open the gates of any board: the fault line, currents, the link, and sensors at the
 * ends of their range. The test observes the gates as levels of the pins that lines 4 and 5 name. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "tests/board/motors.h"

#define TRIP (BOARD_OVERCURRENT_TRIP_MA / 1e3) /* [A] */
#define PINS 12u                               /* GPIO0..11: EPWM1A to EPWM6B */

static rig_t *rig;

/* The rotor turns at half the rated speed without friction, so that almost no current but the ripple
 * flows. */
void setUp(void)
{
    rig = rig_create(41);
    board_put_motor(rig);
    run_put(rig, "current_noise", 0.0);
    run_put(rig, "friction_coulomb", 0.0);
    board_to_ready_at(rig, 0.5 * board_motor.speed);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "shoot_throughs"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "chip_reports"));
    rig_free(rig);
}

static void turn_on(void)
{
    run_on(rig, 0.5 * BOARD_RATED_RPM);
    run_seconds(rig, 0.2);
    run_expect_no_fault(rig);
}

static bool is_gate(uint32_t pin)
{
    static const uint32_t legs[3] = {BOARD_LEG_A, BOARD_LEG_B, BOARD_LEG_C};
    for (uint32_t leg = 0; leg < 3u; leg++) {
        if (pin == 2u * legs[leg] - 2u || pin == 2u * legs[leg] - 1u) {
            return true;
        }
    }
    return false;
}

static uint32_t gates_on(void)
{
    uint32_t on = 0;
    for (uint32_t pin = 0; pin < PINS; pin++) {
        on += is_gate(pin) && chip_pin_out(&rig_state(rig)->chip, pin) == (HAL_GATE_ACTIVE_HIGH != 0);
    }
    return on;
}

/* The pins drive the gates off instead of leaving that to the resistors of the board; pins without a gate
 * are not driven. */
static void expect_gates_off(void)
{
    for (uint32_t pin = 0; pin < PINS; pin++) {
        const int32_t out = chip_pin_out(&rig_state(rig)->chip, pin);
        TEST_ASSERT_EQUAL_INT32(is_gate(pin) ? HAL_GATE_ACTIVE_HIGH == 0 : -1, out);
    }
}

static void expect_fault(int32_t reason)
{
    TEST_ASSERT_EQUAL_DOUBLE((double)reason, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_value(rig, "state"));
    expect_gates_off();
}

/* The currents that are read exceed the true ones by these values; with two sensors current c is minus the
 * sum of both. */
static void read_currents(double a, double b, double c)
{
    run_put(rig, "current_offset_a", a);
    run_put(rig, "current_offset_b", b);
    run_put(rig, "current_offset_c", c);
}

static void reset(void)
{
    read_currents(0.0, 0.0, 0.0);
    run_put(rig, "enable", 0.0);
    run_seconds(rig, 0.03);
    run_put(rig, "fault_reset", 1.0);
    run_seconds(rig, 0.1);
    run_put(rig, "fault_reset", 0.0);
    run_seconds(rig, 0.001);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
}

/* ---- the fault line ---- */

static void test_fault_line_shuts_all_gates_in_the_same_instant(void)
{
    chip_t *chip = &rig_state(rig)->chip;
    turn_on();
    for (uint32_t part = 1; part <= 3u; part++) { /* at three times within the period */
        rig_bind(rig);
        chip_run(chip_now(chip) + part * RIG_PERIOD_TICKS / 5u);
        /* waits for the end of a dead time: three switches are on, one in each leg */
        while (gates_on() < 3u) {
            chip_run(chip_now(chip) + 10u);
        }
        const uint64_t before = chip_now(chip);
        chip_set_pin(chip, 11u + BOARD_TRIP_ZONE, false);
        TEST_ASSERT_EQUAL_UINT64(before, chip_now(chip));
        expect_gates_off();
        chip_set_pin(chip, 11u + BOARD_TRIP_ZONE, true);
        expect_gates_off();
        rig_step(rig);
        expect_fault(REASON_MODULE_FAULT);
        reset();
        turn_on();
    }
}

/* The pins of the other trip zones are not used on the board. */
static void test_other_trip_pins_do_nothing(void)
{
    turn_on();
    for (uint32_t zone = 1; zone <= 6u; zone++) {
        if (zone != BOARD_TRIP_ZONE) {
            rig_bind(rig);
            chip_set_pin(&rig_state(rig)->chip, 11u + zone, false);
            run_seconds(rig, 0.002);
        }
    }
    run_expect_no_fault(rig);
    TEST_ASSERT_TRUE(gates_on() >= 2u);
}

/* ---- currents ---- */

/* Raises one phase alone beyond the trip; the two other phases carry half of its current each. */
static void read_current(uint32_t phase, double amperes)
{
    read_currents(phase == 0u ? amperes : -0.5 * amperes, phase == 1u ? amperes : -0.5 * amperes,
                  phase == 2u ? amperes : -0.5 * amperes);
}

/* The bridge is off, so that no current flows. A reading 1.5 % below the trip causes no fault, 1.5 % above
 * it an immediate one. */
static void expect_trip_at(double trip)
{
    for (uint32_t phase = 0; phase < 3u; phase++) {
        for (int32_t direction = -1; direction <= 1; direction += 2) {
            char message[80];
            snprintf(message, sizeof message, "phase %c, %+g A", "abc"[phase], direction * trip);
            read_current(phase, 0.985 * direction * trip);
            rig_run(rig, 20);
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(0.0, rig_value(rig, "fault_reason"), message);
            read_current(phase, 1.015 * direction * trip);
            rig_run(rig, 1);
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE((double)REASON_OVERCURRENT, rig_value(rig, "fault_reason"),
                                             message);
            reset();
        }
    }
}

static void test_each_phase_trips_in_each_direction_at_the_board_s_current(void)
{
    expect_trip_at(TRIP);
}

/* The largest trip that the parameter accepts, 95 % of the sensors' range that is valid in both
 * directions, is still measured. */
static void test_the_largest_trip_is_seen_in_each_direction(void)
{
    const double seen = fmin(BOARD_CURRENT_ZERO_MV, 3000.0 - BOARD_CURRENT_ZERO_MV) *
                        fabs((double)BOARD_CURRENT_STEP_MA) / BOARD_CURRENT_STEP_MV / 1e3;
    run_parameter(rig, "overcurrent_trip", 0.9499 * seen);
    rig_run(rig, 2u * DRIVE_WINDOW); /* a set takes effect in the second period of the next window */
    expect_trip_at(0.9499 * seen);
}

static void test_overcurrent_shuts_the_gates_of_a_running_drive(void)
{
    for (uint32_t phase = 0; phase < 3u; phase++) {
        turn_on();
        const double direction = phase == 1u ? -1.0 : 1.0;
        read_current(phase, 1.03 * direction * TRIP);
        rig_run(rig, 1);
        expect_fault(REASON_OVERCURRENT);
        reset();
    }
}

/* ---- rails ---- */

static void test_a_sensor_at_either_rail_stops_the_drive(void)
{
    static const char *const stuck[3] = {"stuck_current_a", "stuck_current_b", "stuck_current_c"};
    const uint32_t sensors = BOARD_CURRENT_C_INPUT == BOARD_NONE ? 2u : 3u;
    for (uint32_t sensor = 0; sensor < sensors; sensor++) {
        for (uint32_t rail = 0; rail < 2u; rail++) {
            turn_on();
            run_put(rig, stuck[sensor], rail == 0u ? 0.0 : 4095.0);
            rig_run(rig, 3);
            expect_fault(REASON_BAD_SAMPLE);
            run_put(rig, stuck[sensor], -1.0);
            reset();
        }
    }
}

/* ---- link ---- */

/* One per cent inside a limit no fault follows; one per cent beyond it a fault follows within this number
 * of periods. */
static void expect_link_trip(double limit, double beyond, uint32_t periods, int32_t reason)
{
    run_put(rig, "dc_voltage", limit - 0.01 * beyond * limit);
    run_seconds(rig, 0.005);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    run_put(rig, "dc_voltage", limit + 0.01 * beyond * limit);
    rig_run(rig, periods);
    expect_fault(reason);
}

static void test_link_trips_at_the_board_s_voltages(void)
{
    turn_on();
    expect_link_trip(BOARD_OVERVOLTAGE_MV / 1e3, 1.0, 2u, REASON_DC_OVERVOLTAGE);
    run_put(rig, "dc_voltage", BOARD_DC_NOMINAL_MV / 1e3);
    reset();
    turn_on();
    expect_link_trip(BOARD_UNDERVOLTAGE_MV / 1e3, -1.0, rig_periods(0.002), REASON_DC_UNDERVOLTAGE);
}

/* The largest overvoltage trip of the board is still within the range of the ADC. */
static void test_the_largest_overvoltage_trip_is_seen(void)
{
    run_parameter(rig, "dc_overvoltage", BOARD_OVERVOLTAGE_MAX_MV / 1e3);
    rig_run(rig, 2u * DRIVE_WINDOW); /* a set takes effect in the second period of the next window */
    expect_link_trip(BOARD_OVERVOLTAGE_MAX_MV / 1e3, 1.0, 2u, REASON_DC_OVERVOLTAGE);
}

/* ---- temperatures ---- */

static void expect_hot_trip(const char *plant, const char *limit, bool sensor, int32_t reason)
{
    run_put(rig, plant, rig_value(rig, limit) + 2.0);
    run_seconds(rig, 0.11);
    if (sensor) {
        expect_fault(reason);
        run_put(rig, plant, 40.0);
        reset();
    } else {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    }
}

static void test_heat_trips_where_there_is_a_sensor(void)
{
    expect_hot_trip("plant.sink_temperature", "sink_temperature_max", BOARD_SINK_INPUT != BOARD_NONE,
                    REASON_SINK_HOT);
    expect_hot_trip("plant.motor_temperature", "motor_temperature_max", BOARD_MOTOR_INPUT != BOARD_NONE,
                    REASON_MOTOR_HOT);
}

/* ---- enable input ---- */

#if BOARD_ENABLE_INPUT != BOARD_NONE
#define DEBOUNCE (BOARD_ENABLE_DEBOUNCE_US / 1e6) /* [s] */
/* [s] until the medium task has acted on an order. */
#define WINDOWS (4.0 * DRIVE_WINDOW * RIG_PERIOD_SECONDS)

static void expect_off_for(double seconds, int32_t refusal)
{
    for (uint32_t n = rig_periods(seconds); n > 0u; n--) {
        rig_step(rig);
        TEST_ASSERT_EQUAL_UINT32(0u, gates_on());
    }
    TEST_ASSERT_EQUAL_DOUBLE((double)refusal, rig_value(rig, "refusal"));
}

static void test_without_the_enable_input_no_request_turns_a_gate_on(void)
{
    run_put(rig, "enable_input", 1.0);
    run_seconds(rig, DEBOUNCE + WINDOWS);
    run_put(rig, "enable", 1.0);
    expect_off_for(0.1, REASON_ENABLE_INPUT);
    run_put(rig, "enable_input", 0.0);
    expect_off_for(0.1, REASON_ENABLE_HELD);
    run_put(rig, "enable", 0.0);
    run_seconds(rig, WINDOWS);
    turn_on();
}

/* Braking begins after the debounce time, and the gates are off 50 ms later, at standstill and at speed. */
static void test_a_lost_enable_input_brakes_and_opens_within_50_ms(void)
{
    turn_on();
    run_put(rig, "enable_input", 1.0);
    run_seconds(rig, DEBOUNCE - RIG_PERIOD_SECONDS);
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_OPERATION_ENABLED, rig_value(rig, "state"));
    run_seconds(rig, WINDOWS);
    TEST_ASSERT_TRUE(rig_value(rig, "state") >= (double)DRIVE_QUICK_STOP);
    run_seconds(rig, 50e-3);
    expect_fault(REASON_ENABLE_INPUT);
}
#else
static void test_a_board_without_an_enable_input_has_none_that_could_be_lost(void)
{
    TEST_ASSERT_FALSE(rig_put(rig, "enable_input", 1.0));
    TEST_ASSERT_NOT_NULL(strstr(rig_error(rig), "no enable input"));
    turn_on();
}
#endif
