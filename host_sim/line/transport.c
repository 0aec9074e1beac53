#include "host_sim/line/transport.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#define ACCEPTED "accepted: tcp://HOST:PORT, or a serial device such as /dev/ttyUSB0 or /dev/ttyUSB0:115200"

static bool is_whole(const char *text, uint32_t min, uint32_t max, uint32_t *value)
{
    char *end;
    if (text[0] < '0' || text[0] > '9' || strlen(text) > 9) {
        return false;
    }
    *value = (uint32_t)strtoul(text, &end, 10);
    return *end == '\0' && *value >= min && *value <= max;
}

static bool parse_tcp(const char *target, transport_target_t *parsed, char *why, size_t size)
{
    const char *host = target + strlen("tcp://");
    const char *colon = strrchr(host, ':');
    uint32_t port = 0;
    if (colon == NULL || !is_whole(colon + 1, 1u, 65535u, &port)) {
        snprintf(why, size, "%s: no port 1 to 65535 at its end; %s", target, ACCEPTED);
        return false;
    }
    const bool brackets = host[0] == '[' && colon[-1] == ']';
    const char *begin = brackets ? host + 1 : host;
    const int length = (int)((brackets ? colon - 1 : colon) - begin);
    if (length <= 0) {
        snprintf(why, size, "%s: no host before the port; %s", target, ACCEPTED);
        return false;
    }
    parsed->tcp = true;
    snprintf(parsed->place, sizeof parsed->place, "%.*s", length, begin);
    snprintf(parsed->port, sizeof parsed->port, "%u", (unsigned)port);
    return true;
}

bool transport_parse(const char *target, transport_target_t *parsed, char *why, size_t size)
{
    *parsed = (transport_target_t){.baud = TRANSPORT_BAUD};
    if (strlen(target) >= sizeof parsed->place) {
        snprintf(why, size, "the target's name has %zu octets; %s", strlen(target), ACCEPTED);
        return false;
    }
    if (strncmp(target, "tcp://", 6) == 0) {
        return parse_tcp(target, parsed, why, size);
    }
    if (strchr(target, '/') == NULL || strstr(target, "://") != NULL) {
        snprintf(why, size, "%s: no target; %s", target, ACCEPTED);
        return false;
    }
    snprintf(parsed->place, sizeof parsed->place, "%s", target);
    char *colon = strrchr(parsed->place, ':');
    if (colon != NULL && strchr(colon, '/') == NULL && access(target, F_OK) != 0) {
        if (!is_whole(colon + 1, TRANSPORT_BAUD_MIN, TRANSPORT_BAUD_MAX, &parsed->baud)) {
            snprintf(why, size, "%s: baud %s: accepted: whole numbers %u to %u", target, colon + 1,
                     TRANSPORT_BAUD_MIN, TRANSPORT_BAUD_MAX);
            return false;
        }
        *colon = '\0';
    }
    return true;
}

/* 0, or the errno of the error. */
static int await_connection(int descriptor)
{
    struct pollfd waiting = {descriptor, POLLOUT, 0};
    if (poll(&waiting, 1, (int)(1000.0 * TRANSPORT_WAIT)) != 1) {
        return ETIMEDOUT;
    }
    int error = 0;
    socklen_t length = sizeof error;
    return getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &length) == 0 ? error : errno;
}

static int connect_to(const struct addrinfo *address, int *error)
{
    const int one = 1;
    const int descriptor =
        socket(address->ai_family, address->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, address->ai_protocol);
    if (descriptor < 0) {
        *error = errno;
        return -1;
    }
    *error = connect(descriptor, address->ai_addr, address->ai_addrlen) == 0 ? 0 : errno;
    if (*error == EINPROGRESS) {
        *error = await_connection(descriptor);
    }
    if (*error != 0) {
        close(descriptor);
        return -1;
    }
    (void)setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    return descriptor;
}

static int open_tcp(const transport_target_t *parsed, const char *target, char *why, size_t size)
{
    const struct addrinfo wanted = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    struct addrinfo *found = NULL;
    const int problem = getaddrinfo(parsed->place, parsed->port, &wanted, &found);
    if (problem != 0) {
        snprintf(why, size, "%s: host %s: %s", target, parsed->place, gai_strerror(problem));
        return -1;
    }
    int error = 0;
    int descriptor = -1;
    for (const struct addrinfo *at = found; at != NULL && descriptor < 0; at = at->ai_next) {
        descriptor = connect_to(at, &error);
    }
    freeaddrinfo(found);
    if (descriptor < 0) {
        snprintf(why, size,
                 error == ECONNREFUSED
                     ? "%s: no server listens at this address (%s); start `lagless serve SCENARIO --port %s`"
                     : "%s: %s (port %s)",
                 target, strerror(error), parsed->port);
    }
    return descriptor;
}

static int open_serial(const transport_target_t *parsed, char *why, size_t size)
{
    const int descriptor = open(parsed->place, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) {
        snprintf(why, size, "%s: %s%s", parsed->place, strerror(errno),
                 errno == EACCES   ? "; your user must be a member of the group of the device, often dialout"
                 : errno == ENOENT ? "; check that the adapter is plugged in"
                                   : "");
        return -1;
    }
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
        snprintf(why, size, "%s: another program uses this device (%s); end that program first",
                 parsed->place, strerror(errno));
        close(descriptor);
        return -1;
    }
    char problem[128];
    if (!transport_serial(descriptor, parsed->baud, problem, sizeof problem)) {
        snprintf(why, size, "%s: %s", parsed->place, problem);
        close(descriptor);
        return -1;
    }
    return descriptor;
}

int transport_open(const char *target, bool *lossless, char *why, size_t size)
{
    transport_target_t parsed;
    if (!transport_parse(target, &parsed, why, size)) {
        return -1;
    }
    *lossless = parsed.tcp;
    return parsed.tcp ? open_tcp(&parsed, target, why, size) : open_serial(&parsed, why, size);
}
