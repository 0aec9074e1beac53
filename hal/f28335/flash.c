/* Erasing and programming of flash on silicon, by TI's F2833x Flash API, version 2.10; on the host the
 * virtual chip brings its own, and this file is not compiled.
 *
 * TI has published the library in the object format COFF alone, which does not link with this program's EABI.
 * HAL_FLASH_API says that a library in EABI with these prototypes is linked, its .text and .const among what
 * runs from RAM; none is published. Without it everything is refused, and the flash stays as it is.
 */
#include "hal/f28335/bus.h"
#include "hal/hal.h"

#if defined(HAL_FLASH_API)

/* As TI's Flash2833x_API_Library.h declares them. */
typedef struct {
    uint32_t FirstFailAddr;
    uint16_t ExpectedData;
    uint16_t ActualData;
} FLASH_ST;

extern uint32_t Flash_CPUScaleFactor;
extern void (*Flash_CallbackPtr)(void);
extern uint16_t Flash28335_Erase(uint16_t SectorMask, FLASH_ST *FEraseStat);
extern uint16_t Flash28335_Program(uint16_t *FlashAddr, uint16_t *BufAddr, uint32_t Length,
                                   FLASH_ST *FProgStatus);

/* The scale: 1048576 x 200 ns over the cycle. */
static void set_up(void)
{
    Flash_CPUScaleFactor = (uint32_t)((float)BOARD_SYSCLK_HZ / 5.0e6f * 1048576.0f);
    Flash_CallbackPtr = 0;
}

bool bus_flash_erase(uint16_t sectors)
{
    FLASH_ST status;

    set_up();
    return Flash28335_Erase(sectors, &status) == 0u;
}

bool bus_flash_program(uint32_t address, uint16_t word)
{
    FLASH_ST status;

    set_up();
    return Flash28335_Program((uint16_t *)address, &word, 1u, &status) == 0u;
}

#else

bool bus_flash_erase(uint16_t sectors)
{
    (void)sectors;
    return false;
}

bool bus_flash_program(uint32_t address, uint16_t word)
{
    (void)address;
    (void)word;
    return false;
}

#endif
