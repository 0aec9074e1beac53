#include "host_sim/lab/wire.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "host_sim/lab/loopback.h"

#define WAITING_OUT                                                                                          \
    524288u /* [octets] written and not sent yet: 0.8 s of twelve floats a period, for a busy client */
#define WAITING_IN   4096u /* [octets] received and not read yet */
#define KERNEL_OUT   65536 /* [octets] buffer of the kernel: its content delays the octets that follow */
#define SILENCE      7u    /* [calls of wire_poll] longer than the drive waits within a frame */
#define STOP_LOOK_MS 100   /* [ms] of waiting, then *stop is checked */
#define STALE        2000u /* [calls of wire_poll] of a terminal that accepts nothing, until it counts as unused */

#define HEADER      4u  /* [octets] of a frame */
#define COMMAND_MAX 64u /* [octets] of a packet to the drive: MAX_CTO, docs/serial.md */

/* LEN 1, CTR 0, DISCONNECT */
static const uint8_t goodbye[] = {1u, 0u, 0u, 0u, 0xfeu};

struct wire {
    int listener; /* -1: a terminal */
    int client;   /* -1: no client; of a terminal its master side */
    int keep; /* the other side of a terminal, kept open so that clients may open and close it; -1: none */
    bool wait;
    const volatile sig_atomic_t *stop;
    uint32_t leaving; /* [calls of wire_poll] until the next client is served */
    uint32_t stuck;   /* [calls of wire_poll] without progress although octets wait for the terminal */
    char name[64];
    uint32_t out_count, in_count, in_at; /* [octets] */
    uint32_t in_whole;                   /* [octets] of `in` that are whole frames, or come over a terminal */
    uint8_t out[WAITING_OUT];
    uint8_t in[WAITING_IN];
};

/* ---- opening ---- */

static wire_t *fail(wire_t *wire, wire_error_t *error, const char *what)
{
    snprintf(error->text, sizeof error->text, "%s: %s", what, strerror(errno));
    wire_close(wire);
    return NULL;
}

static wire_t *make(wire_error_t *error)
{
    wire_t *wire = calloc(1, sizeof *wire);
    if (wire == NULL) {
        return fail(NULL, error, "the line");
    }
    wire->listener = -1;
    wire->client = -1;
    wire->keep = -1;
    return wire;
}

wire_t *wire_listen(uint32_t port, bool wait, const volatile sig_atomic_t *stop, wire_error_t *error)
{
    wire_t *wire = make(error);
    if (wire == NULL) {
        return NULL;
    }
    wire->wait = wait;
    wire->stop = stop;
    wire->listener = loopback_listen(&port, error->text, sizeof error->text);
    if (wire->listener < 0) {
        wire_close(wire);
        return NULL;
    }
    snprintf(wire->name, sizeof wire->name, "127.0.0.1:%u", (unsigned)port);
    return wire;
}

