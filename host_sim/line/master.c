/* Sends and receives octets, with one pending command and time-outs. */
#include "host_sim/line/master.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "host_sim/line/master_parts.h"
#include "host_sim/rig/rig.h"

#define REPEATS    3u    /* [-] repetitions of a request that is not answered although SYNCH is answered */
#define BUSY_WAIT  0.02  /* [s] until the request to a busy drive is repeated */
#define BUSY_MAX   100u  /* [-] times */
#define CLOCK_WAIT 0.001 /* [s] the shortest time between two queries of the clock of a fast drive */
#define READS_MAX  16u   /* [-] at a time */
#define NEVER      1e9   /* [s] */

double master_now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

void master_put(uint8_t *at, uint32_t value, uint32_t octets)
{
    for (uint32_t n = 0; n < octets; n++) {
        at[n] = (uint8_t)(value >> 8u * n);
    }
}

uint32_t master_take(const uint8_t *at, uint32_t octets)
{
    uint32_t value = 0;
    for (uint32_t n = 0; n < octets; n++) {
        value |= (uint32_t)at[n] << 8u * n;
    }
    return value;
}

bool master_fail(master_error_t *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    return false;
}

/* ---- out ---- */

static void flush_out(master_t *master)
{
    while (master->descriptor >= 0 && master->out_begin < master->out_end) {
        const uint8_t *from = master->out + master->out_begin;
        const size_t size = master->out_end - master->out_begin;
        ssize_t done = send(master->descriptor, from, size, MSG_NOSIGNAL);
        if (done < 0 && errno == ENOTSOCK) {
            done = write(master->descriptor, from, size);
        }
        if (done < 0) {
            if (errno != EAGAIN && errno != EINTR) {
                master_break(master, errno == EPIPE || errno == ECONNRESET
                                         ? "the other end closed the connection"
                                         : strerror(errno));
            }
            return;
        }
        master->out_begin += (uint32_t)done;
    }
    master->out_begin = master->out_end = 0;
}

static void send_packet(master_t *master, const uint8_t *packet, uint32_t length)
{
    if (master->out_end + FRAMES_HEADER + length + FRAMES_TAIL > sizeof master->out) {
        return; /* the request counts as lost on the line, because its answer will be missing */
    }
    uint8_t *at = master->out + master->out_end;
    master->out_end += frames_make(at, master->in.lossless, master->counter++, packet, length);
    master->sent = master_now();
    flush_out(master);
}

/* ---- questions ---- */

static question_t *first_question(master_t *master)
{
    return &master->queue[master->first];
}

static void ask_step(master_t *master)
{
    const question_t *question = first_question(master);
    const bool takes_long = question->patience > MASTER_PATIENCE && master->step + 1u == question->count;
    master->state = LINE_ASKED;
    master->due = master_now() + (takes_long ? question->patience : master->patience);
    send_packet(master, question->packets[master->step], question->lengths[master->step]);
}

static void ask_first(master_t *master)
{
    if (master->state == LINE_IDLE && master->count != 0u && master->descriptor >= 0) {
        master->step = 0;
        ask_step(master);
    }
}

static void answered(master_t *master, int result, const uint8_t *data, uint32_t octets)
{
    const question_t question = *first_question(master);
    master->first = (master->first + 1u) % MASTER_QUEUE;
    master->count--;
    master->state = LINE_IDLE;
    if (question.answer != NULL) {
        question.answer(question.context, result, data, octets);
    }
    ask_first(master);
}

void master_ask(master_t *master, const question_t *question)
{
    if (master->descriptor < 0 || master->count == MASTER_QUEUE) {
        if (question->answer != NULL) {
            question->answer(question->context, master->descriptor < 0 ? MASTER_LOST : MASTER_NOT_SENT, NULL,
                             0u);
        }
        return;
    }
    master->queue[(master->first + master->count++) % MASTER_QUEUE] = *question;
    ask_first(master);
}

question_t master_question(uint8_t command, uint32_t length, uint32_t octets, master_answer_t answer,
                           void *context)
{
    question_t question = {.count = 1u, .octets = octets, .patience = MASTER_PATIENCE};
    question.packets[0][0] = command;
    question.lengths[0] = (uint8_t)length;
    question.answer = answer;
    question.context = context;
    return question;
}

