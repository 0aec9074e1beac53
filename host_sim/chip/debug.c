/* A debugger on the chip: halt, run, real-time mode, restart. Each part has its own function for a halt; all
 * of them are called here. The order matters only in one respect: all events that are due happen first. */
#include "host_sim/chip/parts.h"

static void tell_parts(chip_t *chip)
{
    bool affected = chip->debug.frozen != 0u; /* a counter other than the carrier is about to continue */
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        affected = affected || (timebase_stops(chip, m) && carrier_has(chip, m));
    }
    if (chip->carrier.active && affected) {
        carrier_leave(chip);
    }
    if (!chip->carrier.active) {
        for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
            timebase_debug(chip, m);
        }
        timebase_schedule(chip);
    }
    eqep_debug(chip);
    timer_debug(chip);
    cpu_update(chip);
}

void chip_debug_halt(chip_t *chip)
{
    if (chip->debug.halted) {
        return;
    }
    epwm_settle(chip);
    chip_refresh(chip);
    sci_refresh(chip);
    chip->debug.halted = 1u;
    chip->debug.since = chip->tick;
    chip->debug.cycle = cycle_now(chip);
    watchdog_halt(chip);
    adc_halt(chip);
    tell_parts(chip);
    epwm_refresh(chip);
    outputs_show(chip); /* if an average was left */
}

void chip_debug_run(chip_t *chip)
{
    if (!chip->debug.halted) {
        return;
    }
    epwm_settle(chip);
    chip_refresh(chip);
    sci_refresh(chip);
    chip->debug.halted = 0u;
    watchdog_go(chip);
    adc_go(chip);
    sci_go(chip);
    tell_parts(chip);
    epwm_refresh(chip);
    outputs_show(chip); /* if an average was left */
}

void chip_debug_realtime(chip_t *chip, bool on)
{
    chip->debug.realtime = on ? 1u : 0u;
    cpu_update(chip);
}

bool chip_debug_halted(const chip_t *chip)
{
    return chip->debug.halted != 0u;
}

bool chip_debug_can_look(const chip_t *chip)
{
    return chip->debug.halted != 0u || chip->cpu.dbgm == 0u;
}

void chip_restart(chip_t *chip)
{
    chip->cpu.interrupts_off = 1u;
    chip->cpu.dbgm = 1u;
    chip->cpu.allow = 0u;
    chip->cpu.halted = 0u;
    cpu_update(chip);
}
