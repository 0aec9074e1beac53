/* I2C-A as a master with FIFOs, SPRUG03, and the memory on its bus (i2c_memory.c). Not modelled: slave mode,
 * interrupts, a second master, addresses of 10 bits, repeat mode, free data format: if requested, they are
 * reported.
 *
 * As in sci.c, the transfer is simulated only when software accesses a register: each access brings the
 * transfer up to the present tick. A transfer proceeds octet by octet, each with its acknowledge bit, nine
 * bits; START and STOP
 * take one bit each. */
#include <assert.h>

#include "host_sim/chip/i2c_parts.h"

enum {
    PHASE_IDLE,
    PHASE_START,   /* START, then the address */
    PHASE_SEND,    /* an octet is being sent */
    PHASE_STARVED, /* the next octet is missing: SCL is held low */
    PHASE_RECEIVE, /* an octet is being received */
    PHASE_HELD,    /* the counter is at 0 without STP: SCL is held low */
    PHASE_NACKED,  /* SCL is held low until STP */
    PHASE_STOP     /* STOP */
};

#define BITS_OF_OCTET 9u
#define STR_CLEARS    (I2CSTR_AL | I2CSTR_NACK | I2CSTR_ARDY | I2CSTR_SCD)
#define STR_RESET     (I2CSTR_XSMT | I2CSTR_XRDY)
#define MDR_KNOWN     (I2CMDR_IRS | I2CMDR_TRX | I2CMDR_MST | I2CMDR_STP | I2CMDR_STT | I2CMDR_FREE)
#define SLOWEST_HZ    7000000u /* of the module's clock */
#define FASTEST_HZ    12000000u
#define LINES         (GPIO_PIN(32u) | GPIO_PIN(33u))

static i2c_regs_t *regs(chip_t *chip)
{
    return &chip->registers.i2ca;
}

static bool clocked(const chip_t *chip)
{
    return (chip->registers.sysctrl.PCLKCR0 & PCLKCR0_I2CA) != 0u;
}

static bool connected(const chip_t *chip)
{
    return gpio_mux(chip, 32u) == 1u && gpio_mux(chip, 33u) == 1u;
}

/* [ticks] of this number of bits by the module's clock, up to the next whole one. */
static uint64_t bits(const chip_t *chip, uint32_t count)
{
    const i2c_regs_t *i2c = &chip->registers.i2ca;
    const uint64_t delay = i2c->I2CPSC == 0u ? 7u : i2c->I2CPSC == 1u ? 6u : 5u;
    const uint64_t cycles = (uint64_t)(i2c->I2CPSC + 1u) * (i2c->I2CCLKL + i2c->I2CCLKH + 2u * delay) * count;
    return (cycles * chip->clock.ticks + chip->clock.cycles - 1u) / chip->clock.cycles;
}

/* ---- Transfer ---- */

static void enter(chip_t *chip, uint32_t phase, uint32_t bit_count)
{
    chip->i2c.phase = phase;
    chip->i2c.due += bits(chip, bit_count);
}

static void drop_mode(chip_t *chip, uint32_t mask)
{
    regs(chip)->I2CMDR = (uint16_t)(regs(chip)->I2CMDR & ~mask);
}

static void stop(chip_t *chip)
{
    enter(chip, PHASE_STOP, 1u);
}

/* The counter is at 0. */
static void end_of_count(chip_t *chip)
{
    if ((regs(chip)->I2CMDR & I2CMDR_STP) != 0u) {
        stop(chip);
        return;
    }
    regs(chip)->I2CSTR |= I2CSTR_ARDY;
    chip->i2c.phase = PHASE_HELD;
}

static void send_next(chip_t *chip)
{
    chip_i2c_t *i2c = &chip->i2c;
    if (i2c->left == 0u) {
        end_of_count(chip);
    } else if (i2c->waiting == 0u) {
        i2c->phase = PHASE_STARVED;
        regs(chip)->I2CSTR = (uint16_t)(regs(chip)->I2CSTR & ~I2CSTR_XSMT);
    } else {
        i2c->shifted = i2c->out[i2c->waiting_first];
        i2c->waiting_first = (i2c->waiting_first + 1u) % I2C_FIFO;
        i2c->waiting--;
        i2c->left--;
        enter(chip, PHASE_SEND, BITS_OF_OCTET);
    }
}

static void receive_next(chip_t *chip)
{
    chip_i2c_t *i2c = &chip->i2c;
    if (i2c->left == 0u) {
        end_of_count(chip);
    } else {
        i2c->left--;
        enter(chip, PHASE_RECEIVE, BITS_OF_OCTET);
    }
}

static void not_acknowledged(chip_t *chip)
{
    regs(chip)->I2CSTR |= I2CSTR_NACK;
    chip->i2c.phase = PHASE_NACKED;
}