void master_break(master_t *master, const char *why)
{
    if (master->descriptor < 0) {
        return;
    }
    snprintf(master->lost, sizeof master->lost, "%s", why);
    close(master->descriptor);
    master_forget(master);
}

void master_forget(master_t *master)
{
    master->descriptor = -1;
    master->connected = false;
    master->daq.running = false;
    master->clock_known = false;
    while (master->count != 0u) {
        answered(master, MASTER_LOST, NULL, 0u);
    }
    master->state = LINE_IDLE;
}

/* ---- in ---- */

/* No answer in time. Before CONNECT is answered there is no SYNCH either: it is sent again. */
static void synch(master_t *master)
{
    static const uint8_t packet[1] = {XCP_SYNCH};
    if (master->synchs++ == MASTER_SYNCHS) {
        master_break(master,
                     master->connected ? "the drive does not answer any more" : "no XCP device answers");
        return;
    }
    if (!master->connected) {
        ask_step(master);
        return;
    }
    master->state = LINE_SYNCHING;
    master->due = master_now() + master->patience;
    send_packet(master, packet, sizeof packet);
}

static void repeat(master_t *master)
{
    if (first_question(master)->repeats++ >= REPEATS) {
        master_break(master, "the drive answers SYNCH, but no command, also after several attempts");
        return;
    }
    master->step = 0;
    ask_step(master);
}

static void take_answer(master_t *master, const uint8_t *packet, uint32_t length)
{
    question_t *question = first_question(master);
    const bool positive = packet[0] == XCP_RESPONSE;
    const int code = positive ? MASTER_OK : length > 1u ? packet[1] : 0xFF;
    if (master->state == LINE_SYNCHING) {
        if (!positive && code == XCP_ERROR_SYNCH) {
            master->synchs = 0;
            repeat(master);
        }
        return; /* otherwise it is the late answer of an abandoned request */
    }
    if (master->state != LINE_ASKED || (!positive && code == XCP_ERROR_SYNCH)) {
        return; /* requested twice, or not at all */
    }
    const bool last = master->step + 1u == question->count;
    if (positive && last && question->octets != MASTER_ANY && length != 1u + question->octets) {
        return; /* answer to another request; the time-out of this one reports its missing answer */
    }
    master->synchs = 0;
    if (code == MASTER_BUSY && question->busy++ < BUSY_MAX) {
        master->state = LINE_BUSY; /* over a serial line the first answer to a write: it has to come twice */
        master->due = master_now() + (question->busy <= question->count ? 0.0 : BUSY_WAIT);
    } else if (positive && !last) {
        master->step++;
        ask_step(master);
    } else {
        answered(master, code, packet + 1, length - 1u);
    }
}

static void take_packet(master_t *master, const uint8_t *packet, uint32_t length)
{
    if (packet[0] == XCP_RESPONSE || packet[0] == XCP_ERROR) {
        take_answer(master, packet, length);
    } else if (packet[0] == XCP_EVENT && length > 1u && packet[1] == XCP_EVENT_PENDING &&
               master->state == LINE_ASKED) {
        master->due = master_now() + first_question(master)->patience;
    } else if (packet[0] < XCP_SERVICE) {
        master_daq_packet(master, packet, length);
    }
}

/* Reads the available octets, up to a limit, because samples may arrive without end. */
static void receive(master_t *master)
{
    for (uint32_t n = 0; n < READS_MAX && master->descriptor >= 0; n++) {
        uint32_t length;
        uint32_t room;
        uint8_t *to = frames_room(&master->in, &room);
        const ssize_t count = read(master->descriptor, to, room);
        const int error = errno;
        if (count > 0) {
            frames_received(&master->in, (uint32_t)count, master_now());
        }
        const double now = master_now();
        for (const uint8_t *packet = frames_next(&master->in, now, &length);
             packet != NULL && master->descriptor >= 0; packet = frames_next(&master->in, now, &length)) {
            take_packet(master, packet, length);
        }
        if (master->in.broken) {
            master_break(master, "the received data are not XCP");
        } else if (count == 0 || (count < 0 && (error == EIO || error == ECONNRESET))) {
            master_break(master, "the other end closed the connection");
        } else if (count < 0 && error != EAGAIN && error != EINTR) {
            master_break(master, strerror(error));
        }
        if (count <= 0 || (uint32_t)count < room / 2u) {
            return;
        }
    }
}

