/* Reads the capture buffer of the drive for a page, piece by piece between other questions, so that a stop
 * does not have to wait. */
#ifndef HOST_SIM_SCOPE_SCOPE_CAPTURE_H
#define HOST_SIM_SCOPE_SCOPE_CAPTURE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/line/master.h"

typedef struct {
    master_capture_t of;
    uint8_t *octets;       /* slots of the buffer as in the drive; NULL: no buffer is being read */
    uint32_t wanted, done; /* [octets] */
    bool asking;           /* a piece has been requested */
    int result;            /* of the last one */
} scope_capture_t;

/* Begins to read a stopped buffer. false: there is none, or it is being read already. */
bool scope_capture_begin(scope_capture_t *capture, master_t *master, master_error_t *error);

/* Requests the next piece, if one is missing and none is pending. */
void scope_capture_ask(scope_capture_t *capture, master_t *master);

/* After the end or an error: the text for the page, once; ends the reading. */
bool scope_capture_is_over(const scope_capture_t *capture);
void scope_capture_text(FILE *to, scope_capture_t *capture, master_t *master);
void scope_capture_end(scope_capture_t *capture);

#endif
