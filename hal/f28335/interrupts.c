#include "hal/f28335/interrupts.h"

#include "hal/f28335/bus.h"
#include "hal/f28335/pwm.h"

#define GROUPS     12u
#define VECTORS    128u
#define SAMPLE_ROW 1u                                    /* INT1.1 in PIEIER1 */
#define SERIAL_ROW 1u                                    /* INT9.1 in PIEIER9 */
#define TRIP_ROW   ((uint16_t)(1u << (PWM_LEADER - 1u))) /* INT2.n in PIEIER2, of ePWMn */

static HAL_INTERRUPT void unexpected(void)
{
    hal_gates_off();
    hal_outputs(false, false);
}

static uint16_t group_bit(uint16_t group)
{
    return (uint16_t)(1u << (group - 1u));
}

void interrupts_init(const hal_config_t *config)
{
    uint16_t n;

    /* After a restart without a reset, the enable and request bits of the previous program may still be set.
     */
    bus_write16(&PIE->PIECTRL, 0u);
    bus_disable_groups();
    bus_write16(&CPU_TIMER(2u)->TCR, TCR_TSS); /* the medium task uses its interrupt */
    bus_clear_pending();
    for (n = 0u; n < GROUPS; n++) {
        bus_write16(&PIE->group[n].IER, 0u);
        bus_write16(&PIE->group[n].IFR, 0u);
    }
    bus_allow();
    /* Vector 0 belongs to the reset, which always starts the boot ROM. */
    for (n = 1u; n < VECTORS; n++) {
        bus_write32(&PIE_VECTORS->vector[n], bus_vector(unexpected));
    }
    bus_write32(&PIE_VECTORS->vector[PIE_SEQ1INT], bus_vector(config->on_sample));
    bus_write32(&PIE_VECTORS->vector[PIE_EPWM_TZ(PWM_LEADER)], bus_vector(config->on_trip));
    bus_write32(&PIE_VECTORS->vector[INTERRUPTS_MEDIUM], bus_vector(config->on_medium));
    if (config->on_serial != NULL) {
        bus_write32(&PIE_VECTORS->vector[PIE_SCIRXINTA], bus_vector(config->on_serial));
    }
    bus_protect();
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    bus_write16(&PIE->group[INTERRUPTS_SAMPLE - 1u].IER, SAMPLE_ROW);
    bus_write16(&PIE->group[INTERRUPTS_TRIP - 1u].IER, TRIP_ROW);
    bus_write16(&PIE->PIEACK, (uint16_t)(group_bit(INTERRUPTS_SAMPLE) | group_bit(INTERRUPTS_TRIP) |
                                         group_bit(INTERRUPTS_SERIAL)));
    if (config->on_serial != NULL) {
        bus_write16(&PIE->group[INTERRUPTS_SERIAL - 1u].IER, SERIAL_ROW);
        bus_enable_group(INTERRUPTS_SERIAL);
    }
    bus_enable_group(INTERRUPTS_SAMPLE);
    bus_enable_group(INTERRUPTS_TRIP);
    bus_enable_group(INTERRUPTS_MEDIUM);
    /* In real-time mode a debugger may halt the background while the interrupts of the drive continue, as
     * long as the carrier runs (pwm.c). It may also read memory while the program runs. */
    bus_debug_groups(
        (uint16_t)(group_bit(INTERRUPTS_SAMPLE) | group_bit(INTERRUPTS_TRIP) | group_bit(INTERRUPTS_MEDIUM)));
    bus_debug_allow();
}

void interrupts_acknowledge(uint16_t group)
{
    bus_write16(&PIE->PIEACK, group_bit(group));
    /* The write must have reached the register before the return from the interrupt enables interrupts
     * (SPRZ272: spurious interrupt). Reading the register ensures this. */
    (void)PIE->PIEACK;
}

void hal_end_of_trip(void)
{
    interrupts_acknowledge(INTERRUPTS_TRIP);
}

void hal_end_of_serial(void)
{
    interrupts_acknowledge(INTERRUPTS_SERIAL);
}

void hal_request_medium(void)
{
    bus_request_group(INTERRUPTS_MEDIUM);
}

/* The interrupts of sample, trip and serial line are still enabled: the CPU has cleared only the bit of INT14
 * in IER, which the return from the interrupt restores. */
void hal_begin_medium(void)
{
    bus_debug_allow();
    bus_interrupts_enable();
}

/* INTM must be set before the registers are restored from the stack (SPRZ272: nested interrupts). */
void hal_end_medium(void)
{
    bus_interrupts_disable();
}

void hal_interrupts_off(void)
{
    bus_interrupts_disable();
}

void hal_interrupts_on(void)
{
    bus_interrupts_enable();
}
