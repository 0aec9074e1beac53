/* A model of the TMS320F28335, of the parts that this drive uses. Software accesses it only through the
 * registers (hal/f28335/bus.h, whose host side is in this module). The world accesses it only through pins:
 * gate edges are outputs; analog voltages, encoder edges and trip pins are inputs.
 *
 * Time is counted in ticks of 150 MHz (6.67 ns) since reset, independent of the PLL. A wrong clock setting
 * makes the peripherals slower, but not the ticks. Peripherals count SYSCLK cycles; clock.c converts between
 * cycles and ticks.
 *
 * Software runs at the speed of the host, and its simulated time is assigned to it. An interrupt function
 * takes time by bus_wait(), or if the caller of the chip calls chip_run() within the function. Accesses
 * before and after occur at these two ticks. In between the CPU is busy, so that interrupts masked by INTM,
 * IER and PIEACK wait. A section of the background with INTM set takes the time that the hook `section`
 * returns. All other software takes no time. Some registers change by themselves: TBCTR, TBSTS, TIM, QPOSCNT,
 * QUTMR, ADCASEQSR, WDCNTR. They are updated before every interrupt function, after every bus_wait() and by
 * chip_look(); otherwise they are constant.
 *
 * A debugger may halt the CPU. Then no software runs, the time of the world continues, and each peripheral
 * follows its own emulation bits.
 *
 * Of the SCIs only SCI-A with FIFOs and frames of 8 bits is modelled (sci.c), and of I2C-A only the master
 * with FIFOs (i2c.c). Not modelled: eCAN, DMA, eCAP, SEQ2, continuous ADC conversion, PWM chopper,
 * high-resolution PWM, input qualification (every input is asynchronous), SYNCI pin, low-power modes,
 * missing-clock detector, the wrong first ADC sample (SPRZ272), pipeline and wait states; of the eQEPs index
 * and strobe inputs, capture unit and watchdog. Writing a value other than 0 to such a register is reported
 * as CHIP_UNKNOWN_REGISTER. */
#ifndef HOST_SIM_CHIP_CHIP_H
#define HOST_SIM_CHIP_CHIP_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/f28335/registers.h"

#define CHIP_TICKS_PER_SECOND UINT64_C(150000000)
#define CHIP_NEVER            UINT64_MAX

/* Wrong uses that the model reports. On silicon nothing would report them. */
typedef enum {
    CHIP_NOTHING = 0,
    CHIP_PROTECTED_WRITE,  /* EALLOW-protected register written outside EALLOW: ignored */
    CHIP_CLOCK_OFF,        /* register of a module whose clock is off written: ignored */
    CHIP_BAD_WIDTH,        /* 32-bit access to a 16-bit register or the reverse: ignored */
    CHIP_UNKNOWN_REGISTER, /* write to an address that holds no register of this model: ignored */
    CHIP_READ_ONLY,        /* write to a read-only register: ignored */
    CHIP_PLL_MISUSE,       /* PLLCR written with DIVSEL not 0, or DIVSEL changed before lock: ignored */
    CHIP_NO_VECTOR,        /* interrupt taken whose PIE vector was never written: the CPU is lost (halted) */
    CHIP_ADC_OVERRUN, /* start of conversion while the sequencer is busy: the first one waits, others are lost
                       */
    CHIP_ADC_NOT_POWERED, /* conversion within the 5 ms of the power-up: the result is wrong (0) */
    CHIP_ADC_TOO_FAST,    /* conversion with ADCCLK above 25 MHz; the result of this model is right, that of
                           * silicon is not
                           */
    CHIP_WATCHDOG_RESET,  /* overflow, wrong WDCHK or wrong WDKEY: the chip was reset (CPU halted until
                             chip_boot) */
    CHIP_FLASH_TOO_FAST,  /* SYSCLK too high for the flash wait states */
    CHIP_SERIAL_LOST,     /* octet written while the transmit FIFO was full, or the transmitter off: lost */
    CHIP_FLASH_MISUSE,    /* flash erased or programmed with interrupts or watchdog on, or without the API:
                             refused */
    CHIP_FLASH_BEYOND,    /* word programmed behind those of a page that this model keeps: refused */
    CHIP_I2C_MISUSE,      /* I2C clock changed out of reset (ignored), or START with it outside 7 to 12 MHz */
    CHIP_REPORT_KINDS
} chip_report_kind_t;

typedef struct {
    uint64_t tick;    /* when [1/150 MHz] */
    uint32_t address; /* [words] register, or PIE vector number for CHIP_NO_VECTOR */
    uint32_t kind;    /* chip_report_kind_t */
} chip_report_t;

