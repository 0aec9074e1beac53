/* The part of an A2L file that describes the protocol: the grammar of its IF_DATA, as far as it is used
 * (A2ML), and IF_DATA XCP itself, which describes the connection to the drive, its commands, and the samples
 * that it can send. Grammar and names are those of ASAM MCD-1 XCP 1.0. */
#ifndef TALK_A2L_XCP_H
#define TALK_A2L_XCP_H

#include <stdint.h>

#include "talk/text.h"
#include "talk/xcp.h"

/* Properties of the connection that the slave does not contain. */
typedef struct {
    uint32_t period;           /* [ns] from sample to sample */
    uint32_t baud;             /* [Bd] of the serial line; 0: no serial line */
    void (*event)(text_t *to); /* name of the event */
} a2l_line_t;

void a2l_xcp_grammar(text_t *text);
void a2l_xcp(const a2l_line_t *line, text_t *text);

/* The memory segment of the parameters: its pages, and the checksum method. */
void a2l_xcp_segment(const xcp_segment_t *segment, text_t *text);

#endif
