/* ePWM1..6, register side: SPRUG04. Counters are in timebase.c, pins in outputs.c, triggers in trigger.c. */
#include "host_sim/chip/parts.h"

#define TBCTL_RESET    0x0083u
#define TBSTS_CTRMAX   (1u << 2)
#define CMPCTL_STORED  0x005Fu
#define AQCTL_STORED   0x0FFFu
#define AQSFRC_STORED  0x00DBu
#define AQSFRC_RLDCSF  0x00C0u
#define AQCSFRC_STORED 0x000Fu
#define DBCTL_STORED   0x003Fu

void epwm_reset(chip_t *chip)
{
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        chip_epwm_t *epwm = &chip->epwm[m];
        *epwm = (chip_epwm_t){.anchor = cycle_now(chip), .up = 1u, .divider = timebase_divider(TBCTL_RESET)};
        epwm->count_next = CHIP_NEVER;
        epwm->sync_due = CHIP_NEVER;
        epwm->red_due = CHIP_NEVER;
        epwm->fed_due = CHIP_NEVER;
        epwm->cau = CHIP_NEVER;
        epwm->cad = CHIP_NEVER;
        epwm->next = CHIP_NEVER;
        chip->debug.stop[m] = CHIP_NEVER;
        chip->registers.epwm[m].TBCTL = TBCTL_RESET;
    }
    chip->carrier.active = 0u;
    chip->carrier.lazy = 0u;
    chip->debug.frozen = 0u;
    chip->debug.ending = 0u;
    chip->pins.raw = 0u;
    timebase_schedule(chip);
    outputs_changed(chip);
}

static void write_tbctl(chip_t *chip, uint32_t m, uint16_t value)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    chip_epwm_t *epwm = &chip->epwm[m];
    bool stood = (regs->TBCTL & 3u) == 3u;
    timebase_hold(chip, m);
    regs->TBCTL = (uint16_t)(value & ~TBCTL_SWFSYNC);
    epwm->divider = timebase_divider(value);
    switch (value & 3u) {
    case 0u:
        epwm->up = 1u;
        break;
    case 1u:
        epwm->up = 0u;
        break;
    case 2u:
        epwm->up = epwm->count == 0u || (epwm->up && epwm->count != epwm->period);
        break;
    default:
        break;
    }
    timebase_plan(chip, m);
    if (stood && (value & 3u) != 3u && epwm->count == 0u) {
        timebase_start(chip, m);
    }
    if ((value & TBCTL_SWFSYNC) != 0u) {
        timebase_sync(chip, m, cycle_now(chip));
    }
    timebase_debug(chip, m);
}

static void write_count(chip_t *chip, uint32_t m, uint16_t value)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    timebase_hold(chip, m);
    epwm->count = value;
    if ((chip->registers.epwm[m].TBCTL & 3u) == TBCTL_UPDOWN) {
        epwm->up = value == 0u || (epwm->up && value != epwm->period);
    }
    timebase_plan(chip, m);
    if (value == 0u) {
        timebase_start(chip, m);
    }
}

static void write_period(chip_t *chip, uint32_t m, uint16_t value)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    chip_epwm_t *epwm = &chip->epwm[m];
    bool immediate = (regs->TBCTL & TBCTL_PRDLD) != 0u;
    regs->TBPRD = value;
    timebase_hold(chip, m);
    if (immediate) {
        epwm->period = value;
        timebase_plan(chip, m);
    }
    if (epwm->count == 0u && (immediate || epwm->period == 0u)) {
        timebase_start(chip, m); /* a counter that was constant at zero because its period was zero */
    }
}

static void load_immediately(chip_t *chip, uint32_t m)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    timebase_hold(chip, m);
    if ((regs->CMPCTL & CMPCTL_SHDWAMODE) != 0u) {
        chip->epwm[m].cmpa = regs->CMPA;
    }
    if ((regs->CMPCTL & CMPCTL_SHDWBMODE) != 0u) {
        chip->epwm[m].cmpb = regs->CMPB;
    }
    timebase_plan(chip, m);
}