/* ---- the drive's clock; reading it also resets the command timeout ---- */

static void take_clock(void *context, int result, const uint8_t *data, uint32_t octets)
{
    master_t *master = context;
    master->asking_clock = false;
    if (result != MASTER_OK || octets < 7u) {
        return;
    }
    const double now = master_now();
    const uint32_t clock = master_take(data + 3, 4u);
    const double passed = now - master->clock_at;
    if (master->clock_known && passed > 0.0) {
        const double rate = (double)(clock - master->clock) * RIG_PERIOD_SECONDS / passed;
        master->clock_rate = fmin(fmax(rate, 1.0), 1000.0);
    }
    master->clock_known = true;
    master->clock = clock;
    master->clock_at = now;
}

static double alive_due(const master_t *master)
{
    const double wait = MASTER_ALIVE / master->clock_rate;
    return master->sent + (wait > CLOCK_WAIT ? wait : CLOCK_WAIT);
}

static void keep_alive(master_t *master)
{
    if (master->connected && !master->asking_clock && master->count == 0u &&
        master_now() >= alive_due(master)) {
        const question_t question = master_question(XCP_GET_DAQ_CLOCK, 1u, 7u, take_clock, master);
        master->asking_clock = true;
        master_ask(master, &question);
    }
}

/* ---- the poll loop ---- */

int master_descriptor(const master_t *master)
{
    return master->descriptor;
}

short master_events(const master_t *master)
{
    return (short)(POLLIN | (master->out_begin < master->out_end ? POLLOUT : 0));
}

double master_patience(const master_t *master)
{
    const double now = master_now();
    double left = frames_patience(&master->in, now);
    if (master->state != LINE_IDLE) {
        left = fmin(left, master->due - now);
    } else if (master->connected) {
        left = fmin(left, alive_due(master) - now);
    }
    return fmax(left, 0.0);
}

static void look_at_time(master_t *master)
{
    if (master->descriptor < 0 || master->state == LINE_IDLE || master_now() < master->due) {
        return;
    }
    if (master->state == LINE_BUSY) {
        ask_step(master);
    } else {
        synch(master);
    }
}

bool master_work(master_t *master)
{
    flush_out(master);
    receive(master);
    look_at_time(master);
    keep_alive(master);
    return master->descriptor >= 0;
}

/* Waits until an octet comes, at most this time. */
static bool poll_once(master_t *master, double seconds)
{
    const double patience = fmin(seconds, master_patience(master));
    struct pollfd waiting = {master->descriptor, master_events(master), 0};
    const struct timespec time = {(time_t)patience, (long)(1e9 * (patience - floor(patience)))};
    if (master->descriptor >= 0) {
        (void)ppoll(&waiting, 1, &time, NULL);
    }
    return master_work(master);
}

bool master_wait(master_t *master, double seconds)
{
    const double end = master_now() + seconds;
    bool good = master_work(master);
    for (double left = seconds; good && left > 0.0; left = end - master_now()) {
        good = poll_once(master, left);
    }
    return good;
}

const char *master_lost(const master_t *master)
{
    return master->lost;
}

typedef struct {
    bool done;
    int result;
    uint8_t *data;
    uint32_t octets;
} waiting_t;

static void take_waited(void *context, int result, const uint8_t *data, uint32_t octets)
{
    waiting_t *waiting = context;
    waiting->done = true;
    waiting->result = result;
    waiting->octets = octets;
    if (waiting->data != NULL && octets != 0u) {
        memcpy(waiting->data, data, octets < MASTER_READ_MAX ? octets : MASTER_READ_MAX);
    }
}

int master_asked(master_t *master, question_t question, uint8_t *data, uint32_t *octets)
{
    waiting_t waiting = {.data = data};
    question.answer = take_waited;
    question.context = &waiting;
    master_ask(master, &question);
    while (!waiting.done) {
        (void)poll_once(master, NEVER);
    }
    if (octets != NULL) {
        *octets = waiting.octets;
    }
    return waiting.result;
}
