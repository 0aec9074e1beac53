/* The server of the scope's page: the requests that it answers, those that it refuses, and clients that do
 * not read. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "host_sim/scope/http.h"
#include "unity.h"

static http_t *http;
static char last_path[256];
static char last_body[HTTP_BODY_MAX + 1u];
static uint32_t posts, gets;

static void handle(void *context, uint32_t client, const http_request_t *request)
{
    (void)context;
    snprintf(last_path, sizeof last_path, "%s", request->path);
    snprintf(last_body, sizeof last_body, "%s", request->body);
    posts += request->post;
    gets += !request->post;
    if (strcmp(request->path, "/events") == 0) {
        http_stream(http, client);
    } else {
        http_answer(http, client, 200, "text/plain", "hello", 5u);
    }
}

void setUp(void)
{
    char why[256];
    posts = gets = 0u;
    last_path[0] = last_body[0] = '\0';
    http = http_open(0u, handle, NULL, why, sizeof why);
    TEST_ASSERT_NOT_NULL_MESSAGE(http, why);
}

void tearDown(void)
{
    http_close(http);
}

static int client(void)
{
    const struct sockaddr_in at = {.sin_family = AF_INET,
                                   .sin_port = htons((uint16_t)http_port(http)),
                                   .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
    const int made = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    (void)connect(made, (const struct sockaddr *)&at, sizeof at);
    usleep(2000);
    http_work(http);
    return made;
}

static void work(void)
{
    for (int n = 0; n < 10; n++) {
        usleep(1000);
        http_work(http);
    }
}

/* Reads all received octets; returns their number. */
static ssize_t receive(int from, char *to, size_t size)
{
    size_t count = 0;
    ssize_t n = 0;
    while (count < size - 1u && (n = recv(from, to + count, size - 1u - count, 0)) > 0) {
        count += (size_t)n;
    }
    to[count] = '\0';
    return count > 0u ? (ssize_t)count : n;
}

static void expect_status(int from, int status)
{
    char answer[2048], wanted[16];
    TEST_ASSERT_GREATER_THAN(0, receive(from, answer, sizeof answer));
    snprintf(wanted, sizeof wanted, "HTTP/1.1 %d", status);
    TEST_ASSERT_EQUAL_STRING_LEN(wanted, answer, strlen(wanted));
}

/* Sends a request; {T} in it becomes the token and {P} the port. */
static void ask(int to, const char *form)
{
    static char text[3u * HTTP_HEAD_MAX];
    size_t count = 0;
    for (const char *c = form; *c != '\0'; c++) {
        if (strncmp(c, "{T}", 3u) == 0 || strncmp(c, "{P}", 3u) == 0) {
            count += (size_t)(c[1] == 'T' ? sprintf(text + count, "%s", http_token(http))
                                          : sprintf(text + count, "%u", (unsigned)http_port(http)));
            c += 2;
        } else {
            text[count++] = *c;
        }
    }
    TEST_ASSERT_EQUAL(count, send(to, text, count, MSG_NOSIGNAL));
    work();
}

static void expect_answer(const char *form, int status)
{
    const int browser = client();
    ask(browser, form);
    expect_status(browser, status);
    close(browser);
}

#define HERE "Host: 127.0.0.1:{P}\r\n"
#define PAGE "GET /{T}/events HTTP/1.1\r\n" HERE

