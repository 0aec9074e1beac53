/* eQEP1 and 2: SPRUG05. Models four counts a line from the position of the shaft, the position counter with
 * its maximum, the unit timer with latch, flags and interrupt.
 *
 * The pins are sampled when the result is visible: at a unit time-out, before an interrupt, after a wait.
 * Between two readings there must be fewer counts than SYSCLK cycles. If there are more, because the position
 * has jumped, the effect is that of two edges in one cycle on silicon: there is a phase error, and the
 * counter follows only the quadrature lines, which show the jump modulo 4.
 *
 * QUTMR goes from 0 to QUPRD, where the time-out sets it to 0 in the same cycle: the period is QUPRD cycles
 * (SPRUG05, unit timer). No index or strobe pulse ever comes, so the fields that react to one have no effect.
 *
 * A debugger's halt: FREE_SOFT 0 stops position counter and unit timer at once, 1 at their next roll-over,
 * 2 and 3 never. The position counter loses the motion of the shaft while it does not count. */
#include "host_sim/chip/parts.h"

#include <assert.h>

#define QEPCTL_WDE        (1u << 0)
#define QDECCTL_STORED    (QDECCTL_SWAP | QDECCTL_XCR)
#define QFLG_INT          (1u << 0)
#define QFLG_QDC          (1u << 3)
#define QFLG_PCU          (1u << 5)
#define QFLG_PCO          (1u << 6)
#define QFLG_ALL          0x0FFFu
#define PCRM(qepctl)      (((uint32_t)(qepctl) >> 12) & 3u)
#define PCRM_UNIT_TIMEOUT 3u
#define EQEP_GROUP        5u /* INT5.1 and INT5.2 */
#define FREE_SOFT(qepctl) ((uint32_t)(qepctl) >> 14)

static int64_t floor_half(int64_t x)
{
    return (x - (x & 1)) / 2;
}

static int64_t look(const chip_t *chip, uint32_t n)
{
    if (chip != chip_bound) {
        return 0;
    }
    int64_t position = chip_world->encoder(chip_world->context, chip->tick);
    return (chip->registers.eqep[n].QDECCTL & QDECCTL_XCR) != 0u ? floor_half(position) : position;
}

static bool clocked(const chip_t *chip, uint32_t n)
{
    return (chip->registers.sysctrl.PCLKCR1 & (PCLKCR1_EQEP1 << n)) != 0u;
}

/* During a halt it stops at the next roll-over. */
static bool ends(const chip_t *chip, uint32_t n)
{
    return chip->debug.halted && FREE_SOFT(chip->registers.eqep[n].QEPCTL) == 1u;
}

static void flag(chip_t *chip, uint32_t n, uint32_t flags)
{
    eqep_regs_t *regs = &chip->registers.eqep[n];
    regs->QFLG |= (uint16_t)flags;
    if ((regs->QFLG & regs->QEINT & ~QFLG_INT) != 0u && (regs->QFLG & QFLG_INT) == 0u) {
        regs->QFLG |= QFLG_INT;
        pie_request(chip, EQEP_GROUP, 1u << n);
    }
}

static void move(chip_t *chip, uint32_t n, int64_t counts)
{
    eqep_regs_t *regs = &chip->registers.eqep[n];
    uint32_t direction = counts > 0;
    uint32_t flags = direction != chip->eqep[n].direction ? QFLG_QDC : 0u;
    int64_t span = (int64_t)regs->QPOSMAX + 1;
    int64_t position = (int64_t)regs->QPOSCNT + counts;
    if (position >= span && counts > 0) {
        position %= span;
        flags |= QFLG_PCO;
    } else if (position < 0) {
        position = (position % span + span) % span;
        flags |= QFLG_PCU;
    }
    regs->QPOSCNT = (uint32_t)position;
    regs->QEPSTS = (uint16_t)(direction ? (regs->QEPSTS | QEPSTS_QDF) : (regs->QEPSTS & ~QEPSTS_QDF));
    chip->eqep[n].direction = direction;
    if ((flags & (QFLG_PCO | QFLG_PCU)) != 0u && ends(chip, n)) {
        chip->eqep[n].held = 1u;
    }
    if (flags != 0u) {
        flag(chip, n, flags);
    }
}

