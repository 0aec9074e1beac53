/* The drive's own buffer, brought to a page: piece by piece between other questions, so that a stop does not
 * wait for the whole. */
#ifndef HOST_SIM_SCOPE_SCOPE_CAPTURE_H
#define HOST_SIM_SCOPE_SCOPE_CAPTURE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/line/master.h"

typedef struct {
    master_capture_t of;
    uint8_t *octets;       /* of its slots, as the drive has them; NULL: none is read */
    uint32_t wanted, done; /* [octets] */
    bool asking;           /* a piece is under way */
    int result;            /* of the last one */
} scope_capture_t;

/* What is held is read from its beginning. false: nothing is held, or one is being read already. */
bool scope_capture_begin(scope_capture_t *capture, master_t *master, master_error_t *error);

/* The next piece, if one is missing and none is under way. */
void scope_capture_ask(scope_capture_t *capture, master_t *master);

/* Complete, or failed: the text that a page gets once, and the end of the reading. */
bool scope_capture_is_over(const scope_capture_t *capture);
void scope_capture_text(FILE *to, scope_capture_t *capture, master_t *master);
void scope_capture_end(scope_capture_t *capture);

#endif
