/* All octets of a transfer fit into the module's FIFO, so they are written before the transfer begins. The
 * state of the transfer is read from the module's registers, because this module must not use variables (on
 * the host several chips share one process). No interrupt is used. */
#include "hal/f28335/eeprom.h"

#include "hal/f28335/bus.h"

#if BOARD_STORE == BOARD_STORE_I2C

/* The module clock is at most 10 MHz. A bit takes 25 of its cycles: SCL is low for 15 and high for 10. At 10
 * MHz this is 400 kHz, with 1.5 us and 1.0 us. */
#define PRESCALE ((BOARD_SYSCLK_HZ + 9999999) / 10000000)
#define SCL_LOW  10u
#define SCL_HIGH 5u

#define MODE_IDLE   (I2CMDR_FREE | I2CMDR_IRS)
#define MODE_MASTER (MODE_IDLE | I2CMDR_MST)
#define MODE_WRITE  (MODE_MASTER | I2CMDR_TRX | I2CMDR_STT | I2CMDR_STP)
#define MODE_PLACE  (MODE_MASTER | I2CMDR_TRX | I2CMDR_STT)
#define MODE_READ   (MODE_MASTER | I2CMDR_STT | I2CMDR_STP)
#define MODE_STOP   (MODE_MASTER | I2CMDR_TRX | I2CMDR_STP)

#define FLAGS       (I2CSTR_AL | I2CSTR_NACK | I2CSTR_ARDY | I2CSTR_SCD)
#define FFTX_EMPTY  I2CFFTX_I2CFFEN
#define FFTX_READY  (I2CFFTX_I2CFFEN | I2CFFTX_TXFFRST)
#define PLACE_OCTET 2u /* of the address in the memory */

#define HALF_BIT_CYCLES ((uint32_t)(BOARD_SYSCLK_HZ / 200000)) /* 5 us */
#define CLOCKS          9u                                     /* of an octet and its acknowledge bit */

static void empty_fifos(void)
{
    bus_write16(&I2CA->I2CFFTX, FFTX_EMPTY);
    bus_write16(&I2CA->I2CFFRX, 0u);
    bus_write16(&I2CA->I2CFFTX, FFTX_READY);
    bus_write16(&I2CA->I2CFFRX, I2CFFRX_RXFFRST);
}

void eeprom_init(void)
{
    bus_write16(&I2CA->I2CMDR, 0u);
    bus_write16(&I2CA->I2CPSC, (uint16_t)(PRESCALE - 1));
    bus_write16(&I2CA->I2CCLKL, SCL_LOW);
    bus_write16(&I2CA->I2CCLKH, SCL_HIGH);
    bus_write16(&I2CA->I2CIER, 0u);
    empty_fifos();
    bus_write16(&I2CA->I2CMDR, MODE_IDLE);
}

/* ---- The lines as plain pins ---- */

#define LINES     GPIO_CONTROL(EEPROM_PIN_DATA / 32u)
#define LEVELS    GPIO_DATA(EEPROM_PIN_DATA / 32u)
#define BOTH_PINS (GPIO_PIN(EEPROM_PIN_DATA) | GPIO_PIN(EEPROM_PIN_CLOCK))
#define FIELDS(f) (GPIO_FIELD(EEPROM_PIN_DATA, f) | GPIO_FIELD(EEPROM_PIN_CLOCK, f))

/* Pulls the line low by an output at 0, or releases it to its pull-up by making the pin an input. */
static void pull(uint16_t pin, bool low)
{
    bus_allow();
    bus_write32(&LINES->DIR, low ? LINES->DIR | GPIO_PIN(pin) : LINES->DIR & ~GPIO_PIN(pin));
    bus_protect();
    bus_wait(HALF_BIT_CYCLES);
}

static bool is_high(uint16_t pin)
{
    return (LEVELS->DAT & GPIO_PIN(pin)) != 0u;
}

