/* Functions of the board for the application, in counts and register units. The implementation is hal/f28335.
 *
 * Timing: period k starts at t_k, when the up-down ePWM counters are zero. The phase currents are sampled and
 * the encoder position is latched exactly at t_k. For this the ADC starts earlier by its own delay. Compare
 * values written during period k act from t_{k+1} to t_{k+2}.
 *
 * Gates: they can be on only after hal_gates_on() has returned true. They are off again after
 * hal_gates_off(), a trip by the fault line of the power module, or an unexpected interrupt. No function
 * waits except hal_init.
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
#define HAL_PER_CHIP __thread /* one process may simulate several chips; each has its own application */
#endif

#define HAL_CLOCK_HZ ((uint32_t)BOARD_SYSCLK_HZ) /* SYSCLKOUT */
#define HAL_PERIOD_COUNT                                                                                     \
    ((uint16_t)BOARD_PERIOD_COUNT) /* compare value of full duty: counts of half a carrier period */

/* Dead band of a leg [SYSCLK cycles]: from the minimum of the power module to the largest value of the
 * register (10 bits). */
#define HAL_DEAD_BAND_MIN ((uint16_t)BOARD_DEAD_BAND_MIN)
#define HAL_DEAD_BAND_MAX ((uint16_t)BOARD_DEAD_BAND_MAX)

/* An interrupt of the application. The interrupts of sample, trip and serial line run with interrupts off.
 * They must end with hal_end_of_sample(), hal_end_of_trip() or hal_end_of_serial(). The interrupt of the
 * medium task begins with hal_begin_medium() and ends with hal_end_medium(); between these calls the others
 * may interrupt it. */
typedef void (*hal_interrupt_t)(void);

typedef struct {
    uint16_t
        dead_band_count; /* [SYSCLK cycles] HAL_DEAD_BAND_MIN..HAL_DEAD_BAND_MAX: both edges of each leg */
    uint32_t encoder_count_max; /* [counts] 4 x lines - 1, lines >= 1 */
    hal_interrupt_t on_sample;  /* every carrier period, when the conversions of t_k are done */
    hal_interrupt_t on_medium;  /* after hal_request_medium(), when no other interrupt is due */
    hal_interrupt_t on_trip;    /* when the power module's fault line has shut gates that were on */
    hal_interrupt_t on_serial;  /* when octets have arrived on the serial line; NULL: not called */
} hal_config_t;

typedef enum {
    HAL_OK = 0,
    HAL_CLOCK_MISSING, /* no crystal: the PLL reports a missing clock */
    HAL_PLL_UNLOCKED,  /* the PLL did not lock in time */
    HAL_BAD_CONFIG,    /* a field of hal_config_t is out of range; no register was changed */
    HAL_TRIP_FAILED    /* a leg did not take the forced trip; the gates were not connected to their pins */
} hal_status_t;

/* hal_samples_t.flags */
#define HAL_FLAG_TRIPPED   (1u << 0) /* the one-shot trip holds the gates off, of one leg at least */
#define HAL_FLAG_FAULT_PIN (1u << 1) /* the power module pulls its fault line at this moment */
#define HAL_FLAG_ENCODER   (1u << 2) /* quadrature phase error since the last sample */
/* The sequence of periods is broken. Either this interrupt occurred after the next period or its conversion
 * had begun, or there was a period without a sample before, because the previous interrupt lasted too long.
 * Compare values of a late interrupt act one period too late, and currents and position may be of different
 * periods. After a gap of ten periods or more, for example a debugger's halt, the next ten samples are late
 * as well. */
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

/* Initialises the board: watchdog off, clock of the board file, flash wait states, gates tripped and then
 * connected to their pins, ADC on, encoder at position 0, interrupts. After HAL_OK the carrier runs with duty
 * 1/2 and tripped gates, and on_sample is called every period. After any other status no interrupt occurs,
 * the bias resistors of the board determine the level of the gates' pins, and hal_gates_on() returns false.
 * It takes about 10 ms, or 150 ms if the PLL does not lock. Call it once after reset, from the background. */
