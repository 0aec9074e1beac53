/* A TMS320F28335 in RAM, as far as this drive uses it. Driven only through its registers (hal/f28335/bus.h,
 * whose host side lives here); shows itself only through pins: gate edges out, analog voltages, encoder edges
 * and trip pins in.
 *
 * Time is counted in ticks of 150 MHz (6.67 ns) since reset, whatever the PLL says: a wrongly set clock makes
 * the peripherals slower, not the ticks. Inside, peripherals count SYSCLK cycles; clock.c turns the one into
 * the other.
 *
 * Software runs at the speed of the host and takes the simulated time that is assigned to it. For an
 * interrupt function this is done by bus_wait(), and by a caller around the chip that calls chip_run() within
 * the function: reads and writes before and after it happen at those two ticks, and in between the CPU is
 * busy, so that interrupts held back by INTM, IER and PIEACK wait. For a section of the background with INTM
 * set it is done by the hook `section`. Everything else takes no time. Registers that move by themselves
 * (TBCTR, TBSTS, TIM, QPOSCNT, QUTMR, ADCASEQSR, WDCNTR) are brought up to date before every interrupt
 * function, after every bus_wait() and by chip_look(); between these they stand still.
 *
 * A debugger may halt the CPU: no software runs, time goes on for the world, and every peripheral does what
 * its own emulation bits say.
 *
 * Not modelled: of the SCIs all but SCI-A with its FIFOs and frames of 8 bits (sci.c), of I2C-A all but the
 * master with FIFOs (i2c.c), eCAN, DMA, eCAP, SEQ2
 * and continuous ADC conversion, PWM chopper, high-resolution PWM, input qualification (every input acts as
 * if asynchronous), index and strobe inputs of the eQEPs, their capture unit and watchdog, SYNCI pin,
 * low-power modes, missing-clock detector, the wrong first ADC sample (SPRZ272), pipeline and wait-state
 * effects. Writing anything but 0 to such a register is reported as CHIP_UNKNOWN_REGISTER. */
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
    CHIP_PROTECTED_WRITE,  /* EALLOW-protected register written outside EALLOW: ignored */
    CHIP_CLOCK_OFF,        /* register of a module whose clock is off written: ignored */
    CHIP_BAD_WIDTH,        /* 32-bit access to a 16-bit register or the reverse: ignored */
    CHIP_UNKNOWN_REGISTER, /* write to an address that holds no register of this model: ignored */
    CHIP_READ_ONLY,        /* write to a read-only register: ignored */
    CHIP_PLL_MISUSE,       /* PLLCR written with DIVSEL not 0, or DIVSEL changed before lock: ignored */
    CHIP_NO_VECTOR,        /* interrupt taken whose PIE vector was never written: the CPU is lost (halted) */
    CHIP_ADC_OVERRUN, /* start of conversion while the sequencer is busy: the first one waits, others are lost
                       */
    CHIP_ADC_NOT_POWERED, /* conversion before the 5 ms of power-up were over: result is wrong (reads 0) */
    CHIP_ADC_TOO_FAST, /* conversion with ADCCLK above 25 MHz; the result here is right, on silicon it is not
                        */
    CHIP_WATCHDOG_RESET, /* overflow, wrong WDCHK or wrong WDKEY: the chip was reset (CPU halted until
                            chip_boot) */
    CHIP_FLASH_TOO_FAST, /* SYSCLK above what the flash wait states allow */
    CHIP_SERIAL_LOST,    /* octet written while the transmit FIFO was full, or the transmitter off: lost */
    CHIP_FLASH_MISUSE,   /* flash erased or programmed with interrupts or watchdog on, or without the API:
                            refused */
    CHIP_FLASH_BEYOND,   /* word programmed behind those of a page that this model keeps: refused */
    CHIP_I2C_MISUSE,     /* I2C clock changed out of reset (ignored), or START with it outside 7 to 12 MHz */
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

/* The world around the pins; called in order of time while chip_run() or bus_wait() runs. A callback may call
 * chip_set_pin, nothing else that changes the chip; `interrupt` may what the function may. */