bool eeprom_free_bus(void)
{
    uint16_t n;
    bool idle;

    bus_allow();
    bus_write32(&LINES->PUD, LINES->PUD & ~BOTH_PINS);
    bus_write32(&LINES->DIR, LINES->DIR & ~BOTH_PINS);
    bus_write32(&LINES->MUX1, LINES->MUX1 & ~FIELDS(3u));
    bus_write32(&LINES->QSEL1, LINES->QSEL1 | FIELDS(GPIO_QSEL_ASYNC));
    bus_protect();
    bus_write32(&LEVELS->CLEAR, BOTH_PINS);
    bus_wait(HALF_BIT_CYCLES);
    for (n = 0u; n < CLOCKS && !is_high(EEPROM_PIN_DATA); n++) {
        pull(EEPROM_PIN_CLOCK, true);
        pull(EEPROM_PIN_CLOCK, false);
    }
    /* a STOP condition: data rises while the clock is high */
    pull(EEPROM_PIN_CLOCK, true);
    pull(EEPROM_PIN_DATA, true);
    pull(EEPROM_PIN_CLOCK, false);
    pull(EEPROM_PIN_DATA, false);
    idle = is_high(EEPROM_PIN_DATA) && is_high(EEPROM_PIN_CLOCK);
    bus_allow();
    bus_write32(&LINES->MUX1, LINES->MUX1 | FIELDS(EEPROM_PIN_MUX));
    bus_protect();
    return idle;
}

/* ---- Transfers ---- */

static void put_octet(uint16_t word)
{
    bus_write16(&I2CA->I2CDXR, word & 0x00FFu);
}

/* Clears flags and FIFOs of the last transfer. The address in the memory is the first to be sent. */
static void prepare(uint32_t at, uint32_t octets)
{
    const uint16_t place = (uint16_t)(2u * at);

    empty_fifos();
    bus_write16(&I2CA->I2CSTR, FLAGS);
    bus_write16(&I2CA->I2CSAR, (uint16_t)BOARD_STORE_ADDRESS);
    bus_write16(&I2CA->I2CCNT, (uint16_t)octets);
    put_octet((uint16_t)(place >> 8));
    put_octet(place);
}

void hal_eeprom_write(uint32_t at, const uint16_t *words, uint32_t count)
{
    uint32_t n;

    prepare(at, PLACE_OCTET + 2u * count);
    for (n = 0u; n < count; n++) {
        put_octet(words[n]);
        put_octet((uint16_t)(words[n] >> 8));
    }
    bus_write16(&I2CA->I2CMDR, MODE_WRITE);
}

void hal_eeprom_read(uint32_t at)
{
    prepare(at, PLACE_OCTET);
    bus_write16(&I2CA->I2CMDR, MODE_PLACE);
}

static uint16_t take_octet(void)
{
    return bus_read16(&I2CA->I2CDRR) & 0x00FFu;
}

/* The result of a transfer that has ended. */
static hal_eeprom_t finish(uint16_t words[HAL_EEPROM_WORDS])
{
    uint16_t n;

    if ((I2CA->I2CMDR & I2CMDR_TRX) != 0u) {
        return HAL_EEPROM_DONE;
    }
    if (I2CFF_ST(bus_read16(&I2CA->I2CFFRX)) != 2u * HAL_EEPROM_WORDS) {
        return HAL_EEPROM_LOST;
    }
    for (n = 0u; n < HAL_EEPROM_WORDS; n++) {
        const uint16_t lower = take_octet();
        words[n] = (uint16_t)(lower | take_octet() << 8);
    }
    return HAL_EEPROM_DONE;
}

hal_eeprom_t hal_eeprom_poll(uint16_t words[HAL_EEPROM_WORDS])
{
    const uint16_t flags = bus_read16(&I2CA->I2CSTR);

    if ((flags & I2CSTR_AL) != 0u) {
        return HAL_EEPROM_LOST;
    }
    if ((flags & I2CSTR_NACK) != 0u) {
        if ((flags & I2CSTR_SCD) != 0u) {
            return HAL_EEPROM_REFUSED;
        }
        bus_write16(&I2CA->I2CMDR, MODE_STOP); /* frees the bus */
        return HAL_EEPROM_BUSY;
    }
    if ((flags & I2CSTR_SCD) != 0u) {
        return finish(words);
    }
    if ((flags & I2CSTR_ARDY) !=
        0u) { /* the address has been sent; now the words are read, after a repeated START */
        bus_write16(&I2CA->I2CSTR, I2CSTR_ARDY);
        bus_write16(&I2CA->I2CCNT, 2u * HAL_EEPROM_WORDS);
        bus_write16(&I2CA->I2CMDR, MODE_READ);
    }
    return HAL_EEPROM_BUSY;
}

void hal_eeprom_abort(void)
{
    bus_write16(&I2CA->I2CMDR, 0u);
    bus_write16(&I2CA->I2CMDR, MODE_IDLE);
}

void hal_eeprom_wait(void)
{
    bus_wait(2u * HALF_BIT_CYCLES);
}

#endif
