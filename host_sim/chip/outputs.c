/* From counter events to pins: action qualifier, dead band, trip zone (SPRUG04) and the pin multiplexer. */
#include "host_sim/chip/parts.h"

#define PIN_BITS(m) (3u << (2u * (m)))
#define LOWER_PINS  0x3Fu /* of ePWM1..3 */

/* Priority of several events at the same count, highest first: SPRUG04 tables "action-qualifier event
 * priority". */
static const epwm_event_t *priority(uint32_t mode, uint32_t up, uint32_t *length)
{
    static const epwm_event_t counting_up[] = {EVENT_PERIOD, EVENT_CBU, EVENT_CAU, EVENT_ZERO};
    static const epwm_event_t counting_down[] = {EVENT_ZERO, EVENT_CBD, EVENT_CAD, EVENT_PERIOD};
    static const epwm_event_t on_the_way_up[] = {EVENT_CBU, EVENT_CAU, EVENT_ZERO, EVENT_CBD, EVENT_CAD};
    static const epwm_event_t on_the_way_down[] = {EVENT_CBD, EVENT_CAD, EVENT_PERIOD, EVENT_CBU, EVENT_CAU};
    *length = mode == TBCTL_UPDOWN ? 5u : 4u;
    if (mode == TBCTL_UPDOWN) {
        return up ? on_the_way_up : on_the_way_down;
    }
    return mode == 0u ? counting_up : counting_down;
}

static uint32_t action(uint32_t aqctl, uint32_t events, uint32_t mode, uint32_t up)
{
    uint32_t length;
    const epwm_event_t *order = priority(mode, up, &length);
    for (uint32_t i = 0u; i < length; i++) {
        uint32_t what = (aqctl >> (2u * (uint32_t)order[i])) & 3u;
        if ((events & (1u << order[i])) != 0u && what != AQ_NONE) {
            return what;
        }
    }
    return AQ_NONE;
}

static uint32_t acted(uint32_t level, uint32_t what)
{
    switch (what) {
    case AQ_CLEAR:
        return 0u;
    case AQ_SET:
        return 1u;
    case AQ_TOGGLE:
        return level ^ 1u;
    default:
        return level;
    }
}

static bool is_forced(uint32_t force)
{
    return (force & 3u) == 1u || (force & 3u) == 2u;
}

void outputs_act(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t events, uint32_t mode, uint32_t up)
{
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    chip_epwm_t *epwm = &chip->epwm[m];
    if (!is_forced(epwm->force)) {
        epwm->a = acted(epwm->a, action(regs->AQCTLA, events, mode, up));
    }
    if (!is_forced(epwm->force >> 2)) {
        epwm->b = acted(epwm->b, action(regs->AQCTLB, events, mode, up));
    }
    outputs_inputs(chip, m, cycle);
}

void outputs_force(chip_t *chip, uint32_t m, uint64_t cycle)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    epwm->force = chip->registers.epwm[m].AQCSFRC;
    if (is_forced(epwm->force)) {
        epwm->a = (epwm->force & 3u) == 2u;
    }
    if (is_forced(epwm->force >> 2)) {
        epwm->b = (epwm->force >> 2) == 2u;
    }
    outputs_inputs(chip, m, cycle);
}

void outputs_once(chip_t *chip, uint32_t m, uint64_t cycle, uint16_t aqsfrc)
{
    chip_epwm_t *epwm = &chip->epwm[m];
    if ((aqsfrc & (1u << 2)) != 0u && !is_forced(epwm->force)) {
        epwm->a = acted(epwm->a, aqsfrc & 3u);
    }
    if ((aqsfrc & (1u << 5)) != 0u && !is_forced(epwm->force >> 2)) {
        epwm->b = acted(epwm->b, (uint32_t)(aqsfrc >> 3) & 3u);
    }
    outputs_inputs(chip, m, cycle);
}

void outputs_inputs(chip_t *chip, uint32_t m, uint64_t cycle)
{
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    chip_epwm_t *epwm = &chip->epwm[m];
    uint32_t red_in = (regs->DBCTL & (1u << 4)) != 0u ? epwm->b : epwm->a;
    uint32_t fed_in = (regs->DBCTL & (1u << 5)) != 0u ? epwm->b : epwm->a;
    if (red_in != epwm->red_in) {
        deadband_rising_path(epwm, cycle, red_in, (uint64_t)regs->DBRED * epwm->divider);
    }
    if (fed_in != epwm->fed_in) {
        deadband_falling_path(epwm, cycle, fed_in, (uint64_t)regs->DBFED * epwm->divider);
    }
}

void outputs_raw(chip_t *chip, uint32_t m)
{
    const epwm_regs_t *regs = &chip->registers.epwm[m];
    const chip_epwm_t *epwm = &chip->epwm[m];
    uint32_t a = (regs->DBCTL & 2u) != 0u ? epwm->red ^ ((regs->DBCTL >> 2) & 1u) : epwm->a;
    uint32_t b = (regs->DBCTL & 1u) != 0u ? epwm->fed ^ ((regs->DBCTL >> 3) & 1u) : epwm->b;
    chip->pins.raw = (chip->pins.raw & ~PIN_BITS(m)) | (a | b << 1) << (2u * m);
}

static bool tripped(const chip_t *chip, uint32_t m)
{
    return (chip->registers.epwm[m].TZFLG & TZ_OST) != 0u || chip->epwm[m].cbc != 0u;
}

