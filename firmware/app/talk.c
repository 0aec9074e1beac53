#include "app/talk.h"

#include <string.h>

#include "app/app.h"
#include "app/talk_values.h"

#define SILENCE_PERIODS DRIVE_PERIODS(5e-3f)  /* silence that ends an incomplete frame */
#define RESTART_PERIODS DRIVE_PERIODS(20e-3f) /* from the order to the reset: its answer is sent */

#define FRAMES_MAX 4u /* sent by a call */

HAL_PER_CHIP const talk_line_t *talk_line;

/* Number of octets from this one on that are contiguous. */
static uint16_t in_a_row(uint16_t at, uint16_t count)
{
    const uint16_t to_end = (uint16_t)(TALK_RING - at % TALK_RING);
    return count < to_end ? count : to_end;
}

static void receive(talk_ring_t *came)
{
    const uint16_t room = (uint16_t)(TALK_RING - (uint16_t)(came->put - came->got));
    const uint32_t count = hal_serial_read(&came->octets[came->put % TALK_RING], in_a_row(came->put, room));
    came->put = (uint16_t)(came->put + count);
}

/* Twice, because the waiting octets may continue at the beginning of the ring. */
static void send(talk_ring_t *going)
{
    for (uint16_t piece = 0u; piece < 2u && going->put != going->got; piece++) {
        const uint16_t waiting = (uint16_t)(going->put - going->got);
        const uint32_t count =
            hal_serial_write(&going->octets[going->got % TALK_RING], in_a_row(going->got, waiting));
        going->got = (uint16_t)(going->got + count);
    }
}

void talk_exchange(void)
{
    if (talk_line == NULL) {
        receive(&app->talk.came);
        send(&app->talk.going);
    }
}

static uint32_t take(talk_ring_t *came, uint16_t *octets, uint32_t room)
{
    uint32_t count = 0u;
    for (; count < room && came->got != came->put; count++) {
        octets[count] = came->octets[came->got % TALK_RING];
        came->got++;
    }
    return count;
}

static uint32_t give(talk_ring_t *going, const uint16_t *octets, uint32_t count)
{
    uint32_t n = 0u;
    for (; n < count && (uint16_t)(going->put - going->got) < TALK_RING; n++) {
        going->octets[going->put % TALK_RING] = octets[n];
        going->put++;
    }
    return n;
}

static uint32_t line_read(uint16_t *octets, uint32_t room)
{
    return talk_line != NULL ? talk_line->read(octets, room) : take(&app->talk.came, octets, room);
}

static uint32_t line_write(const uint16_t *octets, uint32_t count)
{
    return talk_line != NULL ? talk_line->write(octets, count) : give(&app->talk.going, octets, count);
}

/* 1: octets may be lost or changed on the way, and frames have tails. */
static uint32_t is_serial(void)
{
    return talk_line == NULL ? UINT32_C(1) : UINT32_C(0);
}

/* Reads a value that the interrupt may write at any time. */
static uint32_t now_of(const volatile uint32_t *slot)
{
    return *slot;
}

static uint32_t period(void)
{
    return now_of(&app->drive.fast.period);
}

void talk_start(void)
{
    talk_t *talk = &app->talk;
    memset(talk, 0, sizeof *talk);
    frame_receiver_init(&talk->receiver, SILENCE_PERIODS);
    frame_sender_init(&talk->sender);
    xcp_init(&talk->xcp, is_serial());
    daq_clear(&talk->daq);
}

void talk_restart(void)
{
    app->talk.restart = 1u;
    app->talk.restart_at = period() + RESTART_PERIODS;
}

/* ---- in ---- */

