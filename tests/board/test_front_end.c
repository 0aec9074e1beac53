/* Voltages at the pins of the board must arrive in the drive as the right quantities. The path under test
 * is the chip, the HAL and the conversions of the application. The expected values are calculated here
 * from the lines of the board file as docs/board.md explains them, in double precision. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/app.h"
#include "hal/f28335/bus.h"
#include "hal/hal.h"
#include "host_sim/chip/chip.h"
#include "unity.h"

#define FULL   3.0             /* [V] at the ADC's pin */
#define CODE   (FULL / 4096.0) /* [V] */
#define INPUTS 16

/* Half a code, and 0.2 % of it for the rounding of single precision at some thousand codes. */
#define HALF_CODE (0.5 * 1.002)

static chip_t chip;
static double volts[INPUTS];
static int64_t position; /* [counts] of the encoder */
static drive_samples_t got;

static double analog(void *context, uint64_t tick, uint32_t channel)
{
    (void)context;
    (void)tick;
    return volts[channel];
}

static void gates(void *context, uint64_t tick, uint32_t level, uint32_t driven)
{
    (void)context;
    (void)tick;
    (void)level;
    (void)driven;
}

static int64_t encoder(void *context, uint64_t tick)
{
    (void)context;
    (void)tick;
    return position;
}

static const chip_world_t world = {.analog = analog, .gates = gates, .encoder = encoder};

static void on_sample(void)
{
    app_read(&got);
    hal_end_of_sample();
}

static void on_medium(void)
{
}

static void on_trip(void)
{
    hal_end_of_trip();
}

void setUp(void)
{
    const hal_config_t config = {HAL_DEAD_BAND_MAX, 9999u, on_sample, on_medium, on_trip, NULL};
    position = 0;
    for (uint32_t n = 0; n < INPUTS; n++) {
        volts[n] = 0.1 + 0.17 * n; /* all differ, so that a wrong input is detected */
    }
    chip_power_on(&chip, BOARD_CRYSTAL_HZ);
    chip_bind(&chip, &world);
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_init(&config));
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT32(0u, chip_report_total(&chip));
}

/* The sample of a period during which only these voltages were applied. */
static void take_sample(void)
{
    chip_run(chip_now(&chip) + 3u * CHIP_TICKS_PER_SECOND / BOARD_CARRIER_HZ);
}

/* A quantity that is a straight line from 0 V to 3 V at the pin. */
typedef struct {
    double at_0v, at_3v;
} line_t;

static double on_line(line_t line, double pin)
{
    return line.at_0v + (line.at_3v - line.at_0v) * pin / FULL;
}

/* STEP_MA (mV) is the change of the quantity for STEP_MV (mV) at the pin; it is zero at ZERO_MV. */
static line_t line_of(double zero_mv, double step_milli, double step_mv)
{
    return (line_t){(0.0 - zero_mv) * step_milli / step_mv / 1e3,
                    (3000.0 - zero_mv) * step_milli / step_mv / 1e3};
}

/* Tests five points over the range, each at the largest offset from the middle of a code in both
 * directions. */
static void expect_line(const char *what, uint32_t input, line_t line, const float *sample)
{
    const double limit = HALF_CODE * fabs(line.at_3v - line.at_0v) / 4096.0;
    char message[120];
    for (int32_t point = 0; point <= 4; point++) {
        for (int32_t beside = -1; beside <= 1; beside++) {
            const double pin = fmin(fmax(FULL * point / 4.0 + 0.499 * CODE * beside, 0.0), FULL);
            volts[input] = pin;
            take_sample();
            snprintf(message, sizeof message, "%s: %.5f V at the pin is %.6g, the drive gets %.6g", what, pin,
                     on_line(line, pin), (double)*sample);
            TEST_ASSERT_TRUE_MESSAGE(fabs((double)*sample - on_line(line, pin)) <= limit, message);
        }
    }
    for (int32_t end = 0; end < 2; end++) {
        volts[input] = end == 0 ? -0.4 : 3.3;
        take_sample();
        TEST_ASSERT_TRUE_MESSAGE(fabs((double)*sample - (end == 0 ? line.at_0v : line.at_3v)) <= limit, what);
    }
    printf("%s: %.6g at 0 V, %.6g at 3 V, half a code %.3g\n", what, line.at_0v, line.at_3v, limit / 1.002);
}

