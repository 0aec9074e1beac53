/* Frames: packets on a stream of octets, one octet per word. LEN, the octets of the packet, and CTR, which
 * counts frames, are 16 bits each, the lower octet first; then comes the packet. That is XCP on TCP.
 *
 * XCP on a serial line (SxI, HEADER_LEN_CTR_WORD, CHECKSUM_WORD) has a tail: an octet 0 where the packet has
 * an odd number of them, and the sum of all words so far, 16 bits, the lower octet first. There a frame is
 * judged: its sum must agree and its CTR must be the one after that of the frame before. A frame out of
 * sequence is dropped and counted, so that no command acts whose predecessor was lost; CONNECT and SYNCH,
 * which act on nothing, are taken with any CTR, and the count goes on from theirs.
 *
 * A stream may lose octets. A length of zero or above FRAME_MAX_CTO, a wrong sum, or a frame that is not
 * complete `silence` after its last octet, is dropped and counted; then all octets are dropped until that
 * much silence. */
#ifndef TALK_FRAME_H
#define TALK_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#define FRAME_HEADER  4u
#define FRAME_MAX_CTO 64u  /* [octets] of a packet that comes, and of its answer */
#define FRAME_MAX_DTO 128u /* [octets] of a packet of samples */
#define FRAME_TAIL    2u   /* [octets] behind the longest packets, which have even numbers of octets */

typedef struct {
    uint32_t silence;  /* [periods] */
    uint32_t tail;     /* [-] 1: frames have a tail, and are judged; holds from the next frame on */
    uint32_t counted;  /* [-] 1: `counter` is known */
    uint32_t counter;  /* [-] of the next frame, 16 bits */
    uint32_t count;    /* [octets] of the frame under way */
    uint32_t dropping; /* [-] 1: until a silence */
    uint32_t heard_at; /* [periods] when the last octet came */
    uint32_t frames;   /* [-] good ones so far */
    uint32_t errors;   /* [-] dropped ones so far */
    uint16_t octets[FRAME_HEADER + FRAME_MAX_CTO + FRAME_TAIL];
} frame_receiver_t;

void frame_receiver_init(frame_receiver_t *receiver, uint32_t silence);

/* Whether an octet comes or not: what a silence ends at this time [periods]. */
void frame_listen(frame_receiver_t *receiver, uint32_t now);

/* The octet that came at this time; of a word only its lower eight bits count. true: a frame is complete.
 * frame_packet() tells what is in it, until the next octet. */
bool frame_take(frame_receiver_t *receiver, uint16_t octet, uint32_t now);

typedef struct {
    const uint16_t *octets;
    uint32_t count; /* [octets] 1..FRAME_MAX_CTO */
} frame_packet_t;

frame_packet_t frame_packet(const frame_receiver_t *receiver);

/* The line itself has lost something before this time: the frame under way is dropped, and what follows. */
void frame_broken(frame_receiver_t *receiver, uint32_t now);

/* Nobody has listened until now: what was no silence does not count as one. */
static inline void frame_wait(frame_receiver_t *receiver, uint32_t now)
{
    receiver->heard_at = now;
}

typedef struct {
    uint32_t tail;    /* [-] 1: frames have a tail */
    uint32_t counter; /* [-] of the next frame, 16 bits */
    uint32_t count;   /* [octets] of the frame under way; 0: none */
    uint32_t sent;    /* [octets] of it */
    uint16_t octets[FRAME_HEADER + FRAME_MAX_DTO + FRAME_TAIL];
} frame_sender_t;

void frame_sender_init(frame_sender_t *sender);

/* Is the next packet welcome? */
static inline bool frame_is_free(const frame_sender_t *sender)
{
    return sender->sent == sender->count;
}

/* Where the next packet is to be written, up to FRAME_MAX_DTO octets; only while frame_is_free(). Then
 * frame_close() makes a frame of its first `count`, 1 at least. */
static inline uint16_t *frame_open(frame_sender_t *sender)
{
    return &sender->octets[FRAME_HEADER];
}
void frame_close(frame_sender_t *sender, uint32_t count);

#endif
