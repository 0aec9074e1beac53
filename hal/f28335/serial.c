/* The sample interrupt empties the receive FIFO and fills the transmit FIFO. Its period may be longer than
 * the time in which 16 octets fill the receive FIFO, so this FIFO has an interrupt of its own from FIFO_LEVEL
 * octets on; fewer octets wait for the sample interrupt. The count of errors is stored in the period register
 * of CPU timer 2, which is stopped, because this module must not use variables (on the host several chips
 * share one process). */
#include "hal/f28335/serial.h"

#include "hal/f28335/bus.h"

#if BOARD_SERIAL_BAUD != 0

#define ERRORS (&CPU_TIMER(2u)->PRD)

#define BRR            ((uint16_t)(BOARD_SERIAL_DIVIDER - 1))
#define SCICTL1_BOTH   (SCICTL1_RXENA | SCICTL1_TXENA)
#define SCIFFTX_RESET  (SCIFFTX_SCIRST | SCIFFTX_SCIFFENA)
#define SCIFFTX_WORD   ((uint16_t)(SCIFFTX_RESET | SCIFFTX_TXFIFORESET))
#define FIFO_LEVEL     4u
#define SCIFFRX_RUN    (SCIFFRX_RXFIFORESET | SCIFFRX_RXFFIENA | SCIFFRX_RXFFIL(FIFO_LEVEL))
#define SCIFFRX_FORGET ((uint16_t)(SCIFFRX_RUN | SCIFFRX_RXFFOVRCLR | SCIFFRX_RXFFINTCLR))
#define SCIFFRX_EMPTY  ((uint16_t)(SCIFFRX_FORGET & ~(uint32_t)SCIFFRX_RXFIFORESET))

/* The module has no clock before hal_init, and none if the crystal is missing. */
static bool has_clock(void)
{
    return (SYSCTRL->PCLKCR0 & PCLKCR0_SCIA) != 0u;
}

static void count_error(void)
{
    bus_write32(ERRORS, *ERRORS + 1u);
}

/* Resets flags and state machines of the module. An octet that is being sent is lost. */
static void restart_line(void)
{
    bus_write16(&SCIA->SCICTL1, SCICTL1_BOTH);
    bus_write16(&SCIA->SCICTL1, SCICTL1_BOTH | SCICTL1_SWRESET);
}

void serial_init(void)
{
    bus_write16(&CPU_TIMER(2u)->TCR, TCR_TSS);
    bus_write32(ERRORS, 0u);
    bus_write16(&SCIA->SCICTL1, 0u);
    bus_write16(&SCIA->SCIFFTX, SCIFFTX_RESET);
    bus_write16(&SCIA->SCIFFRX, 0u);
    bus_write16(&SCIA->SCIFFCT, 0u);
    bus_write16(&SCIA->SCICCR, SCICCR_8N1);
    bus_write16(&SCIA->SCICTL2, 0u);
    bus_write16(&SCIA->SCIHBAUD, BRR >> 8);
    bus_write16(&SCIA->SCILBAUD, BRR & 0x00FFu);
    bus_write16(&SCIA->SCIPRI, SCIPRI_FREE);
    bus_write16(&SCIA->SCIFFTX, SCIFFTX_WORD);
    bus_write16(&SCIA->SCIFFRX, SCIFFRX_FORGET);
    restart_line();
}

/* Counts and clears errors of the receiver. After a break the receiver is stopped until it is restarted.
 */
static void look_after_receiver(uint16_t fifo)
{
    if ((fifo & SCIFFRX_RXFFOVF) != 0u) {
        count_error();
    }
    if ((fifo & (SCIFFRX_RXFFOVF | SCIFFRX_RXFFINT)) !=
        0u) { /* no interrupt would follow while the flag stays set */
        bus_write16(&SCIA->SCIFFRX, SCIFFRX_FORGET);
    }
    if ((bus_read16(&SCIA->SCIRXST) & SCIRXST_BRKDT) != 0u) {
        count_error();
        restart_line();
    }
}

uint32_t hal_serial_read(uint16_t *octets, uint32_t room)
{
    uint16_t fifo;
    uint16_t waiting;
    uint32_t count = 0u;

    if (!has_clock()) {
        return 0u;
    }
    fifo = bus_read16(&SCIA->SCIFFRX);
    for (waiting = SCIFF_ST(fifo); waiting > 0u && count < room; waiting--) {
        const uint16_t word = bus_read16(&SCIA->SCIRXBUF);
        if ((word & SCIRXBUF_SCIFFFE) != 0u) {
            count_error();
        } else {
            octets[count] = word & 0x00FFu;
            count++;
        }
    }
    look_after_receiver(fifo);
    return count;
}

void hal_serial_drop(void)
{
    if (has_clock() && SCIFF_ST(bus_read16(&SCIA->SCIFFRX)) > 0u) {
        count_error();
        bus_write16(&SCIA->SCIFFRX, SCIFFRX_EMPTY);
        bus_write16(&SCIA->SCIFFRX, SCIFFRX_FORGET);
    }
}

uint32_t hal_serial_write(const uint16_t *octets, uint32_t count)
{
    uint32_t room;
    uint32_t n;

    if (!has_clock()) {
        return 0u;
    }
    room = (uint32_t)SCI_FIFO - SCIFF_ST(bus_read16(&SCIA->SCIFFTX));
    for (n = 0u; n < count && n < room; n++) {
        bus_write16(&SCIA->SCITXBUF, octets[n] & 0x00FFu);
    }
    return n;
}

bool hal_serial_sends(void)
{
    return has_clock() && (SCIFF_ST(bus_read16(&SCIA->SCIFFTX)) != 0u ||
                           (bus_read16(&SCIA->SCICTL2) & SCICTL2_TXEMPTY) == 0u);
}

void hal_serial_baud(uint32_t baud)
{
    const uint32_t lspclk = (uint32_t)BOARD_SYSCLK_HZ / UINT32_C(4);
    const uint32_t divider = (lspclk + UINT32_C(4) * baud) / (UINT32_C(8) * baud);

    if (has_clock()) {
        bus_write16(&SCIA->SCICTL1, SCICTL1_BOTH);
        bus_write16(&SCIA->SCIHBAUD, (uint16_t)((divider - 1u) >> 8));
        bus_write16(&SCIA->SCILBAUD, (uint16_t)((divider - 1u) & 0x00FFu));
        restart_line();
    }
}

uint32_t hal_serial_errors(void)
{
    return has_clock() ? *ERRORS : 0u;
}

#else

void serial_init(void)
{
}

void hal_serial_drop(void)
{
}

uint32_t hal_serial_read(uint16_t *octets, uint32_t room)
{
    (void)octets;
    (void)room;
    return 0u;
}

uint32_t hal_serial_write(const uint16_t *octets, uint32_t count)
{
    (void)octets;
    (void)count;
    return 0u;
}

bool hal_serial_sends(void)
{
    return false;
}

void hal_serial_baud(uint32_t baud)
{
    (void)baud;
}

uint32_t hal_serial_errors(void)
{
    return 0u;
}

#endif
