/* Frames: packets on a stream of octets, one octet per word. LEN, the octets of the packet,
 * and CTR, which counts frames, are 16 bits each, the lower octet first; the packet follows.
 * This is the format of XCP on TCP.
 *
 * XCP on a serial line (SxI, HEADER_LEN_CTR_WORD, CHECKSUM_WORD) has a tail: an octet 0 if the packet has an
 * odd number of octets, and the sum of all words so far, 16 bits, the lower octet first. With a tail a frame
 * is checked: its sum must agree and its CTR must follow that of the frame before. A frame out of sequence is
 * dropped and counted, so that no command is executed whose predecessor was lost; CONNECT and SYNCH, which
 * change nothing, are accepted with any CTR, and the count continues from theirs.
 *
 * A stream may lose octets. A length of zero or above FRAME_MAX_CTO, a wrong sum, or a frame that is not
 * complete `silence` after its last octet, is dropped and counted; then all octets are dropped until the line
 * has been silent for that time. */
#ifndef TALK_FRAME_H
#define TALK_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#define FRAME_HEADER  4u
#define FRAME_MAX_CTO 64u  /* [octets] of a received packet, and of its answer */
#define FRAME_MAX_DTO 128u /* [octets] of a packet of samples */
#define FRAME_TAIL    2u   /* [octets] after the longest packets, whose length is even */

typedef struct {
    uint32_t silence;  /* [periods] */
    uint32_t tail;     /* [-] 1: frames have a tail, and are checked; acts from the next frame on */
    uint32_t counted;  /* [-] 1: `counter` is known */
    uint32_t counter;  /* [-] of the next frame, 16 bits */
    uint32_t count;    /* [octets] of the present frame */
    uint32_t dropping; /* [-] 1: octets are dropped until a silence */
    uint32_t heard_at; /* [periods] time of the last octet */
    uint32_t frames;   /* [-] good ones so far */
    uint32_t errors;   /* [-] dropped ones so far */
    uint16_t octets[FRAME_HEADER + FRAME_MAX_CTO + FRAME_TAIL];
} frame_receiver_t;

void frame_receiver_init(frame_receiver_t *receiver, uint32_t silence);

/* Call it after octets of another protocol: a frame begins with the next octet. On a line with a tail it
 * must be a CONNECT or a SYNCH, with any CTR. The counts of frames are kept. */
void frame_restart(frame_receiver_t *receiver);

/* Call in every pass, also without an octet: ends the present frame if the silence has lasted long
 * enough at this time [periods]. */
void frame_listen(frame_receiver_t *receiver, uint32_t now);

/* Processes the octet that arrived at this time; only the lower eight bits of the word are used. true: a
 * frame is complete, and frame_packet() returns its packet until the next octet. */
bool frame_take(frame_receiver_t *receiver, uint16_t octet, uint32_t now);

typedef struct {
    const uint16_t *octets;
    uint32_t count; /* [octets] 1..FRAME_MAX_CTO */
} frame_packet_t;

frame_packet_t frame_packet(const frame_receiver_t *receiver);

/* The line itself has lost octets before this time: the present frame and
 * the following octets are dropped. */
void frame_broken(frame_receiver_t *receiver, uint32_t now);

/* The line was not read until now: the time before does not count as silence. */
static inline void frame_wait(frame_receiver_t *receiver, uint32_t now)
{
    receiver->heard_at = now;
}

typedef struct {
    uint32_t tail;    /* [-] 1: frames have a tail */
    uint32_t counter; /* [-] of the next frame, 16 bits */
    uint32_t count;   /* [octets] of the present frame; 0: none */
    uint32_t sent;    /* [octets] of it */
    uint16_t octets[FRAME_HEADER + FRAME_MAX_DTO + FRAME_TAIL];
} frame_sender_t;

void frame_sender_init(frame_sender_t *sender);

/* True if the next packet can be accepted. */
static inline bool frame_is_free(const frame_sender_t *sender)
{
    return sender->sent == sender->count;
}

/* The memory for the next packet, up to FRAME_MAX_DTO octets; only while frame_is_free(). Then frame_close()
 * makes a frame of its first `count` octets, at least 1. */
static inline uint16_t *frame_open(frame_sender_t *sender)
{
    return &sender->octets[FRAME_HEADER];
}
void frame_close(frame_sender_t *sender, uint32_t count);

#endif
