#include "host_sim/scope/http.h"

#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include "host_sim/lab/loopback.h"

typedef struct {
    int socket; /* -1: free */
    bool stream;
    bool last;      /* closed when all is sent */
    uint64_t order; /* of streams by age, of others by their last request */
    size_t in_count;
    char in[HTTP_HEAD_MAX + 1u];
    char *out;
    size_t out_count, out_sent, out_room;
} client_t;

struct http {
    int listener;
    uint32_t port;
    uint64_t order;
    http_handler_t handler;
    void *context;
    char token[HTTP_TOKEN + 1u];
    client_t clients[HTTP_CLIENTS];
};

/* ---- life ---- */

/* Random, in hexadecimal digits. false: the system has no random numbers. */
static bool make_token(char token[HTTP_TOKEN + 1u])
{
    uint8_t octets[HTTP_TOKEN / 2u];
    FILE *from = fopen("/dev/urandom", "rb");
    const bool good = from != NULL && fread(octets, sizeof octets, 1, from) == 1;
    if (from != NULL) {
        fclose(from);
    }
    for (uint32_t n = 0; good && n < sizeof octets; n++) {
        snprintf(token + 2u * n, 3u, "%02x", octets[n]);
    }
    return good;
}

http_t *http_open(uint32_t port, http_handler_t handler, void *context, char *why, size_t size)
{
    http_t *http = calloc(1, sizeof *http);
    if (http == NULL) {
        snprintf(why, size, "not enough memory");
        return NULL;
    }
    http->listener = -1;
    if (make_token(http->token)) {
        http->listener = loopback_listen(&port, why, size);
    } else {
        snprintf(why, size, "no random numbers for the page's address: /dev/urandom cannot be read");
    }
    if (http->listener < 0) {
        free(http);
        return NULL;
    }
    http->port = port;
    http->handler = handler;
    http->context = context;
    for (uint32_t n = 0; n < HTTP_CLIENTS; n++) {
        http->clients[n].socket = -1;
    }
    return http;
}

static void drop(client_t *client)
{
    if (client->socket >= 0) {
        close(client->socket);
    }
    free(client->out);
    client->out = NULL;
    client->socket = -1;
    client->stream = false;
    client->last = false;
    client->in_count = 0u;
    client->out_count = 0u;
    client->out_sent = 0u;
    client->out_room = 0u;
}

void http_close(http_t *http)
{
    if (http != NULL) {
        for (uint32_t n = 0; n < HTTP_CLIENTS; n++) {
            drop(&http->clients[n]);
        }
        close(http->listener);
        free(http);
    }
}

uint32_t http_port(const http_t *http)
{
    return http->port;
}

const char *http_token(const http_t *http)
{
    return http->token;
}

uint32_t http_streams(const http_t *http)
{
    uint32_t count = 0;
    for (uint32_t n = 0; n < HTTP_CLIENTS; n++) {
        count += http->clients[n].stream;
    }
    return count;
}

static size_t waiting(const client_t *client)
{
    return client->out_count - client->out_sent;
}

uint32_t http_descriptors(const http_t *http, struct pollfd to[HTTP_CLIENTS + 1u])
{
    uint32_t count = 0;
    to[count++] = (struct pollfd){.fd = http->listener, .events = POLLIN};
    for (uint32_t n = 0; n < HTTP_CLIENTS; n++) {
        const client_t *client = &http->clients[n];
        if (client->socket >= 0) {
            to[count++] = (struct pollfd){.fd = client->socket,
                                          .events = (short)(POLLIN | (waiting(client) > 0u ? POLLOUT : 0))};
        }
    }
    return count;
}

/* ---- out ---- */

static void send_waiting(client_t *client)
{
    while (client->socket >= 0 && waiting(client) > 0u) {
        const ssize_t n = send(client->socket, client->out + client->out_sent, waiting(client), MSG_NOSIGNAL);
        if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            return;
        }
        if (n < 0 && errno != EINTR) {
            drop(client);
            return;
        }
        client->out_sent += n > 0 ? (size_t)n : 0u;
    }
    client->out_count = 0u;
    client->out_sent = 0u;
    if (client->last) {
        drop(client);
    }
}

static void put(client_t *client, const char *text, size_t size)
{
    if (client->socket < 0) {
        return;
    }
    if (client->out_sent > 0u) {
        memmove(client->out, client->out + client->out_sent, waiting(client));
        client->out_count -= client->out_sent;
        client->out_sent = 0u;
    }
    const size_t needed = client->out_count + size;
    if (needed > client->out_room) {
        const size_t room = 2u * needed;
        char *out = needed <= HTTP_OUT_MAX ? realloc(client->out, room) : NULL;
        if (out == NULL) {
            drop(client);
            return;
        }
        client->out = out;
        client->out_room = room;
    }
    memcpy(client->out + client->out_count, text, size);
    client->out_count += size;
}

