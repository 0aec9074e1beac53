/* Declarations shared by the parts of the slave: xcp.c, xcp_page.c and xcp_daq.c. */
#ifndef TALK_XCP_PARTS_H
#define TALK_XCP_PARTS_H

#include "talk/xcp.h"

/* The command that is being executed. */
typedef struct {
    xcp_t *xcp;
    daq_t *daq;
    const xcp_access_t *access;
    const uint16_t *command;
    uint32_t count;   /* [octets] of the command */
    uint16_t *answer; /* its first octet is preset to success, the next ones to 0 */
    uint32_t length;  /* [octets] of the answer, 1 unless changed */
} xcp_call_t;

/* A command: its code, its least number of octets, its name in the standard if it is optional, else NULL, and
 * the function that executes it and returns XCP_OK or the error. */
typedef struct {
    uint16_t code;
    uint16_t octets;
    const char *optional;
    uint32_t (*act)(xcp_call_t *call);
} xcp_row_t;

typedef struct {
    const xcp_row_t *rows;
    uint32_t count;
} xcp_commands_t;

extern const xcp_commands_t xcp_page_commands;
extern const xcp_commands_t xcp_daq_commands;

/* All commands, part by part. */
#define XCP_COMMAND_PARTS 3u
const xcp_commands_t *xcp_commands(uint32_t part);

/* ---- data acquisition, for the commands and the description ---- */

#define XCP_EVENTS         1u
#define XCP_EVENT_CHANNEL  0u
#define XCP_EVENT_PRIORITY 0xFFu

/* A time in the form of the standard: a multiple of a unit; unit 0 is 1 ns, and each next
 * one is ten times the one before. */
typedef struct {
    uint32_t count;
    uint32_t unit; /* [-] below XCP_UNITS */
} xcp_span_t;
#define XCP_UNITS 10u

xcp_span_t xcp_span(uint32_t nanoseconds);
xcp_span_t xcp_span_rough(xcp_span_t span); /* the same in one octet, rounded if necessary */
const char *xcp_unit(uint32_t unit);        /* its name in a description */

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
