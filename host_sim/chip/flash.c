/* Flash sectors C and B, which the drive erases and programs itself: SPRS439, SPRUFB0 ch. 1. This file
 * contains a library with the interface of TI's flash API (hal/f28335/flash_api.h). Its words are no code of
 * this machine, but a call into L0-L3 leads to its functions. They have an effect only if the words are in
 * their place, the variables are set, and interrupts and watchdog are off.
 *
 * An erase first clears all words and then sets them, one word at a time. If the power fails, some words are
 * cleared, some are erased, the present one is neither, and the others are unchanged. If a word was being
 * programmed, only some of its bits are programmed afterwards. Only the first words of a page are stored one
 * by one (chip_flash_t); the words behind them are erased as a whole and cannot be programmed.
 *
 * Nevertheless the operations take their time: interrupts and background wait until the operation ends, and
 * a watchdog that is started during the operation begins to count at its end. */
#include <assert.h>

#include "hal/f28335/flash_api.h"
#include "host_sim/chip/parts.h"

#define SECTOR_C_AT   0x328000u
#define SECTOR_C      (1u << 2)
#define SECTOR_B      (1u << 1)
#define ERASED        0xFFFFu
#define CLEARED       0u
#define ERASE_TICKS   (2u * CHIP_TICKS_PER_SECOND)             /* typical: 2 s */
#define PROGRAM_TICKS (50u * CHIP_TICKS_PER_SECOND / 1000000u) /* 50 us */

#define FAILED      10u /* any status other than 0 */
#define SCALE_HZ    5000000u
#define SCALE_IS    1048576u /* the scale factor of a clock with SCALE_HZ */
#define SCALE_AT    40u      /* [words] the library's variables, from its head on */
#define CALLBACK_AT 42u
#define API_WORDS   48u
#define LB(at)      (uint16_t)(0x0040u | (BUS_CODE_AT + (at)) >> 16), (uint16_t)((BUS_CODE_AT + (at)) & 0xFFFFu)
#define ADDRESS(at) (uint16_t)((BUS_CODE_AT + (at)) & 0xFFFFu), (uint16_t)((BUS_CODE_AT + (at)) >> 16)

/* The table, and words after it that have to be copied as well. */
static const uint16_t api[API_WORDS] = {LB(12u), LB(18u),           LB(24u),
                                        LB(30u), ADDRESS(SCALE_AT), ADDRESS(CALLBACK_AT),
                                        0xA5A5u, 0x5A5Au,           [47] = 0x1234u};

bus_memory_t bus_flash_api(void)
{
    return (bus_memory_t){api, API_WORDS};
}

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

/* Selects about half of the bits, different ones at each call. */
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

/* One operation on one word, or the part of it before the power failed. */
static void work_on(chip_t *chip, uint16_t *word, uint32_t value)
{
    uint32_t done;
    if (chip_storage_operation(chip, &done)) {
        *word = (uint16_t)((*word & ~done) | (value & done));
    }
}

static uint32_t variable(const uint16_t *ram, uint32_t at)
{
    return ram[at] | (uint32_t)ram[at + 1u] << 16;
}

bool flash_api_runs(const chip_t *chip)
{
    return chip->memory[BUS_INTERRUPT_CODE][0] == api[0];
}

/* Every word of the library is in the place where it runs, and its variables suit the clock. */
static bool is_set_up(const chip_t *chip)
{
    const uint16_t *ram = chip->memory[BUS_INTERRUPT_CODE];
    for (uint32_t n = 0u; n < API_WORDS; n++) {
        if (ram[n] != api[n] && (n < SCALE_AT || n >= CALLBACK_AT + 2u)) {
            return false;
        }
    }
    const uint64_t scale = (uint64_t)chip_sysclk_hz(chip) * SCALE_IS / SCALE_HZ;
    return variable(ram, SCALE_AT) == scale && variable(ram, CALLBACK_AT) == 0u;
}

static bool ready(chip_t *chip, uint32_t address)
{
    if (!chip->cpu.interrupts_off || !chip->watchdog.off || !is_set_up(chip)) {
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

static uint16_t api_erase(uint16_t sectors, flash_api_status_t *status)
{
    chip_t *chip = chip_bound;
    const uint32_t page = sectors == SECTOR_C ? 0u : 1u;
    (void)status;
    assert(sectors == SECTOR_C || sectors == SECTOR_B);
    if (!ready(chip, SECTOR_C_AT + page * CHIP_FLASH_WORDS)) {
        return FAILED;
    }
    for (uint32_t pass = 0u; pass < 2u; pass++) {
        for (uint32_t at = 0u; at <= CHIP_FLASH_KEPT; at++) {
            work_on(chip, &chip->flash.word[page][at], pass == 0u ? CLEARED : ERASED);
        }
    }
    take_time(chip, ERASE_TICKS);
    return chip->cpu.halted ? FAILED : FLASH_API_GOOD;
}

/* The kept word at this address; NULL: none. */
static uint16_t *kept_word(chip_t *chip, uint32_t address)
{
    const uint32_t place = address - SECTOR_C_AT;
    const uint32_t page = place / CHIP_FLASH_WORDS;
    const uint32_t at = place % CHIP_FLASH_WORDS;
    assert(page < CHIP_FLASH_PAGES);
    if (at >= CHIP_FLASH_KEPT) {
        chip_report(chip, CHIP_FLASH_BEYOND, address);
        return NULL;
    }
    return &chip->flash.word[page][at];
}

static uint16_t api_program(uint16_t *to, uint16_t *words, uint32_t count, flash_api_status_t *status)
{
    chip_t *chip = chip_bound;
    (void)status;
    for (uint32_t n = 0u; n < count; n++) {
        const uint32_t address = (uint32_t)(uintptr_t)to + n;
        uint16_t *word = ready(chip, address) ? kept_word(chip, address) : NULL;
        if (word == NULL || (words[n] & ~*word) != 0u) { /* only an erase changes bits to one */
            return FAILED;
        }
        work_on(chip, word, words[n]);
        take_time(chip, PROGRAM_TICKS);
    }
    return chip->cpu.halted ? FAILED : FLASH_API_GOOD;
}

static uint16_t api_verify(uint16_t *at, uint16_t *words, uint32_t count, flash_api_status_t *status)
{
    chip_t *chip = chip_bound;
    (void)status;
    for (uint32_t n = 0u; n < count; n++) {
        const uint32_t address = (uint32_t)(uintptr_t)at + n;
        const uint16_t *word = ready(chip, address) ? kept_word(chip, address) : NULL;
        if (word == NULL || *word != words[n]) {
            return FAILED;
        }
    }
    return FLASH_API_GOOD;
}

static uint16_t api_version(void)
{
    return is_set_up(chip_bound) ? FLASH_API_2_10 : 0u;
}

bus_function_t bus_function_at(uint32_t address)
{
    switch (address - BUS_CODE_AT) {
    case FLASH_API_ERASE:
        return (bus_function_t)api_erase;
    case FLASH_API_PROGRAM:
        return (bus_function_t)api_program;
    case FLASH_API_VERIFY:
        return (bus_function_t)api_verify;
    default:
        assert(address - BUS_CODE_AT == FLASH_API_VERSION);
        return (bus_function_t)api_version;
    }
}
