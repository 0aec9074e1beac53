/* A fast engine for the usual set-up of a drive, which needs no step for each count.
 *
 * Plain: SYSCLK at most 150 MHz, the three legs' modules (ePWM1..3, or ePWM4..6 if only these have pins) in
 * step, up-down without prescale, CMPA and CMPB loaded at zero, output A switched by CMPA alone and the same
 * way on all legs, B unused, dead band fed by A with both delays. AQCTLA is one of two:
 *     clear on CAU, set on CAD: A is high while CTR < CMPA, its pulse is centred on counter zero
 *     set on CAU, clear on CAD: A is high while CTR >= CMPA, its pulse is centred on the period match
 * With legs on ePWM4..6, ePWM1 may count in step ahead of them, with outputs that do nothing; every other
 * module does not count.
 *
 * Then all counters have the same value, leg n passes CMPA at zero + CMPA and at zero + 2 TBPRD - CMPA, and
 * only dead-band delays, the start of conversion and the next zero are left as events. With CMPA = 0 the
 * action of CAU comes at the zero after it was loaded, with CMPA >= TBPRD that of CAD comes at the period
 * match: exactly as in timebase.c, with which the tests compare this engine.
 *
 * If no module reads the edges (averaged mode, or all pins tripped), the legs keep their state of the
 * carrier's zero until the next zero, or until carrier_see is called. */
#include "host_sim/chip/parts.h"

#define PLAIN_CMPCTL_MASK (0x000Fu | CMPCTL_SHDWAMODE | CMPCTL_SHDWBMODE)
#define CENTRED_ON_ZERO   (AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET))
#define CENTRED_ON_PERIOD (AQCTL_CAU(AQ_SET) | AQCTL_CAD(AQ_CLEAR))
#define DBCTL_IN_AND_OUT  0x0033u
#define POLSEL_ALL        (3u << 2)
#define LEG_PINS(first)   (0x3Fu << (2u * (first)))
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
    epwm->next = earlier(earlier(epwm->cau, epwm->cad), earlier(epwm->red_due, epwm->fed_due));
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
    if (epwm->cau <= cycle) {
        epwm->cau = CHIP_NEVER;
        set_a(epwm, regs, cycle, chip->carrier.up_level);
    }
    if (epwm->cad <= cycle) {
        epwm->cad = CHIP_NEVER;
        set_a(epwm, regs, cycle, chip->carrier.up_level ^ 1u);
    }
    plan_leg(epwm);
    raw_leg(chip, m);
}

static void start_leg(chip_epwm_t *epwm, uint64_t zero, uint32_t half)
{
    epwm->cau = CHIP_NEVER;
    epwm->cad = CHIP_NEVER;
    if (epwm->cmpa >= half) {
        epwm->cad = zero + half;
    } else if (epwm->cmpa != 0u) {
        epwm->cau = zero + epwm->cmpa;
        epwm->cad = zero + 2u * half - epwm->cmpa;
    }
    plan_leg(epwm);
}

/* A whole period of a leg at once. If a leg passes CMPA twice, its level at the end follows from CAD alone.
 * For the rare other cases the edges are computed one by one. */
static void pass_leg(chip_t *chip, uint32_t m, uint64_t end)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    if (epwm->cmpa == 0u || epwm->cmpa >= chip->carrier.half) {
        while (epwm->next <= end) {
            step_leg(chip, m, epwm->next);
        }
        return;
    }
    uint32_t level = chip->carrier.up_level ^ 1u;
    uint64_t due = epwm->cad + (level ? regs->DBRED : regs->DBFED);
    bool out = due <= end;
    epwm->a = level;
    epwm->red_in = level;
    epwm->fed_in = level;
    epwm->red = level && out;
    epwm->red_due = level && !out ? due : CHIP_NEVER;
    epwm->fed = level || !out;
    epwm->fed_due = !level && !out ? due : CHIP_NEVER;
    epwm->cau = CHIP_NEVER;
    epwm->cad = CHIP_NEVER;
}

/* Cycles for which output A is high in this period: before CAU it keeps its level, between CAU and CAD it is
 * `up_level`, after CAD the other level. */