/* Registers whose writing may change what the counters or outputs do; the plain carrier has been left. */
static void write_setting(chip_t *chip, uint32_t m, uint32_t address, uint16_t value)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    uint64_t now = cycle_now(chip);
    switch ((address - EPWM_AT) % 0x40u) {
    case OFFSET(epwm_regs_t, TBCTL):
        write_tbctl(chip, m, value);
        break;
    case OFFSET(epwm_regs_t, TBPHS):
        regs->TBPHS = value;
        break;
    case OFFSET(epwm_regs_t, TBCTR):
        write_count(chip, m, value);
        break;
    case OFFSET(epwm_regs_t, TBPRD):
        write_period(chip, m, value);
        break;
    case OFFSET(epwm_regs_t, CMPCTL):
        regs->CMPCTL = value & CMPCTL_STORED;
        load_immediately(chip, m);
        break;
    case OFFSET(epwm_regs_t, CMPA):
        regs->CMPA = value;
        load_immediately(chip, m);
        break;
    case OFFSET(epwm_regs_t, CMPB):
        regs->CMPB = value;
        load_immediately(chip, m);
        break;
    case OFFSET(epwm_regs_t, AQCTLA):
        regs->AQCTLA = value & AQCTL_STORED;
        break;
    case OFFSET(epwm_regs_t, AQCTLB):
        regs->AQCTLB = value & AQCTL_STORED;
        break;
    case OFFSET(epwm_regs_t, AQSFRC):
        regs->AQSFRC = value & AQSFRC_STORED;
        outputs_once(chip, m, now, value);
        break;
    case OFFSET(epwm_regs_t, AQCSFRC):
        regs->AQCSFRC = value & AQCSFRC_STORED;
        if ((regs->AQSFRC & AQSFRC_RLDCSF) == AQSFRC_RLDCSF) {
            outputs_force(chip, m, now);
        }
        break;
    case OFFSET(epwm_regs_t, DBCTL):
        regs->DBCTL = value & DBCTL_STORED;
        outputs_inputs(chip, m, now);
        break;
    case OFFSET(epwm_regs_t, DBRED):
        regs->DBRED = value & DB_MAX;
        break;
    case OFFSET(epwm_regs_t, DBFED):
        regs->DBFED = value & DB_MAX;
        break;
    default:
        trigger_write(chip, m, (address - EPWM_AT) % 0x40u, value);
        break;
    }
    timebase_plan(chip, m);
    timebase_schedule(chip);
    outputs_raw(chip, m);
    outputs_show(chip);
}

static bool protected_register(uint32_t offset)
{
    return offset == OFFSET(epwm_regs_t, TZSEL) || offset == OFFSET(epwm_regs_t, TZCTL) ||
           offset == OFFSET(epwm_regs_t, TZEINT) || offset == OFFSET(epwm_regs_t, TZCLR) ||
           offset == OFFSET(epwm_regs_t, TZFRC) || offset == OFFSET(epwm_regs_t, HRCNFG);
}

void epwm_write(chip_t *chip, uint32_t address, uint16_t value)
{
    uint32_t m = (address - EPWM_AT) / 0x40u;
    uint32_t offset = (address - EPWM_AT) % 0x40u;
    epwm_regs_t *regs = &chip->registers.epwm[m];
    if (protected_register(offset) && !chip->cpu.allow) {
        chip_report(chip, CHIP_PROTECTED_WRITE, address);
        return;
    }
    if ((chip->registers.sysctrl.PCLKCR1 & (PCLKCR1_EPWM1 << m)) == 0u) {
        chip_report(chip, CHIP_CLOCK_OFF, address);
        return;
    }
    epwm_settle(chip);
    switch (offset) {
    case OFFSET(epwm_regs_t, CMPA):
    case OFFSET(epwm_regs_t, CMPB):
        if (carrier_has(chip, m)) { /* shadow registers, loaded at the next zero */
            if (offset == OFFSET(epwm_regs_t, CMPA)) {
                regs->CMPA = value;
            } else {
                regs->CMPB = value;
            }
            return;
        }
        break;
    case OFFSET(epwm_regs_t, TZSEL):
    case OFFSET(epwm_regs_t, TZCTL):
    case OFFSET(epwm_regs_t, TZEINT):
    case OFFSET(epwm_regs_t, TZCLR):
    case OFFSET(epwm_regs_t, TZFRC):
        trip_write(chip, m, offset, value);
        return;
    case OFFSET(epwm_regs_t, ETCLR):
        trigger_write(chip, m, offset, value);
        return;
    case OFFSET(epwm_regs_t, TBSTS):
        if ((value & TBSTS_CTRMAX) != 0u) {
            chip->epwm[m].overflow = 0u;
        }
        epwm_refresh(chip);
        return;
    case OFFSET(epwm_regs_t, TZFLG):
    case OFFSET(epwm_regs_t, ETFLG):
        chip_report(chip, CHIP_READ_ONLY, address);
        return;
    case OFFSET(epwm_regs_t, TBPHSHR):
    case OFFSET(epwm_regs_t, CMPAHR):
    case OFFSET(epwm_regs_t, PCCTL):
    case OFFSET(epwm_regs_t, HRCNFG):
        if (value != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        }
        return;
    default:
        if (offset > OFFSET(epwm_regs_t, PCCTL) || offset == 6u || offset == 0x13u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
            return;
        }
        break;
    }
    if (chip->carrier.active) {
        carrier_leave(chip);
    }
    write_setting(chip, m, address, value);
    epwm_refresh(chip);
}