static void test_currents_are_those_at_the_pins_from_end_to_end(void)
{
    const line_t line = line_of(BOARD_CURRENT_ZERO_MV, BOARD_CURRENT_STEP_MA, BOARD_CURRENT_STEP_MV);
    expect_line("current a", BOARD_CURRENT_A_INPUT, line, &got.i_a);
    expect_line("current b", BOARD_CURRENT_B_INPUT, line, &got.i_b);
#if BOARD_CURRENT_C_INPUT != BOARD_NONE
    expect_line("current c", BOARD_CURRENT_C_INPUT, line, &got.i_c);
#endif
}

/* A third sensor is read by itself; without one, current c is minus the sum of a and b. */
static void test_current_c_of_two_sensors_closes_the_sum(void)
{
    volts[BOARD_CURRENT_A_INPUT] = 1.1;
    volts[BOARD_CURRENT_B_INPUT] = 2.2;
    take_sample();
#if BOARD_CURRENT_C_INPUT == BOARD_NONE
    TEST_ASSERT_EQUAL_FLOAT(-(got.i_a + got.i_b), got.i_c);
#else
    const float a = got.i_a;
    const float b = got.i_b;
    const float c = got.i_c;
    volts[BOARD_CURRENT_C_INPUT] += 0.5;
    take_sample();
    TEST_ASSERT_EQUAL_FLOAT(a, got.i_a);
    TEST_ASSERT_EQUAL_FLOAT(b, got.i_b);
    TEST_ASSERT_TRUE(got.i_c != c);
#endif
}

static void test_dc_link_is_that_at_the_pin_from_end_to_end(void)
{
    expect_line("link", BOARD_DC_INPUT, line_of(0.0, BOARD_DC_STEP_MV, BOARD_DC_PIN_MV), &got.u_dc);
}

/* The value for "no sensor" is colder than any temperature. */
static void test_temperatures_are_those_at_the_pins_or_absent(void)
{
#if BOARD_SINK_INPUT != BOARD_NONE
    expect_line("sink", BOARD_SINK_INPUT, (line_t){BOARD_SINK_AT_0V, BOARD_SINK_AT_3V},
                &got.sink_temperature);
#else
    take_sample();
    TEST_ASSERT_EQUAL_FLOAT(-273.15f, got.sink_temperature);
#endif
#if BOARD_MOTOR_INPUT != BOARD_NONE
    expect_line("motor", BOARD_MOTOR_INPUT, (line_t){BOARD_MOTOR_AT_0V, BOARD_MOTOR_AT_3V},
                &got.motor_temperature);
#else
    take_sample();
    TEST_ASSERT_EQUAL_FLOAT(-273.15f, got.motor_temperature);
#endif
}

/* Inputs that the board does not name may have any voltage. */
static void test_other_inputs_do_not_matter(void)
{
    static const uint32_t wired[] = {BOARD_CURRENT_A_INPUT, BOARD_CURRENT_B_INPUT, BOARD_CURRENT_C_INPUT,
                                     BOARD_DC_INPUT,        BOARD_SINK_INPUT,      BOARD_MOTOR_INPUT};
    take_sample();
    const drive_samples_t before = got;
    for (uint32_t n = 0; n < INPUTS; n++) {
        bool is_wired = false;
        for (uint32_t k = 0; k < sizeof wired / sizeof wired[0]; k++) {
            is_wired = is_wired || wired[k] == n;
        }
        volts[n] = is_wired ? volts[n] : 3.0 - volts[n];
    }
    take_sample();
    TEST_ASSERT_EQUAL_MEMORY(&before, &got, sizeof got);
}

/* ---- digital pins ---- */

/* The four pins that line 13 names for the encoder are assigned to the eQEP; the pins of the other
 * possible encoder places are not. */
static uint32_t function_of(uint32_t pin)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(pin / 32u);
    const uint32_t mux = (pin & 16u) != 0u ? port->MUX2 : port->MUX1;
    return (mux >> (2u * (pin & 15u))) & 3u;
}

static void test_encoder_is_counted_from_its_pins(void)
{
    /* GPIO20: EQEP1A is function 1, GPIO50: 1, GPIO24: EQEP2A is function 2 (data manual). */
    static const struct {
        uint32_t pin, function;
        bool here;
    } places[] = {{20u, 1u, BOARD_ENCODER == BOARD_EQEP1_GPIO20},
                  {50u, 1u, BOARD_ENCODER == BOARD_EQEP1_GPIO50},
                  {24u, 2u, BOARD_ENCODER == BOARD_EQEP2_GPIO24}};
    for (uint32_t n = 0; n < 3u; n++) {
        for (uint32_t pin = places[n].pin; pin < places[n].pin + 4u; pin++) {
            TEST_ASSERT_EQUAL_UINT32(places[n].here ? places[n].function : 0u, function_of(pin));
        }
    }
    for (int32_t n = 0; n < 50; n++) {
        position += 7;
        take_sample();
    }
    TEST_ASSERT_EQUAL_UINT32(350u, got.encoder);
    position -= 360;
    take_sample();
    TEST_ASSERT_EQUAL_UINT32(9990u, got.encoder);
}

