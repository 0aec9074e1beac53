/* Sectors C and B of the flash, SPRS439, as two pages. Erasing and programming cannot be interrupted: the
 * flash, which contains constants of the interrupts, cannot be read meanwhile. Therefore the gates must be
 * tripped, and the watchdog is stopped. */
#include "hal/f28335/bus.h"
#include "hal/f28335/flash.h"
#include "hal/f28335/pwm.h"
#include "hal/f28335/watchdog.h"
#include "hal/hal.h"

#define SECTOR_C_AT UINT32_C(0x328000)
#define SECTOR_C    4u /* bit of the sector in the mask of an erase; that of B is the next lower one */
#define ERASED      0xFFFFu

static uint32_t address_of(uint32_t page, uint32_t at)
{
    return SECTOR_C_AT + page * HAL_STORE_WORDS + at;
}

uint16_t hal_store_word(uint32_t page, uint32_t at)
{
    return page < HAL_STORE_PAGES && at < HAL_STORE_WORDS ? bus_flash(address_of(page, at)) : 0u;
}

/* Switches interrupts and watchdog off, and copies the API over the interrupt's code. True: the API is ready.
 * *watched: the watchdog ran before. */
static bool store_begin(bool *watched)
{
    *watched = watchdog_runs();
    bus_interrupts_disable();
    watchdog_stop();
    return flash_begin();
}

static void store_end(bool watched)
{
    flash_end();
    if (watched) {
        hal_watchdog_start();
    }
    bus_interrupts_enable();
}

static bool page_is_erased(uint32_t page)
{
    uint32_t at;

    for (at = 0u; at < HAL_STORE_WORDS; at++) {
        if (bus_flash(address_of(page, at)) != ERASED) {
            return false;
        }
    }
    return true;
}

bool hal_store_erase(uint32_t page)
{
    bool watched;
    bool erased;

    if (page >= HAL_STORE_PAGES || !pwm_all_tripped()) {
        return false;
    }
    erased = store_begin(&watched) && flash_erase((uint16_t)(SECTOR_C >> page));
    store_end(watched);
    return erased && page_is_erased(page);
}

bool hal_store_program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count)
{
    bool watched;
    bool good;
    uint32_t n;

    if (page >= HAL_STORE_PAGES || at > HAL_STORE_WORDS || count > HAL_STORE_WORDS - at ||
        !pwm_all_tripped()) {
        return false;
    }
    good = store_begin(&watched);
    for (n = 0u; n < count && good; n++) {
        const uint32_t address = address_of(page, at + n);
        good = flash_program(address, words[n]) && bus_flash(address) == words[n];
    }
    store_end(watched);
    return good;
}