static void refresh_one(chip_t *chip, uint32_t n)
{
    chip_eqep_t *eqep = &chip->eqep[n];
    uint64_t now = cycle_now(chip);
    if (eqep->unit_next != CHIP_NEVER) {
        chip->registers.eqep[n].QUTMR = chip->registers.eqep[n].QUPRD - (uint32_t)(eqep->unit_next - now);
    }
    if (!eqep->counting || eqep->held) {
        return;
    }
    int64_t position = look(chip, n);
    int64_t counts = position - eqep->position;
    uint64_t cycles = now - eqep->cycle;
    eqep->position = position;
    eqep->cycle = now;
    if (counts == 0) {
        return;
    }
    if ((uint64_t)(counts < 0 ? -counts : counts) > cycles) {
        flag(chip, n, QEP_PHE);
        counts &= 3;
        counts = counts == 3 ? -1 : (counts == 2 ? 0 : counts);
    }
    if ((chip->registers.eqep[n].QDECCTL & QDECCTL_SWAP) != 0u) {
        counts = -counts;
    }
    if (counts != 0) {
        move(chip, n, counts);
    }
}

void eqep_refresh(chip_t *chip)
{
    for (uint32_t n = 0u; n < CHIP_EQEPS; n++) {
        refresh_one(chip, n);
    }
}

void eqep_schedule(chip_t *chip)
{
    chip_plan(chip, SOURCE_EQEP, tick_of(chip, earlier(chip->eqep[0].unit_next, chip->eqep[1].unit_next)));
}

static void plan_timeout(chip_t *chip, uint32_t n)
{
    const eqep_regs_t *regs = &chip->registers.eqep[n];
    chip->eqep[n].unit_next = CHIP_NEVER;
    if (clocked(chip, n) && !chip->eqep[n].unit_held && (regs->QEPCTL & QEPCTL_UTE) != 0u &&
        regs->QUPRD != 0u) {
        uint32_t left = regs->QUTMR < regs->QUPRD ? regs->QUPRD - regs->QUTMR : 1u;
        chip->eqep[n].unit_next = cycle_now(chip) + left;
    }
    eqep_schedule(chip);
}

static void time_out(chip_t *chip, uint32_t n)
{
    eqep_regs_t *regs = &chip->registers.eqep[n];
    if (ends(chip, n)) {
        chip->eqep[n].unit_held = 1u;
        chip->eqep[n].unit_next = CHIP_NEVER;
        regs->QUTMR = 0u;
    } else {
        chip->eqep[n].unit_next += regs->QUPRD;
    }
    eqep_schedule(chip);
    refresh_one(chip, n);
    if ((regs->QEPCTL & QEPCTL_QCLM) != 0u) {
        regs->QPOSLAT = regs->QPOSCNT;
    }
    if (PCRM(regs->QEPCTL) == PCRM_UNIT_TIMEOUT) {
        regs->QPOSLAT = regs->QPOSCNT;
        regs->QPOSCNT = chip->eqep[n].direction ? 0u : regs->QPOSMAX;
    }
    flag(chip, n, QEP_UTO);
}

void eqep_timeout(chip_t *chip)
{
    uint64_t now = cycle_now(chip);
    for (uint32_t n = 0u; n < CHIP_EQEPS; n++) {
        if (chip->eqep[n].unit_next <= now) {
            time_out(chip, n);
        }
    }
}

/* On return, all events that are due at the present tick have happened. */
static void settle(chip_t *chip)
{
    if (chip->next[SOURCE_EQEP] <= chip->tick) {
        eqep_timeout(chip);
    }
    eqep_refresh(chip);
}

static bool connected(const chip_t *chip, uint32_t n)
{
    if (n == 1u) {
        return gpio_mux(chip, 24u) == 2u && gpio_mux(chip, 25u) == 2u;
    }
    return (gpio_mux(chip, 20u) == 1u && gpio_mux(chip, 21u) == 1u) ||
           (gpio_mux(chip, 50u) == 1u && gpio_mux(chip, 51u) == 1u);
}

/* Starts or stops the position counter. When it starts, the present levels of the lines are taken over. */
static void begin_here(chip_t *chip, uint32_t n)
{
    chip->eqep[n].position = look(chip, n);
    chip->eqep[n].cycle = cycle_now(chip);
}

void eqep_connect(chip_t *chip)
{
    settle(chip);
    for (uint32_t n = 0u; n < CHIP_EQEPS; n++) {
        bool enabled = (chip->registers.eqep[n].QEPCTL & QEPCTL_QPEN) != 0u;
        uint32_t counting = clocked(chip, n) && connected(chip, n) && enabled;
        if (counting && !chip->eqep[n].counting) {
            begin_here(chip, n);
        }
        chip->eqep[n].counting = counting;
        plan_timeout(chip, n);
    }
}

void eqep_debug(chip_t *chip)
{
    for (uint32_t n = 0u; n < CHIP_EQEPS; n++) {
        chip_eqep_t *eqep = &chip->eqep[n];
        bool stops = chip->debug.halted && FREE_SOFT(chip->registers.eqep[n].QEPCTL) == 0u;
        if (eqep->held && !stops) {
            begin_here(chip, n);
        }
        eqep->held = stops;
        eqep->unit_held = stops;
        plan_timeout(chip, n);
    }
}

