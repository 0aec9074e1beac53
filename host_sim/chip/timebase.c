/* ePWM time base, any set-up: SPRUG04 time-base and counter-compare submodules.
 *
 * A module is followed from one count where something happens to the next: zero, period, CMPA, CMPB,
 * overflow. Counting up-down, the direction is up at zero and down at the period. Compare values at or above
 * the period act at the period match (counting down or up-down; counting up, above the period, never).
 *
 * Events of a count see the active registers as they were; shadow loads at that count act from the next count
 * on. Therefore a CMPA of 0 that is loaded at zero has no effect at this zero (hence TI's "keep it >= 1").
 *
 * A counter that starts at zero begins with the events of zero, which is how the first TBPRD becomes active.
 * One that counts past its period (TBPRD was reduced, TBCTR written) runs on to 0xFFFF and 0.
 *
 * A debugger's halt stops only the counter (FREE_SOFT): a dead band that has begun ends, trips act, and a
 * sync pulse has no effect on a stopped counter, so that modules that stopped in step stay in step. */
#include "host_sim/chip/parts.h"

#define SYNC_LAG 2u /* [SYSCLK] from SYNCI to the slave's counter if TBCLK = SYSCLK, else one TBCLK */

typedef enum { MODE_UP, MODE_DOWN, MODE_UPDOWN, MODE_STOP } count_mode_t;

static count_mode_t mode_of(const chip_t *chip, uint32_t m)
{
    return (count_mode_t)(chip->registers.epwm[m].TBCTL & 3u);
}

uint32_t timebase_divider(uint32_t tbctl)
{
    uint32_t high_speed = (tbctl >> 7) & 7u;
    return (high_speed == 0u ? 1u : 2u * high_speed) << ((tbctl >> 10) & 7u);
}

static bool frozen(const chip_t *chip, uint32_t m)
{
    return (chip->debug.frozen >> m & 1u) != 0u;
}

static bool counts(const chip_t *chip, uint32_t m)
{
    const chip_epwm_t *epwm = &chip->epwm[m];
    return epwm->running && !frozen(chip, m) && mode_of(chip, m) != MODE_STOP &&
           (epwm->period != 0u || epwm->count != 0u);
}

/* Counter `steps` TBCLK on; steps reach at most to the next event. */
static void advance(const chip_t *chip, uint32_t m, uint64_t steps, uint32_t *count, uint32_t *up)
{
    const chip_epwm_t *epwm = &chip->epwm[m];
    uint64_t ahead = epwm->count + steps;
    *up = epwm->up;
    *count = epwm->count;
    if (steps == 0u) {
        return;
    }
    switch (mode_of(chip, m)) {
    case MODE_UP:
        *count = ahead == (uint64_t)epwm->period + 1u || ahead == 0x10000u ? 0u : (uint32_t)ahead;
        break;
    case MODE_DOWN:
        *count = epwm->count == 0u ? epwm->period : (uint32_t)(epwm->count - steps);
        break;
    case MODE_UPDOWN:
        if (epwm->up) {
            *count = (uint32_t)(ahead & 0xFFFFu);
        } else {
            *count = (uint32_t)(epwm->count - steps);
        }
        if (*count == 0u) {
            *up = 1u;
        } else if (*count == epwm->period) {
            *up = 0u;
        }
        break;
    case MODE_STOP:
        break;
    }
}

static uint64_t steps_to(const chip_t *chip, uint32_t m, uint64_t cycle)
{
    const chip_epwm_t *epwm = &chip->epwm[m];
    return counts(chip, m) ? (cycle - epwm->anchor) / epwm->divider : 0u;
}

static void hold_at(chip_t *chip, uint32_t m, uint64_t cycle)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    uint64_t steps = steps_to(chip, m, cycle);
    uint32_t count;
    uint32_t up;
    advance(chip, m, steps, &count, &up);
    epwm->count = count;
    epwm->up = up;
    epwm->anchor = counts(chip, m) ? epwm->anchor + steps * epwm->divider : cycle;
}

void timebase_hold(chip_t *chip, uint32_t m)
{
    hold_at(chip, m, cycle_now(chip));
}

