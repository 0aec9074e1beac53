/* PIE and the CPU's interrupt logic: SPRUFB0 ch. 6, SPRU430 ch. 3.
 *
 * A peripheral's pulse sets PIEIFRx.y. The lowest enabled flag of a group goes to the CPU if PIEACKx is 0,
 * and sets PIEACKx: a forgotten acknowledge blocks the group permanently. While ENPIE is 0 nothing goes to
 * the CPU. The CPU takes the lowest enabled IFR bit when INTM is 0, clears its IFR and IER bits, sets INTM
 * and DBGM, closes EALLOW; the return restores all of these. An interrupt function that clears INTM and waits
 * can be interrupted by other groups. */
#include "host_sim/chip/parts.h"

#include <stdio.h>
#include <stdlib.h>

/* [SYSCLK] flag to first instruction: 9 for vector fetch and automatic save (SPRUFB0), the rest recognition;
 * no available document confirms the total of 14. */
#define LATENCY_CYCLES 14u
#define PIE_GROUPS     12u

/* A 32-bit PIE vector cannot hold a host pointer: it holds the distance from this function, the same for
 * every run of one program. */
static void anchor(void)
{
}

uint32_t bus_vector(bus_isr_t isr)
{
    if (isr == NULL) {
        return 0u;
    }
    int64_t distance = (int64_t)(uintptr_t)isr - (int64_t)(uintptr_t)anchor;
    if (distance < INT32_MIN || distance > INT32_MAX) {
        fputs("bus_vector: interrupt function and virtual chip are more than 2 GB apart\n", stderr);
        abort();
    }
    return (uint32_t)(int32_t)distance;
}

static bus_isr_t function_of(uint32_t vector)
{
    return (bus_isr_t)(uintptr_t)((int64_t)(uintptr_t)anchor + (int32_t)vector);
}

static void group_changed(chip_t *chip, uint32_t group)
{
    const pie_group_t *pie = &chip->registers.pie.group[group - 1u];
    uint32_t bit = 1u << (group - 1u);
    chip->cpu.groups = (pie->IER & pie->IFR) != 0u ? (chip->cpu.groups | bit) : (chip->cpu.groups & ~bit);
}

/* The interrupt that the CPU would accept now. During a debugger's halt no interrupt is accepted. In
 * real-time mode those
 * that DBGIER names are accepted, for each state of INTM. */
static uint32_t takable(const chip_t *chip)
{
    const chip_cpu_t *cpu = &chip->cpu;
    if (cpu->halted) {
        return 0u;
    }
    if (chip->debug.halted) {
        return chip->debug.realtime ? cpu->ifr & cpu->ier & cpu->dbgier : 0u;
    }
    return cpu->interrupts_off ? 0u : cpu->ifr & cpu->ier;
}

bool cpu_in_background(const chip_t *chip)
{
    const chip_cpu_t *cpu = &chip->cpu;
    return !cpu->halted && !chip->debug.halted && !cpu->interrupts_off && takable(chip) == 0u;
}

void cpu_update(chip_t *chip)
{
    bool enabled = (chip->registers.pie.PIECTRL & PIECTRL_ENPIE) != 0u;
    uint32_t send = enabled ? chip->cpu.groups & ~(uint32_t)chip->registers.pie.PIEACK : 0u;
    chip->registers.pie.PIEACK |= (uint16_t)send;
    chip->cpu.ifr |= send;
    if (takable(chip) == 0u) {
        chip->next[SOURCE_CPU] = CHIP_NEVER;
    } else if (chip->next[SOURCE_CPU] == CHIP_NEVER) {
        const bool from_outside = (takable(chip) & ((1u << PIE_GROUPS) - 1u)) != 0u;
        uint64_t entry =
            tick_of(chip, cycle_now(chip) + LATENCY_CYCLES) + (from_outside ? chip->cpu.delay : 0u);
        chip_plan(chip, SOURCE_CPU, entry > chip->cpu.busy_until ? entry : chip->cpu.busy_until);
    }
}

void pie_request(chip_t *chip, uint32_t group, uint32_t lines)
{
    chip->registers.pie.group[group - 1u].IFR |= (uint16_t)lines;
    group_changed(chip, group);
    cpu_update(chip);
}

void cpu_request(chip_t *chip, uint32_t n)
{
    chip->cpu.ifr |= 1u << (n - 1u);
    cpu_update(chip);
}

