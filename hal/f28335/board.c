/* The board as a whole: order of the start-up, the pins, one sample, time.
 *
 * A late or missing sample is detected by time: CPU timer 0 runs freely, also while a debugger halts the CPU,
 * and is compared with the time of the last carrier zero for which there was a sample. This time is stored in
 * the period register of CPU timer 1, which is stopped, because this module must not use variables (on the
 * host several chips share one process). */
#include "hal/f28335/adc.h"
#include "hal/f28335/bus.h"
#include "hal/f28335/clock.h"
#include "hal/f28335/eeprom.h"
#include "hal/f28335/interrupts.h"
#include "hal/f28335/pwm.h"
#include "hal/f28335/qep.h"
#include "hal/f28335/serial.h"
#include "hal/f28335/watchdog.h"
#include "hal/hal.h"

#define LAST_ZERO (&CPU_TIMER(1u)->PRD)

/* From this time of the period on the next conversion is in progress: too late to read the results of this
 * sample and to write its compare values. */
#define LATEST (PWM_PERIOD - ADC_LEAD)

/* GAP: a time without samples after which the currents are no longer controlled. After such a gap all samples
 * within HOLD are marked as late [ticks]. */
#define GAP  (10u * PWM_PERIOD)
#define HOLD (10u * PWM_PERIOD)

/* Six consecutive pins, from GPIO0 = EPWM1A or GPIO6 = EPWM4A on, each with function 1. */
#define GATE_PINS (UINT32_C(0x555) << (4u * (PWM_LEADER - 1u)))

#define OUTPUTS (BOARD_CHOPPER_OUTPUT != BOARD_NONE || BOARD_BRAKE_OUTPUT != BOARD_NONE)
#define LEDS    (BOARD_LED_RUN != BOARD_NONE || BOARD_LED_FAULT != BOARD_NONE)

static bool config_is_good(const hal_config_t *config)
{
    return config != NULL && config->dead_band_count >= HAL_DEAD_BAND_MIN &&
           config->dead_band_count <= HAL_DEAD_BAND_MAX && qep_count_max_check(config->encoder_count_max) &&
           config->on_sample != NULL && config->on_medium != NULL && config->on_trip != NULL;
}

static void start_time(void)
{
    bus_write16(&CPU_TIMER(1u)->TCR, TCR_TSS);
    bus_write32(&CPU_TIMER(0u)->PRD, UINT32_MAX);
    bus_write16(&CPU_TIMER(0u)->TPR, 0u);
    bus_write16(&CPU_TIMER(0u)->TPRH, 0u);
    bus_write16(&CPU_TIMER(0u)->TCR, TCR_TRB | TCR_FREE);
}

/* Selects the function of a pin: pins 0 to 15 of a port of 32 have their fields in MUX1, the others in MUX2.
 */
static void connect_pin(uint16_t pin, uint16_t function)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(pin / 32u);
    const volatile uint32_t *mux = (pin & 16u) != 0u ? &port->MUX2 : &port->MUX1;

    bus_write32(mux, *mux | GPIO_FIELD(pin, function));
}

static void connect_pins(void)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(0u);
    uint16_t n;

    bus_allow();
    /* The fault line first: its input is asynchronous, so that it trips without a clock, and has a pull-up if
     * the driver of the line is an open collector. */
#if BOARD_TRIP_PULL_UP
    bus_write32(&port->PUD, port->PUD & ~GPIO_PIN(PWM_FAULT_PIN));
#endif
#if BOARD_TRIP_ZONE < 5
    bus_write32(&port->QSEL1, port->QSEL1 | GPIO_FIELD(PWM_FAULT_PIN, GPIO_QSEL_ASYNC));
#else
    bus_write32(&port->QSEL2, port->QSEL2 | GPIO_FIELD(PWM_FAULT_PIN, GPIO_QSEL_ASYNC));
#endif
    connect_pin(PWM_FAULT_PIN, PWM_FAULT_PIN_MUX);
    bus_write32(&port->MUX1, port->MUX1 | GATE_PINS);
    for (n = 0u; n < 4u; n++) {
        connect_pin((uint16_t)(QEP_PIN + n), QEP_PIN_MUX);
    }
    bus_protect();
    /* A write to the multiplexer of a pin takes effect two cycles later. */
    bus_wait(2u);
}

#if BOARD_SERIAL_BAUD != 0
/* Both pins have pull-ups. The input has no qualification, because its sampling would shift the edges of the
 * bits. */
