/* CPU timers 0..2: SPRUFB0 ch. 3. TIM counts down once every TDDR + 1 cycles; from 0 it goes to PRD, which is
 * the moment of the interrupt, so the period is (PRD + 1)(TDDR + 1). A running timer needs no simulation:
 * its state follows from the cycle of the next reload.
 *
 * A debugger's halt lets a timer with FREE run on; with SOFT alone it goes to its next reload, which still
 * interrupts, and stops; else it stops at once. */
#include "host_sim/chip/parts.h"

#define PCLKCR3_TIMER0 (1u << 8)
#define TCR_STORED     (TCR_TSS | TCR_TIE | TCR_SOFT | TCR_FREE)

static bool clocked(const chip_t *chip, uint32_t n)
{
    return (chip->registers.sysctrl.PCLKCR3 & (PCLKCR3_TIMER0 << n)) != 0u;
}

static uint64_t period(const chip_t *chip, uint32_t n)
{
    return ((uint64_t)chip->registers.cpu_timer[n].PRD + 1u) * chip->timer[n].step;
}

/* Cycles to the reload. */
static uint64_t left(const chip_t *chip, uint32_t n)
{
    const chip_timer_t *timer = &chip->timer[n];
    return timer->running ? timer->reload - cycle_now(chip) : timer->left;
}

static void set_left(chip_t *chip, uint32_t n, uint64_t cycles)
{
    chip->timer[n].left = cycles;
    chip->timer[n].reload = cycle_now(chip) + cycles;
}

static void interrupt(chip_t *chip, uint32_t n)
{
    if (n == 0u) {
        pie_request(chip, 1u, 1u << 6); /* TINT0 */
    } else {
        cpu_request(chip, 12u + n);
    }
}

static bool stands(const chip_t *chip, uint32_t n)
{
    return (chip->debug.timers >> n & 1u) != 0u;
}

/* Stops at its next reload. */
static bool ends(const chip_t *chip, uint32_t n)
{
    return chip->debug.halted && (chip->registers.cpu_timer[n].TCR & (TCR_FREE | TCR_SOFT)) == TCR_SOFT;
}

/* Reloads that have passed. */
static void catch_up(chip_t *chip, uint32_t n)
{
    chip_timer_t *timer = &chip->timer[n];
    cpu_timer_regs_t *regs = &chip->registers.cpu_timer[n];
    uint64_t now = cycle_now(chip);
    if (!timer->running || timer->reload > now) {
        return;
    }
    uint64_t turns = (now - timer->reload) / period(chip, n) + 1u;
    timer->reload += turns * period(chip, n);
    if (ends(chip, n)) {
        timer->running = 0u;
        timer->left = period(chip, n);
        regs->TIM = regs->PRD;
        chip->debug.timers |= 1u << n;
    }
    regs->TCR |= TCR_TIF;
    if ((regs->TCR & TCR_TIE) != 0u) {
        interrupt(chip, n);
    }
}

static void refresh_one(chip_t *chip, uint32_t n)
{
    cpu_timer_regs_t *regs = &chip->registers.cpu_timer[n];
    catch_up(chip, n);
    uint64_t counts = left(chip, n) - 1u;
    uint32_t step = chip->timer[n].step;
    if (step == 1u) {
        regs->TIM = (uint32_t)counts;
        return;
    }
    regs->TIM = (uint32_t)(counts / step);
    uint32_t prescale = (uint32_t)(counts % step);
    regs->TPR = (uint16_t)((regs->TPR & 0x00FFu) | (prescale & 0x00FFu) << 8);
    regs->TPRH = (uint16_t)((regs->TPRH & 0x00FFu) | (prescale & 0xFF00u));
}

void timer_refresh(chip_t *chip)
{
    uint64_t now = cycle_now(chip);
    for (uint32_t n = 0u; n < 3u; n++) {
        const chip_timer_t *timer = &chip->timer[n];
        if (!timer->running) {
            continue; /* keeps the value that it had when it stopped */
        }
        if (timer->step == 1u && timer->reload > now) {
            chip->registers.cpu_timer[n].TIM = (uint32_t)(timer->reload - now) - 1u;
        } else {
            refresh_one(chip, n);
        }
    }
}

/* Only timers that interrupt or are about to stop are events. */
void timer_schedule(chip_t *chip)
{
    chip->timer_next = CHIP_NEVER;
    for (uint32_t n = 0u; n < 3u; n++) {
        bool event = (chip->registers.cpu_timer[n].TCR & TCR_TIE) != 0u || ends(chip, n);
        if (chip->timer[n].running && event) {
            chip->timer_next = earlier(chip->timer_next, tick_of(chip, chip->timer[n].reload));
        }
    }
    chip_schedule_rare(chip);
}

void timer_events(chip_t *chip)
{
    for (uint32_t n = 0u; n < 3u; n++) {
        catch_up(chip, n);
    }
    timer_schedule(chip);
}

