/* Frames of XCP on TCP and on a serial line: length (16 bits, low octet first), counter (16 bits), packet; on
 * a serial line an octet 0 behind a packet of an odd length, and the sum of all words so far (16 bits).
 *
 * Over a serial line octets may be lost or spoilt. A frame whose sum is wrong is none. One whose sum is right
 * is taken if its counter is the one expected; else only if what follows it looks like the frame after it, or
 * nothing follows. What is no frame is dropped octet by octet until there is one again, so that samples that
 * never cease are found again too. */
#ifndef HOST_SIM_LINE_FRAMES_H
#define HOST_SIM_LINE_FRAMES_H

#include <stdbool.h>
#include <stdint.h>

#define FRAMES_HEADER 4u
#define FRAMES_PACKET 128u  /* [octets] the longest packet of the drive */
#define FRAMES_TAIL   3u    /* [octets] at most, on a serial line */
#define FRAMES_ROOM   8192u /* [octets] received and not yet taken */
#define FRAMES_SILENCE                                                                                       \
    0.05 /* [s] without an octet that end a half frame; USB adapters deliver every 16 ms                     \
          */

typedef struct {
    bool lossless;
    bool broken;      /* lossless, and yet no frame: the other end speaks something else */
    bool counted;     /* `counter` holds */
    uint16_t counter; /* of the next frame */
    uint32_t begin, end;
    double last;      /* [s] when the last octets came */
    uint32_t missing; /* [-] frames, by the counter */
    uint32_t dropped; /* [octets] */
    uint8_t octets[FRAMES_ROOM];
} frames_t;

void frames_init(frames_t *frames, bool lossless);

/* Puts header and tail around a packet, into room for FRAMES_HEADER + count + FRAMES_TAIL octets. Returns how
 * many there are. */
uint32_t frames_make(uint8_t *to, bool lossless, uint16_t counter, const uint8_t *packet, uint32_t count);

/* Where received octets go, and how many may. */
uint8_t *frames_room(frames_t *frames, uint32_t *room);
void frames_received(frames_t *frames, uint32_t count, double now);

/* The next packet, valid until frames_room is called; NULL: there is none yet. */
const uint8_t *frames_next(frames_t *frames, double now, uint32_t *length);

/* [s] until silence decides about what is there; a large number: it need not. */
double frames_patience(const frames_t *frames, double now);

#endif
