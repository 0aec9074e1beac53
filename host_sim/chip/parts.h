/* What the parts of the virtual chip know of each other. Included by host_sim/chip/.c files only.
 *
 * Order of things: every part keeps the cycle of its next event and puts the tick of it into chip->next;
 * chip.c takes the earliest. At equal ticks the order is that of source_t. Before a register write of a part
 * is obeyed, everything that is due at the present tick has happened. A part may handle several of its events
 * in one go as long as they are earlier than chip->limit, which every other part's planning lowers. A
 * callback into the world is the last thing a handler does, because the world may answer with chip_set_pin.
 */
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
void chip_refresh(chip_t *chip); /* registers that move by themselves */
void chip_engine(chip_t *chip, uint64_t until);
void chip_reset(chip_t *chip, bool boot_rom);
void chip_schedule_rare(chip_t *chip);

/* memory.c */
void memory_power_on(chip_t *chip);

/* flash.c: what the drive erases and programs itself */
void flash_power_on(chip_t *chip);
void flash_reset(chip_t *chip);
bool flash_api_runs(const chip_t *chip); /* its code is in the place of the interrupt's */
/* The next operation of a memory that outlives the supply. *done: its bits, all or, in a cut of the power,
 * some. False: nothing happens, there is no power. */
bool chip_storage_operation(chip_t *chip, uint32_t *done);

/* i2c.c */
void i2c_reset(chip_t *chip);
uint16_t i2c_read(chip_t *chip, uint32_t address);
void i2c_write(chip_t *chip, uint32_t address, uint16_t value);
void i2c_refresh(chip_t *chip);             /* before the clock changes */
void i2c_pins(chip_t *chip);                /* pins became plain ones, or their levels changed */
uint32_t i2c_lines_low(const chip_t *chip); /* mask of port B: pulled low by the memory */

/* i2c_memory.c */
void i2c_memory_power_on(chip_t *chip);
void i2c_memory_power_cycle(chip_t *chip);

/* sci.c */
void sci_reset(chip_t *chip);
void sci_power_cycle(chip_t *chip);
uint16_t sci_read(chip_t *chip, uint32_t address);
void sci_write(chip_t *chip, uint32_t address, uint16_t value);
void sci_refresh(chip_t *chip); /* before clock, pins or a debugger's halt change what the line does */
void sci_event(chip_t *chip);
void sci_go(chip_t *chip); /* a debugger's halt ends: chip->debug still has its beginning */

/* sysctrl.c: clocks, flash */
void sysctrl_crystal(chip_t *chip, uint32_t hz);
void sysctrl_reset(chip_t *chip, bool boot_rom);
void sysctrl_write(chip_t *chip, uint32_t address, uint16_t value);
void sysctrl_locked(chip_t *chip); /* event */
void flash_write(chip_t *chip, uint32_t address, uint16_t value);

/* watchdog.c */
void watchdog_reset(chip_t *chip);
bool watchdog_write(chip_t *chip, uint32_t address, uint16_t value); /* false: not its register */
void watchdog_overflow(chip_t *chip);                                /* event */
void watchdog_refresh(chip_t *chip);
void watchdog_halt(chip_t *chip); /* a debugger's halt begins */
void watchdog_go(chip_t *chip);   /* it ends: chip->debug still has its beginning */

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
void gpio_show(chip_t *chip); /* the pins that PWM modules may drive: the first port alone */
uint32_t gpio_mux(const chip_t *chip, uint32_t pin);
uint32_t gpio_trip_low(const chip_t *chip); /* bit n-1: TZn pulled low */

/* pie.c */
void pie_reset(chip_t *chip);
void pie_write(chip_t *chip, uint32_t address, uint16_t value);
void pie_request(chip_t *chip, uint32_t group, uint32_t lines); /* lines: bit y-1 = INTgroup.y */
void cpu_request(chip_t *chip, uint32_t n);                     /* INT13, INT14 */
void cpu_update(chip_t *chip);                                  /* something that gates interrupts changed */
void cpu_enter(chip_t *chip);                                   /* event */
bool cpu_in_background(const chip_t *chip);                     /* the CPU runs it, and no interrupt waits */

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
                 uint32_t mask); /* SOC pulse; mask of ADCTRL2 bits that let it in */