static uint32_t high_time(const chip_epwm_t *epwm, uint32_t half, uint32_t up_level)
{
    uint32_t before = epwm->cmpa;
    uint32_t between = 2u * (half - before);
    uint32_t after = before;
    if (epwm->cmpa >= half) { /* only CAD, at the period match */
        before = half;
        between = 0u;
        after = half;
    } else if (epwm->cmpa == 0u) { /* neither of them: CAU occurs at the next zero */
        before = 2u * half;
        between = 0u;
        after = 0u;
    }
    return (epwm->a ? before : 0u) + (up_level ? between : after);
}

/* The polarity of the dead band, if all legs have the same one of the two complementary polarities and the
 * same delay. */
static uint32_t common_polarity(const chip_t *chip, uint32_t first)
{
    const epwm_regs_t *regs = &chip->registers.epwm[first];
    uint32_t polarity = regs[0].DBCTL & POLSEL_ALL;
    for (uint32_t leg = 0u; leg < CHIP_LEGS; leg++) {
        if ((regs[leg].DBCTL & POLSEL_ALL) != polarity || regs[leg].DBRED != regs[0].DBRED ||
            regs[leg].DBFED != regs[0].DBRED) {
            return 0u;
        }
    }
    return polarity == DBCTL_POLSEL_AHC || polarity == DBCTL_POLSEL_ALC ? polarity : 0u;
}

static void plan(chip_t *chip)
{
    const chip_carrier_t *carrier = &chip->carrier;
    const chip_epwm_t *leg = &chip->epwm[carrier->first];
    uint64_t next = earlier(carrier->soc, carrier->end);
    if (!carrier->lazy) {
        next = earlier(next, leg[0].next);
        next = earlier(next, leg[1].next);
        next = earlier(next, leg[2].next);
    }
    chip->epwm_next = next;
    chip->next[SOURCE_EPWM] = tick_of(chip, next);
}

static uint64_t soc_cycle(const chip_t *chip)
{
    const chip_carrier_t *carrier = &chip->carrier;
    uint32_t cmpb = chip->epwm[carrier->soc_from].cmpb;
    if (carrier->soc_event == ET_PERIOD || (carrier->soc_event == ET_CMPB_DOWN && cmpb >= carrier->half)) {
        return carrier->zero + carrier->half;
    }
    if (carrier->soc_event == ET_CMPB_DOWN && cmpb != 0u) {
        return carrier->end - cmpb;
    }
    return CHIP_NEVER;
}

/* Rounds to the nearest tick. */
static uint32_t rounded(const chip_t *chip, uint32_t cycles)
{
    const chip_clock_t *clock = &chip->clock;
    if (clock->ticks == clock->cycles) {
        return cycles;
    }
    return (uint32_t)((2u * (uint64_t)cycles * clock->ticks + clock->cycles) /
                      (2u * (uint64_t)clock->cycles));
}

static void tell_average(chip_t *chip)
{
    const chip_carrier_t *carrier = &chip->carrier;
    uint32_t period = (uint32_t)(tick_of(chip, carrier->end) - chip->tick);
    uint32_t high[CHIP_LEGS];
    for (uint32_t leg = 0u; leg < CHIP_LEGS; leg++) {
        uint32_t cycles = high_time(&chip->epwm[carrier->first + leg], carrier->half, carrier->up_level);
        uint32_t ticks = rounded(chip, cycles);
        high[leg] = cycles == 2u * carrier->half ? period : (ticks < period ? ticks : period - 1u);
    }
    chip->pins.hidden = 1u;
    if (chip == chip_bound) {
        chip_world->carrier(chip_world->context, chip->tick, period, high,
                            rounded(chip, chip->registers.epwm[carrier->first].DBRED),
                            carrier->up_level == 0u);
    }
}

/* Legs, compare values and triggers are as after the events of this zero. */
static void begin(chip_t *chip, uint64_t zero)
{
    chip_carrier_t *carrier = &chip->carrier;
    const chip_pins_t *pins = &chip->pins;
    uint32_t legs = LEG_PINS(carrier->first);
    carrier->zero = zero;
    carrier->end = zero + 2u * carrier->half;
    carrier->soc = soc_cycle(chip);
    for (uint32_t leg = 0u; leg < CHIP_LEGS; leg++) {
        start_leg(&chip->epwm[carrier->first + leg], zero, carrier->half);
    }
    bool blind = ((pins->forced | pins->floating | ~pins->muxed) & legs) == legs;
    bool average = false;
    if (chip->averaged && chip == chip_bound) {
        uint32_t expected = chip_world->active_low ? DBCTL_POLSEL_ALC : DBCTL_POLSEL_AHC;
        average = carrier->polarity == expected && (pins->muxed & legs) == legs &&
                  ((pins->forced | pins->floating) & legs) == 0u;
    }
    carrier->lazy = blind || average;
    plan(chip);
    if (average) {
        tell_average(chip);
    } else {
        outputs_show(chip);
    }
}

