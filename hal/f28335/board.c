/* The board as a whole: order of the start-up, the pins, one sample, time.
 *
 * A period that went wrong is found by the clock: CPU timer 0 free-running, and the time of the last carrier
 * zero that a sample belonged to. That one word is kept in the period register of CPU timer 1, which stands
 * still, because nothing here may live in a variable (several chips share one process on the host). */
#include "hal/f28335/adc.h"
#include "hal/f28335/bus.h"
#include "hal/f28335/clock.h"
#include "hal/f28335/interrupts.h"
#include "hal/f28335/pwm.h"
#include "hal/f28335/qep.h"
#include "hal/f28335/watchdog.h"
#include "hal/hal.h"

#define LAST_ZERO (&CPU_TIMER(1u)->PRD)

/* From here on the next conversion is under way: too late for this sample's results and compare values. */
#define LATEST (PWM_PERIOD - ADC_LEAD)

#define GATE_PINS    0x00000555u /* GPIO0..5 = EPWM1A..3B */
#define ENCODER_PINS 0x00005500u /* GPIO20..23 = EQEP1A, B, S, I, in MUX2 */

static bool config_is_good(const hal_config_t *config)
{
    return config != NULL && config->dead_band_count >= HAL_DEAD_BAND_MIN &&
           config->dead_band_count <= HAL_DEAD_BAND_MAX && qep_count_max_check(config->encoder_count_max) &&
           config->on_sample != NULL && config->on_trip != NULL;
}

static void start_time(void)
{
    bus_write16(&CPU_TIMER(1u)->TCR, TCR_TSS);
    bus_write32(&CPU_TIMER(0u)->PRD, UINT32_MAX);
    bus_write16(&CPU_TIMER(0u)->TPR, 0u);
    bus_write16(&CPU_TIMER(0u)->TPRH, 0u);
    bus_write16(&CPU_TIMER(0u)->TCR, TCR_TRB);
}

static void connect_pins(void)
{
    const volatile gpio_control_regs_t *port = GPIO_CONTROL(0u);

    bus_allow();
    /* The fault line first: asynchronous, so that it trips without a clock, and pulled up, its driver being
     * open. */
    bus_write32(&port->PUD, port->PUD & ~GPIO_PIN(PWM_FAULT_PIN));
    bus_write32(&port->QSEL1, port->QSEL1 | GPIO_FIELD(PWM_FAULT_PIN, GPIO_QSEL_ASYNC));
    bus_write32(&port->MUX1, port->MUX1 | GPIO_FIELD(PWM_FAULT_PIN, 1u));
    bus_write32(&port->MUX1, port->MUX1 | GATE_PINS);
    bus_write32(&port->MUX2, port->MUX2 | ENCODER_PINS);
    bus_protect();
    /* A pin follows its multiplexer two cycles later. */
    bus_wait(2u);
}

hal_status_t hal_init(const hal_config_t *config)
{
    hal_status_t status;

    if (!config_is_good(config)) {
        return HAL_BAD_CONFIG;
    }
    bus_interrupts_disable();
    watchdog_stop();
    start_time();
    status = clock_init();
    if (status != HAL_OK) {
        return status;
    }
    if (!pwm_init(config->dead_band_count)) {
        return HAL_TRIP_FAILED;
    }
    connect_pins();
    adc_init();
    qep_init(config->encoder_count_max);
    interrupts_init(config->on_sample, config->on_trip);

    bus_write32(LAST_ZERO, hal_time());
    qep_start();
    clock_start_carrier();
    bus_interrupts_enable();
    return HAL_OK;
}

void hal_read(hal_samples_t *samples)
{
    const uint32_t elapsed = pwm_elapsed();
    const uint32_t zero = hal_time() - elapsed;
    const uint32_t since_last = zero - *LAST_ZERO;
    uint16_t flags = 0u;

    /* One period since the last, give or take half of one. */
    if (elapsed >= LATEST || since_last - PWM_PERIOD / 2u >= PWM_PERIOD) {
        flags = HAL_FLAG_LATE;
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
    samples->current_a = ADC_MIRROR->ADCRESULT[ADC_CURRENT_A];
    samples->current_b = ADC_MIRROR->ADCRESULT[ADC_CURRENT_B];
    samples->dc_link = ADC_MIRROR->ADCRESULT[ADC_DC_LINK];
    samples->sink_temperature = ADC_MIRROR->ADCRESULT[ADC_SINK_TEMPERATURE];
    samples->motor_temperature = ADC_MIRROR->ADCRESULT[ADC_MOTOR_TEMPERATURE];
    samples->flags = flags;
    samples->encoder = EQEP(1u)->QPOSLAT;
}

void hal_end_of_sample(void)
{
    /* Too long: the conversion that began meanwhile is lost. Moving the last zero back by a period makes the
     * next sample late in any case. */
    if (hal_time() - *LAST_ZERO >= LATEST) {
        bus_write32(LAST_ZERO, *LAST_ZERO - PWM_PERIOD);
    }
    adc_rearm();
    interrupts_acknowledge(INTERRUPTS_SAMPLE);
}

uint32_t hal_time(void)
{
    return UINT32_MAX - CPU_TIMER(0u)->TIM;
}
