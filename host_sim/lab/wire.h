/* The far end of the drive's serial line on the desk: a TCP port of this machine alone (127.0.0.1), or a
 * pseudo terminal. One client at a time: who comes second over TCP is accepted and closed at once, so that it
 * sees an end and no silence.
 *
 * Over TCP only whole frames of XCP are handed on. A client whose octets are no frame, a web page's request
 * for instance, is closed, and nothing of what it sent from there on is heard.
 *
 * A client that leaves the port without a word has ended its session: for it the line falls silent, and then
 * a DISCONNECT is said, whose answer nobody gets, before the next client is heard. Otherwise the next one
 * would find measurements running that it never started.
 *
 * Nothing here knows the rig; all calls from one thread. */
#ifndef HOST_SIM_LAB_WIRE_H
#define HOST_SIM_LAB_WIRE_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct wire wire_t;

typedef struct {
    char text[256]; /* one line: what, why, what to do */
} wire_error_t;

/* Listens at this port; 0: any that is free. `wait`: wire_write waits for a client that is slow to read,
 * until *stop is not 0; otherwise it takes only what there is room for. NULL: `error`. */
wire_t *wire_listen(uint32_t port, bool wait, const volatile sig_atomic_t *stop, wire_error_t *error);

/* Makes a pseudo terminal, raw: whatever is written on one side comes out on the other as it is. Octets that
 * nobody fetches are lost, as on a wire. NULL: `error`. */
wire_t *wire_terminal(wire_error_t *error);

void wire_close(wire_t *wire); /* NULL: nothing */

/* "127.0.0.1:5555" or "/dev/pts/3". */
const char *wire_name(const wire_t *wire);

/* Is anybody there; of a terminal nobody knows. */
bool wire_has_client(const wire_t *wire);

/* Who comes, who goes, what was written goes out: to be called each millisecond of simulated time, or about
 * that. */
void wire_poll(wire_t *wire);

/* As rig_line_t wants them; `context` is the wire. */
uint32_t wire_read(void *context, uint8_t *octets, uint32_t room);
uint32_t wire_write(void *context, const uint8_t *octets, uint32_t count);

#endif
