/* Where the linker put things, on silicon only; on the host the virtual chip brings its own. The symbols are
 * the linker command file's: values that have no storage, only an address.
 *
 * The flash is looked at as a whole, erased words among it, but for sectors C and B, which hold what the
 * drive stores itself, and sector A, which holds the entry. The end of the stack is painted by hal_boot. */
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
