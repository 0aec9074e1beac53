/* Listens at a TCP port of 127.0.0.1, which only this machine can reach. */
#ifndef HOST_SIM_LAB_LOOPBACK_H
#define HOST_SIM_LAB_LOOPBACK_H

#include <stddef.h>
#include <stdint.h>

/* Returns a non-blocking socket, which the caller closes. With *port = 0 it uses a free port and writes its
 * number to *port. -1: `why` has a line of at most `size` characters with the cause and the remedy. */
int loopback_listen(uint32_t *port, char *why, size_t size);

#endif