/* The address has been sent. */
static void addressed(chip_t *chip)
{
    const bool out = (regs(chip)->I2CMDR & I2CMDR_TRX) != 0u;
    drop_mode(chip, I2CMDR_STT);
    chip->i2c.left = regs(chip)->I2CCNT;
    if (!i2c_memory_select(chip, regs(chip)->I2CSAR, !out)) {
        not_acknowledged(chip);
    } else if (out) {
        send_next(chip);
    } else {
        receive_next(chip);
    }
}

static void stopped(chip_t *chip)
{
    i2c_memory_stop(chip);
    drop_mode(chip, I2CMDR_STP | I2CMDR_MST);
    regs(chip)->I2CSTR = (uint16_t)((regs(chip)->I2CSTR | I2CSTR_SCD) & ~I2CSTR_BB);
    chip->i2c.phase = PHASE_IDLE;
}

/* The operation that lasted until `due` is complete. */
static void complete(chip_t *chip)
{
    chip_i2c_t *i2c = &chip->i2c;
    switch (i2c->phase) {
    case PHASE_START:
        addressed(chip);
        break;
    case PHASE_SEND:
        if (i2c_memory_put(chip, i2c->shifted)) {
            send_next(chip);
        } else {
            not_acknowledged(chip);
        }
        break;
    case PHASE_RECEIVE:
        if (i2c->received < I2C_FIFO) {
            i2c->in[i2c->received++] = (uint16_t)i2c_memory_get(chip);
        }
        receive_next(chip);
        break;
    default:
        stopped(chip);
        break;
    }
}

static bool moves(uint32_t phase)
{
    return phase == PHASE_START || phase == PHASE_SEND || phase == PHASE_RECEIVE || phase == PHASE_STOP;
}

static void show(chip_t *chip)
{
    i2c_regs_t *i2c = regs(chip);
    const uint32_t waiting = chip->i2c.waiting;
    const uint32_t received = chip->i2c.received;
    i2c->I2CFFTX = (uint16_t)((i2c->I2CFFTX & (I2CFFTX_TXFFRST | I2CFFTX_I2CFFEN)) | waiting << 8);
    i2c->I2CFFRX = (uint16_t)((i2c->I2CFFRX & I2CFFRX_RXFFRST) | received << 8);
    i2c->I2CDRR = received > 0u ? chip->i2c.in[0] : i2c->I2CDRR;
}

void i2c_refresh(chip_t *chip)
{
    while (moves(chip->i2c.phase) && chip->i2c.due <= chip->tick && !chip->cpu.halted) {
        complete(chip);
    }
    show(chip);
}

/* ---- Registers ---- */

static void forget(chip_t *chip)
{
    chip->i2c.phase = PHASE_IDLE;
    chip->i2c.left = 0u;
    regs(chip)->I2CSTR = STR_RESET;
}

void i2c_reset(chip_t *chip)
{
    forget(chip);
    chip->i2c.waiting = 0u;
    chip->i2c.received = 0u;
    show(chip);
}

static uint32_t module_hz(const chip_t *chip)
{
    return chip_sysclk_hz(chip) / (chip->registers.i2ca.I2CPSC + 1u);
}

/* START comes if the bus is free. It waits while a line stays low. */
static void begin(chip_t *chip)
{
    chip_i2c_t *i2c = &chip->i2c;
    const bool again = i2c->phase == PHASE_HELD;
    if (module_hz(chip) < SLOWEST_HZ || module_hz(chip) > FASTEST_HZ) {
        chip_report(chip, CHIP_I2C_MISUSE, I2CA_AT + OFFSET(i2c_regs_t, I2CPSC));
    }
    if (!connected(chip) || i2c_memory_pulls(chip) != 0u || (!again && i2c->phase != PHASE_IDLE)) {
        return;
    }
    regs(chip)->I2CSTR |= I2CSTR_BB;
    i2c->due = chip->tick;
    enter(chip, PHASE_START, 1u + BITS_OF_OCTET);
}

static void write_mode(chip_t *chip, uint16_t value)
{
    const bool ran = (regs(chip)->I2CMDR & I2CMDR_IRS) != 0u;
    const uint32_t phase = chip->i2c.phase;
    regs(chip)->I2CMDR = value;
    if ((value & I2CMDR_IRS) == 0u) {
        if (ran) {
            forget(chip);
        }
    } else if ((value & I2CMDR_STT) != 0u && (value & I2CMDR_MST) != 0u) {
        begin(chip);
    } else if ((value & I2CMDR_STP) != 0u && (phase == PHASE_HELD || phase == PHASE_NACKED)) {
        chip->i2c.due = chip->tick;
        stop(chip);
    }
}

static void put(chip_t *chip, uint16_t value)
{
    chip_i2c_t *i2c = &chip->i2c;
    if (i2c->waiting == I2C_FIFO || (regs(chip)->I2CFFTX & I2CFFTX_TXFFRST) == 0u) {
        chip_report(chip, CHIP_SERIAL_LOST, I2CA_AT + OFFSET(i2c_regs_t, I2CDXR));
        return;
    }
    i2c->out[(i2c->waiting_first + i2c->waiting) % I2C_FIFO] = (uint16_t)(value & 0x00FFu);
    i2c->waiting++;
    if (i2c->phase == PHASE_STARVED) {
        regs(chip)->I2CSTR |= I2CSTR_XSMT;
        i2c->due = chip->tick;
        send_next(chip);
    }
}

