/* What an application needs of a board, in counts and registers' terms. One implementation: hal/f28335.
 *
 * Timing: period k starts at t_k, when the up-down ePWM counters are zero. The phase currents are held
 * exactly there (the ADC is started early by its own delay), the encoder position is latched there, and
 * compare values written during period k act from t_{k+1} to t_{k+2}.
 *
 * Gates: off in doubt. They can be on only after hal_gates_on() said true, until hal_gates_off(), a trip by
 * the power module's fault line, or an interrupt that nobody asked for. Nothing here blocks except hal_init.
 */
#ifndef HAL_HAL_H
#define HAL_HAL_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/board.h"

#if defined(__TMS320C2000__)
#define HAL_INTERRUPT __interrupt
#define HAL_PER_CHIP
#else
#define HAL_INTERRUPT
#define HAL_PER_CHIP __thread /* several chips live in one process; each has its own application */
#endif

#define HAL_CLOCK_HZ ((uint32_t)BOARD_SYSCLK_HZ) /* SYSCLKOUT */
#define HAL_PERIOD_COUNT                                                                                     \
    ((uint16_t)BOARD_PERIOD_COUNT) /* compare value of full duty: counts of half a carrier period */

/* Dead band of a leg [SYSCLK cycles]: from what the power module demands to the register's 10 bits. */
#define HAL_DEAD_BAND_MIN ((uint16_t)BOARD_DEAD_BAND_MIN)
#define HAL_DEAD_BAND_MAX ((uint16_t)BOARD_DEAD_BAND_MAX)

/* An interrupt of the application. Those of sample, trip and serial line run with interrupts off and must end
 * in hal_end_of_sample(), hal_end_of_trip() or hal_end_of_serial(); that of the medium task begins with
 * hal_begin_medium() and ends in hal_end_medium(), and between these two the others may interrupt it. */
typedef void (*hal_interrupt_t)(void);

typedef struct {
    uint16_t
        dead_band_count; /* [SYSCLK cycles] HAL_DEAD_BAND_MIN..HAL_DEAD_BAND_MAX: both edges of each leg */
    uint32_t encoder_count_max; /* [counts] 4 x lines - 1, lines >= 1 */
    hal_interrupt_t on_sample;  /* every carrier period, when the conversions of t_k are done */
    hal_interrupt_t on_medium;  /* after hal_request_medium(), when no other interrupt is due */
    hal_interrupt_t on_trip;    /* when the power module's fault line has shut gates that were on */
    hal_interrupt_t on_serial;  /* when some octets have come on the serial line; NULL: it is never called */
} hal_config_t;

typedef enum {
    HAL_OK = 0,
    HAL_CLOCK_MISSING, /* no crystal: the PLL reports a missing clock */
    HAL_PLL_UNLOCKED,  /* the PLL did not lock in time */
    HAL_BAD_CONFIG,    /* a field of hal_config_t is out of range; no register was touched */
    HAL_TRIP_FAILED    /* a leg did not take the forced trip; the gates were not connected to their pins */
} hal_status_t;

/* hal_samples_t.flags */
#define HAL_FLAG_TRIPPED   (1u << 0) /* the one-shot trip holds the gates off, of one leg at least */
#define HAL_FLAG_FAULT_PIN (1u << 1) /* the power module pulls its fault line at this moment */
#define HAL_FLAG_ENCODER   (1u << 2) /* quadrature phase error since the last sample */
/* The chain of periods is broken: this interrupt came when the next period had begun (or its conversion had),
 * or a period without a sample lies before this one, because the interrupt before ran into it. Compare values
 * of the late one act one period later than they should, and currents and position may be of different
 * periods. After a gap of ten periods or more, as a debugger's halt leaves it, the ten samples that follow
 * are late as well. */
#define HAL_FLAG_LATE (1u << 3)
/* The board's enable input is not active at this moment; never on a board without one. */
#define HAL_FLAG_NOT_ENABLED (1u << 4)

