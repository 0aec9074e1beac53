#include "tests/hal/recording_bus.h"

#include <string.h>

#include "hal/f28335/flash_api.h"
#include "unity.h"

#define VECTOR_BASE UINT32_C(0x300000)

bus_recording_t rec;
__thread const volatile uint16_t *f28335_base;

static bool is(uint32_t address, const volatile void *reg)
{
    return address == recording_address(reg);
}

uint32_t recording_address(const volatile void *reg)
{
    return (uint32_t)((const volatile uint16_t *)reg - f28335_base);
}

void recording_clear_log(void)
{
    rec.entries = 0u;
    rec.overflows = 0u;
}

void recording_reset(void)
{
    memset(&rec, 0, sizeof rec);
    f28335_base = (const volatile uint16_t *)&rec.regs;
    rec.lock_cycles = 131072u / 4u;
    rec.api_words = RECORDING_API_WORDS;
    rec.api_version = 0x0210u;
    rec.regs.sysctrl.PLLSTS = PLLSTS_DIVSEL(2u);
    rec.regs.sysctrl.HISPCP = 1u;
    rec.regs.sysctrl.LOSPCP = 2u;
    rec.regs.sysctrl.PCLKCR3 = 0x2700u;
    rec.regs.flash.FBANKWAIT = 0x0F0Fu;
    rec.regs.gpio_data[0].DAT = 0xFFFFFFFFu;
    for (uint32_t n = 0; n < 6u; n++) {
        rec.regs.epwm[n].TBCTL = 0x0083u;
    }
}

void recording_soil(void)
{
    memset(&rec.regs.epwm, 0xFF, sizeof rec.regs.epwm);
    memset(&rec.regs.eqep, 0xFF, sizeof rec.regs.eqep);
    memset(&rec.regs.cpu_timer, 0xA5, sizeof rec.regs.cpu_timer);
    memset(&rec.regs.adc, 0xFF, sizeof rec.regs.adc);
    for (uint32_t n = 0; n < 6u; n++) {
        rec.regs.epwm[n].TZFLG = 0u; /* read-only register */
    }
}

static void note(did_t did, uint32_t address, uint32_t value)
{
    if (rec.entries == RECORDING_MAX) {
        rec.overflows++;
        return;
    }
    rec.entry[rec.entries++] = (entry_t){did, address, value, rec.allowed};
}

static void set16(uint32_t address, uint32_t value)
{
    const uint16_t word = (uint16_t)value;
    memcpy((char *)&rec.regs + address * sizeof word, &word, sizeof word);
}

static void trip_registers(uint32_t address, uint32_t value)
{
    for (uint16_t n = 0; n < 3u; n++) {
        epwm_regs_t *leg = &rec.regs.epwm[n];
        const uint16_t bit = (uint16_t)(1u << n);
        if (is(address, &leg->TZFRC)) {
            leg->TZFRC = 0u;
            if ((rec.trip_deaf & bit) == 0u) {
                leg->TZFLG =
                    (uint16_t)(leg->TZFLG | (value & TZ_OST) | ((leg->TZEINT & value & TZ_OST) != 0u));
            }
        }
        if (is(address, &leg->TZCLR)) {
            leg->TZCLR = 0u;
            leg->TZFLG = (uint16_t)(leg->TZFLG & ~value);
            if ((rec.trip_again & bit) != 0u) {
                leg->TZFLG = TZ_OST | TZ_INT;
            }
        }
    }
}

/* Reads a register. Of SCI-A the receive FIFO is simulated. */
uint16_t bus_read16(const volatile uint16_t *reg)
{
    sci_regs_t *sci = &rec.regs.scia;
    const uint16_t value = *reg;
    if (reg == &sci->SCIRXBUF && rec.octets_taken < rec.octets_came) {
        const uint16_t octet = rec.octet[rec.octets_taken++];
        sci->SCIFFRX = (uint16_t)((sci->SCIFFRX & ~0x1F00u) | (rec.octets_came - rec.octets_taken) << 8);
        return octet;
    }
    return value;
}

static void serial_registers(uint32_t address, uint32_t value)
{
    sci_regs_t *sci = &rec.regs.scia;
    if (is(address, &sci->SCIFFRX)) { /* level and overflow are read only */
        const uint32_t overflow = (value & SCIFFRX_RXFFOVRCLR) != 0u ? 0u : rec.overrun;
        rec.overrun = overflow;
        sci->SCIFFRX = (uint16_t)((value & 0x2000u) | overflow | (rec.octets_came - rec.octets_taken) << 8);
    }
    if (is(address, &sci->SCICTL1) && (value & SCICTL1_SWRESET) == 0u) {
        sci->SCIRXST = 0u;
    }
}