typedef struct {
    void *context;
    /* Voltage [V] at the ADC pin at this tick, the end of its sample window; channel 0..7 = A0..A7, 8..15 =
     * B0..B7. */
    double (*analog)(void *context, uint64_t tick, uint32_t channel);
    /* Pin levels changed: bit 2(n-1) = EPWMnA, bit 2(n-1)+1 = EPWMnB, n = 1..6 (GPIO0..11); one that is a
     * plain GPIO output counts too. A pin that is high-impedance (input, or tripped with TZCTL = 0) has 0 in
     * `driven`: its level is then what the board's bias makes of it, and its bit in `level` is 0. */
    void (*gates)(void *context, uint64_t tick, uint32_t level, uint32_t driven);
    /* Averaged mode only: three legs, those on ePWM1..3 or, if only these have pins, on ePWM4..6, in this
     * order. Gate A of a leg is on for high[n] ticks, less one dead band if the leg switches at all, in the
     * carrier period that begins at this tick (counter zero) and lasts `period` ticks; gate B is the
     * complement, both are off during `dead` ticks at each change. `ends`: gate A is on at both ends of the
     * period and off around its middle, otherwise on around its middle. On is the pin high, or low if
     * `active_low` is set. Holds until the next call of carrier or gates.
     *
     * Where a SYSCLK cycle is no whole number of ticks: `period` is exactly the way to the next counter zero
     * (whole at 100 MHz), high and dead are rounded to the nearest tick, so they are off by half a tick at
     * most (only odd counts at 100 MHz). A leg that switches keeps 0 < high < period. */
    void (*carrier)(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                    bool ends);
    /* Quadrature position [counts, four per line], free-running and signed, at this tick. Asked at every
     * latch, before every interrupt function, after every wait and by chip_look(). */
    int64_t (*encoder)(void *context, uint64_t tick);
    /* Runs the function of an interrupt that the CPU has entered, for instance to measure it. NULL: the chip
     * calls it itself. */
    void (*interrupt)(void *context, uint32_t vector, void (*function)(void));
    /* A section with INTM set ends at this moment: the ticks that it took. What it wrote was there at its
     * begin; interrupts wait until these ticks have passed. NULL: no time. */
    uint64_t (*section)(void *context);
    /* For recordings; NULL: nobody. */
    void (*event)(void *context, uint64_t tick, chip_event_t what, uint32_t value);
    /* The board's gates are on while their pin is low. Averages are reported only for legs whose dead band
     * fits the board (AHC, or ALC if set): with the other polarity both gates of a leg are on together, which
     * only the edges can show. */
    uint64_t active_low;
} chip_world_t;

/* The whole chip: copyable, no pointers, no padding. Fields are for the debugger; only this module writes
 * them. */
#include "host_sim/chip/chip_state.h"

/* Power-on reset at tick 0: boot ROM done (SPRU963), SYSCLK half the crystal, ADC calibrated, watchdog
 * running, all pins inputs. The crystal is the board's: 20..35 MHz in whole kHz; lock time, watchdog and
 * SYSCLK follow it exactly. */
void chip_power_on(chip_t *chip, uint32_t crystal_hz);

/* The same with a debugger that takes the CPU before the boot ROM ran: SYSCLK is a quarter of the crystal and
 * nobody has copied the ADC's calibration (ADCREFSEL, ADCOFFTRIM) from OTP, so conversions are off by the
 * bare converter's offset and gain until software does. */
void chip_power_on_by_debugger(chip_t *chip, uint32_t crystal_hz);

/* The supply goes off and on again: reset, boot ROM, memory of the firmware's code anew, nothing in the FIFOs
 * and nothing on the line, a cut of the power (chip_cut_power) undone. What the flash sectors of the drive
 * hold stays, and time goes on; so do the board's pins, injected faults and the counts of reports and
 * interrupts. For the bound chip. */
void chip_power_cycle(chip_t *chip);

/* The CPU starts again after a watchdog reset (or after it was lost): what main() would see. Registers stay.
 */
void chip_boot(chip_t *chip);

/* A debugger's restart: the CPU begins at its entry again, what main() would see. INTM and DBGM are set,
 * EALLOW is closed; everything else stays: clocks, registers, counters, trips, IER, IFR, PIE. A CPU that was
 * lost runs again; a halt lasts on. */
void chip_restart(chip_t *chip);

