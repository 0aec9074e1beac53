/* No function of this file, and no function that they call, may run from L0-L3. The linker file names the
 * functions that run there, and tools/check-linker proves that these are not among them. A division of floats
 * is not allowed for the same reason: its library function runs from L0-L3. */
#include "hal/f28335/flash.h"

#include "hal/f28335/bus.h"
#include "hal/f28335/flash_api.h"
#include "hal/hal.h"

/* The scale factor of the API: 2^20 times 200 ns over the duration of a SYSCLK cycle. */
#define SCALE ((uint32_t)BOARD_SYSCLK_HZ / 625u * 16384u / 125u)

/* Sets a variable of the API, whose address is in the table. */
static void put_variable(uint32_t entry, uint32_t value)
{
    uint16_t *const ram = bus_code_ram();
    const uint32_t address = ram[entry] | (uint32_t)ram[entry + 1u] << 16;
    const uint32_t at = address - BUS_CODE_AT;

    ram[at] = (uint16_t)(value & 0xFFFFu);
    ram[at + 1u] = (uint16_t)(value >> 16);
}

bool flash_begin(void)
{
    const bus_memory_t api = bus_flash_api();
    uint16_t *const ram = bus_code_ram();
    uint32_t n;

    if (api.count < FLASH_API_HEAD) {
        return false;
    }
    for (n = 0u; n < api.count; n++) {
        ram[n] = api.words[n];
    }
    put_variable(FLASH_API_SCALE, SCALE);
    put_variable(FLASH_API_CALLBACK, 0u);
    return bus_function(flash_api_version_t, BUS_CODE_AT + FLASH_API_VERSION)() == FLASH_API_2_10;
}

bool flash_erase(uint16_t sectors)
{
    flash_api_status_t status;

    return bus_function(flash_api_erase_t, BUS_CODE_AT + FLASH_API_ERASE)(sectors, &status) == FLASH_API_GOOD;
}

bool flash_program(uint32_t address, uint16_t word)
{
    flash_api_status_t status;
    uint16_t *const at = bus_flash_at(address);

    return bus_function(flash_api_words_t, BUS_CODE_AT + FLASH_API_PROGRAM)(at, &word, 1u, &status) ==
               FLASH_API_GOOD &&
           bus_function(flash_api_words_t, BUS_CODE_AT + FLASH_API_VERIFY)(at, &word, 1u, &status) ==
               FLASH_API_GOOD;
}

void flash_end(void)
{
    bus_copy_code();
}