/* Effects of the counter's zero on one module after the actions of its outputs. */
static void load_at_zero(chip_t *chip, uint32_t m)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    epwm->cmpa = chip->registers.epwm[m].CMPA;
    epwm->cmpb = chip->registers.epwm[m].CMPB;
    if (epwm->cbc) {
        trip_zero(chip, m);
    }
}

static void zero_event(chip_t *chip)
{
    chip_carrier_t *carrier = &chip->carrier;
    uint64_t zero = carrier->end;
    for (uint32_t m = carrier->first; m < carrier->first + CHIP_LEGS; m++) {
        chip_epwm_t *epwm = &chip->epwm[m];
        if (carrier->lazy) {
            pass_leg(chip, m, zero);
        } else if (epwm->next <= zero) {
            step_leg(chip, m, zero);
        }
        if (epwm->cmpa == 0u) {
            set_a(epwm, &chip->registers.epwm[m], zero, carrier->up_level);
        }
        load_at_zero(chip, m);
        raw_leg(chip, m);
    }
    if (carrier->first != 0u && carrier_has(chip, 0u)) {
        load_at_zero(chip, 0u);
    }
    if (carrier->soc_event == ET_ZERO) {
        trigger_soc(chip, carrier->soc_from, zero, 0u);
    }
    chip->carrier_tick = chip->tick;
    chip->carrier_cycle = zero;
    begin(chip, zero);
}

static void one_event(chip_t *chip)
{
    chip_carrier_t *carrier = &chip->carrier;
    uint64_t cycle = chip->epwm_next;
    if (carrier->soc <= cycle) {
        carrier->soc = CHIP_NEVER;
        trigger_soc(chip, carrier->soc_from, cycle, 0u);
    }
    if (carrier->end <= cycle) {
        zero_event(chip);
        return;
    }
    if (carrier->lazy) {
        plan(chip);
        return;
    }
    const chip_epwm_t *legs = &chip->epwm[carrier->first];
    for (uint32_t leg = 0u; leg < CHIP_LEGS; leg++) {
        if (legs[leg].next <= cycle) {
            step_leg(chip, carrier->first + leg, cycle);
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
    chip_carrier_t *carrier = &chip->carrier;
    if (!carrier->lazy) {
        return;
    }
    uint64_t now = cycle_now(chip);
    for (uint32_t m = carrier->first; m < carrier->first + CHIP_LEGS; m++) {
        while (chip->epwm[m].next <= now) {
            step_leg(chip, m, chip->epwm[m].next);
        }
        raw_leg(chip, m);
    }
    carrier->lazy = 0u;
    plan(chip);
    chip_plan(chip, SOURCE_EPWM,
              chip->next[SOURCE_EPWM]); /* a computation in advance ends before these counts */
}

/* The counter of one module has just passed zero at `cycle` and continues like that of the first leg. */
static bool in_step(const chip_t *chip, uint32_t m, uint32_t first, uint64_t cycle)
{
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    const chip_epwm_t *epwm = &chip->epwm[m];
    bool follows = (regs->TBCTL & TBCTL_PHSEN) != 0u;
    bool keeps_step = !follows || (m != 0u && regs->TBPHS == 2u && (regs->TBCTL & TBCTL_PHSDIR_UP) != 0u);
    return epwm->running && epwm->anchor == cycle && epwm->count == 0u && epwm->divider == 1u &&
           epwm->period == chip->epwm[first].period && epwm->period >= 2u && epwm->force == 0u &&
           keeps_step && !timebase_stops(chip, m) && (regs->TBCTL & 3u) == TBCTL_UPDOWN &&
           (regs->TBCTL & TBCTL_PRDLD) == 0u && ((regs->TBCTL >> 4) & 3u) != 2u &&
           (regs->CMPCTL & PLAIN_CMPCTL_MASK) == 0u && regs->AQCTLB == 0u && regs->AQCSFRC == 0u &&
           (regs->ETPS & (ETPS_INT | ETPS_SOCB)) == 0u;
}

static bool plain_leg(const chip_t *chip, uint32_t m, uint32_t first, uint64_t cycle)
{
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    return in_step(chip, m, first, cycle) && regs->AQCTLA == chip->registers.epwm[first].AQCTLA &&
           (regs->DBCTL & DBCTL_IN_AND_OUT) == DBCTL_OUT_BOTH;
}

static bool idle_leader(const chip_t *chip, uint32_t first, uint64_t cycle)
{
    const chip_epwm_t *epwm = &chip->epwm[0];
    return in_step(chip, 0u, first, cycle) && chip->registers.epwm[0].AQCTLA == 0u &&
           epwm->red_due == CHIP_NEVER && epwm->fed_due == CHIP_NEVER;
}

/* Bit m: module m counts in step. 0: the set-up is not the usual one. */
static uint32_t find_members(const chip_t *chip, uint32_t first, uint64_t cycle)
{
    uint32_t members = 0u;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        if (m - first < CHIP_LEGS) {
            if (!plain_leg(chip, m, first, cycle)) {
                return 0u;
            }
            members |= 1u << m;
        } else if (chip->epwm[m].next != CHIP_NEVER) {
            if (m != 0u || !idle_leader(chip, first, cycle)) {
                return 0u;
            }
            members |= 1u;
        }
    }
    return members;
}

/* The module whose SOCA starts conversions, if at most one module does this, at an event that this engine
 * supports. */
static bool find_trigger(const chip_t *chip, uint32_t members, uint32_t first, uint32_t *from,
                         uint32_t *event)
{
    *from = first;
    *event = 0u;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        const epwm_regs_t *regs = &chip->registers.epwm[m];
        if ((members >> m & 1u) == 0u || (regs->ETPS & ETPS_SOCA) == 0u) {
            continue;
        }
        uint32_t selected = (uint32_t)(regs->ETSEL >> 8) & 7u;
        if (*event != 0u ||
            (selected != 0u && selected != ET_ZERO && selected != ET_PERIOD && selected != ET_CMPB_DOWN)) {
            return false;
        }
        *from = m;
        *event = selected;
    }
    return true;
}