static void connect_serial(void)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(SERIAL_PIN_IN / 32u);

    bus_allow();
    bus_write32(&port->PUD, port->PUD & ~(GPIO_PIN(SERIAL_PIN_IN) | GPIO_PIN(SERIAL_PIN_OUT)));
    bus_write32(&port->SERIAL_PIN_QSEL, port->SERIAL_PIN_QSEL | GPIO_FIELD(SERIAL_PIN_IN, GPIO_QSEL_ASYNC));
    connect_pin(SERIAL_PIN_IN, SERIAL_PIN_MUX);
    connect_pin(SERIAL_PIN_OUT, SERIAL_PIN_MUX);
    bus_protect();
}
#endif

#if BOARD_ENABLE_INPUT != BOARD_NONE
#define ENABLE_PIN ((uint16_t)BOARD_ENABLE_INPUT)

/* An open wire must read as not enabled. If a low level enables, the pull-up is on; if a high level enables,
 * the pull-up is off, and the board has a pull-down resistor. */
static void connect_enable(void)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(ENABLE_PIN / 32u);
    const uint32_t pin = GPIO_PIN(ENABLE_PIN);

    bus_allow();
    bus_write32(&port->PUD, BOARD_ENABLE_ACTIVE_HIGH != 0 ? port->PUD | pin : port->PUD & ~pin);
    bus_write32(&port->DIR, port->DIR & ~pin);
    bus_protect();
}
#endif

/* Level of the enable input; a board without one is always enabled. */
static inline bool is_enabled(void)
{
#if BOARD_ENABLE_INPUT == BOARD_NONE
    return true;
#elif BOARD_ENABLE_ACTIVE_HIGH
    return (GPIO_DATA(ENABLE_PIN / 32u)->DAT & GPIO_PIN(ENABLE_PIN)) != 0u;
#else
    return (GPIO_DATA(ENABLE_PIN / 32u)->DAT & GPIO_PIN(ENABLE_PIN)) == 0u;
#endif
}

#if LEDS
static void set_led(uint16_t pin, bool on)
{
    const volatile gpio_data_regs_t *port = GPIO_DATA(pin / 32u);

    if (pin != BOARD_NONE) {
        bus_write32(on == (BOARD_LED_ACTIVE_LOW != 0) ? &port->CLEAR : &port->SET, GPIO_PIN(pin));
    }
}

static void connect_led(uint16_t pin)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(pin / 32u);

    if (pin != BOARD_NONE) {
        set_led(pin, false);
        bus_allow();
        bus_write32(&port->DIR, port->DIR | GPIO_PIN(pin));
        bus_protect();
    }
}
#endif

void hal_leds(bool run, bool fault)
{
#if LEDS
    set_led((uint16_t)BOARD_LED_RUN, run);
    set_led((uint16_t)BOARD_LED_FAULT, fault);
#else
    (void)run;
    (void)fault;
#endif
}

#if OUTPUTS
static inline void set_pin(uint16_t pin, bool high)
{
    const volatile gpio_data_regs_t *port = GPIO_DATA(pin / 32u);

    bus_write32(high ? &port->SET : &port->CLEAR, GPIO_PIN(pin));
}

/* Makes a pin an output. Its level is the one that set_pin() has set before. */
static void drive_pin(uint16_t pin)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(pin / 32u);

    bus_allow();
    bus_write32(&port->DIR, port->DIR | GPIO_PIN(pin));
    bus_protect();
}

static void connect_outputs(void)
{
    hal_outputs(false, false);
#if BOARD_CHOPPER_OUTPUT != BOARD_NONE
    drive_pin((uint16_t)BOARD_CHOPPER_OUTPUT);
#endif
#if BOARD_BRAKE_OUTPUT != BOARD_NONE
    drive_pin((uint16_t)BOARD_BRAKE_OUTPUT);
#endif
}
#endif

void hal_outputs(bool chopper, bool brake)
{
#if BOARD_CHOPPER_OUTPUT != BOARD_NONE
    set_pin((uint16_t)BOARD_CHOPPER_OUTPUT, BOARD_CHOPPER_ACTIVE_HIGH != 0 ? chopper : !chopper);
#else
    (void)chopper;
#endif
#if BOARD_BRAKE_OUTPUT != BOARD_NONE
    set_pin((uint16_t)BOARD_BRAKE_OUTPUT, BOARD_BRAKE_ACTIVE_HIGH != 0 ? brake : !brake);
#else
    (void)brake;
#endif
}

hal_memory_t hal_memory(hal_region_t region)
{
    static const bus_region_t of[HAL_REGIONS] = {BUS_PROGRAM, BUS_INTERRUPT_CODE, BUS_STACK_END};
    const bus_memory_t memory = bus_memory(of[region]);
    return (hal_memory_t){memory.words, memory.count};
}

