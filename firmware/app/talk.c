#include "app/talk.h"

#include <string.h>

#include "app/app.h"
#include "app/talk_modbus.h"
#include "app/talk_values.h"

#define SILENCE_PERIODS DRIVE_PERIODS(5e-3f) /* duration of the silence that ends an incomplete frame */
/* Time from the order to the reset, in which its answer is sent. */
#define RESTART_PERIODS DRIVE_PERIODS(20e-3f)

/* On a line of two wires the drive receives the octets that it sends. After this time such an octet has
 * arrived and has been read. */
#define ECHO_PERIODS 5u

#define FRAMES_MAX 4u /* sent by a call */

HAL_PER_CHIP const talk_line_t *talk_line;

/* Places and counts in a ring of this size. */
static uint32_t waiting(uint16_t put, uint16_t got, uint32_t size)
{
    return put >= got ? (uint32_t)put - got : (uint32_t)put + size - got;
}

/* The place in the ring that is this number of octets after `place`, at most one round further. */
static uint16_t place_behind(uint16_t place, uint32_t count, uint32_t size)
{
    const uint32_t next = place + count;
    return (uint16_t)(next < size ? next : next - size);
}

/* Number of octets from this place on that are contiguous. */
static uint32_t in_a_row(uint16_t place, uint32_t count, uint32_t size)
{
    const uint32_t to_end = size - place;
    return count < to_end ? count : to_end;
}

#define OUT_SIZE (TALK_AHEAD + 1u)

static uint32_t waiting_in(const talk_in_t *came)
{
    return waiting(came->put, came->got, TALK_RING);
}

static uint32_t waiting_out(const talk_out_t *going)
{
    return waiting(going->put, going->got, OUT_SIZE);
}

static uint32_t room_of(const talk_in_t *came)
{
    return in_a_row(came->put, TALK_RING - 1u - waiting_in(came), TALK_RING);
}

/* Reads twice, because the free space may continue at the beginning of the ring. Octets without space are
 * dropped, because octets that stay in the chip would request the interrupt again. */
static void receive(talk_in_t *came)
{
    for (uint16_t piece = 0u; piece < 2u; piece++) {
        const uint32_t count = hal_serial_read(&came->octets[came->put], room_of(came));
        came->put = place_behind(came->put, count, TALK_RING);
    }
    if (room_of(came) == 0u) {
        hal_serial_drop();
    }
}

static void send(talk_out_t *going)
{
    for (uint16_t piece = 0u; piece < 2u && going->put != going->got; piece++) {
        const uint32_t count = in_a_row(going->got, waiting_out(going), OUT_SIZE);
        going->got = place_behind(going->got, hal_serial_write(&going->octets[going->got], count), OUT_SIZE);
    }
}

/* 1: octets may be lost or changed on the way, and frames have tails. */
static uint32_t is_serial(void)
{
    return talk_line == NULL ? UINT32_C(1) : UINT32_C(0);
}

void talk_exchange(void)
{
    if (talk_line == NULL) {
        receive(&app->talk.came);
        send(&app->talk.going);
    }
}

void talk_receive(void)
{
    if (talk_line == NULL) {
        receive(&app->talk.came);
    }
}

/* A line that does not use the chip has no interrupt. */
static void receive_beside(talk_in_t *came)
{
    for (uint16_t piece = 0u; piece < 2u && talk_line != NULL; piece++) {
        const uint32_t room = room_of(came);
        came->put = place_behind(came->put, room > 0u ? talk_line->read(&came->octets[came->put], room) : 0u,
                                 TALK_RING);
    }
}

static uint32_t give(talk_out_t *going, const uint16_t *octets, uint32_t count)
{
    uint32_t n = 0u;
    for (; n < count && waiting_out(going) < TALK_AHEAD; n++) {
        going->octets[going->put] = octets[n];
        going->put = place_behind(going->put, 1u, OUT_SIZE);
    }
    return n;
}

static uint32_t line_write(const uint16_t *octets, uint32_t count)
{
    return talk_line != NULL ? talk_line->write(octets, count) : give(&app->talk.going, octets, count);
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
    talk->setting.baud = BOARD_SERIAL_BAUD;
}

void talk_restart(void)
{
    app->talk.restart = 1u;
    app->talk.restart_at = period() + RESTART_PERIODS;
}

/* ---- received octets ---- */

/* Selects the line, and finds whether octets of it were lost; the octets that have arrived are then dropped
 * as well. */
static void look_at_line(talk_t *talk)
{
    const uint32_t serial = is_serial();
    const uint32_t errors = serial == 0u ? 0u : hal_serial_errors();
    talk->receiver.tail = serial;
    talk->sender.tail = serial;
    talk->xcp.serial = serial;
    receive_beside(&talk->came);
    if (errors != talk->line_errors) {
        talk->line_errors = errors;
        talk->came.got = talk->came.put;
        frame_broken(&talk->receiver, period());
        modbus_broken(&talk->modbus, period());
    }
}

static bool is_modbus(const talk_t *talk)
{
    return talk_line == NULL && talk->setting.protocol == (int32_t)LINE_MODBUS;
}

