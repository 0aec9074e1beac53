/* Power-on, reset, binding to a thread and the event loop; reports and questions. */
#include "hal/f28335/registers.h"

/* The state contains no padding, so that equal chips are equal octet by octet. */
#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded"
#include "host_sim/chip/chip.h"
#pragma GCC diagnostic pop

#include <assert.h>
#include <string.h>

#include "host_sim/chip/parts.h"

__thread const volatile uint16_t *f28335_base;
__thread const chip_world_t *chip_world;
__thread chip_t *chip_bound;

static double no_voltage(void *context, uint64_t tick, uint32_t channel)
{
    (void)context;
    (void)tick;
    (void)channel;
    return 0.0;
}

static void no_gates(void *context, uint64_t tick, uint32_t level, uint32_t driven)
{
    (void)context;
    (void)tick;
    (void)level;
    (void)driven;
}

static void no_carrier(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                       bool ends)
{
    (void)context;
    (void)tick;
    (void)period;
    (void)high;
    (void)dead;
    (void)ends;
}

static int64_t no_encoder(void *context, uint64_t tick)
{
    (void)context;
    (void)tick;
    return 0;
}

const chip_world_t chip_unconnected = {
    .analog = no_voltage, .gates = no_gates, .carrier = no_carrier, .encoder = no_encoder};

static void power_on(chip_t *chip, uint32_t crystal_hz, bool boot_rom)
{
    assert(crystal_hz >= 20000000u && crystal_hz <= 35000000u && crystal_hz % 1000u == 0u);
    memset(chip, 0, sizeof *chip);
    sysctrl_crystal(chip, crystal_hz);
    for (uint32_t channel = 0u; channel < 16u; channel++) {
        chip->adc.stuck[channel] = -1;
    }
    chip->gpio_input[0] = 0xFFFFF000u;
    chip->gpio_input[1] = 0xFFFFFFFFu;
    chip->gpio_input[2] = 0x00FFFFFFu;
    chip->carrier_tick = CHIP_NEVER;
    chip->sample_tick = CHIP_NEVER;
    memory_power_on(chip);
    flash_power_on(chip);
    i2c_memory_power_on(chip);
    chip_reset(chip, boot_rom);
    chip->cpu.halted = 0u;
}

void chip_power_on(chip_t *chip, uint32_t crystal_hz)
{
    power_on(chip, crystal_hz, true);
}

void chip_power_on_by_debugger(chip_t *chip, uint32_t crystal_hz)
{
    power_on(chip, crystal_hz, false);
}

/* A reset by XRS or the watchdog, up to the jump of the boot ROM to flash if it runs. Time, pins of the
 * board
 * and injected faults stay. The caller decides whether software runs. */
void chip_reset(chip_t *chip, bool boot_rom)
{
    memset(&chip->registers, 0, sizeof chip->registers);
    for (uint32_t i = 0u; i < SOURCES; i++) {
        chip->next[i] = CHIP_NEVER;
    }
    flash_reset(chip);
    sysctrl_reset(chip, boot_rom);
    watchdog_reset(chip);
    timer_reset(chip);
    gpio_reset(chip);
    pie_reset(chip);
    eqep_reset(chip);
    adc_reset(chip, boot_rom);
    epwm_reset(chip);
    sci_reset(chip);
    i2c_reset(chip);
    chip_schedule_rare(chip);
    chip_refresh(chip);
    gpio_refresh(chip);
}

void chip_power_cycle(chip_t *chip)
{
    sci_power_cycle(chip);
    i2c_memory_power_cycle(chip);
    memory_power_on(chip);
    chip->flash.cut = 0u;
    chip->flash.operations = 0u;
    chip->carrier_tick = CHIP_NEVER;
    chip->sample_tick = CHIP_NEVER;
    chip_reset(chip, true);
    chip->cpu.halted = 0u;
}

void chip_boot(chip_t *chip)
{
    pie_reset(chip);
    chip->cpu.halted = 0u;
}

void chip_bind(chip_t *chip, const chip_world_t *world)
{
    chip_bound = chip;
    chip_world = world != NULL ? world : &chip_unconnected;
    f28335_base = (const volatile uint16_t *)&chip->registers;
}

void chip_schedule_rare(chip_t *chip)
{
    chip_plan(
        chip, SOURCE_RARE,
        earlier(earlier(chip->clock.locked, chip->watchdog.next), earlier(chip->timer_next, chip->sci.next)));
}

static void rare_event(chip_t *chip)
{
    if (chip->clock.locked <= chip->tick) {
        sysctrl_locked(chip);
    }
    if (chip->timer_next <= chip->tick) {
        timer_events(chip);
    }
    if (chip->sci.next <= chip->tick) {
        sci_event(chip);
    }
    if (chip->watchdog.next <= chip->tick) {
        watchdog_overflow(chip);
    }
    chip_schedule_rare(chip);
}

/* One step of the search for the earliest event and for the one after it. */
static inline void consider(const chip_t *chip, source_t candidate, uint64_t *at, uint64_t *limit,
                            source_t *source)
{
    uint64_t next = chip->next[candidate];
    bool first = next < *at;
    *limit = first ? *at : earlier(next, *limit);
    *source = first ? candidate : *source;
    *at = first ? next : *at;
}