/* Events inside the chip, for a recorder. */
typedef enum {
    CHIP_EVENT_ADC_START, /* a conversion sequence begins */
    CHIP_EVENT_INTERRUPT, /* an interrupt function is called; value: number of its PIE vector */
    CHIP_EVENT_RETURN,    /* it has returned; value the same */
    CHIP_EVENT_TRIP       /* value: bit n - 1 = ePWMn (1..6) is held by its trip zone; on every change */
} chip_event_t;

/* The world around the pins. Its functions are called in the order of time while chip_run() or bus_wait()
 * runs. They may change the chip only by chip_set_pin; `interrupt` may do everything that the interrupt
 * function may do. */
typedef struct {
    void *context;
    /* Returns the voltage [V] at an ADC pin at this tick, the end of its sample window. Channels 0..7 are
     * A0..A7, 8..15 are B0..B7. */
    double (*analog)(void *context, uint64_t tick, uint32_t channel);
    /* Receives changed pin levels: bit 2(n-1) = EPWMnA, bit 2(n-1)+1 = EPWMnB, n = 1..6 (GPIO0..11), also of
     * pins that are plain GPIO outputs. A high-impedance pin (input, or tripped with TZCTL = 0) has 0 in
     * `driven` and in `level`; the bias resistors of the board determine its level. */
    void (*gates)(void *context, uint64_t tick, uint32_t level, uint32_t driven);
    /* Averaged mode only. Receives the three legs on ePWM1..3, or on ePWM4..6 if only these have pins. A
     * carrier period begins at this tick (counter zero) and lasts `period` ticks. In it gate A of a leg is on
     * for high[n] ticks, minus one dead band if the leg switches. Gate B is the complement. Both are off
     * during `dead` ticks at each change. With `ends` gate A is on at both ends of the period, otherwise
     * around its middle. A gate is on when its pin is high, or low if `active_low` is set. The values remain
     * until the next call of carrier or gates.
     *
     * A SYSCLK cycle may be a fraction of a tick. `period` is then still exact (a whole number at 100 MHz),
     * but high and dead are rounded to the nearest tick. Their error is half a tick at most, at 100 MHz for
     * odd counts only. A leg that switches has 0 < high < period. */
    void (*carrier)(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                    bool ends);
    /* Returns the quadrature position [counts, four per line], free-running and signed, at this tick. Called
     * at every latch, before every interrupt function, after every wait and by chip_look(). */
    int64_t (*encoder)(void *context, uint64_t tick);
    /* Calls the function of an interrupt that the CPU has entered, for example to measure its time. NULL: the
     * chip calls it. */
    void (*interrupt)(void *context, uint32_t vector, void (*function)(void));
    /* Called at the end of a section with INTM set. Returns the ticks that the section takes. Its writes act
     * at its beginning; interrupts wait until these ticks have passed. NULL: no time. */
    uint64_t (*section)(void *context);
    /* Receives events for recordings; may be NULL. */
    void (*event)(void *context, uint64_t tick, chip_event_t what, uint32_t value);
    /* The board's gates are on while their pin is low. Averages are reported only for legs whose dead band
     * has the polarity of the board (ALC if this is set, else AHC). With the other polarity both gates of a
     * leg are on together, which only the edges can show. */
    uint64_t active_low;
} chip_world_t;

/* The whole chip: it can be copied, and has no pointers and no padding. The fields are visible for the
 * debugger; only this module writes them. */
#include "host_sim/chip/chip_state.h"

/* Power-on reset at tick 0. The boot ROM has run (SPRU963), SYSCLK is half the crystal frequency, the ADC is
 * calibrated, the watchdog runs, all pins are inputs. The crystal of the board has 20..35 MHz in whole kHz;
 * lock time, watchdog and SYSCLK follow it exactly. */
void chip_power_on(chip_t *chip, uint32_t crystal_hz);

/* The same with a debugger that halts the CPU before the boot ROM has run. SYSCLK is a quarter of the crystal
 * frequency. The calibration of the ADC (ADCREFSEL, ADCOFFTRIM) is not copied from OTP; until software copies
 * it, conversions have the offset and gain of the uncalibrated converter. */
void chip_power_on_by_debugger(chip_t *chip, uint32_t crystal_hz);

/* Switches the supply of the bound chip off and on again: reset, boot ROM, new memory of the firmware's code,
 * empty FIFOs and serial line; chip_cut_power() ends. The flash sectors of the drive keep their content, and
 * time continues. Pins of the board, injected faults, and the counts of reports and interrupts remain. */