static void put_text(client_t *client, const char *text)
{
    put(client, text, strlen(text));
}

static const char *phrase(int status)
{
    switch (status) {
    case 200:
        return "OK";
    case 400:
        return "Bad Request";
    case 403:
        return "Forbidden";
    case 404:
        return "Not Found";
    case 413:
        return "Content Too Large";
    default:
        return "Error";
    }
}

/* The page may load only its own content, and connect only to this server. */
#define COMMON_HEADERS                                                                                       \
    "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n"         \
    "Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "   \
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n"

void http_answer(http_t *http, uint32_t client, int status, const char *type, const char *body, size_t size)
{
    char head[768];
    client_t *to = &http->clients[client];
    snprintf(head, sizeof head,
             "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\n" COMMON_HEADERS "\r\n", status,
             phrase(status), type, size);
    put_text(to, head);
    put(to, body, size);
    to->last = to->last || status >= 400;
    send_waiting(to);
}

static client_t *oldest(http_t *http, bool stream, const client_t *but)
{
    client_t *found = NULL;
    for (uint32_t n = 0; n < HTTP_CLIENTS; n++) {
        client_t *client = &http->clients[n];
        if (client->socket >= 0 && client->stream == stream && client != but &&
            (found == NULL || client->order < found->order)) {
            found = client;
        }
    }
    return found;
}

void http_stream(http_t *http, uint32_t client)
{
    client_t *to = &http->clients[client];
    while (http_streams(http) >= HTTP_STREAMS) {
        client_t *old = oldest(http, true, NULL);
        old->stream = false;
        old->last = true;
        put_text(old, "event: taken\ndata: {}\n\n");
        send_waiting(old);
    }
    to->stream = true;
    put_text(to, "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n" COMMON_HEADERS "\r\n");
}

static void event_to(client_t *client, const char *name, const char *data, size_t size, bool may_be_lost)
{
    if (!client->stream || (may_be_lost && waiting(client) > HTTP_SLOW)) {
        return;
    }
    put_text(client, "event: ");
    put_text(client, name);
    put_text(client, "\ndata: ");
    put(client, data, size);
    put_text(client, "\n\n");
    send_waiting(client);
}

void http_event(http_t *http, uint32_t client, const char *name, const char *data, size_t size,
                bool may_be_lost)
{
    for (uint32_t n = 0; n < HTTP_CLIENTS; n++) {
        if (client == HTTP_ALL || client == n) {
            event_to(&http->clients[n], name, data, size, may_be_lost);
        }
    }
}

/* ---- in ---- */

/* The begin of the value of a header; the head ends with an empty line. NULL: there is no such header. */
static const char *value_of(const char *head, const char *name)
{
    const size_t length = strlen(name);
    for (const char *line = strstr(head, "\r\n"); line != NULL; line = strstr(line, "\r\n")) {
        line += 2;
        if (strncasecmp(line, name, length) == 0 && line[length] == ':') {
            return line + length + 1u;
        }
    }
    return NULL;
}

/* Copies the value of a header without blanks around it. false: the header is missing, or its value is too
 * long. */
static bool header(const char *head, const char *name, char *to, size_t size)
{
    const char *value = value_of(head, name);
    if (value == NULL) {
        return false;
    }
    value += strspn(value, " \t");
    size_t count = strcspn(value, "\r\n");
    while (count > 0u && (value[count - 1u] == ' ' || value[count - 1u] == '\t')) {
        count--;
    }
    snprintf(to, size, "%.*s", (int)(count < size ? count : size - 1u), value);
    return count < size;
}

/* True if the text is one of the two names of this server after this prefix. */
static bool is_own(const http_t *http, const char *before, const char *text)
{
    char address[64], name[64];
    snprintf(address, sizeof address, "%s127.0.0.1:%u", before, (unsigned)http->port);
    snprintf(name, sizeof name, "%slocalhost:%u", before, (unsigned)http->port);
    return strcasecmp(text, address) == 0 || strcasecmp(text, name) == 0;
}

/* true: the request is from the user or from a page of this server. A browser states the origin of a request
 * in headers that a foreign page cannot change. A missing header decides nothing. */
static bool is_own_page(const http_t *http, const char *head)
{
    char host[64], origin[64], site[32];
    if (!header(head, "Host", host, sizeof host) || !is_own(http, "", host)) {
        return false;
    }
    if (value_of(head, "Origin") != NULL &&
        !(header(head, "Origin", origin, sizeof origin) && is_own(http, "http://", origin))) {
        return false;
    }
    return value_of(head, "Sec-Fetch-Site") == NULL ||
           (header(head, "Sec-Fetch-Site", site, sizeof site) &&
            (strcasecmp(site, "same-origin") == 0 || strcasecmp(site, "none") == 0));
}

/* The part of the path after the token; NULL: the path has no token, or a wrong one. The time of the
 * comparison does not depend on the number of right characters.
 */