typedef struct {
    uint16_t current_a;         /* [ADC codes] phase currents at t_k */
    uint16_t current_b;         /* [ADC codes] */
    uint16_t current_c;         /* [ADC codes] 0 on a board with two current sensors */
    uint16_t dc_link;           /* [ADC codes] */
    uint16_t sink_temperature;  /* [ADC codes] 0 without a sensor, this one and the next */
    uint16_t motor_temperature; /* [ADC codes] */
    uint16_t flags;             /* HAL_FLAG_... */
    uint32_t encoder;           /* [counts] 0..encoder_count_max at t_k */
} hal_samples_t;

/* Silicon only, first statement of main: copies the code that runs from RAM to its place, and paints the end
 * of the stack. Until then nothing but this function may be called. */
void hal_boot(void);

/* Bring the board up: watchdog off, clock as the board file says, flash wait states, gates tripped and then
 * connected to their pins, ADC powered, encoder at position 0, interrupts. On HAL_OK the carrier runs, duty
 * 1/2 and gates tripped, and on_sample is called every period. On any other status no interrupt ever comes,
 * the gates' pins stay what the board's bias makes of them and hal_gates_on() refuses. Takes about 10 ms, 150
 * ms when the PLL does not lock. Call once, after reset, from the background. */
hal_status_t hal_init(const hal_config_t *config);

/* ---- In the interrupt: straight line, no waiting ---- */

/* The sample of this period; call it once, first thing in on_sample. About 20 loads and one store. */
void hal_read(hal_samples_t *samples);

/* High time of each leg, 0..HAL_PERIOD_COUNT (more counts as that), acts from t_{k+1}. Minimum pulses are the
 * caller's. */
void hal_write_compare(uint16_t a, uint16_t b, uint16_t c);

/* Forces the one-shot trip: all six off at once. on_trip does not come for it. From anywhere, any number of
 * times. */
void hal_gates_off(void);

/* Clears the trip: the gates follow the compare values that act at this moment, those written one period ago.
 * True if they are on. False, and all off, while the fault line is low, when it pulls again meanwhile, before
 * hal_init came to its end, or if dead band or trip registers are not what hal_init made them. */
bool hal_gates_on(void);

void hal_end_of_sample(void); /* lets the next conversion and interrupt come: last statement of on_sample */
void hal_end_of_trip(void);   /* last statement of on_trip; the gates stay off */
void hal_end_of_serial(void); /* last statement of on_serial, which has read all octets or dropped them */

/* ---- The medium task ---- */

void hal_request_medium(void); /* from on_sample: on_medium follows; once, however often it was requested */
void hal_begin_medium(void);   /* first statement of on_medium: the others may interrupt it from here on */
void hal_end_medium(void);     /* last statement of on_medium: interrupts are off until it has returned */

/* ---- From the background ---- */

/* Memory that is not written while the drive runs: a change of it is an error. */
typedef enum {
    HAL_PROGRAM,        /* the program in flash */
    HAL_INTERRUPT_CODE, /* its part that runs from RAM */
    HAL_STACK_END,      /* the last words of the stack: changed if it came so near its end */
    HAL_REGIONS
} hal_region_t;

typedef struct {
    const uint16_t *words;
    uint32_t count; /* [16-bit words] */
} hal_memory_t;

hal_memory_t hal_memory(hal_region_t region);

/* False, and nothing done, out of HAL_DEAD_BAND_MIN..HAL_DEAD_BAND_MAX or unless all gates are tripped. */
bool hal_set_dead_band(uint16_t count);

/* False, and nothing done, if not 4 x lines - 1 or unless all gates are tripped. A new value restarts the
 * position at 0 (samples show it one period later); the present value changes nothing. */
bool hal_set_encoder(uint32_t count_max);

void hal_watchdog_start(
    void); /* from now on hal_watchdog_feed within 239 ms (279 at 30 MHz), else the chip resets */
void hal_watchdog_feed(void);  /* harmless while the watchdog is off */
void hal_interrupts_off(void); /* brackets a change that the interrupt must not see half done; do not nest */
void hal_interrupts_on(void);
uint32_t hal_time(
    void); /* [SYSCLK cycles] free-running since hal_init, counts up, wraps after 28.6 s at 150 MHz */
void hal_leds(bool run, bool fault); /* the board's two lights, if it has them */

/* ---- The serial line ----
 *
 * 8 data bits, no parity, 1 stop bit, BOARD_SERIAL_BAUD until hal_serial_baud() changes it. Octets stand one
 * per word. Nothing here waits; both directions have the chip's FIFO of 16 octets and nothing behind it.
 * Without a line (BOARD_SERIAL_BAUD 0) nothing comes and nothing is taken. */

