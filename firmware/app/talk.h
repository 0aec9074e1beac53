/* The communication of the drive: an XCP slave or a Modbus RTU server (firmware/talk/) over the values of the
 * application. The parameter line_protocol chooses between them; they use the same buffers.
 *
 * The interrupt only copies samples into a queue, and octets out of the chip's FIFOs and into them. The
 * background does the rest: it receives octets, executes one command at a time, and sends octets. If a master
 * has switched the bridge on and is then silent for longer than
 * command_timeout, the drive stops the motor. */
#ifndef APP_TALK_H
#define APP_TALK_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/hal.h"
#include "talk/a2l.h"
#include "talk/daq.h"
#include "talk/frame.h"
#include "talk/modbus.h"
#include "talk/xcp.h"

/* The source and destination of octets, one per word; neither call waits. */
typedef struct {
    uint32_t (*read)(uint16_t *octets, uint32_t room);
    uint32_t (*write)(const uint16_t *octets, uint32_t count);
} talk_line_t;

/* NULL: the chip's serial line, hal_serial_*, whose frames have tails; otherwise a line
 * that loses and changes nothing. */
extern HAL_PER_CHIP const talk_line_t *talk_line;

/* Octets between interrupts and background, with space for more than two commands of the largest length.
 * Nothing is lost if the background is late, because a master sends at most one command before it has the
 * answer to the previous one. */
#define TALK_RING  144u
#define TALK_AHEAD 64u /* [octets] to be sent, at most: an answer waits behind no more than these */

/* One side writes `put` and the octets, the other one `got`. They are equal while the ring is empty, and one
 * place stays free. */
typedef struct {
    uint16_t put; /* [-] place of the next octet that is written */
    uint16_t got; /* [-] place of the next octet that is read */
    uint16_t octets[TALK_RING];
} talk_in_t;

typedef struct {
    uint16_t put; /* [-] as in talk_in_t */
    uint16_t got; /* [-] */
    uint16_t octets[TALK_AHEAD + 1u];
} talk_out_t;

/* The protocol on the chip's line, and its state. */
typedef struct {
    int32_t protocol; /* [-] line_protocol_t */
    int32_t address;  /* of the Modbus server; 0 with XCP */
    int32_t baud;     /* [bit/s] */
} talk_setting_t;

typedef struct {
    frame_receiver_t receiver;
    frame_sender_t sender;
    xcp_t xcp;
    daq_t daq;
    a2l_place_t a2l;       /* position at which the client reads */
    uint32_t heard_at;     /* [periods] time of the last good frame */
    uint32_t steered;      /* [-] 1: `enable` was switched on over the serial link, and still is */
    uint32_t silent;       /* [-] 1: communication time-out of the master; until `enable` is set again */
    uint32_t line_errors;  /* [-] of the chip's line, at the last check */
    talk_in_t came;        /* octets that the interrupts have received on the chip's line */
    talk_out_t going;      /* octets that they will send on that line */
    uint32_t answer_count; /* [octets] of the waiting answer; 0: none */
    uint16_t answer[FRAME_MAX_CTO];
    modbus_t modbus;
    uint32_t modbus_key; /* [-] written by the client; 0: none */
    talk_setting_t setting;
    uint32_t busy;       /* [-] 1: octets waited or were sent at the last check */
    uint32_t busy_at;    /* [periods] when octets waited or were sent for the last time */
    uint32_t restart;    /* [-] 1: a reset is ordered; the answer is sent first */
    uint32_t restart_at; /* [periods] */
} talk_t;

/* After reset, before the first interrupt. */
void talk_start(void);

/* Called from the sample interrupt: reads the received octets of the chip's line, and writes those to be
 * sent. */
void talk_exchange(void);

/* From the interrupt of the serial line, which comes before the chip's FIFO of 16 octets is full. */
void talk_receive(void);

/* From the background, after each of its tasks: processes received octets with at most one command, sends
 * octets, and checks the communication time-out of the master. Bounded. */
void talk_step(void);

/* Orders a reset of the controller after a short time, in which an answer can still be sent. A client may
 * have ordered it. */
void talk_restart(void);

#endif