void recording_receive(uint16_t word)
{
    sci_regs_t *sci = &rec.regs.scia;
    rec.octet[rec.octets_came++] = word;
    sci->SCIFFRX = (uint16_t)((sci->SCIFFRX & ~0x1F00u) | (rec.octets_came - rec.octets_taken) << 8);
}

void recording_overrun(void)
{
    rec.overrun = SCIFFRX_RXFFOVF;
    rec.regs.scia.SCIFFRX |= SCIFFRX_RXFFOVF;
}

static void come_alive(uint32_t address, uint32_t value)
{
    f28335_t *regs = &rec.regs;
    trip_registers(address, value);
    serial_registers(address, value);
    if (is(address, &regs->sysctrl.PLLCR)) {
        rec.pllcr_written = rec.waited;
        regs->sysctrl.PLLSTS = (uint16_t)(regs->sysctrl.PLLSTS & ~PLLSTS_PLLLOCKS);
    }
    if (is(address, &regs->eqep[0].QCLR)) {
        regs->eqep[0].QFLG = (uint16_t)(regs->eqep[0].QFLG & ~value);
        regs->eqep[0].QCLR = 0u;
    }
    if (is(address, &regs->cpu_timer[0].TCR) && (value & TCR_TRB) != 0u) {
        regs->cpu_timer[0].TIM = regs->cpu_timer[0].PRD;
    }
}

void bus_write16(const volatile uint16_t *reg, uint16_t value)
{
    const uint32_t address = recording_address(reg);
    note(DID_WRITE16, address, value);
    if (is(address, &rec.regs.sysctrl.PLLSTS)) { /* lock and missing clock are read only */
        const unsigned read_only = PLLSTS_PLLLOCKS | PLLSTS_MCLKSTS;
        value = (uint16_t)((value & ~read_only) | (rec.regs.sysctrl.PLLSTS & read_only));
    }
    set16(address, value);
    come_alive(address, value);
}

void bus_write32(const volatile uint32_t *reg, uint32_t value)
{
    const uint32_t address = recording_address(reg);
    note(DID_WRITE32, address, value);
    set16(address, value & 0xFFFFu);
    set16(address + 1u, value >> 16);
}

void bus_allow(void)
{
    rec.nested += rec.allowed;
    rec.allowed = true;
}

void bus_protect(void)
{
    rec.nested += !rec.allowed;
    rec.allowed = false;
}

uint32_t bus_vector(bus_isr_t isr)
{
    uint32_t n = 0;
    while (n < rec.functions && rec.function[n] != isr) {
        n++;
    }
    if (n == rec.functions && n < 5u) {
        rec.function[rec.functions++] = isr;
    }
    return VECTOR_BASE + n;
}

void bus_enable_group(uint16_t group)
{
    note(DID_ENABLE_GROUP, 0u, group);
    rec.groups = (uint16_t)(rec.groups | 1u << (group - 1u));
}

void bus_request_group(uint16_t group)
{
    note(DID_REQUEST_GROUP, 0u, group);
}

void bus_interrupts_enable(void)
{
    note(DID_INTERRUPTS_ON, 0u, 0u);
    rec.interrupts_on = true;
}

void bus_interrupts_disable(void)
{
    note(DID_INTERRUPTS_OFF, 0u, 0u);
    rec.interrupts_on = false;
}

void bus_disable_groups(void)
{
    note(DID_DISABLE_GROUPS, 0u, 0u);
    rec.groups = 0u;
}

void bus_clear_pending(void)
{
    note(DID_CLEAR_PENDING, 0u, 0u);
}

void bus_debug_groups(uint16_t mask)
{
    note(DID_DEBUG_GROUPS, 0u, mask);
    rec.debug_groups = mask;
}

void bus_debug_allow(void)
{
    note(DID_DEBUG_ALLOW, 0u, 0u);
    rec.debug_allowed = true;
}

bus_memory_t bus_memory(bus_region_t region)
{
    return (bus_memory_t){&rec.memory[region], 1u + (uint32_t)region};
}

static uint16_t *flash_word(uint32_t address)
{
    return address - RECORDING_FLASH_AT < 2u * RECORDING_FLASH_WORDS
               ? &rec.flash[address - RECORDING_FLASH_AT]
               : &rec.flash_beside;
}

uint16_t bus_flash(uint32_t address)
{
    return *flash_word(address);
}

/* ---- TI's flash API: words whose table names two variables, and functions at their addresses ---- */