/* Received octets go into a buffer, so that a master may send one command ahead. */
static void fetch(talk_t *talk)
{
    const uint32_t serial = is_serial();
    talk->receiver.tail = serial;
    talk->sender.tail = serial;
    talk->xcp.serial = serial;
    const uint32_t waiting = talk->octets_count - talk->octets_at;
    if (talk->octets_at != 0u) {
        for (uint32_t n = 0; n < waiting; n++) {
            talk->octets[n] = talk->octets[talk->octets_at + n];
        }
        talk->octets_at = 0u;
        talk->octets_count = waiting;
    }
    if (waiting < TALK_OCTETS) {
        talk->octets_count += line_read(&talk->octets[waiting], TALK_OCTETS - waiting);
    }
    const uint32_t errors = serial == 0u ? 0u : hal_serial_errors();
    if (errors != talk->line_errors) {
        talk->line_errors = errors;
        talk->octets_count = 0u;
        frame_broken(&talk->receiver, period());
    }
}

/* Processes octets up to the end of a frame: its command is executed, and its answer waits. Octets after it
 * wait for a later call: a command is executed when the answer before it is being sent. */
static void listen(talk_t *talk)
{
    const uint32_t now = period();
    fetch(talk);
    if (talk->answer_count != 0u) {
        frame_wait(&talk->receiver, now);
        return;
    }
    frame_listen(&talk->receiver, now);
    while (talk->octets_at < talk->octets_count) {
        if (frame_take(&talk->receiver, talk->octets[talk->octets_at++], now)) {
            talk->answer_count = xcp_command(&talk->xcp, &talk->daq, &talk_access,
                                             frame_packet(&talk->receiver), talk->answer);
            /* a client that may only read has not switched anything on */
            talk->heard_at = talk->xcp.locked == 0u ? now : talk->heard_at;
            return;
        }
    }
}

/* ---- out ---- */

/* The next packet: an answer is sent before samples. */
static uint32_t packet(talk_t *talk, uint16_t *octets)
{
    const uint32_t count = talk->answer_count;
    if (count != 0u) {
        for (uint32_t n = 0; n < count; n++) {
            octets[n] = talk->answer[n];
        }
        talk->answer_count = 0u;
        return count;
    }
    return daq_overloaded(&talk->daq, now_of(&talk->daq.lost))
               ? xcp_overload(octets)
               : daq_next(&talk->daq, now_of(&talk->daq.put), octets);
}

static void speak(talk_t *talk)
{
    frame_sender_t *sender = &talk->sender;
    for (uint32_t n = 0; n <= FRAMES_MAX; n++) {
        if (!frame_is_free(sender)) {
            sender->sent += line_write(&sender->octets[sender->sent], sender->count - sender->sent);
        }
        if (!frame_is_free(sender) || n == FRAMES_MAX) {
            return;
        }
        const uint32_t count = packet(talk, frame_open(sender));
        if (count == 0u) {
            return;
        }
        frame_close(sender, count);
    }
}

/* ---- the master ---- */

static void watch_master(talk_t *talk)
{
    const requests_t *requests = &app->drive.requests;
    const float timeout = app->active.command_timeout;
    if (requests->enable != (int32_t)REQUEST_QUICK_STOP) {
        talk->silent = 0u;
    }
    if (requests->enable != (int32_t)REQUEST_ON) {
        talk->steered = 0u;
    }
    if (talk->steered == 0u || timeout == 0.0f || period() - talk->heard_at <= DRIVE_PERIODS(timeout)) {
        return;
    }
    requests_t next = *requests;
    params_error_t why;
    next.enable = (int32_t)REQUEST_QUICK_STOP;
    if (app_request(&next, &why)) {
        talk->silent = 1u;
        talk->steered = 0u;
    }
}

void talk_step(void)
{
    talk_t *talk = &app->talk;
    services_t *services = &app->services;
    listen(talk);
    speak(talk);
    watch_master(talk);
    services->line_frames = talk->receiver.frames;
    services->line_errors = talk->receiver.errors;
    services->daq_lost = talk->daq.lost;
    if (talk->restart != 0u && period() - talk->restart_at < RESTART_PERIODS) {
        talk->restart = 0u;
        hal_restart();
    }
}
