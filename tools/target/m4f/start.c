/* Starts main after a reset, and passes its result to the simulator as exit code. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t bss_begin[], bss_end[], stack_top[];
extern void initialise_monitor_handles(void); /* newlib: console and files by semihosting */
int main(void);
void reset(void);

#define CPACR (*(volatile uint32_t *)0xE000ED88u) /* coprocessor access */

static void stuck(void)
{
    abort();
}

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    stack_top, (void *)reset, (void *)stuck, (void *)stuck, (void *)stuck, (void *)stuck, (void *)stuck,
};

void reset(void)
{
    CPACR |= 0xFu << 20; /* enables the FPU before code uses it */
    __asm volatile("dsb\n\tisb" ::: "memory");
    for (uint32_t *word = bss_begin; word < bss_end; word++) {
        *word = 0u;
    }
    initialise_monitor_handles();
    exit(main());
}

/* newlib's exit requires these; there are no constructors. */
void _init(void);
void _fini(void);
void _init(void)
{
}
void _fini(void)
{
}
