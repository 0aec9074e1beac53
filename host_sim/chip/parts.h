/* Functions that the parts of the virtual chip call of each other. Only host_sim/chip/.c files include it.
 *
 * Order of events: every part stores the cycle of its next event and writes its tick to chip->next; chip.c
 * handles the earliest. At equal ticks the order is that of source_t. All events that are due at the present
 * tick are handled before a register write of a part takes effect. A part may handle several of its events in
 * one call, as long as they are earlier than chip->limit; a part that plans an event lowers this limit. A
 * handler calls the world last, because the world may answer with chip_set_pin. */
#ifndef HOST_SIM_CHIP_PARTS_H
#define HOST_SIM_CHIP_PARTS_H

#include "hal/f28335/bus.h"
#include "host_sim/chip/chip.h"

typedef enum { SOURCE_EPWM, SOURCE_EQEP, SOURCE_ADC, SOURCE_CPU, SOURCE_RARE, SOURCES } source_t;

/* Word addresses of the blocks (SPRS439, memory map). */
#define FLASH_AT        0x0A80u
#define MIRROR_AT       0x0B00u
#define TIMER_AT        0x0C00u
#define PIE_AT          0x0CE0u
#define VECTOR_AT       0x0D00u
#define EPWM_AT         0x6800u
#define EQEP_AT         0x6B00u
#define GPIO_CONTROL_AT 0x6F80u
#define GPIO_DATA_AT    0x6FC0u
#define SYSCTRL_AT      0x7010u
#define SCIA_AT         0x7050u
#define ADC_AT          0x7100u
#define I2CA_AT         0x7900u

#define OFFSET(type, member) ((uint32_t)WORDS(type, member))

extern __thread const chip_world_t *chip_world; /* of the bound chip; never NULL once bound */

/* Reports an event to the recorder. */
static inline void chip_tell(const chip_t *chip, chip_event_t what, uint32_t value)
{
    if (chip_world != NULL && chip_world->event != NULL) {
        chip_world->event(chip_world->context, chip->tick, what, value);
    }
}
extern __thread chip_t *chip_bound;

/* chip.c */
void chip_report(chip_t *chip, chip_report_kind_t kind, uint32_t address);
void chip_refresh(chip_t *chip); /* updates the registers that change by themselves */
void chip_engine(chip_t *chip, uint64_t until);
void chip_reset(chip_t *chip, bool boot_rom);
void chip_schedule_rare(chip_t *chip);

/* memory.c */
void memory_power_on(chip_t *chip);

/* flash.c: the sectors that the drive erases and programs */
void flash_power_on(chip_t *chip);
void flash_reset(chip_t *chip);
bool flash_api_runs(const chip_t *chip); /* its code has replaced the interrupt's code */
/* The next operation of a memory that keeps its content without power. *done: the bits that were changed; all
 * of them, or only some if the power fails during the operation. False: there is no power, and nothing is
 * changed. */
bool chip_storage_operation(chip_t *chip, uint32_t *done);

/* i2c.c */
void i2c_reset(chip_t *chip);
uint16_t i2c_read(chip_t *chip, uint32_t address);
void i2c_write(chip_t *chip, uint32_t address, uint16_t value);
void i2c_refresh(chip_t *chip);             /* before the clock changes */
void i2c_pins(chip_t *chip);                /* the multiplexer or the levels of the pins changed */
uint32_t i2c_lines_low(const chip_t *chip); /* the pins of port B that the memory pulls low */

/* i2c_memory.c */
void i2c_memory_power_on(chip_t *chip);
void i2c_memory_power_cycle(chip_t *chip);

/* sci.c */
void sci_reset(chip_t *chip);
void sci_power_cycle(chip_t *chip);
uint16_t sci_read(chip_t *chip, uint32_t address);
void sci_write(chip_t *chip, uint32_t address, uint16_t value);
void sci_refresh(chip_t *chip); /* before a change of clock or pins, or a halt by a debugger */
void sci_event(chip_t *chip);
void sci_go(chip_t *chip); /* a debugger's halt ends; chip->debug still has the time at which it began */

/* sysctrl.c: clocks, flash */
void sysctrl_crystal(chip_t *chip, uint32_t hz);
void sysctrl_reset(chip_t *chip, bool boot_rom);
void sysctrl_write(chip_t *chip, uint32_t address, uint16_t value);
void sysctrl_locked(chip_t *chip); /* event */
void flash_write(chip_t *chip, uint32_t address, uint16_t value);

/* watchdog.c */
void watchdog_reset(chip_t *chip);
bool watchdog_write(chip_t *chip, uint32_t address,
                    uint16_t value);  /* false: the register belongs to another part */
