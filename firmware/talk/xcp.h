/* The XCP slave (ASAM MCD-1 XCP 1.x): one command, one answer. Intel byte order, BYTE granularity, no block
 * mode; pages of one calibration segment, dynamic data acquisition.
 *
 * With a key the resource CAL/PAG is locked from CONNECT on: DOWNLOAD, and SET_CAL_PAGE for the drive, are
 * refused until the master has answered the seed of GET_SEED by UNLOCK (contract/line.h). A wrong answer ends
 * the session, as the standard requires. Reading and data acquisition are never locked.
 *
 * The sum after a frame of a serial line does not detect two wrong bits of equal weight. On such a line a
 * SET_MTA to a writable address, and a DOWNLOAD, are therefore executed only after they have been
 * received twice in succession and equal; the first one is answered with ERR_CMD_BUSY, after which the
 * standard requires a master to repeat the command. A DOWNLOAD whose slots all have codes of their own
 * (contract/line.h) is executed at once.
 *
 * The slave does not know the data at its addresses: xcp_access_t gives access to them and to the clock. */
#ifndef TALK_XCP_H
#define TALK_XCP_H

#include <stdbool.h>
#include <stdint.h>

#include "talk/daq.h"
#include "talk/frame.h"

/* Errors, by the standard's numbers. */
#define XCP_OK                0x100u /* not part of a packet: success */
#define XCP_CMD_SYNCH         0x00u
#define XCP_CMD_BUSY          0x10u
#define XCP_DAQ_ACTIVE        0x11u
#define XCP_CMD_UNKNOWN       0x20u
#define XCP_CMD_SYNTAX        0x21u
#define XCP_OUT_OF_RANGE      0x22u
#define XCP_WRITE_PROTECTED   0x23u
#define XCP_ACCESS_LOCKED     0x25u
#define XCP_PAGE_NOT_VALID    0x26u
#define XCP_MODE_NOT_VALID    0x27u
#define XCP_SEGMENT_NOT_VALID 0x28u
#define XCP_SEQUENCE          0x29u
#define XCP_DAQ_CONFIG        0x2Au
#define XCP_MEMORY_OVERFLOW   0x30u

#define XCP_VERSION 1u /* of protocol and transport layer */

/* Pages of the one segment. */
#define XCP_PAGE_ACTIVE 0u /* the set with which the drive runs; read only */
#define XCP_PAGE_STAGED 1u /* written value by value; setting page 0 for the drive takes it over */

#define XCP_CHECKSUM_MAX 4096u /* [octets] largest block of a checksum: one pass of the background */

#define XCP_EXTENSION_NONE UINT32_C(0xFF) /* the memory transfer address is not set */

/* Texts that GET_ID returns, by their address extension, from address 0 on. */
#define XCP_EXTENSION_A2L   UINT32_C(5)
#define XCP_EXTENSION_EPK   UINT32_C(6)
#define XCP_EXTENSION_EVENT UINT32_C(8)

/* The calibration segment: its first address and its length in octets. */
typedef struct {
    uint32_t extension, address, length;
} xcp_segment_t;

/* The functions through which the slave has access. Each returns XCP_OK or an error. */
typedef struct {
    uint32_t (*read)(uint32_t extension, uint32_t address, uint32_t count, uint16_t *octets);
    /* Writes whole slots, all of them or none. */
    uint32_t (*write)(uint32_t extension, uint32_t address, uint32_t count, const uint32_t *slots);
    bool (*writable)(uint32_t extension);
    /* True if all these slots have codes that detect a wrong one. */
    bool (*coded)(uint32_t extension, uint32_t address, uint32_t count, const uint32_t *slots);
    /* True if writing this slot does nothing but stop the motor: a locked drive takes it. */
    bool (*stops)(uint32_t extension, uint32_t address, uint32_t slot);
    /* Offset, for the copy in the interrupt, of a slot that can be measured. */
    uint32_t (*measurable)(uint32_t extension, uint32_t address, uint32_t *offset);
    uint32_t (*text_length)(uint32_t extension); /* [octets] of such a text */
    xcp_segment_t (*segment)(void);
    uint32_t (*apply)(void); /* the staged set becomes the active one */
    bool (*applied)(void);   /* true: both sets are equal */
    uint32_t (*clock)(void); /* [periods] */
    uint32_t (*key)(void);   /* [-] of the resource CAL/PAG; 0: it is open */
    uint32_t period;         /* [ns] from sample to sample */
} xcp_access_t;

typedef struct {
    uint32_t connected;                    /* [-] 1 */
    uint32_t serial;                       /* [-] 1: the line may change bits */
    uint32_t once;                         /* [-] 1: a command has been received once */
    uint32_t once_check;                   /* [-] CRC of that command */
    uint32_t extension;                    /* of the memory transfer address */
    uint32_t address;                      /* [octets] */
    uint32_t locked;                       /* [-] 1: nothing may be written but a stop */
    uint32_t seeded;                       /* [-] 1: `seed` waits for its answer */
    uint32_t seed;                         /* [-] the last one */
    uint32_t page;                         /* [-] page that the client reads and writes: XCP_PAGE_... */
    uint32_t daq_list, daq_odt, daq_entry; /* the next place of WRITE_DAQ */
} xcp_t;

/* Sets the state without a connected client. serial: 1 for a line that may change bits. */
void xcp_init(xcp_t *xcp, uint32_t serial);

/* Executes the command. Writes the octets of the answer, one per word, into `answer` (space for
 * FRAME_MAX_CTO) and returns their number; 0: no answer, because no client is connected. */
uint32_t xcp_command(xcp_t *xcp, daq_t *daq, const xcp_access_t *access, frame_packet_t command,
                     uint16_t *answer);

/* Writes the packet that reports lost samples. */
uint32_t xcp_overload(uint16_t *octets);

#endif