static const char *behind_token(const http_t *http, const char *path)
{
    unsigned differs = 0u;
    if (strlen(path) < 1u + HTTP_TOKEN) {
        return NULL;
    }
    for (uint32_t n = 0; n < HTTP_TOKEN; n++) {
        differs |= (unsigned)(path[1u + n] ^ http->token[n]);
    }
    const char *rest = path + 1u + HTTP_TOKEN;
    return differs == 0u && *rest == '/' ? rest : NULL;
}

static void refuse(http_t *http, uint32_t client, int status, const char *text)
{
    http_answer(http, client, status, "text/plain; charset=utf-8", text, strlen(text));
}

/* [octets] of the body; -1: an invalid length. */
static long body_length(const char *head)
{
    char text[16];
    char *end = NULL;
    if (!header(head, "Content-Length", text, sizeof text)) {
        return 0;
    }
    const long length = strtol(text, &end, 10);
    return text[0] >= '0' && text[0] <= '9' && *end == '\0' && length <= (long)HTTP_BODY_MAX ? length : -1;
}

/* Handles a complete request; head and body end with a 0. */
static void serve(http_t *http, uint32_t client, char *head, const char *body)
{
    char mark[8], method[8], path[128], version[16];
    if (sscanf(head, "%7s %127s %15s", method, path, version) != 3 || strncmp(version, "HTTP/1.", 7) != 0 ||
        path[0] != '/' || (strcmp(method, "GET") != 0 && strcmp(method, "POST") != 0)) {
        refuse(http, client, 400,
               "the request is not understood; accepted: the requests of the scope's page\n");
        return;
    }
    const bool post = strcmp(method, "POST") == 0;
    const char *rest = behind_token(http, path);
    if (!is_own_page(http, head) || (post && !header(head, "X-Lagless", mark, sizeof mark))) {
        refuse(http, client, 403,
               "only the page of this server has access: open the address that `lagless scope` printed\n");
        return;
    }
    if (rest == NULL) {
        refuse(http, client, 403, "the address is the one that `lagless scope` printed, with its token\n");
        return;
    }
    const http_request_t request = {post, rest, body};
    http->clients[client].order = ++http->order;
    http->handler(http->context, client, &request);
}

/* Handles one request, if it is complete. */
static bool serve_next(http_t *http, uint32_t number)
{
    client_t *client = &http->clients[number];
    client->in[client->in_count] = '\0';
    char *end = strstr(client->in, "\r\n\r\n");
    if (client->socket < 0 || client->stream || client->last) {
        client->in_count = 0u;
        return false;
    }
    if (end == NULL) {
        if (client->in_count >= HTTP_HEAD_MAX) {
            refuse(http, number, 413, "the request is too long\n");
        }
        return false;
    }
    const size_t head_size = (size_t)(end + 4 - client->in);
    end[2] = '\0'; /* the head keeps the end of its last line */
    const long length = body_length(client->in);
    if (length < 0 || head_size + (size_t)length > HTTP_HEAD_MAX) {
        refuse(http, number, 413, "the request is too long\n");
        return false;
    }
    const size_t whole = head_size + (size_t)length;
    if (client->in_count < whole) {
        end[2] = '\r';
        return false;
    }
    char body[HTTP_BODY_MAX + 1u];
    memcpy(body, client->in + head_size, (size_t)length);
    body[length] = '\0';
    serve(http, number, client->in, body);
    client->in_count -= client->in_count < whole ? client->in_count : whole; /* 0 if it was dropped */
    memmove(client->in, client->in + whole, client->in_count);
    return true;
}

static void receive(http_t *http, uint32_t number)
{
    client_t *client = &http->clients[number];
    if (client->socket < 0) {
        return;
    }
    const ssize_t n =
        recv(client->socket, client->in + client->in_count, HTTP_HEAD_MAX - client->in_count, 0);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) {
        drop(client);
        return;
    }
    client->in_count += n > 0 ? (size_t)n : 0u;
    while (n > 0 && serve_next(http, number)) {
    }
}

static void accept_all(http_t *http)
{
    const int yes = 1;
    for (;;) {
        const int got = accept4(http->listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (got < 0) {
            return;
        }
        client_t *place = NULL;
        for (uint32_t n = 0; n < HTTP_CLIENTS && place == NULL; n++) {
            place = http->clients[n].socket < 0 ? &http->clients[n] : NULL;
        }
        if (place == NULL) { /* the client whose last request is the oldest */
            place = oldest(http, false, NULL);
            drop(place);
        }
        setsockopt(got, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
        place->socket = got;
        place->order = ++http->order;
    }
}

void http_work(http_t *http)
{
    accept_all(http);
    for (uint32_t n = 0; n < HTTP_CLIENTS; n++) {
        receive(http, n);
        send_waiting(&http->clients[n]);
    }
}