/* true: an interrupt has returned to the background, and a caller waits for that. */
static bool engine(chip_t *chip, uint64_t until, bool to_background)
{
    for (;;) {
        uint64_t at = until;
        uint64_t limit = until;
        source_t source = SOURCES;
        consider(chip, SOURCE_EPWM, &at, &limit, &source);
        consider(chip, SOURCE_EQEP, &at, &limit, &source);
        consider(chip, SOURCE_ADC, &at, &limit, &source);
        consider(chip, SOURCE_CPU, &at, &limit, &source);
        consider(chip, SOURCE_RARE, &at, &limit, &source);
        if (source == SOURCES) {
            break;
        }
        chip->limit = limit;
        if (at > chip->tick) {
            chip->tick = at;
        }
        switch (source) {
        case SOURCE_EPWM:
            epwm_event(chip);
            break;
        case SOURCE_EQEP:
            eqep_timeout(chip);
            break;
        case SOURCE_ADC:
            adc_event(chip);
            break;
        case SOURCE_CPU:
            cpu_enter(chip);
            if (to_background && cpu_in_background(chip)) {
                return true;
            }
            break;
        case SOURCE_RARE:
            rare_event(chip);
            break;
        case SOURCES:
            break;
        }
    }
    if (chip->tick < until) {
        chip->tick = until;
    }
    return false;
}

void chip_engine(chip_t *chip, uint64_t until)
{
    (void)engine(chip, until, false);
}

void chip_refresh(chip_t *chip)
{
    epwm_refresh(chip);
    timer_refresh(chip);
    eqep_refresh(chip);
    adc_refresh(chip);
    watchdog_refresh(chip);
}

void chip_run(uint64_t until)
{
    chip_t *chip = chip_bound;
    assert(chip != NULL);
    chip_engine(chip, until);
}

bool chip_run_to_background(uint64_t until)
{
    assert(chip_bound != NULL);
    return engine(chip_bound, until, true);
}

void chip_look(chip_t *chip)
{
    chip_refresh(chip);
}

void chip_set_pin(chip_t *chip, uint32_t gpio, bool high)
{
    assert(gpio < 88u);
    uint32_t bit = UINT32_C(1) << (gpio % 32u);
    uint32_t *port = &chip->gpio_input[gpio / 32u];
    *port = high ? (*port | bit) : (*port & ~bit);
    gpio_refresh(chip);
    trip_pins(chip);
}

void chip_set_averaged(chip_t *chip, bool averaged)
{
    chip->averaged = averaged ? 1u : 0u;
}

void chip_set_interrupt_delay(chip_t *chip, uint32_t ticks)
{
    chip->cpu.delay = ticks;
}

void chip_stick_adc(chip_t *chip, uint32_t channel, int32_t code)
{
    assert(channel < 16u && code >= -1 && code <= 4095);
    chip->adc.stuck[channel] = code;
}

void chip_miss_samples(chip_t *chip, uint32_t count)
{
    chip->adc.missing = count;
}

void chip_report(chip_t *chip, chip_report_kind_t kind, uint32_t address)
{
    chip_report_t *report = &chip->reports[chip->report_total % CHIP_REPORTS];
    report->tick = chip->tick;
    report->address = address;
    report->kind = (uint32_t)kind;
    chip->report_total++;
    chip->report_count[kind]++;
}

uint64_t chip_now(const chip_t *chip)
{
    return chip->tick;
}

uint32_t chip_sysclk_hz(const chip_t *chip)
{
    return (uint32_t)(CHIP_TICKS_PER_SECOND * chip->clock.cycles / chip->clock.ticks);
}

bool chip_halted(const chip_t *chip)
{
    return chip->cpu.halted != 0u;
}

bool chip_tripped(const chip_t *chip, uint32_t leg)
{
    assert(leg >= 1u && leg <= CHIP_EPWMS);
    return (chip->registers.epwm[leg - 1u].TZFLG & TZ_OST) != 0u || chip->epwm[leg - 1u].cbc != 0u;
}

bool chip_restart_asked(const chip_t *chip)
{
    return chip->cpu.halted != 0u && chip->cpu.asked != 0u;
}

bool chip_carrier_plain(const chip_t *chip)
{
    return chip->carrier.active != 0u;
}

uint64_t chip_carrier_tick(const chip_t *chip)
{
    return chip->carrier_tick;
}

uint64_t chip_carrier_zero(const chip_t *chip, uint32_t n)
{
    uint32_t first = chip->pins.first;
    const chip_epwm_t *epwm = &chip->epwm[first];
    uint32_t mode = chip->registers.epwm[first].TBCTL & 3u;
    uint64_t counts = mode == TBCTL_UPDOWN ? 2u * (uint64_t)epwm->period : (uint64_t)epwm->period + 1u;
    if (chip->carrier_tick == CHIP_NEVER || n == 0u) {
        return chip->carrier_tick;
    }
    return tick_of(chip, chip->carrier_cycle + n * counts * epwm->divider);
}

uint64_t chip_sample_tick(const chip_t *chip)
{
    return chip->sample_tick;
}

uint32_t chip_interrupt_count(const chip_t *chip, uint32_t vector)
{
    assert(vector < 128u);
    return chip->entries[vector];
}

uint32_t chip_report_count(const chip_t *chip, chip_report_kind_t kind)
{
    assert(kind < CHIP_REPORT_KINDS);
    return chip->report_count[kind];
}

uint32_t chip_report_total(const chip_t *chip)
{
    return chip->report_total;
}

const chip_report_t *chip_last_report(const chip_t *chip)
{
    return chip->report_total == 0u ? NULL : &chip->reports[(chip->report_total - 1u) % CHIP_REPORTS];
}