void chip_power_cycle(chip_t *chip);

/* The CPU starts again after a watchdog reset, or after it was lost: the state in which main() begins.
 * Registers remain. */
void chip_boot(chip_t *chip);

/* A debugger's restart: the CPU begins at its entry again. INTM and DBGM are set, EALLOW is closed. Clocks,
 * registers, counters, trips, IER, IFR and PIE remain. A CPU that was lost runs again; a halt continues. */
void chip_restart(chip_t *chip);

/* A debugger halts the CPU, and lets it run again, between two calls of chip_run(). During the halt no
 * software runs and requests wait; writes over the bus come from the debugger. ePWM counters (TBCTL), eQEPs
 * (QEPCTL), CPU timers (TCR) and the ADC (SUSMOD) follow their emulation bits. The watchdog stops. Stopped
 * peripherals continue from their state. */
void chip_debug_halt(chip_t *chip);
void chip_debug_run(chip_t *chip);

/* Real-time mode: a halt stops only the background. Interrupts whose CPU group is enabled in DBGIER and IER
 * are still served, independent of INTM. */
void chip_debug_realtime(chip_t *chip, bool on);

/* Nothing is connected to the pins: 0 V, no encoder. */
extern const chip_world_t chip_unconnected;

/* Connects the bus of this thread (hal/f28335/bus.h) to this chip, and the pins of the chip to `world`. Both
 * must exist as long as the connection. Another call replaces the connection. world = NULL:
 * chip_unconnected. */
void chip_bind(chip_t *chip, const chip_world_t *world);

/* Lets time pass on the bound chip: all events with tick < until occur, including interrupts. At the return
 * the chip is at tick `until`, or later if an interrupt function has waited longer. */
void chip_run(uint64_t until);

/* The same, but returns true as soon as an interrupt function has returned to the background and no other one
 * waits, so that the background continues. false: the tick is `until`. */
bool chip_run_to_background(uint64_t until);

/* Updates the registers that change by themselves, for software that continues after a chip_run(). */
void chip_look(chip_t *chip);

/* The board pulls an input pin (GPIO number 0..87) to a level. This acts at the present tick; a trip switches
 * the gates off before the function returns. At the beginning pins are high, but GPIO0..11 (no pull-ups) are
 * low. */
void chip_set_pin(chip_t *chip, uint32_t gpio, bool high);

/* Sets the position counter of eQEP `n` (1, 2) to `count`, wrapped to 0..QPOSMAX, without an edge, as an
 * alignment by an index pulse does. */
void chip_align_encoder(chip_t *chip, uint32_t n, int64_t count);

/* true: from the next counter zero on, legs with the plain centre-aligned complementary setting are reported
 * once a carrier period. */
void chip_set_averaged(chip_t *chip, bool averaged);

/* Delay between an interrupt request and its entry, in ticks on top of the hardware's own; 0 is normal. Fault
 * injection. */
void chip_set_interrupt_delay(chip_t *chip, uint32_t ticks);

/* Overrides the conversion results of one channel (0..15) with a code (0..4095), or -1: none. Fault
 * injection. */
void chip_stick_adc(chip_t *chip, uint32_t channel, int32_t code);

/* The next `count` starts of conversion by a carrier, and their interrupts, do not occur; 0: all occur again.
 * Fault injection. */
void chip_miss_samples(chip_t *chip, uint32_t count);

/* Fault injection: changes a bit of a word of memory. region < CHIP_MEMORY_REGIONS: 0 flash, 1 code in RAM, 2
 * end of the stack; word < CHIP_MEMORY_WORDS. */
void chip_flip_memory(chip_t *chip, uint32_t region, uint32_t word, uint32_t bit);

/* The serial line of SCI-A, from outside. Sends octets to the chip without a gap, from now on or after those
 * that are still being sent. Returns how many were accepted; the line holds CHIP_LINE_FRAMES. */
uint32_t chip_serial_put(chip_t *chip, const uint8_t *octets, uint32_t count);

/* Reads the octets that the chip has sent completely and that have not been read yet, oldest first. Returns
 * their number, at most `room`. The last CHIP_LINE_SENT are stored. */
uint32_t chip_serial_get(chip_t *chip, uint8_t *octets, uint32_t room);

/* Baud rate of the sender to the chip [bit/s], up to 18.75 Mbit/s; 0, as after power-on: the rate that the
 * chip has set. */
void chip_serial_speed(chip_t *chip, uint32_t baud);

/* Puts bits (1..31) on the same line, lowest first, for invalid frames. After a low last bit the line is high
 * for at least one bit. false: there is no room. */
