#include "app/keeping.h"

#include "app/app.h"

#if BOARD_STORE == BOARD_STORE_I2C

typedef char keeping_fits[KEEPING_WORDS <= KEEPING_STRIDE && MIRROR_GROUP == HAL_EEPROM_WORDS ? 1 : -1];

#define CYCLES_PER_US (HAL_CLOCK_HZ / UINT32_C(1000000))

static mirror_reply_t poll(uint16_t words[MIRROR_GROUP])
{
    switch (hal_eeprom_poll(words)) {
    case HAL_EEPROM_BUSY:
        return MIRROR_BUSY;
    case HAL_EEPROM_DONE:
        return MIRROR_DONE;
    case HAL_EEPROM_REFUSED:
        return MIRROR_REFUSED;
    case HAL_EEPROM_LOST:
        break;
    }
    return MIRROR_LOST;
}

/* A transfer takes 0.3 ms. Writing may take three times the time of the data sheet. 10 ms are added, because
 * the background may be late. */
static const mirror_bus_t bus = {
    .write = hal_eeprom_write,
    .read = hal_eeprom_read,
    .poll = poll,
    .give_up = hal_eeprom_abort,
    .time = hal_time,
    .refusals_last = (UINT32_C(3) * BOARD_STORE_WRITE_US + UINT32_C(10000)) * CYCLES_PER_US,
    .transfer_last = UINT32_C(5000) * CYCLES_PER_US,
    .words = KEEPING_WORDS,
    .stride = KEEPING_STRIDE,
};

static uint16_t word(uint32_t page, uint32_t at)
{
    return app->keeping.pages[page * KEEPING_WORDS + at];
}

static bool erase(uint32_t page)
{
    return mirror_erase(&app->keeping.mirror, &bus, app->keeping.pages, page);
}

static bool program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count)
{
    return mirror_program(&app->keeping.mirror, &bus, app->keeping.pages, page, at, words, count);
}

const store_flash_t keeping_memory = {word, erase, program, KEEPING_WORDS};

void keeping_open(void)
{
    mirror_t *mirror = &app->keeping.mirror;
    mirror_begin(mirror);
    if (!hal_eeprom_open()) {
        mirror->error = (uint32_t)MIRROR_BUS_STUCK;
    }
    while (mirror_step(mirror, &bus, app->keeping.pages)) {
        hal_eeprom_wait();
    }
}

uint32_t keeping_error(void)
{
    return app->keeping.mirror.error;
}

bool keeping_busy(void)
{
    return mirror_busy(&app->keeping.mirror);
}

void keeping_step(void)
{
    (void)mirror_step(&app->keeping.mirror, &bus, app->keeping.pages);
}

#else

/* Length used in each sector: several sets per erase, and a search at the
 * start that takes some ms at most. */
#define PAGE_WORDS UINT32_C(2048)

const store_flash_t keeping_memory = {hal_store_word, hal_store_erase, hal_store_program, PAGE_WORDS};

void keeping_open(void)
{
}

uint32_t keeping_error(void)
{
    return (uint32_t)MIRROR_GOOD;
}

bool keeping_busy(void)
{
    return false;
}

#endif
