/* GPIO: SPRUFB0 ch. 4. Pins 0..87 in three ports. Input qualification is not modelled: every input is
 * asynchronous for each value of QSEL, so a trip acts at the tick of the pin. */
#include <assert.h>

#include "host_sim/chip/parts.h"

#define GPIO_PORTS 3u

uint32_t gpio_mux(const chip_t *chip, uint32_t pin)
{
    const gpio_control_regs_t *port = &chip->registers.gpio_control[pin / 32u];
    uint32_t within = pin % 32u;
    uint32_t mux = within < 16u ? port->MUX1 : port->MUX2;
    return (mux >> (2u * (within & 15u))) & 3u;
}

uint32_t gpio_trip_low(const chip_t *chip)
{
    static const struct {
        uint32_t pin, mux;
    } trip[6] = {{12u, 1u}, {13u, 1u}, {14u, 1u}, {15u, 1u}, {16u, 3u}, {17u, 3u}};
    uint32_t low = 0u;
    for (uint32_t n = 0u; n < 6u; n++) {
        bool here = gpio_mux(chip, trip[n].pin) == trip[n].mux;
        if (here && (chip->gpio_input[0] & GPIO_PIN(trip[n].pin)) == 0u) {
            low |= 1u << n;
        }
    }
    return low;
}

int32_t chip_pin_out(const chip_t *chip, uint32_t gpio)
{
    assert(gpio < 88u);
    uint32_t bit = GPIO_PIN(gpio);
    uint32_t port = gpio / 32u;
    if (gpio < 2u * CHIP_EPWMS && (chip->pins.muxed & bit) != 0u) {
        return (chip->pins.driven & bit) == 0u ? -1 : (chip->pins.level & bit) != 0u;
    }
    if (gpio_mux(chip, gpio) != 0u || (chip->registers.gpio_control[port].DIR & bit) == 0u) {
        return -1;
    }
    return (chip->gpio_latch[port] & bit) != 0u;
}

/* DAT shows the pin, also if a peripheral uses it. While the input clock is stopped, DAT keeps the last
 * levels of the inputs. */
static uint32_t level_of(const chip_t *chip, uint32_t port)
{
    bool clocked = (chip->registers.sysctrl.PCLKCR3 & PCLKCR3_GPIOIN) != 0u;
    uint32_t driven = chip->registers.gpio_control[port].DIR;
    uint32_t pulled = port == 1u ? i2c_lines_low(chip) : 0u;
    uint32_t outside = clocked ? chip->gpio_input[port] & ~pulled : chip->registers.gpio_data[port].DAT;
    return (chip->gpio_latch[port] & driven) | (outside & ~driven);
}

void gpio_show(chip_t *chip)
{
    chip->registers.gpio_data[0].DAT = (level_of(chip, 0u) & ~chip->pins.driven) | chip->pins.level;
}

void gpio_refresh(chip_t *chip)
{
    gpio_show(chip);
    for (uint32_t n = 1u; n < GPIO_PORTS; n++) {
        chip->registers.gpio_data[n].DAT = level_of(chip, n);
    }
}

void gpio_reset(chip_t *chip)
{
    for (uint32_t n = 0u; n < GPIO_PORTS; n++) {
        chip->gpio_latch[n] = 0u;
    }
    chip->registers.gpio_control[0].PUD = 0x00000FFFu;
}

static void write_data(chip_t *chip, uint32_t address, uint32_t value)
{
    uint32_t n = (address - GPIO_DATA_AT) / 8u;
    switch ((address - GPIO_DATA_AT) % 8u) {
    case OFFSET(gpio_data_regs_t, DAT):
        chip->gpio_latch[n] = value;
        break;
    case OFFSET(gpio_data_regs_t, SET):
        chip->gpio_latch[n] |= value;
        break;
    case OFFSET(gpio_data_regs_t, CLEAR):
        chip->gpio_latch[n] &= ~value;
        break;
    case OFFSET(gpio_data_regs_t, TOGGLE):
        chip->gpio_latch[n] ^= value;
        break;
    default:
        chip_report(chip, CHIP_BAD_WIDTH, address);
        return;
    }
    if (n == 0u && ((chip->gpio_latch[0] ^ chip->pins.gpio_level) & chip->pins.gpio_driven) != 0u) {
        outputs_changed(chip);
    }
}

static void write_control(chip_t *chip, uint32_t address, uint32_t value)
{
    uint32_t n = (address - GPIO_CONTROL_AT) / 16u;
    uint32_t offset = (address - GPIO_CONTROL_AT) % 16u;
    gpio_control_regs_t *port = &chip->registers.gpio_control[n];
    bool qualified = n < 2u; /* port C has neither CTRL nor QSEL */
    uint32_t *reg = NULL;
    switch (offset) {
    case OFFSET(gpio_control_regs_t, CTRL):
        reg = qualified ? &port->CTRL : NULL;
        break;
    case OFFSET(gpio_control_regs_t, QSEL1):
        reg = qualified ? &port->QSEL1 : NULL;
        break;
    case OFFSET(gpio_control_regs_t, QSEL2):
        reg = qualified ? &port->QSEL2 : NULL;
        break;
    case OFFSET(gpio_control_regs_t, MUX1):
        reg = &port->MUX1;
        break;
    case OFFSET(gpio_control_regs_t, MUX2):
        reg = &port->MUX2;
        break;
    case OFFSET(gpio_control_regs_t, DIR):
        reg = &port->DIR;
        break;
    case OFFSET(gpio_control_regs_t, PUD):
        reg = &port->PUD;
        break;
    default:
        break;
    }
    if (reg == NULL) {
        chip_report(chip, (offset & 1u) != 0u ? CHIP_BAD_WIDTH : CHIP_UNKNOWN_REGISTER, address);
        return;
    }
    if (!chip->cpu.allow) {
        chip_report(chip, CHIP_PROTECTED_WRITE, address);
        return;
    }
    sci_refresh(chip);
    *reg = value;
    i2c_pins(chip);
    eqep_connect(chip);
    trip_pins(chip);
    outputs_changed(chip);
}

void gpio_write(chip_t *chip, uint32_t address, uint32_t value)
{
    epwm_settle(chip);
    if (address >= GPIO_DATA_AT) {
        write_data(chip, address, value);
    } else {
        write_control(chip, address, value);
    }
    gpio_refresh(chip);
}