static void run_or_stop(chip_t *chip, uint32_t n)
{
    chip_timer_t *timer = &chip->timer[n];
    uint64_t cycles = left(chip, n);
    timer->running =
        clocked(chip, n) && !stands(chip, n) && (chip->registers.cpu_timer[n].TCR & TCR_TSS) == 0u;
    set_left(chip, n, cycles);
}

void timer_clock(chip_t *chip)
{
    for (uint32_t n = 0u; n < 3u; n++) {
        refresh_one(chip, n);
        run_or_stop(chip, n);
    }
    timer_schedule(chip);
}

void timer_debug(chip_t *chip)
{
    for (uint32_t n = 0u; n < 3u; n++) {
        bool at_once = (chip->registers.cpu_timer[n].TCR & (TCR_FREE | TCR_SOFT)) == 0u;
        chip->debug.timers &= ~(1u << n);
        chip->debug.timers |= chip->debug.halted && at_once ? 1u << n : 0u;
        run_or_stop(chip, n);
    }
    timer_schedule(chip);
}

void timer_reset(chip_t *chip)
{
    for (uint32_t n = 0u; n < 3u; n++) {
        chip->registers.cpu_timer[n].PRD = 0xFFFFu;
        chip->registers.cpu_timer[n].TIM = 0xFFFFu;
        chip->timer[n].step = 1u;
        chip->timer[n].running = 1u;
        set_left(chip, n, 0x10000u);
    }
    timer_schedule(chip);
}

/* A new prescale acts from the next count on. */
static void change_step(chip_t *chip, uint32_t n)
{
    const cpu_timer_regs_t *regs = &chip->registers.cpu_timer[n];
    chip_timer_t *timer = &chip->timer[n];
    uint64_t rest = left(chip, n) - 1u;
    uint64_t counts = rest / timer->step;
    uint64_t phase = rest % timer->step;
    timer->step = (regs->TPR & 0x00FFu) + ((regs->TPRH & 0x00FFu) << 8) + 1u;
    set_left(chip, n, counts * timer->step + phase + 1u);
}

/* Common to both widths; false: the write has no effect. */
static bool accessible(chip_t *chip, uint32_t n, uint32_t address)
{
    if (!clocked(chip, n)) {
        chip_report(chip, CHIP_CLOCK_OFF, address);
        return false;
    }
    refresh_one(chip, n);
    return true;
}

void timer_write16(chip_t *chip, uint32_t address, uint16_t value)
{
    uint32_t n = (address - TIMER_AT) / 8u;
    uint32_t offset = (address - TIMER_AT) % 8u;
    cpu_timer_regs_t *regs = &chip->registers.cpu_timer[n];
    if (offset < OFFSET(cpu_timer_regs_t, TCR)) {
        chip_report(chip, CHIP_BAD_WIDTH, address);
        return;
    }
    if (!accessible(chip, n, address)) {
        return;
    }
    switch (offset) {
    case OFFSET(cpu_timer_regs_t, TCR):
        regs->TCR = (uint16_t)((regs->TCR & TCR_TIF & ~value) | (value & TCR_STORED));
        run_or_stop(chip, n);
        if ((value & TCR_TRB) != 0u) {
            set_left(chip, n, period(chip, n));
        }
        break;
    case OFFSET(cpu_timer_regs_t, TPR):
        regs->TPR = (uint16_t)((regs->TPR & 0xFF00u) | (value & 0x00FFu));
        change_step(chip, n);
        break;
    case OFFSET(cpu_timer_regs_t, TPRH):
        regs->TPRH = (uint16_t)((regs->TPRH & 0xFF00u) | (value & 0x00FFu));
        change_step(chip, n);
        break;
    default:
        chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        return;
    }
    refresh_one(chip, n);
    timer_schedule(chip);
}

void timer_write32(chip_t *chip, uint32_t address, uint32_t value)
{
    uint32_t n = (address - TIMER_AT) / 8u;
    switch ((address - TIMER_AT) % 8u) {
    case OFFSET(cpu_timer_regs_t, TIM):
        if (accessible(chip, n, address)) {
            set_left(chip, n, ((uint64_t)value + 1u) * chip->timer[n].step);
        }
        break;
    case OFFSET(cpu_timer_regs_t, PRD):
        if (!clocked(chip, n)) {
            chip_report(chip, CHIP_CLOCK_OFF, address);
        } else if (chip->timer[n].running) {
            refresh_one(chip, n);
            chip->registers.cpu_timer[n].PRD = value;
            timer_schedule(chip);
        } else {
            chip->registers.cpu_timer[n].PRD = value; /* acts with the next reload */
        }
        return;
    default:
        chip_report(chip, CHIP_BAD_WIDTH, address);
        return;
    }
    refresh_one(chip, n);
    timer_schedule(chip);
}