static const uint16_t api[RECORDING_API_WORDS] = {[8] = 0x8000u + RECORDING_API_SCALE,
                                                  [10] = 0x8000u + RECORDING_API_SCALE + 2u,
                                                  [RECORDING_API_WORDS - 1u] = 0xA15Au};

bus_memory_t bus_flash_api(void)
{
    return (bus_memory_t){api, rec.api_words};
}

uint16_t *bus_code_ram(void)
{
    return rec.code;
}

void bus_copy_code(void)
{
    note(DID_COPY_CODE, 0u, 0u);
    memset(rec.code, 0, sizeof rec.code);
}

static uint16_t erase(uint16_t sectors, flash_api_status_t *status)
{
    (void)status;
    note(DID_ERASE, 0u, sectors);
    if (!rec.flash_broken) {
        for (uint32_t n = 0; n < RECORDING_FLASH_WORDS; n++) {
            *flash_word(RECORDING_FLASH_AT + n + (sectors == 4u ? 0u : RECORDING_FLASH_WORDS)) = 0xFFFFu;
        }
    }
    return rec.flash_broken ? 22u : 0u;
}

static uint16_t program(uint16_t *at, uint16_t *words, uint32_t count, flash_api_status_t *status)
{
    (void)status;
    note(DID_PROGRAM, (uint32_t)(uintptr_t)at, words[0]);
    TEST_ASSERT_EQUAL_UINT32(1u, count);
    *flash_word((uint32_t)(uintptr_t)at) &= words[0];
    return rec.flash_broken ? 30u : 0u;
}

static uint16_t verify(uint16_t *at, uint16_t *words, uint32_t count, flash_api_status_t *status)
{
    (void)status;
    return count == 1u && *flash_word((uint32_t)(uintptr_t)at) == words[0] ? 0u : 40u;
}

static uint16_t version(void)
{
    return rec.api_version;
}

bus_function_t bus_function_at(uint32_t address)
{
    static const bus_function_t functions[4] = {(bus_function_t)erase, (bus_function_t)program,
                                                (bus_function_t)verify, (bus_function_t)version};
    const uint32_t place = address - 0x8000u;
    TEST_ASSERT_TRUE(place % 2u == 0u && place < 8u);
    TEST_ASSERT_EQUAL_HEX16(0xA15Au, rec.code[RECORDING_API_WORDS - 1u]);
    return functions[place / 2u];
}

uint16_t bus_otp(uint32_t address)
{
    return address == 0x380083u ? rec.otp[0] : address == 0x380085u ? rec.otp[1] : 0xFFFFu;
}

void recording_pass(uint32_t cycles)
{
    rec.waited += cycles;
    if ((rec.regs.cpu_timer[0].TCR & TCR_TSS) == 0u) {
        rec.regs.cpu_timer[0].TIM -= cycles;
    }
}

void bus_wait(uint32_t cycles)
{
    sysctrl_regs_t *sysctrl = &rec.regs.sysctrl;
    rec.nested += rec.allowed;
    if (rec.entries == 0u || rec.entry[rec.entries - 1u].did != DID_WAIT) {
        note(DID_WAIT, 0u, cycles);
    } else { /* each poll counts as one wait */
        rec.entry[rec.entries - 1u].value += cycles;
    }
    recording_pass(cycles);
    if (sysctrl->PLLCR != 0u && rec.waited - rec.pllcr_written >= rec.lock_cycles) {
        sysctrl->PLLSTS |= PLLSTS_PLLLOCKS;
        if (rec.loses_clock_at_lock) {
            sysctrl->PLLSTS |= PLLSTS_MCLKSTS;
        }
    }
}

static uint32_t find(uint32_t from, const volatile void *reg, const uint32_t *value)
{
    uint32_t i;
    for (i = from; i < rec.entries; i++) {
        const entry_t *e = &rec.entry[i];
        const bool is_write = e->did == DID_WRITE16 || e->did == DID_WRITE32;
        if (is_write && is(e->address, reg) && (value == NULL || e->value == *value)) {
            break;
        }
    }
    return i;
}

uint32_t recording_find(uint32_t from, const volatile void *reg)
{
    return find(from, reg, NULL);
}

uint32_t recording_find_value(uint32_t from, const volatile void *reg, uint32_t value)
{
    return find(from, reg, &value);
}

uint32_t recording_count(const volatile void *reg)
{
    uint32_t count = 0;
    for (uint32_t i = recording_find(0u, reg); i < rec.entries; i = recording_find(i + 1u, reg)) {
        count++;
    }
    return count;
}