/* The first steps of the start-up. A second call has no effect. */
static hal_status_t board_begin(void)
{
    bus_interrupts_disable();
    watchdog_stop();
    start_time();
    return clock_init();
}

#if BOARD_STORE == BOARD_STORE_I2C
bool hal_eeprom_open(void)
{
    bool idle;

    if (board_begin() != HAL_OK) {
        return false;
    }
    idle = eeprom_free_bus();
    eeprom_init();
    return idle;
}
#endif

hal_status_t hal_init(const hal_config_t *config)
{
    hal_status_t status;

    if (!config_is_good(config)) {
        return HAL_BAD_CONFIG;
    }
    status = board_begin();
    if (status != HAL_OK) {
        return status;
    }
#if BOARD_SERIAL_BAUD != 0
    connect_serial(); /* before all other parts, because the serial line reports why a later part did not
                         start */
#endif
    serial_init();
    if (!pwm_init(config->dead_band_count)) {
        return HAL_TRIP_FAILED;
    }
    connect_pins();
#if BOARD_ENABLE_INPUT != BOARD_NONE
    connect_enable();
#endif
#if OUTPUTS
    connect_outputs();
#endif
#if LEDS
    connect_led((uint16_t)BOARD_LED_RUN);
    connect_led((uint16_t)BOARD_LED_FAULT);
#endif
    adc_init();
    qep_init(config->encoder_count_max);
    interrupts_init(config);

    bus_write32(LAST_ZERO, hal_time());
    qep_start();
    clock_start_carrier();
    bus_interrupts_enable();
    return HAL_OK;
}

/* The result of the ADC for an input; 0 if the board does not have the input. */
#define RESULT(input, place)                                                                                 \
    ((input) == BOARD_NONE ? (uint16_t)0u : ADC_MIRROR->ADCRESULT[ADC_RESULT(input, place)])

/* The time to be stored as the last zero after a late sample: that of this sample; after a gap a zero in the
 * future, so that every sample until then is late. */
static uint32_t zero_after_late(uint32_t zero, uint32_t since_last)
{
    if (0u - since_last <= HOLD) {
        return zero - since_last;
    }
    return since_last >= GAP ? zero + HOLD : zero;
}

void hal_read(hal_samples_t *samples)
{
    const uint32_t elapsed = pwm_elapsed();
    uint32_t zero = hal_time() - elapsed;
    const uint32_t since_last = zero - *LAST_ZERO;
    uint16_t flags = 0u;

    /* The time since the last zero must be one period, within half a period. */
    if (elapsed >= LATEST || since_last - PWM_PERIOD / 2u >= PWM_PERIOD) {
        flags = HAL_FLAG_LATE;
        zero = zero_after_late(zero, since_last);
    } else {
        qep_keep_step(elapsed);
    }
    bus_write32(LAST_ZERO, zero);

    if (pwm_any_tripped()) {
        flags |= HAL_FLAG_TRIPPED;
    }
    if (pwm_fault_line()) {
        flags |= HAL_FLAG_FAULT_PIN;
    }
    if (qep_take_error()) {
        flags |= HAL_FLAG_ENCODER;
    }
    if (!is_enabled()) {
        flags |= HAL_FLAG_NOT_ENABLED;
    }
    samples->current_a = RESULT(BOARD_CURRENT_A_INPUT, ADC_PLACE_A);
    samples->current_b = RESULT(BOARD_CURRENT_B_INPUT, ADC_PLACE_A);
    samples->current_c = RESULT(BOARD_CURRENT_C_INPUT, ADC_PLACE_C);
    samples->dc_link = RESULT(BOARD_DC_INPUT, ADC_PLACE_DC);
    samples->sink_temperature = RESULT(BOARD_SINK_INPUT, ADC_PLACE_SINK);
    samples->motor_temperature = RESULT(BOARD_MOTOR_INPUT, ADC_PLACE_MOTOR);
    samples->flags = flags;
    samples->encoder = EQEP(QEP_MODULE)->QPOSLAT;
}

void hal_end_of_sample(void)
{
    /* The interrupt took too long: the conversion that began meanwhile is lost. The last zero is moved back
     * by a period, so that the next sample is late in any case. A last zero in the future stays. */
    if (hal_time() - *LAST_ZERO - LATEST < UINT32_MAX / 2u) {
        bus_write32(LAST_ZERO, *LAST_ZERO - PWM_PERIOD);
    }
    adc_rearm();
    interrupts_acknowledge(INTERRUPTS_SAMPLE);
}

uint32_t hal_time(void)
{
    return UINT32_MAX - CPU_TIMER(0u)->TIM;
}