/* The trip zones between the dead bands and the pins. */
static void configure(chip_t *chip)
{
    chip_pins_t *pins = &chip->pins;
    pins->muxed = 0u;
    pins->forced = 0u;
    pins->forced_level = 0u;
    pins->floating = 0u;
    pins->gpio_driven = 0u;
    pins->gpio_level = 0u;
    for (uint32_t pin = 0u; pin < 2u * CHIP_EPWMS; pin++) {
        uint32_t bit = 1u << pin;
        uint32_t mux = gpio_mux(chip, pin);
        uint32_t m = pin / 2u;
        if (mux == 0u && (chip->registers.gpio_control[0].DIR & bit) != 0u) {
            pins->gpio_driven |= bit;
            pins->gpio_level |= chip->gpio_latch[0] & bit;
        }
        if (mux != 1u) {
            continue;
        }
        pins->muxed |= bit;
        if (tripped(chip, m)) {
            uint32_t reaction = (uint32_t)(chip->registers.epwm[m].TZCTL >> (2u * (pin % 2u))) & 3u;
            pins->floating |= reaction == 0u ? bit : 0u;
            pins->forced |= reaction == TZ_HIGH || reaction == TZ_LOW ? bit : 0u;
            pins->forced_level |= reaction == TZ_HIGH ? bit : 0u;
        }
    }
    pins->first = (pins->muxed & LOWER_PINS) == 0u && pins->muxed != 0u ? CHIP_LEGS : 0u;
}

void outputs_show(chip_t *chip)
{
    chip_pins_t *pins = &chip->pins;
    uint32_t driven = pins->muxed & ~pins->floating;
    uint32_t level = (((pins->raw & ~pins->forced) | pins->forced_level) & driven) | pins->gpio_level;
    driven |= pins->gpio_driven;
    if (level == pins->level && driven == pins->driven && !pins->hidden) {
        return;
    }
    pins->level = level;
    pins->driven = driven;
    pins->hidden = 0u;
    gpio_show(chip);
    if (chip == chip_bound) {
        chip_world->gates(chip_world->context, chip->tick, level, driven);
    }
}

static void tell_trip(chip_t *chip)
{
    uint32_t mask = 0u;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        mask |= (uint32_t)tripped(chip, m) << m;
    }
    if (mask != chip->tripped) {
        chip->tripped = mask;
        chip_tell(chip, CHIP_EVENT_TRIP, mask);
    }
}

void outputs_changed(chip_t *chip)
{
    carrier_see(chip);
    configure(chip);
    if (chip->carrier.active && chip->carrier.first != chip->pins.first) {
        carrier_leave(chip);
    }
    outputs_show(chip);
    tell_trip(chip);
}

/* Sets flags, and requests the interrupt if it is enabled and not pending already. */
static void trip(chip_t *chip, uint32_t m, uint32_t flags)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    regs->TZFLG |= (uint16_t)flags;
    if ((flags & TZ_CBC) != 0u) {
        chip->epwm[m].cbc = 1u;
    }
    if ((regs->TZFLG & regs->TZEINT & (TZ_CBC | TZ_OST)) != 0u && (regs->TZFLG & TZ_INT) == 0u) {
        regs->TZFLG |= TZ_INT;
        pie_request(chip, 2u, 1u << m);
    }
}

static uint32_t pulled(const chip_t *chip, uint32_t m)
{
    uint32_t low = gpio_trip_low(chip);
    uint32_t select = chip->registers.epwm[m].TZSEL;
    return ((low & (select >> 8)) != 0u ? TZ_OST : 0u) | ((low & select) != 0u ? TZ_CBC : 0u);
}

void trip_pins(chip_t *chip)
{
    uint32_t any = 0u;
    for (uint32_t m = 0u; m < CHIP_EPWMS; m++) {
        uint32_t flags = pulled(chip, m);
        if (flags != 0u) {
            trip(chip, m, flags);
            any |= flags;
        }
    }
    if (any != 0u) {
        outputs_changed(chip);
    }
}

void trip_zero(chip_t *chip, uint32_t m)
{
    if (chip->epwm[m].cbc && (pulled(chip, m) & TZ_CBC) == 0u) {
        chip->epwm[m].cbc = 0u;
        configure(chip);
        tell_trip(chip);
    }
}

void trip_write(chip_t *chip, uint32_t m, uint32_t offset, uint16_t value)
{
    epwm_regs_t *regs = &chip->registers.epwm[m];
    switch (offset) {
    case OFFSET(epwm_regs_t, TZSEL):
        regs->TZSEL = value & 0x3F3Fu;
        trip_pins(chip);
        break;
    case OFFSET(epwm_regs_t, TZCTL):
        regs->TZCTL = value & 0x000Fu;
        break;
    case OFFSET(epwm_regs_t, TZEINT):
        regs->TZEINT = value & (TZ_CBC | TZ_OST);
        break;
    case OFFSET(epwm_regs_t, TZCLR): /* a pin that is still low trips again at once */
        regs->TZFLG &= (uint16_t) ~(value & (TZ_INT | TZ_CBC | TZ_OST));
        trip(chip, m, pulled(chip, m));
        break;
    default: /* TZFRC */
        trip(chip, m, value & (TZ_CBC | TZ_OST));
        break;
    }
    outputs_changed(chip);
}
