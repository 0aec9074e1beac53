/* eQEP1: SPRUG05. Four counts a line from the world's position, position counter with its maximum, unit timer
 * with latch, flags and interrupt.
 *
 * The pins are looked at when somebody could notice: at a unit time-out, before an interrupt, after a wait.
 * Between two looks fewer counts than SYSCLK cycles must have come; more (the world jumped) are what two
 * edges in one cycle are on silicon: a phase error, and the counter follows the quadrature lines alone, that
 * is the jump modulo 4.
 *
 * QUTMR goes from 0 to QUPRD, where the time-out sets it to 0 in the same cycle: the period is QUPRD cycles
 * (facts section 13). No index or strobe pulse ever comes, so the fields that react to one have no effect. */
#include "host_sim/chip/parts.h"

#define QEPCTL_WDE        (1u << 0)
#define QDECCTL_STORED    (QDECCTL_SWAP | QDECCTL_XCR)
#define QFLG_INT          (1u << 0)
#define QFLG_QDC          (1u << 3)
#define QFLG_PCU          (1u << 5)
#define QFLG_PCO          (1u << 6)
#define QFLG_ALL          0x0FFFu
#define PCRM(qepctl)      (((uint32_t)(qepctl) >> 12) & 3u)
#define PCRM_UNIT_TIMEOUT 3u
#define EQEP_INTERRUPT    5u, 1u /* INT5.1 */

static int64_t floor_half(int64_t x)
{
    return (x - (x & 1)) / 2;
}

static int64_t look(const chip_t *chip)
{
    if (chip != chip_bound) {
        return 0;
    }
    int64_t position = chip_world->encoder(chip_world->context, chip->tick);
    return (chip->registers.eqep[0].QDECCTL & QDECCTL_XCR) != 0u ? floor_half(position) : position;
}

static void flag(chip_t *chip, uint32_t flags)
{
    eqep_regs_t *regs = &chip->registers.eqep[0];
    regs->QFLG |= (uint16_t)flags;
    if ((regs->QFLG & regs->QEINT & ~QFLG_INT) != 0u && (regs->QFLG & QFLG_INT) == 0u) {
        regs->QFLG |= QFLG_INT;
        pie_request(chip, EQEP_INTERRUPT);
    }
}

static void move(chip_t *chip, int64_t counts)
{
    eqep_regs_t *regs = &chip->registers.eqep[0];
    uint32_t direction = counts > 0;
    uint32_t flags = direction != chip->eqep.direction ? QFLG_QDC : 0u;
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
    chip->eqep.direction = direction;
    if (flags != 0u) {
        flag(chip, flags);
    }
}

void eqep_refresh(chip_t *chip)
{
    chip_eqep_t *eqep = &chip->eqep;
    uint64_t now = cycle_now(chip);
    if (eqep->unit_next != CHIP_NEVER) {
        chip->registers.eqep[0].QUTMR = chip->registers.eqep[0].QUPRD - (uint32_t)(eqep->unit_next - now);
    }
    if (!eqep->counting) {
        return;
    }
    int64_t position = look(chip);
    int64_t counts = position - eqep->position;
    uint64_t cycles = now - eqep->cycle;
    eqep->position = position;
    eqep->cycle = now;
    if (counts == 0) {
        return;
    }
    if ((uint64_t)(counts < 0 ? -counts : counts) > cycles) {
        flag(chip, QEP_PHE);
        counts &= 3;
        counts = counts == 3 ? -1 : (counts == 2 ? 0 : counts);
    }
    if ((chip->registers.eqep[0].QDECCTL & QDECCTL_SWAP) != 0u) {
        counts = -counts;
    }
    if (counts != 0) {
        move(chip, counts);
    }
}

static void plan_timeout(chip_t *chip)
{
    const eqep_regs_t *regs = &chip->registers.eqep[0];
    bool clocked = (chip->registers.sysctrl.PCLKCR1 & PCLKCR1_EQEP1) != 0u;
    chip->eqep.unit_next = CHIP_NEVER;
    if (clocked && (regs->QEPCTL & QEPCTL_UTE) != 0u && regs->QUPRD != 0u) {
        uint32_t left = regs->QUTMR < regs->QUPRD ? regs->QUPRD - regs->QUTMR : 1u;
        chip->eqep.unit_next = cycle_now(chip) + left;
    }
    chip_plan(chip, SOURCE_EQEP, tick_of(chip, chip->eqep.unit_next));
}

