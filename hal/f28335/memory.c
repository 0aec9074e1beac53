/* The places of memory regions, on silicon only; on the host the virtual chip defines them. The linker
 * command file defines the symbols: only their addresses have a meaning.
 *
 * The region of the program is the whole flash, erased words included, except for sectors C and B, in which
 * the drive stores parameters, and sector A, which contains the entry point. hal_boot writes the pattern at
 * the end of the stack. */
#include "hal/f28335/bus.h"

extern const uint16_t ramfunc_load_size[]; /* [16-bit words] */
extern const uint16_t ramfunc_run_start[];
extern const uint16_t stack_start[];
extern const uint16_t stack_size[]; /* [16-bit words] */

#define FLASH_H_D       ((const uint16_t *)0x300000)
#define FLASH_H_D_WORDS UINT32_C(0x28000)

bus_memory_t bus_memory(bus_region_t region)
{
    bus_memory_t memory = {FLASH_H_D, FLASH_H_D_WORDS};
    if (region == BUS_INTERRUPT_CODE) {
        memory.words = ramfunc_run_start;
        memory.count = (uint32_t)ramfunc_load_size;
    } else if (region == BUS_STACK_END) {
        memory.words = &stack_start[(uint32_t)stack_size - BUS_STACK_END_WORDS];
        memory.count = BUS_STACK_END_WORDS;
    }
    return memory;
}