/* TBCLK to the next count of interest, at least 1. */
static uint32_t distance(const chip_t *chip, uint32_t m)
{
    const chip_epwm_t *epwm = &chip->epwm[m];
    uint32_t count = epwm->count;
    uint32_t target[3] = {epwm->period, epwm->cmpa, epwm->cmpb};
    uint32_t least;
    bool rising = mode_of(chip, m) == MODE_UP || (mode_of(chip, m) == MODE_UPDOWN && epwm->up);
    if (!rising && count == 0u) {
        return 1u;
    }
    if (!rising) {
        least = count;
    } else if (count > epwm->period) {
        return 0x10000u - count;
    } else {
        least = epwm->period + 1u - count;
    }
    for (uint32_t i = 0u; i < 3u; i++) {
        if (rising && target[i] > count && target[i] - count < least) {
            least = target[i] - count;
        } else if (!rising && target[i] < count && count - target[i] < least) {
            least = count - target[i];
        }
    }
    return least;
}

void timebase_plan(chip_t *chip, uint32_t m)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    if (!epwm->running) {
        epwm->count_next = CHIP_NEVER;
        epwm->next = CHIP_NEVER;
        return;
    }
    if (epwm->count_next != epwm->anchor) { /* else the start is in the future */
        epwm->count_next =
            counts(chip, m) ? epwm->anchor + (uint64_t)distance(chip, m) * epwm->divider : CHIP_NEVER;
    }
    epwm->next = earlier(earlier(epwm->count_next, epwm->sync_due), earlier(epwm->red_due, epwm->fed_due));
    epwm->next = earlier(epwm->next, chip->debug.stop[m]);
}

void timebase_start(chip_t *chip, uint32_t m)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    if (epwm->running && !frozen(chip, m) && mode_of(chip, m) != MODE_STOP) {
        epwm->anchor = cycle_now(chip);
        epwm->count_next = epwm->anchor;
        timebase_plan(chip, m);
    }
}

void timebase_schedule(chip_t *chip)
{
    uint64_t next = CHIP_NEVER;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        next = earlier(next, chip->epwm[m].next);
    }
    chip->epwm_next = next;
    chip_plan(chip, SOURCE_EPWM, tick_of(chip, next));
}

void timebase_sync(chip_t *chip, uint32_t m, uint64_t cycle)
{
    static const uint32_t follower[CHIP_EPWMS] = {1u, 2u, CHIP_EPWMS, 4u, 5u, CHIP_EPWMS};
    chip_epwm_t *epwm = &chip->epwm[m];
    uint16_t tbctl = chip->registers.epwm[m].TBCTL;
    if (epwm->running && !frozen(chip, m) && (tbctl & TBCTL_PHSEN) != 0u) {
        epwm->sync_due = cycle + (epwm->divider == 1u ? SYNC_LAG : epwm->divider);
        timebase_plan(chip, m);
    }
    if (((tbctl >> 4) & 3u) != 0u) {
        return;
    }
    if (follower[m] < CHIP_EPWMS) {
        timebase_sync(chip, follower[m], cycle);
    }
    if (m == 0u) {
        timebase_sync(chip, 3u, cycle);
    }
}

static void sync_out(chip_t *chip, uint32_t m, uint64_t cycle)
{
    if (m == 0u) {
        timebase_sync(chip, 1u, cycle);
        timebase_sync(chip, 3u, cycle);
    } else if (m != 2u && m != 5u) {
        timebase_sync(chip, m + 1u, cycle);
    }
}

static uint32_t events_at(const chip_t *chip, uint32_t m)
{
    const chip_epwm_t *epwm = &chip->epwm[m];
    uint32_t count = epwm->count;
    uint32_t period = epwm->period;
    uint32_t compare[2] = {epwm->cmpa, epwm->cmpb};
    uint32_t up_event[2] = {1u << EVENT_CAU, 1u << EVENT_CBU};
    uint32_t down_event[2] = {1u << EVENT_CAD, 1u << EVENT_CBD};
    bool at_period = count == period && period != 0u;
    uint32_t events = (count == 0u ? 1u << EVENT_ZERO : 0u) | (at_period ? 1u << EVENT_PERIOD : 0u);
    for (uint32_t i = 0u; i < 2u; i++) {
        bool match = count == compare[i] && compare[i] < period;
        switch (mode_of(chip, m)) {
        case MODE_UP:
            events |= count == compare[i] && count <= period ? up_event[i] : 0u;
            break;
        case MODE_DOWN:
            events |= match || (at_period && compare[i] >= period) ? down_event[i] : 0u;
            break;
        case MODE_UPDOWN:
            if (at_period && compare[i] >= period) {
                events |= up_event[i] | down_event[i];
            } else if (match) {
                events |= epwm->up ? up_event[i] : down_event[i];
            }
            break;
        case MODE_STOP:
            break;
        }
    }
    return events;
}

