/* Host side of hal/f28335/bus.h: the selection of the part of the chip for a write, EALLOW, interrupt mask,
 * and time that passes. */
#include "hal/f28335/bus.h"

#include <assert.h>

#include "host_sim/chip/parts.h"

#define EQEP_WORDS (0x40u * CHIP_EQEPS)

static uint32_t address_of(const volatile uint16_t *reg)
{
    return (uint32_t)(reg - f28335_base);
}

static bool within(uint32_t address, uint32_t begin, uint32_t words)
{
    return address - begin < words;
}

/* Blocks in which all registers have 32 bits. */
static bool wide_block(uint32_t address)
{
    return within(address, VECTOR_AT, 0x100u) || within(address, GPIO_CONTROL_AT, 0x30u) ||
           within(address, GPIO_DATA_AT, 0x18u);
}

uint16_t bus_read16(const volatile uint16_t *reg)
{
    chip_t *chip = chip_bound;
    assert(chip != NULL);
    uint32_t address = address_of(reg);
    if (chip->cpu.halted) {
        return *reg;
    }
    return within(address, SCIA_AT, 0x10u)   ? sci_read(chip, address)
           : within(address, I2CA_AT, 0x40u) ? i2c_read(chip, address)
                                             : *reg;
}

void bus_write16(const volatile uint16_t *reg, uint16_t value)
{
    chip_t *chip = chip_bound;
    assert(chip != NULL);
    uint32_t address = address_of(reg);
    if (chip->cpu.halted) {
        return;
    }
    if (within(address, EPWM_AT, 0x180u)) {
        epwm_write(chip, address, value);
    } else if (within(address, ADC_AT, 0x20u)) {
        adc_write(chip, address, value);
    } else if (within(address, PIE_AT, 0x1Au)) {
        pie_write(chip, address, value);
    } else if (within(address, SYSCTRL_AT, 0x20u)) {
        sysctrl_write(chip, address, value);
    } else if (within(address, EQEP_AT, EQEP_WORDS)) {
        eqep_write16(chip, address, value);
    } else if (within(address, SCIA_AT, 0x10u)) {
        sci_write(chip, address, value);
    } else if (within(address, I2CA_AT, 0x40u)) {
        i2c_write(chip, address, value);
    } else if (within(address, TIMER_AT, 0x18u)) {
        timer_write16(chip, address, value);
    } else if (within(address, FLASH_AT, 8u)) {
        flash_write(chip, address, value);
    } else if (within(address, MIRROR_AT, 16u)) {
        chip_report(chip, CHIP_READ_ONLY, address);
    } else {
        chip_report(chip, wide_block(address) ? CHIP_BAD_WIDTH : CHIP_UNKNOWN_REGISTER, address);
    }
}

void bus_write32(const volatile uint32_t *reg, uint32_t value)
{
    chip_t *chip = chip_bound;
    assert(chip != NULL);
    uint32_t address = address_of((const volatile uint16_t *)reg);
    if (chip->cpu.halted) {
        return;
    }
    if (within(address, EQEP_AT, EQEP_WORDS)) {
        eqep_write32(chip, address, value);
    } else if (within(address, TIMER_AT, 0x18u)) {
        timer_write32(chip, address, value);
    } else if (within(address, GPIO_CONTROL_AT, 0x30u) || within(address, GPIO_DATA_AT, 0x18u)) {
        gpio_write(chip, address, value);
    } else if (within(address, VECTOR_AT, 0x100u)) {
        if (!chip->cpu.allow) {
            chip_report(chip, CHIP_PROTECTED_WRITE, address);
        } else {
            chip->registers.pie_vectors.vector[(address - VECTOR_AT) / 2u] = value;
        }
    } else {
        bool narrow = within(address, EPWM_AT, 0x180u) || within(address, ADC_AT, 0x20u) ||
                      within(address, PIE_AT, 0x1Au) || within(address, SYSCTRL_AT, 0x20u) ||
                      within(address, FLASH_AT, 8u) || within(address, MIRROR_AT, 16u) ||
                      within(address, SCIA_AT, 0x10u) || within(address, I2CA_AT, 0x40u);
        chip_report(chip, narrow ? CHIP_BAD_WIDTH : CHIP_UNKNOWN_REGISTER, address);
    }
}

void bus_allow(void)
{
    chip_bound->cpu.allow = 1u;
}

void bus_protect(void)
{
    chip_bound->cpu.allow = 0u;
}

void bus_enable_group(uint16_t group)
{
    assert(group >= 1u && group <= 14u);
    chip_bound->cpu.ier |= 1u << (group - 1u);
    cpu_update(chip_bound);
}

void bus_request_group(uint16_t group)
{
    assert(group >= 1u && group <= 14u);
    cpu_request(chip_bound, group);
}

void bus_interrupts_enable(void)
{
    chip_cpu_t *cpu = &chip_bound->cpu;
    if (cpu->section && chip_world->section != NULL) {
        const uint64_t from = cpu->busy_until > chip_bound->tick ? cpu->busy_until : chip_bound->tick;
        cpu->busy_until = from + chip_world->section(chip_world->context);
    }
    cpu->interrupts_off = 0u;
    cpu->section = 0u;
    cpu_update(chip_bound);
}

void bus_interrupts_disable(void)
{
    chip_bound->cpu.section |= chip_bound->cpu.interrupts_off ^ 1u;
    chip_bound->cpu.interrupts_off = 1u;
    cpu_update(chip_bound);
}

void bus_disable_groups(void)
{
    chip_bound->cpu.ier = 0u;
    cpu_update(chip_bound);
}

void bus_clear_pending(void)
{
    chip_bound->cpu.ifr = 0u;
    cpu_update(chip_bound);
}

void bus_debug_allow(void)
{
    chip_bound->cpu.dbgm = 0u;
}

void bus_debug_groups(uint16_t mask)
{
    chip_bound->cpu.dbgier = mask;
    cpu_update(chip_bound);
}

uint16_t bus_otp(uint32_t address)
{
    return adc_otp(address);
}

void bus_wait(uint32_t cycles)
{
    chip_t *chip = chip_bound;
    uint64_t end = cycle_now(chip) + cycles;
    while (cycle_now(chip) < end) { /* the clock may change during this time */
        uint64_t rare = chip->next[SOURCE_RARE];
        uint64_t until = tick_of(chip, end);
        chip_engine(chip, rare < until ? rare + 1u : until);
    }
    chip_refresh(chip);
}
