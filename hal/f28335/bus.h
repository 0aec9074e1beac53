/* The only difference between silicon and simulation: the access to registers, the passing of time while the
 * CPU waits, and the declaration of an interrupt. On silicon everything here compiles to the plain access. In
 * the simulation the virtual chip implements it, one chip per thread: a register file is connected to the
 * thread before firmware runs in it (chip.h). */
#ifndef HAL_F28335_BUS_H
#define HAL_F28335_BUS_H

#include <stdbool.h>

#include "hal/f28335/registers.h"

/* Memory regions by their content. */
typedef enum {
    BUS_PROGRAM,        /* flash, without the sectors that the drive writes itself */
    BUS_INTERRUPT_CODE, /* the copy of the code that runs from RAM */
    BUS_STACK_END,      /* the last words of the stack, which should never be used */
    BUS_REGIONS
} bus_region_t;

typedef struct {
    const uint16_t *words;
    uint32_t count; /* [16-bit words] */
} bus_memory_t;

#define BUS_STACK_END_WORDS 32u
#define BUS_STACK_PAINT     0x5AA5u /* word that hal_boot writes there */

/* Place of a memory region; silicon: hal/f28335/memory.c. */
bus_memory_t bus_memory(bus_region_t region);

/* L0-L3, from which the interrupt's code runs; and the copy of this code from flash to L0-L3. */
#define BUS_CODE_AT UINT32_C(0x8000)
void bus_copy_code(void); /* silicon: hal/f28335/boot.c */

/* The words of TI's flash API (flash_api.h); silicon: made by tools/flash-api. Without the API there are no
 * words. */
bus_memory_t bus_flash_api(void);

#if defined(__TMS320C2000__)

#define F28335_BASE ((const volatile uint16_t *)0)

#define bus_read16(reg)         (*(const volatile uint16_t *)(reg))
#define bus_write16(reg, value) (*(volatile uint16_t *)(reg) = (value))
#define bus_write32(reg, value) (*(volatile uint32_t *)(reg) = (value))
#define bus_allow()             __asm(" EALLOW")
#define bus_protect()           __asm(" EDIS")
#define bus_vector(isr)         ((uint32_t)(isr))

extern __cregister volatile unsigned int IER;
extern __cregister volatile unsigned int IFR;
#define bus_enable_group(n)         (IER |= (1u << ((n)-1u)))
#define bus_request_group(n)        (IFR |= (1u << ((n)-1u)))
#define bus_disable_groups()        (IER = 0u)
#define bus_clear_pending()         (IFR &= 0u)
#define bus_interrupts_enable()     __asm(" CLRC INTM")
#define bus_interrupts_disable()    __asm(" SETC INTM")
#define bus_debug_allow()           __asm(" CLRC DBGM")
#define bus_otp(address)            (*(const volatile uint16_t *)(address))
#define bus_flash(address)          (*(const volatile uint16_t *)(address))
#define bus_flash_at(address)       ((uint16_t *)(address))
#define bus_code_ram()              ((uint16_t *)BUS_CODE_AT)
#define bus_function(type, address) ((type)(address))
void bus_debug_groups(uint16_t mask);
void bus_wait(uint32_t cycles); /* at least this many SYSCLK cycles; hal/f28335/wait.c */

#else

/* The register file of the chip that runs on this thread. */
extern __thread const volatile uint16_t *f28335_base;
#define F28335_BASE                 f28335_base

typedef void (*bus_isr_t)(void);

/* Reads a register of SCI or I2C that changes when it is read, or that the module changes at any time. All
 * other registers are read by plain loads. */
uint16_t bus_read16(const volatile uint16_t *reg);
void bus_write16(const volatile uint16_t *reg, uint16_t value);
void bus_write32(const volatile uint32_t *reg, uint32_t value);
void bus_allow(void);                   /* EALLOW: protected registers accept writes */
void bus_protect(void);                 /* EDIS */
uint32_t bus_vector(bus_isr_t isr);     /* content of a 32-bit PIE vector for this function */
void bus_enable_group(uint16_t group);  /* IER bit of CPU interrupt INT1..INT14 */
void bus_request_group(uint16_t group); /* IFR bit of CPU interrupt INT1..INT14: raised by software */
void bus_disable_groups(void);          /* IER = 0 */
void bus_clear_pending(void);           /* IFR = 0 */
void bus_interrupts_enable(void);       /* clear INTM */
void bus_interrupts_disable(void);      /* set INTM */
void bus_debug_allow(void);             /* clear DBGM: a debugger has access while the CPU runs */
void bus_debug_groups(uint16_t mask);   /* DBGIER: bit n - 1 = INTn is served in a real-time halt */
uint16_t bus_otp(uint32_t address);     /* a word of the one-time programmable memory */
uint16_t bus_flash(uint32_t address); /* a word of the flash sectors that the drive writes itself, C and B */
void bus_wait(uint32_t cycles);       /* simulated time passes: at least this many SYSCLK cycles */
uint16_t *bus_code_ram(void);         /* the words of the chip's L0-L3 that this model has */
/* The function that a call of this address in L0-L3 runs. */
typedef void (*bus_function_t)(void);
bus_function_t bus_function_at(uint32_t address);
#define bus_flash_at(address)       ((uint16_t *)(uintptr_t)(address))
#define bus_function(type, address) ((type)bus_function_at(address))

#endif

#define AT_(type, word) ((const volatile type *)(F28335_BASE + (word)))
#define FLASH_REGS      AT_(flash_regs_t, 0x0A80u)
#define ADC_MIRROR      AT_(adc_mirror_regs_t, 0x0B00u)
#define CPU_TIMER(n)    AT_(cpu_timer_regs_t, 0x0C00u + 8u * (n))
#define PIE             AT_(pie_regs_t, 0x0CE0u)
#define PIE_VECTORS     AT_(pie_vectors_t, 0x0D00u)
#define EPWM(n)         AT_(epwm_regs_t, 0x6800u + 0x40u * ((n)-1u))    /* n = 1..6 */
#define EQEP(n)         AT_(eqep_regs_t, 0x6B00u + 0x40u * ((n)-1u))    /* n = 1, 2 */
#define GPIO_CONTROL(n) AT_(gpio_control_regs_t, 0x6F80u + 0x10u * (n)) /* n = 0 (A), 1 (B), 2 (C) */
#define GPIO_DATA(n)    AT_(gpio_data_regs_t, 0x6FC0u + 8u * (n))
#define SYSCTRL         AT_(sysctrl_regs_t, 0x7010u)
#define SCIA            AT_(sci_regs_t, 0x7050u)
#define ADC             AT_(adc_regs_t, 0x7100u)
#define I2CA            AT_(i2c_regs_t, 0x7900u)

#endif