hal_status_t hal_init(const hal_config_t *config);

/* ---- In the interrupt: no loops, no waiting ---- */

/* Reads the sample of this period. Call it once, as the first statement of on_sample. About 20 loads and one
 * store. */
void hal_read(hal_samples_t *samples);

/* Sets the high time of each leg, 0..HAL_PERIOD_COUNT (larger values are limited), which acts from t_{k+1}.
 * The caller ensures the shortest pulse. */
void hal_write_compare(uint16_t a, uint16_t b, uint16_t c);

/* Sets the outputs of brake chopper and holding brake, if the board has them: resistor connected, brake
 * released. They act at once. After hal_init, and on an unexpected interrupt, both are off. While the chip is
 * in reset the resistors of the board determine their level. */
void hal_outputs(bool chopper, bool brake);

/* Forces the one-shot trip: all six gates off at once, without a call of on_trip. It may be called from
 * anywhere, any number of times. */
void hal_gates_off(void);

/* Clears the trip: the gates follow the active compare values, which were written one period ago. Returns
 * true if the gates are on. All gates remain off, and the result is false, in these cases: the fault line is
 * active or becomes active, hal_init has not ended, or the dead-band or trip registers differ from the values
 * of hal_init. */
bool hal_gates_on(void);

void hal_end_of_sample(void); /* enables the next conversion and interrupt: last statement of on_sample */
void hal_end_of_trip(void);   /* last statement of on_trip; the gates stay off */
void hal_end_of_serial(void); /* last statement of on_serial, which has read all octets or dropped them */

/* ---- The medium task ---- */

void hal_request_medium(
    void); /* from on_sample: requests one call of on_medium, also if called several times */
void hal_begin_medium(void); /* first statement of on_medium: the others may interrupt it from here on */
void hal_end_medium(void);   /* last statement of on_medium: interrupts are off until it has returned */

/* ---- From the background ---- */

/* Memory that is not written while the drive runs. A change in it is an error. */
typedef enum {
    HAL_PROGRAM,        /* the program in flash */
    HAL_INTERRUPT_CODE, /* its part that runs from RAM */
    HAL_STACK_END,      /* the last words of the stack: they change if the stack has almost reached its end */
    HAL_REGIONS
} hal_region_t;

typedef struct {
    const uint16_t *words;
    uint32_t count; /* [16-bit words] */
} hal_memory_t;

hal_memory_t hal_memory(hal_region_t region);

/* False, and nothing is changed, if the value is outside HAL_DEAD_BAND_MIN..HAL_DEAD_BAND_MAX or a gate is
 * not tripped. */
bool hal_set_dead_band(uint16_t count);

/* False, and nothing is changed, if the value is not 4 x lines - 1 or a gate is not tripped. A new value
 * restarts the position at 0 (samples show it one period later). The present value changes nothing. */
bool hal_set_encoder(uint32_t count_max);

void hal_watchdog_start(
    void); /* from now on the chip resets unless hal_watchdog_feed is called within 239 ms (279 at 30 MHz) */
void hal_watchdog_feed(void);  /* harmless while the watchdog is off */
void hal_interrupts_off(void); /* begins a change that an interrupt must not interrupt; do not nest */
void hal_interrupts_on(void);
uint32_t hal_time(
    void); /* [SYSCLK cycles] free-running since hal_init, counts up, wraps after 28.6 s at 150 MHz */
void hal_leds(bool run, bool fault); /* the board's two lights, if it has them */

/* ---- The serial line ----
 *
 * 8 data bits, no parity, 1 stop bit, BOARD_SERIAL_BAUD until hal_serial_baud() changes it. Each word
 * contains one octet. No function waits. The only buffer of each direction is the chip's FIFO of 16 octets.
 * Without a line (BOARD_SERIAL_BAUD 0) nothing is received and nothing is accepted. */

/* Reads the octets that have arrived since the last call, oldest first, at most `room`. Returns their number.
 * Damaged frames are omitted and counted. */
