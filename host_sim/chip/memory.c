/* Memory that the firmware looks at as such: flash, the copy of the interrupt's code in RAM, the end of the
 * stack. In the simulation code is the host's own; in its place stand a few words that nothing but an
 * injected error changes. */
#include "hal/f28335/bus.h"
#include "host_sim/chip/parts.h"

static void fill(chip_t *chip, uint32_t region)
{
    for (uint32_t n = 0u; n < CHIP_MEMORY_WORDS; n++) {
        chip->memory[region][n] = (uint16_t)(0x1234u + 0x9E37u * n + 0x0101u * region);
    }
}

void memory_power_on(chip_t *chip)
{
    for (uint32_t region = 0u; region < BUS_REGIONS; region++) {
        fill(chip, region);
    }
}

uint16_t *bus_code_ram(void)
{
    return chip_bound->memory[BUS_INTERRUPT_CODE];
}

void bus_copy_code(void)
{
    fill(chip_bound, BUS_INTERRUPT_CODE);
}

bus_memory_t bus_memory(bus_region_t region)
{
    return (bus_memory_t){chip_bound->memory[region], CHIP_MEMORY_WORDS};
}

void chip_flip_memory(chip_t *chip, uint32_t region, uint32_t word, uint32_t bit)
{
    chip->memory[region][word] = (uint16_t)(chip->memory[region][word] ^ 1u << bit);
}
