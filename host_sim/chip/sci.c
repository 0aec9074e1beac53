/* SCI-A: SPRUFZ5. Models frames of 8 data bits without parity through both FIFOs, and the interrupt of the
 * receive FIFO. Nothing else of the module is modelled, neither single buffers nor other frames: if software
 * requests them, this is reported and the line stays quiet. The flag of the interrupt rises when an octet
 * comes and the level is reached: a level that is still reached when the flag is cleared does not raise it by
 * itself.
 *
 * Without that interrupt the line is simulated only on access: each access by software, and each call from
 * outside, brings line, FIFOs and flags up to the present tick. An unused line therefore costs no time.
 *
 * The line towards the chip is a row of frames, each with its levels bit by bit; between them it is high. The
 * receiver works on these levels as in SPRUFZ5: a start bit is a falling edge after which the line is low for
 * four SCICLK (a bit has eight); each following bit is the majority of the 4th, 5th and 6th SCICLK of the
 * bit. Therefore a different rate at the other end has the same effect as on silicon. */
#include <assert.h>

#include "host_sim/chip/parts.h"

#define CLOCKS_PER_BIT 8u
#define BITS           10u /* start, eight data, stop */
#define STOP_BIT       9u
#define DATA(octet)    ((uint32_t)(octet) << 1 | 1u << STOP_BIT)
/* A break: the line stays low for this time after a missing stop bit [eighths of a bit], 9.625 bits. */
#define BREAK_EIGHTHS 77u
#define NOT_SO_FAR    CHIP_NEVER

#define SCICTL1_STORED (SCICTL1_RXENA | SCICTL1_TXENA | SCICTL1_SWRESET)
#define SCIFF_LEVEL    31u
#define SCIFFTX_STORED (SCIFFTX_SCIRST | SCIFFTX_SCIFFENA | SCIFFTX_TXFIFORESET | SCIFF_LEVEL)
#define SCIFFTX_CLEARS (1u << 6) /* of an interrupt that never occurs */
#define RUNNING        (SCIFFTX_SCIRST | SCIFFTX_SCIFFENA)

static sci_regs_t *regs(chip_t *chip)
{
    return &chip->registers.scia;
}

static bool clocked(const chip_t *chip)
{
    return (chip->registers.sysctrl.PCLKCR0 & PCLKCR0_SCIA) != 0u;
}

/* One half of the module is set up and out of reset; a debugger's halt stops it unless FREE is set. */
static bool works(const chip_t *chip, uint32_t half)
{
    const sci_regs_t *sci = &chip->registers.scia;
    return clocked(chip) && sci->SCICCR == SCICCR_8N1 && (sci->SCIFFTX & RUNNING) == RUNNING &&
           (sci->SCICTL1 & (half | SCICTL1_SWRESET)) == (half | SCICTL1_SWRESET) &&
           (!chip->debug.halted || (sci->SCIPRI & SCIPRI_FREE) != 0u);
}

static bool hears(const chip_t *chip)
{
    bool pin = gpio_mux(chip, 28u) == 1u || gpio_mux(chip, 36u) == 1u;
    return pin && works(chip, SCICTL1_RXENA) && (chip->registers.scia.SCIFFRX & SCIFFRX_RXFIFORESET) != 0u;
}

static bool speaks(const chip_t *chip)
{
    return works(chip, SCICTL1_TXENA) && (chip->registers.scia.SCIFFTX & SCIFFTX_TXFIFORESET) != 0u;
}

/* `count` eighths of a bit are count times this over clock.cycles ticks, by the chip's own clock and rate. */
static uint64_t eighth(const chip_t *chip)
{
    const sci_regs_t *sci = &chip->registers.scia;
    uint32_t lospcp = chip->registers.sysctrl.LOSPCP;
    uint32_t brr = (sci->SCIHBAUD & 0xFFu) << 8 | (sci->SCILBAUD & 0xFFu);
    return (uint64_t)(brr == 0u ? 2u : brr + 1u) * (lospcp == 0u ? 1u : 2u * lospcp) * chip->clock.ticks;
}