bool chip_serial_levels(chip_t *chip, uint32_t levels, uint32_t bits);

/* Flash sectors C (page 0) and B (page 1), CHIP_FLASH_WORDS words each. chip_flash_fill sets a page as a
 * programmer does. After the first CHIP_FLASH_KEPT words the model stores one value for all words. false, and
 * nothing is changed: these words differ from each other. */
#define CHIP_FLASH_WORDS 0x8000u
uint16_t chip_flash_word(const chip_t *chip, uint32_t page, uint32_t at);
bool chip_flash_fill(chip_t *chip, uint32_t page, const uint16_t words[CHIP_FLASH_WORDS]);

/* Connects an empty memory (all octets 0xFF) to the I2C bus; NULL: no memory, as after power-on. */
typedef struct {
    uint32_t address;     /* [-] 7 bits */
    uint32_t page_octets; /* [octets] at most CHIP_I2C_PAGE; 0: an FRAM, which has none */
    uint32_t write_ticks; /* [ticks] time for writing a page */
} chip_memory_t;
void chip_attach_memory(chip_t *chip, const chip_memory_t *memory);
/* Reads and replaces the first CHIP_I2C_KEPT octets of the memory. */
const uint8_t *chip_memory_octets(const chip_t *chip);
void chip_memory_fill(chip_t *chip, const uint8_t octets[CHIP_I2C_KEPT]);

/* Fault injection. chip_hold_data: the memory holds the data line low for this number of clock pulses, as
 * after a reset of the chip during a read; CHIP_FOREVER: a short circuit. chip_break_memory: the memory
 * acknowledges, but does not change its content. */
#define CHIP_FOREVER UINT32_MAX
void chip_hold_data(chip_t *chip, uint32_t clocks);
void chip_break_memory(chip_t *chip, bool broken);

/* Fault injection: the power fails during an operation of flash or I2C memory, after this number of further
 * operations. Programming a word is one operation, and an erase is 2 x (CHIP_FLASH_KEPT + 1) operations. For
 * an I2C memory each received octet and each written octet is one operation. After the failure the CPU is
 * halted and flash operations do nothing until chip_power_cycle. */
void chip_cut_power(chip_t *chip, uint32_t operations);
uint32_t chip_flash_operations(const chip_t *chip); /* since power-on */

/* Functions that only read. */
uint64_t chip_now(const chip_t *chip);       /* [ticks] */
uint32_t chip_sysclk_hz(const chip_t *chip); /* [Hz] rounded down */
bool chip_halted(const chip_t *chip);        /* the CPU is lost or reset, and runs no software */
bool chip_restart_asked(const chip_t *chip); /* software has requested the last reset */
bool chip_debug_halted(const chip_t *chip);  /* a debugger has halted the CPU */
bool chip_debug_can_look(
    const chip_t *chip); /* a debugger can access memory: the CPU is halted, or DBGM is 0 */
bool chip_tripped(const chip_t *chip, uint32_t leg); /* trip zone holds ePWM `leg` (1..6) */
bool chip_carrier_plain(const chip_t *chip);         /* the three legs run on the fast path */
/* Last counter zero of the module of the first leg (ePWM1, or ePWM4 if only ePWM4..6 have pins); CHIP_NEVER:
 * none. */
uint64_t chip_carrier_tick(const chip_t *chip);
/* The n-th counter zero after it with the present settings; exact at any SYSCLK. */
uint64_t chip_carrier_zero(const chip_t *chip, uint32_t n);
/* Level of GPIO 0..87 as a plain output or as a gate: 0 or 1. -1: the chip does not drive the pin, or the pin
 * belongs to another peripheral. A gate in averaged mode has the level that was reported last. */
int32_t chip_pin_out(const chip_t *chip, uint32_t gpio);
uint64_t chip_sample_tick(const chip_t *chip); /* last entry of SEQ1INT; CHIP_NEVER: none */
uint32_t chip_interrupt_count(const chip_t *chip,
                              uint32_t vector); /* entries of PIE_VECTOR(x, y) since power-on */
uint32_t chip_report_count(const chip_t *chip, chip_report_kind_t kind); /* since power-on */
uint32_t chip_report_total(const chip_t *chip);                          /* of all kinds */
const chip_report_t *chip_last_report(const chip_t *chip);               /* NULL: none yet */

const char *chip_report_text(chip_report_kind_t kind); /* one line, no full stop */
const char *chip_register_name(
    uint32_t address); /* "EPWM1.TZCLR", "?" if none; until the thread's next call */

#endif