wire_t *wire_terminal(wire_error_t *error)
{
    struct termios how;
    wire_t *wire = make(error);
    if (wire == NULL) {
        return NULL;
    }
    wire->client = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (wire->client < 0 || grantpt(wire->client) != 0 || unlockpt(wire->client) != 0 ||
        ptsname_r(wire->client, wire->name, sizeof wire->name) != 0) {
        return fail(wire, error, "pseudo terminal");
    }
    wire->keep = open(wire->name, O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (wire->keep < 0 || tcgetattr(wire->keep, &how) != 0) {
        return fail(wire, error, wire->name);
    }
    cfmakeraw(&how);
    if (tcsetattr(wire->keep, TCSANOW, &how) != 0 || fcntl(wire->client, F_SETFL, O_NONBLOCK) != 0) {
        return fail(wire, error, wire->name);
    }
    return wire;
}

static void close_if(int file)
{
    if (file >= 0) {
        close(file);
    }
}

void wire_close(wire_t *wire)
{
    if (wire != NULL) {
        close_if(wire->listener);
        close_if(wire->client);
        close_if(wire->keep);
        free(wire);
    }
}

const char *wire_name(const wire_t *wire)
{
    return wire->name;
}

bool wire_has_client(const wire_t *wire)
{
    return wire->client >= 0;
}

const char *wire_client(const wire_t *wire, char to[WIRE_CLIENT_SIZE])
{
    struct sockaddr_in place;
    socklen_t size = sizeof place;
    char host[INET_ADDRSTRLEN];
    if (getpeername(wire->client, (struct sockaddr *)&place, &size) == 0 && place.sin_family == AF_INET &&
        inet_ntop(AF_INET, &place.sin_addr, host, sizeof host) != NULL) {
        snprintf(to, WIRE_CLIENT_SIZE, "%s:%u", host, (unsigned)ntohs(place.sin_port));
    } else {
        snprintf(to, WIRE_CLIENT_SIZE, "?");
    }
    return to;
}

/* ---- clients ---- */

static bool is_terminal(const wire_t *wire)
{
    return wire->listener < 0;
}

static void lose_client(wire_t *wire)
{
    if (!is_terminal(wire)) {
        close(wire->client);
        wire->client = -1;
        wire->leaving = 2u * SILENCE;
    }
    wire->out_count = 0u;
    wire->in_count = 0u;
    wire->in_at = 0u;
    wire->in_whole = 0u;
}

static void take_client(wire_t *wire, int client)
{
    const int yes = 1;
    const int room = KERNEL_OUT;
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    setsockopt(client, SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
    wire->client = client;
}

#ifndef POLLRDHUP
#define POLLRDHUP 0 /* only POLLHUP reports this there */
#endif

static bool happens(int file, short what)
{
    struct pollfd look = {.fd = file, .events = what};
    return poll(&look, 1, 0) == 1 && (look.revents & (what | POLLHUP)) != 0;
}

/* The first client stays, and all others are disconnected at once. A client that comes after the first one
 * has closed waits until the remaining octets of the first one are read. */
static void look_for_clients(wire_t *wire)
{
    while (!is_terminal(wire) && wire->leaving == 0u && happens(wire->listener, POLLIN)) {
        if (wire->client >= 0 && happens(wire->client, POLLRDHUP)) {
            return;
        }
        const int client = accept4(wire->listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (client < 0) {
            return;
        }
        if (wire->client < 0) {
            take_client(wire, client);
        } else {
            close(client);
        }
    }
}

/* ---- octets ---- */

static bool is_passing(int error)
{
    return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

static void send_waiting(wire_t *wire)
{
    uint32_t sent = 0;
    while (wire->client >= 0 && sent < wire->out_count) {
        const size_t count = wire->out_count - sent;
        const ssize_t n = is_terminal(wire) ? write(wire->client, &wire->out[sent], count)
                                            : send(wire->client, &wire->out[sent], count, MSG_NOSIGNAL);
        if (n < 0 && !is_passing(errno)) {
            lose_client(wire);
            return;
        }
        if (n <= 0) {
            break;
        }
        sent += (uint32_t)n;
    }
    wire->out_count -= sent;
    memmove(wire->out, &wire->out[sent], wire->out_count);
    wire->stuck = sent == 0u && wire->out_count > 0u ? wire->stuck + 1u : 0u;
    if (is_terminal(wire) && wire->stuck > STALE) {
        wire->out_count = 0u;
    }
}

/* Number of octets up to the end of the last whole frame. A client with another protocol is disconnected: a
 * request of HTTP, for example, begins with what would be a length above the largest one. */
static void look_for_frames(wire_t *wire)
{
    while (!is_terminal(wire) && wire->in_count - wire->in_whole >= 2u) {
        const uint8_t *at = &wire->in[wire->in_whole];
        const uint32_t length = (uint32_t)at[0] | (uint32_t)at[1] << 8;
        if (length == 0u || length > COMMAND_MAX) {
            lose_client(wire);
            return;
        }
        if (wire->in_count - wire->in_whole < HEADER + length) {
            return;
        }
        wire->in_whole += HEADER + length;
    }
    if (is_terminal(wire)) {
        wire->in_whole = wire->in_count;
    }
}

static void receive(wire_t *wire)
{
    if (wire->client < 0 || wire->in_at < wire->in_whole) {
        return;
    }
    wire->in_count -= wire->in_at;
    memmove(wire->in, &wire->in[wire->in_at], wire->in_count);
    wire->in_at = 0u;
    wire->in_whole = 0u;
    const ssize_t n = read(wire->client, &wire->in[wire->in_count], sizeof wire->in - wire->in_count);
    if (n > 0) {
        wire->in_count += (uint32_t)n;
        look_for_frames(wire);
    } else if (n == 0 || !is_passing(errno)) {
        lose_client(wire);
    }
}

static void say_goodbye(wire_t *wire)
{
    memcpy(wire->in, goodbye, sizeof goodbye);
    wire->in_count = sizeof goodbye;
    wire->in_whole = sizeof goodbye;
    wire->in_at = 0u;
}

void wire_poll(wire_t *wire)
{
    if (wire->leaving > 0u) {
        wire->leaving--;
        if (wire->leaving == SILENCE) {
            say_goodbye(wire);
        }
        return;
    }
    look_for_clients(wire);
    send_waiting(wire);
    receive(wire);
}

uint32_t wire_read(void *context, uint8_t *octets, uint32_t room)
{
    wire_t *wire = context;
    const uint32_t there = wire->in_whole - wire->in_at;
    const uint32_t count = there < room ? there : room;
    memcpy(octets, &wire->in[wire->in_at], count);
    wire->in_at += count;
    return count;
}

static void wait_for_room(wire_t *wire, uint32_t room)
{
    while (wire->client >= 0 && WAITING_OUT - wire->out_count < room && *wire->stop == 0) {
        struct pollfd look = {.fd = wire->client, .events = POLLOUT};
        (void)poll(&look, 1, STOP_LOOK_MS);
        send_waiting(wire);
        look_for_clients(wire); /* a second client that connects during this time gets this answer, too */
    }
}

uint32_t wire_write(void *context, const uint8_t *octets, uint32_t count)
{
    wire_t *wire = context;
    if (wire->wait) {
        wait_for_room(wire, count);
    }
    if (wire->client < 0) {
        return count; /* discarded */
    }
    const uint32_t left = WAITING_OUT - wire->out_count;
    const uint32_t taken = count < left ? count : left;
    memcpy(&wire->out[wire->out_count], octets, taken);
    wire->out_count += taken;
    return taken;
}
