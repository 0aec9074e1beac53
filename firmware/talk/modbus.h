/* A Modbus RTU server (MODBUS over Serial Line 1.02, MODBUS Application Protocol 1.1b3), pure: octets in, at
 * most one answer out, one octet per word. It stores the octets of a request and of an answer in memory of
 * the caller, so that the drive uses one buffer for both of its protocols.
 *
 * A frame is address, function, data and CRC-16, and ends with a silence of 3.5 characters. A frame with a
 * wrong CRC, fewer octets than the shortest or more than the longest one, or octets that the line has lost,
 * is dropped and counted; it gets no answer. A frame for another address is dropped and not counted. Address
 * 0 is a broadcast: it can only write, and gets no answer.
 *
 * The CRC (polynomial x^16 + x^15 + x^2 + 1) detects every error of one, two or three bits in a frame, and
 * every burst of up to 16. A write therefore needs neither the repetition nor the codes that the sum of XCP
 * makes necessary.
 *
 * Registers: every row of the drive's tables is a slot of 32 bits at registers 2 x id, the upper half, and
 * 2 x id + 1. The server does not know the rows: modbus_access_t gives access to them. */
#ifndef TALK_MODBUS_H
#define TALK_MODBUS_H

#include <stdbool.h>
#include <stdint.h>

/* Functions. The first two have the same registers. */
#define MODBUS_READ_HOLDING   0x03u
#define MODBUS_READ_INPUT     0x04u
#define MODBUS_WRITE_SINGLE   0x06u
#define MODBUS_WRITE_MULTIPLE 0x10u

/* Results, by the standard's numbers of exceptions. */
#define MODBUS_OK               0u
#define MODBUS_ILLEGAL_FUNCTION 1u /* no such function, or a drive that is locked */
#define MODBUS_ILLEGAL_ADDRESS  2u /* no such register, or one that cannot be written */
#define MODBUS_ILLEGAL_VALUE    3u /* out of the row's range, or a request of a wrong length */
#define MODBUS_FAILURE          4u /* the drive refuses it in its present state */

#define MODBUS_ADDRESS_MAX  247u
#define MODBUS_BROADCAST    0u
#define MODBUS_FRAME_MAX    256u /* [octets] of any frame */
#define MODBUS_READ_MOST    62u  /* [registers] in one request */
#define MODBUS_WRITE_MOST   30u  /* [registers] */
#define MODBUS_STORE_OCTETS 70u  /* [octets] that the memory for a request must hold */
#define MODBUS_ANSWER_MAX   129u /* [octets] that the memory for an answer must hold */

/* The functions through which the server has access to rows. Each returns MODBUS_OK or an exception. */
typedef struct {
    uint32_t (*read)(uint32_t id, uint32_t *slot);
    /* Writes the slots of `count` successive ids, all of them or none. */
    uint32_t (*write)(uint32_t id, uint32_t count, const uint32_t *slots);
    /* True if a single register with this signed value represents the row: it is no float. */
    bool (*whole)(uint32_t id);
} modbus_access_t;

typedef struct {
    uint32_t address;  /* 1..MODBUS_ADDRESS_MAX */
    uint32_t gap;      /* [periods] silence that ends a frame */
    uint32_t count;    /* [octets] of the present frame, also those that are not stored */
    uint32_t crc;      /* of them; 0 over a whole good frame */
    uint32_t spoilt;   /* [-] 1: octets of the present frame are lost */
    uint32_t heard_at; /* [periods] time of the last octet */
    uint32_t frames;   /* [-] good requests to this drive so far */
    uint32_t errors;   /* [-] dropped frames so far */
} modbus_t;

/* Sets the initial state, but keeps the two counts. */
void modbus_set(modbus_t *modbus, uint32_t address, uint32_t gap);

/* The next octet; only the lower eight bits of the word are used. */
void modbus_take(modbus_t *modbus, uint16_t *store, uint16_t octet, uint32_t now);

/* The line has lost octets before this time: the present frame is dropped at its end. */
void modbus_broken(modbus_t *modbus, uint32_t now);

typedef struct {
    bool heard;     /* a good request to this drive, with answer or without */
    uint32_t count; /* [octets] of the answer; 0: none */
} modbus_result_t;
/* Ends the present frame if the silence has lasted long enough; call it after all octets that have come were
 * taken. Executes a good request to this drive, and writes its answer into `answer`. */
modbus_result_t modbus_listen(modbus_t *modbus, const uint16_t *store, const modbus_access_t *access,
                              uint32_t now, uint16_t *answer);

/* Silence [s] that ends a frame at this rate [bit/s]: 3.5 characters of 11 bits, and 1.75 ms above 19200. */
float modbus_gap(float baud);

#endif