void eqep_timeout(chip_t *chip)
{
    eqep_regs_t *regs = &chip->registers.eqep[0];
    chip->eqep.unit_next += regs->QUPRD;
    chip->next[SOURCE_EQEP] = tick_of(chip, chip->eqep.unit_next);
    eqep_refresh(chip);
    if ((regs->QEPCTL & QEPCTL_QCLM) != 0u) {
        regs->QPOSLAT = regs->QPOSCNT;
    }
    if (PCRM(regs->QEPCTL) == PCRM_UNIT_TIMEOUT) {
        regs->QPOSLAT = regs->QPOSCNT;
        regs->QPOSCNT = chip->eqep.direction ? 0u : regs->QPOSMAX;
    }
    flag(chip, QEP_UTO);
}

/* What is due at the present tick has happened. */
static void settle(chip_t *chip)
{
    if (chip->next[SOURCE_EQEP] <= chip->tick) {
        eqep_timeout(chip);
    }
    eqep_refresh(chip);
}

/* Does the position counter run? On the way from off to on, the lines are taken as they stand. */
void eqep_connect(chip_t *chip)
{
    settle(chip);
    bool clocked = (chip->registers.sysctrl.PCLKCR1 & PCLKCR1_EQEP1) != 0u;
    bool pins = (gpio_mux(chip, 20u) == 1u && gpio_mux(chip, 21u) == 1u) ||
                (gpio_mux(chip, 50u) == 1u && gpio_mux(chip, 51u) == 1u);
    bool enabled = (chip->registers.eqep[0].QEPCTL & QEPCTL_QPEN) != 0u;
    uint32_t counting = clocked && pins && enabled;
    if (counting && !chip->eqep.counting) {
        chip->eqep.position = look(chip);
        chip->eqep.cycle = cycle_now(chip);
    }
    chip->eqep.counting = counting;
    plan_timeout(chip);
}

void eqep_reset(chip_t *chip)
{
    chip->eqep.counting = 0u;
    chip->eqep.direction = 0u;
    chip->eqep.unit_next = CHIP_NEVER;
}

static bool accessible(chip_t *chip, uint32_t address)
{
    if ((chip->registers.sysctrl.PCLKCR1 & PCLKCR1_EQEP1) == 0u) {
        chip_report(chip, CHIP_CLOCK_OFF, address);
        return false;
    }
    settle(chip);
    return true;
}

void eqep_write16(chip_t *chip, uint32_t address, uint16_t value)
{
    eqep_regs_t *regs = &chip->registers.eqep[0];
    uint32_t offset = address - EQEP_AT;
    if (offset < OFFSET(eqep_regs_t, QWDTMR)) {
        chip_report(chip, CHIP_BAD_WIDTH, address);
        return;
    }
    if (!accessible(chip, address)) {
        return;
    }
    switch (offset) {
    case OFFSET(eqep_regs_t, QDECCTL):
        if ((value & ~QDECCTL_STORED) != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
            return;
        }
        regs->QDECCTL = value;
        chip->eqep.position = look(chip); /* XCR changes the unit */
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
            flag(chip, 0u); /* what is still set asks again */
        }
        break;
    case OFFSET(eqep_regs_t, QFRC):
        flag(chip, value & QFLG_ALL & ~QFLG_INT);
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
    eqep_regs_t *regs = &chip->registers.eqep[0];
    uint32_t offset = address - EQEP_AT;
    if (offset >= OFFSET(eqep_regs_t, QWDTMR) || (offset & 1u) != 0u) {
        chip_report(chip, CHIP_BAD_WIDTH, address);
        return;
    }
    if (!accessible(chip, address)) {
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
        plan_timeout(chip);
        break;
    case OFFSET(eqep_regs_t, QUPRD):
        regs->QUPRD = value;
        plan_timeout(chip);
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
