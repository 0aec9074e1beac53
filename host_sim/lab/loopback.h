/* Listening at a TCP port of this machine alone, 127.0.0.1. */
#ifndef HOST_SIM_LAB_LOOPBACK_H
#define HOST_SIM_LAB_LOOPBACK_H

#include <stddef.h>
#include <stdint.h>

/* A socket that does not block; *port 0: any that is free, and which it became. -1: `why`, a line of no more
 * than `size` characters that says what and what to do. The caller closes it. */
int loopback_listen(uint32_t *port, char *why, size_t size);

#endif