void adc_event(chip_t *chip);    /* event */
void adc_refresh(chip_t *chip);
void adc_schedule(chip_t *chip);
void adc_halt(chip_t *chip); /* a debugger's halt begins */
void adc_go(chip_t *chip);   /* it ends: chip->debug still has its beginning */

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
void epwm_settle(chip_t *chip);               /* everything due at the present tick has happened */
void epwm_event(chip_t *chip);                /* event */
void epwm_refresh(chip_t *chip);              /* TBCTR, TBSTS */
void timebase_hold(chip_t *chip, uint32_t m); /* bring anchor and count to now */
void timebase_plan(chip_t *chip, uint32_t m); /* next event after anchor */
void timebase_start(chip_t *chip, uint32_t m);
void timebase_sync(chip_t *chip, uint32_t m, uint64_t cycle); /* SYNCI pulse at module m */
void timebase_schedule(chip_t *chip);
uint32_t timebase_divider(uint32_t tbctl);
void timebase_debug(chip_t *chip, uint32_t m); /* a debugger's halt began or ended, or FREE_SOFT changed */
bool timebase_stops(const chip_t *chip, uint32_t m); /* a halt under way stops this counter */

/* trigger.c: event trigger */
void trigger_events(chip_t *chip, uint32_t m, uint64_t cycle,
                    uint32_t events);                                       /* events: 1 << epwm_event_t */
void trigger_soc(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t shift); /* shift 0 SOCA, 1 SOCB */
void trigger_write(chip_t *chip, uint32_t m, uint32_t offset, uint16_t value);

/* outputs.c: action qualifier, dead band, trip zone, pins */
void outputs_act(chip_t *chip, uint32_t m, uint64_t cycle, uint32_t events, uint32_t mode, uint32_t up);
void outputs_force(chip_t *chip, uint32_t m, uint64_t cycle);                 /* AQCSFRC becomes active */
void outputs_once(chip_t *chip, uint32_t m, uint64_t cycle, uint16_t aqsfrc); /* one-shot force */
void outputs_inputs(chip_t *chip, uint32_t m, uint64_t cycle);                /* a, b or IN_MODE changed */
void outputs_raw(chip_t *chip, uint32_t m);
void outputs_changed(chip_t *chip); /* trip, mux or latch changed: tell the world */
void outputs_show(chip_t *chip);    /* tell the world if levels changed */
void trip_pins(chip_t *chip);       /* TZ pins or TZSEL changed */
void trip_write(chip_t *chip, uint32_t m, uint32_t offset, uint16_t value);
void trip_zero(chip_t *chip, uint32_t m); /* counter zero releases cycle-by-cycle trips */

/* carrier.c: the plain set-up, fast */
void carrier_try(chip_t *chip,
                 uint64_t cycle); /* counters have just passed zero: take over if all is plain */
void carrier_event(chip_t *chip); /* event */
void carrier_see(chip_t *chip);   /* edges of this period matter after all */
void carrier_leave(chip_t *chip); /* back to the general engine */

static inline bool carrier_has(const chip_t *chip, uint32_t m)
{
    return chip->carrier.active && (chip->carrier.members >> m & 1u) != 0u;
}

static inline uint64_t earlier(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

/* A part's next event. The part that runs ahead (chip->limit) stops before it. */
static inline void chip_plan(chip_t *chip, source_t source, uint64_t tick)
{
    chip->next[source] = tick;
    chip->limit = earlier(chip->limit, tick);
}

/* The duration of these cycles of the crystal, in ticks, up to the next whole one. */
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

/* SYSCLK cycle that is under way at a tick, not before the last change of the clock. tick_of and cycle_of
 * undo each other as long as SYSCLK is at most 150 MHz. */
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

/* Dead band of one module: a rising edge leaves late on the one path, a falling edge on the other; a pulse
 * shorter than the delay never leaves. SPRUG04, dead-band submodule. */
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
