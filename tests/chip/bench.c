#include "bench.h"

#include <string.h>

world_record_t bench;
chip_t bench_chip;
uint32_t bench_isr_skips;
uint32_t bench_samples;
uint64_t bench_sample_at[1024];
uint16_t bench_codes[16];
uint16_t bench_compare[3];
uint32_t bench_first_leg;
void (*bench_on_world)(uint64_t tick, bool analog);
void (*bench_in_interrupt)(void);

static void seen(uint64_t tick)
{
    bench.out_of_order += tick < bench.last_tick;
    bench.last_tick = tick;
}

static double on_analog(void *context, uint64_t tick, uint32_t channel)
{
    (void)context;
    seen(tick);
    if (bench.samples < BENCH_SAMPLES) {
        bench.sample[bench.samples++] = (sample_t){tick, channel};
    }
    if (bench_on_world != NULL) {
        bench_on_world(tick, true);
    }
    return bench.volts[channel];
}

static void on_gates(void *context, uint64_t tick, uint32_t level, uint32_t driven)
{
    (void)context;
    seen(tick);
    if (bench.edges < BENCH_EDGES) {
        bench.edge[bench.edges++] = (edge_t){tick, level, driven};
    }
    if (bench_on_world != NULL) {
        bench_on_world(tick, false);
    }
}

static void on_carrier(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                       bool ends)
{
    (void)context;
    seen(tick);
    if (bench.averages < BENCH_SAMPLES) {
        bench.average[bench.averages++] = (average_t){tick, period, {high[0], high[1], high[2]}, dead, ends};
    }
}

static int64_t on_encoder(void *context, uint64_t tick)
{
    (void)context;
    seen(tick);
    int64_t moved = (int64_t)tick * bench.encoder_rate;
    return bench.encoder_offset + (moved >= 0 ? moved >> 20 : -((-moved) >> 20));
}

chip_world_t bench_world = {
    .analog = on_analog, .gates = on_gates, .carrier = on_carrier, .encoder = on_encoder};

void bench_power_on(void)
{
    bench_power_on_with(30000000u);
}

void bench_power_on_with(uint32_t crystal_hz)
{
    memset(&bench, 0, sizeof bench);
    bench_isr_skips = 0u;
    bench_samples = 0u;
    bench_in_interrupt = NULL;
    bench_on_world = NULL;
    bench_first_leg = 1u;
    bench_world.active_low = 0u;
    for (uint32_t i = 0u; i < 3u; i++) {
        bench_compare[i] = 3750u;
    }
    memset(bench_codes, 0, sizeof bench_codes);
    chip_power_on(&bench_chip, crystal_hz);
    chip_bind(&bench_chip, &bench_world);
}

void bench_forget(void)
{
    bench.edges = 0u;
    bench.samples = 0u;
    bench.averages = 0u;
}

void bench_allowed16(const volatile uint16_t *reg, uint16_t value)
{
    bus_allow();
    bus_write16(reg, value);
    bus_protect();
}

void bench_allowed32(const volatile uint32_t *reg, uint32_t value)
{
    bus_allow();
    bus_write32(reg, value);
    bus_protect();
}

uint32_t bench_reports(chip_report_kind_t kind)
{
    return chip_report_count(&bench_chip, kind);
}

void bench_clock(void)
{
    bus_allow();
    bus_write16(&SYSCTRL->WDCR, WDCR_WDDIS | WDCR_WDCHK);
    bus_write16(&SYSCTRL->PLLSTS, 0u);
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_MCLKOFF);
    bus_write16(&SYSCTRL->PLLCR, 10u);
    for (uint32_t i = 0u; i < 100000u && (SYSCTRL->PLLSTS & PLLSTS_PLLLOCKS) == 0u; i++) {
        bus_wait(1000u);
    }
    bus_write16(&SYSCTRL->PLLSTS, 0u);
    bus_write16(&FLASH_REGS->FBANKWAIT, 0x0505u);
    bus_write16(&FLASH_REGS->FOTPWAIT, 8u);
    bus_write16(&SYSCTRL->PLLSTS, PLLSTS_DIVSEL(2u));
    bus_write16(&SYSCTRL->HISPCP, 3u);
    bus_write16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC);
    bus_write16(&SYSCTRL->PCLKCR1, PCLKCR1_EPWM1 | PCLKCR1_EPWM2 | PCLKCR1_EPWM3 | PCLKCR1_EQEP1);
    bus_wait(2u);
    bus_protect();
}

