/* A virtual chip on a bench. The world around it records everything that the chip shows at its pins. The
 * bench contains the correct start-up of a drive in registers; a test can omit one step of it. The
 * expected words follow SPRUFB0 (clock), SPRUG04 (ePWM) and SPRU812 (ADC). */
#ifndef TESTS_CHIP_BENCH_H
#define TESTS_CHIP_BENCH_H

#include "hal/f28335/bus.h"
#include "host_sim/chip/chip.h"

#define BENCH_EDGES   65536u
#define BENCH_SAMPLES 4096u
#define CARRIER       15000u /* [ticks] 2 x 7500 counts */

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
    uint64_t last_tick;     /* tick of the last callback */
    uint32_t out_of_order;  /* callbacks whose tick is before that of the previous one */
    double volts[16];       /* at the ADC pins */
    int64_t encoder_offset; /* position = offset + tick x rate / 2^20 */
    int64_t encoder_rate;
} world_record_t;

/* The steps that bench_start omits. */
enum {
    SKIP_HSPCLKDIV = 1u << 0, /* HSPCLKDIV stays at its reset value */
    SKIP_SOC = 1u << 1,
    SKIP_EALLOW_PWM = 1u << 2, /* the trip zone registers are written without EALLOW */
    SKIP_CLOCK_PWM2 = 1u << 3,
    SKIP_VECTOR = 1u << 4,
    SKIP_ADC_POWER = 1u << 5,
    SKIP_TBCLKSYNC = 1u << 6,
    SKIP_RELEASE = 1u << 7, /* the outputs stay tripped */
    WRONG_POLARITY = 1u << 8
};

/* The steps that the interrupt function omits. */
enum { SKIP_PIEACK = 1u << 0, SKIP_INT_CLR = 1u << 1, SKIP_RST_SEQ1 = 1u << 2 };

extern world_record_t bench;
extern chip_t bench_chip;
extern uint32_t bench_isr_skips;
extern uint32_t bench_samples;         /* number of interrupts */
extern uint64_t bench_sample_at[1024]; /* [ticks] entry times of the first 1024 interrupts */
extern uint16_t bench_codes[16];       /* mirrored results at the last interrupt */
extern uint16_t bench_compare[3];      /* compare values that the interrupt writes */
extern uint32_t bench_first_leg;       /* the interrupt writes them to this ePWM (1..4) and the next two */
extern chip_world_t bench_world;       /* the circuit at the pins */
/* Called by the world in each of its callbacks, unless NULL. */
extern void (*bench_on_world)(uint64_t tick, bool analog);
extern void (*bench_in_interrupt)(void); /* called in the interrupt function, unless NULL */

/* Writes one register with EALLOW set. */
void bench_allowed16(const volatile uint16_t *reg, uint16_t value);
void bench_allowed32(const volatile uint32_t *reg, uint32_t value);

uint32_t bench_reports(chip_report_kind_t kind); /* number of wrong uses of this kind that were reported */

void bench_power_on(void); /* a new chip, connected to the recording world, with an empty record */
void bench_power_on_with(uint32_t crystal_hz);
void bench_clock(void); /* watchdog off, 150 MHz, wait states of the flash, prescalers, module clocks on */
void bench_pwm(uint32_t skip); /* three legs at 10 kHz with a dead band of 450, tripped, pins assigned */
/* Four pairs; SOC 87 ticks before counter zero, so that the second pair is held at zero. */
void bench_adc(uint32_t skip);
void bench_interrupts(uint32_t skip);
void bench_start(uint32_t skip); /* the whole start-up, then TBCLKSYNC, then the release of the trip */
void bench_forget(void);         /* empties the record */
void bench_interrupt(void);      /* the interrupt function of SEQ1INT */
uint32_t bench_edges_of(uint32_t pin, uint64_t from,
                        uint64_t to); /* level changes of one pin, from <= tick < to */
uint64_t bench_high_of(uint32_t pin, uint64_t from, uint64_t to); /* ticks at high level in [from, to) */

#endif
