/* Clock tree, module clocks and flash wait states: SPRUFB0 ch. 1 and 5.
 *
 * SYSCLK = crystal x PLLCR / DIVSEL; while the PLL is bypassed or locking it is crystal / DIVSEL. The periods
 * of both clocks are stored as fractions of the tick, so that there is no drift with a crystal whose period
 * is not a whole number of ticks. */
#include "host_sim/chip/parts.h"

#define LOCK_CYCLES      131072u /* of the crystal */
#define PLL_HIGHEST      10u
#define DIVSEL(pllsts)   (((uint32_t)(pllsts) >> 7) & 3u)
#define FLASH_PAGE(bank) (((uint32_t)(bank) >> 8) & 15u)
#define FLASH_RAND(bank) ((uint32_t)(bank)&15u)
#define PLLSTS_STORED    (PLLSTS_PLLOFF | PLLSTS_MCLKOFF)

/* Flash needs 37 ns (paged or random) and OTP 60 ns a read, which takes wait states + 1 SYSCLK cycles
 * (SPRS439). One tick is 20/3 ns. */
static void flash_check(chip_t *chip, uint32_t blamed)
{
    const flash_regs_t *flash = &chip->registers.flash;
    uint32_t page = FLASH_PAGE(flash->FBANKWAIT);
    uint32_t random = FLASH_RAND(flash->FBANKWAIT);
    uint32_t waits = page < random ? page : random;
    uint32_t otp = flash->FOTPWAIT & 31u;
    if ((waits + 1u) * chip->clock.ticks * 20u < 37u * 3u * chip->clock.cycles ||
        (otp + 1u) * chip->clock.ticks * 20u < 60u * 3u * chip->clock.cycles) {
        chip_report(chip, CHIP_FLASH_TOO_FAST, blamed);
    }
}

