/* The client side of the drive's serial line in the simulation: a TCP port of this machine (127.0.0.1), or a
 * pseudo terminal. One client at a time: a second TCP client is accepted and closed at once, so that it gets
 * an end of the connection instead of waiting.
 *
 * Over TCP only complete XCP frames are passed to the drive. A client that sends something else, such as a
 * web page's request, is closed, and its further octets are ignored.
 *
 * A client may close the connection without DISCONNECT. Its session then ends as follows: the line is silent
 * for a time, then the wire sends a DISCONNECT and drops the answer. Only then the next client is served.
 * Otherwise measurements of the previous client would still run.
 *
 * The module is independent of the rig. All calls must come from one thread. */
#ifndef HOST_SIM_LAB_WIRE_H
#define HOST_SIM_LAB_WIRE_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct wire wire_t;

typedef struct {
    char text[256]; /* one line: what happened, why, what to do */
} wire_error_t;

/* Listens at this port; 0: any free port. `wait`: wire_write waits for a client that reads slowly, until
 * *stop is not 0; otherwise it accepts only as many octets as there is room for. NULL: `error` has the
 * message. */
wire_t *wire_listen(uint32_t port, bool wait, const volatile sig_atomic_t *stop, wire_error_t *error);

/* Makes a pseudo terminal in raw mode: octets pass unchanged. Octets that no client reads are lost, as on a
 * wire. NULL: `error` has the message. */
wire_t *wire_terminal(wire_error_t *error);

void wire_close(wire_t *wire); /* may be NULL */

/* "127.0.0.1:5555" or "/dev/pts/3". */
const char *wire_name(const wire_t *wire);

/* true: a client is connected. For a terminal this is unknown. */
bool wire_has_client(const wire_t *wire);

#define WIRE_CLIENT_SIZE 64 /* [octets] of an address with its closing 0 */

/* Address of the client at a TCP port, "127.0.0.1:54321"; "?" if it has closed. Returns `to`. */
const char *wire_client(const wire_t *wire, char to[WIRE_CLIENT_SIZE]);

/* Handles new and closed connections, and sends written octets. Call it about once per millisecond of
 * simulated time. */
void wire_poll(wire_t *wire);

/* The functions of a rig_line_t; `context` is the wire. */
uint32_t wire_read(void *context, uint8_t *octets, uint32_t room);
uint32_t wire_write(void *context, const uint8_t *octets, uint32_t count);

#endif
