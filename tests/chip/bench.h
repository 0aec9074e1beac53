/* A virtual chip on a bench: a world that records everything the chip shows, and the good start-up of a drive
 * in registers, from which a test leaves out one step. Expected words: SPRUFB0 (clock), SPRUG04 (ePWM) and
 * SPRU812 (ADC). */
#ifndef TESTS_CHIP_BENCH_H
#define TESTS_CHIP_BENCH_H

#include "hal/f28335/bus.h"
#include "host_sim/chip/chip.h"

#define BENCH_EDGES   65536u
#define BENCH_SAMPLES 4096u
#define CARRIER       15000u /* [ticks] 2 x 7500 */

typedef struct {
    uint64_t tick;
    uint32_t level, driven;
} edge_t;

typedef struct {
    uint64_t tick;
    uint32_t channel;
} sample_t;

typedef struct {
    uint64_t tick;
    uint32_t period, high[3], dead;
    bool ends;
} average_t;

typedef struct {
    edge_t edge[BENCH_EDGES];
    sample_t sample[BENCH_SAMPLES];
    average_t average[BENCH_SAMPLES];
    uint32_t edges, samples, averages;
    uint64_t last_tick;     /* of any callback */
    uint32_t out_of_order;  /* callbacks whose tick went back */
    double volts[16];       /* at the ADC pins */
    int64_t encoder_offset; /* position = offset + tick x rate / 2^20 */
    int64_t encoder_rate;
} world_record_t;

/* What bench_start leaves out. */
enum {
    SKIP_HSPCLKDIV = 1u << 0, /* stays at its reset value */
    SKIP_SOC = 1u << 1,
    SKIP_EALLOW_PWM = 1u << 2, /* trip zone registers written without EALLOW */
    SKIP_CLOCK_PWM2 = 1u << 3,
    SKIP_VECTOR = 1u << 4,
    SKIP_ADC_POWER = 1u << 5,
    SKIP_TBCLKSYNC = 1u << 6,
    SKIP_RELEASE = 1u << 7, /* stay tripped */
    WRONG_POLARITY = 1u << 8
};

/* What the interrupt leaves out. */
enum { SKIP_PIEACK = 1u << 0, SKIP_INT_CLR = 1u << 1, SKIP_RST_SEQ1 = 1u << 2 };

extern world_record_t bench;
extern chip_t bench_chip;
extern uint32_t bench_isr_skips;
extern uint32_t bench_samples;                             /* interrupts taken */
extern uint64_t bench_sample_at[1024];                     /* [ticks] their entries, first 1024 */
extern uint16_t bench_codes[16];                           /* mirror results at the last one */
extern uint16_t bench_compare[3];                          /* what the interrupt writes */
extern uint32_t bench_first_leg;                           /* to this ePWM (1..4) and the next two */
extern chip_world_t bench_world;                           /* the circuit at the pins */
extern void (*bench_on_world)(uint64_t tick, bool analog); /* the world's answer to a callback; NULL: none */
extern void (*bench_in_interrupt)(void);                   /* more to do there; NULL: nothing */

/* One write with EALLOW open. */
void bench_allowed16(const volatile uint16_t *reg, uint16_t value);
void bench_allowed32(const volatile uint32_t *reg, uint32_t value);

uint32_t bench_reports(chip_report_kind_t kind); /* wrong uses of this kind so far */

void bench_power_on(void); /* fresh chip, bound to the recording world, record empty */
void bench_power_on_with(uint32_t crystal_hz);
void bench_clock(void);        /* watchdog off, 150 MHz, flash waits, prescalers; module clocks on */
void bench_pwm(uint32_t skip); /* three legs, 10 kHz, dead band 450, tripped, pins muxed */
void bench_adc(uint32_t skip); /* four pairs, SOC 87 ticks before counter zero, where the second is held */
void bench_interrupts(uint32_t skip);
void bench_start(uint32_t skip); /* all of it, then TBCLKSYNC, then the trip released */
void bench_forget(void);         /* empties the record */
void bench_interrupt(void);      /* the SEQ1INT function */
uint32_t bench_edges_of(uint32_t pin, uint64_t from,
                        uint64_t to); /* level changes of one pin, from <= tick < to */
uint64_t bench_high_of(uint32_t pin, uint64_t from, uint64_t to); /* ticks at high level in [from, to) */

#endif