/* [ticks] up to the next whole one. */
static uint64_t eighths(const chip_t *chip, uint64_t count)
{
    return (count * eighth(chip) + chip->clock.cycles - 1u) / chip->clock.cycles;
}

/* ---- The line towards the chip ---- */

/* [ticks] from the begin of a frame to that of its bit n, by the clock of the sender; and the bit of a tick.
 */
static uint64_t bit_at(const chip_t *chip, uint32_t n)
{
    uint32_t baud = chip->sci.line_baud;
    return baud != 0u ? n * CHIP_TICKS_PER_SECOND / baud : eighths(chip, (uint64_t)n * CLOCKS_PER_BIT);
}

static uint32_t bit_of(const chip_t *chip, uint64_t ticks)
{
    uint32_t baud = chip->sci.line_baud;
    return (uint32_t)(baud != 0u ? ((ticks + 1u) * baud - 1u) / CHIP_TICKS_PER_SECOND
                                 : ticks * chip->clock.cycles / (CLOCKS_PER_BIT * eighth(chip)));
}

static const chip_frame_t *frame(const chip_t *chip, uint32_t n)
{
    return &chip->sci.line[(chip->sci.line_first + n) % CHIP_LINE_FRAMES];
}

static uint64_t frame_end(const chip_t *chip, const chip_frame_t *on_line)
{
    return on_line->start + bit_at(chip, on_line->bits);
}

/* The first tick from `from` on at which the line has this `level`; after the last frame the line is high. */
static uint64_t level_from(const chip_t *chip, uint64_t from, uint32_t level)
{
    for (uint32_t n = 0u; n < chip->sci.line_count; n++) {
        const chip_frame_t *on_line = frame(chip, n);
        if (frame_end(chip, on_line) <= from) {
            continue;
        }
        if (level == 1u && from < on_line->start) {
            return from;
        }
        for (uint32_t bit = 0u; bit < on_line->bits; bit++) {
            uint64_t end = on_line->start + bit_at(chip, bit + 1u);
            if (end > from && (on_line->levels >> bit & 1u) == level) {
                uint64_t begin = on_line->start + bit_at(chip, bit);
                return begin > from ? begin : from;
            }
        }
    }
    return level == 1u ? from : NOT_SO_FAR; /* behind the last frame the line is high */
}

static bool line_is_low(const chip_t *chip, uint64_t tick)
{
    for (uint32_t n = 0u; n < chip->sci.line_count && frame(chip, n)->start <= tick; n++) {
        const chip_frame_t *on_line = frame(chip, n);
        uint32_t bit = bit_of(chip, tick - on_line->start);
        if (bit < on_line->bits) {
            return (on_line->levels >> bit & 1u) == 0u;
        }
    }
    return false;
}

/* Last tick at which a frame on the line ends. */
static uint64_t line_end(const chip_t *chip)
{
    return chip->sci.line_count == 0u ? 0u : frame_end(chip, frame(chip, chip->sci.line_count - 1u));
}

/* ---- Receiver ---- */

static void receive(chip_t *chip, uint32_t octet, bool stopped)
{
    chip_sci_t *sci = &chip->sci;
    if (sci->received == SCI_FIFO) { /* the oldest is lost */
        regs(chip)->SCIFFRX |= SCIFFRX_RXFFOVF;
        sci->received_first = (sci->received_first + 1u) % SCI_FIFO;
        sci->received--;
    }
    sci->in[(sci->received_first + sci->received) % SCI_FIFO] =
        (uint16_t)(octet | (stopped ? 0u : SCIRXBUF_SCIFFFE));
    sci->received++;
    if (!stopped) {
        regs(chip)->SCIRXST |= SCIRXST_FE | SCIRXST_RXERROR;
    }
    const uint32_t state = regs(chip)->SCIFFRX;
    if (sci->received >= (state & SCIFF_LEVEL) && (state & SCIFFRX_RXFFINT) == 0u) {
        regs(chip)->SCIFFRX |= SCIFFRX_RXFFINT;
        if ((state & SCIFFRX_RXFFIENA) != 0u) {
            pie_request(chip, 9u, 1u);
        }
    }
}

