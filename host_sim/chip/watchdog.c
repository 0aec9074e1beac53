/* Watchdog: SPRUFB0 ch. 5. Counts crystal / 512 / prescale, 8 bits; overflow, a wrong WDCHK or a wrong key
 * reset the chip. A wrong key resets (SPRZ272); 0xAA without 0x55 before it does nothing. */
#include "host_sim/chip/parts.h"

#define COUNT_CYCLES  UINT64_C(512) /* of the crystal, one count at prescale 1 */
#define WATCHDOG_SPAN 256u
#define SCSR_WDINTS   (1u << 2)

static uint64_t count_cycles(const chip_t *chip)
{
    uint32_t prescale = chip->registers.sysctrl.WDCR & 7u;
    return COUNT_CYCLES << (prescale == 0u ? 0u : prescale - 1u);
}

/* It is stopped while a debugger halts the CPU, also within interrupts of the real-time mode. Actions of the
 * software after a flash operation take place when the operation has ended. */
static uint64_t own_time(const chip_t *chip)
{
    uint64_t now = chip->debug.halted ? chip->debug.since : chip->tick;
    return now > chip->flash.busy_until ? now : chip->flash.busy_until;
}

static void plan(chip_t *chip)
{
    bool counts = !chip->watchdog.off && !chip->debug.halted;
    chip->watchdog.next =
        counts ? chip->watchdog.start + crystal_ticks(chip, WATCHDOG_SPAN * count_cycles(chip)) : CHIP_NEVER;
    chip_schedule_rare(chip);
}

static void restart(chip_t *chip, uint64_t counted)
{
    chip->watchdog.start = own_time(chip) - crystal_ticks(chip, counted * count_cycles(chip));
    plan(chip);
}

void watchdog_halt(chip_t *chip)
{
    plan(chip);
}

void watchdog_go(chip_t *chip)
{
    chip->watchdog.start += chip->tick - chip->debug.since;
    plan(chip);
}

void watchdog_reset(chip_t *chip)
{
    chip->watchdog.off = 0u;
    chip->watchdog.key = 0u;
    restart(chip, 0u);
}

void watchdog_refresh(chip_t *chip)
{
    if (!chip->watchdog.off) {
        uint64_t crystal_cycles =
            (own_time(chip) - chip->watchdog.start) * chip->clock.crystal_cycles / chip->clock.crystal_ticks;
        chip->registers.sysctrl.WDCNTR = (uint16_t)(crystal_cycles / count_cycles(chip));
    }
}

static void bite(chip_t *chip, uint32_t address)
{
    chip_report(chip, CHIP_WATCHDOG_RESET, address);
    chip->cpu.resets++;
    chip->cpu.asked = 0u;
    chip->cpu.halted = 1u;
    chip_reset(chip, true);
    chip->registers.sysctrl.WDCR |= WDCR_WDFLAG;
}

void watchdog_overflow(chip_t *chip)
{
    if ((chip->registers.sysctrl.SCSR & SCSR_WDENINT) != 0u) {
        restart(chip, 0u);
        pie_request(chip, 1u, 1u << 7); /* WAKEINT */
        return;
    }
    bite(chip, SYSCTRL_AT + OFFSET(sysctrl_regs_t, WDCNTR));
}

bool watchdog_write(chip_t *chip, uint32_t address, uint16_t value)
{
    sysctrl_regs_t *sysctrl = &chip->registers.sysctrl;
    switch (address - SYSCTRL_AT) {
    case OFFSET(sysctrl_regs_t, WDCR): {
        if ((value & WDCR_WDCHK_ALL) != WDCR_WDCHK) {
            bite(chip, address);
            chip->cpu.asked = 1u;
            return true;
        }
        watchdog_refresh(chip);
        uint16_t flag = (uint16_t)(sysctrl->WDCR & WDCR_WDFLAG & ~value);
        if ((sysctrl->SCSR & SCSR_WDOVERRIDE) != 0u) {
            chip->watchdog.off = (value & WDCR_WDDIS) != 0u;
        }
        sysctrl->WDCR = (uint16_t)(flag | (chip->watchdog.off ? WDCR_WDDIS : 0u) | (value & 7u));
        restart(chip, sysctrl->WDCNTR);
        return true;
    }
    case OFFSET(sysctrl_regs_t, WDKEY):
        if (value != WDKEY_FIRST && value != WDKEY_SECOND) {
            bite(chip, address);
            return true;
        }
        if (value == WDKEY_SECOND && chip->watchdog.key) {
            sysctrl->WDCNTR = 0u;
            restart(chip, 0u);
        }
        chip->watchdog.key = value == WDKEY_FIRST;
        return true;
    case OFFSET(sysctrl_regs_t, SCSR): {
        uint16_t override = (uint16_t)(sysctrl->SCSR & SCSR_WDOVERRIDE & ~value);
        sysctrl->SCSR = (uint16_t)(override | (value & SCSR_WDENINT) | SCSR_WDINTS);
        return true;
    }
    case OFFSET(sysctrl_regs_t, WDCNTR):
        chip_report(chip, CHIP_READ_ONLY, address);
        return true;
    default:
        return false;
    }
}