void watchdog_overflow(chip_t *chip); /* event */
void watchdog_refresh(chip_t *chip);
void watchdog_halt(chip_t *chip); /* a debugger's halt begins */
void watchdog_go(chip_t *chip);   /* the halt ends; chip->debug still has the time at which it began */

/* timer.c */
void timer_reset(chip_t *chip);
void timer_clock(chip_t *chip); /* PCLKCR3 changed */
void timer_write16(chip_t *chip, uint32_t address, uint16_t value);
void timer_write32(chip_t *chip, uint32_t address, uint32_t value);
void timer_events(chip_t *chip); /* event */
void timer_schedule(chip_t *chip);
void timer_refresh(chip_t *chip);
void timer_debug(chip_t *chip); /* a debugger's halt began or ended */

/* gpio.c */
void gpio_reset(chip_t *chip);
void gpio_write(chip_t *chip, uint32_t address, uint32_t value);
void gpio_refresh(chip_t *chip);
void gpio_show(chip_t *chip); /* updates the first port, whose pins PWM modules can drive */
uint32_t gpio_mux(const chip_t *chip, uint32_t pin);
uint32_t gpio_trip_low(const chip_t *chip); /* bit n-1: TZn pulled low */

/* pie.c */
void pie_reset(chip_t *chip);
void pie_write(chip_t *chip, uint32_t address, uint16_t value);
void pie_request(chip_t *chip, uint32_t group, uint32_t lines); /* lines: bit y-1 = INTgroup.y */
void cpu_request(chip_t *chip, uint32_t n);                     /* INT13, INT14 */
void cpu_update(chip_t *chip);                                  /* a condition for interrupts changed */
void cpu_enter(chip_t *chip);                                   /* event */
bool cpu_in_background(const chip_t *chip); /* true: the CPU runs the background, and no interrupt waits */

/* eqep.c */
void eqep_reset(chip_t *chip);
void eqep_connect(chip_t *chip); /* clock, QPEN or pin mux changed */
void eqep_write16(chip_t *chip, uint32_t address, uint16_t value);
void eqep_write32(chip_t *chip, uint32_t address, uint32_t value);
void eqep_timeout(chip_t *chip); /* event */
void eqep_refresh(chip_t *chip);
void eqep_schedule(chip_t *chip);
void eqep_debug(chip_t *chip); /* a debugger's halt began or ended */

/* adc.c */
void adc_reset(chip_t *chip, bool boot_rom);
uint16_t adc_otp(uint32_t address);
void adc_write(chip_t *chip, uint32_t address, uint16_t value);
void adc_trigger(chip_t *chip, uint64_t cycle,
                 uint32_t mask); /* SOC pulse; mask: the bits of ADCTRL2 that allow it */
void adc_event(chip_t *chip);    /* event */
void adc_refresh(chip_t *chip);
void adc_schedule(chip_t *chip);
void adc_halt(chip_t *chip); /* a debugger's halt begins */
void adc_go(chip_t *chip);   /* the halt ends; chip->debug still has the time at which it began */

/* epwm.c: registers */
void epwm_reset(chip_t *chip);
void epwm_write(chip_t *chip, uint32_t address, uint16_t value);

/* timebase.c: counters, any set-up */
typedef enum {
    EVENT_ZERO,
    EVENT_PERIOD,
    EVENT_CAU,
    EVENT_CAD,
    EVENT_CBU,
    EVENT_CBD
} epwm_event_t;                               /* as in AQCTL */
void epwm_clock(chip_t *chip);                /* PCLKCR1 or TBCLKSYNC changed */
void epwm_settle(chip_t *chip);               /* handles everything that is due at the present tick */
void epwm_event(chip_t *chip);                /* event */
void epwm_refresh(chip_t *chip);              /* TBCTR, TBSTS */
void timebase_hold(chip_t *chip, uint32_t m); /* sets anchor and count to the present */
void timebase_plan(chip_t *chip, uint32_t m); /* computes the next event after the anchor */
void timebase_start(chip_t *chip, uint32_t m);
void timebase_sync(chip_t *chip, uint32_t m, uint64_t cycle); /* SYNCI pulse at module m */
void timebase_schedule(chip_t *chip);
uint32_t timebase_divider(uint32_t tbctl);
void timebase_debug(chip_t *chip, uint32_t m); /* a debugger's halt began or ended, or FREE_SOFT changed */
bool timebase_stops(const chip_t *chip, uint32_t m); /* true: the present halt stops this counter */

/* trigger.c: event trigger */
void trigger_events(chip_t *chip, uint32_t m, uint64_t cycle,
                    uint32_t events); /* events: 1 << epwm_event_t */
void trigger_soc(chip_t *chip, uint32_t m, uint64_t cycle,
                 uint32_t shift); /* shift: 0 for SOCA, 1 for SOCB */