/* Octets that came since the last call, oldest first, at most `room` of them: how many. One that follows a
 * damaged frame is a whole one again; the damaged ones are left out and counted. */
uint32_t hal_serial_read(uint16_t *octets, uint32_t room);

/* Gives up the octets that have come, and counts an error if there are any. */
void hal_serial_drop(void);

/* The first of `count` octets, as many as the transmitter has room for: how many it took. */
uint32_t hal_serial_write(const uint16_t *octets, uint32_t count);

/* True until the last octet of hal_serial_write() has left the chip. */
bool hal_serial_sends(void);

/* Changes the rate to the nearest that the chip has, within 2.5 % up to 115200 bit/s; octets on their way are
 * lost. From the background. */
void hal_serial_baud(uint32_t baud);

/* Times that the receiver lost octets since hal_init: break, a frame without its stop bit, or an overrun.
 * Each stands for one octet or more. */
uint32_t hal_serial_errors(void);

/* ---- Memory that stays, from the background ----
 *
 * Two pages of flash, each erased as a whole: then all its words are 0xFFFF, and programming turns ones into
 * zeros. A cut of the power in the midst leaves the words of that call anything. On silicon erasing takes up
 * to some seconds and programming 50 us a word; meanwhile no interrupt comes, so the gates must be tripped.
 */
#define HAL_STORE_PAGES 2u
#define HAL_STORE_WORDS UINT32_C(0x8000) /* [16-bit words] of a page */

/* Word `at` of page `page`; 0 beyond. */
uint16_t hal_store_word(uint32_t page, uint32_t at);

/* False, and nothing done, unless all gates are tripped and `page` is one; false as well if the flash did not
 * come to its erased state. The watchdog is fed before; longer than its time it would reset the chip, so it
 * is stopped meanwhile and runs again after, if it did. */
bool hal_store_erase(uint32_t page);

/* Words `at` to at + count - 1 of a page. False, and nothing done, unless all gates are tripped and all words
 * lie in the page; false as well if a word does not read as asked for, as one that would need a 1 where a 0
 * is programmed. */
bool hal_store_program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count);

#if BOARD_STORE == BOARD_STORE_I2C
/* ---- A memory on the I2C bus, from the background ----
 *
 * A 24xx EEPROM or an FRAM, as words with the lower octet first. One transfer at a time; nothing waits but
 * hal_eeprom_open and hal_eeprom_wait, and no call takes more than 40 accesses of registers. A transfer is
 * at most HAL_EEPROM_WORDS words, and none goes beyond a multiple of them: so it stays within a page of the
 * memory. */
#define HAL_EEPROM_WORDS UINT32_C(4)

typedef enum {
    HAL_EEPROM_BUSY,
    HAL_EEPROM_DONE,
    HAL_EEPROM_REFUSED, /* not acknowledged: the memory is writing, or it is not there */
    HAL_EEPROM_LOST     /* another driver on the bus, or octets are missing */
} hal_eeprom_t;

/* Before hal_init and any other call of these: clock of the chip, time, pins, module; interrupts and watchdog
 * are off from here to the end of hal_init. false: no clock, or a line of the bus stays low. */
bool hal_eeprom_open(void);

/* Begins a transfer; the one before has come to its end, or was aborted. Words `at` to at + count - 1, or
 * HAL_EEPROM_WORDS words from `at` on. */
void hal_eeprom_write(uint32_t at, const uint16_t *words, uint32_t count);
void hal_eeprom_read(uint32_t at);

/* State of the transfer that was begun last; `words` after a read that is done. Once it is not BUSY, the next
 * call is a new transfer or an abort. */
hal_eeprom_t hal_eeprom_poll(uint16_t words[HAL_EEPROM_WORDS]);

void hal_eeprom_abort(void); /* the transfer under way is given up */
void hal_eeprom_wait(void);  /* 10 us pass; before hal_init only */
#endif

/* Gates off, then a reset of the chip by its watchdog: all begins anew, with what the flash holds. Does not
 * return on silicon. */
void hal_restart(void);

#endif
