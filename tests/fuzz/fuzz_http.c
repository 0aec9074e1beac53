/* The server of the scope's page with damaged requests, sent whole and in pieces by several clients: the
 * server neither hangs nor fails, and the handler gets a path and a body of the announced length. usage:
 * fuzz_http SEED SECONDS */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "fuzz.h"
#include "host_sim/scope/http.h"

#define CLIENTS 6

static http_t *http;
static int clients[CLIENTS];

static void handle(void *context, uint32_t client, const http_request_t *request)
{
    (void)context;
    fuzz_expect(request->path[0] == '/', "a path without a slash");
    fuzz_expect(strlen(request->body) <= HTTP_BODY_MAX, "a body that is too long");
    if (strcmp(request->path, "/events") == 0) {
        http_stream(http, client);
    } else {
        http_answer(http, client, 200, "text/plain", "hello", 5u);
    }
}

static int connected(void)
{
    const struct sockaddr_in at = {.sin_family = AF_INET,
                                   .sin_port = htons((uint16_t)http_port(http)),
                                   .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
    const int made = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    (void)connect(made, (const struct sockaddr *)&at, sizeof at);
    return made;
}

static size_t some_request(char *text, size_t room)
{
    static const char *const forms[] = {
        "GET / HTTP/1.1\r\nHost: 127.0.0.1:%u\r\n\r\n",
        "GET /events HTTP/1.1\r\nHost: localhost:%u\r\nAccept: text/event-stream\r\n\r\n",
        "POST /set HTTP/1.1\r\nHost: 127.0.0.1:%u\r\nX-Lagless: 1\r\nContent-Length: 5\r\n\r\nhello",
        "POST /set HTTP/1.1\r\nHost: 127.0.0.1:%u\r\nContent-Length: 5\r\n\r\nhello",
        "GET /a HTTP/1.1\r\nHost: 127.0.0.1:%u\r\n\r\nGET /b HTTP/1.1\r\nHost: 127.0.0.1:%u\r\n\r\n",
    };
    const unsigned port = http_port(http);
    const char *form = forms[fuzz_below(sizeof forms / sizeof forms[0])];
    char other[600];
    size_t count = 0;
    for (const char *c = form; *c != '\0'; c++) {
        if (*c == '%') {
            count += (size_t)snprintf(text + count, room - count, "%u", port);
            c++;
        } else {
            text[count++] = *c;
        }
    }
    memcpy(other, text, count < sizeof other ? count : sizeof other);
    if (fuzz_below(3u) != 0u) {
        count = fuzz_mutate(text, count, room, other, count < sizeof other ? count : sizeof other);
    }
    return count;
}

static void turn(void)
{
    static char text[4096];
    static char answers[65536];
    const int n = (int)fuzz_below(CLIENTS);
    if (clients[n] < 0 || fuzz_below(4u) == 0u) {
        if (clients[n] >= 0) {
            close(clients[n]);
        }
        clients[n] = connected();
    }
    const size_t count = some_request(text, sizeof text);
    for (size_t at = 0; at < count;) {
        const size_t some = 1u + fuzz_below(200u);
        const size_t part = some < count - at ? some : count - at;
        if (send(clients[n], text + at, part, MSG_NOSIGNAL) < 0) {
            break;
        }
        at += part;
        http_work(http);
    }
    http_event(http, HTTP_ALL, "e", "data", 4u, fuzz_below(2u) == 0u);
    http_work(http);
    for (int k = 0; k < CLIENTS; k++) {
        if (clients[k] >= 0 && recv(clients[k], answers, sizeof answers, MSG_DONTWAIT) == 0) {
            close(clients[k]);
            clients[k] = -1;
        }
    }
    http_work(http);
}

int main(int argc, char **argv)
{
    char why[256];
    http = http_open(0u, handle, NULL, why, sizeof why);
    fuzz_expect(http != NULL, why);
    for (int n = 0; n < CLIENTS; n++) {
        clients[n] = -1;
    }
    const int code = fuzz_run(argc, argv, turn);
    for (int n = 0; n < CLIENTS; n++) {
        if (clients[n] >= 0) {
            close(clients[n]);
        }
    }
    http_close(http);
    return code;
}
