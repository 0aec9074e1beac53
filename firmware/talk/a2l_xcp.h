/* What an A2L file says of the protocol: the grammar of its IF_DATA, as far as that is used (A2ML), and
 * IF_DATA XCP itself, from which a tool knows how to reach the drive, what its commands are, and what it can
 * sample. Grammar and names are those of ASAM MCD-1 XCP 1.0. */
#ifndef TALK_A2L_XCP_H
#define TALK_A2L_XCP_H

#include <stdint.h>

#include "talk/text.h"
#include "talk/xcp.h"

/* What the slave itself does not know of its line. */
typedef struct {
    uint32_t period;           /* [ns] from sample to sample */
    uint32_t baud;             /* [Bd] of the serial line; 0: there is none */
    void (*event)(text_t *to); /* name of the event */
} a2l_line_t;

void a2l_xcp_grammar(text_t *text);
void a2l_xcp(const a2l_line_t *line, text_t *text);

/* The memory segment of the parameters: its pages, and how a checksum over it is built. */
void a2l_xcp_segment(const xcp_segment_t *segment, text_t *text);

#endif