void bench_pwm(uint32_t skip)
{
    uint16_t slow = (skip & SKIP_HSPCLKDIV) != 0u ? TBCTL_HSPCLKDIV(1) : 0u;
    if ((skip & SKIP_CLOCK_PWM2) != 0u) {
        bench_allowed16(&SYSCTRL->PCLKCR1, PCLKCR1_EPWM1 | PCLKCR1_EPWM3 | PCLKCR1_EQEP1);
    }
    for (uint32_t n = 1u; n <= 3u; n++) {
        bus_write16(&EPWM(n)->TBPRD, 7500u);
        bus_write16(&EPWM(n)->TBPHS, n == 1u ? 0u : 2u);
        bus_write16(&EPWM(n)->TBCTL, (uint16_t)((n == 1u ? 0x4012u : 0x6006u) | slow));
        bus_write16(&EPWM(n)->CMPCTL, 0u);
        bus_write16(&EPWM(n)->CMPA, bench_compare[n - 1u]);
        bus_write16(&EPWM(n)->CMPB, 87u);
        bus_write16(&EPWM(n)->AQCTLA, AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET));
        bus_write16(&EPWM(n)->DBRED, 450u);
        bus_write16(&EPWM(n)->DBFED, 450u);
        bus_write16(&EPWM(n)->DBCTL, (skip & WRONG_POLARITY) != 0u ? DBCTL_OUT_BOTH : 0x000Bu);
        if ((skip & SKIP_EALLOW_PWM) == 0u) {
            bus_allow();
        }
        bus_write16(&EPWM(n)->TZSEL, TZSEL_OSHT1);
        bus_write16(&EPWM(n)->TZCTL, 0x000Au);
        bus_write16(&EPWM(n)->TZFRC, TZ_OST);
        bus_protect();
    }
    bus_allow();
    bus_write32(&GPIO_CONTROL(0u)->QSEL1, GPIO_FIELD(12u, GPIO_QSEL_ASYNC));
    bus_write32(&GPIO_CONTROL(0u)->MUX1, 0x01000555u);
    bus_protect();
}

void bench_adc(uint32_t skip)
{
    bus_write16(&ADC->ADCTRL1, 0x0410u);
    bus_write16(&ADC->ADCTRL3, (skip & SKIP_ADC_POWER) != 0u ? 0x0001u : 0x00E1u);
    bus_wait(750000u);
    bus_write16(&ADC->ADCMAXCONV, 3u);
    bus_write16(&ADC->ADCCHSELSEQ[0], 0x2100u);
    bus_write16(&ADC->ADCTRL2, 0x0900u | ADCTRL2_RST_SEQ1);
    if ((skip & SKIP_SOC) == 0u) {
        bus_write16(&EPWM(1u)->ETSEL, ETSEL_SOCAEN | ETSEL_SOCASEL(ET_CMPB_DOWN));
        bus_write16(&EPWM(1u)->ETPS, ETPS_SOCAPRD(1));
    }
}

void bench_interrupt(void)
{
    if (bench_samples < 1024u) {
        bench_sample_at[bench_samples] = chip_now(&bench_chip);
    }
    bench_samples++;
    for (uint32_t i = 0u; i < 16u; i++) {
        bench_codes[i] = ADC_MIRROR->ADCRESULT[i];
    }
    for (uint32_t leg = 0u; leg < 3u; leg++) {
        bus_write16(&EPWM(bench_first_leg + leg)->CMPA, bench_compare[leg]);
    }
    if (bench_in_interrupt != NULL) {
        bench_in_interrupt();
    }
    if ((bench_isr_skips & SKIP_RST_SEQ1) == 0u) {
        bus_write16(&ADC->ADCTRL2, (uint16_t)(ADC->ADCTRL2 | ADCTRL2_RST_SEQ1));
    }
    if ((bench_isr_skips & SKIP_INT_CLR) == 0u) {
        bus_write16(&ADC->ADCST, ADCST_INT_SEQ1_CLR);
    }
    if ((bench_isr_skips & SKIP_PIEACK) == 0u) {
        bus_write16(&PIE->PIEACK, 1u);
    }
}

void bench_interrupts(uint32_t skip)
{
    bus_allow();
    if ((skip & SKIP_VECTOR) == 0u) {
        bus_write32(&PIE_VECTORS->vector[PIE_SEQ1INT], bus_vector(bench_interrupt));
    }
    bus_protect();
    bus_write16(&PIE->PIECTRL, PIECTRL_ENPIE);
    bus_write16(&PIE->group[0].IER, 1u);
    bus_enable_group(1u);
    bus_interrupts_enable();
}

void bench_start(uint32_t skip)
{
    bench_clock();
    bench_pwm(skip);
    bench_adc(skip);
    bench_interrupts(skip);
    if ((skip & SKIP_TBCLKSYNC) == 0u) {
        bench_allowed16(&SYSCTRL->PCLKCR0, PCLKCR0_ADC | PCLKCR0_TBCLKSYNC);
    }
    if ((skip & SKIP_RELEASE) == 0u) {
        bus_allow();
        for (uint32_t n = 1u; n <= 3u; n++) {
            bus_write16(&EPWM(n)->TZCLR, TZ_OST | TZ_INT);
        }
        bus_protect();
    }
}

uint32_t bench_edges_of(uint32_t pin, uint64_t from, uint64_t to)
{
    uint32_t changes = 0u;
    uint32_t level = 0u;
    for (uint32_t i = 0u; i < bench.edges; i++) {
        uint32_t now = (bench.edge[i].level >> pin) & 1u;
        changes += now != level && bench.edge[i].tick >= from && bench.edge[i].tick < to;
        level = now;
    }
    return changes;
}

uint64_t bench_high_of(uint32_t pin, uint64_t from, uint64_t to)
{
    uint64_t high = 0u;
    uint64_t since = 0u;
    uint32_t level = 0u;
    for (uint32_t i = 0u; i <= bench.edges; i++) {
        uint64_t tick = i < bench.edges ? bench.edge[i].tick : to;
        if (level) {
            uint64_t begin = since > from ? since : from;
            uint64_t end = tick < to ? tick : to;
            high += end > begin ? end - begin : 0u;
        }
        since = tick;
        level = i < bench.edges ? (bench.edge[i].level >> pin) & 1u : 0u;
    }
    return high;
}
