/* ePWM event trigger: SPRUG04. Every n-th event makes an interrupt or a start of conversion. An interrupt
 * waits while its flag is set; a start of conversion ignores its flag. */
#include "host_sim/chip/parts.h"

#define ETPS_STORED  0x3303u
#define ETSEL_STORED 0xFF0Fu

static uint32_t selected(uint32_t select)
{
    static const uint32_t event[8] = {0u,
                                      1u << EVENT_ZERO,
                                      1u << EVENT_PERIOD,
                                      0u,
                                      1u << EVENT_CAU,
                                      1u << EVENT_CAD,
                                      1u << EVENT_CBU,
                                      1u << EVENT_CBD};
    return event[select & 7u];
}

static void set_count(epwm_regs_t *regs, uint32_t shift, uint32_t count)
{
    regs->ETPS = (uint16_t)((regs->ETPS & ~(3u << shift)) | count << shift);
}

static void interrupt(chip_t *chip, uint32_t m)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    uint32_t period = regs->ETPS & 3u;
    uint32_t count = (uint32_t)(regs->ETPS >> 2) & 3u;
    if (period != 0u && count == period && (regs->ETSEL & ETSEL_INTEN) != 0u &&
        (regs->ETFLG & ET_FLAG_INT) == 0u) {
        set_count(regs, 2u, 0u);
        regs->ETFLG |= ET_FLAG_INT;
        pie_request(chip, 3u, 1u << m);
    }
}

static void pulse(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t shift)
{
    chip->registers.epwm[m].ETFLG |= (uint16_t)(ET_FLAG_SOCA << shift);
    adc_trigger(chip, cycle, shift == 0u ? ADCTRL2_SOCA_SEQ1 : 1u << 15);
}

void trigger_soc(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t shift)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    uint32_t at = 8u + 4u * shift;
    uint32_t period = (uint32_t)(regs->ETPS >> at) & 3u;
    uint32_t count = (uint32_t)(regs->ETPS >> (at + 2u)) & 3u;
    if (period == 0u) {
        return;
    }
    count += count < period ? 1u : 0u;
    if (count == period && (regs->ETSEL & (ETSEL_SOCAEN << (4u * shift))) != 0u) {
        count = 0u;
        pulse(chip, m, cycle, shift);
    }
    set_count(regs, at + 2u, count);
}

void trigger_events(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t events)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    if ((events & selected(regs->ETSEL)) != 0u && (regs->ETPS & 3u) != 0u) {
        uint32_t count = (uint32_t)(regs->ETPS >> 2) & 3u;
        set_count(regs, 2u, count < (regs->ETPS & 3u) ? count + 1u : count);
        interrupt(chip, m);
    }
    if ((events & selected((uint32_t)regs->ETSEL >> 8)) != 0u) {
        trigger_soc(chip, m, cycle, 0u);
    }
    if ((events & selected((uint32_t)regs->ETSEL >> 12)) != 0u) {
        trigger_soc(chip, m, cycle, 1u);
    }
}

void trigger_write(chip_t *chip, uint32_t m, uint32_t offset, uint16_t value)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    switch (offset) {
    case OFFSET(epwm_regs_t, ETSEL):
        regs->ETSEL = value & ETSEL_STORED;
        interrupt(chip, m);
        break;
    case OFFSET(epwm_regs_t, ETPS): /* counters are read-only */
        regs->ETPS = (uint16_t)((regs->ETPS & ~ETPS_STORED) | (value & ETPS_STORED));
        break;
    case OFFSET(epwm_regs_t, ETCLR):
        regs->ETFLG &= (uint16_t)~value;
        interrupt(chip, m);
        break;
    default: /* ETFRC */
        if ((value & ET_FLAG_INT) != 0u && (regs->ETSEL & ETSEL_INTEN) != 0u &&
            (regs->ETFLG & ET_FLAG_INT) == 0u) {
            regs->ETFLG |= ET_FLAG_INT;
            pie_request(chip, 3u, 1u << m);
        }
        for (uint32_t shift = 0u; shift < 2u; shift++) {
            if ((value & (ET_FLAG_SOCA << shift)) != 0u &&
                (regs->ETSEL & (ETSEL_SOCAEN << (4u * shift))) != 0u) {
                pulse(chip, m, cycle_now(chip), shift);
            }
        }
        break;
    }
}