/* Majority of three samples in the middle of bit n of a frame that fell at `fall`. */
static uint32_t sampled(const chip_t *chip, uint64_t fall, uint32_t n)
{
    uint32_t high = 0u;
    for (uint32_t k = 4u; k <= 6u; k++) {
        high += !line_is_low(chip, fall + eighths(chip, (uint64_t)n * CLOCKS_PER_BIT + k));
    }
    return high >= 2u;
}

/* After a missing stop bit: a break if the line stays low, otherwise the receiver waits for the next falling
 * edge. False: this edge has not occurred yet. */
static bool after_missing_stop(chip_t *chip)
{
    chip_sci_t *sci = &chip->sci;
    uint64_t rise = level_from(chip, sci->looks_from, 1u);
    uint64_t limit = sci->looks_from + eighths(chip, BREAK_EIGHTHS);
    if (chip->tick < earlier(rise, limit)) {
        return false;
    }
    sci->low = 0u;
    if (rise < limit) {
        sci->looks_from = rise;
    } else {
        regs(chip)->SCIRXST |= SCIRXST_BRKDT | SCIRXST_RXERROR;
        sci->looks_from = limit;
    }
    return true;
}

/* The next frame. False: none is complete. */
static bool receive_next(chip_t *chip)
{
    chip_sci_t *sci = &chip->sci;
    if (sci->low) {
        return after_missing_stop(chip);
    }
    uint64_t fall = level_from(chip, sci->looks_from, 0u);
    if (fall == NOT_SO_FAR) { /* only high levels, including those of the present frame */
        sci->looks_from = chip->tick > sci->looks_from ? chip->tick : sci->looks_from;
        return false;
    }
    if (fall + eighths(chip, STOP_BIT * CLOCKS_PER_BIT + 6u) > chip->tick) {
        return false;
    }
    uint64_t rise = level_from(chip, fall, 1u);
    if (rise < fall + eighths(chip, 4u)) { /* no start bit */
        sci->looks_from = rise;
        return true;
    }
    uint32_t octet = 0u;
    for (uint32_t n = 0u; n < 8u; n++) {
        octet |= sampled(chip, fall, n + 1u) << n;
    }
    bool stopped = sampled(chip, fall, STOP_BIT) != 0u;
    sci->looks_from = fall + eighths(chip, STOP_BIT * CLOCKS_PER_BIT + 6u);
    sci->low = !stopped;
    receive(chip, octet, stopped);
    return true;
}

/* Frames after which the receiver already waits for the next one. */
static void drop_frames(chip_t *chip)
{
    chip_sci_t *sci = &chip->sci;
    while (sci->line_count > 0u && frame_end(chip, frame(chip, 0u)) <= sci->looks_from) {
        sci->line_first = (sci->line_first + 1u) % CHIP_LINE_FRAMES;
        sci->line_count--;
    }
}

static void follow_receiver(chip_t *chip)
{
    chip_sci_t *sci = &chip->sci;
    while (hears(chip) && (regs(chip)->SCIRXST & SCIRXST_BRKDT) == 0u && receive_next(chip)) {
        drop_frames(chip);
    }
    bool deaf = !hears(chip) || (regs(chip)->SCIRXST & SCIRXST_BRKDT) != 0u;
    if (deaf && sci->looks_from < chip->tick) {
        sci->looks_from = chip->tick;
    }
    drop_frames(chip);
}

/* ---- Transmitter ---- */

static void hand_out(chip_t *chip, uint32_t octet)
{
    chip_sci_t *sci = &chip->sci;
    if (gpio_mux(chip, 29u) != 1u && gpio_mux(chip, 35u) != 1u) {
        return;
    }
    if (sci->sent_count == CHIP_LINE_SENT) { /* no receiver is connected */
        sci->sent_first = (sci->sent_first + 1u) % CHIP_LINE_SENT;
        sci->sent_count--;
    }
    sci->sent[(sci->sent_first + sci->sent_count) % CHIP_LINE_SENT] = (uint8_t)octet;
    sci->sent_count++;
}