void pie_reset(chip_t *chip)
{
    chip->cpu.interrupts_off = 1u;
    chip->cpu.section = 1u;
    chip->cpu.busy_until = 0u;
    chip->cpu.dbgm = 1u;
    chip->cpu.dbgier = 0u;
    chip->cpu.ier = 0u;
    chip->cpu.ifr = 0u;
    chip->cpu.groups = 0u;
    chip->cpu.allow = 0u;
    chip->next[SOURCE_CPU] = CHIP_NEVER;
    for (uint32_t group = 1u; group <= PIE_GROUPS; group++) {
        group_changed(chip, group);
    }
}

/* The vector of the interrupt that the CPU takes now. If software has cleared the last enabled flag of the
 * group, the first vector of the group is fetched, according to the manual. */
static uint32_t fetch(chip_t *chip, uint32_t n)
{
    if (n > PIE_GROUPS) {
        return n;
    }
    pie_group_t *pie = &chip->registers.pie.group[n - 1u];
    uint32_t lines = pie->IER & pie->IFR;
    uint32_t line = lines != 0u ? (uint32_t)__builtin_ctz(lines) : 0u;
    pie->IFR &= (uint16_t) ~(1u << line);
    group_changed(chip, n);
    return 32u + 8u * (n - 1u) + line;
}

void cpu_enter(chip_t *chip)
{
    chip->next[SOURCE_CPU] = CHIP_NEVER;
    uint32_t n = (uint32_t)__builtin_ctz(takable(chip)) + 1u;
    uint32_t vector = fetch(chip, n);
    uint32_t ier = chip->cpu.ier;
    uint32_t allow = chip->cpu.allow;
    uint32_t masked = chip->cpu.interrupts_off;
    uint32_t section = chip->cpu.section;
    uint32_t dbgm = chip->cpu.dbgm;
    uint32_t resets = chip->cpu.resets;
    bool enabled = (chip->registers.pie.PIECTRL & PIECTRL_ENPIE) != 0u;
    uint32_t token = chip->registers.pie_vectors.vector[vector];
    chip->cpu.ifr &= ~(1u << (n - 1u));
    chip->cpu.ier &= ~(1u << (n - 1u));
    chip->cpu.interrupts_off = 1u;
    chip->cpu.section = 0u;
    chip->cpu.dbgm = 1u;
    chip->cpu.allow = 0u;
    if (flash_api_runs(chip)) { /* there is no function for an interrupt */
        chip_report(chip, CHIP_FLASH_MISUSE, vector);
    }
    if (!enabled || token == 0u) { /* without ENPIE the CPU would use the vectors of the boot ROM, which has
                                      no functions here */
        chip_report(chip, CHIP_NO_VECTOR, vector);
        chip->cpu.halted = 1u;
        return;
    }
    chip->registers.pie.PIECTRL = (uint16_t)((VECTOR_AT + 2u * vector) | PIECTRL_ENPIE);
    chip->entries[vector]++;
    if (vector == PIE_SEQ1INT) {
        chip->sample_tick = chip->tick;
    }
    chip_refresh(chip);
    chip_tell(chip, CHIP_EVENT_INTERRUPT, vector);
    if (chip_world->interrupt != NULL) {
        chip_world->interrupt(chip_world->context, vector, function_of(token));
    } else {
        function_of(token)();
    }
    chip_tell(chip, CHIP_EVENT_RETURN, vector);
    if (chip->cpu.halted || chip->cpu.resets != resets) {
        return;
    }
    chip->cpu.ier = ier;
    chip->cpu.interrupts_off = masked;
    chip->cpu.section = section;
    chip->cpu.dbgm = dbgm;
    chip->cpu.allow = allow;
    cpu_update(chip);
}

void pie_write(chip_t *chip, uint32_t address, uint16_t value)
{
    pie_regs_t *pie = &chip->registers.pie;
    uint32_t offset = address - PIE_AT;
    if (offset == OFFSET(pie_regs_t, PIECTRL)) {
        pie->PIECTRL = (uint16_t)((pie->PIECTRL & 0xFFFEu) | (value & PIECTRL_ENPIE));
    } else if (offset == OFFSET(pie_regs_t, PIEACK)) {
        pie->PIEACK &= (uint16_t)~value;
    } else {
        uint32_t group = (offset - OFFSET(pie_regs_t, group)) / 2u + 1u;
        if ((offset & 1u) == 0u) {
            pie->group[group - 1u].IER = value & 0x00FFu;
        } else {
            pie->group[group - 1u].IFR = value & 0x00FFu;
        }
        group_changed(chip, group);
    }
    cpu_update(chip);
}