void carrier_try(chip_t *chip, uint64_t cycle)
{
    chip_carrier_t *carrier = &chip->carrier;
    uint32_t first = chip->pins.first;
    uint16_t aqctla = chip->registers.epwm[first].AQCTLA;
    uint32_t soc_from;
    uint32_t soc_event;
    if (chip->clock.ticks < chip->clock.cycles || chip->epwm[first].anchor != cycle ||
        (aqctla != CENTRED_ON_ZERO && aqctla != CENTRED_ON_PERIOD)) {
        return;
    }
    uint32_t members = find_members(chip, first, cycle);
    if (members == 0u || !find_trigger(chip, members, first, &soc_from, &soc_event)) {
        return;
    }
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        if ((members >> m & 1u) != 0u) {
            chip->epwm[m].sync_due = CHIP_NEVER; /* would load the present count */
            chip->epwm[m].count_next = CHIP_NEVER;
            chip->epwm[m].next = CHIP_NEVER;
        }
    }
    carrier->active = 1u;
    carrier->half = chip->epwm[first].period;
    carrier->soc_event = soc_event;
    carrier->soc_from = soc_from;
    carrier->first = first;
    carrier->members = members;
    carrier->up_level = aqctla == CENTRED_ON_PERIOD;
    carrier->polarity = common_polarity(chip, first);
    begin(chip, cycle);
}

void carrier_leave(chip_t *chip)
{
    chip_carrier_t *carrier = &chip->carrier;
    carrier_see(chip);
    carrier->active = 0u;
    uint64_t now = cycle_now(chip);
    bool falling = now >= carrier->zero + carrier->half;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        if ((carrier->members >> m & 1u) == 0u) {
            continue;
        }
        chip_epwm_t *epwm = &chip->epwm[m];
        epwm->anchor = falling ? carrier->zero + carrier->half : carrier->zero;
        epwm->count = falling ? carrier->half : 0u;
        epwm->up = falling ? 0u : 1u;
        epwm->cau = CHIP_NEVER;
        epwm->cad = CHIP_NEVER;
        epwm->count_next = CHIP_NEVER;
        timebase_hold(chip, m);
        timebase_plan(chip, m);
    }
    timebase_schedule(chip);
}
