/* Copies the code that runs from RAM, and writes a pattern to the end of the stack. This is the start-up
 * between the run-time library and main(), on silicon only. Before it, codestart.asm stops the watchdog, and
 * the library sets up the stack and the variables. The linker command file defines the symbols: only their
 * addresses have a meaning. */
#include "hal/f28335/bus.h"
#include "hal/hal.h"

extern const uint16_t ramfunc_load_start[]; /* in flash */
extern const uint16_t ramfunc_load_size[];  /* [16-bit words] */
extern uint16_t ramfunc_run_start[];
extern uint16_t stack_start[];
extern const uint16_t stack_size[]; /* [16-bit words] */

/* A loop instead of the library's memcpy, which the linker might place in the memory that is copied here. */
void bus_copy_code(void)
{
    const uint32_t words = (uint32_t)ramfunc_load_size;
    uint32_t n;

    for (n = 0u; n < words; n++) {
        ramfunc_run_start[n] = ramfunc_load_start[n];
    }
}

void hal_boot(void)
{
    uint32_t n;

    bus_copy_code();
    for (n = 1u; n <= BUS_STACK_END_WORDS; n++) { /* at the beginning of main the stack is almost empty */
        stack_start[(uint32_t)stack_size - n] = BUS_STACK_PAINT;
    }
}
