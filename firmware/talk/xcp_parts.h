/* What the parts of the slave know of each other: xcp.c, xcp_page.c and xcp_daq.c. */
#ifndef TALK_XCP_PARTS_H
#define TALK_XCP_PARTS_H

#include "talk/xcp.h"

/* One command under way. */
typedef struct {
    xcp_t *xcp;
    daq_t *daq;
    const xcp_access_t *access;
    const uint16_t *command;
    uint32_t count;   /* [octets] of the command */
    uint16_t *answer; /* its first octet says already that all is well, the next ones are 0 */
    uint32_t length;  /* [octets] of the answer, 1 unless changed */
} xcp_call_t;

/* A command: its code, octets that it has at least, and what carries it out: XCP_OK or the error. */
typedef struct {
    uint16_t code;
    uint16_t octets;
    uint32_t (*act)(xcp_call_t *call);
} xcp_row_t;

typedef struct {
    const xcp_row_t *rows;
    uint32_t count;
} xcp_commands_t;

extern const xcp_commands_t xcp_page_commands;
extern const xcp_commands_t xcp_daq_commands;

static inline uint32_t xcp_word(const uint16_t *octets)
{
    return (uint32_t)octets[0] | (uint32_t)octets[1] << 8;
}

static inline uint32_t xcp_long(const uint16_t *octets)
{
    return xcp_word(octets) | xcp_word(&octets[2]) << 16;
}

static inline void xcp_put_word(uint16_t *octets, uint32_t value)
{
    octets[0] = (uint16_t)(value & 0xFFu);
    octets[1] = (uint16_t)(value >> 8 & 0xFFu);
}

static inline void xcp_put_long(uint16_t *octets, uint32_t value)
{
    xcp_put_word(octets, value);
    xcp_put_word(&octets[2], value >> 16);
}

#endif
