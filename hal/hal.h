/* What an application needs of a board, in counts and registers' terms. One implementation: hal/f28335.
 *
 * Timing: period k starts at t_k, when the up-down ePWM counters are zero. The phase currents are held exactly there (the
 * ADC is started early by its own delay), the encoder position is latched there, and compare values written during
 * period k act from t_{k+1} to t_{k+2}. */
#ifndef HAL_HAL_H
#define HAL_HAL_H

#include <stdbool.h>
#include <stdint.h>

#if defined(__TMS320C2000__)
#define HAL_INTERRUPT __interrupt
#define HAL_PER_CHIP
#else
#define HAL_INTERRUPT
#define HAL_PER_CHIP __thread /* several chips live in one process; each has its own application */
#endif

#define HAL_CLOCK_HZ     UINT32_C(150000000) /* SYSCLKOUT */
#define HAL_PWM_HZ       UINT32_C(10000)     /* carrier and interrupt rate */
#define HAL_PERIOD_COUNT UINT16_C(7500)      /* compare value of full duty: counts of half a carrier period */
#define HAL_ADC_FULL     UINT16_C(4096)      /* ADC codes over 0..3 V */

/* An interrupt of the application; runs with interrupts off and must end in hal_end_of_sample() or hal_end_of_trip(). */
typedef void (*hal_interrupt_t)(void);

typedef struct {
    uint16_t dead_band_count;    /* [1/150 MHz] 300..1023: both edges of each leg */
    uint32_t encoder_count_max;  /* [counts] 4 x lines - 1 */
    hal_interrupt_t on_sample;   /* every carrier period, when the conversions of t_k are done */
    hal_interrupt_t on_trip;     /* when the power module's fault line has shut the gates */
} hal_config_t;

typedef enum {
    HAL_OK = 0,
    HAL_CLOCK_MISSING,  /* no crystal: the PLL reports a missing clock */
    HAL_PLL_UNLOCKED,   /* the PLL did not lock in time */
    HAL_BAD_CONFIG      /* a field of hal_config_t is out of range; no register was touched */
} hal_status_t;

/* hal_samples_t.flags */
#define HAL_FLAG_TRIPPED   (1u << 0) /* the one-shot trip holds the gates off */
#define HAL_FLAG_FAULT_PIN (1u << 1) /* the power module pulls its fault line at this moment */
#define HAL_FLAG_ENCODER   (1u << 2) /* quadrature phase error since the last sample */
#define HAL_FLAG_LATE      (1u << 3) /* the next carrier period has begun already: compare values come one period late */

typedef struct {
    uint16_t current_a;         /* [ADC codes] phase currents at t_k */
    uint16_t current_b;         /* [ADC codes] */
    uint16_t dc_link;           /* [ADC codes] */
    uint16_t sink_temperature;  /* [ADC codes] */
    uint16_t motor_temperature; /* [ADC codes] */
    uint16_t flags;             /* HAL_FLAG_... */
    uint32_t encoder;           /* [counts] 0..encoder_count_max at t_k */
} hal_samples_t;

/* Bring the board up: watchdog fed by nobody yet and off, clock 150 MHz, flash wait states, gates off and tripped, pins,
 * ADC powered (waits 5 ms), encoder, interrupts. On success the carrier runs and on_sample is called every period, gates
 * still tripped. Call once, from the background, after reset. */
hal_status_t hal_init(const hal_config_t *config);

/* In the interrupt. */
void hal_read(hal_samples_t *samples);
void hal_write_compare(uint16_t a, uint16_t b, uint16_t c); /* 0..HAL_PERIOD_COUNT, high time of each leg; acts from t_{k+1} */
void hal_gates_off(void);        /* forces the one-shot trip: all six off at once */
bool hal_gates_on(void);         /* clears the trip; false (and still off) while the fault line is low */
void hal_end_of_sample(void);    /* lets the next conversion and the next interrupt come: last statement of on_sample */
void hal_end_of_trip(void);      /* last statement of on_trip; the gates stay off */

/* From the background. */
bool hal_set_dead_band(uint16_t count); /* false, and nothing done, out of 300..1023 or while the gates are on */
bool hal_set_encoder(uint32_t count_max);
void hal_watchdog_start(void);          /* 279 ms; from now on hal_watchdog_feed must be called */
void hal_watchdog_feed(void);
void hal_interrupts_off(void);          /* brackets a change that the interrupt must not see half done */
void hal_interrupts_on(void);
uint32_t hal_time(void);                /* [1/150 MHz] free-running, counts up, wraps after 28.6 s */

#endif