static void follow_transmitter(chip_t *chip)
{
    chip_sci_t *sci = &chip->sci;
    while (speaks(chip) && (sci->sending || sci->waiting > 0u)) {
        if (sci->sending && sci->sent_at > chip->tick) {
            break;
        }
        uint64_t begin = sci->sending ? sci->sent_at : chip->tick;
        if (sci->sending) {
            hand_out(chip, sci->shifted);
            sci->sending = 0u;
        }
        if (sci->waiting > 0u) {
            sci->shifted = sci->out[sci->waiting_first];
            sci->waiting_first = (sci->waiting_first + 1u) % SCI_FIFO;
            sci->waiting--;
            sci->sending = 1u;
            sci->sent_at = begin + eighths(chip, (uint64_t)BITS * CLOCKS_PER_BIT);
        }
    }
}

static uint16_t in_fifo(uint32_t count)
{
    return (uint16_t)(count << 8);
}

static void show(chip_t *chip)
{
    sci_regs_t *sci = regs(chip);
    const uint32_t waiting = chip->sci.waiting;
    sci->SCIFFTX = (uint16_t)((sci->SCIFFTX & SCIFFTX_STORED) | in_fifo(waiting));
    sci->SCIFFRX = (uint16_t)((sci->SCIFFRX & ~(uint32_t)in_fifo(31u)) | in_fifo(chip->sci.received));
    sci->SCIRXBUF = chip->sci.received > 0u ? chip->sci.in[chip->sci.received_first] : sci->SCIRXBUF;
    sci->SCIRXEMU = sci->SCIRXBUF & 0x00FFu;
    sci->SCIRXST =
        (uint16_t)((sci->SCIRXST & ~SCIRXST_RXRDY) | (chip->sci.received > 0u ? SCIRXST_RXRDY : 0u));
    sci->SCICTL2 = (uint16_t)((waiting < SCI_FIFO ? SCICTL2_TXRDY : 0u) |
                              (waiting == 0u && !chip->sci.sending ? SCICTL2_TXEMPTY : 0u));
}

/* The line is idle in both directions: the registers do not change with time. */
static bool is_quiet(const chip_t *chip)
{
    const chip_sci_t *sci = &chip->sci;
    return (sci->line_count | sci->low | sci->sending | sci->waiting) == 0u;
}

/* The time at which the receiver will have processed the next frame on the line; a false start bit counts as
 * a frame.
 */
static uint64_t next_frame(const chip_t *chip)
{
    const chip_sci_t *sci = &chip->sci;
    const bool waits = hears(chip) && (chip->registers.scia.SCIFFRX & SCIFFRX_RXFFIENA) != 0u &&
                       (chip->registers.scia.SCIRXST & SCIRXST_BRKDT) == 0u &&
                       (sci->line_count | sci->low) != 0u;
    if (!waits) {
        return CHIP_NEVER;
    }
    if (sci->low) {
        return earlier(level_from(chip, sci->looks_from, 1u), sci->looks_from + eighths(chip, BREAK_EIGHTHS));
    }
    const uint64_t fall = level_from(chip, sci->looks_from, 0u);
    return fall == NOT_SO_FAR ? CHIP_NEVER : fall + eighths(chip, STOP_BIT * CLOCKS_PER_BIT + 6u);
}

static void plan(chip_t *chip)
{
    const uint64_t next = next_frame(chip);
    if (next != chip->sci.next) {
        chip->sci.next = next > chip->tick ? next : chip->tick + 1u;
        chip_schedule_rare(chip);
    }
}

void sci_refresh(chip_t *chip)
{
    if (is_quiet(chip)) {
        return;
    }
    follow_receiver(chip);
    follow_transmitter(chip);
    show(chip);
    plan(chip);
}

void sci_event(chip_t *chip)
{
    chip->sci.next = CHIP_NEVER;
    sci_refresh(chip);
    plan(chip);
}

void sci_go(chip_t *chip)
{
    if ((regs(chip)->SCIPRI & SCIPRI_FREE) ==
        0u) { /* the receiver was halted; octets that arrived during the halt are lost */
        chip->sci.sent_at += chip->tick - chip->debug.since;
        chip->sci.looks_from = chip->tick;
    }
}

