/* The plain set-up of a drive, without walking through its counts.
 *
 * Plain: 150 MHz, ePWM1..3 in step, up-down without prescale, CMPA and CMPB loaded at zero, output A high
 * while CTR < CMPA (AQCTLA = clear on CAU, set on CAD), B unused, dead band fed by A with both delays. Then
 * the three counters are one, leg n falls at zero + CMPA and rises at zero + 2 TBPRD - CMPA, and only
 * dead-band delays, the start of conversion and the next zero are left as events. With CMPA = 0 the clear
 * comes at the zero after it was loaded, with CMPA >= TBPRD the set comes at the period match: exactly as
 * timebase.c does it, which the tests hold against this.
 *
 * If nobody looks at the edges (averaged mode, or all pins tripped) the legs stay as they were at zero until
 * the next zero, or until somebody looks (carrier_see). */
#include "host_sim/chip/parts.h"

#define PLAIN_CMPCTL_MASK (0x000Fu | CMPCTL_SHDWAMODE | CMPCTL_SHDWBMODE)
#define PLAIN_AQCTLA      (AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET))
#define DBCTL_IN_AND_OUT  0x0033u
#define ALL_PINS          0x3Fu
#define ETPS_INT          0x0003u
#define ETPS_SOCA         0x0300u
#define ETPS_SOCB         0x3000u

static void set_a(chip_epwm_t *epwm, const epwm_regs_t *regs, uint64_t cycle, uint32_t level)
{
    if (epwm->a != level) {
        epwm->a = level;
        deadband_rising_path(epwm, cycle, level, regs->DBRED);
        deadband_falling_path(epwm, cycle, level, regs->DBFED);
    }
}

static void plan_leg(chip_epwm_t *epwm)
{
    epwm->next = earlier(earlier(epwm->fall, epwm->rise), earlier(epwm->red_due, epwm->fed_due));
}

/* outputs_raw with both delays on. */
static void raw_leg(chip_t *chip, uint32_t m)
{
    const chip_epwm_t *epwm = &chip->epwm[m];
    uint32_t polarity = (uint32_t)chip->registers.epwm[m].DBCTL >> 2;
    uint32_t pins = (epwm->red | epwm->fed << 1) ^ (polarity & 3u);
    chip->pins.raw = (chip->pins.raw & ~(3u << (2u * m))) | pins << (2u * m);
}

static void step_leg(chip_t *chip, uint32_t m, uint64_t cycle)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    deadband_due(epwm, cycle);
    if (epwm->fall <= cycle) {
        epwm->fall = CHIP_NEVER;
        set_a(epwm, regs, cycle, 0u);
    }
    if (epwm->rise <= cycle) {
        epwm->rise = CHIP_NEVER;
        set_a(epwm, regs, cycle, 1u);
    }
    plan_leg(epwm);
    raw_leg(chip, m);
}

static void start_leg(chip_epwm_t *epwm, uint64_t zero, uint32_t half)
{
    epwm->fall = CHIP_NEVER;
    epwm->rise = CHIP_NEVER;
    if (epwm->cmpa >= half) {
        epwm->rise = zero + half;
    } else if (epwm->cmpa != 0u) {
        epwm->fall = zero + epwm->cmpa;
        epwm->rise = zero + 2u * half - epwm->cmpa;
    }
    plan_leg(epwm);
}

/* A whole period of a leg at once. A leg that falls and rises ends up high whatever it was before; the rare
 * others walk. */
static void pass_leg(chip_t *chip, uint32_t m, uint64_t end)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    if (epwm->cmpa == 0u || epwm->cmpa >= chip->carrier.half) {
        while (epwm->next <= end) {
            step_leg(chip, m, epwm->next);
        }
        return;
    }
    uint64_t due = epwm->rise + chip->registers.epwm[m].DBRED;
    epwm->a = 1u;
    epwm->red_in = 1u;
    epwm->fed_in = 1u;
    epwm->fed = 1u;
    epwm->fed_due = CHIP_NEVER;
    epwm->red = due <= end;
    epwm->red_due = epwm->red ? CHIP_NEVER : due;
    epwm->fall = CHIP_NEVER;
    epwm->rise = CHIP_NEVER;
}