uint16_t i2c_read(chip_t *chip, uint32_t address)
{
    i2c_refresh(chip);
    const uint16_t value = ((const uint16_t *)&chip->registers)[address];
    chip_i2c_t *i2c = &chip->i2c;
    if (address - I2CA_AT == OFFSET(i2c_regs_t, I2CDRR) && clocked(chip) && i2c->received > 0u) {
        i2c->received--;
        for (uint32_t n = 0u; n < i2c->received; n++) {
            i2c->in[n] = i2c->in[n + 1u];
        }
        show(chip);
    }
    return value;
}

/* Reports the bits of a value that this model does not have. */
static uint32_t unknown(uint32_t offset, uint16_t value)
{
    switch (offset) {
    case OFFSET(i2c_regs_t, I2CMDR):
        return value & ~MDR_KNOWN;
    case OFFSET(i2c_regs_t, I2CSTR):
        return value & ~STR_CLEARS;
    case OFFSET(i2c_regs_t, I2CFFTX):
        return value & ~(I2CFFTX_TXFFRST | I2CFFTX_I2CFFEN);
    case OFFSET(i2c_regs_t, I2CFFRX):
        return value & ~I2CFFRX_RXFFRST;
    case OFFSET(i2c_regs_t, I2CPSC):
    case OFFSET(i2c_regs_t, I2CDXR):
        return value & 0xFF00u;
    case OFFSET(i2c_regs_t, I2CSAR):
        return value & 0xFF80u;
    case OFFSET(i2c_regs_t, I2CCLKL):
    case OFFSET(i2c_regs_t, I2CCLKH):
    case OFFSET(i2c_regs_t, I2CCNT):
        return 0u;
    default: /* I2COAR, I2CIER (slave mode, interrupts), and reserved registers */
        return value;
    }
}

static bool is_rate(uint32_t offset)
{
    return offset == OFFSET(i2c_regs_t, I2CPSC) || offset == OFFSET(i2c_regs_t, I2CCLKL) ||
           offset == OFFSET(i2c_regs_t, I2CCLKH);
}

static void obey(chip_t *chip, uint32_t offset, uint16_t value)
{
    uint16_t *reg = (uint16_t *)&chip->registers + I2CA_AT + offset;
    switch (offset) {
    case OFFSET(i2c_regs_t, I2CSTR):
        *reg = (uint16_t)(*reg & ~(value & STR_CLEARS));
        break;
    case OFFSET(i2c_regs_t, I2CMDR):
        write_mode(chip, value);
        break;
    case OFFSET(i2c_regs_t, I2CDXR):
        put(chip, value);
        break;
    case OFFSET(i2c_regs_t, I2CFFTX):
        *reg = value;
        chip->i2c.waiting = (value & I2CFFTX_TXFFRST) != 0u ? chip->i2c.waiting : 0u;
        break;
    case OFFSET(i2c_regs_t, I2CFFRX):
        *reg = value;
        chip->i2c.received = (value & I2CFFRX_RXFFRST) != 0u ? chip->i2c.received : 0u;
        break;
    default:
        *reg = value;
        break;
    }
}

void i2c_write(chip_t *chip, uint32_t address, uint16_t value)
{
    const uint32_t offset = address - I2CA_AT;
    if (!clocked(chip)) {
        chip_report(chip, CHIP_CLOCK_OFF, address);
        return;
    }
    if (offset == OFFSET(i2c_regs_t, I2CDRR) || offset == OFFSET(i2c_regs_t, I2CISRC)) {
        chip_report(chip, CHIP_READ_ONLY, address);
        return;
    }
    if (unknown(offset, value) != 0u) {
        chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        return;
    }
    if (is_rate(offset) && (regs(chip)->I2CMDR & I2CMDR_IRS) != 0u) {
        chip_report(chip, CHIP_I2C_MISUSE, address);
        return;
    }
    i2c_refresh(chip);
    obey(chip, offset, value);
    i2c_refresh(chip);
}

/* ---- The lines as plain pins ---- */

uint32_t i2c_lines_low(const chip_t *chip)
{
    return i2c_memory_pulls(chip);
}

/* A memory in the middle of a transfer releases the data line after enough clock pulses. */
void i2c_pins(chip_t *chip)
{
    const uint32_t pulled = gpio_mux(chip, 33u) == 0u &&
                            (chip->registers.gpio_control[1].DIR & GPIO_PIN(33u)) != 0u &&
                            (chip->gpio_latch[1] & GPIO_PIN(33u)) == 0u;
    if (chip->i2c.clock_low != 0u && pulled == 0u) {
        i2c_memory_clock(chip);
    }
    chip->i2c.clock_low = pulled;
}
