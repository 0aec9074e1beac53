/* Flash sectors C and B, which the drive erases and programs itself: SPRS439, SPRUFB0 ch. 1. What takes the
 * place of TI's flash API stands here, behind hal/f28335/bus.h.
 *
 * An erase first clears all words and then sets them, a word at a time, so a cut of the power leaves some
 * words cleared, some erased, the one at work neither, and the others as they were. Of a word that was being
 * programmed it leaves some bits done. Only the first words of a page are kept one by one (chip_flash_t);
 * what is behind goes in one piece and cannot be programmed.
 *
 * The operations take their time all the same: interrupts wait until it is over, the background with them,
 * and a watchdog that is started meanwhile begins to count then. */
#include <assert.h>

#include "host_sim/chip/parts.h"

#define SECTOR_C_AT   0x328000u
#define SECTOR_C      (1u << 2)
#define SECTOR_B      (1u << 1)
#define ERASED        0xFFFFu
#define CLEARED       0u
#define ERASE_TICKS   (2u * CHIP_TICKS_PER_SECOND)             /* typical: 2 s */
#define PROGRAM_TICKS (50u * CHIP_TICKS_PER_SECOND / 1000000u) /* 50 us */

void flash_power_on(chip_t *chip)
{
    chip_flash_t *flash = &chip->flash;
    for (uint32_t page = 0u; page < CHIP_FLASH_PAGES; page++) {
        for (uint32_t at = 0u; at < sizeof flash->word[0] / sizeof flash->word[0][0]; at++) {
            flash->word[page][at] = ERASED;
        }
    }
}

void flash_reset(chip_t *chip)
{
    chip->flash.busy_until = 0u;
}

static uint32_t kept_at(uint32_t at)
{
    return at < CHIP_FLASH_KEPT ? at : CHIP_FLASH_KEPT;
}

uint16_t chip_flash_word(const chip_t *chip, uint32_t page, uint32_t at)
{
    assert(page < CHIP_FLASH_PAGES && at < CHIP_FLASH_WORDS);
    return chip->flash.word[page][kept_at(at)];
}

bool chip_flash_fill(chip_t *chip, uint32_t page, const uint16_t words[CHIP_FLASH_WORDS])
{
    assert(page < CHIP_FLASH_PAGES);
    for (uint32_t at = CHIP_FLASH_KEPT; at < CHIP_FLASH_WORDS; at++) {
        if (words[at] != words[CHIP_FLASH_KEPT]) {
            return false;
        }
    }
    for (uint32_t at = 0u; at <= CHIP_FLASH_KEPT; at++) {
        chip->flash.word[page][at] = words[at];
    }
    return true;
}

void chip_cut_power(chip_t *chip, uint32_t operations)
{
    chip->flash.cut = 1u;
    chip->flash.cut_after = chip->flash.operations + operations;
}

uint32_t chip_flash_operations(const chip_t *chip)
{
    return chip->flash.operations;
}

/* Every other bit or so, other ones each time. */
static uint32_t some_bits(uint32_t operation)
{
    return (operation + 1u) * 0x9E3779B1u >> 16;
}

bool chip_storage_operation(chip_t *chip, uint32_t *done)
{
    chip_flash_t *flash = &chip->flash;
    *done = UINT32_MAX;
    if (chip->cpu.halted) {
        return false; /* no software */
    }
    if (flash->cut && flash->operations == flash->cut_after) {
        *done = some_bits(flash->operations);
        chip->cpu.halted = 1u;
        return true;
    }
    flash->operations++;
    return true;
}

/* One operation on one word, or what of it there was time for. */
static void work_on(chip_t *chip, uint16_t *word, uint32_t value)
{
    uint32_t done;
    if (chip_storage_operation(chip, &done)) {
        *word = (uint16_t)((*word & ~done) | (value & done));
    }
}

static bool ready(chip_t *chip, uint32_t address)
{
    if (!chip->cpu.interrupts_off || !chip->watchdog.off) {
        chip_report(chip, CHIP_FLASH_MISUSE, address);
        return false;
    }
    return !chip->cpu.halted;
}

static void take_time(chip_t *chip, uint64_t ticks)
{
    uint64_t *until = &chip->flash.busy_until;
    *until = (*until > chip->tick ? *until : chip->tick) + ticks;
    chip->cpu.busy_until = *until > chip->cpu.busy_until ? *until : chip->cpu.busy_until;
}

uint16_t bus_flash(uint32_t address)
{
    assert(address - SECTOR_C_AT < CHIP_FLASH_PAGES * CHIP_FLASH_WORDS);
    const uint32_t place = address - SECTOR_C_AT;
    return chip_flash_word(chip_bound, place / CHIP_FLASH_WORDS, place % CHIP_FLASH_WORDS);
}

bool bus_flash_erase(uint16_t sectors)
{
    chip_t *chip = chip_bound;
    const uint32_t page = sectors == SECTOR_C ? 0u : 1u;
    assert(sectors == SECTOR_C || sectors == SECTOR_B);
    if (!ready(chip, SECTOR_C_AT + page * CHIP_FLASH_WORDS)) {
        return false;
    }
    for (uint32_t pass = 0u; pass < 2u; pass++) {
        for (uint32_t at = 0u; at <= CHIP_FLASH_KEPT; at++) {
            work_on(chip, &chip->flash.word[page][at], pass == 0u ? CLEARED : ERASED);
        }
    }
    take_time(chip, ERASE_TICKS);
    return !chip->cpu.halted;
}

bool bus_flash_program(uint32_t address, uint16_t word)
{
    chip_t *chip = chip_bound;
    const uint32_t place = address - SECTOR_C_AT;
    const uint32_t page = place / CHIP_FLASH_WORDS;
    const uint32_t at = place % CHIP_FLASH_WORDS;
    assert(page < CHIP_FLASH_PAGES);
    if (!ready(chip, address)) {
        return false;
    }
    if (at >= CHIP_FLASH_KEPT) {
        chip_report(chip, CHIP_FLASH_BEYOND, address);
        return false;
    }
    if ((word & ~chip->flash.word[page][at]) != 0u) {
        return false; /* only an erase makes ones */
    }
    work_on(chip, &chip->flash.word[page][at], word);
    take_time(chip, PROGRAM_TICKS);
    return !chip->cpu.halted;
}
