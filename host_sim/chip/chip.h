/* A TMS320F28335 in RAM, as far as this drive uses it. Driven only through its registers (hal/f28335/bus.h on the host
 * side); shows itself only through pins: gate edges out, analog voltages, encoder edges and the trip pin in.
 *
 * Time is counted in ticks of 150 MHz (6.67 ns) since reset, whatever the PLL says: a wrongly set clock makes the
 * peripherals slower, not the ticks. */
#ifndef HOST_SIM_CHIP_CHIP_H
#define HOST_SIM_CHIP_CHIP_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/f28335/registers.h"

#define CHIP_TICKS_PER_SECOND UINT64_C(150000000)
#define CHIP_NEVER            UINT64_MAX

/* What the chip found wrong; on silicon it would happen silently. */
typedef enum {
    CHIP_NOTHING = 0,
    CHIP_PROTECTED_WRITE,   /* EALLOW-protected register written outside EALLOW: ignored */
    CHIP_CLOCK_OFF,         /* register of a module whose clock is off written: ignored */
    CHIP_BAD_WIDTH,         /* 32-bit access to a 16-bit register or the reverse: ignored */
    CHIP_UNKNOWN_REGISTER,  /* write to an address that holds no register of this model: ignored */
    CHIP_READ_ONLY,         /* write to a read-only register: ignored */
    CHIP_PLL_MISUSE,        /* PLLCR written with DIVSEL not 0, or DIVSEL changed before lock: ignored */
    CHIP_NO_VECTOR,         /* interrupt taken whose PIE vector was never written: the CPU is lost (state halted) */
    CHIP_ADC_OVERRUN,       /* conversion started while the sequencer was busy: ignored by the sequencer */
    CHIP_ADC_NOT_POWERED,   /* conversion before the 5 ms power-up were over: result is wrong (reads 0) */
    CHIP_WATCHDOG_RESET,    /* overflow, wrong WDCHK or wrong WDKEY: the chip was reset (state halted) */
    CHIP_FLASH_TOO_FAST,    /* SYSCLK raised above what the flash wait states allow */
    CHIP_REPORT_KINDS
} chip_report_kind_t;

typedef struct {
    uint64_t tick;    /* when */
    uint32_t address; /* [words] register, or vector number */
    uint32_t kind;    /* chip_report_kind_t */
} chip_report_t;

/* The world around the pins; called in order of time while chip_run() runs. */
typedef struct {
    void *context;
    /* Voltage [V] at the ADC pin at this tick; channel 0..7 = A0..A7, 8..15 = B0..B7. */
    double (*analog)(void *context, uint64_t tick, uint32_t channel);
    /* Pin levels changed: bit 2(n-1) = EPWMnA, bit 2(n-1)+1 = EPWMnB, n = 1..3. A pin that is not muxed to its ePWM, or
     * is high-impedance, is reported in `driven` as 0 (its level is then what the board's bias makes of it). */
    void (*gates)(void *context, uint64_t tick, uint32_t level, uint32_t driven);
    /* Averaged mode only: three legs switch with these high times [ticks] and this dead band in the carrier period that
     * begins at this tick and lasts `period` ticks. Edges of such a period are not reported. */
    void (*carrier)(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead);
    /* Quadrature position [counts, four per line], free-running and signed, at this tick. */
    int64_t (*encoder)(void *context, uint64_t tick);
} chip_world_t;

/* The whole chip: copyable, no pointers, no padding. Fields are for the debugger; only this module writes them. */
#include "host_sim/chip/chip_state.h"

/* Power-on reset at tick 0: boot ROM done (SPRU963), watchdog running, all pins inputs. */
void chip_power_on(chip_t *chip);

/* From now on the bus of this thread (hal/f28335/bus.h) is this chip's, and `world` is what stands around its pins. Both
 * must outlive the binding; binding again replaces it. */
void chip_bind(chip_t *chip, const chip_world_t *world);

/* Let time pass on the bound chip: everything with tick < until happens, interrupts included. */
void chip_run(uint64_t until);

/* The board pulls an input pin (GPIO number) to a level. Takes effect at the chip's present tick. */
void chip_set_pin(chip_t *chip, uint32_t gpio, bool high);

/* true: legs whose set-up is the plain centre-aligned complementary one are reported once a carrier period. */
void chip_set_averaged(chip_t *chip, bool averaged);

/* Delay between an interrupt request and its entry, in ticks on top of the hardware's own; 0 is normal. Fault injection. */
void chip_set_interrupt_delay(chip_t *chip, uint32_t ticks);

/* Overrides the conversion results of one channel with a code (0..4095), or -1: none. Fault injection. */
void chip_stick_adc(chip_t *chip, uint32_t channel, int32_t code);

const char *chip_report_text(chip_report_kind_t kind);      /* one line, no full stop */
const char *chip_register_name(uint32_t address);           /* "EPWM1.TZCLR"; "?" if none */

#endif
