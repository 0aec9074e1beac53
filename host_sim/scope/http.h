/* A small HTTP/1.1 server for one page on this machine: it listens at 127.0.0.1 alone, answers requests of up
 * to HTTP_BODY_MAX octets, and keeps event streams ("server-sent events") open.
 *
 * Other pages in the same browser can neither control nor read anything. Every request, including GET, must -
 * name this server as its host, so that names that resolve to this machine cannot be misused,
 * - come from a page of this server, or from none, if the browser states it (Sec-Fetch-Site, Origin),
 * - begin its path with a token of 128 random bits, new in each http_open, which only the address has
 * that was printed for the user; else it is answered with 403. A request that changes anything (POST) must
 * also have the header X-Lagless. A browser allows a foreign page to send it only with a permission, which
 * this server does not give.
 *
 * No function waits. All calls must come from one thread. A stream whose reader is slow is spared events that
 * may be lost, and closed when HTTP_OUT_MAX octets wait for it. */
#ifndef HOST_SIM_SCOPE_HTTP_H
#define HOST_SIM_SCOPE_HTTP_H

#include <poll.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define HTTP_TOKEN    32u   /* characters */
#define HTTP_CLIENTS  24u   /* [-] connections at a time */
#define HTTP_STREAMS  3u    /* [-] streams among them: a browser opens at most six connections for all tabs */
#define HTTP_HEAD_MAX 8192u /* [octets] head and body of a request */
#define HTTP_BODY_MAX 4096u /* [octets] */
#define HTTP_OUT_MAX  16777216u /* [octets] buffered for a client */
#define HTTP_SLOW     1048576u  /* [octets] in the buffer of a slow client */

typedef struct http http_t;

typedef struct {
    bool post;        /* else GET */
    const char *path; /* after the token: "/" is the page */
    const char *body; /* with a 0 at its end */
} http_request_t;

/* Must answer by http_answer or http_stream, once, before it returns. */
typedef void (*http_handler_t)(void *context, uint32_t client, const http_request_t *request);

/* Listens at this port; 0: any free port. NULL: *why has the message, one line. */
http_t *http_open(uint32_t port, http_handler_t handler, void *context, char *why, size_t size);
void http_close(http_t *http); /* NULL: nothing */
uint32_t http_port(const http_t *http);
const char *http_token(const http_t *http); /* the address of the page: http://127.0.0.1:PORT/TOKEN/ */

/* The descriptors for poll, at most HTTP_CLIENTS + 1. Returns their number. */
uint32_t http_descriptors(const http_t *http, struct pollfd to[HTTP_CLIENTS + 1u]);

/* Does everything that is possible without waiting. */
void http_work(http_t *http);

void http_answer(http_t *http, uint32_t client, int status, const char *type, const char *body, size_t size);

/* From now on this client gets events. The oldest of too many streams gets the event `taken` and is closed.
 */
void http_stream(http_t *http, uint32_t client);
uint32_t http_streams(const http_t *http);

/* Sends an event to one stream, or to all. `data` is one line. may_be_lost: slow clients do not get it. */
void http_event(http_t *http, uint32_t client, const char *name, const char *data, size_t size,
                bool may_be_lost);
#define HTTP_ALL UINT32_MAX

#endif