/* ---- Registers ---- */

static void empty_in(chip_t *chip)
{
    chip->sci.received = 0u;
    chip->sci.low = 0u;
    chip->sci.looks_from = chip->tick;
}

static void empty_out(chip_t *chip)
{
    chip->sci.waiting = 0u;
}

/* Effect of SWRESET at 0: it resets flags and state machines, and ends an octet that is being sent. */
static void reset_states(chip_t *chip)
{
    regs(chip)->SCIRXST = 0u;
    chip->sci.sending = 0u;
    chip->sci.low = 0u;
    chip->sci.looks_from = chip->tick;
}

void sci_reset(chip_t *chip)
{
    sci_regs_t *sci = regs(chip);
    sci->SCIFFTX = SCIFFTX_SCIRST | SCIFFTX_TXFIFORESET;
    sci->SCIFFRX = 0x201Fu;
    chip->sci.next = CHIP_NEVER;
    reset_states(chip);
    empty_in(chip);
    empty_out(chip);
    show(chip);
}

void sci_power_cycle(chip_t *chip)
{
    chip->sci.line_count = 0u;
    chip->sci.sent_count = 0u;
}

uint16_t sci_read(chip_t *chip, uint32_t address)
{
    sci_refresh(chip);
    uint16_t value = ((const uint16_t *)&chip->registers)[address];
    bool takes = address - SCIA_AT == OFFSET(sci_regs_t, SCIRXBUF) && clocked(chip);
    if (takes && chip->sci.received > 0u) {
        chip->sci.received_first = (chip->sci.received_first + 1u) % SCI_FIFO;
        chip->sci.received--;
        show(chip);
    }
    return value;
}

static void write_fifo_out(chip_t *chip, uint16_t value)
{
    regs(chip)->SCIFFTX = value & SCIFFTX_STORED;
    if ((value & SCIFFTX_TXFIFORESET) == 0u || (value & SCIFFTX_SCIRST) == 0u) {
        empty_out(chip);
    }
    if ((value & SCIFFTX_SCIRST) == 0u) {
        empty_in(chip);
        chip->sci.sending = 0u;
    }
}

static void write_fifo_in(chip_t *chip, uint16_t value)
{
    uint32_t overflow = (value & SCIFFRX_RXFFOVRCLR) != 0u ? 0u : regs(chip)->SCIFFRX & SCIFFRX_RXFFOVF;
    if ((value & SCIFFRX_RXFIFORESET) == 0u) {
        empty_in(chip);
    }
    uint32_t raised = (value & SCIFFRX_RXFFINTCLR) != 0u ? 0u : regs(chip)->SCIFFRX & SCIFFRX_RXFFINT;
    regs(chip)->SCIFFRX =
        (uint16_t)(overflow | raised | (value & (SCIFFRX_RXFIFORESET | SCIFFRX_RXFFIENA | SCIFF_LEVEL)));
}

static void write_octet(chip_t *chip, uint32_t address, uint16_t value)
{
    chip_sci_t *sci = &chip->sci;
    if (!speaks(chip) || sci->waiting == SCI_FIFO) {
        chip_report(chip, CHIP_SERIAL_LOST, address);
        return;
    }
    sci->out[(sci->waiting_first + sci->waiting) % SCI_FIFO] = (uint16_t)(value & 0x00FFu);
    sci->waiting++;
}

/* Reports the bits of a value that this model does not have. */
static uint32_t unknown(uint32_t offset, uint16_t value)
{
    switch (offset) {
    case OFFSET(sci_regs_t, SCICCR):
        return value != 0u && value != SCICCR_8N1;
    case OFFSET(sci_regs_t, SCICTL1):
        return value & ~SCICTL1_STORED;
    case OFFSET(sci_regs_t, SCIFFTX):
        return value & ~(SCIFFTX_STORED | SCIFFTX_CLEARS);
    case OFFSET(sci_regs_t, SCIFFRX):
        return value & ~(SCIFFRX_RXFIFORESET | SCIFFRX_RXFFOVRCLR | SCIFFRX_RXFFINTCLR | SCIFFRX_RXFFIENA |
                         SCIFF_LEVEL);
    case OFFSET(sci_regs_t, SCIPRI):
        return value & ~SCIPRI_FREE;
    case OFFSET(sci_regs_t, SCIHBAUD):
    case OFFSET(sci_regs_t, SCILBAUD):
    case OFFSET(sci_regs_t, SCITXBUF):
        return value & 0xFF00u;
    default: /* SCICTL2, SCIFFCT (interrupts, automatic baud rate, delay), and reserved registers */
        return value;
    }
}