void trigger_write(chip_t *chip, uint32_t m, uint32_t offset, uint16_t value);

/* outputs.c: action qualifier, dead band, trip zone, pins */
void outputs_act(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t events, uint32_t mode, uint32_t up);
void outputs_force(chip_t *chip, uint32_t m, uint64_t cycle);                 /* AQCSFRC becomes active */
void outputs_once(chip_t *chip, uint32_t m, uint64_t cycle, uint16_t aqsfrc); /* one-shot force */
void outputs_inputs(chip_t *chip, uint32_t m, uint64_t cycle); /* input a or b, or IN_MODE, changed */
void outputs_raw(chip_t *chip, uint32_t m);
void outputs_changed(chip_t *chip); /* trip, mux or latch changed: reports it to the world */
void outputs_show(chip_t *chip);    /* reports changed levels to the world */
void trip_pins(chip_t *chip);       /* TZ pins or TZSEL changed */
void trip_write(chip_t *chip, uint32_t m, uint32_t offset, uint16_t value);
void trip_zero(chip_t *chip, uint32_t m); /* at counter zero: ends the cycle-by-cycle trips */

/* carrier.c: a faster engine for the usual set-up of the modules */
void carrier_try(chip_t *chip,
                 uint64_t cycle); /* at counter zero: starts this engine if the set-up is the usual one */
void carrier_event(chip_t *chip); /* event */
void carrier_see(chip_t *chip);   /* computes the edges of this period, which are needed after all */
void carrier_leave(chip_t *chip); /* returns to the general engine */

static inline bool carrier_has(const chip_t *chip, uint32_t m)
{
    return chip->carrier.active && (chip->carrier.members >> m & 1u) != 0u;
}

static inline uint64_t earlier(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

/* Stores a part's next event. A part that handles several events in one call stops before it (chip->limit).
 */
static inline void chip_plan(chip_t *chip, source_t source, uint64_t tick)
{
    chip->next[source] = tick;
    chip->limit = earlier(chip->limit, tick);
}

/* The duration of these cycles of the crystal [ticks], rounded up. */
static inline uint64_t crystal_ticks(const chip_t *chip, uint64_t cycles)
{
    const chip_clock_t *clock = &chip->clock;
    return (cycles * clock->crystal_ticks + clock->crystal_cycles - 1u) / clock->crystal_cycles;
}

/* First tick of a SYSCLK cycle. */
static inline uint64_t tick_of(const chip_t *chip, uint64_t cycle)
{
    const chip_clock_t *clock = &chip->clock;
    if (cycle == CHIP_NEVER) {
        return CHIP_NEVER;
    }
    if (cycle <= clock->cycle) {
        return clock->tick;
    }
    if (clock->ticks == 1u && clock->cycles == 1u) {
        return clock->tick + (cycle - clock->cycle);
    }
    return clock->tick + ((cycle - clock->cycle) * clock->ticks + clock->cycles - 1u) / clock->cycles;
}

/* The SYSCLK cycle to which a tick belongs; the tick must not be before the last change of the clock.
 * cycle_of is the inverse of tick_of as long as SYSCLK is at most 150 MHz. */
static inline uint64_t cycle_of(const chip_t *chip, uint64_t tick)
{
    const chip_clock_t *clock = &chip->clock;
    if (clock->ticks == 1u && clock->cycles == 1u) {
        return clock->cycle + (tick - clock->tick);
    }
    return clock->cycle + (tick - clock->tick) * clock->cycles / clock->ticks;
}

static inline uint64_t cycle_now(const chip_t *chip)
{
    return cycle_of(chip, chip->tick);
}

/* Dead band of one module (SPRUG04, dead-band submodule). One path delays rising edges, the other delays
 * falling edges. A pulse shorter than the delay is lost. */
static inline void deadband_rising_path(chip_epwm_t *epwm, uint64_t cycle, uint32_t level, uint64_t delay)
{
    epwm->red_in = level;
    epwm->red = level && delay == 0u;
    epwm->red_due = level && delay != 0u ? cycle + delay : CHIP_NEVER;
}

static inline void deadband_falling_path(chip_epwm_t *epwm, uint64_t cycle, uint32_t level, uint64_t delay)
{
    epwm->fed_in = level;
    epwm->fed = level || delay != 0u;
    epwm->fed_due = !level && delay != 0u ? cycle + delay : CHIP_NEVER;
}

static inline void deadband_due(chip_epwm_t *epwm, uint64_t cycle)
{
    if (epwm->red_due <= cycle) {
        epwm->red = 1u;
        epwm->red_due = CHIP_NEVER;
    }
    if (epwm->fed_due <= cycle) {
        epwm->fed = 0u;
        epwm->fed_due = CHIP_NEVER;
    }
}

#endif