/* Ticks that output A is high in this period. */
static uint32_t high_time(const chip_epwm_t *epwm, uint32_t half)
{
    if (epwm->cmpa >= half) {
        return epwm->a ? 2u * half : half;
    }
    if (epwm->cmpa == 0u) {
        return epwm->a ? 2u * half : 0u;
    }
    return epwm->a ? 2u * epwm->cmpa : epwm->cmpa;
}

static bool complementary(const chip_t *chip)
{
    const epwm_regs_t *regs = chip->registers.epwm;
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        if ((regs[m].DBCTL & (3u << 2)) != DBCTL_POLSEL_AHC || regs[m].DBRED != regs[0].DBRED ||
            regs[m].DBFED != regs[0].DBRED) {
            return false;
        }
    }
    return true;
}

static void plan(chip_t *chip)
{
    const chip_carrier_t *carrier = &chip->carrier;
    uint64_t next = earlier(carrier->soc, carrier->end);
    if (!carrier->lazy) {
        next = earlier(next, chip->epwm[0].next);
        next = earlier(next, chip->epwm[1].next);
        next = earlier(next, chip->epwm[2].next);
    }
    chip->epwm_next = next;
    chip->next[SOURCE_EPWM] = tick_of(chip, next);
}

static uint64_t soc_cycle(const chip_t *chip)
{
    const chip_carrier_t *carrier = &chip->carrier;
    uint32_t cmpb = chip->epwm[0].cmpb;
    if (carrier->soc_event == ET_PERIOD || (carrier->soc_event == ET_CMPB_DOWN && cmpb >= carrier->half)) {
        return carrier->zero + carrier->half;
    }
    if (carrier->soc_event == ET_CMPB_DOWN && cmpb != 0u) {
        return carrier->end - cmpb;
    }
    return CHIP_NEVER;
}

/* Legs, compare values and triggers are as after the events of this zero. */
static void begin(chip_t *chip, uint64_t zero)
{
    chip_carrier_t *carrier = &chip->carrier;
    const chip_pins_t *pins = &chip->pins;
    carrier->zero = zero;
    carrier->end = zero + 2u * carrier->half;
    carrier->soc = soc_cycle(chip);
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        start_leg(&chip->epwm[m], zero, carrier->half);
    }
    bool blind = ((pins->forced | pins->floating | ~pins->muxed) & ALL_PINS) == ALL_PINS;
    bool average = chip->averaged && carrier->average && pins->muxed == ALL_PINS &&
                   (pins->forced | pins->floating) == 0u;
    carrier->told = average;
    carrier->lazy = blind || average;
    plan(chip);
    if (!average) {
        outputs_show(chip);
        return;
    }
    uint32_t high[CHIP_LEGS];
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        high[m] = high_time(&chip->epwm[m], carrier->half);
    }
    chip->pins.hidden = 1u;
    if (chip == chip_bound) {
        chip_world->carrier(chip_world->context, chip->tick, 2u * carrier->half, high,
                            chip->registers.epwm[0].DBRED);
    }
}

static void zero_event(chip_t *chip)
{
    chip_carrier_t *carrier = &chip->carrier;
    uint64_t zero = carrier->end;
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        chip_epwm_t *epwm = &chip->epwm[m];
        const epwm_regs_t *regs = &chip->registers.epwm[m];
        if (carrier->lazy) {
            pass_leg(chip, m, zero);
        } else if (epwm->next <= zero) {
            step_leg(chip, m, zero);
        }
        if (epwm->cmpa == 0u) {
            set_a(epwm, regs, zero, 0u);
        }
        epwm->cmpa = regs->CMPA;
        epwm->cmpb = regs->CMPB;
        if (epwm->cbc) {
            trip_zero(chip, m);
        }
        raw_leg(chip, m);
    }
    if (carrier->soc_event == ET_ZERO) {
        trigger_soc(chip, 0u, zero, 0u);
    }
    chip->carrier_tick = chip->tick;
    begin(chip, zero);
}

static void one_event(chip_t *chip)
{
    chip_carrier_t *carrier = &chip->carrier;
    uint64_t cycle = chip->epwm_next;
    if (carrier->soc <= cycle) {
        carrier->soc = CHIP_NEVER;
        trigger_soc(chip, 0u, cycle, 0u);
    }
    if (carrier->end <= cycle) {
        zero_event(chip);
        return;
    }
    if (carrier->lazy) {
        plan(chip);
        return;
    }
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        if (chip->epwm[m].next <= cycle) {
            step_leg(chip, m, cycle);
        }
    }
    plan(chip);
    outputs_show(chip);
}