static void test_page_has_headers_that_isolate_it(void)
{
    char answer[2048];
    const int browser = client();
    ask(browser, "GET /{T}/ HTTP/1.1\r\n" HERE "\r\n");
    TEST_ASSERT_GREATER_THAN(0, receive(browser, answer, sizeof answer));
    TEST_ASSERT_NOT_NULL(strstr(answer, "HTTP/1.1 200 OK\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(answer, "Content-Length: 5\r\n"));
    TEST_ASSERT_NOT_NULL(strstr(answer, "default-src 'none'"));
    TEST_ASSERT_NULL(strstr(answer, "Access-Control"));
    TEST_ASSERT_NOT_NULL(strstr(answer, "\r\n\r\nhello"));
    close(browser);
}

static void test_a_foreign_request_is_refused_and_nothing_is_done(void)
{
    static const struct {
        const char *request;
        int status;
    } rows[] = {
        /* A foreign host name that leads to this address, no host name, another port. */
        {"GET /{T}/ HTTP/1.1\r\nHost: evil.example\r\n\r\n", 403},
        {"GET /{T}/ HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", 403},
        {"GET /{T}/ HTTP/1.1\r\nHost: 127.0.0.1:1\r\n\r\n", 403},
        {"GET /{T}/ HTTP/1.1\r\nHost: 127.0.0.1:{P}.evil.example\r\n\r\n", 403},
        {"GET /{T}/ HTTP/1.1\r\n\r\n", 403},
        /* Requests without the token. */
        {"GET / HTTP/1.1\r\n" HERE "\r\n", 403},
        {"GET /events HTTP/1.1\r\n" HERE "\r\n", 403},
        {"GET //events HTTP/1.1\r\n" HERE "\r\n", 403},
        {"GET /0123456789abcdef0123456789abcdef/ HTTP/1.1\r\n" HERE "\r\n", 403},
        {"GET /{T} HTTP/1.1\r\n" HERE "\r\n", 403},
        {"GET {T}/events HTTP/1.1\r\n" HERE "\r\n", 400},
        /* A request from a page of another origin that knows the token; a page at another port of this
         * machine counts as "same-site". */
        {PAGE "Sec-Fetch-Site: cross-site\r\n\r\n", 403},
        {PAGE "Sec-Fetch-Site: same-site\r\n\r\n", 403},
        {PAGE "sec-fetch-site:cross-site\r\n\r\n", 403},
        {PAGE "Sec-Fetch-Site: same-origin-but-very-much-longer-than-any-of-them\r\n\r\n", 403},
        {PAGE "Sec-Fetch-Site: \r\n\r\n", 403},
        {PAGE "Origin: https://evil.example\r\n\r\n", 403},
        {PAGE "Origin: null\r\n\r\n", 403},
        {PAGE "Origin: http://127.0.0.1:1\r\n\r\n", 403},
        {PAGE "Sec-Fetch-Site: same-origin\r\nOrigin: http://evil.example\r\n\r\n", 403},
        /* A form on a foreign page cannot send this header, and the server does not allow such a page to
         * add it. */
        {"POST /{T}/stop HTTP/1.1\r\nHost: localhost:{P}\r\nContent-Length: 0\r\n\r\n", 403},
        {"POST /{T}/stop HTTP/1.1\r\n" HERE
         "Origin: http://evil.example\r\nX-Lagless: 1\r\nContent-Length: 0\r\n\r\n",
         403},
        {"OPTIONS /{T}/stop HTTP/1.1\r\nHost: localhost:{P}\r\n\r\n", 400},
        /* A body that is too long, and texts that are no request. */
        {"POST /{T}/set HTTP/1.1\r\n" HERE "X-Lagless: 1\r\nContent-Length: 99999\r\n\r\n", 413},
        {"POST /{T}/set HTTP/1.1\r\n" HERE "X-Lagless: 1\r\nContent-Length: -1\r\n\r\n", 413},
        {"\x01\x02 nonsense\r\n\r\n", 400},
    };
    static char longer[HTTP_HEAD_MAX + 100u];
    memset(longer, 'a', sizeof longer - 1u);
    memcpy(longer, "GET /", 5u);
    expect_answer(longer, 413);
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        expect_answer(rows[n].request, rows[n].status);
    }
    TEST_ASSERT_EQUAL(HTTP_TOKEN, strspn(http_token(http), "0123456789abcdef"));
    for (uint32_t n = 0; n < HTTP_TOKEN; n++) { /* each character of the token is wrong in turn */
        char request[200];
        snprintf(request, sizeof request, "GET /%s/events HTTP/1.1\r\n" HERE "\r\n", http_token(http));
        request[5u + n] = request[5u + n] == '0' ? '1' : '0';
        expect_answer(request, 403);
    }
    TEST_ASSERT_EQUAL_UINT32(0u, gets + posts);
    TEST_ASSERT_EQUAL_UINT32(0u, http_streams(http));
}

/* Requests typed by the user or opened by a program, requests of the page itself, and STOP from it. */
static void test_a_request_of_the_page_is_answered(void)
{
    expect_answer("GET /{T}/ HTTP/1.1\r\n" HERE "Sec-Fetch-Site: none\r\n\r\n", 200);
    expect_answer("GET /{T}/ HTTP/1.1\r\n" HERE
                  "Sec-Fetch-Site: same-origin\r\nOrigin: http://localhost:{P}\r\n\r\n",
                  200);
    expect_answer(
        "POST /{T}/stop HTTP/1.1\r\nHost: localhost:{P}\r\nx-lagless: 1\r\nContent-Length: 0\r\n\r\n", 200);
    TEST_ASSERT_EQUAL_UINT32(2u, gets);
    TEST_ASSERT_EQUAL_UINT32(1u, posts);
}

static void test_every_server_has_its_own_token_and_answers_this_machine_alone(void)
{
    char why[256], first[HTTP_TOKEN + 1u];
    snprintf(first, sizeof first, "%s", http_token(http));
    http_close(http);
    http = http_open(0u, handle, NULL, why, sizeof why);
    TEST_ASSERT_NOT_NULL_MESSAGE(http, why);
    TEST_ASSERT_TRUE(strcmp(first, http_token(http)) != 0);
    const struct sockaddr_in other = {.sin_family = AF_INET,
                                      .sin_port = htons((uint16_t)http_port(http)),
                                      .sin_addr = {.s_addr = htonl(0x7f000002u)}}; /* 127.0.0.2 */
    const int made = socket(AF_INET, SOCK_STREAM, 0);
    TEST_ASSERT_EQUAL(-1, connect(made, (const struct sockaddr *)&other, sizeof other));
    close(made);
}

/* A request arrives octet by octet, and two requests arrive in one piece. */
static void test_requests_in_pieces_and_in_a_row(void)
{
    char text[512], answer[4096];
    const unsigned port = (unsigned)http_port(http);
    const int browser = client();
    const int count = snprintf(text, sizeof text,
                               "POST /%s/set HTTP/1.1\r\nHost: localhost:%u\r\nX-Lagless: "
                               "1\r\nContent-Length: 11\r\n\r\nenable quick",
                               http_token(http), port);
    for (int n = 0; n < count - 1; n++) {
        TEST_ASSERT_EQUAL(1, send(browser, &text[n], 1, MSG_NOSIGNAL));
        http_work(http);
    }
    work();
    expect_status(browser, 200);
    TEST_ASSERT_EQUAL_STRING("enable quic", last_body);
    ask(browser, "GET /{T}/a HTTP/1.1\r\n" HERE "\r\nGET /{T}/b HTTP/1.1\r\n" HERE "\r\n");
    TEST_ASSERT_GREATER_THAN(0, receive(browser, answer, sizeof answer));
    TEST_ASSERT_EQUAL_UINT32(2u, gets);
    TEST_ASSERT_EQUAL_STRING("/b", last_path);
    close(browser);
}

static int stream(void)
{
    char head[1024];
    const int made = client();
    ask(made, PAGE "\r\n");
    http_event(http, HTTP_ALL, "first", "{}", 2u, false);
    work();
    TEST_ASSERT_GREATER_THAN(0, receive(made, head, sizeof head));
    TEST_ASSERT_NOT_NULL(strstr(head, "text/event-stream"));
    return made;
}

static void test_events_come_as_lines(void)
{
    char text[256];
    const int page = stream();
    http_event(http, HTTP_ALL, "state", "{\"a\":1}", 7u, false);
    TEST_ASSERT_GREATER_THAN(0, receive(page, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("event: state\ndata: {\"a\":1}\n\n", text);
    close(page);
    work();
    TEST_ASSERT_EQUAL_UINT32(0u, http_streams(http));
}

/* A browser opens at most six connections, for all windows together: one of them must be free for STOP. */
static void test_one_stream_too_many_ends_the_oldest(void)
{
    int pages[HTTP_STREAMS + 1u];
    char text[1024];
    for (uint32_t n = 0; n <= HTTP_STREAMS; n++) {
        pages[n] = stream();
    }
    TEST_ASSERT_EQUAL_UINT32(HTTP_STREAMS, http_streams(http));
    (void)receive(pages[0], text, sizeof text);
    TEST_ASSERT_NOT_NULL(strstr(text, "event: taken\n"));
    TEST_ASSERT_EQUAL(0, recv(pages[0], text, 1, 0)); /* the server has closed it */
    TEST_ASSERT_EQUAL(-1, recv(pages[HTTP_STREAMS], text, 1, 0));
    for (uint32_t n = 0; n <= HTTP_STREAMS; n++) {
        close(pages[n]);
    }
}

/* A client that does not read receives no more samples but all messages that must not be lost, and it
 * delays no other client. */
static void test_slow_reader_is_spared_samples(void)
{
    static char data[100000], text[200000];
    memset(data, '7', sizeof data);
    const int slow = stream();
    const int quick = stream();
    ssize_t quick_octets = 0, slow_octets = 0;
    for (int n = 0; n < 300; n++) { /* 300 messages are 30 MB */
        http_event(http, HTTP_ALL, "samples", data, sizeof data, true);
        for (ssize_t got = 1; got > 0;) {
            got = recv(quick, text, sizeof text, 0);
            quick_octets += got > 0 ? got : 0;
            http_work(http);
        }
    }
    http_event(http, HTTP_ALL, "state", "last", 4u, false);
    TEST_ASSERT_EQUAL_UINT32(2u, http_streams(http));
    TEST_ASSERT_GREATER_OR_EQUAL(30000000, quick_octets);
    bool last = false;
    for (int n = 0; n < 100000 && !last; n++) {
        const ssize_t got = recv(slow, text, sizeof text - 1u, 0);
        slow_octets += got > 0 ? got : 0;
        text[got > 0 ? got : 0] = '\0';
        last = got > 0 && strstr(text, "event: state\ndata: last") != NULL;
        http_work(http);
    }
    TEST_ASSERT_TRUE(last);
    TEST_ASSERT_LESS_THAN(20000000, slow_octets);
    close(slow);
    close(quick);
}

static void test_more_connections_than_places_end_the_idlest(void)
{
    int idle[HTTP_CLIENTS + 1u];
    char octet;
    const int page = stream();
    for (uint32_t n = 0; n <= HTTP_CLIENTS; n++) {
        idle[n] = client();
    }
    TEST_ASSERT_EQUAL_UINT32(1u, http_streams(http));
    TEST_ASSERT_EQUAL(0, recv(idle[0], &octet, 1, 0));
    ask(idle[HTTP_CLIENTS], "GET /{T}/ HTTP/1.1\r\n" HERE "\r\n");
    expect_status(idle[HTTP_CLIENTS], 200);
    for (uint32_t n = 0; n <= HTTP_CLIENTS; n++) {
        close(idle[n]);
    }
    close(page);
}

static void test_port_in_use_is_named(void)
{
    char why[256], name[32];
    TEST_ASSERT_NULL(http_open(http_port(http), handle, NULL, why, sizeof why));
    snprintf(name, sizeof name, "port %u", (unsigned)http_port(http));
    TEST_ASSERT_NOT_NULL(strstr(why, name));
    TEST_ASSERT_NOT_NULL(strstr(why, "in use"));
}