void sci_write(chip_t *chip, uint32_t address, uint16_t value)
{
    uint32_t offset = address - SCIA_AT;
    if (!clocked(chip)) {
        chip_report(chip, CHIP_CLOCK_OFF, address);
        return;
    }
    if (offset >= OFFSET(sci_regs_t, SCIRXST) && offset <= OFFSET(sci_regs_t, SCIRXBUF)) {
        chip_report(chip, CHIP_READ_ONLY, address);
        return;
    }
    if (unknown(offset, value) != 0u) {
        chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        return;
    }
    sci_refresh(chip);
    switch (offset) {
    case OFFSET(sci_regs_t, SCICCR):
        regs(chip)->SCICCR = value;
        break;
    case OFFSET(sci_regs_t, SCICTL1):
        regs(chip)->SCICTL1 = value;
        if ((value & SCICTL1_SWRESET) == 0u) {
            reset_states(chip);
        }
        break;
    case OFFSET(sci_regs_t, SCIHBAUD):
        regs(chip)->SCIHBAUD = value;
        break;
    case OFFSET(sci_regs_t, SCILBAUD):
        regs(chip)->SCILBAUD = value;
        break;
    case OFFSET(sci_regs_t, SCITXBUF):
        write_octet(chip, address, value);
        break;
    case OFFSET(sci_regs_t, SCIFFTX):
        write_fifo_out(chip, value);
        break;
    case OFFSET(sci_regs_t, SCIFFRX):
        write_fifo_in(chip, value);
        break;
    case OFFSET(sci_regs_t, SCIPRI):
        regs(chip)->SCIPRI = value;
        break;
    default:
        break;
    }
    sci_refresh(chip);
    show(chip);
    plan(chip);
}

/* ---- From outside ---- */

void chip_serial_speed(chip_t *chip, uint32_t baud)
{
    assert(baud <= CHIP_TICKS_PER_SECOND / CLOCKS_PER_BIT);
    sci_refresh(chip);
    chip->sci.line_baud = baud;
}

bool chip_serial_levels(chip_t *chip, uint32_t levels, uint32_t bits)
{
    chip_sci_t *sci = &chip->sci;
    assert(bits >= 1u && bits <= 31u);
    sci_refresh(chip);
    if (sci->line_count == CHIP_LINE_FRAMES) {
        return false;
    }
    uint64_t end = line_end(chip);
    chip_frame_t *on_line = &sci->line[(sci->line_first + sci->line_count) % CHIP_LINE_FRAMES];
    on_line->start = end > chip->tick ? end : chip->tick;
    bool high =
        (levels >> (bits - 1u) & 1u) != 0u; /* end of the frame; after a low last bit one more bit is high */
    on_line->levels = high ? levels : levels | 1u << bits;
    on_line->bits = high ? bits : bits + 1u;
    sci->line_count++;
    plan(chip);
    return true;
}

uint32_t chip_serial_put(chip_t *chip, const uint8_t *octets, uint32_t count)
{
    uint32_t n = 0u;
    while (n < count && chip_serial_levels(chip, DATA(octets[n]), BITS)) {
        n++;
    }
    return n;
}

uint32_t chip_serial_get(chip_t *chip, uint8_t *octets, uint32_t room)
{
    chip_sci_t *sci = &chip->sci;
    uint32_t n = 0u;
    sci_refresh(chip);
    while (n < room && sci->sent_count > 0u) {
        octets[n++] = sci->sent[sci->sent_first];
        sci->sent_first = (sci->sent_first + 1u) % CHIP_LINE_SENT;
        sci->sent_count--;
    }
    return n;
}
