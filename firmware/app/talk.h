/* The drive on its line: an XCP slave (firmware/talk/) over the values of the application.
 *
 * The interrupt only copies samples into a queue, and octets out of the chip's FIFOs and into them. All else
 * is the background's: octets in, one command at a time, octets out. A master that has switched the bridge on
 * and then is silent for longer than command_timeout stops the motor. */
#ifndef APP_TALK_H
#define APP_TALK_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/hal.h"
#include "talk/a2l.h"
#include "talk/daq.h"
#include "talk/frame.h"
#include "talk/xcp.h"

/* Where octets come from and go to, one per word, neither of which waits. */
typedef struct {
    uint32_t (*read)(uint16_t *octets, uint32_t room);
    uint32_t (*write)(const uint16_t *octets, uint32_t count);
} talk_line_t;

/* NULL: the chip's serial line, hal_serial_*, whose frames have tails; else one that loses and spoils
 * nothing.
 */
extern HAL_PER_CHIP const talk_line_t *talk_line;

#define TALK_OCTETS 140u /* that have come and wait: two commands of the longest */

/* Octets between interrupt and background: what goes over the line at 1 Mbaud in 600 us. A power of two. */
#define TALK_RING 64u

/* One of the two writes `put` and the octets, the other one `got`. */
typedef struct {
    uint16_t put; /* [octets] modulo 2^16, into it so far */
    uint16_t got; /* [octets] modulo 2^16, taken out so far */
    uint16_t octets[TALK_RING];
} talk_ring_t;

typedef struct {
    frame_receiver_t receiver;
    frame_sender_t sender;
    xcp_t xcp;
    daq_t daq;
    a2l_place_t a2l;      /* where its client reads */
    uint32_t heard_at;    /* [periods] when the last good frame came */
    uint32_t steered;     /* [-] 1: `enable` was switched on over the line, and stands */
    uint32_t silent;      /* [-] 1: the master was silent for too long; until `enable` is set anew */
    uint32_t line_errors; /* [-] of the chip's line, as last seen */
    talk_ring_t came;     /* octets that the interrupt has taken off the chip's line */
    talk_ring_t going;    /* octets that it will put on it */
    uint32_t octets_count, octets_at; /* that have come, and that were taken of them */
    uint32_t answer_count;            /* [octets] of the answer that waits; 0: none */
    uint16_t octets[TALK_OCTETS];
    uint16_t answer[FRAME_MAX_CTO];
    uint32_t restart;    /* [-] 1: ordered; the answer goes first */
    uint32_t restart_at; /* [periods] */
} talk_t;

/* After reset, before the first interrupt. */
void talk_start(void);

/* From the sample interrupt: takes what has come on the chip's line, and puts on it what is to go. Its FIFOs
 * of 16 octets last for 170 us, and the background comes round later where the medium task runs meanwhile. */
void talk_exchange(void);

/* From the background, after each of its tasks: what has come in, at most one command of it; what is to go
 * out; the master's silence. Bounded. */
void talk_step(void);

/* Ordered over the line or not: the controller resets, shortly, so that an answer still goes out. */
void talk_restart(void);

#endif