void carrier_event(chip_t *chip)
{
    one_event(chip);
    while (chip->next[SOURCE_EPWM] < chip->limit) {
        chip->tick = chip->next[SOURCE_EPWM];
        one_event(chip);
    }
}

void carrier_see(chip_t *chip)
{
    if (!chip->carrier.lazy) {
        return;
    }
    uint64_t now = cycle_now(chip);
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        while (chip->epwm[m].next <= now) {
            step_leg(chip, m, chip->epwm[m].next);
        }
        raw_leg(chip, m);
    }
    chip->carrier.lazy = 0u;
    plan(chip);
    chip_plan(chip, SOURCE_EPWM, chip->next[SOURCE_EPWM]); /* whoever runs ahead must stop before the edges */
}

/* One leg's settings; the counter has just passed zero at `cycle`. */
static bool plain_leg(const chip_t *chip, uint32_t m, uint64_t cycle)
{
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    const chip_epwm_t *epwm = &chip->epwm[m];
    bool follows = (regs->TBCTL & TBCTL_PHSEN) != 0u;
    bool in_step = !follows || (m != 0u && regs->TBPHS == 2u && (regs->TBCTL & TBCTL_PHSDIR_UP) != 0u);
    return epwm->running && epwm->anchor == cycle && epwm->count == 0u && epwm->divider == 1u &&
           epwm->period == chip->epwm[0].period && epwm->period >= 2u && epwm->force == 0u && in_step &&
           (regs->TBCTL & 3u) == TBCTL_UPDOWN && (regs->TBCTL & TBCTL_PRDLD) == 0u &&
           ((regs->TBCTL >> 4) & 3u) != 2u && (regs->CMPCTL & PLAIN_CMPCTL_MASK) == 0u &&
           regs->AQCTLA == PLAIN_AQCTLA && regs->AQCTLB == 0u && regs->AQCSFRC == 0u &&
           (regs->DBCTL & DBCTL_IN_AND_OUT) == DBCTL_OUT_BOTH &&
           (regs->ETPS & (ETPS_INT | ETPS_SOCB)) == 0u && (m == 0u || (regs->ETPS & ETPS_SOCA) == 0u);
}

void carrier_try(chip_t *chip, uint64_t cycle)
{
    chip_carrier_t *carrier = &chip->carrier;
    const epwm_regs_t *regs = &chip->registers.epwm[0];
    uint32_t soc_event = (regs->ETPS & ETPS_SOCA) == 0u ? 0u : (uint32_t)(regs->ETSEL >> 8) & 7u;
    if (chip->clock.ticks != 1u || chip->clock.cycles != 1u ||
        (soc_event != 0u && soc_event != ET_ZERO && soc_event != ET_PERIOD && soc_event != ET_CMPB_DOWN)) {
        return;
    }
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        if (!plain_leg(chip, m, cycle) || chip->epwm[CHIP_LEGS + m].next != CHIP_NEVER) {
            return;
        }
    }
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        chip->epwm[m].sync_due = CHIP_NEVER; /* would load what the counter holds anyway */
        chip->epwm[m].count_next = CHIP_NEVER;
    }
    carrier->active = 1u;
    carrier->half = chip->epwm[0].period;
    carrier->soc_event = soc_event;
    carrier->average = complementary(chip);
    begin(chip, cycle);
}

void carrier_leave(chip_t *chip)
{
    chip_carrier_t *carrier = &chip->carrier;
    carrier_see(chip);
    carrier->active = 0u;
    uint64_t now = cycle_now(chip);
    bool falling = now >= carrier->zero + carrier->half;
    for (uint32_t m = 0u; m < CHIP_LEGS; m++) {
        chip_epwm_t *epwm = &chip->epwm[m];
        epwm->anchor = falling ? carrier->zero + carrier->half : carrier->zero;
        epwm->count = falling ? carrier->half : 0u;
        epwm->up = falling ? 0u : 1u;
        epwm->fall = CHIP_NEVER;
        epwm->rise = CHIP_NEVER;
        epwm->count_next = CHIP_NEVER;
        timebase_hold(chip, m);
        timebase_plan(chip, m);
    }
    timebase_schedule(chip);
}