/* On a line of two wires the octets that arrive while the drive sends are its own, and are dropped. A silence
 * ends a frame. Octets are processed before the time of the silence is judged, so that a late background can
 * only make the silence longer. */
static void listen_modbus(talk_t *talk)
{
    const uint32_t now = period();
    const float timeout = app->active.command_timeout;
    const bool sends = talk->busy != 0u || now - talk->busy_at <= ECHO_PERIODS;
    talk_in_t *came = &talk->came;
    look_at_line(talk);
    for (uint32_t count = waiting_in(came); count > 0u; count--) {
        const uint16_t octet = came->octets[came->got];
        came->got = place_behind(came->got, 1u, TALK_RING);
        if (!sends) {
            modbus_take(&talk->modbus, talk->receiver.octets, octet, now);
        }
    }
    if (!frame_is_free(&talk->sender)) {
        return;
    }
    if (timeout > 0.0f && now - talk->heard_at > DRIVE_PERIODS(timeout)) {
        talk->modbus_key = 0u;
    }
    talk->xcp.locked = talk_modbus_locked() ? UINT32_C(1) : UINT32_C(0);
    const modbus_result_t result =
        modbus_listen(&talk->modbus, talk->receiver.octets, &talk_modbus_access, now, talk->sender.octets);
    talk->sender.count = result.count;
    talk->sender.sent = 0u;
    if (result.heard && !talk_modbus_locked()) {
        talk->heard_at = now;
    }
}

/* Processes octets up to the end of a frame, executes its command, and keeps the answer. Later octets wait
 * for another call, because a command is executed only when the previous answer is being sent. */
static void listen(talk_t *talk)
{
    const uint32_t now = period();
    talk_in_t *came = &talk->came;
    if (is_modbus(talk)) {
        listen_modbus(talk);
        return;
    }
    look_at_line(talk);
    if (talk->answer_count != 0u) {
        frame_wait(&talk->receiver, now);
        return;
    }
    frame_listen(&talk->receiver, now);
    while (waiting_in(came) != 0u) {
        const uint16_t octet = came->octets[came->got];
        came->got = place_behind(came->got, 1u, TALK_RING);
        if (frame_take(&talk->receiver, octet, now)) {
            talk->answer_count = xcp_command(&talk->xcp, &talk->daq, &talk_access,
                                             frame_packet(&talk->receiver), talk->answer);
            /* a client that may only read has not switched anything on */
            talk->heard_at = talk->xcp.locked == 0u ? now : talk->heard_at;
            return;
        }
    }
}

/* ---- octets to be sent ---- */

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
        const uint32_t count = is_modbus(talk) ? 0u : packet(talk, frame_open(sender));
        if (count == 0u) {
            return;
        }
        frame_close(sender, count);
    }
}

/* ---- the protocol ---- */

static talk_setting_t wanted(void)
{
    const params_t *active = &app->active;
    const bool modbus = talk_line == NULL && active->line_protocol == (int32_t)LINE_MODBUS;
    return modbus ? (talk_setting_t){active->line_protocol, active->modbus_address, active->modbus_baud}
                  : (talk_setting_t){(int32_t)LINE_XCP, 0, BOARD_SERIAL_BAUD};
}

static void use(talk_t *talk, talk_setting_t setting)
{
    const float baud = (float)setting.baud;
    talk->setting = setting;
    talk->came.got = talk->came.put;
    xcp_init(&talk->xcp, is_serial());
    daq_clear(&talk->daq);
    frame_restart(&talk->receiver);
    frame_sender_init(&talk->sender);
    modbus_set(&talk->modbus, (uint32_t)setting.address, 1u + DRIVE_PERIODS(modbus_gap(baud)));
    talk->modbus_key = 0u;
    talk->busy = 0u;
    if (talk_line == NULL) {
        hal_serial_baud((uint32_t)setting.baud);
    }
}

/* Something waits to be sent, or is being sent. */
static bool is_busy(const talk_t *talk)
{
    return talk->answer_count != 0u || !frame_is_free(&talk->sender) || waiting_out(&talk->going) != 0u ||
           (talk_line == NULL && hal_serial_sends());
}

/* The answer to the order that changes the protocol is still sent in the old one. */
static void follow_setting(talk_t *talk)
{
    const talk_setting_t next = wanted();
    const talk_setting_t *present = &talk->setting;
    const uint32_t now = period();
    const bool same =
        next.protocol == present->protocol && next.address == present->address && next.baud == present->baud;
    if (same && !is_modbus(talk)) {
        return;
    }
    const bool was_busy = talk->busy != 0u;
    talk->busy = is_busy(talk) ? UINT32_C(1) : UINT32_C(0);
    if (talk->busy != 0u || was_busy) { /* the transmission may have ended since the last check */
        talk->busy_at = now;
    } else if (!same && now - talk->busy_at > RESTART_PERIODS) {
        use(talk, next);
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
    follow_setting(talk);
    watch_master(talk);
    services->line_frames = talk->receiver.frames + talk->modbus.frames;
    services->line_errors = talk->receiver.errors + talk->modbus.errors;
    services->daq_lost = talk->daq.lost;
    if (talk->restart != 0u && period() - talk->restart_at < RESTART_PERIODS) {
        talk->restart = 0u;
        hal_restart();
    }
}