/* A debugger halts the CPU, and lets it run again; between two chip_run(). During the halt no software runs
 * and requests wait; what is written over the bus is the debugger's doing. ePWM counters (TBCTL), eQEPs
 * (QEPCTL), CPU timers (TCR) and the ADC (SUSMOD) follow their emulation bits, the watchdog stands. What
 * stood goes on from where it stood. */
void chip_debug_halt(chip_t *chip);
void chip_debug_run(chip_t *chip);

/* Real-time mode: a halt stops the background only. Interrupts whose CPU group is enabled in DBGIER and IER
 * are still served, whatever INTM is. */
void chip_debug_realtime(chip_t *chip, bool on);

/* From now on the bus of this thread (hal/f28335/bus.h) is this chip's, and `world` is what stands around its
 * pins. Both must outlive the binding; binding again replaces it. world = NULL: nothing around (0 V, no
 * encoder). */
void chip_bind(chip_t *chip, const chip_world_t *world);

/* Let time pass on the bound chip: everything with tick < until happens, interrupts included. Returns with
 * the chip at tick `until`, or later if an interrupt function waited past it. */
void chip_run(uint64_t until);

/* The same, but returns true as soon as an interrupt function has returned to the background and none waits:
 * there the background goes on. false: it is `until`. */
bool chip_run_to_background(uint64_t until);

/* Registers that move by themselves show the present tick: for software that goes on behind a chip_run(). */
void chip_look(chip_t *chip);

/* The board pulls an input pin (GPIO number 0..87) to a level. Takes effect at the chip's present tick; a
 * trip shuts the gates before this returns. Pins start high, GPIO0..11 (pull-ups off) low. */
void chip_set_pin(chip_t *chip, uint32_t gpio, bool high);

/* An encoder's index as an alignment would use it: the position counter of eQEP `n` (1, 2) becomes `count`,
 * wrapped to 0..QPOSMAX, and no edge is seen. */
void chip_align_encoder(chip_t *chip, uint32_t n, int64_t count);

/* true: from the next counter zero on, legs whose set-up is the plain centre-aligned complementary one are
 * reported once a carrier period. */
void chip_set_averaged(chip_t *chip, bool averaged);

/* Delay between an interrupt request and its entry, in ticks on top of the hardware's own; 0 is normal. Fault
 * injection. */
void chip_set_interrupt_delay(chip_t *chip, uint32_t ticks);

/* Overrides the conversion results of one channel (0..15) with a code (0..4095), or -1: none. Fault
 * injection. */
void chip_stick_adc(chip_t *chip, uint32_t channel, int32_t code);

/* The next `count` starts of conversion that a carrier asks for do not come, nor their interrupts; 0: all
 * come again. Fault injection. */
void chip_miss_samples(chip_t *chip, uint32_t count);

/* An injected error: a bit of a word of memory changes; region: 0 flash, 1 code in RAM, 2 end of the stack,
 * below CHIP_MEMORY_REGIONS; word below CHIP_MEMORY_WORDS. */
void chip_flip_memory(chip_t *chip, uint32_t region, uint32_t word, uint32_t bit);

/* The serial line of SCI-A, from outside. Octets towards the chip follow each other on the line without a gap
 * from now on, or behind those that are on their way; how many there was room for, CHIP_LINE_FRAMES in all.
 */
uint32_t chip_serial_put(chip_t *chip, const uint8_t *octets, uint32_t count);

/* The octets that the chip has sent, stop bit included, and that nobody has taken yet, oldest first: how
 * many, at most `room`. The last CHIP_LINE_SENT are kept. */
uint32_t chip_serial_get(chip_t *chip, uint8_t *octets, uint32_t room);

/* [bit/s] of who sends towards the chip, to 18.75 Mbit/s; 0, as after power-on: whatever the chip has set. */
void chip_serial_speed(chip_t *chip, uint32_t baud);

/* So many bits (1..31) onto the same line as they are, lowest first: for frames that are none. Behind a low
 * one the line goes high for a bit at least. false: no room. */
bool chip_serial_levels(chip_t *chip, uint32_t levels, uint32_t bits);

/* Flash sectors C (page 0) and B (page 1), CHIP_FLASH_WORDS words each. fill: a page as a programmer would
 * leave it; false, and nothing done: words differ from each other behind the CHIP_FLASH_KEPT first, where
 * this model keeps one value for all. */
