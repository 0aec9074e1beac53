#include "host_sim/lab/loopback.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define WAITING 16 /* clients that have not been taken yet */

int loopback_listen(uint32_t *port, char *why, size_t size)
{
    const int yes = 1;
    struct sockaddr_in at = {.sin_family = AF_INET,
                             .sin_port = htons((uint16_t)*port),
                             .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
    socklen_t length = sizeof at;
    const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (listener < 0) {
        snprintf(why, size, "port %u: %s", (unsigned)*port, strerror(errno));
        return -1;
    }
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (bind(listener, (const struct sockaddr *)&at, sizeof at) != 0 || listen(listener, WAITING) != 0 ||
        getsockname(listener, (struct sockaddr *)&at, &length) != 0) {
        snprintf(why, size, "port %u: %s; another one, or 0 for any that is free", (unsigned)*port,
                 strerror(errno));
        close(listener);
        return -1;
    }
    *port = ntohs(at.sin_port);
    return listener;
}