uint32_t hal_serial_read(uint16_t *octets, uint32_t room);

/* Drops the octets that have arrived, and counts an error if there were any. */
void hal_serial_drop(void);

/* Sends the first of `count` octets, as many as fit into the transmitter. Returns their number. */
uint32_t hal_serial_write(const uint16_t *octets, uint32_t count);

/* True until the last octet of hal_serial_write() has left the chip. */
bool hal_serial_sends(void);

/* Changes the rate to the nearest that the chip has, within 2.5 % up to 115200 bit/s; octets in transmission
 * are lost. From the background. */
void hal_serial_baud(uint32_t baud);

/* Number of receive errors since hal_init: break, a frame without stop bit, or an overrun. Each error is a
 * loss of one or more octets. */
uint32_t hal_serial_errors(void);

/* ---- Non-volatile memory, from the background ----
 *
 * Two pages of flash. A page is erased as a whole; then all its words are 0xFFFF. Programming changes ones to
 * zeros. If the power fails during a call, the words of this call may have any value. On silicon erasing
 * takes up to some seconds, and programming 50 us a word. No interrupt occurs meanwhile, so that the gates
 * must be tripped.
 */
#define HAL_STORE_PAGES 2u
#define HAL_STORE_WORDS UINT32_C(0x8000) /* [16-bit words] of a page */

/* Word `at` of page `page`; 0 outside the page. */
uint16_t hal_store_word(uint32_t page, uint32_t at);

/* Erases a page. False, and nothing is changed, if a gate is not tripped or the page does not exist. False as
 * well if the flash did not reach its erased state. The watchdog is fed before. It is stopped during the
 * operation, because this may last longer than its time, and runs again afterwards if it ran before. */
bool hal_store_erase(uint32_t page);

/* Programs the words `at` to at + count - 1 of a page. False, and nothing is changed, if a gate is not
 * tripped or a word is outside the page. False as well if a word differs when it is read back, for example
 * because it needs a 1 where a 0 is programmed. */
bool hal_store_program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count);

#if BOARD_STORE == BOARD_STORE_I2C
/* ---- A memory on the I2C bus, from the background ----
 *
 * A 24xx EEPROM or an FRAM, as words with the lower octet first. There is one transfer at a time. Only
 * hal_eeprom_open and hal_eeprom_wait wait; a call needs at most 40 register accesses. A transfer has at most
 * HAL_EEPROM_WORDS words and does not cross a multiple of this number, so that it stays within a page of the
 * memory. */
#define HAL_EEPROM_WORDS UINT32_C(4)

typedef enum {
    HAL_EEPROM_BUSY,
    HAL_EEPROM_DONE,
    HAL_EEPROM_REFUSED, /* not acknowledged: the memory is writing, or there is none */
    HAL_EEPROM_LOST     /* another driver on the bus, or octets are missing */
} hal_eeprom_t;

/* Call it before hal_init and before the other functions of this section. It initialises the clock of the
 * chip, the time, pins and module. Interrupts and watchdog are off until the end of hal_init. false: there is
 * no clock, or a line of the bus stays low. */
bool hal_eeprom_open(void);

/* Begins a transfer. The previous one must have ended or been aborted. Writes the words `at` to at + count -
 * 1, or reads HAL_EEPROM_WORDS words from `at` on. */
void hal_eeprom_write(uint32_t at, const uint16_t *words, uint32_t count);
void hal_eeprom_read(uint32_t at);

/* State of the last transfer; after a completed read `words` has the result. Once the state is not BUSY, the
 * next call must be a new transfer or an abort. */
hal_eeprom_t hal_eeprom_poll(uint16_t words[HAL_EEPROM_WORDS]);

void hal_eeprom_abort(void); /* aborts the present transfer */
void hal_eeprom_wait(void);  /* waits 10 us; before hal_init only */
#endif

/* Switches the gates off and resets the chip by its watchdog. The program begins again with the content of
 * the flash. Does not return on silicon. */
void hal_restart(void);

#endif