#define CHIP_FLASH_WORDS 0x8000u
uint16_t chip_flash_word(const chip_t *chip, uint32_t page, uint32_t at);
bool chip_flash_fill(chip_t *chip, uint32_t page, const uint16_t words[CHIP_FLASH_WORDS]);

/* A memory on the I2C bus, with nothing in it (all octets 0xFF) after power-on; NULL: none, as after
 * power-on.
 */
typedef struct {
    uint32_t address;     /* [-] 7 bits */
    uint32_t page_octets; /* [octets] at most CHIP_I2C_PAGE; 0: an FRAM, which has none */
    uint32_t write_ticks; /* [ticks] of writing a page */
} chip_memory_t;
void chip_attach_memory(chip_t *chip, const chip_memory_t *memory);
/* The first CHIP_I2C_KEPT of its octets, and others in their place. */
const uint8_t *chip_memory_octets(const chip_t *chip);
void chip_memory_fill(chip_t *chip, const uint8_t octets[CHIP_I2C_KEPT]);

/* Injected: the memory holds the data line low until it has seen so many clock pulses by plain pins, as one
 * that a reset of the chip has left in the midst of a read; CHIP_FOREVER: a short circuit. And: it
 * acknowledges, but keeps what it had. */
#define CHIP_FOREVER UINT32_MAX
void chip_hold_data(chip_t *chip, uint32_t clocks);
void chip_break_memory(chip_t *chip, bool broken);

/* Injected: the power fails in the midst of the operation of flash or I2C memory that comes after so many
 * more. An operation is a word programmed; an erase is 2 x (CHIP_FLASH_KEPT + 1) of them; an octet that an
 * I2C memory receives is one, and one that it writes. From then on the chip is dead (the CPU halted, flash
 * operations do nothing) until chip_power_cycle. */
void chip_cut_power(chip_t *chip, uint32_t operations);
uint32_t chip_flash_operations(const chip_t *chip); /* since power-on */

/* Pure questions. */
uint64_t chip_now(const chip_t *chip);               /* [ticks] */
uint32_t chip_sysclk_hz(const chip_t *chip);         /* [Hz] rounded down */
bool chip_halted(const chip_t *chip);                /* the CPU is lost or reset: it runs no more software */
bool chip_restart_asked(const chip_t *chip);         /* and its last reset was software's own wish */
bool chip_debug_halted(const chip_t *chip);          /* a debugger holds it */
bool chip_debug_can_look(const chip_t *chip);        /* a debugger reaches memory now: halted, or DBGM is 0 */
bool chip_tripped(const chip_t *chip, uint32_t leg); /* trip zone holds ePWM `leg` (1..6) */
bool chip_carrier_plain(const chip_t *chip);         /* the three legs run on the fast path */
/* Last counter zero of the first leg's module (ePWM1, or ePWM4 if only ePWM4..6 have pins), or CHIP_NEVER. */
uint64_t chip_carrier_tick(const chip_t *chip);
/* The n-th one after it, if the counter goes on as it does now; exact at any SYSCLK. */
uint64_t chip_carrier_zero(const chip_t *chip, uint32_t n);
/* Level that the chip gives GPIO 0..87 as a plain output or as a gate: 0, 1, or -1: it does not drive the pin
 * or it belongs to another peripheral. A gate in averaged mode has the level that was last reported. */
int32_t chip_pin_out(const chip_t *chip, uint32_t gpio);
uint64_t chip_sample_tick(const chip_t *chip); /* last entry of SEQ1INT, or CHIP_NEVER */
uint32_t chip_interrupt_count(const chip_t *chip,
                              uint32_t vector); /* entries of PIE_VECTOR(x, y) since power-on */
uint32_t chip_report_count(const chip_t *chip, chip_report_kind_t kind); /* since power-on */
uint32_t chip_report_total(const chip_t *chip);                          /* of all kinds */
const chip_report_t *chip_last_report(const chip_t *chip);               /* NULL: none yet */

const char *chip_report_text(chip_report_kind_t kind); /* one line, no full stop */
const char *chip_register_name(
    uint32_t address); /* "EPWM1.TZCLR", "?" if none; until the thread's next call */

#endif