static uint32_t common_divisor(uint32_t a, uint32_t b)
{
    while (b != 0u) {
        uint32_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

void sysctrl_crystal(chip_t *chip, uint32_t hz)
{
    uint32_t common = common_divisor((uint32_t)CHIP_TICKS_PER_SECOND, hz);
    chip->clock.crystal_ticks = (uint32_t)CHIP_TICKS_PER_SECOND / common;
    chip->clock.crystal_cycles = hz / common;
}

/* SYSCLK from PLLCR, DIVSEL and lock, from cycle `cycle` on, which begins now. */
static void set_clock(chip_t *chip, uint64_t cycle)
{
    static const uint32_t divisor[4] = {4u, 4u, 2u, 1u};
    const sysctrl_regs_t *sysctrl = &chip->registers.sysctrl;
    chip_clock_t *clock = &chip->clock;
    bool multiplied = sysctrl->PLLCR != 0u && (sysctrl->PLLSTS & PLLSTS_PLLLOCKS) != 0u;
    uint32_t cycles = clock->crystal_cycles * (multiplied ? sysctrl->PLLCR : 1u);
    uint32_t ticks = clock->crystal_ticks * divisor[DIVSEL(sysctrl->PLLSTS)];
    uint32_t common = common_divisor(ticks, cycles);
    clock->cycle = cycle;
    clock->tick = chip->tick;
    clock->ticks = ticks / common;
    clock->cycles = cycles / common;
}

/* Every part counts cycles, so only the ticks of its next events change. */
static void clock_change(chip_t *chip, uint32_t blamed)
{
    sci_refresh(chip);
    i2c_refresh(chip);
    set_clock(chip, cycle_now(chip));
    if (chip->carrier.active) {
        carrier_leave(chip);
    }
    timebase_schedule(chip);
    timer_schedule(chip);
    adc_schedule(chip);
    eqep_schedule(chip);
    flash_check(chip, blamed);
    outputs_show(chip); /* if an average was left */
}

void sysctrl_reset(chip_t *chip, bool boot_rom)
{
    f28335_t *f = &chip->registers;
    f->sysctrl.PLLSTS = PLLSTS_PLLLOCKS | (boot_rom ? PLLSTS_DIVSEL(2u) : 0u);
    f->sysctrl.HISPCP = 1u;
    f->sysctrl.LOSPCP = 2u;
    f->sysctrl.PCLKCR3 = PCLKCR3_GPIOIN | 0x0700u; /* three CPU timers */
    f->sysctrl.SCSR = SCSR_WDOVERRIDE | 0x0004u;   /* WDINTS is high when idle */
    f->flash.FSTDBYWAIT = 0x01FFu;
    f->flash.FACTIVEWAIT = 0x01FFu;
    f->flash.FBANKWAIT = 0x0F0Fu;
    f->flash.FOTPWAIT = 0x001Fu;
    uint64_t cycle = chip->clock.ticks == 0u ? 0u : cycle_now(chip);
    chip->clock.locked = CHIP_NEVER;
    set_clock(chip, cycle);
}

void sysctrl_locked(chip_t *chip)
{
    chip->clock.locked = CHIP_NEVER;
    chip->registers.sysctrl.PLLSTS |= PLLSTS_PLLLOCKS;
    clock_change(chip, SYSCTRL_AT + OFFSET(sysctrl_regs_t, PLLCR));
}

static void write_pllsts(chip_t *chip, uint16_t value)
{
    sysctrl_regs_t *sysctrl = &chip->registers.sysctrl;
    uint32_t address = SYSCTRL_AT + OFFSET(sysctrl_regs_t, PLLSTS);
    uint16_t old = sysctrl->PLLSTS;
    uint16_t wanted = (uint16_t)((old & PLLSTS_PLLLOCKS) | (value & (PLLSTS_STORED | PLLSTS_DIVSEL_ALL)));
    bool locking = (old & PLLSTS_PLLLOCKS) == 0u;
    bool misuse = ((value ^ old) & PLLSTS_DIVSEL_ALL) != 0u && locking;
    misuse = misuse || (DIVSEL(value) == 3u && sysctrl->PLLCR != 0u);
    misuse = misuse || ((value & PLLSTS_PLLOFF) != 0u && sysctrl->PLLCR != 0u);
    misuse = misuse || (value & PLLSTS_OSCOFF) != 0u;
    if (misuse) {
        chip_report(chip, CHIP_PLL_MISUSE, address);
        return;
    }
    sysctrl->PLLSTS = wanted;
    if (((wanted ^ old) & PLLSTS_DIVSEL_ALL) != 0u) {
        clock_change(chip, address);
    }
}

static void write_pllcr(chip_t *chip, uint16_t value)
{
    sysctrl_regs_t *sysctrl = &chip->registers.sysctrl;
    uint32_t address = SYSCTRL_AT + OFFSET(sysctrl_regs_t, PLLCR);
    bool locking = (sysctrl->PLLSTS & PLLSTS_PLLLOCKS) == 0u;
    if (value == sysctrl->PLLCR) {
        return;
    }
    if (DIVSEL(sysctrl->PLLSTS) != 0u || value > PLL_HIGHEST || locking ||
        (sysctrl->PLLSTS & PLLSTS_PLLOFF) != 0u) {
        chip_report(chip, CHIP_PLL_MISUSE, address);
        return;
    }
    sysctrl->PLLCR = value;
    sysctrl->PLLSTS &= (uint16_t)~PLLSTS_PLLLOCKS;
    chip->clock.locked = chip->tick + crystal_ticks(chip, LOCK_CYCLES);
    clock_change(chip, address);
    chip_schedule_rare(chip);
}

void sysctrl_write(chip_t *chip, uint32_t address, uint16_t value)
{
    sysctrl_regs_t *sysctrl = &chip->registers.sysctrl;
    if (!chip->cpu.allow) {
        chip_report(chip, CHIP_PROTECTED_WRITE, address);
        return;
    }
    if (watchdog_write(chip, address, value)) {
        return;
    }
    epwm_settle(chip);
    switch (address - SYSCTRL_AT) {
    case OFFSET(sysctrl_regs_t, PLLSTS):
        write_pllsts(chip, value);
        break;
    case OFFSET(sysctrl_regs_t, PLLCR):
        write_pllcr(chip, value);
        break;
    case OFFSET(sysctrl_regs_t, HISPCP):
        sysctrl->HISPCP = value & 7u;
        break;
    case OFFSET(sysctrl_regs_t, LOSPCP):
        sci_refresh(chip);
        sysctrl->LOSPCP = value & 7u;
        break;
    case OFFSET(sysctrl_regs_t, PCLKCR0):
        sci_refresh(chip);
        sysctrl->PCLKCR0 = value;
        epwm_clock(chip);
        break;
    case OFFSET(sysctrl_regs_t, PCLKCR1):
        sysctrl->PCLKCR1 = value;
        epwm_clock(chip);
        eqep_connect(chip);
        break;
    case OFFSET(sysctrl_regs_t, PCLKCR3):
        sysctrl->PCLKCR3 = value;
        timer_clock(chip);
        break;
    case OFFSET(sysctrl_regs_t, LPMCR0):
    case OFFSET(sysctrl_regs_t, MAPCNF):
        if (value != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        }
        break;
    default:
        chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        break;
    }
}

void flash_write(chip_t *chip, uint32_t address, uint16_t value)
{
    flash_regs_t *flash = &chip->registers.flash;
    if (!chip->cpu.allow) {
        chip_report(chip, CHIP_PROTECTED_WRITE, address);
        return;
    }
    switch (address - FLASH_AT) {
    case OFFSET(flash_regs_t, FOPT):
        flash->FOPT = value & FOPT_ENPIPE;
        break;
    case OFFSET(flash_regs_t, FPWR):
        flash->FPWR = value & 3u;
        break;
    case OFFSET(flash_regs_t, FSTATUS):
        break; /* only the write-one-to-clear bit of a pump voltage that never fails here */
    case OFFSET(flash_regs_t, FSTDBYWAIT):
        flash->FSTDBYWAIT = value & 0x01FFu;
        break;
    case OFFSET(flash_regs_t, FACTIVEWAIT):
        flash->FACTIVEWAIT = value & 0x01FFu;
        break;
    case OFFSET(flash_regs_t, FBANKWAIT):
        flash->FBANKWAIT = value & 0x0F0Fu;
        flash_check(chip, address);
        break;
    case OFFSET(flash_regs_t, FOTPWAIT):
        flash->FOTPWAIT = value & 0x001Fu;
        flash_check(chip, address);
        break;
    default:
        chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        break;
    }
}