/* mode: 0 at zero, 1 at period, 2 both, 3 never. */
static bool loads(uint32_t mode, bool zero, bool at_period)
{
    return (zero && (mode == 0u || mode == 2u)) || (at_period && (mode == 1u || mode == 2u));
}

static void load_shadows(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t events)
{
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    chip_epwm_t *epwm = &chip->epwm[m];
    bool zero = (events & (1u << EVENT_ZERO)) != 0u;
    bool at_period = (events & (1u << EVENT_PERIOD)) != 0u;
    uint32_t force_mode = (regs->AQSFRC >> 6) & 3u;
    if (zero && (regs->TBCTL & TBCTL_PRDLD) == 0u) {
        epwm->period = regs->TBPRD;
    }
    if ((regs->CMPCTL & CMPCTL_SHDWAMODE) == 0u && loads(regs->CMPCTL & 3u, zero, at_period)) {
        epwm->cmpa = regs->CMPA;
    }
    if ((regs->CMPCTL & CMPCTL_SHDWBMODE) == 0u && loads((regs->CMPCTL >> 2) & 3u, zero, at_period)) {
        epwm->cmpb = regs->CMPB;
    }
    if (force_mode != 3u && loads(force_mode, zero, at_period)) {
        outputs_force(chip, m, cycle);
    }
}

static void count_events(chip_t *chip, uint32_t m, uint64_t cycle)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    uint32_t events = events_at(chip, m);
    uint32_t sync = (uint32_t)(chip->registers.epwm[m].TBCTL >> 4) & 3u;
    bool zero = (events & (1u << EVENT_ZERO)) != 0u;
    bool sync_now = (sync == 1u && zero) || (sync == 2u && epwm->count == epwm->cmpb);
    outputs_act(chip, m, cycle, events, (uint32_t)mode_of(chip, m), epwm->up);
    trigger_events(chip, m, cycle, events);
    load_shadows(chip, m, cycle, events);
    if (zero) {
        trip_zero(chip, m);
    }
    if (zero && m == chip->pins.first) {
        chip->carrier_tick = chip->tick;
        chip->carrier_cycle = cycle;
    }
    if (sync_now) {
        sync_out(chip, m, cycle);
    }
}

/* The count at which a counter stops with FREE_SOFT = 1. */
static bool at_end(const chip_t *chip, uint32_t m)
{
    const chip_epwm_t *epwm = &chip->epwm[m];
    return epwm->count == (mode_of(chip, m) == MODE_UP ? epwm->period : 0u);
}

static void freeze(chip_t *chip, uint32_t m)
{
    chip->debug.frozen |= 1u << m;
    chip->debug.ending &= ~(1u << m);
    chip->debug.stop[m] = CHIP_NEVER;
    chip->epwm[m].sync_due = CHIP_NEVER;
}

bool timebase_stops(const chip_t *chip, uint32_t m)
{
    return chip->debug.halted != 0u && chip->registers.epwm[m].TBCTL < TBCTL_FREE_SOFT(2u);
}

void timebase_debug(chip_t *chip, uint32_t m)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    if (!timebase_stops(chip, m)) {
        if (frozen(chip, m)) {
            epwm->anchor = cycle_now(chip);
        }
        chip->debug.frozen &= ~(1u << m);
        chip->debug.ending &= ~(1u << m);
        chip->debug.stop[m] = CHIP_NEVER;
    } else if (counts(chip, m)) {
        timebase_hold(chip, m);
        if (chip->registers.epwm[m].TBCTL < TBCTL_FREE_SOFT(1u)) {
            chip->debug.stop[m] = epwm->anchor + epwm->divider;
        } else if (at_end(chip, m)) {
            freeze(chip, m);
        } else {
            chip->debug.ending |= 1u << m;
        }
    }
    timebase_plan(chip, m);
}