/* Input of the fault line: TZ1 to 4 are function 1 of GPIO12 to 15, TZ5 and 6 function 3 of GPIO16 and 17. */
static void test_fault_line_is_a_trip_input_with_the_requested_pull_up(void)
{
    const uint32_t pin = 11u + BOARD_TRIP_ZONE;
    TEST_ASSERT_EQUAL_UINT32(BOARD_TRIP_ZONE <= 4 ? 1u : 3u, function_of(pin));
#if BOARD_TRIP_PULL_UP
    TEST_ASSERT_EQUAL_UINT32(0u, GPIO_CONTROL(0u)->PUD >> pin & 1u);
#endif
}

/* The level that line 19 names enables the drive; an open wire does not. */
static void test_enable_input_is_read_at_its_pin_and_off_with_an_open_wire(void)
{
#if BOARD_ENABLE_INPUT != BOARD_NONE
    const uint32_t pull_up_off =
        GPIO_CONTROL(BOARD_ENABLE_INPUT / 32u)->PUD >> (BOARD_ENABLE_INPUT % 32u) & 1u;
    TEST_ASSERT_EQUAL_UINT32(BOARD_ENABLE_ACTIVE_HIGH, pull_up_off);
    for (uint32_t high = 0; high < 2u; high++) {
        chip_set_pin(&chip, BOARD_ENABLE_INPUT, high != 0u);
        take_sample();
        TEST_ASSERT_EQUAL_HEX32(high == BOARD_ENABLE_ACTIVE_HIGH ? 0u : DRIVE_SAMPLE_NOT_ENABLED,
                                got.flags & DRIVE_SAMPLE_NOT_ENABLED);
    }
#else
    take_sample();
    TEST_ASSERT_EQUAL_HEX32(0u, got.flags & DRIVE_SAMPLE_NOT_ENABLED);
#endif
}

static void expect_output(int32_t pin, bool high)
{
    if (pin != BOARD_NONE) {
        TEST_ASSERT_EQUAL_INT32(high, chip_pin_out(&chip, (uint32_t)pin));
    }
}

#if BOARD_CHOPPER_OUTPUT == BOARD_NONE
#define CHOPPER_HIGH false
#else
#define CHOPPER_HIGH (BOARD_CHOPPER_ACTIVE_HIGH != 0)
#endif
#if BOARD_BRAKE_OUTPUT == BOARD_NONE
#define BRAKE_HIGH false
#else
#define BRAKE_HIGH (BOARD_BRAKE_ACTIVE_HIGH != 0)
#endif

static void test_chopper_and_brake_follow_their_orders_and_are_off_at_first(void)
{
    expect_output(BOARD_CHOPPER_OUTPUT, !CHOPPER_HIGH);
    expect_output(BOARD_BRAKE_OUTPUT, !BRAKE_HIGH);
    for (uint32_t n = 0; n < 4u; n++) {
        const bool chopper = (n & 1u) != 0u, brake = (n & 2u) != 0u;
        hal_outputs(chopper, brake);
        expect_output(BOARD_CHOPPER_OUTPUT, chopper == CHOPPER_HIGH);
        expect_output(BOARD_BRAKE_OUTPUT, brake == BRAKE_HIGH);
    }
}

static void expect_led(int32_t pin, bool lit)
{
    if (pin != BOARD_NONE) {
        TEST_ASSERT_EQUAL_INT32(lit != (BOARD_LED_ACTIVE_LOW != 0), chip_pin_out(&chip, (uint32_t)pin));
    }
}

static void test_lights_show_run_and_fault_and_are_dark_at_first(void)
{
    expect_led(BOARD_LED_RUN, false);
    expect_led(BOARD_LED_FAULT, false);
    for (uint32_t n = 0; n < 4u; n++) {
        hal_leds((n & 1u) != 0u, (n & 2u) != 0u);
        expect_led(BOARD_LED_RUN, (n & 1u) != 0u);
        expect_led(BOARD_LED_FAULT, (n & 2u) != 0u);
    }
}
