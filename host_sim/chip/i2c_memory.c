/* A memory on the I2C bus with addresses of two octets: an EEPROM as the 24xx256, with pages and a time for
 * writing, or an FRAM, with neither. Data sheets: Microchip DS20001203 (24LC256), Infineon 001-86149
 * (FM24W256).
 *
 * The octets of a write go into a buffer of one page; after the last octet of the page the first one follows.
 * STOP begins the writing, and the memory acknowledges nothing until it has ended. A START instead of the
 * STOP discards the buffer. An FRAM writes each octet at once. An octet that arrives is an operation, and so
 * is one that is written: chip_cut_power counts both. After a power failure between writes, the written
 * octets remain. During the writing of a page some octets are new, one has only some of its bits, and the
 * others are old; the number of the operation decides from which end of the page the new ones count. */
#include <assert.h>
#include <string.h>

#include "host_sim/chip/i2c_parts.h"

#define SIZE     0x8000u /* [octets] 256 Kbit */
#define DATA_PIN 32u

enum { IDLE, PLACE_HIGH, PLACE_LOW, WRITING, READING };

void chip_attach_memory(chip_t *chip, const chip_memory_t *memory)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    assert(memory == NULL || memory->page_octets <= CHIP_I2C_PAGE);
    m->attached = memory != NULL;
    if (memory != NULL) {
        m->address = memory->address;
        m->page = memory->page_octets;
        m->write_ticks = memory->write_ticks;
    }
    m->state = IDLE;
}

void i2c_memory_power_on(chip_t *chip)
{
    memset(chip->i2c.memory.octet, 0xFF, sizeof chip->i2c.memory.octet);
}

void i2c_memory_power_cycle(chip_t *chip)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    m->state = IDLE;
    m->buffered = 0u;
    m->busy_until = 0u;
    m->held = m->held == CHIP_FOREVER ? CHIP_FOREVER : 0u;
}

const uint8_t *chip_memory_octets(const chip_t *chip)
{
    return chip->i2c.memory.octet;
}

void chip_memory_fill(chip_t *chip, const uint8_t octets[CHIP_I2C_KEPT])
{
    memcpy(chip->i2c.memory.octet, octets, CHIP_I2C_KEPT);
}

void chip_hold_data(chip_t *chip, uint32_t clocks)
{
    chip->i2c.memory.held = clocks;
    gpio_refresh(chip);
}

void chip_break_memory(chip_t *chip, bool broken)
{
    chip->i2c.memory.broken = broken ? 1u : 0u;
}

uint32_t i2c_memory_pulls(const chip_t *chip)
{
    return chip->i2c.memory.held != 0u ? GPIO_PIN(DATA_PIN) : 0u;
}

void i2c_memory_clock(chip_t *chip)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    m->held -= m->held != 0u && m->held != CHIP_FOREVER ? 1u : 0u;
}

/* ---- Content ---- */

/* An octet of the array changes. */
static void write_octet(chip_t *chip, uint32_t at, uint32_t octet)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    if (at >= CHIP_I2C_KEPT) {
        chip_report(chip, CHIP_FLASH_BEYOND, at);
        return;
    }
    uint32_t done = 0xFFu;
    const bool counted = chip_storage_operation(chip, &done);
    if (counted && m->broken == 0u) {
        m->octet[at] = (uint8_t)((m->octet[at] & ~done) | (octet & done));
    }
}

/* Writes the received octets of the page, and sets `busy_until` to the end of the writing. */
static void write_page(chip_t *chip)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    const bool backwards = (chip->flash.cut_after & 1u) != 0u;
    const uint32_t begin = m->place / m->page * m->page;
    for (uint32_t n = 0u; n < m->page; n++) {
        const uint32_t at = backwards ? m->page - 1u - n : n;
        if ((m->sent[at / 32u] >> (at % 32u) & 1u) != 0u) {
            write_octet(chip, begin + at, m->buffer[at]);
        }
    }
    m->busy_until = chip->i2c.due + m->write_ticks;
}

/* ---- Bus ---- */

bool i2c_memory_select(chip_t *chip, uint32_t address, bool read)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    m->buffered = 0u;
    memset(m->sent, 0, sizeof m->sent);
    const bool here = m->attached != 0u && address == m->address && chip->i2c.due >= m->busy_until;
    m->state = !here ? IDLE : read ? READING : PLACE_HIGH;
    return here;
}

static void take_data(chip_t *chip, uint32_t octet)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    if (m->page == 0u) {
        write_octet(chip, m->place, octet);
        m->place = (m->place + 1u) % SIZE;
        return;
    }
    const uint32_t at = m->place % m->page;
    m->buffer[at] = (uint8_t)octet;
    m->sent[at / 32u] |= 1u << (at % 32u);
    m->buffered = 1u;
    m->place = m->place - at + (at + 1u) % m->page;
}

bool i2c_memory_put(chip_t *chip, uint32_t octet)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    uint32_t done;
    if (!chip_storage_operation(chip, &done) || chip->cpu.halted) {
        return false;
    }
    switch (m->state) {
    case PLACE_HIGH:
        m->place = octet << 8 & (SIZE - 1u);
        m->state = PLACE_LOW;
        return true;
    case PLACE_LOW:
        m->place |= octet;
        m->state = WRITING;
        return true;
    case WRITING:
        take_data(chip, octet);
        return true;
    default:
        return false;
    }
}

uint32_t i2c_memory_get(chip_t *chip)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    if (m->state != READING) {
        return 0xFFu; /* no device pulls the line */
    }
    const uint32_t octet = m->place < CHIP_I2C_KEPT ? m->octet[m->place] : 0xFFu;
    m->place = (m->place + 1u) % SIZE;
    return octet;
}

void i2c_memory_stop(chip_t *chip)
{
    chip_i2c_memory_t *m = &chip->i2c.memory;
    if (m->state == WRITING && m->buffered != 0u) {
        write_page(chip);
    }
    m->state = IDLE;
}