static void step(chip_t *chip, uint32_t m, uint64_t cycle)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    deadband_due(epwm, cycle);
    bool counted = epwm->count_next <= cycle;
    bool wraps = epwm->up && epwm->count > epwm->period;
    bool stops = chip->debug.stop[m] <= cycle;
    if (counted || stops || epwm->sync_due <= cycle) {
        hold_at(chip, m, cycle);
    }
    if (counted && wraps && epwm->count == 0u) {
        epwm->overflow = 1u;
    }
    if (epwm->sync_due <= cycle) {
        uint32_t up = mode_of(chip, m) == MODE_UPDOWN ? (regs->TBCTL & TBCTL_PHSDIR_UP) != 0u : epwm->up;
        epwm->sync_due = CHIP_NEVER;
        if (epwm->count != regs->TBPHS || epwm->up != up) {
            epwm->count = regs->TBPHS;
            epwm->up = up;
            if (mode_of(chip, m) == MODE_UPDOWN && epwm->count == 0u) {
                epwm->up = 1u;
            } else if (mode_of(chip, m) == MODE_UPDOWN && epwm->count == epwm->period) {
                epwm->up = 0u;
            }
            counted = true;
        }
        epwm->anchor = cycle;
    }
    if (counted) {
        epwm->count_next = CHIP_NEVER;
        count_events(chip, m, cycle);
        stops = stops || ((chip->debug.ending >> m & 1u) != 0u && at_end(chip, m));
    }
    if (stops) {
        freeze(chip, m);
    }
    outputs_raw(chip, m);
    timebase_plan(chip, m);
}

void epwm_event(chip_t *chip)
{
    if (chip->carrier.active) {
        carrier_event(chip);
        return;
    }
    uint64_t cycle = chip->epwm_next;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        if (chip->epwm[m].next <= cycle) {
            step(chip, m, cycle);
        }
    }
    timebase_schedule(chip);
    carrier_try(chip, cycle);
    if (!chip->carrier.active) {
        outputs_show(chip);
    }
}

void epwm_settle(chip_t *chip)
{
    while (chip->next[SOURCE_EPWM] <= chip->tick) {
        epwm_event(chip);
    }
}

void epwm_clock(chip_t *chip)
{
    const sysctrl_regs_t *sysctrl = &chip->registers.sysctrl;
    uint64_t now = cycle_now(chip);
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        chip_epwm_t *epwm = &chip->epwm[m];
        uint32_t running =
            (sysctrl->PCLKCR0 & PCLKCR0_TBCLKSYNC) != 0u && (sysctrl->PCLKCR1 & (PCLKCR1_EPWM1 << m)) != 0u;
        if (running == epwm->running) {
            continue;
        }
        if (chip->carrier.active) {
            carrier_leave(chip);
        }
        timebase_hold(chip, m);
        epwm->running = running;
        if (!running) { /* the anchor contains the time at which it stopped */
            epwm->anchor = now;
            timebase_plan(chip, m);
            continue;
        }
        uint64_t stood = now - epwm->anchor;
        epwm->sync_due = CHIP_NEVER;
        epwm->red_due += epwm->red_due != CHIP_NEVER ? stood : 0u;
        epwm->fed_due += epwm->fed_due != CHIP_NEVER ? stood : 0u;
        epwm->anchor = now;
        timebase_plan(chip, m);
        if (epwm->count == 0u) {
            timebase_start(chip, m);
        }
    }
    timebase_schedule(chip);
    outputs_show(chip); /* if an average was left */
}

void epwm_refresh(chip_t *chip)
{
    uint64_t now = cycle_now(chip);
    const chip_carrier_t *carrier = &chip->carrier;
    uint32_t phase = (uint32_t)(now - carrier->zero); /* only if there is a carrier */
    uint32_t common = phase <= carrier->half ? phase : 2u * carrier->half - phase;
    uint32_t common_up = phase < carrier->half || common == 0u;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        uint32_t count = common;
        uint32_t up = common_up;
        if (!carrier_has(chip, m)) {
            if (!chip->epwm[m].running && carrier->active) {
                continue;
            }
            advance(chip, m, steps_to(chip, m, now), &count, &up);
        }
        chip->registers.epwm[m].TBCTR = (uint16_t)count;
        chip->registers.epwm[m].TBSTS = (uint16_t)(up | chip->epwm[m].overflow << 2);
    }
}