void eqep_reset(chip_t *chip)
{
    for (uint32_t n = 0u; n < CHIP_EQEPS; n++) {
        chip->eqep[n] = (chip_eqep_t){.unit_next = CHIP_NEVER};
    }
}

static bool accessible(chip_t *chip, uint32_t n, uint32_t address)
{
    if (!clocked(chip, n)) {
        chip_report(chip, CHIP_CLOCK_OFF, address);
        return false;
    }
    settle(chip);
    return true;
}

void eqep_write16(chip_t *chip, uint32_t address, uint16_t value)
{
    uint32_t n = (address - EQEP_AT) / 0x40u;
    uint32_t offset = (address - EQEP_AT) % 0x40u;
    eqep_regs_t *regs = &chip->registers.eqep[n];
    if (offset < OFFSET(eqep_regs_t, QWDTMR)) {
        chip_report(chip, CHIP_BAD_WIDTH, address);
        return;
    }
    if (!accessible(chip, n, address)) {
        return;
    }
    switch (offset) {
    case OFFSET(eqep_regs_t, QDECCTL):
        if ((value & ~QDECCTL_STORED) != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
            return;
        }
        regs->QDECCTL = value;
        chip->eqep[n].position = look(chip, n); /* XCR changes the unit */
        break;
    case OFFSET(eqep_regs_t, QEPCTL):
        if ((value & QEPCTL_WDE) != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
            return;
        }
        regs->QEPCTL = (uint16_t)(value & ~QEPCTL_SWI);
        if ((value & QEPCTL_SWI) != 0u) {
            regs->QPOSCNT = regs->QPOSINIT;
        }
        eqep_connect(chip);
        break;
    case OFFSET(eqep_regs_t, QEINT):
        regs->QEINT = value & QFLG_ALL & ~QFLG_INT;
        break;
    case OFFSET(eqep_regs_t, QCLR):
        regs->QFLG &= (uint16_t)~value;
        if ((value & QFLG_INT) != 0u) {
            flag(chip, n, 0u); /* a flag that is still set requests the interrupt again */
        }
        break;
    case OFFSET(eqep_regs_t, QFRC):
        flag(chip, n, value & QFLG_ALL & ~QFLG_INT);
        break;
    case OFFSET(eqep_regs_t, QEPSTS):
        break; /* write-one-to-clear bits of index and capture, never set here */
    case OFFSET(eqep_regs_t, QFLG):
        chip_report(chip, CHIP_READ_ONLY, address);
        break;
    default:
        if (value != 0u || offset > OFFSET(eqep_regs_t, QCPRDLAT)) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        }
        break;
    }
}

void eqep_write32(chip_t *chip, uint32_t address, uint32_t value)
{
    uint32_t n = (address - EQEP_AT) / 0x40u;
    uint32_t offset = (address - EQEP_AT) % 0x40u;
    eqep_regs_t *regs = &chip->registers.eqep[n];
    if (offset >= OFFSET(eqep_regs_t, QWDTMR) || (offset & 1u) != 0u) {
        chip_report(chip, CHIP_BAD_WIDTH, address);
        return;
    }
    if (!accessible(chip, n, address)) {
        return;
    }
    switch (offset) {
    case OFFSET(eqep_regs_t, QPOSCNT):
        regs->QPOSCNT = value;
        break;
    case OFFSET(eqep_regs_t, QPOSINIT):
        regs->QPOSINIT = value;
        break;
    case OFFSET(eqep_regs_t, QPOSMAX):
        regs->QPOSMAX = value;
        break;
    case OFFSET(eqep_regs_t, QUTMR):
        regs->QUTMR = value;
        plan_timeout(chip, n);
        break;
    case OFFSET(eqep_regs_t, QUPRD):
        regs->QUPRD = value;
        plan_timeout(chip, n);
        break;
    case OFFSET(eqep_regs_t, QPOSCMP):
        if (value != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        }
        break;
    default:
        chip_report(chip, CHIP_READ_ONLY, address);
        break;
    }
}

void chip_align_encoder(chip_t *chip, uint32_t n, int64_t count)
{
    assert(n >= 1u && n <= CHIP_EQEPS);
    settle(chip);
    const int64_t turn = (int64_t)chip->registers.eqep[n - 1u].QPOSMAX + 1;
    const int64_t within = count % turn;
    chip->registers.eqep[n - 1u].QPOSCNT = (uint32_t)(within < 0 ? within + turn : within);
}
