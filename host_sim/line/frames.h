/* Frames of XCP on TCP and on a serial line: length (16 bits, low octet first), counter (16 bits), packet; on
 * a serial line an octet 0 behind a packet of an odd length, and the sum of all words so far (16 bits).
 *
 * On a serial line octets may be lost or changed. A frame with a wrong sum is invalid. A frame with a right
 * sum is accepted if its counter is the expected one. With another counter it is accepted only if the next
 * frame follows it, or nothing follows. Other octets are dropped one by one until a frame begins, so that the
 * receiver also finds the frames in an uninterrupted stream of samples. */
#ifndef HOST_SIM_LINE_FRAMES_H
#define HOST_SIM_LINE_FRAMES_H

#include <stdbool.h>
#include <stdint.h>

#define FRAMES_HEADER  4u
#define FRAMES_PACKET  128u  /* [octets] the longest packet of the drive */
#define FRAMES_TAIL    3u    /* [octets] at most, on a serial line */
#define FRAMES_ROOM    8192u /* [octets] buffer for received octets */
#define FRAMES_SILENCE 0.05  /* [s] silence that ends an incomplete frame; USB adapters send every 16 ms */

typedef struct {
    bool lossless;
    bool broken;      /* an invalid frame on a lossless line: the other end uses another protocol */
    bool counted;     /* `counter` is valid */
    uint16_t counter; /* of the next frame */
    uint32_t begin, end;
    double last;      /* [s] time of the last octets */
    uint32_t missing; /* [-] missing frames, by the counter */
    uint32_t dropped; /* [octets] */
    uint8_t octets[FRAMES_ROOM];
} frames_t;

void frames_init(frames_t *frames, bool lossless);

/* Makes a frame of a packet. `to` has room for FRAMES_HEADER + count + FRAMES_TAIL octets. Returns the length
 * of the frame. */
uint32_t frames_make(uint8_t *to, bool lossless, uint16_t counter, const uint8_t *packet, uint32_t count);

/* The place for received octets, and its size `room`. */
uint8_t *frames_room(frames_t *frames, uint32_t *room);
void frames_received(frames_t *frames, uint32_t count, double now);

/* The next packet, valid until frames_room is called; NULL: there is none yet. */
const uint8_t *frames_next(frames_t *frames, double now, uint32_t *length);

/* [s] time until an incomplete frame is dropped because of silence; a large number if there is none. */
double frames_patience(const frames_t *frames, double now);

#endif
